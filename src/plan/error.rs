use hati_inputs::InputError;
use hati_sem::SemError;

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
    /// A scene with a domain, for a verb that knows columns alone.
    #[error(
        "domain.dimension = {dimension}: this is made for columns; scenes in two or three dimensions are planned and run with `hati plan` and `hati run`"
    )]
    NotBuilt {
        /// Dimension of the domain.
        dimension: usize,
    },
    /// Names of a mesh and of the scene do not fit together.
    #[error("{place}: {what} `{name}` is not in {}; it has {present:?}\n  help: {help}", path.display())]
    MeshName {
        /// Where it stands in the scene.
        place: String,
        /// Material or boundary.
        what: &'static str,
        /// The name.
        name: String,
        /// The mesh.
        path: Box<std::path::Path>,
        /// Names that the mesh has.
        present: Box<[String]>,
        /// What to do.
        help: &'static str,
    },
    /// A material of the mesh for which the scene gives nothing.
    #[error(
        "{}: material `{name}` has no [[material]] in the scene, which gives {given:?}\n  help: add [[material]] with name = \"{name}\"", path.display()
    )]
    MaterialMissing {
        /// The mesh.
        path: std::path::PathBuf,
        /// The name.
        name: String,
        /// Names that the scene gives.
        given: Vec<String>,
    },
    /// A place of the scene that cannot be used.
    #[error("{what}: {source}")]
    Place {
        /// Which one, in the scene's words.
        what: String,
        /// Why.
        source: Box<SemError>,
    },
    /// A plane of symmetry that is none.
    #[error(
        "domain.boundary.{boundary} = \"symmetry\": its sides do not lie in one plane (normals are up to {angle:.2e} degrees off their mean, points up to {distance:.2e} m off the mean plane)\n  help: name each plane in a physical group of its own, or give its nodes' coordinates more digits"
    )]
    BentSymmetry {
        /// The boundary.
        boundary: String,
        /// Largest angle between a normal and their mean, degrees.
        angle: f64,
        /// Largest distance of a point from the mean plane, m.
        distance: f64,
    },
    /// A source that moves nothing.
    #[error("source `{name}` does nothing: {why}\n  help: {help}")]
    NoEffect {
        /// Its name.
        name: String,
        /// Why.
        why: String,
        /// What to do.
        help: String,
    },
    /// The sources' time functions do not fit into memory.
    #[error(
        "the run takes {steps:.3e} steps, and {functions} time functions of sources at each need {needed_mb:.0} MB of memory; {available_mb:.0} MB are free\n  help: shorten run.duration, give a larger discretisation.dt, or let sources share a wavelet"
    )]
    MemoryOfSources {
        /// Need, MB.
        needed_mb: f64,
        /// Free, MB.
        available_mb: f64,
        /// Steps of the run.
        steps: f64,
        /// Time functions that differ.
        functions: usize,
    },
    /// A source on a plane of symmetry that is not its own mirror image.
    #[error(
        "source `{source_name}` stands on the plane of symmetry `{boundary}` (normal {normal:?}), where its {component} cannot be: mirrored, it is its own opposite\n  help: set it to 0, move the source off the plane, or model both sides of the plane in place of domain.boundary.{boundary} = \"symmetry\""
    )]
    AcrossSymmetry {
        /// The source.
        source_name: String,
        /// The plane.
        boundary: String,
        /// Its normal.
        normal: [f64; 3],
        /// What crosses it, with its value.
        component: String,
    },
    /// The given step is too long for the ground in two or three dimensions.
    #[error(
        "discretisation.dt = {dt:.4e} s is unstable: the critical step is {dt_critical:.4e} s, bounded by {limited_by}\n  help: give dt ≤ {safe:.3e} s, or leave it to \"auto\""
    )]
    UnstableElement {
        /// The given step, s.
        dt: f64,
        /// Critical step, s.
        dt_critical: f64,
        /// The element that bounds it.
        limited_by: String,
        /// A step with margin, s.
        safe: f64,
    },
    /// The ground in two or three dimensions does not fit into memory.
    #[error(
        "the run needs about {needed_mb:.0} MB of memory, and {available_mb:.0} MB are free: {elements:.3e} elements of order {order}\n  help: {help}"
    )]
    MemoryOfElements {
        /// Need, MB.
        needed_mb: f64,
        /// Free, MB.
        available_mb: f64,
        /// Elements.
        elements: f64,
        /// Their order.
        order: usize,
        /// What to do.
        help: String,
    },
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
    /// More elements than a column should have.
    #[error(
        "a column of {elements} elements is above the limit of {limit}: layer `{layer}` takes {in_layer} of them for {f_max:.3} Hz\n  help: make the layer thinner or motion.band narrower, or give fewer discretisation.elements"
    )]
    TooManyElements {
        /// Elements needed.
        elements: usize,
        /// The limit.
        limit: usize,
        /// Layer with most elements.
        layer: String,
        /// Its elements.
        in_layer: usize,
        /// Upper end of the band, Hz.
        f_max: f64,
    },
    /// The run does not fit into memory.
    #[error(
        "the run needs about {needed_mb:.0} MB of memory, and {available_mb:.0} MB are free: {steps} steps, {points} points, {samples} samples\n  help: shorten the motion, give fewer stations or a wider output.field_spacing, or ask for less accuracy"
    )]
    Memory {
        /// Need, MB.
        needed_mb: f64,
        /// Free, MB.
        available_mb: f64,
        /// Solver steps.
        steps: usize,
        /// Points.
        points: usize,
        /// Samples.
        samples: usize,
    },
    /// Deconvolution would return nothing but round-off.
    #[error(
        "motion.kind = \"surface\": the column passes only 1/{amplification:.1e} of the base's motion at some frequency of the band, so the motion at depth cannot be found from the surface's\n  help: end motion.band below {f_safe:.2} Hz, or reduce damping or depth"
    )]
    Deconvolution {
        /// Largest amplification in the band.
        amplification: f64,
        /// Frequency below which it stays under 1e3, Hz.
        f_safe: f64,
    },
    /// The search had nothing to choose from.
    #[error("no discretisation could be formed: check discretisation.order and discretisation.elements")]
    NoCandidate,
}

impl PlanError {
    /// Whether the machine's memory is too small for what is asked, and nothing is wrong with the scene itself.
    pub fn is_memory(&self) -> bool {
        matches!(self, Self::Memory { .. } | Self::MemoryOfElements { .. } | Self::MemoryOfSources { .. })
    }
}
