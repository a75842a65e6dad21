//! The plan: every size of a run, chosen or given, with the reason.

mod error;
mod explain;
mod preparation;
mod sizing;

pub use error::PlanError;
pub(crate) use explain::available_memory;
pub use sizing::{Candidate, Control, Fixed, STEP_MARGIN, Search, Sizer, Weight, fit_arms, substeps_for};

use crate::motion_input::{MotionInput, active_axes};
use hati_inputs::scene::{MotionKind, Resolved, Scene, Station};
use hati_sem::attenuation::{MaxwellArms, ModulusLaw};
use hati_sem::column::{Discretisation, Element, FrequencyResponse, TimeSymbol};
use hati_sem::soil::{Base, Profile};
use preparation::{
    choose_band, extend, field_depths, fixed, lead_and_tail, places, profile, sizer, warn_of_drift,
};
use serde::Serialize;
use serde_json::Value;

/// A key of the scene, what it became and why.
#[derive(Debug, Clone, Serialize)]
pub struct Reason {
    /// Key of the scene file.
    pub key: String,
    /// Value as text.
    pub value: String,
    /// Who chose it and why.
    pub why: String,
}

/// Everything that a run needs, decided.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The motion: acceleration, scaled, led in, with its tail, limited to the band.
    pub input: MotionInput,
    /// Active components.
    pub axes: Vec<usize>,
    /// Control motion.
    pub control: Control,
    /// The profile as given, with its half-space.
    pub profile: Profile,
    /// The profile as it runs: rigid base where the base's motion is imposed.
    pub column: Profile,
    /// Band, Hz.
    pub band: (f64, f64),
    /// Order and elements.
    pub discretisation: Discretisation,
    /// Memory variables of each layer and component.
    pub arms: Vec<[MaxwellArms; 3]>,
    /// Mechanisms per layer; 0 for an elastic column.
    pub mechanisms: usize,
    /// Step of motion and outputs, s.
    pub sample_dt: f64,
    /// Steps per sample.
    pub substeps: usize,
    /// Critical step, s.
    pub dt_critical: f64,
    /// Element that bounds it.
    pub limiting: Element,
    /// Samples before the record's first.
    pub lead: usize,
    /// Samples in all.
    pub samples: usize,
    /// Places whose motion is recorded: the scene's stations, the surface, the base.
    pub places: Vec<Station>,
    /// How many of them (the first ones) the accuracy is for: all but a base that the scene does not name.
    pub sized: usize,
    /// Largest factor by which deconvolution raises a frequency of the band; 1 without.
    pub amplification: f64,
    /// Depths of the field, m; empty for none.
    pub field_depths: Vec<f64>,
    /// The search's outcome.
    pub search: Search,
    /// Accuracy asked for.
    pub accuracy: f64,
    /// Values with their reasons, for the user.
    pub reasons: Vec<Reason>,
    /// Values for `scene.resolved.toml`.
    pub resolved: Vec<Resolved>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Share of the asked accuracy that the predicted error may use.
const TARGET_SHARE: f64 = 0.85;

impl Plan {
    /// Reads the motion and decides everything.
    pub fn new(scene: &Scene) -> Result<Self, PlanError> {
        if scene.domain.is_some() {
            return Err(PlanError::NotBuilt { dimension: scene.dimension() });
        }
        Self::with_input(scene, MotionInput::read(scene)?)
    }

