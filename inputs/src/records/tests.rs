use super::checks::clipped;
use super::formats::{Recognition, refused};
use super::naming::{axis_by_name, instrument};
use super::*;
use proptest::prelude::*;

fn name_of(content: &[u8]) -> Option<&'static str> {
    recognise(Path::new("x"), content).ok().flatten().map(|format| format.name)
}

/// A SAC header of `npts` samples with zeros behind it.
fn sac(npts: i32, little: bool) -> Vec<u8> {
    let mut bytes = vec![0_u8; 632 + 4 * npts as usize];
    let put = |bytes: &mut Vec<u8>, word: usize, value: [u8; 4]| {
        bytes[4 * word..4 * word + 4].copy_from_slice(&value);
    };
    let int = |value: i32| if little { value.to_le_bytes() } else { value.to_be_bytes() };
    let delta = if little { 0.01_f32.to_le_bytes() } else { 0.01_f32.to_be_bytes() };
    put(&mut bytes, 0, delta);
    for (word, value) in [(76, 6), (79, npts), (85, 1), (105, 1), (106, 0), (107, -12345)] {
        put(&mut bytes, word, int(value));
    }
    bytes
}

fn mseed_head() -> Vec<u8> {
    let mut head = b"000001D HATI 00HNEXX".to_vec();
    head.extend(2020_u16.to_be_bytes());
    head.extend(34_u16.to_be_bytes());
    head.extend([4, 5, 6, 0]);
    head.resize(512, 0);
    head
}

#[test]
fn formats_are_told_by_content() {
    assert_eq!(name_of(&sac(100, true)), Some("SAC"));
    assert_eq!(name_of(&sac(100, false)), Some("SAC"));
    assert_eq!(name_of(&mseed_head()), Some("miniSEED"));
    assert_eq!(name_of(b"Origin Time 2020\nMemo.\n 1 2"), Some("K-NET"));
    assert_eq!(
        name_of(b"XW01\n\nWID1  1998228 02 09 00 000        6\nDAT1\n  1 2 3 4 5 6\nCHK1 21\n"),
        Some("GSE1")
    );
    let gse2 = |data: &str| {
        format!("WID2 2005/08/31 02:33:49.850 RJOB    Z RJOB CM6        3\nDAT2\n{data}\nCHK2 1\n")
    };
    assert_eq!(name_of(gse2("0Z10").as_bytes()), Some("GSE2"));
    for other in [&b"text"[..], b"Origin Tim", b"WID2", b"000001D", b"\0\0\0\0"] {
        assert_eq!(name_of(other), None, "{}", other.escape_ascii());
    }
    assert!(refused(b"\x80\x04\x95").is_some());
    assert!(refused(&sac(3, true)).is_none());
}

#[test]
fn headers_that_contradict_the_file_are_broken_not_unknown() {
    let problem = |content: &[u8]| match recognise(Path::new("x"), content) {
        Err(InputError::RecordBroken { problem, .. }) => problem,
        Err(other) => panic!("{other}"),
        Ok(format) => panic!("taken as {:?}", format.map(|format| format.name)),
    };
    for little in [true, false] {
        let mut longer = sac(100, little);
        longer.push(0);
        assert!(problem(&longer).contains("NPTS = 100 needs 1032 bytes, the file has 1033"));
        let mut negative = sac(100, little);
        negative[4 * 79..4 * 80].copy_from_slice(&[0xff; 4]);
        assert!(problem(&negative).contains("NPTS = -1"));
    }
    let mut undated = mseed_head();
    undated[24] = 77;
    assert!(problem(&undated).contains("start time"));
}

