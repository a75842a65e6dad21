//! `stations.nc`: motions at named depths and the input motions, over time.

use std::ops::Range;
use std::path::Path;

use super::file::{MOTIONS, OutputFile, Storage, axis_words};
use super::{OutputError, Provenance};
use crate::results::{AXES, Trace};

/// Samples of one chunk along `time`.
const CHUNK: usize = 1024;

/// Place and component of one trace, as the file is laid out.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceLayout {
    /// Name of the place.
    pub place: String,
    /// Depth below the surface, m; `None` for a motion that is not a point of the column.
    pub depth: Option<f64>,
    /// Component: 0 = x, 1 = y, 2 = z.
    pub axis: usize,
}

impl From<&Trace> for TraceLayout {
    fn from(trace: &Trace) -> Self {
        Self { place: trace.place.clone(), depth: trace.depth, axis: trace.axis }
    }
}

/// Samples to append for one trace; the three slices have one length.
#[derive(Debug, Clone, Copy)]
pub struct TraceChunk<'a> {
    /// Acceleration, m/s².
    pub acceleration: &'a [f64],
    /// Velocity, m/s.
    pub velocity: &'a [f64],
    /// Displacement, m.
    pub displacement: &'a [f64],
}

impl<'a> TraceChunk<'a> {
    /// Samples `range` of a whole trace; what lies beyond its end is left out.
    #[must_use]
    pub fn of(trace: &'a Trace, range: Range<usize>) -> Self {
        fn part(values: &[f64], range: Range<usize>) -> &[f64] {
            let end = range.end.min(values.len());
            &values[range.start.min(end)..end]
        }
        Self {
            acceleration: part(&trace.acceleration, range.clone()),
            velocity: part(&trace.velocity, range.clone()),
            displacement: part(&trace.displacement, range),
        }
    }

    /// In the order of [`MOTIONS`].
    fn motions(&self) -> [&'a [f64]; 3] {
        [self.displacement, self.velocity, self.acceleration]
    }
}

/// Where a trace's samples go.
#[derive(Debug, Clone)]
enum Column {
    /// Station number, component.
    Station(usize, usize),
    /// First part of the variable's name, component.
    Input(String, usize),
}

/// Writer of `stations.nc`, a CF-1.11 discrete sampling geometry of `featureType` `timeSeries`.
///
/// Dimensions `time` (unlimited) and `station`; `displacement_x(time, station)` in m, `velocity_x` in
/// m s⁻¹ and `acceleration_x` in m s⁻² for each active component, f64, NaN where a station has no such
/// trace; coordinates `time`, `elapsed_time`, `depth` (positive down, m), `x`, `y`, `station_name`.
/// A trace without depth becomes a variable of its own, for instance `outcrop_acceleration_x(time)`.
/// `time` leads because the file grows along it; CF allows either order.
#[derive(Debug)]
pub struct StationsWriter {
    file: OutputFile,
    columns: Vec<Column>,
    axes: Vec<usize>,
    stations: usize,
}

impl StationsWriter {
    /// Creates the file for these traces; every later [`append`](Self::append) gives them in this order.
    ///
    /// # Errors
    /// Unwritable folder, full disk, component above 2, two traces of one place and component.
    pub fn create(path: &Path, provenance: &Provenance, traces: &[TraceLayout]) -> Result<Self, OutputError> {
        // Of each place: a name, three coordinates, and the words that describe its variables.
        let texts: usize = traces.iter().map(|t| t.place.len() + 1024).sum();
        let mut file = OutputFile::create(path, texts)?;
        let axes = file.checked_axes(&traces.iter().map(|t| t.axis).collect::<Vec<_>>())?;
        provenance.write(&mut file, "motions at stations")?;
        file.attribute("featureType", "timeSeries")?;
        file.define_time(provenance, CHUNK)?;
        let stations = stations_of(traces);
        define_stations(&mut file, &stations)?;
        define_motions(&mut file, &axes, stations.len())?;
        let mut columns = Vec::with_capacity(traces.len());
        for trace in traces {
            match stations.iter().position(|(name, _)| *name == trace.place) {
                Some(station) if trace.depth.is_some() => {
                    columns.push(Column::Station(station, trace.axis));
                }
                _ => {
                    let prefix = variable_name(&trace.place);
                    define_input(&mut file, &prefix, trace)?;
                    columns.push(Column::Input(prefix, trace.axis));
                }
            }
        }
        file.sync()?;
        Ok(Self { file, columns, axes, stations: stations.len() })
    }

