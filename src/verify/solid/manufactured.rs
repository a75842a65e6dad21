//! A manufactured solution on curved, deformed meshes: order of the error in space.
//!
//! $u_c(x, t) = f(t)\,g_c(x)$ with products of sines $g_c$ in a box of 1 m: zero on the bottom (held), mirrored in
//! the plane x = 0 (symmetry), loaded by its own traction on all other faces and by the body force
//! $\rho\ddot f g - f\,\nabla\cdot\sigma(g)$ inside. At the kicks $\ddot f$ is the second difference that the central
//! difference takes, so that it follows f exactly and only the error in space is left, at any step.
//!
//! The mesh is bent by a fixed smooth map that slides the points of each outer face within its plane: outer faces
//! stay flat, all elements become curved (quad9, hex27).

use crate::verify::{CaseResult, Check, twist};
use hati_coupling::Subdomain;
use hati_sem::SemError;
use hati_sem::gll::Gll;
use hati_sem::mesh::{BoxLayer, LayeredBox, Mesh, axes, determinant};
use hati_sem::solid::{Execution, Ground, Material, Solid, Support, Watch};
use std::f64::consts::{FRAC_PI_2, PI};

/// Density, kg/m³, and speeds of P and S waves, m/s.
const MATERIAL: (f64, f64, f64) = (2.0, 1.9, 1.0);

/// How long the solution is followed, s: an S wave crosses the box.
const DURATION: f64 = 1.0;

/// One component: $\prod_a \sin(k_a x_a + \varphi_a)$.
#[derive(Clone, Copy)]
struct Shape {
    k: [f64; 3],
    phase: [f64; 3],
}

impl Shape {
    /// Derivative of given order along each axis.
    fn at(&self, x: [f64; 3], order: [i32; 3]) -> f64 {
        let along = |a: usize| {
            let angle = self.k[a] * x[a] + self.phase[a] + FRAC_PI_2 * f64::from(order[a]);
            self.k[a].powi(order[a]) * angle.sin()
        };
        along(0) * along(1) * along(2)
    }
}

/// The solution's shape, its stress and the divergence of that.
struct Field {
    shape: [Shape; 3],
    lambda: f64,
    mu: f64,
}

impl Field {
    /// Wave numbers times `factor`; at D = 2 nothing varies along y.
    fn new(dimension: usize, factor: f64) -> Self {
        let (rho, vp, vs) = MATERIAL;
        let mu = rho * vs * vs;
        // sin(k (z + 1)) is zero on the bottom; sine of x across the plane of symmetry, cosine along it
        let shape = |kx: f64, ky: f64, kz: f64, across: bool, phase_y: f64| {
            let (ky, phase_y) = if dimension == 3 { (factor * ky, phase_y) } else { (0.0, FRAC_PI_2) };
            let k = [factor * kx, ky, factor * kz];
            Shape { k, phase: [if across { 0.0 } else { FRAC_PI_2 }, phase_y, factor * kz] }
        };
        let shape = [
            shape(3.1, 2.2, 2.7, true, 0.7),
            shape(2.6, 2.9, 2.3, false, 0.4),
            shape(2.3, 1.9, 3.2, false, 1.1),
        ];
        Self { shape, lambda: rho * vp * vp - 2.0 * mu, mu }
    }

    fn value(&self, x: [f64; 3]) -> [f64; 3] {
        self.shape.map(|s| s.at(x, [0; 3]))
    }

    fn stress(&self, x: [f64; 3]) -> [[f64; 3]; 3] {
        let slope = |c: usize, a: usize| self.shape[c].at(x, unit(a));
        let pressure = self.lambda * (0..3).map(|c| slope(c, c)).sum::<f64>();
        std::array::from_fn(|c| {
            std::array::from_fn(|a| {
                self.mu * (slope(c, a) + slope(a, c)) + if a == c { pressure } else { 0.0 }
            })
        })
    }

    /// $\nabla\cdot\sigma = \mu\Delta g + (\lambda + \mu)\nabla(\nabla\cdot g)$.
    fn divergence(&self, x: [f64; 3]) -> [f64; 3] {
        let second = |c: usize, a: usize, b: usize| {
            let (first, then) = (unit(a), unit(b));
            self.shape[c].at(x, std::array::from_fn(|i| first[i] + then[i]))
        };
        std::array::from_fn(|c| {
            let laplacian: f64 = (0..3).map(|a| second(c, a, a)).sum();
            let gradient: f64 = (0..3).map(|a| second(a, a, c)).sum();
            self.mu * laplacian + (self.lambda + self.mu) * gradient
        })
    }
}

fn unit(a: usize) -> [i32; 3] {
    std::array::from_fn(|i| i32::from(i == a))
}

