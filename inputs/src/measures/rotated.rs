//! Response spectra of two horizontal components in all directions.

use std::f64::consts::{PI, TAU};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ground::Grounds;
use super::oscillator::{BLOCK, Lanes, Oscillator, State, step_peak};
use super::parallel;
use super::response::{by_upsampling, is_valid, side_by_side};

/// Directions looked at: 0° to 179° in steps of 1°.
const ANGLES: usize = 180;

/// Oscillators that run side by side.
const LANES: usize = 4;

/// Share of the largest peak below which the peak of a direction is not followed any further.
const NEGLIGIBLE: f64 = 1e-7;

/// Pseudo-acceleration (m/s²) of two horizontal components, whatever the instrument's azimuth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RotatedSpectrum {
    /// Periods, s.
    pub periods: Vec<f64>,
    /// Damping ratio of all oscillators.
    pub damping: f64,
    /// Smallest PSA over the directions, RotD00, m/s².
    pub rotd00: Vec<f64>,
    /// Median PSA over the directions, RotD50, m/s².
    pub rotd50: Vec<f64>,
    /// Largest PSA over the directions, RotD100, m/s².
    pub rotd100: Vec<f64>,
    /// Direction of the largest PSA, degrees from x towards y, 0 to 179.
    pub rotd100_angle: Vec<f64>,
    /// Geometric mean of the PSA along x and along y, m/s².
    pub geometric_mean: Vec<f64>,
    /// PSA along x, as [`super::response_spectrum`] gives it, m/s².
    pub along_x: Vec<f64>,
    /// PSA along y, m/s².
    pub along_y: Vec<f64>,
}

/// RotD00, RotD50 and RotD100 of two horizontal components.
///
/// For each period the relative displacements of the oscillators along x and y are turned through
/// θ = 0°, 1°, …, 179°, `u_θ = u_x cos θ + u_y sin θ`, and the peak of each direction is taken,
/// `PSA(θ) = (2π/T)² max |u_θ|`. Smallest, median (mean of the 90th and the 91st) and largest over the
/// directions are RotD00, RotD50 and RotD100 (Boore, 2010): all directions of one period in its own turn,
/// so RotD50 needs no geometric mean.
///
/// - `x`, `y`: m/s², perpendicular, beginning together, step `dt` (s); of unlike lengths the shorter
///   counts. `periods` in s; `damping` ζ, 0 ≤ ζ < 1.
/// - a period of 0 takes the samples themselves; negative periods, or a ζ out of its range, give NaN.
///
/// Polygon, recursion, peaks between points and accuracy are those of [`super::response_spectrum`]. A step
/// that lies inside an ellipse which no peak so far undercuts cannot raise any of them and is not turned;
/// the result is that of turning every step, but for directions whose peak is below 1e-7 of the largest.
///
/// Cost: three to four times that of one component, up to seven where the motion keeps growing;
/// memory 32 bytes per point of the finest polygon.
#[must_use]
pub fn rotated_spectrum(x: &[f64], y: &[f64], dt: f64, periods: &[f64], damping: f64) -> RotatedSpectrum {
    let n = x.len().min(y.len());
    let (x, y) = (&x[..n], &y[..n]);
    let mut peaks = vec![[f64::NAN; ANGLES]; periods.len()];
    let valid = is_valid(dt, damping);
    if valid && n > 1 {
        let directions = Directions::new();
        let grounds = Grounds::new(&[x, y], dt);
        for (k, members) in by_upsampling(dt, periods) {
            let corners = grounds.corners(k);
            let step = dt / k as f64;
            let batches: Vec<&[usize]> = members.chunks(LANES).collect();
            let worth = n * k * members.len() > 1 << 16;
            let found: Vec<[[f64; ANGLES]; LANES]> = parallel::each(&batches, worth, |batch| {
                let oscillators = side_by_side(batch, periods, damping, step);
                turned_peaks(&oscillators, [&corners[0], &corners[1]], &directions, step)
            });
            for (batch, found) in batches.iter().zip(found) {
                batch.iter().zip(found).for_each(|(i, turned)| peaks[*i] = turned);
            }
        }
        for i in (0..periods.len()).filter(|i| periods[*i] == 0.0) {
            peaks[i] = turned_samples(x, y, &directions);
        }
    }
    summary(periods, damping, &peaks)
}

