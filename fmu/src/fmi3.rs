//! The functions of FMI 3.0 for co-simulation. Each is a call of [`Instance`]; signatures are those of
//! `fmi3Functions.h`.
//!
//! For all of them: a null instance gives Error; a call that does not fit the state is refused and logged. A
//! `fmi3Boolean` is taken as a byte, so that no bit pattern of a host is an invalid value here.
//!
//! # Safety of all functions here
//! The pointers are as their types' [`Handle::given`], [`Text::given`], [`Input::given`] and
//! [`Output::given`] ask, still, and the counts beside them are theirs. Pointers that are plain here are
//! never followed.
#![allow(non_snake_case)] // the standard's names
#![allow(clippy::missing_safety_doc)] // said once, above

use crate::calls::{self, Handle, Text, array, array_mut, pass};
use crate::instance::Instance;
use crate::kept::Saved;
use crate::log::{Category, Log, Logger, Logger3, Status};
use crate::memory::Owned;
use crate::three::{self, BOOLEAN, FLOAT64, INT32, INT64};
use core::ffi::{c_char, c_void};
use core::ptr;
use fabric_host::{Input, Output};

/// "3.0"
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Chooses log categories.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: Handle,
    on: u8,
    count: usize,
    categories: Input<Text>,
) -> Status {
    pass(instance, |instance| {
        let Some(names) = array(&categories, count) else { return instance.refuse("null array") };
        three::set_debug_logging(instance, on != 0, names.iter().map(Text::get))
    })
}

/// A new instance, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    name: Text,
    token: Text,
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
    let (name, token, logging_on) = (name.get(), token.get(), logging_on != 0);
    let log = Log::new(Logger::Three(logger), environment, name.unwrap_or(c""), logging_on);
    let (events, early) = (event_mode_used != 0, early_return_allowed != 0);
    three::instantiate(log, name, token, logging_on, events, early).map_or(ptr::null_mut(), Owned::into_pointer)
}

/// Not provided: null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    name: Text,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: u8,
    _logging_on: u8,
    environment: *mut c_void,
    logger: Option<Logger3>,
) -> *mut Instance {
    only_co_simulation(name, environment, logger)
}

/// Not provided: null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    name: Text,
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
    only_co_simulation(name, environment, logger)
}

fn only_co_simulation(name: Text, environment: *mut c_void, logger: Option<Logger3>) -> *mut Instance {
    let name = name.get().unwrap_or(c"");
    Log::new(Logger::Three(logger), environment, name, false).say(Category::Error, "only co-simulation is supported");
    ptr::null_mut()
}

/// Frees an instance and its states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: Handle) {
    calls::destroy(instance)
}

/// Start and stop time; begins initialisation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: Handle,
    _tolerance_defined: u8,
    _tolerance: f64,
    start: f64,
    stop_defined: u8,
    stop: f64,
) -> Status {
    let stop = (stop_defined != 0).then_some(stop);
    pass(instance, |instance| three::enter_initialization(instance, start, stop))
}

/// Makes the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: Handle) -> Status {
    pass(instance, three::exit_initialization)
}

/// From stepping to handling events.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: Handle) -> Status {
    pass(instance, three::enter_event_mode)
}

/// Whether to end is said here, too, for hosts that handle the event before they ask.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: Handle,
    need_update: Output<u8>,
    mut terminate: Output<u8>,
    nominals_changed: Output<u8>,
    states_changed: Output<u8>,
    next_event_defined: Output<u8>,
    mut next_event: Output<f64>,
) -> Status {
    pass(instance, |instance| match three::update_discrete_states(instance) {
        Ok(end) => {
            for mut place in [need_update, nominals_changed, states_changed, next_event_defined] {
                place.put(0);
            }
            terminate.put(u8::from(end));
            next_event.put(0.0);
            Status::Ok
        }
        Err(refused) => refused,
    })
}

/// From handling events to stepping.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(instance: Handle) -> Status {
    pass(instance, three::enter_step_mode)
}

/// Ends the run; values may still be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: Handle) -> Status {
    pass(instance, three::terminate)
}

