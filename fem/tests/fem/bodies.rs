//! Bodies and solves that the tests share.

use faer::{
    Mat, Side,
    linalg::solvers::Solve,
    sparse::{SparseColMat, Triplet},
};
use hati_fem::{
    FemError,
    assembly::Assembly,
    material::Material,
    mesh::{SolidKind, SolidMesh, block},
    model::Model,
    sparse::SymmetricMatrix,
};
use nalgebra::{DMatrix, SymmetricEigen};

pub(crate) const KINDS: [SolidKind; 3] = [SolidKind::Hex8, SolidKind::Hex20, SolidKind::Tet10];

pub(crate) fn steel() -> Material {
    Material::new(200e9, 0.3, 8000.0).unwrap()
}

/// A block of solids in one group.
pub(crate) fn solid_model(
    kind: SolidKind,
    counts: [usize; 3],
    material: Material,
    map: impl Fn([f64; 3]) -> [f64; 3],
) -> (Model, SolidMesh) {
    let mesh = block(kind, counts, map);
    let mut model = Model::new();
    let group = model.group("block");
    mesh.add_to(&mut model, group, material).unwrap();
    (model, mesh)
}

fn triplets(a: &SymmetricMatrix) -> Vec<Triplet<usize, usize, f64>> {
    let column = |j: usize| a.starts()[j]..a.starts()[j + 1];
    (0..a.size()).flat_map(|j| column(j).map(move |k| Triplet::new(a.rows()[k], j, a.values()[k]))).collect()
}

/// The solver of the tests: a sparse Cholesky of its own.
pub(crate) fn cholesky(a: &SymmetricMatrix, b: &[f64]) -> Result<Vec<f64>, FemError> {
    let solver = Factor::new(a);
    Ok(solver.solve(b))
}

pub(crate) struct Factor(faer::sparse::linalg::solvers::Llt<usize, f64>);

impl Factor {
    pub(crate) fn new(a: &SymmetricMatrix) -> Self {
        let n = a.size();
        let matrix = SparseColMat::try_new_from_triplets(n, n, &triplets(a)).unwrap();
        Self(matrix.sp_cholesky(Side::Lower).unwrap())
    }

    pub(crate) fn solve(&self, b: &[f64]) -> Vec<f64> {
        let x = self.0.solve(Mat::from_fn(b.len(), 1, |i, _| b[i]));
        (0..b.len()).map(|i| x[(i, 0)]).collect()
    }
}

pub(crate) fn dense(a: &SymmetricMatrix) -> DMatrix<f64> {
    let mut full = DMatrix::zeros(a.size(), a.size());
    for t in triplets(a) {
        full[(t.row, t.col)] = t.val;
        full[(t.col, t.row)] = t.val;
    }
    full
}

/// Frequencies of $K\phi = \omega^2 M\phi$ in Hz, ascending, with $\phi^TM\phi = 1$ in the columns.
pub(crate) fn modes(stiffness: &SymmetricMatrix, mass: &SymmetricMatrix) -> (Vec<f64>, DMatrix<f64>) {
    let factor = dense(mass).cholesky().unwrap().l();
    let half = factor.solve_lower_triangular(&dense(stiffness)).unwrap();
    let reduced = factor.solve_lower_triangular(&half.transpose()).unwrap();
    let eigen = SymmetricEigen::new((&reduced + reduced.transpose()) * 0.5);
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let hertz = |k: &usize| eigen.eigenvalues[*k].max(0.0).sqrt() / std::f64::consts::TAU;
    let shapes =
        factor.transpose().solve_upper_triangular(&eigen.eigenvectors.select_columns(&order)).unwrap();
    (order.iter().map(hertz).collect(), shapes)
}

/// Prescribed motion of the supports from a field over positions.
pub(crate) fn prescribed(assembly: &Assembly<'_>, field: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
    let supports = assembly.reduction().supports().iter();
    supports.map(|f| field(assembly.model().nodes()[f.node])[f.component.index()]).collect()
}

pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// Observed order between two meshes whose sizes differ by `ratio`.
pub(crate) fn order(coarse: f64, fine: f64, ratio: f64) -> f64 {
    (coarse / fine).ln() / ratio.ln()
}
