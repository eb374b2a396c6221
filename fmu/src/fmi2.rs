//! The functions of FMI 2.0 for co-simulation. Each is a call of [`Instance`]; signatures are those of
//! `fmi2Functions.h`.
//!
//! For all of them: a null instance gives Error; a call that does not fit the state is refused and logged.
//!
//! # Safety of all functions here
//! The pointers are as their types' [`Handle::given`], [`Text::given`], [`Input::given`] and
//! [`Output::given`] ask, still, and the counts beside them are theirs. Pointers that are plain here are
//! never followed.
#![allow(non_snake_case)] // the standard's names
#![allow(clippy::missing_safety_doc)] // said once, above

use crate::calls::{self, Handle, Text, Version, array, array_mut, create, enter};
use crate::instance::{Early, Instance};
use crate::kept::Phase;
use crate::kept::Saved;
use crate::log::{Category, Log, Logger, Logger2, Status};
use crate::memory::Owned;
use crate::table::Kind;
use core::ffi::{c_char, c_int, c_void};
use core::ptr;
use fabric_host::{Input, Output};

/// The host's functions.
#[repr(C)]
pub struct Callbacks {
    logger: Option<Logger2>,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

const CO_SIMULATION: c_int = 1;
const DO_STEP_STATUS: c_int = 0;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// "default"
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// "2.0"
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Chooses log categories.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(c: Handle, on: c_int, count: usize, categories: Input<Text>) -> Status {
    enter(c, "fmi2SetDebugLogging", Phase::ANY, |instance| {
        let Some(names) = array(&categories, count) else { return instance.refuse("null array") };
        if instance.log.switch(on != 0, names.iter().map(Text::get)) {
            Status::Ok
        } else {
            instance.refuse("fmi2SetDebugLogging: unknown category")
        }
    })
}

/// A new instance, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: Text,
    fmu_type: c_int,
    guid: Text,
    _resources: *const c_char,
    functions: Input<Callbacks>,
    _visible: c_int,
    logging_on: c_int,
) -> *mut Instance {
    let Some([functions]) = functions.elements(1) else { return ptr::null_mut() };
    let shown = name.get().unwrap_or(c"");
    let log = Log::new(Logger::Two(functions.logger), functions.environment, shown, logging_on != 0);
    if fmu_type != CO_SIMULATION {
        log.say(Category::Error, "only co-simulation is supported");
        return ptr::null_mut();
    }
    create(log, name.get(), guid.get()).map_or(ptr::null_mut(), Owned::into_pointer)
}

/// Frees an instance and its states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: Handle) {
    calls::destroy(c)
}

/// Start and stop time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: Handle,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start: f64,
    stop_defined: c_int,
    stop: f64,
) -> Status {
    enter(c, "fmi2SetupExperiment", Phase::Instantiated as u32, |instance| {
        instance.set_experiment(start, (stop_defined != 0).then_some(stop))
    })
}

/// Begins initialisation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: Handle) -> Status {
    enter(c, "fmi2EnterInitializationMode", Phase::Instantiated as u32, Instance::enter_initialization)
}

/// Makes the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: Handle) -> Status {
    enter(c, "fmi2ExitInitializationMode", Phase::Initialization as u32, Instance::exit_initialization)
}

/// Ends the run; values may still be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: Handle) -> Status {
    enter(c, "fmi2Terminate", Phase::RUNNING, |instance| {
        instance.end_capsule();
        instance.kept.phase = Phase::Terminated;
        Status::Ok
    })
}

/// Back to just after instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: Handle) -> Status {
    enter(c, "fmi2Reset", Phase::ANY, Instance::reset)
}

/// Reads Real variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: Handle, vr: Input<u32>, n: usize, mut values: Output<f64>) -> Status {
    enter(c, "fmi2GetReal", Phase::READABLE_IN_2, |instance| {
        calls::get(instance, Version::Two, Kind::Real, array(&vr, n), array_mut(&mut values, n), |x| x)
    })
}

/// Reads Integer and Enumeration variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: Handle, vr: Input<u32>, n: usize, mut values: Output<c_int>) -> Status {
    enter(c, "fmi2GetInteger", Phase::READABLE_IN_2, |instance| {
        let convert = calls::to_integer;
        calls::get(instance, Version::Two, Kind::Integer, array(&vr, n), array_mut(&mut values, n), convert)
    })
}

