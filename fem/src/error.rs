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
}
