//! What a box and a mesh are refused for.

use super::two_layers;
use hati_sem::SemError;
use hati_sem::mesh::{BoxLayer, HeightGrid, LayeredBox, Mesh, Side, check};

#[test]
fn topography_is_refused_where_it_crushes_the_layer_or_is_missing() {
    let layers = [BoxLayer::with_height("soft", 4.0, 2.0), BoxLayer::with_height("stiff", 6.0, 3.0)];
    let mesh = |height: &dyn Fn(f64, f64) -> f64, moved_layers| {
        LayeredBox {
            dimension: 3,
            x: (0.0, 10.0),
            y: (0.0, 10.0),
            layers: &layers,
            element_width: 1.0,
            topography: Some(height),
            moved_layers,
            order: 1,
        }
        .mesh()
    };
    let valley = |x: f64, y: f64| if (x, y) == (3.0, 7.0) { -3.3 } else { 0.0 };
    let error = mesh(&valley, 1).unwrap_err();
    let SemError::TopographyTooLow { x, y, height, floor, .. } = error else { panic!("{error}") };
    assert_eq!((x, y, height, floor), (3.0, 7.0, -3.3, -4.0));
    let deeper = mesh(&valley, 2).unwrap();
    check(&deeper, 4).unwrap();
    assert!(deeper.nodes.iter().all(|x| x[2] >= -10.0));
    let grid = HeightGrid::new([0.0, 0.0], [5.0, 2.5], [3, 4], vec![1.0; 12]).unwrap();
    let error = mesh(&|x, y| grid.height(x, y), 1).unwrap_err();
    assert!(matches!(error, SemError::TopographyMissing { y, .. } if y > 7.5), "{error}");
}

#[test]
fn bad_boxes_are_refused() {
    let good = [BoxLayer { name: "a".into(), thickness: 1.0, elements: 1 }];
    let thin = [BoxLayer::with_height("a", 0.0, 1.0)];
    let none = [BoxLayer::with_height("a", 1.0, f64::NAN)];
    let base = LayeredBox {
        dimension: 3,
        x: (0.0, 1.0),
        y: (0.0, 1.0),
        layers: &good,
        element_width: 0.5,
        topography: None,
        moved_layers: 1,
        order: 1,
    };
    assert!(base.mesh().is_ok());
    let refused = |b: LayeredBox| b.mesh().unwrap_err();
    assert!(matches!(refused(LayeredBox { dimension: 1, ..base }), SemError::Dimension(1)));
    assert!(matches!(refused(LayeredBox { order: 3, ..base }), SemError::GeometryOrder(3)));
    assert!(matches!(refused(LayeredBox { x: (1.0, 1.0), ..base }), SemError::BoxRange { axis: 'x', .. }));
    assert!(matches!(
        refused(LayeredBox { y: (0.0, f64::NAN), ..base }),
        SemError::BoxRange { axis: 'y', .. }
    ));
    assert!(matches!(refused(LayeredBox { element_width: -1.0, ..base }), SemError::ElementWidth(_)));
    assert!(matches!(refused(LayeredBox { element_width: 1e-9, ..base }), SemError::TooManyElements { .. }));
    assert!(matches!(
        refused(LayeredBox { element_width: 1e-300, ..base }),
        SemError::TooManyElements { .. }
    ));
    assert!(matches!(refused(LayeredBox { layers: &[], ..base }), SemError::ElementCounts { .. }));
    assert!(matches!(
        refused(LayeredBox { layers: &thin, ..base }),
        SemError::Material { key: "thickness", .. }
    ));
    assert!(matches!(
        refused(LayeredBox { layers: &none, ..base }),
        SemError::Material { key: "elements", .. }
    ));
}

/// Changes a sound mesh and returns what the check says.
fn fault(dimension: usize, order: usize, change: impl Fn(&mut Mesh)) -> SemError {
    let mut mesh = two_layers(dimension, order, 10.0);
    check(&mesh, 4).unwrap();
    change(&mut mesh);
    check(&mesh, 4).unwrap_err()
}

#[test]
fn lists_and_numbers_that_do_not_fit_are_refused() {
    assert!(matches!(fault(3, 1, |m| m.dimension = 1), SemError::Dimension(1)));
    assert!(matches!(fault(3, 1, |m| m.order = 3), SemError::GeometryOrder(3)));
    assert!(matches!(fault(3, 1, |m| m.order = 2), SemError::MeshLists { .. }));
    assert!(matches!(fault(3, 1, |m| m.material.clear()), SemError::MeshLists { elements: 0, .. }));
    assert!(matches!(
        fault(2, 1, |m| m.elements[9] = 9999),
        SemError::NodeIndex { element: 2, node: 9999, .. }
    ));
    assert!(matches!(fault(2, 1, |m| m.nodes[3][0] = f64::NAN), SemError::NodePosition { node: 3, .. }));
    assert!(matches!(fault(2, 1, |m| m.nodes[3][1] = 1.0), SemError::NodePosition { node: 3, .. }));
    assert!(matches!(
        fault(3, 2, |m| m.material[5] = 2),
        SemError::MaterialIndex { element: 5, material: 2, .. }
    ));
    let beyond = |m: &mut Mesh| m.boundaries[0].sides[0].element = 777;
    assert!(matches!(fault(3, 2, beyond), SemError::SideIndex { element: 777, .. }));
    let inside = |m: &mut Mesh| m.boundaries[0].sides.push(Side { element: 0, side: 1 });
    assert!(matches!(fault(3, 2, inside), SemError::BoundaryInside { element: 0, .. }));
    assert!(matches!(check(&two_layers(2, 1, 1.0), 11), Err(SemError::Order(11))));
}

