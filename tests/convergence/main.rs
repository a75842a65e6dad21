//! Observed orders and errors that stay what they were.

mod solid;

use hati::verify::{standing_wave_error, verify};

/// Standing-wave errors (relative L2, largest over a period), stored: order, elements, error in space.
/// A change of more than 1 % is a change of the method and wants an explanation.
const STORED: [(usize, usize, f64); 8] = [
    (1, 16, 1.9302e-2),
    (2, 16, 1.4749e-4),
    (3, 8, 3.9821e-5),
    (4, 8, 1.1303e-6),
    (5, 8, 2.7153e-8),
    (6, 4, 7.1561e-8),
    (7, 4, 2.6192e-9),
    (8, 4, 8.4025e-11),
];

#[test]
fn stored_errors_of_the_standing_wave_hold_within_one_percent() {
    for (order, elements, stored) in STORED {
        let error = standing_wave_error(order, elements, 400 * elements, false, 1.0).unwrap();
        assert!(
            (error / stored - 1.0).abs() < 0.01,
            "({order}, {elements}, {error:.4e}) stored as {stored:.4e}"
        );
    }
}

#[test]
fn orders_in_size_and_step_are_those_of_the_theory() {
    passes("standing-wave", 10);
}

#[test]
fn asked_accuracy_is_reached_and_not_overdone() {
    passes("accuracy", 9);
    passes("accuracy-kinds", 4);
}

fn passes(case: &str, quantities: usize) {
    let checks = verify(&|name| name == case, false, &mut |_| ()).unwrap();
    assert_eq!(checks.len(), quantities, "{case}");
    let failed: Vec<String> = checks.iter().filter(|c| !c.pass).map(ToString::to_string).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
