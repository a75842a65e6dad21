//! Heights of the ground's surface on a regular grid, from a text file.

use std::fs;
use std::path::Path;

use super::diagnostic::{plain, rounded};
use super::files;

/// Largest file of heights, bytes: some two million points.
const MAX_BYTES: u64 = 64 << 20;

/// Heights of the surface above z = 0 on a grid of rising x and y, at dimension 2 of x alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Topography {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Shape `[y.len(), x.len()]`, x fastest, m.
    z: Vec<f64>,
}

/// What is wrong with a file of heights, and what to do.
pub(super) type Problem = (String, String);

impl Topography {
    /// Reads lines `x y z` (at dimension 2 `x z`), in any order.
    ///
    /// Blank lines, what follows a `#`, and a first line without any number are passed over; numbers stand between blanks,
    /// commas or semicolons. Coordinates nearer than 1e-9 of the grid's extent are taken for one.
    pub(super) fn read(path: &Path, dimension: usize) -> Result<Self, Problem> {
        let size = files::regular_file(path, "").map_err(|p| (p.message, p.help.unwrap_or_default()))?;
        let shown = path.display();
        if size > MAX_BYTES {
            let help =
                "take fewer points: the mesh follows the surface no finer than its elements".to_owned();
            return Err((format!("{shown}: {size} bytes of heights are too many (limit {MAX_BYTES})"), help));
        }
        let text = fs::read_to_string(path)
            .map_err(|e| (format!("{shown} cannot be read as text: {e}"), String::new()))?;
        let points = points(&text, dimension).map_err(|(m, help)| (format!("{shown}{m}"), help))?;
        Self::from_points(&points).map_err(|(m, help)| (format!("{shown}: {m}"), help))
    }

    /// Puts points x, y, z on their grid.
    fn from_points(points: &[[f64; 3]]) -> Result<Self, Problem> {
        let (x, y) = (axis(points.iter().map(|p| p[0])), axis(points.iter().map(|p| p[1])));
        let help = "give every x with every y, each pair once".to_owned();
        if x.len() < 2 || (y.len() < 2 && points.iter().any(|p| p[1] != 0.0)) {
            let message =
                "the heights lie on one line, expected a grid of two or more values along each axis";
            return Err((message.to_owned(), help));
        }
        let mut z = vec![f64::NAN; x.len().saturating_mul(y.len()).min(4 * points.len())];
        let grid = format!("a grid of {} x by {} y", x.len(), y.len());
        if z.len() < x.len() * y.len() {
            let message = format!("{} points are too few for {grid}", points.len());
            return Err((message, help));
        }
        for p in points {
            let height = &mut z[nearest(&y, p[1]) * x.len() + nearest(&x, p[0])];
            if !height.is_nan() {
                let message =
                    format!("the point x = {}, y = {} stands there twice", plain(p[0]), plain(p[1]));
                return Err((message, help));
            }
            *height = p[2];
        }
        if let Some(gap) = z.iter().position(|z| z.is_nan()) {
            let (i, j) = (gap % x.len(), gap / x.len());
            let message = format!("no height at x = {}, y = {}, expected {grid}", plain(x[i]), plain(y[j]));
            return Err((message, help));
        }
        Ok(Self { x, y, z })
    }

    /// Values of x, rising, m.
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// Values of y, rising, m; 0 alone at dimension 2.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// Heights, shape `[y.len(), x.len()]`, x fastest, m.
    pub fn heights(&self) -> &[f64] {
        &self.z
    }

    /// Height of the surface at a place, bilinear between the grid's points and constant beyond its edge, m.
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let ((i, i1, s), (j, j1, t)) = (cell(&self.x, x), cell(&self.y, y));
        let n = self.x.len();
        let along = |j: usize| (1.0 - s) * self.z[j * n + i] + s * self.z[j * n + i1];
        (1.0 - t) * along(j) + t * along(j1)
    }

    /// Least and greatest height, m.
    pub fn range(&self) -> (f64, f64) {
        self.z.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(*z), b.max(*z)))
    }

    /// What of a range the grid leaves out along an axis (0 = x, 1 = y), in words.
    pub(super) fn uncovered(&self, axis: usize, range: [f64; 2]) -> Option<String> {
        let values = if axis == 0 { &self.x } else { &self.y };
        let (first, last) = (values[0], values[values.len() - 1]);
        let slack = 1e-9 * (range[1] - range[0]);
        (range[0] < first - slack || range[1] > last + slack).then(|| {
            let name = if axis == 0 { "x" } else { "y" };
            format!(
                "the heights reach from {name} = {} m to {} m, the domain from {} m to {} m",
                rounded(first),
                rounded(last),
                plain(range[0]),
                plain(range[1])
            )
        })
    }
}

