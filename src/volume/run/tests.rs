use super::*;
use crate::volume::{MeshOptions, VolumePlan};
use hati_inputs::scene::load_str;

/// A damped box with a force, a moment and a patch, stations with and without tensors, and no rows of fields in the first
/// tenth of a second.
const SCENE: &str = r#"
version = 1
[domain]
dimension = 3
x = [0.0, 40.0]
y = [-20.0, 20.0]
depth = 20.0
[[soil.layer]]
thickness = 10.0
vs = 150.0
rho = 1800.0
damping = 0.03
[soil.base]
kind = "elastic"
vs = 300.0
rho = 2000.0
[[source]]
kind = "force"
position = [11.0, 2.0, 0.0]
force = [2e5, 1e5, -1e6]
wavelet = { kind = "ricker", frequency = 6.0, time = 0.1 }
[[source]]
kind = "moment"
position = [21.0, 2.0, -9.0]
moment = [1e6, 0.0, 0.0, 0.0, 0.0, 0.0]
wavelet = { kind = "ricker", frequency = 6.0, time = 0.1 }
[[source]]
kind = "traction"
boundary = "top"
centre = [30.0, 0.0]
sigma = 2.0
force = [0.0, 0.0, 1e5]
wavelet = { kind = "ricker", frequency = 6.0, time = 0.1 }
[discretisation]
order = 4
element_size = 10.0
elements = [1, 1]
mechanisms = 2
dt = 1e-3
[run]
duration = 1.0
[output]
stations = [
    { name = "a", position = [22.0, 3.0, 0.0] },
    { name = "b", position = [5.0, -4.0], depth = 6.0, quantities = ["velocity", "strain", "stress"] },
]
[output.surface]
dt = 0.5
"#;

/// Allocations on the calling thread of `count` samples, the ledger's rows left out.
fn allocations<T: Real>(threads: usize, count: usize) -> u64 {
    let scene = load_str(SCENE, "a box", &[]).unwrap_or_else(|e| panic!("{e}"));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let folder = tempfile::tempdir().unwrap();
    pool.install(|| {
        let options = MeshOptions { allow_scripts: false, folder: folder.path() };
        let mut plan = VolumePlan::new(&scene, threads, &options).unwrap();
        plan.threads = threads;
        let execution = Execution { threads, ..Execution::default() };
        let mut solid = Solid::<T>::new(&plan.ground, plan.sampling.dt, plan.dt_critical, execution);
        let provenance = provenance(&scene, &plan, "", "");
        let (mut streams, mut progress) =
            open_streams(&plan, &mut solid, folder.path(), &provenance, None).unwrap();
        let interrupt = AtomicBool::new(false);
        let mut control = VolumeControl {
            interrupt: &interrupt,
            max_wall_time: None,
            progress: &mut |_, _, _| {},
            history: String::new(),
            restart: false,
        };
        let looped =
            Loop { plan: &plan, out: folder.path(), control: &mut control, wall: Instant::now(), hash: "" };
        let mut samples = |count: usize| {
            for _ in 0..count {
                looped.sample(&mut solid, &mut streams, &mut progress, usize::MAX).unwrap();
            }
        };
        // the first sample is a row of every file, and the pool's queues find their size
        samples(3);
        allocation_counter::measure(|| samples(count)).count_total
    })
}

/// On two threads the other one runs the code that one thread runs as well: what is counted beyond is the joining.
#[test]
fn steps_and_samples_allocate_nothing() {
    for threads in [1, 2] {
        assert_eq!(allocations::<f32>(threads, 20), 0, "f32 on {threads} threads");
        assert_eq!(allocations::<f64>(threads, 20), 0, "f64 on {threads} threads");
    }
    // the counter does count
    assert!(allocation_counter::measure(|| drop(std::hint::black_box(vec![1.0_f64; 10]))).count_total > 0);
}
