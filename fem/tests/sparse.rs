//! Factors, solves and inertia against closed forms and dense algebra.

use approx::assert_relative_eq;
use hati_fem::FemError;
use hati_fem::sparse::{Factor, Ordering, SOLVE_COLUMNS, Symbolic, SymmetricMatrix, free_motion};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// Chain of springs 1 between `n` masses, its ends held where told.
fn chain(n: usize, left: bool, right: bool) -> SymmetricMatrix {
    let links = (0..n - 1).flat_map(|i| [(i, i, 1.0), (i + 1, i + 1, 1.0), (i + 1, i, -1.0)]);
    let ends = [(0, 0, f64::from(left)), (n - 1, n - 1, f64::from(right))];
    SymmetricMatrix::assemble(n, links.chain(ends)).unwrap()
}

/// Laplacian of a box of `n³` points, held outside: eigenvalues are sums of three of the chain's.
fn laplacian(n: usize) -> SymmetricMatrix {
    let at = |i: usize, j: usize, k: usize| (k * n + j) * n + i;
    let mut entries = vec![];
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                entries.push((at(i, j, k), at(i, j, k), 6.0));
                if i + 1 < n {
                    entries.push((at(i + 1, j, k), at(i, j, k), -1.0));
                }
                if j + 1 < n {
                    entries.push((at(i, j + 1, k), at(i, j, k), -1.0));
                }
                if k + 1 < n {
                    entries.push((at(i, j, k + 1), at(i, j, k), -1.0));
                }
            }
        }
    }
    SymmetricMatrix::assemble(n * n * n, entries).unwrap()
}

fn identity(n: usize) -> SymmetricMatrix {
    SymmetricMatrix::assemble(n, (0..n).map(|i| (i, i, 1.0))).unwrap()
}

fn one_each(n: usize) -> Vec<u32> {
    (0..n as u32).collect()
}

fn analysed(a: &SymmetricMatrix) -> Arc<Symbolic> {
    Arc::new(Symbolic::new(a, &one_each(a.size()), Ordering::default()).unwrap())
}

#[test]
fn a_chain_under_one_force_takes_its_closed_form() {
    let n = 50;
    let a = chain(n, true, false);
    let symbolic = Arc::new(Symbolic::new(&a, &one_each(n), Ordering::Natural).unwrap());
    let mut factor = Factor::definite(&symbolic, &a, 1).unwrap();
    let mut x = vec![0.0; n];
    x[n - 1] = 2.0;
    factor.solve(&mut x);
    for (i, x) in x.iter().enumerate() {
        assert_relative_eq!(*x, 2.0 * (i + 1) as f64, max_relative = 1e-12);
    }
    assert_eq!(factor.negative_pivots(), 0);
    // the last mass hangs on n springs in a row
    assert_relative_eq!(factor.pivot_share(), 1.0 / n as f64, max_relative = 1e-12);
}

#[test]
fn many_columns_are_the_columns_one_by_one_also_past_a_turn() {
    let a = laplacian(7);
    let n = a.size();
    let columns = SOLVE_COLUMNS + 3;
    let mut factor = Factor::definite(&analysed(&a), &a, 1).unwrap();
    let b: Vec<f64> = (0..n * columns).map(|i| ((i * i) as f64).sin()).collect();
    let mut together = b.clone();
    factor.solve(&mut together);
    for c in 0..columns {
        let mut x = b[c * n..(c + 1) * n].to_vec();
        factor.solve(&mut x);
        for i in 0..n {
            assert_relative_eq!(x[i], together[c * n + i], epsilon = 1e-13);
        }
        let mut r = b[c * n..(c + 1) * n].to_vec();
        a.multiply_add(-1.0, &x, &mut r);
        assert!(r.iter().all(|r| r.abs() < 1e-13));
    }
}

#[test]
fn one_thread_and_two_agree() {
    let a = laplacian(14);
    let symbolic = analysed(&a);
    let b: Vec<f64> = (0..a.size()).map(|i| (i as f64).cos()).collect();
    let mut solutions = vec![];
    for threads in [1, 2] {
        let mut factor = Factor::definite(&symbolic, &a, threads).unwrap();
        let mut x = b.clone();
        factor.solve(&mut x);
        solutions.push(x);
    }
    for (x, y) in solutions[0].iter().zip(&solutions[1]) {
        assert_relative_eq!(x, y, epsilon = 1e-13);
    }
}

