//! Both sides of the solid's critical step.

use crate::verify::{CaseResult, Check, twist};
use hati_coupling::Subdomain;
use hati_sem::SemError;
use hati_sem::mesh::{BoxLayer, LayeredBox, Mesh};
use hati_sem::soil::Layer;
use hati_sem::solid::{Execution, Ground, Material, Memory, Real, Solid, Support};

/// Velocities that the rough start cannot reach while stable, m/s.
const BOUNDED: f64 = 1e3;

/// One model on both sides of its limit.
#[derive(Debug, Clone, Copy)]
struct Model {
    dimension: usize,
    order: usize,
    deformed: bool,
    /// Elastic without.
    memory: Option<Memory>,
    supported: bool,
}

impl Model {
    fn name(&self) -> String {
        let word = |is: bool, yes: &'static str, no: &'static str| if is { yes } else { no };
        format!(
            "D = {}, N = {}, {}, {}, {}",
            self.dimension,
            self.order,
            word(self.deformed, "deformed", "affine"),
            match self.memory {
                None => "elastic",
                Some(Memory::Full) => "damped",
                Some(Memory::Coarse) => "coarsely damped",
            },
            word(self.supported, "supported", "free")
        )
    }

    /// Two layers of two by one elements (by two at D = 3).
    fn mesh(&self) -> Result<Mesh, SemError> {
        let layer = |name: &str, thickness| BoxLayer { name: name.into(), thickness, elements: 1 };
        let layers = [layer("soft", 1.1), layer("stiff", 0.9)];
        let mut mesh = LayeredBox {
            dimension: self.dimension,
            x: (0.0, 2.0),
            y: (0.0, 2.0),
            layers: &layers,
            element_width: 1.0,
            topography: None,
            moved_layers: 1,
            order: 1,
        }
        .mesh()?;
        if self.deformed {
            // a bend alone would leave the outer elements of so small a box as they are
            mesh.deform(|[x, y, z]| {
                let bump = 0.12 * (1.9 * x + 0.4 + 0.8 * y).sin() * (1.3 * z).cos();
                [x + 0.5 * bump, if self.dimension == 3 { y - 0.7 * bump } else { y }, z + bump]
            });
        }
        Ok(mesh)
    }

    fn ground(&self) -> Result<Ground, SemError> {
        let layer = |name: &str, vs: f64, damping: f64| Layer {
            name: name.into(),
            thickness: 1.0,
            vs,
            vp: 2.2 * vs,
            rho: 1900.0,
            damping_s: damping,
            damping_p: damping,
        };
        let materials =
            [layer("soft", 150.0, 0.05), layer("stiff", 260.0, 0.02)].map(|l| match self.memory {
                Some(_) => Material::of_layer(&l, 20.0, (4.0, 100.0), 3),
                None => Ok(Material::elastic(&l.name, l.rho, l.vp, l.vs)),
            });
        let materials = materials.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut ground = Ground::new(self.mesh()?, self.order, &materials)?;
        ground.set_memory(self.memory.unwrap_or_default())?;
        if self.supported {
            ground.support("x_min", Support::Symmetry)?;
            ground.support("x_max", Support::Absorbing)?;
            ground.support(
                "bottom",
                if self.order.is_multiple_of(2) { Support::Fixed } else { Support::Absorbing },
            )?;
        }
        Ok(ground)
    }

    /// Largest velocity of a point after `steps` from a rough start of 1 m/s.
    fn growth<T: Real>(ground: &Ground, dt: f64, steps: usize) -> f64 {
        let mut solid = Solid::<T>::new(ground, dt, dt, Execution::default());
        let mut seed = 1_u64;
        let rough = std::cell::RefCell::new(move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        });
        solid.set_motion(ground, |_| ([0.0; 3], std::array::from_fn(|_| (rough.borrow_mut())())));
        (0..steps).for_each(|_| solid.step());
        solid.fastest_point().0
    }

    fn check<T: Real>(&self, twist: f64) -> CaseResult {
        const CASE: &str = "solid-step-bound";
        let ground = self.ground()?;
        let limit = Solid::<T>::critical_step(&ground, 1e-3, Execution::default())?;
        let below = Self::growth::<T>(&ground, 0.999 * twist * limit, 2000);
        let above = Self::growth::<T>(&ground, 1.01 / twist * limit, 600);
        let check = |word: &str, value: f64, pass: bool| {
            let quantity = format!("{}, {}: m/s {word}", self.name(), T::NAME);
            let error = if pass { 0.0 } else { f64::INFINITY };
            Check { case: CASE, quantity, value, reference: BOUNDED, error, limit: LIMIT, pass }
        };
        Ok(vec![
            check("after 2000 steps at 0.999 of the limit stays below", below, below < BOUNDED),
            check("at 1.01 of the limit grows above", above, above.is_nan() || above > BOUNDED),
        ])
    }
}

const LIMIT: f64 = 1e-2;

/// Stable at 0.999 of the limit by Lanczos and unstable at 1.01, N = 1…8, D = 2 and 3. Twist: the limit.
pub(in crate::verify) fn solid_step_bound(twisted: bool) -> CaseResult {
    let twist = twist(twisted, LIMIT);
    let mut checks = vec![];
    for dimension in [2, 3] {
        for order in 1..=8 {
            for case in 0..12 {
                let [deformed, supported] = [0, 1].map(|bit| case >> bit & 1 == 1);
                let memory = [None, Some(Memory::Full), Some(Memory::Coarse)][case / 4];
                let model = Model { dimension, order, deformed, memory, supported };
                checks.extend(model.check::<f64>(twist)?);
                if order.is_multiple_of(4) && case % 3 == 0 {
                    checks.extend(model.check::<f32>(twist)?);
                }
            }
        }
    }
    Ok(checks)
}
