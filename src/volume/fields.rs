//! Which points the files of surface, volume and grid hold.

use super::plan::{PlannedField, PlannedSurface, PlannedVolume};
use super::sampling::{Rows, Sampling, auto_rows};
use super::sizes::Frequencies;
use crate::outputs::wave::{Cells, Grid};
use crate::plan::PlanError;
use hati_inputs::scene::{Auto, OutputQuantity, Scene};
use hati_sem::SemError;
use hati_sem::mesh::{Locator, Resolution};
use hati_sem::solid::Ground;

/// Boundary whose peaks are kept where the scene names none.
const TOP: &str = "top";
/// Points of a shear wave's length that an automatic grid has.
const GRID_POINTS: f64 = 4.0;
/// Most points of a grid.
const GRID_MOST: f64 = 5e7;

fn motions(quantities: &[OutputQuantity]) -> Vec<usize> {
    let kinds = [OutputQuantity::Displacement, OutputQuantity::Velocity, OutputQuantity::Acceleration];
    (0..3).filter(|&m| quantities.contains(&kinds[m])).collect()
}

fn rows(dt: Auto<f64>, frequencies: &Frequencies, sampling: &Sampling) -> Rows {
    let asked = match dt {
        Auto::Value(dt) => dt,
        // a whole number of samples
        Auto::Auto => {
            let samples = (auto_rows(frequencies) / sampling.sample_dt() * (1.0 + 1e-9)).floor().max(1.0);
            samples * sampling.sample_dt()
        }
    };
    sampling.rows(asked, frequencies.content())
}

/// The boundary that the scene writes, else `top` for its peak maps where the mesh has one.
pub(super) fn surface(
    scene: &Scene,
    ground: &Ground,
    frequencies: &Frequencies,
    sampling: &Sampling,
) -> Result<Option<PlannedSurface>, PlanError> {
    let asked = scene.output.surface.as_ref();
    let name = asked.map_or(TOP, |s| s.boundary.as_str());
    let mesh = ground.mesh();
    let Some(boundary) = mesh.boundary(name) else {
        let known = mesh.boundaries.iter().map(|b| b.name.clone()).collect();
        return match asked {
            Some(_) => {
                let what = "output.surface.boundary".to_owned();
                Err(PlanError::Place {
                    what,
                    source: Box::new(SemError::NoBoundary { name: name.into(), known }),
                })
            }
            None => Ok(None),
        };
    };
    let numbering = ground.numbering();
    let mut sides = vec![];
    for side in &boundary.sides {
        let element = numbering.element(side.element as usize);
        sides.extend(numbering.side_points(side.side).into_iter().map(|p| element[p]));
    }
    let positions = positions_of(ground, &sides);
    let n = ground.gll().len();
    let (cells, points) = Cells::of_elements(mesh.dimension - 1, n, &sides, |p| positions[&p]);
    let dt = asked.map_or(Auto::Auto, |s| s.dt);
    Ok(Some(PlannedSurface {
        boundary: name.to_owned(),
        cells,
        points,
        rows: rows(dt, frequencies, sampling),
        motions: asked.map_or(vec![], |s| motions(&s.quantities)),
    }))
}

/// Positions of some points.
fn positions_of(ground: &Ground, points: &[u32]) -> std::collections::HashMap<u32, [f64; 3]> {
    let all = ground.positions();
    points.iter().map(|&p| (p, all[p as usize])).collect()
}

/// All points, or those of a material.
pub(super) fn volume(
    scene: &Scene,
    ground: &Ground,
    frequencies: &Frequencies,
    sampling: &Sampling,
) -> Result<Option<PlannedVolume>, PlanError> {
    let Some(asked) = &scene.output.volume else { return Ok(None) };
    let mesh = ground.mesh();
    let wanted = match &asked.material {
        None => None,
        Some(name) => {
            let found = mesh.materials.iter().position(|m| m == name);
            let known = mesh.materials.clone();
            let source = SemError::UnknownMaterial { name: name.clone(), known };
            Some(found.ok_or(PlanError::Place {
                what: "output.volume.material".into(),
                source: Box::new(source),
            })?)
        }
    };
    let numbering = ground.numbering();
    let elements =
        (0..mesh.len()).filter(|&e| wanted.is_none_or(|material| mesh.material[e] as usize == material));
    let points: Vec<u32> = elements.flat_map(|e| numbering.element(e).iter().copied()).collect();
    let positions = ground.positions();
    let n = ground.gll().len();
    let (cells, points) = Cells::of_elements(mesh.dimension, n, &points, |p| positions[p as usize]);
    let rows = rows(asked.dt, frequencies, sampling);
    Ok(Some(PlannedVolume { cells, points, rows, motions: motions(&asked.quantities) }))
}

/// The regular grid.
pub(super) fn grid(
    scene: &Scene,
    ground: &Ground,
    frequencies: &Frequencies,
    resolution: &Resolution,
    sampling: &Sampling,
) -> Result<Option<PlannedField>, PlanError> {
    let Some(asked) = &scene.output.field else { return Ok(None) };
    let mesh = ground.mesh();
    let slowest = ground.materials().iter().map(|m| m.vs).fold(f64::INFINITY, f64::min);
    let spacing = asked.spacing.value().copied().unwrap_or(slowest / (GRID_POINTS * resolution.f_max));
    let (mut low, mut high) = mesh.extent();
    for (axis, range) in [asked.x, asked.y, asked.z].into_iter().enumerate() {
        if let Some([from, to]) = range {
            (low[axis], high[axis]) = (from, to);
        }
    }
    let counts: f64 =
        hati_sem::mesh::axes(mesh.dimension).iter().map(|&a| (high[a] - low[a]) / spacing + 1.0).product();
    if counts > GRID_MOST {
        let help = format!("a grid of {counts:.1e} points is too fine: give a larger output.field.spacing");
        let (needed_mb, available_mb) = (counts * 1e-3, GRID_MOST * 1e-3);
        let (elements, order) = (mesh.len() as f64, resolution.order);
        return Err(PlanError::MemoryOfElements { needed_mb, available_mb, elements, order, help });
    }
    let grid = Grid::over(low, high, spacing, mesh.dimension);
    let locator = Locator::new(mesh);
    let probes = grid.iter().map(|x| ground.probe(&locator, x).ok()).collect();
    let rows = rows(asked.dt, frequencies, sampling);
    Ok(Some(PlannedField { grid, probes, rows, motions: motions(&asked.quantities) }))
}

impl PlannedField {
    /// Spacing of the grid, m.
    pub fn spacing(&self) -> f64 {
        let of = |x: &[f64]| if x.len() > 1 { Some(x[1] - x[0]) } else { None };
        [&self.grid.x, &self.grid.y, &self.grid.z].into_iter().find_map(|x| of(x)).unwrap_or(0.0)
    }
}
