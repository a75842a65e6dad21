//! Constant damping ratio in the time domain.
//!
//! The law is the causal one (Kjartansson 1979): with $D = \mathrm{Im}\,G/(2\,\mathrm{Re}\,G)$ the same
//! at every frequency,
//! $$ G(\omega) = G_{\mathrm{ref}}\,\frac{(i\omega/\omega_{\mathrm{ref}})^{2\gamma}}{\cos\pi\gamma},
//!    \qquad \gamma = \frac{\arctan 2D}{\pi}, $$
//! so that $\mathrm{Re}\,G(\omega_{\mathrm{ref}}) = G_{\mathrm{ref}}$ and $\mathrm{Re}\,G$ rises by about
//! $4D/\pi$ per factor e of frequency. In the time domain it is a spring beside $L$ Maxwell arms,
//! $$ \hat G(\omega) = G_R + \sum_{l=1}^L g_l\,\frac{i\omega}{\omega_l + i\omega}, \qquad G_R, g_l, \omega_l > 0, $$
//! fitted to the *complex* modulus over the band in the Chebyshev sense, since a modulus that fits $D$
//! alone gets the wave speed wrong.

use crate::SemError;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Most mechanisms on offer.
pub const MECHANISMS_MAX: usize = 12;

/// How a modulus depends on frequency, as a factor on its value at the reference frequency.
#[derive(Debug, Clone, PartialEq)]
pub enum ModulusLaw {
    /// Elastic: 1 at every frequency.
    Elastic,
    /// The causal constant-D law.
    ConstantDamping {
        /// Damping ratio D.
        damping: f64,
        /// Reference frequency, Hz.
        reference_frequency: f64,
    },
    /// Memory variables, as the time domain has them.
    Maxwell(MaxwellArms),
}

impl ModulusLaw {
    /// Factor $G(\omega)/G_{\mathrm{ref}}$ where `i_omega` stands for $i\omega$ (or for its discrete symbol).
    pub fn factor(&self, i_omega: Complex64) -> Complex64 {
        match self {
            Self::Elastic => Complex64::ONE,
            Self::ConstantDamping { damping, reference_frequency } => {
                constant_damping_factor(*damping, i_omega / (2.0 * PI * reference_frequency))
            }
            Self::Maxwell(arms) => arms.factor(i_omega),
        }
    }
}

/// $(s)^{2\gamma}/\cos\pi\gamma$ for $s = i\omega/\omega_{\mathrm{ref}}$; 1 for D = 0.
pub fn constant_damping_factor(damping: f64, s: Complex64) -> Complex64 {
    let gamma = (2.0 * damping).atan() / PI;
    s.powf(2.0 * gamma) / (PI * gamma).cos()
}

/// A spring and Maxwell arms in parallel, as factors on the modulus at the reference frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct MaxwellArms {
    /// Relaxed modulus factor $G_R$.
    pub relaxed: f64,
    /// Relaxation frequencies $\omega_l$, rad/s, increasing.
    pub omega: Vec<f64>,
    /// Arm moduli $g_l$.
    pub modulus: Vec<f64>,
}

impl MaxwellArms {
    /// No arms: an elastic layer.
    pub fn elastic() -> Self {
        Self { relaxed: 1.0, omega: vec![], modulus: vec![] }
    }

    /// Unrelaxed modulus factor $G_R + \sum g_l$: what a fast step feels, hence what bounds the step.
    pub fn unrelaxed(&self) -> f64 {
        self.relaxed + self.modulus.iter().sum::<f64>()
    }

    /// Modulus factor at $i\omega$ (or at its discrete symbol).
    pub fn factor(&self, i_omega: Complex64) -> Complex64 {
        let arms = self.omega.iter().zip(&self.modulus).map(|(w, g)| *g * i_omega / (w + i_omega));
        self.relaxed + arms.sum::<Complex64>()
    }

    /// Damping ratio at an angular frequency.
    pub fn damping(&self, omega: f64) -> f64 {
        let g = self.factor(Complex64::new(0.0, omega));
        0.5 * g.im / g.re
    }

