//! Every `fk_*` function. Each returns a status unless it says otherwise; a refused call has changed nothing.
//!
//! Stepping calls save, set (round to nearest, subnormals kept) and restore the floating-point environment, so that a host
//! built with fast-math gets the same bits.
//!
//! # Safety of all functions here
//! The pointers are as their types' [`Input::given`], [`Output::given`], [`ToLookAt::given`], [`ToChange::given`] and
//! [`Lent::given`] ask, still, and the counts beside them are theirs. A C host promises that by calling (the header's "Pointers");
//! it is checked no further than the errors of a call say. The functions themselves have no unsafe code: what trusts the host
//! stands in `fabric_host` (numbers and arrays), `sizes.rs` (structures) and `block.rs` (handles and lent memory).
#![allow(clippy::missing_safety_doc)] // said once, above

use crate::block::{self, Lent, ToChange, ToLookAt, fk_sim};
use crate::sizes::{Part, Structure, change_scene, put_scene, read, read_scene};
use crate::types::*;
use core::ffi::{CStr, c_char};
use fabric_capsule::Call;
use fabric_host::{Input, Output, in_our_environment};
use fabric_kernel::{Code, Error, Layout, OutcomeSet, Scene, Textile};

/// 0 or the error's number.
pub(crate) fn status(result: Result<(), Error>) -> i32 {
    match result {
        Ok(()) => FK_OK,
        Err(error) => error.code.number(),
    }
}

/// Writes a single number, which may be misaligned. One that may be null is written by [`Output::put`].
pub(crate) fn put_number<T>(place: &mut Output<T>, field: &'static str, value: T) -> Result<(), Error> {
    if place.put(value) { Ok(()) } else { Err(Error::plain(Code::NullPointer, field)) }
}

/// A caller's array.
pub(crate) fn array<'a, T>(place: &'a Input<T>, length: u64, field: &'static str) -> Result<&'a [T], Error> {
    let count = usize::try_from(length).unwrap_or(usize::MAX);
    place.elements(count).ok_or_else(|| no_array(place.pointer(), length, field))
}

/// A caller's array, to be written.
pub(crate) fn array_mut<'a, T>(
    place: &'a mut Output<T>,
    length: u64,
    field: &'static str,
) -> Result<&'a mut [T], Error> {
    let count = usize::try_from(length).unwrap_or(usize::MAX);
    let pointer = place.pointer();
    place.elements(count).ok_or_else(|| no_array(pointer, length, field))
}

/// Why a pointer is not that of an array, if it is not: null, misaligned, or longer than memory can be.
fn no_array<T>(pointer: *const T, length: u64, field: &'static str) -> Error {
    if pointer.is_null() {
        return Error::plain(Code::NullPointer, field);
    }
    if !pointer.is_aligned() {
        return Error::plain(Code::Misaligned, field);
    }
    let largest = isize::MAX as usize / size_of::<T>();
    Error::new(Code::WrongLength, field, length as f64, largest as f64)
}

/// Returns FK_ABI_VERSION of the library. A host runs with every library whose number is at least its header's.
/// Threads: any, at any time. Time: constant. Touches: nothing.
#[unsafe(no_mangle)]
pub extern "C" fn fk_abi_version() -> u32 {
    FK_ABI_VERSION
}

/// Returns the library's version, e.g. "0.1.0", a static string.
/// Threads: any, at any time. Time: constant. Touches: nothing.
#[unsafe(no_mangle)]
pub extern "C" fn fk_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };
    VERSION.as_ptr()
}

/// Returns what a status number means, a static string; "unknown status" for numbers that no call returns.
/// Threads: any, at any time. Time: constant. Touches: nothing.
#[unsafe(no_mangle)]
pub extern "C" fn fk_status_name(status: i32) -> *const c_char {
    if status == FK_OK {
        return c"success".as_ptr();
    }
    Code::ALL.iter().find(|code| code.number() == status).map_or(c"unknown status", |code| code.text()).as_ptr()
}

/// Fills `scene` with a preset (FK_PRESET_...). `struct_size` is sizeof(fk_scene) as the caller was compiled, and becomes the
/// scene's first word. fk_scene_default and fk_scene_preset below call it.
/// Threads: any, each with its own scene. Time: constant. Touches: `scene`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_UNKNOWN_CHOICE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_scene_fill(mut scene: Output<fk_scene>, struct_size: u64, preset: u32) -> i32 {
    let mut fill = || {
        Part::of(&mut scene, struct_size)?;
        let mut preset = scene_of(preset);
        put_scene(&mut scene, struct_size, preset.as_mut().map_err(|error| *error)?)
    };
    status(fill())
}

