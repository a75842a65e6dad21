/// What can be wrong with a soil model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SemError {
    /// A polynomial order that has no tabulated rule.
    #[error("polynomial order {0} is outside 1…10; orders 4 to 8 serve most scenes")]
    Order(usize),
    /// A mesh description that does not fit the profile.
    #[error("{found} element counts for {expected} layers: give one count of at least 1 per layer")]
    ElementCounts {
        /// Counts given.
        found: usize,
        /// Layers of the profile.
        expected: usize,
    },
    /// A material value out of its range.
    #[error("layer `{layer}`: {key} = {value} is outside its range ({range})")]
    Material {
        /// Layer's name.
        layer: String,
        /// Key.
        key: &'static str,
        /// Value found.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// The damping fit did not converge.
    #[error(
        "no set of {mechanisms} memory variables found for D = {damping} over {f_min}–{f_max} Hz; ask for more mechanisms or a narrower band"
    )]
    Fit {
        /// Mechanisms asked for.
        mechanisms: usize,
        /// Damping ratio.
        damping: f64,
        /// Lower end of the band, Hz.
        f_min: f64,
        /// Upper end of the band, Hz.
        f_max: f64,
    },
    /// A depth outside the column.
    #[error("depth {depth} m lies outside the column (0 to {bottom} m)")]
    Depth {
        /// Depth asked for, m.
        depth: f64,
        /// Depth of the column's base, m.
        bottom: f64,
    },
    /// No component is active.
    #[error("no component is active: the motion must have x, y or z")]
    NoComponent,
    /// A dimension that has no mesh.
    #[error("dimension {0} has no mesh of elements: give 2 (a section in x–z) or 3")]
    Dimension(usize),
    /// A geometric order that elements do not have.
    #[error("elements of geometric order {0} are not known: give 1 (straight edges) or 2 (curved)")]
    GeometryOrder(usize),
    /// A box without extent.
    #[error("the box runs from {axis} = {min} m to {max} m: the second must be greater, both finite")]
    BoxRange {
        /// Axis.
        axis: char,
        /// Least coordinate given, m.
        min: f64,
        /// Greatest coordinate given, m.
        max: f64,
    },
    /// A horizontal size that is no size.
    #[error("element width {0} m: give a finite width above 0")]
    ElementWidth(f64),
    /// More nodes than can be numbered.
    #[error(
        "a box of {} × {} × {} elements has more nodes than can be numbered (4.29e9): ask for larger elements or a smaller box",
        counts[0], counts[1], counts[2]
    )]
    TooManyElements {
        /// Elements along x, y, z.
        counts: [usize; 3],
    },
    /// A topography without a height at a point of the box.
    #[error(
        "the topography gives no finite height at x = {x} m, y = {y} m: it must cover the whole box, sides included"
    )]
    TopographyMissing {
        /// Place, m.
        x: f64,
        /// Place, m.
        y: f64,
    },
    /// A surface that comes too near the interface under it.
    #[error(
        "the surface at x = {x} m, y = {y} m lies at z = {height} m, but the layers that follow it end at z = {floor} m and elements would be crushed below z = {least} m: thicken the first layer or mesh the scene with Gmsh"
    )]
    TopographyTooLow {
        /// Place, m.
        x: f64,
        /// Place, m.
        y: f64,
        /// Height of the surface there, m.
        height: f64,
        /// Flat interface under the layers that follow the surface, m.
        floor: f64,
        /// Lowest height allowed, m.
        least: f64,
    },
    /// A grid of heights that is none.
    #[error(
        "a height grid of {} × {} points, spacing {} × {} m, has {found} heights: it needs one finite height per point and a spacing above 0",
        counts[0], counts[1], spacing[0], spacing[1]
    )]
    HeightGrid {
        /// Heights given.
        found: usize,
        /// Points along x and y.
        counts: [usize; 2],
        /// Spacing along x and y, m.
        spacing: [f64; 2],
    },
    /// A resolution that is none.
    #[error("{key} = {value}: element sizes need a finite value above 0")]
    Sampling {
        /// Key.
        key: &'static str,
        /// Value found.
        value: f64,
    },
    /// Too few points for a wave, or an error that is none.
    #[error("{key} = {value}: the dispersion of a wave needs {range}")]
    Dispersion {
        /// Key.
        key: &'static str,
        /// Value found.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// Lists of a mesh that do not fit each other.
    #[error(
        "the mesh has {elements} elements and {nodes} nodes, and lists {found} element nodes where {expected} belong: give at least one element, all of its nodes, and fewer than 4.29e9 nodes"
    )]
    MeshLists {
        /// Elements.
        elements: usize,
        /// Element nodes that belong to them.
        expected: usize,
        /// Element nodes found.
        found: usize,
        /// Nodes.
        nodes: usize,
    },
    /// A coordinate that cannot be.
    #[error(
        "node {node} lies at ({}, {}, {}) m: coordinates must be finite, and y = 0 in a section (D = 2)",
        position[0], position[1], position[2]
    )]
    NodePosition {
        /// Node, counted from 0.
        node: usize,
        /// Its coordinates.
        position: [f64; 3],
    },
    /// A node that is not there.
    #[error("element {element} asks for node {node}, but the mesh has nodes 0 to {}: mesh again", nodes.saturating_sub(1))]
    NodeIndex {
        /// Element, counted from 0.
        element: usize,
        /// Node asked for.
        node: u32,
        /// Number of nodes.
        nodes: usize,
    },
    /// A material that is not there.
    #[error(
        "element {element} at ({}, {}, {}) m has material {material}, but only {materials} are named: put every element into a named group",
        short(centre[0]), short(centre[1]), short(centre[2])
    )]
    MaterialIndex {
        /// Element, counted from 0.
        element: usize,
        /// Mean of its corners, m.
        centre: [f64; 3],
        /// Index found.
        material: u32,
        /// Number of materials.
        materials: usize,
    },
    /// A side that is not there.
    #[error(
        "boundary `{name}` has side {side} of element {element}, but the mesh has {elements} elements of {sides} sides (counted from 0): mesh again"
    )]
    SideIndex {
        /// Boundary.
        name: String,
        /// Element asked for.
        element: u32,
        /// Side asked for.
        side: u8,
        /// Number of elements.
        elements: usize,
        /// Sides of an element.
        sides: usize,
    },
    /// An element that is turned inside out, folded or flat.
    #[error(
        "element {element} at ({}, {}, {}) m has a scaled Jacobian of {value:.3e}, which must be above 1e-6: the element is turned inside out, folded or flat (check the order of its nodes, the mesh's quality there or the topography)",
        short(centre[0]), short(centre[1]), short(centre[2])
    )]
    Jacobian {
        /// Element, counted from 0.
        element: usize,
        /// Mean of its corners, m.
        centre: [f64; 3],
        /// Least scaled Jacobian, 1 for a box.
        value: f64,
    },
    /// More than two elements at one side.
    #[error(
        "elements {elements:?} share one side at ({}, {}, {}) m: a side has at most two elements; remove the duplicates",
        short(centre[0]), short(centre[1]), short(centre[2])
    )]
    SideShared {
        /// Elements, counted from 0.
        elements: Vec<u32>,
        /// Middle of the side, m.
        centre: [f64; 3],
    },
    /// A side on whose nodes two elements do not agree.
    #[error(
        "elements {} and {} meet at ({}, {}, {}) m with the same corners but not the same side: their nodes between or the order of the corners differ; mesh again with one geometric order and without duplicate nodes",
        elements[0], elements[1], short(centre[0]), short(centre[1]), short(centre[2])
    )]
    SideTwisted {
        /// Elements, counted from 0.
        elements: [u32; 2],
        /// Middle of the side, m.
        centre: [f64; 3],
    },
    /// Two elements on the same side of the side that they share.
    #[error(
        "elements {} and {} overlap: both lie on the same side of their common face at ({}, {}, {}) m; remove the duplicate",
        elements[0], elements[1], short(centre[0]), short(centre[1]), short(centre[2])
    )]
    ElementsOverlap {
        /// Elements, counted from 0.
        elements: [u32; 2],
        /// Middle of the side, m.
        centre: [f64; 3],
    },
    /// Elements that touch without sharing nodes.
    #[error(
        "element {} has a side at ({}, {}, {}) m that no element shares, yet element {} touches it: a hanging node, or two blocks with nodes of their own; make the blocks' divisions equal and merge duplicate nodes (Gmsh: Coherence)",
        elements[0], short(centre[0]), short(centre[1]), short(centre[2]), elements[1]
    )]
    SidesUnmatched {
        /// Elements, counted from 0.
        elements: [u32; 2],
        /// Middle of the side, m.
        centre: [f64; 3],
    },
    /// A named boundary inside the mesh.
    #[error(
        "boundary `{name}` has a side of element {element} at ({}, {}, {}) m that lies inside the mesh: a boundary must be part of the surface; take the inner sides out of the group, or use no boundary of this name",
        short(centre[0]), short(centre[1]), short(centre[2])
    )]
    BoundaryInside {
        /// Boundary.
        name: String,
        /// Element, counted from 0.
        element: u32,
        /// Middle of the side, m.
        centre: [f64; 3],
    },
    /// A boundary that the mesh does not have.
    #[error("the mesh has no boundary `{name}`; it has {known:?}")]
    NoBoundary {
        /// Name asked for.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// A point outside the mesh.
    #[error(
        "the point ({}, {}, {}) m lies {distance:.3e} m outside the mesh, whose nearest point is ({}, {}, {}) m and which spans x {}…{}, y {}…{}, z {}…{} m: move the point or enlarge the mesh",
        short(point[0]), short(point[1]), short(point[2]), short(nearest[0]), short(nearest[1]), short(nearest[2]),
        short(min[0]), short(max[0]), short(min[1]), short(max[1]), short(min[2]), short(max[2])
    )]
    OutsideMesh {
        /// Point asked for, m.
        point: [f64; 3],
        /// Distance from the mesh, m.
        distance: f64,
        /// Nearest point of the mesh, m.
        nearest: [f64; 3],
        /// Least coordinates of the mesh, m.
        min: [f64; 3],
        /// Greatest coordinates of the mesh, m.
        max: [f64; 3],
    },
    /// A place of the plan that a boundary does not cover.
    #[error(
        "x = {} m, y = {} m lies {distance:.3e} m beside the boundary `{name}`, whose nearest point is ({}, {}, {}) m",
        short(*x), short(*y), short(nearest[0]), short(nearest[1]), short(nearest[2])
    )]
    OutsideBoundary {
        /// Boundary.
        name: String,
        /// Place asked for, m.
        x: f64,
        /// Place asked for, m.
        y: f64,
        /// Distance in plan, m.
        distance: f64,
        /// Nearest point of the boundary, m.
        nearest: [f64; 3],
    },
    /// P waves damped too little beside S waves.
    #[error(
        "material `{material}` (vp {vp} m/s, vs {vs} m/s): its P waves are damped so little beside its S waves that a change of volume would give energy back: raise damping_p to at least 4/3 (vs/vp)² damping"
    )]
    ActiveBulk {
        /// Material.
        material: String,
        /// Speed of P waves, m/s.
        vp: f64,
        /// Speed of S waves, m/s.
        vs: f64,
    },
    /// Too few points of an element for the mechanisms that are spread over them.
    #[error(
        "an element of order {order} in {dimension} dimensions has too few points to spread {mechanisms} mechanisms of damping over them evenly: ask for a higher order or fewer mechanisms, or keep all memory variables at every point (memory_variables = \"full\")"
    )]
    CoarseOrder {
        /// Polynomial order.
        order: usize,
        /// Dimension.
        dimension: usize,
        /// Mechanisms.
        mechanisms: usize,
    },
    /// Damping so strong that points with one mechanism each would lose their stiffness.
    #[error(
        "damping of `{material}` is too strong to be spread over the points: those of the mechanism of {frequency:.4} Hz would have a relaxed {modulus} modulus of {share:.3} times the mean, where it has to be above 0: keep all memory variables at every point (memory_variables = \"full\"), or ask for fewer mechanisms"
    )]
    CoarseModulus {
        /// Material.
        material: String,
        /// Modulus, "shear" or "bulk".
        modulus: &'static str,
        /// Relaxed modulus of such a point over the mean.
        share: f64,
        /// Relaxation frequency, Hz.
        frequency: f64,
    },
    /// A number of materials that is not the mesh's.
    #[error("the mesh has material `{name}`, for which no values are given; known are: {}", known.join(", "))]
    UnknownMaterial {
        /// Material of the mesh.
        name: String,
        /// Materials given.
        known: Vec<String>,
    },
    /// From the step or the algebra.
    #[error(transparent)]
    Coupling(#[from] hati_coupling::CouplingError),
}

/// A coordinate with seven digits, without the zeros of a very large or small one.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.6e}").parse().unwrap_or(x);
    match rounded.abs() {
        0.0 => "0".to_owned(),
        1e-4..1e9 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short() {
        let point = [1.0 / 3.0, 1e-300, -12_345.678_912];
        let (nearest, min, max) = ([0.1 + 0.2, 0.0, -0.0], [-1e300; 3], [2.0 / 3.0 * 1e8; 3]);
        let text = SemError::OutsideMesh { point, distance: 1.0, nearest, min, max }.to_string();
        assert!(text.contains("(0.3333333, 1e-300, -12345.68) m lies 1.000e0 m outside"), "{text}");
        assert!(text.contains("point is (0.3, 0, 0) m") && text.contains("x -1e300…66666670,"), "{text}");
    }
}
