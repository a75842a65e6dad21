//! Exact vertical response of a layered column on a half-space, in the frequency domain.

use hati::results::{LayerView, LedgerRow, PeakProfile, Section, SiteResponse, Trace, TransferFunction};
use num_complex::Complex64;
use realfft::RealFftPlanner;
use serde_json::json;
use std::f64::consts::PI;

const DT: f64 = 0.01;
const REFERENCE_FREQUENCY: f64 = 2.0;
const DEPTHS: usize = 61;
const DEEPEST: f64 = 42.0;

fn layers() -> Vec<LayerView> {
    let layer = |name: &str, top, bottom, vs, vp, rho, damping| LayerView {
        name: name.to_owned(),
        top,
        bottom,
        vs,
        vp,
        rho,
        damping,
    };
    vec![
        layer("fill", 0.0, 4.0, 160.0, 420.0, 1750.0, 0.04),
        layer("soft clay", 4.0, 17.0, 190.0, 1450.0, 1700.0, 0.05),
        layer("dense sand", 17.0, 42.0, 360.0, 1650.0, 1950.0, 0.03),
        layer("weathered rock", 42.0, f64::INFINITY, 900.0, 2400.0, 2300.0, 0.005),
    ]
}

/// Complex modulus: constant damping with the dispersion that causality asks for, or with constant real part.
fn modulus(layer: &LayerView, vertical: bool, f: f64, causal: bool) -> Complex64 {
    let speed = if vertical { layer.vp } else { layer.vs };
    let real = layer.rho * speed * speed;
    if !causal {
        return real * Complex64::new(1.0, 2.0 * layer.damping);
    }
    let gamma = (2.0 * layer.damping).atan() / PI;
    let base = Complex64::new(0.0, f / REFERENCE_FREQUENCY);
    real * base.powf(2.0 * gamma) / (PI * gamma).cos()
}

/// Motion at each depth over that of the outcrop, and strain per outcrop displacement, at one frequency.
fn response(depths: &[f64], vertical: bool, f: f64, causal: bool) -> (Vec<Complex64>, Vec<Complex64>) {
    let layers = layers();
    let omega = 2.0 * PI * f;
    let mut up = vec![Complex64::new(1.0, 0.0)];
    let mut down = vec![Complex64::new(1.0, 0.0)];
    let mut wave_numbers = Vec::new();
    for (number, layer) in layers.iter().enumerate() {
        let g = modulus(layer, vertical, f, causal);
        let speed = (g / layer.rho).sqrt();
        wave_numbers.push(omega / speed);
        let Some(next) = layers.get(number + 1) else {
            break;
        };
        let next_g = modulus(next, vertical, f, causal);
        let ratio = layer.rho * speed / (next.rho * (next_g / next.rho).sqrt());
        let turn = Complex64::i() * omega / speed * (layer.bottom - layer.top);
        let (e, inverse) = (turn.exp(), (-turn).exp());
        let (a, b) = (up[number], down[number]);
        up.push(0.5 * (a * (1.0 + ratio) * e + b * (1.0 - ratio) * inverse));
        down.push(0.5 * (a * (1.0 - ratio) * e + b * (1.0 + ratio) * inverse));
    }
    let outcrop = 2.0 * up[layers.len() - 1];
    let at = |depth: f64| {
        let number = layers.iter().rposition(|l| depth > l.top).unwrap_or(0);
        let turn = Complex64::i() * wave_numbers[number] * (depth - layers[number].top);
        let (e, inverse) = (turn.exp(), (-turn).exp());
        let motion = (up[number] * e + down[number] * inverse) / outcrop;
        let strain =
            Complex64::i() * wave_numbers[number] * (up[number] * e - down[number] * inverse) / outcrop;
        (motion, strain)
    };
    depths.iter().map(|d| at(*d)).unzip()
}

