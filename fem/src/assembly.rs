//! From elements to matrices and loads over the free freedoms.

use crate::{
    FemError,
    constraint::{Component, Numbering, Reduction, fits},
    element::{Element, MassForm, Recovery},
    model::{GroupId, Model},
    sparse::SymmetricMatrix,
};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, SMatrix, Vector3};

/// A symmetric operator $A$ over all freedoms, seen through $u = T q + S s + g$.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    /// $T^T A T$.
    pub free: SymmetricMatrix,
    /// Entries (free, support, value) of $T^T A S$, places not repeated in order of the free ones.
    pub coupling: Vec<(usize, usize, f64)>,
    /// $S^T A S$.
    pub support: SymmetricMatrix,
    /// $T^T A g$, then $S^T A g$: what the constants of constraints give.
    pub constant: (Vec<f64>, Vec<f64>),
}

impl Operator {
    /// $T^T A S\,s$: the load, with the other sign, that a motion of supports puts on the free part.
    /// Errors: a length that does not fit.
    pub fn couple(&self, support: &[f64]) -> Result<Vec<f64>, FemError> {
        fits("motion of supports", support.len(), self.support.size())?;
        let mut load = vec![0.0; self.free.size()];
        for &(i, j, value) in &self.coupling {
            load[i] += value * support[j];
        }
        Ok(load)
    }

    /// $S^T A (T q + S s + g)$: the forces that the supports give to hold $q$ and $s$ (less the loads
    /// on them). Errors: lengths that do not fit.
    pub fn support_force(&self, free: &[f64], support: &[f64]) -> Result<Vec<f64>, FemError> {
        fits("free motion", free.len(), self.free.size())?;
        fits("motion of supports", support.len(), self.support.size())?;
        let mut force = vec![0.0; support.len()];
        self.support.multiply(support, &mut force);
        for &(i, j, value) in &self.coupling {
            force[j] += value * free[i];
        }
        for (value, constant) in force.iter_mut().zip(&self.constant.1) {
            *value += constant;
        }
        Ok(force)
    }
}

/// Mass, centre and inertia of a structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of gravity, m.
    pub centre: [f64; 3],
    /// Inertia tensor about the centre, kg·m², off-diagonal $-\int xy\,dm$.
    pub inertia: [[f64; 3]; 3],
}

/// A model with its freedoms numbered and its constraints resolved.
///
/// Full vectors run over [`Numbering`]; `free` and `support` vectors over [`Reduction`].
#[derive(Debug)]
pub struct Assembly<'m> {
    model: &'m Model,
    numbering: Numbering,
    reduction: Reduction,
}

impl<'m> Assembly<'m> {
    /// Numbers the freedoms of `model` and resolves its constraints. Errors: those of
    /// [`Model::numbering`] and [`Model::reduction`]. Geometry and connection are checked apart, by
    /// [`crate::check::check`].
    pub fn new(model: &'m Model) -> Result<Self, FemError> {
        let numbering = model.numbering()?;
        let reduction = model.reduction(&numbering)?;
        Ok(Self { model, numbering, reduction })
    }