/// Each row names another reader of ObsPy, and none the one that runs code.
#[test]
fn the_format_table_has_no_pickle_and_no_doubles() {
    let mut words: Vec<&str> = FORMATS.iter().map(|format| format.obspy).collect();
    assert!(!words.contains(&"PICKLE"));
    words.sort_unstable();
    words.dedup();
    assert_eq!(words.len(), FORMATS.len());
    let random: Vec<u8> = (0..2000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let taken = |format: &RecordFormat| matches!((format.recognise)(&random), Recognition::Yes);
    assert!(!FORMATS.iter().any(taken));
}

#[test]
fn clipping_is_told_from_the_coarse_top_of_a_slow_wave() {
    let sine = |amplitude: f64, per_period: f64, n: usize| -> Vec<f64> {
        (0..n).map(|i| (amplitude * (std::f64::consts::TAU * i as f64 / per_period).sin()).round()).collect()
    };
    // Weak, slow and coarse: runs of up to hundreds of samples at the extremes.
    for amplitude in [1.0, 2.0, 5.0, 30.0, 1000.0, 1e5] {
        for per_period in [50.0, 400.0, 3000.0, 20000.0] {
            assert_eq!(clipped(&sine(amplitude, per_period, 6000)), None, "{amplitude} {per_period}");
        }
    }
    let limited: Vec<f64> = sine(1e5, 200.0, 6000).iter().map(|x| x.clamp(-8e4, 8e4)).collect();
    let (begin, run) = clipped(&limited).expect("clipped at 80 %");
    assert_eq!(begin, (0..).find(|i| limited[*i] == 8e4).unwrap());
    assert!((35..50).contains(&run), "{run}");
    // Fast peaks are cut in short runs; together they tell.
    let fast: Vec<f64> = (0..6000)
        .map(|i| (1e5 * (i as f64 * 0.31).sin() * (i as f64 * 0.0113).sin()).round().clamp(-7e4, 7e4))
        .collect();
    let (_, run) = clipped(&fast).expect("clipped in short runs");
    assert!((3..10).contains(&run), "{run}");
    // A sine in step with the sampling has its largest value twice per period, exactly.
    for per_period in [4.0, 6.0, 8.0, 12.0, 30.0, 62.0] {
        assert_eq!(clipped(&sine(5e4, per_period, 6000)), None, "{per_period}");
        assert_eq!(clipped(&sine(20.0, per_period, 6000)), None, "{per_period}");
    }
    // One side only.
    let one_sided: Vec<f64> = sine(1e5, 200.0, 6000).iter().map(|x| x.min(7e4)).collect();
    assert!(clipped(&one_sided).is_some());
    // Zeros before and between one-sided pulses are no limit.
    let pulses: Vec<f64> =
        (0..3000).map(|i| if i % 1000 < 100 { (i as f64 * 0.0314).sin().abs() } else { 0.0 }).collect();
    assert_eq!(clipped(&pulses), None);
}

/// What ObsPy's unpacker would follow beyond its memory.
#[test]
fn packed_data_must_fit_their_header() {
    let problem = |data: &str| {
        let text = format!("WID2 2005/08/31 02:33:49.850 RJOB    Z RJOB CM6        3\n{data}");
        match recognise(Path::new("x"), text.as_bytes()) {
            Err(InputError::RecordBroken { problem, .. }) => problem,
            other => panic!("{:?}", other.map(|format| format.map(|format| format.name))),
        }
    };
    assert!(problem("DAT2\n000\n").contains("no line CHK2 at their end"));
    assert!(problem("000\nCHK2 1\n").contains("no line DAT2 follows"));
    assert!(problem("DAT2\n00\nCHK2 1\n").contains("3 samples are announced, 2 are there"));
    assert!(problem("DAT2\n0000\nCHK2 1\n").contains("3 samples are announced, 4 are there"));
    assert!(problem("DAT2\n0?0\nCHK2 1\n").contains("line 3: \"?\" is no character"));
    let long = format!("DAT2\n{}\nCHK2 1\n", "U".repeat(81));
    assert!(problem(&long).contains("line 3: 81 characters of packed data"));
}

/// Reference times and places that ObsPy would count its way to.
#[test]
fn sac_headers_out_of_this_world_are_broken() {
    let with = |word: usize, value: [u8; 4]| {
        let mut bytes = sac(10, true);
        bytes[4 * word..4 * word + 4].copy_from_slice(&value);
        match recognise(Path::new("x"), &bytes) {
            Err(InputError::RecordBroken { problem, .. }) => problem,
            other => panic!("{:?}", other.map(|format| format.map(|format| format.name))),
        }
    };
    assert!(with(32, 1e30_f32.to_le_bytes()).starts_with("STLO = 1"));
    assert!(with(35, f32::NAN.to_le_bytes()).starts_with("EVLA = NaN"));
    assert!(with(70, 99_999_i32.to_le_bytes()).starts_with("NZYEAR = 99999"));
    assert!(with(71, (-3_i32).to_le_bytes()).starts_with("NZJDAY = -3"));
}

#[test]
fn axes_and_instruments_by_name() {
    let cases = [("EW", 0), ("EW2", 0), ("HNE", 0), ("x", 0), ("NS1", 1), ("BNN", 1), ("UD", 2), ("HHZ", 2)];
    for (name, axis) in cases {
        assert_eq!(axis_by_name(name), Some(axis), "{name}");
    }
    assert_eq!(axis_by_name("HN1"), None);
    assert_eq!(axis_by_name(""), None);
    assert_eq!(instrument("HNZ"), Some("an accelerometer"));
    assert_eq!(instrument("BHE"), Some("a velocity seismometer"));
    assert_eq!(instrument("EW2"), None);
}

#[test]
fn every_unit_has_one_word_that_reads_back() {
    for unit in Unit::ALL {
        assert_eq!(unit.symbol().parse::<Unit>().unwrap(), unit);
        let json = serde_json::to_string(&unit).unwrap();
        assert_eq!(json, format!("\"{}\"", unit.symbol()));
        assert_eq!(serde_json::from_str::<Unit>(&json).unwrap(), unit);
    }
    assert_eq!("cm/s^2".parse::<Unit>().unwrap(), Unit::CentimetrePerSecond2);
    assert_eq!("m/s²".parse::<Unit>().unwrap(), Unit::MetrePerSecond2);
    assert!("furlong".parse::<Unit>().unwrap_err().to_string().contains("m/s2, cm/s2"));
    assert_eq!(Unit::G.factor(), 9.80665);
    assert_eq!(Unit::TenthG.factor(), 0.980665);
    assert_eq!(Unit::Gal.factor(), Unit::CentimetrePerSecond2.factor());
}

proptest! {
    /// Whatever the bytes, and whichever of them are spoiled: an answer, never a panic.
    #[test]
    fn damaged_headers_are_judged_without_a_panic(
        which in 0_usize..5, length in 0_usize..700,
        changes in prop::collection::vec((0_usize..700, any::<u8>()), 0..12),
    ) {
        let text = b"WID2 2005/08/31 02:33:49.850 RJOB    Z RJOB CM6       12  200.000000\nDAT2\n".to_vec();
        let mut bytes = match which {
            0 => sac(10, true),
            1 => sac(10, false),
            2 => mseed_head(),
            3 => text,
            _ => b"Origin Time       2020/01/02 03:04:00\nMemo.\n  1  2".to_vec(),
        };
        for (at, value) in changes {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = value;
            }
        }
        bytes.truncate(length);
        match recognise(Path::new("x"), &bytes) {
            Ok(Some(format)) => prop_assert!(!bytes.is_empty() && formats::known().contains(format.name)),
            Ok(None) => prop_assert!(formats::is_text(&bytes)),
            Err(error) => prop_assert!(error.to_string().starts_with("x: ")),
        }
    }
}
