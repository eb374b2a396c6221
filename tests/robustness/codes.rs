//! Every code, failure, outcome and status comes out of a call, in Rust and in C. The matches have no arm for "others": a new
//! one does not compile before it is produced here.

use fabric::Hash;
use fabric::fields::{FIELDS, slot_of};
use fabric::{
    CacheLine, Code, Drive, Error, Failure, Integrator, Motion, Outcome, Path, Scene, Sim, Stack, Status, Symmetry,
};
use fabric_capi::calls::*;
use fabric_capi::types::*;
use fabric_capi::{Input, Lent, Output, ToChange, ToLookAt, fk_sim};
use fabric_tests::inputs::{self, Expected};
use fabric_tests::{Buffers, between_supports, small_sheet};
use std::collections::HashSet;
use std::ptr::null_mut;

/// The first scene of the table of inputs that is refused with this code.
fn refused_scene(code: Code) -> Scene {
    let refused = |case: &inputs::Case| {
        let mut scene = inputs::scene(case.base);
        let wanted = matches!(case.expected, Expected::Refused(with, _) if with == code);
        (wanted && inputs::assign(&mut scene, case.name, case.value)).then_some(scene)
    };
    inputs::cases().iter().find_map(refused).expect("a case")
}

/// Why a scene is refused, given memory enough for every one of the table that is refused.
fn constructed(scene: &Scene) -> Error {
    Sim::new(scene, &mut vec![CacheLine::ZERO; 8750]).err().expect("refused")
}

fn theta(max_iterations: u32) -> Scene {
    let mut scene = small_sheet(9, 50.0);
    scene.integrator = Integrator { max_iterations, ..Integrator::THETA };
    scene
}

fn prescribed() -> Scene {
    Scene { drive: Drive::Prescribed, ..small_sheet(9, 50.0) }
}

fn crowded() -> Scene {
    Scene { contact_capacity: 1, ..small_sheet(21, 100.0) }
}

fn no_path() -> Path {
    let end = Motion {
        position: [0.0; 3],
        velocity: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: [0.0; 3],
    };
    Path { first: 0, steps: 0, end }
}

/// Velocities of a sheet of 9 x 9, one of which no fabric survives.
fn wild() -> Vec<f64> {
    let mut velocities = vec![0.0; 3 * 81];
    velocities[3 * 40] = 1e34;
    velocities
}

/// Two plies of 9 x 9.
fn pair() -> Scene {
    Scene { stack: Stack { plies: 2, gap: 1e-4, turned: false }, ..small_sheet(9, 50.0) }
}

/// Positions far from the projectile, the second of the two plies below the first.
fn crossed() -> Vec<f64> {
    (0..2 * 81).flat_map(|k| [1.0, 1.0, if k < 81 { 0.0 } else { -1e-3 }]).collect()
}

/// The image of another scene.
fn foreign_image() -> Vec<u8> {
    let scene = Scene { seed: 77, ..small_sheet(9, 50.0) };
    let mut memory = Buffers::of(&scene);
    let sim = memory.sim(&scene);
    let mut image = vec![0; sim.snapshot_bytes()];
    sim.save(&mut image).expect("sound");
    image
}

/// An image of the scene whose step count is impossible, with the right checksum.
fn forged_image() -> Vec<u8> {
    let scene = small_sheet(9, 50.0);
    let mut memory = Buffers::of(&scene);
    let sim = memory.sim(&scene);
    let mut image = vec![0; sim.snapshot_bytes()];
    sim.save(&mut image).expect("sound");
    image[8 * 4..8 * 5].fill(0xff);
    let end = image.len() - 8;
    let mut hash = Hash::default();
    image[..end].as_chunks::<8>().0.iter().for_each(|word| hash.word(u64::from_le_bytes(*word)));
    image[end..].copy_from_slice(&hash.value().to_le_bytes());
    image
}

/// Where a code that no build with every feature gives is produced: the test and the file it is in.
const NOT_BUILT: (&str, &str) = (
    "fn a_build_without_a_feature_refuses_it_by_field_and_feature()",
    include_str!("../../kernel/src/scene/features.rs"),
);

