//! The hot loop allocates nothing: steps and samples, through a whole run.

use hati::plan::Plan;
use hati::run::Simulation;
use hati::verify::{accelerogram, scene_with, simulate};

const SOIL: &str = "[soil]\n[[soil.layer]]\nthickness = 8.0\nvs = 150.0\nrho = 1800.0\ndamping = 0.05\n\
    [[soil.layer]]\nthickness = 12.0\nvs = 300.0\nrho = 1950.0\ndamping = 0.02\n\
    [soil.base]\nkind = \"elastic\"\nvs = 700.0\nrho = 2200.0\n";

fn allocations(plan: &Plan) -> u64 {
    let mut simulation = Simulation::new(plan).unwrap();
    let counted = allocation_counter::measure(|| {
        // as many samples as fit between two appends to the files
        for _ in 0..plan.samples.min(hati::run::CHUNK) {
            simulation.advance(plan).unwrap();
        }
    });
    counted.count_total
}

#[test]
fn steps_and_samples_allocate_nothing() {
    for kind in ["outcrop", "within"] {
        let scene = scene_with(SOIL, kind, 1e-2, "", "").unwrap();
        let (plan, _) = simulate(&scene, accelerogram(0.01, 8.0), 0.01).unwrap();
        assert!(plan.mechanisms > 0 && !plan.field_depths.is_empty() && plan.samples > 500);
        assert_eq!(allocations(&plan), 0, "{kind}");
    }
    // the counter does count
    assert!(allocation_counter::measure(|| drop(std::hint::black_box(vec![1.0_f64; 10]))).count_total > 0);
}
