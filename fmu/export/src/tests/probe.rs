//! A unit with every kind of variable and selectable faults.

use crate::log::Log;
use crate::resources::Resources;
use crate::unit::{CoSimulationUnit, VariableId};
use model_description::{Causality as C, Initial, Table, Value, Variability as V, VariableSpec};
use std::cell::Cell;

pub(super) const U: u32 = 0;
pub(super) const GAIN: u32 = 1;
pub(super) const OFFSET: u32 = 2;
pub(super) const Y: u32 = 3;
pub(super) const N: u32 = 4;
pub(super) const ON: u32 = 5;
pub(super) const LABEL: u32 = 6;
pub(super) const SCALE: u32 = 7;
pub(super) const GRAVITY: u32 = 8;
pub(super) const GUESS: u32 = 9;
pub(super) const FAULT: u32 = 10;
pub(super) const COUNT: u32 = 11;

pub(super) const VARIABLES: &[VariableSpec] = &[
    VariableSpec::real("u", U, C::Input, V::Continuous).min(-10.0).max(10.0),
    VariableSpec::real("gain", GAIN, C::Parameter, V::Tunable).min(0.0).max(100.0),
    VariableSpec::real("offset", OFFSET, C::Parameter, V::Fixed),
    VariableSpec::real("y", Y, C::Output, V::Continuous),
    VariableSpec::integer("n", N, C::Parameter, V::Tunable).min(0.0).max(5.0),
    VariableSpec::boolean("on", ON, C::Input, V::Discrete),
    VariableSpec::string("label", LABEL, C::Parameter, V::Tunable),
    VariableSpec::real("scale", SCALE, C::CalculatedParameter, V::Fixed),
    VariableSpec::real("gravity", GRAVITY, C::Output, V::Constant),
    VariableSpec::real("guess", GUESS, C::Local, V::Continuous).initial(Initial::Approx),
    VariableSpec::integer("fault", FAULT, C::Parameter, V::Tunable),
    VariableSpec::integer("count", COUNT, C::Input, V::Discrete).min(0.0).max(9.0),
];

pub(super) const TABLE: Table = Table::new("Probe", "1", "A unit for tests", VARIABLES);

/// The faults of the unit, by the value of `fault`.
pub(super) const PANIC_IN_EXIT: i32 = 1;
pub(super) const PANIC_IN_STEP: i32 = 2;
pub(super) const PANIC_IN_GET: i32 = 3;
pub(super) const PANIC_IN_SET: i32 = 4;
pub(super) const PANIC_IN_CLONE: i32 = 5;
pub(super) const PANIC_IN_DROP: i32 = 6;
pub(super) const ERROR_IN_STEP: i32 = 7;
pub(super) const WARNING_IN_STEP: i32 = 8;
pub(super) const ERROR_IN_EXIT: i32 = 9;

thread_local! {
    /// Units alive on this thread.
    pub(super) static LIVE: Cell<i32> = const { Cell::new(0) };
}

/// Counts the units alive.
struct Counted;

impl Counted {
    fn new() -> Self {
        LIVE.set(LIVE.get() + 1);
        Self
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        LIVE.set(LIVE.get() - 1);
    }
}

pub(super) struct Probe {
    u: f64,
    gain: f64,
    offset: f64,
    y: f64,
    n: i32,
    on: bool,
    label: String,
    guess: f64,
    count: i32,
    fault: i32,
    _counted: Counted,
}

impl Clone for Probe {
    fn clone(&self) -> Self {
        assert!(self.fault != PANIC_IN_CLONE, "clone");
        Self { label: self.label.clone(), _counted: Counted::new(), ..*self }
    }
}

impl Drop for Probe {
    fn drop(&mut self) {
        assert!(self.fault != PANIC_IN_DROP, "drop");
    }
}

#[derive(Clone, Copy)]
pub(super) struct Variable(u32);

impl VariableId for Variable {
    fn from_reference(reference: u32) -> Option<Self> {
        (reference as usize).lt(&VARIABLES.len()).then_some(Self(reference))
    }

    fn spec(self) -> &'static VariableSpec {
        &VARIABLES[self.0 as usize]
    }
}

impl CoSimulationUnit for Probe {
    type Variable = Variable;
    const TABLE: &'static Table = &TABLE;

    fn open(resources: &Resources) -> Result<Self, String> {
        match resources.get("fault.txt") {
            Some(b"panic") => panic!("open"),
            Some(_) => return Err("a bad resource".into()),
            None => {}
        }
        let (gain, label) = (2.0, "start".into());
        Ok(Self {
            u: 0.0,
            gain,
            offset: 0.0,
            y: 0.0,
            n: 0,
            on: false,
            label,
            guess: 0.0,
            count: 0,
            fault: 0,
            _counted: Counted::new(),
        })
    }

    fn get(&mut self, variable: Variable) -> Value {
        assert!(self.fault != PANIC_IN_GET, "get");
        match variable.0 {
            U => Value::Real(self.u),
            GAIN => Value::Real(self.gain),
            OFFSET => Value::Real(self.offset),
            Y => Value::Real(self.y),
            N => Value::Integer(self.n),
            ON => Value::Boolean(self.on),
            LABEL => Value::String(self.label.clone()),
            SCALE => Value::Real(2.0 * self.offset),
            GRAVITY => Value::Real(9.81),
            GUESS => Value::Real(self.guess),
            COUNT => Value::Integer(self.count),
            _ => Value::Integer(self.fault),
        }
    }

    fn set(&mut self, variable: Variable, value: &Value) {
        match (variable.0, value) {
            (U, Value::Real(value)) => self.u = *value,
            (GAIN, Value::Real(value)) => self.gain = *value,
            (OFFSET, Value::Real(value)) => self.offset = *value,
            (GUESS, Value::Real(value)) => self.guess = *value,
            (N, Value::Integer(value)) => self.n = *value,
            (COUNT, Value::Integer(value)) => self.count = *value,
            (FAULT, Value::Integer(value)) => {
                self.fault = *value;
                assert!(self.fault != PANIC_IN_SET, "set");
            }
            (ON, Value::Boolean(value)) => self.on = *value,
            (LABEL, Value::String(value)) => self.label.clone_from(value),
            other => panic!("the layer let {other:?} pass"),
        }
    }

    fn exit_initialization(&mut self, _start: f64, log: &mut Log) -> Result<(), String> {
        assert!(self.fault != PANIC_IN_EXIT, "exit");
        log.info("initialized");
        if self.fault == ERROR_IN_EXIT { Err("no solution".into()) } else { Ok(()) }
    }

    fn step(&mut self, time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        // Not a round number: a restored state must return the same bits.
        self.y += step * (self.gain * self.u + self.offset - 0.3 * self.y) + 1e-9 * time.sin();
        match self.fault {
            PANIC_IN_STEP => panic!("{}", format!("step {}", 1)),
            ERROR_IN_STEP => Err("diverged\0 100% %s".into()),
            WARNING_IN_STEP => {
                log.warning("too fast");
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
