//! From the content of a file to a mesh: what is ground, what is boundary, and whether it is sound.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::GmshMesh;
use super::fault::MeshFault;
use super::geometry::{Orientation, orientation};
use super::kinds::{Family, Kind};
use super::raw::{Block, Raw};
use super::section::{Section, section};
use super::sections::refused;
use super::sides::{Ground, Misfit, Sides};
use crate::error::InputError;

/// Where the nodes of the file are.
struct Places {
    /// Dense table by tag, where tags are dense enough.
    dense: Vec<u32>,
    sparse: HashMap<u64, u32>,
}

/// A tag without a node in [`Places::dense`].
const NOWHERE: u32 = u32::MAX;

impl Places {
    fn new(path: &Path, raw: &Raw) -> Result<Self, InputError> {
        let largest = raw.node_tags.iter().copied().max().unwrap_or(0);
        let room = 4 * raw.node_tags.len() as u64 + 1000;
        let mut places = Self { dense: Vec::new(), sparse: HashMap::new() };
        if largest < room {
            places.dense = vec![NOWHERE; largest as usize + 1];
        }
        for (index, &tag) in (0_u32..).zip(&raw.node_tags) {
            let before = match places.dense.get_mut(tag as usize) {
                Some(slot) => std::mem::replace(slot, index),
                None => places.sparse.insert(tag, index).unwrap_or(NOWHERE),
            };
            if before != NOWHERE {
                return Err(broken(path, format!("node {tag}"), "is given twice"));
            }
        }
        Ok(places)
    }

    fn of(&self, tag: u64) -> Option<u32> {
        let dense = usize::try_from(tag).ok().and_then(|tag| self.dense.get(tag));
        let index = dense.copied().or_else(|| self.sparse.get(&tag).copied());
        index.filter(|index| *index != NOWHERE)
    }
}

pub(super) fn broken(path: &Path, place: String, problem: &str) -> InputError {
    InputError::MeshBroken { path: path.to_path_buf(), place, problem: problem.into() }
}

/// What the checks speak of: the file, its content, and where its nodes are.
pub(super) struct Content<'a> {
    pub(super) path: &'a Path,
    pub(super) raw: &'a Raw,
    places: Places,
    /// D.
    dimension: u8,
}

