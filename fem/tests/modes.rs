//! Modes against closed forms and dense algebra; none missed.

use approx::assert_relative_eq;
use hati_fem::FemError;
use hati_fem::modes::{Direction, Modes, Search, Wanted, modes};
use hati_fem::sparse::SymmetricMatrix;
use nalgebra::DMatrix;
use std::f64::consts::PI;

mod brick;

fn groups(n: usize) -> Vec<u32> {
    (0..n as u32).collect()
}

fn diagonal(values: &[f64]) -> SymmetricMatrix {
    SymmetricMatrix::assemble(values.len(), values.iter().enumerate().map(|(i, v)| (i, i, *v))).unwrap()
}

/// Springs 1 between `n` masses, with springs of the stiffness given at both ends.
fn chain(n: usize, left: f64, right: f64) -> SymmetricMatrix {
    let links = (0..n - 1).flat_map(|i| [(i, i, 1.0), (i + 1, i + 1, 1.0), (i + 1, i, -1.0)]);
    SymmetricMatrix::assemble(n, links.chain([(0, 0, left), (n - 1, n - 1, right)])).unwrap()
}

/// Laplacian of a box of points, held outside.
fn laplacian(n: [usize; 3]) -> SymmetricMatrix {
    let size = n.iter().product();
    let at = |p: [usize; 3]| (p[2] * n[1] + p[1]) * n[0] + p[0];
    let mut entries = vec![];
    for index in 0..size {
        let p = [index % n[0], index / n[0] % n[1], index / n[0] / n[1]];
        entries.push((index, index, 6.0));
        for axis in 0..3 {
            if p[axis] + 1 < n[axis] {
                let mut q = p;
                q[axis] += 1;
                entries.push((at(q), index, -1.0));
            }
        }
    }
    SymmetricMatrix::assemble(size, entries).unwrap()
}

/// Its eigenvalues: sums of those of three chains.
fn laplacian_values(n: [usize; 3]) -> Vec<f64> {
    let one = |i: usize, n: usize| 2.0 - 2.0 * (PI * i as f64 / (n + 1) as f64).cos();
    let mut values = vec![];
    for i in 1..=n[0] {
        for j in 1..=n[1] {
            for k in 1..=n[2] {
                values.push(one(i, n[0]) + one(j, n[1]) + one(k, n[2]));
            }
        }
    }
    values.sort_by(f64::total_cmp);
    values
}

fn hertz(value: f64) -> f64 {
    value.sqrt() / (2.0 * PI)
}

fn check_orthonormal(modes: &Modes, mass: &SymmetricMatrix) {
    let mut p = vec![0.0; modes.size()];
    for i in 0..modes.len() {
        mass.multiply(modes.shape(i), &mut p);
        for j in 0..modes.len() {
            let product: f64 = modes.shape(j).iter().zip(&p).map(|(a, b)| a * b).sum();
            assert_relative_eq!(product, f64::from(i == j), epsilon = 1e-11);
        }
    }
}

#[test]
fn a_chain_has_its_closed_form_and_all_of_its_mass_in_its_modes() {
    let n = 40;
    let (k, m) = (chain(n, 1.0, 0.0), diagonal(&vec![2.0; n]));
    let found = modes(&k, &m, &groups(n), Wanted::Lowest(n), Search::default()).unwrap();
    assert_eq!(found.len(), n);
    for i in 0..n {
        let exact = 2.0 * ((2 * i + 1) as f64 * PI / (2.0 * (2 * n + 1) as f64)).sin().powi(2);
        assert_relative_eq!(found.values()[i], exact, max_relative = 1e-11);
        assert!(found.residual(i) < 1e-9, "{i}: {:e}", found.residual(i));
        let largest = found.shape(i).iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let first = found.shape(i).iter().find(|v| v.abs() > (1.0 - 1e-6) * largest);
        assert!(*first.unwrap() > 0.0, "{i}");
    }
    check_orthonormal(&found, &m);
    let direction = Direction::new("x", &m, &vec![1.0; n]).unwrap();
    assert_relative_eq!(direction.mass(), 80.0, max_relative = 1e-14);
    let share = found.participation(&direction).unwrap();
    assert_relative_eq!(*share.cumulative.last().unwrap(), 1.0, epsilon = 1e-11);
    // first mode of a long bar: 8 / pi²
    assert_relative_eq!(share.share[0], 8.0 / (PI * PI), max_relative = 2e-2);
}

