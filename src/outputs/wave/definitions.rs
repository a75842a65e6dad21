//! Dimensions, variables and attributes of a wave field's file.

use super::super::classic::{Attribute, ClassicFile, Kind, Layout, Variable};
use super::super::file::{MOTIONS, axis_words};
use super::super::{OutputError, Provenance};
use super::{Cells, Grid, Sensor, SensorLayout, WaveLayout};
use crate::results::AXES;

/// Names of the peak maps, in the order of the motions.
pub(super) const PEAKS: [&str; 3] = ["pgd", "pgv", "pga"];

/// Values of a variable that does not grow.
pub(super) enum Fixed {
    Doubles(String, Vec<f64>),
    Ints(String, Vec<i32>),
    Bytes(String, Vec<i8>),
    Letters(String, Vec<u8>),
}

impl Fixed {
    pub(super) fn put(&self, file: &mut ClassicFile) -> Result<(), OutputError> {
        match self {
            Self::Doubles(name, values) => file.put(name, values),
            Self::Ints(name, values) => file.put(name, values),
            Self::Bytes(name, values) => file.put(name, values),
            Self::Letters(name, values) => file.put(name, values),
        }
    }
}

/// A layout under construction.
pub(super) struct Definitions {
    layout: Layout,
    fixed: Vec<Fixed>,
}

impl Definitions {
    pub(super) fn new(provenance: &Provenance, content: &str, conventions: &str) -> Self {
        let mut attributes = provenance.attributes(content);
        let named = attributes.iter_mut().find(|(name, _)| name == "Conventions");
        named.into_iter().for_each(|(_, value)| *value = conventions.into());
        let dimensions = vec![("time".to_owned(), 0)];
        let mut made = Self { layout: Layout { dimensions, attributes, variables: vec![] }, fixed: vec![] };
        let time = [
            ("standard_name", "time"),
            ("long_name", "time"),
            ("units", &provenance.time_units()),
            ("calendar", "standard"),
            ("axis", "T"),
        ];
        made.variable("time", Kind::Double, &["time"], &time);
        let elapsed = [("long_name", "elapsed time since the start of the record"), ("units", "s")];
        made.variable("elapsed_time", Kind::Double, &["time"], &elapsed);
        made
    }

    pub(super) fn finish(self) -> (Layout, Vec<Fixed>) {
        (self.layout, self.fixed)
    }

    fn dimension(&mut self, name: &str, length: usize) {
        self.layout.dimensions.push((name.to_owned(), length));
    }

    pub(super) fn variable(
        &mut self,
        name: &str,
        kind: Kind,
        dimensions: &[&str],
        attributes: &[(&str, &str)],
    ) {
        let number = |name: &&str| self.layout.dimensions.iter().position(|(d, _)| d == name);
        let dimensions = dimensions.iter().filter_map(number).collect();
        let attributes = attributes.iter().map(|(key, value)| ((*key).to_owned(), (*value).into())).collect();
        self.layout.variables.push(Variable { name: name.to_owned(), kind, dimensions, attributes });
    }

    /// Gives the latest variable another attribute.
    pub(super) fn attribute(&mut self, name: &str, value: Attribute) {
        let latest = self.layout.variables.last_mut();
        latest.into_iter().for_each(|v| v.attributes.push((name.to_owned(), value.clone())));
    }

