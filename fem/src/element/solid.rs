//! Solids: hexahedra of 8 and 20 nodes, tetrahedra of 10.
//!
//! All three share one frame: at a point the strain is $\varepsilon = \bar B u$ and
//! $K = \int \bar B^T D \bar B\,dV$. What $\bar B$ is tells them apart:
//!
//! - hex8: $\bar B = B + \Gamma A$, enhanced strains eliminated in the element;
//! - hex20: the volumetric part of $B$ projected on linear fields;
//! - tet10: $B$ itself.

mod hex20;
mod hex8;
mod quadrature;
mod tet10;

pub use hex8::Hex8Shape;
pub(crate) use hex20::EDGES as HEX_EDGES;
pub use hex20::Hex20Shape;
pub use quadrature::Point;
pub(crate) use tet10::EDGES as TET_EDGES;
pub use tet10::Tet10Shape;

use super::{Element, MassForm, Recovery};
use crate::{FemError, material::Material};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3, Vector6};
use std::{fmt::Debug, marker::PhantomData};

/// Hexahedron of 8 nodes with enhanced strains, see [`Hex8Shape`].
pub type Hex8 = Solid<Hex8Shape>;
/// Hexahedron of 20 nodes, see [`Hex20Shape`].
pub type Hex20 = Solid<Hex20Shape>;
/// Tetrahedron of 10 nodes, see [`Tet10Shape`].
pub type Tet10 = Solid<Tet10Shape>;

/// What sets a solid element apart from the others.
pub trait SolidShape: Debug + Send + Sync + Sized + 'static {
    /// Name.
    const NAME: &'static str;
    /// Number of nodes.
    const NODES: usize;
    /// Nodes in reference coordinates.
    fn reference() -> &'static [[f64; 3]];
    /// Centre in reference coordinates.
    fn centre() -> [f64; 3];
    /// Shape functions $N_a(\xi)$.
    fn values(xi: [f64; 3]) -> Vec<f64>;
    /// Their gradients $\partial N_a/\partial\xi_j$.
    fn gradients(xi: [f64; 3]) -> Vec<[f64; 3]>;
    /// Points and weights for the stiffness.
    fn rule() -> &'static [Point];
    /// Points and weights for mass and loads.
    fn mass_rule() -> &'static [Point];
    /// Whether the lumped mass is by row sums (else by scaling the diagonal).
    const LUMPED_BY_ROWS: bool;
    /// What the strain is beyond $B u$.
    fn enhancement(_solid: &Solid<Self>) -> Enhancement {
        Enhancement::None
    }
}

/// How the strain departs from that of the displacement alone.
#[derive(Debug)]
pub enum Enhancement {
    /// It does not.
    None,
    /// Enhanced modes: amplitudes $\alpha = A u$, one row per mode.
    Modes(DMatrix<f64>),
    /// Linear dilatation: coefficients of $1, x, y, z$ about the centre, one row each.
    Dilatation(DMatrix<f64>),
}

/// Stress at a point of a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StressPoint {
    /// Position, m.
    pub position: [f64; 3],
    /// $\sigma_x, \sigma_y, \sigma_z, \tau_{xy}, \tau_{yz}, \tau_{zx}$, Pa, tension positive.
    pub stress: [f64; 6],
}

/// A solid element of shape `S`.
#[derive(Debug, Clone)]
pub struct Solid<S> {
    nodes: Vec<usize>,
    coordinates: Vec<Vector3<f64>>,
    material: Material,
    shape: PhantomData<S>,
}

/// A place in an element: the Jacobian's determinant and the gradients of the shape functions in space.
#[derive(Debug)]
struct Place {
    determinant: f64,
    gradients: Vec<Vector3<f64>>,
}

impl<S: SolidShape> Solid<S> {
    /// Solid on `nodes` at `positions` (m), in Gmsh's node order.
    ///
    /// Errors: another number of nodes than the shape has; numbered inside out; a Jacobian
    /// determinant not above 0 at a node or a quadrature point.
    pub fn new(nodes: &[usize], positions: &[[f64; 3]], material: Material) -> Result<Self, FemError> {
        for found in [nodes.len(), positions.len()] {
            if found != S::NODES {
                return Err(FemError::NodeCount { element: S::NAME, found, expected: S::NODES });
            }
        }
        let coordinates = positions.iter().map(|&x| Vector3::from(x)).collect();
        let solid = Self { nodes: nodes.to_vec(), coordinates, material, shape: PhantomData };
        solid.check_jacobian()?;
        Ok(solid)
    }

