//! An importer for tests: records the log and frees its instances.

use super::probe::{FAULT, GAIN, N, ON, Probe, TABLE, U, Y};
use crate::boundary as c;
use crate::calls::{Call, State};
use crate::instance::Instance;
use crate::types::{CallbackFunctions, LoggerFunction};
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};

pub(super) const OK: i32 = 0;
pub(super) const WARNING: i32 = 1;
pub(super) const DISCARD: i32 = 2;
pub(super) const ERROR: i32 = 3;
pub(super) const FATAL: i32 = 4;

/// All states but fatal, each with its letter in the tables of the tests.
pub(super) const STATES: [(State, char); 5] = [
    (State::Instantiated, 'I'),
    (State::Initialization, 'M'),
    (State::StepComplete, 'C'),
    (State::Terminated, 'T'),
    (State::Error, 'E'),
];

/// A line of the log: instance, status, category, text.
pub(super) type Line = (String, i32, String, String);
pub(super) type Lines = RefCell<Vec<Line>>;

/// The logger of an importer, for the only format used.
///
/// SAFETY: as the standard's logger; called with "%s" and one string, which the C calling
/// conventions of the test platforms pass like a sixth fixed argument.
unsafe extern "C" fn collect(
    environment: *mut c_void,
    name: *const c_char,
    status: i32,
    category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    // SAFETY: all strings are those of the layer; the environment is the `Lines` of a `Host`.
    unsafe {
        assert_eq!(CStr::from_ptr(format), c"%s");
        let string = |pointer| CStr::from_ptr(pointer).to_str().unwrap().to_owned();
        let line = (string(name), status, string(category), string(text));
        (*environment.cast::<Lines>()).borrow_mut().push(line);
    }
}

pub(super) fn callbacks(lines: &Lines) -> CallbackFunctions {
    // SAFETY: see `collect`.
    let logger = unsafe {
        std::mem::transmute::<
            unsafe extern "C" fn(
                *mut c_void,
                *const c_char,
                i32,
                *const c_char,
                *const c_char,
                *const c_char,
            ),
            LoggerFunction,
        >(collect)
    };
    CallbackFunctions {
        logger: Some(logger),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: std::ptr::from_ref(lines).cast_mut().cast(),
    }
}

pub(super) fn guid() -> CString {
    CString::new(model_description::guid(&TABLE, &[])).unwrap()
}

/// One instance of the probe.
pub(super) struct Host {
    pub(super) component: *mut c_void,
    lines: Box<Lines>,
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: created by `Host::new`, freed once.
        unsafe { c::free_instance::<Probe>(self.component) }
    }
}

/// Calls a function of the boundary on the host's instance.
macro_rules! call {
    ($host:expr, $function:ident($($argument:expr),*)) => {{
        let component = $host.component;
        // SAFETY: a live instance of the probe, arguments as the test requires.
        unsafe { crate::boundary::$function::<crate::tests::probe::Probe>(component, $($argument),*) }
    }};
}
pub(super) use call;

impl Host {
    pub(super) fn new(logging_on: bool) -> Self {
        let lines = Box::new(Lines::default());
        let callbacks = callbacks(&lines);
        // SAFETY: valid strings and callbacks; these do not outlive the call.
        let component = unsafe {
            c::instantiate::<Probe>(
                c"probe".as_ptr(),
                1,
                guid().as_ptr(),
                null(),
                &callbacks,
                0,
                i32::from(logging_on),
            )
        };
        assert!(!component.is_null(), "{lines:?}");
        Self { component, lines }
    }

    /// A host with a null component.
    pub(super) fn null() -> Self {
        Self { component: null_mut(), lines: Box::default() }
    }

    /// An instance in a state, reached by legal calls or a fault.
    pub(super) fn in_state(state: State) -> Self {
        let host = Self::new(false);
        let initialize = || {
            assert_eq!(call!(host, setup_experiment(0, 0.0, 0.0, 0, 0.0)), OK);
            assert_eq!(call!(host, enter_initialization_mode()), OK);
        };
        let step = || {
            initialize();
            assert_eq!(call!(host, exit_initialization_mode()), OK);
        };
        match state {
            State::Instantiated => {}
            State::Initialization => initialize(),
            State::StepComplete => step(),
            State::Terminated => {
                step();
                assert_eq!(call!(host, terminate()), OK);
            }
            State::Error => {
                step();
                assert_eq!(host.do_step(0.0, -1.0), ERROR);
            }
            State::Fatal => {
                assert_eq!(host.set_integer(FAULT, super::probe::PANIC_IN_SET), FATAL);
            }
        }
        assert_eq!(host.state(), state);
        host.take_lines();
        host
    }

    pub(super) fn state(&self) -> State {
        // SAFETY: a live instance of the probe.
        unsafe { (*self.component.cast::<Instance<Probe>>()).core.state }
    }

    pub(super) fn take_lines(&self) -> Vec<Line> {
        self.lines.take()
    }

    pub(super) fn do_step(&self, time: f64, step: f64) -> i32 {
        call!(self, do_step(time, step, 1))
    }

