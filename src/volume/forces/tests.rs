use crate::plan::PlanError;
use crate::volume::{MeshOptions, VolumePlan};
use hati_coupling::Subdomain;
use hati_inputs::scene::load_str;
use hati_sem::solid::{Execution, Solid, Watch};
use std::path::Path;

/// A section of 96 m by 32 m in elements of 8 m, with a source at its surface.
fn scene(source: &str, boundary: &str) -> String {
    format!(
        "version = 1\n[domain]\ndimension = 2\nx = [0.0, 96.0]\ndepth = 32.0\n{boundary}\n\
         [soil.base]\nkind = \"elastic\"\nvs = 200.0\nrho = 1900.0\n\
         [[source]]\nname = \"push\"\n{source}\n\
         wavelet = {{ kind = \"ricker\", frequency = 4.0, time = 0.3 }}\n\
         [discretisation]\norder = 4\nelement_size = 8.0\nelements = [4]\nf_max = 12.0\ndt = 5e-4\n\
         [run]\nduration = 0.7\n[output]\nstations = [{{ name = \"a\", position = [63.0, 0.0] }}]\n"
    )
}

fn planned(text: &str) -> Result<VolumePlan, PlanError> {
    let scene = load_str(text, "a section", &[]).unwrap_or_else(|e| panic!("{e}"));
    VolumePlan::new(&scene, 1, &MeshOptions { allow_scripts: false, folder: Path::new(".") })
}

fn total(plan: &VolumePlan) -> [f64; 3] {
    let forces = || plan.ground.loads().iter().flat_map(|l| &l.forces);
    std::array::from_fn(|c| forces().map(|f| f.1[c]).sum())
}

fn point(x: f64, z: f64, force: &str) -> String {
    format!("kind = \"force\"\nposition = [{x}, {z}]\nforce = {force}")
}

fn patch(x: f64, sigma: f64, force: &str) -> String {
    format!("kind = \"traction\"\nboundary = \"top\"\ncentre = [{x}]\nsigma = {sigma}\nforce = {force}")
}

const DOWN: &str = "[0.0, 0.0, -1e6]";
const SYMMETRY: &str = "[domain.boundary]\nx_min = \"symmetry\"";

/// Largest vertical velocity at the station.
fn peak(plan: &VolumePlan) -> f64 {
    let mut solid = Solid::<f64>::new(&plan.ground, plan.sampling.dt, plan.dt_critical, Execution::default());
    let probe = &plan.sensors[0].probe;
    let points: Vec<u32> = probe.weights.iter().map(|w| w.0).collect();
    let mut watch = Watch::new(&solid, &points);
    let mut peak = 0.0_f64;
    for _ in 0..plan.sampling.steps() {
        watch.before(&solid);
        solid.step();
        watch.after(&solid);
        peak = peak.max(watch.at(probe, 0).velocity[2].abs());
    }
    peak
}

#[test]
fn a_patch_far_narrower_than_its_elements_pushes_as_the_point_force_does() {
    let by_point = peak(&planned(&scene(&point(43.0, 0.0, DOWN), "")).unwrap());
    for sigma in [0.5, 0.3, 0.02] {
        let plan = planned(&scene(&patch(43.0, sigma, DOWN), "")).unwrap();
        assert!((total(&plan)[2] + 1e6).abs() < 1e-3, "{sigma}: {:?}", total(&plan));
        assert!(plan.warnings.iter().all(|w| !w.contains("push")), "{:?}", plan.warnings);
        let found = peak(&plan);
        assert!((found / by_point - 1.0).abs() < 1e-2, "{sigma}: {found:e} against {by_point:e}");
    }
    // a wide one does spread what it does
    let wide = peak(&planned(&scene(&patch(43.0, 8.0, DOWN), "")).unwrap());
    assert!((wide / by_point - 1.0).abs() > 5e-2, "{wide:e} against {by_point:e}");
}

