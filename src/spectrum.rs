//! Fourier spectrum of a sampled motion inside a band.

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
    if fft.process(&mut padded, &mut spectrum).is_err() {
        unreachable!("the buffers have the planner's own lengths");
    }
    let df = 1.0 / (n as f64 * dt);
    (spectrum.into_iter().enumerate().skip(1))
        .map(|(k, value)| (k as f64 * df, value))
        .filter(|(f, _)| *f >= band.0 && *f <= band.1)
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::band_spectrum;

    #[test]
    fn a_cosine_stands_at_its_frequency() {
        let dt = 0.01;
        let a: Vec<f64> =
            (0..1000).map(|i| (2.0 * std::f64::consts::PI * 5.0 * i as f64 * dt).cos()).collect();
        let (f, s) = band_spectrum(&a, dt, (1.0, 20.0));
        assert!(f[0] >= 1.0 && f[f.len() - 1] <= 20.0);
        let (k, top) = s.iter().map(|s| s.norm()).enumerate().max_by(|x, y| x.1.total_cmp(&y.1)).unwrap();
        assert!((f[k] - 5.0).abs() < 0.06 && (top - 500.0).abs() < 5.0, "{} Hz, {top}", f[k]);
    }
}
