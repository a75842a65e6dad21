//! The child process: Python with ObsPy, a script through `-c`, requests and replies through pipes.
//!
//! The protocol stands at the head of `inputs/python/hati_records.py`, which is compiled in. Files
//! travel as bytes: the child opens nothing of the user's, so it can neither fetch an address nor
//! expand a pattern, and what it parses is what was recognised and hashed here.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::Limits;
use crate::error::InputError;
use crate::python::find_python;

const SCRIPT: &str = include_str!("../../python/hati_records.py");

/// Largest reply line, bytes.
const LINE_LIMIT: u64 = 64 << 20;
/// Largest number of segments in one file; a sound record has one per channel.
const SEGMENT_LIMIT: u64 = 2000;
/// How much of the end of stderr goes into an error, bytes.
const STDERR_TAIL: usize = 2000;

/// A stretch of samples as the file stores them.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    pub(crate) id: String,
    pub(crate) channel: String,
    pub(crate) dt: f64,
    pub(crate) start_ns: i64,
    pub(crate) start_utc: String,
    pub(crate) end_utc: String,
    pub(crate) calib: Option<f64>,
    pub(crate) header: Map<String, Value>,
    pub(crate) samples: Vec<f64>,
    /// Ground motion with the instrument's response taken off, where that was asked for.
    pub(crate) ground: Option<Ground>,
}

/// What became of a response that was to be removed.
#[derive(Debug, Clone)]
pub(crate) enum Ground {
    /// Samples in SI, and the settings and numbers of the removal.
    Removed { samples: Vec<f64>, about: Value },
    /// Why not, and what to do.
    Refused { problem: String, remedy: String },
}

impl Segment {
    /// A number of the file's own header.
    pub(crate) fn number(&self, key: &str) -> Option<f64> {
        self.header.get(key).and_then(Value::as_f64)
    }

    /// A text of the file's own header.
    pub(crate) fn text(&self, key: &str) -> Option<&str> {
        self.header.get(key).and_then(Value::as_str)
    }

    /// A flag of the file's own header.
    pub(crate) fn flag(&self, key: &str) -> Option<bool> {
        self.header.get(key).and_then(Value::as_bool)
    }
}

/// What one file gave; `format` is the reader's word for the format that took it.
pub(super) enum Answer {
    Segments {
        format: String,
        segments: Vec<Segment>,
        warnings: Vec<String>,
    },
    Refused {
        format: String,
        problem: String,
        remedy: Option<String>,
    },
    TooMany(u64),
    /// No text format knows the content.
    Unknown,
    /// The plug-ins for text formats are not installed.
    NoPlugIns(String),
}

/// One file as it goes to the reader.
pub(super) struct Request<'a> {
    /// The reader's word for the format; empty: let the plug-ins look.
    pub(super) format: &'a str,
    pub(super) content: &'a [u8],
    /// What to do with the metadata, and their bytes.
    pub(super) response: Option<(Value, &'a [u8])>,
}

#[derive(Deserialize)]
struct SegmentHeader {
    id: String,
    channel: String,
    npts: u64,
    dt: f64,
    start_ns: i64,
    start_utc: String,
    end_utc: String,
    calib: Option<f64>,
    header: Map<String, Value>,
    response: Option<Value>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum AnswerHeader {
    Channels {
        format: String,
        channels: Vec<SegmentHeader>,
        warnings: Vec<String>,
    },
    Refused {
        format: String,
        error: String,
        remedy: Option<String>,
    },
    TooMany {
        too_many: u64,
    },
    Unknown {
        #[serde(rename = "unknown")]
        _unknown: bool,
    },
    NoPlugIns {
        readers: String,
    },
}

#[derive(Deserialize)]
struct ReadReply {
    obspy: String,
    files: Vec<AnswerHeader>,
}

/// A running reader; dropped, its child ends.
pub(super) struct Reader {
    python: PathBuf,
    child: Arc<Mutex<Child>>,
    stdin: Option<ChildStdin>,
    stdout: BufReader<ChildStdout>,
    stderr: Option<JoinHandle<Vec<u8>>>,
    expired: Arc<AtomicBool>,
    watchdog: Option<(Sender<()>, JoinHandle<()>)>,
    limit: Duration,
}

impl Reader {
    /// Starts the interpreter; its time begins to run.
    pub(super) fn start(python: Option<&Path>, limits: &Limits) -> Result<Self, InputError> {
        let (python, tried) = match python {
            Some(python) => (python.to_path_buf(), python.display().to_string()),
            None => find_python(),
        };
        let mut child = Command::new(&python)
            // Isolated: no PYTHON* variables, no user packages, no current folder in the path.
            .args(["-I", "-X", "utf8", "-c", SCRIPT])
            .env("OPENBLAS_NUM_THREADS", "1")
            .env("OMP_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| InputError::PythonMissing { tried: format!("{tried} ({error})") })?;
        let stdin = child.stdin.take();
        let stdout = BufReader::new(child.stdout.take().expect("stdout is piped"));
        let stderr = child.stderr.take().expect("stderr is piped");
        let child = Arc::new(Mutex::new(child));
        let expired = Arc::new(AtomicBool::new(false));
        let (done, wait) = channel::<()>();
        let (guarded, flag, limit) = (child.clone(), expired.clone(), limits.time);
        let watchdog = thread::spawn(move || {
            if wait.recv_timeout(limit) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                flag.store(true, Ordering::SeqCst);
                kill(&guarded);
            }
        });
        Ok(Self {
            python,
            child,
            stdin,
            stdout,
            stderr: Some(thread::spawn(move || tail(stderr))),
            expired,
            watchdog: Some((done, watchdog)),
            limit,
        })
    }

