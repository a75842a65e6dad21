//! Finding points and the surface.

use super::{Numbers, bent, distance, two_layers};
use hati_sem::SemError;
use hati_sem::mesh::{BoxLayer, LayeredBox, Located, Locator, Side, Surface, check};

#[test]
fn ten_thousand_points_are_found() {
    for (dimension, order) in [(2, 1), (2, 2), (3, 1), (3, 2)] {
        for scale in [0.1, 1e4] {
            let mut mesh = two_layers(dimension, order, scale);
            mesh.move_interior_nodes(0.15, 1);
            bent(&mut mesh, scale);
            check(&mesh, 5).unwrap();
            let locator = Locator::new(&mesh);
            let mut numbers = Numbers(9);
            for _ in 0..10_000 {
                let element = numbers.below(mesh.len());
                let local = numbers.local(dimension, 0.999_999);
                let asked = mesh.position(element, local);
                let found = locator.find(asked).unwrap();
                assert_eq!(found.element, element);
                assert!(distance(found.local, local) < 1e-11);
                assert!(distance(found.position, asked) < 1e-12 * scale);
            }
        }
    }
}

#[test]
fn a_shared_point_belongs_to_the_lowest_element() {
    for (dimension, order) in [(2, 1), (3, 1), (3, 2)] {
        let mut mesh = two_layers(dimension, order, 1.0);
        mesh.move_interior_nodes(0.15, 1);
        let locator = Locator::new(&mesh);
        for (node, &x) in mesh.nodes.iter().enumerate() {
            let lowest = (0..mesh.len()).find(|&e| mesh.element(e).contains(&(node as u32))).unwrap();
            let found = locator.find(x).unwrap();
            assert_eq!(found.element, lowest, "node {node}");
            assert!(distance(found.position, x) < 1e-13);
        }
    }
}

#[test]
fn points_outside_are_named_with_their_distance() {
    for scale in [0.1, 1e4] {
        let mut mesh = two_layers(3, 2, scale);
        let locator = Locator::new(&mesh);
        let near = locator.find([0.1 * scale, 0.3 * scale, 1e-9 * scale]).unwrap();
        assert_eq!(near.position[2], 0.0);
        assert!((near.position[0] - 0.1 * scale).abs() < 1e-12 * scale);
        let error = locator.find([0.9 * scale, 0.3 * scale, 0.3 * scale]).unwrap_err();
        let SemError::OutsideMesh { distance: d, nearest, min, max, .. } = error else { panic!("{error}") };
        assert!((d - 0.5 * scale).abs() < 1e-9 * scale, "{d}");
        assert!(distance(nearest, [0.5 * scale, 0.3 * scale, 0.0]) < 1e-9 * scale);
        assert_eq!((min, max), ([-0.5 * scale, 0.0, -scale], [0.5 * scale, 0.8 * scale, 0.0]));
        assert!(locator.find([f64::NAN, 0.0, 0.0]).is_err());
        assert!(locator.find([0.0, 0.0, 1e-4 * scale]).is_err());
        // the same from a curved surface: a point along the normal, its foot and its distance come back
        bent(&mut mesh, scale);
        let locator = Locator::new(&mesh);
        let mut numbers = Numbers(2);
        for &side in &mesh.boundary("top").unwrap().sides {
            let local = mesh.side_local(side, [1.6 * numbers.next() - 0.8, 1.6 * numbers.next() - 0.8]);
            let foot = mesh.position(side.element as usize, local);
            let normal = mesh.side_normal(side, local);
            let length = distance(normal, [0.0; 3]);
            let d = 0.02 * scale;
            let point = [0, 1, 2].map(|i| foot[i] + d * normal[i] / length);
            let (found, away) = locator.nearest(point).unwrap();
            assert!((away - d).abs() < 1e-9 * scale, "{away} {d}");
            assert!(distance(found.position, foot) < 1e-6 * scale, "{:?} {foot:?}", found.position);
        }
    }
}

