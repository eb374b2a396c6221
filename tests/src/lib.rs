//! What the tests share: memory for a simulation, small scenes, and plain formulas to check against. All
//! panic where a scene is refused, a simulation has failed or a name is not known.
#![allow(clippy::disallowed_methods)] // Expected values may come from the host's own functions.

use fabric_kernel::{AttachmentKind, CacheLine, Faces, Layout, Motion, Scene, Sim};

#[path = "../golden/scenes.rs"]
pub mod golden;
pub mod inputs;
pub mod options;
pub mod reference;

/// Just enough memory for a scene, filled with zeros.
pub fn memory_of(scene: &Scene) -> Vec<CacheLine> {
    vec![CacheLine::ZERO; Layout::of(scene).expect("the scene is sound").lines()]
}

/// A simulation in memory of its own, which is never given back.
pub fn sim_of(scene: &Scene) -> Sim<'static> {
    Sim::new(scene, memory_of(scene).leak()).expect("the scene is sound")
}

/// Simulation after so many steps.
pub fn stepped(scene: &Scene, steps: u64) -> Sim<'static> {
    let mut sim = sim_of(scene);
    sim.advance(steps).expect("no failure");
    sim
}

/// The image of a simulation.
pub fn image_of(sim: &Sim<'_>) -> Vec<u8> {
    let mut image = vec![0; sim.snapshot_bytes()];
    sim.save(&mut image).expect("sound");
    image
}

/// Sets a new simulation off: `motion` gives position, m, and velocity, m/s, of the node of a number that
/// rests at a place.
pub fn set_off(sim: &mut Sim<'_>, motion: impl Fn(usize, [f64; 3]) -> [[f64; 3]; 2]) {
    let given: Vec<_> = positions(sim).into_iter().enumerate().map(|(k, x)| motion(k, x)).collect();
    let [x, v] = [0, 1].map(|part| given.iter().flat_map(|node| node[part]).collect::<Vec<f64>>());
    sim.set_motion(&x, &v).expect("accepted");
}

/// At the origin, at rest, not turned.
pub const AT_REST: Motion =
    Motion { position: [0.0; 3], velocity: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0], angular_velocity: [0.0; 3] };

/// The faces of a cuboid with these half edges, m.
pub fn cuboid_faces([a, b, c]: [f64; 3]) -> Faces {
    Faces::of(&[
        [1.0, 0.0, 0.0, a],
        [-1.0, 0.0, 0.0, a],
        [0.0, 1.0, 0.0, b],
        [0.0, -1.0, 0.0, b],
        [0.0, 0.0, 1.0, c],
        [0.0, 0.0, -1.0, c],
    ])
}

/// The faces of a tetrahedron about a sphere of this radius, m.
pub fn tetrahedron(radius: f64) -> Faces {
    let n = 3f64.sqrt().recip();
    Faces::of(&[[n, n, n, radius], [n, -n, -n, radius], [-n, n, -n, radius], [-n, -n, n, radius]])
}

/// Numbers from 0 to 1 without visible order.
pub fn number(k: u64) -> f64 {
    (fabric_kernel::internals::random::splitmix64(k) >> 11) as f64 / (1u64 << 53) as f64
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

/// A square sheet of `nodes` x `nodes`, four sides held, uniform yarn, the preset sphere at `velocity` m/s
/// along +z.
pub fn small_sheet(nodes: u32, velocity: f64) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    scene.sheet.nodes_x = nodes;
    scene.sheet.nodes_y = nodes;
    scene.yarn.stochastic = false;
    scene.projectile.velocity = [0.0, 0.0, velocity];
    scene
}

/// With a sphere of the same mass that fits between the supports of a small sheet: of this radius in node
/// spacings, just touching the sheet.
pub fn between_supports(mut scene: Scene, radius: f64) -> Scene {
    scene.projectile.radius = radius * scene.sheet.spacing;
    scene.projectile.position = [0.0, 0.0, -scene.projectile.radius];
    scene
}

/// The preset flat cylinder, tilted by `tilt` rad about x, its lowest rim point just short of the sheet, at
/// `velocity` m/s.
pub fn tilted_cylinder(nodes: u32, tilt: f64, velocity: f64) -> Scene {
    let mut scene = small_sheet(nodes, velocity);
    let (radius, length) = (6.35e-3, 0.0381);
    let body = &mut scene.projectile;
    body.shape = fabric_kernel::Shape::Cylinder;
    (body.radius, body.length, body.mass) = (radius, length, 0.037);
    let lowest = 0.5 * length * tilt.cos() + radius * tilt.sin();
    body.position = [0.0, 0.0, -lowest - 1e-6];
    body.orientation = [(0.5 * tilt).cos(), (0.5 * tilt).sin(), 0.0, 0.0];
    scene
}

/// A sheet without a projectile: the body is prescribed, at rest and far away.
pub fn without_projectile(mut scene: Scene) -> Scene {
    scene.drive = fabric_kernel::Drive::Prescribed;
    scene.projectile.position = [0.0, 0.0, -1.0];
    scene.projectile.velocity = [0.0; 3];
    scene
}

/// With yarn drawn for every segment.
pub fn drawn(mut scene: Scene) -> Scene {
    scene.yarn.stochastic = true;
    scene
}

/// With this linear, quadratic and bending viscosity of the yarn.
pub fn viscous(mut scene: Scene, [linear, quadratic, bending]: [f64; 3]) -> Scene {
    let yarn = &mut scene.yarn;
    (yarn.viscosity_linear, yarn.viscosity_quadratic, yarn.viscosity_bending) = (linear, quadratic, bending);
    scene
}

/// With viscosity as proposed for real fabrics.
pub fn as_proposed(scene: Scene) -> Scene {
    viscous(scene, [0.06, 1.5, 0.06])
}

/// With a dependence on the rate of strain like that of Kevlar 49, up to this rate, 1/s.
pub fn rated(mut scene: Scene, limit: f64) -> Scene {
    let yarn = &mut scene.yarn;
    (yarn.rate_modulus, yarn.rate_stretch) = (0.13, 0.16);
    (yarn.rate_reference, yarn.rate_limit) = (limit * 30.0 / 1700.0, limit);
    scene
}

/// With this coefficient of friction.
pub fn rough(mut scene: Scene, coefficient: f64) -> Scene {
    scene.contact.friction = coefficient;
    scene
}

/// Positions at t_n, m, one triple per node.
pub fn positions(sim: &Sim<'_>) -> Vec<[f64; 3]> {
    let mut flat = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut flat).expect("sound");
    flat.as_chunks::<3>().0.to_vec()
}

/// Velocities at t_n, m/s, one triple per node.
pub fn velocities(sim: &Sim<'_>) -> Vec<[f64; 3]> {
    let mut flat = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_velocities(&mut flat).expect("sound");
    flat.as_chunks::<3>().0.to_vec()
}

/// alpha of every segment at t_n.
pub fn damage(sim: &Sim<'_>) -> Vec<f64> {
    let mut values = vec![0.0; sim.layout().segments()];
    sim.copy_damage(&mut values).expect("sound");
    values
}

/// Asserts that a value agrees with its expected value to a relative tolerance.
#[track_caller]
pub fn close(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value:e} is not {expected:e}: off by {:.2e} of it, allowed {relative:.0e}",
        ((value - expected) / expected).abs()
    );
}
