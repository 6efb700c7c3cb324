//! The C types of FMI 2.0 (`fmi2TypesPlatform.h`, `fmi2FunctionTypes.h`), signatures of its functions.
//!
//! Function pointers are `unsafe extern "C"`: whether a call is sound is known to the caller alone.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem::MaybeUninit;

/// `fmi2Component`: the pointer of an instance.
pub(crate) type Component = *mut c_void;
/// `fmi2FMUstate`: the pointer of a saved state.
pub(crate) type FmuStatePointer = *mut c_void;
/// `fmi2Status`, unchecked: an FMU may return any number.
pub(crate) type RawStatus = c_int;
/// `fmi2Boolean`: 0 or 1.
pub(crate) type Boolean = c_int;
/// `fmi2ValueReference`.
pub(crate) type Reference = c_uint;

/// `fmi2False`.
pub(crate) const FALSE: Boolean = 0;
/// `fmi2CoSimulation` of `fmi2Type`.
pub(crate) const CO_SIMULATION: c_int = 1;

/// `fmi2LastSuccessfulTime` and `fmi2Terminated` of `fmi2StatusKind`.
pub(crate) const LAST_SUCCESSFUL_TIME: c_int = 2;
pub(crate) const TERMINATED: c_int = 3;

/// `fmi2CallbackLogger`, declared here with fixed parameters; see [`crate::log`] for why.
pub(crate) type Logger = unsafe extern "C" fn(
    environment: *mut c_void,
    instance: *const c_char,
    status: RawStatus,
    category: *const c_char,
    message: *const c_char,
    first_variadic: MaybeUninit<*const c_char>,
);

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub(crate) struct CallbackFunctions {
    pub(crate) logger: Option<Logger>,
    pub(crate) allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    pub(crate) free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    pub(crate) step_finished: Option<unsafe extern "C" fn(*mut c_void, RawStatus)>,
    pub(crate) component_environment: *mut c_void,
}

pub(crate) type GetText = unsafe extern "C" fn() -> *const c_char;
pub(crate) type SetDebugLogging =
    unsafe extern "C" fn(Component, Boolean, usize, *const *const c_char) -> RawStatus;
pub(crate) type Instantiate = unsafe extern "C" fn(
    name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const CallbackFunctions,
    visible: Boolean,
    logging_on: Boolean,
) -> Component;
pub(crate) type FreeInstance = unsafe extern "C" fn(Component);
pub(crate) type SetupExperiment = unsafe extern "C" fn(
    Component,
    tolerance_defined: Boolean,
    tolerance: f64,
    start: f64,
    stop_defined: Boolean,
    stop: f64,
) -> RawStatus;
/// EnterInitializationMode, ExitInitializationMode, Terminate, Reset, CancelStep.
pub(crate) type Simple = unsafe extern "C" fn(Component) -> RawStatus;
pub(crate) type Get<T> =
    unsafe extern "C" fn(Component, *const Reference, usize, *mut T) -> RawStatus;
pub(crate) type Set<T> =
    unsafe extern "C" fn(Component, *const Reference, usize, *const T) -> RawStatus;
/// GetFMUstate and FreeFMUstate.
pub(crate) type StateByAddress = unsafe extern "C" fn(Component, *mut FmuStatePointer) -> RawStatus;
pub(crate) type SetState = unsafe extern "C" fn(Component, FmuStatePointer) -> RawStatus;
pub(crate) type SerializedSize =
    unsafe extern "C" fn(Component, FmuStatePointer, *mut usize) -> RawStatus;
pub(crate) type Serialize =
    unsafe extern "C" fn(Component, FmuStatePointer, *mut c_char, usize) -> RawStatus;
pub(crate) type DeSerialize =
    unsafe extern "C" fn(Component, *const c_char, usize, *mut FmuStatePointer) -> RawStatus;
pub(crate) type DirectionalDerivative = unsafe extern "C" fn(
    Component,
    unknown: *const Reference,
    unknowns: usize,
    known: *const Reference,
    knowns: usize,
    known_change: *const f64,
    unknown_change: *mut f64,
) -> RawStatus;
pub(crate) type SetDerivatives =
    unsafe extern "C" fn(Component, *const Reference, usize, *const c_int, *const f64) -> RawStatus;
pub(crate) type GetDerivatives =
    unsafe extern "C" fn(Component, *const Reference, usize, *const c_int, *mut f64) -> RawStatus;
pub(crate) type DoStep =
    unsafe extern "C" fn(Component, time: f64, step: f64, no_set_prior: Boolean) -> RawStatus;
/// GetStatus, GetRealStatus, GetIntegerStatus, GetBooleanStatus, GetStringStatus.
pub(crate) type GetStatus<T> = unsafe extern "C" fn(Component, c_int, *mut T) -> RawStatus;

/// `fmi2Status`, the result of an FMI 2.0 function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// No problem.
    Ok,
    /// A problem that does not stop the computation.
    Warning,
    /// The step or the value is refused.
    Discard,
    /// The instance cannot continue.
    Error,
    /// No instance of the FMU can continue.
    Fatal,
    /// The step is carried out asynchronously.
    Pending,
    /// A number that FMI 2.0 does not define.
    Undefined(i32),
}

impl Status {
    pub(crate) fn from_raw(raw: RawStatus) -> Self {
        match raw {
            0 => Self::Ok,
            1 => Self::Warning,
            2 => Self::Discard,
            3 => Self::Error,
            4 => Self::Fatal,
            5 => Self::Pending,
            other => Self::Undefined(other),
        }
    }
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Ok => f.write_str("ok"),
            Self::Warning => f.write_str("warning"),
            Self::Discard => f.write_str("discard"),
            Self::Error => f.write_str("error"),
            Self::Fatal => f.write_str("fatal"),
            Self::Pending => f.write_str("pending"),
            Self::Undefined(number) => write!(f, "status {number}, which FMI 2.0 does not define"),
        }
    }
}
