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
        assert_eq!(nine(-f64::INFINITY), "-inf");
        assert_eq!(nine(f64::NAN), "NaN");
    }
}
