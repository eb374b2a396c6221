//! What every exported function does first: check the instance, its phase and the host's arrays, and set the
//! floating-point environment.

use crate::instance::Instance;
use crate::kept::Phase;
use crate::kept::Saved;
use crate::log::{Category, Log, Status, line};
use crate::memory::Owned;
use crate::starts::Starts;
use crate::table::{self, Kind, MOST_ELEMENTS, TIME_REFERENCE, Variable};
use crate::token;
use core::ffi::{CStr, c_char};
use core::ptr::{self, NonNull};
use fabric_host::{Input, Output, in_our_environment};

/// Version of the interface, where the two differ.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Version {
    /// A value reference means an element.
    Two,
    /// A value reference means a whole array.
    Three,
}

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

    fn instance(&mut self) -> Option<&mut Instance> {
        // SAFETY: null, or live and used by nobody else, as the host vouches.
        unsafe { self.0.as_mut() }
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
pub(crate) fn enter(
    mut handle: Handle,
    function: &str,
    phases: u32,
    work: impl FnOnce(&mut Instance) -> Status,
) -> Status {
    let Some(instance) = handle.instance() else { return Status::Error };
    within(instance, function, phases, work)
}

/// The same for an instance that is there.
pub(crate) fn within(
    instance: &mut Instance,
    function: &str,
    phases: u32,
    work: impl FnOnce(&mut Instance) -> Status,
) -> Status {
    match check(instance, function, phases) {
        Ok(()) => in_our_environment(|| work(instance)),
        Err(refused) => refused,
    }
}

/// Refuses a call if the instance is in none of `phases`.
pub(crate) fn check(instance: &Instance, function: &str, phases: u32) -> Result<(), Status> {
    if instance.kept.phase as u32 & phases != 0 {
        return Ok(());
    }
    Err(instance.refuse(&line(format_args!("{function}: not allowed in this state"))))
}

/// Runs `work`, which looks itself whether the state allows the call.
pub(crate) fn pass(mut handle: Handle, work: impl FnOnce(&mut Instance) -> Status) -> Status {
    handle.instance().map_or(Status::Error, work)
}

/// A new instance if the token is that of this build.
pub(crate) fn create(log: Log, name: Option<&CStr>, token: Option<&CStr>) -> Option<Owned<Instance>> {
    if name.is_none_or(|name| name.to_bytes().iter().all(u8::is_ascii_whitespace)) {
        log.say(Category::Error, "instanceName: missing");
        return None;
    }
    let starts = match Starts::read() {
        Ok(starts) => starts,
        Err(reason) => {
            log.say(Category::Error, reason);
            return None;
        }
    };
    if token.is_none_or(|token| token.to_bytes() != token::text(starts.token)) {
        log.say(Category::Error, "token: the model description and the library are of different builds");
        return None;
    }
    let place = Owned::new(Instance::new(log.clone()), 0);
    if place.is_none() {
        log.say(Category::Fatal, "out of memory");
    }
    place
}

/// Frees an instance with everything it holds.
pub(crate) fn destroy(handle: Handle) {
    if let Some(place) = NonNull::new(handle.0) {
        // SAFETY: made by `create`, which puts nothing behind it; the host vouches that it has not freed it,
        // and for not using it again.
        drop(unsafe { Owned::from_pointer(place) });
    }
}

/// The function's name in refusals for the phase. The six below are allowed in every phase, so that it is
/// never told.
const STATES: &str = "FMU state";

/// Copies the state; a state given by the host is used again.
pub(crate) fn get_state(handle: Handle, mut state: Output<*mut Saved>) -> Status {
    enter(handle, STATES, Phase::ANY, |instance| {
        let Some([state]) = state.elements(1) else { return instance.refuse("null pointer") };
        match instance.save(*state) {
            Ok(saved) => {
                *state = saved;
                Status::Ok
            }
            Err(status) => status,
        }
    })
}

/// Restores a state.
pub(crate) fn set_state(handle: Handle, state: *mut Saved) -> Status {
    enter(handle, STATES, Phase::ANY, |instance| instance.restore(state))
}

/// Frees a state and clears the host's pointer.
pub(crate) fn free_state(handle: Handle, mut state: Output<*mut Saved>) -> Status {
    enter(handle, STATES, Phase::ANY, |instance| {
        if state.pointer().is_null() {
            return Status::Ok;
        }
        let Some([state]) = state.elements(1) else { return instance.refuse("misaligned pointer") };
        let status = instance.free(*state);
        if status == Status::Ok {
            *state = ptr::null_mut();
        }
        status
    })
}

/// Bytes of a state.
pub(crate) fn serialized_size(handle: Handle, state: *mut Saved, mut size: Output<usize>) -> Status {
    enter(handle, STATES, Phase::ANY, |instance| match instance.serialized_size(state) {
        Ok(bytes) if size.put(bytes) => Status::Ok,
        Ok(_) => instance.refuse("null pointer"),
        Err(status) => status,
    })
}

/// Writes a state into bytes.
pub(crate) fn serialize(handle: Handle, state: *mut Saved, mut bytes: Output<u8>, size: usize) -> Status {
    enter(handle, STATES, Phase::ANY, |instance| match array_mut(&mut bytes, size) {
        Some(bytes) => instance.serialize(state, bytes),
        None => instance.refuse("null array"),
    })
}

/// Makes a state from bytes.
pub(crate) fn deserialize(handle: Handle, bytes: Input<u8>, size: usize, mut state: Output<*mut Saved>) -> Status {
    enter(handle, STATES, Phase::ANY, |instance| {
        let Some(bytes) = array(&bytes, size).filter(|_| !state.pointer().is_null()) else {
            return instance.refuse("null pointer");
        };
        match instance.deserialize(bytes) {
            Ok(saved) => {
                state.put(saved);
                Status::Ok
            }
            Err(status) => status,
        }
    })
}

/// For functions of a type that no variable has: reading or writing none is fine, any is not.
pub(crate) fn none_of_this_type(instance: &mut Instance, function: &str, phases: u32, count: usize) -> Status {
    if count == 0 { within(instance, function, phases, |_| Status::Ok) } else { unsupported(instance, function) }
}

/// For functions that are not provided.
pub fn unsupported(instance: &mut Instance, function: &str) -> Status {
    instance.refuse(&line(format_args!("{function}: not supported")))
}

/// For a status of FMI 2.0 that there is not: Discard, as its section 4.2.3 asks; nothing has changed.
pub(crate) fn no_status(instance: &mut Instance, function: &str) -> Status {
    within(instance, function, Phase::AFTER_SETTING_UP, |instance| instance.no_status(function))
}

/// An array of the host's; None for null with a length.
pub(crate) fn array<T>(start: &Input<T>, count: usize) -> Option<&[T]> {
    if count == 0 { Some(&[]) } else { start.elements(count) }
}

/// An array of the host's to write into; None for null with a length.
pub(crate) fn array_mut<T>(start: &mut Output<T>, count: usize) -> Option<&mut [T]> {
    if count == 0 { Some(&mut []) } else { start.elements(count) }
}

/// Whether a variable of the table is read and written through functions for `kind`. Choices go with integers
/// in FMI 2.0 and by themselves in FMI 3.0.
fn fits(version: Version, variable: &Variable, kind: Kind) -> bool {
    match (variable.kind, kind) {
        (Kind::Choice(_), Kind::Choice(_)) => true,
        (Kind::Choice(_), Kind::Integer) => version == Version::Two,
        (own, asked) => own == asked,
    }
}

/// The variable a reference means and which of its elements: first and count.
fn find(version: Version, reference: u32, kind: Kind) -> Option<(&'static Variable, usize, usize)> {
    let (variable, first, count) = match version {
        Version::Two => table::element(reference).map(|(variable, element)| (variable, element, 1))?,
        Version::Three => table::whole(reference).map(|variable| (variable, 0, variable.size()))?,
    };
    fits(version, variable, kind).then_some((variable, first, count))
}

fn refuse_reference(instance: &Instance, reference: u32) -> Status {
    instance.refuse(&line(format_args!("value reference {reference}: unknown, or of another type")))
}

/// Reads variables one after the other into `values`.
pub(crate) fn get<T: Default>(
    instance: &mut Instance,
    version: Version,
    kind: Kind,
    references: Option<&[u32]>,
    values: Option<&mut [T]>,
    convert: impl Fn(f64) -> T,
) -> Status {
    let (Some(references), Some(values)) = (references, values) else { return instance.refuse("null array") };
    let mut places = values.iter_mut();
    for &reference in references {
        let mut numbers = [0.0; MOST_ELEMENTS];
        let (first, count) = if reference == TIME_REFERENCE && version == Version::Three && kind == Kind::Real {
            numbers[0] = instance.kept.time;
            (0, 1)
        } else {
            let Some((variable, first, count)) = find(version, reference, kind) else {
                return refuse_reference(instance, reference);
            };
            let status = instance.get(variable, &mut numbers);
            if status != Status::Ok {
                return status;
            }
            (first, count)
        };
        for number in numbers.iter().skip(first).take(count) {
            let Some(place) = places.next() else { return instance.refuse("array of values too short") };
            *place = convert(*number);
        }
    }
    if places.next().is_some() {
        return instance.refuse("array of values too long");
    }
    Status::Ok
}

/// Sets variables from `values`, all or none.
pub(crate) fn set<T: Copy>(
    instance: &mut Instance,
    version: Version,
    kind: Kind,
    references: Option<&[u32]>,
    values: Option<&[T]>,
    convert: impl Fn(T) -> f64,
) -> Status {
    let (Some(references), Some(values)) = (references, values) else { return instance.refuse("null array") };
    for apply in [false, true] {
        let mut given = values.iter();
        for &reference in references {
            let Some((variable, first, count)) = find(version, reference, kind) else {
                return refuse_reference(instance, reference);
            };
            for element in first..first + count {
                let Some(&value) = given.next() else { return instance.refuse("array of values too short") };
                let value = convert(value);
                if apply {
                    instance.set(variable, element, value);
                } else {
                    let status = instance.may_set(variable, value);
                    if status != Status::Ok {
                        return status;
                    }
                }
            }
        }
        if given.next().is_some() {
            return instance.refuse("array of values too long");
        }
    }
    Status::Ok
}

/// A count as an Integer; what does not fit is cut off at the ends.
pub(crate) fn to_integer(value: f64) -> i32 {
    value as i32
}
