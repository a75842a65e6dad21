//! `ledger.nc` of ground in two and three dimensions.

use std::path::Path;

use super::super::classic::{Attribute, ClassicFile, Kind};
use super::super::{OutputError, Provenance, compress};
use super::definitions::Definitions;
use crate::results::LedgerRow;

/// Name, words and explanation of each line, in the order of a row.
const LINES: [(&str, &str, &str); 6] = [
    ("energy_input", "energy that came in", "work of the sources; cumulative"),
    ("energy_kinetic", "kinetic energy", "stored in the moving mass at this time"),
    ("energy_strain", "strain energy", "stored elastically at this time, memory variables included"),
    ("energy_viscous", "energy lost to material damping", "dissipated in the memory variables; cumulative"),
    (
        "energy_outflow",
        "energy that left through absorbing boundaries",
        "taken up by their dashpots; cumulative",
    ),
    (
        "energy_residual",
        "what does not close",
        "input minus stored minus losses; round-off where the scheme is exact",
    ),
];

/// Writer of `ledger.nc`, f64, along `time`; in J, of a section in J per metre along y. It grows and ends as a wave
/// field does.
#[derive(Debug)]
pub struct WaveLedgerWriter {
    file: ClassicFile,
}

impl WaveLedgerWriter {
    /// Creates the file, or goes on with the one of an interrupted run after `resume` rows; `dimension` is 2 or 3.
    ///
    /// # Errors
    /// Unwritable folder, full disk; a file that cannot be gone on with.
    pub fn create(
        path: &Path,
        provenance: &Provenance,
        dimension: usize,
        resume: Option<usize>,
    ) -> Result<Self, OutputError> {
        let mut definitions = Definitions::new(provenance, "energy ledger", "CF-1.11");
        let (units, per) = if dimension == 2 { ("J m-1", ", per metre along y") } else { ("J", "") };
        for (name, words, comment) in LINES {
            let words = format!("{words}{per}");
            let attributes = [
                ("long_name", words.as_str()),
                ("units", units),
                ("comment", comment),
                ("coordinates", "elapsed_time"),
            ];
            definitions.variable(name, Kind::Double, &["time"], &attributes);
        }
        let comment = "largest |input - stored - losses| over time, divided by the largest |input| + stored";
        let attributes =
            [("long_name", "closing error of the energy ledger"), ("units", "1"), ("comment", comment)];
        definitions.variable("closing_error", Kind::Float, &[], &attributes);
        definitions.attribute("_FillValue", Attribute::Float(f32::NAN));
        let (layout, _) = definitions.finish();
        let file = match resume {
            Some(rows) => ClassicFile::open_existing(path, &layout, rows)?,
            None => ClassicFile::create(path, layout, |_| Ok(()))?,
        };
        Ok(Self { file })
    }

    /// Takes a row.
    ///
    /// # Errors
    /// Full disk.
    pub fn append(&mut self, row: &LedgerRow) -> Result<(), OutputError> {
        let LedgerRow { time, input, kinetic, strain, viscous, outflow, residual } = *row;
        self.file.append(&[time, time, input, kinetic, strain, viscous, outflow, residual], &[])
    }

    /// Brings all rows to the disk.
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

    /// Writes the closing error (1); may be called again.
    ///
    /// # Errors
    /// Full disk.
    pub fn write_closing_error(&mut self, error: f64) -> Result<(), OutputError> {
        self.file.put("closing_error", &[error as f32])
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
