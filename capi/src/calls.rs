//! Every `fk_*` function. Each returns a status unless it says otherwise; a refused call has changed nothing.
//!
//! Stepping calls save, set (round to nearest, subnormals kept) and restore the floating-point environment, so that a host
//! built with fast-math gets the same bits.
#![allow(clippy::missing_safety_doc)] // Each function's text says what its pointers must be; C has no other contract.

use crate::block::{self, fk_sim};
use crate::float::in_our_environment;
use crate::types::*;
use core::ffi::{CStr, c_char};
use fabric::{Code, Error, Layout, Outcome, Path, Scene};

/// A structure that starts with its own size.
trait Structure: Copy {
    /// Name for faults.
    const NAME: &'static str;
}

impl Structure for fk_scene {
    const NAME: &'static str = "fk_scene";
}
impl Structure for fk_fault {
    const NAME: &'static str = "fk_fault";
}
impl Structure for fk_motion {
    const NAME: &'static str = "fk_motion";
}
impl Structure for fk_path {
    const NAME: &'static str = "fk_path";
}
impl Structure for fk_step_limits {
    const NAME: &'static str = "fk_step_limits";
}
impl Structure for fk_contact {
    const NAME: &'static str = "fk_contact";
}
impl Structure for fk_support {
    const NAME: &'static str = "fk_support";
}
impl Structure for fk_energy {
    const NAME: &'static str = "fk_energy";
}
impl Structure for fk_fabric {
    const NAME: &'static str = "fk_fabric";
}
impl Structure for fk_counters {
    const NAME: &'static str = "fk_counters";
}
impl Structure for fk_outcome {
    const NAME: &'static str = "fk_outcome";
}

/// 0 or the error's number.
fn status(result: Result<(), Error>) -> i32 {
    match result {
        Ok(()) => FK_OK,
        Err(error) => error.code.number(),
    }
}

/// Refuses null, misaligned and unknown-sized structures.
///
/// # Safety
/// `pointer` is null or points to a readable structure.
unsafe fn known<T: Structure>(pointer: *const T) -> Result<(), Error> {
    if pointer.is_null() {
        return Err(Error::plain(Code::NullPointer, T::NAME));
    }
    if !pointer.is_aligned() {
        return Err(Error::plain(Code::Misaligned, T::NAME));
    }
    // SAFETY: every structure starts with its 64-bit size.
    let size = unsafe { pointer.cast::<u64>().read() };
    let expected = size_of::<T>() as u64;
    if size == expected { Ok(()) } else { Err(Error::new(Code::StructSize, T::NAME, size as f64, expected as f64)) }
}

/// Reads a structure.
///
/// # Safety
/// As for [`known`].
unsafe fn read<T: Structure>(pointer: *const T) -> Result<T, Error> {
    // SAFETY: the caller's promise; known() refuses null and misaligned pointers and foreign sizes.
    unsafe {
        known(pointer)?;
        Ok(pointer.read())
    }
}

/// Writes a structure that the caller has given its size.
///
/// # Safety
/// As for [`known`], and writable.
unsafe fn put<T: Structure>(pointer: *mut T, value: T) -> Result<(), Error> {
    // SAFETY: the caller's promise; known() refuses null and misaligned pointers and foreign sizes.
    unsafe {
        known(pointer)?;
        pointer.write(value);
    }
    Ok(())
}

/// Writes a single number.
///
/// # Safety
/// `pointer` is null or writable.
unsafe fn put_number<T>(pointer: *mut T, field: &'static str, value: T) -> Result<(), Error> {
    if pointer.is_null() {
        return Err(Error::plain(Code::NullPointer, field));
    }
    // SAFETY: not null; the caller vouches for the rest.
    unsafe { pointer.write_unaligned(value) };
    Ok(())
}

/// A caller's array.
///
/// # Safety
/// `pointer` is null or points to `length` readable elements.
unsafe fn array<'a, T>(pointer: *const T, length: u64, field: &'static str) -> Result<&'a [T], Error> {
    let length = checked::<T>(pointer, length, field)?;
    // SAFETY: not null, aligned, of a length that a slice can have; the caller vouches for the memory.
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}

