//! A mass on a spring, `der(x) = v`, `der(v) = (F − k x)/m`, as an FMU with all optional capabilities:
//! states, input derivatives, output and directional derivatives, and serialized states.
//!
//! A step is exact for a force that is linear in time: with `ω = √(k/m)`, the equilibrium moves as
//! `F/k + Ḟ/k t`, and `x` and `v` oscillate about it.
#![deny(unsafe_code)] // the macro allows it for itself

use fmi2_export::model_description::{DependencyKind, DependsOn::Nothing, Initial, Table, Value};
use fmi2_export::{
    Capabilities, CoSimulationUnit, Known, Log, Resources, StateSpec, Unknown, export,
};

fmi2_export::variables! {
    /// Variables of the oscillator. The position is the first state, so it depends on no variable.
    Variable, "Oscillator", "A mass on a spring";
    Force = 0, real "F", Input, Continuous, .unit("N").nominal(100.0);
    Mass = 1, real "m", Parameter, Fixed, .unit("kg").min(1e-3);
    Stiffness = 2, real "k", Parameter, Fixed, .unit("N/m").min(1e-3);
    Position = 3, real "x", Output, Continuous, .unit("m").initial(Initial::Calculated)
        .depends_on(Nothing).initial_depends_on(Nothing);
}

/// The unit: its input and parameters, and its states.
#[derive(Debug, Clone)]
pub(crate) struct Oscillator {
    force: f64,
    /// N/s, within the next step.
    growth: f64,
    mass: f64,
    stiffness: f64,
    /// Position, m, and speed, m/s.
    state: [f64; 2],
}

impl Oscillator {
    fn derivatives(&self) -> [f64; 2] {
        let [x, v] = self.state;
        [v, (self.force - self.stiffness * x) / self.mass]
    }
}

impl CoSimulationUnit for Oscillator {
    type Variable = Variable;
    const TABLE: &'static Table = Variable::TABLE;
    const CAPABILITIES: Capabilities = Capabilities::ALL;

    fn open(_: &Resources) -> Result<Self, String> {
        Ok(Self { force: 0.0, growth: 0.0, mass: 1.0, stiffness: 4.0, state: [1.0, 0.0] })
    }

    fn get(&mut self, variable: Variable) -> Value {
        Value::Real(match variable {
            Variable::Force => self.force,
            Variable::Mass => self.mass,
            Variable::Stiffness => self.stiffness,
            Variable::Position => self.state[0],
        })
    }

    fn set(&mut self, variable: Variable, value: &Value) {
        match (variable, value) {
            (Variable::Force, Value::Real(value)) => self.force = *value,
            (Variable::Mass, Value::Real(value)) => self.mass = *value,
            (Variable::Stiffness, Value::Real(value)) => self.stiffness = *value,
            _ => {}
        }
    }

    fn exit_initialization(&mut self, _start: f64, _: &mut Log) -> Result<(), String> {
        Ok(())
    }

    fn step(&mut self, _time: f64, step: f64, _: &mut Log) -> Result<(), String> {
        let omega = (self.stiffness / self.mass).sqrt();
        let (sin, cos) = (omega * step).sin_cos();
        let (rest, drift) = (self.force / self.stiffness, self.growth / self.stiffness);
        let (x, v) = (self.state[0] - rest, self.state[1] - drift);
        self.state =
            [rest + drift * step + x * cos + v * sin / omega, drift - x * omega * sin + v * cos];
        Ok(())
    }

    fn states(&self) -> Vec<StateSpec> {
        let state = |description: &str, unit, derivative_unit| StateSpec {
            description: description.into(),
            unit: Some(unit),
            derivative_unit: Some(derivative_unit),
            settable: true,
        };
        vec![state("position", "m", "m/s"), state("speed", "m/s", "m/s2")]
    }

    fn state(&mut self, index: usize) -> f64 {
        self.state[index]
    }

    fn state_derivative(&mut self, index: usize) -> f64 {
        self.derivatives()[index]
    }

    fn set_state(&mut self, index: usize, value: f64) {
        self.state[index] = value;
    }

    fn set_input_derivative(&mut self, _: Variable, derivative: f64) {
        self.growth = derivative;
    }

    fn output_derivative(&mut self, _: Variable) -> f64 {
        self.state[1]
    }

    fn dependency(
        &self,
        unknown: Unknown<Variable>,
        known: Known<Variable>,
    ) -> Option<DependencyKind> {
        match (unknown, known) {
            (Unknown::Variable(Variable::Position), Known::State(0))
            | (Unknown::Derivative(0), Known::State(1)) => Some(DependencyKind::Constant),
            (Unknown::Derivative(1), Known::State(0) | Known::Variable(_)) => {
                Some(DependencyKind::Dependent)
            }
            _ => None,
        }
    }

    /// The layer computes the other partial derivatives as central differences.
    fn partial_derivative(&mut self, _: Unknown<Variable>, known: Known<Variable>) -> Option<f64> {
        matches!(known, Known::Variable(Variable::Force)).then(|| 1.0 / self.mass)
    }

    fn save(&self) -> Vec<u8> {
        let numbers = [self.force, self.mass, self.stiffness, self.state[0], self.state[1]];
        numbers.into_iter().flat_map(f64::to_le_bytes).collect()
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (words, rest) = bytes.as_chunks::<8>();
        let numbers: Vec<f64> = words.iter().map(|word| f64::from_le_bytes(*word)).collect();
        match (numbers.as_slice(), rest) {
            (&[force, mass, stiffness, x, v], [])
                if numbers.iter().all(|number| number.is_finite())
                    && mass >= 1e-3
                    && stiffness >= 1e-3 =>
            {
                *self = Self { force, growth: 0.0, mass, stiffness, state: [x, v] };
                Ok(())
            }
            _ => Err("the bytes are not the state of an oscillator".into()),
        }
    }
}

export!(Oscillator);
