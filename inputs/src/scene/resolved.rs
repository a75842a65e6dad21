//! A scene written back with every value and where it came from.

mod volume;

use std::fmt::Write as _;

use serde::Serialize;
use toml::Value;

use crate::motion::{Process, Quantity};

use super::load::Written;
use super::types::{Base, Component, DEFAULT_NU, Layer, Motion, Scene, Synthetic};
use super::wavelet::Wavelet;

/// A value that the program chose, for [`resolved_toml`].
#[derive(Debug, Clone, PartialEq)]
pub struct Resolved {
    /// Key as in messages: `discretisation.order`, `motion.band`, `soil.reference_frequency`.
    pub key: String,
    /// The value, as the scene file would hold it.
    pub value: Value,
    /// Why this value, in a few words.
    pub why: String,
}

/// The scene's text with every key, each with a comment: `# user`, `# user (--set)`, `# default` or `# auto: reason`.
///
/// - `resolved`: values in place of the scene's own. One whose key the scene does not write (for instance a `vp` that
///   follows from a given `nu`) stands as a comment at the end, since the two together would be refused.
/// - returns TOML that loads again as a valid scene. Records' paths are written in full, so that the text may be kept
///   in another folder. A choice without an entry in `resolved` stays `"auto"`.
pub fn resolved_toml(scene: &Scene, resolved: &[Resolved]) -> String {
    let mut w = Writer { scene, resolved, used: vec![false; resolved.len()], out: String::new() };
    w.line(
        "# A scene as it was run, with where each value came from: user, default or auto with its reason.",
    );
    w.entry("", "version", &scene.version);
    w.entry("", "title", &scene.title);
    w.entry("", "accuracy", &scene.accuracy);
    if let Some(domain) = &scene.domain {
        w.domain(domain);
    }
    if let Some(motion) = &scene.motion {
        w.motion(motion);
    }
    w.soil();
    w.materials();
    w.sources();
    w.discretisation();
    match &scene.domain {
        None => w.output(),
        Some(_) => w.run_and_output(),
    }
    w.rest();
    w.out
}

struct Writer<'a> {
    scene: &'a Scene,
    resolved: &'a [Resolved],
    used: Vec<bool>,
    out: String,
}

/// Text on one line, fit for a comment.
fn one_line(text: &str) -> String {
    text.split(char::is_control).collect::<Vec<_>>().join(" ")
}

