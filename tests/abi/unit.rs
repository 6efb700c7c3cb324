//! One instance, created and freed through C, with its log.

use crate::api::{Api, Callbacks, Component, OK, State, Status};
use crate::samples::Sample;
use model_description::{Causality, Kind, Value, Variable};
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

/// One call of the logger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Line {
    pub(crate) instance: String,
    pub(crate) status: Status,
    pub(crate) category: String,
    /// The format, which must be a bare `%s`.
    pub(crate) format: String,
    pub(crate) text: String,
}

/// The log of an instance. Its address is the component environment.
#[derive(Debug, Default)]
pub(crate) struct Lines(Mutex<Vec<Line>>);

impl Lines {
    /// Takes all lines.
    pub(crate) fn take(&self) -> Vec<Line> {
        std::mem::take(&mut self.0.lock().unwrap())
    }
}

/// `fmi2CallbackLogger` with the one variadic argument that our libraries pass. Stable Rust cannot
/// define variadic functions; `fmu/host/src/log.rs` states where this one reads it correctly.
unsafe extern "C" fn logger(
    environment: *mut c_void,
    instance: *const c_char,
    status: Status,
    category: *const c_char,
    message: *const c_char,
    argument: *const c_char,
) {
    let text = |pointer: *const c_char| {
        assert!(!pointer.is_null());
        // SAFETY: not null; each of these is a string that ends in zero.
        unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned()
    };
    let arrives = !cfg!(all(target_arch = "aarch64", target_vendor = "apple"));
    let format = text(message);
    let line = Line {
        instance: text(instance),
        status,
        category: text(category),
        text: if arrives && format == "%s" { text(argument) } else { String::new() },
        format,
    };
    // SAFETY: the environment is the `Lines` of a live [`Unit`].
    unsafe { &*environment.cast::<Lines>() }.0.lock().unwrap().push(line);
}

/// The callbacks of one instance: this logger, and no others.
pub(crate) fn callbacks(lines: &Lines) -> Callbacks {
    Callbacks {
        logger: logger as *const c_void,
        allocate_memory: null(),
        free_memory: null(),
        step_finished: null(),
        environment: std::ptr::from_ref(lines).cast_mut().cast(),
    }
}

/// An instance.
pub(crate) struct Unit<'s> {
    pub(crate) sample: &'s Sample,
    pub(crate) api: &'s Api,
    pub(crate) component: Component,
    pub(crate) lines: Box<Lines>,
    /// Where the next step begins, s.
    pub(crate) time: f64,
}

// SAFETY: the standard lets an instance move between threads that do not use it at once.
unsafe impl Send for Unit<'_> {}

impl Drop for Unit<'_> {
    fn drop(&mut self) {
        // SAFETY: live until here; null is ignored.
        unsafe { (self.api.free_instance)(self.component) }
    }
}

/// Arguments of `fmi2Instantiate`.
pub(crate) struct Birth<'b> {
    pub(crate) name: Option<&'b CStr>,
    pub(crate) guid: Option<CString>,
    pub(crate) location: Option<CString>,
    pub(crate) fmu_type: i32,
    pub(crate) logging_on: bool,
}

impl<'s> Birth<'s> {
    /// As an importer should.
    pub(crate) fn of(sample: &Sample) -> Self {
        Self {
            name: Some(c"one"),
            guid: Some(CString::new(sample.description.guid.clone()).unwrap()),
            location: Some(CString::new(sample.uri()).unwrap()),
            fmu_type: 1,
            logging_on: false,
        }
    }

    /// Instantiates; the component may be null.
    pub(crate) fn give(&self, sample: &'s Sample) -> Unit<'s> {
        let lines = Box::<Lines>::default();
        // On the stack, and gone after the call: it must be copied.
        let callbacks = callbacks(&lines);
        let pointer = |text: Option<&CStr>| text.map_or(null(), CStr::as_ptr);
        // SAFETY: null or strings and a struct that live for the time of the call; `lines` lives
        // as long as the instance.
        let component = unsafe {
            (sample.api.instantiate)(
                pointer(self.name),
                self.fmu_type,
                pointer(self.guid.as_deref()),
                pointer(self.location.as_deref()),
                &callbacks,
                0,
                i32::from(self.logging_on),
            )
        };
        Unit { sample, api: &sample.api, component, lines, time: 0.0 }
    }
}

impl<'s> Unit<'s> {
    /// A fresh instance.
    pub(crate) fn new(sample: &'s Sample) -> Self {
        let unit = Birth::of(sample).give(sample);
        assert!(!unit.component.is_null(), "{:?}", unit.lines.take());
        unit
    }

