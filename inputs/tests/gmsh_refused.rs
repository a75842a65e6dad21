//! Meshes that cannot be computed with: each is refused with the element, its place and the reason.

mod gmsh;

use gmsh::{Draft, fault, fixture, read_bytes};
use hati_inputs::InputError;
use hati_inputs::gmsh::{MeshFault, read};

fn two_by_two() -> Draft {
    Draft::default().squares([0.0; 2], 2, 2, 1.0, 1).soil(2)
}

/// Text of the refusal of the file as a whole.
fn refused(bytes: &[u8]) -> String {
    match read_bytes(bytes) {
        Err(error @ InputError::MeshRefused { .. }) => error.to_string(),
        other => panic!("expected a refusal, found {other:?}"),
    }
}

/// Text of the refusal of a damaged file.
fn broken(bytes: &[u8]) -> String {
    match read_bytes(bytes) {
        Err(error @ InputError::MeshBroken { .. }) => error.to_string(),
        other => panic!("expected a damaged file, found {other:?}"),
    }
}

// ---- shapes and orders --------------------------------------------------------------------------

#[test]
fn simplices_are_refused_with_the_advice_to_recombine() {
    for (name, kind) in [("refused_tetrahedra.msh", "tetrahedron"), ("refused_triangles.msh", "triangle")] {
        let error = read(&fixture(name)).unwrap_err().to_string();
        assert!(error.contains(kind) && error.contains("help: recombine"), "{error}");
        assert!(error.contains("(the first of "), "{error}");
    }
    let (prism, pyramid) = (&[1, 2, 4, 10, 11, 13], &[1, 2, 5, 4, 10]);
    let cubes = Draft::default().cubes([0.0; 3], [2, 2, 2], 1.0, 1).soil(3);
    let (tag, centre, found) = cubes.clone().element(77, 6, 1, prism).fault();
    assert_eq!((tag, centre[2]), (77, 0.5));
    assert!(matches!(found, MeshFault::Shape { kind, expected: "hexahedra" } if kind == "6-node prism"));
    let (tag, _, found) = cubes.element(78, 7, 1, pyramid).fault();
    assert_eq!(tag, 78);
    assert!(matches!(found, MeshFault::Shape { kind, .. } if kind == "5-node pyramid"));
}

#[test]
fn incomplete_mixed_and_high_orders_are_refused() {
    for name in ["refused_quad8.msh", "refused_hex20.msh"] {
        let (.., found) = fault(read(&fixture(name)));
        assert!(matches!(found, MeshFault::Serendipity { .. }), "{found:?}");
    }
    let (.., found) = fault(read(&fixture("refused_order3.msh")));
    assert!(matches!(found, MeshFault::Order { order: 3, .. }));
    let nine: Vec<u64> = (1..=9).collect();
    let (tag, centre, found) = two_by_two().element(50, 10, 1, &nine).fault();
    assert_eq!(tag, 50);
    assert!(centre.iter().all(|c| c.is_finite()));
    assert!(matches!(found, MeshFault::MixedOrders { first, .. } if first == "4-node quadrilateral"));
}

// ---- groups ---------------------------------------------------------------------------------------

