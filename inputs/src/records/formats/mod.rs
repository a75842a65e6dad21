//! The formats that can be read: one row each. A new format is a new row and a module beside these.

mod gse;
mod knet;
mod mseed;
mod sac;
mod text;

use super::reader::Segment;
use super::unit::Unit;
use crate::motion::Quantity;

/// What a look at a file's bytes says about one format.
pub(crate) enum Recognition {
    /// Another format.
    No,
    /// This one, and its header is in order.
    Yes,
    /// This one, but its header contradicts itself or the file; the text says how.
    Broken(String),
}

/// What the stored numbers mean according to the file itself.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StoredUnit {
    /// The unit in words, as the file has it.
    pub(crate) text: String,
    pub(crate) quantity: Quantity,
    /// Stored value times this is SI.
    pub(crate) factor: f64,
}

impl StoredUnit {
    fn of(unit: Unit) -> Self {
        Self { text: unit.symbol().to_string(), quantity: unit.quantity(), factor: unit.factor() }
    }
}

/// One format: how it is recognised, which reader of ObsPy takes it, how its unit is decided.
pub(crate) struct RecordFormat {
    /// Name in messages and in [`super::Channel::format`].
    pub(crate) name: &'static str,
    /// Format word for ObsPy; the script has its own list of those that it accepts.
    pub(crate) obspy: &'static str,
    /// Looks at the whole file; never at its name.
    pub(crate) recognise: fn(&[u8]) -> Recognition,
    /// What the file calls its samples, in words (`counts` where it does not say).
    pub(crate) stored: &'static str,
    /// The unit from the file's own header, or why it does not tell.
    pub(crate) unit: fn(&Segment) -> Result<StoredUnit, String>,
    /// Whether the samples that were read agree with the header; the text says why not.
    pub(crate) consistent: fn(&Segment) -> Result<(), String>,
    /// Warnings of ObsPy (by category) which mean that a part of the file was skipped.
    pub(crate) damage: &'static [&'static str],
}

/// All formats; the first row that recognises a file wins.
pub(crate) const FORMATS: [RecordFormat; 13] = [
    // Fixed record headers: sequence number, quality letter, year and day. Samples are counts.
    RecordFormat {
        name: "miniSEED",
        obspy: "MSEED",
        recognise: mseed::recognise,
        stored: "counts",
        unit: mseed::unit,
        consistent: |_| Ok(()),
        damage: &["InternalMSEEDWarning", "InternalMSEEDError"],
    },
    // "Origin Time" in the first line. Scale factor in gal per count; ObsPy's calib is m/s² per count.
    RecordFormat {
        name: "K-NET",
        obspy: "KNET",
        recognise: knet::recognise,
        stored: "counts",
        unit: knet::unit,
        consistent: knet::consistent,
        damage: &[],
    },
    // "WID2" in the first line. Calibration is a displacement in nm per count at one period.
    RecordFormat {
        name: "GSE2",
        obspy: "GSE2",
        recognise: gse::recognise_2,
        stored: "counts",
        unit: gse::unit,
        consistent: |_| Ok(()),
        damage: &[],
    },
    // "WID1" or "XW01" in the first line. Calibration as for GSE2.
    RecordFormat {
        name: "GSE1",
        obspy: "GSE1",
        recognise: gse::recognise_1,
        stored: "counts",
        unit: gse::unit,
        consistent: |_| Ok(()),
        damage: &[],
    },
    // Binary header of 632 bytes, version 6, either byte order, file size = 632 + 4 npts. IDEP gives
    // the unit: nm, nm/s or nm/s².
    RecordFormat {
        name: "SAC",
        obspy: "SAC",
        recognise: sac::recognise,
        stored: "samples",
        unit: sac::unit,
        consistent: |_| Ok(()),
        damage: &[],
    },
    // Text formats. Their readers are plug-ins of ObsPy (`inputs/python/hati_obspy`), which recognise
    // them, check the samples against the header and refuse with the line.
    text::format("COSMOS", "COSMOS"),
    text::format("SMC", "SMC"),
    text::format("RENADIC", "RENADIC"),
    text::format("USC", "USC"),
    text::format("CSMIP", "CSMIP"),
    text::format("ESM", "ESM_DYNA"),
    text::format("PEER", "PEER_AT2"),
    text::format("text columns", "COLUMNS"),
];

/// Names of all formats, for messages.
pub(crate) fn known() -> String {
    FORMATS.map(|format| format.name).join(", ")
}

/// What a file is that is recognised and never read as a record, and what to do about it.
pub(crate) fn refused(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    let starts = |magic: &[u8]| bytes.starts_with(magic);
    if bytes.len() > 2 && bytes[0] == 0x80 && (2..=5).contains(&bytes[1]) {
        return Some((
            "a Python pickle, which can run code when it is opened; it was not opened",
            "export the record as miniSEED or SAC from the program that wrote it",
        ));
    }
    if starts(b"\x1f\x8b") || starts(b"BZh") || starts(b"PK\x03\x04") || starts(b"\xfd7zXZ") {
        return Some(("a compressed file", "unpack it and give the record inside"));
    }
    if bytes.get(257..262) == Some(b"ustar".as_slice()) {
        return Some(("a tar archive", "unpack it and give the record inside"));
    }
    if starts(b"<?xml") || starts(b"\xef\xbb\xbf<?xml") {
        return Some((
            "an XML document (station metadata or an event), not a record",
            "give the waveform file that belongs to it",
        ));
    }
    if starts(b"MS\x03") {
        return Some(("a miniSEED 3 file, which is not read yet", "convert it to miniSEED 2"));
    }
    let volume = bytes.len() > 8
        && bytes[..6].iter().all(u8::is_ascii_digit)
        && matches!(bytes[6], b'V' | b'A' | b'S' | b'T');
    if volume {
        return Some((
            "a full SEED volume with control headers, which is not read",
            "extract its data records as miniSEED",
        ));
    }
    None
}

/// Whether a file may be text: marked as UTF-16, or no zero byte and hardly a control character at its
/// beginning.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return true;
    }
    let head = &bytes[..bytes.len().min(4096)];
    let control = head.iter().filter(|b| b.is_ascii_control() && !b.is_ascii_whitespace()).count();
    !head.contains(&0) && control * 50 <= head.len()
}

/// The first bytes of a file in a form that can be printed.
pub(crate) fn beginning(bytes: &[u8]) -> String {
    let shown = &bytes[..bytes.len().min(24)];
    format!("\"{}\"", shown.escape_ascii())
}
