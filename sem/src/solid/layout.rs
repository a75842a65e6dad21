//! Where elements and points lie in memory: blocks that fit the cache, batches that fill the vectors.
//!
//! Elements follow a space-filling curve, those of one metric kind together, and are cut into blocks of
//! some thousand points. Points that one block alone touches are its *inner* points: they lie side by
//! side, and their step ends inside the block while it is in the cache. Points of several blocks are
//! *shared*: blocks leave partial sums for them, added in the order of the blocks whatever the number of
//! threads, so results do not depend on it. Points with loads, supports or dashpots are *special*, the
//! last of the shared ones.

use super::geometry::Metric;
use crate::mesh::Mesh;
use crate::numbering::Numbering;
use std::ops::Range;

/// Points that a block is made for; three components of positions and forces of f32 then fit a
/// second-level cache of 512 KiB. Larger blocks share fewer points: from 4096 to 8192 and 16384 the step
/// of 32³ elements of order 4 gains 5 and 10 % where the cache has 1 MiB.
const BLOCK_POINTS: usize = 16384;

/// Blocks that even a small mesh is cut into, so that several threads find work. The number of threads
/// itself has no say: results must not depend on it.
const BLOCKS_LEAST: usize = 32;

/// Local numbers are 16 bits wide.
const LOCAL_MAX: usize = 1 << 16;

/// Marks an empty lane.
pub(super) const NO_ELEMENT: u32 = u32::MAX;

/// Consecutive batches with their inner points.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Batches.
    pub batches: Range<usize>,
    /// Inner points, by number.
    pub inner: Range<usize>,
    /// Its entries in [`Layout::halo`].
    pub halo: Range<usize>,
    /// How its elements' metric is found.
    pub metric: Metric,
    /// First number of its metric.
    pub metric_start: usize,
}

impl Block {
    /// Points that it touches.
    pub(super) fn points(&self) -> usize {
        self.inner.len() + self.halo.len()
    }
}

/// Order of elements and points.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    /// Lanes of a batch.
    pub lanes: usize,
    /// Local points of an element.
    pub points: usize,
    /// Blocks.
    pub blocks: Vec<Block>,
    /// Runs of blocks that one task takes.
    pub leaves: Vec<Range<usize>>,
    /// Element in each lane of each batch, or [`NO_ELEMENT`].
    pub element: Vec<u32>,
    /// Number inside the block of each local point, `[batch][point][lane]`.
    pub local: Vec<u16>,
    /// Shared points that blocks touch, counted from the first shared one.
    pub halo: Vec<u32>,
    /// First entry of each shared point in `sums`.
    pub sums_start: Vec<u32>,
    /// Entries of `halo` that add up at each shared point, in the order of the blocks.
    pub sums: Vec<u32>,
    /// Number of the first shared point.
    pub shared: usize,
    /// Number of the first special point.
    pub special: usize,
    /// Points in all.
    pub nodes: usize,
    /// Number here of each point of the [`Numbering`].
    pub number: Vec<u32>,
    /// Block of each element.
    pub block_of: Vec<u32>,
}

impl Layout {
    /// Arranges a mesh. `special` marks points of the numbering; `tasks` is the number of leaves wanted.
    pub(super) fn new(
        mesh: &Mesh,
        numbering: &Numbering,
        special: &[bool],
        lanes: usize,
        tasks: usize,
    ) -> Self {
        let kinds: Vec<Metric> = (0..mesh.len()).map(|e| Metric::of(mesh, e)).collect();
        let mut order = mesh.curve_order();
        order.sort_by_key(|&e| kinds[e as usize]);
        let per_block = elements_per_block(numbering, mesh.dimension, lanes);
        let mut layout = Self {
            lanes,
            points: numbering.points,
            blocks: vec![],
            leaves: vec![],
            element: vec![],
            local: vec![],
            halo: vec![],
            sums_start: vec![],
            sums: vec![],
            shared: 0,
            special: 0,
            nodes: numbering.nodes,
            number: vec![],
            block_of: vec![0; mesh.len()],
        };
        let mut runs = vec![];
        for same in order.chunk_by(|&a, &b| kinds[a as usize] == kinds[b as usize]) {
            for run in same.chunks(per_block) {
                let first = layout.element.len() / lanes;
                run.iter().for_each(|&e| layout.block_of[e as usize] = runs.len() as u32);
                layout.element.extend(run);
                layout.element.resize(layout.element.len().next_multiple_of(lanes), NO_ELEMENT);
                let metric = kinds[run[0] as usize];
                let batches = first..layout.element.len() / lanes;
                layout.blocks.push(Block { batches, inner: 0..0, halo: 0..0, metric, metric_start: 0 });
                runs.push(run);
            }
        }
        layout.number_points(numbering, special, &runs);
        layout.localise(numbering, &runs);
        layout.add_up();
        layout.cut_into_leaves(tasks);
        layout
    }

