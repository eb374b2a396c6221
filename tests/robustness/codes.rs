//! Every code comes out of a call, in Rust or, where only C has it, in C.

use crate::failures;
use crate::snapshots::forged;
use fabric_capi::calls::{fk_memory_size, fk_step};
use fabric_capi::capsule::fk_capsule_read;
use fabric_capi::types::{fk_capsule, fk_scene};
use fabric_capi::{Input, Output, ToChange};
use fabric_kernel::fields::{FIELDS, slot_of};
use fabric_kernel::{CacheLine, Code, Drive, Error, Integrator, Path, Scene, Sim, Stack};
use fabric_tests::inputs::{self, Expected};
use fabric_tests::{AT_REST, image_of, sim_of, small_sheet};
use std::collections::HashSet;
use std::ptr::null;

/// The first scene of the table of inputs that is refused with this code, if there is one.
fn refused_scene(code: Code) -> Option<Scene> {
    let refused = |case: &inputs::Case| {
        let mut scene = inputs::scene(case.base);
        let wanted = matches!(case.expected, Expected::Refused(with, _) if with == code);
        (wanted && inputs::assign(&mut scene, case.name, case.value)).then_some(scene)
    };
    inputs::cases().iter().find_map(refused)
}

const NO_PATH: Path = Path { first: 0, steps: 0, end: AT_REST };

/// Where a code that no build with every feature gives is produced: the test and the file it is in.
const NOT_BUILT: (&str, &str) = (
    "fn a_build_without_a_feature_refuses_it_by_field_and_feature()",
    include_str!("../../kernel/src/scene/features.rs"),
);

/// The error of a call on a simulation.
fn called(scene: &Scene, call: impl FnOnce(&mut Sim<'_>) -> Result<(), Error>) -> Option<Code> {
    Some(call(&mut sim_of(scene)).expect_err("refused").code)
}

/// What a call in Rust gives; None for codes that only C has (bare pointers, numbers for choices) or no build
/// like this.
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
        Code::NullPointer
        | Code::Misaligned
        | Code::MovedBlock
        | Code::StructSize
        | Code::UnknownChoice
        | Code::BadCapsule => None,
        Code::NotBuilt => None,
        Code::ShortBuffer => called(&sheet, |sim| sim.save(&mut [])),
        Code::WrongLength => called(&sheet, |sim| sim.copy_positions(&mut [])),
        Code::WrongDrive => called(&sheet, |sim| sim.follow(&NO_PATH, 1)),
        Code::BadPath => called(&Scene { drive: Drive::Prescribed, ..sheet }, |sim| sim.follow(&NO_PATH, 1)),
        Code::AlreadyStarted => called(&sheet, |sim| {
            sim.step()?;
            sim.set_motion(&rest[..3 * 81], &rest[..3 * 81])
        }),
        Code::PliesOverlap => {
            // Far from the projectile, the second of two plies below the first.
            let pair = Scene { stack: Stack { plies: 2, gap: 1e-4, turned: false }, ..sheet };
            let crossed: Vec<_> = (0..2 * 81).flat_map(|k| [1.0, 1.0, if k < 81 { 0.0 } else { -1e-3 }]).collect();
            called(&pair, |sim| sim.set_motion(&crossed, &rest))
        }
        Code::ImageMalformed => called(&sheet, |sim| sim.load(&[0; 64])),
        Code::ImageOfAnotherScene => called(&sheet, |sim| sim.load(&image_of(&sim_of(&Scene { seed: 77, ..sheet })))),

        // An impossible step count, with the right checksum.
        Code::ImageInvalid => called(&sheet, |sim| sim.load(&forged(&image_of(sim), 4, u64::MAX))),
        Code::BandOutOfTurn => called(&sheet, |sim| {
            let mut scratch = vec![CacheLine::ZERO; sim.layout().band_lines(2)?];
            let bands = sim.bands(&mut scratch, 2, 0)?;
            bands.pass(0)?;
            bands.pass(0).map(|_| ())
        }),
        Code::NotInBands => {
            called(&Scene { integrator: Integrator::THETA, ..sheet }, |sim| sim.layout().band_lines(2).map(|_| ()))
        }
        other => panic!("{other:?} is produced nowhere"),
    }
}

/// What a call in C gives for the codes that only C has: bare pointers, sizes of structures, numbers for
/// choices. (That a call in C gives the code that it gives in Rust, whatever it is, `tests/fuzz/src/calls.rs`
/// asserts.)
fn in_c(code: Code) -> Option<i32> {
    let plain = fk_scene::of(small_sheet(9, 50.0));
    let sized = |scene: *const fk_scene| {
        // SAFETY: a structure of this function, or a place in it that is refused before it is read; a number
        // of this function.
        unsafe { fk_memory_size(Input::given(scene), Output::given(&mut 0)) }
    };
    let with = |place: usize, word| {
        let mut structure = plain;
        structure.words[place] = word;
        sized(&structure)
    };
    let drive = FIELDS.iter().position(|field| field.name == "drive").expect("a parameter");
    Some(match code {
        Code::NullPointer => sized(null()),
        // SAFETY: inside the structure.
        Code::Misaligned => sized(unsafe { (&raw const plain).byte_add(4) }),
        // SAFETY: memory of this function, as long as a handle.
        Code::MovedBlock => unsafe { fk_step(ToChange::given(vec![0_u64; 80_000].as_mut_ptr().cast())) },
        Code::StructSize => with(0, 8),
        Code::UnknownChoice => with(1 + slot_of(drive), 9),
        Code::BadCapsule => {
            let (mut scene, mut about, size) = (plain, fk_capsule::default(), size_of::<fk_scene>() as u64);
            // SAFETY: bytes and structures of this function, with their sizes.
            unsafe {
                let (scene, about) = (Output::given(&mut scene), Output::given(&mut about));
                fk_capsule_read(Input::given([0_u8; 8].as_ptr()), 8, scene, size, about, size_of::<fk_capsule>() as u64)
            }
        }
        _ => return None,
    })
}

#[test]
fn every_code_comes_out_of_a_call() {
    let [mut rust, mut c] = [0; 2];
    for code in Code::ALL {
        if let Some(produced) = in_rust(code) {
            assert_eq!(produced, code);
            rust += 1;
        } else if let Some(produced) = in_c(code) {
            assert_eq!(produced, code.number(), "{code:?}");
            c += 1;
        } else {
            // No build with every feature gives it.
            assert_eq!(code, Code::NotBuilt);
            assert!(NOT_BUILT.1.contains(NOT_BUILT.0));
        }
    }
    let all = Code::ALL.len();
    assert_eq!(Code::ALL.iter().collect::<HashSet<_>>().len(), all);
    println!("figure 9: {all} of {all} codes produced, {rust} in Rust, {c} in C, 1 in a build without its feature");
}
