//! Meshes that Gmsh wrote: every format, shape and order, against what was drawn.

mod gmsh;

use approx::assert_relative_eq;
use gmsh::{Draft, boundary, fixture, measure, read_bytes, side_nodes};
use hati_inputs::gmsh::{GmshMesh, read};

fn sound(name: &str) -> GmshMesh {
    read(&fixture(name)).unwrap_or_else(|error| panic!("{error}"))
}

/// What does not depend on how the file is written; MSH 2.2 has 16 digits, 4.1 has 17.
fn assert_same(a: &GmshMesh, b: &GmshMesh) {
    assert_eq!((&a.elements, &a.material, &a.materials), (&b.elements, &b.material, &b.materials));
    assert_eq!((a.nodes.len(), &a.boundaries), (b.nodes.len(), &b.boundaries));
    for (p, q) in a.nodes.iter().zip(&b.nodes) {
        (0..3).for_each(|c| assert_relative_eq!(p[c], q[c], max_relative = 4e-15));
    }
}

#[test]
fn a_section_is_the_same_in_every_format() {
    let text = sound("section_quad4.msh");
    assert_eq!((text.dimension, text.order, text.material.len()), (2, 1, 4 * 3 + 4 * 2));
    // By the tags of their groups, 3 and 7, not by their order in the file.
    assert_eq!(text.materials, ["clay", "rock"]);
    assert_relative_eq!(measure(&text, "rock"), 20.0 * 6.0, max_relative = 1e-12);
    assert_relative_eq!(measure(&text, "clay"), 20.0 * 4.0, max_relative = 1e-12);
    let names: Vec<&str> = text.boundaries.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["top", "bottom", "all"]);
    for (name, z) in [("top", 0.0), ("bottom", -10.0)] {
        let sides = boundary(&text, name);
        assert_eq!(sides.len(), 4);
        assert!(sides.iter().all(|side| side_nodes(&text, *side).iter().all(|p| p[2] == z)));
    }
    // The bottom belongs to a second group too.
    assert_eq!(boundary(&text, "all").len(), 4 + 4 + 2 * (3 + 2));
    assert!(text.nodes.iter().all(|p| p[1] == 0.0));
    assert!(text.notes.iter().any(|note| note.contains("x–z")), "{:?}", text.notes);
    assert_eq!(text.sha256.len(), 64);
    for other in ["section_quad4_22.msh", "section_quad4_22_binary.msh"] {
        let other = sound(other);
        assert_same(&other, &text);
        assert_ne!(other.sha256, text.sha256);
    }
}

#[test]
fn clockwise_quadrilaterals_are_turned() {
    let drawn = Draft::default().squares([0.0, 0.0], 2, 1, 1.0, 1).soil(2).name(1, 1, "top");
    let counter = drawn.clone().element(1, 1, 1, &[4, 5]).read().unwrap();
    let mut clockwise = drawn.element(1, 1, 1, &[4, 5]);
    clockwise.elements[1].3.reverse();
    let turned = clockwise.read().unwrap();
    assert_relative_eq!(measure(&turned, "soil"), 2.0, max_relative = 1e-14);
    assert!(turned.notes.iter().any(|note| note.starts_with("1 clockwise")), "{:?}", turned.notes);
    assert_eq!(counter.elements[..4], [0, 1, 3, 4]);
    assert_eq!(side_nodes(&turned, boundary(&turned, "top")[0]).len(), 2);
    assert!(side_nodes(&turned, boundary(&turned, "top")[0]).iter().all(|p| p[2] == 1.0));

    // The mirrored drawing: every element of the section is clockwise in x–z.
    let hill = sound("hill_quad9.msh");
    assert!(measure(&hill, "clay") > 0.0 && measure(&hill, "rock") > 0.0);
}