/// The scene of a preset. Not inlined: it must not add to the stack of what is done with it.
#[inline(never)]
fn scene_of(preset: u32) -> Result<Scene, Error> {
    match preset {
        FK_PRESET_SHEET_3IN_SPHERE => Ok(Scene::sheet_3in_sphere()),
        FK_PRESET_SHEET_10IN_CYLINDER => Ok(Scene::sheet_10in_cylinder()),
        FK_PRESET_TURBINE_DISC_SECTOR => Ok(Scene::turbine_disc_sector()),
        FK_PRESET_RING_40IN => Ok(Scene::ring_40in()),
        other => Err(Error::new(Code::UnknownChoice, "preset", other as f64, 0.0)),
    }
}

/// Makes the sheet of `scene` that of a textile's data sheet: sheet.spacing, spacing_y, node_mass, yarn_area, yarn_area_y and crimp,
/// the yarn law, without one of the weft's own, and the viscosity 0.06, 1.5, 0.06, which the theta rule does not take; all else
/// stays (docs/model.md, "From a textile to a scene").
/// `textile_size` is sizeof(fk_textile). `fault` may be null; on an error it receives the number, the first bad field, e.g.
/// "textile.warp.count", its value and the limit. `fault_size` is its sizeof.
/// Threads: any, each with its own scene. Time: constant. Touches: `scene`; on an error only `fault`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_UNKNOWN_CHOICE (of the scene); of the textile FK_NOT_FINITE,
/// FK_NOT_POSITIVE, FK_OUT_OF_RANGE, FK_DAMAGE_RATE_TOO_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_scene_set_textile(
    mut scene: Output<fk_scene>,
    textile: Input<fk_textile>,
    textile_size: u64,
    fault: Output<fk_fault>,
    fault_size: u64,
) -> i32 {
    telling(fault, fault_size, || change_fabric(&mut scene, textile, textile_size, Scene::set_textile))
}

/// Makes the group `back` of `scene`, but for back.plies, the fabric of a textile's data sheet in the scene's own grid of nodes, and
/// yarn.viscosity_quadratic that of the textile of the two that takes less; all else stays (docs/model.md, "Two fabrics").
/// Sizes, fault, threads, time and errors: as for fk_scene_set_textile. Touches: `scene`; on an error only `fault`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_scene_set_back_textile(
    mut scene: Output<fk_scene>,
    textile: Input<fk_textile>,
    textile_size: u64,
    fault: Output<fk_fault>,
    fault_size: u64,
) -> i32 {
    telling(fault, fault_size, || change_fabric(&mut scene, textile, textile_size, Scene::set_back_textile))
}

/// Chooses a graded network, sheet.grading, for a hit as the projectile of `scene` starts, with absorbed energy and residual velocity
/// expected to be wrong by at most `error`, a part of them in [0.005, 0.1]; all else stays (docs/model.md, "Graded networks"). `fault`
/// may be null; on an error it receives the number, the first bad field, its value and the limit. `fault_size` is its sizeof.
/// Threads: any, each with its own scene. Time: constant. Touches: `scene`; on an error only `fault`.
/// Errors: FK_OUT_OF_RANGE and FK_NOT_FINITE of `error`, and those of fk_scene_check.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_scene_set_grading(
    mut scene: Output<fk_scene>,
    error: f64,
    fault: Output<fk_fault>,
    fault_size: u64,
) -> i32 {
    telling(fault, fault_size, || change_scene(&mut scene, |scene| in_our_environment(|| scene.set_grading(error))))
}

/// Refuses what fk_init refuses of a scene, whatever block it is given, in some milliseconds for any scene. The answer is that of fk_init,
/// unless more than 8192 segments are drawn or nodes lie under the projectile: only so many are looked at then, evenly spread, and what
/// another one alone forbids is found by fk_init. `fault` may be null; on an error it receives the number, the first bad field, its
/// value and the limit. `fault_size` is its sizeof.
/// Threads: any. Time: at most milliseconds. Touches: `fault`, on an error.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE; of the scene, each where a field of it says so or the
/// constant's text does: FK_NOT_FINITE, FK_NOT_POSITIVE, FK_OUT_OF_RANGE, FK_UNKNOWN_CHOICE, FK_BAD_QUATERNION,
/// FK_TOO_MANY_NODES, FK_STEP_TOO_LARGE, FK_STEP_LIMIT_UNUSABLE, FK_DAMAGE_RATE_TOO_SMALL, FK_PROJECTILE_TOO_LIGHT,
/// FK_PROJECTILE_TOO_SMALL, FK_DISCS_OVERLAP, FK_DISC_TOUCHES_PROJECTILE, FK_BAD_NORMAL, FK_UNBOUNDED_FACES,
/// FK_IMPOSSIBLE_MOMENTS, FK_NOT_SYMMETRIC, FK_NOT_BUILT, FK_HOLDS_NOTHING, FK_NOT_IN_EQUILIBRIUM, FK_DOES_NOT_GO_WITH,
/// FK_INITIAL_OVERLAP, FK_PROJECTILE_TOO_FAST.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_scene_check(scene: Input<fk_scene>, fault: Output<fk_fault>, fault_size: u64) -> i32 {
    let check = || {
        let scene = read_scene(&scene);
        // By reference, here and below: a copy of the scene would take a kilobyte of stack.
        let scene = scene.as_ref().map_err(|error| *error)?;
        in_our_environment(|| {
            block::room(scene)?;
            scene.check_start()
        })
    };
    telling(fault, fault_size, check)
}

