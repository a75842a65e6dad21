//! The layered column: spectral elements along depth, displacement with up to three components.
//!
//! Each active component is a wave equation of its own, $\rho\,\ddot u = \partial_z\sigma$, with
//! $\sigma = G * \partial_z u$ for x and y and $\sigma = \rho v_p^2 * \partial_z u$ for z (vertical
//! incidence: SH, SV and P do not mix in isotropic layers). The base is an elastic half-space, felt as
//! the traction $\rho c\,(v_{\mathrm{outcrop}} - v)$, or its motion is imposed.
//!
//! Time: drift–kick–drift ([`hati_coupling::central_difference`]); kick $n$ falls on the sample
//! instant $n\,\Delta t$. Memory variables follow the trapezoidal rule between kicks,
//! $e^{n+1} = \dfrac{(1 - x)\,e^n + \Delta\varepsilon}{1 + x}$ with $x = \omega_l\Delta t/2$, so an
//! alternating motion meets the unrelaxed modulus, and the critical step is $2/\omega_{\max}$ of the
//! unrelaxed elastic column, damped or not.
//!
//! Energy, exact for the discrete scheme (η = strain of an arm's spring, bars = means of two kicks):
//! $$ \Delta\Big[\tfrac12 v^T M v + \tfrac12 \varepsilon^{n+1} G_R\,\varepsilon^{n}
//! {} + \sum_l \tfrac12 g_l e^{n+1}e^{n} - \tfrac{g_l\omega_l\Delta t}{8}\big((e^{n+1})^2 - (e^{n})^2\big)\Big] = \mathrm{work}
//! {} - \sum_l g_l\,\omega_l\Delta t\,\tfrac12(\bar e_+^2 + \bar e_-^2). $$

mod component;
mod mesh;
mod response;

pub use mesh::{Discretisation, Element, Mesh, Probe};
pub use response::{FrequencyResponse, TimeSymbol, Transfer};

use crate::SemError;
use crate::attenuation::MaxwellArms;
use crate::soil::Profile;
use component::Component;
use hati_coupling::central_difference::dt_critical;
use hati_coupling::spectral_bound::omega_max;
use hati_coupling::{CouplingError, Energies, State, Subdomain};

/// Motion of the base for one component, sampled at the kicks.
#[derive(Debug, Clone)]
pub enum BaseMotion {
    /// Outcrop velocity, m/s, at kicks 0, 1, 2, …: the incident wave carries half of it. Zero afterwards.
    Outcrop(Vec<f64>),
    /// Displacement of the base, m, at the kicks (within motion; the base's own motion is imposed).
    /// Beyond the last one it goes on at its last velocity.
    Imposed(Vec<f64>),
}

/// Motion of a point at the latest kick.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PointMotion {
    /// m
    pub displacement: f64,
    /// m/s
    pub velocity: f64,
    /// m/s²
    pub acceleration: f64,
}

/// The column as a subdomain. Interface 0 is the surface; interface 1 the base where it is elastic.
#[derive(Debug, Clone)]
pub struct Column {
    mesh: Mesh,
    axes: Vec<usize>,
    components: Vec<Component>,
    dt: f64,
    dt_critical: f64,
    limiting: usize,
    imposed: bool,
    step: u64,
}

impl Column {
    /// Builds a column.
    ///
    /// - `motion[axis]`: base motion of each active component, x = 0, y = 1, z = 2;
    /// - `arms[layer][axis]`: memory variables;
    /// - `dt`: step, s; nothing is refused here, [`Subdomain::dt_critical`] tells the limit.
    ///
    /// Errors: no component, a profile or mesh out of range.
    pub fn new(
        profile: &Profile,
        discretisation: &Discretisation,
        arms: &[[MaxwellArms; 3]],
        dt: f64,
        motion: [Option<BaseMotion>; 3],
    ) -> Result<Self, SemError> {
        profile.check()?;
        let mesh = Mesh::new(profile, discretisation)?;
        let mut components = vec![];
        let mut axes = vec![];
        let mut imposed = false;
        let (mut limit, mut limiting) = (f64::INFINITY, 0);
        for (axis, motion) in motion.into_iter().enumerate() {
            let Some(motion) = motion else { continue };
            imposed = matches!(motion, BaseMotion::Imposed(_));
            let component = Component::new(profile, &mesh, axis, arms, dt, motion);
            let critical = critical_step(&mesh, &component)?;
            if critical < limit {
                (limit, limiting) = (critical, component.limiting_element(profile, &mesh));
            }
            axes.push(axis);
            components.push(component);
        }
        if components.is_empty() {
            return Err(SemError::NoComponent);
        }
        Ok(Self { mesh, axes, components, dt, dt_critical: limit, limiting, imposed, step: 0 })
    }

