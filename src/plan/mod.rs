//! The plan: every size of a run, chosen or given, with the reason.

mod sizing;

pub use sizing::{Candidate, Control, Fixed, STEP_MARGIN, Search, Sizer, Weight, fit_arms, substeps_for};

use crate::motion_input::{MotionInput, active_axes};
use crate::results::AXES;
use crate::spectrum::band_spectrum;
use hati_inputs::InputError;
use hati_inputs::motion::{Step, usable_band};
use hati_inputs::scene::{Auto, Band, FieldSpacing, MotionKind, Resolved, Scene, Station};
use hati_sem::SemError;
use hati_sem::attenuation::MaxwellArms;
use hati_sem::column::{Discretisation, Element};
use hati_sem::soil::{Base, Layer, Profile};
use num_complex::Complex64;
use serde::Serialize;
use serde_json::{Value, json};

/// What keeps a scene from being planned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// From the motion.
    #[error(transparent)]
    Input(#[from] InputError),
    /// From the column.
    #[error(transparent)]
    Sem(#[from] SemError),
    /// From the step.
    #[error(transparent)]
    Coupling(#[from] hati_coupling::CouplingError),
    /// The given step is too long.
    #[error(
        "discretisation.dt = {dt:.4e} s is unstable: the critical step is {dt_critical:.4e} s, bounded by layer `{layer}` (element of {height:.3} m at {top:.2} m depth)\n  help: give dt ≤ {safe:.3e} s, or leave it to \"auto\""
    )]
    UnstableStep {
        /// Step that results from the scene, s.
        dt: f64,
        /// Critical step, s.
        dt_critical: f64,
        /// Layer that bounds it.
        layer: String,
        /// Element's height, m.
        height: f64,
        /// Depth of its top, m.
        top: f64,
        /// A step with margin, s.
        safe: f64,
    },
    /// The band holds no energy or no frequency.
    #[error(
        "motion.band = {f_min:.4}–{f_max:.4} Hz holds nothing of the motion: {why}\n  help: give motion.band = [f_min, f_max] inside 0–{nyquist} Hz, or \"auto\""
    )]
    Band {
        /// Lower end, Hz.
        f_min: f64,
        /// Upper end, Hz.
        f_max: f64,
        /// Nyquist frequency of the motion, Hz.
        nyquist: f64,
        /// What is wrong.
        why: String,
    },
    /// The search had nothing to choose from.
    #[error("no discretisation could be formed: check discretisation.order and discretisation.elements")]
    NoCandidate,
}

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
    /// Stations.
    pub stations: Vec<Station>,
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
        Self::with_input(scene, MotionInput::read(scene)?)
    }

    /// Decides everything for a motion already read.
    pub fn with_input(scene: &Scene, input: MotionInput) -> Result<Self, PlanError> {
        let mut notes = Notes::default();
        let axes = active_axes(scene);
        let sample_dt = input.motion.dt;
        let band = choose_band(scene, &input, &mut notes)?;
        let profile = profile(scene, band, &mut notes);
        let control = match scene.motion.kind {
            MotionKind::Outcrop => Control::Outcrop,
            MotionKind::Within => Control::Within,
            MotionKind::Surface => Control::Surface,
        };
        let imposed = control == Control::Within || profile.base == Base::Rigid;
        let column = Profile { base: if imposed { Base::Rigid } else { profile.base }, ..profile.clone() };
        let (lead, tail) = lead_and_tail(scene, &profile, &column, control, &axes, sample_dt, &mut notes);
        let input = extend(input, band, lead, tail, scene)?;
        let samples = input.motion.len();
        let stations = scene.stations();
        let sizer = sizer(&column, control, &input, &axes, band, &stations, samples)?;
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
            stations,
            field_depths,
            search,
            accuracy: scene.accuracy,
            reasons: vec![],
            resolved: vec![],
            warnings: vec![],
        };
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
            &self.stations,
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

    /// Elapsed time of the first sample, s.
    pub fn time_first(&self) -> f64 {
        -(self.lead as f64) * self.sample_dt
    }

    fn explain(&mut self, scene: &Scene, mut notes: Notes) {
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
                "{} steps per sample; critical step {:.4e} s, bounded by layer `{layer}` ({:.3} m elements); time error {time:.1e}",
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
            notes.warnings.push(format!(
                "predicted error {:.2e} is above the accuracy asked ({:.2e}): the fixed values of [discretisation] do not allow better",
                c.error, self.accuracy
            ));
        }
        notes.warnings.extend(self.input.warnings.iter().cloned());
        (self.reasons, self.resolved, self.warnings) = (notes.reasons, notes.resolved, notes.warnings);
    }

    fn verdict(&self) -> String {
        let c = &self.search.chosen;
        if self.search.coarsest && c.error < 0.1 * self.accuracy {
            "the coarsest model that layers, record and stability permit is already better than asked".into()
        } else if !self.search.met {
            "not reached with the values that the scene fixes".into()
        } else {
            let [space, fit, time] = self.search.parts;
            format!(
                "relative L2 of acceleration at the worst station, in the band: space {space:.1e}, damping fit {fit:.1e}, time {time:.1e}"
            )
        }
    }

    /// The plan as JSON.
    pub fn to_json(&self) -> Value {
        let layer = &self.profile.layers[self.limiting.layer].name;
        let bytes = self.points() * self.axes.len() * 8 * (8 + 2 * self.mechanisms)
            + self.samples * 8 * self.axes.len() * (3 * self.stations.len() + self.substeps);
        let disk = self.samples * self.axes.len() * (24 * self.stations.len() + 8 * self.field_depths.len());
        json!({
            "accuracy": { "asked": self.accuracy, "predicted": self.search.chosen.error,
                "space": self.search.parts[0], "damping_fit": self.search.parts[1], "time": self.search.parts[2],
                "met": self.search.met, "coarsest": self.search.coarsest },
            "model": self.model_json(),
            "limits": { "dt_critical": self.dt_critical, "layer": layer, "depth": self.limiting.top, "height": self.limiting.height },
            "cost": { "solver_s": self.search.chosen.cost, "memory_bytes": bytes, "disk_bytes": disk },
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
        self.reasons.push(Reason { key: key.into(), value, why });
    }
}

fn choose_band(scene: &Scene, input: &MotionInput, notes: &mut Notes) -> Result<(f64, f64), PlanError> {
    let dt = input.motion.dt;
    let nyquist = 0.5 / dt;
    let lowest = 1.0 / (input.motion.len() as f64 * dt);
    let (f_min, f_max, why) = match scene.motion.band {
        Band::Range([a, b]) => (a, b, "user".to_string()),
        Band::Full => (
            lowest,
            nyquist,
            "user: all that the record holds, from one period in its length to Nyquist".into(),
        ),
        Band::Auto => {
            let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
            for a in input.motion.components.iter().flatten() {
                let (f0, f1) = usable_band(a, dt, scene.accuracy);
                (low, high) = (low.min(f0), high.max(f1));
            }
            (
                low,
                high,
                format!(
                    "outside lies less than (accuracy/2)² = {:.1e} of the energy of the acceleration",
                    0.25 * scene.accuracy.powi(2)
                ),
            )
        }
    };
    let bad = |why: &str| Err(PlanError::Band { f_min, f_max, nyquist, why: why.into() });
    if f_max > nyquist * (1.0 + 1e-9) {
        return bad("it ends above the Nyquist frequency of the motion");
    }
    if f_min >= f_max {
        return bad("its lower end is not below its upper end");
    }
    let auto = scene.motion.band == Band::Auto;
    notes.add(
        "motion.band",
        format!("{f_min:.4}–{f_max:.3} Hz"),
        auto,
        if auto { format!("auto: {why}") } else { why },
        json!([f_min, f_max]),
    );
    Ok((f_min, f_max))
}

fn profile(scene: &Scene, band: (f64, f64), notes: &mut Notes) -> Profile {
    let auto = scene.soil.reference_frequency;
    let reference_frequency = auto.value().copied().unwrap_or_else(|| (band.0 * band.1).sqrt());
    let why = if auto.is_auto() { "auto: geometric mean of the band" } else { "user" };
    notes.add(
        "soil.reference_frequency",
        format!("{reference_frequency:.4} Hz"),
        auto.is_auto(),
        why.into(),
        json!(reference_frequency),
    );
    let layers = (scene.layers().into_iter())
        .map(|l| Layer {
            name: l.name,
            thickness: l.thickness,
            vs: l.vs,
            vp: l.vp,
            rho: l.rho,
            damping_s: l.damping,
            damping_p: l.damping_p,
        })
        .collect();
    let base = scene.soil.base.half_space().map_or(Base::Rigid, |h| Base::Elastic {
        vs: h.vs,
        vp: h.vp,
        rho: h.rho,
    });
    Profile { layers, base, reference_frequency }
}

/// Time before the record that a deconvolved motion needs, and free vibration after it, in samples.
fn lead_and_tail(
    scene: &Scene,
    profile: &Profile,
    column: &Profile,
    control: Control,
    axes: &[usize],
    dt: f64,
    notes: &mut Notes,
) -> (usize, usize) {
    let travel = axes.iter().map(|&a| profile.travel_time(a)).fold(0.0, f64::max);
    let lead = if control == Control::Surface { 1.0 + 2.0 * travel } else { 0.0 };
    let auto = scene.discretisation.tail;
    let tail = auto.value().copied().unwrap_or_else(|| {
        axes.iter()
            .map(|&a| decay_time(column, a, 0.1 * scene.accuracy))
            .fold(0.0, f64::max)
            .clamp(1.0, TAIL_MAX)
    });
    let why = if auto.is_auto() {
        format!("auto: free vibration decays to {:.0e} (at most {TAIL_MAX} s)", 0.1 * scene.accuracy)
    } else {
        "user".into()
    };
    notes.add("discretisation.tail", format!("{tail:.2} s"), auto.is_auto(), why, json!(tail));
    if auto.is_auto() && tail >= TAIL_MAX {
        notes.warnings.push(format!("free vibration outlasts the {TAIL_MAX} s computed after the record: transfer functions from the run ring; give discretisation.tail to compute more"));
    }
    if lead > 0.0 {
        notes.reasons.push(Reason {
            key: "lead-in".into(),
            value: format!("{lead:.2} s"),
            why: format!("the waves behind a surface motion start {travel:.2} s earlier at the base"),
        });
    }
    ((lead / dt).ceil() as usize, (tail / dt).ceil() as usize)
}

/// Longest automatic tail, s.
const TAIL_MAX: f64 = 30.0;

/// Time in which a column's free vibration falls to `level`: one round trip loses what the base lets
/// out and what a quarter-wave mode's damping takes.
fn decay_time(column: &Profile, axis: usize, level: f64) -> f64 {
    let travel = column.travel_time(axis);
    let mean = |value: &dyn Fn(&Layer) -> f64| {
        column.layers.iter().map(|l| value(l) * l.thickness / l.speed(axis)).sum::<f64>() / travel
    };
    let impedance = mean(&|l| l.rho * l.speed(axis));
    let damping = mean(&|l| l.damping(axis));
    let reflection = match column.base.impedance(axis) {
        Some(z) => ((z - impedance) / (z + impedance)).abs().max(1e-3),
        None => 1.0,
    };
    let loss = -(reflection.ln()) + std::f64::consts::PI * damping;
    if loss <= 0.0 { f64::INFINITY } else { -2.0 * travel * level.ln() / loss }
}

fn extend(
    mut input: MotionInput,
    band: (f64, f64),
    lead: usize,
    tail: usize,
    scene: &Scene,
) -> Result<MotionInput, PlanError> {
    let motion = &mut input.motion;
    let nyquist = 0.5 / motion.dt;
    for component in motion.components.iter_mut().flatten() {
        let mut extended = vec![0.0; lead];
        extended.append(component);
        extended.resize(extended.len() + tail, 0.0);
        *component = extended;
    }
    if let Some(start) = &mut motion.start {
        *start -= lead as f64 * motion.dt;
    }
    let parameters = json!({ "before_s": lead as f64 * motion.dt, "after_s": tail as f64 * motion.dt });
    motion.steps.push(Step::new("zero padding", parameters));
    if scene.motion.band != Band::Full {
        motion.band(band.0, band.1.min(nyquist))?;
    }
    Ok(input)
}

fn sizer<'a>(
    column: &'a Profile,
    control: Control,
    input: &MotionInput,
    axes: &[usize],
    band: (f64, f64),
    stations: &[Station],
    samples: usize,
) -> Result<Sizer<'a>, PlanError> {
    let dt = input.motion.dt;
    let mut frequencies = vec![];
    let mut weights = vec![];
    for &axis in axes {
        let a = input.motion.components[axis].as_deref().unwrap_or(&[]);
        let (f, power) = band_power(a, dt, band);
        frequencies = f;
        weights.push(Weight { axis, power });
    }
    if frequencies.is_empty() {
        return Err(PlanError::Band {
            f_min: band.0,
            f_max: band.1,
            nyquist: 0.5 / dt,
            why: "no frequency of the record falls into it".into(),
        });
    }
    Ok(Sizer {
        profile: column,
        control,
        frequencies,
        weights,
        stations: stations.iter().map(|s| s.depth).collect(),
        band,
        record_dt: dt,
        samples,
    })
}

