//! Where a motion comes from: files with their hashes, what was given with them, and the steps. Enough to
//! make the same samples again.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use hati_inputs::motion::Process;
use hati_inputs::records::{Channel, Response, Source, Unit};
use serde::{Deserialize, Serialize};

use super::{Components, RecordError};

/// Version of the layout of [`Origin`].
const VERSION: u32 = 1;
/// What stands before the origin in the head of a CSV file.
pub(super) const MARK: &str = "# hati-motion: ";
/// How much of a file is searched for its origin, bytes.
const HEAD: u64 = 4 << 20;

/// Sources and steps of a motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Version of this layout, 1.
    pub version: u32,
    /// Version of the program that wrote it.
    pub hati: String,
    /// One file per component.
    pub sources: Sources,
    /// The steps, in their order.
    pub process: Vec<Process>,
}

/// The components' files.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sources {
    /// Along x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<OriginFile>,
    /// Along y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<OriginFile>,
    /// Along z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<OriginFile>,
}

/// One file and what the user said about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OriginFile {
    /// The file as it was named.
    pub file: PathBuf,
    /// SHA-256 of its content, hexadecimal.
    pub sha256: String,
    /// Full id of the channel.
    pub channel: String,
    /// Unit that was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Step that was given, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dt: Option<f64>,
    /// Response that was taken off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response: Option<Response>,
    /// SHA-256 of its metadata file, hexadecimal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metadata_sha256: Option<String>,
}

impl Origin {
    /// The origin of some components and the steps that follow.
    pub(super) fn new(components: &Components, sources: &[Source], process: &[Process]) -> Self {
        let file = |axis: usize| {
            components[axis].as_ref().map(|(number, channel)| OriginFile::new(channel, &sources[*number]))
        };
        Self {
            version: VERSION,
            hati: env!("CARGO_PKG_VERSION").into(),
            sources: Sources { x: file(0), y: file(1), z: file(2) },
            process: process.to_vec(),
        }
    }

    /// The origin that stands in a CSV file's head or in a `record.json` of this program.
    ///
    /// Errors: a file that cannot be read, that holds none, or one of another version.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let mut bytes = vec![];
        let unreadable = |cause| RecordError::OriginUnreadable { path: path.into(), cause };
        // A pipe would keep the program waiting for whoever writes into it.
        let regular = |found: std::fs::Metadata| match found.is_file() {
            true => Ok(()),
            false => Err(std::io::Error::other("it is not a regular file")),
        };
        std::fs::metadata(path).and_then(regular).map_err(unreadable)?;
        File::open(path).and_then(|f| f.take(HEAD).read_to_end(&mut bytes)).map_err(unreadable)?;
        let text = String::from_utf8_lossy(&bytes);
        let missing = |problem: String| RecordError::OriginMissing { path: path.into(), problem };
        let origin = if text.trim_start().starts_with('{') {
            let value: serde_json::Value =
                serde_json::from_str(&text).map_err(|e| missing(format!("it is not JSON: {e}")))?;
            serde_json::from_value(value.get("motion").cloned().unwrap_or_default())
        } else {
            let line = text.lines().take_while(|l| l.starts_with('#')).find_map(|l| l.strip_prefix(MARK));
            let line = line.ok_or_else(|| missing(format!("no line of its head begins with “{MARK}”")))?;
            serde_json::from_str(line)
        };
        let origin: Self = origin.map_err(|e| missing(format!("its account is not understood: {e}")))?;
        match origin.version {
            VERSION => Ok(origin),
            other => Err(missing(format!("its account has version {other}, this program knows {VERSION}"))),
        }
    }

    /// The files as sources to be read again, with the axis of each. A file that is not where it was named
    /// is looked for beside `from`, the file that holds this origin.
    pub(super) fn sources(&self, from: &Path) -> Result<Vec<(usize, Source)>, RecordError> {
        let mut found = vec![];
        for (axis, file) in [&self.sources.x, &self.sources.y, &self.sources.z].into_iter().enumerate() {
            let Some(file) = file else { continue };
            let mut response = file.response.clone();
            if let Some(response) = &mut response {
                response.metadata = located(&response.metadata, from)?;
            }
            let source = Source {
                unit: file.unit,
                channel: Some(file.channel.clone()),
                dt: file.dt,
                response,
                ..Source::new(located(&file.file, from)?)
            };
            found.push((axis, source));
        }
        Ok(found)
    }

    /// Refuses channels that were not read from the same bytes.
    pub(super) fn expect_same(&self, components: &Components) -> Result<(), RecordError> {
        for (axis, file) in [&self.sources.x, &self.sources.y, &self.sources.z].into_iter().enumerate() {
            let (Some(file), Some((_, channel))) = (file, &components[axis]) else { continue };
            let changed = |path: PathBuf, expected: &str, found: String| {
                Err(RecordError::SourceChanged { path, expected: expected.into(), found })
            };
            if file.sha256 != channel.sha256 {
                return changed(channel.file.clone(), &file.sha256, channel.sha256.clone());
            }
            if let Some(expected) = &file.metadata_sha256 {
                let found = metadata_sha256(channel).unwrap_or_default();
                if *expected != found {
                    let path = file.response.as_ref().map(|r| r.metadata.clone()).unwrap_or_default();
                    return changed(path, expected, found);
                }
            }
        }
        Ok(())
    }
}

impl OriginFile {
    fn new(channel: &Channel, source: &Source) -> Self {
        Self {
            file: source.location.clone(),
            sha256: channel.sha256.clone(),
            channel: channel.id.clone(),
            unit: source.unit,
            dt: source.dt,
            response: source.response.clone(),
            metadata_sha256: metadata_sha256(channel),
        }
    }
}

fn metadata_sha256(channel: &Channel) -> Option<String> {
    let unit = channel.steps.iter().find(|step| step.name == "unit")?;
    unit.parameters.get("metadata_sha256")?.as_str().map(str::to_owned)
}

/// A file as it was named, else beside `from`, else of the same name beside `from`.
fn located(file: &Path, from: &Path) -> Result<PathBuf, RecordError> {
    if file.to_str().is_some_and(|f| f.starts_with("obspy:")) {
        return Ok(file.to_path_buf());
    }
    let folder = from.parent().unwrap_or_else(|| Path::new(""));
    let beside = file.file_name().map(|name| folder.join(name));
    let mut places = vec![file.to_path_buf(), folder.join(file)];
    places.extend(beside);
    places.dedup();
    let looked = places.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ");
    places.into_iter().find(|place| place.is_file()).ok_or_else(|| RecordError::SourceMissing {
        path: file.to_path_buf(),
        from: from.to_path_buf(),
        looked,
    })
}
