//! The C types of `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`, platform "default".
//!
//! `fmi2Real` is `f64`; `fmi2Integer`, `fmi2Boolean` and the enumerations an importer passes are
//! `i32` (a C enumeration may hold any `int`, a Rust enum may not); `fmi2ValueReference` is `u32`;
//! `fmi2String` is `*const c_char`; components and FMU states are `*mut c_void`.

use std::ffi::{c_char, c_void};

/// The value that `fmi2GetTypesPlatform` returns.
pub const TYPES_PLATFORM: &std::ffi::CStr = c"default";
/// The value that `fmi2GetVersion` returns.
pub const VERSION: &std::ffi::CStr = c"2.0";

/// `fmi2CoSimulation` of `fmi2Type`; 0 is model exchange.
pub const CO_SIMULATION: i32 = 1;

/// `fmi2LastSuccessfulTime` of `fmi2StatusKind` (0 `fmi2DoStepStatus`, 1 `fmi2PendingStatus`).
pub const LAST_SUCCESSFUL_TIME: i32 = 2;
/// `fmi2Terminated` of `fmi2StatusKind`.
pub const TERMINATED: i32 = 3;

/// `fmi2Status`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// The call succeeded.
    Ok = 0,
    /// The call succeeded with a warning; the simulation can continue.
    Warning = 1,
    /// The requested status does not exist.
    Discard = 2,
    /// The call failed; the instance is in the error state.
    Error = 3,
    /// The instance is unusable.
    Fatal = 4,
}

/// `fmi2CallbackLogger`. The message is a `printf` format.
pub type LoggerFunction = unsafe extern "C" fn(
    environment: *mut c_void,
    instance_name: *const c_char,
    status: i32,
    category: *const c_char,
    message: *const c_char,
    ...
);

/// `fmi2CallbackFunctions`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct CallbackFunctions {
    /// Receives log messages.
    pub logger: Option<LoggerFunction>,
    /// Not used: `canNotUseMemoryManagementFunctions` is true.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used: no step is asynchronous.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, i32)>,
    /// Passed to the logger.
    pub component_environment: *mut c_void,
}
