//! Everything that a run in two or three dimensions needs, decided.

use super::explain::{Facts, Notes};
use super::forces;
use super::mesh::{self, BoxSizes, FileMesh, MeshOptions, PlannedBoundary};
use super::rounding::{self, Rounding};
use super::sampling::{Rows, Sampling, auto_rows, step_for};
use super::sizes::{self, Frequencies, Points};
use super::sources::{self, Signal};
use super::symmetry;
use crate::outputs::wave::{Cells, Grid};
use crate::plan::{PlanError, Reason, STEP_MARGIN};
use hati_inputs::scene::{
    Auto, BoundaryKind, MaterialValues, MemoryVariables, OutputQuantity, Precision, Resolved, Scene,
};
use hati_sem::mesh::{Locator, Mesh, MeshReport, Resolution};
use hati_sem::solid::{Execution, Ground, Material, Memory, Probe, Solid, Support};
use std::sync::Arc;
use std::time::Duration;

/// Wall time between checkpoints where the scene leaves it open.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(600);
/// Relative tolerances of the critical step, tried in turn: a uniform mesh has a dense upper spectrum.
const STEP_TOLERANCES: [f64; 3] = [5e-3, 2e-2, 6e-2];

/// Points of the shear wave's length at `f_max` in a material.
#[derive(Debug, Clone, PartialEq)]
pub struct Reached {
    /// The material.
    pub material: String,
    /// Points that its largest element gives.
    pub points: f64,
    /// Points that the accuracy asks for.
    pub wanted: f64,
}

/// The element that bounds the step.
#[derive(Debug, Clone, PartialEq)]
pub struct Limiting {
    /// Its number.
    pub element: usize,
    /// Mean of its corners, m.
    pub centre: [f64; 3],
    /// Its material.
    pub material: String,
    /// Its longest extent, m.
    pub size: f64,
    /// Gmsh's tag, where a file gave the mesh.
    pub tag: Option<u64>,
}

/// A source with its place in the mesh.
#[derive(Debug, Clone)]
pub struct PlannedSource {
    /// Name.
    pub name: String,
    /// Where it acts: a force, a moment, or the centre of a traction; `None` of a uniform traction.
    pub position: Option<[f64; 3]>,
    /// Longest edge of the element that holds a force or a moment, m.
    pub element_size: Option<f64>,
}

/// A station with its place in the mesh.
#[derive(Debug, Clone)]
pub struct PlannedSensor {
    /// Name.
    pub name: String,
    /// Where it was asked for, m.
    pub asked: [f64; 3],
    /// Where it is.
    pub probe: Probe,
    /// What is written.
    pub quantities: Vec<OutputQuantity>,
}

/// `surface.nc` or the peak maps' surface.
#[derive(Debug, Clone)]
pub struct PlannedSurface {
    /// Boundary.
    pub boundary: String,
    /// Points and cells.
    pub cells: Cells,
    /// Points of the numbering, in the order of the cells' points.
    pub points: Vec<u32>,
    /// Rows.
    pub rows: Rows,
    /// Motions written: 0 displacement, 1 velocity, 2 acceleration.
    pub motions: Vec<usize>,
}

/// `volume.nc`.
#[derive(Debug, Clone)]
pub struct PlannedVolume {
    /// Points and cells.
    pub cells: Cells,
    /// Points of the numbering, in the order of the cells' points.
    pub points: Vec<u32>,
    /// Rows.
    pub rows: Rows,
    /// Motions written.
    pub motions: Vec<usize>,
}

/// `field.nc`.
#[derive(Debug, Clone)]
pub struct PlannedField {
    /// The grid.
    pub grid: Grid,
    /// Probe of every point; `None` outside the ground.
    pub probes: Vec<Option<Probe>>,
    /// Rows.
    pub rows: Rows,
    /// Motions written.
    pub motions: Vec<usize>,
}