impl Content<'_> {
    /// A refusal of one element, the first of `count` with the same fault.
    fn refuse(&self, block: &Block, index: usize, count: usize, fault: MeshFault) -> InputError {
        let mut centre = [0.0; 3];
        let corners = &block.element(index)[..block.kind.corners()];
        for tag in corners {
            let place = self.places.of(*tag).map_or([f64::NAN; 3], |node| self.raw.points[node as usize]);
            (0..3).for_each(|c| centre[c] += place[c] / corners.len() as f64);
        }
        InputError::MeshElement {
            path: self.path.to_path_buf(),
            tag: block.tags[index],
            centre,
            fault: Box::new(fault),
            others: count.saturating_sub(1),
        }
    }

    /// Index of a node that an element names.
    fn node(&self, block: &Block, index: usize, tag: u64) -> Result<u32, InputError> {
        self.places.of(tag).ok_or_else(|| {
            let problem = format!("names node {tag}, which $Nodes does not have");
            broken(self.path, format!("element {}", block.tags[index]), &problem)
        })
    }

    /// The blocks of one dimension.
    fn blocks(&self, dimension: u8) -> impl Iterator<Item = &Block> {
        self.raw.blocks.iter().filter(move |block| block.kind.dimension() == dimension && block.len() > 0)
    }

    /// Every element of the ground with its block and its place therein, in the file's order.
    fn ground(&self) -> impl Iterator<Item = (&Block, usize)> {
        self.blocks(self.dimension).flat_map(|block| (0..block.len()).map(move |index| (block, index)))
    }

    /// Refuses the ground's first element that has a fault, with the number of all that have a like one.
    fn every_block(&self, fault: impl Fn(&Block) -> Option<MeshFault>) -> Result<(), InputError> {
        let mut faults = self.blocks(self.dimension).filter_map(|block| Some((block, fault(block)?)));
        let Some((block, first)) = faults.next() else { return Ok(()) };
        let like = |other: &MeshFault| std::mem::discriminant(other) == std::mem::discriminant(&first);
        let others: usize = faults.filter(|(_, fault)| like(fault)).map(|(block, _)| block.len()).sum();
        Err(self.refuse(block, 0, block.len() + others, first))
    }

    /// The one type of the ground's elements.
    fn kind(&self) -> Result<Kind, InputError> {
        let (family, expected) = match self.dimension {
            2 => (Family::Quadrilateral, "quadrilaterals"),
            _ => (Family::Hexahedron, "hexahedra"),
        };
        self.every_block(|block| {
            let kind = block.kind;
            (kind.family != family).then(|| MeshFault::Shape { kind: kind.name(), expected })
        })?;
        self.every_block(|block| {
            let kind = block.kind;
            let bad = !(1..=2).contains(&kind.order);
            bad.then(|| MeshFault::Order { kind: kind.name(), order: kind.order })
        })?;
        self.every_block(|block| {
            let kind = block.kind;
            (!kind.is_tensor_product()).then(|| MeshFault::Serendipity { kind: kind.name() })
        })?;
        let first = self.blocks(self.dimension).next().map(|block| block.kind).expect("D has elements");
        self.every_block(|block| {
            let (kind, first) = (block.kind, first);
            (kind != first).then(|| MeshFault::MixedOrders { kind: kind.name(), first: first.name() })
        })?;
        Ok(first)
    }

    /// The name of a group, if it has one.
    fn name(&self, dimension: u8, group: i64) -> Option<&str> {
        self.raw.names.get(&(dimension, group)).map(String::as_str).filter(|name| !name.is_empty())
    }

    /// Material of every element and the names, in the order of the groups' tags.
    fn materials(&self) -> Result<(Vec<u32>, Vec<String>), InputError> {
        let dimension = self.dimension;
        if self.blocks(dimension).all(|block| block.groups.is_empty()) {
            return Err(no_groups(self.path, dimension));
        }
        self.every_block(|block| block.groups.is_empty().then_some(MeshFault::NoGroup))?;
        self.every_block(|block| {
            let unnamed = block.groups.iter().find(|group| self.name(dimension, **group).is_none());
            unnamed.map(|&group| MeshFault::UnnamedGroup { dimension, group })
        })?;
        let names = |block: &Block| -> Vec<String> {
            let names = block.groups.iter().filter_map(|&group| self.name(dimension, group));
            let mut names: Vec<String> = names.map(String::from).collect();
            names.dedup();
            names
        };
        self.every_block(|block| {
            let names = names(block);
            (names.len() > 1).then(|| MeshFault::SeveralMaterials { names: names.join(", ") })
        })?;
        let mut order: Vec<i64> = self.blocks(dimension).map(|block| block.groups[0]).collect();
        order.sort_unstable();
        let mut materials: Vec<String> = Vec::new();
        for group in order {
            let name = self.name(dimension, group).expect("looked at above");
            if !materials.iter().any(|known| known == name) {
                materials.push(name.to_string());
            }
        }
        let mut material = Vec::new();
        for block in self.blocks(dimension) {
            let name = self.name(dimension, block.groups[0]).expect("looked at above");
            let index = materials.iter().position(|known| known == name).expect("pushed above") as u32;
            material.resize(material.len() + block.len(), index);
        }
        Ok((material, materials))
    }

    /// Nodes of the ground's elements in tensor order, by their place in the file; and which are used.
    fn elements(&self, kind: Kind) -> Result<(Vec<u32>, Vec<bool>), InputError> {
        let order = kind.tensor_order().expect("order 1 or 2 and complete");
        let count: usize = self.blocks(self.dimension).map(Block::len).sum();
        let mut elements = Vec::with_capacity(count * order.len());
        let mut used = vec![false; self.raw.points.len()];
        for (block, index) in self.ground() {
            let tags = block.element(index);
            for &place in order {
                let node = self.node(block, index, tags[usize::from(place)])?;
                elements.push(node);
                used[node as usize] = true;
            }
        }
        Ok((elements, used))
    }

    /// New numbers for the nodes that are used, in the file's order.
    fn used(&self, used: &[bool]) -> Result<Used, InputError> {
        let mut kept = Used { new: vec![NOWHERE; used.len()], nodes: Vec::new(), tags: Vec::new() };
        for (index, _) in used.iter().enumerate().filter(|(_, used)| **used) {
            let (place, tag) = (self.raw.points[index], self.raw.node_tags[index]);
            if !place.iter().all(|c| c.is_finite()) {
                let problem = format!("its coordinates are {}", super::fault::point(place));
                return Err(broken(self.path, format!("node {tag}"), &problem));
            }
            kept.new[index] = kept.nodes.len() as u32;
            kept.nodes.push(place);
            kept.tags.push(tag);
        }
        Ok(kept)
    }

    /// Turns clockwise quadrilaterals; refuses what is folded, collapsed or inside out.
    fn orient(&self, order: usize, nodes: &[[f64; 3]], elements: &mut [u32]) -> Result<usize, InputError> {
        let dimension = usize::from(self.dimension);
        let per_element = (order + 1).pow(dimension as u32);
        let (mut turned, mut first, mut bad) = (0, None, 0);
        for (element, (block, index)) in elements.chunks_exact_mut(per_element).zip(self.ground()) {
            let mut places = [[0.0; 3]; 27];
            for (place, node) in places.iter_mut().zip(&*element) {
                *place = nodes[*node as usize];
            }
            let fault = match orientation(dimension, order, &places[..per_element]) {
                Orientation::Right => continue,
                Orientation::Left if dimension == 2 => {
                    swap_axes(order, element);
                    turned += 1;
                    continue;
                }
                Orientation::Left => MeshFault::Inverted,
                Orientation::Bad(value, at) => MeshFault::Jacobian { value, at },
            };
            bad += 1;
            first.get_or_insert((block, index, fault));
        }
        match first {
            Some((block, index, fault)) => Err(self.refuse(block, index, bad, fault)),
            None => Ok(turned),
        }
    }

    /// The refusal of parts that do not fit; `tags` are those of the nodes that are used.
    fn misfit(&self, misfit: &Misfit, tags: &[u64]) -> InputError {
        let place = |node: u32| self.places.of(tags[node as usize]).expect("tags of nodes that are there");
        let at = |node: u32| self.raw.points[place(node) as usize];
        let element = |wanted: u32| self.ground().nth(wanted as usize).expect("an element of the ground");
        let tag = |node: u32| tags[node as usize];
        let (found, fault) = match *misfit {
            Misfit::Overlap { element: found, other } => {
                let (block, index) = element(other);
                (found, MeshFault::Overlap { other: block.tags[index] })
            }
            Misfit::Duplicate { element, node, other } => {
                (element, MeshFault::DuplicateNodes { node: tag(node), other: tag(other), at: at(node) })
            }
            Misfit::Hanging { element, node } => {
                (element, MeshFault::HangingNode { node: tag(node), at: at(node) })
            }
        };
        let (block, index) = element(found);
        self.refuse(block, index, 1, fault)
    }

    /// Sides of every named group of dimension D − 1, and how many of them lie inside the ground.
    fn boundaries(&self, new: &[u32], sides: &Sides) -> Result<(Boundaries, usize), InputError> {
        let dimension = self.dimension - 1;
        let mut groups: BTreeMap<i64, Vec<(u32, u8)>> = BTreeMap::new();
        let mut inside = 0;
        for block in self.blocks(dimension).filter(|block| !block.groups.is_empty()) {
            if let Some(&group) = block.groups.iter().find(|group| self.name(dimension, **group).is_none()) {
                return Err(self.refuse(block, 0, block.len(), MeshFault::UnnamedGroup { dimension, group }));
            }
            for index in 0..block.len() {
                let mut corners = Vec::with_capacity(4);
                for &tag in &block.element(index)[..block.kind.corners()] {
                    corners.push(new[self.node(block, index, tag)? as usize]);
                }
                let fits = matches!(block.kind.family, Family::Line | Family::Quadrilateral);
                let mut found = sides.with(&corners).filter(|_| fits && !corners.contains(&NOWHERE));
                let Some(side) = found.next() else {
                    let boundary = self.name(dimension, block.groups[0]).expect("looked at above").into();
                    let fault = MeshFault::OffSide { boundary, kind: block.kind.name() };
                    return Err(self.refuse(block, index, 1, fault));
                };
                inside += found.count();
                for group in &block.groups {
                    groups.entry(*group).or_default().push(side);
                }
            }
        }
        let mut named: Boundaries = Vec::new();
        for (group, sides) in groups {
            let name = self.name(dimension, group).expect("looked at above");
            match named.iter_mut().find(|(known, _)| known == name) {
                Some((_, all)) => all.extend(sides),
                None => named.push((name.to_string(), sides)),
            }
        }
        for (_, sides) in &mut named {
            sides.sort_unstable();
            sides.dedup();
        }
        Ok((named, inside))
    }
}

