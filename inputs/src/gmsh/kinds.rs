//! Gmsh's element types by number, and what becomes of them here.

/// Shape of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    Point,
    Line,
    Triangle,
    Quadrilateral,
    Tetrahedron,
    Hexahedron,
    Prism,
    Pyramid,
}

use Family::*;

/// One of Gmsh's element types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Kind {
    pub(super) family: Family,
    /// Polynomial order of its edges.
    pub(super) order: u8,
    /// Number of its nodes.
    pub(super) nodes: u16,
}

/// Number in the file, shape, order, nodes: those that Gmsh 4 can write.
const KINDS: [(u16, Family, u8, u16); 102] = [
    (15, Point, 0, 1),
    (84, Line, 0, 1),
    (1, Line, 1, 2),
    (8, Line, 2, 3),
    (26, Line, 3, 4),
    (27, Line, 4, 5),
    (28, Line, 5, 6),
    (62, Line, 6, 7),
    (63, Line, 7, 8),
    (64, Line, 8, 9),
    (65, Line, 9, 10),
    (66, Line, 10, 11),
    (85, Triangle, 0, 1),
    (2, Triangle, 1, 3),
    (9, Triangle, 2, 6),
    (20, Triangle, 3, 9),
    (21, Triangle, 3, 10),
    (22, Triangle, 4, 12),
    (23, Triangle, 4, 15),
    (24, Triangle, 5, 15),
    (25, Triangle, 5, 21),
    (42, Triangle, 6, 28),
    (43, Triangle, 7, 36),
    (44, Triangle, 8, 45),
    (45, Triangle, 9, 55),
    (46, Triangle, 10, 66),
    (52, Triangle, 6, 18),
    (53, Triangle, 7, 21),
    (54, Triangle, 8, 24),
    (55, Triangle, 9, 27),
    (56, Triangle, 10, 30),
    (86, Quadrilateral, 0, 1),
    (3, Quadrilateral, 1, 4),
    (10, Quadrilateral, 2, 9),
    (16, Quadrilateral, 2, 8),
    (36, Quadrilateral, 3, 16),
    (37, Quadrilateral, 4, 25),
    (38, Quadrilateral, 5, 36),
    (39, Quadrilateral, 3, 12),
    (40, Quadrilateral, 4, 16),
    (41, Quadrilateral, 5, 20),
    (47, Quadrilateral, 6, 49),
    (48, Quadrilateral, 7, 64),
    (49, Quadrilateral, 8, 81),
    (50, Quadrilateral, 9, 100),
    (51, Quadrilateral, 10, 121),
    (57, Quadrilateral, 6, 24),
    (58, Quadrilateral, 7, 28),
    (59, Quadrilateral, 8, 32),
    (60, Quadrilateral, 9, 36),
    (61, Quadrilateral, 10, 40),
    (87, Tetrahedron, 0, 1),
    (4, Tetrahedron, 1, 4),
    (11, Tetrahedron, 2, 10),
    (29, Tetrahedron, 3, 20),
    (30, Tetrahedron, 4, 35),
    (31, Tetrahedron, 5, 56),
    (32, Tetrahedron, 4, 22),
    (33, Tetrahedron, 5, 28),
    (71, Tetrahedron, 6, 84),
    (72, Tetrahedron, 7, 120),
    (73, Tetrahedron, 8, 165),
    (74, Tetrahedron, 9, 220),
    (75, Tetrahedron, 10, 286),
    (79, Tetrahedron, 6, 34),
    (80, Tetrahedron, 7, 40),
    (81, Tetrahedron, 8, 46),
    (82, Tetrahedron, 9, 52),
    (83, Tetrahedron, 10, 58),
    (137, Tetrahedron, 3, 16),
    (88, Hexahedron, 0, 1),
    (5, Hexahedron, 1, 8),
    (12, Hexahedron, 2, 27),
    (17, Hexahedron, 2, 20),
    (92, Hexahedron, 3, 64),
    (93, Hexahedron, 4, 125),
    (94, Hexahedron, 5, 216),
    (95, Hexahedron, 6, 343),
    (96, Hexahedron, 7, 512),
    (97, Hexahedron, 8, 729),
    (98, Hexahedron, 9, 1000),
    (99, Hexahedron, 3, 32),
    (100, Hexahedron, 4, 44),
    (101, Hexahedron, 5, 56),
    (102, Hexahedron, 6, 68),
    (103, Hexahedron, 7, 80),
    (104, Hexahedron, 8, 92),
    (105, Hexahedron, 9, 104),
    (89, Prism, 0, 1),
    (6, Prism, 1, 6),
    (13, Prism, 2, 18),
    (18, Prism, 2, 15),
    (90, Prism, 3, 40),
    (91, Prism, 4, 75),
    (132, Pyramid, 0, 1),
    (7, Pyramid, 1, 5),
    (14, Pyramid, 2, 14),
    (19, Pyramid, 2, 13),
    (118, Pyramid, 3, 30),
    (119, Pyramid, 4, 55),
    (125, Pyramid, 3, 21),
    (126, Pyramid, 4, 29),
];

