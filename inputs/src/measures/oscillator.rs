//! The linear oscillator on a moving base: one exact step, and many oscillators side by side.

use std::f64::consts::{PI, TAU};

/// Steps after which the oscillators side by side are looked at.
pub(super) const BLOCK: usize = 128;

/// One step of an oscillator: `u' = uu u + uv v + u0 a + u1 a'`, `v'` likewise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Oscillator {
    omega: f64,
    damping: f64,
    step: f64,
    u: [f64; 4],
    v: [f64; 4],
}

/// Relative displacement (m) and velocity (m/s).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct State {
    pub(super) u: f64,
    pub(super) v: f64,
}

impl Oscillator {
    /// Coefficients of the exact step for a ground acceleration that is straight over `step` (s).
    ///
    /// Over one step the load is p(t) = p₀ + s t, p = −a. A particular solution is A + B t with
    /// B = s/ω², A = (p₀ − 2ζω B)/ω²; the free vibration from (u − A, v − B) is added.
    pub(super) fn new(period: f64, damping: f64, step: f64) -> Self {
        let omega = TAU / period;
        let omega_d = omega * (1.0 - damping * damping).sqrt();
        let decay = (-damping * omega * step).exp();
        let (sin, cos) = (omega_d * step).sin_cos();
        let (s, c) = (decay * sin / omega_d, decay * cos);
        // Free vibration: u = (c + ζω s) u₀ + s v₀, v = −ω² s u₀ + (c − ζω s) v₀.
        let uu = c + damping * omega * s;
        let uv = s;
        let vu = -omega * omega * s;
        let vv = c - damping * omega * s;
        let response = |p0: f64, p1: f64| {
            let slope = (p1 - p0) / (step * omega * omega);
            let start = p0 / (omega * omega) - 2.0 * damping * slope / omega;
            let displacement = start + slope * step - uu * start - uv * slope;
            let velocity = slope - vu * start - vv * slope;
            (displacement, velocity)
        };
        let (u0, v0) = response(-1.0, 0.0);
        let (u1, v1) = response(0.0, -1.0);
        Self { omega, damping, step, u: [uu, uv, u0, u1], v: [vu, vv, v0, v1] }
    }

    /// State after one step in which the ground goes from `a0` to `a1` (m/s²).
    #[inline(always)]
    pub(super) fn advance(&self, from: State, a0: f64, a1: f64) -> State {
        let [uu, uv, u0, u1] = self.u;
        let [vu, vv, v0, v1] = self.v;
        State {
            u: uu * from.u + uv * from.v + (u0 * a0 + u1 * a1),
            v: vu * from.u + vv * from.v + (v0 * a0 + v1 * a1),
        }
    }

    /// max |u| over `ground` (from `state`, which is taken to its end): the plain recursion.
    ///
    /// The peak inside a step is that of the cubic through both ends; see [`turning_point`].
    pub(super) fn peak(&self, ground: &[f64], state: &mut State) -> f64 {
        let mut peak = 0.0_f64;
        for pair in ground.windows(2) {
            let next = self.advance(*state, pair[0], pair[1]);
            peak = peak.max(step_peak(*state, next, self.step));
            *state = next;
        }
        peak
    }

    /// First maximum of |u| in free vibration from a state.
    pub(super) fn free_peak(&self, from: State) -> f64 {
        let State { u, v } = from;
        let decay = self.damping * self.omega;
        let omega_d = self.omega * (1.0 - self.damping * self.damping).sqrt();
        let mut angle = (v * omega_d).atan2(decay * v + self.omega * self.omega * u);
        if angle < 0.0 {
            angle += PI;
        }
        let amplitude = u * angle.cos() + (v + decay * u) / omega_d * angle.sin();
        (amplitude * (-decay * angle / omega_d).exp()).abs()
    }
}

/// max |u| at the end of a step and, where the velocity changes sign, inside it.
#[inline(always)]
pub(super) fn step_peak(from: State, to: State, step: f64) -> f64 {
    let inside = if from.v * to.v < 0.0 { turning_point(from, to, step).abs() } else { 0.0 };
    let end = to.u.abs();
    if inside > end { inside } else { end }
}