/// A caller's array, to be written.
///
/// # Safety
/// `pointer` is null or points to `length` writable elements that nothing else uses during the call.
unsafe fn array_mut<'a, T>(pointer: *mut T, length: u64, field: &'static str) -> Result<&'a mut [T], Error> {
    let length = checked::<T>(pointer, length, field)?;
    // SAFETY: not null, aligned, of a length that a slice can have; the caller vouches for the memory.
    Ok(unsafe { core::slice::from_raw_parts_mut(pointer, length) })
}

fn checked<T>(pointer: *const T, length: u64, field: &'static str) -> Result<usize, Error> {
    if pointer.is_null() {
        return Err(Error::plain(Code::NullPointer, field));
    }
    if !pointer.is_aligned() {
        return Err(Error::plain(Code::Misaligned, field));
    }
    let largest = isize::MAX as usize / size_of::<T>();
    usize::try_from(length).ok().filter(|&n| n <= largest).ok_or(Error::new(
        Code::WrongLength,
        field,
        length as f64,
        largest as f64,
    ))
}

/// Returns FK_ABI_VERSION of the library; compare it with the header's.
#[unsafe(no_mangle)]
pub extern "C" fn fk_abi_version() -> u32 {
    FK_ABI_VERSION
}

/// Returns the library's version, e.g. "0.1.0", a static string.
#[unsafe(no_mangle)]
pub extern "C" fn fk_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };
    VERSION.as_ptr()
}

/// Returns what a status number means, a static string; "unknown status" for numbers that no call returns.
#[unsafe(no_mangle)]
pub extern "C" fn fk_status_name(status: i32) -> *const c_char {
    if status == FK_OK {
        return c"success".as_ptr();
    }
    Code::ALL.iter().find(|code| code.number() == status).map_or(c"unknown status", |code| code.text()).as_ptr()
}

/// Fills `scene` with the 10 in preset. `struct_size` is sizeof(fk_scene) as the caller was compiled.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_scene_default(scene: *mut fk_scene, struct_size: u64) -> i32 {
    // SAFETY: the same contract.
    unsafe { fk_scene_preset(scene, struct_size, FK_PRESET_SHEET_10IN_CYLINDER) }
}

/// Fills `scene` with a preset (FK_PRESET_...). `struct_size` is sizeof(fk_scene) as the caller was compiled.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_UNKNOWN_CHOICE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_scene_preset(scene: *mut fk_scene, struct_size: u64, preset: u32) -> i32 {
    let fill = || {
        if scene.is_null() {
            return Err(Error::plain(Code::NullPointer, "fk_scene"));
        }
        if !scene.is_aligned() {
            return Err(Error::plain(Code::Misaligned, "fk_scene"));
        }
        if struct_size != size_of::<fk_scene>() as u64 {
            return Err(Error::plain(Code::StructSize, "fk_scene"));
        }
        let preset = match preset {
            FK_PRESET_SHEET_3IN_SPHERE => Scene::sheet_3in_sphere(),
            FK_PRESET_SHEET_10IN_CYLINDER => Scene::sheet_10in_cylinder(),
            FK_PRESET_TURBINE_DISC_SECTOR => Scene::turbine_disc_sector(),
            other => return Err(Error::new(Code::UnknownChoice, "preset", other as f64, 0.0)),
        };
        // SAFETY: not null, aligned, and the caller says it has the structure's size.
        unsafe { scene.write(fk_scene::of(&preset)) };
        Ok(())
    };
    status(fill())
}

/// Checks a scene, the time step included (which draws every segment of a stochastic sheet). `fault` may be null; on an
/// error it receives the code, the first bad field, the value and the limit.
/// Errors: every precondition of fk_scene's fields, FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_scene_check(scene: *const fk_scene, fault: *mut fk_fault) -> i32 {
    let check = || {
        // SAFETY: the caller's structure.
        let scene = unsafe { read(scene)? }.scene()?;
        in_our_environment(|| scene.step_limits())?;
        Ok(())
    };
    // SAFETY: the caller's structure.
    unsafe { telling(fault, check) }
}

/// Bytes and alignment of the block that fk_init needs for a scene.
/// Errors: those of fk_scene_check but for the time step. On an error neither number has been written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_memory_size(scene: *const fk_scene, bytes: *mut u64, align: *mut u64) -> i32 {
    let answer = || {
        // SAFETY: the caller's structure.
        let scene = unsafe { read(scene)? }.scene()?;
        let needed = block::bytes(&in_our_environment(|| Layout::of(&scene))?)? as u64;
        if align.is_null() {
            return Err(Error::plain(Code::NullPointer, "align"));
        }
        // SAFETY: the caller's numbers.
        unsafe {
            put_number(bytes, "bytes", needed)?;
            put_number(align, "align", block::ALIGN as u64)
        }
    };
    status(answer())
}