/// Most frequencies that the sizing looks at.
const FREQUENCIES_MAX: usize = 1200;

/// $|A|^2$ in the band on at most [`FREQUENCIES_MAX`] frequencies, neighbouring bins added up.
fn band_power(a: &[f64], dt: f64, band: (f64, f64)) -> (Vec<f64>, Vec<f64>) {
    let (frequency, spectrum) = band_spectrum(a, dt, band);
    let group = frequency.len().div_ceil(FREQUENCIES_MAX).max(1);
    let power = |bins: &[Complex64]| bins.iter().map(|s| s.norm_sqr()).sum::<f64>();
    (frequency.chunks(group).zip(spectrum.chunks(group)))
        .map(|(f, s)| (0.5 * (f[0] + f[f.len() - 1]), power(s)))
        .unzip()
}

fn fixed(scene: &Scene, sample_dt: f64) -> Fixed {
    let d = &scene.discretisation;
    Fixed {
        order: d.order.value().copied(),
        elements: match &d.elements {
            Auto::Value(e) => Some(e.clone()),
            Auto::Auto => None,
        },
        substeps: d.dt.value().map(|dt| ((sample_dt / dt * (1.0 - 1e-9)).ceil() as usize).max(1)),
        mechanisms: d.mechanisms.value().copied(),
    }
}

