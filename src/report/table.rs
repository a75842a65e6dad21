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
        for part in self.parts(rows) {
            text.push_str(&part);
        }
        text
    }

    /// The lines, in pieces that were written side by side where they are many.
    fn parts(&self, rows: usize) -> Vec<String> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let share = rows.div_ceil(cores).max(MANY_ROWS);
        std::thread::scope(|scope| {
            let ranges = (0..rows).step_by(share).map(|first| first..(first + share).min(rows));
            let writers: Vec<_> = ranges.map(|range| scope.spawn(|| self.lines(range))).collect();
            writers
                .into_iter()
                .map(|writer| writer.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause)))
                .collect()
        })
    }

    fn lines(&self, rows: std::ops::Range<usize>) -> String {
        let mut text = String::with_capacity(rows.len() * self.columns.len() * 15);
        for row in rows {
            for (number, (_, values)) in self.columns.iter().enumerate() {
                if number > 0 {
                    text.push(',');
                }
                match values.get(row) {
                    Some(value) if value.is_finite() => scientific(&mut text, *value),
                    _ => {}
                }
            }
            text.push('\n');
        }
        text
    }
}

/// Rows below which one thread writes them all.
const MANY_ROWS: usize = 20_000;

/// The powers of ten that are exact in f64.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Writes `value` as `{:.7e}` does, digit for digit, several times faster.
///
/// Eight digits are an integer below 10⁸, found by one product with an exact power of ten. Where that
/// product lies so close to a tie or to a change of exponent that its rounding could decide, and for
/// numbers too small or too large for it, the standard formatter writes.
fn scientific(text: &mut String, value: f64) {
    let size = value.abs();
    // log₁₀ 2 = 0.301 = 77/256: at most one off, which is put right below.
    let binary = ((size.to_bits() >> 52) as i32) - 1023;
    let mut exponent = (binary * 77) >> 8;
    let scaled = |exponent: i32| {
        let shift = 7 - exponent;
        let power = POWERS.get(shift.unsigned_abs() as usize)?;
        Some(if shift < 0 { size / power } else { size * power })
    };
    match scaled(exponent) {
        Some(digits) if digits >= 1e8 => exponent += 1,
        Some(digits) if digits < 1e7 => exponent -= 1,
        _ => {}
    }
    let digits = scaled(exponent).filter(|digits| {
        // Below 10⁸ the conversion to an integer and back is the floor.
        *digits >= 1e7 && *digits < 99_999_999.0 && (digits - f64::from(*digits as u32) - 0.5).abs() > 1e-6
    });
    let Some(digits) = digits else {
        let _ = write!(text, "{value:.7e}");
        return;
    };
    // Sign, one figure, the point, seven figures, e, sign and at most two figures of the exponent.
    let mut bytes = [b'0'; 16];
    let mut rest = (digits + 0.5) as u32;
    for place in (3..10).rev() {
        bytes[place] += (rest % 10) as u8;
        rest /= 10;
    }
    bytes[1] += rest as u8;
    (bytes[0], bytes[2], bytes[10]) = (b'-', b'.', b'e');
    let mut end = 11;
    let mut put = |byte: u8| {
        bytes[end] = byte;
        end += 1;
    };
    if exponent < 0 {
        put(b'-');
    }
    let exponent = exponent.unsigned_abs() as u8;
    if exponent > 9 {
        put(b'0' + exponent / 10);
    }
    put(b'0' + exponent % 10);
    let first = usize::from(value >= 0.0);
    text.push_str(std::str::from_utf8(&bytes[first..end]).unwrap_or_default());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_standard_formatter() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let edges = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            10.0,
            9.999_999_95,
            9.999_999_949_999,
            99_999_999.5,
            0.1,
            1e-5,
            1e22,
            1e23,
            1e-15,
            1e-16,
            1.234_567_85,
            5e-324,
            f64::MAX,
            0.001,
            1e8,
            1e7,
            999_999.999_999,
            0.005,
            1199.995,
        ];
        let wide = (0..20_000).map(|_| (random() - 0.5) * 10_f64.powf(60.0 * random() - 30.0));
        let grid = (0..20_000).map(|i| f64::from(i) * 0.005);
        let near = (-60..60).flat_map(|i| {
            let power = 10_f64.powi(i / 4);
            [power, f64::from_bits(power.to_bits() + 1), f64::from_bits(power.to_bits() - 1)]
        });
        for value in wide.collect::<Vec<_>>().into_iter().chain(edges).chain(grid).chain(near) {
            let mut text = String::new();
            scientific(&mut text, value);
            assert_eq!(text, format!("{value:.7e}"));
        }
    }

    #[test]
    fn pieces_join_to_the_whole() {
        let rows = 2 * MANY_ROWS + 17;
        let values: Vec<f64> = (0..rows).map(|i| i as f64).collect();
        let csv = Table::default().column("n", values.as_slice()).to_csv();
        let wanted: String = values.iter().map(|value| format!("{value:.7e}\n")).collect();
        assert!(csv == format!("n\n{wanted}"));
    }

    #[test]
    fn ragged_and_missing_values_stay_empty() {
        let csv = Table::default().column("time_s", vec![0.0, 0.5]).column("a, b", vec![f64::NAN]).to_csv();
        assert_eq!(csv, "time_s,\"a, b\"\n0.0000000e0,\n5.0000000e-1,\n");
    }
}