    /// Decides everything for a motion already read.
    pub fn with_input(scene: &Scene, input: MotionInput) -> Result<Self, PlanError> {
        let mut notes = Notes::default();
        let axes = active_axes(scene);
        let sample_dt = input.motion.dt;
        let band = choose_band(scene, &input, &mut notes)?;
        let profile = profile(scene, &input, band, &mut notes);
        let control = match scene.motion().kind {
            MotionKind::Outcrop => Control::Outcrop,
            MotionKind::Within => Control::Within,
            MotionKind::Surface => Control::Surface,
        };
        let imposed = control == Control::Within || profile.base == Base::Rigid;
        let column = Profile { base: if imposed { Base::Rigid } else { profile.base }, ..profile.clone() };
        let (lead, tail) = lead_and_tail(scene, &profile, &column, control, &input, band, &mut notes);
        let input = extend(input, band, lead, tail, scene)?;
        let samples = input.motion.len();
        let (places, sized) = places(scene);
        let sizer = sizer(&column, control, &input, &axes, band, &places[..sized], samples)?;
        let fixed = fixed(scene, sample_dt);
        let mut search = sizer.search(TARGET_SHARE * scene.accuracy, &fixed)?;
        // the search keeps a reserve; the verdict is against what was asked
        search.met |= search.chosen.error <= scene.accuracy;
        let chosen = search.chosen.clone();
        let arms = sizer.arms(chosen.mechanisms)?;
        let (dt_critical, limiting) = sizer.critical_step(&chosen.discretisation, &arms)?;
        let dt = sample_dt / chosen.substeps as f64;
        // a given step above the sample's is cut to it, but judged as it was given
        let given = scene.discretisation.dt.value().copied().unwrap_or(dt).max(dt);
        if given > dt_critical {
            return Err(PlanError::UnstableStep {
                dt: given,
                dt_critical,
                layer: profile.layers[limiting.layer].name.clone(),
                height: limiting.height,
                top: limiting.top,
                safe: STEP_MARGIN * dt_critical,
            });
        }
        let field_depths = field_depths(scene, &column, band, &axes, &mut notes);
        warn_of_drift(&input, &mut notes);
        let mut plan = Self {
            input,
            axes,
            control,
            profile,
            column,
            band,
            discretisation: chosen.discretisation,
            arms,
            mechanisms: chosen.mechanisms,
            sample_dt,
            substeps: chosen.substeps,
            dt_critical,
            limiting,
            lead,
            samples,
            places,
            sized,
            amplification: 1.0,
            field_depths,
            search,
            accuracy: scene.accuracy,
            reasons: vec![],
            resolved: vec![],
            warnings: vec![],
        };
        plan.check_deconvolution(&mut notes)?;
        plan.explain(scene, notes);
        Ok(plan)
    }

    /// The same scene and motion with another target and other fixed sizes.
    pub fn replanned(&self, target: f64, fixed: &Fixed) -> Result<Self, PlanError> {
        let sizer = sizer(
            &self.column,
            self.control,
            &self.input,
            &self.axes,
            self.band,
            &self.places[..self.sized],
            self.samples,
        )?;
        let search = sizer.search(target, fixed)?;
        let arms = sizer.arms(search.chosen.mechanisms)?;
        let (dt_critical, limiting) = sizer.critical_step(&search.chosen.discretisation, &arms)?;
        Ok(Self {
            discretisation: search.chosen.discretisation.clone(),
            mechanisms: search.chosen.mechanisms,
            substeps: search.chosen.substeps,
            arms,
            dt_critical,
            limiting,
            search,
            ..self.clone()
        })
    }

    /// Step of the solver, s.
    pub fn dt(&self) -> f64 {
        self.sample_dt / self.substeps as f64
    }

    /// Number of solver steps.
    pub fn steps(&self) -> usize {
        (self.samples - 1) * self.substeps + 1
    }

    /// Points of the column.
    pub fn points(&self) -> usize {
        self.discretisation.elements.iter().sum::<usize>() * self.discretisation.order + 1
    }

    /// Whether the base's motion is imposed.
    pub fn imposed(&self) -> bool {
        self.column.base == Base::Rigid
    }

    /// Frequency response of the column exactly as it will run, for one component.
    pub fn response(&self, axis: usize, depths: &[f64]) -> Result<FrequencyResponse, PlanError> {
        let laws: Vec<ModulusLaw> = self.arms.iter().map(|a| ModulusLaw::Maxwell(a[axis].clone())).collect();
        let symbol = TimeSymbol::CentralDifference(self.dt());
        Ok(FrequencyResponse::new(&self.column, &self.discretisation, axis, &laws, symbol, depths)?)
    }

    /// Elapsed time of the first sample, s.
    pub fn time_first(&self) -> f64 {
        -(self.lead as f64) * self.sample_dt
    }
}

#[derive(Default)]
struct Notes {
    reasons: Vec<Reason>,
    resolved: Vec<Resolved>,
    warnings: Vec<String>,
}

impl Notes {
    fn add(&mut self, key: &str, value: String, auto: bool, why: String, resolved: Value) {
        if auto && let Ok(value) = toml::Value::try_from(&resolved) {
            let why = why.trim_start_matches("auto: ").to_string();
            self.resolved.push(Resolved { key: key.into(), value, why });
        }
        self.remark(key, value, why);
    }

    fn remark(&mut self, key: &str, value: String, why: String) {
        self.reasons.push(Reason { key: key.into(), value, why });
    }
}
