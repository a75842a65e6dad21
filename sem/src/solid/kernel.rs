//! Internal force of a batch of elements side by side in vector lanes: the fast kernel.
//!
//! One code for D = 2 and 3, both precisions and every order that it is instantiated for: `P` points per
//! edge, `K` of them along the third local axis (1 at D = 2). Per element and ζ-plane:
//!
//! 1. $g_{dc} = \sum_m D_{\cdot m}u_c$, derivatives along the local axes $d$;
//! 2. $h_{cx} = \sum_d B_{dx}\,g_{dc}$ with the metric $B$, that is $\partial u_c/\partial x$ times a known factor;
//! 3. $\sigma = C\,h$ times the weight $s$, memory variables included;
//! 4. $F_{dc} = \sum_x B_{dx}\,\sigma_{cx}$, and $f_c = \sum_d D^T_d F_{dc}$.
//!
//! The metric stands for $B = J^{-1}$ up to a factor that the weight takes back ([`super::geometry`]): with
//! $B = \varphi J^{-1}$ the weight is $s = w\,|J|/\varphi^2$, so cofactors ($\varphi = |J|$) need no division
//! but that of $s$, and $\varphi^2 = w|J|$ needs no weight at all.
//!
//! Memory variables: arm $l$ of a point has the strain $e_l = (h - \gamma_l)/(1 + x_l)$, $x_l = \omega_l\Delta t/2$,
//! and its dashpot's strain advances by $\gamma_l \leftarrow \gamma_l + 2x_l e_l$. That is the trapezoidal rule between kicks
//! of the column, in a form that needs no strain of the step before.

use super::geometry::{Metric, MetricLanes};
use super::laws::{ArmLanes, Laws};
use super::real::Real;
use crate::prefetch::prefetch;
use pulp::Simd;

/// Values at the points of one batch, `[ζ][η][ξ]`.
pub(super) type Cube<V, const P: usize, const K: usize> = [[[V; P]; P]; K];

/// Fluxes on a plane, `[local axis][component][η][ξ]`.
type Fluxes<V, const P: usize> = [[[[V; P]; P]; 3]; 3];

/// Working memory of a batch; lives on the stack.
pub(super) struct Work<V, const P: usize, const K: usize> {
    /// Position at the kick, per component.
    pub u: [Cube<V, P, K>; 3],
    /// Velocity before the kick, per component; used where losses are booked.
    pub v: [Cube<V, P, K>; 3],
    /// Internal force, per component.
    pub f: [Cube<V, P, K>; 3],
    flux: Fluxes<V, P>,
    metric: [[[V; 9]; P]; P],
    weight: [[V; P]; P],
}

impl<V: Copy, const P: usize, const K: usize> Work<V, P, K> {
    /// All zero.
    #[inline(always)]
    pub(super) fn new(zero: V) -> Self {
        let cube = [[[zero; P]; P]; K];
        Self {
            u: [cube; 3],
            v: [cube; 3],
            f: [cube; 3],
            flux: [[[[zero; P]; P]; 3]; 3],
            metric: [[[zero; 9]; P]; P],
            weight: [[zero; P]; P],
        }
    }
}

/// Derivative matrix and quadrature weights of an order, in the kernel's precision.
#[derive(Debug, Clone)]
pub(super) struct Basis<T, const P: usize> {
    /// `derivative[i][m]` is $\ell_m'(\xi_i)$.
    pub derivative: [[T; P]; P],
    /// Points.
    pub points: [T; P],
    /// Weights.
    pub weights: [T; P],
}

/// Number of strain components that are not zero: all six, or all but $\varepsilon_{yy}$ of a section.
pub(super) const fn strain_components(planes: usize) -> usize {
    if planes == 1 { 5 } else { 6 }
}

/// Number of axes along which the field varies.
pub(super) const fn axis_count(planes: usize) -> usize {
    if planes == 1 { 2 } else { 3 }
}

/// Global axis of a metric's column.
#[inline(always)]
pub(super) const fn global_axis(planes: usize, column: usize) -> usize {
    if planes == 1 { 2 * column } else { column }
}

