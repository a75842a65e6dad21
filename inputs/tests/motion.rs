//! Motions: spectral calculus and the model's band against closed forms.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use hati_inputs::InputError;
use hati_inputs::motion::{
    BandWindow, Motion, Quantity, differentiate, integrate, padded_length, resample_as, upsample, usable_band,
};
use hati_inputs::records::Channel;
use proptest::prelude::*;

const RICKER_FREQUENCY: f64 = 4.0;
const RICKER_TIME: f64 = 2.0;

/// Displacement, velocity and acceleration whose displacement is the Gaussian exp(−p²).
///
/// With p = π f (t − t₀): v = −2 p π f e, a = −2 (πf)² (1 − 2p²) e; the acceleration is a Ricker wavelet.
fn gaussian(t: f64) -> [f64; 3] {
    let rate = PI * RICKER_FREQUENCY;
    let p = rate * (t - RICKER_TIME);
    let e = (-p * p).exp();
    [e, -2.0 * p * rate * e, -2.0 * rate * rate * (1.0 - 2.0 * p * p) * e]
}

fn sampled(order: usize, n: usize, dt: f64) -> Vec<f64> {
    (0..n).map(|i| gaussian(i as f64 * dt)[order]).collect()
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))
}

#[track_caller]
fn assert_close(found: &[f64], wanted: &[f64], tolerance: f64) {
    assert_eq!(found.len(), wanted.len());
    let scale = largest(wanted);
    for (i, (a, b)) in found.iter().zip(wanted).enumerate() {
        assert!((a - b).abs() <= tolerance * scale, "sample {i}: {a} against {b} (scale {scale})");
    }
}

#[test]
fn a_ricker_wavelet_converts_both_ways_and_at_every_factor() {
    let dt = 0.02;
    let kinds = [Quantity::Displacement, Quantity::Velocity, Quantity::Acceleration];
    for n in [256, 257] {
        for k in [1, 2, 3, 8] {
            for (i, from) in kinds.iter().enumerate() {
                for (j, to) in kinds.iter().enumerate() {
                    let x = sampled(i, n, dt);
                    let found = resample_as(&x, dt, *from, *to, k);
                    let fine = sampled(j, (n - 1) * k + 1, dt / k as f64);
                    // Displacement integrated from rest starts at 0; the Gaussian at exp(−631) does too.
                    assert_close(&found, &fine, 1e-9);
                }
            }
        }
    }
}

#[test]
fn the_sign_and_the_start_of_an_integral() {
    // One full cycle of a sine: velocity (1 − cos)/ω, never negative, zero at both ends.
    let (dt, omega) = (0.002, TAU * 2.0);
    let a: Vec<f64> =
        (0..1000).map(|i| i as f64 * dt).map(|t| if t <= 0.5 { (omega * t).sin() } else { 0.0 }).collect();
    let v = integrate(&a, dt);
    assert_eq!(v[0], 0.0);
    // The kinks at the ends of the cycle are not band-limited: 1e-5.
    assert_relative_eq!(v[125], 2.0 / omega, max_relative = 5e-5);
    assert!(v[500].abs() < 1e-5 && v.iter().all(|v| *v > -1e-5));
    let minus: Vec<f64> = a.iter().map(|a| -a).collect();
    assert_close(&integrate(&minus, dt), &v.iter().map(|v| -v).collect::<Vec<_>>(), 1e-15);
    // Displacement (ωt − sin ωt)/ω², then a constant velocity of zero: it stays at T/ω.
    let d = resample_as(&a, dt, Quantity::Acceleration, Quantity::Displacement, 1);
    assert_eq!(d[0], 0.0);
    assert_relative_eq!(d[250], 0.5 / omega, max_relative = 1e-4);
    assert_relative_eq!(d[999], 0.5 / omega, max_relative = 1e-4);
}

