//! Numeric factors and solves.

use super::{Symbolic, SymmetricMatrix};
use crate::FemError;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltError;
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::cholesky::{LdltRef, LltRef};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;

/// Right-hand sides that one pass over the factor serves; more are taken in turns.
pub const SOLVE_COLUMNS: usize = 32;

/// A pivot below this share of its diagonal is what round-off leaves of zero: were it true, a solution would
/// have fewer than three digits left.
const PIVOT_SHARE: f64 = 1e-13;

/// Largest scaled residual of a solve with a factor whose inertia is believed.
const RESIDUAL_OF_INERTIA: f64 = 1e-9;

/// Relative residuals $\|b - A x\| / \|b\|$ of a solve, before and after one refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Before the refinement.
    pub before: f64,
    /// After it.
    pub after: f64,
}

/// Factor of a symmetric matrix, with the scratch that its solves need.
pub struct Factor {
    symbolic: Arc<Symbolic>,
    value: Vec<f64>,
    definite: bool,
    par: Par,
    scratch: MemBuffer,
    negative: usize,
    pivot_share: f64,
}

impl std::fmt::Debug for Factor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Factor")
            .field("size", &self.symbolic.size())
            .field("definite", &self.definite)
            .field("negative", &self.negative)
            .finish_non_exhaustive()
    }
}

impl Factor {
    /// Factor $A = L L^T$ of a positive definite matrix on `threads` threads of the global pool.
    ///
    /// Errors: another pattern than the one analysed; a pivot that is zero, negative or positive only by
    /// round-off (below 1e-13 of its diagonal), with its freedom; no memory.
    pub fn definite(
        symbolic: &Arc<Symbolic>,
        matrix: &SymmetricMatrix,
        threads: usize,
    ) -> Result<Self, FemError> {
        let mut factor = Self::empty(symbolic, true, threads)?;
        factor.renew(matrix)?;
        Ok(factor)
    }

    /// Factor $A = L D L^T$ of an indefinite matrix, without exchange of pivots.
    ///
    /// A solve with it is checked, since nothing bounds the growth of $L$: an error tells that the shift of
    /// $K - \sigma M$ must be moved. Errors besides: those of [`Self::definite`], a pivot of exactly zero.
    pub fn indefinite(
        symbolic: &Arc<Symbolic>,
        matrix: &SymmetricMatrix,
        threads: usize,
    ) -> Result<Self, FemError> {
        let mut factor = Self::empty(symbolic, false, threads)?;
        factor.renew(matrix)?;
        Ok(factor)
    }

    fn empty(symbolic: &Arc<Symbolic>, definite: bool, threads: usize) -> Result<Self, FemError> {
        let size = symbolic.size();
        let memory = FemError::Memory { what: "the factor", size };
        let par = if threads > 1 { Par::rayon(threads) } else { Par::Seq };
        let mut value: Vec<f64> = vec![];
        value.try_reserve_exact(symbolic.inner.len_val()).map_err(|_| memory.clone())?;
        value.resize(symbolic.inner.len_val(), 0.0);
        let scratch = MemBuffer::try_new(symbolic.inner.solve_in_place_scratch::<f64>(SOLVE_COLUMNS, par))
            .map_err(|_| memory)?;
        let symbolic = symbolic.clone();
        Ok(Self { symbolic, value, definite, par, scratch, negative: 0, pivot_share: f64::NAN })
    }

    /// Factors another matrix of the same pattern in the same memory.
    ///
    /// Errors: as when it was made; the factor is then of no use until it is renewed.
    pub fn renew(&mut self, matrix: &SymmetricMatrix) -> Result<(), FemError> {
        let symbolic = self.symbolic.clone();
        if !(Arc::ptr_eq(&symbolic.pattern, &matrix.pattern) || symbolic.pattern == matrix.pattern) {
            let (found, expected) = (matrix.value.len(), symbolic.pattern.row.len());
            return Err(FemError::Pattern { found, expected });
        }
        let size = symbolic.size();
        let diagonal = matrix.diagonal();
        let failed =
            if self.definite { self.renew_definite(matrix)? } else { self.renew_indefinite(matrix)? };
        if let Some(at) = failed {
            let freedom = symbolic.order[at];
            let place = symbolic.diagonal_places().nth(at).expect("a pivot of the matrix");
            return Err(FemError::Pivot { freedom, pivot: self.value[place], diagonal: diagonal[freedom] });
        }
        self.negative = 0;
        self.pivot_share = f64::INFINITY;
        for (place, &freedom) in symbolic.diagonal_places().zip(&symbolic.order) {
            let pivot = if self.definite { self.value[place].powi(2) } else { self.value[place] };
            self.negative += usize::from(pivot < 0.0);
            let share = pivot.abs() / diagonal[freedom].abs();
            if self.definite && (share.is_nan() || share < PIVOT_SHARE) {
                return Err(FemError::Pivot { freedom, pivot, diagonal: diagonal[freedom] });
            }
            self.pivot_share = self.pivot_share.min(share);
        }
        if !self.definite && size > 0 {
            let residual = self.probe(matrix, &diagonal);
            if residual.is_nan() || residual > RESIDUAL_OF_INERTIA {
                return Err(FemError::Unstable { residual });
            }
        }
        Ok(())
    }

    /// The place in the order of elimination where no pivot was found, if so.
    fn renew_definite(&mut self, matrix: &SymmetricMatrix) -> Result<Option<usize>, FemError> {
        let symbolic = &self.symbolic.inner;
        let need = symbolic.factorize_numeric_llt_scratch::<f64>(self.par, Default::default());
        let mut memory = buffer(need, symbolic.nrows())?;
        let result = symbolic.factorize_numeric_llt(
            &mut self.value,
            view(matrix),
            Side::Lower,
            Default::default(),
            self.par,
            MemStack::new(&mut memory),
            Default::default(),
        );
        match result {
            Ok(_) => Ok(None),
            Err(LltError::NonPositivePivot { index }) => Ok(Some(index)),
        }
    }

