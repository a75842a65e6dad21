//! A plane wave along a bar of square elements, one element high, of a section; or of cubes, one element wide as well.
//!
//! Held so that only one component moves, and pushed at one end, a bar carries exactly the plane wave: P with z held
//! everywhere, SV with x held, SH with both. It is so long that nothing comes back while it is looked at.
//! The ratio of the spectra at two corners of elements is then the discrete solid's own transfer function over the
//! distance between them, at every frequency that the pulse holds, and not the end's.

use hati_coupling::Subdomain;
use hati_sem::SemError;
use hati_sem::mesh::{BoxLayer, LayeredBox};
use hati_sem::solid::{Execution, Ground, Material, Memory, Solid, Watch};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The component that moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wave {
    P,
    Sv,
    Sh,
}

impl Wave {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::P => "P",
            Self::Sv => "SV",
            Self::Sh => "SH",
        }
    }

    fn component(self) -> usize {
        match self {
            Self::P => 0,
            Self::Sv => 2,
            Self::Sh => 1,
        }
    }
}

/// A bar and how it is looked at.
pub(super) struct Bar {
    pub(super) dimension: usize,
    pub(super) wave: Wave,
    pub(super) order: usize,
    /// Edge of an element, m.
    pub(super) size: f64,
    pub(super) material: Material,
    pub(super) memory: Memory,
    /// Fastest speed in the bar, m/s.
    pub(super) speed: f64,
    /// Frequency of the pulse, Hz: a cosine under a bell.
    pub(super) centre: f64,
    /// Standard deviation of the bell, periods. The pulse's band is narrow, so that no wave is so short, or so near a gap
    /// between two branches, that it stays behind and is cut off.
    pub(super) bell: f64,
    /// Step over its limit.
    pub(super) part: f64,
    /// Elements from the end to the first place, and between the two places.
    pub(super) near: usize,
    pub(super) between: usize,
}

/// Standard deviations from the start to the middle of the pulse.
const DELAY: f64 = 6.5;

impl Bar {
    /// The step, s. The limit is that of the section, whose points may move in more ways than the wave does.
    pub(super) fn dt(&self) -> Result<f64, SemError> {
        Ok(self.part * Solid::<f64>::critical_step(&self.ground(3)?, 1e-3, Execution::default())?)
    }

    /// Spectrum far over spectrum near, at each frequency (Hz).
    pub(super) fn transfer(&self, frequencies: &[f64]) -> Result<Vec<Complex64>, SemError> {
        let far = self.near + self.between;
        let (dt, travel) = (self.dt()?, far as f64 * self.size / self.speed);
        // slow waves of a damped bar and the pulse's tail have passed by then
        let delay = DELAY * self.bell / self.centre;
        let duration = 1.15 * travel + 2.0 * delay;
        // what comes back from the far end must not reach the far place
        let elements = ((1.02 * self.speed * duration / self.size + far as f64) / 2.0).ceil() as usize + 4;
        let mut ground = self.ground(elements)?;
        let mut push = [0.0; 3];
        push[self.wave.component()] = 1.0;
        let forces = ground.traction("x_min", |_| push)?;
        let steps = (duration / dt) as usize;
        let pulse = |n: usize| {
            let periods = self.centre * (n as f64 * dt - delay);
            (TAU * periods).cos() * (-0.5 * (periods / self.bell).powi(2)).exp()
        };
        ground.add_load(forces, (0..steps).map(pulse).collect());
        let points: Vec<u32> = [self.near, far].map(|e| ground.numbering().element(e)[0]).to_vec();
        let mut solid = Solid::<f64>::new(&ground, dt, dt, Execution::default());
        let mut watch = Watch::new(&solid, &points);
        let mut spectra = vec![[Complex64::ZERO; 2]; frequencies.len()];
        for n in 0..steps {
            watch.before(&solid);
            solid.step();
            watch.after(&solid);
            for (f, sum) in frequencies.iter().zip(&mut spectra) {
                let turn = Complex64::from_polar(1.0, -TAU * f * n as f64 * dt);
                (0..2).for_each(|i| sum[i] += watch.velocity()[i][self.wave.component()] * turn);
            }
        }
        Ok(spectra.into_iter().map(|[near, far]| far / near).collect())
    }

    fn ground(&self, elements: usize) -> Result<Ground, SemError> {
        let name = self.material.name.clone();
        let layers = [BoxLayer { name, thickness: self.size, elements: 1 }];
        let mesh = LayeredBox {
            dimension: self.dimension,
            x: (0.0, elements as f64 * self.size),
            y: (0.0, self.size),
            layers: &layers,
            element_width: self.size,
            topography: None,
            moved_layers: 1,
            order: 1,
        }
        .mesh()?;
        let mut ground = Ground::new(mesh, self.order, std::slice::from_ref(&self.material))?;
        ground.set_memory(self.memory)?;
        (0..3).filter(|&c| c != self.wave.component()).for_each(|c| ground.hold_component(c));
        Ok(ground)
    }
}

/// The branch of a phase (rad) that lies nearest to an expected one.
pub(super) fn unwrapped(phase: f64, expected: f64) -> f64 {
    phase + TAU * ((expected - phase) / TAU).round()
}
