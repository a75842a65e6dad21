//! Header of a classic NetCDF file: dimensions, attributes and variables, as bytes and back.
//!
//! Written after the format's own specification (NetCDF User's Guide, appendix “File Format
//! Specifications”): big-endian, every list led by its tag and count, names and values padded to four
//! bytes. Files are of the 64-bit offset kind (CDF-2), and of the 64-bit data kind (CDF-5) where a
//! variable is too large for that.

/// Value type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Kind {
    /// Signed byte.
    Byte,
    /// Byte of a text.
    Char,
    /// 32-bit integer.
    Int,
    /// 32-bit float.
    Float,
    /// 64-bit float.
    Double,
}

impl Kind {
    /// Bytes of one value.
    pub(in super::super) fn bytes(self) -> usize {
        match self {
            Self::Byte | Self::Char => 1,
            Self::Int | Self::Float => 4,
            Self::Double => 8,
        }
    }

    fn tag(self) -> u32 {
        match self {
            Self::Byte => 1,
            Self::Char => 2,
            Self::Int => 4,
            Self::Float => 5,
            Self::Double => 6,
        }
    }

    fn from_tag(tag: u64) -> Option<Self> {
        [Self::Byte, Self::Char, Self::Int, Self::Float, Self::Double]
            .into_iter()
            .find(|k| u64::from(k.tag()) == tag)
    }
}

/// Value of an attribute.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) enum Attribute {
    /// Text.
    Text(String),
    /// One 32-bit integer.
    Int(i32),
    /// One 64-bit float.
    Double(f64),
    /// 32-bit floats, for instance a fill value.
    Float(f32),
    /// Bytes, for instance flag values.
    Bytes(Vec<i8>),
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

/// A variable; one whose first dimension is 0 has a value for every row.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Variable {
    /// Name.
    pub(in super::super) name: String,
    /// Value type.
    pub(in super::super) kind: Kind,
    /// Indices into [`Layout::dimensions`].
    pub(in super::super) dimensions: Vec<usize>,
    /// Attributes in order.
    pub(in super::super) attributes: Vec<(String, Attribute)>,
}

/// Dimensions, attributes and variables of a file. Dimension 0 is the one that grows; its length is 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in super::super) struct Layout {
    /// Name and length.
    pub(in super::super) dimensions: Vec<(String, usize)>,
    /// Global attributes.
    pub(in super::super) attributes: Vec<(String, Attribute)>,
    /// Variables.
    pub(in super::super) variables: Vec<Variable>,
}

/// Where things lie in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in super::super) struct Places {
    /// Version byte: 2 or 5.
    pub(super) version: u8,
    /// First byte of each variable.
    pub(super) begins: Vec<u64>,
    /// First byte of the first row.
    pub(super) rows_begin: u64,
    /// Bytes of a row.
    pub(super) row_bytes: u64,
}

const DIMENSION: u32 = 0x0a;
const VARIABLE: u32 = 0x0b;
const ATTRIBUTE: u32 = 0x0c;

/// Largest variable of a CDF-2 file, bytes.
const LARGEST: u64 = u32::MAX as u64 - 3;

impl Layout {
    /// Whether a variable grows with the rows.
    pub(in super::super) fn is_row(&self, variable: &Variable) -> bool {
        variable.dimensions.first() == Some(&0)
    }

    /// Number of values of a variable, of one row of it where it grows.
    pub(in super::super) fn values(&self, variable: &Variable) -> usize {
        let fixed = variable.dimensions.iter().skip(usize::from(self.is_row(variable)));
        fixed.map(|&d| self.dimensions[d].1).product()
    }

    /// Bytes of a variable (of one row of it where it grows), padded to four.
    pub(in super::super) fn bytes(&self, variable: &Variable) -> u64 {
        (self.values(variable) as u64 * variable.kind.bytes() as u64).next_multiple_of(4)
    }

    /// The header's bytes, and where everything lies behind it.
    pub(super) fn encode(&self) -> (Vec<u8>, Places) {
        let large = self.variables.iter().any(|v| self.bytes(v) > LARGEST);
        let version = if large { 5 } else { 2 };
        // The offsets do not change the header's length, so a first pass measures it.
        let mut begins = vec![0; self.variables.len()];
        let mut next = self.encode_with(version, &begins).len() as u64;
        for growing in [false, true] {
            for (begin, variable) in begins.iter_mut().zip(&self.variables) {
                if self.is_row(variable) == growing {
                    *begin = next;
                    next += self.bytes(variable);
                }
            }
        }
        let row_bytes = self.row_bytes();
        let places = Places { version, rows_begin: next - row_bytes, row_bytes, begins };
        (self.encode_with(version, &places.begins), places)
    }

