//! The regular grid of `field.nc`.

/// Coordinates of a regular grid, m, each increasing; `y` is empty for a section in x–z.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Grid {
    /// Along x.
    pub x: Vec<f64>,
    /// Along y; empty for a section.
    pub y: Vec<f64>,
    /// Along z, upwards.
    pub z: Vec<f64>,
}

impl Grid {
    /// A grid of the given spacing over a box, centred in it: along each axis as many points as fit.
    ///
    /// - `low`, `high`: corners of the box, m; - `spacing`: m; - `dimension`: 2 leaves y out.
    ///
    /// An extent below half a millionth of the spacing counts as none and gets one point.
    #[must_use]
    pub fn over(low: [f64; 3], high: [f64; 3], spacing: f64, dimension: usize) -> Self {
        let along = |axis: usize| -> Vec<f64> {
            let extent = high[axis] - low[axis];
            // An extent of 10 m holds 11 points 1 m apart, whatever the last bit of it says.
            let steps = (extent / spacing * (1.0 + 1e-9) + 1e-6).floor().max(0.0);
            let first = low[axis] + 0.5 * (extent - steps * spacing);
            (0..=steps as usize).map(|i| first + i as f64 * spacing).collect()
        };
        Self { x: along(0), y: if dimension == 2 { vec![] } else { along(1) }, z: along(2) }
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.x.len() * self.y.len().max(usize::from(!self.x.is_empty())) * self.z.len()
    }

    /// All points in the order of a row's values: x fastest, z slowest; y = 0 in a section.
    pub fn iter(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        const SECTION: &[f64] = &[0.0];
        let y = if self.y.is_empty() { SECTION } else { &self.y };
        self.z.iter().flat_map(move |&z| y.iter().flat_map(move |&y| self.x.iter().map(move |&x| [x, y, z])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fit_into_the_box_at_any_scale() {
        for scale in [1e-3, 1.0, 1e5] {
            let high = [1.0 * scale, 0.55 * scale, 0.3 * scale];
            let grid = Grid::over([0.0; 3], high, 0.1 * scale, 3);
            assert_eq!([grid.x.len(), grid.y.len(), grid.z.len()], [11, 6, 4]);
            assert!((grid.y[0] - 0.025 * scale).abs() < 1e-12 * scale);
            assert!((grid.x[10] - scale).abs() < 1e-12 * scale);
            assert_eq!(grid.iter().count(), grid.points());
            let section = Grid::over([0.0; 3], high, 0.1 * scale, 2);
            assert_eq!((section.points(), section.iter().count()), (44, 44));
        }
        assert_eq!(Grid::default().points(), 0);
    }
}
