//! The scene's tables as types. The comments on the fields are the text of the reference page.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::motion::{Process, Quantity};
use crate::records::{ResponseMode, Unit};

use super::load::Source;
use super::volume::{
    Checkpoint, Domain, FieldOutput, Material, MemoryVariables, OutputQuantity, POINTS_TO, Precision,
    RHO_FROM, RHO_TO, Run, SIZE_FROM, SourceEntry, SurfaceOutput, VolumeOutput,
};
use super::wavelet::Wavelet;

/// A value that the program chooses unless the scene gives it: the word `"auto"` or the value itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub enum Auto<T> {
    /// Left to the program, which says what it chose and why.
    #[default]
    Auto,
    /// Given by the user.
    #[serde(untagged)]
    Value(T),
}

impl<T> Auto<T> {
    /// The given value, if there is one.
    pub fn value(&self) -> Option<&T> {
        match self {
            Self::Auto => None,
            Self::Value(v) => Some(v),
        }
    }

    /// True where the choice is the program's.
    pub fn is_auto(&self) -> bool {
        matches!(self, Self::Auto)
    }
}

/// A scene: a column of soil under a motion, or ground in two or three dimensions (`domain`) under sources.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("anyOf" = [{ "required": ["motion", "soil"] }, { "required": ["domain", "source", "run"] }]))]
pub struct Scene {
    /// Version of this format.
    #[schemars(extend("const" = 1))]
    pub version: u32,
    /// Name of the scene in reports and files.
    #[serde(default = "default_title")]
    pub title: String,
    /// Relative L2 error asked for, over time and inside the band, of the acceleration at every station, against
    /// the converged solution of the same model.
    #[serde(default = "default_accuracy")]
    #[schemars(extend("exclusiveMinimum" = ACCURACY_ABOVE, "maximum" = ACCURACY_TO, "x-unit" = "1"))]
    pub accuracy: f64,
    /// Ground in two or three dimensions, in place of a column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "a column"))]
    pub domain: Option<Domain>,
    /// The motion that drives a column: at least one of the components x, y (horizontal) and z (up). A scene with
    /// `domain` has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "required for a column"))]
    pub motion: Option<Motion>,
    /// The ground, from the surface down.
    #[serde(default)]
    #[schemars(extend("x-default" = "required without `domain.mesh`"))]
    pub soil: Soil,
    /// The mesh's materials; with `domain.mesh` only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("x-default" = "required with `domain.mesh`"))]
    pub material: Vec<Material>,
    /// What acts on the ground; with `domain` only.
    #[serde(rename = "source", default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("x-default" = "required with `domain`"))]
    pub source_entries: Vec<SourceEntry>,
    /// How long to compute; with `domain` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "required with `domain`"))]
    pub run: Option<Run>,
    /// Numerical choices; all may be left out.
    #[serde(default)]
    pub discretisation: Discretisation,
    /// What to write.
    #[serde(default)]
    pub output: Output,
    /// Where the scene came from and which keys its author wrote; not part of the format.
    #[serde(skip)]
    pub source: Source,
}

/// Lower limit of `accuracy`, itself excluded.
pub(super) const ACCURACY_ABOVE: f64 = 1e-6;
/// Upper limit of `accuracy`.
pub(super) const ACCURACY_TO: f64 = 0.3;
/// Largest damping ratio.
pub(super) const DAMPING_TO: f64 = 0.3;
/// Smallest quality factor, 1/(2·0.3) rounded up so that the damping stays in its range.
pub(super) const Q_FROM: f64 = 5.0 / 3.0;
/// Largest thickness of a layer, m.
pub(super) const THICKNESS_TO: f64 = 1e5;
/// Largest speed of shear waves, m/s; diamond stays below 1.3e4.
pub(super) const VS_TO: f64 = 1e4;
/// Largest speed of P waves, m/s.
pub(super) const VP_TO: f64 = 2e4;
/// Most layers of a column.
pub(super) const LAYERS_TO: usize = 2000;
/// Most elements of a column.
pub(super) const ELEMENTS_TO: usize = 20_000;
/// Smallest time step, s.
pub(super) const DT_FROM: f64 = 1e-9;
/// Longest free vibration, s.
pub(super) const TAIL_TO: f64 = 3600.0;
/// Most intervals of the wave field over the column's depth.
pub(super) const FIELD_INTERVALS_TO: f64 = 2000.0;
/// Poisson's ratio of a layer that gives neither `nu` nor `vp`.
pub const DEFAULT_NU: f64 = 0.25;

