//! `.geo` files: run only with leave and from the scene's folder; meshed by the Gmsh of the set-up.

mod gmsh;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use approx::assert_relative_eq;
use gmsh::{boundary, fixture, measure, say};
use hati_inputs::InputError;
use hati_inputs::gmsh::{GeoRun, gmsh_version, mesh_geo, read};

/// A folder with a scene's folder, one outside it, and one for results.
struct Place {
    _folder: tempfile::TempDir,
    scene: PathBuf,
    outside: PathBuf,
    out: PathBuf,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let [scene, outside, out] = ["scene", "outside", "run"].map(|name| folder.path().join(name));
        fs::create_dir_all(scene.join("meshes")).unwrap();
        fs::create_dir_all(&outside).unwrap();
        Self { _folder: folder, scene, outside, out }
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.scene.join(name), text).unwrap();
    }

    /// Meshes with leave.
    fn mesh(&self, name: &str, dimension: usize) -> Result<PathBuf, InputError> {
        mesh_geo(&self.run(Path::new(name), dimension))
    }

    fn run<'a>(&'a self, geo: &'a Path, dimension: usize) -> GeoRun<'a> {
        GeoRun {
            geo,
            scene_folder: &self.scene,
            dimension,
            allow_scripts: true,
            python: None,
            out_folder: &self.out,
            time_limit: Duration::from_secs(120),
        }
    }
}

/// Whether Gmsh can be run; says so when it cannot.
fn has_gmsh() -> bool {
    match gmsh_version(None) {
        Ok(_) => true,
        Err(error) => {
            say(&format!("skipped: {}", error.to_string().lines().next().unwrap_or_default()));
            false
        }
    }
}

