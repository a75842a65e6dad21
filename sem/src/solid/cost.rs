//! Bytes and operations of a step, counted from the formulas and the arrays.

use super::Solid;
use super::geometry::Metric;
use super::kernel::{axis_count, strain_components};
use super::real::Real;

/// What a step costs, summed over all elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Bytes of all arrays.
    pub bytes_held: f64,
    /// Bytes that go through memory in a step where no cache holds an array: each array once, twice where it
    /// is written.
    pub bytes_moved: f64,
    /// Additions and multiplications, a fused pair counting as two.
    pub flops: f64,
}

impl<T: Real> Solid<T> {
    /// Counts what a step costs. Empty lanes of the last batch of a block are not counted.
    pub fn cost(&self) -> Cost {
        let (model, size) = (&self.model, size_of::<T>() as f64);
        let layout = &model.layout;
        // positions and velocities are read and written, Δt/m is read
        let nodes = layout.nodes as f64 * (4.0 * 3.0 + 1.0) * size;
        // partial sums are written and read, with their addresses
        let shared = layout.halo.len() as f64 * (2.0 * 3.0 * size + 8.0);
        let elements = 2.0 * layout.local.len() as f64
            + size * (model.metric.len() + 2 * model.moduli.lambda.len() + model.arm_lanes.len()) as f64;
        let memory = 2.0 * size * self.dashpots.len() as f64;
        let points = model.layout.points as f64;
        let flops: f64 = (self.metrics().iter().zip([Metric::Affine, Metric::Corners, Metric::Stored]))
            .map(|(count, metric)| *count as f64 * points * self.flops_per_point(metric))
            .sum();
        Cost {
            bytes_held: self.bytes() as f64,
            bytes_moved: nodes + shared + elements + memory,
            flops: flops + 12.0 * layout.nodes as f64,
        }
    }

    /// Operations per point of an element.
    fn flops_per_point(&self, metric: Metric) -> f64 {
        let planes = self.model.planes();
        let (axes, n) = (axis_count(planes) as f64, self.model.gll.len() as f64);
        let components = strain_components(planes) as f64;
        let (arms, memory) = (self.model.arms as f64, f64::from(self.model.arms > 0));
        let derivatives = 3.0 * axes * n * 2.0;
        let transform = 3.0 * axes * (2.0 * axes - 1.0);
        let stress = 2.0 + 4.0 * 2.0 + 3.0 + components;
        let geometry = if metric == Metric::Corners { 7.0 * axes * axes } else { 0.0 };
        // strain of the velocity, its increment; per arm its strain twice, stress, loss
        let arm = components * (2.0 + 2.0 + 3.0 + 1.0 + 1.0) + stress + 17.0;
        2.0 * (derivatives + transform)
            + stress
            + geometry
            + memory * (derivatives + transform + components)
            + arms * arm
    }
}
