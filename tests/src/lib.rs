//! What the tests and the ensembles share: memory for a simulation, small scenes, and plain formulas to check against.
#![allow(clippy::disallowed_methods)] // Expected values may come from the host's own functions.

use fabric::{AttachmentKind, CacheLine, Layout, Scene, Sim};

pub mod inputs;
pub mod options;
pub mod reference;

/// Memory of one simulation.
pub struct Buffers {
    /// Its lines.
    pub lines: Vec<CacheLine>,
}

impl Buffers {
    /// Just enough memory for a scene, filled with zeros.
    ///
    /// # Panics
    /// If the scene is refused.
    pub fn of(scene: &Scene) -> Buffers {
        let layout = Layout::of(scene).expect("the scene is sound");
        Buffers { lines: vec![CacheLine::ZERO; layout.lines()] }
    }

    /// A simulation of `scene` in this memory.
    ///
    /// # Panics
    /// If the scene is refused.
    pub fn sim(&mut self, scene: &Scene) -> Sim<'_> {
        Sim::new(scene, &mut self.lines).expect("the scene is sound")
    }
}

/// Velocity, m/s, of a body of this mass, kg, with this kinetic energy, J: V = sqrt(2 KE/M).
pub fn speed(kinetic_energy: f64, mass: f64) -> f64 {
    (2.0 * kinetic_energy / mass).sqrt()
}

/// The preset 3 in scene, held in the given way, with the sphere at the given kinetic energy, J.
pub fn sphere_on_3in(kind: AttachmentKind, kinetic_energy: f64, stochastic: bool) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    scene.attachment.kind = kind;
    scene.yarn.stochastic = stochastic;
    scene.projectile.velocity = [0.0, 0.0, speed(kinetic_energy, scene.projectile.mass)];
    scene
}

/// A square sheet of `nodes` x `nodes`, four sides held, uniform yarn, the preset sphere at `velocity` m/s along +z.
pub fn small_sheet(nodes: u32, velocity: f64) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    scene.sheet.nodes_x = nodes;
    scene.sheet.nodes_y = nodes;
    scene.yarn.stochastic = false;
    scene.projectile.velocity = [0.0, 0.0, velocity];
    scene
}

/// With a sphere of the same mass that fits between the supports of a small sheet: of this radius in node spacings, just
/// touching the sheet.
pub fn between_supports(mut scene: Scene, radius: f64) -> Scene {
    scene.projectile.radius = radius * scene.sheet.spacing;
    scene.projectile.position = [0.0, 0.0, -scene.projectile.radius];
    scene
}

/// The preset flat cylinder, tilted by `tilt` rad about x, its lowest rim point just short of the sheet, at `velocity` m/s.
pub fn tilted_cylinder(nodes: u32, tilt: f64, velocity: f64) -> Scene {
    let mut scene = small_sheet(nodes, velocity);
    let (radius, length) = (6.35e-3, 0.0381);
    let body = &mut scene.projectile;
    body.shape = fabric::Shape::Cylinder;
    (body.radius, body.length, body.mass) = (radius, length, 0.037);
    let lowest = 0.5 * length * tilt.cos() + radius * tilt.sin();
    body.position = [0.0, 0.0, -lowest - 1e-6];
    body.orientation = [(0.5 * tilt).cos(), (0.5 * tilt).sin(), 0.0, 0.0];
    scene
}

/// A sheet without a projectile: the body is prescribed, at rest and far away.
pub fn without_projectile(mut scene: Scene) -> Scene {
    scene.drive = fabric::Drive::Prescribed;
    scene.projectile.position = [0.0, 0.0, -1.0];
    scene.projectile.velocity = [0.0; 3];
    scene
}

/// Positions at t_n, m, one triple per node.
///
/// # Panics
/// If the simulation has failed.
pub fn positions(sim: &Sim<'_>) -> Vec<[f64; 3]> {
    let mut flat = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut flat).expect("sound");
    flat.as_chunks::<3>().0.to_vec()
}

/// Velocities at t_n, m/s, one triple per node.
///
/// # Panics
/// If the simulation has failed.
pub fn velocities(sim: &Sim<'_>) -> Vec<[f64; 3]> {
    let mut flat = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_velocities(&mut flat).expect("sound");
    flat.as_chunks::<3>().0.to_vec()
}

/// alpha of every segment at t_n.
///
/// # Panics
/// If the simulation has failed.
pub fn damage(sim: &Sim<'_>) -> Vec<f64> {
    let mut values = vec![0.0; sim.layout().segments()];
    sim.copy_damage(&mut values).expect("sound");
    values
}

/// Asserts that a value agrees with its expected value to a relative tolerance.
///
/// # Panics
/// If it does not.
#[track_caller]
pub fn close(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value:e} is not {expected:e}: off by {:.2e} of it, allowed {relative:.0e}",
        ((value - expected) / expected).abs()
    );
}

/// The Rust example of the README, run as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
