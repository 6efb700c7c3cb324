//! What an FMU's author writes.

use crate::{Log, Resources};
use model_description::{DependencyKind, Table, Value, VariableSpec};

/// A variable of an FMU: usually an enum with one member for each row of the table.
pub trait VariableId: Copy + 'static {
    /// The variable with that value reference.
    fn from_reference(reference: u32) -> Option<Self>;

    /// Its row of the table.
    fn spec(self) -> &'static VariableSpec;
}

/// What a slave can do beyond the least; each member is a capability flag of the description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Capabilities {
    /// [`Slave::set_input_derivative`] has an effect: `canInterpolateInputs`.
    pub interpolates_inputs: bool,
    /// [`Slave::output_derivative`] answers: `maxOutputDerivativeOrder` is 1.
    pub output_derivatives: bool,
    /// [`Slave::partial_derivative`] may be asked: `providesDirectionalDerivative`.
    pub directional_derivatives: bool,
    /// [`Slave::save`] and [`Slave::load`] are there: `canSerializeFMUstate`.
    pub serializes: bool,
}

impl Capabilities {
    /// None of them.
    pub const NONE: Self = Self {
        interpolates_inputs: false,
        output_derivatives: false,
        directional_derivatives: false,
        serializes: false,
    };

    /// All of them.
    pub const ALL: Self = Self {
        interpolates_inputs: true,
        output_derivatives: true,
        directional_derivatives: true,
        serializes: true,
    };
}

/// A continuous state, which the layer exposes as `state[i]` and `der(state[i])`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StateSpec {
    /// One line for people.
    pub description: String,
    /// Its unit, one of [`model_description::UNITS`].
    pub unit: Option<&'static str>,
    /// The unit of its derivative.
    pub derivative_unit: Option<&'static str>,
    /// Whether its value at the start can be set (`initial="exact"`); if not it follows from other
    /// start values (`initial="calculated"`).
    pub settable: bool,
}

/// What a partial derivative is taken of. States count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown<V> {
    /// An output.
    Variable(V),
    /// The derivative of that state.
    Derivative(usize),
    /// That state itself; asked of states that are not settable, in initialization mode alone.
    State(usize),
}

/// What a partial derivative is taken by. States count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known<V> {
    /// An input, or, in initialization mode, a variable with `initial="exact"`.
    Variable(V),
    /// A state; in initialization mode a settable one.
    State(usize),
}

/// What an FMU is: everything the C layer needs.
///
/// The state of an instance is the value itself: `fmi2GetFMUstate` clones it, `fmi2Reset` goes
/// back to a clone of what [`Slave::open`] gave. Keep what never changes behind an `Arc`.
///
/// The layer has checked what reaches these functions: the call is legal in the instance's state,
/// values are of the row's type, finite and within its limits, times are finite and in order. A
/// panic becomes `fmi2Fatal` for this instance alone.
pub trait Slave: Clone + Send + Sized + 'static {
    /// Names its variables.
    type Variable: VariableId;

    /// Its variables; refer to a `const` or `static` item, so that the compiler checks it.
    const TABLE: &'static Table;

    /// What it can do beyond the least; the functions for the rest are never called.
    const CAPABILITIES: Capabilities = Capabilities::NONE;

    /// Makes a new instance from the files under `resources/` of the archive.
    ///
    /// # Errors
    /// A text for people; the instantiation fails with it.
    fn open(resources: &Resources) -> Result<Self, String>;

    /// The value of a variable, of the row's type, after everything set so far.
    fn get(&mut self, variable: Self::Variable) -> Value;

    /// Gives a variable a value.
    fn set(&mut self, variable: Self::Variable, value: &Value);

    /// Leaves initialization mode at `start_time` (s).
    ///
    /// # Errors
    /// A text for people; the call returns `fmi2Error`.
    fn exit_initialization(&mut self, start_time: f64, log: &mut Log) -> Result<(), String>;

    /// Advances from `time` by `step` (both s, `step` > 0).
    ///
    /// `time` is what the importer says, within a thousandth of a step of what it should be:
    /// advance states by `step`, never by a difference of times.
    ///
    /// # Errors
    /// A text for people; the call returns `fmi2Error`.
    fn step(&mut self, time: f64, step: f64, log: &mut Log) -> Result<(), String>;

    /// The continuous states, a pure function of the resources.
    fn states(&self) -> Vec<StateSpec> {
        Vec::new()
    }

    /// The value of a state, after everything set so far.
    fn state(&mut self, _index: usize) -> f64 {
        0.0
    }

    /// The derivative of a state by time, at the present inputs, 1/s times its unit.
    fn state_derivative(&mut self, _index: usize) -> f64 {
        0.0
    }

    /// Gives a settable state its value at the start. Called before the first step; later on clones
    /// alone, for the differences of [`Slave::partial_derivative`].
    fn set_state(&mut self, _index: usize, _value: f64) {}

    /// Lets an input grow by `derivative` (its unit per second) within the next step. The layer
    /// sets it back to zero after that step; the input itself stays what was set.
    fn set_input_derivative(&mut self, _variable: Self::Variable, _derivative: f64) {}

    /// The derivative by time of a Real output at this communication point.
    fn output_derivative(&mut self, _variable: Self::Variable) -> f64 {
        0.0
    }

    /// How an unknown depends on a known; `None` where the partial derivative is zero whatever the
    /// values. By default what the table says of outputs and inputs, and everything of states and
    /// derivatives.
    ///
    /// Outputs are asked about at communication points. What they depend on in initialization mode
    /// among the variables is the table's `initial_depends_on`; states and derivatives are asked
    /// about for both, and then by variables with `initial="exact"` besides.
    fn dependency(
        &self,
        unknown: Unknown<Self::Variable>,
        known: Known<Self::Variable>,
    ) -> Option<DependencyKind> {
        crate::structure::table_dependency::<Self>(unknown, known)
    }

    /// `∂unknown/∂known` at the present values; where it is `None`, the layer takes central
    /// differences on clones.
    fn partial_derivative(
        &mut self,
        _unknown: Unknown<Self::Variable>,
        _known: Known<Self::Variable>,
    ) -> Option<f64> {
        None
    }

    /// All that can differ from what [`Slave::open`] makes of the same resources, as bytes; the same
    /// bytes for the same state. Pending derivatives of inputs are the layer's to keep.
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Takes over what [`Slave::save`] gave, perhaps in another process. `self` is as
    /// [`Slave::open`] made it. The bytes have passed a checksum and may still be anything.
    ///
    /// # Errors
    /// A text for people; the instance keeps its state.
    fn load(&mut self, _bytes: &[u8]) -> Result<(), String> {
        Err("this model has no serialized states".into())
    }
}
