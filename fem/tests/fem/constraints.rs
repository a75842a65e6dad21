//! Links, couplings and supports in whole structures.

use crate::bodies::{cholesky, dense, largest, modes, prescribed, solid_model, steel};
use hati_fem::{
    assembly::{Assembly, add_force},
    constraint::{Component, Freedom},
    element::{Axis, Bar, Beam, Dashpot, MassForm, PointMass, Spring},
    material::Material,
    mesh::SolidKind,
    model::Model,
    section::Section,
    statics,
};

const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// A solid block from x = 0 to 2 whose end carries a beam of 3 m.
fn block_with_beam(
    material: Material,
    join: impl Fn(&mut Model, usize, &[usize]),
) -> (Model, Vec<usize>, usize) {
    let side = 0.4;
    let (mut model, mesh) = solid_model(SolidKind::Hex20, [4, 2, 2], material, |x| {
        [2.0 * x[0], side * (x[1] - 0.5), side * (x[2] - 0.5)]
    });
    let face = |x: f64| -> Vec<usize> {
        (0..mesh.nodes.len()).filter(|&n| (mesh.nodes[n][0] - x).abs() < 1e-12).collect()
    };
    let (root, end) = (face(0.0), face(2.0));
    let joint = model.add_node([2.0, 0.0, 0.0]);
    let tip = model.add_node([5.0, 0.0, 0.0]);
    let group = model.group("beam");
    let section = Section::rectangle(side, side, material.poisson()).unwrap();
    let at = [[2.0, 0.0, 0.0], [5.0, 0.0, 0.0]];
    model.add(group, Beam::new([joint, tip], at, UP, section, material).unwrap());
    join(&mut model, joint, &end);
    (model, root, tip)
}

#[test]
fn a_solid_joined_to_a_beam_bends_as_one_cantilever() {
    type Join = fn(&mut Model, usize, &[usize]);
    // a rigid face is what beam theory has; a spread force dents the face a little
    let joins: [(&str, Join, std::ops::Range<f64>); 2] = [
        ("rigid", |model, joint, end| model.rigid_link("joint", joint, end), 0.9975..1.0),
        (
            "distributing",
            |model, joint, end| model.distribute("joint", joint, end, &vec![1.0; end.len()]),
            1.0..1.015,
        ),
    ];
    // without Poisson's effect no joint and no root holds the section back from its own shape
    let material = Material::new(200e9, 0.0, 8000.0).unwrap();
    for (name, join, range) in joins {
        let (mut model, root, tip) = block_with_beam(material, join);
        root.iter().for_each(|&node| model.fix("root", node));
        let assembly = Assembly::new(&model).unwrap();
        let mut load = vec![0.0; assembly.numbering().size()];
        add_force(assembly.numbering(), &mut load, tip, Component::Z, 1e4).unwrap();
        let s = vec![0.0; assembly.reduction().supports().len()];
        let state = statics::solve(&assembly, &assembly.stiffness().unwrap(), &load, &s, cholesky).unwrap();
        let section = Section::rectangle(0.4, 0.4, 0.0).unwrap();
        let beam = 1e4 * 125.0 / (3.0 * 200e9 * section.iy)
            + 1e4 * 5.0 / (material.shear_modulus() * section.shear_area_z.unwrap());
        let ratio = state.displacement[assembly.numbering().start(tip) + 2] / beam;
        println!("{name} joint: tip at {ratio} of one beam");
        assert!(range.contains(&ratio), "{name}: {ratio}");
        let up: f64 = state.reactions.iter().filter(|r| r.0.component == Component::Z).map(|r| r.1).sum();
        assert!((up + 1e4).abs() < 1e-6);
    }
}

#[test]
fn joined_parts_keep_their_six_rigid_motions_free_of_force() {
    for rigid in [true, false] {
        let (model, _, _) = block_with_beam(steel(), |model, joint, end| match rigid {
            true => model.rigid_link("joint", joint, end),
            false => model.distribute("joint", joint, end, &vec![1.0; end.len()]),
        });
        let assembly = Assembly::new(&model).unwrap();
        let mut values: Vec<f64> =
            dense(&assembly.stiffness().unwrap().free).symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        let top = values[values.len() - 1];
        assert!(largest(values[..6].iter().copied()) < 1e-13 * top, "{:?}", &values[..7]);
        assert!(values[6] > 1e-9 * top, "{:?}", &values[..7]);
    }
}