#[test]
fn the_part_of_a_patch_beside_its_boundary_is_told_warned_of_and_refused() {
    let whole = planned(&scene(&patch(40.0, 3.0, DOWN), "")).unwrap();
    let told = |plan: &VolumePlan| plan.reasons.iter().any(|r| r.key == "source" && r.why.contains('%'));
    assert!(told(&whole) && whole.warnings.iter().all(|w| !w.contains("push")), "{:?}", whole.warnings);
    // 2 sigma from the rim: 2.3 % are lost; at the rim of a plane of symmetry that is the mirror image's part
    let cut = planned(&scene(&patch(6.0, 3.0, DOWN), "")).unwrap();
    assert!(cut.warnings.iter().any(|w| w.contains("97.7250 %")), "{:?}", cut.warnings);
    assert!((total(&cut)[2] / -1e6 - 0.977_249_868).abs() < 1e-8, "{:?}", total(&cut));
    for (x, part) in [(6.0, 0.977_249_868), (0.0, 0.5)] {
        let mirrored = planned(&scene(&patch(x, 3.0, DOWN), SYMMETRY)).unwrap();
        assert!(mirrored.warnings.iter().all(|w| !w.contains("push")), "{:?}", mirrored.warnings);
        assert!((total(&mirrored)[2] / -1e6 - part).abs() < 1e-8, "{:?}", total(&mirrored));
    }
    let outside = planned(&scene(&patch(-60.0, 3.0, DOWN), ""));
    assert!(matches!(outside, Err(PlanError::NoEffect { .. })), "{:?}", outside.err());
}

#[test]
fn what_supports_take_of_a_source_is_warned_of_and_all_of_it_refused() {
    let fixed = "[domain.boundary]\nbottom = \"fixed\"";
    let both = "[domain.boundary]\nbottom = \"fixed\"\nx_min = \"symmetry\"";
    let traction = |b: &str, t: &str| format!("kind = \"traction\"\nboundary = \"{b}\"\ntraction = {t}");
    for (source, boundary) in [
        (traction("bottom", "[0.0, 0.0, 1e3]"), fixed),
        (point(43.0, -32.0, DOWN), fixed),
        (traction("x_min", "[1e3, 0.0, 0.0]"), SYMMETRY),
    ] {
        let plan = planned(&scene(&source, boundary));
        assert!(matches!(plan, Err(PlanError::NoEffect { .. })), "{source}: {:?}", plan.err());
    }
    // what a plane of symmetry turns round cannot stand on it, in whole or in part
    let shear = "kind = \"moment\"\nposition = [0.0, -9.0]\nmoment = [0.0, 0.0, 0.0, 0.0, 1e6, 0.0]";
    for source in [
        point(0.0, -4.0, "[1e6, 0.0, 0.0]"),
        point(0.0, -4.0, "[3e6, 0.0, 4e6]"),
        patch(0.0, 0.5, "[1e6, 0.0, 0.0]"),
        patch(0.0, 0.5, "[3e6, 0.0, 4e6]"),
        shear.into(),
    ] {
        let plan = planned(&scene(&source, SYMMETRY));
        assert!(matches!(plan, Err(PlanError::AcrossSymmetry { .. })), "{source}: {:?}", plan.err());
    }
    let plan = planned(&scene(&traction("x_min", "[3e3, 0.0, 4e3]"), SYMMETRY)).unwrap();
    assert!(plan.warnings.iter().any(|w| w.contains("60.0000 %")), "{:?}", plan.warnings);
    // beside a support nothing is lost, and the corner of two is not the one nor the other
    for (source, boundary) in [
        (point(43.0, -31.0, DOWN), fixed),
        (traction("top", "[1e3, 0.0, 1e3]"), both),
        (traction("x_max", "[1e3, 0.0, 1e3]"), both),
        (
            "kind = \"moment\"\nposition = [41.0, -32.0]\nmoment = [1e6, 0.0, 1e6, 0.0, 0.0, 0.0]".into(),
            fixed,
        ),
    ] {
        let plan = planned(&scene(&source, boundary)).unwrap();
        assert!(plan.warnings.iter().all(|w| !w.contains("push")), "{source}: {:?}", plan.warnings);
    }
}

