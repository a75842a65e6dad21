//! The energy balance closes to round-off, with loads, supports, dashpots and memory.

use crate::{materials, small_box};
use hati_coupling::{Ledger, Subdomain};
use hati_sem::mesh::Locator;
use hati_sem::solid::{Execution, Ground, Memory, Real, Solid, Support};

fn closing<T: Real>(dimension: usize, memory: Option<Memory>) -> (f64, Ledger) {
    let mesh = small_box(dimension, 1, true);
    let mut ground = Ground::new(mesh, 4, &materials(memory.is_some())).unwrap();
    ground.set_memory(memory.unwrap_or_default()).unwrap();
    ground.support("x_min", Support::Symmetry).unwrap();
    ground.support("x_max", Support::Absorbing).unwrap();
    ground.support("bottom", Support::Absorbing).unwrap();
    if dimension == 3 {
        ground.support("y_min", Support::Fixed).unwrap();
    }
    let place = if dimension == 3 { [1.3, 0.2, -0.7] } else { [1.3, 0.0, -0.7] };
    let forces = {
        let locator = Locator::new(ground.mesh());
        ground.point_force(&locator, place, [1.0, -0.6, 0.8]).unwrap()
    };
    let dt = 0.9 * Solid::<f64>::critical_step(&ground, 1e-3, Execution::default()).unwrap();
    let tau = |i: usize| (i as f64 * dt - 1.0) * 3.0;
    let steps = (6.0 / dt) as usize;
    ground.add_load(
        forces,
        (0..steps).map(|i| (1.0 - 2.0 * tau(i).powi(2)) * (-tau(i).powi(2)).exp()).collect(),
    );
    let mut solid = Solid::<T>::new(&ground, dt, dt, Execution::default());
    let mut ledger = Ledger::start(&solid.energies());
    for _ in 0..steps {
        solid.step();
        ledger.book(&solid.energies());
    }
    (ledger.closing_error(), ledger)
}

#[test]
fn the_ledger_closes_to_round_off() {
    for dimension in [2, 3] {
        for memory in [None, Some(Memory::Full), Some(Memory::Coarse)] {
            let (error, ledger) = closing::<f64>(dimension, memory);
            assert!(error < 1e-12, "f64, D = {dimension}, {memory:?}: {error:e} {ledger:?}");
            assert!(ledger.last.input > 0.0 && ledger.last.outflow > 0.05 * ledger.last.input, "{ledger:?}");
            assert_eq!(memory.is_some(), ledger.last.viscous > 0.02 * ledger.last.input, "{ledger:?}");
            let (error, ledger) = closing::<f32>(dimension, memory);
            assert!(error < 2e-5, "f32, D = {dimension}, {memory:?}: {error:e} {ledger:?}");
        }
    }
}
