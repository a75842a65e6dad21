//! Error against cost of Lamb's problem over order, element size, step and precision.

use super::lamb::{Footprint, LAMB_DISTANCES, LambModel, difference};
use super::{CaseResult, Check, closed_form};
use crate::run::RunError;
use crate::verify::{CaseFigure, twist};
use hati_sem::SemError;
use hati_sem::solid::Real;
use std::sync::OnceLock;

/// Elements along an edge of the quarter box for every order.
const COUNTS: [(usize, [usize; 5]); 7] = [
    (2, [12, 16, 20, 24, 28]),
    (3, [8, 12, 17, 23, 30]),
    (4, [6, 9, 12, 16, 22]),
    (5, [5, 7, 9, 12, 17]),
    (6, [4, 5, 7, 10, 15]),
    (7, [3, 5, 6, 8, 13]),
    (8, [3, 4, 5, 7, 11]),
];
/// Steps over the critical step; f64 takes the third.
const SHARES: [f64; 4] = [0.3, 0.5, 0.7, 0.95];
/// Side of the quarter box, m, and instant of the end, s: the waves have passed 40 m by then, and what has
/// come back from the box's sides stays below 3e-4 of the peak.
const SIDE: f64 = 80.0;
const END: f64 = 0.54;

/// One run of Lamb's problem.
#[derive(Debug, Clone, PartialEq)]
struct CostRow {
    /// Polynomial order.
    pub order: usize,
    /// `f32` or `f64`.
    pub precision: &'static str,
    /// Width of an element, m.
    pub width: f64,
    /// Step over the critical step.
    pub step_share: f64,
    /// Step, s.
    pub dt: f64,
    /// Number of elements.
    pub elements: usize,
    /// Largest difference of the vertical displacement over its peak at 10, 20 and 40 m.
    pub errors: [f64; 3],
    /// Processor time of one thread over simulated time.
    pub cost: f64,
}

impl CostRow {
    /// Largest of the errors from a receiver on: 0 for all three, 2 for that at 40 m alone.
    fn error(&self, nearest: usize) -> f64 {
        self.errors[nearest..].iter().copied().fold(0.0, f64::max)
    }
}

fn row<T: Real>(order: usize, count: usize, step_share: f64, vs_factor: f64) -> Result<CostRow, SemError> {
    let width = SIDE / count as f64;
    let model = LambModel {
        order,
        footprint: Footprint::Point,
        width_at_source: width,
        width,
        growth: 1.0,
        side: SIDE,
        step_share,
        end: END,
    };
    let record = model.run::<T>(vs_factor)?;
    let errors = std::array::from_fn(|i| difference(&record.displacement[i][1], &closed_form(i)));
    let cost = record.cpu_seconds / (record.steps as f64 * record.dt);
    let (dt, elements) = (record.dt, record.elements);
    Ok(CostRow { order, precision: T::NAME, width, step_share, dt, elements, errors, cost })
}

/// All runs of the chart, once a process: 175 runs, half an hour; order 2 has no fast kernel and stops earlier.
fn cost_of_lamb() -> Result<&'static [CostRow], SemError> {
    static ROWS: OnceLock<Vec<CostRow>> = OnceLock::new();
    if let Some(rows) = ROWS.get() {
        return Ok(rows);
    }
    let mut rows = vec![];
    for size in 0..COUNTS[0].1.len() {
        for (order, counts) in COUNTS {
            for share in SHARES {
                rows.push(row::<f32>(order, counts[size], share, 1.0)?);
            }
            rows.push(row::<f64>(order, counts[size], SHARES[2], 1.0)?);
        }
    }
    Ok(ROWS.get_or_init(|| rows))
}

/// Runs of an order and precision that no other one betters in both error and cost, dearest last.
fn best(rows: &[CostRow], order: usize, precision: &str, nearest: usize) -> Vec<(f64, f64)> {
    let own = rows.iter().filter(|r| r.order == order && r.precision == precision);
    let mut all: Vec<(f64, f64)> = own.map(|r| (r.cost, r.error(nearest))).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<(f64, f64)> = vec![];
    for point in all {
        if kept.last().is_none_or(|last| point.1 < last.1) {
            kept.push(point);
        }
    }
    kept
}

