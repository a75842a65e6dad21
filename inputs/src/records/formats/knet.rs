//! K-NET and KiK-net ASCII: 17 header lines, then counts in columns.

use super::{Quantity, Recognition, Segment, StoredUnit};

/// Files begin with the words `Origin Time`; the header ends with a `Memo` line.
pub(super) fn recognise(bytes: &[u8]) -> Recognition {
    if !bytes.starts_with(b"Origin Time") {
        return Recognition::No;
    }
    let mut lines = bytes.split(|b| *b == b'\n');
    match lines.by_ref().take(32).position(|line| line.starts_with(b"Memo")) {
        Some(_) => Recognition::Yes,
        None => Recognition::Broken("the header has no Memo line".into()),
    }
}

/// `Scale Factor` is gal per count; ObsPy hands it over as m/s² per count.
pub(super) fn unit(segment: &Segment) -> Result<StoredUnit, String> {
    match segment.calib {
        Some(factor) if factor.is_finite() && factor > 0.0 => Ok(StoredUnit {
            text: "counts × scale factor (gal/count)".into(),
            quantity: Quantity::Acceleration,
            factor,
        }),
        _ => Err("the header's Scale Factor is not a positive number".into()),
    }
}

/// `Duration Time` is in whole seconds: the samples must last that long, to the second.
pub(super) fn consistent(segment: &Segment) -> Result<(), String> {
    let Some(duration) = segment.number("duration") else {
        return Ok(());
    };
    let found = segment.samples.len() as f64 * segment.dt;
    if (found - duration).abs() >= 1.0 {
        return Err(format!("the header's Duration Time is {duration} s, the samples last {found:.2} s"));
    }
    Ok(())
}