/// Makes a simulation of `scene` at the start of the caller's block and hands back its handle in `out`. The block must
/// not be moved or copied while the handle is used (use fk_state_save and fk_state_load); simply let go of it when done.
/// `fault` may be null. On an error nothing has been written but `fault`.
/// Errors: those of fk_scene_check, FK_SHORT_BUFFER, FK_MISALIGNED, FK_INITIAL_OVERLAP, FK_PROJECTILE_TOO_FAST,
/// FK_OUT_OF_RANGE (a projectile too heavy for its energy to be a number).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_init(
    memory: *mut core::ffi::c_void,
    bytes: u64,
    scene: *const fk_scene,
    out: *mut *mut fk_sim,
    fault: *mut fk_fault,
) -> i32 {
    let make = || {
        if memory.is_null() {
            return Err(Error::plain(Code::NullPointer, "memory"));
        }
        if out.is_null() {
            return Err(Error::plain(Code::NullPointer, "out"));
        }
        // SAFETY: the caller's structure and block.
        unsafe {
            let scene = read(scene)?.scene()?;
            let handle = in_our_environment(|| block::init(memory.cast(), bytes, &scene))?;
            put_number(out, "out", handle)
        }
    };
    // SAFETY: the caller's structure.
    unsafe { telling(fault, make) }
}

/// Runs a call that tells why it refuses in `fault`, if there is one. A fault that cannot be written is refused before
/// anything is done, so that it never hides another reason.
///
/// # Safety
/// `fault` is null or points to a writable structure.
unsafe fn telling(fault: *mut fk_fault, work: impl FnOnce() -> Result<(), Error>) -> i32 {
    if fault.is_null() {
        return status(work());
    }
    // SAFETY: the caller's structure.
    if let Err(unusable) = unsafe { known(fault) } {
        return unusable.code.number();
    }
    let result = work();
    if let Err(error) = &result {
        // SAFETY: known() found it writable as a structure; the caller vouches for the memory.
        unsafe { fault.write(fk_fault::of(error)) };
    }
    status(result)
}

/// Runs a call that changes the simulation; after a failure it repeats the failure.
///
/// # Safety
/// `sim` is null or a handle from fk_init that no other call is using.
unsafe fn change(sim: *mut fk_sim, work: impl FnOnce(&mut fabric::Sim<'static>) -> Result<(), Error>) -> i32 {
    let work = |sim: &mut fabric::Sim<'static>| match sim.failure() {
        Some(failure) => Err(failure.into()),
        None => work(sim),
    };
    // SAFETY: the caller's promise.
    unsafe { change_even_failed(sim, work) }
}

/// Runs a call that changes the simulation and that a failure does not stop. Notes why it is refused or fails.
///
/// # Safety
/// As for [`change`].
unsafe fn change_even_failed(
    sim: *mut fk_sim,
    work: impl FnOnce(&mut fabric::Sim<'static>) -> Result<(), Error>,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise.
        let block = unsafe { block::open(sim)? };
        let result = in_our_environment(|| work(&mut block.sim));
        if let Err(error) = result {
            block.last = Some(error);
        }
        result
    };
    status(work())
}

/// Runs a call that only looks; after a failure it repeats the failure.
///
/// # Safety
/// `sim` is null or a handle from fk_init that no other call is changing.
unsafe fn view(sim: *const fk_sim, work: impl FnOnce(&fabric::Sim<'static>) -> Result<(), Error>) -> i32 {
    let work = |block: &fk_sim| match block.sim.failure() {
        Some(failure) => Err(failure.into()),
        None => work(&block.sim),
    };
    // SAFETY: the caller's promise.
    unsafe { view_even_failed(sim, work) }
}

/// Runs a call that only looks and that a failure does not stop.
///
/// # Safety
/// As for [`view`].
unsafe fn view_even_failed(sim: *const fk_sim, work: impl FnOnce(&fk_sim) -> Result<(), Error>) -> i32 {
    // SAFETY: the caller's promise.
    status(unsafe { block::look(sim) }.and_then(|block| in_our_environment(|| work(block))))
}

/// Back to step 0 as after fk_init. Clears a failure, the fault of fk_get_fault and the external load.
/// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_reset(sim: *mut fk_sim) -> i32 {
    let reset = || {
        // SAFETY: the caller's handle.
        let block = unsafe { block::open(sim)? };
        in_our_environment(|| block.sim.reset());
        block.last = None;
        Ok(())
    };
    status(reset())
}

