//! Measures against closed forms.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use hati_inputs::measures::{
    Measures, fourier_amplitude, horizontal_to_vertical, husid, konno_ohmachi, konno_ohmachi_each,
    log_periods, mean_period, psa, response_spectrum, rotated_spectrum,
};

const G: f64 = 9.80665;

/// `cycles` whole cycles of A sin(2πft) from `begin` on, zero elsewhere.
fn burst(amplitude: f64, f: f64, cycles: usize, begin: f64, n: usize, dt: f64) -> Vec<f64> {
    let end = begin + cycles as f64 / f;
    (0..n)
        .map(|i| i as f64 * dt)
        .map(|t| if t < begin || t > end { 0.0 } else { amplitude * (TAU * f * (t - begin)).sin() })
        .collect()
}

#[test]
fn a_sine_burst_has_the_measures_of_the_textbook() {
    let (amplitude, f, cycles, dt) = (2.0, 2.5, 20, 0.002);
    let duration = cycles as f64 / f;
    let a = burst(amplitude, f, cycles, 1.0, 8001, dt);
    let m = Measures::of(&a, dt, 0.0);
    assert_relative_eq!(m.pga, amplitude, max_relative = 1e-6);
    // ∫ sin² over whole cycles is half the time, ∫ |sin| is 2/π of it.
    assert_relative_eq!(
        m.arias_intensity,
        PI / (2.0 * G) * amplitude * amplitude * duration / 2.0,
        max_relative = 1e-6
    );
    assert_relative_eq!(m.cav, 2.0 / PI * amplitude * duration, max_relative = 1e-4);
    // Energy grows as t/2 − sin(2ωt)/(4ω): 5 % and 95 % lie at whole cycles 1 and 19, 75 % at 15.
    assert_relative_eq!(m.d5_95, 0.9 * duration, max_relative = 1e-3);
    assert_relative_eq!(m.d5_75, 0.7 * duration, max_relative = 1e-3);
    // Velocity A/ω (1 − cos), displacement A/ω (t − …): mean velocity A/ω over the burst.
    let omega = TAU * f;
    assert_relative_eq!(m.pgv, 2.0 * amplitude / omega, max_relative = 1e-4);
    assert_relative_eq!(m.pgd, amplitude / omega * duration, max_relative = 1e-3);
    assert_relative_eq!(m.mean_period, 1.0 / f, max_relative = 0.03);
}

#[test]
fn a_low_cut_takes_the_drift_out_of_velocity_and_displacement() {
    // A sine in a wide Gaussian envelope, lifted by an offset of a tenth.
    let (dt, n, f) = (0.01, 6000, 2.0);
    let omega = TAU * f;
    let wave = |t: f64| (omega * t).cos() * (-((t - 30.0) / 8.0).powi(2)).exp();
    let a: Vec<f64> = (0..n).map(|i| wave(i as f64 * dt) + 0.1).collect();
    let drifting = Measures::of(&a, dt, 0.0);
    assert_relative_eq!(drifting.pgv, 0.1 * 60.0, max_relative = 0.02);
    assert_relative_eq!(drifting.pgd, 0.05 * 3600.0, max_relative = 0.02);
    let a: Vec<f64> = a.iter().map(|a| a - 0.1).collect();
    for f_min in [0.1, 1.0] {
        let cut = Measures::of(&a, dt, f_min);
        assert_relative_eq!(cut.pgv, 1.0 / omega, max_relative = 1e-2);
        assert_relative_eq!(cut.pgd, 1.0 / (omega * omega), max_relative = 1e-2);
    }
}