pub(super) fn default_title() -> String {
    "untitled".to_owned()
}

pub(super) fn default_accuracy() -> f64 {
    1e-2
}

pub(super) fn default_quantity() -> Quantity {
    Quantity::Acceleration
}

pub(super) fn default_process() -> Vec<Process> {
    vec![Process::Demean { first_seconds: None }]
}

/// Where the motion was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionKind {
    /// On rock at the surface: twice the wave that rises in the half-space. Needs an elastic base.
    Outcrop,
    /// At the top of the half-space under the soil, where up- and downgoing waves add.
    Within,
    /// At the soil's surface; the input at depth is found by going down the column.
    Surface,
}

/// Frequency band in which the run has to be accurate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Band {
    /// the band outside which the record's energy does not matter at the accuracy asked
    #[default]
    Auto,
    /// all that the record holds, up to its Nyquist frequency
    Full,
    /// lowest and highest frequency, 0 < f_min < f_max
    #[serde(untagged)]
    Range([f64; 2]),
}

/// The motion that drives the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Where the motion was recorded.
    pub kind: MotionKind,
    /// What the files hold.
    #[serde(default = "default_quantity")]
    pub quantity: Quantity,
    /// Frequency band in which the run has to be accurate.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Hz"))]
    pub band: Band,
    /// What is done to the motion before it drives the scene, in this order; `[]` for nothing. `demean`, `detrend` and
    /// `baseline` mend what an instrument leaves: they act on records and leave a wavelet its closed form.
    #[serde(default = "default_process")]
    #[schemars(extend("x-default" = "one `demean`"))]
    pub process: Vec<Process>,
    /// Lets records pass that look clipped, where a plateau at the extreme is meant.
    #[serde(default)]
    pub accept_clipped: bool,
    /// Horizontal component along x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "at rest"))]
    pub x: Option<Component>,
    /// Horizontal component along y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "at rest"))]
    pub y: Option<Component>,
    /// Vertical component, positive up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "at rest"))]
    pub z: Option<Component>,
}

/// One component of the motion: a record's file or a synthetic pulse.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(extend("x-section" = true))]
pub enum Component {
    /// From a file.
    Record(RecordFile),
    /// From a closed form.
    Synthetic(Synthetic),
}

/// A component read from a record's file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordFile {
    /// Path of the record, relative to the scene's folder; `obspy:PATH` names a file inside the installed ObsPy
    /// package. Give either `file` or `wavelet`.
    #[schemars(extend("x-default" = "this or `wavelet`"))]
    pub file: String,
    /// Unit of one sample, in place of what the file says; it has to be a unit of `motion.quantity`. For a file
    /// of counts it says what one count means, and the file's own calibration is not used. `gal` is 1 cm/s², `g` is
    /// 9.80665 m/s², `g/10` a tenth of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "from the file"))]
    pub unit: Option<Unit>,
    /// Channel to take where the file holds several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "the only one"))]
    pub channel: Option<String>,
    /// Time step of a file that states none; a file that states another one is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s", "x-default" = "from the file"))]
    pub dt: Option<f64>,
    /// Path of the instrument's metadata (FDSN StationXML, RESP, or SAC poles and zeros), relative to the scene's
    /// folder: its response is taken off, in place of a `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "no response is taken off"))]
    pub metadata: Option<String>,
    /// How the response is taken off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "`\"full\"` with `metadata`"))]
    pub response: Option<ResponseMode>,
    /// Four rising corners of the cosine window under which the response is divided; with `metadata`, and not with
    /// `response = "sensitivity"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "Hz", "x-default" = "from the record's length and its Nyquist frequency"))]
    pub pre_filter: Option<[f64; 4]>,
}

/// A component with a closed form.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Synthetic {
    /// A pulse with a closed form; no Python is needed for it. All wavelets of a scene share `dt` and `duration`.
    #[schemars(extend("x-default" = "this or `file`"))]
    pub wavelet: Wavelet,
}

/// The ground in layers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Soil {
    /// Frequency at which the layers' speeds hold; the causal damping law stiffens above it and softens below.
    /// `"auto"` takes the geometric mean of the given band, or of the band that accuracy 1e-2 would take.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "Hz"))]
    pub reference_frequency: Auto<f64>,
    /// Layers from the surface (of a `domain` z = 0) down, 1 to 2000; none for a `domain` with `depth`, which the base
    /// then fills.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("minItems" = 1, "maxItems" = LAYERS_TO, "x-default" = "required for a column"))]
    pub layer: Vec<Layer>,
    /// What the layers stand on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "required without `domain.mesh`"))]
    pub base: Option<Base>,
}

