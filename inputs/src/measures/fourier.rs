//! Fourier amplitudes and their smoothing.

use crate::motion::{PAD_SECONDS, Spectrum};

/// Fourier amplitude spectrum |A(f)| = |∫ a e^{−i2πft} dt| of a record followed by zeros.
///
/// - `a`: m/s², step `dt` (s).
/// - returns the frequencies (Hz, from 0 to Nyquist, equally spaced at 1/(M dt) with M from
///   [`crate::motion::padded_length`]) and the amplitudes (m/s). Empty for an empty record.
#[must_use]
pub fn fourier_amplitude(a: &[f64], dt: f64) -> (Vec<f64>, Vec<f64>) {
    if a.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let spectrum = Spectrum::of(a, dt, PAD_SECONDS);
    let frequencies = (0..spectrum.bins.len()).map(|bin| spectrum.frequency(bin));
    let amplitudes = spectrum.bins.iter().map(|value| value.norm() * dt);
    (frequencies.collect(), amplitudes.collect())
}

/// Mean period T_m = Σ C²/f / Σ C² over the Fourier amplitudes C from 0.25 to 20 Hz, s.
///
/// After Rathje, Abrahamson and Bray (1998). The padding keeps the spacing at or below the 0.05 Hz
/// that the measure asks for. 0 for a record without energy in that range.
#[must_use]
pub fn mean_period(a: &[f64], dt: f64) -> f64 {
    let (frequencies, amplitudes) = fourier_amplitude(a, dt);
    let mut weighted = 0.0;
    let mut total = 0.0;
    for (f, c) in frequencies.iter().zip(&amplitudes) {
        if (0.25..=20.0).contains(f) {
            weighted += c * c / f;
            total += c * c;
        }
    }
    if total > 0.0 { weighted / total } else { 0.0 }
}

/// Where the smoothing window is cut: at its sixth zero on either side, where its tail is below 2e-6.
const WINDOW_ZEROS: f64 = 6.0;

/// Konno–Ohmachi smoothing of an amplitude spectrum at the given centre frequencies.
///
/// Weights `w(f) = [sin x / x]⁴`, `x = b log₁₀(f/f_c)`, normalised to sum 1 over the given
/// frequencies, cut at |x| = 6π. Larger `b` smooths less; 40 is customary.
///
/// - `frequencies`: Hz, increasing; `amplitudes` beside them; `centres`: Hz.
/// - returns one value per centre, in the unit of `amplitudes`. A centre that is not positive, or so
///   far from all frequencies that no weight is left, takes the nearest amplitude (0 if there is none).
///
/// Cost: the frequencies within the window, per centre. Source: Konno and Ohmachi (1998).
#[must_use]
pub fn konno_ohmachi(frequencies: &[f64], amplitudes: &[f64], centres: &[f64], b: f64) -> Vec<f64> {
    let n = frequencies.len().min(amplitudes.len());
    let (frequencies, amplitudes) = (&frequencies[..n], &amplitudes[..n]);
    let half_width = 10_f64.powf(WINDOW_ZEROS * std::f64::consts::PI / b.abs().max(1e-3));
    let smooth = |&centre: &f64| {
        let low = frequencies.partition_point(|f| *f < centre / half_width);
        let high = frequencies.partition_point(|f| *f <= centre * half_width);
        let mut sum = 0.0;
        let mut total = 0.0;
        for i in low..high.max(low) {
            let x = b * (frequencies[i] / centre).log10();
            let weight = if x.abs() < 1e-6 { 1.0 } else { (x.sin() / x).powi(4) };
            if weight.is_finite() {
                sum += weight * amplitudes[i];
                total += weight;
            }
        }
        if centre > 0.0 && total > 0.0 { sum / total } else { nearest(frequencies, amplitudes, centre) }
    };
    centres.iter().map(smooth).collect()
}

fn nearest(frequencies: &[f64], amplitudes: &[f64], centre: f64) -> f64 {
    let next = frequencies.partition_point(|f| *f < centre);
    let after = frequencies.get(next).map_or(f64::INFINITY, |f| f - centre);
    let before = match next.checked_sub(1) {
        Some(i) => centre - frequencies[i],
        None => f64::INFINITY,
    };
    let index = if before < after { next - 1 } else { next };
    amplitudes.get(index).copied().unwrap_or(0.0)
}
