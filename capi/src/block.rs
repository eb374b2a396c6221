//! The caller's block: a handle at its start, then the kernel's numbers and integers.

use fabric::{Code, Error, Layout, Memory, Scene, Sim};

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
    let sim = Sim::new(scene, Memory { reals, words })?;
    let handle = memory.cast::<fk_sim>();
    // SAFETY: the start of the block is aligned for the handle and has room for it.
    unsafe { handle.write(fk_sim { magic: MAGIC, address: memory.addr(), last: None, sim }) };
    Ok(handle)
}

/// The block behind a handle.
///
/// # Safety
/// `handle` is null, or points to a readable block at least as large as a handle that no other call is using.
pub unsafe fn open<'h>(handle: *mut fk_sim) -> Result<&'h mut fk_sim, Error> {
    check(handle)?;
    // SAFETY: check() found an initialised handle at its own address.
    Ok(unsafe { &mut *handle })
}

/// The block behind a handle, to be looked at.
///
/// # Safety
/// As for [`open`].
pub unsafe fn look<'h>(handle: *const fk_sim) -> Result<&'h fk_sim, Error> {
    check(handle)?;
    // SAFETY: check() found an initialised handle at its own address.
    Ok(unsafe { &*handle })
}

fn check(handle: *const fk_sim) -> Result<(), Error> {
    if handle.is_null() {
        return Err(Error::plain(Code::NullPointer, "sim"));
    }
    if !handle.addr().is_multiple_of(ALIGN) {
        return Err(Error::plain(Code::MovedBlock, "sim"));
    }
    // SAFETY: not null and aligned; the caller vouches for the memory. Both fields are plain integers, valid whatever they hold.
    let (magic, address) = unsafe { ((*handle).magic, (*handle).address) };
    if magic == MAGIC && address == handle.addr() { Ok(()) } else { Err(Error::plain(Code::MovedBlock, "sim")) }
}
