//! The FMU as a component for WebAssembly, after the working draft of FMI-LS-WASM (`wit/fmi3.wit`): each
//! function is one of [`fabric_fmu::operations`], which the C functions of FMI 3.0 call too.
//!
//! It imports the host's logger and nothing of WASI. A component is not entered while it calls its host, so
//! that no instance is ever borrowed twice; a host that did so would be refused.
#![cfg_attr(target_family = "wasm", no_std)]
#![allow(missing_docs)] // of what is generated

extern crate alloc;

use alloc::ffi::CString;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;
use core::cell::RefCell;
use core::ptr;
use exports::fmi::fmi3::co_simulation::{
    self, DiscreteStatesInfo, DoStepResult, IntervalFraction, IntervalQualifier, VariableDependency,
};
use exports::fmi::fmi3::common;
use fabric_fmu::instance::Instance;
use fabric_fmu::log::{Log, Logger};
use fabric_fmu::operations::{self, BOOLEAN, FLOAT64, INT32, INT64, Type, unsupported};
use fabric_fmu::{Owned, log::Status as Answer};
use fmi::fmi3::callbacks::log_message;
use fmi::fmi3::types::Status;

wit_bindgen::generate!({ path: "wit", world: "co-simulation-fmu" });

struct Fmu;

export!(Fmu);

impl common::Guest for Fmu {
    fn get_version() -> String {
        "3.0".into()
    }
}

impl co_simulation::Guest for Fmu {
    type CoSimulationInstance = Component;
}

/// One instance.
struct Component(RefCell<Owned<Instance>>);

fn status(answer: Answer) -> Status {
    match answer {
        Answer::Ok => Status::Ok,
        Answer::Warning => Status::Warning,
        Answer::Discard => Status::Discard,
        Answer::Error => Status::Error,
        Answer::Fatal => Status::Fatal,
    }
}

/// A value, or why there is none.
fn or<T>(answer: Answer, value: T) -> Result<T, Answer> {
    if answer == Answer::Ok { Ok(value) } else { Err(answer) }
}

/// A text for the instance, of which one with a zero in it is never a known one.
fn text(text: String) -> CString {
    CString::new(text).unwrap_or_default()
}

/// The host's logger.
fn say(name: &str, answer: Answer, category: &str, message: &str) {
    log_message(name, status(answer), category, message);
}

impl Component {
    fn ask<T>(&self, work: impl FnOnce(&mut Instance) -> Result<T, Answer>) -> Result<T, Status> {
        let mut instance = self.0.try_borrow_mut().map_err(|_| Status::Error)?;
        work(&mut instance).map_err(status)
    }

    fn call(&self, work: impl FnOnce(&mut Instance) -> Answer) -> Status {
        self.ask(|instance| Ok(status(work(instance)))).unwrap_or_else(|refused| refused)
    }

    fn get<T: Default + Clone>(&self, of: &Type<T>, references: &[u32]) -> Result<Vec<T>, Status> {
        let mut values = vec![T::default(); operations::length(references)];
        self.ask(|instance| or(operations::get(instance, of, Some(references), Some(&mut values)), ()))?;
        Ok(values)
    }

    fn set<T: Copy>(&self, of: &Type<T>, references: &[u32], values: &[T]) -> Status {
        self.call(|instance| operations::set(instance, of, Some(references), Some(values)))
    }

    fn get_none<T>(&self, function: &str, references: &[u32]) -> Result<Vec<T>, Status> {
        self.ask(|instance| or(operations::get_none(instance, function, references.len()), Vec::new()))
    }

    fn set_none(&self, function: &str, references: &[u32]) -> Status {
        self.call(|instance| operations::set_none(instance, function, references.len()))
    }
}

/// The functions of types that no variable has.
macro_rules! of_no_variable {
    ($($get:ident $set:ident $type:ty, $c_get:literal $c_set:literal;)*) => {$(
        fn $get(&self, references: Vec<u32>) -> Result<Vec<$type>, Status> {
            self.get_none($c_get, &references)
        }

        fn $set(&self, references: Vec<u32>, _: Vec<$type>) -> Status {
            self.set_none($c_set, &references)
        }
    )*};
}

/// Functions that this FMU does not offer in any form: each is refused and logged.
macro_rules! not_offered {
    ($($answer:path, $name:ident($($of:ty),*) -> $result:ty, $function:literal;)*) => {$(
        fn $name(&self, $(_: $of),*) -> $result {
            $answer(self.call(|instance| unsupported(instance, $function)))
        }
    )*};
}

