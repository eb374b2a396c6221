//! Separate plies that push on each other, against closed forms: plies far apart, plies that lie on each
//! other, a ply that falls on another, and the balances of energy and momentum.

use fabric_kernel::{AttachmentKind, Outcome, Scene, Shape, Sim, Stack, TimeStep, Yarn};
use fabric_tests::reference::{V3, dot, largest_distance as apart, length, scale, sub};
use fabric_tests::{
    as_proposed, close, damage, drawn, positions, rough, set_off, sim_of, small_sheet, stepped, tilted_cylinder,
    velocities, without_projectile,
};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;

/// So many plies at this gap, m.
pub(crate) fn stacked(mut scene: Scene, plies: u32, gap: f64) -> Scene {
    scene.stack = Stack { plies, gap, turned: false };
    scene
}

/// Positions of one ply.
pub(crate) fn of_ply(sim: &Sim<'_>, ply: usize) -> Vec<[f64; 3]> {
    let nodes = sim.layout().nodes() / sim.layout().plies;
    positions(sim)[ply * nodes..(ply + 1) * nodes].to_vec()
}

/// Where plies lie on each other some nodes of a column stick to the projectile and some slide, and which
/// they are is found, too.
#[test]
fn friction_on_plies_that_lie_on_each_other_is_solved() {
    for velocity in [15.0, 42.0] {
        let mut scene = stacked(small_sheet(31, velocity), 5, 0.0);
        scene.contact.friction = 0.2;
        let sim = stepped(&scene, 1000);
        let (counters, energy) = (sim.counters(), sim.energy().unwrap());
        assert!(counters.contacts > 0 && energy.friction > 0.0, "{counters:?}");
        assert_eq!(counters.unconverged, 0, "{counters:?}");
        let impact = 0.5 * scene.projectile.mass * velocity * velocity;
        assert!(energy.residual.abs() < 1e-4 * impact, "{}", energy.residual);
    }
}

/// Before it reaches the second ply a projectile knows the first alone, to what the solve of contact leaves;
/// and one that starts between the plies knows the second alone, which has draws of its own.
#[test]
fn plies_far_apart_are_shields_of_their_own() {
    [0.0, 0.3].into_iter().for_each(far_apart);
}

fn far_apart(friction: f64) {
    let mut scene = drawn(small_sheet(31, 90.0));
    scene.time_step = TimeStep::seconds(2e-8);
    (scene.contact.friction, scene.projectile.angular_velocity) = (friction, [900.0, 0.0, 300.0]);
    let gap = 0.05;
    let (stack, mut second) = (stacked(scene, 2, gap), scene);
    second.seed = scene.ply_seed(1);
    assert_ne!(second.seed, scene.seed);
    let (both, mut alone) = (stepped(&stack, 400), stepped(&scene, 400));
    assert!(apart(&of_ply(&both, 0), &positions(&alone)) < 1e-9 * alone.fabric().unwrap().max_deflection);
    close(both.projectile().unwrap().velocity[2], alone.projectile().unwrap().velocity[2], 1e-12);
    assert!(of_ply(&both, 1).iter().all(|x| x[2] == gap));
    let (first, rest, energy) = (both.ply(0).unwrap(), both.ply(1).unwrap(), alone.energy().unwrap());
    close(both.energy().unwrap().friction, energy.friction, 1e-9);
    assert_eq!(energy.friction > 0.0, friction > 0.0);
    close(first.kinetic, energy.fabric_kinetic, 1e-7);
    close(first.strain, energy.strain, 1e-7);
    assert_eq!((first.failed_segments, rest.failed_segments), (0, 0));
    assert_eq!((rest.kinetic, rest.strain, rest.dissipated), (0.0, 0.0, 0.0));
    assert_eq!(both.ply(2).unwrap_err().field, "ply");

    let (mut stack, mut alone) = (stack, second);
    stack.projectile.position[2] = gap - scene.projectile.radius;
    alone.sheet.position[2] = gap;
    alone.projectile.position = stack.projectile.position;
    let (mut both, alone) = (stepped(&stack, 300), stepped(&alone, 300));
    let worst = apart(&of_ply(&both, 1), &positions(&alone));
    let deflection = both.fabric().unwrap().max_deflection;
    assert!(worst < 1e-9 * deflection && deflection > 4e-4, "{worst:e} {deflection:e}");
    assert_eq!(both.counters().failed_segments, 0);
}

