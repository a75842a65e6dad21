//! Shape of elements and sides: Jacobians, sides' nodes, the nearest point of a side.

/// Values of $\det J / \prod_a |\partial x/\partial \xi_a|$ below this count as zero: a thousandth of a
/// degree between two edges is no element, and coordinates of ten digits still tell it from zero.
const COLLAPSED: f64 = 1e-6;

/// What the Jacobian says of an element.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Orientation {
    Right,
    Left,
    /// Folded or collapsed: the smallest scaled Jacobian and its place in local coordinates.
    Bad(f64, Vec<i8>),
}

/// Numbers of the nodes on a side, within the tensor of an element, the lower local axis fastest.
pub(super) fn side_nodes(dimension: usize, order: usize, side: usize) -> Vec<usize> {
    let n = order + 1;
    let (axis, end) = (side / 2, (side % 2) * order);
    let count = n.pow(dimension as u32);
    let digit = |node: usize| node / n.pow(axis as u32) % n;
    (0..count).filter(|&node| digit(node) == end).collect()
}

/// Numbers of the corners within a tensor of `(order + 1)^axes` nodes, the first axis fastest.
pub(super) fn corners(axes: usize, order: usize) -> Vec<usize> {
    let n = order + 1;
    let place = |corner: usize| (0..axes).map(|a| (corner >> a & 1) * order * n.pow(a as u32)).sum();
    (0..1 << axes).map(place).collect()
}

/// The $3^D$ points of the tensor of −1, 0 and 1: the nodes themselves at order 2, else interpolated.
fn grid(dimension: usize, order: usize, nodes: &[[f64; 3]]) -> [[f64; 3]; 27] {
    let mut grid = [[0.0; 3]; 27];
    let n = order + 1;
    for (point, value) in grid.iter_mut().enumerate().take(3_usize.pow(dimension as u32)) {
        let digits = [point % 3, point / 3 % 3, point / 9];
        if order == 2 {
            *value = nodes[point];
            continue;
        }
        for (node, place) in nodes.iter().enumerate() {
            let weight: f64 = (0..dimension)
                .map(|a| {
                    let high = digits[a] as f64 / 2.0;
                    if node / n.pow(a as u32) % n == 1 { high } else { 1.0 - high }
                })
                .product();
            (0..3).for_each(|c| value[c] += weight * place[c]);
        }
    }
    grid
}

/// $\partial/\partial\xi$ at −1, 0, 1 from values there.
const DERIVATIVE: [[f64; 3]; 3] = [[-1.5, 2.0, -0.5], [-0.5, 0.0, 0.5], [0.5, -2.0, 1.5]];

/// Whether an element is right-handed, left-handed or bad, from its Jacobian at the $3^D$ points of the
/// tensor of −1, 0 and 1. At D = 2 the section is x–z, and right-handed turns from x to z.
pub(super) fn orientation(dimension: usize, order: usize, nodes: &[[f64; 3]]) -> Orientation {
    // Distances within the element, so that a far origin costs no digits.
    let origin = nodes[0];
    let mut near = [[0.0; 3]; 27];
    for (near, node) in near.iter_mut().zip(nodes) {
        *near = subtract(*node, origin);
    }
    let grid = grid(dimension, order, &near[..nodes.len()]);
    let (mut low, mut high, mut at) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for point in 0..3_usize.pow(dimension as u32) {
        let scaled = scaled_jacobian(dimension, &grid, point);
        if scaled < low {
            (low, at) = (scaled, point);
        }
        high = high.max(scaled);
    }
    if low > COLLAPSED {
        Orientation::Right
    } else if high < -COLLAPSED {
        Orientation::Left
    } else {
        let digits = [at % 3, at / 3 % 3, at / 9];
        Orientation::Bad(low, digits[..dimension].iter().map(|&digit| digit as i8 - 1).collect())
    }
}

/// The sine-like measure of the angles between the tangents at one point of the grid.
fn scaled_jacobian(dimension: usize, grid: &[[f64; 3]; 27], point: usize) -> f64 {
    let mut tangents = [[0.0; 3]; 3];
    for (axis, tangent) in tangents.iter_mut().enumerate().take(dimension) {
        let stride = 3_usize.pow(axis as u32);
        let digit = point / stride % 3;
        for (other, weight) in DERIVATIVE[digit].iter().enumerate() {
            let value = grid[point + other * stride - digit * stride];
            (0..3).for_each(|c| tangent[c] += weight * value[c]);
        }
        let length = norm(*tangent);
        tangent.iter_mut().for_each(|c| *c /= length);
    }
    let [t, u, v] = tangents;
    let determinant = if dimension == 2 { t[0] * u[2] - t[2] * u[0] } else { dot(t, cross(u, v)) };
    // A tangent of length zero, or one beyond all numbers, gives NaN: no element either.
    if determinant.is_nan() { 0.0 } else { determinant }
}

/// Values and derivatives of the Lagrange polynomials on −1, (0,) 1.
fn lagrange(order: usize, x: f64) -> ([f64; 3], [f64; 3]) {
    if order == 1 {
        ([(1.0 - x) / 2.0, (1.0 + x) / 2.0, 0.0], [-0.5, 0.5, 0.0])
    } else {
        ([x * (x - 1.0) / 2.0, 1.0 - x * x, x * (x + 1.0) / 2.0], [x - 0.5, -2.0 * x, x + 0.5])
    }
}

