//! The mesh of a scene: a box of its layers, or the user's file.

use super::sizes::{Points, layer};
use crate::plan::PlanError;
use hati_inputs::gmsh::{self, GeoRun, GmshMesh};
use hati_inputs::scene::{Action, Auto, BoundaryKind, MaterialValues, Scene};
use hati_sem::mesh::{
    Boundary, BoxLayer, LayeredBox, Mesh, MeshReport, Side, check, element_width, layer_heights,
};
use hati_sem::soil::Layer;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Longest time that Gmsh may take.
const GMSH_TIME: Duration = Duration::from_secs(600);

/// What making a mesh may do and where.
#[derive(Debug, Clone, Copy)]
pub struct MeshOptions<'a> {
    /// Whether a `.geo` script may run.
    pub allow_scripts: bool,
    /// Folder for the mesh that a script makes.
    pub folder: &'a Path,
}

/// A mesh file as it was read.
#[derive(Debug, Clone)]
pub struct FileMesh {
    /// Where the `.msh` file lies.
    pub path: PathBuf,
    /// Gmsh's tags of the elements.
    pub tags: Vec<u64>,
    /// SHA-256 of the file.
    pub sha256: String,
    /// What the reader did.
    pub notes: Vec<String>,
    /// Whether a script made it.
    pub scripted: bool,
}

/// Reads the mesh file of a scene, or makes it by its script; `None` for a box.
pub fn read(scene: &Scene, options: &MeshOptions<'_>) -> Result<Option<(Mesh, FileMesh)>, PlanError> {
    let Some(name) = scene.domain.as_ref().and_then(|d| d.mesh.as_deref()) else { return Ok(None) };
    let given = scene.path_of(name);
    let scripted = given.extension().is_some_and(|e| e.eq_ignore_ascii_case("geo"));
    let path = if scripted {
        let here = Path::new(".");
        let folder = &scene.source.folder;
        gmsh::mesh_geo(&GeoRun {
            geo: Path::new(name),
            scene_folder: if folder.as_os_str().is_empty() { here } else { folder },
            dimension: scene.dimension(),
            allow_scripts: options.allow_scripts,
            python: None,
            out_folder: options.folder,
            time_limit: GMSH_TIME,
        })?
    } else {
        given
    };
    let GmshMesh { dimension, order, nodes, elements, material, materials, boundaries, tags, notes, sha256 } =
        gmsh::read(&path)?;
    let side = |(element, side)| Side { element, side };
    let named = |(name, sides): (String, Vec<(u32, u8)>)| Boundary {
        name,
        sides: sides.into_iter().map(side).collect(),
    };
    let boundaries = boundaries.into_iter().map(named).collect();
    let mut mesh = Mesh { dimension, order, nodes, elements, material, materials, boundaries };
    check_names(scene, &mesh, &path)?;
    let mut notes = notes;
    settle_groups(scene, &mut mesh, &mut notes);
    Ok(Some((mesh, FileMesh { path, tags, sha256, notes, scripted })))
}

/// Compares the names of the scene with those of the mesh.
fn check_names(scene: &Scene, mesh: &Mesh, path: &Path) -> Result<(), PlanError> {
    let expected = scene.dimension();
    if mesh.dimension != expected {
        let (place, name) = (scene.source.place_of("domain.dimension"), expected.to_string());
        let present = vec![mesh.dimension.to_string()];
        let help = "give the dimension of the mesh";
        return Err(PlanError::MeshName {
            place,
            what: "dimension",
            name,
            path: path.into(),
            present: present.into(),
            help,
        });
    }
    let given: Vec<String> = scene.material.iter().map(|m| m.name.clone()).collect();
    if let Some(name) = mesh.materials.iter().find(|name| !given.contains(name)) {
        return Err(PlanError::MaterialMissing { path: path.into(), name: name.clone(), given });
    }
    if let Some(number) = given.iter().position(|name| !mesh.materials.contains(name)) {
        let place = scene.source.place_of(&format!("material[{}].name", number + 1));
        let (what, name, present) = ("material", given[number].clone(), mesh.materials.clone());
        let help = "take it out, or name it as the physical group of the mesh";
        return Err(PlanError::MeshName {
            place,
            what,
            name,
            path: path.into(),
            present: present.into(),
            help,
        });
    }
    let boundaries = scene.domain.iter().flat_map(|d| d.boundary.keys());
    if let Some(name) = boundaries.into_iter().find(|name| mesh.boundary(name).is_none()) {
        let place = scene.source.place_of(&format!("domain.boundary.{name}"));
        let present: Vec<String> = mesh.boundaries.iter().map(|b| b.name.clone()).collect();
        let help = "take it out, or name it as the physical group of the mesh";
        let (what, name) = ("boundary", name.clone());
        return Err(PlanError::MeshName {
            place,
            what,
            name,
            path: path.into(),
            present: present.into(),
            help,
        });
    }
    Ok(())
}

/// A box as it will be meshed.
#[derive(Debug, Clone)]
pub struct BoxSizes {
    /// Layers with their counts.
    pub layers: Vec<BoxLayer>,
    /// Greatest width of an element, m.
    pub width: f64,
    /// Elements along x, y and z.
    pub counts: [usize; 3],
    x: (f64, f64),
    y: (f64, f64),
}

