//! The verb `export`: a run folder in the formats of other programs.

use super::arguments::ExportArguments;
use super::{Exit, Failure, print, print_json};
use crate::export::{ExportError, Wanted, export};
use hati_inputs::records::ReadOptions;
use serde_json::json;

impl From<ExportError> for Failure {
    fn from(e: ExportError) -> Self {
        let exit = if matches!(e, ExportError::Output(_)) { Exit::Machine } else { Exit::WrongInput };
        Self::new(exit, e)
    }
}

pub(super) fn export_verb(a: &ExportArguments, json: bool) -> Result<Exit, Failure> {
    let wanted = Wanted { csv: a.csv, mseed: a.mseed, sac: a.sac, vtkhdf: a.vtkhdf, place: a.place.clone() };
    let out = a.out.clone().unwrap_or_else(|| a.run.join("export"));
    let exported = export(&a.run, &out, &wanted, &ReadOptions::default())?;
    if json {
        print_json(&json!({ "run": a.run, "files": exported }))?;
    } else {
        for file in &exported {
            print(&format!("{}  {}: {}\n", file.path.display(), file.format, file.content))?;
        }
    }
    Ok(Exit::Fine)
}