impl Kind {
    /// The type of a number in the file.
    pub(super) fn numbered(number: i64) -> Option<Self> {
        let found = KINDS.iter().find(|(known, ..)| i64::from(*known) == number);
        found.map(|&(_, family, order, nodes)| Self { family, order, nodes })
    }

    /// Dimension of the shape.
    pub(super) fn dimension(self) -> u8 {
        match self.family {
            Point => 0,
            Line => 1,
            Triangle | Quadrilateral => 2,
            Tetrahedron | Hexahedron | Prism | Pyramid => 3,
        }
    }

    /// Whether its nodes are those of a tensor product.
    pub(super) fn is_tensor_product(self) -> bool {
        matches!(self.family, Line | Quadrilateral | Hexahedron)
            && usize::from(self.nodes) == (usize::from(self.order) + 1).pow(u32::from(self.dimension()))
    }

    /// Number of its corners, which come first among its nodes.
    pub(super) fn corners(self) -> usize {
        let corners = match self.family {
            Point => 1,
            Line => 2,
            Triangle => 3,
            Quadrilateral | Tetrahedron => 4,
            Pyramid => 5,
            Prism => 6,
            Hexahedron => 8,
        };
        corners.min(usize::from(self.nodes))
    }

    /// For messages: `8-node hexahedron`.
    pub(super) fn name(self) -> String {
        let family = match self.family {
            Point => "point",
            Line => "line",
            Triangle => "triangle",
            Quadrilateral => "quadrilateral",
            Tetrahedron => "tetrahedron",
            Hexahedron => "hexahedron",
            Prism => "prism",
            Pyramid => "pyramid",
        };
        format!("{}-node {family}", self.nodes)
    }

    /// For every node in tensor order (first local axis fastest), its place in Gmsh's order.
    ///
    /// Quadrilaterals and hexahedra of order 1 and 2; `None` for all else.
    pub(super) fn tensor_order(self) -> Option<&'static [u8]> {
        match (self.family, self.nodes) {
            (Quadrilateral, 4) => Some(&[0, 1, 3, 2]),
            (Quadrilateral, 9) => Some(&[0, 4, 1, 7, 8, 5, 3, 6, 2]),
            (Hexahedron, 8) => Some(&[0, 1, 3, 2, 4, 5, 7, 6]),
            (Hexahedron, 27) => Some(&[
                0, 8, 1, 9, 20, 11, 3, 13, 2, // ζ = −1
                10, 21, 12, 22, 26, 23, 15, 24, 14, // ζ = 0
                4, 16, 5, 17, 25, 18, 7, 19, 6, // ζ = +1
            ]),
            _ => None,
        }
    }
}
