//! Scenes made of any bytes: refused by a documented status with nothing written, or run without a panic,
//! alike in C and Rust.

use crate::bytes::Bytes;
use crate::image::look;
use crate::memory::{Block, at, into, nowhere, to};
use crate::small::{self, MOST_ITERATIONS, MOST_NODES};
use fabric_capi::calls::*;
use fabric_capi::types::*;
use fabric_capi::{Lent, Output, ToChange, ToLookAt, fk_sim};
use fabric_kernel::fields::{FIELDS, slot_of};
use fabric_kernel::{CacheLine, Code, InstructionSet, Layout, Sim};
use std::ptr::null_mut;

/// What fk_memory_size, and but for the time step's three every other call, may refuse a scene with.
#[rustfmt::skip]
const OF_A_FIELD: [Code; 20] = [
    Code::StructSize, Code::NotFinite, Code::NotPositive, Code::OutOfRange, Code::UnknownChoice, Code::BadQuaternion,
    Code::TooManyNodes, Code::DamageRateTooSmall, Code::ProjectileTooLight, Code::ProjectileTooSmall, Code::DiscsOverlap,
    Code::DiscTouchesProjectile, Code::BadNormal, Code::UnboundedFaces, Code::ImpossibleMoments, Code::NotSymmetric,
    Code::NotBuilt, Code::HoldsNothing, Code::NotInEquilibrium, Code::DoesNotGoWith,
];
/// What fk_scene_check adds, of the step and of the start; out of range is a quadratic viscosity that no step
/// allows for the strengths drawn, or a mass.
#[rustfmt::skip]
const OF_THE_START: [Code; 7] = [
    Code::StepTooLarge, Code::StepLimitUnusable, Code::DamageRateTooSmall, Code::OutOfRange, Code::InitialOverlap,
    Code::ProjectileTooFast, Code::NotSymmetric,
];
/// What a step may fail with.
const FAILURES: [Code; 4] = [Code::NonFinite, Code::ContactCapacity, Code::TooFast, Code::NotConverged];

/// Whether a status is FK_OK or one of these.
fn is_of(status: i32, codes: &[Code]) -> bool {
    status == FK_OK || codes.iter().any(|code| code.number() == status)
}

/// Whether a step may fail with it.
pub fn is_failure(status: i32) -> bool {
    status != FK_OK && is_of(status, &FAILURES)
}

/// Where a parameter stands in the structure.
fn place(name: &str) -> usize {
    1 + slot_of(FIELDS.iter().position(|field| field.name == name).expect("a parameter"))
}

/// A scene as C gives it: a small sound one with a few words overwritten, or any bytes at all.
fn given(bytes: &mut Bytes) -> fk_scene {
    let mut scene = fk_scene::of(small::scene(bytes));
    let edits = match bytes.below(16) {
        0..8 => 0,
        8..12 => 1,
        12..14 => 2,
        14 => 5,
        _ => scene.words.len(),
    };
    let words = scene.words.len();
    for _ in 0..edits {
        if bytes.is_empty() {
            break;
        }
        let place = bytes.below(words);
        let word = &mut scene.words[place];
        let mut half = |new: u64, second: usize| {
            let shift = 32 * second;
            *word = *word & !(0xffff_ffff << shift) | (new & 0xffff_ffff) << shift;
        };
        match bytes.below(4) {
            0 => {
                let second = bytes.below(2);
                half(bytes.below(8) as u64, second);
            }
            1 => {
                let second = bytes.below(2);
                half(bytes.odd_count(3), second);
            }
            _ => *word = bytes.odd(f64::from_bits(*word)).to_bits(),
        }
    }
    // Longer iterations than this are sound, and take as long as asked for.
    let most = place("integrator.max_iterations");
    scene.words[most] = scene.words[most].min(u64::from(MOST_ITERATIONS));
    scene
}

/// Bytes of a fault.
const FAULT: u64 = size_of::<fk_fault>() as u64;

/// A fault's number, once its texts have been found to end.
fn fault_status(fault: &fk_fault) -> i32 {
    assert!(fault.field.contains(&0) && fault.text.contains(&0) && fault.text[0] != 0);
    fault.status
}

