//! Frames, releases, offsets and section forces against closed forms.

use crate::bodies::{cholesky, largest, steel};
use hati_fem::{
    FemError,
    assembly::{Assembly, add_force},
    constraint::{Component, Freedom},
    element::{Beam, Element, EndReleases, MassForm, PointMass, Recovery, SectionForces},
    mesh::Member,
    model::Model,
    section::Section,
    statics::{self, StaticState},
};
use nalgebra::DMatrix;

const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn girder() -> Section {
    Section::hollow_box(0.6, 1.3, 0.014, 0.008, 0.3).unwrap()
}

fn slender() -> Section {
    Section { shear_area_y: None, shear_area_z: None, ..girder() }
}

fn beam(nodes: [usize; 2], at: [[f64; 3]; 2], section: Section) -> Beam {
    Beam::new(nodes, at, UP, section, steel()).unwrap()
}

fn solve(assembly: &Assembly<'_>, load: &[f64]) -> StaticState {
    let s = vec![0.0; assembly.reduction().supports().len()];
    statics::solve(assembly, &assembly.stiffness().unwrap(), load, &s, cholesky).unwrap()
}

fn close(found: f64, exact: f64) {
    assert!((found / exact - 1.0).abs() < 1e-9, "found {found}, exact {exact}");
}

#[test]
fn a_bracket_deflects_as_its_strain_energy_says() {
    // column of height h fixed at its foot, arm of length a along x
    let (h, a, section, m) = (6.0, 4.0, girder(), steel());
    let (e, g) = (m.young(), m.shear_modulus());
    let mut model = Model::new();
    let at = [[0.0; 3], [0.0, 0.0, h], [a, 0.0, h]];
    model.add_nodes(&at);
    let group = model.group("bracket");
    // the column's own z points along x: I_y bends it in the x–z plane, as it does the arm
    let column = Beam::new([0, 1], [at[0], at[1]], [1.0, 0.0, 0.0], section, m).unwrap();
    model.add(group, column);
    model.add(group, beam([1, 2], [at[1], at[2]], section));
    model.fix("foot", 0);
    let assembly = Assembly::new(&model).unwrap();
    let unit = |component| {
        let mut load = vec![0.0; 18];
        add_force(assembly.numbering(), &mut load, 2, component, 1.0).unwrap();
        solve(&assembly, &load).displacement
    };
    let [ay, az] = [section.shear_area_y.unwrap(), section.shear_area_z.unwrap()];
    let vertical = a.powi(3) / (3.0 * e * section.iy)
        + a * a * h / (e * section.iy)
        + h / (e * section.area)
        + a / (g * az);
    close(unit(Component::Z)[14], vertical);
    let across = a.powi(3) / (3.0 * e * section.iz)
        + h.powi(3) / (3.0 * e * section.iz)
        + a * a * h / (g * section.torsion)
        + (a + h) / (g * ay);
    close(unit(Component::Y)[13], across);
    let along = h.powi(3) / (3.0 * e * section.iy) + h / (g * az) + a / (e * section.area);
    close(unit(Component::X)[12], along);
}

#[test]
fn a_hinge_in_the_middle_makes_two_cantilevers() {
    let (l, section) = (8.0, girder());
    let mut model = Model::new();
    let at = [[0.0; 3], [l / 2.0, 0.0, 0.0], [l, 0.0, 0.0]];
    model.add_nodes(&at);
    let group = model.group("span");
    let hinged =
        beam([0, 1], [at[0], at[1]], section).with_releases(EndReleases::hinges(false, true)).unwrap();
    model.add(group, hinged);
    model.add(group, beam([1, 2], [at[1], at[2]], section));
    model.fix("left", 0);
    model.fix("right", 2);
    let assembly = Assembly::new(&model).unwrap();
    let mut load = vec![0.0; 18];
    load[8] = -1e4;
    let state = solve(&assembly, &load);
    let half = l / 2.0;
    let one = half.powi(3) / (3.0 * steel().young() * section.iy)
        + half / (steel().shear_modulus() * section.shear_area_z.unwrap());
    close(state.displacement[8], -5e3 * one);
    let Recovery::Sections(forces) = assembly.recover(0, &state.displacement, [0.0; 3]).unwrap() else {
        panic!()
    };
    assert!(forces.last().unwrap().moment_y.abs() < 1e-7);
    // hanging down it is hogging at the root: tension above, where z is positive
    close(forces[0].moment_y, 5e3 * half * forces[0].moment_y.signum());
    close(forces[0].shear_z.abs(), 5e3);
}

