//! A component that is NULL: an error, or ignored, and never a crash.

use crate::api::{ERROR, Status};
use crate::samples::samples;
use std::ptr::{null, null_mut};

#[test]
fn every_function_survives_a_null_component() {
    for sample in samples() {
        let api = &sample.api;
        let c = null_mut();
        let (mut real, mut integer, mut text, mut size) = (0.0, 0, null(), 0);
        let (reference, state) = (0, &mut null_mut());
        // SAFETY: null is an error to each function; the other arguments are good.
        let statuses: [Status; 30] = unsafe {
            [
                (api.set_debug_logging)(c, 0, 0, null()),
                (api.setup_experiment)(c, 0, 0.0, 0.0, 0, 0.0),
                (api.enter_initialization_mode)(c),
                (api.exit_initialization_mode)(c),
                (api.terminate)(c),
                (api.reset)(c),
                (api.get_real)(c, &reference, 1, &mut real),
                (api.get_integer)(c, &reference, 1, &mut integer),
                (api.get_boolean)(c, &reference, 1, &mut integer),
                (api.get_string)(c, &reference, 1, &mut text),
                (api.set_real)(c, &reference, 1, &real),
                (api.set_integer)(c, &reference, 1, &integer),
                (api.set_boolean)(c, &reference, 1, &integer),
                (api.set_string)(c, &reference, 1, &c"".as_ptr()),
                (api.get_fmu_state)(c, state),
                (api.set_fmu_state)(c, *state),
                (api.free_fmu_state)(c, state),
                (api.serialized_fmu_state_size)(c, *state, &mut size),
                (api.serialize_fmu_state)(c, *state, null_mut(), 0),
                (api.de_serialize_fmu_state)(c, null(), 0, state),
                (api.get_directional_derivative)(c, null(), 0, null(), 0, null(), null_mut()),
                (api.set_real_input_derivatives)(c, null(), 0, null(), null()),
                (api.get_real_output_derivatives)(c, null(), 0, null(), null_mut()),
                (api.do_step)(c, 0.0, 0.01, 1),
                (api.cancel_step)(c),
                (api.get_status)(c, 0, &mut integer),
                (api.get_real_status)(c, 2, &mut real),
                (api.get_integer_status)(c, 0, &mut integer),
                (api.get_boolean_status)(c, 3, &mut integer),
                (api.get_string_status)(c, 1, &mut text),
            ]
        };
        assert_eq!(statuses, [ERROR; 30], "{}", sample.name());
        // SAFETY: null is ignored.
        unsafe { (api.free_instance)(c) };
    }
}
