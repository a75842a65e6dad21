//! `hati export`: a run folder as CSV, miniSEED and SAC; what cannot be exported.

use std::path::Path;
use std::process::Command;

use crate::program::{folder, hati, read_json, write};
use crate::python::{hati_with, interpreter};
use crate::results::File;
use crate::scenes::{SceneText, ricker};

/// A short run with motion along x and z, in `folder/r`.
fn run(folder: &Path) {
    let scene = SceneText {
        motions: vec![('x', ricker(4.0, 1.0, 0.5, 2.0)), ('z', ricker(6.0, 0.5, 0.6, 2.0))],
        discretisation: "order = 4\nmechanisms = 1\ntail = 0.5".into(),
        ..SceneText::default()
    };
    let scene = write(folder, "scene.toml", &scene.text());
    let answer = hati(folder, &["run", &scene, "--out", "r"]);
    // Coarse on purpose: the accuracy is of no interest here.
    assert!(matches!(answer.code, Some(0 | 1)), "{}", answer.stderr);
}

#[test]
fn stations_become_csv_digit_by_digit() {
    let folder = folder();
    run(folder.path());
    let answer = hati(folder.path(), &["export", "r", "--csv"]).exits(0);
    let stations = File::open(&folder.path().join("r"), "stations.nc");
    for place in ["surface", "within", "outcrop"] {
        assert!(answer.stdout.contains(&format!("r/export/{place}.csv  CSV: ")), "{}", answer.stdout);
        let text = std::fs::read_to_string(folder.path().join(format!("r/export/{place}.csv"))).expect("CSV");
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
        assert_eq!(head.len(), 7, "{head:?}");
        assert_eq!(head[..3], ["time_s", "acceleration_x_m_s2", "acceleration_z_m_s2"]);
        let rows: Vec<Vec<f64>> =
            lines.map(|l| l.split(',').map(|n| n.parse().expect("a number")).collect()).collect();
        assert_eq!(rows.len(), stations.records());
        for (column, name) in head.iter().enumerate() {
            let variable = match name.split_once("_m") {
                Some((motion, _)) if place == "outcrop" => format!("outcrop_{motion}"),
                Some((motion, _)) => motion.to_owned(),
                None => "elapsed_time".to_owned(),
            };
            let wanted = match place {
                "outcrop" => stations.values(&variable),
                _ if column == 0 => stations.values(&variable),
                _ => stations.at(&variable, place),
            };
            let found: Vec<f64> = rows.iter().map(|row| row[column]).collect();
            assert_eq!(found, wanted, "{place} {name}");
        }
    }
}

#[test]
fn one_place_and_json() {
    let folder = folder();
    run(folder.path());
    let answer =
        hati(folder.path(), &["export", "r", "--csv", "--place", "surface", "--out", "o", "--json"]).exits(0);
    let value = answer.json();
    assert_eq!(value["files"].as_array().map(Vec::len), Some(1), "{value}");
    assert_eq!(value["files"][0]["path"], "o/surface.csv");
    assert_eq!(value["files"][0]["format"], "csv");
    let made: Vec<_> = std::fs::read_dir(folder.path().join("o")).expect("o").collect();
    assert_eq!(made.len(), 1);
}

#[test]
fn what_cannot_be_exported_is_told() {
    let folder = folder();
    run(folder.path());
    let cwd = folder.path();
    hati(cwd, &["export", "r"]).exits(2).prints_nothing().tells(&["--csv"]);
    hati(cwd, &["export", "nowhere", "--csv"]).exits(2).prints_nothing().tells(&["nowhere", "hati run"]);
    hati(cwd, &["export", "r", "--csv", "--place", "roof", "--json", "--out", "o"])
        .fails_in_json(2, &["no place “roof”", "surface, top of layer 2, within, outcrop"]);
    assert!(!cwd.join("o").exists(), "nothing is made for a place that is not there");
    // A column's field goes over depth only.
    hati(cwd, &["export", "r", "--vtkhdf"]).exits(2).tells(&["field.nc", "--csv"]);
    std::fs::create_dir(cwd.join("empty")).expect("a folder");
    hati(cwd, &["export", "empty", "--csv"]).exits(2).tells(&["stations.nc", "is not there"]);
    write(cwd, "taken", "not a folder");
    hati(cwd, &["export", "r", "--csv", "--out", "taken"])
        .exits(4)
        .tells(&["cannot write into folder taken"]);
    write(&cwd.join("empty"), "stations.nc", "no NetCDF");
    hati(cwd, &["export", "empty", "--csv"]).exits(2).tells(&["stations.nc", "cannot be read"]);
}

/// ObsPy reads the files back: times, channels, and the unit that SAC's code means.
#[test]
fn stations_become_miniseed_and_sac() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    run(folder.path());
    let arguments = ["export", "r", "--mseed", "--sac", "--place", "surface", "--json"];
    let value = hati_with(python, folder.path(), &arguments).exits(0).json();
    assert_eq!(value["files"].as_array().map(Vec::len), Some(3 + 6), "{value}");
    let script = folder.path().join("read.py");
    let text = "import json, sys, obspy\n\
                out = {}\n\
                for name in sys.argv[1:]:\n\
                \x20   form = 'SAC' if name.endswith('.sac') else 'MSEED'\n\
                \x20   for tr in obspy.read(name, format=form):\n\
                \x20       idep = int(tr.stats.sac.idep) if form == 'SAC' else None\n\
                \x20       out[f'{form} {tr.stats.channel}'] = dict(dt=tr.stats.delta, n=tr.stats.npts, idep=idep,\n\
                \x20           station=tr.stats.station, data=[float(v) for v in tr.data])\n\
                json.dump(out, open('back.json', 'w'))\n";
    std::fs::write(&script, text).expect("a script");
    let files = value["files"].as_array().expect("files");
    let names = files.iter().map(|f| f["path"].as_str().expect("a path"));
    let status =
        Command::new(python).current_dir(folder.path()).arg("read.py").args(names).status().expect("Python");
    assert!(status.success());
    let back = read_json(folder.path().join("back.json"));
    let stations = File::open(&folder.path().join("r"), "stations.nc");
    for (sensor, motion, idep) in
        [("HN", "acceleration", 8), ("HH", "velocity", 7), ("HX", "displacement", 6)]
    {
        for axis in ["x", "z"] {
            let wanted = stations.at(&format!("{motion}_{axis}"), "surface");
            let peak = crate::results::peak(&wanted);
            let channel = format!("{sensor}{}", axis.to_uppercase());
            for (form, factor, tolerance) in [("MSEED", 1.0, 1e-12), ("SAC", 1e9, 1e-6)] {
                let trace = &back[format!("{form} {channel}")];
                assert_eq!(trace["n"], wanted.len(), "{form} {channel}");
                assert!((trace["dt"].as_f64().expect("a step") - 0.005).abs() < 1e-8);
                assert_eq!(trace["station"], "SURFA");
                if form == "SAC" {
                    assert_eq!(trace["idep"], idep);
                }
                let data = trace["data"].as_array().expect("samples").iter();
                let found: Vec<f64> = data.map(|v| v.as_f64().expect("a number") / factor).collect();
                let error = crate::results::distance(&found, &wanted);
                assert!(error <= tolerance * peak, "{form} {channel}: {error:e} of {peak:e}");
            }
        }
    }
}