/// Bytes of the block that fk_init needs for a scene, wherever it starts. They depend on the nodes, the projectile's
/// size and the options, not on material or motion; they may differ between versions of the library.
/// Threads: any. Time: constant. Touches: `bytes`, not on an error.
/// Errors: those of fk_scene_check but for the time step and the projectile's start.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_memory_size(scene: Input<fk_scene>, mut bytes: Output<u64>) -> i32 {
    let mut answer = || {
        let scene = read_scene(&scene);
        let scene = scene.as_ref().map_err(|error| *error)?;
        let needed = block::bytes(&in_our_environment(|| Layout::of(scene))?)?;
        put_number(&mut bytes, "bytes", needed as u64)
    };
    status(answer())
}

/// Makes a simulation of `scene` at step 0 in the caller's block, which may start anywhere, and hands back its handle in
/// `out`: sheet flat and at rest, projectile in its start motion. The scene is copied; the block's old content does not
/// matter. The block must not be moved or copied while the handle is used (use fk_state_save and fk_state_load); simply
/// let go of it when done.
/// Threads: any, each with its own block. Time: draws every segment of a stochastic sheet (some 0.1 us each), and a pass over the
/// block. Touches: the block and `out`; on an error only `fault`, which may be null.
/// Errors: those of fk_scene_check, FK_SHORT_BUFFER.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_init(
    memory: Lent,
    bytes: u64,
    scene: Input<fk_scene>,
    mut out: Output<*mut fk_sim>,
    fault: Output<fk_fault>,
    fault_size: u64,
) -> i32 {
    let make = || {
        if memory.is_null() {
            return Err(Error::plain(Code::NullPointer, "memory"));
        }
        if out.pointer().is_null() {
            return Err(Error::plain(Code::NullPointer, "out"));
        }
        let scene = read_scene(&scene);
        let scene = scene.as_ref().map_err(|error| *error)?;
        let handle = in_our_environment(|| block::init(memory, bytes, scene))?;
        put_number(&mut out, "out", handle)
    };
    telling(fault, fault_size, make)
}

/// Changes a scene by a textile.
fn change_fabric(
    scene: &mut Output<fk_scene>,
    textile: Input<fk_textile>,
    textile_size: u64,
    set: impl Fn(&mut Scene, &Textile) -> Result<(), Error>,
) -> Result<(), Error> {
    let textile = read(&textile, textile_size)?;
    change_scene(scene, |scene| in_our_environment(|| set(scene, &textile)))
}

/// Runs a call that tells why it refuses in `fault`, if there is one. A fault that cannot be written is refused before
/// anything is done, so that it never hides another reason.
fn telling(mut fault: Output<fk_fault>, size: u64, work: impl FnOnce() -> Result<(), Error>) -> i32 {
    if fault.pointer().is_null() {
        return status(work());
    }
    let part = match Part::of(&mut fault, size) {
        Ok(part) => part,
        Err(unusable) => return unusable.code.number(),
    };
    let result = work();
    if let Err(error) = &result {
        put_fault(part, error);
    }
    status(result)
}

/// Writes why a call was refused. Not inlined: the structure must not add to the stack of the call itself.
#[inline(never)]
fn put_fault(part: Part<'_, fk_fault>, error: &Error) {
    part.put(&fk_fault::of(error));
}

/// Runs a call that changes the simulation; after a failure it repeats the failure.
fn change(sim: ToChange, work: impl FnOnce(&mut fk_sim) -> Result<(), Error>) -> i32 {
    let work = |block: &mut fk_sim| match block.sim.failure() {
        Some(failure) => Err(failure.into()),
        None => work(block),
    };
    change_even_failed(sim, work)
}

/// Runs a call that is one of the kernel's.
fn run<'c>(sim: ToChange, call: impl FnOnce() -> Result<Call<'c>, Error>) -> i32 {
    change(sim, |block| block.run(&call()?))
}

