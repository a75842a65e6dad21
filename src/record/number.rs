//! Numbers as people read them.

/// A number with so many digits that count, in plain figures where that is short: `0.04124`, `123.5`, `9.800e-7`.
#[must_use]
pub(crate) fn figures(x: f64, count: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let text = format!("{:.*e}", count - 1, x);
    let exponent: i32 = text.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    if (-4..5).contains(&exponent) {
        let decimals = (count as i32 - 1 - exponent).max(0) as usize;
        return format!("{x:.decimals$}");
    }
    text
}

/// A number as short as it is, free of the noise of its last binary digit, with a power of ten where it is far from 1.
#[must_use]
pub(crate) fn shortest(x: f64) -> String {
    let rounded = format!("{x:.9e}").parse::<f64>().unwrap_or(x);
    if rounded == 0.0 || (1e-6..1e9).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::{figures, shortest};

    #[test]
    fn numbers_stay_short() {
        assert_eq!(figures(0.041_237, 4), "0.04124");
        assert_eq!(figures(9.8e-7, 4), "9.800e-7");
        assert_eq!(figures(123.456, 4), "123.5");
        assert_eq!(figures(2.321, 4), "2.321");
        assert_eq!(shortest(59.999_999_999_999_99), "60");
        assert_eq!(shortest(1e300), "1e300");
        assert_eq!(shortest(0.005), "0.005");
    }
}
