//! The functions of FMI 3.0 for co-simulation. Each is a thin door to [`Instance`]; signatures are those of `fmi3Functions.h`.
//!
//! For all of them: a null instance gives Error; a call that does not fit the state is refused and logged. A `fmi3Boolean` is
//! taken as a byte, so that no bit pattern of a host is an invalid value here.
#![allow(non_snake_case, clippy::missing_safety_doc)] // the standard's names, and its rules for pointers

use crate::door::{self, Version, array, array_mut, create, enter, put, text};
use crate::fmi2::{none_of_this_type, unsupported};
use crate::instance::{Early, Instance, Phase};
use crate::log::{Category, Log, Logger, Logger3, Status};
use crate::state::Saved;
use crate::table::{CHOICES, Id, Kind, whole};
use core::ffi::{c_char, c_void};
use core::ptr;

/// "3.0"
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Chooses log categories.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut Instance,
    on: u8,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3SetDebugLogging", Phase::ANY, |instance| {
            let Some(names) = array(categories, count) else { return instance.refuse("null array") };
            if instance.log.switch(on != 0, names.iter().map(|&name| text(name))) {
                Status::Ok
            } else {
                instance.refuse("fmi3SetDebugLogging: unknown category")
            }
        })
    }
}

/// A new instance, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    name: *const c_char,
    token: *const c_char,
    _resources: *const c_char,
    _visible: u8,
    logging_on: u8,
    event_mode_used: u8,
    early_return_allowed: u8,
    _intermediate: *const u32,
    _intermediates: usize,
    environment: *mut c_void,
    logger: Option<Logger3>,
    _intermediate_update: *const c_void,
) -> *mut Instance {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        let shown = text(name).unwrap_or(c"");
        // Why there is no instance is told in any case.
        let place = create(Log::new(Logger::Three(logger), environment, shown, logging_on != 0), name, token);
        if let Some(instance) = place.as_mut() {
            if logging_on == 0 {
                // In FMI 3.0 the logger is then not called at all; FMI 2.0 means messages for debugging only.
                instance.log.switch(false, core::iter::empty());
            }
            instance.event_mode_used = event_mode_used != 0;
            instance.early_return_allowed = early_return_allowed != 0;
        }
        place
    }
}

/// Not provided: null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: u8,
    _logging_on: u8,
    environment: *mut c_void,
    logger: Option<Logger3>,
) -> *mut Instance {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { only_co_simulation(name, environment, logger) }
}

/// Not provided: null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: u8,
    _logging_on: u8,
    environment: *mut c_void,
    logger: Option<Logger3>,
    _clock_update: *const c_void,
    _lock_preemption: *const c_void,
    _unlock_preemption: *const c_void,
) -> *mut Instance {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { only_co_simulation(name, environment, logger) }
}

unsafe fn only_co_simulation(name: *const c_char, environment: *mut c_void, logger: Option<Logger3>) -> *mut Instance {
    // SAFETY: the host keeps the standard's rules for pointers.
    let name = unsafe { text(name) }.unwrap_or(c"");
    Log::new(Logger::Three(logger), environment, name, false).say(Category::Error, "only co-simulation is supported");
    ptr::null_mut()
}

/// Frees an instance and its states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut Instance) {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { door::destroy(instance) }
}

/// Start and stop time; begins initialisation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut Instance,
    _tolerance_defined: u8,
    _tolerance: f64,
    start: f64,
    stop_defined: u8,
    stop: f64,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3EnterInitializationMode", Phase::Instantiated as u32, |instance| {
            match instance.set_experiment(start, (stop_defined != 0).then_some(stop)) {
                Status::Ok => instance.enter_initialization(),
                status => status,
            }
        })
    }
}

/// Makes the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut Instance) -> Status {
    let phases = Phase::Initialization as u32;
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { enter(instance, "fmi3ExitInitializationMode", phases, Instance::exit_initialization) }
}

/// From stepping to handling events.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: *mut Instance) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3EnterEventMode", Phase::Step as u32, |instance| {
            if !instance.event_mode_used {
                return instance.refuse("fmi3EnterEventMode: instantiated without event mode");
            }
            instance.kept.phase = Phase::Event;
            Status::Ok
        })
    }
}

