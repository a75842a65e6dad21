//! Gauss–Lobatto–Legendre rule on [−1, 1]: points, weights, derivative matrix, interpolation.

use crate::SemError;

/// Highest polynomial order on offer.
pub const ORDER_MAX: usize = 10;

/// Points, weights and derivative matrix of one polynomial order $N$ ($n = N + 1$ points).
///
/// The points are $\pm1$ and the zeros of $P_N'$; the weights $w_i = 2/(N(N+1)P_N(\xi_i)^2)$ integrate
/// polynomials of degree $2N-1$ exactly; `derivative[i][j]` is $\ell_j'(\xi_i)$.
#[derive(Debug, Clone)]
pub struct Gll {
    /// Points, increasing.
    pub points: Vec<f64>,
    /// Weights, sum 2.
    pub weights: Vec<f64>,
    /// Derivative matrix, row-major, row = point, column = basis function.
    pub derivative: Vec<f64>,
    barycentric: Vec<f64>,
}

impl Gll {
    /// The rule of a polynomial order 1–10; another order is an error.
    pub fn new(order: usize) -> Result<Self, SemError> {
        if !(1..=ORDER_MAX).contains(&order) {
            return Err(SemError::Order(order));
        }
        let n = order + 1;
        let points: Vec<f64> = (0..n).map(|i| point(order, i)).collect();
        let weights =
            points.iter().map(|&x| 2.0 / ((order * n) as f64 * legendre(order, x).0.powi(2))).collect();
        let barycentric: Vec<f64> = (0..n)
            .map(|i| 1.0 / (0..n).filter(|&j| j != i).map(|j| points[i] - points[j]).product::<f64>())
            .collect();
        let mut derivative = vec![0.0; n * n];
        for i in 0..n {
            for j in (0..n).filter(|&j| j != i) {
                derivative[i * n + j] = barycentric[j] / barycentric[i] / (points[i] - points[j]);
            }
            // rows sum to zero: a rigid motion has no strain, to the last digit
            derivative[i * n + i] = -(0..n).filter(|&j| j != i).map(|j| derivative[i * n + j]).sum::<f64>();
        }
        Ok(Self { points, weights, derivative, barycentric })
    }

    /// Number of points, $N + 1$.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Never; a rule has at least two points.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Values $\ell_j(\xi)$ of the basis functions at a point of [−1, 1].
    pub fn interpolation(&self, xi: f64) -> Vec<f64> {
        let mut values = vec![0.0; self.len()];
        if let Some(hit) = self.points.iter().position(|&p| p == xi) {
            values[hit] = 1.0;
            return values;
        }
        for (value, (b, p)) in values.iter_mut().zip(self.barycentric.iter().zip(&self.points)) {
            *value = b / (xi - p);
        }
        let sum: f64 = values.iter().sum();
        values.iter_mut().for_each(|v| *v /= sum);
        values
    }
}

impl Gll {
    /// Slopes $\ell_j'(\xi)$ of the basis functions at a point of [−1, 1].
    pub fn interpolation_slope(&self, xi: f64) -> Vec<f64> {
        // the derivative of a basis function is a polynomial that its values at the points fix
        let n = self.len();
        let at = self.interpolation(xi);
        (0..n).map(|j| (0..n).map(|i| at[i] * self.derivative[i * n + j]).sum()).collect()
    }
}

