//! Half and quarter models: the same motion as the mirrored whole sheet. Without contact every expression is
//! the same, so every bit is, through failure too; with contact the sum over the nodes is taken in another
//! order.

use crate::fabrics::unlike;
use fabric_kernel::AttachmentKind::{FourCorners, FourSides, Free, TwoSides};
use fabric_kernel::{Grading, Integrator, Scene, Shape, Sim, Symmetry};
use fabric_tests::reference::{length, sub};
use fabric_tests::{
    as_proposed, close, positions, rated, rough, set_off, sim_of, small_sheet, stepped, tilted_cylinder, velocities,
};

const PLANES: [Symmetry; 3] = [
    Symmetry { mirror_x: true, mirror_y: false },
    Symmetry { mirror_x: false, mirror_y: true },
    Symmetry { mirror_x: true, mirror_y: true },
];
const QUARTER: Symmetry = PLANES[2];

/// A sheet that is set in motion by itself: v_z = v0 cos cos, or v0 and sideways where it is free. The
/// projectile is far away.
pub(crate) fn with_wave(scene: &Scene, v0: f64) -> Sim<'static> {
    let mut sim = sim_of(scene);
    let fixed = fabric_tests::reference::fixed_nodes(&Scene { symmetry: Symmetry::default(), ..*scene });
    let (nx, modelled) = (scene.sheet.nodes_x as usize, sim.layout().nodes_x);
    let half = scene.half_size();
    let wave = |x: f64, half: f64| (1.3 * x / half).cos();
    set_off(&mut sim, |k, x| {
        let height = wave(x[0], half[0]) * wave(x[1], half[1]);
        let held = fixed[k / modelled * nx + k % modelled];
        [x, if held { [0.0; 3] } else { [40.0 * x[0] / half[0], -60.0 * x[1] / half[1], v0 * height] }]
    });
    sim
}

/// Numbers of the whole sheet's nodes that a model with mirror planes holds.
fn modelled_nodes(whole: &Sim<'_>, part: &Sim<'_>) -> Vec<usize> {
    let [nx, columns, rows] = [whole.layout().nodes_x, part.layout().nodes_x, part.layout().nodes_y];
    (0..rows).flat_map(|j| (0..columns).map(move |i| j * nx + i)).collect()
}

/// Sheets with every kind of yarn and fabric, far from a projectile, and the speed of the wave that is to
/// tear them.
fn without_contact() -> Vec<(&'static str, Scene, f64)> {
    let mut scenes = Vec::new();
    for (nx, ny) in [(20, 21), (21, 20), (15, 16)] {
        let mut scene = small_sheet(nx, 0.0);
        scene.sheet.nodes_y = ny;
        (scene.attachment.disc_inset, scene.attachment.disc_radius) = (1.6e-3, 1.5e-3);
        (scene.projectile.radius, scene.projectile.position) = (1e-3, [0.0, 0.0, -1.0]);
        for kind in [FourSides, TwoSides, FourCorners, Free] {
            scene.attachment.kind = kind;
            let kinds = [("plain", scene), ("viscous", as_proposed(scene)), ("rate", rated(scene, 17_000.0))];
            scenes.extend(kinds.map(|(name, scene)| (name, scene, 1400.0)));
        }
        scene.attachment.kind = FourSides;
        scenes.push(("slack balance", Scene { slack_balance: true, ..scene }, 1400.0));
        for (pre_strain, crimp) in
            [([0.004, 0.0], [0.0, 0.004]), ([0.0; 2], [0.003, 0.006]), ([0.002, 0.006], [0.0; 2])]
        {
            let mut fabric = unlike(scene);
            (fabric.sheet.pre_strain, fabric.sheet.crimp) = (pre_strain, crimp);
            scenes.push(("fabric", fabric, 1400.0));
        }
    }
    let mut theta = Scene { integrator: Integrator::THETA, ..small_sheet(14, 0.0) };
    theta.projectile.position = [0.0, 0.0, -1.0];
    scenes.push(("theta", theta, 1200.0));
    (theta.sheet.nodes_x, theta.sheet.nodes_y) = (15, 15);
    scenes.push(("theta", theta, 1200.0));
    scenes
}