#[test]
fn the_husid_curve_runs_from_zero_to_one() {
    let dt = 0.01;
    let curve = husid(&burst(1.0, 1.0, 4, 2.0, 1000, dt), dt);
    assert_eq!((curve[0], curve[200]), (0.0, 0.0));
    assert!(curve.windows(2).all(|pair| pair[1] >= pair[0]));
    assert_relative_eq!(curve[400], 0.5, epsilon = 1e-9);
    assert_relative_eq!(*curve.last().unwrap(), 1.0, epsilon = 1e-12);
    assert_eq!(husid(&[0.0; 3], dt), [0.0; 3]);
    assert!(husid(&[], dt).is_empty());
    let nothing = Measures::of(&[], dt, 0.1);
    assert_eq!(
        (nothing.pga, nothing.arias_intensity, nothing.d5_95, nothing.mean_period),
        (0.0, 0.0, 0.0, 0.0)
    );
}

/// erf by its series, for |x| up to 3.
fn erf(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    for n in 1..120 {
        term *= -x * x / f64::from(n);
        sum += term / f64::from(2 * n + 1);
    }
    2.0 / PI.sqrt() * sum
}

/// Where a non-decreasing function from 0 to 1 reaches `level`.
fn reached(share: impl Fn(f64) -> f64, level: f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if share(middle) < level { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// (name, found, closed form) of what is integrated over the record.
type Row = (&'static str, f64, f64);

fn assert_rows(what: &str, rows: &[Row], limit: f64) {
    for (name, found, wanted) in rows {
        let error = found / wanted - 1.0;
        assert!(error.abs() < limit, "{what}: {name} {found} against {wanted}: {error:.1e}");
    }
}

#[test]
fn a_ricker_pulse_has_its_closed_forms_at_ten_samples_per_cycle_and_more() {
    let (amplitude, f) = (3.0, 2.0);
    for samples_per_cycle in [10.0_f64, 17.0, 50.0, 200.0] {
        let dt = 1.0 / (f * samples_per_cycle);
        // Between two samples: nothing may depend on a sample that meets the peak.
        let centre = 2.0 + 0.37 * dt;
        let n = (8.0 / dt) as usize;
        let s = |t: f64| PI * f * (t - centre);
        let a: Vec<f64> = (0..n)
            .map(|i| s(i as f64 * dt))
            .map(|s| amplitude * (1.0 - 2.0 * s * s) * (-s * s).exp())
            .collect();
        let m = Measures::of(&a, dt, 0.0);
        // a = A (1 − 2s²) e^{−s²}, s = πf(t − c). Then v = A (t − c) e^{−s²}, d = −A/(2π²f²) e^{−s²} and
        // ∫ a² dt = A²/(πf) [¾ √(π/2) (1 + erf(√2 s))/2 + (s/4 − s³) e^{−2s²}] up to s.
        let energy = 0.75 * (PI / 2.0).sqrt() / (PI * f) * amplitude * amplitude;
        let share = |s: f64| {
            let grown = 0.5 * (1.0 + erf(2.0_f64.sqrt() * s));
            grown + (0.25 * s - s.powi(3)) * (-2.0 * s * s).exp() / (0.75 * (PI / 2.0).sqrt())
        };
        let time = |level| reached(share, level, -2.0, 2.0) / (PI * f);
        let pgv = amplitude * (-0.5_f64).exp() / (2.0_f64.sqrt() * PI * f);
        let rows = [
            ("Arias intensity", m.arias_intensity, PI / (2.0 * G) * energy),
            // v goes down, up and down again: −v, +v and back.
            ("CAV", m.cav, 4.0 * pgv),
            ("D5-75", m.d5_75, time(0.75) - time(0.05)),
            ("D5-95", m.d5_95, time(0.95) - time(0.05)),
            ("time of 5 %", m.t5, centre + time(0.05)),
            ("PGV", m.pgv, pgv),
            ("PGD", m.pgd, amplitude / (2.0 * (PI * f).powi(2))),
        ];
        assert_rows(&format!("Ricker, {samples_per_cycle} samples per cycle"), &rows, 1e-3);
    }
}

#[test]
fn a_sine_burst_has_its_closed_forms_at_forty_samples_per_cycle_and_more() {
    let (amplitude, f, cycles) = (2.0, 2.5, 20);
    let omega = TAU * f;
    let duration = cycles as f64 / f;
    // Its corners at both ends are not band-limited: with ten samples the record itself is another.
    for samples_per_cycle in [40.0_f64, 70.0, 200.0] {
        let dt = 1.0 / (f * samples_per_cycle);
        let begin = 2.0 + 0.37 * dt;
        let a = burst(amplitude, f, cycles, begin, (12.0 / dt) as usize, dt);
        let m = Measures::of(&a, dt, 0.0);
        // ∫ a² dt = A²/2 [t − sin(2ωt)/(2ω)], v = A/ω (1 − cos ωt), d = A/ω (t − sin(ωt)/ω).
        let share = |t: f64| (t - (2.0 * omega * t).sin() / (2.0 * omega)) / duration;
        let time = |level| reached(share, level, 0.0, duration);
        let rows = [
            ("Arias intensity", m.arias_intensity, PI / (2.0 * G) * amplitude * amplitude * duration / 2.0),
            ("CAV", m.cav, 2.0 / PI * amplitude * duration),
            ("D5-75", m.d5_75, time(0.75) - time(0.05)),
            ("D5-95", m.d5_95, time(0.95) - time(0.05)),
            ("PGV", m.pgv, 2.0 * amplitude / omega),
            ("PGD", m.pgd, amplitude / omega * duration),
        ];
        assert_rows(&format!("burst, {samples_per_cycle} samples per cycle"), &rows, 1e-3);
    }
}

#[test]
fn the_predominant_period_is_that_of_the_largest_psa() {
    let dt = 0.005;
    let a = burst(1.0, 2.0, 30, 1.0, 5000, dt);
    let spectrum = response_spectrum(&a, dt, &log_periods(0.05, 5.0, 201), 0.05);
    assert_relative_eq!(spectrum.predominant_period(), 0.5, max_relative = 0.03);
    let still = response_spectrum(&[0.0; 100], dt, &[0.1, 1.0], 0.05);
    assert_eq!(still.predominant_period(), 0.0);
}

#[test]
fn a_motion_along_one_line_is_largest_along_it() {
    let dt = 0.01;
    let a = burst(1.0, 1.3, 12, 1.0, 1500, dt);
    let angle = 33.0_f64.to_radians();
    let [x, y] = [angle.cos(), angle.sin()].map(|c| a.iter().map(|a| c * a).collect::<Vec<f64>>());
    let periods = [0.05, 0.3, 0.77, 4.0];
    let along = psa(&a, dt, &periods, 0.05);
    let turned = rotated_spectrum(&x, &y, dt, &periods, 0.05);
    for (i, psa) in along.iter().enumerate() {
        assert_eq!(turned.rotd100_angle[i], 33.0);
        assert_relative_eq!(turned.rotd100[i], *psa, max_relative = 1e-12);
        // The peak falls as |cos|, whose median over all directions is cos 45° (between two degrees).
        assert_relative_eq!(turned.rotd50[i], psa * 45.0_f64.to_radians().cos(), max_relative = 1e-3);
        assert!(turned.rotd00[i] < 1e-6 * psa);
        assert_relative_eq!(turned.along_x[i], psa * angle.cos(), max_relative = 1e-12);
        let mean = psa * (angle.cos() * angle.sin()).sqrt();
        assert_relative_eq!(turned.geometric_mean[i], mean, max_relative = 1e-12);
    }
}

#[test]
fn a_motion_in_a_circle_is_the_same_in_all_directions() {
    let (dt, f, n) = (0.01, 1.25, 2401);
    let envelope = |t: f64| (PI * t / 24.0).sin().powi(2);
    let wave = |shape: fn(f64) -> f64| -> Vec<f64> {
        (0..n).map(|i| i as f64 * dt).map(|t| envelope(t) * shape(TAU * f * t)).collect()
    };
    let turned = rotated_spectrum(&wave(f64::cos), &wave(f64::sin), dt, &[0.2, 0.8, 2.0], 0.05);
    for i in 0..3 {
        assert_relative_eq!(turned.rotd00[i], turned.rotd100[i], max_relative = 1e-2);
        assert!(turned.rotd00[i] <= turned.rotd50[i] && turned.rotd50[i] <= turned.rotd100[i]);
        assert!(turned.rotd00[i] < turned.rotd100[i]);
    }
    // What cannot be: a damping out of range, a negative period, no motion at all.
    let nothing = rotated_spectrum(&wave(f64::cos), &wave(f64::sin), dt, &[0.2, -1.0], 1.0);
    assert!(nothing.rotd50.iter().chain(&nothing.rotd100_angle).all(|value| value.is_nan()));
    assert!(rotated_spectrum(&[], &[1.0], dt, &[0.5], 0.05).rotd50[0].is_nan());
    assert_eq!(rotated_spectrum(&[0.0; 9], &[0.0; 9], dt, &[0.0, 0.5], 0.05).rotd100, [0.0, 0.0]);
}

/// A sin(pt) under the envelope sin²(πt/L), which is a sum of three sines: (amplitude, circular frequency).
fn smooth_burst(amplitude: f64, p: f64, length: f64) -> [(f64, f64); 3] {
    let q = TAU / length;
    [(0.5 * amplitude, p), (-0.25 * amplitude, p + q), (-0.25 * amplitude, p - q)]
}

/// Free vibration (u, v) after t from (u₀, v₀).
fn free(omega: f64, zeta: f64, u0: f64, v0: f64, t: f64) -> (f64, f64) {
    let omega_d = omega * (1.0 - zeta * zeta).sqrt();
    let (sin, cos) = (omega_d * t).sin_cos();
    let decay = (-zeta * omega * t).exp();
    let b = (v0 + zeta * omega * u0) / omega_d;
    let u = decay * (u0 * cos + b * sin);
    (u, decay * omega_d * (b * cos - u0 * sin) - zeta * omega * u)
}

/// (u, v) of ü + 2ζω u̇ + ω² u = −A sin(pt) from rest, closed form.
fn driven(omega: f64, zeta: f64, amplitude: f64, p: f64, t: f64) -> (f64, f64) {
    if zeta == 0.0 && (p / omega - 1.0).abs() < 1e-9 {
        // Resonance without damping: −A/(2ω²) (sin ωt − ωt cos ωt).
        let (sin, cos) = (omega * t).sin_cos();
        let scale = -amplitude / (2.0 * omega * omega);
        return (scale * (sin - omega * t * cos), scale * omega * omega * t * sin);
    }
    let (x, y) = (omega * omega - p * p, 2.0 * zeta * omega * p);
    let (s, c) = (-amplitude * x / (x * x + y * y), amplitude * y / (x * x + y * y));
    let (u, v) = free(omega, zeta, -c, -s * p, t);
    let (sin, cos) = (p * t).sin_cos();
    (u + s * sin + c * cos, v + p * (s * cos - c * sin))
}

/// Largest |u| under a sum of sines from rest until `end` and in the free vibration after it.
fn exact_peak(load: &[(f64, f64)], end: f64, omega: f64, zeta: f64) -> f64 {
    let state = |t: f64| {
        load.iter().fold((0.0, 0.0), |(u, v), (amplitude, p)| {
            let (du, dv) = driven(omega, zeta, *amplitude, *p, t);
            (u + du, v + dv)
        })
    };
    let fastest = load.iter().fold(omega, |fastest, (_, p)| fastest.max(*p));
    let step = TAU / fastest / 200.0;
    let (u, v) = state(end);
    let during = (0..=(end / step) as usize).map(|i| state(i as f64 * step).0.abs());
    let after =
        (0..=(TAU / omega / step) as usize + 1).map(|i| free(omega, zeta, u, v, i as f64 * step).0.abs());
    during.chain(after).fold(0.0, f64::max)
}

#[test]
fn psa_of_a_sine_is_exact_to_a_thousandth_from_half_a_step_to_a_thousand() {
    let dt = 0.01;
    let mut worst = 0.0_f64;
    for damping in [0.0, 0.02, 0.05, 0.2] {
        for ratio in [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 21.0, 39.0, 40.0, 73.0, 100.0, 300.0, 1000.0] {
            let period = ratio * dt;
            // Below, at and above resonance, as far as 8 samples per cycle allow. The envelope keeps
            // the burst band-limited: a kink at its start would not be.
            for tuning in [0.3_f64, 1.0, 1.7] {
                let samples_per_cycle = (ratio / tuning).round().max(8.0);
                let f = 1.0 / (samples_per_cycle * dt);
                let length = 8.0 / f;
                let load = smooth_burst(1.5, TAU * f, length);
                let n = (length / dt).round() as usize + 1;
                let ground = |t: f64| load.iter().map(|(a, p)| a * (p * t).sin()).sum::<f64>();
                let a: Vec<f64> = (0..n).map(|i| ground(i as f64 * dt)).collect();
                let found = psa(&a, dt, &[period], damping)[0];
                let omega = TAU / period;
                let wanted = omega * omega * exact_peak(&load, length, omega, damping);
                let error = found / wanted - 1.0;
                worst = worst.max(error.abs());
                assert!(error.abs() < 1e-3, "T/dt {ratio} ζ {damping} tuning {tuning}: {error:.2e}");
            }
        }
    }
    assert!(worst > 1e-8, "the reference is not the method itself");
}

/// Peak of |ω² u| by the transfer function on the zero-padded, finely interpolated record.
fn psa_by_frequencies(a: &[f64], dt: f64, period: f64, zeta: f64) -> f64 {
    use realfft::{RealFftPlanner, num_complex::Complex64};
    let omega_0 = TAU / period;
    let fine = (40.0 * dt / period).ceil().max(16.0) as usize;
    let n = 2 * (a.len() + (30.0 * period / dt) as usize);
    let mut padded = a.to_vec();
    padded.resize(n, 0.0);
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(n);
    let mut bins = forward.make_output_vec();
    forward.process(&mut padded, &mut bins).unwrap();
    bins[n / 2] *= 0.5;
    for (i, bin) in bins.iter_mut().enumerate() {
        let omega = TAU * i as f64 / (n as f64 * dt);
        let denominator = Complex64::new(omega_0 * omega_0 - omega * omega, 2.0 * zeta * omega_0 * omega);
        *bin *= -omega_0 * omega_0 / denominator / n as f64;
    }
    bins.resize(n * fine / 2 + 1, Complex64::new(0.0, 0.0));
    let inverse = planner.plan_fft_inverse(n * fine);
    let mut response = inverse.make_output_vec();
    inverse.process(&mut bins, &mut response).unwrap();
    response.iter().fold(0.0, |peak: f64, u| peak.max(u.abs()))
}

#[test]
fn psa_of_noise_up_to_nyquist_agrees_with_the_transfer_function() {
    let dt = 0.02;
    let mut seed = 12345_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let n = 1000;
    let a: Vec<f64> = (0..n).map(|i| noise() * (PI * i as f64 / (n - 1) as f64).sin().powi(2)).collect();
    for ratio in [1.0, 3.0, 10.0, 19.0, 20.0, 30.0, 70.0, 200.0] {
        let found = psa(&a, dt, &[ratio * dt], 0.05)[0];
        let wanted = psa_by_frequencies(&a, dt, ratio * dt, 0.05);
        assert!((found / wanted - 1.0).abs() < 3e-3, "T/dt {ratio}: {found} against {wanted}");
    }
}

#[test]
fn a_steady_resonance_at_twenty_samples_per_period_is_exact() {
    // Straight lines through the samples would lose 0.8 % here.
    let (dt, period, damping) = (0.01, 0.2, 0.05);
    let a = burst(1.0, 1.0 / period, 150, 0.0, 3001, dt);
    let found = psa(&a, dt, &[period], damping)[0];
    assert_relative_eq!(found, 1.0 / (2.0 * damping), max_relative = 1e-3);
}

#[test]
fn spectra_hang_together_at_the_ends() {
    let dt = 0.01;
    let a = burst(2.0, 2.5, 6, 1.0, 1000, dt);
    let periods = [0.0, 1e-5, 0.003, 0.5, 10.0, -1.0, f64::NAN];
    let s = response_spectrum(&a, dt, &periods, 0.05);
    assert_eq!((s.psa[0], s.sd[0]), (2.0, 0.0));
    // Stiff oscillators follow the ground.
    assert_relative_eq!(s.psa[1], 2.0, max_relative = 2e-3);
    assert_relative_eq!(s.psa[2], 2.0, max_relative = 2e-3);
    assert_relative_eq!(s.psv[3], s.sd[3] * TAU / 0.5);
    assert!(s.psa[5].is_nan() && s.psa[6].is_nan());
    // A period of 1000 s moves against the ground by the ground's own displacement.
    let long = response_spectrum(&a, dt, &[1000.0], 0.0);
    let ground = Measures::of(&a, dt, 0.0).pgd;
    assert_relative_eq!(long.sd[0], ground, max_relative = 1e-3);
    for damping in [-0.1, 1.0, f64::NAN] {
        assert!(psa(&a, dt, &[0.5], damping)[0].is_nan());
    }
    assert!(psa(&[], dt, &[0.5], 0.05)[0].is_nan());
    assert!(psa(&a, dt, &[], 0.05).is_empty());
}

#[test]
fn the_free_vibration_after_the_record_counts() {
    // An impulse of one sample: u = −(I/ω) sin ωt, whose first maximum comes after the record's end.
    let dt = 0.01;
    let mut a = vec![0.0; 21];
    a[10] = 1.0;
    let period = 5.0;
    let sd = response_spectrum(&a, dt, &[period], 0.0).sd[0];
    assert_relative_eq!(sd, dt * period / TAU, max_relative = 1e-3);
}

#[test]
fn periods_are_spaced_on_a_logarithmic_axis() {
    let periods = log_periods(0.01, 10.0, 120);
    assert_eq!((periods.len(), periods[0], periods[119]), (120, 0.01, 10.0));
    let ratio = periods[1] / periods[0];
    assert!(periods.windows(2).all(|pair| (pair[1] / pair[0] / ratio - 1.0).abs() < 1e-12));
    assert_eq!(log_periods(0.5, 10.0, 1), [0.5]);
    assert!(log_periods(0.5, 10.0, 0).is_empty());
}

#[test]
fn the_fourier_amplitude_of_a_gaussian_is_a_gaussian() {
    let (dt, width) = (0.01, 0.1);
    let a: Vec<f64> = (0..1000).map(|i| (-((i as f64 * dt - 5.0) / width).powi(2)).exp()).collect();
    let (frequencies, amplitudes) = fourier_amplitude(&a, dt);
    assert_relative_eq!(*frequencies.last().unwrap(), 50.0, max_relative = 1e-12);
    for (f, c) in frequencies.iter().zip(&amplitudes) {
        let wanted = width * PI.sqrt() * (-(PI * f * width).powi(2)).exp();
        assert!((c - wanted).abs() < 1e-12, "{f}: {c} against {wanted}");
    }
    assert!(fourier_amplitude(&[], dt).0.is_empty());
    assert_eq!(mean_period(&[0.0; 10], dt), 0.0);
}

#[test]
fn konno_ohmachi_keeps_a_constant_and_spreads_a_line() {
    let frequencies: Vec<f64> = (0..5000).map(|i| i as f64 * 0.01).collect();
    let centres = [0.05, 0.5, 5.0, 40.0];
    for value in konno_ohmachi(&frequencies, &vec![3.0; 5000], &centres, 40.0) {
        assert_relative_eq!(value, 3.0, max_relative = 1e-12);
    }
    // One line at 5 Hz: the window itself, symmetric in log f, zero at x = ±π.
    let mut line = vec![0.0; 5000];
    line[500] = 1.0;
    let reach = 10_f64.powf(PI / 40.0);
    let half = 10_f64.powf(PI / 80.0);
    let centres = [5.0, 5.0 / half, 5.0 * half, 5.0 * reach, 5.0 / reach];
    let found = konno_ohmachi(&frequencies, &line, &centres, 40.0);
    // Weight at x = π/2 is (2/π)⁴; the sum of weights grows with the centre as the spacing is linear.
    let ratio = (2.0 / PI).powi(4);
    assert_relative_eq!(found[1] / found[0], ratio * half, max_relative = 1e-2);
    assert_relative_eq!(found[2] / found[0], ratio / half, max_relative = 1e-2);
    assert!(found[3] < 1e-6 * found[0] && found[4] < 1e-6 * found[0]);
    assert_eq!(konno_ohmachi(&frequencies, &line, &[0.0, -1.0, 1e9], 40.0), [0.0, 0.0, 0.0]);
    assert_eq!(konno_ohmachi(&[], &[], &[1.0], 40.0), [0.0]);
}

/// The window as its formula reads.
fn konno_ohmachi_plainly(frequencies: &[f64], amplitudes: &[f64], centre: f64, b: f64) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (f, amplitude) in frequencies.iter().zip(amplitudes) {
        let x = b * (f / centre).log10();
        if *f > 0.0 && x.abs() <= 6.0 * PI {
            let weight = if x == 0.0 { 1.0 } else { (x.sin() / x).powi(4) };
            sum += weight * amplitude;
            total += weight;
        }
    }
    sum / total
}

#[test]
fn smoothing_is_the_formula_for_one_spectrum_and_for_three() {
    let frequencies: Vec<f64> = (0..20_001).map(|i| i as f64 * 0.005).collect();
    let amplitude = |phase: f64| -> Vec<f64> {
        frequencies.iter().map(|f| 1.0 + (37.0 * f + phase).sin() / (1.0 + f)).collect()
    };
    let columns = [amplitude(0.0), amplitude(1.0), amplitude(2.0)];
    // On a frequency of the grid, between two, at the ends.
    let mut centres = log_periods(0.01, 100.0, 61);
    centres.extend([5.0, 5.0025, 99.999]);
    for b in [8.0, 40.0, -40.0, 188.0] {
        let three = konno_ohmachi_each(&frequencies, columns.each_ref().map(|c| &c[..]), &centres, b);
        for (column, smoothed) in columns.iter().zip(&three) {
            assert_eq!(*smoothed, konno_ohmachi(&frequencies, column, &centres, b));
            for (centre, value) in centres.iter().zip(smoothed) {
                let wanted = konno_ohmachi_plainly(&frequencies, column, *centre, b);
                assert_relative_eq!(*value, wanted, max_relative = 1e-9);
            }
        }
    }
}

#[test]
fn horizontal_to_vertical_is_the_ratio_of_the_smoothed_amplitudes() {
    let dt = 0.01;
    let pulse = |c: f64| -> Vec<f64> {
        (0..2000).map(|i| c * (-((i as f64 * dt - 10.0) / 0.1).powi(2)).exp()).collect()
    };
    let centres = [0.5, 1.0, 2.0, 4.0];
    let ratio = horizontal_to_vertical(&pulse(2.0), &pulse(-8.0), &pulse(0.5), dt, &centres, 40.0);
    for value in ratio {
        assert_relative_eq!(value, 8.0, max_relative = 1e-12);
    }
    let still = vec![0.0; 2000];
    let without = horizontal_to_vertical(&pulse(2.0), &pulse(1.0), &still, dt, &centres, 40.0);
    assert!(without.iter().all(|value| value.is_nan()));
    assert_eq!(horizontal_to_vertical(&pulse(2.0), &still, &pulse(1.0), dt, &centres, 40.0), [0.0; 4]);
}
