//! Steps of processing: each against its equation, its limits, and its own record.

mod filters;
mod steps;

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use hati_inputs::InputError;
use hati_inputs::measures;
use hati_inputs::motion::{Motion, Process, Quantity, Scaling, Step, integrate, resample_as};

fn motion_of(x: Vec<f64>, dt: f64) -> Motion {
    Motion::new(dt, None, Quantity::Acceleration, [Some(x), None, None]).unwrap()
}

fn x_of(motion: &Motion) -> &[f64] {
    motion.components[0].as_deref().unwrap()
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

/// The same numbers on every machine, between −1 and 1.
fn noise(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    (0..n)
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
        .collect()
}

/// A tone under a Gaussian that is nothing at the ends of the record.
fn burst(f: f64, n: usize, dt: f64) -> Vec<f64> {
    let middle = 0.5 * n as f64 * dt;
    let width = middle / 7.0;
    (0..n)
        .map(|i| i as f64 * dt - middle)
        .map(|t| (TAU * f * t).cos() * (-(t / width).powi(2)).exp())
        .collect()
}

#[track_caller]
fn refused(process: &Process, motion: &Motion, parts: &[&str]) {
    let mut changed = motion.clone();
    let error = process.apply(&mut changed).unwrap_err();
    let good = matches!(error, InputError::StepParameter { .. } | InputError::StepUnfit { .. });
    assert!(good, "{error}");
    for part in parts.iter().chain(&["\n  help: "]) {
        assert!(error.to_string().contains(part), "{part:?} is not in {error}");
    }
    assert_eq!(&changed, motion, "a refused step leaves the motion alone");
}

// ---- offset and trends --------------------------------------------------------------------------

#[test]
fn offsets_are_removed_and_gravity_is_named() {
    let wave: Vec<f64> = (0..1000).map(|i| if i < 100 { 0.0 } else { (i as f64 * 0.3).sin() }).collect();
    let lifted = |offset: f64| Some(wave.iter().map(|x| x + offset).collect::<Vec<f64>>());
    let motion =
        Motion::new(0.01, Some(7.0), Quantity::Acceleration, [lifted(0.2), None, lifted(9.79)]).unwrap();
    let mut first = motion.clone();
    Process::Demean { first_seconds: Some(1.0) }.apply(&mut first).unwrap();
    assert_close(x_of(&first), &wave, 1e-12);
    assert_close(first.components[2].as_ref().unwrap(), &wave, 1e-12);
    let step = &first.steps[0];
    assert_eq!((step.name.as_str(), &step.parameters["first_seconds"]), ("demean", &1.0.into()));
    assert_eq!((&step.found["z"]["gravity_g"], &step.found["samples_averaged"]), (&1.0.into(), &100.into()));
    assert!(step.found["x"].get("gravity_g").is_none());
    assert_relative_eq!(step.found["x"]["offset_m_s2"].as_f64().unwrap(), 0.2, max_relative = 1e-12);
    let mut whole = motion.clone();
    Process::Demean { first_seconds: None }.apply(&mut whole).unwrap();
    assert!(x_of(&whole).iter().sum::<f64>().abs() < 1e-10);
    for seconds in [0.0, -1.0, 10.1, f64::NAN] {
        refused(&Process::Demean { first_seconds: Some(seconds) }, &motion, &["demean: first_seconds"]);
    }
}

#[test]
fn a_trend_of_the_samples_is_taken_off() {
    let (n, dt) = (2000, 0.01);
    let wave = burst(3.0, n, dt);
    for order in 1..=5 {
        let trend = |t: f64| (0..=order).map(|k| (t / 10.0 - 1.0).powi(k) * 0.3).sum::<f64>();
        let drifted = (0..n).map(|i| wave[i] + trend(i as f64 * dt)).collect();
        let mut motion = motion_of(drifted, dt);
        Process::Detrend { order: order as usize }.apply(&mut motion).unwrap();
        // The wave has next to no projection on the polynomial: its own spectrum ends above 1 Hz.
        assert_close(x_of(&motion), &wave, 1e-9);
        let first = motion.steps[0].found["x"]["removed_first_m_s2"].as_f64().unwrap();
        assert_relative_eq!(first, trend(0.0), epsilon = 1e-9);
    }
    let motion = motion_of(wave, dt);
    for order in [0, 6] {
        refused(&Process::Detrend { order }, &motion, &["detrend: order", "1 to 5"]);
    }
    refused(&Process::Detrend { order: 3 }, &motion_of(vec![1.0, 2.0, 3.0, 5.0], dt), &["4 samples"]);
}

/// A drift c₁ t + c₂ t² of the velocity, put into the acceleration as its derivative, is found and taken off.
#[test]
fn a_drift_of_the_velocity_is_taken_off_the_acceleration() {
    let (n, dt) = (4000, 0.005);
    let wave = burst(2.0, n, dt);
    let drift = |t: f64| 0.02 - 0.003 * t;
    let drifted: Vec<f64> = (0..n).map(|i| wave[i] + drift(i as f64 * dt)).collect();
    let mut motion = motion_of(drifted.clone(), dt);
    Process::Baseline { order: 2 }.apply(&mut motion).unwrap();
    // The record's ends are jumps to the zeros around it, over which the integral is right to about a sample's share.
    let rest: Vec<f64> = x_of(&motion).iter().zip(&wave).map(|(a, b)| a - b).collect();
    assert!(largest(&rest) < 2e-3 * 0.04, "{}", largest(&rest));
    let step = &motion.steps[0].found["x"];
    let end = |key: &str| step[key].as_f64().unwrap();
    assert_relative_eq!(end("velocity_end_before_m_s"), 0.02 * 20.0 - 0.0015 * 400.0, max_relative = 2e-3);
    assert!(end("velocity_end_m_s").abs() < 1e-3);
    // The velocity still starts from rest.
    assert_eq!(integrate(x_of(&motion), dt)[0], 0.0);
    // What is left of the velocity has no projection on t and t²: a second round finds next to nothing.
    Process::Baseline { order: 2 }.apply(&mut motion).unwrap();
    let again = motion.steps[1].found["x"]["removed_peak_m_s2"].as_f64().unwrap();
    assert!(again < 1e-2 * step_peak(&motion.steps[0]), "{again}");
    let velocity = Motion::new(dt, None, Quantity::Velocity, [Some(drifted), None, None]).unwrap();
    refused(&Process::Baseline { order: 1 }, &velocity, &["is a velocity", "help: put { step = \"convert\""]);
}

fn step_peak(step: &Step) -> f64 {
    step.found["x"]["removed_peak_m_s2"].as_f64().unwrap()
}

#[test]
fn the_taper_is_a_half_cosine_at_each_end() {
    let mut motion = motion_of(vec![1.0; 101], 0.01);
    Process::Taper { start: 0.2, end: 0.4 }.apply(&mut motion).unwrap();
    for (i, gain) in [(0, 0.0), (10, 0.5), (20, 1.0), (60, 1.0), (80, 0.5), (100, 0.0)] {
        assert!((x_of(&motion)[i] - gain).abs() < 1e-12, "{i}: {}", x_of(&motion)[i]);
    }
    refused(&Process::Taper { start: 0.6, end: 0.6 }, &motion, &["start + end"]);
    refused(&Process::Taper { start: -0.1, end: 0.0 }, &motion, &["taper: start"]);
    refused(&Process::Taper { start: 0.0, end: f64::NAN }, &motion, &["taper: end"]);
}

// ---- axes, time, step ---------------------------------------------------------------------------

#[test]
fn a_rotation_turns_the_axes_counter_clockwise() {
    // A motion towards x alone: after the axes have turned by 30° it points to −30° of the new x axis.
    let mut motion = Motion::new(
        0.01,
        None,
        Quantity::Velocity,
        [Some(vec![1.0, 2.0]), Some(vec![0.0, 0.0]), Some(vec![5.0, 5.0])],
    )
    .unwrap();
    let before = motion.clone();
    Process::Rotate { angle: 30.0 }.apply(&mut motion).unwrap();
    assert_relative_eq!(x_of(&motion)[1], 3_f64.sqrt(), max_relative = 1e-14);
    assert_relative_eq!(motion.components[1].as_ref().unwrap()[1], -1.0, max_relative = 1e-14);
    assert_eq!(motion.components[2], before.components[2]);
    // A right angle is exact: x' = y, y' = −x.
    let mut right = before.clone();
    Process::Rotate { angle: -270.0 }.apply(&mut right).unwrap();
    assert_eq!((x_of(&right), right.components[1].as_deref().unwrap()), (&[0.0, 0.0][..], &[-1.0, -2.0][..]));
    refused(&Process::Rotate { angle: f64::INFINITY }, &before, &["rotate: angle"]);
    refused(&Process::Rotate { angle: 10.0 }, &motion_of(vec![1.0, 2.0], 0.01), &["needs both horizontals"]);
}

#[test]
fn trims_and_pads_move_the_start() {
    let ramp = |from: usize, to: usize| (from..to).map(|i| i as f64).collect::<Vec<f64>>();
    let mut motion = motion_of(ramp(0, 101), 0.1);
    motion.start = Some(1000.0);
    let before = motion.clone();
    Process::Trim { from: 0.3, to: Some(0.7) }.apply(&mut motion).unwrap();
    assert_eq!((x_of(&motion), motion.start), (&ramp(3, 8)[..], Some(1000.3)));
    assert_eq!(
        (&motion.steps[0].found["samples_cut_before"], &motion.steps[0].found["samples_cut_after"]),
        (&3.into(), &93.into())
    );
    Process::Pad { before: 0.2, after: 0.1 }.apply(&mut motion).unwrap();
    assert_eq!(x_of(&motion), [0.0, 0.0, 3.0, 4.0, 5.0, 6.0, 7.0, 0.0]);
    assert!((motion.start.unwrap() - 1000.1).abs() < 1e-9);
    // Times between samples: what lies inside is kept.
    let mut between = before.clone();
    Process::Trim { from: 0.25, to: Some(0.79) }.apply(&mut between).unwrap();
    assert_eq!(x_of(&between), ramp(3, 8));
    let mut open = before.clone();
    Process::Trim { from: 9.5, to: None }.apply(&mut open).unwrap();
    assert_eq!(x_of(&open), ramp(95, 101));
    refused(&Process::Trim { from: 5.0, to: Some(5.0) }, &before, &["trim: to", "above from = 5 s"]);
    refused(
        &Process::Trim { from: 0.0, to: Some(10.1) },
        &before,
        &["trim: to", "at most the motion's 10 s"],
    );
    refused(&Process::Trim { from: 10.0, to: None }, &before, &["trim: from"]);
    refused(&Process::Trim { from: 0.31, to: Some(0.39) }, &before, &["two samples"]);
    refused(&Process::Pad { before: -1.0, after: 0.0 }, &before, &["pad: before"]);
    refused(
        &Process::Pad { before: 0.0, after: 1e12 },
        &before,
        &["pad: after = 1e12;", "at most 2e7 samples"],
    );
}

#[test]
fn resampling_keeps_what_lies_below_the_new_nyquist_and_folds_nothing() {
    let (n, dt) = (4001, 0.01);
    for (new, below, above) in
        [(0.01 * 73.0 / 50.0, 10.0, 45.0), (0.02, 15.0, 35.0), (0.025, 14.0, 30.0), (0.0128, 25.0, 45.0)]
    {
        let count = (40.0 / new + 1e-9_f64).floor() as usize + 1;
        let resampled = |x: Vec<f64>| {
            let mut motion = motion_of(x, dt);
            Process::Resample { dt: new }.apply(&mut motion).unwrap();
            assert_eq!((motion.len(), motion.dt), (count, new));
            x_of(&motion).to_vec()
        };
        let middle = 0.5 * n as f64 * dt;
        let tone = |f: f64, i: usize| {
            let t = i as f64 * new - middle;
            (TAU * f * t).cos() * (-(t / (middle / 7.0)).powi(2)).exp()
        };
        let wanted: Vec<f64> = (0..count).map(|i| tone(below, i)).collect();
        assert_close(&resampled(burst(below, n, dt)), &wanted, 1e-6);
        assert!(largest(&resampled(burst(above, n, dt))) < 1e-6, "{new}");
    }
    // To a finer step nothing is lost, and the old samples are among the new ones.
    for new in [0.005, 0.01 / 3.0, 0.0073, 0.0078125] {
        let x = burst(40.0, n, dt);
        let mut motion = motion_of(x.clone(), dt);
        Process::Resample { dt: new }.apply(&mut motion).unwrap();
        assert_eq!(x_of(&motion)[0], x_of(&motion)[0]);
        let middle = 0.5 * n as f64 * dt;
        let wanted: Vec<f64> = (0..motion.len())
            .map(|i| i as f64 * new - middle)
            .map(|t| (TAU * 40.0 * t).cos() * (-(t / (middle / 7.0)).powi(2)).exp())
            .collect();
        assert_close(x_of(&motion), &wanted, 1e-6);
    }
    // The program's own refinement is the same one.
    let x = noise(300, 5);
    let mut motion = motion_of(x.clone(), dt);
    Process::Resample { dt: 0.0025 }.apply(&mut motion).unwrap();
    assert_close(x_of(&motion), &resample_as(&x, dt, Quantity::Velocity, Quantity::Velocity, 4), 1e-12);
    let mut same = motion_of(x.clone(), dt);
    Process::Resample { dt: 0.01 }.apply(&mut same).unwrap();
    assert_eq!(x_of(&same), x);
    let motion = motion_of(x, dt);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(&Process::Resample { dt: bad }, &motion, &["resample: dt", "positive"]);
    }
    refused(&Process::Resample { dt: 0.01 / PI }, &motion, &["whole-number ratio", "near are"]);
    refused(&Process::Resample { dt: 4.0 }, &motion, &["at most the motion's length of 2.99 s"]);
}

