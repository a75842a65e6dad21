//! Against closed forms and references.
#![allow(clippy::print_stdout, reason = "a test says what it skipped and what it found")]

mod attenuation;
mod borehole_pair;
mod el_centro;
mod lamb;
mod loh1;

use hati::verify::verify;
use std::path::{Path, PathBuf};

/// A path inside the collection of references, or a word that it is not at hand.
fn shared(inside: &str) -> Option<PathBuf> {
    let root = std::env::var_os("HATI_SHARED").map(PathBuf::from);
    let root = root.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"));
    let path = root.join(inside);
    if path.exists() {
        return Some(path);
    }
    println!("SKIPPED: {} is not at hand (set HATI_SHARED)", path.display());
    None
}

fn passes(case: &str) {
    let checks = verify(&|name| name == case, false, &mut |_| ()).unwrap();
    assert!(!checks.is_empty(), "no case {case}");
    let failed: Vec<String> = checks.iter().filter(|c| !c.pass).map(ToString::to_string).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn undamped_layer_peaks_at_the_ratio_of_impedances() {
    passes("uniform-layer");
}

#[test]
fn closed_form_agrees_with_an_independent_table() {
    passes("three-layer-table");
}

#[test]
fn time_domain_column_is_the_causal_closed_form() {
    passes("three-layer-column");
}

#[test]
fn damping_is_constant_over_two_decades() {
    passes("damping-fit");
}

#[test]
fn surface_pga_is_that_of_the_closed_form() {
    passes("surface-pga");
}

#[test]
fn a_surface_record_comes_back_from_its_deconvolution() {
    passes("deconvolution");
}

#[test]
fn closed_form_of_a_borehole_pair_agrees_with_assembled_stiffness() {
    passes("borehole-pair");
}

#[test]
fn spectra_and_intensities_are_those_of_closed_forms() {
    passes("spectra");
    passes("intensity");
}

#[test]
fn a_motion_is_matched_to_a_design_spectrum() {
    passes("matching");
}
