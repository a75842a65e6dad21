//! Elements: what they store (stiffness, mass, damping) and what they tell (forces, stresses).
//!
//! - [`Beam`], [`Bar`]: members between two nodes;
//! - [`Hex8`], [`Hex20`], [`Tet10`]: solids;
//! - [`Spring`], [`Dashpot`], [`PointMass`]: at a node or between two.
//!
//! An element holds the positions of its nodes at the time it was made; geometry is checked there.

mod bar;
mod beam;
mod beam_shape;
mod point_mass;
mod solid;
mod spring;

pub use bar::Bar;
pub use beam::{Beam, EndReleases};
pub use point_mass::PointMass;
pub use solid::{
    Enhancement, Hex8, Hex8Shape, Hex20, Hex20Shape, Point, Solid, SolidShape, StressPoint, Tet10, Tet10Shape,
};
pub(crate) use solid::{HEX_EDGES, TET_EDGES};
pub use spring::{Axis, Dashpot, Spring};

use nalgebra::{DMatrix, DVector};
use std::fmt::Debug;

/// How the mass of an element is spread over its freedoms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MassForm {
    /// $M = \int \rho N^T N\,dV$ with the element's own shape functions.
    Consistent,
    /// Diagonal in the translations. Row sums for hex8 and bars; for hex20, tet10 and beams the
    /// consistent diagonal scaled to the element's mass (Hinton, Rock & Zienkiewicz 1976), since row
    /// sums of serendipity and quadratic tetrahedra are negative at corners. Frequencies of every solid
    /// then converge with order 2.
    Lumped,
}

/// Forces of a beam's section at a distance from its first end, in the beam's own axes.
///
/// Forces that the part beyond the section exerts on the part before it: axial positive in tension;
/// moments about the section's y and z axes by the right-hand rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionForces {
    /// Distance from the first end, m.
    pub position: f64,
    /// Axial force $N$, N.
    pub axial: f64,
    /// Shear force $V_y$, N.
    pub shear_y: f64,
    /// Shear force $V_z$, N.
    pub shear_z: f64,
    /// Torsional moment $M_x$, N·m.
    pub torsion: f64,
    /// Bending moment $M_y$, N·m.
    pub moment_y: f64,
    /// Bending moment $M_z$, N·m.
    pub moment_z: f64,
}

/// What an element recovers from its displacements.
#[derive(Debug, Clone, PartialEq)]
pub enum Recovery {
    /// Nothing: a mass, a dashpot.
    Nothing,
    /// Axial force, N, tension positive.
    Axial(f64),
    /// Section forces at both ends and between.
    Sections(Vec<SectionForces>),
    /// Stresses at points of a solid.
    Stresses(Vec<StressPoint>),
    /// Force (N) or moment (N·m) in each axis of a spring, positive when its ends are drawn apart.
    Axes(Vec<f64>),
}

/// One finite element.
///
/// Matrices run over the nodes in order, [`Element::freedoms_per_node`] freedoms each: translations
/// $u_x, u_y, u_z$ (m), then, where there are six, rotations $\theta_x, \theta_y, \theta_z$ (rad), all
/// in the global axes. They are symmetric. `displacement` slices have the same order.
pub trait Element: Debug + Send + Sync {
    /// What it is called in messages.
    fn kind(&self) -> &'static str;
    /// Its nodes.
    fn nodes(&self) -> &[usize];
    /// 3 (translations) or 6 (with rotations).
    fn freedoms_per_node(&self) -> usize;
    /// Its mass, kg.
    fn total_mass(&self) -> f64;
    /// Stiffness $K$, N/m (N, N·m where rotations stand).
    fn stiffness(&self) -> DMatrix<f64>;
    /// Mass $M$, kg (kg·m, kg·m² where rotations stand).
    fn mass(&self, form: MassForm) -> DMatrix<f64>;
    /// Damping $C$, N·s/m, of the element itself; `None` where it has none.
    fn damping(&self) -> Option<DMatrix<f64>> {
        None
    }
    /// Geometric stiffness $K_\sigma$ of the stresses under `displacement`, to be added to $K$;
    /// positive definite under tension. `None` where an element has none.
    fn geometric_stiffness(&self, _displacement: &[f64]) -> Option<DMatrix<f64>> {
        None
    }
    /// Consistent load of a uniform acceleration field `gravity` (m/s²), $f = \int \rho N^T g\,dV$, N.
    fn gravity_load(&self, gravity: [f64; 3]) -> DVector<f64> {
        let n = self.freedoms_per_node();
        let field =
            DVector::from_fn(n * self.nodes().len(), |i, _| gravity.get(i % n).copied().unwrap_or(0.0));
        self.mass(MassForm::Consistent) * field
    }
    /// Forces or stresses under `displacement`, the element itself carrying the load of `gravity`.
    fn recover(&self, displacement: &[f64], gravity: [f64; 3]) -> Recovery;
}