/// The error of a call on a simulation of 9 x 9, or of another scene.
fn called(scene: &Scene, call: impl FnOnce(&mut Sim<'_>) -> Result<(), Error>) -> Option<Code> {
    let mut memory = Buffers::of(scene);
    let mut sim = memory.sim(scene);
    Some(call(&mut sim).expect_err("refused").code)
}

/// What a call in Rust gives; None for codes that only C has (bare pointers, numbers for choices) or no build like this.
fn in_rust(code: Code) -> Option<Code> {
    let sheet = small_sheet(9, 50.0);
    match code {
        Code::NullPointer | Code::Misaligned | Code::MovedBlock | Code::StructSize | Code::UnknownChoice => None,
        Code::NotBuilt => None,
        Code::NotFinite
        | Code::NotPositive
        | Code::OutOfRange
        | Code::BadQuaternion
        | Code::TooManyNodes
        | Code::StepTooLarge
        | Code::StepLimitUnusable
        | Code::DamageRateTooSmall
        | Code::ProjectileTooLight
        | Code::ProjectileTooSmall
        | Code::ProjectileTooFast
        | Code::InitialOverlap
        | Code::DiscsOverlap
        | Code::DiscTouchesProjectile
        | Code::BadNormal
        | Code::UnboundedFaces
        | Code::ImpossibleMoments
        | Code::NotSymmetric
        | Code::HoldsNothing
        | Code::NotInEquilibrium
        | Code::DoesNotGoWith => Some(constructed(&refused_scene(code)).code),
        Code::ShortBuffer => called(&sheet, |sim| sim.save(&mut [])),
        Code::WrongLength => called(&sheet, |sim| sim.copy_positions(&mut [])),
        Code::WrongDrive => called(&sheet, |sim| sim.follow(&no_path(), 1)),
        Code::BadPath => called(&prescribed(), |sim| sim.follow(&no_path(), 1)),
        Code::AlreadyStarted => called(&sheet, |sim| {
            sim.step()?;
            sim.set_motion(&wild(), &wild())
        }),
        Code::PliesOverlap => called(&pair(), |sim| sim.set_motion(&crossed(), &[0.0; 6 * 81])),
        Code::ImageMalformed => called(&sheet, |sim| sim.load(&[0; 64])),
        Code::ImageOfAnotherScene => called(&sheet, |sim| sim.load(&foreign_image())),
        Code::ImageInvalid => called(&sheet, |sim| sim.load(&forged_image())),
        Code::BandOutOfTurn => called(&sheet, |sim| {
            let mut scratch = vec![CacheLine::ZERO; sim.layout().band_lines(2)?];
            let bands = sim.bands(&mut scratch, 2, 0)?;
            bands.pass(0)?;
            bands.pass(0).map(|_| ())
        }),
        Code::NotInBands => called(&theta(500), |sim| sim.layout().band_lines(2).map(|_| ())),
        Code::NonFinite | Code::ContactCapacity | Code::TooFast | Code::NotConverged => {
            let failure = [Failure::NonFinite, Failure::ContactCapacity, Failure::TooFast, Failure::NotConverged];
            failure.into_iter().find(|failure| failure.code() == code).map(|failure| failed(failure).code())
        }
    }
}

/// Runs into a failure.
fn failed(failure: Failure) -> Failure {
    let run = |scene: &Scene, prepare: &dyn Fn(&mut Sim<'_>)| {
        let mut memory = Buffers::of(scene);
        let mut sim = memory.sim(scene);
        prepare(&mut sim);
        sim.advance(20_000).expect_err("fails")
    };
    match failure {
        Failure::NonFinite => run(&small_sheet(9, 50.0), &|sim| {
            let mut x = vec![0.0; 3 * 81];
            sim.copy_positions(&mut x).expect("sound");
            sim.set_motion(&x, &wild()).expect("accepted");
        }),
        Failure::ContactCapacity => run(&crowded(), &|_| ()),
        Failure::TooFast => run(&between_supports(small_sheet(9, 50.0), 1.0), &|sim| {
            sim.set_external_load([0.0, 0.0, 1e12], [0.0; 3]).expect("accepted");
        }),
        Failure::NotConverged => run(&theta(1), &|_| ()),
    }
}

// ---- C ---------------------------------------------------------------------------------------------------------------

/// A simulation in C: the block and its handle.
struct InC {
    _block: Vec<u8>,
    sim: *mut fk_sim,
}

impl InC {
    /// The handle for a call that changes the simulation.
    fn to_change(&self) -> ToChange {
        // SAFETY: from fk_init; its block is kept beside it, and one thread makes all calls.
        unsafe { ToChange::given(self.sim) }
    }

    /// The handle for a call that looks.
    fn to_look_at(&self) -> ToLookAt {
        // SAFETY: as above.
        unsafe { ToLookAt::given(self.sim) }
    }
}

fn in_c_of(scene: &Scene) -> InC {
    let structure = fk_scene::of(*scene);
    let (mut bytes, mut sim) = (0, null_mut());
    // SAFETY: structures and numbers of this function; the block is as long as asked for and kept with the handle.
    unsafe {
        assert_eq!(fk_memory_size(Input::given(&structure), Output::given(&mut bytes)), FK_OK);
        let mut block = vec![0; bytes as usize];
        let (lent, no_fault) = (Lent::given(block.as_mut_ptr().cast()), Output::given(null_mut()));
        assert_eq!(fk_init(lent, bytes, Input::given(&structure), Output::given(&mut sim), no_fault, 0), FK_OK);
        InC { _block: block, sim }
    }
}

/// What fk_init says about a scene.
fn init(structure: &fk_scene) -> i32 {
    let (mut block, mut sim) = (vec![0_u8; 640_000], null_mut());
    // SAFETY: a structure and a block of this function.
    unsafe {
        let (lent, no_fault) = (Lent::given(block.as_mut_ptr().cast()), Output::given(null_mut()));
        fk_init(lent, 640_000, Input::given(structure), Output::given(&mut sim), no_fault, 0)
    }
}

/// What a call in C gives.
fn in_c(code: Code) -> i32 {
    let sheet = small_sheet(9, 50.0);
    let plain = fk_scene::of(sheet);
    let row = |name| FIELDS.iter().position(|field| field.name == name).expect("a parameter");
    let with = |place: usize, word| {
        let mut structure = plain;
        structure.words[place] = word;
        structure
    };
    let load = |image: Vec<u8>| {
        let host = in_c_of(&sheet);
        // SAFETY: the handle's block is in `host`; the image is as long as said.
        unsafe { fk_state_load(host.to_change(), Input::given(image.as_ptr()), image.len() as u64) }
    };
    let follow = |scene: &Scene| {
        let host = in_c_of(scene);
        let path = no_path();
        // SAFETY: the handle's block is in `host`; a structure of this function.
        unsafe { fk_follow(host.to_change(), Input::given(&path), size_of::<fk_path>() as u64, 1) }
    };
    // SAFETY: of all calls below: handles whose blocks are kept beside them, structures and arrays of this function, and null.
    unsafe {
        match code {
            Code::NullPointer => fk_step(ToChange::given(null_mut())),
            Code::ShortBuffer => fk_init(
                Lent::given([0_u8; 64].as_mut_ptr().cast()),
                64,
                Input::given(&plain),
                Output::given(&mut null_mut()),
                Output::given(null_mut()),
                0,
            ),
            Code::Misaligned => {
                let mut numbers = [0.0; 10];
                let askew = numbers.as_mut_ptr().cast::<u8>().add(1);
                fk_copy_positions(in_c_of(&sheet).to_look_at(), Output::given(askew.cast()), 1)
            }
            Code::MovedBlock => fk_step(ToChange::given(vec![0_u64; 80_000].as_mut_ptr().cast())),
            Code::StructSize => init(&with(0, 8)),
            Code::UnknownChoice => init(&with(1 + slot_of(row("drive")), 9)),
            Code::NotBuilt => {
                assert!(NOT_BUILT.1.contains(NOT_BUILT.0));
                Code::NotBuilt.number()
            }
            Code::NotFinite
            | Code::NotPositive
            | Code::OutOfRange
            | Code::BadQuaternion
            | Code::TooManyNodes
            | Code::StepTooLarge
            | Code::StepLimitUnusable
            | Code::DamageRateTooSmall
            | Code::ProjectileTooLight
            | Code::ProjectileTooSmall
            | Code::ProjectileTooFast
            | Code::InitialOverlap
            | Code::DiscsOverlap
            | Code::DiscTouchesProjectile
            | Code::BadNormal
            | Code::UnboundedFaces
            | Code::ImpossibleMoments
            | Code::NotSymmetric
            | Code::HoldsNothing
            | Code::NotInEquilibrium
            | Code::DoesNotGoWith => init(&fk_scene::of(refused_scene(code))),
            Code::WrongLength => fk_copy_positions(in_c_of(&sheet).to_look_at(), Output::given([0.0].as_mut_ptr()), 1),
            Code::WrongDrive => follow(&sheet),
            Code::BadPath => follow(&prescribed()),
            Code::AlreadyStarted => {
                let host = in_c_of(&sheet);
                assert_eq!(fk_step(host.to_change()), FK_OK);
                fk_set_motion(host.to_change(), Input::given(wild().as_ptr()), Input::given(wild().as_ptr()), 3 * 81)
            }
            Code::PliesOverlap => {
                let (host, x, v) = (in_c_of(&pair()), crossed(), [0.0; 6 * 81]);
                fk_set_motion(host.to_change(), Input::given(x.as_ptr()), Input::given(v.as_ptr()), 6 * 81)
            }
            Code::ImageMalformed => load(vec![0; 64]),
            Code::ImageOfAnotherScene => load(foreign_image()),
            Code::ImageInvalid => load(forged_image()),
            Code::BandOutOfTurn => fk_bands_end(in_c_of(&sheet).to_change()),
            Code::NotInBands => fk_bands_size(in_c_of(&theta(500)).to_look_at(), 2, Output::given(&mut 0)),
            Code::NonFinite => {
                let (host, mut x) = (in_c_of(&sheet), vec![0.0; 3 * 81]);
                assert_eq!(fk_copy_positions(host.to_look_at(), Output::given(x.as_mut_ptr()), 3 * 81), FK_OK);
                assert_eq!(
                    fk_set_motion(host.to_change(), Input::given(x.as_ptr()), Input::given(wild().as_ptr()), 3 * 81),
                    FK_OK
                );
                fk_advance(host.to_change(), 10)
            }
            Code::ContactCapacity => fk_advance(in_c_of(&crowded()).to_change(), 20_000),
            Code::TooFast => {
                let (host, force) = (in_c_of(&between_supports(sheet, 1.0)), [0.0, 0.0, 1e12]);
                assert_eq!(
                    fk_set_external_load(
                        host.to_change(),
                        Input::given(force.as_ptr()),
                        Input::given([0.0; 3].as_ptr())
                    ),
                    FK_OK
                );
                fk_advance(host.to_change(), 20_000)
            }
            Code::NotConverged => fk_advance(in_c_of(&theta(1)).to_change(), 20_000),
        }
    }
}

#[test]
fn every_code_comes_out_of_a_call() {
    let mut rust = 0;
    for code in Code::ALL {
        if let Some(produced) = in_rust(code) {
            assert_eq!(produced, code);
            rust += 1;
        }
        assert_eq!(in_c(code), code.number(), "{code:?}");
    }
    let all = Code::ALL.len();
    assert_eq!(Code::ALL.iter().collect::<HashSet<_>>().len(), all);
    println!(
        "figure 9: {all} of {all} codes produced, {rust} in Rust, {} in C, 1 in a build without its feature",
        all - 1
    );
}

/// Runs into an outcome.
fn reached(outcome: Outcome) -> Scene {
    match outcome {
        Outcome::Arrested => small_sheet(41, 20.0),
        Outcome::Exited => small_sheet(41, 250.0),
        // A small sheet, whose middle tears off its edge.
        Outcome::Detached => {
            let mut scene = small_sheet(21, 250.0);
            scene.symmetry = Symmetry { mirror_x: true, mirror_y: true };
            scene
        }
        Outcome::Passed => {
            let mut scene = small_sheet(5, 100.0);
            scene.projectile.position[0] = 0.05;
            scene
        }
    }
}

/// The name of a status, to count those met.
fn named(status: Status) -> &'static str {
    match status {
        Status::Flight => "flight",
        Status::Contact => "contact",
        Status::Faulted => "faulted",
    }
}

