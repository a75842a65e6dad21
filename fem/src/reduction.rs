//! Reduction of a structure to its retained freedoms and a few modes, after Craig & Bampton (1968).
//!
//! With the retained freedoms $b$ (interfaces, contacts) and the others $i$,
//!
//! $$ u = \begin{pmatrix} u_b \\ u_i \end{pmatrix} = T \begin{pmatrix} u_b \\ q \end{pmatrix}, \qquad
//!    T = \begin{pmatrix} I & 0 \\ X & \Phi \end{pmatrix}, \qquad
//!    X = -K_{ii}^{-1} K_{ib}, \qquad K_{ii} \Phi = M_{ii} \Phi \Lambda. $$
//!
//! $\hat K = T^T K T$ has the blocks $\hat K_{bb}$ and $\Lambda$ and nothing between them. Statics under forces
//! on the retained freedoms are exact, whatever the number of modes. What the dropped modes leave out of the
//! dynamic stiffness $D_{bb}(\omega)$ of the interface is
//! $-\omega^4 \sum_{k\,dropped} y_k y_k^T / (\omega_k^2 - \omega^2)$ with $y_k = Y^T \phi_k$,
//! $Y = M_{ib} + M_{ii} X$; it is bounded without them, since $\sum_{all} y_k y_k^T / \omega_k^2 =
//! Y^T K_{ii}^{-1} Y$ is known from statics. That bound chooses how many modes are kept.

use crate::FemError;
use crate::modes::{Modes, Search, Wanted, modes};
use crate::sparse::{Factor, Ordering, SOLVE_COLUMNS, Symbolic, SymmetricMatrix};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use std::f64::consts::PI;
use std::sync::Arc;

/// Cut-off as a multiple of the band, from the first that is tried to the last.
const CUT_OFFS: [f64; 6] = [1.5, 2.0, 3.0, 4.5, 7.0, 10.0];

/// How many modes of the structure held at its retained freedoms are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kept {
    /// So many of the lowest.
    Count(usize),
    /// All below a frequency, Hz.
    Below(f64),
    /// As many as an accuracy demands: cut-off at 1.5 times the band, then higher, until
    /// [`Reduction::estimate`] at the end of the band is within it in every direction.
    Accuracy {
        /// End of the band of the excitation, Hz.
        band: f64,
        /// Relative error of the forces at the retained freedoms.
        accuracy: f64,
    },
}

/// What the dropped modes leave out in one direction of the retained freedoms.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Missing {
    /// $r^T \hat K_{bb} r$, N/m.
    stiffness: f64,
    /// $r^T \hat M_{bb} r$, kg.
    mass: f64,
    /// $\sum_{dropped} (y_k^T r)^2 / \omega_k^2$, kg s².
    flexibility: f64,
}

/// A reduced structure: retained freedoms first, in the order given, then one coordinate for each mode.
#[derive(Debug, Clone)]
pub struct Reduction {
    retained: Vec<usize>,
    interior: Vec<usize>,
    freedoms: usize,
    transform: Vec<f64>,
    stiffness: Vec<f64>,
    mass: Vec<f64>,
    modes: Modes,
    cut_off: f64,
    missing: Vec<Missing>,
    par: Par,
}

impl Reduction {
    /// Reduces a structure to the freedoms `retained` and its modes with these held.
    ///
    /// - `groups`: as in [`Symbolic::new`];
    /// - `directions`: motions of the retained freedoms in which the error is judged, such as those of a rigid
    ///   base; if there is none, each retained freedom by itself.
    ///
    /// Cost: a factor, a solve for each retained freedom and direction, the modes, and $2 n r^2$ operations for
    /// $r$ reduced coordinates of $n$ freedoms; memory $8 n r$ bytes for the transform. Errors: a freedom
    /// retained twice or unknown, a structure that moves freely while the retained freedoms are held, the
    /// errors of [`modes`], an accuracy that no cut-off up to ten times the band reaches.
    pub fn new(
        stiffness: &SymmetricMatrix,
        mass: &SymmetricMatrix,
        groups: &[u32],
        retained: &[usize],
        directions: &[Vec<f64>],
        kept: Kept,
        search: Search,
    ) -> Result<Self, FemError> {
        let mut parts = Parts::new(stiffness, mass, groups, retained, search.threads)?;
        let static_motion = parts.static_motion()?;
        let units: Vec<Vec<f64>>;
        let directions = if directions.is_empty() {
            let unit = |j| (0..retained.len()).map(|i| f64::from(i == j)).collect();
            units = (0..retained.len()).map(unit).collect();
            &units
        } else {
            directions
        };
        let excitations = parts.excitations(&static_motion, directions)?;
        let find = |wanted| {
            modes(&parts.stiffness_ii, &parts.mass_ii, &parts.groups, wanted, search)
                .map_err(|error| parts.original(error))
        };
        let below = |to: f64| find(Wanted::Band { from: 0.0, to });
        let (found, cut_off, missing) = match kept {
            Kept::Count(count) => {
                let found = find(Wanted::Lowest(count))?;
                // a dropped mode lies at the last kept one at least
                let cut_off = if count > 0 { found.frequency(count - 1) } else { 0.0 };
                let missing = missing(&excitations, &found);
                (found, cut_off, missing)
            }
            Kept::Below(to) => {
                let found = below(to)?;
                let missing = missing(&excitations, &found);
                (found, to, missing)
            }
            Kept::Accuracy { band, accuracy } => by_accuracy(band, accuracy, &excitations, below)?,
        };
        let mut this = Self {
            retained: retained.to_vec(),
            interior: parts.interior.clone(),
            freedoms: stiffness.size(),
            transform: parts.transform(&static_motion, &found),
            stiffness: vec![],
            mass: vec![],
            modes: found,
            cut_off,
            missing,
            par: parts.par,
        };
        this.stiffness = this.reduced_stiffness(stiffness);
        this.mass = this.reduce(mass)?;
        Ok(this)
    }

