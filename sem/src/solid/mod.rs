//! The ground at D = 2 and 3: elastic or viscoelastic elements, explicit steps, on one thread or several.
//!
//! $$ M\,\dot v = f_{\mathrm{ext}} - \int_\Omega \sigma(u) : \nabla w\,d\Omega - C v,\qquad
//!    \sigma = \lambda\,\mathrm{tr}\,\varepsilon\,I + 2\mu\,\varepsilon + \text{memory}, $$
//! with GLL quadrature on the basis's own points, so that M is diagonal. Displacement has three components
//! at D = 2 as well: a section carries P-SV and SH waves at once.
//!
//! - [`Ground`]: mesh, materials, supports and loads, assembled once;
//! - [`Solid`]: the same in one precision, with a step, ready to run, as a subdomain of `coupling`;
//! - [`Memory`]: how memory variables are spread over the points;
//! - [`Metric`]: how much of an element's geometry is kept;
//! - [`dispersion`]: how many points a wavelength needs;
//! - [`reference`]: the internal force by its formula, slow and clear, for parity tests.
//!
//! Time: drift–kick–drift ([`hati_coupling::central_difference`]); kick $n$ falls on $t = n\Delta t$, loads are taken
//! there. What is stored between steps is the position of the *next* kick, two drifts in one.
//!
//! Energy, exact for the discrete scheme, is that of [`crate::column`], with $\varepsilon$ the strain tensor.

mod block;
mod cost;
pub mod dispersion;
mod gauge;
mod gaussian;
mod geometry;
mod ground;
mod held;
mod kernel;
mod laws;
mod layout;
mod material;
mod memory;
mod model;
mod portable;
mod real;
pub mod reference;
mod state;
mod step;
mod watch;

pub use cost::Cost;
pub use gauge::{Gauge, Tensors};
pub use gaussian::Gaussian;
pub use geometry::Metric;
pub use ground::{Ground, Load, Probe, Support};
pub use held::{BoundaryPlane, FLAT};
pub use material::Material;
pub use memory::{Memory, PointArm, PointLaw, coarse_error};
pub use real::Real;
pub use watch::Watch;

use crate::SemError;
use crate::aligned::Aligned;
use block::{Books, Pass, Scratch};
use hati_coupling::central_difference::dt_critical;
use hati_coupling::spectral_bound::omega_max;
use hati_coupling::{CouplingError, Energies, State, Subdomain};
use model::Model;
use step::{Arrays, Exchange};

/// Vector instructions of the kernel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Instructions {
    /// The widest that the machine has.
    #[default]
    Best,
    /// None: the portable path, one element at a time.
    Portable,
}

impl Instructions {
    /// Elements side by side in a vector of `T` at a polynomial order.
    pub fn lanes<T: Real>(self, order: usize) -> usize {
        if self == Self::Best && step::FAST_ORDERS.contains(&order) { step::lanes::<T>() } else { 1 }
    }
}

/// How a solid computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Execution {
    /// Threads; 1 stays on the caller's. More run in the current `rayon` pool.
    pub threads: usize,
    /// Vector instructions.
    pub instructions: Instructions,
}

impl Default for Execution {
    fn default() -> Self {
        Self { threads: 1, instructions: Instructions::Best }
    }
}

/// Motion of a place at the latest kick.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Motion {
    /// m
    pub displacement: [f64; 3],
    /// m/s
    pub velocity: [f64; 3],
    /// m/s²
    pub acceleration: [f64; 3],
}

/// A solid in precision `T`, ready to step.
pub struct Solid<T: Real> {
    model: Model<T>,
    execution: Execution,
    /// Positions at the next kick, velocities since the last one.
    x: Aligned<T>,
    v: Aligned<T>,
    partial: Aligned<T>,
    dashpots: Aligned<T>,
    scratch: Vec<Scratch<T>>,
    block_books: Vec<Books>,
    exchange: Vec<Exchange>,
    external: Vec<[f64; 3]>,
    multipliers: Vec<[f64; 3]>,
    books: Energies,
    step: u64,
    dt: f64,
    dt_critical: f64,
}

impl<T: Real> Solid<T> {
    /// A ground in precision `T` with step `dt` (s). Nothing is refused for the step:
    /// [`Solid::critical_step`] tells the limit before, [`Subdomain::dt_critical`] afterwards.
    pub fn new(ground: &Ground, dt: f64, dt_critical: f64, execution: Execution) -> Self {
        let lanes = execution.instructions.lanes::<T>(ground.gll().len() - 1);
        // more tasks than threads, so that one that is held up does not keep the others waiting
        let tasks = if execution.threads > 1 { 4 * execution.threads } else { 1 };
        let model = Model::new(ground, dt, lanes, tasks);
        let (layout, nodes) = (&model.layout, model.layout.nodes);
        let batches = layout.element.len() / lanes;
        let portable = if lanes == 1 { layout.points } else { 0 };
        Self {
            x: Aligned::zeros(3 * nodes),
            v: Aligned::zeros(3 * nodes),
            partial: Aligned::zeros(3 * layout.halo.len()),
            dashpots: Aligned::zeros(batches * model.dashpots_per_batch()),
            scratch: layout.leaves.iter().map(|_| Scratch::new(portable)).collect(),
            block_books: vec![Books::default(); layout.blocks.len()],
            exchange: vec![Exchange::default(); step::shared_runs(&model)],
            external: vec![[0.0; 3]; nodes - layout.special],
            multipliers: vec![[0.0; 3]; nodes - layout.special],
            books: Energies::default(),
            step: 0,
            dt,
            dt_critical,
            execution,
            model,
        }
    }

