//! `stations.nc` of ground in two and three dimensions: motion, strain and stress at points.

use std::path::Path;

use super::super::classic::ClassicFile;
use super::super::{OutputError, Provenance, compress};
use super::definitions::Definitions;

/// A point at which something is recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Its name.
    pub name: String,
    /// Where it was asked for, m.
    pub asked: [f64; 3],
    /// Where it is: another place only where the asked one lies outside the ground, m.
    pub position: [f64; 3],
}

/// What is recorded at the sensors.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SensorLayout {
    /// Components of displacement, velocity and acceleration, increasing: 0 = x, 1 = y, 2 = z.
    pub axes: Vec<usize>,
    /// The six components of the strain tensor xx, yy, zz, xy, yz, xz (tensor shears, not engineering).
    pub strain: bool,
    /// The six components of the stress tensor, Pa, tension positive, in the same order.
    pub stress: bool,
}

impl SensorLayout {
    /// Variables of a row.
    #[must_use]
    pub fn variables(&self) -> usize {
        3 * self.axes.len() + 6 * (usize::from(self.strain) + usize::from(self.stress))
    }
}

/// Writer of `stations.nc`, a CF discrete sampling geometry of `featureType` `timeSeries`.
///
/// `displacement_x(time, station)` and so on, f64; coordinates `x`, `y`, `z` (true place), `x_asked`,
/// `y_asked`, `z_asked`, `station_name`. It grows and ends as a wave field does (see the module) and takes
/// no lock of the NetCDF library, so the time loop may write it itself: rows are gathered and written
/// some at a time.
#[derive(Debug)]
pub struct SensorWriter {
    file: ClassicFile,
    /// Both times and the values of a row, so that nothing is allocated for it.
    row: Vec<f64>,
}

impl SensorWriter {
    /// Creates the file, or goes on with the one of an interrupted run after `resume` rows.
    ///
    /// # Errors
    /// Unwritable folder, full disk, a component above 2, no sensor; a file that cannot be gone on with.
    pub fn create(
        path: &Path,
        provenance: &Provenance,
        layout: &SensorLayout,
        sensors: &[Sensor],
        resume: Option<usize>,
    ) -> Result<Self, OutputError> {
        super::check_axes(path, &layout.axes)?;
        if sensors.is_empty() {
            let (path, variable) = (path.to_path_buf(), "the list of sensors".to_owned());
            return Err(OutputError::Length { path, variable, found: 0, expected: 1 });
        }
        let mut definitions = Definitions::new(provenance, "motions at stations", "CF-1.11");
        definitions.sensors(sensors);
        definitions.recorded(layout);
        let (made, fixed) = definitions.finish();
        let file = match resume {
            Some(rows) => ClassicFile::open_existing(path, &made, rows)?,
            None => ClassicFile::create(path, made, |file| fixed.iter().try_for_each(|f| f.put(file)))?,
        };
        Ok(Self { file, row: Vec::with_capacity(2 + layout.variables() * sensors.len()) })
    }

    /// Takes a row: `[variable][station]`, variables in the order displacement, velocity, acceleration
    /// (each with its components), strain, stress. Allocates nothing.
    ///
    /// # Errors
    /// Another number of values, full disk.
    pub fn append(&mut self, time: f64, values: &[f64]) -> Result<(), OutputError> {
        self.row.clear();
        self.row.extend([time, time]);
        self.row.extend(values);
        self.file.append(&self.row, &[])
    }

    /// Brings all rows to the disk; call it at every checkpoint and every few seconds.
    ///
    /// # Errors
    /// Full disk.
    pub fn sync(&mut self) -> Result<(), OutputError> {
        self.file.sync()
    }

    /// Rows taken.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.file.rows()
    }

    /// Ends the file of a run that is complete, as compressed NetCDF-4.
    ///
    /// # Errors
    /// Full disk, a fault of the library.
    pub fn finish(mut self) -> Result<(), OutputError> {
        self.file.sync()?;
        compress::compress(self.file)
    }
}