    /// Number of reduced coordinates.
    pub fn size(&self) -> usize {
        self.retained.len() + self.modes.len()
    }

    /// Freedoms of the whole structure.
    pub fn freedoms(&self) -> usize {
        self.freedoms
    }

    /// Retained freedoms.
    pub fn retained(&self) -> &[usize] {
        &self.retained
    }

    /// Freedoms that were reduced: row $k$ of a shape of [`Self::modes`] belongs to the $k$-th of them.
    pub fn interior(&self) -> &[usize] {
        &self.interior
    }

    /// $\hat K$, full, column by column.
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// $\hat M$, full, column by column.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// Modes kept, with the retained freedoms held.
    pub fn modes(&self) -> &Modes {
        &self.modes
    }

    /// Frequency, Hz, that every dropped mode exceeds.
    pub fn cut_off(&self) -> f64 {
        self.cut_off
    }

    /// Bound of the error of the forces at the retained freedoms under a harmonic motion of them with
    /// `frequency`, Hz: the largest over the directions $r$ of
    ///
    /// $$ \frac{\omega^4 R}{1 - \omega^2 / \omega_c^2} \Big/ \max(r^T \hat K r, \omega^2 r^T \hat M r), \qquad
    ///    R = \sum_{dropped} (y_k^T r)^2 / \omega_k^2; $$
    ///
    /// infinite from the cut-off on.
    pub fn estimate(&self, frequency: f64) -> f64 {
        estimate(&self.missing, frequency, self.cut_off)
    }

    /// Motion of all freedoms from the reduced coordinates, $u = T (u_b, q)$. Errors: lengths.
    pub fn recover(&self, reduced: &[f64], full: &mut [f64]) -> Result<(), FemError> {
        expect("reduced coordinates", reduced.len(), self.size())?;
        expect("freedoms", full.len(), self.freedoms)?;
        let to = MatMut::from_column_major_slice_mut(full, self.freedoms, 1);
        let from = MatRef::from_column_major_slice(reduced, self.size(), 1);
        matmul(to, Accum::Replace, self.view(), from, 1.0, self.par);
        Ok(())
    }

    /// Rows of $T$ for some freedoms, column by column: what recovers an output at each step. Errors: a
    /// freedom that does not exist.
    pub fn recovery(&self, freedoms: &[usize]) -> Result<Vec<f64>, FemError> {
        if let Some(&f) = freedoms.iter().find(|f| **f >= self.freedoms) {
            return Err(FemError::Entry { row: f, column: f, size: self.freedoms });
        }
        let columns = self.transform.chunks(self.freedoms.max(1));
        Ok(columns.flat_map(|c| freedoms.iter().map(|&f| c[f])).collect())
    }

    /// Forces on the reduced coordinates, $T^T f$. Errors: lengths.
    pub fn reduce_force(&self, force: &[f64]) -> Result<Vec<f64>, FemError> {
        expect("forces", force.len(), self.freedoms)?;
        let dot = |c: &[f64]| c.iter().zip(force).map(|(t, f)| t * f).sum();
        Ok(self.transform.chunks(self.freedoms.max(1)).map(dot).collect())
    }