    /// UGRID topology with its nodes and cells.
    pub(super) fn cells(&mut self, cells: &Cells) {
        let (cell, words) = match cells.dimension {
            1 => ("edge", "edges between the points of the elements' sides"),
            2 => ("face", "quadrilaterals between the points of the elements"),
            _ => ("volume", "hexahedra between the points of the elements"),
        };
        let connectivity = format!("mesh_{cell}_nodes");
        self.dimension("node", cells.points.len());
        self.dimension(cell, cells.len());
        self.dimension("corner", 1 << cells.dimension);
        self.variable(
            "mesh",
            Kind::Int,
            &[],
            &[
                ("cf_role", "mesh_topology"),
                ("long_name", words),
                ("node_coordinates", super::cells::STATIC_COORDINATES),
                (&format!("{cell}_node_connectivity"), &connectivity),
                (&format!("{cell}_dimension"), cell),
            ],
        );
        self.attribute("topology_dimension", Attribute::Int(cells.dimension as i32));
        if cells.dimension == 3 {
            self.attribute("volume_shape_type", "mesh_volume_types".into());
        }
        self.fixed.push(Fixed::Ints("mesh".into(), vec![0]));
        for (axis, letter) in AXES.iter().enumerate() {
            self.node_coordinate(axis, &format!("mesh_node_{letter}"));
            let values = cells.points.iter().map(|p| p[axis]).collect();
            self.fixed.push(Fixed::Doubles(format!("mesh_node_{letter}"), values));
        }
        let role = format!("{cell}_node_connectivity");
        let attributes = [("cf_role", role.as_str()), ("long_name", "nodes at the corners, counted from 0")];
        self.variable(&connectivity, Kind::Int, &[cell, "corner"], &attributes);
        self.attribute("start_index", Attribute::Int(0));
        self.fixed.push(Fixed::Ints(connectivity, cells.corners.iter().map(|&c| c as i32).collect()));
        if cells.dimension == 3 {
            let attributes = [
                ("cf_role", "volume_shape_type"),
                ("long_name", "shape of the cells"),
                ("flag_meanings", "tetrahedron wedge hexahedron"),
            ];
            self.variable("mesh_volume_types", Kind::Byte, &[cell], &attributes);
            self.attribute("flag_values", Attribute::Bytes(vec![0, 1, 2]));
            self.fixed.push(Fixed::Bytes("mesh_volume_types".into(), vec![2; cells.len()]));
        }
    }

    fn node_coordinate(&mut self, axis: usize, name: &str) {
        let words = format!("local coordinate of the nodes {}", axis_words(axis));
        let mut attributes = vec![("long_name", words.as_str()), ("units", "m")];
        attributes.extend(match axis {
            0 => [("standard_name", "projection_x_coordinate")],
            1 => [("standard_name", "projection_y_coordinate")],
            _ => [("positive", "up")],
        });
        self.variable(name, Kind::Double, &["node"], &attributes);
    }