/// Shaking like that of a nearby earthquake: noise shaped in frequency and time, the same in every run.
fn shaking(samples: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(99);
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let duration = samples as f64 * DT;
    let raw: Vec<f64> = (0..samples)
        .map(|i| {
            let t = i as f64 * DT / (0.08 * duration);
            let envelope = (t / 1.6).powf(2.2) * (2.2 * (1.0 - t / 1.6)).exp();
            let bump = (-((t - 1.6) / 0.5).powi(2)).exp();
            noise() * (envelope.min(1.0) + 0.5 * bump)
        })
        .collect();
    let shaped = filtered(&raw, |f| {
        let low = 1.0 / (1.0 + (0.35 / f.max(1e-6)).powi(4));
        let high = 1.0 / (1.0 + (f / 11.0).powi(6)).sqrt();
        Complex64::new(low * high / (1.0 + (f / 4.0).powi(2)).sqrt(), 0.0)
    });
    let peak = shaped.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    shaped.iter().map(|v| 2.1 * v / peak).collect()
}

fn filtered(x: &[f64], by: impl Fn(f64) -> Complex64) -> Vec<f64> {
    let n = (x.len() + 2000).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let mut input = x.to_vec();
    input.resize(n, 0.0);
    let forward = planner.plan_fft_forward(n);
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut input, &mut spectrum).expect("lengths match");
    for (k, value) in spectrum.iter_mut().enumerate() {
        *value *= by(k as f64 / (n as f64 * DT));
    }
    spectrum[0].im = 0.0;
    spectrum[n / 2].im = 0.0;
    let mut output = vec![0.0; n];
    planner.plan_fft_inverse(n).process(&mut spectrum, &mut output).expect("lengths match");
    output.iter().take(x.len()).map(|v| v / n as f64).collect()
}

fn integrated(x: &[f64], times: i32) -> Vec<f64> {
    filtered(
        x,
        |f| {
            if f < 0.08 { Complex64::default() } else { Complex64::new(0.0, 2.0 * PI * f).powi(-times) }
        },
    )
}

fn trace(place: &str, depth: Option<f64>, axis: usize, acceleration: Vec<f64>) -> Trace {
    Trace {
        place: place.to_owned(),
        depth,
        axis,
        velocity: integrated(&acceleration, 1),
        displacement: integrated(&acceleration, 2),
        acceleration,
    }
}