/// Runs a call that changes the simulation and that a failure does not stop. Notes why it is refused or fails.
fn change_even_failed(mut sim: ToChange, work: impl FnOnce(&mut fk_sim) -> Result<(), Error>) -> i32 {
    let work = || {
        let block = block::open(&mut sim)?;
        let result = in_our_environment(|| work(block));
        if let Err(error) = result {
            block.last = Some(error);
        }
        result
    };
    status(work())
}

/// Runs a call that only reads; after a failure it repeats the failure.
fn view(sim: ToLookAt, work: impl FnOnce(&fabric_kernel::Sim<'static>) -> Result<(), Error>) -> i32 {
    let work = |block: &fk_sim| match block.sim.failure() {
        Some(failure) => Err(failure.into()),
        None => work(&block.sim),
    };
    view_even_failed(sim, work)
}

/// Runs a call that only reads and that a failure does not stop.
fn view_even_failed(sim: ToLookAt, work: impl FnOnce(&fk_sim) -> Result<(), Error>) -> i32 {
    status(block::look(&sim).and_then(|block| in_our_environment(|| work(block))))
}

/// Hands out a structure about the simulation, as long as the host's; after a failure it repeats the failure.
fn get<T: Structure>(
    sim: ToLookAt,
    mut out: Output<T>,
    size: u64,
    work: impl FnOnce(&fabric_kernel::Sim<'static>) -> Result<T, Error>,
) -> i32 {
    view(sim, |sim| put(&mut out, size, work(sim)?))
}

/// Reads a structure also after a failure.
fn get_even_failed<T: Structure>(sim: ToLookAt, mut out: Output<T>, size: u64, work: impl FnOnce(&fk_sim) -> T) -> i32 {
    view_even_failed(sim, |block| put(&mut out, size, work(block)))
}

/// Writes a structure as far as the host's goes.
fn put<T: Structure>(out: &mut Output<T>, size: u64, value: T) -> Result<(), Error> {
    Part::of(out, size)?.put(&value);
    Ok(())
}

/// Back to step 0 as after fk_init, and to its bits. Clears a failure, the fault of fk_get_fault, the external load,
/// and what fk_set_motion and fk_set_largest_stretch gave.
/// Threads: changes. Time: a pass over the sheet. Touches: the block.
/// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_reset(mut sim: ToChange) -> i32 {
    let mut reset = || {
        let block = block::open(&mut sim)?;
        in_our_environment(|| block.run(&Call::Reset))?;
        block.last = None;
        Ok(())
    };
    status(reset())
}

/// One step: M7 for the yarns, M8 for contact, then the projectile.
/// Threads: changes. Time: at most one step's; docs/embedding.md says how to bound it. Touches: the block.
/// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK; failures FK_NON_FINITE, FK_CONTACT_CAPACITY, FK_TOO_FAST and with the theta
/// rule FK_NOT_CONVERGED, which every later call but fk_reset, fk_state_load, fk_get_counters and fk_get_fault repeats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_step(sim: ToChange) -> i32 {
    change(sim, |block| block.advance(1))
}

/// `steps` steps; the bits do not depend on how they are split over calls. A failure ends it early; fk_get_counters
/// then tells the steps taken.
/// Threads: changes. Time: `steps` steps. Touches: the block.
/// Errors: as fk_step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_advance(sim: ToChange, steps: u64) -> i32 {
    change(sim, |block| block.advance(steps))
}

/// Up to `steps` steps, ending after the one at which any outcome of `mask` (FK_ARRESTED | ...) is latched, at once if
/// one already is. Outcomes are tested every 64 steps. `taken` may be null.
/// Threads: changes. Time: at most `steps` steps. Touches: the block; `taken`, the steps taken, unless a failure ended
/// them.
/// Errors: as fk_step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_advance_until(sim: ToChange, mask: u32, steps: u64, mut taken: Output<u64>) -> i32 {
    let work = |block: &mut fk_sim| {
        let result = block.sim.advance_until(OutcomeSet::from_bits(mask), steps);
        block.note_steps(result.unwrap_or(steps));
        taken.put(result?);
        Ok(())
    };
    change(sim, work)
}

/// Moves a prescribed body along `path` (M13), of `path_size` = sizeof(fk_path), for `steps` steps. Call again with the
/// same path to go on along it; the bits do not depend on how a path is split. Without a path the body coasts.
/// Threads: changes. Time: `steps` steps. Touches: the block.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, FK_WRONG_DRIVE (the scene's drive is
/// FK_DRIVE_FREE), FK_BAD_PATH, FK_NOT_FINITE, FK_BAD_QUATERNION, FK_PROJECTILE_TOO_FAST, FK_OUT_OF_RANGE; failures as
/// fk_step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_follow(sim: ToChange, path: Input<fk_path>, path_size: u64, steps: u64) -> i32 {
    change(sim, |block| {
        start_path(block, &path, path_size, steps)?;
        block.advance(steps)
    })
}

