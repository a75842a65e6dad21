//! Symmetric sparse matrices, their factors and solves.
//!
//! - [`SymmetricMatrix`]: lower triangle by columns; matrices of one pattern share it.
//! - [`Symbolic`]: the order of elimination and the pattern of the factor, found once, used for every matrix
//!   of the same pattern.
//! - [`Factor`]: $LL^T$ of a positive definite matrix, $LDL^T$ of an indefinite one with the number of its
//!   negative eigenvalues; solves without allocation.
//! - [`free_motion`]: the motion that a structure without a factor is free to make.

mod factor;
mod motion;
mod ordering;
mod symbolic;

pub use factor::{Factor, Residual, SOLVE_COLUMNS};
pub use motion::free_motion;
pub use ordering::Ordering;
pub use symbolic::Symbolic;

use crate::FemError;
use std::sync::Arc;

/// Where the entries of the lower triangle stand.
#[derive(Debug, PartialEq, Eq)]
struct Pattern {
    start: Vec<usize>,
    row: Vec<usize>,
}

/// A symmetric matrix by its lower triangle, column by column, rows increasing, no entry twice.
///
/// Copies share their pattern; memory is 16 bytes an entry, and 8 for each further matrix of the same
/// pattern.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricMatrix {
    pattern: Arc<Pattern>,
    value: Vec<f64>,
}

impl SymmetricMatrix {
    /// Sum of entries (row, column, value); of a pair off the diagonal one of the two is given, either way.
    ///
    /// Entries that sum up to zero stay in the pattern. Entries of one place are summed in the order given.
    /// Cost: linear in the entries, besides the sort within each column. Errors: a row or column not below
    /// `size`, a value that is not finite.
    pub fn assemble(
        size: usize,
        entries: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, FemError> {
        let mut all = vec![];
        let mut end = vec![0; size + 1];
        for (row, column, value) in entries {
            if row >= size || column >= size {
                return Err(FemError::Entry { row, column, size });
            }
            if !value.is_finite() {
                return Err(FemError::NotFinite { row, column, value });
            }
            all.push((row.max(column), row.min(column), value));
            end[row.min(column) + 1] += 1;
        }
        for column in 0..size {
            end[column + 1] += end[column];
        }
        let mut sorted = vec![(0, 0.0); all.len()];
        for (row, column, value) in all {
            sorted[end[column]] = (row, value);
            end[column] += 1;
        }
        let (mut start, mut row, mut value) = (vec![0; size + 1], vec![], vec![]);
        for column in 0..size {
            let first = if column == 0 { 0 } else { end[column - 1] };
            let part = &mut sorted[first..end[column]];
            // stable: what stands in one place keeps its order
            part.sort_by_key(|&(row, _)| row);
            for &(r, v) in part.iter() {
                if row.len() > start[column] && row.last() == Some(&r) {
                    *value.last_mut().expect("an entry came before") += v;
                } else {
                    row.push(r);
                    value.push(v);
                }
            }
            start[column + 1] = row.len();
        }
        Ok(Self { pattern: Arc::new(Pattern { start, row }), value })
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.pattern.start.len() - 1
    }

    /// Where each column begins in [`Self::rows`] and [`Self::values`], and the end.
    pub fn starts(&self) -> &[usize] {
        &self.pattern.start
    }

    /// Rows of the entries.
    pub fn rows(&self) -> &[usize] {
        &self.pattern.row
    }

    /// Values of the entries.
    pub fn values(&self) -> &[f64] {
        &self.value
    }

    /// Values of the entries, to be changed; the pattern stays.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.value
    }