/// Sizes of a box's elements; what the scene gives wins.
///
/// A material that needs fewer points than the most is sized as if its waves were faster by as much.
pub fn box_sizes(
    scene: &Scene,
    materials: &[MaterialValues],
    points: &Points,
) -> Result<BoxSizes, PlanError> {
    let resolution = &points.resolution;
    let thicknesses = scene.thicknesses();
    let domain = scene.domain.as_ref();
    let hill = domain.and_then(|d| d.heights.as_ref()).map_or(0.0, |h| h.range().1.max(0.0));
    let sized = |(m, thickness): (&MaterialValues, &f64)| {
        let spared = resolution.points_per_wavelength / points.wanted(&m.name);
        Layer { vs: m.vs * spared, ..layer(m, *thickness) }
    };
    let mut layers: Vec<_> = materials.iter().zip(&thicknesses).map(sized).collect();
    let width = match scene.discretisation.element_size {
        Auto::Value(size) => size,
        Auto::Auto => element_width(&layers, resolution)?,
    };
    let mut sized = match &scene.discretisation.elements {
        Auto::Value(counts) => layers
            .iter()
            .zip(counts)
            .map(|(l, &elements)| BoxLayer { name: l.name.clone(), thickness: l.thickness, elements })
            .collect(),
        Auto::Auto => {
            // the uppermost layer is as thick as the highest hill makes it
            layers.iter_mut().take(1).for_each(|l| l.thickness += hill);
            layer_heights(&layers, resolution)?
        }
    };
    sized.iter_mut().zip(&thicknesses).for_each(|(l, t)| l.thickness = *t);
    let range = |r: Option<[f64; 2]>| r.map_or((0.0, 0.0), |[a, b]| (a, b));
    let (x, y) = (range(domain.and_then(|d| d.x)), range(domain.and_then(|d| d.y)));
    let mut sizes = BoxSizes { layers: sized, width, counts: [0; 3], x, y };
    sizes.counts = sizes.described(scene.dimension(), None).counts()?;
    Ok(sizes)
}

impl BoxSizes {
    fn described<'a>(
        &'a self,
        dimension: usize,
        topography: Option<&'a dyn Fn(f64, f64) -> f64>,
    ) -> LayeredBox<'a> {
        LayeredBox {
            dimension,
            x: self.x,
            y: self.y,
            layers: &self.layers,
            element_width: self.width,
            topography,
            moved_layers: 1,
            order: 1,
        }
    }

    /// Meshes the box.
    pub fn mesh(&self, scene: &Scene) -> Result<Mesh, PlanError> {
        let heights = scene.domain.as_ref().and_then(|d| d.heights.as_ref());
        let height = |x: f64, y: f64| heights.map_or(0.0, |h| h.height(x, y));
        let topography: Option<&dyn Fn(f64, f64) -> f64> = heights.map(|_| &height as _);
        Ok(self.described(scene.dimension(), topography).mesh()?)
    }
}

/// Checks a mesh; a fault of a file's element is told with Gmsh's tag.
pub fn checked(mesh: &Mesh, order: usize, file: Option<&FileMesh>) -> Result<MeshReport, PlanError> {
    check(mesh, order).map_err(|source| match file {
        Some(file) => PlanError::Place {
            what: format!("domain.mesh: {}", file.path.display()),
            source: Box::new(source),
        },
        None => source.into(),
    })
}

/// A boundary with what holds on it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedBoundary {
    /// Its name.
    pub name: String,
    /// What holds on it.
    pub kind: BoundaryKind,
    /// Whether the scene says so; else it is the default.
    pub given: bool,
    /// Sides of elements.
    pub sides: usize,
}

/// All boundaries with their kinds, in the mesh's order.
pub fn kinds(scene: &Scene, mesh: &Mesh) -> Vec<PlannedBoundary> {
    let given = |name: &str| scene.domain.as_ref().is_some_and(|d| d.boundary.contains_key(name));
    let of = |b: &Boundary| PlannedBoundary {
        name: b.name.clone(),
        kind: scene.boundary_kind(&b.name),
        given: given(&b.name),
        sides: b.sides.len(),
    };
    mesh.boundaries.iter().map(of).collect()
}

/// Takes out the groups that lie between elements, where the scene does not name them, with a note; and notes sides of
/// the surface that no group holds.
fn settle_groups(scene: &Scene, mesh: &mut Mesh, notes: &mut Vec<String>) {
    let outer = mesh.outer_sides();
    let named = |name: &str| {
        let of_source = |action: &Action| match action {
            Action::Traction { boundary, .. } | Action::Patch { boundary, .. } => boundary == name,
            Action::Force { .. } | Action::Moment { .. } => false,
        };
        scene.domain.as_ref().is_some_and(|d| d.boundary.contains_key(name))
            || scene.output.surface.as_ref().is_some_and(|s| s.boundary == name)
            || scene.sources().iter().any(|s| of_source(&s.action))
    };
    let inner = |b: &Boundary| !b.sides.iter().any(|s| outer.binary_search(s).is_ok());
    mesh.boundaries.retain(|b| {
        let drop = inner(b) && !named(&b.name);
        if drop {
            notes.push(format!(
                "the group `{}` lies between elements: it is no boundary of the ground and is passed over",
                b.name
            ));
        }
        !drop
    });
    let grouped: HashSet<Side> = mesh.boundaries.iter().flat_map(|b| b.sides.iter().copied()).collect();
    let mut loose = outer.iter().filter(|s| !grouped.contains(s));
    if let Some(&first) = loose.next() {
        let place = mesh.position(first.element as usize, mesh.side_local(first, [0.0; 2]));
        notes.push(format!(
            "{} sides of the mesh's surface are in no physical group, the first around {}: they are free; put them into a \
             group and give its kind in [domain.boundary]",
            loose.count() + 1,
            super::explain::place(place, mesh.dimension)
        ));
    }
}
