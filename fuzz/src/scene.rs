//! Scenes made of any bytes: refused by a documented status with nothing written, or run without a panic, alike in C and Rust.

use crate::bytes::Bytes;
use crate::memory::Block;
use crate::small::{self, MOST_ITERATIONS, MOST_NODES};
use fabric::{InstructionSet, Layout, Memory, Sim};
use fabric_capi::calls::*;
use fabric_capi::types::*;
use fabric_capi::{Input, Lent, Output, ToChange, ToLookAt, fk_sim};
use std::ptr::null_mut;

/// What fk_memory_size, and but for the time step's three every other call, may refuse a scene with.
const OF_A_FIELD: [i32; 18] = [
    FK_STRUCT_SIZE,
    FK_NOT_FINITE,
    FK_NOT_POSITIVE,
    FK_OUT_OF_RANGE,
    FK_UNKNOWN_CHOICE,
    FK_BAD_QUATERNION,
    FK_TOO_MANY_NODES,
    FK_DAMAGE_RATE_TOO_SMALL,
    FK_PROJECTILE_TOO_LIGHT,
    FK_PROJECTILE_TOO_SMALL,
    FK_DISCS_OVERLAP,
    FK_DISC_TOUCHES_PROJECTILE,
    FK_BAD_NORMAL,
    FK_UNBOUNDED_FACES,
    FK_IMPOSSIBLE_MOMENTS,
    FK_NOT_SYMMETRIC,
    FK_NOT_BUILT,
    FK_HOLDS_NOTHING,
];
/// What fk_scene_check adds.
const OF_THE_STEP: [i32; 3] = [FK_STEP_TOO_LARGE, FK_STEP_LIMIT_UNUSABLE, FK_DAMAGE_RATE_TOO_SMALL];
/// What fk_init adds.
const OF_THE_START: [i32; 4] = [FK_INITIAL_OVERLAP, FK_PROJECTILE_TOO_FAST, FK_OUT_OF_RANGE, FK_NOT_SYMMETRIC];
/// What a step may fail with.
pub const FAILURES: [i32; 4] = [FK_NON_FINITE, FK_CONTACT_CAPACITY, FK_TOO_FAST, FK_NOT_CONVERGED];

/// A scene as C gives it: a small sound one with a few words overwritten, or any bytes at all.
fn given(bytes: &mut Bytes) -> fk_scene {
    let mut scene = fk_scene::of(&small::scene(bytes));
    let edits = match bytes.below(16) {
        0..8 => 0,
        8..12 => 1,
        12..14 => 2,
        14 => 5,
        _ => size_of::<fk_scene>() / 8,
    };
    let words = size_of::<fk_scene>() / 8;
    for _ in 0..edits {
        if bytes.is_empty() {
            break;
        }
        let place = bytes.below(words);
        // SAFETY: a structure of whole words, integers and floating-point numbers only, so that any bits are values.
        unsafe {
            let word = (&raw mut scene).cast::<u64>().add(place);
            match bytes.below(4) {
                0 => word.cast::<u32>().add(bytes.below(2)).write(bytes.below(8) as u32),
                1 => word.cast::<u32>().add(bytes.below(2)).write(bytes.odd_count(3) as u32),
                _ => word.write(bytes.odd(f64::from_bits(word.read())).to_bits()),
            }
        }
    }
    // Longer iterations than this are sound, and take as long as asked for.
    scene.theta_max_iterations = scene.theta_max_iterations.min(MOST_ITERATIONS);
    scene
}

/// A fault's number, once its texts have been found to end.
fn told(fault: &fk_fault) -> i32 {
    assert!(fault.field.contains(&0) && fault.text.contains(&0) && fault.text[0] != 0);
    fault.status
}

