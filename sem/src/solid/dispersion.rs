//! Numerical dispersion: how wrong the speed of a plane wave is, from the number of points and the step.
//!
//! On a uniform mesh of elements of size $h$ a plane wave is a Bloch wave: the same in every element but
//! for the factor $e^{i k h}$. One element with that condition between its faces is an exact Hermitian
//! eigenproblem for the frequency $\omega_h(k)$ of the discrete solid. Along an axis of the mesh it is that of a
//! single line of points, whatever D, the wave and the moduli, since with the GLL rule the derivatives across
//! the direction integrate to nothing.
//!
//! Points per wavelength are those of [`crate::mesh::Resolution`]: $p = N\lambda/h$, on the mean spacing. Two are
//! the least that tell a wave from its alias (Nyquist). The error is that of the phase speed,
//! $$ e = |\omega_h/(ck) - 1|, $$
//! which is also the phase error per wavelength as a part of a cycle ($2\pi e$ in radians): over $n$ wavelengths a
//! narrow-band wave comes $n e$ periods early or late.
//!
//! Where an element is a whole number of half wavelengths, $p = 2N/m$, the points of two elements see two waves
//! instead of one: there the branches part, the error peaks, and a narrow band of frequencies is not carried at all. That is
//! why the table has steps.
//!
//! ```text
//! space alone      e ~ p^(−2N), waves too slow
//! time alone       ω̃ = (2/Δt) arcsin(ωΔt/2):  e = (ωΔt)²/24, too fast
//! both             ω_h in the place of ω
//! ```

use super::{Ground, Material, reference};
use crate::SemError;
use crate::gll::{Gll, ORDER_MAX};
use crate::mesh::{BoxLayer, LayeredBox};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// Fewest points per wavelength that carry a wave.
pub const POINTS_MIN: f64 = 2.0;

/// Ratio $\omega/\omega_h$ by which the central difference raises a frequency, from $\omega_h\Delta t$:
/// $\arcsin(x/2)/(x/2)$; NaN beyond its limit, 2.
pub fn step_factor(omega_dt: f64) -> f64 {
    let s = 0.5 * omega_dt;
    if s.abs() < 1e-4 { 1.0 + s * s / 6.0 } else { s.asin() / s }
}

/// Phase speed of a plane wave along an axis of the mesh over its true speed, for
/// `points` per wavelength and a Courant number $c\Delta t/h$ (0: space alone).
///
/// NaN where the step is beyond its limit for the wave itself. Cost: an eigenproblem of N freedoms. Errors: an
/// order out of 1–10, fewer than [`POINTS_MIN`] points.
pub fn phase_speed(order: usize, points: f64, courant: f64) -> Result<f64, SemError> {
    let line = Line::new(order)?;
    line.ratio(wave_number(order, points)?, courant)
}

/// Wave number $kh = 2\pi N/p$.
fn wave_number(order: usize, points: f64) -> Result<f64, SemError> {
    if !(points >= POINTS_MIN && points.is_finite()) {
        let range = "at least 2 points per wavelength";
        return Err(SemError::Dispersion { key: "points_per_wavelength", value: points, range });
    }
    Ok(TAU * order as f64 / points)
}

/// Largest Courant number $c\Delta t/h$ of a line of equal elements: $2/(\omega_{\max}h/c)$.
///
/// Of the scalar wave equation at D = 2, 3 on squares and cubes it is this over $\sqrt D$; the elastic solid's
/// limit lies near that with $c = v_p$ ([`super::Solid::critical_step`] finds it). Errors: an order out of 1–10.
pub fn critical_courant(order: usize) -> Result<f64, SemError> {
    let line = Line::new(order)?;
    let highest = (0..=16)
        .flat_map(|i| line.eigen(PI * f64::from(i) / 16.0).eigenvalues.iter().copied().collect::<Vec<_>>());
    Ok(2.0 / highest.fold(0.0, f64::max).sqrt())
}

/// Equal elements along a line, $h = c = 1$.
struct Line {
    gll: Gll,
    stiffness: DMatrix<f64>,
}

