//! The plane of a mesh of quadrilaterals: the section x–z.

use std::path::Path;

use super::fault::point;
use super::geometry::{corners, norm, subtract};
use super::sections::refused;
use crate::error::InputError;

/// Deviation from a plane that is round-off, as a share of the smallest element's extent.
const FLAT: f64 = 1e-6;

/// The plane in which the file gave the mesh.
#[derive(Debug, PartialEq)]
pub(super) enum Section {
    /// Flat in z: its y has become z.
    FromXy,
    /// Flat in y: left as it is.
    FromXz,
}

/// Brings a flat mesh into the plane y = 0, with z up.
pub(super) fn section(
    path: &Path,
    order: usize,
    elements: &[u32],
    nodes: &mut [[f64; 3]],
) -> Result<Section, InputError> {
    let (mut low, mut high) = (nodes[elements[0] as usize], nodes[elements[0] as usize]);
    for place in nodes.iter() {
        for c in 0..3 {
            (low[c], high[c]) = (low[c].min(place[c]), high[c].max(place[c]));
        }
    }
    // The diagonal of an element, not its edges: a collapsed edge is told by its own name later.
    let corners = corners(2, order);
    let size = elements
        .chunks_exact((order + 1).pow(2))
        .map(|element| {
            let place = |corner: usize| nodes[element[corners[corner]] as usize];
            let across = norm(subtract(place(3), place(0)));
            across.max(norm(subtract(place(2), place(1))))
        })
        .fold(f64::INFINITY, f64::min);
    // Far from the origin the last digit of a coordinate is all that can be asked for.
    let far = low.iter().chain(&high).fold(0.0_f64, |far, c| far.max(c.abs()));
    let flat = |c: usize| high[c] - low[c] <= FLAT * size + 8.0 * f64::EPSILON * far;
    let section = if flat(2) {
        Section::FromXy
    } else if flat(1) {
        Section::FromXz
    } else {
        return Err(refused(
            path,
            format!(
                "its elements are surfaces, no volumes, and not flat in z or y: they reach from {} to {}",
                point(low),
                point(high)
            ),
            "for a volume add a Physical Volume and mesh with -3; for a section draw it in the plane x–y (y up) or x–z",
        ));
    };
    for place in nodes.iter_mut() {
        let up = if section == Section::FromXy { place[1] } else { place[2] };
        *place = [place[0], 0.0, up];
    }
    Ok(section)
}