    /// The model.
    pub fn model(&self) -> &'m Model {
        self.model
    }

    /// Places of all freedoms.
    pub fn numbering(&self) -> &Numbering {
        &self.numbering
    }

    /// Reduction to the free freedoms.
    pub fn reduction(&self) -> &Reduction {
        &self.reduction
    }

    /// Places of an element's freedoms among all, in the order of its matrices.
    pub fn places(&self, element: &dyn Element) -> Vec<usize> {
        let count = element.freedoms_per_node();
        let nodes = element.nodes().iter();
        nodes
            .flat_map(|&n| (0..count).map(move |i| (n, i)))
            .map(|(n, i)| self.numbering.start(n) + i)
            .collect()
    }

    fn gather(&self, element: &dyn Element, full: &[f64]) -> Vec<f64> {
        self.places(element).into_iter().map(|p| full[p]).collect()
    }

    /// Operator of the matrices that `matrix` gives element by element (`None`: nothing).
    pub fn operator(
        &self,
        matrix: impl Fn(usize, &dyn Element) -> Option<DMatrix<f64>>,
    ) -> Result<Operator, FemError> {
        let free = self.reduction.free();
        let mut sum = Sum { free, support: self.reduction.supports().len(), ..Sum::default() };
        sum.constant = vec![0.0; free + sum.support];
        for (i, element) in self.model.elements().iter().enumerate() {
            if let Some(matrix) = matrix(i, element.as_ref()) {
                sum.add(&self.reduction, &self.places(element.as_ref()), &matrix);
            }
        }
        sum.finish()
    }

    /// Stiffness $K$.
    pub fn stiffness(&self) -> Result<Operator, FemError> {
        self.operator(|_, element| Some(element.stiffness()))
    }

    /// Mass $M$. A lumped one stays diagonal as long as no constraint joins freedoms.
    pub fn mass(&self, form: MassForm) -> Result<Operator, FemError> {
        self.operator(|_, element| Some(element.mass(form)))
    }

    /// Damping $C$ of the elements that have one of their own, dashpots.
    pub fn damping(&self) -> Result<Operator, FemError> {
        self.operator(|_, element| element.damping())
    }

    /// Rayleigh damping by group, $C = \sum_g \alpha_g M_g + \beta_g K_g$, with `coefficients` giving
    /// $(\alpha_g, \beta_g)$ in 1/s and s; own dampings of elements are not in it.
    ///
    /// The mass part belongs to motion relative to the base: multiplied with an absolute velocity it
    /// would brake a rigid motion.
    pub fn rayleigh_damping(
        &self,
        form: MassForm,
        coefficients: impl Fn(GroupId) -> (f64, f64),
    ) -> Result<Operator, FemError> {
        self.operator(|i, element| {
            let (alpha, beta) = coefficients(self.model.group_of(i));
            let part =
                |factor: f64, matrix: &dyn Fn() -> DMatrix<f64>| (factor != 0.0).then(|| matrix() * factor);
            let mass = part(alpha, &|| element.mass(form));
            let stiffness = part(beta, &|| element.stiffness());
            match (mass, stiffness) {
                (Some(m), Some(k)) => Some(m + k),
                (m, k) => m.or(k),
            }
        })
    }

    /// Geometric stiffness $K_\sigma$ of the stresses under the full motion `displacement`.
    /// Errors: a length that does not fit.
    pub fn geometric_stiffness(&self, displacement: &[f64]) -> Result<Operator, FemError> {
        fits("displacement", displacement.len(), self.numbering.size())?;
        self.operator(|_, element| element.geometric_stiffness(&self.gather(element, displacement)))
    }

    /// Load of a uniform acceleration `gravity` (m/s²) on all freedoms, N.
    pub fn gravity_load(&self, gravity: [f64; 3]) -> Vec<f64> {
        let mut load = vec![0.0; self.numbering.size()];
        for element in self.model.elements() {
            self.scatter(element.as_ref(), &element.gravity_load(gravity), &mut load);
        }
        load
    }

    /// Adds an element's load (from [`crate::element::Beam::line_load`], say) to a full one.
    pub fn scatter(&self, element: &dyn Element, own: &DVector<f64>, load: &mut [f64]) {
        for (place, value) in self.places(element).into_iter().zip(own.iter()) {
            load[place] += value;
        }
    }

    /// Full motion of a unit translation of everything along `axis` (0, 1, 2): all nodes 1, no
    /// rotation.
    pub fn unit_translation(&self, axis: usize) -> Vec<f64> {
        (0..self.numbering.size())
            .map(|p| if self.numbering.freedom(p).component.index() == axis { 1.0 } else { 0.0 })
            .collect()
    }

    /// Influence vectors $\iota_x, \iota_y, \iota_z$: the free freedoms under a unit translation of
    /// base and structure together.
    ///
    /// The load of a base acceleration $a$ on relative motion is $-(T^TMT\,\iota + T^TMS\,1)\,a$, see
    /// [`Assembly::base_load`].
    pub fn influence(&self) -> [Vec<f64>; 3] {
        [0, 1, 2].map(|axis| {
            let unit = |f: &crate::constraint::Freedom| f64::from(u8::from(f.component.index() == axis));
            self.reduction.freedoms().iter().map(unit).collect()
        })
    }

    /// $-T^T M r_x$, $-T^T M r_y$, $-T^T M r_z$: load on relative motion per unit of base
    /// acceleration, kg.
    pub fn base_load(&self, mass: &Operator) -> Result<[Vec<f64>; 3], FemError> {
        let mut loads = self.influence();
        for (axis, load) in loads.iter_mut().enumerate() {
            let supports = self.reduction.supports().iter();
            let unit: Vec<f64> = supports.map(|f| f64::from(u8::from(f.component.index() == axis))).collect();
            let coupled = mass.couple(&unit)?;
            let mut own = vec![0.0; load.len()];
            mass.free.multiply(load, &mut own);
            *load = own.iter().zip(&coupled).map(|(a, b)| -(a + b)).collect();
        }
        Ok(loads)
    }

    /// What an element recovers from the full motion `displacement`, itself under `gravity`.
    /// Errors: a length that does not fit.
    pub fn recover(
        &self,
        element: usize,
        displacement: &[f64],
        gravity: [f64; 3],
    ) -> Result<Recovery, FemError> {
        fits("displacement", displacement.len(), self.numbering.size())?;
        let element = self.model.elements()[element].as_ref();
        Ok(element.recover(&self.gather(element, displacement), gravity))
    }

    /// Mass, centre of gravity and inertia, from the elements' consistent masses and the rigid motions
    /// of their nodes.
    ///
    /// Errors: a mass that differs by more than 1e-9 of it between the elements' own figures and the
    /// matrix over free and supported freedoms (a constraint that a translation does not satisfy).
    pub fn mass_properties(&self) -> Result<MassProperties, FemError> {
        let (rigid, origin) = self.rigid_mass();
        let expected: f64 = self.model.elements().iter().map(|e| e.total_mass()).sum();
        let operator = self.mass(MassForm::Consistent)?;
        let loads = self.base_load(&operator)?;
        for (axis, name) in ['x', 'y', 'z'].into_iter().enumerate() {
            let found = self.translated_mass(axis, &loads[axis], &operator)?;
            let adds_up = (found - expected).abs() <= 1e-9 * expected;
            if !adds_up {
                return Err(FemError::Mass { axis: name, found, expected });
            }
        }
        let mass = rigid[(0, 0)];
        // upper right block: -m [c]×
        let arm = Vector3::new(rigid[(1, 5)], rigid[(2, 3)], rigid[(0, 4)]) / mass.max(f64::MIN_POSITIVE);
        let square = arm.cross_matrix() * arm.cross_matrix();
        let about: Matrix3<f64> = rigid.fixed_view::<3, 3>(3, 3) + square * mass;
        Ok(MassProperties {
            mass,
            centre: (origin + arm).into(),
            inertia: [0, 1, 2].map(|i| [0, 1, 2].map(|j| about[(i, j)])),
        })
    }

    /// $r^T M r$ over free and supported freedoms for a unit translation.
    fn translated_mass(&self, axis: usize, load: &[f64], mass: &Operator) -> Result<f64, FemError> {
        let free = &self.influence()[axis];
        let supports = self.reduction.supports().iter();
        let unit: Vec<f64> = supports.map(|f| f64::from(u8::from(f.component.index() == axis))).collect();
        let held = mass.support_force(free, &unit)?;
        let on_free: f64 = free.iter().zip(load).map(|(a, b)| -a * b).sum();
        Ok(on_free + unit.iter().zip(&held).map(|(a, b)| a * b).sum::<f64>())
    }

    /// $R^T M R$ of the six rigid motions about the mean of the nodes, and that point.
    fn rigid_mass(&self) -> (Matrix6<f64>, Vector3<f64>) {
        let nodes = self.model.nodes();
        let origin =
            nodes.iter().map(|&x| Vector3::from(x)).sum::<Vector3<f64>>() / nodes.len().max(1) as f64;
        let mut sum = Matrix6::zeros();
        for element in self.model.elements() {
            let count = element.freedoms_per_node();
            let mut motions = DMatrix::zeros(count * element.nodes().len(), 6);
            for (k, &node) in element.nodes().iter().enumerate() {
                let own = rigid_motion(Vector3::from(nodes[node]) - origin);
                motions.view_mut((k * count, 0), (count, 6)).copy_from(&own.rows(0, count));
            }
            let product = motions.transpose() * element.mass(MassForm::Consistent) * &motions;
            sum += Matrix6::from_column_slice(product.as_slice());
        }
        (sum, origin)
    }
}