/// Shorthands of one instruction set.
#[derive(Clone, Copy)]
struct Ops<T, S>(S, std::marker::PhantomData<T>);

impl<T: Real, S: Simd> Ops<T, S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        Self(simd, std::marker::PhantomData)
    }
    #[inline(always)]
    fn add(self, a: T::Vector<S>, b: T::Vector<S>) -> T::Vector<S> {
        T::plus(self.0, a, b)
    }
    #[inline(always)]
    fn sub(self, a: T::Vector<S>, b: T::Vector<S>) -> T::Vector<S> {
        T::minus(self.0, a, b)
    }
    #[inline(always)]
    fn mul(self, a: T::Vector<S>, b: T::Vector<S>) -> T::Vector<S> {
        T::times(self.0, a, b)
    }
    #[inline(always)]
    fn fma(self, a: T::Vector<S>, b: T::Vector<S>, c: T::Vector<S>) -> T::Vector<S> {
        T::fma(self.0, a, b, c)
    }
    #[inline(always)]
    fn splat(self, x: T) -> T::Vector<S> {
        T::splat(self.0, x)
    }
}

/// Derivative matrix in every lane.
#[inline(always)]
pub(super) fn splat_matrix<T: Real, S: Simd, const P: usize>(
    simd: S,
    matrix: &[[T; P]; P],
) -> [[T::Vector<S>; P]; P] {
    let mut lanes = [[T::splat(simd, T::default()); P]; P];
    for i in 0..P {
        for m in 0..P {
            lanes[i][m] = T::splat(simd, matrix[i][m]);
        }
    }
    lanes
}

/// Derivatives of one component along the local axes, on the row (k, j) of a batch, added to `g`.
#[inline(always)]
fn row_derivatives<T: Real, S: Simd, const P: usize, const K: usize>(
    ops: Ops<T, S>,
    d: &[[T::Vector<S>; P]; P],
    u: &Cube<T::Vector<S>, P, K>,
    k: usize,
    j: usize,
    g: &mut [[T::Vector<S>; P]; 3],
) {
    for m in 0..P {
        for i in 0..P {
            g[0][i] = ops.fma(d[i][m], u[k][j][m], g[0][i]);
        }
    }
    for m in 0..P {
        for i in 0..P {
            g[1][i] = ops.fma(d[j][m], u[k][m][i], g[1][i]);
        }
    }
    if K > 1 {
        for m in 0..K {
            for i in 0..P {
                g[2][i] = ops.fma(d[k][m], u[m][j][i], g[2][i]);
            }
        }
    }
}

/// $h_{cx} = \sum_d B_{dx}\,g_{dc}$ at point i of a row, as strains xx, yy, zz, yz, xz, xy (shear: twice
/// the tensor's).
#[inline(always)]
fn strain<T: Real, S: Simd, const P: usize, const K: usize>(
    ops: Ops<T, S>,
    b: &[T::Vector<S>; 9],
    g: &[[[T::Vector<S>; P]; 3]; 3],
    i: usize,
) -> [T::Vector<S>; 6] {
    let axes = axis_count(K);
    let mut h = [[ops.splat(T::default()); 3]; 3];
    for c in 0..3 {
        for x in 0..axes {
            let mut sum = ops.mul(b[x], g[c][0][i]);
            for d in 1..axes {
                sum = ops.fma(b[d * axes + x], g[c][d][i], sum);
            }
            h[c][global_axis(K, x)] = sum;
        }
    }
    [
        h[0][0],
        h[1][1],
        h[2][2],
        ops.add(h[1][2], h[2][1]),
        ops.add(h[0][2], h[2][0]),
        ops.add(h[0][1], h[1][0]),
    ]
}

/// Isotropic stress of a strain; `weight` scales the moduli.
#[inline(always)]
fn stress<T: Real, S: Simd>(
    ops: Ops<T, S>,
    lambda: T::Vector<S>,
    mu: T::Vector<S>,
    e: &[T::Vector<S>; 6],
) -> [T::Vector<S>; 6] {
    let pressure = ops.mul(lambda, ops.add(ops.add(e[0], e[1]), e[2]));
    let twice = ops.add(mu, mu);
    [
        ops.fma(twice, e[0], pressure),
        ops.fma(twice, e[1], pressure),
        ops.fma(twice, e[2], pressure),
        ops.mul(mu, e[3]),
        ops.mul(mu, e[4]),
        ops.mul(mu, e[5]),
    ]
}

