//! Sources and their time functions at the kicks; [`super::forces`] tells what they push.

use crate::plan::PlanError;
use hati_inputs::motion::{Quantity, resample_as};
use hati_inputs::records::{self, Channel, ReadOptions};
use hati_inputs::scene::{Action, Pulse, PulseKind, Scene, SourceTerm, TimeFunction};

/// A source with its record read.
#[derive(Debug, Clone)]
pub struct Signal {
    /// Name in messages.
    pub name: String,
    /// What acts where.
    pub action: Action,
    /// Its time function.
    pub time: TimeFunction,
    /// The record, where the time function is one.
    pub record: Option<Channel>,
}

/// Reads the sources of a scene; Python is started once, and only for records.
pub fn signals(scene: &Scene) -> Result<Vec<Signal>, PlanError> {
    let terms = scene.sources();
    let wanted = |t: &SourceTerm| match &t.time {
        TimeFunction::Record { record, .. } => Some(record.clone()),
        TimeFunction::Pulse(_) => None,
    };
    let sources: Vec<records::Source> = terms.iter().filter_map(wanted).collect();
    let options = ReadOptions {
        quantity: Some(Quantity::Acceleration),
        accept_clipped: true,
        ..ReadOptions::default()
    };
    let read = if sources.is_empty() { vec![] } else { records::read_many(&sources, &options)? };
    let mut channels = vec![];
    for (found, source) in read.into_iter().zip(&sources) {
        channels.push(records::choose(found, source, 0)?);
    }
    let mut channels = channels.into_iter();
    let signal = |t: SourceTerm| {
        let record = if matches!(t.time, TimeFunction::Record { .. }) { channels.next() } else { None };
        Signal { name: t.name, action: t.action, time: t.time, record }
    };
    Ok(terms.into_iter().map(signal).collect())
}

/// For each signal the first one with the same amplitude at every instant: signals of one number share one array.
pub fn shared_amplitudes(signals: &[Signal]) -> Vec<usize> {
    let first = |s: &Signal| {
        signals.iter().position(|other| other.time == s.time && other.is_rate() == s.is_rate()).unwrap_or(0)
    };
    signals.iter().map(first).collect()
}

impl Signal {
    /// Whether the time function is the rate of what acts.
    fn is_rate(&self) -> bool {
        matches!(self.action, Action::Moment { rate: true, .. })
    }

    /// Amplitude at the kicks t = n `dt`, `count` of them; a moment's rate is integrated.
    pub fn amplitude(&self, dt: f64, count: usize) -> Vec<f64> {
        let integrate = self.is_rate();
        match (&self.time, &self.record) {
            (TimeFunction::Pulse(pulse), _) if integrate => integral(pulse, dt, count),
            (TimeFunction::Pulse(pulse), _) => (0..count).map(|n| pulse.value(n as f64 * dt)).collect(),
            (TimeFunction::Record { amplitude, .. }, Some(record)) => {
                of_record(record, *amplitude, integrate, dt, count)
            }
            (TimeFunction::Record { .. }, None) => vec![0.0; count],
        }
    }
}

/// Integral of a pulse from before its start: a Gaussian's is a ramp; others by Simpson's rule, eight intervals a step.
fn integral(pulse: &Pulse, dt: f64, count: usize) -> Vec<f64> {
    if pulse.kind == PulseKind::Gaussian {
        let area = pulse.amplitude / (pulse.frequency * std::f64::consts::PI.sqrt());
        let ramp = Pulse { kind: PulseKind::Ramp, amplitude: area, ..*pulse };
        return (0..count).map(|n| ramp.value(n as f64 * dt)).collect();
    }
    // what the pulse had before t = 0, where it does not begin with zero, is part of it; a ramp never began
    let fine = dt / 8.0;
    let before = if pulse.kind == PulseKind::Ramp { 0.0 } else { (1.5 * pulse.half_width() / fine).ceil() };
    let panel =
        |t: f64| fine / 6.0 * (pulse.value(t) + 4.0 * pulse.value(t + 0.5 * fine) + pulse.value(t + fine));
    let mut sum: f64 = (1..=before as usize).map(|i| panel(-(i as f64) * fine)).sum();
    let mut values = Vec::with_capacity(count);
    for n in 0..count {
        values.push(sum);
        sum += (0..8).map(|i| panel((8 * n + i) as f64 * fine)).sum::<f64>();
    }
    values
}

