//! Factor, solves and modes of a cube of bricks, beside faer and METIS called directly in the same run.
//!
//! ```text
//! cargo bench -p hati-fem --bench factor -- [--cells 30] [--rounds 3] [--solves 1000] [--modes 20]
//!     [--threads 2]
//! ```
//!
//! A cube of `cells³` eight-node bricks of steel (eight Gauss points), held on one face: 86,490 freedoms for
//! 30. *Bare*: METIS on the graph of nodes, its permutation handed to faer's symbolic and numeric Cholesky
//! with default parameters, faer's solve. Rounds take both in turns; the table gives medians, and the ratio of
//! the medians. *Factor + solve* is one numeric factor and one solve, the order being known; *all* has the
//! order and the symbolic factor too. Memory is the high-water mark of the process, reset before each.

#![allow(clippy::print_stdout, missing_docs)]

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{LltRef, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use hati_fem::modes::{Search, Wanted, modes};
use hati_fem::sparse::{Factor, Ordering, Symbolic, SymmetricMatrix};
use std::sync::Arc;
use std::time::Instant;

#[path = "../tests/brick/mod.rs"]
mod brick;

struct Options {
    cells: usize,
    rounds: usize,
    solves: usize,
    modes: usize,
    /// Most threads tried.
    threads: usize,
}

fn options() -> Options {
    let mut options = Options { cells: 30, rounds: 3, solves: 1000, modes: 20, threads: 2 };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().and_then(|v| v.parse().ok()).expect("a number after the option");
        match word.as_str() {
            "--cells" => options.cells = value(),
            "--rounds" => options.rounds = value(),
            "--solves" => options.solves = value(),
            "--threads" => options.threads = value(),
            "--modes" => options.modes = value(),
            _ => {}
        }
    }
    options
}

/// Seconds of the four stages, by the clock and of processor: order and pattern, numeric factor, one solve, 64
/// solves together.
type Stages = [[f64; 2]; 4];

fn main() {
    let options = options();
    let [n, rounds] = [options.cells, options.rounds.max(1)];
    let block = brick::block([n, n, n], [1.0, 1.0, 1.0]);
    let (size, load) = (block.stiffness.size(), block.load());
    println!(
        "{n}³ bricks, {size} freedoms, {} entries, load {}",
        block.stiffness.values().len(),
        machine_load()
    );
    for threads in 1..=options.threads {
        let (mut ours, mut bare) = (vec![], vec![]);
        let mut memory = [0.0; 2];
        for _ in 0..rounds {
            reset_peak();
            let (stages, x) = own(&block, &load, threads);
            memory[0] = peak();
            ours.push(stages);
            reset_peak();
            let (stages, y) = direct(&block, &load, threads);
            memory[1] = peak();
            bare.push(stages);
            let top = y.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-9 * top), "the two answers differ");
        }
        println!(
            "{threads} thread(s), load {:<8}     ours      bare     ratio   processor: ours, bare, ratio",
            machine_load()
        );
        let table: [(&str, &[usize]); 6] = [
            ("order and pattern, s", &[0]),
            ("numeric factor, s", &[1]),
            ("one solve, s", &[2]),
            ("64 solves together, s", &[3]),
            ("factor + solve, s", &[1, 2]),
            ("all, s", &[0, 1, 2]),
        ];
        for (name, stages) in table {
            let of = |runs: &[Stages], kind: usize| {
                median(runs.iter().map(|s| stages.iter().map(|&i| s[i][kind]).sum()).collect())
            };
            let [a, b] = [of(&ours, 0), of(&bare, 0)];
            let [c, d] = [of(&ours, 1), of(&bare, 1)];
            println!("  {name:<26} {a:9.4} {b:9.4} {:9.3} {c:12.2} {d:9.2} {:9.3}", a / b, c / d);
        }
        println!(
            "  {:<26} {:9.0} {:9.0} {:9.3}",
            "peak memory, MB",
            memory[0],
            memory[1],
            memory[0] / memory[1]
        );
    }
    solves(&block, &load, options.solves);
    natural(&block, options.modes, options.threads);
}

/// The lowest modes, with the count that none is missed.
fn natural(block: &brick::Block, count: usize, most: usize) {
    for threads in 1..=most {
        reset_peak();
        let start = Clock::now();
        let search = Search { threads, ..Search::default() };
        let found = modes(&block.stiffness, &block.mass, &block.groups, Wanted::Lowest(count), search)
            .expect("the modes of a block that is held");
        let [seconds, processor] = start.elapsed();
        let worst = (0..found.len()).map(|i| found.bound(i)).fold(0.0, f64::max);
        println!(
            "{count} lowest modes, {threads} thread(s): {seconds:.1} s (processor {processor:.1} s), {} solves, peak {:.0} MB, load {}, worst bound {worst:.1e}, \
             {:.1} to {:.1} Hz, counted at {:.1} Hz",
            found.solves(),
            peak(),
            machine_load(),
            found.frequency(0),
            found.frequency(count - 1),
            found.counted_at()
        );
    }
}

/// Many solves one after the other, as the steps of an implicit scheme make them.
fn solves(block: &brick::Block, load: &[f64], count: usize) {
    let symbolic =
        Arc::new(Symbolic::new(&block.stiffness, &block.groups, Ordering::default()).expect("a pattern"));
    println!(
        "factor: {} entries, {:.1} Gflop, {:.0} MB",
        symbolic.entries(),
        symbolic.flops() * 1e-9,
        symbolic.factor_bytes() as f64 * 1e-6
    );
    let mut factor = Factor::definite(&symbolic, &block.stiffness, 1).expect("a factor");
    let start = Clock::now();
    let mut x = load.to_vec();
    for _ in 0..count {
        x.copy_from_slice(load);
        factor.solve(&mut x);
    }
    let [seconds, processor] = start.elapsed();
    let each = 1e3 / count.max(1) as f64;
    println!(
        "{count} solves one by one: {seconds:.1} s, {:.1} ms each (processor {:.1} ms)",
        each * seconds,
        each * processor
    );
    let residual = factor.solve_refined(&block.stiffness, load, &mut x).expect("lengths that fit");
    println!("residual {:.1e}, after one refinement {:.1e}", residual.before, residual.after);
}

