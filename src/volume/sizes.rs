//! Frequencies and element sizes of a scene in two or three dimensions.

use super::sources::Signal;
use crate::plan::PlanError;
use hati_inputs::motion::usable_band;
use hati_inputs::scene::{Action, Auto, BoundaryKind, MaterialValues, Place, Scene, TimeFunction};
use hati_sem::attenuation::{MaxwellArms, ModulusLaw};
use hati_sem::mesh::Resolution;
use hati_sem::soil::Layer;
use hati_sem::solid::dispersion;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Order of the elements where the scene leaves it open.
pub const ORDER: usize = 5;
/// Fewest points per shortest wavelength that `auto` takes: below, surface waves and the ground near a source are not
/// what the table of plane waves tells.
pub const POINTS_FLOOR: f64 = 4.0;
/// Decades below the highest frequency over which damping is represented.
const DAMPING_DECADES: f64 = 1.7;
/// Accuracy at which the automatic reference frequency is taken: stiffness must not move with the accuracy asked.
const REFERENCE_ACCURACY: f64 = 1e-2;
/// Share of the accuracy for each of space, time and the damping fit.
pub const SHARE: f64 = 0.5;

/// Frequencies of the sources.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frequencies {
    /// Highest one that the sizes are chosen for, Hz.
    pub f_max: f64,
    /// The upper one at which the sources still have half of their largest amplitude, Hz.
    pub f_half: f64,
    /// Reference frequency of the soil's speeds, Hz.
    pub reference: f64,
    /// Highest frequency of the sources themselves, where the scene gives another, Hz.
    pub of_sources: f64,
}

/// Highest frequency of the sources: where their amplitude has fallen to `share` of its peak; of a record, what leaves
/// out `share` of its energy's root.
fn highest(signals: &[Signal], share: f64) -> f64 {
    let of = |signal: &Signal| match &signal.time {
        TimeFunction::Pulse(pulse) => pulse.highest_frequency(share),
        TimeFunction::Record { .. } => {
            signal.record.as_ref().map_or(0.0, |r| usable_band(&r.samples, r.dt, share).1)
        }
    };
    signals.iter().map(of).fold(0.0, f64::max)
}

/// Chooses the frequencies of a scene.
pub fn frequencies(scene: &Scene, signals: &[Signal]) -> Frequencies {
    let of_sources = highest(signals, scene.accuracy.min(0.3));
    let given = scene.discretisation.f_max.value().copied();
    let f_max = given.unwrap_or(of_sources);
    let f_half = highest(signals, 0.5).min(f_max);
    let top = given.unwrap_or_else(|| highest(signals, REFERENCE_ACCURACY));
    let auto = top / 10_f64.powf(0.5 * DAMPING_DECADES);
    let reference = scene.soil.reference_frequency.value().copied().unwrap_or(auto);
    Frequencies { f_max, f_half, reference, of_sources }
}

impl Frequencies {
    /// Highest frequency that the motion may hold, Hz: that of the sources too, where `f_max` is given below it.
    pub fn content(&self) -> f64 {
        self.f_max.max(self.of_sources)
    }

    /// Band over which damping is represented, Hz.
    pub fn damping_band(&self) -> (f64, f64) {
        (self.f_max / 10_f64.powf(DAMPING_DECADES), self.f_max)
    }
}

/// Points per wavelength at `f_max` for an accuracy after waves have run for `time` seconds.
///
/// The phase error after n wavelengths is 2πn times the relative error of the phase speed. It must stay below [`SHARE`] of
/// the accuracy at `f_half`, where the sources are strong, and below [`SHARE`] of a radian at `f_max`, where their
/// amplitude is a share `accuracy` of the peak. The dispersion is that of plane shear waves in the direction that the mesh
/// serves worst: along it ([`dispersion::points_per_wavelength`]) times [`dispersion::shear_amplification`], which grows
/// with `vp_over_vs`.
pub fn points_per_wavelength(
    order: usize,
    accuracy: f64,
    frequencies: &Frequencies,
    time: f64,
    vp_over_vs: f64,
) -> Result<f64, PlanError> {
    let Frequencies { f_max, f_half, .. } = *frequencies;
    let worse = dispersion::shear_amplification(order, vp_over_vs);
    let allowed = |phase: f64, f: f64| (phase / (2.0 * PI * (f * time).max(1.0) * worse)).clamp(1e-12, 0.1);
    let strong =
        dispersion::points_per_wavelength(order, allowed(SHARE * accuracy, f_half))? * f_half / f_max;
    let weak = dispersion::points_per_wavelength(order, allowed(SHARE, f_max))?;
    Ok(strong.max(weak).max(POINTS_FLOOR))
}

