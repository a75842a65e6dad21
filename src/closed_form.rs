//! Closed forms of the layered column in the frequency domain, the yardstick of `verify` and the
//! line drawn over the computed transfer functions. The solver never uses them.
//!
//! Vertical incidence on horizontal layers over a half-space, time factor $e^{+i\omega t}$. In layer m,
//! $u = A e^{ik z} + B e^{-ikz}$ with depth z, $k = \omega/c^*$, $c^* = \sqrt{G^*/\rho}$; continuity of
//! displacement and traction at each interface gives, with
//! $\alpha = \rho_m c_m^*/(\rho_{m+1}c_{m+1}^*)$ and h the thickness,
//! $$ A_{m+1} = \tfrac12 A(1+\alpha)e^{ikh} + \tfrac12 B(1-\alpha)e^{-ikh},\quad
//!    B_{m+1} = \tfrac12 A(1-\alpha)e^{ikh} + \tfrac12 B(1+\alpha)e^{-ikh}, $$
//! starting from $A = B$ at the free surface (Thomson 1950, Haskell 1953, in the form of Kramer 1996).
//! The outcrop motion is twice the upgoing amplitude of the half-space, the within motion the sum.

use hati_sem::attenuation::constant_damping_factor;
use hati_sem::soil::{Base, Profile};
use num_complex::Complex64;
use std::f64::consts::PI;

/// How the modulus depends on frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Constant D with the dispersion that causality demands: what a time-domain code can reproduce.
    Causal,
    /// The textbooks' $G(1 + 2iD)$ with constant Re G: not causal, frequency domain only.
    Hysteretic,
}

impl Law {
    fn factor(self, damping: f64, frequency: f64, reference: f64) -> Complex64 {
        match self {
            Law::Causal => constant_damping_factor(damping, Complex64::new(0.0, frequency / reference)),
            Law::Hysteretic => Complex64::new(1.0, 2.0 * damping),
        }
    }
}

/// The surface motion against the two motions of the base, complex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceRatios {
    /// Surface/outcrop; for a rigid base the same as surface/within.
    pub outcrop: Complex64,
    /// Surface/within.
    pub within: Complex64,
}

/// Transfer functions of a profile at one frequency (Hz, > 0) for one component.
///
/// `base_damping`: damping ratio of the half-space under the same law (the time domain has 0, a real
/// impedance; some frequency-domain programs damp it).
pub fn surface_ratios(
    profile: &Profile,
    axis: usize,
    law: Law,
    base_damping: f64,
    frequency: f64,
) -> SurfaceRatios {
    let omega = 2.0 * PI * frequency;
    let reference = profile.reference_frequency;
    let speed = |i: usize| {
        let l = &profile.layers[i];
        l.speed(axis) * law.factor(l.damping(axis), frequency, reference).sqrt()
    };
    let rock = match profile.base {
        Base::Elastic { rho, .. } => profile
            .base
            .impedance(axis)
            .map(|z| z / rho * law.factor(base_damping, frequency, reference).sqrt())
            .map(|c| (rho, c)),
        Base::Rigid => None,
    };
    // amplitudes of the present layer's top, divided by e^grown: thick damped columns overflow otherwise
    let (mut up, mut down, mut grown) = (Complex64::ONE, Complex64::ONE, 0.0_f64);
    let last = profile.layers.len() - 1;
    for i in 0..=last {
        let (rho, c) = (profile.layers[i].rho, speed(i));
        let exponent = Complex64::I * omega / c * profile.layers[i].thickness;
        grown += exponent.re.abs();
        let (a, b) =
            (up * (exponent - exponent.re.abs()).exp(), down * (-exponent - exponent.re.abs()).exp());
        let below = if i < last { Some((profile.layers[i + 1].rho, speed(i + 1))) } else { rock };
        let Some((rho_below, c_below)) = below else {
            let within = 2.0 * (-grown).exp() / (a + b);
            return SurfaceRatios { outcrop: within, within };
        };
        let alpha = rho * c / (rho_below * c_below);
        up = 0.5 * (a * (1.0 + alpha) + b * (1.0 - alpha));
        down = 0.5 * (a * (1.0 - alpha) + b * (1.0 + alpha));
    }
    let shrink = (-grown).exp();
    SurfaceRatios { outcrop: shrink / up, within: 2.0 * shrink / (up + down) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hati_sem::soil::Layer;

    fn uniform(damping: f64) -> Profile {
        let layer = Layer {
            name: "soil".into(),
            thickness: 20.0,
            vs: 200.0,
            vp: 400.0,
            rho: 1900.0,
            damping_s: damping,
            damping_p: damping,
        };
        Profile {
            layers: vec![layer],
            base: Base::Elastic { vs: 1000.0, vp: 2000.0, rho: 2300.0 },
            reference_frequency: 2.0,
        }
    }

    #[test]
    fn undamped_uniform_layer_peaks_at_the_impedance_ratio() {
        for law in [Law::Causal, Law::Hysteretic] {
            let r = surface_ratios(&uniform(0.0), 0, law, 0.0, 2.5);
            assert!((r.outcrop.norm() - 2300.0 * 1000.0 / (1900.0 * 200.0)).abs() < 1e-9);
        }
    }

    #[test]
    fn one_layer_is_the_textbook_formula_whatever_it_is_cut_into() {
        let whole = uniform(0.05);
        let mut cut = whole.clone();
        let piece = Layer { thickness: 5.0, ..whole.layers[0].clone() };
        cut.layers = vec![piece; 4];
        for f in [0.1, 1.7, 2.5, 9.3] {
            let c = 200.0 * Complex64::new(1.0, 0.1).sqrt();
            let (kh, z) = (2.0 * PI * f * 20.0 / c, 1900.0 * c / 2.3e6);
            let exact = (kh.cos() + Complex64::I * z * kh.sin()).inv();
            for p in [&whole, &cut] {
                let r = surface_ratios(p, 0, Law::Hysteretic, 0.0, f);
                assert!((r.outcrop - exact).norm() < 1e-12 * exact.norm());
                assert!((r.within - kh.cos().inv()).norm() < 1e-12 * r.within.norm());
            }
        }
    }

    #[test]
    fn a_thick_damped_column_attenuates_without_overflow() {
        let mut p = uniform(0.3);
        p.layers[0].thickness = 20_000.0;
        let r = surface_ratios(&p, 0, Law::Causal, 0.0, 20.0);
        assert!(r.outcrop.norm() < 1e-200 && r.within.norm() < 1e-200, "{r:?}");
    }

    #[test]
    fn a_rigid_base_has_one_ratio() {
        let p = Profile { base: Base::Rigid, ..uniform(0.02) };
        let r = surface_ratios(&p, 0, Law::Causal, 0.0, 3.3);
        assert_eq!(r.outcrop, r.within);
    }
}
