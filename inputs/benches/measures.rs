//! Time of everything that a page shows of one long motion: 20 minutes, 200 Hz, three components.
//!
//! Run with `cargo bench -p hati-inputs --bench measures`.

use std::hint::black_box;
use std::io::Write;
use std::time::Instant;

use hati_inputs::measures;

/// Noise under an envelope, in steps of 5 ms.
fn component(seed: u64) -> Vec<f64> {
    let mut seed = seed;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let (mut low, mut band) = (0.0, 0.0);
    (0..240_000)
        .map(|i| {
            let t = i as f64 * 0.005;
            let envelope = (t / 60.0) * (1.0 - t / 60.0).exp() + 0.05;
            low += 0.15 * (noise() - low);
            band += 0.02 * (low - band);
            envelope * (low - band)
        })
        .collect()
}

fn timed<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let begin = Instant::now();
    let result = black_box(work());
    let line = format!("{:9.1} ms  {what}\n", 1e3 * begin.elapsed().as_secs_f64());
    let _ = std::io::stdout().write_all(line.as_bytes());
    result
}

fn main() {
    let dt = 0.005;
    let motion = [component(1), component(2), component(3)];
    let periods = measures::log_periods(0.01, 10.0, 100);
    let centres = measures::log_periods(0.05, 100.0, 200);
    let [x, y, z] = &motion;
    timed("PSA of one component", || measures::response_spectrum(x, dt, &periods, 0.05));
    timed("the page", || {
        timed("  RotD with PSA of x and y", || measures::rotated_spectrum(x, y, dt, &periods, 0.05));
        timed("  PSA z", || measures::response_spectrum(z, dt, &periods, 0.05));
        timed("  peaks, Arias intensity, CAV, durations, mean period of x, y, z", || {
            motion.each_ref().map(|a| measures::Measures::of(a, dt, 0.1))
        });
        timed("  Husid curves", || motion.each_ref().map(|a| measures::husid(a, dt)));
        let raw =
            timed("  Fourier amplitudes", || motion.each_ref().map(|a| measures::fourier_amplitude(a, dt)));
        let [h1, h2, v] = timed("  smoothed at 200 centres", || {
            measures::konno_ohmachi_each(&raw[0].0, raw.each_ref().map(|r| &r.1[..]), &centres, 40.0)
        });
        timed("  H/V of the smoothed", || measures::ratio_of_smoothed(&h1, &h2, &v));
    });
}