fn field_depths(
    scene: &Scene,
    column: &Profile,
    band: (f64, f64),
    axes: &[usize],
    notes: &mut Notes,
) -> Vec<f64> {
    let depth = column.depth();
    let (spacing, auto, why) = match scene.output.field_spacing {
        FieldSpacing::None => return vec![],
        FieldSpacing::Metres(h) => (h.min(depth), false, "user".to_string()),
        FieldSpacing::Auto => {
            let shortest = axes
                .iter()
                .flat_map(|&a| column.layers.iter().map(move |l| l.speed(a) / band.1))
                .fold(f64::INFINITY, f64::min);
            let wanted = (shortest / 8.0).clamp(depth / 200.0, depth / 20.0);
            (
                round_125(wanted),
                true,
                "auto: about 8 points in the shortest wavelength, 20 to 200 over the column".into(),
            )
        }
    };
    let count = (depth / spacing * (1.0 + 1e-12)).floor() as usize;
    notes.add("output.field_spacing", format!("{spacing} m"), auto, why, json!(spacing));
    (0..=count).map(|i| i as f64 * spacing).collect()
}

/// Largest of 1, 2, 2.5, 5 × 10ⁿ that does not exceed x.
fn round_125(x: f64) -> f64 {
    let decade = 10f64.powf(x.log10().floor());
    let digit = [5.0, 2.5, 2.0, 1.0].into_iter().find(|d| d * decade <= x * (1.0 + 1e-12)).unwrap_or(1.0);
    // through text, so that 0.2 is 0.2 and not 0.2000…01
    format!("{:.12}", digit * decade).trim_end_matches('0').parse().unwrap_or(digit * decade)
}
