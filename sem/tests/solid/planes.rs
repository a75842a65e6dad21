//! A quarter between planes of symmetry or antisymmetry moves as the whole does.

use hati_coupling::Subdomain;
use hati_sem::mesh::{BoxLayer, LayeredBox, Locator};
use hati_sem::solid::{Execution, Ground, Material, Solid, Support};

const PLACE: [f64; 3] = [0.7, 0.9, -0.3];
const SOURCE: [f64; 3] = [0.0, 0.0, -0.8];

/// Displacement at [`PLACE`] over time; a vertical force or a double couple M_xy at [`SOURCE`].
fn motion(least: f64, share: f64, double_couple: bool, planes: Support) -> Vec<[f64; 3]> {
    let layers = [BoxLayer { name: "soil".into(), thickness: 2.0, elements: 2 }];
    let mesh = LayeredBox {
        dimension: 3,
        x: (least, 2.0),
        y: (least, 2.0),
        layers: &layers,
        element_width: 1.0,
        topography: None,
        moved_layers: 1,
        order: 1,
    };
    let soil = Material::elastic("soil", 1.0, 2.0, 1.0);
    let mut ground = Ground::new(mesh.mesh().unwrap(), 4, &[soil]).unwrap();
    for boundary in ["x_min", "y_min"] {
        ground.support(boundary, planes).unwrap();
    }
    let (forces, probe) = {
        let locator = Locator::new(ground.mesh());
        let forces = match double_couple {
            // slopes differ from element to element: each of those around the source takes its share
            true => around(least < 0.0)
                .flat_map(|[x, y]| {
                    let m = if least < 0.0 { 0.25 * share } else { share };
                    let m = [[0.0, m, 0.0], [m, 0.0, 0.0], [0.0; 3]];
                    ground.moment(&locator, [x, y, SOURCE[2]], m).unwrap()
                })
                .collect(),
            false => ground.point_force(&locator, SOURCE, [0.0, 0.0, share]).unwrap(),
        };
        (forces, ground.probe(&locator, PLACE).unwrap())
    };
    let dt = 0.02;
    ground.add_load(forces, (0..200).map(|i| (-(f64::from(i) * dt - 1.0).powi(2) * 9.0).exp()).collect());
    let everywhere: Vec<u32> = probe.weights.iter().map(|w| w.0).collect();
    let interface = ground.add_interface(everywhere);
    let mut solid = Solid::<f64>::new(&ground, dt, dt, Execution::default());
    let mut position = vec![0.0; 3 * probe.weights.len()];
    (0..200)
        .map(|_| {
            solid.step();
            solid.interface_position(interface, &mut position);
            let at = |c: usize| probe.weights.iter().zip(position.chunks(3)).map(|(w, x)| w.1 * x[c]).sum();
            std::array::from_fn(at)
        })
        .collect()
}

/// Places a hair off the axis, in each element around it or in that of the quarter alone.
fn around(whole: bool) -> impl Iterator<Item = [f64; 2]> {
    const HAIR: f64 = 1e-8;
    let places = [[HAIR, HAIR], [-HAIR, HAIR], [HAIR, -HAIR], [-HAIR, -HAIR]];
    places.into_iter().take(if whole { 4 } else { 1 })
}

#[test]
fn a_quarter_moves_as_the_whole() {
    for (double_couple, planes) in [(false, Support::Symmetry), (true, Support::Antisymmetry)] {
        let whole = motion(-2.0, 1.0, double_couple, Support::Free);
        let quarter = motion(0.0, 0.25, double_couple, planes);
        let gap = |other: &[[f64; 3]]| {
            let peak = whole.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
            let gaps = whole.iter().flatten().zip(other.iter().flatten());
            assert!(peak > 0.0);
            gaps.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / peak
        };
        assert!(gap(&quarter) < 1e-6, "{planes:?}: {:e}", gap(&quarter));
        // the other kind of plane must not do
        let other = if double_couple { Support::Symmetry } else { Support::Antisymmetry };
        let wrong = motion(0.0, 0.25, double_couple, other);
        assert!(gap(&wrong) > 0.1, "{other:?}: {:e}", gap(&wrong));
    }
}
