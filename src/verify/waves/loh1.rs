//! LOH.1: a double couple under a layer over a half-space, a quarter of it between planes of antisymmetry.

use hati_coupling::Subdomain;
use hati_sem::SemError;
use hati_sem::mesh::{BoxLayer, LayeredBox, Locator};
use hati_sem::solid::{Execution, Ground, Material, Real, Solid, Support, Watch};

/// Instants per second of the reference table.
pub const LOH1_RATE: usize = 64;
/// Where the table's receiver stands, m.
const RECEIVER: [f64; 3] = [600.0, 800.0, 0.0];
const SOURCE: [f64; 3] = [0.0, 0.0, -2000.0];
const MOMENT: f64 = 1e18;

/// Discretisation of LOH.1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loh1Model {
    /// Polynomial order.
    pub order: usize,
    /// Greatest width of an element, m.
    pub width: f64,
    /// Greatest height of an element in the layer and below it, m.
    pub heights: [f64; 2],
    /// Horizontal sides of the quarter box, m.
    pub side: f64,
    /// Depth of the box, m.
    pub depth: f64,
    /// Greatest step over the critical step; the step divides the table's.
    pub step_share: f64,
    /// Instant of the end, s.
    pub end: f64,
    /// Threads.
    pub threads: usize,
}

/// What a [`Loh1Model`] gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Loh1Record {
    /// Velocity at instants k/64 s, m/s: radial, transverse towards increasing azimuth from x to y, down.
    pub velocity: [Vec<f64>; 3],
    /// Number of elements.
    pub elements: usize,
    /// Step, s.
    pub dt: f64,
    /// Number of steps.
    pub steps: usize,
}

/// The moment over its final value: rate a Gaussian of 0.05 s centred at 0.3 s, so an error function,
/// here by the trapezoidal rule, which is exact to round-off for a Gaussian that is resolved.
fn moment_history(dt: f64, steps: usize) -> Vec<f64> {
    const FINER: usize = 8;
    let (sigma, centre, fine) = (0.05, 0.3, dt / FINER as f64);
    let rate = |t: f64| {
        let x = (t - centre) / sigma;
        (-0.5 * x * x).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt())
    };
    let mut sum = 0.0;
    let mut before = rate(0.0);
    let mut history = vec![0.0];
    for i in 1..steps * FINER {
        let now = rate(i as f64 * fine);
        sum += 0.5 * fine * (before + now);
        before = now;
        if i % FINER == 0 {
            history.push(sum);
        }
    }
    history
}

impl Loh1Model {
    /// The quarter with its supports. On the planes x = 0 and y = 0 the double couple moves points only
    /// across the plane.
    fn ground(&self, vs_factor: f64) -> Result<Ground, SemError> {
        let layers = [
            BoxLayer::with_height("layer", 1000.0, self.heights[0]),
            BoxLayer::with_height("rock", self.depth - 1000.0, self.heights[1]),
        ];
        let mesh = LayeredBox {
            dimension: 3,
            x: (0.0, self.side),
            y: (0.0, self.side),
            layers: &layers,
            element_width: self.width,
            topography: None,
            moved_layers: 1,
            order: 1,
        }
        .mesh()?;
        let materials = [
            Material::elastic("layer", 2600.0, 4000.0, 2000.0 * vs_factor),
            Material::elastic("rock", 2700.0, 6000.0, 3464.0),
        ];
        let mut ground = Ground::new(mesh, self.order, &materials)?;
        for (boundary, support) in [
            ("x_min", Support::Antisymmetry),
            ("y_min", Support::Antisymmetry),
            ("x_max", Support::Absorbing),
            ("y_max", Support::Absorbing),
            ("bottom", Support::Absorbing),
        ] {
            ground.support(boundary, support)?;
        }
        Ok(ground)
    }

    /// Runs the model in precision `T`; `vs_factor`, on the layer, is 1 but for tests of the test.
    pub fn run<T: Real>(&self, vs_factor: f64) -> Result<Loh1Record, SemError> {
        let execution = Execution { threads: self.threads, ..Execution::default() };
        let mut ground = self.ground(vs_factor)?;
        let (forces, probe) = {
            let locator = Locator::new(ground.mesh());
            // a quarter: each of the four images takes up its own share of the virtual work M : ε
            let m = 0.25 * MOMENT;
            let forces = ground.moment(&locator, SOURCE, [[0.0, m, 0.0], [m, 0.0, 0.0], [0.0; 3]])?;
            (forces, ground.probe(&locator, RECEIVER)?)
        };
        let limit = Solid::<f64>::critical_step(&ground, 1e-2, execution)?;
        let interval = 1.0 / LOH1_RATE as f64;
        let substeps = (interval / (self.step_share * limit)).ceil() as usize;
        let dt = interval / substeps as f64;
        let steps = (self.end * LOH1_RATE as f64) as usize * substeps + 1;
        ground.add_load(forces, moment_history(dt, steps));
        let mut solid = Solid::<T>::new(&ground, dt, limit, execution);
        let points: Vec<u32> = probe.weights.iter().map(|w| w.0).collect();
        let mut watch = Watch::new(&solid, &points);
        let mut velocity: [Vec<f64>; 3] = Default::default();
        let away = (RECEIVER[0].hypot(RECEIVER[1])).recip();
        let (cosine, sine) = (RECEIVER[0] * away, RECEIVER[1] * away);
        for step in 0..steps {
            let wanted = step % substeps == 0;
            if wanted {
                watch.before(&solid);
            }
            solid.step();
            if wanted {
                watch.after(&solid);
                let [vx, vy, vz] = watch.at(&probe, 0).velocity;
                velocity[0].push(cosine * vx + sine * vy);
                velocity[1].push(-sine * vx + cosine * vy);
                velocity[2].push(-vz);
            }
        }
        Ok(Loh1Record { velocity, elements: ground.mesh().len(), dt, steps })
    }
}