/// Stress times strain, $\sigma:e$.
#[inline(always)]
fn work_of<T: Real, S: Simd>(ops: Ops<T, S>, s: &[T::Vector<S>; 6], e: &[T::Vector<S>; 6]) -> T::Vector<S> {
    let mut sum = ops.mul(s[0], e[0]);
    for c in 1..6 {
        sum = ops.fma(s[c], e[c], sum);
    }
    sum
}

/// What a batch gives besides its force, a lane an element, J.
#[derive(Clone, Copy)]
pub(super) struct BatchBooks<V> {
    /// Four times the energy that the arms' dashpots took up between the kick before and this one.
    pub loss: V,
    /// Strain energy, arms included, in the middle between the two kicks; only where asked for.
    pub strain: V,
}

/// Internal force of a batch, `work.u` to `work.f`.
///
/// - `laws`: moduli and arms; without `MEMORY` those of the first class hold at every point;
/// - `dashpots`: strains of the arms' dashpots, `[point][arm][component]`. They need `work.v`, the velocity that led from
///   the kick before to this one, for the energy that goes into `books`;
/// - `advance`: whether the arms take the step; without it their stored energy is booked instead.
///
/// Cost per point: 2 × 3 × D × P multiply–adds for derivatives, some 80 for the rest; with memory half as
/// many derivatives again, and some 60 per arm.
#[inline(always)]
pub(super) fn internal_force<T: Real, S: Simd, const P: usize, const K: usize, const MEMORY: bool>(
    simd: S,
    basis: &Basis<T, P>,
    d: &[[T::Vector<S>; P]; P],
    work: &mut Work<T::Vector<S>, P, K>,
    metric: &MetricLanes<'_, T::Vector<S>>,
    laws: &Laws<'_, T::Vector<S>>,
    dashpots: &mut [T::Vector<S>],
    advance: bool,
    dt: T,
    books: &mut BatchBooks<T::Vector<S>>,
) {
    let ops = Ops::<T, S>::new(simd);
    let zero = ops.splat(T::default());
    for c in 0..3 {
        work.f[c] = [[[zero; P]; P]; K];
    }
    let components = strain_components(K);
    let stride = laws.arms_per_point * components;
    let (mut lambda, mut mu) = (laws.lambda[0], laws.mu[0]);
    let (axes, dt) = (axis_count(K), ops.splat(dt));
    for k in 0..K {
        let source = fill_plane::<T, S, P, K>(simd, basis, metric, k, &mut work.metric, &mut work.weight);
        for j in 0..P {
            let mut g = [[[zero; P]; 3]; 3];
            let mut rates = [[[zero; P]; 3]; 3];
            for c in 0..3 {
                row_derivatives::<T, S, P, K>(ops, d, &work.u[c], k, j, &mut g[c]);
                if MEMORY {
                    row_derivatives::<T, S, P, K>(ops, d, &work.v[c], k, j, &mut rates[c]);
                }
            }
            if MEMORY {
                let next = (k * P + j + 1) * P * stride;
                prefetch(dashpots, next, next + P * stride);
            }
            for i in 0..P {
                let b = match source {
                    Source::Plane => &work.metric[j][i],
                    Source::One(b) => b,
                };
                let weight = work.weight[j][i];
                let e = strain::<T, S, P, K>(ops, b, &g, i);
                let point = (k * P + j) * P + i;
                let mut class = 0;
                if MEMORY {
                    class = usize::from(laws.class[point]);
                    (lambda, mu) = (laws.lambda[class], laws.mu[class]);
                }
                let mut s = stress::<T, S>(ops, lambda, mu, &e);
                if MEMORY {
                    let mut increment = strain::<T, S, P, K>(ops, b, &rates, i);
                    for x in &mut increment {
                        *x = ops.mul(dt, *x);
                    }
                    let mut point_books = BatchBooks { loss: zero, strain: zero };
                    if !advance {
                        let mut last = e;
                        for c in 0..6 {
                            last[c] = ops.sub(e[c], increment[c]);
                        }
                        point_books.strain = work_of::<T, S>(ops, &s, &last);
                    }
                    let own = &laws.arms[class * laws.arms_per_point..(class + 1) * laws.arms_per_point];
                    let kept = &mut dashpots[point * stride..(point + 1) * stride];
                    for (arm, dashpot) in own.iter().zip(kept.chunks_exact_mut(components)) {
                        step_arm::<T, S, K>(
                            ops,
                            arm,
                            &e,
                            &increment,
                            advance,
                            dashpot,
                            &mut s,
                            &mut point_books,
                        );
                    }
                    books.loss = ops.fma(weight, point_books.loss, books.loss);
                    books.strain = ops.fma(weight, point_books.strain, books.strain);
                }
                for x in &mut s {
                    *x = ops.mul(*x, weight);
                }
                let rows = [[s[0], s[5], s[4]], [s[5], s[1], s[3]], [s[4], s[3], s[2]]];
                for c in 0..3 {
                    for a in 0..axes {
                        let mut sum = ops.mul(b[a * axes], rows[c][0]);
                        for x in 1..axes {
                            sum = ops.fma(b[a * axes + x], rows[c][global_axis(K, x)], sum);
                        }
                        work.flux[a][c][j][i] = sum;
                    }
                }
            }
        }
        scatter_plane::<T, S, P, K>(ops, d, k, &work.flux, &mut work.f);
    }
    if !MEMORY && !advance {
        book_elastic::<T, S, P, K>(ops, work, dt, books);
    }
}

