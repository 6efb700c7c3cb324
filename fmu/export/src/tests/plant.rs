//! A unit with states, derivatives and serialized states, and a host for it.
//!
//! `der(x1) = -a x1 + b u`, `der(x2) = x1`; `y = x1 + d u`, `z = x2`; `x2` starts at `z0`.
//! A step uses Heun's method with the derivative of `u`. The unit returns the partial derivatives
//! `∂y/∂u`, `∂der(x2)/∂x1` and all with respect to `x2`; the layer computes the others.

use super::host::{Line, Lines, OK, callbacks};
use crate::boundary as c;
use crate::calls::State;
use crate::instance::Instance;
use crate::log::Log;
use crate::resources::Resources;
use crate::unit::{Capabilities, CoSimulationUnit, Known, StateSpec, Unknown, VariableId};
use model_description::{
    Causality as C, DependencyKind, DependsOn, Table, Value, Variability as V, VariableSpec,
};
use std::ffi::{CString, c_void};
use std::marker::PhantomData;
use std::ptr::null;

pub(super) const U: u32 = 0;
pub(super) const A: u32 = 1;
pub(super) const B: u32 = 2;
pub(super) const Z0: u32 = 3;
pub(super) const Y: u32 = 4;
pub(super) const Z: u32 = 5;
pub(super) const TWICE: u32 = 6;
pub(super) const HELD: u32 = 7;
pub(super) const N: u32 = 8;
pub(super) const GATE: u32 = 9;
pub(super) const X1: u32 = crate::state_reference(0);
pub(super) const DX1: u32 = crate::derivative_reference(0);
pub(super) const X2: u32 = crate::state_reference(1);
pub(super) const DX2: u32 = crate::derivative_reference(1);
/// The feedthrough.
pub(super) const D: f64 = 0.25;

const VARIABLES: &[VariableSpec] = &[
    VariableSpec::real("u", U, C::Input, V::Continuous).min(-1e3).max(1e3).unit("m/s2"),
    VariableSpec::real("a", A, C::Parameter, V::Fixed).min(0.5).max(0.5 + 1e-9).nominal(1.0),
    VariableSpec::real("b", B, C::Parameter, V::Tunable).nominal(1e3),
    VariableSpec::real("z0", Z0, C::Parameter, V::Fixed).unit("m"),
    VariableSpec::real("y", Y, C::Output, V::Continuous)
        .unit("m/s")
        .depends_on(DependsOn::On(&["u"]))
        .initial_depends_on(DependsOn::On(&["u"])),
    VariableSpec::real("z", Z, C::Output, V::Continuous)
        .unit("m")
        .depends_on(DependsOn::Nothing)
        .initial_depends_on(DependsOn::On(&["z0"])),
    VariableSpec::real("twice", TWICE, C::CalculatedParameter, V::Fixed)
        .initial_depends_on(DependsOn::On(&["z0"])),
    VariableSpec::real("held", HELD, C::Output, V::Discrete)
        .depends_on(DependsOn::On(&["gate"]))
        .initial_depends_on(DependsOn::On(&["gate"])),
    VariableSpec::integer("n", N, C::Parameter, V::Tunable),
    VariableSpec::real("gate", GATE, C::Input, V::Discrete),
];
pub(super) const TABLE: Table = Table::new("Plant", "1", "A plant for tests", VARIABLES);

/// The optional capabilities of the plant.
pub(super) trait Ability: Clone + Send + 'static {
    const CAPABILITIES: Capabilities;
}

/// All capabilities.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct All;
impl Ability for All {
    const CAPABILITIES: Capabilities = Capabilities::ALL;
}