    /// Folder of the installed ObsPy package.
    pub(super) fn package_root(&mut self) -> Result<PathBuf, InputError> {
        let reply = self.ask(&json!({"op": "locate"}), &[])?;
        match reply.get("root").and_then(Value::as_str) {
            Some(root) => Ok(PathBuf::from(root)),
            None => Err(self.failed("its answer names no folder".into())),
        }
    }

    /// Segments of several files, and ObsPy's version.
    pub(super) fn read(
        &mut self,
        files: &[Request<'_>],
        limits: &Limits,
    ) -> Result<(String, Vec<Answer>), InputError> {
        let entry = |file: &Request<'_>| {
            let response = file.response.as_ref().map(|(request, _)| request);
            json!({"format": file.format, "bytes": file.content.len(), "response": response})
        };
        let entries: Vec<Value> = files.iter().map(entry).collect();
        let request = json!({
            "op": "read", "files": entries, "max_samples": limits.samples,
            "max_segments": SEGMENT_LIMIT, "memory_bytes": limits.memory_bytes,
        });
        let metadata = |file: &Request<'_>| file.response.as_ref().map_or(Vec::new(), |(_, m)| m.to_vec());
        let metadata: Vec<Vec<u8>> = files.iter().map(metadata).collect();
        let contents = files.iter().zip(&metadata).flat_map(|(file, metadata)| [file.content, metadata]);
        let contents: Vec<&[u8]> = contents.collect();
        let reply = self.ask(&request, &contents)?;
        let reply: ReadReply = serde_json::from_value(reply)
            .map_err(|error| self.failed(format!("its answer is not understood: {error}")))?;
        if reply.files.len() != files.len() {
            return Err(self.failed("it answered for another number of files".into()));
        }
        let answers: Result<Vec<_>, _> =
            reply.files.into_iter().map(|answer| self.answer(answer, limits)).collect();
        Ok((reply.obspy, answers?))
    }

    fn answer(&mut self, header: AnswerHeader, limits: &Limits) -> Result<Answer, InputError> {
        Ok(match header {
            AnswerHeader::Refused { format, error, remedy } => {
                Answer::Refused { format, problem: error, remedy }
            }
            AnswerHeader::TooMany { too_many } => Answer::TooMany(too_many),
            AnswerHeader::Unknown { .. } => Answer::Unknown,
            AnswerHeader::NoPlugIns { readers } => Answer::NoPlugIns(readers),
            AnswerHeader::Channels { format, channels, warnings } => {
                let total = channels.iter().fold(0_u64, |sum, c| sum.saturating_add(c.npts));
                if total > limits.samples {
                    return Err(self.failed(format!("it announced {total} samples")));
                }
                let segments: Result<_, _> =
                    channels.into_iter().map(|header| self.segment(header)).collect();
                Answer::Segments { format, segments: segments?, warnings }
            }
        })
    }

    /// Files of the samples in the blocks, as ObsPy writes them.
    pub(super) fn write(
        &mut self,
        format: &str,
        traces: &[Value],
        blocks: &[Vec<u8>],
        limit: u64,
    ) -> Result<Vec<Vec<u8>>, InputError> {
        let request = json!({"op": "write", "format": format, "traces": traces});
        let blocks: Vec<&[u8]> = blocks.iter().map(Vec::as_slice).collect();
        let reply = self.ask(&request, &blocks)?;
        let sizes: Option<Vec<u64>> =
            reply["bytes"].as_array().map(|sizes| sizes.iter().filter_map(Value::as_u64).collect());
        let Some(sizes) = sizes.filter(|sizes| sizes.iter().sum::<u64>() <= limit) else {
            return Err(self.failed("its answer to what it was to write is not understood".into()));
        };
        sizes.into_iter().map(|size| self.block(size as usize)).collect()
    }

    fn block(&mut self, size: usize) -> Result<Vec<u8>, InputError> {
        let mut bytes = vec![0_u8; size];
        match self.stdout.read_exact(&mut bytes) {
            Ok(()) => Ok(bytes),
            Err(_) => Err(self.failed("it ended before all it announced had come".into())),
        }
    }

