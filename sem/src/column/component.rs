use super::mesh::{Mesh, Probe};
use super::{BaseMotion, PointMotion};
use crate::attenuation::MaxwellArms;
use crate::soil::Profile;
use hati_coupling::Energies;
use hati_coupling::central_difference::{drift, kick, kick_damped};

/// One displacement component of the column with its memory variables and its books.
///
/// Element arrays are laid out `[point][element]`, so that the inner loops run over elements and
/// vectorise whatever the order. Depth is the coordinate inside; only [`Component::strain_stress`]
/// turns to z upwards.
#[derive(Debug, Clone)]
pub(super) struct Component {
    mass: Vec<f64>,
    dt_over_mass: Vec<f64>,
    relaxed: Vec<f64>,
    unrelaxed: Vec<f64>,
    inverse_half_height: Vec<f64>,
    arms: Vec<Arm>,
    base: BaseLoad,
    multiplier: [f64; 2],
    u: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    strain: Vec<f64>,
    books: Books,
    scratch: Scratch,
}

/// One mechanism over all elements.
#[derive(Debug, Clone)]
struct Arm {
    decay: Vec<f64>,
    gain: Vec<f64>,
    modulus: Vec<f64>,
    /// $g\,\omega\,\Delta t\,h/2$: dissipated per unit weight and squared mean strain.
    loss: Vec<f64>,
    strain: Vec<f64>,
}

#[derive(Debug, Clone)]
enum BaseLoad {
    Elastic {
        impedance: f64,
        outcrop: Vec<f64>,
    },
    /// Velocity between kicks n and n + 1, and the displacement of kick 0.
    Imposed {
        velocity: Vec<f64>,
    },
}

/// Cumulative energies up to the latest kick; the viscous line up to the latest pair of kicks.
#[derive(Debug, Clone, Copy, Default)]
struct Books {
    input: f64,
    outflow: f64,
    viscous: f64,
    /// Traction at the base at the latest kick (imposed base: the reaction), Pa.
    base_traction: f64,
}

/// Work arrays of the kernel, so that the loop allocates nothing.
#[derive(Debug, Clone)]
pub(super) struct Scratch {
    local: Vec<f64>,
    stress: Vec<f64>,
    force: Vec<f64>,
    lane: Vec<f64>,
    loss: Vec<f64>,
}

impl Scratch {
    fn new(points: usize, elements: usize, nodes: usize) -> Self {
        let n = points * elements;
        let (local, stress) = (vec![0.0; n], vec![0.0; n]);
        Self { local, stress, force: vec![0.0; nodes], lane: vec![0.0; elements], loss: vec![0.0; elements] }
    }
}

