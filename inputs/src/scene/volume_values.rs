//! What the keys of a scene in two or three dimensions mean together: materials, places, sources, boundaries.

use serde::Serialize;

use crate::records::{self, Unit};

use super::pulse::{Pulse, PulseKind};
use super::types::{Base, Layer, Scene};
use super::values::{Words, speeds};
use super::volume::{
    BoundaryKind, Domain, Material, MemoryVariables, OutputQuantity, Precision, SourceEntry, SourceKind,
    amplitude_of, top,
};

impl Words for BoundaryKind {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("free", Self::Free),
        ("fixed", Self::Fixed),
        ("symmetry", Self::Symmetry),
        ("absorbing", Self::Absorbing),
    ];
}

impl Words for SourceKind {
    const WORDS: &'static [(&'static str, Self)] =
        &[("force", Self::Force), ("moment", Self::Moment), ("traction", Self::Traction)];
}

impl Words for PulseKind {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("ricker", Self::Ricker),
        ("gaussian", Self::Gaussian),
        ("sine_burst", Self::SineBurst),
        ("ramp", Self::Ramp),
    ];
}

impl Words for Precision {
    const WORDS: &'static [(&'static str, Self)] = &[("f32", Self::F32), ("f64", Self::F64)];
}

impl Words for MemoryVariables {
    const WORDS: &'static [(&'static str, Self)] = &[("full", Self::Full), ("coarse", Self::Coarse)];
}

impl Words for OutputQuantity {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("displacement", Self::Displacement),
        ("velocity", Self::Velocity),
        ("acceleration", Self::Acceleration),
        ("strain", Self::Strain),
        ("stress", Self::Stress),
    ];
}

/// The word of a value.
fn word<T: Words + PartialEq>(value: T) -> &'static str {
    T::WORDS.iter().find(|(_, v)| *v == value).map_or("", |(w, _)| w)
}

impl BoundaryKind {
    /// The word of the scene file, for instance `absorbing`.
    pub fn as_str(self) -> &'static str {
        word(self)
    }
}

impl MemoryVariables {
    /// The word of the scene file, for instance `coarse`.
    pub fn as_str(self) -> &'static str {
        word(self)
    }
}

impl SourceKind {
    /// The word of the scene file, for instance `moment`.
    pub fn as_str(self) -> &'static str {
        word(self)
    }
}

impl PulseKind {
    /// The word of the scene file, for instance `ramp`.
    pub fn as_str(self) -> &'static str {
        word(self)
    }
}

impl OutputQuantity {
    /// The word of the scene file, for instance `strain`.
    pub fn as_str(self) -> &'static str {
        word(self)
    }
}

/// Constants of one material, with its defaults filled in.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaterialValues {
    /// Name: of the layer, `base`, or of the mesh's physical group.
    pub name: String,
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

impl From<&Material> for MaterialValues {
    fn from(m: &Material) -> Self {
        let (vp, nu) = speeds(m.vs, m.vp, m.nu);
        let ratio = |d: Option<f64>, q: Option<f64>| d.or(q.map(|q| 0.5 / q));
        let damping = ratio(m.damping, m.q).unwrap_or_default();
        let damping_p = ratio(m.damping_p, m.q_p).unwrap_or(damping);
        Self { name: m.name.clone(), vs: m.vs, vp, nu, rho: m.rho, damping, damping_p }
    }
}

/// A place in a domain, m; y = 0 at dimension 2.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Place {
    /// Coordinates x, y, z.
    Point([f64; 3]),
    /// So far under the surface at x and y.
    Below {
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
        /// Depth below the surface, m.
        depth: f64,
    },
}

impl Place {
    /// From the numbers of a scene file, which have been checked: as many as dimensions, one less with a depth.
    fn new(numbers: &[f64], depth: Option<f64>, dimension: usize) -> Self {
        let at = |i: usize| numbers.get(i).copied().unwrap_or_default();
        let (x, y) = (at(0), if dimension == 3 { at(1) } else { 0.0 });
        match depth {
            Some(depth) => Self::Below { x, y, depth },
            None => Self::Point([x, y, at(dimension - 1)]),
        }
    }

