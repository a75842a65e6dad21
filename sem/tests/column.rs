//! The column against exact discrete and continuous solutions, its energy and its limit.

use hati_coupling::{State, Subdomain, window_response};
use hati_sem::attenuation::{MaxwellArms, ModulusLaw, constant_damping_factor};
use hati_sem::column::{BaseMotion, Column, Discretisation, FrequencyResponse, Mesh, TimeSymbol};
use hati_sem::soil::{Base, Layer, Profile};
use num_complex::Complex64;
use std::f64::consts::PI;

fn layer(thickness: f64, vs: f64, rho: f64, damping: f64) -> Layer {
    Layer { name: "l".into(), thickness, vs, vp: 2.0 * vs, rho, damping_s: damping, damping_p: 0.5 * damping }
}

fn three_layers(damped: bool, base: Base) -> Profile {
    let d = if damped { 1.0 } else { 0.0 };
    Profile {
        layers: vec![
            layer(5.0, 150.0, 1800.0, 0.02 * d),
            layer(10.0, 250.0, 1900.0, 0.05 * d),
            layer(15.0, 400.0, 2000.0, 0.01 * d),
        ],
        base,
        reference_frequency: 2.0,
    }
}

const ROCK: Base = Base::Elastic { vs: 800.0, vp: 1600.0, rho: 2200.0 };

fn arms(profile: &Profile, mechanisms: usize) -> Vec<[MaxwellArms; 3]> {
    let fit = |d: f64| MaxwellArms::fit(d, profile.reference_frequency, (0.2, 20.0), mechanisms).unwrap();
    profile.layers.iter().map(|l| [fit(l.damping_s), fit(l.damping_s), fit(l.damping_p)]).collect()
}

/// Velocity of a Ricker wavelet at the kicks.
fn ricker(f: f64, t0: f64, dt: f64, duration: f64) -> Vec<f64> {
    (0..(duration / dt) as usize)
        .map(|i| {
            let a = (PI * f * (i as f64 * dt - t0)).powi(2);
            (1.0 - 2.0 * a) * (-a).exp()
        })
        .collect()
}

fn spectrum(x: &[f64], dt: f64, f: f64) -> Complex64 {
    let w = Complex64::new(0.0, -2.0 * PI * f * dt);
    x.iter().enumerate().map(|(i, x)| x * (w * i as f64).exp()).sum()
}

#[test]
fn the_time_loop_has_the_discrete_frequency_response() {
    for (base, damped) in [(ROCK, false), (ROCK, true), (Base::Rigid, true)] {
        let profile = three_layers(damped, base);
        let discretisation = Discretisation { order: 4, elements: vec![2, 2, 1] };
        let arms = arms(&profile, 4);
        let rigid = base == Base::Rigid;
        for axis in [0, 2] {
            let dt = 0.8 * Column::critical_step(&profile, &discretisation, &arms, &[axis], rigid).unwrap().0;
            let pulse = ricker(4.0, 0.5, dt, 1.0);
            let steps = (if rigid {
                80.0
            } else if damped {
                30.0
            } else {
                8.0
            } / dt) as usize;
            let mut motion = [None, None, None];
            let mut u = 0.0;
            let displacement: Vec<f64> = pulse.iter().map(|v| (u += dt * v, u).1).collect();
            let held = displacement[displacement.len() - 1];
            motion[axis] = Some(if rigid {
                BaseMotion::Imposed(displacement.clone())
            } else {
                BaseMotion::Outcrop(pulse.clone())
            });
            let mut column = Column::new(&profile, &discretisation, &arms, dt, motion).unwrap();
            let depths = [0.0, 3.3, 11.0, 30.0];
            let probes: Vec<_> = depths.iter().map(|&d| column.mesh().probe(d).unwrap()).collect();
            let mut a = vec![vec![]; depths.len()];
            for _ in 0..steps {
                column.step();
                for (a, p) in a.iter_mut().zip(&probes) {
                    a.push(column.motion_at(p, 0).acceleration);
                }
            }
            assert!(held.abs() < 1e-10, "the pulse ends at rest: {held}");
            let laws: Vec<_> = arms.iter().map(|l| ModulusLaw::Maxwell(l[axis].clone())).collect();
            let symbol = TimeSymbol::CentralDifference(dt);
            let response =
                FrequencyResponse::new(&profile, &discretisation, axis, &laws, symbol, &depths).unwrap();
            for f in [0.7, 2.0, 3.9, 7.3, 9.1] {
                let omega = 2.0 * PI * f;
                let input = if rigid {
                    -omega * omega * spectrum(&displacement, dt, f)
                } else {
                    Complex64::new(0.0, omega) * spectrum(&pulse, dt, f)
                };
                let exact = response.at(f);
                for (k, a) in a.iter().enumerate() {
                    let run = spectrum(a, dt, f) / input;
                    let expected = exact.per_within[k] * exact.within_per_outcrop;
                    let error = (run - expected).norm() / expected.norm();
                    assert!(
                        error < 1e-7,
                        "axis {axis} damped {damped} {base:?} f {f} depth {}: {run} against {expected}",
                        depths[k]
                    );
                }
            }
        }
    }
}

