pub mod fingerprint;
pub mod outputs;
pub(crate) mod restore;
pub mod simulation;
pub mod snapshot;
pub mod start;

/// What the unit tests of several files use.
#[cfg(test)]
mod tests {
    use crate::Sim;
    use crate::scene::parts::{Scene, StepAfterFailure};
    use std::vec::Vec;

    /// 21 x 21 nodes, four sides held, every option that adds to the state; the preset sphere at 150 m/s.
    pub fn torn_by_a_sphere() -> Scene {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.projectile.velocity) = (21, 21, [0.0, 0.0, 150.0]);
        (scene.yarn.stochastic, scene.track_detachment, scene.track_support) = (true, true, true);
        (scene.slack_toe, scene.step_after_failure) = (0.02, StepAfterFailure::Half);
        (scene.yarn.viscosity_linear, scene.yarn.viscosity_bending) = (0.06, 0.06);
        scene
    }

    /// Calls a function with a simulation of the scene.
    pub fn with_sim<R>(scene: &Scene, act: impl FnOnce(&mut Sim<'_>) -> R) -> R {
        let layout = crate::Layout::of(scene).unwrap();
        let mut memory = std::vec![crate::CacheLine::ZERO; layout.lines()];
        act(&mut Sim::new(scene, &mut memory).unwrap())
    }

    pub fn saved(sim: &Sim<'_>) -> Vec<u8> {
        let mut image = std::vec![0; sim.snapshot_bytes()];
        sim.save(&mut image).unwrap();
        image
    }

    pub fn word_of(image: &[u8], at: usize) -> u64 {
        u64::from_le_bytes(*image[8 * at..].first_chunk().unwrap())
    }
}