#[test]
fn a_propped_cantilever_under_its_weight_has_its_textbook_forces() {
    let (l, section) = (12.0, slender());
    let mut model = Model::new();
    let at = [[0.0; 3], [l, 0.0, 0.0]];
    model.add_nodes(&at);
    let group = model.group("span");
    let propped = beam([0, 1], at, section).with_releases(EndReleases::hinges(false, true)).unwrap();
    let element = model.add(group, propped);
    model.fix("left", 0);
    model.fix("right", 1);
    let assembly = Assembly::new(&model).unwrap();
    let gravity = [0.0, 0.0, -9.81];
    let state = solve(&assembly, &assembly.gravity_load(gravity));
    let q = section.mass_per_length(8000.0) * 9.81;
    let reaction = |node, component| {
        let freedom = Freedom::new(node, component);
        state.reactions.iter().find(|r| r.0 == freedom).unwrap().1
    };
    close(reaction(0, Component::Z), 5.0 / 8.0 * q * l);
    close(reaction(1, Component::Z), 3.0 / 8.0 * q * l);
    close(reaction(0, Component::RotationY).abs(), q * l * l / 8.0);
    assert!(reaction(1, Component::RotationY).abs() < 1e-9 * q * l * l);
    let Recovery::Sections(forces) = assembly.recover(element, &state.displacement, gravity).unwrap() else {
        panic!()
    };
    // hogging at the root, sagging in the span; about y a sagging moment is the other sign
    let moment = |x: f64| q * l * l / 8.0 - 5.0 / 8.0 * q * l * x + q * x * x / 2.0;
    let sign = forces[0].moment_y.signum();
    for SectionForces { position, moment_y, shear_z, .. } in forces {
        assert!((moment_y - sign * moment(position)).abs() < 1e-9 * q * l * l, "at {position}");
        assert!((shear_z.abs() - (5.0 / 8.0 * q * l - q * position).abs()).abs() < 1e-9 * q * l);
    }
}

#[test]
fn section_moments_have_the_sign_of_the_right_hand() {
    // a cantilever along x pushed up (z) at its tip: the part beyond pulls the root part up
    let mut model = Model::new();
    let at = [[0.0; 3], [5.0, 0.0, 0.0]];
    model.add_nodes(&at);
    let group = model.group("span");
    let element = model.add(group, beam([0, 1], at, girder()));
    model.fix("root", 0);
    let assembly = Assembly::new(&model).unwrap();
    let mut load = vec![0.0; 12];
    (load[6], load[7], load[8], load[9]) = (3.0, 7.0, 2.0, 11.0);
    let state = solve(&assembly, &load);
    let Recovery::Sections(forces) = assembly.recover(element, &state.displacement, [0.0; 3]).unwrap() else {
        panic!()
    };
    for f in forces {
        let arm = 5.0 - f.position;
        // moment of the force at the tip about the section: (arm, 0, 0) × F
        let exact = [3.0, 7.0, 2.0, 11.0, -arm * 2.0, arm * 7.0];
        let found = [f.axial, f.shear_y, f.shear_z, f.torsion, f.moment_y, f.moment_z];
        assert!(largest((0..6).map(|i| found[i] - exact[i])) < 1e-8, "{found:?} {exact:?}");
    }
}

#[test]
fn a_line_load_gives_the_nodes_their_exact_motion() {
    // triangular load on a cantilever, greatest at the tip: w = 11 q L⁴ / (120 EI)
    let (l, section) = (7.0, slender());
    let mut model = Model::new();
    let at = [[0.0; 3], [l, 0.0, 0.0]];
    model.add_nodes(&at);
    let group = model.group("span");
    model.add(group, beam([0, 1], at, section));
    model.fix("root", 0);
    let assembly = Assembly::new(&model).unwrap();
    let member = beam([0, 1], at, section);
    let mut load = vec![0.0; 12];
    assembly.scatter(&member, &member.line_load([0.0; 3], [0.0, 0.0, 1e3]), &mut load);
    let state = solve(&assembly, &load);
    close(state.displacement[8], 11.0 * 1e3 * l.powi(4) / (120.0 * steel().young() * section.iy));
    let forces = member.section_forces(&state.displacement, [0.0; 3], [0.0, 0.0, 1e3], 3);
    assert!(forces[2].shear_z.abs() < 1e-6 && forces[2].moment_y.abs() < 1e-6, "{:?}", forces[2]);
    close(forces[0].moment_y, -1e3 * l * l / 3.0);
}

#[test]
fn offsets_are_rigid_links() {
    let offsets = [[0.1, -0.3, 0.5], [-0.2, 0.4, 0.6]];
    let at = [[0.0; 3], [3.0, 1.0, -2.0]];
    let ends = [0, 1].map(|k| [0, 1, 2].map(|i| at[k][i] + offsets[k][i]));
    let offset = beam([0, 1], at, girder()).with_offsets(offsets).unwrap();
    let mut model = Model::new();
    let nodes = model.add_nodes(&[at[0], at[1], ends[0], ends[1]]);
    let group = model.group("beam");
    model.add(group, beam([nodes[2], nodes[3]], ends, girder()));
    model.rigid_link("first", nodes[0], &[nodes[2]]);
    model.rigid_link("second", nodes[1], &[nodes[3]]);
    let assembly = Assembly::new(&model).unwrap();
    for (linked, own) in [
        (assembly.stiffness().unwrap(), offset.stiffness()),
        (assembly.mass(MassForm::Consistent).unwrap(), offset.mass(MassForm::Consistent)),
    ] {
        let linked = crate::bodies::dense(&linked.free);
        assert!((&linked - &own).amax() < 1e-13 * own.amax());
    }
}

