//! What a plan in two or three dimensions decides and tells: precision, mechanisms, rows, boundaries, limits of values.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use crate::program::{Answer, folder, hati, number, write};
use crate::volume::content;

/// A strip of elastic ground around an explosion; `frequency` of its pulse, Hz.
fn strip(frequency: f64) -> String {
    format!(
        r#"
version = 1
[domain]
dimension = 2
x = [0.0, 24.0]
depth = 12.0
[soil.base]
kind = "elastic"
vs = 200.0
rho = 1900.0
[[source]]
kind = "moment"
position = [8.0, -5.0]
moment = [1e6, 0.0, 1e6, 0.0, 0.0, 0.0]
wavelet = {{ kind = "gaussian", frequency = {frequency:?}, time = {:?} }}
[discretisation]
order = 4
element_size = 3.0
elements = [4]
[run]
duration = {:?}
[output]
stations = [{{ name = "near", position = [11.0], depth = 0.0 }}, {{ name = "far", position = [22.0], depth = 0.0 }}]
"#,
        1.0 / frequency,
        if frequency > 10.0 { 5.0 / frequency } else { 2.0 / frequency }
    )
}

/// One variable of a station file, `[time][station]`.
fn values(run: &Path, name: &str) -> Vec<f64> {
    content(run)[&format!("stations {name}")].iter().map(|b| f64::from_bits(*b)).collect()
}

fn warnings(plan: &Value) -> String {
    plan["warnings"].to_string()
}

/// Largest difference of the accelerations of two runs over their peak, at the worse of two stations.
fn apart(a: &Path, b: &Path) -> f64 {
    let mut worst = 0.0_f64;
    for station in 0..2 {
        let (mut difference, mut peak) = (0.0_f64, 0.0_f64);
        for axis in ["acceleration_x", "acceleration_z"] {
            for (x, y) in values(a, axis).iter().zip(values(b, axis)).skip(station).step_by(2) {
                difference = difference.max((x - y).abs());
                peak = peak.max(y.abs());
            }
        }
        worst = worst.max(difference / peak);
    }
    worst
}

#[test]
fn precision_follows_the_noise_that_rounding_leaves_in_accelerations() {
    let dir = folder();
    // many steps to a period: the slower the pulse, the larger the displacement that is rounded beside its acceleration
    for (frequency, expected) in [(20.0, "f32"), (2.0, "f64")] {
        let scene = write(dir.path(), "scene.toml", &strip(frequency));
        let plan = hati(dir.path(), &["plan", &scene, "--json"]).exits(0).json();
        let (noise, allowed) =
            (number(&plan, "/accuracy/noise_of_f32"), number(&plan, "/accuracy/noise_allowed"));
        assert_eq!(plan["model"]["precision"], expected, "noise {noise:e}, {allowed:e} allowed");
        assert!((expected == "f64") == (noise > allowed), "{noise:e} against {allowed:e}");
        let runs = ["f32", "f64"].map(|precision| {
            let set = format!("discretisation.precision=\"{precision}\"");
            let out = format!("{expected}-{precision}");
            hati(dir.path(), &["run", &scene, "--out", &out, "--set", &set]).exits(0);
            dir.path().join(out)
        });
        let found = apart(&runs[0], &runs[1]);
        assert!(found < noise && found > 1e-3 * noise, "{found:e} where {noise:e} is predicted at most");
        if expected == "f64" {
            assert!(found > 1e-3, "single precision would do: {found:e}");
            let single = ["plan", &scene, "--json", "--set", "discretisation.precision=\"f32\""];
            let told = warnings(&hati(dir.path(), &single).exits(0).json());
            assert!(told.contains("rounding in single precision"), "{told}");
        }
    }
}

