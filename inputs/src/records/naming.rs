//! What the name of a channel says: its axis, its instrument.

use super::reader::Segment;

/// Axis by the file's own direction (vertical, or an azimuth within 1° of east or north), else by the
/// channel's name: `EW`, `EW1`, `HNE`, `x` → 0; north → 1; `UD2`, `HNZ` → 2.
pub(super) fn axis_hint(whole: &Segment) -> Option<usize> {
    if whole.flag("vertical") == Some(true) {
        return Some(2);
    }
    if let Some(azimuth) = whole.number("azimuth_deg") {
        let away = |direction: f64| ((azimuth - direction + 180.0).rem_euclid(360.0) - 180.0).abs();
        return [90.0, 0.0].into_iter().position(|direction| away(direction) <= 1.0);
    }
    axis_by_name(&whole.channel)
}

pub(super) fn axis_by_name(channel: &str) -> Option<usize> {
    let name = channel.trim().to_ascii_uppercase();
    // KiK-net numbers its sensors: EW1 in the borehole, EW2 at the surface.
    match name.trim_end_matches(['1', '2']) {
        "EW" => return Some(0),
        "NS" => return Some(1),
        "UD" | "UP" => return Some(2),
        _ => {}
    }
    match name.chars().last()? {
        'E' | 'X' => Some(0),
        'N' | 'Y' => Some(1),
        'Z' => Some(2),
        _ => None,
    }
}

/// What [`instrument`] says of the code letter N.
pub(super) const ACCELEROMETER: &str = "an accelerometer";

/// The instrument that a three-letter SEED channel code names, by its second letter.
pub(super) fn instrument(channel: &str) -> Option<&'static str> {
    let mut letters = channel.trim().chars();
    let (_, second, _) = (letters.next()?, letters.next()?, letters.next()?);
    match second {
        _ if letters.next().is_some() => None,
        'H' | 'L' => Some("a velocity seismometer"),
        'N' => Some(ACCELEROMETER),
        _ => None,
    }
}
