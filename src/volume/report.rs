//! `report.html` of a run in two or three dimensions, made from its files.

use super::files::axes;
use super::mesh::PlannedBoundary;
use super::picture::picture;
use super::plan::VolumePlan;
use super::stations::MOTIONS;
use crate::outputs::OutputError;
use crate::report::wave::{KeyNumber, SurfaceMotion, WavePage, write_wave_report};
use crate::results::{AXES, LedgerRow, Trace};
use hati_inputs::scene::{BoundaryKind, Scene};
use netcdf::Extent;
use serde_json::Value;
use std::path::Path;

/// Instants of the surface that the page shows at most.
const FRAMES: usize = 120;
/// Values of these at most.
const FRAME_VALUES: usize = 40_000_000;

fn failed(path: &Path, what: &str) -> impl FnOnce(netcdf::Error) -> OutputError {
    let action = format!("read {what}");
    let path = path.to_path_buf();
    move |cause| OutputError::from_netcdf(&path, action, cause)
}

/// Motions of all stations, from `stations.nc`.
pub(super) fn traces(plan: &VolumePlan, out: &Path) -> Result<Vec<Trace>, OutputError> {
    if plan.sensors.is_empty() {
        return Ok(vec![]);
    }
    let path = out.join("stations.nc");
    let file = netcdf::open(&path).map_err(failed(&path, "the stations"))?;
    let stations = plan.sensors.len();
    let column = |name: &str| -> Result<Vec<f64>, OutputError> {
        let Some(variable) = file.variable(name) else { return Ok(vec![]) };
        variable.get_values(..).map_err(failed(&path, name))
    };
    let mut traces = vec![];
    for axis in axes(plan) {
        let read = |motion: &str| column(&format!("{motion}_{}", AXES[axis]));
        let (u, v, a) = (read("displacement")?, read("velocity")?, read("acceleration")?);
        for (number, sensor) in plan.sensors.iter().enumerate() {
            // a motion that was not asked for holds missing values only
            let asked = MOTIONS.map(|m| sensor.quantities.contains(&m));
            let of = |motion: usize, all: &[f64]| match asked[motion] {
                true => all.iter().skip(number).step_by(stations).copied().collect(),
                false => vec![],
            };
            if asked == [false; 3] {
                continue;
            }
            traces.push(Trace {
                place: sensor.name.clone(),
                depth: None,
                axis,
                acceleration: of(2, &a),
                velocity: of(1, &v),
                displacement: of(0, &u),
            });
        }
    }
    // all components of a place together
    let number = |t: &Trace| plan.sensors.iter().position(|s| s.name == t.place);
    traces.sort_by_key(|t| (number(t), t.axis));
    Ok(traces)
}

/// The surface's motion, from `surface.nc`; `None` where it was not written.
fn surface(plan: &VolumePlan, out: &Path) -> Result<Option<SurfaceMotion>, OutputError> {
    let Some(planned) = &plan.surface else { return Ok(None) };
    let path = out.join("surface.nc");
    let file = netcdf::open(&path).map_err(failed(&path, "the surface"))?;
    let points = planned.points.len();
    let all: Vec<f64> = match file.variable("elapsed_time") {
        Some(variable) => variable.get_values(..).map_err(failed(&path, "elapsed_time"))?,
        None => vec![],
    };
    let most = FRAMES.min(FRAME_VALUES / points.max(1)).max(1);
    let stride = all.len().div_ceil(most).max(1);
    let (mut time, mut speed) = (vec![], vec![]);
    if planned.motions.contains(&1) {
        for row in (0..all.len()).step_by(stride) {
            let mut squares = vec![0.0_f32; points];
            for axis in axes(plan) {
                let name = format!("velocity_{}", AXES[axis]);
                let Some(variable) = file.variable(&name) else { continue };
                let extent: [Extent; 2] = [Extent::Index(row), (0..points).into()];
                let values: Vec<f32> = variable.get_values(&extent[..]).map_err(failed(&path, &name))?;
                squares.iter_mut().zip(values).for_each(|(s, v)| *s += v * v);
            }
            time.push(all[row]);
            speed.extend(squares.iter().map(|s| s.sqrt()));
        }
    }
    let mut peaks: [Vec<f32>; 3] = Default::default();
    for (to, name) in peaks.iter_mut().zip(["pgd", "pgv", "pga"]) {
        if let Some(variable) = file.variable(name) {
            *to = variable.get_values(..).map_err(failed(&path, name))?;
        }
    }
    Ok(Some(SurfaceMotion { cells: planned.cells.clone(), time, speed, peaks }))
}

