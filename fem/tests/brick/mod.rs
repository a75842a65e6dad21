//! A box of eight-node bricks, made here so that tests and benches of the algebra rest on nothing else.

use hati_fem::sparse::SymmetricMatrix;

const YOUNG: f64 = 210e9;
const POISSON: f64 = 0.3;
const DENSITY: f64 = 7850.0;

/// Stiffness, consistent mass and nodes of a box of steel.
pub(crate) struct Block {
    /// Stiffness, N/m.
    pub(crate) stiffness: SymmetricMatrix,
    /// Mass, kg.
    pub(crate) mass: SymmetricMatrix,
    /// Node of each freedom; three freedoms a node, x, y, z.
    pub(crate) groups: Vec<u32>,
}

impl Block {
    /// A force of 1 N in every third freedom, alternating.
    #[allow(dead_code)]
    pub(crate) fn load(&self) -> Vec<f64> {
        (0..self.stiffness.size()).map(|i| f64::from(i % 3 == 1) - 0.5 * f64::from(i % 6 == 2)).collect()
    }
}

/// Box of `cells` bricks and edges of `lengths`, m, held on its face z = 0.
#[allow(dead_code)]
pub(crate) fn block(cells: [usize; 3], lengths: [f64; 3]) -> Block {
    made(cells, lengths, true)
}

/// The same box, held nowhere.
#[allow(dead_code)]
pub(crate) fn free_block(cells: [usize; 3], lengths: [f64; 3]) -> Block {
    made(cells, lengths, false)
}

fn made(cells: [usize; 3], lengths: [f64; 3], held: bool) -> Block {
    let [nx, ny, nz] = cells.map(|c| c + 1);
    let edges = [0, 1, 2].map(|a| lengths[a] / cells[a] as f64);
    let (k, m) = brick(edges);
    let fixed = if held { nx * ny } else { 0 };
    let freedoms = 3 * (nx * ny * nz - fixed);
    let nodes_of = |e: usize| {
        let (i, j, l) = (e % cells[0], e / cells[0] % cells[1], e / cells[0] / cells[1]);
        CORNERS.map(|[a, b, c]| ((l + c) * ny + j + b) * nx + i + a)
    };
    let elements = cells[0] * cells[1] * cells[2];
    let assemble = |local: &[[f64; 24]; 24]| {
        let entries = (0..elements).flat_map(|e| {
            let nodes = nodes_of(e);
            (0..24).flat_map(move |r| (0..=r).map(move |c| (r, c))).filter_map(move |(r, c)| {
                let (p, q) = (nodes[r / 3].checked_sub(fixed)?, nodes[c / 3].checked_sub(fixed)?);
                Some((3 * p + r % 3, 3 * q + c % 3, local[r][c]))
            })
        });
        SymmetricMatrix::assemble(freedoms, entries).expect("entries within the matrix")
    };
    let groups = (0..freedoms as u32).map(|f| f / 3).collect();
    Block { stiffness: assemble(&k), mass: assemble(&m), groups }
}

const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// Stiffness and consistent mass of one brick with eight Gauss points.
fn brick(edges: [f64; 3]) -> ([[f64; 24]; 24], [[f64; 24]; 24]) {
    let lambda = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let mu = YOUNG / (2.0 * (1.0 + POISSON));
    let volume = edges.iter().product::<f64>() / 8.0;
    let (mut k, mut m) = ([[0.0; 24]; 24], [[0.0; 24]; 24]);
    let at = 1.0 / 3.0f64.sqrt();
    for point in 0..8 {
        let xi = [0, 1, 2].map(|a| if point >> a & 1 == 0 { -at } else { at });
        let side = CORNERS.map(|c| c.map(|s| 2.0 * s as f64 - 1.0));
        let shape = side.map(|s| (0..3).map(|a| 0.5 * (1.0 + s[a] * xi[a])).product::<f64>());
        let gradient = side.map(|s| {
            [0, 1, 2].map(|a| {
                let others: f64 = (0..3).filter(|&b| b != a).map(|b| 0.5 * (1.0 + s[b] * xi[b])).product();
                s[a] / edges[a] * others
            })
        });
        for r in 0..24 {
            for c in 0..24 {
                let (p, i, q, j) = (r / 3, r % 3, c / 3, c % 3);
                let (gp, gq) = (gradient[p], gradient[q]);
                let dot: f64 = (0..3).map(|a| gp[a] * gq[a]).sum();
                let shear = gp[j] * gq[i] + if i == j { dot } else { 0.0 };
                k[r][c] += volume * (lambda * gp[i] * gq[j] + mu * shear);
                if i == j {
                    m[r][c] += volume * DENSITY * shape[p] * shape[q];
                }
            }
        }
    }
    (k, m)
}