// ---- scale, rest, quantity ----------------------------------------------------------------------

#[test]
fn scaling_reaches_what_was_asked_and_says_its_factor() {
    let (n, dt) = (2000, 0.01);
    let y = burst(2.0, n, dt).into_iter().map(|v| -0.25 * v).collect();
    let motion =
        Motion::new(dt, None, Quantity::Acceleration, [Some(burst(3.0, n, dt)), Some(y), None]).unwrap();
    let scaled = |scaling: Scaling| {
        let mut motion = motion.clone();
        Process::Scale(scaling).apply(&mut motion).unwrap();
        let factor = motion.steps[0].found["factor"].as_f64().unwrap();
        for axis in 0..2 {
            let before = motion_component(&self::motion_like(&motion, factor), axis);
            assert_close(&before, &motion_component(&motion, axis), 1e-12);
        }
        motion
    };
    let factor = scaled(Scaling::Factor(-2.0));
    assert_eq!(factor.peak(), 2.0 * motion.peak());
    assert_eq!(factor.steps[0].found["peak_m_s2"], factor.peak());
    assert_relative_eq!(scaled(Scaling::Pga(3.0)).peak(), 3.0, max_relative = 1e-14);
    let pgv = scaled(Scaling::Pgv(0.3));
    let velocity = (0..2).map(|axis| largest(&pgv.component_as(axis, Quantity::Velocity, 1).unwrap()));
    assert_relative_eq!(velocity.fold(0.0, f64::max), 0.3, max_relative = 1e-12);
    let sa = scaled(Scaling::Sa { sa: 5.0, period: 0.5, damping: 0.05 });
    let psa = (0..2).map(|axis| measures::psa(&motion_component(&sa, axis), dt, &[0.5], 0.05)[0]);
    assert_relative_eq!(psa.fold(0.0, f64::max), 5.0, max_relative = 1e-9);

    // Squares of such samples would not be numbers, or all be 0.
    for factor in [1e200, -1e154, 1e-200] {
        refused(
            &Process::Scale(Scaling::Factor(factor)),
            &motion,
            &["scale: factor", "from 1e-30 to 1e30 m/s²"],
        );
    }
    for factor in [0.0, f64::NAN, f64::INFINITY, 1e308] {
        let mut large = motion.clone();
        Process::Scale(Scaling::Factor(10.0)).apply(&mut large).unwrap();
        large.steps.clear();
        refused(&Process::Scale(Scaling::Factor(factor)), &large, &["scale: factor"]);
    }
    for bad in [0.0, -1.0, f64::NAN] {
        refused(&Process::Scale(Scaling::Pga(bad)), &motion, &["scale: pga"]);
        refused(&Process::Scale(Scaling::Pgv(bad)), &motion, &["scale: pgv"]);
        refused(
            &Process::Scale(Scaling::Sa { sa: bad, period: 1.0, damping: 0.05 }),
            &motion,
            &["scale: sa"],
        );
        refused(
            &Process::Scale(Scaling::Sa { sa: 1.0, period: bad, damping: 0.05 }),
            &motion,
            &["scale: period"],
        );
    }
    refused(
        &Process::Scale(Scaling::Sa { sa: 1.0, period: 1.0, damping: 1.0 }),
        &motion,
        &["scale: damping"],
    );
    refused(&Process::Scale(Scaling::Pga(1.0)), &motion_of(vec![0.0; 9], dt), &["zero throughout"]);
    // The scaling of a velocity record by its PGA is that of its derivative.
    let mut velocity = motion.clone();
    Process::Convert { to: Quantity::Velocity }.apply(&mut velocity).unwrap();
    Process::Scale(Scaling::Pga(3.0)).apply(&mut velocity).unwrap();
    assert_relative_eq!(
        largest(&velocity.component_as(0, Quantity::Acceleration, 1).unwrap()),
        3.0,
        max_relative = 1e-9
    );
}