    /// Appends samples of all traces and flushes them.
    ///
    /// - `elapsed_time`: s, one per sample; - `chunks`: one per trace, in the order of the layout.
    ///
    /// # Errors
    /// A slice of another length than `elapsed_time`, a missing trace, full disk.
    pub fn append(&mut self, elapsed_time: &[f64], chunks: &[TraceChunk<'_>]) -> Result<(), OutputError> {
        let rows = elapsed_time.len();
        self.file.expect_length("the list of traces", chunks.len(), self.columns.len())?;
        for (column, chunk) in self.columns.iter().zip(chunks) {
            for (values, (motion, _)) in chunk.motions().into_iter().zip(MOTIONS) {
                let name = match column {
                    Column::Station(_, axis) => format!("{motion}_{}", AXES[*axis]),
                    Column::Input(prefix, axis) => format!("{prefix}_{motion}_{}", AXES[*axis]),
                };
                self.file.expect_length(&name, values.len(), rows)?;
            }
        }
        if rows == 0 {
            return Ok(());
        }
        self.file.expect_room(rows)?;
        self.file.put_time(elapsed_time)?;
        self.append_inputs(rows, chunks)?;
        if self.stations > 0 {
            self.append_stations(rows, chunks)?;
        }
        self.file.commit(rows)
    }

    fn append_inputs(&mut self, rows: usize, chunks: &[TraceChunk<'_>]) -> Result<(), OutputError> {
        for (column, chunk) in self.columns.iter().zip(chunks) {
            if let Column::Input(prefix, axis) = column {
                for (values, (motion, _)) in chunk.motions().into_iter().zip(MOTIONS) {
                    let name = format!("{prefix}_{motion}_{}", AXES[*axis]);
                    self.file.put_rows(&name, values, rows, None)?;
                }
            }
        }
        Ok(())
    }

    fn append_stations(&mut self, rows: usize, chunks: &[TraceChunk<'_>]) -> Result<(), OutputError> {
        let mut block = vec![0.0; rows * self.stations];
        for &wanted in &self.axes {
            for (index, (motion, _)) in MOTIONS.iter().enumerate() {
                block.fill(f64::NAN);
                for (column, chunk) in self.columns.iter().zip(chunks) {
                    if let Column::Station(station, axis) = column
                        && *axis == wanted
                    {
                        for (row, value) in chunk.motions()[index].iter().enumerate() {
                            block[row * self.stations + station] = *value;
                        }
                    }
                }
                let name = format!("{motion}_{}", AXES[wanted]);
                self.file.put_rows(&name, &block, rows, Some(self.stations))?;
            }
        }
        Ok(())
    }

    /// Samples written so far.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.file.rows()
    }

    /// Flushes and closes the file.
    ///
    /// # Errors
    /// Full disk, or a fault of the library.
    pub fn finish(self) -> Result<(), OutputError> {
        self.file.close()
    }
}

/// Distinct places that have a depth, in order of appearance.
fn stations_of(traces: &[TraceLayout]) -> Vec<(String, f64)> {
    let mut stations: Vec<(String, f64)> = Vec::new();
    for trace in traces {
        if let Some(depth) = trace.depth
            && stations.iter().all(|(name, _)| *name != trace.place)
        {
            stations.push((trace.place.clone(), depth));
        }
    }
    stations
}

fn define_stations(file: &mut OutputFile, stations: &[(String, f64)]) -> Result<(), OutputError> {
    if stations.is_empty() {
        return Ok(());
    }
    file.dimension("station", stations.len())?;
    let names: Vec<String> = stations.iter().map(|(name, _)| name.clone()).collect();
    file.texts(
        "station_name",
        "station",
        &names,
        &[("cf_role", "timeseries_id"), ("long_name", "station name")],
    )?;
    file.variable::<f64>(
        "depth",
        &["station"],
        Storage::PLAIN,
        &[
            ("standard_name", "depth"),
            ("long_name", "depth below the ground surface"),
            ("units", "m"),
            ("positive", "down"),
            ("axis", "Z"),
        ],
    )?;
    let depths: Vec<f64> = stations.iter().map(|(_, depth)| *depth).collect();
    file.put_all("depth", &depths)?;
    for (name, axis) in [("x", "X"), ("y", "Y")] {
        file.variable::<f64>(
            name,
            &["station"],
            Storage::PLAIN,
            &[("long_name", &format!("local horizontal coordinate {name}")), ("units", "m"), ("axis", axis)],
        )?;
        file.put_all(name, &vec![0.0_f64; stations.len()])?;
    }
    Ok(())
}

fn define_motions(file: &mut OutputFile, axes: &[usize], stations: usize) -> Result<(), OutputError> {
    if stations == 0 {
        return Ok(());
    }
    for &axis in axes {
        for (motion, units) in MOTIONS {
            file.variable::<f64>(
                &format!("{motion}_{}", AXES[axis]),
                &["time", "station"],
                Storage { chunk: &[CHUNK, stations.min(16)], compressed: false },
                &[
                    ("long_name", &format!("total {motion} {}", axis_words(axis))),
                    ("units", units),
                    ("coordinates", "elapsed_time station_name depth x y"),
                ],
            )?;
        }
    }
    Ok(())
}

fn define_input(file: &mut OutputFile, prefix: &str, trace: &TraceLayout) -> Result<(), OutputError> {
    for (motion, units) in MOTIONS {
        file.variable::<f64>(
            &format!("{prefix}_{motion}_{}", AXES[trace.axis]),
            &["time"],
            Storage { chunk: &[CHUNK], compressed: false },
            &[
                ("long_name", &format!("{} {motion} {}", trace.place, axis_words(trace.axis))),
                ("units", units),
                ("coordinates", "elapsed_time"),
            ],
        )?;
    }
    Ok(())
}

/// A place's name as the first part of a variable's name: letters, digits and underscores.
fn variable_name(place: &str) -> String {
    let mut name: String = place.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name.insert_str(0, "input_");
    }
    name
}
