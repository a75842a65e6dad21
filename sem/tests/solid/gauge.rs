//! Strain and stress at a place: exact for uniform strain, and the arms' own recursion where strain varies.

use crate::{materials, small_box};
use hati_coupling::Subdomain;
use hati_sem::mesh::Locator;
use hati_sem::solid::{Execution, Gauge, Ground, Instructions, Memory, Solid};

/// Index pairs of xx, yy, zz, xy, yz, xz.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];

fn hooke(lambda: f64, mu: f64, e: &[f64; 6]) -> [f64; 6] {
    let trace = e[0] + e[1] + e[2];
    std::array::from_fn(|c| if c < 3 { lambda * trace } else { 0.0 } + 2.0 * mu * e[c])
}

fn close(a: &[f64; 6], b: &[f64; 6], tolerance: f64, case: &str) {
    let scale = b.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let error = a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(scale > 0.0 && error <= tolerance * scale, "{case}: {a:?} against {b:?}");
}

#[test]
fn uniform_strain_is_found_exactly() {
    for dimension in [2, 3] {
        for geometry in [1, 2] {
            let ground = Ground::new(small_box(dimension, geometry, true), 3, &materials(false)).unwrap();
            let mut slope = [[0.1, 0.2, -0.3], [0.4, -0.2, 0.6], [0.5, 0.7, 0.25]];
            if dimension == 2 {
                slope.iter_mut().for_each(|row| row[1] = 0.0);
            }
            let mut solid = Solid::<f64>::new(&ground, 1e-3, 1e-3, Execution::default());
            let at = |x: [f64; 3]| slope.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
            solid.set_motion(&ground, |x| (at(x), [0.0; 3]));
            let locator = Locator::new(ground.mesh());
            let place = if dimension == 3 { [1.37, 0.21, -0.9] } else { [1.37, 0.0, -0.9] };
            let probe = ground.probe(&locator, place).unwrap();
            let found = Gauge::new(&solid, &ground, &probe).look(&solid);
            let expected = PAIRS.map(|(i, j)| 0.5 * (slope[i][j] + slope[j][i]));
            let case = format!("D = {dimension}, geometry {geometry}");
            close(&found.strain, &expected, 1e-11, &case);
            let (lambda, mu) = ground.material(probe.element).relaxed();
            close(&found.stress, &hooke(lambda, mu, &expected), 1e-11, &case);
        }
    }
}

/// Largest error of a stress that takes its memory from a third of the points, over the stress: Q = 10, an element from a
/// point force, five points per wavelength. Without memory it would be some tenths.
const COARSE: f64 = 6e-2;

#[test]
fn the_arms_follow_the_places_own_strain() {
    for dimension in [2, 3] {
        // affine elements: strain is a polynomial of the basis, so what holds at the points holds between them; in
        // deformed ones it is nearly one
        for (instructions, geometry, deformed, memory, tolerance) in [
            (Instructions::Best, 1, false, Memory::Full, 1e-9),
            (Instructions::Portable, 1, false, Memory::Full, 1e-9),
            (Instructions::Best, 1, true, Memory::Full, 5e-3),
            (Instructions::Best, 2, true, Memory::Full, 5e-3),
            // a third of the points keep an arm
            (Instructions::Best, 1, false, Memory::Coarse, COARSE),
            (Instructions::Portable, 1, false, Memory::Coarse, COARSE),
            (Instructions::Best, 1, true, Memory::Coarse, COARSE),
            (Instructions::Best, 2, true, Memory::Coarse, COARSE),
        ] {
            let mesh = small_box(dimension, geometry, deformed);
            let mut ground = Ground::new(mesh, 4, &materials(true)).unwrap();
            ground.set_memory(memory).unwrap();
            let y = if dimension == 3 { 0.2 } else { 0.0 };
            let (forces, probe) = {
                let locator = Locator::new(ground.mesh());
                let forces = ground.point_force(&locator, [1.3, y, -0.7], [1.0, -0.6, 0.8]).unwrap();
                (forces, ground.probe(&locator, [2.3, y, -1.1]).unwrap())
            };
            let (dt, steps) = (0.01, 200);
            ground.add_load(forces, (0..steps).map(|i| (0.05 * i as f64).sin()).collect());
            let execution = Execution { threads: 1, instructions };
            let mut solid = Solid::<f64>::new(&ground, dt, dt, execution);
            let gauge = Gauge::new(&solid, &ground, &probe);
            let material = ground.material(probe.element);
            let mut dashpots = vec![[0.0; 6]; material.omega().len()];
            for step in 0..steps {
                let found = gauge.look(&solid);
                let (lambda, mu) = material.relaxed();
                let mut expected = hooke(lambda, mu, &found.strain);
                for (l, dashpot) in dashpots.iter_mut().enumerate() {
                    let x = 0.5 * material.omega()[l] * dt;
                    let own: [f64; 6] = std::array::from_fn(|c| (found.strain[c] - dashpot[c]) / (1.0 + x));
                    let (lambda, mu) = material.arm(l);
                    let part = hooke(lambda, mu, &own);
                    (0..6).for_each(|c| expected[c] += part[c]);
                    (0..6).for_each(|c| dashpot[c] += 2.0 * x * own[c]);
                }
                if step > 150 {
                    let case = format!(
                        "D = {dimension}, {instructions:?}, geometry {geometry} {deformed}, {memory:?}, step {step}"
                    );
                    close(&found.stress, &expected, tolerance, &case);
                }
                solid.step();
            }
            let relaxed = hooke(material.relaxed().0, material.relaxed().1, &gauge.look(&solid).strain);
            let stress = gauge.look(&solid).stress;
            let share = (stress[0] - relaxed[0]).abs() / relaxed[0].abs();
            assert!(share > 1e-3, "the arms carry nothing: {share:e}");
        }
    }
}
