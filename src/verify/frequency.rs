//! Cases in the frequency domain: transfer functions and the damping law.

use super::fixtures::{THREE_LAYERS, UNIFORM, fourier, ricker, scene_with, simulate};
use super::{CaseResult, Check, twist};
use crate::closed_form::{Law, surface_ratios};
use crate::run::RunError;
use hati_sem::attenuation::MaxwellArms;
use hati_sem::soil::Profile;
use num_complex::Complex64;

/// Complex transfer functions of the time-domain column under a Ricker pulse.
struct Ratios {
    profile: Profile,
    frequency: Vec<f64>,
    outcrop: Vec<Complex64>,
    within: Vec<Complex64>,
}

fn ratios(soil: &str, accuracy: f64, frequency: Vec<f64>, rest: &str) -> Result<Ratios, RunError> {
    let dt = 0.01;
    let scene = scene_with(soil, "outcrop", accuracy, "band = [0.2, 20.0]", rest)?;
    let (plan, simulation) = simulate(&scene, ricker(7.0, 1.0, dt, 2.0), dt)?;
    let find = |place: &str| {
        let trace = simulation.recorder.traces.iter().find(|t| t.place == place);
        trace.map(|t| t.acceleration.as_slice()).unwrap_or_default()
    };
    let input = simulation.drive.acceleration[0].clone().unwrap_or_default();
    let spectrum = |a: &[f64]| -> Vec<Complex64> { frequency.iter().map(|&f| fourier(a, dt, f)).collect() };
    let (surface, within, outcrop) = (spectrum(find("surface")), spectrum(find("within")), spectrum(&input));
    let divide = |below: &[Complex64]| surface.iter().zip(below).map(|(s, b)| s / b).collect();
    Ok(Ratios {
        profile: plan.profile.clone(),
        outcrop: divide(&outcrop),
        within: divide(&within),
        frequency,
    })
}

/// First resonance of an undamped layer, from the time loop: c/(4H) = 2.5 Hz, and its height, the ratio of
/// impedances, ρ_r c_r/(ρ c) = 6.0526. Twist: the layer's thickness and the rock's density.
pub(super) fn uniform_layer(twisted: bool) -> CaseResult {
    const CASE: &str = "uniform-layer";
    const LIMIT: f64 = 3e-3;
    let near: Vec<f64> = (0..=400).map(|i| 2.4 + 0.0005 * i as f64).collect();
    let r = ratios(UNIFORM, 1e-3, near, "")?;
    let (k, peak) =
        r.outcrop.iter().map(|c| c.norm()).enumerate().fold((0, 0.0), |m, c| if c.1 > m.1 { c } else { m });
    let height = 2300.0 * twist(twisted, LIMIT) * 1000.0 / (1900.0 * 200.0);
    let resonance = 200.0 / (4.0 * 20.0 * twist(twisted, LIMIT));
    Ok(vec![
        Check::relative(CASE, "peak of |surface/outcrop|", peak, height, LIMIT),
        Check::relative(CASE, "its frequency, Hz", r.frequency[k], resonance, LIMIT),
    ])
}

/// |surface/outcrop| and |surface/within| under G(1 + 2iD), half-space damped by 0.5 %: every 83rd row
/// of an independent Thomson–Haskell table of this profile (frequency in Hz).
const TABLE: [(f64, f64, f64); 9] = [
    (0.012207, 1.000008, 1.000024),
    (3.051758, 3.426928, 17.10850),
    (6.091309, 2.693018, 3.866006),
    (9.130859, 2.303485, 2.478089),
    (12.170410, 1.274470, 1.398436),
    (15.209961, 1.456789, 1.846546),
    (18.249512, 1.595362, 1.786402),
    (21.289062, 2.183502, 3.649115),
    (24.328613, 2.534772, 5.258208),
];

/// The closed form itself, with the textbooks' law, against an independent table. Twist: the speed of
/// the top layer.
pub(super) fn three_layer_table(twisted: bool) -> CaseResult {
    const LIMIT: f64 = 1e-4;
    let mut profile = ratios(THREE_LAYERS, 0.3, vec![], "")?.profile;
    profile.layers[0].vs *= twist(twisted, LIMIT);
    let mut worst = [(0.0_f64, 0.0, 0.0); 2];
    for (f, outcrop, within) in TABLE {
        let r = surface_ratios(&profile, 0, Law::Hysteretic, 0.005, f);
        for (w, (found, table)) in
            worst.iter_mut().zip([(r.outcrop.norm(), outcrop), (r.within.norm(), within)])
        {
            let error = (found / table - 1.0).abs();
            if error >= w.0 {
                *w = (error, found, table);
            }
        }
    }
    let check = |name: &str, (_, found, table): (f64, f64, f64)| {
        Check::relative(
            "three-layer-table",
            format!("closed form, G(1+2iD), worst |surface/{name}|"),
            found,
            table,
            LIMIT,
        )
    };
    Ok(vec![check("outcrop", worst[0]), check("within", worst[1])])
}

/// The time-domain column, complex, 0.3 to 20 Hz, against the closed form with the causal modulus.
/// Twist: the speed of the middle layer in the closed form.
pub(super) fn three_layer_column(twisted: bool) -> CaseResult {
    const LIMIT: f64 = 1e-2;
    let grid: Vec<f64> = (0..800).map(|i| 0.3 + 19.7 * i as f64 / 799.0).collect();
    let r = ratios(THREE_LAYERS, 1e-4, grid, "[discretisation]\ntail = 12.0")?;
    let mut profile = r.profile.clone();
    profile.layers[1].vs *= twist(twisted, LIMIT);
    let exact: Vec<_> =
        r.frequency.iter().map(|&f| surface_ratios(&profile, 0, Law::Causal, 0.0, f)).collect();
    let check = |name: &str, found: &[Complex64], exact: Vec<Complex64>| {
        let peak = exact.iter().map(|e| e.norm()).fold(0.0, f64::max);
        let (value, reference) = (found.iter().map(|e| e.norm()).fold(0.0, f64::max), peak);
        let error = found.iter().zip(&exact).map(|(f, e)| (f - e).norm()).fold(0.0, f64::max) / peak;
        let quantity = format!("surface/{name}, complex, 0.3–20 Hz, largest error over peak");
        Check {
            case: "three-layer-column",
            quantity,
            value,
            reference,
            error,
            limit: LIMIT,
            pass: error <= LIMIT,
        }
    };
    Ok(vec![
        check("outcrop", &r.outcrop, exact.iter().map(|e| e.outcrop).collect()),
        check("within", &r.within, exact.iter().map(|e| e.within).collect()),
    ])
}

/// Damping ratio of five mechanisms over two decades. Twist: the damping ratio asked for.
pub(super) fn damping_fit(twisted: bool) -> CaseResult {
    const LIMIT: f64 = 5e-3;
    let mut checks = vec![];
    for damping in [0.005, 0.01, 0.02, 0.05, 0.1, 0.2] {
        let arms = MaxwellArms::fit(damping, 2.0, (0.2, 20.0), 5)?;
        let asked = damping * twist(twisted, LIMIT);
        let worst = (0..=2000)
            .map(|i| arms.damping(2.0 * std::f64::consts::PI * 0.2 * 100f64.powf(i as f64 / 2000.0)))
            .max_by(|a, b| (a / asked - 1.0).abs().total_cmp(&(b / asked - 1.0).abs()))
            .unwrap_or(f64::NAN);
        checks.push(Check::relative(
            "damping-fit",
            format!("D = {damping}, worst over 0.2–20 Hz"),
            worst,
            asked,
            LIMIT,
        ));
    }
    Ok(checks)
}
