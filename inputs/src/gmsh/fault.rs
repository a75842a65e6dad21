//! What can be wrong with one element of a mesh.

use crate::number::rounded;

/// What is wrong with one element of a mesh, and by [`Self::remedy`] what to do.
///
/// Places are coordinates of the file, in the order in which it gives them.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFault {
    /// A triangle, tetrahedron, prism or pyramid in the ground.
    #[error("is {}; the ground is made of {expected}", one(kind))]
    Shape {
        /// The element's type.
        kind: String,
        /// `quadrilaterals` or `hexahedra`.
        expected: &'static str,
    },
    /// Second order without the nodes inside faces and volume.
    #[error("is {}, which lacks the nodes inside its faces and itself (serendipity)", one(kind))]
    Serendipity {
        /// The element's type.
        kind: String,
    },
    /// Order 3 or more, or 0.
    #[error("is {} of order {order}; geometry of order 1 and 2 is read", one(kind))]
    Order {
        /// The element's type.
        kind: String,
        /// Its order.
        order: u8,
    },
    /// Straight and curved elements in one mesh.
    #[error("is {}, but the mesh begins with {}; one mesh has one order", one(kind), one(first))]
    MixedOrders {
        /// The element's type.
        kind: String,
        /// Type of the first element.
        first: String,
    },
    /// No physical group.
    #[error("belongs to no physical group, so it has no material")]
    NoGroup,
    /// A physical group without a name.
    #[error("belongs to physical group {group} of dimension {dimension}, which has no name")]
    UnnamedGroup {
        /// Dimension of the group.
        dimension: u8,
        /// Its tag.
        group: i64,
    },
    /// Two materials.
    #[error("belongs to several physical groups ({names}); it has one material")]
    SeveralMaterials {
        /// The groups.
        names: String,
    },
    /// The mapping from the reference element folds or collapses.
    #[error(
        "is folded or collapsed: its Jacobian divided by the lengths of its tangents is {} at {}; it must be positive everywhere",
        rounded(*value),
        local(.at)
    )]
    Jacobian {
        /// $\det J$ over the product of the lengths of the columns of $J$, between −1 and 1.
        value: f64,
        /// Where it is smallest, in local coordinates of −1 to 1.
        at: Vec<i8>,
    },
    /// A hexahedron whose local axes are left-handed.
    #[error("is inside out: its Jacobian is negative everywhere")]
    Inverted,
    /// Two elements with the same corners, or three on one side.
    #[error(
        "shares a side with more than one other element, among them element {other}: elements overlap or are given twice"
    )]
    Overlap {
        /// Tag of one of the others.
        other: u64,
    },
    /// Two nodes in one place.
    #[error("touches another part of the mesh without being joined to it: nodes {node} and {other} lie in one place, {}", point(*.at))]
    DuplicateNodes {
        /// Tag of a node of this element.
        node: u64,
        /// Tag of the other node.
        other: u64,
        /// Where.
        at: [f64; 3],
    },
    /// A corner of another element inside one of its sides.
    #[error("has a hanging node: node {node} at {} is a corner of other elements and lies inside one of its sides", point(*.at))]
    HangingNode {
        /// Tag of the node.
        node: u64,
        /// Where.
        at: [f64; 3],
    },
    /// An element of a boundary that lies on no element's side.
    #[error("of boundary \"{boundary}\" ({}) is no side of an element of the ground", one(kind))]
    OffSide {
        /// Name of the boundary.
        boundary: String,
        /// The element's type.
        kind: String,
    },
}

