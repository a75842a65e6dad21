//! One NetCDF file that grows along `time`: definitions, appends and flushes with the path in every error.

use std::path::{Path, PathBuf};

use netcdf::{AttributeValue, FileMut, NcTypeDescriptor, Options};

use super::{OutputError, Provenance};

/// Kinds of motion that files store, with their CF units and words.
pub(super) const MOTIONS: [(&str, &str); 3] =
    [("displacement", "m"), ("velocity", "m s-1"), ("acceleration", "m s-2")];

/// How a variable is stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Storage<'a> {
    /// Chunk shape; empty leaves it to the library.
    pub(super) chunk: &'a [usize],
    /// Deflate level 1 with shuffle.
    pub(super) compressed: bool,
}

impl Storage<'_> {
    pub(super) const PLAIN: Storage<'static> = Storage { chunk: &[], compressed: false };
}

/// A NetCDF-4 file open for writing.
#[derive(Debug)]
pub(super) struct OutputFile {
    file: FileMut,
    path: PathBuf,
    rows: usize,
    /// Chunks along `time`: rows of one, and bytes of all that begin at one row.
    chunks: Vec<(usize, u64)>,
}

impl OutputFile {
    /// Creates `path`, replacing an older file; `bytes` are those of the variables without `time`.
    pub(super) fn create(path: &Path, bytes: usize) -> Result<Self, OutputError> {
        let folder = super::error::folder_of(path);
        if !folder.is_dir() {
            return Err(OutputError::UnwritableFolder {
                folder,
                cause: std::io::Error::from(std::io::ErrorKind::NotFound),
            });
        }
        super::error::expect_room(path, bytes as u64)?;
        // Replacing the name, not the content, leaves a reader of an older run its file.
        match std::fs::remove_file(path) {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                return Err(OutputError::from_io(path, cause));
            }
            _ => {}
        }
        let file = netcdf::create_with(path, Options::NETCDF4)
            .map_err(|cause| OutputError::from_netcdf(path, "create the file", cause))?;
        Ok(Self { file, path: path.to_path_buf(), rows: 0, chunks: vec![] })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Rows written along `time`.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    pub(super) fn attribute(
        &mut self,
        name: &str,
        value: impl Into<AttributeValue>,
    ) -> Result<(), OutputError> {
        self.file
            .add_attribute(name, value)
            .map(drop)
            .map_err(|cause| OutputError::from_netcdf(&self.path, format!("write attribute {name}"), cause))
    }

    /// Defines a dimension; length 0 makes it unlimited.
    pub(super) fn dimension(&mut self, name: &str, length: usize) -> Result<(), OutputError> {
        self.file
            .add_dimension(name, length)
            .map(drop)
            .map_err(|cause| OutputError::from_netcdf(&self.path, format!("define dimension {name}"), cause))
    }

    /// Defines a numeric variable with its text attributes; missing values read as NaN.
    pub(super) fn variable<T: NcTypeDescriptor + FillNan>(
        &mut self,
        name: &str,
        dimensions: &[&str],
        storage: Storage<'_>,
        attributes: &[(&str, &str)],
    ) -> Result<(), OutputError> {
        let mut along = 1;
        let mut define = || -> netcdf::Result<()> {
            let mut variable = self.file.add_variable::<T>(name, dimensions)?;
            let lengths = variable.dimensions().iter().map(netcdf::Dimension::len);
            along = lengths.zip(storage.chunk).skip(1).map(|(n, chunk)| n.div_ceil(*chunk)).product();
            if !storage.chunk.is_empty() {
                variable.set_chunking(storage.chunk)?;
            }
            if storage.compressed {
                variable.set_compression(1, true)?;
            }
            if attributes.iter().all(|(key, _)| *key != "axis") {
                variable.set_fill_value(T::NAN)?;
            }
            for (key, value) in attributes {
                variable.put_attribute(key, *value)?;
            }
            Ok(())
        };
        define().map_err(|cause| {
            OutputError::from_netcdf(&self.path, format!("define variable {name}"), cause)
        })?;
        if let Some(&rows) = storage.chunk.first() {
            let values = along * storage.chunk.iter().product::<usize>();
            self.chunks.push((rows, (values * size_of::<T>()) as u64));
        }
        Ok(())
    }

    /// Refuses an append of `rows` rows that the disk has no room for.
    ///
    /// HDF5 writes whole chunks: those that the rows begin, and again the one that they go on with, which
    /// may find no place in its old one where it is compressed.
    pub(super) fn expect_room(&self, rows: usize) -> Result<(), OutputError> {
        let touched = |chunk: usize| ((self.rows + rows).div_ceil(chunk) - self.rows / chunk) as u64;
        let bytes = self.chunks.iter().map(|(chunk, bytes)| touched(*chunk) * bytes).sum();
        super::error::expect_room(&self.path, bytes)
    }

    /// Refuses to write `bytes` bytes of variables without `time` that the disk has no room for.
    pub(super) fn expect_room_for(&self, bytes: usize) -> Result<(), OutputError> {
        super::error::expect_room(&self.path, bytes as u64)
    }