/// Cost at which an order reaches an error at the receivers from the `nearest` (0, 1, 2) on, by logarithmic
/// interpolation between its best runs; that of the cheapest run where even this is better, `None` where no
/// run is as good.
fn cost_to_reach(rows: &[CostRow], order: usize, precision: &str, nearest: usize, error: f64) -> Option<f64> {
    let kept = best(rows, order, precision, nearest);
    let after = kept.iter().position(|p| p.1 <= error)?;
    let Some(before) = after.checked_sub(1) else { return Some(kept[0].0) };
    let (a, b) = (kept[before], kept[after]);
    let part = (a.1 / error).ln() / (a.1 / b.1).ln();
    Some(a.0 * (b.0 / a.0).powf(part))
}

/// Least error that every order reaches in f32: at 40 m, where it is that of waves, and at all receivers, where
/// that at 10 m lies one element beside the force. Twist: both wave speeds.
pub(in crate::verify) fn lamb_chart(twisted: bool) -> CaseResult {
    const CASE: &str = "lamb-chart";
    const AT_40_M: [f64; 7] = [1e-1, 5e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3];
    const AT_ALL: [f64; 7] = [1e-1, 5e-3, 5e-3, 5e-3, 5e-3, 5e-3, 5e-3];
    let mut checks = vec![];
    for (i, (order, counts)) in COUNTS.into_iter().enumerate() {
        for (places, nearest, limit) in [("at 40 m", 2, AT_40_M[i]), ("at 10, 20 and 40 m", 0, AT_ALL[i])] {
            let found = if twisted {
                row::<f32>(order, counts[3], SHARES[0], twist(true, limit))?.error(nearest)
            } else {
                best(cost_of_lamb()?, order, "f32", nearest).last().map_or(f64::INFINITY, |p| p.1)
            };
            checks.push(Check::error(CASE, format!("least error of N = {order} {places}"), found, limit));
        }
    }
    Ok(checks)
}

/// The figure of the case, and all its runs.
pub(in crate::verify) fn cost_chart() -> Result<CaseFigure, RunError> {
    let rows = cost_of_lamb()?;
    let curves: Vec<_> = (COUNTS.iter())
        .map(|&(order, counts)| {
            let finest = SIDE / counts[4] as f64;
            let steps = (rows.iter())
                .filter(|r| r.order == order && r.precision == "f32" && r.width == finest)
                .map(|r| (r.step_share, r.error(0)))
                .collect();
            let pair = |nearest| [best(rows, order, "f32", nearest), best(rows, order, "f64", nearest)];
            crate::report::CostCurve { order, near: pair(0), far: pair(2), steps }
        })
        .collect();
    let mut csv = String::from(
        "order,precision,width_m,step_share,dt_s,elements,error_10m,error_20m,error_40m,cpu_s_per_simulated_s\n",
    );
    for r in rows {
        csv.push_str(&format!(
            "{},{},{:.4},{},{:.4e},{},{:.4e},{:.4e},{:.4e},{:.4e}\n",
            r.order,
            r.precision,
            r.width,
            r.step_share,
            r.dt,
            r.elements,
            r.errors[0],
            r.errors[1],
            r.errors[2],
            r.cost
        ));
    }
    let svg = crate::report::cost_figure(&curves);
    Ok(CaseFigure {
        name: "lamb-chart",
        svg,
        tables: vec![("lamb-chart", csv), ("lamb-chart-orders", orders(rows))],
    })
}

/// Cost of every order at 10 %, 1 % and 0.1 %, at all receivers and at the farthest, with the width and the step
/// share of its cheapest run that is as good. Nothing stands where no run is.
fn orders(rows: &[CostRow]) -> String {
    let mut csv = String::from(
        "nearest_receiver_m,error,order,precision,cpu_s_per_simulated_s,cheapest_run_width_m,cheapest_run_step_share\n",
    );
    for (nearest, error) in [0, 2].into_iter().flat_map(|r| [1e-1, 1e-2, 1e-3].map(|e| (r, e))) {
        for (order, precision) in COUNTS.into_iter().flat_map(|(n, _)| ["f32", "f64"].map(|p| (n, p))) {
            let good =
                |r: &&CostRow| r.order == order && r.precision == precision && r.error(nearest) <= error;
            let cheapest = rows.iter().filter(good).min_by(|a, b| a.cost.total_cmp(&b.cost));
            let cost = cost_to_reach(rows, order, precision, nearest, error);
            let told = cheapest
                .zip(cost)
                .map_or(",,".into(), |(run, cost)| format!("{cost:.4e},{:.4},{}", run.width, run.step_share));
            csv.push_str(&format!("{},{error},{order},{precision},{told}\n", LAMB_DISTANCES[nearest]));
        }
    }
    csv
}
