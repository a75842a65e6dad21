//! Block Lanczos on $A = (K - \sigma M)^{-1} M$, self-adjoint in the product of $M$.

use crate::FemError;
use crate::sparse::{Factor, SymmetricMatrix};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};

/// Part of a vector that is left after its projection, below which it lay in the space already.
const LEFT: f64 = 1e-11;

/// A basis, $M$-orthonormal, and the operator on it.
///
/// The last columns, from `done` on, have not met the operator yet; the operator on all others stays within
/// the basis: $A V_{done} = V_{done} H + V_{next} B E^T$ with $E$ the columns of the last block. Every new
/// vector is orthogonalised twice against the whole basis, so that no copies of converged modes return.
pub(super) struct Lanczos<'a> {
    mass: &'a SymmetricMatrix,
    factor: &'a mut Factor,
    size: usize,
    block: usize,
    par: Par,
    /// Basis $V$ and $M V$, columns one after the other.
    basis: Vec<f64>,
    mass_basis: Vec<f64>,
    /// Columns of the operator on the basis; the part above the diagonal counts.
    h: Vec<Vec<f64>>,
    /// $B$, rows of the next block, columns of the last.
    coupling: Mat<f64>,
    done: usize,
    used: usize,
    solves: usize,
    state: u64,
    exhausted: bool,
}

/// Ritz pairs by decreasing $|\theta|$.
pub(super) struct Ritz {
    pub(super) theta: Vec<f64>,
    /// $\|A x - \theta x\|_M / |\theta|$.
    pub(super) bound: Vec<f64>,
    vector: Mat<f64>,
}

impl<'a> Lanczos<'a> {
    pub(super) fn new(mass: &'a SymmetricMatrix, factor: &'a mut Factor, block: usize) -> Self {
        let (size, threads) = (mass.size(), factor.threads());
        let mut this = Self {
            mass,
            factor,
            size,
            block: block.clamp(1, size.max(1)),
            par: if threads > 1 { Par::rayon(threads) } else { Par::Seq },
            basis: vec![],
            mass_basis: vec![],
            h: vec![],
            coupling: Mat::zeros(0, 0),
            done: 0,
            used: 0,
            solves: 0,
            state: 0,
            exhausted: false,
        };
        this.fill();
        this
    }

    pub(super) fn solves(&self) -> usize {
        self.solves
    }

    /// Columns on which the operator is known.
    pub(super) fn done(&self) -> usize {
        self.done
    }

    /// Whether the basis spans all there is: its Ritz pairs are the modes.
    pub(super) fn exhausted(&self) -> bool {
        self.exhausted
    }

    /// One block more.
    pub(super) fn step(&mut self) {
        if self.exhausted {
            return;
        }
        let width = self.used - self.done;
        let mut w = self.mass_basis[self.done * self.size..].to_vec();
        self.apply_inverse(&mut w);
        let mut projection = Mat::<f64>::zeros(self.used, width);
        for _ in 0..2 {
            projection += self.project_out(&mut w);
        }
        let reference = (0..width).map(|j| projection.col(j).norm_l2()).fold(0.0, f64::max);
        for j in 0..width {
            self.h.push((0..self.used).map(|i| projection[(i, j)]).collect());
        }
        self.done = self.used;
        self.coupling = self.append(w, reference);
        if self.used - self.done < self.block {
            self.fill();
        }
    }

    /// Puts vectors without structure, from the range of the operator, into the next block.
    ///
    /// From the range, so that no part without mass enters. Where nothing of them is left outside the basis,
    /// the basis is whole.
    fn fill(&mut self) {
        let missing = self.block.saturating_sub(self.used - self.done);
        let mut w: Vec<f64> = (0..missing * self.size).map(|_| crate::random(&mut self.state)).collect();
        w = self.times_mass(&w);
        self.apply_inverse(&mut w);
        let reference = self.norms(&w).into_iter().fold(0.0, f64::max);
        for _ in 0..2 {
            self.project_out(&mut w);
        }
        self.append(w, reference);
        let mut wider = Mat::zeros(self.used - self.done, self.coupling.ncols());
        for j in 0..self.coupling.ncols() {
            for i in 0..self.coupling.nrows() {
                wider[(i, j)] = self.coupling[(i, j)];
            }
        }
        self.coupling = wider;
        self.exhausted = self.used == self.done;
    }

    /// Replaces the next block by vectors without structure; what it held is found again.
    ///
    /// The restart keeps the pairs that converged, whose coupling to the block that goes is below the
    /// tolerance.
    pub(super) fn stir(&mut self, ritz: &Ritz, keep: usize) {
        if self.exhausted {
            return;
        }
        self.restart(ritz, keep);
        self.used = self.done;
        self.coupling = Mat::zeros(0, 0);
        self.basis.truncate(self.used * self.size);
        self.mass_basis.truncate(self.used * self.size);
        self.fill();
    }

