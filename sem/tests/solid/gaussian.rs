//! Gaussian loads of any width: their sum, their first moments, both limits.

use super::small_box;
use hati_sem::mesh::Locator;
use hati_sem::solid::{Gaussian, Ground, Material};

fn ground(dimension: usize, geometry: usize, order: usize, deformed: bool) -> Ground {
    let soil = |name| Material::elastic(name, 1800.0, 400.0, 200.0);
    Ground::new(small_box(dimension, geometry, deformed), order, &[soil("soft"), soil("stiff")]).unwrap()
}

/// $\int_a^b \frac{x^k}{\sqrt{2\pi}\sigma} e^{-(x-c)^2/2\sigma^2}dx$ by Simpson's rule where the load is.
fn part(a: f64, b: f64, c: f64, sigma: f64, k: i32) -> f64 {
    let (a, b) = (a.max(c - 12.0 * sigma), b.min(c + 12.0 * sigma));
    let count = 4000;
    let h = (b - a) / f64::from(count);
    let g = |i: i32| {
        let x = a + h * f64::from(i);
        let r = (x - c) / sigma;
        x.powi(k) * (-0.5 * r * r).exp() / (2.0 * std::f64::consts::PI).sqrt() / sigma
    };
    (0..count).step_by(2).map(|i| h / 3.0 * (g(i) + 4.0 * g(i + 1) + g(i + 2))).sum()
}

#[test]
fn the_weights_have_the_loads_sum_and_moments_at_any_width() {
    for (dimension, order) in [(2, 2), (2, 4), (3, 3), (3, 5)] {
        let ground = ground(dimension, 1, order, false);
        let positions = ground.positions();
        for sigma in [30.0, 2.0, 0.6, 0.1, 0.013, 2e-4] {
            for horizontal in [false, true] {
                let load = Gaussian { centre: [1.3, 0.2, 0.0], horizontal, sigma };
                let weights = ground.gaussian("top", &load).unwrap();
                let moment = |kx: i32, ky: i32| -> f64 {
                    let at = |p: u32| positions[p as usize];
                    weights.iter().map(|&(p, w)| w * at(p)[0].powi(kx) * at(p)[1].powi(ky)).sum()
                };
                let exact = |kx: i32, ky: i32| {
                    let y = if dimension == 3 { part(-1.0, 1.0, 0.2, sigma, ky) } else { 1.0 };
                    part(0.0, 3.0, 1.3, sigma, kx) * y
                };
                // whatever the basis holds exactly: the force, its place, its spread
                for (kx, ky) in [(0, 0), (1, 0), (2, 0), (0, 1), (0, 2)] {
                    if dimension == 2 && ky > 0 {
                        continue;
                    }
                    let (found, exact) = (moment(kx, ky), exact(kx, ky));
                    assert!(
                        (found - exact).abs() < 3e-9,
                        "{dimension} {order} {sigma} {kx} {ky}: {found} {exact}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_narrow_load_is_the_point_force_and_a_wide_one_that_of_the_sides_rule() {
    for (dimension, geometry) in [(2, 1), (3, 1), (2, 2), (3, 2)] {
        let ground = ground(dimension, geometry, 4, true);
        let locator = Locator::new(ground.mesh());
        let seat = locator.find_on_surface(1.3, 0.2).unwrap().position;
        let mut point = ground.probe(&locator, seat).unwrap().weights;
        point.sort_unstable_by_key(|w| w.0);
        let mut errors = vec![];
        for sigma in [1e-2, 1e-4, 1e-9] {
            let narrow =
                ground.gaussian("top", &Gaussian { centre: seat, horizontal: false, sigma }).unwrap();
            let of = |p: u32| narrow.iter().find(|w| w.0 == p).map_or(0.0, |w| w.1);
            errors.push(point.iter().map(|&(p, w)| (of(p) - w).abs()).fold(0.0, f64::max));
            let total: f64 = narrow.iter().map(|w| w.1).sum();
            assert!((total - 1.0).abs() < 1e-3, "{dimension} {geometry} {sigma}: {total}");
        }
        // the basis is smooth at the seat: the difference is of second order in σ
        assert!(
            errors[0] < 3e-3 && errors[1] < 3e-7 && errors[2] < 1e-9,
            "{dimension} {geometry}: {errors:?}"
        );

        let load = Gaussian { centre: seat, horizontal: false, sigma: 2.0 };
        let wide = ground.gaussian("top", &load).unwrap();
        let area = (2.0 * std::f64::consts::PI).sqrt().powi(dimension as i32 - 1)
            * 2.0_f64.powi(dimension as i32 - 1);
        let pressure = |x: [f64; 3]| {
            let r2: f64 =
                (0..3).filter(|i| dimension == 3 || *i != 1).map(|i| (x[i] - seat[i]).powi(2)).sum();
            [0.0, 0.0, (-0.125 * r2).exp() / area]
        };
        let sum = |of: &dyn Fn([f64; 3]) -> f64| -> f64 {
            let positions = ground.positions();
            wide.iter().map(|(p, w)| w * of(positions[*p as usize])).sum()
        };
        let rule = ground.traction("top", pressure).unwrap();
        let positions = ground.positions();
        for k in [0, 1, 2] {
            let by_rule: f64 = rule.iter().map(|(p, f)| f[2] * positions[*p as usize][0].powi(k)).sum();
            let found = sum(&|x| x[0].powi(k));
            assert!(
                (found - by_rule).abs() < 2e-6 * by_rule.abs(),
                "{dimension} {geometry}: {found} {by_rule}"
            );
        }
    }
}

#[test]
fn a_load_per_area_of_the_plan_keeps_its_sum_on_a_slope() {
    for dimension in [2, 3] {
        let mut mesh = small_box(dimension, 1, false);
        mesh.deform(|[x, y, z]| [x, y, z + 0.7 * x]);
        let soil = |name| Material::elastic(name, 1800.0, 400.0, 200.0);
        let ground = Ground::new(mesh, 4, &[soil("soft"), soil("stiff")]).unwrap();
        for (horizontal, z) in [(true, 55.0), (false, 0.7 * 1.4)] {
            let load = Gaussian { centre: [1.4, 0.1, z], horizontal, sigma: 0.08 };
            let share: f64 = ground.gaussian("top", &load).unwrap().iter().map(|w| w.1).sum();
            assert!((share - 1.0).abs() < 1e-9, "{dimension} {horizontal}: {share}");
        }
        let beside = Gaussian { centre: [9.0, 0.0, 0.0], horizontal: true, sigma: 0.3 };
        assert!(ground.gaussian("top", &beside).unwrap().is_empty());
    }
}
