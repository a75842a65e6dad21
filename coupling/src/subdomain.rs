use crate::{CouplingError, Energies};
use nalgebra::DMatrix;

/// What a subdomain needs to go on from an instant, bit for bit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Steps taken since the start of the run.
    pub step: u64,
    /// Positions, velocities and memory, in an order that is the subdomain's own affair.
    pub values: Vec<f64>,
}

/// A part of a scene with its own unknowns, its own integrator and its own step.
///
/// Signs: a multiplier is a force on the subdomain's interface freedoms, N, held constant over a step;
/// positive along the freedom's axis. A step without multiplier is the *free* step. Explicit parts run
/// drift–kick–drift ([`crate::central_difference`]), so position and velocity belong to the same
/// instant at a step's end.
pub trait Subdomain {
    /// Name for messages and the ledger.
    fn name(&self) -> &str;
    /// Own step, s.
    fn dt(&self) -> f64;
    /// Largest stable step, s; `None` when unconditionally stable.
    fn dt_critical(&self) -> Option<f64>;
    /// Instant of the end of the last step, s.
    fn time(&self) -> f64;
    /// Takes one own step under its own loads and the multipliers set before.
    fn step(&mut self);

    /// Number of interfaces; they are numbered from 0.
    fn interface_count(&self) -> usize;
    /// Number of freedoms on an interface.
    fn interface_len(&self, interface: usize) -> usize;
    /// Positions on an interface at the end of the last step, m.
    fn interface_position(&self, interface: usize, position: &mut [f64]);
    /// Velocities on an interface at the end of the last step, m/s.
    fn interface_velocity(&self, interface: usize, velocity: &mut [f64]);
    /// Sets the multiplier that acts on an interface during the next steps, N.
    fn set_multiplier(&mut self, interface: usize, multiplier: &[f64]);

    /// Energies at the end of the last step.
    fn energies(&mut self) -> Energies;

    /// Whether [`Self::restore`] can take the subdomain back; a program at the end of a pipe cannot.
    fn can_rewind(&self) -> bool {
        true
    }
    /// Writes the state of the last step's end into `state`, reusing its memory.
    fn save(&self, state: &mut State);
    /// Goes back to a saved state. The multipliers are not part of it.
    fn restore(&mut self, state: &State) -> Result<(), CouplingError>;
}

/// Response of an interface to unit multipliers held over a window of `steps` own steps:
/// entry $(i, j)$ is the position of freedom $i$ at the window's end under a unit force on freedom
/// $j$, less that of the free window, m/N.
///
/// Symmetric for a linear symmetric subdomain (a checked property, not an assumption). The subdomain
/// is left as it was found, with zero multiplier on that interface. Cost: `interface_len + 1` windows.
pub fn window_response(
    subdomain: &mut dyn Subdomain,
    interface: usize,
    steps: usize,
) -> Result<DMatrix<f64>, CouplingError> {
    let n = subdomain.interface_len(interface);
    let mut start = State::default();
    subdomain.save(&mut start);
    let mut run = |multiplier: &[f64], position: &mut [f64]| -> Result<(), CouplingError> {
        subdomain.set_multiplier(interface, multiplier);
        for _ in 0..steps {
            subdomain.step();
        }
        subdomain.interface_position(interface, position);
        subdomain.restore(&start)
    };
    let mut multiplier = vec![0.0; n];
    let (mut free, mut forced) = (vec![0.0; n], vec![0.0; n]);
    run(&multiplier, &mut free)?;
    let mut response = DMatrix::zeros(n, n);
    for j in 0..n {
        multiplier[j] = 1.0;
        run(&multiplier, &mut forced)?;
        multiplier[j] = 0.0;
        for i in 0..n {
            response[(i, j)] = forced[i] - free[i];
        }
    }
    subdomain.set_multiplier(interface, &multiplier);
    Ok(response)
}