    pub(super) fn row_bytes(&self) -> u64 {
        self.variables.iter().filter(|v| self.is_row(v)).map(|v| self.bytes(v)).sum()
    }

    fn encode_with(&self, version: u8, begins: &[u64]) -> Vec<u8> {
        let mut to = Encoder { bytes: vec![b'C', b'D', b'F', version], wide: version == 5 };
        to.count(0);
        to.list(DIMENSION, self.dimensions.len());
        for (name, length) in &self.dimensions {
            to.name(name);
            to.count(*length as u64);
        }
        to.attributes(&self.attributes);
        to.list(VARIABLE, self.variables.len());
        for (variable, begin) in self.variables.iter().zip(begins) {
            to.name(&variable.name);
            to.count(variable.dimensions.len() as u64);
            variable.dimensions.iter().for_each(|&d| to.count(d as u64));
            to.attributes(&variable.attributes);
            to.word(variable.kind.tag());
            to.count(self.bytes(variable));
            to.bytes.extend(begin.to_be_bytes());
        }
        to.bytes
    }

    /// Reads a header; `None` where it is none, or holds what [`Self::encode`] never writes.
    /// Returns the rows that it tells of.
    pub(super) fn decode(bytes: &[u8]) -> Option<(Self, Places, u64)> {
        let version = *bytes.strip_prefix(b"CDF")?.first()?;
        if version != 2 && version != 5 {
            return None;
        }
        let mut from = Decoder { bytes, at: 4, wide: version == 5 };
        let rows = from.count()?;
        let mut layout = Self::default();
        for _ in 0..from.list(DIMENSION)? {
            layout.dimensions.push((from.name()?, from.count()? as usize));
        }
        layout.attributes = from.attributes()?;
        let mut begins = vec![];
        for _ in 0..from.list(VARIABLE)? {
            let name = from.name()?;
            let rank = from.count()?;
            let dimensions: Option<Vec<usize>> = (0..rank).map(|_| Some(from.count()? as usize)).collect();
            let dimensions = dimensions.filter(|d| d.iter().all(|&d| d < layout.dimensions.len()))?;
            let attributes = from.attributes()?;
            let kind = Kind::from_tag(from.word()?.into())?;
            from.count()?;
            begins.push(u64::from_be_bytes(from.take(8)?.try_into().ok()?));
            layout.variables.push(Variable { name, kind, dimensions, attributes });
        }
        let growing = layout.variables.iter().zip(&begins).filter(|(v, _)| layout.is_row(v));
        let rows_begin = growing.map(|(_, &begin)| begin).min()?;
        let row_bytes = layout.row_bytes();
        Some((layout, Places { version, begins, rows_begin, row_bytes }, rows))
    }
}

impl Places {
    /// The number of rows as it stands in the file's bytes from 4 on.
    pub(super) fn row_count(&self, rows: u64) -> Vec<u8> {
        if self.version == 5 { rows.to_be_bytes().to_vec() } else { (rows as u32).to_be_bytes().to_vec() }
    }
}

struct Encoder {
    bytes: Vec<u8>,
    wide: bool,
}

impl Encoder {
    fn word(&mut self, value: u32) {
        self.bytes.extend(value.to_be_bytes());
    }

    /// A number that is never negative: 8 bytes in CDF-5, 4 before; one that is too large there is all
    /// ones, which readers take for “work it out”.
    fn count(&mut self, value: u64) {
        if self.wide {
            self.bytes.extend(value.to_be_bytes());
        } else {
            self.word(u32::try_from(value).unwrap_or(u32::MAX));
        }
    }

    fn list(&mut self, tag: u32, length: usize) {
        self.word(if length == 0 { 0 } else { tag });
        self.count(length as u64);
    }

    fn pad(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    fn name(&mut self, text: &str) {
        self.count(text.len() as u64);
        self.bytes.extend(text.as_bytes());
        self.pad();
    }

    fn attributes(&mut self, attributes: &[(String, Attribute)]) {
        self.list(ATTRIBUTE, attributes.len());
        for (name, value) in attributes {
            self.name(name);
            let (tag, count, bytes) = match value {
                Attribute::Text(text) => (2, text.len(), text.as_bytes().to_vec()),
                Attribute::Int(v) => (4, 1, v.to_be_bytes().to_vec()),
                Attribute::Float(v) => (5, 1, v.to_be_bytes().to_vec()),
                Attribute::Double(v) => (6, 1, v.to_be_bytes().to_vec()),
                Attribute::Bytes(v) => (1, v.len(), v.iter().map(|b| *b as u8).collect()),
            };
            self.word(tag);
            self.count(count as u64);
            self.bytes.extend(bytes);
            self.pad();
        }
    }
}

struct Decoder<'a> {
    bytes: &'a [u8],
    at: usize,
    wide: bool,
}