/// Points per wavelength at `f_max` that a source near the free surface asks for.
///
/// Measured on Lamb's problem, N = 4 and 5 (`docs/src/solid.md`), with p counted at `f_half`: relative error of the
/// acceleration $1.2\cdot10^{-2}\,(8.55/p)^{6.5}$, far above what plane waves tell and much the same for both orders.
/// It may take 0.7 of the accuracy, since time has its own error.
pub fn points_of_surface_source(accuracy: f64, frequencies: &Frequencies) -> f64 {
    let at_half = 8.55 * (1.2e-2 / (0.7 * accuracy)).powf(1.0 / 6.5);
    (at_half * frequencies.f_half / frequencies.f_max).max(POINTS_FLOOR)
}

/// Whether a source stands within `depth` of the free surface: of a box that of its heights, of a mesh its highest point.
fn is_shallow(scene: &Scene, signals: &[Signal], highest: Option<f64>, depth: f64) -> bool {
    let heights = scene.domain.as_ref().and_then(|d| d.heights.as_ref());
    let below = |place: &Place| match *place {
        Place::Below { depth, .. } => depth,
        Place::Point([x, y, z]) => {
            let top = highest.unwrap_or_else(|| heights.map_or(0.0, |h| h.height(x, y)));
            top - z
        }
    };
    signals.iter().any(|s| match &s.action {
        Action::Force { at, .. } | Action::Moment { at, .. } => below(at) < depth,
        Action::Patch { boundary, .. } => scene.boundary_kind(boundary) == BoundaryKind::Free,
        // a plane wave, but for the boundary's edges
        Action::Traction { .. } => false,
    })
}

/// Points per wavelength that each material needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    /// Order, highest frequency, and the most points of any material.
    pub resolution: Resolution,
    /// Points of each material: alike where the scene gives them.
    pub of: Vec<(String, f64)>,
}

impl Points {
    /// Points that a material needs.
    pub fn wanted(&self, material: &str) -> f64 {
        let found = self.of.iter().find(|(name, _)| name == material);
        found.map_or(self.resolution.points_per_wavelength, |(_, points)| *points)
    }

    /// Whether all materials need the same.
    pub fn is_uniform(&self) -> bool {
        self.of.iter().all(|(_, points)| *points == self.resolution.points_per_wavelength)
    }
}

/// Points of a scene's materials, and the reason for them; `highest` is the top of a mesh, m.
pub fn points(
    scene: &Scene,
    materials: &[MaterialValues],
    signals: &[Signal],
    frequencies: &Frequencies,
    time: f64,
    highest: Option<f64>,
) -> Result<(Points, String), PlanError> {
    let d = &scene.discretisation;
    let order = d.order.value().copied().unwrap_or(ORDER);
    let shortest = materials.iter().map(|m| m.vs).fold(f64::INFINITY, f64::min) / frequencies.f_max;
    let shallow = is_shallow(scene, signals, highest, shortest);
    // of a box only what lies within the shortest wavelength of the surface
    let mut top = 0.0;
    let mut tops: Vec<f64> = vec![];
    for thickness in scene.thicknesses() {
        tops.push(top);
        top += thickness;
    }
    let mut of = vec![];
    for (number, m) in materials.iter().enumerate() {
        let near = shallow && tops.get(number).is_none_or(|top| *top < shortest);
        let floor = if near { points_of_surface_source(scene.accuracy, frequencies) } else { POINTS_FLOOR };
        let points = match d.points_per_wavelength {
            Auto::Value(points) => points,
            Auto::Auto => {
                points_per_wavelength(order, scene.accuracy, frequencies, time, m.vp / m.vs)?.max(floor)
            }
        };
        of.push((m.name.clone(), points));
    }
    let (least, most) =
        of.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), (_, p)| (low.min(*p), high.max(*p)));
    let mut why = format!(
        "plane shear waves of order {order}, in the worst direction, keep their phase to {:.1e} of {time:.3} s",
        SHARE * scene.accuracy,
    );
    if most <= POINTS_FLOOR {
        why += &format!(", not below {POINTS_FLOOR}");
    } else if most > least {
        why += &format!(", and {least:.2} is enough for other materials");
    }
    if shallow {
        why += "; a source near the surface asks for more than plane waves do";
    }
    let resolution = Resolution { f_max: frequencies.f_max, points_per_wavelength: most, order };
    Ok((Points { resolution, of }, why))
}