    /// In initialization mode, at time zero.
    pub(crate) fn initializing(sample: &'s Sample) -> Self {
        let unit = Self::new(sample);
        unit.begin();
        unit
    }

    /// At its first communication point.
    pub(crate) fn started(sample: &'s Sample) -> Self {
        let unit = Self::initializing(sample);
        assert_eq!(unit.exit_initialization(), OK);
        unit
    }

    /// Sets up and enters initialization mode.
    pub(crate) fn begin(&self) {
        assert_eq!(self.setup(0.0), OK);
        // SAFETY: a live instance.
        assert_eq!(unsafe { (self.api.enter_initialization_mode)(self.component) }, OK);
    }

    pub(crate) fn setup(&self, start: f64) -> Status {
        // SAFETY: a live instance.
        unsafe { (self.api.setup_experiment)(self.component, 0, 0.0, start, 0, 0.0) }
    }

    pub(crate) fn exit_initialization(&self) -> Status {
        // SAFETY: a live instance.
        unsafe { (self.api.exit_initialization_mode)(self.component) }
    }

    pub(crate) fn reset(&self) -> Status {
        // SAFETY: a live instance.
        unsafe { (self.api.reset)(self.component) }
    }

    pub(crate) fn terminate(&self) -> Status {
        // SAFETY: a live instance.
        unsafe { (self.api.terminate)(self.component) }
    }

    /// A call that is never legal, and does nothing else.
    pub(crate) fn cancel(&self) -> Status {
        // SAFETY: a live instance.
        unsafe { (self.api.cancel_step)(self.component) }
    }

    pub(crate) fn step_at(&self, time: f64, step: f64) -> Status {
        // SAFETY: a live instance.
        unsafe { (self.api.do_step)(self.component, time, step, 1) }
    }

    /// The next step of the advised size; warnings are as good.
    pub(crate) fn step(&mut self) {
        let step = self.sample.step();
        let status = self.step_at(self.time, step);
        assert!(status <= 1, "{status}: {:?}", self.lines.take());
        self.time += step;
    }

    pub(crate) fn set_real(&self, reference: u32, value: f64) -> Status {
        // SAFETY: a live instance, one element each.
        unsafe { (self.api.set_real)(self.component, &reference, 1, &value) }
    }

    pub(crate) fn real(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: a live instance, one element each.
        let status = unsafe { (self.api.get_real)(self.component, &reference, 1, &mut value) };
        assert_eq!(status, OK, "{:?}", self.lines.take());
        value
    }

    /// Sets a variable.
    pub(crate) fn set(&self, variable: &Variable, value: &Value) -> Status {
        let (c, r) = (self.component, &variable.reference);
        // SAFETY: a live instance, one element each, a string that lives for the call.
        unsafe {
            match value {
                Value::Real(value) => (self.api.set_real)(c, r, 1, value),
                Value::Integer(value) => (self.api.set_integer)(c, r, 1, value),
                Value::Boolean(value) => (self.api.set_boolean)(c, r, 1, &i32::from(*value)),
                Value::String(text) => {
                    let text = CString::new(text.as_str()).unwrap();
                    (self.api.set_string)(c, r, 1, &text.as_ptr())
                }
            }
        }
    }

