//! A pair of records, one in the borehole and one at the surface, by the closed form.

use super::fixtures::accelerogram;
use super::{CaseResult, Check, twist};
use crate::closed_form::{Law, surface_ratios};
use crate::spectrum::filtered;
use hati_sem::soil::{Base, Layer, Profile};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Thickness (m), speed (m/s), density (kg/m³) and damping ratio of the layers over the borehole's sensor.
const LAYERS: [(f64, f64, f64, f64); 3] =
    [(5.0, 150.0, 1800.0, 0.02), (10.0, 250.0, 1900.0, 0.02), (15.0, 400.0, 2000.0, 0.01)];

/// The profile between the two sensors: 30 m in three damped layers over 800 m/s.
pub fn pair_profile() -> Profile {
    let layer = |(thickness, vs, rho, damping)| Layer {
        name: "layer".into(),
        thickness,
        vs,
        vp: 2.0 * vs,
        rho,
        damping_s: damping,
        damping_p: damping,
    };
    Profile {
        layers: LAYERS.into_iter().map(layer).collect(),
        base: Base::Elastic { vs: 800.0, vp: 1600.0, rho: 2200.0 },
        reference_frequency: 1.0,
    }
}

/// Surface motion from the motion at the borehole's sensor (within), G(1 + 2iD), spectrum times closed form.
///
/// Both are taken as periodic over their `n` samples (a record that is quiet at its end is so): G(1 + 2iD) has
/// no causal response, what it sends before the motion comes in at the other end. `a` in m/s², step `dt` in s;
/// `n` should be even with small prime factors, else zeros are added.
pub fn surface_from_within(profile: &Profile, axis: usize, a: &[f64], dt: f64) -> Vec<f64> {
    filtered(a, dt, 0.0, |f| surface_ratios(profile, axis, Law::Hysteretic, 0.0, f).within)
}

/// Surface over base displacement by the assembled stiffness of the layers at one frequency (Hz).
///
/// A layer joins its two faces by `(ρ c ω/ sin kh) [[cos kh, −1], [−1, cos kh]]`, k = ω/c, c = √(G(1 + 2iD)/ρ)
/// (Kausel and Roësset, 1981); the free surface bears no force, and the base moves by one. Eliminated from
/// the surface down: no wave amplitudes, so it shares nothing with the closed form but the law of the soil.
fn by_stiffness(profile: &Profile, frequency: f64) -> Complex64 {
    let omega = 2.0 * PI * frequency;
    let (mut above, mut product) = (Complex64::ZERO, Complex64::ONE);
    for layer in &profile.layers {
        let c = layer.vs * Complex64::new(1.0, 2.0 * layer.damping_s).sqrt();
        let kh = omega * layer.thickness / c;
        let scale = layer.rho * c * omega / kh.sin();
        // The upper face's row: (above + s cos) u_upper = s u_lower.
        let upper = scale / (above + scale * kh.cos());
        product *= upper;
        above = scale * kh.cos() - scale * upper;
    }
    product
}

/// The surface motion of a pair against the one by assembled stiffness; relative L2 in time. Twist: the speed of
/// the top layer.
pub(super) fn borehole_pair(twisted: bool) -> CaseResult {
    const LIMIT: f64 = 1e-4;
    const DT: f64 = 0.01;
    let mut borehole = accelerogram(DT, 40.0);
    borehole.resize(6000, 0.0);
    let reference = filtered(&borehole, DT, 0.0, |f| by_stiffness(&pair_profile(), f));
    let mut profile = pair_profile();
    profile.layers[0].vs *= twist(twisted, LIMIT);
    let found = surface_from_within(&profile, 0, &borehole, DT);
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|v| v * v).sum::<f64>().sqrt();
    let wrong = norm(&mut found.iter().zip(&reference).map(|(a, b)| a - b));
    let error = wrong / norm(&mut reference.iter().copied());
    let quantity = "surface from borehole, G(1+2iD), relative L2 in time";
    Ok(vec![Check::error("borehole-pair", quantity, error, LIMIT)])
}
