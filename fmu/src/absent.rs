//! The functions of FMI 2.0 and 3.0 that this FMU does not offer: those of types that no variable has, of
//! optional features, of other interface types, and of statuses that there are not. Each is refused and
//! logged.
//!
//! They look at the first arguments only, which under these calling conventions are all that they need to
//! declare.
//!
//! # Safety of all functions here
//! The instance is as [`Handle::given`] asks, still. No other pointer is followed.
#![allow(non_snake_case)] // the standard's names
#![allow(clippy::missing_safety_doc)] // said once, above

use crate::calls::{Handle, pass};
use crate::log::Status;
use crate::operations::{get_none, get_none_in_2, no_status, set_none, unsupported};

macro_rules! of_no_variable {
    ($answer:path; $($name:ident)*) => {$(
        /// No variable has this type: reading or writing none is fine, any is not.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: Handle, _vr: *const u32, count: usize) -> Status {
            pass(instance, |instance| $answer(instance, stringify!($name), count))
        }
    )*};
}

of_no_variable! { get_none_in_2; fmi2GetString }

of_no_variable! { get_none;
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetUInt32 fmi3GetUInt64
    fmi3GetString fmi3GetBinary fmi3GetClock
}

of_no_variable! { set_none;
    fmi2SetString
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetUInt32 fmi3SetUInt64
    fmi3SetString fmi3SetBinary fmi3SetClock
}

macro_rules! not_offered {
    ($answer:path; $($name:ident)*) => {$(
        /// Not offered.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: Handle) -> Status {
            pass(instance, |instance| $answer(instance, stringify!($name)))
        }
    )*};
}

not_offered! { no_status; fmi2GetIntegerStatus fmi2GetStringStatus }

// The acceleration is an input variable, so that no derivatives of inputs are needed; nothing runs in the
// background.
not_offered! { unsupported;
    fmi2GetDirectionalDerivative fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives fmi2CancelStep
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies fmi3GetDirectionalDerivative fmi3GetAdjointDerivative
    fmi3EnterConfigurationMode fmi3ExitConfigurationMode
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3EvaluateDiscreteStates fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep
    fmi3SetTime fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators
    fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators
    fmi3GetNumberOfContinuousStates fmi3GetOutputDerivatives fmi3ActivateModelPartition
}
