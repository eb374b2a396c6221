//! The caller's block: a handle at its start, then the kernel's numbers and integers.
//!
//! Code that trusts the host's handles and lent memory stands here; as in `fabric_host` their types carry its promise.

use core::ffi::c_void;
use core::mem::MaybeUninit;
use fabric_capsule::Call;
use fabric_kernel::Feature;
use fabric_kernel::{Bands, CacheLine, Code, Error, Layout, Scene, Sim};

/// Alignment of the handle and the numbers, bytes, wherever the host's memory starts.
const ALIGN: usize = 64;

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
    /// Step count at which the bands began.
    bands_from: u64,
    #[cfg(feature = "capsule")]
    pub(crate) capsule: Option<fabric_capsule::Log<Window>>,
    pub(crate) sim: Sim<'static>,
}

impl fk_sim {
    /// Takes steps, and writes it if a capsule is written, also if they end in a failure.
    pub(crate) fn advance(&mut self, steps: u64) -> Result<(), Error> {
        let result = self.sim.advance(steps);
        self.note_steps(steps);
        Ok(result?)
    }

    /// Writes steps that were taken.
    #[inline(never)] // It must not add to the stack of the steps.
    pub(crate) fn note_steps(&mut self, steps: u64) {
        self.note(&Call::Advance(steps));
    }

    /// Does another call, and writes it if a capsule is written.
    #[inline(always)] // As Call::apply.
    pub(crate) fn run(&mut self, call: &Call<'_>) -> Result<(), Error> {
        call.apply(&mut self.sim)?;
        self.note(call);
        Ok(())
    }

    #[cfg(feature = "capsule")]
    #[inline(never)] // It must not add to the stack of the call.
    fn note(&mut self, call: &Call<'_>) {
        if let Some(capsule) = &mut self.capsule {
            capsule.note(call, &self.sim);
        }
    }

    #[cfg(not(feature = "capsule"))]
    fn note(&mut self, _: &Call<'_>) {}
}

/// The host's memory for a capsule.
#[cfg(feature = "capsule")]
pub(crate) struct Window {
    start: *mut u8,
    length: usize,
    pub(crate) used: usize,
}

#[cfg(feature = "capsule")]
impl Window {
    /// Memory of so many bytes.
    pub(crate) fn of(memory: Lent, length: u64) -> Result<Window, Error> {
        if memory.is_null() {
            return Err(Error::plain(Code::NullPointer, "memory"));
        }
        let length = usize::try_from(length).ok().filter(|&bytes| bytes <= isize::MAX as usize);
        let length = length.ok_or(Error::plain(Code::WrongLength, "bytes"))?;
        Ok(Window { start: memory.0.cast(), length, used: 0 })
    }
}

#[cfg(feature = "capsule")]
impl fabric_capsule::Sink for Window {
    fn take(&mut self, bytes: &[u8]) -> bool {
        if self.length - self.used < bytes.len() {
            return false;
        }
        // SAFETY: the host lends `length` writable bytes until fk_capsule_end; `used` is at most that, and there is room after it.
        unsafe { core::ptr::copy_nonoverlapping(bytes.as_ptr(), self.start.add(self.used), bytes.len()) };
        self.used += bytes.len();
        true
    }
}

/// Bytes of the handle, rounded up so that the numbers after it are aligned.
const HANDLE_BYTES: usize = size_of::<fk_sim>().next_multiple_of(ALIGN);

/// Bytes of a block for a scene, wherever it starts.
pub(crate) fn bytes(layout: &Layout) -> Result<usize, Error> {
    let too_many = Error::plain(Code::TooManyNodes, "sheet.nodes_x");
    layout.bytes().checked_add(HANDLE_BYTES + ALIGN - 1).filter(|&b| b <= isize::MAX as usize).ok_or(too_many)
}

/// A handle for a call that changes the simulation.
#[repr(transparent)]
pub struct ToChange(*mut fk_sim);

impl ToChange {
    /// A handle as a host would give it.
    ///
    /// # Safety
    /// Null, or readable memory as large as a handle that has been initialised, by [`fk_init`](crate::calls::fk_init) or with
    /// anything else. If that is a handle of fk_init where it was made, its block and the scratch of its bands are still lent, and
    /// nobody else calls the simulation during the call.
    pub const unsafe fn given(handle: *mut fk_sim) -> ToChange {
        ToChange(handle)
    }

