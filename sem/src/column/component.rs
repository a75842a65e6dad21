use super::mesh::{Element, Mesh, Probe};
use super::{BaseMotion, PointMotion};
use crate::attenuation::MaxwellArms;
use crate::soil::Profile;
use hati_coupling::Energies;
use hati_coupling::central_difference::{drift, kick, kick_damped};

/// Elements side by side.
const WIDTH: usize = 4;
/// One value of each element of a block.
type Lanes = [f64; WIDTH];
/// Most points of an element.
const POINTS_MAX: usize = crate::gll::ORDER_MAX + 1;

/// One displacement component of the column with its memory variables and its books.
///
/// Elements go in blocks of [`WIDTH`] side by side: arrays are laid out `[block][point][lane]`, so that
/// the inner loops have a fixed length and vectorise whatever the order. Lanes beyond the last element
/// repeat it with zero moduli and are never scattered. Depth is the coordinate inside; only
/// [`Component::strain_stress`] turns to z upwards.
#[derive(Debug, Clone)]
pub(super) struct Component {
    mass: Vec<f64>,
    dt_over_mass: Vec<f64>,
    relaxed: Vec<Lanes>,
    unrelaxed: Vec<Lanes>,
    inverse_half_height: Vec<Lanes>,
    arms: Vec<Arm>,
    base: BaseLoad,
    multiplier: [f64; 2],
    u: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    strain: Vec<Lanes>,
    books: Books,
    scratch: Scratch,
}