    /// $T^T A T$, full, column by column: for a damping matrix, say. Errors: another size.
    pub fn reduce(&self, matrix: &SymmetricMatrix) -> Result<Vec<f64>, FemError> {
        expect("rows of a matrix", matrix.size(), self.freedoms)?;
        let (n, r) = (self.freedoms, self.size());
        let mut result = vec![0.0; r * r];
        let mut product = vec![0.0; n * SOLVE_COLUMNS.min(r)];
        for first in (0..r).step_by(SOLVE_COLUMNS) {
            let columns = SOLVE_COLUMNS.min(r - first);
            for c in 0..columns {
                let x = &self.transform[(first + c) * n..(first + c + 1) * n];
                matrix.multiply(x, &mut product[c * n..(c + 1) * n]);
            }
            let to = MatMut::from_column_major_slice_mut(&mut result[first * r..][..columns * r], r, columns);
            let from = MatRef::from_column_major_slice(&product[..n * columns], n, columns);
            matmul(to, Accum::Replace, self.view().transpose(), from, 1.0, self.par);
        }
        symmetrise(&mut result, r);
        Ok(result)
    }

    /// $\hat K$: forces at the retained freedoms under static motion, and the eigenvalues.
    fn reduced_stiffness(&self, stiffness: &SymmetricMatrix) -> Vec<f64> {
        let (n, r, b) = (self.freedoms, self.size(), self.retained.len());
        let mut result = vec![0.0; r * r];
        let mut force = vec![0.0; n];
        for j in 0..b {
            stiffness.multiply(&self.transform[j * n..(j + 1) * n], &mut force);
            for (i, &freedom) in self.retained.iter().enumerate() {
                result[j * r + i] = force[freedom];
            }
        }
        for (k, value) in self.modes.values().iter().enumerate() {
            result[(b + k) * r + b + k] = *value;
        }
        symmetrise(&mut result, r);
        result
    }

    fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.transform, self.freedoms, self.size())
    }
}

/// Motion of the structure with one direction of the retained freedoms, and what it excites.
struct Excitation {
    stiffness: f64,
    mass: f64,
    /// $Y r$, on the interior freedoms.
    load: Vec<f64>,
    /// $r^T Y^T K_{ii}^{-1} Y r$.
    flexibility: f64,
}

/// The blocks of a structure.
struct Parts<'a> {
    stiffness: &'a SymmetricMatrix,
    mass: &'a SymmetricMatrix,
    retained: &'a [usize],
    interior: Vec<usize>,
    stiffness_ii: SymmetricMatrix,
    mass_ii: SymmetricMatrix,
    groups: Vec<u32>,
    factor: Option<Factor>,
    threads: usize,
    par: Par,
}

impl<'a> Parts<'a> {
    fn new(
        stiffness: &'a SymmetricMatrix,
        mass: &'a SymmetricMatrix,
        groups: &[u32],
        retained: &'a [usize],
        threads: usize,
    ) -> Result<Self, FemError> {
        let size = stiffness.size();
        expect("rows of the mass matrix", mass.size(), size)?;
        expect("groups of freedoms", groups.len(), size)?;
        let mut held = vec![false; size];
        for &freedom in retained {
            let slot =
                held.get_mut(freedom).ok_or(FemError::Entry { row: freedom, column: freedom, size })?;
            if std::mem::replace(slot, true) {
                return Err(FemError::FreedomTwice { freedom });
            }
        }
        let interior: Vec<usize> = (0..size).filter(|&f| !held[f]).collect();
        Ok(Self {
            stiffness,
            mass,
            retained,
            stiffness_ii: stiffness.principal(&interior)?,
            mass_ii: mass.principal(&interior)?,
            groups: interior.iter().map(|&f| groups[f]).collect(),
            interior,
            factor: None,
            threads,
            par: if threads > 1 { Par::rayon(threads) } else { Par::Seq },
        })
    }

    /// $X = -K_{ii}^{-1} K_{ib}$, column by column.
    fn static_motion(&mut self) -> Result<Vec<f64>, FemError> {
        let n = self.interior.len();
        let mut x = vec![0.0; n * self.retained.len()];
        for (i, j, value) in self.stiffness.block(&self.interior, self.retained)? {
            x[j * n + i] = -value;
        }
        if !x.is_empty() {
            let pattern = Symbolic::new(&self.stiffness_ii, &self.groups, Ordering::default())?;
            let factor = Factor::definite(&Arc::new(pattern), &self.stiffness_ii, self.threads);
            let mut factor = factor.map_err(|error| self.original(error))?;
            factor.solve(&mut x);
            self.factor = Some(factor);
        }
        Ok(x)
    }

    /// An error that names a freedom of the whole structure.
    fn original(&self, error: FemError) -> FemError {
        match error {
            FemError::Pivot { freedom, pivot, diagonal } => {
                FemError::Pivot { freedom: self.interior[freedom], pivot, diagonal }
            }
            other => other,
        }
    }

