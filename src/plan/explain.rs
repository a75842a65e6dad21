//! The plan in words and as JSON, and the checks that need the whole of it.

use super::{Control, Notes, Plan, PlanError, Reason, TARGET_SHARE};
use crate::results::AXES;
use hati_inputs::scene::Scene;
use hati_sem::soil::Base;
use serde_json::{Value, json};

impl Plan {
    /// Writes down every choice with its reason.
    pub(super) fn explain(&mut self, scene: &Scene, mut notes: Notes) {
        let d = &scene.discretisation;
        let by = |auto: bool, why: String| if auto { format!("auto: {why}") } else { "user".to_string() };
        let c = &self.search.chosen;
        let [space, fit, time] = self.search.parts;
        let weighed = self.search.weighed;
        notes.add(
            "discretisation.order",
            self.discretisation.order.to_string(),
            d.order.is_auto(),
            by(
                d.order.is_auto(),
                format!(
                    "cheapest of {weighed} weighed whose predicted error stays under {:.2e}",
                    TARGET_SHARE * self.accuracy
                ),
            ),
            json!(self.discretisation.order),
        );
        notes.add(
            "discretisation.elements",
            format!("{:?}", self.discretisation.elements),
            d.elements.is_auto(),
            by(d.elements.is_auto(), format!("space error {space:.1e}; {} points", self.points())),
            json!(self.discretisation.elements),
        );
        let layer = &self.profile.layers[self.limiting.layer].name;
        notes.add("discretisation.dt", format!("{:.6e} s", self.dt()), d.dt.is_auto(), by(
            d.dt.is_auto(),
            format!(
                "steps per sample: {}; critical step {:.4e} s, bounded by layer `{layer}` ({:.3} m elements); time error {time:.1e}",
                self.substeps, self.dt_critical, self.limiting.height
            ),
        ), json!(self.dt()));
        if let Some(given) = d.dt.value().filter(|given| **given > self.dt() * (1.0 + 1e-9))
            && let Some(reason) = notes.reasons.last_mut()
        {
            reason.why = format!("user: {given:e} s, cut to a whole number of steps per sample");
        }
        let arms = if self.mechanisms == 0 {
            "no damping".to_string()
        } else {
            format!("error of the damping fit {fit:.1e}")
        };
        if self.mechanisms > 0 {
            notes.add(
                "discretisation.mechanisms",
                self.mechanisms.to_string(),
                d.mechanisms.is_auto(),
                by(d.mechanisms.is_auto(), arms),
                json!(self.mechanisms),
            );
        }
        notes.reasons.push(Reason {
            key: "accuracy".into(),
            value: format!("{:.2e} asked, {:.2e} predicted", self.accuracy, c.error),
            why: self.verdict(),
        });
        if !self.search.met {
            notes.warnings.push(self.shortfall(scene));
        }
        notes.warnings.extend(self.input.warnings.iter().cloned());
        (self.reasons, self.resolved, self.warnings) = (notes.reasons, notes.resolved, notes.warnings);
    }