    /// Fits `mechanisms` arms to the constant-D law over `band` (Hz).
    ///
    /// The error $|\hat G/G - 1|/(2D)$ is made as small as possible in the maximum norm over the band
    /// by a Levenberg–Marquardt iteration on logarithms (so that every arm stays positive) inside
    /// Lawson's reweighting. Two decades need 5 arms for 0.5 % of D, 3 for 6 %. Elastic for D = 0.
    /// Cost: milliseconds for a few arms, a tenth of a second for ten. Errors: more than [`MECHANISMS_MAX`] or no arm with D > 0.
    pub fn fit(
        damping: f64,
        reference_frequency: f64,
        band: (f64, f64),
        mechanisms: usize,
    ) -> Result<Self, SemError> {
        if damping == 0.0 {
            return Ok(Self::elastic());
        }
        let (f_min, f_max) = band;
        let failed = || SemError::Fit { mechanisms, damping, f_min, f_max };
        if mechanisms == 0 || mechanisms > MECHANISMS_MAX || !(f_min > 0.0 && f_max > f_min) {
            return Err(failed());
        }
        let centre = (f_min * f_max).sqrt();
        let mut fit = Fit::new(damping, (f_max / f_min).ln(), mechanisms);
        let p = fit.minimax().ok_or_else(failed)?;
        // the fit has the band's centre as reference; a power law only changes by a factor
        let gamma = (2.0 * damping).atan() / PI;
        let scale = (centre / reference_frequency).powf(2.0 * gamma);
        let mut arms: Vec<(f64, f64)> = (0..mechanisms)
            .map(|l| (2.0 * PI * centre * p[1 + l].exp(), scale * p[1 + mechanisms + l].exp()))
            .collect();
        arms.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (omega, modulus) = arms.into_iter().unzip();
        Ok(Self { relaxed: scale * p[0].exp(), omega, modulus })
    }

    /// Fits the moduli of arms at given relaxation frequencies (rad/s) to the constant-D law over `band`.
    ///
    /// The complex error relative to 2D is weighted least squares (Lawson's weights towards its largest
    /// value) in the moduli alone, a linear problem; a modulus that would turn negative is left out.
    pub fn fit_at(
        damping: f64,
        reference_frequency: f64,
        band: (f64, f64),
        omega: &[f64],
    ) -> Result<Self, SemError> {
        if damping == 0.0 {
            return Ok(Self { relaxed: 1.0, omega: omega.to_vec(), modulus: vec![0.0; omega.len()] });
        }
        let (f_min, f_max) = band;
        let failed = || SemError::Fit { mechanisms: omega.len(), damping, f_min, f_max };
        let points = 24 + 12 * omega.len();
        let s: Vec<Complex64> = (0..points)
            .map(|i| {
                let x = 0.5 * (1.0 - (PI * i as f64 / (points - 1) as f64).cos());
                Complex64::new(0.0, 2.0 * PI * f_min * (f_max / f_min).powf(x))
            })
            .collect();
        let target: Vec<Complex64> = (s.iter())
            .map(|s| constant_damping_factor(damping, s / (2.0 * PI * reference_frequency)))
            .collect();
        let mut kept: Vec<usize> = (0..omega.len()).collect();
        loop {
            let p = fit_moduli(&s, &target, omega, &kept).ok_or_else(failed)?;
            match kept.iter().zip(p.iter().skip(1)).find(|(_, g)| **g <= 0.0) {
                Some((&arm, _)) => kept.retain(|&l| l != arm),
                None => {
                    let mut modulus = vec![0.0; omega.len()];
                    kept.iter().zip(p.iter().skip(1)).for_each(|(&l, g)| modulus[l] = *g);
                    return Ok(Self { relaxed: p[0], omega: omega.to_vec(), modulus });
                }
            }
        }
    }
}

/// Relaxed modulus and those of the arms `kept`, by Lawson-weighted linear least squares.
fn fit_moduli(s: &[Complex64], target: &[Complex64], omega: &[f64], kept: &[usize]) -> Option<DVector<f64>> {
    let (n, columns) = (s.len(), kept.len() + 1);
    let basis = |i: usize, c: usize| match c {
        0 => 1.0 / target[i],
        _ => s[i] / (omega[kept[c - 1]] + s[i]) / target[i],
    };
    let mut weight = vec![1.0_f64; n];
    let mut best: Option<(f64, DVector<f64>)> = None;
    for _ in 0..30 {
        let part = |z: Complex64, i: usize| if i < n { z.re } else { z.im };
        let matrix = DMatrix::from_fn(2 * n, columns, |i, c| weight[i % n].sqrt() * part(basis(i % n, c), i));
        let right = DVector::from_fn(2 * n, |i, _| weight[i % n].sqrt() * part(Complex64::ONE, i));
        let p = matrix.svd(true, true).solve(&right, 1e-14).ok()?;
        let error: Vec<f64> = (0..n)
            .map(|i| ((0..columns).map(|c| p[c] * basis(i, c)).sum::<Complex64>() - 1.0).norm())
            .collect();
        let worst = error.iter().fold(0.0_f64, |m, e| m.max(*e));
        if best.as_ref().is_none_or(|(b, _)| worst < *b) {
            best = Some((worst, p));
        }
        for (w, e) in weight.iter_mut().zip(&error) {
            *w = (*w * e / worst.max(f64::MIN_POSITIVE)).max(1e-6);
        }
    }
    best.map(|(_, p)| p)
}

