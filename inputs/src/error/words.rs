//! Parts of the texts of errors.

use crate::number::brief;

/// How many elements beside the first have a fault.
pub(super) fn and_others(count: usize) -> String {
    if count == 0 { String::new() } else { format!(" (the first of {})", count + 1) }
}

/// What is said of a step that is missing or doubted.
pub(super) fn no_step(doubt: Option<&str>) -> String {
    match doubt {
        Some(doubt) => format!("no sure time step: {doubt}"),
        None => "no time step: the file holds values without times".into(),
    }
}

/// How a step is given, with its value where that is known.
pub(super) fn step_options(dt: Option<f64>) -> String {
    dt.map(brief).map_or_else(|| "--dt or `dt`".into(), |dt| format!("--dt {dt} (dt = {dt} in a scene)"))
}
