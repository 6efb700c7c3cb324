//! The importer that makes the calls, and what it holds the FMU to.

use crate::cursor::Cursor;
use fmi2_export::model_description::Kind;
use fmi2_export::types::CallbackFunctions;
use fmi2_export::{CoSimulationUnit, boundary as c};
use std::ffi::{CString, c_char, c_void};
use std::marker::PhantomData;
use std::path::Path;
use std::ptr::{null, null_mut};

const OK: i32 = 0;
const WARNING: i32 = 1;
const ERROR: i32 = 3;

/// The state of the instance, from its return values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Before,
    Initialization,
    StepComplete,
    Terminated,
    Error,
}

/// An FMU state and what could be read when it was taken.
struct Taken {
    state: *mut c_void,
    mode: Mode,
    time: f64,
    values: Vec<u64>,
}

/// One instance of `S`.
pub(super) struct Importer<S: CoSimulationUnit> {
    component: *mut c_void,
    mode: Mode,
    time: f64,
    references: Vec<u32>,
    taken: Vec<Taken>,
    unit: PhantomData<S>,
}

/// A call on the importer's instance, its status checked.
macro_rules! call {
    ($self:ident, $function:ident($($argument:expr),*)) => {{
        // SAFETY: a live instance of `S`; pointers are NULL or point to the stated number of values.
        let status = unsafe { c::$function::<S>($self.component, $($argument),*) };
        $self.took(stringify!($function), status)
    }};
}

