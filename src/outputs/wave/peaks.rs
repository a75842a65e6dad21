//! Largest motion of every point over a run.

use super::super::OutputError;

/// Peak displacement, velocity and acceleration of points, per component and as the length of the vector.
///
/// The motions are those of the points themselves; take them at every step, for a row of an output is
/// low-passed and later.
#[derive(Debug, Clone, PartialEq)]
pub struct Peaks {
    axes: Vec<usize>,
    points: usize,
    /// `[motion][component][point]`, largest absolute value.
    components: Vec<f32>,
    /// `[motion][point]`, largest square of the length.
    squares: Vec<f32>,
}

impl Peaks {
    /// Zero everywhere; `axes` are the components, increasing.
    #[must_use]
    pub fn new(axes: &[usize], points: usize) -> Self {
        let zeros = |count: usize| vec![0.0; count];
        let components = zeros(3 * axes.len() * points);
        Self { axes: axes.to_vec(), points, components, squares: zeros(3 * points) }
    }

    /// Takes one instant of one motion (0 displacement, 1 velocity, 2 acceleration), `[component][point]`.
    /// Allocates nothing; a NaN is passed over.
    ///
    /// # Panics
    /// If `motion` is above 2 or the number of values is another.
    pub fn take(&mut self, motion: usize, values: &[f32]) {
        let points = self.points;
        assert_eq!(values.len(), self.axes.len() * points, "one value per component and point");
        let peaks = &mut self.components[motion * values.len()..(motion + 1) * values.len()];
        peaks.iter_mut().zip(values).for_each(|(peak, value)| *peak = raised(*peak, value.abs()));
        let squares = &mut self.squares[motion * points..(motion + 1) * points];
        match self.axes.len() {
            3 => {
                let (x, rest) = values.split_at(points);
                let (y, z) = rest.split_at(points);
                for (peak, ((x, y), z)) in squares.iter_mut().zip(x.iter().zip(y).zip(z)) {
                    *peak = raised(*peak, x * x + y * y + z * z);
                }
            }
            2 => {
                let (x, z) = values.split_at(points);
                for (peak, (x, z)) in squares.iter_mut().zip(x.iter().zip(z)) {
                    *peak = raised(*peak, x * x + z * z);
                }
            }
            _ => squares.iter_mut().zip(values).for_each(|(peak, x)| *peak = raised(*peak, x * x)),
        }
    }

    /// Components, increasing.
    #[must_use]
    pub fn axes(&self) -> &[usize] {
        &self.axes
    }

    /// Peaks of one component; `number` counts in [`Self::axes`].
    #[must_use]
    pub fn component(&self, motion: usize, number: usize) -> &[f32] {
        let from = (motion * self.axes.len() + number) * self.points;
        &self.components[from..from + self.points]
    }

    /// Largest length of the vector, per point.
    pub fn norm(&self, motion: usize) -> impl Iterator<Item = f32> + '_ {
        self.squares[motion * self.points..(motion + 1) * self.points].iter().map(|square| square.sqrt())
    }

    /// The state as bytes, for a checkpoint.
    pub fn save(&self, to: &mut Vec<u8>) {
        self.components.iter().chain(&self.squares).for_each(|v| to.extend(v.to_le_bytes()));
    }

    /// Takes the state of [`Self::save`] back.
    ///
    /// # Errors
    /// Bytes of another size.
    pub fn restore(&mut self, from: &[u8]) -> Result<(), OutputError> {
        let expected = 4 * (self.components.len() + self.squares.len());
        if from.len() != expected {
            return Err(OutputError::State { what: "the peak maps", found: from.len(), expected });
        }
        let slots = self.components.iter_mut().chain(&mut self.squares);
        for (slot, bytes) in slots.zip(from.chunks_exact(4)) {
            *slot = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        }
        Ok(())
    }
}

/// The larger one; the first where the second is not a number.
#[inline]
fn raised(peak: f32, value: f32) -> f32 {
    if value > peak { value } else { peak }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_and_lengths() {
        let mut peaks = Peaks::new(&[0, 1, 2], 2);
        peaks.take(1, &[3.0, 0.0, -4.0, 1.0, 0.0, 0.0]);
        peaks.take(1, &[-1.0, f32::NAN, 1.0, 0.5, 2.0, -2.0]);
        assert_eq!(peaks.component(1, 0), [3.0, 0.0]);
        assert_eq!(peaks.component(1, 1), [4.0, 1.0]);
        assert_eq!(peaks.component(1, 2), [2.0, 2.0]);
        assert_eq!(peaks.norm(1).collect::<Vec<_>>(), [5.0, 1.0]);
        assert_eq!(peaks.norm(0).collect::<Vec<_>>(), [0.0, 0.0]);
        let mut bytes = vec![];
        peaks.save(&mut bytes);
        let mut back = Peaks::new(&[0, 1, 2], 2);
        back.restore(&bytes).expect("its own state");
        assert_eq!(back, peaks);
        assert!(Peaks::new(&[0, 1, 2], 3).restore(&bytes).is_err());
    }
}