/// A textile of a data sheet with a few numbers that may be anything: refused with the scene as it was, or
/// set as in Rust.
fn set_textile(bytes: &mut Bytes, scene: &fk_scene) {
    let warp = fk_threads { linear_density: 6.7e-5, count: 1340.0, crimp: 0.01 };
    let mut textile = fk_textile {
        warp,
        weft: fk_threads { crimp: 0.0, ..warp },
        fibre_density: 1440.0,
        modulus: 85e9,
        modulus_sd: 0.0,
        failure_strain: 0.0355,
        strength: 0.0,
        weaving_loss: 0.0,
        damage_rate: 2300.0,
        weibull_shape: 14.7,
        gauge_length: 0.05,
        thickness: 0.0,
    };
    let t = &mut textile;
    let (warp, weft) = (&mut t.warp, &mut t.weft);
    #[rustfmt::skip]
    let numbers = [
        &mut warp.linear_density, &mut warp.count, &mut warp.crimp, &mut weft.linear_density, &mut weft.count, &mut weft.crimp,
        &mut t.fibre_density, &mut t.modulus, &mut t.modulus_sd, &mut t.failure_strain, &mut t.strength, &mut t.weaving_loss,
        &mut t.damage_rate, &mut t.weibull_shape, &mut t.gauge_length, &mut t.thickness,
    ];
    for _ in 0..bytes.below(4) {
        let number = &mut *numbers[bytes.below(16)];
        *number = bytes.odd(*number);
    }
    let (size, known) = (bytes_of::<fk_textile>(), scene.words[0] == bytes_of::<fk_scene>());
    for back in [false, true] {
        let mut in_c = *scene;
        let set = if back { fk_scene_set_back_textile } else { fk_scene_set_textile };
        // SAFETY: structures of this function.
        let set = unsafe { set(into(&mut in_c), at(&textile), size, nowhere(), 0) };
        let Some(mut rust) = fk_scene::scene(&scene.words).ok().filter(|_| known) else {
            assert!(set != FK_OK && in_c.words == scene.words);
            continue;
        };
        let model = if back { rust.set_back_textile(&textile) } else { rust.set_textile(&textile) };
        assert_eq!(set, model.map_or_else(|error| error.code.number(), |()| FK_OK));
        assert_eq!(in_c.words, if set == FK_OK { fk_scene::of(rust).words } else { scene.words });
    }
}