#[inline(never)] // The path must not add to the stack of the steps.
fn start_path(block: &mut fk_sim, path: &Input<fk_path>, size: u64, steps: u64) -> Result<(), Error> {
    block.run(&Call::Path(read(path, size)?, steps))
}

/// Bytes of scratch that fk_bands_begin needs for `of` bands, wherever it starts.
/// Errors: FK_NULL_POINTER, FK_OUT_OF_RANGE (`of` is not 1 to FK_MAX_BANDS), FK_NOT_IN_BANDS, FK_TOO_MANY_NODES (more memory than
/// there can be), FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_size(sim: ToLookAt, of: u32, mut bytes: Output<u64>) -> i32 {
    view(sim, |sim| put_number(&mut bytes, "bytes", block::bands_bytes(sim.layout(), of)? as u64))
}

/// Cuts the sheet into `of` bands of rows, to be stepped by as many threads of the host's. From here to fk_bands_end the
/// bands have the simulation: every call but fk_bands_pass and fk_bands_progress is refused with FK_BAND_OUT_OF_TURN.
/// `scratch` must not be moved or used by anything else until then.
/// `steps`: how many steps will be taken at least until fk_bands_end; a sheet that is too large for the caches takes eight of these
/// in one block of nine passes. 0 if it is not known. If fewer are taken, fk_bands_end completes the block: up to eight steps more.
/// Errors: FK_NULL_POINTER, FK_SHORT_BUFFER, FK_OUT_OF_RANGE, FK_NOT_IN_BANDS, FK_TOO_MANY_NODES, FK_BAND_OUT_OF_TURN (bands are in
/// use), FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_begin(sim: ToChange, of: u32, steps: u64, scratch: Lent, bytes: u64) -> i32 {
    status(in_our_environment(|| block::begin(sim, of, steps, scratch, bytes)))
}

/// One band's part of a pass: a pass is a step; a block of eight steps takes nine. To be called for every band once a pass, in any order, from any threads, at the same time. Nothing waits in here: the
/// last band to be done completes the pass for all. `last` (may be null) receives 1 in that call, else 0. The host must wait for the pass to be complete before it
/// calls the same band again: until then it is refused. The bits are those of fk_step.
/// Errors: FK_OUT_OF_RANGE (no such band), FK_BAND_OUT_OF_TURN (called already in this pass, or no fk_bands_begin): nothing
/// changed. FK_NULL_POINTER, FK_MOVED_BLOCK. A failure as fk_step: to the last band, and to every band in later passes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_pass(sim: ToLookAt, band: u32, mut last: Output<u32>) -> i32 {
    let mut pass = || {
        let completed = in_our_environment(|| block::bands(&sim)?.pass(band))?;
        last.put(u32::from(completed));
        Ok(())
    };
    status(pass())
}

/// How far the bands have come since fk_bands_begin: passes completed (a failed one included), steps completed, outcomes
/// latched (FK_ARRESTED | ...). Any pointer may be null. Any thread may read them between fk_bands_begin and fk_bands_end, also while
/// others are in fk_bands_pass; the end drops what this reads. In a block `steps` grows by eight at its end. When `passes` has grown, the next pass may begin; while a
/// thread's own band has not been called, none of the three changes.
/// Errors: FK_NULL_POINTER (sim), FK_BAND_OUT_OF_TURN (no fk_bands_begin), FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_progress(
    sim: ToLookAt,
    mut passes: Output<u64>,
    mut steps: Output<u64>,
    mut outcomes: Output<u32>,
) -> i32 {
    let mut look = || {
        let bands = block::bands(&sim)?;
        // First: the others are then at least as new.
        let completed = bands.passes();
        passes.put(completed);
        steps.put(bands.steps());
        outcomes.put(bands.outcomes().bits());
        Ok(())
    };
    status(look())
}

/// Gives the simulation back to the other calls, once no thread is in a call of the bands any more. A step that only some
/// bands have taken, or a block that is begun, is completed. Returns the failure of the last pass, if there was one.
/// Errors: FK_NULL_POINTER, FK_BAND_OUT_OF_TURN (no fk_bands_begin), FK_MOVED_BLOCK; failures as fk_step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_bands_end(mut sim: ToChange) -> i32 {
    let mut end = || {
        let block = in_our_environment(|| block::end(&mut sim))?;
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

/// Step count, and time = steps times dt, s. Either pointer may be null.
/// Threads: reads. Time: constant. Touches: `steps`, `seconds`.
/// Errors: FK_NULL_POINTER (sim), FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_time(sim: ToLookAt, mut steps: Output<u64>, mut seconds: Output<f64>) -> i32 {
    let work = |sim: &fabric_kernel::Sim<'static>| {
        steps.put(sim.step_count());
        seconds.put(sim.time());
        Ok(())
    };
    view(sim, work)
}

