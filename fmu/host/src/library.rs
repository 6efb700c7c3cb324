//! The shared library of an FMU, with all its functions resolved.
//!
//! A library is loaded once an archive and shared by the archive's instances. A missing function is
//! found here, by name, and not in the middle of a simulation: FMI 2.0 requires all 34 even where a
//! capability is absent.

#![allow(unsafe_code)]

use std::ffi::CStr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::Error;
use crate::c_types::{
    Boolean, DeSerialize, DirectionalDerivative, DoStep, FreeInstance, Get, GetDerivatives,
    GetStatus, GetText, Instantiate, RawStatus, Serialize, SerializedSize, Set, SetDebugLogging,
    SetDerivatives, SetState, SetupExperiment, Simple, StateByAddress,
};
use crate::error::LIBPYTHON;

/// Declares [`Functions`] and its loading from one list of field, C name and type.
macro_rules! functions {
    ($($field:ident : $symbol:literal => $kind:ty,)*) => {
        /// The resolved functions. Each is valid as long as its [`Library`] is loaded.
        // Some are resolved only to prove that they are there.
        #[allow(dead_code)]
        pub(crate) struct Functions { $(pub(crate) $field: $kind,)* }

        /// The names of the functions that FMI 2.0 requires of a co-simulation binary.
        pub const FUNCTION_NAMES: &[&str] = &[$($symbol),*];

        impl Functions {
            fn resolve(library: &libloading::Library, path: &Path) -> Result<Self, Error> {
                let mut missing = Vec::new();
                $(
                    // SAFETY: the type is that of the FMI 2.0 header for this symbol name; a
                    // binary that uses the name for something else is not an FMU, which cannot
                    // be seen from outside.
                    let $field = unsafe { library.get::<$kind>($symbol) }.ok().map(|f| *f);
                    if $field.is_none() {
                        missing.push($symbol);
                    }
                )*
                let ($(Some($field),)*) = ($($field,)*) else {
                    return Err(Error::MissingFunctions { path: path.to_path_buf(), missing });
                };
                Ok(Self { $($field,)* })
            }
        }
    };
}

functions! {
    get_types_platform: "fmi2GetTypesPlatform" => GetText,
    get_version: "fmi2GetVersion" => GetText,
    set_debug_logging: "fmi2SetDebugLogging" => SetDebugLogging,
    instantiate: "fmi2Instantiate" => Instantiate,
    free_instance: "fmi2FreeInstance" => FreeInstance,
    setup_experiment: "fmi2SetupExperiment" => SetupExperiment,
    enter_initialization_mode: "fmi2EnterInitializationMode" => Simple,
    exit_initialization_mode: "fmi2ExitInitializationMode" => Simple,
    terminate: "fmi2Terminate" => Simple,
    reset: "fmi2Reset" => Simple,
    get_real: "fmi2GetReal" => Get<f64>,
    get_integer: "fmi2GetInteger" => Get<i32>,
    get_boolean: "fmi2GetBoolean" => Get<Boolean>,
    get_string: "fmi2GetString" => Get<*const std::ffi::c_char>,
    set_real: "fmi2SetReal" => Set<f64>,
    set_integer: "fmi2SetInteger" => Set<i32>,
    set_boolean: "fmi2SetBoolean" => Set<Boolean>,
    set_string: "fmi2SetString" => Set<*const std::ffi::c_char>,
    get_fmu_state: "fmi2GetFMUstate" => StateByAddress,
    set_fmu_state: "fmi2SetFMUstate" => SetState,
    free_fmu_state: "fmi2FreeFMUstate" => StateByAddress,
    serialized_fmu_state_size: "fmi2SerializedFMUstateSize" => SerializedSize,
    serialize_fmu_state: "fmi2SerializeFMUstate" => Serialize,
    de_serialize_fmu_state: "fmi2DeSerializeFMUstate" => DeSerialize,
    get_directional_derivative: "fmi2GetDirectionalDerivative" => DirectionalDerivative,
    set_real_input_derivatives: "fmi2SetRealInputDerivatives" => SetDerivatives,
    get_real_output_derivatives: "fmi2GetRealOutputDerivatives" => GetDerivatives,
    do_step: "fmi2DoStep" => DoStep,
    cancel_step: "fmi2CancelStep" => Simple,
    get_status: "fmi2GetStatus" => GetStatus<RawStatus>,
    get_real_status: "fmi2GetRealStatus" => GetStatus<f64>,
    get_integer_status: "fmi2GetIntegerStatus" => GetStatus<i32>,
    get_boolean_status: "fmi2GetBooleanStatus" => GetStatus<Boolean>,
    get_string_status: "fmi2GetStringStatus" => GetStatus<*const std::ffi::c_char>,
}