    /// Defines and fills a variable of texts along one dimension.
    pub(super) fn texts(
        &mut self,
        name: &str,
        dimension: &str,
        values: &[String],
        attributes: &[(&str, &str)],
    ) -> Result<(), OutputError> {
        let mut write = || -> netcdf::Result<()> {
            let mut variable = self.file.add_string_variable(name, &[dimension])?;
            for (key, value) in attributes {
                variable.put_attribute(key, *value)?;
            }
            for (index, value) in values.iter().enumerate() {
                // A NUL cannot stand in a NetCDF text.
                variable.put_string(&value.replace('\0', "\u{fffd}"), index)?;
            }
            Ok(())
        };
        write().map_err(|cause| OutputError::from_netcdf(&self.path, format!("write variable {name}"), cause))
    }

    /// Writes all of a variable that has no `time`.
    pub(super) fn put_all<T: NcTypeDescriptor>(
        &mut self,
        name: &str,
        values: &[T],
    ) -> Result<(), OutputError> {
        self.put(name, values, |variable, values| variable.put_values(values, ..))
    }

    /// Writes `rows` rows of `width` values behind those already there; [`Self::commit`] makes them count.
    pub(super) fn put_rows<T: NcTypeDescriptor>(
        &mut self,
        name: &str,
        values: &[T],
        rows: usize,
        width: Option<usize>,
    ) -> Result<(), OutputError> {
        self.expect_length(name, values.len(), rows * width.unwrap_or(1))?;
        let from = self.rows;
        self.put(name, values, |variable, values| match width {
            Some(width) => variable.put_values(values, [from..from + rows, 0..width]),
            None => variable.put_values(values, from..from + rows),
        })
    }

    fn put<T: NcTypeDescriptor>(
        &mut self,
        name: &str,
        values: &[T],
        action: impl FnOnce(&mut netcdf::VariableMut<'_>, &[T]) -> netcdf::Result<()>,
    ) -> Result<(), OutputError> {
        let outcome = match self.file.variable_mut(name) {
            Some(mut variable) => action(&mut variable, values),
            None => Err(netcdf::Error::NotFound(format!("variable {name}"))),
        };
        outcome.map_err(|cause| OutputError::from_netcdf(&self.path, format!("write variable {name}"), cause))
    }

    /// Refuses an array of another length than the layout's.
    pub(super) fn expect_length(
        &self,
        variable: &str,
        found: usize,
        expected: usize,
    ) -> Result<(), OutputError> {
        if found == expected {
            return Ok(());
        }
        Err(OutputError::Length { path: self.path.clone(), variable: variable.to_owned(), found, expected })
    }

    /// Counts the rows just written and flushes them to the disk.
    pub(super) fn commit(&mut self, rows: usize) -> Result<(), OutputError> {
        self.rows += rows;
        self.sync()
    }

    /// Flushes all buffers, so that a reader and a later kill find everything written so far.
    pub(super) fn sync(&self) -> Result<(), OutputError> {
        self.file.sync().map_err(|cause| OutputError::from_netcdf(&self.path, "flush", cause))
    }

    /// Closes the file, which can still fail on a full disk.
    pub(super) fn close(self) -> Result<(), OutputError> {
        let Self { file, path, .. } = self;
        file.close().map_err(|cause| OutputError::from_netcdf(&path, "close the file", cause))
    }

    /// Defines `time` (unlimited) with its two coordinates: `time` since the record's start and `elapsed_time`.
    pub(super) fn define_time(&mut self, provenance: &Provenance, chunk: usize) -> Result<(), OutputError> {
        self.dimension("time", 0)?;
        let storage = Storage { chunk: &[chunk], compressed: false };
        self.variable::<f64>(
            "time",
            &["time"],
            storage,
            &[
                ("standard_name", "time"),
                ("long_name", "time"),
                ("units", &provenance.time_units()),
                ("calendar", "standard"),
                ("axis", "T"),
            ],
        )?;
        self.variable::<f64>(
            "elapsed_time",
            &["time"],
            storage,
            &[("long_name", "elapsed time since the start of the record"), ("units", "s")],
        )
    }

    /// Appends to both time coordinates.
    pub(super) fn put_time(&mut self, elapsed_time: &[f64]) -> Result<(), OutputError> {
        self.put_rows("time", elapsed_time, elapsed_time.len(), None)?;
        self.put_rows("elapsed_time", elapsed_time, elapsed_time.len(), None)
    }

    /// Refuses components above 2; returns them sorted, each once.
    pub(super) fn checked_axes(&self, axes: &[usize]) -> Result<Vec<usize>, OutputError> {
        let mut sorted = axes.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        match sorted.iter().find(|&&axis| axis > 2) {
            Some(&axis) => Err(OutputError::Axis { path: self.path.clone(), axis, available: vec![0, 1, 2] }),
            None => Ok(sorted),
        }
    }
}

/// Value that stands for "not written".
pub(super) trait FillNan {
    /// Quiet not-a-number of the type.
    const NAN: Self;
}

impl FillNan for f64 {
    const NAN: Self = f64::NAN;
}

impl FillNan for f32 {
    const NAN: Self = f32::NAN;
}

/// Word for a component in a `long_name`.
pub(super) fn axis_words(axis: usize) -> &'static str {
    match axis {
        0 => "along x (horizontal)",
        1 => "along y (horizontal)",
        _ => "along z (vertical, positive up)",
    }
}
