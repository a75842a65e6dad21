//! Dispersion of plane waves: the table that sizes come from, against closed forms and against the time loop.

use super::bar::{Bar, Wave, unwrapped};
use crate::report::{DispersionCurve, dispersion_figure};
use crate::run::RunError;
use crate::verify::{CaseFigure, CaseResult, Check, twist};
use hati_sem::SemError;
use hati_sem::solid::{Material, Memory, dispersion};
use std::f64::consts::TAU;

/// Leading term of the phase error per wavelength, $\dfrac{1}{2N(2N+1)}\left[\dfrac{N!}{(2N)!}\right]^2 (kh)^{2N}$
/// (Ainsworth & Wajid 2009), waves too slow.
fn leading_term(order: usize, points: f64) -> f64 {
    let n = order as f64;
    let factorials: f64 = (order + 1..=2 * order).map(|i| i as f64).product();
    let kh = TAU * n / points;
    kh.powi(2 * order as i32) / (factorials * factorials) / (2.0 * n * (2.0 * n + 1.0))
}

/// Phase error over its leading term, extrapolated from two sizes, and 1.
fn leading(order: usize) -> Result<(f64, f64), SemError> {
    let ratio = |error: f64| -> Result<(f64, f64), SemError> {
        let points = dispersion::points_per_wavelength(order, error)?;
        Ok((
            points * points,
            (1.0 - dispersion::phase_speed(order, points, 0.0)?) / leading_term(order, points),
        ))
    };
    // small enough that one more term is enough, large enough for the digits of f64
    let error = if order < 5 { 1e-8 } else { 1e-9 };
    let ((p, coarse), (q, fine)) = (ratio(error)?, ratio(0.1 * error)?);
    Ok(((q * fine - p * coarse) / (q - p), 1.0))
}

/// Phase lost over `wavelengths` by a wave in the time loop, and what the eigenproblem says, in cycles.
///
/// `points` per wavelength at 10 Hz; `part` is the step over its limit.
fn lag(wave: Wave, order: usize, points: f64, part: f64, wavelengths: usize) -> Result<(f64, f64), SemError> {
    let (vp, vs, f) = (400.0, 200.0, 10.0);
    let speed = if wave == Wave::P { vp } else { vs };
    let size = order as f64 * speed / (points * f);
    let between = (wavelengths as f64 * speed / f / size).ceil() as usize;
    let bar = Bar {
        dimension: 2,
        wave,
        order,
        size,
        speed,
        centre: f,
        // a bell of 4 periods keeps clear of gaps 30 % away, one of 6 of those 18 % away
        bell: if order > 6 { 6.0 } else { 4.0 },
        part,
        near: 2,
        between,
        material: Material::elastic("soil", 1900.0, vp, vs),
        memory: Memory::Full,
    };
    let courant = speed * bar.dt()? / size;
    let distance = between as f64 * size / (speed / f);
    let found = unwrapped(bar.transfer(&[f])?[0].arg(), -TAU * distance) / -TAU;
    // the wave of this frequency, not of this length: k = ω/(c r(k))
    let mut shorter = 1.0;
    for _ in 0..20 {
        shorter = 1.0 / dispersion::phase_speed(order, points / shorter, courant)?;
    }
    Ok((found - distance, distance * (shorter - 1.0)))
}

/// Phase error of plane waves: the eigenproblem of one element against the closed form of its leading term, the step's
/// closed form, and waves that have run twelve wavelengths in the time loop. Twist: the closed forms, the lag predicted.
pub(in crate::verify) fn plane_waves(twisted: bool) -> CaseResult {
    const CASE: &str = "dispersion";
    const LEADING: f64 = 2e-2;
    const LAG: f64 = 1e-6;
    let mut checks = vec![];
    for order in 2..=8 {
        let (one, exact) = leading(order)?;
        let quantity =
            format!("N = {order}: phase error per wavelength over its leading term, towards no size");
        checks.push(Check::relative(CASE, quantity, one, exact * twist(twisted, LEADING), LEADING));
    }
    // far from the gaps, p = 2N/m, which let nothing through at that very frequency
    for (wave, order, points, part) in [
        (Wave::P, 2, 10.0, 0.2),
        (Wave::Sv, 2, 10.0, 0.9),
        (Wave::Sh, 3, 4.3, 0.3),
        (Wave::P, 4, 5.6, 0.2),
        (Wave::Sv, 4, 5.6, 0.5),
        (Wave::Sh, 5, 7.0, 0.4),
        (Wave::P, 6, 8.4, 0.9),
        (Wave::Sv, 8, 6.5, 0.6),
    ] {
        let (found, predicted) = lag(wave, order, points, part, 12)?;
        let quantity = format!(
            "{}, N = {order}, {points} points, {part} of the limit: cycles lost in 12 wavelengths",
            wave.name()
        );
        checks.push(Check::relative(CASE, quantity, found, predicted * twist(twisted, LAG), LAG));
    }
    Ok(checks)
}

/// Phase error against points per wavelength, N = 2…8: space alone, the step alone, and both at nine tenths of the
/// limit of a P wave on cubes.
pub(in crate::verify) fn dispersion_chart() -> Result<CaseFigure, RunError> {
    const PART: f64 = 0.9;
    let points: Vec<f64> = (0..=600).map(|i| 2.0 * 20.0_f64.powf(f64::from(i) / 600.0)).collect();
    let mut curves = vec![];
    for order in 2..=8 {
        let courant = PART * dispersion::critical_courant(order)? / 3.0_f64.sqrt();
        let mut curve =
            DispersionCurve { order, points: points.clone(), space: vec![], time: vec![], both: vec![] };
        for &p in &points {
            let omega_dt = TAU * order as f64 / p * courant;
            curve.space.push((dispersion::phase_speed(order, p, 0.0)? - 1.0).abs());
            curve.time.push((dispersion::step_factor(omega_dt) - 1.0).abs());
            curve.both.push((dispersion::phase_speed(order, p, courant)? - 1.0).abs());
        }
        curves.push(curve);
    }
    let (svg, csv) = dispersion_figure(&curves, PART);
    Ok(CaseFigure { name: "dispersion", svg, tables: vec![("dispersion", csv)] })
}