/// Strain energy between two kicks of an elastic batch, $u^{n}\!\cdot f(u^{n+1})$ — twice of it.
#[inline(always)]
fn book_elastic<T: Real, S: Simd, const P: usize, const K: usize>(
    ops: Ops<T, S>,
    work: &Work<T::Vector<S>, P, K>,
    dt: T::Vector<S>,
    books: &mut BatchBooks<T::Vector<S>>,
) {
    for c in 0..3 {
        for k in 0..K {
            for j in 0..P {
                for i in 0..P {
                    let last = ops.sub(work.u[c][k][j][i], ops.mul(dt, work.v[c][k][j][i]));
                    books.strain = ops.fma(last, work.f[c][k][j][i], books.strain);
                }
            }
        }
    }
}

/// One arm at one point: adds its stress to `s`, books its loss, and takes the step or books its energy.
#[inline(always)]
fn step_arm<T: Real, S: Simd, const K: usize>(
    ops: Ops<T, S>,
    arm: &ArmLanes<T::Vector<S>>,
    e: &[T::Vector<S>; 6],
    increment: &[T::Vector<S>; 6],
    advance: bool,
    dashpot: &mut [T::Vector<S>],
    s: &mut [T::Vector<S>; 6],
    books: &mut BatchBooks<T::Vector<S>>,
) {
    let [gain, rate, lambda, mu, twice, back] = *arm;
    let zero = ops.splat(T::default());
    let (mut own, mut both) = ([zero; 6], [zero; 6]);
    let mut slot = 0;
    for c in 0..6 {
        if K == 1 && c == 1 {
            continue;
        }
        own[c] = ops.mul(gain, ops.sub(e[c], dashpot[slot]));
        both[c] = ops.sub(ops.mul(twice, own[c]), ops.mul(back, increment[c]));
        if advance {
            dashpot[slot] = ops.fma(rate, own[c], dashpot[slot]);
        }
        slot += 1;
    }
    let part = stress::<T, S>(ops, lambda, mu, &own);
    for c in 0..6 {
        s[c] = ops.add(s[c], part[c]);
    }
    // 2x = ω Δt; a mean's square is a quarter of a sum's, which the caller takes
    books.loss = ops.fma(rate, square::<T, S>(ops, lambda, mu, &both), books.loss);
    if !advance {
        let (mut change, mut before) = (own, own);
        for c in 0..6 {
            before[c] = ops.sub(both[c], own[c]);
            change[c] = ops.sub(own[c], before[c]);
        }
        // twice the energy: e⁺·σ(e⁻) − (ωΔt/4)(e⁺·σ(e⁺) − e⁻·σ(e⁻)), the last by (a+b)·σ(a−b)
        books.strain = ops.add(books.strain, work_of::<T, S>(ops, &part, &before));
        let quarter = ops.mul(ops.splat(T::of(-0.25)), rate);
        let of_both = stress::<T, S>(ops, lambda, mu, &both);
        books.strain = ops.fma(quarter, work_of::<T, S>(ops, &of_both, &change), books.strain);
    }
}

