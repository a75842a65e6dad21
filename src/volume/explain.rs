//! The plan in words and as JSON.

use super::mesh::{BoxSizes, PlannedBoundary};
use super::plan::{Limiting, Reached, VolumePlan};
use super::sampling::Rows;
use super::sizes::{Frequencies, SHARE};
use crate::plan::Reason;
use hati_inputs::scene::{BoundaryKind, MemoryVariables, Precision, Resolved, Scene};
use hati_sem::solid::coarse_error;
use serde_json::{Value, json};
use std::fmt;

/// Share of the run beyond which a filter's reach is told.
const LONG_FILTER: f64 = 0.1;
/// Share of the points wanted below which a material is called coarse.
const COARSE: f64 = 0.95;
/// Elements about a point source within which its near field is not resolved.
const NEAR: f64 = 2.0;
/// Stations that a warning names; of more it tells how many.
const NAMED: usize = 4;

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
    /// Whether all materials need the same points per wavelength.
    pub(super) points_alike: bool,
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

impl fmt::Display for PlannedBoundary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let origin = if self.given { "user" } else { "default" };
        write!(f, "`{}` {} ({origin})", self.name, self.kind.as_str())
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

impl VolumePlan {
    /// Writes down every choice with its reason.
    pub(super) fn explain(&mut self, scene: &Scene, facts: &Facts, notes: Notes) {
        let mut told = Told::default();
        self.explain_sizes(scene, facts, &mut told);
        self.explain_material(scene, facts, &mut told);
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
        let why =
            "at 1e-2 within a factor two to three of the cheapest order, and its elements fit thinner layers";
        told.add("discretisation.order", order.to_string(), d.order.is_auto(), why, json!(order));
        let points = self.resolution.points_per_wavelength;
        let (auto, key) = (d.points_per_wavelength.is_auto(), "discretisation.points_per_wavelength");
        if facts.points_alike {
            told.add(key, format!("{points:.2}"), auto, &facts.points_why, json!(points));
        } else {
            // one number of the scene file could not say it; the elements' counts and size do
            told.remark(key, format!("{points:.2}"), format!("auto: {}", facts.points_why));
        }
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
        self.explain_boundaries(told);
    }

