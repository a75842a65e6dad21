//! What sources push: forces at points, symmetry counted in, and what of them the ground cannot feel.

use super::sources::Signal;
use super::symmetry::{Plane, length};
use crate::plan::PlanError;
use hati_inputs::scene::{Action, Place, erf};
use hati_sem::SemError;
use hati_sem::mesh::{Locator, Side};
use hati_sem::solid::{Gaussian, Ground, Probe};

/// Points and forces per unit amplitude.
type Forces = Vec<(u32, [f64; 3])>;

/// Part of a source that may be lost without a word.
const SILENT: f64 = 1e-6;
/// The same for the part of a Gaussian that falls beside its boundary.
const SILENT_BESIDE: f64 = 1e-2;
/// Part of a source below which nothing is left of it.
const NOTHING: f64 = 1e-3;

/// Forces of a source per unit of its time function.
#[derive(Debug, Clone, Default)]
pub struct SourceForces {
    /// The forces, N.
    pub forces: Forces,
    /// Where it acts, m: of a force, a moment or the centre of a patch.
    pub position: Option<[f64; 3]>,
    /// The element that holds a force or a moment.
    pub element: Option<usize>,
    /// What has no effect, in words.
    pub warnings: Vec<String>,
    /// What a reader of the plan wants to know.
    pub remark: Option<String>,
}

/// Coordinates of a place; a depth counts from the boundary `top`.
pub fn position(locator: &Locator<'_>, place: &Place) -> Result<[f64; 3], SemError> {
    match *place {
        Place::Point(point) => Ok(point),
        Place::Below { x, y, depth } => {
            let top = locator.find_on_surface(x, y)?.position;
            Ok([x, y, top[2] - depth])
        }
    }
}

impl SourceForces {
    /// Those of a force or a moment.
    fn at(forces: Forces, probe: &Probe) -> Self {
        let (position, element) = (Some(probe.position), Some(probe.element));
        Self { forces, position, element, ..Self::default() }
    }
}

/// Where a source is placed: the ground, its planes of symmetry, its name.
struct Placing<'a> {
    ground: &'a Ground,
    locator: &'a Locator<'a>,
    planes: &'a [Plane],
    name: &'a str,
}

/// Forces of a source per unit of its time function, and warnings where part of it does nothing.
///
/// A source on a plane of symmetry pushes half as hard on the half that is modelled, and only along the plane; its
/// mirror image, on the other half, does the rest.
///
/// # Errors
/// A place outside the ground; a source that a plane of symmetry turns round; one that does nothing at all.
pub fn forces(
    ground: &Ground,
    locator: &Locator<'_>,
    planes: &[Plane],
    signal: &Signal,
) -> Result<SourceForces, PlanError> {
    let placing = Placing { ground, locator, planes, name: &signal.name };
    match &signal.action {
        Action::Force { at, force } => placing.force(at, *force),
        Action::Moment { at, moment, .. } => placing.moment(at, *moment),
        Action::Traction { boundary, traction } => placing.traction(boundary, *traction),
        Action::Patch { boundary, centre, horizontal, sigma, force } => {
            let load = Gaussian { centre: *centre, horizontal: *horizontal, sigma: *sigma };
            placing.patch(boundary, &load, *force)
        }
    }
}

