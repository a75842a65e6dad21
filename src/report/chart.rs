//! Error against cost of a scene: the figure and the page of `hati chart`.

use super::svg::{Axis, Figure, Panel, Rect, Stroke, Text, escape, significant};
use crate::chart::Point;
use hati_inputs::scene::Scene;
use std::fmt::Write as _;

const WIDTH: f64 = 980.0;
const HEIGHT: f64 = 560.0;
const AT: Rect = Rect { x: 84.0, y: 56.0, width: WIDTH - 84.0 - 150.0, height: 430.0 };

/// One colour and one dash per order, so that the lines part in grey as well.
const STROKES: [(&str, &str); 8] = [
    ("#7b8794", "2 3"),
    ("#b44d12", "6 3"),
    ("#de911d", ""),
    ("#3f9142", ""),
    ("#0967d2", ""),
    ("#6b2fb3", ""),
    ("#ba2525", "8 3 2 3"),
    ("#102a43", "4 2"),
];

/// Measured error against solver time, one line per order, with the asked accuracy and auto's point.
pub(crate) fn chart_figure(title: &str, accuracy: f64, points: &[Point]) -> String {
    let mut figure = Figure::new("chart", &format!("Error against cost: {title}"), WIDTH, HEIGHT);
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values
            .filter(|v| *v > 0.0 && v.is_finite())
            .fold((f64::INFINITY, 0.0_f64), |m, v| (m.0.min(v), m.1.max(v)))
    };
    let (t0, t1) = range(&mut points.iter().map(|p| p.seconds));
    let (e0, e1) = range(&mut points.iter().flat_map(|p| [p.measured, p.predicted]).chain([accuracy]));
    if !(t0.is_finite() && e0.is_finite()) {
        return figure.finish();
    }
    let x = Axis::log(t0 * 0.8, t1 * 1.25, "solver time (s)");
    let y = Axis::log(e0 * 0.7, e1 * 1.4, "relative L2 error of acceleration, worst station (1)");
    let panel = Panel::draw(&mut figure, AT, x, y, true, true);
    panel.horizontal(&mut figure, accuracy, Stroke::solid("#52606d", 1.2));
    figure.text(AT.x + 8.0, panel.py(accuracy) - 6.0, "accuracy asked", Text::new(12.0).halo());
    let mut orders: Vec<usize> = points.iter().map(|p| p.order).collect();
    orders.sort_unstable();
    orders.dedup();
    let mut entries = vec![];
    for (i, order) in orders.iter().enumerate() {
        let (colour, dash) = STROKES[i % STROKES.len()];
        let stroke = Stroke::solid(colour, 1.8).dashed(dash);
        let mut line: Vec<(f64, f64)> =
            points.iter().filter(|p| p.order == *order).map(|p| (p.seconds, p.measured)).collect();
        line.sort_by(|a, b| b.1.total_cmp(&a.1));
        panel.polyline(&mut figure, &line, stroke);
        for (t, e) in &line {
            figure.dot(panel.px(*t), panel.py(*e), 3.2, colour);
        }
        entries.push((format!("order {order}"), stroke));
    }
    for (i, (name, stroke)) in entries.iter().enumerate() {
        let row = AT.y + 16.0 + 22.0 * i as f64;
        let left = AT.x + AT.width + 18.0;
        figure.segment((left, row), (left + 26.0, row), *stroke);
        figure.text(left + 34.0, row + 4.0, name, Text::new(12.0));
    }
    if let Some(auto) = points.iter().find(|p| p.auto) {
        let (px, py) = (panel.px(auto.seconds), panel.py(auto.measured));
        figure.dot(px, py, 7.5, "#102a43");
        figure.dot(px, py, 4.5, "#f7c948");
        figure.text(px + 12.0, py - 8.0, "chosen by auto", Text::new(13.0).bold().halo());
    }
    panel.close(&mut figure);
    figure.finish()
}

/// The page of `hati chart`: the figure and the numbers.
pub(crate) fn chart_page(scene: &Scene, points: &[Point], svg: &str) -> String {
    let mut rows = String::new();
    for p in points {
        let _ = write!(
            rows,
            "<tr{}><td>{}</td><td>{:?}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            if p.auto { " class=\"auto\"" } else { "" },
            p.order,
            p.elements,
            p.points,
            p.substeps,
            p.mechanisms,
            significant(p.predicted, 3),
            significant(p.measured, 3),
            significant(p.seconds, 3),
        );
    }
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}: error against cost</title>\
         <style>body{{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:62rem;padding:0 1rem;color:#1f2933}}\
         svg{{max-width:100%;height:auto}}table{{border-collapse:collapse;font-size:.85rem}}\
         th,td{{padding:.25rem .7rem;text-align:left;border-bottom:1px solid #e4e7eb}}.auto{{font-weight:700;background:#fffbea}}</style></head>\
         <body><h1>{title}</h1><p>Each point is a run of this scene, its error measured against a run four times finer than the most \
         accurate of them, its time (steps alone) the median over rounds in which all take turns. Lower left is better. <code>auto</code> took the highlighted one \
         for an asked accuracy of {asked}.</p>{svg}<table><thead><tr><th>order</th><th>elements per layer</th><th>points</th>\
         <th>steps per sample</th><th>mechanisms</th><th>predicted error</th><th>measured error</th><th>solver s</th></tr></thead>\
         <tbody>{rows}</tbody></table></body></html>\n",
        title = escape(&scene.title),
        asked = significant(scene.accuracy, 2),
    )
}
