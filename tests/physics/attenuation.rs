//! Damped plane waves over twenty wavelengths, and the damping law behind them.

use hati::verify::realised_error;

#[test]
fn plane_waves_decay_and_run_as_the_exact_solution() {
    crate::passes("attenuation");
}

/// More arms carry D further, and a wider band than theirs shows.
#[test]
fn mechanisms_carry_constant_damping_over_their_bands_and_not_beyond() {
    for quality in [10.0, 25.0, 100.0] {
        for (mechanisms, carried, beyond) in [(3, 6.0, 10.0), (4, 25.0, 40.0), (5, 100.0, 150.0)] {
            let (damping, velocity) = realised_error(quality, mechanisms, carried).unwrap();
            let case = format!("Q = {quality}, {mechanisms} mechanisms over a factor {carried}");
            assert!(damping <= 5e-3 && velocity <= 5e-3, "{case}: {damping:.2e}, {velocity:.2e}");
            assert!(realised_error(quality, mechanisms, beyond).unwrap().0 > 5e-3, "{case}");
        }
    }
}