#[test]
fn every_element_needs_one_named_group() {
    let mut none = two_by_two();
    none.elements.iter_mut().for_each(|(_, _, group, _)| *group = 0);
    assert!(refused(none.text().as_bytes()).contains("Physical Surface(\"clay\") = {1};"));
    let error = read(&fixture("refused_no_groups.msh")).unwrap_err().to_string();
    assert!(error.contains("no surface belongs to a physical group"), "{error}");
    let mut cubes = Draft::default().cubes([0.0; 3], [1, 1, 1], 1.0, 1);
    cubes.elements[0].2 = 0;
    assert!(refused(cubes.text().as_bytes()).contains("Physical Volume(\"clay\") = {1};"));

    let mut some = two_by_two();
    (some.elements[1].2, some.elements[3].2) = (0, 0);
    assert_eq!(some.fault(), (1002, [1.5, 0.5, 0.0], MeshFault::NoGroup));
    let text = some.read().unwrap_err().to_string();
    assert!(text.contains("element 1002 at (1.5, 0.5, 0) (the first of 2): belongs to no"), "{text}");

    let mut unnamed = two_by_two();
    unnamed.elements[2].2 = 8;
    let found = MeshFault::UnnamedGroup { dimension: 2, group: 8 };
    assert_eq!(unnamed.fault(), (1003, [0.5, 1.5, 0.0], found));
    let empty = two_by_two().text().replace("\"soil\"", "\"\"");
    assert!(matches!(fault(read_bytes(empty.as_bytes())).2, MeshFault::UnnamedGroup { .. }));
    let edge = two_by_two().element(5, 1, 6, &[1, 2]);
    assert_eq!(edge.fault(), (5, [0.5, 0.0, 0.0], MeshFault::UnnamedGroup { dimension: 1, group: 6 }));
}

#[test]
fn two_materials_on_one_part_are_refused() {
    // The groups of an entity stand in $Entities; group 3 of the surface becomes two.
    let text = std::fs::read_to_string(fixture("section_quad4.msh")).unwrap();
    let at = text.lines().position(|line| line == "$Entities").unwrap();
    let entities = |dimension: usize| -> usize {
        text.lines().nth(at + 1).unwrap().split_whitespace().nth(dimension).unwrap().parse().unwrap()
    };
    let surface = at + 2 + entities(0) + entities(1) + 1;
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let line = lines[surface].clone();
    assert!(line.starts_with("2 ") && line.contains(" 1 3 "), "{line}");
    lines[surface] = line.replace(" 1 3 ", " 2 3 7 ");
    let (.., found) = fault(read_bytes((lines.join("\n") + "\n").as_bytes()));
    assert_eq!(found, MeshFault::SeveralMaterials { names: "clay, rock".into() });
    // In MSH 2.2 such an element is given twice.
    let twice = two_by_two().name(2, 2, "rock").element(99, 3, 2, &[1, 2, 5, 4]);
    let found = read_bytes(twice.text().as_bytes());
    assert!(matches!(fault(found).2, MeshFault::Overlap { .. }));
}

#[test]
fn a_mesh_without_ground_says_so() {
    let error = read(&fixture("refused_only_boundary.msh")).unwrap_err().to_string();
    assert!(error.contains("Physical Volume"), "{error}");
    let lines =
        Draft::default().node(1, [0.0; 3]).node(2, [1.0; 3]).name(1, 1, "line").element(1, 1, 1, &[1, 2]);
    assert!(refused(lines.text().as_bytes()).contains("no elements of a surface or volume"));
    // A plate that stands askew, and one in the plane y–z.
    let askew = two_by_two().moved(|[x, y, _]| [x, y, x + y]);
    assert!(refused(askew.text().as_bytes()).contains("not flat in z or y"));
    let across = two_by_two().moved(|[x, y, _]| [0.0, x, y]);
    assert!(refused(across.text().as_bytes()).contains("not flat in z or y"));
}

// ---- geometry ---------------------------------------------------------------------------------------

#[test]
fn folded_collapsed_and_inverted_elements_are_refused() {
    let mut folded = two_by_two();
    folded.nodes[4].1 = [2.5, 2.5, 0.0];
    let (tag, centre, found) = folded.fault();
    assert!(matches!(found, MeshFault::Jacobian { value, .. } if value < 0.0), "{found:?}");
    assert!(tag > 1000 && centre[2] == 0.0);

    let mut collapsed = two_by_two();
    collapsed.elements[3].3 = vec![5, 6, 9, 9];
    let (tag, _, found) = collapsed.fault();
    assert_eq!(tag, 1004);
    assert!(matches!(found, MeshFault::Jacobian { value, .. } if value.abs() < 1e-12), "{found:?}");

    let mirrored = Draft::default().cubes([0.0; 3], [2, 1, 1], 0.1, 1).soil(3).moved(|[x, y, z]| [-x, y, z]);
    let (tag, centre, found) = mirrored.fault();
    assert_eq!((tag, found), (1001, MeshFault::Inverted));
    assert!((centre[0] + 0.05).abs() < 1e-15);
    let text = mirrored.read().unwrap_err().to_string();
    assert!(text.contains("(the first of 2)") && text.contains("reverse"), "{text}");

    // One corner of a small cube far from the origin pushed through the opposite face.
    let mut bad = Draft::default().cubes([1e6, 0.0, 0.0], [1, 1, 1], 0.1, 1).soil(3);
    bad.nodes[7].1 = [1e6 + 0.1, 0.1, -0.1];
    let (.., found) = bad.fault();
    assert!(matches!(found, MeshFault::Jacobian { at, .. } if at.len() == 3));
}

