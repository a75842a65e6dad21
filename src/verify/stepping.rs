//! Cases of the time loop itself: convergence, the step's limit, the energy ledger.

use super::fixtures::{THREE_LAYERS, accelerogram, scene_with, simulate};
use super::{CaseResult, Check, twist};
use crate::run::RunError;
use hati_coupling::{Energies, Ledger, Subdomain};
use hati_sem::SemError;
use hati_sem::attenuation::MaxwellArms;
use hati_sem::column::{BaseMotion, Column, Discretisation};
use hati_sem::soil::{Base, Layer, Profile};
use std::f64::consts::PI;

/// Relative L2 error over depth, largest over a period, of the standing wave cos(kd)·cos(ωt) on a
/// fixed base, three quarter-waves in 10 m.
///
/// - `exact_in_time`: compare with cos ωt; otherwise with cos ω̃t, ω̃ = (2/Δt) arcsin(ωΔt/2), which the
///   central difference follows exactly, so that only the error in space is left;
/// - `k_factor`: factor on the wave number of the exact solution (1).
pub fn standing_wave_error(
    order: usize,
    elements: usize,
    steps_per_period: usize,
    exact_in_time: bool,
    k_factor: f64,
) -> Result<f64, SemError> {
    let (h, c) = (10.0, 100.0);
    let layer = Layer {
        name: "soil".into(),
        thickness: h,
        vs: c,
        vp: 2.0 * c,
        rho: 2000.0,
        damping_s: 0.0,
        damping_p: 0.0,
    };
    let profile = Profile { layers: vec![layer], base: Base::Rigid, reference_frequency: 1.0 };
    let k = 1.5 * PI / h;
    let omega = k * c;
    let dt = 2.0 * PI / omega / steps_per_period as f64;
    let seen = if exact_in_time { omega } else { 2.0 / dt * (0.5 * omega * dt).asin() };
    let mesh = Discretisation { order, elements: vec![elements] };
    let elastic = vec![[MaxwellArms::elastic(), MaxwellArms::elastic(), MaxwellArms::elastic()]];
    let still = Some(BaseMotion::Imposed(vec![0.0]));
    let mut column = Column::new(&profile, &mesh, &elastic, dt, [still, None, None])?;
    // positions at kicks −1 and 0 are cos(−ω̃Δt) and 1: their mean and slope hold half-way
    let (before, at) = ((seen * dt).cos(), 1.0);
    column.set_motion(0, |d| ((k * d).cos() * 0.5 * (before + at), (k * d).cos() * (at - before) / dt));
    let gauss = [-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683, 0.906179845938664];
    let weight =
        [0.236926885056189, 0.478628670499366, 0.568888888888889, 0.478628670499366, 0.236926885056189];
    let cells = elements * 4;
    let width = h / cells as f64;
    let probes = (0..cells)
        .flat_map(|i| gauss.map(|g| (i as f64 + 0.5 + 0.5 * g) * width))
        .map(|d| column.mesh().probe(d))
        .collect::<Result<Vec<_>, _>>()?;
    let k = k * k_factor;
    let mut worst = 0.0_f64;
    for step in 0..steps_per_period {
        column.step();
        if step % (steps_per_period / 8) != 0 {
            continue;
        }
        let time = (seen * step as f64 * dt).cos();
        let sum: f64 = (probes.iter().enumerate())
            .map(|(i, p)| {
                let e = column.motion_at(p, 0).displacement - (k * p.depth).cos() * time;
                0.5 * width * weight[i % 5] * e * e
            })
            .sum();
        worst = worst.max((sum / (0.5 * h)).sqrt());
    }
    Ok(worst)
}

/// Orders in h and Δt and spectral convergence. Twist: the wave number of the exact solution.
pub(super) fn standing_wave(twisted: bool) -> CaseResult {
    const CASE: &str = "standing-wave";
    const ORDER_LIMIT: f64 = 0.1;
    const STEP_LIMIT: f64 = 0.02;
    const SPECTRAL_LIMIT: f64 = 1e-10;
    let mut checks = vec![];
    let absolute = |quantity: String, value: f64, reference: f64, limit: f64| {
        let error = (value - reference).abs();
        Check { case: CASE, quantity, value, reference, error, limit, pass: error <= limit }
    };
    let k = twist(twisted, ORDER_LIMIT);
    for order in 1..=8 {
        let elements = if order <= 2 {
            16
        } else if order <= 5 {
            8
        } else {
            4
        };
        let coarse = standing_wave_error(order, elements, 400 * elements, false, k)?;
        let fine = standing_wave_error(order, 2 * elements, 800 * elements, false, k)?;
        let observed = (coarse / fine).log2();
        checks.push(absolute(
            format!("order in h, L2, N = {order}"),
            observed,
            order as f64 + 1.0,
            ORDER_LIMIT,
        ));
    }
    let spectral = standing_wave_error(10, 3, 2000, false, twist(twisted, SPECTRAL_LIMIT))?;
    checks.push(Check::error(CASE, "L2 error at N = 10, 3 elements", spectral, SPECTRAL_LIMIT));
    let k = twist(twisted, STEP_LIMIT);
    let coarse = standing_wave_error(9, 3, 800, true, k)?;
    let fine = standing_wave_error(9, 3, 1600, true, k)?;
    checks.push(absolute("order in Δt".into(), (coarse / fine).log2(), 2.0, STEP_LIMIT));
    Ok(checks)
}

