//! The plan in words and as JSON; memory, disk and time.

use super::mesh::BoxSizes;
use super::plan::{Limiting, VolumePlan};
use super::sampling::Rows;
use super::sizes::SHARE;
use crate::plan::{PlanError, Reason, available_memory};
use hati_inputs::scene::{Precision, Resolved, Scene};
use serde_json::{Value, json};
use std::fmt;

/// Nanoseconds per point and step on one thread: elastic ground of affine elements in f32; `make bench` (32³ elements of
/// order 4, whole loop) gives 1.0 M element-steps/s at 64 points an element.
const NS_PER_POINT: f64 = 16.0;
/// What deformed elements and f64 cost more, and each arm, as a share of it.
const DEFORMED: f64 = 1.3;
const DOUBLE: f64 = 1.7;
const ARM: f64 = 0.4;
/// Share of each further thread that is gained.
const THREAD: f64 = 0.9;
/// Vectors of f64 of the whole ground that the spectral bound holds at once: three of the basis, masses and their roots,
/// the two of a product, that product's copy, and the points' places (two words of three).
const LANCZOS_VECTORS: f64 = 8.7;
/// Where the ground has few freedoms all vectors are kept, some tens of them.
const LANCZOS_KEPT: f64 = 100.0;
const LANCZOS_FEW: f64 = 20_000.0;
/// Points per shear wavelength below which a material is called coarse.
const COARSE: f64 = 0.95;

/// Words gathered while planning.
#[derive(Debug, Default)]
pub(super) struct Notes {
    pub(super) warnings: Vec<String>,
    pub(super) remarks: Vec<String>,
    /// Sources' names, and what is worth knowing of them.
    pub(super) sources: Vec<(String, String)>,
    /// Relative tolerance that the critical step was found to.
    pub(super) step_tolerance: f64,
}

/// What the plan itself does not keep.
pub(super) struct Facts {
    pub(super) points_why: String,
    pub(super) sizes: Option<BoxSizes>,
    pub(super) time: f64,
}

/// Coordinates in words.
pub(super) fn place(x: [f64; 3], dimension: usize) -> String {
    let number = |v: f64| format!("{:.4}", if v.abs() < 5e-5 { 0.0 } else { v });
    let trimmed = |v: f64| number(v).trim_end_matches('0').trim_end_matches('.').to_owned();
    match dimension {
        2 => format!("x = {} m, z = {} m", trimmed(x[0]), trimmed(x[2])),
        _ => format!("x = {} m, y = {} m, z = {} m", trimmed(x[0]), trimmed(x[1]), trimmed(x[2])),
    }
}

