//! The rows as an FMU's host sees them: parameters by variable name, and what must come out, bit for bit.
//!
//! `tests/fmi/test_stability.py` reads these cases and runs them through both FMUs. A scene that no parameter of the FMU can
//! describe (mirror planes, theta rule, polyhedra, motion given by hand) has no such case.

use crate::Result;
use fabric::{Draw, Error, Integrator, RotationRule, Scene, Shape, Sim, StepCheck, Symmetry, TimeStep, math};
use serde::Serialize;
use serde_json::{Map, Value, json};

/// A row for a host.
#[derive(Clone, Debug, Serialize)]
pub struct FmuCase {
    /// Start values by variable name.
    values: Map<String, Value>,
    /// Force on the projectile from the start, N.
    force: [f64; 3],
    /// What must happen.
    #[serde(flatten)]
    outcome: Expected,
}

/// What must happen.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "expected", rename_all = "snake_case")]
enum Expected {
    /// Initialisation ends in an error, and the log says this.
    Refused { text: String },
    /// A step of this size ends in an error, and the log says this.
    Failed { h: f64, text: String },
    /// A step of this size is taken, and these are the outputs then.
    Runs { h: f64, outputs: Map<String, Value> },
}

impl FmuCase {
    /// In a word.
    pub fn word(&self) -> &'static str {
        match self.outcome {
            Expected::Refused { .. } => "refused",
            Expected::Failed { .. } => "faulted",
            Expected::Runs { .. } => "same bits",
        }
    }
}

/// The case of a simulation that has run under a constant force; `steps`: how far it should have come if it failed.
/// What only `StepCheck::None` lets through must be refused by the FMU.
pub fn case(sim: &mut Sim<'_>, force: [f64; 3], steps: u64) -> Result<Option<FmuCase>> {
    let Some(values) = values(sim.scene(), sim.step_limits().dt) else { return Ok(None) };
    let checked = Scene { step_check: StepCheck::Refuse, ..seconds(sim.scene(), sim.step_limits().dt) };
    let outcome = if let Err(error) = checked.step_limits() {
        Expected::Refused { text: error.text().to_string() }
    } else if let Some(failure) = sim.failure() {
        let h = steps as f64 * sim.step_limits().dt;
        Expected::Failed { h, text: Error::from(failure).text().to_string() }
    } else {
        Expected::Runs { h: sim.time(), outputs: outputs(sim)? }
    };
    Ok(Some(FmuCase { values, force, outcome }))
}

fn seconds(scene: &Scene, dt: f64) -> Scene {
    Scene { time_step: TimeStep::seconds(dt), ..*scene }
}

/// Start values for a scene; None if the FMU has no variable for something in it.
fn values(scene: &Scene, dt: f64) -> Option<Map<String, Value>> {
    let (sheet, yarn, body) = (&scene.sheet, &scene.yarn, &scene.projectile);
    let preset = Scene::sheet_3in_sphere();
    let plain = scene.symmetry == Symmetry::default()
        && scene.integrator == Integrator::VERLET
        && scene.rotation_rule == RotationRule::MIDPOINT
        && (yarn.damage_a, yarn.damage_b, yarn.draw) == (1.0, 0.0, Draw::Segment)
        && body.shape != Shape::Polyhedron
        && (scene.drive, scene.track_support, scene.contact_capacity)
            == (preset.drive, preset.track_support, preset.contact_capacity)
        && scene.seed <= i32::MAX as u64;
    let mut values = Map::new();
    let mut give = |name: &str, value: Value| drop(values.insert(name.to_string(), value));
    give("preset", json!(1));
    give("sheet.nodes_x", json!(sheet.nodes_x));
    give("sheet.nodes_y", json!(sheet.nodes_y));
    give("sheet.plies", json!(sheet.plies));
    give("attachment.kind", json!(scene.attachment.kind as u32));
    give("projectile.shape", json!(body.shape as u32));
    give("yarn.stochastic", json!(yarn.stochastic));
    give("seed", json!(scene.seed));
    give("track_detachment", json!(scene.track_detachment));
    for (name, value) in [
        ("sheet.spacing", sheet.spacing),
        ("sheet.node_mass", sheet.node_mass),
        ("sheet.yarn_area", sheet.yarn_area),
        ("attachment.disc_inset", scene.attachment.disc_inset),
        ("attachment.disc_radius", scene.attachment.disc_radius),
        ("yarn.modulus_mean", yarn.modulus_mean),
        ("yarn.modulus_sd", yarn.modulus_sd),
        ("yarn.damage_slope", yarn.damage_slope),
        ("yarn.damage_intercept", yarn.damage_intercept),
        ("yarn.damage_sd", yarn.damage_sd),
        ("yarn.critical_stretch", yarn.critical_stretch),
        ("yarn.alpha_fail", yarn.alpha_fail),
        ("projectile.radius", body.radius),
        ("projectile.length", body.length),
        ("projectile.mass", body.mass),
        ("force_window", scene.force_window),
        ("dt", dt),
    ] {
        give(name, number(value));
    }
    for (name, vector) in [
        ("sheet.position", sheet.position),
        ("projectile.size", body.size),
        ("projectile.position", body.position),
        ("projectile.velocity", body.velocity),
        ("projectile.angular_velocity", body.angular_velocity),
    ] {
        give(name, vector.map(number).to_vec().into());
    }
    give("sheet.orientation", sheet.orientation.map(number).to_vec().into());
    give("projectile.orientation", body.orientation.map(number).to_vec().into());
    plain.then_some(values)
}

/// What the FMU must show, by output name.
fn outputs(sim: &mut Sim<'_>) -> Result<Map<String, Value>> {
    let (motion, contact, fabric) = (sim.projectile()?, sim.contact()?, sim.fabric()?);
    let (energy, counters, limits) = (sim.energy()?, sim.counters(), sim.step_limits());
    let outputs = json!({
        "contact.work": contact.work,
        "contact.impulse": contact.impulse,
        "contact.force_peak": contact.force_peak,
        "contact.unconverged": counters.unconverged,
        "support.impulse": sim.support()?.total,
        "state.position": motion.position,
        "state.velocity": motion.velocity,
        "state.orientation": motion.orientation,
        "state.angular_velocity": motion.angular_velocity,
        "energy.kinetic": energy.fabric_kinetic,
        "energy.strain": energy.strain,
        "energy.dissipated": energy.dissipated,
        "energy.residual": energy.residual,
        "momentum.residual": math::length(sim.momentum_residual()?),
        "step.fraction": limits.dt / limits.dt_crit,
        "fabric.failed_segments": counters.failed_segments,
        "fabric.max_stretch": fabric.max_stretch,
        "fabric.worst_penetration": counters.worst_penetration,
        "status": sim.outcomes().status as u32,
    });
    let Value::Object(outputs) = outputs else { return Err("the outputs are not an object".into()) };
    Ok(outputs)
}

/// JSON has no NaN and no infinity: they travel as text that Python's `float` reads.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}
