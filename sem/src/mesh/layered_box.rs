//! The built-in mesh: a box of horizontal layers, with topography on top.

use super::{Boundary, Mesh, Side, axes};
use crate::SemError;

/// Least share of the moved layers' thickness that must remain under the surface.
pub const LEAST_REMAINING: f64 = 0.2;

/// A layer of a [`LayeredBox`].
#[derive(Debug, Clone, PartialEq)]
pub struct BoxLayer {
    /// Name, which its material takes.
    pub name: String,
    /// Thickness, m.
    pub thickness: f64,
    /// Elements over the thickness, at least 1.
    pub elements: usize,
}

impl BoxLayer {
    /// A layer of as few equal elements as are no higher than asked.
    pub fn with_height(name: &str, thickness: f64, element_height: f64) -> Self {
        Self { name: name.into(), thickness, elements: count(thickness, element_height) }
    }
}

/// Elements of a length no longer than `size`: the quotient rounded up, but 3.000000001 counts as 3.
/// 0 where an argument is not positive and finite.
pub(crate) fn count(length: f64, size: f64) -> usize {
    let quotient = length / size;
    if !(length > 0.0 && size > 0.0 && quotient.is_finite()) {
        return 0;
    }
    ((quotient * (1.0 - 1e-9)).ceil() as usize).max(1)
}

/// Description of a box of layers. The surface lies at z = 0, the layers follow it downwards.
///
/// Layer interfaces lie on element faces. Elements are as wide as `element_width` or a little less, and
/// in each layer of one height. Sides are named `top`, `bottom`, `x_min`, `x_max` and at D = 3 `y_min`,
/// `y_max`; materials have the layers' names and order, one for each layer.
///
/// ```text
///        z = topography(x, y)
///      __________      ____  top
///     |__|__|__|_‾‾‾‾‾‾_|__|           the moved layers take up the topography
///     |__|__|__|__|__|__|__|  flat interface
///     |__|__|__|__|__|__|__|
///                             bottom
/// ```
#[derive(Clone, Copy)]
pub struct LayeredBox<'a> {
    /// D: 2 (a section in x–z) or 3.
    pub dimension: usize,
    /// Least and greatest x, m.
    pub x: (f64, f64),
    /// Least and greatest y, m; not used at D = 2.
    pub y: (f64, f64),
    /// Layers from the surface down.
    pub layers: &'a [BoxLayer],
    /// Greatest width of an element along x and y, m.
    pub element_width: f64,
    /// Height of the surface above z = 0 at x, y, m (y = 0 at D = 2); `None` is flat.
    pub topography: Option<&'a dyn Fn(f64, f64) -> f64>,
    /// How many layers from the top take up the topography; usually 1, and 0 counts as 1. Heights inside them change in
    /// proportion, so that the interfaces between them follow the surface; those below stay flat.
    pub moved_layers: usize,
    /// Order of the geometry: 1, or 2 for a surface that is curved inside an element.
    pub order: usize,
}