    pub(super) fn set_real(&self, reference: u32, value: f64) -> i32 {
        call!(self, set_real(&reference, 1, &value))
    }

    pub(super) fn set_integer(&self, reference: u32, value: i32) -> i32 {
        call!(self, set_integer(&reference, 1, &value))
    }

    pub(super) fn set_boolean(&self, reference: u32, value: i32) -> i32 {
        call!(self, set_boolean(&reference, 1, &value))
    }

    pub(super) fn real(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(call!(self, get_real(&reference, 1, &mut value)), OK);
        value
    }

    pub(super) fn integer(&self, reference: u32) -> i32 {
        let mut value = i32::MIN;
        assert_eq!(call!(self, get_integer(&reference, 1, &mut value)), OK);
        value
    }

    /// All settable numbers, read directly from the unit.
    pub(super) fn values(&self) -> [f64; 5] {
        use crate::unit::{CoSimulationUnit, VariableId};
        // SAFETY: a live instance of the probe.
        let instance = unsafe { &mut *self.component.cast::<Instance<Probe>>() };
        [U, GAIN, Y, N, ON].map(|reference| {
            let variable =
                <Probe as CoSimulationUnit>::Variable::from_reference(reference).unwrap();
            match instance.core.unit.get(variable) {
                model_description::Value::Boolean(value) => f64::from(u8::from(value)),
                value => value.as_number().unwrap(),
            }
        })
    }

    /// Makes a call with arguments that are valid in every state in which the call is legal.
    pub(super) fn make(&self, which: Call) -> i32 {
        let mut real = 0.5;
        let mut integer = 1;
        let mut text = c"text".as_ptr();
        let mut state = null_mut();
        let mut size = 0_usize;
        match which {
            Call::SetDebugLogging => call!(self, set_debug_logging(0, 0, null())),
            Call::SetupExperiment => call!(self, setup_experiment(0, 0.0, 0.0, 0, 0.0)),
            Call::EnterInitializationMode => {
                if !self.component.is_null() && self.state() == State::Instantiated {
                    call!(self, setup_experiment(0, 0.0, 0.0, 0, 0.0));
                }
                call!(self, enter_initialization_mode())
            }
            Call::ExitInitializationMode => call!(self, exit_initialization_mode()),
            Call::Terminate => call!(self, terminate()),
            Call::Reset => call!(self, reset()),
            Call::GetReal => call!(self, get_real(&Y, 1, &mut real)),
            Call::GetInteger => call!(self, get_integer(&N, 1, &mut integer)),
            Call::GetBoolean => call!(self, get_boolean(&ON, 1, &mut integer)),
            Call::GetString => call!(self, get_string(&super::probe::LABEL, 1, &mut text)),
            Call::SetReal => self.set_real(GAIN, 0.5),
            Call::SetInteger => self.set_integer(N, 1),
            Call::SetBoolean => self.set_boolean(ON, 1),
            Call::SetString => call!(self, set_string(&super::probe::LABEL, 1, &text)),
            Call::GetFmuState => {
                let status = call!(self, get_fmu_state(&mut state));
                if status == OK {
                    call!(self, free_fmu_state(&mut state));
                }
                status
            }
            Call::SetFmuState => {
                // A state of another instance of the same FMU.
                let other = Self::new(false);
                assert_eq!(call!(other, get_fmu_state(&mut state)), OK);
                let status = call!(self, set_fmu_state(state));
                assert_eq!(call!(other, free_fmu_state(&mut state)), OK);
                status
            }
            Call::FreeFmuState => call!(self, free_fmu_state(&mut state)),
            Call::SerializedFmuStateSize => {
                call!(self, serialized_fmu_state_size(state, &mut size))
            }
            Call::SerializeFmuState => call!(self, serialize_fmu_state(state, null_mut(), 0)),
            Call::DeSerializeFmuState => {
                call!(self, de_serialize_fmu_state(null(), 0, &mut state))
            }
            Call::GetDirectionalDerivative => {
                call!(self, get_directional_derivative(&Y, 1, &U, 1, &1.0, &mut real))
            }
            Call::SetRealInputDerivatives => {
                call!(self, set_real_input_derivatives(&U, 1, &1, &1.0))
            }
            Call::GetRealOutputDerivatives => {
                call!(self, get_real_output_derivatives(&Y, 1, &1, &mut real))
            }
            Call::DoStep => self.do_step(0.0, 0.01),
            Call::CancelStep => call!(self, cancel_step()),
            Call::GetStatus => call!(self, get_status(0, &mut integer)),
            Call::GetRealStatus => call!(self, get_real_status(2, &mut real)),
            Call::GetIntegerStatus => call!(self, get_integer_status(0, &mut integer)),
            Call::GetBooleanStatus => call!(self, get_boolean_status(3, &mut integer)),
            Call::GetStringStatus => call!(self, get_string_status(1, &mut text)),
            Call::GetTypesPlatform | Call::GetVersion | Call::Instantiate | Call::FreeInstance => {
                OK
            }
        }
    }
}
