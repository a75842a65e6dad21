//! One iteration: the smallest change that brings the half-cycles of all periods within their bounds.

use super::metric::Metric;
use super::oscillator::{Extreme, Oscillator, extremes};
use crate::measures::parallel;

/// Half-cycles of one period that are bounded from above at most.
const HALF_CYCLES: usize = 16;

/// Half-cycles above this ratio to the target are bounded, so that a change does not lift them over it.
const WATCHED: f64 = 0.88;

/// A largest half-cycle that lies this much above its lower bound is not held up.
const RESERVE: f64 = 0.08;

/// A half-cycle counts as bounded when one of the two periods before has a bound within this share of the
/// period, of the same sign, and not lower by more than `ALIKE`: short periods follow the ground alike.
const SAME_TIME: f64 = 0.1;
const ALIKE: f64 = 0.01;

/// Constraints whose stiffness is worked out together.
const BLOCK: usize = 8;

/// Sweeps over the multipliers at most, and the change (units of the target) below which they end.
const SWEEPS: usize = 300;
const SETTLED: f64 = 3e-4;

/// Over-relaxation of the sweeps; any value between 0 and 2 converges.
const RELAXATION: f64 = 1.4;

/// A constraint may be missed by this share of its own effect: nearly equal ones do not fight.
const COMPLIANCE: f64 = 0.01;

/// Largest size of one constraint's change, in standard deviations of what [`Metric`] thinks likely.
const SIZE: f64 = 60.0;

/// Share of the change that is made: the extremes move while it grows.
const RELAXED: f64 = 0.9;

/// What the record must be brought to.
#[derive(Debug)]
pub(super) struct Target {
    /// Periods of the constraints, increasing, s.
    pub(super) periods: Vec<f64>,
    /// Displacements of the target at those periods, m.
    pub(super) displacements: Vec<f64>,
    /// Longest period with a lower bound, s; longer ones have an upper bound only.
    pub(super) longest: f64,
    /// Damping ratio.
    pub(super) damping: f64,
    /// Share by which the bounds lie below and above the target.
    pub(super) margin: f64,
}

impl Target {
    /// One more period (s) with its displacement (m), unless it is there.
    pub(super) fn add(&mut self, period: f64, displacement: f64) {
        let at = self.periods.partition_point(|other| *other < period * (1.0 - 1e-9));
        if self.periods.get(at).is_none_or(|other| *other > period * (1.0 + 1e-9)) {
            self.periods.insert(at, period);
            self.displacements.insert(at, displacement);
        }
    }
}

/// `⟨shares, δ⟩ ≥ missing` for a change δ of the record (= where `equal`), in units of the target.
struct Constraint {
    first: usize,
    shares: Vec<f64>,
    missing: f64,
    equal: bool,
}

/// Changes the record (m/s², step `dt` in s) once; see the module [`matching`](super).
///
/// Returns the effort, constraints times all their entries, the number of products being about half of it; `None`,
/// with the record as it was, where it would be above `most`.
pub(super) fn iterate(
    record: &mut [f64],
    dt: f64,
    target: &Target,
    metric: &Metric,
    most: f64,
) -> Option<f64> {
    let mut constraints: Vec<Constraint> = rest(record.len())
        .into_iter()
        .map(|shares| Constraint { first: 0, missing: -dot(&shares, record), shares, equal: true })
        .collect();
    constraints.extend(bounds(record, dt, target));
    let entries: usize = constraints.iter().map(|c| c.shares.len()).sum();
    let effort = constraints.len() as f64 * entries as f64;
    if effort > most {
        return None;
    }
    let multipliers = multipliers(&constraints, metric);
    let mut sum = vec![0.0; record.len()];
    for (c, multiplier) in constraints.iter().zip(multipliers) {
        let samples = &mut sum[c.first..c.first + c.shares.len()];
        samples.iter_mut().zip(&c.shares).for_each(|(s, share)| *s += RELAXED * multiplier * share);
    }
    let change = metric.apply(0, &sum);
    record.iter_mut().zip(change).for_each(|(a, change)| *a += change);
    Some(effort)
}

/// Means of a and of (t_end − t)/t_end · a as shares of the samples: zero for a ground at rest in the end.
pub(super) fn rest(n: usize) -> [Vec<f64>; 2] {
    let share = |i: usize| (n - 1 - i) as f64 / (n - 1) as f64 / n as f64;
    [vec![1.0 / n as f64; n], (0..n).map(share).collect()]
}

