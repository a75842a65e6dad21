//! Motions at stations as CSV, miniSEED and SAC.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use hati_inputs::motion::Quantity;
use hati_inputs::records::{FileFormat, ReadOptions, Trace, encode};

use super::{ExportError, Format, Wanted};
use crate::calendar;
use crate::results::AXES;

/// The motions in a station's files, with the names of their variables and units.
const MOTIONS: [(Quantity, &str, &str); 3] = [
    (Quantity::Acceleration, "acceleration", "m_s2"),
    (Quantity::Velocity, "velocity", "m_s"),
    (Quantity::Displacement, "displacement", "m"),
];

/// One motion of a place.
struct Series {
    /// Counts in [`MOTIONS`].
    motion: usize,
    axis: usize,
    samples: Vec<f64>,
}

/// A place with its motions.
struct Place {
    name: String,
    series: Vec<Series>,
    /// Components of strain and stress: their columns and values. Neither miniSEED nor SAC has a place for them.
    tensors: Vec<(String, Vec<f64>)>,
}

/// Content of `stations.nc`.
pub(super) struct Stations {
    path: PathBuf,
    /// Start of the elapsed time, s since 1970.
    start: Option<f64>,
    time: Vec<f64>,
    places: Vec<Place>,
}

/// A file before it is written: name, format, what it holds, bytes.
pub(super) type Draft = (String, Format, String, Vec<u8>);

impl Stations {
    /// Reads all places, or the one wanted.
    pub(super) fn read(path: &Path, wanted: Option<&str>) -> Result<Self, ExportError> {
        let file = super::fields::open(path)?;
        let time = super::fields::doubles(path, &file, "elapsed_time")?;
        if time.is_empty() {
            return Err(ExportError::TooFewRows { path: path.to_path_buf(), found: 0, expected: 1 });
        }
        let start = match file.attribute("record_start").map(|a| a.value()) {
            Some(Ok(netcdf::AttributeValue::Str(text))) => calendar::unix_seconds(&text),
            _ => None,
        };
        let mut places = station_places(path, &file, time.len())?;
        places.extend(input_places(path, &file)?);
        places.retain(|place| !place.series.is_empty() || !place.tensors.is_empty());
        if let Some(wanted) = wanted {
            let known = places.iter().map(|place| place.name.clone()).collect();
            places.retain(|place| place.name == wanted);
            if places.is_empty() {
                let (path, place) = (path.to_path_buf(), wanted.to_owned());
                return Err(ExportError::Place { path, place, known });
            }
        }
        Ok(Self { path: path.to_path_buf(), start, time, places })
    }

    /// All files that are wanted.
    pub(super) fn files(&self, wanted: &Wanted, options: &ReadOptions) -> Result<Vec<Draft>, ExportError> {
        let mut drafts = vec![];
        let mut taken = vec![];
        for place in &self.places {
            let name = distinct(&place.name, &mut taken);
            if wanted.csv {
                let content = "time in s, motions in SI units, every digit".to_owned();
                drafts.push((format!("{name}.csv"), Format::Csv, content, self.csv(place).into_bytes()));
            }
            if wanted.mseed {
                self.mseed(place, &name, options, &mut drafts)?;
            }
            if wanted.sac {
                self.sac(place, &name, options, &mut drafts)?;
            }
        }
        Ok(drafts)
    }

    fn csv(&self, place: &Place) -> String {
        let mut text = format!("# motion at {}, written by hati {}\n", place.name, env!("CARGO_PKG_VERSION"));
        let start = self.start.map_or_else(|| "an unknown instant".to_owned(), calendar::iso8601);
        let _ = writeln!(text, "# time in s since {start}");
        text.push_str("time_s");
        for series in &place.series {
            let (_, motion, unit) = MOTIONS[series.motion];
            let _ = write!(text, ",{motion}_{}_{unit}", AXES[series.axis]);
        }
        for (column, _) in &place.tensors {
            let _ = write!(text, ",{column}");
        }
        text.push('\n');
        text.reserve(self.time.len() * (place.series.len() + place.tensors.len() + 1) * 20);
        for (row, time) in self.time.iter().enumerate() {
            // The shortest text that gives the same number back.
            let _ = write!(text, "{time:?}");
            for series in &place.series {
                let _ = write!(text, ",{:?}", series.samples[row]);
            }
            for (_, samples) in &place.tensors {
                let _ = write!(text, ",{:?}", samples[row]);
            }
            text.push('\n');
        }
        text
    }