/// A loaded binary. Dropped, it is unloaded, unless one of its instances ended in `fmi2Fatal`:
/// then nothing of it may run any more, not even its unloading code, and it stays in memory.
pub(crate) struct Library {
    pub(crate) functions: Functions,
    /// `None` only while being dropped.
    library: Option<libloading::Library>,
    fatal: AtomicBool,
    instances: AtomicUsize,
}

impl Library {
    /// Loads the binary at `path` and reads its FMI version and types.
    pub(crate) fn load(path: &Path) -> Result<Self, Error> {
        let load_error =
            |e: libloading::Error| Error::Load { path: path.to_path_buf(), reason: reason(&e) };
        // SAFETY: loading runs the library's initialisation code. That is what opening an FMU is:
        // whoever opens an archive trusts its binary, as the documentation of `Archive` states.
        let library = unsafe { open(path) }.map_err(load_error)?;
        let functions = Functions::resolve(&library, path)?;
        for (what, function, expected) in [
            ("fmi2GetVersion", functions.get_version, "2.0"),
            ("fmi2GetTypesPlatform", functions.get_types_platform, "default"),
        ] {
            // SAFETY: both functions may be called at any time and take nothing; they return a
            // C string constant or, in a broken FMU, NULL, which is checked.
            let got = unsafe {
                let text = function();
                if text.is_null() { None } else { Some(CStr::from_ptr(text)) }
            };
            let got = got.map(|text| text.to_string_lossy().into_owned());
            if got.as_deref() != Some(expected) {
                let (path, got) = (path.to_path_buf(), got.unwrap_or_else(|| "NULL".to_owned()));
                return Err(Error::WrongVersion { path, function: what, got, expected });
            }
        }
        Ok(Self {
            functions,
            library: Some(library),
            fatal: AtomicBool::new(false),
            instances: AtomicUsize::new(0),
        })
    }

    /// Frees no instance at all: the standard has NULL ignored.
    pub(crate) fn free_null(&self) {
        // SAFETY: `fmi2FreeInstance` takes NULL at any time (FMI 2.0.5, 2.1.5).
        unsafe { (self.functions.free_instance)(std::ptr::null_mut()) };
    }

    /// Marks the binary as unusable: an instance of it returned `fmi2Fatal`.
    pub(crate) fn set_fatal(&self) {
        self.fatal.store(true, Ordering::Release);
    }

    /// Whether an instance of the binary returned `fmi2Fatal`.
    pub(crate) fn is_fatal(&self) -> bool {
        self.fatal.load(Ordering::Acquire)
    }

    /// The number of living instances; see `canBeInstantiatedOnlyOncePerProcess`.
    pub(crate) fn instances(&self) -> &AtomicUsize {
        &self.instances
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        if self.is_fatal() {
            std::mem::forget(self.library.take());
        }
    }
}

/// All symbols of the binary and of its dependencies are bound now (a missing one is an error here,
/// not a crash later), and none of them is visible to other libraries: two FMUs export the same
/// names.
#[cfg(unix)]
unsafe fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::unix;
    // SAFETY: the caller's, see above.
    unsafe { unix::Library::open(Some(path.as_os_str()), unix::RTLD_NOW | unix::RTLD_LOCAL) }
        .map(Into::into)
}

/// Libraries in the binary's folder are found by it.
#[cfg(windows)]
unsafe fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows;
    // SAFETY: the caller's, see above.
    unsafe {
        windows::Library::load_with_flags(path.as_os_str(), windows::LOAD_WITH_ALTERED_SEARCH_PATH)
    }
    .map(Into::into)
}

/// libloading keeps the system's message in the error's source.
fn reason(error: &libloading::Error) -> String {
    let text = match std::error::Error::source(error) {
        Some(source) => format!("{error}: {source}"),
        None => error.to_string(),
    };
    match undefined_of_python(&text) {
        Some(symbol) => {
            format!("{text}; {symbol} is of {LIBPYTHON}, which the binary does not load itself")
        }
        None => text,
    }
}

/// The symbol of Python's C interface that a message of the loader names as undefined.
fn undefined_of_python(message: &str) -> Option<&str> {
    let (_, after) = message.split_once("symbol")?;
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    after.split(|c| !is_part(c)).find(|word| {
        // On macOS C names begin with another underscore.
        let name = word.trim_start_matches('_').strip_prefix("Py");
        name.and_then(|rest| rest.chars().next()).is_some_and(|c| c == '_' || c.is_uppercase())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_of_python_are_recognized() {
        for (message, symbol) in [
            ("/tmp/Pyramid.so: undefined symbol: PyExc_ValueError", Some("PyExc_ValueError")),
            ("a.so: undefined symbol: _Py_NoneStruct", Some("_Py_NoneStruct")),
            ("symbol not found in flat namespace '_Py_Initialize'", Some("_Py_Initialize")),
            ("Pyramid.so: undefined symbol: pyramid", None),
            ("undefined symbol: Pyramid_of", None),
            ("PyA.so: no such file", None),
        ] {
            assert_eq!(undefined_of_python(message), symbol, "{message}");
        }
    }
}
