//! Calls from C: the host's instance, texts and arrays, and the functions of states, which both versions of
//! the interface have alike.

use crate::instance::Instance;
use crate::kept::Phase;
use crate::log::Status;
use crate::memory::Owned;
use core::ffi::{CStr, c_char};
use core::ptr::NonNull;
use fabric_host::{Input, Output};

/// An instance as its host names it, for one call: to C a plain pointer. The host vouches for it as for an
/// [`Input`]: null, or what an instantiating function gave it and it has not freed; no other call on that
/// instance is under way.
#[repr(transparent)]
pub struct Handle(*mut Instance);

impl Handle {
    /// An instance as a host would name it.
    ///
    /// # Safety
    /// The promise above; nothing else refers to the instance as long as the handle is used.
    pub const unsafe fn given(instance: *mut Instance) -> Handle {
        Handle(instance)
    }
}

/// A text of the host's: null, or ended by a zero.
#[repr(transparent)]
pub struct Text(*const c_char);

impl Text {
    /// A text as a host would give it.
    ///
    /// # Safety
    /// Null or ends with a zero, and unchanged as long as it is used.
    pub const unsafe fn given(start: *const c_char) -> Text {
        Text(start)
    }

    /// The text; None for null.
    pub(crate) fn get(&self) -> Option<&CStr> {
        // SAFETY: not null; the host vouches for the rest.
        (!self.0.is_null()).then(|| unsafe { CStr::from_ptr(self.0) })
    }
}

/// Runs `work` on an instance if it is in one of `phases`.
pub(crate) fn enter(handle: Handle, function: &str, phases: u32, work: impl FnOnce(&mut Instance) -> Status) -> Status {
    pass(handle, |instance| instance.within(function, phases, work))
}

/// Runs `work`, which checks itself whether the state allows the call.
pub(crate) fn pass(handle: Handle, work: impl FnOnce(&mut Instance) -> Status) -> Status {
    // SAFETY: null, or live and used by nobody else, as the host vouches.
    unsafe { handle.0.as_mut() }.map_or(Status::Error, work)
}

/// Frees an instance with everything it holds.
pub(crate) fn destroy(handle: Handle) {
    if let Some(place) = NonNull::new(handle.0) {
        // SAFETY: made by `create`, which puts nothing after it; the host vouches that it has not freed it,
        // and for not using it again.
        drop(unsafe { Owned::from_pointer(place) });
    }
}

/// Array of the host's; None for null with a length.
pub(crate) fn array<T>(start: &Input<T>, count: usize) -> Option<&[T]> {
    if count == 0 { Some(&[]) } else { start.elements(count) }
}

/// Array of the host's to write into; None for null with a length.
pub(crate) fn array_mut<T>(start: &mut Output<T>, count: usize) -> Option<&mut [T]> {
    if count == 0 { Some(&mut []) } else { start.elements(count) }
}

/// Work of a function of states: they are allowed in every phase, so that no refusal names them.
pub(crate) fn state(handle: Handle, work: impl FnOnce(&mut Instance) -> Result<(), Status>) -> Status {
    enter(handle, "FMU state", Phase::ANY, |instance| work(instance).err().unwrap_or(Status::Ok))
}

/// C functions of states, by their names in a version of the interface.
macro_rules! functions_of_states {
    ($get:ident $set:ident $free:ident $size:ident $serialize:ident $deserialize:ident) => {
        /// Copies the state; a state given by the host is used again.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(instance: Handle, mut state: Output<*mut Saved>) -> Status {
            calls::state(instance, |instance| {
                let Some([state]) = state.elements(1) else { return Err(instance.refuse("null pointer")) };
                *state = instance.save(*state)?;
                Ok(())
            })
        }

        /// Restores a state.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(instance: Handle, state: *mut Saved) -> Status {
            calls::state(instance, |instance| instance.restore(state))
        }

        /// Frees a state and clears the host's pointer.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free(instance: Handle, mut state: Output<*mut Saved>) -> Status {
            calls::state(instance, |instance| {
                if state.pointer().is_null() {
                    return Ok(());
                }
                let Some([state]) = state.elements(1) else { return Err(instance.refuse("misaligned pointer")) };
                instance.free(*state)?;
                *state = core::ptr::null_mut();
                Ok(())
            })
        }

        /// Bytes of a state.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $size(instance: Handle, state: *mut Saved, mut size: Output<usize>) -> Status {
            calls::state(instance, |instance| {
                let bytes = instance.serialized_size(state)?;
                if size.put(bytes) { Ok(()) } else { Err(instance.refuse("null pointer")) }
            })
        }

        /// Writes a state into bytes.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $serialize(
            instance: Handle,
            state: *mut Saved,
            mut bytes: Output<u8>,
            size: usize,
        ) -> Status {
            calls::state(instance, |instance| match array_mut(&mut bytes, size) {
                Some(bytes) => instance.serialize(state, bytes),
                None => Err(instance.refuse("null array")),
            })
        }

        /// Makes a state from bytes.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $deserialize(
            instance: Handle,
            bytes: Input<u8>,
            size: usize,
            mut state: Output<*mut Saved>,
        ) -> Status {
            calls::state(instance, |instance| {
                let Some(bytes) = array(&bytes, size).filter(|_| !state.pointer().is_null()) else {
                    return Err(instance.refuse("null pointer"));
                };
                state.put(instance.deserialize(bytes)?);
                Ok(())
            })
        }
    };
}
pub(crate) use functions_of_states;