/// Plies that lie on each other and are alike are the lumped sheet of their mass, up to the first failure.
#[test]
fn plies_on_each_other_move_as_the_lumped_sheet() {
    for (plies, scene) in [(2, small_sheet(31, 60.0)), (7, small_sheet(31, 60.0)), (3, tilted_cylinder(41, 0.3, 40.0))]
    {
        let [speed, work, strain] = off_the_lumped(&scene, plies, 300);
        assert!(speed < 1e-9 && work < 1e-7 && strain < 1e-6, "{plies} plies: {speed:e} {work:e} {strain:e}");
    }
}

/// What so many plies on each other are off the lumped sheet: speed of the body, work and strain energy, in
/// parts.
pub(crate) fn off_the_lumped(scene: &Scene, plies: u32, steps: u64) -> [f64; 3] {
    let (stack, mut lumped) = (stacked(*scene, plies, 0.0), *scene);
    lumped.sheet.plies = plies;
    let [apart, one] = [stack, lumped].map(|scene| stepped(&scene, steps));
    assert_eq!(apart.counters().failed_segments + one.counters().failed_segments, 0);
    assert!(apart.counters().ply_penetration < 1e-12 && apart.counters().unconverged == 0);
    let [a, b] = [&apart, &one].map(|sim| sim.support().unwrap().casing);
    assert!(length(sub(a, b)) <= 1e-6 * length(b), "{a:?} {b:?}");
    let [v, u] = [&apart, &one].map(|sim| sim.projectile().unwrap().velocity);
    let [a, b] = [&apart, &one].map(|sim| sim.energy().unwrap());
    assert!(a.contact_work > 1e-3, "{a:?}");
    let speed = length(sub(v, u)) / length(scene.projectile.velocity);
    [speed, (a.contact_work / b.contact_work - 1.0).abs(), (a.strain / b.strain - 1.0).abs()]
}

/// A ring of nodes that closes in on a light sphere from a little below its equator squeezes it out upwards,
/// faster than the nodes move. So it meets in the same step a node above it that nothing seemed to reach.
#[test]
fn a_sphere_that_is_squeezed_out_meets_what_was_out_of_its_reach() {
    let mut scene = small_sheet(10, 0.0);
    let (h, closing, dt, ring) = (scene.sheet.spacing, 10.0, 1e-8, 16);
    let (radius, sine) = (1.05 * h, 0.2_f64);
    let body = &mut scene.projectile;
    (body.radius, body.mass) = (radius, scene.sheet.node_mass);
    let centre = -1.5 * radius;
    (body.position, body.velocity) = ([0.0, 0.0, centre], [0.0; 3]);
    scene.time_step = TimeStep::seconds(dt);
    let scene = stacked(scene, 2, 0.0);
    let mut sim = sim_of(&scene);
    // Both plies are torn to pieces, so that nothing but contact moves their nodes. The middle ones are put
    // about the sphere.
    sim.set_largest_stretch(&vec![10.0; sim.layout().segments()]).unwrap();
    let mut x = positions(&sim);
    let mut v = vec![[0.0; 3]; x.len()];
    let mut middle: Vec<usize> = (0..100).collect();
    middle.sort_by(|&a, &b| x[a][0].hypot(x[a][1]).total_cmp(&x[b][0].hypot(x[b][1])));
    let above = middle[ring];
    for ply in [0, 100] {
        for (k, node) in middle[..ring].iter().enumerate() {
            let angle = std::f64::consts::TAU * k as f64 / ring as f64;
            let cosine = (1.0 - sine * sine).sqrt();
            let normal = [cosine * angle.cos(), cosine * angle.sin(), -sine];
            let away = normal.map(|n| 1.000_001 * radius * n);
            x[ply + node] = [away[0], away[1], centre + away[2]];
            v[ply + node] = normal.map(|n| -closing * n);
        }
        x[ply + above] = [0.0, 0.0, centre + radius + 2.2 * closing * dt];
    }
    sim.set_motion(x.as_flattened(), v.as_flattened()).unwrap();
    sim.step().unwrap();
    let body = sim.projectile().unwrap();
    let depth = |x: &[f64; 3]| radius - length(sub(*x, body.position));
    let deepest = positions(&sim).iter().map(depth).fold(-h, f64::max);
    assert!(deepest < 1e-9 * h, "{deepest}");
    assert!(velocities(&sim)[above][2] > 0.0 && body.velocity[2] > 2.2 * closing, "{:?}", body.velocity);
}

/// A stack of free plies without a projectile.
fn free_plies(plies: u32, gap: f64) -> Scene {
    let mut scene = stacked(without_projectile(small_sheet(9, 0.0)), plies, gap);
    scene.attachment.kind = AttachmentKind::Free;
    scene
}