#[test]
fn negative_pivots_count_the_eigenvalues_below_a_shift() {
    let n = 6;
    let a = laplacian(n);
    let one = |i: usize| 2.0 - 2.0 * (PI * i as f64 / (n + 1) as f64).cos();
    let mut values = vec![];
    for i in 1..=n {
        for j in 1..=n {
            for k in 1..=n {
                values.push(one(i) + one(j) + one(k));
            }
        }
    }
    let symbolic = analysed(&a);
    for shift in [-1.0, 0.3, 1.0, 2.0, 3.7, 5.1, 8.3, 11.0, 12.5] {
        let shifted = SymmetricMatrix::combine(1.0, &a, -shift, &identity(n * n * n)).unwrap();
        let factor = Factor::indefinite(&symbolic, &shifted, 1).unwrap();
        assert_eq!(factor.negative_pivots(), values.iter().filter(|v| **v < shift).count(), "{shift}");
    }
    let mut factor = Factor::indefinite(&symbolic, &a, 1).unwrap();
    let other = SymmetricMatrix::combine(-1.0, &a, 0.0, &a).unwrap();
    factor.renew(&other).unwrap();
    assert_eq!(factor.negative_pivots(), n * n * n);
}

#[test]
fn a_shift_on_an_eigenvalue_is_refused_not_miscounted() {
    // two springs: the leading part of K - 2 M is exactly singular
    let a = chain(2, true, true);
    let shifted = SymmetricMatrix::combine(1.0, &a, -2.0, &identity(2)).unwrap();
    let symbolic = Arc::new(Symbolic::new(&shifted, &[0, 1], Ordering::Natural).unwrap());
    let error = Factor::indefinite(&symbolic, &shifted, 1).unwrap_err();
    assert!(matches!(error, FemError::Pivot { freedom: 0, pivot: 0.0, .. }), "{error}");
    // near it the growth of the factor shows in the residual
    let near = SymmetricMatrix::combine(1.0, &a, -2.0 + 1e-14, &identity(2)).unwrap();
    match Factor::indefinite(&symbolic, &near, 1) {
        Ok(factor) => assert_eq!(factor.negative_pivots(), 1),
        Err(error) => assert!(matches!(error, FemError::Unstable { .. }), "{error}"),
    }
}

#[test]
fn a_mechanism_is_named_by_its_freedom_and_its_motion() {
    // two chains, the second not held: freedoms 30 to 49
    let held = chain(30, true, false);
    let entries = |a: &SymmetricMatrix, shift: usize| {
        (0..a.size())
            .flat_map(|c| (a.starts()[c]..a.starts()[c + 1]).map(move |k| (c, k)))
            .map(|(c, k)| (a.rows()[k] + shift, c + shift, a.values()[k]))
            .collect::<Vec<_>>()
    };
    let mut all = entries(&held, 0);
    all.extend(entries(&chain(20, false, false), 30));
    let a = SymmetricMatrix::assemble(50, all).unwrap();
    let error = Factor::definite(&analysed(&a), &a, 1).unwrap_err();
    let FemError::Pivot { freedom, pivot, diagonal } = error else { panic!("{error}") };
    assert!((30..50).contains(&freedom), "{freedom}");
    assert!(pivot.abs() < 1e-14 && diagonal >= 1.0);
    let (motion, energy) = free_motion(&a, &one_each(50), freedom, 1).unwrap();
    assert!(energy.abs() < 1e-14, "{energy}");
    for (i, x) in motion.iter().enumerate() {
        assert_relative_eq!(*x, f64::from(i >= 30), epsilon = 1e-7);
    }
    // a structure that is held is no mechanism, and is not called one
    let (_, energy) = free_motion(&held, &one_each(30), 29, 1).unwrap();
    assert!(energy > 1e-4, "{energy}");
}

#[test]
fn a_freedom_that_nothing_holds_is_named() {
    let a = SymmetricMatrix::assemble(3, [(0, 0, 1.0), (2, 2, 1.0)]).unwrap();
    let error = Factor::definite(&analysed(&a), &a, 1).unwrap_err();
    assert_eq!(error, FemError::Pivot { freedom: 1, pivot: 0.0, diagonal: 0.0 });
    let (motion, energy) = free_motion(&a, &one_each(3), 1, 1).unwrap();
    assert_eq!((motion, energy), (vec![0.0, 1.0, 0.0], 0.0));
}