#[test]
fn without_contact_every_bit_is_that_of_the_whole_sheet() {
    for ((yarn, scene, speed), symmetry) in without_contact().into_iter().flat_map(|of| PLANES.map(|plane| (of, plane)))
    {
        let [nx, ny] = [scene.sheet.nodes_x, scene.sheet.nodes_y];
        let name = format!("{nx} x {ny} {yarn} {:?} {symmetry:?}", scene.attachment.kind);
        let (mut whole, mut part) = (with_wave(&scene, speed), with_wave(&Scene { symmetry, ..scene }, speed));
        let nodes = modelled_nodes(&whole, &part);
        for _ in 0..6 {
            whole.advance(40).unwrap();
            part.advance(40).unwrap();
            let (x, v) = (positions(&whole), velocities(&whole));
            let expected: Vec<_> = nodes.iter().map(|&k| (x[k], v[k])).collect();
            let found: Vec<_> = positions(&part).into_iter().zip(velocities(&part)).collect();
            assert!(found == expected, "{name}");
            assert_eq!(part.counters().failed_segments, whole.counters().failed_segments);
            let (a, b) = (part.energy().unwrap(), whole.energy().unwrap());
            close(a.fabric_kinetic, b.fabric_kinetic, 1e-12);
            close(a.strain, b.strain, 1e-12);
            close(a.dissipated, b.dissipated, 1e-12);
            close(a.viscous, b.viscous, 1e-12);
            let (a, b) = (part.support().unwrap(), whole.support().unwrap());
            let scale = b.attachments.iter().flatten().fold(1e-9, |m: f64, x| m.max(x.abs()));
            for (a, b) in a.attachments.iter().flatten().zip(b.attachments.iter().flatten()) {
                assert!((a - b).abs() <= 1e-12 * scale, "{name} {a:e} {b:e}");
            }
        }
        let failed = whole.counters().failed_segments;
        let enough = if scene.integrator == Integrator::VERLET { 20 } else { 0 };
        assert!(scene.attachment.kind == Free || failed > enough, "{name}: {failed}");
    }
}

/// A hit at the middle, planes that it leaves alone, and how near to the whole sheet a model with these
/// comes: in places, spacings, and in sums over the nodes, parts.
type Hit = (String, Scene, Symmetry, f64, f64);

fn hits() -> Vec<Hit> {
    let mut hits = Vec::new();
    for nodes in [40, 41] {
        let mut cuboid = tilted_cylinder(nodes, 0.0, 12.0);
        (cuboid.projectile.shape, cuboid.projectile.size) = (Shape::Box, [9e-3, 7e-3, 0.0381]);
        for mut scene in [small_sheet(nodes, 25.0), tilted_cylinder(nodes, 0.0, 12.0), cuboid] {
            for kind in [FourSides, TwoSides, FourCorners] {
                scene.attachment.kind = kind;
                (scene.attachment.disc_inset, scene.attachment.disc_radius) = (2.5e-3, 2e-3);
                hits.push((format!("{nodes} {:?} {kind:?}", scene.projectile.shape), scene, QUARTER, 1e-11, 1e-11));
            }
        }
        for mu in [0.3, 5.0] {
            let mut scene = rough(small_sheet(nodes, 25.0), mu);
            hits.push((format!("{nodes} rough {mu}"), scene, QUARTER, 1e-9, 1e-10));
            // It may spin about the normal of a plane.
            scene.projectile.angular_velocity = [900.0, 0.0, 0.0];
            hits.push((format!("{nodes} rough {mu}, spinning"), scene, PLANES[0], 1e-9, 1e-10));
        }
        let mut graded = small_sheet(nodes + 20, 25.0);
        let half_width = [10.0 * graded.sheet.spacing; 2];
        graded.sheet.grading = Grading { largest: 4, run: 2, half_width, ..graded.sheet.grading };
        hits.extend(PLANES.map(|planes| (format!("{nodes} graded {planes:?}"), graded, planes, 1e-10, 1e-9)));
    }
    hits
}

