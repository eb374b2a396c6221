//! Graded networks: bars that stand for several yarns and crossings carry the mass, the tension and the waves of what they replace.

use fabric::{AttachmentKind, Code, Drive, Grading, InstructionSet, Integrator, Scene, Shape, Sim, Symmetry};
use fabric_tests::{Buffers, close, damage, positions, small_sheet, velocities, without_projectile};

/// Fine within `half` spacings of the middle, then `run` bars of 2, 4 ... up to `largest` yarns.
fn graded(mut scene: Scene, half: f64, largest: u32, run: u32) -> Scene {
    let half_width = scene.spacings().map(|h| half * h);
    scene.sheet.grading = Grading { largest, run, half_width, ..scene.sheet.grading };
    scene
}

/// Drawn yarn under the sphere, through failure.
fn struck(nodes: u32) -> Scene {
    let mut scene = small_sheet(nodes, 150.0);
    scene.yarn.stochastic = true;
    scene
}

/// Positions, velocities and damage: all that nodes and segments are.
fn state(sim: &Sim<'_>) -> (Vec<[f64; 3]>, Vec<[f64; 3]>, Vec<f64>) {
    (positions(sim), velocities(sim), damage(sim))
}

fn state_after(scene: &Scene, steps: u64) -> (Vec<[f64; 3]>, Vec<[f64; 3]>, Vec<f64>) {
    let mut buffers = Buffers::of(scene);
    let mut sim = buffers.sim(scene);
    sim.advance(steps).unwrap();
    state(&sim)
}

/// No grading, bars of one yarn, and a fine part as large as the sheet are the fabric, to the bit.
#[test]
fn a_network_of_single_yarns_is_the_fabric_to_the_bit() {
    let mut scenes = [struck(41); 5];
    scenes[1].slack_toe = 0.02;
    (scenes[2].sheet.spacing_y, scenes[2].sheet.crimp) = (9e-4, [0.0, 0.004]);
    scenes[3].yarn.strength_draw = fabric::StrengthDraw::Weibull;
    (scenes[4].integrator, scenes[4].projectile.velocity[2]) = (Integrator::THETA, 600.0);
    for (k, scene) in scenes.into_iter().enumerate() {
        let steps = if k == 4 { 400 } else { 2000 };
        let whole = state_after(&scene, steps);
        assert!(whole.2.iter().any(|alpha| *alpha < 1.0), "{k}");
        for grading in [graded(scene, 3.0, 1, 4), graded(scene, 20.0, 4, 4)] {
            assert!(state_after(&grading, steps) == whole, "{k} {:?}", grading.sheet.grading);
        }
    }
}

/// Nodes hold the mass of the fabric and bars its section: a sheet that moves as a whole has its kinetic energy, one that is stretched
/// evenly its strain energy, and no force on the nodes inside.
#[test]
fn mass_and_section_are_those_of_the_fabric() {
    for (nodes, half, largest, run, centre) in
        [(60, 5.0, 8, 2, 0.0), (61, 0.0, 64, 1, 0.0), (45, 3.0, 4, 1, 8.3e-3), (33, 40.0, 2, 1, 0.0), (50, 0.2, 2, 3, -1.0)]
    {
        let mut whole = without_projectile(small_sheet(nodes, 0.0));
        (whole.sheet.nodes_y, whole.sheet.spacing_y) = (nodes + 7, 8e-4);
        whole.attachment.kind = AttachmentKind::Free;
        let mut part = graded(whole, half, largest, run);
        part.sheet.grading.centre = [centre, -0.5 * centre];
        let kinetic = |scene: &Scene| {
            let mut buffers = Buffers::of(scene);
            let mut sim = buffers.sim(scene);
            let x: Vec<f64> = positions(&sim).into_iter().flatten().collect();
            sim.set_motion(&x, &[3.0, -4.0, 5.0].repeat(x.len() / 3)).unwrap();
            sim.energy().unwrap().fabric_kinetic
        };
        let mass = whole.sheet.node_mass * f64::from(nodes * (nodes + 7));
        close(kinetic(&whole), 25.0 * mass, 1e-12);
        close(kinetic(&part), 25.0 * mass, 1e-12);
        let strain = |scene: Scene| {
            let scene = Scene { integrator: Integrator::THETA, ..scene };
            let mut buffers = Buffers::of(&scene);
            stretched(&mut buffers, &scene).energy().unwrap().strain
        };
        close(strain(part), strain(whole), 1e-12);
        let mut buffers = Buffers::of(&part);
        let mut sim = stretched(&mut buffers, &part);
        sim.step().unwrap();
        let (nx, ny) = (sim.layout().nodes_x, sim.layout().nodes_y);
        assert!(nx < nodes as usize || half == 40.0);
        let v = velocities(&sim);
        for k in (2..ny - 2).flat_map(|j| (2..nx - 2).map(move |i| j * nx + i)) {
            assert!(v[k].iter().all(|v| v.abs() < 1e-9), "{:?}", v[k]);
        }
    }
}

/// The sheet at rest, 1 % longer along x and 2 % along y.
fn stretched<'a>(buffers: &'a mut Buffers, scene: &Scene) -> Sim<'a> {
    let mut sim = buffers.sim(scene);
    let x: Vec<f64> = positions(&sim).iter().flat_map(|x| [1.01 * x[0], 1.02 * x[1], x[2]]).collect();
    sim.set_motion(&x, &vec![0.0; x.len()]).unwrap();
    sim
}
