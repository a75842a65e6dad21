//! Response spectra against an independent oscillator under records that are known at every time.

use std::f64::consts::{PI, TAU};
use std::io::Write;

use hati_inputs::measures::response_spectrum;
use num_complex::Complex64;

/// A ground acceleration (m/s²) known at every time, with nothing above Nyquist, and its length in s.
struct Record {
    name: &'static str,
    at: Box<dyn Fn(f64) -> f64>,
    length: f64,
}

const DT: f64 = 0.01;

fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut seed = seed;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Sines of random phase under sin²(πt/L): `weight` gives the amplitude over the frequency in Hz.
fn sines(name: &'static str, seed: u64, length: f64, weight: fn(f64) -> f64) -> Record {
    let mut random = random(seed);
    let highest: f64 = 0.4 / DT;
    let lowest: f64 = 0.2;
    let lines: Vec<(f64, f64, f64)> = (0..24)
        .map(|_| {
            let f = lowest * (highest / lowest).powf(random());
            (weight(f), TAU * f, TAU * random())
        })
        .collect();
    let at = move |t: f64| {
        let sum: f64 = lines.iter().map(|(c, omega, phase)| c * (omega * t + phase).sin()).sum();
        if t < 0.0 || t > length { 0.0 } else { sum * (PI * t / length).sin().powi(2) }
    };
    Record { name, at: Box::new(at), length }
}

fn records() -> Vec<Record> {
    let ricker = |t: f64| {
        let square = (PI * 0.1 / DT * (t - 1.0)).powi(2);
        (1.0 - 2.0 * square) * (-square).exp()
    };
    let burst = |t: f64| {
        if !(0.0..=4.0).contains(&t) { 0.0 } else { (TAU * 9.1 * t).sin() * (PI * t / 4.0).sin().powi(2) }
    };
    vec![
        sines("earthquake", 3, 8.0, |f| f / (1.0 + (f / 4.0).powi(2))),
        sines("as much at 0.8 of Nyquist as below", 4, 5.0, |_| 1.0),
        Record { name: "burst of 9.1 Hz", at: Box::new(burst), length: 4.0 },
        Record { name: "Ricker pulse of 10 Hz", at: Box::new(ricker), length: 2.0 },
    ]
}

/// max |u| by `y' = λ y − a`, λ = −ζω + iω_d, u = Im y/ω_d, exact for straight lines over steps that are
/// at most dt/64 and T/256; largest of the points, over the record and 3 periods (or 10 damped ones).
fn largest_displacement(record: &Record, period: f64, damping: f64) -> f64 {
    let omega = TAU / period;
    let omega_d = omega * (1.0 - damping * damping).sqrt();
    let h = (DT / 64.0).min(period / 256.0);
    let z = Complex64::new(-damping * omega, omega_d) * h;
    let turn = z.exp();
    // φ₁ = (e^z − 1)/z and φ₂ = (e^z − 1 − z)/z² by their series, as |z| ≤ 2π/256.
    let series = |first: f64| {
        let mut term = Complex64::new(1.0 / first, 0.0);
        let mut sum = term;
        for j in 1..12 {
            term *= z / (first + f64::from(j));
            sum += term;
        }
        sum
    };
    let (phi_1, phi_2) = (series(1.0), series(2.0));
    let (mut y, mut peak) = (Complex64::new(0.0, 0.0), 0.0_f64);
    let mut before = (record.at)(0.0);
    let count = ((record.length + 3.0 * period) / h) as usize;
    let forced = (record.length / h) as usize;
    for i in 1..=count {
        let now = if i <= forced { (record.at)(i as f64 * h) } else { 0.0 };
        y = turn * y - h * (phi_1 * before + phi_2 * (now - before));
        peak = peak.max(y.im.abs());
        before = now;
    }
    peak / omega_d
}

const RATIOS: [f64; 14] = [0.5, 0.7, 1.0, 1.6, 2.5, 5.0, 10.0, 19.9, 20.0, 40.0, 99.0, 200.0, 500.0, 1000.0];

#[test]
fn spectra_are_within_a_thousandth_from_half_a_step_to_a_thousand() {
    let damping = 0.05;
    let periods = RATIOS.map(|ratio| ratio * DT);
    let mut lines = String::new();
    let mut worst_of_all = 0.0_f64;
    for record in records() {
        let n = (record.length / DT).round() as usize + 1;
        let samples: Vec<f64> = (0..n).map(|i| (record.at)(i as f64 * DT)).collect();
        let found = response_spectrum(&samples, DT, &periods, damping);
        lines += &format!("{}:", record.name);
        for (i, period) in periods.iter().enumerate() {
            let wanted = largest_displacement(&record, *period, damping);
            let error = found.sd[i] / wanted - 1.0;
            lines += &format!(" {:.1e} at {}", error, RATIOS[i]);
            worst_of_all = worst_of_all.max(error.abs());
        }
        lines += "\n";
    }
    let _ = writeln!(std::io::stderr(), "relative error of SD at T/dt:\n{lines}");
    assert!(worst_of_all < 1e-3, "{lines}");
    assert!(worst_of_all > 1e-7, "the reference is not the method itself");
}