/// The target.
pub fn run(data: &[u8]) -> bool {
    let mut bytes = Bytes::new(data);
    let scene = given(&mut bytes);
    let steps = 1 + bytes.below(16) as u64 + if bytes.once_in(16) { 64 } else { 0 };
    let instructions = bytes.choose(&InstructionSet::ALL);
    let mut fault = fk_fault::of(&fabric::Error::plain(fabric::Code::NullPointer, ""));
    let (mut size, mut align) = (0, 0);

    // SAFETY: structures and numbers of this function; blocks as long as they are said to be.
    unsafe {
        let sized = fk_memory_size(Input::given(&scene), Output::given(&mut size), Output::given(&mut align));
        assert!(sized == FK_OK || OF_A_FIELD.contains(&sized), "fk_memory_size: {sized}");
        let mut handle = null_mut();
        let nodes = u64::from(scene.sheet_nodes_x) * u64::from(scene.sheet_nodes_y);
        if nodes > MOST_NODES {
            // Checking would draw every segment; a block that is too short is refused before.
            let block = Block::new(64);
            let refused = fk_init(
                Lent::given(block.start().cast()),
                64,
                Input::given(&scene),
                Output::given(&mut handle),
                Output::given(&mut fault),
            );
            assert_eq!(refused, if sized == FK_OK { FK_SHORT_BUFFER } else { sized });
            assert!(told(&fault) == refused && handle.is_null() && block.untouched());
            return false;
        }

        let checked = fk_scene_check(Input::given(&scene), Output::given(&mut fault));
        if sized != FK_OK {
            assert_eq!(checked, sized);
            assert!(told(&fault) == checked || checked == FK_STRUCT_SIZE);
        } else {
            assert!(checked == FK_OK || OF_THE_STEP.contains(&checked), "fk_scene_check: {checked}");
            assert_eq!(align, 64);
        }
        let block = Block::new(if sized == FK_OK { size as usize } else { 64 });
        let made = fk_init(
            Lent::given(block.start().cast()),
            block.bytes() as u64,
            Input::given(&scene),
            Output::given(&mut handle),
            Output::given(&mut fault),
        );
        if made != FK_OK {
            assert!(block.untouched() && handle.is_null() && told(&fault) == made);
            assert!(if checked == FK_OK { OF_THE_START.contains(&made) } else { made == checked }, "fk_init: {made}");
            return false;
        }
        assert_eq!(checked, FK_OK);

        // The same scene in Rust, with an instruction set of the fuzzer's choice: the same bits, or the same failure.
        let rust = scene.scene().expect("accepted through C");
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
            look(handle);
            let mut image = vec![0; twin.snapshot_bytes()];
            assert_eq!(
                fk_state_save(ToLookAt::given(handle), Output::given(image.as_mut_ptr()), image.len() as u64),
                FK_OK
            );
            let before = twin.digest();
            twin.reset();
            assert_eq!(twin.load(&image), Ok(()), "the image of a sound simulation");
            assert_eq!(twin.digest(), before);
        } else {
            assert!(FAILURES.contains(&stepped), "fk_advance: {stepped}");
            assert_eq!((fk_step(ToChange::given(handle)), digest(handle)), (stepped, Err(stepped)));
            let mut counters: fk_counters = empty();
            assert_eq!(fk_get_counters(ToLookAt::given(handle), Output::given(&mut counters)), FK_OK);
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
    match unsafe { fk_digest(ToLookAt::given(handle), Output::given(&mut digest)) } {
        FK_OK => Ok(digest),
        status => Err(status),
    }
}

/// A structure of the C interface as a host hands it over to be filled.
pub fn empty<T: Copy>() -> T {
    let mut value = std::mem::MaybeUninit::<T>::zeroed();
    // SAFETY: every structure of the C interface starts with its 64-bit size, and holds integers and floating-point numbers
    // only, for which zero is a value.
    unsafe {
        value.as_mut_ptr().cast::<u64>().write(size_of::<T>() as u64);
        value.assume_init()
    }
}

/// Every read-out of a sound simulation, into arrays of exactly the lengths asked for.
///
/// # Safety
/// A handle from fk_init whose simulation has not failed.
unsafe fn look(handle: *const fk_sim) {
    let mut grid: fk_grid = empty();
    let (mut steps, mut seconds, mut bytes) = (0, 0.0, 0);
    // SAFETY: the caller's promise; structures and arrays of this function.
    unsafe {
        let sim = || ToLookAt::given(handle);
        assert_eq!(fk_get_grid(sim(), Output::given(&mut grid)), FK_OK);
        let mut nodes = vec![0.0; 3 * (grid.nodes_x * grid.nodes_y) as usize];
        let mut segments = vec![0.0; (grid.horizontal + grid.vertical) as usize];
        let mut residual = [0.0; 3];
        let statuses = [
            fk_get_time(sim(), Output::given(&mut steps), Output::given(&mut seconds)),
            fk_get_step_limits(sim(), Output::given(&mut empty())),
            fk_get_projectile(sim(), Output::given(&mut empty())),
            fk_get_contact(sim(), Output::given(&mut empty())),
            fk_get_support(sim(), Output::given(&mut empty())),
            fk_get_energy(sim(), Output::given(&mut empty())),
            fk_get_momentum_residual(sim(), Output::given(residual.as_mut_ptr())),
            fk_get_fabric(ToChange::given(handle.cast_mut()), Output::given(&mut empty())),
            fk_get_counters(sim(), Output::given(&mut empty())),
            fk_get_fault(sim(), Output::given(&mut empty())),
            fk_get_outcome(sim(), Output::given(&mut empty())),
            fk_copy_positions(sim(), Output::given(nodes.as_mut_ptr()), nodes.len() as u64),
            fk_copy_velocities(sim(), Output::given(nodes.as_mut_ptr()), nodes.len() as u64),
            fk_copy_stretch(sim(), Output::given(segments.as_mut_ptr()), segments.len() as u64),
            fk_copy_damage(sim(), Output::given(segments.as_mut_ptr()), segments.len() as u64),
            fk_state_size(sim(), Output::given(&mut bytes)),
        ];
        assert_eq!(statuses, [FK_OK; 16]);
        assert!(segments.iter().all(|alpha| (0.0..=1.0).contains(alpha)), "damage outside 0 to 1");
    }
}
