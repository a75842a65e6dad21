//! The mesh with its materials, sources and stations, seen from above and from the side.

use std::collections::HashMap;

use super::super::place;
use super::super::svg::{Anchor, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::super::wave::{MeshFace, MeshPicture, MeshView};
use super::wave::metres;
use super::{Plate, WIDTH, extent};
use crate::results::AXES;

/// Fills of the materials; neighbours in the list differ in grey too.
const FILLS: [&str; 8] =
    ["#f2e3b8", "#b9a48c", "#dbe7ee", "#8fae9d", "#e8c4a0", "#9db4cc", "#f0d9dd", "#8d8aa0"];
const SOURCE: &str = "#b3202c";
const STATION: &str = "#1f2933";
/// Faces of a view above which they are drawn in lumps and without outlines.
const MOST_FACES: usize = 6000;
/// Lumps along the longer side of a view.
const LUMPS: usize = 260;
const LEFT: f64 = 76.0;
const GAP: f64 = 84.0;
const TOP: f64 = 94.0;
const TALLEST: f64 = 420.0;
/// Height below which a view is drawn taller than it is, pixels.
const FLATTEST: f64 = 130.0;
/// Places of a kind above which none carries its name.
const NAMED: usize = 12;

/// Elements filled by material, with sources and stations; `None` without a view.
pub(in super::super) fn mesh(picture: &MeshPicture) -> Option<Plate> {
    let frames = frames(&picture.views)?;
    let bottom = frames.iter().map(|f| f.at.y + f.at.height).fold(0.0, f64::max);
    let mut figure = Figure::new("mesh", "The mesh", WIDTH, bottom + 46.0);
    key(&mut figure, picture);
    let (mut lumped, mut table) = (false, [vec![], vec![], vec![], vec![], vec![]]);
    for (number, (frame, view)) in frames.iter().zip(&picture.views).enumerate() {
        let lumps = (view.faces.len() > MOST_FACES).then(|| lumps(&view.faces, frame));
        lumped |= lumps.is_some();
        let faces = lumps.as_deref().unwrap_or(&view.faces);
        let outline =
            lumps.is_none().then(|| Stroke::solid("#3e4c59", if faces.len() > 1500 { 0.35 } else { 0.7 }));
        draw(&mut figure, picture, view, frame, faces, outline);
        for (face, MeshFace { material, outline }) in faces.iter().enumerate() {
            for [across, up] in outline {
                let row = [number as f64, face as f64, *material as f64, *across, *up];
                table.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            }
        }
    }
    let names: Vec<String> = picture
        .materials
        .iter()
        .enumerate()
        .map(|(i, name)| format!("{i} {}", super::super::svg::escape(name)))
        .collect();
    let mut caption = format!(
        "Sources and stations are drawn wherever they lie along the line of sight. The table holds the corners of every face; its \
         materials are {}.",
        names.join(", ")
    );
    if lumped {
        caption += " The elements are too many to be drawn one by one: what is shown are lumps of them.";
    }
    let mut csv = Table::default();
    for (name, column) in ["view", "face", "material", "across_m", "up_m"].into_iter().zip(table) {
        csv = csv.column(name, column);
    }
    Some(Plate { figure, csv: csv.to_csv(), caption })
}

/// Where a view stands in the figure.
struct Frame {
    at: Rect,
    across: (f64, f64),
    up: (f64, f64),
    /// How much taller than true.
    exaggeration: f64,
}

/// Places of all views side by side, to one scale, unless one would be too flat to see.
fn frames(views: &[MeshView]) -> Option<Vec<Frame>> {
    let range = |view: &MeshView, i: usize| {
        extent(view.faces.iter().flat_map(|f| &f.outline).map(|p| p[i])).filter(|(a, b)| b > a)
    };
    let ranges: Vec<_> = views.iter().map(|v| Some((range(v, 0)?, range(v, 1)?))).collect::<Option<_>>()?;
    let wide: f64 = ranges.iter().map(|(a, _)| a.1 - a.0).sum();
    let high = ranges.iter().map(|(_, u)| u.1 - u.0).fold(0.0, f64::max);
    if ranges.is_empty() {
        return None;
    }
    let gaps = GAP * (ranges.len() - 1) as f64;
    let scale = ((WIDTH - LEFT - 40.0 - gaps) / wide).min(TALLEST / high);
    let mut x = LEFT;
    let place = |(across, up): ((f64, f64), (f64, f64))| {
        let (width, true_height) = (scale * (across.1 - across.0), scale * (up.1 - up.0));
        let height = true_height.max(FLATTEST);
        let at = Rect { x, y: TOP, width, height };
        x += width + GAP;
        Frame { at, across, up, exaggeration: height / true_height }
    };
    Some(ranges.into_iter().map(place).collect())
}

fn draw(
    figure: &mut Figure,
    picture: &MeshPicture,
    view: &MeshView,
    frame: &Frame,
    faces: &[MeshFace],
    outline: Option<Stroke>,
) {
    let at = frame.at;
    let ticks = |size: f64| ((size / 75.0) as usize).clamp(2, 8);
    let letters = view.axes.map(|axis| AXES.get(axis).copied().unwrap_or('?'));
    let (x, y) =
        (metres(frame.across, letters[0], ticks(at.width)), metres(frame.up, letters[1], ticks(at.height)));
    let panel = Panel::draw(figure, at, x, y, true, true);
    let pixel = |p: [f64; 2]| {
        let part = |v: f64, range: (f64, f64)| (v - range.0) / (range.1 - range.0);
        (at.x + at.width * part(p[0], frame.across), at.y + at.height * (1.0 - part(p[1], frame.up)))
    };
    // runs of one material, so that near faces stay above far ones
    for run in faces.chunk_by(|a, b| a.material == b.material) {
        let outlines = run.iter().map(|face| face.outline.iter().map(|&p| pixel(p)));
        figure.polygons(outlines, FILLS[run[0].material % FILLS.len()], outline);
    }
    panel.close(figure);
    let mut title = view.title.clone();
    if frame.exaggeration > 1.05 {
        title += &format!(", drawn {} times too tall", significant(frame.exaggeration, 2));
    }
    figure.text(at.x, at.y - 22.0, &title, Text::new(12.5).bold());
    marks(figure, picture, at, |place| pixel(view.axes.map(|axis| place[axis])));
}

/// Marks and names of stations and sources; `pixel` takes a place to the figure.
fn marks(figure: &mut Figure, picture: &MeshPicture, at: Rect, pixel: impl Fn([f64; 3]) -> (f64, f64)) {
    let mut taken = vec![];
    let kinds = [(&picture.sources, true), (&picture.stations, false)];
    for (places, is_source) in kinds.into_iter().rev() {
        for (x, y) in places.iter().map(|(_, place)| pixel(*place)) {
            if is_source {
                figure.polygons([star(x, y)], SOURCE, Some(Stroke::solid("#ffffff", 1.0)));
                taken.push([x - 9.0, y - 9.0, x + 9.0, y + 9.0]);
            } else {
                let triangle = [(x - 6.0, y - 10.0), (x + 6.0, y - 10.0), (x, y)];
                figure.polygons([triangle], STATION, Some(Stroke::solid("#ffffff", 1.0)));
                taken.push([x - 6.0, y - 10.0, x + 6.0, y]);
            }
        }
    }
    for (places, is_source) in kinds.into_iter().filter(|(places, _)| places.len() <= NAMED) {
        let colour = if is_source { SOURCE } else { STATION };
        for (name, place) in places {
            name_beside(figure, at, pixel(*place), &place::words(name), colour, &mut taken);
        }
    }
}

/// The name of a mark, where nothing else stands: right, left, above or below; else it is left out.
fn name_beside(
    figure: &mut Figure,
    at: Rect,
    (x, y): (f64, f64),
    name: &str,
    colour: &'static str,
    taken: &mut Vec<[f64; 4]>,
) {
    let wide = 6.6 * name.chars().count() as f64;
    let (right, left) = ((x + 11.0, y), (x - 11.0 - wide, y));
    let (above, below) = ((x - 0.5 * wide, y - 14.0), (x - 0.5 * wide, y + 20.0));
    let (far_right, far_left) = ((x + 11.0, y - 14.0), (x - 11.0 - wide, y - 14.0));
    for (from, base) in [right, left, above, below, far_right, far_left] {
        let area = [from, base - 9.0, from + wide, base + 2.0];
        let inside = from > at.x - 30.0 && from + wide < at.x + at.width + 34.0;
        let free = |t: &[f64; 4]| area[0] >= t[2] || area[2] <= t[0] || area[1] >= t[3] || area[3] <= t[1];
        let clear = base > at.y - 12.0 && base < at.y + at.height;
        if inside && clear && taken.iter().all(free) {
            taken.push(area);
            figure.text(from, base, name, Text::new(11.5).anchor(Anchor::Start).colour(colour).halo());
            return;
        }
    }
}

/// An eight-pointed star.
fn star(x: f64, y: f64) -> [(f64, f64); 16] {
    std::array::from_fn(|i| {
        let (radius, angle) = (if i % 2 == 0 { 9.0 } else { 3.5 }, std::f64::consts::PI * i as f64 / 8.0);
        (x + radius * angle.cos(), y + radius * angle.sin())
    })
}

fn key(figure: &mut Figure, picture: &MeshPicture) {
    let (mut x, y) = (16.0, 48.0);
    let width = |name: &str| 34.0 + 6.9 * name.chars().count() as f64;
    for (number, name) in picture.materials.iter().enumerate() {
        if x + width(name) > WIDTH - 240.0 {
            figure.text(x, y, "…", Text::new(12.0));
            break;
        }
        figure.rectangle(x, y - 11.0, 13.0, 13.0, FILLS[number % FILLS.len()]);
        figure.text(x + 18.0, y, name, Text::new(12.0));
        x += width(name);
    }
    let mark = WIDTH - 190.0;
    figure.polygons([star(mark, y - 4.0)], SOURCE, None);
    figure.text(mark + 14.0, y, "source", Text::new(12.0));
    let mark = WIDTH - 100.0;
    figure.polygons([[(mark - 6.0, y - 9.0), (mark + 6.0, y - 9.0), (mark, y + 1.0)]], STATION, None);
    figure.text(mark + 12.0, y, "station", Text::new(12.0));
}

/// Many small faces as rectangles of a raster that touch them, rows merged; a later face lies above an earlier one.
fn lumps(faces: &[MeshFace], frame: &Frame) -> Vec<MeshFace> {
    let (wide, high) = (frame.across.1 - frame.across.0, frame.up.1 - frame.up.0);
    let size = wide.max(high) / LUMPS as f64;
    let count = |length: f64| ((length / size).ceil() as usize).max(1);
    let (columns, rows) = (count(wide), count(high));
    let mut cells: HashMap<(usize, usize), usize> = HashMap::new();
    for MeshFace { material, outline } in faces {
        let span = |i: usize, start: f64, most: usize| {
            let (low, high) = extent(outline.iter().map(|p| p[i])).unwrap_or_default();
            let first = (((low - start) / size + 1e-9).floor().max(0.0) as usize).min(most - 1);
            let last = (((high - start) / size - 1e-9).ceil() as usize).clamp(first + 1, most);
            first..last
        };
        for row in span(1, frame.up.0, rows) {
            for column in span(0, frame.across.0, columns) {
                cells.insert((row, column), *material);
            }
        }
    }
    let mut sorted: Vec<((usize, usize), usize)> = cells.into_iter().collect();
    sorted.sort_unstable();
    let joined = |a: &((usize, usize), usize), b: &((usize, usize), usize)| {
        a.1 == b.1 && a.0.0 == b.0.0 && a.0.1 + 1 == b.0.1
    };
    let mut lumps: Vec<MeshFace> = (sorted.chunk_by(joined))
        .map(|run| {
            let ((row, first), material) = run[0];
            let x = |column: usize| (frame.across.0 + size * column as f64).min(frame.across.1);
            let y = |row: usize| (frame.up.0 + size * row as f64).min(frame.up.1);
            let (x, y) = ([x(first), x(first + run.len())], [y(row), y(row + 1)]);
            MeshFace { material, outline: vec![[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]] }
        })
        .collect();
    lumps.sort_by_key(|face| face.material);
    lumps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(columns: usize, rows: usize) -> MeshView {
        let face = |i: usize, j: usize| {
            let (x, y) = (10.0 * i as f64, 5.0 * j as f64);
            let outline = vec![[x, y], [x + 10.0, y], [x + 10.0, y + 5.0], [x, y + 5.0]];
            MeshFace { material: usize::from(2 * j >= rows), outline }
        };
        let faces = (0..rows).flat_map(|j| (0..columns).map(move |i| face(i, j))).collect();
        MeshView { title: "seen from above".into(), axes: [0, 1], faces }
    }

    fn area(faces: &[MeshFace], material: usize) -> f64 {
        let of = |f: &MeshFace| (f.outline[2][0] - f.outline[0][0]) * (f.outline[2][1] - f.outline[0][1]);
        faces.iter().filter(|f| f.material == material).map(of).sum()
    }

    #[test]
    fn many_faces_become_lumps_of_the_same_area() {
        let view = grid(300, 300);
        let frames = frames(std::slice::from_ref(&view)).unwrap();
        let lumps = lumps(&view.faces, &frames[0]);
        assert!(lumps.len() < 600 && view.faces.len() == 90_000, "{}", lumps.len());
        let (all, upper) = (3000.0 * 1500.0, area(&lumps, 1));
        assert!((area(&lumps, 0) + upper - all).abs() < 1e-6 * all);
        assert!((upper / all - 0.5).abs() < 0.02, "{upper}");
    }

    #[test]
    fn every_face_source_and_station_is_drawn() {
        let picture = MeshPicture {
            materials: vec!["clay <1>".into(), "rock".into()],
            views: vec![grid(4, 2)],
            sources: vec![("hammer".into(), [5.0, 5.0, 0.0])],
            stations: vec![("a".into(), [30.0, 8.0, 0.0]), ("b".into(), [31.0, 8.0, 0.0])],
        };
        let plate = mesh(&picture).unwrap();
        let svg = plate.figure.finish();
        assert_eq!(plate.csv.lines().count(), 1 + 8 * 4);
        assert_eq!(
            svg.matches(FILLS[0]).count() + svg.matches(FILLS[1]).count(),
            4,
            "two runs, two of the key"
        );
        let names =
            [">hammer<", ">a<", ">b<"].map(|name| svg.lines().filter(|line| line.contains(name)).count());
        assert_eq!(names, [1, 1, 1], "b's name stands where a's does not");
        let filled = |colour: &str| svg.matches(&format!("Z\" fill=\"{colour}\"")).count();
        assert_eq!((filled(SOURCE), filled(STATION)), (2, 3), "the marks and those of the key");
        assert!(plate.caption.contains("clay &lt;1&gt;"));
        let crowd =
            (0..NAMED).map(|i| (format!("station {i}"), [20.0 + 0.01 * i as f64, 8.0, 0.0])).collect();
        let crowded = mesh(&MeshPicture { stations: crowd, ..picture }).unwrap().figure.finish();
        let named = crowded.matches(">station ").count();
        assert!(named > 2 && named < NAMED, "{named} names fit about one place");
        assert!(mesh(&MeshPicture::default()).is_none());
    }
}
