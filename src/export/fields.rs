//! Wave fields read from a run folder, for programs that know cells and points.

use std::path::{Path, PathBuf};

use netcdf::{Extent, File};

use super::vtkhdf::{self, Array};
use super::{ExportError, Exported, Format};
use crate::outputs::wave::Cells;
use crate::results::AXES;

/// Kinds of motion, each a vector where all three components are there.
const MOTIONS: [&str; 3] = ["displacement", "velocity", "acceleration"];
/// Peak maps.
const PEAKS: [&str; 3] = ["pgd", "pgv", "pga"];

/// A field to be written.
pub(super) struct Field {
    path: PathBuf,
    file: File,
    cells: Cells,
    time: Vec<f64>,
    /// For each point of the cells its place in a row of the file; all of them in order where empty.
    picked: Vec<usize>,
}

/// Opens a NetCDF file.
pub(super) fn open(path: &Path) -> Result<File, ExportError> {
    if !path.exists() {
        return Err(ExportError::Missing { path: path.to_path_buf() });
    }
    netcdf::open(path).map_err(failed(path, "opening it"))
}

/// Gives a failure of the library its file.
pub(super) fn failed(path: &Path, action: &str) -> impl FnOnce(netcdf::Error) -> ExportError {
    let (path, action) = (path.to_path_buf(), action.to_owned());
    move |cause| ExportError::NetCdf { path, action, cause }
}

/// All values of a variable.
pub(super) fn doubles(path: &Path, file: &File, name: &str) -> Result<Vec<f64>, ExportError> {
    let missing = || ExportError::Layout { path: path.to_path_buf(), expected: format!("variable {name}") };
    let variable = file.variable(name).ok_or_else(missing)?;
    variable.get_values(..).map_err(failed(path, &format!("reading {name}")))
}

/// The fields of a run folder that lie in space.
pub(super) fn found(run: &Path) -> Result<Vec<Field>, ExportError> {
    let mut fields = vec![];
    for name in ["surface.nc", "volume.nc", "field.nc"] {
        let path = run.join(name);
        if !path.exists() {
            continue;
        }
        let file = open(&path)?;
        let time = doubles(&path, &file, "elapsed_time")?;
        let grid = name == "field.nc";
        if grid && (file.dimension("x").is_none() || file.dimension("z").is_none()) {
            continue;
        }
        if time.is_empty() {
            return Err(ExportError::TooFewRows { path, found: 0, expected: 1 });
        }
        let (cells, picked) =
            if grid { grid_cells(&path, &file)? } else { (mesh_cells(&path, &file)?, vec![]) };
        fields.push(Field { path, file, cells, time, picked });
    }
    if fields.is_empty() {
        return Err(ExportError::NoFields { path: run.to_path_buf() });
    }
    Ok(fields)
}

/// Points and cells of a UGRID file.
fn mesh_cells(path: &Path, file: &File) -> Result<Cells, ExportError> {
    let xyz = [
        doubles(path, file, "mesh_node_x")?,
        doubles(path, file, "mesh_node_y")?,
        doubles(path, file, "mesh_node_z")?,
    ];
    let points: Vec<[f64; 3]> = (0..xyz[0].len()).map(|n| [xyz[0][n], xyz[1][n], xyz[2][n]]).collect();
    for (dimension, cell) in [(1, "edge"), (2, "face"), (3, "volume")] {
        let name = format!("mesh_{cell}_nodes");
        if file.variable(&name).is_none() {
            continue;
        }
        let corners: Vec<u32> = doubles(path, file, &name)?.iter().map(|&c| c as u32).collect();
        let whole = corners.len().is_multiple_of(1 << dimension);
        if whole && corners.iter().all(|&c| (c as usize) < points.len()) {
            return Ok(Cells { dimension, points, corners });
        }
    }
    Err(ExportError::Layout { path: path.to_path_buf(), expected: "a sound table of the cells".into() })
}

