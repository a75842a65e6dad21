//! Order of elimination, found on the graph of nodes.

use super::SymmetricMatrix;
use crate::FemError;

/// How the order of elimination is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ordering {
    /// Nested dissection by METIS, then the elimination tree in post-order. The default: least fill and work
    /// for solids, no worse than the others for frames.
    #[default]
    NestedDissection,
    /// The order given.
    Natural,
}

/// Graph of nodes: which nodes share an entry of the matrix.
struct Graph {
    start: Vec<usize>,
    neighbour: Vec<i32>,
    /// Freedoms of each node.
    freedoms: Vec<Vec<usize>>,
}

/// Forward permutation of freedoms: entry `i` is the freedom that is eliminated as the `i`-th.
///
/// Freedoms of one group stay together, in their own order: they share their pattern, so that the graph to be
/// dissected is smaller by the square of their number and supernodes hold whole nodes.
pub(super) fn permutation(
    matrix: &SymmetricMatrix,
    groups: &[u32],
    ordering: Ordering,
) -> Result<Vec<usize>, FemError> {
    let size = matrix.size();
    if groups.len() != size {
        return Err(FemError::Length { what: "groups of freedoms", found: groups.len(), expected: size });
    }
    if ordering == Ordering::Natural {
        return Ok((0..size).collect());
    }
    let graph = graph(matrix, groups)?;
    let dissected = dissect(&graph)?;
    let nodes = post_order(&graph, &dissected);
    Ok(nodes.into_iter().flat_map(|node| graph.freedoms[node].iter().copied()).collect())
}