    fn renew_indefinite(&mut self, matrix: &SymmetricMatrix) -> Result<Option<usize>, FemError> {
        let symbolic = &self.symbolic.inner;
        let need = symbolic.factorize_numeric_ldlt_scratch::<f64>(self.par, Default::default());
        let mut memory = buffer(need, symbolic.nrows())?;
        let result = symbolic.factorize_numeric_ldlt(
            &mut self.value,
            view(matrix),
            Side::Lower,
            Default::default(),
            self.par,
            MemStack::new(&mut memory),
            Default::default(),
        );
        match result {
            Ok(_) => Ok(None),
            Err(LdltError::ZeroPivot { index }) => Ok(Some(index)),
        }
    }

    /// Residual of a solve with a right-hand side without any structure.
    ///
    /// Rows are scaled by $1/\sqrt{|a_{ii}|}$ and the unknowns accordingly: factors without exchange of pivots
    /// do not depend on the units of a freedom, and the measure must not either.
    fn probe(&mut self, matrix: &SymmetricMatrix, diagonal: &[f64]) -> f64 {
        let size = matrix.size();
        let largest = diagonal.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        let scale: Vec<f64> =
            diagonal.iter().map(|d| if *d == 0.0 { largest } else { d.abs() }.sqrt()).collect();
        let mut state = 1;
        let b: Vec<f64> = scale.iter().map(|s| s * crate::random(&mut state)).collect();
        let mut x = b.clone();
        self.solve(&mut x);
        let mut r = b.clone();
        matrix.multiply_add(-1.0, &x, &mut r);
        let (mut residual, mut reference) = (0.0, 0.0);
        for i in 0..size {
            residual += (r[i] / scale[i]).powi(2);
            reference += (b[i] / scale[i]).powi(2) + (x[i] * scale[i]).powi(2);
        }
        (residual / reference).sqrt()
    }

    /// Solves $A X = B$ in place; `x` holds one or more columns one after the other.
    ///
    /// Nothing is allocated with one thread. Cost: one pass over the factor for each [`SOLVE_COLUMNS`]
    /// columns, so that many together cost far less than one by one.
    ///
    /// # Panics
    /// If `x` is no whole number of columns.
    pub fn solve(&mut self, x: &mut [f64]) {
        let size = self.symbolic.size();
        if size == 0 || x.is_empty() {
            return;
        }
        assert_eq!(x.len() % size, 0, "whole columns are expected");
        for part in x.chunks_mut(size * SOLVE_COLUMNS) {
            let columns = part.len() / size;
            let rhs = MatMut::from_column_major_slice_mut(part, size, columns);
            let stack = MemStack::new(&mut self.scratch);
            if self.definite {
                let factor = LltRef::new(&self.symbolic.inner, &self.value);
                factor.solve_in_place_with_conj(Conj::No, rhs, self.par, stack);
            } else {
                let factor = LdltRef::new(&self.symbolic.inner, &self.value);
                factor.solve_in_place_with_conj(Conj::No, rhs, self.par, stack);
            }
        }
    }

    /// Solves $A x = b$ with one step of refinement and tells both residuals.
    ///
    /// `matrix` is the one that was factored. Errors: lengths that do not fit.
    pub fn solve_refined(
        &mut self,
        matrix: &SymmetricMatrix,
        b: &[f64],
        x: &mut [f64],
    ) -> Result<Residual, FemError> {
        let expected = self.symbolic.size();
        for (what, found) in [("matrix", matrix.size()), ("right-hand side", b.len()), ("solution", x.len())]
        {
            if found != expected {
                return Err(FemError::Length { what, found, expected });
            }
        }
        let norm = |v: &[f64]| v.iter().map(|a| a * a).sum::<f64>().sqrt();
        let reference = norm(b);
        let relative = |r: &[f64]| if reference > 0.0 { norm(r) / reference } else { norm(r) };
        x.copy_from_slice(b);
        self.solve(x);
        let mut r = b.to_vec();
        matrix.multiply_add(-1.0, x, &mut r);
        let before = relative(&r);
        self.solve(&mut r);
        for (x, r) in x.iter_mut().zip(&r) {
            *x += r;
        }
        r.copy_from_slice(b);
        matrix.multiply_add(-1.0, x, &mut r);
        Ok(Residual { before, after: relative(&r) })
    }

    /// Number of negative eigenvalues of the matrix, by the signs of the pivots (Sylvester's law of inertia);
    /// zero for [`Self::definite`].
    pub fn negative_pivots(&self) -> usize {
        self.negative
    }

    /// Least pivot as a share of its diagonal: about $10^{-d}$ where $d$ digits were lost.
    pub fn pivot_share(&self) -> f64 {
        self.pivot_share
    }

    /// Pattern of the factor.
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    /// Threads that factor and solve.
    pub fn threads(&self) -> usize {
        self.par.degree()
    }
}

fn buffer(need: StackReq, size: usize) -> Result<MemBuffer, FemError> {
    MemBuffer::try_new(need).map_err(|_| FemError::Memory { what: "the scratch of a factor", size })
}

fn view(matrix: &SymmetricMatrix) -> SparseColMatRef<'_, usize, f64> {
    let size = matrix.size();
    // checked when the matrix was assembled, and cheap beside the factor
    let pattern = SymbolicSparseColMatRef::new_checked(size, size, matrix.starts(), None, matrix.rows());
    SparseColMatRef::new(pattern, matrix.values())
}