/// Free plies are stiff plates in the direction in which they fall. Also where the last ply is of another
/// fabric, three times as heavy.
#[test]
fn a_falling_ply_takes_along_one_after_the_other() {
    let heavy = with_back(free_plies(3, 1e-4), 1, |back| back.node_mass *= 3.0);
    takes_along(sim_of(&free_plies(4, 1e-4)), &[1.0; 4], |_| [0.0, 0.0, 1.0]);
    takes_along(sim_of(&heavy), &[1.0, 1.0, 3.0], |_| [0.0, 0.0, 1.0]);
}

/// A ply of speed V meets plies of these masses at rest one after the other, and goes on with them at the
/// common speed of momentum, each time at the place that follows from the speeds between. `ahead`: unit
/// vector from a node's place.
pub(crate) fn takes_along(mut sim: Sim<'_>, masses: &[f64], ahead: impl Fn(V3) -> V3) {
    let (scene, speed, nodes) = (*sim.scene(), 30.0, sim.layout().nodes() / masses.len());
    set_off(&mut sim, |k, x| [x, scale(ahead(x), if k < nodes { speed } else { 0.0 })]);
    let (dt, mass, gap) = (sim.step_limits().dt, nodes as f64 * scene.sheet.node_mass, scene.stack.gap);
    let first = sim.energy().unwrap().fabric_kinetic;
    close(first, 0.5 * mass * speed * speed, 1e-12);
    let mut together = masses[0];
    for (met, next) in masses.iter().enumerate().skip(1) {
        // Up to the next meeting these plies go on together.
        sim.advance((gap * together / speed / dt).ceil() as u64 + 2).unwrap();
        together += next;
        let common = speed / together;
        for (k, (v, x)) in velocities(&sim).into_iter().zip(positions(&sim)).enumerate() {
            let expected = scale(ahead(x), if k / nodes <= met { common } else { 0.0 });
            assert!(length(sub(v, expected)) < 1e-9 * speed, "{met}: node {k} {v:?}");
        }
        let energy = sim.energy().unwrap();
        close(energy.fabric_kinetic, 0.5 * mass * speed * common, 1e-9);
        close(sim.ply(met as u32).unwrap().kinetic, 0.5 * mass * next * common * common, 1e-9);
        // What an impact without restitution loses, in the ledger.
        close(energy.ply_loss, 0.5 * mass * speed * (speed - common), 1e-9);
        assert!(energy.residual.abs() < 1e-9 * first);
        assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * mass * speed);
        // The meeting was where the ply below has come by then: no ply is through another, and they lie on
        // each other.
        assert!(sim.counters().ply_penetration < if scene.sheet.radius > 0.0 { 1e-14 } else { 1e-15 });
        let [above, below] = [met, met - 1].map(|ply| of_ply(&sim, ply));
        assert!(above.into_iter().zip(below).all(|(a, b)| dot(sub(a, b), ahead(a)).abs() < 1e-12));
    }
}

/// 250 m/s through five plies 0.25 mm apart, smooth and rough, and of two viscous fabrics: whatever tears,
/// momentum is kept, the balances close, and no ply goes through another before there is a hole.
#[test]
fn balances_of_a_perforated_stack() {
    let mut smooth = stacked(small_sheet(31, 250.0), 5, 2.5e-4);
    (smooth.yarn.stochastic, smooth.track_support) = (true, true);
    let uniform = Scene { yarn: Yarn { stochastic: false, ..smooth.yarn }, ..smooth };
    let mut hybrid = drawn(as_proposed(with_back(uniform, 3, another)));
    (hybrid.back.modulus_sd, hybrid.back.crimp) = (1e9, [0.003, 0.001]);
    for (name, scene, residual, failed) in
        [("smooth", smooth, 1e-3, 300), ("rough", rough(smooth, 0.3), 1e-3, 300), ("hybrid", hybrid, 1e-2, 20)]
    {
        let mut sim = sim_of(&scene);
        let (first, mut through, mut worst) = (0.5 * scene.projectile.mass * 250.0 * 250.0, 0.0, 0.0);
        for _ in 0..40 {
            sim.advance(20).unwrap();
            let (energy, counters) = (sim.energy().unwrap(), sim.counters());
            worst = f64::max(worst, energy.residual.abs() / first);
            assert!(worst < residual && energy.ply_loss >= 0.0, "{name}: {energy:?}");
            assert!(length(sim.momentum_residual().unwrap()) < 1e-10 * scene.projectile.mass * 250.0);
            if counters.failed_segments == 0 {
                through = counters.ply_penetration;
            }
            let plies = [0, 1, 2, 3, 4].map(|ply| sim.ply(ply).unwrap());
            assert_eq!(plies.iter().map(|ply| ply.failed_segments).sum::<u64>(), counters.failed_segments);
            close(plies.iter().map(|ply| ply.kinetic).sum(), energy.fabric_kinetic, 1e-12);
        }
        println!("{name} stack: residual at most {worst:e} of the impact energy");
        assert!(through < 1e-15 && sim.counters().failed_segments > failed, "{name}: {:?}", sim.counters());
        let energy = sim.energy().unwrap();
        assert!(energy.ply_loss > 1e-4 * first, "{name}: {energy:?}");
        assert_eq!((energy.friction > 1e-4 * first, energy.viscous > 0.0), (name == "rough", name == "hybrid"));
        assert!(sim.ply(4).unwrap().failed_segments > 20);
    }
}