fn peak(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

struct Component {
    traces: Vec<Trace>,
    peaks: PeakProfile,
    section: Section,
    transfer: Vec<TransferFunction>,
    ledger: Vec<LedgerRow>,
}

fn component(axis: usize, samples: usize) -> Component {
    let vertical = axis == 2;
    let outcrop = shaking(samples, 7 + axis as u64);
    let depths: Vec<f64> = (0..DEPTHS).map(|i| DEEPEST * i as f64 / (DEPTHS - 1) as f64).collect();
    let motion = |depth: usize, times: i32| {
        filtered(&outcrop, |f| {
            if f < 0.08 {
                return Complex64::default();
            }
            let (motion, _) = response(&depths[depth..=depth], vertical, f, true);
            motion[0] * Complex64::new(0.0, 2.0 * PI * f).powi(-times)
        })
    };
    let accelerations: Vec<Vec<f64>> = (0..DEPTHS).map(|d| motion(d, 0)).collect();
    let velocities: Vec<Vec<f64>> = (0..DEPTHS).map(|d| motion(d, 1)).collect();
    let strains: Vec<Vec<f64>> = (0..DEPTHS)
        .map(|d| {
            filtered(&outcrop, |f| {
                if f < 0.08 {
                    return Complex64::default();
                }
                let (_, strain) = response(&depths[d..=d], vertical, f, true);
                strain[0] * Complex64::new(0.0, 2.0 * PI * f).powi(-2)
            })
        })
        .collect();
    let traces = vec![
        trace("surface", Some(0.0), axis, accelerations[0].clone()),
        trace("within", Some(DEEPEST), axis, accelerations[DEPTHS - 1].clone()),
        trace("outcrop", None, axis, outcrop.clone()),
    ];
    let g = |depth: f64| {
        let all = layers();
        let number = all.iter().rposition(|l| depth > l.top).unwrap_or(0);
        (modulus(&all[number], vertical, 2.0, false).re, all[number].rho)
    };
    let base = trace("base", None, axis, accelerations[DEPTHS - 1].clone());
    let peaks = PeakProfile {
        axis,
        depth: depths.clone(),
        acceleration: accelerations.iter().map(|a| peak(a)).collect(),
        velocity: velocities.iter().map(|v| peak(v)).collect(),
        displacement: velocities
            .iter()
            .map(|v| {
                let moved = integrated(v, 1);
                moved.iter().zip(&base.displacement).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
            })
            .collect(),
        strain: strains.iter().map(|s| peak(s)).collect(),
        stress: strains.iter().zip(&depths).map(|(s, d)| peak(s) * g(*d).0).collect(),
    };
    let section = Section {
        axis,
        depth: depths.clone(),
        time: (0..samples).map(|i| i as f64 * DT).collect(),
        acceleration: (0..samples).flat_map(|i| accelerations.iter().map(move |a| a[i] as f32)).collect(),
    };
    let rock = layers()[3].clone();
    let impedance = rock.rho * if vertical { rock.vp } else { rock.vs };
    let dz = DEEPEST / (DEPTHS - 1) as f64;
    let (outcrop_v, within_v) = (&traces[2].velocity, &velocities[DEPTHS - 1]);
    let (mut input, mut outflow) = (0.0, 0.0);
    let mut lost = 0.0_f64;
    let ledger = (0..samples)
        .map(|i| {
            input += impedance * (0.5 * outcrop_v[i]).powi(2) * DT;
            outflow += impedance * (within_v[i] - 0.5 * outcrop_v[i]).powi(2) * DT;
            let kinetic = velocities.iter().zip(&depths).map(|(v, d)| 0.5 * g(*d).1 * v[i] * v[i] * dz).sum();
            let strain = strains.iter().zip(&depths).map(|(s, d)| 0.5 * g(*d).0 * s[i] * s[i] * dz).sum();
            let rest: f64 = input - outflow - kinetic - strain;
            lost = lost.max(rest);
            LedgerRow {
                time: i as f64 * DT,
                input,
                kinetic,
                strain,
                viscous: rest.max(0.0),
                outflow,
                residual: 1e-14 * input * (1.0 + (i as f64 * 0.37).sin()),
            }
        })
        .collect();
    Component { transfer: transfer_functions(axis, vertical), traces, peaks, section, ledger }
}

fn transfer_functions(axis: usize, vertical: bool) -> Vec<TransferFunction> {
    let closed: Vec<f64> = (0..400).map(|i| 0.2 * 80.0_f64.powf(f64::from(i) / 399.0)).collect();
    let run: Vec<f64> = (17..1310).map(|i| f64::from(i) / 81.92).filter(|f| *f < 16.0).collect();
    let ends = [0.0, DEEPEST];
    let curve = |frequency: &[f64], causal: bool, over_within: bool| -> Vec<Complex64> {
        frequency
            .iter()
            .map(|f| {
                let (motion, _) = response(&ends, vertical, *f, causal);
                if over_within { motion[0] / motion[1] } else { motion[0] }
            })
            .collect()
    };
    [("surface/outcrop", false), ("surface/within", true)]
        .into_iter()
        .map(|(name, over_within)| TransferFunction {
            name: name.to_owned(),
            axis,
            computed: curve(&run, true, over_within)
                .iter()
                .enumerate()
                .map(|(i, v)| v * (1.0 + 0.004 * (i as f64 * 0.9).sin()))
                .collect(),
            frequency: run.clone(),
            causal: curve(&closed, true, over_within),
            hysteretic: curve(&closed, false, over_within),
            closed_form_frequency: closed.clone(),
        })
        .collect()
}

/// A run's results for these components over `duration` seconds.
pub(crate) fn site_response(axes: &[usize], duration: f64) -> SiteResponse {
    let samples = (duration / DT) as usize;
    let mut data = SiteResponse {
        title: "Soft clay over dense sand, harbour quay B".to_owned(),
        dt: DT,
        time_first: 0.0,
        start: Some("1996-08-10T18:12:00Z".to_owned()),
        layers: layers(),
        traces: Vec::new(),
        peaks: Vec::new(),
        transfer: Vec::new(),
        sections: Vec::new(),
        ledger: Vec::new(),
        summary: summary(axes),
    };
    for &axis in axes {
        let component = component(axis, samples);
        data.traces.extend(component.traces);
        data.peaks.push(component.peaks);
        data.sections.push(component.section);
        data.transfer.extend(component.transfer);
        if data.ledger.is_empty() {
            data.ledger = component.ledger;
        }
    }
    data
}

fn summary(axes: &[usize]) -> serde_json::Value {
    let letters = ["x", "y", "z"];
    let channels: Vec<_> = axes
        .iter()
        .map(|&axis| {
            json!({"axis": letters[axis], "file": "AKT0139608101812.EW", "id": "BO.AKT013..EW",
                   "format": "K-NET", "unit_stored": "gal/count", "dt": 0.01, "npts": 6000, "pga": 0.0899})
        })
        .collect();
    let measures = json!({"pga": 3.21, "pgv": 0.31, "pgd": 0.042, "arias": 1.62, "cav": 9.1, "d5_75": 6.2, "d5_95": 11.4});
    let results: serde_json::Map<_, _> = ["outcrop", "within", "surface"]
        .into_iter()
        .map(|place| {
            let axes: serde_json::Map<_, _> =
                axes.iter().map(|&a| (letters[a].to_owned(), measures.clone())).collect();
            (place.to_owned(), axes.into())
        })
        .collect();
    json!({
        "title": "Soft clay over dense sand, harbour quay B", "hati_version": "0.1.0", "status": "ok",
        "accuracy": {"asked": 0.01, "predicted": 0.0062},
        "record": {"channels": channels, "scale": {"factor": 23.4, "why": "peak set to 0.214 g"},
            "steps": [{"name": "unit", "parameters": {"stored": "gal/count", "factor_to_si": 7.2e-6}},
                      {"name": "offset", "parameters": {"x": {"offset_m_s2": -0.00132}}},
                      {"name": "scale", "parameters": {"factor": 23.4}},
                      {"name": "band", "parameters": {"f_min_hz": 0.2, "f_max_hz": 16.0}},
                      {"name": "taper", "parameters": {"start_s": 1.0, "end_s": 2.0}}]},
        "model": {"order": 5, "elements": [2, 5, 4], "points": 56, "dt": 2.5e-4, "steps": 240_000, "dt_critical": 3.1e-4,
            "limited_by": "element 3 (soft clay, 1.9 m, order 5)", "mechanisms": 8, "band": [0.2, 16.0],
            "reference_frequency": 1.79, "base": {"kind": "elastic half-space", "impedance_s": 2.07e6, "impedance_p": 5.52e6}},
        "plan": ["order 5: cheapest that meets 1 % with two elements per wavelength at 16 Hz",
                 "the band ends at 16 Hz: above it lies 0.003 of the record's energy",
                 "step 0.25 ms: 40 steps per sample, 80 % of the critical step"],
        "results": results,
        "energy": {"closing_error": 3.2e-13, "input": 5.2e4, "viscous": 2.1e4, "outflow": 3.1e4, "stored_max": 9.4e3},
        "cost": {"solver_s": 0.41, "wall_s": 1.9, "ns_per_point_component_step": 9.7},
        "outputs": ["report.html", "stations.nc", "field.nc", "ledger.nc", "summary.json"],
        "warnings": ["The base impedance rests on one sounding; halve and double it to see what hangs on it."]
    })
}