    /// Coordinates x, y, z under a surface whose height at (x, y) is given, m.
    pub fn point(&self, surface: impl FnOnce(f64, f64) -> f64) -> [f64; 3] {
        match *self {
            Self::Point(point) => point,
            Self::Below { x, y, depth } => [x, y, surface(x, y) - depth],
        }
    }
}

/// A source as it acts: size and direction, times [`TimeFunction`].
#[derive(Debug, Clone, PartialEq)]
pub struct SourceTerm {
    /// Name, given or `source N`.
    pub name: String,
    /// What acts where.
    pub action: Action,
    /// How it changes with time.
    pub time: TimeFunction,
}

/// What a source does. At dimension 2 forces and moments are per metre along y. On planes of symmetry they are those of
/// the whole, mirrored ground: a model that carries one half of a point source takes half of it.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// A force at a point.
    Force {
        /// Where.
        at: Place,
        /// Force along x, y, z, N.
        force: [f64; 3],
    },
    /// A moment tensor at a point, equivalent to the body force f_i = −∂_j (m_ij δ).
    Moment {
        /// Where.
        at: Place,
        /// mxx, myy, mzz, mxy, mxz, myz, N·m; N·m/s where `rate`.
        moment: [f64; 6],
        /// Whether the time function is the moment's rate.
        rate: bool,
    },
    /// A uniform traction on a boundary.
    Traction {
        /// Name of the boundary.
        boundary: String,
        /// Traction along x, y, z, Pa.
        traction: [f64; 3],
    },
    /// A traction force·exp(−r²/(2σ²))/(2πσ²), at dimension 2 force·exp(−r²/(2σ²))/(√(2π)σ), on a boundary.
    Patch {
        /// Name of the boundary.
        boundary: String,
        /// Where r = 0: x, y, z, or x, y with r the horizontal distance; y = 0 at dimension 2.
        centre: [f64; 3],
        /// Whether r leaves z out.
        horizontal: bool,
        /// Width σ, m.
        sigma: f64,
        /// Sum over an endless plane, N.
        force: [f64; 3],
    },
}

/// A source's time function.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeFunction {
    /// A closed form.
    Pulse(Pulse),
    /// A record, scaled so that its largest sample has the absolute value |amplitude|; its sign turns with `amplitude`'s.
    Record {
        /// What to read. Its unit is set to m/s², which scaling takes away again: read it as an acceleration.
        record: records::Source,
        /// Value of the largest sample.
        amplitude: f64,
    },
}

/// A place whose motion is written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensor {
    /// Name.
    pub name: String,
    /// Where.
    pub at: Place,
    /// Quantities, each once, in the order of [`OutputQuantity`].
    pub quantities: Vec<OutputQuantity>,
}

impl Domain {
    /// What holds on a boundary of a name: as given, or the default.
    fn boundary_kind(&self, name: &str, rigid: bool) -> BoundaryKind {
        match (self.boundary.get(name), name) {
            (Some(kind), _) => *kind,
            (None, "top") => BoundaryKind::Free,
            (None, "bottom") if rigid => BoundaryKind::Fixed,
            (None, _) => BoundaryKind::Absorbing,
        }
    }

    /// Names of the boundaries of a box.
    pub fn box_boundaries(dimension: usize) -> &'static [&'static str] {
        const NAMES: [&str; 6] = ["top", "bottom", "x_min", "x_max", "y_min", "y_max"];
        &NAMES[..if dimension == 2 { 4 } else { 6 }]
    }
}

impl Scene {
    /// 1 for a column, else the dimension of the domain.
    pub fn dimension(&self) -> usize {
        self.domain.as_ref().map_or(1, |d| d.dimension)
    }

    /// What holds on a boundary: as the scene says, else `top` is free, the `bottom` over a rigid base fixed, every other
    /// absorbing.
    pub fn boundary_kind(&self, name: &str) -> BoundaryKind {
        let rigid = matches!(self.soil.base, Some(Base::Rigid));
        self.domain.as_ref().map_or(BoundaryKind::Free, |d| d.boundary_kind(name, rigid))
    }

