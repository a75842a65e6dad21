//! What the search starts from: band, profile, lead-in and tail, spectral weights, depths.

use super::{Control, Fixed, Notes, PlanError, Sizer, Weight};
use crate::motion_input::MotionInput;
use crate::spectrum::band_spectrum;
use hati_inputs::motion::{Process, Quantity, Step, usable_band};
use hati_inputs::scene::{Auto, Band, FieldSpacing, Scene, Station};
use hati_sem::soil::{Base, Layer, Profile};
use num_complex::Complex64;
use serde_json::json;

/// Accuracy at which the band for the automatic reference frequency is taken. The soil's stiffness must
/// not move with the accuracy that a run asks for.
const REFERENCE_ACCURACY: f64 = 1e-2;

/// The band that holds the motion's energy to `accuracy`, over all components, Hz.
fn energy_band(input: &MotionInput, accuracy: f64) -> (f64, f64) {
    let mut band = (f64::INFINITY, 0.0_f64);
    for a in input.motion.components.iter().flatten() {
        let (low, high) = usable_band(a, input.motion.dt, accuracy);
        band = (band.0.min(low), band.1.max(high));
    }
    band
}

/// Chooses the band and checks that it holds the motion.
pub(super) fn choose_band(
    scene: &Scene,
    input: &MotionInput,
    notes: &mut Notes,
) -> Result<(f64, f64), PlanError> {
    let dt = input.motion.dt;
    let nyquist = 0.5 / dt;
    let lowest = 1.0 / (input.motion.len() as f64 * dt);
    let auto = scene.motion().band == Band::Auto;
    let ((f_min, f_max), why) = match scene.motion().band {
        Band::Range([a, b]) => ((a, b), "user".to_string()),
        Band::Full => (
            (lowest, nyquist),
            "user: all that the record holds, from one period in its length to Nyquist".into(),
        ),
        Band::Auto => {
            let lost = 0.25 * scene.accuracy.powi(2);
            let why = format!(
                "auto: outside lies less than (accuracy/2)² = {lost:.1e} of the energy of the acceleration"
            );
            (energy_band(input, scene.accuracy), why)
        }
    };
    let bad = |why: &str| Err(PlanError::Band { f_min, f_max, nyquist, why: why.into() });
    if f_max > nyquist * (1.0 + 1e-9) {
        return bad("it ends above the Nyquist frequency of the motion");
    }
    if f_min >= f_max {
        return bad("its lower end is not below its upper end");
    }
    let kept = energy_kept(input, (f_min, f_max));
    if kept < 1e-6 {
        return bad(&format!("less than 1e-6 of the energy of the acceleration lies in it ({kept:.1e})"));
    }
    if kept < 0.9 {
        notes.warnings.push(format!(
            "motion.band = {f_min:.3}–{f_max:.3} Hz keeps {:.1} % of the energy of the acceleration; the rest is filtered out",
            100.0 * kept
        ));
    }
    notes.add("motion.band", format!("{f_min:.4}–{f_max:.3} Hz"), auto, why, json!([f_min, f_max]));
    Ok((f_min, f_max))
}

/// Share of the acceleration's energy inside a band, over all components.
fn energy_kept(input: &MotionInput, band: (f64, f64)) -> f64 {
    let energy = |band| -> f64 {
        let components = input.motion.components.iter().flatten();
        components.flat_map(|a| band_spectrum(a, input.motion.dt, band).1).map(|s| s.norm_sqr()).sum()
    };
    let all = energy((0.0, f64::INFINITY));
    if all > 0.0 { energy(band) / all } else { 0.0 }
}