#[test]
fn an_offset_drifts_as_a_line_and_a_parabola() {
    // A smooth bump with a mean: the mean is kept, the velocity behind it is the bump's area.
    let dt = 0.01;
    let bump = |t: f64| (-((t - 3.0) / 0.5_f64).powi(2)).exp();
    let a: Vec<f64> = (0..1000).map(|i| bump(i as f64 * dt)).collect();
    let area = 0.5 * PI.sqrt();
    let v = integrate(&a, dt);
    assert_relative_eq!(v[300], 0.5 * area, max_relative = 1e-9);
    assert_relative_eq!(v[999], area, max_relative = 1e-9);
    let d = resample_as(&a, dt, Quantity::Acceleration, Quantity::Displacement, 4);
    // Behind the bump the displacement runs on as area (t − 3 s).
    for t in [6.0, 9.0] {
        assert_relative_eq!(d[(t / dt * 4.0) as usize], area * (t - 3.0), max_relative = 1e-9);
    }
    // Integration and differentiation undo each other.
    assert_close(&differentiate(&v, dt)[200..700], &a[200..700], 1e-4);
    // A line is differentiated exactly up to its ends.
    let line: Vec<f64> = (0..100).map(|i| 3.0 - 0.5 * i as f64 * dt).collect();
    assert_close(&differentiate(&line, dt), &[-0.5; 100], 1e-9);
}

proptest! {
    #[test]
    fn interpolation_passes_through_the_samples(
        x in prop::collection::vec(-1.0..1.0_f64, 1..200), k in 1_usize..9, dt in 0.001..0.1_f64,
    ) {
        let fine = upsample(&x, dt, k);
        prop_assert_eq!(fine.len(), (x.len() - 1) * k + 1);
        for (i, value) in x.iter().enumerate() {
            prop_assert!((fine[i * k] - value).abs() < 1e-12);
        }
    }

    #[test]
    fn padded_lengths_are_even_smooth_and_close(n in 1_usize..3_000_000) {
        let length = padded_length(n, 1.0, 0.0);
        prop_assert!(length >= n && length.is_multiple_of(2));
        let mut rest = length;
        for prime in [2, 3, 5] {
            while rest.is_multiple_of(prime) {
                rest /= prime;
            }
        }
        prop_assert_eq!(rest, 1);
        prop_assert!(n < 100 || (length as f64) < 1.1 * n as f64);
    }
}

#[test]
fn lengths_have_twenty_seconds_of_zeros_and_a_bound() {
    assert_eq!(padded_length(1000, 0.01, 20.0), 3000);
    assert_eq!(padded_length(1001, 0.01, 20.0), 3072);
    // No step makes it ask for unbounded memory.
    for dt in [1e-12, 0.0, f64::NAN, 1e300] {
        assert!(padded_length(1000, dt, 20.0) <= 1 << 21);
    }
    assert!(upsample(&[], 0.01, 3).is_empty());
    assert_eq!(upsample(&[2.0], 0.01, 3), [2.0]);
}

#[test]
fn the_usable_band_leaves_out_the_share_it_says() {
    // |A|² of exp(−(πfτ)²)-type spectra: a Ricker wavelet of peak frequency f_p.
    let (dt, n) = (0.005, 4000);
    let a = sampled(2, n, dt);
    let mut last = (f64::INFINITY, 0.0);
    for accuracy in [0.3, 0.1, 0.01, 1e-3] {
        let (f_min, f_max) = usable_band(&a, dt, accuracy);
        assert!(f_min < last.0 && f_max > last.1, "{f_min} {f_max}");
        last = (f_min, f_max);
        // Cut sharply there, the error is accuracy/2 at most and, on such fine bins, hardly less.
        let window = |f: f64| f >= f_min && f <= f_max;
        let (mut kept, mut total) = (0.0, 0.0);
        for i in 0..200_000 {
            let f = i as f64 * 1e-4;
            // Transform of the wavelet: f² exp(−f²/f_p²).
            let energy = (f * f * (-(f / RICKER_FREQUENCY).powi(2)).exp()).powi(2);
            total += energy;
            kept += if window(f) { energy } else { 0.0 };
        }
        let error = (1.0 - kept / total).sqrt();
        assert!(error < 0.5 * accuracy * 1.02 && error > 0.5 * accuracy * 0.8, "{accuracy}: {error}");
    }
    let (f_min, f_max) = usable_band(&vec![0.0; 100], 0.01, 0.01);
    assert_eq!((f_min, f_max), (1.0, 50.0));
    assert_eq!(usable_band(&a, dt, 0.0).1, 100.0);
    // An offset: everything lies at zero frequency, and the band stays a band.
    let (f_min, f_max) = usable_band(&vec![1.0; 100], 0.01, 0.3);
    assert!(f_min <= f_max && f_min >= 1.0);
}

