//! Whether the samples of a channel are sound: one stretch, one step, finite, alive, unclipped.

use std::path::Path;

use super::reader::Segment;
use crate::error::InputError;

/// Samples at an extreme value, in all, from which clipping is suspected.
const CLIPPED_SAMPLES: usize = 10;
/// Samples in a row at an extreme, at least once, for the suspicion to hold.
const CLIPPED_RUN: usize = 3;

/// Joins the segments of one channel into one, or says where they do not fit.
///
/// Segments are put in the order of time. A difference of half a step between the expected and the
/// stated begin of the next one is the clock's resolution; more is a gap or an overlap.
pub(super) fn join(path: &Path, mut segments: Vec<Segment>) -> Result<Segment, InputError> {
    segments.sort_by_key(|segment| segment.start_ns);
    let mut parts = segments.into_iter();
    let mut whole = parts.next().expect("a channel has a segment");
    check_step(path, &whole)?;
    for part in parts {
        check_step(path, &part)?;
        if (part.dt - whole.dt).abs() > 1e-6 * whole.dt {
            return Err(InputError::MixedRates {
                path: path.into(),
                channel: whole.id,
                first: whole.dt,
                first_begin: whole.start_utc,
                second: part.dt,
                second_begin: part.start_utc,
            });
        }
        let since = (i128::from(part.start_ns) - i128::from(whole.start_ns)) as f64 * 1e-9;
        let late = since - whole.samples.len() as f64 * whole.dt;
        if late.abs() > 0.5 * whole.dt {
            let (path, channel) = (path.to_path_buf(), whole.id);
            let (end, begin, seconds) = (whole.end_utc, part.start_utc, late.abs());
            return Err(if late > 0.0 {
                InputError::Gap { path, channel, end, begin, seconds }
            } else {
                InputError::Overlap { path, channel, end, begin, seconds }
            });
        }
        whole.samples.extend_from_slice(&part.samples);
        whole.end_utc = part.end_utc;
    }
    Ok(whole)
}

fn check_step(path: &Path, segment: &Segment) -> Result<(), InputError> {
    if segment.dt.is_finite() && segment.dt > 0.0 {
        return Ok(());
    }
    Err(InputError::BadStep { path: path.into(), channel: segment.id.clone(), dt: segment.dt })
}

/// Refuses what cannot be a motion; `accept_clipped` lets a plateau at the extreme pass.
pub(super) fn sound(path: &Path, whole: &Segment, accept_clipped: bool) -> Result<(), InputError> {
    let (path, channel) = (path.to_path_buf(), whole.id.clone());
    let x = &whole.samples;
    if x.len() < 2 {
        return Err(InputError::TooShort { path, channel, samples: x.len() });
    }
    if let Some(index) = x.iter().position(|value| !value.is_finite()) {
        return Err(InputError::NotFinite {
            path,
            channel,
            index,
            time: index as f64 * whole.dt,
            value: x[index],
            count: x.iter().filter(|value| !value.is_finite()).count(),
        });
    }
    if x.iter().all(|value| *value == x[0]) {
        return Err(InputError::DeadChannel { path, channel, samples: x.len(), value: x[0] });
    }
    match clipped(x) {
        Some((begin, run)) if !accept_clipped => Err(InputError::Clipped {
            path,
            channel,
            run,
            count: x.iter().filter(|value| **value == x[begin]).count(),
            value: x[begin],
            time: begin as f64 * whole.dt,
        }),
        _ => Ok(()),
    }
}

/// First plateau (begin, length) that only a limit of the instrument explains.
///
/// At least 10 samples stand at the largest or at the smallest value, and in one place 3 or more of
/// them in a row, where
/// - the value lies at least half as far from the median as the farthest sample (the quiet level of a
///   one-sided pulse is an extreme too, but no limit), and
/// - the slopes with which the signal enters and leaves, continued by a parabola over the run, would
///   have taken it beyond the value by more than four quanta and by more than 0.1 % of the range. The
///   quantum is the smallest change between neighbours.
///
/// The top of a slow swell that is coarse in counts has runs as well, but there the parabola rises by
/// one or two quanta. A sine whose period is a whole number of samples repeats its largest value for
/// ever, but twice in a row at most.
pub(super) fn clipped(x: &[f64]) -> Option<(usize, usize)> {
    let (low, high) = x
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
    let mut sorted = x.to_vec();
    let (_, median, _) = sorted.select_nth_unstable_by(x.len() / 2, f64::total_cmp);
    let farthest = (high - *median).max(*median - low);
    let quantum = x
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min);
    let material = (4.0 * quantum).max(1e-3 * (high - low));
    let count = |value: f64| x.iter().filter(|other| **other == value).count();
    let piled = |value: f64| (value - *median).abs() >= 0.5 * farthest && count(value) >= CLIPPED_SAMPLES;
    let (low_piled, high_piled) = (piled(low), piled(high));
    let suspect = |value: f64| (low_piled && value == low) || (high_piled && value == high);
    let mut begin = 0;
    while begin < x.len() {
        let run = x[begin..].iter().take_while(|value| **value == x[begin]).count();
        if run >= CLIPPED_RUN && suspect(x[begin]) {
            let slope = flank_slope(x, begin, run);
            // A parabola over n steps that begins with slope s rises by s n/4.
            if slope * run as f64 / 4.0 > material {
                return Some((begin, run));
            }
        }
        begin += run;
    }
    None
}

/// The smaller of the mean slopes before and after a run, per sample; one side where the record
/// begins or ends with the run.
///
/// Taken as the largest distance from the plateau within half a run (at least 5 samples), over that
/// length: closer in, one quantum would already look steep beside a long run.
fn flank_slope(x: &[f64], begin: usize, run: usize) -> f64 {
    let value = x[begin];
    let flank = (run / 2).max(5);
    let slope = |side: &[f64]| {
        let farthest = side.iter().map(|other| (value - other).abs()).fold(0.0, f64::max);
        (!side.is_empty()).then(|| farthest / side.len() as f64)
    };
    let end = begin + run;
    let before = slope(&x[begin - begin.min(flank)..begin]);
    let after = slope(&x[end..x.len().min(end + flank)]);
    match (before, after) {
        (Some(before), Some(after)) => before.min(after),
        (Some(slope), None) | (None, Some(slope)) => slope,
        (None, None) => 0.0,
    }
}