#[test]
fn repeated_eigenvalues_are_all_found_by_blocks_and_by_single_vectors() {
    let n = [7, 7, 7];
    let exact = laplacian_values(n);
    let (k, m) = (laplacian(n), diagonal(&[1.0; 343]));
    for block in [1, 2, 6] {
        for count in [4, 10, 25] {
            let search = Search { block, ..Search::default() };
            let found = modes(&k, &m, &groups(343), Wanted::Lowest(count), search).unwrap();
            assert_eq!(found.len(), count);
            for (value, exact) in found.values().iter().zip(&exact) {
                assert_relative_eq!(value, exact, max_relative = 1e-10);
            }
            check_orthonormal(&found, &m);
        }
    }
}

#[test]
fn a_band_holds_all_its_modes_and_no_others() {
    let n = [9, 8, 7];
    let exact = laplacian_values(n);
    let (k, m) = (laplacian(n), diagonal(&[1.0; 504]));
    for (low, high) in [(0.0, 1.0), (0.0, 0.2), (0.9, 1.6), (3.0, 3.2), (0.0, 1e-3), (6.0, 6.01)] {
        let band = Wanted::Band { from: hertz(low), to: hertz(high) };
        let found = modes(&k, &m, &groups(504), band, Search::default()).unwrap();
        let inside: Vec<f64> = exact.iter().copied().filter(|v| (low..high).contains(v)).collect();
        assert_eq!(found.len(), inside.len(), "{low} to {high}");
        for (value, exact) in found.values().iter().zip(&inside) {
            assert_relative_eq!(value, exact, max_relative = 1e-9);
        }
        check_orthonormal(&found, &m);
    }
    // repeated eigenvalues within a band, by single vectors
    let cube = laplacian_values([6, 6, 6]);
    let (low, high) = (2.0, 3.1);
    let inside: Vec<f64> = cube.iter().copied().filter(|v| (low..high).contains(v)).collect();
    for block in [1, 3] {
        let band = Wanted::Band { from: hertz(low), to: hertz(high) };
        let search = Search { block, ..Search::default() };
        let (k, m) = (laplacian([6, 6, 6]), diagonal(&[1.0; 216]));
        let found = modes(&k, &m, &groups(216), band, search).unwrap();
        assert_eq!(found.len(), inside.len());
        for (value, exact) in found.values().iter().zip(&inside) {
            assert_relative_eq!(value, exact, max_relative = 1e-9);
        }
    }
    // an end of the band that is an eigenvalue
    let band = Wanted::Band { from: 0.0, to: hertz(exact[5]) };
    let found = modes(&k, &m, &groups(504), band, Search::default()).unwrap();
    assert!((5..=6).contains(&found.len()));
}

#[test]
fn a_free_body_has_six_motions_without_frequency_that_hold_its_mass() {
    let block = brick::free_block([3, 4, 8], [0.3, 0.4, 0.9]);
    let n = block.mass.size();
    let search = Wanted::Lowest(12);
    let found = modes(&block.stiffness, &block.mass, &block.groups, search, Search::default()).unwrap();
    assert!(found.shift() < 0.0);
    for i in 0..6 {
        assert!(found.values()[i].abs() < 1e-6 * found.values()[6], "{i}: {:?}", found.values());
    }
    assert!(found.values()[6] > 1e6);
    for axis in 0..3 {
        let r: Vec<f64> = (0..n).map(|f| f64::from(f % 3 == axis)).collect();
        let direction = Direction::new("", &block.mass, &r).unwrap();
        assert_relative_eq!(direction.mass(), 7850.0 * 0.3 * 0.4 * 0.9, max_relative = 1e-12);
        let share = found.participation(&direction).unwrap();
        assert_relative_eq!(share.cumulative[5], 1.0, epsilon = 1e-9);
    }
    check_orthonormal(&found, &block.mass);
}

#[test]
fn a_solid_agrees_with_dense_algebra() {
    let block = brick::block([2, 2, 5], [0.1, 0.1, 0.5]);
    let n = block.mass.size();
    let full = |a: &SymmetricMatrix| {
        let mut d = DMatrix::zeros(n, n);
        for c in 0..n {
            for k in a.starts()[c]..a.starts()[c + 1] {
                d[(a.rows()[k], c)] = a.values()[k];
                d[(c, a.rows()[k])] = a.values()[k];
            }
        }
        d
    };
    let l = full(&block.mass).cholesky().unwrap().l();
    let half = l.solve_lower_triangular(&full(&block.stiffness)).unwrap();
    let mut exact: Vec<f64> = l
        .solve_lower_triangular(&half.transpose())
        .unwrap()
        .symmetric_eigenvalues()
        .iter()
        .copied()
        .collect();
    exact.sort_by(f64::total_cmp);
    let found =
        modes(&block.stiffness, &block.mass, &block.groups, Wanted::Lowest(20), Search::default()).unwrap();
    for i in 0..20 {
        assert_relative_eq!(found.values()[i], exact[i], max_relative = 1e-8);
        assert!(found.bound(i) < 1e-9);
        assert!(found.residual(i) < 1e-8, "{i}: {:e}", found.residual(i));
    }
}

