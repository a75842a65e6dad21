//! Text formats read by the plug-ins of `inputs/python/hati_obspy`.
//!
//! The plug-ins recognise and check; what is left here is the unit. Each channel's header has `unit` (a
//! word of [`Unit`], or empty), `unit_stated` (the file's own words for it), `quantity` (what the file
//! calls its samples, or empty) and, where the file's words contradict each other, `unit_problem`.

use super::{Recognition, RecordFormat, Segment, StoredUnit, Unit};

/// The row of a format that only the plug-ins recognise.
pub(super) const fn format(name: &'static str, plug_in: &'static str) -> RecordFormat {
    RecordFormat {
        name,
        obspy: plug_in,
        recognise: |_| Recognition::No,
        stored: "samples",
        unit,
        consistent: |_| Ok(()),
        damage: &[],
    }
}

/// The unit that the file states; it must be one of the quantity that the file names.
pub(super) fn unit(segment: &Segment) -> Result<StoredUnit, String> {
    let text = |key: &str| segment.text(key).unwrap_or_default();
    let (word, stated, quantity) = (text("unit"), text("unit_stated"), text("quantity"));
    let problem = text("unit_problem");
    if word.is_empty() && !problem.is_empty() {
        return Err(problem.into());
    }
    if word.is_empty() && stated.is_empty() {
        return Err("the file states no unit".into());
    }
    let Ok(unit) = word.parse::<Unit>() else {
        return Err(format!("the file says \"{stated}\", which is no unit of a motion that is known here"));
    };
    let measures = unit.quantity().to_string();
    if !quantity.is_empty() && quantity != measures {
        let samples = if quantity == "velocity" { "velocities".into() } else { format!("{quantity}s") };
        return Err(format!("the file calls its samples {samples} and gives {stated}, a unit of {measures}"));
    }
    let text = if stated.is_empty() { word } else { stated };
    Ok(StoredUnit { text: text.into(), ..StoredUnit::of(unit) })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::motion::Quantity;

    fn segment(header: serde_json::Value) -> Segment {
        Segment {
            id: "..A".into(),
            channel: "A".into(),
            dt: 0.01,
            start_ns: 0,
            start_utc: String::new(),
            end_utc: String::new(),
            calib: None,
            header: header.as_object().cloned().unwrap_or_default(),
            samples: vec![0.0, 1.0],
            ground: None,
        }
    }

    #[test]
    fn a_stated_unit_is_taken_with_the_words_of_the_file() {
        let header = json!({"unit": "cm/s2", "unit_stated": "CM/SEC/SEC", "quantity": "acceleration"});
        let found = unit(&segment(header)).unwrap();
        assert_eq!(found.text, "CM/SEC/SEC");
        assert_eq!((found.quantity, found.factor), (Quantity::Acceleration, 0.01));
    }

    #[test]
    fn absent_unknown_and_contradicting_units_are_told_apart() {
        let cases = [
            (json!({"unit": "", "unit_stated": "", "quantity": "acceleration"}), "states no unit"),
            (json!({}), "states no unit"),
            (json!({"unit": "", "unit_stated": "mg"}), "\"mg\", which is no unit"),
            (
                json!({"unit": "", "unit_stated": "g", "unit_problem": "the file states \"g\" and \"gal\""}),
                "states \"g\" and \"gal\"",
            ),
            (
                json!({"unit": "gal", "unit_stated": "gal", "quantity": "velocity"}),
                "calls its samples velocities and gives gal, a unit of acceleration",
            ),
            (
                json!({"unit": "cm/s", "unit_stated": "cm/s", "quantity": "acceleration"}),
                "calls its samples accelerations and gives cm/s, a unit of velocity",
            ),
        ];
        for (header, words) in cases {
            let error = unit(&segment(header)).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