/// The box [0, 1]³ (z from −1) of `elements` per edge, bent; quad9 or hex27.
fn bent_box(dimension: usize, elements: usize) -> Result<Mesh, SemError> {
    let layers = [BoxLayer { name: "soil".into(), thickness: 1.0, elements }];
    let mut mesh = LayeredBox {
        dimension,
        x: (0.0, 1.0),
        y: (0.0, 1.0),
        layers: &layers,
        element_width: 1.0 / elements as f64,
        topography: None,
        moved_layers: 1,
        order: 2,
    }
    .mesh()?;
    mesh.deform(|[x, y, z]| {
        let (sin, cos) = (|a: f64| (PI * a).sin(), |a: f64| (PI * a + 0.3).cos());
        // sin(πx) vanishes on x = 0 and x = 1, and so on: a face slides within its plane
        let along_y = if dimension == 3 { y + 0.06 * sin(y) * cos(x) * cos(z) } else { y };
        let across = if dimension == 3 { cos(y) } else { 1.0 };
        [x + 0.08 * sin(x) * cos(z) * across, along_y, z + 0.07 * sin(z) * cos(x)]
    });
    Ok(mesh)
}

/// f(t).
fn history(t: f64) -> f64 {
    (2.3 * t + 0.4).sin()
}

/// The box with supports and loads for a step.
fn loaded(dimension: usize, order: usize, elements: usize) -> Result<Ground, SemError> {
    let (rho, vp, vs) = MATERIAL;
    let mesh = bent_box(dimension, elements)?;
    let mut ground = Ground::new(mesh, order, &[Material::elastic("soil", rho, vp, vs)])?;
    ground.support("bottom", Support::Fixed)?;
    ground.support("x_min", Support::Symmetry)?;
    Ok(ground)
}

fn add_loads(ground: &mut Ground, field: &Field, dt: f64, steps: usize) -> Result<(), SemError> {
    let dimension = ground.mesh().dimension;
    let still: Vec<f64> = (0..steps).map(|n| history(n as f64 * dt)).collect();
    let at = |n: f64| history(n * dt);
    let inertia = (0..steps).map(|n| n as f64).map(|n| (at(n + 1.0) - 2.0 * at(n) + at(n - 1.0)) / (dt * dt));
    let forces: Vec<(u32, [f64; 3])> = (0u32..)
        .zip(ground.positions())
        .zip(ground.mass())
        .map(|((i, x), m)| (i, field.value(x).map(|g| m * g)))
        .collect();
    ground.add_load(forces, inertia.collect());
    let mut body = vec![[0.0; 3]; ground.numbering().nodes];
    for e in 0..ground.mesh().len() {
        for (local, weight, node) in rule(ground, e) {
            let divergence = field.divergence(ground.mesh().position(e, local));
            (0..3).for_each(|c| body[node as usize][c] -= weight * divergence[c]);
        }
    }
    for (name, axis, sign) in [("x_max", 0, 1.0), ("top", 2, 1.0), ("y_min", 1, -1.0), ("y_max", 1, 1.0)] {
        if axis == 1 && dimension == 2 {
            continue;
        }
        for (node, f) in ground.traction(name, |x| field.stress(x).map(|row| sign * row[axis]))? {
            (0..3).for_each(|c| body[node as usize][c] += f[c]);
        }
    }
    ground.add_load((0u32..).zip(body).collect(), still);
    Ok(())
}

/// The GLL points of an element: local point, weight times |J|, number.
fn rule(ground: &Ground, element: usize) -> Vec<([f64; 3], f64, u32)> {
    let (gll, mesh) = (ground.gll(), ground.mesh());
    (ground.numbering().element(element).iter().enumerate())
        .map(|(p, &node)| {
            let (local, weight) = tensor(gll, mesh.dimension, p);
            (local, weight * determinant(&mesh.jacobian(element, local)), node)
        })
        .collect()
}

fn tensor(gll: &Gll, dimension: usize, p: usize) -> ([f64; 3], f64) {
    let n = gll.len();
    let (mut local, mut weight) = ([0.0; 3], 1.0);
    for a in 0..dimension {
        let i = p / n.pow(a as u32) % n;
        local[a] = gll.points[i];
        weight *= gll.weights[i];
    }
    (local, weight)
}