#[test]
fn curved_elements_are_checked_between_their_corners() {
    let node = |i: u64| [(i % 3) as f64, (i / 3) as f64, 0.0];
    let mut quad = Draft::default().soil(2).element(7, 10, 1, &[1, 3, 9, 7, 2, 6, 8, 4, 5]);
    quad.nodes = (0..9).map(|i| (i + 1, node(i))).collect();
    assert!(quad.read().is_ok());
    quad.nodes[1].1[0] = 0.3;
    assert!(matches!(quad.fault().2, MeshFault::Jacobian { .. }));
    quad.nodes[1].1[0] = 1.0;
    quad.nodes[4].1 = [1.0, 2.4, 0.0];
    assert!(matches!(quad.fault().2, MeshFault::Jacobian { .. }));
}

#[test]
fn coordinates_that_are_no_numbers_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
        let mut draft = two_by_two();
        draft.nodes[4].1[1] = bad;
        let text = broken(draft.text().as_bytes());
        assert!(text.contains("node 5: its coordinates are (1, "), "{text}");
    }
}

// ---- conformity ---------------------------------------------------------------------------------------

#[test]
fn parts_that_touch_without_sharing_nodes_are_refused() {
    let (tag, _, found) = fault(read(&fixture("refused_apart.msh")));
    let MeshFault::DuplicateNodes { at, .. } = found else { panic!("{found:?}") };
    assert!(tag > 0 && at[0] == 1.0, "{at:?}");

    for size in [1e-4, 1.0, 1e4] {
        let apart = Draft::default().cubes([0.0; 3], [2, 2, 2], size, 1).soil(3);
        let apart = apart.cubes([2.0 * size, 0.0, 0.0], [1, 2, 2], size, 5000);
        let (_, _, found) = apart.fault();
        assert!(matches!(found, MeshFault::DuplicateNodes { node: 3, .. }), "{found:?}");
        assert!(found.remedy().contains("Coherence"));
        // A gap of a thousandth of an element is a gap.
        let gap = Draft::default().cubes([0.0; 3], [2, 2, 2], size, 1).soil(3);
        let gap = gap.cubes([2.002 * size, 0.0, 0.0], [1, 2, 2], size, 5000);
        assert!(gap.read().is_ok());
    }
    let joined =
        Draft::default().squares([0.0; 2], 2, 2, 1.0, 1).soil(2).squares([2.0, 0.0], 2, 2, 1.0, 5000);
    assert!(joined.clone().joined().read().is_ok());
    assert!(matches!(joined.fault().2, MeshFault::DuplicateNodes { node: 3, other: 5000, .. }));
}

#[test]
fn second_order_sides_share_the_nodes_between_their_corners_too() {
    let node = |i: u64| [(i % 5) as f64, (i / 5) as f64, 0.0];
    let mut draft = Draft::default().soil(2);
    draft.nodes = (0..15).map(|i| (i + 1, node(i))).collect();
    draft = draft.element(1, 10, 1, &[1, 3, 13, 11, 2, 8, 12, 6, 7]);
    draft = draft.element(2, 10, 1, &[3, 5, 15, 13, 4, 10, 14, 8, 9]);
    assert!(draft.read().is_ok());
    let mut apart = draft.node(20, [2.0, 1.0, 0.0]);
    apart.elements[1].3[7] = 20;
    let (tag, _, found) = apart.fault();
    assert_eq!(tag, 1);
    assert!(matches!(found, MeshFault::DuplicateNodes { node: 8, other: 20, .. }), "{found:?}");
}

