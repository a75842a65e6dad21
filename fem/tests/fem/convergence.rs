//! Observed orders of every element, at rest and in vibration.

use crate::bodies::{Factor, cholesky, modes, order, prescribed, solid_model, steel};
use hati_fem::{
    assembly::Assembly,
    constraint::Component,
    element::{Bar, Beam, Hex8, Hex8Shape, Hex20, Hex20Shape, MassForm, SolidShape, Tet10, Tet10Shape},
    material::Material,
    mesh::{SolidKind, SolidMesh},
    model::Model,
    section::Section,
    statics,
};
use nalgebra::{DVector, Vector3};
use std::f64::consts::PI;

/// Standing field u = A sin(k·x + φ) with the body force that balances it.
#[derive(Clone, Copy)]
pub(crate) struct Wave {
    pub(crate) amplitude: Vector3<f64>,
    pub(crate) wavenumber: Vector3<f64>,
    pub(crate) material: Material,
}

impl Wave {
    fn phase(&self, x: [f64; 3]) -> f64 {
        self.wavenumber.dot(&Vector3::from(x)) + 0.4
    }

    pub(crate) fn displacement(&self, x: [f64; 3]) -> [f64; 3] {
        (self.amplitude * self.phase(x).sin()).into()
    }

    /// -div σ = [(λ+μ)(k·A) k + μ k² A] sin(k·x + φ).
    pub(crate) fn force(&self, x: [f64; 3]) -> [f64; 3] {
        let (k, mu) = (self.wavenumber, self.material.shear_modulus());
        let lambda = self.material.bulk_modulus() - 2.0 * mu / 3.0;
        let bracket = k * ((lambda + mu) * k.dot(&self.amplitude)) + self.amplitude * (mu * k.norm_squared());
        (bracket * self.phase(x).sin()).into()
    }
}

/// A smooth distortion that leaves the faces of the unit cube in their planes.
fn bend(x: [f64; 3]) -> [f64; 3] {
    let bump = |v: f64| v * (1.0 - v);
    let s = 0.6 * bump(x[0]) * bump(x[1]) * bump(x[2]);
    [x[0] + s, x[1] - s + 0.2 * bump(x[1]) * (x[0] - 0.5), x[2] + 0.5 * s]
}

fn load_and_error<S: SolidShape>(
    mesh: &SolidMesh,
    wave: Wave,
    solid: impl Fn(&[usize], &[[f64; 3]]) -> hati_fem::element::Solid<S>,
    mut use_solid: impl FnMut(&[usize], &hati_fem::element::Solid<S>, Wave),
) {
    for nodes in &mesh.elements {
        let at: Vec<[f64; 3]> = nodes.iter().map(|&n| mesh.nodes[n]).collect();
        use_solid(nodes, &solid(nodes, &at), wave);
    }
}

/// Relative L2 error of the displacement, all faces held at the exact field.
fn manufactured<S: SolidShape>(
    kind: SolidKind,
    n: usize,
    wave: Wave,
    solid: impl Fn(&[usize], &[[f64; 3]]) -> hati_fem::element::Solid<S>,
) -> f64 {
    let (mut model, mesh) = solid_model(kind, [n; 3], wave.material, bend);
    let flat = hati_fem::mesh::block(kind, [n; 3], |x| x);
    for (node, x) in flat.nodes.iter().enumerate() {
        if x.iter().any(|&v| v == 0.0 || v == 1.0) {
            model.support("faces", node, &Component::TRANSLATIONS);
        }
    }
    let assembly = Assembly::new(&model).unwrap();
    let mut load = vec![0.0; assembly.numbering().size()];
    load_and_error(&mesh, wave, &solid, |nodes, solid, wave| {
        let own = solid.body_load(|x| wave.force(x));
        for (a, node) in nodes.iter().enumerate() {
            (0..3).for_each(|i| load[3 * node + i] += own[3 * a + i]);
        }
    });
    let s = prescribed(&assembly, |x| wave.displacement(x));
    let state = statics::solve(&assembly, &assembly.stiffness().unwrap(), &load, &s, cholesky).unwrap();
    let (mut error, mut norm) = (0.0, 0.0);
    load_and_error(&mesh, wave, &solid, |nodes, solid, wave| {
        for point in S::mass_rule() {
            let volume = point.weight * solid.jacobian(point.xi).determinant();
            let (mut x, mut u) = ([0.0; 3], [0.0; 3]);
            for (value, &node) in S::values(point.xi).iter().zip(nodes) {
                (0..3).for_each(|i| x[i] += value * mesh.nodes[node][i]);
                (0..3).for_each(|i| u[i] += value * state.displacement[3 * node + i]);
            }
            let exact = wave.displacement(x);
            error += volume * (0..3).map(|i| (u[i] - exact[i]).powi(2)).sum::<f64>();
            norm += volume * exact.iter().map(|v| v * v).sum::<f64>();
        }
    });
    (error / norm).sqrt()
}

