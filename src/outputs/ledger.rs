//! `ledger.nc`: the energy ledger over time.

use std::path::Path;

use super::file::{OutputFile, Storage};
use super::{OutputError, Provenance};
use crate::results::LedgerRow;

/// Name, words and explanation of each line, in the order of [`values`].
const LINES: [(&str, &str, &str); 6] = [
    (
        "energy_input",
        "energy that came in",
        "work of the incident wave at the base, or of the imposed base motion; cumulative",
    ),
    ("energy_kinetic", "kinetic energy", "stored in the moving mass at this time"),
    ("energy_strain", "strain energy", "stored elastically at this time, memory variables included"),
    ("energy_viscous", "energy lost to material damping", "dissipated in the memory variables; cumulative"),
    (
        "energy_outflow",
        "energy radiated into the half-space",
        "carried out through the base by the downgoing wave; cumulative",
    ),
    (
        "energy_residual",
        "what does not close",
        "input minus stored minus losses; round-off where the scheme is exact",
    ),
];

/// Writer of `ledger.nc`: cumulative energies per unit plan area, J m⁻², f64, along `time` (unlimited).
#[derive(Debug)]
pub struct LedgerWriter {
    file: OutputFile,
}

impl LedgerWriter {
    /// Creates the file.
    ///
    /// # Errors
    /// Unwritable folder, full disk.
    pub fn create(path: &Path, provenance: &Provenance) -> Result<Self, OutputError> {
        let mut file = OutputFile::create(path, 0)?;
        provenance.write(&mut file, "energy ledger")?;
        file.define_time(provenance, 1024)?;
        for (name, words, comment) in LINES {
            file.variable::<f64>(
                name,
                &["time"],
                Storage { chunk: &[1024], compressed: false },
                &[
                    ("long_name", &format!("{words}, per unit plan area")),
                    ("units", "J m-2"),
                    ("comment", comment),
                    ("coordinates", "elapsed_time"),
                ],
            )?;
        }
        file.variable::<f64>(
            "closing_error",
            &[],
            Storage::PLAIN,
            &[
                ("long_name", "closing error of the energy ledger"),
                ("units", "1"),
                (
                    "comment",
                    "largest |input - stored - losses| over time, divided by the largest |input| + stored",
                ),
            ],
        )?;
        file.sync()?;
        Ok(Self { file })
    }

    /// Appends rows and flushes them.
    ///
    /// # Errors
    /// Full disk, or a fault of the library.
    pub fn append(&mut self, rows: &[LedgerRow]) -> Result<(), OutputError> {
        if rows.is_empty() {
            return Ok(());
        }
        let times: Vec<f64> = rows.iter().map(|row| row.time).collect();
        self.file.expect_room(rows.len())?;
        self.file.put_time(&times)?;
        for (line, (name, ..)) in LINES.iter().enumerate() {
            let column: Vec<f64> = rows.iter().map(|row| values(row)[line]).collect();
            self.file.put_rows(name, &column, rows.len(), None)?;
        }
        self.file.commit(rows.len())
    }

    /// Rows written so far.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.file.rows()
    }

    /// Writes the closing error (1) as variable and attribute, and closes the file.
    ///
    /// # Errors
    /// Full disk, or a fault of the library.
    pub fn finish(mut self, closing_error: f64) -> Result<(), OutputError> {
        self.file.expect_room_for(size_of::<f64>())?;
        self.file.put_all("closing_error", &[closing_error])?;
        self.file.attribute("closing_error", closing_error)?;
        self.file.close()
    }
}

fn values(row: &LedgerRow) -> [f64; 6] {
    [row.input, row.kinetic, row.strain, row.viscous, row.outflow, row.residual]
}
