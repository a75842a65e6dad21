//! Error against cost of a scene over order, size and step.

use crate::measured::{finer, measured_error};
use crate::outputs::{OutputError, replace_bytes};
use crate::plan::{Fixed, Plan, PlanError};
use crate::run::{RunError, Simulation};
use hati_inputs::scene::Scene;
use serde_json::{Value, json};
use std::path::Path;

/// One measured discretisation.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Point {
    /// Polynomial order.
    pub order: usize,
    /// Elements per layer.
    pub elements: Vec<usize>,
    /// Points of the column.
    pub points: usize,
    /// Steps per sample.
    pub substeps: usize,
    /// Memory variables per layer.
    pub mechanisms: usize,
    /// Predicted relative L2 error.
    pub predicted: f64,
    /// Measured relative L2 error against a run four times finer than the most accurate point.
    pub measured: f64,
    /// Time of the steps, s, median over rounds in which all points take turns.
    pub seconds: f64,
    /// Whether `auto` chose it.
    pub auto: bool,
}

/// Measures a family of discretisations around what `auto` chose, writes `chart.svg`, `chart.csv`,
/// `chart.json` and `chart.html` into `out` and returns the JSON.
///
/// `told` hears a line per point; it answers false to stop early, which leaves the files of what was
/// measured so far. Cost: eight runs a point, and one much finer run.
pub fn chart(scene: &Scene, out: &Path, told: &mut dyn FnMut(&str) -> bool) -> Result<Value, RunError> {
    std::fs::create_dir_all(out)
        .map_err(|cause| OutputError::UnwritableFolder { folder: out.to_path_buf(), cause })?;
    let auto = Plan::new(scene)?;
    let plans = family(scene, &auto)?;
    let best =
        plans.iter().min_by(|a, b| a.search.chosen.error.total_cmp(&b.search.chosen.error)).unwrap_or(&auto);
    told(&format!(
        "reference: four times finer than order {} with {} points",
        best.discretisation.order,
        best.points()
    ));
    let fine = finer(best)?;
    let mut reference = Simulation::new(&fine)?;
    reference.run_through(&fine)?;
    let mut points: Vec<Point> = vec![];
    for (i, plan) in plans.iter().enumerate() {
        let simulation = through(plan)?;
        let point = Point {
            order: plan.discretisation.order,
            elements: plan.discretisation.elements.clone(),
            points: plan.points(),
            substeps: plan.substeps,
            mechanisms: plan.mechanisms,
            predicted: plan.search.chosen.error,
            measured: measured_error(plan, &simulation, &reference),
            seconds: simulation.step_seconds,
            auto: i == 0,
        };
        let line = format!(
            "{}order {:2}, {:4} points, {:3} steps/sample, mechanisms {}: error {:.2e} (predicted {:.2e})",
            if point.auto { "auto: " } else { "      " },
            point.order,
            point.points,
            point.substeps,
            point.mechanisms,
            point.measured,
            point.predicted
        );
        points.push(point);
        if !told(&line) {
            break;
        }
    }
    if points.len() == plans.len() {
        time_in_rounds(&plans, &mut points)?;
    }
    let value = json!({
        "title": scene.title, "accuracy": scene.accuracy,
        "norm": "relative L2 in time of acceleration at the worst station and component, inside the band",
        "reference": { "order": fine.discretisation.order, "points": fine.points(), "substeps": fine.substeps, "mechanisms": fine.mechanisms },
        "points": points,
    });
    write(scene, out, &points, &value)?;
    Ok(value)
}

fn through(plan: &Plan) -> Result<Simulation, RunError> {
    let mut simulation = Simulation::new(plan)?;
    simulation.run_through(plan)?;
    Ok(simulation)
}

/// Rounds of timing.
const ROUNDS: usize = 7;

/// Times all points in turn, round after round, so that a drift of the machine meets them alike, and
/// keeps each one's median.
fn time_in_rounds(plans: &[Plan], points: &mut [Point]) -> Result<(), RunError> {
    let mut seconds = vec![vec![]; points.len()];
    for _ in 0..ROUNDS {
        for (plan, seconds) in plans.iter().zip(&mut seconds) {
            seconds.push(through(plan)?.step_seconds);
        }
    }
    for (point, mut seconds) in points.iter_mut().zip(seconds) {
        seconds.sort_by(f64::total_cmp);
        point.seconds = seconds[ROUNDS / 2];
    }
    Ok(())
}

/// `auto`, then per order the cheapest at targets of 1/3 decade, and `auto` with other steps.
fn family(scene: &Scene, auto: &Plan) -> Result<Vec<Plan>, PlanError> {
    let mut plans = vec![auto.clone()];
    let mut add = |plan: Plan| {
        let same = |p: &Plan| {
            p.discretisation == plan.discretisation
                && p.substeps == plan.substeps
                && p.mechanisms == plan.mechanisms
        };
        if !plans.iter().any(same) {
            plans.push(plan);
        }
    };
    for order in [1, 2, 3, 4, 5, 6, 8, 10] {
        for target in [3.0, 1.0, 0.3, 0.1].map(|t| t * scene.accuracy) {
            let fixed = Fixed { order: Some(order), ..Fixed::default() };
            let plan = auto.replanned(target, &fixed)?;
            // order 1 and 2 reach small errors only with meshes that nobody would run
            if plan.search.met && plan.search.chosen.cost < 60.0 * auto.search.chosen.cost.max(0.02) {
                add(plan);
            }
        }
    }
    for factor in [2, 4] {
        let fixed = Fixed {
            order: Some(auto.discretisation.order),
            elements: Some(auto.discretisation.elements.clone()),
            substeps: Some(auto.substeps * factor),
            mechanisms: (auto.mechanisms > 0).then_some(auto.mechanisms),
        };
        add(auto.replanned(1.0, &fixed)?);
    }
    Ok(plans)
}

fn write(scene: &Scene, out: &Path, points: &[Point], value: &Value) -> Result<(), OutputError> {
    let mut csv = String::from(
        "order,points,steps_per_sample,mechanisms,predicted_error,measured_error,solver_s,auto\n",
    );
    for p in points {
        csv.push_str(&format!(
            "{},{},{},{},{:e},{:e},{:e},{}\n",
            p.order, p.points, p.substeps, p.mechanisms, p.predicted, p.measured, p.seconds, p.auto
        ));
    }
    let svg = crate::report::chart_figure(&scene.title, scene.accuracy, points);
    let html = crate::report::chart_page(scene, points, &svg);
    replace_bytes(&out.join("chart.csv"), csv.as_bytes(), false)?;
    replace_bytes(&out.join("chart.svg"), svg.as_bytes(), false)?;
    replace_bytes(&out.join("chart.html"), html.as_bytes(), false)?;
    replace_bytes(&out.join("chart.json"), format!("{value:#}").as_bytes(), true)
}
