//! Profiles and motions that the cases share.

use crate::motion_input::{MotionInput, active_axes};
use crate::plan::{Plan, PlanError};
use crate::run::{RunError, Simulation};
use hati_inputs::motion::{Motion, Quantity};
use hati_inputs::scene::{Scene, load_str};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Uniform undamped layer, 20 m of 200 m/s over 1000 m/s.
pub(super) const UNIFORM: &str = r#"
[soil]
[[soil.layer]]
thickness = 20.0
vs = 200.0
rho = 1900.0
[soil.base]
kind = "elastic"
vs = 1000.0
rho = 2300.0
"#;

/// Three damped layers, 30 m of 150/250/400 m/s over 800 m/s.
pub(super) const THREE_LAYERS: &str = r#"
[soil]
[[soil.layer]]
thickness = 5.0
vs = 150.0
rho = 1800.0
damping = 0.02
[[soil.layer]]
thickness = 10.0
vs = 250.0
rho = 1900.0
damping = 0.02
[[soil.layer]]
thickness = 15.0
vs = 400.0
rho = 2000.0
damping = 0.01
[soil.base]
kind = "elastic"
vs = 800.0
rho = 2200.0
"#;

/// Twenty layers of 1 to 3 m whose speed rises with depth, with soft and stiff ones between.
pub(super) fn twenty_layers() -> String {
    let mut text = String::from("[soil]\n");
    for i in 0..20 {
        let thickness = 1.0 + (i * 7 % 5) as f64 * 0.5;
        let vs = 130.0 + 14.0 * i as f64 + if i % 3 == 0 { -25.0 } else { 15.0 };
        let damping = 0.04 - 0.0015 * i as f64;
        text.push_str(&format!(
            "[[soil.layer]]\nthickness = {thickness}\nvs = {vs}\nrho = {}\ndamping = {damping}\n",
            1700.0 + 20.0 * i as f64
        ));
    }
    text + "[soil.base]\nkind = \"elastic\"\nvs = 760.0\nrho = 2200.0\n"
}

/// 100 m of 300 to 500 m/s with 4 m of soft clay at 40 m.
pub(super) const SOFT_LAYER: &str = r#"
[soil]
[[soil.layer]]
thickness = 40.0
vs = 300.0
rho = 1900.0
damping = 0.02
[[soil.layer]]
thickness = 4.0
vs = 110.0
rho = 1600.0
damping = 0.05
[[soil.layer]]
thickness = 56.0
vs = 500.0
rho = 2050.0
damping = 0.01
[soil.base]
kind = "elastic"
vs = 1100.0
rho = 2350.0
"#;

/// A scene along x from a soil section and extra keys; a fault of the text comes out as an error.
pub fn scene_with(
    soil: &str,
    kind: &str,
    accuracy: f64,
    motion: &str,
    rest: &str,
) -> Result<Scene, RunError> {
    scene_along('x', soil, kind, accuracy, motion, rest)
}

/// A scene along one axis.
pub(super) fn scene_along(
    axis: char,
    soil: &str,
    kind: &str,
    accuracy: f64,
    motion: &str,
    rest: &str,
) -> Result<Scene, RunError> {
    let text = format!(
        "version = 1\naccuracy = {accuracy:e}\n[motion]\nkind = \"{kind}\"\n{motion}\n[motion.{axis}]\n\
         wavelet = {{ kind = \"ricker\", frequency = 8.0, amplitude = 1.0, time = 0.5, dt = 0.01, duration = 2.0 }}\n{soil}\n{rest}\n"
    );
    load_str(&text, "built-in scene", &[]).map_err(|d| RunError::Scene(Box::new(d)))
}

/// Plans a scene of one component for an acceleration in place of its own motion, and runs it.
pub fn simulate(scene: &Scene, acceleration: Vec<f64>, dt: f64) -> Result<(Plan, Simulation), RunError> {
    let mut components = [None, None, None];
    components[active_axes(scene).first().copied().unwrap_or(0)] = Some(acceleration);
    let motion = Motion::new(dt, None, Quantity::Acceleration, components).map_err(PlanError::from)?;
    let input = MotionInput { motion, channels: vec![], scale: None, warnings: vec![] };
    let plan = Plan::with_input(scene, input)?;
    let mut simulation = Simulation::new(&plan)?;
    simulation.run_through(&plan)?;
    Ok((plan, simulation))
}

/// A repeatable accelerogram, m/s²: noise filtered to a ground of 2.5 Hz (Kanai–Tajimi) under a
/// rise–stay–decay envelope; harmonics 0.1 to 20 Hz.
pub fn accelerogram(dt: f64, duration: f64) -> Vec<f64> {
    let n = (duration / dt).round() as usize + 1;
    let df = 1.0 / duration;
    let mut seed = 20_160_824_u64;
    let mut phase = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2.0 * PI * (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let harmonics: Vec<(f64, f64, f64)> = (1..)
        .map(|k| k as f64 * df)
        .skip_while(|f| *f < 0.1)
        .take_while(|f| *f < 20.0)
        .map(|f| {
            let (r, xi) = (f / 2.5, 0.6);
            let top = 1.0 + 4.0 * xi * xi * r * r;
            let bottom = (1.0 - r * r).powi(2) + 4.0 * xi * xi * r * r;
            let edge = 1.0 / (1.0 + (0.3 / f).powi(4)) / (1.0 + (f / 14.0).powi(8));
            (2.0 * PI * f, (top / bottom).sqrt() * edge, phase())
        })
        .collect();
    let mut a: Vec<f64> = (0..n)
        .map(|i| {
            let t = i as f64 * dt;
            let s = t / duration;
            let envelope = (s / 0.15).min(1.0).powi(2) * (-6.0 * (s - 0.4).max(0.0)).exp();
            envelope * harmonics.iter().map(|(w, a, p)| a * (w * t + p).cos()).sum::<f64>()
        })
        .collect();
    let peak = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    a.iter_mut().for_each(|x| *x *= 2.0 / peak);
    a
}

/// A Ricker pulse of acceleration.
pub(super) fn ricker(frequency: f64, time: f64, dt: f64, duration: f64) -> Vec<f64> {
    (0..=(duration / dt).round() as usize)
        .map(|i| {
            let tau = (PI * frequency * (i as f64 * dt - time)).powi(2);
            (1.0 - 2.0 * tau) * (-tau).exp()
        })
        .collect()
}

/// Fourier sum of a sampled motion at one frequency.
pub(super) fn fourier(a: &[f64], dt: f64, frequency: f64) -> Complex64 {
    let turn = Complex64::new(0.0, -2.0 * PI * frequency * dt);
    a.iter().enumerate().map(|(i, x)| x * (turn * i as f64).exp()).sum()
}
