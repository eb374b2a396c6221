//! Hits of an ensemble: where they strike, what an impact ends with, and the ballistic limit of each, found by bisection.
//!
//! Hits differ by where in a cell of the network the projectile's axis strikes, which a shot does not control, and by the seed of
//! what is drawn. Each hit has a limit of its own, between arrest and perforation; their mean stands for V50 and Student's interval for its error.
//! Limit: beyond the first failure the model is chaotic, so the limit of one hit is one sample; bisection finds one of its crossings.

use crate::Result;
use crate::event::mask_of;
use crate::memory::Buffers;
use fabric::Solid;
use fabric::internals::random::splitmix64;
use fabric::{Outcome, Scene};
use rayon::prelude::*;

/// Stride of the search for an arrest below and a perforation above, and width at which bisection ends, in parts of the velocity.
const STRIDE: f64 = 1.25;
const WIDTH: f64 = 1.01;

/// What an impact ended with.
pub struct Impact {
    /// Work on the fabric, J.
    pub absorbed: f64,
    /// What friction on the projectile took of it, J.
    pub rubbed: f64,
    /// Velocity of the projectile along z, m/s.
    pub velocity: f64,
    /// Whether the projectile went through; of a run that was given up, whether it still moves on with 5 % of its velocity.
    pub through: bool,
    /// Segments that failed.
    pub failed: u64,
    /// What the energy balance does not close by, in parts of the impact energy.
    pub residual: f64,
    /// Contact solves that ran out of sweeps.
    pub unconverged: u64,
    /// Deepest that two plies were through each other, m.
    pub ply_penetration: f64,
}

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

/// Runs an impact to its outcome; after so many seconds it is given up.
pub fn impact(scene: &Scene, longest: f64) -> Result<Impact> {
    let mut buffers = Buffers::of(scene)?;
    let mut sim = buffers.sim(scene)?;
    let ends = mask_of(&[Outcome::Arrested, Outcome::Exited, Outcome::Detached]);
    sim.advance_until(ends, (longest / sim.step_limits().dt) as u64)?;
    let (velocity, outcomes) = (sim.projectile()?.velocity[2], sim.outcomes().mask);
    let (energy, counters) = (sim.energy()?, sim.counters());
    let first = scene.projectile.velocity[2];
    let through = if outcomes.has(ends) { !outcomes.has(Outcome::Arrested) } else { velocity > 0.05 * first };
    Ok(Impact {
        absorbed: energy.contact_work,
        rubbed: energy.friction,
        velocity,
        through,
        failed: counters.failed_segments,
        residual: energy.residual / (0.5 * scene.projectile.mass * first * first),
        unconverged: counters.unconverged,
        ply_penetration: counters.ply_penetration,
    })
}

/// The ballistic limit of one hit, m/s: strides from the guess until it lies between two velocities, then bisection of the logarithm.
pub fn limit(scene: &Scene, guess: f64, hit: u64, longest: f64) -> Result<f64> {
    bracketed(guess, |velocity| Ok(impact(&shot(scene, velocity, hit), longest)?.through))
}

/// Where a velocity begins to go through, m/s, to half of [`WIDTH`].
fn bracketed(guess: f64, through: impl Fn(f64) -> Result<bool>) -> Result<f64> {
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

/// What a function gives for each job, on all cores.
pub fn each<J: Sync, T: Send>(jobs: &[J], work: impl Fn(&J) -> Result<T> + Sync) -> Result<Vec<T>> {
    let done: std::result::Result<Vec<T>, String> =
        jobs.par_iter().with_max_len(1).map(|job| work(job).map_err(|error| crate::in_words(&*error))).collect();
    Ok(done?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From guesses below, at and above it.
    #[test]
    fn a_threshold_is_found() {
        for guess in [10.0, 99.0, 100.0, 101.0, 1e4] {
            let found = bracketed(guess, |velocity| Ok(velocity > 100.0)).unwrap();
            assert!((found / 100.0 - 1.0).abs() < 0.5 * (WIDTH - 1.0) + 1e-4, "{guess}: {found}");
        }
    }

    /// A hit strikes within the middle cell, just before the sheet, and two strike at two places.
    #[test]
    fn hits_lie_in_the_middle_cell() {
        let scene = Scene::sheet_10in_cylinder();
        let places: Vec<[f64; 3]> = (0..20).map(|hit| shot(&scene, 50.0, hit).projectile.position).collect();
        let half = 0.5 * scene.sheet.spacing;
        assert!(places.iter().all(|place| place[0].abs() <= half && place[1].abs() <= half));
        assert!(places.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(shot(&scene, 50.0, 3).check().is_ok());
    }
}
