//! Timoshenko beam between two nodes.

use super::beam_shape::{BeamShape, End12, GAUSS, Vector12};
use super::{Element, MassForm, Recovery, SectionForces};
use crate::{FemError, material::Material, section::Section};
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, Vector3};

/// Freedoms let go at the two ends of a beam, in its own axes.
///
/// At each end in the order u, v, w, θx, θy, θz: `true` means that the end transmits no force there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EndReleases {
    /// At the first end.
    pub start: [bool; 6],
    /// At the second end.
    pub end: [bool; 6],
}

impl EndReleases {
    /// A hinge for both bendings (θy and θz) at the ends chosen.
    pub fn hinges(start: bool, end: bool) -> Self {
        let hinge = |on| [false, false, false, false, on, on];
        Self { start: hinge(start), end: hinge(end) }
    }

    fn any(&self) -> bool {
        self.start.iter().chain(&self.end).any(|&free| free)
    }

    fn freedoms(&self) -> Vec<usize> {
        let all = self.start.iter().chain(&self.end);
        all.enumerate().filter(|(_, free)| **free).map(|(i, _)| i).collect()
    }
}

/// Straight Timoshenko beam of two nodes, exact for loads at its ends.
///
/// Own axes: x from the first end to the second; z as near to `orientation` as a direction across x
/// can be; y = z × x. Stiffness with the shear parameter $\Phi = 12EI/(GA_sL^2)$ in both planes,
/// torsion $GJ/L$ (St Venant, no warping), axial $EA/L$. Consistent mass with rotary inertia
/// $\rho I_y$, $\rho I_z$ and $\rho(I_y + I_z)$. Rigid offsets from node to end; end releases condensed
/// statically, the mass with the same shape. Frequencies converge with order 4 as long as shear
/// deformation does not matter, with order 2 where it does: the shear angle is constant in an element.
///
/// Geometric stiffness: $\int N(v'^2 + w'^2 + \frac{I_p}{A}\theta_x'^2)\,dx$ with the mean axial force;
/// no part of bending moments (lateral buckling), none of the offsets' own rotation.
#[derive(Debug, Clone)]
pub struct Beam {
    nodes: [usize; 2],
    section: Section,
    material: Material,
    shape: BeamShape,
    /// Rows: own axes in global ones.
    axes: Matrix3<f64>,
    /// From node to end, m, global axes.
    offsets: [Vector3<f64>; 2],
    positions: [Vector3<f64>; 2],
    orientation: Vector3<f64>,
    releases: EndReleases,
    /// Ends' freedoms by the ends' freedoms that are held; identity without releases.
    condensation: End12,
    /// Ends' released freedoms by loads on them: zero but for $K_{rr}^{-1}$.
    flexibility: End12,
}

impl Beam {
    /// Beam between `nodes` at `positions` (m); `orientation` (global) points up in the section.
    ///
    /// Errors: length zero; orientation zero or along the beam; a section constant not above 0.
    pub fn new(
        nodes: [usize; 2],
        positions: [[f64; 3]; 2],
        orientation: [f64; 3],
        section: Section,
        material: Material,
    ) -> Result<Self, FemError> {
        section.check()?;
        Self::build(
            nodes,
            positions.map(Vector3::from),
            [Vector3::zeros(); 2],
            Vector3::from(orientation),
            section,
            material,
        )
    }

    fn build(
        nodes: [usize; 2],
        positions: [Vector3<f64>; 2],
        offsets: [Vector3<f64>; 2],
        orientation: Vector3<f64>,
        section: Section,
        material: Material,
    ) -> Result<Self, FemError> {
        let ends = [positions[0] + offsets[0], positions[1] + offsets[1]];
        let length = (ends[1] - ends[0]).norm();
        let scale = ends.iter().map(|x| x.norm()).fold(0.0, f64::max);
        if !(length > 1e-12 * scale && length.is_finite()) {
            return Err(FemError::ZeroLength { element: "beam", nodes, length });
        }
        let x = (ends[1] - ends[0]) / length;
        let y = orientation.cross(&x);
        // false also where a component is not a number
        let across = y.norm() > 1e-6 * orientation.norm();
        if !across {
            return Err(FemError::Orientation { nodes, vector: orientation.into() });
        }
        let y = y.normalize();
        let axes = Matrix3::from_rows(&[x.transpose(), y.transpose(), x.cross(&y).transpose()]);
        let shear = material.shear_modulus();
        let phi = |inertia: f64, shear_area: Option<f64>| {
            shear_area.map_or(0.0, |a| 12.0 * material.young() * inertia / (shear * a * length * length))
        };
        let shape = BeamShape {
            length,
            phi_y: phi(section.iz, section.shear_area_y),
            phi_z: phi(section.iy, section.shear_area_z),
        };
        Ok(Self {
            nodes,
            section,
            material,
            shape,
            axes,
            offsets,
            positions,
            orientation,
            releases: EndReleases::default(),
            condensation: End12::identity(),
            flexibility: End12::zeros(),
        })
    }

