//! Which memory variables a point keeps: all mechanisms, or one of them.

use super::geometry::point;
use super::material::Material;
use crate::SemError;
use crate::attenuation::MaxwellArms;
use crate::gll::Gll;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// How memory variables are spread over an element's points.
///
/// **Coarse.** An element's points are dealt out to the mechanisms, class $(i+j+k) \bmod L$ of the point with
/// indices i, j, k along the local axes, and a point keeps the arm of its class alone. With $\varphi_l$ the share of the
/// quadrature's weight that arm $l$'s points carry, such a point has, of a modulus $R + \sum_l g_l\,i\omega/(\omega_l+i\omega)$,
/// $$ \hat M_l(\omega) = R + \sum_m r_m g_m +
///    \frac{g_l}{\varphi_l}\left(\frac{i\omega}{\omega_l + i\omega} - r_l\right), $$
/// so that the element's average $\sum_l\varphi_l\hat M_l$ is the full law at every frequency, whatever the constants $r_l$,
/// which shift stiffness between the points. Long waves feel an element somewhere between its average modulus and its average
/// compliance, which differ by the variance in space, $\sum_l\varphi_l\delta_l^2$, $\delta_l = \hat M_l - M$. Its imaginary part,
/// which damping sees, is
/// $$ 2\sum_l\varphi_l\,\mathrm{Re}\,\delta_l\,\mathrm{Im}\,\delta_l $$
/// and linear in $r_l$, for no $r_l$ touches $\mathrm{Im}\,\delta_l$. The constants here make it vanish in least
/// squares over the band of the damping: stiff points are then no more and no less lossy than soft ones. With $r_l = 1$ the
/// unrelaxed modulus would be the same at every point (Day 1998), with $r_l = 0$ the relaxed one: 1/Q is then some
/// hundred times further off.
///
/// Relaxed moduli differ from point to point, by more the smaller Q is and the wider the band; one that is
/// not positive is refused.
///
/// Day (1998) and Day & Bradley (2001) for finite differences; van Driel & Nissen-Meyer (2014) for spectral elements.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Memory {
    /// Every mechanism at every point.
    #[default]
    Full,
    /// One mechanism at a point, the mechanisms in turn.
    Coarse,
}

/// A mechanism as a point has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointArm {
    /// Its number in the material.
    pub mechanism: usize,
    /// Relaxation frequency, rad/s.
    pub omega: f64,
    /// Moduli λ and μ, Pa.
    pub moduli: (f64, f64),
}

/// Law of the points of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct PointLaw {
    /// Relaxed moduli λ and μ, Pa.
    pub relaxed: (f64, f64),
    /// Arms beside them.
    pub arms: Vec<PointArm>,
}

impl PointLaw {
    /// Moduli λ and μ that a fast step feels, Pa.
    pub fn unrelaxed(&self) -> (f64, f64) {
        let plus = |sum: (f64, f64), arm: &PointArm| (sum.0 + arm.moduli.0, sum.1 + arm.moduli.1);
        self.arms.iter().fold(self.relaxed, plus)
    }
}

/// Least share of the quadrature's weight that a class may have, over its even share.
const LEAST_SHARE: f64 = 0.5;

/// Classes of an element's points and the laws of each material in them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Distribution {
    pub(super) memory: Memory,
    /// Class of each local point.
    pub(super) class: Vec<u8>,
    /// `[material][class]`.
    pub(super) laws: Vec<Vec<PointLaw>>,
}

impl Distribution {
    /// Every mechanism at every one of `points` points.
    pub(super) fn full(materials: &[Material], points: usize) -> Self {
        let law = |m: &Material| {
            let arm = |l: usize| PointArm { mechanism: l, omega: m.omega()[l], moduli: m.arm(l) };
            vec![PointLaw { relaxed: m.relaxed(), arms: (0..m.omega().len()).map(arm).collect() }]
        };
        Self { memory: Memory::Full, class: vec![0; points], laws: materials.iter().map(law).collect() }
    }

    /// One mechanism at a point.
    ///
    /// A material of fewer mechanisms than the richest one deals its own out over the same classes.
    /// Errors: too few points for so many mechanisms; a relaxed modulus that is not positive.
    pub(super) fn coarse(materials: &[Material], gll: &Gll, dimension: usize) -> Result<Self, SemError> {
        let classes = materials.iter().map(|m| m.omega().len()).max().unwrap_or(0).max(1);
        let (class, share) = deal_out(gll, dimension, classes);
        if share.iter().any(|s| s * (classes as f64) < LEAST_SHARE) {
            return Err(SemError::CoarseOrder { order: gll.len() - 1, dimension, mechanisms: classes });
        }
        let laws = materials.iter().map(|m| coarse_laws(m, &share)).collect::<Result<_, _>>()?;
        Ok(Self { memory: Memory::Coarse, class, laws })
    }

