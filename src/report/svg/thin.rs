//! Thinning: a long line drawn with no more points than the screen can show, its peaks kept.

use std::fmt::Write as _;

/// Columns per pixel that are told apart.
const COLUMNS_PER_PIXEL: f64 = 1.0;

/// SVG path commands of a line through pixel points with non-decreasing `x`.
///
/// Within each pixel the first, lowest, highest and last point stay, in their order, so that no
/// peak is lost. The line breaks at points that are not finite.
pub(super) fn line(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    let mut column = Column::default();
    let mut pen_down = false;
    for (x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            column.flush(&mut path, &mut pen_down);
            pen_down = false;
            continue;
        }
        let number = (x * COLUMNS_PER_PIXEL).floor();
        if column.count > 0 && number != column.number {
            column.flush(&mut path, &mut pen_down);
        }
        column.number = number;
        column.add((x, y));
    }
    column.flush(&mut path, &mut pen_down);
    path
}

#[derive(Default)]
struct Column {
    number: f64,
    count: usize,
    first: (f64, f64),
    last: (f64, f64),
    low: (usize, (f64, f64)),
    high: (usize, (f64, f64)),
}

impl Column {
    fn add(&mut self, point: (f64, f64)) {
        if self.count == 0 {
            self.first = point;
            self.low = (0, point);
            self.high = (0, point);
        }
        if point.1 < self.low.1.1 {
            self.low = (self.count, point);
        }
        if point.1 > self.high.1.1 {
            self.high = (self.count, point);
        }
        self.last = point;
        self.count += 1;
    }

    fn flush(&mut self, path: &mut String, pen_down: &mut bool) {
        if self.count == 0 {
            return;
        }
        let (early, late) =
            if self.low.0 <= self.high.0 { (self.low, self.high) } else { (self.high, self.low) };
        let end = self.count - 1;
        let mut put = |(x, y): (f64, f64)| {
            let command = if *pen_down { 'L' } else { 'M' };
            *pen_down = true;
            let _ = write!(path, "{command}{x:.1} {y:.1}");
        };
        put(self.first);
        if early.0 != 0 && early.0 != end {
            put(early.1);
        }
        if late.0 != 0 && late.0 != end && late.0 != early.0 {
            put(late.1);
        }
        if end != 0 {
            put(self.last);
        }
        self.count = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_survive_and_the_path_is_short() {
        let n = 100_000;
        let path = line((0..n).map(|i| {
            let y = if i == 51_234 { -7.0 } else { (i as f64 * 0.1).sin() };
            (i as f64 * 800.0 / n as f64, y)
        }));
        assert!(path.contains("-7.0"), "the peak is lost");
        assert!(path.matches('L').count() < 4 * 801);
    }

    #[test]
    fn breaks_at_missing_values() {
        let path = line([(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0), (3.0, 2.0)].into_iter());
        assert_eq!(path, "M0.0 1.0M2.0 1.0L3.0 2.0");
    }
}
