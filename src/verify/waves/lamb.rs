//! Lamb's problem: a vertical force on a half-space, a quarter of it between two planes of symmetry.

use hati_coupling::Subdomain;
use hati_sem::SemError;
use hati_sem::mesh::{BoxLayer, LayeredBox, Locator, Mesh};
use hati_sem::solid::{Execution, Ground, Material, Real, Solid, Support, Watch};
use std::f64::consts::PI;

/// Radial and downward motion at each distance.
type Motions = [[Vec<f64>; 2]; 3];

/// Distances of the receivers from the force, m.
pub const LAMB_DISTANCES: [f64; 3] = [10.0, 20.0, 40.0];
/// Instants per second at which records are compared.
pub(super) const RATE: f64 = 256.0;
/// Shear-wave speed, m/s, density, kg/m³, force, N: those of the reference tables. Poisson's ratio is 1/4.
const VS: f64 = 200.0;
const RHO: f64 = 1800.0;
const FORCE: f64 = 1e6;
/// Standard deviation of the spread force, m.
const SIGMA: f64 = 0.5;

/// How the force enters the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Footprint {
    /// At one point.
    Point,
    /// As a Gaussian traction of standard deviation 0.5 m, by the sides' own quadrature: elements at the
    /// source have to resolve it.
    Gaussian,
}

/// Discretisation of Lamb's problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LambModel {
    /// Polynomial order.
    pub order: usize,
    /// How the force enters.
    pub footprint: Footprint,
    /// Width of the element at the source, m.
    pub width_at_source: f64,
    /// Width that elements tend to away from it, m.
    pub width: f64,
    /// Number of elements over which the width grows by all but 1/e of the way.
    pub growth: f64,
    /// Least side of the quarter box, m; its outer sides are dashpots.
    pub side: f64,
    /// Step over the critical step.
    pub step_share: f64,
    /// Instant of the end, s.
    pub end: f64,
}

/// What a [`LambModel`] gives.
#[derive(Debug, Clone, PartialEq)]
pub struct LambRecord {
    /// Displacement at instants k/256 s, m: distance, then radial outward and vertical downward.
    pub displacement: [[Vec<f64>; 2]; 3],
    /// Force over the asked one.
    pub force_share: f64,
    /// Number of elements.
    pub elements: usize,
    /// Step, s.
    pub dt: f64,
    /// Number of steps.
    pub steps: usize,
    /// Processor time of the steps, s.
    pub cpu_seconds: f64,
}

/// Ricker pulse of 10 Hz centred at 0.15 s, by its phase `a` = (π f (t − t₀))², and its slope.
fn ricker(t: f64) -> (f64, f64) {
    let (b, x) = ((PI * 10.0).powi(2), t - 0.15);
    let a = b * x * x;
    let bell = (-a).exp();
    ((1.0 - 2.0 * a) * bell, -2.0 * b * x * (3.0 - 2.0 * a) * bell)
}

/// Vertical displacement on the surface, m downward, under a point force, after Pekeris (1955) at Poisson's
/// ratio 1/4: response $w = F G(\tau)/(32\pi\mu r)$ to a step, $\tau = v_s t/r$, convolved with the pulse's slope.
///
/// The root's singularity at the Rayleigh wave goes with $\tau = \gamma\sin\vartheta$; after it the response
/// is the static one, whose share is the pulse itself. Error of the quadrature below 1e-8 of the peak.
pub fn lamb_closed_form(distance: f64, t: f64) -> f64 {
    let root3 = 3.0_f64.sqrt();
    let gamma2 = 0.25 * (3.0 + root3);
    let (gamma, high, low) = (gamma2.sqrt(), 3.0 * root3 + 5.0, 3.0 * root3 - 5.0);
    let scale = distance / VS;
    let before_s = |q: f64| {
        let g = 6.0 - root3 / (q * q - 0.25).sqrt() - (high / (gamma2 - q * q)).sqrt()
            + (low / (q * q + 0.25 * root3 - 0.75)).sqrt();
        g * ricker(t - q * scale).1
    };
    let before_rayleigh = |angle: f64| {
        2.0 * (6.0 * gamma * angle.cos() - high.sqrt()) * ricker(t - gamma * angle.sin() * scale).1
    };
    let varying =
        integral(1.0 / root3, 1.0, before_s) + integral((1.0 / gamma).asin(), 0.5 * PI, before_rayleigh);
    FORCE / (32.0 * PI * RHO * VS * VS * distance) * (varying * scale + 12.0 * ricker(t - gamma * scale).0)
}

/// Gauss's rule of five points in sixty cells.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    const CELLS: usize = 60;
    let rule = [
        (0.0, 0.568888888888889),
        (0.538469310105683, 0.478628670499366),
        (-0.538469310105683, 0.478628670499366),
        (0.906179845938664, 0.236926885056189),
        (-0.906179845938664, 0.236926885056189),
    ];
    let half = 0.5 * (to - from) / CELLS as f64;
    let cell = |i: usize| {
        let middle = from + half * (2 * i + 1) as f64;
        rule.iter().map(|&(x, w)| w * f(middle + half * x)).sum::<f64>()
    };
    half * (0..CELLS).map(cell).sum::<f64>()
}