/// A record at the kicks: band-limited between its samples, 0 outside.
fn of_record(record: &Channel, amplitude: f64, integrate: bool, dt: f64, count: usize) -> Vec<f64> {
    let largest = record.samples.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let scale = if largest > 0.0 { amplitude.abs() / largest * amplitude.signum() } else { 0.0 };
    // fine enough that the cubic between two instants is within 1e-6 of a record that ends at half its Nyquist frequency
    let k = ((16.0 * record.dt / dt).ceil() as usize).clamp(16, 4096) / 16 * 16;
    let k = k.min((1 << 26) / record.samples.len().max(1)).max(1);
    let to = if integrate { Quantity::Velocity } else { Quantity::Acceleration };
    let fine = resample_as(&record.samples, record.dt, Quantity::Acceleration, to, k);
    let step = record.dt / k as f64;
    let last = fine.last().copied().unwrap_or(0.0);
    let value = |t: f64| {
        let place = t / step;
        let i = place as usize;
        if i + 1 >= fine.len() {
            // an integral keeps its value when the rate has ended
            return if integrate || place <= (fine.len() - 1) as f64 { last } else { 0.0 };
        }
        cubic(&fine, i, place - i as f64)
    };
    (0..count).map(|n| scale * value(n as f64 * dt)).collect()
}

/// Cubic through four neighbours, held at the ends.
fn cubic(x: &[f64], i: usize, s: f64) -> f64 {
    let at = |k: usize| x[(i + k).saturating_sub(1).min(x.len() - 1)];
    let (a, b, c, d) = (at(0), at(1), at(2), at(3));
    b + 0.5 * s * (c - a + s * (2.0 * a - 5.0 * b + 4.0 * c - d + s * (3.0 * (b - c) + d - a)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pulse(kind: PulseKind) -> Pulse {
        let cycles = (kind == PulseKind::SineBurst).then_some(3.0);
        Pulse { kind, frequency: 2.0, amplitude: 3.0, time: 1.0, cycles }
    }

    #[test]
    fn a_rates_integral_has_the_rate_as_its_slope() {
        let (dt, count) = (2e-3, 1000);
        for kind in [PulseKind::Ricker, PulseKind::Gaussian, PulseKind::SineBurst, PulseKind::Ramp] {
            let p = pulse(kind);
            let x = integral(&p, dt, count);
            for n in (1..count - 1).step_by(37) {
                let slope = (x[n + 1] - x[n - 1]) / (2.0 * dt);
                let error = (slope - p.value(n as f64 * dt)).abs();
                assert!(error < 3e-3, "{kind:?} at {n}: {error:e}");
            }
        }
        assert!(
            integral(&pulse(PulseKind::Ricker), dt, count)[999].abs() < 1e-6,
            "a Ricker's integral ends at 0"
        );
    }

    #[test]
    fn a_record_is_scaled_and_interpolated() {
        let dt = 0.01;
        let wave = |t: f64| (-(8.0 * (t - 1.0)).powi(2)).exp() * (40.0 * t).sin();
        let record = Channel {
            id: "a".into(),
            file: "a".into(),
            format: "SAC",
            start: None,
            dt,
            samples: (0..201).map(|i| 7.0 * wave(f64::from(i) * dt)).collect(),
            quantity: Quantity::Acceleration,
            unit_stored: String::new(),
            axis_hint: None,
            steps: vec![],
            sha256: String::new(),
        };
        let peak = (0..201).map(|i| wave(f64::from(i) * dt).abs()).fold(0.0, f64::max);
        let found = of_record(&record, -2.0, false, 0.0033, 700);
        for (n, x) in found.iter().enumerate() {
            let t = n as f64 * 0.0033;
            let expected = if t <= 2.0 { -2.0 * wave(t) / peak } else { 0.0 };
            assert!((x - expected).abs() < 1e-4, "{t}: {x} against {expected}");
        }
    }
}