#[test]
fn a_slender_structure_is_no_mechanism() {
    // 20,000 springs in a row, the last pivot 5e-5 of its diagonal
    let a = chain(20_000, true, false);
    let mut factor = Factor::definite(&analysed(&a), &a, 1).unwrap();
    let b: Vec<f64> = (0..a.size()).map(|i| (i as f64).sin()).collect();
    let mut x = vec![0.0; a.size()];
    let residual = factor.solve_refined(&a, &b, &mut x).unwrap();
    assert!(residual.after <= residual.before && residual.after < 1e-10, "{residual:?}");
}

#[test]
fn a_matrix_of_another_pattern_is_refused() {
    let a = chain(5, true, false);
    let symbolic = analysed(&a);
    let error = Factor::definite(&symbolic, &identity(5), 1).unwrap_err();
    assert_eq!(error, FemError::Pattern { found: 5, expected: 9 });
}

#[test]
fn fill_and_work_of_a_full_matrix_are_counted() {
    let n = 12;
    let entries = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j, if i == j { 20.0 } else { 1.0 })));
    let symbolic = analysed(&SymmetricMatrix::assemble(n, entries).unwrap());
    assert_eq!(symbolic.entries(), n * (n + 1) / 2);
    assert_eq!(symbolic.flops(), (n * (n + 1) * (2 * n + 1) / 6) as f64);
    assert_eq!(symbolic.factor_bytes(), 8 * n * n);
}

#[test]
fn an_empty_matrix_is_factored_and_solved() {
    let a = SymmetricMatrix::assemble(0, []).unwrap();
    let mut factor = Factor::definite(&analysed(&a), &a, 1).unwrap();
    factor.solve(&mut []);
}

#[test]
fn a_solve_allocates_nothing() {
    let a = laplacian(12);
    let n = a.size();
    let mut factor = Factor::definite(&analysed(&a), &a, 1).unwrap();
    for columns in [1, 8, SOLVE_COLUMNS] {
        let mut x = vec![1.0; n * columns];
        factor.solve(&mut x);
        let counted = allocation_counter::measure(|| factor.solve(&mut x));
        assert_eq!(counted.count_total, 0, "{columns} columns: {counted:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..Default::default() })]

    #[test]
    fn random_matrices_agree_with_dense_algebra(
        n in 2usize..30,
        links in prop::collection::vec((0usize..1000, 0usize..1000, -1.0f64..1.0), 0..80),
        shift in -3.0f64..3.0,
    ) {
        let mut entries: Vec<_> =
            links.iter().map(|&(i, j, v)| (i % n, j % n, v)).filter(|e| e.0 != e.1).collect();
        let mut row = vec![0.0; n];
        for &(i, j, v) in &entries {
            row[i] += v.abs();
            row[j] += v.abs();
        }
        entries.extend((0..n).map(|i| (i, i, row[i] + 0.1)));
        let a = SymmetricMatrix::assemble(n, entries).unwrap();
        let dense = DMatrix::from_fn(n, n, |i, j| {
            let (r, c) = (i.max(j), i.min(j));
            (a.starts()[c]..a.starts()[c + 1]).find(|&k| a.rows()[k] == r).map_or(0.0, |k| a.values()[k])
        });
        let b: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5).sin()).collect();
        let symbolic = analysed(&a);
        let mut x = b.clone();
        Factor::definite(&symbolic, &a, 1).unwrap().solve(&mut x);
        let exact = dense.clone().cholesky().unwrap().solve(&DVector::from_vec(b.clone()));
        for i in 0..n {
            prop_assert!((x[i] - exact[i]).abs() < 1e-11 * (1.0 + exact.amax()));
        }
        let moved = SymmetricMatrix::combine(1.0, &a, -shift, &identity(n)).unwrap();
        let values = dense.symmetric_eigenvalues();
        if values.iter().all(|v| (v - shift).abs() > 1e-6) {
            match Factor::indefinite(&symbolic, &moved, 1) {
                Ok(mut factor) => {
                    prop_assert_eq!(factor.negative_pivots(), values.iter().filter(|v| **v < shift).count());
                    let mut x = b.clone();
                    factor.solve(&mut x);
                    let mut r = b.clone();
                    moved.multiply_add(-1.0, &x, &mut r);
                    prop_assert!(r.iter().all(|r| r.abs() < 1e-6));
                }
                Err(error) => {
                    let refused = matches!(error, FemError::Unstable { .. } | FemError::Pivot { .. });
                    prop_assert!(refused, "{}", error);
                }
            }
        }
    }
}
