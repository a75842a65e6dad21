//! Layers and base of a profile, at D = 1 and later at D = 2 and 3.

use crate::SemError;
use serde::Serialize;

/// A homogeneous isotropic layer. Speeds belong to the reference frequency.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Layer {
    /// Name for messages and figures.
    pub name: String,
    /// Thickness, m.
    pub thickness: f64,
    /// Shear-wave speed $\sqrt{\mathrm{Re}\,G/\rho}$ at the reference frequency, m/s.
    pub vs: f64,
    /// Compressional-wave speed at the reference frequency, m/s.
    pub vp: f64,
    /// Density, kg/m³.
    pub rho: f64,
    /// Damping ratio $D = \mathrm{Im}\,G/(2\,\mathrm{Re}\,G)$ of shear, 1.
    pub damping_s: f64,
    /// Damping ratio of the constrained modulus $\rho v_p^2$, 1.
    pub damping_p: f64,
}

impl Layer {
    /// Modulus that a component feels at the reference frequency, Pa: $G$ for x and y, $\rho v_p^2$ for z.
    pub fn modulus(&self, axis: usize) -> f64 {
        self.rho * self.speed(axis).powi(2)
    }

    /// Wave speed of a component, m/s.
    pub fn speed(&self, axis: usize) -> f64 {
        if axis == 2 { self.vp } else { self.vs }
    }

    /// Damping ratio of a component.
    pub fn damping(&self, axis: usize) -> f64 {
        if axis == 2 { self.damping_p } else { self.damping_s }
    }
}

/// What lies under the lowest layer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Base {
    /// Elastic half-space, felt as the impedances $\rho v_s$ and $\rho v_p$.
    Elastic {
        /// Shear-wave speed, m/s.
        vs: f64,
        /// Compressional-wave speed, m/s.
        vp: f64,
        /// Density, kg/m³.
        rho: f64,
    },
    /// Rigid: the base motion is imposed.
    Rigid,
}

impl Base {
    /// Impedance $\rho c$ of a component, Pa·s/m; `None` for a rigid base.
    pub fn impedance(&self, axis: usize) -> Option<f64> {
        match *self {
            Base::Elastic { vs, vp, rho } => Some(rho * if axis == 2 { vp } else { vs }),
            Base::Rigid => None,
        }
    }
}

/// Layers from the surface down, and the base.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Profile {
    /// Layers from the surface down.
    pub layers: Vec<Layer>,
    /// What they rest on.
    pub base: Base,
    /// Frequency at which speeds are given, Hz.
    pub reference_frequency: f64,
}

impl Profile {
    /// Depth of the base, m.
    pub fn depth(&self) -> f64 {
        self.layers.iter().map(|l| l.thickness).sum()
    }

    /// Depth of the top of each layer and of the base, m; one more than there are layers.
    pub fn interfaces(&self) -> Vec<f64> {
        let mut z = vec![0.0];
        for layer in &self.layers {
            z.push(z[z.len() - 1] + layer.thickness);
        }
        z
    }

    /// Travel time from base to surface of a component, s.
    pub fn travel_time(&self, axis: usize) -> f64 {
        self.layers.iter().map(|l| l.thickness / l.speed(axis)).sum()
    }

    /// Checks every value; the first that is out of range is the error. (A scene file reports them all.)
    pub fn check(&self) -> Result<(), SemError> {
        for l in &self.layers {
            let positive = [("thickness", l.thickness), ("vs", l.vs), ("vp", l.vp), ("rho", l.rho)];
            for (key, value) in positive {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(SemError::Material { layer: l.name.clone(), key, value, range: "> 0" });
                }
            }
            for (key, value) in [("damping_s", l.damping_s), ("damping_p", l.damping_p)] {
                if !(0.0..=0.3).contains(&value) {
                    return Err(SemError::Material { layer: l.name.clone(), key, value, range: "0…0.3" });
                }
            }
        }
        Ok(())
    }
}
