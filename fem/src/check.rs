//! What is wrong with a structure, all at once: duplicate and loose nodes, unconnected parts.

use crate::{FemError, model::Model};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Nodes nearer than this share of the structure's size lie in one place.
const SAME_PLACE: f64 = 1e-9;

/// Looks at a structure before it is assembled; `parts` is the number of pieces that it may have
/// (1 for most; more where contact joins them later).
///
/// Finds nodes of nothing, two nodes in one place with nothing between them, and more or fewer pieces
/// than asked for. Elements have checked their own geometry. Empty where all is well.
pub fn check(model: &Model, parts: usize) -> Vec<FemError> {
    if let Err(error) = model.numbering() {
        return vec![error];
    }
    let mut errors = duplicates(model);
    let components = components(model);
    errors.extend(loose(&components));
    let pieces: Vec<&Component> = components.iter().filter(|c| !c.loose()).collect();
    if pieces.len() != parts {
        let list = pieces.iter().map(|c| c.to_string()).collect();
        errors.push(FemError::Parts { found: pieces.len(), expected: parts, parts: list });
    }
    errors
}

/// Nodes joined by elements and constraints.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Component {
    /// Its nodes, ascending.
    pub nodes: Vec<usize>,
    /// Names of the groups whose elements it holds.
    pub groups: Vec<String>,
    joined: bool,
}

impl Component {
    fn loose(&self) -> bool {
        self.groups.is_empty() && !self.joined
    }
}

impl std::fmt::Display for Component {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let groups: Vec<String> = self.groups.iter().map(|g| format!("`{g}`")).collect();
        let first = self.nodes.first().copied().unwrap_or(0);
        write!(f, "{} ({} nodes, first {first})", groups.join(", "), self.nodes.len())
    }
}

/// The connected parts of a structure, in the order of their first nodes.
pub fn components(model: &Model) -> Vec<Component> {
    let mut root: Vec<usize> = (0..model.nodes().len()).collect();
    let mut joined = HashSet::new();
    for element in model.elements() {
        unite(&mut root, element.nodes());
    }
    for (_, constraint) in model.constraints() {
        unite(&mut root, &constraint.nodes());
        joined.extend(constraint.nodes());
    }
    let mut parts: BTreeMap<usize, Component> = BTreeMap::new();
    for node in 0..root.len() {
        let part = parts.entry(find(&mut root, node)).or_default();
        part.nodes.push(node);
        part.joined |= joined.contains(&node);
    }
    for (i, element) in model.elements().iter().enumerate() {
        let name = &model.groups()[model.group_of(i).0];
        let Some(&node) = element.nodes().first() else { continue };
        let part = parts.entry(find(&mut root, node)).or_default();
        if !part.groups.contains(name) {
            part.groups.push(name.clone());
        }
    }
    let mut list: Vec<Component> = parts.into_values().collect();
    list.sort_by_key(|c| c.nodes.first().copied());
    list
}

fn find(root: &mut [usize], mut node: usize) -> usize {
    while root[node] != node {
        root[node] = root[root[node]];
        node = root[node];
    }
    node
}

fn unite(root: &mut [usize], nodes: &[usize]) {
    for pair in nodes.windows(2) {
        let (a, b) = (find(root, pair[0]), find(root, pair[1]));
        root[a.max(b)] = a.min(b);
    }
}

fn loose(components: &[Component]) -> Option<FemError> {
    let nodes: Vec<usize> =
        components.iter().filter(|c| c.loose()).flat_map(|c| c.nodes.iter().copied()).take(20).collect();
    (!nodes.is_empty()).then_some(FemError::LooseNodes { nodes })
}

fn duplicates(model: &Model) -> Vec<FemError> {
    let nodes = model.nodes();
    let range = |axis: usize| {
        let values = nodes.iter().map(|x| x[axis]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    let size = if nodes.is_empty() { 0.0 } else { (0..3).map(range).fold(0.0, f64::max) };
    let tolerance = (SAME_PLACE * size).max(f64::MIN_POSITIVE);
    let pairs = near_pairs(nodes, tolerance);
    if pairs.is_empty() {
        return vec![];
    }
    let joined = joined_pairs(model, &pairs);
    let apart = pairs.into_iter().filter(|pair| !joined.contains(pair));
    apart.map(|(first, second)| FemError::DuplicateNodes { first, second, position: nodes[first] }).collect()
}

/// Pairs of nodes within `tolerance`, the first below the second, by a grid of cells.
fn near_pairs(nodes: &[[f64; 3]], tolerance: f64) -> Vec<(usize, usize)> {
    let cell =
        |x: &[f64; 3], shift: [f64; 3]| [0, 1, 2].map(|i| (x[i] / (4.0 * tolerance) + shift[i]).floor());
    let key = |c: [f64; 3]| c.map(f64::to_bits);
    let mut grid: HashMap<[u64; 3], Vec<usize>> = HashMap::new();
    let mut pairs = vec![];
    for (node, x) in nodes.iter().enumerate() {
        // a neighbour within the tolerance lies in a cell that a quarter of a cell's shift reaches
        let mut seen = HashSet::new();
        for corner in 0..8 {
            let shift = [0, 1, 2].map(|i| if corner >> i & 1 == 0 { -0.25 } else { 0.25 });
            // -0 and 0 are one cell
            let place = key(cell(x, shift).map(|v| v + 0.0));
            if !seen.insert(place) {
                continue;
            }
            for &other in grid.get(&place).into_iter().flatten() {
                let apart = (0..3).map(|i| (nodes[other][i] - x[i]).powi(2)).sum::<f64>().sqrt();
                if apart <= tolerance {
                    pairs.push((other, node));
                }
            }
        }
        grid.entry(key(cell(x, [0.0; 3]).map(|v| v + 0.0))).or_default().push(node);
    }
    pairs
}

/// Those of `pairs` that an element or a constraint joins.
fn joined_pairs(model: &Model, pairs: &[(usize, usize)]) -> HashSet<(usize, usize)> {
    let mut partners: HashMap<usize, Vec<(usize, usize)>> = HashMap::new();
    for &pair in pairs {
        partners.entry(pair.0).or_default().push(pair);
    }
    let mut joined = HashSet::new();
    let constraints = model.constraints().iter().map(|(_, c)| c.nodes());
    for nodes in model.elements().iter().map(|e| e.nodes().to_vec()).chain(constraints) {
        for node in &nodes {
            for pair in partners.get(node).into_iter().flatten() {
                if nodes.contains(&pair.1) {
                    joined.insert(*pair);
                }
            }
        }
    }
    joined
}
