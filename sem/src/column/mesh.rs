use crate::SemError;
use crate::gll::Gll;
use crate::soil::Profile;

/// Polynomial order and number of equal elements in each layer.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Discretisation {
    /// Polynomial order, 1–10.
    pub order: usize,
    /// Elements in each layer, from the surface down, at least 1.
    pub elements: Vec<usize>,
}

/// One element of the column.
#[derive(Debug, Clone, Copy)]
pub struct Element {
    /// Layer it lies in.
    pub layer: usize,
    /// Depth of its top, m.
    pub top: f64,
    /// Its height, m.
    pub height: f64,
}

/// Where a depth lies in the mesh, with the interpolation weights of its element's points.
#[derive(Debug, Clone)]
pub struct Probe {
    /// Depth, m.
    pub depth: f64,
    /// Element that holds it.
    pub element: usize,
    /// Values of the basis functions there, from the element's top down.
    pub weights: Vec<f64>,
}

/// Elements from the surface down; node 0 is the surface, the last node the base. Neighbours share
/// their end node, and element faces lie on the layer interfaces.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// The rule of the mesh's order.
    pub gll: Gll,
    /// Elements from the surface down.
    pub elements: Vec<Element>,
    /// The discretisation that it was made from.
    pub discretisation: Discretisation,
    /// Depth of every node, m.
    pub depth: Vec<f64>,
}

impl Mesh {
    /// Meshes a profile. Errors: order out of range, counts that do not match the layers.
    pub fn new(profile: &Profile, discretisation: &Discretisation) -> Result<Self, SemError> {
        let gll = Gll::new(discretisation.order)?;
        let counts = &discretisation.elements;
        if counts.len() != profile.layers.len() || counts.contains(&0) {
            return Err(SemError::ElementCounts { found: counts.len(), expected: profile.layers.len() });
        }
        let top = profile.interfaces();
        let mut elements = vec![];
        for (layer, (&count, l)) in counts.iter().zip(&profile.layers).enumerate() {
            let height = l.thickness / count as f64;
            elements.extend((0..count).map(|k| Element {
                layer,
                top: top[layer] + k as f64 * height,
                height,
            }));
        }
        let mut depth = vec![0.0];
        for e in &elements {
            depth.extend(gll.points[1..].iter().map(|xi| e.top + 0.5 * (1.0 + xi) * e.height));
        }
        Ok(Self { gll, elements, discretisation: discretisation.clone(), depth })
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.depth.len()
    }

    /// Polynomial order.
    pub fn order(&self) -> usize {
        self.discretisation.order
    }

    /// Depth of the base, m.
    pub fn bottom(&self) -> f64 {
        self.elements.last().map_or(0.0, |e| e.top + e.height)
    }

    /// Lumped mass of every node for unit plan area, kg/m²; the same for every component.
    pub fn mass(&self, profile: &Profile) -> Vec<f64> {
        let mut mass = vec![0.0; self.nodes()];
        for (k, e) in self.elements.iter().enumerate() {
            let scale = 0.5 * e.height * profile.layers[e.layer].rho;
            for (i, w) in self.gll.weights.iter().enumerate() {
                mass[k * self.order() + i] += scale * w;
            }
        }
        mass
    }

    /// Finds a depth; the base itself belongs to the lowest element. Error: outside the column.
    pub fn probe(&self, depth: f64) -> Result<Probe, SemError> {
        let bottom = self.bottom();
        let slack = 1e-9 * bottom;
        if !(-slack..=bottom + slack).contains(&depth) {
            return Err(SemError::Depth { depth, bottom });
        }
        let element = self.elements.partition_point(|e| e.top <= depth).saturating_sub(1);
        let e = self.elements[element];
        let xi = (2.0 * (depth - e.top) / e.height - 1.0).clamp(-1.0, 1.0);
        Ok(Probe { depth, element, weights: self.gll.interpolation(xi) })
    }
}
