//! What a scene in two or three dimensions writes back.

use super::super::types::Discretisation;
use super::super::volume::{
    Domain, FieldOutput, Material, SourceEntry, SourceKind, SurfaceOutput, VolumeOutput,
};
use super::super::volume_values::{MaterialValues, Sensor};
use super::Writer;

/// A key that TOML takes: bare, or in quotes.
fn quoted(key: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !key.is_empty() && key.chars().all(bare) {
        return key.to_owned();
    }
    let mut quoted = String::from("\"");
    for c in key.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04X}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

impl Writer<'_> {
    pub(super) fn domain(&mut self, domain: &Domain) {
        self.header("[domain]");
        self.entry("domain", "dimension", &domain.dimension);
        if let Some(mesh) = &domain.mesh {
            self.path("domain", "mesh", mesh);
        }
        for (key, range) in [("x", domain.x), ("y", domain.y)] {
            if let Some(range) = range {
                self.entry("domain", key, &range);
            }
        }
        if domain.mesh.is_none() {
            self.optional("domain", "depth", domain.depth.as_ref(), "the sum of the layers");
            match &domain.topography {
                Some(file) => self.path("domain", "topography", file),
                None => self.line("# topography: flat, z = 0 # default"),
            }
        }
        let section = "domain.boundary";
        self.header(&format!("[{section}]"));
        let given: Vec<&str> = domain.boundary.keys().map(String::as_str).collect();
        let all = if domain.mesh.is_some() { &given } else { Domain::box_boundaries(domain.dimension) };
        for name in all {
            let kind = self.scene.boundary_kind(name);
            if !self.chosen(&format!("{section}.{name}"), &quoted(name)) {
                let who = self.provenance(&format!("{section}.{name}"));
                self.line(&format!("{} = \"{}\" # {who}", quoted(name), kind.as_str()));
            }
        }
        if domain.mesh.is_some() {
            self.other_boundaries(section, &given);
        }
    }

    /// Boundaries of a mesh that the scene leaves at their defaults: only the plan knows their names.
    fn other_boundaries(&mut self, section: &str, given: &[&str]) {
        let resolved = self.resolved;
        for (i, r) in resolved.iter().enumerate() {
            let name = r.key.strip_prefix(section).and_then(|rest| rest.strip_prefix('.'));
            let Some(name) = name.filter(|name| !given.contains(name)) else { continue };
            self.used[i] = true;
            self.line(&format!("{} = {} # default: {}", quoted(name), r.value, super::one_line(&r.why)));
        }
    }

    pub(super) fn materials(&mut self) {
        for (i, material) in self.scene.material.iter().enumerate() {
            self.material(&format!("material[{}]", i + 1), material);
        }
    }

    fn material(&mut self, section: &str, m: &Material) {
        self.header("[[material]]");
        self.entry(section, "name", &m.name);
        self.entry(section, "vs", &m.vs);
        self.speeds(section, m.vp, m.nu);
        self.entry(section, "rho", &m.rho);
        let values = MaterialValues::from(m);
        self.losses(section, m.q, (m.damping_p, m.q_p), (values.damping, values.damping_p));
    }

    pub(super) fn sources(&mut self) {
        for (i, source) in self.scene.source_entries.iter().enumerate() {
            self.source(i + 1, source);
        }
    }

    fn source(&mut self, number: usize, source: &SourceEntry) {
        let section = &format!("source[{number}]");
        self.header("[[source]]");
        match &source.name {
            Some(name) => self.entry(section, "name", name),
            None => self.entry(section, "name", &format!("source {number}")),
        }
        self.entry(section, "kind", source.kind.as_str());
        let vectors = [("position", &source.position), ("centre", &source.centre)];
        for (key, vector) in vectors.into_iter().filter_map(|(key, v)| Some((key, v.as_ref()?))) {
            self.entry(section, key, vector);
        }
        let numbers = [("depth", source.depth), ("sigma", source.sigma)];
        for (key, number) in numbers.into_iter().filter_map(|(key, v)| Some((key, v?))) {
            self.entry(section, key, &number);
        }
        for (key, vector) in [("force", source.force), ("traction", source.traction)] {
            if let Some(vector) = vector {
                self.entry(section, key, &vector);
            }
        }
        if let Some(moment) = source.moment {
            self.entry(section, "moment", &moment);
            self.entry(section, "rate", &source.rate);
        }
        if source.kind == SourceKind::Traction {
            self.entry(section, "boundary", source.boundary.as_deref().unwrap_or("top"));
        }
        self.time_function(section, source);
    }

    fn time_function(&mut self, section: &str, source: &SourceEntry) {
        if let Some(file) = &source.file {
            self.path(section, "file", file);
            self.optional(section, "channel", source.channel.as_ref(), "the only one");
            self.optional(section, "dt", source.dt.as_ref(), "as the file says");
            self.entry(section, "amplitude", &source.amplitude.unwrap_or(1.0));
        }
        let Some(pulse) = &source.wavelet else { return };
        let inner = super::super::document::join(section, "wavelet");
        self.header("[source.wavelet]");
        self.entry(&inner, "kind", pulse.kind.as_str());
        self.entry(&inner, "frequency", &pulse.frequency);
        self.entry(&inner, "amplitude", &pulse.amplitude);
        self.entry(&inner, "time", &pulse.time);
        if let Some(cycles) = pulse.cycles {
            self.entry(&inner, "cycles", &cycles);
        }
    }

    pub(super) fn discretisation_of(&mut self, domain: &Domain, d: &Discretisation) {
        if domain.mesh.is_none() {
            self.entry("discretisation", "element_size", &d.element_size);
        }
        self.entry("discretisation", "points_per_wavelength", &d.points_per_wavelength);
        self.entry("discretisation", "f_max", &d.f_max);
        self.entry("discretisation", "precision", &d.precision);
        self.entry("discretisation", "memory_variables", &d.memory_variables);
    }

    pub(super) fn run_and_output(&mut self) {
        let scene = self.scene;
        if let Some(run) = &scene.run {
            self.header("[run]");
            self.entry("run", "duration", &run.duration);
        }
        let output = &scene.output;
        self.header("[output]");
        self.entry("output", "vtkhdf", &output.vtkhdf);
        for (i, sensor) in scene.sensors().iter().enumerate() {
            self.sensor(i, sensor);
        }
        if let Some(surface) = &output.surface {
            self.surface(surface);
        }
        if let Some(volume) = &output.volume {
            self.volume(volume);
        }
        if let Some(field) = &output.field {
            self.field(field);
        }
        self.header("[output.checkpoint]");
        self.entry("output.checkpoint", "every", &output.checkpoint.unwrap_or_default().every);
    }

    /// A station with its quantities, which `output.quantities` may have given.
    fn sensor(&mut self, index: usize, sensor: &Sensor) {
        let section = format!("output.stations[{}]", index + 1);
        let entry = self.scene.output.stations.iter().flatten().nth(index);
        self.header("[[output.stations]]");
        self.entry(&section, "name", &sensor.name);
        if let Some(entry) = entry {
            self.entry(&section, "position", &entry.position);
            if let Some(depth) = entry.depth {
                self.entry(&section, "depth", &depth);
            }
        }
        let of_all = self.scene.output.quantities.is_some() && entry.is_some_and(|e| e.quantities.is_none());
        let reason = if of_all { "output.quantities" } else { "" };
        self.entry_because(&section, "quantities", &sensor.quantities, reason);
    }

    fn surface(&mut self, surface: &SurfaceOutput) {
        let section = "output.surface";
        self.header("[output.surface]");
        self.entry(section, "boundary", &surface.boundary);
        self.entry(section, "dt", &surface.dt);
        self.entry(section, "quantities", &surface.quantities);
    }

    fn volume(&mut self, volume: &VolumeOutput) {
        let section = "output.volume";
        self.header("[output.volume]");
        self.optional(section, "material", volume.material.as_ref(), "all");
        self.entry(section, "dt", &volume.dt);
        self.entry(section, "quantities", &volume.quantities);
    }

    fn field(&mut self, field: &FieldOutput) {
        let section = "output.field";
        self.header("[output.field]");
        self.entry(section, "spacing", &field.spacing);
        self.entry(section, "dt", &field.dt);
        self.entry(section, "quantities", &field.quantities);
        let dimension = self.scene.dimension();
        for (key, range) in [("x", field.x), ("y", field.y), ("z", field.z)] {
            if key != "y" || dimension == 3 {
                self.optional(section, key, range.as_ref(), "the whole domain");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn keys_are_quoted_where_they_have_to_be() {
        assert_eq!(quoted("x_min"), "x_min");
        assert_eq!(quoted("east side"), "\"east side\"");
        assert_eq!(quoted("a\"\\\t"), "\"a\\\"\\\\\\u0009\"");
        assert_eq!(quoted(""), "\"\"");
    }
}
