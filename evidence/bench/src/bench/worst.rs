//! The worst step: random bodies as large as the sheet, which is what contact takes longest for.

use super::Bench;
use crate::Result;
use crate::machine::Clock;
use crate::memory::Buffers;
use fabric_kernel::{AttachmentKind, Scene, Shape};

/// Scenes that are tried.
const SCENES: u64 = 60;
/// Steps of each, from just before the first contact.
const STEPS: u64 = 150;

/// Numbers that are the same in every search.
struct Draws(u64);

impl Draws {
    /// In [0, 1): a linear congruential generator, the upper half of its bits.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as f64 / (1u64 << 32) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(self.next() * all.len() as f64) as usize]
    }
}

/// A body of some size of the sheet, flat or tilted, of ten milligrams to three kilograms, just short of 105
/// x 105 nodes.
fn scene(draws: &mut Draws) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    scene.yarn.stochastic = false;
    let kinds = [AttachmentKind::TwoSides, AttachmentKind::FourSides, AttachmentKind::FourSides, AttachmentKind::Free];
    scene.attachment.kind = draws.one_of(&kinds);
    scene.contact.friction = draws.one_of(&[0.0, 0.0, 0.1, 0.3, 1.0, 10.0]);
    let (h, wide) = (scene.sheet.spacing, scene.sheet.spacing * f64::from(scene.sheet.nodes_x));
    let body = &mut scene.projectile;
    body.shape = draws.one_of(&[Shape::Box, Shape::Box, Shape::Box, Shape::Cylinder, Shape::Sphere]);
    body.mass = 10f64.powf(draws.between(-5.0, 0.5));
    body.size = [wide * draws.between(0.5, 1.5), wide * draws.between(0.5, 1.5), h * draws.between(2.0, 30.0)];
    body.radius = wide * draws.between(0.5, 3.0);
    body.length = body.radius * draws.between(0.1, 1.0);
    let (tilt, about) = (
        draws.one_of(&[0.0, 1e-4, 1e-3, 1e-2, 0.1]) * draws.between(0.5, 1.5),
        draws.between(0.0, std::f64::consts::TAU),
    );
    let (half, rim) = match body.shape {
        Shape::Box => (0.5 * body.size[2], 0.5 * body.size[0].hypot(body.size[1])),
        _ => (0.5 * body.length, body.radius),
    };
    let depth = half * tilt.cos() + rim.min(0.75 * wide) * tilt.sin();
    body.position = [0.0, 0.0, -1e-7 - if body.shape == Shape::Sphere { body.radius } else { depth }];
    body.orientation = [(0.5 * tilt).cos(), about.cos() * (0.5 * tilt).sin(), about.sin() * (0.5 * tilt).sin(), 0.0];
    let speed = 10f64.powf(draws.between(-0.5, 2.0));
    body.velocity = [speed * draws.between(-0.5, 0.5), speed * draws.between(-0.5, 0.5), speed];
    let spin = draws.one_of(&[0.0, 0.0, 1.0]) * speed / wide;
    body.angular_velocity = [0, 1, 2].map(|_| spin * draws.between(-1.0, 1.0));
    scene
}

/// The longest step of all, without friction and with it, and what contact did in the scene that has it.
pub fn measure(bench: &mut Bench) -> Result<()> {
    let report = &mut bench.report;
    let mut worst = [(0.0, 0, 0); 2];
    let (mut draws, mut given_up) = (Draws(1), 0);
    for _ in 0..SCENES {
        let scene = scene(&mut draws);
        let mut buffers = Buffers::of(&scene)?;
        let mut sim = buffers.sim(&scene)?;
        let mut longest: f64 = 0.0;
        for _ in 0..STEPS {
            let clock = Clock::start();
            // A light body may become too fast: that ends it, as it would a run.
            if sim.step().is_err() {
                break;
            }
            longest = longest.max(clock.seconds());
        }
        let (counters, kind) = (sim.counters(), usize::from(scene.contact.friction > 0.0));
        given_up += counters.unconverged;
        if longest > worst[kind].0 {
            worst[kind] = (longest, counters.most_sweeps, counters.most_candidates);
        }
    }
    for (name, (seconds, sweeps, candidates)) in ["without friction", "with friction"].into_iter().zip(worst) {
        let name = format!("worst step of {SCENES} scenes, 105 x 105, {name}");
        report.figure("worst", name.clone(), 1e3 * seconds, "ms");
        report.figure("worst", format!("{name}: most sweeps and passes of a solve"), sweeps as f64, "");
        report.figure("worst", format!("{name}: most candidates"), candidates as f64, "");
    }
    report.figure("worst", "contact solves given up", given_up as f64, "");
    Ok(())
}
