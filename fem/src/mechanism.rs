//! Free motions: what a structure can do without force, named by its motion and its nodes.

use crate::{
    FemError,
    assembly::{Assembly, rigid_motion},
    check::components,
    sparse::SymmetricMatrix,
};
use faer::{
    Mat, Side,
    linalg::solvers::Solve,
    sparse::{SparseColMat, Triplet},
};
use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use std::fmt;

/// A motion of zero strain energy.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeMotion {
    /// Every freedom, scaled so that the largest is 1 (rotations times the structure's size).
    pub displacement: Vec<f64>,
    /// Nodes that move.
    pub nodes: Vec<usize>,
    /// Motion in words.
    pub motion: String,
}

impl fmt::Display for FreeMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: Vec<String> = self.nodes.iter().take(8).map(usize::to_string).collect();
        let more = self.nodes.len().saturating_sub(shown.len());
        let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        write!(f, "{} of node(s) {}{rest}", self.motion, shown.join(", "))
    }
}

/// Most motions looked for at once.
const BLOCK: usize = 12;
/// Shift that makes the scaled stiffness positive definite.
const SHIFT: f64 = 1e-10;
/// A unit vector is free where the scaled stiffness leaves less than this of it. The lowest bending of
/// a row of $n$ beams lies near $n^{-4}$: a thousand elements in a row stay above.
const FREE: f64 = 1e-13;

/// Free motions of an assembled structure with `stiffness` over its free freedoms: at most a dozen.
///
/// Null vectors of $\hat K = D^{-1/2} K D^{-1/2}$, $D$ the diagonal, by inverse iteration on
/// $\hat K + 10^{-10} I$; vectors are then combined so that each moves as few nodes as possible.
/// Errors: a factor that fails ($K$ indefinite: geometric stiffness beyond buckling).
pub fn free_motions(
    assembly: &Assembly<'_>,
    stiffness: &SymmetricMatrix,
) -> Result<Vec<FreeMotion>, FemError> {
    let diagonal = diagonal(stiffness);
    let largest = diagonal.iter().copied().fold(0.0, f64::max);
    let empty: Vec<bool> = diagonal.iter().map(|&d| d <= 1e-15 * largest || d == 0.0).collect();
    let scale: Vec<f64> =
        diagonal.iter().zip(&empty).map(|(d, none)| if *none { 1.0 } else { 1.0 / d.sqrt() }).collect();
    let mut vectors: Vec<Vec<f64>> = vec![];
    for k in (0..empty.len()).filter(|&k| empty[k]).take(BLOCK) {
        vectors.push((0..empty.len()).map(|i| if i == k { 1.0 } else { 0.0 }).collect());
    }
    for column in null_space(stiffness, &scale, &empty)?.column_iter() {
        vectors.push(column.iter().zip(&scale).map(|(x, s)| x * s).collect());
    }
    named(assembly, &vectors)
}

/// Names motions over the free freedoms that are known to cost no force. Errors: a length that does
/// not fit.
pub fn named(assembly: &Assembly<'_>, motions: &[Vec<f64>]) -> Result<Vec<FreeMotion>, FemError> {
    let support = vec![0.0; assembly.reduction().supports().len()];
    let expand = |motion: &Vec<f64>| assembly.reduction().expand_linear(motion, &support);
    let full = motions.iter().map(expand).collect::<Result<Vec<_>, _>>()?;
    Ok(describe(assembly, full))
}

/// [`FemError::Mechanism`] where the structure has free motions. Errors: also those of
/// [`free_motions`].
pub fn refuse_mechanism(assembly: &Assembly<'_>, stiffness: &SymmetricMatrix) -> Result<(), FemError> {
    let motions = free_motions(assembly, stiffness)?;
    if motions.is_empty() {
        return Ok(());
    }
    Err(FemError::Mechanism { motions: motions.iter().map(FreeMotion::to_string).collect() })
}

fn diagonal(matrix: &SymmetricMatrix) -> Vec<f64> {
    let mut diagonal = vec![0.0; matrix.size()];
    entries(matrix).filter(|(i, j, _)| i == j).for_each(|(i, _, value)| diagonal[i] = value);
    diagonal
}

fn entries(matrix: &SymmetricMatrix) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
    (0..matrix.size()).flat_map(move |column| {
        let range = matrix.starts()[column]..matrix.starts()[column + 1];
        range.map(move |k| (matrix.rows()[k], column, matrix.values()[k]))
    })
}