/// A flat block on free plies that lie on each other takes them along with its speed; across it each of their
/// nodes gets the coefficient times what it gets along, or goes along. The block is so heavy that it neither
/// slows down nor tips by more than a millionth.
#[test]
fn a_block_rubs_on_a_pile_as_on_one_ply() {
    for (plies, gap, coefficient, across) in
        [(1, 0.0, 0.2, 20.0), (2, 0.0, 0.2, 20.0), (7, 0.0, 0.2, 20.0), (5, 1e-8, 0.3, 10.0), (4, 0.0, 2.0, 5.0)]
    {
        let mut scene = stacked(small_sheet(3, 0.0), plies, gap);
        scene.attachment.kind = AttachmentKind::Free;
        scene.contact.friction = coefficient;
        let h = scene.sheet.spacing;
        let body = &mut scene.projectile;
        (body.shape, body.size, body.mass) = (Shape::Box, [8.0 * h, 8.0 * h, 8.0 * h], 10.0);
        (body.position, body.velocity) = ([0.0, 0.0, -4.0 * h], [0.6 * across, -0.8 * across, 10.0]);
        let mut sim = sim_of(&scene);
        sim.step().unwrap();
        let dt = sim.step_limits().dt;
        let (mut along, mut beside) = (0.0, 0.0);
        for (k, v) in velocities(&sim).into_iter().enumerate() {
            // The gaps are closed first.
            close(v[2], 10.0 - (k / 9) as f64 * gap / dt, 1e-5);
            (along, beside) = (along + v[2], beside + (0.6 * v[0] - 0.8 * v[1]));
        }
        let expected = (coefficient * along).min(f64::from(9 * plies) * across);
        close(beside, expected, 1e-5);
        let mass = scene.sheet.node_mass;
        let slower = sub([0.6 * across, -0.8 * across, 10.0], sim.projectile().unwrap().velocity);
        close(slower[2], mass * along / 10.0, 1e-6);
        close(0.6 * slower[0] - 0.8 * slower[1], mass * beside / 10.0, 1e-6);
        assert_eq!(sim.counters().unconverged, 0);
    }
}

/// Plies without tension in any motion, under a body in any motion: what they do to each other in a step is
/// all that happens.
#[derive(Clone, Debug)]
struct Meeting {
    scene: Scene,
    positions: Vec<f64>,
    velocities: Vec<f64>,
}

/// Mass of a body as a logarithm, whether it is round, its velocity and how fast it turns.
type Moving = (f64, bool, [f64; 3], [f64; 3]);