/// One step. Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, and the failures FK_NON_FINITE, FK_CONTACT_CAPACITY, FK_TOO_FAST,
/// which every later call but reset, load and the counters repeats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_step(sim: *mut fk_sim) -> i32 {
    // SAFETY: the caller's handle.
    unsafe { change(sim, |sim| Ok(sim.step()?)) }
}

/// `steps` steps; the bits do not depend on how they are split over calls. Errors as fk_step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_advance(sim: *mut fk_sim, steps: u64) -> i32 {
    // SAFETY: the caller's handle.
    unsafe { change(sim, |sim| Ok(sim.advance(steps)?)) }
}

/// Up to `steps` steps, ending when any outcome of `mask` (FK_ARRESTED | ...) is latched. `taken` (may be null) receives the
/// steps taken. Errors as fk_step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_advance_until(sim: *mut fk_sim, mask: u32, steps: u64, taken: *mut u64) -> i32 {
    let work = |sim: &mut fabric::Sim<'static>| {
        let count = sim.advance_until(mask, steps)?;
        if taken.is_null() {
            return Ok(());
        }
        // SAFETY: the caller's number.
        unsafe { put_number(taken, "taken", count) }
    };
    // SAFETY: the caller's handle.
    unsafe { change(sim, work) }
}

/// Moves a prescribed body along `path` for `steps` steps. Call again with the same path to go on along it.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, FK_WRONG_DRIVE, FK_BAD_PATH, FK_NOT_FINITE,
/// FK_BAD_QUATERNION, FK_PROJECTILE_TOO_FAST, FK_OUT_OF_RANGE; failures as fk_step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_follow(sim: *mut fk_sim, path: *const fk_path, steps: u64) -> i32 {
    let work = |sim: &mut fabric::Sim<'static>| {
        // SAFETY: the caller's structure.
        let path = unsafe { read(path)? };
        // SAFETY: a structure inside a structure that was just read.
        unsafe { known(&raw const path.end)? };
        sim.follow(&Path { first: path.first, steps: path.steps, end: path.end.motion() }, steps)
    };
    // SAFETY: the caller's handle.
    unsafe { change(sim, work) }
}

/// Bytes of scratch, aligned as the block, that fk_bands_begin needs for `of` bands.
/// Errors: FK_NULL_POINTER, FK_OUT_OF_RANGE (`of` is not 1 to FK_MAX_BANDS), FK_NOT_IN_BANDS, FK_MOVED_BLOCK, a latched
/// failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_size(sim: *const fk_sim, of: u32, bytes: *mut u64) -> i32 {
    // SAFETY: the caller's handle and number.
    unsafe { view(sim, |sim| put_number(bytes, "bytes", block::bands_bytes(sim.layout(), of)? as u64)) }
}

/// Cuts the sheet into `of` bands of rows, to be stepped by as many threads of the host's. From here to fk_bands_end the
/// bands have the simulation: every call but fk_bands_pass and fk_bands_progress is refused with FK_BAND_OUT_OF_TURN.
/// `scratch` must not be moved or used by anything else until then.
/// Errors: FK_NULL_POINTER, FK_SHORT_BUFFER, FK_MISALIGNED, FK_OUT_OF_RANGE, FK_NOT_IN_BANDS, FK_BAND_OUT_OF_TURN (bands are in
/// use), FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_begin(sim: *mut fk_sim, of: u32, scratch: *mut core::ffi::c_void, bytes: u64) -> i32 {
    // SAFETY: the caller's handle and scratch.
    status(in_our_environment(|| unsafe { block::begin(sim, of, scratch.cast(), bytes) }))
}

