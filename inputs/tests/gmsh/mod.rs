//! What the tests of meshes share: the files in git, small meshes written here, and their measures.
#![allow(dead_code, unreachable_pub)]

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use hati_inputs::InputError;
use hati_inputs::gmsh::{GmshMesh, MeshFault, read};

/// A file of `tests/data/gmsh`, made by `python/make_fixtures_gmsh.py`.
pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gmsh").join(name)
}

/// A mesh file in the making: MSH 2.2 text.
#[derive(Clone, Default)]
pub struct Draft {
    pub names: Vec<(u8, i64, &'static str)>,
    pub nodes: Vec<(u64, [f64; 3])>,
    /// Tag, type, physical group (0: none), nodes in Gmsh's order.
    pub elements: Vec<(u64, u16, i64, Vec<u64>)>,
}

impl Draft {
    /// `columns` by `rows` unit squares in the plane x–y from a corner on; tags from `first` on.
    pub fn squares(mut self, corner: [f64; 2], columns: u64, rows: u64, size: f64, first: u64) -> Self {
        let tag = |i: u64, j: u64| first + i + j * (columns + 1);
        for j in 0..=rows {
            for i in 0..=columns {
                let place = [corner[0] + size * i as f64, corner[1] + size * j as f64, 0.0];
                self.nodes.push((tag(i, j), place));
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let nodes = vec![tag(i, j), tag(i + 1, j), tag(i + 1, j + 1), tag(i, j + 1)];
                self.elements.push((first + 1000 + i + j * columns, 3, 1, nodes));
            }
        }
        self
    }

    /// `n[0]` by `n[1]` by `n[2]` cubes from a corner on; tags from `first` on.
    pub fn cubes(mut self, corner: [f64; 3], n: [u64; 3], size: f64, first: u64) -> Self {
        let tag = |i: u64, j: u64, k: u64| first + i + (n[0] + 1) * (j + (n[1] + 1) * k);
        for k in 0..=n[2] {
            for j in 0..=n[1] {
                for i in 0..=n[0] {
                    let place = [i, j, k].map(|index| size * index as f64);
                    self.nodes.push((tag(i, j, k), [0, 1, 2].map(|c| corner[c] + place[c])));
                }
            }
        }
        for k in 0..n[2] {
            for j in 0..n[1] {
                for i in 0..n[0] {
                    let layer = |k| [tag(i, j, k), tag(i + 1, j, k), tag(i + 1, j + 1, k), tag(i, j + 1, k)];
                    let nodes = [layer(k), layer(k + 1)].concat();
                    self.elements.push((first + 1000 + i + n[0] * (j + n[1] * k), 5, 1, nodes));
                }
            }
        }
        self
    }

    /// Names group 1 of the elements of this dimension.
    pub fn soil(mut self, dimension: u8) -> Self {
        self.names.push((dimension, 1, "soil"));
        self
    }

    pub fn name(mut self, dimension: u8, group: i64, name: &'static str) -> Self {
        self.names.push((dimension, group, name));
        self
    }

    pub fn element(mut self, tag: u64, kind: u16, group: i64, nodes: &[u64]) -> Self {
        self.elements.push((tag, kind, group, nodes.to_vec()));
        self
    }

    pub fn node(mut self, tag: u64, place: [f64; 3]) -> Self {
        self.nodes.push((tag, place));
        self
    }

    /// Adds the nodes and elements of another.
    pub fn with(mut self, other: Self) -> Self {
        self.nodes.extend(other.nodes);
        self.elements.extend(other.elements);
        self
    }

    /// Lets one node stand for another, which goes.
    pub fn join(mut self, kept: u64, gone: u64) -> Self {
        self.nodes.retain(|(tag, _)| *tag != gone);
        for (.., nodes) in &mut self.elements {
            nodes.iter_mut().filter(|node| **node == gone).for_each(|node| *node = kept);
        }
        self
    }

    /// Joins every pair of nodes in one place.
    pub fn joined(mut self) -> Self {
        let mut index = 0;
        while index < self.nodes.len() {
            let (tag, place) = self.nodes[index];
            let near = |other: [f64; 3]| (0..3).all(|c| (place[c] - other[c]).abs() < 1e-9);
            let twin = self.nodes[index + 1..].iter().find(|(_, other)| near(*other)).map(|(tag, _)| *tag);
            match twin {
                Some(twin) => self = self.join(tag, twin),
                None => index += 1,
            }
        }
        self
    }

    /// Moves every node.
    pub fn moved(mut self, to: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        self.nodes.iter_mut().for_each(|(_, place)| *place = to(*place));
        self
    }

