//! One impact from start to end, and what is read off it.

use crate::Result;
use fabric::math::length;
use fabric::{Contact, Counters, Energy, Motion, Outcome, OutcomeSet, Scene, Sim, StepLimits, Support};
use serde::{Serialize, Serializer};
use serde_json::json;

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
pub struct Summary {
    /// Names of the outcomes that ended the run, or TIMEOUT if the step limit did.
    pub ended_by: String,
    /// Kinetic energy of the projectile at the start, J.
    pub initial_kinetic_energy: f64,
    /// Outcomes in the order of their numbers.
    pub outcomes: Vec<Latched>,
    /// What each separate ply holds, in their order; empty for a single sheet.
    pub plies: Vec<InPly>,
    /// Length of what the momentum balance does not close by, N s.
    pub momentum_residual: f64,
    /// What the numbers alone do not say loudly enough.
    pub warnings: Vec<String>,
    /// The read-outs at the end.
    pub scene: Scene,
    pub limits: StepLimits,
    pub time: f64,
    pub motion: Motion,
    pub contact: Contact,
    pub support: Support,
    pub energy: Energy,
    pub counters: Counters,
    pub digest: String,
}

impl Summary {
    /// Reads the simulation as it stands. `mask`: the outcomes that were waited for; `start`: kinetic energy of the projectile at the
    /// start, J.
    pub fn of(sim: &Sim<'_>, mask: OutcomeSet, start: f64) -> Result<Summary> {
        let (limits, found) = (sim.step_limits(), sim.outcomes());
        let latched = Outcome::ALL.iter().zip(&found.latched).filter_map(|(outcome, latch)| {
            let latch = latch.as_ref()?;
            let time = latch.step as f64 * limits.dt;
            Some(Latched { outcome: outcome.name(), step: latch.step, time, absorbed: latch.work })
        });
        let waited = Outcome::ALL.iter().filter(|outcome| mask.has(**outcome) && found.mask.has(**outcome));
        let waited: Vec<&str> = waited.map(|outcome| outcome.name()).collect();
        Ok(Summary {
            ended_by: if waited.is_empty() { "TIMEOUT".to_string() } else { waited.join(" and ") },
            initial_kinetic_energy: start,
            outcomes: latched.collect(),
            plies: InPly::of_stack(sim)?,
            momentum_residual: length(sim.momentum_residual()?),
            warnings: Vec::new(),
            scene: *sim.scene(),
            limits,
            time: sim.time(),
            motion: sim.projectile()?,
            contact: sim.contact()?,
            support: sim.support()?,
            energy: sim.energy()?,
            counters: sim.counters(),
            digest: format!("{:016x}", sim.digest()),
        })
    }

    /// What the energy balance does not close by, over the kinetic energy at the start; 0 if that is 0.
    pub fn open_part(&self) -> f64 {
        let start = self.initial_kinetic_energy;
        if start > 0.0 { self.energy.residual / start } else { 0.0 }
    }
}

/// summary.json: SI units, host's axes; what is off, a single sheet's plies and no warnings are left out.
impl Serialize for Summary {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let Summary { scene, limits, motion, contact, support, energy, counters, .. } = self;
        let friction = Some(scene.contact.friction).filter(|friction| *friction > 0.0);
        let gap = Some(scene.stack.gap).filter(|_| scene.stack.plies > 1);
        let warnings = Some(&self.warnings).filter(|warnings| !warnings.is_empty());
        let rows = [
            ("ended_by", json!(self.ended_by)),
            ("steps", json!(counters.steps)),
            ("dt", json!(limits.dt)),
            ("dt_over_dt_crit", json!(limits.dt / limits.dt_crit)),
            ("time", json!(self.time)),
            ("initial_kinetic_energy", json!(self.initial_kinetic_energy)),
            ("friction_coefficient", json!(friction)),
            ("ply_gap", json!(gap)),
            ("initial_momentum", json!(scene.projectile.mass * length(scene.projectile.velocity))),
            ("residual_velocity", json!(motion.velocity)),
            ("residual_angular_velocity", json!(motion.angular_velocity)),
            ("absorbed", json!(contact.work)),
            ("support_work", json!(energy.support_work)),
            ("outcomes", json!(self.outcomes)),
            ("peak_force", json!(contact.force_peak)),
            ("force_window", json!(scene.force_window)),
            ("failed_segments", json!(counters.failed_segments)),
            ("segments", json!(scene.segments())),
            ("support_impulse", json!(support.total)),
            ("support_impulses", json!(support.attachments)),
            ("fabric_kinetic", json!(energy.fabric_kinetic)),
            ("strain", json!(energy.strain)),
            ("dissipated", json!(energy.dissipated)),
            ("viscous", json!(energy.viscous)),
            ("friction", json!(energy.friction)),
            ("ply_loss", json!(energy.ply_loss)),
            ("ply_penetration", json!(counters.ply_penetration)),
            ("plies", json!(self.plies)),
            ("casing_loss", json!(energy.casing_loss)),
            ("attachment", json!(energy.attachment)),
            ("contact_loss", json!(energy.contact_loss)),
            ("energy_residual", json!(energy.residual)),
            ("energy_residual_relative", json!(self.open_part())),
            ("momentum_residual", json!(self.momentum_residual)),
            ("worst_penetration", json!(counters.worst_penetration)),
            ("most_sweeps", json!(counters.most_sweeps)),
            ("unconverged", json!(counters.unconverged)),
            ("beyond_fine", json!(counters.beyond_fine)),
            ("digest", json!(self.digest)),
            ("warnings", json!(warnings)),
        ];
        serializer.collect_map(rows.into_iter().filter(|(_, value)| !value.is_null()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A single sheet without friction says nothing of plies and friction.
    #[test]
    fn what_is_on_is_named() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (11, 11);
        let summary = |scene: &Scene| {
            let mut buffers = crate::memory::Buffers::of(scene).unwrap();
            Summary::of(&buffers.sim(scene).unwrap(), OutcomeSet::NONE, 0.0).unwrap()
        };
        let plain = serde_json::to_string(&summary(&scene)).unwrap();
        assert!(!plain.contains("friction_coefficient") && !plain.contains("ply_gap"), "{plain}");
        (scene.contact.friction, scene.stack.plies, scene.stack.gap, scene.stack.turned) = (0.2, 3, 1e-4, true);
        (scene.back.plies, scene.back.modulus_mean, scene.back.critical_stretch) = (1, 9e10, 1.04);
        (scene.back.damage_slope, scene.back.damage_intercept) = (0.0, 2000.0);
        let found = summary(&scene);
        let text = serde_json::to_string(&found).unwrap();
        assert!(text.contains("\"friction_coefficient\":0.2,\"ply_gap\":0.0001"), "{text}");
        assert_eq!(found.plies.iter().map(|ply| ply.turned).collect::<Vec<_>>(), [false, true, false]);
        assert_eq!(found.plies[0].fabric, found.plies[1].fabric);
        assert!(found.plies[2].fabric.ends_with("90.0 GPa, fails from 4.00 %"), "{}", found.plies[2].fabric);
    }
}