/// Longest step whose phase error after `time` seconds stays below [`SHARE`] of the accuracy at `f_half`, s: the central
/// difference raises a frequency by the factor 1 + (ωΔt)²/24.
pub fn accurate_step(accuracy: f64, frequencies: &Frequencies, time: f64) -> f64 {
    let omega = 2.0 * PI * frequencies.f_half;
    (24.0 * SHARE * accuracy / (omega * time).max(1.0)).sqrt() / omega
}

/// A layer of the solver from a material's values; `thickness` serves messages only.
pub fn layer(m: &MaterialValues, thickness: f64) -> Layer {
    Layer {
        name: m.name.clone(),
        thickness,
        vs: m.vs,
        vp: m.vp,
        rho: m.rho,
        damping_s: m.damping,
        damping_p: m.damping_p,
    }
}

/// Most mechanisms that `auto` takes.
const MECHANISMS_MOST: usize = 8;

/// Largest relative error of a complex modulus that keeps waves right for `time` seconds: over n wavelengths a wave
/// turns by $2\pi n$ and an error $\Delta G/G$ of the modulus changes that, in phase and in the logarithm of the
/// amplitude, by $\pi n\,|\Delta G/G|$, which is to stay below [`SHARE`] of the accuracy after the wavelengths at
/// `f_half`, one at least.
pub fn modulus_error(accuracy: f64, frequencies: &Frequencies, time: f64) -> f64 {
    SHARE * accuracy / (PI * (frequencies.f_half * time).max(1.0))
}

