//! Frequency response of the *discrete* column, time stepping included.
//!
//! For a motion $e^{i\omega t}$ sampled at the kicks the drift–kick–drift step turns $-\omega^2$ into
//! $-\tfrac{4}{\Delta t^2}\sin^2\tfrac{\omega\Delta t}{2}$, the dashpot's $i\omega$ into
//! $i\sin(\omega\Delta t)/\Delta t$ and the arms' $i\omega$ into
//! $i\tfrac{2}{\Delta t}\tan\tfrac{\omega\Delta t}{2}$. With these symbols the response is that of the
//! time loop to round-off, so that sizes can be chosen, errors predicted and motions deconvolved
//! without stepping. Without a step ([`TimeSymbol::Continuous`]) it is the semi-discrete response.
//!
//! An element's inner freedoms are condensed in the eigenbasis of the reference element,
//! $K_{ii}\varphi = \mu W_{ii}\varphi$: with stiffness factor $k = 2G/h$ and mass factor
//! $m = \tfrac{h}{2}\rho\,s$ the inverse is $\sum\varphi\varphi^T/(k\mu + m)$, the same basis for every
//! element and frequency. Cost: $O(N)$ per distinct element and frequency.

use super::mesh::{Discretisation, Mesh, Probe};
use crate::SemError;
use crate::attenuation::ModulusLaw;
use crate::gll::Gll;
use crate::soil::Profile;
use hati_coupling::central_difference::{acceleration_symbol, trapezoidal_symbol, velocity_symbol};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use num_complex::Complex64;

/// How time derivatives act on $e^{i\omega t}$.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeSymbol {
    /// Exact derivatives.
    Continuous,
    /// Drift–kick–drift with this step, s.
    CentralDifference(f64),
}

impl TimeSymbol {
    /// Symbols of acceleration, of the dashpot's velocity and of the arms' rate for a motion $e^{st}$.
    fn at(self, s: Complex64) -> (Complex64, Complex64, Complex64) {
        match self {
            Self::Continuous => (s * s, s, s),
            Self::CentralDifference(dt) => {
                (acceleration_symbol(s, dt), velocity_symbol(s, dt), trapezoidal_symbol(s, dt))
            }
        }
    }
}

/// What a column does at one frequency.
#[derive(Debug, Clone)]
pub struct Transfer {
    /// Acceleration at each probe for a unit acceleration of the base (within).
    pub per_within: Vec<Complex64>,
    /// Acceleration of the base for a unit outcrop acceleration; 1 for a rigid base, whose motion is imposed.
    pub within_per_outcrop: Complex64,
}

/// The discrete column of one component in the frequency domain.
#[derive(Debug, Clone)]
pub struct FrequencyResponse {
    reference: ReferenceElement,
    /// Per layer: elements, height, modulus, density, law.
    layers: Vec<LayerElements>,
    impedance: Option<f64>,
    symbol: TimeSymbol,
    probes: Vec<ProbeInLayer>,
}

#[derive(Debug, Clone)]
struct LayerElements {
    count: usize,
    height: f64,
    modulus: f64,
    rho: f64,
    law: ModulusLaw,
}

#[derive(Debug, Clone)]
struct ProbeInLayer {
    element: usize,
    layer: usize,
    ends: [f64; 2],
    inner: Vec<f64>,
}

/// Least dynamic stiffness of an inner mode over its stiffness.
const INNER_FLOOR: f64 = 1e-8;

/// The reference element in the eigenbasis of its inner freedoms.
#[derive(Debug, Clone)]
struct ReferenceElement {
    corner: f64,
    across: f64,
    end_weight: f64,
    mu: Vec<f64>,
    first: Vec<f64>,
    last: Vec<f64>,
    basis: DMatrix<f64>,
}

impl ReferenceElement {
    fn new(gll: &Gll) -> Self {
        let n = gll.len();
        let d = |i: usize, j: usize| gll.derivative[i * n + j];
        let k =
            DMatrix::from_fn(n, n, |i, j| (0..n).map(|q| gll.weights[q] * d(q, i) * d(q, j)).sum::<f64>());
        let inner = n - 2;
        let root: Vec<f64> = gll.weights[1..n - 1].iter().map(|w| w.sqrt()).collect();
        let scaled = DMatrix::from_fn(inner, inner, |i, j| k[(i + 1, j + 1)] / (root[i] * root[j]));
        let (mu, mut basis) = if inner == 0 {
            (DVector::zeros(0), DMatrix::zeros(0, 0))
        } else {
            let eigen = SymmetricEigen::new(scaled);
            (eigen.eigenvalues, eigen.eigenvectors)
        };
        for i in 0..inner {
            basis.row_mut(i).scale_mut(1.0 / root[i]);
        }
        let project = |column: usize| -> Vec<f64> {
            (0..inner).map(|j| (0..inner).map(|i| basis[(i, j)] * k[(i + 1, column)]).sum()).collect()
        };
        Self {
            corner: k[(0, 0)],
            across: k[(0, n - 1)],
            end_weight: gll.weights[0],
            first: project(0),
            last: project(n - 1),
            mu: mu.iter().copied().collect(),
            basis,
        }
    }