    /// Materials of the ground with their defaults filled in: those of a mesh, or the layers from the surface down and,
    /// where a box goes deeper than they do, `base`.
    pub fn materials(&self) -> Vec<MaterialValues> {
        if !self.material.is_empty() {
            return self.material.iter().map(MaterialValues::from).collect();
        }
        let mut materials: Vec<MaterialValues> = (self.layers().into_iter())
            .map(|l| MaterialValues {
                name: l.name,
                vs: l.vs,
                vp: l.vp,
                nu: l.nu,
                rho: l.rho,
                damping: l.damping,
                damping_p: l.damping_p,
            })
            .collect();
        if let (Some(_), Some(h)) = (self.base_thickness(), self.half_space()) {
            let name = BASE.to_owned();
            materials.push(MaterialValues {
                name,
                vs: h.vs,
                vp: h.vp,
                nu: h.nu,
                rho: h.rho,
                damping: 0.0,
                damping_p: 0.0,
            });
        }
        materials
    }

    /// Thickness of each material of a box, as [`Self::materials`] lists them, m; empty for a mesh.
    pub fn thicknesses(&self) -> Vec<f64> {
        let layers = self.soil.layer.iter().map(|l: &Layer| l.thickness);
        layers.chain(self.base_thickness()).collect()
    }

    /// How far a box continues under its layers, m; `None` where it ends with them.
    fn base_thickness(&self) -> Option<f64> {
        let depth = self.domain.as_ref()?.depth?;
        Some(depth - self.depth())
    }

    /// Sources of a domain with what their kind leaves out taken away.
    pub fn sources(&self) -> Vec<SourceTerm> {
        let entries = self.source_entries.iter().enumerate();
        entries.map(|(i, entry)| self.source_term(i + 1, entry)).collect()
    }

    fn source_term(&self, number: usize, entry: &SourceEntry) -> SourceTerm {
        let dimension = self.dimension();
        let place = |numbers: &Option<Vec<f64>>| {
            Place::new(numbers.as_deref().unwrap_or_default(), entry.depth, dimension)
        };
        let boundary = || entry.boundary.clone().unwrap_or_else(top);
        let force = entry.force.unwrap_or_default();
        let action = match (entry.kind, &entry.centre) {
            (SourceKind::Force, _) => Action::Force { at: place(&entry.position), force },
            (SourceKind::Moment, _) => Action::Moment {
                at: place(&entry.position),
                moment: entry.moment.unwrap_or_default(),
                rate: entry.rate,
            },
            (SourceKind::Traction, None) => {
                Action::Traction { boundary: boundary(), traction: entry.traction.unwrap_or_default() }
            }
            (SourceKind::Traction, Some(numbers)) => {
                let horizontal = numbers.len() < dimension;
                let centre = Place::new(numbers, horizontal.then_some(0.0), dimension).point(|_, _| 0.0);
                let sigma = entry.sigma.unwrap_or_default();
                Action::Patch { boundary: boundary(), centre, horizontal, sigma, force }
            }
        };
        let time = match (&entry.wavelet, &entry.file) {
            (Some(pulse), _) => TimeFunction::Pulse(*pulse),
            (None, file) => TimeFunction::Record {
                record: records::Source {
                    unit: Some(Unit::MetrePerSecond2),
                    channel: entry.channel.clone(),
                    dt: entry.dt,
                    ..records::Source::new(self.path_of(file.as_deref().unwrap_or_default()))
                },
                amplitude: amplitude_of(entry),
            },
        };
        let name = entry.name.clone().unwrap_or_else(|| format!("source {number}"));
        SourceTerm { name, action, time }
    }

    /// Stations of a domain with what is written at each; none of a column, whose places are [`Scene::stations`].
    pub fn sensors(&self) -> Vec<Sensor> {
        if self.domain.is_none() {
            return Vec::new();
        }
        use OutputQuantity::{Acceleration, Displacement, Velocity};
        let all =
            self.output.quantities.clone().unwrap_or_else(|| vec![Displacement, Velocity, Acceleration]);
        let entries = self.output.stations.iter().flatten();
        entries
            .map(|entry| {
                let mut quantities = entry.quantities.clone().unwrap_or_else(|| all.clone());
                quantities.sort_unstable();
                let numbers = entry.position.as_deref().unwrap_or_default();
                let at = Place::new(numbers, entry.depth, self.dimension());
                Sensor { name: entry.name.clone(), at, quantities }
            })
            .collect()
    }
}

/// Name of the material of the half-space under a box's layers.
pub(super) const BASE: &str = "base";