impl fmt::Display for Limiting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.centre;
        let Self { material, size, element, .. } = self;
        write!(f, "element {element}")?;
        if let Some(tag) = self.tag {
            write!(f, " (tag {tag})")?;
        }
        write!(f, " of `{material}`, {size:.4} m across, around ({x:.3}, {y:.3}, {z:.3}) m")
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
    /// Writes down every choice with its reason.
    pub(super) fn explain(&mut self, scene: &Scene, facts: &Facts, notes: Notes) {
        let mut told = Told::default();
        self.explain_sizes(scene, facts, &mut told);
        self.explain_step(scene, &notes, &mut told);
        self.explain_outputs(scene, &mut told);
        self.warnings.extend(notes.warnings);
        self.warnings.extend(self.file.iter().flat_map(|f| f.notes.iter().cloned()));
        for (name, remark) in notes.sources {
            told.remark("source", name, remark);
        }
        notes.remarks.into_iter().for_each(|r| told.remark("output.stations", String::new(), r));
        self.warn(facts);
        (self.reasons, self.resolved) = (told.reasons, told.resolved);
    }

    fn explain_sizes(&self, scene: &Scene, facts: &Facts, told: &mut Told) {
        let d = &scene.discretisation;
        let f = &self.frequencies;
        let why = format!("above it the sources' amplitude is below {:.0e} of its peak", scene.accuracy);
        told.add(
            "discretisation.f_max",
            format!("{:.4} Hz", f.f_max),
            d.f_max.is_auto(),
            &why,
            json!(f.f_max),
        );
        let order = self.resolution.order;
        let why = "waves of 1e-2 to 1e-3 cost least near this order";
        told.add("discretisation.order", order.to_string(), d.order.is_auto(), why, json!(order));
        let points = self.resolution.points_per_wavelength;
        let why = facts.points_why.trim_start_matches("auto: ").to_owned();
        let auto = d.points_per_wavelength.is_auto();
        told.add("discretisation.points_per_wavelength", format!("{points:.2}"), auto, &why, json!(points));
        if let Some(sizes) = &facts.sizes {
            let counts: Vec<usize> = sizes.layers.iter().map(|l| l.elements).collect();
            let why = "no higher than the layer's shear wave allows";
            told.add(
                "discretisation.elements",
                format!("{counts:?}"),
                d.elements.is_auto(),
                why,
                json!(counts),
            );
            let why = format!(
                "what the slowest layer's shear wave allows; {:?} elements along x, y, z",
                sizes.counts
            );
            let width = sizes.width;
            told.add(
                "discretisation.element_size",
                format!("{width:.4} m"),
                d.element_size.is_auto(),
                &why,
                json!(width),
            );
        }
        if let Some(file) = &self.file {
            let words = format!("{} ({} elements)", file.path.display(), self.elements());
            let why = if file.scripted { "made by Gmsh from the script of the scene" } else { "user" };
            told.remark("domain.mesh", words, why.into());
        }
        let (count, error) = self.mechanisms;
        if count > 0 {
            let why = format!("the modulus is within {error:.1e} of the causal law over the band");
            told.add(
                "discretisation.mechanisms",
                count.to_string(),
                d.mechanisms.is_auto(),
                &why,
                json!(count),
            );
            let why = "geometric mean of the damping's band";
            let auto = scene.soil.reference_frequency.is_auto();
            told.add(
                "soil.reference_frequency",
                format!("{:.4} Hz", f.reference),
                auto,
                why,
                json!(f.reference),
            );
        }
        let word = if self.precision == Precision::F32 { "f32" } else { "f64" };
        let why = "half the memory and up to twice the speed; seven digits";
        told.add("discretisation.precision", word.into(), d.precision.is_auto(), why, json!(word));
    }

    fn explain_step(&self, scene: &Scene, notes: &Notes, told: &mut Told) {
        let s = &self.sampling;
        let share = s.dt / self.dt_critical;
        let why = format!(
            "{:.2} of the critical step {:.4e} s (found to {:.0e}), bounded by {}; phase error at most {:.1e}",
            share,
            self.dt_critical,
            notes.step_tolerance,
            self.limiting,
            SHARE * self.accuracy
        );
        let auto = scene.discretisation.dt.is_auto();
        told.add("discretisation.dt", format!("{:.6e} s", s.dt), auto, &why, json!(s.dt));
        if !auto && let Some(reason) = told.reasons.last_mut() {
            reason.why = format!("user: {}", why.split("; phase").next().unwrap_or_default());
        }
        let words = format!("{:.6e} s", s.sample_dt());
        let why = format!(
            "{} samples of stations and peaks, every {} steps: 20 per shortest period",
            s.samples, s.stride
        );
        told.remark("samples", words, why);
    }

    fn explain_outputs(&self, scene: &Scene, told: &mut Told) {
        let output = &scene.output;
        let mut rows = |key: &str, rows: &Rows, auto: bool, what: String| {
            let dt = rows.dt(&self.sampling);
            let how = match rows {
                Rows::Picked { .. } => "taken as they are, nothing faster is there".to_owned(),
                Rows::Filtered { .. } => format!(
                    "low-passed at {:.3} Hz; of the last {:.3} s rows see a motion that stands still",
                    0.5 / dt,
                    11.0 * dt
                ),
            };
            told.add(key, format!("{dt:.6e} s"), auto, &format!("{what}: {how}"), json!(dt));
        };
        if let (Some(plan), Some(asked)) = (&self.surface, &output.surface) {
            let what = format!("{} points of `{}`", plan.points.len(), plan.boundary);
            rows("output.surface.dt", &plan.rows, asked.dt.is_auto(), what);
        }
        if let (Some(plan), Some(asked)) = (&self.volume, &output.volume) {
            rows("output.volume.dt", &plan.rows, asked.dt.is_auto(), format!("{} points", plan.points.len()));
        }
        if let (Some(plan), Some(asked)) = (&self.field, &output.field) {
            rows("output.field.dt", &plan.rows, asked.dt.is_auto(), format!("{} points", plan.grid.points()));
            let spacing = plan.spacing();
            let why = "a quarter of the shortest wavelength";
            told.add(
                "output.field.spacing",
                format!("{spacing:.4} m"),
                asked.spacing.is_auto(),
                why,
                json!(spacing),
            );
        }
        let every = self.checkpoint_every.as_secs_f64();
        let auto = output.checkpoint.is_none_or(|c| c.every.is_auto());
        let why = "what a kill may cost; and at an interrupt";
        told.add("output.checkpoint.every", format!("{every} s"), auto, why, json!(every));
    }

    fn warn(&mut self, facts: &Facts) {
        let wanted = self.resolution.points_per_wavelength;
        for (name, points) in &self.reached {
            if *points < COARSE * wanted {
                self.warnings.push(format!(
                    "`{name}`: its elements give a shear wave of {:.3} Hz {points:.2} points per wavelength, and \
                     {wanted:.2} are wanted for the accuracy asked: mesh it finer, or lower discretisation.f_max",
                    self.frequencies.f_max
                ));
            }
        }
        let f = &self.frequencies;
        if f.f_max < 0.99 * f.of_sources {
            self.warnings.push(format!(
                "the sources reach {:.3} Hz, above discretisation.f_max = {:.3} Hz: what is faster is computed wrongly",
                f.of_sources, f.f_max
            ));
        }
        let allowed = super::sizes::accurate_step(self.accuracy, f, facts.time);
        if self.sampling.dt > 1.01 * allowed {
            self.warnings.push(format!(
                "the step {:.3e} s is stable, but waves of {:.3} Hz keep their phase to {:.1e} only below {allowed:.3e} s",
                self.sampling.dt, f.f_half, SHARE * self.accuracy
            ));
        }
    }

    /// Memory of a run, bytes.
    pub fn memory(&self) -> f64 {
        let (order, arms) = (self.resolution.order, self.mechanisms.0);
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

    /// Estimated time of the loop, s.
    pub fn seconds(&self) -> f64 {
        let [affine, deformed, stored] = self.metrics.map(|n| n as f64);
        let shape = (affine + DEFORMED * (deformed + stored)) / (affine + deformed + stored).max(1.0);
        let precision = if self.precision == Precision::F64 { DOUBLE } else { 1.0 };
        let factor = shape * precision * (1.0 + ARM * self.mechanisms.0 as f64);
        let threads = 1.0 + THREAD * (self.threads.max(1) - 1) as f64;
        1e-9 * NS_PER_POINT * factor * self.points() as f64 * self.sampling.steps() as f64 / threads
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

    /// The plan as JSON.
    pub fn to_json(&self) -> Value {
        json!({
            "accuracy": { "asked": self.accuracy },
            "model": self.model_json(),
            "limits": {
                "dt_critical": self.dt_critical, "element": self.limiting.element, "centre": self.limiting.centre,
                "material": self.limiting.material, "size": self.limiting.size, "tag": self.limiting.tag,
            },
            "mesh": {
                "min": self.report.min, "max": self.report.max,
                "edge_min": self.report.edge_min.value, "edge_max": self.report.edge_max.value,
                "aspect_max": self.report.aspect_max.value,
                "scaled_jacobian_min": self.report.scaled_jacobian_min.value,
                "sha256": self.file.as_ref().map(|f| f.sha256.clone()),
            },
            "points_per_wavelength": self.reached.iter().map(|(n, p)| json!({ "material": n, "points": p })).collect::<Vec<_>>(),
            "cost": { "solver_s": self.seconds(), "memory_bytes": self.memory(), "disk_bytes": self.disk() },
            "reasons": self.reasons,
            "warnings": self.warnings,
        })
    }

    /// The `model` object of plan and summary.
    pub fn model_json(&self) -> Value {
        let s = &self.sampling;
        let [affine, deformed, stored] = self.metrics;
        json!({
            "dimension": self.dimension, "order": self.resolution.order,
            "elements": self.elements(), "points": self.points(),
            "metric": { "affine": affine, "from_corners": deformed, "stored": stored },
            "precision": if self.precision == Precision::F64 { "f64" } else { "f32" },
            "dt": s.dt, "steps": s.steps(), "sample_dt": s.sample_dt(), "samples": s.samples,
            "dt_critical": self.dt_critical, "limited_by": self.limiting.to_string(),
            "mechanisms": self.mechanisms.0, "f_max": self.frequencies.f_max,
            "points_per_wavelength": self.resolution.points_per_wavelength,
            "reference_frequency": self.frequencies.reference,
            "materials": self.materials,
            "duration_s": (s.samples - 1) as f64 * s.sample_dt(),
            "stations": self.sensors.len(),
        })
    }

    /// The plan as a person reads it.
    pub fn text(&self, title: &str) -> String {
        use fmt::Write as _;
        let mut text = format!("plan of “{title}”\n");
        let width = self.reasons.iter().map(|r| r.key.len()).max().unwrap_or(0);
        for r in &self.reasons {
            let _ = writeln!(text, "  {:width$}  {}\n  {:width$}    {}", r.key, r.value, "", r.why);
        }
        for (name, points) in &self.reached {
            let _ = writeln!(
                text,
                "  `{name}`: {points:.2} points per shear wavelength at {:.3} Hz",
                self.frequencies.f_max
            );
        }
        let [affine, deformed, stored] = self.metrics;
        let _ = writeln!(
            text,
            "  {} elements ({affine} affine, {deformed} with straight edges, {stored} curved), {} points × {} steps on {}: \
             about {:.1} s, {:.0} MB of memory, {:.0} MB on disk",
            self.elements(),
            self.points(),
            self.sampling.steps(),
            if self.threads == 1 { "1 thread".to_owned() } else { format!("{} threads", self.threads) },
            self.seconds(),
            (self.memory() / 1e6).max(1.0),
            (self.disk() / 1e6).max(1.0),
        );
        for w in &self.warnings {
            let _ = writeln!(text, "  warning: {w}");
        }
        text
    }
}

/// Reasons and resolved values.
#[derive(Default)]
struct Told {
    reasons: Vec<Reason>,
    resolved: Vec<Resolved>,
}

impl Told {
    fn add(&mut self, key: &str, value: String, auto: bool, why: &str, resolved: Value) {
        if auto && let Ok(value) = toml::Value::try_from(&resolved) {
            self.resolved.push(Resolved { key: key.into(), value, why: why.into() });
        }
        let why = if auto { format!("auto: {why}") } else { "user".to_owned() };
        self.remark(key, value, why);
    }

    fn remark(&mut self, key: &str, value: String, why: String) {
        self.reasons.push(Reason { key: key.into(), value, why });
    }
}