    /// Reads a variable: the status, and the bits of the value.
    pub(crate) fn bits(&self, variable: &Variable) -> (Status, u64) {
        let (c, r) = (self.component, &variable.reference);
        let (mut real, mut integer, mut text) = (f64::NAN, i32::MIN, null());
        // SAFETY: a live instance, one element each.
        unsafe {
            match variable.kind {
                Kind::Real => ((self.api.get_real)(c, r, 1, &mut real), real.to_bits()),
                Kind::Integer => ((self.api.get_integer)(c, r, 1, &mut integer), integer as u64),
                Kind::Boolean => ((self.api.get_boolean)(c, r, 1, &mut integer), integer as u64),
                Kind::String => {
                    let status = (self.api.get_string)(c, r, 1, &mut text);
                    let bytes = if text.is_null() { &[] } else { CStr::from_ptr(text).to_bytes() };
                    // The same text gives the same sum.
                    (status, bytes.iter().fold(7, |sum, b| sum * 31 + u64::from(*b)))
                }
            }
        }
    }

    /// The bits of every variable.
    pub(crate) fn everything(&self) -> Vec<u64> {
        let bits = |variable: &Variable| match self.bits(variable) {
            (OK, bits) => bits,
            (status, _) => panic!("{}: {status}, {:?}", variable.name, self.lines.take()),
        };
        self.sample.variables().iter().map(bits).collect()
    }

    /// Saves into a new state.
    pub(crate) fn save(&self) -> State {
        let mut state = null_mut();
        // SAFETY: a live instance, a pointer to null.
        let status = unsafe { (self.api.get_fmu_state)(self.component, &mut state) };
        assert_eq!(status, OK, "{:?}", self.lines.take());
        assert!(!state.is_null());
        state
    }

    pub(crate) fn restore(&self, state: State) -> Status {
        // SAFETY: a live instance; what is no state is refused.
        unsafe { (self.api.set_fmu_state)(self.component, state) }
    }

    pub(crate) fn free(&self, mut state: State) {
        // SAFETY: a live instance and state.
        let status = unsafe { (self.api.free_fmu_state)(self.component, &mut state) };
        assert_eq!((status, state.is_null()), (OK, true));
    }

    /// Some steps with all inputs moving; the bits of every variable after each.
    pub(crate) fn drive(&mut self, from: u32, count: u32) -> Vec<Vec<u64>> {
        let step = |k: u32| {
            self.steer(k);
            self.step();
            self.everything()
        };
        (from..from + count).map(step).collect()
    }

    /// Sets every input to a value that depends on `k`.
    pub(crate) fn steer(&self, k: u32) {
        for (i, input) in self.sample.of(Kind::Real, Causality::Input).enumerate() {
            let wave = (f64::from(k) * 0.1 + i as f64).sin();
            // A speed stays positive.
            let value = if input.min == Some(0.0) { 15.0 + 2.0 * wave } else { 0.1 * wave };
            assert!(self.set_real(input.reference, value) <= 1);
        }
        for input in self.sample.of(Kind::Boolean, Causality::Input) {
            assert_eq!(self.set(input, &Value::Boolean(k % 16 < 12)), OK);
        }
        // What counts events: one in five steps.
        for input in self.sample.of(Kind::Integer, Causality::Input) {
            assert_eq!(self.set(input, &Value::Integer(i32::try_from(k / 5).unwrap())), OK);
        }
    }
}

impl Unit<'_> {
    /// The present state as bytes, if the description has `canSerializeFMUstate`.
    pub(crate) fn serialized(&self) -> Vec<c_char> {
        let (state, mut size) = (self.save(), 0);
        // SAFETY: a live instance and state, as much room as asked for.
        let bytes = unsafe {
            let c = self.component;
            assert_eq!((self.api.serialized_fmu_state_size)(c, state, &mut size), OK);
            let mut bytes = vec![0; size];
            assert_eq!((self.api.serialize_fmu_state)(c, state, bytes.as_mut_ptr(), size), OK);
            bytes
        };
        self.free(state);
        bytes
    }

    /// Goes to a state that is given as bytes.
    pub(crate) fn deserialize(&self, bytes: &[c_char]) -> Status {
        let mut state = null_mut();
        let (pointer, n) = (bytes.as_ptr(), bytes.len());
        // SAFETY: a live instance, as many bytes as declared, a pointer to null.
        let status =
            unsafe { (self.api.de_serialize_fmu_state)(self.component, pointer, n, &mut state) };
        if status == OK {
            assert_eq!(self.restore(state), OK);
            self.free(state);
        }
        status
    }
}