/// The nodes of the ground.
struct Used {
    /// By a node's place in the file, its number; [`NOWHERE`] if it has none.
    new: Vec<u32>,
    /// Their places.
    nodes: Vec<[f64; 3]>,
    /// Their tags.
    tags: Vec<u64>,
}

type Boundaries = Vec<(String, Vec<(u32, u8)>)>;

/// Exchanges the two local axes of a quadrilateral.
fn swap_axes(order: usize, element: &mut [u32]) {
    let n = order + 1;
    for i in 0..n {
        for j in 0..i {
            element.swap(i + n * j, j + n * i);
        }
    }
}

fn no_groups(path: &Path, dimension: u8) -> InputError {
    let (part, what) = if dimension == 2 { ("surface", "Surface") } else { ("volume", "Volume") };
    refused(
        path,
        format!("no {part} belongs to a physical group, so nothing says which material it is"),
        format!("put every {part} into a named group: Physical {what}(\"clay\") = {{1}};"),
    )
}

/// D: 3 with any element of a volume, else 2 with any of a surface.
fn dimension(path: &Path, raw: &Raw) -> Result<u8, InputError> {
    let has = |d: u8| raw.blocks.iter().any(|block| block.kind.dimension() == d && block.len() > 0);
    if has(3) {
        Ok(3)
    } else if has(2) {
        Ok(2)
    } else {
        Err(refused(
            path,
            "holds no elements of a surface or volume",
            "mesh it: gmsh -3 (a volume) or gmsh -2 (a section); with physical groups Gmsh writes these alone, so name the volumes too",
        ))
    }
}

