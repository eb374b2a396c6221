//! Random bodies and hits: no outcome before it is true, none missed.
//!
//! A scene is drawn from its seed (fabric, attachment, body, motion, load). It runs until it is arrested, has
//! exited or passed, and then goes on: the work must stay what it was when "exited" or "rebounded" latched,
//! and zero after "passed". A run without an outcome so many steps after its first contact is missed if over
//! its last third nothing was touched, or work of note did not change; but a load against the motion may
//! bring the body back. What comes later than `AFTER` steps after an outcome is not seen.

use crate::changed;
use fabric_kernel::internals::random::splitmix64;
use fabric_kernel::pose::{components, normalised};
use fabric_kernel::{AttachmentKind, Code, Drive, Outcome, OutcomeSet, Scene, Shape, Sim, Solid};
use fabric_tests::memory_of;
use fabric_tests::reference::{V3, dot};
use rayon::prelude::*;

/// Steps after the start, or the first contact, after which a run ends without an outcome.
const LIMIT: u64 = 800_000;
/// Steps for which a run goes on after its outcome.
const AFTER: u64 = 60_000;
/// Steps between two looks.
const LOOK: u64 = 64;

// The body of seed 0 stays on the sheet for all of `LIMIT`.
#[test]
fn random_hits_end_when_they_are_over() {
    check(1..8);
}

#[test]
#[ignore = "minutes; cargo xtask verify runs it"]
fn more_random_hits() {
    check(0..1);
    check(8..200);
}

