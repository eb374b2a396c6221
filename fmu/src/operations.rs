//! Operations that a host may ask of an instance: name in refusals, phases that allow it, and work. The C
//! functions of FMI 2.0 and 3.0 and the component for WebAssembly call them.
#![allow(non_snake_case)] // the standard's names

use crate::instance::{Early, Instance, StepEnd};
use crate::kept::Phase;
use crate::log::{Category, Log, Status, line};
use crate::memory::Owned;
use crate::starts::Starts;
use crate::table::{self, Kind, MOST_ELEMENTS, STATUS, TIME_REFERENCE, Variable};
use crate::token;
use core::ffi::{CStr, c_int};
use fabric_host::in_our_environment;

/// Operations of an instance alone: each row is a function here, and a C function of that name.
macro_rules! operations {
    ($($(#[$about:meta])* $name:ident, $phases:expr, $work:expr;)*) => {
        $(
            $(#[$about])*
            pub fn $name(instance: &mut Instance) -> Status {
                instance.within(stringify!($name), $phases, $work)
            }
        )*

        /// C functions of the instance alone. The instance is as [`Handle::given`] asks, still.
        ///
        /// [`Handle::given`]: crate::calls::Handle::given
        #[cfg(not(target_family = "wasm"))]
        #[allow(clippy::missing_safety_doc)] // said once, above
        pub mod exported {
            use crate::calls::{Handle, pass};
            use crate::log::Status;

            $(
                $(#[$about])*
                #[unsafe(no_mangle)]
                pub unsafe extern "C" fn $name(instance: Handle) -> Status {
                    pass(instance, super::$name)
                }
            )*
        }
    };
}

operations! {
    /// Begins initialisation.
    fmi2EnterInitializationMode, Phase::Instantiated as u32, Instance::enter_initialization;
    /// Makes the simulation.
    fmi2ExitInitializationMode, Phase::Initialization as u32, Instance::exit_initialization;
    /// Makes the simulation.
    fmi3ExitInitializationMode, Phase::Initialization as u32, Instance::exit_initialization;
    /// From stepping to handling events.
    fmi3EnterEventMode, Phase::Step as u32, Instance::enter_event_mode;
    /// From handling events to stepping.
    fmi3EnterStepMode, Phase::Event as u32, Instance::enter_step_mode;
    /// Ends the run; values may still be read.
    fmi2Terminate, Phase::RUNNING, Instance::terminate;
    /// Ends the run; values may still be read.
    fmi3Terminate, Phase::RUNNING, Instance::terminate;
    /// Back to just after instantiation.
    fmi2Reset, Phase::ANY, Instance::reset;
    /// Back to just after instantiation.
    fmi3Reset, Phase::ANY, Instance::reset;
}

/// New instance if the token is that of this build.
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

/// New instance of FMI 3.0.
pub fn instantiate(
    log: Log,
    name: Option<&CStr>,
    token: Option<&CStr>,
    logging_on: bool,
    event_mode_used: bool,
    early_return_allowed: bool,
) -> Option<Owned<Instance>> {
    // Why there is no instance is logged in any case.
    let mut instance = create(log, name, token)?;
    if !logging_on {
        // In FMI 3.0 the logger is then not called at all; FMI 2.0 means messages for debugging only.
        instance.log.switch(false, core::iter::empty());
    }
    instance.event_mode_used = event_mode_used;
    instance.early_return_allowed = early_return_allowed;
    Some(instance)
}

/// Chooses log categories; None among them is unknown.
pub fn set_debug_logging<'a>(
    instance: &mut Instance,
    function: &str,
    on: bool,
    names: Option<impl Iterator<Item = Option<&'a CStr>>>,
) -> Status {
    instance.within(function, Phase::ANY, |instance| match names.map(|names| instance.log.switch(on, names)) {
        Some(true) => Status::Ok,
        Some(false) => instance.refuse_field(Category::Error, (function, "unknown category")),
        None => instance.refuse("null array"),
    })
}

/// Start and stop time, s; begins initialisation.
pub fn enter_initialization(instance: &mut Instance, start: f64, stop: Option<f64>) -> Status {
    instance.within("fmi3EnterInitializationMode", Phase::Instantiated as u32, |instance| {
        match instance.set_experiment(start, stop) {
            Status::Ok => instance.enter_initialization(),
            status => status,
        }
    })
}

/// Whether the host is asked to end; discrete outputs are already up to date, and nothing else is ever
/// reported.
///
/// # Errors
/// The state does not allow it.
pub fn update_discrete_states(instance: &mut Instance) -> Result<bool, Status> {
    instance.check("fmi3UpdateDiscreteStates", Phase::Event as u32)?;
    Ok(instance.kept.terminated)
}

/// A communication step of FMI 3.0 from t to t + h, s.
///
/// # Errors
/// The state does not allow it; how a step that is allowed ends is said by its status.
pub fn do_step(instance: &mut Instance, t: f64, h: f64) -> Result<StepEnd, Status> {
    instance.check("fmi3DoStep", Phase::Step as u32)?;
    let early = match (instance.early_return_allowed, instance.event_mode_used) {
        (false, _) => Early::No,
        (true, true) => Early::AtEvents,
        (true, false) if instance.kept.parameters.stop_on_event() => Early::ToStop,
        (true, false) => Early::No,
    };
    let mut end = in_our_environment(|| instance.do_step(t, h, early));
    end.event &= instance.event_mode_used;
    Ok(end)
}

/// Number in a type of the interface that variables have, and the functions that read and write it.
pub struct Type<T: 'static> {
    /// FMI 2.0: a value reference means an element. FMI 3.0: it means a whole array.
    two: bool,
    get: &'static str,
    set: &'static str,
    kind: Kind,
    of: fn(f64) -> T,
    number: fn(T) -> f64,
}

macro_rules! types {
    ($($(#[$about:meta])* $name:ident: $number:ty, $two:literal, $get:ident $set:ident, $kind:expr, $of:expr, $back:expr;)*) => {$(
        $(#[$about])*
        pub const $name: Type<$number> =
            Type { two: $two, get: stringify!($get), set: stringify!($set), kind: $kind, of: $of, number: $back };
    )*};
}

types! {
    /// Real of FMI 2.0.
    REAL: f64, true, fmi2GetReal fmi2SetReal, Kind::Real, |x| x, |x| x;
    /// Integer of FMI 2.0, enumerations too. What does not fit is cut off at the ends.
    INTEGER: c_int, true, fmi2GetInteger fmi2SetInteger, Kind::Integer, |x| x as c_int, f64::from;
    /// Boolean of FMI 2.0.
    WHETHER: c_int, true, fmi2GetBoolean fmi2SetBoolean, Kind::Boolean, |x| c_int::from(x != 0.0), |x| f64::from(x != 0);
    /// Float64.
    FLOAT64: f64, false, fmi3GetFloat64 fmi3SetFloat64, Kind::Real, |x| x, |x| x;
    /// Int32. What does not fit is cut off at the ends.
    INT32: i32, false, fmi3GetInt32 fmi3SetInt32, Kind::Integer, |x| x as i32, f64::from;
    /// Int64: any enumeration, for all are read and written alike.
    INT64: i64, false, fmi3GetInt64 fmi3SetInt64, Kind::Choice(&STATUS), |x| x as i64, |x| x as f64;
    /// Boolean of FMI 3.0, as a byte.
    BOOLEAN: u8, false, fmi3GetBoolean fmi3SetBoolean, Kind::Boolean, |x| u8::from(x != 0.0), |x| f64::from(x != 0);
}

impl<T> Type<T> {
    /// Variable that a reference means, and which of its elements: first and count.
    fn find(&self, reference: u32) -> Option<(&'static Variable, usize, usize)> {
        let (variable, first, count) = if self.two {
            table::element(reference).map(|(variable, element)| (variable, element, 1))?
        } else {
            table::whole(reference).map(|variable| (variable, 0, variable.size()))?
        };
        // Choices go with integers in FMI 2.0 and by themselves in FMI 3.0.
        let fits = match (variable.kind, self.kind) {
            (Kind::Choice(_), Kind::Choice(_)) => true,
            (Kind::Choice(_), Kind::Integer) => self.two,
            (own, asked) => own == asked,
        };
        fits.then_some((variable, first, count))
    }
}

fn refuse_reference(instance: &Instance, reference: u32) -> Status {
    instance.refuse(&line(format_args!("value reference {reference}: unknown, or of another type")))
}

/// Reads variables one after the other into `values`; None is an array that the host does not have.
pub fn get<T>(instance: &mut Instance, of: &Type<T>, references: Option<&[u32]>, values: Option<&mut [T]>) -> Status {
    let phases = if of.two { Phase::READABLE_IN_2 } else { Phase::ANY };
    instance.within(of.get, phases, |instance| {
        let (Some(references), Some(values)) = (references, values) else { return instance.refuse("null array") };
        let mut places = values.iter_mut();
        for &reference in references {
            let mut numbers = [0.0; MOST_ELEMENTS];
            let (first, count) = if reference == TIME_REFERENCE && !of.two && of.kind == Kind::Real {
                numbers[0] = instance.kept.time;
                (0, 1)
            } else {
                let Some((variable, first, count)) = of.find(reference) else {
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
                *place = (of.of)(*number);
            }
        }
        if places.next().is_some() {
            return instance.refuse("array of values too long");
        }
        Status::Ok
    })
}

/// Sets variables from `values`, all or none.
pub fn set<T: Copy>(instance: &mut Instance, of: &Type<T>, references: Option<&[u32]>, values: Option<&[T]>) -> Status {
    instance.within(of.set, Phase::SETTABLE, |instance| {
        let (Some(references), Some(values)) = (references, values) else { return instance.refuse("null array") };
        for apply in [false, true] {
            let mut given = values.iter();
            for &reference in references {
                let Some((variable, first, count)) = of.find(reference) else {
                    return refuse_reference(instance, reference);
                };
                for element in first..first + count {
                    let Some(&value) = given.next() else { return instance.refuse("array of values too short") };
                    let value = (of.number)(value);
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
    })
}

/// Number of values that these variables have; of what is no variable, none.
pub fn length(references: &[u32]) -> usize {
    let of =
        |&reference| table::whole(reference).map_or(usize::from(reference == TIME_REFERENCE), |found| found.size());
    references.iter().map(of).sum()
}

/// Functions of a type that no variable has: reading or writing none is fine, any is not.
fn none_of_this_type(instance: &mut Instance, function: &str, phases: u32, count: usize) -> Status {
    if count == 0 { instance.within(function, phases, |_| Status::Ok) } else { unsupported(instance, function) }
}

/// Reads so many variables of a type that none has, in FMI 2.0.
pub(crate) fn get_none_in_2(instance: &mut Instance, function: &str, count: usize) -> Status {
    none_of_this_type(instance, function, Phase::READABLE_IN_2, count)
}

/// Reads so many variables of a type that none has.
pub fn get_none(instance: &mut Instance, function: &str, count: usize) -> Status {
    none_of_this_type(instance, function, Phase::ANY, count)
}

/// Sets so many variables of a type that none has.
pub fn set_none(instance: &mut Instance, function: &str, count: usize) -> Status {
    none_of_this_type(instance, function, Phase::SETTABLE, count)
}

/// Functions that are not provided.
pub fn unsupported(instance: &mut Instance, function: &str) -> Status {
    instance.refuse_field(Category::Error, (function, "not supported"))
}

/// Status of FMI 2.0 that there is not: Discard, as its section 4.2.3 asks; nothing has changed.
pub(crate) fn no_status(instance: &mut Instance, function: &str) -> Status {
    instance.within(function, Phase::AFTER_SETTING_UP, |instance| {
        instance.refuse_field(Category::Discard, (function, "no such status"))
    })
}
