//! Reads a run folder's NetCDF files.

use std::path::{Path, PathBuf};

/// The NetCDF files of a run with a field.
pub(crate) const FILES: [&str; 3] = ["stations.nc", "field.nc", "ledger.nc"];

/// One NetCDF file.
pub(crate) struct File {
    file: netcdf::File,
    path: PathBuf,
}

impl File {
    #[track_caller]
    pub(crate) fn open(folder: &Path, name: &str) -> Self {
        let path = folder.join(name);
        let file = netcdf::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        Self { file, path }
    }

    /// Number of records along `time`.
    #[track_caller]
    pub(crate) fn records(&self) -> usize {
        self.file.dimension("time").unwrap_or_else(|| panic!("{}: no time", self.path.display())).len()
    }

    /// All values of a variable, row-major.
    #[track_caller]
    pub(crate) fn values(&self, name: &str) -> Vec<f64> {
        let variable =
            self.file.variable(name).unwrap_or_else(|| panic!("{}: no {name}", self.path.display()));
        variable.get_values(..).unwrap_or_else(|e| panic!("{} {name}: {e}", self.path.display()))
    }

    /// The first `records` records of a variable, row-major.
    #[track_caller]
    pub(crate) fn first(&self, name: &str, records: usize) -> Vec<f64> {
        let all = self.values(name);
        let width = all.len() / self.records();
        all[..records * width].to_vec()
    }

    /// Names of all variables with numbers.
    pub(crate) fn numeric(&self) -> Vec<String> {
        let text = |v: &netcdf::Variable<'_>| v.vartype() == netcdf::types::NcVariableType::String;
        self.file.variables().filter(|v| !text(v)).map(|v| v.name()).collect()
    }

    /// Whether a variable has a value for every record.
    #[track_caller]
    pub(crate) fn is_along_time(&self, name: &str) -> bool {
        let variable =
            self.file.variable(name).unwrap_or_else(|| panic!("{}: no {name}", self.path.display()));
        variable.dimensions().first().is_some_and(|d| d.name() == "time")
    }

    /// History of a station: `acceleration_x` at `place`.
    #[track_caller]
    pub(crate) fn at(&self, name: &str, place: &str) -> Vec<f64> {
        let names = self.file.variable("station_name").expect("station names");
        let count = self.file.dimension("station").expect("stations").len();
        let index = (0..count)
            .find(|&i| names.get_string(i).expect("a name") == place)
            .unwrap_or_else(|| panic!("no station {place}"));
        self.values(name).chunks(count).map(|row| row[index]).collect()
    }
}

/// Largest absolute value.
pub(crate) fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Largest distance of two histories of one length.
#[track_caller]
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    assert!(!a.is_empty() && a.iter().chain(b).all(|x| x.is_finite()));
    a.iter().zip(b).fold(0.0, |m, (x, y)| m.max((x - y).abs()))
}