    fn explain_material(&self, scene: &Scene, facts: &Facts, told: &mut Told) {
        let (d, f) = (&scene.discretisation, &self.frequencies);
        let (count, error) = self.mechanisms;
        if count > 0 {
            let allowed = super::sizes::modulus_error(self.accuracy, f, facts.time);
            let why = format!(
                "the modulus is within {error:.1e} of the causal law over the band; {allowed:.1e} keeps waves of {:.3} Hz \
                 for {:.3} s",
                f.f_half, facts.time
            );
            told.add(
                "discretisation.mechanisms",
                count.to_string(),
                d.mechanisms.is_auto(),
                &why,
                json!(count),
            );
            let (word, why) = (self.memory_variables.as_str(), self.spread_why());
            let auto = d.memory_variables.is_auto();
            told.add("discretisation.memory_variables", word.into(), auto, &why, json!(word));
            if !auto && let Some(reason) = told.reasons.last_mut() {
                reason.why = format!("user: {why}");
            }
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
        let why = self.rounding.why();
        told.add("discretisation.precision", word.into(), d.precision.is_auto(), &why, json!(word));
    }

    /// Every boundary with its kind; those of a mesh that the scene leaves out also go into the resolved scene.
    fn explain_boundaries(&self, told: &mut Told) {
        let why = "`top` is free, `bottom` over a rigid base fixed, every other absorbs";
        for b in self.boundaries.iter().filter(|b| !b.given && self.file.is_some()) {
            let (key, value) = (format!("domain.boundary.{}", b.name), b.kind.as_str().into());
            told.resolved.push(Resolved { key, value, why: why.into() });
        }
        let loose = self.report.unnamed_sides;
        let loose = (loose > 0).then(|| format!("{loose} sides in no group free (default)"));
        let words: Vec<String> =
            self.boundaries.iter().map(PlannedBoundary::to_string).chain(loose).collect();
        let all_given = self.boundaries.iter().all(|b| b.given);
        let why = if all_given { "user".to_owned() } else { format!("default: {why}") };
        told.remark("domain.boundary", words.join(", "), why);
    }

    /// What the spread of the memory variables means for the damping.
    fn spread_why(&self) -> String {
        if self.memory_variables == MemoryVariables::Full {
            return "every mechanism at every point".into();
        }
        let Frequencies { f_half, f_max, .. } = self.frequencies;
        let worst = |frequency: f64| {
            let of =
                |m| coarse_error(m, self.resolution.order, self.dimension, frequency).unwrap_or((0.0, 0.0));
            self.ground
                .materials()
                .iter()
                .map(of)
                .fold((0.0_f64, 0.0_f64), |a, b| (a.0.max(b.0), a.1.max(b.1)))
        };
        let ((half, _), (top, speed)) = (worst(f_half), worst(f_max));
        format!(
            "one mechanism at a point: 1/Q of long waves is off by at most {half:.1e} at {f_half:.3} Hz and {top:.1e} at \
             {f_max:.3} Hz, speeds by {speed:.1e}"
        )
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
                    "low-passed at {:.3} Hz, to be read up to {:.3} Hz, the motion goes up to {:.3} Hz; a row sees \
                     {:.3} s ahead and back, so what comes is felt before it comes, and rows of the last {:.3} s see a \
                     motion that stands still",
                    0.5 / dt,
                    0.4 / dt,
                    self.frequencies.content(),
                    rows.reach(),
                    rows.reach()
                ),
            };
            let (value, why) = (format!("{dt:.6e} s"), format!("{what}: {how}"));
            // what becomes of the motion matters whoever chose the instants
            match auto {
                true => told.add(key, value, true, &why, json!(dt)),
                false => told.remark(key, value, format!("user: {why}")),
            }
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
        for Reached { material, points, wanted } in &self.reached {
            if *points < COARSE * wanted {
                self.warnings.push(format!(
                    "`{material}`: its elements give a shear wave of {:.3} Hz {points:.2} points per wavelength, and \
                     {wanted:.2} are wanted for the accuracy asked: mesh it finer, or lower discretisation.f_max",
                    self.frequencies.f_max
                ));
            }
        }
        self.warn_of_near_fields();
        let f = &self.frequencies;
        if f.f_max < 0.99 * f.of_sources {
            self.warnings.push(format!(
                "the sources reach {:.3} Hz, above discretisation.f_max = {:.3} Hz: what is faster is computed wrongly",
                f.of_sources, f.f_max
            ));
        }
        self.warnings.extend(self.rounding.warning());
        self.warnings.extend(self.filtered());
        let free = self.boundaries.iter().any(|b| b.kind == BoundaryKind::Free);
        if self.file.is_some() && !free && self.report.unnamed_sides == 0 {
            self.warnings.push(
                "the mesh has no free boundary: name the group of its surface `top`, or give domain.boundary.NAME = \"free\""
                    .to_owned(),
            );
        }
        let (count, error) = self.mechanisms;
        let modulus = super::sizes::modulus_error(self.accuracy, f, facts.time);
        if count > 0 && error > 1.01 * modulus {
            self.warnings.push(format!(
                "{count} mechanisms keep the modulus to {error:.1e}, and waves of {:.3} Hz need {modulus:.1e} to keep phase and \
                 amplitude to {:.1e} over {:.3} s: leave discretisation.mechanisms to \"auto\", or shorten the path",
                f.f_half,
                SHARE * self.accuracy,
                facts.time
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

    /// Stations so near a point source that the element's polynomial, over which its force is spread, shows.
    fn warn_of_near_fields(&mut self) {
        let mut warnings = vec![];
        for source in &self.sources {
            let (Some(at), Some(size)) = (source.position, source.element_size) else { continue };
            let distance = |x: [f64; 3]| (0..3).map(|i| (x[i] - at[i]).powi(2)).sum::<f64>().sqrt();
            let mut near: Vec<(f64, &str)> = (self.sensors.iter())
                .map(|s| (distance(s.probe.position), s.name.as_str()))
                .filter(|(distance, _)| *distance < NEAR * size)
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some((nearest, _)) = near.first() else { continue };
            let named: Vec<String> =
                near.iter().take(NAMED).map(|(d, name)| format!("`{name}` ({d:.3} m)")).collect();
            let more = near.len().saturating_sub(NAMED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            warnings.push(format!(
                "near field of source `{}`, whose element is {size:.3} m long, is not resolved within two elements: station {}{more}; \
                 elements of {:.3} m there, or a distance of {:.3} m, would do",
                source.name,
                named.join(", "),
                nearest / NEAR,
                NEAR * size,
            ));
        }
        self.warnings.extend(warnings);
    }

    /// Files whose filter is long for the run.
    fn filtered(&self) -> Vec<String> {
        let duration = (self.sampling.samples - 1) as f64 * self.sampling.sample_dt();
        let all = [
            ("output.surface", self.surface.as_ref().filter(|s| !s.motions.is_empty()).map(|s| &s.rows)),
            ("output.volume", self.volume.as_ref().map(|v| &v.rows)),
            ("output.field", self.field.as_ref().map(|f| &f.rows)),
        ];
        let long = |(key, rows): (&str, Option<&Rows>)| {
            let reach = rows?.reach();
            (reach > LONG_FILTER * duration).then(|| {
                let dt = rows.map_or(0.0, |r| r.dt(&self.sampling));
                format!(
                    "{key}.dt = {dt:.4e} s: rows are low-passed by a filter that reaches {reach:.3} s ahead and back, {:.0} % of \
                     the run: rows before the motion are not zero, and those of the last {reach:.3} s see a standstill; give \
                     a dt of {:.3e} s or less, which needs no filter, or a longer run",
                    100.0 * reach / duration,
                    0.4 / self.frequencies.content()
                )
            })
        };
        all.into_iter().filter_map(long).collect()
    }

    /// The plan as JSON.
    pub fn to_json(&self) -> Value {
        json!({
            "accuracy": { "asked": self.accuracy, "noise_of_f32": self.rounding.single, "noise_allowed": self.rounding.allowed },
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
            "points_per_wavelength": self.reached.iter().map(|r| json!({ "material": r.material, "points": r.points, "wanted": r.wanted })).collect::<Vec<_>>(),
            "cost": { "solver_s": self.seconds(), "solver_s_from": super::cost::speed().from, "memory_bytes": self.memory(), "disk_bytes": self.disk() },
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
            "mechanisms": self.mechanisms.0, "memory_variables": self.memory_variables.as_str(), "f_max": self.frequencies.f_max,
            "points_per_wavelength": self.resolution.points_per_wavelength,
            "reference_frequency": self.frequencies.reference,
            "materials": self.materials,
            "boundaries": self.boundaries.iter().map(|b| json!({
                "name": b.name, "kind": b.kind.as_str(), "from": if b.given { "user" } else { "default" }, "sides": b.sides,
            })).collect::<Vec<_>>(),
            "sides_in_no_group": self.report.unnamed_sides,
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
        for Reached { material, points, .. } in &self.reached {
            let _ = writeln!(
                text,
                "  `{material}`: {points:.2} points per shear wavelength at {:.3} Hz",
                self.frequencies.f_max
            );
        }
        let [affine, deformed, stored] = self.metrics;
        let _ = writeln!(
            text,
            "  {} elements ({affine} affine, {deformed} with straight edges, {stored} curved), {} points × {} steps on {}: \
             about {:.1} s at the speed of {}, {:.0} MB of memory, {:.0} MB on disk",
            self.elements(),
            self.points(),
            self.sampling.steps(),
            if self.threads == 1 { "1 thread".to_owned() } else { format!("{} threads", self.threads) },
            self.seconds(),
            super::cost::speed().from,
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
