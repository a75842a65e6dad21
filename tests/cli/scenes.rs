//! Texts of scenes, made from their parts.

/// A scene with one pulse along x unless told otherwise; every part can be replaced.
#[derive(Debug, Clone)]
pub(crate) struct SceneText {
    pub(crate) accuracy: f64,
    pub(crate) kind: &'static str,
    pub(crate) quantity: &'static str,
    pub(crate) band: &'static str,
    /// Axis and wavelet.
    pub(crate) motions: Vec<(char, String)>,
    /// Thickness m, vs m/s, vp m/s, density kg/m³, damping.
    pub(crate) layers: Vec<[f64; 5]>,
    /// vs m/s, vp m/s, density kg/m³; `None` is rigid.
    pub(crate) base: Option<[f64; 3]>,
    pub(crate) discretisation: String,
    pub(crate) output: String,
}

impl Default for SceneText {
    fn default() -> Self {
        Self {
            accuracy: 1e-2,
            kind: "outcrop",
            quantity: "acceleration",
            band: "\"auto\"",
            motions: vec![('x', ricker(4.0, 1.0, 0.5, 4.0))],
            layers: vec![[6.0, 150.0, 600.0, 1800.0, 0.02], [9.0, 250.0, 900.0, 1900.0, 0.02]],
            base: Some([800.0, 1400.0, 2200.0]),
            discretisation: String::new(),
            output: String::new(),
        }
    }
}

impl SceneText {
    pub(crate) fn text(&self) -> String {
        let mut text = format!(
            "version = 1\ntitle = \"made for a test\"\naccuracy = {:e}\n\n[motion]\nkind = \"{}\"\nquantity = \"{}\"\nband = {}\n",
            self.accuracy, self.kind, self.quantity, self.band
        );
        for (axis, wavelet) in &self.motions {
            text += &format!("\n[motion.{axis}]\nwavelet = {wavelet}\n");
        }
        for [thickness, vs, vp, rho, damping] in &self.layers {
            text += &format!(
                "\n[[soil.layer]]\nthickness = {thickness:?}\nvs = {vs:?}\nvp = {vp:?}\nrho = {rho:?}\ndamping = {damping:?}\n"
            );
        }
        text += "\n[soil.base]\n";
        text += &match self.base {
            Some([vs, vp, rho]) => format!("kind = \"elastic\"\nvs = {vs:?}\nvp = {vp:?}\nrho = {rho:?}\n"),
            None => "kind = \"rigid\"\n".into(),
        };
        text + &format!("\n[discretisation]\n{}\n\n[output]\n{}\n", self.discretisation, self.output)
    }
}

/// Step of the wavelets below, s.
pub(crate) const DT: f64 = 0.005;

/// A Ricker pulse: frequency Hz, amplitude, time s, duration s.
pub(crate) fn ricker(frequency: f64, amplitude: f64, time: f64, duration: f64) -> String {
    wavelet("ricker", frequency, amplitude, time, duration, "")
}

/// Any wavelet; `more` is appended inside the braces.
pub(crate) fn wavelet(
    kind: &str,
    frequency: f64,
    amplitude: f64,
    time: f64,
    duration: f64,
    more: &str,
) -> String {
    format!(
        "{{ kind = \"{kind}\", frequency = {frequency:?}, amplitude = {amplitude:?}, time = {time:?}, \
         dt = {DT:?}, duration = {duration:?}{more} }}"
    )
}

/// A(1 − 2τ²)exp(−τ²), τ = π f (t − time).
pub(crate) fn ricker_value(frequency: f64, amplitude: f64, time: f64, t: f64) -> f64 {
    let tau = std::f64::consts::PI * frequency * (t - time);
    amplitude * (1.0 - 2.0 * tau * tau) * (-tau * tau).exp()
}

/// A scene that takes about half a minute, with a chunk of results every half second.
pub(crate) fn long() -> SceneText {
    SceneText {
        motions: vec![('x', ricker(4.0, 1.0, 0.5, 200.0))],
        layers: vec![[2000.0, 2000.0, 3600.0, 2000.0, 0.02]],
        base: Some([3000.0, 5200.0, 2200.0]),
        discretisation: "order = 4\nelements = [400]\ndt = 0.00025\nmechanisms = 2\ntail = 1.0".into(),
        output: "field_spacing = 100.0".into(),
        ..SceneText::default()
    }
}
