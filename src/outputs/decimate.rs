//! Rows on a schedule of their own from samples at the solver's step, without aliases.
//!
//! A row at $t_k = k\,T$ is the samples' running mean
//! $$ y_k = \frac{\sum_n h(t_n - t_k)\, x_n}{\sum_n h(t_n - t_k)}, \qquad
//!    h(\tau) = \operatorname{sinc}(\tau/T)\; \frac{I_0\!\big(\beta\sqrt{1-(\tau/H)^2}\big)}{I_0(\beta)}, \quad |\tau| < H, $$
//! a low-pass of linear phase (symmetric about the row) with the output's Nyquist frequency
//! $f_N = 1/2T$ in the middle of its flank, for any ratio of $T$ to the step. Window after Kaiser (1974).
//!
//! Measured (unit tests, T from 7 to 40 steps): within 3.3e-4 of 1 up to 0.8 $f_N$, one half at $f_N$, below
//! −69 dB from 1.2 $f_N$ on. What lies between 1.0 and 1.2 $f_N$ folds into 0.8 to 1.0 $f_N$ of the rows, so rows are to
//! be read up to 0.8 $f_N = 0.4/T$.

use super::OutputError;

/// Half the filter's length over T.
pub const HALF: f64 = 11.0;
/// Window parameter: about 70 dB.
const BETA: f64 = 6.755;
/// Samples that are worked in together, so that a row under way is touched once for all of them.
const BATCH: usize = 8;
/// Values of a block: those of a batch stay in the fastest cache.
const BLOCK: usize = 512;

/// Makes low-passed rows at `t = k T` from samples every `dt`; see the module.
///
/// Rows appear late, by [`delay`](Self::delay): a row needs the samples of 11 T behind it. Before the first
/// sample the ground is taken to hold that sample's values (at rest: zero), which is exact for a run that
/// starts at rest. [`finish`](Self::finish) holds the last sample in the same way; the rows of the last
/// 11 T then see a record that ends in a standstill and are wrong by what the motion still does
/// there. Run that much longer where they matter.
///
/// Cost: 22 additions and multiplications per value and sample, whatever the ratio; memory: 22 rows and
/// 8 samples (a few rows more at ratios near 1). Nothing is allocated after the start. The order of
/// summation does not depend on how samples and rows fall together, so a run that was saved and restored
/// gives the same bits.
#[derive(Debug, Clone)]
pub struct Decimator {
    values: usize,
    dt: f64,
    first: f64,
    dt_out: f64,
    /// Samples taken.
    taken: u64,
    /// Samples of these that wait in `batch`.
    waiting: usize,
    batch: Vec<f32>,
    /// Number k of the oldest row under way.
    row: i64,
    /// Rows under way, a ring: that of row k is `k mod slots`.
    sums: Vec<f32>,
    weights: Vec<f64>,
    slots: usize,
    /// Samples are passed on as they are.
    direct: bool,
}

/// One row.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a> {
    /// Its number k.
    pub number: i64,
    /// Its time k T, s.
    pub time: f64,
    /// Its values.
    pub values: &'a [f32],
}

impl Decimator {
    /// - `values`: of a sample; - `dt`: step, s; - `first`: time of the first sample, s (half a step for
    ///   velocities of a leap-frog scheme); - `dt_out`: T, s.
    ///
    /// The first row is the first multiple of T that is not more than half a step before `first`. With
    /// T = `dt` and `first` a multiple of it, samples are passed on unfiltered and at once.
    ///
    /// # Errors
    /// T below `dt`, or numbers that are not positive and finite.
    pub fn new(values: usize, dt: f64, first: f64, dt_out: f64) -> Result<Self, OutputError> {
        let ratio = dt_out / dt;
        let sound = dt > 0.0 && ratio.is_finite() && first.is_finite() && ratio >= 1.0 - 1e-9;
        if !sound {
            return Err(OutputError::Schedule { dt, dt_out, first });
        }
        let at = first / dt_out;
        let direct = (ratio - 1.0).abs() < 1e-9 && (at - at.round()).abs() < 1e-6;
        let slots = if direct { 0 } else { (2.0 * HALF + BATCH as f64 / ratio) as usize + 3 };
        Ok(Self {
            values,
            dt,
            first,
            dt_out,
            taken: 0,
            waiting: 0,
            batch: vec![0.0; if direct { values } else { BATCH * values }],
            row: if direct { at.round() as i64 } else { (at - 0.5 / ratio - 1e-9).ceil() as i64 },
            sums: vec![0.0; slots * values],
            weights: vec![0.0; slots],
            slots,
            direct,
        })
    }