/// Statistics over the directions, as pseudo-accelerations.
fn summary(periods: &[f64], damping: f64, peaks: &[[f64; ANGLES]]) -> RotatedSpectrum {
    let empty = || Vec::with_capacity(periods.len());
    let mut result = RotatedSpectrum {
        periods: periods.to_vec(),
        damping,
        rotd00: empty(),
        rotd50: empty(),
        rotd100: empty(),
        rotd100_angle: empty(),
        geometric_mean: empty(),
        along_x: empty(),
        along_y: empty(),
    };
    for (period, peaks) in periods.iter().zip(peaks) {
        // At the period 0 the peaks are accelerations already.
        let factor = if *period == 0.0 { 1.0 } else { (TAU / period).powi(2) };
        let (x, y) = (factor * peaks[0], factor * peaks[ANGLES / 2]);
        let largest = (0..ANGLES).fold(0, |best, i| if peaks[i] > peaks[best] { i } else { best });
        let mut sorted = *peaks;
        sorted.sort_by(f64::total_cmp);
        let middle = 0.5 * (sorted[ANGLES / 2 - 1] + sorted[ANGLES / 2]);
        result.rotd00.push(factor * sorted[0]);
        result.rotd50.push(factor * middle);
        result.rotd100.push(factor * sorted[ANGLES - 1]);
        result.rotd100_angle.push(if x.is_nan() { f64::NAN } else { largest as f64 });
        result.geometric_mean.push((x * y).sqrt());
        result.along_x.push(x);
        result.along_y.push(y);
    }
    result
}

/// Unit vectors of the directions.
struct Directions {
    cos: [f64; ANGLES],
    sin: [f64; ANGLES],
}

impl Directions {
    fn new() -> Self {
        let angle = |i: usize| PI * i as f64 / ANGLES as f64;
        let mut cos: [f64; ANGLES] = std::array::from_fn(|i| angle(i).cos());
        let sin = std::array::from_fn(|i| angle(i).sin());
        cos[ANGLES / 2] = 0.0;
        Self { cos, sin }
    }
}

/// Both oscillators of one period at one time.
type Pair = [State; 2];

/// Peaks of all directions so far, and the ellipse inside which nothing can raise them.
///
/// A displacement p lies in the ellipse of the matrix C and the radius r where `pᵀ C⁻¹ p ≤ r²`; its
/// component along the unit vector n is then at most `r √(nᵀ C n)`. With r the smallest of
/// `peak(n)/√(nᵀ C n)` over the directions, no direction is raised. C follows the displacements that
/// did raise one, so that it is long where the motion is.
struct Support {
    peak: [f64; ANGLES],
    moments: [f64; 3],
    /// Rows of C^(−½): long axis, short axis.
    axes: [[f64; 2]; 2],
    /// `1/(nᵀ C n)` of each direction.
    slimness: [f64; ANGLES],
    radius_squared: f64,
}

impl Support {
    fn new() -> Self {
        Self {
            peak: [0.0; ANGLES],
            moments: [0.0; 3],
            axes: [[1.0, 0.0], [0.0, 1.0]],
            slimness: [1.0; ANGLES],
            radius_squared: 0.0,
        }
    }

    /// Largest `pᵀ C⁻¹ p` of the control points u ± v h/3 of the cubics that meet at a point.
    fn reach(&self, at: Pair, third: f64) -> f64 {
        let along = |x: f64, y: f64| self.axes.map(|axis| axis[0] * x + axis[1] * y);
        farther(along(at[0].u, at[1].u), along(third * at[0].v, third * at[1].v))
    }

    /// Takes the peaks of one step in all directions.
    fn offer(&mut self, directions: &Directions, from: Pair, to: Pair, step: f64) {
        let mut raised = false;
        for i in 0..ANGLES {
            let (cos, sin) = (directions.cos[i], directions.sin[i]);
            let along =
                |at: Pair| State { u: cos * at[0].u + sin * at[1].u, v: cos * at[0].v + sin * at[1].v };
            let peak = step_peak(along(from), along(to), step);
            raised |= peak > self.peak[i];
            self.peak[i] = if peak > self.peak[i] { peak } else { self.peak[i] };
        }
        if raised {
            let (x, y) = (to[0].u, to[1].u);
            let added = [x * x, x * y, y * y];
            self.moments.iter_mut().zip(added).for_each(|(moment, value)| *moment += value);
        }
    }

