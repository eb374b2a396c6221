//! The bits of a run depend on the scene and the number of steps alone, not on how the calls are made. Every scene here runs
//! past its first failures, where any difference of rounding would grow.

use fabric::{AttachmentKind, Drive, InstructionSet, Motion, Path, Scene, Sim};
use fabric_tests::{Buffers, damage, positions, small_sheet, tilted_cylinder, velocities};

const STEPS: u64 = 700;

fn scenes() -> [Scene; 4] {
    let mut corners = small_sheet(23, 500.0);
    corners.yarn.stochastic = true;
    corners.attachment.kind = AttachmentKind::FourCorners;
    (corners.attachment.disc_inset, corners.attachment.disc_radius) = (1e-3, 0.8e-3);
    corners.projectile.radius = 3e-3;
    corners.projectile.position[2] = -3e-3;
    let mut oblong = tilted_cylinder(17, 0.3, 500.0);
    (oblong.sheet.nodes_y, oblong.sheet.plies) = (29, 2);
    let softened = Scene { slack_toe: 0.02, ..small_sheet(21, 250.0) };
    [small_sheet(21, 250.0), corners, oblong, softened]
}

/// Digest of a plain run.
fn plain(scene: &Scene) -> u64 {
    let mut memory = Buffers::of(scene);
    let mut sim = memory.sim(scene);
    sim.advance(STEPS).unwrap();
    assert!(sim.counters().failed_segments > 0, "{:?}", scene.projectile.shape);
    sim.digest()
}

