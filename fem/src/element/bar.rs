//! Bar between two nodes.

use super::{Element, MassForm, Recovery};
use crate::{FemError, material::Material};
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Straight bar that carries axial force only, $N = EA\,\Delta l/l$; its nodes need translations only.
///
/// Frequencies converge with order 2.
#[derive(Debug, Clone)]
pub struct Bar {
    nodes: [usize; 2],
    axis: Vector3<f64>,
    length: f64,
    area: f64,
    material: Material,
}

impl Bar {
    /// Bar between `nodes` at `positions` (m) of section `area` (m²). Errors: length or area zero.
    pub fn new(
        nodes: [usize; 2],
        positions: [[f64; 3]; 2],
        area: f64,
        material: Material,
    ) -> Result<Self, FemError> {
        let [start, end] = positions.map(Vector3::from);
        let length = (end - start).norm();
        if !(length > 1e-12 * start.norm().max(end.norm()) && length.is_finite()) {
            return Err(FemError::ZeroLength { element: "bar", nodes, length });
        }
        if !(area > 0.0 && area.is_finite()) {
            return Err(FemError::ElementProperty {
                element: "bar",
                nodes: nodes.to_vec(),
                key: "area",
                value: area,
                range: "above 0 m²",
            });
        }
        Ok(Self { nodes, axis: (end - start) / length, length, area, material })
    }

    fn axial(&self, displacement: &[f64]) -> f64 {
        let drawn =
            Vector3::from_column_slice(&displacement[3..6]) - Vector3::from_column_slice(&displacement[..3]);
        self.material.young() * self.area / self.length * self.axis.dot(&drawn)
    }
}

/// $\begin{pmatrix} k & -k \\ -k & k \end{pmatrix}$.
pub(super) fn difference(block: &DMatrix<f64>) -> DMatrix<f64> {
    let n = block.nrows();
    let mut full = DMatrix::zeros(2 * n, 2 * n);
    for (i, j, sign) in [(0, 0, 1.0), (0, n, -1.0), (n, 0, -1.0), (n, n, 1.0)] {
        full.view_mut((i, j), (n, n)).copy_from(&(block * sign));
    }
    full
}

fn dynamic(block: Matrix3<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(3, 3, block.as_slice())
}

impl Element for Bar {
    fn kind(&self) -> &'static str {
        "bar"
    }

    fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    fn freedoms_per_node(&self) -> usize {
        3
    }

    fn total_mass(&self) -> f64 {
        self.material.density() * self.area * self.length
    }

    fn stiffness(&self) -> DMatrix<f64> {
        let along = self.axis * self.axis.transpose() * (self.material.young() * self.area / self.length);
        difference(&dynamic(along))
    }

    fn mass(&self, form: MassForm) -> DMatrix<f64> {
        let (own, other) = match form {
            MassForm::Consistent => (1.0 / 3.0, 1.0 / 6.0),
            MassForm::Lumped => (0.5, 0.0),
        };
        let mass = self.total_mass();
        DMatrix::from_fn(6, 6, |i, j| match (i == j, i % 3 == j % 3) {
            (true, _) => own * mass,
            (false, true) => other * mass,
            _ => 0.0,
        })
    }

    /// $\frac{N}{l}(I - n n^T)$ between the nodes.
    fn geometric_stiffness(&self, displacement: &[f64]) -> Option<DMatrix<f64>> {
        let across = Matrix3::identity() - self.axis * self.axis.transpose();
        Some(difference(&dynamic(across * (self.axial(displacement) / self.length))))
    }

    /// The mean axial force; a bar's own weight makes it differ by half of it at the ends.
    fn recover(&self, displacement: &[f64], _gravity: [f64; 3]) -> Recovery {
        Recovery::Axial(self.axial(displacement))
    }
}