    fn mseed(
        &self,
        place: &Place,
        name: &str,
        options: &ReadOptions,
        drafts: &mut Vec<Draft>,
    ) -> Result<(), ExportError> {
        for (motion, (quantity, word, _)) in MOTIONS.iter().enumerate() {
            let traces = self.traces(place, motion)?;
            if traces.is_empty() {
                continue;
            }
            let bytes = encode(FileFormat::MiniSeed, &traces, options)?.swap_remove(0);
            let content =
                format!("{word} in {}, 8-byte floats; miniSEED itself holds no unit", quantity.si_unit());
            drafts.push((format!("{name}.{word}.mseed"), Format::Mseed, content, bytes));
        }
        Ok(())
    }

    fn sac(
        &self,
        place: &Place,
        name: &str,
        options: &ReadOptions,
        drafts: &mut Vec<Draft>,
    ) -> Result<(), ExportError> {
        for (motion, (quantity, word, _)) in MOTIONS.iter().enumerate() {
            let traces = self.traces(place, motion)?;
            if traces.is_empty() {
                continue;
            }
            let axes = place.series.iter().filter(|s| s.motion == motion).map(|s| s.axis);
            let contents = encode(FileFormat::Sac, &traces, options)?;
            for (axis, bytes) in axes.zip(contents) {
                let content = format!("{word} in n{}, 4-byte floats", quantity.si_unit());
                drafts.push((format!("{name}.{word}.{}.sac", AXES[axis]), Format::Sac, content, bytes));
            }
        }
        Ok(())
    }

    /// The components of one motion as channels.
    fn traces<'a>(&self, place: &'a Place, motion: usize) -> Result<Vec<Trace<'a>>, ExportError> {
        let dt = self.step()?;
        let quantity = MOTIONS[motion].0;
        let of = |series: &'a Series| Trace {
            id: ["".into(), place.name.to_ascii_uppercase(), "".into(), channel(dt, quantity, series.axis)],
            start: self.start.map(|start| start + self.time[0]),
            dt,
            quantity,
            samples: &series.samples,
        };
        Ok(place.series.iter().filter(|s| s.motion == motion).map(of).collect())
    }

    /// Time step, s; these formats know one only.
    fn step(&self) -> Result<f64, ExportError> {
        let count = self.time.len();
        if count < 2 {
            return Err(ExportError::TooFewRows { path: self.path.clone(), found: count, expected: 2 });
        }
        let mean = (self.time[count - 1] - self.time[0]) / (count - 1) as f64;
        let out = |pair: &[f64]| ((pair[1] - pair[0]) / mean - 1.0).abs() > 1e-4;
        if let Some(before) = self.time.windows(2).position(out) {
            let found = self.time[before + 1] - self.time[before];
            return Err(ExportError::Uneven { path: self.path.clone(), sample: before + 1, found, mean });
        }
        // 0.005 rather than 0.005000000000000001, which the difference of two times may give.
        Ok(format!("{mean:.11e}").parse().unwrap_or(mean))
    }
}

/// SEED's three letters: band by the sampling rate, N for an accelerometer, H for a velocity sensor, X for
/// what no sensor has, and the axis.
fn channel(dt: f64, quantity: Quantity, axis: usize) -> String {
    let rate = 1.0 / dt;
    let band = match rate {
        r if r >= 1000.0 => 'F',
        r if r >= 250.0 => 'C',
        r if r >= 80.0 => 'H',
        r if r >= 10.0 => 'B',
        r if r > 1.0 => 'M',
        _ => 'L',
    };
    let sensor = match quantity {
        Quantity::Acceleration => 'N',
        Quantity::Velocity => 'H',
        Quantity::Displacement => 'X',
    };
    format!("{band}{sensor}{}", AXES[axis].to_ascii_uppercase())
}

