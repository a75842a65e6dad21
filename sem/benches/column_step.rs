//! Time of one step of the column over order, size and number of mechanisms.
//!
//! Run with `cargo bench -p hati-sem`. The throughput is in points per second: its inverse is the ns per
//! point, component and step that a run prints.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use hati_coupling::Subdomain;
use hati_sem::attenuation::MaxwellArms;
use hati_sem::column::{BaseMotion, Column, Discretisation};
use hati_sem::soil::{Base, Layer, Profile};
use std::hint::black_box;

fn column(order: usize, elements: usize, mechanisms: usize) -> Column {
    let damping = if mechanisms == 0 { 0.0 } else { 0.02 };
    let layer = Layer {
        name: "soil".into(),
        thickness: 30.0,
        vs: 250.0,
        vp: 500.0,
        rho: 1900.0,
        damping_s: damping,
        damping_p: damping,
    };
    let profile = Profile {
        layers: vec![layer],
        base: Base::Elastic { vs: 800.0, vp: 1600.0, rho: 2200.0 },
        reference_frequency: 2.0,
    };
    let arms =
        MaxwellArms::fit(damping, 2.0, (0.2, 20.0), mechanisms.max(1)).expect("a fit that the tests make");
    let arms = vec![[arms.clone(), arms.clone(), arms]];
    let mesh = Discretisation { order, elements: vec![elements] };
    let dt = Column::critical_step(&profile, &mesh, &arms, &[0], false).expect("a sound profile").0 * 0.9;
    let pulse = (0..1000).map(|i| (i as f64 * 0.01).sin()).collect();
    Column::new(&profile, &mesh, &arms, dt, [Some(BaseMotion::Outcrop(pulse)), None, None])
        .expect("a sound profile")
}

fn steps(c: &mut Criterion) {
    const STEPS: usize = 1000;
    let mut group = c.benchmark_group("column step");
    for (order, elements) in
        [(1, 8), (1, 64), (2, 4), (2, 32), (3, 4), (4, 4), (4, 16), (5, 8), (6, 16), (8, 8), (10, 4)]
    {
        for mechanisms in [0, 3, 5] {
            let mut column = column(order, elements, mechanisms);
            group.throughput(Throughput::Elements((STEPS * (order * elements + 1)) as u64));
            let id = BenchmarkId::new(format!("order {order}, {elements} elements"), mechanisms);
            group.bench_function(id, |b| {
                b.iter(|| {
                    for _ in 0..STEPS {
                        column.step();
                    }
                    black_box(column.kick_time())
                });
            });
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).warm_up_time(std::time::Duration::from_millis(100)).measurement_time(std::time::Duration::from_millis(400));
    targets = steps
}
criterion_main!(benches);
