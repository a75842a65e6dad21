//! VTKHDF: an unstructured grid that stands still while its values move.
//!
//! VTK's own layout on HDF5 (version 2.0, read by VTK 9.3 and ParaView 5.12 and later), written through
//! the NetCDF-4 library: its groups, variables and attributes are HDF5's. Lengths of arrays are dimensions
//! of the root group, so that the groups that VTK reads hold its own names only.

use std::path::Path;

use netcdf::{FileMut, GroupMut, Options};

use super::ExportError;
use crate::outputs::wave::Cells;
use crate::outputs::{OutputError, aside, expect_room};

/// Points of a chunk at most.
const CHUNK: usize = 1 << 15;

/// Values at the points.
pub(super) struct Array {
    /// Its name.
    pub(super) name: String,
    /// Variables that are its components.
    pub(super) parts: Vec<String>,
    /// Has values of its own at every instant.
    pub(super) moving: bool,
}

/// Writes a file; `values` gives those of an array at an instant, the components of a point together.
pub(super) fn write(
    path: &Path,
    cells: &Cells,
    time: &[f64],
    arrays: &[Array],
    values: impl Fn(&Array, usize) -> Result<Vec<f32>, ExportError>,
) -> Result<(), ExportError> {
    let aside = aside(path);
    let _ = std::fs::remove_file(&aside);
    let failed = |action: &'static str| move |cause| OutputError::from_netcdf(path, action.to_owned(), cause);
    let outcome = (|| -> Result<(), ExportError> {
        expect_room(path, 28 * cells.points.len() as u64 + 5 * cells.corners.len() as u64)?;
        let mut file = netcdf::create_with(&aside, Options::NETCDF4).map_err(failed("create the file"))?;
        geometry(&mut file, cells).map_err(failed("write the points and cells"))?;
        steps(&mut file, time, arrays, cells.points.len()).map_err(failed("write the instants"))?;
        for array in arrays {
            let count = if array.moving { time.len() } else { 1 };
            for step in 0..count {
                let found = values(array, step)?;
                expect_room(path, 4 * found.len() as u64)?;
                put(&mut file, array, cells.points.len(), step, &found).map_err(failed("write values"))?;
            }
        }
        file.close().map_err(failed("close the file"))?;
        std::fs::rename(&aside, path).map_err(|cause| OutputError::from_io(path, cause))?;
        Ok(())
    })();
    if outcome.is_err() {
        let _ = std::fs::remove_file(&aside);
    }
    outcome
}

/// VTK's number for a cell: line, quadrilateral, hexahedron.
fn cell_type(dimension: usize) -> u8 {
    [3, 9, 12][dimension - 1]
}

/// A variable with its values.
fn whole<T: netcdf::NcTypeDescriptor>(
    group: &mut GroupMut<'_>,
    name: &str,
    dimensions: &[&str],
    values: &[T],
) -> netcdf::Result<()> {
    group.add_variable::<T>(name, dimensions)?.put_values(values, ..)
}

fn geometry(file: &mut FileMut, cells: &Cells) -> netcdf::Result<()> {
    let lengths = [
        ("one", 1),
        ("xyz", 3),
        ("points", cells.points.len()),
        ("cells", cells.len()),
        ("cells_and_end", cells.len() + 1),
        ("corners", cells.corners.len()),
    ];
    for (name, length) in lengths {
        file.add_dimension(name, length)?;
    }
    let mut group = file.add_group("VTKHDF")?;
    group.add_attribute("Version", vec![2_i64, 0])?;
    group.add_attribute("Type", "UnstructuredGrid")?;
    whole(&mut group, "NumberOfPoints", &["one"], &[cells.points.len() as i64])?;
    whole(&mut group, "NumberOfCells", &["one"], &[cells.len() as i64])?;
    whole(&mut group, "NumberOfConnectivityIds", &["one"], &[cells.corners.len() as i64])?;
    whole(&mut group, "Points", &["points", "xyz"], cells.points.as_flattened())?;
    let corners: Vec<i64> = cells.corners.iter().map(|&c| i64::from(c)).collect();
    whole(&mut group, "Connectivity", &["corners"], &corners)?;
    let offsets: Vec<i64> = (0..=cells.len()).map(|cell| (cell << cells.dimension) as i64).collect();
    whole(&mut group, "Offsets", &["cells_and_end"], &offsets)?;
    whole(&mut group, "Types", &["cells"], &vec![cell_type(cells.dimension); cells.len()])
}

/// The instants, where each array's values of an instant begin, and the arrays themselves, still empty.
fn steps(file: &mut FileMut, time: &[f64], arrays: &[Array], points: usize) -> netcdf::Result<()> {
    let count = time.len();
    file.add_dimension("steps", count)?;
    file.add_dimension("all_points_of_all_steps", count * points)?;
    let Some(mut root) = file.group_mut("VTKHDF")? else {
        return Err(netcdf::Error::NotFound("group VTKHDF".into()));
    };
    {
        let mut group = root.add_group("Steps")?;
        group.add_attribute("NSteps", count as i64)?;
        whole(&mut group, "Values", &["steps"], time)?;
        // One part that stands still: every instant begins where the first one does.
        let zeros = vec![0_i64; count];
        whole(&mut group, "PartOffsets", &["steps"], &zeros)?;
        whole(&mut group, "NumberOfParts", &["steps"], &vec![1_i64; count])?;
        whole(&mut group, "PointOffsets", &["steps"], &zeros)?;
        whole(&mut group, "CellOffsets", &["steps", "one"], &zeros)?;
        whole(&mut group, "ConnectivityIdOffsets", &["steps", "one"], &zeros)?;
        let mut offsets = group.add_group("PointDataOffsets")?;
        for array in arrays {
            let step = if array.moving { points as i64 } else { 0 };
            let begins: Vec<i64> = (0..count as i64).map(|number| number * step).collect();
            whole(&mut offsets, &array.name, &["steps"], &begins)?;
        }
    }
    let mut data = root.add_group("PointData")?;
    for array in arrays {
        let rows = if array.moving { "all_points_of_all_steps" } else { "points" };
        let vector = array.parts.len() == 3;
        let dimensions = if vector { vec![rows, "xyz"] } else { vec![rows] };
        let mut variable = data.add_variable::<f32>(&array.name, &dimensions)?;
        let chunk = points.min(CHUNK);
        variable.set_chunking(&[chunk, 3][..dimensions.len()])?;
        variable.set_compression(1, true)?;
    }
    Ok(())
}

fn put(file: &mut FileMut, array: &Array, points: usize, step: usize, values: &[f32]) -> netcdf::Result<()> {
    let missing = || netcdf::Error::NotFound(format!("array {}", array.name));
    let mut group = file.group_mut("VTKHDF/PointData")?.ok_or_else(missing)?;
    let mut variable = group.variable_mut(&array.name).ok_or_else(missing)?;
    let rows = step * points..(step + 1) * points;
    if array.parts.len() == 3 {
        variable.put_values(values, [rows, 0..3])
    } else {
        variable.put_values(values, rows)
    }
}
