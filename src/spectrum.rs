//! Fourier spectrum of a sampled motion inside a band.

use hati_inputs::motion::padded_length;
use num_complex::Complex64;
use realfft::RealFftPlanner;

/// Frequencies (Hz, > 0) inside `band` and the spectrum there, as sums over samples (multiply by `dt` for
/// the integral); zero-padded to twice the length or more, so that the end does not meet the beginning.
pub fn band_spectrum(a: &[f64], dt: f64, band: (f64, f64)) -> (Vec<f64>, Vec<Complex64>) {
    let n = (2 * a.len()).next_power_of_two().max(2);
    let mut padded = vec![0.0; n];
    padded[..a.len()].copy_from_slice(a);
    let fft = RealFftPlanner::new().plan_fft_forward(n);
    let mut spectrum = fft.make_output_vec();
    fft.process(&mut padded, &mut spectrum).expect("the buffers have the planner's own lengths");
    let df = 1.0 / (n as f64 * dt);
    (spectrum.into_iter().enumerate().skip(1))
        .map(|(k, value)| (k as f64 * df, value))
        .filter(|(f, _)| *f >= band.0 && *f <= band.1)
        .unzip()
}

/// A motion whose spectrum is multiplied by `factor(f)`, f in Hz > 0; the mean is kept.
///
/// - `a`: samples, step `dt` (s); zero-padded by `pad_seconds` or more, into which what the factor delays
///   or advances may fall;
/// - returns as many samples.
pub fn filtered(a: &[f64], dt: f64, pad_seconds: f64, mut factor: impl FnMut(f64) -> Complex64) -> Vec<f64> {
    let n = padded_length(a.len(), dt, pad_seconds);
    let mut planner = RealFftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
    let mut time = vec![0.0; n];
    time[..a.len()].copy_from_slice(a);
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut time, &mut spectrum).expect("the buffers have the planner's own lengths");
    for (k, value) in spectrum.iter_mut().enumerate().skip(1) {
        *value *= factor(k as f64 / (n as f64 * dt));
    }
    spectrum[0].im = 0.0;
    if n.is_multiple_of(2) {
        // the Nyquist bin of a real motion is real
        spectrum[n / 2].im = 0.0;
    }
    inverse.process(&mut spectrum, &mut time).expect("the buffers have the planner's own lengths");
    time.truncate(a.len());
    time.iter_mut().for_each(|x| *x /= n as f64);
    time
}

#[cfg(test)]
mod tests {
    use super::{band_spectrum, filtered};
    use num_complex::Complex64;

    #[test]
    fn a_cosine_stands_at_its_frequency() {
        // on a line of the padded spectrum, whose spacing is 1/20.48 Hz
        let at = 102.0 / 20.48;
        let dt = 0.01;
        let a: Vec<f64> =
            (0..1000).map(|i| (2.0 * std::f64::consts::PI * at * i as f64 * dt).cos()).collect();
        let (f, s) = band_spectrum(&a, dt, (1.0, 20.0));
        assert!(f[0] >= 1.0 && f[f.len() - 1] <= 20.0);
        let (k, top) = s.iter().map(|s| s.norm()).enumerate().max_by(|x, y| x.1.total_cmp(&y.1)).unwrap();
        assert!((f[k] - at).abs() < 1e-9 && (top - 500.0).abs() < 5.0, "{} Hz, {top}", f[k]);
    }

    #[test]
    fn a_phase_factor_delays() {
        let dt = 0.01;
        let pulse = |t: f64| (-(t - 1.0).powi(2) * 200.0).exp();
        let a: Vec<f64> = (0..301).map(|i| pulse(i as f64 * dt)).collect();
        let delay = |f: f64| Complex64::new(0.0, -2.0 * std::f64::consts::PI * f * 0.5).exp();
        for (i, x) in filtered(&a, dt, 5.0, delay).iter().enumerate() {
            assert!((x - pulse(i as f64 * dt - 0.5)).abs() < 1e-9, "{i}: {x}");
        }
    }
}
