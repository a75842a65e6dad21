//! What a run takes: memory, disk, time.

use super::plan::VolumePlan;
use super::sampling::Rows;
use crate::plan::{PlanError, available_memory};
use hati_inputs::scene::{MemoryVariables, Precision};
use std::sync::LazyLock;

/// Vectors of f64 of the whole ground that the spectral bound holds at once: three of the basis, masses and their roots,
/// the two of a product, that product's copy, and the points' places (two words of three).
const LANCZOS_VECTORS: f64 = 8.7;
/// Where the ground has few freedoms all vectors are kept, some tens of them.
const LANCZOS_KEPT: f64 = 100.0;
const LANCZOS_FEW: f64 = 20_000.0;

/// The stored result of `make bench`, and its name.
const BENCH: (&str, &str) = (
    "benches/results/throughput-2026-11-21.csv",
    include_str!("../../benches/results/throughput-2026-11-21.csv"),
);
/// Arms of the bench's damped ground.
const BENCH_ARMS: f64 = 3.0;
/// Share of what these arms cost that does not depend on their number: the losses, which need the strain's increment.
const LOSSES: f64 = 0.36;

/// Speed of the time loop as the bench measured it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Speed {
    /// Which result, on which machine.
    pub(super) from: String,
    /// ns per point and step, `[affine, deformed][f32, f64][one thread, two][elastic, viscoelastic]`.
    pub(super) ns_per_point: [[[[f64; 2]; 2]; 2]; 2],
    /// Arms of the viscoelastic ground.
    pub(super) arms: f64,
}

/// The speed that estimates take.
pub(super) fn speed() -> &'static Speed {
    static SPEED: LazyLock<Speed> = LazyLock::new(|| Speed::read(BENCH.0, BENCH.1));
    &SPEED
}

impl Speed {
    /// From the bench's table; what it lacks is not a number.
    fn read(name: &str, text: &str) -> Self {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let head: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let machine = text.lines().next().unwrap_or_default().split(',').nth(1).unwrap_or_default().trim();
        let mut speed = Self {
            from: format!("{name} ({machine})"),
            ns_per_point: [[[[f64::NAN; 2]; 2]; 2]; 2],
            arms: BENCH_ARMS,
        };
        for line in lines {
            let cells: Vec<&str> = line.split(',').collect();
            let of = |key: &str| head.iter().position(|h| *h == key).and_then(|i| cells.get(i)).copied();
            let which = |key: &str, words: [&str; 2]| words.iter().position(|w| of(key) == Some(w));
            let (Some(mesh), Some(law), Some(precision), Some(threads), Some(ns)) = (
                which("mesh", ["affine", "deformed"]),
                which("law", ["elastic", "viscous"]),
                which("precision", ["f32", "f64"]),
                which("threads", ["1", "2"]),
                of("ns_per_point").and_then(|cell| cell.parse().ok()),
            ) else {
                continue;
            };
            speed.ns_per_point[mesh][precision][threads][law] = ns;
        }
        speed
    }
}

/// Bytes of the vectors of the spectral bound: they are gone before a run opens its outputs.
fn spectral_bytes(elements: f64, dimension: usize, order: usize) -> f64 {
    let freedoms = 3.0 * points(elements, dimension, order);
    let kept = if freedoms > LANCZOS_FEW { 0.0 } else { LANCZOS_KEPT };
    8.0 * freedoms * (LANCZOS_VECTORS + kept)
}

/// Points of so many elements, about: what the rim has more is a tenth at most of a large ground.
fn points(elements: f64, dimension: usize, order: usize) -> f64 {
    elements * (order as f64).powi(dimension as i32) * 1.1
}

/// Bytes of a run: the ground in f64, the solid, scratch.
///
/// Counted from the arrays: `per_point` 36 bytes of the ground's mass and maps, seven numbers of the solid and a
/// local number; `per_element` connectivity, local numbers, metric, memory variables.
fn bytes(
    elements: f64,
    dimension: usize,
    order: usize,
    precision: Precision,
    arms: usize,
    threads: usize,
) -> f64 {
    let number = if precision == Precision::F64 { 8.0 } else { 4.0 };
    let local = ((order + 1) as f64).powi(dimension as i32);
    let points = points(elements, dimension, order);
    let components = if dimension == 2 { 5.0 } else { 6.0 };
    let per_element =
        4.0 * local + 2.0 * local + 64.0 + 21.0 * number + arms as f64 * components * local * number;
    let per_point = 36.0 + 8.0 * number;
    let scratch = 4.0 * threads as f64 * 9.0 * 65536.0 * number;
    elements * per_element + points * per_point + scratch
}

/// Refuses what cannot fit, before anything of that size is made.
pub(super) fn expect_memory(
    elements: f64,
    dimension: usize,
    order: usize,
    is_box: bool,
) -> Result<(), PlanError> {
    let Some(available) = available_memory() else { return Ok(()) };
    let needed =
        bytes(elements, dimension, order, Precision::F32, 0, 1) + spectral_bytes(elements, dimension, order);
    if needed <= available {
        return Ok(());
    }
    let help = if is_box {
        "make the domain smaller, lower discretisation.f_max, give fewer points_per_wavelength or a larger element_size"
    } else {
        "mesh coarser, or cut the domain"
    };
    let help = help.to_owned();
    let (needed_mb, available_mb) = (needed / 1e6, available / 1e6);
    Err(PlanError::MemoryOfElements { needed_mb, available_mb, elements, order, help })
}