/// The soil profile of a scene with its reference frequency.
pub(super) fn profile(scene: &Scene, input: &MotionInput, band: (f64, f64), notes: &mut Notes) -> Profile {
    let given = scene.soil.reference_frequency;
    let (value, why) = match (given, scene.motion().band) {
        (Auto::Value(f), _) => (f, "user"),
        (Auto::Auto, Band::Auto) => {
            let (low, high) = energy_band(input, REFERENCE_ACCURACY);
            (
                (low * high).sqrt(),
                "auto: geometric mean of the band that accuracy 1e-2 would take, whatever is asked",
            )
        }
        (Auto::Auto, _) => ((band.0 * band.1).sqrt(), "auto: geometric mean of the band"),
    };
    notes.add(
        "soil.reference_frequency",
        format!("{value:.4} Hz"),
        given.is_auto(),
        why.into(),
        json!(value),
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
    let base = scene.half_space().map_or(Base::Rigid, |h| Base::Elastic { vs: h.vs, vp: h.vp, rho: h.rho });
    Profile { layers, base, reference_frequency: value }
}

/// The scene's stations with the surface and the base added where they are missing, and how many of them
/// the accuracy is for.
pub(super) fn places(scene: &Scene) -> (Vec<Station>, usize) {
    let mut places = scene.stations();
    let mut add = |name: &str, depth: f64| {
        if !places.iter().any(|p| p.name == name) {
            places.push(Station { name: name.into(), depth });
        }
        places.len()
    };
    let sized = add("surface", 0.0);
    add("within", scene.depth());
    (places, sized)
}

/// Longest automatic tail, s.
const TAIL_MAX: f64 = 30.0;

/// Samples before the record that a deconvolved motion needs, and of free vibration after it.
pub(super) fn lead_and_tail(
    scene: &Scene,
    profile: &Profile,
    column: &Profile,
    control: Control,
    input: &MotionInput,
    band: (f64, f64),
    notes: &mut Notes,
) -> (usize, usize) {
    let dt = input.motion.dt;
    let axes: Vec<usize> = (0..3).filter(|&a| input.motion.components[a].is_some()).collect();
    let travel = axes.iter().map(|&a| profile.travel_time(a)).fold(0.0, f64::max);
    let lead = if control == Control::Surface { 2.0 * travel + 2.0 / (band.0 * band.1).sqrt() } else { 0.0 };
    // twenty periods of the column or the length of the record, whichever is longer, but never above the maximum
    let longest = input.motion.duration().max(80.0 * travel).min(TAIL_MAX);
    let level = 0.1 * scene.accuracy;
    let decay = axes.iter().map(|&a| decay_time(column, a, level)).fold(0.0, f64::max);
    let auto = scene.discretisation.tail;
    let tail = auto.value().copied().unwrap_or_else(|| decay.max(2.0 * travel).min(longest));
    let why = match auto {
        Auto::Value(_) => "user".to_string(),
        Auto::Auto if decay > longest => {
            "auto: as long as the record, or twenty periods of the column".into()
        }
        Auto::Auto => format!("auto: free vibration decays to {level:.0e}"),
    };
    notes.add("discretisation.tail", format!("{tail:.3} s"), auto.is_auto(), why, json!(tail));
    if auto.is_auto() && decay > longest {
        notes.warnings.push(format!(
            "free vibration outlasts the {tail:.3} s computed after the record: spectra and transfer functions of the run are cut there; give discretisation.tail to compute more"
        ));
    }
    if lead > 0.0 {
        let why = format!("the waves behind a surface motion start {travel:.3} s earlier at the base");
        notes.remark("lead-in", format!("{lead:.3} s"), why);
    }
    ((lead / dt).ceil() as usize, (tail / dt).ceil() as usize)
}

/// Time in which a column's free vibration falls to `level`, s.
///
/// The upper layers down to each interface, and the whole column, are taken as one layer of mean
/// impedance and damping on what lies below: a round trip loses what that lets out and what a
/// quarter-wave mode's damping takes. The slowest of these decays counts.
fn decay_time(column: &Profile, axis: usize, level: f64) -> f64 {
    let (mut travel, mut mass, mut damped) = (0.0, 0.0, 0.0);
    let mut slowest = 0.0_f64;
    for (i, l) in column.layers.iter().enumerate() {
        let through = l.thickness / l.speed(axis);
        travel += through;
        mass += l.rho * l.thickness;
        damped += l.damping(axis) * through;
        let impedance = mass / travel;
        let below = match column.layers.get(i + 1) {
            Some(next) => Some(next.rho * next.speed(axis)),
            None => column.base.impedance(axis),
        };
        let reflection = below.map_or(1.0, |z| ((z - impedance) / (z + impedance)).abs().max(1e-3));
        let loss = std::f64::consts::PI * damped / travel - reflection.ln();
        slowest = slowest.max(if loss > 0.0 { -2.0 * travel * level.ln() / loss } else { f64::INFINITY });
    }
    slowest
}

/// Adds lead-in and tail and limits the motion to the band.
pub(super) fn extend(
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
    if scene.motion().band != Band::Full {
        motion.band(band.0, band.1.min(nyquist))?;
        // The window has no phase and spreads below f_min: what it puts outside the record's time is cut, and
        // what is left moves on. Where nothing below f_min is wanted, the ground ends where it began.
        if band.0 > 0.0 && motion.len() > REST_SAMPLES {
            Process::Rest {}.apply(motion)?;
        }
    }
    Ok(input)
}

/// Samples from which a motion is brought to rest at its end.
const REST_SAMPLES: usize = 100;

/// Share of the peak velocity that may be left at the end without a word.
const DRIFT: f64 = 0.05;

/// Warns where the ground still moves when the motion ends, which integration turns into a drift.
pub(super) fn warn_of_drift(input: &MotionInput, notes: &mut Notes) {
    for axis in 0..3 {
        let Some(v) = input.motion.component_as(axis, Quantity::Velocity, 1) else { continue };
        let peak = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let left = v.last().map_or(0.0, |x| x.abs());
        if left > DRIFT * peak {
            notes.warnings.push(format!(
                "component {}: {:.0} % of the peak velocity is left when the motion ends, so displacements drift; end motion.process with {{ step = \"rest\" }}, or give motion.band a lower end",
                crate::results::AXES[axis],
                100.0 * left / peak
            ));
        }
    }
}

/// The search's view of a scene.
pub(super) fn sizer<'a>(
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
    let Some(&first) = frequencies.first() else {
        let why = "no frequency of the record falls into it".into();
        return Err(PlanError::Band { f_min: band.0, f_max: band.1, nyquist: 0.5 / dt, why });
    };
    let spacing = frequencies.get(1).map_or(first, |second| second - first);
    Ok(Sizer {
        profile: column,
        control,
        frequencies,
        growth: 0.5 * std::f64::consts::PI * spacing,
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

/// What the scene fixes of the discretisation.
pub(super) fn fixed(scene: &Scene, sample_dt: f64) -> Fixed {
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

/// Depths of the wave field, m; empty for none.
pub(super) fn field_depths(
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
