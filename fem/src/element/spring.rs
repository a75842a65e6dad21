//! Springs and dashpots, to the ground or between two nodes.

use super::{Element, MassForm, Recovery, bar::difference};
use crate::FemError;
use nalgebra::{DMatrix, DVector, Vector3};

/// One axis of a spring or dashpot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    direction: Vector3<f64>,
    rotational: bool,
    coefficient: f64,
}

impl Axis {
    /// Resists translation along `direction` (any length but zero) with `coefficient`, N/m or N·s/m.
    pub fn translation(direction: [f64; 3], coefficient: f64) -> Self {
        Self { direction: Vector3::from(direction), rotational: false, coefficient }
    }

    /// Resists rotation about `direction` with `coefficient`, N·m/rad or N·m·s/rad.
    pub fn rotation(direction: [f64; 3], coefficient: f64) -> Self {
        Self { direction: Vector3::from(direction), rotational: true, coefficient }
    }
}

/// Axes between one node and the ground, or between two nodes.
#[derive(Debug, Clone)]
struct Link {
    nodes: Vec<usize>,
    freedoms: usize,
    axes: Vec<Axis>,
}

impl Link {
    fn new(
        element: &'static str,
        nodes: &[usize],
        distance: Vector3<f64>,
        axes: &[Axis],
    ) -> Result<Self, FemError> {
        let refuse = |key, value, range| {
            Err(FemError::ElementProperty { element, nodes: nodes.to_vec(), key, value, range })
        };
        let span = distance.norm();
        let mut unit = vec![];
        for axis in axes {
            let norm = axis.direction.norm();
            if !(norm > 0.0 && norm.is_finite()) {
                return refuse("length of the direction", norm, "above 0");
            }
            if !(axis.coefficient >= 0.0 && axis.coefficient.is_finite()) {
                return refuse("coefficient", axis.coefficient, "0 or more");
            }
            let direction = axis.direction / norm;
            if let [first, second] = *nodes
                && !axis.rotational
                && distance.cross(&direction).norm() > 1e-9 * span
            {
                return Err(FemError::SpringSpan { element, nodes: [first, second], distance: span });
            }
            unit.push(Axis { direction, ..*axis });
        }
        let freedoms = if axes.iter().any(|axis| axis.rotational) { 6 } else { 3 };
        Ok(Self { nodes: nodes.to_vec(), freedoms, axes: unit })
    }

    /// Row that draws the axis' motion from the freedoms of one node.
    fn row(&self, axis: &Axis) -> DVector<f64> {
        let mut row = DVector::zeros(self.freedoms);
        row.rows_mut(if axis.rotational { 3 } else { 0 }, 3).copy_from(&axis.direction);
        row
    }

    fn matrix(&self) -> DMatrix<f64> {
        let mut block = DMatrix::zeros(self.freedoms, self.freedoms);
        for axis in &self.axes {
            let row = self.row(axis);
            block.ger(axis.coefficient, &row, &row, 1.0);
        }
        if self.nodes.len() == 2 { difference(&block) } else { block }
    }

    fn zeros(&self) -> DMatrix<f64> {
        let n = self.freedoms * self.nodes.len();
        DMatrix::zeros(n, n)
    }

    fn forces(&self, displacement: &[f64]) -> Vec<f64> {
        let u = DVector::from_column_slice(displacement);
        let first = u.rows(0, self.freedoms);
        let drawn = match self.nodes.len() {
            2 => u.rows(self.freedoms, self.freedoms) - first,
            _ => first.into_owned(),
        };
        self.axes.iter().map(|axis| axis.coefficient * self.row(axis).dot(&drawn)).collect()
    }
}

/// From the first node to the second; nothing where they lie in one place but for rounding (1e-9 m, or
/// 1e-9 of their distance from the origin).
fn span(positions: [[f64; 3]; 2]) -> Vector3<f64> {
    let [first, second] = positions.map(Vector3::from);
    let rounding = 1e-9 * first.norm().max(second.norm()).max(1.0);
    if (second - first).norm() > rounding { second - first } else { Vector3::zeros() }
}

/// Linear spring of one or more axes: force = stiffness × motion of the second node less the first's
/// (to the ground: of the node).
///
/// A translation axis between two nodes must lie along the line between them, unless they lie in one
/// place: otherwise a rigid rotation would give force.
#[derive(Debug, Clone)]
pub struct Spring(Link);

impl Spring {
    /// Spring between `node` and the ground (which moves with the base). Errors: a zero direction, a
    /// negative stiffness.
    pub fn to_ground(node: usize, axes: &[Axis]) -> Result<Self, FemError> {
        Link::new("spring", &[node], Vector3::zeros(), axes).map(Self)
    }

    /// Spring between two `nodes` at `positions` (m). Errors: as above; an axis across the span.
    pub fn between(nodes: [usize; 2], positions: [[f64; 3]; 2], axes: &[Axis]) -> Result<Self, FemError> {
        Link::new("spring", &nodes, span(positions), axes).map(Self)
    }
}

/// Linear dashpot of one or more axes: force = coefficient × relative velocity. Rules as [`Spring`].
#[derive(Debug, Clone)]
pub struct Dashpot(Link);

impl Dashpot {
    /// Dashpot between `node` and the ground (which moves with the base). Errors: as [`Spring`].
    pub fn to_ground(node: usize, axes: &[Axis]) -> Result<Self, FemError> {
        Link::new("dashpot", &[node], Vector3::zeros(), axes).map(Self)
    }

    /// Dashpot between two `nodes` at `positions` (m). Errors: as [`Spring`].
    pub fn between(nodes: [usize; 2], positions: [[f64; 3]; 2], axes: &[Axis]) -> Result<Self, FemError> {
        Link::new("dashpot", &nodes, span(positions), axes).map(Self)
    }
}

impl Element for Spring {
    fn kind(&self) -> &'static str {
        "spring"
    }

    fn nodes(&self) -> &[usize] {
        &self.0.nodes
    }

    fn freedoms_per_node(&self) -> usize {
        self.0.freedoms
    }

    fn total_mass(&self) -> f64 {
        0.0
    }

    fn stiffness(&self) -> DMatrix<f64> {
        self.0.matrix()
    }

    fn mass(&self, _form: MassForm) -> DMatrix<f64> {
        self.0.zeros()
    }

    fn recover(&self, displacement: &[f64], _gravity: [f64; 3]) -> Recovery {
        Recovery::Axes(self.0.forces(displacement))
    }
}

impl Element for Dashpot {
    fn kind(&self) -> &'static str {
        "dashpot"
    }

    fn nodes(&self) -> &[usize] {
        &self.0.nodes
    }

    fn freedoms_per_node(&self) -> usize {
        self.0.freedoms
    }

    fn total_mass(&self) -> f64 {
        0.0
    }

    fn stiffness(&self) -> DMatrix<f64> {
        self.0.zeros()
    }

    fn mass(&self, _form: MassForm) -> DMatrix<f64> {
        self.0.zeros()
    }

    fn damping(&self) -> Option<DMatrix<f64>> {
        Some(self.0.matrix())
    }

    fn recover(&self, _displacement: &[f64], _gravity: [f64; 3]) -> Recovery {
        Recovery::Nothing
    }
}