    /// Time by which a row comes after the instant that it stands for, s, but for at most 7 steps.
    #[must_use]
    pub fn delay(&self) -> f64 {
        if self.direct { 0.0 } else { HALF * self.dt_out }
    }

    /// Takes the next sample, which `fill` writes, and gives the rows that are then complete to `emit`.
    ///
    /// # Errors
    /// Those of `emit`.
    pub fn take<E>(
        &mut self,
        fill: impl FnOnce(&mut [f32]),
        mut emit: impl FnMut(Row<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let at = self.waiting * self.values;
        fill(&mut self.batch[at..at + self.values]);
        self.taken += 1;
        if self.direct {
            let (number, values) = (self.row, &self.batch[..]);
            self.row += 1;
            return emit(Row { number, time: number as f64 * self.dt_out, values });
        }
        if self.taken == 1 {
            self.hold_before();
        }
        self.waiting += 1;
        if self.waiting == BATCH {
            self.work_in();
            return self.emit_complete(&mut emit);
        }
        Ok(())
    }

    /// Gives all rows up to the last sample's time; the last sample is held. Nothing can be taken after it.
    ///
    /// # Errors
    /// Those of `emit`.
    pub fn finish<E>(mut self, mut emit: impl FnMut(Row<'_>) -> Result<(), E>) -> Result<(), E> {
        if self.direct || self.taken == 0 {
            return Ok(());
        }
        let last = self.waiting.checked_sub(1).unwrap_or(BATCH - 1) * self.values;
        self.work_in();
        self.emit_complete(&mut emit)?;
        let last = self.batch[last..last + self.values].to_vec();
        let end = self.time(self.taken - 1);
        while self.row as f64 * self.dt_out <= end + 0.5 * self.dt {
            let held = self.held(self.row, self.taken..);
            self.add(self.row, held, &last);
            self.emit_row(&mut emit)?;
        }
        Ok(())
    }

    /// The state as bytes, for a checkpoint.
    pub fn save(&self, to: &mut Vec<u8>) {
        to.extend(self.taken.to_le_bytes());
        to.extend((self.waiting as u64).to_le_bytes());
        to.extend(self.row.to_le_bytes());
        self.weights.iter().for_each(|v| to.extend(v.to_le_bytes()));
        self.sums.iter().chain(&self.batch).for_each(|v| to.extend(v.to_le_bytes()));
    }

    /// Takes the state of [`Self::save`] back into a decimator made with the same arguments.
    ///
    /// # Errors
    /// Bytes of another size.
    pub fn restore(&mut self, from: &[u8]) -> Result<(), OutputError> {
        let expected = 24 + 8 * self.weights.len() + 4 * (self.sums.len() + self.batch.len());
        if from.len() != expected {
            return Err(OutputError::State { what: "the sub-sampling", found: from.len(), expected });
        }
        let (head, rest) = from.split_at(24 + 8 * self.weights.len());
        let mut words = head.as_chunks::<8>().0.iter();
        let mut word = || words.next().copied().unwrap_or_default();
        self.taken = u64::from_le_bytes(word());
        self.waiting = u64::from_le_bytes(word()) as usize;
        self.row = i64::from_le_bytes(word());
        self.weights.iter_mut().for_each(|weight| *weight = f64::from_le_bytes(word()));
        let slots = self.sums.iter_mut().chain(&mut self.batch);
        slots.zip(rest.as_chunks::<4>().0).for_each(|(slot, bytes)| *slot = f32::from_le_bytes(*bytes));
        Ok(())
    }

    fn time(&self, sample: u64) -> f64 {
        self.first + sample as f64 * self.dt
    }

    /// Weight of a sample in a row.
    fn weight(&self, sample: i64, row: i64) -> f64 {
        kernel((self.first + sample as f64 * self.dt - row as f64 * self.dt_out) / self.dt_out)
    }

    /// Sum of the weights in a row of samples from a number on.
    fn held(&self, row: i64, from: std::ops::RangeFrom<u64>) -> f64 {
        let last = ((row as f64 + HALF) * self.dt_out - self.first) / self.dt;
        (from.start as i64..=last.ceil() as i64).map(|sample| self.weight(sample, row)).sum()
    }

    /// The samples that would have been before the first one hold its values.
    fn hold_before(&mut self) {
        let first: Vec<f32> = self.batch[..self.values].to_vec();
        let mut row = self.row;
        while (row as f64 - HALF) * self.dt_out < self.first {
            let begin = (((row as f64 - HALF) * self.dt_out - self.first) / self.dt).floor() as i64;
            let sum = (begin..0).map(|sample| self.weight(sample, row)).sum();
            self.add(row, sum, &first);
            row += 1;
        }
    }

    fn slot(&self, row: i64) -> usize {
        row.rem_euclid(self.slots as i64) as usize
    }

    fn add(&mut self, row: i64, weight: f64, values: &[f32]) {
        let slot = self.slot(row);
        self.weights[slot] += weight;
        let sums = &mut self.sums[slot * self.values..(slot + 1) * self.values];
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight as f32 * value);
    }

    /// Works the waiting samples into all rows that they touch.
    fn work_in(&mut self) {
        let count = std::mem::take(&mut self.waiting);
        if count == 0 {
            return;
        }
        let first = (self.taken - count as u64) as i64;
        let end = (self.time(self.taken - 1) / self.dt_out + HALF).floor() as i64;
        let values = self.values;
        for row in self.row..=end {
            let mut weights = [0.0_f32; BATCH];
            let slot = self.slot(row);
            for (sample, weight) in weights.iter_mut().enumerate().take(count) {
                let exact = self.weight(first + sample as i64, row);
                self.weights[slot] += exact;
                *weight = exact as f32;
            }
            if weights == [0.0; BATCH] {
                continue;
            }
            let sums = &mut self.sums[slot * values..(slot + 1) * values];
            for (number, block) in sums.chunks_mut(BLOCK).enumerate() {
                let length = block.len();
                let sample = |s: usize| {
                    let at = s * values + number * BLOCK;
                    &self.batch[at..at + length]
                };
                if count == BATCH {
                    accumulate_all(block, &std::array::from_fn(sample), &weights);
                } else {
                    (0..count).for_each(|s| accumulate(block, sample(s), weights[s]));
                }
            }
        }
    }

    /// Gives the rows that no further sample touches.
    fn emit_complete<E>(&mut self, emit: &mut impl FnMut(Row<'_>) -> Result<(), E>) -> Result<(), E> {
        let next = self.time(self.taken);
        while (self.row as f64 + HALF) * self.dt_out <= next {
            self.emit_row(emit)?;
        }
        Ok(())
    }

    fn emit_row<E>(&mut self, emit: &mut impl FnMut(Row<'_>) -> Result<(), E>) -> Result<(), E> {
        let (number, slot) = (self.row, self.slot(self.row));
        let sums = &mut self.sums[slot * self.values..(slot + 1) * self.values];
        let factor = (1.0 / self.weights[slot]) as f32;
        sums.iter_mut().for_each(|sum| *sum *= factor);
        let outcome = emit(Row { number, time: number as f64 * self.dt_out, values: sums });
        sums.fill(0.0);
        self.weights[slot] = 0.0;
        self.row += 1;
        outcome
    }
}

/// Adds one sample.
fn accumulate(sums: &mut [f32], sample: &[f32], weight: f32) {
    sums.iter_mut().zip(sample).for_each(|(sum, value)| *sum += weight * value);
}

/// Adds a whole batch in the order in which one by one would.
fn accumulate_all(sums: &mut [f32], samples: &[&[f32]; BATCH], weights: &[f32; BATCH]) {
    let length = sums.len();
    let samples = samples.map(|sample| &sample[..length]);
    for (i, slot) in sums.iter_mut().enumerate() {
        let mut sum = *slot;
        for (sample, weight) in samples.iter().zip(weights) {
            sum += weight * sample[i];
        }
        *slot = sum;
    }
}

/// Filter over τ/T; its integral is about 1.
fn kernel(tau: f64) -> f64 {
    let place = tau / HALF;
    if place.abs() >= 1.0 {
        return 0.0;
    }
    let x = std::f64::consts::PI * tau;
    let sinc = if x.abs() < 1e-8 { 1.0 } else { x.sin() / x };
    sinc * bessel_i0(BETA * (1.0 - place * place).sqrt()) / bessel_i0(BETA)
}

/// Modified Bessel function of order 0 by its series, all terms positive.
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..60 {
        term *= quarter / f64::from(k * k);
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::f64::consts::PI;

    use super::*;

    /// Rows of one signal sampled `count` times.
    fn rows(dt: f64, first: f64, dt_out: f64, count: usize, signal: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let mut decimator = Decimator::new(1, dt, first, dt_out).expect("a schedule");
        let mut found = vec![];
        let mut emit = |row: Row<'_>| {
            found.push((row.time, f64::from(row.values[0])));
            Ok::<(), Infallible>(())
        };
        for n in 0..count {
            let value = signal(first + n as f64 * dt) as f32;
            decimator.take(|to| to[0] = value, &mut emit).expect("infallible");
        }
        decimator.finish(&mut emit).expect("infallible");
        found
    }

    /// A burst whose spectrum ends, to 1e-7, at `f + 3/width`: far from the ends it is zero.
    fn burst(f: f64, width: f64, centre: f64) -> impl Fn(f64) -> f64 {
        move |t| {
            let tau = (t - centre) / width;
            (-(PI * tau).powi(2)).exp() * (2.0 * PI * f * (t - centre)).sin()
        }
    }

    /// Largest error, and largest value, of the rows.
    fn error(found: &[(f64, f64)], exact: impl Fn(f64) -> f64) -> (f64, f64) {
        found
            .iter()
            .fold((0.0, 0.0), |(e, m): (f64, f64), (t, y)| (e.max((y - exact(*t)).abs()), m.max(y.abs())))
    }

    #[test]
    fn band_limited_signals_pass_at_any_ratio() {
        for ratio in [1.3, 2.0, 7.0, 10.37, 40.0] {
            let (dt, dt_out) = (1e-3, ratio * 1e-3);
            let nyquist = 0.5 / dt_out;
            let end = 120.0 * dt_out;
            let signal = burst(0.7 * nyquist, 60.0 * dt_out, 0.5 * end);
            let found = rows(dt, 0.0, dt_out, (end / dt) as usize + 1, &signal);
            assert!(found.len() >= 120 && found[0].0 == 0.0, "{} rows", found.len());
            let (error, largest) = error(&found, &signal);
            assert!(error < 5e-4 && largest > 0.8, "ratio {ratio}: {error:e}, {largest}");
        }
    }

    #[test]
    fn what_would_fold_is_suppressed() {
        for ratio in [7.0, 10.37, 40.0] {
            let (dt, dt_out) = (1e-3, ratio * 1e-3);
            let end = 200.0 * dt_out;
            for part in [1.22, 1.5, 2.0, 3.3] {
                let signal = burst(part * 0.5 / dt_out, 200.0 * dt_out, 0.5 * end);
                let found = rows(dt, 0.0, dt_out, (end / dt) as usize + 1, signal);
                let inner = found.iter().filter(|(t, _)| *t > 40.0 * dt_out && *t < 160.0 * dt_out);
                let largest = inner.fold(0.0_f64, |m, (_, y)| m.max(y.abs()));
                assert!(largest < 10_f64.powf(-66.0 / 20.0), "ratio {ratio}, {part} f_N: {largest:e}");
            }
        }
    }

    /// The gain at a frequency, from the kernel itself.
    fn gain(part: f64, ratio: f64, shift: f64) -> f64 {
        let (mut sum, mut total) = (0.0, 0.0);
        let most = (HALF * ratio) as i64 + 2;
        for n in -most..=most {
            let tau = (n as f64 + shift) / ratio;
            sum += kernel(tau) * (PI * part * tau).cos();
            total += kernel(tau);
        }
        sum / total
    }

    #[test]
    fn gain_of_the_filter() {
        for ratio in [7.0, 10.37, 40.0] {
            for shift in [0.0, 0.31, 0.5] {
                for step in 0..=80 {
                    let gain = gain(0.01 * f64::from(step), ratio, shift);
                    assert!((gain - 1.0).abs() < 3.3e-4, "{step} % of f_N: {gain}");
                }
                for step in 0..200 {
                    let part = 1.2 + 0.01 * f64::from(step);
                    let gain = gain(part, ratio, shift).abs();
                    assert!(gain < 10_f64.powf(-69.0 / 20.0), "{part} f_N: {} dB", 20.0 * gain.log10());
                }
            }
        }
    }

    #[test]
    fn a_constant_passes_from_end_to_end() {
        for (ratio, first) in [(1.7, 0.0), (10.0, 0.5e-3), (23.4, 0.0)] {
            let found = rows(1e-3, first, ratio * 1e-3, 5000, |_| 2.5);
            assert!(found.iter().all(|(_, y)| (y - 2.5).abs() < 3e-6), "ratio {ratio}");
            let last = found.last().expect("rows").0;
            assert!(last <= 5.0 && last > 5.0 - ratio * 1e-3 - 2e-3, "{last}");
            assert_eq!(found[0].0, 0.0);
        }
    }

    #[test]
    fn times_are_multiples_and_half_steps_are_seen() {
        // Velocities at half steps: the rows stand at whole multiples all the same.
        let (dt, dt_out) = (1e-3, 9.3e-3);
        let signal = burst(0.6 * 0.5 / dt_out, 50.0 * dt_out, 0.5);
        let found = rows(dt, 0.5 * dt, dt_out, 1000, &signal);
        assert!(found.iter().enumerate().all(|(k, (t, _))| *t == k as f64 * dt_out));
        assert!(error(&found, &signal).0 < 5e-4);
        let negative = rows(dt, -0.1, 0.02, 1000, |t| t);
        assert_eq!(negative[0].0, -0.1);
    }

    #[test]
    fn a_step_as_long_as_the_row_is_passed_on() {
        let found = rows(0.01, 0.0, 0.01, 10, |t| t);
        assert_eq!(found.len(), 10);
        assert!(found.iter().all(|(t, y)| (t - y).abs() < 1e-6));
        for dt_out in [0.009, 0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Decimator::new(1, 0.01, 0.0, dt_out), Err(OutputError::Schedule { .. })));
        }
    }