/// Cells between the grid's points inside the ground, and the points that they use.
fn grid_cells(path: &Path, file: &File) -> Result<(Cells, Vec<usize>), ExportError> {
    let axis = |name: &str| match file.dimension(name) {
        Some(_) => doubles(path, file, name),
        None => Ok(vec![]),
    };
    let (x, y, z) = (axis("x")?, axis("y")?, axis("z")?);
    let size = [x.len(), y.len().max(1), z.len()];
    let points = size.iter().product();
    let inside = inside(path, file, points)?;
    // Axes along which there are cells; the local axes of a cell turn as x, y, z do.
    let axes: Vec<usize> = (0..3).filter(|&a| size[a] > 1).collect();
    let stride = [1, size[0], size[0] * size[1]];
    let (mut elements, dimension) = (vec![], axes.len());
    for first in 0..points {
        let at = [first % size[0], first / size[0] % size[1], first / stride[2]];
        if axes.iter().any(|&a| at[a] + 1 == size[a]) {
            continue;
        }
        let corner = |bits: usize| {
            first + axes.iter().enumerate().map(|(n, &a)| (bits >> n & 1) * stride[a]).sum::<usize>()
        };
        let corners: Vec<usize> = (0..1 << dimension).map(corner).collect();
        if corners.iter().all(|&c| inside[c]) {
            elements.extend(corners.iter().map(|&c| c as u32));
        }
    }
    if elements.is_empty() || dimension == 0 {
        let expected = "a cell of the grid inside the ground".to_owned();
        return Err(ExportError::Layout { path: path.to_path_buf(), expected });
    }
    let position = |point: u32| {
        let p = point as usize;
        let at = |axis: &[f64], i: usize| axis.get(i).copied().unwrap_or(0.0);
        [at(&x, p % size[0]), at(&y, p / size[0] % size[1]), at(&z, p / stride[2])]
    };
    let (cells, picked) = Cells::of_elements(dimension, 2, &elements, position);
    Ok((cells, picked.into_iter().map(|p| p as usize).collect()))
}

/// Which points of the grid hold values: those of the first row that are not missing.
fn inside(path: &Path, file: &File, points: usize) -> Result<Vec<bool>, ExportError> {
    let names = MOTIONS.iter().flat_map(|m| AXES.iter().map(move |a| format!("{m}_{a}")));
    match names.into_iter().find(|name| file.variable(name).is_some()) {
        Some(name) => Ok(row(path, file, &name, 0)?.iter().map(|v| !v.is_nan()).collect()),
        None => Ok(vec![true; points]),
    }
}

/// One row of a variable over time.
fn row(path: &Path, file: &File, name: &str, number: usize) -> Result<Vec<f32>, ExportError> {
    let missing = || ExportError::Layout { path: path.to_path_buf(), expected: format!("variable {name}") };
    let variable = file.variable(name).ok_or_else(missing)?;
    let mut extents: Vec<Extent> = variable.dimensions().iter().map(|d| Extent::from(0..d.len())).collect();
    extents[0] = Extent::from(number..number + 1);
    variable.get_values(extents).map_err(failed(path, &format!("reading {name}")))
}

impl Field {
    /// Writes `NAME.vtkhdf` into a folder.
    pub(super) fn write(&self, out: &Path) -> Result<Exported, ExportError> {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let path = out.join(format!("{stem}.vtkhdf"));
        let arrays = self.arrays();
        vtkhdf::write(&path, &self.cells, &self.time, &arrays, |array, step| self.values(array, step))?;
        let names: Vec<&str> = arrays.iter().map(|a| a.name.as_str()).collect();
        let content = format!(
            "{} points, {} cells, {} instants; {} in SI units",
            self.cells.points.len(),
            self.cells.len(),
            self.time.len(),
            names.join(", ")
        );
        Ok(Exported { path, format: Format::Vtkhdf, content })
    }

    /// What the file holds, three components as one vector.
    fn arrays(&self) -> Vec<Array> {
        let mut arrays = vec![];
        for (kinds, moving) in [(MOTIONS, true), (PEAKS, false)] {
            for kind in kinds {
                let there = |name: &String| self.file.variable(name).is_some();
                let parts: Vec<String> = AXES.iter().map(|a| format!("{kind}_{a}")).filter(there).collect();
                let plain = Array { name: kind.to_owned(), parts: vec![kind.to_owned()], moving };
                if moving && parts.len() == 3 {
                    arrays.push(Array { parts, ..plain });
                    continue;
                }
                arrays.extend(parts.into_iter().map(|p| Array { name: p.clone(), parts: vec![p], moving }));
                arrays.extend(there(&plain.name).then_some(plain));
            }
        }
        arrays
    }

    /// Values of an array at one instant, the components of a point together.
    fn values(&self, array: &Array, step: usize) -> Result<Vec<f32>, ExportError> {
        let mut parts = vec![];
        for name in &array.parts {
            let all = if array.moving {
                row(&self.path, &self.file, name, step)?
            } else {
                doubles(&self.path, &self.file, name)?.iter().map(|v| *v as f32).collect()
            };
            parts.push(match self.picked.is_empty() {
                true => all,
                false => self.picked.iter().map(|&p| all[p]).collect(),
            });
        }
        let points = self.cells.points.len();
        Ok((0..points).flat_map(|point| parts.iter().map(move |part| part[point])).collect())
    }
}
