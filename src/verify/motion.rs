//! Cases with an accelerogram: peak motion and deconvolution.

use super::fixtures::{THREE_LAYERS, UNIFORM, accelerogram, scene_with, simulate};
use super::{CaseResult, Check, twist};
use crate::closed_form::{Law, surface_ratios};
use crate::spectrum::filtered;
use hati_sem::soil::Profile;

/// Motion at the surface by multiplying the spectrum with the closed form: the reference of a time loop.
fn by_spectrum(a: &[f64], dt: f64, profile: &Profile) -> Vec<f64> {
    filtered(a, dt, 60.0, |f| surface_ratios(profile, 0, Law::Causal, 0.0, f).outcrop)
}

fn peak(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Surface PGA of an accelerogram through the uniform undamped and the damped layered column, against
/// the spectrum times the closed form. Twist: the size of the record.
pub(super) fn surface_pga(twisted: bool) -> CaseResult {
    const LIMIT: f64 = 3e-3;
    let mut checks = vec![];
    for (name, soil) in [("uniform undamped", UNIFORM), ("three damped layers", THREE_LAYERS)] {
        let scene = scene_with(soil, "outcrop", 1e-3, "", "")?;
        let (plan, simulation) = simulate(&scene, accelerogram(0.01, 20.0), 0.01)?;
        let input = simulation.drive.acceleration[0].clone().unwrap_or_default();
        let exact = by_spectrum(&input, plan.sample_dt, &plan.profile);
        let surface = &simulation.recorder.traces[0].acceleration;
        let reference = twist(twisted, LIMIT) * peak(&exact);
        checks.push(Check::relative(
            "surface-pga",
            format!("PGA, m/s², {name}"),
            peak(surface),
            reference,
            LIMIT,
        ));
    }
    Ok(checks)
}

/// A surface record goes down by deconvolution and up by the time loop: it must come back. Twist: the
/// size of the record.
pub(super) fn deconvolution(twisted: bool) -> CaseResult {
    const LIMIT: f64 = 1e-3;
    let mut checks = vec![];
    let rigid = THREE_LAYERS.replace("kind = \"elastic\"\nvs = 800.0\nrho = 2200.0", "kind = \"rigid\"");
    for (name, soil) in [("elastic base", THREE_LAYERS), ("rigid base", rigid.as_str())] {
        let scene = scene_with(soil, "surface", 1e-2, "", "")?;
        let (plan, simulation) = simulate(&scene, accelerogram(0.01, 20.0), 0.01)?;
        let given = plan.input.motion.components[0].clone().unwrap_or_default();
        let surface = &simulation.recorder.traces[0].acceleration;
        let t = twist(twisted, LIMIT);
        let (mut wrong, mut right) = (0.0, 0.0);
        for (a, b) in surface.iter().zip(&given) {
            wrong += (a - b * t).powi(2);
            right += b * b;
        }
        let error = (wrong / right).sqrt();
        checks.push(Check::error(
            "deconvolution",
            format!("surface record back, relative L2, {name}"),
            error,
            LIMIT,
        ));
    }
    Ok(checks)
}