    /// Critical step of the unrelaxed solid, s: $2/\omega_{\max}$ of the assembled operator, supports
    /// included, by Lanczos; errs to the safe side by at most `tolerance`.
    ///
    /// Cost: some tens of steps, and memory for a few vectors of f64.
    pub fn critical_step(ground: &Ground, tolerance: f64, execution: Execution) -> Result<f64, SemError> {
        let mut solid = Self::new(ground, 1.0, f64::INFINITY, execution);
        let places: Vec<(usize, usize)> =
            solid.model.layout.number.iter().map(|&n| solid.model.layout.place(n as usize)).collect();
        let mass: Vec<f64> = ground.mass().iter().flat_map(|&m| [m; 3]).collect();
        let free: Vec<(usize, Vec<[f64; 3]>)> =
            ground.held.iter().map(|(p, h)| (*p as usize, h.directions.clone())).collect();
        let project = |u: &mut [f64]| {
            for (p, directions) in &free {
                for n in directions {
                    let along: f64 = (0..3).map(|c| n[c] * u[3 * p + c]).sum();
                    (0..3).for_each(|c| u[3 * p + c] -= along * n[c]);
                }
            }
        };
        let mut held = vec![0.0; mass.len()];
        let omega = omega_max(
            &mass,
            |u, f| {
                // forces in the units of the largest stress would overflow nothing, but f32 has few digits:
                // positions of the order of one and masses that are divided out keep them all
                held.copy_from_slice(u);
                project(&mut held);
                let scale = held.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
                for (p, &(first, stride)) in places.iter().enumerate() {
                    (0..3).for_each(|c| solid.x[first + c * stride] = T::of(held[3 * p + c] / scale));
                }
                solid.pass(Pass::UnrelaxedForce);
                for (p, &(first, stride)) in places.iter().enumerate() {
                    (0..3).for_each(|c| f[3 * p + c] = scale * solid.v[first + c * stride].f64());
                }
                project(f);
            },
            tolerance,
        )?;
        Ok(dt_critical(omega))
    }

    fn pass(&mut self, pass: Pass) {
        let arrays = Arrays {
            x: &mut self.x,
            v: &mut self.v,
            partial: &mut self.partial,
            dashpots: &mut self.dashpots,
            books: &mut self.block_books,
            exchange: &mut self.exchange,
            scratch: &mut self.scratch,
        };
        let parallel = self.execution.threads > 1;
        step::run(&self.model, pass, parallel, arrays, &self.external);
    }

    /// Instant of the latest kick, s.
    pub fn kick_time(&self) -> f64 {
        (self.step as f64 - 1.0) * self.dt
    }

    /// Steps taken.
    pub fn steps_taken(&self) -> u64 {
        self.step
    }

    /// Starts from positions and velocities at the instant [`Subdomain::time`], half a step before the
    /// next kick; memory variables start unstrained.
    pub fn set_motion(&mut self, ground: &Ground, motion: impl Fn([f64; 3]) -> ([f64; 3], [f64; 3])) {
        for (point, position) in ground.positions().into_iter().enumerate() {
            let (first, stride) = self.model.layout.place(self.model.layout.number[point] as usize);
            let (u, v) = motion(position);
            for c in 0..3 {
                self.x[first + c * stride] = T::of(u[c] + 0.5 * self.dt * v[c]);
                self.v[first + c * stride] = T::of(v[c]);
            }
        }
    }

    /// Largest absolute velocity of a point and its number; NaN where one is met.
    pub fn fastest_point(&self) -> (f64, u32) {
        let mut worst = (0.0, 0);
        for (point, &number) in (0u32..).zip(&self.model.layout.number) {
            let (first, stride) = self.model.layout.place(number as usize);
            for c in 0..3 {
                let v = self.v[first + c * stride].f64().abs();
                if v.is_nan() {
                    return (f64::NAN, point);
                }
                if v > worst.0 {
                    worst = (v, point);
                }
            }
        }
        worst
    }

    /// Bytes of all arrays, scratch aside.
    pub fn bytes(&self) -> usize {
        let numbers = self.x.len() + self.v.len() + self.partial.len() + self.dashpots.len();
        numbers * size_of::<T>() + self.model.bytes() + 48 * self.external.len()
    }

