//! Physics in another frame or with another number of plies.

use fabric_kernel::Scene;
use fabric_tests::reference::{V3, add, largest_distance, length, sub, turn};
use fabric_tests::{positions, small_sheet, stepped, tilted_cylinder, velocities};

const STEPS: u64 = 400;

/// The scene with everything moved and turned together.
fn moved(scene: &Scene, place: V3, q: [f64; 4]) -> Scene {
    let mut moved = *scene;
    (moved.sheet.position, moved.sheet.orientation) = (place, q);
    let body = &mut moved.projectile;
    body.position = add(turn(q, body.position), place);
    body.velocity = turn(q, body.velocity);
    body.angular_velocity = turn(q, body.angular_velocity);
    let [a, b, c, d] = q;
    let [w, x, y, z] = body.orientation;
    body.orientation = [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ];
    moved
}

/// A small sheet held on four sides, whole and soon taut, hardly amplifies rounding: a moved and turned scene
/// gives the moved and turned result.
#[test]
fn a_moved_and_turned_sheet_sees_the_same_physics() {
    let scene = tilted_cylinder(21, 0.3, 60.0);
    let q: [f64; 4] = [0.5, -0.5, 0.1, 0.7];
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (place, q) = ([0.3, -0.7, 0.2], q.map(|x| x / size));
    let sim = stepped(&scene, STEPS);
    let other = stepped(&moved(&scene, place, q), STEPS);
    assert!(sim.contact().unwrap().work > 0.0 && sim.counters().failed_segments == 0);

    let expected: Vec<V3> = positions(&sim).iter().map(|x| add(turn(q, *x), place)).collect();
    assert!(largest_distance(&positions(&other), &expected) < 1e-13);
    let expected: Vec<V3> = velocities(&sim).iter().map(|v| turn(q, *v)).collect();
    assert!(largest_distance(&velocities(&other), &expected) < 1e-8 * 60.0);
    let (body, turned) = (sim.projectile().unwrap(), other.projectile().unwrap());
    assert!(length(sub(turned.velocity, turn(q, body.velocity))) < 1e-12 * 60.0);
    assert!(length(sub(turned.angular_velocity, turn(q, body.angular_velocity))) < 1e-10 * 60.0 / 6.35e-3);
    let (contact, turned) = (sim.contact().unwrap(), other.contact().unwrap());
    assert!((contact.work - turned.work).abs() < 1e-10 * contact.work);
    assert!(length(sub(turned.impulse, turn(q, contact.impulse))) < 1e-10 * length(contact.impulse));
    let (support, turned) = (sim.support().unwrap(), other.support().unwrap());
    for (here, there) in support.attachments.iter().zip(turned.attachments) {
        assert!(length(sub(there, turn(q, *here))) < 1e-9 * length(contact.impulse));
    }
}

/// Half a turn about z only changes signs: the numbers are the same to the bit.
#[test]
fn half_a_turn_about_the_normal_changes_signs_only() {
    let mut scene = small_sheet(21, 60.0);
    scene.projectile.velocity = [3.0, -2.0, 60.0];
    let half_turn = [0.0, 0.0, 0.0, 1.0];
    let sim = stepped(&scene, STEPS);
    let other = stepped(&moved(&scene, [0.0; 3], half_turn), STEPS);
    let expected: Vec<V3> = positions(&sim).iter().map(|x| [-x[0], -x[1], x[2]]).collect();
    assert_eq!(positions(&other), expected);
    let v = sim.projectile().unwrap().velocity;
    assert!(v[2] < 60.0);
    assert_eq!(other.projectile().unwrap().velocity, [-v[0], -v[1], v[2]]);
}

/// n plies multiply node mass and yarn area by n; with n times the projectile's mass every velocity is the
/// same, and every impulse and energy n times as large. To the bit where n is a power of two, through
/// failure.
#[test]
fn plies_with_as_much_more_projectile_move_alike() {
    for (plies, velocity, steps) in [(3, 60.0, STEPS), (64, 100.0, 4000)] {
        let scene = small_sheet(21, velocity);
        let mut lumped = scene;
        lumped.sheet.plies = plies;
        lumped.projectile.mass *= f64::from(plies);
        let (sim, other, n) = (stepped(&scene, steps), stepped(&lumped, steps), f64::from(plies));
        assert_eq!(sim.counters().failed_segments > 0, plies == 64);
        let (work, lumped_work) = (sim.contact().unwrap().work, other.contact().unwrap().work);
        let (energy, lumped_energy) = (sim.energy().unwrap(), other.energy().unwrap());
        assert!(work > 0.0);
        if plies == 64 {
            assert_eq!(positions(&other), positions(&sim));
            assert_eq!(lumped_work, n * work);
            assert_eq!(lumped_energy.strain, n * energy.strain);
        } else {
            assert!(largest_distance(&positions(&other), &positions(&sim)) < 1e-14);
            assert!((lumped_work - n * work).abs() < 1e-11 * lumped_work);
            assert!((lumped_energy.strain - n * energy.strain).abs() < 1e-10 * lumped_energy.strain);
        }
    }
}

/// A uniform sheet hit in the middle stays mirror-symmetric to rounding over these few steps, and pulls alike
/// on opposite sides.
#[test]
fn the_uniform_sheet_keeps_its_mirror_planes() {
    let scene = small_sheet(21, 60.0);
    let sim = stepped(&scene, STEPS);
    let x = positions(&sim);
    let at = |i: usize, j: usize| x[21 * j + i];
    for j in 0..21 {
        for i in 0..21 {
            let (p, mirrored, turned) = (at(i, j), at(20 - i, j), at(j, i));
            assert!(length(sub(p, [-mirrored[0], mirrored[1], mirrored[2]])) < 1e-15);
            assert!(length(sub(p, [turned[1], turned[0], turned[2]])) < 1e-15);
        }
    }
    let [left, right, bottom, top] = sim.support().unwrap().attachments;
    let all = length(left);
    assert!(length(sub(left, [-right[0], right[1], right[2]])) < 1e-12 * all);
    assert!(length(sub(bottom, [top[0], -top[1], top[2]])) < 1e-12 * all);
}