impl co_simulation::GuestCoSimulationInstance for Component {
    fn instantiate_co_simulation(
        name: String,
        token: String,
        _visible: bool,
        logging_on: bool,
        event_mode_used: bool,
        early_return_allowed: bool,
        _intermediate: Vec<u32>,
    ) -> Option<co_simulation::CoSimulationInstance> {
        let (name, token) = (text(name), text(token));
        let log = Log::new(Logger::Component(say), ptr::null_mut(), &name, logging_on);
        let (name, token) = (Some(&*name), Some(&*token));
        let instance = operations::instantiate(log, name, token, logging_on, event_mode_used, early_return_allowed)?;
        Some(co_simulation::CoSimulationInstance::new(Component(RefCell::new(instance))))
    }

    fn set_debug_logging(&self, on: bool, categories: Vec<String>) -> Status {
        let names: Vec<CString> = categories.into_iter().map(text).collect();
        let named = names.iter().map(|name| Some(&**name));
        self.call(|instance| operations::set_debug_logging(instance, "fmi3SetDebugLogging", on, Some(named)))
    }

    fn enter_initialization_mode(&self, _tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Status {
        self.call(|instance| operations::enter_initialization(instance, start, stop))
    }

    fn exit_initialization_mode(&self) -> Status {
        self.call(operations::fmi3ExitInitializationMode)
    }

    fn enter_event_mode(&self) -> Status {
        self.call(operations::fmi3EnterEventMode)
    }

    fn update_discrete_states(&self) -> Result<DiscreteStatesInfo, Status> {
        let terminate_simulation = self.ask(operations::update_discrete_states)?;
        Ok(DiscreteStatesInfo {
            new_discrete_states_needed: false,
            terminate_simulation,
            nominals_of_continuous_states_changed: false,
            values_of_continuous_states_changed: false,
            next_event_time_defined: false,
            next_event_time: 0.0,
        })
    }

    fn enter_step_mode(&self) -> Status {
        self.call(operations::fmi3EnterStepMode)
    }

    fn terminate(&self) -> Status {
        self.call(operations::fmi3Terminate)
    }

    fn reset(&self) -> Status {
        self.call(operations::fmi3Reset)
    }

    fn do_step(&self, t: f64, h: f64, _no_set_state_before: bool) -> Result<DoStepResult, Status> {
        self.ask(|instance| {
            let end = operations::do_step(instance, t, h)?;
            let result = DoStepResult {
                last_successful_time: instance.kept.time,
                event_handling_needed: end.event,
                terminate_simulation: end.terminate,
                early_return: end.early,
            };
            or(end.status, result)
        })
    }

    fn get_float64(&self, references: Vec<u32>) -> Result<Vec<f64>, Status> {
        self.get(&FLOAT64, &references)
    }

    fn get_int32(&self, references: Vec<u32>) -> Result<Vec<i32>, Status> {
        self.get(&INT32, &references)
    }

    fn get_int64(&self, references: Vec<u32>) -> Result<Vec<i64>, Status> {
        self.get(&INT64, &references)
    }

    fn get_boolean(&self, references: Vec<u32>) -> Result<Vec<bool>, Status> {
        Ok(self.get(&BOOLEAN, &references)?.into_iter().map(|value| value != 0).collect())
    }

    fn set_float64(&self, references: Vec<u32>, values: Vec<f64>) -> Status {
        self.set(&FLOAT64, &references, &values)
    }

    fn set_int32(&self, references: Vec<u32>, values: Vec<i32>) -> Status {
        self.set(&INT32, &references, &values)
    }

    fn set_int64(&self, references: Vec<u32>, values: Vec<i64>) -> Status {
        self.set(&INT64, &references, &values)
    }

    fn set_boolean(&self, references: Vec<u32>, values: Vec<bool>) -> Status {
        self.set(&BOOLEAN, &references, &values.into_iter().map(u8::from).collect::<Vec<_>>())
    }

    /// The state as bytes; none is kept here.
    fn get_fmu_state(&self) -> Result<Vec<u8>, Status> {
        self.ask(|instance| {
            let saved = instance.save(ptr::null_mut())?;
            let mut bytes = vec![0; instance.serialized_size(saved)?];
            let written = instance.serialize(saved, &mut bytes);
            instance.free(saved)?;
            written.map(|()| bytes)
        })
    }

    fn set_fmu_state(&self, bytes: Vec<u8>) -> Status {
        let restored = self.ask(|instance| {
            let saved = instance.deserialize(&bytes)?;
            let restored = instance.restore(saved);
            instance.free(saved)?;
            restored
        });
        restored.err().unwrap_or(Status::Ok)
    }

    of_no_variable! {
        get_float32 set_float32 f32, "fmi3GetFloat32" "fmi3SetFloat32";
        get_int8 set_int8 i8, "fmi3GetInt8" "fmi3SetInt8";
        get_int16 set_int16 i16, "fmi3GetInt16" "fmi3SetInt16";
        get_uint8 set_uint8 u8, "fmi3GetUInt8" "fmi3SetUInt8";
        get_uint16 set_uint16 u16, "fmi3GetUInt16" "fmi3SetUInt16";
        get_uint32 set_uint32 u32, "fmi3GetUInt32" "fmi3SetUInt32";
        get_uint64 set_uint64 u64, "fmi3GetUInt64" "fmi3SetUInt64";
        get_string set_string String, "fmi3GetString" "fmi3SetString";
        get_binary set_binary Vec<u8>, "fmi3GetBinary" "fmi3SetBinary";
        get_clock set_clock bool, "fmi3GetClock" "fmi3SetClock";
    }

    not_offered! {
        Status::from, enter_configuration_mode() -> Status, "fmi3EnterConfigurationMode";
        Status::from, exit_configuration_mode() -> Status, "fmi3ExitConfigurationMode";
        Err, get_number_of_variable_dependencies(u32) -> Result<u64, Status>, "fmi3GetNumberOfVariableDependencies";
        Err, get_variable_dependencies(u32) -> Result<Vec<VariableDependency>, Status>, "fmi3GetVariableDependencies";
        Err, get_directional_derivative(Vec<u32>, Vec<u32>, Vec<f64>) -> Result<Vec<f64>, Status>, "fmi3GetDirectionalDerivative";
        Err, get_adjoint_derivative(Vec<u32>, Vec<u32>, Vec<f64>) -> Result<Vec<f64>, Status>, "fmi3GetAdjointDerivative";
        Err, get_interval_decimal(Vec<u32>) -> Result<Vec<(f64, IntervalQualifier)>, Status>, "fmi3GetIntervalDecimal";
        Err, get_interval_fraction(Vec<u32>) -> Result<Vec<(IntervalFraction, IntervalQualifier)>, Status>, "fmi3GetIntervalFraction";
        Err, get_shift_decimal(Vec<u32>) -> Result<Vec<f64>, Status>, "fmi3GetShiftDecimal";
        Err, get_shift_fraction(Vec<u32>) -> Result<Vec<IntervalFraction>, Status>, "fmi3GetShiftFraction";
        Status::from, set_interval_decimal(Vec<u32>, Vec<f64>) -> Status, "fmi3SetIntervalDecimal";
        Status::from, set_interval_fraction(Vec<u32>, Vec<IntervalFraction>) -> Status, "fmi3SetIntervalFraction";
        Status::from, set_shift_decimal(Vec<u32>, Vec<f64>) -> Status, "fmi3SetShiftDecimal";
        Status::from, set_shift_fraction(Vec<u32>, Vec<IntervalFraction>) -> Status, "fmi3SetShiftFraction";
        Status::from, evaluate_discrete_states() -> Status, "fmi3EvaluateDiscreteStates";
        Status::from, set_input_derivatives(Vec<(u32, u32)>, Vec<f64>) -> Status, "fmi3SetInputDerivatives";
        Err, get_output_derivatives(Vec<(u32, u32)>) -> Result<Vec<f64>, Status>, "fmi3GetOutputDerivatives";
    }
}

#[cfg(target_family = "wasm")]
mod bare {
    use alloc::alloc::{Layout, alloc, realloc};
    use core::ptr;

