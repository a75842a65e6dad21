//! The energy ledger: every line summed from its own forces and velocities, none by difference.

use serde::{Deserialize, Serialize};

/// Energies of a subdomain at the end of a step, J (J/m² for a column of unit plan area).
///
/// `input`, `viscous` and `outflow` are cumulative from the start of the run; the discrete balance is
/// `input + initial = kinetic + strain + viscous + outflow`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Energy received: incident waves, imposed motion, applied forces.
    pub input: f64,
    /// Kinetic energy.
    pub kinetic: f64,
    /// Strain energy, that of memory variables included.
    pub strain: f64,
    /// Dissipated inside (viscosity, memory variables).
    pub viscous: f64,
    /// Carried out through boundaries.
    pub outflow: f64,
}

impl Energies {
    /// Kinetic and strain energy together.
    pub fn stored(&self) -> f64 {
        self.kinetic + self.strain
    }

    /// What the balance leaves over: `input − stored − viscous − outflow`.
    pub fn residual(&self) -> f64 {
        self.input - self.stored() - self.viscous - self.outflow
    }
}

/// Follows the balance of a run and keeps its closing error.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Ledger {
    initial: f64,
    residual_max: f64,
    scale_max: f64,
    /// Largest stored energy met.
    pub stored_max: f64,
    /// The latest entry.
    pub last: Energies,
}

impl Ledger {
    /// A ledger that starts from the given energies (their residual is the initial store).
    pub fn start(energies: &Energies) -> Self {
        let mut ledger = Self { initial: energies.residual(), ..Self::default() };
        ledger.book(energies);
        ledger
    }

    /// Enters the energies of one instant; returns the residual.
    pub fn book(&mut self, energies: &Energies) -> f64 {
        let residual = energies.residual() - self.initial;
        // `max` would swallow a NaN, and a NaN is the one thing a ledger must not lose
        let keep = |old: f64, new: f64| if new <= old { old } else { new };
        self.residual_max = keep(self.residual_max, residual.abs());
        self.scale_max = keep(self.scale_max, energies.input.abs() + energies.stored().abs());
        self.stored_max = keep(self.stored_max, energies.stored());
        self.last = *energies;
        residual
    }

    /// Closing error $\max_t|\mathrm{residual}| / \max_t(|\mathrm{input}| + \mathrm{stored})$; 0 for a run at rest.
    pub fn closing_error(&self) -> f64 {
        if self.scale_max == 0.0 { 0.0 } else { self.residual_max / self.scale_max }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_loss_shows_in_the_closing_error() {
        let mut ledger = Ledger::start(&Energies::default());
        ledger.book(&Energies { input: 2.0, kinetic: 1.0, strain: 0.5, viscous: 0.5, outflow: 0.0 });
        assert_eq!(ledger.closing_error(), 0.0);
        ledger.book(&Energies { input: 2.0, kinetic: 1.0, strain: 0.5, viscous: 0.4, outflow: 0.0 });
        assert!((ledger.closing_error() - 0.1 / 3.5).abs() < 1e-15);
    }

    #[test]
    fn nan_is_not_swallowed() {
        let mut ledger = Ledger::start(&Energies::default());
        ledger.book(&Energies { input: f64::NAN, ..Energies::default() });
        assert!(ledger.closing_error().is_nan());
    }
}