impl Writer<'_> {
    fn line(&mut self, text: &str) {
        self.out.push_str(text);
        self.out.push('\n');
    }

    fn header(&mut self, header: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.out, "\n{header}");
    }

    /// Who wrote a key: its author, an override, or nobody.
    fn provenance(&self, path: &str) -> &'static str {
        match self.scene.source.written.get(path) {
            Some(Written::File(_)) => "user",
            Some(Written::Override) => "user (--set)",
            None => "default",
        }
    }

    /// One key with the resolved value, if there is one, else with its own.
    fn entry<T: Serialize + ?Sized>(&mut self, section: &str, key: &str, value: &T) {
        self.entry_because(section, key, value, "");
    }

    /// As [`Self::entry`], with a reason for a default or a user's value.
    fn entry_because<T: Serialize + ?Sized>(&mut self, section: &str, key: &str, value: &T, reason: &str) {
        let path = super::document::join(section, key);
        if self.chosen(&path, key) {
            return;
        }
        // Every part of a scene has a TOML form; a value without one would be left out here and fall to its default.
        if let Ok(value) = Value::try_from(value) {
            let who = self.provenance(&path);
            let reason = if reason.is_empty() { String::new() } else { format!(": {}", one_line(reason)) };
            let _ = writeln!(self.out, "{key} = {value} # {who}{reason}");
        }
    }

    /// Writes the resolved value of a key, if there is one.
    fn chosen(&mut self, path: &str, key: &str) -> bool {
        // The last entry of a key counts.
        let Some(i) = self.resolved.iter().rposition(|r| r.key == path) else {
            return false;
        };
        for (used, r) in self.used.iter_mut().zip(self.resolved) {
            *used |= r.key == path;
        }
        let r = &self.resolved[i];
        let _ = writeln!(self.out, "{key} = {} # auto: {}", r.value, one_line(&r.why));
        true
    }

    fn motion(&mut self, m: &Motion) {
        self.header("[motion]");
        self.entry("motion", "kind", &m.kind);
        self.entry("motion", "quantity", &m.quantity);
        self.entry("motion", "band", &m.band);
        if !self.chosen("motion.process", "process") {
            let steps: Vec<String> = m.process.iter().map(Process::to_toml).collect();
            let who = self.provenance("motion.process");
            // Writing to a string cannot fail.
            let _ = writeln!(self.out, "process = [{}] # {who}", steps.join(", "));
        }
        self.entry("motion", "accept_clipped", &m.accept_clipped);
        for (axis, component) in ["x", "y", "z"].into_iter().zip(self.scene.components()) {
            if let Some(component) = component {
                self.component(axis, component, m.quantity);
            }
        }
    }

    fn component(&mut self, axis: &str, component: &Component, quantity: Quantity) {
        let section = format!("motion.{axis}");
        match component {
            Component::Record(record) => {
                self.header(&format!("[{section}]"));
                self.path(&section, "file", &record.file);
                self.optional(&section, "unit", record.unit.as_ref(), "as the file says");
                self.optional(&section, "channel", record.channel.as_ref(), "the only one");
                self.optional(&section, "dt", record.dt.as_ref(), "as the file says");
                let Some(metadata) = &record.metadata else { return };
                self.path(&section, "metadata", metadata);
                self.entry(&section, "response", &record.response.unwrap_or_default());
                let absent = "from the record's length and its Nyquist frequency";
                self.optional(&section, "pre_filter", record.pre_filter.as_ref(), absent);
            }
            Component::Synthetic(Synthetic { wavelet }) => self.wavelet(&section, wavelet, quantity),
        }
    }

    /// A file's path in full, so that the text may be kept in another folder.
    fn path(&mut self, section: &str, key: &str, file: &str) {
        let path = self.scene.path_of(file);
        let full = if file.starts_with("obspy:") { path } else { std::path::absolute(&path).unwrap_or(path) };
        let full = full.display().to_string();
        let reason = if full == file { String::new() } else { format!("{file} in the scene's folder") };
        self.entry_because(section, key, &full, &reason);
    }

    fn wavelet(&mut self, component: &str, w: &Wavelet, quantity: Quantity) {
        let section = super::document::join(component, "wavelet");
        self.header(&format!("[{section}]"));
        self.entry(&section, "kind", &w.kind);
        self.entry(&section, "frequency", &w.frequency);
        self.entry_because(&section, "amplitude", &w.amplitude, quantity.si_unit());
        self.entry(&section, "time", &w.time);
        self.entry(&section, "dt", &w.dt);
        self.entry(&section, "duration", &w.duration);
        if let Some(cycles) = w.cycles {
            self.entry(&section, "cycles", &cycles);
        }
    }

    /// A key without a value that would stand for its absence: a comment where it is absent.
    fn optional<T: Serialize>(&mut self, section: &str, key: &str, value: Option<&T>, absent: &str) {
        match value {
            Some(value) => self.entry(section, key, value),
            None => {
                let path = super::document::join(section, key);
                if !self.chosen(&path, key) {
                    let _ = writeln!(self.out, "# {key}: {absent} # default");
                }
            }
        }
    }

    fn soil(&mut self) {
        let soil = &self.scene.soil;
        self.header("[soil]");
        self.entry("soil", "reference_frequency", &soil.reference_frequency);
        for (i, layer) in soil.layer.iter().enumerate() {
            self.layer(i + 1, layer);
        }
        let Some(base) = &soil.base else { return };
        self.header("[soil.base]");
        match base {
            Base::Rigid => self.entry("soil.base", "kind", "rigid"),
            Base::Elastic { vs, rho, nu, vp } => {
                self.entry("soil.base", "kind", "elastic");
                self.entry("soil.base", "vs", vs);
                self.entry("soil.base", "rho", rho);
                self.speeds("soil.base", *vp, *nu);
            }
        }
    }

    fn layer(&mut self, number: usize, layer: &Layer) {
        let section = format!("soil.layer[{number}]");
        self.header("[[soil.layer]]");
        match &layer.name {
            Some(name) => self.entry(&section, "name", name),
            None => self.entry(&section, "name", &format!("layer {number}")),
        }
        self.entry(&section, "thickness", &layer.thickness);
        self.entry(&section, "vs", &layer.vs);
        self.speeds(&section, layer.vp, layer.nu);
        self.entry(&section, "rho", &layer.rho);
        let values = (layer.damping_s(), layer.damping_p());
        self.losses(&section, layer.q, (layer.damping_p, layer.q_p), values);
    }

    /// Damping as it is given; `values`: the ratios of shear and P waves that follow.
    fn losses(
        &mut self,
        section: &str,
        q: Option<f64>,
        of_p: (Option<f64>, Option<f64>),
        values: (f64, f64),
    ) {
        match q {
            Some(q) => self.entry(section, "q", &q),
            None => self.entry(section, "damping", &values.0),
        }
        match of_p {
            (_, Some(q_p)) => self.entry(section, "q_p", &q_p),
            (Some(damping_p), None) => self.entry(section, "damping_p", &damping_p),
            (None, None) => self.entry_because(section, "damping_p", &values.1, "as for shear waves"),
        }
    }

    fn speeds(&mut self, section: &str, vp: Option<f64>, nu: Option<f64>) {
        match vp {
            Some(vp) => self.entry(section, "vp", &vp),
            None => self.entry(section, "nu", &nu.unwrap_or(DEFAULT_NU)),
        }
    }

    fn discretisation(&mut self) {
        let d = &self.scene.discretisation;
        self.header("[discretisation]");
        self.entry("discretisation", "order", &d.order);
        let domain = self.scene.domain.as_ref();
        if domain.is_none_or(|d| d.mesh.is_none()) {
            self.entry("discretisation", "elements", &d.elements);
        }
        if let Some(domain) = domain {
            self.discretisation_of(domain, d);
        }
        self.entry("discretisation", "dt", &d.dt);
        self.entry("discretisation", "mechanisms", &d.mechanisms);
        if domain.is_none() {
            self.entry("discretisation", "tail", &d.tail);
        }
    }

    fn output(&mut self) {
        self.header("[output]");
        self.entry("output", "field_spacing", &self.scene.output.field_spacing);
        if self.chosen("output.stations", "stations") {
            return;
        }
        for (i, station) in self.scene.stations().iter().enumerate() {
            let section = format!("output.stations[{}]", i + 1);
            self.header("[[output.stations]]");
            self.entry(&section, "name", &station.name);
            self.entry(&section, "depth", &station.depth);
        }
    }

    /// Resolved values that are no keys of this scene.
    fn rest(&mut self) {
        let left: Vec<&Resolved> =
            self.resolved.iter().zip(&self.used).filter_map(|(r, used)| (!used).then_some(r)).collect();
        if left.is_empty() {
            return;
        }
        self.line("\n# What follows from the values above:");
        for r in left {
            let text = one_line(&format!("{} = {} ({})", r.key, r.value, r.why));
            self.line(&format!("# {text}"));
        }
    }
}
