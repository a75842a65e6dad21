//! Design spectra against their tables, and records matched to them.

mod python;

use std::path::Path;

use approx::assert_relative_eq;
use hati_inputs::InputError;
use hati_inputs::measures::{DesignSpectrum, log_periods, psa, response_spectrum};
use hati_inputs::motion::{Matching, Motion, Process, Quantity};
use hati_inputs::records::{ReadOptions, read};
use serde_json::json;

const G: f64 = 9.80665;

fn spectrum(value: serde_json::Value) -> DesignSpectrum {
    serde_json::from_value(value).unwrap()
}

// ---- design spectra -----------------------------------------------------------------------------

#[test]
fn regulatory_guide_160_has_its_control_points_and_straight_lines_between() {
    let horizontal = spectrum(json!({ "kind": "rg160", "pga": G, "damping": 0.05 }));
    // D: 2.05 · 0.9144 m · (2π · 0.25 Hz)² = 1.87452 m · 2.467401 s⁻².
    let at_d = 4.625_193;
    // Between two points the geometric mean of frequencies has the geometric mean of the values.
    let cases = [
        (0.01, G),
        (1.0 / 33.0, G),
        (1.0 / 297_f64.sqrt(), G * 2.61_f64.sqrt()),
        (1.0 / 9.0, 2.61 * G),
        (1.0 / 22.5_f64.sqrt(), 2.858_199 * G),
        (0.4, 3.13 * G),
        (1.0 / 0.625_f64.sqrt(), (3.13 * G * at_d).sqrt()),
        (4.0, at_d),
        (10.0, 0.16 * at_d),
    ];
    for (period, wanted) in cases {
        assert_relative_eq!(horizontal.psa(period), wanted, max_relative = 1e-6);
    }
    let factors =
        [(0.005, 4.96, 5.95, 3.20), (0.02, 3.54, 4.25, 2.5), (0.07, 2.27, 2.72, 1.88), (0.1, 1.9, 2.28, 1.7)];
    for (damping, b, c, d) in factors {
        let rows = spectrum(json!({ "kind": "rg160", "pga": G, "damping": damping }));
        for (period, wanted) in [(1.0 / 9.0, b * G), (0.4, c * G), (4.0, d * at_d / 2.05)] {
            assert_relative_eq!(rows.psa(period), wanted, max_relative = 1e-6);
        }
    }
}

/// 3 % lies a third of the way from 2 to 5 %: B = 3.54 − 0.93/3, C = 4.25 − 1.12/3.
#[test]
fn factors_of_the_guide_are_interpolated_linearly_in_damping() {
    let between = spectrum(json!({ "kind": "rg160", "pga": 1.0, "damping": 0.03 }));
    assert_relative_eq!(between.psa(1.0 / 9.0), 3.23, max_relative = 1e-12);
    assert_relative_eq!(between.psa(0.4), 4.25 - 1.12 / 3.0, max_relative = 1e-12);
    assert_relative_eq!(between.psa(0.01), 1.0);
    assert!(between.check().is_ok());
}

#[test]
fn the_vertical_spectrum_of_the_guide_is_two_thirds_at_long_periods_and_the_same_at_short_ones() {
    for (damping, c, d) in
        [(0.005, 5.67, 2.13), (0.02, 4.05, 1.67), (0.05, 2.98, 1.37), (0.07, 2.59, 1.25), (0.1, 2.17, 1.13)]
    {
        let horizontal = spectrum(json!({ "kind": "rg160", "pga": 2.0, "damping": damping }));
        let vertical = horizontal.for_axis(2);
        assert_eq!(horizontal.for_axis(0).psa(0.3), horizontal.psa(0.3));
        assert_relative_eq!(vertical.psa(1.0 / 3.5), c * 2.0, max_relative = 1e-12);
        let displacement = d * 0.9144 * 2.0 / G;
        assert_relative_eq!(vertical.psa(4.0), displacement * 2.467_401, max_relative = 1e-6);
        // The guide's text: 2/3 below 0.25 Hz (its tables round), equal above 3.5 Hz.
        assert_relative_eq!(vertical.psa(8.0) / horizontal.psa(8.0), 2.0 / 3.0, max_relative = 0.005);
        assert_relative_eq!(vertical.psa(1.0 / 9.0), horizontal.psa(1.0 / 9.0), max_relative = 1e-12);
        assert!((vertical.psa(1.0 / 3.5) / horizontal.psa(1.0 / 3.5) - 1.0).abs() < 0.005);
    }
}