/// $\sigma(e):e = \lambda\,\mathrm{tr}^2 + 2\mu\,e{:}e$, shear strains being twice the tensor's.
#[inline(always)]
fn square<T: Real, S: Simd>(
    ops: Ops<T, S>,
    lambda: T::Vector<S>,
    mu: T::Vector<S>,
    e: &[T::Vector<S>; 6],
) -> T::Vector<S> {
    let trace = ops.add(ops.add(e[0], e[1]), e[2]);
    let axial = ops.fma(e[2], e[2], ops.fma(e[1], e[1], ops.mul(e[0], e[0])));
    let shear = ops.fma(e[5], e[5], ops.fma(e[4], e[4], ops.mul(e[3], e[3])));
    let tensor = ops.add(ops.add(axial, axial), shear);
    ops.fma(mu, tensor, ops.mul(ops.mul(lambda, trace), trace))
}

/// Where a plane's metric is.
#[derive(Clone, Copy)]
enum Source<'a, V> {
    /// Same at every point.
    One(&'a [V; 9]),
    /// In the plane's buffer.
    Plane,
}

/// Makes metric and weight of plane k ready.
#[inline(always)]
fn fill_plane<'a, T: Real, S: Simd, const P: usize, const K: usize>(
    simd: S,
    basis: &Basis<T, P>,
    metric: &MetricLanes<'a, T::Vector<S>>,
    k: usize,
    plane: &mut [[[T::Vector<S>; 9]; P]; P],
    weight: &mut [[T::Vector<S>; P]; P],
) -> Source<'a, T::Vector<S>> {
    let ops = Ops::<T, S>::new(simd);
    let axes = axis_count(K);
    let along = if K > 1 { basis.weights[k] } else { T::of(1.0) };
    match metric.kind {
        Metric::Affine => {
            for j in 0..P {
                for i in 0..P {
                    weight[j][i] = ops.splat(basis.weights[i] * basis.weights[j] * along);
                }
            }
            match metric.values.first_chunk() {
                Some(b) => Source::One(b),
                None => Source::Plane,
            }
        }
        Metric::Stored => {
            let n = axes * axes;
            for j in 0..P {
                for i in 0..P {
                    let point = (k * P + j) * P + i;
                    plane[j][i][..n].copy_from_slice(&metric.values[point * n..(point + 1) * n]);
                    weight[j][i] = ops.splat(T::of(1.0));
                }
            }
            Source::Plane
        }
        Metric::Corners => {
            corner_plane::<T, S, P, K>(simd, basis, metric.values, k, plane, weight);
            Source::Plane
        }
    }
}

