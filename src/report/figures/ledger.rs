//! Where the energy went: the ledger over time.

use super::super::place::COLUMN;
use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::{Plate, WIDTH, extent};
use crate::results::LedgerRow;

/// Fills of the shares, from the bottom up; lightness falls so that grey tells them apart.
const FILLS: [&str; 4] = ["#d9e6f2", "#9dbfda", "#e9b872", "#b3552f"];

/// Whose energies they are: decides units and words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Ledgered {
    /// A column: per unit of plan area.
    Column,
    /// A section: per metre along y.
    Section,
    /// A volume.
    Volume,
}

impl Ledgered {
    fn unit(self) -> &'static str {
        match self {
            Self::Column => "J/m²",
            Self::Section => "J/m",
            Self::Volume => "J",
        }
    }

    /// Ending of the table's columns.
    fn suffix(self) -> &'static str {
        match self {
            Self::Column => "j_m2",
            Self::Section => "j_m",
            Self::Volume => "j",
        }
    }

    /// Words of each share, from the bottom up.
    fn shares(self) -> [&'static str; 4] {
        let left = match self {
            Self::Column => "radiated into the half-space",
            _ => "left through boundaries",
        };
        [left, "lost to material damping", "strain energy", "kinetic energy"]
    }

    fn body(self) -> &'static str {
        if self == Self::Column { "column" } else { "ground" }
    }

    fn first_words(self) -> &'static str {
        match self {
            Self::Column => "Energies per unit plan area.",
            Self::Section => "Energies per metre along y.",
            Self::Volume => "Energies of the whole model.",
        }
    }
}

fn shares(row: &LedgerRow) -> [f64; 4] {
    [row.outflow, row.viscous, row.strain, row.kinetic]
}

/// Largest |residual| over the largest (|input| + stored), 1; `None` for an empty ledger.
pub(in super::super) fn closing_error(rows: &[LedgerRow]) -> Option<f64> {
    let reference = reference(rows)?;
    let worst = rows.iter().map(|r| r.residual.abs()).fold(0.0, f64::max);
    Some(worst / reference)
}

fn reference(rows: &[LedgerRow]) -> Option<f64> {
    extent(rows.iter().map(|r| r.input.abs() + r.kinetic + r.strain))
        .map(|(_, high)| high)
        .filter(|high| *high > 0.0)
}

/// Left edge of all panels.
const LEFT: f64 = 88.0;
/// Top and height of the panels: cumulative energies, stored energy, residual.
const PANELS: [(f64, f64); 3] = [(60.0, 270.0), (370.0, 110.0), (520.0, 110.0)];

fn place(panel: usize) -> Rect {
    let (y, height) = PANELS[panel];
    Rect { x: LEFT, y, width: WIDTH - LEFT - 24.0, height }
}

/// The energy ledger: stacked shares under the input, what is stored enlarged, the residual below.
pub(in super::super) fn ledger(rows: &[LedgerRow], of: Ledgered) -> Option<Plate> {
    let error = closing_error(rows)?;
    let reference = reference(rows)?;
    let (first, last) = extent(rows.iter().map(|r| r.time))?;
    let height = |r: &LedgerRow| shares(r).iter().sum::<f64>();
    let (_, top) = extent(rows.iter().flat_map(|r| [r.input, height(r)]))?;
    let (low, _) = extent(rows.iter().map(|r| r.input.min(0.0)))?;
    let mut figure = Figure::new("energy-ledger", "Energy ledger", WIDTH, 682.0);
    let x = Axis::linear(first, last, "elapsed time (s)", 12);
    let (scale, unit) = energy_unit(top, of);
    let label = format!("energy ({unit})");
    let y = Axis::linear(low * scale * 1.06, top * scale * 1.06, &label, 6);
    let panel = Panel::draw(&mut figure, place(0), x.clone(), y, false, true);
    draw_shares(&mut figure, &panel, rows, scale, 0);
    let input = Stroke::dashed(COLUMN, "7 3").wide(2.0);
    panel.line(&mut figure, rows.iter().map(|r| (r.time, r.input * scale)), input);
    panel.close(&mut figure);
    let shown = significant(error, 2);
    let at = place(0);
    // at the end of the time where less stands in its way
    let highest = |from: f64, to: f64| {
        let within = |r: &&LedgerRow| (from..=to).contains(&((r.time - first) / (last - first)));
        rows.iter().filter(within).map(|r| r.input).fold(0.0, f64::max)
    };
    let early = highest(0.0, 0.3) <= highest(0.7, 1.0);
    let (x_text, anchor) =
        if early { (at.x + 12.0, Anchor::Start) } else { (at.x + at.width - 12.0, Anchor::End) };
    let style = Text::new(13.5).bold().halo().anchor(anchor);
    figure.text(x_text, at.y + 24.0, &format!("closing error {shown}"), style);
    draw_stored(&mut figure, rows, x.clone(), of);
    draw_residual(&mut figure, rows, reference, x);
    draw_key(&mut figure, at.x + at.width, input, of);
    Some(Plate {
        figure,
        csv: table(rows, of.suffix()),
        caption: format!(
            "{} Stacked: what is stored and what has left the {}; the dashed \
             line is what came in. Where the two meet, no energy was made or lost. Closing error: largest \
             |input − stored − losses| over the largest |input| + stored = {shown}.",
            of.first_words(),
            of.body(),
        ),
    })
}

