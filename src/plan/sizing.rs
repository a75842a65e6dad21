//! Predicts the error of a mesh, a step and a damping fit, and finds the cheapest that meets a target.
//!
//! Every prediction is a difference of complex frequency responses of the same column
//! ([`FrequencyResponse`]), weighted with the spectrum of the control motion, so by Parseval it is the
//! relative L2 error in time, inside the band, of the acceleration at each station. Three differences
//! against the converged response (order 10, exact time, exact law) are taken once and added as
//! complex numbers, to first order: that of each mesh in exact time, that of a step on the converged
//! mesh (it scales with Δt²), that of each number of mechanisms. The chosen triple is then evaluated
//! as it will run.

use super::PlanError;
use hati_sem::attenuation::{MECHANISMS_MAX, MaxwellArms, ModulusLaw, constant_damping_factor};
use hati_sem::column::{Column, Discretisation, Element, FrequencyResponse, TimeSymbol};
use hati_sem::gll::{Gll, ORDER_MAX};
use hati_sem::soil::Profile;
use num_complex::Complex64;
use serde::Serialize;

/// Motion that the scene gives and all others are measured against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Control {
    /// Outcrop motion.
    Outcrop,
    /// Motion of the base.
    Within,
    /// Motion of the surface.
    Surface,
}

/// Spectrum of the control motion of one component: weights $|A|^2$ at frequencies, Hz.
#[derive(Debug, Clone)]
pub struct Weight {
    /// Component, 0 = x, 1 = y, 2 = z.
    pub axis: usize,
    /// $|A(f)|^2$ at [`Sizer::frequencies`].
    pub power: Vec<f64>,
}

/// A mesh, a step and a number of mechanisms with what they cost and promise.
#[derive(Debug, Clone, Serialize)]
pub struct Candidate {
    /// Order and elements.
    pub discretisation: Discretisation,
    /// Steps per sample of the record.
    pub substeps: usize,
    /// Memory variables per layer.
    pub mechanisms: usize,
    /// Predicted relative L2 error, largest over stations and components.
    pub error: f64,
    /// Estimated solver time, s.
    pub cost: f64,
}

/// What the user fixed; `None` is left to the sizing.
#[derive(Debug, Clone, Default)]
pub struct Fixed {
    /// Polynomial order.
    pub order: Option<usize>,
    /// Elements per layer.
    pub elements: Option<Vec<usize>>,
    /// Steps per sample.
    pub substeps: Option<usize>,
    /// Mechanisms.
    pub mechanisms: Option<usize>,
}

impl Fixed {
    fn is_free(&self) -> bool {
        self.order.is_none()
            && self.elements.is_none()
            && self.substeps.is_none()
            && self.mechanisms.is_none()
    }
}

/// Responses of one model: `[axis][frequency][station]`, flattened.
type Responses = Vec<Vec<Complex64>>;

/// Everything that the search needs to know of a scene.
pub struct Sizer<'a> {
    /// The column as it will run: rigid base where the base motion is imposed.
    pub profile: &'a Profile,
    /// Control motion.
    pub control: Control,
    /// Frequencies inside the band, Hz.
    pub frequencies: Vec<f64>,
    /// Growth rate at which responses are taken, 1/s: π/2 times the spacing of `frequencies`, so that no
    /// resonance falls between two of them.
    pub growth: f64,
    /// Spectral weights of each active component.
    pub weights: Vec<Weight>,
    /// Station depths, m.
    pub stations: Vec<f64>,
    /// Band of the damping fit, Hz.
    pub band: (f64, f64),
    /// Record's step, s.
    pub record_dt: f64,
    /// Samples that the run will have.
    pub samples: usize,
}

/// Most elements of a column, as many as a scene may give.
const ELEMENTS_LIMIT: usize = 20_000;

/// Points beyond which no finer mesh is tried.
const POINTS_MAX: usize = 20_000;

/// Nanoseconds of a column's step: constant, and per block of four elements with n points and L
/// mechanisms a constant, n, n² and n·L. From `cargo bench -p hati-sem` on one 2.x GHz server core; only
/// ratios matter for the choice, the plan prints the sum as an estimate.
const COST_STEP: f64 = 30.0;
const COST_BLOCK: [f64; 4] = [25.0, 12.0, 2.0, 6.5];

