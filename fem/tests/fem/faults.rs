//! Faulty structures: each gets a message that names what is wrong and where.

use crate::bodies::{solid_model, steel};
use hati_fem::{
    FemError,
    assembly::Assembly,
    check::{check, components},
    constraint::Component,
    element::{Axis, Bar, Beam, EndReleases, Hex8, PointMass, Spring, Tet10},
    mechanism::{free_motions, refuse_mechanism},
    mesh::SolidKind,
    model::Model,
    section::Section,
};

const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn square() -> Section {
    Section::rectangle(0.2, 0.2, 0.3).unwrap()
}

/// Beams in a row along x through `count` nodes 1 m apart.
fn row(count: usize) -> Model {
    let mut model = Model::new();
    let group = model.group("row");
    for i in 0..count {
        model.add_node([i as f64, 0.0, 0.0]);
    }
    for i in 1..count {
        let at = [model.nodes()[i - 1], model.nodes()[i]];
        model.add(group, Beam::new([i - 1, i], at, UP, square(), steel()).unwrap());
    }
    model
}

fn motions(model: &Model) -> Vec<String> {
    let assembly = Assembly::new(model).unwrap();
    let found = free_motions(&assembly, &assembly.stiffness().unwrap().free).unwrap();
    found.iter().map(ToString::to_string).collect()
}

#[test]
fn a_structure_that_is_held_has_no_free_motion() {
    let mut model = row(40);
    model.fix("root", 0);
    assert_eq!(motions(&model), Vec::<String>::new());
    let assembly = Assembly::new(&model).unwrap();
    assert!(refuse_mechanism(&assembly, &assembly.stiffness().unwrap().free).is_ok());
}

#[test]
fn a_free_body_has_six_rigid_motions() {
    for model in [row(5), solid_model(SolidKind::Hex8, [3, 1, 1], steel(), |x| x).0] {
        let found = motions(&model);
        let starts = ["x", "y", "z"].map(|axis| format!("free translation along {axis} of node(s) 0, 1, 2"));
        let turns = ["x", "y", "z"].map(|axis| format!("free rotation about {axis} through ("));
        assert_eq!(found.len(), 6, "{found:?}");
        for (motion, start) in found.iter().zip(starts.iter().chain(&turns)) {
            assert!(motion.starts_with(start), "{motion}, expected {start}");
        }
    }
}

#[test]
fn a_part_that_is_not_held_is_named_beside_one_that_is() {
    let mut model = row(3);
    model.fix("root", 0);
    let group = model.group("trolley");
    let a = model.add_node([0.0, 5.0, 1.0]);
    let b = model.add_node([1.0, 5.0, 1.0]);
    let at = [model.nodes()[a], model.nodes()[b]];
    model.add(group, Beam::new([a, b], at, UP, square(), steel()).unwrap());
    model.support("rail", a, &[Component::Y, Component::Z, Component::RotationX]);
    model.support("rail", b, &[Component::Y, Component::Z]);
    assert_eq!(motions(&model), ["free translation along x of node(s) 3, 4"]);
}

#[test]
fn a_body_on_a_skew_axis_turns_about_it() {
    let (mut model, mesh) = solid_model(SolidKind::Hex8, [1, 1, 1], steel(), |x| x);
    // held at the two ends of a diagonal of the lower face
    for (node, x) in mesh.nodes.iter().enumerate() {
        if *x == [0.0, 0.0, 0.0] || *x == [1.0, 1.0, 0.0] {
            model.fix("pin", node);
        }
    }
    let found = motions(&model);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].starts_with("free rotation about (0.7071, 0.7071, 0) through (0.5, 0.5, 0) m"),
        "{found:?}"
    );
}

#[test]
fn a_row_that_can_roll_and_slide_is_told_so() {
    let mut model = row(4);
    for node in [0, 3] {
        model.support("rest", node, &[Component::Y, Component::Z]);
    }
    let mut found = motions(&model);
    found.sort();
    assert_eq!(
        found,
        [
            "free rotation about x through (1.5, 0, 0) m of node(s) 0, 1, 2, 3",
            "free translation along x of node(s) 0, 1, 2, 3"
        ]
    );
    let assembly = Assembly::new(&model).unwrap();
    let error = refuse_mechanism(&assembly, &assembly.stiffness().unwrap().free).unwrap_err();
    assert!(matches!(error, FemError::Mechanism { ref motions } if motions.len() == 2), "{error}");
}

#[test]
fn a_hinge_too_many_is_found_at_its_node() {
    // both beams let go of node 1: it spins by itself about y and z
    let mut model = Model::new();
    let group = model.group("row");
    for i in 0..3 {
        model.add_node([f64::from(i), 0.0, 0.0]);
    }
    for (nodes, releases) in
        [([0, 1], EndReleases::hinges(false, true)), ([1, 2], EndReleases::hinges(true, false))]
    {
        let at = nodes.map(|n| model.nodes()[n]);
        let beam = Beam::new(nodes, at, UP, square(), steel()).unwrap().with_releases(releases).unwrap();
        model.add(group, beam);
    }
    for node in [0, 2] {
        model.fix("end", node);
    }
    let mut found = motions(&model);
    found.sort();
    assert_eq!(
        found,
        [
            "free rotation about y through (1, 0, 0) m of node(s) 1",
            "free rotation about z through (1, 0, 0) m of node(s) 1"
        ]
    );
}