/// The fitting problem in frequencies relative to the band's centre.
struct Fit {
    damping: f64,
    mechanisms: usize,
    half_span: f64,
    s: Vec<Complex64>,
    target: Vec<Complex64>,
    weight: Vec<f64>,
}

impl Fit {
    fn new(damping: f64, span: f64, mechanisms: usize) -> Self {
        let points = 24 + 12 * mechanisms;
        let half_span = 0.5 * span;
        let s: Vec<Complex64> = (0..points)
            .map(|i| {
                // denser at the ends, where the error of a minimax fit is largest
                let x = -half_span * (PI * i as f64 / (points - 1) as f64).cos();
                Complex64::new(0.0, x.exp())
            })
            .collect();
        let target = s.iter().map(|&s| constant_damping_factor(damping, s)).collect();
        Self { damping, mechanisms, half_span, target, weight: vec![1.0; s.len()], s }
    }

    /// Logarithms of $G_R$, $\omega_l$, $g_l$.
    fn start(&self) -> DVector<f64> {
        let l = self.mechanisms;
        let mut p = DVector::zeros(1 + 2 * l);
        // the best arms reach about a factor e beyond the band, where its ends need them
        let reach = self.half_span + 1.0;
        let spacing = if l > 1 { 2.0 * reach / (l as f64 - 1.0) } else { 2.0 * reach };
        let rise = 4.0 * self.damping / PI;
        p[0] = (1.0 - 0.5 * rise * reach).max(0.2).ln();
        for k in 0..l {
            p[1 + k] = if l > 1 { -reach + spacing * k as f64 } else { 0.0 };
            p[1 + l + k] = (rise * spacing).max(1e-6).ln();
        }
        p
    }

    fn error(&self, p: &DVector<f64>) -> Vec<Complex64> {
        let l = self.mechanisms;
        (self.s.iter().zip(&self.target))
            .map(|(s, target)| {
                let arms = (0..l).map(|k| p[1 + l + k].exp() * s / (p[1 + k].exp() + s));
                ((p[0].exp() + arms.sum::<Complex64>()) / target - 1.0) / (2.0 * self.damping)
            })
            .collect()
    }

    fn weighted(&self, p: &DVector<f64>) -> DVector<f64> {
        let e = self.error(p);
        let n = e.len();
        DVector::from_fn(2 * n, |i, _| self.weight[i % n] * if i < n { e[i].re } else { e[i - n].im })
    }

    fn jacobian(&self, p: &DVector<f64>) -> DMatrix<f64> {
        let (l, n) = (self.mechanisms, self.s.len());
        let mut jacobian = DMatrix::zeros(2 * n, p.len());
        for (i, s) in self.s.iter().enumerate() {
            let scale = self.weight[i] / (2.0 * self.damping * self.target[i]);
            let mut set = |column: usize, value: Complex64| {
                jacobian[(i, column)] = (scale * value).re;
                jacobian[(n + i, column)] = (scale * value).im;
            };
            set(0, Complex64::new(p[0].exp(), 0.0));
            for k in 0..l {
                let (w, g) = (p[1 + k].exp(), p[1 + l + k].exp());
                set(1 + k, -g * w * s / ((w + s) * (w + s)));
                set(1 + l + k, g * s / (w + s));
            }
        }
        jacobian
    }

    /// Levenberg–Marquardt at the present weights.
    ///
    /// Each step solves the damped problem by an orthogonal factorisation: arms overlap so much that the
    /// normal equations would lose the digits that tell ten of them from eleven.
    fn least_squares(&self, mut p: DVector<f64>) -> DVector<f64> {
        let mut damping = 1e-3;
        let mut r = self.weighted(&p);
        for _ in 0..100 {
            let j = self.jacobian(&p);
            let (rows, columns) = j.shape();
            let scale: Vec<f64> = j.column_iter().map(|c| c.norm().max(1e-12)).collect();
            let mut improved = false;
            for _ in 0..12 {
                let mut stacked = j.clone().insert_rows(rows, columns, 0.0);
                for d in 0..columns {
                    stacked[(rows + d, d)] = f64::sqrt(damping) * scale[d];
                }
                let mut right = r.clone().insert_rows(rows, columns, 0.0);
                let qr = stacked.qr();
                qr.q_tr_mul(&mut right);
                let Some(step) = qr.unpack_r().solve_upper_triangular(&right.rows(0, columns)) else {
                    damping *= 10.0;
                    continue;
                };
                let trial = &p - step.map(|s| s.clamp(-1.0, 1.0));
                let r_trial = self.weighted(&trial);
                if r_trial.norm_squared() < r.norm_squared() {
                    let gain = 1.0 - r_trial.norm_squared() / r.norm_squared();
                    (p, r) = (trial, r_trial);
                    damping = (damping * 0.2).max(1e-14);
                    improved = gain > 1e-5;
                    break;
                }
                damping *= 5.0;
            }
            if !improved {
                break;
            }
        }
        p
    }

