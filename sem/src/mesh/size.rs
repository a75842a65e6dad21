//! Element sizes from wave speeds and the highest frequency.
//!
//! Points per wavelength are counted on the mean spacing of the GLL points, $h/N$: an element of size $h$
//! and order $N$ has $p = N\,v/(f_{max}\,h)$ points per wavelength of a wave of speed $v$, so that
//! $h = N\,v/(p\,f_{max})$. The points themselves are unequally spaced; the widest gap, in the middle of
//! the element, is 1.31 to 1.49 times the mean for N = 3…10. What a number of points is worth depends on
//! the order: see the dispersion table.

use super::BoxLayer;
use super::layered_box::count;
use crate::SemError;
use crate::soil::Layer;

/// What a mesh must resolve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Highest frequency, Hz.
    pub f_max: f64,
    /// GLL points per wavelength at that frequency, on the mean spacing $h/N$.
    pub points_per_wavelength: f64,
    /// Polynomial order N.
    pub order: usize,
}

impl Resolution {
    /// Largest element for a wave speed (m/s), $N\,v/(p\,f_{max})$, m.
    pub fn element_size(&self, speed: f64) -> f64 {
        self.order as f64 * speed / (self.points_per_wavelength * self.f_max)
    }

    /// Points per wavelength that an element of a size (m) gives a wave of a speed (m/s).
    pub fn points_in(&self, element_size: f64, speed: f64) -> f64 {
        self.order as f64 * speed / (element_size * self.f_max)
    }

    fn check(&self) -> Result<(), SemError> {
        if !(1..=crate::gll::ORDER_MAX).contains(&self.order) {
            return Err(SemError::Order(self.order));
        }
        for (key, value) in [("f_max", self.f_max), ("points_per_wavelength", self.points_per_wavelength)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(SemError::Sampling { key, value });
            }
        }
        Ok(())
    }
}

/// Layers of a box whose elements are no higher than each layer's shear wave allows: the fewest equal
/// elements, at least one in a layer.
///
/// Errors: a frequency, number of points, order, thickness or speed out of range.
pub fn layer_heights(layers: &[Layer], resolution: &Resolution) -> Result<Vec<BoxLayer>, SemError> {
    resolution.check()?;
    let sized = |l: &Layer| {
        let elements = count(l.thickness, resolution.element_size(l.vs));
        if elements == 0 {
            let (key, value) = if l.vs > 0.0 { ("thickness", l.thickness) } else { ("vs", l.vs) };
            return Err(SemError::Material { layer: l.name.clone(), key, value, range: "> 0" });
        }
        Ok(BoxLayer { name: l.name.clone(), thickness: l.thickness, elements })
    };
    layers.iter().map(sized).collect()
}

/// The one horizontal element size of a box: what the slowest layer's shear wave allows, m.
///
/// Errors: as [`layer_heights`]; no layer.
pub fn element_width(layers: &[Layer], resolution: &Resolution) -> Result<f64, SemError> {
    resolution.check()?;
    let mut slowest = f64::INFINITY;
    for l in layers {
        if !(l.vs > 0.0 && l.vs.is_finite()) {
            return Err(SemError::Material { layer: l.name.clone(), key: "vs", value: l.vs, range: "> 0" });
        }
        slowest = slowest.min(l.vs);
    }
    if layers.is_empty() {
        return Err(SemError::ElementCounts { found: 0, expected: 1 });
    }
    Ok(resolution.element_size(slowest))
}