/// All rows of `ledger.nc`.
fn ledger(out: &Path) -> Result<Vec<LedgerRow>, OutputError> {
    let path = out.join("ledger.nc");
    let file = netcdf::open(&path).map_err(failed(&path, "the ledger"))?;
    let read = |name: &str| -> Result<Vec<f64>, OutputError> {
        let Some(variable) = file.variable(name) else { return Ok(vec![]) };
        variable.get_values(..).map_err(failed(&path, name))
    };
    let time = read("elapsed_time")?;
    let mut columns = vec![];
    for name in ["input", "kinetic", "strain", "viscous", "outflow", "residual"] {
        columns.push(read(&format!("energy_{name}"))?);
    }
    let at = |line: usize, row: usize| columns[line].get(row).copied().unwrap_or(f64::NAN);
    let row = |(row, &time): (usize, &f64)| LedgerRow {
        time,
        input: at(0, row),
        kinetic: at(1, row),
        strain: at(2, row),
        viscous: at(3, row),
        outflow: at(4, row),
        residual: at(5, row),
    };
    Ok(time.iter().enumerate().map(row).collect())
}

/// Writes `report.html` and `figures/`.
pub(super) fn report(
    scene: &Scene,
    plan: &VolumePlan,
    summary: &Value,
    traces: &[Trace],
    out: &Path,
) -> Result<(), OutputError> {
    let page = WavePage {
        title: scene.title.clone(),
        subtitle: subtitle(plan, summary),
        warnings: plan.warnings.clone(),
        numbers: numbers(plan, summary),
        mesh: picture(plan),
        ledger: ledger(out)?,
        is_section: plan.dimension == 2,
        surface: surface(plan, out)?,
        traces: traces.to_vec(),
        dt: plan.sampling.sample_dt(),
        time_first: 0.0,
    };
    write_wave_report(out, &page)
}

fn subtitle(plan: &VolumePlan, summary: &Value) -> String {
    let [affine, deformed, curved] = plan.metrics;
    format!(
        "{} dimensions · {} elements of order {} ({affine} affine, {deformed} straight, {curved} curved) · {} points · {} · {}",
        plan.dimension,
        plan.elements(),
        plan.resolution.order,
        plan.points(),
        summary["model"]["precision"].as_str().unwrap_or_default(),
        summary["status"].as_str().unwrap_or_default(),
    )
}

fn numbers(plan: &VolumePlan, summary: &Value) -> Vec<KeyNumber> {
    let number = |path: &str| summary.pointer(path).and_then(Value::as_f64).unwrap_or(f64::NAN);
    let card = |label: &str, value: String, note: String| KeyNumber { label: label.into(), value, note };
    let share = |path: &str| 100.0 * number(path) / number("/energy/input");
    let coarsest = plan.reached.iter().min_by(|a, b| (a.points / a.wanted).total_cmp(&(b.points / b.wanted)));
    let (name, points) = coarsest.map_or((String::new(), f64::NAN), |r| (r.material.clone(), r.points));
    let unit = summary["energy"]["unit"].as_str().unwrap_or_default();
    vec![
        card(
            "energy closing error",
            format!("{:.1e}", number("/energy/closing_error")),
            "unaccounted energy / largest energy".into(),
        ),
        card(
            "energy in",
            format!("{:.3e} {unit}", number("/energy/input")),
            format!(
                "{:.1} % left through boundaries, {:.1} % lost in the ground",
                share("/energy/outflow"),
                share("/energy/viscous")
            ),
        ),
        card(
            "step",
            format!("{:.3e} s", plan.sampling.dt),
            format!(
                "{:.0} % of the critical step, bounded by {}",
                100.0 * plan.sampling.dt / plan.dt_critical,
                plan.limiting
            ),
        ),
        card(
            "resolution",
            format!("{points:.2} points"),
            format!("per shear wavelength at {:.3} Hz, in `{name}`", plan.frequencies.f_max),
        ),
        boundaries(plan),
        card(
            "loop",
            format!("{:.2} s", number("/cost/solver_s")),
            format!(
                "{} steps · {:.1} ns per point and step · {} threads",
                plan.sampling.steps(),
                number("/cost/ns_per_point_step"),
                plan.threads
            ),
        ),
    ]
}

/// How many boundaries are of which kind, and their names.
fn boundaries(plan: &VolumePlan) -> KeyNumber {
    let mut names: Vec<String> = plan.boundaries.iter().map(PlannedBoundary::to_string).collect();
    let loose = plan.report.unnamed_sides;
    if loose > 0 {
        names.push(format!("{loose} sides in no group free (default)"));
    }
    let free = plan.boundaries.iter().filter(|b| b.kind == BoundaryKind::Free).count();
    KeyNumber {
        label: "boundaries".into(),
        value: format!("{} · {free} free", plan.boundaries.len()),
        note: names.join(", "),
    }
}