/// Everything that a run needs.
#[derive(Debug, Clone)]
pub struct VolumePlan {
    /// Dimension, 2 or 3.
    pub dimension: usize,
    /// The ground with supports and loads.
    pub ground: Ground,
    /// Facts about the mesh.
    pub report: MeshReport,
    /// What holds on the boundaries.
    pub boundaries: Vec<PlannedBoundary>,
    /// The mesh's file, if it is one.
    pub file: Option<FileMesh>,
    /// Constants of the materials, in the mesh's order.
    pub materials: Vec<MaterialValues>,
    /// Frequencies.
    pub frequencies: Frequencies,
    /// Order and points per wavelength that were aimed at.
    pub resolution: Resolution,
    /// What each material reaches in its largest element.
    pub reached: Vec<Reached>,
    /// Mechanisms of damping, and the relative error of the modulus.
    pub mechanisms: (usize, f64),
    /// How memory variables are spread over the points.
    pub memory_variables: MemoryVariables,
    /// Precision of the run.
    pub precision: Precision,
    /// What single precision would leave, and why this precision.
    pub rounding: Rounding,
    /// Critical step, s.
    pub dt_critical: f64,
    /// Who bounds it.
    pub limiting: Limiting,
    /// Step and samples.
    pub sampling: Sampling,
    /// Elements whose metric is found in each way: affine, from corners, stored.
    pub metrics: [usize; 3],
    /// Sources.
    pub sources: Vec<PlannedSource>,
    /// Stations.
    pub sensors: Vec<PlannedSensor>,
    /// The top's peak maps and `surface.nc`.
    pub surface: Option<PlannedSurface>,
    /// `volume.nc`.
    pub volume: Option<PlannedVolume>,
    /// `field.nc`.
    pub field: Option<PlannedField>,
    /// Wall time between checkpoints.
    pub checkpoint_every: Duration,
    /// Threads.
    pub threads: usize,
    /// Accuracy asked for.
    pub accuracy: f64,
    /// Values with their reasons.
    pub reasons: Vec<Reason>,
    /// Values for `scene.resolved.toml`.
    pub resolved: Vec<Resolved>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// SHA-256 of the records that sources follow.
    pub record_sha256: Vec<String>,
    /// Whether anything moves along y: at dimension 2 only where a source pushes there.
    pub moves_y: bool,
}

/// Points from which a step takes long enough (some 0.3 ms) that threads gain more than they wait for each
/// other; below, a thread that the machine holds up for an instant costs more than the step.
pub(super) const PARALLEL_POINTS: usize = 20_000;

impl VolumePlan {
    /// Decides everything. `threads` serve the spectral bound and the run; they run in the current `rayon`
    /// pool. Ground of fewer than some 20 000 points stays on one.
    ///
    /// # Errors
    /// Whatever of the scene, its mesh and its records cannot be used; a step above the critical one; too little memory.
    pub fn new(scene: &Scene, threads: usize, options: &MeshOptions<'_>) -> Result<Self, PlanError> {
        let signals = sources::signals(scene)?;
        let frequencies = sizes::frequencies(scene, &signals);
        let file = mesh::read(scene, options)?;
        let values = scene.materials();
        let time = travel_time(scene, &values, file.as_ref().map(|f| &f.0));
        let highest = file.as_ref().map(|f| f.0.extent().1[2]);
        let (points, points_why) = sizes::points(scene, &values, &signals, &frequencies, time, highest)?;
        let resolution = points.resolution;
        let mut notes = Notes::default();
        let made = Made::new(scene, file, &values, &points)?;
        let asked = scene.discretisation.mechanisms;
        let mechanisms = sizes::mechanisms(asked, scene.accuracy, &values, &frequencies, time)?;
        let report = mesh::checked(&made.mesh, resolution.order, made.file.as_ref())?;
        let materials = in_order(&values, &made.mesh);
        let mut ground = assemble(scene, made.mesh, &values, &resolution, &frequencies, mechanisms.0)?;
        let memory_variables = spread(scene, &mut ground)?;
        let limiting = limiting(&ground, made.file.as_ref());
        let threads = if ground.numbering().nodes < PARALLEL_POINTS { 1 } else { threads };
        let asked = scene.discretisation.precision;
        let bound_in = asked.value().copied().unwrap_or(Precision::F32);
        let dt_critical = critical(&ground, bound_in, threads, &mut notes)?;
        let sampling = sampling(scene, dt_critical, &limiting, &frequencies, time)?;
        let (sources, moves_y) = load(scene, &mut ground, &signals, &sampling, &mut notes)?;
        let record_sha256 = signals.iter().filter_map(|s| Some(s.record.as_ref()?.sha256.clone())).collect();
        let mut plan = Self {
            dimension: scene.dimension(),
            reached: reached(&ground, &materials, &points),
            report,
            boundaries: mesh::kinds(scene, ground.mesh()),
            file: made.file,
            materials,
            frequencies,
            resolution,
            mechanisms,
            memory_variables,
            precision: asked.value().copied().unwrap_or(Precision::F32),
            rounding: Rounding::choose(asked, 0.0, 1.0, true, scene.accuracy),
            dt_critical,
            limiting,
            sampling,
            metrics: [0; 3],
            sources,
            sensors: sensors(scene, &ground, &mut notes)?,
            surface: super::fields::surface(scene, &ground, &frequencies, &sampling)?,
            volume: super::fields::volume(scene, &ground, &frequencies, &sampling)?,
            field: super::fields::grid(scene, &ground, &frequencies, &resolution, &sampling)?,
            checkpoint_every: checkpoint_every(scene),
            threads,
            accuracy: scene.accuracy,
            reasons: vec![],
            resolved: vec![],
            warnings: vec![],
            record_sha256,
            moves_y,
            ground,
        };
        plan.metrics = plan.count_metrics();
        plan.choose_precision(asked, &signals);
        let facts = Facts { points_why, points_alike: points.is_uniform(), sizes: made.sizes, time };
        plan.explain(scene, &facts, notes);
        Ok(plan)
    }