    /// Why the asked accuracy is not met: the largest part and whether the scene fixes it.
    fn shortfall(&self, scene: &Scene) -> String {
        let d = &scene.discretisation;
        let parts = [
            ("space", d.order.is_auto() && d.elements.is_auto(), "discretisation.order and elements"),
            ("the damping fit", d.mechanisms.is_auto(), "discretisation.mechanisms"),
            ("time", d.dt.is_auto(), "discretisation.dt"),
        ];
        let (k, part) = (self.search.parts.iter().copied().enumerate())
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, f64::NAN));
        let (name, auto, key) = parts[k];
        let cause = if auto {
            "which is as far as the search goes; ask for less accuracy".to_string()
        } else {
            format!("which {key} as given by the scene does not allow to lower")
        };
        format!(
            "predicted error {:.2e} is above the accuracy asked ({:.2e}); the largest part is {name}, {part:.1e}, {cause}",
            self.search.chosen.error, self.accuracy
        )
    }

    fn verdict(&self) -> String {
        let c = &self.search.chosen;
        let [space, fit, time] = self.search.parts;
        if self.search.coarsest && c.error < 0.1 * self.accuracy {
            "the coarsest model that layers, record and stability permit is already better than asked".into()
        } else if !self.search.met {
            "not reached; see the warning".into()
        } else {
            format!(
                "relative L2 of acceleration at the worst station, in the band: space {space:.1e}, damping fit {fit:.1e}, time {time:.1e}"
            )
        }
    }

    /// Largest amplification of a deconvolved band that passes without a warning, and that is not refused.
    const AMPLIFICATION: (f64, f64) = (30.0, 1e8);

    /// Finds how much a surface motion has to be raised at depth, warns, and refuses what is round-off.
    pub(super) fn check_deconvolution(&mut self, notes: &mut Notes) -> Result<(), PlanError> {
        if self.control != Control::Surface {
            return Ok(());
        }
        let (f0, f1) = self.band;
        let (mut largest, mut f_safe) = (1.0_f64, f1);
        for &axis in &self.axes {
            let response = self.response(axis, &[0.0])?;
            for i in 0..=2000 {
                let f = f0 * (f1 / f0).powf(i as f64 / 2000.0);
                let t = response.at(f);
                let passed = (t.per_within[0] * t.within_per_outcrop).norm().max(f64::MIN_POSITIVE);
                if passed < 1e-3 {
                    f_safe = f_safe.min(f);
                }
                largest = largest.max(1.0 / passed);
            }
        }
        let (warned, refused) = Self::AMPLIFICATION;
        if largest > refused {
            return Err(PlanError::Deconvolution { amplification: largest, f_safe });
        }
        if largest > warned {
            notes.warnings.push(format!(
                "deconvolution raises some frequency of the band {largest:.0} times: noise of the surface record grows alike at depth; end motion.band lower"
            ));
        }
        self.amplification = largest;
        Ok(())
    }

    /// Memory of a run, bytes: base motion at the solver's step with its transforms, traces, field rows.
    pub fn memory(&self) -> f64 {
        let (samples, axes, steps) = (self.samples as f64, self.axes.len() as f64, self.steps() as f64);
        let depths = self.field_depths.len() as f64;
        let traces = 24.0 * samples * axes * (self.places.len() + 1) as f64;
        let section = 4.0 * samples.min(8000.0) * depths * axes;
        // the transform of one component stands beside what is kept of all: padded to twice, complex
        let base = 8.0 * steps * (axes + 6.0);
        let column = self.points() as f64 * axes * 8.0 * (9.0 + self.mechanisms as f64);
        base + 2.0 * traces + 2.0 * section + 56.0 * samples + column
    }

    /// Size of the run folder, bytes: stations in f64, field in f32, both about as large as uncompressed.
    pub fn disk(&self) -> f64 {
        let (samples, axes) = (self.samples as f64, self.axes.len() as f64);
        let stations = 24.0 * samples * axes * (self.places.len() + 1) as f64;
        stations + 12.0 * samples * axes * self.field_depths.len() as f64 + 64.0 * samples + 4e6 * axes
    }

    /// Estimated time of steps and samples, s.
    pub fn seconds(&self) -> f64 {
        let probes = (self.places.len() + self.field_depths.len()) * (self.discretisation.order + 1);
        let sample = 3e-9 * probes as f64 + 25e-9 * self.points() as f64;
        self.search.chosen.cost + self.samples as f64 * self.axes.len() as f64 * sample
    }

    /// Refuses a run that does not fit into the memory that is free.
    pub fn check_memory(&self) -> Result<(), PlanError> {
        let Some(available) = available_memory() else { return Ok(()) };
        let needed = self.memory();
        if needed <= available {
            return Ok(());
        }
        Err(PlanError::Memory {
            needed_mb: needed / 1e6,
            available_mb: available / 1e6,
            steps: self.steps(),
            points: self.points(),
            samples: self.samples,
        })
    }

    /// The plan as JSON.
    pub fn to_json(&self) -> Value {
        let layer = &self.profile.layers[self.limiting.layer].name;
        json!({
            "accuracy": { "asked": self.accuracy, "predicted": self.search.chosen.error,
                "space": self.search.parts[0], "damping_fit": self.search.parts[1], "time": self.search.parts[2],
                "met": self.search.met, "coarsest": self.search.coarsest },
            "model": self.model_json(),
            "limits": { "dt_critical": self.dt_critical, "layer": layer, "depth": self.limiting.top, "height": self.limiting.height },
            "cost": { "solver_s": self.seconds(), "memory_bytes": self.memory(), "disk_bytes": self.disk() },
            "reasons": self.reasons,
            "warnings": self.warnings,
        })
    }

    /// The `model` object of plan and summary.
    pub fn model_json(&self) -> Value {
        let layer = &self.profile.layers[self.limiting.layer].name;
        let impedance = |axis| self.profile.base.impedance(axis);
        json!({
            "components": self.axes.iter().map(|&a| AXES[a].to_string()).collect::<Vec<_>>(),
            "control": self.control,
            "order": self.discretisation.order, "elements": self.discretisation.elements, "points": self.points(),
            "dt": self.dt(), "substeps": self.substeps, "sample_dt": self.sample_dt, "steps": self.steps(),
            "dt_critical": self.dt_critical,
            "limited_by": format!("layer `{layer}`, elements of {:.3} m", self.limiting.height),
            "mechanisms": self.mechanisms, "band": [self.band.0, self.band.1],
            "reference_frequency": self.profile.reference_frequency,
            "base": {
                "kind": if self.profile.base == Base::Rigid { "rigid" } else if self.imposed() { "elastic, its motion imposed" } else { "elastic" },
                "impedance_s": impedance(0), "impedance_p": impedance(2),
            },
            "lead_s": self.lead as f64 * self.sample_dt, "duration_s": (self.samples - 1) as f64 * self.sample_dt,
        })
    }
}

/// Memory that is free for a new program, bytes; `None` where the system does not tell.
pub(crate) fn available_memory() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("MemAvailable:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kb| kb * 1024.0)
}