/// Strain and kinetic energy at a scale of their own.
fn draw_stored(figure: &mut Figure, rows: &[LedgerRow], x: Axis, of: Ledgered) {
    let Some((_, top)) = extent(rows.iter().map(|r| r.strain + r.kinetic)) else {
        return;
    };
    let (scale, unit) = energy_unit(top, of);
    let y = Axis::from_zero(top * scale, &format!("stored ({unit})"), 3);
    let panel = Panel::draw(figure, place(1), x, y, false, true);
    draw_shares(figure, &panel, rows, scale, 2);
    panel.close(figure);
    let style = Text::new(12.5).bold();
    figure.text(LEFT, place(1).y - 9.0, &format!("stored in the {}", of.body()), style);
}

/// Stacks the shares from number `from` on.
fn draw_shares(figure: &mut Figure, panel: &Panel, rows: &[LedgerRow], scale: f64, from: usize) {
    // A point per pixel is enough: areas have no thin peaks that must be kept.
    let stride = rows.len().div_ceil(1000).max(1);
    let mut picked: Vec<&LedgerRow> = rows.iter().step_by(stride).collect();
    picked.extend(rows.last());
    let mut low: Vec<(f64, f64)> = picked.iter().map(|r| (r.time, 0.0)).collect();
    for (share, fill) in FILLS.iter().enumerate().skip(from) {
        let high: Vec<(f64, f64)> = picked
            .iter()
            .zip(&low)
            .map(|(r, (time, base))| (*time, base + shares(r)[share] * scale))
            .collect();
        panel.band(figure, &low, &high, fill);
        panel.line(figure, high.iter().copied(), Stroke::solid("#ffffff", 0.7));
        low = high;
    }
}

fn draw_residual(figure: &mut Figure, rows: &[LedgerRow], reference: f64, x: Axis) {
    let relative = |r: &LedgerRow| (r.residual / reference).abs();
    let sizes = rows.iter().map(relative).filter(|v| *v > 0.0);
    let (_, high) = extent(sizes).unwrap_or((1e-16, 1e-15));
    let low = (high * 1e-4).max(1e-18).min(high * 0.1);
    let y = Axis::log(low, high * 3.0, "|residual| (1)");
    let panel = Panel::draw(figure, place(2), x, y, true, true);
    let floor = low * 0.5;
    let points = rows.iter().map(|r| (r.time, relative(r).max(floor)));
    panel.line(figure, points, COLUMN.wide(1.1));
    panel.close(figure);
    let style = Text::new(12.5).bold();
    let words = "what does not close, over the largest |input| + stored";
    figure.text(LEFT, place(2).y - 9.0, words, style);
}

fn draw_key(figure: &mut Figure, right: f64, input: Stroke, of: Ledgered) {
    let width = |text: &str| 30.0 + 6.6 * text.chars().count() as f64;
    let total: f64 = of.shares().into_iter().map(width).sum();
    let mut x = right - total - 78.0;
    figure.segment((x, 22.0), (x + 24.0, 22.0), input);
    figure.text(x + 30.0, 26.0, "input", Text::new(12.0));
    x += 78.0;
    for (fill, words) in FILLS.into_iter().zip(of.shares()).rev() {
        figure.rectangle(x, 15.0, 13.0, 13.0, fill);
        let style = Text::new(12.0).anchor(Anchor::Start);
        figure.text(x + 18.0, 26.0, words, style);
        x += width(words);
    }
}

/// Factor and unit in which the largest energy has few digits.
fn energy_unit(top: f64, of: Ledgered) -> (f64, String) {
    let prefixes = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m")];
    let (size, prefix) = prefixes.into_iter().find(|(size, _)| top >= 2.0 * size).unwrap_or((1e-6, "µ"));
    (1.0 / size, format!("{prefix}{}", of.unit()))
}

fn table(rows: &[LedgerRow], suffix: &str) -> String {
    let column = |of: fn(&LedgerRow) -> f64| rows.iter().map(of).collect::<Vec<f64>>();
    Table::default()
        .column("elapsed_time_s", column(|r| r.time))
        .column(format!("input_{suffix}"), column(|r| r.input))
        .column(format!("kinetic_{suffix}"), column(|r| r.kinetic))
        .column(format!("strain_{suffix}"), column(|r| r.strain))
        .column(format!("viscous_{suffix}"), column(|r| r.viscous))
        .column(format!("outflow_{suffix}"), column(|r| r.outflow))
        .column(format!("residual_{suffix}"), column(|r| r.residual))
        .to_csv()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_follow_the_size_and_the_kind() {
        assert_eq!(energy_unit(2.5e6, Ledgered::Column), (1e-6, "MJ/m²".to_owned()));
        assert_eq!(energy_unit(1.9e3, Ledgered::Section), (1.0, "J/m".to_owned()));
        assert_eq!(energy_unit(0.1, Ledgered::Volume).1, "mJ");
        assert_eq!(energy_unit(0.0, Ledgered::Volume).1, "µJ");
    }
}