impl LayeredBox<'_> {
    /// Elements along x, y (1 at D = 2) and z. Errors as [`Self::mesh`], but for the topography.
    pub fn counts(&self) -> Result<[usize; 3], SemError> {
        if !(2..=3).contains(&self.dimension) {
            return Err(SemError::Dimension(self.dimension));
        }
        if !(1..=2).contains(&self.order) {
            return Err(SemError::GeometryOrder(self.order));
        }
        if !(self.element_width > 0.0 && self.element_width.is_finite()) {
            return Err(SemError::ElementWidth(self.element_width));
        }
        if self.layers.is_empty() {
            return Err(SemError::ElementCounts { found: 0, expected: 1 });
        }
        for l in self.layers {
            if !(l.thickness > 0.0 && l.thickness.is_finite()) {
                let (layer, value) = (l.name.clone(), l.thickness);
                return Err(SemError::Material { layer, key: "thickness", value, range: "> 0" });
            }
            if l.elements == 0 {
                let (layer, value) = (l.name.clone(), 0.0);
                return Err(SemError::Material { layer, key: "elements", value, range: "≥ 1" });
            }
        }
        let mut counts = [1; 3];
        for (axis, name, range) in [(0, 'x', self.x), (1, 'y', self.y)] {
            if axis == 1 && self.dimension == 2 {
                continue;
            }
            if !(range.1 > range.0 && range.0.is_finite() && range.1.is_finite()) {
                return Err(SemError::BoxRange { axis: name, min: range.0, max: range.1 });
            }
            counts[axis] = count(range.1 - range.0, self.element_width);
        }
        counts[2] = self.layers.iter().fold(0usize, |sum, l| sum.saturating_add(l.elements));
        let along = |&axis: &usize| counts[axis] as f64 * self.order as f64 + 1.0;
        let nodes: f64 = axes(self.dimension).iter().map(along).product();
        if nodes >= f64::from(u32::MAX) {
            return Err(SemError::TooManyElements { counts });
        }
        Ok(counts)
    }

    /// Meshes the box; elements run along x, then y, then up.
    ///
    /// Errors: a dimension, order, range, width, thickness or count out of range; more nodes than 32 bits
    /// number; a surface whose height is not finite, or that leaves less than [`LEAST_REMAINING`] of the
    /// moved layers' thickness.
    pub fn mesh(&self) -> Result<Mesh, SemError> {
        let counts = self.counts()?;
        let (nodes, lengths) = self.nodes(counts)?;
        let (elements, material) = self.elements(counts, lengths);
        Ok(Mesh {
            dimension: self.dimension,
            order: self.order,
            nodes,
            elements,
            material,
            materials: self.layers.iter().map(|l| l.name.clone()).collect(),
            boundaries: boundaries(self.dimension, counts),
        })
    }

    /// Geometric nodes, x fastest, then y, then up, and their number along each axis.
    fn nodes(&self, counts: [usize; 3]) -> Result<(Vec<[f64; 3]>, [usize; 3]), SemError> {
        let g = self.order;
        let flat = self.dimension == 2;
        let x = divide(self.x, counts[0] * g);
        let y = if flat { vec![0.0] } else { divide(self.y, counts[1] * g) };
        let (z, fixed) = self.levels();
        let floor = z[fixed];
        let mut nodes = Vec::with_capacity(x.len() * y.len() * z.len());
        let mut heights = Vec::with_capacity(x.len() * y.len());
        for &y in &y {
            for &x in &x {
                heights.push(self.height(x, y, floor)?);
            }
        }
        for (k, &z) in z.iter().enumerate() {
            let columns = y.iter().flat_map(|&y| x.iter().map(move |&x| (x, y)));
            // the share of the surface's height that a level takes: 1 at the top, 0 from the floor down
            let share = if k > fixed { 1.0 - z / floor } else { 0.0 };
            nodes.extend(columns.zip(&heights).map(|((x, y), height)| [x, y, z + share * height]));
        }
        Ok((nodes, [x.len(), y.len(), z.len()]))
    }

    /// Node levels of the flat box from the bottom up, and which of them is the base of the moved layers.
    fn levels(&self) -> (Vec<f64>, usize) {
        let mut interfaces = vec![0.0];
        for (k, l) in self.layers.iter().enumerate() {
            interfaces.push(interfaces[k] - l.thickness);
        }
        let moved = self.moved_layers.clamp(1, self.layers.len());
        let mut z = vec![interfaces[self.layers.len()]];
        let mut fixed = 0;
        for (k, l) in self.layers.iter().enumerate().rev() {
            if k + 1 == moved {
                fixed = z.len() - 1;
            }
            z.extend(divide((interfaces[k + 1], interfaces[k]), l.elements * self.order).drain(1..));
        }
        (z, fixed)
    }

    /// Height of the surface, checked against the floor of the moved layers.
    fn height(&self, x: f64, y: f64, floor: f64) -> Result<f64, SemError> {
        let Some(topography) = self.topography else { return Ok(0.0) };
        let height = topography(x, y);
        if !height.is_finite() {
            return Err(SemError::TopographyMissing { x, y });
        }
        if height < floor * (1.0 - LEAST_REMAINING) {
            let least = floor * (1.0 - LEAST_REMAINING);
            return Err(SemError::TopographyTooLow { x, y, height, floor, least });
        }
        Ok(height)
    }

    /// Geometric nodes and material of every element.
    fn elements(&self, counts: [usize; 3], lengths: [usize; 3]) -> (Vec<u32>, Vec<u32>) {
        let g = self.order;
        let deep = if self.dimension == 2 { 1 } else { g + 1 };
        let total: usize = counts.iter().product();
        let mut elements = Vec::with_capacity(total * (g + 1).pow(self.dimension as u32));
        let mut material = Vec::with_capacity(total);
        let layer_of = self.layers.iter().enumerate().rev();
        let layers = layer_of.flat_map(|(k, l)| std::iter::repeat_n(k as u32, l.elements));
        for (ez, layer) in layers.enumerate() {
            for ey in 0..counts[1] {
                for ex in 0..counts[0] {
                    material.push(layer);
                    for k in 0..=g {
                        for j in 0..deep {
                            let row = ((ez * g + k) * lengths[1] + ey * g + j) * lengths[0] + ex * g;
                            elements.extend((row..=row + g).map(|node| node as u32));
                        }
                    }
                }
            }
        }
        (elements, material)
    }
}