/// Places along the dimension `station`.
fn station_places(path: &Path, file: &netcdf::File, rows: usize) -> Result<Vec<Place>, ExportError> {
    let Some(count) = file.dimension_len("station") else { return Ok(vec![]) };
    let missing = || ExportError::Layout { path: path.to_path_buf(), expected: "station_name".into() };
    let variable = file.variable("station_name").ok_or_else(missing)?;
    let names = names(&variable, count).map_err(super::fields::failed(path, "reading station_name"))?;
    let mut places: Vec<Place> =
        names.into_iter().map(|name| Place { name, series: vec![], tensors: vec![] }).collect();
    for (motion, (_, word, _)) in MOTIONS.iter().enumerate() {
        for (axis, letter) in AXES.iter().enumerate() {
            let name = format!("{word}_{letter}");
            if file.variable(&name).is_none() {
                continue;
            }
            let values = super::fields::doubles(path, file, &name)?;
            for (station, place) in places.iter_mut().enumerate() {
                let samples: Vec<f64> = (0..rows).map(|row| values[row * count + station]).collect();
                // A station that lacks this component holds nothing but missing values.
                if samples.iter().any(|v| !v.is_nan()) {
                    place.series.push(Series { motion, axis, samples });
                }
            }
        }
    }
    for (tensor, unit) in [("strain", ""), ("stress", "_Pa")] {
        for pair in ["xx", "yy", "zz", "xy", "yz", "xz"] {
            let name = format!("{tensor}_{pair}");
            if file.variable(&name).is_none() {
                continue;
            }
            let values = super::fields::doubles(path, file, &name)?;
            for (station, place) in places.iter_mut().enumerate() {
                let samples: Vec<f64> = (0..rows).map(|row| values[row * count + station]).collect();
                if samples.iter().any(|v| !v.is_nan()) {
                    place.tensors.push((format!("{name}{unit}"), samples));
                }
            }
        }
    }
    Ok(places)
}

/// Texts of a variable: as they are, or as the rows of letters of a run that was stopped.
fn names(variable: &netcdf::Variable<'_>, count: usize) -> netcdf::Result<Vec<String>> {
    if variable.vartype() != netcdf::types::NcVariableType::Char {
        return (0..count).map(|station| variable.get_string(station)).collect();
    }
    let letters = variable.get_raw_values(..)?;
    let rows = letters.chunks_exact((letters.len() / count).max(1));
    Ok(rows.map(|row| String::from_utf8_lossy(row).trim_end_matches('\0').to_owned()).collect())
}

/// Motions that are no station's: `outcrop_acceleration_x(time)`.
fn input_places(path: &Path, file: &netcdf::File) -> Result<Vec<Place>, ExportError> {
    let mut places: Vec<Place> = vec![];
    for variable in file.variables() {
        let name = variable.name();
        let found = MOTIONS.iter().enumerate().find_map(|(motion, (_, word, _))| {
            let (place, letter) = name.split_once(&format!("_{word}_"))?;
            let axis = AXES.iter().position(|axis| letter == axis.to_string())?;
            Some((place.to_owned(), motion, axis))
        });
        let Some((place, motion, axis)) = found else { continue };
        let series = Series { motion, axis, samples: super::fields::doubles(path, file, &name)? };
        match places.iter_mut().find(|p| p.name == place) {
            Some(known) => known.series.push(series),
            None => places.push(Place { name: place, series: vec![series], tensors: vec![] }),
        }
    }
    places.iter_mut().for_each(|p| p.series.sort_by_key(|s| (s.motion, s.axis)));
    Ok(places)
}

/// A place's name as that of a file; numbered where another place has the same one.
fn distinct(place: &str, taken: &mut Vec<String>) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' };
    let name: String = place.chars().map(plain).collect();
    let name = if name.is_empty() { "place".to_owned() } else { name };
    let numbered = |n: usize| if n == 1 { name.clone() } else { format!("{name}-{n}") };
    let free = |candidate: &String| !taken.contains(&candidate.to_lowercase());
    let name = (1..).map(numbered).find(free).unwrap_or_default();
    taken.push(name.to_lowercase());
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_channels() {
        let mut taken = vec![];
        let names = ["mid/clay", "mid clay", "A", "a"].map(|name| distinct(name, &mut taken));
        assert_eq!(names, ["mid_clay", "mid_clay-2", "A", "a-2"]);
        assert_eq!(channel(0.005, Quantity::Acceleration, 2), "HNZ");
        assert_eq!(channel(0.0005, Quantity::Velocity, 0), "FHX");
        assert_eq!(channel(0.05, Quantity::Displacement, 1), "BXY");
    }

    #[test]
    fn an_uneven_time_is_told() {
        let mut stations =
            Stations { path: "s.nc".into(), start: None, time: vec![0.0, 0.1, 0.2, 0.3], places: vec![] };
        assert_eq!(stations.step().expect("even"), 0.1);
        stations.time[2] = 0.21;
        assert!(matches!(stations.step(), Err(ExportError::Uneven { sample: 2, .. })));
    }
}
