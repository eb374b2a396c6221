//! A row that runs one scene: what it starts from, how long it runs, and what must be true at its end.

use super::{Answer, Balances, Case, fmu};
use crate::Result;
use crate::event::{Summary, mask_of};
use crate::memory::Buffers;
use fabric::Solid;
use fabric::math::length;
use fabric::pose::into_body;
use fabric::pose::{Vector, components, normalised};
use fabric::{Fabric, Failure, Outcome, Scene, Sim, StepCheck, TimeStep, math};

/// What a run ended with, for its check.
pub struct Ended<'a> {
    /// Read-outs.
    pub summary: &'a Summary,
    /// Deflection and stretch.
    pub fabric: Fabric,
    /// The simulation; reset after a failure.
    pub sim: &'a Sim<'a>,
    /// The failure that ended the run.
    pub failure: Option<Failure>,
    /// How well the balances closed.
    pub balances: Balances,
    /// Fastest spin of the projectile, rad/s, seen every 64 steps.
    pub spin: f64,
}

impl Ended<'_> {
    /// Within a part of what is expected.
    pub fn near(value: f64, expected: f64, part: f64) -> bool {
        (value - expected).abs() <= part * expected.abs()
    }

    /// This outcome latched and no other.
    pub fn only(&self, outcome: Outcome) -> bool {
        self.summary.outcomes.len() == 1 && self.latched(outcome)
    }

    /// This outcome latched.
    pub fn latched(&self, outcome: Outcome) -> bool {
        self.summary.latched(outcome).is_some()
    }

    /// Energy within 1 % of that at the start, momentum to rounding.
    pub fn closed(&self) -> bool {
        self.balances.energy.abs() < 0.01 && self.balances.momentum < 1e-9
    }

    /// The same, and every contact solve converged.
    pub fn sound(&self) -> bool {
        self.closed() && self.summary.unconverged == 0
    }

    /// No node ever deeper in the projectile than this, m.
    pub fn outside(&self, depth: f64) -> bool {
        self.summary.worst_penetration <= depth
    }

    /// How deep a node may get because the body turns, m. Contact is exact for a body that only moves; a turn by w dt leaves in
    /// every step an error of second order, w dt (reach w dt/2 + v dt), which nothing takes back. v, along the surface: that of
    /// the body and of a yarn's end that recoils at c (U_c - 1), c^2 = E A h/m, when the yarn breaks.
    pub fn turning_allows(&self) -> f64 {
        let (scene, summary) = (self.sim.scene(), self.summary);
        let reach = Solid::of(&scene.projectile).reach();
        let (sheet, yarn) = (&scene.sheet, &scene.yarn);
        let wave = math::sqrt(yarn.modulus_mean * sheet.yarn_area * sheet.spacing / sheet.node_mass);
        let along = length(scene.projectile.velocity) + wave * (yarn.critical_stretch - 1.0);
        summary.time * summary.dt * self.spin * (0.5 * reach * self.spin + along) + 1e-12 * reach
    }
}

