//! A motion matched to a design spectrum.

use super::fixtures::accelerogram;
use super::{CaseResult, Check, twist};
use crate::plan::PlanError;
use hati_inputs::measures::{DesignSpectrum, log_periods, response_spectrum};
use hati_inputs::motion::{Matching, Motion, Quantity, integrate};
use serde_json::json;

/// Horizontal spectrum of Regulatory Guide 1.60 for 5 %, 0.02 to 10 s, by an accelerogram of 40 s: every one of 400
/// periods within ±10 %, and the ground at rest in the end. Twist: the spectrum compared with, and a
/// velocity left over.
pub(super) fn matching(twisted: bool) -> CaseResult {
    const CASE: &str = "matching";
    const LIMIT: f64 = 0.1;
    const REST: f64 = 1e-10;
    const PGA: f64 = 2.0;
    let spectrum = |pga: f64| -> DesignSpectrum {
        serde_json::from_value(json!({ "kind": "rg160", "pga": pga })).expect("its own format")
    };
    let (dt, seed) = (0.01, accelerogram(0.01, 40.0));
    let mut motion =
        Motion::new(dt, None, Quantity::Acceleration, [Some(seed), None, None]).map_err(PlanError::from)?;
    Matching::to(spectrum(PGA)).apply(&mut motion).map_err(PlanError::from)?;
    let a = motion.components[0].clone().unwrap_or_default();

    let target = spectrum(PGA * twist(twisted, LIMIT));
    let periods = log_periods(0.02, 10.0, 400);
    let found = response_spectrum(&a, motion.dt, &periods, target.damping());
    let ratios = periods.iter().zip(&found.psa).map(|(t, psa)| psa / target.psa(*t));
    let (low, high) = ratios.fold((f64::INFINITY, 0.0_f64), |(low, high), r| (low.min(r), high.max(r)));
    let velocity = integrate(&a, motion.dt);
    let peak = velocity.iter().fold(0.0_f64, |peak, v| peak.max(v.abs()));
    let left = if twisted { 3.0 * REST } else { 0.0 };
    let last = velocity.last().copied().unwrap_or(f64::NAN).abs() / peak + left;
    let correlation = motion.steps.last().and_then(|step| step.found.get("x")?.get("correlation")?.as_f64());
    let correlation = correlation.unwrap_or(f64::NAN);
    let worst = if 1.0 - low > high - 1.0 { low } else { high };
    let quantity =
        format!("RG 1.60 5 %, worst PSA/target, 0.02–10 s (correlation with the seed {correlation:.2})");
    Ok(vec![
        Check::relative(CASE, quantity, worst, 1.0, LIMIT),
        Check::error(CASE, "last velocity over largest", last, REST),
    ])
}
