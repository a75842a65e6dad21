//! Throughput of the solid's whole time loop, with its share of what the machine allows.
//!
//! ```text
//! cargo bench --bench throughput -- [--elements 32] [--order 4] [--only f32] [--law coarse] [--save benches/results]
//! cargo bench --bench throughput -- --pairs 9 [--elements 32]   full and coarse memory in turns, on one core
//! ```
//!
//! A box of 32³ elements of order 4 under a point force, stepped at 0.9 of its critical step, its free
//! surface looked at every fourth step, sub-sampled to every 10 ms and written to a file, and one station in the middle
//! with its motion, strain and stress, looked at as often; five rounds of at least half a second each; the table gives
//! medians. *Deformed*: inner corners moved at random by 15 % of an element. *Viscoelastic*: three
//! mechanisms at every point; *coarse*: one of them at each. Bytes and operations are counted, not measured: every array once a step from memory, every
//! operation of the kernel's formulas.

#![allow(clippy::print_stdout)]

mod limits;

use hati::outputs::Provenance;
use hati::outputs::decimate::Decimator;
use hati::outputs::thread::Background;
use hati::outputs::wave::{Cells, WaveLayout, WaveWriter};
use hati_coupling::Subdomain;
use hati_sem::mesh::{BoxLayer, LayeredBox, Locator};
use hati_sem::soil::Layer;
use hati_sem::solid::{Execution, Gauge, Ground, Material, Memory, Probe, Real, Solid, Watch};
use std::fmt::Write as _;
use std::time::Instant;

const ROUNDS: usize = 5;
const SURFACE_DT: f64 = 0.01;
/// Steps between two looks at the surface: its samples still hold half of the highest frequency of the
/// mesh, far above what the sub-sampling lets pass.
const STRIDE: usize = 4;

struct Options {
    elements: usize,
    order: usize,
    only: String,
    law: String,
    pairs: usize,
    save: Option<String>,
}

fn options() -> Options {
    let mut options =
        Options { elements: 32, order: 4, only: String::new(), law: String::new(), pairs: 0, save: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().unwrap_or_default();
        match word.as_str() {
            "--elements" => options.elements = value().parse().expect("--elements takes a number"),
            "--order" => options.order = value().parse().expect("--order takes a number"),
            "--only" => options.only = value(),
            "--law" => options.law = value(),
            "--pairs" => options.pairs = value().parse().expect("--pairs takes a number"),
            "--save" => options.save = Some(value()),
            _ => {}
        }
    }
    options
}

/// What one core reaches.
struct Machine {
    triad: [f64; 2],
    fma: [f64; 2],
}

fn main() {
    let options = options();
    if options.pairs > 0 {
        return pairs(&options);
    }
    let machine = Machine {
        triad: [limits::triad_bandwidth::<f32>(32 << 20, 5), limits::triad_bandwidth::<f64>(16 << 20, 5)],
        fma: [limits::fma_peak::<f32>(5), limits::fma_peak::<f64>(5)],
    };
    println!(
        "one core: triad {:.1} GB/s, multiply-add {:.0} GFLOP/s (f32), {:.0} (f64)",
        machine.triad[0] * 1e-9,
        machine.fma[0] * 1e-9,
        machine.fma[1] * 1e-9
    );
    let mut csv = String::from(
        "mesh,law,precision,threads,M_element_steps_per_s,least,most,ns_per_point,output_share,bytes_held_per_element,bytes_moved_per_element_step,flops_per_element_step,share_of_triad,share_of_multiply_add\n",
    );
    println!("{}", HEAD);
    for deformed in [false, true] {
        for (law, memory) in LAWS.into_iter().filter(|(law, _)| law.starts_with(&options.law)) {
            let ground = ground(&options, deformed, memory);
            let dt = stable_step(&ground);
            let names = (if deformed { "deformed" } else { "affine" }, law);
            for threads in [1, 2] {
                if options.only.is_empty() || options.only == "f32" {
                    case::<f32>(&ground, dt, threads, names, &machine, 0, &mut csv);
                }
                if options.only.is_empty() || options.only == "f64" {
                    case::<f64>(&ground, dt, threads, names, &machine, 1, &mut csv);
                }
            }
        }
    }
    if let Some(folder) = options.save {
        std::fs::create_dir_all(&folder).expect("a folder for the results");
        let now = std::time::SystemTime::now()
            .duration_since(std::time::UNIX_EPOCH)
            .map_or(0.0, |d| d.as_secs_f64());
        let day = &hati::calendar::iso8601(now)[..10];
        let file = format!("{folder}/throughput-{day}.csv");
        let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let cpu = cpu
            .lines()
            .find_map(|l| l.strip_prefix("model name"))
            .unwrap_or("")
            .trim_start_matches(['\t', ':', ' ']);
        let head = format!(
            "# {day}, {cpu}, {} elements of order {}, triad {:.2} GB/s, multiply-add {:.0} / {:.0} GFLOP/s (f32, f64) on one core\n",
            options.elements.pow(3),
            options.order,
            machine.triad[0] * 1e-9,
            machine.fma[0] * 1e-9,
            machine.fma[1] * 1e-9
        );
        std::fs::write(&file, head + &csv).expect("the results' file");
        println!("written to {file}");
    }
}

