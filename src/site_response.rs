//! What the report of a site response draws: a finished run, with the closed forms over it.

use crate::closed_form::{Law, surface_ratios};
use crate::outputs::OutputError;
use crate::plan::Plan;
use crate::report::write_report;
use crate::results::{LayerView, SiteResponse, TransferFunction};
use crate::run::{Outcome, Ratio, start_iso, transfer_ratios};
use hati_inputs::scene::Scene;
use hati_sem::soil::Base;
use num_complex::Complex64;
use std::path::Path;

/// Writes `report.html` and `figures/` of a run into its folder. Takes what the run recorded, so that
/// nothing large is held twice.
pub fn report(scene: &Scene, plan: &Plan, outcome: Outcome, out: &Path) -> Result<(), OutputError> {
    write_report(out, &site_response(scene, plan, outcome))
}

/// Everything that the report needs.
pub fn site_response(scene: &Scene, plan: &Plan, outcome: Outcome) -> SiteResponse {
    let Outcome { simulation, summary, .. } = outcome;
    let taken = simulation.recorder.samples_taken();
    let transfer =
        transfer_ratios(plan, &simulation).into_iter().map(|r| with_closed_forms(plan, r)).collect();
    let mut traces = simulation.outcrop_traces(plan);
    for t in &mut traces {
        [&mut t.acceleration, &mut t.velocity, &mut t.displacement]
            .into_iter()
            .for_each(|x| x.truncate(taken));
    }
    let recorder = simulation.recorder;
    traces.extend(recorder.traces);
    SiteResponse {
        title: scene.title.clone(),
        dt: plan.sample_dt,
        time_first: plan.time_first(),
        start: start_iso(plan),
        layers: layers(plan),
        traces,
        peaks: recorder.peaks,
        transfer,
        sections: recorder.sections,
        ledger: recorder.ledger_rows,
        summary,
    }
}

fn layers(plan: &Plan) -> Vec<LayerView> {
    let top = plan.profile.interfaces();
    // the damping that the report draws is that of the components that move
    let axis = if plan.axes == [2] { 2 } else { 0 };
    let mut layers: Vec<LayerView> = (plan.profile.layers.iter().enumerate())
        .map(|(i, l)| LayerView {
            name: l.name.clone(),
            top: top[i],
            bottom: top[i + 1],
            vs: l.vs,
            vp: l.vp,
            rho: l.rho,
            damping: l.damping(axis),
        })
        .collect();
    if let Base::Elastic { vs, vp, rho } = plan.profile.base {
        let top = plan.profile.depth();
        layers.push(LayerView {
            name: "half-space".into(),
            top,
            bottom: f64::INFINITY,
            vs,
            vp,
            rho,
            damping: 0.0,
        });
    }
    layers
}

/// Frequencies at which the closed forms are drawn besides those of the run, so that no pole is missed.
const CLOSED_FORM_POINTS: usize = 1500;

fn with_closed_forms(plan: &Plan, run: Ratio) -> TransferFunction {
    let outcrop = run.name.ends_with("outcrop");
    let mut grid: Vec<f64> = (0..CLOSED_FORM_POINTS)
        .map(|i| plan.band.0 + (plan.band.1 - plan.band.0) * i as f64 / (CLOSED_FORM_POINTS - 1) as f64)
        .chain(run.frequency.iter().copied())
        .collect();
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    let of = |law| -> Vec<Complex64> {
        let ratio = |&f: &f64| surface_ratios(&plan.profile, run.axis, law, 0.0, f);
        grid.iter().map(ratio).map(|r| if outcrop { r.outcrop } else { r.within }).collect()
    };
    TransferFunction {
        causal: of(Law::Causal),
        hysteretic: of(Law::Hysteretic),
        name: run.name,
        axis: run.axis,
        frequency: run.frequency,
        computed: run.ratio,
        closed_form_frequency: grid,
    }
}