    /// Elements whose metric is found in each way: affine, from corners, stored.
    pub fn metrics(&self) -> [usize; 3] {
        let mut count = [0; 3];
        for block in &self.model.layout.blocks {
            let lanes = self.model.layout.lanes;
            let range = block.batches.start * lanes..block.batches.end * lanes;
            let elements =
                self.model.layout.element[range].iter().filter(|e| **e != layout::NO_ELEMENT).count();
            count[block.metric as usize] += elements;
        }
        count
    }

    fn gather_external(&mut self) {
        self.external.copy_from_slice(&self.multipliers);
        for load in &self.model.loads {
            let Some(a) = load.amplitude.get(self.step as usize).filter(|a| **a != 0.0) else { continue };
            for &(i, f) in &load.forces {
                (0..3).for_each(|c| self.external[i as usize][c] += a * f[c]);
            }
        }
    }

    fn kinetic(&self) -> f64 {
        let (layout, model) = (&self.model.layout, &self.model);
        let mut sum = 0.0;
        for block in &layout.blocks {
            let inner = block.inner.len();
            for c in 0..3 {
                let first = 3 * block.inner.start + c * inner;
                let mut part = 0.0;
                for (v, m) in
                    self.v[first..first + inner].iter().zip(&model.dt_over_mass[block.inner.clone()])
                {
                    part += v.f64() * v.f64() / m.f64();
                }
                sum += part;
            }
        }
        for number in layout.shared..layout.nodes {
            let v = &self.v[3 * number..3 * number + 3];
            sum += v.iter().map(|v| v.f64() * v.f64()).sum::<f64>() / model.dt_over_mass[number].f64();
        }
        0.5 * self.dt * sum
    }

    fn interface_points(&self, interface: usize) -> &[u32] {
        &self.model.interfaces[interface]
    }

    fn at_special(&self, i: u32) -> usize {
        3 * (self.model.layout.special + i as usize)
    }
}

impl<T: Real> Subdomain for Solid<T> {
    fn name(&self) -> &str {
        "ground"
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
        self.gather_external();
        self.pass(Pass::Step);
        for e in &self.exchange {
            self.books.input += e.input;
            self.books.outflow += e.outflow;
        }
        self.step += 1;
    }

    fn interface_count(&self) -> usize {
        self.model.interfaces.len()
    }

    fn interface_len(&self, interface: usize) -> usize {
        3 * self.interface_points(interface).len()
    }

    fn interface_position(&self, interface: usize, position: &mut [f64]) {
        for (&i, to) in self.interface_points(interface).iter().zip(position.as_chunks_mut::<3>().0) {
            let at = self.at_special(i);
            *to = std::array::from_fn(|c| self.x[at + c].f64() - 0.5 * self.dt * self.v[at + c].f64());
        }
    }

    fn interface_velocity(&self, interface: usize, velocity: &mut [f64]) {
        for (&i, to) in self.interface_points(interface).iter().zip(velocity.as_chunks_mut::<3>().0) {
            let at = self.at_special(i);
            *to = std::array::from_fn(|c| self.v[at + c].f64());
        }
    }

    fn set_multiplier(&mut self, interface: usize, multiplier: &[f64]) {
        for (&i, from) in self.model.interfaces[interface].iter().zip(multiplier.as_chunks::<3>().0) {
            self.multipliers[i as usize] = *from;
        }
    }

    fn energies(&mut self) -> Energies {
        self.pass(Pass::Energies);
        let sum = |of: &dyn Fn(&Books) -> f64| self.block_books.iter().map(of).sum::<f64>();
        Energies {
            kinetic: self.kinetic(),
            strain: sum(&|b| b.strain),
            viscous: sum(&|b| b.viscous + b.pending),
            ..self.books
        }
    }

    fn save(&self, state: &mut State) {
        state.step = self.step;
        state.values.clear();
        for part in [&self.x, &self.v, &self.dashpots] {
            state.values.extend(part.iter().map(|x| x.f64()));
        }
        state.values.extend(self.block_books.iter().map(|b| b.viscous));
        state.values.extend([self.books.input, self.books.outflow]);
    }

    fn restore(&mut self, state: &State) -> Result<(), CouplingError> {
        let lengths = [self.x.len(), self.v.len(), self.dashpots.len(), self.block_books.len(), 2];
        let (expected, found) = (lengths.iter().sum(), state.values.len());
        if found != expected {
            return Err(CouplingError::StateSize { subdomain: self.name().into(), found, expected });
        }
        self.step = state.step;
        let mut rest = state.values.iter();
        for part in [&mut self.x, &mut self.v, &mut self.dashpots] {
            part.iter_mut().zip(&mut rest).for_each(|(x, value)| *x = T::of(*value));
        }
        self.block_books.iter_mut().zip(&mut rest).for_each(|(b, value)| b.viscous = *value);
        [&mut self.books.input, &mut self.books.outflow].into_iter().zip(rest).for_each(|(b, v)| *b = *v);
        Ok(())
    }
}
