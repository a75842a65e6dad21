//! Quadrature rules of the reference cube $[-1,1]^3$ and the reference tetrahedron.

use std::sync::LazyLock;

/// A quadrature point: $\int f\,d\xi \approx \sum w\,f(\xi)$.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Reference coordinates.
    pub xi: [f64; 3],
    /// Weight.
    pub weight: f64,
}

fn cube(rule: &[(f64, f64)]) -> Vec<Point> {
    let mut points = vec![];
    for &(z, wz) in rule {
        for &(y, wy) in rule {
            for &(x, wx) in rule {
                points.push(Point { xi: [x, y, z], weight: wx * wy * wz });
            }
        }
    }
    points
}

/// Gauss, two points an axis: exact to degree 3 in each coordinate.
pub(super) static CUBE_8: LazyLock<Vec<Point>> = LazyLock::new(|| {
    let a = 1.0 / 3f64.sqrt();
    cube(&[(-a, 1.0), (a, 1.0)])
});

/// Gauss, three points an axis: exact to degree 5 in each coordinate.
pub(super) static CUBE_27: LazyLock<Vec<Point>> = LazyLock::new(|| {
    let a = 0.6f64.sqrt();
    cube(&[(-a, 5.0 / 9.0), (0.0, 8.0 / 9.0), (a, 5.0 / 9.0)])
});

/// Fourteen points, positive weights, exact to degree 5 on the tetrahedron of volume 1/6.
///
/// Two stars of four points and one of six; abscissae and weights solve the moment equations of
/// degree 5 (Walkington 2000 lists them; the test below checks every monomial).
pub(super) static TETRAHEDRON_14: LazyLock<Vec<Point>> = LazyLock::new(|| {
    let mut points = vec![];
    for (a, weight) in [
        (0.310_885_919_263_300_6, 0.018_781_320_953_002_642),
        (0.092_735_250_310_891_23, 0.012_248_840_519_393_658),
    ] {
        let b = 1.0 - 3.0 * a;
        for xi in [[a, a, a], [b, a, a], [a, b, a], [a, a, b]] {
            points.push(Point { xi, weight });
        }
    }
    let (a, weight) = (0.045_503_704_125_649_65, 0.007_091_003_462_846_911);
    let b = 0.5 - a;
    for xi in [[a, a, b], [a, b, a], [b, a, a], [a, b, b], [b, a, b], [b, b, a]] {
        points.push(Point { xi, weight });
    }
    points
});

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn cubes_integrate_their_degree_in_each_coordinate_and_no_more() {
        for (rule, degree) in [(&*CUBE_8, 3), (&*CUBE_27, 5)] {
            for power in 0..=degree + 1 {
                let exact = if power % 2 == 0 { 8.0 / f64::from(power + 1) } else { 0.0 };
                let found: f64 = rule.iter().map(|p| p.weight * p.xi[1].powi(power)).sum();
                assert_eq!((found - exact).abs() < 1e-14, power <= degree, "{power}: {found} {exact}");
            }
        }
    }

    #[test]
    fn the_tetrahedron_integrates_every_monomial_of_degree_five() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for (i, j, k) in (0..=5).flat_map(|i| (0..=5).flat_map(move |j| (0..=5).map(move |k| (i, j, k)))) {
            if i + j + k > 5 {
                continue;
            }
            let exact = factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3);
            let found: f64 = TETRAHEDRON_14
                .iter()
                .map(|p| p.weight * p.xi[0].powi(i) * p.xi[1].powi(j) * p.xi[2].powi(k))
                .sum();
            assert_abs_diff_eq!(found, exact, epsilon = 1e-16);
        }
    }
}
