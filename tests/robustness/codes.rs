//! Every code comes out of a call, in Rust and in C.

use crate::failures;
use crate::snapshots::forged;
use fabric::fields::{FIELDS, slot_of};
use fabric::{CacheLine, Code, Drive, Error, Integrator, Path, Scene, Sim, Stack};
use fabric_capi::calls::*;
use fabric_capi::types::*;
use fabric_capi::{Input, Lent, Output, ToChange, ToLookAt, fk_sim};
use fabric_tests::inputs::{self, Expected};
use fabric_tests::{AT_REST, image_of, sim_of, small_sheet};
use std::collections::HashSet;
use std::ptr::null_mut;

/// The first scene of the table of inputs that is refused with this code, if there is one.
fn refused_scene(code: Code) -> Option<Scene> {
    let refused = |case: &inputs::Case| {
        let mut scene = inputs::scene(case.base);
        let wanted = matches!(case.expected, Expected::Refused(with, _) if with == code);
        (wanted && inputs::assign(&mut scene, case.name, case.value)).then_some(scene)
    };
    inputs::cases().iter().find_map(refused)
}

fn theta() -> Scene {
    Scene { integrator: Integrator::THETA, ..small_sheet(9, 50.0) }
}

fn prescribed() -> Scene {
    Scene { drive: Drive::Prescribed, ..small_sheet(9, 50.0) }
}

const NO_PATH: Path = Path { first: 0, steps: 0, end: AT_REST };

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
    image_of(&sim_of(&Scene { seed: 77, ..small_sheet(9, 50.0) }))
}

/// An image of the scene whose step count is impossible, with the right checksum.
fn forged_image() -> Vec<u8> {
    forged(&image_of(&sim_of(&small_sheet(9, 50.0))), 4, u64::MAX)
}

/// Where a code that no build with every feature gives is produced: the test and the file it is in.
const NOT_BUILT: (&str, &str) = (
    "fn a_build_without_a_feature_refuses_it_by_field_and_feature()",
    include_str!("../../kernel/src/scene/features.rs"),
);

