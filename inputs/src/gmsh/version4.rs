//! Entities, nodes and elements of MSH 4.1.

use std::collections::HashMap;

use super::cursor::{Cursor, shown};
use super::kinds::Kind;
use super::raw::{Block, Raw};
use crate::error::InputError;

/// Physical groups of every entity, by its dimension and tag.
#[derive(Default)]
pub(super) struct Entities(HashMap<(u8, i64), Vec<i64>>);

/// `$Entities`: the corners, bounds and neighbours of the geometry are passed over.
pub(super) fn entities(cursor: &mut Cursor<'_>) -> Result<Entities, InputError> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = cursor.size()?;
    }
    let mut entities = Entities::default();
    for (dimension, count) in (0_u8..).zip(counts) {
        // A point has a tag, three coordinates and the number of its groups; the others, a box of six
        // and one more number.
        let (reals, bounded) = if dimension == 0 { (3, false) } else { (6, true) };
        let words = 2 + reals + u64::from(bounded);
        let bytes = 4 + 8 * (reals + 1 + u64::from(bounded));
        let count = cursor.fits(count, words, bytes, "entities")?;
        for _ in 0..count {
            let tag = cursor.int()?;
            for _ in 0..reals {
                cursor.real()?;
            }
            let groups = tags(cursor)?;
            if bounded {
                tags(cursor)?;
            }
            // A negative tag turns the group's normal, nothing else.
            let mut groups: Vec<i64> = groups.into_iter().map(i64::abs).collect();
            groups.sort_unstable();
            groups.dedup();
            entities.0.insert((dimension, tag), groups);
        }
    }
    Ok(entities)
}

/// A count and as many `int`s.
fn tags(cursor: &mut Cursor<'_>) -> Result<Vec<i64>, InputError> {
    let count = cursor.size()?;
    let count = cursor.fits(count, 1, 4, "tags of an entity")?;
    (0..count).map(|_| cursor.int()).collect()
}

/// `$Nodes`: in each block first the tags, then the coordinates.
pub(super) fn nodes(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), InputError> {
    let (blocks, total) = (cursor.size()?, cursor.size()?);
    let (_smallest, _largest) = (cursor.size()?, cursor.size()?);
    let total = cursor.fits(total, 4, 32, "nodes")?;
    let blocks = cursor.fits(blocks, 4, 20, "blocks of nodes")?;
    raw.node_tags.reserve_exact(total);
    raw.points.reserve_exact(total);
    for _ in 0..blocks {
        let (dimension, _entity, parametric) = (cursor.int()?, cursor.int()?, cursor.int()?);
        // Places on the curve or surface follow the coordinates and are passed over.
        let parameters = match (parametric, dimension) {
            (0, _) => 0,
            (1, 0..=3) => dimension as u64,
            _ => return Err(cursor.broken("expected parametric 0 or 1 and a dimension of 0 to 3")),
        };
        let count = cursor.size()?;
        let count = cursor.fits(count, 4 + parameters, 8 * (4 + parameters), "nodes of a block")?;
        if raw.node_tags.len() + count > total {
            return Err(cursor.broken(format!("more nodes in the blocks than the {total} announced")));
        }
        for _ in 0..count {
            raw.node_tags.push(cursor.size()?);
        }
        for _ in 0..count {
            raw.points.push([cursor.real()?, cursor.real()?, cursor.real()?]);
            for _ in 0..parameters {
                cursor.real()?;
            }
        }
    }
    if raw.points.len() != total {
        return Err(cursor.broken(format!("{total} nodes announced, {} found", raw.points.len())));
    }
    Ok(())
}

/// `$Elements`: blocks of one type on one entity.
pub(super) fn elements(
    cursor: &mut Cursor<'_>,
    entities: &Entities,
    raw: &mut Raw,
) -> Result<(), InputError> {
    let (blocks, total) = (cursor.size()?, cursor.size()?);
    let (_smallest, _largest) = (cursor.size()?, cursor.size()?);
    let total = cursor.fits(total, 2, 16, "elements")?;
    let blocks = cursor.fits(blocks, 4, 20, "blocks of elements")?;
    let mut found = 0;
    for _ in 0..blocks {
        let (dimension, entity, number) = (cursor.int()?, cursor.int()?, cursor.int()?);
        let count = cursor.size()?;
        let Some(kind) = Kind::numbered(number) else {
            return Err(unknown(cursor, number));
        };
        if i64::from(kind.dimension()) != dimension {
            return Err(cursor.broken(format!("{} on an entity of dimension {dimension}", kind.name())));
        }
        let per_element = 1 + u64::from(kind.nodes);
        let count = cursor.fits(count, per_element, 8 * per_element, "elements of a block")?;
        found += count;
        if found > total {
            return Err(cursor.broken(format!("more elements in the blocks than the {total} announced")));
        }
        let groups = entities.0.get(&(kind.dimension(), entity)).cloned().unwrap_or_default();
        let mut block = Block {
            kind,
            groups,
            tags: Vec::with_capacity(count),
            nodes: Vec::with_capacity(count * usize::from(kind.nodes)),
        };
        for _ in 0..count {
            block.tags.push(cursor.size()?);
            for _ in 0..kind.nodes {
                block.nodes.push(cursor.size()?);
            }
        }
        raw.blocks.push(block);
    }
    if found != total {
        return Err(cursor.broken(format!("{total} elements announced, {found} found")));
    }
    Ok(())
}

/// A type that is not in Gmsh's documentation, or of an order that nobody uses.
pub(super) fn unknown(cursor: &Cursor<'_>, number: i64) -> InputError {
    let number = shown(number.to_string().as_bytes());
    cursor.broken(format!(
        "element type {number} is not known; quadrilaterals and hexahedra of order 1 or 2 are 3, 10, 5, 12"
    ))
}
