//! One impact from start to end, and what is read off it.

use crate::Result;
use fabric::Solid;
use fabric::math::length;
use fabric::{Body, Inertia};
use fabric::{Counters, Energy, Motion, Outcome, OutcomeSet, Scene, Sim};
use serde::Serialize;

/// The outcome that is a mask's bit.
pub fn mask_of(outcomes: &[Outcome]) -> OutcomeSet {
    outcomes.iter().copied().collect()
}

/// Kinetic energy of the projectile at the start, J, with that of its rotation.
pub fn kinetic_energy(scene: &Scene) -> f64 {
    let body = &scene.projectile;
    let solid = Solid::of(body);
    let motion = Motion {
        position: body.position,
        velocity: body.velocity,
        orientation: body.orientation,
        angular_velocity: if scene.projectile_turns() { body.angular_velocity } else { [0.0; 3] },
    };
    Body::of(&motion).kinetic_energy(&Inertia::of(&solid, body.mass, true))
}

/// A latched outcome.
#[derive(Clone, Debug, Serialize)]
pub struct Latched {
    /// Its name.
    pub outcome: &'static str,
    /// Step count.
    pub step: u64,
    /// Time, s.
    pub time: f64,
    /// Energy absorbed until then, J.
    pub absorbed: f64,
}

/// What one ply holds.
#[derive(Clone, Debug, Serialize)]
pub struct InPly {
    /// Its fabric: name if it has one, areal density, modulus, strain at which it begins to fail.
    pub fabric: String,
    /// Whether it is turned by 90 degrees.
    pub turned: bool,
    /// Segments with alpha = 0.
    pub failed_segments: u64,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Strain energy, J.
    pub strain: f64,
    /// Energy dissipated by rupture, J.
    pub dissipated: f64,
}

impl InPly {
    /// Every ply of a stack; none of a single sheet.
    fn of_stack(sim: &Sim<'_>) -> Result<Vec<InPly>> {
        let scene = sim.scene();
        let plies = if scene.stack.plies > 1 { scene.stack.plies } else { 0 };
        let all = (0..plies).map(|number| {
            let fabric::Ply { failed_segments, kinetic, strain, dissipated } = sim.ply(number)?;
            let (fabric, turned) = (fabric_of(scene, number), scene.stack.turned && number % 2 == 1);
            Ok(InPly { fabric, turned, failed_segments, kinetic, strain, dissipated })
        });
        all.collect()
    }
}

/// The numbers of a ply's fabric.
fn fabric_of(scene: &Scene, ply: u32) -> String {
    let (yarn, back) = (&scene.yarn, &scene.back);
    let (mass, modulus, stretch) = match ply < scene.front_plies() {
        true => (scene.sheet.node_mass * f64::from(scene.sheet.plies), yarn.modulus_mean, yarn.critical_stretch),
        false => (back.node_mass * f64::from(scene.sheet.plies), back.modulus_mean, back.critical_stretch),
    };
    let [h_x, h_y] = scene.spacings();
    let (density, strain) = (mass / (h_x * h_y), 100.0 * (stretch - 1.0));
    format!("{density:.3} kg/m2, {:.1} GPa, fails from {strain:.2} %", 1e-9 * modulus)
}

/// What one impact gave. All of it is reproducible to the bit.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Names of the outcomes that ended the run, or TIMEOUT if the step limit did.
    pub ended_by: String,
    /// Steps taken.
    pub steps: u64,
    /// Time step, s.
    pub dt: f64,
    /// Time step over dt_crit.
    pub dt_over_dt_crit: f64,
    /// End of the run, s.
    pub time: f64,
    /// Kinetic energy of the projectile at the start, J.
    pub initial_kinetic_energy: f64,
    /// Coefficient of friction between yarn and projectile; none without friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_coefficient: Option<f64>,
    /// Gap between the separate plies, m; none for a single sheet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ply_gap: Option<f64>,
    /// Momentum of the projectile at the start, N s.
    pub initial_momentum: f64,
    /// Velocity of the projectile at the end, m/s.
    pub residual_velocity: [f64; 3],
    /// Angular velocity of the projectile at the end, rad/s.
    pub residual_angular_velocity: [f64; 3],
    /// Work of the projectile on the fabric at the end, J.
    pub absorbed: f64,
    /// What of it went into held nodes, J.
    pub support_work: f64,
    /// Outcomes in the order of their numbers.
    pub outcomes: Vec<Latched>,
    /// Largest mean force over a force window, N.
    pub peak_force: f64,
    /// Window of the peak force, s.
    pub force_window: f64,
    /// Segments with alpha = 0.
    pub failed_segments: u64,
    /// All segments.
    pub segments: u64,
    /// Impulse of the sheet on its supports, N s.
    pub support_impulse: [f64; 3],
    /// The same for each side (left, right, bottom, top) or corner.
    pub support_impulses: [[f64; 3]; 4],
    /// Kinetic energy of the fabric at the end, J.
    pub fabric_kinetic: f64,
    /// Strain energy at the end, J.
    pub strain: f64,
    /// Energy dissipated by rupture, J.
    pub dissipated: f64,
    /// Energy that the viscosity of the yarn took, J.
    pub viscous: f64,
    /// Energy rubbed away between yarn and projectile, J.
    pub friction: f64,
    /// Kinetic energy lost where separate plies meet, J.
    pub ply_loss: f64,
    /// Deepest way of a node through the one that it faces in the next ply, m.
    pub ply_penetration: f64,
    /// What each separate ply holds, in their order; empty for a single sheet.
    pub plies: Vec<InPly>,
    /// Kinetic energy lost in impacts of nodes, J.
    pub contact_loss: f64,
    /// What the energy balance does not close by, J.
    pub energy_residual: f64,
    /// The same over the initial kinetic energy; 0 if that is 0.
    pub energy_residual_relative: f64,
    /// Length of what the momentum balance does not close by, N s.
    pub momentum_residual: f64,
    /// Deepest penetration of a node, m.
    pub worst_penetration: f64,
    /// Most sweeps of one contact solve.
    pub most_sweeps: u64,
    /// Contact solves that ran out of sweeps.
    pub unconverged: u64,
    /// Passes in which the body met a graded network beyond its fine part.
    pub beyond_fine: u64,
    /// Hash of the final state.
    pub digest: String,
    /// What the numbers alone do not say loudly enough; only of a run of a scene file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

