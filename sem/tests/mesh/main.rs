//! Meshes: volumes, maps and their inverses, finding points, what is refused.

mod locate;
mod refusals;

use hati_sem::SemError;
use hati_sem::gll::Gll;
use hati_sem::mesh::{
    BoxLayer, HeightGrid, LayeredBox, Mesh, Resolution, axes, check, determinant, element_width,
    layer_heights,
};
use hati_sem::soil::Layer;
use std::f64::consts::PI;

/// Two layers of 4 and 6 parts in 10, in units of `scale`, three or four elements a side.
fn two_layers(dimension: usize, order: usize, scale: f64) -> Mesh {
    let layers = [
        BoxLayer::with_height("soft", 0.4 * scale, 0.2 * scale),
        BoxLayer::with_height("stiff", 0.6 * scale, 0.3 * scale),
    ];
    LayeredBox {
        dimension,
        x: (-0.5 * scale, 0.5 * scale),
        y: (0.0, 0.8 * scale),
        layers: &layers,
        element_width: 0.26 * scale,
        topography: None,
        moved_layers: 1,
        order,
    }
    .mesh()
    .unwrap()
}

/// A map that bends every element and keeps D = 2 in its plane.
fn bent(mesh: &mut Mesh, scale: f64) {
    let plane = mesh.dimension == 2;
    mesh.deform(|[x, y, z]| {
        let (u, v, w) = (x / scale, y / scale, z / scale);
        let dy = if plane { 0.0 } else { 0.07 * (3.0 * u + 2.0 * w).sin() };
        [x + scale * 0.08 * (2.0 * v + 4.0 * w).sin(), y + scale * dy, z + scale * 0.09 * (3.0 * u + v).cos()]
    });
}

fn volume(mesh: &Mesh, order: usize) -> f64 {
    let gll = Gll::new(order).unwrap();
    let n = gll.len();
    let points = n.pow(mesh.dimension as u32);
    let mut sum = 0.0;
    for element in 0..mesh.len() {
        for k in 0..points {
            let (mut local, mut weight) = ([0.0; 3], 1.0);
            for a in 0..mesh.dimension {
                let i = k / n.pow(a as u32) % n;
                local[a] = gll.points[i];
                weight *= gll.weights[i];
            }
            sum += weight * determinant(&mesh.jacobian(element, local));
        }
    }
    sum
}