impl<S: CoSimulationUnit> Importer<S> {
    pub(super) fn new(folder: &Path, name: &str, document: &[u8]) -> Self {
        let entries = vec![(name.to_owned(), document.to_vec())];
        let guid = fmi2_export::guid::<S>(&fmi2_export::Resources::from(entries));
        let guid = CString::new(guid).expect("no zero in it");
        let location = format!("file://{}", folder.display());
        let location = CString::new(location).expect("no zero in it");
        let callbacks = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: null_mut(),
        };
        // SAFETY: valid strings, and callbacks that are copied.
        let component = unsafe {
            c::instantiate::<S>(
                c"i".as_ptr(),
                1,
                guid.as_ptr(),
                location.as_ptr(),
                &callbacks,
                0,
                1,
            )
        };
        assert!(!component.is_null(), "{name} is refused");
        let rows = S::TABLE.variables.iter();
        let references = rows.filter(|row| row.kind == Kind::Real).map(|row| row.reference);
        Self {
            component,
            mode: Mode::Before,
            time: 0.0,
            references: references.collect(),
            taken: Vec::new(),
            unit: PhantomData,
        }
    }

    /// Notes a status; whether the call was carried out.
    fn took(&mut self, function: &str, status: i32) -> bool {
        assert!((0..=ERROR).contains(&status), "{function} returned {status}");
        if status == ERROR {
            self.mode = Mode::Error;
        }
        status == OK || status == WARNING
    }

    /// Makes the call that the bytes choose.
    pub(super) fn call(&mut self, cursor: &mut Cursor<'_>) {
        match cursor.byte() % 24 {
            0..=5 => self.do_step(cursor),
            6..=8 => self.set_reals(cursor),
            9 => self.set_others(cursor),
            10 | 11 => self.get_reals(cursor),
            12 | 13 => self.initialize(cursor),
            14 | 15 => self.take(),
            16 | 17 => self.restore(cursor),
            18 => self.through_bytes(cursor),
            19 => self.free_state(cursor),
            20 => self.reset(),
            21 => self.derivatives(cursor),
            22 => self.ask_status(cursor),
            _ => self.out_of_order(cursor),
        }
    }

    fn do_step(&mut self, cursor: &mut Cursor<'_>) {
        let step = cursor.step();
        let time = if cursor.rarely(20) { cursor.real() } else { self.time };
        let stood = self.mode;
        if call!(self, do_step(time, step, 1)) {
            assert_eq!(stood, Mode::StepComplete, "a step was made in {stood:?}");
            self.time = time + step;
            self.values();
        }
    }

    fn references(&self, cursor: &mut Cursor<'_>) -> Vec<u32> {
        (0..cursor.below(5))
            .map(|_| match cursor.byte() {
                0..=229 => self.references[cursor.below(self.references.len())],
                230..=239 => 0x1000_0000 + u32::from(cursor.byte() % 16),
                _ => u32::from(cursor.byte()),
            })
            .collect()
    }

    fn set_reals(&mut self, cursor: &mut Cursor<'_>) {
        let references = self.references(cursor);
        let values: Vec<f64> = references.iter().map(|_| cursor.real()).collect();
        let pointer = if cursor.rarely(40) { null() } else { values.as_ptr() };
        call!(self, set_real(references.as_ptr(), references.len(), pointer));
    }

    fn set_others(&mut self, cursor: &mut Cursor<'_>) {
        let others: Vec<(u32, Kind)> = S::TABLE
            .variables
            .iter()
            .filter(|row| row.kind != Kind::Real)
            .map(|row| (row.reference, row.kind))
            .collect();
        let (reference, kind) = match others.get(cursor.below(others.len() + 1)) {
            Some(other) => *other,
            None => (u32::from(cursor.byte()), Kind::Integer),
        };
        let value = cursor.integer();
        match kind {
            Kind::Boolean => call!(self, set_boolean(&reference, 1, &value)),
            Kind::String => call!(self, set_string(&reference, 1, &c"text".as_ptr())),
            _ => call!(self, set_integer(&reference, 1, &value)),
        };
    }

    fn get_reals(&mut self, cursor: &mut Cursor<'_>) {
        let references = self.references(cursor);
        let mut values = vec![0.0; references.len()];
        let pointer = if cursor.rarely(40) { null_mut() } else { values.as_mut_ptr() };
        if call!(self, get_real(references.as_ptr(), references.len(), pointer)) {
            assert!(values.iter().all(|value| value.is_finite()), "{references:?} {values:?}");
        }
    }

    fn initialize(&mut self, cursor: &mut Cursor<'_>) {
        let choice = cursor.byte();
        let stop_defined = i32::from(choice >= 200);
        let start = if choice % 8 == 7 { cursor.real() } else { 0.0 };
        if self.mode == Mode::Before || cursor.rarely(10) {
            if !call!(self, setup_experiment(0, 0.0, start, stop_defined, start + 100.0)) {
                return;
            }
            self.time = start;
            if !call!(self, enter_initialization_mode()) {
                return;
            }
            self.mode = Mode::Initialization;
            if choice.is_multiple_of(3) {
                return;
            }
        }
        if call!(self, exit_initialization_mode()) {
            self.mode = Mode::StepComplete;
            self.values();
        }
    }

    /// All Real variables, where they may be read without a breach of the standard.
    fn values(&mut self) -> Vec<u64> {
        if self.mode != Mode::StepComplete && self.mode != Mode::Terminated {
            return Vec::new();
        }
        let references = self.references.clone();
        let mut values = vec![f64::NAN; references.len()];
        let read =
            call!(self, get_real(references.as_ptr(), references.len(), values.as_mut_ptr()));
        assert!(read, "cannot read {references:?} in {:?}", self.mode);
        assert!(values.iter().all(|value| value.is_finite()), "{references:?} {values:?}");
        values.into_iter().map(f64::to_bits).collect()
    }

    fn take(&mut self) {
        if self.taken.len() >= 8 {
            return;
        }
        let values = self.values();
        let mut state = null_mut();
        let (mode, time) = (self.mode, self.time);
        if call!(self, get_fmu_state(&raw mut state)) {
            assert!(!state.is_null());
            self.taken.push(Taken { state, mode, time, values });
        }
    }

    fn restore(&mut self, cursor: &mut Cursor<'_>) {
        let Some(taken) = self.taken.get(cursor.below(self.taken.len())) else {
            call!(self, set_fmu_state(null_mut()));
            return;
        };
        let (state, mode, time, values) =
            (taken.state, taken.mode, taken.time, taken.values.clone());
        assert!(call!(self, set_fmu_state(state)), "a state was refused");
        (self.mode, self.time) = (mode, time);
        assert_eq!(self.values(), values, "a state gave back other values");
    }

    fn through_bytes(&mut self, cursor: &mut Cursor<'_>) {
        if !S::CAPABILITIES.serializes || self.taken.is_empty() {
            return;
        }
        let index = cursor.below(self.taken.len());
        let state = self.taken[index].state;
        let mode = self.mode;
        let mut size = 0;
        assert!(call!(self, serialized_fmu_state_size(state, &raw mut size)));
        let mut bytes = vec![0_u8; size];
        assert!(call!(self, serialize_fmu_state(state, bytes.as_mut_ptr().cast(), size)));
        let changed = cursor.rarely(2);
        if changed {
            let at = usize::from(cursor.byte()) * 256 + usize::from(cursor.byte());
            bytes[at % size] ^= 1 << (cursor.byte() % 8);
        }
        let mut again = null_mut();
        let pointer = bytes.as_ptr().cast::<c_char>();
        let read = call!(self, de_serialize_fmu_state(pointer, size, &raw mut again));
        assert_eq!(read, !changed, "changed: {changed}");
        if changed {
            assert!(again.is_null());
            return;
        }
        self.mode = mode;
        let Taken { state, mode, time, ref values, .. } = self.taken[index];
        let old = Taken { state: again, mode, time, values: values.clone() };
        self.taken[index] = old;
        let mut state = state;
        assert!(call!(self, free_fmu_state(&raw mut state)));
    }

    fn free_state(&mut self, cursor: &mut Cursor<'_>) {
        if self.taken.is_empty() {
            let mut none = null_mut();
            call!(self, free_fmu_state(&raw mut none));
            call!(self, free_fmu_state(null_mut()));
            return;
        }
        let mut taken = self.taken.swap_remove(cursor.below(self.taken.len()));
        assert!(call!(self, free_fmu_state(&raw mut taken.state)));
        assert!(taken.state.is_null());
    }

    fn reset(&mut self) {
        assert!(call!(self, reset()));
        self.mode = Mode::Before;
    }

    fn derivatives(&mut self, cursor: &mut Cursor<'_>) {
        let references = self.references(cursor);
        let (n, pointer) = (references.len(), references.as_ptr());
        let orders: Vec<i32> = references.iter().map(|_| cursor.integer().min(2)).collect();
        let mut values: Vec<f64> = references.iter().map(|_| cursor.real()).collect();
        match cursor.byte() % 3 {
            0 => {
                call!(
                    self,
                    set_real_input_derivatives(pointer, n, orders.as_ptr(), values.as_ptr())
                );
            }
            1 => {
                values.fill(0.0);
                if call!(
                    self,
                    get_real_output_derivatives(pointer, n, orders.as_ptr(), values.as_mut_ptr())
                ) {
                    assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
                }
            }
            _ => {
                let knowns = self.references(cursor);
                let seeds: Vec<f64> = knowns.iter().map(|_| cursor.real()).collect();
                call!(
                    self,
                    get_directional_derivative(
                        pointer,
                        n,
                        knowns.as_ptr(),
                        knowns.len(),
                        seeds.as_ptr(),
                        values.as_mut_ptr()
                    )
                );
            }
        }
    }

    fn ask_status(&mut self, cursor: &mut Cursor<'_>) {
        let kind = cursor.integer();
        let (mut real, mut integer, mut text) = (0.0, 0, null());
        match cursor.byte() % 5 {
            0 => call!(self, get_status(kind, &raw mut integer)),
            1 => call!(self, get_real_status(kind, &raw mut real)),
            2 => call!(self, get_integer_status(kind, &raw mut integer)),
            3 => call!(self, get_boolean_status(kind, &raw mut integer)),
            _ => call!(self, get_string_status(kind, &raw mut text)),
        };
    }

    fn out_of_order(&mut self, cursor: &mut Cursor<'_>) {
        match cursor.byte() % 4 {
            0 => {
                if call!(self, terminate()) {
                    self.mode = Mode::Terminated;
                }
            }
            1 => {
                call!(self, cancel_step());
            }
            2 => {
                let category = c"logAll".as_ptr();
                call!(self, set_debug_logging(cursor.integer(), 1, &category));
            }
            _ => {
                call!(self, set_debug_logging(1, 0, null()));
            }
        }
    }
}

impl<S: CoSimulationUnit> Drop for Importer<S> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            return;
        }
        for taken in std::mem::take(&mut self.taken) {
            let mut state = taken.state;
            assert!(call!(self, free_fmu_state(&raw mut state)));
        }
        // SAFETY: made by `Importer::new`, freed once.
        unsafe { c::free_instance::<S>(self.component) };
    }
}
