//! Rigid motions, rotated elements and masses, over arbitrary geometry.

use crate::bodies::{largest, steel};
use hati_fem::{
    assembly::rigid_motion,
    element::{Axis, Bar, Beam, Element, EndReleases, Hex8, Hex20, MassForm, PointMass, Spring, Tet10},
    mesh::{SolidKind, block},
    section::Section,
};
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

/// An element and the positions of its nodes.
type Placed = (Box<dyn Element>, Vec<Vector3<f64>>);
type Map<'a> = &'a dyn Fn(Vector3<f64>) -> Vector3<f64>;

/// One of each element, its geometry moved by `map`, directions turned by `turn`; with its positions.
fn elements(map: Map<'_>, turn: Matrix3<f64>, shake: f64) -> Vec<Placed> {
    let mut list: Vec<Placed> = vec![];
    for kind in [SolidKind::Hex8, SolidKind::Hex20, SolidKind::Tet10] {
        let mesh = block(kind, [1, 1, 1], |x| {
            let s = shake * (3.0 * x[0] + 5.0 * x[1] * x[1] - 4.0 * x[2] * x[0]).sin();
            map(Vector3::new(x[0] + s, 2.0 * x[1] - s, x[2] + 0.5 * s)).into()
        });
        let nodes = &mesh.elements[0];
        let at: Vec<[f64; 3]> = nodes.iter().map(|&n| mesh.nodes[n]).collect();
        let solid: Box<dyn Element> = match kind {
            SolidKind::Hex8 => Box::new(Hex8::new(nodes, &at, steel()).unwrap()),
            SolidKind::Hex20 => Box::new(Hex20::new(nodes, &at, steel()).unwrap()),
            SolidKind::Tet10 => Box::new(Tet10::new(nodes, &at, steel()).unwrap()),
        };
        list.push((solid, at.into_iter().map(Vector3::from).collect()));
    }
    let ends = [Vector3::new(0.2, 0.1, -0.4), Vector3::new(1.5 + shake, -0.7, 0.9)].map(map);
    let at = ends.map(<[f64; 3]>::from);
    let up: [f64; 3] = (turn * Vector3::new(0.1, 0.3, 1.0)).into();
    let section = Section::hollow_box(0.2, 0.3, 0.01, 0.02, 0.3).unwrap();
    let offsets = [Vector3::new(0.1, 0.2, -0.1), Vector3::new(-0.1, 0.05, 0.3)].map(|r| (turn * r).into());
    let beam = Beam::new([0, 1], at, up, section, steel()).unwrap().with_offsets(offsets).unwrap();
    let released = EndReleases {
        start: [true, false, false, false, true, false],
        end: [false, false, false, false, true, true],
    };
    list.push((Box::new(beam.clone()), ends.to_vec()));
    list.push((Box::new(beam.with_releases(released).unwrap()), ends.to_vec()));
    list.push((Box::new(Bar::new([0, 1], at, 0.01, steel()).unwrap()), ends.to_vec()));
    let along: [f64; 3] = (ends[1] - ends[0]).into();
    let axes = [Axis::translation(along, 3e9), Axis::rotation(up, 2e9)];
    list.push((Box::new(Spring::between([0, 1], at, &axes).unwrap()), ends.to_vec()));
    let tensor = turn * Matrix3::new(4.0, 0.5, 0.2, 0.5, 5.0, -0.3, 0.2, -0.3, 6.0) * turn.transpose();
    let six =
        [tensor[(0, 0)], tensor[(1, 1)], tensor[(2, 2)], tensor[(0, 1)], tensor[(1, 2)], tensor[(2, 0)]];
    let arm = (turn * Vector3::new(0.4, -0.2, 0.6)).into();
    let mass = PointMass::new(0, 7.0).unwrap().with_inertia(six).unwrap().with_eccentricity(arm).unwrap();
    list.push((Box::new(mass), vec![ends[0]]));
    list
}

fn rigid(element: &dyn Element, positions: &[Vector3<f64>]) -> DMatrix<f64> {
    let count = element.freedoms_per_node();
    let mut motions = DMatrix::zeros(count * positions.len(), 6);
    for (k, x) in positions.iter().enumerate() {
        motions.view_mut((k * count, 0), (count, 6)).copy_from(&rigid_motion(*x).rows(0, count));
    }
    motions
}

fn turned(matrix: &DMatrix<f64>, turn: &Matrix3<f64>) -> DMatrix<f64> {
    let mut full = DMatrix::zeros(matrix.nrows(), matrix.nrows());
    for k in 0..matrix.nrows() / 3 {
        full.view_mut((3 * k, 3 * k), (3, 3)).copy_from(turn);
    }
    &full * matrix * full.transpose()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn no_element_resists_a_rigid_motion(shake in -0.08..0.08f64, shift in prop::array::uniform3(-5.0..5.0f64)) {
        let move_by = Vector3::from(shift);
        for (element, positions) in elements(&|x| x + move_by, Matrix3::identity(), shake) {
            let stiffness = element.stiffness();
            let force = &stiffness * rigid(element.as_ref(), &positions);
            // springs are as stiff in turning as their coefficient: scale by the greatest entry
            prop_assert!(force.amax() < 3e-13 * 10.0 * stiffness.amax().max(1.0), "{}: {:e}", element.kind(), force.amax());
        }
    }

    #[test]
    fn a_turned_element_has_turned_matrices(angles in prop::array::uniform3(-3.0..3.0f64), shake in -0.08..0.08f64) {
        let turn = *Rotation3::from_euler_angles(angles[0], angles[1], angles[2]).matrix();
        let plain = elements(&|x| x, Matrix3::identity(), shake);
        let rotated = elements(&|x| turn * x, turn, shake);
        for ((a, _), (b, _)) in plain.iter().zip(&rotated) {
            let pairs = [
                (a.stiffness(), b.stiffness()),
                (a.mass(MassForm::Consistent), b.mass(MassForm::Consistent)),
            ];
            for (own, other) in pairs {
                let wrong = (turned(&own, &turn) - &other).amax();
                prop_assert!(wrong <= 1e-12 * own.amax(), "{}: {wrong:e} of {:e}", a.kind(), own.amax());
            }
        }
    }

    #[test]
    fn the_mass_of_translations_is_the_element_s_own(shake in -0.08..0.08f64) {
        for (element, positions) in elements(&|x| x, Matrix3::identity(), shake) {
            let forms = [MassForm::Consistent, MassForm::Lumped];
            let released = |form| element.kind() == "beam" && form == MassForm::Lumped;
            for form in forms.into_iter().filter(|&f| !released(f)) {
                let motion = rigid(element.as_ref(), &positions).columns(0, 3).into_owned();
                let mass = motion.transpose() * element.mass(form) * &motion;
                let wrong = largest((mass - DMatrix::identity(3, 3) * element.total_mass()).iter().copied());
                prop_assert!(wrong <= 1e-12 * element.total_mass().max(1e-300), "{} {form:?}: {wrong:e}", element.kind());
            }
        }
    }
}