#[test]
fn freedoms_without_mass_follow_the_others() {
    // every second mass is zero: two springs 1 in a row are one of 1/2
    let n = 41;
    let mass: Vec<f64> = (0..n).map(|i| f64::from(i % 2 == 1)).collect();
    let (k, m) = (chain(n, 1.0, 1.0), diagonal(&mass));
    let found = modes(&k, &m, &groups(n), Wanted::Lowest(20), Search::default()).unwrap();
    for i in 0..20 {
        let exact = 2.0 * (PI * (i + 1) as f64 / 42.0).sin().powi(2);
        assert_relative_eq!(found.values()[i], exact, max_relative = 1e-10);
        assert!(found.residual(i) < 1e-9, "{i}: {:e}", found.residual(i));
    }
    check_orthonormal(&found, &m);
    let error = modes(&k, &m, &groups(n), Wanted::Lowest(21), Search::default()).unwrap_err();
    assert_eq!(error, FemError::TooManyModes { asked: 21, available: 20 });
}

#[test]
fn a_mechanism_without_mass_and_a_buckled_structure_are_refused() {
    let k = SymmetricMatrix::assemble(3, [(0, 0, 1.0), (2, 2, 1.0)]).unwrap();
    let error =
        modes(&k, &diagonal(&[1.0, 0.0, 1.0]), &groups(3), Wanted::Lowest(1), Search::default()).unwrap_err();
    assert!(matches!(error, FemError::Pivot { freedom: 1, .. }), "{error}");
    let buckled = diagonal(&[1.0, -1.0, 1.0]);
    let error =
        modes(&buckled, &diagonal(&[1.0; 3]), &groups(3), Wanted::Lowest(1), Search::default()).unwrap_err();
    assert!(matches!(error, FemError::Pivot { freedom: 1, .. }), "{error}");
    let error = modes(
        &diagonal(&[1.0; 3]),
        &diagonal(&[1.0; 3]),
        &groups(3),
        Wanted::Band { from: 2.0, to: 1.0 },
        Search::default(),
    );
    assert_eq!(error.unwrap_err(), FemError::Band { from: 2.0, to: 1.0 });
}

#[test]
fn a_structure_that_is_barely_held_keeps_the_digits_of_its_other_modes() {
    for hold in [1e-4, 1e-8, 1e-11, 1e-14] {
        let n = 60;
        let (k, m) = (chain(n, hold, 0.0), diagonal(&vec![1.0; n]));
        let found = modes(&k, &m, &groups(n), Wanted::Lowest(8), Search::default()).unwrap();
        for i in 1..8 {
            let free = 4.0 * (PI * i as f64 / (2 * n) as f64).sin().powi(2);
            assert_relative_eq!(found.values()[i], free, max_relative = 3.0 * hold / free + 1e-9);
        }
        assert_relative_eq!(found.values()[0], hold / n as f64, max_relative = 0.01 + 1e-12 / hold);
    }
}

#[test]
fn stiffnesses_many_orders_apart_do_no_harm() {
    // a mass on a soft spring beside rigid links
    let k = SymmetricMatrix::assemble(
        3,
        [(0, 0, 1e2), (0, 0, 1e12), (1, 0, -1e12), (1, 1, 1e12), (1, 1, 1e12), (2, 1, -1e12), (2, 2, 1e12)],
    )
    .unwrap();
    let found =
        modes(&k, &diagonal(&[1.0, 1.0, 2.0]), &groups(3), Wanted::Lowest(1), Search::default()).unwrap();
    assert_relative_eq!(found.values()[0], 25.0, max_relative = 1e-4);
}

#[test]
fn runs_repeat_and_threads_agree() {
    let block = brick::block([4, 4, 10], [0.2, 0.3, 1.0]);
    let run = |threads| {
        let search = Search { threads, ..Search::default() };
        modes(&block.stiffness, &block.mass, &block.groups, Wanted::Lowest(10), search).unwrap()
    };
    let (a, b, c) = (run(1), run(1), run(2));
    assert_eq!(a, b);
    for i in 0..10 {
        assert_relative_eq!(a.values()[i], c.values()[i], max_relative = 1e-9);
        let product: f64 = {
            let mut p = vec![0.0; a.size()];
            block.mass.multiply(a.shape(i), &mut p);
            p.iter().zip(c.shape(i)).map(|(x, y)| x * y).sum()
        };
        assert_relative_eq!(product, 1.0, epsilon = 1e-8);
    }
}
