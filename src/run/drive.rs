//! Base motion of the column from the control motion: integration, and deconvolution of a surface record.

use crate::plan::{Control, Plan, PlanError};
use hati_inputs::motion::{Quantity, padded_length, resample_as};
use hati_sem::attenuation::ModulusLaw;
use hati_sem::column::{BaseMotion, FrequencyResponse, TimeSymbol};
use num_complex::Complex64;
use realfft::RealFftPlanner;

/// What drives the column, and the input motion as it is reported.
pub struct Drive {
    /// Base motion of each component at the kicks.
    pub base: [Option<BaseMotion>; 3],
    /// Acceleration that enters at the base at the samples, m/s²: outcrop, or within where imposed.
    pub acceleration: [Option<Vec<f64>>; 3],
    /// Largest amplification that deconvolution applied inside the band; 1 without.
    pub amplification: f64,
}

/// Builds the base motion of a plan.
pub fn drive(plan: &Plan) -> Result<Drive, PlanError> {
    let mut drive = Drive { base: [None, None, None], acceleration: [None, None, None], amplification: 1.0 };
    for &axis in &plan.axes {
        let given = plan.input.motion.components[axis].clone().unwrap_or_default();
        let a = if plan.control == Control::Surface {
            let (a, amplification) = deconvolve(plan, axis, &given)?;
            drive.amplification = drive.amplification.max(amplification);
            a
        } else {
            given
        };
        let to = if plan.imposed() { Quantity::Displacement } else { Quantity::Velocity };
        let fine = resample_as(&a, plan.sample_dt, Quantity::Acceleration, to, plan.substeps);
        drive.base[axis] =
            Some(if plan.imposed() { BaseMotion::Imposed(fine) } else { BaseMotion::Outcrop(fine) });
        drive.acceleration[axis] = Some(a);
    }
    Ok(drive)
}

/// Frequency response of the column exactly as it will run, for one component.
pub fn discrete_response(plan: &Plan, axis: usize, depths: &[f64]) -> Result<FrequencyResponse, PlanError> {
    let laws: Vec<ModulusLaw> = plan.arms.iter().map(|a| ModulusLaw::Maxwell(a[axis].clone())).collect();
    let symbol = TimeSymbol::CentralDifference(plan.dt());
    Ok(FrequencyResponse::new(&plan.column, &plan.discretisation, axis, &laws, symbol, depths)?)
}

/// Divides a surface motion by the column's own discrete response surface/base motion.
///
/// The response is that of the time loop to round-off, so the run gives the surface motion back. The
/// spectrum is padded by the usual zeros; the motion at depth starts earlier than the surface's, for
/// which the plan leads the record in.
fn deconvolve(plan: &Plan, axis: usize, surface: &[f64]) -> Result<(Vec<f64>, f64), PlanError> {
    let dt = plan.sample_dt;
    let n = padded_length(surface.len(), dt, 2.0 * hati_inputs::motion::PAD_SECONDS);
    let mut planner = RealFftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
    let mut time = vec![0.0; n];
    time[..surface.len()].copy_from_slice(surface);
    let mut spectrum = forward.make_output_vec();
    let mut failed = forward.process(&mut time, &mut spectrum).is_err();
    let response = discrete_response(plan, axis, &[0.0])?;
    let df = 1.0 / (n as f64 * dt);
    let mut amplification = 1.0_f64;
    let nyquist = n.is_multiple_of(2).then_some(n / 2);
    for (k, value) in spectrum.iter_mut().enumerate().skip(1) {
        let f = k as f64 * df;
        let t = response.at(f);
        let h = t.per_within[0] * t.within_per_outcrop;
        *value /= h;
        if f >= plan.band.0 && f <= plan.band.1 {
            amplification = amplification.max(1.0 / h.norm());
        }
        if Some(k) == nyquist {
            *value = Complex64::new(value.re, 0.0);
        }
    }
    spectrum[0].im = 0.0;
    failed |= inverse.process(&mut spectrum, &mut time).is_err();
    debug_assert!(!failed, "buffers have the planner's own lengths");
    let scale = 1.0 / n as f64;
    Ok((time[..surface.len()].iter().map(|x| x * scale).collect(), amplification))
}