    /// Ritz pairs of the basis.
    pub(super) fn ritz(&self) -> Result<Ritz, FemError> {
        let n = self.done;
        let t = Mat::from_fn(n, n, |i, j| {
            let (lo, hi) = (i.min(j), i.max(j));
            // within a block both halves are there, and differ by round-off
            self.h[lo].get(hi).map_or(self.h[hi][lo], |m| 0.5 * (m + self.h[hi][lo]))
        });
        let eigen = t.self_adjoint_eigen(Side::Lower).map_err(|_| FemError::NotFinite {
            row: n,
            column: n,
            value: f64::NAN,
        })?;
        let value = eigen.S().column_vector();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| value[b].abs().total_cmp(&value[a].abs()));
        let vector = Mat::from_fn(n, n, |i, j| eigen.U()[(i, order[j])]);
        let last = self.coupling.ncols();
        let rest = &self.coupling * vector.as_ref().subrows(n - last, last);
        let theta: Vec<f64> = order.iter().map(|&i| value[i]).collect();
        let bound = (0..n).map(|i| rest.col(i).norm_l2() / theta[i].abs()).collect();
        Ok(Ritz { theta, bound, vector })
    }

    /// Shrinks the basis to the first `keep` Ritz vectors and the next block.
    pub(super) fn restart(&mut self, ritz: &Ritz, keep: usize) {
        let keep = keep.min(self.done);
        let next = self.done * self.size..self.used * self.size;
        let mut parts = vec![];
        for old in [&self.basis, &self.mass_basis] {
            let mut new = self.combine(old, ritz, keep);
            new.extend_from_slice(&old[next.clone()]);
            parts.push(new);
        }
        self.mass_basis = parts.pop().expect("two parts");
        self.basis = parts.pop().expect("two parts");
        self.h = (0..keep)
            .map(|j| (0..keep).map(|i| if i == j { ritz.theta[j] } else { 0.0 }).collect())
            .collect();
        // the coupling of the kept vectors comes back with the operator on the next block
        let last = self.coupling.ncols();
        let kept = &self.coupling * ritz.vector.as_ref().subrows(self.done - last, last).subcols(0, keep);
        self.coupling = kept;
        self.used = keep + self.used - self.done;
        self.done = keep;
    }

    /// The first `count` Ritz vectors, columns one after the other.
    pub(super) fn vectors(&self, ritz: &Ritz, count: usize) -> Vec<f64> {
        self.combine(&self.basis, ritz, count)
    }

    fn combine(&self, basis: &[f64], ritz: &Ritz, count: usize) -> Vec<f64> {
        let mut result = vec![0.0; count * self.size];
        let from = MatRef::from_column_major_slice(&basis[..self.done * self.size], self.size, self.done);
        let to = MatMut::from_column_major_slice_mut(&mut result, self.size, count);
        matmul(to, Accum::Replace, from, ritz.vector.as_ref().subcols(0, count), 1.0, self.par);
        result
    }

    fn apply_inverse(&mut self, w: &mut [f64]) {
        self.factor.solve(w);
        self.solves += w.len() / self.size.max(1);
    }

    fn times_mass(&self, w: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; w.len()];
        for (x, y) in w.chunks(self.size).zip(result.chunks_mut(self.size)) {
            self.mass.multiply(x, y);
        }
        result
    }

    fn norms(&self, w: &[f64]) -> Vec<f64> {
        w.chunks(self.size).map(|x| self.mass.quadratic(x).max(0.0).sqrt()).collect()
    }

    /// $C = V^T M W$, $W \leftarrow W - V C$.
    fn project_out(&self, w: &mut [f64]) -> Mat<f64> {
        let columns = w.len() / self.size;
        let mut c = Mat::zeros(self.used, columns);
        let dual = MatRef::from_column_major_slice(&self.mass_basis, self.size, self.used);
        let basis = MatRef::from_column_major_slice(&self.basis, self.size, self.used);
        let mut w = MatMut::from_column_major_slice_mut(w, self.size, columns);
        matmul(c.as_mut(), Accum::Replace, dual.transpose(), w.as_ref(), 1.0, self.par);
        matmul(w.as_mut(), Accum::Add, basis, c.as_ref(), -1.0, self.par);
        c
    }

    /// Orthonormalises `w`, free of the basis, and appends what is not small beside `reference`.
    ///
    /// Returns $B$ with $W = V_{new} B$.
    fn append(&mut self, mut w: Vec<f64>, reference: f64) -> Mat<f64> {
        let mut width = w.len() / self.size;
        let mut coupling = Mat::<f64>::identity(width, width);
        let mut mw = vec![];
        // the second round repairs what the first lost by cancellation, against the basis too
        for round in 0..3 {
            if width == 0 {
                break;
            }
            if round > 0 {
                self.project_out(&mut w);
            }
            mw = self.times_mass(&w);
            let mut gram = Mat::zeros(width, width);
            let [a, b] = [&w, &mw].map(|v| MatRef::from_column_major_slice(v, self.size, width));
            matmul(gram.as_mut(), Accum::Replace, a.transpose(), b, 1.0, self.par);
            let Ok(eigen) = gram.self_adjoint_eigen(Side::Lower) else { break };
            let value = eigen.S().column_vector();
            let floor = if round == 0 { LEFT * reference } else { 0.0 };
            let kept: Vec<usize> = (0..width).filter(|&i| value[i] > floor * floor).collect();
            let turn = Mat::from_fn(width, kept.len(), |i, j| eigen.U()[(i, kept[j])]);
            let scale = |j: usize| value[kept[j]].sqrt();
            let down = Mat::from_fn(width, kept.len(), |i, j| turn[(i, j)] / scale(j));
            coupling = turn.transpose() * coupling;
            for j in 0..coupling.ncols() {
                for i in 0..kept.len() {
                    coupling[(i, j)] *= scale(i);
                }
            }
            for v in [&mut w, &mut mw] {
                let mut new = vec![0.0; self.size * kept.len()];
                let from = MatRef::from_column_major_slice(v, self.size, width);
                let to = MatMut::from_column_major_slice_mut(&mut new, self.size, kept.len());
                matmul(to, Accum::Replace, from, down.as_ref(), 1.0, self.par);
                *v = new;
            }
            width = kept.len();
        }
        self.basis.truncate(self.used * self.size);
        self.mass_basis.truncate(self.used * self.size);
        self.basis.extend_from_slice(&w);
        self.mass_basis.extend_from_slice(&mw);
        self.used += width;
        coupling
    }
}
