//! Craig-Bampton: exact with all modes, exact in statics, convergent between, its error bounded.

use approx::assert_relative_eq;
use hati_fem::FemError;
use hati_fem::modes::{Search, Wanted, modes};
use hati_fem::reduction::{Kept, Reduction};
use hati_fem::sparse::{Factor, Ordering, Symbolic, SymmetricMatrix};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use std::sync::Arc;

mod brick;

fn dense(a: &SymmetricMatrix) -> DMatrix<f64> {
    let mut d = DMatrix::zeros(a.size(), a.size());
    for c in 0..a.size() {
        for k in a.starts()[c]..a.starts()[c + 1] {
            d[(a.rows()[k], c)] = a.values()[k];
            d[(c, a.rows()[k])] = a.values()[k];
        }
    }
    d
}

/// Eigenvalues of a dense pencil, increasing.
fn eigenvalues(k: &DMatrix<f64>, m: &DMatrix<f64>) -> Vec<f64> {
    let l = m.clone().cholesky().unwrap().l();
    let half = l.solve_lower_triangular(k).unwrap();
    let a = l.solve_lower_triangular(&half.transpose()).unwrap();
    let mut values: Vec<f64> = (0.5 * (&a + a.transpose())).symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// A free bar of bricks; retained: the freedoms of its two ends.
fn bar() -> (brick::Block, Vec<usize>) {
    let block = brick::free_block([1, 1, 10], [0.1, 0.12, 1.0]);
    let n = block.mass.size();
    let retained = (0..12).chain(n - 12..n).collect();
    (block, retained)
}

fn reduced(block: &brick::Block, retained: &[usize], kept: Kept) -> Result<Reduction, FemError> {
    let search = Search { tolerance: 1e-12, ..Search::default() };
    Reduction::new(&block.stiffness, &block.mass, &block.groups, retained, &[], kept, search)
}

fn matrices(r: &Reduction) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = r.size();
    (DMatrix::from_column_slice(n, n, r.stiffness()), DMatrix::from_column_slice(n, n, r.mass()))
}

/// Dynamic stiffness at the first `b` freedoms: Schur complement of $K - \omega^2 M$.
fn dynamic(k: &DMatrix<f64>, m: &DMatrix<f64>, omega: f64, keep: &[usize]) -> DMatrix<f64> {
    let d = k - omega * omega * m;
    let rest: Vec<usize> = (0..d.nrows()).filter(|i| !keep.contains(i)).collect();
    let part = |r: &[usize], c: &[usize]| DMatrix::from_fn(r.len(), c.len(), |i, j| d[(r[i], c[j])]);
    let solved = part(&rest, &rest).lu().solve(&part(&rest, keep)).unwrap();
    part(keep, keep) - part(keep, &rest) * solved
}

#[test]
fn with_all_modes_kept_nothing_is_lost() {
    let (block, retained) = bar();
    let (n, inner) = (block.mass.size(), block.mass.size() - retained.len());
    let r = reduced(&block, &retained, Kept::Count(inner)).unwrap();
    assert_eq!(r.size(), n);
    let (k, m) = matrices(&r);
    let (full_k, full_m) = (dense(&block.stiffness), dense(&block.mass));
    let (found, exact) = (eigenvalues(&k, &m), eigenvalues(&full_k, &full_m));
    for i in 0..n {
        assert_relative_eq!(found[i], exact[i], max_relative = 1e-10, epsilon = 1e-10 * exact[20]);
    }
    assert_eq!(r.estimate(1.0), 0.0);
    // under any harmonic motion too
    let first: Vec<usize> = (0..retained.len()).collect();
    for omega in [1e3, 1e4, 3e4] {
        let a = dynamic(&k, &m, omega, &first);
        let b = dynamic(&full_k, &full_m, omega, &retained);
        assert!((&a - &b).amax() < 1e-9 * b.amax(), "{:e}", (&a - &b).amax() / b.amax());
    }
}

#[test]
fn statics_are_exact_without_any_mode() {
    let block = brick::block([2, 2, 6], [0.2, 0.2, 0.8]);
    let n = block.stiffness.size();
    let retained: Vec<usize> = vec![n - 1, 40, n - 3];
    let r = reduced(&block, &retained, Kept::Count(0)).unwrap();
    let (k, _) = matrices(&r);
    let load = [3.0, -1.0, 2.0];
    let mut full_load = vec![0.0; n];
    for (f, l) in retained.iter().zip(load) {
        full_load[*f] = l;
    }
    assert_eq!(r.reduce_force(&full_load).unwrap(), load);
    let small = k.cholesky().unwrap().solve(&DVector::from_row_slice(&load));
    let mut recovered = vec![0.0; n];
    r.recover(small.as_slice(), &mut recovered).unwrap();
    let pattern = Symbolic::new(&block.stiffness, &block.groups, Ordering::default()).unwrap();
    let mut exact = full_load;
    Factor::definite(&Arc::new(pattern), &block.stiffness, 1).unwrap().solve(&mut exact);
    let top = exact.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    for (a, b) in recovered.iter().zip(&exact) {
        assert_relative_eq!(a, b, epsilon = 1e-11 * top);
    }
    let rows = r.recovery(&[40, 7]).unwrap();
    assert_eq!([rows[0], rows[2], rows[4]], [0.0, 1.0, 0.0]);
    assert_relative_eq!(
        rows[1] * small[0] + rows[3] * small[1] + rows[5] * small[2],
        recovered[7],
        max_relative = 1e-12
    );
}