pub(crate) fn error(kind: SolidKind, n: usize, wave: Wave) -> f64 {
    let m = wave.material;
    match kind {
        SolidKind::Hex8 => manufactured::<Hex8Shape>(kind, n, wave, |i, x| Hex8::new(i, x, m).unwrap()),
        SolidKind::Hex20 => manufactured::<Hex20Shape>(kind, n, wave, |i, x| Hex20::new(i, x, m).unwrap()),
        SolidKind::Tet10 => manufactured::<Tet10Shape>(kind, n, wave, |i, x| Tet10::new(i, x, m).unwrap()),
    }
}

#[test]
fn solids_converge_in_displacement_with_one_order_above_their_degree() {
    let wave = Wave {
        amplitude: Vector3::new(0.8, -0.5, 0.6),
        wavenumber: Vector3::new(2.0, 1.5, -1.0),
        material: steel(),
    };
    for (kind, meshes, theory) in [
        (SolidKind::Hex8, [4, 8, 12], 2.0),
        (SolidKind::Hex20, [2, 4, 6], 3.0),
        (SolidKind::Tet10, [2, 4, 6], 3.0),
    ] {
        let errors = meshes.map(|n| error(kind, n, wave));
        let ratio = meshes[2] as f64 / meshes[1] as f64;
        let observed = order(errors[1], errors[2], ratio);
        println!("{kind:?}: {errors:?}, order {observed}");
        assert!((observed - theory).abs() < 0.25, "{kind:?}: {errors:?}, order {observed}");
    }
}

/// ω² of the standing shear wave of a unit cube whose faces slide: 2π²G/ρ, relative error.
fn sliding_cube(kind: SolidKind, n: usize, material: Material, form: MassForm) -> f64 {
    let (mut model, mesh) = solid_model(kind, [n; 3], material, bend);
    let flat = hati_fem::mesh::block(kind, [n; 3], |x| x);
    for (node, x) in flat.nodes.iter().enumerate() {
        let held = Component::TRANSLATIONS.into_iter().zip(x).filter(|(_, v)| **v == 0.0 || **v == 1.0);
        let held: Vec<Component> = held.map(|(c, _)| c).collect();
        model.support("faces", node, &held);
    }
    let assembly = Assembly::new(&model).unwrap();
    let stiffness = assembly.stiffness().unwrap().free;
    let mass = assembly.mass(form).unwrap().free;
    let mode =
        |x: [f64; 3]| [(PI * x[0]).sin() * (PI * x[1]).cos(), -(PI * x[0]).cos() * (PI * x[1]).sin(), 0.0];
    let freedoms = assembly.reduction().freedoms().iter();
    let mut shape: Vec<f64> = freedoms.map(|f| mode(mesh.nodes[f.node])[f.component.index()]).collect();
    let factor = Factor::new(&stiffness);
    let mut image = vec![0.0; shape.len()];
    let mut square = 0.0;
    for _ in 0..12 {
        mass.multiply(&shape, &mut image);
        shape = factor.solve(&image);
        let work: f64 = shape.iter().zip(&image).map(|(a, b)| a * b).sum();
        mass.multiply(&shape, &mut image);
        square = work / shape.iter().zip(&image).map(|(a, b)| a * b).sum::<f64>();
        let scale = 1.0 / shape.iter().map(|v| v * v).sum::<f64>().sqrt();
        shape.iter_mut().for_each(|v| *v *= scale);
    }
    let exact = 2.0 * PI * PI * material.shear_modulus() / material.density();
    (square / exact - 1.0).abs()
}

