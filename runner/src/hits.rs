//! Shots of an ensemble: where they strike, and whether they go through. `evidence/hits.py` has the same for the evidence.

use crate::Result;
use crate::memory::Buffers;
use fabric::Solid;
use fabric::internals::random::splitmix64;
use fabric::{Outcome, Scene};

/// The scene with this velocity, its projectile against the sheet at a place in the middle cell that `hit` draws, as other draws.
pub fn shot(scene: &Scene, velocity: f64, hit: u64) -> Scene {
    let mut scene = *scene;
    let part = |k: u64| (splitmix64(2 * hit + k) >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
    let [h_x, h_y] = scene.spacings();
    let reach = Solid::of(&scene.projectile).support(&[0.0, 0.0, 1.0].into());
    scene.seed += hit;
    scene.projectile.position = [part(0) * h_x, part(1) * h_y, -reach];
    scene.projectile.velocity = [0.0, 0.0, velocity];
    scene
}

/// Runs an impact to its outcome; after so many seconds it is given up. Whether the projectile went through; of a run that was given
/// up, whether it still moves on with 5 % of its velocity.
pub fn goes_through(scene: &Scene, longest: f64) -> Result<bool> {
    let mut buffers = Buffers::of(scene)?;
    let mut sim = buffers.sim(scene)?;
    let ends = Outcome::Arrested | Outcome::Exited | Outcome::Detached;
    sim.advance_until(ends, (longest / sim.step_limits().dt) as u64)?;
    let (velocity, outcomes) = (sim.projectile()?.velocity[2], sim.outcomes().mask);
    let ended = outcomes.has(ends);
    Ok(if ended { !outcomes.has(Outcome::Arrested) } else { velocity > 0.05 * scene.projectile.velocity[2] })
}
