//! A tree of bounding boxes: which boxes hold a point, and which thing is nearest to it.
//!
//! Why a tree and not a regular grid of cells: a mesh graded from 0.1 m under a wheel to 100 m at its rim
//! would put thousands of elements into one cell or need billions of cells.

/// Items in a leaf.
const LEAF: usize = 4;

/// Least and greatest corner of a box.
pub(crate) type Bounds = ([f64; 3], [f64; 3]);

struct Node {
    bounds: Bounds,
    /// Items of the node in [`Tree::items`].
    first: u32,
    last: u32,
    /// Left child, the right one follows it; 0 for a leaf.
    child: u32,
}

/// Binary tree of boxes, split at the median of the longest direction.
pub(crate) struct Tree {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

impl Tree {
    /// Cost $O(n\log n)$; the boxes themselves are not kept.
    pub(crate) fn new(boxes: &[Bounds]) -> Self {
        let mut items: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = vec![];
        if !items.is_empty() {
            nodes.push(node(boxes, &items, 0, items.len()));
        }
        let mut next = 0;
        while next < nodes.len() {
            let (first, last) = (nodes[next].first as usize, nodes[next].last as usize);
            if last - first > LEAF {
                let middle = (first + last) / 2;
                split(boxes, &mut items[first..last], middle - first);
                nodes[next].child = nodes.len() as u32;
                nodes.push(node(boxes, &items, first, middle));
                nodes.push(node(boxes, &items, middle, last));
            }
            next += 1;
        }
        Self { nodes, items }
    }

    /// Calls `visit` with the items of every leaf whose box holds the point.
    pub(crate) fn at(&self, point: [f64; 3], visit: &mut dyn FnMut(u32)) {
        if !self.nodes.is_empty() {
            self.descend(0, point, visit);
        }
    }

    fn descend(&self, at: usize, point: [f64; 3], visit: &mut dyn FnMut(u32)) {
        let node = &self.nodes[at];
        if distance(&node.bounds, point) > 0.0 {
            return;
        }
        if node.child == 0 {
            self.items[node.first as usize..node.last as usize].iter().for_each(|&item| visit(item));
            return;
        }
        self.descend(node.child as usize, point, visit);
        self.descend(node.child as usize + 1, point, visit);
    }

    /// Visits items in the order of their boxes' distance, as long as that is not above the least distance
    /// that `visit` has returned. No item may be nearer than its box.
    pub(crate) fn nearest(&self, point: [f64; 3], visit: &mut dyn FnMut(u32) -> f64) {
        let mut least = f64::INFINITY;
        if !self.nodes.is_empty() {
            self.approach(0, point, &mut least, visit);
        }
    }

    fn approach(&self, at: usize, point: [f64; 3], least: &mut f64, visit: &mut dyn FnMut(u32) -> f64) {
        let node = &self.nodes[at];
        if distance(&node.bounds, point) > *least {
            return;
        }
        if node.child == 0 {
            for &item in &self.items[node.first as usize..node.last as usize] {
                *least = least.min(visit(item));
            }
            return;
        }
        let (left, right) = (node.child as usize, node.child as usize + 1);
        let d = [left, right].map(|n| distance(&self.nodes[n].bounds, point));
        let order = if d[0] <= d[1] { [left, right] } else { [right, left] };
        order.into_iter().for_each(|n| self.approach(n, point, least, visit));
    }
}

fn node(boxes: &[Bounds], items: &[u32], first: usize, last: usize) -> Node {
    let mut bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &item in &items[first..last] {
        let b = &boxes[item as usize];
        for i in 0..3 {
            bounds.0[i] = bounds.0[i].min(b.0[i]);
            bounds.1[i] = bounds.1[i].max(b.1[i]);
        }
    }
    Node { bounds, first: first as u32, last: last as u32, child: 0 }
}

/// Puts the lower half, along the direction in which the boxes' middles spread most, before `middle`.
fn split(boxes: &[Bounds], items: &mut [u32], middle: usize) {
    let twice = |item: u32, i: usize| boxes[item as usize].0[i] + boxes[item as usize].1[i];
    let spread = |i: usize| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &item in items.iter() {
            low = low.min(twice(item, i));
            high = high.max(twice(item, i));
        }
        high - low
    };
    let spreads = [0, 1, 2].map(spread);
    let axis = (0..3).fold(0, |best, i| if spreads[i] > spreads[best] { i } else { best });
    items.select_nth_unstable_by(middle, |&a, &b| twice(a, axis).total_cmp(&twice(b, axis)).then(a.cmp(&b)));
}

/// Distance of a point from a box, 0 inside.
fn distance(bounds: &Bounds, point: [f64; 3]) -> f64 {
    let squared = |i: usize| (bounds.0[i] - point[i]).max(point[i] - bounds.1[i]).max(0.0).powi(2);
    (0..3).map(squared).sum::<f64>().sqrt()
}