impl<'a> Decoder<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }

    fn word(&mut self) -> Option<u32> {
        Some(u32::from_be_bytes(self.take(4)?.try_into().ok()?))
    }

    fn count(&mut self) -> Option<u64> {
        if self.wide {
            return Some(u64::from_be_bytes(self.take(8)?.try_into().ok()?));
        }
        self.word().map(u64::from)
    }

    fn list(&mut self, tag: u32) -> Option<u64> {
        let found = self.word()?;
        let length = self.count()?;
        (found == tag || (found == 0 && length == 0)).then_some(length)
    }

    fn padded(&mut self, count: u64) -> Option<&'a [u8]> {
        let count = usize::try_from(count).ok()?;
        let taken = self.take(count)?;
        self.take(count.checked_next_multiple_of(4)? - count)?;
        Some(taken)
    }

    fn name(&mut self) -> Option<String> {
        let length = self.count()?;
        String::from_utf8(self.padded(length)?.to_vec()).ok()
    }

    fn attributes(&mut self) -> Option<Vec<(String, Attribute)>> {
        (0..self.list(ATTRIBUTE)?).map(|_| Some((self.name()?, self.attribute()?))).collect()
    }

    fn attribute(&mut self) -> Option<Attribute> {
        let tag = self.word()?;
        let count = self.count()?;
        let size = match tag {
            1 | 2 => 1,
            4 | 5 => 4,
            6 => 8,
            _ => return None,
        };
        let bytes = self.padded(count.checked_mul(size)?)?;
        Some(match tag {
            1 => Attribute::Bytes(bytes.iter().map(|b| *b as i8).collect()),
            2 => Attribute::Text(String::from_utf8(bytes.to_vec()).ok()?),
            4 => Attribute::Int(i32::from_be_bytes(bytes.try_into().ok()?)),
            5 => Attribute::Float(f32::from_be_bytes(bytes.try_into().ok()?)),
            _ => Attribute::Double(f64::from_be_bytes(bytes.try_into().ok()?)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout() -> Layout {
        let variable = |name: &str, kind, dimensions: &[usize]| Variable {
            name: name.into(),
            kind,
            dimensions: dimensions.to_vec(),
            attributes: vec![("units".into(), "m".into()), ("_FillValue".into(), Attribute::Float(0.5))],
        };
        Layout {
            dimensions: vec![("time".into(), 0), ("node".into(), 7), ("three".into(), 3)],
            attributes: vec![("title".into(), "a wave".into()), ("n".into(), Attribute::Int(-4))],
            variables: vec![
                variable("x", Kind::Double, &[1]),
                variable("time", Kind::Double, &[0]),
                variable("flag", Kind::Byte, &[2]),
                variable("u", Kind::Float, &[0, 1]),
            ],
        }
    }

    #[test]
    fn a_header_comes_back_as_it_was() {
        let (bytes, places) = layout().encode();
        let (back, found, rows) = Layout::decode(&bytes).expect("a header");
        assert_eq!((back, found, rows), (layout(), places.clone(), 0));
        assert_eq!(places.version, 2);
        assert_eq!(places.row_bytes, 8 + 28);
        // The fixed variables first, then the rows.
        assert_eq!(places.begins[0], bytes.len() as u64);
        assert_eq!(places.begins[2], places.begins[0] + 56);
        assert_eq!(places.rows_begin, places.begins[2] + 4);
    }

    #[test]
    fn a_variable_beyond_four_gigabytes_takes_the_wide_kind() {
        let mut layout = layout();
        layout.dimensions[1].1 = 600_000_000;
        let (bytes, places) = layout.encode();
        assert_eq!((bytes[3], places.version), (5, 5));
        assert_eq!(Layout::decode(&bytes), Some((layout, places, 0)));
    }

    #[test]
    fn a_cut_or_foreign_header_is_refused() {
        let (bytes, _) = layout().encode();
        for length in 0..bytes.len() {
            assert_eq!(Layout::decode(&bytes[..length]), None, "{length} bytes");
        }
        assert_eq!(Layout::decode(b"\x89HDF\r\n\x1a\n"), None);
    }
}
