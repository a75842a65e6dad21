//! Errors of structures.

use crate::constraint::Freedom;

/// What can be wrong with a structure.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FemError {
    /// An entry outside a matrix.
    #[error("entry ({row}, {column}) lies outside a matrix of {size} rows")]
    Entry {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// Number of rows.
        size: usize,
    },
    /// An entry that is no number.
    #[error("entry ({row}, {column}) of a matrix is {value}: look for a section, length or modulus of zero")]
    NotFinite {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The value.
        value: f64,
    },
    /// A list that does not fit the matrix.
    #[error("{what}: {found} given, {expected} expected")]
    Length {
        /// What the list holds.
        what: &'static str,
        /// Length found.
        found: usize,
        /// Length expected.
        expected: usize,
    },
    /// A freedom named twice in one list.
    #[error("freedom {freedom} stands twice in a list of freedoms")]
    FreedomTwice {
        /// The freedom.
        freedom: usize,
    },
    /// A matrix other than the one whose pattern was analysed.
    #[error(
        "the matrix has {found} entries in other places than the {expected} that were analysed: analyse it anew"
    )]
    Pattern {
        /// Entries found.
        found: usize,
        /// Entries analysed.
        expected: usize,
    },
    /// A pivot that is zero, negative, or positive only by round-off.
    #[error(
        "no stiffness is left at freedom {freedom} (pivot {pivot:.3e}, diagonal {diagonal:.3e}): the structure can \
         move there without force, or it has buckled; add the support or the connection that is missing"
    )]
    Pivot {
        /// Freedom, in the numbering of the matrix.
        freedom: usize,
        /// Pivot: what is left of the diagonal after elimination.
        pivot: f64,
        /// Diagonal of the matrix.
        diagonal: f64,
    },
    /// Factors that lost all their digits.
    #[error(
        "the factor of an indefinite matrix leaves a residual of {residual:.1e}: the shift lies on an eigenvalue of \
         a part of the structure; take another"
    )]
    Unstable {
        /// Relative residual of a solve.
        residual: f64,
    },
    /// An ordering or a factor that did not fit into memory.
    #[error("not enough memory for {what} of a matrix of {size} rows")]
    Memory {
        /// What was to be stored.
        what: &'static str,
        /// Number of rows.
        size: usize,
    },
    /// More modes than there are freedoms with mass.
    #[error("{asked} modes asked, {available} exist (freedoms without mass have none): ask for fewer")]
    TooManyModes {
        /// Modes asked.
        asked: usize,
        /// Modes that exist.
        available: usize,
    },
    /// Modes that did not converge.
    #[error(
        "{converged} of {asked} modes reached the tolerance {tolerance:.1e} after {solves} solves: loosen it, or \
         look for stiffnesses many orders apart"
    )]
    ModesNotConverged {
        /// Modes asked.
        asked: usize,
        /// Modes that converged.
        converged: usize,
        /// Tolerance.
        tolerance: f64,
        /// Solves made.
        solves: usize,
    },
    /// A count of eigenvalues that does not agree with those found.
    #[error("{counted} modes lie below {frequency:.6} Hz, {found} were found: take a smaller tolerance")]
    ModeCount {
        /// Modes counted by the signs of pivots.
        counted: usize,
        /// Modes found.
        found: usize,
        /// Frequency of the count, Hz.
        frequency: f64,
    },
    /// A band of frequencies without extent.
    #[error(
        "a band from {from} Hz to {to} Hz: the two must be finite, not negative, and the first below the second"
    )]
    Band {
        /// Lower end, Hz.
        from: f64,
        /// Upper end, Hz.
        to: f64,
    },
    /// A reduction that does not reach the accuracy demanded.
    #[error(
        "a reduction with modes up to {cut_off:.3} Hz still errs by {estimate:.1e} at {band:.3} Hz, {accuracy:.1e} \
         demanded: retain more freedoms, or keep the structure whole"
    )]
    Reduction {
        /// Estimate of the error at the end of the band.
        estimate: f64,
        /// Accuracy demanded.
        accuracy: f64,
        /// End of the band, Hz.
        band: f64,
        /// Highest cut-off tried, Hz.
        cut_off: f64,
    },
    /// A material constant out of its range.
    #[error("material: {key} = {value} is outside its range ({range})")]
    Material {
        /// Constant.
        key: &'static str,
        /// Value found.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// A section dimension or constant that makes no section.
    #[error("{shape} section: {key} = {value} is outside its range ({range})")]
    Section {
        /// Shape of the section.
        shape: &'static str,
        /// Dimension or constant.
        key: &'static str,
        /// Value found.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// Walls that fill or overfill a section.
    #[error(
        "{shape} section: walls of {thickness} m on both sides leave nothing of {outer} m: give less than half, or a solid section"
    )]
    SectionWall {
        /// Shape of the section.
        shape: &'static str,
        /// Wall thickness, m.
        thickness: f64,
        /// Outer dimension that the wall must leave open, m.
        outer: f64,
    },
    /// A property of an element out of its range.
    #[error("{element} at node(s) {nodes:?}: {key} = {value} is outside its range ({range})")]
    ElementProperty {
        /// Kind of element.
        element: &'static str,
        /// Its nodes.
        nodes: Vec<usize>,
        /// Property.
        key: &'static str,
        /// Value found.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// A line element without length.
    #[error(
        "{element} between nodes {} and {}: length {length} m; its ends (offsets included) must lie apart",
        nodes[0], nodes[1]
    )]
    ZeroLength {
        /// Kind of element.
        element: &'static str,
        /// Its nodes.
        nodes: [usize; 2],
        /// Length found, m.
        length: f64,
    },
    /// An orientation vector that shows no direction across the beam.
    #[error(
        "beam between nodes {} and {}: the orientation vector {vector:?} is zero or parallel to the beam's axis; give one across it",
        nodes[0], nodes[1]
    )]
    Orientation {
        /// The beam's nodes.
        nodes: [usize; 2],
        /// Vector found.
        vector: [f64; 3],
    },
    /// End releases that let the beam itself move freely.
    #[error(
        "beam between nodes {} and {}: its end releases leave it a free motion of its own (twist, sliding or swing); take one release back",
        nodes[0], nodes[1]
    )]
    Release {
        /// The beam's nodes.
        nodes: [usize; 2],
    },
    /// An element with another number of nodes than its kind has.
    #[error("{element} with {found} nodes: it has {expected}")]
    NodeCount {
        /// Kind of element.
        element: &'static str,
        /// Nodes given.
        found: usize,
        /// Nodes of the kind.
        expected: usize,
    },
    /// A solid whose nodes are numbered inside out.
    #[error(
        "{element} of nodes {nodes:?} is inside out (Jacobian {jacobian:e} m³ at its centre): number one face the other way round"
    )]
    InsideOut {
        /// Kind of element.
        element: &'static str,
        /// Its nodes.
        nodes: Vec<usize>,
        /// Jacobian determinant at the centre, m³.
        jacobian: f64,
    },
    /// A solid folded so that its Jacobian is not positive everywhere.
    #[error(
        "{element} of nodes {nodes:?}: Jacobian {jacobian:e} m³ at the reference point {place:?}; it must be above 0 everywhere: move its nodes or refine there"
    )]
    Jacobian {
        /// Kind of element.
        element: &'static str,
        /// Its nodes.
        nodes: Vec<usize>,
        /// Least Jacobian determinant found, m³.
        jacobian: f64,
        /// Where, in reference coordinates.
        place: [f64; 3],
    },
    /// A spring or dashpot that would turn a rigid rotation into force.
    #[error(
        "{element} between nodes {} and {}: its ends lie {distance} m apart and a translation axis is not along the line between them, so that it would resist a rigid rotation; join its ends in one place by a rigid link",
        nodes[0], nodes[1]
    )]
    SpringSpan {
        /// Kind of element.
        element: &'static str,
        /// Its nodes.
        nodes: [usize; 2],
        /// Distance between the nodes, m.
        distance: f64,
    },
    /// An inertia that no body has.
    #[error(
        "point mass at node {node}: principal inertias {principal:?} kg·m² belong to no body: each must be at least 0 and at most the sum of the others"
    )]
    Inertia {
        /// Node.
        node: usize,
        /// Principal moments of inertia, kg·m².
        principal: [f64; 3],
    },
    /// A node that the model does not have.
    #[error("{item} names node {node}, but the model has {count} nodes (0 to {})", count.wrapping_sub(1))]
    UnknownNode {
        /// Who names it.
        item: String,
        /// Node named.
        node: usize,
        /// Nodes of the model.
        count: usize,
    },
    /// A coordinate that is no number.
    #[error("node {node} lies at {position:?}: coordinates must be finite")]
    Coordinate {
        /// Node.
        node: usize,
        /// Position found, m.
        position: [f64; 3],
    },
    /// A rotation asked of a node that has translations only.
    #[error("{item} names {freedom}, but nothing at that node has rotations")]
    NoRotation {
        /// Who names it.
        item: String,
        /// Freedom named.
        freedom: Freedom,
    },
    /// A freedom bound twice.
    #[error(
        "{freedom} is bound twice, by `{first}` and by `{second}`: take one away, or bind the freedom that it follows"
    )]
    Overdetermined {
        /// Freedom.
        freedom: Freedom,
        /// Constraint that came first.
        first: String,
        /// Constraint that came second.
        second: String,
    },
    /// Constraints that follow each other in a ring.
    #[error("constraints follow each other in a ring: {}; cut it at one node", ring(chain))]
    Cycle {
        /// Freedoms of the ring, each bound by the next.
        chain: Vec<Freedom>,
    },
    /// A constraint whose coefficients are no numbers.
    #[error("constraint `{name}`: {what}")]
    Constraint {
        /// Its name.
        name: String,
        /// What is wrong.
        what: &'static str,
    },
    /// A distributing coupling whose nodes do not span a rotation.
    #[error(
        "coupling `{name}` spreads a motion with rotations over nodes {nodes:?}, which lie in one line or one place: give at least three that do not"
    )]
    Coupling {
        /// Its name.
        name: String,
        /// Its nodes.
        nodes: Vec<usize>,
    },
    /// Two nodes in one place with nothing between them.
    #[error(
        "nodes {first} and {second} lie in one place ({position:?} m) and nothing joins them: merge them, tie them or put a spring between them"
    )]
    DuplicateNodes {
        /// First node.
        first: usize,
        /// Second node.
        second: usize,
        /// Place, m.
        position: [f64; 3],
    },
    /// Nodes that nothing uses.
    #[error("nodes {nodes:?} belong to no element: take them out or attach something")]
    LooseNodes {
        /// The nodes (the first twenty).
        nodes: Vec<usize>,
    },
    /// A model in more pieces than asked for.
    #[error("the model falls into {found} unconnected parts, {expected} expected: {}", list(parts))]
    Parts {
        /// Parts found.
        found: usize,
        /// Parts expected.
        expected: usize,
        /// Each part: element groups, number of nodes, first node.
        parts: Vec<String>,
    },
    /// A structure that can move without force.
    #[error("the structure can move without force: {}", list(motions))]
    Mechanism {
        /// Each free motion and its nodes.
        motions: Vec<String>,
    },
    /// Masses that do not add up.
    #[error(
        "the mass along {axis} adds up to {found} kg, but the elements weigh {expected} kg: a constraint or a release loses mass"
    )]
    Mass {
        /// Axis.
        axis: char,
        /// Mass found in the matrix, kg.
        found: f64,
        /// Mass of the elements, kg.
        expected: f64,
    },
    /// A factor or solve that failed.
    #[error("the matrix of {size} rows cannot be factored: {reason}")]
    Factor {
        /// Rows.
        size: usize,
        /// What the solver says.
        reason: String,
    },
}

fn ring(chain: &[Freedom]) -> String {
    let names: Vec<String> = chain.iter().map(Freedom::to_string).collect();
    names.join(" ← ")
}

fn list(items: &[String]) -> String {
    items.join("; ")
}
