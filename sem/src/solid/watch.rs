//! Motions of chosen points at the kicks.

use super::{Motion, Probe, Real, Solid};
use hati_coupling::Subdomain;

/// Points whose motion is looked at: displacement, velocity and acceleration belong to the same kick.
///
/// A step replaces the position of its kick by that of the next one, so a watch takes the state before
/// the step as well: [`Watch::before`], [`Subdomain::step`], [`Watch::after`]. Steps between two looks
/// need no watch. Nothing is allocated after [`Watch::new`].
#[derive(Debug, Clone)]
pub struct Watch {
    places: Vec<(u32, u32)>,
    displacement: Vec<[f64; 3]>,
    velocity: Vec<[f64; 3]>,
    acceleration: Vec<[f64; 3]>,
}

impl Watch {
    /// Watches points of the numbering, in the order given.
    pub fn new<T: Real>(solid: &Solid<T>, points: &[u32]) -> Self {
        let layout = &solid.model.layout;
        let places = (points.iter())
            .map(|&p| layout.place(layout.number[p as usize] as usize))
            .map(|(first, stride)| (first as u32, stride as u32))
            .collect();
        let zeros = || vec![[0.0; 3]; points.len()];
        Self { places, displacement: zeros(), velocity: zeros(), acceleration: zeros() }
    }

    /// Takes the state before a step.
    pub fn before<T: Real>(&mut self, solid: &Solid<T>) {
        for (i, &(first, stride)) in self.places.iter().enumerate() {
            for c in 0..3 {
                let at = first as usize + c * stride as usize;
                self.displacement[i][c] = solid.x[at].f64();
                self.velocity[i][c] = solid.v[at].f64();
            }
        }
    }

    /// Takes the state after it; the motions are those of its kick from now on.
    pub fn after<T: Real>(&mut self, solid: &Solid<T>) {
        let inverse_dt = 1.0 / solid.dt();
        for (i, &(first, stride)) in self.places.iter().enumerate() {
            for c in 0..3 {
                let after = solid.v[first as usize + c * stride as usize].f64();
                let before = self.velocity[i][c];
                self.velocity[i][c] = 0.5 * (before + after);
                self.acceleration[i][c] = (after - before) * inverse_dt;
            }
        }
    }

    /// Displacements, m.
    pub fn displacement(&self) -> &[[f64; 3]] {
        &self.displacement
    }

    /// Velocities, m/s.
    pub fn velocity(&self) -> &[[f64; 3]] {
        &self.velocity
    }

    /// Accelerations, m/s².
    pub fn acceleration(&self) -> &[[f64; 3]] {
        &self.acceleration
    }

    /// Motion at a probe whose points begin at `first` in this watch.
    pub fn at(&self, probe: &Probe, first: usize) -> Motion {
        let mut sum = Motion::default();
        for (i, (_, w)) in (first..).zip(&probe.weights) {
            for c in 0..3 {
                sum.displacement[c] += w * self.displacement[i][c];
                sum.velocity[c] += w * self.velocity[i][c];
                sum.acceleration[c] += w * self.acceleration[i][c];
            }
        }
        sum
    }
}