fn motion_of(x: Vec<f64>, dt: f64) -> Motion {
    Motion::new(dt, None, Quantity::Acceleration, [Some(x), None, None]).unwrap()
}

#[test]
fn the_band_window_is_flat_inside_and_a_half_cosine_outside() {
    let window = BandWindow::new(1.0, 20.0, 0.01);
    let cases =
        [(0.0, 0.0), (0.5, 0.0), (0.75, 0.5), (1.0, 1.0), (20.0, 1.0), (22.5, 0.5), (25.0, 0.0), (50.0, 0.0)];
    for (f, gain) in cases {
        assert!((window.gain(f) - gain).abs() < 1e-12, "{f}: {}", window.gain(f));
    }
    // Nyquist bounds the upper roll-off; at Nyquist itself there is none.
    assert_eq!(BandWindow::new(1.0, 45.0, 0.01).f_stop, 50.0);
    assert_eq!(BandWindow::new(0.0, 50.0, 0.01).gain(50.0), 1.0);
    assert_eq!(BandWindow::new(0.0, 50.0, 0.01).gain(0.0), 1.0);
}

#[test]
fn the_band_keeps_what_is_inside_without_a_shift_and_drops_the_rest() {
    let (dt, n) = (0.01, 6000);
    let burst = |f: f64| -> Vec<f64> {
        (0..n)
            .map(|i| i as f64 * dt)
            .map(|t| (TAU * f * t).sin() * (-((t - 30.0) / 6.0).powi(2)).exp())
            .collect()
    };
    let (inside, below, above) = (burst(5.0), burst(0.2), burst(40.0));
    let sum = (0..n).map(|i| inside[i] + below[i] + above[i] + 3.0).collect();
    let mut motion = motion_of(sum, dt);
    motion.band(1.0, 20.0).unwrap();
    let found = motion.components[0].as_ref().unwrap();
    // The constant of 3 is a box of the record's length: its ends ring, its middle is gone.
    assert_close(&found[2000..4000], &inside[2000..4000], 1e-2);
    let step = &motion.steps[0];
    assert_eq!(step.name, "band");
    assert_eq!((&step.parameters["f_min_hz"], &step.found["f_zero_above_hz"]), (&1.0.into(), &25.0.into()));
    // The whole band changes nothing.
    let mut same = motion_of(inside.clone(), dt);
    same.band(0.0, 50.0).unwrap();
    assert_close(same.components[0].as_ref().unwrap(), &inside, 1e-13);
    for (low, high) in [(-1.0, 5.0), (5.0, 5.0), (5.0, 1.0), (1.0, 51.0), (f64::NAN, 5.0), (1.0, f64::NAN)] {
        let error = same.band(low, high).unwrap_err();
        assert!(matches!(error, InputError::StepParameter { step: "band", .. }), "{error}");
    }
}

#[test]
fn a_motion_must_be_one_motion() {
    let x = || Some(vec![1.0, 2.0, 3.0]);
    let new = |dt, components| Motion::new(dt, None, Quantity::Velocity, components);
    assert!(matches!(new(0.01, [None, None, None]), Err(InputError::NoComponent)));
    let lengths = new(0.01, [x(), None, Some(vec![1.0, 2.0])]).unwrap_err().to_string();
    assert!(lengths.contains("x and z") && lengths.contains("3 and 2"), "{lengths}");
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(new(dt, [x(), None, None]).is_err());
    }
    assert!(new(0.01, [Some(vec![1.0]), None, None]).is_err());
    assert!(new(0.01, [None, Some(vec![1.0, f64::NAN]), None]).is_err());
    let motion = new(0.5, [None, x(), None]).unwrap();
    assert_eq!((motion.len(), motion.duration(), motion.peak()), (3, 1.0, 3.0));
    assert!(motion.component_as(0, Quantity::Velocity, 1).is_none());
    assert_eq!(motion.component_as(1, Quantity::Velocity, 1), x());
    assert!(motion.component_as(9, Quantity::Velocity, 1).is_none());
}