    pub fn text(&self) -> String {
        let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
        let _ = writeln!(text, "$PhysicalNames\n{}", self.names.len());
        for (dimension, tag, name) in &self.names {
            let _ = writeln!(text, "{dimension} {tag} \"{name}\"");
        }
        let _ = writeln!(text, "$EndPhysicalNames\n$Nodes\n{}", self.nodes.len());
        for (tag, [x, y, z]) in &self.nodes {
            let _ = writeln!(text, "{tag} {x} {y} {z}");
        }
        let _ = writeln!(text, "$EndNodes\n$Elements\n{}", self.elements.len());
        for (tag, kind, group, nodes) in &self.elements {
            let nodes: Vec<String> = nodes.iter().map(u64::to_string).collect();
            let _ = writeln!(text, "{tag} {kind} 2 {group} 1 {}", nodes.join(" "));
        }
        text + "$EndElements\n"
    }

    pub fn read(&self) -> Result<GmshMesh, InputError> {
        read_bytes(self.text().as_bytes())
    }

    /// Tag, centre and fault of the element that is refused.
    pub fn fault(&self) -> (u64, [f64; 3], MeshFault) {
        fault(self.read())
    }
}

/// Reads a file of these bytes.
pub fn read_bytes(bytes: &[u8]) -> Result<GmshMesh, InputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.msh");
    fs::write(&path, bytes).unwrap();
    let found = read(&path);
    if let Err(error) = &found {
        let text = error.to_string();
        assert!(text.starts_with(&path.display().to_string()), "begins with the file: {text}");
        assert!(text.contains("\n  help: "), "says what to do: {text}");
    }
    found
}

/// Tag, centre and fault of the element that is refused.
pub fn fault(found: Result<GmshMesh, InputError>) -> (u64, [f64; 3], MeshFault) {
    match found {
        Err(InputError::MeshElement { tag, centre, fault, .. }) => (tag, centre, *fault),
        other => panic!("expected the refusal of an element, found {other:?}"),
    }
}

/// Nodes of a side, the lower local axis fastest.
pub fn side_nodes(mesh: &GmshMesh, (element, side): (u32, u8)) -> Vec<[f64; 3]> {
    let n = mesh.order + 1;
    let count = n.pow(mesh.dimension as u32);
    let nodes = &mesh.elements[element as usize * count..][..count];
    let (axis, end) = (usize::from(side) / 2, usize::from(side) % 2 * mesh.order);
    let on = (0..count).filter(|node| node / n.pow(axis as u32) % n == end);
    on.map(|node| mesh.nodes[nodes[node] as usize]).collect()
}

/// The sides of a boundary.
pub fn boundary<'a>(mesh: &'a GmshMesh, name: &str) -> &'a [(u32, u8)] {
    let found = mesh.boundaries.iter().find(|(known, _)| known == name);
    &found.unwrap_or_else(|| panic!("no boundary {name}")).1
}

/// Places (−√0.6, 0, √0.6) and weights of Gauss' quadrature.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

fn lagrange(order: usize, node: usize, x: f64) -> (f64, f64) {
    match (order, node) {
        (1, 0) => ((1.0 - x) / 2.0, -0.5),
        (1, _) => ((1.0 + x) / 2.0, 0.5),
        (_, 0) => (x * (x - 1.0) / 2.0, x - 0.5),
        (_, 1) => (1.0 - x * x, -2.0 * x),
        _ => (x * (x + 1.0) / 2.0, x + 0.5),
    }
}

/// Area or volume of a material by Gauss' quadrature of the Jacobian, m² or m³.
pub fn measure(mesh: &GmshMesh, material: &str) -> f64 {
    let wanted = mesh.materials.iter().position(|name| name == material).unwrap() as u32;
    let count = (mesh.order + 1).pow(mesh.dimension as u32);
    let elements = mesh.elements.chunks_exact(count).zip(&mesh.material).filter(|(_, m)| **m == wanted);
    elements.map(|(nodes, _)| volume(mesh, nodes)).sum()
}

fn volume(mesh: &GmshMesh, nodes: &[u32]) -> f64 {
    let (n, d) = (mesh.order + 1, mesh.dimension);
    let mut volume = 0.0;
    for point in 0..3_usize.pow(d as u32) {
        let at = [point % 3, point / 3 % 3, point / 9].map(|index| GAUSS[index]);
        let mut jacobian = [[0.0; 3]; 3];
        for (node, number) in nodes.iter().enumerate() {
            let digits = [node % n, node / n % n, node / n / n];
            for axis in 0..d {
                let slope: f64 = (0..d)
                    .map(|a| {
                        let (value, slope) = lagrange(mesh.order, digits[a], at[a].0);
                        if a == axis { slope } else { value }
                    })
                    .product();
                (0..3).for_each(|c| jacobian[axis][c] += slope * mesh.nodes[*number as usize][c]);
            }
        }
        let weight: f64 = at[..d].iter().map(|(_, weight)| weight).product();
        let [a, b, c] = jacobian;
        volume += weight
            * if d == 2 {
                a[0] * b[2] - a[2] * b[0]
            } else {
                a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])
            };
    }
    volume
}

/// A line for whoever reads the test's output, past the capture of the test harness.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
