//! Coarse-grained memory variables against all of them: plane waves along bars, and what a short wave loses to the
//! pattern of the points.

use super::attenuation::{CARRIED, CENTRE, material};
use super::bar::{Bar, Wave, unwrapped};
use crate::report::{CoarseCurve, coarse_figure};
use crate::run::RunError;
use crate::verify::{CaseFigure, CaseResult, Check};
use hati_coupling::Subdomain;
use hati_sem::SemError;
use hati_sem::mesh::{BoxLayer, LayeredBox};
use hati_sem::solid::{Execution, Ground, Memory, Solid, Support, Watch};
use num_complex::Complex64;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Wavelengths that waves run.
const WAVELENGTHS: f64 = 20.0;
/// Order of the elements where one stands for all.
const ORDER: usize = 4;
/// A frequency near the upper end of the band, Hz.
const EDGE: f64 = 2.2 * CENTRE;

/// A plane wave along a bar of square elements or cubes.
#[derive(Debug, Clone, Copy)]
struct Run {
    dimension: usize,
    wave: Wave,
    order: usize,
    /// Points per wavelength.
    points: f64,
    quality: f64,
    /// Hz.
    frequency: f64,
}

/// What a wave has become after [`WAVELENGTHS`], over what it should be, less one: amplitude and phase velocity.
#[derive(Debug, Clone, Copy)]
struct Miss {
    amplitude: f64,
    velocity: f64,
}

/// Misses of coarse memory against full memory on the same mesh and steps, and of full memory against the exact wave.
#[derive(Debug, Clone, Copy)]
struct Misses {
    coarse: Miss,
    full: Miss,
}

impl Run {
    fn misses(&self) -> Result<Misses, SemError> {
        let (mechanisms, ratio) = CARRIED[0];
        let material = material(self.quality, mechanisms, ratio)?;
        let (speed, arms) = match self.wave {
            Wave::P => (material.vp, material.constrained.clone()),
            _ => (material.vs, material.shear.clone()),
        };
        let size = self.order as f64 * speed / self.frequency / self.points;
        let between = (WAVELENGTHS * speed / self.frequency / size).ceil() as usize;
        let bar = |memory| Bar {
            dimension: self.dimension,
            wave: self.wave,
            order: self.order,
            size,
            speed: speed * arms.unrelaxed().sqrt(),
            centre: self.frequency,
            bell: 2.0,
            part: 0.4,
            near: 2,
            between,
            material: material.clone(),
            memory,
        };
        let h = |memory| -> Result<Complex64, SemError> { Ok(bar(memory).transfer(&[self.frequency])?[0]) };
        let (full, coarse) = (h(Memory::Full)?, h(Memory::Coarse)?);
        let i_omega = Complex64::new(0.0, TAU * self.frequency);
        let distance = between as f64 * size;
        let exact = -i_omega / (speed * arms.factor(i_omega).sqrt()) * distance;
        let share = WAVELENGTHS * speed / self.frequency / distance;
        let phase = unwrapped(full.arg(), exact.im);
        let full_exponent = Complex64::new(full.norm().ln(), phase);
        let exponent = Complex64::new(coarse.norm().ln(), unwrapped(coarse.arg(), phase));
        let miss = |found: Complex64, reference: Complex64| Miss {
            amplitude: ((found.re - reference.re) * share).exp_m1(),
            velocity: reference.im / found.im - 1.0,
        };
        Ok(Misses { coarse: miss(exponent, full_exponent), full: miss(full_exponent, exact) })
    }
}

/// Share of a P pulse's kinetic energy that is no plane P wave any more after [`WAVELENGTHS`]: motion along z, and what of
/// the motion along x differs over the height.
///
/// A section four elements high between planes of symmetry; full memory leaves none but round-off.
fn converted(
    order: usize,
    points: f64,
    quality: f64,
    frequency: f64,
    memory: Memory,
) -> Result<f64, SemError> {
    const HIGH: usize = 4;
    let (mechanisms, ratio) = CARRIED[0];
    let material = material(quality, mechanisms, ratio)?;
    let wavelength = material.vp / frequency;
    let size = order as f64 * wavelength / points;
    let (bell, delay) = (1.0, 4.0 / frequency);
    let length = ((WAVELENGTHS + 12.0) * wavelength / size).ceil() as usize;
    let layers = [BoxLayer { name: material.name.clone(), thickness: HIGH as f64 * size, elements: HIGH }];
    let mesh = LayeredBox {
        dimension: 2,
        x: (0.0, length as f64 * size),
        y: (0.0, 1.0),
        layers: &layers,
        element_width: size,
        topography: None,
        moved_layers: 1,
        order: 1,
    };
    let mut ground = Ground::new(mesh.mesh()?, order, &[material])?;
    ground.set_memory(memory)?;
    ground.hold_component(1);
    for side in ["top", "bottom"] {
        ground.support(side, Support::Symmetry)?;
    }
    let dt = 0.4 * Solid::<f64>::critical_step(&ground, 1e-2, Execution::default())?;
    let steps = ((WAVELENGTHS / frequency + delay) / dt) as usize;
    let pulse = |n: usize| {
        let periods = frequency * (n as f64 * dt - delay);
        (TAU * periods).cos() * (-0.5 * (periods / bell).powi(2)).exp()
    };
    let forces = ground.traction("x_min", |_| [1.0, 0.0, 0.0])?;
    ground.add_load(forces, (0..steps).map(pulse).collect());
    let mut solid = Solid::<f64>::new(&ground, dt, dt, Execution::default());
    let all: Vec<u32> = (0..ground.numbering().nodes as u32).collect();
    let mut watch = Watch::new(&solid, &all);
    (0..steps).for_each(|_| solid.step());
    watch.before(&solid);
    solid.step();
    watch.after(&solid);
    Ok(unlike_a_plane_wave(&ground, watch.velocity(), size))
}