/// Refuses time functions that cannot fit, before any is made: one array for each that differs.
pub(super) fn expect_amplitudes(steps: u64, functions: usize) -> Result<(), PlanError> {
    let Some(available) = available_memory() else { return Ok(()) };
    let needed = 8.0 * steps as f64 * functions as f64;
    if needed <= available {
        return Ok(());
    }
    let (needed_mb, available_mb) = (needed / 1e6, available / 1e6);
    Err(PlanError::MemoryOfSources { needed_mb, available_mb, steps: steps as f64, functions })
}

impl VolumePlan {
    /// Memory variables of a point, in strain components.
    fn arms_per_point(&self) -> usize {
        match self.memory_variables {
            MemoryVariables::Full => self.mechanisms.0,
            MemoryVariables::Coarse => self.mechanisms.0.min(1),
        }
    }

    /// Memory of a run, bytes.
    pub fn memory(&self) -> f64 {
        let (order, arms) = (self.resolution.order, self.arms_per_point());
        let solid = bytes(self.elements() as f64, self.dimension, order, self.precision, arms, self.threads);
        let loads = self.ground.load_bytes() as f64;
        let watched = |points: usize| 80.0 * points as f64;
        let kept = |rows: &Rows, values: f64| match rows {
            Rows::Picked { .. } => 16.0 * values,
            Rows::Filtered { .. } => 4.0 * 36.0 * values,
        };
        let surface =
            self.surface.iter().map(|s| watched(s.points.len()) + kept(&s.rows, 9.0 * s.points.len() as f64));
        let volume =
            self.volume.iter().map(|v| watched(v.points.len()) + kept(&v.rows, 9.0 * v.points.len() as f64));
        let field = self.field.iter().map(|f| {
            let local = ((order + 1) as f64).powi(self.dimension as i32);
            f.grid.points() as f64 * (92.0 * local) + kept(&f.rows, 9.0 * f.grid.points() as f64)
        });
        let outputs = surface.chain(volume).chain(field).sum::<f64>();
        solid + loads + outputs.max(spectral_bytes(self.elements() as f64, self.dimension, order))
    }

    /// Size of the run folder, bytes, while it grows: nothing is compressed then.
    pub fn disk(&self) -> f64 {
        let row = |points: usize, motions: usize| 12.0 * (points * motions) as f64 + 16.0;
        let rows = |r: &Rows| r.count(&self.sampling) as f64;
        let stations = (21 * self.sensors.len() + 2) as f64 * 8.0 * self.sampling.samples as f64;
        let cells =
            |c: &crate::outputs::wave::Cells| 4.0 * c.corners.len() as f64 + 24.0 * c.points.len() as f64;
        let surface = self.surface.iter().filter(|s| !s.motions.is_empty());
        let surface = surface.map(|s| rows(&s.rows) * row(s.points.len(), s.motions.len()) + cells(&s.cells));
        let volume = self.volume.iter();
        let volume = volume.map(|v| rows(&v.rows) * row(v.points.len(), v.motions.len()) + cells(&v.cells));
        let field = self.field.iter().map(|f| rows(&f.rows) * row(f.grid.points(), f.motions.len()));
        let number = if self.precision == Precision::F64 { 8.0 } else { 4.0 };
        let state = 2.0 * number * 6.5 * self.points() as f64;
        stations + surface.chain(volume).chain(field).sum::<f64>() + state + 4e6
    }

    /// Estimated time of the loop, s: at the speed of the stored bench ([`speed`]), whatever this machine is.
    ///
    /// Deformed elements and damping cost what they cost there (the arms' part in proportion to its three), and each further thread
    /// gains what its second one did.
    pub fn seconds(&self) -> f64 {
        let s = speed();
        let double = usize::from(self.precision == Precision::F64);
        let cost = |threads: usize| {
            let of = |deformed: usize| {
                let [elastic, viscous] = s.ns_per_point[deformed][double][threads];
                let share = match self.arms_per_point() {
                    0 => 0.0,
                    arms => LOSSES + (1.0 - LOSSES) * arms as f64 / s.arms,
                };
                elastic + (viscous - elastic) * share
            };
            let [affine, straight, stored] = self.metrics.map(|n| n as f64);
            (affine * of(0) + (straight + stored) * of(1)) / (affine + straight + stored).max(1.0)
        };
        let gain = (cost(0) / cost(1) - 1.0).clamp(0.0, 1.0);
        let threads = 1.0 + gain * (self.threads.max(1) - 1) as f64;
        1e-9 * cost(0) * self.points() as f64 * self.sampling.steps() as f64 / threads
    }

    /// Refuses a run that does not fit into the memory that is free.
    ///
    /// # Errors
    /// That.
    pub fn check_memory(&self) -> Result<(), PlanError> {
        let Some(available) = available_memory() else { return Ok(()) };
        let needed = self.memory();
        if needed <= available {
            return Ok(());
        }
        Err(PlanError::MemoryOfElements {
            needed_mb: needed / 1e6,
            available_mb: available / 1e6,
            elements: self.elements() as f64,
            order: self.resolution.order,
            help: "give fewer points of output, or a coarser or smaller ground".into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stored_bench_gives_every_speed() {
        let s = speed();
        assert!(s.from.contains("throughput-") && s.from.contains("EPYC"), "{}", s.from);
        for [one, two] in s.ns_per_point.iter().flatten() {
            for law in 0..2 {
                assert!(one[law] > 1.0 && one[law] < 200.0, "{s:?}");
                assert!(one[law] > 1.3 * two[law] && one[law] < 2.2 * two[law], "two threads gain: {s:?}");
            }
            assert!(one[1] > one[0], "damping costs: {s:?}");
        }
        assert_eq!(s.ns_per_point[1][1][0][0], 23.08, "deformed, f64, one thread, elastic");
    }
}
