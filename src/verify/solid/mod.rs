//! Cases of the ground at D = 2 and 3.

mod attenuation;
mod bar;
mod bound;
mod coarse;
mod manufactured;
mod plane_waves;

pub(super) use attenuation::attenuation;
pub use attenuation::realised_error;
pub(super) use bound::solid_step_bound;
pub(super) use coarse::{attenuation_coarse, coarse_chart};
pub(super) use manufactured::manufactured;
pub use manufactured::{manufactured_error, manufactured_sizes};
pub(super) use plane_waves::{dispersion_chart, plane_waves};