    fn check_jacobian(&self) -> Result<(), FemError> {
        let (element, nodes) = (S::NAME, self.nodes.clone());
        let centre = self.jacobian(S::centre()).determinant();
        // rounding of a flat element is not a volume
        let span = self.coordinates.iter().map(|x| (x - self.coordinates[0]).norm()).fold(0.0, f64::max);
        let least = 1e-12 * span.powi(3);
        if centre < -least {
            return Err(FemError::InsideOut { element, nodes, jacobian: centre });
        }
        let quadrature = S::rule().iter().map(|p| p.xi);
        let places = S::reference().iter().copied().chain(quadrature).chain([S::centre()]);
        let worst = places.map(|xi| (self.jacobian(xi).determinant(), xi)).min_by(|a, b| a.0.total_cmp(&b.0));
        match worst {
            // a determinant that is no number compares as greater than all
            Some((jacobian, place)) if jacobian <= least || jacobian.is_nan() => {
                Err(FemError::Jacobian { element, nodes, jacobian, place })
            }
            _ => Ok(()),
        }
    }

    /// Jacobian $J_{ij} = \partial x_i/\partial \xi_j$ at `xi`, m.
    pub fn jacobian(&self, xi: [f64; 3]) -> Matrix3<f64> {
        let mut jacobian = Matrix3::zeros();
        for (x, gradient) in self.coordinates.iter().zip(S::gradients(xi)) {
            jacobian += x * Vector3::from(gradient).transpose();
        }
        jacobian
    }

    /// Volume, m³.
    pub fn volume(&self) -> f64 {
        S::mass_rule().iter().map(|p| p.weight * self.jacobian(p.xi).determinant()).sum()
    }

    /// Consistent load $\int N^T b\,dV$ of a body force `force` (N/m³ at a position in m), N.
    pub fn body_load(&self, force: impl Fn([f64; 3]) -> [f64; 3]) -> DVector<f64> {
        let mut load = DVector::zeros(3 * S::NODES);
        for point in S::mass_rule() {
            let volume = point.weight * self.jacobian(point.xi).determinant();
            let values = S::values(point.xi);
            let body = force(self.position(&values));
            for (a, value) in values.iter().enumerate() {
                for i in 0..3 {
                    load[3 * a + i] += volume * value * body[i];
                }
            }
        }
        load
    }

    fn position(&self, values: &[f64]) -> [f64; 3] {
        self.coordinates.iter().zip(values).map(|(x, n)| x * *n).sum::<Vector3<f64>>().into()
    }

    fn place(&self, xi: [f64; 3]) -> Place {
        let gradients = S::gradients(xi);
        let mut jacobian = Matrix3::zeros();
        for (x, gradient) in self.coordinates.iter().zip(&gradients) {
            jacobian += x * Vector3::from(*gradient).transpose();
        }
        let determinant = jacobian.determinant();
        // the constructor saw to a determinant above 0
        let to_space = jacobian.try_inverse().unwrap_or_else(Matrix3::zeros).transpose();
        let gradients = gradients.iter().map(|g| to_space * Vector3::from(*g)).collect();
        Place { determinant, gradients }
    }

    fn centre_of_coordinates(&self) -> Vector3<f64> {
        self.coordinates.iter().sum::<Vector3<f64>>() / S::NODES as f64
    }

    /// $\bar B$ at a place, a column for each freedom.
    fn strain_operator(&self, xi: [f64; 3], place: &Place, enhancement: &Enhancement) -> Vec<Strain> {
        let mut operator = compatible_strain(place);
        match enhancement {
            Enhancement::None => {}
            Enhancement::Modes(amplitudes) => {
                let modes = hex8::enhanced_strain(self.jacobian(S::centre()), xi, place.determinant);
                for (strain, amplitude) in operator.iter_mut().zip(amplitudes.column_iter()) {
                    for (mode, factor) in modes.iter().zip(amplitude.iter()) {
                        *strain += mode * *factor;
                    }
                }
            }
            Enhancement::Dilatation(coefficients) => {
                let x = Vector3::from(self.position(&S::values(xi))) - self.centre_of_coordinates();
                let monomials = [1.0, x.x, x.y, x.z];
                for (strain, column) in operator.iter_mut().zip(coefficients.column_iter()) {
                    let projected: f64 = (0..4).map(|k| monomials[k] * column[k]).sum();
                    let change = (projected - strain[0] - strain[1] - strain[2]) / 3.0;
                    (0..3).for_each(|i| strain[i] += change);
                }
            }
        }
        operator
    }

    /// Stress at a reference place under `displacement`.
    fn stress(&self, xi: [f64; 3], enhancement: &Enhancement, displacement: &[f64]) -> Strain {
        let operator = self.strain_operator(xi, &self.place(xi), enhancement);
        let strain: Strain = operator.iter().zip(displacement.iter()).map(|(b, u)| b * *u).sum();
        self.material.elasticity() * strain
    }

