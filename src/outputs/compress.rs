//! From the file that grew by rows to compressed NetCDF-4.

use netcdf::{Extent, FileMut, Options};

use super::OutputError;
use super::classic::{Attribute, ClassicFile, Kind, Layout, Variable, aside};
use super::error::expect_room;

/// Values of a chunk along the points at most: 256 KiB of f32.
const CHUNK_POINTS: usize = 1 << 16;
/// Values of a chunk at most: 1 MiB of f32.
const CHUNK_VALUES: usize = 1 << 18;
/// Rows of a chunk at most, so that one instant of a small field is not all of it.
const CHUNK_ROWS: usize = 64;

/// Writes the content of a classic file as NetCDF-4 (deflate 1, shuffle, chunks of some rows) and puts it
/// in its place.
///
/// It is made aside and renamed, so that the name always holds a whole file.
///
/// # Errors
/// No room for the copy, a fault of the library; the classic file is then still in place.
pub(super) fn compress(mut from: ClassicFile) -> Result<(), OutputError> {
    let path = from.path().to_path_buf();
    let aside = aside(&path);
    let outcome = copy(&mut from, &aside).and_then(|()| {
        let flushed = std::fs::File::open(&aside).and_then(|file| file.sync_all());
        flushed
            .and_then(|()| std::fs::rename(&aside, &path))
            .map_err(|cause| OutputError::from_io(&path, cause))
    });
    if outcome.is_err() {
        let _ = std::fs::remove_file(&aside);
    }
    outcome
}

fn copy(from: &mut ClassicFile, aside: &std::path::Path) -> Result<(), OutputError> {
    let path = from.path().to_path_buf();
    let layout = from.layout().clone();
    let rows = from.rows();
    let failed = |action: String| {
        let path = path.clone();
        move |cause| OutputError::from_netcdf(&path, action, cause)
    };
    let _ = std::fs::remove_file(aside);
    let mut to =
        netcdf::create_with(aside, Options::NETCDF4).map_err(failed("create the compressed file".into()))?;
    define(&mut to, &layout).map_err(failed("define the compressed file".into()))?;
    let mut bytes = vec![];
    for (index, variable) in layout.variables.iter().enumerate() {
        let action = || format!("write variable {}", variable.name);
        let growing = layout.is_row(variable);
        let step = chunk(&layout, variable).first().copied().filter(|_| growing).unwrap_or(1);
        let mut first = 0;
        while first < if growing { rows } else { 1 } {
            let count = if growing { step.min(rows - first) } else { 1 };
            bytes.clear();
            (first..first + count).try_for_each(|row| from.read(index, row, &mut bytes))?;
            expect_room(&path, bytes.len() as u64)?;
            put(&mut to, &layout, variable, first..first + count, &bytes).map_err(failed(action()))?;
            first += count;
        }
    }
    to.close().map_err(failed("close the compressed file".into()))
}

/// Shape of a variable's chunks; empty for one that does not grow.
fn chunk(layout: &Layout, variable: &Variable) -> Vec<usize> {
    if !layout.is_row(variable) {
        return vec![];
    }
    let mut shape: Vec<usize> = variable.dimensions[1..].iter().map(|&d| layout.dimensions[d].1).collect();
    if shape.is_empty() {
        return vec![1024];
    }
    // The slow axes give way first: neighbours along x stay together.
    for axis in 0..shape.len() {
        let others: usize = shape.iter().product::<usize>() / shape[axis].max(1);
        shape[axis] = shape[axis].min((CHUNK_POINTS / others.max(1)).max(1)).max(1);
    }
    let points: usize = shape.iter().product();
    shape.insert(0, (CHUNK_VALUES / points).clamp(1, CHUNK_ROWS));
    shape
}

fn define(to: &mut FileMut, layout: &Layout) -> netcdf::Result<()> {
    for (name, length) in &layout.dimensions {
        to.add_dimension(name, *length)?;
    }
    for (name, value) in &layout.attributes {
        match value.clone() {
            Attribute::Text(v) => to.add_attribute(name, v)?,
            Attribute::Int(v) => to.add_attribute(name, v)?,
            Attribute::Double(v) => to.add_attribute(name, v)?,
            Attribute::Float(v) => to.add_attribute(name, v)?,
            Attribute::Bytes(v) => to.add_attribute(name, v)?,
        };
    }
    layout.variables.iter().try_for_each(|variable| define_variable(to, layout, variable))
}