#[test]
fn semi_discrete_response_is_the_closed_form_of_a_uniform_layer() {
    // surface/outcrop = 1/(cos kH + i z sin kH), k = ω/c*, c* = sqrt(G*/ρ), z = ρc*/(ρ_r c_r)
    let profile =
        Profile { layers: vec![layer(20.0, 200.0, 1900.0, 0.05)], base: ROCK, reference_frequency: 3.0 };
    let law = ModulusLaw::ConstantDamping { damping: 0.05, reference_frequency: 3.0 };
    let mesh = Discretisation { order: 10, elements: vec![8] };
    let response =
        FrequencyResponse::new(&profile, &mesh, 0, &[law], TimeSymbol::Continuous, &[0.0, 7.0]).unwrap();
    for i in 1..200 {
        let f = 0.2 * i as f64;
        let omega = 2.0 * PI * f;
        let c = 200.0 * constant_damping_factor(0.05, Complex64::new(0.0, f / 3.0)).sqrt();
        let (k, z) = (omega / c, 1900.0 * c / (2200.0 * 800.0));
        let kh = k * 20.0;
        let surface = (kh.cos() + Complex64::I * z * kh.sin()).inv();
        let inside = (k * 7.0).cos() * surface;
        let t = response.at(f);
        for (found, exact) in [(t.per_within[0], surface), (t.per_within[1], inside)] {
            let found = found * t.within_per_outcrop;
            assert!((found - exact).norm() < 1e-8 * exact.norm().max(0.1), "{f} Hz: {found} against {exact}");
        }
    }
}

#[test]
fn ledger_closes_to_round_off_elastic_and_damped_elastic_base_and_imposed() {
    for damped in [false, true] {
        for base in [ROCK, Base::Rigid] {
            let profile = three_layers(damped, base);
            let mesh = Discretisation { order: 5, elements: vec![1, 2, 2] };
            let arms = arms(&profile, 3);
            let dt = 0.9
                * Column::critical_step(&profile, &mesh, &arms, &[0, 1, 2], profile.base == Base::Rigid)
                    .unwrap()
                    .0;
            let pulse = |f: f64| ricker(f, 0.3, dt, 1.0);
            let wrap = |v: Vec<f64>| {
                Some(if base == Base::Rigid { BaseMotion::Imposed(v) } else { BaseMotion::Outcrop(v) })
            };
            let motion = [wrap(pulse(5.0)), wrap(pulse(7.0)), wrap(pulse(9.0))];
            let mut column = Column::new(&profile, &mesh, &arms, dt, motion).unwrap();
            column.set_multiplier(0, &[1e3, -2e3, 5e2]);
            let start = column.energies();
            let mut ledger = hati_coupling::Ledger::start(&start);
            for step in 0..20_000 {
                if step == 9000 {
                    column.set_multiplier(0, &[0.0; 3]);
                }
                column.step();
                if step % 7 == 0 {
                    ledger.book(&column.energies());
                }
            }
            let error = ledger.closing_error();
            assert!(error < 1e-11, "damped {damped}, {base:?}: {error}");
            assert!(ledger.last.viscous > 0.0 || !damped);
            assert!(ledger.stored_max > 0.0);
            assert_eq!(damped, ledger.last.viscous > 0.05 * ledger.last.input, "the viscous line is real");
        }
    }
}