#[test]
fn a_curved_section_keeps_its_plane_and_its_curve() {
    // A segment of a circle of radius √(10² + 16²) above 20 m by 4 m.
    let radius = 356.0_f64.sqrt();
    let half = (10.0 / radius).asin();
    let segment = radius * radius * (half - half.sin() * half.cos());
    let curved = sound("hill_quad9.msh");
    assert_eq!((curved.dimension, curved.order), (2, 2));
    assert_relative_eq!(measure(&curved, "clay"), 80.0 + segment, max_relative = 2e-5);
    assert_relative_eq!(measure(&curved, "rock"), 120.0, max_relative = 1e-9);
    for side in boundary(&curved, "top") {
        for [x, _, z] in side_nodes(&curved, *side) {
            assert_relative_eq!((x - 10.0).hypot(z + 16.0), radius, max_relative = 1e-9);
        }
    }
    let straight = sound("hill_quad4.msh");
    assert_eq!(straight.order, 1);
    let missing = 80.0 + segment - measure(&straight, "clay");
    assert!(missing > 0.5 && missing < 3.0, "chords lie below the arc: {missing} m²");
    assert!(!straight.notes.iter().any(|note| note.contains("x–z")), "flat in y already");
}

#[test]
fn a_block_is_the_same_in_every_format() {
    let text = sound("block_hex8.msh");
    assert_eq!((text.dimension, text.order, text.material.len()), (3, 1, 4 * 2 * 3));
    assert_eq!(text.materials, ["rock", "clay"]);
    assert_relative_eq!(measure(&text, "rock"), 1200.0, max_relative = 1e-12);
    assert_relative_eq!(measure(&text, "clay"), 800.0, max_relative = 1e-12);
    for (name, z) in [("top", 0.0), ("bottom", -10.0), ("contact", -4.0)] {
        let sides = boundary(&text, name);
        assert_eq!(sides.len(), 8);
        let near = |p: &[f64; 3]| (p[2] - z).abs() < 1e-12;
        assert!(sides.iter().all(|side| side_nodes(&text, *side).iter().all(near)), "{name}");
    }
    let inner = "8 sides of boundaries lie between two elements";
    assert!(text.notes.iter().any(|note| note.starts_with(inner)), "{:?}", text.notes);
    for other in ["block_hex8_binary.msh", "block_hex8_parametric.msh", "block_hex8_22.msh"] {
        let other = sound(other);
        assert_same(&other, &text);
    }
}

#[test]
fn second_order_hexahedra_are_those_of_first_order_with_nodes_between() {
    let (first, second) = (sound("block_hex8.msh"), sound("block_hex27.msh"));
    assert_eq!(second.order, 2);
    assert_relative_eq!(measure(&second, "clay"), 800.0, max_relative = 1e-12);
    for (corners, nodes) in first.elements.chunks_exact(8).zip(second.elements.chunks_exact(27)) {
        for node in 0..27 {
            let digits = [node % 3, node / 3 % 3, node / 9];
            let mut place = [0.0; 3];
            for (corner, number) in corners.iter().enumerate() {
                let weight: f64 = (0..3)
                    .map(|a| {
                        let high = digits[a] as f64 / 2.0;
                        if corner >> a & 1 == 1 { high } else { 1.0 - high }
                    })
                    .product();
                (0..3).for_each(|c| place[c] += weight * first.nodes[*number as usize][c]);
            }
            let found = second.nodes[nodes[node] as usize];
            (0..3).for_each(|c| assert_relative_eq!(found[c], place[c], epsilon = 1e-9));
        }
    }
}

#[test]
fn curved_hexahedra_follow_the_ring() {
    let exact = 0.25 * std::f64::consts::PI * (64.0 - 16.0) * 3.0;
    let straight = sound("ring_hex8.msh");
    // Three trapezia of 30 degrees.
    assert_relative_eq!(measure(&straight, "ring"), 3.0 * 0.5 * 0.5 * 48.0 * 3.0, max_relative = 1e-9);
    for name in ["ring_hex27.msh", "ring_hex27_22_binary.msh"] {
        let curved = sound(name);
        assert_relative_eq!(measure(&curved, "ring"), exact, max_relative = 2e-4);
        let sides = boundary(&curved, "outer");
        assert_eq!(sides.len(), 3);
        for place in sides.iter().flat_map(|side| side_nodes(&curved, *side)) {
            assert_relative_eq!(place[0].hypot(place[1]), 8.0, max_relative = 1e-9);
        }
    }
}

