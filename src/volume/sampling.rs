//! When things are looked at: the step, the samples of it, the rows of the files.

use super::sizes::Frequencies;

/// Samples per period of the highest frequency at which stations and peaks are taken, at least.
pub const SAMPLES_PER_PERIOD: f64 = 20.0;
/// Rows need no filter where their Nyquist frequency is this many times the highest frequency, or more.
const CLEAN: f64 = 1.25;

/// The step and the instants of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Step, s.
    pub dt: f64,
    /// Steps from one sample to the next.
    pub stride: usize,
    /// Samples, the first at t = 0.
    pub samples: usize,
}

impl Sampling {
    /// Samples at every so many steps that they stand no farther apart than 1/(20 `highest`) and that rows every `rows`
    /// seconds (the closest asked for) fall on samples where they fall on steps; `highest`: the highest frequency of the
    /// motion, Hz ([`Frequencies::content`]).
    pub fn new(dt: f64, highest: f64, rows: Option<f64>, duration: f64) -> Self {
        let most = ((1.0 / (SAMPLES_PER_PERIOD * highest) / dt * (1.0 + 1e-9)) as usize).max(1);
        let whole = rows.map(|t| (t / dt).round()).filter(|n| *n >= 1.0);
        let fits = rows.zip(whole).is_some_and(|(t, n)| (t / dt - n).abs() < 1e-6);
        let stride = match whole {
            Some(n) if fits => (1..=most).rev().find(|s| (n as usize).is_multiple_of(*s)).unwrap_or(1),
            _ => most,
        };
        let samples = (duration / (stride as f64 * dt) * (1.0 - 1e-9)).ceil() as usize + 1;
        Self { dt, stride, samples }
    }

    /// Time between samples, s.
    pub fn sample_dt(&self) -> f64 {
        self.stride as f64 * self.dt
    }

    /// Steps of the run: one after the last sample's kick.
    pub fn steps(&self) -> u64 {
        (self.samples as u64 - 1).saturating_mul(self.stride as u64).saturating_add(1)
    }

    /// How rows every `dt_out` seconds are made of samples, whose motion goes up to `highest` Hz.
    pub fn rows(&self, dt_out: f64, highest: f64) -> Rows {
        let ratio = dt_out / self.sample_dt();
        let whole = ratio.round();
        let on_samples = whole >= 1.0 && (ratio - whole).abs() < 1e-6 * whole;
        if on_samples && 0.5 / dt_out >= CLEAN * highest {
            Rows::Picked { every: whole as usize }
        } else if ratio < 1.0 {
            Rows::Picked { every: 1 }
        } else {
            Rows::Filtered { dt: dt_out }
        }
    }
}

/// How rows are made of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rows {
    /// Every so many samples as they are: nothing of the motion lies above the rows' Nyquist frequency.
    Picked {
        /// Samples from one row to the next.
        every: usize,
    },
    /// Low-passed ([`crate::outputs::decimate::Decimator`]).
    Filtered {
        /// Time between rows, s.
        dt: f64,
    },
}

impl Rows {
    /// Time between rows, s.
    pub fn dt(&self, sampling: &Sampling) -> f64 {
        match *self {
            Self::Picked { every } => every as f64 * sampling.sample_dt(),
            Self::Filtered { dt } => dt,
        }
    }

    /// How far a row sees ahead and back, s: 0 for samples as they are.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Picked { .. } => 0.0,
            Self::Filtered { dt } => crate::outputs::decimate::HALF * dt,
        }
    }

    /// Rows of a run, about.
    pub fn count(&self, sampling: &Sampling) -> usize {
        let end = (sampling.samples - 1) as f64 * sampling.sample_dt();
        (end / self.dt(sampling) * (1.0 + 1e-9)) as usize + 1
    }
}

/// A step not above `most` that divides the rows' time, where they are farther apart than it.
pub fn step_for(most: f64, rows: Option<f64>) -> f64 {
    match rows.filter(|t| *t >= most) {
        Some(t) => t / (t / most * (1.0 - 1e-9)).ceil(),
        None => most,
    }
}

/// Time between rows where the scene leaves it open: four per period of the highest frequency, which keeps a margin of
/// 1.6 to what a reader of rows may trust.
pub fn auto_rows(frequencies: &Frequencies) -> f64 {
    0.25 / frequencies.f_max
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_fall_on_samples_and_samples_on_steps() {
        let dt = step_for(7e-4, Some(0.01));
        assert!((0.01 / dt - 15.0).abs() < 1e-9, "{dt}");
        let sampling = Sampling::new(dt, 20.0, Some(0.01), 0.5);
        assert_eq!(sampling.stride, 3, "15 steps a row, at most 3.7 a sample");
        assert_eq!((sampling.samples, sampling.steps()), (251, 751));
        assert_eq!(sampling.rows(0.01, 20.0), Rows::Picked { every: 5 });
        assert_eq!(sampling.rows(0.01, 45.0), Rows::Filtered { dt: 0.01 });
        assert_eq!(sampling.rows(0.0123, 20.0), Rows::Filtered { dt: 0.0123 });
        assert_eq!(sampling.rows(1e-4, 20.0), Rows::Picked { every: 1 });
        assert_eq!(sampling.rows(0.01, 20.0).count(&sampling), 51);
    }

    #[test]
    fn rows_are_filtered_where_the_sources_reach_beyond_their_nyquist_frequency() {
        let given = |of_sources| Frequencies { f_max: 5.0, f_half: 5.0, reference: 1.0, of_sources };
        let rows = |frequencies: &Frequencies| {
            let sampling = Sampling::new(1e-3, frequencies.content(), Some(0.05), 1.0);
            assert!(sampling.sample_dt() * SAMPLES_PER_PERIOD * frequencies.content() < 1.0 + 1e-9);
            sampling.rows(0.05, frequencies.content())
        };
        // rows of 0.05 s hold 8 Hz with the margin of 1.25
        assert!(matches!(rows(&given(7.9)), Rows::Picked { .. }));
        let filtered = rows(&given(8.1));
        assert_eq!(filtered, Rows::Filtered { dt: 0.05 });
        assert_eq!(rows(&given(3.0)).reach(), 0.0);
        assert!((filtered.reach() - 0.55).abs() < 1e-12);
    }

    #[test]
    fn a_run_without_rows_samples_as_it_likes() {
        let sampling = Sampling::new(1e-3, 5.0, None, 1.0);
        assert_eq!((sampling.stride, sampling.samples), (10, 101));
        assert_eq!(step_for(1e-3, None), 1e-3);
        assert_eq!(step_for(1e-3, Some(5e-4)), 1e-3);
        assert_eq!(Sampling::new(0.1, 5.0, None, 1.0).stride, 1);
    }
}
