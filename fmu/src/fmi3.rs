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

use crate::calls::{self, Handle, Text, array, array_mut, functions_of_states, pass};
use crate::instance::Instance;
use crate::kept::Saved;
use crate::log::{Category, Log, Logger, Logger3, Status};
use crate::memory::Owned;
use crate::operations::{self, BOOLEAN, FLOAT64, INT32, INT64};
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
    let names = array(&categories, count).map(|names| names.iter().map(Text::get));
    pass(instance, |instance| operations::set_debug_logging(instance, "fmi3SetDebugLogging", on != 0, names))
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
    operations::instantiate(log, name, token, logging_on, events, early).map_or(ptr::null_mut(), Owned::into_pointer)
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
    pass(instance, |instance| operations::enter_initialization(instance, start, stop))
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
    pass(instance, |instance| match operations::update_discrete_states(instance) {
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

macro_rules! of_type {
    ($($get:ident $set:ident $of:ident $number:ty;)*) => {$(
        /// Reads variables of a type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: Handle,
            vr: Input<u32>,
            count: usize,
            mut values: Output<$number>,
            length: usize,
        ) -> Status {
            pass(instance, |instance| operations::get(instance, &$of, array(&vr, count), array_mut(&mut values, length)))
        }

        /// Sets variables of a type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: Handle,
            vr: Input<u32>,
            count: usize,
            values: Input<$number>,
            length: usize,
        ) -> Status {
            pass(instance, |instance| operations::set(instance, &$of, array(&vr, count), array(&values, length)))
        }
    )*};
}

of_type! {
    fmi3GetFloat64 fmi3SetFloat64 FLOAT64 f64;
    fmi3GetInt32 fmi3SetInt32 INT32 i32;
    fmi3GetInt64 fmi3SetInt64 INT64 i64;
    fmi3GetBoolean fmi3SetBoolean BOOLEAN u8;
}

functions_of_states! {
    fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState
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
    pass(instance, |instance| match operations::do_step(instance, t, h) {
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
