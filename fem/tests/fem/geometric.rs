//! Geometric stiffness: buckling loads and the work of a turned stress.

use crate::bodies::{KINDS, cholesky, dense, solid_model, steel};
use hati_fem::{
    assembly::{Assembly, add_force},
    constraint::Component,
    element::{Bar, Beam, Element, Recovery},
    mesh::{SolidKind, subdivide},
    model::Model,
    section::Section,
    statics,
};
use nalgebra::{DMatrix, SymmetricEigen};
use std::f64::consts::PI;

/// Least factor on the load that makes $K + \lambda K_\sigma$ singular.
fn buckling_factor(assembly: &Assembly<'_>, load: &[f64]) -> f64 {
    let stiffness = assembly.stiffness().unwrap();
    let s = vec![0.0; assembly.reduction().supports().len()];
    let state = statics::solve(assembly, &stiffness, load, &s, cholesky).unwrap();
    let geometric = dense(&assembly.geometric_stiffness(&state.displacement).unwrap().free);
    let factor = dense(&stiffness.free).cholesky().unwrap().l();
    let half = factor.solve_lower_triangular(&geometric).unwrap();
    let reduced = factor.solve_lower_triangular(&half.transpose()).unwrap();
    let values: DMatrix<f64> = (&reduced + reduced.transpose()) * 0.5;
    -1.0 / SymmetricEigen::new(values).eigenvalues.min()
}

/// Fixed–free column: Euler's load with Engesser's correction for shear, N = P_E / (1 + P_E/GA_s).
fn engesser(young: f64, inertia: f64, length: f64, shear: f64) -> f64 {
    let euler = PI * PI * young * inertia / (4.0 * length * length);
    euler / (1.0 + euler / shear)
}

#[test]
fn a_beam_column_buckles_at_eulers_load() {
    let (section, length) = (Section::rectangle(0.3, 0.2, 0.3).unwrap(), 5.0);
    let mut model = Model::new();
    let group = model.group("column");
    let points = subdivide([0.0; 3], [0.0, 0.0, length], 8);
    let nodes = model.add_nodes(&points);
    for (pair, at) in nodes.windows(2).zip(points.windows(2)) {
        let beam = Beam::new([pair[0], pair[1]], [at[0], at[1]], [1.0, 0.0, 0.0], section, steel()).unwrap();
        model.add(group, beam);
    }
    model.fix("foot", nodes[0]);
    let assembly = Assembly::new(&model).unwrap();
    let mut load = vec![0.0; assembly.numbering().size()];
    add_force(assembly.numbering(), &mut load, nodes[8], Component::Z, -1.0).unwrap();
    let shear = steel().shear_modulus() * section.shear_area_z.unwrap();
    let exact = engesser(steel().young(), section.iy, length, shear);
    let found = buckling_factor(&assembly, &load);
    println!("beam column: {found} N, exact {exact} N");
    assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
}

#[test]
fn a_solid_column_buckles_near_eulers_load() {
    let (side, length) = (0.2, 4.0);
    for (kind, n, tolerance) in
        [(SolidKind::Hex8, 16, 0.01), (SolidKind::Hex20, 4, 0.01), (SolidKind::Tet10, 8, 0.01)]
    {
        let (mut model, mesh) = solid_model(
            kind,
            [1, 1, n],
            hati_fem::material::Material::new(200e9, 0.0, 8000.0).unwrap(),
            |x| [side * x[0], side * x[1], length * x[2]],
        );
        let mut top = vec![];
        for (node, x) in mesh.nodes.iter().enumerate() {
            if x[2] == 0.0 {
                model.fix("foot", node);
            } else if x[2] == length {
                top.push(node);
            }
        }
        let grip = model.add_node([side / 2.0, side / 2.0, length]);
        model.distribute("grip", grip, &top, &vec![1.0; top.len()]);
        let assembly = Assembly::new(&model).unwrap();
        let mut load = vec![0.0; assembly.numbering().size()];
        add_force(assembly.numbering(), &mut load, grip, Component::Z, -1.0).unwrap();
        let shear = 100e9 * side * side * 5.0 / 6.0;
        let exact = engesser(200e9, side.powi(4) / 12.0, length, shear);
        let found = buckling_factor(&assembly, &load);
        println!("{kind:?} column: {found} N, exact {exact} N");
        assert!((found / exact - 1.0).abs() < tolerance, "{kind:?}: {found} {exact}");
    }
}

#[test]
fn a_turned_tension_resists_with_force_times_length() {
    // pulled along x by strain ε, then turned by θ about z: the work is ½ N L θ²
    let (strain, length) = (1e-3, 2.0);
    for kind in KINDS {
        let material = steel();
        let (model, mesh) =
            solid_model(kind, [1, 1, 1], material, |x| [length * x[0], 0.3 * x[1], 0.2 * x[2]]);
        let assembly = Assembly::new(&model).unwrap();
        let pulled = |x: [f64; 3]| [strain * x[0], -0.3 * strain * x[1], -0.3 * strain * x[2]];
        let u: Vec<f64> = mesh.nodes.iter().flat_map(|&x| pulled(x)).collect();
        let turn: Vec<f64> = mesh.nodes.iter().flat_map(|x| [-x[1], x[0], 0.0]).collect();
        let geometric = assembly.geometric_stiffness(&u).unwrap().free;
        let mut force = vec![0.0; turn.len()];
        geometric.multiply(&turn, &mut force);
        let work: f64 = force.iter().zip(&turn).map(|(a, b)| a * b).sum();
        let exact = material.young() * strain * 0.06 * length;
        assert!((work / exact - 1.0).abs() < 1e-12, "{kind:?}: {work} {exact}");
    }
}

#[test]
fn a_tight_bar_is_a_string() {
    let bar = Bar::new([0, 1], [[0.0; 3], [2.0, 0.0, 0.0]], 0.01, steel()).unwrap();
    let pulled = [0.0, 0.0, 0.0, 1e-4, 0.0, 0.0];
    let force = 200e9 * 0.01 * 1e-4 / 2.0;
    assert_eq!(bar.recover(&pulled, [0.0; 3]), Recovery::Axial(force));
    let geometric = bar.geometric_stiffness(&pulled).unwrap();
    assert!((geometric[(1, 1)] - force / 2.0).abs() < 1e-9 * force);
    assert_eq!(geometric[(0, 0)], 0.0);
    assert!((geometric[(1, 4)] + force / 2.0).abs() < 1e-9 * force);
}