fn channel(id: &str, start: Option<f64>, samples: Vec<f64>) -> Channel {
    Channel {
        id: id.into(),
        file: "made.up".into(),
        format: "K-NET",
        start,
        dt: 0.01,
        samples,
        quantity: Quantity::Acceleration,
        unit_stored: "gal".into(),
        axis_hint: None,
        steps: Vec::new(),
        sha256: "00".into(),
    }
}

/// Components that speak of two recordings.
#[test]
fn components_of_two_stations_or_sensors_are_refused() {
    let ramp = || (0..100).map(f64::from).collect::<Vec<f64>>();
    let refusal = |x: &str, y: &str| {
        let (x, mut y) = (channel(x, None, ramp()), channel(y, None, ramp()));
        y.sha256 = "01".into();
        Motion::from_channels([Some(&x), Some(&y), None])
            .map(|motion| motion.len())
            .map_err(|e| e.to_string())
    };
    assert!(refusal("CI.CLC..HNE", "CI.TOW..HNN").unwrap_err().contains("differ in station: CLC and TOW"));
    let sensors = refusal("BO.S..EW1", "BO.S..NS2").unwrap_err();
    assert!(sensors.contains("differ in sensor: 1, in the borehole and 2, at the surface"), "{sensors}");
    for (x, y) in [("CI.CLC..HNE", "CI.CLC..HNN"), ("...A", "CI.CLC..HNN"), ("BO.S..EW2", "BO.S..NS2")] {
        assert_eq!(refusal(x, y), Ok(100));
    }
    let x = channel("CI.CLC..HNE", None, ramp());
    let error = Motion::from_channels([Some(&x), None, Some(&x)]).unwrap_err();
    assert!(error.to_string().contains("x and z are the same channel: CI.CLC..HNE of made.up"), "{error}");
}

#[test]
fn channels_of_one_recording_are_cut_to_their_common_time() {
    let ramp = |from: usize, n: usize| (from..from + n).map(|i| i as f64).collect::<Vec<f64>>();
    let day = 1.58e9;
    // Sample i of the ramp belongs to the time day + i/100.
    let x = channel("X", Some(day), ramp(0, 100));
    let z = channel("Z", Some(day + 0.30), ramp(30, 100));
    let motion = Motion::from_channels([Some(&x), None, Some(&z)]).unwrap();
    assert_eq!(motion.components[0], Some(ramp(30, 70)));
    assert_eq!(motion.components[2], Some(ramp(30, 70)));
    assert!((motion.start.unwrap() - day - 0.30).abs() < 1e-6);
    let record = &motion.steps[0].parameters;
    assert_eq!(
        (&record["x"]["samples_cut_before"], &record["z"]["samples_cut_after"]),
        (&30.into(), &30.into())
    );
    // Without a start on one side they begin together.
    let unknown = channel("Y", None, ramp(0, 90));
    let motion = Motion::from_channels([Some(&x), Some(&unknown), None]).unwrap();
    assert_eq!((motion.len(), motion.start), (90, None));

    let refused = |second: Channel, word: &str| {
        let error = Motion::from_channels([Some(&x), Some(&second), None]).unwrap_err();
        assert!(matches!(error, InputError::ComponentsDiffer { .. }), "{error}");
        assert!(error.to_string().contains(word), "{error}");
    };
    refused(channel("Y", Some(day + 0.004), ramp(0, 100)), "sampling times");
    refused(channel("Y", Some(f64::NAN), ramp(0, 100)), "sampling times");
    refused(channel("Y", Some(day + 50.0), ramp(0, 100)), "time covered");
    refused(channel("Y", None, vec![]), "time covered");
    refused(Channel { dt: 0.02, ..x.clone() }, "time step");
    refused(Channel { quantity: Quantity::Velocity, ..x.clone() }, "quantity");
    assert!(matches!(Motion::from_channels([None; 3]), Err(InputError::NoComponent)));
}