/// Puts a mesh together and checks it.
pub(super) fn assemble(path: &Path, raw: &Raw, sha256: String) -> Result<GmshMesh, InputError> {
    let dimension = dimension(path, raw)?;
    let ground: usize = raw.blocks.iter().map(Block::len).sum();
    if raw.points.len() >= NOWHERE as usize || ground >= NOWHERE as usize {
        return Err(refused(path, "has more than 4 thousand million nodes or elements", "mesh it coarser"));
    }
    let content = Content { path, raw, places: Places::new(path, raw)?, dimension };
    let kind = content.kind()?;
    let (material, materials) = content.materials()?;
    let (mut elements, used) = content.elements(kind)?;
    let mut notes = Vec::new();

    let Used { new, mut nodes, tags: node_tags } = content.used(&used)?;
    elements.iter_mut().for_each(|node| *node = new[*node as usize]);
    if nodes.len() < raw.points.len() {
        notes.push(format!("{} nodes belong to no element and are left out", raw.points.len() - nodes.len()));
    }
    let order = usize::from(kind.order);
    if dimension == 2 && section(path, order, &elements, &mut nodes)? == Section::FromXy {
        notes.push("the plane x–y of the file is the section x–z: its y is up".into());
    }
    let turned = content.orient(order, &nodes, &mut elements)?;
    if turned > 0 {
        notes.push(format!("{turned} clockwise quadrilaterals were turned"));
    }
    let ground = Ground { dimension: usize::from(dimension), order, nodes: &nodes, elements: &elements };
    let sides = ground.sides();
    if let Some(misfit) = ground.misfits(&sides) {
        return Err(content.misfit(&misfit, &node_tags));
    }
    let (boundaries, inside) = content.boundaries(&new, &sides)?;
    for ((lower, _), name) in raw.names.iter().filter(|((lower, _), _)| lower + 1 < dimension) {
        notes
            .push(format!("group \"{name}\" has dimension {lower}: it bounds no element and is passed over"));
    }
    if inside > 0 {
        notes.push(format!(
            "{inside} sides of boundaries lie between two elements; each is given as that of the element with the lower number"
        ));
    }
    let tags = content.ground().map(|(block, index)| block.tags[index]).collect();
    Ok(GmshMesh {
        dimension: usize::from(dimension),
        order,
        nodes,
        elements,
        material,
        materials,
        boundaries,
        tags,
        notes,
        sha256,
    })
}
