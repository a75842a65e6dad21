//! The mesh as the report draws it.

use super::plan::VolumePlan;
use crate::report::wave::{MeshFace, MeshPicture, MeshView};
use hati_sem::mesh::{Mesh, Side};

/// Elements up to which the outer sides are found among all; of larger meshes those of the named boundaries are drawn.
const SORTED: usize = 200_000;
/// Share of a side's normal towards the viewer from which it is seen.
const TOWARDS: f64 = 0.2;

/// Views of a plan's mesh: of a section its elements, of a volume its outer sides from above and from −y.
pub(super) fn picture(plan: &VolumePlan) -> MeshPicture {
    let mesh = plan.ground.mesh();
    let views = if mesh.dimension == 2 {
        let faces = (0..mesh.len()).map(|e| face(mesh, e, [0, 2], |p| [p[0], p[1], 0.0])).collect();
        vec![MeshView { title: "section".into(), axes: [0, 2], faces }]
    } else {
        let sides = if mesh.len() <= SORTED {
            mesh.outer_sides()
        } else {
            mesh.boundaries.iter().flat_map(|b| b.sides.iter().copied()).collect()
        };
        vec![
            view(mesh, &sides, "seen from above", [0, 1], (2, 1.0)),
            view(mesh, &sides, "seen from the side, along y", [0, 2], (1, -1.0)),
        ]
    };
    MeshPicture {
        materials: mesh.materials.clone(),
        views,
        sources: plan.sources.iter().filter_map(|s| Some((s.name.clone(), s.position?))).collect(),
        stations: plan.sensors.iter().map(|s| (s.name.clone(), s.probe.position)).collect(),
    }
}

/// Sides that face a viewer who stands far along an axis, the farthest first.
fn view(mesh: &Mesh, sides: &[Side], title: &str, axes: [usize; 2], (axis, sign): (usize, f64)) -> MeshView {
    let mut seen: Vec<(f64, MeshFace)> = vec![];
    for &side in sides {
        let local = mesh.side_local(side, [0.0; 2]);
        let normal = mesh.side_normal(side, local);
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        if sign * normal[axis] > TOWARDS * length {
            let element = side.element as usize;
            let nearness = sign * mesh.position(element, local)[axis];
            seen.push((nearness, face(mesh, element, axes, |p| mesh.side_local(side, p))));
        }
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let faces = seen.into_iter().map(|(_, face)| face).collect();
    MeshView { title: title.into(), axes, faces }
}

/// Outline of a quadrilateral whose coordinates in [−1, 1]² a function takes to those of the element; curved edges bend in
/// their middle.
fn face(mesh: &Mesh, element: usize, axes: [usize; 2], local: impl Fn([f64; 2]) -> [f64; 3]) -> MeshFace {
    const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let parts: &[f64] = if mesh.order == 1 { &[0.0] } else { &[0.0, 0.25, 0.5, 0.75] };
    let mut outline = vec![];
    for (i, from) in CORNERS.iter().enumerate() {
        let to = CORNERS[(i + 1) % 4];
        for part in parts {
            let at = [0, 1].map(|k| from[k] + part * (to[k] - from[k]));
            let x = mesh.position(element, local(at));
            outline.push(axes.map(|axis| x[axis]));
        }
    }
    MeshFace { material: mesh.material[element] as usize, outline }
}
