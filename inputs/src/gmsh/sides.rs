//! Which sides of elements meet, and whether those that meet none lie on the surface of the ground.

use std::collections::HashMap;

use super::geometry::{corners, distance_to_side, dot, norm, side_nodes, subtract};
use super::near::Tree;

/// Nodes nearer to each other than this share of the shortest edge beside them lie in one place.
const ONE_PLACE: f64 = 1e-5;
/// A node nearer to a side than this share of the shorter edge lies on it.
const ON_SIDE: f64 = 1e-3;
/// A node this near to an edge, in shares of it, hangs on it when it is joined to both ends of it: across
/// a curved interface it stands off by the sagitta of the coarser side.
const ON_EDGE: f64 = 0.1;

/// A mesh whose sides are looked at.
pub(super) struct Ground<'a> {
    pub(super) dimension: usize,
    pub(super) order: usize,
    pub(super) nodes: &'a [[f64; 3]],
    pub(super) elements: &'a [u32],
}

/// Why the parts of a mesh do not fit together.
#[derive(Debug, PartialEq)]
pub(super) enum Misfit {
    /// More than two elements on one side.
    Overlap { element: u32, other: u32 },
    /// Two nodes in one place.
    Duplicate { element: u32, node: u32, other: u32 },
    /// A corner of others inside a side of the element.
    Hanging { element: u32, node: u32 },
}

/// Corners of a side in ascending order, `u32::MAX` for those that a line lacks: the same from both of
/// its elements.
type Key = [u32; 4];

/// Every side of every element, sorted by its corners.
pub(super) struct Sides {
    sorted: Vec<(Key, u32, u8)>,
}

fn key(nodes: impl Iterator<Item = u32>) -> Key {
    let mut key = [u32::MAX; 4];
    key.iter_mut().zip(nodes).for_each(|(slot, node)| *slot = node);
    key.sort_unstable();
    key
}

impl Ground<'_> {
    fn element(&self, element: u32) -> &[u32] {
        let n = (self.order + 1).pow(self.dimension as u32);
        &self.elements[element as usize * n..(element as usize + 1) * n]
    }

    fn len(&self) -> usize {
        self.elements.len() / (self.order + 1).pow(self.dimension as u32)
    }

    /// Sides of all elements.
    pub(super) fn sides(&self) -> Sides {
        let tables: Vec<Vec<usize>> = (0..2 * self.dimension)
            .map(|side| {
                let nodes = side_nodes(self.dimension, self.order, side);
                corners(self.dimension - 1, self.order).iter().map(|&corner| nodes[corner]).collect()
            })
            .collect();
        let mut sorted = Vec::with_capacity(self.len() * tables.len());
        for element in 0..self.len() as u32 {
            let nodes = self.element(element);
            for (side, table) in (0_u8..).zip(&tables) {
                sorted.push((key(table.iter().map(|&node| nodes[node])), element, side));
            }
        }
        sorted.sort_unstable();
        Sides { sorted }
    }

    /// Nodes on one side of one element, the lower local axis fastest.
    fn on_side(&self, element: u32, side: u8) -> Vec<u32> {
        let nodes = self.element(element);
        side_nodes(self.dimension, self.order, side.into()).iter().map(|&node| nodes[node]).collect()
    }

    /// Whether elements meet side to side, and nowhere else.
    pub(super) fn misfits(&self, sides: &Sides) -> Option<Misfit> {
        let mut free = Vec::new();
        for group in sides.sorted.chunk_by(|a, b| a.0 == b.0) {
            match group {
                [(_, element, side)] => free.push((*element, self.on_side(*element, *side))),
                [(_, element, side), (_, other, beside)] => {
                    if self.order == 2
                        && let Some(misfit) = self.inner_nodes((*element, *side), (*other, *beside))
                    {
                        return Some(misfit);
                    }
                }
                [(_, element, _), .., (_, other, _)] => {
                    return Some(Misfit::Overlap { element: *element, other: *other });
                }
                [] => {}
            }
        }
        Free::new(self, free).misfits()
    }

    /// Edges of a side by the nodes at their ends.
    fn edges(&self, nodes: &[u32]) -> Vec<(u32, u32)> {
        let axes = self.dimension - 1;
        let corner = corners(axes, self.order);
        let pairs: &[(usize, usize)] = if axes == 1 { &[(0, 1)] } else { &[(0, 1), (2, 3), (0, 2), (1, 3)] };
        pairs.iter().map(|&(a, b)| (nodes[corner[a]], nodes[corner[b]])).collect()
    }

    /// Two sides with the same corners share the nodes between these too.
    fn inner_nodes(&self, one: (u32, u8), other: (u32, u8)) -> Option<Misfit> {
        let (mine, theirs) = (self.on_side(one.0, one.1), self.on_side(other.0, other.1));
        let node = *mine.iter().find(|node| !theirs.contains(node))?;
        let gap = |other: &u32| norm(subtract(self.nodes[*other as usize], self.nodes[node as usize]));
        let strangers = theirs.iter().filter(|other| !mine.contains(other));
        let other = *strangers.min_by(|a, b| gap(a).total_cmp(&gap(b)))?;
        Some(Misfit::Duplicate { element: one.0, node, other })
    }
}

