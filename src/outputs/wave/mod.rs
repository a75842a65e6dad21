//! Wave fields in two and three dimensions: `surface.nc`, `volume.nc`, the regular grid `field.nc`, and points.
//!
//! One writer, [`WaveWriter`], serves all three; they differ in where their points lie. A row is a frame of
//! f32 values `[motion][component][point]`, motions in the order displacement, velocity, acceleration, as
//! [`WaveLayout`] asks for them.
//!
//! While the run goes on a file is classic NetCDF (64-bit offset), grows row by row and is valid at every
//! instant, also at a kill; [`WaveWriter::finish`] turns it into compressed NetCDF-4 (deflate 1, shuffle,
//! chunks of some rows) under the same name. A restart cuts it back to the rows of its checkpoint: the
//! number of rows is lowered and the bytes behind it are taken away, so that no reader meets a row that
//! the new run did not write.

mod cells;
mod definitions;
mod grid;
mod ledger;
mod peaks;
mod sensors;

use std::path::Path;

pub use cells::Cells;
pub use grid::Grid;
pub use ledger::WaveLedgerWriter;
pub use peaks::Peaks;
pub use sensors::{Sensor, SensorLayout, SensorWriter};

use super::classic::ClassicFile;
use super::thread::Sink;
use super::{OutputError, Provenance, compress};
use definitions::Definitions;

/// Motions and components that a file holds over time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WaveLayout {
    /// Displacement, m.
    pub displacement: bool,
    /// Velocity, m/s.
    pub velocity: bool,
    /// Acceleration, m/s².
    pub acceleration: bool,
    /// Components, increasing: 0 = x, 1 = y, 2 = z.
    pub axes: Vec<usize>,
}

impl WaveLayout {
    /// The motions that are asked for, as indices: 0 displacement, 1 velocity, 2 acceleration.
    #[must_use]
    pub fn motions(&self) -> Vec<usize> {
        let asked = [self.displacement, self.velocity, self.acceleration];
        (0..3).filter(|&motion| asked[motion]).collect()
    }

    /// Values of one row over `points` points.
    #[must_use]
    pub fn values(&self, points: usize) -> usize {
        self.motions().len() * self.axes.len() * points
    }

    fn check(&self, path: &Path) -> Result<(), OutputError> {
        check_axes(path, &self.axes)
    }
}

/// Refuses components above 2, twice or out of order.
fn check_axes(path: &Path, axes: &[usize]) -> Result<(), OutputError> {
    let disordered = axes.windows(2).find(|pair| pair[0] >= pair[1]).map(|pair| &pair[1]);
    match axes.iter().find(|&&axis| axis > 2).or(disordered) {
        Some(&axis) => Err(OutputError::Axis { path: path.to_path_buf(), axis, available: vec![0, 1, 2] }),
        None => Ok(()),
    }
}

/// Writer of a wave field; see the module.
#[derive(Debug)]
pub struct WaveWriter {
    file: ClassicFile,
    values: usize,
    points: usize,
}

impl WaveWriter {
    /// `surface.nc`: a surface's motion on the points of its elements' sides (CF and UGRID).
    ///
    /// - `cells`: quadrilaterals, or edges where the ground is a section;
    /// - `resume`: `None` for a new file; `Some(rows)` goes on with the one of an interrupted run after
    ///   that many rows.
    ///
    /// Variables `displacement_x(time, node)` in m, `velocity_x` in m s⁻¹, `acceleration_x` in m s⁻², f32,
    /// as `layout` asks; `pgd_x`, `pgv_x`, `pga_x` and `pgd`, `pgv`, `pga` (largest length of the vector)
    /// over `node`, missing until [`Self::write_peaks`].
    ///
    /// # Errors
    /// Unwritable folder, full disk, a component above 2; a file that cannot be gone on with.
    pub fn surface(
        path: &Path,
        provenance: &Provenance,
        layout: &WaveLayout,
        cells: &Cells,
        resume: Option<usize>,
    ) -> Result<Self, OutputError> {
        layout.check(path)?;
        expect_cells(path, cells)?;
        let mut definitions = Definitions::new(provenance, "motion of the surface", "CF-1.11 UGRID-1.0");
        definitions.cells(cells);
        definitions.motions(layout, &["node"], cells::COORDINATES);
        definitions.peaks(layout, cells::STATIC_COORDINATES);
        Self::open(path, definitions, layout.values(cells.points.len()), cells.points.len(), resume)
    }