impl MeshFault {
    /// What to do.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Shape { .. } => {
                "recombine: Recombine Surface{…} in a plane; in space transfinite volumes, or Extrude{…}{Surface{…}; \
                 Layers{n}; Recombine;} of recombined surfaces, and Mesh.SubdivisionAlgorithm = 2 as the last resort"
            }
            Self::Serendipity { .. } => "set Mesh.SecondOrderIncomplete = 0 and mesh again",
            Self::Order { .. } => {
                "set Mesh.ElementOrder = 1 or 2: the polynomial order of the waves is a value of the scene, not of the mesh"
            }
            Self::MixedOrders { .. } => "set Mesh.ElementOrder once and mesh all parts together",
            Self::NoGroup => {
                "put every part into a group, Physical Volume(\"clay\") = {1}; or Physical Surface in a plane, and take out Mesh.SaveAll"
            }
            Self::UnnamedGroup { .. } => {
                "name the group: Physical Volume(\"clay\") = {1}; in place of Physical Volume(1) = {1};"
            }
            Self::SeveralMaterials { .. } => "keep every part in one group of its dimension",
            Self::Jacobian { .. } => {
                "look at it in Gmsh (Tools, Statistics, SICN); mesh finer where the boundary curves, or set Mesh.HighOrderOptimize = 2"
            }
            Self::Inverted => {
                "number its nodes the other way round: gmsh.model.mesh.reverse([(3, volume)]) in Gmsh's Python, or extrude the other way"
            }
            Self::Overlap { .. } => {
                "remove the part that lies there twice: Coherence; or BooleanFragments before meshing"
            }
            Self::DuplicateNodes { .. } => {
                "join the parts: Coherence; (built-in kernel), BooleanFragments{…} (OpenCASCADE), or Coherence Mesh; after meshing"
            }
            Self::HangingNode { .. } => {
                "give both sides of the interface the same divisions: BooleanFragments{…} and one Transfinite Curve for shared edges"
            }
            Self::OffSide { .. } => {
                "take parts that bound no meshed volume (or surface, in a plane) out of the group, and give Recombine to those that do"
            }
        }
    }
}

/// An element's type with its article: `an 8-node hexahedron`.
fn one(kind: &str) -> String {
    let vowel = ["8", "11-", "18-"].iter().any(|begin| kind.starts_with(begin));
    format!("{} {kind}", if vowel { "an" } else { "a" })
}

/// Coordinates for a message.
pub(crate) fn point(at: [f64; 3]) -> String {
    let [x, y, z] = at.map(crate::number::nine);
    format!("({x}, {y}, {z})")
}

fn local(at: &[i8]) -> String {
    let axes = ["ξ", "η", "ζ"];
    let words: Vec<String> = at.iter().zip(axes).map(|(value, axis)| format!("{axis} = {value}")).collect();
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_says_what_to_do_in_one_line() {
        let (kind, at) = (String::from("4-node tetrahedron"), [0.1, 0.0, 2e9]);
        let all = [
            MeshFault::Shape { kind: kind.clone(), expected: "hexahedra" },
            MeshFault::Serendipity { kind: kind.clone() },
            MeshFault::Order { kind: kind.clone(), order: 3 },
            MeshFault::MixedOrders { kind: kind.clone(), first: kind.clone() },
            MeshFault::NoGroup,
            MeshFault::UnnamedGroup { dimension: 3, group: 4 },
            MeshFault::SeveralMaterials { names: "a, b".into() },
            MeshFault::Jacobian { value: -0.1, at: vec![1, 0, -1] },
            MeshFault::Inverted,
            MeshFault::Overlap { other: 3 },
            MeshFault::DuplicateNodes { node: 1, other: 2, at },
            MeshFault::HangingNode { node: 1, at },
            MeshFault::OffSide { boundary: "top".into(), kind },
        ];
        let source = include_str!("fault.rs");
        let variants = source.split("#[cfg(test)]").next().unwrap().matches("    #[error(").count();
        assert_eq!(all.len(), variants);
        for fault in all {
            let (text, remedy) = (fault.to_string(), fault.remedy());
            assert!(!text.contains('\n') && !remedy.contains('\n') && remedy.len() > 20, "{text} {remedy}");
        }
        let folded = MeshFault::Jacobian { value: -0.1, at: vec![1, 0] }.to_string();
        assert!(folded.contains("is -0.1 at ξ = 1, η = 0"), "{folded}");
    }
}