    /// Gives the ellipse the shape of the displacements that raised a peak.
    fn reshape(&mut self, directions: &Directions) {
        let [xx, xy, yy] = self.moments;
        if xx + yy <= 0.0 {
            return;
        }
        let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy).hypot(2.0 * xy));
        let long = mean + half;
        let short = (mean - half).max(0.0) + NEGLIGIBLE * NEGLIGIBLE * long;
        for i in 0..ANGLES {
            let [a, b] = [directions.cos[i], directions.sin[i]];
            let width = long * (cos * a + sin * b).powi(2) + short * (cos * b - sin * a).powi(2);
            self.slimness[i] = 1.0 / width;
        }
        let (long, short) = (long.sqrt(), short.sqrt());
        self.axes = [[cos / long, sin / long], [-sin / short, cos / short]];
    }

    /// Grows the ellipse as far as the peaks allow.
    fn grow(&mut self) {
        let floor = NEGLIGIBLE * self.peak.iter().fold(0.0, |top, &peak| if peak > top { peak } else { top });
        let mut smallest = f64::INFINITY;
        for (peak, slimness) in self.peak.iter().zip(&self.slimness) {
            let peak = if *peak > floor { *peak } else { floor };
            let allowed = peak * peak * slimness;
            smallest = if allowed < smallest { allowed } else { smallest };
        }
        self.radius_squared = smallest;
    }

    /// Takes the peaks of consecutive steps, the farthest first, as most others then lie inside.
    fn take(&mut self, directions: &Directions, states: &[Pair], step: f64) {
        let third = step / 3.0;
        let mut outside: Vec<(f64, usize)> = Vec::new();
        let mut before = self.reach(states[0], third);
        for (i, state) in states.iter().enumerate().skip(1) {
            let at = self.reach(*state, third);
            let reach = before.max(at);
            if reach > self.radius_squared {
                outside.push((reach, i));
            }
            before = at;
        }
        if outside.is_empty() {
            return;
        }
        outside.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (reach, i) in outside {
            if reach <= self.radius_squared {
                break;
            }
            self.offer(directions, states[i - 1], states[i], step);
            self.grow();
        }
        self.reshape(directions);
        self.grow();
    }
}

/// The larger of |p + w|² and |p − w|².
#[inline(always)]
fn farther(p: [f64; 2], w: [f64; 2]) -> f64 {
    (p[0] * p[0] + p[1] * p[1]) + (w[0] * w[0] + w[1] * w[1]) + 2.0 * (p[0] * w[0] + p[1] * w[1]).abs()
}

/// max |u_θ| in all directions of `LANES` oscillators, over the ground motion and the free vibration after it.
fn turned_peaks<const LANES: usize>(
    oscillators: &[Oscillator; LANES],
    ground: [&[f64]; 2],
    directions: &Directions,
    step: f64,
) -> [[f64; ANGLES]; LANES] {
    let mut lanes = TurnedLanes::new(oscillators, step);
    let mut supports: [Support; LANES] = std::array::from_fn(|_| Support::new());
    let last = ground[0].len() - 1;
    let mut first = 0;
    while first < last {
        let end = (first + BLOCK).min(last);
        let block = ground.map(|ground| &ground[first..=end]);
        let start = lanes.state;
        let reach = lanes.reach(block);
        for lane in 0..LANES {
            if reach[lane] > supports[lane].radius_squared {
                let states = trajectory(&oscillators[lane], start.at(lane), block);
                supports[lane].take(directions, &states, step);
                lanes.follow(lane, &supports[lane]);
            }
        }
        first = end;
    }
    std::array::from_fn(|lane| {
        let [x, y] = lanes.state.at(lane);
        std::array::from_fn(|i| {
            let (cos, sin) = (directions.cos[i], directions.sin[i]);
            let state = State { u: cos * x.u + sin * y.u, v: cos * x.v + sin * y.v };
            supports[lane].peak[i].max(oscillators[lane].free_peak(state))
        })
    })
}