impl LambModel {
    /// Elements along an edge, and the mesh: widths grow smoothly away from the source along each axis.
    fn mesh(&self) -> Result<Mesh, SemError> {
        let spread = (self.width - self.width_at_source) * self.growth;
        let place = |i: f64| self.width * i - spread * (1.0 - (-i / self.growth).exp());
        let mut count = 1;
        while place(count as f64) < self.side * (1.0 - 1e-9) {
            count += 1;
        }
        let edge = count as f64;
        let layers = [BoxLayer { name: "soil".into(), thickness: edge, elements: count }];
        let mut mesh = LayeredBox {
            dimension: 3,
            x: (0.0, edge),
            y: (0.0, edge),
            layers: &layers,
            element_width: 1.0,
            topography: None,
            moved_layers: 1,
            order: 1,
        }
        .mesh()?;
        mesh.deform(|[x, y, z]| [place(x), place(y), -place(-z)]);
        Ok(mesh)
    }

    /// Forces per unit of the pulse on the quarter.
    fn forces(&self, ground: &Ground) -> Result<Vec<(u32, [f64; 3])>, SemError> {
        match self.footprint {
            Footprint::Point => {
                ground.point_force(&Locator::new(ground.mesh()), [0.0; 3], [0.0, 0.0, -0.25 * FORCE])
            }
            Footprint::Gaussian => ground.traction("top", |[x, y, _]| {
                let pressure = FORCE / (2.0 * PI * SIGMA * SIGMA);
                [0.0, 0.0, -pressure * (-(x * x + y * y) / (2.0 * SIGMA * SIGMA)).exp()]
            }),
        }
    }

    /// Runs the model in precision `T` on one thread; `vs_factor` is 1 but for tests of the test.
    pub fn run<T: Real>(&self, vs_factor: f64) -> Result<LambRecord, SemError> {
        let vs = VS * vs_factor;
        let soil = Material::elastic("soil", RHO, 3.0_f64.sqrt() * vs, vs);
        let mut ground = Ground::new(self.mesh()?, self.order, &[soil])?;
        for (boundary, support) in [
            ("x_min", Support::Symmetry),
            ("y_min", Support::Symmetry),
            ("x_max", Support::Absorbing),
            ("y_max", Support::Absorbing),
            ("bottom", Support::Absorbing),
        ] {
            ground.support(boundary, support)?;
        }
        let forces = self.forces(&ground)?;
        let force_share = forces.iter().map(|f| f.1[2]).sum::<f64>() / (-0.25 * FORCE);
        let limit = Solid::<f64>::critical_step(&ground, 1e-2, Execution::default())?;
        let dt = self.step_share * limit;
        let steps = (self.end / dt) as usize + 3;
        ground.add_load(forces, (0..steps).map(|i| ricker(i as f64 * dt).0).collect());
        let solid = Solid::<T>::new(&ground, dt, limit, Execution::default());
        let (displacement, cpu_seconds) = record(&ground, solid, steps)?;
        let displacement = displacement.map(|pair| pair.map(|u| resample(&u, dt, self.end)));
        Ok(LambRecord { displacement, force_share, elements: ground.mesh().len(), dt, steps, cpu_seconds })
    }
}

/// Radial and downward displacement at every kick.
fn record<T: Real>(ground: &Ground, mut solid: Solid<T>, steps: usize) -> Result<(Motions, f64), SemError> {
    let locator = Locator::new(ground.mesh());
    let mut probes = vec![];
    let mut points = vec![];
    for r in LAMB_DISTANCES {
        let probe = ground.probe(&locator, [r, 0.0, 0.0])?;
        let first = points.len();
        points.extend(probe.weights.iter().map(|w| w.0));
        probes.push((probe, first));
    }
    let mut watch = Watch::new(&solid, &points);
    let mut displacement: [[Vec<f64>; 2]; 3] = Default::default();
    let begin = cpu_seconds();
    for _ in 0..steps {
        watch.before(&solid);
        solid.step();
        watch.after(&solid);
        for ((probe, first), kept) in probes.iter().zip(&mut displacement) {
            let u = watch.at(probe, *first).displacement;
            kept[0].push(u[0]);
            kept[1].push(-u[2]);
        }
    }
    Ok((displacement, cpu_seconds() - begin))
}

/// Values at k/256 s by cubics through four samples.
fn resample(samples: &[f64], dt: f64, end: f64) -> Vec<f64> {
    let at = |t: f64| {
        let place = t / dt;
        let k = (place as usize).clamp(1, samples.len() - 3);
        let x = place - k as f64;
        let y = &samples[k - 1..k + 3];
        -x * (x - 1.0) * (x - 2.0) / 6.0 * y[0] + (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0 * y[1]
            - (x + 1.0) * x * (x - 2.0) / 2.0 * y[2]
            + (x + 1.0) * x * (x - 1.0) / 6.0 * y[3]
    };
    (0..=(end * RATE) as usize).map(|k| at(k as f64 / RATE)).collect()
}

/// Largest difference over the record over the peak of the reference's whole record.
pub(super) fn difference(found: &[f64], reference: &[f64]) -> f64 {
    let peak = reference.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let gaps = found.iter().zip(reference).map(|(a, b)| (a - b).abs());
    // max() would pass over a value that is not a number
    gaps.fold(0.0_f64, |m, gap| if gap.is_nan() { f64::INFINITY } else { m.max(gap) }) / peak
}

/// Time that the processor gave this thread, s; the clock's where the system does not tell.
fn cpu_seconds() -> f64 {
    #[cfg(target_os = "linux")]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    }
    #[cfg(not(target_os = "linux"))]
    {
        use std::time::Instant;
        static BEGIN: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
        BEGIN.get_or_init(Instant::now).elapsed().as_secs_f64()
    }
}