    /// Dynamic stiffness $k\mu_j + m$ of an inner mode, kept from vanishing.
    ///
    /// Without damping it is zero where an element with fixed ends resonates, although the column does
    /// not: the condensed terms are then differences of infinities. Round frequencies and round layers
    /// do meet there exactly. Moving the mode by 1e-8 of its stiffness changes the response by about as
    /// much and leaves half of the digits.
    fn inner(&self, k: Complex64, m: Complex64, j: usize) -> Complex64 {
        let stiffness = k * self.mu[j];
        let dynamic = stiffness + m;
        if dynamic.norm() < INNER_FLOOR * stiffness.norm() { INNER_FLOOR * stiffness } else { dynamic }
    }

    /// Condensed end stiffness (diagonal, off-diagonal) for factors k of stiffness and m of mass.
    fn condensed(&self, k: Complex64, m: Complex64) -> (Complex64, Complex64) {
        let mut diagonal = k * self.corner + m * self.end_weight;
        let mut across = k * self.across;
        for j in 0..self.mu.len() {
            let share = k * k / self.inner(k, m, j);
            diagonal -= share * (self.first[j] * self.first[j]);
            across -= share * (self.first[j] * self.last[j]);
        }
        (diagonal, across)
    }
}

impl FrequencyResponse {
    /// Prepares the response of one component. `laws` holds one modulus law per layer.
    pub fn new(
        profile: &Profile,
        discretisation: &Discretisation,
        axis: usize,
        laws: &[ModulusLaw],
        symbol: TimeSymbol,
        depths: &[f64],
    ) -> Result<Self, SemError> {
        let mesh = Mesh::new(profile, discretisation)?;
        let reference = ReferenceElement::new(&mesh.gll);
        let layers = (profile.layers.iter().zip(&discretisation.elements).zip(laws))
            .map(|((l, &count), law)| LayerElements {
                count,
                height: l.thickness / count as f64,
                modulus: l.modulus(axis),
                rho: l.rho,
                law: law.clone(),
            })
            .collect();
        let probes = depths
            .iter()
            .map(|&depth| {
                let Probe { element, weights, .. } = mesh.probe(depth)?;
                let n = weights.len();
                let inner = (0..n - 2)
                    .map(|j| (0..n - 2).map(|i| weights[i + 1] * reference.basis[(i, j)]).sum())
                    .collect();
                let ends = [weights[0], weights[n - 1]];
                Ok(ProbeInLayer { element, layer: mesh.elements[element].layer, ends, inner })
            })
            .collect::<Result<_, SemError>>()?;
        Ok(Self { reference, layers, impedance: profile.base.impedance(axis), symbol, probes })
    }

    /// The same column with another step.
    pub fn with_symbol(&self, symbol: TimeSymbol) -> Self {
        Self { symbol, ..self.clone() }
    }

    /// Response at a frequency, Hz (> 0).
    pub fn at(&self, frequency: f64) -> Transfer {
        self.at_growing(frequency, 0.0)
    }

    /// Response to a motion $e^{(\sigma + i\omega)t}$ that grows at the rate `sigma` ≥ 0, 1/s.
    ///
    /// A growth of π times a frequency spacing shows resonances as wide as that spacing: what a sampled
    /// spectrum, or a run of finite length, can see of them.
    pub fn at_growing(&self, frequency: f64, sigma: f64) -> Transfer {
        let s = Complex64::new(sigma, 2.0 * std::f64::consts::PI * frequency);
        let (s_a, s_v, s_m) = self.symbol.at(s);
        // from the surface down: the impedance of what lies above, and each element's u_top / u_bottom
        let elements: usize = self.layers.iter().map(|l| l.count).sum();
        let mut ratio = Vec::with_capacity(elements);
        let mut factors = Vec::with_capacity(self.layers.len());
        let mut above = Complex64::ZERO;
        for layer in &self.layers {
            let k = layer.modulus * layer.law.factor(s_m) * (2.0 / layer.height);
            let m = s_a * layer.rho * 0.5 * layer.height;
            let (diagonal, across) = self.reference.condensed(k, m);
            factors.push((k, m));
            for _ in 0..layer.count {
                let r = -across / (diagonal + above);
                above = diagonal + across * r;
                ratio.push(r);
            }
        }
        // from the base up: displacement at element ends for a unit base displacement
        let mut end = vec![Complex64::ONE; elements + 1];
        for e in (0..elements).rev() {
            end[e] = ratio[e] * end[e + 1];
        }
        let motion = |p: &ProbeInLayer| {
            let (top, bottom) = (end[p.element], end[p.element + 1]);
            let (k, m) = factors[p.layer];
            let mut u = p.ends[0] * top + p.ends[1] * bottom;
            for (j, phi) in p.inner.iter().enumerate() {
                let load = self.reference.first[j] * top + self.reference.last[j] * bottom;
                u -= *phi * k * load / self.reference.inner(k, m, j);
            }
            u
        };
        // the base moves as the record says (exact s²); what the column makes of it is seen at the kicks
        let seen = s_a / (s * s);
        let within_per_outcrop = match self.impedance {
            None => Complex64::ONE,
            Some(z) => s_a * z / (s * (above + z * s_v)),
        };
        let scale = if self.impedance.is_none() { seen } else { Complex64::ONE };
        Transfer { per_within: self.probes.iter().map(|p| scale * motion(p)).collect(), within_per_outcrop }
    }
}