#[test]
fn every_failure_outcome_and_status_is_reached() {
    let failures = [Failure::NonFinite, Failure::ContactCapacity, Failure::TooFast, Failure::NotConverged];
    failures.into_iter().for_each(|failure| assert_eq!(failed(failure), failure));

    let mut statuses = HashSet::new();
    for outcome in Outcome::ALL {
        let scene = reached(outcome);
        let mut memory = Buffers::of(&scene);
        let mut sim = memory.sim(&scene);
        while !sim.outcomes().mask.has(outcome) && sim.step_count() < 60_000 {
            statuses.insert(named(sim.outcomes().status));
            sim.advance(16).expect("sound");
        }
        assert!(sim.outcomes().mask.has(outcome), "{}", outcome.name());
        assert!(sim.outcomes().latched[outcome as usize].is_some());
        statuses.insert(named(sim.outcomes().status));
    }
    let mut memory = Buffers::of(&crowded());
    let mut sim = memory.sim(&crowded());
    sim.advance(20_000).expect_err("fails");
    statuses.insert(named(sim.outcomes().status));
    println!("figure 9: 4 of 4 failures, 4 of 4 outcomes, {} of 3 statuses reached", statuses.len());
    assert_eq!(statuses.len(), 3, "{statuses:?}");
}