    /// Critical step of a mesh for the given components, s, and the element that limits it, without
    /// building a column for a run. A base whose motion is `imposed` does not move with the highest
    /// mode, which raises the limit.
    pub fn critical_step(
        profile: &Profile,
        discretisation: &Discretisation,
        arms: &[[MaxwellArms; 3]],
        axes: &[usize],
        imposed: bool,
    ) -> Result<(f64, Element), SemError> {
        let still = || if imposed { BaseMotion::Imposed(vec![]) } else { BaseMotion::Outcrop(vec![]) };
        let mut motion = [None, None, None];
        axes.iter().for_each(|&a| motion[a] = Some(still()));
        let column = Self::new(profile, discretisation, arms, 1.0, motion)?;
        Ok((column.dt_critical, column.limiting_element()))
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Active components, in the order of interface freedoms.
    pub fn axes(&self) -> &[usize] {
        &self.axes
    }

    /// The element whose wave speed and size bound the step.
    pub fn limiting_element(&self) -> Element {
        self.mesh.elements[self.limiting]
    }

    /// Starts component `index` from positions and velocities given over depth, at the instant
    /// [`Subdomain::time`] (half a step before the next kick); memory variables start from zero.
    pub fn set_motion(&mut self, index: usize, motion: impl Fn(f64) -> (f64, f64)) {
        self.components[index].set_motion(&self.mesh, self.dt, motion);
    }

    /// Instant of the latest kick relative to the first sample, s.
    pub fn kick_time(&self) -> f64 {
        (self.step as f64 - 1.0) * self.dt
    }

    /// Steps taken.
    pub fn steps_taken(&self) -> u64 {
        self.step
    }

    /// Motion of a probe at the latest kick; `index` counts the active components.
    pub fn motion_at(&self, probe: &Probe, index: usize) -> PointMotion {
        self.components[index].motion_at(probe, self.mesh.order(), self.dt)
    }

    /// Strain ∂u/∂z and stress at every point of every element at the latest kick: calls
    /// `visit(depth, strain, stress)` from the surface down, interface points twice. Strain and stress
    /// take z upwards.
    pub fn strain_stress(&self, index: usize, mut visit: impl FnMut(usize, f64, f64)) {
        self.components[index].strain_stress(&self.mesh, &mut visit);
    }

    /// Depth of the points that [`Self::strain_stress`] and [`Self::point_motion`] visit, m.
    pub fn element_point_depths(&self) -> Vec<f64> {
        let n = self.mesh.order();
        (0..self.mesh.elements.len()).flat_map(|e| (0..=n).map(move |i| self.mesh.depth[e * n + i])).collect()
    }

    /// Motion of node `node` at the latest kick.
    pub fn node_motion(&self, node: usize, index: usize) -> PointMotion {
        self.components[index].node_motion(node, self.dt)
    }

    /// Outcrop velocity that goes with the base's motion and traction at the latest kick, m/s:
    /// $v + \tau/(\rho c)$ with the half-space's impedance $\rho c$.
    pub fn outcrop_velocity(&self, index: usize, impedance: f64) -> f64 {
        self.components[index].outcrop_velocity(self.dt, impedance)
    }

    /// Largest absolute velocity and its depth, m/s and m, over all components; NaN where one is met.
    pub fn fastest_point(&self) -> (f64, f64) {
        let mut worst = (0.0, 0.0);
        for c in &self.components {
            for (v, depth) in c.velocities().iter().zip(&self.mesh.depth) {
                if v.is_nan() {
                    return (f64::NAN, *depth);
                }
                if v.abs() > worst.0 {
                    worst = (v.abs(), *depth);
                }
            }
        }
        worst
    }
}

/// Critical step of one component of the unrelaxed column, free at both ends unless imposed.
fn critical_step(mesh: &Mesh, component: &Component) -> Result<f64, CouplingError> {
    let mut scratch = component.elastic_scratch();
    let omega =
        omega_max(component.free_mass(), |u, f| component.unrelaxed_force(mesh, u, f, &mut scratch), 1e-5)?;
    Ok(dt_critical(omega))
}

impl Subdomain for Column {
    fn name(&self) -> &str {
        "column"
    }

    fn dt(&self) -> f64 {
        self.dt
    }

    fn dt_critical(&self) -> Option<f64> {
        Some(self.dt_critical)
    }

    fn time(&self) -> f64 {
        (self.step as f64 - 0.5) * self.dt
    }

    fn step(&mut self) {
        for component in &mut self.components {
            component.step(&self.mesh, self.step as usize, self.dt);
        }
        self.step += 1;
    }

    fn interface_count(&self) -> usize {
        if self.imposed { 1 } else { 2 }
    }

    fn interface_len(&self, _interface: usize) -> usize {
        self.axes.len()
    }

    fn interface_position(&self, interface: usize, position: &mut [f64]) {
        for (p, c) in position.iter_mut().zip(&self.components) {
            *p = c.end_position(interface);
        }
    }

    fn interface_velocity(&self, interface: usize, velocity: &mut [f64]) {
        for (v, c) in velocity.iter_mut().zip(&self.components) {
            *v = c.end_velocity(interface);
        }
    }

    fn set_multiplier(&mut self, interface: usize, multiplier: &[f64]) {
        for (m, c) in multiplier.iter().zip(&mut self.components) {
            c.set_multiplier(interface, *m);
        }
    }

    fn energies(&mut self) -> Energies {
        let mut sum = Energies::default();
        for c in &mut self.components {
            let e = c.energies(&self.mesh, self.dt);
            sum.input += e.input;
            sum.kinetic += e.kinetic;
            sum.strain += e.strain;
            sum.viscous += e.viscous;
            sum.outflow += e.outflow;
        }
        sum
    }

    fn save(&self, state: &mut State) {
        state.step = self.step;
        state.values.clear();
        self.components.iter().for_each(|c| c.save(&mut state.values));
    }

    fn restore(&mut self, state: &State) -> Result<(), CouplingError> {
        let expected: usize = self.components.iter().map(Component::state_len).sum();
        let found = state.values.len();
        if found != expected {
            return Err(CouplingError::StateSize { subdomain: self.name().into(), found, expected });
        }
        self.step = state.step;
        let mut rest = &state.values[..];
        for c in &mut self.components {
            let (own, next) = rest.split_at(c.state_len());
            c.restore(own);
            rest = next;
        }
        Ok(())
    }
}
