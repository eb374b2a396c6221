//! Ballistic limits: the velocity between arrest and perforation, found by bisection for each of several hits.
//!
//! Hits differ by where in a cell of the network the projectile's axis strikes: the sheets have no scatter of their own, and the place
//! is what a shot does not control. Each hit has a limit of its own; their mean stands for V50 and Student's interval for its error.
//! Limit: beyond the first failure the model is chaotic, so the limit of one hit is one sample; bisection finds one of its crossings.

use crate::Result;
use crate::event::mask_of;
use crate::memory::Buffers;
use fabric::random::splitmix64;
use fabric::shape::Solid;
use fabric::{Outcome, Scene};

/// Time after which an impact is given up, s.
const LONGEST: f64 = 2e-3;
/// Stride of the search for an arrest below and a perforation above, and width at which bisection ends, in parts of the velocity.
const STRIDE: f64 = 1.25;
const WIDTH: f64 = 1.01;

/// What an impact ended with.
pub struct Impact {
    /// Work on the fabric, J.
    pub absorbed: f64,
    /// Whether the projectile went through; of a run that was given up, whether it still moves on with 5 % of its velocity.
    pub through: bool,
    /// What the energy balance does not close by, in parts of the impact energy.
    pub residual: f64,
}

/// The scene with this velocity, its projectile against the sheet at a place in the middle cell that `hit` draws.
pub fn shot(scene: &Scene, velocity: f64, hit: u64) -> Scene {
    let mut scene = *scene;
    let part = |k: u64| (splitmix64(2 * hit + k) >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
    let [h_x, h_y] = scene.spacings();
    let reach = Solid::of(&scene.projectile).support(&[0.0, 0.0, 1.0].into());
    scene.projectile.position = [part(0) * h_x, part(1) * h_y, -reach];
    scene.projectile.velocity = [0.0, 0.0, velocity];
    scene
}

/// Runs an impact to its outcome.
pub fn impact(scene: &Scene) -> Result<Impact> {
    let mut buffers = Buffers::of(scene)?;
    let mut sim = buffers.sim(scene)?;
    let ends = mask_of(&[Outcome::Arrested, Outcome::Exited, Outcome::Detached]);
    let steps = (LONGEST / sim.step_limits().dt) as u64;
    sim.advance_until(ends, steps)?;
    let (velocity, outcomes) = (sim.projectile()?.velocity[2], sim.outcomes().mask);
    let first = scene.projectile.velocity[2];
    let through = if outcomes.has(ends) { !outcomes.has(Outcome::Arrested) } else { velocity > 0.05 * first };
    let energy = 0.5 * scene.projectile.mass * first * first;
    Ok(Impact { absorbed: sim.contact()?.work, through, residual: sim.energy()?.residual / energy })
}

/// The ballistic limit of one hit, m/s: strides from the guess until it lies between two velocities, then bisection of the logarithm.
pub fn limit(scene: &Scene, guess: f64, hit: u64) -> Result<f64> {
    let through = |velocity: f64| -> Result<bool> { Ok(impact(&shot(scene, velocity, hit))?.through) };
    let mut low = guess;
    while through(low)? {
        low /= STRIDE;
    }
    let mut high = low * STRIDE;
    while low >= guess && !through(high)? {
        (low, high) = (high, high * STRIDE);
    }
    while high / low > WIDTH {
        let middle = (low * high).sqrt();
        if through(middle)? { high = middle } else { low = middle }
    }
    Ok((low * high).sqrt())
}
