//! The checks themselves are checked: with one constant of a case changed by three times its limit,
//! every quantity of every case fails.

use hati::verify::{names, self_check};

fn notices(case: &str) {
    let checks = self_check(&|name| name == case, false, &mut |_| ()).unwrap();
    assert!(!checks.is_empty(), "no case {case}");
    let blind: Vec<String> = checks.iter().filter(|c| c.pass).map(ToString::to_string).collect();
    assert!(blind.is_empty(), "blind:\n{}", blind.join("\n"));
}

#[test]
fn cases_of_the_frequency_domain_notice() {
    ["uniform-layer", "three-layer-table", "three-layer-column", "damping-fit", "borehole-pair"]
        .into_iter()
        .for_each(notices);
}

#[test]
fn cases_of_the_time_loop_notice() {
    ["standing-wave", "step-bound", "energy-ledger"].into_iter().for_each(notices);
}

#[test]
fn cases_with_an_accelerogram_notice() {
    ["surface-pga", "deconvolution"].into_iter().for_each(notices);
}

#[test]
fn cases_of_records_notice() {
    ["spectra", "intensity", "matching"].into_iter().for_each(notices);
}

#[test]
fn the_accuracy_case_notices() {
    ["accuracy", "accuracy-kinds"].into_iter().for_each(notices);
}

#[test]
fn cases_of_the_solid_notice() {
    ["manufactured", "dispersion", "attenuation", "attenuation-coarse", "solid-step-bound"]
        .into_iter()
        .for_each(notices);
}

#[test]
fn lambs_problem_notices() {
    notices("lamb");
}

#[test]
fn every_short_case_stands_in_one_of_these_tests() {
    let listed = [
        "uniform-layer",
        "three-layer-table",
        "three-layer-column",
        "damping-fit",
        "standing-wave",
        "step-bound",
        "energy-ledger",
        "borehole-pair",
        "surface-pga",
        "deconvolution",
        "spectra",
        "intensity",
        "matching",
        "accuracy",
        "accuracy-kinds",
        "manufactured",
        "dispersion",
        "attenuation",
        "attenuation-coarse",
        "solid-step-bound",
        "lamb",
        "lamb-fine",
        "lamb-chart",
        "loh1",
        "step-bound-million",
    ];
    assert_eq!(names(), listed);
}