/// Runs every scene in a special way and compares with the plain run.
#[track_caller]
fn same_bits(special: impl Fn(&mut Sim<'_>)) {
    for scene in scenes() {
        let mut memory = Buffers::of(&scene);
        let mut sim = memory.sim(&scene);
        special(&mut sim);
        assert_eq!(sim.step_count(), STEPS);
        assert_eq!(sim.digest(), plain(&scene));
    }
}

#[test]
fn two_runs_are_alike() {
    same_bits(|sim| sim.advance(STEPS).unwrap());
}

#[test]
fn any_split_of_the_steps_is_alike() {
    same_bits(|sim| (0..STEPS).for_each(|_| sim.step().unwrap()));
    same_bits(|sim| {
        let mut batch = 1;
        while sim.step_count() < STEPS {
            sim.advance(batch.min(STEPS - sim.step_count())).unwrap();
            sim.advance(0).unwrap();
            batch = batch * 5 % 97;
        }
    });
    same_bits(|sim| {
        while sim.step_count() < STEPS {
            sim.advance_until(0, 11.min(STEPS - sim.step_count())).unwrap();
        }
    });
}

#[test]
fn read_outs_change_nothing() {
    same_bits(|sim| {
        let mut image = vec![0; sim.snapshot_bytes()];
        while sim.step_count() < STEPS {
            sim.advance(7).unwrap();
            let _ = (sim.energy(), sim.fabric(), sim.support(), sim.contact(), sim.projectile(), sim.outcomes());
            let _ = (sim.momentum_residual(), sim.counters(), sim.digest(), sim.save(&mut image));
            let _ = (positions(sim), velocities(sim), damage(sim));
        }
    });
}

#[test]
fn stepping_rows_at_rest_changes_nothing() {
    same_bits(|sim| {
        sim.step_every_row();
        sim.advance(STEPS).unwrap();
    });
}

#[test]
fn instruction_sets_change_nothing() {
    for set in InstructionSet::ALL {
        same_bits(|sim| {
            // One that this machine lacks is refused and leaves the widest.
            assert_eq!(sim.use_instructions(set).is_ok(), set.available());
            sim.advance(STEPS).unwrap();
        });
    }
}

#[test]
fn a_reset_starts_afresh() {
    same_bits(|sim| {
        let fresh = sim.digest();
        sim.set_external_load([1.0, 2.0, 3.0], [0.0; 3]).unwrap();
        sim.advance(600).unwrap();
        sim.reset();
        assert_eq!(sim.digest(), fresh);
        sim.advance(STEPS).unwrap();
    });
}

#[test]
fn saving_and_loading_in_the_middle_goes_on_alike() {
    for scene in scenes() {
        let expected = plain(&scene);
        // Before contact, during it, at an outcome test, after failures.
        for at in [0, 1, 64, 333, 640] {
            let mut memory = Buffers::of(&scene);
            let mut sim = memory.sim(&scene);
            sim.advance(at).unwrap();
            let mut image = vec![0xa5; sim.snapshot_bytes() + 3];
            sim.save(&mut image).unwrap();
            assert_eq!(image.split_off(sim.snapshot_bytes()), [0xa5; 3], "no more than its bytes");
            let here = sim.digest();

            // Into the same simulation, after it went elsewhere.
            sim.advance(99).unwrap();
            sim.load(&image).unwrap();
            assert_eq!(sim.digest(), here);
            sim.advance(STEPS - at).unwrap();
            assert_eq!(sim.digest(), expected);
            sim.load_kept(&image).unwrap();
            assert_eq!(sim.digest(), here);
            sim.advance(STEPS - at).unwrap();
            assert_eq!(sim.digest(), expected);

            // Into a fresh one in dirty memory; saving again gives the same bytes.
            let mut other_memory = Buffers::of(&scene);
            other_memory.reals.fill(f64::NAN);
            other_memory.words.fill(u32::MAX);
            let mut other = other_memory.sim(&scene);
            other.load(&image).unwrap();
            let mut again = vec![0; other.snapshot_bytes()];
            other.save(&mut again).unwrap();
            assert_eq!(again, image);
            assert_eq!(other.counters().failed_segments, {
                let mut whole = Buffers::of(&scene);
                let mut plain = whole.sim(&scene);
                plain.advance(at).unwrap();
                plain.counters().failed_segments
            });
            other.advance(STEPS - at).unwrap();
            assert_eq!(other.digest(), expected);
        }
    }
}

#[test]
fn two_simulations_do_not_see_each_other() {
    let [first, second, _, _] = scenes();
    let (mut a, mut b) = (Buffers::of(&first), Buffers::of(&second));
    let (mut a, mut b) = (a.sim(&first), b.sim(&second));
    for _ in 0..STEPS / 7 {
        a.advance(7).unwrap();
        b.advance(7).unwrap();
    }
    assert_eq!((a.digest(), b.digest()), (plain(&first), plain(&second)));
}

/// A path driven in one call, in single steps, in uneven pieces, and across a save and load.
#[test]
fn any_split_of_a_path_is_alike() {
    for mut scene in [small_sheet(21, 200.0), tilted_cylinder(21, 0.3, 200.0)] {
        scene.drive = Drive::Prescribed;
        let dt = scene.step_limits().unwrap().dt;
        let way = 250.0 * STEPS as f64 * dt;
        let start = scene.projectile.position;
        let end = Motion {
            position: [start[0] + 0.1 * way, start[1], start[2] + way],
            velocity: [0.0, 50.0, 220.0],
            orientation: [0.99, 0.0, (1.0f64 - 0.99 * 0.99).sqrt(), 0.0],
            angular_velocity: [0.0, 100.0, 0.0],
        };
        let path = Path { first: 0, steps: STEPS, end };
        let run = |special: &dyn Fn(&mut Sim<'_>)| {
            let mut memory = Buffers::of(&scene);
            let mut sim = memory.sim(&scene);
            special(&mut sim);
            assert_eq!(sim.step_count(), STEPS);
            assert!(sim.counters().failed_segments > 0);
            sim.digest()
        };
        let whole = run(&|sim| sim.follow(&path, STEPS).unwrap());
        assert_eq!(whole, run(&|sim| (0..STEPS).for_each(|_| sim.follow(&path, 1).unwrap())));
        assert_eq!(
            whole,
            run(&|sim| {
                sim.follow(&path, 123).unwrap();
                // Stepping goes along the path too.
                sim.advance(77).unwrap();
                let mut image = vec![0; sim.snapshot_bytes()];
                sim.save(&mut image).unwrap();
                sim.reset();
                sim.load(&image).unwrap();
                sim.follow(&path, STEPS - 200).unwrap();
            })
        );
    }
}