    fn samples(&mut self, count: u64) -> Result<Vec<f64>, InputError> {
        let bytes = self.block(count as usize * 8)?;
        let number = |chunk: &[u8]| f64::from_le_bytes(chunk.try_into().expect("chunks of 8"));
        Ok(bytes.chunks_exact(8).map(number).collect())
    }

    fn segment(&mut self, header: SegmentHeader) -> Result<Segment, InputError> {
        let samples = self.samples(header.npts)?;
        let ground = match header.response {
            None => None,
            Some(about) => {
                let samples = self.samples(header.npts)?;
                let text = |key: &str| about[key].as_str().unwrap_or_default().to_string();
                Some(match about.get("refused") {
                    Some(_) => Ground::Refused { problem: text("refused"), remedy: text("remedy") },
                    None => Ground::Removed { samples, about },
                })
            }
        };
        Ok(Segment {
            id: header.id,
            channel: header.channel,
            dt: header.dt,
            start_ns: header.start_ns,
            start_utc: header.start_utc,
            end_utc: header.end_utc,
            calib: header.calib,
            header: header.header,
            samples,
            ground,
        })
    }

    /// Sends one request and returns the JSON line of its reply.
    fn ask(&mut self, request: &Value, contents: &[&[u8]]) -> Result<Value, InputError> {
        let stdin = self.stdin.as_mut().expect("open until the reader is dropped");
        let mut send = || {
            stdin.write_all(request.to_string().as_bytes())?;
            stdin.write_all(b"\n")?;
            contents.iter().try_for_each(|content| stdin.write_all(content))?;
            stdin.flush()
        };
        // A child that died says why on stderr; a broken pipe alone tells nothing.
        let sent = send();
        let mut line = Vec::new();
        let received = (&mut self.stdout).take(LINE_LIMIT).read_until(b'\n', &mut line);
        if sent.is_err() || received.is_err() || line.last() != Some(&b'\n') {
            return Err(self.failed("it ended without an answer".into()));
        }
        let reply: Value = serde_json::from_slice(&line)
            .map_err(|error| self.failed(format!("its answer is not JSON: {error}")))?;
        let message = || reply["message"].as_str().unwrap_or_default().to_string();
        match reply.get("failed").and_then(Value::as_str) {
            None => Ok(reply),
            Some("import") => {
                Err(InputError::ObspyMissing { python: self.python.clone(), reason: message() })
            }
            Some(_) => Err(self.failed(message())),
        }
    }

    /// The error for a child that did not do its part: its time, its exit status and its last words.
    fn failed(&mut self, problem: String) -> InputError {
        self.stdin = None;
        let status = self.stop();
        let words = self.stderr.take().and_then(|thread| thread.join().ok());
        let words = String::from_utf8_lossy(&words.unwrap_or_default()).trim().to_string();
        let stderr =
            if words.is_empty() { String::new() } else { format!("\n  {}", words.replace('\n', "\n  ")) };
        let python = self.python.clone();
        if self.expired.load(Ordering::SeqCst) {
            let seconds = self.limit.as_secs_f64();
            return InputError::ReaderTimeout { python, seconds, stderr };
        }
        let crashed = status.is_some_and(|status| status.code().is_none());
        let status = status.map_or("state unknown".into(), |status| status.to_string());
        InputError::ReaderFailed { python, problem: format!("{problem} ({status})"), stderr, crashed }
    }

    /// Ends the child (it has a moment to go by itself) and says how it ended.
    fn stop(&mut self) -> Option<ExitStatus> {
        self.stdin = None;
        let mut status = None;
        for _ in 0..100 {
            let mut child = self.child.lock().unwrap_or_else(|broken| broken.into_inner());
            status = child.try_wait().ok().flatten();
            drop(child);
            if status.is_some() {
                break;
            }
            thread::sleep(Duration::from_millis(2));
        }
        if status.is_none() {
            kill(&self.child);
            let mut child = self.child.lock().unwrap_or_else(|broken| broken.into_inner());
            status = child.wait().ok();
        }
        if let Some((done, thread)) = self.watchdog.take() {
            // The watchdog may be gone already; then nobody listens.
            let _ = done.send(());
            let _ = thread.join();
        }
        status
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        // Nothing is lost: it has answered, or its end was already waited for.
        kill(&self.child);
        self.stop();
    }
}

fn kill(child: &Mutex<Child>) {
    let mut child = child.lock().unwrap_or_else(|broken| broken.into_inner());
    // It may have ended by itself in this moment.
    let _ = child.kill();
}

/// Reads a stream to its end and keeps the last bytes.
fn tail(mut stream: impl Read) -> Vec<u8> {
    let mut kept = Vec::new();
    let mut block = [0_u8; 4096];
    while let Ok(count @ 1..) = stream.read(&mut block) {
        kept.extend_from_slice(&block[..count]);
        if kept.len() > 2 * STDERR_TAIL {
            kept.drain(..kept.len() - STDERR_TAIL);
        }
    }
    let surplus = kept.len().saturating_sub(STDERR_TAIL);
    kept.drain(..surplus);
    kept
}
