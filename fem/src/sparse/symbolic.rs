//! Pattern of the factor.

use super::{Ordering, Pattern, SymmetricMatrix, ordering};
use crate::FemError;
use faer::Side;
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use std::sync::Arc;

/// Order of elimination and supernodes of the factor: all that depends on the pattern alone.
///
/// Found once for a structure and used for its stiffness, for $K - \sigma M$ and for the operator of an
/// implicit step, as long as they share the pattern.
#[derive(Debug)]
pub struct Symbolic {
    pub(super) inner: SymbolicCholesky<usize>,
    pub(super) pattern: Arc<Pattern>,
    /// Freedom of each pivot.
    pub(super) order: Vec<usize>,
    entries: usize,
    flops: f64,
}

impl Symbolic {
    /// Analyses the pattern of a matrix.
    ///
    /// - `groups`: the node (or any label) of each freedom; those of one label are eliminated together.
    ///
    /// Cost: about the time of one to two numeric factors of a solid, most of it in METIS. Errors: `groups` of
    /// another length, no memory.
    pub fn new(matrix: &SymmetricMatrix, groups: &[u32], ordering: Ordering) -> Result<Self, FemError> {
        let size = matrix.size();
        let order = ordering::permutation(matrix, groups, ordering)?;
        let mut place = vec![0; size];
        for (i, &freedom) in order.iter().enumerate() {
            place[freedom] = i;
        }
        let memory = |_| FemError::Memory { what: "the pattern of the factor", size };
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, matrix.starts(), None, matrix.rows());
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let permutation = PermRef::new_checked(&order, &place, size);
        let inner =
            factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Custom(permutation), params)
                .map_err(memory)?;
        let mut this = Self { inner, pattern: matrix.pattern.clone(), order, entries: 0, flops: 0.0 };
        (this.entries, this.flops) = this.count();
        Ok(this)
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.order.len()
    }

    /// Entries of the factor: lower triangle, explicit zeros of merged supernodes included.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// Floating-point operations of a numeric factor, $\sum_j \ell_j^2$ with $\ell_j$ entries in column $j$.
    pub fn flops(&self) -> f64 {
        self.flops
    }

    /// Bytes that the values of a factor take.
    pub fn factor_bytes(&self) -> usize {
        size_of::<f64>() * self.inner.len_val()
    }

    /// Supernodes; none for a matrix without rows.
    pub(super) fn supernodes(&self) -> Option<&SymbolicSupernodalCholesky<usize>> {
        match self.inner.raw() {
            SymbolicCholeskyRaw::Supernodal(supernodes) => Some(supernodes),
            SymbolicCholeskyRaw::Simplicial(_) => None,
        }
    }

    fn count(&self) -> (usize, f64) {
        let (mut entries, mut flops) = (0, 0.0);
        if let Some(supernodes) = self.supernodes() {
            for s in 0..supernodes.n_supernodes() {
                let columns = supernodes.supernode_end()[s] - supernodes.supernode_begin()[s];
                let below = supernodes.supernode(s).pattern().len();
                for own in 1..=columns {
                    entries += own + below;
                    flops += ((own + below) as f64).powi(2);
                }
            }
        }
        (entries, flops)
    }

    /// Place in the values of a factor of the diagonal entry of each pivot, in the order of elimination.
    pub(super) fn diagonal_places(&self) -> impl Iterator<Item = usize> + '_ {
        self.supernodes().into_iter().flat_map(|supernodes| {
            (0..supernodes.n_supernodes()).flat_map(move |s| {
                let columns = supernodes.supernode_end()[s] - supernodes.supernode_begin()[s];
                let stride = columns + supernodes.supernode(s).pattern().len() + 1;
                let first = supernodes.col_ptr_for_val()[s];
                (0..columns).map(move |j| first + j * stride)
            })
        })
    }
}