    #[global_allocator]
    static MEMORY: dlmalloc::GlobalDlmalloc = dlmalloc::GlobalDlmalloc;

    /// The target's core library expects it of a C library, as the only function of one.
    ///
    /// # Safety
    /// Both places have so many bytes.
    #[unsafe(no_mangle)]
    unsafe extern "C" fn memcmp(one: *const u8, other: *const u8, bytes: usize) -> i32 {
        for k in 0..bytes {
            // SAFETY: within both, as the caller promises.
            let (one, other) = unsafe { (*one.add(k), *other.add(k)) };
            if one != other {
                return i32::from(one) - i32::from(other);
            }
        }
        0
    }

    /// Memory for what the host hands over; wit-bindgen leaves it to the C library of this target, too.
    ///
    /// # Safety
    /// As the canonical interface calls it: a block of these bytes and this alignment, or none.
    #[unsafe(no_mangle)]
    unsafe extern "C" fn cabi_realloc(old: *mut u8, old_bytes: usize, align: usize, bytes: usize) -> *mut u8 {
        // SAFETY: the canonical interface gives powers of two, and what it has from here.
        let new = unsafe {
            match (old_bytes, bytes) {
                (0, 0) => ptr::without_provenance_mut(align),
                (0, _) => alloc(Layout::from_size_align_unchecked(bytes, align)),
                _ => realloc(old, Layout::from_size_align_unchecked(old_bytes, align), bytes),
            }
        };
        if new.is_null() { core::arch::wasm32::unreachable() } else { new }
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        core::arch::wasm32::unreachable()
    }
}