impl Sizer<'_> {
    fn axes(&self) -> Vec<usize> {
        self.weights.iter().map(|w| w.axis).collect()
    }

    /// Laws of all layers for one component: exact, or fitted arms.
    fn laws(&self, axis: usize, arms: Option<&[[MaxwellArms; 3]]>) -> Vec<ModulusLaw> {
        (self.profile.layers.iter().enumerate())
            .map(|(i, l)| match (arms, l.damping(axis)) {
                (_, 0.0) => ModulusLaw::Elastic,
                (Some(arms), _) => ModulusLaw::Maxwell(arms[i][axis].clone()),
                (None, damping) => ModulusLaw::ConstantDamping {
                    damping,
                    reference_frequency: self.profile.reference_frequency,
                },
            })
            .collect()
    }

    /// Arms of every layer and component with `mechanisms` each.
    pub fn arms(&self, mechanisms: usize) -> Result<Vec<[MaxwellArms; 3]>, PlanError> {
        fit_arms(self.profile, self.band, mechanisms)
    }

    fn responses(
        &self,
        mesh: &Discretisation,
        arms: Option<&[[MaxwellArms; 3]]>,
        symbol: TimeSymbol,
    ) -> Result<Responses, PlanError> {
        let mut depths = self.stations.clone();
        depths.push(0.0);
        let mut all = vec![];
        for weight in &self.weights {
            let laws = self.laws(weight.axis, arms);
            let response = FrequencyResponse::new(self.profile, mesh, weight.axis, &laws, symbol, &depths)?;
            let mut values = Vec::with_capacity(self.frequencies.len() * self.stations.len());
            for &f in &self.frequencies {
                let t = response.at_growing(f, self.growth);
                let surface = t.per_within[self.stations.len()];
                let control = match self.control {
                    Control::Outcrop => t.within_per_outcrop,
                    Control::Within => Complex64::ONE,
                    Control::Surface => 1.0 / surface,
                };
                values.extend(t.per_within[..self.stations.len()].iter().map(|h| h * control));
            }
            all.push(values);
        }
        Ok(all)
    }

    /// Largest relative L2 error over stations and components of a sum of differences.
    fn error(&self, differences: &[(&Responses, f64)], reference: &Responses) -> f64 {
        let n = self.stations.len();
        let mut worst = 0.0_f64;
        for (a, weight) in self.weights.iter().enumerate() {
            let (mut wrong, mut right) = (vec![0.0; n], vec![0.0; n]);
            for (k, power) in weight.power.iter().enumerate() {
                for s in 0..n {
                    let i = k * n + s;
                    let d: Complex64 = differences.iter().map(|(d, scale)| d[a][i] * *scale).sum();
                    wrong[s] += power * d.norm_sqr();
                    right[s] += power * reference[a][i].norm_sqr();
                }
            }
            for s in 0..n {
                if right[s] > 0.0 {
                    worst = worst.max((wrong[s] / right[s]).sqrt());
                }
            }
        }
        worst
    }

    /// A mesh on which the space error is below 1e-9 over the band: order 10, an element per wavelength.
    ///
    /// Error: more than [`ELEMENTS_LIMIT`] elements; the layer with most elements is named.
    pub fn converged_mesh(&self) -> Result<Discretisation, PlanError> {
        let mesh = Discretisation { order: ORDER_MAX, elements: self.elements(1.0) };
        self.check_elements(&mesh)?;
        Ok(mesh)
    }

    fn check_elements(&self, mesh: &Discretisation) -> Result<(), PlanError> {
        let elements = mesh.elements.iter().sum::<usize>();
        if elements <= ELEMENTS_LIMIT {
            return Ok(());
        }
        let layer = (0..mesh.elements.len()).max_by_key(|&i| mesh.elements[i]).unwrap_or(0);
        Err(PlanError::TooManyElements {
            elements,
            limit: ELEMENTS_LIMIT,
            layer: self.profile.layers[layer].name.clone(),
            in_layer: mesh.elements[layer],
            f_max: self.band.1,
        })
    }

    /// Shortest wave speed of a layer in the band over all components, m/s: that of the damped modulus at
    /// the band's upper end, where wavelengths are shortest.
    fn slowest(&self, layer: usize) -> f64 {
        let l = &self.profile.layers[layer];
        let speed = |axis: usize| {
            let s = Complex64::new(0.0, self.band.1 / self.profile.reference_frequency);
            l.speed(axis) * constant_damping_factor(l.damping(axis), s).norm().sqrt()
        };
        self.axes().into_iter().map(speed).fold(f64::INFINITY, f64::min)
    }

    /// Elements per layer for `per_wavelength` elements in the shortest wavelength of each layer.
    fn elements(&self, per_wavelength: f64) -> Vec<usize> {
        (self.profile.layers.iter().enumerate())
            .map(|(i, l)| {
                ((l.thickness * self.band.1 / self.slowest(i) * per_wavelength).ceil() as usize).max(1)
            })
            .collect()
    }

    /// Finds the cheapest candidate whose predicted error stays below `target`.
    ///
    /// Returns the chosen one and its parts. If nothing meets the target within
    /// the user's fixed values, the most accurate one is returned.
    pub fn search(&self, target: f64, fixed: &Fixed) -> Result<Search, PlanError> {
        let converged = self.converged_mesh()?;
        let reference = self.responses(&converged, None, TimeSymbol::Continuous)?;
        let subtract = |mut a: Responses| {
            a.iter_mut().zip(&reference).for_each(|(a, r)| a.iter_mut().zip(r).for_each(|(a, r)| *a -= r));
            a
        };
        let fits = self.fits(target, fixed, &converged, &reference, &subtract)?;
        let probe_dt = 0.01 / self.band.1;
        let time = subtract(self.responses(&converged, None, TimeSymbol::CentralDifference(probe_dt))?);
        let time_error = self.error(&[(&time, 1.0)], &reference);
        let meshes = self.meshes(target, fixed, &reference, &subtract)?;
        let mut trials = vec![];
        for (m, mesh) in meshes.iter().enumerate() {
            for (l, fit) in fits.iter().enumerate() {
                let stable = self.stable_substeps(&mesh.discretisation, &fit.arms)?;
                for substeps in substep_choices(stable, fixed.substeps) {
                    let time_scale = (self.record_dt / substeps as f64 / probe_dt).powi(2);
                    let parts = [mesh.error, fit.error, time_scale * time_error];
                    let cost = self.cost(&mesh.discretisation, fit.mechanisms, substeps);
                    trials.push(Trial { cost, parts, mesh: m, fit: l, substeps, time_scale });
                }
            }
        }
        trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut search = self.choose(&trials, target, &meshes, &fits, &time, &reference)?;
        search.coarsest &= fixed.is_free();
        Ok(search)
    }

    /// Goes through the trials from the cheapest up.
    fn choose(
        &self,
        trials: &[Trial],
        target: f64,
        meshes: &[MeshChoice],
        fits: &[FitChoice],
        time: &Responses,
        reference: &Responses,
    ) -> Result<Search, PlanError> {
        let candidate = |t: &Trial, error: f64| Candidate {
            discretisation: meshes[t.mesh].discretisation.clone(),
            substeps: t.substeps,
            mechanisms: fits[t.fit].mechanisms,
            error,
            cost: t.cost,
        };
        let as_it_runs = |t: &Trial| self.discrete_error(&candidate(t, 0.0), &fits[t.fit].arms, reference);
        let mut best: Option<(f64, usize)> = None;
        for (i, t) in trials.iter().enumerate() {
            // errors of space and time have opposite signs and may cancel: no part may rely on that
            let mut error = t.parts.iter().copied().fold(0.0, f64::max);
            if error <= target {
                let sum =
                    [(&meshes[t.mesh].difference, 1.0), (&fits[t.fit].difference, 1.0), (time, t.time_scale)];
                error = error.max(self.error(&sum, reference));
            }
            if best.is_none_or(|(e, _)| error < e) {
                best = Some((error, i));
            }
            if error <= target {
                let exact = as_it_runs(t)?;
                if exact <= target {
                    let chosen = candidate(t, exact);
                    return Ok(Search {
                        chosen,
                        parts: t.parts,
                        weighed: i + 1,
                        met: true,
                        coarsest: i == 0,
                    });
                }
            }
        }
        let (_, i) = best.ok_or(PlanError::NoCandidate)?;
        let exact = as_it_runs(&trials[i])?;
        let (chosen, weighed) = (candidate(&trials[i], exact), trials.len());
        Ok(Search { chosen, parts: trials[i].parts, weighed, met: exact <= target, coarsest: false })
    }

    fn discrete_error(
        &self,
        c: &Candidate,
        arms: &[[MaxwellArms; 3]],
        reference: &Responses,
    ) -> Result<f64, PlanError> {
        let symbol = TimeSymbol::CentralDifference(self.record_dt / c.substeps as f64);
        let mut run = self.responses(&c.discretisation, Some(arms), symbol)?;
        run.iter_mut().zip(reference).for_each(|(a, r)| a.iter_mut().zip(r).for_each(|(a, r)| *a -= r));
        Ok(self.error(&[(&run, 1.0)], reference))
    }

    /// Damping fits with more and more mechanisms, until the error drops under a quarter of the target.
    fn fits(
        &self,
        target: f64,
        fixed: &Fixed,
        converged: &Discretisation,
        reference: &Responses,
        subtract: &dyn Fn(Responses) -> Responses,
    ) -> Result<Vec<FitChoice>, PlanError> {
        let axes = self.axes();
        let damped = self.profile.layers.iter().any(|l| axes.iter().any(|&a| l.damping(a) > 0.0));
        let numbers: Vec<usize> = match (damped, fixed.mechanisms) {
            (false, _) => vec![0],
            (true, Some(n)) => vec![n],
            (true, None) => (1..=MECHANISMS_MAX).collect(),
        };
        let mut fits = vec![];
        for mechanisms in numbers {
            let arms = self.arms(mechanisms)?;
            let difference = subtract(self.responses(converged, Some(&arms), TimeSymbol::Continuous)?);
            let error = self.error(&[(&difference, 1.0)], reference);
            fits.push(FitChoice { mechanisms, arms, difference, error });
            if error < 0.25 * target {
                break;
            }
        }
        Ok(fits)
    }

    /// Meshes over order and size with their space errors, from the coarsest until errors drop under a
    /// quarter of the target (a finer one leaves nothing to gain) or [`POINTS_MAX`] is passed.
    fn meshes(
        &self,
        target: f64,
        fixed: &Fixed,
        reference: &Responses,
        subtract: &dyn Fn(Responses) -> Responses,
    ) -> Result<Vec<MeshChoice>, PlanError> {
        let orders = fixed.order.map_or(1..=ORDER_MAX, |n| n..=n);
        let mut meshes: Vec<MeshChoice> = vec![];
        for order in orders {
            let mut before: Option<Vec<usize>> = None;
            for step in 0..24 {
                let points =
                    1.6 * 1.19_f64.powi(step) * if order <= 2 { 1.19_f64.powi(2 * step) } else { 1.0 };
                let elements = match &fixed.elements {
                    Some(elements) => elements.clone(),
                    None => self.elements(points / order as f64),
                };
                if before.as_ref() == Some(&elements) {
                    continue;
                }
                before = Some(elements.clone());
                let discretisation = Discretisation { order, elements };
                self.check_elements(&discretisation)?;
                let difference = subtract(self.responses(&discretisation, None, TimeSymbol::Continuous)?);
                let error = self.error(&[(&difference, 1.0)], reference);
                let finest = discretisation.elements.iter().sum::<usize>() * order > POINTS_MAX;
                meshes.push(MeshChoice { discretisation, difference, error });
                if error < 0.25 * target || finest {
                    break;
                }
            }
        }
        Ok(meshes)
    }

    /// Smallest number of steps per sample that is stable with 2 % in hand, from the bound of single
    /// elements (never below the true limit of the assembled column).
    fn stable_substeps(&self, mesh: &Discretisation, arms: &[[MaxwellArms; 3]]) -> Result<usize, PlanError> {
        let reference = element_omega(mesh.order)?;
        let mut omega = 0.0_f64;
        for (i, (l, &count)) in self.profile.layers.iter().zip(&mesh.elements).enumerate() {
            for axis in self.axes() {
                let speed = l.speed(axis) * arms[i][axis].unrelaxed().sqrt();
                omega = omega.max(2.0 * speed * count as f64 / l.thickness * reference);
            }
        }
        Ok(substeps_for(self.record_dt, 2.0 / omega))
    }

    /// Estimated solver time of a candidate, s.
    pub fn cost(&self, mesh: &Discretisation, mechanisms: usize, substeps: usize) -> f64 {
        let blocks = mesh.elements.iter().sum::<usize>().div_ceil(4) as f64;
        let (n, l) = ((mesh.order + 1) as f64, mechanisms as f64);
        let [fixed, row, square, arm] = COST_BLOCK;
        let step = COST_STEP + blocks * (fixed + row * n + square * n * n + arm * n * l);
        1e-9 * step * (self.samples * substeps * self.weights.len()) as f64
    }

    /// Critical step of the assembled column and the element that limits it.
    pub fn critical_step(
        &self,
        mesh: &Discretisation,
        arms: &[[MaxwellArms; 3]],
    ) -> Result<(f64, Element), PlanError> {
        let imposed = self.profile.base == hati_sem::soil::Base::Rigid;
        Ok(Column::critical_step(self.profile, mesh, arms, &self.axes(), imposed)?)
    }
}

