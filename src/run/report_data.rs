//! Turns a finished simulation into what the report draws.

use super::Simulation;
use crate::closed_form::{Law, surface_ratios};
use crate::plan::Plan;
use crate::results::{AXES, LayerView, SiteResponse, Trace, TransferFunction};
use crate::spectrum::band_spectrum;
use hati_inputs::measures::Measures;
use hati_inputs::scene::Scene;
use hati_sem::soil::Base;
use num_complex::Complex64;
use serde_json::{Map, Value, json};

/// Everything the report needs; its summary is still empty.
pub fn site_response(scene: &Scene, plan: &Plan, simulation: &Simulation) -> SiteResponse {
    let recorder = &simulation.recorder;
    let taken = recorder.samples_taken();
    let mut traces = simulation.outcrop_traces(plan);
    for t in &mut traces {
        [&mut t.acceleration, &mut t.velocity, &mut t.displacement]
            .into_iter()
            .for_each(|x| x.truncate(taken));
    }
    traces.extend(recorder.traces.iter().cloned());
    let transfer = transfer_functions(plan, &traces);
    SiteResponse {
        title: scene.title.clone(),
        dt: plan.sample_dt,
        time_first: plan.time_first(),
        start: super::start_iso(plan),
        layers: layers(plan),
        traces,
        peaks: recorder.peaks.clone(),
        transfer,
        sections: recorder.sections.clone(),
        ledger: recorder.ledger_rows.clone(),
        summary: Value::Null,
    }
}

fn layers(plan: &Plan) -> Vec<LayerView> {
    let top = plan.profile.interfaces();
    let mut layers: Vec<LayerView> = (plan.profile.layers.iter().enumerate())
        .map(|(i, l)| LayerView {
            name: l.name.clone(),
            top: top[i],
            bottom: top[i + 1],
            vs: l.vs,
            vp: l.vp,
            rho: l.rho,
            damping: l.damping_s,
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

/// Peaks, intensities and durations: `{place: {axis: {pga, …}}}`.
pub fn places_json(data: &SiteResponse, f_min: f64) -> Value {
    let mut places = Map::new();
    for t in &data.traces {
        let mut m = crate::motion_input::measures_json(&Measures::of(&t.acceleration, data.dt, f_min));
        m["depth"] = json!(t.depth);
        let entry = places.entry(t.place.clone()).or_insert_with(|| json!({}));
        entry[AXES[t.axis].to_string()] = m;
    }
    Value::Object(places)
}

/// Largest value of each transfer function, its frequency, and the gaps to the two closed forms.
pub(super) fn transfer_json(data: &SiteResponse) -> Value {
    let list: Vec<Value> = (data.transfer.iter())
        .filter_map(|t| {
            let (k, peak) = largest(&t.causal)?;
            let gap = t.causal.iter().zip(&t.hysteretic).map(|(a, b)| (a.norm() - b.norm()).abs()).fold(0.0, f64::max);
            Some(json!({
                "name": t.name, "axis": AXES[t.axis].to_string(), "peak": peak, "frequency": t.closed_form_frequency[k],
                "gap_of_laws": gap / peak, "gap_to_run": gap_to_run(t, peak),
            }))
        })
        .collect();
    Value::Array(list)
}

fn largest(values: &[Complex64]) -> Option<(usize, f64)> {
    values.iter().map(|v| v.norm()).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Largest complex distance of the run's own ratio from the causal closed form, relative to the peak.
fn gap_to_run(t: &TransferFunction, peak: f64) -> f64 {
    let mut worst = 0.0_f64;
    for (f, value) in t.frequency.iter().zip(&t.computed) {
        let k = t.closed_form_frequency.partition_point(|g| g < f);
        if k == 0 || k >= t.closed_form_frequency.len() {
            continue;
        }
        let (f0, f1) = (t.closed_form_frequency[k - 1], t.closed_form_frequency[k]);
        let s = (f - f0) / (f1 - f0);
        let exact = t.causal[k - 1] * (1.0 - s) + t.causal[k] * s;
        worst = worst.max((value - exact).norm() / peak);
    }
    worst
}

/// Frequencies at which the closed forms are drawn.
const CLOSED_FORM_POINTS: usize = 1500;

/// Share of the largest amplitude of the denominator below which a ratio of spectra is not shown.
const RATIO_FLOOR: f64 = 1e-3;

/// Ratios of the run's own spectra with the closed forms.
pub fn transfer_functions(plan: &Plan, traces: &[Trace]) -> Vec<TransferFunction> {
    let mut all = vec![];
    for &axis in &plan.axes {
        let spectrum = |place: &str| {
            let t = traces.iter().find(|t| t.place == place && t.axis == axis)?;
            Some(band_spectrum(&t.acceleration, plan.sample_dt, plan.band))
        };
        let Some((frequency, surface)) = spectrum("surface") else { continue };
        let grid: Vec<f64> = (0..CLOSED_FORM_POINTS)
            .map(|i| plan.band.0 + (plan.band.1 - plan.band.0) * i as f64 / (CLOSED_FORM_POINTS - 1) as f64)
            .collect();
        for place in ["outcrop", "within"] {
            let Some((_, below)) = spectrum(place) else { continue };
            let of = |law| -> Vec<Complex64> {
                let ratio = |&f: &f64| surface_ratios(&plan.profile, axis, law, 0.0, f);
                grid.iter()
                    .map(ratio)
                    .map(|r| if place == "outcrop" { r.outcrop } else { r.within })
                    .collect()
            };
            let floor = RATIO_FLOOR * below.iter().map(|b| b.norm()).fold(0.0, f64::max);
            let (f, computed) = (0..frequency.len())
                .filter(|&k| below[k].norm() > floor)
                .map(|k| (frequency[k], surface[k] / below[k]))
                .unzip();
            all.push(TransferFunction {
                name: format!("surface/{place}"),
                axis,
                frequency: f,
                computed,
                causal: of(Law::Causal),
                hysteretic: of(Law::Hysteretic),
                closed_form_frequency: grid.clone(),
            });
        }
    }
    all
}
