//! What the figures need of each trace beyond its samples: response spectrum, Husid curve, Fourier spectrum.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use hati_inputs::measures;
use hati_inputs::motion::STANDARD_GRAVITY;

use super::place;
use crate::results::{SiteResponse, Trace};

/// Damping ratio of the response spectra.
pub(super) const DAMPING: f64 = 0.05;
/// Number of periods of the response spectra.
const PERIODS: usize = 120;
/// Number of centre frequencies of the smoothed Fourier spectra.
const CENTRES: usize = 160;
/// Bandwidth coefficient of the Konno–Ohmachi window.
pub(super) const BANDWIDTH: f64 = 40.0;

/// Spectra of one trace; all empty where the trace is too short or not drawn.
#[derive(Debug, Clone, Default)]
pub(super) struct TraceMeasures {
    /// Pseudo-acceleration at [`periods`], m/s².
    pub(super) psa: Vec<f64>,
    /// Pseudo-velocity at [`periods`], m/s.
    pub(super) psv: Vec<f64>,
    /// Largest relative displacement at [`periods`], m.
    pub(super) sd: Vec<f64>,
    /// Arias intensity, m/s.
    pub(super) arias_intensity: f64,
    /// Times of 5, 75 and 95 % of the Arias intensity from the first sample, s, where they are known better than
    /// by the curve's own straight lines.
    pub(super) times: Option<[f64; 3]>,
    /// Peak acceleration (m/s²), velocity (m/s) and displacement (m), where they are known better than by the samples.
    pub(super) peaks: Option<[f64; 3]>,
    /// Cumulative Arias intensity, 0 to 1.
    pub(super) husid: Vec<f64>,
    /// Frequencies of the Fourier spectrum, Hz.
    pub(super) frequency: Vec<f64>,
    /// Fourier amplitude of the acceleration, m/s.
    pub(super) amplitude: Vec<f64>,
    /// Centre frequencies of the smoothed spectrum, Hz.
    pub(super) centres: Vec<f64>,
    /// Smoothed Fourier amplitude, m/s.
    pub(super) smoothed: Vec<f64>,
}

/// Periods of the response spectra, 0.01 to 10 s, s.
pub(super) fn periods() -> Vec<f64> {
    measures::log_periods(0.01, 10.0, PERIODS)
}

/// Measures of all traces of a run that are drawn.
pub(super) fn of_all(data: &SiteResponse, periods: &[f64]) -> Vec<TraceMeasures> {
    let mut wanted = vec![false; data.traces.len()];
    for axis in 0..3 {
        for drawn in place::drawn(&data.traces, axis) {
            wanted[drawn.index] = true;
        }
    }
    of_traces(&data.traces, &wanted, data.dt, periods)
}

/// Measures of the wanted ones of some traces with the step `dt` (s), computed side by side.
pub(super) fn of_traces(traces: &[Trace], wanted: &[bool], dt: f64, periods: &[f64]) -> Vec<TraceMeasures> {
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let results: Vec<Mutex<TraceMeasures>> = traces.iter().map(|_| Mutex::default()).collect();
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..workers.min(traces.len()) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let (Some(trace), Some(wanted)) = (traces.get(index), wanted.get(index)) else { break };
                    if *wanted {
                        let found = of_trace(trace, dt, periods);
                        *results[index].lock().unwrap_or_else(PoisonError::into_inner) = found;
                    }
                }
            });
        }
    });
    results.into_iter().map(|m| m.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

fn of_trace(trace: &Trace, dt: f64, periods: &[f64]) -> TraceMeasures {
    let a = &trace.acceleration;
    let sound = a.len() >= 2
        && dt.is_finite()
        && dt > 0.0
        && a.iter().all(|v| v.is_finite())
        && a.iter().any(|v| *v != 0.0);
    if !sound {
        return TraceMeasures::default();
    }
    let (frequency, amplitude) = measures::fourier_amplitude(a, dt);
    let duration = a.len() as f64 * dt;
    let centres = measures::log_periods(2.0 / duration, 0.5 / dt, CENTRES);
    let smoothed = measures::konno_ohmachi(&frequency, &amplitude, &centres, BANDWIDTH);
    let spectrum = measures::response_spectrum(a, dt, periods, DAMPING);
    TraceMeasures {
        psa: spectrum.psa,
        psv: spectrum.psv,
        sd: spectrum.sd,
        arias_intensity: arias_intensity(a, dt),
        times: None,
        peaks: None,
        husid: measures::husid(a, dt),
        frequency,
        amplitude,
        centres,
        smoothed,
    }
}

/// π/(2g) ∫a² dt by the trapezoidal rule, m/s.
fn arias_intensity(a: &[f64], dt: f64) -> f64 {
    let squares: f64 = a.windows(2).map(|pair| 0.5 * dt * (pair[0] * pair[0] + pair[1] * pair[1])).sum();
    std::f64::consts::PI / (2.0 * STANDARD_GRAVITY) * squares
}
