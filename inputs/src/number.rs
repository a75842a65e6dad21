//! Numbers as a person writes them, for messages.

/// A number as it stands: plain between 1e-4 and 1e7, else with an exponent.
pub(crate) fn plain(x: f64) -> String {
    if x == 0.0 || (1e-4..1e7).contains(&x.abs()) || !x.is_finite() {
        format!("{x}")
    } else {
        format!("{x:e}")
    }
}

/// A derived number with four significant digits, trailing zeros dropped.
pub(crate) fn rounded(x: f64) -> String {
    format!("{x:.3e}").parse::<f64>().map_or_else(|_| x.to_string(), plain)
}

/// A limit or a length with nine significant digits: without the last digits of a quotient in binary.
pub(crate) fn nine(x: f64) -> String {
    format!("{x:.8e}").parse::<f64>().map_or_else(|_| x.to_string(), plain)
}

/// A number in the fewest digits that give it to 5e-7 of itself; seven at most.
pub(crate) fn brief(x: f64) -> String {
    let near = |digits: usize| format!("{x:.digits$e}").parse::<f64>().ok();
    let found = (0..7).filter_map(near).find(|y| (y - x).abs() <= 5e-7 * x.abs());
    plain(found.unwrap_or(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(plain(1200.0), "1200");
        assert_eq!(plain(1e-6), "1e-6");
        assert_eq!(rounded(777.817459), "777.8");
        assert_eq!(rounded(-0.0333333), "-0.03333");
        assert_eq!(nine(999968.8200000001), "999968.82");
        assert_eq!(nine(1e308), "1e308");
        assert_eq!(brief(f64::from(0.6_f32)), "0.6");
        assert_eq!(brief(1.0 / 3.0), "0.3333333");
        assert_eq!(brief(f64::from(1e-5_f32)), "1e-5");
        assert_eq!((brief(0.0), brief(f64::NAN)), ("0".into(), "NaN".into()));
        assert_eq!(nine(-f64::INFINITY), "-inf");
        assert_eq!(nine(f64::NAN), "NaN");
    }
}