/// Share of the kinetic energy in v_z and in what of v_x differs over the height.
fn unlike_a_plane_wave(ground: &Ground, velocity: &[[f64; 3]], size: f64) -> f64 {
    let mut columns: BTreeMap<i64, Vec<(f64, f64)>> = BTreeMap::new();
    let (mut across, mut whole) = (0.0, 0.0);
    for ((x, v), m) in ground.positions().iter().zip(velocity).zip(ground.mass()) {
        columns.entry((1e6 * x[0] / size).round() as i64).or_default().push((*m, v[0]));
        across += m * v[2] * v[2];
        whole += m * (v[0] * v[0] + v[2] * v[2]);
    }
    for column in columns.values() {
        let mass: f64 = column.iter().map(|(m, _)| m).sum();
        let mean = column.iter().map(|(m, v)| m * v).sum::<f64>() / mass;
        across += column.iter().map(|(m, v)| m * (v - mean).powi(2)).sum::<f64>();
    }
    across / whole
}

/// Plane waves with coarse memory against full memory, and a P pulse's energy that turns into other waves. P and SV waves are
/// those of one mesh: twice the points for P. Twist: every miss.
pub(in crate::verify) fn attenuation_coarse(twisted: bool) -> CaseResult {
    const CASE: &str = "attenuation-coarse";
    const AMPLITUDE: f64 = 1e-2;
    const VELOCITY: f64 = 1e-4;
    const CONVERTED: f64 = 2e-3;
    let missed = |value: f64, limit: f64| value.abs() + if twisted { 3.0 * limit } else { 0.0 };
    let mut checks = vec![];
    let rows = [25.0, 50.0, 100.0]
        .into_iter()
        .flat_map(|q| [(2, q, CENTRE, 5.0), (2, q, CENTRE, 7.0), (2, q, EDGE, 5.0), (2, q, EDGE, 7.0)]);
    for (dimension, quality, frequency, points) in rows.chain([(3, 50.0, CENTRE, 5.0)]) {
        for (wave, points) in [(Wave::P, 2.0 * points), (Wave::Sv, points)] {
            let run = Run { dimension, wave, order: ORDER, points, quality, frequency };
            let Miss { amplitude, velocity } = run.misses()?.coarse;
            let word = format!(
                "{}, D = {dimension}, N = {ORDER}, Q = {quality}, {frequency} Hz, {points} points per wavelength: ",
                wave.name()
            );
            let miss = missed(amplitude, AMPLITUDE);
            checks.push(Check::error(CASE, format!("{word}amplitude against full memory"), miss, AMPLITUDE));
            let miss = missed(velocity, VELOCITY);
            checks.push(Check::error(
                CASE,
                format!("{word}phase velocity against full memory"),
                miss,
                VELOCITY,
            ));
        }
    }
    for quality in [25.0, 50.0, 100.0] {
        let share = converted(ORDER, 10.0, quality, CENTRE, Memory::Coarse)?;
        let word = format!(
            "P pulse, N = {ORDER}, Q = {quality}, 10 points per wavelength: share of energy in other waves"
        );
        checks.push(Check::error(CASE, word, missed(share, CONVERTED), CONVERTED));
    }
    // a measure that finds nothing proves nothing: round-off is all that full memory may convert
    let none = converted(ORDER, 10.0, 25.0, CENTRE, Memory::Full)?;
    let word = "P pulse, full memory: share of energy in other waves";
    checks.push(Check::error(CASE, word, missed(none, 1e-20), 1e-20));
    Ok(checks)
}

/// Misses over points per wavelength of SV waves, worst of P and SV on the same mesh: orders 3 to 8 at Q = 50, and order 4
/// at Q = 25, 50 and 100.
pub(in crate::verify) fn coarse_chart() -> Result<CaseFigure, RunError> {
    const POINTS: [f64; 7] = [4.0, 4.5, 5.0, 6.0, 7.0, 8.5, 10.0];
    let curve = |order: usize, quality: f64| -> Result<CoarseCurve, SemError> {
        let mut curve = CoarseCurve {
            order,
            quality,
            points: POINTS.to_vec(),
            amplitude: vec![],
            velocity: vec![],
            amplitude_full: vec![],
            velocity_full: vec![],
        };
        for p in POINTS {
            let run =
                |wave, points| Run { dimension: 2, wave, order, points, quality, frequency: CENTRE }.misses();
            let (of_p, of_s) = (run(Wave::P, 2.0 * p)?, run(Wave::Sv, p)?);
            let worst = |of: fn(&Misses) -> f64| of(&of_p).abs().max(of(&of_s).abs());
            curve.amplitude.push(worst(|m| m.coarse.amplitude));
            curve.velocity.push(worst(|m| m.coarse.velocity));
            curve.amplitude_full.push(worst(|m| m.full.amplitude));
            curve.velocity_full.push(worst(|m| m.full.velocity));
        }
        Ok(curve)
    };
    let orders = (3..=8).map(|order| curve(order, 50.0)).collect::<Result<Vec<_>, _>>()?;
    let middle = orders.iter().find(|c| c.order == ORDER).cloned();
    let mut qualities = vec![curve(ORDER, 25.0)?];
    qualities.extend(middle);
    qualities.push(curve(ORDER, 100.0)?);
    let (svg, csv) = coarse_figure(&orders, &qualities);
    Ok(CaseFigure { name: "attenuation-coarse", svg, tables: vec![("attenuation-coarse", csv)] })
}