/// Arms of every layer and component of a profile.
pub fn fit_arms(
    profile: &Profile,
    band: (f64, f64),
    mechanisms: usize,
) -> Result<Vec<[MaxwellArms; 3]>, PlanError> {
    let mut known: Vec<(f64, MaxwellArms)> = vec![];
    let mut fit = |damping: f64| -> Result<MaxwellArms, PlanError> {
        if mechanisms == 0 {
            return Ok(MaxwellArms::elastic());
        }
        if let Some((_, arms)) = known.iter().find(|(d, _)| *d == damping) {
            return Ok(arms.clone());
        }
        let arms = MaxwellArms::fit(damping, profile.reference_frequency, band, mechanisms)?;
        known.push((damping, arms.clone()));
        Ok(arms)
    };
    profile
        .layers
        .iter()
        .map(|l| {
            let (s, p) = (fit(l.damping_s)?, fit(l.damping_p)?);
            Ok([s.clone(), s, p])
        })
        .collect()
}

/// Margin between the step and its critical value.
pub const STEP_MARGIN: f64 = 0.98;

/// Steps per sample that keep the step under its critical value with [`STEP_MARGIN`].
pub fn substeps_for(record_dt: f64, dt_critical: f64) -> usize {
    ((record_dt / (STEP_MARGIN * dt_critical)).ceil() as usize).max(1)
}