/// No capabilities.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct None_;
impl Ability for None_ {
    const CAPABILITIES: Capabilities = Capabilities::NONE;
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plant<A = All> {
    u: f64,
    growth: f64,
    a: f64,
    b: f64,
    z0: f64,
    x: [f64; 2],
    n: i32,
    gate: f64,
    ability: PhantomData<A>,
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

impl<A> Plant<A> {
    fn rates(&self, x: [f64; 2], u: f64) -> [f64; 2] {
        [self.b * u - self.a * x[0], x[0]]
    }
}

impl<A: Ability> CoSimulationUnit for Plant<A> {
    type Variable = Variable;
    const TABLE: &'static Table = &TABLE;
    const CAPABILITIES: Capabilities = A::CAPABILITIES;

    fn open(_: &Resources) -> Result<Self, String> {
        let ability = PhantomData;
        let (u, growth, z0, gate) = (0.0, 0.0, 0.0, 0.0);
        Ok(Self { u, growth, a: 0.5, b: 2.0, z0, x: [1.0, 0.0], n: 0, gate, ability })
    }

    fn get(&mut self, variable: Variable) -> Value {
        Value::Real(match variable.0 {
            U => self.u,
            A => self.a,
            B => self.b,
            Z0 => self.z0,
            Y => self.x[0] + D * self.u,
            Z => self.x[1],
            TWICE => 2.0 * self.z0,
            HELD => self.gate,
            GATE => self.gate,
            _ => return Value::Integer(self.n),
        })
    }

    fn set(&mut self, variable: Variable, value: &Value) {
        match (variable.0, value) {
            (U, Value::Real(value)) => self.u = *value,
            (A, Value::Real(value)) => {
                assert!((0.5..=0.5 + 1e-9).contains(value), "outside the limits");
                self.a = *value;
            }
            (B, Value::Real(value)) => self.b = *value,
            (Z0, Value::Real(value)) => {
                self.z0 = *value;
                self.x[1] = *value;
            }
            (GATE, Value::Real(value)) => self.gate = *value,
            (N, Value::Integer(value)) => self.n = *value,
            other => panic!("the layer let {other:?} pass"),
        }
    }

    fn exit_initialization(&mut self, _start: f64, _: &mut Log) -> Result<(), String> {
        Ok(())
    }

    fn step(&mut self, _time: f64, step: f64, log: &mut Log) -> Result<(), String> {
        let first = self.rates(self.x, self.u);
        let x = [self.x[0] + step * first[0], self.x[1] + step * first[1]];
        let second = self.rates(x, self.u + step * self.growth);
        for (x, (first, second)) in self.x.iter_mut().zip(first.into_iter().zip(second)) {
            *x += step / 2.0 * (first + second);
        }
        if self.n == 1 {
            log.warning(format!("the speed is {}", self.x[0]));
        }
        Ok(())
    }

    fn states(&self) -> Vec<StateSpec> {
        let state = |description: &str, unit, derivative_unit, settable| StateSpec {
            description: description.into(),
            unit: Some(unit),
            derivative_unit: Some(derivative_unit),
            settable,
        };
        vec![state("speed", "m/s", "m/s2", true), state("way", "m", "m/s", false)]
    }

    fn state(&mut self, index: usize) -> f64 {
        self.x[index]
    }

    fn state_derivative(&mut self, index: usize) -> f64 {
        self.rates(self.x, self.u)[index]
    }

    fn set_state(&mut self, index: usize, value: f64) {
        assert_eq!(index, 0, "the layer let a state pass that is not settable");
        self.x[index] = value;
    }

    fn set_input_derivative(&mut self, variable: Variable, derivative: f64) {
        assert_eq!(variable.0, U);
        self.growth = derivative;
    }

    fn output_derivative(&mut self, variable: Variable) -> f64 {
        let rates = self.rates(self.x, self.u);
        if variable.0 == Y { rates[0] + D * self.growth } else { rates[1] }
    }

    fn dependency(
        &self,
        unknown: Unknown<Variable>,
        known: Known<Variable>,
    ) -> Option<DependencyKind> {
        let fixed = Some(DependencyKind::Fixed);
        match (unknown, known) {
            (Unknown::Variable(Variable(Y)), Known::Variable(Variable(U))) => fixed,
            (Unknown::Variable(Variable(Y)), Known::State(0)) => fixed,
            (Unknown::Variable(Variable(Z)), Known::State(1)) => fixed,
            (Unknown::Variable(Variable(HELD)), Known::Variable(Variable(GATE))) => {
                Some(DependencyKind::Dependent)
            }
            (Unknown::Derivative(0), Known::Variable(Variable(U | A | B)) | Known::State(0)) => {
                Some(DependencyKind::Dependent)
            }
            (Unknown::Derivative(1), Known::State(0)) => fixed,
            (Unknown::State(1), Known::Variable(Variable(Z0))) => fixed,
            _ => None,
        }
    }

    fn partial_derivative(
        &mut self,
        unknown: Unknown<Variable>,
        known: Known<Variable>,
    ) -> Option<f64> {
        match (unknown, known) {
            (Unknown::Variable(Variable(Y)), Known::Variable(Variable(U))) => Some(D),
            (Unknown::Derivative(1), Known::State(0)) => Some(1.0),
            (_, Known::State(1)) => Some(1.0),
            _ => None,
        }
    }

    fn save(&self) -> Vec<u8> {
        let numbers = [self.u, self.a, self.b, self.z0, self.x[0], self.x[1], self.gate];
        let mut bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        bytes.extend(self.n.to_le_bytes());
        bytes
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        if bytes.len() != 60 {
            return Err(format!("{} bytes instead of 60", bytes.len()));
        }
        let number = |k: usize| f64::from_le_bytes(bytes[8 * k..8 * k + 8].try_into().unwrap());
        (self.u, self.a, self.b, self.z0) = (number(0), number(1), number(2), number(3));
        self.x = [number(4), number(5)];
        self.gate = number(6);
        self.n = i32::from_le_bytes(bytes[56..].try_into().unwrap());
        Ok(())
    }
}

/// One instance of the plant.
pub(super) struct Rig<A: Ability = All> {
    pub(super) component: *mut c_void,
    lines: Box<Lines>,
    ability: PhantomData<A>,
}

impl<A: Ability> Drop for Rig<A> {
    fn drop(&mut self) {
        // SAFETY: created by `Rig::new`, freed once.
        unsafe { c::free_instance::<Plant<A>>(self.component) }
    }
}

/// Calls a function of the boundary on the rig's instance.
macro_rules! on {
    ($rig:expr, $function:ident($($argument:expr),*)) => {{
        // Keeps a temporary rig alive during the call.
        let rig = &$rig;
        // SAFETY: a live instance of the plant, arguments as the test requires.
        unsafe {
            crate::boundary::$function::<crate::tests::plant::Plant>(rig.component, $($argument),*)
        }
    }};
}
pub(super) use on;

impl<A: Ability> Rig<A> {
    pub(super) fn instantiated(logging_on: bool) -> Self {
        let lines = Box::new(Lines::default());
        let callbacks = callbacks(&lines);
        let guid = CString::new(model_description::guid(&TABLE, &[])).unwrap();
        let on = i32::from(logging_on);
        // SAFETY: valid strings and callbacks; these do not outlive the call.
        let component = unsafe {
            let name = c"plant".as_ptr();
            c::instantiate::<Plant<A>>(name, 1, guid.as_ptr(), null(), &callbacks, 0, on)
        };
        assert!(!component.is_null(), "{lines:?}");
        Self { component, lines, ability: PhantomData }
    }

    /// The instance.
    pub(super) fn instance(&self) -> &Instance<Plant<A>> {
        // SAFETY: a live instance of the plant; no test keeps the reference during a call.
        unsafe { &*self.component.cast() }
    }

    pub(super) fn state(&self) -> State {
        self.instance().core.state
    }

    pub(super) fn take_lines(&self) -> Vec<Line> {
        self.lines.take()
    }
}

impl Rig {
    pub(super) fn new() -> Self {
        Self::instantiated(false)
    }

    pub(super) fn in_state(state: State) -> Self {
        let rig = Self::new();
        if state != State::Instantiated {
            assert_eq!(on!(rig, setup_experiment(0, 0.0, 0.0, 0, 0.0)), OK);
            assert_eq!(on!(rig, enter_initialization_mode()), OK);
        }
        if !matches!(state, State::Instantiated | State::Initialization) {
            assert_eq!(on!(rig, exit_initialization_mode()), OK);
        }
        match state {
            State::Terminated => assert_eq!(on!(rig, terminate()), OK),
            State::Error => assert_eq!(on!(rig, do_step(0.0, -1.0, 1)), super::host::ERROR),
            _ => {}
        }
        assert_eq!(rig.state(), state);
        rig.take_lines();
        rig
    }

    pub(super) fn real(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(on!(self, get_real(&reference, 1, &mut value)), OK);
        value
    }

    pub(super) fn set(&self, reference: u32, value: f64) -> i32 {
        on!(self, set_real(&reference, 1, &value))
    }

    /// `∂unknown/∂known`.
    pub(super) fn partial(&self, unknown: u32, known: u32) -> Result<f64, i32> {
        let mut value = f64::NAN;
        match on!(self, get_directional_derivative(&unknown, 1, &known, 1, &1.0, &mut value)) {
            OK => Ok(value),
            status => Err(status),
        }
    }
}
