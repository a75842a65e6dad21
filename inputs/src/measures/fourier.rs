//! Fourier amplitudes, their smoothing, and the ratio of horizontal to vertical.

use super::parallel;
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
    if a.is_empty() { 0.0 } else { mean_period_of(&Spectrum::of(a, dt, PAD_SECONDS)) }
}

pub(super) fn mean_period_of(spectrum: &Spectrum) -> f64 {
    let mut weighted = 0.0;
    let mut total = 0.0;
    for (bin, value) in spectrum.bins.iter().enumerate() {
        let f = spectrum.frequency(bin);
        if (0.25..=20.0).contains(&f) {
            weighted += value.norm_sqr() / f;
            total += value.norm_sqr();
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
/// Cost: about 1 ns per frequency within the window and centre. Source: Konno and Ohmachi (1998).
#[must_use]
pub fn konno_ohmachi(frequencies: &[f64], amplitudes: &[f64], centres: &[f64], b: f64) -> Vec<f64> {
    let [smoothed] = konno_ohmachi_each(frequencies, [amplitudes], centres, b);
    smoothed
}

/// [`konno_ohmachi`] of several spectra with the same frequencies: the weights are computed once.
#[must_use]
pub fn konno_ohmachi_each<const N: usize>(
    frequencies: &[f64],
    amplitudes: [&[f64]; N],
    centres: &[f64],
    b: f64,
) -> [Vec<f64>; N] {
    let n = amplitudes.iter().fold(frequencies.len(), |n, column| n.min(column.len()));
    let window = Window::new(&frequencies[..n], b);
    let columns = amplitudes.map(|column| &column[..n]);
    let worth = n * centres.len() > 1 << 16;
    let rows = parallel::each(centres, worth, |&centre| window.smoothed(columns, centre));
    std::array::from_fn(|column| rows.iter().map(|row| row[column]).collect())
}

/// Frequencies on the scale of the window, `x = b log₁₀ f`, with sine and cosine of x: the window at any
/// centre then needs no function but a division.
struct Window<'a> {
    frequencies: &'a [f64],
    b: f64,
    half_width: f64,
    x: Vec<f64>,
    sin: Vec<f64>,
    cos: Vec<f64>,
}

/// Weights computed together.
const LANES: usize = 4;

impl<'a> Window<'a> {
    fn new(frequencies: &'a [f64], b: f64) -> Self {
        let x: Vec<f64> = frequencies.iter().map(|f| b * f.log10()).collect();
        let (sin, cos) = x.iter().map(|x| x.sin_cos()).unzip();
        let half_width = 10_f64.powf(WINDOW_ZEROS * std::f64::consts::PI / b.abs().max(1e-3));
        Self { frequencies, b, half_width, x, sin, cos }
    }

    fn smoothed<const N: usize>(&self, columns: [&[f64]; N], centre: f64) -> [f64; N] {
        // The logarithm of 0 Hz has no weight at any centre.
        let positive = self.frequencies.partition_point(|f| *f <= 0.0);
        let low = self.frequencies.partition_point(|f| *f < centre / self.half_width).max(positive);
        let high = self.frequencies.partition_point(|f| *f <= centre * self.half_width).max(low);
        let x = self.b * centre.log10();
        let (sin, cos) = x.sin_cos();
        let weight = |i: usize| {
            let d = self.x[i] - x;
            let square = d * d;
            let near = 1.0 - square * (1.0 / 6.0 - square / 120.0);
            let far = (self.sin[i] * cos - self.cos[i] * sin) / d;
            let ratio = if square < 1e-4 { near } else { far };
            (ratio * ratio) * (ratio * ratio)
        };
        let (mut total, mut sums) = ([0.0; LANES], [[0.0; LANES]; N]);
        let whole = low + (high - low) / LANES * LANES;
        for first in (low..whole).step_by(LANES) {
            let weights: [f64; LANES] = std::array::from_fn(|lane| weight(first + lane));
            for lane in 0..LANES {
                total[lane] += weights[lane];
                for column in 0..N {
                    sums[column][lane] += weights[lane] * columns[column][first + lane];
                }
            }
        }
        for i in whole..high {
            let weight = weight(i);
            total[0] += weight;
            (0..N).for_each(|column| sums[column][0] += weight * columns[column][i]);
        }
        let total: f64 = total.iter().sum();
        std::array::from_fn(|column| {
            if centre > 0.0 && total > 0.0 {
                sums[column].iter().sum::<f64>() / total
            } else {
                nearest(self.frequencies, columns[column], centre)
            }
        })
    }
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

/// Ratio of horizontal to vertical Fourier amplitude, each component smoothed on its own:
/// `H/V(f) = √(X(f) Y(f)) / Z(f)`.
///
/// - `x`, `y`: horizontal, `z`: vertical, one unit, step `dt` (s); of unlike lengths the shortest counts.
/// - `centres`: Hz; `b`: coefficient of the Konno–Ohmachi window (40 is customary).
/// - returns one value per centre; not a number where the vertical carries nothing.
///
/// The whole record is one window. The ratio of an earthquake therefore shows its source and path as well
/// as the site; for ambient noise the custom is the mean over many short windows without transients,
/// which this function does not take. Below about 10/duration, and below the band that the record
/// carries, the ratio is that of noise. Horizontals are combined by their geometric mean, which
/// depends a little on the azimuth of the instrument.
#[must_use]
pub fn horizontal_to_vertical(x: &[f64], y: &[f64], z: &[f64], dt: f64, centres: &[f64], b: f64) -> Vec<f64> {
    let n = x.len().min(y.len()).min(z.len());
    let records = [&x[..n], &y[..n], &z[..n]];
    let spectra = parallel::each(&records, n > 1 << 14, |a| fourier_amplitude(a, dt));
    let [h1, h2, v] =
        konno_ohmachi_each(&spectra[0].0, [&spectra[0].1, &spectra[1].1, &spectra[2].1], centres, b);
    ratio_of_smoothed(&h1, &h2, &v)
}

/// [`horizontal_to_vertical`] from amplitudes that are smoothed already, all at the same frequencies.
#[must_use]
pub fn ratio_of_smoothed(x: &[f64], y: &[f64], z: &[f64]) -> Vec<f64> {
    let ratio = |((x, y), z): ((&f64, &f64), &f64)| if *z > 0.0 { (x * y).sqrt() / z } else { f64::NAN };
    x.iter().zip(y).zip(z).map(ratio).collect()
}
