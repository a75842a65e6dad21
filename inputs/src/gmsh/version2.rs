//! Nodes and elements of MSH 2.2.

use super::cursor::Cursor;
use super::kinds::Kind;
use super::raw::{Block, Raw};
use super::version4::unknown;
use crate::error::InputError;

/// Reads a count that is a line of text in binary files too.
fn count(cursor: &mut Cursor<'_>) -> Result<u64, InputError> {
    let binary = std::mem::replace(&mut cursor.binary, false);
    let count = cursor.size()?;
    cursor.binary = binary;
    if binary {
        cursor.skip_byte(b'\r');
        cursor.skip_byte(b'\n');
    }
    Ok(count)
}

/// Tag of a node or an element: an `int` in binary files, any size in text.
fn tag(cursor: &mut Cursor<'_>) -> Result<u64, InputError> {
    if !cursor.binary {
        return cursor.size();
    }
    let tag = cursor.int()?;
    u64::try_from(tag).map_err(|_| cursor.broken(format!("expected a tag, found {tag}")))
}

/// `$Nodes`: tag and coordinates, one node after another.
pub(super) fn nodes(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), InputError> {
    let total = count(cursor)?;
    let total = cursor.fits(total, 4, 28, "nodes")?;
    raw.node_tags.reserve_exact(total);
    raw.points.reserve_exact(total);
    for _ in 0..total {
        raw.node_tags.push(tag(cursor)?);
        raw.points.push([cursor.real()?, cursor.real()?, cursor.real()?]);
    }
    Ok(())
}

/// `$Elements`: in text type and tags for each element, in binary for runs of them.
pub(super) fn elements(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), InputError> {
    let total = count(cursor)?;
    let total = cursor.fits(total, 4, 8, "elements")?;
    let mut found = 0;
    while found < total {
        let (element, number, run, tags);
        if cursor.binary {
            (number, run, tags) = (cursor.int()?, cursor.int()?, cursor.int()?);
            element = None;
        } else {
            element = Some(tag(cursor)?);
            (number, run, tags) = (cursor.int()?, 1, cursor.int()?);
        }
        let Some(kind) = Kind::numbered(number) else {
            return Err(unknown(cursor, number));
        };
        let (Ok(run), Ok(tags)) = (u64::try_from(run), u64::try_from(tags)) else {
            return Err(cursor.broken("expected a number of elements and of tags, found a negative one"));
        };
        let per_element = tags + u64::from(kind.nodes);
        let run = cursor.fits(run, per_element, 4 * (1 + per_element), "elements with their tags")?;
        if run == 0 || found + run > total {
            return Err(cursor.broken(format!("{run} elements in a run, {} are left", total - found)));
        }
        for _ in 0..run {
            let element = match element {
                Some(element) => element,
                None => tag(cursor)?,
            };
            one(cursor, kind, element, tags, raw)?;
        }
        found += run;
    }
    Ok(())
}

/// Tags and nodes of one element. Its first tag is its physical group, 0 for none; the second the
/// entity, the others partitions.
fn one(
    cursor: &mut Cursor<'_>,
    kind: Kind,
    element: u64,
    tags: u64,
    raw: &mut Raw,
) -> Result<(), InputError> {
    let mut group = 0;
    for index in 0..tags {
        let value = cursor.int()?;
        if index == 0 {
            group = value.abs();
        }
    }
    let groups: &[i64] = if group == 0 { &[] } else { &[group] };
    let fits = |block: &Block| block.kind == kind && block.groups == groups;
    if !raw.blocks.last().is_some_and(fits) {
        raw.blocks.push(Block { kind, groups: groups.to_vec(), tags: Vec::new(), nodes: Vec::new() });
    }
    let block = raw.blocks.last_mut().expect("pushed just now");
    block.tags.push(element);
    for _ in 0..kind.nodes {
        block.nodes.push(tag(cursor)?);
    }
    Ok(())
}
