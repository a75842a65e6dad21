//! Published free-vibration cases with beams (reference/free_vibration.csv).

use crate::bodies::{modes, steel};
use hati_fem::{
    assembly::Assembly,
    constraint::Component,
    element::{EndReleases, MassForm, PointMass},
    mesh::Member,
    model::Model,
    section::Section,
};

fn member(section: Section) -> Member {
    let (material, releases) = (steel(), EndReleases::default());
    Member { section, material, orientation: [0.0, 0.0, 1.0], releases }
}

fn frequencies(model: &Model) -> Vec<f64> {
    let assembly = Assembly::new(model).unwrap();
    let mass = assembly.mass(MassForm::Consistent).unwrap().free;
    modes(&assembly.stiffness().unwrap().free, &mass).0
}

fn compare(case: &str, found: &[f64], published: &[f64]) {
    for (mode, (f, p)) in found.iter().zip(published).enumerate() {
        println!("{case} mode {}: {f:.4} Hz, published {p} Hz, {:+.3} %", mode + 1, 100.0 * (f / p - 1.0));
        assert!((f / p - 1.0).abs() < 0.005, "{case} mode {}: {f} Hz, published {p} Hz", mode + 1);
    }
}

/// Without shear deformation, as the published values of FV2 and FV4 are.
fn bernoulli(section: Section) -> Section {
    Section { shear_area_y: None, shear_area_z: None, ..section }
}

fn cross(section: Section) -> Vec<f64> {
    let mut model = Model::new();
    let group = model.group("arms");
    let arms = member(section);
    let hub = model.add_node([0.0; 3]);
    let mut nodes = vec![hub];
    for arm in 0..8 {
        let angle = f64::from(arm) * std::f64::consts::FRAC_PI_4;
        let end = model.add_node([5.0 * angle.cos(), 5.0 * angle.sin(), 0.0]);
        nodes.extend(&arms.add_to(&mut model, group, [hub, end], 4).unwrap()[1..]);
        model.support("pin", end, &[Component::X, Component::Y]);
    }
    for node in nodes {
        model.support("plane", node, &[Component::Z, Component::RotationX, Component::RotationY]);
    }
    frequencies(&model)
}

#[test]
fn fv2_a_cross_of_eight_arms_in_its_plane() {
    let mut published = vec![11.336, 17.709, 17.709];
    published.extend([17.709; 5]);
    published.extend([45.345, 57.390, 57.390]);
    let section = Section::rectangle(0.125, 0.125, 0.3).unwrap();
    compare("FV2", &cross(bernoulli(section)), &published);
    // an arm between hub and pin, β L = 7.0686: shear and rotary inertia take a share of
    // ½ (β r)² (1 + E/(κG)), r² = h²/12, of the frequency that the published theory leaves out
    let slender = (7.0686f64 / 5.0 * 0.125).powi(2) / 12.0;
    let share = 0.5 * slender * (1.0 + 2.6 * 1.2);
    let found = cross(section)[10];
    println!("FV2 with shear deformation, mode 11: {found:.4} Hz, less by about {:.3} %", 100.0 * share);
    assert!((found / 57.390 - 1.0 + share).abs() < 0.0015, "{found}");
}

#[test]
fn fv4_a_cantilever_with_masses_off_its_axis() {
    let published = [1.723, 1.727, 7.413, 9.972, 18.155, 26.957];
    let build = |by_links: bool, section: Section| {
        let mut model = Model::new();
        let group = model.group("cantilever");
        let [root, tip] = [[0.0; 3], [10.0, 0.0, 0.0]].map(|x| model.add_node(x));
        member(section).add_to(&mut model, group, [root, tip], 10).unwrap();
        model.fix("root", root);
        for (mass, y) in [(10_000.0, 2.0), (1000.0, -2.0)] {
            if by_links {
                let end = model.add_node([10.0, y, 0.0]);
                model.add(group, PointMass::new(end, mass).unwrap());
                model.rigid_link("arm", tip, &[end]);
            } else {
                let eccentric = PointMass::new(tip, mass).unwrap().with_eccentricity([0.0, y, 0.0]).unwrap();
                model.add(group, eccentric);
            }
        }
        frequencies(&model)
    };
    let section = bernoulli(Section::round(0.5, 0.3).unwrap());
    let (links, eccentric) = (build(true, section), build(false, section));
    compare("FV4", &links, &published);
    for (a, b) in links.iter().zip(&eccentric).take(20) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn fv5_a_deep_simply_supported_beam() {
    let square = Section::rectangle(2.0, 2.0, 0.3).unwrap();
    // the published torsion takes J as the polar moment: no warping
    let section = Section { torsion: square.polar(), ..square };
    let mut model = Model::new();
    let group = model.group("beam");
    let [start, end] = [[0.0; 3], [10.0, 0.0, 0.0]].map(|x| model.add_node(x));
    member(section).add_to(&mut model, group, [start, end], 20).unwrap();
    model.support("end", start, &[Component::X, Component::Y, Component::Z, Component::RotationX]);
    model.support("other end", end, &[Component::Y, Component::Z]);
    let published = [42.649, 42.649, 77.542, 125.00, 148.31, 148.31, 233.10, 284.55, 284.55];
    compare("FV5", &frequencies(&model), &published);
}
