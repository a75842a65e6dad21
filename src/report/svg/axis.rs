//! Axes: range, ticks and the map from value to pixel.

use super::number::{log_tick, tick};

/// One axis of a panel.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    /// Value at the start.
    pub(crate) min: f64,
    /// Value at the end.
    pub(crate) max: f64,
    /// Logarithmic.
    pub(crate) log: bool,
    /// Quantity and unit.
    pub(crate) label: String,
    /// Places of the labelled ticks with their text.
    pub(crate) ticks: Vec<(f64, String)>,
    /// Places of the fine grid lines.
    pub(super) minor: Vec<f64>,
}

impl Axis {
    /// Linear axis over exactly `[min, max]`, with about `count` steps of 1, 2 or 5 times a power of ten.
    pub(crate) fn linear(min: f64, max: f64, label: &str, count: usize) -> Self {
        let (min, max) = sound_range(min, max);
        let step = nice_step(max - min, count.max(1) as f64);
        let first = (min / step - 1e-9).ceil() as i64;
        let last = (max / step + 1e-9).floor() as i64;
        let ticks = (first..=last.min(first + 100))
            .map(|k| {
                let value = k as f64 * step;
                (value, tick(value, step))
            })
            .collect();
        Self { min, max, log: false, label: label.to_owned(), ticks, minor: Vec::new() }
    }

    /// Linear axis from 0 to a tick at or above `max` with some air.
    pub(crate) fn from_zero(max: f64, label: &str, count: usize) -> Self {
        let max = if max.is_finite() && max > 0.0 { max * 1.06 } else { 1.0 };
        Self::linear(0.0, max, label, count)
    }

    /// Linear axis symmetric about 0.
    pub(crate) fn symmetric(peak: f64, label: &str, count: usize) -> Self {
        let peak = if peak.is_finite() && peak > 0.0 { peak * 1.1 } else { 1.0 };
        Self::linear(-peak, peak, label, count)
    }

    /// Logarithmic axis; 2 and 5 are labelled where it spans two decades or less.
    pub(crate) fn log(min: f64, max: f64, label: &str) -> Self {
        let sound = min.is_finite() && max.is_finite() && min > 0.0 && max > min * 1.01;
        let (min, max) = if sound { (min, max) } else { (0.1, 10.0) };
        let decades = (max / min).log10();
        let stride = (decades / 9.0).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        let mut minor = Vec::new();
        for exponent in min.log10().floor() as i32..=max.log10().ceil() as i32 {
            for lead in 1..10 {
                let value = f64::from(lead) * 10_f64.powi(exponent);
                if value < min * (1.0 - 1e-9) || value > max * (1.0 + 1e-9) {
                    continue;
                }
                let labelled = (lead == 1 && exponent.rem_euclid(stride) == 0)
                    || (decades <= 2.05 && (lead == 2 || lead == 5));
                if labelled {
                    ticks.push((value, log_tick(value)));
                } else if stride == 1 {
                    minor.push(value);
                }
            }
        }
        Self { min, max, log: true, label: label.to_owned(), ticks, minor }
    }

    /// The same axis running the other way (depth grows downwards).
    pub(crate) fn reversed(mut self) -> Self {
        std::mem::swap(&mut self.min, &mut self.max);
        self
    }

    /// The same axis with ticks at these values.
    pub(crate) fn with_ticks(mut self, values: &[f64]) -> Self {
        let step = match values {
            [a, b, ..] => (b - a).abs(),
            _ => 1.0,
        };
        self.ticks = values.iter().map(|&v| (v, tick(v, step))).collect();
        self.minor.clear();
        self
    }

    /// Position of `value`, 0 at the start and 1 at the end; not finite where the axis has no such place.
    pub(crate) fn fraction(&self, value: f64) -> f64 {
        if self.log {
            (value / self.min).ln() / (self.max / self.min).ln()
        } else {
            (value - self.min) / (self.max - self.min)
        }
    }

    /// Smaller end.
    pub(crate) fn low(&self) -> f64 {
        self.min.min(self.max)
    }

    /// Larger end.
    pub(crate) fn high(&self) -> f64 {
        self.min.max(self.max)
    }
}

fn sound_range(min: f64, max: f64) -> (f64, f64) {
    if min.is_finite() && max.is_finite() && max > min && (max - min).is_finite() {
        (min, max)
    } else if min.is_finite() && min.abs() < 1e300 {
        (min, min + min.abs().max(1.0))
    } else {
        (0.0, 1.0)
    }
}

/// Step of 1, 2 or 5 times a power of ten that divides `range` into a number of parts closest to `count`.
fn nice_step(range: f64, count: f64) -> f64 {
    let power = 10_f64.powf((range / count).log10().floor());
    let misfit = |step: f64| (range / step / count).ln().abs();
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|lead| lead * power)
        .min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)))
        .unwrap_or(range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_one_two_five() {
        for (range, count, nice) in
            [(1.1, 10.0, 0.1), (8.4, 4.0, 2.0), (954.0, 4.0, 200.0), (60.0, 12.0, 5.0)]
        {
            assert!((nice_step(range, count) / nice - 1.0).abs() < 1e-12, "{range}");
        }
    }

    #[test]
    fn log_axis_labels_decades() {
        let axis = Axis::log(0.01, 10.0, "period");
        let labels: Vec<&str> = axis.ticks.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10"]);
        assert!((axis.fraction(0.1) - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn unsound_ranges_still_give_axes() {
        for (min, max) in [(f64::NAN, 1.0), (1.0, 1.0), (0.0, f64::INFINITY), (3.0, -1.0)] {
            let axis = Axis::linear(min, max, "x", 5);
            assert!(axis.max > axis.min && !axis.ticks.is_empty());
            let axis = Axis::log(min, max, "x");
            assert!(axis.max > axis.min && axis.min > 0.0);
        }
    }
}
