//! The verb `record`: what was found in the files, its measures, and the motion as a page and as files.

use super::arguments::RecordArguments;
use super::{Exit, Failure, note, print, print_json, record_table, tell};
use crate::outputs::{OutputError, write_summary};
use crate::record::{
    Looked, Measured, NOT_OURS, RecordError, Recording, Refused, Written, abandon, look, replay, write,
};
use crate::report::{Row, write_index};
use hati_inputs::motion::Process;
use hati_inputs::records::{ReadOptions, Response, Source, Unit};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

impl From<RecordError> for Failure {
    fn from(e: RecordError) -> Self {
        let exit = if matches!(e, RecordError::Output(_)) { Exit::Machine } else { Exit::WrongInput };
        Self::new(exit, e)
    }
}

impl From<OutputError> for Failure {
    fn from(e: OutputError) -> Self {
        Self::new(Exit::Machine, e)
    }
}

pub(super) fn record(a: &RecordArguments, json: bool) -> Result<Exit, Failure> {
    end_on_signals(json);
    let options = ReadOptions { accept_clipped: a.accept_clipped, ..ReadOptions::default() };
    let mut looked = match &a.from {
        Some(from) => Looked { recordings: vec![replay(from, &options)?], refused: vec![] },
        None => look(&sources(a)?, &process(&a.process)?, &options)?,
    };
    let several = looked.recordings.len() > 1;
    let mut told = Told::default();
    for recording in std::mem::take(&mut looked.recordings) {
        let measured = Measured::of(&recording);
        let written = match &a.out {
            Some(out) => {
                let dir = if several { out.join(&recording.name) } else { out.clone() };
                match write(&dir, &recording, &measured, a.write, &options) {
                    Ok(written) => Some(written),
                    Err(RecordError::Input(error)) => {
                        let what = recording.name.clone();
                        looked.refused.push(Refused { what, error: error.into() });
                        continue;
                    }
                    Err(error) => return Err(error.into()),
                }
            }
            None => None,
        };
        told.add(&recording, &measured, written);
    }
    let page = match &a.out {
        Some(out) if several => Some(index(out, &told, &looked.refused)?),
        _ => told.pages.first().cloned(),
    };
    told.print(&looked.refused, page.as_deref(), json)?;
    Ok(if looked.refused.is_empty() { Exit::Fine } else { Exit::WrongInput })
}

/// Ends the program on Ctrl-C or a request to terminate: with one line, and with nothing half-made left behind.
fn end_on_signals(json: bool) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else { return };
    std::thread::spawn(move || {
        if signals.forever().next().is_some() {
            abandon();
            let text = "interrupted: nothing half-made is left; recordings that were put into place before are whole";
            super::report_failure(&Failure::new(Exit::Interrupted, text), json);
            std::process::exit(Exit::Interrupted as i32);
        }
    });
}

/// What is told of the recordings in the end.
#[derive(Default)]
struct Told {
    channels: Vec<Value>,
    summaries: Vec<Value>,
    pages: Vec<PathBuf>,
    folders: Vec<String>,
}

impl Told {
    fn add(&mut self, recording: &Recording, measured: &Measured, written: Option<Written>) {
        self.channels.extend(recording.channel_summaries(measured));
        self.folders.push(recording.name.clone());
        match written {
            Some(written) => {
                self.pages.push(written.page);
                self.summaries.push(written.summary);
            }
            None => self.summaries.push(recording.summary(measured)),
        }
    }

    fn print(&self, refused: &[Refused], page: Option<&Path>, json: bool) -> Result<(), Failure> {
        if json {
            let mut value = json!({ "channels": self.channels, "recordings": self.summaries });
            if let Some(page) = page {
                value["page"] = json!(page);
            }
            if !refused.is_empty() {
                value["refused"] =
                    refused.iter().map(|r| json!({ "what": r.what, "error": r.to_string() })).collect();
                let texts: Vec<String> = refused.iter().map(Refused::to_string).collect();
                value["error"] = json!(texts.join("\n"));
                value["exit"] = json!(Exit::WrongInput as u8);
            }
            print_json(&value)?;
        } else {
            print(&record_table::table(&self.summaries))?;
            for summary in &self.summaries {
                record_table::warnings(summary).iter().for_each(|line| tell(line));
            }
        }
        refused.iter().for_each(|r| note(&r.to_string()));
        if let (Some(page), false) = (page, json) {
            print(&format!("{}\n", page.display()))?;
        }
        Ok(())
    }
}

/// The page and the summary of a batch.
fn index(out: &Path, told: &Told, refused: &[Refused]) -> Result<PathBuf, Failure> {
    let rows: Vec<Row<'_>> =
        (told.folders.iter().zip(&told.summaries)).map(|(folder, summary)| Row { folder, summary }).collect();
    let refused: Vec<(String, String)> = refused.iter().map(|r| (r.what.clone(), r.to_string())).collect();
    let all = json!({
        "hati_version": env!("CARGO_PKG_VERSION"), "recordings": told.folders,
        "refused": refused.iter().map(|(what, why)| json!({ "what": what, "error": why })).collect::<Vec<_>>(),
    });
    for name in ["records.json", "index.html"] {
        expect_ours(out, name)?;
    }
    write_summary(&out.join("records.json"), &all)?;
    write_index(out, &rows, &refused)?;
    Ok(out.join("index.html"))
}

/// Refuses to replace a batch's file that is there without the `records.json` of an earlier batch.
fn expect_ours(out: &Path, name: &str) -> Result<(), RecordError> {
    let path = out.join(name);
    let ours = std::fs::read(out.join("records.json"))
        .ok()
        .and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok())
        .is_some_and(|value| value.get("hati_version").is_some());
    if path.symlink_metadata().is_ok() && !ours {
        return Err(RecordError::NotOurs { path, what: NOT_OURS });
    }
    Ok(())
}

/// The files with what was given for all of them.
fn sources(a: &RecordArguments) -> Result<Vec<Source>, Failure> {
    let unit = a.unit.as_deref().map(str::parse::<Unit>).transpose().map_err(Failure::input)?;
    let response = a.metadata.as_ref().map(|metadata| Response {
        mode: a.response.into(),
        pre_filter: a.pre_filter,
        ..Response::new(metadata)
    });
    let of = |file: &PathBuf| Source {
        unit,
        channel: a.channel.clone(),
        dt: a.dt,
        response: response.clone(),
        ..Source::new(file)
    };
    Ok(a.files.iter().map(of).collect())
}

/// The steps asked for: by default the mean is taken off; `none`, alone, leaves the samples as they are.
fn process(words: &[String]) -> Result<Vec<Process>, Failure> {
    match words {
        [] => Ok(vec![Process::Demean { first_seconds: None }]),
        [none] if none.trim() == "none" => Ok(vec![]),
        _ if words.iter().any(|word| word.trim() == "none") => {
            Err(Failure::input("--process none: stands alone; leave it out, or leave the other steps out"))
        }
        _ => words.iter().map(|text| step(text)).collect(),
    }
}

fn step(text: &str) -> Result<Process, Failure> {
    if text.split_whitespace().next().is_some_and(|word| word.contains(',')) {
        let mended = text.replacen(',', " ", 1);
        return Err(Failure::input(format!(
            "--process '{text}': a comma follows the step's word\n  help: put a blank there: --process '{mended}'"
        )));
    }
    Process::parse(text).map_err(Failure::input)
}
