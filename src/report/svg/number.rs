//! Numbers as text.

/// `value` with `digits` significant digits, without trailing zeros; a power of ten below 1e-3 and from 1e5 on.
///
/// Values that are not numbers become `—`.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "—".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = rounded_exponent(value, digits);
    if !(-3..5).contains(&exponent) {
        let text = format!("{:.*e}", digits.saturating_sub(1), value);
        let (mantissa, _) = text.split_once('e').unwrap_or((&text, ""));
        return format!("{} × 10{}", minus(&trimmed(mantissa)), superscript(exponent));
    }
    let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
    minus(&trimmed(&format!("{value:.decimals$}")))
}

/// Decimal exponent after rounding to `digits` digits.
fn rounded_exponent(value: f64, digits: usize) -> i32 {
    let text = format!("{:.*e}", digits.saturating_sub(1), value);
    text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// Number of a tick, with as many decimals as its step asks for.
pub(super) fn tick(value: f64, step: f64) -> String {
    let size = value.abs().max(step);
    if !(1e-4..1e6).contains(&size) {
        return significant(value, 3);
    }
    let decimals = (0..6)
        .find(|&d| {
            let scaled = step * 10_f64.powi(d);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        })
        .unwrap_or(6) as usize;
    let shown = if value.abs() < step * 1e-6 { 0.0 } else { value };
    minus(&format!("{shown:.decimals$}"))
}

/// Number of a tick on a logarithmic axis.
pub(super) fn log_tick(value: f64) -> String {
    if (1e-3..1e5).contains(&value) {
        return significant(value, 1);
    }
    let exponent = value.log10().floor();
    let lead = (value / 10_f64.powf(exponent)).round();
    if lead > 1.0 {
        format!("{lead}·10{}", superscript(exponent as i32))
    } else {
        format!("10{}", superscript(exponent as i32))
    }
}

fn superscript(value: i32) -> String {
    value
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '0' => '⁰',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            _ => '⁹',
        })
        .collect()
}

fn trimmed(text: &str) -> String {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text.to_owned()
    }
}

fn minus(text: &str) -> String {
    text.replace('-', "−")
}

/// Text that stands safely inside HTML and SVG, in content and in attributes.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // XML 1.0 forbids control characters.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits() {
        assert_eq!(significant(0.123_456, 3), "0.123");
        assert_eq!(significant(23.4, 3), "23.4");
        assert_eq!(significant(1234.6, 3), "1235");
        assert_eq!(significant(-0.5, 3), "−0.5");
        assert_eq!(significant(3.2e-12, 2), "3.2 × 10⁻¹²");
        assert_eq!(significant(999.96, 3), "1000");
        assert_eq!(significant(f64::NAN, 3), "—");
        assert_eq!(significant(0.0, 3), "0");
    }

    #[test]
    fn ticks() {
        assert_eq!(tick(0.5, 0.25), "0.50");
        assert_eq!(tick(-1e-17, 0.1), "0.0");
        assert_eq!(log_tick(0.01), "0.01");
        assert_eq!(log_tick(1e-6), "10⁻⁶");
        assert_eq!(log_tick(2e5), "2·10⁵");
    }

    #[test]
    fn markup_is_escaped() {
        assert_eq!(escape("<a & \"b\">\u{1}"), "&lt;a &amp; &quot;b&quot;&gt; ");
    }
}