/// The target.
pub fn run(data: &[u8]) -> bool {
    let mut bytes = Bytes::new(data);
    let scene = given(&mut bytes);
    let steps = 1 + bytes.below(16) as u64 + if bytes.once_in(16) { 64 } else { 0 };
    let instructions = bytes.choose(&InstructionSet::ALL);
    let mut fault = fk_fault::of(&fabric_kernel::Error::plain(fabric_kernel::Code::NullPointer, ""));
    let mut size = 0;
    set_textile(&mut bytes, &scene);

    // SAFETY: structures and numbers of this function; blocks as long as they are said to be.
    unsafe {
        let sized = fk_memory_size(at(&scene), into(&mut size));
        assert!(is_of(sized, &OF_A_FIELD), "fk_memory_size: {sized}");
        let checked = fk_scene_check(at(&scene), into(&mut fault), FAULT);
        if sized != FK_OK {
            assert_eq!(checked, sized);
            assert!(fault_status(&fault) == checked || checked == Code::StructSize.number());
        } else {
            assert!(is_of(checked, &OF_THE_START), "fk_scene_check: {checked}");
        }
        let mut handle = null_mut();
        let nodes = scene.words[place("sheet.nodes_x")].saturating_mul(scene.words[place("sheet.nodes_y")]);
        if nodes > MOST_NODES {
            // Making it would draw every segment; a block that is too short is refused before.
            let block = Block::new(64);
            let refused =
                fk_init(Lent::given(block.start().cast()), 64, at(&scene), into(&mut handle), into(&mut fault), FAULT);
            assert_eq!(refused, if sized == FK_OK { Code::ShortBuffer.number() } else { sized });
            assert!(fault_status(&fault) == refused && handle.is_null() && block.untouched());
            return false;
        }

        let block = Block::new(if sized == FK_OK { size as usize } else { 64 });
        let made = fk_init(
            Lent::given(block.start().cast()),
            block.bytes() as u64,
            at(&scene),
            into(&mut handle),
            into(&mut fault),
            FAULT,
        );
        if made != FK_OK {
            assert!(block.untouched() && handle.is_null() && fault_status(&fault) == made);
        }
        // The check has looked at all segments if they are few.
        let few = nodes.saturating_mul(scene.words[place("stack.plies")]) <= 20 * MOST_NODES;
        assert!(checked == made || !few && checked == FK_OK, "fk_scene_check: {checked}, fk_init: {made}");
        if made != FK_OK {
            return false;
        }
        assert_eq!(checked, FK_OK);

        // This scene in Rust, with an instruction set of the fuzzer's choice: the same bits, or the same
        // failure.
        let rust = fk_scene::scene(&scene.words).expect("accepted through C");
        let layout = Layout::of(&rust).expect("accepted through C");
        let mut memory = vec![CacheLine::ZERO; layout.lines()];
        let mut twin = Sim::new(&rust, &mut memory).expect("accepted through C");
        if instructions.available() {
            twin.use_instructions(instructions).expect("available");
        }
        let start = digest(handle);
        assert_eq!(start, Ok(twin.digest()));
        let first = steps / 3;
        let mut stepped = fk_advance(ToChange::given(handle), first);
        if stepped == FK_OK {
            stepped = fk_advance(ToChange::given(handle), steps - first);
        }
        let twin_stepped = twin.advance(steps).map_or_else(|failure| failure.code().number(), |()| FK_OK);
        assert_eq!(stepped, twin_stepped);
        if stepped == FK_OK {
            assert_eq!(digest(handle), Ok(twin.digest()));
            // (`calls` reads all of it through C.)
            let [places, speeds, alpha] = look(&mut twin);
            assert!(places.iter().chain(&speeds).all(|x| x.is_finite()));
            assert!(alpha.iter().all(|alpha| (0.0..=1.0).contains(alpha)), "damage outside 0 to 1");
            let mut image = vec![0; twin.snapshot_bytes()];
            assert_eq!(fk_state_save(ToLookAt::given(handle), to(&mut image), image.len() as u64), FK_OK);
            let before = twin.digest();
            twin.reset();
            assert_eq!(twin.load(&image), Ok(()), "the image of a sound simulation");
            assert_eq!(twin.digest(), before);
        } else {
            assert!(is_failure(stepped), "fk_advance: {stepped}");
            assert_eq!((fk_step(ToChange::given(handle)), digest(handle)), (stepped, Err(stepped)));
            let mut counters: fk_counters = empty();
            assert_eq!(fk_get_counters(ToLookAt::given(handle), into(&mut counters), bytes_of::<fk_counters>()), FK_OK);
            assert!(counters.steps < steps);
        }
        assert_eq!(fk_reset(ToChange::given(handle)), FK_OK);
        assert_eq!(digest(handle), start);
    }
    true
}

/// The hash of a simulation's state, or why there is none.
///
/// # Safety
/// A handle from fk_init.
pub unsafe fn digest(handle: *const fk_sim) -> Result<u64, i32> {
    let mut digest = 0;
    // SAFETY: the caller's promise.
    match unsafe { fk_digest(ToLookAt::given(handle), into(&mut digest)) } {
        FK_OK => Ok(digest),
        status => Err(status),
    }
}

/// Bytes of a structure, as a host says them.
pub fn bytes_of<T>() -> u64 {
    size_of::<T>() as u64
}

/// A structure of the C interface as a host hands it over to be filled.
pub fn empty<T: Copy>() -> T {
    let value = std::mem::MaybeUninit::<T>::zeroed();
    // SAFETY: every structure of the C interface holds integers and floating-point numbers only, for which
    // zero is a value.
    unsafe { value.assume_init() }
}

/// A read-out's function: handle, structure, its size.
pub type Get<H, T> = unsafe extern "C" fn(H, Output<T>, u64) -> i32;

/// What a read-out finds, or its status.
///
/// # Safety
/// A handle from fk_init.
pub(crate) unsafe fn got<H, T: Copy>(handle: H, call: Get<H, T>) -> Result<T, i32> {
    let mut value = empty();
    // SAFETY: the caller's promise, and a structure of this function.
    match unsafe { call(handle, into(&mut value), bytes_of::<T>()) } {
        FK_OK => Ok(value),
        status => Err(status),
    }
}
