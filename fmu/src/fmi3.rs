//! The functions of FMI 3.0 for co-simulation. Each is a call of [`Instance`]; signatures are those of `fmi3Functions.h`.
//!
//! For all of them: a null instance gives Error; a call that does not fit the state is refused and logged. A `fmi3Boolean` is
//! taken as a byte, so that no bit pattern of a host is an invalid value here.
//!
//! # Safety of all functions here
//! The pointers are as their types' [`Handle::given`], [`Text::given`], [`Input::given`] and [`Output::given`] ask, still, and the
//! counts beside them are theirs. Pointers that are plain here are never followed.
#![allow(non_snake_case)] // the standard's names
#![allow(clippy::missing_safety_doc)] // said once, above

use crate::calls::{self, Handle, Text, Version, array, array_mut, create, enter};
use crate::instance::{Early, Instance};
use crate::kept::Phase;
use crate::kept::Saved;
use crate::log::{Category, Log, Logger, Logger3, Status};
use crate::memory::Owned;
use crate::table::{Kind, STATUS};
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
    enter(instance, "fmi3SetDebugLogging", Phase::ANY, |instance| {
        let Some(names) = array(&categories, count) else { return instance.refuse("null array") };
        if instance.log.switch(on != 0, names.iter().map(Text::get)) {
            Status::Ok
        } else {
            instance.refuse("fmi3SetDebugLogging: unknown category")
        }
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
    let shown = name.get().unwrap_or(c"");
    // Why there is no instance is told in any case.
    let log = Log::new(Logger::Three(logger), environment, shown, logging_on != 0);
    let Some(mut instance) = create(log, name, token) else { return ptr::null_mut() };
    if logging_on == 0 {
        // In FMI 3.0 the logger is then not called at all; FMI 2.0 means messages for debugging only.
        instance.log.switch(false, core::iter::empty());
    }
    instance.event_mode_used = event_mode_used != 0;
    instance.early_return_allowed = early_return_allowed != 0;
    Owned::into_pointer(instance)
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
    enter(instance, "fmi3EnterInitializationMode", Phase::Instantiated as u32, |instance| {
        match instance.set_experiment(start, (stop_defined != 0).then_some(stop)) {
            Status::Ok => instance.enter_initialization(),
            status => status,
        }
    })
}

/// Makes the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: Handle) -> Status {
    let phases = Phase::Initialization as u32;
    enter(instance, "fmi3ExitInitializationMode", phases, Instance::exit_initialization)
}

/// From stepping to handling events.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: Handle) -> Status {
    enter(instance, "fmi3EnterEventMode", Phase::Step as u32, |instance| {
        if !instance.event_mode_used {
            return instance.refuse("fmi3EnterEventMode: instantiated without event mode");
        }
        instance.kept.phase = Phase::Event;
        instance.show();
        Status::Ok
    })
}

/// Discrete outputs are already up to date. Whether to end is said here, too, for hosts that handle the event before they ask.
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
    enter(instance, "fmi3UpdateDiscreteStates", Phase::Event as u32, |instance| {
        for mut place in [need_update, nominals_changed, states_changed, next_event_defined] {
            place.put(0);
        }
        terminate.put(u8::from(instance.kept.terminated));
        next_event.put(0.0);
        Status::Ok
    })
}

/// From handling events to stepping.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(instance: Handle) -> Status {
    enter(instance, "fmi3EnterStepMode", Phase::Event as u32, |instance| {
        instance.kept.phase = Phase::Step;
        Status::Ok
    })
}

/// Ends the run; values may still be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: Handle) -> Status {
    enter(instance, "fmi3Terminate", Phase::RUNNING, |instance| {
        instance.end_capsule();
        instance.kept.phase = Phase::Terminated;
        Status::Ok
    })
}

/// Back to just after instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: Handle) -> Status {
    enter(instance, "fmi3Reset", Phase::ANY, Instance::reset)
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
    enter(instance, "fmi3GetFloat64", Phase::ANY, |instance| {
        calls::get(instance, Version::Three, Kind::Real, array(&vr, count), array_mut(&mut values, length), |x| x)
    })
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
    enter(instance, "fmi3GetInt32", Phase::ANY, |instance| {
        let (vr, values) = (array(&vr, count), array_mut(&mut values, length));
        calls::get(instance, Version::Three, Kind::Integer, vr, values, calls::to_integer)
    })
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
    enter(instance, "fmi3GetInt64", Phase::ANY, |instance| {
        let (vr, values) = (array(&vr, count), array_mut(&mut values, length));
        calls::get(instance, Version::Three, ENUMERATION, vr, values, |x| x as i64)
    })
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
    enter(instance, "fmi3GetBoolean", Phase::ANY, |instance| {
        let (vr, values) = (array(&vr, count), array_mut(&mut values, length));
        calls::get(instance, Version::Three, Kind::Boolean, vr, values, |x| u8::from(x != 0.0))
    })
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
    enter(instance, "fmi3SetFloat64", Phase::SETTABLE, |instance| {
        calls::set(instance, Version::Three, Kind::Real, array(&vr, count), array(&values, length), |x| x)
    })
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
    enter(instance, "fmi3SetInt32", Phase::SETTABLE, |instance| {
        calls::set(instance, Version::Three, Kind::Integer, array(&vr, count), array(&values, length), f64::from)
    })
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
    enter(instance, "fmi3SetInt64", Phase::SETTABLE, |instance| {
        let (vr, values) = (array(&vr, count), array(&values, length));
        calls::set(instance, Version::Three, ENUMERATION, vr, values, |x| x as f64)
    })
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
    enter(instance, "fmi3SetBoolean", Phase::SETTABLE, |instance| {
        let (vr, values) = (array(&vr, count), array(&values, length));
        calls::set(instance, Version::Three, Kind::Boolean, vr, values, |x| f64::from(u8::from(x != 0)))
    })
}

/// Any enumeration: all are read and written alike.
const ENUMERATION: Kind = Kind::Choice(&STATUS);

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
    enter(instance, "fmi3DoStep", Phase::Step as u32, |instance| {
        let early = match (instance.early_return_allowed, instance.event_mode_used) {
            (false, _) => Early::No,
            (true, true) => Early::AtEvents,
            (true, false) if instance.kept.parameters.stop_on_event() => Early::ToStop,
            (true, false) => Early::No,
        };
        let end = instance.do_step(t, h, early);
        event_handling_needed.put(u8::from(end.event && instance.event_mode_used));
        terminate.put(u8::from(end.terminate));
        early_return.put(u8::from(end.early));
        last_successful_time.put(instance.kept.time);
        end.status
    })
}
