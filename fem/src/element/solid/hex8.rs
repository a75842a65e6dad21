//! Hexahedron of 8 nodes with enhanced strains.

use super::{Enhancement, Point, Solid, SolidShape, Strain, compatible_strain, quadrature};
use nalgebra::{DMatrix, Matrix3, SMatrix};

/// Trilinear hexahedron, enhanced by 12 strain modes.
///
/// Beside the strain of its displacement it holds $\tilde\varepsilon = \frac{j_0}{j} J_0^{-T} E J_0^{-1}$,
/// $J_0$ and $j_0$ at the centre, with (in reference axes)
///
/// - normal strains $E_{\xi\xi} = \xi$, $E_{\eta\eta} = \eta$, $E_{\zeta\zeta} = \zeta$ and shears
///   $E_{\xi\eta} = \xi, \eta$; $E_{\eta\zeta} = \eta, \zeta$; $E_{\zeta\xi} = \zeta, \xi$: free bending,
/// - dilatations $\xi\eta$, $\eta\zeta$, $\zeta\xi$: with the first three they make every term of the
///   divergence free, so that nothing locks as $\nu \to ½$.
///
/// Each mode integrates to zero with the two-point rule, so constant stresses do no work on it and the
/// patch test holds on any shape. The amplitudes are eliminated in the element. After Simo & Rifai
/// (1990) and Simo, Armero & Taylor (1993); small strain only. Sharply tapered or skewed elements
/// remain stiff in bending, as all eight-node elements that pass the patch test do (MacNeal).
/// Nodes in Gmsh's order. Order 2 in displacement and frequency.
#[derive(Debug, Clone, Copy)]
pub struct Hex8Shape;

pub(super) const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

const MODES: usize = 12;

/// Enhanced strains at `xi`, one a mode, by the Jacobian `centre` of the element's centre and the
/// determinant at `xi`.
pub(super) fn enhanced_strain(centre: Matrix3<f64>, xi: [f64; 3], determinant: f64) -> [Strain; MODES] {
    let scale = centre.determinant() / determinant;
    let inverse = centre.try_inverse().unwrap_or_else(Matrix3::zeros);
    let mut strain = [Strain::zeros(); MODES];
    let [x, y, z] = xi;
    let shears = [(0, 1, x), (0, 1, y), (1, 2, y), (1, 2, z), (2, 0, z), (2, 0, x)];
    let normals = [(0, 0, x), (1, 1, y), (2, 2, z)];
    for (mode, &(i, j, value)) in normals.iter().chain(&shears).enumerate() {
        // J₀⁻ᵀ (e_i e_jᵀ + e_j e_iᵀ)/2 J₀⁻¹
        let (row_i, row_j) = (inverse.row(i).transpose(), inverse.row(j).transpose());
        let tensor = (row_i * row_j.transpose() + row_j * row_i.transpose()) * (0.5 * value * scale);
        strain[mode] = Strain::new(
            tensor[(0, 0)],
            tensor[(1, 1)],
            tensor[(2, 2)],
            2.0 * tensor[(0, 1)],
            2.0 * tensor[(1, 2)],
            2.0 * tensor[(2, 0)],
        );
    }
    for (mode, value) in [x * y, y * z, z * x].into_iter().enumerate() {
        strain[9 + mode].fixed_rows_mut::<3>(0).fill(scale * value);
    }
    strain
}

impl SolidShape for Hex8Shape {
    const NAME: &'static str = "hex8";
    const NODES: usize = 8;
    const LUMPED_BY_ROWS: bool = true;

    fn reference() -> &'static [[f64; 3]] {
        &CORNERS
    }

    fn centre() -> [f64; 3] {
        [0.0; 3]
    }

    fn values(xi: [f64; 3]) -> Vec<f64> {
        CORNERS.iter().map(|c| (0..3).map(|i| 1.0 + c[i] * xi[i]).product::<f64>() / 8.0).collect()
    }

    fn gradients(xi: [f64; 3]) -> Vec<[f64; 3]> {
        let gradient = |c: &[f64; 3]| {
            let f = [0, 1, 2].map(|i| 1.0 + c[i] * xi[i]);
            [c[0] * f[1] * f[2] / 8.0, f[0] * c[1] * f[2] / 8.0, f[0] * f[1] * c[2] / 8.0]
        };
        CORNERS.iter().map(gradient).collect()
    }

    fn rule() -> &'static [Point] {
        &quadrature::CUBE_8
    }

    fn mass_rule() -> &'static [Point] {
        &quadrature::CUBE_27
    }

    /// $A = -K_{\alpha\alpha}^{-1} K_{\alpha u}$: the amplitudes that leave no work on the modes.
    fn enhancement(solid: &Solid<Self>) -> Enhancement {
        let elasticity = solid.material.elasticity();
        let centre = solid.jacobian(Self::centre());
        let mut own = SMatrix::<f64, MODES, MODES>::zeros();
        let mut mixed = DMatrix::zeros(MODES, 3 * Self::NODES);
        for point in Self::rule() {
            let place = solid.place(point.xi);
            let modes = enhanced_strain(centre, point.xi, place.determinant);
            let stresses = modes.map(|mode| elasticity * mode * (point.weight * place.determinant));
            let strains = compatible_strain(&place);
            for (i, stress) in stresses.iter().enumerate() {
                for (j, mode) in modes.iter().enumerate() {
                    own[(i, j)] += stress.dot(mode);
                }
                for (j, strain) in strains.iter().enumerate() {
                    mixed[(i, j)] += stress.dot(strain);
                }
            }
        }
        // positive definite: the modes are independent at the eight points
        let amplitudes = own.cholesky().map(|factor| -factor.solve(&mixed));
        amplitudes.map_or(Enhancement::None, Enhancement::Modes)
    }
}