    /// Whether two matrices have their entries in the same places (at once where they share the pattern).
    pub fn same_pattern(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.pattern, &other.pattern) || self.pattern == other.pattern
    }

    /// Product $y = A x$.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.multiply_add(1.0, x, y);
    }

    /// Product $y \leftarrow y + \alpha A x$; `x` and `y` of [`Self::size`].
    pub fn multiply_add(&self, alpha: f64, x: &[f64], y: &mut [f64]) {
        let (start, rows) = (self.starts(), self.rows());
        for column in 0..self.size() {
            let scaled = alpha * x[column];
            let mut sum = 0.0;
            for k in start[column]..start[column + 1] {
                let (row, value) = (rows[k], self.value[k]);
                if row == column {
                    sum += value * x[row];
                } else {
                    y[row] += value * scaled;
                    sum += value * x[row];
                }
            }
            y[column] += alpha * sum;
        }
    }

    /// Quadratic form $x^T A x$.
    pub fn quadratic(&self, x: &[f64]) -> f64 {
        let (start, rows) = (self.starts(), self.rows());
        let mut total = 0.0;
        for column in 0..self.size() {
            let mut sum = 0.0;
            for k in start[column]..start[column + 1] {
                let twice = if rows[k] == column { 1.0 } else { 2.0 };
                sum += twice * self.value[k] * x[rows[k]];
            }
            total += sum * x[column];
        }
        total
    }

    /// Diagonal, zero where no entry stands.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.size())
            .map(|column| {
                // rows increase: the diagonal, if any, comes first
                let k = self.starts()[column];
                if k < self.starts()[column + 1] && self.rows()[k] == column { self.value[k] } else { 0.0 }
            })
            .collect()
    }

    /// Sum $\alpha A + \beta B$ on the union of both patterns, every diagonal entry included.
    ///
    /// Where `b` has the pattern of `a`, with the whole diagonal, the sum shares it. Errors: sizes differ.
    pub fn combine(alpha: f64, a: &Self, beta: f64, b: &Self) -> Result<Self, FemError> {
        if a.size() != b.size() {
            return Err(FemError::Length { what: "second matrix", found: b.size(), expected: a.size() });
        }
        let diagonal = (0..a.size()).all(|c| {
            let k = a.starts()[c];
            k < a.starts()[c + 1] && a.rows()[k] == c
        });
        if diagonal && a.same_pattern(b) {
            let value = a.value.iter().zip(&b.value).map(|(x, y)| alpha * x + beta * y).collect();
            return Ok(Self { pattern: a.pattern.clone(), value });
        }
        let entries = a.value.len().max(b.value.len());
        let (mut start, mut row, mut value) =
            (vec![0; a.size() + 1], Vec::with_capacity(entries), Vec::with_capacity(entries));
        for column in 0..a.size() {
            let (mut i, mut j) = (a.starts()[column], b.starts()[column]);
            let (end_a, end_b) = (a.starts()[column + 1], b.starts()[column + 1]);
            let first_a = if i < end_a { a.rows()[i] } else { usize::MAX };
            let first_b = if j < end_b { b.rows()[j] } else { usize::MAX };
            if first_a.min(first_b) != column {
                row.push(column);
                value.push(0.0);
            }
            while i < end_a || j < end_b {
                let row_a = if i < end_a { a.rows()[i] } else { usize::MAX };
                let row_b = if j < end_b { b.rows()[j] } else { usize::MAX };
                let mut sum = 0.0;
                if row_a <= row_b {
                    sum += alpha * a.value[i];
                    i += 1;
                }
                if row_b <= row_a {
                    sum += beta * b.value[j];
                    j += 1;
                }
                row.push(row_a.min(row_b));
                value.push(sum);
            }
            start[column + 1] = row.len();
        }
        Ok(Self { pattern: Arc::new(Pattern { start, row }), value })
    }

    /// Principal part: rows and columns `keep`, in that order.
    ///
    /// Errors: an index not below [`Self::size`] or given twice.
    pub fn principal(&self, keep: &[usize]) -> Result<Self, FemError> {
        let place = self.places(keep)?;
        let entries = (0..self.size()).flat_map(|column| {
            let place = &place;
            (self.starts()[column]..self.starts()[column + 1])
                .filter_map(move |k| Some((place[self.rows()[k]]?, place[column]?, self.value[k])))
        });
        Self::assemble(keep.len(), entries)
    }

    /// Entries (row, column, value) of the block of rows `rows` and columns `columns`, numbered within them;
    /// the two lists must have no index in common.
    ///
    /// Errors: an index not below [`Self::size`] or given twice.
    pub fn block(&self, rows: &[usize], columns: &[usize]) -> Result<Vec<(usize, usize, f64)>, FemError> {
        let (in_row, in_column) = (self.places(rows)?, self.places(columns)?);
        let mut entries = vec![];
        for column in 0..self.size() {
            for k in self.starts()[column]..self.starts()[column + 1] {
                let row = self.rows()[k];
                if let (Some(i), Some(j)) = (in_row[row], in_column[column]) {
                    entries.push((i, j, self.value[k]));
                } else if let (Some(i), Some(j)) = (in_row[column], in_column[row]) {
                    entries.push((i, j, self.value[k]));
                }
            }
        }
        Ok(entries)
    }

    /// Place of every row in a list.
    fn places(&self, list: &[usize]) -> Result<Vec<Option<usize>>, FemError> {
        let mut place = vec![None; self.size()];
        for (i, &row) in list.iter().enumerate() {
            match place.get_mut(row) {
                Some(slot @ None) => *slot = Some(i),
                Some(Some(_)) => return Err(FemError::FreedomTwice { freedom: row }),
                None => return Err(FemError::Entry { row, column: row, size: self.size() }),
            }
        }
        Ok(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_of_one_place_are_summed_and_both_triangles_multiply() {
        let entries = [(0, 0, 2.0), (1, 0, -1.0), (0, 1, -1.0), (1, 1, 3.0), (2, 2, 4.0)];
        let a = SymmetricMatrix::assemble(3, entries).unwrap();
        let mut y = [0.0; 3];
        a.multiply(&[1.0, 2.0, 3.0], &mut y);
        assert_eq!(y, [-2.0, 4.0, 12.0]);
        assert_eq!(a.values().len(), 4);
        assert_eq!(a.quadratic(&[1.0, 2.0, 3.0]), 42.0);
        assert_eq!(a.diagonal(), [2.0, 3.0, 4.0]);
    }

    #[test]
    fn an_entry_outside_or_not_finite_is_refused() {
        let error = SymmetricMatrix::assemble(2, [(2, 0, 1.0)]).unwrap_err();
        assert_eq!(error, FemError::Entry { row: 2, column: 0, size: 2 });
        let error = SymmetricMatrix::assemble(2, [(1, 0, f64::NAN)]).unwrap_err();
        assert!(matches!(error, FemError::NotFinite { row: 1, column: 0, .. }));
    }

    #[test]
    fn a_sum_stands_on_both_patterns_and_on_the_whole_diagonal() {
        let a = SymmetricMatrix::assemble(4, [(0, 0, 1.0), (1, 0, 2.0), (3, 3, 5.0)]).unwrap();
        let b = SymmetricMatrix::assemble(4, [(1, 1, 3.0), (3, 0, 4.0), (3, 3, 1.0)]).unwrap();
        let sum = SymmetricMatrix::combine(2.0, &a, -1.0, &b).unwrap();
        assert_eq!(sum.starts(), [0, 3, 4, 5, 6]);
        assert_eq!(sum.rows(), [0, 1, 3, 1, 2, 3]);
        assert_eq!(sum.values(), [2.0, 4.0, -4.0, -3.0, 0.0, 9.0]);
    }

    #[test]
    fn parts_hold_what_stands_in_either_triangle() {
        let entries = [(0, 0, 1.0), (1, 0, 2.0), (2, 1, 3.0), (2, 2, 4.0), (1, 1, 5.0)];
        let a = SymmetricMatrix::assemble(3, entries).unwrap();
        let part = a.principal(&[2, 1]).unwrap();
        assert_eq!((part.rows(), part.values()), (&[0, 1, 1][..], &[4.0, 3.0, 5.0][..]));
        let mut block = a.block(&[0, 2], &[1]).unwrap();
        block.sort_by_key(|e| e.0);
        assert_eq!(block, [(0, 0, 2.0), (1, 0, 3.0)]);
        assert_eq!(a.principal(&[1, 1]).unwrap_err(), FemError::FreedomTwice { freedom: 1 });
    }
}
