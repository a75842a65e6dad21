//! The solid of D = 2 and 3 against its reference and its own invariants.

mod gauge;
mod gaussian;
mod held;
mod ledger;
mod parity;
mod planes;
mod rest;
mod state;

use hati_sem::mesh::{BoxLayer, LayeredBox, Mesh};
use hati_sem::soil::Layer;
use hati_sem::solid::Material;

/// A small box of two layers; geometric order 1 or 2, deformed or not.
pub fn small_box(dimension: usize, geometry: usize, deformed: bool) -> Mesh {
    let layer = |name: &str, thickness, elements| BoxLayer { name: name.into(), thickness, elements };
    let layers = [layer("soft", 2.0, 2), layer("stiff", 1.5, 1)];
    let mut mesh = LayeredBox {
        dimension,
        x: (0.0, 3.0),
        y: (-1.0, 1.0),
        layers: &layers,
        element_width: 1.0,
        topography: None,
        moved_layers: 1,
        order: geometry,
    }
    .mesh()
    .unwrap();
    if deformed && geometry == 1 {
        mesh.move_interior_nodes(0.15, 7);
    }
    if deformed && geometry == 2 {
        mesh.deform(|[x, y, z]| {
            let bump = 0.1 * (1.3 * x + 0.4).sin() * (0.9 * z).cos();
            [x + 0.5 * bump, if dimension == 3 { y - 0.7 * bump } else { y }, z + bump]
        });
    }
    mesh
}

/// Materials of [`small_box`], with memory variables or without.
pub fn materials(damped: bool) -> Vec<Material> {
    let layer = |name: &str, vs: f64, damping_s, damping_p| Layer {
        name: name.into(),
        thickness: 1.0,
        vs,
        vp: 2.0 * vs,
        rho: 1.8 * vs,
        damping_s,
        damping_p,
    };
    [layer("soft", 1.0, 0.05, 0.05), layer("stiff", 1.7, 0.02, 0.03)]
        .iter()
        .map(|l| match damped {
            true => Material::of_layer(l, 0.3, (0.05, 2.0), 3).unwrap(),
            false => Material::elastic(&l.name, l.rho, l.vp, l.vs),
        })
        .collect()
}