    /// Inner points block by block, then shared, then special ones, each in the order of first touch.
    fn number_points(&mut self, numbering: &Numbering, special: &[bool], runs: &[&[u32]]) {
        const UNSEEN: u32 = u32::MAX;
        const SHARED: u32 = u32::MAX - 1;
        let mut owner = vec![UNSEEN; numbering.nodes];
        for (run, b) in runs.iter().zip(0u32..) {
            for &e in *run {
                for &p in numbering.element(e as usize) {
                    let slot = &mut owner[p as usize];
                    *slot = match *slot {
                        _ if special[p as usize] => SHARED,
                        UNSEEN => b,
                        same if same == b => b,
                        _ => SHARED,
                    };
                }
            }
        }
        self.number = vec![UNSEEN; numbering.nodes];
        let mut next = 0;
        for (run, b) in runs.iter().zip(0u32..) {
            let first = next;
            for &e in *run {
                for &p in numbering.element(e as usize) {
                    if owner[p as usize] == b && self.number[p as usize] == UNSEEN {
                        self.number[p as usize] = next as u32;
                        next += 1;
                    }
                }
            }
            self.blocks[b as usize].inner = first..next;
        }
        self.shared = next;
        for wanted in [false, true] {
            if wanted {
                self.special = next;
            }
            for &p in runs.iter().flat_map(|run| run.iter()).flat_map(|&e| numbering.element(e as usize)) {
                if self.number[p as usize] == UNSEEN && special[p as usize] == wanted {
                    self.number[p as usize] = next as u32;
                    next += 1;
                }
            }
        }
    }

    /// Numbers inside the blocks; a block's empty lanes repeat its last element.
    fn localise(&mut self, numbering: &Numbering, runs: &[&[u32]]) {
        let mut place = vec![u32::MAX; self.nodes - self.shared];
        for (b, run) in runs.iter().enumerate() {
            let first_halo = self.halo.len();
            let inner = self.blocks[b].inner.clone();
            for &p in run.iter().flat_map(|&e| numbering.element(e as usize)) {
                let number = self.number[p as usize] as usize;
                if number >= self.shared && place[number - self.shared] == u32::MAX {
                    place[number - self.shared] = (self.halo.len() - first_halo) as u32;
                    self.halo.push((number - self.shared) as u32);
                }
            }
            for batch in self.blocks[b].batches.clone() {
                for point in 0..self.points {
                    for lane in 0..self.lanes {
                        let e = self.element[batch * self.lanes + lane];
                        let e = if e == NO_ELEMENT { run[run.len() - 1] } else { e };
                        let number = self.number[numbering.element(e as usize)[point] as usize] as usize;
                        let local = if number < self.shared {
                            number - inner.start
                        } else {
                            inner.len() + place[number - self.shared] as usize
                        };
                        self.local.push(local as u16);
                    }
                }
            }
            let halo = first_halo..self.halo.len();
            self.halo[halo.clone()].iter().for_each(|&s| place[s as usize] = u32::MAX);
            self.blocks[b].halo = halo;
        }
    }

    fn add_up(&mut self) {
        let shared = self.nodes - self.shared;
        let mut start = vec![0u32; shared + 1];
        self.halo.iter().for_each(|&s| start[s as usize + 1] += 1);
        (0..shared).for_each(|s| start[s + 1] += start[s]);
        let mut next = start.clone();
        self.sums = vec![0; self.halo.len()];
        for (entry, &s) in (0u32..).zip(&self.halo) {
            self.sums[next[s as usize] as usize] = entry;
            next[s as usize] += 1;
        }
        self.sums_start = start;
    }

    fn cut_into_leaves(&mut self, tasks: usize) {
        let tasks = tasks.clamp(1, self.blocks.len().max(1));
        let batches = self.element.len() / self.lanes;
        let mut first = 0;
        for task in 1..=tasks {
            let due = batches * task / tasks;
            let end = self.blocks.partition_point(|b| b.batches.end <= due).max(first);
            if end > first {
                self.leaves.push(first..end);
            }
            first = end;
        }
    }

    /// Where the components of a point lie in an array of three numbers per point: first, and distance of
    /// the next component. Inner points of a block lie component by component, others point by point.
    pub(super) fn place(&self, number: usize) -> (usize, usize) {
        if number >= self.shared {
            return (3 * number, 1);
        }
        let block = &self.blocks[self.blocks.partition_point(|b| b.inner.end <= number)];
        (3 * block.inner.start + number - block.inner.start, block.inner.len())
    }
}

fn elements_per_block(numbering: &Numbering, dimension: usize, lanes: usize) -> usize {
    // a point is shared by all but its own share of elements: N^D new ones per element
    let new = numbering.order.pow(dimension as u32);
    let share = (numbering.connectivity.len() / numbering.points).div_ceil(BLOCKS_LEAST);
    let wanted = (BLOCK_POINTS / new).min(share).max(1).next_multiple_of(lanes);
    let most = (LOCAL_MAX - 1) / numbering.points;
    // even where no two elements of a block share a point, its numbers must fit
    if wanted <= most { wanted } else { (most / lanes * lanes).max(1) }
}