/// The time step and its limits (M11).
/// Threads: reads. Time: constant. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_step_limits(sim: ToLookAt, out: Output<fk_step_limits>, size: u64) -> i32 {
    get(sim, out, size, |sim| Ok(sim.step_limits()))
}

/// Modelled part of the sheet: the lengths of the arrays below.
/// Threads: reads. Time: constant. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_grid(sim: ToLookAt, out: Output<fk_grid>, size: u64) -> i32 {
    let work = |sim: &fabric_kernel::Sim<'static>| {
        let layout = sim.layout();
        let rows = layout.y.modelled();
        Ok(fk_grid {
            nodes_x: layout.nodes_x as u64,
            nodes_y: rows as u64,
            horizontal: (layout.x.segments() * rows) as u64,
            vertical: (layout.nodes_x * layout.y.segments()) as u64,
            plies: layout.plies as u64,
        })
    };
    get(sim, out, size, work)
}

/// The projectile: pose at the present time, rates of the half step before it (M7).
/// Threads: reads. Time: constant. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_projectile(sim: ToLookAt, out: Output<fk_motion>, size: u64) -> i32 {
    get(sim, out, size, |sim| Ok(sim.projectile()?))
}

/// Sets the force, N, and torque about the centre of mass, N m (3 numbers each, host's axes), that act on a free body
/// from now on, in every step until they are set anew. At the start both are 0.
/// Threads: changes. Time: constant. Touches: the block.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_NOT_FINITE, FK_WRONG_DRIVE (the scene's drive is FK_DRIVE_PRESCRIBED),
/// FK_NOT_SYMMETRIC, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_set_external_load(sim: ToChange, force: Input<f64>, torque: Input<f64>) -> i32 {
    let work = |block: &mut fk_sim| {
        let (force, torque) = (array(&force, 3, "external.force")?, array(&torque, 3, "external.torque")?);
        let (&[fx, fy, fz], &[tx, ty, tz]) = (force, torque) else {
            return Err(Error::plain(Code::WrongLength, "external.force"));
        };
        block.run(&Call::ExternalLoad([fx, fy, fz], [tx, ty, tz]))
    };
    change(sim, work)
}

/// Starts from given positions, m, and velocities, m/s, at time 0: `n` = 3 plies nodes_x nodes_y (fk_get_grid) numbers each,
/// node by node, rows along x first, host's frame. For restarts from another code and sheets that start stretched.
/// Fixed nodes stay where this puts them; their velocity must be 0. Only before the first step, and after
/// fk_set_largest_stretch.
/// Threads: changes. Time: two passes over the sheet. Touches: the block.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE (a fixed node that
/// moves; a position beyond 1e30 spacings, a velocity beyond 1e30 spacings a step), FK_INITIAL_OVERLAP,
/// FK_PLIES_OVERLAP, FK_NOT_SYMMETRIC, FK_ALREADY_STARTED, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_set_motion(sim: ToChange, positions: Input<f64>, velocities: Input<f64>, n: u64) -> i32 {
    run(sim, || Ok(Call::Motion(array(&positions, n, "positions")?, array(&velocities, n, "velocities")?)))
}

/// Gives every segment the largest stretch it has ever had, U_max of M5: a pre-damaged sheet. `n` = horizontal +
/// vertical (fk_get_grid) numbers, horizontal ones first, row by row, in [0, 1e100]; up to the critical stretch means
/// whole. Only before the first step.
/// Threads: changes. Time: two passes over the sheet. Touches: the block.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE, FK_ALREADY_STARTED,
/// FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_set_largest_stretch(sim: ToChange, stretches: Input<f64>, n: u64) -> i32 {
    run(sim, || Ok(Call::LargestStretch(array(&stretches, n, "stretches")?)))
}

/// Contact sums (M8).
/// Threads: reads. Time: constant. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_contact(sim: ToLookAt, out: Output<fk_contact>, size: u64) -> i32 {
    get(sim, out, size, |sim| Ok(sim.contact()?))
}

/// Impulses on the supports; zero without track_support.
/// Threads: reads. Time: constant. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_support(sim: ToLookAt, out: Output<fk_support>, size: u64) -> i32 {
    get(sim, out, size, |sim| Ok(sim.support()?))
}

/// The energies (M15).
/// Threads: reads. Time: a pass over the sheet, with exp for damaged segments. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_energy(sim: ToLookAt, out: Output<fk_energy>, size: u64) -> i32 {
    get(sim, out, size, |sim| Ok(sim.energy()?))
}

/// Failed segments and energies of one ply, 0 to scene.stack.plies - 1; of a single sheet ply 0 is all.
/// Threads: reads. Time: a pass over the ply, with exp for damaged segments. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_OUT_OF_RANGE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_ply(sim: ToLookAt, ply: u32, out: Output<fk_ply>, size: u64) -> i32 {
    get(sim, out, size, |sim| sim.ply(ply))
}

