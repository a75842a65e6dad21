//! Lamb's problem on a quarter of a half-space.

use crate::passes;
use hati::verify::lamb_closed_form;

#[test]
fn a_force_on_the_surface_moves_receivers_as_lamb_found() {
    passes("lamb");
}

/// The closed form against what follows from it by hand: nothing moves before the P wave, and a force
/// that changes slowly gives (1 − ν) F/(2π μ r).
#[test]
fn the_closed_form_is_causal_and_has_the_static_limit() {
    let (f, mu, r) = (1e6, 1800.0 * 200.0_f64.powi(2), 0.005);
    // at 5 mm the pulse is slow: the response is static all the time
    let static_share = 0.75 * f / (2.0 * std::f64::consts::PI * mu * r);
    let peak = lamb_closed_form(r, 0.15);
    assert!((peak / static_share - 1.0).abs() < 1e-4, "{peak} against {static_share}");
    let before = lamb_closed_form(100.0, 0.03 + 100.0 / 346.5);
    let after = lamb_closed_form(100.0, 0.15 + 100.0 / 183.9);
    assert!(before.abs() < 1e-5 * after.abs(), "{before} before, {after} at the Rayleigh wave");
}
