//! GSE1 and GSE2: text lines, samples as numbers or six-bit compressed, with a checksum.

use super::{Recognition, Segment, StoredUnit};

/// Files begin with the waveform line `WID2`.
pub(super) fn recognise_2(bytes: &[u8]) -> Recognition {
    if !bytes.starts_with(b"WID2 ") {
        return Recognition::No;
    }
    // Columns of the WID2 line: samples in 49-56. Every sample takes at least one byte.
    let line = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    sample_count(line.get(48..56), bytes.len())
}

/// Files begin with `WID1`, or with the line `XW01` before it.
pub(super) fn recognise_1(bytes: &[u8]) -> Recognition {
    if !(bytes.starts_with(b"WID1 ") || bytes.starts_with(b"XW01")) {
        return Recognition::No;
    }
    let mut lines = bytes.split(|b| *b == b'\n').take(8);
    let Some(line) = lines.find(|line| line.starts_with(b"WID1")) else {
        return Recognition::Broken("no WID1 line".into());
    };
    // Columns of the WID1 line: samples in 28-35.
    sample_count(line.get(27..35), bytes.len())
}

/// A header must not announce more samples than the file can hold.
fn sample_count(field: Option<&[u8]>, size: usize) -> Recognition {
    let text = field.and_then(|field| std::str::from_utf8(field).ok());
    match text.and_then(|text| text.trim().parse::<usize>().ok()) {
        None => Recognition::Broken("the waveform line gives no number of samples".into()),
        Some(0) => Recognition::Broken("the waveform line says 0 samples".into()),
        Some(count) if count > size => Recognition::Broken(format!(
            "the waveform line says {count} samples, the whole file has {size} bytes"
        )),
        Some(_) => Recognition::Yes,
    }
}

/// The calibration turns counts into a displacement at one period only: it is no unit of the record.
pub(super) fn unit(segment: &Segment) -> Result<StoredUnit, String> {
    let calibration = match (segment.calib, segment.number("calper")) {
        (Some(calib), Some(period)) => format!("CALIB = {calib} nm/count at a period of {period} s"),
        (Some(calib), None) => format!("the calibration {calib} nm/count"),
        _ => "the calibration".into(),
    };
    Err(format!("samples are instrument counts, and {calibration} is a displacement for that period only"))
}