fn graph(matrix: &SymmetricMatrix, groups: &[u32]) -> Result<Graph, FemError> {
    let mut labels = groups.to_vec();
    labels.sort_unstable();
    labels.dedup();
    let node: Vec<usize> =
        groups.iter().map(|g| labels.binary_search(g).expect("every label is in the list")).collect();
    let mut freedoms = vec![vec![]; labels.len()];
    for (freedom, &n) in node.iter().enumerate() {
        freedoms[n].push(freedom);
    }
    // one direction first, each pair once, then both
    let mut seen = vec![usize::MAX; labels.len()];
    let mut pairs = vec![];
    let mut degree = vec![0; labels.len() + 1];
    for (n, own) in freedoms.iter().enumerate() {
        for &column in own {
            for k in matrix.starts()[column]..matrix.starts()[column + 1] {
                let other = node[matrix.rows()[k]];
                if other != n && seen[other] != n {
                    seen[other] = n;
                    pairs.push((n.min(other), n.max(other)));
                }
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    for &(a, b) in &pairs {
        degree[a + 1] += 1;
        degree[b + 1] += 1;
    }
    for n in 0..labels.len() {
        degree[n + 1] += degree[n];
    }
    let start = degree.clone();
    if i32::try_from(2 * pairs.len()).is_err() {
        return Err(FemError::Memory { what: "the graph", size: matrix.size() });
    }
    let mut neighbour = vec![0; 2 * pairs.len()];
    for (a, b) in pairs {
        for (from, to) in [(a, b), (b, a)] {
            neighbour[degree[from]] = to as i32;
            degree[from] += 1;
        }
    }
    Ok(Graph { start, neighbour, freedoms })
}

/// Nested dissection by METIS: entry `i` is the node that is eliminated as the `i`-th.
///
/// The random numbers of METIS start from its fixed seed: the same graph gives the same order.
#[allow(unsafe_code)]
fn dissect(graph: &Graph) -> Result<Vec<usize>, FemError> {
    let nodes = graph.freedoms.len();
    // without an edge there is nothing to dissect
    if graph.neighbour.is_empty() {
        return Ok((0..nodes).collect());
    }
    let memory = || FemError::Memory { what: "the order of elimination", size: nodes };
    let mut count = i32::try_from(nodes).map_err(|_| memory())?;
    let mut start: Vec<i32> = graph.start.iter().map(|&s| s as i32).collect();
    let mut neighbour = graph.neighbour.clone();
    let mut weight: Vec<i32> = graph.freedoms.iter().map(|f| f.len() as i32).collect();
    let (mut forward, mut inverse) = (vec![0; nodes], vec![0; nodes]);
    let mut options = [0; metis_sys::METIS_NOPTIONS as usize];
    // SAFETY: `options` has the length that METIS states; the graph is symmetric, without loops, its starts
    // end at the length of `neighbour`, and the two permutations hold one entry a node.
    let status = unsafe {
        metis_sys::METIS_SetDefaultOptions(options.as_mut_ptr());
        metis_sys::METIS_NodeND(
            &mut count,
            start.as_mut_ptr(),
            neighbour.as_mut_ptr(),
            weight.as_mut_ptr(),
            options.as_mut_ptr(),
            forward.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    if status != metis_sys::rstatus_et_METIS_OK {
        return Err(memory());
    }
    Ok(forward.into_iter().map(|node| node as usize).collect())
}

/// The same elimination with the tree in post-order: columns of one supernode then stand together.
///
/// Fill and work stay those of `order`. Elimination tree after Liu (1986), with compressed paths.
fn post_order(graph: &Graph, order: &[usize]) -> Vec<usize> {
    const NONE: usize = usize::MAX;
    let nodes = order.len();
    let mut place = vec![0; nodes];
    for (i, &node) in order.iter().enumerate() {
        place[node] = i;
    }
    let (mut parent, mut ancestor) = (vec![NONE; nodes], vec![NONE; nodes]);
    for i in 0..nodes {
        for &other in &graph.neighbour[graph.start[order[i]]..graph.start[order[i] + 1]] {
            let mut at = place[other as usize];
            while at < i {
                let next = ancestor[at];
                ancestor[at] = i;
                if next == NONE {
                    parent[at] = i;
                    break;
                }
                at = next;
            }
        }
    }
    // children in increasing order: lists are filled from the back
    let (mut first, mut next) = (vec![NONE; nodes], vec![NONE; nodes]);
    for i in (0..nodes).rev() {
        if parent[i] != NONE {
            next[i] = first[parent[i]];
            first[parent[i]] = i;
        }
    }
    let mut result = Vec::with_capacity(nodes);
    for root in (0..nodes).filter(|&i| parent[i] == NONE) {
        let mut path = vec![root];
        while let Some(&top) = path.last() {
            if first[top] == NONE {
                result.push(order[top]);
                path.pop();
            } else {
                path.push(first[top]);
                first[top] = next[first[top]];
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(nodes: usize) -> SymmetricMatrix {
        let entries = (0..2 * nodes).map(|i| (i, i, 4.0));
        let links = (0..nodes - 1).flat_map(|n| [(2 * n + 2, 2 * n, -1.0), (2 * n + 3, 2 * n + 1, -1.0)]);
        SymmetricMatrix::assemble(2 * nodes, entries.chain(links)).unwrap()
    }

    #[test]
    fn an_order_holds_every_freedom_once_and_keeps_nodes_together() {
        let a = chain(300);
        let groups: Vec<u32> = (0..600).map(|i| 7 * (i / 2)).collect();
        let order = permutation(&a, &groups, Ordering::NestedDissection).unwrap();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &f)| i == f));
        assert!(order.chunks(2).all(|pair| pair[0] + 1 == pair[1] && pair[0] % 2 == 0));
    }

    #[test]
    fn parts_without_a_link_are_ordered_too() {
        let a = SymmetricMatrix::assemble(5, (0..5).map(|i| (i, i, 1.0))).unwrap();
        let order = permutation(&a, &[0, 1, 2, 3, 4], Ordering::default()).unwrap();
        assert_eq!(order, [0, 1, 2, 3, 4]);
    }

    #[test]
    fn groups_must_cover_the_matrix() {
        let a = SymmetricMatrix::assemble(2, [(0, 0, 1.0)]).unwrap();
        let error = permutation(&a, &[0], Ordering::default()).unwrap_err();
        assert!(matches!(error, FemError::Length { found: 1, expected: 2, .. }));
    }
}