impl Line {
    fn new(order: usize) -> Result<Self, SemError> {
        let gll = Gll::new(order)?;
        let n = gll.len();
        let d = |q: usize, i: usize| gll.derivative[q * n + i];
        // ∫ ℓ'_i ℓ'_j dx with dξ/dx = 2 and dx = dξ/2
        let stiffness =
            DMatrix::from_fn(n, n, |i, j| (0..n).map(|q| 2.0 * gll.weights[q] * d(q, i) * d(q, j)).sum());
        Ok(Self { gll, stiffness })
    }

    /// Mass of a point; that of the face belongs to both its elements.
    fn mass(&self, i: usize) -> f64 {
        0.5 * self.gll.weights[i] * if i == 0 { 2.0 } else { 1.0 }
    }

    /// Bloch waves of $kh$: eigenvalues $(\omega h/c)^2$, vectors times the root of the mass.
    fn eigen(&self, kh: f64) -> SymmetricEigen<Complex64, nalgebra::Dyn> {
        let order = self.gll.len() - 1;
        let mut a = DMatrix::<Complex64>::zeros(order, order);
        for i in 0..=order {
            for j in 0..=order {
                let turn = f64::from(i32::from(j == order) - i32::from(i == order));
                a[(i % order, j % order)] += Complex64::from_polar(self.stiffness[(i, j)], kh * turn);
            }
        }
        hermitian(a, &(0..order).map(|i| self.mass(i)).collect::<Vec<_>>())
    }

    /// Phase speed, of the Bloch wave that is most like the plane wave.
    fn ratio(&self, kh: f64, courant: f64) -> Result<f64, SemError> {
        let plane: Vec<Complex64> = (0..self.gll.len() - 1)
            .map(|i| Complex64::from_polar(self.mass(i).sqrt(), kh * 0.5 * (1.0 + self.gll.points[i])))
            .collect();
        let omega = nearest(&self.eigen(kh), &plane).sqrt();
        Ok(omega / kh * step_factor(omega * courant))
    }

    fn error(&self, points: f64) -> f64 {
        let kh = TAU * (self.gll.len() - 1) as f64 / points;
        self.ratio(kh, 0.0).map_or(f64::NAN, |r| (r - 1.0).abs())
    }
}

/// Eigenvalues of $K v = \omega^2 M v$, vectors times the root of the mass.
fn hermitian(mut a: DMatrix<Complex64>, mass: &[f64]) -> SymmetricEigen<Complex64, nalgebra::Dyn> {
    for i in 0..mass.len() {
        for j in 0..mass.len() {
            a[(i, j)] /= (mass[i] * mass[j]).sqrt();
        }
    }
    SymmetricEigen::new(a)
}

/// Eigenvalue whose vector has the largest share in a given one.
fn nearest(eigen: &SymmetricEigen<Complex64, nalgebra::Dyn>, plane: &[Complex64]) -> f64 {
    let plane = DVector::from_column_slice(plane);
    let share = |k: usize| eigen.eigenvectors.column(k).dotc(&plane).norm_sqr();
    let best = (0..plane.len()).max_by(|&i, &j| share(i).total_cmp(&share(j)));
    best.map_or(f64::NAN, |k| eigen.eigenvalues[k])
}

/// How much larger than along an axis the phase error of a shear wave can be in another direction of a section:
/// $\max(1, 1 + a_N((v_p/v_s)^2 - 3))$, a = 0.75, 0.65, 0.55 for N = 1, 2 and more.
///
/// An oblique shear wave is no longer free of compression on the points of the mesh, and what little it has of that is
/// stiff: the error grows with $(v_p/v_s)^2$, is largest between 15° and 45°, and is a wave too fast. Up to Poisson's
/// ratio ¼ the axis is the worst direction; in soil below the water table ($v_p/v_s$ = 8) the factor is 35. Ask
/// [`points_per_wavelength`] for an error smaller by this much: since the error falls as $p^{-2N}$, N = 5 takes 4 % more
/// points for $v_p/v_s$ = 2 and 40 % more for 8. Found by [`phase_speed_oblique`]; D = 3 was not explored.
pub fn shear_amplification(order: usize, vp_over_vs: f64) -> f64 {
    let slope = match order {
        1 => 0.75,
        2 => 0.65,
        _ => 0.55,
    };
    (1.0 + slope * (vp_over_vs * vp_over_vs - 3.0)).max(1.0)
}

