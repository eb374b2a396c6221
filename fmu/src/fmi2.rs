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

use crate::calls::{self, Handle, Text, array, array_mut, enter, functions_of_states, pass};
use crate::instance::{Early, Instance};
use crate::kept::{Phase, Saved};
use crate::log::{Category, Log, Logger, Logger2, Status};
use crate::memory::Owned;
use crate::operations::{self, INTEGER, REAL, WHETHER};
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
    let names = array(&categories, count).map(|names| names.iter().map(Text::get));
    pass(c, |instance| operations::set_debug_logging(instance, "fmi2SetDebugLogging", on != 0, names))
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
    operations::create(log, name.get(), guid.get()).map_or(ptr::null_mut(), Owned::into_pointer)
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

macro_rules! of_type {
    ($($get:ident $set:ident $of:ident $number:ty;)*) => {$(
        /// Reads variables of a type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(c: Handle, vr: Input<u32>, n: usize, mut values: Output<$number>) -> Status {
            pass(c, |instance| operations::get(instance, &$of, array(&vr, n), array_mut(&mut values, n)))
        }

        /// Sets variables of a type.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(c: Handle, vr: Input<u32>, n: usize, values: Input<$number>) -> Status {
            pass(c, |instance| operations::set(instance, &$of, array(&vr, n), array(&values, n)))
        }
    )*};
}

of_type! {
    fmi2GetReal fmi2SetReal REAL f64;
    fmi2GetInteger fmi2SetInteger INTEGER c_int;
    fmi2GetBoolean fmi2SetBoolean WHETHER c_int;
}

functions_of_states! {
    fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate
    fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate
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

/// Number of a status about the last step, if it is of this `kind`.
fn about_step<T>(
    c: Handle,
    function: &str,
    of_this_kind: bool,
    mut value: Output<T>,
    number: impl FnOnce(&Instance) -> T,
) -> Status {
    if !of_this_kind {
        return pass(c, |instance| operations::no_status(instance, function));
    }
    enter(c, function, Phase::AFTER_SETTING_UP, |instance| {
        if value.put(number(instance)) {
            return Status::Ok;
        }
        instance.refuse_field(Category::Error, (function, "null pointer"))
    })
}

/// Status of a pending step: there is never one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: Handle, kind: c_int, value: Output<c_int>) -> Status {
    about_step(c, "fmi2GetStatus", kind == DO_STEP_STATUS, value, |_| Status::Ok as c_int)
}

/// Time at which the last step ended, s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: Handle, kind: c_int, value: Output<f64>) -> Status {
    about_step(c, "fmi2GetRealStatus", kind == LAST_SUCCESSFUL_TIME, value, |instance| instance.kept.time)
}

/// Whether the last step ended the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: Handle, kind: c_int, value: Output<c_int>) -> Status {
    about_step(c, "fmi2GetBooleanStatus", kind == TERMINATED, value, |instance| c_int::from(instance.kept.terminated))
}
