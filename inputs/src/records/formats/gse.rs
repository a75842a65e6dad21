//! GSE1 and GSE2: text lines, samples as numbers or six-bit compressed, with a checksum.

use super::{Recognition, Segment, StoredUnit};

/// What the two versions of the format name differently.
struct Words {
    /// Begin of a waveform line, of a data section and of its checksum.
    waveform: &'static [u8],
    data: &'static [u8],
    checksum: &'static [u8],
    /// The type of data that is packed in six-bit characters.
    packed: &'static [u8],
    /// Columns of the data type and of the number of samples in the waveform line.
    kind: std::ops::Range<usize>,
    count: std::ops::Range<usize>,
}

const GSE2: Words = Words {
    waveform: b"WID2",
    data: b"DAT2",
    checksum: b"CHK2",
    packed: b"CM6",
    kind: 44..48,
    count: 48..56,
};
const GSE1: Words = Words {
    waveform: b"WID1",
    data: b"DAT1",
    checksum: b"CHK1",
    packed: b"CMP6",
    kind: 74..78,
    count: 27..35,
};

/// Longest line of a data section; a longer one does not fit the buffer of ObsPy's unpacker.
const LINE_BYTES: usize = 80;

/// Files begin with the waveform line `WID2`.
pub(super) fn recognise_2(bytes: &[u8]) -> Recognition {
    if !bytes.starts_with(b"WID2 ") {
        return Recognition::No;
    }
    judged(check(bytes, &GSE2))
}

/// Files begin with `WID1`, or with the line `XW01` before it.
pub(super) fn recognise_1(bytes: &[u8]) -> Recognition {
    if !(bytes.starts_with(b"WID1 ") || bytes.starts_with(b"XW01")) {
        return Recognition::No;
    }
    judged(check(bytes, &GSE1))
}

fn judged(check: Result<(), String>) -> Recognition {
    check.map_or_else(Recognition::Broken, |()| Recognition::Yes)
}

/// Whether every waveform has its data section, its samples and its checksum line.
///
/// The unpacker of ObsPy trusts all of that; a packed section that ends early or runs on sends it beyond
/// its memory.
fn check(bytes: &[u8], words: &Words) -> Result<(), String> {
    let mut lines = (1..).zip(bytes.split(|b| *b == b'\n').map(<[u8]>::trim_ascii_end));
    let mut waveforms = 0;
    while let Some((number, line)) = lines.by_ref().find(|(_, line)| line.starts_with(words.waveform)) {
        waveforms += 1;
        let samples = sample_count(line.get(words.count.clone()), bytes.len())
            .map_err(|problem| format!("line {number}: the waveform line {problem}"))?;
        let packed = line.get(words.kind.clone()).map(<[u8]>::trim_ascii) == Some(words.packed);
        let (mut inside, mut found, mut closed) = (false, 0, false);
        for (after, (number, line)) in lines.by_ref().enumerate() {
            if line.starts_with(words.checksum) {
                closed = true;
                break;
            }
            if inside && packed {
                found += packed_samples(line).map_err(|problem| format!("line {number}: {problem}"))?;
            } else if line.starts_with(words.data) {
                inside = true;
            } else if packed && after > 0 && line.len() > LINE_BYTES {
                // The line right behind the waveform line is the header's own and may be longer.
                return Err(format!("line {number}: {} characters, at most {LINE_BYTES}", line.len()));
            }
        }
        let word = |word: &[u8]| String::from_utf8_lossy(word).into_owned();
        if !inside {
            return Err(format!("line {number}: no line {} follows the waveform line", word(words.data)));
        }
        if !closed {
            return Err(format!(
                "line {number}: the data have no line {} at their end",
                word(words.checksum)
            ));
        }
        if packed && found != samples {
            return Err(format!("line {number}: {samples} samples are announced, {found} are there"));
        }
    }
    if waveforms == 0 {
        return Err(format!("no {} line", String::from_utf8_lossy(words.waveform)));
    }
    Ok(())
}

/// Samples that end in a line of packed data: a character stands for six bits, of which the highest says that
/// the sample goes on.
fn packed_samples(line: &[u8]) -> Result<usize, String> {
    if line.len() > LINE_BYTES {
        return Err(format!("{} characters of packed data, at most {LINE_BYTES}", line.len()));
    }
    let ends = line.iter().map(|&character| match character {
        b'+' | b'-' | b'0'..=b'9' | b'A'..=b'T' => Ok(1),
        b'U'..=b'Z' | b'a'..=b'z' => Ok(0),
        _ => Err(format!("\"{}\" is no character of packed data", character.escape_ascii())),
    });
    ends.sum()
}

/// A header must not announce more samples than the file can hold.
fn sample_count(field: Option<&[u8]>, size: usize) -> Result<usize, String> {
    let text = field.and_then(|field| std::str::from_utf8(field).ok());
    match text.and_then(|text| text.trim().parse::<usize>().ok()) {
        None => Err("gives no number of samples".into()),
        Some(0) => Err("says 0 samples".into()),
        Some(count) if count > size => Err(format!("says {count} samples, the whole file has {size} bytes")),
        Some(count) => Ok(count),
    }
}

/// The calibration turns counts into a displacement at one period only: it is no unit of the record.
pub(super) fn unit(segment: &Segment) -> Result<StoredUnit, String> {
    let calibration = match (segment.calib, segment.number("calper")) {
        (Some(calib), Some(period)) => format!("CALIB = {calib} nm/count at a period of {period} s"),
        (Some(calib), None) => format!("the calibration {calib} nm/count"),
        _ => "the calibration".into(),
    };
    Err(format!("samples are instrument counts, and {calibration} is a displacement for that period only"))
}