/// Discrete outputs are already up to date.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: *mut Instance,
    need_update: *mut u8,
    terminate: *mut u8,
    nominals_changed: *mut u8,
    states_changed: *mut u8,
    next_event_defined: *mut u8,
    next_event: *mut f64,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3UpdateDiscreteStates", Phase::Event as u32, |instance| {
            for place in [need_update, nominals_changed, states_changed, next_event_defined] {
                put(place, 0);
            }
            put(terminate, u8::from(instance.kept.terminated));
            put(next_event, 0.0);
            Status::Ok
        })
    }
}

/// From handling events to stepping.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(instance: *mut Instance) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3EnterStepMode", Phase::Event as u32, |instance| {
            instance.kept.phase = Phase::Step;
            Status::Ok
        })
    }
}

/// Ends the run; values may still be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: *mut Instance) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3Terminate", Phase::RUNNING, |instance| {
            instance.kept.phase = Phase::Terminated;
            Status::Ok
        })
    }
}

/// Back to just after instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut Instance) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { enter(instance, "fmi3Reset", Phase::ANY, Instance::reset) }
}

/// Reads Float64 variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut Instance,
    vr: *const u32,
    count: usize,
    values: *mut f64,
    length: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3GetFloat64", Phase::ANY, |instance| {
            door::get(instance, Version::Three, Kind::Real, array(vr, count), array_mut(values, length), |x| x)
        })
    }
}

/// Reads Int32 variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt32(
    instance: *mut Instance,
    vr: *const u32,
    count: usize,
    values: *mut i32,
    length: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3GetInt32", Phase::ANY, |instance| {
            let (vr, values) = (array(vr, count), array_mut(values, length));
            door::get(instance, Version::Three, Kind::Integer, vr, values, door::to_integer)
        })
    }
}

/// Reads Enumeration variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt64(
    instance: *mut Instance,
    vr: *const u32,
    count: usize,
    values: *mut i64,
    length: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3GetInt64", Phase::ANY, |instance| {
            let (vr, values) = (array(vr, count), array_mut(values, length));
            door::get(instance, Version::Three, ENUMERATION, vr, values, |x| x as i64)
        })
    }
}

/// Reads Boolean variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBoolean(
    instance: *mut Instance,
    vr: *const u32,
    count: usize,
    values: *mut u8,
    length: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3GetBoolean", Phase::ANY, |instance| {
            let (vr, values) = (array(vr, count), array_mut(values, length));
            door::get(instance, Version::Three, Kind::Boolean, vr, values, |x| u8::from(x != 0.0))
        })
    }
}

/// Sets Float64 variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut Instance,
    vr: *const u32,
    count: usize,
    values: *const f64,
    length: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3SetFloat64", Phase::SETTABLE, |instance| {
            door::set(instance, Version::Three, Kind::Real, array(vr, count), array(values, length), |x| x)
        })
    }
}

/// Sets Int32 variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt32(
    instance: *mut Instance,
    vr: *const u32,
    count: usize,
    values: *const i32,
    length: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3SetInt32", Phase::SETTABLE, |instance| {
            door::set(instance, Version::Three, Kind::Integer, array(vr, count), array(values, length), f64::from)
        })
    }
}

/// Sets Enumeration variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt64(
    instance: *mut Instance,
    vr: *const u32,
    count: usize,
    values: *const i64,
    length: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3SetInt64", Phase::SETTABLE, |instance| {
            let (vr, values) = (array(vr, count), array(values, length));
            door::set(instance, Version::Three, ENUMERATION, vr, values, |x| x as f64)
        })
    }
}

/// Sets Boolean variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBoolean(
    instance: *mut Instance,
    vr: *const u32,
    count: usize,
    values: *const u8,
    length: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3SetBoolean", Phase::SETTABLE, |instance| {
            let (vr, values) = (array(vr, count), array(values, length));
            door::set(instance, Version::Three, Kind::Boolean, vr, values, |x| f64::from(u8::from(x != 0)))
        })
    }
}

/// Any enumeration: all are read and written alike.
const ENUMERATION: Kind = Kind::Choice(CHOICES[0]);

