//! What a run knows when it ends: the arrays that outputs and report are made from.
//!
//! Axes: x and y horizontal, z up. `depth` is positive down. SI units throughout.

use num_complex::Complex64;
use serde::Serialize;

/// Letters of the three displacement components, in storage order.
pub const AXES: [char; 3] = ['x', 'y', 'z'];

/// One recorded motion at one place along one axis, sampled at the record's own step.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Place: `surface`, `within` (top of the half-space), `outcrop` (input side), or a station's name.
    pub place: String,
    /// Depth below the surface, m; `None` for a motion that is not a point of the column (outcrop).
    pub depth: Option<f64>,
    /// Component: 0 = x, 1 = y, 2 = z.
    pub axis: usize,
    /// Acceleration, m/s².
    pub acceleration: Vec<f64>,
    /// Velocity, m/s.
    pub velocity: Vec<f64>,
    /// Displacement, m.
    pub displacement: Vec<f64>,
}

/// Largest absolute values over the whole run at every GLL point of the column, for one component.
#[derive(Debug, Clone, Serialize)]
pub struct PeakProfile {
    /// Component: 0 = x, 1 = y, 2 = z.
    pub axis: usize,
    /// Depth, m, increasing; a point on a layer interface stands twice (strain jumps there).
    pub depth: Vec<f64>,
    /// Peak acceleration, m/s².
    pub acceleration: Vec<f64>,
    /// Peak velocity, m/s.
    pub velocity: Vec<f64>,
    /// Peak displacement relative to the column's base, m.
    pub displacement: Vec<f64>,
    /// Peak strain (engineering shear strain γ for x and y, axial strain for z), 1.
    pub strain: Vec<f64>,
    /// Peak stress (τ or σ_zz), Pa.
    pub stress: Vec<f64>,
}

/// A transfer function of the run with closed forms to draw over it.
#[derive(Debug, Clone)]
pub struct TransferFunction {
    /// For instance `surface/outcrop`.
    pub name: String,
    /// Component: 0 = x, 1 = y, 2 = z.
    pub axis: usize,
    /// Frequencies of the computed ratio, Hz, increasing.
    pub frequency: Vec<f64>,
    /// Ratio of the run's own spectra; only where the denominator carries energy.
    pub computed: Vec<Complex64>,
    /// Frequencies of the closed forms, Hz.
    pub closed_form_frequency: Vec<f64>,
    /// Closed form with the causal constant-D modulus that the run uses.
    pub causal: Vec<Complex64>,
    /// Closed form with the textbooks' G(1 + 2iD), which is not causal.
    pub hysteretic: Vec<Complex64>,
}

/// Motion of the whole column on a regular depth grid, for one component (`[time][depth]`, row-major).
#[derive(Debug, Clone)]
pub struct Section {
    /// Component: 0 = x, 1 = y, 2 = z.
    pub axis: usize,
    /// Depths, m, increasing.
    pub depth: Vec<f64>,
    /// Time of each row, s of `elapsed_time`.
    pub time: Vec<f64>,
    /// Acceleration, m/s², `time.len() * depth.len()`.
    pub acceleration: Vec<f32>,
}

/// One row of the energy ledger: cumulative energies per unit plan area, J/m².
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct LedgerRow {
    /// Elapsed time, s.
    pub time: f64,
    /// Energy that came in (incident wave, or work of the imposed base motion).
    pub input: f64,
    /// Kinetic energy.
    pub kinetic: f64,
    /// Strain energy, memory variables included.
    pub strain: f64,
    /// Dissipated in the memory variables.
    pub viscous: f64,
    /// Carried out by the downgoing wave.
    pub outflow: f64,
    /// input − stored − losses.
    pub residual: f64,
}

/// A layer as the report draws it.
#[derive(Debug, Clone, Serialize)]
pub struct LayerView {
    /// Name.
    pub name: String,
    /// Depth of the top, m.
    pub top: f64,
    /// Depth of the bottom, m; infinite for the half-space.
    pub bottom: f64,
    /// Shear-wave speed at the reference frequency, m/s.
    pub vs: f64,
    /// Compressional-wave speed at the reference frequency, m/s.
    pub vp: f64,
    /// Density, kg/m³.
    pub rho: f64,
    /// Damping ratio D.
    pub damping: f64,
}

/// Everything the report page needs of a site-response run.
#[derive(Debug, Clone)]
pub struct SiteResponse {
    /// The scene's title.
    pub title: String,
    /// Step of every trace, s.
    pub dt: f64,
    /// Elapsed time of the first sample, s (0 unless the motion was led in).
    pub time_first: f64,
    /// Start of the record, ISO 8601 UTC; `None` when unknown.
    pub start: Option<String>,
    /// Layers from the surface down; the half-space last.
    pub layers: Vec<LayerView>,
    /// All recorded motions.
    pub traces: Vec<Trace>,
    /// Peak values with depth, one per active component.
    pub peaks: Vec<PeakProfile>,
    /// Transfer functions, surface/outcrop and surface/within for each active component.
    pub transfer: Vec<TransferFunction>,
    /// Depth–time sections, one per active component.
    pub sections: Vec<Section>,
    /// The energy ledger over time.
    pub ledger: Vec<LedgerRow>,
    /// The content of `summary.json`: the report's tables are made from it.
    pub summary: serde_json::Value,
}
