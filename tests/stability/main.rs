//! Extreme scenes that are accepted, each with what must come of it: nothing may end in a silent wrong
//! answer, a panic, a hang or a NaN.
//!
//! What is refused stands in `tests/src/inputs.rs`; the map of time step against velocity is
//! `python -m evidence stability`.
#![allow(clippy::disallowed_methods)] // Expected values may come from the host's own functions.

mod bodies;
mod outcomes;
mod sheets;
mod sides;
mod signs;

use fabric_kernel::pose::{Vector, components, into_body, normalised};
use fabric_kernel::{Contact, Counters, Energy, Failure, Motion, Outcome, OutcomeSet, Scene, Sim, Solid};
use fabric_tests::{memory_of, reference::length};
use rayon::prelude::*;

/// What counts as none inside a sphere, m.
const ROUNDING: f64 = 1e-12 * 6.35e-3;

/// A run of a scene and what must be true at its end.
struct Row {
    name: String,
    /// In words.
    expected: &'static str,
    scene: Scene,
    prepare: fn(&mut Sim<'_>),
    /// Outcomes that end the run.
    until: OutcomeSet,
    /// Steps after which it ends in any case.
    steps: u64,
    check: Box<dyn Fn(&End<'_>) -> bool + Sync + Send>,
}

/// A run until arrest, exit or pass.
fn row(
    name: impl Into<String>,
    expected: &'static str,
    scene: Scene,
    steps: u64,
    check: impl Fn(&End<'_>) -> bool + Sync + Send + 'static,
) -> Row {
    Row { name: name.into(), expected, scene, prepare: |_| {}, until: OutcomeSet::ENDS, steps, check: Box::new(check) }
}

impl Row {
    /// Row without an outcome that ends it.
    fn for_its_steps(self) -> Row {
        Row { until: OutcomeSet::NONE, ..self }
    }

    /// What is wrong with the run, if anything is.
    fn miss(&self) -> Option<String> {
        let mut memory = memory_of(&self.scene);
        let mut sim = Sim::new(&self.scene, &mut memory).unwrap();
        (self.prepare)(&mut sim);
        let found = match self.run(&mut sim) {
            Ok(end) if end.finite() && (self.check)(&end) => return None,
            Ok(end) => end.in_words(),
            Err(failure) => format!("{failure}, in step {}", sim.step_count()),
        };
        Some(format!("{}: expected {}; found {found}", self.name, self.expected))
    }

    fn run<'a>(&self, sim: &'a mut Sim<'_>) -> Result<End<'a>, Failure> {
        let start = sim.energy()?;
        let kinetic = start.projectile_kinetic + start.fabric_kinetic;
        // A sheet that starts taut and at rest has its strain energy alone.
        let energy = if kinetic > 1e-9 * start.strain { kinetic } else { start.strain };
        let momentum = self.scene.projectile.mass * length(self.scene.projectile.velocity);
        let mut spin: f64 = 0.0;
        while sim.step_count() < self.steps && !sim.outcomes().mask.has(self.until) {
            sim.advance_until(self.until, (self.steps - sim.step_count()).min(64))?;
            spin = spin.max(length(sim.projectile()?.angular_velocity));
        }
        let over = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { value };
        let now = sim.energy()?;
        Ok(End {
            off: [over(now.residual, energy), over(length(sim.momentum_residual()?), momentum)],
            contact: sim.contact()?,
            counters: sim.counters(),
            body: sim.projectile()?,
            energy: now,
            spin,
            sim,
        })
    }
}

/// What a run ended with.
struct End<'a> {
    /// What energy and momentum do not close by, over what there was at the start; as they are where that is
    /// 0.
    off: [f64; 2],
    energy: Energy,
    contact: Contact,
    counters: Counters,
    body: Motion,
    /// Fastest spin of the projectile, rad/s, seen every 64 steps.
    spin: f64,
    sim: &'a Sim<'a>,
}

impl End<'_> {
    fn finite(&self) -> bool {
        let all = self.off.iter().chain([&self.energy.fabric_kinetic, &self.contact.work]).chain(&self.body.velocity);
        all.into_iter().all(|value| value.is_finite())
    }

    fn in_words(&self) -> String {
        let Counters { failed_segments, unconverged, worst_penetration, steps, .. } = self.counters;
        let latched: Vec<_> = Outcome::ALL.iter().filter(|outcome| self.latched(**outcome)).map(|o| o.name()).collect();
        format!(
            "{latched:?} after {steps} steps, v {:?} m/s, absorbed {:.4e} J, {failed_segments} failed, off by {:.1e} of the energy and \
             {:.1e} of the momentum, {worst_penetration:.1e} m deep, {unconverged} unconverged",
            self.body.velocity, self.contact.work, self.off[0], self.off[1]
        )
    }

    fn latched(&self, outcome: Outcome) -> bool {
        self.sim.outcomes().mask.has(outcome)
    }

    /// This outcome and no other.
    fn only(&self, outcome: Outcome) -> bool {
        self.sim.outcomes().mask == outcome
    }

    /// Energy within 1 %, momentum to rounding.
    fn closed(&self) -> bool {
        self.off[0].abs() < 0.01 && self.off[1] < 1e-9
    }

    /// Whether balances close and every contact solve converged.
    fn sound(&self) -> bool {
        self.closed() && self.counters.unconverged == 0
    }

    /// Closed, and under 1 % of the contact solves given up: counted, no error.
    fn few_given_up(&self) -> bool {
        self.closed() && self.counters.unconverged < self.counters.steps.div_ceil(100)
    }

    /// No node ever deeper in the projectile than this, m.
    fn outside(&self, depth: f64) -> bool {
        self.counters.worst_penetration <= depth
    }

    /// How deep a node may get because the body turns, m. Contact is exact for a body that only moves; a turn
    /// by w dt leaves in every step an error of second order, w dt (reach w dt/2 + v dt), which nothing takes
    /// back. v, along the surface: that of the body and of a yarn's end that recoils at c (U_c - 1), c^2 = E
    /// A h/m, when the yarn breaks.
    fn turning_allows(&self) -> f64 {
        let scene = self.sim.scene();
        let (sheet, yarn, reach) = (&scene.sheet, &scene.yarn, Solid::of(&scene.projectile).reach());
        let wave = (yarn.modulus_mean * sheet.yarn_area * sheet.spacing / sheet.node_mass).sqrt();
        let along = length(scene.projectile.velocity) + wave * (yarn.critical_stretch - 1.0);
        let step = self.sim.step_limits().dt;
        self.sim.time() * step * self.spin * (0.5 * reach * self.spin + along) + 1e-12 * reach
    }
}

/// Within a part of what is expected.
fn near(value: f64, expected: f64, part: f64) -> bool {
    (value - expected).abs() <= part * expected.abs()
}

/// Runs every row, and names each that misses.
fn all(rows: Vec<Row>) {
    let missed: Vec<String> = rows.par_iter().filter_map(Row::miss).collect();
    assert!(missed.is_empty(), "{} of {} rows:\n{}", missed.len(), rows.len(), missed.join("\n"));
}

/// A changed scene.
fn changed(mut scene: Scene, change: impl FnOnce(&mut Scene)) -> Scene {
    change(&mut scene);
    scene
}

/// The projectile turned about an axis (any length) by an angle, rad, its foremost point on the sheet's
/// plane.
fn turned(scene: Scene, axis: [f64; 3], angle: f64) -> Scene {
    changed(scene, |scene| {
        let (sine, cosine) = (0.5 * angle).sin_cos();
        let [x, y, z] = axis.map(|part| sine * part / length(axis));
        let q = normalised([cosine, x, y, z]);
        let body = &mut scene.projectile;
        body.orientation = components(&q);
        body.position[2] = -Solid::of(body).support(&into_body(&q, &Vector::new(0.0, 0.0, 1.0)));
    })
}

/// Every position times `factor`, at rest.
fn stretch(sim: &mut Sim<'_>, factor: f64) {
    let x: Vec<f64> = fabric_tests::positions(sim).into_iter().flatten().map(|x| x * factor).collect();
    sim.set_motion(&x, &vec![0.0; x.len()]).unwrap();
}