/// At how many crossings yarns would slip, which the network pins. `thickness` of the ply, m, > 0; `friction` between yarns, >= 0; `adhesion`, the force
/// at a crossing without pressure, N, >= 0. Not of curved sheets.
/// Threads: reads. Time: a pass over the sheet, with exp for damaged segments. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_NOT_FINITE, FK_NOT_POSITIVE, FK_OUT_OF_RANGE, FK_DOES_NOT_GO_WITH, FK_NOT_BUILT,
/// FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_slip(
    sim: ToLookAt,
    thickness: f64,
    friction: f64,
    adhesion: f64,
    out: Output<fk_slip>,
    size: u64,
) -> i32 {
    get(sim, out, size, |sim| sim.slip(thickness, friction, adhesion))
}

/// Linear momentum, N s, that the balance of projectile, fabric, supports and external load does not close by: three
/// numbers, host's axes. Rounding in a sound run. Needs track_support.
/// Threads: reads. Time: a pass over the sheet. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_momentum_residual(sim: ToLookAt, mut out: Output<f64>) -> i32 {
    let work = |sim: &fabric_kernel::Sim<'static>| {
        let residual = sim.momentum_residual()?;
        let out = array_mut(&mut out, 3, "out")?;
        out.iter_mut().zip(residual).for_each(|(slot, component)| *slot = component);
        Ok(())
    };
    view(sim, work)
}

/// Largest deflection and stretch (M1). What is still joined to a support is found in the simulation's scratch.
/// Threads: changes, though no result. Time: a pass over the sheet. Touches: the block's scratch, `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_fabric(mut sim: ToChange, mut out: Output<fk_fabric>, size: u64) -> i32 {
    // Not change(): a read-out that is refused leaves nothing for fk_get_fault.
    let mut look = || {
        let block = block::open(&mut sim)?;
        let fabric = in_our_environment(|| block.sim.fabric())?;
        put(&mut out, size, fabric)
    };
    status(look())
}

/// Counters; also after a failure.
/// Threads: reads. Time: constant. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_counters(sim: ToLookAt, out: Output<fk_counters>, size: u64) -> i32 {
    get_even_failed(sim, out, size, |block| block.sim.counters())
}

/// Why the last call that changes this simulation (fk_step ... fk_set_motion, fk_state_load) was refused or failed;
/// status FK_OK and empty texts if none was since fk_init or fk_reset. Also after a failure.
/// Threads: reads. Time: constant. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_fault(sim: ToLookAt, out: Output<fk_fault>, size: u64) -> i32 {
    get_even_failed(sim, out, size, |block| block.last.as_ref().map_or(fk_fault::NONE, fk_fault::of))
}

/// Outcomes latched so far: physics, not errors. Tested every 64 steps; they change nothing.
/// Threads: reads. Time: constant. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_get_outcome(sim: ToLookAt, out: Output<fk_outcome>, size: u64) -> i32 {
    let work = |sim: &fabric_kernel::Sim<'static>| {
        let outcomes = sim.outcomes();
        Ok(fk_outcome {
            status: outcomes.status as u32,
            mask: outcomes.mask.bits(),
            first_contact: outcomes.first_contact.unwrap_or(FK_NEVER),
            step: outcomes.latched.map(|latch| latch.map_or(FK_NEVER, |latch| latch.step)),
            work: outcomes.latched.map(|latch| latch.map_or(0.0, |latch| latch.work)),
        })
    };
    get(sim, out, size, work)
}

/// Positions, m: `n` = 3 plies nodes_x nodes_y (fk_get_grid) numbers, node by node, rows along x first, host's frame.
/// Threads: reads. Time: a pass over the sheet. Touches: `out`.
/// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_copy_positions(sim: ToLookAt, mut out: Output<f64>, n: u64) -> i32 {
    view(sim, |sim| sim.copy_positions(array_mut(&mut out, n, "out")?))
}

/// Velocities at the present time, m/s: `n` and order as fk_copy_positions, host's axes.
/// Threads: reads. Time: a pass over the sheet. Touches: `out`.
/// Errors: as fk_copy_positions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_copy_velocities(sim: ToLookAt, mut out: Output<f64>, n: u64) -> i32 {
    view(sim, |sim| sim.copy_velocities(array_mut(&mut out, n, "out")?))
}

/// alpha of every segment (M5; 1 whole, 0 failed): `n` = horizontal + vertical (fk_get_grid) numbers, horizontal ones
/// first, row by row, then the vertical ones.
/// Threads: reads. Time: a pass over the sheet. Touches: `out`.
/// Errors: as fk_copy_positions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_copy_damage(sim: ToLookAt, mut out: Output<f64>, n: u64) -> i32 {
    view(sim, |sim| sim.copy_damage(array_mut(&mut out, n, "out")?))
}