/// Reads Boolean variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: Handle, vr: Input<u32>, n: usize, mut values: Output<c_int>) -> Status {
    enter(c, "fmi2GetBoolean", Phase::READABLE_IN_2, |instance| {
        let convert = |x| c_int::from(x != 0.0);
        calls::get(instance, Version::Two, Kind::Boolean, array(&vr, n), array_mut(&mut values, n), convert)
    })
}

/// Sets Real variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: Handle, vr: Input<u32>, n: usize, values: Input<f64>) -> Status {
    enter(c, "fmi2SetReal", Phase::SETTABLE, |instance| {
        calls::set(instance, Version::Two, Kind::Real, array(&vr, n), array(&values, n), |x| x)
    })
}

/// Sets Integer and Enumeration variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: Handle, vr: Input<u32>, n: usize, values: Input<c_int>) -> Status {
    enter(c, "fmi2SetInteger", Phase::SETTABLE, |instance| {
        calls::set(instance, Version::Two, Kind::Integer, array(&vr, n), array(&values, n), f64::from)
    })
}

/// Sets Boolean variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: Handle, vr: Input<u32>, n: usize, values: Input<c_int>) -> Status {
    enter(c, "fmi2SetBoolean", Phase::SETTABLE, |instance| {
        let convert = |x: c_int| f64::from(u8::from(x != 0));
        calls::set(instance, Version::Two, Kind::Boolean, array(&vr, n), array(&values, n), convert)
    })
}

/// Copies the state; a state given by the host is used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: Handle, state: Output<*mut Saved>) -> Status {
    calls::get_state(c, state)
}

/// Restores a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: Handle, state: *mut Saved) -> Status {
    calls::set_state(c, state)
}

/// Frees a state and clears the host's pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: Handle, state: Output<*mut Saved>) -> Status {
    calls::free_state(c, state)
}

/// Bytes of a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: Handle, state: *mut Saved, size: Output<usize>) -> Status {
    calls::serialized_size(c, state, size)
}

/// Writes a state into bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(c: Handle, state: *mut Saved, bytes: Output<u8>, size: usize) -> Status {
    calls::serialize(c, state, bytes, size)
}

/// Makes a state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: Handle,
    bytes: Input<u8>,
    size: usize,
    state: Output<*mut Saved>,
) -> Status {
    calls::deserialize(c, bytes, size, state)
}

/// A communication step from t to t + h.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(c: Handle, t: f64, h: f64, _no_set_state_before: c_int) -> Status {
    enter(c, "fmi2DoStep", Phase::Step as u32, |instance| {
        let stop = instance.kept.parameters.stop_on_event();
        let end = instance.do_step(t, h, if stop { Early::ToStop } else { Early::No });
        if end.terminate { Status::Discard } else { end.status }
    })
}

/// Nothing is ever pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: Handle, kind: c_int, mut value: Output<c_int>) -> Status {
    enter(c, "fmi2GetStatus", Phase::AFTER_SETTING_UP, |instance| {
        if kind != DO_STEP_STATUS {
            return instance.no_status("fmi2GetStatus");
        }
        if !value.put(Status::Ok as c_int) {
            return instance.refuse("fmi2GetStatus: null pointer");
        }
        Status::Ok
    })
}

/// Where the last step ended.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: Handle, kind: c_int, mut value: Output<f64>) -> Status {
    enter(c, "fmi2GetRealStatus", Phase::AFTER_SETTING_UP, |instance| {
        if kind != LAST_SUCCESSFUL_TIME {
            return instance.no_status("fmi2GetRealStatus");
        }
        if !value.put(instance.kept.time) {
            return instance.refuse("fmi2GetRealStatus: null pointer");
        }
        Status::Ok
    })
}

/// Whether the last step ended the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: Handle, kind: c_int, mut value: Output<c_int>) -> Status {
    enter(c, "fmi2GetBooleanStatus", Phase::AFTER_SETTING_UP, |instance| {
        if kind != TERMINATED {
            return instance.no_status("fmi2GetBooleanStatus");
        }
        if !value.put(c_int::from(instance.kept.terminated)) {
            return instance.refuse("fmi2GetBooleanStatus: null pointer");
        }
        Status::Ok
    })
}
