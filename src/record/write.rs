//! The folder of a recording: the motion in files that other programs read, the account of it, and the page.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use hati_inputs::motion::{AXES, Quantity};
use hati_inputs::records::{FileFormat, ReadOptions, Trace, encode};
use serde_json::{Map, Value, json};

use super::origin::MARK;
use super::place::Aside;
use super::{Measured, RecordError, Recording, group};
use crate::calendar::iso8601;
use crate::outputs::{OutputError, expect_room, replace_bytes, write_summary};
use crate::report::write_record_report;

/// File that tells everything about the others; it makes a folder known as one of these.
const SUMMARY: &str = "record.json";
/// What stands in the way of an output.
pub(crate) const NOT_OURS: &str = "is there already and is not an output of `hati record`";
/// Motion files of any recording.
const MOTION_FILES: [&str; 5] =
    ["motion.csv", "motion.mseed", "motion.x.sac", "motion.y.sac", "motion.z.sac"];

/// Which files of the motion are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Formats {
    /// `motion.csv`: SI, every digit, with the account in its head.
    pub csv: bool,
    /// `motion.mseed`: SI, 8-byte floats.
    pub mseed: bool,
    /// `motion.x.sac`, …: nm/s² (nm/s, nm), 4-byte floats.
    pub sac: bool,
}

impl Default for Formats {
    fn default() -> Self {
        Self { csv: true, mseed: false, sac: false }
    }
}

impl FromStr for Formats {
    type Err = String;

    /// Words with commas between them: `csv,mseed,sac`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut formats = Self { csv: false, mseed: false, sac: false };
        for word in text.split(',').map(str::trim) {
            match word.to_ascii_lowercase().as_str() {
                "csv" => formats.csv = true,
                "mseed" | "miniseed" => formats.mseed = true,
                "sac" => formats.sac = true,
                _ => {
                    return Err(format!(
                        "no format “{word}”; give csv, mseed and sac with commas between them"
                    ));
                }
            }
        }
        Ok(formats)
    }
}

/// What was written.
#[derive(Debug, Clone)]
pub struct Written {
    /// The folder.
    pub folder: PathBuf,
    /// Its page.
    pub page: PathBuf,
    /// The content of `record.json`.
    pub summary: Value,
}

/// Writes a recording into the folder `dir`, which is made where it is missing.
///
/// All files are made aside and put into place together in the end, the page last. They replace what an earlier call
/// left there, never a file of the same name that this program did not write: a folder is known by its `record.json`.
///
/// Errors: a folder that cannot be written, a full disk, foreign files of these names, no Python for
/// miniSEED and SAC. What was there before is then as it was.
pub fn write(
    dir: &Path,
    recording: &Recording,
    measured: &Measured,
    formats: Formats,
    options: &ReadOptions,
) -> Result<Written, RecordError> {
    fs::create_dir_all(dir)
        .map_err(|cause| OutputError::UnwritableFolder { folder: dir.to_path_buf(), cause })?;
    let old = replaceable(dir, recording)?;
    let mut files = motion_files(recording, formats, options)?;
    let mut summary = recording.summary(measured);
    let told: Map<String, Value> =
        files.iter().map(|file| (file.name.to_string(), file.about.clone())).collect();
    summary["files"] = Value::Object(told);
    let aside = Aside::within(dir)?;
    write_summary(&aside.folder().join(SUMMARY), &summary)?;
    let mut names = vec![SUMMARY.to_owned()];
    for file in files.drain(..) {
        let path = aside.folder().join(&file.name);
        expect_room(&path, file.content.len() as u64 / 2)?;
        replace_bytes(&path, &file.content, false)?;
        names.push(file.name);
    }
    names.extend(write_record_report(aside.folder(), recording, measured, &summary)?);
    aside.put(dir, &names, || clear(dir, &old))?;
    Ok(Written { folder: dir.to_path_buf(), page: dir.join("report.html"), summary })
}

/// The files of an earlier call. Refuses those that are not of this program, or are being read.
fn replaceable(dir: &Path, recording: &Recording) -> Result<Vec<PathBuf>, RecordError> {
    let ours = fs::read(dir.join(SUMMARY))
        .ok()
        .and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok())
        .is_some_and(|value| value.get("hati_version").is_some() && value.get("motion").is_some());
    let sources: Vec<PathBuf> =
        recording.channels.iter().flatten().filter_map(|c| c.file.canonicalize().ok()).collect();
    let mut old = vec![];
    for name in MOTION_FILES.iter().chain(&[SUMMARY, "report.html"]) {
        let path = dir.join(name);
        if fs::symlink_metadata(&path).is_err() {
            continue;
        }
        let source = path.canonicalize().is_ok_and(|real| sources.contains(&real));
        if source {
            return Err(RecordError::NotOurs { path, what: "is one of the records that were read" });
        }
        if !ours || path.is_dir() {
            return Err(RecordError::NotOurs { path, what: NOT_OURS });
        }
        old.push(path);
    }
    Ok(old)
}

/// Takes away what an earlier call left, so that none of it passes for this one's.
fn clear(dir: &Path, old: &[PathBuf]) -> Result<(), RecordError> {
    for path in old {
        fs::remove_file(path).map_err(|cause| OutputError::from_io(path, cause))?;
    }
    Ok(crate::report::clear_record_figures(dir)?)
}

/// One file of the motion before it is written.
struct MotionFile {
    name: String,
    content: Vec<u8>,
    about: Value,
}

