//! Row bands: whatever the cut, the order of the bands and the threads, the bits are those of plain steps,
//! through failure; a band out of turn is refused and changes nothing.

use fabric_kernel::internals::layout::MAX_BANDS;
use fabric_kernel::{AttachmentKind, Bands, CacheLine, Code, Error, InstructionSet, Outcome, Scene, Sim, Symmetry};
use fabric_tests::{as_proposed, drawn, golden, sim_of, small_sheet, stepped};
use std::sync::Barrier;

fn scratch(sim: &Sim<'_>, of: u32) -> Vec<CacheLine> {
    vec![CacheLine([f64::NAN; 8]); sim.layout().band_lines(of).unwrap()]
}

/// Takes `steps` steps with all bands on this thread, in an order that changes with every pass.
pub fn in_turn(sim: &mut Sim<'_>, of: u32, steps: u64) -> Result<(), Error> {
    let mut scratch = scratch(sim, of);
    let bands = sim.bands(&mut scratch, of, steps)?;
    let mut passes = 0;
    while bands.steps() < steps {
        for k in 0..of {
            let band = (7 * k + passes as u32) % of;
            assert_eq!(bands.pass(band)?, k + 1 == of, "the last and no other completes the pass");
        }
        passes += 1;
        assert_eq!(bands.passes(), passes);
    }
    Ok(())
}

/// Runs threads to their end. They are joined one by one: of the end of a scope ThreadSanitizer knows
/// nothing.
fn side_by_side(count: u32, run: impl Fn(u32) + Sync) {
    std::thread::scope(|threads| {
        let run = &run;
        let threads: Vec<_> = (0..count).map(|thread| threads.spawn(move || run(thread))).collect();
        threads.into_iter().for_each(|thread| thread.join().unwrap());
    });
}

/// Takes `steps` steps with a thread for every band.
fn on_threads(sim: &mut Sim<'_>, of: u32, steps: u64) {
    let mut scratch = scratch(sim, of);
    let bands = sim.bands(&mut scratch, of, steps).unwrap();
    side_by_side(of, |band| {
        while bands.steps() < steps {
            let passes = bands.passes();
            bands.pass(band).unwrap();
            while bands.passes() == passes {
                std::thread::yield_now();
            }
        }
    });
}

