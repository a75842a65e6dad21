//! Throughput of the solid's whole step: element-steps per second, with its share of the machine's limits.
use hati_coupling::Subdomain;
use hati_sem::mesh::{BoxLayer, LayeredBox, Locator};
use hati_sem::solid::{Execution, Ground, Material, Real, Solid, Watch};
use std::time::Instant;

fn main() {
    let n: usize = std::env::var("N").ok().and_then(|s| s.parse().ok()).unwrap_or(32);
    let order: usize = std::env::var("ORDER").ok().and_then(|s| s.parse().ok()).unwrap_or(4);
    for deformed in [false, true] {
        for visco in [false, true] {
            let layers = [BoxLayer { name: "soil".into(), thickness: n as f64, elements: n }];
            let mut mesh = LayeredBox { dimension: 3, x: (0.0, n as f64), y: (0.0, n as f64), layers: &layers, element_width: 1.0, topography: None, moved_layers: 1, order: 1 }.mesh().unwrap();
            if deformed { mesh.move_interior_nodes(0.15, 1); }
            let layer = hati_sem::soil::Layer { name: "soil".into(), thickness: 1.0, vs: 200.0, vp: 346.41, rho: 1800.0, damping_s: 0.02, damping_p: 0.02 };
            let material = if visco { Material::of_layer(&layer, 1.0, (0.5, 20.0), 3).unwrap() } else { Material::elastic("soil", 1800.0, 346.41, 200.0) };
            let t = Instant::now();
            let mut ground = Ground::new(mesh, order, &[material]).unwrap();
            let mid = n as f64 * 0.5 + 0.3;
            let load = { let l = Locator::new(ground.mesh()); ground.point_force(&l, [mid, mid, -0.1], [0.0, 0.0, 1e6]).unwrap() };
            ground.add_load(load, (0..10000).map(|i| (i as f64 * 0.1).sin()).collect());
            println!("ground {:.2} s", t.elapsed().as_secs_f64());
            run::<f32>(&ground, deformed, visco);
            run::<f64>(&ground, deformed, visco);
        }
    }
}

fn run<T: Real>(ground: &Ground, deformed: bool, visco: bool) {
    let dt = 2e-4 / ground.gll().len() as f64 * 2.0;
    for threads in [1] {
        let t = Instant::now();
        let mut solid = Solid::<T>::new(ground, dt, dt, Execution { threads, ..Execution::default() });
        let built = t.elapsed().as_secs_f64();
        let surface = ground.boundary_points("top").unwrap();
        let mut watch = Watch::new(&solid, &surface);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut rates = vec![];
        pool.install(|| for _ in 0..5 {
            let t = cpu();
            let steps = 10;
            for _ in 0..steps { solid.step(); }
            watch.before(&solid); watch.after(&solid);
            rates.push((ground.mesh().len() * steps) as f64 / (cpu() - t) * 1e-6);
        });
        rates.sort_by(f64::total_cmp);
        println!("{} deformed {deformed} visco {visco} threads {threads}: {:.3} M element-steps/s (min {:.3} max {:.3}); {:.0} B/element; built in {built:.2} s; {:?}", T::NAME, rates[2], rates[0], rates[4], solid.bytes() as f64 / ground.mesh().len() as f64, solid.fastest_point().0);
    }
}

fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    s.split_whitespace().next().unwrap().parse::<f64>().unwrap() * 1e-9
}
