//! `summary.json` of a run in two or three dimensions.

use super::plan::VolumePlan;
use super::run::Progress;
use crate::motion_input::measures_json;
use crate::results::{AXES, Trace};
use hati_inputs::measures::Measures;
use hati_inputs::scene::Scene;
use serde_json::{Value, json};

/// The summary of a run; `traces` are the stations' motions.
pub(super) fn summary(
    scene: &Scene,
    plan: &VolumePlan,
    progress: &Progress,
    traces: &[Trace],
    status: &str,
) -> Value {
    let ledger = &progress.ledger;
    let taken = progress.sample.saturating_sub(1) * plan.sampling.stride + 1;
    let steps = (taken as u64).min(plan.sampling.steps());
    let work = steps as f64 * plan.points() as f64;
    let element_steps = steps as f64 * plan.elements() as f64;
    json!({
        "title": scene.title, "hati_version": env!("CARGO_PKG_VERSION"), "format_version": 1, "status": status,
        "accuracy": { "asked": scene.accuracy },
        "model": plan.model_json(),
        "plan": plan.reasons.iter().map(|r| format!("{} = {}: {}", r.key, r.value, r.why)).collect::<Vec<_>>(),
        "energy": {
            "unit": if plan.dimension == 2 { "J/m" } else { "J" },
            "closing_error": ledger.closing_error(), "input": ledger.last.input, "viscous": ledger.last.viscous,
            "outflow": ledger.last.outflow, "stored_end": ledger.last.stored(), "stored_max": ledger.stored_max,
        },
        "cost": {
            "threads": plan.threads,
            "solver_s": progress.seconds, "steps_s": progress.step_seconds,
            "ns_per_point_step": 1e9 * progress.step_seconds / work.max(1.0),
            "element_steps_per_s": element_steps / progress.seconds.max(1e-9),
            "output_share": 1.0 - progress.step_seconds / progress.seconds.max(1e-9),
            "waited_for_disk_s": progress.waited,
            "solver_estimated_s": plan.seconds(),
        },
        "checkpoints": progress.checkpoints, "restarts": progress.restarts,
        "outputs": outputs(plan),
        "warnings": plan.warnings,
        "results": results(plan, traces),
        // tests/cli/volume.rs, `a_run_leaves_its_files_and_threads_change_no_bit`, and sem/tests/solid/parity.rs hold it
        "same_bits_for_any_thread_count": true,
    })
}

/// What a run leaves in its folder.
fn outputs(plan: &VolumePlan) -> Vec<&'static str> {
    let mut names = vec!["scene.resolved.toml"];
    names.extend((!plan.sensors.is_empty()).then_some("stations.nc"));
    names.extend(plan.surface.as_ref().map(|_| "surface.nc"));
    names.extend(plan.volume.as_ref().map(|_| "volume.nc"));
    names.extend(plan.field.as_ref().map(|_| "field.nc"));
    names.extend(["ledger.nc", "report.html", "figures/", "summary.json"]);
    names
}

/// Peaks, intensities and durations of every station: `{place: {axis: {pga, …}}}`.
fn results(plan: &VolumePlan, traces: &[Trace]) -> Value {
    let mut places = serde_json::Map::new();
    let lowest = plan.frequencies.damping_band().0;
    for t in traces {
        let entry = places.entry(t.place.clone()).or_insert_with(|| json!({}));
        let entry = &mut entry[AXES[t.axis].to_string()];
        *entry = json!({});
        if t.acceleration.len() > 1 {
            *entry = measures_json(&Measures::of(&t.acceleration, plan.sampling.sample_dt(), lowest));
        }
        // only what the station was asked for is there
        let peak = |x: &[f64]| x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (key, motion) in [("pgv", &t.velocity), ("pgd", &t.displacement)] {
            if !motion.is_empty() {
                entry[key] = json!(peak(motion));
            }
        }
    }
    for sensor in &plan.sensors {
        if let Some(entry) = places.get_mut(&sensor.name) {
            entry["position"] = json!(sensor.probe.position);
        }
    }
    Value::Object(places)
}
