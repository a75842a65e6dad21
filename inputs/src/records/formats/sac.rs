//! SAC binary: 70 floats, 40 integers, 192 bytes of text, then 4-byte floats.

use super::{Recognition, Segment, StoredUnit, Unit};

const HEADER_BYTES: usize = 632;
/// Value of a header field that is not set.
const UNSET: i32 = -12345;

/// Offsets of the integer fields that decide, bytes.
const NVHDR: usize = 4 * 76;
const NPTS: usize = 4 * 79;
const IFTYPE: usize = 4 * 85;
const LEVEN: usize = 4 * 105;
const LAST_LOGICAL: usize = 4 * 109;
/// Year of the reference time; day, hour, minute, second and millisecond follow.
const NZYEAR: usize = 4 * 70;
/// Ranges of those six.
const CLOCK: [(&str, std::ops::RangeInclusive<i32>); 6] = [
    ("NZYEAR", 0..=2200),
    ("NZJDAY", 0..=366),
    ("NZHOUR", 0..=23),
    ("NZMIN", 0..=59),
    ("NZSEC", 0..=60),
    ("NZMSEC", 0..=999),
];
/// Latitude and longitude of station and event with their largest magnitudes, degrees.
const PLACES: [(&str, usize, f32); 4] =
    [("STLA", 4 * 31, 90.0), ("STLO", 4 * 32, 360.0), ("EVLA", 4 * 35, 90.0), ("EVLO", 4 * 36, 360.0)];

/// Header version 6, logical fields that are logical, a positive step, npts that fits the file's size.
pub(super) fn recognise(bytes: &[u8]) -> Recognition {
    if bytes.len() < HEADER_BYTES {
        return Recognition::No;
    }
    let four = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let little = i32::from_le_bytes(four(NVHDR));
    let big = i32::from_be_bytes(four(NVHDR));
    let is_little = match (little, big) {
        (6 | 7, _) => true,
        (_, 6 | 7) => false,
        _ => return Recognition::No,
    };
    let int = |at: usize| {
        if is_little { i32::from_le_bytes(four(at)) } else { i32::from_be_bytes(four(at)) }
    };
    let float = |at: usize| {
        if is_little { f32::from_le_bytes(four(at)) } else { f32::from_be_bytes(four(at)) }
    };
    let delta = float(0);
    let logical = (LEVEN..LAST_LOGICAL).step_by(4).all(|at| matches!(int(at), 0 | 1 | UNSET));
    if !logical {
        return Recognition::No;
    }
    let npts = int(NPTS);
    let needed = HEADER_BYTES as i64 + 4 * i64::from(npts);
    let problem = if int(NVHDR) != 6 {
        Some("header version 7 is not read; save it as version 6".to_string())
    } else if int(LEVEN) == 0 {
        Some("samples are not evenly spaced in time (LEVEN is false)".to_string())
    } else if !matches!(int(IFTYPE), 1 | UNSET) {
        Some(format!("not a time series (IFTYPE = {})", int(IFTYPE)))
    } else if !(delta.is_finite() && delta > 0.0) {
        Some(format!("DELTA = {delta} s; it must be positive"))
    } else if npts < 0 || needed != bytes.len() as i64 {
        Some(format!("NPTS = {npts} needs {needed} bytes, the file has {}", bytes.len()))
    } else {
        outside(int, float)
    };
    problem.map_or(Recognition::Yes, Recognition::Broken)
}

/// A time or a place that does not exist; ObsPy would count its way to it, degree by degree.
fn outside(int: impl Fn(usize) -> i32, float: impl Fn(usize) -> f32) -> Option<String> {
    for (i, (name, range)) in CLOCK.iter().enumerate() {
        let value = int(NZYEAR + 4 * i);
        if value != UNSET && !range.contains(&value) {
            let (low, high) = (range.start(), range.end());
            return Some(format!("{name} = {value}; it must be {low} to {high}, or {UNSET} where unknown"));
        }
    }
    for (name, at, largest) in PLACES {
        let value = float(at);
        // Not a number is outside as well.
        let inside = value.abs() <= largest;
        if value != UNSET as f32 && !inside {
            return Some(format!(
                "{name} = {value}° is no place; at most {largest}°, or {UNSET} where unknown"
            ));
        }
    }
    None
}

/// IDEP 6, 7 and 8 mean nm, nm/s and nm/s². SCALE is not applied by SAC itself but is by others, so a
/// file that sets it leaves the unit open.
pub(super) fn unit(segment: &Segment) -> Result<StoredUnit, String> {
    if let Some(scale) = segment.calib.filter(|scale| (scale - 1.0).abs() > 1e-12) {
        return Err(format!("the header sets SCALE = {scale}, which some programs apply and others ignore"));
    }
    match segment.number("idep").map(|code| code as i64) {
        Some(6) => Ok(StoredUnit::of(Unit::Nanometre)),
        Some(7) => Ok(StoredUnit::of(Unit::NanometrePerSecond)),
        Some(8) => Ok(StoredUnit::of(Unit::NanometrePerSecond2)),
        Some(code) if code != i64::from(UNSET) && code != 5 => {
            Err(format!("IDEP = {code} is none of 6 (displacement), 7 (velocity), 8 (acceleration)"))
        }
        _ => Err("the header does not say what the samples are (IDEP is unknown)".into()),
    }
}