#[test]
fn solids_converge_in_frequency_with_twice_their_degree() {
    let material = Material::new(2.5, 0.25, 1.0).unwrap();
    for (kind, meshes, theory) in [
        (SolidKind::Hex8, [4, 8, 12], 2.0),
        (SolidKind::Hex20, [2, 4, 6], 4.0),
        (SolidKind::Tet10, [2, 6, 8], 4.0),
    ] {
        let errors = meshes.map(|n| sliding_cube(kind, n, material, MassForm::Consistent));
        let ratio = meshes[2] as f64 / meshes[1] as f64;
        let observed = order(errors[1], errors[2], ratio);
        println!("{kind:?}: {errors:?}, order {observed}");
        assert!((observed - theory).abs() < 0.25, "{kind:?}: {errors:?}, order {observed}");
    }
}

#[test]
fn lumped_masses_leave_order_two_to_every_solid() {
    let material = Material::new(2.5, 0.25, 1.0).unwrap();
    for (kind, meshes) in [(SolidKind::Hex8, [8, 12]), (SolidKind::Hex20, [4, 6]), (SolidKind::Tet10, [4, 6])]
    {
        let errors = meshes.map(|n| sliding_cube(kind, n, material, MassForm::Lumped));
        let observed = order(errors[0], errors[1], 1.5);
        println!("lumped {kind:?}: {errors:?}, order {observed}");
        assert!((observed - 2.0).abs() < 0.15, "{kind:?}: {errors:?}, order {observed}");
    }
}

/// A straight member along x cut into `n`, its first node 0.
fn member(n: usize, mut element: impl FnMut(&mut Model, [usize; 2], [[f64; 3]; 2])) -> Model {
    let mut model = Model::new();
    let nodes = model.add_nodes(&hati_fem::mesh::subdivide([0.0; 3], [10.0, 0.0, 0.0], n));
    for pair in nodes.windows(2) {
        let at = [model.nodes()[pair[0]], model.nodes()[pair[1]]];
        element(&mut model, [pair[0], pair[1]], at);
    }
    model
}

#[test]
fn bars_converge_in_frequency_with_order_two() {
    let steel = steel();
    let exact = (steel.young() / steel.density()).sqrt() / 20.0;
    let error = |n: usize| {
        let mut model = member(n, |model, nodes, at| {
            let group = model.group("bar");
            model.add(group, Bar::new(nodes, at, 0.01, steel).unwrap());
        });
        for node in 0..=n {
            model.support("guide", node, &[Component::Y, Component::Z]);
        }
        model.support("end", 0, &[Component::X]);
        model.support("end", n, &[Component::X]);
        let assembly = Assembly::new(&model).unwrap();
        let mass = assembly.mass(MassForm::Consistent).unwrap().free;
        (modes(&assembly.stiffness().unwrap().free, &mass).0[0] / exact - 1.0).abs()
    };
    let observed = order(error(10), error(20), 2.0);
    assert!((observed - 2.0).abs() < 0.05, "order {observed}");
}

/// ω² of a simply supported Timoshenko beam at the wavenumber `k`, the lower root of
/// (EIk² + GA_s − ρIω²)(GA_s k² − ρAω²) = (GA_s k)²; without shear EIk⁴ / (ρA + ρIk²).
fn timoshenko(section: &Section, material: Material, k: f64) -> f64 {
    let (bend, turn) = (material.young() * section.iz, material.density() * section.iz);
    let line = section.mass_per_length(material.density());
    let Some(area) = section.shear_area_y else { return bend * k.powi(4) / (line + turn * k * k) };
    let shear = material.shear_modulus() * area;
    let mixed = -shear * k / (line * turn).sqrt();
    let matrix = nalgebra::Matrix2::new(shear * k * k / line, mixed, mixed, (bend * k * k + shear) / turn);
    matrix.symmetric_eigenvalues().min()
}

