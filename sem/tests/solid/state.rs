//! A state written as bytes goes on bit for bit, and is refused by another solid.

use crate::{materials, small_box};
use hati_coupling::Subdomain;
use hati_sem::mesh::Locator;
use hati_sem::solid::{Execution, Ground, Instructions, Memory, Real, Solid, Watch};

const DT: f64 = 1e-3;

fn ground(memory: Memory) -> Ground {
    let mut ground = Ground::new(small_box(3, 1, true), 4, &materials(true)).unwrap();
    ground.set_memory(memory).unwrap();
    ground.support("bottom", hati_sem::solid::Support::Absorbing).unwrap();
    let forces = {
        let locator = Locator::new(ground.mesh());
        ground.point_force(&locator, [1.3, 0.2, -0.7], [1.0, -0.6, 0.8]).unwrap()
    };
    ground.add_load(forces, (0..40).map(|i| (0.4 * f64::from(i) + 0.2).sin()).collect());
    ground
}

fn steps<T: Real>(ground: &Ground, solid: &mut Solid<T>, count: usize) -> Vec<[f64; 3]> {
    let all: Vec<u32> = (0..ground.numbering().nodes as u32).collect();
    let mut watch = Watch::new(solid, &all);
    for _ in 0..count {
        watch.before(solid);
        solid.step();
        watch.after(solid);
    }
    watch.displacement().iter().chain(watch.acceleration()).copied().collect()
}

fn goes_on<T: Real>(memory: Memory) {
    let ground = ground(memory);
    let solid = |threads| Solid::<T>::new(&ground, DT, DT, Execution { threads, ..Execution::default() });
    let mut straight = solid(1);
    let expected = steps(&ground, &mut straight, 30);
    let mut first = solid(1);
    steps(&ground, &mut first, 17);
    let mut bytes = vec![];
    first.write_state(&mut bytes).unwrap();
    assert_eq!(bytes.len(), first.state_bytes());
    let mut second = solid(2);
    second.read_state(&mut &bytes[..]).unwrap();
    assert_eq!(second.steps_taken(), 17);
    assert!(steps(&ground, &mut second, 13) == expected, "{}", T::NAME);
    assert_eq!(second.energies(), straight.energies());
    assert!(second.read_state(&mut &bytes[..bytes.len() - 1]).is_err(), "a state that is cut off");
}

#[test]
fn a_written_state_goes_on_bit_for_bit_on_any_number_of_threads() {
    for memory in [Memory::Full, Memory::Coarse] {
        goes_on::<f32>(memory);
        goes_on::<f64>(memory);
    }
}

#[test]
fn the_state_of_another_solid_is_refused() {
    let ground = ground(Memory::Full);
    let mut bytes = vec![];
    Solid::<f32>::new(&ground, DT, DT, Execution::default()).write_state(&mut bytes).unwrap();
    let refused = |outcome: std::io::Result<()>| {
        let error = outcome.unwrap_err();
        assert_eq!(error.kind(), std::io::ErrorKind::InvalidData, "{error}");
    };
    let from = |bytes: &[u8]| bytes.to_vec();
    let other = Solid::<f64>::new(&ground, DT, DT, Execution::default()).read_state(&mut &from(&bytes)[..]);
    refused(other);
    refused(Solid::<f32>::new(&ground, 2.0 * DT, DT, Execution::default()).read_state(&mut &bytes[..]));
    let coarse = self::ground(Memory::Coarse);
    refused(Solid::<f32>::new(&coarse, DT, DT, Execution::default()).read_state(&mut &bytes[..]));
    let portable = Execution { threads: 1, instructions: Instructions::Portable };
    if Instructions::Best.lanes::<f32>(4) > 1 {
        refused(Solid::<f32>::new(&ground, DT, DT, portable).read_state(&mut &bytes[..]));
    }
}
