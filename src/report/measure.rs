//! What the figures need of each trace beyond its samples: response spectrum, Husid curve, Fourier spectrum.

use hati_inputs::measures;

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

/// Measures of all traces that are drawn, computed side by side.
pub(super) fn of_all(data: &SiteResponse, periods: &[f64]) -> Vec<TraceMeasures> {
    let mut wanted = vec![false; data.traces.len()];
    for axis in 0..3 {
        for drawn in place::drawn(&data.traces, axis) {
            wanted[drawn.index] = true;
        }
    }
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let mut results = vec![TraceMeasures::default(); data.traces.len()];
    let share = data.traces.len().div_ceil(workers).max(1);
    std::thread::scope(|scope| {
        let traces = data.traces.chunks(share).zip(wanted.chunks(share));
        for ((traces, wanted), results) in traces.zip(results.chunks_mut(share)) {
            scope.spawn(move || {
                for ((trace, wanted), result) in traces.iter().zip(wanted).zip(results) {
                    if *wanted {
                        *result = of_trace(trace, data.dt, periods);
                    }
                }
            });
        }
    });
    results
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
    TraceMeasures {
        psa: measures::psa(a, dt, periods, DAMPING),
        husid: measures::husid(a, dt),
        frequency,
        amplitude,
        centres,
        smoothed,
    }
}