fn substep_choices(stable: usize, fixed: Option<usize>) -> Vec<usize> {
    if let Some(k) = fixed {
        return vec![k];
    }
    let mut choices: Vec<usize> =
        (0..14).map(|i| (stable as f64 * 1.26_f64.powi(i)).round() as usize).collect();
    choices.dedup();
    choices
}

/// Largest eigenfrequency of the free reference element of length 2 with unit speed.
fn element_omega(order: usize) -> Result<f64, PlanError> {
    let gll = Gll::new(order)?;
    let n = gll.len();
    let d = |i: usize, j: usize| gll.derivative[i * n + j];
    let omega = hati_coupling::spectral_bound::omega_max(
        &gll.weights,
        |u, f| {
            f.fill(0.0);
            for q in 0..n {
                let strain: f64 = (0..n).map(|j| d(q, j) * u[j]).sum();
                for j in 0..n {
                    f[j] += gll.weights[q] * d(q, j) * strain;
                }
            }
        },
        1e-6,
    )?;
    Ok(omega)
}

/// One combination under trial.
struct Trial {
    cost: f64,
    /// Shares of space, damping fit and time.
    parts: [f64; 3],
    mesh: usize,
    fit: usize,
    substeps: usize,
    /// (Δt over the probe's Δt)².
    time_scale: f64,
}

struct MeshChoice {
    discretisation: Discretisation,
    difference: Responses,
    error: f64,
}

struct FitChoice {
    mechanisms: usize,
    arms: Vec<[MaxwellArms; 3]>,
    difference: Responses,
    error: f64,
}

/// Outcome of [`Sizer::search`].
#[derive(Debug, Clone)]
pub struct Search {
    /// The chosen candidate; its error is that of the discrete column as it will run.
    pub chosen: Candidate,
    /// Predicted shares: space, damping fit, time.
    pub parts: [f64; 3],
    /// Candidates weighed, cheapest first, the chosen one included.
    pub weighed: usize,
    /// Whether the target is met.
    pub met: bool,
    /// Whether nothing is fixed and nothing cheaper exists: the coarsest model that layers, record and
    /// stability permit.
    pub coarsest: bool,
}