    /// `volume.nc`: the ground's motion on the points of its elements (CF and UGRID).
    ///
    /// As [`Self::surface`], with hexahedra (quadrilaterals where the ground is a section) and without
    /// peaks.
    ///
    /// # Errors
    /// As [`Self::surface`].
    pub fn volume(
        path: &Path,
        provenance: &Provenance,
        layout: &WaveLayout,
        cells: &Cells,
        resume: Option<usize>,
    ) -> Result<Self, OutputError> {
        layout.check(path)?;
        expect_cells(path, cells)?;
        let mut definitions = Definitions::new(provenance, "motion of the ground", "CF-1.11 UGRID-1.0");
        definitions.cells(cells);
        definitions.motions(layout, &["node"], cells::COORDINATES);
        Self::open(path, definitions, layout.values(cells.points.len()), cells.points.len(), resume)
    }

    /// `field.nc`: motion on a regular grid, `velocity_x(time, z, y, x)`; `(time, z, x)` for a section.
    ///
    /// A point outside the ground is given as NaN and reads as missing.
    ///
    /// # Errors
    /// As [`Self::surface`]; a grid without points.
    pub fn grid(
        path: &Path,
        provenance: &Provenance,
        layout: &WaveLayout,
        grid: &Grid,
        resume: Option<usize>,
    ) -> Result<Self, OutputError> {
        layout.check(path)?;
        if grid.points() == 0 {
            let (path, variable) = (path.to_path_buf(), "the grid".to_owned());
            return Err(OutputError::Length { path, variable, found: 0, expected: 1 });
        }
        let mut definitions = Definitions::new(provenance, "motion on a regular grid", "CF-1.11");
        let dimensions = definitions.grid(grid);
        definitions.motions(layout, &dimensions, "elapsed_time");
        Self::open(path, definitions, layout.values(grid.points()), grid.points(), resume)
    }

    fn open(
        path: &Path,
        definitions: Definitions,
        values: usize,
        points: usize,
        resume: Option<usize>,
    ) -> Result<Self, OutputError> {
        let (layout, fixed) = definitions.finish();
        let file = match resume {
            Some(rows) => ClassicFile::open_existing(path, &layout, rows)?,
            None => ClassicFile::create(path, layout, |file| fixed.iter().try_for_each(|f| f.put(file)))?,
        };
        Ok(Self { file, values, points })
    }

    /// Values of one row.
    #[must_use]
    pub fn values(&self) -> usize {
        self.values
    }

    /// Rows written; the number that a checkpoint keeps after [`Sink::sync`].
    #[must_use]
    pub fn rows(&self) -> usize {
        self.file.rows()
    }

    /// Writes the peak maps of `surface.nc`; may be called again as peaks grow.
    ///
    /// # Errors
    /// Another number of points, a file without peaks, full disk.
    pub fn write_peaks(&mut self, peaks: &Peaks) -> Result<(), OutputError> {
        let mut norm = Vec::with_capacity(self.points);
        for (motion, name) in definitions::PEAKS.iter().enumerate() {
            for (number, &axis) in peaks.axes().iter().enumerate() {
                let name = format!("{name}_{}", crate::results::AXES[axis]);
                self.file.put(&name, peaks.component(motion, number))?;
            }
            norm.clear();
            norm.extend(peaks.norm(motion));
            self.file.put(name, &norm)?;
        }
        Ok(())
    }

    /// Ends the file of a run that is complete: compressed NetCDF-4 takes the place of the file that grew,
    /// in one step. Needs room for both for a moment.
    ///
    /// # Errors
    /// Full disk (the file that grew is then still there and whole), a fault of the library.
    pub fn finish(mut self) -> Result<(), OutputError> {
        self.file.sync()?;
        compress::compress(self.file)
    }

    /// Ends the file of a run that will be gone on with: all rows are on the disk, nothing is compressed.
    ///
    /// # Errors
    /// Full disk.
    pub fn leave(mut self) -> Result<(), OutputError> {
        self.file.sync()
    }
}

/// A dimension of length 0 would mean one that grows.
fn expect_cells(path: &Path, cells: &Cells) -> Result<(), OutputError> {
    if cells.is_empty() {
        let (path, variable) = (path.to_path_buf(), "the list of cells".to_owned());
        return Err(OutputError::Length { path, variable, found: 0, expected: 1 });
    }
    Ok(())
}

impl Sink for WaveWriter {
    fn values(&self) -> usize {
        self.values
    }

    fn append(&mut self, time: f64, values: &[f32]) -> Result<(), OutputError> {
        if values.len() != self.values {
            let (path, variable) = (self.file.path().to_path_buf(), "a row".to_owned());
            return Err(OutputError::Length { path, variable, found: values.len(), expected: self.values });
        }
        self.file.append(&[time, time], values)
    }

    fn sync(&mut self) -> Result<(), OutputError> {
        self.file.sync()
    }
}
