//! Meshes of [Gmsh](https://gmsh.info): MSH 4.1 and 2.2, text and binary; and `.geo` files meshed by it.
//!
//! [`read`] takes quadrilaterals (a section) or hexahedra (a volume) of order 1 or 2, every one in a named
//! physical group, which is its material; named groups one dimension lower are boundaries. What cannot be
//! computed with is refused with the element's tag and centre and with what to do ([`MeshFault`]).
//!
//! A `.geo` file is a program: it may run commands of the system. [`mesh_geo`] runs it only with leave and
//! only from the scene's own folder.

mod assemble;
mod cursor;
mod fault;
mod geo;
mod geometry;
mod kinds;
mod near;
mod raw;
mod section;
mod sections;
mod sides;
mod version2;
mod version4;

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use sha2::{Digest, Sha256};

pub use fault::MeshFault;
pub(crate) use fault::point;
pub use geo::{GeoRun, gmsh_version, mesh_geo};

use crate::error::InputError;

/// Quadrilaterals (D = 2, a section in x–z) or hexahedra (D = 3), checked.
///
/// Every Jacobian is positive, elements meet side to side, no two nodes lie in one place, and all nodes
/// are used. Lengths are taken as m.
#[derive(Debug, Clone, PartialEq)]
pub struct GmshMesh {
    /// D: 2 or 3.
    pub dimension: usize,
    /// Order g of the geometry: 1 (quad4, hex8) or 2 (quad9, hex27).
    pub order: usize,
    /// Coordinates x, y, z of the nodes, m, z up; y = 0 at D = 2.
    pub nodes: Vec<[f64; 3]>,
    /// Nodes of every element, $(g+1)^D$ each, in tensor order: ξ runs fastest, then η, then ζ.
    pub elements: Vec<u32>,
    /// Material of every element, an index into [`Self::materials`].
    pub material: Vec<u32>,
    /// Names of the physical groups of dimension D, in the order of their tags.
    pub materials: Vec<String>,
    /// Names of the physical groups of dimension D − 1 and their sides, each an element and a number:
    /// `2 a` at −1 of local axis `a`, `2 a + 1` at +1. A side between two elements is given once, as that
    /// of the element with the lower index.
    pub boundaries: Vec<(String, Vec<(u32, u8)>)>,
    /// Gmsh's tag of every element, by which messages name it.
    pub tags: Vec<u64>,
    /// What was done that the file does not say: nodes left out, elements turned, the section's plane.
    pub notes: Vec<String>,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
}

/// Reads a mesh that Gmsh wrote.
///
/// At D = 2 a mesh flat in z (Gmsh's usual plane) becomes the section x–z, its y being up; one flat in y
/// stays as it is. Quadrilaterals may be numbered either way round; hexahedra must be right-handed.
///
/// # Errors
/// [`InputError::MeshBroken`] with line or byte where the file is damaged, [`InputError::MeshRefused`] where
/// it is another kind of file, [`InputError::MeshElement`] where an element cannot be computed with.
pub fn read(path: &Path) -> Result<GmshMesh, InputError> {
    let bytes = content(path)?;
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("geo")) {
        return Err(sections::refused(
            path,
            "is a geometry, a program for Gmsh, and no mesh",
            "let hati mesh it (--allow-scripts), or run gmsh -3 -format msh41 and give the .msh file",
        ));
    }
    let mut hash = Sha256::new();
    hash.update(&bytes);
    let sha256 = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    let raw = sections::take_apart(path, &bytes)?;
    drop(bytes);
    assemble::assemble(path, &raw, sha256)
}

/// Bytes of a local, regular file.
fn content(path: &Path) -> Result<Vec<u8>, InputError> {
    let unreadable = |source| InputError::RecordUnreadable { path: path.to_path_buf(), source };
    let about = match fs::metadata(path) {
        Ok(about) => about,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Err(InputError::RecordMissing { path: path.to_path_buf() });
        }
        Err(error) => return Err(unreadable(error)),
    };
    if !about.is_file() {
        return Err(sections::refused(path, "is not a regular file", "name the .msh file itself"));
    }
    let bytes = fs::read(path).map_err(unreadable)?;
    if bytes.is_empty() {
        return Err(InputError::RecordEmpty { path: path.to_path_buf() });
    }
    Ok(bytes)
}