/// States at all points of a block, the plain recursion.
fn trajectory(oscillator: &Oscillator, start: Pair, block: [&[f64]; 2]) -> Vec<Pair> {
    let mut states = Vec::with_capacity(block[0].len());
    let mut at = start;
    states.push(at);
    for (x, y) in block[0].windows(2).zip(block[1].windows(2)) {
        at = [oscillator.advance(at[0], x[0], x[1]), oscillator.advance(at[1], y[0], y[1])];
        states.push(at);
    }
    states
}

/// Displacements and velocities of all lanes along x and y.
#[derive(Clone, Copy)]
struct LaneStates<const LANES: usize> {
    u: [[f64; LANES]; 2],
    v: [[f64; LANES]; 2],
}

impl<const LANES: usize> LaneStates<LANES> {
    fn at(&self, lane: usize) -> Pair {
        std::array::from_fn(|axis| State { u: self.u[axis][lane], v: self.v[axis][lane] })
    }
}

/// Oscillators side by side along x and y, with the ellipse of each.
struct TurnedLanes<const LANES: usize> {
    lanes: Lanes<LANES>,
    state: LaneStates<LANES>,
    /// [axis of the ellipse][component][lane].
    axes: [[[f64; LANES]; 2]; 2],
    third: f64,
}

impl<const LANES: usize> TurnedLanes<LANES> {
    fn new(oscillators: &[Oscillator; LANES], step: f64) -> Self {
        let zero = [[0.0; LANES]; 2];
        let axes = [[[1.0; LANES], [0.0; LANES]], [[0.0; LANES], [1.0; LANES]]];
        let state = LaneStates { u: zero, v: zero };
        Self { lanes: Lanes::new(oscillators), state, axes, third: step / 3.0 }
    }

    fn follow(&mut self, lane: usize, support: &Support) {
        for axis in 0..2 {
            for component in 0..2 {
                self.axes[axis][component][lane] = support.axes[axis][component];
            }
        }
    }

    /// Takes all lanes through a block and returns the largest distance of any control point.
    #[inline(never)]
    fn reach(&mut self, block: [&[f64]; 2]) -> [f64; LANES] {
        let (lanes, axes, third) = (self.lanes.clone(), self.axes, self.third);
        let LaneStates { u: [mut ux, mut uy], v: [mut vx, mut vy] } = self.state;
        let mut reach = [0.0; LANES];
        widen(&mut reach, &axes, third, [&ux, &uy], [&vx, &vy]);
        for (x, y) in block[0].windows(2).zip(block[1].windows(2)) {
            lanes.advance(&mut ux, &mut vx, x[0], x[1]);
            lanes.advance(&mut uy, &mut vy, y[0], y[1]);
            widen(&mut reach, &axes, third, [&ux, &uy], [&vx, &vy]);
        }
        self.state = LaneStates { u: [ux, uy], v: [vx, vy] };
        reach
    }
}

/// Raises each lane's reach to that of its control points at one point.
#[inline(always)]
fn widen<const LANES: usize>(
    reach: &mut [f64; LANES],
    axes: &[[[f64; LANES]; 2]; 2],
    third: f64,
    u: [&[f64; LANES]; 2],
    v: [&[f64; LANES]; 2],
) {
    for lane in 0..LANES {
        let along = |i: usize, at: [&[f64; LANES]; 2]| {
            axes[i][0][lane] * at[0][lane] + axes[i][1][lane] * at[1][lane]
        };
        let p = [along(0, u), along(1, u)];
        let w = [third * along(0, v), third * along(1, v)];
        let far = farther(p, w);
        reach[lane] = if far > reach[lane] { far } else { reach[lane] };
    }
}