/// Point and tangents of a side with `axes` local axes at a local place.
fn side_point(axes: usize, order: usize, nodes: &[[f64; 3]], at: [f64; 2]) -> ([f64; 3], [[f64; 3]; 2]) {
    let (shape_s, slope_s) = lagrange(order, at[0]);
    let (shape_t, slope_t) = lagrange(order, at[1]);
    let n = order + 1;
    let (mut point, mut tangents) = ([0.0; 3], [[0.0; 3]; 2]);
    for (node, place) in nodes.iter().enumerate() {
        let (i, j) = (node % n, node / n);
        let (value, along, across) = if axes == 1 {
            (shape_s[i], slope_s[i], 0.0)
        } else {
            (shape_s[i] * shape_t[j], slope_s[i] * shape_t[j], shape_s[i] * slope_t[j])
        };
        for c in 0..3 {
            point[c] += value * place[c];
            tangents[0][c] += along * place[c];
            tangents[1][c] += across * place[c];
        }
    }
    (point, tangents)
}

/// Distance from a point to a side, where the nearest point is on the side and not beyond its ends.
///
/// Gauss–Newton on the squared distance; straight and slightly curved sides take two or three steps.
pub(super) fn distance_to_side(
    axes: usize,
    order: usize,
    nodes: &[[f64; 3]],
    point: [f64; 3],
) -> Option<f64> {
    let near: Vec<[f64; 3]> = nodes.iter().map(|node| subtract(*node, point)).collect();
    let mut at = [0.0; 2];
    for _ in 0..8 {
        let (gap, [s, t]) = side_point(axes, order, &near, at);
        let (ss, st, tt) = (dot(s, s), dot(s, t), dot(t, t));
        let (gs, gt) = (dot(gap, s), dot(gap, t));
        if axes == 1 {
            at[0] -= gs / ss;
        } else {
            let determinant = ss * tt - st * st;
            at[0] -= (tt * gs - st * gt) / determinant;
            at[1] -= (ss * gt - st * gs) / determinant;
        }
        // Far outside there is nothing to find, and a curved side need not converge.
        at.iter_mut().for_each(|a| *a = a.clamp(-1.5, 1.5));
    }
    let (gap, _) = side_point(axes, order, &near, at);
    at[..axes].iter().all(|a| a.abs() <= 1.0 + 1e-6).then(|| norm(gap))
}

pub(super) fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_corners_are_those_of_the_tensor() {
        assert_eq!(side_nodes(2, 1, 0), [0, 2]);
        assert_eq!(side_nodes(2, 2, 3), [6, 7, 8]);
        assert_eq!(side_nodes(3, 1, 1), [1, 3, 5, 7]);
        assert_eq!(side_nodes(3, 1, 4), [0, 1, 2, 3]);
        assert_eq!(side_nodes(3, 2, 2), [0, 1, 2, 9, 10, 11, 18, 19, 20]);
        assert_eq!(corners(2, 2), [0, 2, 6, 8]);
        assert_eq!(corners(3, 2), [0, 2, 6, 8, 18, 20, 24, 26]);
    }

    #[test]
    fn orientation_is_independent_of_size_and_place() {
        for (size, far) in [(1.0, 0.0), (1e-4, 0.0), (1e5, 0.0), (0.1, 5e6)] {
            let node = |x: f64, z: f64| [far + size * x, 0.0, far + size * z];
            let square = [node(0.0, 0.0), node(1.0, 0.0), node(0.0, 1.0), node(1.0, 1.0)];
            assert_eq!(orientation(2, 1, &square), Orientation::Right);
            let [a, b, c, d] = square;
            assert_eq!(orientation(2, 1, &[a, c, b, d]), Orientation::Left);
            // The last corner drawn in beyond the diagonal: concave there.
            let dart = [a, b, c, node(0.4, 0.4)];
            assert!(
                matches!(orientation(2, 1, &dart), Orientation::Bad(low, at) if low < -0.1 && at == [1, 1])
            );
            let triangle = [a, b, c, b];
            assert!(matches!(orientation(2, 1, &triangle), Orientation::Bad(..)));
            // A thousand times wider than high is a sound layer.
            let flat = [a, node(1000.0, 0.0), c, node(1000.0, 1.0)];
            assert_eq!(orientation(2, 1, &flat), Orientation::Right);
        }
        let zero = [[1.0; 3]; 8];
        assert!(matches!(orientation(3, 1, &zero), Orientation::Bad(low, _) if low == 0.0));
        let mut huge = zero;
        huge[3] = [1e300; 3];
        assert!(matches!(orientation(3, 1, &huge), Orientation::Bad(..)));
    }

    #[test]
    fn second_order_elements_are_checked_at_their_nodes() {
        let node = |i: usize| [(i % 3) as f64, 0.0, (i / 3) as f64];
        let mut quad: Vec<[f64; 3]> = (0..9).map(node).collect();
        assert_eq!(orientation(2, 2, &quad), Orientation::Right);
        // A mid-side node beyond the quarter point folds the corner; the corners alone look sound.
        quad[1][0] = 0.4;
        assert!(matches!(orientation(2, 2, &quad), Orientation::Bad(..)));
        quad[1][0] = 0.6;
        assert_eq!(orientation(2, 2, &quad), Orientation::Right);
    }

    #[test]
    fn distance_to_a_curved_side_is_that_to_its_parabola() {
        let arc = [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.5], [1.0, 0.0, 0.0]];
        let on = [0.5, 0.0, 0.375];
        assert!(distance_to_side(1, 2, &arc, on).unwrap() < 1e-9);
        assert!(distance_to_side(1, 2, &arc, [3.0, 0.0, 0.0]).is_none());
        let plate = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [2.0, 3.0, 0.0]];
        let distance = distance_to_side(2, 1, &plate, [0.7, 1.1, 0.2]).unwrap();
        assert!((distance - 0.2).abs() < 1e-9, "{distance}");
    }
}
