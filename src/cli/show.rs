//! Plans, summaries and progress as text.

use crate::plan::Plan;
use crate::verify::Check;
use hati_inputs::scene::Scene;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;
use std::fmt::Write as _;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

pub(super) fn count(n: usize, what: &str) -> String {
    match (n, what.strip_suffix('y')) {
        (1, _) => format!("1 {what}"),
        (_, Some(stem)) => format!("{n} {stem}ies"),
        (_, None) => format!("{n} {what}s"),
    }
}

/// The plan as a person reads it.
pub(super) fn plan(scene: &Scene, plan: &Plan) -> String {
    let mut text = format!("plan of “{}”\n", scene.title);
    let width = plan.reasons.iter().map(|r| r.key.len()).max().unwrap_or(0);
    for r in &plan.reasons {
        let _ = writeln!(text, "  {:width$}  {}\n  {:width$}    {}", r.key, r.value, "", r.why);
    }
    let json = plan.to_json();
    let bytes = |key: &str| json["cost"][key].as_f64().unwrap_or(0.0) / 1e6;
    let _ = writeln!(
        text,
        "  {} points × {} × {} steps: about {:.2} s, {:.0} MB of memory, {:.0} MB on disk",
        plan.points(),
        count(plan.axes.len(), "component"),
        plan.steps(),
        plan.search.chosen.cost,
        bytes("memory_bytes").max(1.0),
        bytes("disk_bytes").max(1.0),
    );
    for w in &plan.warnings {
        let _ = writeln!(text, "  warning: {w}");
    }
    text
}

/// A quantity of the self-check: to miss its twisted reference is what it should do.
pub(super) fn twisted(check: &Check) -> String {
    let word = if check.pass { "BLIND  " } else { "noticed" };
    format!(
        "{word} {:<20} {}: {:.6e} against {:.6e}, error {:.2e} (limit {:.1e})",
        check.case, check.quantity, check.value, check.reference, check.error, check.limit
    )
}

/// The end of a run.
pub(super) fn summary(summary: &Value) -> String {
    let number = |path: &str| summary.pointer(path).and_then(Value::as_f64).unwrap_or(f64::NAN);
    let mut text = format!(
        "{}: solver {:.3} s ({:.1} ns per point, component and step), in all {:.2} s; energy closes to {:.1e}\n",
        summary["status"].as_str().unwrap_or("ended"),
        number("/cost/solver_s"),
        number("/cost/ns_per_point_component_step"),
        number("/cost/wall_s"),
        number("/energy/closing_error"),
    );
    for axis in ["x", "y", "z"] {
        let pga =
            |place: &str| summary.pointer(&format!("/results/{place}/{axis}/pga")).and_then(Value::as_f64);
        if let Some(surface) = pga("surface") {
            let below = pga("outcrop").map(|o| format!("outcrop {o:.4}, ")).unwrap_or_default();
            let within = pga("within").unwrap_or(f64::NAN);
            let _ = writeln!(text, "  PGA {axis}: {below}within {within:.4}, surface {surface:.4} m/s²");
        }
    }
    text
}

/// Progress: a bar on a terminal, a line every ten seconds elsewhere.
pub(super) struct Meter {
    bar: Option<ProgressBar>,
    last: Instant,
}

impl Meter {
    pub(super) fn new(samples: usize) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(samples as u64);
            if let Ok(style) = ProgressStyle::with_template("  {bar:40} {percent:>3} %  {eta} left") {
                bar.set_style(style);
            }
            bar
        });
        Self { bar, last: Instant::now() }
    }

    pub(super) fn update(&mut self, done: usize, all: usize, seconds: f64) {
        match &self.bar {
            Some(bar) => bar.set_position(done as u64),
            None if self.last.elapsed() > Duration::from_secs(10) => {
                super::note(&format!("{done} of {all} samples, {seconds:.0} s"));
                self.last = Instant::now();
            }
            None => {}
        }
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