/// max |a_θ| over the samples in all directions.
fn turned_samples(x: &[f64], y: &[f64], directions: &Directions) -> [f64; ANGLES] {
    let mut support = Support::new();
    let rest = |a: f64| State { u: a, v: 0.0 };
    let points: Vec<Pair> = x.iter().zip(y).map(|(x, y)| [rest(*x), rest(*y)]).collect();
    // Each block begins with the last point of the one before, as a step needs both ends.
    let mut first = 0;
    while first + 1 < points.len() {
        let end = (first + BLOCK).min(points.len() - 1);
        support.take(directions, &points[first..=end], 0.0);
        first = end;
    }
    // A step gives the peak of its end: the very first point is the end of none.
    let start = points[0];
    support.offer(directions, start, start, 0.0);
    support.peak
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: u64, n: usize) -> Vec<f64> {
        let mut seed = seed;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..n).map(|i| next() * (0.2 + (i as f64 * 9.0 / n as f64).sin().powi(2))).collect()
    }

    /// Every step turned into every direction.
    fn by_brute_force(x: &[f64], y: &[f64], dt: f64, period: f64, damping: f64) -> [f64; ANGLES] {
        let directions = Directions::new();
        let (k, _) = by_upsampling(dt, &[period])[0];
        let corners = Grounds::new(&[x, y], dt).corners(k);
        let step = dt / k as f64;
        let oscillator = Oscillator::new(period, damping, step);
        let rest = [State::default(); 2];
        let states = trajectory(&oscillator, rest, [&corners[0], &corners[1]]);
        std::array::from_fn(|i| {
            let (cos, sin) = (directions.cos[i], directions.sin[i]);
            let along =
                |at: &Pair| State { u: cos * at[0].u + sin * at[1].u, v: cos * at[0].v + sin * at[1].v };
            let steps = states.windows(2).map(|pair| step_peak(along(&pair[0]), along(&pair[1]), step));
            let free = oscillator.free_peak(along(states.last().unwrap()));
            steps.fold(free, f64::max)
        })
    }

    #[test]
    fn what_is_left_out_could_not_have_been_a_peak() {
        let (dt, damping, n) = (0.01, 0.05, 3001);
        let (a, b) = (noise(1, n), noise(2, n));
        let mixed = |p: f64, q: f64| a.iter().zip(&b).map(|(a, b)| p * a + q * b).collect::<Vec<f64>>();
        // Independent, strongly polarised, exactly polarised between two directions, one at rest.
        let cases = [
            (a.clone(), b.clone()),
            (a.clone(), mixed(0.3, 0.01)),
            (mixed(0.861_629_16, 0.0), mixed(0.507_538_36, 0.0)),
            (a.clone(), a.clone()),
            (a.clone(), vec![0.0; n]),
        ];
        let periods = log_periods_with_zero();
        for (case, (x, y)) in cases.iter().enumerate() {
            let found = rotated_spectrum(x, y, dt, &periods, damping);
            for (i, &period) in periods.iter().enumerate().skip(1) {
                let mut peaks = by_brute_force(x, y, dt, period, damping);
                let factor = (TAU / period).powi(2);
                peaks.iter_mut().for_each(|peak| *peak *= factor);
                assert!((found.along_x[i] - peaks[0]).abs() <= 1e-12 * peaks[0]);
                assert!((found.along_y[i] - peaks[90]).abs() <= 1e-12 * peaks[90] + 1e-7 * peaks[0]);
                peaks.sort_by(f64::total_cmp);
                let top = peaks[179];
                let wanted = [peaks[0], 0.5 * (peaks[89] + peaks[90]), top];
                let values = [found.rotd00[i], found.rotd50[i], found.rotd100[i]];
                for (j, (value, wanted)) in values.iter().zip(wanted).enumerate() {
                    let allowed = if j == 0 { 1.1e-7 * top } else { 1e-12 * top };
                    assert!(
                        (value - wanted).abs() <= allowed,
                        "case {case} T {period} {j}: {value} {wanted}"
                    );
                }
            }
        }
    }

    fn log_periods_with_zero() -> Vec<f64> {
        let mut periods = super::super::log_periods(0.008, 9.0, 31);
        periods.insert(0, 0.0);
        periods
    }

    #[test]
    fn at_the_period_zero_the_samples_are_turned() {
        let (x, y) = (noise(3, 1001), noise(4, 1001));
        let found = rotated_spectrum(&x, &y, 0.01, &[0.0], 0.05);
        let mut peaks: Vec<f64> = (0..180)
            .map(|i| (PI * f64::from(i) / 180.0).sin_cos())
            .map(|(s, c)| x.iter().zip(&y).fold(0.0, |top: f64, (x, y)| top.max((c * x + s * y).abs())))
            .collect();
        peaks.sort_by(f64::total_cmp);
        assert!((found.rotd100[0] - peaks[179]).abs() < 1e-12);
        assert!((found.rotd50[0] - 0.5 * (peaks[89] + peaks[90])).abs() < 1e-12);
        assert!((found.rotd00[0] - peaks[0]).abs() < 1e-12);
    }
}
