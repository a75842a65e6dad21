//! A step's record repeats it; a step's text is read as it is written.

use hati_inputs::InputError;
use hati_inputs::measures::{DesignSpectrum, Direction, Rg160};
use hati_inputs::motion::{Filter, Matching, Motion, Process, Quantity, Scaling, Step};
use proptest::prelude::*;

use super::{burst, noise};

/// Any step that a motion of 400 samples at 0.01 s with both horizontals can go through at any place of a list.
fn any_process() -> impl Strategy<Value = Process> {
    let corner = || prop::option::of(0.05..4.0_f64);
    prop_oneof![
        prop::option::of(0.01..1.0_f64).prop_map(|first_seconds| Process::Demean { first_seconds }),
        (1_usize..=5).prop_map(|order| Process::Detrend { order }),
        (1_usize..=5).prop_map(|order| Process::Baseline { order }),
        (0.0..0.4_f64, 0.0..0.4_f64).prop_map(|(start, end)| Process::Taper { start, end }),
        (corner(), 5.0..12.0_f64, 1_usize..=10, any::<bool>(), any::<bool>()).prop_map(
            |(f_min, f_max, order, causal, keep_pads)| {
                Process::Filter(Filter { f_min, f_max: Some(f_max), order, causal, keep_pads })
            }
        ),
        (-720.0..720.0_f64).prop_map(|angle| Process::Rotate { angle }),
        (0.0..0.3_f64, prop::option::of(1.5..2.0_f64)).prop_map(|(from, to)| Process::Trim { from, to }),
        (0.0..1.0_f64, 0.0..1.0_f64).prop_map(|(before, after)| Process::Pad { before, after }),
        (1_u32..40, 10_u32..20)
            .prop_map(|(p, q)| Process::Resample { dt: 0.01 * f64::from(p.min(q)) / f64::from(q) }),
        prop_oneof![
            (0.001..100.0_f64).prop_map(Scaling::Factor),
            (0.001..100.0_f64).prop_map(Scaling::Pga),
            (0.001..100.0_f64).prop_map(Scaling::Pgv),
            (0.001..100.0_f64, 0.05..5.0_f64, 0.0..0.9_f64).prop_map(|(sa, period, damping)| Scaling::Sa {
                sa,
                period,
                damping
            }),
        ]
        .prop_map(Process::Scale),
        Just(Process::Rest {}),
        Just(Process::Convert { to: Quantity::Acceleration }),
    ]
}