/// A point source on the extension of a plane of symmetry through the ground was halved.
#[test]
fn a_plane_halves_what_stands_on_it_and_not_on_its_extension() {
    let text = scene(&point(0.0, -20.0, DOWN), SYMMETRY);
    let scene = load_str(&text, "a section", &[]).unwrap();
    // an L: below 16 m the ground goes on to x < 0
    let l = hati_sem::mesh::BoxLayer { name: "base".into(), thickness: 32.0, elements: 4 };
    let mut mesh = hati_sem::mesh::LayeredBox {
        dimension: 2,
        x: (-32.0, 96.0),
        y: (0.0, 0.0),
        layers: &[l],
        element_width: 8.0,
        topography: None,
        moved_layers: 1,
        order: 1,
    }
    .mesh()
    .unwrap();
    let centres: Vec<[f64; 3]> = (0..mesh.len()).map(|e| mesh.centre(e)).collect();
    let at_foot = |e: u32| {
        let [x, _, z] = centres[e as usize];
        x > 0.0 && x < 8.0 && z > -16.0
    };
    let kept = |e: u32| centres[e as usize][0] > 0.0 || centres[e as usize][2] < -16.0;
    let sides: Vec<_> = (0..mesh.len() as u32)
        .filter(|&e| at_foot(e))
        .flat_map(|e| (0..4).map(move |side| hati_sem::mesh::Side { element: e, side }))
        .filter(|&s| mesh.side_normal(s, mesh.side_local(s, [0.0; 2]))[0] < -1.0)
        .collect();
    assert_eq!(sides.len(), 2);
    // elements are taken out and numbered anew
    let numbers: Vec<Option<u32>> = (0..mesh.len() as u32)
        .scan(0, |next, e| {
            let number = kept(e).then_some(*next);
            *next += u32::from(number.is_some());
            Some(number)
        })
        .collect();
    let nodes = mesh.nodes_per_element();
    mesh.elements = mesh
        .elements
        .chunks(nodes)
        .zip(&numbers)
        .filter(|n| n.1.is_some())
        .flat_map(|c| c.0.to_vec())
        .collect();
    mesh.material.truncate(mesh.elements.len() / nodes);
    let renumbered = |s: &hati_sem::mesh::Side| {
        numbers[s.element as usize].map(|element| hati_sem::mesh::Side { element, side: s.side })
    };
    mesh.boundaries.retain(|b| b.name != "x_min");
    mesh.boundaries.push(hati_sem::mesh::Boundary { name: "x_min".into(), sides });
    for boundary in &mut mesh.boundaries {
        boundary.sides = boundary.sides.iter().filter_map(renumbered).collect();
    }
    let soil = hati_sem::solid::Material::elastic("base", 1900.0, 400.0, 200.0);
    let mut ground = hati_sem::solid::Ground::new(mesh, 4, &[soil]).unwrap();
    ground.support("x_min", hati_sem::solid::Support::Symmetry).unwrap();
    let planes = crate::volume::symmetry::planes(&scene, &ground).unwrap();
    assert_eq!(planes.len(), 1);
    let signals = crate::volume::sources::signals(&scene).unwrap();
    let locator = hati_sem::mesh::Locator::new(ground.mesh());
    for (z, share) in [(-4.0, 0.5), (-9.0, 0.5), (-20.0, 1.0), (-24.0, 1.0)] {
        let mut signal = signals[0].clone();
        if let hati_inputs::scene::Action::Force { at, .. } = &mut signal.action {
            *at = hati_inputs::scene::Place::Point([0.0, 0.0, z]);
        }
        let made = super::forces(&ground, &locator, &planes, &signal).unwrap();
        let found: f64 = made.forces.iter().map(|f| f.1[2]).sum();
        assert!((found / -1e6 - share).abs() < 1e-9, "{z}: {found}");
        assert!(made.warnings.is_empty(), "{:?}", made.warnings);
    }
}

#[test]
fn sources_of_one_wavelet_share_it_and_steps_without_end_are_refused() {
    let more = |wavelet: &str| {
        let push = point(20.0, -5.0, DOWN);
        format!(
            "[[source]]\n{push}\nwavelet = {{ kind = \"ricker\", frequency = {wavelet}, time = 0.3 }}\n[run]"
        )
    };
    let one = planned(&scene(&point(43.0, 0.0, DOWN), "")).unwrap();
    let bytes = |wavelets: [&str; 2]| {
        let text =
            wavelets.iter().fold(scene(&point(43.0, 0.0, DOWN), ""), |t, w| t.replacen("[run]", &more(w), 1));
        planned(&text).unwrap().ground.load_bytes()
    };
    let array = 8 * one.sampling.steps() as usize;
    assert!(bytes(["4.0", "4.0"]) < one.ground.load_bytes() + array / 2);
    assert!(bytes(["4.0", "3.0"]) > one.ground.load_bytes() + array / 2);
    let endless = scene(&point(43.0, 0.0, DOWN), "")
        .replace("dt = 5e-4", "dt = 1e-9")
        .replace("duration = 0.7", "duration = 1e6");
    let refused = planned(&endless);
    assert!(matches!(refused, Err(PlanError::MemoryOfSources { .. })), "{:?}", refused.err());
}
