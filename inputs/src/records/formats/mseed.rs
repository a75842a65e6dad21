//! miniSEED 2: records of a fixed header of 48 bytes, blockettes and packed samples.

use super::{Recognition, Segment, StoredUnit};

const HEADER_BYTES: usize = 48;

/// Every record begins with a sequence number, a quality letter and a start time that exists, and none
/// is cut (ObsPy leaves out a last record that is, without a word).
pub(super) fn recognise(bytes: &[u8]) -> Recognition {
    if !begins_record(bytes) {
        return Recognition::No;
    }
    let mut at = 0;
    while at < bytes.len() {
        let record = &bytes[at..];
        if !begins_record(record) {
            let left = record.len();
            return Recognition::Broken(format!("{left} bytes from byte {at} on are no record"));
        }
        let Some(little) = byte_order(record) else {
            return Recognition::Broken(format!("the start time of the record at byte {at} does not exist"));
        };
        // Without blockette 1000 a record does not tell its length; ObsPy then looks for the next one.
        let Some(length) = record_length(record, little) else {
            return Recognition::Yes;
        };
        if record.len() < length {
            let left = record.len();
            return Recognition::Broken(format!(
                "the record at byte {at} has {length} bytes, but only {left} are left"
            ));
        }
        at += length;
    }
    Recognition::Yes
}

fn begins_record(bytes: &[u8]) -> bool {
    let Some(head) = bytes.get(..HEADER_BYTES) else {
        return false;
    };
    let number = head[..6].iter().all(|b| b.is_ascii_digit() || matches!(b, b' ' | 0));
    let quality = matches!(head[6], b'D' | b'R' | b'Q' | b'M') && matches!(head[7], b' ' | 0);
    let codes = head[8..20].iter().all(|b| *b == 0 || b.is_ascii_graphic() || *b == b' ');
    number && quality && codes
}

fn word(head: &[u8], at: usize, little: bool) -> Option<u16> {
    let pair = [*head.get(at)?, *head.get(at + 1)?];
    Some(if little { u16::from_le_bytes(pair) } else { u16::from_be_bytes(pair) })
}

/// Whether a record is little-endian: the order in which its start time is one; `None` if neither.
fn byte_order(head: &[u8]) -> Option<bool> {
    let clock = head[24] < 24 && head[25] < 60 && head[26] <= 60;
    [false, true].into_iter().find(|little| {
        let year = word(head, 20, *little).unwrap_or(0);
        let day = word(head, 22, *little).unwrap_or(0);
        clock && (1900..=2200).contains(&year) && (1..=366).contains(&day)
    })
}

/// Record length, bytes, from blockette 1000: a power of two.
fn record_length(record: &[u8], little: bool) -> Option<usize> {
    let mut at = usize::from(word(record, 46, little)?);
    while at >= HEADER_BYTES {
        let next = usize::from(word(record, at + 2, little)?);
        if word(record, at, little)? == 1000 {
            let exponent = *record.get(at + 6)?;
            return (7..=28).contains(&exponent).then(|| 1 << exponent);
        }
        // Blockettes go forward; anything else would never end.
        at = if next > at { next } else { 0 };
    }
    None
}

/// miniSEED holds no unit; the channel code hints at the instrument.
pub(super) fn unit(segment: &Segment) -> Result<StoredUnit, String> {
    let instrument = match super::super::naming::instrument(&segment.channel) {
        Some(instrument) => format!("; its code {} is that of {instrument}", segment.channel),
        None => String::new(),
    };
    Err(format!("miniSEED stores instrument counts without a unit{instrument}"))
}