/// Displacement where the velocity vanishes inside a step: cubic through both ends.
#[inline(always)]
pub(super) fn turning_point(from: State, to: State, step: f64) -> f64 {
    let t = from.v / (from.v - to.v);
    let (a, b) = (1.0 - t, t);
    from.u * a * a * (1.0 + 2.0 * b) + to.u * b * b * (1.0 + 2.0 * a) + step * a * b * (from.v * a - to.v * b)
}

/// `LANES` oscillators with one step, their numbers side by side so that vector units work on them.
#[derive(Debug, Clone)]
pub(super) struct Lanes<const LANES: usize> {
    u: [[f64; LANES]; 4],
    v: [[f64; LANES]; 4],
}

impl<const LANES: usize> Lanes<LANES> {
    pub(super) fn new(oscillators: &[Oscillator; LANES]) -> Self {
        let u = std::array::from_fn(|i| std::array::from_fn(|lane| oscillators[lane].u[i]));
        let v = std::array::from_fn(|i| std::array::from_fn(|lane| oscillators[lane].v[i]));
        Self { u, v }
    }

    /// One step of all lanes, the same operations in the same order as [`Oscillator::advance`].
    #[inline(always)]
    pub(super) fn advance(&self, u: &mut [f64; LANES], v: &mut [f64; LANES], a0: f64, a1: f64) {
        for lane in 0..LANES {
            let (from_u, from_v) = (u[lane], v[lane]);
            u[lane] = self.u[0][lane] * from_u
                + self.u[1][lane] * from_v
                + (self.u[2][lane] * a0 + self.u[3][lane] * a1);
            v[lane] = self.v[0][lane] * from_u
                + self.v[1][lane] * from_v
                + (self.v[2][lane] * a0 + self.v[3][lane] * a1);
        }
    }
}

/// SD of `LANES` oscillators over one polygon and the free vibration after it; equal to the plain recursion.
///
/// Between its ends the cubic of a step stays inside the hull of its control points u, u ± v h/3, hence
/// |u| ≤ max(|u| + |v| h/3) over both ends. The lanes run without a branch through a block of steps and
/// keep that bound; only a lane whose bound exceeds its peak so far goes through the block again, in full.
pub(super) fn peaks<const LANES: usize>(oscillators: &[Oscillator; LANES], ground: &[f64]) -> [f64; LANES] {
    let lanes = Lanes::new(oscillators);
    let third = oscillators[0].step / 3.0;
    let (mut u, mut v, mut peak) = ([0.0; LANES], [0.0; LANES], [0.0_f64; LANES]);
    let mut first = 0;
    while first + 1 < ground.len() {
        let last = (first + BLOCK).min(ground.len() - 1);
        let block = &ground[first..=last];
        let start = (u, v);
        let reach = reach(&lanes, &mut u, &mut v, third, block);
        for lane in 0..LANES {
            if reach[lane] > peak[lane] {
                let mut state = State { u: start.0[lane], v: start.1[lane] };
                peak[lane] = peak[lane].max(oscillators[lane].peak(block, &mut state));
            }
        }
        first = last;
    }
    let free = |lane: usize| oscillators[lane].free_peak(State { u: u[lane], v: v[lane] });
    std::array::from_fn(|lane| peak[lane].max(free(lane)))
}

/// Takes all lanes through a block and returns max(|u| + |v| h/3) over it, its first point included.
#[inline(never)]
fn reach<const LANES: usize>(
    lanes: &Lanes<LANES>,
    u_out: &mut [f64; LANES],
    v_out: &mut [f64; LANES],
    third: f64,
    block: &[f64],
) -> [f64; LANES] {
    // Local copies stay in registers.
    let (lanes, mut u, mut v) = (lanes.clone(), *u_out, *v_out);
    let mut reach: [f64; LANES] = std::array::from_fn(|lane| u[lane].abs() + v[lane].abs() * third);
    for pair in block.windows(2) {
        lanes.advance(&mut u, &mut v, pair[0], pair[1]);
        for lane in 0..LANES {
            let bound = u[lane].abs() + v[lane].abs() * third;
            reach[lane] = if bound > reach[lane] { bound } else { reach[lane] };
        }
    }
    (*u_out, *v_out) = (u, v);
    reach
}