#[test]
fn hanging_nodes_are_refused_in_a_section() {
    for size in [1e-4, 1.0, 1e4] {
        // One column of large squares beside two of half their size.
        let draft = Draft::default().squares([0.0; 2], 1, 2, size, 1).soil(2);
        let draft = draft.squares([size, 0.0], 2, 4, 0.5 * size, 5000);
        let joined = draft.moved(|p| p.map(|c| c / size)).joined().moved(|p| p.map(|c| c * size));
        let (tag, centre, found) = joined.fault();
        let MeshFault::HangingNode { at, .. } = found else { panic!("{found:?}") };
        assert_eq!((tag, at), (1001, [size, 0.5 * size, 0.0]));
        assert_eq!(centre, [0.5 * size, 0.5 * size, 0.0]);
    }
}

#[test]
fn hanging_nodes_are_refused_in_a_volume() {
    // The finer block halved in one direction, in all, and in thirds.
    for n in [[2, 4, 2], [2, 4, 4], [3, 6, 6]] {
        let coarse = Draft::default().cubes([0.0; 3], [1, 2, 2], 1.0, 1).soil(3);
        let fine = Draft::default().cubes([0.0; 3], n, 1.0, 5000);
        let parts = n.map(|n| n as f64);
        let fine = fine.moved(|[x, y, z]| [1.0 + x / parts[0], 2.0 * y / parts[1], 2.0 * z / parts[2]]);
        let (tag, _, found) = coarse.with(fine).joined().fault();
        assert!(matches!(found, MeshFault::HangingNode { .. }), "{found:?}");
        assert!((1001..1005).contains(&tag), "the coarser element: {tag}");
    }
}

#[test]
fn the_middle_of_a_second_order_side_is_no_corner_of_others() {
    // One element of 2 m beside two of 1 m, whose common corner is the middle of its side.
    let square = |x: f64, y: f64, size: f64, first: u64| {
        let at = |i: f64, j: f64| [x + 0.5 * size * i, y + 0.5 * size * j, 0.0];
        let places = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)];
        let mut draft = Draft::default();
        for (tag, (i, j)) in (first..).zip(places) {
            draft = draft.node(tag, at(f64::from(i), f64::from(j)));
        }
        draft.element(first + 1000, 10, 1, &(first..first + 9).collect::<Vec<_>>())
    };
    let draft = square(0.0, 0.0, 2.0, 1).soil(2);
    let draft = draft.with(square(2.0, 0.0, 1.0, 100)).with(square(2.0, 1.0, 1.0, 200)).joined();
    let (tag, _, found) = draft.fault();
    assert!(
        matches!(found, MeshFault::HangingNode { node: 6, at: [2.0, 1.0, 0.0] }) && tag == 1001,
        "{found:?}"
    );
}

#[test]
fn hanging_nodes_on_a_bent_interface_are_found_by_their_edges() {
    // A coarse row outside a circle, a fine one inside: the hanging nodes lie on the circle, 2 % of an
    // element off the coarse chords.
    let ring = |inner: f64, outer: f64, parts: u64, first: u64| {
        Draft::default().squares([0.0; 2], parts, 1, 1.0, first).moved(|[x, y, _]| {
            let angle = x / parts as f64;
            let radius = inner + y * (outer - inner);
            [radius * angle.sin(), radius * angle.cos(), 0.0]
        })
    };
    let (fine, coarse) = (ring(5.0, 6.0, 12, 1), ring(6.0, 7.0, 6, 5000));
    let (tag, _, found) = fine.soil(2).with(coarse).joined().fault();
    assert!(matches!(found, MeshFault::HangingNode { .. }) && tag >= 5000, "{tag} {found:?}");
}

