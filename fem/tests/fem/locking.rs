//! No locking: thin cantilevers on coarse meshes, and nearly incompressible bodies.

use crate::{
    bodies::{cholesky, order, solid_model},
    convergence::{Wave, error},
};
use hati_fem::{
    assembly::{Assembly, add_force},
    constraint::Component,
    material::Material,
    mesh::SolidKind,
    statics,
};
use nalgebra::Vector3;

const LENGTH: f64 = 10.0;
const SIDE: f64 = 0.1;

/// Tip deflection over that of the Timoshenko beam: 100 times longer than thick, `n` cells along and
/// one across, force at the tip spread by a distributing coupling, the root free to contract.
fn cantilever(kind: SolidKind, n: usize, poisson: f64, skew: f64) -> f64 {
    let material = Material::new(200e9, poisson, 8000.0).unwrap();
    let (mut model, mesh) = solid_model(kind, [n, 1, 1], material, |x| {
        // cells that lean by `skew` of their thickness in mid-span, the ends upright
        let lean = skew * SIDE * (x[2] - 0.5) * 4.0 * x[0] * (1.0 - x[0]);
        [LENGTH * x[0] + lean, SIDE * (x[1] - 0.5), SIDE * (x[2] - 0.5)]
    });
    let at = |x: [f64; 3], y: [f64; 3]| (0..3).all(|i| (x[i] - y[i]).abs() < 1e-12);
    let mut tip = vec![];
    for (node, &x) in mesh.nodes.iter().enumerate() {
        if x[0].abs() < 1e-12 {
            let mut held = vec![Component::X];
            // two corners of one level keep the section from falling and turning, one from sliding
            if at(x, [0.0, -SIDE / 2.0, -SIDE / 2.0]) {
                held.extend([Component::Y, Component::Z]);
            } else if at(x, [0.0, SIDE / 2.0, -SIDE / 2.0]) {
                held.push(Component::Z);
            }
            model.support("root", node, &held);
        } else if (x[0] - LENGTH).abs() < 1e-12 {
            tip.push(node);
        }
    }
    let grip = model.add_node([LENGTH, 0.0, 0.0]);
    model.distribute("grip", grip, &tip, &vec![1.0; tip.len()]);
    let assembly = Assembly::new(&model).unwrap();
    let mut load = vec![0.0; assembly.numbering().size()];
    add_force(assembly.numbering(), &mut load, grip, Component::Z, 1000.0).unwrap();
    let s = vec![0.0; assembly.reduction().supports().len()];
    let state = statics::solve(&assembly, &assembly.stiffness().unwrap(), &load, &s, cholesky).unwrap();
    let down = state.displacement[assembly.numbering().start(grip) + 2];
    let inertia = SIDE.powi(4) / 12.0;
    let bending = 1000.0 * LENGTH.powi(3) / (3.0 * 200e9 * inertia);
    let shear = 1000.0 * LENGTH / (material.shear_modulus() * SIDE * SIDE * 5.0 / 6.0);
    down / (bending + shear)
}

#[test]
fn thin_cantilevers_reach_the_beam_on_coarse_meshes() {
    // linear moments leave 1/(4 n²) to elements of constant curvature
    for (kind, n) in [(SolidKind::Hex8, 10), (SolidKind::Hex20, 6), (SolidKind::Tet10, 20)] {
        for poisson in [0.0, 0.3, 0.4999] {
            let ratio = cantilever(kind, n, poisson, 0.0);
            println!("{kind:?}, {n} × 1 × 1 cells, ν = {poisson}: tip at {ratio} of the beam");
            assert!((ratio - 1.0).abs() < 0.01, "{kind:?}, ν = {poisson}: {ratio}");
        }
    }
}

#[test]
fn cells_that_lean_by_27_degrees_stay_within_two_percent_and_a_half() {
    for (kind, n) in [(SolidKind::Hex8, 10), (SolidKind::Hex20, 6), (SolidKind::Tet10, 20)] {
        let ratio = cantilever(kind, n, 0.3, 0.5);
        println!("{kind:?}, {n} × 1 × 1 leaning cells: tip at {ratio} of the beam");
        assert!((ratio - 1.0).abs() < 0.025, "{kind:?}: {ratio}");
    }
}

/// Errors of one field without dilatation at ν = 0.3 and 0.4999. With A across k the field does not
/// change with ν, so only locking can make a difference.
fn without_dilatation(kind: SolidKind, n: usize) -> [f64; 2] {
    [0.3, 0.4999].map(|poisson| {
        let material = Material::new(200e9, poisson, 8000.0).unwrap();
        let (amplitude, wavenumber) = (Vector3::new(0.5f64, -1.0, -0.5), Vector3::new(2.0, 1.5, -1.0));
        assert!(amplitude.dot(&wavenumber).abs() < 1e-15);
        error(kind, n, Wave { amplitude, wavenumber, material })
    })
}

#[test]
fn hexahedra_are_as_accurate_near_incompressibility() {
    for (kind, n) in [(SolidKind::Hex8, 6), (SolidKind::Hex20, 4)] {
        let [plain, tight] = without_dilatation(kind, n);
        println!("{kind:?}: {plain:e} at ν = 0.3, {tight:e} at 0.4999");
        assert!(tight < 1.2 * plain, "{kind:?}: {plain:e} at 0.3, {tight:e} at 0.4999");
    }
}

#[test]
fn tetrahedra_lose_a_factor_near_incompressibility_and_keep_converging() {
    let errors = [3, 6].map(|n| without_dilatation(SolidKind::Tet10, n));
    println!("Tet10, 3 and 6 cells: {errors:?}");
    let observed = order(errors[0][1], errors[1][1], 2.0);
    assert!(observed > 2.0, "order {observed} at ν = 0.4999");
    assert!(errors[1][1] < 8.0 * errors[1][0], "{errors:?}");
}
