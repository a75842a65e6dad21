//! The ledger closes to round-off, whatever drives the column.

use hati::verify::{accelerogram, scene_with, simulate, verify};

#[test]
fn closes_elastic_and_damped() {
    let checks = verify(&|name| name == "energy-ledger", false, &mut |_| ()).unwrap();
    assert_eq!(checks.len(), 2);
    assert!(checks.iter().all(|c| c.pass), "{checks:?}");
}

const SOIL: &str = "[soil]\n[[soil.layer]]\nthickness = 8.0\nvs = 150.0\nrho = 1800.0\ndamping = 0.05\n\
    [[soil.layer]]\nthickness = 12.0\nvs = 300.0\nrho = 1950.0\ndamping = 0.02\n[soil.base]\n";

#[test]
fn closes_for_every_kind_of_motion_and_base_and_its_lines_have_their_sign() {
    let elastic = format!("{SOIL}kind = \"elastic\"\nvs = 700.0\nrho = 2200.0\n");
    let rigid = format!("{SOIL}kind = \"rigid\"\n");
    for (kind, soil) in [
        ("outcrop", &elastic),
        ("within", &elastic),
        ("surface", &elastic),
        ("within", &rigid),
        ("surface", &rigid),
    ] {
        let scene = scene_with(soil, kind, 1e-2, "", "").unwrap();
        let (plan, run) = simulate(&scene, accelerogram(0.01, 15.0), 0.01).unwrap();
        let ledger = run.recorder.ledger;
        assert!(ledger.closing_error() < 1e-11, "{kind}: {}", ledger.closing_error());
        let last = ledger.last;
        assert!(last.viscous > 1e-3 * last.input, "{kind}: a damped column loses energy: {last:?}");
        assert_eq!(
            last.outflow > 0.0,
            !plan.imposed(),
            "{kind}: only an elastic base lets energy out: {last:?}"
        );
        for rows in run.recorder.ledger_rows.windows(2) {
            assert!(rows[1].viscous >= rows[0].viscous, "{kind}: viscous loss never comes back");
            assert!(rows[1].outflow >= rows[0].outflow, "{kind}: nor does what left");
            assert!(rows[1].kinetic >= 0.0);
        }
    }
}

#[test]
fn the_viscous_loss_is_proportional_to_a_small_damping() {
    let loss = |factor: f64| {
        let soil = SOIL
            .replace("0.05", &format!("{}", 0.05 * factor))
            .replace("0.02", &format!("{}", 0.02 * factor));
        let soil = format!("{soil}kind = \"elastic\"\nvs = 700.0\nrho = 2200.0\n");
        let scene = scene_with(&soil, "outcrop", 1e-3, "", "").unwrap();
        simulate(&scene, accelerogram(0.01, 15.0), 0.01).unwrap().1.recorder.ledger.last.viscous
    };
    let (small, twice) = (loss(0.02), loss(0.04));
    assert!((twice / small - 2.0).abs() < 0.02, "{small} J/m² against {twice} J/m² at twice the damping");
}