/// Points and weights of the Gauss–Legendre rule of `count` points on [−1, 1], exact to degree 2 `count` − 1.
pub fn gauss(count: usize) -> Vec<(f64, f64)> {
    let root = |i: usize| {
        // Tricomi's estimate of the zero of P_n, then Newton
        let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        for _ in 0..50 {
            let (p, dp) = legendre(count, x);
            x -= p / dp;
            if (p / dp).abs() < 1e-16 {
                break;
            }
        }
        let slope = legendre(count, x).1;
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(root).collect()
}

/// Legendre polynomial and its derivative at x.
fn legendre(order: usize, x: f64) -> (f64, f64) {
    let (mut p, mut before) = (1.0, 0.0);
    let (mut dp, mut dbefore) = (0.0, 0.0);
    for k in 0..order {
        let k = k as f64;
        let next = ((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0);
        let dnext = ((2.0 * k + 1.0) * (p + x * dp) - k * dbefore) / (k + 1.0);
        (before, p, dbefore, dp) = (p, next, dp, dnext);
    }
    (p, dp)
}

/// The i-th GLL point: Newton on $P_N'$ from the Chebyshev–Lobatto point.
fn point(order: usize, i: usize) -> f64 {
    if i == 0 {
        return -1.0;
    }
    if i == order {
        return 1.0;
    }
    if 2 * i == order {
        return 0.0;
    }
    let n = (order * (order + 1)) as f64;
    let mut x = -(std::f64::consts::PI * i as f64 / order as f64).cos();
    for _ in 0..50 {
        let (p, dp) = legendre(order, x);
        // Legendre's equation gives P'' = (2 x P' − N(N+1) P)/(1 − x²)
        let step = dp * (1.0 - x * x) / (2.0 * x * dp - n * p);
        x -= step;
        if step.abs() < 1e-16 {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrature_is_exact_to_degree_2n_minus_1_and_not_beyond() {
        for order in 1..=ORDER_MAX {
            let gll = Gll::new(order).unwrap();
            let integral = |degree: i32| -> f64 {
                gll.points.iter().zip(&gll.weights).map(|(x, w)| w * x.powi(degree)).sum()
            };
            for degree in 0..2 * order as i32 {
                let exact = if degree % 2 == 0 { 2.0 / (degree + 1) as f64 } else { 0.0 };
                assert!((integral(degree) - exact).abs() < 2e-15, "order {order}, degree {degree}");
            }
            let beyond = 2 * order as i32;
            assert!((integral(beyond) - 2.0 / (beyond + 1) as f64).abs() > 1e-8, "order {order}");
        }
    }

    #[test]
    fn gauss_is_exact_to_degree_2n_minus_1_and_not_beyond() {
        for count in 1..=16 {
            let rule = gauss(count);
            let integral = |degree: i32| -> f64 { rule.iter().map(|(x, w)| w * x.powi(degree)).sum() };
            for degree in 0..2 * count as i32 {
                let exact = if degree % 2 == 0 { 2.0 / f64::from(degree + 1) } else { 0.0 };
                assert!((integral(degree) - exact).abs() < 4e-15, "{count} points, degree {degree}");
            }
            let beyond = 2 * count as i32;
            assert!((integral(beyond) - 2.0 / f64::from(beyond + 1)).abs() > 1e-10, "{count} points");
        }
    }

    #[test]
    fn derivative_is_exact_for_the_order() {
        for order in 1..=ORDER_MAX {
            let gll = Gll::new(order).unwrap();
            let n = gll.len();
            for i in 0..n {
                let row = &gll.derivative[i * n..(i + 1) * n];
                assert!(row.iter().sum::<f64>().abs() < 1e-13);
                let d: f64 = row.iter().zip(&gll.points).map(|(d, x)| d * x.powi(order as i32)).sum();
                let exact = order as f64 * gll.points[i].powi(order as i32 - 1);
                assert!((d - exact).abs() < 1e-12, "order {order}: {d} against {exact}");
            }
        }
    }

    #[test]
    fn interpolation_is_a_partition_of_unity_that_reproduces_polynomials() {
        for order in 1..=ORDER_MAX {
            let gll = Gll::new(order).unwrap();
            for xi in [-1.0, -0.93, -0.2, 0.0, 0.4142, 1.0] {
                let l = gll.interpolation(xi);
                assert!((l.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                let value: f64 = l.iter().zip(&gll.points).map(|(l, x)| l * x.powi(order as i32)).sum();
                assert!((value - xi.powi(order as i32)).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn orders_out_of_range_are_refused() {
        for order in [0, 11] {
            assert!(matches!(Gll::new(order), Err(SemError::Order(o)) if o == order));
        }
    }
}
