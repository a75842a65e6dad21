//! Tractions that fall off as a Gaussian, of any width against the elements.

use super::ground::Ground;
use crate::SemError;
use crate::gll::gauss;
use crate::mesh::Side;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Distance from the centre, in σ, beyond which nothing is counted: $e^{-40}$ of the peak.
const REACH: f64 = 9.0;
/// Longest edge of a cell of the quadrature, in σ.
const CELL: f64 = 2.0;
/// Points of the rule beyond the order's number: with [`CELL`] the sum is right to some 1e-9 at orders 2 and above.
const MORE_POINTS: usize = 6;
/// Least σ as a share of the element's size: no basis function tells a narrower load from a point force.
const NARROWEST: f64 = 1e-6;

/// A load per area that falls off around a point, $g = \frac{1}{(2\pi)^{(D-1)/2}\sigma^{D-1}}e^{-r^2/(2\sigma^2)}$, 1/m²
/// (1/m at D = 2): its integral over an endless plane through the centre is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// Centre, m. y does not count at D = 2, z does not where `horizontal`.
    pub centre: [f64; 3],
    /// Whether r is the horizontal distance and the load is per area of the plan; else r is the distance in space.
    pub horizontal: bool,
    /// Width σ, m.
    pub sigma: f64,
}

/// A part of a side: its lower corner and its width in the side's local coordinates.
#[derive(Clone, Copy)]
struct Cell {
    low: [f64; 2],
    width: f64,
}

impl Ground {
    /// Nodal weights of a Gaussian load on a boundary, $w_i = \int g\,\ell_i\,dA$; a force F so spread is $F w_i$.
    ///
    /// - σ may be anything: sides are cut into cells no longer than 2σ, each with a Gauss rule on the element's own
    ///   map. As σ → 0 the weights become those of [`Ground::point_force`] at the centre; below 1e-6 of an
    ///   element's size σ is taken as that.
    /// - The sum of the weights is the share of the load that falls on the boundary: 1 where no part lies beyond its rim
    ///   or beside the surface, 0 where the centre is far from it.
    ///
    /// Errors: no boundary of that name. Cost: some 300 cells where σ is small, one per side within 9σ where it is
    /// large; $(N+7)^{D-1}$ points each.
    pub fn gaussian(&self, boundary: &str, load: &Gaussian) -> Result<Vec<(u32, f64)>, SemError> {
        let rule = gauss(self.gll().len() + MORE_POINTS);
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        for side in self.sides(boundary)? {
            let floor = NARROWEST * self.mesh().size(side.element as usize);
            let load = Gaussian { sigma: load.sigma.max(floor), ..*load };
            let mut cells = vec![Cell { low: [-1.0; 2], width: 2.0 }];
            while let Some(cell) = cells.pop() {
                match self.cell_reach(side, cell, &load) {
                    Reach::Far => {}
                    Reach::Split => self.split(cell, &mut cells),
                    Reach::Fine => self.integrate(side, cell, &load, &rule, &mut sum),
                }
            }
        }
        Ok(sum.into_iter().filter(|(_, w)| *w != 0.0).collect())
    }

    fn cell_reach(&self, side: Side, cell: Cell, load: &Gaussian) -> Reach {
        let mesh = self.mesh();
        let count = 1usize << (mesh.dimension - 1);
        let mut corners = [[0.0; 3]; 4];
        let mut middle = [0.0; 3];
        for (i, corner) in corners.iter_mut().enumerate().take(count) {
            let place = [0, 1].map(|a| cell.low[a] + cell.width * (i >> a & 1) as f64);
            let x = mesh.position(side.element as usize, mesh.side_local(side, place));
            *corner = load.offset(x, mesh.dimension);
            (0..3).for_each(|c| middle[c] += corner[c] / count as f64);
        }
        let between = |a: [f64; 3], b: [f64; 3]| norm([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
        let corners = &corners[..count];
        // straight sides lie within the hull of their corners; a curved one is given as much again
        let bulge = mesh.order as f64;
        let radius = bulge * corners.iter().map(|c| between(*c, middle)).fold(0.0, f64::max);
        if norm(middle) - radius > REACH * load.sigma {
            return Reach::Far;
        }
        let edges = (0..count).flat_map(|i| (0..mesh.dimension - 1).map(move |a| (i, i ^ 1 << a)));
        let longest = edges.map(|(i, j)| between(corners[i], corners[j])).fold(0.0, f64::max);
        if longest > CELL * load.sigma { Reach::Split } else { Reach::Fine }
    }

    fn split(&self, cell: Cell, cells: &mut Vec<Cell>) {
        let width = 0.5 * cell.width;
        for part in 0..1usize << (self.mesh().dimension - 1) {
            let low = [0, 1].map(|a| cell.low[a] + width * (part >> a & 1) as f64);
            cells.push(Cell { low, width });
        }
    }

    fn integrate(
        &self,
        side: Side,
        cell: Cell,
        load: &Gaussian,
        rule: &[(f64, f64)],
        sum: &mut BTreeMap<u32, f64>,
    ) {
        let (mesh, element) = (self.mesh(), side.element as usize);
        let d = mesh.dimension;
        let nodes = self.numbering().element(element);
        let points = self.numbering().side_points(side.side);
        let n = self.gll().len();
        let half = 0.5 * cell.width;
        let along = |a: usize| -> Vec<(f64, f64, Vec<f64>)> {
            let at = |(x, w): &(f64, f64)| {
                let place = (cell.low[a] + half * (1.0 + x)).clamp(-1.0, 1.0);
                (place, half * w, self.gll().interpolation(place))
            };
            rule.iter().map(at).collect()
        };
        let first = along(0);
        let second = if d == 3 { along(1) } else { vec![(0.0, 1.0, vec![1.0])] };
        let mut weights = vec![0.0; points.len()];
        for (y, wy, ly) in &second {
            for (x, wx, lx) in &first {
                let local = mesh.side_local(side, [*x, *y]);
                let r = load.offset(mesh.position(element, local), d);
                let area = mesh.side_normal(side, local);
                let area = match (load.horizontal, d) {
                    (true, _) => area[2].abs(),
                    (_, 2) => norm([area[0], 0.0, area[2]]),
                    _ => norm(area),
                };
                let value = wx * wy * area * load.value(r, d);
                // the points of a side run along its lower local axis first
                weights.iter_mut().enumerate().for_each(|(p, w)| *w += value * lx[p % n] * ly[p / n]);
            }
        }
        points.iter().zip(weights).for_each(|(&p, w)| *sum.entry(nodes[p]).or_default() += w);
    }
}

enum Reach {
    Far,
    Split,
    Fine,
}

impl Gaussian {
    /// From the centre to a place, what does not count left out.
    fn offset(&self, x: [f64; 3], dimension: usize) -> [f64; 3] {
        let counts = |i: usize| (i != 2 || !self.horizontal) && (i != 1 || dimension == 3);
        std::array::from_fn(|i| if counts(i) { x[i] - self.centre[i] } else { 0.0 })
    }

    fn value(&self, offset: [f64; 3], dimension: usize) -> f64 {
        let r = norm(offset) / self.sigma;
        (-0.5 * r * r).exp() / ((2.0 * PI).sqrt() * self.sigma).powi(dimension as i32 - 1)
    }
}

fn norm(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