    /// The same beam with rigid `offsets` (m, global axes) from each node to the beam's end.
    ///
    /// The ends follow $u_e = u + \theta \times r$, $\theta_e = \theta$. Errors: as [`Beam::new`].
    pub fn with_offsets(self, offsets: [[f64; 3]; 2]) -> Result<Self, FemError> {
        let beam = Self::build(
            self.nodes,
            self.positions,
            offsets.map(Vector3::from),
            self.orientation,
            self.section,
            self.material,
        )?;
        beam.with_releases(self.releases)
    }

    /// The same beam with its ends' `releases`.
    ///
    /// The released freedoms $r$ follow the held ones by $u_r = -K_{rr}^{-1}K_{rk}u_k$; stiffness, mass
    /// and loads are all taken over that shape. Errors: releases that leave $K_{rr}$ singular (torsion
    /// let go at both ends, say).
    pub fn with_releases(mut self, releases: EndReleases) -> Result<Self, FemError> {
        self.releases = releases;
        self.condensation = End12::identity();
        self.flexibility = End12::zeros();
        if !releases.any() {
            return Ok(self);
        }
        let stiffness = self.own_stiffness();
        let free = releases.freedoms();
        let block = DMatrix::from_fn(free.len(), free.len(), |i, j| stiffness[(free[i], free[j])]);
        // scaled to a unit diagonal, so that metres and radians are judged alike
        let scale = DVector::from_fn(free.len(), |i, _| 1.0 / block[(i, i)].sqrt());
        let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| block[(i, j)] * scale[i] * scale[j]);
        if scaled.symmetric_eigenvalues().min() < 1e-10 {
            return Err(FemError::Release { nodes: self.nodes });
        }
        let inverse = scaled.try_inverse().ok_or(FemError::Release { nodes: self.nodes })?;
        for (i, &row) in free.iter().enumerate() {
            for (j, &column) in free.iter().enumerate() {
                self.flexibility[(row, column)] = scale[i] * inverse[(i, j)] * scale[j];
            }
        }
        self.condensation -= self.flexibility * stiffness;
        for &released in &free {
            self.condensation.column_mut(released).fill(0.0);
        }
        Ok(self)
    }

    /// Length between the ends, m.
    pub fn length(&self) -> f64 {
        self.shape.length
    }

    /// Own axes, one a row, in global components.
    pub fn axes(&self) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.axes[(i, j)]))
    }

    /// Section.
    pub fn section(&self) -> &Section {
        &self.section
    }

    /// Consistent load of a force per length (N/m, global axes) that runs straight from `start` at
    /// the first end to `end` at the second, N and N·m at the nodes.
    pub fn line_load(&self, start: [f64; 3], end: [f64; 3]) -> DVector<f64> {
        let local = self.own_line_load(start, end);
        let nodal = self.to_ends().transpose() * (self.condensation.transpose() * local);
        DVector::from_column_slice(nodal.as_slice())
    }

    /// Section forces at `count` places (2 or more) evenly from end to end, the beam carrying a force
    /// per length from `start` to `end` (N/m, global axes).
    ///
    /// End forces are $K u - f$; those between follow from balance, so statics are exact.
    pub fn section_forces(
        &self,
        displacement: &[f64],
        start: [f64; 3],
        end: [f64; 3],
        count: usize,
    ) -> Vec<SectionForces> {
        let load = self.own_line_load(start, end);
        let nodal = Vector12::from_column_slice(displacement);
        let ends = self.condensation * (self.to_ends() * nodal) + self.flexibility * load;
        let force = self.own_stiffness() * ends - load;
        let [a, b] = [start, end].map(|q| self.axes * Vector3::from(q));
        let last = count.max(2) - 1;
        (0..=last).map(|k| self.balance(&force, a, b, k as f64 / last as f64)).collect()
    }

    /// Balance of the part from the first end to the share `s`, under the load a + (b - a) s.
    fn balance(&self, force: &Vector12, a: Vector3<f64>, b: Vector3<f64>, s: f64) -> SectionForces {
        let x = s * self.length();
        let rise = (b - a) / self.length();
        let load = a * x + rise * (x * x / 2.0);
        // moment arm of the load about the section: ∫ q(t)(x - t) dt
        let lever = a * (x * x / 2.0) + rise * (x * x * x / 6.0);
        let (v, w) = (force[1], force[2]);
        SectionForces {
            position: x,
            axial: -(force[0] + load.x),
            shear_y: -(v + load.y),
            shear_z: -(w + load.z),
            torsion: -force[3],
            moment_y: -force[4] - w * x - lever.z,
            moment_z: -force[5] + v * x + lever.y,
        }
    }

    fn own_line_load(&self, start: [f64; 3], end: [f64; 3]) -> Vector12 {
        let [a, b] = [start, end].map(|q| self.axes * Vector3::from(q));
        let mut load = Vector12::zeros();
        for (s, weight) in GAUSS {
            let force = (a + (b - a) * s) * (weight * self.length());
            let field = SVector::<f64, 6>::new(force.x, force.y, force.z, 0.0, 0.0, 0.0);
            load += self.shape.displacement(s).transpose() * field;
        }
        load
    }

    /// Own freedoms of the ends by the nodes' global ones.
    fn to_ends(&self) -> End12 {
        let mut full = End12::zeros();
        for (node, r) in self.offsets.iter().enumerate() {
            let k = 6 * node;
            full.fixed_view_mut::<3, 3>(k, k).copy_from(&self.axes);
            full.fixed_view_mut::<3, 3>(k + 3, k + 3).copy_from(&self.axes);
            // θ × r = -[r]× θ
            full.fixed_view_mut::<3, 3>(k, k + 3).copy_from(&(-self.axes * r.cross_matrix()));
        }
        full
    }

    fn own_stiffness(&self) -> End12 {
        let (e, g, section) = (self.material.young(), self.material.shear_modulus(), &self.section);
        let rigidity = SVector::<f64, 6>::new(
            e * section.area,
            g * section.shear_area_y.unwrap_or(0.0),
            g * section.shear_area_z.unwrap_or(0.0),
            g * section.torsion,
            e * section.iy,
            e * section.iz,
        );
        self.integrate(&rigidity, |s| self.shape.strain(s))
    }

    fn own_mass(&self, form: MassForm) -> End12 {
        let (rho, section) = (self.material.density(), &self.section);
        let line = section.mass_per_length(rho);
        let inertia = [line, line, line, rho * section.polar(), rho * section.iy, rho * section.iz];
        let consistent = self.integrate(&SVector::from(inertia), |s| self.shape.displacement(s));
        match form {
            MassForm::Consistent => consistent,
            MassForm::Lumped => self.lumped(&consistent),
        }
    }

    /// Half the mass at each end; rotations keep the share that the diagonal of their plane gives
    /// them when its translations are scaled to the mass.
    fn lumped(&self, consistent: &End12) -> End12 {
        let half = self.section.mass_per_length(self.material.density()) * self.length() / 2.0;
        let twist = self.material.density() * self.section.polar() * self.length() / 2.0;
        let mut lumped = End12::zeros();
        for k in [0, 6] {
            for i in 0..3 {
                lumped[(k + i, k + i)] = half;
            }
            lumped[(k + 3, k + 3)] = twist;
            for (rotation, translation) in [(4, 2), (5, 1)] {
                let scale = half / consistent[(k + translation, k + translation)].max(f64::MIN_POSITIVE);
                lumped[(k + rotation, k + rotation)] = scale * consistent[(k + rotation, k + rotation)];
            }
        }
        lumped
    }

    fn integrate(&self, weights: &SVector<f64, 6>, field: impl Fn(f64) -> SMatrix<f64, 6, 12>) -> End12 {
        let mut sum = End12::zeros();
        for (s, weight) in GAUSS {
            let values = field(s);
            let scaled = SMatrix::<f64, 6, 6>::from_diagonal(&(weights * (weight * self.length()))) * values;
            sum += values.transpose() * scaled;
        }
        sum
    }

    fn to_nodes(&self, own: &End12) -> DMatrix<f64> {
        let shape = self.condensation * self.to_ends();
        let nodal = shape.transpose() * own * shape;
        let symmetric = (nodal + nodal.transpose()) * 0.5;
        DMatrix::from_column_slice(12, 12, symmetric.as_slice())
    }
}