#[test]
fn sound_surfaces_have_no_hanging_nodes() {
    // A trench, steps, a tunnel, a corner at which two blocks touch along one shared edge.
    let mut trench = Draft::default().cubes([0.0; 3], [4, 3, 3], 1.0, 1).soil(3);
    trench.elements.retain(|(tag, ..)| ![1001 + 1 + 4 + 12, 1001 + 2 + 4 + 24, 1001].contains(tag));
    trench.elements.retain(|(tag, ..)| ![1001 + 1 + 4, 1001 + 1 + 4 + 24].contains(tag));
    assert!(trench.read().is_ok(), "{:?}", trench.read());
    let mut corner = Draft::default().squares([0.0; 2], 2, 2, 1.0, 1).soil(2);
    corner.elements.retain(|(tag, ..)| ![1002, 1003].contains(tag));
    assert!(corner.read().is_ok());
    // A fan of thin wedges around a hole, very different sizes side by side.
    let graded = Draft::default().squares([0.0; 2], 30, 4, 1.0, 1).soil(2);
    let graded = graded.moved(|[x, y, _]| [1.6_f64.powf(x), y * 0.1 * 1.6_f64.powf(x), 0.0]);
    assert!(graded.read().is_ok(), "{:?}", graded.read());
}

#[test]
fn a_third_element_on_one_side_is_refused() {
    let draft = two_by_two().node(60, [1.7, -0.5, 0.0]).node(61, [1.9, 0.7, 0.0]);
    let overlapping = draft.element(1070, 3, 1, &[2, 60, 61, 5]);
    let (.., found) = overlapping.fault();
    assert!(matches!(found, MeshFault::Overlap { other: 1070 }), "{found:?}");
}

#[test]
fn boundaries_are_sides_of_elements() {
    let named = || two_by_two().name(1, 4, "top");
    let off = named().element(9, 1, 4, &[7, 8]).element(10, 1, 4, &[1, 5]);
    let found = MeshFault::OffSide { boundary: "top".into(), kind: "2-node line".into() };
    assert_eq!(off.fault(), (10, [0.5, 0.5, 0.0], found));
    let apart = named().node(90, [0.0, 5.0, 0.0]).element(11, 1, 4, &[7, 90]);
    assert!(matches!(apart.fault(), (11, _, MeshFault::OffSide { .. })));
    let cubes = Draft::default().cubes([0.0; 3], [1, 1, 1], 1.0, 1).soil(3).name(2, 2, "top");
    assert!(cubes.clone().element(12, 3, 2, &[5, 6, 8, 7]).read().is_ok());
    let triangle = cubes.element(13, 2, 2, &[5, 6, 8]).fault();
    assert!(matches!(triangle, (13, _, MeshFault::OffSide { kind, .. }) if kind == "3-node triangle"));
}

// ---- files ------------------------------------------------------------------------------------------

