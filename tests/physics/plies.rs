//! Separate plies that push on each other, against closed forms: plies far apart, plies that lie on each other, a ply that falls on another,
//! and the balances of energy and momentum.

use fabric::{AttachmentKind, Code, Scene, Sim, Stack, TimeStep};
use fabric_tests::reference::length;
use fabric_tests::{Buffers, close, positions, small_sheet, velocities, without_projectile};

/// So many plies at this gap, m.
fn stacked(mut scene: Scene, plies: u32, gap: f64) -> Scene {
    scene.stack = Stack { plies, gap, turned: false };
    scene
}

/// Positions of one ply.
fn of_ply(sim: &Sim<'_>, ply: usize) -> Vec<[f64; 3]> {
    let nodes = sim.layout().nodes() / sim.layout().plies;
    positions(sim)[ply * nodes..(ply + 1) * nodes].to_vec()
}

/// Before it reaches the second ply a projectile knows the first alone, to the bit; and one that starts between the plies knows the second
/// alone, which has draws of its own.
#[test]
fn plies_far_apart_are_shields_of_their_own() {
    let mut scene = small_sheet(31, 90.0);
    (scene.yarn.stochastic, scene.time_step) = (true, TimeStep::seconds(2e-8));
    let gap = 0.05;
    let (stack, mut second) = (stacked(scene, 2, gap), scene);
    second.seed = scene.ply_seed(1);
    assert_ne!(second.seed, scene.seed);
    let (mut a, mut b) = (Buffers::of(&stack), Buffers::of(&scene));
    let (mut both, mut alone) = (a.sim(&stack), b.sim(&scene));
    both.advance(400).unwrap();
    alone.advance(400).unwrap();
    assert!(of_ply(&both, 0) == positions(&alone));
    assert_eq!(both.projectile().unwrap(), alone.projectile().unwrap());
    assert!(of_ply(&both, 1).iter().all(|x| x[2] == gap), "a ply at rest is not stepped");

    let (mut stack, mut alone) = (stack, second);
    stack.projectile.position[2] = gap - scene.projectile.radius;
    alone.sheet.position[2] = gap;
    alone.projectile.position = stack.projectile.position;
    let (mut a, mut b) = (Buffers::of(&stack), Buffers::of(&alone));
    let (mut both, mut alone) = (a.sim(&stack), b.sim(&alone));
    both.advance(300).unwrap();
    alone.advance(300).unwrap();
    let worst =
        of_ply(&both, 1).into_iter().zip(positions(&alone)).map(|(a, b)| length([0, 1, 2].map(|k| a[k] - b[k])));
    let worst = worst.fold(0.0, f64::max);
    let deflection = both.fabric().unwrap().max_deflection;
    assert!(worst < 1e-10 * deflection && deflection > 1e-3, "{worst:e} {deflection:e}");
    assert_eq!(both.counters().failed_segments, 0);
}

/// Two plies that lie on each other and are alike, pushed by a flat or a round body: the lumped sheet of twice the mass, up to the first
/// failure.
#[test]
fn plies_on_each_other_move_as_the_lumped_sheet() {
    for plies in [2, 3, 7] {
        let scene = small_sheet(31, 60.0);
        let (stack, mut lumped) = (stacked(scene, plies, 0.0), scene);
        lumped.sheet.plies = plies;
        let (mut a, mut b) = (Buffers::of(&stack), Buffers::of(&lumped));
        let (mut apart, mut one) = (a.sim(&stack), b.sim(&lumped));
        for _ in 0..8 {
            apart.advance(50).unwrap();
            one.advance(50).unwrap();
            assert_eq!(apart.counters().failed_segments + one.counters().failed_segments, 0);
            let (a, b) = (apart.projectile().unwrap().velocity[2], one.projectile().unwrap().velocity[2]);
            assert!((a - b).abs() < 1e-9 * 60.0, "{plies} plies at step {}: {a} {b}", one.step_count());
        }
        println!("{plies}: {:?} {:?}", apart.counters(), apart.energy().unwrap());
        let (a, b) = (apart.energy().unwrap(), one.energy().unwrap());
        close(a.contact_work, b.contact_work, 1e-9);
        close(a.strain, b.strain, 1e-7);
        assert!(a.residual.abs() < 1e-3 * 15.0, "{}", a.residual);
    }
}