#[test]
fn an_element_turned_inside_out_is_named_with_its_place() {
    for (dimension, order) in [(2, 1), (2, 2), (3, 1), (3, 2)] {
        for scale in [0.01, 1e3] {
            let mut mesh = two_layers(dimension, order, 10.0 * scale);
            // the first interior corner is pulled through the opposite corner of element 0
            let corner = mesh.corners(0).last().unwrap();
            let first = mesh.nodes[mesh.element(0)[0] as usize];
            let place = mesh.nodes[corner as usize];
            mesh.nodes[corner as usize] = [0, 1, 2].map(|i| first[i] - 0.3 * (place[i] - first[i]));
            let error = check(&mesh, 4).unwrap_err();
            let SemError::Jacobian { element, centre, value } = error else { panic!("{error}") };
            assert_eq!((element, centre), (0, mesh.centre(0)));
            assert!(value < 0.0);
        }
    }
    // mirrored, and collapsed to a wedge
    assert!(
        matches!(fault(2, 1, |m| m.deform(|[x, y, z]| [-x, y, z])), SemError::Jacobian { value, .. } if value < 0.0)
    );
    let wedge = |m: &mut Mesh| m.nodes[1] = m.nodes[0];
    assert!(matches!(fault(3, 1, wedge), SemError::Jacobian { element: 0, .. }));
    // sound at its corners, folded between them: only the points inside can tell
    let folded = |m: &mut Mesh| {
        let middle = m.element(0)[4] as usize;
        m.nodes[middle][0] += 2.2;
    };
    assert!(matches!(fault(2, 2, folded), SemError::Jacobian { element: 0, .. }));
}

/// Adds an element of the first material.
fn append(mesh: &mut Mesh, nodes: &[u32]) {
    mesh.elements.extend_from_slice(nodes);
    mesh.material.push(0);
}

#[test]
fn sides_that_do_not_fit_are_refused() {
    for dimension in [2, 3] {
        let twice = |m: &mut Mesh| {
            let nodes = m.element(0).to_vec();
            append(m, &nodes);
        };
        // the copy of an element at a corner shares its outer sides with the element, its inner ones with a third
        assert!(matches!(
            fault(dimension, 1, twice),
            SemError::SideShared { .. } | SemError::ElementsOverlap { .. }
        ));
        let third = |m: &mut Mesh| {
            // on the inner side of element 0 towards +x a further element is set, somewhere else
            let mut nodes = m.element(0).to_vec();
            for k in (0..nodes.len()).filter(|k| k % 2 == 0) {
                let mut x = m.nodes[nodes[k] as usize];
                x[0] -= 0.1;
                nodes[k] = m.nodes.len() as u32;
                m.nodes.push(x);
            }
            append(m, &nodes);
        };
        let error = fault(dimension, 1, third);
        assert!(matches!(&error, SemError::SideShared { elements, .. } if elements.len() == 3), "{error}");
    }
    let alone = |m: &mut Mesh| {
        // two elements in the same place, with no neighbour
        m.elements.truncate(8);
        m.material.truncate(1);
        m.boundaries.clear();
        let nodes = m.element(0).to_vec();
        append(m, &nodes);
    };
    assert!(matches!(fault(3, 1, alone), SemError::ElementsOverlap { elements: [0, 1], .. }));
    let middle = |m: &mut Mesh| {
        // element 0 takes a copy of a node between the corners of its side towards +x
        let node = m.element(0)[5];
        m.nodes.push(m.nodes[node as usize]);
        m.elements[5] = m.nodes.len() as u32 - 1;
    };
    assert!(matches!(fault(3, 2, middle), SemError::SideTwisted { .. }));
}

#[test]
fn blocks_that_touch_without_sharing_nodes_are_refused() {
    for (dimension, order) in [(2, 1), (3, 1), (3, 2)] {
        for scale in [0.01, 1e3] {
            // the same place, nodes of its own: a second block beside the first, equal or finer
            for width in [0.26, 0.13] {
                let mut mesh = two_layers(dimension, order, scale);
                let layers = [BoxLayer::with_height("soft", scale, 0.26 * width * scale)];
                let second = LayeredBox {
                    dimension,
                    x: (0.5 * scale, 1.0 * scale),
                    y: (0.0, 0.8 * scale),
                    layers: &layers,
                    element_width: width * scale,
                    topography: None,
                    moved_layers: 1,
                    order,
                }
                .mesh()
                .unwrap();
                let shift = mesh.nodes.len() as u32;
                mesh.nodes.extend(&second.nodes);
                mesh.elements.extend(second.elements.iter().map(|n| n + shift));
                mesh.material.extend(&second.material);
                let error = check(&mesh, 4).unwrap_err();
                let SemError::SidesUnmatched { centre, .. } = error else { panic!("{error}") };
                assert!((centre[0] - 0.5 * scale).abs() < 1e-12 * scale);
                // apart, the two blocks are sound
                for x in &mut mesh.nodes[shift as usize..] {
                    x[0] += 0.01 * scale;
                }
                check(&mesh, 4).unwrap();
            }
        }
    }
}