/// A body wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wave {
    /// Compression: motion along the direction.
    P,
    /// Shear in the section: motion across the direction.
    Sv,
}

/// Phase speed over true speed of a plane wave at `angle` (rad) to the x axis on square elements of a section, space
/// alone: the Bloch problem of one element assembled by [`reference::internal_force`].
///
/// Cost: an eigenproblem of 2N² freedoms. Errors: as [`phase_speed`]; speeds that make no material.
pub fn phase_speed_oblique(
    order: usize,
    points: f64,
    angle: f64,
    vp_over_vs: f64,
    wave: Wave,
) -> Result<f64, SemError> {
    let kh = wave_number(order, points)?;
    let (kx, kz) = (kh * angle.cos(), kh * angle.sin());
    let ground = one_element(order, vp_over_vs)?;
    let (n, nodes) = (order + 1, ground.numbering().element(0));
    let (mut a, mut mass) =
        (DMatrix::<Complex64>::zeros(2 * order * order, 2 * order * order), vec![0.0; 2 * order * order]);
    // a point of the faces x = 1 or z = 1 is that at x = 0 or z = 0, turned
    let fold = |p: usize, c: usize| 2 * (p / n % order * order + p % n % order) + c;
    let turn = |p: usize| kx * f64::from(u8::from(p % n == order)) + kz * f64::from(u8::from(p / n == order));
    for p in 0..n * n {
        for (c, axis) in [(0, 0), (1, 2)] {
            let mut u = vec![[0.0; 3]; n * n];
            u[nodes[p] as usize][axis] = 1.0;
            let f = reference::internal_force(&ground, &u, Material::relaxed);
            mass[fold(p, c)] += ground.mass()[nodes[p] as usize];
            for q in 0..n * n {
                for (d, along) in [(0, 0), (1, 2)] {
                    let value = f[nodes[q] as usize][along];
                    a[(fold(q, d), fold(p, c))] += Complex64::from_polar(value, turn(p) - turn(q));
                }
            }
        }
    }
    let at = |p: usize| 0.5 * (1.0 + ground.gll().points[p]);
    let polarised = if wave == Wave::P { [angle.cos(), angle.sin()] } else { [-angle.sin(), angle.cos()] };
    let plane: Vec<Complex64> = (0..2 * order * order)
        .map(|i| {
            let phase = kx * at(i / 2 % order) + kz * at(i / 2 / order);
            Complex64::from_polar(mass[i].sqrt(), phase) * polarised[i % 2]
        })
        .collect();
    let speed = if wave == Wave::P { vp_over_vs } else { 1.0 };
    Ok(nearest(&hermitian(a, &mass), &plane).sqrt() / (speed * kh))
}

/// A square of 1 m with $v_s$ = 1 m/s.
fn one_element(order: usize, vp_over_vs: f64) -> Result<Ground, SemError> {
    let layers = [BoxLayer { name: "soil".into(), thickness: 1.0, elements: 1 }];
    let mesh = LayeredBox {
        dimension: 2,
        x: (0.0, 1.0),
        y: (0.0, 1.0),
        layers: &layers,
        element_width: 1.0,
        topography: None,
        moved_layers: 1,
        order: 1,
    }
    .mesh()?;
    Ground::new(mesh, order, &[Material::elastic("soil", 1.0, vp_over_vs, 1.0)])
}

/// Errors of [`points_per_wavelength`]'s table: tenths of decades from 1e-1 down to 1e-7.
const ERRORS: usize = 61;

/// Points per wavelength, one row per error and one column per order; [`table`] writes it.
static TABLE: LazyLock<Vec<[f64; ORDER_MAX]>> = LazyLock::new(|| read(include_str!("dispersion.csv")));

