//! The accuracy that `auto` delivers, against runs finer in space and step.

use std::path::Path;

use crate::program::{folder, hati, number, write};
use crate::volume::content;

/// Times and one variable of a station file, `[time][station]`.
fn station_values(run: &Path, name: &str) -> (Vec<f64>, Vec<f64>) {
    let content = content(run);
    let of = |name: &str| content[name].iter().map(|b| f64::from_bits(*b)).collect();
    (of("stations elapsed_time"), of(&format!("stations {name}")))
}

/// Relative L2 difference of the acceleration at each of two stations over the named components, at the times of the
/// reference.
fn difference(run: &Path, reference: &Path, names: &[&str]) -> [f64; 2] {
    let (mut square, mut scale) = ([0.0_f64; 2], [0.0_f64; 2]);
    for name in names {
        let ((t, a), (t0, a0)) = (station_values(run, name), station_values(reference, name));
        let dt = t[1] - t[0];
        for (n, time) in t0.iter().enumerate().take_while(|(_, time)| **time + dt < t[t.len() - 1]) {
            let place = time / dt;
            let (i, part) = (place as usize, place.fract());
            for station in 0..2 {
                // the cubic through four neighbours: 20 samples a period are too few for straight lines
                let at = |k: usize| a[2 * (i + k).saturating_sub(1).min(t.len() - 1) + station];
                let (before, here, next, last) = (at(0), at(1), at(2), at(3));
                let bend = 2.0 * before - 5.0 * here + 4.0 * next - last;
                let twist = 3.0 * (here - next) + last - before;
                let value = here + 0.5 * part * (next - before + part * (bend + part * twist));
                square[station] += (value - a0[2 * n + station]).powi(2);
                scale[station] += a0[2 * n + station].powi(2);
            }
        }
    }
    [0, 1].map(|s| f64::sqrt(square[s] / scale[s]))
}

/// What `auto` chooses meets the accuracy asked, in a layered, damped section against a converged run; and a looser
/// accuracy gives a larger error, so that the choice is not merely lavish.
#[test]
fn the_accuracy_asked_is_reached_by_what_auto_chooses() {
    let dir = folder();
    let text = r#"
version = 1
[domain]
dimension = 2
x = [0.0, 120.0]
depth = 60.0
[soil]
reference_frequency = 1.95
[[soil.layer]]
thickness = 12.0
vs = 150.0
rho = 1800.0
damping = 0.03
[soil.base]
kind = "elastic"
vs = 400.0
rho = 2000.0
[[source]]
kind = "force"
position = [20.0, -31.0]
force = [1e5, 0.0, -1e6]
wavelet = { kind = "ricker", frequency = 5.0, time = 0.3 }
[run]
duration = 1.2
[output]
stations = [{ name = "a", position = [40.0], depth = 0.0 }, { name = "b", position = [90.0], depth = 0.0 }]
"#;
    let scene = write(dir.path(), "scene.toml", text);
    let run = |out: &str, more: &[&str]| {
        let sets = more.iter().flat_map(|s| ["--set", s]);
        let arguments: Vec<&str> = ["run", &scene, "--out", out].into_iter().chain(sets).collect();
        hati(dir.path(), &arguments).exits(0);
        dir.path().join(out)
    };
    let fine = [
        "discretisation.order=7",
        "discretisation.points_per_wavelength=7",
        "discretisation.f_max=13.82",
        "discretisation.dt=8e-5",
        "discretisation.mechanisms=6",
        "discretisation.precision=\"f64\"",
    ];
    let reference = run("reference", &fine);
    let errors = ["3e-2", "1e-2", "3e-3"].map(|accuracy| {
        let set = format!("accuracy={accuracy}");
        let found = difference(&run(accuracy, &[&set]), &reference, &["acceleration_x", "acceleration_z"]);
        found[0].max(found[1])
    });
    for (error, accuracy) in errors.iter().zip([3e-2, 1e-2, 3e-3]) {
        assert!(*error < accuracy && *error > 0.1 * accuracy, "{accuracy:e}: {errors:?}");
    }
}

/// A quarter of a half-space under a force on its surface: surface waves, and a source that no plane wave tells of.
const LAMB: &str = r#"
version = 1
[domain]
dimension = 3
x = [0.0, 50.0]
y = [0.0, 50.0]
depth = 40.0
[domain.boundary]
x_min = "symmetry"
y_min = "symmetry"
[soil.base]
kind = "elastic"
vs = 200.0
vp = 346.41
rho = 1800.0
[[source]]
kind = "force"
position = [0.0, 0.0, 0.0]
force = [0.0, 0.0, -1e6]
wavelet = { kind = "ricker", frequency = 10.0, time = 0.15 }
[run]
duration = 0.4
[output]
stations = [{ name = "a", position = [20.0, 0.0, 0.0] }, { name = "b", position = [40.0, 0.0, 0.0] }]
"#;

/// The same in three dimensions, against half as many points again per wavelength and half the step.
#[test]
fn the_accuracy_asked_is_reached_in_three_dimensions() {
    let dir = folder();
    let scene = write(dir.path(), "scene.toml", LAMB);
    let run = |out: &str, more: &[String]| {
        let sets = more.iter().flat_map(|s| ["--set", s]);
        let arguments: Vec<&str> = ["run", &scene, "--out", out, "--json"].into_iter().chain(sets).collect();
        (dir.path().join(out), hati(dir.path(), &arguments).exits(0).json())
    };
    let asked = [3e-2, 1e-2];
    let runs = asked.map(|a| run(&format!("{a}"), &[format!("accuracy={a}")]));
    let plan = &runs[1].1;
    let (f_max, dt) = (number(plan, "/model/f_max"), number(plan, "/model/dt"));
    let points = number(plan, "/model/points_per_wavelength");
    let fine = [
        format!("discretisation.points_per_wavelength={}", 1.5 * points),
        format!("discretisation.f_max={f_max}"),
        format!("discretisation.dt={}", 0.5 * dt),
    ];
    let (reference, finer) = run("reference", &fine);
    assert!(number(&finer, "/model/elements") > 2.5 * number(plan, "/model/elements"));
    let names = ["acceleration_x", "acceleration_z"];
    let errors =
        runs.map(|(folder, _)| difference(&folder, &reference, &names).into_iter().fold(0.0, f64::max));
    for (error, accuracy) in errors.iter().zip(asked) {
        assert!(*error < accuracy && *error > 0.1 * accuracy, "{accuracy:e}: {errors:?}");
    }
}