/// One band's part of a pass: a pass is a step, or half of one after step_after_failure. To be called for every band once a
/// pass, in any order, from any threads, at the same time. Nothing waits in here: the last band to be done completes the pass
/// for all. `last` (may be null) receives 1 in that call, else 0. The host must wait for the pass to be complete before it
/// calls the same band again: until then it is refused. The bits are those of fk_step.
/// Errors: FK_OUT_OF_RANGE (no such band), FK_BAND_OUT_OF_TURN (called already in this pass, or no fk_bands_begin): nothing
/// changed. FK_NULL_POINTER, FK_MOVED_BLOCK. A failure as fk_step: to the last band, and to every band in later passes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_pass(sim: *const fk_sim, band: u32, last: *mut u32) -> i32 {
    let pass = || {
        // SAFETY: the caller's handle and number.
        unsafe {
            let completed = in_our_environment(|| block::bands(sim)?.pass(band))?;
            if last.is_null() { Ok(()) } else { put_number(last, "last", u32::from(completed)) }
        }
    };
    status(pass())
}

/// How far the bands have come since fk_bands_begin: passes completed (a failed one included), steps completed, outcomes
/// latched (FK_ARRESTED | ...). Any pointer may be null; any thread may look at any time. When `passes` has grown, the next
/// pass may begin; while a thread's own band has not been called, none of the three changes.
/// Errors: FK_NULL_POINTER (sim), FK_BAND_OUT_OF_TURN (no fk_bands_begin), FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_progress(
    sim: *const fk_sim,
    passes: *mut u64,
    steps: *mut u64,
    outcomes: *mut u32,
) -> i32 {
    let look = || {
        // SAFETY: the caller's handle and numbers, null or writable.
        unsafe {
            let bands = block::bands(sim)?;
            // First: the others are then at least as new.
            let completed = bands.passes();
            if !passes.is_null() {
                put_number(passes, "passes", completed)?;
            }
            if !steps.is_null() {
                put_number(steps, "steps", bands.steps())?;
            }
            if !outcomes.is_null() {
                put_number(outcomes, "outcomes", bands.outcomes())?;
            }
        }
        Ok(())
    };
    status(look())
}

/// Gives the simulation back to the other calls, once no thread is in a call of the bands any more. A step that only some
/// bands have taken is completed. Returns the failure of the last pass, if there was one.
/// Errors: FK_NULL_POINTER, FK_BAND_OUT_OF_TURN (no fk_bands_begin), FK_MOVED_BLOCK; failures as fk_step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_end(sim: *mut fk_sim) -> i32 {
    let end = || {
        // SAFETY: the caller's handle.
        let block = unsafe { in_our_environment(|| block::end(sim))? };
        match block.sim.failure() {
            Some(failure) => {
                block.last = Some(failure.into());
                Err(failure.into())
            }
            None => Ok(()),
        }
    };
    status(end())
}

/// Step count and time (steps times dt), s. Either pointer may be null.
/// Errors: FK_NULL_POINTER (sim), FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_time(sim: *const fk_sim, steps: *mut u64, seconds: *mut f64) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        // SAFETY: the caller's numbers, null or writable.
        unsafe {
            if !steps.is_null() {
                put_number(steps, "steps", sim.step_count())?;
            }
            if !seconds.is_null() {
                put_number(seconds, "seconds", sim.time())?;
            }
        }
        Ok(())
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// The time step and its limits.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_step_limits(sim: *const fk_sim, out: *mut fk_step_limits) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        let limits = sim.step_limits();
        let struct_size = size_of::<fk_step_limits>() as u64;
        let value = fk_step_limits { struct_size, dt: limits.dt, dt_crit: limits.dt_crit, step_max: limits.step_max };
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// The projectile: pose at the present time, rates of the last half step.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_projectile(sim: *const fk_sim, out: *mut fk_motion) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        let motion = sim.projectile()?;
        let value = fk_motion {
            struct_size: size_of::<fk_motion>() as u64,
            position: motion.position,
            velocity: motion.velocity,
            orientation: motion.orientation,
            angular_velocity: motion.angular_velocity,
        };
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// Sets the force, N, and torque, N m (3 numbers each, host's axes), that act on a free body from now on.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_NOT_FINITE, FK_WRONG_DRIVE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_set_external_load(sim: *mut fk_sim, force: *const f64, torque: *const f64) -> i32 {
    let work = |sim: &mut fabric::Sim<'static>| {
        // SAFETY: the caller's arrays of three.
        let (force, torque) = unsafe { (array(force, 3, "external.force")?, array(torque, 3, "external.torque")?) };
        let (&[fx, fy, fz], &[tx, ty, tz]) = (force, torque) else {
            return Err(Error::plain(Code::WrongLength, "external.force"));
        };
        sim.set_external_load([fx, fy, fz], [tx, ty, tz])
    };
    // SAFETY: the caller's handle.
    unsafe { change(sim, work) }
}