fn meetings(coefficient: std::ops::Range<f64>, share: std::ops::Range<f64>) -> impl Strategy<Value = Meeting> {
    let nodes = 6 * 5 * 4;
    let body = (share, any::<bool>(), [-1.0..1.0, -1.0..1.0, -1.0..1.0], [-1.0..1.0, -1.0..1.0, -1.0..1.0]);
    let of_nodes =
        prop::collection::vec(([-0.05..0.05, -0.05..0.05], 0.0..0.1, [-1.0..1.0, -1.0..1.0, -1.0..1.0]), nodes);
    let gap = prop_oneof![Just(0.0), 1e-5..3e-4];
    let quiet = prop_oneof![Just(0.0), 0.0..1.0];
    (coefficient, body, of_nodes, gap, quiet).prop_map(
        |(mu, (share, round, v, w), of_nodes, gap, quiet): (f64, Moving, _, f64, f64)| {
            let mut scene = stacked(small_sheet(5, 0.0), 4, gap);
            (scene.sheet.nodes_y, scene.attachment.kind) = (6, AttachmentKind::Free);
            scene.contact.friction = if mu < 1e-200 { 0.0 } else { mu };
            let h = scene.sheet.spacing;
            let body = &mut scene.projectile;
            (body.radius, body.length, body.mass) = (2.0 * h, 4.2 * h, scene.sheet.node_mass * share.exp());
            (body.shape, body.position) = (
                if round { Shape::Sphere } else { Shape::Cylinder },
                [0.1 * h, 0.0, if round { -2.0 * h } else { -2.1 * h }],
            );
            // A tenth of a spacing in a step.
            body.velocity = [3000.0 * v[0], 3000.0 * v[1], 6000.0 + 3000.0 * v[2]];
            body.angular_velocity = [0, 1, 2].map(|k| 5e5 * w[k]);
            let (mut positions, mut velocities) = (Vec::new(), Vec::new());
            let mut heights = [0.0; 30];
            for (k, (aside, above, v)) in of_nodes.into_iter().enumerate() {
                let (ply, j, i) = (k / 30, k % 30 / 5, k % 5);
                // Nearer together than the yarn is long; on the ply below or above it.
                let height = &mut heights[k % 30];
                *height += if above < 0.05 { 0.0 } else { above * h };
                positions.extend([
                    (0.5 * (i as f64 - 2.0) + aside[0]) * h,
                    (0.5 * (j as f64 - 2.5) + aside[1]) * h,
                    ply as f64 * gap + *height,
                ]);
                velocities.extend(v.map(|v| 2000.0 * quiet * v));
            }
            Meeting { scene, positions, velocities }
        },
    )
}

/// Meeting on a curve of 40 spacings, with the body as much lower as the sheet's edges: outwards is there
/// what z is here.
fn on_a_curve(meeting: Meeting) -> Meeting {
    let Meeting { mut scene, mut positions, mut velocities } = meeting;
    let radius = 40.0 * scene.sheet.spacing;
    scene.sheet.radius = radius;
    scene.projectile.position[2] += 0.5 * radius - 0.03 * scene.sheet.spacing;
    for (k, (x, v)) in positions.chunks_exact_mut(3).zip(velocities.chunks_exact_mut(3)).enumerate() {
        let (i, h, turned) = ((k % 5) as f64 - 2.0, scene.sheet.spacing, axes_of(&scene, k));
        let aside = x[0] - 0.5 * i * h;
        x.copy_from_slice(&turned([aside, x[1], 0.5 * radius + x[2]], 1.0));
        let own = [v[0], v[1], v[2]];
        v.copy_from_slice(&turned(own, 1.0));
    }
    Meeting { scene, positions, velocities }
}

/// A vector out of the axes of a node's column, or with the sign -1 into them.
fn axes_of(scene: &Scene, k: usize) -> impl Fn([f64; 3], f64) -> [f64; 3] + use<> {
    let (i, h, radius) = ((k % 5) as f64 - 2.0, scene.sheet.spacing, scene.sheet.radius);
    let (sine, cosine) = if radius == 0.0 { (0.0, 1.0) } else { (i * 2.0 * (0.5 * h / radius).asin()).sin_cos() };
    move |[x, y, z], sign| [cosine * x + sign * sine * z, y, cosine * z - sign * sine * x]
}

/// Steps once and checks the balances, whether the solve has converged or not. What plies and what the body
/// lost, of the energy before.
fn meet(meeting: &Meeting) -> Result<[f64; 2], TestCaseError> {
    let mut sim = sim_of(&meeting.scene);
    sim.set_motion(&meeting.positions, &meeting.velocities).unwrap();
    let before = sim.energy().unwrap();
    let start = before.projectile_kinetic + before.fabric_kinetic;
    prop_assert!(before.strain == 0.0);
    sim.step().unwrap();
    let energy = sim.energy().unwrap();
    let end = energy.projectile_kinetic + energy.fabric_kinetic;
    prop_assert!(energy.strain == 0.0);
    prop_assert!(end <= start * (1.0 + 1e-12), "{:e} of {start:e} gained", end - start);
    let lost = energy.contact_loss + energy.friction + energy.ply_loss;
    prop_assert!((start - end - lost).abs() < 1e-11 * start, "{energy:?}");
    // Pairs that part before the body pushes them together take a share that another pair or the body loses:
    // only the sum never gains.
    let at_rest = meeting.velocities.iter().all(|v| *v == 0.0);
    prop_assert!(!at_rest || energy.ply_loss >= -1e-12 * start, "{energy:?}");
    let size = 6000.0 * meeting.scene.projectile.mass + 120.0 * 2000.0 * meeting.scene.largest_mass();
    prop_assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * size);
    // No pair that faces each other ends through each other.
    let x = positions(&sim);
    let h = meeting.scene.sheet.spacing;
    for (k, above) in x.iter().enumerate().skip(30) {
        let (below, was, was_below) = (x[k - 30], &meeting.positions[3 * k..], &meeting.positions[3 * k - 90..]);
        if (was[0] - was_below[0]).abs() < h && (was[1] - was_below[1]).abs() < h {
            let [_, _, gap] = axes_of(&meeting.scene, k)(sub(*above, below), -1.0);
            prop_assert!(gap > -1e-13, "{k}");
        }
    }
    Ok([energy.ply_loss / start, (energy.contact_loss + energy.friction) / start])
}

