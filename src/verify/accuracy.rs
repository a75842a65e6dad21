//! Asked accuracy against measured accuracy.

use super::fixtures::{
    SOFT_LAYER, THREE_LAYERS, accelerogram, scene_along, scene_with, simulate, twenty_layers,
};
use super::{CaseResult, Check, twist};
use crate::measured::{finer, measured_error};
use crate::run::{RunError, Simulation};
use hati_inputs::scene::Scene;

/// `accuracy` = 1e-1, 1e-2, 1e-3 on three profiles, measured against runs four times finer: reached,
/// and not by a factor of ten unless the coarsest permitted model is already better. Twist: the speeds
/// of the run to compare with.
pub(super) fn accuracy(twisted: bool) -> CaseResult {
    let twenty = twenty_layers();
    let profiles = [
        ("three layers", THREE_LAYERS),
        ("20 layers of 1–3 m", &twenty),
        ("soft layer in 100 m", SOFT_LAYER),
    ];
    let mut checks = vec![];
    for (name, soil) in profiles {
        for asked in [1e-1, 1e-2, 1e-3] {
            let scene = scene_with(soil, "outcrop", asked, "", "")?;
            checks.push(against_finer(name, &scene, twisted)?);
        }
    }
    Ok(checks)
}

/// The same for the other kinds of motion and the vertical component.
pub(super) fn accuracy_kinds(twisted: bool) -> CaseResult {
    let rigid = THREE_LAYERS.replace("kind = \"elastic\"\nvs = 800.0\nrho = 2200.0", "kind = \"rigid\"");
    let mut checks = vec![];
    for (axis, kind, soil, name) in [
        ('x', "within", THREE_LAYERS, "three layers, within"),
        ('x', "within", rigid.as_str(), "three layers on a rigid base"),
        ('x', "surface", THREE_LAYERS, "three layers, surface"),
        ('z', "outcrop", THREE_LAYERS, "three layers, vertical"),
    ] {
        let scene = scene_along(axis, soil, kind, 1e-2, "", "")?;
        checks.push(against_finer(name, &scene, twisted)?);
    }
    Ok(checks)
}

fn against_finer(name: &str, scene: &Scene, twisted: bool) -> Result<Check, RunError> {
    let asked = scene.accuracy;
    let (plan, simulation) = simulate(scene, accelerogram(0.01, 20.0), 0.01)?;
    // the self-check needs no finer run: other speeds alone have to show
    let mut fine = if twisted { plan.clone() } else { finer(&plan)? };
    for l in &mut fine.column.layers {
        l.vs *= twist(twisted, asked);
        l.vp *= twist(twisted, asked);
    }
    fine.substeps *= if twisted { 2 } else { 1 };
    let mut reference = Simulation::new(&fine)?;
    reference.run_through(&fine)?;
    let error = measured_error(&plan, &simulation, &reference);
    let coarsest = plan.search.coarsest;
    let pass = error <= asked && (error >= 0.1 * asked || coarsest);
    let quantity = format!(
        "{name}: order {}, {} points, steps per sample {}, mechanisms {}{}; measured against predicted",
        plan.discretisation.order,
        plan.points(),
        plan.substeps,
        plan.mechanisms,
        if coarsest { ", the coarsest permitted" } else { "" }
    );
    let reference = plan.search.chosen.error;
    Ok(Check { case: "accuracy", quantity, value: error, reference, error, limit: asked, pass })
}