/// A square of 2 m in four quadrilaterals.
const SQUARE: &str = r#"
Point(1) = {0, 0, 0}; Point(2) = {2, 0, 0}; Point(3) = {2, 2, 0}; Point(4) = {0, 2, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve{:} = 3; Transfinite Surface{1}; Recombine Surface{1};
Physical Surface("soil") = {1};
"#;

#[test]
fn a_geometry_is_a_program_and_runs_only_with_leave() {
    let place = Place::new();
    let marker = place.outside.join("marker");
    place.write("model.geo", &format!("SystemCall \"touch '{}'\";{SQUARE}", marker.display()));
    let without = GeoRun { allow_scripts: false, ..place.run(Path::new("model.geo"), 2) };
    let error = mesh_geo(&without).unwrap_err();
    assert!(matches!(error, InputError::GeoRefused { .. }), "{error}");
    assert!(error.to_string().contains("--allow-scripts"), "{error}");
    assert!(!marker.exists() && !place.out.exists());
    if has_gmsh() {
        place.mesh("model.geo", 2).unwrap();
        assert!(marker.exists(), "it is a program indeed");
    }
}

#[test]
fn a_geometry_runs_only_from_the_scenes_own_folder() {
    let place = Place::new();
    fs::write(place.outside.join("model.geo"), SQUARE).unwrap();
    // Nothing may be run: this Python would be an error of another kind.
    let nowhere = Path::new("/nonexistent/python");
    let refusal = |geo: &Path| {
        let run = GeoRun { python: Some(nowhere), ..place.run(geo, 2) };
        mesh_geo(&run).unwrap_err()
    };
    let outside = place.outside.join("model.geo");
    for geo in [Path::new("../outside/model.geo"), Path::new("meshes/../model.geo"), &outside] {
        let error = refusal(geo);
        assert!(matches!(error, InputError::GeoRefused { .. }), "{error}");
        assert!(error.to_string().contains("scene's folder"), "{error}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, place.scene.join("link.geo")).unwrap();
        std::os::unix::fs::symlink(&place.outside, place.scene.join("elsewhere")).unwrap();
        for geo in ["link.geo", "elsewhere/model.geo"] {
            assert!(matches!(refusal(Path::new(geo)), InputError::GeoRefused { .. }), "{geo}");
        }
    }
    assert!(matches!(refusal(Path::new("none.geo")), InputError::RecordMissing { .. }));
    fs::create_dir(place.scene.join("folder.geo")).unwrap();
    place.write("model.py", "");
    for geo in ["folder.geo", "meshes", "model.py"] {
        assert!(matches!(refusal(Path::new(geo)), InputError::GeoRefused { .. }), "{geo}");
    }
    // From within it, by a relative or an absolute path, it comes as far as the Python that is not there.
    place.write("meshes/model.geo", SQUARE);
    for geo in [Path::new("meshes/model.geo"), &place.scene.join("meshes/model.geo")] {
        assert!(matches!(refusal(geo), InputError::GmshMissing { .. }));
    }
    let flat = GeoRun { dimension: 1, ..place.run(Path::new("meshes/model.geo"), 2) };
    assert!(matches!(mesh_geo(&flat).unwrap_err(), InputError::GeoRefused { .. }));
}

#[test]
fn the_books_example_is_meshed() {
    let example = fs::read_to_string(fixture("two-layers.geo")).unwrap();
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/meshes.md");
    assert!(fs::read_to_string(book).unwrap().contains(&example), "the book shows this file");
    if !has_gmsh() {
        return;
    }
    let place = Place::new();
    place.write("two-layers.geo", &example);
    let path = place.mesh("two-layers.geo", 3).unwrap();
    assert_eq!(path.file_name().unwrap(), "two-layers.msh");
    let mesh = read(&path).unwrap();
    assert_eq!((mesh.dimension, mesh.order, mesh.material.len()), (3, 1, 12 * 8 * 6));
    assert_eq!(mesh.materials, ["rock", "clay"]);
    assert_relative_eq!(measure(&mesh, "rock"), 48_000.0, max_relative = 1e-9);
    assert_relative_eq!(measure(&mesh, "clay"), 24_000.0, max_relative = 1e-9);
    let counts: Vec<usize> = ["top", "bottom", "sides"].iter().map(|b| boundary(&mesh, b).len()).collect();
    assert_eq!(counts, [96, 96, 2 * (12 + 8) * 6]);

    place.write("curved.geo", &example.replace("ElementOrder = 1", "ElementOrder = 2"));
    let curved = read(&place.mesh("curved.geo", 3).unwrap()).unwrap();
    assert_eq!((curved.order, curved.material.len()), (2, mesh.material.len()));
    // The same file, the same bytes.
    let first = fs::read(&path).unwrap();
    assert_eq!(fs::read(place.mesh("two-layers.geo", 3).unwrap()).unwrap(), first);
}

#[test]
fn a_section_is_meshed_too_and_other_files_of_the_folder_may_be_included() {
    if !has_gmsh() {
        return;
    }
    let place = Place::new();
    place.write("meshes/square.geo", SQUARE);
    place.write("model.geo", "Include \"meshes/square.geo\";\nMesh.ElementOrder = 2;\n");
    let mesh = read(&place.mesh("model.geo", 2).unwrap()).unwrap();
    assert_eq!((mesh.dimension, mesh.order, mesh.material.len()), (2, 2, 4));
    assert_relative_eq!(measure(&mesh, "soil"), 4.0, max_relative = 1e-9);
}

#[test]
fn what_gmsh_calls_an_error_fails_with_its_words() {
    if !has_gmsh() {
        return;
    }
    let place = Place::new();
    place.write("model.geo", &format!("{SQUARE}\nPlane Surface(2) = {{undefined}};\n"));
    let error = place.mesh("model.geo", 2).unwrap_err();
    assert!(matches!(error, InputError::GmshFailed { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("line 8") && text.contains("undefined"), "{text}");
    assert!(!place.out.join("model.msh").exists());
    // A program that ends Gmsh before it has meshed.
    place.write("quit.geo", "Exit;");
    assert!(matches!(place.mesh("quit.geo", 2), Err(InputError::GmshFailed { .. })));
    let log = fs::read_to_string(place.out.join("model.gmsh.log")).unwrap();
    assert!(log.contains("undefined"), "{log}");
}

#[test]
fn a_geometry_that_does_not_end_is_stopped() {
    if !has_gmsh() {
        return;
    }
    let place = Place::new();
    place.write("slow.geo", "For i In {0:1000000000}\n  x = i * i;\nEndFor\n");
    let begin = Instant::now();
    let run = GeoRun { time_limit: Duration::from_secs(2), ..place.run(Path::new("slow.geo"), 2) };
    let error = mesh_geo(&run).unwrap_err();
    assert!(matches!(error, InputError::GmshTimeout { seconds: 2.0, .. }), "{error}");
    assert!(begin.elapsed() < Duration::from_secs(20));
    assert!(!place.out.join("slow.msh").exists());
}