/// Copies the state; a state given by the host is used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: *mut Instance, state: *mut *mut Saved) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { crate::fmi2::fmi2GetFMUstate(instance, state) }
}

/// Restores a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut Instance, state: *mut Saved) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { crate::fmi2::fmi2SetFMUstate(instance, state) }
}

/// Frees a state and clears the host's pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: *mut Instance, state: *mut *mut Saved) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { crate::fmi2::fmi2FreeFMUstate(instance, state) }
}

/// Bytes of a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: *mut Instance,
    state: *mut Saved,
    size: *mut usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { crate::fmi2::fmi2SerializedFMUstateSize(instance, state, size) }
}

/// Writes a state into bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: *mut Instance,
    state: *mut Saved,
    bytes: *mut u8,
    size: usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { crate::fmi2::fmi2SerializeFMUstate(instance, state, bytes, size) }
}

/// Makes a state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: *mut Instance,
    bytes: *const u8,
    size: usize,
    state: *mut *mut Saved,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe { crate::fmi2::fmi2DeSerializeFMUstate(instance, bytes, size, state) }
}

/// A communication step from t to t + h.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut Instance,
    t: f64,
    h: f64,
    _no_set_state_before: u8,
    event_handling_needed: *mut u8,
    terminate: *mut u8,
    early_return: *mut u8,
    last_successful_time: *mut f64,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3DoStep", Phase::Step as u32, |instance| {
            let early = match (instance.early_return_allowed, instance.event_mode_used) {
                (false, _) => Early::No,
                (true, true) => Early::AtEvents,
                (true, false) if instance.kept.parameters.flag(Id::StopOnEvent) => Early::ToStop,
                (true, false) => Early::No,
            };
            let end = instance.do_step(t, h, early);
            put(event_handling_needed, u8::from(end.event && instance.event_mode_used));
            put(terminate, u8::from(end.terminate));
            put(early_return, u8::from(end.early));
            put(last_successful_time, instance.kept.time);
            end.status
        })
    }
}

/// No input reaches an output without a step: every output depends on nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfVariableDependencies(
    instance: *mut Instance,
    reference: u32,
    count: *mut usize,
) -> Status {
    // SAFETY: the host keeps the standard's rules for pointers.
    unsafe {
        enter(instance, "fmi3GetNumberOfVariableDependencies", Phase::ANY, |instance| {
            if count.is_null() || whole(reference).is_none_or(|variable| !variable.role.is_output()) {
                return instance.refuse("fmi3GetNumberOfVariableDependencies: not an output, or null pointer");
            }
            put(count, 0);
            Status::Ok
        })
    }
}

/// Types no variable has: reading or writing none is fine, any is not. The arguments after the count are of no interest, and
/// under these calling conventions need not be declared.
macro_rules! of_no_variable {
    ($phases:expr; $($name:ident)*) => {$(
        /// No variable has this type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut Instance, _vr: *const u32, count: usize) -> Status {
            // SAFETY: the host keeps the standard's rules for pointers.
            unsafe { none_of_this_type(instance, stringify!($name), $phases, count) }
        }
    )*};
}

of_no_variable! { Phase::ANY;
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetUInt32 fmi3GetUInt64
    fmi3GetString fmi3GetBinary fmi3GetClock
}

of_no_variable! { Phase::SETTABLE;
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetUInt32 fmi3SetUInt64
    fmi3SetString fmi3SetBinary fmi3SetClock
}

/// Functions of other interface types and of optional features: refused and logged. They look at nothing but the
/// instance, which under these calling conventions is all they need to declare.
macro_rules! unsupported {
    ($($name:ident)*) => {$(
        /// Not provided.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut Instance) -> Status {
            // SAFETY: the host keeps the standard's rules for pointers.
            unsafe { unsupported(instance, stringify!($name)) }
        }
    )*};
}

unsupported! {
    fmi3GetVariableDependencies fmi3GetDirectionalDerivative fmi3GetAdjointDerivative
    fmi3EnterConfigurationMode fmi3ExitConfigurationMode
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3EvaluateDiscreteStates fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep
    fmi3SetTime fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators
    fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators
    fmi3GetNumberOfContinuousStates fmi3GetOutputDerivatives fmi3ActivateModelPartition
}