/// The three layers as a profile, with or without damping.
fn three_layers(damped: bool) -> Result<Profile, RunError> {
    let scene = scene_with(THREE_LAYERS, "outcrop", 0.3, "band = [0.2, 20.0]", "")?;
    let layers = (scene.layers().into_iter())
        .map(|l| {
            let d = if damped { l.damping } else { 0.0 };
            Layer {
                name: l.name,
                thickness: l.thickness,
                vs: l.vs,
                vp: l.vp,
                rho: l.rho,
                damping_s: d,
                damping_p: d,
            }
        })
        .collect();
    Ok(Profile {
        layers,
        base: Base::Elastic { vs: 800.0, vp: 1400.0, rho: 2200.0 },
        reference_frequency: 2.0,
    })
}

/// Largest velocity after `steps` at `factor` times the computed limit, from a rough start.
fn growth(order: usize, damped: bool, factor: f64, steps: usize) -> Result<f64, RunError> {
    let profile = three_layers(damped)?;
    let mesh = Discretisation { order, elements: vec![1, 2, 2] };
    let arms = crate::plan::fit_arms(&profile, (0.2, 20.0), 4)?;
    let limit = Column::critical_step(&profile, &mesh, &arms, &[0], false)?.0;
    let rough: Vec<f64> = (0..100).map(|i| ((i * 7919) % 13) as f64 - 6.0).collect();
    let motion = [Some(BaseMotion::Outcrop(rough)), None, None];
    let mut column = Column::new(&profile, &mesh, &arms, factor * limit, motion)?;
    for _ in 0..steps {
        column.step();
    }
    Ok(column.fastest_point().0)
}

/// Velocities that the rough start of [`growth`] cannot reach while stable, m/s.
const BOUNDED: f64 = 1e3;

fn bounds(
    case: &'static str,
    orders: std::ops::RangeInclusive<usize>,
    steps: usize,
    twisted: bool,
) -> CaseResult {
    const LIMIT: f64 = 1e-2;
    let twist = twist(twisted, LIMIT);
    let mut checks = vec![];
    for order in orders {
        for damped in [false, true] {
            let word = if damped { "damped" } else { "undamped" };
            let below = growth(order, damped, 0.999 * twist, steps)?;
            let above = growth(order, damped, 1.01 / twist, 20_000)?;
            let check = |quantity: String, value: f64, pass: bool| {
                let error = if pass { 0.0 } else { f64::INFINITY };
                Check { case, quantity, value, reference: BOUNDED, error, limit: LIMIT, pass }
            };
            checks.push(check(
                format!("N = {order}, {word}: m/s after {steps} steps at 0.999 of the limit stays below"),
                below,
                below < BOUNDED,
            ));
            let grew = above.is_nan() || above > BOUNDED;
            checks.push(check(
                format!("N = {order}, {word}: m/s at 1.01 of the limit grows above"),
                above,
                grew,
            ));
        }
    }
    Ok(checks)
}

/// Both sides of the critical step. Twist: the critical step.
pub(super) fn step_bound(twisted: bool) -> CaseResult {
    bounds("step-bound", 1..=10, 20_000, twisted)
}

/// The same below the limit through a million steps.
pub(super) fn step_bound_million(twisted: bool) -> CaseResult {
    bounds("step-bound-million", 4..=6, 1_000_000, twisted)
}

/// Closing error of the ledger, elastic and damped. Twist: the input line.
pub(super) fn energy_ledger(twisted: bool) -> CaseResult {
    let mut checks = vec![];
    for (name, limit) in [("elastic", 1e-10), ("damped", 1e-6)] {
        let soil = if name == "damped" { THREE_LAYERS.to_string() } else { undamped(THREE_LAYERS) };
        let scene = scene_with(&soil, "outcrop", 1e-2, "", "")?;
        let (_, simulation) = simulate(&scene, accelerogram(0.01, 20.0), 0.01)?;
        let mut ledger = Ledger::start(&Energies::default());
        for row in &simulation.recorder.ledger_rows {
            ledger.book(&Energies {
                input: row.input * twist(twisted, limit),
                kinetic: row.kinetic,
                strain: row.strain,
                viscous: row.viscous,
                outflow: row.outflow,
            });
        }
        checks.push(Check::error(
            "energy-ledger",
            format!("closing error, {name}"),
            ledger.closing_error(),
            limit,
        ));
    }
    Ok(checks)
}

fn undamped(soil: &str) -> String {
    soil.lines().filter(|l| !l.starts_with("damping")).collect::<Vec<_>>().join("\n")
}