fn read(csv: &str) -> Vec<[f64; ORDER_MAX]> {
    let row = |line: &str| {
        let mut row = [f64::NAN; ORDER_MAX];
        line.split(',')
            .skip(1)
            .zip(&mut row)
            .for_each(|(cell, value)| *value = cell.parse().unwrap_or(f64::NAN));
        row
    };
    csv.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())).map(row).collect()
}

fn table_error(row: usize) -> f64 {
    10.0_f64.powf(-1.0 - 0.1 * row as f64)
}

/// Points per wavelength from which on the phase error per wavelength, a part of a cycle, stays below `error`: space
/// alone, plane waves along an axis of a uniform mesh. Shear waves of another direction can be
/// worse: [`shear_amplification`].
///
/// From the table `dispersion.csv` beside this file, between its rows by powers of the error, the safer row where
/// a gap between two branches lies between them; below 1e-7 by $p\sim e^{-1/(2N)}$. Never fewer than
/// [`phase_speed`] asks for by more than 0.5 %. Multiply by a wave's length in wavelengths to know its
/// error at the end: 100 wavelengths to 1 % of a cycle ask for `error` = 1e-4.
///
/// Errors: an order out of 1–10; an error that is not above 0 and at most 0.1.
pub fn points_per_wavelength(order: usize, error: f64) -> Result<f64, SemError> {
    if !(1..=ORDER_MAX).contains(&order) {
        return Err(SemError::Order(order));
    }
    if !(error > 0.0 && error <= 0.1) {
        let range = "an error above 0, 0.1 at most";
        return Err(SemError::Dispersion { key: "phase error per wavelength", value: error, range });
    }
    let points = |row: usize| TABLE[row][order - 1];
    let place = -10.0 * (10.0 * error).log10();
    let row = (place as usize).min(ERRORS - 2);
    let last = ERRORS - 1;
    Ok(if place >= last as f64 {
        points(last) * (table_error(last) / error).powf(0.5 / order as f64)
    } else {
        // a jump is a gap between two branches: anywhere in it only the finer row is safe
        let (ratio, smooth) = (points(row + 1) / points(row), 10.0_f64.powf(0.075 / order as f64));
        if ratio > smooth { points(row + 1) } else { points(row) * ratio.powf(place - row as f64) }
    })
}

/// The table of [`points_per_wavelength`], computed anew, as CSV. `cargo run --release -p hati-sem --example
/// dispersion_table` prints it. Cost: a second.
///
/// Errors: none for the orders it holds.
pub fn table() -> Result<String, SemError> {
    let mut text = String::from("phase error per wavelength (cycles)");
    (1..=ORDER_MAX).for_each(|order| text += &format!(",N = {order}"));
    let columns = (1..=ORDER_MAX).map(points_computed).collect::<Result<Vec<_>, _>>()?;
    for row in 0..ERRORS {
        text += &format!("\n{:.6e}", table_error(row));
        columns.iter().for_each(|c| text += &format!(",{:.5}", c[row]));
    }
    Ok(text + "\n")
}