    fn scalar_mass(&self) -> DMatrix<f64> {
        let mut mass = DMatrix::zeros(S::NODES, S::NODES);
        for point in S::mass_rule() {
            let weight = self.material.density() * point.weight * self.jacobian(point.xi).determinant();
            let values = DVector::from_vec(S::values(point.xi));
            mass.ger(weight, &values, &values, 1.0);
        }
        mass
    }

    fn lumped(&self, consistent: &DMatrix<f64>) -> DVector<f64> {
        if S::LUMPED_BY_ROWS {
            return consistent.column_sum();
        }
        let diagonal = consistent.diagonal();
        let trace = diagonal.sum();
        if trace > 0.0 { diagonal * (consistent.sum() / trace) } else { diagonal }
    }
}

/// Strain or stress: normal components along x, y, z, then the shears xy, yz, zx (angles in full).
type Strain = Vector6<f64>;

/// $B$ of the displacement's own strain, a column for each freedom.
fn compatible_strain(place: &Place) -> Vec<Strain> {
    let columns = place.gradients.iter().flat_map(|g| {
        [
            Strain::new(g.x, 0.0, 0.0, g.y, 0.0, g.z),
            Strain::new(0.0, g.y, 0.0, g.x, g.z, 0.0),
            Strain::new(0.0, 0.0, g.z, 0.0, g.y, g.x),
        ]
    });
    columns.collect()
}

fn times_identity(scalar: &DMatrix<f64>) -> DMatrix<f64> {
    let n = scalar.nrows();
    let mut full = DMatrix::zeros(3 * n, 3 * n);
    for a in 0..n {
        for b in 0..n {
            for i in 0..3 {
                full[(3 * a + i, 3 * b + i)] = scalar[(a, b)];
            }
        }
    }
    full
}

impl<S: SolidShape> Element for Solid<S> {
    fn kind(&self) -> &'static str {
        S::NAME
    }

    fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    fn freedoms_per_node(&self) -> usize {
        3
    }

    fn total_mass(&self) -> f64 {
        self.material.density() * self.volume()
    }

    fn stiffness(&self) -> DMatrix<f64> {
        let enhancement = S::enhancement(self);
        let elasticity = self.material.elasticity();
        let mut stiffness = DMatrix::zeros(3 * S::NODES, 3 * S::NODES);
        for point in S::rule() {
            let place = self.place(point.xi);
            let volume = point.weight * place.determinant;
            let strains = self.strain_operator(point.xi, &place, &enhancement);
            for (j, strain) in strains.iter().enumerate() {
                let stress = elasticity * strain * volume;
                // the lower half; the upper is its mirror
                for (entry, other) in stiffness.column_mut(j).iter_mut().zip(&strains).skip(j) {
                    *entry += stress.dot(other);
                }
            }
        }
        stiffness.fill_upper_triangle_with_lower_triangle();
        stiffness
    }

    fn mass(&self, form: MassForm) -> DMatrix<f64> {
        let consistent = self.scalar_mass();
        times_identity(&match form {
            MassForm::Consistent => consistent,
            MassForm::Lumped => DMatrix::from_diagonal(&self.lumped(&consistent)),
        })
    }

    /// $K_\sigma = \int \nabla N_a^T \sigma \nabla N_b\,dV\; I_3$.
    fn geometric_stiffness(&self, displacement: &[f64]) -> Option<DMatrix<f64>> {
        let enhancement = S::enhancement(self);
        let mut scalar = DMatrix::zeros(S::NODES, S::NODES);
        for point in S::rule() {
            let place = self.place(point.xi);
            let s = self.stress(point.xi, &enhancement, displacement);
            let tensor = Matrix3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]);
            let volume = point.weight * place.determinant;
            for (a, ga) in place.gradients.iter().enumerate() {
                let pull = tensor * ga * volume;
                for (b, gb) in place.gradients.iter().enumerate() {
                    scalar[(a, b)] += pull.dot(gb);
                }
            }
        }
        Some(times_identity(&scalar))
    }

    /// Stresses at the centre, then at the nodes in their order.
    fn recover(&self, displacement: &[f64], _gravity: [f64; 3]) -> Recovery {
        let enhancement = S::enhancement(self);
        let places = std::iter::once(S::centre()).chain(S::reference().iter().copied());
        let stresses = places.map(|xi| StressPoint {
            position: self.position(&S::values(xi)),
            stress: self.stress(xi, &enhancement, displacement).into(),
        });
        Recovery::Stresses(stresses.collect())
    }
}