fn check(seeds: std::ops::Range<u64>) {
    let shots: Vec<_> = seeds.into_par_iter().map(|seed| (seed, fly(seed))).collect();
    let wrong = shots.iter().filter_map(|(seed, end)| Some(format!("seed {seed}: {}", end.as_ref().err()?)));
    let wrong: Vec<_> = wrong.collect();
    for outcome in Outcome::ALL.map(Some).into_iter().chain([None]) {
        let count = shots.iter().filter(|(_, end)| *end == Ok(outcome)).count();
        println!("{count} {}", outcome.map_or("still in contact", Outcome::name));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The outcome that came, and rightly; or what is wrong: one before it was true, one that was missed, or a
/// failure.
fn fly(seed: u64) -> Result<Option<Outcome>, String> {
    let (scene, load) = draw(seed);
    let mut memory = memory_of(&scene);
    let mut sim = Sim::new(&scene, &mut memory).unwrap();
    if load != [0.0; 3] {
        sim.set_external_load(load, [0.0; 3]).unwrap();
    }
    let mask = OutcomeSet::ENDS;
    let mut looks = Vec::new();
    while sim.step_count() < sim.outcomes().first_contact.unwrap_or(0) + LIMIT && !sim.outcomes().mask.has(mask) {
        sim.advance(LOOK).map_err(|failure| format!("{failure} at step {}", sim.step_count()))?;
        looks.push((work(&sim), sim.counters().contacts));
    }
    let (at, step, velocity) = (work(&sim), sim.step_count(), sim.projectile().unwrap().velocity);
    let of_nodes = 4.0 * scene.lumped_mass() * dot(velocity, velocity);
    let allowed = f64::max(of_nodes, 0.01 * at.abs());
    let latched = sim.outcomes().mask;
    if !latched.has(mask) {
        let last = &looks[2 * looks.len() / 3..];
        let (low, high) = last.iter().fold((f64::MAX, f64::MIN), |(low, high), (w, _)| (low.min(*w), high.max(*w)));
        let over = last.iter().all(|(_, contacts)| *contacts == 0) || (at > 0.1 && high - low <= allowed);
        if !over || dot(load, scene.projectile.velocity) < 0.0 {
            return Ok(None);
        }
        let place = sim.projectile().unwrap().position;
        return Err(format!("no outcome, {at:e} J for long; at {place:?} m, {velocity:?} m/s"));
    }
    if latched.has(Outcome::Arrested) {
        // It has been in contact and no longer moves along its first direction.
        let touched = sim.outcomes().first_contact.is_some() && sim.contact().unwrap().impulse != [0.0; 3];
        let stopped = dot(scene.projectile.velocity, velocity) <= 0.0;
        return if stopped && touched { Ok(Some(Outcome::Arrested)) } else { Err("arrested while it moves on".into()) };
    }
    let over = [Outcome::Exited, Outcome::Rebounded].into_iter().find(|outcome| latched.has(*outcome));
    let (outcome, allowed) = over.map_or((Outcome::Passed, 0.0), |outcome| (outcome, allowed));
    let mut moved = 0.0_f64;
    while sim.step_count() < step + AFTER && sim.advance(LOOK).is_ok() {
        moved = moved.max((work(&sim) - at).abs());
    }
    let early = format!("{} at step {step} with {at:e} J, {moved:e} J later", outcome.name());
    if moved > allowed { Err(early) } else { Ok(Some(outcome)) }
}

fn work(sim: &Sim<'_>) -> f64 {
    sim.contact().unwrap().work
}

/// Numbers in a fixed order from a seed.
pub(crate) struct Numbers {
    pub(crate) seed: u64,
    pub(crate) drawn: u64,
}

impl Numbers {
    /// From 0 to 1.
    pub(crate) fn next(&mut self) -> f64 {
        self.drawn += 1;
        (splitmix64(splitmix64(self.seed) ^ (self.drawn << 32)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Evenly over the orders of magnitude.
    pub(crate) fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * fabric_kernel::math::exp(self.next() * fabric_kernel::math::ln(high / low))
    }

    pub(crate) fn choice<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.next() * choices.len() as f64) as usize]
    }

    pub(crate) fn orientation(&mut self) -> [f64; 4] {
        components(&normalised(std::array::from_fn(|_| self.between(-1.0, 1.0))))
    }
}

/// The scene of a seed and the load on its body, N. A draw that a corner disc forbids is drawn again.
fn draw(seed: u64) -> (Scene, V3) {
    let mut numbers = Numbers { seed, drawn: 0 };
    loop {
        let (scene, load) = scene(seed, &mut numbers);
        if !scene.check().is_err_and(|error| error.code == Code::DiscTouchesProjectile) {
            return (scene, load);
        }
    }
}

fn scene(seed: u64, numbers: &mut Numbers) -> (Scene, V3) {
    let mut load = [0.0; 3];
    let scene = changed(Scene::sheet_3in_sphere(), |scene| {
        scene.seed = seed;
        scene.sheet.nodes_x = numbers.between(31.0, 62.0) as u32;
        scene.sheet.nodes_y = numbers.between(31.0, 62.0) as u32;
        scene.sheet.plies = numbers.choice(&[1, 2, 3]);
        scene.yarn.stochastic = numbers.choice(&[true, false]);
        let attachment = &mut scene.attachment;
        attachment.kind = numbers.choice(&[
            AttachmentKind::TwoSides,
            AttachmentKind::FourSides,
            AttachmentKind::FourCorners,
            AttachmentKind::Free,
        ]);
        (attachment.disc_inset, attachment.disc_radius) = (3e-3, numbers.between(1e-3, 2.5e-3));
        scene.drive = if numbers.next() < 0.1 { Drive::Prescribed } else { Drive::Free };

        let half = scene.half_size();
        let body = &mut scene.projectile;
        body.shape = numbers.choice(&[Shape::Sphere, Shape::Cylinder, Shape::HemisphericalCylinder, Shape::Box]);
        body.radius = numbers.scale(2e-3, 6.35e-3);
        body.length = body.radius * numbers.between(2.0, 6.0);
        body.size = [numbers.scale(3e-3, 3e-2), numbers.scale(2e-3, 1e-2), numbers.scale(2e-3, 1e-2)];
        body.mass = numbers.scale(5e-4, 5.0);
        body.orientation = if numbers.next() < 0.7 { numbers.orientation() } else { body.orientation };
        let spin = if numbers.next() < 0.7 { numbers.scale(10.0, 3000.0) } else { 0.0 };
        let [_, x, y, z] = numbers.orientation();
        body.angular_velocity = [spin * x, spin * y, spin * z];

        // From straight down to 85 degrees from it; some miss the sheet.
        let angle = if numbers.next() < 0.7 { numbers.between(0.0, 1.48) } else { 0.0 };
        let turn = numbers.between(0.0, std::f64::consts::TAU);
        let [(sine, cosine), (across, along)] =
            [angle, turn].map(|angle| (fabric_kernel::math::sin(angle), fabric_kernel::math::cos(angle)));
        let direction = [sine * along, sine * across, cosine];
        let size = numbers.scale(5.0, 400.0);
        body.velocity = direction.map(|x| size * x);
        let height = Solid::of(body).reach() + 1e-4;
        let aim = half.map(|half| half * numbers.between(-1.3, 1.3));
        body.position =
            [aim[0] - direction[0] / direction[2] * height, aim[1] - direction[1] / direction[2] * height, -height];
        // A load that would stop the body within 50 mm or more, forwards or backwards.
        let push = numbers.choice(&[0.0, 0.0, 0.0, 1.0, -1.0]) * numbers.scale(0.01, 1.0);
        if scene.drive == Drive::Free {
            load = direction.map(|x| push * body.mass * size * size / 0.1 * x);
        }
    });
    (scene, load)
}