/// One soil layer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// Name in reports and stations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "`layer 1`, `layer 2`, …"))]
    pub name: Option<String>,
    /// Thickness.
    #[schemars(extend("minimum" = SIZE_FROM, "maximum" = THICKNESS_TO, "x-unit" = "m"))]
    pub thickness: f64,
    /// Speed of shear waves at the reference frequency; at most vp/√2.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = VS_TO, "x-unit" = "m/s"))]
    pub vs: f64,
    /// Speed of P waves. Give `vp` or `nu`, not both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = VP_TO, "x-unit" = "m/s", "x-default" = "from `nu`"))]
    pub vp: Option<f64>,
    /// Poisson's ratio; 0.25 where neither `nu` nor `vp` is given. The vp that follows is at most 20000 m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0, "exclusiveMaximum" = 0.5, "x-unit" = "1", "x-default" = "0.25, or from `vp`"))]
    pub nu: Option<f64>,
    /// Density.
    #[schemars(extend("minimum" = RHO_FROM, "maximum" = RHO_TO, "x-unit" = "kg/m³"))]
    pub rho: f64,
    /// Damping ratio D = Im G/(2 Re G) of shear waves, constant over the band. Give `damping` or `q`, not both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0, "maximum" = DAMPING_TO, "x-unit" = "1", "x-default" = "0, or from `q`"))]
    pub damping: Option<f64>,
    /// Quality factor of shear waves, D = 1/(2Q).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = Q_FROM, "x-unit" = "1", "x-default" = "from `damping`"))]
    pub q: Option<f64>,
    /// Damping ratio of P waves. Give `damping_p` or `q_p`, not both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0, "maximum" = DAMPING_TO, "x-unit" = "1", "x-default" = "as for shear waves"))]
    pub damping_p: Option<f64>,
    /// Quality factor of P waves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = Q_FROM, "x-unit" = "1", "x-default" = "from `damping_p`"))]
    pub q_p: Option<f64>,
}

/// What the layers stand on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[schemars(extend("x-section" = true))]
pub enum Base {
    /// An elastic half-space, which lets downgoing waves out: impedances ρ·vs and ρ·vp.
    Elastic {
        /// Speed of shear waves.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = VS_TO, "x-unit" = "m/s"))]
        vs: f64,
        /// Density.
        #[schemars(extend("minimum" = RHO_FROM, "maximum" = RHO_TO, "x-unit" = "kg/m³"))]
        rho: f64,
        /// Poisson's ratio; 0.25 where neither `nu` nor `vp` is given. The vp that follows is at most 20000 m/s.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("minimum" = 0.0, "exclusiveMaximum" = 0.5, "x-unit" = "1", "x-default" = "0.25, or from `vp`"))]
        nu: Option<f64>,
        /// Speed of P waves. Give `vp` or `nu`, not both.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = VP_TO, "x-unit" = "m/s", "x-default" = "from `nu`"))]
        vp: Option<f64>,
    },
    /// A rigid base that follows the motion and reflects every wave; it takes no other key.
    Rigid,
}

