//! El Centro 1940 NS through 20 m of 200 m/s on 1000 m/s, where the collection of references is at hand.

use crate::shared;
use hati::verify::{scene_with, simulate};
use std::path::Path;

fn columns(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    let rows: Vec<Vec<f64>> = (text.lines())
        .filter_map(|l| l.split(',').map(|x| x.trim().parse().ok()).collect::<Option<Vec<f64>>>())
        .collect();
    (0..rows[0].len()).map(|c| rows.iter().map(|r| r[c]).collect()).collect()
}

const SOIL: &str = "[soil]\n[[soil.layer]]\nthickness = 20.0\nvs = 200.0\nrho = 1900.0\n\
    [soil.base]\nkind = \"elastic\"\nvs = 1000.0\nrho = 2300.0\n";

/// The reference is a multiplication of spectra with the closed form at the record's own samples.
#[test]
fn surface_pga_and_history_of_the_uniform_layer() {
    let Some(path) = shared("reference/site_response/uniform_layer_elcentro_time.csv") else { return };
    let table = columns(&path);
    let (time, input, surface, within) = (&table[0], &table[1], &table[2], &table[3]);
    let dt = time[1] - time[0];
    // the record ends where its zero padding begins
    let end = input.iter().rposition(|a| a.abs() > 0.0).unwrap() + 1;
    let record = input[..end].to_vec();
    let scene =
        scene_with(SOIL, "outcrop", 1e-3, "band = \"full\"\nprocess = []", "[discretisation]\ntail = 10.0")
            .unwrap();
    let (plan, run) = simulate(&scene, record, dt).unwrap();
    let g = 9.80665;
    let found = |place: &str| &run.recorder.traces.iter().find(|t| t.place == place).unwrap().acceleration;
    let pga = found("surface").iter().fold(0.0_f64, |m, a| m.max(a.abs())) / g;
    println!(
        "surface PGA {pga:.4} g, {} steps per sample, order {}",
        plan.substeps, plan.discretisation.order
    );
    assert!((pga / 1.0373 - 1.0).abs() < 3e-3, "surface PGA {pga} g against 1.0373 g");
    for (place, reference) in [("surface", surface), ("within", within)] {
        let n = found(place).len().min(reference.len());
        let (mut wrong, mut right) = (0.0, 0.0);
        for (a, b) in found(place)[..n].iter().zip(reference) {
            wrong += (a - b) * (a - b);
            right += b * b;
        }
        let error = f64::sqrt(wrong / right);
        println!("{place}: relative L2 distance {error:.2e}");
        assert!(error < 1e-2, "{place}: {error}");
    }
}

#[test]
fn closed_form_with_the_textbooks_law_over_the_whole_table() {
    use hati::closed_form::{Law, surface_ratios};
    let Some(path) = shared("reference/site_response/three_layer_GIL067_tf.csv") else { return };
    let table = columns(&path);
    let soil = "[soil]\n[[soil.layer]]\nthickness = 5.0\nvs = 150.0\nrho = 1800.0\ndamping = 0.02\n\
        [[soil.layer]]\nthickness = 10.0\nvs = 250.0\nrho = 1900.0\ndamping = 0.02\n\
        [[soil.layer]]\nthickness = 15.0\nvs = 400.0\nrho = 2000.0\ndamping = 0.01\n\
        [soil.base]\nkind = \"elastic\"\nvs = 800.0\nrho = 2200.0\n";
    let scene = scene_with(soil, "outcrop", 0.3, "band = [0.2, 20.0]", "").unwrap();
    let (plan, _) = simulate(&scene, vec![0.0, 1.0, 0.0, 0.0], 0.02).unwrap();
    let mut worst = 0.0_f64;
    for (k, f) in table[0].iter().enumerate() {
        let r = surface_ratios(&plan.profile, 0, Law::Hysteretic, 0.005, *f);
        worst = worst
            .max((r.outcrop.norm() / table[5][k] - 1.0).abs())
            .max((r.within.norm() / table[6][k] - 1.0).abs());
    }
    println!("{} frequencies, worst relative difference {worst:.2e}", table[0].len());
    assert!(table[0].len() > 600 && worst < 1e-4, "{worst}");
}
