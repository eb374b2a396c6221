//! Random bodies and hits: no outcome before it is true, none missed.
//!
//! Method: a scene is drawn from its seed (fabric, attachment, body, motion, load; the numbers behind it are splitmix64's). It runs until it is
//! arrested, has exited or passed, and then goes on: the work must stay what it was when "exited" latched, and zero after
//! "passed". A run without an outcome so many steps behind its first contact is missed if over its last third nothing was touched, or work
//! of note did not change; but a load against the motion may bring the body back.
//! Limits: sheets of 31 to 61 nodes a side. What comes later than `AFTER` steps behind an outcome is not seen.

use super::flight::{changed, short};
use super::{Answer, Case};
use crate::Result;
use crate::memory::Buffers;
use fabric::Solid;
use fabric::internals::random::splitmix64;
use fabric::pose::{components, normalised};
use fabric::{AttachmentKind, Code, Drive, Outcome, Scene, Shape, Sim, math};

/// Seeds of the study.
const SEEDS: u64 = 200;
/// Seeds of a row.
const ROW: u64 = 20;
/// Seeds of the short form.
const SHORT: u64 = 8;
/// Steps behind the start, or the first contact, after which a run ends without an outcome.
const LIMIT: u64 = 800_000;
/// Steps for which a run goes on behind its outcome.
const AFTER: u64 = 60_000;
/// Steps between two looks.
const LOOK: u64 = 64;

/// Rows of the table: the short form, and all seeds.
pub fn rows() -> Vec<Case> {
    let short = std::iter::once((0, SHORT, false));
    let all = (0..SEEDS / ROW).map(|k| (ROW * k, ROW * (k + 1), true));
    short.chain(all).map(|(from, to, long)| row(from, to, long)).collect()
}

fn row(from: u64, to: u64, long: bool) -> Case {
    Case {
        theme: "Outcomes",
        name: format!("random hits, {}seeds {from} to {}", if long { "" } else { "short form, " }, to - 1),
        expected: "no outcome before it is true, none missed".to_string(),
        long,
        check: Box::new(move || check(from..to)),
    }
}

fn check(seeds: std::ops::Range<u64>) -> Result<Answer> {
    let (mut counts, mut wrong, mut worst) = ([0; 4], Vec::new(), 0.0_f64);
    for seed in seeds {
        match fly(seed)? {
            Verdict::True(outcome, part) => {
                counts[outcome] += 1;
                worst = worst.max(part);
            }
            Verdict::Open => counts[3] += 1,
            Verdict::Wrong(why) => wrong.push(format!("seed {seed} ({}): {why}", described(seed))),
        }
    }
    let [arrested, exited, passed, open] = counts;
    let counted = format!("{exited} exited, {arrested} arrested, {passed} passed, {open} still in contact");
    let happened = format!("{counted}; the work moved later by {} of what is allowed", short(worst));
    let happened = if wrong.is_empty() { happened } else { format!("{happened}; {}", wrong.join("; ")) };
    Ok(Answer::plain(happened, wrong.is_empty()))
}

/// What a run says of its outcome.
enum Verdict {
    /// Arrested (0), exited (1) or passed (2), and how far the work moved behind it, as part of what is allowed.
    True(usize, f64),
    /// No outcome, and rightly.
    Open,
    /// An outcome before it was true, one that was missed, or a failure.
    Wrong(String),
}

/// A scene in a few words.
fn described(seed: u64) -> String {
    let Some((scene, load)) = draw(seed) else { return String::new() };
    let (body, sheet) = (&scene.projectile, &scene.sheet);
    let way = if load == [0.0; 3] { "" } else { ", loaded" };
    let moved = if scene.drive == Drive::Free { "" } else { ", prescribed" };
    let speed = math::length(body.velocity);
    format!(
        "{:?}, {} x {} nodes, {} plies, {:?} of {} kg, {} m/s, {:.0} degrees off the normal{way}{moved}",
        scene.attachment.kind,
        sheet.nodes_x,
        sheet.nodes_y,
        sheet.plies,
        body.shape,
        short(body.mass),
        short(speed),
        math::atan2(math::length([body.velocity[0], body.velocity[1], 0.0]), body.velocity[2]).to_degrees()
    )
}