/// Laws of the rows.
const LAWS: [(&str, Option<Memory>); 3] =
    [("elastic", None), ("viscous", Some(Memory::Full)), ("coarse", Some(Memory::Coarse))];

fn stable_step(ground: &Ground) -> f64 {
    0.9 * Solid::<f32>::critical_step(ground, 0.02, Execution::default()).expect("a bound of the step")
}

/// Rounds of full and of coarse memory in turns, in processor time, so that what else the machine does falls on both; medians.
fn pairs(options: &Options) {
    println!(
        "mesh      prec | full, coarse (M element-steps/s, one core) | coarse/full: median (least, most)"
    );
    for deformed in [false, true] {
        let grounds = [Memory::Full, Memory::Coarse].map(|memory| ground(options, deformed, Some(memory)));
        let mesh = if deformed { "deformed" } else { "affine" };
        if options.only != "f64" {
            pairs_in::<f32>(&grounds, mesh, options.pairs);
        }
        if options.only != "f32" {
            pairs_in::<f64>(&grounds, mesh, options.pairs);
        }
    }
}

/// Seconds that this thread has run; wall time where the system does not tell.
fn processor_time() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ran = text.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok());
    ran.map_or_else(|| START.get_or_init(Instant::now).elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

fn pairs_in<T: Real>(grounds: &[Ground; 2], mesh: &str, rounds: usize) {
    let mut solids = grounds.each_ref().map(|ground| {
        let dt = stable_step(ground);
        Solid::<T>::new(ground, dt, dt, Execution::default())
    });
    let mut rates = vec![];
    for _ in 0..=rounds {
        rates.push(solids.each_mut().map(|solid| {
            let (start, mut steps) = (processor_time(), 0);
            while steps < 3 || processor_time() - start < 0.5 {
                solid.step();
                steps += 1;
            }
            1e-6 * (grounds[0].mesh().len() * steps) as f64 / (processor_time() - start)
        }));
    }
    // the first round finds caches and pages cold
    let sorted = |of: &dyn Fn(&[f64; 2]) -> f64| {
        let mut values: Vec<f64> = rates[1..].iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let (full, coarse, ratio) = (sorted(&|r| r[0]), sorted(&|r| r[1]), sorted(&|r| r[1] / r[0]));
    println!(
        "{mesh:<9} {:<4} | {:.3}, {:.3} | {:.3} ({:.3}, {:.3})",
        T::NAME,
        full[rounds / 2],
        coarse[rounds / 2],
        ratio[rounds / 2],
        ratio[0],
        ratio[rounds - 1]
    );
}

const HEAD: &str = "mesh      law      prec threads | M element-steps/s (least, most) | ns/point | outputs | held B/el | moved B/el | flop/el | of triad | of FMA";

fn ground(options: &Options, deformed: bool, memory: Option<Memory>) -> Ground {
    let n = options.elements;
    let layers = [BoxLayer { name: "soil".into(), thickness: n as f64, elements: n }];
    let mut mesh = LayeredBox {
        dimension: 3,
        x: (0.0, n as f64),
        y: (0.0, n as f64),
        layers: &layers,
        element_width: 1.0,
        topography: None,
        moved_layers: 1,
        order: 1,
    }
    .mesh()
    .expect("a box");
    if deformed {
        mesh.move_interior_nodes(0.15, 1);
    }
    let damping = if memory.is_some() { 0.02 } else { 0.0 };
    let layer = Layer {
        name: "soil".into(),
        thickness: n as f64,
        vs: 200.0,
        vp: 346.41,
        rho: 1800.0,
        damping_s: damping,
        damping_p: damping,
    };
    let material = Material::of_layer(&layer, 1.0, (0.5, 20.0), 3).expect("a fit");
    let mut ground = Ground::new(mesh, options.order, &[material]).expect("a ground");
    ground.set_memory(memory.unwrap_or_default()).expect("memory that fits the order");
    let middle = 0.5 * n as f64 + 0.3;
    let forces = {
        let locator = Locator::new(ground.mesh());
        ground.point_force(&locator, [middle, middle, -0.1], [0.0, 0.0, 1e6]).expect("a point inside")
    };
    ground.add_load(forces, (0..1_000_000).map(|i| (1e-2 * f64::from(i)).sin()).collect());
    ground
}

/// A station with its tensors.
struct Station {
    probe: Probe,
    watch: Watch,
    gauge: Gauge,
}

/// The loop that is timed: steps, and the outputs if they are to be taken.
struct Loop<T: Real> {
    solid: Solid<T>,
    watch: Watch,
    taken: usize,
    station: Station,
    surface: Option<(Decimator, Background<WaveWriter>)>,
}

impl Station {
    fn new<T: Real>(ground: &Ground, solid: &Solid<T>) -> Self {
        let (min, max) = ground.mesh().extent();
        let middle = std::array::from_fn(|i| 0.5 * (min[i] + max[i]) + 0.7);
        let probe = ground.probe(&Locator::new(ground.mesh()), middle).expect("a point inside");
        let points: Vec<u32> = probe.weights.iter().map(|w| w.0).collect();
        let (watch, gauge) = (Watch::new(solid, &points), Gauge::new(solid, ground, &probe));
        Self { probe, watch, gauge }
    }

    fn before<T: Real>(&mut self, solid: &Solid<T>) {
        self.watch.before(solid);
        std::hint::black_box(self.gauge.look(solid));
    }

    fn after<T: Real>(&mut self, solid: &Solid<T>) {
        self.watch.after(solid);
        std::hint::black_box(self.watch.at(&self.probe, 0));
    }
}

impl<T: Real> Loop<T> {
    fn new(ground: &Ground, dt: f64, threads: usize, folder: Option<&std::path::Path>) -> Self {
        let solid = Solid::new(ground, dt, dt, Execution { threads, ..Execution::default() });
        let numbering = ground.numbering();
        let sides = &ground.mesh().boundary("top").expect("a top").sides;
        let points: Vec<u32> = (sides.iter())
            .flat_map(|s| {
                numbering.side_points(s.side).into_iter().map(|p| numbering.element(s.element as usize)[p])
            })
            .collect();
        let at = ground.positions();
        let (cells, ids) = Cells::of_elements(2, numbering.order + 1, &points, |id| at[id as usize]);
        let layout =
            WaveLayout { displacement: false, velocity: true, acceleration: false, axes: vec![0, 1, 2] };
        let surface = folder.map(|folder| {
            let writer = WaveWriter::surface(
                &folder.join("surface.nc"),
                &Provenance::default(),
                &layout,
                &cells,
                None,
            )
            .expect("a file");
            let values = layout.values(ids.len());
            let decimator = Decimator::new(values, STRIDE as f64 * dt, 0.0, SURFACE_DT).expect("a schedule");
            (decimator, Background::start(vec![writer], 8).expect("a writer"))
        });
        let watch = Watch::new(&solid, &ids);
        let station = Station::new(ground, &solid);
        Self { solid, watch, taken: 0, station, surface }
    }

    fn step(&mut self) {
        let Some((decimator, writer)) = &mut self.surface else { return self.solid.step() };
        self.taken += 1;
        if !(self.taken - 1).is_multiple_of(STRIDE) {
            return self.solid.step();
        }
        self.watch.before(&self.solid);
        self.station.before(&self.solid);
        self.solid.step();
        self.watch.after(&self.solid);
        self.station.after(&self.solid);
        let velocity = self.watch.velocity();
        let fill = |row: &mut [f32]| {
            for (c, part) in row.chunks_mut(velocity.len()).enumerate() {
                part.iter_mut().zip(velocity).for_each(|(to, v)| *to = v[c] as f32);
            }
        };
        decimator
            .take(fill, |row| {
                let mut frame = writer.frame(0)?;
                frame.time = row.time;
                frame.values.copy_from_slice(row.values);
                writer.send(frame)
            })
            .expect("a row written");
    }

    /// Element-steps per second of each round, sorted.
    fn rates(&mut self, elements: usize) -> Vec<f64> {
        let start = Instant::now();
        (0..3).for_each(|_| self.step());
        let steps = (0.5 / (start.elapsed().as_secs_f64() / 3.0)).ceil().max(3.0) as usize;
        let mut rates: Vec<f64> = (0..ROUNDS)
            .map(|_| {
                let start = Instant::now();
                (0..steps).for_each(|_| self.step());
                (elements * steps) as f64 / start.elapsed().as_secs_f64()
            })
            .collect();
        rates.sort_by(f64::total_cmp);
        rates
    }
}

fn case<T: Real>(
    ground: &Ground,
    dt: f64,
    threads: usize,
    (mesh, law): (&str, &str),
    machine: &Machine,
    kind: usize,
    csv: &mut String,
) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let folder = tempfile::tempdir().expect("a folder");
    let elements = ground.mesh().len();
    let (rates, share, cost) = pool.install(|| {
        let mut plain = Loop::<T>::new(ground, dt, threads, None);
        let without = plain.rates(elements);
        let cost = plain.solid.cost();
        drop(plain);
        let mut whole = Loop::<T>::new(ground, dt, threads, Some(folder.path()));
        let rates = whole.rates(elements);
        let share = 1.0 - rates[ROUNDS / 2] / without[ROUNDS / 2];
        (rates, share, cost)
    });
    let rate = rates[ROUNDS / 2];
    let per = |x: f64| x / elements as f64;
    let (held, moved, flops) = (per(cost.bytes_held), per(cost.bytes_moved), per(cost.flops));
    let points = ground.numbering().nodes as f64 / elements as f64;
    let (triad, fma) = (rate * moved / machine.triad[kind], rate * flops / machine.fma[kind]);
    println!(
        "{mesh:<9} {law:<8} {:<4} {threads:>7} | {:>17.3} ({:.3}, {:.3}) | {:>8.1} | {:>6.1}% | {held:>9.0} | {moved:>10.0} | {flops:>7.0} | {:>7.0}% | {:>5.0}%",
        T::NAME,
        rate * 1e-6,
        rates[0] * 1e-6,
        rates[ROUNDS - 1] * 1e-6,
        1e9 / rate / points,
        1e2 * share,
        1e2 * triad / threads as f64,
        1e2 * fma / threads as f64,
    );
    let _ = writeln!(
        csv,
        "{mesh},{law},{},{threads},{:.4},{:.4},{:.4},{:.2},{share:.4},{held:.0},{moved:.0},{flops:.0},{:.3},{:.3}",
        T::NAME,
        rate * 1e-6,
        rates[0] * 1e-6,
        rates[ROUNDS - 1] * 1e-6,
        1e9 / rate / points,
        triad / threads as f64,
        fma / threads as f64,
    );
}