    /// Chooses the precision from what is written and how slow the sources are.
    fn choose_precision(&mut self, asked: Auto<Precision>, signals: &[Signal]) {
        let dt_critical = self.dt_critical;
        let Some(curvature) = rounding::curvature(signals, &self.sampling) else { return };
        let noise = rounding::noise(Precision::F32, curvature, self.sampling.steps(), dt_critical);
        let ratio = 0.5 * curvature.sqrt() * dt_critical;
        let fields = [
            self.volume.as_ref().map_or(&[][..], |v| &v.motions),
            self.field.as_ref().map_or(&[][..], |f| &f.motions),
        ];
        // a surface has its peak map of accelerations
        let accelerations = self.surface.is_some()
            || self.sensors.iter().any(|s| s.quantities.contains(&OutputQuantity::Acceleration))
            || fields.iter().any(|motions| motions.contains(&2));
        self.rounding = Rounding::choose(asked, noise, ratio, accelerations, self.accuracy);
        self.precision = self.rounding.precision;
    }

    /// Elements.
    pub fn elements(&self) -> usize {
        self.ground.mesh().len()
    }

    /// Points.
    #[allow(clippy::misnamed_getters)] // a numbering's nodes are the points of all elements
    pub fn points(&self) -> usize {
        self.ground.numbering().nodes
    }

    fn count_metrics(&self) -> [usize; 3] {
        let mut count = [0; 3];
        let mesh = self.ground.mesh();
        for element in 0..mesh.len() {
            count[hati_sem::solid::Metric::of(mesh, element) as usize] += 1;
        }
        count
    }
}

/// The mesh and where it came from.
struct Made {
    mesh: Mesh,
    file: Option<FileMesh>,
    sizes: Option<BoxSizes>,
}

impl Made {
    fn new(
        scene: &Scene,
        file: Option<(Mesh, FileMesh)>,
        values: &[MaterialValues],
        points: &Points,
    ) -> Result<Self, PlanError> {
        let resolution = &points.resolution;
        if let Some((mesh, file)) = file {
            super::cost::expect_memory(mesh.len() as f64, mesh.dimension, resolution.order, false)?;
            return Ok(Self { mesh, file: Some(file), sizes: None });
        }
        let sizes = mesh::box_sizes(scene, values, points)?;
        let elements: f64 = sizes.counts.iter().map(|n| *n as f64).product();
        super::cost::expect_memory(elements, scene.dimension(), resolution.order, true)?;
        Ok(Self { mesh: sizes.mesh(scene)?, file: None, sizes: Some(sizes) })
    }
}

/// The longest time that a wave may be followed, s: the run's, or that of the slowest wave across the domain.
fn travel_time(scene: &Scene, values: &[MaterialValues], mesh: Option<&Mesh>) -> f64 {
    let duration = scene.run.map_or(0.0, |r| r.duration);
    let slowest = values.iter().map(|m| m.vs).fold(f64::INFINITY, f64::min);
    let extent = match (mesh, &scene.domain) {
        (Some(mesh), _) => {
            let (min, max) = mesh.extent();
            (0..3).map(|i| max[i] - min[i]).collect()
        }
        (None, Some(domain)) => {
            let range = |r: Option<[f64; 2]>| r.map_or(0.0, |[a, b]| b - a);
            vec![range(domain.x), range(domain.y), scene.thicknesses().iter().sum()]
        }
        (None, None) => vec![],
    };
    let diagonal = extent.iter().map(|x| x * x).sum::<f64>().sqrt();
    (diagonal / slowest).min(duration)
}