fn motion_files(
    recording: &Recording,
    formats: Formats,
    options: &ReadOptions,
) -> Result<Vec<MotionFile>, RecordError> {
    let mut files = vec![];
    let quantity = recording.motion.quantity;
    if formats.csv {
        let about = json!({ "unit": quantity.si_unit(), "encoding": "text, every digit" });
        files.push(MotionFile { name: "motion.csv".into(), content: csv(recording).into_bytes(), about });
    }
    let traces = traces(recording);
    if formats.mseed {
        let content = encode(FileFormat::MiniSeed, &traces, options)?.swap_remove(0);
        let about =
            json!({ "unit": quantity.si_unit(), "encoding": "FLOAT64", "note": "miniSEED holds no unit" });
        files.push(MotionFile { name: "motion.mseed".into(), content, about });
    }
    if formats.sac {
        let (unit, idep) = match quantity {
            Quantity::Acceleration => ("nm/s²", 8),
            Quantity::Velocity => ("nm/s", 7),
            Quantity::Displacement => ("nm", 6),
        };
        let contents = encode(FileFormat::Sac, &traces, options)?;
        for (axis, content) in recording.axes().into_iter().zip(contents) {
            let about = json!({ "unit": unit, "idep": idep, "encoding": "4-byte floats, seven digits" });
            files.push(MotionFile { name: format!("motion.{}.sac", AXES[axis]), content, about });
        }
    }
    Ok(files)
}

/// The components with the codes of their channels. After a rotation the horizontals are no longer those of their
/// codes: they end in X and Y.
fn traces(recording: &Recording) -> Vec<Trace<'_>> {
    let rotated = recording.motion.steps.iter().any(|step| step.name == "rotate");
    let one = |axis: usize| {
        let samples = recording.motion.components[axis].as_deref()?;
        let id = recording.channels[axis].as_ref().map(|c| c.id.as_str()).unwrap_or_default();
        let mut parts = id.split('.').map(str::to_owned);
        let mut id: [String; 4] = std::array::from_fn(|_| parts.next().unwrap_or_default());
        if rotated && axis < 2 {
            id[3] = format!("{}{}", group::without_direction(&id[3]), ["X", "Y"][axis]);
        }
        let motion = &recording.motion;
        Some(Trace { id, start: motion.start, dt: motion.dt, quantity: motion.quantity, samples })
    };
    (0..3).filter_map(one).collect()
}

/// The motion as text: a head for people and programs, then a row per sample.
fn csv(recording: &Recording) -> String {
    let motion = &recording.motion;
    let axes = recording.axes();
    let mut text = head(recording);
    text.reserve(motion.len() * (axes.len() + 1) * 20);
    let suffix = match motion.quantity {
        Quantity::Acceleration => "m_s2",
        Quantity::Velocity => "m_s",
        Quantity::Displacement => "m",
    };
    text.push_str("time_s");
    for &axis in &axes {
        let _ = write!(text, ",{}_{suffix}", AXES[axis]);
    }
    text.push('\n');
    let columns: Vec<&[f64]> = axes.iter().filter_map(|&a| motion.components[a].as_deref()).collect();
    let decimals = decimals(motion.dt);
    for row in 0..motion.len() {
        let time = row as f64 * motion.dt;
        // The shortest text that gives the same number back.
        let _ = match decimals {
            Some(decimals) => write!(text, "{time:.decimals$}"),
            None => write!(text, "{time:?}"),
        };
        for column in &columns {
            let _ = write!(text, ",{:?}", column[row]);
        }
        text.push('\n');
    }
    text
}

/// Decimals that write every multiple of the step; none for a step such as 1/3 s.
fn decimals(dt: f64) -> Option<usize> {
    (0..=9).find(|&d| {
        let scaled = dt * 10_f64.powi(d as i32);
        (scaled - scaled.round()).abs() <= 1e-12 * scaled && scaled.round() >= 1.0
    })
}

fn head(recording: &Recording) -> String {
    let motion = &recording.motion;
    let origin = &recording.origin;
    let mut text = String::new();
    let mut line = |words: String| {
        let plain: String = words.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let _ = writeln!(text, "# {plain}");
    };
    line(format!("motion of {}, written by hati {}", recording.name, origin.hati));
    line(format!("{} in {}; time in s from the first sample", motion.quantity, motion.quantity.si_unit()));
    let start = motion.start.map_or_else(|| "at an unknown time".to_owned(), iso8601);
    line(format!("{} samples with a step of {} s, the first one {start}", motion.len(), motion.dt));
    let named = [&origin.sources.x, &origin.sources.y, &origin.sources.z];
    for (axis, file) in named.into_iter().enumerate() {
        let (Some(file), Some(channel)) = (file, &recording.channels[axis]) else { continue };
        line(format!(
            "{}: channel {} of {} ({}), stored in {}",
            AXES[axis],
            file.channel,
            file.file.display(),
            channel.format,
            channel.unit_stored
        ));
    }
    for (number, step) in origin.process.iter().enumerate() {
        line(format!("step {}: {step}", number + 1));
    }
    line(
        "the next line is for programs: `hati record --from FILE` makes this motion again from its sources"
            .into(),
    );
    // Plain maps, texts and numbers: they have a JSON form.
    let account = serde_json::to_string(origin).unwrap_or_default();
    let _ = writeln!(text, "{MARK}{account}");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_of_steps() {
        assert_eq!(decimals(0.005), Some(3));
        assert_eq!(decimals(1.0), Some(0));
        assert_eq!(decimals(0.004_166), Some(6));
        assert_eq!(decimals(1.0 / 3.0), None);
    }

    #[test]
    fn formats_by_their_words() {
        assert_eq!("csv, SAC".parse(), Ok(Formats { csv: true, mseed: false, sac: true }));
        assert!("csv,tsv".parse::<Formats>().is_err());
    }
}
