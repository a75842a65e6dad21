//! The response spectrum of El Centro 1940 NS against the numbers of another program.
//!
//! That program takes the largest of the samples, of which an oscillator of period T has T/dt: it falls
//! short by up to (π dt/T)²/2. It lets the response of the padded record run round (82 s), which shows
//! from periods of 2.5 s on. Between the two, both must agree.
//!
//! The reference is no part of the project: HATI_SHARED names its folder, or it lies in `../shared` of
//! the workspace. Where it is absent the test says so and passes.

use std::f64::consts::PI;
use std::io::Write;
use std::path::{Path, PathBuf};

use hati_inputs::measures::psa;

fn columns(path: &Path) -> Option<Vec<Vec<f64>>> {
    let text = std::fs::read_to_string(path).ok()?;
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    Some(rows.map(|row| row.split(',').map(|cell| cell.trim().parse().unwrap()).collect()).collect())
}

#[test]
fn el_centro_has_the_response_spectrum_of_the_reference() {
    let shared = std::env::var_os("HATI_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    let folder = shared.join("reference/site_response");
    let motion = columns(&folder.join("uniform_layer_elcentro_time.csv"));
    let spectrum = columns(&folder.join("uniform_layer_elcentro_rs5.csv"));
    let (Some(motion), Some(spectrum)) = (motion, spectrum) else {
        let _ = writeln!(std::io::stderr(), "skipped: no reference spectra (HATI_SHARED or ../shared)");
        return;
    };
    let dt = motion[1][0] - motion[0][0];
    for (column, reference) in [(1, 1), (2, 2)] {
        let a: Vec<f64> = motion.iter().map(|row| row[column]).collect();
        let periods: Vec<f64> = spectrum.iter().map(|row| 1.0 / row[0]).collect();
        let found = psa(&a, dt, &periods, 0.05);
        let mut compared = 0;
        for ((period, psa), row) in periods.iter().zip(&found).zip(&spectrum) {
            if *period > 2.5 {
                continue;
            }
            let ratio = psa / 9.80665 / row[reference];
            let missed = 0.5 * (PI * dt / period).powi(2);
            assert!(ratio > 0.998, "column {column}, T = {period} s: {ratio}");
            if missed < 0.02 {
                assert!(ratio < 1.003 + missed, "column {column}, T = {period} s: {ratio}");
                compared += 1;
            }
        }
        assert!(compared >= 15, "{compared} periods compared");
    }
}
