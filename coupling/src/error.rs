/// What can go wrong in a subdomain's step or in the algebra around it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CouplingError {
    /// A state was restored into a subdomain of another size.
    #[error(
        "state of {found} values offered to `{subdomain}`, which holds {expected}: the checkpoint belongs to another discretisation; delete it or restore the scene it was made from"
    )]
    StateSize {
        /// Name of the subdomain.
        subdomain: String,
        /// Values in the state.
        found: usize,
        /// Values the subdomain holds.
        expected: usize,
    },
    /// The run grows without physical cause.
    #[error(
        "`{subdomain}` became unstable at t = {time:.6} s: {symptom}; step {dt:.3e} s, critical step {dt_critical:.3e} s; {likely}"
    )]
    Unstable {
        /// Name of the subdomain.
        subdomain: String,
        /// Simulated time, s.
        time: f64,
        /// What was seen.
        symptom: String,
        /// Step in use, s.
        dt: f64,
        /// Its critical step, s.
        dt_critical: f64,
        /// Likely cause and what to do.
        likely: String,
    },
    /// The Lanczos process did not settle on the largest eigenvalue.
    #[error(
        "largest eigenfrequency not found to {tolerance:.1e} in {iterations} Lanczos steps (last residual {residual:.1e}): the highest eigenfrequencies lie too close together, as in a uniform mesh of very many elements, or the stiffness is not symmetric; take fewer elements"
    )]
    SpectralBound {
        /// Asked relative tolerance.
        tolerance: f64,
        /// Steps taken.
        iterations: usize,
        /// Relative residual reached.
        residual: f64,
    },
    /// A freedom carries no mass, so an explicit step cannot move it.
    #[error(
        "freedom {index} has mass {mass:e}: every freedom of an explicit part needs a positive lumped mass"
    )]
    Massless {
        /// Index of the freedom.
        index: usize,
        /// Its mass.
        mass: f64,
    },
    /// A parameter without a stable scheme.
    #[error("{name} = {value} lies outside {low} to {high}, where the scheme is stable at every step")]
    SchemeParameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Least value.
        low: f64,
        /// Largest value.
        high: f64,
    },
}
