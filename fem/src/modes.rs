//! Natural modes $K \phi = \lambda M \phi$, their participation, and the count that none is missed.
//!
//! [`modes`] finds the lowest ones or all of a band by shifted and inverted block Lanczos; freedoms without
//! mass and free bodies are allowed. The number of eigenvalues below the last one is counted by the signs of
//! the pivots of $K - \sigma M$ (Sturm count): a mode that the iteration missed is searched for again.

mod lanczos;
mod participation;
mod pencil;
mod search;

pub use participation::{Direction, Participation};

use crate::FemError;
use crate::sparse::SymmetricMatrix;
use std::f64::consts::PI;

/// Which modes are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wanted {
    /// So many of the lowest.
    Lowest(usize),
    /// All of a band, Hz; rigid motions belong to a band from 0.
    Band {
        /// Lower end, Hz.
        from: f64,
        /// Upper end, Hz.
        to: f64,
    },
}

/// How modes are searched for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Relative tolerance of $\lambda - \sigma$, see [`Modes::bound`].
    pub tolerance: f64,
    /// Vectors of a block of the iteration.
    pub block: usize,
    /// Threads of factors and solves.
    pub threads: usize,
}

impl Default for Search {
    /// 1e-10, blocks of 6 (a free body has six modes of frequency zero), one thread.
    fn default() -> Self {
        Self { tolerance: 1e-10, block: 6, threads: 1 }
    }
}

/// Modes by increasing frequency, normalised to $\phi_i^T M \phi_j = \delta_{ij}$.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    size: usize,
    value: Vec<f64>,
    shape: Vec<f64>,
    bound: Vec<f64>,
    residual: Vec<f64>,
    shift: f64,
    counted_at: f64,
    solves: usize,
}

impl Modes {
    /// Number of modes.
    pub fn len(&self) -> usize {
        self.value.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.value.is_empty()
    }

    /// Number of freedoms.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Eigenvalues $\lambda = \omega^2$, rad²/s²; about zero, of either sign, for a free motion.
    pub fn values(&self) -> &[f64] {
        &self.value
    }

    /// Frequency of a mode, Hz; zero where round-off made $\lambda$ negative.
    pub fn frequency(&self, mode: usize) -> f64 {
        frequency(self.value[mode])
    }

    /// Shape of a mode, $1/\sqrt{\mathrm{kg}}$; its largest entry (the first of equals) is positive.
    ///
    /// Where several modes share a frequency, any rotation among their shapes is as good.
    pub fn shape(&self, mode: usize) -> &[f64] {
        &self.shape[mode * self.size..(mode + 1) * self.size]
    }

    /// $\|(K - \sigma M)^{-1} (K - \lambda M) \phi\|_M$: an eigenvalue $\mu$ exists with
    /// $|1/(\mu - \sigma) - 1/(\lambda - \sigma)|$ at most this times $1/|\lambda - \sigma|$.
    pub fn bound(&self, mode: usize) -> f64 {
        self.bound[mode]
    }

    /// $\|K \phi - \lambda M \phi\| / (|\lambda - \sigma| \, \|M \phi\|)$, Euclidean norms. Round-off in
    /// $K \phi$ alone gives about $10^{-16}$ times the ratio of the highest eigenvalue to this one.
    pub fn residual(&self, mode: usize) -> f64 {
        self.residual[mode]
    }

    /// Shift $\sigma$ of the search, rad²/s²: zero for a structure that is held, negative for a free one.
    pub fn shift(&self) -> f64 {
        self.shift
    }

    /// Frequency, Hz, below which the number of modes was counted and found to agree.
    pub fn counted_at(&self) -> f64 {
        frequency(self.counted_at)
    }

    /// Solves made, one for each vector.
    pub fn solves(&self) -> usize {
        self.solves
    }

    /// The first `count` of these modes.
    pub fn truncated(mut self, count: usize) -> Self {
        self.value.truncate(count);
        self.shape.truncate(count * self.size);
        self.bound.truncate(count);
        self.residual.truncate(count);
        self
    }
}

/// Natural modes of $K \phi = \lambda M \phi$, with `groups` as in [`crate::sparse::Symbolic::new`].
///
/// $M$ may be singular, $K$ too if no free motion is without mass. Cost: one factor of $K$ (two of a free
/// body), one indefinite factor for the count, and about two to four solves a mode. Memory: two factors and
/// about three vectors a mode.
///
/// Errors: a mechanism without mass or a negative eigenvalue ([`FemError::Pivot`]); more modes asked than
/// exist; a band without extent; a count that does not agree after several searches.
pub fn modes(
    stiffness: &SymmetricMatrix,
    mass: &SymmetricMatrix,
    groups: &[u32],
    wanted: Wanted,
    search: Search,
) -> Result<Modes, FemError> {
    search::run(stiffness, mass, groups, wanted, search)
}

/// Hz of an eigenvalue in rad²/s².
fn frequency(value: f64) -> f64 {
    value.max(0.0).sqrt() / (2.0 * PI)
}
