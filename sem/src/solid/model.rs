//! Everything about a solid that does not change while it steps, in one precision.

use super::ground::Ground;
use super::held::Held;
use super::laws::ARM_NUMBERS;
use super::layout::{Layout, NO_ELEMENT};
use super::memory::PointLaw;
use super::real::Real;
use crate::aligned::Aligned;
use crate::gll::Gll;
use nalgebra::Matrix3;
use std::sync::Arc;

/// Lamé's moduli, `[batch][class][lane]`, Pa.
#[derive(Debug, Clone)]
pub(super) struct Moduli<T: Real> {
    pub lambda: Aligned<T>,
    pub mu: Aligned<T>,
}

/// What a kick does to a special point.
#[derive(Debug, Clone)]
pub(super) enum SpecialKick<T> {
    /// $v^+ = v + f\,\Delta t/m$.
    Free(T),
    /// $v^+ = A v + B f$, with the dashpot C for the ledger.
    Held(Box<HeldKick>),
}

/// $v^+ = A v + B f$ with supports and dashpots, and the dashpot C.
#[derive(Debug, Clone)]
pub(super) struct HeldKick {
    pub keep: [[f64; 3]; 3],
    pub force: [[f64; 3]; 3],
    pub dashpot: [[f64; 3]; 3],
}

/// A load at special points, counted from the first of them.
#[derive(Debug, Clone)]
pub(super) struct SpecialLoad {
    pub forces: Vec<(u32, [f64; 3])>,
    pub amplitude: Arc<Vec<f64>>,
}

/// Constants of a solid.
#[derive(Debug, Clone)]
pub(super) struct Model<T: Real> {
    pub gll: Gll,
    pub dimension: usize,
    pub layout: Layout,
    pub dt: T,
    /// $\Delta t/m$ of every point.
    pub dt_over_mass: Aligned<T>,
    /// Relaxed moduli.
    pub moduli: Moduli<T>,
    /// Unrelaxed moduli.
    pub unrelaxed: Moduli<T>,
    /// Metric of every block.
    pub metric: Aligned<T>,
    /// Class of each local point, which chooses among an element's laws ([`super::Memory`]).
    pub class: Vec<u8>,
    /// Classes.
    pub classes: usize,
    /// Most arms of a point.
    pub arms: usize,
    /// Numbers of the arms, `[batch][class][arm][number][lane]`.
    pub arm_lanes: Aligned<T>,
    pub specials: Vec<SpecialKick<T>>,
    pub loads: Vec<SpecialLoad>,
    /// Special points of each interface.
    pub interfaces: Vec<Vec<u32>>,
}

impl<T: Real> Moduli<T> {
    fn of(ground: &Ground, layout: &Layout, of: &dyn Fn(&PointLaw) -> (f64, f64)) -> Self {
        let classes = ground.distribution.classes();
        let zeros = || Aligned::zeros(layout.element.len() * classes);
        let (mut lambda, mut mu) = (zeros(), zeros());
        for (i, &e) in layout.element.iter().enumerate().filter(|(_, e)| **e != NO_ELEMENT) {
            let (batch, lane) = (i / layout.lanes, i % layout.lanes);
            for (class, law) in laws(ground, e).iter().enumerate() {
                let at = (batch * classes + class) * layout.lanes + lane;
                let moduli = of(law);
                (lambda[at], mu[at]) = (T::of(moduli.0), T::of(moduli.1));
            }
        }
        Self { lambda, mu }
    }
}

/// Laws of an element's classes.
fn laws(ground: &Ground, element: u32) -> &[PointLaw] {
    &ground.distribution.laws[ground.mesh().material[element as usize] as usize]
}

impl<T: Real> Model<T> {
    /// Lays out a ground for a step.
    pub(super) fn new(ground: &Ground, dt: f64, lanes: usize, tasks: usize) -> Self {
        let mesh = ground.mesh();
        let gll = ground.gll().clone();
        let special = ground.special();
        let mut layout = Layout::new(mesh, ground.numbering(), &special, lanes, tasks);
        let metric = metric::<T>(ground, &mut layout);
        let moduli = Moduli::of(ground, &layout, &|law| law.relaxed);
        let unrelaxed = Moduli::of(ground, &layout, &PointLaw::unrelaxed);
        let arm_lanes = arm_lanes(ground, &layout, dt);
        let mut dt_over_mass = Aligned::zeros(layout.nodes);
        for (mass, &number) in ground.mass().iter().zip(&layout.number) {
            dt_over_mass[number as usize] = T::of(dt / mass);
        }
        let mut model = Self {
            gll,
            dimension: mesh.dimension,
            dt: T::of(dt),
            dt_over_mass,
            moduli,
            unrelaxed,
            metric,
            class: ground.distribution.class.clone(),
            classes: ground.distribution.classes(),
            arms: ground.distribution.arms(),
            arm_lanes,
            specials: vec![],
            loads: vec![],
            interfaces: vec![],
            layout,
        };
        model.add_specials(ground, dt);
        model
    }