/// Runs a scene plainly and in bands of several numbers, in two parts, prepared as told. (`invariance.rs`
/// does so with every pair of options.)
#[track_caller]
fn same_bits(scene: &Scene, steps: u64, prepare: impl Fn(&mut Sim<'_>)) {
    let mut plain = sim_of(scene);
    prepare(&mut plain);
    plain.advance(steps).unwrap();
    failed(&plain);
    for of in [1, 2, 3, 5, MAX_BANDS] {
        let mut sim = sim_of(scene);
        prepare(&mut sim);
        in_turn(&mut sim, of, steps / 3).unwrap();
        sim.advance(10).unwrap();
        in_turn(&mut sim, of, steps - steps / 3 - 10).unwrap();
        assert_eq!(sim.digest(), plain.digest(), "{of} bands");
        assert_eq!((sim.counters(), sim.outcomes()), (plain.counters(), plain.outcomes()), "{of} bands");
        assert_eq!(sim.energy(), plain.energy());
    }
}

fn failed(sim: &Sim<'_>) {
    assert!(sim.counters().failed_segments > 0);
}

#[test]
fn rows_at_rest_stepped_or_not() {
    let scene = small_sheet(41, 250.0);
    // While the wave still runs outwards: fewer rows than bands, then more.
    for steps in [1, 2, 3, 12, 40] {
        for of in [1, 2, 3, 5] {
            let mut sim = sim_of(&scene);
            in_turn(&mut sim, of, steps).unwrap();
            assert_eq!(sim.digest(), stepped(&scene, steps).digest(), "{of} bands, {steps} steps");
        }
    }
    same_bits(&scene, 900, |sim| sim.step_every_row());
    // A sphere that breaks the sheet's middle and wedges between its supports, which take impulses.
    same_bits(&small_sheet(15, 60.0), 2500, |_| ());
}

#[test]
fn mirror_planes() {
    for (mirror_x, mirror_y) in [(true, false), (false, true), (true, true)] {
        for nodes in [20, 21] {
            let mut scene = small_sheet(nodes, 250.0);
            scene.symmetry = Symmetry { mirror_x, mirror_y };
            same_bits(&scene, 500, |_| ());
            scene.yarn.viscosity_bending = 0.01;
            same_bits(&scene, 500, |_| ());
        }
    }
}

/// Yarns slip in their clamps and come out, and one of four bolts fails, at the same steps.
#[test]
fn clamps_that_slip() {
    for (kind, hold, strength) in [(AttachmentKind::FourSides, 350.0, 0.0), (AttachmentKind::FourCorners, 500.0, 3.3e3)]
    {
        let mut scene = small_sheet(41, 150.0);
        (scene.attachment.kind, scene.attachment.hold, scene.attachment.strength) = (kind, hold, strength);
        (scene.attachment.grip, scene.attachment.disc_inset, scene.attachment.disc_radius) = (3e-4, 3.5e-3, 3e-3);
        let plain = stepped(&scene, 2000);
        let fails = plain.outcomes().mask.has(Outcome::AttachmentFailed);
        assert!(plain.energy().unwrap().attachment > 0.0 && fails == (strength > 0.0));
        same_bits(&scene, 2000, |_| ());
    }
}

#[test]
fn threads() {
    let plain = drawn(small_sheet(29, 500.0));
    let balanced = Scene { slack_balance: true, ..small_sheet(21, 250.0) };
    let mut viscous = plain;
    viscous.yarn.viscosity_bending = 0.01;
    for scene in [plain, balanced, viscous] {
        let plain = stepped(&scene, 700);
        failed(&plain);
        for of in [1, 2, 3, 5] {
            let mut sim = sim_of(&scene);
            on_threads(&mut sim, of, 700);
            assert_eq!(sim.digest(), plain.digest(), "{of} threads");
        }
    }
}

/// The band is refused, and nothing that can be seen changes.
#[track_caller]
fn band_refused(bands: &Bands<'_, '_>, band: u32, code: Code, field: &str) {
    let before = (bands.passes(), bands.steps(), bands.outcomes());
    let error = bands.pass(band).unwrap_err();
    assert_eq!((error.code, error.field), (code, field));
    assert_eq!((bands.passes(), bands.steps(), bands.outcomes()), before);
}

#[test]
fn a_band_out_of_turn_is_refused_and_changes_nothing() {
    let scene = small_sheet(21, 250.0);
    let plain = stepped(&scene, 40);

    let mut sim = sim_of(&scene);
    let mut scratch = scratch(&sim, 3);
    let bands = sim.bands(&mut scratch, 3, 0).unwrap();
    for _ in 0..40 {
        band_refused(&bands, 3, Code::OutOfRange, "band");
        band_refused(&bands, u32::MAX, Code::OutOfRange, "band");
        assert!(!bands.pass(1).unwrap());
        band_refused(&bands, 1, Code::BandOutOfTurn, "band");
        assert!(!bands.pass(0).unwrap());
        band_refused(&bands, 0, Code::BandOutOfTurn, "band");
        band_refused(&bands, 1, Code::BandOutOfTurn, "band");
        assert!(bands.pass(2).unwrap());
    }
    drop(bands);
    assert_eq!(sim.digest(), plain.digest());
}

#[test]
fn threads_that_fight_for_one_band_share_its_turns() {
    let scene = small_sheet(21, 250.0);
    let plain = stepped(&scene, 200);

    let mut sim = sim_of(&scene);
    let mut scratch = scratch(&sim, 2);
    let bands = sim.bands(&mut scratch, 2, 0).unwrap();
    let start = Barrier::new(4);
    side_by_side(4, |thread| {
        start.wait();
        for turn in 0.. {
            if bands.steps() >= 150 {
                break;
            }
            // Now and then refused, now and then not; never waits for anyone.
            match bands.pass((thread + turn) % 2) {
                Ok(_) => (),
                Err(error) => assert_eq!(error.code, Code::BandOutOfTurn),
            }
            std::thread::yield_now();
        }
    });
    // One pass may have been begun beyond the last; dropping the bands completes it.
    drop(bands);
    assert!((150..=152).contains(&sim.step_count()));
    sim.advance(200 - sim.step_count()).unwrap();
    assert_eq!(sim.digest(), plain.digest());
}

/// A sheet beyond the caches that is hit at once, which takes eight steps in a block.
fn large_sheet() -> Scene {
    let mut scene = small_sheet(447, 250.0);
    scene.projectile.position[2] = -scene.projectile.radius;
    scene.contact_capacity = 2000;
    scene
}

#[test]
fn bands_of_a_large_sheet_take_its_steps_in_blocks_with_the_same_bits() {
    // Viscosity reaches one row further, and takes four steps in a block.
    for scene in [large_sheet(), as_proposed(large_sheet())] {
        let mut plain = sim_of(&scene);
        plain.step_every_row();
        (0..43).for_each(|_| plain.step().unwrap());
        for of in [1, 2, 5] {
            let mut sim = sim_of(&scene);
            sim.step_every_row();
            // Five blocks (or ten) and three single steps on threads, with a call of less than a block.
            on_threads(&mut sim, of, 24);
            in_turn(&mut sim, of, 3).unwrap();
            on_threads(&mut sim, of, 16);
            assert_eq!((sim.step_count(), sim.digest()), (43, plain.digest()), "{of} bands");
        }
        let energy = plain.energy().unwrap();
        assert!(energy.fabric_kinetic > 0.0 && (energy.viscous > 0.0) == (scene.yarn.viscosity_bending > 0.0));
    }
}

#[test]
fn dropping_bands_completes_a_begun_block() {
    if !InstructionSet::Avx2.available() {
        return; // No blocks.
    }
    let scene = large_sheet();
    let mut plain = sim_of(&scene);
    plain.step_every_row();
    (0..8).for_each(|_| plain.step().unwrap());
    for calls in [0, 1, 3, 7, 20] {
        let mut sim = sim_of(&scene);
        sim.step_every_row();
        let mut scratch = scratch(&sim, 3);
        let bands = sim.bands(&mut scratch, 3, 1000).unwrap();
        (0..calls).for_each(|call| assert!(bands.pass(call % 3).is_ok()));
        assert_eq!(bands.steps(), 0);
        drop(bands);
        assert_eq!(sim.step_count(), if calls > 0 { 8 } else { 0 });
        sim.advance(8 - sim.step_count()).unwrap();
        assert_eq!(sim.digest(), plain.digest(), "{calls} calls");
    }
}

#[test]
fn dropping_bands_completes_a_begun_step() {
    let mut scene = small_sheet(21, 250.0);
    scene.slack_balance = true;
    completed_when_dropped(&scene);
    scene.yarn.viscosity_bending = 0.06;
    completed_when_dropped(&scene);
}

fn completed_when_dropped(scene: &Scene) {
    let plain = stepped(scene, 700);
    failed(&plain);

    let mut sim = sim_of(scene);
    let mut calls = 0;
    while sim.step_count() < 700 {
        let before = sim.step_count();
        let mut scratch = scratch(&sim, 3);
        let bands = sim.bands(&mut scratch, 3, 0).unwrap();
        // None to all of the calls that a step takes, not always from the first band on.
        (0..calls % 4).for_each(|call| assert!(bands.pass((calls + call) % 3).is_ok()));
        drop(bands);
        assert_eq!(sim.step_count() - before, u64::from(calls % 4 > 0));
        calls += 1;
    }
    assert_eq!(sim.digest(), plain.digest());
}

#[test]
fn what_cannot_be_cut_is_refused() {
    let scene = small_sheet(21, 250.0);
    let mut sim = sim_of(&scene);
    let before = sim.digest();
    let refused = |result: Result<Bands<'_, '_>, Error>, code: Code, field: &str| {
        let error = result.err().expect("refused");
        assert_eq!((error.code, error.field), (code, field));
    };
    let mut scratch = scratch(&sim, MAX_BANDS);
    refused(sim.bands(&mut scratch, 0, 0), Code::OutOfRange, "of");
    refused(sim.bands(&mut scratch, MAX_BANDS + 1, 0), Code::OutOfRange, "of");
    let short = sim.layout().band_lines(2).unwrap() - 1;
    refused(sim.bands(&mut scratch[..short], 2, 0), Code::ShortBuffer, "scratch");
    assert_eq!(sim.digest(), before);

    let theta = golden::drawn_yarns_by_the_theta_rule();
    let mut sim = sim_of(&theta);
    refused(sim.bands(&mut scratch, 2, 0), Code::NotInBands, "integrator.kind");
}

#[test]
fn a_failure_comes_with_its_step_and_reaches_every_band() {
    // Too few places for candidates from some step on.
    let mut scene = small_sheet(21, 250.0);
    scene.contact_capacity = stepped(&scene, 5).counters().most_candidates as u32 + 5;
    let mut plain = sim_of(&scene);
    let failure = plain.advance(5000).unwrap_err();
    let steps = plain.step_count();
    assert!(steps > 0);

    let mut sim = sim_of(&scene);
    // Up to there nothing is said, although the next pass is already planned.
    in_turn(&mut sim, 3, steps).unwrap();
    assert_eq!(sim.failure(), None);
    let mut scratch = scratch(&sim, 3);
    let bands = sim.bands(&mut scratch, 3, 0).unwrap();
    assert_eq!((bands.pass(0), bands.pass(2)), (Ok(false), Ok(false)));
    assert_eq!(bands.failure(), None);
    assert_eq!(bands.pass(1), Err(failure.into()));
    assert_eq!((bands.passes(), bands.steps(), bands.failure()), (1, 0, Some(failure)));
    (0..3).for_each(|band| assert_eq!(bands.pass(band), Err(failure.into())));
    drop(bands);
    assert_eq!(sim.failure(), Some(failure));
    assert_eq!(sim.digest(), plain.digest());
    assert_eq!(sim.bands(&mut scratch, 3, 0).err().map(|error| error.code), Some(failure.code()));
}