impl Component {
    pub(super) fn new(
        profile: &Profile,
        mesh: &Mesh,
        axis: usize,
        arms: &[[MaxwellArms; 3]],
        dt: f64,
        motion: BaseMotion,
    ) -> Self {
        let (points, elements, nodes) = (mesh.order() + 1, mesh.elements.len(), mesh.nodes());
        let per_element = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            mesh.elements.iter().map(|e| value(e.layer)).collect()
        };
        let modulus = |layer: usize| profile.layers[layer].modulus(axis);
        let mechanisms = arms.iter().map(|a| a[axis].omega.len()).max().unwrap_or(0);
        let arm = |l: usize| {
            let omega = |layer: usize| arms[layer][axis].omega.get(l).copied().unwrap_or(0.0);
            let g = |layer: usize| modulus(layer) * arms[layer][axis].modulus.get(l).copied().unwrap_or(0.0);
            let x = |layer: usize| 0.5 * dt * omega(layer);
            Arm {
                decay: per_element(&|layer| (1.0 - x(layer)) / (1.0 + x(layer))),
                gain: per_element(&|layer| 1.0 / (1.0 + x(layer))),
                modulus: per_element(&g),
                loss: (mesh.elements.iter())
                    .map(|e| g(e.layer) * omega(e.layer) * dt * 0.5 * e.height)
                    .collect(),
                strain: vec![0.0; points * elements],
            }
        };
        let mass = mesh.mass(profile);
        let base = match motion {
            BaseMotion::Outcrop(outcrop) => {
                BaseLoad::Elastic { impedance: profile.base.impedance(axis).unwrap_or(0.0), outcrop }
            }
            BaseMotion::Imposed(u) => {
                BaseLoad::Imposed { velocity: u.windows(2).map(|w| (w[1] - w[0]) / dt).collect() }
            }
        };
        Self {
            dt_over_mass: mass.iter().map(|m| dt / m).collect(),
            mass,
            relaxed: per_element(&|layer| modulus(layer) * arms[layer][axis].relaxed),
            unrelaxed: per_element(&|layer| modulus(layer) * arms[layer][axis].unrelaxed()),
            inverse_half_height: mesh.elements.iter().map(|e| 2.0 / e.height).collect(),
            arms: (0..mechanisms).map(arm).collect(),
            base,
            multiplier: [0.0; 2],
            u: vec![0.0; nodes],
            v: vec![0.0; nodes],
            a: vec![0.0; nodes],
            strain: vec![0.0; points * elements],
            books: Books::default(),
            scratch: Scratch::new(points, elements, nodes),
        }
    }

    pub(super) fn step(&mut self, mesh: &Mesh, kick_index: usize, dt: f64) {
        let half = 0.5 * dt;
        for (u, v) in self.u.iter_mut().zip(&self.v) {
            *u = drift(*u, *v, half);
        }
        self.internal_force(mesh);
        let last = self.u.len() - 1;
        let inverse_dt = 1.0 / dt;
        let v_base = self.v[last];
        self.scratch.force[0] -= self.multiplier[0];
        for i in 0..last {
            let before = self.v[i];
            self.v[i] = kick(before, -self.scratch.force[i], self.dt_over_mass[i]);
            self.a[i] = (self.v[i] - before) * inverse_dt;
        }
        self.books.input += dt * self.multiplier[0] * (self.v[0] - half * self.a[0]);
        self.kick_base(kick_index, v_base, dt);
        for (u, v) in self.u.iter_mut().zip(&self.v) {
            *u = drift(*u, *v, half);
        }
    }

    fn kick_base(&mut self, kick_index: usize, before: f64, dt: f64) {
        let last = self.u.len() - 1;
        let internal = self.scratch.force[last];
        let books = &mut self.books;
        match &self.base {
            BaseLoad::Elastic { impedance: z, outcrop } => {
                let incident = 0.5 * outcrop.get(kick_index).copied().unwrap_or(0.0);
                let load = 2.0 * z * incident + self.multiplier[1] - internal;
                let after = kick_damped(before, load, self.mass[last], *z, dt);
                let mean = 0.5 * (before + after);
                books.input += dt * (z * incident * incident + self.multiplier[1] * mean);
                books.outflow += dt * z * (mean - incident) * (mean - incident);
                books.base_traction = z * (2.0 * incident - mean);
                self.v[last] = after;
            }
            BaseLoad::Imposed { velocity } => {
                let after = velocity.get(kick_index).copied().unwrap_or(0.0);
                books.base_traction = self.mass[last] * (after - before) / dt + internal;
                books.input += dt * books.base_traction * 0.5 * (before + after);
                self.v[last] = after;
            }
        }
        self.a[last] = (self.v[last] - before) / dt;
    }

    /// Strain, memory variables and internal force at the present positions.
    fn internal_force(&mut self, mesh: &Mesh) {
        let (n, ne) = (mesh.order() + 1, mesh.elements.len());
        let s = &mut self.scratch;
        gather(&self.u, &mut s.local, n, ne);
        for i in 0..n {
            let row = i * ne..(i + 1) * ne;
            derivative_row(mesh, &s.local, &mut s.lane, i, ne);
            let (strain, stress) = (&mut self.strain[row.clone()], &mut s.stress[row.clone()]);
            for e in 0..ne {
                let new = s.lane[e] * self.inverse_half_height[e];
                s.lane[e] = new - strain[e];
                strain[e] = new;
                stress[e] = self.relaxed[e] * new;
            }
            let w = mesh.gll.weights[i];
            for arm in &mut self.arms {
                arm.advance(&s.lane, w, row.clone(), stress, &mut s.loss);
            }
            stress.iter_mut().for_each(|x| *x *= w);
        }
        if !self.arms.is_empty() {
            self.books.viscous += s.loss.iter().sum::<f64>();
            s.loss.fill(0.0);
        }
        scatter_transposed(mesh, &s.stress, &mut s.lane, &mut s.force, n, ne);
    }

    /// Force of the unrelaxed elastic column, for the spectral bound; an imposed base is fixed.
    pub(super) fn unrelaxed_force(&self, mesh: &Mesh, u: &[f64], f: &mut [f64], s: &mut Scratch) {
        let (n, ne) = (mesh.order() + 1, mesh.elements.len());
        s.force[..u.len()].copy_from_slice(u);
        s.force[u.len()..].fill(0.0);
        gather(&s.force, &mut s.local, n, ne);
        for i in 0..n {
            derivative_row(mesh, &s.local, &mut s.lane, i, ne);
            for e in 0..ne {
                s.stress[i * ne + e] =
                    mesh.gll.weights[i] * self.unrelaxed[e] * self.inverse_half_height[e] * s.lane[e];
            }
        }
        scatter_transposed(mesh, &s.stress, &mut s.lane, &mut s.force, n, ne);
        f.copy_from_slice(&s.force[..f.len()]);
    }

    pub(super) fn elastic_scratch(&self) -> Scratch {
        self.scratch.clone()
    }

    /// Masses of the freedoms that the step moves: all, or all but the imposed base.
    pub(super) fn free_mass(&self) -> &[f64] {
        match self.base {
            BaseLoad::Elastic { .. } => &self.mass,
            BaseLoad::Imposed { .. } => &self.mass[..self.mass.len() - 1],
        }
    }

    /// Element with the largest own frequency $\sqrt{G_U/\rho}/h$.
    pub(super) fn limiting_element(&self, mesh: &Mesh) -> usize {
        let rate = |e: usize| {
            let inner = e * mesh.order() + mesh.order() / 2;
            self.unrelaxed[e] * self.inverse_half_height[e] / self.mass[inner].max(f64::MIN_POSITIVE)
        };
        (0..mesh.elements.len()).max_by(|&a, &b| rate(a).total_cmp(&rate(b))).unwrap_or(0)
    }

    /// Puts the state at the end of the last step to given positions and velocities, unstrained arms.
    pub(super) fn set_motion(&mut self, mesh: &Mesh, dt: f64, motion: impl Fn(f64) -> (f64, f64)) {
        for (i, &depth) in mesh.depth.iter().enumerate() {
            (self.u[i], self.v[i]) = motion(depth);
        }
        let (n, ne) = (mesh.order() + 1, mesh.elements.len());
        let s = &mut self.scratch;
        for (f, (u, v)) in s.force.iter_mut().zip(self.u.iter().zip(&self.v)) {
            *f = drift(*u, *v, -0.5 * dt);
        }
        gather(&s.force, &mut s.local, n, ne);
        for i in 0..n {
            derivative_row(mesh, &s.local, &mut s.lane, i, ne);
            for e in 0..ne {
                self.strain[i * ne + e] = s.lane[e] * self.inverse_half_height[e];
            }
        }
        self.arms.iter_mut().for_each(|arm| arm.strain.fill(0.0));
    }

    pub(super) fn node_motion(&self, node: usize, dt: f64) -> PointMotion {
        let (v, a) = (self.v[node], self.a[node]);
        PointMotion { displacement: self.u[node] - 0.5 * dt * v, velocity: v - 0.5 * dt * a, acceleration: a }
    }

    pub(super) fn motion_at(&self, probe: &Probe, order: usize, dt: f64) -> PointMotion {
        let mut sum = PointMotion::default();
        for (i, w) in probe.weights.iter().enumerate() {
            let m = self.node_motion(probe.element * order + i, dt);
            sum.displacement += w * m.displacement;
            sum.velocity += w * m.velocity;
            sum.acceleration += w * m.acceleration;
        }
        sum
    }

    pub(super) fn strain_stress(&self, mesh: &Mesh, visit: &mut impl FnMut(usize, f64, f64)) {
        let (n, ne) = (mesh.order() + 1, mesh.elements.len());
        for e in 0..ne {
            for i in 0..n {
                let k = i * ne + e;
                let stress = self.scratch.stress[k] / mesh.gll.weights[i];
                visit(e * n + i, -self.strain[k], -stress);
            }
        }
    }

    pub(super) fn outcrop_velocity(&self, dt: f64, impedance: f64) -> f64 {
        self.node_motion(self.u.len() - 1, dt).velocity + self.books.base_traction / impedance
    }

    pub(super) fn velocities(&self) -> &[f64] {
        &self.v
    }

    fn interface_node(&self, interface: usize) -> usize {
        if interface == 0 { 0 } else { self.u.len() - 1 }
    }

    pub(super) fn end_position(&self, interface: usize) -> f64 {
        self.u[self.interface_node(interface)]
    }

    pub(super) fn end_velocity(&self, interface: usize) -> f64 {
        self.v[self.interface_node(interface)]
    }

    pub(super) fn set_multiplier(&mut self, interface: usize, value: f64) {
        self.multiplier[interface.min(1)] = value;
    }

    /// Energies at the end of the last step: half a step beyond the latest kick, so the strains of the
    /// next kick are evaluated without advancing anything.
    pub(super) fn energies(&mut self, mesh: &Mesh, dt: f64) -> Energies {
        let (n, ne) = (mesh.order() + 1, mesh.elements.len());
        let s = &mut self.scratch;
        for (f, (u, v)) in s.force.iter_mut().zip(self.u.iter().zip(&self.v)) {
            *f = drift(*u, *v, 0.5 * dt);
        }
        gather(&s.force, &mut s.local, n, ne);
        let (mut strain_energy, mut viscous) = (0.0, self.books.viscous);
        for i in 0..n {
            derivative_row(mesh, &s.local, &mut s.lane, i, ne);
            let w = mesh.gll.weights[i];
            for e in 0..ne {
                let k = i * ne + e;
                let (old, new) = (self.strain[k], s.lane[e] * self.inverse_half_height[e]);
                let volume = w / self.inverse_half_height[e];
                strain_energy += 0.5 * volume * self.relaxed[e] * old * new;
                for arm in &self.arms {
                    let before = arm.strain[k];
                    let after = arm.decay[e] * before + arm.gain[e] * (new - old);
                    let mean = 0.5 * (before + after);
                    viscous += 0.5 * w * arm.loss[e] * mean * mean;
                    strain_energy += 0.5 * volume * arm.modulus[e] * before * after
                        - 0.125 * w * arm.loss[e] * (after * after - before * before);
                }
            }
        }
        let kinetic = self.mass.iter().zip(&self.v).map(|(m, v)| 0.5 * m * v * v).sum();
        let Books { input, outflow, .. } = self.books;
        Energies { input, kinetic, strain: strain_energy, viscous, outflow }
    }

    pub(super) fn state_len(&self) -> usize {
        3 * self.u.len() + self.strain.len() * (1 + self.arms.len()) + 4
    }

    pub(super) fn save(&self, values: &mut Vec<f64>) {
        for part in [&self.u, &self.v, &self.a, &self.strain] {
            values.extend(part);
        }
        self.arms.iter().for_each(|arm| values.extend(&arm.strain));
        let b = &self.books;
        values.extend([b.input, b.outflow, b.viscous, b.base_traction]);
    }

    pub(super) fn restore(&mut self, values: &[f64]) {
        let mut rest = values;
        let mut take = |part: &mut [f64]| {
            let (own, next) = rest.split_at(part.len());
            part.copy_from_slice(own);
            rest = next;
        };
        for part in [&mut self.u, &mut self.v, &mut self.a, &mut self.strain] {
            take(part);
        }
        self.arms.iter_mut().for_each(|arm| take(&mut arm.strain));
        let mut b = [0.0; 4];
        take(&mut b);
        self.books = Books { input: b[0], outflow: b[1], viscous: b[2], base_traction: b[3] };
    }
}