/// Runs 500 meetings. The body meets plies in most of them, and plies push on each other in many: half of the
/// gaps are open at the start.
fn meet_all(meetings: impl Strategy<Value = Meeting>) {
    let (of_plies, of_body) = (Cell::new(0), Cell::new(0));
    let met = |counter: &Cell<u32>, yes: bool| counter.set(counter.get() + u32::from(yes));
    TestRunner::new(crate::random(500))
        .run(&meetings, |meeting| {
            let [plies, body] = meet(&meeting)?;
            met(&of_plies, plies.abs() > 1e-6);
            met(&of_body, body.abs() > 1e-6);
            Ok(())
        })
        .unwrap();
    assert!(of_plies.get() > 150 && of_body.get() > 400, "{of_plies:?} {of_body:?}");
}

#[test]
fn plies_and_a_body_that_meet_or_rub_lose_energy() {
    meet_all(meetings(0.0..1e-300, 0.0..12.0));
    meet_all(meetings(0.01..10.0, 0.0..12.0));
}

#[test]
fn and_so_do_plies_on_a_curve() {
    for friction in [0.0..1e-300, 0.01..10.0] {
        meet_all(meetings(friction, 0.0..12.0).prop_map(on_a_curve));
    }
}

/// Two plies of a fabric of 0.05 to 20 times the mass.
#[test]
fn and_so_do_plies_of_two_masses() {
    for friction in [0.0..1e-300, 0.01..10.0] {
        meet_all((meetings(friction, 0.0..12.0), -3.0..3.0).prop_map(|(mut meeting, share): (Meeting, f64)| {
            meeting.scene = with_back(meeting.scene, 2, |back| back.node_mass *= share.exp());
            // The projectile is heavier than a node of either.
            meeting.scene.projectile.mass *= share.max(0.0).exp();
            meeting
        }));
    }
}

/// The stack with its projectile between two plies that are far apart, and the second of them by itself,
/// until a segment fails.
fn behind_the_first(mut stack: Scene, mut alone: Scene) -> [Sim<'static>; 2] {
    stack.projectile.position[2] = stack.stack.gap - stack.projectile.radius;
    (alone.sheet.position[2], alone.projectile.position) = (stack.stack.gap, stack.projectile.position);
    let [mut both, mut alone] = [stack, alone].map(|scene| sim_of(&scene));
    while alone.counters().failed_segments == 0 {
        both.advance(10).unwrap();
        alone.advance(10).unwrap();
    }
    [both, alone]
}

/// A turned ply of a fabric with unlike directions is the fabric with its directions exchanged.
#[test]
fn a_turned_ply_has_its_warp_along_y() {
    let mut scene = small_sheet(21, 120.0);
    (scene.sheet.yarn_area_y, scene.sheet.crimp) = (0.7e-7, [0.002, 0.0]);
    scene.weft.critical_stretch = 1.02;
    scene.time_step = TimeStep::seconds(1.5e-8);
    let mut exchanged = scene;
    (exchanged.sheet.yarn_area, exchanged.sheet.yarn_area_y) = (0.7e-7, scene.sheet.yarn_area);
    exchanged.sheet.crimp = [0.0, 0.002];
    (exchanged.yarn.critical_stretch, exchanged.weft.critical_stretch) = (1.02, 1.03);
    let mut stack = stacked(scene, 2, 0.05);
    stack.stack.turned = true;
    let [both, alone] = behind_the_first(stack, exchanged);
    assert!(apart(&of_ply(&both, 1), &positions(&alone)) < 1e-9);
    let half = damage(&both).len() / 2;
    let worst = damage(&both)[half..].iter().zip(damage(&alone)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-6 && damage(&alone).iter().any(|alpha| *alpha < 1.0), "{worst}");
}

#[test]
fn sixty_plies_and_a_thousand_tiny_ones_run() {
    let sim = stepped(&drawn(stacked(small_sheet(21, 200.0), 60, 2.5e-4)), 40);
    assert!(sim.ply(0).unwrap().kinetic > 0.0 && sim.ply(59).unwrap().kinetic == 0.0, "the last rests");
    assert!(sim.energy().unwrap().residual.abs() < 1e-3 * 168.0);
    let mut tiny = stacked(small_sheet(2, 50.0), 1000, 0.0);
    tiny.attachment.kind = AttachmentKind::Free;
    assert!(stepped(&tiny, 100).contact().unwrap().work > 0.0);
}