/// Motion of a node at `arm` under the six unit rigid motions about the origin, `[6 freedoms, 6]`.
pub fn rigid_motion(arm: Vector3<f64>) -> SMatrix<f64, 6, 6> {
    let mut motion = SMatrix::<f64, 6, 6>::identity();
    motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm.cross_matrix());
    motion
}

#[derive(Default)]
struct Sum {
    free: usize,
    support: usize,
    own: Vec<(usize, usize, f64)>,
    coupling: Vec<(usize, usize, f64)>,
    held: Vec<(usize, usize, f64)>,
    constant: Vec<f64>,
}

impl Sum {
    fn add(&mut self, reduction: &Reduction, places: &[usize], matrix: &DMatrix<f64>) {
        // rows of (T S) once per element; most hold one entry of 1
        let rows: Vec<Vec<(usize, f64)>> = places.iter().map(|&p| reduction.row(p).collect()).collect();
        for (j, (&place, column)) in places.iter().zip(&rows).enumerate() {
            let constant = reduction.constants()[place];
            for (i, row) in rows.iter().enumerate() {
                let value = matrix[(i, j)];
                if value == 0.0 {
                    continue;
                }
                for &(a, ca) in row {
                    self.constant[a] += ca * value * constant;
                    for &(b, cb) in column {
                        self.entry(a, b, ca * value * cb);
                    }
                }
            }
        }
    }