#[test]
fn bars_in_a_line_sag_at_the_joint() {
    let mut model = Model::new();
    model.add_nodes(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let group = model.group("bars");
    for pair in [[0, 1], [1, 2]] {
        let at = pair.map(|n| model.nodes()[n]);
        model.add(group, Bar::new(pair, at, 0.01, steel()).unwrap());
    }
    for node in [0, 2] {
        model.fix("end", node);
    }
    let mut found = motions(&model);
    found.sort();
    assert_eq!(found, ["free translation along y of node(s) 1", "free translation along z of node(s) 1"]);
}

#[test]
fn duplicate_and_loose_nodes_are_named_unless_something_joins_them() {
    let mut model = row(3);
    let twin = model.add_node([1.0, 0.0, 1e-12]);
    let errors = check(&model, 1);
    assert!(matches!(errors[0], FemError::DuplicateNodes { first: 1, second: 3, .. }), "{errors:?}");
    assert!(matches!(&errors[1], FemError::LooseNodes { nodes } if nodes == &[3]), "{errors:?}");
    let at = [model.nodes()[1], model.nodes()[twin]];
    let group = model.group("spring");
    model.add(group, Spring::between([1, twin], at, &[Axis::translation(UP, 1e6)]).unwrap());
    assert_eq!(check(&model, 1), []);
}

#[test]
fn unconnected_parts_are_listed_by_group() {
    let mut model = row(3);
    let group = model.group("trolley");
    let a = model.add_node([0.0, 5.0, 0.0]);
    let b = model.add_node([1.0, 5.0, 0.0]);
    let at = [model.nodes()[a], model.nodes()[b]];
    model.add(group, Beam::new([a, b], at, UP, square(), steel()).unwrap());
    let errors = check(&model, 1);
    let expected = "the model falls into 2 unconnected parts, 1 expected: `row` (3 nodes, first 0); `trolley` (2 nodes, first 3)";
    assert_eq!(errors.iter().map(ToString::to_string).collect::<Vec<_>>(), [expected]);
    assert_eq!(check(&model, 2), []);
    assert_eq!(components(&model).len(), 2);
    model.rigid_link("hook", 0, &[a]);
    assert_eq!(check(&model, 1), []);
}

#[test]
fn lines_without_length_or_direction_are_refused() {
    let at = [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]];
    let error = Beam::new([4, 5], at, UP, square(), steel()).unwrap_err();
    assert_eq!(error, FemError::ZeroLength { element: "beam", nodes: [4, 5], length: 0.0 });
    assert!(matches!(Bar::new([4, 5], at, 0.1, steel()), Err(FemError::ZeroLength { element: "bar", .. })));
    let upright = [[0.0; 3], [0.0, 0.0, 2.0]];
    assert!(matches!(Beam::new([0, 1], upright, UP, square(), steel()), Err(FemError::Orientation { .. })));
    let nothing = Section { area: 0.0, ..square() };
    assert!(matches!(
        Beam::new([0, 1], [[0.0; 3], [1.0, 0.0, 0.0]], UP, nothing, steel()),
        Err(FemError::Section { key: "area", .. })
    ));
}

#[test]
fn solids_inside_out_and_folded_are_told_apart() {
    let mesh = hati_fem::mesh::block(SolidKind::Hex8, [1, 1, 1], |x| x);
    let nodes = &mesh.elements[0];
    let at: Vec<[f64; 3]> = nodes.iter().map(|&n| mesh.nodes[n]).collect();
    let mirrored: Vec<[f64; 3]> = at.iter().map(|x| [x[1], x[0], x[2]]).collect();
    assert!(matches!(Hex8::new(nodes, &mirrored, steel()), Err(FemError::InsideOut { .. })));
    let mut folded = at.clone();
    folded[6] = [0.1, 0.1, 0.4];
    assert!(matches!(Hex8::new(nodes, &folded, steel()), Err(FemError::Jacobian { .. })));
    let flat: Vec<[f64; 3]> = at.iter().map(|x| [x[0], x[1], 0.0]).collect();
    assert!(matches!(Hex8::new(nodes, &flat, steel()), Err(FemError::Jacobian { .. })));
    let error = Tet10::new(nodes, &at, steel()).unwrap_err();
    assert_eq!(error, FemError::NodeCount { element: "tet10", found: 8, expected: 10 });
}

#[test]
fn springs_across_their_span_and_impossible_inertias_are_refused() {
    let at = [[0.0; 3], [1.0, 0.0, 0.0]];
    let error = Spring::between([0, 1], at, &[Axis::translation(UP, 1e6)]).unwrap_err();
    assert_eq!(error, FemError::SpringSpan { element: "spring", nodes: [0, 1], distance: 1.0 });
    assert!(Spring::between([0, 1], at, &[Axis::translation([3.0, 0.0, 0.0], 1e6)]).is_ok());
    assert!(Spring::to_ground(0, &[Axis::translation([0.0; 3], 1e6)]).is_err());
    let mass = PointMass::new(0, 1.0).unwrap();
    assert!(matches!(
        mass.clone().with_inertia([1.0, 1.0, 3.0, 0.0, 0.0, 0.0]),
        Err(FemError::Inertia { .. })
    ));
    assert!(mass.with_inertia([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]).is_ok());
    assert!(PointMass::new(0, -1.0).is_err());
}

#[test]
fn a_node_that_is_not_there_is_named_with_who_names_it() {
    let mut model = row(2);
    model.rigid_link("arm", 0, &[9]);
    let error = Assembly::new(&model).unwrap_err();
    assert_eq!(error, FemError::UnknownNode { item: "constraint `arm`".into(), node: 9, count: 2 });
}

#[test]
fn a_coupling_of_nodes_in_a_line_spans_no_rotation() {
    let mut model = row(3);
    let reference = model.add_node([1.0, 1.0, 0.0]);
    model.distribute("grip", reference, &[0, 1, 2], &[1.0; 3]);
    let error = Assembly::new(&model).unwrap_err();
    assert!(matches!(error, FemError::Coupling { ref name, .. } if name == "grip"), "{error}");
}
