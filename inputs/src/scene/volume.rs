//! The tables of a scene in two or three dimensions. The comments on the fields are the text of the reference page.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::pulse::{Pulse, one};
use super::topography::Topography;
use super::types::{Auto, DAMPING_TO, Q_FROM, VP_TO, VS_TO};

/// Largest coordinate of a domain, m: the Earth's diameter is 1.3e7.
pub(super) const COORDINATE_TO: f64 = 1e8;
/// Longest run, s.
pub(super) const DURATION_TO: f64 = 1e6;
/// Longest wall time between checkpoints, s: thirty years.
pub(super) const CHECKPOINT_TO: f64 = 1e9;
/// Least size of a domain, a layer or an element, m.
pub(super) const SIZE_FROM: f64 = 1e-6;
/// Densities, kg/m³: a gas has 1, osmium 22 600.
pub(super) const RHO_FROM: f64 = 1e-3;
pub(super) const RHO_TO: f64 = 1e5;
/// Most points to a wavelength.
pub(super) const POINTS_TO: f64 = 100.0;
/// Most materials, sources and stations.
pub(super) const ENTRIES_TO: usize = 100_000;

/// The ground in two or three dimensions: a box of the soil's layers, or a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// 2: a section in x and z, in which nothing varies along y and displacement has three components; 3: a volume.
    #[schemars(extend("minimum" = 2, "maximum" = 3, "x-unit" = "1"))]
    pub dimension: usize,
    /// Least and greatest x of the box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m", "x-default" = "required without `mesh`"))]
    pub x: Option<[f64; 2]>,
    /// Least and greatest y of the box; at dimension 3 only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m", "x-default" = "required at dimension 3 without `mesh`"))]
    pub y: Option<[f64; 2]>,
    /// Depth of the box under z = 0: where it is below the layers, the elastic base's material continues down to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = SIZE_FROM, "maximum" = COORDINATE_TO, "x-unit" = "m", "x-default" = "the sum of the layers"))]
    pub depth: Option<f64>,
    /// Path of a text file with the height of the surface above z = 0, in metres, on a regular grid that covers the
    /// box: lines `x y z`, or `x z` at dimension 2, in any order, between blanks or commas; `#` begins a comment.
    /// Between the points heights are interpolated linearly. Only the first layer's top follows them: the interfaces below stay flat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "flat, z = 0"))]
    pub topography: Option<String>,
    /// Path of a Gmsh mesh (`.msh`) or of a script that makes one (`.geo`, in the scene's folder only), in place of
    /// `x`, `y`, `depth`, `topography` and the layers; each of its materials has a `[[material]]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "a box of the soil's layers"))]
    pub mesh: Option<String>,
    /// What holds on the boundaries: of a box `top`, `bottom`, `x_min`, `x_max`, `y_min`, `y_max`, of a mesh its
    /// physical groups. Left out, `top` is `"free"`, the `bottom` over a rigid base `"fixed"`, every other
    /// `"absorbing"`. Sides of a mesh that are in no group are free.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("x-default" = "`top` free, others absorbing"))]
    pub boundary: BTreeMap<String, BoundaryKind>,
    /// Heights of `topography`, read when the scene was checked; not part of the format.
    #[serde(skip)]
    pub heights: Option<Topography>,
}

/// What holds on a boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundaryKind {
    /// No traction.
    Free,
    /// No displacement.
    Fixed,
    /// No displacement along the normal, no traction along the plane: a plane of symmetry. The boundary has to be flat.
    Symmetry,
    /// Dashpots of first order, ρ·vp along the normal and ρ·vs along the plane: waves that arrive straight leave.
    Absorbing,
}

/// The material of a physical group of the mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Name of the mesh's physical group (surface at dimension 2, volume at 3).
    pub name: String,
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

/// What acts on the ground: a vector or a tensor, whose size is given, times a time function, a `wavelet` or a `file`.
///
/// [`super::Scene::sources`] gives the same with what its kind leaves out taken away.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceEntry {
    /// Name in reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "`source 1`, `source 2`, …"))]
    pub name: Option<String>,
    /// What acts.
    pub kind: SourceKind,
    /// Place of a `force` or `moment`: x, y, z, or x, z at dimension 2; without the last number where `depth` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minItems" = 1, "maxItems" = 3, "x-unit" = "m", "x-default" = "required for `force` and `moment`"))]
    pub position: Option<Vec<f64>>,
    /// Depth of the place below the surface at its x and y, in place of z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0, "x-unit" = "m", "x-default" = "z stands in `position`"))]
    pub depth: Option<f64>,
    /// Force along x, y, z: of a `force`, or in all of a `traction` around a `centre`. At dimension 2 per metre along y.
    /// On planes of symmetry it is the whole force, of which the model carries its part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N", "x-default" = "required for `force`"))]
    pub force: Option<[f64; 3]>,
    /// Moment tensor mxx, myy, mzz, mxy, mxz, myz of a `moment`. At dimension 2 per metre along y, and myy, which acts
    /// on nothing there, is 0. On planes of symmetry it is the whole moment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N·m", "x-default" = "required for `moment`"))]
    pub moment: Option<[f64; 6]>,
    /// Whether the time function of a `moment` is the moment's rate, in N·m/s, instead of the moment.
    #[serde(default)]
    pub rate: bool,
    /// Traction along x, y, z on the whole boundary. Give `traction`, or `centre`, `sigma` and `force`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "Pa", "x-default" = "this or `centre`"))]
    pub traction: Option<[f64; 3]>,
    /// Boundary on which a `traction` acts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "`top` for a `traction`"))]
    pub boundary: Option<String>,
    /// Centre of a traction that falls off as exp(−r²/(2 sigma²)): x, y, z with r the distance in space, or without z with
    /// r the horizontal one; at dimension 2 without y. Its sum over an endless plane is `force`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minItems" = 1, "maxItems" = 3, "x-unit" = "m", "x-default" = "this or `traction`"))]
    pub centre: Option<Vec<f64>>,
    /// Width σ of the traction around `centre`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m", "x-default" = "required with `centre`"))]
    pub sigma: Option<f64>,
    /// Time function with a closed form. Give `wavelet` or `file`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "this or `file`"))]
    pub wavelet: Option<Pulse>,
    /// Path of a record whose samples are the time function, relative to the scene's folder; `obspy:PATH` names a file
    /// inside the installed ObsPy package. Its unit does not matter; its first sample is at t = 0, and before and after it
    /// the time function is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "this or `wavelet`"))]
    pub file: Option<String>,
    /// Channel to take where the file holds several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "the only one"))]
    pub channel: Option<String>,
    /// Time step of a file that states none; a file that states another one is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s", "x-default" = "from the file"))]
    pub dt: Option<f64>,
    /// Value that the largest sample of the file takes, whatever its sign; negative turns the record over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "1", "x-default" = "`1` with `file`"))]
    pub amplitude: Option<f64>,
}