fn in_order(values: &[MaterialValues], mesh: &Mesh) -> Vec<MaterialValues> {
    mesh.materials.iter().filter_map(|name| values.iter().find(|m| m.name == *name).cloned()).collect()
}

fn assemble(
    scene: &Scene,
    mesh: Mesh,
    values: &[MaterialValues],
    resolution: &Resolution,
    frequencies: &Frequencies,
    mechanisms: usize,
) -> Result<Ground, PlanError> {
    let mut materials = vec![];
    for m in values {
        materials.push(if m.damping == 0.0 && m.damping_p == 0.0 {
            Material::elastic(&m.name, m.rho, m.vp, m.vs)
        } else {
            let layer = sizes::layer(m, 1.0);
            Material::of_layer(&layer, frequencies.reference, frequencies.damping_band(), mechanisms)?
        });
    }
    let names: Vec<String> = mesh.boundaries.iter().map(|b| b.name.clone()).collect();
    let mut ground = Ground::new(mesh, resolution.order, &materials)?;
    for name in names {
        let support = match scene.boundary_kind(&name) {
            BoundaryKind::Free => continue,
            BoundaryKind::Fixed => Support::Fixed,
            BoundaryKind::Symmetry => Support::Symmetry,
            BoundaryKind::Absorbing => Support::Absorbing,
        };
        ground.support(&name, support)?;
    }
    Ok(ground)
}

/// Spreads the memory variables as the scene says.
fn spread(scene: &Scene, ground: &mut Ground) -> Result<MemoryVariables, PlanError> {
    let asked = scene.discretisation.memory_variables.value().copied().unwrap_or(MemoryVariables::Full);
    ground.set_memory(match asked {
        MemoryVariables::Full => Memory::Full,
        MemoryVariables::Coarse => Memory::Coarse,
    })?;
    Ok(asked)
}

fn limiting(ground: &Ground, file: Option<&FileMesh>) -> Limiting {
    let element = ground.limiting_element();
    Limiting {
        element,
        centre: ground.mesh().centre(element),
        material: ground.material(element).name.clone(),
        size: ground.mesh().size(element),
        tag: file.and_then(|f| f.tags.get(element).copied()),
    }
}

fn critical(
    ground: &Ground,
    precision: Precision,
    threads: usize,
    notes: &mut Notes,
) -> Result<f64, PlanError> {
    let execution = Execution { threads, ..Execution::default() };
    let mut outcome = Err(hati_sem::SemError::Dimension(0));
    for tolerance in STEP_TOLERANCES {
        // the bound of one precision serves both; f32 finds it in half the time
        outcome = match precision {
            Precision::F32 => Solid::<f32>::critical_step(ground, tolerance, execution),
            Precision::F64 => Solid::<f64>::critical_step(ground, tolerance, execution),
        };
        if outcome.is_ok() {
            notes.step_tolerance = tolerance;
            break;
        }
    }
    Ok(outcome?)
}

/// Steps and samples; a given step has to be stable.
fn sampling(
    scene: &Scene,
    dt_critical: f64,
    limiting: &Limiting,
    frequencies: &Frequencies,
    time: f64,
) -> Result<Sampling, PlanError> {
    let output = &scene.output;
    let asked = [
        output.surface.as_ref().map(|s| s.dt),
        output.volume.as_ref().map(|s| s.dt),
        output.field.as_ref().map(|s| s.dt),
    ];
    let closest = asked
        .iter()
        .flatten()
        .map(|dt| dt.value().copied().unwrap_or_else(|| auto_rows(frequencies)))
        .min_by(f64::total_cmp);
    let dt = match scene.discretisation.dt {
        Auto::Value(dt) if dt > dt_critical => {
            let (limited_by, safe) = (limiting.to_string(), STEP_MARGIN * dt_critical);
            return Err(PlanError::UnstableElement { dt, dt_critical, limited_by, safe });
        }
        Auto::Value(dt) => dt,
        Auto::Auto => {
            let most = sizes::accurate_step(scene.accuracy, frequencies, time).min(STEP_MARGIN * dt_critical);
            step_for(most, closest)
        }
    };
    let duration = scene.run.map_or(0.0, |r| r.duration);
    Ok(Sampling::new(dt, frequencies.content(), closest, duration))
}