    /// Lawson's reweighting towards the smallest largest error; `None` if nothing finite was found.
    fn minimax(&mut self) -> Option<DVector<f64>> {
        let mut p = self.start();
        let mut best: Option<(f64, DVector<f64>)> = None;
        for _ in 0..30 {
            p = self.least_squares(p);
            let size: Vec<f64> = self.error(&p).iter().map(|e| e.norm()).collect();
            let largest = size.iter().fold(0.0_f64, |m, &e| if e <= m { m } else { e });
            if !largest.is_finite() {
                break;
            }
            let gain = best.as_ref().map_or(1.0, |(b, _)| 1.0 - largest / b);
            if gain > 0.0 {
                best = Some((largest, p.clone()));
            }
            if gain.abs() < 1e-4 {
                break;
            }
            for (w, e) in self.weight.iter_mut().zip(&size) {
                *w *= (e / largest + 0.05).sqrt();
            }
            let top = self.weight.iter().fold(0.0_f64, |m, &w| m.max(w));
            self.weight.iter_mut().for_each(|w| *w /= top);
        }
        best.map(|(_, p)| p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_within_half_a_percent_over_two_decades_with_five_arms() {
        for damping in [0.005, 0.01, 0.02, 0.05, 0.1, 0.2] {
            let arms = MaxwellArms::fit(damping, 2.0, (0.2, 20.0), 5).unwrap();
            for i in 0..=400 {
                let omega = 2.0 * PI * 0.2 * 100f64.powf(i as f64 / 400.0);
                let d = arms.damping(omega);
                assert!((d / damping - 1.0).abs() <= 0.005, "D = {damping} at {omega}: {d}");
                let exact = constant_damping_factor(damping, Complex64::new(0.0, omega / (4.0 * PI)));
                let g = arms.factor(Complex64::new(0.0, omega));
                assert!((g / exact - 1.0).norm() <= 0.01 * damping, "G at {omega}: {g} against {exact}");
            }
        }
    }

    #[test]
    fn the_error_falls_with_every_arm_on_any_band() {
        for span in [3.0, 30.0, 300.0, 1e4] {
            let error = |mechanisms: usize| {
                let arms = MaxwellArms::fit(0.03, 1.0, (0.1, 0.1 * span), mechanisms).unwrap();
                (0..=300).fold(0.0_f64, |m, i| {
                    let omega = 2.0 * PI * 0.1 * span.powf(i as f64 / 300.0);
                    m.max((arms.damping(omega) / 0.03 - 1.0).abs())
                })
            };
            let e: Vec<f64> = (1..=MECHANISMS_MAX).map(error).collect();
            for w in e.windows(2) {
                assert!(w[1] < 0.6 * w[0] || w[1] < 1e-5, "span {span}: {e:?}");
            }
        }
    }

    #[test]
    fn reference_frequency_need_not_be_the_centre_of_the_band() {
        let arms = MaxwellArms::fit(0.05, 1.0, (0.2, 20.0), 6).unwrap();
        let g = arms.factor(Complex64::new(0.0, 2.0 * PI));
        assert!((g.re - 1.0).abs() < 2e-4, "{g}");
    }

    #[test]
    fn real_part_rises_by_four_d_over_pi_per_factor_e() {
        let at = |f: f64| constant_damping_factor(0.02, Complex64::new(0.0, f)).re;
        assert!((at(1f64.exp()) / at(1.0) - 1.0 - 0.08 / PI).abs() < 5e-4);
    }

    #[test]
    fn zero_damping_is_elastic_and_bad_bands_are_refused() {
        assert_eq!(MaxwellArms::fit(0.0, 1.0, (0.1, 10.0), 3).unwrap(), MaxwellArms::elastic());
        for (band, mechanisms) in
            [((1.0, 1.0), 3), ((0.0, 10.0), 3), ((0.1, 10.0), 0), ((0.1, 10.0), MECHANISMS_MAX + 1)]
        {
            assert!(MaxwellArms::fit(0.1, 1.0, band, mechanisms).is_err());
        }
    }
}
