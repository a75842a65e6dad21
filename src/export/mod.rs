//! A run folder in the formats of other programs.
//!
//! | from | to |
//! |---|---|
//! | `stations.nc` | `PLACE.csv`: time and all motions, strains and stresses of a place, SI, every digit |
//! | | `PLACE.acceleration.mseed`, …: one file per place and motion, SI, 8-byte floats |
//! | | `PLACE.acceleration.x.sac`, …: one file per trace, nm/s² (nm/s, nm), 4-byte floats |
//! | `surface.nc`, `volume.nc`, `field.nc` | `surface.vtkhdf`, …: moving unstructured grids for ParaView 5.12 and later |
//!
//! Every file is made aside and renamed, so that none is ever half there.

mod error;
mod fields;
mod stations;
mod vtkhdf;

use std::fmt;
use std::path::{Path, PathBuf};

use hati_inputs::records::ReadOptions;
use serde::Serialize;

pub use error::ExportError;
use stations::Stations;

use crate::outputs::{OutputError, replace_bytes};

/// What is written, and of which places.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Stations as text.
    pub csv: bool,
    /// Stations as miniSEED.
    pub mseed: bool,
    /// Stations as SAC.
    pub sac: bool,
    /// Fields as VTKHDF.
    pub vtkhdf: bool,
    /// Only this station; all of them where `None`.
    pub place: Option<String>,
}

/// Format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Text.
    Csv,
    /// miniSEED.
    Mseed,
    /// SAC.
    Sac,
    /// VTKHDF.
    Vtkhdf,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Csv => "CSV",
            Self::Mseed => "miniSEED",
            Self::Sac => "SAC",
            Self::Vtkhdf => "VTKHDF",
        })
    }
}

/// A file that was written.
#[derive(Debug, Clone, Serialize)]
pub struct Exported {
    /// The file.
    pub path: PathBuf,
    /// Its format.
    pub format: Format,
    /// What it holds, with units.
    pub content: String,
}

/// Writes what is wanted of the run folder `run` into the folder `out`, which is made where it is missing.
///
/// Files of the same names are replaced.
///
/// # Errors
/// A folder without the files that are wanted, a station that is not there, files that cannot be read or
/// have another layout than hati's, no Python for miniSEED and SAC, a full disk.
pub fn export(
    run: &Path,
    out: &Path,
    wanted: &Wanted,
    options: &ReadOptions,
) -> Result<Vec<Exported>, ExportError> {
    if !run.is_dir() {
        return Err(ExportError::NoRunFolder { path: run.to_path_buf() });
    }
    // All is read before anything is written: a wrong place leaves no half of an export.
    let stations = match wanted.csv || wanted.mseed || wanted.sac {
        true => Some(Stations::read(&run.join("stations.nc"), wanted.place.as_deref())?),
        false => None,
    };
    let fields = if wanted.vtkhdf { fields::found(run)? } else { vec![] };
    std::fs::create_dir_all(out)
        .map_err(|cause| OutputError::UnwritableFolder { folder: out.to_path_buf(), cause })?;
    let mut exported = vec![];
    if let Some(stations) = &stations {
        for (name, format, content, bytes) in stations.files(wanted, options)? {
            let path = out.join(name);
            crate::outputs::expect_room(&path, bytes.len() as u64 / 2)?;
            replace_bytes(&path, &bytes, false)?;
            exported.push(Exported { path, format, content });
        }
    }
    for field in fields {
        exported.push(field.write(out)?);
    }
    Ok(exported)
}