/// Equal division of a range, both ends exact.
fn divide(range: (f64, f64), count: usize) -> Vec<f64> {
    (0..=count)
        .map(|i| if i == count { range.1 } else { range.0 + (range.1 - range.0) * (i as f64 / count as f64) })
        .collect()
}

/// The box's sides, elements numbered along x, then y, then up.
fn boundaries(dimension: usize, counts: [usize; 3]) -> Vec<Boundary> {
    let up = dimension - 1;
    let mut sides = vec![("top", 2, up, true), ("bottom", 2, up, false), ("x_min", 0, 0, false)];
    sides.push(("x_max", 0, 0, true));
    if dimension == 3 {
        sides.extend([("y_min", 1, 1, false), ("y_max", 1, 1, true)]);
    }
    let named = |(name, axis, local, far): (&str, usize, usize, bool)| {
        let mut list = vec![];
        let at = if far { counts[axis] - 1 } else { 0 };
        let range = |a: usize| if a == axis { at..at + 1 } else { 0..counts[a] };
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    let element = ((k * counts[1] + j) * counts[0] + i) as u32;
                    list.push(Side { element, side: (2 * local + usize::from(far)) as u8 });
                }
            }
        }
        Boundary { name: name.into(), sides: list }
    };
    sides.into_iter().map(named).collect()
}

/// Heights on a regular grid, for the topography of a [`LayeredBox`]; bilinear between its points.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightGrid {
    origin: [f64; 2],
    spacing: [f64; 2],
    counts: [usize; 2],
    heights: Vec<f64>,
}

impl HeightGrid {
    /// A grid from its first point, spacing (m) and number of points along x and y; `heights` runs along x
    /// first, m. One point along y (a section) means the same height for every y, and likewise along x.
    ///
    /// Errors: no point, another number of heights than points, a spacing or height that is not finite,
    /// a spacing not above 0 where there is more than one point.
    pub fn new(
        origin: [f64; 2],
        spacing: [f64; 2],
        counts: [usize; 2],
        heights: Vec<f64>,
    ) -> Result<Self, SemError> {
        let expected = counts[0].saturating_mul(counts[1]);
        let spaced = (0..2).all(|a| counts[a] == 1 || spacing[a] > 0.0 && spacing[a].is_finite());
        let finite = origin.iter().chain(&heights).all(|v| v.is_finite());
        if expected == 0 || heights.len() != expected || !spaced || !finite {
            return Err(SemError::HeightGrid { found: heights.len(), counts, spacing });
        }
        Ok(Self { origin, spacing, counts, heights })
    }

    /// Height at x, y, m; not a number outside the grid (more than 1e-6 of a spacing), which
    /// [`LayeredBox::mesh`] reports with the place.
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let mut cell = [0; 2];
        let mut part = [0.0; 2];
        for (a, value) in [x, y].into_iter().enumerate() {
            if self.counts[a] == 1 {
                continue;
            }
            let last = (self.counts[a] - 1) as f64;
            let t = (value - self.origin[a]) / self.spacing[a];
            if !(-1e-6..=last + 1e-6).contains(&t) {
                return f64::NAN;
            }
            let t = t.clamp(0.0, last);
            cell[a] = (t as usize).min(self.counts[a] - 2);
            part[a] = t - cell[a] as f64;
        }
        let at = |i: usize, j: usize| {
            let i = (cell[0] + i).min(self.counts[0] - 1);
            let j = (cell[1] + j).min(self.counts[1] - 1);
            self.heights[j * self.counts[0] + i]
        };
        let along = |j| (1.0 - part[0]) * at(0, j) + part[0] * at(1, j);
        (1.0 - part[1]) * along(0) + part[1] * along(1)
    }
}
