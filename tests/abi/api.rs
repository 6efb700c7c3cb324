//! The 34 functions of a loaded library, with the types of `fmi2FunctionTypes.h`.

use libloading::Library;
use std::ffi::{CStr, c_char, c_void};
use std::path::Path;

pub(crate) type Component = *mut c_void;
pub(crate) type State = *mut c_void;
pub(crate) type Status = i32;

pub(crate) const OK: Status = 0;
pub(crate) const WARNING: Status = 1;
pub(crate) const DISCARD: Status = 2;
pub(crate) const ERROR: Status = 3;

/// `fmi2CallbackFunctions`; the logger's type is that of [`crate::unit`].
#[repr(C)]
pub(crate) struct Callbacks {
    pub(crate) logger: *const c_void,
    pub(crate) allocate_memory: *const c_void,
    pub(crate) free_memory: *const c_void,
    pub(crate) step_finished: *const c_void,
    pub(crate) environment: *mut c_void,
}

macro_rules! functions {
    ($($field:ident $name:literal ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// A loaded library and its functions.
        pub(crate) struct Api {
            $(pub(crate) $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            /// Last: the functions are gone with it.
            _library: Library,
        }

        /// Every C name.
        pub(crate) const NAMES: [&str; 34] = [$($name),*];

        impl Api {
            /// Loads a library and finds every function in it.
            pub(crate) fn load(path: &Path) -> Self {
                // SAFETY: a library of this project; it has no initializers.
                let library = unsafe { Library::new(path) }.expect("a library");
                // SAFETY: the types below are those of the official headers, which tests/importers
                // proves of the same rows, and `host.c` by calling through the headers.
                unsafe {
                    Self {
                        $($field: *library.get($name.as_bytes()).expect($name),)*
                        _library: library,
                    }
                }
            }
        }
    };
}

functions! {
    get_types_platform "fmi2GetTypesPlatform" () -> *const c_char;
    get_version "fmi2GetVersion" () -> *const c_char;
    set_debug_logging "fmi2SetDebugLogging" (Component, i32, usize, *const *const c_char) -> Status;
    instantiate "fmi2Instantiate" (*const c_char, i32, *const c_char, *const c_char, *const Callbacks, i32, i32) -> Component;
    free_instance "fmi2FreeInstance" (Component);
    setup_experiment "fmi2SetupExperiment" (Component, i32, f64, f64, i32, f64) -> Status;
    enter_initialization_mode "fmi2EnterInitializationMode" (Component) -> Status;
    exit_initialization_mode "fmi2ExitInitializationMode" (Component) -> Status;
    terminate "fmi2Terminate" (Component) -> Status;
    reset "fmi2Reset" (Component) -> Status;
    get_real "fmi2GetReal" (Component, *const u32, usize, *mut f64) -> Status;
    get_integer "fmi2GetInteger" (Component, *const u32, usize, *mut i32) -> Status;
    get_boolean "fmi2GetBoolean" (Component, *const u32, usize, *mut i32) -> Status;
    get_string "fmi2GetString" (Component, *const u32, usize, *mut *const c_char) -> Status;
    set_real "fmi2SetReal" (Component, *const u32, usize, *const f64) -> Status;
    set_integer "fmi2SetInteger" (Component, *const u32, usize, *const i32) -> Status;
    set_boolean "fmi2SetBoolean" (Component, *const u32, usize, *const i32) -> Status;
    set_string "fmi2SetString" (Component, *const u32, usize, *const *const c_char) -> Status;
    get_fmu_state "fmi2GetFMUstate" (Component, *mut State) -> Status;
    set_fmu_state "fmi2SetFMUstate" (Component, State) -> Status;
    free_fmu_state "fmi2FreeFMUstate" (Component, *mut State) -> Status;
    serialized_fmu_state_size "fmi2SerializedFMUstateSize" (Component, State, *mut usize) -> Status;
    serialize_fmu_state "fmi2SerializeFMUstate" (Component, State, *mut c_char, usize) -> Status;
    de_serialize_fmu_state "fmi2DeSerializeFMUstate" (Component, *const c_char, usize, *mut State) -> Status;
    get_directional_derivative "fmi2GetDirectionalDerivative" (Component, *const u32, usize, *const u32, usize, *const f64, *mut f64) -> Status;
    set_real_input_derivatives "fmi2SetRealInputDerivatives" (Component, *const u32, usize, *const i32, *const f64) -> Status;
    get_real_output_derivatives "fmi2GetRealOutputDerivatives" (Component, *const u32, usize, *const i32, *mut f64) -> Status;
    do_step "fmi2DoStep" (Component, f64, f64, i32) -> Status;
    cancel_step "fmi2CancelStep" (Component) -> Status;
    get_status "fmi2GetStatus" (Component, i32, *mut i32) -> Status;
    get_real_status "fmi2GetRealStatus" (Component, i32, *mut f64) -> Status;
    get_integer_status "fmi2GetIntegerStatus" (Component, i32, *mut i32) -> Status;
    get_boolean_status "fmi2GetBooleanStatus" (Component, i32, *mut i32) -> Status;
    get_string_status "fmi2GetStringStatus" (Component, i32, *mut *const c_char) -> Status;
}

/// The text of `fmi2GetVersion` or `fmi2GetTypesPlatform`.
pub(crate) fn text_of(function: unsafe extern "C" fn() -> *const c_char) -> &'static str {
    // SAFETY: the functions take nothing and return a constant string of the library, which the
    // tests keep loaded.
    unsafe { CStr::from_ptr(function()) }.to_str().unwrap()
}
