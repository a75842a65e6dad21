//! Cases of the measures of an accelerogram: response spectra, and what is integrated over time.

use super::{CaseResult, Check, twist};
use hati_inputs::measures::{Measures, log_periods, response_spectrum};
use hati_inputs::motion::STANDARD_GRAVITY;
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// Step of all records here, s.
const DT: f64 = 0.01;

/// Largest error allowed: what engineers ask of a spectrum.
const LIMIT: f64 = 1e-3;

/// A ground acceleration (m/s²) that is known at every time from 0 to its length (s).
type Record = (&'static str, fn(f64) -> f64, f64);

/// Ricker pulse of 10 Hz, ten samples per cycle.
fn ricker(t: f64) -> f64 {
    let square = (10.0 * PI * (t - 1.0)).powi(2);
    (1.0 - 2.0 * square) * (-square).exp()
}

/// Burst of 9.1 Hz under half a period of sin².
fn burst(t: f64) -> f64 {
    (TAU * 9.1 * t).sin() * (PI * t / 4.0).sin().powi(2)
}

/// Sines from 0.4 to 40 Hz, largest about 4 Hz, phases and frequencies without a common period.
fn earthquake(t: f64) -> f64 {
    let line = |i: i32| {
        let f = 0.4 * 100_f64.powf(f64::from(i) / 23.0);
        let phase = 2.4 * f64::from(i * i);
        f / (1.0 + (f / 4.0).powi(2)) * (TAU * f * t + phase).sin()
    };
    (0..24).map(line).sum::<f64>() * (PI * t / 8.0).sin().powi(2)
}

/// max |u| of an oscillator from rest, over the record and three periods after it.
///
/// `y' = λ y − a` with λ = −ζω + iω_d and u = Im y/ω_d, exact for straight lines over steps of at most
/// dt/64 and T/256, with the record itself at every point.
fn largest_displacement(record: &Record, period: f64, damping: f64) -> f64 {
    let (_, at, length) = record;
    let omega = TAU / period;
    let omega_d = omega * (1.0 - damping * damping).sqrt();
    let h = (DT / 64.0).min(period / 256.0);
    let z = Complex64::new(-damping * omega, omega_d) * h;
    // φ₁ = (e^z − 1)/z, φ₂ = (e^z − 1 − z)/z² by their series.
    let series = |first: f64| {
        let mut term = Complex64::new(1.0 / first, 0.0);
        (1..12).fold(term, |sum, j| {
            term *= z / (first + f64::from(j));
            sum + term
        })
    };
    let (turn, phi_1, phi_2) = (z.exp(), series(1.0), series(2.0));
    let forced = (length / h) as usize;
    let (mut y, mut peak, mut before) = (Complex64::new(0.0, 0.0), 0.0_f64, at(0.0));
    for i in 1..=((length + 3.0 * period) / h) as usize {
        let now = if i <= forced { at(i as f64 * h) } else { 0.0 };
        y = turn * y - h * (phi_1 * before + phi_2 * (now - before));
        peak = peak.max(y.im.abs());
        before = now;
    }
    peak / omega_d
}

/// 5 % spectra of band-limited records from half a step to a thousand steps, against an oscillator with 64
/// steps per sample and 256 per period or more. Twist: the size of the record.
pub(super) fn spectra(twisted: bool) -> CaseResult {
    let records: [Record; 3] =
        [("earthquake", earthquake, 8.0), ("burst", burst, 4.0), ("Ricker pulse", ricker, 2.0)];
    let periods = log_periods(0.5 * DT, 1000.0 * DT, 15);
    let mut checks = vec![];
    for record in &records {
        let (name, at, length) = record;
        let n = (length / DT).round() as usize + 1;
        let samples: Vec<f64> = (0..n).map(|i| at(i as f64 * DT)).collect();
        let found = response_spectrum(&samples, DT, &periods, 0.05);
        let all = periods.iter().zip(&found.psa).map(|(&period, &psa)| {
            let reference = (TAU / period).powi(2) * largest_displacement(record, period, 0.05);
            let quantity = format!("worst PSA, m/s², {name}, T/dt = {:.3}", period / DT);
            Check::relative("spectra", quantity, psa, reference * twist(twisted, LIMIT), LIMIT)
        });
        checks.extend(all.max_by(|a, b| a.error.total_cmp(&b.error)));
    }
    Ok(checks)
}

/// erf by its series, |x| up to 3.
fn erf(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    for n in 1..120 {
        term *= -x * x / f64::from(n);
        sum += term / f64::from(2 * n + 1);
    }
    2.0 / PI.sqrt() * sum
}

/// Where a non-decreasing function reaches `level`, between `low` and `high`.
fn reached(share: &dyn Fn(f64) -> f64, level: f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if share(middle) < level { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Arias intensity, CAV, D5–95, PGV and PGD of a pulse and of a burst, against closed forms. Twist: the
/// closed forms.
pub(super) fn intensity(twisted: bool) -> CaseResult {
    let mut checks = of_ricker(twisted);
    checks.extend(of_burst(twisted));
    Ok(checks)
}

/// Checks of what was found against [Arias, CAV, D5–95, PGV, PGD].
fn compared(name: &str, found: &Measures, wanted: [f64; 5], twisted: bool) -> Vec<Check> {
    let found = [found.arias_intensity, found.cav, found.d5_95, found.pgv, found.pgd];
    let names = ["Arias intensity, m/s", "CAV, m/s", "D5–95, s", "PGV, m/s", "PGD, m"];
    let check = |i: usize| {
        let quantity = format!("{}, {name}", names[i]);
        Check::relative("intensity", quantity, found[i], wanted[i] * twist(twisted, LIMIT), LIMIT)
    };
    (0..5).map(check).collect()
}

/// `a = (1 − 2s²) e^{−s²}`, s = πf(t − c): `v = (t − c) e^{−s²}`, `d = −e^{−s²}/(2π²f²)`, and ∫a² dt up to s
/// is `[¾ √(π/2) (1 + erf(√2 s))/2 + (s/4 − s³) e^{−2s²}]/(πf)`.
fn of_ricker(twisted: bool) -> Vec<Check> {
    let f = 10.0;
    let a: Vec<f64> = (0..201).map(|i| ricker((f64::from(i) + 0.37) * DT)).collect();
    let whole = 0.75 * (PI / 2.0).sqrt();
    let share =
        |s: f64| 0.5 * (1.0 + erf(2_f64.sqrt() * s)) + (0.25 * s - s.powi(3)) * (-2.0 * s * s).exp() / whole;
    let time = |level| reached(&share, level, -2.0, 2.0) / (PI * f);
    let pgv = (-0.5_f64).exp() / (2_f64.sqrt() * PI * f);
    let arias = PI / (2.0 * STANDARD_GRAVITY) * whole / (PI * f);
    let wanted = [arias, 4.0 * pgv, time(0.95) - time(0.05), pgv, 0.5 / (PI * f).powi(2)];
    compared("Ricker pulse, 10 samples per cycle", &Measures::of(&a, DT, 0.0), wanted, twisted)
}

/// Twenty cycles of `a = sin ωt`: `v = (1 − cos ωt)/ω`, `d = (t − sin(ωt)/ω)/ω`, and ∫a² dt up to t is
/// `t/2 − sin(2ωt)/(4ω)`.
fn of_burst(twisted: bool) -> Vec<Check> {
    let (f, begin) = (1.0, 2.0037);
    let (omega, duration) = (TAU * f, 20.0 / f);
    let sample = |t: f64| if (0.0..=duration).contains(&t) { (omega * t).sin() } else { 0.0 };
    let a: Vec<f64> = (0..2500).map(|i| sample(f64::from(i) * DT - begin)).collect();
    let share = |t: f64| (t - (2.0 * omega * t).sin() / (2.0 * omega)) / duration;
    let time = |level| reached(&share, level, 0.0, duration);
    let arias = PI / (2.0 * STANDARD_GRAVITY) * duration / 2.0;
    let d5_95 = time(0.95) - time(0.05);
    let wanted = [arias, 2.0 / PI * duration, d5_95, 2.0 / omega, duration / omega];
    compared("sine burst, 100 samples per cycle", &Measures::of(&a, DT, 0.0), wanted, twisted)
}
