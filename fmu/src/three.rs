//! What the functions of FMI 3.0 do, whoever calls them: the C functions of [`crate::fmi3`] or the component
//! for WebAssembly. Each looks itself whether the state of the instance allows the call, and logs why it
//! refuses one.

use crate::calls::{self, Version, check, none_of_this_type, within};
use crate::instance::{Early, Instance, StepEnd};
use crate::kept::Phase;
use crate::log::{Log, Status};
use crate::memory::Owned;
use crate::table::{self, Kind, STATUS, TIME_REFERENCE};
use core::ffi::CStr;
use fabric_host::in_our_environment;

/// A new instance if the token is that of this build.
pub fn instantiate(
    log: Log,
    name: Option<&CStr>,
    token: Option<&CStr>,
    logging_on: bool,
    event_mode_used: bool,
    early_return_allowed: bool,
) -> Option<Owned<Instance>> {
    // Why there is no instance is told in any case.
    let mut instance = calls::create(log, name, token)?;
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
    on: bool,
    names: impl Iterator<Item = Option<&'a CStr>>,
) -> Status {
    within(instance, "fmi3SetDebugLogging", Phase::ANY, |instance| {
        if instance.log.switch(on, names) {
            Status::Ok
        } else {
            instance.refuse("fmi3SetDebugLogging: unknown category")
        }
    })
}

/// Start and stop time, s; begins initialisation.
pub fn enter_initialization(instance: &mut Instance, start: f64, stop: Option<f64>) -> Status {
    within(instance, "fmi3EnterInitializationMode", Phase::Instantiated as u32, |instance| {
        match instance.set_experiment(start, stop) {
            Status::Ok => instance.enter_initialization(),
            status => status,
        }
    })
}

/// Makes the simulation.
pub fn exit_initialization(instance: &mut Instance) -> Status {
    let phases = Phase::Initialization as u32;
    within(instance, "fmi3ExitInitializationMode", phases, Instance::exit_initialization)
}

/// From stepping to handling events.
pub fn enter_event_mode(instance: &mut Instance) -> Status {
    within(instance, "fmi3EnterEventMode", Phase::Step as u32, |instance| {
        if !instance.event_mode_used {
            return instance.refuse("fmi3EnterEventMode: instantiated without event mode");
        }
        instance.kept.phase = Phase::Event;
        instance.show();
        Status::Ok
    })
}

/// Whether the host is asked to end; discrete outputs are already up to date, and nothing else is ever
/// reported.
///
/// # Errors
/// The state does not allow it.
pub fn update_discrete_states(instance: &mut Instance) -> Result<bool, Status> {
    check(instance, "fmi3UpdateDiscreteStates", Phase::Event as u32)?;
    Ok(instance.kept.terminated)
}

/// From handling events to stepping.
pub fn enter_step_mode(instance: &mut Instance) -> Status {
    within(instance, "fmi3EnterStepMode", Phase::Event as u32, |instance| {
        instance.kept.phase = Phase::Step;
        Status::Ok
    })
}

/// Ends the run; values may still be read.
pub fn terminate(instance: &mut Instance) -> Status {
    within(instance, "fmi3Terminate", Phase::RUNNING, |instance| {
        instance.end_capsule();
        instance.kept.phase = Phase::Terminated;
        Status::Ok
    })
}

/// Back to just after instantiation.
pub fn reset(instance: &mut Instance) -> Status {
    within(instance, "fmi3Reset", Phase::ANY, Instance::reset)
}

/// A communication step from t to t + h, s.
///
/// # Errors
/// The state does not allow it; how a step that is allowed ends is said by its status.
pub fn do_step(instance: &mut Instance, t: f64, h: f64) -> Result<StepEnd, Status> {
    check(instance, "fmi3DoStep", Phase::Step as u32)?;
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

/// A type of FMI 3.0 that variables have: its functions, and what a number is in it.
pub struct Type<T: 'static> {
    get: &'static str,
    set: &'static str,
    kind: Kind,
    of: fn(f64) -> T,
    number: fn(T) -> f64,
}

/// Float64.
pub const FLOAT64: Type<f64> =
    Type { get: "fmi3GetFloat64", set: "fmi3SetFloat64", kind: Kind::Real, of: |x| x, number: |x| x };
/// Int32.
pub const INT32: Type<i32> =
    Type { get: "fmi3GetInt32", set: "fmi3SetInt32", kind: Kind::Integer, of: calls::to_integer, number: f64::from };
/// Int64: any enumeration, for all are read and written alike.
pub const INT64: Type<i64> = Type {
    get: "fmi3GetInt64",
    set: "fmi3SetInt64",
    kind: Kind::Choice(&STATUS),
    of: |x| x as i64,
    number: |x| x as f64,
};
/// Boolean, as a byte.
pub const BOOLEAN: Type<u8> = Type {
    get: "fmi3GetBoolean",
    set: "fmi3SetBoolean",
    kind: Kind::Boolean,
    of: |x| u8::from(x != 0.0),
    number: |x| f64::from(u8::from(x != 0)),
};

/// Reads variables one after the other; None is an array that the host does not have.
pub fn get<T: Default>(
    instance: &mut Instance,
    of: &Type<T>,
    references: Option<&[u32]>,
    values: Option<&mut [T]>,
) -> Status {
    within(instance, of.get, Phase::ANY, |instance| {
        calls::get(instance, Version::Three, of.kind, references, values, of.of)
    })
}

/// Sets variables, all or none.
pub fn set<T: Copy>(instance: &mut Instance, of: &Type<T>, references: Option<&[u32]>, values: Option<&[T]>) -> Status {
    within(instance, of.set, Phase::SETTABLE, |instance| {
        calls::set(instance, Version::Three, of.kind, references, values, of.number)
    })
}

/// How many values these variables have; of what is no variable, none.
pub fn length(references: &[u32]) -> usize {
    let of =
        |&reference| table::whole(reference).map_or(usize::from(reference == TIME_REFERENCE), |found| found.size());
    references.iter().map(of).sum()
}

/// Reads so many variables of a type that none has.
pub fn get_none(instance: &mut Instance, function: &str, count: usize) -> Status {
    none_of_this_type(instance, function, Phase::ANY, count)
}

/// Sets so many variables of a type that none has.
pub fn set_none(instance: &mut Instance, function: &str, count: usize) -> Status {
    none_of_this_type(instance, function, Phase::SETTABLE, count)
}