    /// Handle for calls that only read.
    fn to_look_at(&self) -> ToLookAt {
        ToLookAt(self.0)
    }
}

/// A handle for a call that only reads the simulation, or that is a band's.
#[repr(transparent)]
pub struct ToLookAt(*const fk_sim);

impl ToLookAt {
    /// A handle as a host would give it.
    ///
    /// # Safety
    /// As for [`ToChange::given`], but others may look at the same simulation, and call its bands, during the call.
    pub const unsafe fn given(handle: *const fk_sim) -> ToLookAt {
        ToLookAt(handle)
    }
}

/// Memory that the host lends beyond the call.
#[repr(transparent)]
pub struct Lent(*mut c_void);

impl Lent {
    /// Memory as a host would give it.
    ///
    /// # Safety
    /// Null, or as many writable bytes as stand beside it, initialised or not, which nobody else uses until the simulation is no
    /// longer called (a block) or `fk_bands_end` (scratch).
    pub const unsafe fn given(start: *mut c_void) -> Lent {
        Lent(start)
    }

    /// Whether there is none.
    pub(crate) fn is_null(&self) -> bool {
        self.0.is_null()
    }

    /// The first place in it that is aligned, if it is there and has the length needed, which counts `ALIGN - 1` bytes before it.
    fn start(self, length: u64, needed: usize, field: &'static str) -> Result<*mut u8, Error> {
        if self.is_null() {
            return Err(Error::plain(Code::NullPointer, field));
        }
        if length < needed as u64 {
            return Err(Error::new(Code::ShortBuffer, field, length as f64, needed as f64));
        }
        let start: *mut u8 = self.0.cast();
        Ok(start.wrapping_add(start.addr().wrapping_neg() % ALIGN))
    }
}

/// Bytes of the block of a scene, and lines of its simulation. Not inlined: the layout must not add to the stack of making it.
#[inline(never)]
pub(crate) fn room(scene: &Scene) -> Result<(usize, usize), Error> {
    let layout = Layout::of(scene)?;
    Ok((bytes(&layout)?, layout.lines()))
}

/// Makes a simulation at the start of a block. On an error nothing has been written.
pub(crate) fn init(memory: Lent, length: u64, scene: &Scene) -> Result<*mut fk_sim, Error> {
    let (bytes, lines) = room(scene)?;
    let memory = memory.start(length, bytes, "memory")?;
    let handle = memory.cast::<fk_sim>();
    // SAFETY: from here on the block has room for the handle and the simulation's lines in this order, both at a multiple of 64 bytes;
    // nothing else uses the block. The host need not have initialised it: any bits are a line, and the kernel reads nothing of one
    // before it has written it. The simulation is made where it stays; then the other fields are written, which drop nothing.
    unsafe {
        let lines = core::slice::from_raw_parts_mut(memory.add(HANDLE_BYTES).cast::<CacheLine>(), lines);
        let place = (&raw mut (*handle).sim).cast::<MaybeUninit<Sim<'static>>>();
        Sim::new_in(&mut *place, scene, lines)?;
        (*handle).magic = MAGIC;
        (*handle).address = memory.addr();
        (*handle).last = None;
        (*handle).bands = core::ptr::null_mut();
        #[cfg(feature = "capsule")]
        (&raw mut (*handle).capsule).write(None);
    }
    Ok(handle)
}

/// Block of a handle.
pub(crate) fn open(handle: &mut ToChange) -> Result<&mut fk_sim, Error> {
    without_bands(&handle.to_look_at())?;
    // SAFETY: found to be an initialised handle at its own address, which no bands have; the host lets nobody else use it.
    Ok(unsafe { &mut *handle.0 })
}

/// Block of a handle, for calls that only read.
pub(crate) fn look(handle: &ToLookAt) -> Result<&fk_sim, Error> {
    without_bands(handle)?;
    // SAFETY: found to be an initialised handle at its own address, which no bands have; the host lets nobody change it.
    Ok(unsafe { &*handle.0 })
}

/// The bands that have a simulation. Bands of one simulation may be looked at by several threads at once.
pub(crate) fn bands(handle: &ToLookAt) -> Result<&Bands<'static, 'static>, Error> {
    let bands = bands_of(handle)?;
    // SAFETY: null, or set by begin() to bands in the scratch, which the host lends until end().
    unsafe { bands.as_ref() }.ok_or(Error::plain(Code::BandOutOfTurn, "bands"))
}

/// Bytes of scratch for `of` bands, wherever it starts: the bands, then their numbers.
///
/// # Errors
/// A number of bands, or an integrator, that a sheet cannot be cut for; more memory than there can be.
pub(crate) fn bands_bytes(layout: &Layout, of: u32) -> Result<usize, Error> {
    // No more than a slice can hold, so that the product is right and only the sum may be too large.
    let lines = size_of::<CacheLine>() * layout.band_lines(of)?;
    let bytes = lines.checked_add(BANDS_BYTES + ALIGN - 1).filter(|&bytes| bytes <= isize::MAX as usize);
    bytes.ok_or(Error::plain(Code::TooManyNodes, "of"))
}

/// Bytes of the bands themselves, rounded up so that the numbers after them are aligned.
const BANDS_BYTES: usize = size_of::<Bands<'static, 'static>>().next_multiple_of(ALIGN);

/// Hands the simulation to `of` bands.
pub(crate) fn begin(handle: ToChange, of: u32, steps: u64, scratch: Lent, length: u64) -> Result<(), Error> {
    without_bands(&handle.to_look_at())?;
    let handle = handle.0;
    // SAFETY: found to be an initialised handle at its own address, which no bands have; the host lets nobody else use it. The
    // fields are reached one by one, since the bands keep the simulation.
    let sim: &'static mut Sim<'static> = unsafe { &mut (*handle).sim };
    let (lines, from) = (sim.layout().band_lines(of)?, sim.step_count());
    let scratch = scratch.start(length, bands_bytes(sim.layout(), of)?, "scratch")?;
    let place = scratch.cast::<Bands<'static, 'static>>();
    // SAFETY: from here on the scratch has room for the bands and their lines in this order, both aligned; nothing else uses it until
    // end(); the host need not have initialised it, but any bits are a line, and the bands read nothing of one before they have written
    // it. The handle as above.
    unsafe {
        let lines = core::slice::from_raw_parts_mut(scratch.add(BANDS_BYTES).cast::<CacheLine>(), lines);
        // No `?`: it would take another copy of the bands on the stack.
        match sim.bands(lines, of, steps) {
            Ok(bands) => place.write(bands),
            Err(error) => return Err(error),
        }
        ((*handle).bands, (*handle).bands_from) = (place, from);
    }
    Ok(())
}

/// Takes the simulation back; a step, or a block of steps, that is begun is completed.
pub(crate) fn end(handle: &mut ToChange) -> Result<&mut fk_sim, Error> {
    let bands = bands_of(&handle.to_look_at())?;
    if bands.is_null() {
        return Err(Error::plain(Code::BandOutOfTurn, "bands"));
    }
    // SAFETY: begin() has set them; the host has no call use them any more.
    unsafe {
        bands.drop_in_place();
        (*handle.0).bands = core::ptr::null_mut();
    }
    let block = open(handle)?;
    let failed = u64::from(block.sim.failure().is_some());
    block.note_steps(block.sim.step_count() - block.bands_from + failed);
    Ok(block)
}

/// An initialised handle that no bands have.
fn without_bands(handle: &ToLookAt) -> Result<(), Error> {
    if bands_of(handle)?.is_null() { Ok(()) } else { Err(Error::plain(Code::BandOutOfTurn, "bands")) }
}

/// The bands that have the simulation of an initialised handle, or null. Makes no reference to the block.
fn bands_of(handle: &ToLookAt) -> Result<*mut Bands<'static, 'static>, Error> {
    let handle = handle.0;
    if handle.is_null() {
        return Err(Error::plain(Code::NullPointer, "sim"));
    }
    if !handle.addr().is_multiple_of(ALIGN) {
        return Err(Error::plain(Code::MovedBlock, "sim"));
    }
    // SAFETY: not null and aligned; the host vouches for a handle of fk_init, or for memory of this size that it has initialised.
    // All fields read are plain integers and pointers, valid whatever they hold.
    let (magic, address, bands) = unsafe { ((*handle).magic, (*handle).address, (*handle).bands) };
    // Without bands in the build the compiler leaves out what they do.
    let bands = if Feature::Bands.is_built() { bands } else { core::ptr::null_mut() };
    if magic == MAGIC && address == handle.addr() { Ok(bands) } else { Err(Error::plain(Code::MovedBlock, "sim")) }
}
