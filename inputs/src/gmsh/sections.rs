//! The sections of an MSH file: header, names, and those of versions 4.1 and 2.2.

use std::path::Path;

use super::cursor::{Cursor, shown};
use super::raw::Raw;
use super::{version2, version4};
use crate::error::InputError;

/// Version and storage as the header gives them.
#[derive(Clone, Copy, PartialEq)]
enum Version {
    V2,
    V4,
}

/// A refusal of what the file is, not of damage.
pub(super) fn refused(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> InputError {
    InputError::MeshRefused { path: path.to_path_buf(), problem: problem.into(), remedy: remedy.into() }
}

/// Takes a file apart.
pub(super) fn take_apart(path: &Path, bytes: &[u8]) -> Result<Raw, InputError> {
    let beginning = bytes.trim_ascii_start();
    if !beginning.starts_with(b"$") {
        let first = beginning.split(|byte| *byte == b'\n').next().unwrap_or_default();
        return Err(refused(
            path,
            format!("is no MSH file; it begins with {}", shown(first)),
            "give a mesh that Gmsh wrote (gmsh -3 -format msh41 model.geo), or name the .geo file itself",
        ));
    }
    let mut cursor = Cursor::new(path, bytes);
    let mut raw = Raw::default();
    let mut version = None;
    let mut entities = version4::Entities::default();
    let mut seen: Vec<String> = Vec::new();
    while let Some(section) = cursor.next_section()? {
        if matches!(section.as_str(), "MeshFormat" | "Entities" | "Nodes" | "Elements")
            && seen.contains(&section)
        {
            return Err(cursor.broken(format!("a second ${section}")));
        }
        match (section.as_str(), version) {
            ("MeshFormat", _) => version = Some(header(&mut cursor)?),
            ("NOD" | "ELM", _) => return Err(old(path, "1")),
            ("PartitionedEntities" | "GhostElements", _) => return Err(partitioned(path)),
            ("ParametricNodes", _) => {
                return Err(refused(
                    path,
                    "its nodes are parametric ($ParametricNodes)",
                    "write it as MSH 4.1, or with Mesh.SaveParametric = 0",
                ));
            }
            ("PhysicalNames", Some(_)) => names(&mut cursor, &mut raw)?,
            ("Entities", Some(Version::V4)) => entities = version4::entities(&mut cursor)?,
            ("Nodes", Some(Version::V4)) => version4::nodes(&mut cursor, &mut raw)?,
            ("Elements", Some(Version::V4)) => version4::elements(&mut cursor, &entities, &mut raw)?,
            ("Nodes", Some(Version::V2)) => version2::nodes(&mut cursor, &mut raw)?,
            ("Elements", Some(Version::V2)) => version2::elements(&mut cursor, &mut raw)?,
            ("Nodes" | "Elements" | "Entities" | "PhysicalNames", None) => {
                return Err(cursor.broken("comes before $MeshFormat"));
            }
            _ => {
                cursor.skip_section()?;
                continue;
            }
        }
        cursor.end_section()?;
        seen.push(section);
    }
    for needed in ["MeshFormat", "Nodes", "Elements"] {
        if !seen.iter().any(|section| section == needed) {
            return Err(cursor.broken(format!("the file ends without ${needed}")));
        }
    }
    Ok(raw)
}

fn old(path: &Path, version: &str) -> InputError {
    refused(
        path,
        format!("is MSH version {version}; 4.1 and 2.2 are read"),
        "convert it: gmsh old.msh -save -format msh41 -o new.msh",
    )
}

fn partitioned(path: &Path) -> InputError {
    refused(
        path,
        "is a partitioned mesh ($PartitionedEntities); the parts of a mesh are chosen here",
        "write it whole: take the partitioning out of the .geo file, or call gmsh.model.mesh.unpartition() in Gmsh's Python",
    )
}

/// `$MeshFormat`: version, storage, size of a number, byte order.
fn header(cursor: &mut Cursor<'_>) -> Result<Version, InputError> {
    let line = cursor.line();
    let text = String::from_utf8_lossy(line).into_owned();
    let words: Vec<&str> = text.split_whitespace().collect();
    let [version, storage, data_size] = words[..] else {
        return Err(
            cursor.broken(format!("expected version, file type and data size, found {}", shown(line)))
        );
    };
    let version = match version {
        "4.1" => Version::V4,
        "2.2" => Version::V2,
        // Files of 2.0 and 2.1 differ from 2.2 in nothing that is read here.
        "2" | "2.0" | "2.1" => Version::V2,
        other if other.parse::<f64>().is_ok() => return Err(old(cursor.path(), other)),
        other => return Err(cursor.broken(format!("expected a version, found {}", shown(other.as_bytes())))),
    };
    let binary = match storage {
        "0" => false,
        "1" => true,
        other => {
            let found = shown(other.as_bytes());
            return Err(cursor.broken(format!("expected file type 0 (text) or 1 (binary), found {found}")));
        }
    };
    if binary {
        if data_size != "8" {
            return Err(refused(
                cursor.path(),
                format!("binary numbers of {} bytes; 8 are read", shown(data_size.as_bytes())),
                "write the mesh as text (Mesh.Binary = 0), or with a 64-bit Gmsh",
            ));
        }
        cursor.binary = true;
        let one = cursor.int()?;
        if one == i64::from(1_i32.swap_bytes()) {
            return Err(refused(
                cursor.path(),
                "its binary numbers have the other byte order: it was written on another kind of machine",
                "write it as text there (Mesh.Binary = 0)",
            ));
        }
        if one != 1 {
            return Err(
                cursor.broken(format!("expected the number 1 that tells the byte order, found {one}"))
            );
        }
    }
    Ok(version)
}

/// `$PhysicalNames`: text in every file.
fn names(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), InputError> {
    let binary = std::mem::replace(&mut cursor.binary, false);
    let count = cursor.size()?;
    let count = cursor.fits(count, 3, 6, "physical names")?;
    for _ in 0..count {
        let (dimension, tag) = (cursor.int()?, cursor.int()?);
        let line = cursor.line();
        let quoted = line.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\""));
        let name = quoted.and_then(|name| std::str::from_utf8(name).ok());
        let Some(name) = name else {
            return Err(cursor.broken(format!("expected a name in quotation marks, found {}", shown(line))));
        };
        let dimension = u8::try_from(dimension).ok().filter(|d| *d <= 3);
        let Some(dimension) = dimension else {
            return Err(cursor.broken("the dimension of a physical group is 0 to 3"));
        };
        raw.names.insert((dimension, tag), name.trim().to_string());
    }
    cursor.binary = binary;
    Ok(())
}
