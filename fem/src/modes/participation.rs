//! Participation of modes in rigid motions of the base.

use super::Modes;
use crate::FemError;
use crate::sparse::SymmetricMatrix;

/// A motion of the base: its momentum and its mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    name: String,
    momentum: Vec<f64>,
    mass: f64,
}

impl Direction {
    /// Direction of the influence vector $r$: the displacement of the freedoms when the base moves by one unit
    /// (1 m or 1 rad). Momentum $M r$, mass $r^T M r$ in kg or kg m².
    ///
    /// Errors: `r` of another length than the mass matrix.
    pub fn new(name: &str, mass: &SymmetricMatrix, r: &[f64]) -> Result<Self, FemError> {
        let expected = mass.size();
        if r.len() != expected {
            return Err(FemError::Length { what: "influence vector", found: r.len(), expected });
        }
        let mut momentum = vec![0.0; expected];
        mass.multiply(r, &mut momentum);
        let total = momentum.iter().zip(r).map(|(p, r)| p * r).sum();
        Ok(Self { name: name.into(), momentum, mass: total })
    }

    /// Direction with the momentum of the free freedoms, mass that the fixed ones share with them included,
    /// and the total mass, of which shares are taken.
    pub fn of_momentum(name: &str, momentum: Vec<f64>, mass: f64) -> Self {
        Self { name: name.into(), momentum, mass }
    }

    /// Name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Momentum $M r$.
    pub fn momentum(&self) -> &[f64] {
        &self.momentum
    }

    /// Mass $r^T M r$, kg or kg m².
    pub fn mass(&self) -> f64 {
        self.mass
    }
}

/// Participation of each mode in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Participation {
    /// Factors $\Gamma_i = \phi_i^T M r$, √kg (or √kg m).
    pub factor: Vec<f64>,
    /// Effective masses $\Gamma_i^2$, kg (or kg m²).
    pub effective_mass: Vec<f64>,
    /// Shares $\Gamma_i^2 / r^T M r$.
    pub share: Vec<f64>,
    /// Sums of the shares of this mode and all before it; at most 1.
    pub cumulative: Vec<f64>,
}

impl Modes {
    /// Participation in a motion of the base.
    ///
    /// Errors: a momentum of another length than a shape.
    pub fn participation(&self, direction: &Direction) -> Result<Participation, FemError> {
        let (found, expected) = (direction.momentum.len(), self.size());
        if found != expected {
            return Err(FemError::Length { what: "momentum", found, expected });
        }
        let factor: Vec<f64> = (0..self.len())
            .map(|i| self.shape(i).iter().zip(&direction.momentum).map(|(s, p)| s * p).sum())
            .collect();
        let effective_mass: Vec<f64> = factor.iter().map(|f| f * f).collect();
        let share: Vec<f64> = effective_mass
            .iter()
            .map(|m| if direction.mass > 0.0 { m / direction.mass } else { 0.0 })
            .collect();
        let cumulative = share
            .iter()
            .scan(0.0, |sum, s| {
                *sum += s;
                Some(*sum)
            })
            .collect();
        Ok(Participation { factor, effective_mass, share, cumulative })
    }
}