#[test]
fn eurocode_8_has_its_four_branches() {
    let on = |kind: u8, ground: &str, damping: f64| {
        spectrum(
            json!({ "kind": "eurocode8", "type": kind, "ground": ground, "ag": 1.0, "damping": damping }),
        )
    };
    // S = 1.15, corners 0.2, 0.6, 2.0 s.
    let c = on(1, "C", 0.05);
    for (period, wanted) in
        [(0.0, 1.15), (0.1, 2.0125), (0.2, 2.875), (0.4, 2.875), (1.2, 1.4375), (4.0, 0.215_625)]
    {
        assert_relative_eq!(c.psa(period), wanted, max_relative = 1e-12);
    }
    // η = √(10/15) = 0.816497; at 40 % it is bounded by 0.55.
    assert_relative_eq!(on(1, "C", 0.10).psa(0.3), 2.875 * 0.816_496_6, max_relative = 1e-6);
    assert_relative_eq!(on(1, "C", 0.40).psa(0.3), 2.875 * 0.55, max_relative = 1e-12);
    // Type 2, ground D: S = 1.8, corners 0.1, 0.3, 1.2 s.
    let d = on(2, "D", 0.05);
    for (period, wanted) in [(0.05, 1.8 * 1.75), (0.2, 4.5), (0.6, 2.25), (2.4, 4.5 * 0.3 * 1.2 / 5.76)] {
        assert_relative_eq!(d.psa(period), wanted, max_relative = 1e-12);
    }
    // Vertical: a_vg = 0.90 and 0.45 a_g, corners 0.05, 0.15, 1.0 s, factor 3, no soil factor.
    for (kind, share) in [(1, 0.90), (2, 0.45)] {
        let vertical = on(kind, "E", 0.05).for_axis(2);
        for (period, wanted) in [(0.025, 2.0), (0.1, 3.0), (0.3, 1.5), (2.0, 3.0 * 0.15 / 4.0)] {
            assert_relative_eq!(vertical.psa(period), share * wanted, max_relative = 1e-12);
        }
    }
}

#[test]
fn points_are_joined_on_logarithmic_axes() {
    let points = spectrum(json!({ "kind": "points", "periods": [0.1, 0.4, 1.6], "psa": [2.0, 8.0, 0.5] }));
    for (period, wanted) in [(0.05, 2.0), (0.1, 2.0), (0.2, 4.0), (0.8, 2.0), (1.6, 0.5), (3.2, 0.125)] {
        assert_relative_eq!(points.psa(period), wanted, max_relative = 1e-12);
    }
    assert_eq!(points.for_axis(2), points);
}

#[test]
fn spectra_that_cannot_be_are_refused_with_what_would_do() {
    let cases = [
        (json!({ "kind": "rg160", "pga": 1.0, "damping": 0.004 }), "from 0.005 to 0.10"),
        (json!({ "kind": "rg160", "pga": 1.0, "damping": 0.12 }), "from 0.005 to 0.10"),
        (json!({ "kind": "rg160", "pga": -1.0 }), "pga = -1; expected a positive number"),
        (json!({ "kind": "eurocode8", "type": 1, "ground": "A", "ag": 1.0, "damping": 0.0 }), "above 0"),
        (json!({ "kind": "points", "periods": [0.1, 0.1], "psa": [1.0, 1.0] }), "a period above 0.1 s"),
        (json!({ "kind": "points", "periods": [0.1, 0.2], "psa": [1.0] }), "as many values as periods, 2"),
    ];
    for (value, text) in cases {
        let error = spectrum(value).check().unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    }
    for unknown in [
        json!({ "kind": "rg160", "pga": 1.0, "soil": 2 }),
        json!({ "kind": "eurocode8", "type": 3, "ground": "A", "ag": 1.0 }),
    ] {
        assert!(serde_json::from_value::<DesignSpectrum>(unknown).is_err());
    }
}

