//! Seconds since 1970 as an ISO 8601 instant.

/// `YYYY-MM-DDThh:mm:ss.ffffffZ` of seconds since 1970-01-01T00:00:00Z, proleptic Gregorian, no leap seconds.
pub fn iso8601(unix_seconds: f64) -> String {
    let micros = (unix_seconds * 1e6).round() as i64;
    let (days, rest) = (micros.div_euclid(86_400_000_000), micros.rem_euclid(86_400_000_000));
    let (year, month, day) = civil(days);
    let (seconds, fraction) = (rest / 1_000_000, rest % 1_000_000);
    let (h, m, s) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    format!("{year:04}-{month:02}-{day:02}T{h:02}:{m:02}:{s:02}.{fraction:06}Z")
}

/// Date of a day counted from 1970-01-01; years start in March inside, so that leap days come last.
fn civil(days: i64) -> (i64, i64, i64) {
    let shifted = days + 719_468;
    let era = shifted.div_euclid(146_097);
    let day_of_era = shifted.rem_euclid(146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let march_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 { march_month + 3 } else { march_month - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    (year, month, day)
}

/// Seconds since 1970-01-01T00:00:00Z of `YYYY-MM-DDThh:mm:ss[.f…][Z]`; `None` for any other text.
///
/// A text without a zone counts as UTC.
pub fn unix_seconds(iso: &str) -> Option<f64> {
    let (date, time) = iso.trim().trim_end_matches('Z').split_once(['T', ' '])?;
    let numbers =
        |text: &str, mark: char| text.split(mark).map(|n| n.parse().ok()).collect::<Option<Vec<f64>>>();
    let [year, month, day] = numbers(date, '-')?.try_into().ok()?;
    let [h, m, s] = numbers(time, ':')?.try_into().ok()?;
    let wanted = (year as i64, month as i64, day as i64);
    // The calendar is known one way only: a guess a few days off, then the day that has this date.
    let guess = ((year - 1970.0) * 365.2425 + (month - 1.0) * 30.44 + day) as i64;
    let found = (guess - 8..=guess + 8).find(|&number| civil(number) == wanted)?;
    let sound = (0.0..24.0).contains(&h) && (0.0..60.0).contains(&m) && (0.0..61.0).contains(&s);
    sound.then_some(found as f64 * 86_400.0 + h * 3600.0 + m * 60.0 + s)
}

#[cfg(test)]
mod tests {
    use super::{iso8601, unix_seconds};

    #[test]
    fn instants_come_back() {
        for seconds in [0.0, 839_646_720.25, 951_782_400.0, -1.5, 4_107_542_399.0, -2_208_988_800.0] {
            assert_eq!(unix_seconds(&iso8601(seconds)), Some(seconds));
        }
        for day in -40_000..60_000 {
            let seconds = f64::from(day) * 86_400.0;
            assert_eq!(unix_seconds(&iso8601(seconds)), Some(seconds));
        }
        for wrong in ["", "unknown", "2024-02-30T00:00:00Z", "2024-01-01T25:00:00Z", "2024-01-01"] {
            assert_eq!(unix_seconds(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn known_instants() {
        assert_eq!(iso8601(0.0), "1970-01-01T00:00:00.000000Z");
        assert_eq!(iso8601(839_646_720.25), "1996-08-10T03:12:00.250000Z");
        assert_eq!(iso8601(951_782_400.0), "2000-02-29T00:00:00.000000Z");
        assert_eq!(iso8601(-1.5), "1969-12-31T23:59:58.500000Z");
    }
}