/// Unit vectors that the scaled stiffness sends to zero, one a column; rows marked `empty` are left
/// out.
fn null_space(matrix: &SymmetricMatrix, scale: &[f64], empty: &[bool]) -> Result<DMatrix<f64>, FemError> {
    let n = matrix.size();
    let scaled: Vec<(usize, usize, f64)> = entries(matrix)
        .filter(|&(i, j, _)| !empty[i] && !empty[j])
        .map(|(i, j, value)| (i, j, value * scale[i] * scale[j]))
        .chain((0..n).filter(|&i| empty[i]).map(|i| (i, i, 1.0)))
        .collect();
    let scaled = SymmetricMatrix::assemble(n, scaled)?;
    let failed = |reason: String| FemError::Factor { size: n, reason };
    let shifted: Vec<Triplet<usize, usize, f64>> = entries(&scaled)
        .map(|(i, j, value)| Triplet::new(i, j, value))
        .chain((0..n).map(|i| Triplet::new(i, i, SHIFT)))
        .collect();
    let shifted =
        SparseColMat::try_new_from_triplets(n, n, &shifted).map_err(|e| failed(format!("{e:?}")))?;
    let factor = shifted.sp_cholesky(Side::Lower).map_err(|e| failed(format!("{e:?}")))?;
    let columns = BLOCK.min(n);
    // an arbitrary block without structure, the same in every run
    let mut block =
        DMatrix::from_fn(n, columns, |i, j| ((i * columns + j) as f64 * 0.754_877_666).fract() - 0.5);
    for _ in 0..8 {
        let right = Mat::from_fn(n, columns, |i, j| block[(i, j)]);
        let solved = factor.solve(&right);
        block = DMatrix::from_fn(n, columns, |i, j| solved[(i, j)]).qr().q();
    }
    let image = apply(&scaled, &block);
    let ritz = (block.transpose() * image).symmetric_eigen();
    let vectors = block * ritz.eigenvectors;
    let images = apply(&scaled, &vectors);
    let free: Vec<usize> = (0..columns).filter(|&k| images.column(k).norm() < FREE).collect();
    Ok(vectors.select_columns(&free))
}

fn apply(matrix: &SymmetricMatrix, block: &DMatrix<f64>) -> DMatrix<f64> {
    let mut image = DMatrix::zeros(block.nrows(), block.ncols());
    let mut column = vec![0.0; block.nrows()];
    for k in 0..block.ncols() {
        matrix.multiply(block.column(k).as_slice(), &mut column);
        image.column_mut(k).copy_from_slice(&column);
    }
    image
}

/// Names each motion: first those that are a plain rigid motion of a connected part, then the rest,
/// combined so that each has a freedom to itself.
fn describe(assembly: &Assembly<'_>, vectors: Vec<Vec<f64>>) -> Vec<FreeMotion> {
    let size = size_of(assembly.model().nodes());
    let numbering = assembly.numbering();
    let weight: Vec<f64> = (0..numbering.size())
        .map(|p| if numbering.freedom(p).component.index() < 3 { 1.0 } else { size })
        .collect();
    let mut space = orthonormal(
        vectors.iter().map(|v| DVector::from_fn(v.len(), |p, _| v[p] * weight[p])).collect(),
        0.0,
    );
    let mut motions = vec![];
    for plain in plain_motions(assembly, &weight) {
        let mut outside = plain.clone();
        space.iter().for_each(|v| outside -= v * v.dot(&plain));
        if outside.norm() > 1e-6 {
            continue;
        }
        // what is left is the part of the space across this motion
        let rest = space.iter().map(|v| v - &plain * v.dot(&plain)).collect();
        space = orthonormal(rest, 1e-6);
        motions.push(plain);
    }
    motions.extend(echelon(space));
    let unscaled = |v: DVector<f64>| (0..v.len()).map(|p| v[p] / weight[p]).collect();
    motions.into_iter().filter_map(|v| name(assembly, unscaled(v), &weight, size)).collect()
}

/// Gram–Schmidt; vectors of which less than `least` is new are dropped.
fn orthonormal(vectors: Vec<DVector<f64>>, least: f64) -> Vec<DVector<f64>> {
    let mut base: Vec<DVector<f64>> = vec![];
    for vector in vectors {
        let size = vector.norm();
        let mut rest = if size > 0.0 { vector / size } else { vector };
        let share = size.min(1.0);
        // twice is enough
        for _ in 0..2 {
            for known in &base {
                rest -= known * known.dot(&rest);
            }
        }
        if rest.norm() * share > least {
            base.push(rest.normalize());
        }
    }
    base
}

/// Unit translations and rotations, about its centre, of each connected part; weighted, of norm 1.
fn plain_motions(assembly: &Assembly<'_>, weight: &[f64]) -> Vec<DVector<f64>> {
    let (numbering, positions) = (assembly.numbering(), assembly.model().nodes());
    let mut motions = vec![];
    for part in components(assembly.model()) {
        let sum: Vector3<f64> = part.nodes.iter().map(|&n| Vector3::from(positions[n])).sum();
        let centre = sum / part.nodes.len() as f64;
        for kind in 0..6 {
            let mut motion = DVector::zeros(numbering.size());
            for &node in &part.nodes {
                let own = rigid_motion(Vector3::from(positions[node]) - centre);
                for i in 0..numbering.count(node) {
                    let place = numbering.start(node) + i;
                    motion[place] = own[(i, kind)] * weight[place];
                }
            }
            // nodes without rotations in one place or line do not show every rotation
            if motion.norm() > 0.0 {
                motions.push(motion.normalize());
            }
        }
    }
    motions
}

