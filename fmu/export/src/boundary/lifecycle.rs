//! Creating, initializing and freeing instances.

use super::call;
use crate::arguments::{flag, string, strings};
use crate::calls::Call;
use crate::contain::{contain, silence_hook};
use crate::instance::Instance;
use crate::logger::{Category, Logger};
use crate::resources::Resources;
use crate::types::{CO_SIMULATION, CallbackFunctions, TYPES_PLATFORM, VERSION};
use crate::unit::CoSimulationUnit;
use crate::uri;
use std::ffi::{CStr, c_char, c_void};

/// `fmi2GetTypesPlatform`.
#[must_use]
pub fn get_types_platform() -> *const c_char {
    TYPES_PLATFORM.as_ptr()
}

/// `fmi2GetVersion`.
#[must_use]
pub fn get_version() -> *const c_char {
    VERSION.as_ptr()
}

/// `fmi2Instantiate`.
pub unsafe fn instantiate<S: CoSimulationUnit>(
    instance_name: *const c_char,
    fmu_type: i32,
    guid: *const c_char,
    resource_location: *const c_char,
    callbacks: *const CallbackFunctions,
    _visible: i32,
    logging_on: i32,
) -> *mut c_void {
    silence_hook();
    // SAFETY: null or strings of the importer, valid during this call; they are copied.
    let (name, guid, location) =
        unsafe { (string(instance_name), string(guid), string(resource_location)) };
    // SAFETY: null or a struct of the importer, valid during this call; it is copied.
    let callbacks = unsafe { callbacks.as_ref() };
    let logger = Logger::new(callbacks, name.unwrap_or_default(), logging_on != 0);
    let created = contain(|| create::<S>(name, fmu_type, guid, location, logger.clone()));
    let (category, problem) = match created {
        Ok(Ok(instance)) => return Box::into_raw(Box::new(instance)).cast(),
        Ok(Err(problem)) => (Category::Error, problem),
        Err(message) => (Category::Fatal, format!("the model panicked: {message}")),
    };
    logger.log(category, &format!("fmi2Instantiate: {problem}"));
    std::ptr::null_mut()
}

fn create<S: CoSimulationUnit>(
    name: Option<&CStr>,
    fmu_type: i32,
    guid: Option<&CStr>,
    location: Option<&CStr>,
    logger: Logger,
) -> Result<Instance<S>, String> {
    if name.is_none_or(|name| name.to_string_lossy().trim().is_empty()) {
        return Err("the instance has no name".into());
    }
    if fmu_type != CO_SIMULATION {
        return Err(format!("the FMU type is {fmu_type}; this FMU supports co-simulation only"));
    }
    let guid = guid.ok_or("the GUID is NULL")?;
    let resources = match location {
        None => Resources::default(),
        Some(location) => uri::folder(location.to_bytes())
            .and_then(|folder| Resources::read(&folder))
            .map_err(|error| error.to_string())?,
    };
    Instance::new(guid, &resources, logger)
}

/// `fmi2FreeInstance`.
pub unsafe fn free_instance<S: CoSimulationUnit>(component: *mut c_void) {
    if component.is_null() {
        return;
    }
    let instance = component.cast::<Instance<S>>();
    // SAFETY: created by `Box::into_raw` in `instantiate`, and not used afterwards.
    let instance = unsafe { Box::from_raw(instance) };
    // A panic of a destructor cannot be reported any more.
    let _ = contain(|| drop(instance));
}

/// `fmi2SetDebugLogging`.
pub unsafe fn set_debug_logging<S: CoSimulationUnit>(
    component: *mut c_void,
    logging_on: i32,
    length: usize,
    categories: *const *const c_char,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        let on = flag(logging_on, "loggingOn")?;
        // SAFETY: the module's contract.
        let categories = unsafe { strings(categories, length, "categories")? };
        let categories: Option<Vec<&CStr>> = categories.into_iter().collect();
        instance.set_debug_logging(on, &categories.ok_or("a category is NULL")?)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetDebugLogging, body) }
}

/// `fmi2SetupExperiment`.
pub unsafe fn setup_experiment<S: CoSimulationUnit>(
    component: *mut c_void,
    tolerance_defined: i32,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: i32,
    stop_time: f64,
) -> i32 {
    let body = |instance: &mut Instance<S>| {
        let tolerance =
            if flag(tolerance_defined, "toleranceDefined")? { Some(tolerance) } else { None };
        let stop_time =
            if flag(stop_time_defined, "stopTimeDefined")? { Some(stop_time) } else { None };
        instance.setup_experiment(tolerance, start_time, stop_time)
    };
    // SAFETY: the module's contract.
    unsafe { call(component, Call::SetupExperiment, body) }
}

/// `fmi2EnterInitializationMode`.
pub unsafe fn enter_initialization_mode<S: CoSimulationUnit>(component: *mut c_void) -> i32 {
    let body = Instance::<S>::enter_initialization_mode;
    // SAFETY: the module's contract.
    unsafe { call(component, Call::EnterInitializationMode, body) }
}

/// `fmi2ExitInitializationMode`.
pub unsafe fn exit_initialization_mode<S: CoSimulationUnit>(component: *mut c_void) -> i32 {
    let body = Instance::<S>::exit_initialization_mode;
    // SAFETY: the module's contract.
    unsafe { call(component, Call::ExitInitializationMode, body) }
}

/// `fmi2Terminate`.
pub unsafe fn terminate<S: CoSimulationUnit>(component: *mut c_void) -> i32 {
    // SAFETY: the module's contract.
    unsafe { call(component, Call::Terminate, Instance::<S>::terminate) }
}

/// `fmi2Reset`.
pub unsafe fn reset<S: CoSimulationUnit>(component: *mut c_void) -> i32 {
    // SAFETY: the module's contract.
    unsafe { call(component, Call::Reset, Instance::<S>::reset) }
}