impl Sides {
    /// The sides with these corners: the lower element first, two of them inside the ground.
    pub(super) fn with(&self, corners: &[u32]) -> impl Iterator<Item = (u32, u8)> {
        let wanted = key(corners.iter().copied());
        let first = self.sorted.partition_point(|(key, ..)| *key < wanted);
        let found = self.sorted[first..].iter().take_while(move |(key, ..)| *key == wanted);
        found.map(|&(_, element, side)| (element, side))
    }
}

/// The sides that belong to one element: the surface, and wherever parts do not fit.
struct Free<'a> {
    ground: &'a Ground<'a>,
    /// Element and nodes of each.
    sides: Vec<(u32, Vec<u32>)>,
    /// Their corners, sides' places and the edges between them, by node.
    around: HashMap<u32, Around>,
    /// The nodes of [`Self::around`] in ascending order, so that refusals do not depend on hashing.
    nodes: Vec<u32>,
}

/// What lies around one corner of a free side.
struct Around {
    /// One of the elements.
    element: u32,
    /// The shortest edge, m.
    shortest: f64,
    /// The nodes at the other ends of the edges.
    joined: Vec<u32>,
}

impl<'a> Free<'a> {
    fn new(ground: &'a Ground<'a>, sides: Vec<(u32, Vec<u32>)>) -> Self {
        let mut around: HashMap<u32, Around> = HashMap::new();
        for (element, nodes) in &sides {
            for (a, b) in ground.edges(nodes) {
                let length = norm(subtract(ground.nodes[a as usize], ground.nodes[b as usize]));
                for (from, to) in [(a, b), (b, a)] {
                    let entry = around.entry(from);
                    let new = || Around { element: *element, shortest: length, joined: Vec::new() };
                    let around = entry.or_insert_with(new);
                    around.shortest = around.shortest.min(length);
                    if !around.joined.contains(&to) {
                        around.joined.push(to);
                    }
                }
            }
        }
        let mut nodes: Vec<u32> = around.keys().copied().collect();
        nodes.sort_unstable();
        Self { ground, sides, around, nodes }
    }

    fn misfits(&self) -> Option<Misfit> {
        let place = |node: &u32| (self.ground.nodes[*node as usize], *node);
        let tree = Tree::new(self.nodes.iter().map(place).collect());
        self.duplicates(&tree).or_else(|| self.hanging_on_edges()).or_else(|| self.hanging(&tree))
    }

    /// Two nodes in one place.
    fn duplicates(&self, tree: &Tree) -> Option<Misfit> {
        self.nodes.iter().find_map(|&node| {
            let (around, at) = (&self.around[&node], self.ground.nodes[node as usize]);
            let reach = ONE_PLACE * around.shortest;
            let mut nearest: Option<u32> = None;
            tree.within(at.map(|c| c - reach), at.map(|c| c + reach), &mut |place, other| {
                if other != node && norm(subtract(place, at)) <= reach {
                    nearest = Some(nearest.map_or(other, |found| found.min(other)));
                }
            });
            nearest.map(|other| Misfit::Duplicate { element: around.element, node, other })
        })
    }

    /// A node joined to both ends of a free edge and lying beside it: the edge of a coarser element.
    fn hanging_on_edges(&self) -> Option<Misfit> {
        let at = |node: u32| self.ground.nodes[node as usize];
        self.sides.iter().find_map(|(element, nodes)| {
            self.ground.edges(nodes).into_iter().find_map(|(a, b)| {
                let edge = subtract(at(b), at(a));
                let squared = dot(edge, edge);
                let theirs = &self.around[&b].joined;
                let between = self.around[&a].joined.iter().filter(|node| theirs.contains(node));
                between.copied().find_map(|node| {
                    let along = dot(subtract(at(node), at(a)), edge) / squared;
                    let foot = [0, 1, 2].map(|c| at(a)[c] + along * edge[c]);
                    let off = norm(subtract(at(node), foot));
                    let hangs = (0.05..=0.95).contains(&along) && off <= ON_EDGE * squared.sqrt();
                    hangs.then_some(Misfit::Hanging { element: *element, node })
                })
            })
        })
    }

    /// A corner of a free side that lies on another free side.
    fn hanging(&self, tree: &Tree) -> Option<Misfit> {
        let (axes, order) = (self.ground.dimension - 1, self.ground.order);
        let own: Vec<usize> = corners(axes, order);
        self.sides.iter().find_map(|(element, nodes)| {
            let places: Vec<[f64; 3]> = nodes.iter().map(|&node| self.ground.nodes[node as usize]).collect();
            let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
            for place in &places {
                for c in 0..3 {
                    (low[c], high[c]) = (low[c].min(place[c]), high[c].max(place[c]));
                }
            }
            // A curved side may stand out of the box of its nodes.
            let margin = norm(subtract(high, low)) * if order == 2 { 0.1 } else { ON_SIDE };
            let shortest = own.iter().map(|&corner| self.around[&nodes[corner]].shortest);
            let shortest = shortest.fold(f64::INFINITY, f64::min);
            let mut found: Option<u32> = None;
            tree.within(low.map(|c| c - margin), high.map(|c| c + margin), &mut |place, node| {
                if own.iter().any(|&corner| nodes[corner] == node) || found.is_some_and(|found| found < node)
                {
                    return;
                }
                let reach = ON_SIDE * shortest.min(self.around[&node].shortest);
                if distance_to_side(axes, order, &places, place).is_some_and(|gap| gap <= reach) {
                    found = Some(node);
                }
            });
            found.map(|node| Misfit::Hanging { element: *element, node })
        })
    }
}
