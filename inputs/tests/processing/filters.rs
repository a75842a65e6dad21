//! Butterworth filters against their closed form and against SciPy.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use hati_inputs::motion::{Filter, Process, integrate};

use super::{assert_close, burst, largest, motion_of, noise, refused, x_of};

/// Gain of one pass in closed form.
fn butterworth(filter: &Filter, f: f64, dt: f64) -> f64 {
    let w = |f: f64| (PI * f * dt).tan();
    let x = match (filter.f_min, filter.f_max) {
        (Some(low), Some(high)) => (w(f).powi(2) - w(low) * w(high)) / (w(f) * (w(high) - w(low))),
        (Some(low), None) => w(low) / w(f),
        (None, high) => w(f) / w(high.unwrap()),
    };
    (1.0 + x.powi(2 * filter.order as i32)).sqrt().recip()
}

/// |Σ y exp(−iωt)| of an impulse's response.
fn response_at(y: &[f64], f: f64, dt: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (i, value) in y.iter().enumerate() {
        let (sin, cos) = (TAU * f * dt * i as f64).sin_cos();
        re += value * cos;
        im -= value * sin;
    }
    re.hypot(im)
}

#[test]
fn filters_have_the_gain_of_their_closed_form() {
    let (dt, n) = (0.01, 12_000);
    for order in [1, 2, 3, 4, 7, 10] {
        for (f_min, f_max) in
            [(Some(1.0), None), (None, Some(12.0)), (Some(0.5), Some(20.0)), (Some(4.0), Some(6.0))]
        {
            for causal in [true, false] {
                let filter = Filter { f_min, f_max, order, causal, ..Filter::default() };
                let mut impulse = vec![0.0; n];
                impulse[if causal { 0 } else { n / 2 }] = 1.0;
                let mut motion = motion_of(impulse, dt);
                Process::Filter(filter).apply(&mut motion).unwrap();
                for f in [0.3, 0.5, 1.0, 3.0, 4.0, 5.0, 6.0, 12.0, 20.0, 35.0, 49.0] {
                    let once = butterworth(&filter, f, dt);
                    let wanted = if causal { once } else { once * once };
                    let found = response_at(x_of(&motion), f, dt);
                    assert!((found - wanted).abs() < 2e-9, "{filter:?} {f} Hz: {found} against {wanted}");
                }
            }
        }
    }
    // The corners: −3.01 dB once, −6.02 dB forth and back.
    let filter = Filter { f_min: Some(2.0), f_max: Some(9.0), order: 4, ..Filter::default() };
    for corner in [2.0, 9.0] {
        assert_relative_eq!(20.0 * butterworth(&filter, corner, dt).log10(), -3.0103, epsilon = 1e-3);
    }
}

/// Against `scipy.signal` 1.18: `sosfilt(butter(order, 2*f, kind, output="sos"), x)` once, and back over the record
/// between ceil(1.5 order/f) zeros, at the samples 0, 1, 10, 50, 120, 199 of x = ((7i² + 3i) mod 23 − 11)/11.
#[test]
fn filters_agree_with_scipy() {
    let x: Vec<f64> = (0..200_i64).map(|i| (((7 * i * i + 3 * i) % 23) as f64 - 11.0) / 11.0).collect();
    type Case = (Option<f64>, Option<f64>, usize, [f64; 6], [f64; 6]);
    let cases: [Case; 4] = [
        (
            Some(0.02),
            None,
            4,
            [
                -0.848475295524359,
                0.20139564031043589,
                0.1445939293535579,
                0.21969124761947,
                -0.04165078903169145,
                -0.04533705187990017,
            ],
            [
                -0.9397111533577815,
                -0.027735457272405423,
                0.6299220361437043,
                -0.0923408076714034,
                -0.3633930112160676,
                -0.06863782541249391,
            ],
        ),
        (
            None,
            Some(0.3),
            5,
            [
                -0.10837370258747996,
                -0.44493732328449415,
                0.357191657057641,
                0.14199526723583525,
                -0.6710627184256954,
                -0.2270141890178527,
            ],
            [
                -0.6098289478854796,
                -0.32491363722967137,
                0.49083606526287343,
                -0.6652595965643137,
                -0.10046284363651717,
                -0.026071995223825407,
            ],
        ),
        (
            Some(0.01),
            Some(0.4),
            4,
            [
                -0.3965011836278851,
                -0.6210221486708692,
                0.6991538283174786,
                -0.3699978211660301,
                0.11653355069195778,
                -0.056014155308117056,
            ],
            [
                -0.8383455737147343,
                -0.07126824761208794,
                0.5901165509537134,
                -0.21737720409229122,
                -0.27483561454989486,
                0.09635080532410367,
            ],
        ),
        (
            Some(0.1),
            Some(0.15),
            3,
            [
                -0.0028981946337214323,
                -0.011414064661863564,
                -0.042952875563474276,
                0.016353002621305485,
                0.0037491679120109714,
                0.029723567942001303,
            ],
            [
                0.07803320324258399,
                0.04425779080492042,
                0.02043791760914713,
                -0.01850468587339009,
                -0.011923070536092747,
                0.11718550062989518,
            ],
        ),
    ];
    for (f_min, f_max, order, once, twice) in cases {
        for (causal, wanted) in [(true, once), (false, twice)] {
            let filter = Filter { f_min, f_max, order, causal, ..Filter::default() };
            let mut motion = motion_of(x.clone(), 1.0);
            Process::Filter(filter).apply(&mut motion).unwrap();
            for (i, wanted) in [0, 1, 10, 50, 120, 199].into_iter().zip(wanted) {
                let found = x_of(&motion)[i];
                assert!((found - wanted).abs() < 1e-11, "{filter:?} {i}: {found} against {wanted}");
            }
        }
    }
}

