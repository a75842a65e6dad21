//! The pencil $K - \sigma M$: one pattern, factors for any shift.

use crate::FemError;
use crate::sparse::{Factor, Ordering, Symbolic, SymmetricMatrix};
use std::sync::Arc;

pub(super) struct Pencil<'a> {
    pub(super) stiffness: &'a SymmetricMatrix,
    pub(super) mass: &'a SymmetricMatrix,
    /// Both on the union of their patterns.
    wide: [SymmetricMatrix; 2],
    symbolic: Arc<Symbolic>,
    threads: usize,
    /// The factor of the last count, renewed for the next.
    counter: Option<Factor>,
}

impl<'a> Pencil<'a> {
    pub(super) fn new(
        stiffness: &'a SymmetricMatrix,
        mass: &'a SymmetricMatrix,
        groups: &[u32],
        threads: usize,
    ) -> Result<Self, FemError> {
        let k = SymmetricMatrix::combine(1.0, stiffness, 0.0, mass)?;
        let m = SymmetricMatrix::combine(0.0, &k, 1.0, mass)?;
        let symbolic = Arc::new(Symbolic::new(&k, groups, Ordering::default())?);
        Ok(Self { stiffness, mass, wide: [k, m], symbolic, threads, counter: None })
    }

    fn shifted(&self, shift: f64) -> Result<SymmetricMatrix, FemError> {
        SymmetricMatrix::combine(1.0, &self.wide[0], -shift, &self.wide[1])
    }

    /// A shift at or below all eigenvalues and the factor there: zero if the structure is held; else negative
    /// and small beside the scale of the spectrum.
    pub(super) fn below_all(&self, free: bool) -> Result<(f64, Factor), FemError> {
        if !free {
            match Factor::definite(&self.symbolic, &self.wide[0], self.threads) {
                Err(FemError::Pivot { .. }) => {}
                other => return Ok((0.0, other?)),
            }
        }
        let mut shift = -1e-7 * self.scale();
        let mut result = Factor::definite(&self.symbolic, &self.shifted(shift)?, self.threads);
        for _ in 0..2 {
            if let Err(FemError::Pivot { .. }) = result {
                shift *= 100.0;
                result = Factor::definite(&self.symbolic, &self.shifted(shift)?, self.threads);
            }
        }
        Ok((shift, result?))
    }

    /// Indefinite factor at a shift within the spectrum.
    pub(super) fn at(&self, shift: f64) -> Result<Factor, FemError> {
        Factor::indefinite(&self.symbolic, &self.shifted(shift)?, self.threads)
    }

    /// Number of eigenvalues below a shift.
    pub(super) fn count(&mut self, shift: f64) -> Result<usize, FemError> {
        let shifted = self.shifted(shift)?;
        let factor = match self.counter.take() {
            Some(mut factor) => {
                factor.renew(&shifted)?;
                factor
            }
            None => Factor::indefinite(&self.symbolic, &shifted, self.threads)?,
        };
        let count = factor.negative_pivots();
        self.counter = Some(factor);
        Ok(count)
    }

    /// Geometric mean of $k_{ii} / m_{ii}$ over the freedoms that have both: between the ends of the spectrum.
    fn scale(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (k, m) in self.stiffness.diagonal().into_iter().zip(self.mass.diagonal()) {
            if k > 0.0 && m > 0.0 {
                sum += (k / m).ln();
                count += 1;
            }
        }
        if count == 0 { 1.0 } else { (sum / f64::from(count)).exp() }
    }
}
