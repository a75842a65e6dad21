//! Damped plane waves over twenty wavelengths.

use super::bar::{Bar, Wave, unwrapped};
use crate::verify::{CaseResult, Check, twist};
use hati_sem::SemError;
use hati_sem::attenuation::{MaxwellArms, constant_damping_factor};
use hati_sem::soil::Layer;
use hati_sem::solid::{Material, Memory};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Centre of the pulse and of the band, Hz.
pub(super) const CENTRE: f64 = 10.0;

/// Mechanisms and the band's highest over its lowest frequency, as wide as they carry D to 0.5 %.
pub(super) const CARRIED: [(usize, f64); 3] = [(3, 6.0), (4, 25.0), (5, 100.0)];

/// What a wave has become after twenty wavelengths of the centre frequency, against the exact solution.
#[derive(Debug, Clone, Copy)]
struct Decay {
    /// Frequency, Hz.
    frequency: f64,
    /// Found amplitude over the exact one.
    amplitude: f64,
    /// Found phase velocity over the exact one.
    velocity: f64,
    /// Exact amplitude over that of the start.
    decayed_to: f64,
}

/// Band (Hz) around [`CENTRE`] of a ratio of its ends.
fn band(ratio: f64) -> (f64, f64) {
    (CENTRE / ratio.sqrt(), CENTRE * ratio.sqrt())
}

pub(super) fn material(quality: f64, mechanisms: usize, ratio: f64) -> Result<Material, SemError> {
    let damping = 0.5 / quality;
    let layer = Layer {
        name: "soil".into(),
        thickness: 1.0,
        vs: 200.0,
        vp: 400.0,
        rho: 1900.0,
        damping_s: damping,
        damping_p: damping,
    };
    Material::of_layer(&layer, CENTRE, band(ratio), mechanisms)
}

/// Decay of a plane wave of a quality factor, at seven tenths, once and 1.4 times the centre frequency.
///
/// Exact: $e^{-ikX}$, $k = \omega\sqrt{\rho/G(\omega)}$, with the modulus that the memory variables have in
/// continuous time, `speed_factor` times the speed (1).
fn decay(
    wave: Wave,
    quality: f64,
    mechanisms: usize,
    ratio: f64,
    speed_factor: f64,
) -> Result<Vec<Decay>, SemError> {
    let material = material(quality, mechanisms, ratio)?;
    let (speed, arms) =
        if wave == Wave::P { (material.vp, &material.constrained) } else { (material.vs, &material.shear) };
    let (order, per_wavelength) = (5, 3_usize);
    let size = speed / CENTRE / per_wavelength as f64;
    let fastest = speed * arms.unrelaxed().sqrt();
    let between = 20 * per_wavelength;
    let arms = arms.clone();
    let bar = Bar {
        dimension: 2,
        wave,
        order,
        size,
        speed: fastest,
        centre: CENTRE,
        bell: 1.0,
        part: 0.4,
        near: 2,
        between,
        material,
        memory: Memory::Full,
    };
    let frequencies = [0.7, 1.0, 1.4].map(|f| f * CENTRE);
    let distance = between as f64 * size;
    let found = bar.transfer(&frequencies)?;
    Ok(frequencies
        .iter()
        .zip(found)
        .map(|(&f, h)| against_exact(f, h, &arms, speed, distance, speed_factor))
        .collect())
}

fn against_exact(
    frequency: f64,
    h: Complex64,
    arms: &MaxwellArms,
    speed: f64,
    distance: f64,
    factor: f64,
) -> Decay {
    let i_omega = Complex64::new(0.0, TAU * frequency);
    // −ik X
    let exponent = -i_omega / (speed * arms.factor(i_omega).sqrt()) * distance;
    let phase = unwrapped(h.arg(), exponent.im);
    let exact = exponent / factor;
    Decay {
        frequency,
        amplitude: h.norm() / exact.re.exp(),
        velocity: exact.im / phase,
        decayed_to: exact.re.exp(),
    }
}

/// Largest relative errors of damping ratio and phase velocity of `mechanisms` arms against constant D and its causal
/// dispersion, over the band in which they are fitted.
///
/// Errors: those of the fit.
pub fn realised_error(quality: f64, mechanisms: usize, ratio: f64) -> Result<(f64, f64), SemError> {
    let damping = 0.5 / quality;
    let (low, high) = band(ratio);
    let arms = MaxwellArms::fit(damping, CENTRE, (low, high), mechanisms)?;
    let mut worst = (0.0_f64, 0.0_f64);
    for i in 0..=400 {
        let frequency = low * (high / low).powf(f64::from(i) / 400.0);
        let i_omega = Complex64::new(0.0, TAU * frequency);
        let exact = constant_damping_factor(damping, i_omega / (TAU * CENTRE));
        let found = arms.factor(i_omega);
        // the phase velocity is 1/Re(1/c) with c = √(G/ρ)
        let velocity = |g: Complex64| 1.0 / (1.0 / g.sqrt()).re;
        worst.0 = worst.0.max((0.5 * found.im / found.re / damping - 1.0).abs());
        worst.1 = worst.1.max((velocity(found) / velocity(exact) - 1.0).abs());
    }
    Ok(worst)
}

/// Amplitude and phase velocity of P and SV waves after twenty wavelengths and more; damping and causal dispersion of
/// the modulus. Twist: the speed of the exact waves, the damping asked for.
pub(in crate::verify) fn attenuation(twisted: bool) -> CaseResult {
    const CASE: &str = "attenuation";
    const LIMIT: f64 = 1e-2;
    const MODULUS: f64 = 5e-3;
    let mut checks = vec![];
    for quality in [25.0, 50.0, 100.0] {
        for (mechanisms, ratio) in CARRIED {
            let (damping, velocity) = realised_error(quality, mechanisms, ratio)?;
            let word =
                format!("Q = {quality}, {mechanisms} mechanisms, f_max/f_min = {ratio}: largest error of");
            let more = if twisted { 3.0 * MODULUS } else { 0.0 };
            checks.push(Check::error(CASE, format!("{word} D"), damping + more, MODULUS));
            checks.push(Check::error(CASE, format!("{word} the phase velocity"), velocity + more, MODULUS));
        }
        for wave in [Wave::P, Wave::Sv] {
            let (mechanisms, ratio) = CARRIED[0];
            for d in decay(wave, quality, mechanisms, ratio, twist(twisted, LIMIT))? {
                let word = format!(
                    "{}, Q = {quality}, {} Hz, decayed to {:.3}: ",
                    wave.name(),
                    d.frequency,
                    d.decayed_to
                );
                checks.push(Check::relative(CASE, format!("{word}amplitude"), d.amplitude, 1.0, LIMIT));
                checks.push(Check::relative(CASE, format!("{word}phase velocity"), d.velocity, 1.0, LIMIT));
            }
        }
    }
    Ok(checks)
}