/// The scene's own fabric in the last plies, but for what `change` makes of it.
pub(crate) fn with_back(mut scene: Scene, plies: u32, change: impl Fn(&mut fabric_kernel::Back)) -> Scene {
    let (sheet, yarn) = (scene.sheet, scene.yarn);
    scene.back = fabric_kernel::Back {
        plies,
        node_mass: sheet.node_mass,
        yarn_area: sheet.yarn_area,
        yarn_area_y: sheet.yarn_area_y,
        crimp: sheet.crimp,
        modulus_mean: yarn.modulus_mean,
        modulus_sd: if yarn.stochastic { yarn.modulus_sd } else { 0.0 },
        damage_slope: yarn.damage_slope,
        damage_intercept: yarn.damage_intercept,
        damage_sd: if yarn.stochastic { yarn.damage_sd } else { 0.0 },
        critical_stretch: yarn.critical_stretch,
        weibull_shape: if yarn.strength_draw == fabric_kernel::StrengthDraw::None { 0.0 } else { yarn.weibull_shape },
        weibull_gauge_length: yarn.weibull_gauge_length,
    };
    change(&mut scene.back);
    scene
}

/// A lighter, softer and more extensible fabric.
pub(crate) fn another(back: &mut fabric_kernel::Back) {
    (back.node_mass, back.yarn_area, back.modulus_mean) = (4.1e-8, 0.7e-7, 80e9);
    (back.damage_slope, back.damage_intercept, back.critical_stretch) = (0.0, 400.0, 1.035);
}

/// A back fabric that is the front one changes no bit, whatever is drawn and torn.
#[test]
fn a_back_fabric_like_the_front_one_gives_the_same_bits() {
    let uniform = small_sheet(31, 250.0);
    let (mut strength, mut viscous) = (drawn(uniform), as_proposed(uniform));
    (strength.yarn.strength_draw, strength.yarn.weibull_shape) = (fabric_kernel::StrengthDraw::Weibull, 6.0);
    (viscous.sheet.yarn_area_y, viscous.sheet.crimp) = (0.9e-7, [0.002, 0.001]);
    for scene in [uniform, drawn(uniform), strength, viscous] {
        let one = Scene { time_step: TimeStep::seconds(1.5e-8), ..stacked(scene, 4, 2.5e-4) };
        let two = with_back(one, 2, |_| ());
        // The stiffest and the strongest segment need not be of one fabric.
        let [limit, own] = [&one, &two].map(|scene| scene.step_limits().unwrap().dt_crit);
        assert!(own >= limit && own < 1.01 * limit, "{own} {limit}");
        let (mut one, mut two) = (sim_of(&one), sim_of(&two));
        for _ in 0..8 {
            one.advance(100).unwrap();
            two.advance(100).unwrap();
            assert_eq!(positions(&one), positions(&two));
            assert_eq!((one.energy().unwrap(), one.counters()), (two.energy().unwrap(), two.counters()));
            assert_eq!(
                (one.contact().unwrap(), one.support().unwrap()),
                (two.contact().unwrap(), two.support().unwrap())
            );
        }
        assert!(one.counters().failed_segments > 10);
    }
}

/// Far apart a ply of another fabric is a shield of that fabric.
#[test]
fn a_ply_of_another_fabric_far_behind_is_a_shield_of_it() {
    for stochastic in [false, true] {
        let mut scene = small_sheet(31, 90.0);
        (scene.yarn.stochastic, scene.time_step) = (stochastic, TimeStep::seconds(1.5e-8));
        let stack = with_back(stacked(scene, 2, 0.05), 1, another);
        let alone = Scene { stack: scene.stack, seed: scene.ply_seed(1), ..stack.all_of_back() };
        let [both, mut alone] = behind_the_first(stack, alone);
        let deflection = alone.fabric().unwrap().max_deflection;
        assert!(apart(&of_ply(&both, 1), &positions(&alone)) < 1e-7 * deflection);
        let (ply, energy) = (both.ply(1).unwrap(), alone.energy().unwrap());
        close(ply.kinetic, energy.fabric_kinetic, 1e-7);
        close(ply.strain, energy.strain, 1e-7);
        close(ply.dissipated, energy.dissipated, 1e-5);
        close(both.contact().unwrap().work, alone.contact().unwrap().work, 1e-9);
        close(both.support().unwrap().total[2], alone.support().unwrap().total[2], 1e-6);
        assert_eq!(both.ply(0).unwrap().kinetic, 0.0);
    }
}