fn motion_component(motion: &Motion, axis: usize) -> Vec<f64> {
    motion.components[axis].clone().unwrap()
}

/// The unscaled test motion times a factor.
fn motion_like(motion: &Motion, factor: f64) -> Motion {
    let mut like = motion.clone();
    like.components[0] = Some(burst(3.0, motion.len(), motion.dt).into_iter().map(|v| v * factor).collect());
    like.components[1] =
        Some(burst(2.0, motion.len(), motion.dt).into_iter().map(|v| -0.25 * v * factor).collect());
    like
}

#[test]
fn the_ground_comes_to_rest_and_the_correction_is_smooth_and_small() {
    let dt = 0.01;
    let shaped = |n: usize, offset: f64, seed: u64| {
        let rise = noise(n, seed);
        let shape = |i: usize| (PI * i as f64 / n as f64).sin().powi(2);
        (0..n).map(|i| rise[i] * shape(i) + offset).collect::<Vec<f64>>()
    };
    for (n, offset) in [(3000, 0.0), (3001, 0.02), (700, -0.5), (8, 0.1)] {
        let x = shaped(n, offset, 11);
        let mut motion = motion_of(x.clone(), dt);
        Process::Rest {}.apply(&mut motion).unwrap();
        for k in [1, 4] {
            let history = |to| resample_as(x_of(&motion), dt, Quantity::Acceleration, to, k);
            let (v, d) = (history(Quantity::Velocity), history(Quantity::Displacement));
            assert!(v[v.len() - 1].abs() < 1e-12 * largest(&v), "{n} {offset} {k}: {:e}", v[v.len() - 1]);
            assert!(d[d.len() - 1].abs() < 1e-12 * largest(&d), "{n} {offset} {k}: {:e}", d[d.len() - 1]);
        }
        let correction: Vec<f64> = x_of(&motion).iter().zip(&x).map(|(a, b)| a - b).collect();
        assert_eq!((correction[0], correction[n - 1]), (0.0, 0.0));
        // c/sin² is a straight line: the correction is in the family.
        let line = |i: usize| correction[i] / (PI * i as f64 / (n - 1) as f64).sin().powi(2);
        let (a, b, c) = (line(n / 4), line(n / 2), line(2 * (n / 2) - n / 4));
        assert_relative_eq!(a + c, 2.0 * b, epsilon = 1e-9 * largest(&correction));
        let found = &motion.steps[0].found["x"];
        assert_relative_eq!(
            found["correction_peak_m_s2"].as_f64().unwrap(),
            largest(&correction),
            max_relative = 1e-9
        );
        assert_relative_eq!(
            found["correction_over_peak"].as_f64().unwrap(),
            largest(&correction) / largest(&x),
            max_relative = 1e-9
        );
        assert_relative_eq!(
            found["velocity_end_before_m_s"].as_f64().unwrap(),
            *integrate(&x, dt).last().unwrap(),
            max_relative = 1e-12
        );
    }
    refused(&Process::Rest {}, &motion_of(vec![1.0; 7], dt), &["number of samples", "at least 8"]);
    let velocity = Motion::new(dt, None, Quantity::Velocity, [Some(vec![1.0; 70]), None, None]).unwrap();
    refused(&Process::Rest {}, &velocity, &["is a velocity"]);
}

#[test]
fn a_motion_converts_when_it_is_asked_to() {
    let x = burst(3.0, 1000, 0.01);
    let mut motion = motion_of(x.clone(), 0.01);
    Process::Convert { to: Quantity::Displacement }.apply(&mut motion).unwrap();
    assert_eq!(motion.quantity, Quantity::Displacement);
    assert_eq!(motion.steps[0].found["from"], "acceleration");
    Process::Convert { to: Quantity::Acceleration }.apply(&mut motion).unwrap();
    assert_close(x_of(&motion), &x, 1e-9);
}