/// Back to just after instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: Handle) -> Status {
    pass(instance, three::reset)
}

/// Reads Float64 variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: Handle,
    vr: Input<u32>,
    count: usize,
    mut values: Output<f64>,
    length: usize,
) -> Status {
    pass(instance, |instance| three::get(instance, &FLOAT64, array(&vr, count), array_mut(&mut values, length)))
}

/// Reads Int32 variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt32(
    instance: Handle,
    vr: Input<u32>,
    count: usize,
    mut values: Output<i32>,
    length: usize,
) -> Status {
    pass(instance, |instance| three::get(instance, &INT32, array(&vr, count), array_mut(&mut values, length)))
}

/// Reads Enumeration variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt64(
    instance: Handle,
    vr: Input<u32>,
    count: usize,
    mut values: Output<i64>,
    length: usize,
) -> Status {
    pass(instance, |instance| three::get(instance, &INT64, array(&vr, count), array_mut(&mut values, length)))
}

/// Reads Boolean variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBoolean(
    instance: Handle,
    vr: Input<u32>,
    count: usize,
    mut values: Output<u8>,
    length: usize,
) -> Status {
    pass(instance, |instance| three::get(instance, &BOOLEAN, array(&vr, count), array_mut(&mut values, length)))
}

/// Sets Float64 variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: Handle,
    vr: Input<u32>,
    count: usize,
    values: Input<f64>,
    length: usize,
) -> Status {
    pass(instance, |instance| three::set(instance, &FLOAT64, array(&vr, count), array(&values, length)))
}

/// Sets Int32 variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt32(
    instance: Handle,
    vr: Input<u32>,
    count: usize,
    values: Input<i32>,
    length: usize,
) -> Status {
    pass(instance, |instance| three::set(instance, &INT32, array(&vr, count), array(&values, length)))
}

/// Sets Enumeration variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt64(
    instance: Handle,
    vr: Input<u32>,
    count: usize,
    values: Input<i64>,
    length: usize,
) -> Status {
    pass(instance, |instance| three::set(instance, &INT64, array(&vr, count), array(&values, length)))
}

/// Sets Boolean variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBoolean(
    instance: Handle,
    vr: Input<u32>,
    count: usize,
    values: Input<u8>,
    length: usize,
) -> Status {
    pass(instance, |instance| three::set(instance, &BOOLEAN, array(&vr, count), array(&values, length)))
}

/// Copies the state; a state given by the host is used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: Handle, state: Output<*mut Saved>) -> Status {
    calls::get_state(instance, state)
}

/// Restores a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: Handle, state: *mut Saved) -> Status {
    calls::set_state(instance, state)
}

/// Frees a state and clears the host's pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: Handle, state: Output<*mut Saved>) -> Status {
    calls::free_state(instance, state)
}

/// Bytes of a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: Handle,
    state: *mut Saved,
    size: Output<usize>,
) -> Status {
    calls::serialized_size(instance, state, size)
}

/// Writes a state into bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: Handle,
    state: *mut Saved,
    bytes: Output<u8>,
    size: usize,
) -> Status {
    calls::serialize(instance, state, bytes, size)
}

/// Makes a state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: Handle,
    bytes: Input<u8>,
    size: usize,
    state: Output<*mut Saved>,
) -> Status {
    calls::deserialize(instance, bytes, size, state)
}

/// A communication step from t to t + h.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: Handle,
    t: f64,
    h: f64,
    _no_set_state_before: u8,
    mut event_handling_needed: Output<u8>,
    mut terminate: Output<u8>,
    mut early_return: Output<u8>,
    mut last_successful_time: Output<f64>,
) -> Status {
    pass(instance, |instance| match three::do_step(instance, t, h) {
        Ok(end) => {
            event_handling_needed.put(u8::from(end.event));
            terminate.put(u8::from(end.terminate));
            early_return.put(u8::from(end.early));
            last_successful_time.put(instance.kept.time);
            end.status
        }
        Err(refused) => refused,
    })
}