/// The error of a call on a simulation.
fn called(scene: &Scene, call: impl FnOnce(&mut Sim<'_>) -> Result<(), Error>) -> Option<Code> {
    Some(call(&mut sim_of(scene)).expect_err("refused").code)
}

/// What a call in Rust gives; None for codes that only C has (bare pointers, numbers for choices) or no build like this.
fn in_rust(code: Code) -> Option<Code> {
    if let Some(scene) = refused_scene(code) {
        // Memory enough for every scene of the table that is refused.
        return Sim::new(&scene, &mut vec![CacheLine::ZERO; 8750]).err().map(|error| error.code);
    }
    if let Some(case) = failures::cases().into_iter().find(|case| case.failure.code() == code) {
        return case.run().0.failure().map(|failure| failure.code());
    }
    let (sheet, rest) = (small_sheet(9, 50.0), [0.0; 6 * 81]);
    match code {
        Code::NullPointer | Code::Misaligned | Code::MovedBlock | Code::StructSize | Code::UnknownChoice => None,
        Code::NotBuilt => None,
        Code::ShortBuffer => called(&sheet, |sim| sim.save(&mut [])),
        Code::WrongLength => called(&sheet, |sim| sim.copy_positions(&mut [])),
        Code::WrongDrive => called(&sheet, |sim| sim.follow(&NO_PATH, 1)),
        Code::BadPath => called(&prescribed(), |sim| sim.follow(&NO_PATH, 1)),
        Code::AlreadyStarted => called(&sheet, |sim| {
            sim.step()?;
            sim.set_motion(&rest[..3 * 81], &rest[..3 * 81])
        }),
        Code::PliesOverlap => called(&pair(), |sim| sim.set_motion(&crossed(), &rest)),
        Code::ImageMalformed => called(&sheet, |sim| sim.load(&[0; 64])),
        Code::ImageOfAnotherScene => called(&sheet, |sim| sim.load(&foreign_image())),
        Code::ImageInvalid => called(&sheet, |sim| sim.load(&forged_image())),
        Code::BandOutOfTurn => called(&sheet, |sim| {
            let mut scratch = vec![CacheLine::ZERO; sim.layout().band_lines(2)?];
            let bands = sim.bands(&mut scratch, 2, 0)?;
            bands.pass(0)?;
            bands.pass(0).map(|_| ())
        }),
        Code::NotInBands => called(&theta(), |sim| sim.layout().band_lines(2).map(|_| ())),
        other => panic!("{other:?} is produced nowhere"),
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

/// Steps in C under a force along z, N, that comes after some steps.
fn loaded(scene: &Scene, before: u64, force: f64) -> i32 {
    let (host, force) = (in_c_of(scene), [0.0, 0.0, force]);
    // SAFETY: a handle whose block is kept beside it, and arrays of this function.
    unsafe {
        assert_eq!(fk_advance(host.to_change(), before), FK_OK);
        let [force, torque] = [Input::given(force.as_ptr()), Input::given([0.0; 3].as_ptr())];
        assert_eq!(fk_set_external_load(host.to_change(), force, torque), FK_OK);
        fk_advance(host.to_change(), 20_000)
    }
}

/// What a call in C gives.
fn in_c(code: Code) -> i32 {
    if let Some(scene) = refused_scene(code) {
        return init(&fk_scene::of(scene));
    }
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
        // SAFETY: the handle's block is in `host`; a structure of this file.
        unsafe { fk_follow(host.to_change(), Input::given(&NO_PATH), size_of::<fk_path>() as u64, 1) }
    };
    let failing = |code: Code| failures::cases().into_iter().find(|case| case.failure.code() == code).unwrap().scene;
    // SAFETY: of all calls below: handles whose blocks are kept beside them, structures and arrays of this function, and null.
    unsafe {
        match code {
            Code::NullPointer => fk_step(ToChange::given(null_mut())),
            Code::ShortBuffer => {
                let (lent, sim) = (Lent::given([0_u8; 64].as_mut_ptr().cast()), &mut null_mut());
                fk_init(lent, 64, Input::given(&plain), Output::given(sim), Output::given(null_mut()), 0)
            }
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
            Code::WrongLength => fk_copy_positions(in_c_of(&sheet).to_look_at(), Output::given([0.0].as_mut_ptr()), 1),
            Code::WrongDrive => follow(&sheet),
            Code::BadPath => follow(&prescribed()),
            Code::AlreadyStarted => {
                let (host, x) = (in_c_of(&sheet), [0.0; 3 * 81]);
                assert_eq!(fk_step(host.to_change()), FK_OK);
                fk_set_motion(host.to_change(), Input::given(x.as_ptr()), Input::given(x.as_ptr()), 3 * 81)
            }
            Code::PliesOverlap => {
                let (host, x, v) = (in_c_of(&pair()), crossed(), [0.0; 6 * 81]);
                fk_set_motion(host.to_change(), Input::given(x.as_ptr()), Input::given(v.as_ptr()), 6 * 81)
            }
            Code::ImageMalformed => load(vec![0; 64]),
            Code::ImageOfAnotherScene => load(foreign_image()),
            Code::ImageInvalid => load(forged_image()),
            Code::BandOutOfTurn => fk_bands_end(in_c_of(&sheet).to_change()),
            Code::NotInBands => fk_bands_size(in_c_of(&theta()).to_look_at(), 2, Output::given(&mut 0)),
            Code::TooFast => loaded(&failing(code), 0, 1e12),
            Code::NonFinite => loaded(&sheet, 10, 1e150),
            Code::ContactCapacity | Code::NotConverged => loaded(&failing(code), 0, 0.0),
            other => panic!("{other:?} is produced nowhere"),
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
