//! The caller's block: a handle at its start, then the kernel's numbers and integers.

use core::mem::MaybeUninit;
use fabric::{Bands, Code, Error, Layout, Memory, Scene, Sim};

/// Alignment of a block, bytes; C asks for it with fk_memory_size.
pub(crate) const ALIGN: usize = 64;

/// "FKSIMBLK": tells an initialised block from any other memory.
const MAGIC: u64 = u64::from_le_bytes(*b"FKSIMBLK");

/// A simulation in its block. C knows only that it exists.
#[allow(non_camel_case_types)]
pub struct fk_sim {
    magic: u64,
    /// Where the block was initialised: the slices in `sim` point into it, so it must not move.
    address: usize,
    /// The last refused or failed call that changes the simulation, for fk_get_fault.
    pub(crate) last: Option<Error>,
    /// The bands that have the simulation, in the caller's scratch; null if none have. While it is set `sim` and `last` are
    /// reached through nothing else.
    bands: *mut Bands<'static, 'static>,
    pub(crate) sim: Sim<'static>,
}

/// Bytes of the handle, rounded up so that the numbers behind it are aligned.
const HANDLE_BYTES: usize = size_of::<fk_sim>().next_multiple_of(ALIGN);

/// Bytes of a block for a scene.
pub fn bytes(layout: &Layout) -> Result<usize, Error> {
    let too_many = Error::plain(Code::TooManyNodes, "sheet.nodes_x");
    let numbers = layout.reals().checked_mul(8).and_then(|b| b.checked_add(layout.words().checked_mul(4)?));
    numbers.and_then(|b| b.checked_add(HANDLE_BYTES)).filter(|&b| b <= isize::MAX as usize).ok_or(too_many)
}

/// Makes a simulation at the start of a block. On an error nothing has been written.
///
/// # Safety
/// `memory` points to `length` writable bytes that nothing else uses until the simulation is no longer called.
pub unsafe fn init(memory: *mut u8, length: u64, scene: &Scene) -> Result<*mut fk_sim, Error> {
    let layout = Layout::of(scene)?;
    let needed = bytes(&layout)?;
    if length < needed as u64 {
        return Err(Error::new(Code::ShortBuffer, "memory", length as f64, needed as f64));
    }
    if !memory.addr().is_multiple_of(ALIGN) {
        return Err(Error::new(Code::Misaligned, "memory", (memory.addr() % ALIGN) as f64, ALIGN as f64));
    }
    // SAFETY: the block has room for handle, numbers and integers in this order; the numbers start at a multiple of 64 bytes,
    // the integers at a multiple of 8; nothing else uses the block; every bit pattern is a valid f64 or u32.
    let (reals, words) = unsafe {
        let reals = memory.add(HANDLE_BYTES).cast::<f64>();
        let words = reals.add(layout.reals()).cast::<u32>();
        (core::slice::from_raw_parts_mut(reals, layout.reals()), core::slice::from_raw_parts_mut(words, layout.words()))
    };
    let handle = memory.cast::<fk_sim>();
    // SAFETY: the start of the block is aligned for the handle and has room for it. The simulation is made where it stays; then
    // the other fields are written, which drop nothing.
    unsafe {
        let place = (&raw mut (*handle).sim).cast::<MaybeUninit<Sim<'static>>>();
        Sim::new_in(&mut *place, scene, Memory { reals, words })?;
        (*handle).magic = MAGIC;
        (*handle).address = memory.addr();
        (*handle).last = None;
        (*handle).bands = core::ptr::null_mut();
    }
    Ok(handle)
}

/// The block behind a handle.
///
/// # Safety
/// `handle` is null, or points to a readable block at least as large as a handle that no other call is using.
pub unsafe fn open<'h>(handle: *mut fk_sim) -> Result<&'h mut fk_sim, Error> {
    without_bands(handle)?;
    // SAFETY: found to be an initialised handle at its own address, which no bands have.
    Ok(unsafe { &mut *handle })
}

/// The block behind a handle, to be looked at.
///
/// # Safety
/// As for [`open`].
pub unsafe fn look<'h>(handle: *const fk_sim) -> Result<&'h fk_sim, Error> {
    without_bands(handle)?;
    // SAFETY: found to be an initialised handle at its own address, which no bands have.
    Ok(unsafe { &*handle })
}