#[test]
fn frequencies_converge_from_above_as_modes_are_kept() {
    let (block, retained) = bar();
    let exact =
        modes(&block.stiffness, &block.mass, &block.groups, Wanted::Lowest(10), Search::default()).unwrap();
    let mut last = f64::INFINITY;
    for count in [0, 2, 4, 8, 16, 32] {
        let (k, m) = matrices(&reduced(&block, &retained, Kept::Count(count)).unwrap());
        let found = eigenvalues(&k, &m);
        let errors: Vec<f64> = (6..10).map(|i| found[i] / exact.values()[i] - 1.0).collect();
        assert!(errors.iter().all(|e| *e > -1e-9), "{count}: {errors:?}");
        let worst = errors.iter().fold(0.0, |a: f64, b| a.max(*b));
        assert!(worst <= last + 1e-9, "{count}: {worst:e} after {last:e}");
        last = worst;
    }
    // 6e-5 measured: the stiff modes of the section that are left out follow the others almost statically
    assert!(last < 1e-4, "{last:e}");
    let (k, m) = matrices(&reduced(&block, &retained, Kept::Count(0)).unwrap());
    assert!(eigenvalues(&k, &m)[9] > 1.05 * exact.values()[9]);
}

#[test]
fn the_estimate_bounds_the_error_and_is_near_it() {
    let (block, retained) = bar();
    let (full_k, full_m) = (dense(&block.stiffness), dense(&block.mass));
    let first: Vec<usize> = (0..retained.len()).collect();
    for cut_off in [4000.0, 8000.0] {
        let r = reduced(&block, &retained, Kept::Below(cut_off)).unwrap();
        assert!(!r.modes().is_empty());
        let (k, m) = matrices(&r);
        for share in [0.2, 0.5, 0.8] {
            let omega = 2.0 * PI * share * cut_off;
            let a = dynamic(&k, &m, omega, &first);
            let b = dynamic(&full_k, &full_m, omega, &retained);
            let error = (0..retained.len())
                .map(|j| {
                    let scale = k[(j, j)].max(omega * omega * m[(j, j)]);
                    (a[(j, j)] - b[(j, j)]).abs() / scale
                })
                .fold(0.0, f64::max);
            let bound = r.estimate(share * cut_off);
            assert!(error <= bound && bound < 4.0 * error, "{share}: {error:e}, bound {bound:e}");
        }
        assert_eq!(r.estimate(cut_off), f64::INFINITY);
    }
}

#[test]
fn an_accuracy_chooses_the_modes_or_is_refused() {
    let (block, retained) = bar();
    let mut counts = vec![];
    for accuracy in [1e-1, 1e-2, 1e-3] {
        let r = reduced(&block, &retained, Kept::Accuracy { band: 3000.0, accuracy }).unwrap();
        assert!(r.estimate(3000.0) <= accuracy);
        counts.push(r.modes().len());
    }
    assert!(counts[0] < counts[2] && counts[2] < 60, "{counts:?}");
    let error = reduced(&block, &retained, Kept::Accuracy { band: 300.0, accuracy: 1e-12 }).unwrap_err();
    assert!(matches!(error, FemError::Reduction { band: 300.0, .. }), "{error}");
    // in directions of a rigid base less is needed than freedom by freedom
    let shake: Vec<f64> = (0..24).map(|i| f64::from(i % 3 == 0)).collect();
    let kept = Kept::Accuracy { band: 3000.0, accuracy: 1e-3 };
    let r = Reduction::new(
        &block.stiffness,
        &block.mass,
        &block.groups,
        &retained,
        &[shake],
        kept,
        Search::default(),
    )
    .unwrap();
    assert!(r.estimate(3000.0) <= 1e-3);
}

#[test]
fn a_structure_that_moves_while_held_names_a_freedom_of_the_whole() {
    let (block, _) = bar();
    // one node held: the bar still turns about it
    let error = reduced(&block, &[5, 3, 4], Kept::Count(2)).unwrap_err();
    let FemError::Pivot { freedom, .. } = error else { panic!("{error}") };
    assert!(![3, 4, 5].contains(&freedom) && freedom < block.mass.size());
    let error = reduced(&block, &[3, 3], Kept::Count(2)).unwrap_err();
    assert_eq!(error, FemError::FreedomTwice { freedom: 3 });
}

#[test]
fn without_retained_freedoms_the_modes_are_left() {
    let block = brick::block([1, 1, 4], [0.1, 0.1, 0.4]);
    let r = reduced(&block, &[], Kept::Count(3)).unwrap();
    let (k, m) = matrices(&r);
    for i in 0..3 {
        assert_relative_eq!(k[(i, i)], r.modes().values()[i], max_relative = 1e-14);
        assert_relative_eq!(m[(i, i)], 1.0, max_relative = 1e-11);
    }
}