impl Summary {
    /// Reads the simulation as it stands. `mask`: the outcomes that were waited for.
    pub fn of(sim: &Sim<'_>, mask: OutcomeSet) -> Result<Summary> {
        let limits = sim.step_limits();
        let (motion, contact, support) = (sim.projectile()?, sim.contact()?, sim.support()?);
        let energy: Energy = sim.energy()?;
        let counters: Counters = sim.counters();
        let found = sim.outcomes();
        let outcomes: Vec<Latched> = Outcome::ALL
            .iter()
            .zip(&found.latched)
            .filter_map(|(outcome, latch)| {
                let latch = latch.as_ref()?;
                let time = latch.step as f64 * limits.dt;
                Some(Latched { outcome: outcome.name(), step: latch.step, time, absorbed: latch.work })
            })
            .collect();
        let waited: Vec<&str> = Outcome::ALL
            .iter()
            .filter(|outcome| mask.has(**outcome) && found.mask.has(**outcome))
            .map(|outcome| outcome.name())
            .collect();
        let start = kinetic_energy(sim.scene());
        let momentum = sim.momentum_residual()?;
        Ok(Summary {
            ended_by: if waited.is_empty() { "TIMEOUT".to_string() } else { waited.join(" and ") },
            steps: counters.steps,
            dt: limits.dt,
            dt_over_dt_crit: limits.dt / limits.dt_crit,
            time: sim.time(),
            initial_kinetic_energy: start,
            friction_coefficient: Some(sim.scene().contact.friction).filter(|friction| *friction > 0.0),
            ply_gap: Some(sim.scene().stack).filter(|stack| stack.plies > 1).map(|stack| stack.gap),
            initial_momentum: sim.scene().projectile.mass * length(sim.scene().projectile.velocity),
            residual_velocity: motion.velocity,
            residual_angular_velocity: motion.angular_velocity,
            absorbed: contact.work,
            support_work: energy.support_work,
            outcomes,
            peak_force: contact.force_peak,
            force_window: sim.scene().force_window,
            failed_segments: counters.failed_segments,
            segments: sim.scene().segments(),
            support_impulse: support.total,
            support_impulses: support.attachments,
            fabric_kinetic: energy.fabric_kinetic,
            strain: energy.strain,
            dissipated: energy.dissipated,
            viscous: energy.viscous,
            friction: energy.friction,
            ply_loss: energy.ply_loss,
            ply_penetration: counters.ply_penetration,
            plies: InPly::of_stack(sim)?,
            contact_loss: energy.contact_loss,
            energy_residual: energy.residual,
            energy_residual_relative: if start > 0.0 { energy.residual / start } else { 0.0 },
            momentum_residual: length(momentum),
            worst_penetration: counters.worst_penetration,
            most_sweeps: counters.most_sweeps,
            unconverged: counters.unconverged,
            beyond_fine: counters.beyond_fine,
            digest: format!("{:016x}", sim.digest()),
            warnings: Vec::new(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabric::Shape;

    /// A single sheet without friction says nothing of plies and friction.
    #[test]
    fn what_is_on_is_named() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (11, 11);
        let summary = |scene: &Scene| {
            let mut buffers = crate::memory::Buffers::of(scene).unwrap();
            Summary::of(&buffers.sim(scene).unwrap(), OutcomeSet::NONE).unwrap()
        };
        let plain = serde_json::to_string(&summary(&scene)).unwrap();
        assert!(!plain.contains("friction_coefficient") && !plain.contains("ply_gap"), "{plain}");
        (scene.contact.friction, scene.stack.plies, scene.stack.gap, scene.stack.turned) = (0.2, 3, 1e-4, true);
        (scene.back.plies, scene.back.modulus_mean, scene.back.critical_stretch) = (1, 9e10, 1.04);
        (scene.back.damage_slope, scene.back.damage_intercept) = (0.0, 2000.0);
        let found = summary(&scene);
        assert_eq!((found.friction_coefficient, found.ply_gap), (Some(0.2), Some(1e-4)));
        assert_eq!(found.plies.iter().map(|ply| ply.turned).collect::<Vec<_>>(), [false, true, false]);
        assert_eq!(found.plies[0].fabric, found.plies[1].fabric);
        assert!(found.plies[2].fabric.ends_with("90.0 GPa, fails from 4.00 %"), "{}", found.plies[2].fabric);
    }

    #[test]
    fn a_body_that_turns_has_energy() {
        let mut scene = Scene::sheet_3in_sphere();
        let body = &mut scene.projectile;
        (body.shape, body.size, body.mass) = (Shape::Box, [0.02, 0.01, 0.01], 0.01);
        (body.velocity, body.angular_velocity) = ([0.0, 0.0, 5.0], [0.0, 20_000.0, 0.0]);
        let moment = 0.01 * (0.02 * 0.02 + 0.01 * 0.01) / 12.0;
        let expected = 0.5 * 0.01 * 25.0 + 0.5 * moment * 4e8;
        assert!((kinetic_energy(&scene) / expected - 1.0).abs() < 1e-14);
    }
}
