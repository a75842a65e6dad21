//! Hexahedron of 20 nodes.

use super::{Enhancement, Point, Solid, SolidShape, compatible_strain, hex8::CORNERS, quadrature};
use nalgebra::{DMatrix, Matrix4, Vector3, Vector4};
use std::sync::LazyLock;

/// Serendipity hexahedron of 20 nodes, 27 quadrature points, dilatation projected.
///
/// The divergence of the displacement is replaced by its $L_2$ projection on $1, x, y, z$ within the
/// element: four volumetric constraints for twelve freedoms an element as $\nu \to ½$, so nothing
/// locks, and every linear strain is still exact. The deviatoric part is fully integrated: the
/// stiffness has the six rigid modes and no other (an eight-point rule would leave six more).
/// Nodes in Gmsh's order. Order 3 in displacement, 4 in frequency, on parallelepipeds and on meshes
/// that tend to them; elements that stay distorted as they shrink lose one order (Arnold, Boffi & Falk
/// 2002).
#[derive(Debug, Clone, Copy)]
pub struct Hex20Shape;

/// Ends of the edges, in Gmsh's order.
pub(crate) const EDGES: [[usize; 2]; 12] =
    [[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]];

static NODES: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
    let middle = |e: &[usize; 2]| [0, 1, 2].map(|i| (CORNERS[e[0]][i] + CORNERS[e[1]][i]) / 2.0);
    CORNERS.iter().copied().chain(EDGES.iter().map(middle)).collect()
});

/// Value and gradient of the shape function of the node at `c`.
fn shape(c: &[f64; 3], xi: [f64; 3]) -> (f64, [f64; 3]) {
    // one factor an axis: 1 + c ξ at a corner coordinate, 1 - ξ² at a middle one
    let middle = c.contains(&0.0);
    let f = [0, 1, 2].map(|i| if c[i] == 0.0 { 1.0 - xi[i] * xi[i] } else { 1.0 + c[i] * xi[i] });
    let d = [0, 1, 2].map(|i| if c[i] == 0.0 { -2.0 * xi[i] } else { c[i] });
    let product = f[0] * f[1] * f[2];
    let slopes = [d[0] * f[1] * f[2], f[0] * d[1] * f[2], f[0] * f[1] * d[2]];
    if middle {
        return (product / 4.0, slopes.map(|s| s / 4.0));
    }
    let sum = (0..3).map(|i| c[i] * xi[i]).sum::<f64>() - 2.0;
    (product * sum / 8.0, [0, 1, 2].map(|i| (slopes[i] * sum + product * c[i]) / 8.0))
}

impl SolidShape for Hex20Shape {
    const NAME: &'static str = "hex20";
    const NODES: usize = 20;
    const LUMPED_BY_ROWS: bool = false;

    fn reference() -> &'static [[f64; 3]] {
        &NODES
    }

    fn centre() -> [f64; 3] {
        [0.0; 3]
    }

    fn values(xi: [f64; 3]) -> Vec<f64> {
        NODES.iter().map(|c| shape(c, xi).0).collect()
    }

    fn gradients(xi: [f64; 3]) -> Vec<[f64; 3]> {
        NODES.iter().map(|c| shape(c, xi).1).collect()
    }

    fn rule() -> &'static [Point] {
        &quadrature::CUBE_27
    }

    fn mass_rule() -> &'static [Point] {
        &quadrature::CUBE_27
    }

    fn enhancement(solid: &Solid<Self>) -> Enhancement {
        let centre = solid.centre_of_coordinates();
        let mut gram = Matrix4::zeros();
        let mut moments = DMatrix::zeros(4, 3 * Self::NODES);
        for point in Self::rule() {
            let place = solid.place(point.xi);
            let x = Vector3::from(solid.position(&Self::values(point.xi))) - centre;
            let monomials = Vector4::new(1.0, x.x, x.y, x.z);
            let weight = point.weight * place.determinant;
            gram += monomials * monomials.transpose() * weight;
            for (j, strain) in compatible_strain(&place).iter().enumerate() {
                let divergence = strain[0] + strain[1] + strain[2];
                (0..4).for_each(|k| moments[(k, j)] += weight * divergence * monomials[k]);
            }
        }
        // positive definite: the four monomials are independent in a volume
        gram.cholesky().map_or(Enhancement::None, |factor| Enhancement::Dilatation(factor.solve(&moments)))
    }
}
