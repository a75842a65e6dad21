//! Tables of numbers behind the figures, as comma-separated text.

use std::fmt::Write as _;

/// A table under construction: named columns of numbers, which may differ in length.
#[derive(Debug, Default)]
pub(super) struct Table<'a> {
    columns: Vec<(String, std::borrow::Cow<'a, [f64]>)>,
}

impl<'a> Table<'a> {
    /// Adds a column; the name ends in the unit, for instance `period_s`.
    pub(super) fn column(
        mut self,
        name: impl Into<String>,
        values: impl Into<std::borrow::Cow<'a, [f64]>>,
    ) -> Self {
        self.columns.push((name.into(), values.into()));
        self
    }

    /// The text: one header line, then a line per row; a value that is missing or not a number stays empty.
    pub(super) fn to_csv(&self) -> String {
        let rows = self.columns.iter().map(|(_, v)| v.len()).max().unwrap_or(0);
        let mut text = String::with_capacity(64 + rows * self.columns.len() * 14);
        for (number, (name, _)) in self.columns.iter().enumerate() {
            if number > 0 {
                text.push(',');
            }
            if name.contains([',', '"', '\n', '\r']) {
                let _ = write!(text, "\"{}\"", name.replace('"', "\"\"").replace(['\n', '\r'], " "));
            } else {
                text.push_str(name);
            }
        }
        text.push('\n');
        for row in 0..rows {
            for (number, (_, values)) in self.columns.iter().enumerate() {
                if number > 0 {
                    text.push(',');
                }
                match values.get(row) {
                    Some(value) if value.is_finite() => {
                        let _ = write!(text, "{value:.7e}");
                    }
                    _ => {}
                }
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ragged_and_missing_values_stay_empty() {
        let csv = Table::default().column("time_s", vec![0.0, 0.5]).column("a, b", vec![f64::NAN]).to_csv();
        assert_eq!(csv, "time_s,\"a, b\"\n0.0000000e0,\n5.0000000e-1,\n");
    }
}
