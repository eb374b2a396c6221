//! What every exported function does first: check the instance, its phase and the host's arrays, and set the floating-point
//! environment.

use crate::float::in_our_environment;
use crate::instance::{Instance, MOST_ELEMENTS};
use crate::log::{Line, Log, Status};
use crate::memory;
use crate::table::{Kind, TIME_REFERENCE, TOKEN, Variable};
use core::ffi::{CStr, c_char};
use core::fmt::Write;
use core::ptr::{self, NonNull};

/// Version of the interface, where the two differ.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// A value reference means an element.
    Two,
    /// A value reference means a whole array.
    Three,
}

/// Runs `work` on an instance if it is in one of `phases`.
///
/// # Safety
/// `instance` is null or came from [`create`] and was not freed; no other call on it is under way.
pub unsafe fn enter(
    instance: *mut Instance,
    function: &str,
    phases: u32,
    work: impl FnOnce(&mut Instance) -> Status,
) -> Status {
    // SAFETY: the caller's promise.
    let Some(instance) = (unsafe { instance.as_mut() }) else { return Status::Error };
    if instance.kept.phase as u32 & phases == 0 {
        let mut line = Line::new();
        let _ = write!(line, "{function}: not allowed in this state");
        return instance.refuse(&line);
    }
    in_our_environment(|| work(instance))
}

/// A new instance if the token is that of this build; null otherwise.
///
/// # Safety
/// Texts are null or end with a zero.
pub unsafe fn create(log: Log, name: *const c_char, token: *const c_char) -> *mut Instance {
    // SAFETY: the caller's promise.
    let (name, token) = unsafe { (text(name), text(token)) };
    if name.is_none_or(|name| name.to_bytes().iter().all(u8::is_ascii_whitespace)) {
        log.say(crate::log::Category::Error, "instanceName: missing");
        return ptr::null_mut();
    }
    if token.is_none_or(|token| token.to_bytes() != TOKEN) {
        log.say(crate::log::Category::Error, "token: the model description and the library are of different builds");
        return ptr::null_mut();
    }
    let Some(place) = memory::allocate::<Instance>(0) else {
        log.say(crate::log::Category::Fatal, "out of memory");
        return ptr::null_mut();
    };
    // SAFETY: a fresh block of the right size and alignment.
    unsafe { place.write(Instance::new(log)) };
    place.as_ptr()
}

/// Frees an instance with everything it holds.
///
/// # Safety
/// As for [`enter`]; the pointer is not used again.
pub unsafe fn destroy(instance: *mut Instance) {
    if let Some(place) = NonNull::new(instance) {
        // SAFETY: made by `create`, dropped once.
        unsafe {
            place.drop_in_place();
            memory::release(place);
        }
    }
}

/// A text of the host's; None for null.
///
/// # Safety
/// Null or ends with a zero, and lives as long as it is used.
pub unsafe fn text<'a>(text: *const c_char) -> Option<&'a CStr> {
    // SAFETY: the caller's promise.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) })
}

/// An array of the host's; None for null with a length.
///
/// # Safety
/// Null or holds `count` elements, and lives as long as it is used.
pub unsafe fn array<'a, T>(start: *const T, count: usize) -> Option<&'a [T]> {
    if count == 0 {
        return Some(&[]);
    }
    // SAFETY: the caller's promise; a length that no array can have is refused.
    (!start.is_null() && count <= LONGEST).then(|| unsafe { core::slice::from_raw_parts(start, count) })
}

/// An array of the host's to write into; None for null with a length.
///
/// # Safety
/// As for [`array()`], and nothing else refers to it.
pub unsafe fn array_mut<'a, T>(start: *mut T, count: usize) -> Option<&'a mut [T]> {
    if count == 0 {
        return Some(&mut []);
    }
    // SAFETY: as above.
    (!start.is_null() && count <= LONGEST).then(|| unsafe { core::slice::from_raw_parts_mut(start, count) })
}

const LONGEST: usize = isize::MAX as usize / 16;

/// Writes one value if the host gave a place for it.
///
/// # Safety
/// Null or points to a `T`.
pub unsafe fn put<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: the caller's promise.
        unsafe { place.write(value) };
    }
}

/// Whether a variable of the table is read and written through functions for `kind`. Choices go with integers in FMI 2.0 and
/// by themselves in FMI 3.0.
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
        Version::Two => crate::table::element(reference).map(|(variable, element)| (variable, element, 1))?,
        Version::Three => crate::table::whole(reference).map(|variable| (variable, 0, variable.size()))?,
    };
    fits(version, variable, kind).then_some((variable, first, count))
}

fn refuse_reference(instance: &Instance, reference: u32) -> Status {
    let mut line = Line::new();
    let _ = write!(line, "value reference {reference}: unknown, or of another type");
    instance.refuse(&line)
}

/// Reads variables one after the other into `values`.
pub fn get<T: Default>(
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
pub fn set<T: Copy>(
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
pub fn to_integer(value: f64) -> i32 {
    value as i32
}