/// The bands that have a simulation. Bands of one simulation may be looked at by several threads at once.
///
/// # Safety
/// As for [`open`], but for other calls of the bands.
pub unsafe fn bands<'h>(handle: *const fk_sim) -> Result<&'h Bands<'static, 'static>, Error> {
    let bands = bands_of(handle)?;
    // SAFETY: null, or set by begin() to bands in the caller's scratch, which stays until end().
    unsafe { bands.as_ref() }.ok_or(Error::plain(Code::BandOutOfTurn, "bands"))
}

/// Bytes of scratch for `of` bands: the bands, then their numbers.
///
/// # Errors
/// A number of bands, or an integrator, that a sheet cannot be cut for.
pub fn bands_bytes(layout: &Layout, of: u32) -> Result<usize, Error> {
    // Far less than the rows themselves, which have been found to fit.
    Ok(BANDS_BYTES + 8 * layout.band_reals(of)?)
}

/// Bytes of the bands themselves, rounded up so that the numbers behind them are aligned.
const BANDS_BYTES: usize = size_of::<Bands<'static, 'static>>().next_multiple_of(ALIGN);

/// Hands the simulation to `of` bands.
///
/// # Safety
/// As for [`open`]; `scratch` points to `length` writable bytes that nothing else uses until [`end`].
pub unsafe fn begin(handle: *mut fk_sim, of: u32, scratch: *mut u8, length: u64) -> Result<(), Error> {
    without_bands(handle)?;
    // SAFETY: the caller's promise; the fields are reached one by one, since the bands keep the simulation.
    let sim: &'static mut Sim<'static> = unsafe { &mut (*handle).sim };
    let needed = bands_bytes(sim.layout(), of)?;
    if scratch.is_null() {
        return Err(Error::plain(Code::NullPointer, "scratch"));
    }
    if length < needed as u64 {
        return Err(Error::new(Code::ShortBuffer, "scratch", length as f64, needed as f64));
    }
    if !scratch.addr().is_multiple_of(ALIGN) {
        return Err(Error::new(Code::Misaligned, "scratch", (scratch.addr() % ALIGN) as f64, ALIGN as f64));
    }
    let count = (needed - BANDS_BYTES) / 8;
    // SAFETY: the scratch has room for the bands and the numbers in this order, both aligned; nothing else uses it; every bit
    // pattern is a valid f64.
    let numbers = unsafe { core::slice::from_raw_parts_mut(scratch.add(BANDS_BYTES).cast::<f64>(), count) };
    let place = scratch.cast::<Bands<'static, 'static>>();
    // No `?`: it would take another copy of the bands on the stack.
    match sim.bands(numbers, of) {
        // SAFETY: as above; the handle's field is the caller's to change.
        Ok(bands) => unsafe {
            place.write(bands);
            (*handle).bands = place;
        },
        Err(error) => return Err(error),
    }
    Ok(())
}

/// Takes the simulation back; a step that only some bands have taken is completed.
///
/// # Safety
/// As for [`open`].
pub unsafe fn end<'h>(handle: *mut fk_sim) -> Result<&'h mut fk_sim, Error> {
    let bands = bands_of(handle)?;
    if bands.is_null() {
        return Err(Error::plain(Code::BandOutOfTurn, "bands"));
    }
    // SAFETY: begin() has set them; no call is using them any more.
    unsafe {
        bands.drop_in_place();
        (*handle).bands = core::ptr::null_mut();
        open(handle)
    }
}

/// An initialised handle that no bands have.
fn without_bands(handle: *const fk_sim) -> Result<(), Error> {
    if bands_of(handle)?.is_null() { Ok(()) } else { Err(Error::plain(Code::BandOutOfTurn, "bands")) }
}

/// The bands that have the simulation of an initialised handle, or null. Makes no reference to the block.
fn bands_of(handle: *const fk_sim) -> Result<*mut Bands<'static, 'static>, Error> {
    if handle.is_null() {
        return Err(Error::plain(Code::NullPointer, "sim"));
    }
    if !handle.addr().is_multiple_of(ALIGN) {
        return Err(Error::plain(Code::MovedBlock, "sim"));
    }
    // SAFETY: not null and aligned; the caller vouches for the memory. All fields read are plain integers and pointers, valid
    // whatever they hold.
    let (magic, address, bands) = unsafe { ((*handle).magic, (*handle).address, (*handle).bands) };
    if magic == MAGIC && address == handle.addr() { Ok(bands) } else { Err(Error::plain(Code::MovedBlock, "sim")) }
}
