//! Linear isotropic materials.

use crate::FemError;
use nalgebra::Matrix6;

/// A linear, isotropic, elastic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    young: f64,
    poisson: f64,
    density: f64,
}

impl Material {
    /// Material of Young's modulus `young` (Pa), Poisson's ratio `poisson` and `density` (kg/m³).
    ///
    /// Errors: $E \le 0$; $\nu$ outside $(-1, 0.5)$ ends excluded; negative density; numbers not finite.
    pub fn new(young: f64, poisson: f64, density: f64) -> Result<Self, FemError> {
        let refuse = |key, value, range| Err(FemError::Material { key, value, range });
        if !(young > 0.0 && young.is_finite()) {
            return refuse("young", young, "above 0 Pa");
        }
        if !(poisson > -1.0 && poisson < 0.5) {
            return refuse("poisson", poisson, "above -1, below 0.5");
        }
        if !(density >= 0.0 && density.is_finite()) {
            return refuse("density", density, "0 kg/m³ or more");
        }
        Ok(Self { young, poisson, density })
    }

    /// Young's modulus $E$, Pa.
    pub fn young(&self) -> f64 {
        self.young
    }

    /// Poisson's ratio $\nu$.
    pub fn poisson(&self) -> f64 {
        self.poisson
    }

    /// Density $\rho$, kg/m³.
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Shear modulus $G = E / (2(1+\nu))$, Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// Bulk modulus $K = E / (3(1-2\nu))$, Pa.
    pub fn bulk_modulus(&self) -> f64 {
        self.young / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// Elasticity matrix $D$, Pa, of $\sigma = D \varepsilon$ with
    /// $\varepsilon = (\varepsilon_x, \varepsilon_y, \varepsilon_z, \gamma_{xy}, \gamma_{yz}, \gamma_{zx})$,
    /// $\gamma$ the full shear angle: $D = K\,m m^T + 2G\,(I_0 - m m^T/3)$, $m = (1,1,1,0,0,0)$,
    /// $I_0 = \mathrm{diag}(1,1,1,½,½,½)$.
    pub fn elasticity(&self) -> Matrix6<f64> {
        let (bulk, shear) = (self.bulk_modulus(), self.shear_modulus());
        let mut d = Matrix6::zeros();
        for i in 0..3 {
            for j in 0..3 {
                d[(i, j)] = bulk - 2.0 * shear / 3.0;
            }
            d[(i, i)] = bulk + 4.0 * shear / 3.0;
            d[(i + 3, i + 3)] = shear;
        }
        d
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector6;

    #[test]
    fn a_bar_pulled_along_x_has_young_and_poisson() {
        let steel = Material::new(210e9, 0.3, 7850.0).unwrap();
        let stress = steel.elasticity() * Vector6::new(1.0, -0.3, -0.3, 0.0, 0.0, 0.0);
        assert_relative_eq!(stress, Vector6::new(210e9, 0.0, 0.0, 0.0, 0.0, 0.0), epsilon = 1e-3);
    }

    #[test]
    fn constants_out_of_range_are_named() {
        for (young, poisson, density, key) in [
            (0.0, 0.3, 1.0, "young"),
            (1.0, 0.5, 1.0, "poisson"),
            (1.0, -1.0, 1.0, "poisson"),
            (1.0, 0.3, -1.0, "density"),
        ] {
            let error = Material::new(young, poisson, density).unwrap_err();
            assert!(matches!(error, FemError::Material { key: k, .. } if k == key), "{error}");
        }
        assert!(Material::new(f64::NAN, 0.3, 1.0).is_err());
    }
}
