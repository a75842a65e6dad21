//! Mass at a node.

use super::{Element, MassForm, Recovery};
use crate::FemError;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Rigid body fixed to a node: mass $m$, inertia tensor $I_c$ about its own centre, centre at
/// $r$ from the node.
///
/// With $\hat r$ the matrix of $r \times$, its centre moves with $\dot u + \dot\theta \times r$, so that
/// $M = \begin{pmatrix} m I & -m \hat r \\ m \hat r & I_c - m \hat r \hat r
/// \end{pmatrix}$. Without inertia and eccentricity the node needs translations only. Its weight
/// at an eccentricity adds no geometric stiffness here.
#[derive(Debug, Clone)]
pub struct PointMass {
    node: [usize; 1],
    mass: f64,
    inertia: Matrix3<f64>,
    eccentricity: Vector3<f64>,
}

impl PointMass {
    /// Mass at `node`, kg. Errors: a negative mass.
    pub fn new(node: usize, mass: f64) -> Result<Self, FemError> {
        if !(mass >= 0.0 && mass.is_finite()) {
            return Err(FemError::ElementProperty {
                element: "point mass",
                nodes: vec![node],
                key: "mass",
                value: mass,
                range: "0 kg or more",
            });
        }
        Ok(Self { node: [node], mass, inertia: Matrix3::zeros(), eccentricity: Vector3::zeros() })
    }

    /// The same mass with an inertia tensor about its centre, kg·m², global axes:
    /// $I_{xx}, I_{yy}, I_{zz}, I_{xy}, I_{yz}, I_{zx}$ (tensor components: $I_{xy} = -\int xy\,dm$).
    ///
    /// Errors: principal moments of which one is negative or above the sum of the others.
    pub fn with_inertia(mut self, tensor: [f64; 6]) -> Result<Self, FemError> {
        let [xx, yy, zz, xy, yz, zx] = tensor;
        self.inertia = Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz);
        let mut principal: [f64; 3] = self.inertia.symmetric_eigenvalues().into();
        principal.sort_by(f64::total_cmp);
        let slack = 1e-9 * principal[2].abs();
        let body = principal[0] >= -slack && principal[2] <= principal[0] + principal[1] + slack;
        if !(body && principal.iter().all(|p| p.is_finite())) {
            return Err(FemError::Inertia { node: self.node[0], principal });
        }
        Ok(self)
    }

    /// The same mass with its centre at `eccentricity` from the node, m, global axes. Errors: a number
    /// that is not finite.
    pub fn with_eccentricity(mut self, eccentricity: [f64; 3]) -> Result<Self, FemError> {
        if let Some(&value) = eccentricity.iter().find(|r| !r.is_finite()) {
            return Err(FemError::ElementProperty {
                element: "point mass",
                nodes: self.node.to_vec(),
                key: "eccentricity",
                value,
                range: "finite, m",
            });
        }
        self.eccentricity = Vector3::from(eccentricity);
        Ok(self)
    }
}

impl Element for PointMass {
    fn kind(&self) -> &'static str {
        "point mass"
    }

    fn nodes(&self) -> &[usize] {
        &self.node
    }

    fn freedoms_per_node(&self) -> usize {
        let translations_only = self.inertia == Matrix3::zeros() && self.eccentricity == Vector3::zeros();
        if translations_only { 3 } else { 6 }
    }

    fn total_mass(&self) -> f64 {
        self.mass
    }

    fn stiffness(&self) -> DMatrix<f64> {
        let n = self.freedoms_per_node();
        DMatrix::zeros(n, n)
    }

    /// The same in both forms: an eccentric mass couples translation and rotation whatever is asked.
    fn mass(&self, _form: MassForm) -> DMatrix<f64> {
        let n = self.freedoms_per_node();
        let mut mass = DMatrix::from_fn(n, n, |i, j| if i == j && i < 3 { self.mass } else { 0.0 });
        if n == 6 {
            let arm = self.eccentricity.cross_matrix();
            mass.view_mut((0, 3), (3, 3)).copy_from(&(arm * -self.mass));
            mass.view_mut((3, 0), (3, 3)).copy_from(&(arm * self.mass));
            mass.view_mut((3, 3), (3, 3)).copy_from(&(self.inertia - arm * arm * self.mass));
        }
        mass
    }

    fn recover(&self, _displacement: &[f64], _gravity: [f64; 3]) -> Recovery {
        Recovery::Nothing
    }
}