/// Mechanisms of the damping and the largest relative error of a modulus over the band; 0 for elastic ground. `auto`
/// takes the fewest within [`modulus_error`] after `time` seconds, eight at most.
pub fn mechanisms(
    asked: Auto<usize>,
    accuracy: f64,
    materials: &[MaterialValues],
    frequencies: &Frequencies,
    time: f64,
) -> Result<(usize, f64), PlanError> {
    let largest = materials.iter().map(|m| m.damping.max(m.damping_p)).fold(0.0, f64::max);
    if largest == 0.0 {
        return Ok((0, 0.0));
    }
    let error = |count: usize| -> Result<f64, PlanError> {
        let band = frequencies.damping_band();
        let arms = MaxwellArms::fit(largest, frequencies.reference, band, count)?;
        let exact =
            ModulusLaw::ConstantDamping { damping: largest, reference_frequency: frequencies.reference };
        let at = |i: usize| {
            let f = band.0 * (band.1 / band.0).powf(i as f64 / 40.0);
            let i_omega = Complex64::new(0.0, 2.0 * PI * f);
            (arms.factor(i_omega) / exact.factor(i_omega) - 1.0).norm()
        };
        Ok((0..=40).map(at).fold(0.0, f64::max))
    };
    if let Auto::Value(count) = asked {
        return Ok((count, error(count)?));
    }
    let mut found = (1, error(1)?);
    let allowed = modulus_error(accuracy, frequencies, time);
    while found.1 > allowed && found.0 < MECHANISMS_MOST {
        found = (found.0 + 1, error(found.0 + 1)?);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frequencies(f_max: f64) -> Frequencies {
        Frequencies { f_max, f_half: 0.6 * f_max, reference: 1.0, of_sources: f_max }
    }

    /// The points that `auto` takes keep an oblique shear wave's phase within its share of the accuracy; fewer do not.
    #[test]
    fn an_oblique_shear_wave_keeps_its_phase() {
        let (order, accuracy, time) = (4, 1e-3, 20.0);
        let f = frequencies(5.0);
        let phase = |points: f64, degrees: f64, vp_over_vs: f64| {
            // `points` count at f_max; the strong waves are longer
            let (points, wave) = (points * f.f_max / f.f_half, dispersion::Wave::Sv);
            let ratio =
                dispersion::phase_speed_oblique(order, points, degrees.to_radians(), vp_over_vs, wave);
            2.0 * PI * f.f_half * time * (ratio.unwrap() - 1.0).abs()
        };
        for vp_over_vs in [1.6, 2.5, 7.0] {
            let points = points_per_wavelength(order, accuracy, &f, time, vp_over_vs).unwrap();
            let worst = |points: f64| {
                [0.0, 10.0, 20.0, 30.0, 45.0]
                    .map(|d| phase(points, d, vp_over_vs))
                    .into_iter()
                    .fold(0.0, f64::max)
            };
            assert!(worst(points) < 1.03 * SHARE * accuracy, "{vp_over_vs}: {:e}", worst(points));
            assert!(worst(0.9 * points) > SHARE * accuracy, "{vp_over_vs}: {:e}", worst(0.9 * points));
        }
    }

    fn ground(damping: f64) -> MaterialValues {
        let name = "a".to_owned();
        MaterialValues { name, vs: 1.0, vp: 2.0, nu: 1.0 / 3.0, rho: 1.0, damping, damping_p: damping }
    }

    /// Difference of a Ricker pulse of 1 Hz after `distance` in the realised and in the exact law, over its energy's root.
    fn error_after(distance: f64, damping: f64, count: usize, frequencies: &Frequencies) -> f64 {
        let arms = MaxwellArms::fit(damping, frequencies.reference, frequencies.damping_band(), count)
            .expect("a fit");
        let exact = ModulusLaw::ConstantDamping { damping, reference_frequency: frequencies.reference };
        let (mut difference, mut energy) = (0.0, 0.0);
        for i in 1..300 {
            let f = 0.01 * f64::from(i);
            let i_omega = Complex64::new(0.0, 2.0 * PI * f);
            let spectrum = f * f * (-f * f).exp();
            let arrived = |factor: Complex64| spectrum * (-i_omega * distance / factor.sqrt()).exp();
            let (found, expected) = (arrived(arms.factor(i_omega)), arrived(exact.factor(i_omega)));
            difference += (found - expected).norm_sqr();
            energy += expected.norm_sqr();
        }
        (difference / energy).sqrt()
    }

    #[test]
    fn mechanisms_keep_a_wave_over_its_whole_path() {
        let frequencies = Frequencies { f_max: 2.7, f_half: 1.7, reference: 0.4, of_sources: 2.7 };
        let chosen =
            |time: f64| mechanisms(Auto::Auto, 1e-2, &[ground(0.02)], &frequencies, time).expect("a fit").0;
        let (short, long) = (chosen(0.1), chosen(25.0));
        let found = error_after(25.0, 0.02, long, &frequencies);
        assert!(found < 1e-2, "{long} mechanisms: {found:e} after 25 wavelengths");
        // as many as a single wavelength needs are too few for 25, and enough for one
        assert!(short < long && error_after(25.0, 0.02, short, &frequencies) > 1e-2, "{short} and {long}");
        assert!(error_after(1.0, 0.02, short, &frequencies) < 1e-2);
        assert_eq!(mechanisms(Auto::Auto, 1e-2, &[ground(0.0)], &frequencies, 25.0).expect("none"), (0, 0.0));
    }
}
