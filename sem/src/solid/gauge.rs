//! Strain and stress at a place.

use super::geometry::{Metric, point};
use super::ground::{Ground, Probe};
use super::kernel::strain_components;
use super::{Real, Solid};
use crate::mesh::determinant;
use hati_coupling::Subdomain;
use nalgebra::{DMatrix, DVector};

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
/// γ of the arms' dashpots interpolated from the element's points. Where memory is coarse-grained ([`super::Memory`]) these
/// are the moduli of the material, not of any point, and γ follows from the points that keep it, by the polynomial that
/// fits them best. On a side between elements it is the side of the element
/// that the [`Probe`] names.
#[derive(Debug, Clone)]
pub struct Gauge {
    /// First number and stride of each local point in the solid's arrays.
    places: Vec<(u32, u32)>,
    gradients: Vec<[f64; 3]>,
    /// Relaxed λ and μ, Pa.
    relaxed: (f64, f64),
    arms: Vec<GaugeArm>,
    /// First dashpot of the element, and the distance of two of its numbers.
    dashpots: (usize, usize),
    components: usize,
}

/// One arm at the place.
#[derive(Debug, Clone)]
struct GaugeArm {
    gain: f64,
    /// λ and μ, Pa.
    moduli: (f64, f64),
    /// First dashpot number of a point in the element, and its weight.
    weights: Vec<(usize, f64)>,
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
        let lane = layout.element.iter().position(|&e| e as usize == probe.element).unwrap_or(0);
        let (batch, lane) = (lane / layout.lanes, lane % layout.lanes);
        let components = strain_components(solid.model.planes());
        let arm = |l: usize| {
            let own = |(p, slot, weight)| ((p * solid.model.arms + slot) * components, weight);
            GaugeArm {
                gain: 1.0 / (1.0 + 0.5 * material.omega()[l] * solid.dt()),
                moduli: material.arm(l),
                weights: memory_weights(ground, probe, l).into_iter().map(own).collect(),
            }
        };
        Self {
            places,
            gradients: ground.basis_gradients(probe.element, probe.local),
            relaxed: material.relaxed(),
            arms: (0..material.omega().len()).map(arm).collect(),
            dashpots: (batch * solid.model.dashpots_per_batch() + lane, layout.lanes),
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
        for arm in &self.arms {
            add_stress(&mut stress, arm.moduli, arm.gain, &self.elastic_part(solid, arm, &e));
        }
        let mut found = Tensors::default();
        for (c, &to) in PLACE.iter().enumerate() {
            found.strain[to] = if c < 3 { e[c] } else { 0.5 * e[c] };
            found.stress[to] = stress[c];
        }
        found
    }

    /// Strain of an arm's spring before its gain, ε − γ.
    fn elastic_part<T: Real>(&self, solid: &Solid<T>, arm: &GaugeArm, e: &[f64; 6]) -> [f64; 6] {
        let mut rest = *e;
        let (first, distance) = self.dashpots;
        // a section keeps no εyy
        let kept = (0..6).filter(|c| self.components == 6 || *c != 1);
        for (slot, c) in kept.enumerate() {
            for (number, w) in &arm.weights {
                rest[c] -= w * solid.dashpots[first + (number + slot) * distance].f64();
            }
        }
        rest
    }
}

/// Point, its slot and weight, of the points that keep a mechanism: they give the strain of its dashpot at a probe. The
/// kernel keeps strains times the factor that its metric has over the inverse Jacobian, see [`Metric`]; it is taken off here.
fn memory_weights(ground: &Ground, probe: &Probe, mechanism: usize) -> Vec<(usize, usize, f64)> {
    let (mesh, gll) = (ground.mesh(), ground.gll());
    let kept: Vec<(usize, usize)> = (0..ground.numbering().points)
        .filter_map(|p| {
            let slot = ground.law(probe.element, p).arms.iter().position(|a| a.mechanism == mechanism)?;
            Some((p, slot))
        })
        .collect();
    let weights = if kept.len() == ground.numbering().points {
        interpolation(ground, probe)
    } else {
        fitted(ground, probe, &kept)
    };
    let kind = Metric::of(mesh, probe.element);
    let factor = |p: usize| {
        let (local, w) = point(gll, mesh.dimension, p);
        let det = determinant(&mesh.jacobian(probe.element, local));
        match kind {
            Metric::Affine => det.sqrt(),
            Metric::Corners => det,
            Metric::Stored => (w * det).sqrt(),
        }
    };
    kept.into_iter().zip(weights).map(|((p, slot), w)| (p, slot, w / factor(p))).collect()
}

/// The basis at a probe.
fn interpolation(ground: &Ground, probe: &Probe) -> Vec<f64> {
    let n = ground.gll().len();
    let along = |a: usize| ground.gll().interpolation(probe.local[a]);
    let (x, y) = (along(0), along(1));
    let z = if ground.mesh().dimension == 3 { along(2) } else { vec![1.0] };
    (0..ground.numbering().points).map(|p| x[p % n] * y[p / n % n] * z[p / (n * n)]).collect()
}

/// Weights of scattered points that give at a probe the polynomial which fits them best, in the mean of the quadrature's
/// squares. Its total degree is the highest whose monomials are at most three quarters of the points.
fn fitted(ground: &Ground, probe: &Probe, kept: &[(usize, usize)]) -> Vec<f64> {
    let dimension = ground.mesh().dimension;
    let monomials = |degree: i32| {
        let mut all = vec![];
        for a in 0..=degree {
            for b in 0..=degree - a {
                all.extend((0..=if dimension == 3 { degree - a - b } else { 0 }).map(|c| [a, b, c]));
            }
        }
        all
    };
    let most = (1..).take_while(|d| 4 * monomials(*d).len() <= 3 * kept.len()).last().unwrap_or(0);
    let powers = monomials(most);
    let value = |x: &[f64; 3], p: &[i32; 3]| x.iter().zip(p).map(|(x, p)| x.powi(*p)).product::<f64>();
    let points: Vec<([f64; 3], f64)> =
        kept.iter().map(|&(p, _)| point(ground.gll(), dimension, p)).map(|(x, w)| (x, w.sqrt())).collect();
    // √w V c = √w γ in the mean of squares: the value at the place is a product of γ, least in norm
    let rows =
        DMatrix::from_fn(powers.len(), points.len(), |i, j| points[j].1 * value(&points[j].0, &powers[i]));
    let at = DVector::from_fn(powers.len(), |i, _| value(&probe.local, &powers[i]));
    let weights = rows.svd(true, true).solve(&at, 1e-10).unwrap_or_else(|_| DVector::zeros(points.len()));
    points.iter().zip(weights.iter()).map(|((_, root), w)| w * root).collect()
}

fn add_stress(stress: &mut [f64; 6], (lambda, mu): (f64, f64), gain: f64, e: &[f64; 6]) {
    let pressure = lambda * (e[0] + e[1] + e[2]);
    for c in 0..6 {
        stress[c] += gain * if c < 3 { pressure + 2.0 * mu * e[c] } else { mu * e[c] };
    }
}