/// Relative L2 error of the displacement after a second, in f64.
///
/// - `elements`: along each edge of the box;
/// - `k_factor`: factor on the wave numbers of the solution that it is compared with (1).
///
/// The error is integrated by a GLL rule three orders above. Errors: an order out of 1–7.
pub fn manufactured_error(
    dimension: usize,
    order: usize,
    elements: usize,
    k_factor: f64,
) -> Result<f64, SemError> {
    let field = Field::new(dimension, 1.0);
    let mut ground = loaded(dimension, order, elements)?;
    // the map is the same at every size: the limit is in proportion to the elements, or above
    let coarse = elements.min(2);
    let critical =
        Solid::<f64>::critical_step(&loaded(dimension, order, coarse)?, 1e-2, Execution::default())?;
    let steps = (DURATION / (0.6 * critical * coarse as f64 / elements as f64)).ceil() as usize;
    let dt = DURATION / steps as f64;
    add_loads(&mut ground, &field, dt, steps + 1)?;
    let mut solid = Solid::<f64>::new(&ground, dt, dt, Execution::default());
    let (before, at) = (history(-dt), history(0.0));
    // positions at kicks −1 and 0: their mean and slope hold half-way
    solid.set_motion(&ground, |x| {
        let g = field.value(x);
        (g.map(|g| 0.5 * (before + at) * g), g.map(|g| (at - before) / dt * g))
    });
    (0..steps).for_each(|_| solid.step());
    let all: Vec<u32> = (0..ground.numbering().nodes as u32).collect();
    let mut watch = Watch::new(&solid, &all);
    watch.before(&solid);
    let exact = Field::new(dimension, k_factor);
    l2_error(&ground, watch.displacement(), |x| exact.value(x).map(|g| history(DURATION) * g))
}

fn l2_error(ground: &Ground, u: &[[f64; 3]], exact: impl Fn([f64; 3]) -> [f64; 3]) -> Result<f64, SemError> {
    let (mesh, order) = (ground.mesh(), ground.gll().len() - 1);
    let fine = Gll::new(order + 3)?;
    let d = axes(mesh.dimension).len();
    // values of the basis at the finer rule's points, the same in every element
    let places: Vec<([f64; 3], f64, Vec<f64>)> = (0..fine.len().pow(d as u32))
        .map(|p| {
            let (local, weight) = tensor(&fine, d, p);
            let along: Vec<Vec<f64>> = (0..d).map(|a| ground.gll().interpolation(local[a])).collect();
            let value =
                |q: usize| (0..d).map(|a| along[a][q / (order + 1).pow(a as u32) % (order + 1)]).product();
            (local, weight, (0..ground.numbering().points).map(value).collect())
        })
        .collect();
    let (mut wrong, mut whole) = (0.0, 0.0);
    for e in 0..mesh.len() {
        let nodes = ground.numbering().element(e);
        for (local, weight, values) in &places {
            let mut found = [0.0; 3];
            for (v, node) in values.iter().zip(nodes) {
                (0..3).for_each(|c| found[c] += v * u[*node as usize][c]);
            }
            let weight = weight * determinant(&mesh.jacobian(e, *local));
            let g = exact(mesh.position(e, *local));
            wrong += weight * (0..3).map(|c| (found[c] - g[c]).powi(2)).sum::<f64>();
            whole += weight * g.iter().map(|g| g * g).sum::<f64>();
        }
    }
    Ok((wrong / whole).sqrt())
}

/// Elements per edge at which the error's order is observed: where the error is that of the theory's leading
/// term, and not yet round-off.
pub fn manufactured_sizes(dimension: usize, order: usize) -> [usize; 4] {
    match (dimension, order) {
        (2, 2) => [8, 16, 32, 64],
        (2, 6) => [2, 4, 8, 12],
        (2, _) => [2, 4, 8, 16],
        (_, 2) => [4, 8, 12, 16],
        (_, 3) => [2, 4, 8, 12],
        _ => [2, 4, 6, 8],
    }
}

/// Order N + 1 of the L2 error for N = 2…6, D = 2 and 3: each refinement's and no less than the theory's. Twist: the wave
/// numbers of the exact solution.
pub(in crate::verify) fn manufactured(twisted: bool) -> CaseResult {
    const CASE: &str = "manufactured";
    const LIMIT: f64 = 0.1;
    let mut checks = vec![];
    for dimension in [2, 3] {
        for order in 2..=6 {
            let sizes = manufactured_sizes(dimension, order);
            // the wrong solution shows on any pair; the coarse one costs least
            let pair = if twisted { &sizes[..2] } else { &sizes[2..] };
            let error = |n: usize| manufactured_error(dimension, order, n, twist(twisted, LIMIT));
            let observed = (error(pair[0])? / error(pair[1])?).ln() / (pair[1] as f64 / pair[0] as f64).ln();
            let reference = order as f64 + 1.0;
            // more than the theory promises is no mistake
            let short = (reference - observed).max(0.0);
            checks.push(Check {
                case: CASE,
                quantity: format!(
                    "D = {dimension}, N = {order}, {} to {} elements per edge: order in h, L2",
                    pair[0], pair[1]
                ),
                value: observed,
                reference,
                error: short,
                limit: LIMIT,
                pass: short <= LIMIT,
            });
        }
    }
    Ok(checks)
}
