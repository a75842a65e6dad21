//! Every order, dimension, precision, geometry, law, instruction set and number of threads takes the same
//! steps as the reference.

use crate::{materials, small_box};
use hati_coupling::{State, Subdomain};
use hati_sem::mesh::Locator;
use hati_sem::solid::reference::ReferenceSolid;
use hati_sem::solid::{Execution, Ground, Instructions, Memory, Real, Solid, Watch};

const STEPS: usize = 8;

/// Elastic, all mechanisms at every point, or one at each.
const LAWS: [Option<Memory>; 3] = [None, Some(Memory::Full), Some(Memory::Coarse)];

fn loaded(dimension: usize, geometry: usize, deformed: bool, order: usize, memory: Option<Memory>) -> Ground {
    let mesh = small_box(dimension, geometry, deformed);
    let mut ground = Ground::new(mesh, order, &materials(memory.is_some())).unwrap();
    ground.set_memory(memory.unwrap_or_default()).unwrap();
    let place = if dimension == 3 { [1.3, 0.2, -0.7] } else { [1.3, 0.0, -0.7] };
    let forces = {
        let locator = Locator::new(ground.mesh());
        ground.point_force(&locator, place, [1.0, -0.6, 0.8]).unwrap()
    };
    ground.add_load(forces, (0..STEPS).map(|i| (0.4 * i as f64 + 0.2).sin()).collect());
    ground
}

fn everywhere<T: Real>(ground: &Ground, solid: &mut Solid<T>, steps: usize) -> Vec<[f64; 3]> {
    let all: Vec<u32> = (0..ground.numbering().nodes as u32).collect();
    let mut watch = Watch::new(solid, &all);
    for _ in 0..steps {
        watch.before(solid);
        solid.step();
        watch.after(solid);
    }
    watch
        .velocity()
        .iter()
        .zip(watch.acceleration())
        .map(|(v, a)| std::array::from_fn(|c| v[c] + a[c]))
        .collect()
}

fn by_reference(ground: &Ground, dt: f64) -> Vec<[f64; 3]> {
    let mut reference = ReferenceSolid::new(ground, dt);
    let mut before = reference.v.clone();
    for _ in 0..STEPS {
        before.clone_from(&reference.v);
        reference.step();
    }
    (before.iter().zip(&reference.v))
        .map(|(b, a)| std::array::from_fn(|c| 0.5 * (a[c] + b[c]) + (a[c] - b[c]) / dt))
        .collect()
}

fn difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let peak = b.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(peak > 0.0);
    a.iter().flatten().zip(b.iter().flatten()).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / peak
}

fn check<T: Real>(dimension: usize, order: usize, geometry: usize, deformed: bool, memory: Option<Memory>) {
    let ground = loaded(dimension, geometry, deformed, order, memory);
    let dt = 0.02 / (order * order) as f64;
    let expected = by_reference(&ground, dt);
    for instructions in [Instructions::Best, Instructions::Portable] {
        // the passes that threads share are the same on both paths
        let counts: &[usize] = if instructions == Instructions::Best { &[1, 2] } else { &[1] };
        for &threads in counts {
            let mut solid = Solid::<T>::new(&ground, dt, dt, Execution { threads, instructions });
            let error = difference(&everywhere(&ground, &mut solid, STEPS), &expected);
            let case = format!(
                "D = {dimension}, N = {order}, {}, geometry {geometry} {deformed}, {memory:?}, {instructions:?}, {threads} threads",
                T::NAME
            );
            // one step's round-off is some epsilon of the largest stress; accelerations see it undamped
            assert!(error < 200.0 * T::EPSILON * order as f64, "{case}: {error:e}");
        }
    }
}

#[test]
fn every_order_dimension_precision_geometry_and_law_steps_like_the_reference() {
    for dimension in [2, 3] {
        for order in 1..=10 {
            for (geometry, deformed) in [(1, false), (1, true), (2, true)] {
                for memory in LAWS {
                    // the largest elements once, with everything on
                    if dimension == 3 && order > 8 && !(deformed && memory.is_some()) {
                        continue;
                    }
                    check::<f32>(dimension, order, geometry, deformed, memory);
                    check::<f64>(dimension, order, geometry, deformed, memory);
                }
            }
        }
    }
}

#[test]
fn threads_and_tasks_do_not_change_a_bit() {
    for memory in [Memory::Full, Memory::Coarse] {
        let ground = loaded(3, 1, true, 4, Some(memory));
        let dt = 1e-3;
        let run = |threads| {
            let execution = Execution { threads, ..Execution::default() };
            everywhere(&ground, &mut Solid::<f32>::new(&ground, dt, dt, execution), STEPS)
        };
        let one = run(1);
        for threads in [2, 3, 7] {
            assert!(run(threads) == one, "{memory:?}, {threads} threads");
        }
    }
}

#[test]
fn a_saved_state_goes_on_bit_for_bit() {
    fn check<T: Real>(memory: Memory) {
        let ground = loaded(3, 2, true, 3, Some(memory));
        let dt = 1e-3;
        let mut straight = Solid::<T>::new(&ground, dt, dt, Execution::default());
        let expected = everywhere(&ground, &mut straight, STEPS);
        let mut first = Solid::<T>::new(&ground, dt, dt, Execution::default());
        everywhere(&ground, &mut first, STEPS / 2);
        let mut state = State::default();
        first.save(&mut state);
        let mut second = Solid::<T>::new(&ground, dt, dt, Execution { threads: 2, ..Execution::default() });
        second.restore(&state).unwrap();
        assert!(everywhere(&ground, &mut second, STEPS - STEPS / 2) == expected, "{}", T::NAME);
        assert_eq!(second.energies(), straight.energies());
        state.values.pop();
        assert!(second.restore(&state).is_err());
    }
    for memory in [Memory::Full, Memory::Coarse] {
        check::<f32>(memory);
        check::<f64>(memory);
    }
}