/// The bounds that matter now: on the largest half-cycle from below, on all large ones from above.
fn bounds(record: &[f64], dt: f64, target: &Target) -> Vec<Constraint> {
    let mut constraints = Vec::new();
    let mut recent: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
    for (i, mut half_cycles) in half_cycles(record, dt, target).into_iter().enumerate() {
        let (period, unit) = (target.periods[i], target.displacements[i]);
        half_cycles.sort_by(|a, b| b.displacement.abs().total_cmp(&a.displacement.abs()));
        let oscillator = Oscillator::new(period, target.damping);
        let mut bound = |extreme: &Extreme, direction: f64, missing: f64| {
            let (first, mut shares) = oscillator.shares(extreme.time, dt, record.len());
            let scale = direction * extreme.displacement.signum() / unit;
            shares.iter_mut().for_each(|share| *share *= scale);
            constraints.push(Constraint { first, shares, missing, equal: false });
        };
        let lower = 1.0 - target.margin;
        let held_up = period <= target.longest * (1.0 + 1e-9);
        if let Some(peak) = half_cycles.first().filter(|_| held_up) {
            let ratio = peak.displacement.abs() / unit;
            if ratio < lower + RESERVE {
                bound(peak, 1.0, lower - ratio);
            }
        }
        let mut mine = Vec::new();
        for extreme in half_cycles.iter().take(HALF_CYCLES) {
            let ratio = extreme.displacement / unit;
            let known = recent.iter().flatten().any(|(time, other)| {
                (time - extreme.time).abs() < SAME_TIME * period
                    && other * ratio > 0.0
                    && other.abs() > ratio.abs() - ALIKE
            });
            if ratio.abs() > WATCHED && !known {
                bound(extreme, -1.0, ratio.abs() - 1.0 - target.margin);
                mine.push((extreme.time, ratio));
            }
        }
        recent.rotate_left(1);
        recent[1] = mine;
    }
    constraints
}

/// Extremes of every period: those above half of the target, or all where none is.
fn half_cycles(record: &[f64], dt: f64, target: &Target) -> Vec<Vec<Extreme>> {
    let Target { periods, displacements, damping, .. } = target;
    let floors: Vec<f64> = displacements.iter().map(|d| 0.5 * d).collect();
    let mut found = extremes(record, dt, periods, *damping, &floors);
    let empty: Vec<usize> = (0..found.len()).filter(|i| found[*i].is_empty()).collect();
    let few: Vec<f64> = empty.iter().map(|i| periods[*i]).collect();
    let all = extremes(record, dt, &few, *damping, &vec![0.0; few.len()]);
    for (i, extremes) in empty.into_iter().zip(all) {
        found[i] = extremes;
    }
    found
}

/// `⟨shares_r, W shares_s⟩` of all pairs, row by row: symmetric, never negative as a form.
fn stiffness(constraints: &[Constraint], metric: &Metric) -> Vec<f64> {
    let n = constraints.len();
    // The last block has the longest rows: it comes first.
    let blocks: Vec<usize> = (0..n).step_by(BLOCK).rev().collect();
    let lines = parallel::each(&blocks, n > BLOCK, |&begin| {
        let end = (begin + BLOCK).min(n);
        let changes: Vec<Vec<f64>> =
            constraints[begin..end].iter().map(|c| metric.apply(c.first, &c.shares)).collect();
        // All shares together are many times larger than a cache: each is read once per block.
        let products = |c: &Constraint| {
            let mut out = [0.0; BLOCK];
            for (out, change) in out.iter_mut().zip(&changes) {
                *out = dot(&c.shares, &change[c.first..c.first + c.shares.len()]);
            }
            out
        };
        constraints[..end].iter().map(products).collect::<Vec<_>>()
    });
    let mut stiffness = vec![0.0; n * n];
    for (&begin, lines) in blocks.iter().zip(&lines) {
        for (other, products) in lines.iter().enumerate() {
            for (row, product) in (begin..n.min(begin + BLOCK)).zip(products) {
                stiffness[row * n + other] = *product;
                stiffness[other * n + row] = *product;
            }
        }
    }
    stiffness
}

/// Sum of products in eight partial sums, which vector units work on side by side.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (x_blocks, y_blocks) = (x.chunks_exact(8), y.chunks_exact(8));
    let rest: f64 = x_blocks.remainder().iter().zip(y_blocks.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in x_blocks.zip(y_blocks) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Multipliers of the smallest change that keeps all constraints, one at a time (Hildreth's method).
///
/// With the stiffness G they minimise `½ λᵀ(G + εD)λ − λᵀm` over λ ≥ 0, D the diagonal of G: coordinate
/// descent on a convex function, which cannot diverge.
fn multipliers(constraints: &[Constraint], metric: &Metric) -> Vec<f64> {
    let n = constraints.len();
    let stiffness = stiffness(constraints, metric);
    let mut multipliers = vec![0.0_f64; n];
    let mut values = vec![0.0_f64; n];
    for _ in 0..SWEEPS {
        let mut largest = 0.0_f64;
        for (row, constraint) in constraints.iter().enumerate() {
            let line = &stiffness[row * n..(row + 1) * n];
            let own = line[row];
            if own.is_nan() || own <= 0.0 {
                continue;
            }
            let missing = constraint.missing - values[row] - COMPLIANCE * own * multipliers[row];
            let wanted = multipliers[row] + RELAXATION * missing / (own * (1.0 + COMPLIANCE));
            let most = SIZE / own.sqrt();
            let new = wanted.clamp(if constraint.equal { -most } else { 0.0 }, most);
            let change = new - multipliers[row];
            if change != 0.0 {
                multipliers[row] = new;
                largest = largest.max((change * own).abs());
                values.iter_mut().zip(line).for_each(|(value, g)| *value += g * change);
            }
        }
        if largest < SETTLED {
            break;
        }
    }
    multipliers
}