/// The points of a text; a message begins with the line's number.
fn points(text: &str, dimension: usize) -> Result<Vec<[f64; 3]>, Problem> {
    let expected = if dimension == 2 { "two numbers x z" } else { "three numbers x y z" };
    let mut points = Vec::new();
    let mut words_allowed = true;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim_start_matches('\u{feff}').split('#').next().unwrap_or_default();
        let fields: Vec<&str> = line
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .filter(|f| !f.is_empty())
            .collect();
        if fields.is_empty() {
            continue;
        }
        let numbers: Vec<Option<f64>> =
            fields.iter().map(|f| f.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let header = numbers.iter().all(Option::is_none) && words_allowed;
        words_allowed = false;
        match numbers[..] {
            _ if header => {}
            [Some(x), Some(z)] if dimension == 2 => points.push([x, 0.0, z]),
            [Some(x), Some(y), Some(z)] if dimension == 3 => points.push([x, y, z]),
            _ => {
                let found: String = line.trim().chars().take(40).collect();
                let help = "write one point a line, in metres with a decimal point".to_owned();
                return Err((format!(":{number}: expected {expected}, found `{found}`"), help));
            }
        }
    }
    if points.is_empty() {
        let help = format!("write lines of {expected}");
        return Err((": there is no point in the file".to_owned(), help));
    }
    Ok(points)
}

/// Sorted values without repetition.
fn axis(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let extent = values.last().unwrap_or(&0.0) - values.first().unwrap_or(&0.0);
    values.dedup_by(|b, a| *b - *a <= 1e-9 * extent);
    values
}

/// Index of the value nearest to `x` from below, up to the tolerance of [`axis`].
fn nearest(values: &[f64], x: f64) -> usize {
    let after = values.partition_point(|v| *v <= x);
    after.saturating_sub(1)
}

/// The two neighbours of `x` and the share of the second.
fn cell(values: &[f64], x: f64) -> (usize, usize, f64) {
    let last = values.len() - 1;
    let high = values.partition_point(|v| *v <= x).clamp(1.min(last), last);
    let low = high.saturating_sub(1);
    if low == high {
        return (low, high, 0.0);
    }
    (low, high, ((x - values[low]) / (values[high] - values[low])).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn read(text: &str, dimension: usize) -> Result<Topography, Problem> {
        Topography::from_points(&points(text, dimension)?)
    }

    #[test]
    fn a_bilinear_surface_is_met_everywhere() {
        let height = |x: f64, y: f64| 2.0 + 0.5 * x - 3.0 * y + 0.25 * x * y;
        let mut text = "x, y, z\n# a grid of 3 by 2, its last point first\n\n".to_owned();
        for y in [0.4, -0.1] {
            for x in [7.0, 1.0, 2.5] {
                text.push_str(&format!("{x}; {y},\t{} # m\n", height(x, y)));
            }
        }
        let t = read(&text, 3).expect("heights");
        assert_eq!((t.x(), t.y()), (&[1.0, 2.5, 7.0][..], &[-0.1, 0.4][..]));
        for (x, y) in [(1.0, -0.1), (7.0, 0.4), (2.5, 0.0), (3.3, 0.31), (1.2, 0.4)] {
            assert_abs_diff_eq!(t.height(x, y), height(x, y), epsilon = 1e-12);
        }
        assert_abs_diff_eq!(t.height(100.0, -9.0), height(7.0, -0.1), epsilon = 1e-12);
        assert_abs_diff_eq!(t.range().0, height(1.0, 0.4), epsilon = 1e-12);
        assert_abs_diff_eq!(t.range().1, height(7.0, -0.1), epsilon = 1e-12);
        assert!(t.uncovered(0, [1.0, 7.0]).is_none());
        assert!(t.uncovered(1, [-0.1, 0.5]).is_some_and(|m| m.contains("to 0.4 m, the domain")));
    }

    #[test]
    fn a_section_has_lines_of_two() {
        let t = read("0 1\n1e-3 3\n", 2).expect("heights");
        assert_abs_diff_eq!(t.height(5e-4, 123.0), 2.0, epsilon = 1e-12);
        assert_eq!(t.y(), [0.0]);
    }

    #[test]
    fn what_is_no_grid_is_refused_with_its_line_or_point() {
        for (text, dimension, expected) in [
            ("", 3, ": there is no point"),
            ("x y z\n", 3, ": there is no point"),
            ("0 0 1\n0 1\n", 3, ":2: expected three numbers x y z, found `0 1`"),
            ("0 0 1\n", 2, ":1: expected two numbers x z"),
            ("0 0\nx z\n", 2, ":2: expected two numbers"),
            ("0 nan\n1 0\n", 2, ":1: expected two numbers"),
            ("0 0 1\n1 0 1\n0 1 1\n", 3, "no height at x = 1, y = 1, expected a grid of 2 x by 2 y"),
            ("0 0 1\n1 0 1\n0 1 1\n1 1 1\n1 1 2", 3, "the point x = 1, y = 1 stands there twice"),
            ("0 0 1\n1 2 1\n3 4 1\n5 6 1\n7 8 1\n", 3, "5 points are too few for a grid of 5 x by 5 y"),
            ("0 5 1\n1 5 1\n", 3, "the heights lie on one line"),
            ("0 5\n0 5\n", 2, "the heights lie on one line"),
        ] {
            let (message, _) = read(text, dimension).expect_err(text);
            assert!(message.contains(expected), "{text:?}: {message}");
        }
    }
}