    #[test]
    fn rows_come_after_the_delay() {
        let (dt, dt_out) = (1e-3, 0.01);
        let mut decimator = Decimator::new(1, dt, 0.0, dt_out).expect("a schedule");
        let mut late = 0.0_f64;
        for n in 0..2000 {
            let now = n as f64 * dt;
            let emit = |row: Row<'_>| {
                late = late.max(now - row.time);
                Ok::<(), Infallible>(())
            };
            decimator.take(|to| to[0] = 0.0, emit).expect("infallible");
        }
        assert!((0.0..=7.5 * dt).contains(&(late - decimator.delay())), "{late}");
    }

    #[test]
    fn a_restored_decimator_gives_the_same_bits() {
        let values = 1030;
        let sample = |n: usize, i: usize| ((n * 31 + i * 17) % 101) as f32 - 50.0;
        let run = |cut: Option<usize>| {
            let mut decimator = Decimator::new(values, 1e-3, 0.0, 6.4e-3).expect("a schedule");
            let mut found = vec![];
            let mut emit = |row: Row<'_>| {
                found.extend(row.values.iter().map(|v| v.to_bits()));
                Ok::<(), Infallible>(())
            };
            for n in 0..400 {
                if cut == Some(n) {
                    let mut state = vec![];
                    decimator.save(&mut state);
                    decimator = Decimator::new(values, 1e-3, 0.0, 6.4e-3).expect("a schedule");
                    decimator.restore(&state).expect("its own state");
                }
                let fill = |to: &mut [f32]| to.iter_mut().enumerate().for_each(|(i, v)| *v = sample(n, i));
                decimator.take(fill, &mut emit).expect("infallible");
            }
            decimator.finish(&mut emit).expect("infallible");
            found
        };
        let whole = run(None);
        assert_eq!(whole.len(), 63 * values);
        for cut in [1, 63, 200, 205] {
            assert!(run(Some(cut)) == whole, "cut at {cut}");
        }
        assert!(Decimator::new(2, 1e-3, 0.0, 6.4e-3).expect("a schedule").restore(&[0; 9]).is_err());
    }

    #[test]
    fn taking_allocates_nothing() {
        let mut decimator = Decimator::new(500, 1e-3, 0.0, 5e-3).expect("a schedule");
        let mut take = |count: usize| {
            for _ in 0..count {
                decimator.take(|to| to.fill(1.0), |_| Ok::<(), Infallible>(())).expect("infallible");
            }
        };
        take(1);
        assert_eq!(allocation_counter::measure(|| take(1000)).count_total, 0);
    }
}
