//! Symmetric sparse matrices.

use crate::FemError;

/// A symmetric matrix by its lower triangle, column by column, rows increasing, no entry twice.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricMatrix {
    start: Vec<usize>,
    row: Vec<usize>,
    value: Vec<f64>,
}

impl SymmetricMatrix {
    /// Sum of entries (row, column, value); of a pair off the diagonal one of the two is given, either way.
    ///
    /// Entries that sum up to zero stay in the pattern. Errors: a row or column not below `size`.
    pub fn assemble(
        size: usize,
        entries: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, FemError> {
        let mut all = vec![];
        for (row, column, value) in entries {
            if row >= size || column >= size {
                return Err(FemError::Entry { row, column, size });
            }
            all.push((row.min(column), row.max(column), value));
        }
        // stable: entries of one place are summed in the order given
        all.sort_by_key(|&(column, row, _)| (column, row));
        let mut matrix = Self { start: vec![0; size + 1], row: vec![], value: vec![] };
        let mut last = None;
        for (column, row, value) in all {
            if last == Some((column, row)) {
                *matrix.value.last_mut().expect("an entry came before") += value;
                continue;
            }
            last = Some((column, row));
            matrix.row.push(row);
            matrix.value.push(value);
            matrix.start[column + 1] += 1;
        }
        for column in 0..size {
            matrix.start[column + 1] += matrix.start[column];
        }
        Ok(matrix)
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.start.len() - 1
    }

    /// Where each column begins in [`Self::rows`] and [`Self::values`], and the end.
    pub fn starts(&self) -> &[usize] {
        &self.start
    }

    /// Rows of the entries.
    pub fn rows(&self) -> &[usize] {
        &self.row
    }

    /// Values of the entries.
    pub fn values(&self) -> &[f64] {
        &self.value
    }

    /// Product $y = A x$.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for column in 0..self.size() {
            let mut sum = 0.0;
            for k in self.start[column]..self.start[column + 1] {
                let (row, value) = (self.row[k], self.value[k]);
                y[row] += value * x[column];
                if row != column {
                    sum += value * x[row];
                }
            }
            y[column] += sum;
        }
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
    }

    #[test]
    fn an_entry_outside_is_refused() {
        let error = SymmetricMatrix::assemble(2, [(2, 0, 1.0)]).unwrap_err();
        assert_eq!(error, FemError::Entry { row: 2, column: 0, size: 2 });
    }
}