impl Element for Beam {
    fn kind(&self) -> &'static str {
        "beam"
    }

    fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    fn freedoms_per_node(&self) -> usize {
        6
    }

    fn total_mass(&self) -> f64 {
        self.section.mass_per_length(self.material.density()) * self.length()
    }

    fn stiffness(&self) -> DMatrix<f64> {
        self.to_nodes(&self.own_stiffness())
    }

    fn mass(&self, form: MassForm) -> DMatrix<f64> {
        self.to_nodes(&self.own_mass(form))
    }

    fn geometric_stiffness(&self, displacement: &[f64]) -> Option<DMatrix<f64>> {
        let ends = self.condensation * (self.to_ends() * Vector12::from_column_slice(displacement));
        let axial = self.material.young() * self.section.area * (ends[6] - ends[0]) / self.length();
        let twist = axial * self.section.polar() / self.section.area;
        let weights = SVector::<f64, 6>::new(axial, axial, twist, 0.0, 0.0, 0.0);
        Some(self.to_nodes(&self.integrate(&weights, |s| self.shape.slope(s))))
    }

    /// Section forces at five places under the beam's own weight in `gravity`.
    fn recover(&self, displacement: &[f64], gravity: [f64; 3]) -> Recovery {
        let line = self.section.mass_per_length(self.material.density());
        let load = gravity.map(|g| line * g);
        Recovery::Sections(self.section_forces(displacement, load, load, 5))
    }
}