/// Starts from given positions, m, and velocities, m/s: `n` = 3 numbers per node each, node by node, rows along x first,
/// host's frame. Only before the first step; the velocity of fixed nodes must be 0.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE, FK_INITIAL_OVERLAP,
/// FK_ALREADY_STARTED, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_set_motion(sim: *mut fk_sim, positions: *const f64, velocities: *const f64, n: u64) -> i32 {
    let work = |sim: &mut fabric::Sim<'static>| {
        // SAFETY: the caller's arrays.
        let (positions, velocities) =
            unsafe { (array(positions, n, "positions")?, array(velocities, n, "velocities")?) };
        sim.set_motion(positions, velocities)
    };
    // SAFETY: the caller's handle.
    unsafe { change(sim, work) }
}

/// Gives every segment the largest stretch it has ever had (`n` = number of segments, horizontal ones first, row by row):
/// a pre-damaged sheet. Only before the first step.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE, FK_ALREADY_STARTED,
/// FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_set_largest_stretch(sim: *mut fk_sim, stretches: *const f64, n: u64) -> i32 {
    let work = |sim: &mut fabric::Sim<'static>| {
        // SAFETY: the caller's array.
        sim.set_largest_stretch(unsafe { array(stretches, n, "stretches")? })
    };
    // SAFETY: the caller's handle.
    unsafe { change(sim, work) }
}

/// Contact sums. Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_contact(sim: *const fk_sim, out: *mut fk_contact) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        let contact = sim.contact()?;
        let value = fk_contact {
            struct_size: size_of::<fk_contact>() as u64,
            impulse: contact.impulse,
            angular_impulse: contact.angular_impulse,
            work: contact.work,
            loss: contact.loss,
            force_peak: contact.force_peak,
        };
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// Impulses on the supports; zero without track_support.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_support(sim: *const fk_sim, out: *mut fk_support) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        let support = sim.support()?;
        let struct_size = size_of::<fk_support>() as u64;
        let value = fk_support { struct_size, total: support.total, attachments: support.attachments };
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// The energies, with a full pass over the sheet.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_energy(sim: *const fk_sim, out: *mut fk_energy) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        let energy = sim.energy()?;
        let value = fk_energy {
            struct_size: size_of::<fk_energy>() as u64,
            projectile_kinetic: energy.projectile_kinetic,
            fabric_kinetic: energy.fabric_kinetic,
            strain: energy.strain,
            dissipated: energy.dissipated,
            contact_loss: energy.contact_loss,
            contact_work: energy.contact_work,
            external_work: energy.external_work,
            residual: energy.residual,
            halving: energy.halving,
        };
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// Linear momentum, N s, that the balance does not close by: three numbers, host's axes. Meaningful with track_support.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_momentum_residual(sim: *const fk_sim, out: *mut f64) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        let residual = sim.momentum_residual()?;
        // SAFETY: the caller's array of three.
        let out = unsafe { array_mut(out, 3, "out")? };
        out.iter_mut().zip(residual).for_each(|(slot, component)| *slot = component);
        Ok(())
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// Largest deflection and stretch, with a full pass over the sheet.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_fabric(sim: *const fk_sim, out: *mut fk_fabric) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        let fabric = sim.fabric()?;
        let struct_size = size_of::<fk_fabric>() as u64;
        let value = fk_fabric { struct_size, max_deflection: fabric.max_deflection, max_stretch: fabric.max_stretch };
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// Counters; also after a failure. Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_counters(sim: *const fk_sim, out: *mut fk_counters) -> i32 {
    let work = |block: &fk_sim| {
        let counters = block.sim.counters();
        let value = fk_counters {
            struct_size: size_of::<fk_counters>() as u64,
            steps: counters.steps,
            failed_segments: counters.failed_segments,
            contacts: counters.contacts,
            unconverged: counters.unconverged,
            most_sweeps: counters.most_sweeps,
            most_candidates: counters.most_candidates,
            candidate_capacity: counters.candidate_capacity,
            worst_penetration: counters.worst_penetration,
            iterations: counters.iterations,
            most_iterations: counters.most_iterations,
        };
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view_even_failed(sim, work) }
}