impl Placing<'_> {
    fn placed(&self, source: SemError) -> PlanError {
        PlanError::Place { what: format!("source `{}`", self.name), source: Box::new(source) }
    }

    fn probe(&self, at: &Place) -> Result<Probe, PlanError> {
        let at = position(self.locator, at).map_err(|e| self.placed(e))?;
        self.ground.probe(self.locator, at).map_err(|e| self.placed(e))
    }

    /// Warns where a share of the source has no effect, refuses where all of it has none.
    fn judge(&self, made: &mut SourceForces, lost: f64, why: &str, help: &str) -> Result<(), PlanError> {
        if lost > 1.0 - SILENT {
            let (name, why, help) = (self.name.into(), why.into(), help.into());
            return Err(PlanError::NoEffect { name, why, help });
        }
        if lost > SILENT {
            let words = format!("source `{}`: {} of it has no effect: {why}", self.name, percent(lost));
            made.warnings.push(words);
        }
        Ok(())
    }

    fn force(&self, at: &Place, force: [f64; 3]) -> Result<SourceForces, PlanError> {
        let probe = self.probe(at)?;
        let mut felt = force;
        for plane in self.planes.iter().filter(|p| p.carries(self.ground, &probe)) {
            plane.expect_along(self.name, force)?;
            felt = plane.along(felt).map(|f| 0.5 * f);
        }
        let part = self.halves(&probe);
        let lost = self.ground.lost(&probe.weights, felt);
        let missing: [f64; 3] = std::array::from_fn(|i| part * force[i] - felt[i] + lost[i]);
        let forces = probe.weights.iter().map(|&(node, w)| (node, felt.map(|f| f * w))).collect();
        let mut made = SourceForces::at(forces, &probe);
        let why = "it pushes along what a boundary holds there";
        self.judge(&mut made, norm(missing) / (part * norm(force)).max(f64::MIN_POSITIVE), why, HELD_HELP)?;
        Ok(made)
    }

    /// Share of a point source that the model carries: a half for every plane of symmetry that it stands on.
    fn halves(&self, probe: &Probe) -> f64 {
        let count = self.planes.iter().filter(|p| p.carries(self.ground, probe)).count();
        0.5_f64.powi(count as i32)
    }

    fn moment(&self, at: &Place, [xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Result<SourceForces, PlanError> {
        let probe = self.probe(at)?;
        let part = self.halves(&probe);
        let asked = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(|row| row.map(|m| part * m));
        let mut felt = asked;
        for plane in self.planes.iter().filter(|p| p.carries(self.ground, &probe)) {
            plane.expect_mirrored(self.name, [xx, yy, zz, xy, xz, yz])?;
            felt = plane.mirrored(felt);
        }
        let gradients = self.ground.basis_gradients(probe.element, probe.local);
        let nodes = self.ground.numbering().element(probe.element);
        let forces: Forces =
            nodes.iter().zip(gradients).map(|(&node, g)| (node, felt.map(|row| dot(row, g)))).collect();
        let mut made = SourceForces::at(forces, &probe);
        // beside held points a moment acts on; where all are held it does not
        let (mut taken, mut all) = (0.0, 0.0);
        for &(node, f) in &made.forces {
            all += norm(f);
            taken += norm(f) - norm(self.ground.released(node, f));
        }
        if all > 0.0 && taken > (1.0 - SILENT) * all {
            self.judge(&mut made, 1.0, "all points of its element are held", HELD_HELP)?;
        }
        Ok(made)
    }

    fn traction(&self, boundary: &str, traction: [f64; 3]) -> Result<SourceForces, PlanError> {
        let forces = self.ground.traction(boundary, |_| traction).map_err(|e| self.placed(e))?;
        let mut made = SourceForces { forces, ..SourceForces::default() };
        let (mut lost, mut all) = (0.0, 0.0);
        for side in self.sides(boundary) {
            let areas = self.ground.side_areas(side);
            let weights: Vec<(u32, f64)> = areas.into_iter().map(|(node, area)| (node, norm(area))).collect();
            let area: f64 = weights.iter().map(|w| w.1).sum();
            lost += area * norm(self.ground.lost(&weights, traction));
            all += area * norm(traction);
        }
        self.judge(&mut made, lost / all.max(f64::MIN_POSITIVE), HELD_SIDES, HELD_HELP)?;
        Ok(made)
    }

    fn patch(&self, boundary: &str, load: &Gaussian, force: [f64; 3]) -> Result<SourceForces, PlanError> {
        let weights = self.ground.gaussian(boundary, load).map_err(|e| self.placed(e))?;
        let (mut felt, mut expected) = (force, 1.0);
        for plane in self.planes.iter().filter(|p| weights.iter().any(|w| p.points.contains(&w.0))) {
            let inside = -plane.outside(load.centre);
            // what lies beyond the plane is the mirror image's; a centre beyond it is a mistake
            expected *= 0.5 * (1.0 + erf(inside.max(0.0) / (std::f64::consts::SQRT_2 * load.sigma)));
            if inside.abs() <= 1e-6 * length(self.ground) {
                plane.expect_along(self.name, force)?;
                felt = plane.along(felt);
            }
        }
        let share = weights.iter().map(|w| w.1).sum::<f64>() / expected;
        if share < NOTHING {
            let why = format!(
                "none of its Gaussian falls on `{boundary}`: the centre is outside, or off the surface by more than sigma"
            );
            let help = "move `centre` onto the boundary, or give it without z".into();
            return Err(PlanError::NoEffect { name: self.name.into(), why, help });
        }
        let forces = weights.iter().map(|&(node, w)| (node, felt.map(|f| f * w))).collect();
        let mut made = SourceForces { forces, position: Some(load.centre), ..SourceForces::default() };
        let words = format!("{} of its force falls on `{boundary}`", percent(share));
        if (share - 1.0).abs() > SILENT_BESIDE {
            made.warnings.push(format!(
                "source `{}`: {words}, the rest of its Gaussian lies beyond the boundary's rim or off the surface",
                self.name
            ));
        }
        made.remark = Some(words);
        let held = self.held_part(boundary, &weights, felt);
        self.judge(&mut made, held, HELD_SIDES, HELD_HELP)?;
        Ok(made)
    }

    /// Share of a force spread on a boundary that falls on sides held along it.
    fn held_part(&self, boundary: &str, weights: &[(u32, f64)], force: [f64; 3]) -> f64 {
        let (mut lost, mut all) = (0.0, 0.0);
        for side in self.sides(boundary) {
            let weight =
                |node: u32| weights.binary_search_by_key(&node, |w| w.0).map_or(0.0, |i| weights[i].1);
            let own: Vec<(u32, f64)> =
                self.ground.side_areas(side).into_iter().map(|(node, _)| (node, weight(node))).collect();
            let size: f64 = own.iter().map(|w| w.1.abs()).sum();
            if size > 0.0 {
                lost += size * norm(self.ground.lost(&own, force));
                all += size * norm(force);
            }
        }
        lost / all.max(f64::MIN_POSITIVE)
    }

    fn sides(&self, boundary: &str) -> Vec<Side> {
        self.ground.mesh().boundary(boundary).map_or_else(Vec::new, |b| b.sides.clone())
    }
}

const HELD_HELP: &str = "move the source to where the ground can follow it, or free that boundary";
const HELD_SIDES: &str = "it falls on sides that are held along it";

fn percent(share: f64) -> String {
    format!("{:.4} %", 1e2 * share)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests;
