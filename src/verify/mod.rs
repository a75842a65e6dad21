//! Built-in cases against closed forms and references, each with a limit, and a check of the checks.
//!
//! A case computes values and compares them with references that do not come from the same code. Every
//! case takes a `twist`: 0 to verify, and in the self-check three times its limit, by which it changes
//! one of its constants (named in the case); a case that still passes then is blind.

mod accuracy;
mod fixtures;
mod frequency;
mod matching;
mod measures;
mod motion;
mod pair;
mod solid;
mod stepping;
mod waves;

use crate::run::RunError;
use serde::Serialize;
use std::fmt;

pub use fixtures::{accelerogram, scene_with, simulate};
pub use pair::{pair_profile, surface_from_within};
pub use solid::{manufactured_error, manufactured_sizes, realised_error};
pub use stepping::standing_wave_error;
pub use waves::{
    Footprint, LAMB_DISTANCES, LOH1_RATE, LambModel, LambRecord, Loh1Model, Loh1Record, lamb_closed_form,
    loh1_reference,
};

/// One compared quantity.
#[derive(Debug, Clone, Serialize)]
pub struct Check {
    /// Name of the case.
    pub case: &'static str,
    /// What was compared.
    pub quantity: String,
    /// Found.
    pub value: f64,
    /// Expected.
    pub reference: f64,
    /// Error in the norm that the quantity names.
    pub error: f64,
    /// Largest error allowed.
    pub limit: f64,
    /// Whether it holds.
    pub pass: bool,
}

impl Check {
    /// Relative error of a value against a reference.
    fn relative(
        case: &'static str,
        quantity: impl Into<String>,
        value: f64,
        reference: f64,
        limit: f64,
    ) -> Self {
        let error = (value / reference - 1.0).abs();
        Self { case, quantity: quantity.into(), value, reference, error, limit, pass: error <= limit }
    }

    /// An error by itself, which should be 0.
    fn error(case: &'static str, quantity: impl Into<String>, error: f64, limit: f64) -> Self {
        Self {
            case,
            quantity: quantity.into(),
            value: error,
            reference: 0.0,
            error,
            limit,
            pass: error <= limit,
        }
    }
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.pass { "ok  " } else { "FAIL" };
        write!(
            f,
            "{word} {:<20} {}: {:.6e} against {:.6e}, error {:.2e} (limit {:.1e})",
            self.case, self.quantity, self.value, self.reference, self.error, self.limit
        )
    }
}

/// What can keep a case from being computed.
type CaseResult = Result<Vec<Check>, RunError>;

struct Case {
    name: &'static str,
    long: bool,
    run: fn(bool) -> CaseResult,
}

/// All cases; `long` ones run only when asked for.
const CASES: &[Case] = &[
    Case { name: "uniform-layer", long: false, run: frequency::uniform_layer },
    Case { name: "three-layer-table", long: false, run: frequency::three_layer_table },
    Case { name: "three-layer-column", long: false, run: frequency::three_layer_column },
    Case { name: "damping-fit", long: false, run: frequency::damping_fit },
    Case { name: "standing-wave", long: false, run: stepping::standing_wave },
    Case { name: "step-bound", long: false, run: stepping::step_bound },
    Case { name: "energy-ledger", long: false, run: stepping::energy_ledger },
    Case { name: "borehole-pair", long: false, run: pair::borehole_pair },
    Case { name: "surface-pga", long: false, run: motion::surface_pga },
    Case { name: "deconvolution", long: false, run: motion::deconvolution },
    Case { name: "spectra", long: false, run: measures::spectra },
    Case { name: "intensity", long: false, run: measures::intensity },
    Case { name: "matching", long: false, run: matching::matching },
    Case { name: "accuracy", long: false, run: accuracy::accuracy },
    Case { name: "accuracy-kinds", long: false, run: accuracy::accuracy_kinds },
    Case { name: "manufactured", long: false, run: solid::manufactured },
    Case { name: "dispersion", long: false, run: solid::plane_waves },
    Case { name: "attenuation", long: false, run: solid::attenuation },
    Case { name: "attenuation-coarse", long: false, run: solid::attenuation_coarse },
    Case { name: "solid-step-bound", long: false, run: solid::solid_step_bound },
    Case { name: "lamb", long: false, run: waves::lamb },
    Case { name: "lamb-fine", long: true, run: waves::lamb_fine },
    Case { name: "lamb-chart", long: true, run: waves::lamb_chart },
    Case { name: "loh1", long: true, run: waves::loh1 },
    Case { name: "step-bound-million", long: true, run: stepping::step_bound_million },
];

/// A figure of a case with the numbers behind it.
#[derive(Debug, Clone)]
pub struct CaseFigure {
    /// Name of its file, without ending.
    pub name: &'static str,
    /// The drawing.
    pub svg: String,
    /// The numbers: name of a CSV file, without ending, and its text, with a line of names.
    pub tables: Vec<(&'static str, String)>,
}

/// Draws a case's figure.
type Draw = fn() -> Result<CaseFigure, RunError>;

/// Cases that have a figure, and how it is made.
const FIGURES: &[(&str, Draw)] = &[
    ("dispersion", solid::dispersion_chart),
    ("attenuation-coarse", solid::coarse_chart),
    ("lamb-chart", waves::cost_chart),
];

/// Figures of the wanted cases; those of long ones only when asked for.
pub fn figures(wanted: &dyn Fn(&str) -> bool, long: bool) -> Result<Vec<CaseFigure>, RunError> {
    let runs = |name: &str| CASES.iter().any(|c| c.name == name && (long || !c.long));
    let drawn = FIGURES.iter().filter(|(case, _)| wanted(case) && runs(case));
    drawn.map(|(_, figure)| figure()).collect()
}

/// Names of all cases.
pub fn names() -> Vec<&'static str> {
    CASES.iter().map(|c| c.name).collect()
}

fn each(
    wanted: &dyn Fn(&str) -> bool,
    long: bool,
    twisted: bool,
    told: &mut dyn FnMut(&Check),
) -> Result<Vec<Check>, RunError> {
    let mut all = vec![];
    for case in CASES.iter().filter(|c| wanted(c.name) && (long || !c.long)) {
        for check in (case.run)(twisted)? {
            told(&check);
            all.push(check);
        }
    }
    Ok(all)
}

/// Runs the wanted cases; `told` hears of each quantity as it is compared.
pub fn verify(
    wanted: &dyn Fn(&str) -> bool,
    long: bool,
    told: &mut dyn FnMut(&Check),
) -> Result<Vec<Check>, RunError> {
    each(wanted, long, false, told)
}

/// Runs the wanted cases with one constant of each changed by three times its limit; every quantity
/// should now fail.
pub fn self_check(
    wanted: &dyn Fn(&str) -> bool,
    long: bool,
    told: &mut dyn FnMut(&Check),
) -> Result<Vec<Check>, RunError> {
    each(wanted, long, true, told)
}

/// Factor by which a case twists a constant: 1, or 1 + 3 × limit in the self-check.
fn twist(twisted: bool, limit: f64) -> f64 {
    if twisted { 1.0 + 3.0 * limit } else { 1.0 }
}
