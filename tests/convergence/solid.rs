//! Errors of the manufactured solution on bent meshes, D = 2 and 3, as they were stored.

use hati::verify::{manufactured_error, manufactured_sizes};

/// `hati verify manufactured` gives the orders; this table has the errors behind them. A change of more than 1 % is a
/// change of the method and wants an explanation.
const STORED: &str = include_str!("tables/manufactured.csv");

/// Errors stored for a dimension and an order: elements per edge, relative L2 error.
fn stored(dimension: usize, order: usize) -> Vec<(usize, f64)> {
    let rows = STORED.lines().skip(1).map(|line| {
        let cells: Vec<f64> = line.split(',').take(4).map(|cell| cell.parse().unwrap()).collect();
        (cells[0] as usize, cells[1] as usize, cells[2] as usize, cells[3])
    });
    rows.filter(|r| (r.0, r.1) == (dimension, order)).map(|r| (r.2, r.3)).collect()
}

/// Every error within 1 % of the table; every refinement of the order N + 1 or better, the last of about that order.
fn holds(dimension: usize, orders: std::ops::RangeInclusive<usize>) {
    for order in orders {
        let table = stored(dimension, order);
        let sizes: Vec<usize> = table.iter().map(|row| row.0).collect();
        assert_eq!(sizes, manufactured_sizes(dimension, order), "D = {dimension}, N = {order}");
        let mut before: Option<(usize, f64)> = None;
        let mut observed = f64::NAN;
        for (elements, expected) in table {
            let error = manufactured_error(dimension, order, elements, 1.0).unwrap();
            let case = format!("D = {dimension}, N = {order}, {elements} elements per edge");
            assert!((error / expected - 1.0).abs() < 0.01, "{case}: {error:.5e}, stored {expected:.5e}");
            if let Some((coarse, wrong)) = before {
                observed = (wrong / error).ln() / (elements as f64 / coarse as f64).ln();
                assert!(observed > order as f64 + 0.9, "{case}: order {observed:.3}");
            }
            before = Some((elements, error));
        }
        assert!(observed < order as f64 + 1.3, "D = {dimension}, N = {order}: order {observed:.3}");
    }
}

#[test]
fn manufactured_errors_of_a_bent_section_are_those_stored() {
    holds(2, 2..=6);
}

#[test]
fn manufactured_errors_of_a_bent_box_are_those_stored() {
    holds(3, 2..=5);
}

#[test]
fn manufactured_errors_of_a_bent_box_of_order_six_are_those_stored() {
    holds(3, 6..=6);
}

#[test]
fn plane_waves_run_as_the_dispersion_table_says() {
    crate::passes("dispersion", 15);
}