// ---- seeds --------------------------------------------------------------------------------------

fn one(samples: Vec<f64>, dt: f64) -> Motion {
    Motion::new(dt, Some(0.0), Quantity::Acceleration, [Some(samples), None, None]).unwrap()
}

fn x_of(motion: Motion) -> Vec<f64> {
    motion.components.into_iter().flatten().next().unwrap()
}

/// Coloured noise under a rise and an exponential decay; its velocity and displacement drift far.
fn noise(seed: u64) -> Motion {
    let mut state = seed;
    let mut coloured = 0.0;
    let sample = |i: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        coloured = 0.7 * coloured + (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        let t = i as f64 / 400.0;
        3.0 * coloured * t * t * (2.0 * (1.0 - t)).exp()
    };
    one((0..3000).map(sample).collect(), 0.01)
}

fn akt013() -> Option<Motion> {
    if !python::has_obspy() {
        return None;
    }
    let record = Path::new("obspy:io/nied/tests/data/test.knet");
    let channels = read(record, &ReadOptions::default()).unwrap();
    let mut motion = Motion::from_channels([Some(&channels[0]), None, None]).unwrap();
    Process::Demean { first_seconds: None }.apply(&mut motion).unwrap();
    Some(motion)
}

fn el_centro() -> Option<Motion> {
    let shared = std::env::var_os("HATI_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), Into::into);
    let Ok(text) = std::fs::read_to_string(shared.join("records/peer_at2/elcentro1940_NS.AT2")) else {
        python::say("skipped: no El Centro record (HATI_SHARED or ../shared)");
        return None;
    };
    let numbers = text.lines().skip(4).flat_map(str::split_whitespace);
    Some(one(numbers.map(|number| G * number.parse::<f64>().unwrap()).collect(), 0.02))
}

/// Matches, looks at the result with eyes of its own, and returns the correlation that the step states.
fn assert_matched(mut motion: Motion, target: &DesignSpectrum, periods: [f64; 2]) -> f64 {
    let matching = Matching { periods, ..Matching::to(target.clone()) };
    let (start, dt, duration) = (motion.start.unwrap(), motion.dt, motion.duration());
    matching.apply(&mut motion).unwrap();
    let a = motion.components[0].as_ref().unwrap();
    // Other periods than those that the match looks at, and more of them.
    let checks = log_periods(periods[0], periods[1], 997);
    for (period, found) in checks.iter().zip(psa(a, motion.dt, &checks, target.damping())) {
        let ratio = found / target.psa(*period);
        assert!((0.9..=1.1).contains(&ratio), "PSA is {ratio} of the target at T = {period} s");
    }
    let end = |to| motion.component_as(0, to, 1).unwrap();
    for (to, unit) in [(Quantity::Velocity, "m/s"), (Quantity::Displacement, "m")] {
        let history = end(to);
        let peak = history.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        let last = history[history.len() - 1];
        assert!(last.abs() <= 1e-10 * peak, "ends at {last} {unit}, peak {peak} {unit}");
    }
    // No drift: beyond the longest period the ground moves no more than the target's continuation says.
    let longest = response_spectrum(a, motion.dt, &[2.0 * periods[1]], target.damping()).sd[0];
    let allowed = target.psa(periods[1]) * (periods[1] / std::f64::consts::TAU).powi(2);
    assert!(longest < 1.15 * allowed, "displacement at twice the longest period: {longest} of {allowed} m");
    let found = &motion.steps.last().unwrap().found;
    let number = |key: &str| found[key].as_f64().unwrap();
    assert_relative_eq!(motion.start.unwrap(), start - number("pad_before_s"), epsilon = 1e-9);
    let padded = duration + number("pad_before_s") + number("pad_after_s");
    assert_relative_eq!(motion.duration(), padded, epsilon = 1e-9);
    assert!(motion.dt <= periods[0] / 4.0 * 1.000_001 && motion.dt <= dt);
    let entry = &found["x"];
    assert!(entry["ratio_min"].as_f64().unwrap() >= 0.9 && entry["ratio_max"].as_f64().unwrap() <= 1.1);
    entry["correlation"].as_f64().unwrap()
}

fn guide() -> DesignSpectrum {
    spectrum(json!({ "kind": "rg160", "pga": 0.2 * G, "damping": 0.05 }))
}

#[test]
fn akt013_is_matched_to_the_guide() {
    let Some(motion) = akt013() else { return };
    let correlation = assert_matched(motion, &guide(), [0.02, 10.0]);
    assert!(correlation > 0.8, "{correlation}");
}

#[test]
fn el_centro_is_matched_to_the_guide_and_to_eurocode_8() {
    let Some(motion) = el_centro() else { return };
    let correlation = assert_matched(motion.clone(), &guide(), [0.02, 10.0]);
    assert!(correlation > 0.95, "{correlation}");
    let eurocode = spectrum(json!({ "kind": "eurocode8", "type": 1, "ground": "C", "ag": 3.0 }));
    let correlation = assert_matched(motion, &eurocode, [0.02, 4.0]);
    assert!(correlation > 0.95, "{correlation}");
}

#[test]
fn noise_with_a_drift_is_matched_to_the_guide() {
    let correlation = assert_matched(noise(5), &guide(), [0.02, 10.0]);
    assert!(correlation > 0.7, "{correlation}");
}

#[test]
fn each_component_has_its_spectrum_and_the_step_repeats_the_match() {
    let [x, z] = [noise(3), noise(4)].map(|motion| motion.components.into_iter().flatten().next());
    let before = Motion::new(0.01, None, Quantity::Acceleration, [x, None, z]).unwrap();
    let target = spectrum(json!({ "kind": "eurocode8", "type": 2, "ground": "B", "ag": 1.5 }));
    let mut motion = before.clone();
    let process = Process::Match(Matching { periods: [0.1, 2.0], ..Matching::to(target.clone()) });
    process.apply(&mut motion).unwrap();
    assert_eq!(motion.dt, 0.01);
    let checks = log_periods(0.1, 2.0, 503);
    for axis in [0, 2] {
        let own = target.for_axis(axis);
        let found = psa(motion.components[axis].as_ref().unwrap(), motion.dt, &checks, 0.05);
        for (period, found) in checks.iter().zip(found) {
            assert!((found / own.psa(*period) - 1.0).abs() <= 0.1, "axis {axis}, T = {period} s");
        }
    }
    let mut again = before;
    Process::from_step(motion.steps.last().unwrap()).unwrap().apply(&mut again).unwrap();
    assert_eq!(again, motion);
}

#[test]
fn what_cannot_be_matched_is_refused_and_left_as_it_was() {
    let mut motion = noise(5);
    let before = motion.clone();
    let hasty = Matching { iterations: 1, ..Matching::to(guide()) };
    let error = hasty.apply(&mut motion).unwrap_err();
    let InputError::NotMatched { component: "x", ratio, iterations: 1, .. } = error else {
        panic!("{error}")
    };
    assert!((ratio - 1.0).abs() > 0.1);
    assert!(error.to_string().contains("PSA is") && error.to_string().contains("help:"), "{error}");
    assert_eq!(motion, before);

    let refused = |matching: Matching, mut motion: Motion, text: &str| {
        let error = matching.apply(&mut motion).unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    };
    let to = || Matching::to(guide());
    refused(to(), one(vec![0.0; 100], 0.01), "component x does not move");
    refused(to(), one(vec![1.0; 40_000], 0.02), "samples after padding and interpolation, above 131072");
    let slight = Matching::to(spectrum(json!({ "kind": "rg160", "pga": 1.0, "damping": 0.005 })));
    let lasting = one((0..8).flat_map(|seed| x_of(noise(seed))).collect(), 0.01);
    refused(slight, lasting, "at a damping of 0.005 and from 0.02 s to 10 s the match would take minutes");
    refused(Matching { periods: [0.001, 1.0], ..to() }, noise(1), "0.01 s or more");
    refused(Matching { periods: [1.0, 1.0], ..to() }, noise(1), "a longest period of 1.5 s");
    refused(Matching { tolerance: 0.0, ..to() }, noise(1), "0.02 or more");
    let mut velocity = noise(1);
    velocity.quantity = Quantity::Velocity;
    refused(to(), velocity, "the motion is a velocity");
}