/// Why the last call that changes this simulation (fk_step ... fk_set_motion, fk_state_load) was refused or failed; status
/// FK_OK and empty texts if none was since fk_init or fk_reset. Also after a failure.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_fault(sim: *const fk_sim, out: *mut fk_fault) -> i32 {
    let work = |block: &fk_sim| {
        let value = block.last.as_ref().map_or(fk_fault::NONE, fk_fault::of);
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view_even_failed(sim, work) }
}

/// Outcomes latched so far. Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_outcome(sim: *const fk_sim, out: *mut fk_outcome) -> i32 {
    let work = |sim: &fabric::Sim<'static>| {
        let outcomes = sim.outcomes();
        let latched = Outcome::ALL.map(|outcome| outcomes.latched.get(outcome as usize).copied().flatten());
        let value = fk_outcome {
            struct_size: size_of::<fk_outcome>() as u64,
            status: outcomes.status as u32,
            mask: outcomes.mask,
            first_contact: outcomes.first_contact.unwrap_or(FK_NEVER),
            step: latched.map(|latch| latch.map_or(FK_NEVER, |latch| latch.step)),
            work: latched.map(|latch| latch.map_or(0.0, |latch| latch.work)),
        };
        // SAFETY: the caller's structure.
        unsafe { put(out, value) }
    };
    // SAFETY: the caller's handle.
    unsafe { view(sim, work) }
}

/// Positions, m: `n` = 3 numbers per node, node by node, rows along x first, host's frame.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_copy_positions(sim: *const fk_sim, out: *mut f64, n: u64) -> i32 {
    // SAFETY: the caller's handle and array.
    unsafe { view(sim, |sim| sim.copy_positions(array_mut(out, n, "out")?)) }
}

/// Velocities, m/s: shape and errors as fk_copy_positions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_copy_velocities(sim: *const fk_sim, out: *mut f64, n: u64) -> i32 {
    // SAFETY: the caller's handle and array.
    unsafe { view(sim, |sim| sim.copy_velocities(array_mut(out, n, "out")?)) }
}

/// alpha of every segment (1 whole, 0 failed): `n` = number of segments, horizontal ones first, row by row, then the
/// vertical ones. Errors as fk_copy_positions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_copy_damage(sim: *const fk_sim, out: *mut f64, n: u64) -> i32 {
    // SAFETY: the caller's handle and array.
    unsafe { view(sim, |sim| sim.copy_damage(array_mut(out, n, "out")?)) }
}

/// Stretch of every segment: shape and errors as fk_copy_damage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_copy_stretch(sim: *const fk_sim, out: *mut f64, n: u64) -> i32 {
    // SAFETY: the caller's handle and array.
    unsafe { view(sim, |sim| sim.copy_stretch(array_mut(out, n, "out")?)) }
}

/// Bytes of a snapshot image. Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_state_size(sim: *const fk_sim, bytes: *mut u64) -> i32 {
    // SAFETY: the caller's handle and number.
    unsafe { view(sim, |sim| put_number(bytes, "bytes", sim.snapshot_bytes() as u64)) }
}

/// Writes the state into `image`, at least fk_state_size bytes: portable between machines.
/// Errors: FK_NULL_POINTER, FK_SHORT_BUFFER, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_state_save(sim: *const fk_sim, image: *mut u8, bytes: u64) -> i32 {
    // SAFETY: the caller's handle and array.
    unsafe { view(sim, |sim| sim.save(array_mut(image, bytes, "image")?)) }
}

/// Puts the simulation into the state of an image of the same scene; clears a failure. On an error nothing has changed.
/// Errors: FK_NULL_POINTER, FK_IMAGE_MALFORMED, FK_IMAGE_OF_ANOTHER_SCENE, FK_IMAGE_INVALID, FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_state_load(sim: *mut fk_sim, image: *const u8, bytes: u64) -> i32 {
    // SAFETY: the caller's handle and array.
    unsafe { change_even_failed(sim, |sim| sim.load(array(image, bytes, "image")?)) }
}