    /// Both (a, b) and (b, a) come by; one of the two is kept.
    fn entry(&mut self, a: usize, b: usize, value: f64) {
        let n = self.free;
        match (a < n, b < n) {
            (true, true) if a >= b => self.own.push((a, b, value)),
            (true, false) => self.coupling.push((a, b - n, value)),
            (false, false) if a >= b => self.held.push((a - n, b - n, value)),
            _ => {}
        }
    }

    fn finish(mut self) -> Result<Operator, FemError> {
        self.coupling.sort_by_key(|&(i, j, _)| (i, j));
        self.coupling.dedup_by(|later, first| {
            let same = (later.0, later.1) == (first.0, first.1);
            if same {
                first.2 += later.2;
            }
            same
        });
        let held = self.constant.split_off(self.free);
        Ok(Operator {
            free: SymmetricMatrix::assemble(self.free, self.own)?,
            coupling: self.coupling,
            support: SymmetricMatrix::assemble(self.support, self.held)?,
            constant: (self.constant, held),
        })
    }
}

/// Adds a force or moment on one freedom to a full load. Errors: a freedom that is not there.
pub fn add_force(
    numbering: &Numbering,
    load: &mut [f64],
    node: usize,
    component: Component,
    value: f64,
) -> Result<(), FemError> {
    fits("load", load.len(), numbering.size())?;
    let freedom = crate::constraint::Freedom::new(node, component);
    if node >= numbering.nodes() {
        return Err(FemError::UnknownNode { item: "a load".into(), node, count: numbering.nodes() });
    }
    let place = numbering.place(freedom).ok_or(FemError::NoRotation { item: "a load".into(), freedom })?;
    load[place] += value;
    Ok(())
}