/// Stretch of every segment (M1), failed ones too: `n` and order as fk_copy_damage.
/// Threads: reads. Time: a pass over the sheet. Touches: `out`.
/// Errors: as fk_copy_positions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_copy_stretch(sim: ToLookAt, mut out: Output<f64>, n: u64) -> i32 {
    view(sim, |sim| sim.copy_stretch(array_mut(&mut out, n, "out")?))
}

/// Bytes of a snapshot image; constant for a simulation.
/// Threads: reads. Time: constant. Touches: `bytes`.
/// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_state_size(sim: ToLookAt, mut bytes: Output<u64>) -> i32 {
    view(sim, |sim| put_number(&mut bytes, "bytes", sim.snapshot_bytes() as u64))
}

/// Writes the state into `image`, at least fk_state_size bytes long (`bytes` is its length): with a checksum, and
/// portable between machines that run the same version of the library.
/// Threads: reads. Time: a pass over the sheet. Touches: `image`.
/// Errors: FK_NULL_POINTER, FK_SHORT_BUFFER, FK_WRONG_LENGTH (`bytes` is more than memory can have), FK_MOVED_BLOCK, a
/// latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_state_save(sim: ToLookAt, mut image: Output<u8>, bytes: u64) -> i32 {
    view(sim, |sim| sim.save(array_mut(&mut image, bytes, "image")?))
}

/// Puts the simulation into the state of an image of the same scene, bit for bit; clears a failure. `bytes` is what
/// fk_state_size says. On an error nothing has changed.
/// Threads: changes. Time: a few passes over the sheet. Touches: the block.
/// Errors: FK_NULL_POINTER, FK_WRONG_LENGTH (`bytes` is more than memory can have), FK_IMAGE_MALFORMED,
/// FK_IMAGE_OF_ANOTHER_SCENE, FK_IMAGE_INVALID, FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_state_load(sim: ToChange, image: Input<u8>, bytes: u64) -> i32 {
    change_even_failed(sim, |block| block.run(&Call::Load(array(&image, bytes, "image")?)))
}

/// A hash of the whole state: equal digests mean equal bits, on every machine.
/// Threads: reads. Time: a pass over the sheet. Touches: `digest`.
/// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_digest(sim: ToLookAt, mut digest: Output<u64>) -> i32 {
    view(sim, |sim| put_number(&mut digest, "digest", sim.digest()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabric_kernel::fields::FIELDS;

    #[test]
    fn the_header_says_the_kernels_limits() {
        assert_eq!(FK_MAX_BANDS, fabric_kernel::MAX_BANDS);
    }

    #[test]
    fn a_scene_survives_the_round_trip() {
        // Every number another than in the 10 in preset, from which a structure is read.
        let mut scene = Scene::sheet_3in_sphere();
        for (row, field) in FIELDS.iter().enumerate() {
            for element in 0..field.size() {
                let was = field.word(&mut Scene::sheet_10in_cylinder(), element);
                let own = if field.is_real() { (row as f64 + 0.01 * element as f64).to_bits() } else { 1 - was.min(1) };
                field.set_word(&mut scene, element, own).unwrap();
                assert_ne!(field.word(&mut scene, element), was, "{}", field.name);
            }
        }
        for scene in [scene, Scene::sheet_3in_sphere(), Scene::turbine_disc_sector()] {
            let structure = fk_scene::of(scene);
            assert_eq!(structure.words[0] as usize, size_of::<fk_scene>());
            assert_eq!(fk_scene::scene(&structure.words), Ok(scene));
        }
    }

    #[test]
    fn what_an_older_scene_lacks_is_the_default() {
        let mut wanted = Scene::sheet_10in_cylinder();
        (wanted.sheet.nodes_x, wanted.sheet.nodes_y) = (105, 105);
        let words = fk_scene::of(Scene::sheet_3in_sphere()).words;
        assert_eq!(fk_scene::scene(&words[..3]), Ok(wanted));
    }

    /// Output of the hosts, an old one among them, and of the example with threads.
    #[test]
    fn the_digest_of_the_hosts_is_that_of_the_kernel() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
        let mut memory = std::vec![fabric_kernel::CacheLine::ZERO; Layout::of(&scene).unwrap().lines()];
        let mut sim = fabric_kernel::Sim::new(&scene, &mut memory).unwrap();
        sim.advance(3000).unwrap();
        let pin = std::format!("host small {:016x}", sim.digest());
        assert!(include_str!("../../tests/golden/pins").lines().any(|line| line == pin), "{pin}");
    }
}
