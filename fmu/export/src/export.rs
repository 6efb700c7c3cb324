//! The macro that exports the functions of the boundary under their C names.

/// Exports the 34 functions of FMI 2.0 for Co-Simulation for one [`CoSimulationUnit`](crate::CoSimulationUnit).
///
/// Use it once in a library of crate type `cdylib`. Two libraries that use it cannot be linked into
/// one binary, since they export the same symbols.
#[macro_export]
macro_rules! export {
    ($unit:ty) => {
        // An unnamed constant hides the items from the caller's scope and sees its names.
        #[allow(unsafe_code, non_snake_case, clippy::missing_safety_doc)]
        const _: () = {
            use ::std::ffi::{c_char, c_void};
            use ::std::primitive::{f64, i32, u32, usize};
            use $crate::boundary as layer;

            type Exported = $unit;

            $crate::__export! {
                fmi2SetDebugLogging => set_debug_logging(on: i32, n: usize, names: *const *const c_char);
                fmi2SetupExperiment => setup_experiment(tolerance_defined: i32, tolerance: f64, start: f64, stop_defined: i32, stop: f64);
                fmi2EnterInitializationMode => enter_initialization_mode();
                fmi2ExitInitializationMode => exit_initialization_mode();
                fmi2Terminate => terminate();
                fmi2Reset => reset();
                fmi2GetReal => get_real(r: *const u32, n: usize, v: *mut f64);
                fmi2GetInteger => get_integer(r: *const u32, n: usize, v: *mut i32);
                fmi2GetBoolean => get_boolean(r: *const u32, n: usize, v: *mut i32);
                fmi2GetString => get_string(r: *const u32, n: usize, v: *mut *const c_char);
                fmi2SetReal => set_real(r: *const u32, n: usize, v: *const f64);
                fmi2SetInteger => set_integer(r: *const u32, n: usize, v: *const i32);
                fmi2SetBoolean => set_boolean(r: *const u32, n: usize, v: *const i32);
                fmi2SetString => set_string(r: *const u32, n: usize, v: *const *const c_char);
                fmi2GetFMUstate => get_fmu_state(state: *mut *mut c_void);
                fmi2SetFMUstate => set_fmu_state(state: *mut c_void);
                fmi2FreeFMUstate => free_fmu_state(state: *mut *mut c_void);
                fmi2SerializedFMUstateSize => serialized_fmu_state_size(state: *mut c_void, size: *mut usize);
                fmi2SerializeFMUstate => serialize_fmu_state(state: *mut c_void, bytes: *mut c_char, size: usize);
                fmi2DeSerializeFMUstate => de_serialize_fmu_state(bytes: *const c_char, size: usize, state: *mut *mut c_void);
                fmi2GetDirectionalDerivative => get_directional_derivative(unknowns: *const u32, unknown_count: usize, knowns: *const u32, known_count: usize, seed: *const f64, sensitivity: *mut f64);
                fmi2SetRealInputDerivatives => set_real_input_derivatives(r: *const u32, n: usize, orders: *const i32, v: *const f64);
                fmi2GetRealOutputDerivatives => get_real_output_derivatives(r: *const u32, n: usize, orders: *const i32, v: *mut f64);
                fmi2DoStep => do_step(time: f64, step: f64, no_set_state: i32);
                fmi2CancelStep => cancel_step();
                fmi2GetStatus => get_status(kind: i32, v: *mut i32);
                fmi2GetRealStatus => get_real_status(kind: i32, v: *mut f64);
                fmi2GetIntegerStatus => get_integer_status(kind: i32, v: *mut i32);
                fmi2GetBooleanStatus => get_boolean_status(kind: i32, v: *mut i32);
                fmi2GetStringStatus => get_string_status(kind: i32, v: *mut *const c_char);
            }

            #[unsafe(no_mangle)]
            extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
                layer::get_types_platform()
            }

            #[unsafe(no_mangle)]
            extern "C" fn fmi2GetVersion() -> *const c_char {
                layer::get_version()
            }

            #[unsafe(no_mangle)]
            unsafe extern "C" fn fmi2Instantiate(
                name: *const c_char,
                fmu_type: i32,
                guid: *const c_char,
                location: *const c_char,
                callbacks: *const $crate::types::CallbackFunctions,
                visible: i32,
                logging_on: i32,
            ) -> *mut c_void {
                // SAFETY: the standard's contract with the importer, passed on.
                unsafe {
                    layer::instantiate::<Exported>(
                        name, fmu_type, guid, location, callbacks, visible, logging_on,
                    )
                }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C" fn fmi2FreeInstance(component: *mut c_void) {
                // SAFETY: the standard's contract with the importer, passed on.
                unsafe { layer::free_instance::<Exported>(component) }
            }
        };
    };
}

/// The one-line exports of [`export!`].
#[doc(hidden)]
#[macro_export]
macro_rules! __export {
    ($($symbol:ident => $function:ident($($argument:ident: $kind:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $symbol(component: *mut c_void, $($argument: $kind),*) -> i32 {
            // SAFETY: the standard's contract with the importer, passed on.
            unsafe { layer::$function::<Exported>(component, $($argument),*) }
        }
    )*};
}