/// Adds the sources; where they are, and whether anything moves along y.
fn load(
    scene: &Scene,
    ground: &mut Ground,
    signals: &[Signal],
    sampling: &Sampling,
    notes: &mut Notes,
) -> Result<(Vec<PlannedSource>, bool), PlanError> {
    let first = sources::shared_amplitudes(signals);
    let distinct = (0..signals.len()).filter(|&i| first[i] == i).count();
    super::cost::expect_amplitudes(sampling.steps(), distinct)?;
    let planes = symmetry::planes(scene, ground)?;
    let (mut planned, mut all) = (vec![], vec![]);
    {
        let locator = Locator::new(ground.mesh());
        for signal in signals {
            let made = forces::forces(ground, &locator, &planes, signal)?;
            notes.warnings.extend(made.warnings);
            notes.sources.extend(made.remark.map(|r| (signal.name.clone(), r)));
            planned.push(PlannedSource {
                name: signal.name.clone(),
                position: made.position,
                element_size: made.element.map(|e| longest_edge(ground.mesh(), e)),
            });
            all.push(made.forces);
        }
    }
    let steps = sampling.steps() as usize;
    let moves_y = ground.mesh().dimension == 3 || all.iter().flatten().any(|(_, f)| f[1] != 0.0);
    let mut amplitudes: Vec<Arc<Vec<f64>>> = vec![];
    for (i, (forces, signal)) in all.into_iter().zip(signals).enumerate() {
        amplitudes.push(if first[i] < i {
            Arc::clone(&amplitudes[first[i]])
        } else {
            Arc::new(signal.amplitude(sampling.dt, steps))
        });
        ground.add_shared_load(forces, Arc::clone(&amplitudes[i]));
    }
    Ok((planned, moves_y))
}

fn sensors(scene: &Scene, ground: &Ground, notes: &mut Notes) -> Result<Vec<PlannedSensor>, PlanError> {
    let locator = Locator::new(ground.mesh());
    let mut sensors = vec![];
    for sensor in scene.sensors() {
        let placed = |source| PlanError::Place {
            what: format!("station `{}`", sensor.name),
            source: Box::new(source),
        };
        let asked = forces::position(&locator, &sensor.at).map_err(placed)?;
        let probe = ground.probe(&locator, asked).map_err(placed)?;
        let on_side = |x: &f64| (1.0 - x.abs()).abs() < 1e-9;
        let local = &probe.local[..ground.mesh().dimension];
        let tensors = sensor.quantities.iter().any(|q| *q >= OutputQuantity::Strain);
        if tensors && local.iter().any(on_side) {
            let centre = ground.mesh().centre(probe.element);
            notes.remarks.push(format!(
                "station `{}` stands on a side between elements or on the surface: strain and stress are those of the \
                 element around {}",
                sensor.name,
                super::explain::place(centre, ground.mesh().dimension)
            ));
        }
        sensors.push(PlannedSensor { name: sensor.name, asked, probe, quantities: sensor.quantities });
    }
    Ok(sensors)
}

/// Points of a shear wave's length at `f_max` in the largest element of each material.
fn reached(ground: &Ground, materials: &[MaterialValues], points: &Points) -> Vec<Reached> {
    let mesh = ground.mesh();
    let mut largest = vec![0.0_f64; materials.len()];
    for element in 0..mesh.len() {
        let slot = &mut largest[mesh.material[element] as usize];
        *slot = slot.max(longest_edge(mesh, element));
    }
    let of = |(m, size): (&MaterialValues, f64)| Reached {
        material: m.name.clone(),
        points: points.resolution.points_in(size, m.vs),
        wanted: points.wanted(&m.name),
    };
    materials.iter().zip(largest).map(of).collect()
}

/// Longest edge between corners, m.
fn longest_edge(mesh: &Mesh, element: usize) -> f64 {
    let corners: Vec<[f64; 3]> = mesh.corners(element).map(|n| mesh.nodes[n as usize]).collect();
    let mut longest = 0.0_f64;
    for (i, a) in corners.iter().enumerate() {
        for axis in 0..mesh.dimension {
            if i >> axis & 1 == 0 {
                let b = corners[i | 1 << axis];
                longest = longest.max((0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt());
            }
        }
    }
    longest
}

fn checkpoint_every(scene: &Scene) -> Duration {
    let given = scene.output.checkpoint.and_then(|c| c.every.value().copied());
    given.map_or(CHECKPOINT_EVERY, Duration::from_secs_f64)
}