/// Cofactors of the Jacobian of a bi- or trilinear element on plane k, and $w/|J|$.
#[inline(always)]
fn corner_plane<T: Real, S: Simd, const P: usize, const K: usize>(
    simd: S,
    basis: &Basis<T, P>,
    coefficients: &[T::Vector<S>],
    k: usize,
    plane: &mut [[[T::Vector<S>; 9]; P]; P],
    weight: &mut [[T::Vector<S>; P]; P],
) {
    let ops = Ops::<T, S>::new(simd);
    let zero = ops.splat(T::default());
    if K == 1 {
        // x = a + ξ a₀ + η a₁ + ξη a₂: coefficients [m][x, z]
        let a = coefficients;
        for j in 0..P {
            let eta = ops.splat(basis.points[j]);
            for i in 0..P {
                let xi = ops.splat(basis.points[i]);
                let (x_xi, z_xi) = (ops.fma(eta, a[4], a[0]), ops.fma(eta, a[5], a[1]));
                let (x_eta, z_eta) = (ops.fma(xi, a[4], a[2]), ops.fma(xi, a[5], a[3]));
                let det = ops.sub(ops.mul(x_xi, z_eta), ops.mul(z_xi, x_eta));
                let b = &mut plane[j][i];
                (b[0], b[1]) = (z_eta, ops.sub(zero, x_eta));
                (b[2], b[3]) = (ops.sub(zero, z_xi), x_xi);
                weight[j][i] = T::over(simd, ops.splat(basis.weights[i] * basis.weights[j]), det);
            }
        }
        return;
    }
    // x = a + ξ a₀ + η a₁ + ζ a₂ + ξη a₃ + ηζ a₄ + ζξ a₅ + ξηζ a₆: coefficients [m][x, y, z]
    let mut a = [[zero; 3]; 7];
    for m in 0..7 {
        a[m].copy_from_slice(&coefficients[3 * m..3 * m + 3]);
    }
    let zeta = ops.splat(basis.points[k]);
    let (plane_xi, plane_eta) = (line(ops, zeta, &a[5], &a[0]), line(ops, zeta, &a[4], &a[1]));
    let plane_both = line(ops, zeta, &a[6], &a[3]);
    for j in 0..P {
        let eta = ops.splat(basis.points[j]);
        let d_xi = line(ops, eta, &plane_both, &plane_xi);
        let (zeta_base, zeta_slope) = (line(ops, eta, &a[4], &a[2]), line(ops, eta, &a[6], &a[5]));
        for i in 0..P {
            let xi = ops.splat(basis.points[i]);
            let d_eta = line(ops, xi, &plane_both, &plane_eta);
            let d_zeta = line(ops, xi, &zeta_slope, &zeta_base);
            let b = &mut plane[j][i];
            for x in 0..3 {
                let (y, z) = ((x + 1) % 3, (x + 2) % 3);
                b[x] = ops.sub(ops.mul(d_eta[y], d_zeta[z]), ops.mul(d_eta[z], d_zeta[y]));
                b[3 + x] = ops.sub(ops.mul(d_zeta[y], d_xi[z]), ops.mul(d_zeta[z], d_xi[y]));
                b[6 + x] = ops.sub(ops.mul(d_xi[y], d_eta[z]), ops.mul(d_xi[z], d_eta[y]));
            }
            let det = ops.fma(d_xi[2], b[2], ops.fma(d_xi[1], b[1], ops.mul(d_xi[0], b[0])));
            let w = basis.weights[i] * basis.weights[j] * basis.weights[k];
            weight[j][i] = T::over(simd, ops.splat(w), det);
        }
    }
}

/// $t\,p + q$ for three components.
#[inline(always)]
fn line<T: Real, S: Simd>(
    ops: Ops<T, S>,
    t: T::Vector<S>,
    p: &[T::Vector<S>; 3],
    q: &[T::Vector<S>; 3],
) -> [T::Vector<S>; 3] {
    [ops.fma(t, p[0], q[0]), ops.fma(t, p[1], q[1]), ops.fma(t, p[2], q[2])]
}

/// Adds the contributions of plane k's fluxes to the force.
#[inline(always)]
fn scatter_plane<T: Real, S: Simd, const P: usize, const K: usize>(
    ops: Ops<T, S>,
    d: &[[T::Vector<S>; P]; P],
    k: usize,
    flux: &Fluxes<T::Vector<S>, P>,
    f: &mut [Cube<T::Vector<S>, P, K>; 3],
) {
    for c in 0..3 {
        for j in 0..P {
            let mut row = f[c][k][j];
            for m in 0..P {
                for i in 0..P {
                    row[i] = ops.fma(d[m][i], flux[0][c][j][m], row[i]);
                }
            }
            for m in 0..P {
                for i in 0..P {
                    row[i] = ops.fma(d[m][j], flux[1][c][m][i], row[i]);
                }
            }
            f[c][k][j] = row;
        }
        if K > 1 {
            for m in 0..K {
                for j in 0..P {
                    for i in 0..P {
                        f[c][m][j][i] = ops.fma(d[k][m], flux[2][c][j][i], f[c][m][j][i]);
                    }
                }
            }
        }
    }
}