/// Combines vectors so that each has a freedom to itself.
fn echelon(mut vectors: Vec<DVector<f64>>) -> Vec<DVector<f64>> {
    for k in 0..vectors.len() {
        let own = vectors[k].clone();
        let pivot = own.iamax();
        for (other, vector) in vectors.iter_mut().enumerate() {
            if other != k {
                *vector -= &own * (vector[pivot] / own[pivot]);
            }
        }
    }
    vectors
}

fn size_of(nodes: &[[f64; 3]]) -> f64 {
    let spread = |axis: usize| {
        let values = nodes.iter().map(|x| x[axis]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    let size = (0..3).map(spread).fold(0.0, f64::max);
    if size > 0.0 { size } else { 1.0 }
}

fn name(assembly: &Assembly<'_>, mut vector: Vec<f64>, weight: &[f64], size: f64) -> Option<FreeMotion> {
    let largest = vector.iter().zip(weight).map(|(v, w)| (v * w).abs()).fold(0.0, f64::max);
    if largest == 0.0 {
        return None;
    }
    vector.iter_mut().for_each(|v| *v /= largest);
    let numbering = assembly.numbering();
    let moves = |node: usize| {
        let range = numbering.start(node)..numbering.start(node) + numbering.count(node);
        range.into_iter().any(|p| (vector[p] * weight[p]).abs() > 1e-6)
    };
    let nodes: Vec<usize> = (0..numbering.nodes()).filter(|&n| moves(n)).collect();
    let motion = motion(assembly, &vector, &nodes, size);
    Some(FreeMotion { displacement: vector, nodes, motion })
}

/// The motion in words: the rigid motion that fits the moving nodes, if one does.
fn motion(assembly: &Assembly<'_>, vector: &[f64], nodes: &[usize], size: f64) -> String {
    let (numbering, positions) = (assembly.numbering(), assembly.model().nodes());
    let centre: Vector3<f64> =
        nodes.iter().map(|&n| Vector3::from(positions[n])).sum::<Vector3<f64>>() / nodes.len().max(1) as f64;
    let rows: usize = nodes.iter().map(|&n| numbering.count(n)).sum();
    // rotations of the fit and of the nodes in units of 1/size
    let mut fit = DMatrix::zeros(rows, 6);
    let mut target = DVector::zeros(rows);
    let mut row = 0;
    for &node in nodes {
        let own = rigid_motion(Vector3::from(positions[node]) - centre);
        for i in 0..numbering.count(node) {
            let unit = if i < 3 { 1.0 } else { size };
            target[row] = unit * vector[numbering.start(node) + i];
            for j in 0..6 {
                fit[(row, j)] = own[(i, j)] * unit / if j < 3 { 1.0 } else { size };
            }
            row += 1;
        }
    }
    let solution = least_squares(&fit, &target);
    let rest = (&fit * &solution - &target).norm();
    if rest > 1e-5 * target.norm() {
        return "a free deformation".into();
    }
    let rigid = Vector6::from_column_slice(solution.as_slice());
    let (shift, turn) = (rigid.fixed_rows::<3>(0).into_owned(), rigid.fixed_rows::<3>(3) / size);
    if turn.norm() * size < 1e-6 * shift.norm() {
        return format!("free translation along {}", direction(&shift));
    }
    // the axis passes where the velocity is along it
    let point = centre + turn.cross(&shift) / turn.norm_squared();
    let [x, y, z] = [0, 1, 2].map(|i| round(point[i]));
    format!("free rotation about {} through ({x}, {y}, {z}) m", direction(&turn))
}

/// Least solution of least squares by the eigenvectors of the normal matrix: nodes in a line leave a
/// rotation open.
fn least_squares(fit: &DMatrix<f64>, target: &DVector<f64>) -> DVector<f64> {
    let normal = (fit.transpose() * fit).symmetric_eigen();
    let right = normal.eigenvectors.transpose() * (fit.transpose() * target);
    let open = 1e-10 * normal.eigenvalues.amax();
    let inverse = normal.eigenvalues.map(|v| if v > open { 1.0 / v } else { 0.0 });
    &normal.eigenvectors * right.component_mul(&inverse)
}

fn direction(v: &Vector3<f64>) -> String {
    let unit = v / v.amax();
    let mut unit = unit / unit.norm();
    // the sign of a null vector is arbitrary: let the leading component be positive
    if unit[unit.iamax()] < 0.0 {
        unit = -unit;
    }
    for (i, name) in ["x", "y", "z"].into_iter().enumerate() {
        if unit[i] > 1.0 - 1e-9 {
            return name.into();
        }
    }
    let [x, y, z] = [0, 1, 2].map(|i| round(unit[i]));
    format!("({x}, {y}, {z})")
}

fn round(value: f64) -> f64 {
    // + 0 turns -0 into 0
    (value * 1e4).round() / 1e4 + 0.0
}