/// One mechanism over all elements.
#[derive(Debug, Clone)]
struct Arm {
    decay: Vec<Lanes>,
    gain: Vec<Lanes>,
    modulus: Vec<Lanes>,
    /// $g\,\omega\,\Delta t\,h/2$: dissipated per unit weight and squared mean strain.
    loss: Vec<Lanes>,
    strain: Vec<Lanes>,
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
    /// Weighted stress $w\sigma$ at every point.
    stress: Vec<Lanes>,
    force: Vec<f64>,
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
        let (points, nodes) = (mesh.order() + 1, mesh.nodes());
        let elements = mesh.elements.len();
        let blocks = elements.div_ceil(WIDTH);
        // `pad` stands in the lanes beyond the last element
        let lanes = |pad: f64, value: &dyn Fn(&Element) -> f64| -> Vec<Lanes> {
            (0..blocks)
                .map(|b| std::array::from_fn(|w| mesh.elements.get(b * WIDTH + w).map_or(pad, value)))
                .collect()
        };
        let modulus = |layer: usize| profile.layers[layer].modulus(axis);
        let mechanisms = arms.iter().map(|a| a[axis].omega.len()).max().unwrap_or(0);
        let arm = |l: usize| {
            let omega = |layer: usize| arms[layer][axis].omega.get(l).copied().unwrap_or(0.0);
            let g = |layer: usize| modulus(layer) * arms[layer][axis].modulus.get(l).copied().unwrap_or(0.0);
            let x = |e: &Element| 0.5 * dt * omega(e.layer);
            Arm {
                decay: lanes(0.0, &|e| (1.0 - x(e)) / (1.0 + x(e))),
                gain: lanes(0.0, &|e| 1.0 / (1.0 + x(e))),
                modulus: lanes(0.0, &|e| g(e.layer)),
                loss: lanes(0.0, &|e| g(e.layer) * omega(e.layer) * dt * 0.5 * e.height),
                strain: vec![[0.0; WIDTH]; points * blocks],
            }
        };
        let mass = mesh.mass(profile);
        let base = match motion {
            BaseMotion::Outcrop(outcrop) => {
                BaseLoad::Elastic { impedance: profile.base.impedance(axis).unwrap_or(0.0), outcrop }
            }
            BaseMotion::Imposed(u) => {
                let mut velocity: Vec<f64> = u.windows(2).map(|w| (w[1] - w[0]) / dt).collect();
                // the kick at the last displacement needs the velocity behind it: go on as before
                if let [.., earlier, later] = velocity[..] {
                    velocity.push(2.0 * later - earlier);
                }
                BaseLoad::Imposed { velocity }
            }
        };
        Self {
            dt_over_mass: mass.iter().map(|m| dt / m).collect(),
            mass,
            relaxed: lanes(0.0, &|e| modulus(e.layer) * arms[e.layer][axis].relaxed),
            unrelaxed: lanes(0.0, &|e| modulus(e.layer) * arms[e.layer][axis].unrelaxed()),
            inverse_half_height: lanes(1.0, &|e| 2.0 / e.height),
            arms: (0..mechanisms).map(arm).collect(),
            base,
            multiplier: [0.0; 2],
            u: vec![0.0; nodes],
            v: vec![0.0; nodes],
            a: vec![0.0; nodes],
            strain: vec![[0.0; WIDTH]; points * blocks],
            books: Books::default(),
            scratch: Scratch { stress: vec![[0.0; WIDTH]; points * blocks], force: vec![0.0; nodes] },
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
                let after = velocity.get(kick_index).copied().unwrap_or(before);
                books.base_traction = self.mass[last] * (after - before) / dt + internal;
                books.input += dt * books.base_traction * 0.5 * (before + after);
                self.v[last] = after;
            }
        }
        self.a[last] = (self.v[last] - before) / dt;
    }

    /// Strain, memory variables and internal force at the present positions.
    fn internal_force(&mut self, mesh: &Mesh) {
        let n = mesh.order() + 1;
        let Scratch { stress, force } = &mut self.scratch;
        force.fill(0.0);
        let mut lost = [0.0; WIDTH];
        for b in 0..self.relaxed.len() {
            let local = gather(&self.u, mesh, b);
            let (relaxed, scale) = (self.relaxed[b], self.inverse_half_height[b]);
            let strain = &mut self.strain[b * n..(b + 1) * n];
            let stress = &mut stress[b * n..(b + 1) * n];
            for i in 0..n {
                let slope = derivative(mesh, &local, i);
                let mut delta = [0.0; WIDTH];
                for w in 0..WIDTH {
                    let new = slope[w] * scale[w];
                    delta[w] = new - strain[i][w];
                    strain[i][w] = new;
                    stress[i][w] = relaxed[w] * new;
                }
                let weight = mesh.gll.weights[i];
                for arm in &mut self.arms {
                    arm.advance(b, b * n + i, &delta, weight, &mut stress[i], &mut lost);
                }
                stress[i].iter_mut().for_each(|s| *s *= weight);
            }
            scatter(mesh, stress, force, b);
        }
        self.books.viscous += lost.iter().sum::<f64>();
    }

    /// Force of the unrelaxed elastic column, for the spectral bound; an imposed base is fixed.
    pub(super) fn unrelaxed_force(&self, mesh: &Mesh, u: &[f64], f: &mut [f64], s: &mut Scratch) {
        let n = mesh.order() + 1;
        let all = [u, &[0.0][..mesh.nodes() - u.len()]].concat();
        s.force.fill(0.0);
        for b in 0..self.unrelaxed.len() {
            let local = gather(&all, mesh, b);
            let (modulus, scale) = (self.unrelaxed[b], self.inverse_half_height[b]);
            let stress = &mut s.stress[b * n..(b + 1) * n];
            for i in 0..n {
                let slope = derivative(mesh, &local, i);
                stress[i] = std::array::from_fn(|w| mesh.gll.weights[i] * modulus[w] * scale[w] * slope[w]);
            }
            scatter(mesh, stress, &mut s.force, b);
        }
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

    /// Element with the largest own frequency, $\sqrt{G_U/\rho}/h$.
    pub(super) fn limiting_element(&self, profile: &Profile, mesh: &Mesh) -> usize {
        let rate = |e: usize| {
            let element = &mesh.elements[e];
            let stiffness = self.unrelaxed[e / WIDTH][e % WIDTH];
            (stiffness / profile.layers[element.layer].rho).sqrt() / element.height
        };
        (0..mesh.elements.len()).max_by(|&a, &b| rate(a).total_cmp(&rate(b))).unwrap_or(0)
    }

    /// Puts the state at the end of the last step to given positions and velocities, unstrained arms.
    pub(super) fn set_motion(&mut self, mesh: &Mesh, dt: f64, motion: impl Fn(f64) -> (f64, f64)) {
        for (i, &depth) in mesh.depth.iter().enumerate() {
            (self.u[i], self.v[i]) = motion(depth);
        }
        let n = mesh.order() + 1;
        let before: Vec<f64> = self.u.iter().zip(&self.v).map(|(u, v)| drift(*u, *v, -0.5 * dt)).collect();
        for b in 0..self.relaxed.len() {
            let local = gather(&before, mesh, b);
            for i in 0..n {
                let slope = derivative(mesh, &local, i);
                self.strain[b * n + i] = std::array::from_fn(|w| slope[w] * self.inverse_half_height[b][w]);
            }
        }
        self.arms.iter_mut().for_each(|arm| arm.strain.fill([0.0; WIDTH]));
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
        let n = mesh.order() + 1;
        for e in 0..mesh.elements.len() {
            for i in 0..n {
                let (k, w) = (e / WIDTH * n + i, e % WIDTH);
                let stress = self.scratch.stress[k][w] / mesh.gll.weights[i];
                visit(e * n + i, -self.strain[k][w], -stress);
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
        let n = mesh.order() + 1;
        let next = &mut self.scratch.force;
        for (f, (u, v)) in next.iter_mut().zip(self.u.iter().zip(&self.v)) {
            *f = drift(*u, *v, 0.5 * dt);
        }
        let (mut stored, mut lost) = ([0.0; WIDTH], [0.0; WIDTH]);
        for b in 0..self.relaxed.len() {
            let local = gather(next, mesh, b);
            let scale = self.inverse_half_height[b];
            for i in 0..n {
                let slope = derivative(mesh, &local, i);
                let (k, weight) = (b * n + i, mesh.gll.weights[i]);
                let old = self.strain[k];
                let new: Lanes = std::array::from_fn(|w| slope[w] * scale[w]);
                for w in 0..WIDTH {
                    stored[w] += 0.5 * weight / scale[w] * self.relaxed[b][w] * old[w] * new[w];
                }
                for arm in &self.arms {
                    for w in 0..WIDTH {
                        let before = arm.strain[k][w];
                        let after = arm.decay[b][w] * before + arm.gain[b][w] * (new[w] - old[w]);
                        let (mean, loss) = (0.5 * (before + after), weight * arm.loss[b][w]);
                        lost[w] += 0.5 * loss * mean * mean;
                        stored[w] += 0.5 * weight / scale[w] * arm.modulus[b][w] * before * after
                            - 0.125 * loss * (after * after - before * before);
                    }
                }
            }
        }
        let strain_energy = stored.iter().sum();
        let viscous = self.books.viscous + lost.iter().sum::<f64>();
        let kinetic = self.mass.iter().zip(&self.v).map(|(m, v)| 0.5 * m * v * v).sum();
        let Books { input, outflow, .. } = self.books;
        Energies { input, kinetic, strain: strain_energy, viscous, outflow }
    }

    pub(super) fn state_len(&self) -> usize {
        3 * self.u.len() + WIDTH * self.strain.len() * (1 + self.arms.len()) + 4
    }

    pub(super) fn save(&self, values: &mut Vec<f64>) {
        for part in [&self.u, &self.v, &self.a] {
            values.extend(part);
        }
        values.extend(self.strain.as_flattened());
        self.arms.iter().for_each(|arm| values.extend(arm.strain.as_flattened()));
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
        for part in [&mut self.u, &mut self.v, &mut self.a] {
            take(part);
        }
        take(self.strain.as_flattened_mut());
        self.arms.iter_mut().for_each(|arm| take(arm.strain.as_flattened_mut()));
        let mut b = [0.0; 4];
        take(&mut b);
        self.books = Books { input: b[0], outflow: b[1], viscous: b[2], base_traction: b[3] };
    }
}

impl Arm {
    /// Advances one point of a block by the strain increments `delta`; adds to its stress and to the losses.
    #[inline(always)]
    fn advance(
        &mut self,
        block: usize,
        point: usize,
        delta: &Lanes,
        weight: f64,
        stress: &mut Lanes,
        lost: &mut Lanes,
    ) {
        let strain = &mut self.strain[point];
        let (decay, gain) = (&self.decay[block], &self.gain[block]);
        let (modulus, loss) = (&self.modulus[block], &self.loss[block]);
        let quarter = 0.25 * weight;
        for w in 0..WIDTH {
            let before = strain[w];
            let after = decay[w] * before + gain[w] * delta[w];
            let twice_mean = before + after;
            strain[w] = after;
            stress[w] += modulus[w] * after;
            lost[w] += quarter * loss[w] * twice_mean * twice_mean;
        }
    }
}

/// Values of a block's elements, `[point][lane]`; lanes beyond the last element repeat it.
#[inline(always)]
fn gather(u: &[f64], mesh: &Mesh, block: usize) -> [Lanes; POINTS_MAX] {
    let order = mesh.order();
    let last = mesh.elements.len() - 1;
    let mut local = [[0.0; WIDTH]; POINTS_MAX];
    for w in 0..WIDTH {
        let e = (block * WIDTH + w).min(last);
        for (slot, value) in local.iter_mut().zip(&u[e * order..=(e + 1) * order]) {
            slot[w] = *value;
        }
    }
    local
}

/// $\partial u/\partial\xi$ at point `i` of a block's elements.
#[inline(always)]
fn derivative(mesh: &Mesh, local: &[Lanes; POINTS_MAX], i: usize) -> Lanes {
    let n = mesh.gll.len();
    let mut slope = [0.0; WIDTH];
    for (d, u) in mesh.gll.derivative[i * n..(i + 1) * n].iter().zip(local) {
        for w in 0..WIDTH {
            slope[w] += d * u[w];
        }
    }
    slope
}

/// $f_j = \sum_i \ell_j'(\xi_i)\,w_i\sigma_i$, added up over the elements of a block (`stress` holds $w\sigma$).
#[inline(always)]
fn scatter(mesh: &Mesh, stress: &[Lanes], force: &mut [f64], block: usize) {
    let n = mesh.gll.len();
    let present = WIDTH.min(mesh.elements.len() - block * WIDTH);
    let first = block * WIDTH * (n - 1);
    for j in 0..n {
        let mut sum = [0.0; WIDTH];
        for (i, s) in stress.iter().enumerate() {
            let d = mesh.gll.derivative[i * n + j];
            for w in 0..WIDTH {
                sum[w] += d * s[w];
            }
        }
        for (w, f) in sum.iter().enumerate().take(present) {
            force[first + w * (n - 1) + j] += f;
        }
    }
}
