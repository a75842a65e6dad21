//! Motions written as miniSEED and SAC come back as they were.

mod python;

use hati_inputs::motion::Quantity;
use hati_inputs::records::{FileFormat, ReadOptions, Trace, Unit, encode, read};

fn samples() -> Vec<f64> {
    (0..1234).map(|i| 0.7 * (0.3 * f64::from(i)).sin() * (-1e-5 * f64::from(i * i)).exp()).collect()
}

fn trace<'a>(channel: &str, quantity: Quantity, samples: &'a [f64]) -> Trace<'a> {
    let id = ["XX".into(), "HA-TI far too long".into(), String::new(), channel.into()];
    Trace { id, start: Some(1_580_702_706.25), dt: 0.005, quantity, samples }
}

fn saved(name: &str, content: &[u8]) -> std::path::PathBuf {
    let path =
        std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{name}", std::process::id()));
    std::fs::write(&path, content).unwrap();
    path
}

#[test]
fn miniseed_keeps_every_bit_and_asks_for_its_unit() {
    if !python::has_obspy() {
        return;
    }
    let (x, y) = (samples(), samples().iter().map(|value| -0.5 * value).collect::<Vec<_>>());
    let traces = [trace("HNE", Quantity::Acceleration, &x), trace("HNN", Quantity::Acceleration, &y)];
    let options = ReadOptions::default();
    let files = encode(FileFormat::MiniSeed, &traces, &options).unwrap();
    assert_eq!(files.len(), 1);
    let path = saved("both.mseed", &files[0]);
    let refusal = read(&path, &options).unwrap_err().to_string();
    assert!(refusal.contains("no unit"), "{refusal}");
    let unit = Some(Unit::MetrePerSecond2);
    let found = read(&path, &ReadOptions { unit, ..options }).unwrap();
    for (channel, (id, samples)) in found.iter().zip([("XX.HATIf..HNE", &x), ("XX.HATIf..HNN", &y)]) {
        assert_eq!((channel.id.as_str(), channel.dt, channel.start), (id, 0.005, Some(1_580_702_706.25)));
        assert_eq!(&channel.samples, samples);
    }
}

#[test]
fn sac_stores_nanometres_under_the_code_that_says_so() {
    if !python::has_obspy() {
        return;
    }
    let x = samples();
    // Quantity, IDEP: displacement 6, velocity 7, acceleration 8.
    for (quantity, idep) in
        [(Quantity::Displacement, 6), (Quantity::Velocity, 7), (Quantity::Acceleration, 8)]
    {
        let files = encode(FileFormat::Sac, &[trace("HNE", quantity, &x)], &ReadOptions::default()).unwrap();
        let word = |at: usize| i32::from_le_bytes(files[0][4 * at..4 * at + 4].try_into().unwrap());
        assert_eq!((word(86), word(79)), (idep, 1234));
        let first = f32::from_le_bytes(files[0][632 + 40..632 + 44].try_into().unwrap());
        assert!((f64::from(first) / (x[10] * 1e9) - 1.0).abs() < 1e-7, "{first}");
        // Read back by the header alone.
        let path = saved("one.sac", &files[0]);
        let found = read(&path, &ReadOptions::default()).unwrap().remove(0);
        assert_eq!((found.quantity, found.dt, found.samples.len()), (quantity, 0.005, 1234));
        for (value, expected) in found.samples.iter().zip(&x) {
            assert!((value - expected).abs() <= 1e-7 * 0.7, "{value} {expected}");
        }
    }
}

#[test]
fn a_motion_without_a_start_is_written_from_the_epoch() {
    if !python::has_obspy() {
        return;
    }
    let x = samples();
    for format in [FileFormat::MiniSeed, FileFormat::Sac] {
        let unknown = Trace { start: None, ..trace("EW", Quantity::Acceleration, &x) };
        let files = encode(format, &[unknown], &ReadOptions::default()).unwrap();
        let path = saved("unknown", &files[0]);
        let unit = (format == FileFormat::MiniSeed).then_some(Unit::MetrePerSecond2);
        let found = read(&path, &ReadOptions { unit, ..ReadOptions::default() }).unwrap();
        assert_eq!(found[0].start, None);
    }
}