impl Arm {
    /// Advances one row of points by the strain increments `delta`, adds to stress and to the losses.
    #[inline(always)]
    fn advance(
        &mut self,
        delta: &[f64],
        weight: f64,
        row: std::ops::Range<usize>,
        stress: &mut [f64],
        loss: &mut [f64],
    ) {
        let ne = delta.len();
        let strain = &mut self.strain[row][..ne];
        let (decay, gain) = (&self.decay[..ne], &self.gain[..ne]);
        let (modulus, rate) = (&self.modulus[..ne], &self.loss[..ne]);
        let (stress, loss) = (&mut stress[..ne], &mut loss[..ne]);
        let quarter = 0.25 * weight;
        for e in 0..ne {
            let before = strain[e];
            let after = decay[e] * before + gain[e] * delta[e];
            let twice_mean = before + after;
            strain[e] = after;
            stress[e] += modulus[e] * after;
            loss[e] += quarter * rate[e] * twice_mean * twice_mean;
        }
    }
}

fn gather(u: &[f64], local: &mut [f64], n: usize, ne: usize) {
    let order = n - 1;
    for i in 0..n {
        for (e, slot) in local[i * ne..(i + 1) * ne].iter_mut().enumerate() {
            *slot = u[e * order + i];
        }
    }
}

/// $\partial u/\partial\xi$ at point `i` of every element.
#[inline(always)]
fn derivative_row(mesh: &Mesh, local: &[f64], lane: &mut [f64], i: usize, ne: usize) {
    let n = mesh.gll.len();
    lane.fill(0.0);
    for j in 0..n {
        let d = mesh.gll.derivative[i * n + j];
        for (s, u) in lane.iter_mut().zip(&local[j * ne..(j + 1) * ne]) {
            *s += d * u;
        }
    }
}

/// $f_j = \sum_i \ell_j'(\xi_i)\,w_i\sigma_i$, added up over elements (`stress` holds $w\sigma$).
#[inline(always)]
fn scatter_transposed(mesh: &Mesh, stress: &[f64], lane: &mut [f64], force: &mut [f64], n: usize, ne: usize) {
    force.fill(0.0);
    for j in 0..n {
        lane.fill(0.0);
        for i in 0..n {
            let d = mesh.gll.derivative[i * n + j];
            for (f, s) in lane.iter_mut().zip(&stress[i * ne..(i + 1) * ne]) {
                *f += d * s;
            }
        }
        for (e, f) in lane.iter().enumerate() {
            force[e * (n - 1) + j] += f;
        }
    }
}