    /// Coordinates of a regular grid; returns its dimensions.
    pub(super) fn grid(&mut self, grid: &Grid) -> Vec<&'static str> {
        let mut dimensions = vec![];
        for (axis, name, values) in [(2, "z", &grid.z), (1, "y", &grid.y), (0, "x", &grid.x)] {
            if values.is_empty() {
                continue;
            }
            self.dimension(name, values.len());
            let words = format!("local coordinate {}", axis_words(axis));
            let mut attributes =
                vec![("long_name", words.as_str()), ("units", "m"), ("axis", ["X", "Y", "Z"][axis])];
            if axis == 2 {
                attributes.push(("positive", "up"));
            }
            self.variable(name, Kind::Double, &[name], &attributes);
            self.fixed.push(Fixed::Doubles(name.to_owned(), values.clone()));
            dimensions.push(name);
        }
        dimensions
    }

    /// The motions over time; `dimensions` are those behind `time`.
    pub(super) fn motions(&mut self, layout: &WaveLayout, dimensions: &[&str], coordinates: &str) {
        let all: Vec<&str> = std::iter::once("time").chain(dimensions.iter().copied()).collect();
        for motion in layout.motions() {
            let (name, units) = MOTIONS[motion];
            for &axis in &layout.axes {
                let words = format!("total {name} {}", axis_words(axis));
                let mut attributes =
                    vec![("long_name", words.as_str()), ("units", units), ("coordinates", coordinates)];
                if dimensions == ["node"] {
                    attributes.extend([("mesh", "mesh"), ("location", "node")]);
                }
                self.variable(&format!("{name}_{}", AXES[axis]), Kind::Float, &all, &attributes);
                self.attribute("_FillValue", Attribute::Float(f32::NAN));
            }
        }
    }

    /// Sensors with their names and places.
    pub(super) fn sensors(&mut self, sensors: &[Sensor]) {
        self.layout.attributes.push(("featureType".to_owned(), "timeSeries".into()));
        let longest = sensors.iter().map(|s| s.name.len()).max().unwrap_or(0).max(1);
        self.dimension("station", sensors.len());
        self.dimension("name_length", longest);
        let role = [("cf_role", "timeseries_id"), ("long_name", "station name")];
        self.variable("station_name", Kind::Char, &["station", "name_length"], &role);
        let letters = sensors.iter().flat_map(|s| {
            let name = s.name.replace('\0', " ").into_bytes();
            (0..longest).map(move |i| name.get(i).copied().unwrap_or(0))
        });
        self.fixed.push(Fixed::Letters("station_name".into(), letters.collect()));
        for (axis, letter) in AXES.iter().enumerate() {
            let places = sensors.iter().map(|s| s.position[axis]).collect();
            let mut attributes = vec![("units", "m"), ("axis", ["X", "Y", "Z"][axis])];
            if axis == 2 {
                attributes.push(("positive", "up"));
            }
            let words = format!("local coordinate {}", axis_words(axis));
            attributes.push(("long_name", &words));
            self.variable(&letter.to_string(), Kind::Double, &["station"], &attributes);
            self.fixed.push(Fixed::Doubles(letter.to_string(), places));
        }
        for (axis, letter) in AXES.iter().enumerate() {
            let words = format!("coordinate that was asked for {}", axis_words(axis));
            let name = format!("{letter}_asked");
            self.variable(&name, Kind::Double, &["station"], &[("long_name", &words), ("units", "m")]);
            self.fixed.push(Fixed::Doubles(name, sensors.iter().map(|s| s.asked[axis]).collect()));
        }
    }

    /// What sensors record over time, f64.
    pub(super) fn recorded(&mut self, layout: &SensorLayout) {
        let mut lines: Vec<(String, String, &str)> = vec![];
        for (motion, units) in MOTIONS {
            lines.extend(layout.axes.iter().map(|&axis| {
                (format!("{motion}_{}", AXES[axis]), format!("total {motion} {}", axis_words(axis)), units)
            }));
        }
        for (kind, units, asked) in [("strain", "1", layout.strain), ("stress", "Pa", layout.stress)] {
            for pair in ["xx", "yy", "zz", "xy", "yz", "xz"].into_iter().filter(|_| asked) {
                let words = format!("component {pair} of the {kind} tensor, tension positive");
                lines.push((format!("{kind}_{pair}"), words, units));
            }
        }
        for (name, words, units) in &lines {
            let attributes = [
                ("long_name", words.as_str()),
                ("units", *units),
                ("coordinates", "elapsed_time station_name x y z"),
            ];
            self.variable(name, Kind::Double, &["time", "station"], &attributes);
        }
    }

    /// The peak maps over the nodes.
    pub(super) fn peaks(&mut self, layout: &WaveLayout, coordinates: &str) {
        for (name, (motion, units)) in PEAKS.iter().zip(MOTIONS) {
            let mut lines: Vec<(String, String)> = (layout.axes.iter())
                .map(|&axis| {
                    let words = format!("largest absolute {motion} {} over the run", axis_words(axis));
                    (format!("{name}_{}", AXES[axis]), words)
                })
                .collect();
            lines.push(((*name).to_owned(), format!("largest length of the {motion} vector over the run")));
            for (name, words) in &lines {
                let attributes = [
                    ("long_name", words.as_str()),
                    ("units", units),
                    ("coordinates", coordinates),
                    ("mesh", "mesh"),
                    ("location", "node"),
                ];
                self.variable(name, Kind::Float, &["node"], &attributes);
                self.attribute("_FillValue", Attribute::Float(f32::NAN));
            }
        }
    }
}
