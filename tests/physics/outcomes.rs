//! Outcomes latch at the right time and say what a look at the sheet says.

use fabric::{AttachmentKind, Outcome, Scene, Status};
use fabric_tests::reference::{length, segment_ends, sub};
use fabric_tests::{Buffers, close, damage, positions, small_sheet, speed};

/// The mask of outcomes after at most `steps` steps, and the status.
fn outcome(scene: &Scene, steps: u64) -> (u32, Status, f64) {
    let mut memory = Buffers::of(scene);
    let mut sim = memory.sim(scene);
    sim.advance_until(Outcome::Arrested.bit() | Outcome::Exited.bit() | Outcome::Passed.bit(), steps).unwrap();
    let outcomes = sim.outcomes();
    for latch in outcomes.latched.iter().flatten() {
        assert!(latch.step.is_multiple_of(64) && latch.step > outcomes.first_contact.unwrap_or(0));
    }
    (outcomes.mask, outcomes.status, sim.contact().unwrap().work)
}

/// 0.5 J is less than the sheet can hold: the sphere comes to rest, having given all its energy, and flies back.
#[test]
fn a_slow_sphere_is_arrested_and_pushed_back() {
    let scene = small_sheet(41, speed(0.5, 8.4e-3));
    assert_eq!(outcome(&scene, 50_000).0, Outcome::Arrested.bit());
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    sim.advance_until(Outcome::Arrested.bit(), 50_000).unwrap();
    let latch = sim.outcomes().latched[Outcome::Arrested as usize].unwrap();
    assert!(latch.step == sim.step_count() && (latch.work / 0.5 - 1.0).abs() < 1e-2, "{latch:?}");
    assert_eq!(sim.outcomes().status, Status::Arrested);
    sim.advance(10_000).unwrap();
    assert!(sim.projectile().unwrap().velocity[2] < -1.0);
}

/// 40 J breaks through: exited, without ever having stopped.
#[test]
fn a_fast_sphere_exits() {
    let (mask, status, work) = outcome(&small_sheet(41, speed(40.0, 8.4e-3)), 50_000);
    assert_eq!(mask & Outcome::Exited.bit(), Outcome::Exited.bit());
    assert_eq!(mask & (Outcome::Arrested.bit() | Outcome::Passed.bit()), 0);
    assert_eq!(status, Status::Exited);
    assert!(work > 0.5 && work < 20.0);
}

/// A sphere beside the sheet passes, having lost exactly nothing.
#[test]
fn a_miss_passes_and_absorbs_exactly_nothing() {
    let mut scene = small_sheet(21, 100.0);
    scene.projectile.position[0] = 0.05;
    assert_eq!(outcome(&scene, 50_000), (Outcome::Passed.bit(), Status::Passed, 0.0));
}

/// A sphere at rest has no outcome, whatever the time.
#[test]
fn a_sphere_at_rest_has_no_outcome() {
    assert_eq!(outcome(&small_sheet(11, 0.0), 10_000), (0, Status::Flight, 0.0));
}

/// Where every node is fixed the sheet is a wall: the sphere stops, and all its energy is gone.
#[test]
fn a_sheet_of_fixed_nodes_is_a_wall() {
    let (mask, status, work) = outcome(&small_sheet(2, 100.0), 50_000);
    assert_eq!((mask, status), (Outcome::Arrested.bit(), Status::Arrested));
    close(work, 0.5 * 8.4e-3 * 1e4, 1e-12);
}

/// A sheet held at its corners and hit hard tears off: when "detached" latches, a search over the live segments from the
/// fixed nodes reaches no node that touches the sphere, and 64 steps earlier it did.
#[test]
fn a_torn_off_corner_sheet_is_detached() {
    let mut scene = small_sheet(61, speed(80.0, 8.4e-3));
    scene.attachment.kind = AttachmentKind::FourCorners;
    (scene.attachment.disc_inset, scene.attachment.disc_radius) = (3.5e-3, 3.0e-3);
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let reaches = |sim: &fabric::Sim<'_>| {
        let half = scene.half_size()[0];
        let (c, r) = (scene.attachment.disc_inset, scene.attachment.disc_radius);
        let rest = fabric_tests::reference::rest_positions(&scene);
        let mut held: Vec<bool> =
            rest.iter().map(|x| (x[0].abs() - half + c).hypot(x[1].abs() - half + c) <= r).collect();
        assert!(held.iter().filter(|&&h| h).count() > 4);
        let (ends, alpha) = (segment_ends(&scene), damage(sim));
        loop {
            let mut grown = false;
            for ([a, b], _) in ends.iter().zip(&alpha).filter(|(_, alpha)| **alpha > 0.0) {
                if held[*a] != held[*b] {
                    (held[*a], held[*b], grown) = (true, true, true);
                }
            }
            if !grown {
                break;
            }
        }
        let centre = sim.projectile().unwrap().position;
        let touching = |x: &[f64; 3]| length(sub(*x, centre)) - scene.projectile.radius < 1e-9;
        positions(sim).iter().zip(&held).any(|(x, held)| *held && touching(x))
    };
    let mut held_before = false;
    while sim.outcomes().mask & Outcome::Detached.bit() == 0 && sim.step_count() < 30_000 {
        held_before = reaches(&sim);
        sim.advance(64).unwrap();
    }
    let latch = sim.outcomes().latched[Outcome::Detached as usize].expect("detached");
    assert_eq!(latch.step, sim.step_count());
    assert!(!reaches(&sim), "no touched node is held");
    assert!(held_before, "64 steps earlier one was");
    assert!(sim.counters().failed_segments > 40);
}

/// No outcome changes the physics: a run that watches for detachment and one that does not move alike.
#[test]
fn watching_for_detachment_changes_nothing() {
    let mut scene = small_sheet(31, speed(40.0, 8.4e-3));
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    scene.track_detachment = false;
    scene.track_support = false;
    let mut other_memory = Buffers::of(&scene);
    let mut other = other_memory.sim(&scene);
    sim.advance(1500).unwrap();
    other.advance(1500).unwrap();
    assert!(sim.counters().failed_segments > 0);
    assert_eq!(positions(&sim), positions(&other));
    assert_eq!(sim.projectile().unwrap(), other.projectile().unwrap());
}