#[test]
fn other_files_are_told_by_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(matches!(read(&at("none.msh")), Err(InputError::RecordMissing { .. })));
    assert!(matches!(read(folder.path()), Err(InputError::MeshRefused { .. })));
    std::fs::write(at("empty.msh"), "").unwrap();
    assert!(matches!(read(&at("empty.msh")), Err(InputError::RecordEmpty { .. })));
    std::fs::write(at("model.geo"), "Point(1) = {0, 0, 0};").unwrap();
    assert!(read(&at("model.geo")).unwrap_err().to_string().contains("a program for Gmsh"));
    assert!(refused(b"solid cube\n").contains("is no MSH file; it begins with \"solid cube\""));
    for (name, version) in [("refused_version_40.msh", "4"), ("refused_version_1.msh", "1")] {
        let error = read(&fixture(name)).unwrap_err().to_string();
        assert!(error.contains(&format!("is MSH version {version}")), "{error}");
    }
    let error = read(&fixture("refused_partitioned.msh")).unwrap_err().to_string();
    assert!(error.contains("partitioned"), "{error}");
    assert!(refused(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$ParametricNodes\n").contains("parametric"));
}

#[test]
fn binary_numbers_of_other_machines_are_refused() {
    let sound = std::fs::read(fixture("block_hex8_binary.msh")).unwrap();
    let at = sound.iter().position(|byte| *byte == b'\n').unwrap() + "4.1 1 8\n".len() + 1;
    assert_eq!(sound[at..at + 4], 1_i32.to_ne_bytes());
    let mut other = sound.clone();
    other[at..at + 4].reverse();
    assert!(refused(&other).contains("byte order"));
    let mut small = sound.clone();
    small[at - 2] = b'4';
    assert!(refused(&small).contains("binary numbers of \"4\" bytes"));
    let mut odd = sound;
    odd[at] = 9;
    assert!(broken(&odd).contains("byte order"));
}

#[test]
fn a_file_cut_off_anywhere_is_refused() {
    for name in
        ["section_quad4.msh", "section_quad4_22_binary.msh", "block_hex8_binary.msh", "ring_hex27.msh"]
    {
        let sound = std::fs::read(fixture(name)).unwrap();
        for length in (1..sound.trim_ascii_end().len()).step_by(17) {
            let error = read_bytes(&sound[..length]).unwrap_err();
            let told = matches!(error, InputError::MeshBroken { .. } | InputError::MeshRefused { .. });
            assert!(told, "{name} cut at {length}: {error}");
        }
    }
}

#[test]
fn wrong_counts_are_told_with_their_place() {
    let text = two_by_two().text();
    let fewer = broken(text.replace("$Nodes\n9\n", "$Nodes\n8\n").as_bytes());
    assert!(
        fewer.contains("line 17 (in $Nodes): expected $EndNodes") && fewer.contains("found \"9\""),
        "{fewer}"
    );
    let more = broken(text.replace("$Nodes\n9\n", "$Nodes\n10\n").as_bytes());
    assert!(more.contains("expected a number that is not negative, found \"$EndNodes\""), "{more}");
    let more = broken(text.replace("$Elements\n4\n", "$Elements\n5\n").as_bytes());
    assert!(more.contains("line 26 (in $Elements)"), "{more}");
    let strange = broken(text.replace("1001 3 2", "1001 333 2").as_bytes());
    assert!(strange.contains("element type \"333\" is not known"), "{strange}");
    let missing = broken(text.replace("1 2 5 4", "1 2 5 44").as_bytes());
    assert!(missing.contains("element 1001: names node 44"), "{missing}");
    let twice = broken(text.replace("\n4 0 1 0\n", "\n3 0 1 0\n").as_bytes());
    assert!(twice.contains("node 3: is given twice"), "{twice}");
    assert!(broken(text.replace("$EndNodes", "$EndNode").as_bytes()).contains("$EndNode"));
    assert!(
        broken(text.replace("$Elements", "$Element").replace("$EndElements", "$EndElement").as_bytes())
            .contains("ends without $Elements")
    );
}

#[test]
fn counts_beyond_the_file_ask_for_no_memory() {
    let text = two_by_two().text();
    for huge in ["9000000000", "18446744073709551615", "123456"] {
        let nodes = broken(text.replace("$Nodes\n9\n", &format!("$Nodes\n{huge}\n")).as_bytes());
        assert!(nodes.contains(huge) && nodes.contains("more than the file can hold"), "{nodes}");
        let elements = broken(text.replace("$Elements\n4\n", &format!("$Elements\n{huge}\n")).as_bytes());
        assert!(elements.contains("more than the file can hold"), "{elements}");
    }
    let tags = broken(text.replace("1001 3 2 1", "1001 3 2000000000 1").as_bytes());
    assert!(tags.contains("more than the file can hold"), "{tags}");
    let section = std::fs::read_to_string(fixture("section_quad4.msh")).unwrap();
    let blocks = section.find("$Nodes\n").unwrap() + 7;
    let mut many = section.clone();
    many.insert_str(blocks, "77777777");
    assert!(broken(many.as_bytes()).contains("more than the file can hold"));
}
