//! What a scene's keys mean together: words, elastic constants, stations.

use std::path::PathBuf;

use serde::Serialize;

use crate::motion::Quantity;
use crate::records::{self, Response, ResponseMode, Unit};

use super::types::{
    Band, Base, Component, DEFAULT_NU, Layer, Motion, MotionKind, RecordFile, Scene, StationEntry,
};
use super::wavelet::WaveletKind;

/// An enum whose values are words of the scene file.
pub(super) trait Words: Copy + 'static {
    /// Every word with its value.
    const WORDS: &'static [(&'static str, Self)];
}

impl Words for MotionKind {
    const WORDS: &'static [(&'static str, Self)] =
        &[("outcrop", Self::Outcrop), ("within", Self::Within), ("surface", Self::Surface)];
}

impl Words for Quantity {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("acceleration", Self::Acceleration),
        ("velocity", Self::Velocity),
        ("displacement", Self::Displacement),
    ];
}

impl Words for WaveletKind {
    const WORDS: &'static [(&'static str, Self)] =
        &[("ricker", Self::Ricker), ("gaussian", Self::Gaussian), ("sine_burst", Self::SineBurst)];
}

impl Words for Unit {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("m/s2", Self::MetrePerSecond2),
        ("cm/s2", Self::CentimetrePerSecond2),
        ("gal", Self::Gal),
        ("g", Self::G),
        ("g/10", Self::TenthG),
        ("mm/s2", Self::MillimetrePerSecond2),
        ("nm/s2", Self::NanometrePerSecond2),
        ("m/s", Self::MetrePerSecond),
        ("cm/s", Self::CentimetrePerSecond),
        ("mm/s", Self::MillimetrePerSecond),
        ("nm/s", Self::NanometrePerSecond),
        ("m", Self::Metre),
        ("cm", Self::Centimetre),
        ("mm", Self::Millimetre),
        ("nm", Self::Nanometre),
    ];
}

impl Words for ResponseMode {
    const WORDS: &'static [(&'static str, Self)] =
        &[("full", Self::Full), ("sensitivity", Self::Sensitivity), ("stages", Self::Stages)];
}

/// The word of a value.
fn word<T: Words + PartialEq>(value: T) -> &'static str {
    T::WORDS.iter().find(|(_, v)| *v == value).map_or("", |(w, _)| w)
}

impl MotionKind {
    /// The word of the scene file, for instance `outcrop`.
    pub fn as_str(self) -> &'static str {
        word(self)
    }
}

impl WaveletKind {
    /// The word of the scene file, for instance `ricker`.
    pub fn as_str(self) -> &'static str {
        word(self)
    }
}

/// P-wave speed of a medium, vp = vs √(2(1 − ν)/(1 − 2ν)), m/s; `nu` in [0, 0.5).
pub fn vp_from_nu(vs: f64, nu: f64) -> f64 {
    vs * (2.0 * (1.0 - nu) / (1.0 - 2.0 * nu)).sqrt()
}

/// Poisson's ratio of a medium, ν = (vp² − 2 vs²)/(2 (vp² − vs²)); negative where vs > vp/√2.
pub fn nu_from_speeds(vs: f64, vp: f64) -> f64 {
    let r = (vs / vp).powi(2);
    // vs = vp/√2 gives ν = 0, which round-off must not turn negative.
    let nu = (1.0 - 2.0 * r) / (2.0 * (1.0 - r));
    if nu.abs() < 1e-12 { 0.0 } else { nu }
}

/// The elastic constants of one layer with its defaults filled in.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerValues {
    /// Name, given or `layer N`.
    pub name: String,
    /// Depth of its top, m.
    pub top: f64,
    /// Thickness, m.
    pub thickness: f64,
    /// Speed of shear waves at the reference frequency, m/s.
    pub vs: f64,
    /// Speed of P waves at the reference frequency, m/s.
    pub vp: f64,
    /// Poisson's ratio.
    pub nu: f64,
    /// Density, kg/m³.
    pub rho: f64,
    /// Damping ratio of shear waves.
    pub damping: f64,
    /// Damping ratio of P waves.
    pub damping_p: f64,
}

/// The elastic constants of an elastic half-space with its defaults filled in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HalfSpace {
    /// Speed of shear waves, m/s.
    pub vs: f64,
    /// Speed of P waves, m/s.
    pub vp: f64,
    /// Poisson's ratio.
    pub nu: f64,
    /// Density, kg/m³.
    pub rho: f64,
}

impl HalfSpace {
    /// Impedances ρ·vs along x and y and ρ·vp along z, kg/(m²·s).
    pub fn impedance(&self) -> [f64; 3] {
        let s = self.rho * self.vs;
        [s, s, self.rho * self.vp]
    }
}

/// Both of (vp, ν) from whichever is given, ν = 0.25 from neither.
pub(super) fn speeds(vs: f64, vp: Option<f64>, nu: Option<f64>) -> (f64, f64) {
    match (vp, nu) {
        (Some(vp), _) => (vp, nu_from_speeds(vs, vp)),
        (None, nu) => {
            let nu = nu.unwrap_or(DEFAULT_NU);
            (vp_from_nu(vs, nu), nu)
        }
    }
}

impl Layer {
    /// Damping ratio of shear waves, from `damping` or `q`; 0 where neither is given.
    pub fn damping_s(&self) -> f64 {
        self.damping.or(self.q.map(|q| 0.5 / q)).unwrap_or_default()
    }