/// Numerical choices.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Discretisation {
    /// Polynomial order of the elements.
    #[serde(default)]
    #[schemars(extend("minimum" = 1, "maximum" = 10, "x-unit" = "1"))]
    pub order: Auto<usize>,
    /// Number of elements over each layer's thickness, from the surface down: one count of at least 1 per layer, at most
    /// 20000 in all. A `domain` with `depth` has one more, for the base's material; a mesh has none.
    #[serde(default)]
    #[schemars(with = "Auto<Vec<std::num::NonZeroUsize>>", transform = limit_counts)]
    pub elements: Auto<Vec<usize>>,
    /// Horizontal size of the elements of a box; it is made a little smaller where the box asks for it.
    #[serde(default)]
    #[schemars(extend("minimum" = SIZE_FROM, "x-unit" = "m"))]
    pub element_size: Auto<f64>,
    /// Points of the elements to the shortest wavelength, vs/f_max, that the sizes are chosen for; with `domain` only.
    #[serde(default)]
    #[schemars(extend("minimum" = 2.0, "maximum" = POINTS_TO, "x-unit" = "1"))]
    pub points_per_wavelength: Auto<f64>,
    /// Highest frequency that the sizes are chosen for; `"auto"` takes it from the sources. With `domain` only: a
    /// column has its `motion.band`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "Hz"))]
    pub f_max: Auto<f64>,
    /// Number format of the computation, `"f32"` or `"f64"`; `"auto"` is `"f32"`. With `domain` only: a column is
    /// computed in `"f64"`.
    #[serde(default)]
    pub precision: Auto<Precision>,
    /// Time step; it has to be stable, which the plan checks.
    #[serde(default)]
    #[schemars(extend("minimum" = DT_FROM, "x-unit" = "s"))]
    pub dt: Auto<f64>,
    /// Number of relaxation mechanisms that represent the damping over the band.
    #[serde(default)]
    #[schemars(extend("minimum" = 1, "maximum" = 12, "x-unit" = "1"))]
    pub mechanisms: Auto<usize>,
    /// How the mechanisms' memory variables are spread over the points of an element, `"full"` (every mechanism at every point)
    /// or `"coarse"` (one at a point); `"auto"` is `"full"`. With `domain` only.
    #[serde(default)]
    pub memory_variables: Auto<MemoryVariables>,
    /// Time of free vibration to compute after the record's end; for a column only.
    #[serde(default)]
    #[schemars(extend("minimum" = 0.0, "maximum" = TAIL_TO, "x-unit" = "s"))]
    pub tail: Auto<f64>,
}

/// Puts the limits of counts per layer, which stand behind the word `"auto"`, into their schema.
fn limit_counts(schema: &mut schemars::Schema) {
    if let Some(list) = schema.pointer_mut("/anyOf/1").and_then(serde_json::Value::as_object_mut) {
        list.insert("maxItems".to_owned(), LAYERS_TO.into());
        if let Some(count) = list.get_mut("items").and_then(serde_json::Value::as_object_mut) {
            count.insert("maximum".to_owned(), ELEMENTS_TO.into());
        }
    }
}

/// What to write.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Places whose motion is written and whose accuracy counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "of a column the surface, every layer's top and the base's top"))]
    pub stations: Option<Vec<StationEntry>>,
    /// Quantities that are written at every station of a `domain` that does not name its own; a column's stations have
    /// displacement, velocity and acceleration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minItems" = 1, "x-default" = "displacement, velocity and acceleration"))]
    pub quantities: Option<Vec<OutputQuantity>>,
    /// Spacing of a column's wave field over depth, at least a 2000th of its depth; `"none"` writes no field. A
    /// `domain` has `[output.field]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m"))]
    pub field_spacing: FieldSpacing,
    /// The motion of a boundary, in `surface.nc`; with `domain` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "not written"))]
    pub surface: Option<SurfaceOutput>,
    /// The motion of all points, in `volume.nc`; with `domain` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "not written"))]
    pub volume: Option<VolumeOutput>,
    /// The motion on a regular grid, in `field.nc`; with `domain` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "not written"))]
    pub field: Option<FieldOutput>,
    /// Checkpoints; with `domain` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "as its keys"))]
    pub checkpoint: Option<Checkpoint>,
    /// Writes surface and volume as VTKHDF too, for ParaView; with `domain` only.
    #[serde(default)]
    pub vtkhdf: bool,
}

/// A place whose motion is written: of a column `depth` alone, of a `domain` `position`, or `position` and `depth`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StationEntry {
    /// Name, different for each station. In a column `outcrop` is kept for the input, and `surface` and `within` only
    /// name its ends.
    pub name: String,
    /// Place in a `domain`: x, y, z, or x, z at dimension 2; without the last number where `depth` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minItems" = 1, "maxItems" = 3, "x-unit" = "m", "x-default" = "required with `domain`"))]
    pub position: Option<Vec<f64>>,
    /// Depth below the surface, from 0 to the ground's depth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0, "x-unit" = "m", "x-default" = "required for a column"))]
    pub depth: Option<f64>,
    /// Quantities that are written here; with `domain` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minItems" = 1, "x-default" = "those of `output.quantities`"))]
    pub quantities: Option<Vec<OutputQuantity>>,
}

/// Spacing of the wave field over depth.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub enum FieldSpacing {
    /// fine enough for the highest frequency of the band
    #[default]
    Auto,
    /// no field
    None,
    /// the spacing, m
    #[serde(untagged)]
    Metres(f64),
}
