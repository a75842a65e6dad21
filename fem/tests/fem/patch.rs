//! Patch tests, rigid modes and rank of the solids.

use crate::bodies::{KINDS, cholesky, largest, prescribed, solid_model, steel};
use hati_fem::{
    assembly::Assembly,
    constraint::Component,
    element::{MassForm, Recovery},
    material::Material,
    mesh::SolidKind,
    statics,
};
use nalgebra::{DMatrix, Matrix3, Vector3};

/// An arbitrary shift of nodes, up to `size`, the same in every run.
fn shake(x: [f64; 3], size: f64) -> [f64; 3] {
    let wave = |a: f64, b: f64, c: f64| (a * x[0] + b * x[1] + c * x[2]).sin();
    [
        x[0] + size * wave(17.0, 5.0, 3.0),
        x[1] + size * wave(7.0, 13.0, -11.0),
        x[2] + size * wave(-4.0, 19.0, 8.0),
    ]
}

fn linear(x: [f64; 3]) -> [f64; 3] {
    let a = Matrix3::new(1.0, 0.4, -0.3, 0.2, -0.7, 0.5, 0.9, -0.1, 0.6) * 1e-3;
    (Vector3::new(1e-3, -2e-3, 5e-4) + a * Vector3::from(x)).into()
}

fn stress(material: Material) -> [f64; 6] {
    let strain = [1.0, -0.7, 0.6, 0.6, 0.4, 0.6].map(|e| e * 1e-3);
    (material.elasticity() * nalgebra::Vector6::from(strain)).into()
}

#[test]
fn a_linear_field_is_exact_on_any_distorted_mesh() {
    for kind in KINDS {
        // middles of edges move too: the edges are curved
        let size = if kind == SolidKind::Hex8 { 0.1 } else { 0.025 };
        for material in [steel(), Material::new(200e9, 0.4999, 8000.0).unwrap()] {
            let (mut model, mesh) = solid_model(kind, [2, 2, 2], material, |x| shake(x, size));
            // the block's surface is where the undistorted mesh has a coordinate of 0 or 1
            let plain = hati_fem::mesh::block(kind, [2, 2, 2], |x| x);
            for (node, x) in plain.nodes.iter().enumerate() {
                if x.iter().any(|&v| v == 0.0 || v == 1.0) {
                    model.support("surface", node, &Component::TRANSLATIONS);
                }
            }
            let assembly = Assembly::new(&model).unwrap();
            assert!(assembly.reduction().free() >= 3);
            let s = prescribed(&assembly, linear);
            let load = vec![0.0; assembly.numbering().size()];
            let state =
                statics::solve(&assembly, &assembly.stiffness().unwrap(), &load, &s, cholesky).unwrap();
            let wrong = mesh.nodes.iter().enumerate().flat_map(|(n, x)| {
                let exact = linear(*x);
                [0, 1, 2].map(|i| state.displacement[3 * n + i] - exact[i])
            });
            let error = largest(wrong) / 3e-3;
            assert!(error < 1e-12, "{kind:?}, ν = {}: displacement off by {error:e}", material.poisson());
            stresses_are_constant(&assembly, &state.displacement, material, kind);
        }
    }
}

fn stresses_are_constant(assembly: &Assembly<'_>, u: &[f64], material: Material, kind: SolidKind) {
    let exact = stress(material);
    // rounding is that of the pressure, which grows as ν → ½
    let scale = largest(exact);
    for element in 0..assembly.model().elements().len() {
        let Recovery::Stresses(points) = assembly.recover(element, u, [0.0; 3]).unwrap() else { panic!() };
        for point in points {
            let error = largest((0..6).map(|i| point.stress[i] - exact[i])) / scale;
            assert!(error < 1e-12, "{kind:?}: stress off by {error:e}");
        }
    }
}

fn one_element(kind: SolidKind, size: f64, material: Material) -> hati_fem::model::Model {
    solid_model(kind, [1, 1, 1], material, |x| shake(x, size)).0
}

#[test]
fn a_distorted_solid_has_the_six_rigid_modes_and_no_other() {
    for kind in KINDS {
        for poisson in [0.0, 0.3, 0.4999] {
            let model = one_element(kind, 0.06, Material::new(1.0, poisson, 1.0).unwrap());
            let mut values: Vec<f64> =
                model.elements()[0].stiffness().symmetric_eigenvalues().iter().copied().collect();
            values.sort_by(f64::total_cmp);
            let top = values[values.len() - 1];
            assert!(largest(values[..6].iter().copied()) < 1e-12 * top, "{kind:?}: {:?}", &values[..6]);
            // a spurious mode would lie at rounding; the softest true one is far above it
            assert!(values[6] > 1e-3 * model_stiffness(poisson), "{kind:?} ν = {poisson}: {}", values[6]);
        }
    }
}

/// Shear modulus times a size of one, which sets the softest mode.
fn model_stiffness(poisson: f64) -> f64 {
    1.0 / (2.0 * (1.0 + poisson))
}

#[test]
fn masses_are_positive_and_add_up_in_both_forms() {
    for kind in KINDS {
        let model = one_element(kind, 0.06, steel());
        let element = model.elements()[0].as_ref();
        for form in [MassForm::Consistent, MassForm::Lumped] {
            let mass = element.mass(form);
            let unit = DMatrix::from_fn(mass.nrows(), 3, |i, j| if i % 3 == j { 1.0 } else { 0.0 });
            let total = unit.transpose() * &mass * &unit;
            let error =
                (total - DMatrix::identity(3, 3) * element.total_mass()).amax() / element.total_mass();
            assert!(error < 1e-13, "{kind:?} {form:?}: {error:e}");
            assert!(mass.symmetric_eigenvalues().min() > 0.0, "{kind:?} {form:?}");
        }
        let lumped = element.mass(MassForm::Lumped);
        assert_eq!(lumped.clone(), DMatrix::from_diagonal(&lumped.diagonal()));
    }
}