/// What a source is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SourceKind {
    /// A force at a point.
    Force,
    /// A moment tensor at a point.
    Moment,
    /// A traction on a boundary, integrated over its faces.
    Traction,
}

/// How long to compute.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Simulated time, from t = 0.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = DURATION_TO, "x-unit" = "s"))]
    pub duration: f64,
}

/// Number format of the computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// Single precision: half the memory, up to twice the speed, seven digits.
    F32,
    /// Double precision.
    F64,
}

/// How the damping's memory variables are spread over the points of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MemoryVariables {
    /// Every mechanism at every point.
    Full,
    /// One mechanism at a point, the mechanisms in turn: faster, with fewer numbers to keep, for a small error of the
    /// damping that the plan bounds.
    Coarse,
}

/// What is written at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OutputQuantity {
    /// m
    Displacement,
    /// m/s
    Velocity,
    /// m/s²
    Acceleration,
    /// xx, yy, zz, xy, xz, yz, the mixed ones as ε and not as γ = 2ε
    Strain,
    /// Pa, in the same order
    Stress,
}

/// The motion of a boundary over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceOutput {
    /// Boundary that is written.
    #[serde(default = "top")]
    pub boundary: String,
    /// Time between two of its states; what is faster is filtered out before.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s"))]
    pub dt: Auto<f64>,
    /// Quantities that are written: displacement, velocity, acceleration; strain and stress are those of stations.
    #[serde(default = "velocity")]
    #[schemars(extend("minItems" = 1), transform = motions_only)]
    pub quantities: Vec<OutputQuantity>,
}

/// The motion of all points over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeOutput {
    /// Layer or material that is written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "all"))]
    pub material: Option<String>,
    /// Time between two of its states; what is faster is filtered out before.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s"))]
    pub dt: Auto<f64>,
    /// Quantities that are written: displacement, velocity, acceleration; strain and stress are those of stations.
    #[serde(default = "velocity")]
    #[schemars(extend("minItems" = 1), transform = motions_only)]
    pub quantities: Vec<OutputQuantity>,
}

/// The motion on a regular grid, interpolated inside the elements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldOutput {
    /// Spacing of the grid along every axis.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m"))]
    pub spacing: Auto<f64>,
    /// Time between two of its states; what is faster is filtered out before.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s"))]
    pub dt: Auto<f64>,
    /// Quantities that are written: displacement, velocity, acceleration; strain and stress are those of stations.
    #[serde(default = "velocity")]
    #[schemars(extend("minItems" = 1), transform = motions_only)]
    pub quantities: Vec<OutputQuantity>,
    /// Least and greatest x of the grid; with the same number twice a plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m", "x-default" = "the whole domain"))]
    pub x: Option<[f64; 2]>,
    /// Least and greatest y of the grid; at dimension 3 only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m", "x-default" = "the whole domain"))]
    pub y: Option<[f64; 2]>,
    /// Least and greatest z of the grid, positive up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m", "x-default" = "the whole domain"))]
    pub z: Option<[f64; 2]>,
}

/// States of the run from which it can go on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    /// Wall time between two checkpoints.
    #[serde(default)]
    #[schemars(extend("minimum" = 1.0, "maximum" = CHECKPOINT_TO, "x-unit" = "s"))]
    pub every: Auto<f64>,
}

/// Leaves strain and stress out of the words of a list.
fn motions_only(schema: &mut schemars::Schema) {
    let motions =
        serde_json::json!({ "type": "string", "enum": ["displacement", "velocity", "acceleration"] });
    schema.insert("items".to_owned(), motions);
}

pub(super) fn top() -> String {
    "top".to_owned()
}

pub(super) fn velocity() -> Vec<OutputQuantity> {
    vec![OutputQuantity::Velocity]
}

/// Factor of a source whose file gives none.
pub(super) fn amplitude_of(entry: &SourceEntry) -> f64 {
    entry.amplitude.unwrap_or_else(one)
}