/// Deterministic numbers in [0, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }

    fn local(&mut self, dimension: usize, reach: f64) -> [f64; 3] {
        let mut local = [0.0; 3];
        (0..dimension).for_each(|a| local[a] = reach * (2.0 * self.next() - 1.0));
        local
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn the_box_has_its_layers_sides_and_counts() {
    for (dimension, order) in [(2, 1), (2, 2), (3, 1), (3, 2)] {
        let mesh = two_layers(dimension, order, 10.0);
        let deep = if dimension == 2 { 1 } else { 4 };
        assert_eq!(mesh.len(), 4 * deep * 4);
        assert_eq!(mesh.materials, ["soft", "stiff"]);
        for element in 0..mesh.len() {
            // interfaces on faces: the material is that of the centre's depth, for every element
            assert_eq!(mesh.material[element], u32::from(mesh.centre(element)[2] < -4.0));
            assert!(mesh.is_affine(element));
        }
        let report = check(&mesh, 5).unwrap();
        assert_eq!(report.affine, mesh.len());
        assert_eq!(report.unnamed_sides, 0);
        assert_eq!(mesh.boundaries.len(), 2 * dimension);
        assert_eq!((report.min[2], report.max[2]), (-10.0, 0.0));
        assert!((report.scaled_jacobian_min.value - 1.0).abs() < 1e-12);
        let long = report.edge_max.value;
        assert!((report.edge_min.value - 2.0).abs() < 1e-12 && (long - 3.0).abs() < 1e-12);
        for boundary in &mesh.boundaries {
            let (axis, value) = match boundary.name.as_str() {
                "top" => (2, 0.0),
                "bottom" => (2, -10.0),
                "x_min" => (0, -5.0),
                "x_max" => (0, 5.0),
                "y_min" => (1, 0.0),
                _ => (1, 8.0),
            };
            for &side in &boundary.sides {
                mesh.side_nodes(side).for_each(|n| assert_eq!(mesh.nodes[n as usize][axis], value));
                let normal = mesh.side_normal(side, mesh.side_local(side, [0.3, -0.2]));
                let outward = if value == 0.0 && axis == 2 || value > 0.0 { 1.0 } else { -1.0 };
                assert!(normal[axis] * outward > 0.0, "{} {normal:?}", boundary.name);
                assert!((0..3).all(|i| i == axis || normal[i].abs() < 1e-12));
            }
        }
    }
}

#[test]
fn volume_by_quadrature_is_exact_where_the_rule_is() {
    for (dimension, order) in [(2, 1), (2, 2), (3, 1), (3, 2)] {
        for scale in [0.1, 1e4] {
            let mut mesh = two_layers(dimension, order, scale);
            let exact = if dimension == 2 { scale * scale } else { 0.8 * scale.powi(3) };
            assert!((volume(&mesh, 1) / exact - 1.0).abs() < 1e-13);
            // the surface stays, and with it the volume; det J has degree 2 (order 1) or 5 in each direction
            mesh.move_interior_nodes(0.15, 7);
            let found = volume(&mesh, if order == 1 { 2 } else { 3 });
            assert!((found / exact - 1.0).abs() < 1e-13, "D = {dimension}, order {order}: {found} {exact}");
        }
    }
}

#[test]
fn curved_geometry_converges_to_the_annulus() {
    let exact = 0.75 * PI;
    for dimension in [2, 3] {
        for (order, least, most) in [(1, 1.9, 2.1), (2, 3.9, 4.2)] {
            let error = |n: usize| {
                let layers = [BoxLayer { name: "a".into(), thickness: 1.0, elements: n }];
                let mut mesh = LayeredBox {
                    dimension,
                    x: (0.0, 1.0),
                    y: (0.0, 1.0),
                    layers: &layers,
                    element_width: 0.5,
                    topography: None,
                    moved_layers: 1,
                    order,
                }
                .mesh()
                .unwrap();
                mesh.deform(|[x, y, z]| {
                    let (r, angle) = (1.0 + x, 0.5 * PI * (1.0 + z));
                    [r * angle.cos(), y, r * angle.sin()]
                });
                check(&mesh, 4).unwrap();
                (volume(&mesh, 4) - exact).abs()
            };
            let rate = (error(3) / error(6)).log2();
            assert!((least..most).contains(&rate), "D = {dimension}, order {order}: {rate}");
        }
    }
}

#[test]
fn jacobian_is_the_derivative_of_position() {
    for (dimension, order) in [(2, 1), (2, 2), (3, 1), (3, 2)] {
        let mut mesh = two_layers(dimension, order, 1.0);
        bent(&mut mesh, 1.0);
        let mut numbers = Numbers(3);
        for element in 0..mesh.len() {
            let local = numbers.local(dimension, 0.9);
            let jacobian = mesh.jacobian(element, local);
            for (a, &column) in axes(dimension).iter().enumerate() {
                let at = |h: f64| {
                    let mut l = local;
                    l[a] += h;
                    mesh.position(element, l)
                };
                let (plus, minus) = (at(1e-5), at(-1e-5));
                for i in 0..3 {
                    let slope = (plus[i] - minus[i]) / 2e-5;
                    assert!((slope - jacobian[i][column]).abs() < 1e-10);
                }
            }
            if dimension == 2 {
                assert_eq!([jacobian[1], jacobian.map(|r| r[1])], [[0.0, 1.0, 0.0]; 2]);
            }
        }
    }
}

#[test]
fn inverse_map_undoes_position_at_every_size() {
    for (dimension, order) in [(2, 1), (2, 2), (3, 1), (3, 2)] {
        for scale in [0.1, 1e4] {
            let mut mesh = two_layers(dimension, order, scale);
            mesh.move_interior_nodes(0.2, 11);
            bent(&mut mesh, scale);
            let mut numbers = Numbers(5);
            for round in 0..40 {
                for element in 0..mesh.len() {
                    let mut local = numbers.local(dimension, 1.0);
                    if round < 3 {
                        // corners and sides too
                        (0..dimension)
                            .for_each(|a| local[a] = if round == 2 { local[a] } else { local[a].signum() });
                        local[0] = local[0].signum();
                    }
                    let found = mesh.inverse_map(element, mesh.position(element, local)).unwrap();
                    assert!(
                        distance(found, local) < 1e-12,
                        "D = {dimension}, {scale} m: {found:?} {local:?}"
                    );
                }
            }
            assert_eq!(mesh.inverse_map(0, [f64::NAN, 0.0, 0.0]), None);
            assert_eq!(mesh.inverse_map(0, [5.0 * scale, 0.0, 0.0]), None);
        }
    }
}

#[test]
fn inverse_map_far_from_the_origin_is_as_good_as_the_coordinates() {
    let mut mesh = two_layers(3, 2, 10.0);
    bent(&mut mesh, 10.0);
    mesh.deform(|[x, y, z]| [x + 5e5, y + 4.6e6, z]);
    let mut numbers = Numbers(6);
    for element in 0..mesh.len() {
        let local = numbers.local(3, 1.0);
        let found = mesh.inverse_map(element, mesh.position(element, local)).unwrap();
        assert!(distance(found, local) < 2e-9, "{found:?} {local:?}");
    }
    let affine = {
        let mut mesh = two_layers(3, 1, 3.7);
        mesh.deform(|[x, y, z]| [x + 0.3 * y - 0.1 * z + 5e5, y + 0.2 * z + 4.6e6, z + 0.1 * x]);
        check(&mesh, 4).unwrap().affine
    };
    assert_eq!(affine, 64, "round-off of far coordinates must not pass for a deformation");
}

#[test]
fn strongly_deformed_elements_are_inverted() {
    // one hexahedron with a corner pulled far in
    let mut mesh = LayeredBox {
        dimension: 3,
        x: (0.0, 1.0),
        y: (0.0, 1.0),
        layers: &[BoxLayer { name: "a".into(), thickness: 1.0, elements: 1 }],
        element_width: 1.0,
        topography: None,
        moved_layers: 1,
        order: 1,
    }
    .mesh()
    .unwrap();
    mesh.nodes[7] = [0.69, 0.68, -0.31];
    let report = check(&mesh, 8).unwrap();
    assert!(report.scaled_jacobian_min.value < 0.25, "{:?}", report.scaled_jacobian_min);
    let mut numbers = Numbers(8);
    for _ in 0..2000 {
        let local = numbers.local(3, 1.0);
        let found = mesh.inverse_map(0, mesh.position(0, local)).unwrap();
        assert!(distance(found, local) < 1e-11, "{found:?} {local:?}");
    }
}

#[test]
fn a_height_grid_is_bilinear() {
    let height = |x: f64, y: f64| 1.0 + 0.3 * x - 0.2 * y + 0.05 * x * y;
    let points = (0..4).flat_map(|j| (0..3).map(move |i| (2.0 + 5.0 * i as f64, -1.0 + 2.5 * j as f64)));
    let heights: Vec<f64> = points.map(|(x, y)| height(x, y)).collect();
    let grid = HeightGrid::new([2.0, -1.0], [5.0, 2.5], [3, 4], heights.clone()).unwrap();
    for (x, y) in [(2.0, -1.0), (12.0, 6.5), (3.3, 4.4), (7.0, 1.5), (11.9, -0.9)] {
        assert!((grid.height(x, y) - height(x, y)).abs() < 1e-13);
    }
    assert!(grid.height(1.9, 0.0).is_nan() && grid.height(3.0, 6.6).is_nan());
    let line = HeightGrid::new([0.0, 0.0], [2.0, 0.0], [2, 1], vec![1.0, 3.0]).unwrap();
    assert_eq!(line.height(1.0, 55.0), 2.0);
    let refused = [
        HeightGrid::new([0.0; 2], [1.0; 2], [3, 4], vec![0.0; 11]),
        HeightGrid::new([0.0; 2], [0.0, 1.0], [3, 4], heights.clone()),
        HeightGrid::new([0.0; 2], [1.0; 2], [0, 4], vec![]),
        HeightGrid::new([0.0; 2], [1.0; 2], [1, 1], vec![f64::NAN]),
    ];
    assert!(refused.iter().all(|r| matches!(r, Err(SemError::HeightGrid { .. }))));
}

#[test]
fn random_meshes_are_the_same_every_time_and_stay_valid() {
    for (dimension, order) in [(2, 1), (3, 1), (3, 2)] {
        let moved = |seed| {
            let mut mesh = two_layers(dimension, order, 100.0);
            mesh.move_interior_nodes(0.15, seed);
            mesh
        };
        assert_eq!(moved(5), moved(5));
        assert_ne!(moved(5), moved(6));
        let (before, after) = (two_layers(dimension, order, 100.0), moved(5));
        let report = check(&after, 8).unwrap();
        assert!(report.scaled_jacobian_min.value > 0.5 && report.affine == 0, "{report:?}");
        let shifts = before.nodes.iter().zip(&after.nodes).map(|(a, b)| distance(*a, *b));
        let most = shifts.fold(0.0, f64::max);
        // 15 % of edges between 20 m and 30 m along each axis
        assert!((3.0..0.15 * 30.0 * 3f64.sqrt()).contains(&most), "{most}");
        for side in before.outer_sides() {
            before
                .side_nodes(side)
                .for_each(|n| assert_eq!(before.nodes[n as usize], after.nodes[n as usize]));
        }
    }
}

#[test]
fn sizes_follow_the_slowest_wave() {
    let layer = |name: &str, thickness, vs| Layer {
        name: name.into(),
        thickness,
        vs,
        vp: 2.0 * vs,
        rho: 1800.0,
        damping_s: 0.0,
        damping_p: 0.0,
    };
    let layers = [layer("a", 10.0, 200.0), layer("b", 50.0, 500.0), layer("c", 1.0, 1000.0)];
    let resolution = Resolution { f_max: 20.0, points_per_wavelength: 5.0, order: 4 };
    // h = N v / (p f): 8 m, 20 m, 40 m
    assert_eq!(resolution.element_size(200.0), 8.0);
    assert_eq!(resolution.points_in(8.0, 200.0), 5.0);
    let heights = layer_heights(&layers, &resolution).unwrap();
    assert_eq!(heights.iter().map(|l| l.elements).collect::<Vec<_>>(), [2, 3, 1]);
    assert_eq!(element_width(&layers, &resolution).unwrap(), 8.0);
    let exact = layer_heights(&[layer("a", 24.0 + 1e-12, 200.0)], &resolution).unwrap();
    assert_eq!(exact[0].elements, 3, "round-off must not cost an element");
    let bad = |r: Resolution| layer_heights(&layers, &r).unwrap_err();
    assert!(matches!(bad(Resolution { f_max: 0.0, ..resolution }), SemError::Sampling { key: "f_max", .. }));
    assert!(matches!(bad(Resolution { order: 0, ..resolution }), SemError::Order(0)));
    let still = [layer("a", 1.0, 0.0)];
    assert!(matches!(layer_heights(&still, &resolution), Err(SemError::Material { key: "vs", .. })));
    assert!(matches!(element_width(&still, &resolution), Err(SemError::Material { key: "vs", .. })));
    assert!(element_width(&[], &resolution).is_err());
}
