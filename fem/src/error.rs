//! Errors of structures.

/// What can be wrong with a structure.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FemError {
    /// An entry outside a matrix.
    #[error("entry ({row}, {column}) lies outside a matrix of {size} rows")]
    Entry {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// Number of rows.
        size: usize,
    },
    /// An entry that is no number.
    #[error("entry ({row}, {column}) of a matrix is {value}: look for a section, length or modulus of zero")]
    NotFinite {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The value.
        value: f64,
    },
    /// A list that does not fit the matrix.
    #[error("{what}: {found} given, {expected} expected")]
    Length {
        /// What the list holds.
        what: &'static str,
        /// Length found.
        found: usize,
        /// Length expected.
        expected: usize,
    },
    /// A freedom named twice in one list.
    #[error("freedom {freedom} stands twice in a list of freedoms")]
    FreedomTwice {
        /// The freedom.
        freedom: usize,
    },
    /// A matrix other than the one whose pattern was analysed.
    #[error(
        "the matrix has {found} entries in other places than the {expected} that were analysed: analyse it anew"
    )]
    Pattern {
        /// Entries found.
        found: usize,
        /// Entries analysed.
        expected: usize,
    },
    /// A pivot that is zero, negative, or positive only by round-off.
    #[error(
        "no stiffness is left at freedom {freedom} (pivot {pivot:.3e}, diagonal {diagonal:.3e}): the structure can \
         move there without force, or it has buckled; add the support or the connection that is missing"
    )]
    Pivot {
        /// Freedom, in the numbering of the matrix.
        freedom: usize,
        /// Pivot: what is left of the diagonal after elimination.
        pivot: f64,
        /// Diagonal of the matrix.
        diagonal: f64,
    },
    /// Factors that lost all their digits.
    #[error(
        "the factor of an indefinite matrix leaves a residual of {residual:.1e}: the shift lies on an eigenvalue of \
         a part of the structure; take another"
    )]
    Unstable {
        /// Relative residual of a solve.
        residual: f64,
    },
    /// An ordering or a factor that did not fit into memory.
    #[error("not enough memory for {what} of a matrix of {size} rows")]
    Memory {
        /// What was to be stored.
        what: &'static str,
        /// Number of rows.
        size: usize,
    },
    /// More modes than there are freedoms with mass.
    #[error("{asked} modes asked, {available} exist (freedoms without mass have none): ask for fewer")]
    TooManyModes {
        /// Modes asked.
        asked: usize,
        /// Modes that exist.
        available: usize,
    },
    /// Modes that did not converge.
    #[error(
        "{converged} of {asked} modes reached the tolerance {tolerance:.1e} after {solves} solves: loosen it, or \
         look for stiffnesses many orders apart"
    )]
    ModesNotConverged {
        /// Modes asked.
        asked: usize,
        /// Modes that converged.
        converged: usize,
        /// Tolerance.
        tolerance: f64,
        /// Solves made.
        solves: usize,
    },
    /// A count of eigenvalues that does not agree with those found.
    #[error("{counted} modes lie below {frequency:.6} Hz, {found} were found: take a smaller tolerance")]
    ModeCount {
        /// Modes counted by the signs of pivots.
        counted: usize,
        /// Modes found.
        found: usize,
        /// Frequency of the count, Hz.
        frequency: f64,
    },
    /// A band of frequencies without extent.
    #[error(
        "a band from {from} Hz to {to} Hz: the two must be finite, not negative, and the first below the second"
    )]
    Band {
        /// Lower end, Hz.
        from: f64,
        /// Upper end, Hz.
        to: f64,
    },
    /// A reduction that does not reach the accuracy demanded.
    #[error(
        "a reduction with modes up to {cut_off:.3} Hz still errs by {estimate:.1e} at {band:.3} Hz, {accuracy:.1e} \
         demanded: retain more freedoms, or keep the structure whole"
    )]
    Reduction {
        /// Estimate of the error at the end of the band.
        estimate: f64,
        /// Accuracy demanded.
        accuracy: f64,
        /// End of the band, Hz.
        band: f64,
        /// Highest cut-off tried, Hz.
        cut_off: f64,
    },
}