    /// Classes of points.
    pub(super) fn classes(&self) -> usize {
        self.laws.first().map_or(1, Vec::len)
    }

    /// Most arms that a point has.
    pub(super) fn arms(&self) -> usize {
        self.laws.iter().flatten().map(|l| l.arms.len()).max().unwrap_or(0)
    }
}

/// Class of every local point and the share of the weight that each class has.
fn deal_out(gll: &Gll, dimension: usize, classes: usize) -> (Vec<u8>, Vec<f64>) {
    let n = gll.len();
    let class: Vec<u8> =
        (0..n.pow(dimension as u32)).map(|p| ((p % n + p / n % n + p / (n * n)) % classes) as u8).collect();
    let mut share = vec![0.0; classes];
    for (p, &c) in class.iter().enumerate() {
        share[usize::from(c)] += point(gll, dimension, p).1 / 2.0_f64.powi(dimension as i32);
    }
    (class, share)
}

/// Laws of a material in each class, whose shares of the weight are given.
fn coarse_laws(material: &Material, share: &[f64]) -> Result<Vec<PointLaw>, SemError> {
    let omega = material.omega();
    let count = omega.len();
    if count == 0 {
        return Ok(vec![PointLaw { relaxed: material.relaxed(), arms: vec![] }; share.len()]);
    }
    let own: Vec<f64> = (0..count).map(|l| share.iter().skip(l).step_by(count).sum()).collect();
    let constrained = relaxed_factors(&material.constrained, &own, material.band);
    let shear = relaxed_factors(&material.shear, &own, material.band);
    let bulk = |(lambda, mu): (f64, f64)| lambda + 2.0 / 3.0 * mu;
    (0..share.len())
        .map(|class| {
            let l = class % count;
            let (lambda, mu) = material.arm(l);
            let moduli = (lambda / own[l], mu / own[l]);
            let relaxed = material.lame(constrained[l], shear[l]);
            for (modulus, value, mean) in [
                ("shear", relaxed.1, material.relaxed().1),
                ("bulk", bulk(relaxed), bulk(material.relaxed())),
            ] {
                if value <= 0.0 {
                    return Err(SemError::CoarseModulus {
                        material: material.name.clone(),
                        modulus,
                        share: value / mean,
                        frequency: omega[l] / TAU,
                    });
                }
            }
            Ok(PointLaw { relaxed, arms: vec![PointArm { mechanism: l, omega: omega[l], moduli }] })
        })
        .collect()
}

/// Frequencies at which the shift of stiffness is sought, denser at the ends of the band.
const FREQUENCIES: usize = 60;

/// Relaxed modulus of the points of each arm, $R + \sum_m r_m g_m - r_l g_l/\varphi_l$, as factors like the law's own.
///
/// $r$ makes $\sum_l \varphi_l\,\mathrm{Re}\,\delta_l\,\mathrm{Im}\,\delta_l / \mathrm{Im}\,M$ least in the mean of squares
/// over the band. Where that leaves a choice, it stays as near as can be to the $r$ that makes the real modulus the same
/// at every point in the middle of the band.
fn relaxed_factors(law: &MaxwellArms, share: &[f64], (low, high): (f64, f64)) -> Vec<f64> {
    let (count, middle) = (law.omega.len(), TAU * (low * high).sqrt());
    let part = |l: usize, omega: f64| {
        let i_omega = Complex64::new(0.0, omega);
        i_omega / (law.omega[l] + i_omega)
    };
    let mut r = DVector::from_fn(count, |l, _| part(l, middle).re);
    let strength = law.modulus.iter().sum::<f64>();
    if strength > 0.0 {
        let omega = |i: usize| {
            let x = (PI * (i as f64 + 0.5) / FREQUENCIES as f64).cos();
            middle * (high / low).powf(0.5 * x)
        };
        let losses: Vec<f64> = (0..FREQUENCIES)
            .map(|i| (0..count).map(|l| law.modulus[l] * part(l, omega(i)).im).sum())
            .collect();
        // φ_l Im δ_l g_l/φ_l over Im M; what is common to all points drops out, since Im δ has no mean
        let matrix = DMatrix::from_fn(FREQUENCIES, count, |i, l| {
            let g = law.modulus[l];
            g * (g / share[l] * part(l, omega(i)).im - losses[i]) / losses[i]
        });
        let missing = DVector::from_fn(FREQUENCIES, |i, _| {
            (0..count).map(|l| matrix[(i, l)] * (part(l, omega(i)).re - r[l])).sum::<f64>()
        });
        // no solution where the iteration fails: the even stiffness of the middle stands
        if let Ok(change) = matrix.svd(true, true).solve(&missing, 1e-9 * strength) {
            r += change;
        }
    }
    let even = law.relaxed + (0..count).map(|l| r[l] * law.modulus[l]).sum::<f64>();
    (0..count).map(|l| even - r[l] * law.modulus[l] / share[l]).collect()
}