type Check = Box<dyn Fn(&Ended<'_>) -> bool + Sync + Send>;
type Text = Box<dyn Fn(&Ended<'_>) -> String + Sync + Send>;
/// Changes a fresh simulation before its first step.
pub type Prepare = fn(&mut Sim<'_>) -> Result<()>;

/// A run of a scene and what must be true at its end.
pub struct Flight {
    pub name: String,
    pub expected: String,
    /// Left out of the short form.
    pub long: bool,
    pub scene: Scene,
    /// Motion or damage given by hand: no host of an FMU can do that.
    pub prepare: Option<Prepare>,
    /// Force on the projectile, N.
    pub force: [f64; 3],
    /// Outcomes that end the run.
    pub until: &'static [Outcome],
    /// Steps after which it ends in any case.
    pub steps: u64,
    pub check: Check,
    pub text: Text,
}

impl Flight {
    /// A run until arrest, exit or pass.
    pub fn new(
        name: impl Into<String>,
        expected: impl Into<String>,
        scene: Scene,
        steps: u64,
        check: impl Fn(&Ended<'_>) -> bool + Sync + Send + 'static,
    ) -> Flight {
        Flight {
            name: name.into(),
            expected: expected.into(),
            long: false,
            scene,
            prepare: None,
            force: [0.0; 3],
            until: &[Outcome::Arrested, Outcome::Exited, Outcome::Passed],
            steps,
            check: Box::new(check),
            text: Box::new(ending),
        }
    }

    /// As a row of the table.
    pub fn case(self, theme: &'static str) -> Case {
        let (name, expected, long) = (self.name.clone(), self.expected.clone(), self.long);
        Case { theme, name, expected, long, check: Box::new(move || self.fly()) }
    }

    fn fly(&self) -> Result<Answer> {
        let mut buffers = Buffers::of(&self.scene)?;
        let mut sim = buffers.sim(&self.scene)?;
        if let Some(prepare) = self.prepare {
            prepare(&mut sim)?;
        }
        if self.force != [0.0; 3] {
            sim.set_external_load(self.force, [0.0; 3])?;
        }
        let start = scale(&sim)?;
        let mask = mask_of(self.until);
        let (mut failure, mut spin) = (None, 0.0);
        while failure.is_none() && sim.step_count() < self.steps && !sim.outcomes().mask.has(mask) {
            failure = sim.advance_until(mask, (self.steps - sim.step_count()).min(64)).err();
            spin = sim.projectile().map_or(spin, |motion| length(motion.angular_velocity).max(spin));
        }
        let fmu = if self.prepare.is_none() { fmu::case(&mut sim, self.force, self.steps)? } else { None };
        if failure.is_some() {
            // Read-outs refuse after a failure; a fresh simulation stands for them.
            sim.reset();
        }
        let summary = Summary::of(&sim, mask)?;
        let balances = Balances::of(&summary, start);
        let numbers = [summary.absorbed, summary.energy_residual, summary.momentum_residual, summary.fabric_kinetic];
        let finite = numbers.iter().chain(&summary.residual_velocity).all(|value| value.is_finite());
        let fabric = sim.fabric()?;
        let end = Ended { summary: &summary, fabric, sim: &sim, failure, balances, spin };
        let pass = finite && (self.check)(&end);
        let happened = failure.map_or_else(|| (self.text)(&end), |failure| format!("FAULTED: {failure}"));
        Ok(Answer { happened, pass, balances: failure.is_none().then_some(balances), fmu })
    }
}

/// What residuals are measured by: the kinetic energy of projectile and fabric, or the strain energy if they are at rest, J.
pub fn scale(sim: &Sim<'_>) -> Result<f64> {
    let energy = sim.energy()?;
    let kinetic = energy.projectile_kinetic + energy.fabric_kinetic;
    Ok(if kinetic > 1e-9 * energy.strain { kinetic } else { energy.strain })
}

/// How the run ended, in a few words.
pub fn ending(end: &Ended<'_>) -> String {
    let summary = end.summary;
    let (speed, absorbed) = (short(summary.residual_velocity[2]), short(summary.absorbed));
    format!("{}, v {speed} m/s, absorbed {absorbed} J, {} failed", summary.ended_by, summary.failed_segments)
}

/// The energy residual in percent, and how the run ended.
pub fn percent(end: &Ended<'_>) -> String {
    format!("{:+.2} % energy; {}", 100.0 * end.balances.energy, ending(end))
}

/// A number with about four figures.
pub fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_string(),
        size if (1e-2..1e5).contains(&size) => format!("{x:.3}"),
        _ => format!("{x:.3e}"),
    }
}

// ---- scenes ----

/// A square uniform sheet, four sides held, under the 8.4 g sphere.
pub fn uniform(nodes: u32, speed: f64) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nodes, nodes);
    scene.yarn.stochastic = false;
    scene.projectile.velocity = [0.0, 0.0, speed];
    scene
}

/// Speed of the preset sphere with this kinetic energy, m/s.
pub fn speed(energy: f64) -> f64 {
    math::sqrt(2.0 * energy / Scene::sheet_3in_sphere().projectile.mass)
}

/// A changed scene.
pub fn changed(mut scene: Scene, change: impl FnOnce(&mut Scene)) -> Scene {
    change(&mut scene);
    scene
}

/// This fraction of dt_crit, whatever the limit.
pub fn unchecked(scene: Scene, fraction: f64) -> Scene {
    changed(scene, |scene| {
        scene.time_step = TimeStep::fraction(fraction);
        scene.step_check = StepCheck::None;
    })
}

/// A sheet, four sides held, that no projectile comes near.
pub fn far(nodes: u32) -> Scene {
    changed(uniform(nodes, 0.0), |scene| scene.projectile.position[2] = -1.0)
}

/// The projectile turned about an axis (any length) by an angle, rad, its foremost point on the sheet's plane.
pub fn turned(scene: Scene, axis: [f64; 3], angle: f64) -> Scene {
    changed(scene, |scene| {
        let (cosine, sine) = (math::cos(0.5 * angle), math::sin(0.5 * angle) / math::length(axis));
        let q = normalised([cosine, sine * axis[0], sine * axis[1], sine * axis[2]]);
        let body = &mut scene.projectile;
        body.orientation = components(&q);
        body.position[2] = -Solid::of(body).support(&into_body(&q, &Vector::new(0.0, 0.0, 1.0)));
    })
}

/// Every position times `factor`, at rest.
pub fn stretch(sim: &mut Sim<'_>, factor: f64) -> Result<()> {
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    positions.iter_mut().for_each(|x| *x *= factor);
    let velocities = vec![0.0; positions.len()];
    Ok(sim.set_motion(&positions, &velocities)?)
}
