//! A mesh as its file holds it: tags and Gmsh's node order, nothing checked against anything.

use std::collections::BTreeMap;

use super::kinds::Kind;

/// Elements of one type that belong to the same physical groups.
pub(super) struct Block {
    pub(super) kind: Kind,
    /// Tags of the physical groups of this dimension.
    pub(super) groups: Vec<i64>,
    /// Tag of every element.
    pub(super) tags: Vec<u64>,
    /// Tags of the elements' nodes, `kind.nodes` each, in Gmsh's order.
    pub(super) nodes: Vec<u64>,
}

impl Block {
    pub(super) fn len(&self) -> usize {
        self.tags.len()
    }

    /// Tags of the nodes of one element.
    pub(super) fn element(&self, index: usize) -> &[u64] {
        let n = usize::from(self.kind.nodes);
        &self.nodes[index * n..(index + 1) * n]
    }
}

/// Content of a mesh file.
#[derive(Default)]
pub(super) struct Raw {
    /// Names of the physical groups by dimension and tag.
    pub(super) names: BTreeMap<(u8, i64), String>,
    /// Tags of the nodes.
    pub(super) node_tags: Vec<u64>,
    /// Their coordinates.
    pub(super) points: Vec<[f64; 3]>,
    pub(super) blocks: Vec<Block>,
}