/// A corner 10⁵ times below the sampling rate: bounded, and right against the closed form of the step's response.
#[test]
fn a_very_low_corner_is_stable() {
    let (dt, n) = (0.005, 400_000);
    let f_min = 1e-5 / dt;
    // A second-order high-pass on a constant: exp(−ωt/√2) (cos(ωt/√2) − sin(ωt/√2)).
    let filter = Filter { f_min: Some(f_min), order: 2, causal: true, ..Filter::default() };
    let mut motion = motion_of(vec![1.0; n], dt);
    Process::Filter(filter).apply(&mut motion).unwrap();
    for i in (0..n).step_by(1000) {
        let phase = TAU * f_min * i as f64 * dt / 2_f64.sqrt();
        let wanted = (-phase).exp() * (phase.cos() - phase.sin());
        assert!((x_of(&motion)[i] - wanted).abs() < 1e-4, "{i}: {} against {wanted}", x_of(&motion)[i]);
    }
    for causal in [true, false] {
        let filter = Filter { f_min: Some(f_min), f_max: Some(80.0), order: 10, causal, keep_pads: true };
        let mut motion = motion_of(noise(100_000, 3), dt);
        Process::Filter(filter).apply(&mut motion).unwrap();
        let x = x_of(&motion);
        assert!(largest(x) < 3.0, "{}", largest(x));
        assert!(largest(&x[x.len() - 1000..]) < 1e-3, "{}", largest(&x[x.len() - 1000..]));
    }
}

#[test]
fn a_filter_forth_and_back_keeps_times_and_says_what_it_cut() {
    let (n, dt) = (4000, 0.01);
    let wave = burst(5.0, n, dt);
    let mut motion = motion_of(wave.clone(), dt);
    motion.start = Some(100.0);
    let filter = Filter { f_min: Some(0.2), f_max: Some(25.0), ..Filter::default() };
    let mut kept = motion.clone();
    Process::Filter(filter).apply(&mut motion).unwrap();
    assert_close(x_of(&motion), &wave, 1e-4);
    assert_eq!((motion.len(), motion.start), (n, Some(100.0)));
    let found = &motion.steps[0].found;
    assert_eq!((&found["passes"], &found["zeros_before_s"]), (&2.into(), &30.0.into()));
    assert!(found["x"]["cut_peak_m_s2"].as_f64().unwrap() < 1e-4);
    Process::Filter(Filter { keep_pads: true, ..filter }).apply(&mut kept).unwrap();
    assert_eq!((kept.len(), kept.start), (n + 6000, Some(70.0)));
    assert_eq!(&x_of(&kept)[3000..3000 + n], x_of(&motion));
    // A high-pass with its pads leaves the ground at rest, without them it need not.
    let velocity = integrate(x_of(&kept), dt);
    assert!(velocity[velocity.len() - 1].abs() < 1e-6 * largest(&velocity));
}

#[test]
fn filters_refuse_what_has_no_meaning() {
    let motion = motion_of(noise(500, 1), 0.01);
    let filter = |f_min, f_max, order| Process::Filter(Filter { f_min, f_max, order, ..Filter::default() });
    refused(&filter(None, None, 4), &motion, &["filter: no corner", "help: give f_min, f_max or both"]);
    for bad in [0.0, -1.0, 50.0, 60.0, f64::NAN] {
        refused(&filter(Some(bad), None, 4), &motion, &["filter: f_min", "Nyquist frequency 50 Hz"]);
        refused(&filter(None, Some(bad), 4), &motion, &["filter: f_max", "Nyquist frequency 50 Hz"]);
    }
    refused(&filter(Some(5.0), Some(5.0), 4), &motion, &["f_min = 5; expected below f_max = 5 Hz"]);
    for order in [0, 11] {
        refused(&filter(Some(5.0), None, order), &motion, &["filter: order", "1 to 10"]);
    }
    refused(
        &filter(Some(1e-9), None, 4),
        &motion,
        &["f_min = 1e-9", "at least 3.576e-5 Hz", "zeros would be too many", "help: raise"],
    );
}