/// A plane SH wave of 10 Hz that runs along 25 of its lengths through damped ground.
const LONG_PATH: &str = r#"
version = 1
[domain]
dimension = 2
x = [0.0, 262.0]
[domain.boundary]
x_min = "free"
bottom = "free"
[[soil.layer]]
thickness = 5.0
vs = 100.0
rho = 1800.0
damping = 0.02
[soil.base]
kind = "rigid"
[[source]]
kind = "traction"
boundary = "x_min"
traction = [0.0, 1e5, 0.0]
wavelet = { kind = "ricker", frequency = 10.0, time = 0.15 }
[discretisation]
precision = "f64"
[run]
duration = 3.0
[output]
quantities = ["velocity"]
stations = [{ name = "end", position = [250.0], depth = 0.0 }]
"#;

#[test]
fn automatic_mechanisms_keep_a_wave_over_25_wavelengths() {
    let dir = folder();
    let scene = write(dir.path(), "scene.toml", LONG_PATH);
    let run = |out: &str, more: &[&str]| {
        let arguments = [&["run", &scene, "--out", out, "--json"], more].concat();
        let summary = hati(dir.path(), &arguments).exits(0).json();
        (values(&dir.path().join(out), "velocity_y"), number(&summary, "/model/mechanisms"))
    };
    let (found, chosen) = run("auto", &[]);
    let (expected, _) = run("eight", &["--set", "discretisation.mechanisms=8"]);
    let (coarse, _) = run("three", &["--set", "discretisation.mechanisms=3"]);
    let error = |x: &[f64]| {
        assert_eq!(x.len(), expected.len());
        let square: f64 = x.iter().zip(&expected).map(|(a, b)| (a - b).powi(2)).sum();
        (square / expected.iter().map(|b| b * b).sum::<f64>()).sqrt()
    };
    assert!(chosen < 8.0, "{chosen} mechanisms");
    assert!(error(&found) < 1e-2, "{chosen} mechanisms: {:e}", error(&found));
    assert!(error(&coarse) > 2e-2, "three would do: {:e}", error(&coarse));
    let few = ["plan", &scene, "--json", "--set", "discretisation.mechanisms=3"];
    let told = warnings(&hati(dir.path(), &few).exits(0).json());
    assert!(told.contains("3 mechanisms keep the modulus"), "{told}");
}

#[test]
fn a_plan_tells_rows_that_are_filtered_and_a_filter_that_is_long() {
    let dir = folder();
    let text = format!("{}[output.surface]\ndt = 0.02\n", strip(5.0));
    let scene = write(dir.path(), "scene.toml", &text);
    let plan = |more: &[&str]| {
        let answer = hati(dir.path(), &[&["plan", &scene, "--json"], more].concat()).exits(0).json();
        (answer["reasons"].to_string(), warnings(&answer))
    };
    let (reasons, told) = plan(&[]);
    assert!(reasons.contains("taken as they are") && !told.contains("filter"), "{reasons} {told}");
    // rows of 0.02 s hold the 10.7 Hz of the pulse, and not the 21 Hz of a quicker one, whatever f_max says
    let quicker = ["--set", "source[1].wavelet.frequency=10", "--set", "discretisation.f_max=10"];
    let (reasons, told) = plan(&quicker);
    assert!(reasons.contains("low-passed at 25.000 Hz") && reasons.contains("0.220 s ahead"), "{reasons}");
    assert!(told.contains("reaches 0.220 s ahead and back, 55 %"), "{told}");
}