fn any_match() -> impl Strategy<Value = Process> {
    (0.1..20.0_f64, prop_oneof![Just(None), Just(Some(Direction::Vertical))], 0.1..0.3_f64).prop_map(
        |(pga, direction, tolerance)| {
            let spectrum = DesignSpectrum::Rg160(Rg160 { pga, damping: 0.05, direction });
            Process::Match(Matching { tolerance, ..Matching::to(spectrum) })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// The steps, through the text of a header, do the same again to the last bit.
    #[test]
    fn steps_repeat_themselves_bit_for_bit(list in prop::collection::vec(any_process(), 1..5), seed in 1_u64..1000) {
        let components = [Some(noise(400, seed)), Some(noise(400, seed + 1)), None];
        let original = Motion::new(0.01, Some(5.0), Quantity::Acceleration, components).unwrap();
        let mut first = original.clone();
        for process in &list {
            // A step that the motion cannot take here leaves no trace.
            let _ = process.apply(&mut first);
        }
        let header = serde_json::to_string(&first.steps).unwrap();
        let steps: Vec<Step> = serde_json::from_str(&header).unwrap();
        let mut second = original;
        for step in &steps {
            Process::from_step(step).expect("a step of processing").apply(&mut second).unwrap();
        }
        prop_assert_eq!(first, second);
    }

    /// Whatever the text, the answer is a step or a refusal; what is read is printed as the same step.
    #[test]
    fn texts_never_panic(text in "(filter|scale|trim|match)?( [a-z_.]{0,6}=?[-0-9a-z.,\\[{\\]}\"']{0,8}){0,4}") {
        if let Ok(process) = Process::parse(&text) {
            prop_assert_eq!(Process::parse(&process.to_string()).unwrap(), process);
        }
    }

    /// A step as text and as a scene's table is the same step.
    #[test]
    fn steps_are_read_as_they_are_written(process in prop_oneof![8 => any_process(), 1 => any_match()]) {
        prop_assert_eq!(&Process::parse(&process.to_string()).unwrap(), &process);
        let table: toml::Table = format!("process = {}", process.to_toml()).parse().unwrap();
        prop_assert_eq!(&table["process"].clone().try_into::<Process>().unwrap(), &process);
    }
}

#[test]
fn steps_of_reading_are_no_processes() {
    for name in ["record", "band", "zero padding", "unit", ""] {
        assert_eq!(Process::from_step(&Step::new(name, serde_json::json!({ "f_min_hz": 1.0 }))), None);
    }
    let more = serde_json::json!({ "order": 1, "window": "x" });
    assert_eq!(
        Process::from_step(&Step::new("detrend", more)),
        None,
        "an unknown parameter is not passed over"
    );
    for word in Process::WORDS {
        let text = match word {
            "detrend" | "baseline" => format!("{word} order=1"),
            "filter" => "filter f_min=1".to_owned(),
            "rotate" => "rotate angle=1".to_owned(),
            "resample" => "resample dt=0.1".to_owned(),
            "scale" => "scale factor=2".to_owned(),
            "taper" => "taper start=1".to_owned(),
            "trim" => "trim from=1".to_owned(),
            "pad" => "pad after=1".to_owned(),
            "convert" => "convert to=velocity".to_owned(),
            "match" => "match spectrum={kind=\"rg160\", pga=2}".to_owned(),
            word => word.to_owned(),
        };
        assert_eq!(Process::parse(&text).unwrap_or_else(|e| panic!("{e}")).word(), word);
    }
}

#[test]
fn a_step_of_the_command_line_says_what_is_wrong() {
    let filter = Filter { f_min: Some(0.1), f_max: Some(25.0), causal: true, ..Filter::default() };
    assert_eq!(
        Process::parse(" filter  f_min=0.1, f_max = 25 causal=true").unwrap(),
        Process::Filter(filter)
    );
    for (text, parts) in [
        ("", &["\"\": expected a step", "demean, detrend"][..]),
        ("filtre f_min=0.1", &["expected \"demean\"", "did you mean \"filter\"?"]),
        ("filter f_mn=0.1", &["f_mn: unknown key", "did you mean `f_min`?"]),
        ("filter", &["expected `f_min`, `f_max` or both"]),
        (
            "filter f_min=2 f_max=1 order=99",
            &["f_max: 1 Hz is not above f_min = 2 Hz", "order: expected a whole number from 1 to 10"],
        ),
        ("filter f_min", &["f_min", "key=value"]),
        ("filter f_min=0.1 f_min=0.2", &["f_min", "given twice"]),
        ("filter f_min=fast", &["f_min: expected a number above 0 Hz", "\"fast\""]),
        ("scale pga=1 factor=2", &["give one of"]),
        ("scale sa=1", &["period", "missing"]),
        ("scale pga=1 period=2", &["period", "belongs to `sa`"]),
        ("demean seconds=1", &["seconds: unknown key"]),
        ("trim from=3 to=2", &["to: 2 s is not above from = 3 s"]),
        (
            "match spectrum.kind=rg161 spectrum.pga=2",
            &["spectrum.kind: expected \"rg160\"", "did you mean \"rg160\"?"],
        ),
        ("match spectrum.kind=rg160 spectrum.pga=-2", &["spectrum.pga: ", "above 0 m/s², found -2 m/s²"]),
        ("match spectrum.kind=rg160", &["spectrum.pga: missing", "help: give the peak", "in m/s²"]),
        ("match tolerance=0.1", &["spectrum: missing", "kind = \"rg160\""]),
        ("convert to=speed", &["\"velocity\"", "\"speed\""]),
    ] {
        let error = Process::parse(text).unwrap_err();
        assert!(matches!(error, InputError::ProcessText { .. }), "{error}");
        let mistakes = error.to_string();
        let mistakes = mistakes.lines().collect::<Vec<_>>();
        assert!(mistakes.len().is_multiple_of(2), "each mistake has its help: {error}");
        assert!(mistakes.chunks(2).all(|pair| pair[1].starts_with("  help: ")), "{error}");
        for part in parts {
            assert!(error.to_string().contains(part), "{part:?} is not in {error}");
        }
    }
}

#[test]
fn warnings_are_those_that_must_not_be_missed() {
    let x = burst(3.0, 1000, 0.01);
    let warning = |lifted: f64, process: Process| {
        let z = x.iter().map(|x| x + lifted).collect();
        let mut motion = Motion::new(0.01, None, Quantity::Acceleration, [None, None, Some(z)]).unwrap();
        process.apply(&mut motion).unwrap();
        motion.steps[0].warning()
    };
    let demean = || Process::Demean { first_seconds: None };
    assert_eq!(warning(0.5, demean()), None);
    assert!(warning(-9.8, demean()).unwrap().contains("carried gravity (−1 g)"));
    assert_eq!(warning(0.0, Process::Scale(Scaling::Factor(-9.0))), None);
    assert!(
        warning(0.0, Process::Scale(Scaling::Factor(-11.0))).unwrap().contains("scaled by -11.0000: a weak")
    );
    assert!(
        warning(0.0, Process::Scale(Scaling::Factor(0.05))).unwrap().contains("a strong record made weak")
    );
    assert_eq!(warning(0.0, Process::Rest {}), None);
    assert!(
        warning(0.5, Process::Rest {}).unwrap().contains("component z: bringing the ground to rest took")
    );
    let high_pass = || Process::Filter(Filter { f_min: Some(0.5), ..Filter::default() });
    assert_eq!(warning(0.0, high_pass()), None);
    assert!(warning(0.5, high_pass()).unwrap().contains("fell outside the record's time"));
}