/// The second of two shields in series, of the same fabric or of another, is hit by what the first has left.
/// The fragments of the first that fly on and the chaos after the first failure leave some percent of what
/// two shields take.
#[test]
fn a_projectile_goes_through_two_plies_as_through_two_shields() {
    let mut scene = small_sheet(31, 200.0);
    scene.time_step = TimeStep::seconds(1.5e-8);
    let (stack, run) = (stacked(scene, 2, 0.03), |scene: &Scene| {
        let mut sim = sim_of(scene);
        sim.advance_until(Outcome::Exited, 30_000).unwrap();
        assert!(sim.outcomes().mask.has(Outcome::Exited), "{scene:?}");
        (sim.projectile().unwrap().velocity[2], sim.counters().failed_segments)
    });
    let (after_first, failed) = run(&scene);
    for (both, second) in [(stack, scene), (with_back(stack, 1, another), with_back(stack, 1, another).all_of_back())] {
        let mut next = Scene { stack: scene.stack, ..second };
        next.projectile.velocity[2] = after_first;
        let ((after_second, failed_second), (through, failed_both)) = (run(&next), run(&both));
        println!(
            "{after_first} then {after_second}, through both {through}; failed {failed} {failed_second} {failed_both}"
        );
        close(200.0 - through, 200.0 - after_second, 0.05);
        assert!(failed_both > failed && failed_both > failed_second);
    }
}

/// A pull on a yarn runs along it at sqrt(E A_0/mu), with the mass mu that it drags along: in each ply with
/// its own numbers.
#[test]
fn the_wave_in_each_ply_has_its_own_speed() {
    let mut scene = without_projectile(small_sheet(161, 0.0));
    scene.time_step = TimeStep::fraction(0.1);
    let stack = with_back(stacked(scene, 2, 0.01), 1, another);
    let mut sim = sim_of(&stack);
    // All columns to the left of the middle move away from the right ones at a speed that damages nothing.
    set_off(&mut sim, |k, x| {
        let (i, j) = (k % 161, k / 161 % 161);
        [x, [if i == 0 || i > 80 || j == 0 || j == 160 { 0.0 } else { -20.0 }, 0.0, 0.0]]
    });
    // Where a node of the middle row has half the speed that it has within the front: the front has gone c t
    // from the middle.
    let front = |sim: &Sim<'_>, ply: usize| {
        let all = velocities(sim);
        let row = &all[ply * 161 * 161 + 80 * 161..][..161];
        let behind = 0.5 * -20.0 * 0.5;
        let k = (81..160).find(|&k| row[k][0] > behind).unwrap();
        let [a, b] = [row[k - 1][0], row[k][0]];
        (k as f64 - 1.0 + (behind - a) / (b - a) - 80.5) * stack.sheet.spacing
    };
    let mut at = |time: f64| {
        sim.advance((time / sim.step_limits().dt) as u64 - sim.step_count()).unwrap();
        (sim.time(), [front(&sim, 0), front(&sim, 1)])
    };
    let (first, last) = (at(1.2e-6), at(3.2e-6));
    for (ply, fabric) in [stack, stack.all_of_back()].into_iter().enumerate() {
        let speed = (last.1[ply] - first.1[ply]) / (last.0 - first.0);
        let mass_per_length = fabric.sheet.node_mass / fabric.sheet.spacing;
        let expected = (fabric.yarn.modulus_mean * fabric.sheet.yarn_area / mass_per_length).sqrt();
        println!("ply {ply}: {speed} m/s, {expected} m/s in theory");
        close(speed, expected, 0.03);
    }
    assert_eq!(sim.counters().failed_segments, 0);
}

/// The step is that of the fabric that allows less.
#[test]
fn the_step_is_that_of_the_stricter_fabric() {
    let scene = stacked(small_sheet(11, 50.0), 3, 1e-4);
    let scene = Scene { time_step: TimeStep::fraction(0.4), ..scene };
    for change in
        [another as fn(&mut fabric_kernel::Back), |back| back.modulus_mean *= 2.0, |back| back.node_mass *= 0.5]
    {
        let hybrid = with_back(scene, 1, change);
        let [front, back] = [scene, hybrid.all_of_back()].map(|scene| scene.step_limits().unwrap());
        let both = hybrid.step_limits().unwrap();
        assert_eq!((both.dt_crit, both.step_max), (front.dt_crit.min(back.dt_crit), front.step_max.min(back.step_max)));
    }
}