/// Three by two elements of 10 m with groups on all sides, without the eastern one where it is not `closed`, and one between
/// the layers.
fn mesh(surface: &str, closed: bool) -> String {
    let mut text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n5\n1 1 \"{surface}\"\n1 2 \"floor\"\n1 3 \"west\"\n\
         1 4 \"interface\"\n2 5 \"soil\"\n$EndPhysicalNames\n$Nodes\n12\n"
    );
    let node = |i: usize, k: usize| 4 * k + i + 1;
    for k in 0..3 {
        for i in 0..4 {
            let _ = writeln!(text, "{} {} {} 0", node(i, k), 10 * i, 10.0 * k as f64 - 20.0);
        }
    }
    let mut elements = vec![];
    for (group, k) in [(1, 2), (2, 0), (4, 1)] {
        elements.extend((0..3).map(|i| format!("1 2 {group} {group} {} {}", node(i, k), node(i + 1, k))));
    }
    for i in if closed { vec![0, 3] } else { vec![0] } {
        elements.extend((0..2).map(|k| format!("1 2 3 3 {} {}", node(i, k), node(i, k + 1))));
    }
    for k in 0..2 {
        for i in 0..3 {
            let [a, b, c, d] = [node(i, k), node(i + 1, k), node(i + 1, k + 1), node(i, k + 1)];
            elements.push(format!("3 2 5 5 {a} {b} {c} {d}"));
        }
    }
    let _ = writeln!(text, "$EndNodes\n$Elements\n{}", elements.len());
    for (number, element) in elements.iter().enumerate() {
        let _ = writeln!(text, "{} {element}", number + 1);
    }
    text + "$EndElements\n"
}

const MESHED: &str = r#"
version = 1
[domain]
dimension = 2
mesh = "soil.msh"
[domain.boundary]
west = "fixed"
[[material]]
name = "soil"
vs = 200.0
rho = 1900.0
[[source]]
kind = "force"
position = [11.0, -7.0]
force = [0.0, 0.0, 1e6]
wavelet = { kind = "ricker", frequency = 5.0, time = 0.2 }
[run]
duration = 0.4
[output]
stations = [{ name = "a", position = [21.0, -3.0] }]
"#;

#[test]
fn every_boundary_of_a_mesh_is_told_with_its_kind_and_origin() {
    let dir = folder();
    let scene = write(dir.path(), "scene.toml", MESHED);
    write(dir.path(), "soil.msh", &mesh("top", false));
    let plan = hati(dir.path(), &["plan", &scene]).exits(0).stdout;
    for word in [
        "`top` free (default)",
        "`floor` absorbing (default)",
        "`west` fixed (user)",
        "2 sides of the mesh's surface are in no physical group, the first around x = 30 m, z = -15 m",
        "the group `interface` lies between elements",
    ] {
        assert!(plan.contains(word), "{word} is missing in {plan}");
    }
    assert!(!plan.contains("no free boundary"));
    hati(dir.path(), &["run", &scene, "--out", "run"]).exits(0);
    let read = |name: &str| std::fs::read_to_string(dir.path().join("run").join(name)).expect(name);
    let resolved = read("scene.resolved.toml");
    for line in ["west = \"fixed\" # user", "floor = \"absorbing\" # default", "top = \"free\" # default"] {
        assert!(resolved.contains(line), "{line} is missing in {resolved}");
    }
    assert!(read("report.html").contains("`floor` absorbing (default)"));
    let path = dir.path().join("run/scene.resolved.toml").display().to_string();
    hati(dir.path(), &["check", &path]).exits(0);
}

#[test]
fn a_surface_of_another_name_and_an_inner_boundary_are_told() {
    let dir = folder();
    write(dir.path(), "soil.msh", &mesh("ground", false));
    let closed = MESHED.replace("west = \"fixed\"", "west = \"fixed\"\nground = \"absorbing\"");
    let scene = write(dir.path(), "scene.toml", &closed);
    // the side that no group holds is free: there is no more to say of it than that
    assert!(!hati(dir.path(), &["plan", &scene]).exits(0).stdout.contains("no free boundary"));
    write(dir.path(), "soil.msh", &mesh("ground", true));
    let scene = write(dir.path(), "scene.toml", MESHED);
    let plan = hati(dir.path(), &["plan", &scene]).exits(0).stdout;
    assert!(plan.contains("`ground` absorbing (default)"), "{plan}");
    assert!(plan.contains("the mesh has no free boundary") && plan.contains("`top`"), "{plan}");
    let inner = MESHED.replace("west = \"fixed\"", "interface = \"fixed\"");
    let scene = write(dir.path(), "scene.toml", &inner);
    hati(dir.path(), &["plan", &scene]).exits(2).tells(&["`interface`", "inside the mesh", "group"]);
}

