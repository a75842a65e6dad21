//! The report page, made from the exact response of a layered column in the frequency domain.

#[path = "outputs_report/column.rs"]
mod column;

use std::path::Path;
use std::time::{Duration, Instant};

use hati::report::write_report;
use hati::results::SiteResponse;
use serde_json::{Value, json};

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn page_of(data: &SiteResponse) -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().expect("temporary folder");
    write_report(dir.path(), data).expect("the report is written");
    let html = read(&dir.path().join("report.html"));
    (dir, html)
}

/// Every tag that opens closes, in order; void and self-closed tags aside.
fn assert_balanced(text: &str, what: &str) {
    const VOID: [&str; 4] = ["meta", "br", "!doctype", "input"];
    let mut open: Vec<String> = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let end = rest[start..].find('>').expect("a tag ends") + start;
        let tag = &rest[start + 1..end];
        let name: String = tag
            .trim_start_matches('/')
            .chars()
            .take_while(|c| c.is_ascii_alphanumeric() || *c == '!')
            .collect();
        rest = &rest[end + 1..];
        if name == "script" || name == "style" {
            let close = format!("</{name}>");
            if !tag.starts_with('/') {
                let skip = rest.find(&close).expect("script or style ends");
                rest = &rest[skip + close.len()..];
            }
            continue;
        }
        if let Some(closing) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(closing), "{what}: </{closing}>");
        } else if !tag.ends_with('/') && !VOID.contains(&name.to_lowercase().as_str()) {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{what}: not closed: {open:?}");
}

#[test]
fn page_answers_the_three_doubts_and_shows_every_figure() {
    let (dir, html) = page_of(&column::site_response(&[0], 60.0));
    for text in [
        "Did the record go in right?",
        "scaled by 23.4",
        "Is the boundary quiet?",
        "Is the step stable?",
        "of the critical step",
        "predicted error",
        "closing error",
        "the band ends at 16 Hz",
    ] {
        assert!(html.contains(text), "the page lacks {text:?}");
    }
    assert_balanced(&html, "report.html");
    for name in [
        "acceleration-x",
        "velocity-x",
        "displacement-x",
        "profile-x",
        "response-spectra-x",
        "spectral-ratio-x",
        "transfer-functions-x",
        "depth-time-x",
        "husid-x",
        "fourier-amplitude-x",
        "energy-ledger",
    ] {
        let svg = read(&dir.path().join(format!("figures/{name}.svg")));
        assert!(html.contains(svg.trim_end()), "{name} is not on the page");
        assert_balanced(&svg, name);
        assert!(!svg.contains("NaN") && !svg.contains("inf,"), "{name} has places that are no numbers");
        let csv = read(&dir.path().join(format!("figures/{name}.csv")));
        let mut lines = csv.lines();
        let columns = lines.next().expect("header").split(',').count();
        assert!(columns >= 2, "{name}.csv");
        assert!(lines.clone().count() >= 3, "{name}.csv");
        assert!(lines.all(|l| l.split(',').count() == columns), "{name}.csv is ragged");
    }
}

#[test]
fn page_needs_no_network() {
    let (_dir, html) = page_of(&column::site_response(&[0], 20.0));
    for address in ["http://", "https://"] {
        for (place, _) in html.match_indices(address) {
            let found = &html[place..(place + 26).min(html.len())];
            assert_eq!(found, "http://www.w3.org/2000/svg", "the page names a foreign address");
        }
    }
    for tag in ["<link", "<script src", "@import", "url(http"] {
        assert!(!html.contains(tag), "{tag}");
    }
}

#[test]
fn numbers_beside_the_figures_are_the_runs() {
    let data = column::site_response(&[0], 20.0);
    let (dir, _) = page_of(&data);
    let csv = read(&dir.path().join("figures/acceleration-x.csv"));
    let header: Vec<&str> = csv.lines().next().expect("header").split(',').collect();
    let surface = header.iter().position(|h| *h == "surface_acceleration_m_s2").expect("surface column");
    let column: Vec<f64> = csv
        .lines()
        .skip(1)
        .map(|l| l.split(',').nth(surface).and_then(|v| v.parse().ok()).expect("number"))
        .collect();
    let trace = data.traces.iter().find(|t| t.place == "surface").expect("surface trace");
    assert_eq!(column.len(), trace.acceleration.len());
    let scale = trace.acceleration.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (read, kept) in column.iter().zip(&trace.acceleration) {
        assert!((read - kept).abs() <= 1e-6 * scale);
    }
    let csv = read(&dir.path().join("figures/response-spectra-x.csv"));
    let first: f64 = csv
        .lines()
        .nth(1)
        .and_then(|l| l.split(',').nth(3))
        .and_then(|v| v.parse().ok())
        .expect("PSA of the surface at 0.01 s");
    assert!((first / scale - 1.0).abs() < 0.05, "PSA at 0.01 s tends to the peak: {first} and {scale}");
}

