//! The internal force and the step by their formulas, slow and clear: what fast kernels are tested against.

use super::{Ground, Material};
use crate::mesh::{axes, determinant, inverse};

/// Strain tensor at every point of every element, `[element][point]`.
pub type Strains = Vec<[[f64; 3]; 3]>;

/// Strain $\varepsilon_{cx} = \tfrac12(\partial_x u_c + \partial_c u_x)$ at every point of every element.
///
/// Gradients come from the derivative matrix and the inverse of the Jacobian at each point.
pub fn strains(ground: &Ground, u: &[[f64; 3]]) -> Strains {
    let (mesh, gll, numbering) = (ground.mesh(), ground.gll(), ground.numbering());
    let (n, d) = (gll.len(), mesh.dimension);
    let mut all = vec![];
    for e in 0..mesh.len() {
        let nodes = numbering.element(e);
        for p in 0..numbering.points {
            let (local, _) = super::geometry::point(gll, d, p);
            let (inverse, _) = inverse(&mesh.jacobian(e, local));
            let mut h = [[0.0; 3]; 3];
            for a in 0..d {
                let stride = n.pow(a as u32);
                let i = p / stride % n;
                for m in 0..n {
                    let slope = gll.derivative[i * n + m];
                    let node = nodes[p + m * stride - i * stride] as usize;
                    for c in 0..3 {
                        for &x in axes(d) {
                            h[c][x] += slope * u[node][c] * inverse[axes(d)[a]][x];
                        }
                    }
                }
            }
            all.push(std::array::from_fn(|c| std::array::from_fn(|x| 0.5 * (h[c][x] + h[x][c]))));
        }
    }
    all
}

/// Isotropic stress $\lambda\,\mathrm{tr}\,\varepsilon\,I + 2\mu\,\varepsilon$.
pub fn stress((lambda, mu): (f64, f64), strain: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let pressure = lambda * (strain[0][0] + strain[1][1] + strain[2][2]);
    std::array::from_fn(|c| {
        std::array::from_fn(|x| 2.0 * mu * strain[c][x] + if c == x { pressure } else { 0.0 })
    })
}

/// Internal force $f_{ic} = \sum_e\sum_p w_p|J|\,\sigma_{cx}\,\partial_x\ell_i$ of given stresses, N.
pub fn force_of(ground: &Ground, stresses: &[[[f64; 3]; 3]]) -> Vec<[f64; 3]> {
    let (mesh, gll, numbering) = (ground.mesh(), ground.gll(), ground.numbering());
    let (n, d) = (gll.len(), mesh.dimension);
    let mut f = vec![[0.0; 3]; numbering.nodes];
    for e in 0..mesh.len() {
        let nodes = numbering.element(e);
        for p in 0..numbering.points {
            let (local, w) = super::geometry::point(gll, d, p);
            let jacobian = mesh.jacobian(e, local);
            let (inverse, _) = inverse(&jacobian);
            let weight = w * determinant(&jacobian);
            let s = &stresses[e * numbering.points + p];
            for a in 0..d {
                let stride = n.pow(a as u32);
                let i = p / stride % n;
                for m in 0..n {
                    let slope = weight * gll.derivative[i * n + m];
                    let node = nodes[p + m * stride - i * stride] as usize;
                    for c in 0..3 {
                        for &x in axes(d) {
                            f[node][c] += slope * s[c][x] * inverse[axes(d)[a]][x];
                        }
                    }
                }
            }
        }
    }
    f
}

/// Internal force of an elastic solid with the moduli that `of` takes from each material.
pub fn internal_force(
    ground: &Ground,
    u: &[[f64; 3]],
    of: impl Fn(&Material) -> (f64, f64),
) -> Vec<[f64; 3]> {
    let points = ground.numbering().points;
    let stresses: Vec<_> = (strains(ground, u).iter().enumerate())
        .map(|(i, e)| stress(of(ground.material(i / points)), e))
        .collect();
    force_of(ground, &stresses)
}

/// A solid that steps by the textbook's central difference, each arm by the trapezoidal rule on its own strain
/// $e^{n+1} = \dfrac{(1-x)e^n + \Delta\varepsilon}{1+x}$; no supports, no dashpots.
#[derive(Debug, Clone)]
pub struct ReferenceSolid<'a> {
    ground: &'a Ground,
    dt: f64,
    /// Position at the next kick, m.
    pub x: Vec<[f64; 3]>,
    /// Velocity, m/s.
    pub v: Vec<[f64; 3]>,
    strain: Strains,
    arms: Vec<Strains>,
    step: usize,
}

impl<'a> ReferenceSolid<'a> {
    /// At rest.
    pub fn new(ground: &'a Ground, dt: f64) -> Self {
        let zeros = || vec![[0.0; 3]; ground.numbering().nodes];
        let none = vec![[[0.0; 3]; 3]; ground.mesh().len() * ground.numbering().points];
        let arms = ground.distribution.arms();
        Self { ground, dt, x: zeros(), v: zeros(), arms: vec![none.clone(); arms], strain: none, step: 0 }
    }

    /// One step under the ground's loads.
    pub fn step(&mut self) {
        let points = self.ground.numbering().points;
        let strain = strains(self.ground, &self.x);
        let mut stresses = Vec::with_capacity(strain.len());
        for (i, e) in strain.iter().enumerate() {
            let law = self.ground.law(i / points, i % points);
            let mut s = stress(law.relaxed, e);
            for (l, arm) in law.arms.iter().enumerate() {
                let x = 0.5 * arm.omega * self.dt;
                let own = &mut self.arms[l][i];
                for c in 0..3 {
                    for k in 0..3 {
                        own[c][k] = ((1.0 - x) * own[c][k] + e[c][k] - self.strain[i][c][k]) / (1.0 + x);
                    }
                }
                let part = stress(arm.moduli, own);
                (0..9).for_each(|k| s[k / 3][k % 3] += part[k / 3][k % 3]);
            }
            stresses.push(s);
        }
        self.strain = strain;
        let mut force = force_of(self.ground, &stresses);
        force.iter_mut().flatten().for_each(|f| *f = -*f);
        for load in &self.ground.loads {
            let a = load.amplitude.get(self.step).copied().unwrap_or(0.0);
            for (p, f) in &load.forces {
                (0..3).for_each(|c| force[*p as usize][c] += a * f[c]);
            }
        }
        for (i, m) in self.ground.mass().iter().enumerate() {
            for c in 0..3 {
                self.v[i][c] += self.dt / m * force[i][c];
                self.x[i][c] += self.dt * self.v[i][c];
            }
        }
        self.step += 1;
    }
}