    fn add_specials(&mut self, ground: &Ground, dt: f64) {
        let first = self.layout.special;
        let mut kicks: Vec<Option<SpecialKick<T>>> = vec![None; self.layout.nodes - first];
        let place = |point: u32| self.layout.number[point as usize] as usize - first;
        for (&point, held) in &ground.held {
            let kick = held_kick(held, ground.mass()[point as usize], dt);
            kicks[place(point)] = Some(SpecialKick::Held(Box::new(kick)));
        }
        let free = |i: usize| SpecialKick::Free(self.dt_over_mass[first + i]);
        self.specials = kicks.into_iter().enumerate().map(|(i, k)| k.unwrap_or_else(|| free(i))).collect();
        self.loads = (ground.loads.iter())
            .map(|load| SpecialLoad {
                forces: load.forces.iter().map(|&(p, f)| (place(p) as u32, f)).collect(),
                amplitude: Arc::clone(&load.amplitude),
            })
            .collect();
        self.interfaces = (ground.interfaces.iter())
            .map(|points| points.iter().map(|&p| place(p) as u32).collect())
            .collect();
    }

    /// Points along the third axis.
    pub(super) fn planes(&self) -> usize {
        if self.dimension == 2 { 1 } else { self.gll.len() }
    }

    /// Numbers of a batch's memory variables.
    pub(super) fn dashpots_per_batch(&self) -> usize {
        let components = super::kernel::strain_components(self.planes());
        self.layout.points * self.arms * components * self.layout.lanes
    }

    /// Bytes of everything here.
    pub(super) fn bytes(&self) -> usize {
        let l = &self.layout;
        let numbers =
            self.dt_over_mass.len() + 4 * self.moduli.lambda.len() + self.metric.len() + self.arm_lanes.len();
        let words = l.element.len()
            + l.halo.len()
            + l.sums.len()
            + l.sums_start.len()
            + l.number.len()
            + l.block_of.len();
        let held = self.specials.iter().filter(|s| matches!(s, SpecialKick::Held(_))).count();
        numbers * size_of::<T>()
            + 4 * words
            + self.class.len()
            + 2 * l.local.len()
            + self.specials.len() * size_of::<SpecialKick<T>>()
            + held * size_of::<HeldKick>()
    }
}

/// Metric of every block, lanes side by side; empty lanes repeat the batch's first element.
fn metric<T: Real>(ground: &Ground, layout: &mut Layout) -> Aligned<T> {
    let (lanes, mesh, gll) = (layout.lanes, ground.mesh(), ground.gll());
    let planes = if mesh.dimension == 2 { 1 } else { gll.len() };
    let sizes: Vec<usize> = (layout.blocks.iter())
        .map(|b| b.batches.len() * lanes * b.metric.values(planes, layout.points))
        .collect();
    let mut metric = Aligned::zeros(sizes.iter().sum());
    let mut start = 0;
    let mut values = vec![];
    for (block, size) in layout.blocks.iter_mut().zip(sizes) {
        block.metric_start = start;
        let per = block.metric.values(planes, layout.points);
        for (index, batch) in block.batches.clone().enumerate() {
            for lane in 0..lanes {
                let own = layout.element[batch * lanes + lane];
                let e = if own == NO_ELEMENT { layout.element[batch * lanes] } else { own };
                values.clear();
                block.metric.fill(mesh, e as usize, gll, &mut values);
                let to = start + index * per * lanes + lane;
                values.iter().enumerate().for_each(|(i, v)| metric[to + i * lanes] = T::of(*v));
            }
        }
        start += size;
    }
    metric
}

fn arm_lanes<T: Real>(ground: &Ground, layout: &Layout, dt: f64) -> Aligned<T> {
    let (lanes, classes, arms) = (layout.lanes, ground.distribution.classes(), ground.distribution.arms());
    let mut numbers = Aligned::zeros(layout.element.len() * classes * arms * ARM_NUMBERS);
    for (i, &e) in layout.element.iter().enumerate() {
        let (batch, lane) = (i / lanes, i % lanes);
        for l in 0..classes * arms {
            let mut own = [1.0, 0.0, 0.0, 0.0, 2.0, 1.0];
            if e != NO_ELEMENT
                && let Some(arm) = laws(ground, e)[l / arms].arms.get(l % arms)
            {
                let x = 0.5 * arm.omega * dt;
                let (lambda, mu) = arm.moduli;
                // an arm faster than the step has d = 0: the ledger then books its loss by a neighbour of d
                let decay = if (1.0 - x).abs() < 1e-3 { 1e-3 } else { 1.0 - x } / (1.0 + x);
                let gain = 1.0 / (1.0 + x);
                own = [gain, 2.0 * x, lambda, mu, 1.0 + 1.0 / decay, gain / decay];
            }
            for (k, value) in own.iter().enumerate() {
                numbers[((batch * classes * arms + l) * ARM_NUMBERS + k) * lanes + lane] = T::of(*value);
            }
        }
    }
    numbers
}

/// Half-implicit dashpots and supports of one point: with P the projection onto what is free,
/// $v^+ = A^{-1}[(m - \tfrac{\Delta t}{2}PCP)v + \Delta t\,Pf]$, $A = m + \tfrac{\Delta t}{2}PCP$.
fn held_kick(held: &Held, mass: f64, dt: f64) -> HeldKick {
    let free = held.free();
    let dashpot = Matrix3::from_fn(|i, j| held.dashpot[i][j]);
    let c = 0.5 * dt * free * dashpot * free;
    let m = Matrix3::from_diagonal_element(mass);
    let inverse = (m + c).try_inverse().unwrap_or_else(Matrix3::zeros);
    let rows = |m: Matrix3<f64>| std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]));
    HeldKick {
        keep: rows(free * inverse * (m - c) * free),
        force: rows(dt * free * inverse * free),
        dashpot: rows(free * dashpot * free),
    }
}