#[test]
fn releases_keep_the_mass_of_translations_and_let_go_what_they_say() {
    let at = [[0.0; 3], [3.0, 1.0, -2.0]];
    let releases = EndReleases {
        start: [true, false, false, false, true, false],
        end: [false, false, false, true, true, true],
    };
    let released = beam([0, 1], at, girder()).with_releases(releases).unwrap();
    let unit = DMatrix::from_fn(12, 3, |i, j| if i % 6 == j { 1.0 } else { 0.0 });
    let mass = unit.transpose() * released.mass(MassForm::Consistent) * &unit;
    assert!((mass / released.total_mass() - DMatrix::identity(3, 3)).amax() < 1e-13);
    // three rigid turns and the six motions that the releases let go give no force
    let mut values: Vec<f64> = released.stiffness().symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    // 12 freedoms, 5 released: 7 held, of which 6 are rigid motions
    assert!(largest(values[..11].iter().copied()) < 1e-12 * values[11], "{values:?}");
}

#[test]
fn releases_that_let_the_beam_spin_or_slide_are_refused() {
    let at = [[0.0; 3], [3.0, 0.0, 0.0]];
    let twist = [false, false, false, true, false, false];
    let error =
        beam([4, 5], at, girder()).with_releases(EndReleases { start: twist, end: twist }).unwrap_err();
    assert_eq!(error, FemError::Release { nodes: [4, 5] });
    let one = EndReleases { start: twist, end: [false; 6] };
    assert!(beam([4, 5], at, girder()).with_releases(one).is_ok());
}

#[test]
fn a_member_is_released_at_its_ends_alone() {
    // hinged at both ends and cut into four: a simply supported span under a force in its middle
    let (l, section) = (8.0, girder());
    let mut model = Model::new();
    let ends = [[0.0; 3], [l, 0.0, 0.0]].map(|x| model.add_node(x));
    let group = model.group("span");
    let releases = EndReleases::hinges(true, true);
    let member = Member { section, material: steel(), orientation: UP, releases };
    let nodes = member.add_to(&mut model, group, ends, 4).unwrap();
    assert_eq!(nodes, [0, 2, 3, 4, 1]);
    ends.iter().for_each(|&node| model.fix("end", node));
    let assembly = Assembly::new(&model).unwrap();
    let mut load = vec![0.0; assembly.numbering().size()];
    add_force(assembly.numbering(), &mut load, nodes[2], Component::Z, -1e4).unwrap();
    let state = solve(&assembly, &load);
    let exact = l.powi(3) / (48.0 * steel().young() * section.iy)
        + l / (4.0 * steel().shear_modulus() * section.shear_area_z.unwrap());
    close(state.displacement[assembly.numbering().start(nodes[2]) + 2], -1e4 * exact);
    let error = member.add_to(&mut model, group, [0, 9], 2).unwrap_err();
    assert_eq!(error, FemError::UnknownNode { item: "a member".into(), node: 9, count: 5 });
}

#[test]
fn an_eccentric_mass_is_a_mass_on_a_rigid_arm() {
    let mut model = Model::new();
    let nodes = model.add_nodes(&[[1.0, 2.0, 3.0], [1.5, 1.0, 5.0]]);
    let group = model.group("mass");
    let tensor = [4.0, 5.0, 6.0, 0.5, -0.3, 0.2];
    model.add(group, PointMass::new(nodes[1], 10.0).unwrap().with_inertia(tensor).unwrap());
    model.rigid_link("arm", nodes[0], &[nodes[1]]);
    let assembly = Assembly::new(&model).unwrap();
    let linked = crate::bodies::dense(&assembly.mass(MassForm::Consistent).unwrap().free);
    let eccentric = PointMass::new(0, 10.0)
        .unwrap()
        .with_inertia(tensor)
        .unwrap()
        .with_eccentricity([0.5, -1.0, 2.0])
        .unwrap();
    assert!((linked - eccentric.mass(MassForm::Consistent)).amax() < 1e-12);
    let properties = assembly.mass_properties().unwrap();
    assert!((properties.mass - 10.0).abs() < 1e-13);
    assert!(largest((0..3).map(|i| properties.centre[i] - [1.5, 1.0, 5.0][i])) < 1e-13);
    let exact = [[4.0, 0.5, 0.2], [0.5, 5.0, -0.3], [0.2, -0.3, 6.0]];
    assert!(largest((0..9).map(|k| properties.inertia[k / 3][k % 3] - exact[k / 3][k % 3])) < 1e-12);
}
