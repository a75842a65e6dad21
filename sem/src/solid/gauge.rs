//! Strain and stress at a place.

use super::geometry::{Metric, point};
use super::ground::{Ground, Probe};
use super::kernel::strain_components;
use super::{Real, Solid};
use crate::mesh::determinant;
use hati_coupling::Subdomain;

/// Order of the components that the kernel keeps: xx, yy, zz, yz, xz, xy. Their places in xx, yy, zz, xy, yz, xz.
const PLACE: [usize; 6] = [0, 1, 2, 4, 5, 3];

/// Strain and stress tensors of a place; components xx, yy, zz, xy, yz, xz.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tensors {
    /// Strain ε (shears as ε, half of γ).
    pub strain: [f64; 6],
    /// Stress, Pa, tension positive.
    pub stress: [f64; 6],
}

/// A place where strain and stress are looked at.
///
/// $\varepsilon(\xi) = \mathrm{sym}\sum_i u_i\otimes\nabla\ell_i(\xi)$ is the element's own derivative there. The stress is
/// that of the relaxed moduli and of the arms, $\sigma = C_R\varepsilon + \sum_l C_l\,g_l(\varepsilon - \gamma_l)$, with the strains
/// γ of the arms' dashpots interpolated from the element's points. On a side between elements it is the side of the element
/// that the [`Probe`] names.
#[derive(Debug, Clone)]
pub struct Gauge {
    /// First number and stride of each local point in the solid's arrays.
    places: Vec<(u32, u32)>,
    gradients: Vec<[f64; 3]>,
    /// Weights of the dashpots of each local point.
    weights: Vec<f64>,
    /// Relaxed λ and μ, Pa.
    relaxed: (f64, f64),
    /// Gain, λ and μ (Pa) of each arm.
    arms: Vec<(f64, f64, f64)>,
    /// First dashpot of the element, and the distance of two of its numbers.
    dashpots: (usize, usize),
    /// Dashpots of a point: arms of the model times components.
    per_point: usize,
    components: usize,
}

impl Gauge {
    /// Prepares a probe of the ground that the solid was made from.
    pub fn new<T: Real>(solid: &Solid<T>, ground: &Ground, probe: &Probe) -> Self {
        let layout = &solid.model.layout;
        let places = (ground.numbering().element(probe.element).iter())
            .map(|&p| layout.place(layout.number[p as usize] as usize))
            .map(|(first, stride)| (first as u32, stride as u32))
            .collect();
        let material = ground.material(probe.element);
        let arm = |l: usize| {
            let (lambda, mu) = material.arm(l);
            (1.0 / (1.0 + 0.5 * material.omega()[l] * solid.dt()), lambda, mu)
        };
        let lane = layout.element.iter().position(|&e| e as usize == probe.element).unwrap_or(0);
        let (batch, lane) = (lane / layout.lanes, lane % layout.lanes);
        let components = strain_components(solid.model.planes());
        Self {
            places,
            gradients: ground.basis_gradients(probe.element, probe.local),
            weights: memory_weights(ground, probe),
            relaxed: material.relaxed(),
            arms: (0..material.omega().len()).map(arm).collect(),
            dashpots: (batch * solid.model.dashpots_per_batch() + lane, layout.lanes),
            per_point: solid.model.arms * components,
            components,
        }
    }

    /// Strain and stress at the coming kick: call it before [`Subdomain::step`], as [`super::Watch::before`]. Allocates
    /// nothing.
    pub fn look<T: Real>(&self, solid: &Solid<T>) -> Tensors {
        let mut h = [[0.0; 3]; 3];
        for (&(first, stride), g) in self.places.iter().zip(&self.gradients) {
            for (c, row) in h.iter_mut().enumerate() {
                let u = solid.x[first as usize + c * stride as usize].f64();
                row.iter_mut().zip(g).for_each(|(h, g)| *h += u * g);
            }
        }
        let shear = |i: usize, j: usize| h[i][j] + h[j][i];
        let e = [h[0][0], h[1][1], h[2][2], shear(1, 2), shear(0, 2), shear(0, 1)];
        let mut stress = [0.0; 6];
        add_stress(&mut stress, self.relaxed, 1.0, &e);
        for (l, &(gain, lambda, mu)) in self.arms.iter().enumerate() {
            add_stress(&mut stress, (lambda, mu), gain, &self.elastic_part(solid, l, &e));
        }
        let mut found = Tensors::default();
        for (c, &to) in PLACE.iter().enumerate() {
            found.strain[to] = if c < 3 { e[c] } else { 0.5 * e[c] };
            found.stress[to] = stress[c];
        }
        found
    }

    /// Strain of an arm's spring before its gain, ε − γ.
    fn elastic_part<T: Real>(&self, solid: &Solid<T>, arm: usize, e: &[f64; 6]) -> [f64; 6] {
        let mut rest = *e;
        let (first, distance) = self.dashpots;
        // a section keeps no εyy
        let kept = (0..6).filter(|c| self.components == 6 || *c != 1);
        for (slot, c) in kept.enumerate() {
            for (p, w) in self.weights.iter().enumerate() {
                let at = first + (p * self.per_point + arm * self.components + slot) * distance;
                rest[c] -= w * solid.dashpots[at].f64();
            }
        }
        rest
    }
}

/// Weights that interpolate the dashpots' strains. The kernel keeps them times the factor that its metric has over the
/// inverse Jacobian, see [`Metric`]; it is taken off here.
fn memory_weights(ground: &Ground, probe: &Probe) -> Vec<f64> {
    let (mesh, gll) = (ground.mesh(), ground.gll());
    let n = gll.len();
    let along = |a: usize| gll.interpolation(probe.local[a]);
    let (x, y) = (along(0), along(1));
    let z = if mesh.dimension == 3 { along(2) } else { vec![1.0] };
    let kind = Metric::of(mesh, probe.element);
    let of_point = |p: usize| {
        let (local, w) = point(gll, mesh.dimension, p);
        let det = determinant(&mesh.jacobian(probe.element, local));
        let factor = match kind {
            Metric::Affine => det.sqrt(),
            Metric::Corners => det,
            Metric::Stored => (w * det).sqrt(),
        };
        x[p % n] * y[p / n % n] * z[p / (n * n)] / factor
    };
    (0..ground.numbering().points).map(of_point).collect()
}

fn add_stress(stress: &mut [f64; 6], (lambda, mu): (f64, f64), gain: f64, e: &[f64; 6]) {
    let pressure = lambda * (e[0] + e[1] + e[2]);
    for c in 0..6 {
        stress[c] += gain * if c < 3 { pressure + 2.0 * mu * e[c] } else { mu * e[c] };
    }
}
