/// What can be wrong with a soil model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SemError {
    /// A polynomial order that has no tabulated rule.
    #[error("polynomial order {0} is outside 1…10; orders 4 to 8 serve most scenes")]
    Order(usize),
    /// A mesh description that does not fit the profile.
    #[error("{found} element counts for {expected} layers: give one count of at least 1 per layer")]
    ElementCounts {
        /// Counts given.
        found: usize,
        /// Layers of the profile.
        expected: usize,
    },
    /// A material value out of its range.
    #[error("layer `{layer}`: {key} = {value} is outside its range ({range})")]
    Material {
        /// Layer's name.
        layer: String,
        /// Key.
        key: &'static str,
        /// Value found.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// The damping fit did not converge.
    #[error(
        "no set of {mechanisms} memory variables found for D = {damping} over {f_min}–{f_max} Hz; ask for more mechanisms or a narrower band"
    )]
    Fit {
        /// Mechanisms asked for.
        mechanisms: usize,
        /// Damping ratio.
        damping: f64,
        /// Lower end of the band, Hz.
        f_min: f64,
        /// Upper end of the band, Hz.
        f_max: f64,
    },
    /// A depth outside the column.
    #[error("depth {depth} m lies outside the column (0 to {bottom} m)")]
    Depth {
        /// Depth asked for, m.
        depth: f64,
        /// Depth of the column's base, m.
        bottom: f64,
    },
    /// No component is active.
    #[error("no component is active: the motion must have x, y or z")]
    NoComponent,
    /// From the step or the algebra.
    #[error(transparent)]
    Coupling(#[from] hati_coupling::CouplingError),
}
