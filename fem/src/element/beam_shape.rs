//! Shape functions of the Timoshenko beam in its own axes.

use nalgebra::{SMatrix, SVector};

/// Matrix over the six freedoms of each end: u, v, w, θx, θy, θz.
pub(super) type End12 = SMatrix<f64, 12, 12>;
/// Vector over the same.
pub(super) type Vector12 = SVector<f64, 12>;
/// Six field values by the twelve freedoms.
pub(super) type Field = SMatrix<f64, 6, 12>;

/// Gauss points and weights on [0, 1], exact to degree 7: the mass holds products of cubics.
pub(super) const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Shape of a beam of `length` with shear parameters $\Phi = 12EI/(GA_sL^2)$ in its two planes.
///
/// In each plane the deflection is cubic, the section's rotation quadratic, the shear angle
/// $\gamma = v' - \theta$ constant, and moment and shear are in balance: the exact solution of a beam
/// loaded at its ends (Przemieniecki 1968; as interpolation Friedman & Kosmatka 1993).
#[derive(Debug, Clone, Copy)]
pub(super) struct BeamShape {
    pub(super) length: f64,
    /// In the x–y plane, where $I_z$ bends.
    pub(super) phi_y: f64,
    /// In the x–z plane, where $I_y$ bends.
    pub(super) phi_z: f64,
}

/// Deflection, rotation, and the rotation's derivative along x, by (v₁, θ₁, v₂, θ₂).
struct Plane {
    deflection: [f64; 4],
    rotation: [f64; 4],
    curvature: [f64; 4],
    shear: [f64; 4],
}

fn plane(s: f64, length: f64, phi: f64) -> Plane {
    let (s2, s3, f, l) = (s * s, s * s * s, 1.0 / (1.0 + phi), length);
    Plane {
        deflection: [
            f * (1.0 - 3.0 * s2 + 2.0 * s3 + phi * (1.0 - s)),
            f * l * (s - 2.0 * s2 + s3 + phi / 2.0 * (s - s2)),
            f * (3.0 * s2 - 2.0 * s3 + phi * s),
            f * l * (s3 - s2 - phi / 2.0 * (s - s2)),
        ],
        rotation: [
            f * 6.0 / l * (s2 - s),
            f * (1.0 - 4.0 * s + 3.0 * s2 + phi * (1.0 - s)),
            f * 6.0 / l * (s - s2),
            f * (3.0 * s2 - 2.0 * s + phi * s),
        ],
        curvature: [
            f * 6.0 / (l * l) * (2.0 * s - 1.0),
            f / l * (6.0 * s - 4.0 - phi),
            f * 6.0 / (l * l) * (1.0 - 2.0 * s),
            f / l * (6.0 * s - 2.0 + phi),
        ],
        shear: [-f * phi / l, -f * phi / 2.0, f * phi / l, -f * phi / 2.0],
    }
}

/// Freedoms of the two planes among the twelve, and the sign of the rotation: about z it turns x to
/// y, about y it turns z to x.
const IN_Y: [(usize, f64); 4] = [(1, 1.0), (5, 1.0), (7, 1.0), (11, 1.0)];
const IN_Z: [(usize, f64); 4] = [(2, 1.0), (4, -1.0), (8, 1.0), (10, -1.0)];

fn spread(field: &mut Field, row: usize, sign: f64, places: &[(usize, f64); 4], values: &[f64; 4]) {
    for (&(column, turn), value) in places.iter().zip(values) {
        field[(row, column)] = sign * turn * value;
    }
}

impl BeamShape {
    /// u, v, w, θx, θy, θz at the share `s` of the length.
    pub(super) fn displacement(&self, s: f64) -> Field {
        let mut field = Field::zeros();
        for row in [0, 3] {
            field[(row, row)] = 1.0 - s;
            field[(row, row + 6)] = s;
        }
        let (y, z) = (plane(s, self.length, self.phi_y), plane(s, self.length, self.phi_z));
        spread(&mut field, 1, 1.0, &IN_Y, &y.deflection);
        spread(&mut field, 5, 1.0, &IN_Y, &y.rotation);
        spread(&mut field, 2, 1.0, &IN_Z, &z.deflection);
        spread(&mut field, 4, -1.0, &IN_Z, &z.rotation);
        field
    }

    /// Extension u′, shear angles v′ − θz and w′ + θy, twist θx′, curvatures θy′ and θz′.
    pub(super) fn strain(&self, s: f64) -> Field {
        let mut field = Field::zeros();
        for row in [0, 3] {
            field[(row, row)] = -1.0 / self.length;
            field[(row, row + 6)] = 1.0 / self.length;
        }
        let (y, z) = (plane(s, self.length, self.phi_y), plane(s, self.length, self.phi_z));
        spread(&mut field, 1, 1.0, &IN_Y, &y.shear);
        spread(&mut field, 5, 1.0, &IN_Y, &y.curvature);
        spread(&mut field, 2, 1.0, &IN_Z, &z.shear);
        spread(&mut field, 4, -1.0, &IN_Z, &z.curvature);
        field
    }

    /// v′, w′ and θx′ in the first three rows.
    pub(super) fn slope(&self, s: f64) -> Field {
        let (strain, turn) = (self.strain(s), self.displacement(s));
        let mut slope = Field::zeros();
        slope.set_row(0, &(strain.row(1) + turn.row(5)));
        slope.set_row(1, &(strain.row(2) - turn.row(4)));
        slope.set_row(2, &strain.row(3));
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn derivatives_are_those_of_the_fields() {
        let shape = BeamShape { length: 2.5, phi_y: 0.7, phi_z: 0.0 };
        let (s, h) = (0.3, 1e-5);
        let (before, after) = (shape.displacement(s - h), shape.displacement(s + h));
        let slope = (after - before) / (2.0 * h * shape.length);
        assert_relative_eq!(slope.row(1), shape.slope(s).row(0), epsilon = 1e-9);
        assert_relative_eq!(slope.row(2), shape.slope(s).row(1), epsilon = 1e-9);
        assert_relative_eq!(slope.row(5), shape.strain(s).row(5), epsilon = 1e-9);
        assert_relative_eq!(slope.row(4), shape.strain(s).row(4), epsilon = 1e-9);
    }

    #[test]
    fn the_ends_take_their_own_values() {
        let shape = BeamShape { length: 2.5, phi_y: 0.7, phi_z: 0.2 };
        assert_relative_eq!(
            shape.displacement(0.0).fixed_columns::<6>(0).into_owned(),
            SMatrix::<f64, 6, 6>::identity(),
            epsilon = 1e-15
        );
        assert_relative_eq!(
            shape.displacement(1.0).fixed_columns::<6>(6).into_owned(),
            SMatrix::<f64, 6, 6>::identity(),
            epsilon = 1e-15
        );
    }
}
