//! What a plan's error really is: against the same model, four times finer.

use crate::plan::{Plan, fit_arms, substeps_for};
use crate::run::{RunError, Simulation};
use hati_sem::attenuation::MECHANISMS_MAX;
use hati_sem::column::{Column, Discretisation};

/// The same plan four times finer: elements and step by four, and all mechanisms there are.
pub fn finer(plan: &Plan) -> Result<Plan, RunError> {
    let mut fine = plan.clone();
    fine.discretisation = Discretisation {
        order: plan.discretisation.order,
        elements: plan.discretisation.elements.iter().map(|n| 4 * n).collect(),
    };
    if plan.mechanisms > 0 {
        fine.mechanisms = MECHANISMS_MAX;
        fine.arms = fit_arms(&plan.column, plan.band, MECHANISMS_MAX)?;
    }
    // more mechanisms stiffen the column a little: the step follows the finer mesh's own limit
    let limit =
        Column::critical_step(&fine.column, &fine.discretisation, &fine.arms, &fine.axes, fine.imposed())?;
    (fine.dt_critical, fine.limiting) = limit;
    fine.substeps = (4 * plan.substeps).max(substeps_for(plan.sample_dt, fine.dt_critical));
    Ok(fine)
}

/// Largest relative L2 error in time of acceleration over the places and components that the accuracy is for.
pub fn measured_error(plan: &Plan, run: &Simulation, fine: &Simulation) -> f64 {
    let count = plan.sized * plan.axes.len();
    let mut worst = 0.0_f64;
    for (a, b) in run.recorder.traces.iter().zip(&fine.recorder.traces).take(count) {
        let (mut wrong, mut right) = (0.0, 0.0);
        for (x, y) in a.acceleration.iter().zip(&b.acceleration) {
            wrong += (x - y).powi(2);
            right += y * y;
        }
        if right > 0.0 {
            worst = worst.max((wrong / right).sqrt());
        }
    }
    worst
}