fn supported_beam(n: usize, mode: usize, section: Section) -> f64 {
    let steel = steel();
    let mut model = member(n, |model, nodes, at| {
        let group = model.group("beam");
        model.add(group, Beam::new(nodes, at, [0.0, 0.0, 1.0], section, steel).unwrap());
    });
    let plane = [Component::Z, Component::RotationX, Component::RotationY, Component::X];
    (0..=n).for_each(|node| model.support("plane", node, &plane));
    for node in [0, n] {
        model.support("pin", node, &[Component::Y]);
    }
    let assembly = Assembly::new(&model).unwrap();
    let mass = assembly.mass(MassForm::Consistent).unwrap().free;
    let found = modes(&assembly.stiffness().unwrap().free, &mass).0[mode - 1];
    let exact = timoshenko(&section, steel, mode as f64 * PI / 10.0);
    (found * 2.0 * PI).powi(2) / exact - 1.0
}

/// The energy of what the shapes leave out sets the order: curvature is linear in a beam, so 4; the
/// shear angle is constant, so 2 where shear deforms.
#[test]
fn beams_converge_in_frequency_with_order_four_without_shear_and_two_with_it() {
    let deep = Section::rectangle(2.0, 2.0, 0.3).unwrap();
    let bernoulli = Section { shear_area_y: None, shear_area_z: None, ..deep };
    for (section, theory) in [(bernoulli, 4.0), (deep, 2.0)] {
        for mode in [1, 3] {
            let errors = [8, 16, 32].map(|n| supported_beam(n, mode, section));
            let observed = order(errors[1], errors[2], 2.0);
            println!("theory {theory}, mode {mode}: {errors:?}, order {observed}");
            assert!((observed - theory).abs() < 0.15, "mode {mode}: {errors:?}, order {observed}");
        }
    }
}

#[test]
fn a_beam_under_load_at_its_nodes_is_exact_however_it_is_cut() {
    let (steel, section) = (steel(), Section::hollow_box(0.6, 1.3, 0.014, 0.008, 0.3).unwrap());
    let (force, length) = (Vector3::new(3e4, -2e4, 5e4), 10.0f64);
    let [ay, az] = [section.shear_area_y.unwrap(), section.shear_area_z.unwrap()];
    let deflection =
        |i: f64, a: f64| length.powi(3) / (3.0 * steel.young() * i) + length / (steel.shear_modulus() * a);
    let exact = Vector3::new(
        length / (steel.young() * section.area),
        deflection(section.iz, ay),
        deflection(section.iy, az),
    );
    for n in [1, 2, 7] {
        let mut model = member(n, |model, nodes, at| {
            let group = model.group("beam");
            model.add(group, Beam::new(nodes, at, [0.0, 0.0, 1.0], section, steel).unwrap());
        });
        model.fix("root", 0);
        let assembly = Assembly::new(&model).unwrap();
        let mut load = vec![0.0; assembly.numbering().size()];
        (0..3).for_each(|i| load[6 * n + i] = force[i]);
        let s = vec![0.0; 6];
        let state = statics::solve(&assembly, &assembly.stiffness().unwrap(), &load, &s, cholesky).unwrap();
        for i in 0..3 {
            let error = state.displacement[6 * n + i] / (exact[i] * force[i]) - 1.0;
            assert!(error.abs() < 1e-10, "{n} beams, axis {i}: {error:e}");
        }
        let reaction = DVector::from_iterator(6, state.reactions.iter().map(|r| r.1));
        assert!((reaction.rows(0, 3) + force).amax() < 1e-6 * force.amax());
        assert!((reaction[4] - length * force.z).abs() < 1e-6 * force.amax());
        assert!((reaction[5] + length * force.y).abs() < 1e-6 * force.amax());
    }
}
