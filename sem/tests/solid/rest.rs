//! A ground at rest, and what a wave front sends ahead of itself.

use crate::materials;
use hati_coupling::{State, Subdomain};
use hati_sem::mesh::{BoxLayer, LayeredBox, Locator};
use hati_sem::solid::{Execution, Ground, Solid};

/// Numbers below f32's smallest normal one slow a processor down tenfold. A bar of 40 elements, shaken at one end
/// by a force that swells from next to nothing, holds none of them where it is elastic and hardly any where it is
/// damped (a small strain's small share), neither while the front runs nor after it.
#[test]
fn hardly_a_number_of_a_state_is_subnormal() {
    for damped in [false, true] {
        let layers = [BoxLayer { name: "soft".into(), thickness: 1.0, elements: 1 }];
        let mesh = LayeredBox {
            dimension: 3,
            x: (0.0, 40.0),
            y: (0.0, 1.0),
            layers: &layers,
            element_width: 1.0,
            topography: None,
            moved_layers: 1,
            order: 1,
        };
        let mut ground = Ground::new(mesh.mesh().unwrap(), 4, &materials(damped)[..1]).unwrap();
        let forces =
            ground.point_force(&Locator::new(ground.mesh()), [0.3, 0.5, -0.5], [1.0, 0.5, 0.2]).unwrap();
        let pulse = |i: i32| (-(f64::from(i) / 60.0 - 5.0).powi(2)).exp();
        ground.add_load(forces, (0..600).map(pulse).collect());
        let dt = 0.9 * Solid::<f64>::critical_step(&ground, 1e-2, Execution::default()).unwrap();
        let mut solid = Solid::<f32>::new(&ground, dt, dt, Execution::default());
        let (mut state, mut moving, mut resting) = (State::default(), 0, 0);
        for _ in 0..40 {
            (0..20).for_each(|_| solid.step());
            solid.save(&mut state);
            let tiny = |x: &&f64| **x != 0.0 && x.abs() < f64::from(f32::MIN_POSITIVE);
            let share = state.values.iter().filter(tiny).count() as f64 / state.values.len() as f64;
            assert!(
                share <= if damped { 1e-3 } else { 0.0 },
                "damped {damped}, step {}: {share}",
                state.step
            );
            moving += state.values.iter().filter(|x| **x != 0.0).count();
            resting += state.values.iter().filter(|x| **x == 0.0).count();
        }
        assert!(moving > 100 && resting > 100, "the front was on its way: {moving}, {resting}");
    }
}