#[test]
fn three_components_have_tabs() {
    let (dir, html) = page_of(&column::site_response(&[0, 1, 2], 20.0));
    assert_eq!(html.matches("role=\"tab\"").count(), 3);
    assert!(dir.path().join("figures/profile-z.svg").is_file());
    assert_balanced(&html, "report.html");
}

#[test]
fn missing_and_broken_values_do_not_stop_the_report() {
    let empty = SiteResponse {
        title: "<script>alert(1)</script>".to_owned(),
        dt: 0.01,
        time_first: 0.0,
        start: None,
        layers: Vec::new(),
        traces: Vec::new(),
        peaks: Vec::new(),
        transfer: Vec::new(),
        sections: Vec::new(),
        ledger: Vec::new(),
        summary: Value::Null,
    };
    let (_dir, html) = page_of(&empty);
    assert!(html.contains('—') && !html.contains("<script>alert"));
    let whole = column::site_response(&[0], 12.0);
    for summary in [
        json!([1, 2]),
        json!({"record": 7, "model": [], "results": {"surface": 3, "x": {"x": null}}, "plan": "text"}),
        json!({"warnings": [{"a": 1}], "record": {"channels": [null, 3], "steps": ["demean", {}]}}),
    ] {
        page_of(&SiteResponse { summary, ..whole.clone() });
    }
    type Break = fn(&mut SiteResponse);
    let breaks: [Break; 12] = [
        |d| d.dt = f64::NAN,
        |d| d.dt = 0.0,
        |d| d.time_first = f64::INFINITY,
        |d| d.traces.iter_mut().for_each(|t| t.acceleration.clear()),
        |d| d.traces.iter_mut().for_each(|t| t.acceleration.truncate(1)),
        |d| d.traces.iter_mut().for_each(|t| t.acceleration.fill(f64::NAN)),
        |d| d.traces.iter_mut().for_each(|t| t.acceleration.fill(0.0)),
        |d| d.layers.iter_mut().for_each(|l| (l.vs, l.top) = (0.0, f64::NAN)),
        |d| d.peaks.iter_mut().for_each(|p| p.depth.truncate(1)),
        |d| d.transfer.iter_mut().for_each(|t| t.causal.truncate(1)),
        |d| d.sections.iter_mut().for_each(|s| s.acceleration.fill(f32::NAN)),
        |d| d.ledger.iter_mut().for_each(|r| r.input = f64::NAN),
    ];
    for (number, damage) in breaks.into_iter().enumerate() {
        let mut data = whole.clone();
        damage(&mut data);
        let (_dir, html) = page_of(&data);
        assert_balanced(&html, &format!("damage {number}"));
    }
}

#[test]
fn unwritable_folder_is_named() {
    let data = column::site_response(&[0], 12.0);
    let error = write_report(Path::new("/proc/no-such-folder"), &data).expect_err("cannot be written");
    assert!(error.to_string().contains("/proc/no-such-folder"), "{error}");
}

/// A page for a person to look at: `HATI_REPORT_LOOK=folder cargo test look -- --ignored`.
#[test]
#[ignore = "writes a page for a person to look at"]
fn look() {
    let dir = std::env::var_os("HATI_REPORT_LOOK")
        .unwrap_or_else(|| concat!(env!("CARGO_TARGET_TMPDIR"), "/report_look").into());
    let dir = Path::new(&dir);
    std::fs::create_dir_all(dir).expect("folder");
    let axes: &[usize] = if std::env::var_os("HATI_REPORT_AXES").is_some() { &[0, 1, 2] } else { &[0] };
    let data = column::site_response(axes, 60.0);
    let mut spent = Duration::MAX;
    for _ in 0..5 {
        let start = Instant::now();
        write_report(dir, &data).expect("report");
        spent = spent.min(start.elapsed());
    }
    let size = std::fs::metadata(dir.join("report.html")).expect("page").len();
    let note = format!("{} ms, page of {} kB\n", spent.as_millis(), size / 1024);
    std::fs::write(dir.join("cost.txt"), note).expect("note");
}