#[test]
fn a_base_translation_moves_a_structure_without_force() {
    let (mut model, root, _) =
        block_with_beam(steel(), |model, joint, end| model.rigid_link("joint", joint, end));
    root.iter().for_each(|&node| model.fix("root", node));
    let assembly = Assembly::new(&model).unwrap();
    let stiffness = assembly.stiffness().unwrap();
    let s = prescribed(&assembly, |_| [0.3, -0.2, 0.5]);
    let load = vec![0.0; assembly.numbering().size()];
    let state = statics::solve(&assembly, &stiffness, &load, &s, cholesky).unwrap();
    let influence = assembly.influence();
    for (k, q) in state.free.iter().enumerate() {
        let exact = 0.3 * influence[0][k] - 0.2 * influence[1][k] + 0.5 * influence[2][k];
        assert!((q - exact).abs() < 1e-9, "{q} {exact}");
    }
    assert!(largest(state.reactions.iter().map(|r| r.1)) < 1e-9 * 200e9 * 0.4);
}

#[test]
fn the_base_load_is_the_mass_that_the_base_moves() {
    let (mut model, root, _) =
        block_with_beam(steel(), |model, joint, end| model.rigid_link("joint", joint, end));
    root.iter().for_each(|&node| model.fix("root", node));
    let assembly = Assembly::new(&model).unwrap();
    let properties = assembly.mass_properties().unwrap();
    assert!((properties.mass / (8000.0 * 0.16 * 5.0) - 1.0).abs() < 1e-12, "{}", properties.mass);
    assert!((properties.centre[0] - 2.5).abs() < 1e-10 && properties.centre[2].abs() < 1e-12);
    // a slender body of 5 m: m (L² + h²)/12 about y
    let exact = properties.mass * (25.0 + 0.16) / 12.0;
    assert!((properties.inertia[1][1] / exact - 1.0).abs() < 1e-10, "{}", properties.inertia[1][1]);
    // full mass: on the free part and on the held one
    let mass = assembly.mass(MassForm::Consistent).unwrap();
    let loads = assembly.base_load(&mass).unwrap();
    let full = assembly.unit_translation(2);
    let weight = assembly.gravity_load([0.0, 0.0, 1.0]);
    assert!(
        (weight.iter().zip(&full).map(|(a, b)| a * b).sum::<f64>() / properties.mass - 1.0).abs() < 1e-12
    );
    let (reduced, _) = assembly.reduction().reduce(&weight).unwrap();
    assert!(largest(reduced.iter().zip(&loads[2]).map(|(a, b)| a + b)) < 1e-10 * properties.mass);
}

