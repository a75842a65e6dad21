//! Planes that are flat up to round-off slide as planes do; what supports take of a force.

use super::small_box;
use hati_sem::mesh::{Boundary, Locator, Mesh};
use hati_sem::solid::{FLAT, Ground, Material, Support};

fn ground(mesh: Mesh) -> Ground {
    let soil = |name| Material::elastic(name, 1800.0, 400.0, 200.0);
    Ground::new(mesh, 2, &[soil("soft"), soil("stiff")]).unwrap()
}

/// A box whose side x = 0 is moved by up to `shift` to and fro from node to node (elements are 1 m wide).
fn rough(dimension: usize, shift: f64) -> Mesh {
    let mut mesh = small_box(dimension, 1, false);
    mesh.deform(|[x, y, z]| {
        let odd = ((y + z).round() as i64).rem_euclid(2) == 1;
        [if x == 0.0 && odd { shift } else { x }, y, z]
    });
    mesh
}

/// How much of a unit force along x and along z the points of `x_min` feel: least and greatest.
fn felt(ground: &Ground) -> [[f64; 2]; 2] {
    [0, 2].map(|axis| {
        let force: [f64; 3] = std::array::from_fn(|i| f64::from(i == axis));
        let parts =
            ground.boundary_points("x_min").unwrap().into_iter().map(|p| ground.released(p, force)[axis]);
        parts.fold([f64::INFINITY, 0.0_f64], |[low, high], x| [low.min(x), high.max(x)])
    })
}

#[test]
fn a_plane_that_is_flat_up_to_round_off_slides() {
    for dimension in [2, 3] {
        // normals of neighbours then differ by twice the shift over 1 m, and from their mean by once
        for shift in [0.0, 1e-9, 1.5e-6, 0.3 * FLAT, 0.5 * FLAT] {
            let mut plane = ground(rough(dimension, shift));
            assert!(plane.boundary_plane("x_min").unwrap().is_flat(), "{dimension} {shift:e}");
            plane.support("x_min", Support::Symmetry).unwrap();
            let [x, z] = felt(&plane);
            assert!(x[1] < 1e-9 && z[0] > 1.0 - 1e-9, "{dimension} {shift:e}: {x:?} {z:?}");
            let mut plane = ground(rough(dimension, shift));
            plane.support("x_min", Support::Antisymmetry).unwrap();
            let [x, z] = felt(&plane);
            assert!(x[0] > 1.0 - 1e-9 && z[1] < 1e-9, "{dimension} {shift:e}: {x:?} {z:?}");
        }
        // a side that is bent indeed has no one direction to slide along
        let mut bent = ground(rough(dimension, 20.0 * FLAT));
        let plane = bent.boundary_plane("x_min").unwrap();
        assert!(!plane.is_flat() && plane.angle > 10.0 * FLAT && plane.angle < 60.0 * FLAT, "{plane:?}");
        assert!(plane.distance > 5.0 * FLAT && plane.distance < 21.0 * FLAT, "{plane:?}");
        bent.support("x_min", Support::Symmetry).unwrap();
        assert!(felt(&bent)[1][0] < 0.5, "{dimension}: {:?}", felt(&bent));
    }
}

#[test]
fn two_boundaries_in_one_plane_hold_one_direction_where_they_meet() {
    for (tilt, slides) in [(0.9 * FLAT, true), (1.8 * FLAT, true), (10.0 * FLAT, false)] {
        let mut mesh = small_box(2, 1, false);
        mesh.deform(|[x, y, z]| [if x == 0.0 { tilt * (z + 2.0).max(0.0) } else { x }, y, z]);
        let number = mesh.boundaries.iter().position(|b| b.name == "x_min").unwrap();
        let all = mesh.boundaries[number].sides.clone();
        let (upper, lower) = all.into_iter().partition(|s| mesh.centre(s.element as usize)[2] > -2.0);
        mesh.boundaries[number].sides = upper;
        mesh.boundaries.push(Boundary { name: "below".into(), sides: lower });
        let mut ground = ground(mesh);
        ground.support("x_min", Support::Symmetry).unwrap();
        ground.support("below", Support::Symmetry).unwrap();
        let least = felt(&ground)[1][0];
        assert_eq!(least > 0.5, slides, "{tilt:e}: {least}");
    }
}

#[test]
fn a_force_is_lost_where_its_place_cannot_move_and_nowhere_else() {
    let mut ground = ground(small_box(3, 1, false));
    ground.support("bottom", Support::Fixed).unwrap();
    ground.support("x_min", Support::Symmetry).unwrap();
    let force = [3.0, -2.0, 1.0];
    for (place, expected) in [
        ([1.3, 0.2, -3.5], force),
        ([1.3, 0.2, -3.499], [0.0; 3]),
        ([0.0, 0.2, -1.2], [3.0, 0.0, 0.0]),
        ([0.01, 0.2, -1.2], [0.0; 3]),
        ([0.0, 0.2, 0.0], [3.0, 0.0, 0.0]),
        ([1.0, 0.0, -2.0], [0.0; 3]),
    ] {
        let weights = ground.probe(&Locator::new(ground.mesh()), place).unwrap().weights;
        let lost = ground.lost(&weights, force);
        let gap = (0..3).map(|i| (lost[i] - expected[i]).abs()).fold(0.0, f64::max);
        assert!(gap < 1e-9, "{place:?}: {lost:?}");
    }
}

#[test]
fn shared_amplitudes_are_counted_once() {
    let mut ground = ground(small_box(2, 1, false));
    let amplitude = std::sync::Arc::new(vec![1.0; 1000]);
    for _ in 0..7 {
        ground.add_shared_load(vec![(0, [1.0; 3])], std::sync::Arc::clone(&amplitude));
    }
    let shared = ground.load_bytes();
    assert!((8000..8400).contains(&shared), "{shared}");
    ground.add_load(vec![(0, [1.0; 3])], vec![1.0; 1000]);
    assert!((16000..16400).contains(&ground.load_bytes()), "{}", ground.load_bytes());
}