#[test]
fn values_out_of_all_bounds_are_refused_before_a_mesh_is_made() {
    let dir = folder();
    let scene = write(dir.path(), "scene.toml", &strip(5.0));
    let refused = |sets: &[&str], words: &[&str]| {
        let sets = sets.iter().flat_map(|s| ["--set", s]);
        let arguments: Vec<&str> = ["check", &scene].into_iter().chain(sets).collect();
        let answer: Answer = hati(dir.path(), &arguments).exits(2);
        assert!(answer.stderr.len() + answer.stdout.len() < 2000, "{}", answer.stderr);
        answer.tells(words);
    };
    refused(&["domain.depth=1e-300"], &["domain.depth"]);
    refused(&["domain.x=[0.0, 1e-300]"], &["domain.x", "spans less"]);
    refused(&["soil.base.rho=1e300"], &["soil.base.rho", "at most"]);
    refused(&["discretisation.element_size=1e-300"], &["element_size"]);
    refused(&["output.checkpoint.every=1e30"], &["output.checkpoint.every", "at most"]);
    refused(&["output.surface.quantities=[\"velocity\", \"strain\"]"], &["\"strain\"", "stations only"]);
    refused(&["output.field.quantities=[\"stress\"]"], &["\"stress\"", "stations only"]);
    let longest = ["plan", &scene, "--set", "output.checkpoint.every=1e9"];
    hati(dir.path(), &longest).exits(0);
}

#[test]
fn a_station_writes_what_it_is_asked_for_and_exports_all_of_it() {
    let dir = folder();
    let stations = "output.stations=[{name=\"tensors\", position=[11.0, -2.0], quantities=[\"strain\", \"stress\"]}, \
                    {name=\"speed\", position=[20.0, -2.0], quantities=[\"velocity\"]}]";
    let scene = write(dir.path(), "scene.toml", &strip(5.0));
    let summary =
        hati(dir.path(), &["run", &scene, "--out", "run", "--json", "--set", stations]).exits(0).json();
    let run = dir.path().join("run");
    for (name, written) in
        [("displacement_x", [false; 2]), ("velocity_z", [false, true]), ("strain_xx", [true, false])]
    {
        let values = values(&run, name);
        for (station, written) in written.into_iter().enumerate() {
            let mut own = values.iter().skip(station).step_by(2);
            assert!(own.all(|v| v.is_nan() != written), "{name} at station {station}");
        }
    }
    assert!(number(&summary, "/results/speed/z/pgv") > 0.0);
    assert!(summary["results"]["speed"]["z"]["pga"].is_null() && summary["results"]["tensors"].is_null());
    hati(dir.path(), &["export", "run", "--csv"]).exits(0);
    let find = |name: &str| {
        let found = ["run/export", "run"].map(|folder| dir.path().join(folder).join(name));
        std::fs::read_to_string(found.iter().find(|p| p.exists()).expect(name)).expect(name)
    };
    let tensors = find("tensors.csv");
    assert!(tensors.contains(",strain_xx,") && tensors.contains(",stress_zz_Pa"), "{}", &tensors[..300]);
    assert!(!tensors.contains("velocity"));
    let strain = values(&run, "strain_xx");
    let column = tensors.lines().filter(|l| !l.starts_with(['#', 't'])).map(|l| {
        let cell = l.split(',').nth(1).expect("a column");
        cell.parse::<f64>().expect("a number")
    });
    assert!(column.zip(strain.iter().step_by(2)).all(|(a, b)| a == *b));
    assert!(find("speed.csv").contains("velocity_z_m_s") && !find("speed.csv").contains("strain"));
}