#[test]
fn a_ratio_between_freedoms_loses_mass_and_says_so() {
    let mut model = Model::new();
    model.add_nodes(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let group = model.group("bar");
    model.add(group, Bar::new([0, 1], [[0.0; 3], [1.0, 0.0, 0.0]], 0.01, steel()).unwrap());
    let (x0, x1) = (Freedom::new(0, Component::X), Freedom::new(1, Component::X));
    model.relation("gear", x1, &[(x0, 0.5)], 0.0);
    let error = Assembly::new(&model).unwrap().mass_properties().unwrap_err();
    assert!(matches!(error, hati_fem::FemError::Mass { axis: 'x', .. }), "{error}");
}

#[test]
fn a_constant_in_a_constraint_is_a_gap_that_is_closed() {
    // two springs in a row, the second node pulled 1 mm beyond its twin
    let mut model = Model::new();
    model.add_nodes(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let group = model.group("springs");
    let x = [Axis::translation([1.0, 0.0, 0.0], 1e6)];
    model.add(group, Spring::to_ground(0, &x).unwrap());
    model.add(group, Spring::between([1, 2], [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &x).unwrap());
    model.support("wall", 2, &Component::TRANSLATIONS);
    for node in 0..2 {
        model.support("guide", node, &[Component::Y, Component::Z]);
    }
    let [x0, x1] = [0, 1].map(|n| Freedom::new(n, Component::X));
    model.relation("shim", x1, &[(x0, 1.0)], 1e-3);
    let assembly = Assembly::new(&model).unwrap();
    let s = vec![0.0; assembly.reduction().supports().len()];
    let state = statics::solve(&assembly, &assembly.stiffness().unwrap(), &[0.0; 9], &s, cholesky).unwrap();
    assert!((state.displacement[0] + 5e-4).abs() < 1e-15);
    assert!((state.displacement[3] - 5e-4).abs() < 1e-15);
    let wall = state.reactions.iter().find(|r| r.0 == Freedom::new(2, Component::X)).unwrap().1;
    assert!((wall + 500.0).abs() < 1e-9, "{wall}");
}

#[test]
fn a_tied_pin_lets_rotations_differ() {
    // two beams end to end, their ends tied in translation: a hinge, as a release makes it
    let (steel, section) = (steel(), Section::rectangle(0.2, 0.3, 0.3).unwrap());
    let at = [[0.0; 3], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
    let mut model = Model::new();
    model.add_nodes(&[at[0], at[1], at[1], at[2]]);
    let group = model.group("beams");
    model.add(group, Beam::new([0, 1], [at[0], at[1]], UP, section, steel).unwrap());
    model.add(group, Beam::new([2, 3], [at[1], at[2]], UP, section, steel).unwrap());
    let pin = [Component::X, Component::Y, Component::Z, Component::RotationX];
    model.tie("pin", 2, 1, &pin);
    for node in [0, 3] {
        model.fix("end", node);
    }
    let assembly = Assembly::new(&model).unwrap();
    let mut load = vec![0.0; 24];
    load[8] = -1.0;
    let state =
        statics::solve(&assembly, &assembly.stiffness().unwrap(), &load, &[0.0; 12], cholesky).unwrap();
    let one = 8.0 / (3.0 * steel.young() * section.iy)
        + 2.0 / (steel.shear_modulus() * section.shear_area_z.unwrap());
    assert!((state.displacement[8] / (-0.5 * one) - 1.0).abs() < 1e-10);
    assert!((state.displacement[14] / (-0.5 * one) - 1.0).abs() < 1e-10);
    assert!((state.displacement[10] + state.displacement[16]).abs() < 1e-10 * state.displacement[10].abs());
}

#[test]
fn springs_dashpots_and_masses_make_an_oscillator() {
    let mut model = Model::new();
    let node = model.add_node([0.0; 3]);
    let group = model.group("oscillator");
    let up = [0.0, 0.0, 2.0];
    model
        .add(group, Spring::to_ground(node, &[Axis::translation(up, 4e6), Axis::rotation(up, 9e4)]).unwrap());
    model.add(group, Dashpot::to_ground(node, &[Axis::translation(up, 300.0)]).unwrap());
    model.add(
        group,
        PointMass::new(node, 100.0).unwrap().with_inertia([2.0, 2.0, 3.0, 0.0, 0.0, 0.0]).unwrap(),
    );
    model.support("guide", node, &[Component::X, Component::Y, Component::RotationX, Component::RotationY]);
    let assembly = Assembly::new(&model).unwrap();
    let mass = assembly.mass(MassForm::Lumped).unwrap().free;
    let found = modes(&assembly.stiffness().unwrap().free, &mass).0;
    let exact = [(9e4f64 / 3.0).sqrt(), (4e6f64 / 100.0).sqrt()].map(|w| w / std::f64::consts::TAU);
    assert!((found[0] / exact[0] - 1.0).abs() < 1e-12 && (found[1] / exact[1] - 1.0).abs() < 1e-12);
    assert_eq!(dense(&assembly.damping().unwrap().free)[(0, 0)], 300.0);
    let rayleigh = assembly.rayleigh_damping(MassForm::Lumped, |_| (0.5, 1e-3)).unwrap();
    assert!((dense(&rayleigh.free)[(0, 0)] - (0.5 * 100.0 + 1e-3 * 4e6)).abs() < 1e-9);
    assert_eq!(assembly.reduction().node_groups(), [0, 0]);
}
