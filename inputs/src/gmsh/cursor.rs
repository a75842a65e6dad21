//! Words and numbers of a mesh file one after another, text or binary, each refusal with its place.

use std::path::Path;
use std::str::FromStr;

use crate::error::InputError;

/// A place in the content of a file.
pub(super) struct Cursor<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    /// Whether numbers are those of this machine in binary; else words of text.
    pub(super) binary: bool,
    /// The section that is being read, for messages.
    section: String,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self { path, bytes, at: 0, binary: false, section: String::new() }
    }

    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// A damaged file, here.
    pub(super) fn broken(&self, problem: impl Into<String>) -> InputError {
        let place = if self.binary {
            format!("byte {}", self.at)
        } else {
            let lines = self.bytes[..self.at].iter().filter(|byte| **byte == b'\n').count();
            format!("line {}", lines + 1)
        };
        let place = if self.section.is_empty() { place } else { format!("{place} (in ${})", self.section) };
        InputError::MeshBroken { path: self.path.to_path_buf(), place, problem: problem.into() }
    }

    fn skip_space(&mut self) {
        let space = self.bytes[self.at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        self.at += space;
    }

    /// The next word of text; empty at the end of the file.
    fn word(&mut self) -> &'a [u8] {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    /// What remains of the line, without the spaces around it.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.at = (self.at + length + 1).min(self.bytes.len());
        rest[..length].trim_ascii()
    }

    /// Takes the name of the section that begins here, without its `$`; `None` at the end of the file.
    pub(super) fn next_section(&mut self) -> Result<Option<String>, InputError> {
        self.section.clear();
        self.skip_space();
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        let line = self.line();
        match line.strip_prefix(b"$") {
            Some(name) if !name.is_empty() && name.len() < 64 => {
                self.section = String::from_utf8_lossy(name).into_owned();
                Ok(Some(self.section.clone()))
            }
            _ => Err(self.broken(format!("expected a section ($…), found {}", shown(line)))),
        }
    }

    /// Takes the `$End…` of the section.
    pub(super) fn end_section(&mut self) -> Result<(), InputError> {
        let (before, binary) = (self.at, std::mem::replace(&mut self.binary, false));
        let word = self.word();
        let end = word.strip_prefix(b"$End").is_some_and(|name| name == self.section.as_bytes());
        self.binary = binary;
        if end {
            return Ok(());
        }
        self.at = before;
        let found = if word.is_empty() { "the end of the file".into() } else { shown(word) };
        Err(self.broken(format!(
            "expected $End{} after the announced number of entries, found {found}",
            self.section
        )))
    }

    /// Goes beyond the end of a section that is of no use here.
    pub(super) fn skip_section(&mut self) -> Result<(), InputError> {
        let end = format!("$End{}", self.section).into_bytes();
        let found = self.bytes[self.at..].windows(end.len()).position(|window| window == end);
        let Some(found) = found else {
            return Err(self.broken(format!("the file ends without $End{}", self.section)));
        };
        self.at += found + end.len();
        Ok(())
    }

    /// The next bytes of a binary file.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], InputError> {
        match self.bytes[self.at..].first_chunk::<N>() {
            Some(bytes) => {
                self.at += N;
                Ok(*bytes)
            }
            None => Err(self.broken("the file ends here: it is cut off")),
        }
    }

    fn parse<T: FromStr>(&mut self, expected: &str) -> Result<T, InputError> {
        let before = self.at;
        let word = self.word();
        if let Some(value) = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok()) {
            return Ok(value);
        }
        if word.is_empty() {
            return Err(self.broken("the file ends here: it is cut off"));
        }
        self.at = before;
        self.skip_space();
        Err(self.broken(format!("expected {expected}, found {}", shown(word))))
    }

    /// An `int` of the format: 4 bytes in binary, and no larger in text.
    pub(super) fn int(&mut self) -> Result<i64, InputError> {
        let int: i32 =
            if self.binary { i32::from_ne_bytes(self.take()?) } else { self.parse("an integer of 32 bits")? };
        Ok(int.into())
    }

    /// A `size_t` of the format: 8 bytes in binary.
    pub(super) fn size(&mut self) -> Result<u64, InputError> {
        if self.binary {
            Ok(u64::from_ne_bytes(self.take()?))
        } else {
            self.parse("a number that is not negative")
        }
    }

    /// A `double` of the format.
    pub(super) fn real(&mut self) -> Result<f64, InputError> {
        if self.binary { Ok(f64::from_ne_bytes(self.take()?)) } else { self.parse("a number") }
    }

    /// A number of entries that the rest of the file can hold: each is at least `words` words of text
    /// or `bytes` bytes. Memory is asked for only after this.
    pub(super) fn fits(&self, count: u64, words: u64, bytes: u64, what: &str) -> Result<usize, InputError> {
        let least = if self.binary { bytes } else { words.saturating_mul(2) };
        let left = (self.bytes.len() - self.at) as u64;
        match count.checked_mul(least) {
            Some(needed) if needed <= left => Ok(count as usize),
            _ => Err(self.broken(format!("{count} {what} announced, more than the file can hold"))),
        }
    }

    /// Takes one byte if it is this one.
    pub(super) fn skip_byte(&mut self, byte: u8) {
        if self.bytes.get(self.at) == Some(&byte) {
            self.at += 1;
        }
    }
}

/// Bytes of a file as a message shows them.
pub(super) fn shown(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]);
    let text: String = text.chars().map(|c| if c.is_control() { '·' } else { c }).collect();
    format!("\"{text}{}\"", if bytes.len() > 40 { "…" } else { "" })
}
