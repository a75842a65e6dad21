//! Cases of waves in half-spaces: Lamb's problem, LOH.1, error against cost.

mod cost;
mod lamb;
mod loh1;

pub(super) use cost::{cost_chart, lamb_chart};
pub use lamb::{Footprint, LAMB_DISTANCES, LambModel, LambRecord, lamb_closed_form};
pub use loh1::{LOH1_RATE, Loh1Model, Loh1Record};

use super::{CaseResult, Check, twist};
use lamb::{RATE, difference};

/// Column of a table of references; its comments begin with `#`, a line of names follows.
fn column(table: &str, index: usize) -> Vec<f64> {
    let value = |row: &str| row.split(',').nth(index).and_then(|x| x.parse().ok()).unwrap_or(f64::NAN);
    table.lines().filter(|l| !l.starts_with('#')).skip(1).map(value).collect()
}

/// Reference displacement at instants k/256 s to 1.2 s, m downward: the point force at a distance of
/// [`LAMB_DISTANCES`], by its closed form.
fn closed_form(distance: usize) -> Vec<f64> {
    let instants = 0..(1.2 * RATE) as usize;
    instants.map(|k| lamb_closed_form(LAMB_DISTANCES[distance], k as f64 / RATE)).collect()
}

/// Largest differences over the peak: a name and a value for every compared record.
fn lamb_differences(record: &LambRecord, footprint: Footprint) -> Vec<(String, f64)> {
    const TABLE: &str = include_str!("tables/lamb.csv");
    let mut found = vec![];
    for (i, [radial, down]) in record.displacement.iter().enumerate() {
        let r = LAMB_DISTANCES[i];
        match footprint {
            Footprint::Point => {
                let table = column(TABLE, 1 + 3 * i);
                found.push((format!("point force, u_z at {r} m, table"), difference(down, &table)));
                found.push((
                    format!("point force, u_z at {r} m, closed form"),
                    difference(down, &closed_form(i)),
                ));
            }
            Footprint::Gaussian => {
                let tables = [column(TABLE, 2 + 3 * i), column(TABLE, 3 + 3 * i)];
                found.push((format!("spread force, u_r at {r} m"), difference(radial, &tables[0])));
                found.push((format!("spread force, u_z at {r} m"), difference(down, &tables[1])));
            }
        }
    }
    found
}

fn lamb_case(case: &'static str, models: &[LambModel], limit: f64, twisted: bool) -> CaseResult {
    let mut checks = vec![];
    for model in models {
        let record = model.run::<f32>(twist(twisted, limit))?;
        let found = lamb_differences(&record, model.footprint);
        checks.extend(found.into_iter().map(|(what, error)| {
            let limit = if what.ends_with("table") { limit.max(1.5e-2) } else { limit };
            Check::error(case, format!("{what}: largest difference over peak"), error, limit)
        }));
    }
    Ok(checks)
}

/// Lamb's problem to 0.6 s, when the waves have passed all receivers. Twist: both wave speeds.
pub(super) fn lamb(twisted: bool) -> CaseResult {
    let point = LambModel {
        order: 4,
        footprint: Footprint::Point,
        width_at_source: 5.0,
        width: 5.0,
        growth: 1.0,
        side: 80.0,
        step_share: 0.5,
        end: 0.6,
    };
    // the quadrature of the sides has to see the Gaussian: points 0.15 to 0.37 m apart at the source
    let spread = LambModel {
        order: 5,
        footprint: Footprint::Gaussian,
        width_at_source: 1.3,
        width: 8.0,
        growth: 4.0,
        step_share: 0.9,
        ..point
    };
    lamb_case("lamb", &[point, spread], 1.5e-2, twisted)
}

/// The same finer, and to 0.95 s, in a box so large that what comes back from its sides by then stays below
/// 3e-4 of the peak. Twist: both wave speeds.
pub(super) fn lamb_fine(twisted: bool) -> CaseResult {
    let spread = LambModel {
        order: 6,
        footprint: Footprint::Gaussian,
        width_at_source: 1.3,
        width: 7.0,
        growth: 4.0,
        side: 130.0,
        step_share: 0.7,
        end: 0.95,
    };
    let point = LambModel { footprint: Footprint::Point, width_at_source: 2.5, ..spread };
    lamb_case("lamb-fine", &[point, spread], 1e-3, twisted)
}

impl Loh1Model {
    /// The whole record of 9 s; waves from the box's sides need 3.9 s to the receiver and are small then.
    pub fn whole() -> Self {
        Self {
            order: 6,
            width: 400.0,
            heights: [350.0, 700.0],
            side: 12_000.0,
            depth: 10_000.0,
            step_share: 0.9,
            end: 9.0,
            threads: threads(),
        }
    }

    /// The first 3 s in a small box of coarse elements, for a quick test.
    pub fn beginning() -> Self {
        let (side, depth) = (6000.0, 5500.0);
        Self { width: 500.0, heights: [500.0, 800.0], side, depth, end: 3.0, ..Self::whole() }
    }
}

fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Reference of LOH.1: velocity at instants k/64 s, m/s, components as in [`Loh1Record`].
pub fn loh1_reference() -> [Vec<f64>; 3] {
    const TABLE: &str = include_str!("tables/loh1.csv");
    std::array::from_fn(|c| column(TABLE, 1 + c))
}

/// LOH.1 at 1 km with all that the pulse holds, to 10 Hz; the misfits up to 5 Hz are a test's. Twist: the
/// shear-wave speed of the layer.
pub(super) fn loh1(twisted: bool) -> CaseResult {
    const LIMIT: f64 = 3e-2;
    let record = Loh1Model::whole().run::<f32>(twist(twisted, LIMIT))?;
    let components = ["radial", "transverse", "vertical"];
    Ok((components.iter().zip(&record.velocity).zip(&loh1_reference()))
        .map(|((name, found), reference)| {
            let quantity = format!("{name} velocity: largest difference over peak");
            Check::error("loh1", quantity, difference(found, reference), LIMIT)
        })
        .collect())
}