fn define_variable(to: &mut FileMut, layout: &Layout, from: &Variable) -> netcdf::Result<()> {
    let dimensions: Vec<&str> = from.dimensions.iter().map(|&d| layout.dimensions[d].0.as_str()).collect();
    let mut variable = match from.kind {
        Kind::Byte => to.add_variable::<i8>(&from.name, &dimensions)?,
        // A classic file has texts as rows of letters, NetCDF-4 as they are.
        Kind::Char => to.add_string_variable(&from.name, &dimensions[..dimensions.len() - 1])?,
        Kind::Int => to.add_variable::<i32>(&from.name, &dimensions)?,
        Kind::Float => to.add_variable::<f32>(&from.name, &dimensions)?,
        Kind::Double => to.add_variable::<f64>(&from.name, &dimensions)?,
    };
    let chunk = chunk(layout, from);
    if !chunk.is_empty() {
        variable.set_chunking(&chunk)?;
    }
    // An index along time gains nothing, a scalar cannot be.
    let packable = from.dimensions.len() > 1 || (!layout.is_row(from) && from.dimensions.len() == 1);
    if packable && from.kind != Kind::Char {
        variable.set_compression(1, true)?;
    }
    for (name, value) in &from.attributes {
        match value.clone() {
            Attribute::Float(v) if name == "_FillValue" => {
                variable.set_fill_value(v)?;
                continue;
            }
            Attribute::Text(v) => variable.put_attribute(name, v)?,
            Attribute::Int(v) => variable.put_attribute(name, v)?,
            Attribute::Double(v) => variable.put_attribute(name, v)?,
            Attribute::Float(v) => variable.put_attribute(name, v)?,
            Attribute::Bytes(v) => variable.put_attribute(name, v)?,
        };
    }
    Ok(())
}

/// Writes big-endian bytes of some rows, or of all of a variable that does not grow.
fn put(
    to: &mut FileMut,
    layout: &Layout,
    from: &Variable,
    rows: std::ops::Range<usize>,
    bytes: &[u8],
) -> netcdf::Result<()> {
    let whole = |&d: &usize| Extent::from(0..layout.dimensions[d].1);
    let mut extents: Vec<Extent> = from.dimensions.iter().map(whole).collect();
    if layout.is_row(from) {
        extents[0] = Extent::from(rows);
    }
    let Some(mut variable) = to.variable_mut(&from.name) else {
        return Err(netcdf::Error::NotFound(format!("variable {}", from.name)));
    };
    match from.kind {
        Kind::Byte => variable.put_values(&values(bytes, i8::from_be_bytes), extents),
        Kind::Char => put_texts(&mut variable, bytes),
        Kind::Int => variable.put_values(&values(bytes, i32::from_be_bytes), extents),
        Kind::Float => variable.put_values(&values(bytes, f32::from_be_bytes), extents),
        Kind::Double => variable.put_values(&values(bytes, f64::from_be_bytes), extents),
    }
}

/// Writes rows of letters, filled up with NUL, as texts.
fn put_texts(to: &mut netcdf::VariableMut<'_>, bytes: &[u8]) -> netcdf::Result<()> {
    let count = to.len().max(1);
    for (index, letters) in bytes.chunks_exact(bytes.len() / count).enumerate() {
        let text = String::from_utf8_lossy(letters);
        to.put_string(text.trim_end_matches('\0'), index)?;
    }
    Ok(())
}

fn values<T, const N: usize>(bytes: &[u8], of: fn([u8; N]) -> T) -> Vec<T> {
    let (chunks, _) = bytes.as_chunks::<N>();
    chunks.iter().map(|chunk| of(*chunk)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_hold_a_megabyte_at_most() {
        let shape = |lengths: &[usize]| {
            let named = lengths.iter().map(|&n| (format!("d{n}"), n));
            let layout = Layout {
                dimensions: std::iter::once(("time".to_owned(), 0)).chain(named).collect(),
                ..Layout::default()
            };
            let dimensions = (0..=lengths.len()).collect();
            let variable = Variable { name: "u".into(), kind: Kind::Float, dimensions, attributes: vec![] };
            chunk(&layout, &variable)
        };
        assert_eq!(shape(&[]), [1024]);
        assert_eq!(shape(&[100]), [64, 100]);
        assert_eq!(shape(&[16_641]), [15, 16_641]);
        assert_eq!(shape(&[5_000_000]), [4, 65_536]);
        assert_eq!(shape(&[50, 200, 300]), [4, 1, 200, 300]);
        assert_eq!(shape(&[3, 70_000, 2]), [4, 1, 32_768, 2]);
    }
}