fn fly(seed: u64) -> Result<Verdict> {
    let Some((scene, load)) = draw(seed) else { return Err(format!("seed {seed} gives no scene").into()) };
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    if load != [0.0; 3] {
        sim.set_external_load(load, [0.0; 3])?;
    }
    let mask = Outcome::Arrested | Outcome::Exited | Outcome::Passed;
    let mut looks = Vec::new();
    while sim.step_count() < sim.outcomes().first_contact.unwrap_or(0) + LIMIT && !sim.outcomes().mask.has(mask) {
        if let Err(failure) = sim.advance(LOOK) {
            return Ok(Verdict::Wrong(format!("{failure} at step {}", sim.step_count())));
        }
        looks.push((sim.contact()?.work, sim.counters().contacts));
    }
    let (work, step) = (sim.contact()?.work, sim.step_count());
    let of_nodes = 4.0 * scene.lumped_mass() * dot(sim.projectile()?.velocity, sim.projectile()?.velocity);
    let allowed = f64::max(of_nodes, 0.01 * work.abs());
    let latched = sim.outcomes().mask;
    if !latched.has(mask) {
        let last = &looks[2 * looks.len() / 3..];
        let (low, high) = last.iter().fold((f64::MAX, f64::MIN), |(low, high), (w, _)| (low.min(*w), high.max(*w)));
        let over = last.iter().all(|(_, contacts)| *contacts == 0) || (work > 0.1 && high - low <= allowed);
        if !over || dot(load, scene.projectile.velocity) < 0.0 {
            return Ok(Verdict::Open);
        }
        let (motion, deflection) = (sim.projectile()?, sim.fabric()?.max_deflection);
        let [x, v] = [motion.position, motion.velocity].map(|v| v.map(short).join(" "));
        let sheet = format!("sheet within {} m", short(deflection));
        return Ok(Verdict::Wrong(format!("no outcome, {} J for long; at {x} m, {v} m/s, {sheet}", short(work))));
    }
    if latched.has(Outcome::Arrested) {
        return arrest(&scene, &sim);
    }
    let exited = latched.has(Outcome::Exited);
    let allowed = if exited { allowed } else { 0.0 };
    let mut moved = 0.0_f64;
    while sim.step_count() < step + AFTER {
        if sim.advance(LOOK).is_err() {
            break;
        }
        moved = moved.max((sim.contact()?.work - work).abs());
    }
    let name = if exited { "exited" } else { "passed" };
    Ok(if moved > allowed {
        Verdict::Wrong(format!("{name} at step {step} with {} J, {} J later", short(work), short(moved)))
    } else {
        Verdict::True(if exited { 1 } else { 2 }, if exited { moved / allowed } else { 0.0 })
    })
}

/// Arrested: the body has been in contact and no longer moves along its first direction.
fn arrest(scene: &Scene, sim: &Sim<'_>) -> Result<Verdict> {
    let along = dot(scene.projectile.velocity, sim.projectile()?.velocity);
    let touched = sim.outcomes().first_contact.is_some() && sim.contact()?.impulse != [0.0; 3];
    Ok(if along <= 0.0 && touched {
        Verdict::True(0, 0.0)
    } else {
        Verdict::Wrong("arrested while it moves on".to_string())
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Numbers in a fixed order behind a seed.
struct Numbers {
    seed: u64,
    drawn: u64,
}

impl Numbers {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.drawn += 1;
        (splitmix64(splitmix64(self.seed) ^ (self.drawn << 32)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Evenly over the orders of magnitude.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * math::exp(self.next() * math::ln(high / low))
    }

    fn choice<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.next() * choices.len() as f64) as usize]
    }

    fn orientation(&mut self) -> [f64; 4] {
        components(&normalised(std::array::from_fn(|_| self.between(-1.0, 1.0))))
    }
}

/// The scene of a seed and the load on its body, N. A draw that a corner disc forbids is drawn again.
fn draw(seed: u64) -> Option<(Scene, [f64; 3])> {
    let mut numbers = Numbers { seed, drawn: 0 };
    (0..100).map(|_| scene(seed, &mut numbers)).find(|(scene, _)| match scene.check() {
        Ok(()) => true,
        Err(error) => error.code != Code::DiscTouchesProjectile,
    })
}

fn scene(seed: u64, numbers: &mut Numbers) -> (Scene, [f64; 3]) {
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
        let direction = [math::sin(angle) * math::cos(turn), math::sin(angle) * math::sin(turn), math::cos(angle)];
        let size = numbers.scale(5.0, 400.0);
        body.velocity = direction.map(|x| size * x);
        let height = Solid::of(body).reach() + 1e-4;
        let aim = half.map(|half| half * numbers.between(-1.3, 1.3));
        body.position =
            [aim[0] - direction[0] / direction[2] * height, aim[1] - direction[1] / direction[2] * height, -height];
        // A load that would stop the body within 50 mm or more, forwards or backwards.
        let push = numbers.choice(&[0.0, 0.0, 0.0, 1.0, -1.0]) * numbers.scale(0.01, 1.0);
        load = if scene.drive == Drive::Free {
            direction.map(|x| push * body.mass * size * size / 0.1 * x)
        } else {
            [0.0; 3]
        };
    });
    (scene, load)
}
