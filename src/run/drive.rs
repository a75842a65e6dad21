//! Base motion of the column from the control motion: integration, and deconvolution of a surface record.

use crate::plan::{Control, Plan, PlanError};
use crate::spectrum::filtered;
use hati_inputs::motion::{PAD_SECONDS, Quantity, resample_as};
use hati_sem::column::BaseMotion;
use num_complex::Complex64;

/// What drives the column, and the input motion as it is reported.
pub struct Drive {
    /// Base motion of each component at the kicks.
    pub base: [Option<BaseMotion>; 3],
    /// Acceleration that enters at the base at the samples, m/s²: outcrop, or within where imposed.
    pub acceleration: [Option<Vec<f64>>; 3],
}

/// Builds the base motion of a plan.
pub fn drive(plan: &Plan) -> Result<Drive, PlanError> {
    let mut drive = Drive { base: [None, None, None], acceleration: [None, None, None] };
    for &axis in &plan.axes {
        let given = plan.input.motion.components[axis].clone().unwrap_or_default();
        let a = if plan.control == Control::Surface { deconvolve(plan, axis, &given)? } else { given };
        let to = if plan.imposed() { Quantity::Displacement } else { Quantity::Velocity };
        let fine = resample_as(&a, plan.sample_dt, Quantity::Acceleration, to, plan.substeps);
        drive.base[axis] =
            Some(if plan.imposed() { BaseMotion::Imposed(fine) } else { BaseMotion::Outcrop(fine) });
        drive.acceleration[axis] = Some(a);
    }
    Ok(drive)
}

/// Divides a surface motion by the column's own discrete response surface/base motion.
///
/// The response is that of the time loop to round-off, so the run gives the surface motion back. The
/// motion at depth starts earlier than the surface's, for which the plan leads the record in.
fn deconvolve(plan: &Plan, axis: usize, surface: &[f64]) -> Result<Vec<f64>, PlanError> {
    let response = plan.response(axis, &[0.0])?;
    let nyquist = 0.5 / plan.sample_dt;
    Ok(filtered(surface, plan.sample_dt, 2.0 * PAD_SECONDS, |f| {
        // a step as long as the sample turns the alternating motion into itself: no response to divide by
        if f > 0.999 * nyquist {
            return Complex64::ZERO;
        }
        let t = response.at(f);
        1.0 / (t.per_within[0] * t.within_per_outcrop)
    }))
}