    /// Damping ratio of P waves, from `damping_p` or `q_p`; that of shear waves where neither is given.
    pub fn damping_p(&self) -> f64 {
        self.damping_p.or(self.q_p.map(|q| 0.5 / q)).unwrap_or_else(|| self.damping_s())
    }
}

impl Base {
    /// The half-space with its defaults filled in; `None` for a rigid base.
    pub fn half_space(&self) -> Option<HalfSpace> {
        match *self {
            Self::Rigid => None,
            Self::Elastic { vs, rho, nu, vp } => {
                let (vp, nu) = speeds(vs, vp, nu);
                Some(HalfSpace { vs, vp, nu, rho })
            }
        }
    }
}

/// A place of a column whose motion is written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Station {
    /// Name.
    pub name: String,
    /// Depth below the surface, m.
    pub depth: f64,
}

/// The motion of a scene that has none.
static AT_REST: Motion = Motion {
    kind: MotionKind::Outcrop,
    quantity: Quantity::Acceleration,
    band: Band::Auto,
    process: Vec::new(),
    accept_clipped: false,
    x: None,
    y: None,
    z: None,
};

impl Scene {
    /// The motion that drives the scene; one without components where the scene has none, as with a `domain`.
    pub fn motion(&self) -> &Motion {
        self.motion.as_ref().unwrap_or(&AT_REST)
    }

    /// The elastic half-space under the layers; `None` over a rigid base and for a mesh.
    pub fn half_space(&self) -> Option<HalfSpace> {
        self.soil.base.as_ref().and_then(Base::half_space)
    }

    /// Layers from the surface down with their defaults filled in.
    pub fn layers(&self) -> Vec<LayerValues> {
        let mut top = 0.0;
        let mut layers = Vec::with_capacity(self.soil.layer.len());
        for (i, l) in self.soil.layer.iter().enumerate() {
            let (vp, nu) = speeds(l.vs, l.vp, l.nu);
            layers.push(LayerValues {
                name: l.name.clone().unwrap_or_else(|| format!("layer {}", i + 1)),
                top,
                thickness: l.thickness,
                vs: l.vs,
                vp,
                nu,
                rho: l.rho,
                damping: l.damping_s(),
                damping_p: l.damping_p(),
            });
            top += l.thickness;
        }
        layers
    }

    /// Depth of the layers, the sum of their thicknesses, m: of a column all of it.
    pub fn depth(&self) -> f64 {
        self.soil.layer.iter().map(|l| l.thickness).sum()
    }

    /// Places of a column: the given stations, or the surface, the top of every further layer and the top of the base.
    /// Those of a domain are [`Scene::sensors`].
    pub fn stations(&self) -> Vec<Station> {
        if let Some(given) = &self.output.stations {
            let station =
                |e: &StationEntry| Station { name: e.name.clone(), depth: e.depth.unwrap_or_default() };
            return given.iter().map(station).collect();
        }
        let layers = self.layers();
        let mut stations = vec![Station { name: "surface".to_owned(), depth: 0.0 }];
        for (i, l) in layers.iter().enumerate().skip(1) {
            let twin = layers.iter().filter(|o| o.name == l.name).count() > 1;
            let name = if twin {
                format!("top of {} (layer {})", l.name, i + 1)
            } else {
                format!("top of {}", l.name)
            };
            stations.push(Station { name, depth: l.top });
        }
        stations.push(Station { name: "within".to_owned(), depth: self.depth() });
        stations
    }

    /// Components x, y, z of the motion.
    pub fn components(&self) -> [Option<&Component>; 3] {
        let motion = self.motion();
        [&motion.x, &motion.y, &motion.z].map(Option::as_ref)
    }

    /// Path of a record or of its metadata: relative to the scene's folder, `obspy:…` as it stands.
    pub fn path_of(&self, file: &str) -> PathBuf {
        if file.starts_with("obspy:") { PathBuf::from(file) } else { self.source.folder.join(file) }
    }

    /// What to read for a recorded component.
    pub fn source_of(&self, record: &RecordFile) -> records::Source {
        let response = record.metadata.as_ref().map(|metadata| Response {
            mode: record.response.unwrap_or_default(),
            pre_filter: record.pre_filter,
            ..Response::new(self.path_of(metadata))
        });
        records::Source {
            location: self.path_of(&record.file),
            unit: record.unit,
            channel: record.channel.clone(),
            dt: record.dt,
            response,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use serde::{Serialize, de::DeserializeOwned};

    fn words_are_serdes_words<T: Words + Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>() {
        for (word, value) in T::WORDS {
            assert_eq!(serde_json::to_value(value).unwrap(), *word);
            assert_eq!(serde_json::from_value::<T>((*word).into()).unwrap(), *value);
        }
    }

    #[test]
    fn words_agree_with_serde() {
        words_are_serdes_words::<MotionKind>();
        words_are_serdes_words::<Quantity>();
        words_are_serdes_words::<WaveletKind>();
        words_are_serdes_words::<Unit>();
        words_are_serdes_words::<ResponseMode>();
    }

    #[test]
    fn poisson_and_speeds_are_inverse() {
        // ν = 1/4 is the Poisson solid, vp = √3 vs.
        assert_abs_diff_eq!(vp_from_nu(100.0, 0.25), 100.0 * 3f64.sqrt(), epsilon = 1e-12);
        for nu in [0.0, 0.1, 0.3, 0.45, 0.499] {
            assert_abs_diff_eq!(nu_from_speeds(170.0, vp_from_nu(170.0, nu)), nu, epsilon = 1e-12);
        }
        assert!(nu_from_speeds(200.0, 250.0) < 0.0);
    }
}
