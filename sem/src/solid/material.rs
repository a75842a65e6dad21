//! Isotropic materials with memory variables that shear and volume share.

use crate::SemError;
use crate::attenuation::MaxwellArms;
use crate::soil::Layer;

/// An isotropic, elastic or viscoelastic material.
///
/// Shear modulus and constrained modulus follow $G = \rho v_s^2\,\hat G_s(\omega)$ and
/// $M = \rho v_p^2\,\hat G_p(\omega)$, each a spring beside Maxwell arms; both sets of arms have the same
/// relaxation frequencies, so that one memory variable per strain component and arm serves both:
/// $\lambda_l = M_l - 2G_l$.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name.
    pub name: String,
    /// Density, kg/m³.
    pub rho: f64,
    /// Speed of P waves at the reference frequency, m/s.
    pub vp: f64,
    /// Speed of S waves at the reference frequency, m/s.
    pub vs: f64,
    /// Law of the shear modulus.
    pub shear: MaxwellArms,
    /// Law of the constrained modulus; the same frequencies as `shear`.
    pub constrained: MaxwellArms,
    /// Band over which the laws are fitted, Hz; of no meaning where there are no arms.
    pub band: (f64, f64),
}

impl Material {
    /// An elastic material.
    pub fn elastic(name: &str, rho: f64, vp: f64, vs: f64) -> Self {
        let (shear, constrained) = (MaxwellArms::elastic(), MaxwellArms::elastic());
        Self { name: name.into(), rho, vp, vs, shear, constrained, band: (0.0, 0.0) }
    }

    /// The material of a layer, its damping fitted over `band` (Hz) with `mechanisms` arms.
    ///
    /// The arms' frequencies are those of the better damped modulus's fit; the other modulus takes the
    /// best arms at these. Errors: those of the fit; a damping of P waves so small that the bulk modulus
    /// would feed energy ($D_p\,v_p^2 < \tfrac43 D_s\,v_s^2$, about).
    pub fn of_layer(
        layer: &Layer,
        reference_frequency: f64,
        band: (f64, f64),
        mechanisms: usize,
    ) -> Result<Self, SemError> {
        let (ds, dp) = (layer.damping_s, layer.damping_p);
        let fit = |d: f64| MaxwellArms::fit(d, reference_frequency, band, mechanisms);
        let at = |d: f64, omega: &[f64]| MaxwellArms::fit_at(d, reference_frequency, band, omega);
        let (shear, constrained) = if ds >= dp {
            let shear = fit(ds)?;
            let constrained = if ds == dp { shear.clone() } else { at(dp, &shear.omega)? };
            (shear, constrained)
        } else {
            let constrained = fit(dp)?;
            (at(ds, &constrained.omega)?, constrained)
        };
        let material = Self {
            name: layer.name.clone(),
            rho: layer.rho,
            vp: layer.vp,
            vs: layer.vs,
            shear,
            constrained,
            band,
        };
        material.check()?;
        Ok(material)
    }

    /// Lamé's moduli λ and μ at a factor pair of the two laws, Pa.
    pub(super) fn lame(&self, constrained: f64, shear: f64) -> (f64, f64) {
        let mu = self.rho * self.vs * self.vs * shear;
        (self.rho * self.vp * self.vp * constrained - 2.0 * mu, mu)
    }

    /// Relaxed moduli λ and μ, Pa.
    pub fn relaxed(&self) -> (f64, f64) {
        self.lame(self.constrained.relaxed, self.shear.relaxed)
    }

    /// Unrelaxed moduli λ and μ, Pa: what a fast step feels.
    pub fn unrelaxed(&self) -> (f64, f64) {
        self.lame(self.constrained.unrelaxed(), self.shear.unrelaxed())
    }

    /// Moduli λ and μ of arm `l`, Pa.
    pub fn arm(&self, l: usize) -> (f64, f64) {
        self.lame(self.constrained.modulus[l], self.shear.modulus[l])
    }

    /// Relaxation frequencies of the arms, rad/s.
    pub fn omega(&self) -> &[f64] {
        &self.shear.omega
    }

    /// Unrelaxed speed of P waves, m/s.
    pub fn vp_unrelaxed(&self) -> f64 {
        self.vp * self.constrained.unrelaxed().sqrt()
    }

    /// Checks the values: positive, a bulk modulus that is positive relaxed and in every arm.
    pub fn check(&self) -> Result<(), SemError> {
        let layer = || self.name.clone();
        for (key, value) in [("rho", self.rho), ("vp", self.vp), ("vs", self.vs)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(SemError::Material { layer: layer(), key, value, range: "> 0" });
            }
        }
        let bulk = |(lambda, mu): (f64, f64)| lambda + 2.0 / 3.0 * mu;
        if bulk(self.relaxed()) <= 0.0 {
            return Err(SemError::Material {
                layer: layer(),
                key: "vp",
                value: self.vp,
                range: "above 2/√3 vs",
            });
        }
        let scale = bulk(self.unrelaxed());
        if (0..self.omega().len()).any(|l| bulk(self.arm(l)) < -1e-9 * scale) {
            return Err(SemError::ActiveBulk { material: layer(), vp: self.vp, vs: self.vs });
        }
        Ok(())
    }
}