/// How far coarse-grained memory may take 1/Q and the speed of long waves from the material's law at a frequency (Hz),
/// relative: what lies between the average of the points' moduli and the average of their compliances, $\tfrac12$ for the speed.
///
/// Worst of P and S. Waves of a few elements' length may fall beyond it where they are reflected by the pattern itself,
/// which repeats from element to element. Cost: none. Errors: those of [`super::Ground::set_memory`].
pub fn coarse_error(
    material: &Material,
    order: usize,
    dimension: usize,
    frequency: f64,
) -> Result<(f64, f64), SemError> {
    let gll = Gll::new(order)?;
    let (_, share) = deal_out(&gll, dimension, material.omega().len().max(1));
    let laws = &Distribution::coarse(std::slice::from_ref(material), &gll, dimension)?.laws[0];
    let i_omega = Complex64::new(0.0, TAU * frequency);
    let mut worst = (0.0_f64, 0.0_f64);
    for of in [|(lambda, mu): (f64, f64)| lambda + 2.0 * mu, |(_, mu): (f64, f64)| mu] {
        let modulus = |law: &PointLaw| {
            let arms = law.arms.iter().map(|a| of(a.moduli) * i_omega / (a.omega + i_omega));
            of(law.relaxed) + arms.sum::<Complex64>()
        };
        let mean: Complex64 = laws.iter().zip(&share).map(|(law, s)| *s * modulus(law)).sum();
        let compliance: Complex64 = laws.iter().zip(&share).map(|(law, s)| *s / modulus(law)).sum();
        let ratio = 1.0 / (compliance * mean);
        let loss = |g: Complex64| g.im / g.re;
        if mean.im > 0.0 {
            worst.0 = worst.0.max((loss(ratio * mean) / loss(mean) - 1.0).abs());
        }
        worst.1 = worst.1.max(0.5 * (ratio.re - 1.0).abs());
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soil::Layer;

    fn material(quality: f64, mechanisms: usize, ratio: f64) -> Material {
        let damping = 0.5 / quality;
        let layer = Layer {
            name: "soil".into(),
            thickness: 1.0,
            vs: 200.0,
            vp: 400.0,
            rho: 1900.0,
            damping_s: damping,
            damping_p: 0.8 * damping,
        };
        let band = (10.0 / f64::sqrt(ratio), 10.0 * f64::sqrt(ratio));
        Material::of_layer(&layer, 10.0, band, mechanisms).unwrap()
    }

    fn shear(law: &PointLaw, i_omega: Complex64) -> Complex64 {
        let arms = law.arms.iter().map(|a| a.moduli.1 * i_omega / (a.omega + i_omega));
        law.relaxed.1 + arms.sum::<Complex64>()
    }

    #[test]
    fn the_average_over_an_element_is_the_full_law() {
        for (order, dimension, mechanisms) in [(3, 2, 3), (4, 3, 3), (5, 3, 5), (8, 2, 6), (4, 3, 1)] {
            let gll = Gll::new(order).unwrap();
            let m = material(30.0, mechanisms, 10.0);
            let coarse = Distribution::coarse(std::slice::from_ref(&m), &gll, dimension).unwrap();
            let full = &Distribution::full(std::slice::from_ref(&m), coarse.class.len()).laws[0][0];
            for frequency in [0.01, 3.0, 10.0, 40.0, 1e4] {
                let i_omega = Complex64::new(0.0, TAU * frequency);
                let mut mean = Complex64::ZERO;
                for (p, class) in coarse.class.iter().enumerate() {
                    let weight = point(&gll, dimension, p).1 / 2.0_f64.powi(dimension as i32);
                    mean += weight * shear(&coarse.laws[0][usize::from(*class)], i_omega);
                }
                assert!((mean / shear(full, i_omega) - 1.0).norm() < 1e-13, "N = {order}, {frequency} Hz");
            }
        }
    }

    /// Σ φ Re δ Im δ over |M| Im M, the largest over a band of the same middle and `ratio`.
    fn correlation(m: &Material, ratio: f64) -> f64 {
        let gll = Gll::new(4).unwrap();
        let (_, share) = deal_out(&gll, 3, m.omega().len());
        let laws = &Distribution::coarse(std::slice::from_ref(m), &gll, 3).unwrap().laws[0];
        (0..=40).fold(0.0, |worst, i| {
            let i_omega = Complex64::new(0.0, TAU * 10.0 * ratio.powf(f64::from(i) / 40.0 - 0.5));
            let mean: Complex64 = laws.iter().zip(&share).map(|(l, s)| *s * shear(l, i_omega)).sum();
            let sum: f64 = (laws.iter().zip(&share))
                .map(|(l, _)| shear(l, i_omega) - mean)
                .zip(&share)
                .map(|(d, s)| s * d.re * d.im)
                .sum();
            worst.max((sum / mean.norm() / mean.im).abs())
        })
    }

    #[test]
    fn stiff_points_are_as_lossy_as_soft_ones() {
        for (mechanisms, ratio, limit) in [(2, 3.0, 5e-4), (3, 6.0, 4e-4), (5, 50.0, 3e-3)] {
            let m = material(50.0, mechanisms, ratio);
            let found = correlation(&m, ratio);
            assert!(found < limit, "{mechanisms}: {found:e}");
            // far out of the band nothing was asked for
            assert!(correlation(&m, 100.0 * ratio) > 20.0 * found, "{mechanisms}: {found:e}");
        }
    }

    #[test]
    fn materials_of_fewer_mechanisms_share_the_classes() {
        let materials =
            [material(30.0, 4, 10.0), material(50.0, 2, 10.0), Material::elastic("rock", 2e3, 4e3, 2e3)];
        let gll = Gll::new(5).unwrap();
        let coarse = Distribution::coarse(&materials, &gll, 3).unwrap();
        assert_eq!((coarse.classes(), coarse.arms()), (4, 1));
        let (_, share) = deal_out(&gll, 3, 4);
        for (m, laws) in materials.iter().zip(&coarse.laws) {
            let mean: f64 = laws.iter().zip(&share).map(|(l, s)| s * l.unrelaxed().1).sum();
            assert!((mean / m.unrelaxed().1 - 1.0).abs() < 1e-13, "{}", m.name);
        }
        assert_eq!(coarse.laws[1][3].arms[0].mechanism, 1);
    }

    #[test]
    fn what_cannot_be_spread_is_refused() {
        let gll = |order| Gll::new(order).unwrap();
        let coarse = |quality: f64, mechanisms, ratio, order, dimension| {
            let m = material(quality, mechanisms, ratio);
            Distribution::coarse(std::slice::from_ref(&m), &gll(order), dimension)
        };
        // both sides of the least quality for three mechanisms over a factor 6
        assert!(coarse(3.0, 3, 6.0, 4, 3).is_ok());
        let error = coarse(2.0, 3, 6.0, 4, 3).unwrap_err();
        assert!(
            matches!(error, SemError::CoarseModulus { modulus: "shear", share, .. } if share <= 0.0),
            "{error}"
        );
        // both sides of the most mechanisms that order 4 has points for in a section
        assert!(coarse(50.0, 5, 100.0, 4, 2).is_ok());
        assert!(matches!(coarse(50.0, 6, 100.0, 4, 2), Err(SemError::CoarseOrder { order: 4, .. })));
    }

    #[test]
    fn the_error_foreseen_falls_with_the_quality() {
        let at = |quality: f64, f: f64| coarse_error(&material(quality, 3, 6.0), 4, 3, f).unwrap();
        for f in [4.5, 10.0, 24.0] {
            let [weak, middle, strong] = [50.0, 25.0, 10.0].map(|quality| at(quality, f));
            assert!(
                weak.0 > 0.0 && weak.0 < 0.5 * middle.0 && middle.0 < 0.5 * strong.0,
                "{f} Hz: {middle:?}"
            );
            assert!(middle.0 < 1e-3 && middle.1 < 2e-4, "{f} Hz: {middle:?}");
        }
    }
}