#[test]
fn tags_may_be_sparse_and_in_any_order_and_unused_nodes_go() {
    let plain = Draft::default().cubes([0.0; 3], [2, 1, 1], 1.0, 1).soil(3);
    let expected = plain.read().unwrap();
    let far = |tag: u64| tag * 1_000_003 + 5_000_000_000;
    let mut sparse = plain.clone();
    sparse.nodes.iter_mut().for_each(|(tag, _)| *tag = far(*tag));
    sparse.elements.iter_mut().for_each(|(tag, _, _, nodes)| {
        *tag = far(*tag);
        nodes.iter_mut().for_each(|node| *node = far(*node));
    });
    let found = sparse.read().unwrap();
    assert_same(&found, &expected);
    assert_eq!(found.tags, expected.tags.iter().map(|tag| far(*tag)).collect::<Vec<_>>());

    let mut shuffled = plain.node(900, [0.5, f64::NAN, 0.5]).node(901, [0.0, 0.0, 0.0]);
    shuffled.nodes.reverse();
    let found = shuffled.read().unwrap();
    assert_eq!(found.nodes.len(), 12);
    assert_relative_eq!(measure(&found, "soil"), 2.0, max_relative = 1e-14);
    assert!(found.notes.iter().any(|note| note.starts_with("2 nodes")), "{:?}", found.notes);
}

#[test]
fn a_mock_up_and_a_basin_far_from_the_origin_are_sound() {
    let draft = Draft::default().cubes([0.0; 3], [2, 2, 2], 1.0, 1).soil(3);
    let plane = Draft::default().squares([0.0; 2], 2, 2, 1.0, 1).soil(2);
    for (size, far) in [(0.1, 0.0), (1e-5, 0.0), (5e3, 0.0), (0.1, 4.5e6)] {
        let mesh = draft.clone().moved(|p| p.map(|c| far + size * c)).read().unwrap();
        assert_relative_eq!(measure(&mesh, "soil"), (2.0 * size).powi(3), max_relative = 1e-6);
        let mesh = plane.clone().moved(|[x, y, _]| [far + size * x, far + size * y, 0.0]).read().unwrap();
        assert_relative_eq!(measure(&mesh, "soil"), (2.0 * size).powi(2), max_relative = 1e-6);
    }
    // A layer a thousand times wider than high, beside cubes.
    let flat = draft.moved(|[x, y, z]| [1000.0 * x, 1000.0 * y, z]).read().unwrap();
    assert_relative_eq!(measure(&flat, "soil"), 8e6, max_relative = 1e-12);
}

#[test]
fn groups_of_one_name_are_one_material_or_boundary() {
    let mut draft = Draft::default().squares([0.0; 2], 2, 1, 1.0, 1).soil(2).name(2, 5, "soil");
    draft = draft.name(1, 3, "edge").name(1, 4, "edge").element(1, 1, 3, &[1, 2]).element(2, 1, 4, &[4, 1]);
    // Given twice, once the other way round, and once in no group at all.
    draft = draft.element(3, 1, 4, &[1, 4]).element(4, 1, 0, &[2, 3]);
    draft.elements[1].2 = 5;
    // A point with a name has no part in the mesh, and that is said.
    draft = draft.name(0, 1, "station").element(5, 15, 1, &[5]);
    let mesh = draft.read().unwrap();
    assert!(mesh.notes.iter().any(|note| note.contains("\"station\"")), "{:?}", mesh.notes);
    assert_eq!((mesh.materials.len(), mesh.boundaries.len()), (1, 1));
    assert_eq!(boundary(&mesh, "edge"), [(0, 0), (0, 2)]);
}

#[test]
fn line_ends_sections_and_names_of_all_kinds_are_read() {
    let mesh = Draft::default().squares([0.0; 2], 2, 1, 1.0, 1).soil(2);
    let text = mesh.text();
    let expected = mesh.read().unwrap();
    let windows = read_bytes(text.replace('\n', "\r\n").as_bytes()).unwrap();
    assert_same(&windows, &expected);
    let data = "$Comments\nby hand\n$EndComments\n";
    let more = format!("{data}{text}$NodeData\n1\n\"u\"\n1\n0.0\n0\n$EndNodeData\n\n");
    assert_same(&read_bytes(more.as_bytes()).unwrap(), &expected);
    let named = text.replace("\"soil\"", "\"sandy clay, 2° \"");
    assert_eq!(read_bytes(named.as_bytes()).unwrap().materials, ["sandy clay, 2°"]);
}
