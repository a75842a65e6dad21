//! A chain of masses as a subdomain: the trait carries what an interface scheme will ask of it.

use hati_coupling::central_difference::{self, drift, kick};
use hati_coupling::spectral_bound::omega_max;
use hati_coupling::{CouplingError, Energies, State, Subdomain, window_response};

/// Masses in a row joined by springs, the first one tied to the ground; interface 0 is the last two.
struct SpringChain {
    mass: Vec<f64>,
    spring: Vec<f64>,
    dt: f64,
    step: u64,
    u: Vec<f64>,
    v: Vec<f64>,
    multiplier: [f64; 2],
    work: f64,
}

impl SpringChain {
    fn new(mass: &[f64], spring: &[f64], dt: f64) -> Self {
        let n = mass.len();
        let (mass, spring) = (mass.to_vec(), spring.to_vec());
        Self { mass, spring, dt, step: 0, u: vec![0.0; n], v: vec![0.0; n], multiplier: [0.0; 2], work: 0.0 }
    }

    fn internal_force(spring: &[f64], u: &[f64], f: &mut [f64]) {
        f.fill(0.0);
        for (i, k) in spring.iter().enumerate() {
            let below = if i == 0 { 0.0 } else { u[i - 1] };
            let s = k * (u[i] - below);
            f[i] += s;
            if i > 0 {
                f[i - 1] -= s;
            }
        }
    }
}

impl Subdomain for SpringChain {
    fn name(&self) -> &str {
        "chain"
    }
    fn dt(&self) -> f64 {
        self.dt
    }
    fn dt_critical(&self) -> Option<f64> {
        let omega = omega_max(&self.mass, |u, f| Self::internal_force(&self.spring, u, f), 1e-9).ok()?;
        Some(central_difference::dt_critical(omega))
    }
    fn time(&self) -> f64 {
        self.step as f64 * self.dt
    }
    fn step(&mut self) {
        let n = self.mass.len();
        let mut f = vec![0.0; n];
        let half = 0.5 * self.dt;
        for i in 0..n {
            self.u[i] = drift(self.u[i], self.v[i], half);
        }
        Self::internal_force(&self.spring, &self.u, &mut f);
        for i in 0..n {
            let external = if i + 2 >= n { self.multiplier[i + 2 - n] } else { 0.0 };
            let before = self.v[i];
            self.v[i] = kick(before, external - f[i], self.dt / self.mass[i]);
            self.work += self.dt * external * 0.5 * (before + self.v[i]);
            self.u[i] = drift(self.u[i], self.v[i], half);
        }
        self.step += 1;
    }
    fn interface_count(&self) -> usize {
        1
    }
    fn interface_len(&self, _: usize) -> usize {
        2
    }
    fn interface_position(&self, _: usize, position: &mut [f64]) {
        position.copy_from_slice(&self.u[self.u.len() - 2..]);
    }
    fn interface_velocity(&self, _: usize, velocity: &mut [f64]) {
        velocity.copy_from_slice(&self.v[self.v.len() - 2..]);
    }
    fn set_multiplier(&mut self, _: usize, multiplier: &[f64]) {
        self.multiplier.copy_from_slice(multiplier);
    }
    fn energies(&mut self) -> Energies {
        let n = self.mass.len();
        let (mut ku, mut kv) = (vec![0.0; n], vec![0.0; n]);
        Self::internal_force(&self.spring, &self.u, &mut ku);
        Self::internal_force(&self.spring, &self.v, &mut kv);
        let kinetic = (0..n).map(|i| 0.5 * self.mass[i] * self.v[i].powi(2)).sum();
        let strain =
            (0..n).map(|i| 0.5 * self.u[i] * ku[i] - 0.125 * self.dt.powi(2) * self.v[i] * kv[i]).sum();
        Energies { input: self.work, kinetic, strain, ..Energies::default() }
    }
    fn save(&self, state: &mut State) {
        state.step = self.step;
        state.values.clear();
        state.values.extend(&self.u);
        state.values.extend(&self.v);
        state.values.push(self.work);
    }
    fn restore(&mut self, state: &State) -> Result<(), CouplingError> {
        let n = self.mass.len();
        if state.values.len() != 2 * n + 1 {
            let (found, expected) = (state.values.len(), 2 * n + 1);
            return Err(CouplingError::StateSize { subdomain: self.name().into(), found, expected });
        }
        self.step = state.step;
        self.u.copy_from_slice(&state.values[..n]);
        self.v.copy_from_slice(&state.values[n..2 * n]);
        self.work = state.values[2 * n];
        Ok(())
    }
}

fn chain(dt: f64) -> SpringChain {
    SpringChain::new(&[1.0, 0.5, 2.0, 0.3], &[3.0, 10.0, 4.0, 7.0], dt)
}

#[test]
fn window_response_is_symmetric_and_leaves_the_subdomain_alone() {
    let mut sub = chain(0.05);
    sub.set_multiplier(0, &[0.2, -1.0]);
    (0..37).for_each(|_| sub.step());
    let (mut before, mut after) = (State::default(), State::default());
    sub.save(&mut before);
    let y = window_response(&mut sub, 0, 10).unwrap();
    sub.save(&mut after);
    assert_eq!(before, after);
    assert!((y[(0, 1)] - y[(1, 0)]).abs() < 1e-15 * y[(0, 0)].abs().max(1.0), "{y}");
    assert!(y.symmetric_eigenvalues().min() > 0.0, "{y}");
}

#[test]
fn one_step_response_is_half_dt_squared_over_mass() {
    let mut sub = chain(0.05);
    let y = window_response(&mut sub, 0, 1).unwrap();
    for (i, mass) in [2.0, 0.3].into_iter().enumerate() {
        assert!((y[(i, i)] - 0.5 * 0.05_f64.powi(2) / mass).abs() < 1e-16);
    }
}

#[test]
fn work_of_the_multiplier_is_the_stored_energy() {
    let mut sub = chain(0.05);
    sub.set_multiplier(0, &[1.0, -0.4]);
    for step in 0..5000 {
        sub.step();
        let e = sub.energies();
        assert!(e.residual().abs() < 1e-11, "step {step}: {e:?}");
    }
}

#[test]
fn stable_below_its_own_limit_and_not_above() {
    for (factor, stable) in [(0.999, true), (1.01, false)] {
        let mut sub = chain(1.0);
        sub.dt = factor * sub.dt_critical().unwrap();
        sub.v[1] = 1.0;
        (0..20_000).for_each(|_| sub.step());
        assert_eq!(sub.v.iter().all(|v| v.abs() < 1e3), stable, "factor {factor}: velocities {:?}", sub.v);
    }
}

#[test]
fn a_state_of_another_size_is_refused() {
    let error = chain(0.1).restore(&State { step: 0, values: vec![0.0; 3] }).unwrap_err();
    assert!(error.to_string().contains("3 values") && error.to_string().contains("`chain`"), "{error}");
}