fn own(block: &brick::Block, load: &[f64], threads: usize) -> (Stages, Vec<f64>) {
    let mut clock = Clock::now();
    let symbolic = Symbolic::new(&block.stiffness, &block.groups, Ordering::default()).expect("a pattern");
    let symbolic = Arc::new(symbolic);
    let order = lap(&mut clock);
    let mut factor = Factor::definite(&symbolic, &block.stiffness, threads).expect("a factor");
    let numeric = lap(&mut clock);
    let mut x = load.to_vec();
    factor.solve(&mut x);
    let one = lap(&mut clock);
    let mut many = load.repeat(64);
    clock = Clock::now();
    factor.solve(&mut many);
    ([order, numeric, one, lap(&mut clock)], x)
}

fn direct(block: &brick::Block, load: &[f64], threads: usize) -> (Stages, Vec<f64>) {
    let matrix = &block.stiffness;
    let size = matrix.size();
    let par = if threads > 1 { Par::rayon(threads) } else { Par::Seq };
    let mut clock = Clock::now();
    let order = metis(matrix, &block.groups);
    let mut inverse = vec![0; size];
    for (i, &freedom) in order.iter().enumerate() {
        inverse[freedom] = i;
    }
    let pattern = SymbolicSparseColMatRef::new_checked(size, size, matrix.starts(), None, matrix.rows());
    let custom = SymmetricOrdering::Custom(PermRef::new_checked(&order, &inverse, size));
    let symbolic =
        factorize_symbolic_cholesky(pattern, Side::Lower, custom, Default::default()).expect("a pattern");
    let ordered = lap(&mut clock);
    let mut values = vec![0.0; symbolic.len_val()];
    let need = symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default());
    symbolic
        .factorize_numeric_llt(
            &mut values,
            SparseColMatRef::new(pattern, matrix.values()),
            Side::Lower,
            Default::default(),
            par,
            MemStack::new(&mut MemBuffer::new(need)),
            Default::default(),
        )
        .expect("a factor");
    let numeric = lap(&mut clock);
    let solve = |x: &mut [f64]| {
        let columns = x.len() / size;
        let mut scratch = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(columns, par));
        LltRef::new(&symbolic, &values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, size, columns),
            par,
            MemStack::new(&mut scratch),
        );
    };
    let mut x = load.to_vec();
    solve(&mut x);
    let one = lap(&mut clock);
    let mut many = load.repeat(64);
    clock = Clock::now();
    solve(&mut many);
    ([ordered, numeric, one, lap(&mut clock)], x)
}

/// METIS on the graph of nodes; labels are 0, 1, 2, ... and freedoms of a node follow each other.
#[allow(unsafe_code)]
fn metis(matrix: &SymmetricMatrix, groups: &[u32]) -> Vec<usize> {
    let nodes = groups.iter().max().map_or(0, |g| *g as usize + 1);
    let mut near = vec![vec![]; nodes];
    for column in 0..matrix.size() {
        for k in matrix.starts()[column]..matrix.starts()[column + 1] {
            let (a, b) = (groups[column] as usize, groups[matrix.rows()[k]] as usize);
            if a != b {
                near[a].push(b as i32);
                near[b].push(a as i32);
            }
        }
    }
    let (mut start, mut neighbour) = (vec![0], vec![]);
    for list in &mut near {
        list.sort_unstable();
        list.dedup();
        neighbour.extend_from_slice(list);
        start.push(neighbour.len() as i32);
    }
    let (mut forward, mut inverse) = (vec![0; nodes], vec![0; nodes]);
    // SAFETY: the graph is symmetric and without loops; all arrays have the lengths that METIS expects.
    let status = unsafe {
        metis_sys::METIS_NodeND(
            &mut (nodes as i32),
            start.as_mut_ptr(),
            neighbour.as_mut_ptr(),
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            forward.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    assert_eq!(status, metis_sys::rstatus_et_METIS_OK);
    let mut first = vec![0; nodes + 1];
    for &g in groups {
        first[g as usize + 1] += 1;
    }
    for node in 0..nodes {
        first[node + 1] += first[node];
    }
    forward.iter().flat_map(|&node| first[node as usize]..first[node as usize + 1]).collect()
}

/// Time by the clock, and of processor in all threads: on a busy machine only the second compares.
#[derive(Clone, Copy)]
struct Clock {
    wall: Instant,
    processor: f64,
}

impl Clock {
    fn now() -> Self {
        Self { wall: Instant::now(), processor: processor() }
    }

    fn elapsed(&self) -> [f64; 2] {
        [self.wall.elapsed().as_secs_f64(), processor() - self.processor]
    }
}

fn lap(clock: &mut Clock) -> [f64; 2] {
    let seconds = clock.elapsed();
    *clock = Clock::now();
    seconds
}

/// Seconds of processor that this process has used, in steps of the system's tick (10 ms).
fn processor() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or("").split_whitespace();
    fields.skip(11).take(2).filter_map(|t| t.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn machine_load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().unwrap_or("?").into()
}

/// Sets the high-water mark of memory back to what is held now (where the system allows it).
fn reset_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// High-water mark of memory, MB.
fn peak() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or("");
    line.trim().trim_end_matches(" kB").parse().map_or(f64::NAN, |kb: f64| kb / 1024.0)
}