/// Only for 400 steps (8.5 us): soon after, contact itself amplifies any rounding a millionfold, in two whole
/// sheets whose velocities differ by 1e-14 just as here.
#[test]
fn a_centred_hit_is_that_of_the_whole_sheet() {
    for (name, scene, symmetry, places, sums) in hits() {
        println!("{name}");
        let (whole, part) = (stepped(&scene, 400), stepped(&Scene { symmetry, ..scene }, 400));
        let x = positions(&whole);
        for (found, k) in positions(&part).iter().zip(modelled_nodes(&whole, &part)) {
            assert!((0..3).all(|axis| (found[axis] - x[k][axis]).abs() < places * scene.sheet.spacing));
        }
        let (a, b) = (part.contact().unwrap(), whole.contact().unwrap());
        close(a.impulse[2], b.impulse[2], sums);
        close(a.work, b.work, sums);
        close(a.loss, b.loss, f64::max(sums, 1e-9));
        let across = [symmetry.mirror_x, symmetry.mirror_y];
        assert!((0..2).all(|axis| !across[axis] || a.impulse[axis] == 0.0));
        let (a, b) = (part.energy().unwrap(), whole.energy().unwrap());
        close(a.fabric_kinetic, b.fabric_kinetic, sums);
        close(a.strain, b.strain, sums);
        close(a.friction, b.friction, sums);
        let (a, b) = (part.support().unwrap().total[2], whole.support().unwrap().total[2]);
        assert!((a - b).abs() <= sums * b.abs().max(1e-6));
        let (a, b, spin) =
            (part.projectile().unwrap(), whole.projectile().unwrap(), scene.projectile.angular_velocity[0]);
        assert!(length(sub(a.velocity, b.velocity)) < 1e-11 * 25.0);
        assert!(length(sub(a.angular_velocity, b.angular_velocity)) < 1e-9 * (1.0 + spin));
        assert!(spin == 0.0 || a.angular_velocity[0] < spin);
        let momentum = scene.projectile.mass * scene.projectile.velocity[2];
        assert!(length(part.momentum_residual().unwrap()) < 1e-12 * momentum);
    }
}

/// One plane leaves the turning about its normal and the hit's place along it free.
#[test]
fn half_a_sheet_under_a_tilted_cylinder() {
    let mut scene = tilted_cylinder(41, 0.3, 15.0);
    scene.projectile.position[1] = 1e-3;
    scene.projectile.angular_velocity = [300.0, 0.0, 0.0];
    let half = Scene { symmetry: PLANES[0], ..scene };
    let [a, b] = [half, scene].map(|scene| stepped(&scene, 900).projectile().unwrap());
    assert!((a.angular_velocity[0] - 300.0).abs() > 1e-3);
    close(a.angular_velocity[0], b.angular_velocity[0], 1e-12);
    for axis in 1..3 {
        close(a.position[axis], b.position[axis], 1e-12);
        close(a.velocity[axis], b.velocity[axis], 1e-12);
    }
}

/// The quarter's memory is about a quarter.
#[test]
fn a_quarter_takes_a_quarter_of_the_memory() {
    let mut scene = Scene::sheet_10in_cylinder();
    scene.yarn.stochastic = false;
    let whole = fabric_kernel::Layout::of(&scene).unwrap().bytes();
    scene.symmetry = QUARTER;
    let part = fabric_kernel::Layout::of(&scene).unwrap().bytes() as f64 / whole as f64;
    assert!((0.25..0.27).contains(&part), "{part}");
}