#[test]
fn the_surface_is_where_the_topography_says() {
    // a quadratic surface on one element row is met exactly by elements of order 2
    let height = |x: f64, y: f64| 0.02 * x * x - 0.01 * x * y + 0.3;
    let layers = [BoxLayer::with_height("soft", 4.0, 2.0), BoxLayer::with_height("stiff", 6.0, 3.0)];
    for dimension in [2, 3] {
        let mesh = LayeredBox {
            dimension,
            x: (-5.0, 5.0),
            y: (0.0, 8.0),
            layers: &layers,
            element_width: 2.1,
            topography: Some(&height),
            moved_layers: 1,
            order: 2,
        }
        .mesh()
        .unwrap();
        let report = check(&mesh, 5).unwrap();
        // elements under the flat interface keep their affine map
        assert_eq!(report.affine, mesh.len() / 2);
        let locator = Locator::new(&mesh);
        let mut numbers = Numbers(4);
        for _ in 0..500 {
            let (x, y) = (10.0 * numbers.next() - 5.0, 8.0 * numbers.next());
            let y = if dimension == 2 { 0.0 } else { y };
            let found = locator.find_on_surface(x, y).unwrap();
            assert!(distance(found.position, [x, y, height(x, y)]) < 1e-12, "{:?}", found.position);
            assert_eq!(found.local[dimension - 1], 1.0);
        }
        assert!(locator.find_on_surface(5.0 + 1e-9, 8.0).is_ok());
        let error = locator.find_on_surface(7.0, 0.0).unwrap_err();
        let SemError::OutsideBoundary { distance: d, .. } = error else { panic!("{error}") };
        assert!((d - 2.0).abs() < 1e-9);
        assert!(matches!(Surface::new(&mesh, "sea"), Err(SemError::NoBoundary { .. })));
        // flat below: every node at or under the interface keeps its level
        let below = mesh.nodes.iter().filter(|x| x[2] <= -4.0 + 1e-12);
        assert!(below.clone().count() > 0);
        below.for_each(|x| assert!([-4.0, -5.5, -7.0, -8.5, -10.0].iter().any(|z| (x[2] - z).abs() < 1e-12)));
    }
}

#[test]
fn the_highest_of_several_surfaces_is_taken() {
    // a bridge: a second block above the first, both in the boundary
    let mut mesh = two_layers(2, 1, 10.0);
    let shift = mesh.nodes.len() as u32;
    let count = mesh.len() as u32;
    let mut upper = mesh.clone();
    upper.deform(|[x, y, z]| [0.5 * x, y, z + 20.0]);
    mesh.nodes.extend(&upper.nodes);
    mesh.elements.extend(upper.elements.iter().map(|n| n + shift));
    mesh.material.extend(&upper.material);
    let raised: Vec<Side> = upper
        .boundary("top")
        .unwrap()
        .sides
        .iter()
        .map(|s| Side { element: s.element + count, ..*s })
        .collect();
    mesh.boundaries[0].sides.extend(raised);
    check(&mesh, 4).unwrap();
    let locator = Locator::new(&mesh);
    let height = |x| -> Located { locator.find_on_surface(x, 0.0).unwrap() };
    assert_eq!(height(1.0).position[2], 20.0);
    assert_eq!(height(4.0).position[2], 0.0);
}

#[test]
fn points_in_a_bulge_beyond_the_nodes_are_found() {
    // the top's nodes lie at 0, 0.38 and 0.4; the parabola through them rises to 0.4356 in between
    let bulge = |x: f64, _: f64| if x == 0.5 { 0.38 } else { 0.4 * x };
    for dimension in [2, 3] {
        let mesh = LayeredBox {
            dimension,
            x: (0.0, 1.0),
            y: (0.0, 1.0),
            layers: &[BoxLayer { name: "a".into(), thickness: 1.0, elements: 1 }],
            element_width: 1.0,
            topography: Some(&bulge),
            moved_layers: 1,
            order: 2,
        }
        .mesh()
        .unwrap();
        let locator = Locator::new(&mesh);
        let mut local = [5.0 / 9.0; 3];
        local[dimension - 1] = 1.0;
        let crest = mesh.position(0, local);
        assert!((crest[2] - (0.38 + 0.01 / 0.18)).abs() < 1e-12, "{crest:?}");
        let found = locator.find(crest).unwrap();
        assert!(distance(found.position, crest) < 1e-14);
        assert!(distance(locator.inside(crest).unwrap().position, crest) < 1e-14);
    }
}