/// A hash of the whole state: equal digests mean equal bits. Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_digest(sim: *const fk_sim, digest: *mut u64) -> i32 {
    // SAFETY: the caller's handle and number.
    unsafe { view(sim, |sim| put_number(digest, "digest", sim.digest())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_its_constant() {
        // The header's numbers are the kernel's.
        let numbers = [
            FK_NULL_POINTER,
            FK_SHORT_BUFFER,
            FK_MISALIGNED,
            FK_MOVED_BLOCK,
            FK_STRUCT_SIZE,
            FK_NOT_FINITE,
            FK_NOT_POSITIVE,
            FK_OUT_OF_RANGE,
            FK_UNKNOWN_CHOICE,
            FK_BAD_QUATERNION,
            FK_TOO_MANY_NODES,
            FK_STEP_TOO_LARGE,
            FK_STEP_LIMIT_UNUSABLE,
            FK_DAMAGE_RATE_TOO_SMALL,
            FK_PROJECTILE_TOO_LIGHT,
            FK_PROJECTILE_TOO_SMALL,
            FK_PROJECTILE_TOO_FAST,
            FK_INITIAL_OVERLAP,
            FK_DISCS_OVERLAP,
            FK_DISC_TOUCHES_PROJECTILE,
            FK_WRONG_LENGTH,
            FK_WRONG_DRIVE,
            FK_BAD_PATH,
            FK_ALREADY_STARTED,
            FK_IMAGE_MALFORMED,
            FK_IMAGE_OF_ANOTHER_SCENE,
            FK_IMAGE_INVALID,
            FK_BAD_NORMAL,
            FK_UNBOUNDED_FACES,
            FK_IMPOSSIBLE_MOMENTS,
            FK_NOT_SYMMETRIC,
            FK_NOT_BUILT,
            FK_BAND_OUT_OF_TURN,
            FK_NOT_IN_BANDS,
            FK_NON_FINITE,
            FK_CONTACT_CAPACITY,
            FK_TOO_FAST,
            FK_NOT_CONVERGED,
        ];
        assert_eq!(numbers.as_slice(), Code::ALL.map(Code::number).as_slice());
        assert_eq!(FK_MAX_BANDS, fabric::bands::MAX_BANDS);
    }

    #[test]
    fn a_scene_survives_the_round_trip() {
        for scene in [Scene::sheet_3in_sphere(), Scene::sheet_10in_cylinder(), Scene::turbine_disc_sector()] {
            assert_eq!(fk_scene::of(&scene).scene(), Ok(scene));
        }
        for shape in [fabric::Shape::HemisphericalCylinder, fabric::Shape::Box] {
            let mut scene = Scene::sheet_3in_sphere();
            (scene.projectile.shape, scene.projectile.size) = (shape, [0.01, 0.02, 0.03]);
            assert_eq!(fk_scene::of(&scene).scene(), Ok(scene));
        }
    }

    /// What the C and C++ hosts print for the same scene and steps.
    const HOSTS: &str = include_str!("../../tests/c/digest");

    #[test]
    fn the_same_digest_as_the_kernel() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
        let layout = Layout::of(&scene).unwrap();
        let (mut reals, mut words) = (std::vec![0.0; layout.reals()], std::vec![0; layout.words()]);
        let memory = fabric::Memory { reals: &mut reals, words: &mut words };
        let mut sim = fabric::Sim::new(&scene, memory).unwrap();
        sim.advance(3000).unwrap();

        let structure = fk_scene::of(&scene);
        let (mut bytes, mut align, mut handle, mut digest) = (0, 0, core::ptr::null_mut(), 0);
        // SAFETY: structures, numbers and block of this test; the block is as long and aligned as asked for.
        unsafe {
            assert_eq!(fk_memory_size(&structure, &mut bytes, &mut align), FK_OK);
            let mut block = std::vec![[0_u64; 8]; bytes as usize / 64 + 2];
            let start = block.as_mut_ptr().cast::<u8>();
            let start = start.add(start.align_offset(align as usize));
            assert_eq!(fk_init(start.cast(), bytes, &structure, &mut handle, core::ptr::null_mut()), FK_OK);
            assert_eq!(fk_advance(handle, 3000), FK_OK);
            assert_eq!(fk_digest(handle, &mut digest), FK_OK);
        }
        assert_eq!(digest, sim.digest());
        assert_eq!(std::format!("{digest:016x}"), HOSTS.trim());
    }
}