    fn excitations(&mut self, x: &[f64], directions: &[Vec<f64>]) -> Result<Vec<Excitation>, FemError> {
        let n = self.interior.len();
        let mut result = vec![];
        let mut momentum = vec![0.0; self.mass.size()];
        for r in directions {
            expect("direction of the retained freedoms", r.len(), self.retained.len())?;
            let mut motion = vec![0.0; self.mass.size()];
            for (j, (&freedom, r)) in self.retained.iter().zip(r).enumerate() {
                motion[freedom] = *r;
                if *r != 0.0 {
                    for (&i, x) in self.interior.iter().zip(&x[j * n..]) {
                        motion[i] += r * x;
                    }
                }
            }
            self.mass.multiply(&motion, &mut momentum);
            let load: Vec<f64> = self.interior.iter().map(|&i| momentum[i]).collect();
            let mass = momentum.iter().zip(&motion).map(|(p, u)| p * u).sum();
            let stiffness = self.stiffness.quadratic(&motion);
            result.push(Excitation { stiffness, mass, load, flexibility: 0.0 });
        }
        for part in result.chunks_mut(SOLVE_COLUMNS) {
            let mut z: Vec<f64> = part.iter().flat_map(|e| e.load.iter().copied()).collect();
            if let Some(factor) = &mut self.factor {
                factor.solve(&mut z);
            }
            for (e, z) in part.iter_mut().zip(z.chunks(n.max(1))) {
                e.flexibility = e.load.iter().zip(z).map(|(a, b)| a * b).sum();
            }
        }
        Ok(result)
    }

    /// $T$ in the numbering of the whole structure.
    fn transform(&self, x: &[f64], modes: &Modes) -> Vec<f64> {
        let (size, n) = (self.stiffness.size(), self.interior.len());
        let mut result = vec![0.0; size * (self.retained.len() + modes.len())];
        for (j, column) in result.chunks_mut(size.max(1)).enumerate() {
            let inner = if j < self.retained.len() {
                column[self.retained[j]] = 1.0;
                &x[j * n..(j + 1) * n]
            } else {
                modes.shape(j - self.retained.len())
            };
            for (&i, v) in self.interior.iter().zip(inner) {
                column[i] = *v;
            }
        }
        result
    }
}

/// Raises the cut-off until the estimate is within the accuracy.
fn by_accuracy(
    band: f64,
    accuracy: f64,
    excitations: &[Excitation],
    below: impl Fn(f64) -> Result<Modes, FemError>,
) -> Result<(Modes, f64, Vec<Missing>), FemError> {
    let mut last = f64::INFINITY;
    for factor in CUT_OFFS {
        let cut_off = factor * band;
        let found = below(cut_off)?;
        let missing = missing(excitations, &found);
        last = estimate(&missing, band, cut_off);
        if last <= accuracy {
            return Ok((found, cut_off, missing));
        }
    }
    let cut_off = CUT_OFFS[CUT_OFFS.len() - 1] * band;
    Err(FemError::Reduction { estimate: last, accuracy, band, cut_off })
}

fn missing(excitations: &[Excitation], modes: &Modes) -> Vec<Missing> {
    let one = |e: &Excitation| {
        let kept: f64 = (0..modes.len())
            .map(|k| {
                let y: f64 = modes.shape(k).iter().zip(&e.load).map(|(s, l)| s * l).sum();
                y * y / modes.values()[k]
            })
            .sum();
        // with all modes kept round-off is left, of either sign
        let rest = e.flexibility - kept;
        let flexibility = if rest > 1e-12 * e.flexibility { rest } else { 0.0 };
        Missing { stiffness: e.stiffness, mass: e.mass, flexibility }
    };
    excitations.iter().map(one).collect()
}

fn estimate(missing: &[Missing], frequency: f64, cut_off: f64) -> f64 {
    if frequency >= cut_off && missing.iter().any(|m| m.flexibility > 0.0) {
        return f64::INFINITY;
    }
    let square = (2.0 * PI * frequency).powi(2);
    let growth = 1.0 - (frequency / cut_off).powi(2);
    missing
        .iter()
        .map(|m| {
            let scale = m.stiffness.max(square * m.mass);
            if m.flexibility > 0.0 { square * square * m.flexibility / (growth * scale) } else { 0.0 }
        })
        .fold(0.0, f64::max)
}

fn symmetrise(a: &mut [f64], n: usize) {
    for j in 0..n {
        for i in 0..j {
            let mean = 0.5 * (a[j * n + i] + a[i * n + j]);
            a[j * n + i] = mean;
            a[i * n + j] = mean;
        }
    }
}

fn expect(what: &'static str, found: usize, expected: usize) -> Result<(), FemError> {
    if found == expected { Ok(()) } else { Err(FemError::Length { what, found, expected }) }
}
