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

/// Relative difference between the stated peak and that of the samples beyond which one of them is wrong.
const PEAK_TOLERANCE: f64 = 0.05;

/// `Max. Acc. (gal)` is the peak about the offset; a wrong scale factor shows there.
fn stated_peak(segment: &Segment) -> Result<(), String> {
    let (Some(stated), Some(factor)) = (segment.number("accmax").filter(|peak| *peak > 0.0), segment.calib)
    else {
        return Ok(());
    };
    let mean = segment.samples.iter().sum::<f64>() / segment.samples.len().max(1) as f64;
    let peak = segment.samples.iter().fold(0.0_f64, |peak, value| peak.max((value - mean).abs()));
    let found = 100.0 * peak * factor;
    // The header prints gal to three decimals.
    if (found - stated).abs() > PEAK_TOLERANCE * stated + 1e-3 {
        return Err(format!(
            "the header's Max. Acc. is {stated} gal, counts times Scale Factor give {found:.3}"
        ));
    }
    Ok(())
}

/// `Duration Time` is in whole seconds: the samples must last that long, to the second.
pub(super) fn consistent(segment: &Segment) -> Result<(), String> {
    let Some(duration) = segment.number("duration") else {
        return Ok(());
    };
    stated_peak(segment)?;
    let found = segment.samples.len() as f64 * segment.dt;
    if (found - duration).abs() >= 1.0 {
        return Err(format!("the header's Duration Time is {duration} s, the samples last {found:.2} s"));
    }
    Ok(())
}