#[test]
fn stable_at_0_999_and_unstable_at_1_01_of_the_limit() {
    for order in 1..=10 {
        for (damped, base) in [(false, ROCK), (true, ROCK), (true, Base::Rigid)] {
            let profile = three_layers(damped, base);
            let mesh = Discretisation { order, elements: vec![1, 2, 2] };
            let arms = arms(&profile, 3);
            let limit =
                Column::critical_step(&profile, &mesh, &arms, &[0], profile.base == Base::Rigid).unwrap().0;
            for (factor, stable) in [(0.999, true), (1.01, false)] {
                let dt = factor * limit;
                let noise: Vec<f64> = (0..100).map(|i| ((i * 7919) % 13) as f64 - 6.0).collect();
                let motion =
                    if base == Base::Rigid { BaseMotion::Imposed(noise) } else { BaseMotion::Outcrop(noise) };
                let mut column = Column::new(&profile, &mesh, &arms, dt, [Some(motion), None, None]).unwrap();
                for _ in 0..20_000 {
                    column.step();
                }
                let (v, depth) = column.fastest_point();
                let bound = if base == Base::Rigid { 1e3 / dt } else { 1e3 };
                assert_eq!(
                    v < bound,
                    stable,
                    "order {order} damped {damped} {base:?} at {factor}: {v} m/s at {depth} m"
                );
            }
        }
    }
}

#[test]
fn a_restored_state_goes_on_bit_for_bit_and_the_window_response_is_symmetric() {
    let profile = three_layers(true, ROCK);
    let mesh = Discretisation { order: 4, elements: vec![1, 1, 1] };
    let arms = arms(&profile, 2);
    let dt =
        0.7 * Column::critical_step(&profile, &mesh, &arms, &[0, 2], profile.base == Base::Rigid).unwrap().0;
    let pulse = ricker(6.0, 0.2, dt, 0.5);
    let motion = [Some(BaseMotion::Outcrop(pulse.clone())), None, Some(BaseMotion::Outcrop(pulse))];
    let mut column = Column::new(&profile, &mesh, &arms, dt, motion).unwrap();
    (0..500).for_each(|_| column.step());
    let mut state = State::default();
    column.save(&mut state);
    let mut other = column.clone();
    (0..500).for_each(|_| column.step());
    (0..77).for_each(|_| other.step());
    other.restore(&state).unwrap();
    (0..500).for_each(|_| other.step());
    assert_eq!(column.energies(), other.energies());
    assert_eq!(
        column.motion_at(&column.mesh().probe(1.0).unwrap(), 1),
        other.motion_at(&other.mesh().probe(1.0).unwrap(), 1)
    );
    let y = window_response(&mut other, 0, 50).unwrap();
    assert!(y[(0, 0)] > 0.0 && y[(0, 1)] == 0.0 && y[(1, 0)] == 0.0, "{y}");
    assert!(matches!(other.restore(&State::default()), Err(e) if e.to_string().contains("column")));
}

#[test]
fn probes_outside_the_column_and_wrong_counts_are_refused() {
    let profile = three_layers(false, ROCK);
    let mesh = Mesh::new(&profile, &Discretisation { order: 3, elements: vec![1, 1, 1] }).unwrap();
    assert!(mesh.probe(30.1).unwrap_err().to_string().contains("30.1 m lies outside"));
    assert!(Mesh::new(&profile, &Discretisation { order: 3, elements: vec![1, 0, 1] }).is_err());
    assert!(Mesh::new(&profile, &Discretisation { order: 3, elements: vec![1, 1] }).is_err());
}
#[test]
fn response_is_smooth_where_an_element_with_fixed_ends_resonates() {
    // 150 m/s in 8 m: half a wave at 9.375 Hz, to the last bit
    let profile = Profile {
        layers: vec![layer(8.0, 150.0, 1800.0, 0.0), layer(0.5, 600.0, 2000.0, 0.0)],
        base: ROCK,
        reference_frequency: 2.0,
    };
    let laws = [ModulusLaw::Elastic, ModulusLaw::Elastic];
    let response = |order: usize, elements: Vec<usize>| {
        let mesh = Discretisation { order, elements };
        FrequencyResponse::new(&profile, &mesh, 0, &laws, TimeSymbol::Continuous, &[0.0, 5.0, 8.0])
            .unwrap()
            .at(9.375)
    };
    let (whole, cut) = (response(10, vec![1, 1]), response(7, vec![13, 2]));
    for (a, b) in whole.per_within.iter().zip(&cut.per_within) {
        let (a, b) = (a * whole.within_per_outcrop, b * cut.within_per_outcrop);
        assert!((a - b).norm() < 1e-6, "{a} against {b}");
    }
}