/// Points per wavelength from which on an order's error stays below each of the table's.
fn points_computed(order: usize) -> Result<[f64; ERRORS], SemError> {
    // fine enough to see the gaps between the branches, where the error peaks
    const RATIO: f64 = 1.002;
    let line = Line::new(order)?;
    let mut result = [POINTS_MIN; ERRORS];
    let mut points = if order == 1 { 1e4 } else { 1e3 };
    let mut row = ERRORS;
    while points > POINTS_MIN && row > 0 {
        let next = (points / RATIO).max(POINTS_MIN);
        let error = line.error(next);
        while row > 0 && error > table_error(row - 1) {
            let (mut coarse, mut fine) = (next, points);
            for _ in 0..30 {
                let middle = 0.5 * (coarse + fine);
                if line.error(middle) > table_error(row - 1) { coarse = middle } else { fine = middle }
            }
            row -= 1;
            result[row] = fine;
        }
        points = next;
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_what_is_computed_now() {
        let (stored, now) = (read(include_str!("dispersion.csv")), read(&table().unwrap()));
        assert_eq!((stored.len(), now.len()), (ERRORS, ERRORS));
        for (stored, now) in stored.iter().flatten().zip(now.iter().flatten()) {
            assert!((stored / now - 1.0).abs() < 1e-4, "{stored} is now {now}");
        }
    }

    #[test]
    fn the_points_asked_for_keep_the_error() {
        for order in 1..=ORDER_MAX {
            for i in 0..=140 {
                let error = 10.0_f64.powf(-1.0 - 0.05 * f64::from(i) + 1e-3).min(0.1);
                let points = points_per_wavelength(order, error).unwrap();
                let found = (phase_speed(order, points, 0.0).unwrap() - 1.0).abs();
                let spare = 1.01_f64.powi(2 * order as i32);
                assert!(found <= error * spare, "N = {order}, {error:e}: {points} points give {found:e}");
                // in reach of the leading term nothing is wasted
                if error < 1e-5 {
                    assert!(
                        found * spare * spare >= error,
                        "N = {order}, {error:e}: {points} points give {found:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn order_one_and_the_step_have_closed_forms() {
        for points in [2.5, 4.0, 10.0, 100.0] {
            let kh = TAU / points;
            let space = 2.0 * (0.5 * kh).sin() / kh;
            assert!((phase_speed(1, points, 0.0).unwrap() / space - 1.0).abs() < 1e-10);
            // the largest step makes up for the points: the classic exact case
            assert!((phase_speed(1, points, 1.0).unwrap() - 1.0).abs() < 1e-7);
        }
        assert!((critical_courant(1).unwrap() - 1.0).abs() < 1e-12);
        assert!((step_factor(0.2) - 1.0 - 0.04 / 24.0).abs() < 1e-5);
        assert!((step_factor(2.0) - PI / 2.0).abs() < 1e-12 && step_factor(2.01).is_nan());
    }

    #[test]
    fn along_an_axis_the_section_is_the_line() {
        for order in 1..=6 {
            for wave in [Wave::P, Wave::Sv] {
                for angle in [0.0, 0.5 * PI] {
                    let line = phase_speed(order, 9.0, 0.0).unwrap();
                    let section = phase_speed_oblique(order, 9.0, angle, 2.3, wave).unwrap();
                    assert!(
                        (line - section).abs() < 1e-11,
                        "N = {order}, {wave:?}: {section} against {line}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_amplification_covers_every_direction_of_shear() {
        let mut tight = 0.0_f64;
        for order in 1..=6 {
            for vp_over_vs in [1.6, 2.0, 3.0, 8.0] {
                for error in [1e-3, 1e-5] {
                    let asked = error / shear_amplification(order, vp_over_vs);
                    let points = points_per_wavelength(order, asked).unwrap();
                    for degrees in [0.0, 9.0, 18.0, 24.0, 30.0, 45.0_f64] {
                        let ratio =
                            phase_speed_oblique(order, points, degrees.to_radians(), vp_over_vs, Wave::Sv);
                        let found = (ratio.unwrap() - 1.0).abs();
                        assert!(
                            found < 1.02 * error,
                            "N = {order}, {vp_over_vs}, {degrees}°: {found:e} for {error:e}"
                        );
                        tight = tight.max(if vp_over_vs > 2.5 { found / error } else { 0.0 });
                    }
                }
            }
        }
        assert!(tight > 0.8, "{tight}");
    }

    #[test]
    fn values_out_of_range_are_refused() {
        assert!(matches!(phase_speed(0, 5.0, 0.0), Err(SemError::Order(0))));
        assert!(points_per_wavelength(11, 1e-3).is_err() && points_per_wavelength(4, 0.2).is_err());
        for points in [1.9, 0.0, f64::NAN, f64::INFINITY] {
            let text = phase_speed(4, points, 0.0).unwrap_err().to_string();
            assert!(text.contains("at least 2 points"), "{text}");
        }
        assert!(points_per_wavelength(4, f64::NAN).is_err() && points_per_wavelength(4, 0.0).is_err());
    }
}
