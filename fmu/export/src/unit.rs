//! The trait that the author of an FMU implements.

use crate::log::Log;
use crate::resources::Resources;
use model_description::{DependencyKind, DependsOn, Table, Unit, Value, VariableSpec};

/// A variable of an FMU: usually an enum with one variant for each row of the table.
pub trait VariableId: Copy + 'static {
    /// The variable with that value reference.
    fn from_reference(reference: u32) -> Option<Self>;

    /// Its row of the table.
    fn spec(self) -> &'static VariableSpec;
}

/// The optional capabilities of a unit; each field is a capability flag of the description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Capabilities {
    /// [`CoSimulationUnit::set_input_derivative`] has an effect: `canInterpolateInputs`.
    pub interpolates_inputs: bool,
    /// [`CoSimulationUnit::output_derivative`] is implemented: `maxOutputDerivativeOrder` is 1.
    pub output_derivatives: bool,
    /// Directional derivatives are available: `providesDirectionalDerivative`.
    pub directional_derivatives: bool,
    /// [`CoSimulationUnit::save`] and [`CoSimulationUnit::load`] are implemented: `canSerializeFMUstate`.
    pub serializes: bool,
}

impl Capabilities {
    /// No optional capability.
    pub const NONE: Self = Self {
        interpolates_inputs: false,
        output_derivatives: false,
        directional_derivatives: false,
        serializes: false,
    };

    /// All optional capabilities.
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
    /// A description of one line.
    pub description: String,
    /// Its unit, one of [`model_description::UNITS`].
    pub unit: Option<&'static str>,
    /// The unit of its derivative.
    pub derivative_unit: Option<&'static str>,
    /// Whether its initial value can be set (`initial="exact"`); otherwise it is calculated from other
    /// start values (`initial="calculated"`).
    pub settable: bool,
}

/// What the resources of an archive state of a variable in place of its row.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedVariable {
    /// Its name, unlike that of any other variable.
    pub name: String,
    /// Its unit; one that is not of [`model_description::UNITS`] enters the description as it is.
    pub unit: Option<Unit>,
    /// Its typical magnitude.
    pub nominal: Option<f64>,
    /// A description of one line.
    pub description: String,
}

/// The numerator of a partial derivative. States are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown<V> {
    /// An output.
    Variable(V),
    /// The derivative of a state.
    Derivative(usize),
    /// A state that is not settable; in initialization mode only.
    State(usize),
}

/// The denominator of a partial derivative. States are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known<V> {
    /// An input, or, in initialization mode, a variable with `initial="exact"`.
    Variable(V),
    /// A state; in initialization mode a settable one.
    State(usize),
}

/// The model of an FMU: everything that the C layer needs.
///
/// The state of an instance is the value itself: `fmi2GetFMUstate` clones it, `fmi2Reset` restores a
/// clone of the value that [`CoSimulationUnit::open`] returned. Keep constant data behind an `Arc`.
///
/// The layer checks all arguments of these functions: the call is legal in the instance's state,
/// values have the row's type, are finite and within its limits, times are finite and increase. A
/// panic becomes `fmi2Fatal` for this instance only.
pub trait CoSimulationUnit: Clone + Send + Sized + 'static {
    /// Its variables.
    type Variable: VariableId;

    /// The table of its variables; refer to a `const` or `static` item, so that the compiler checks it.
    const TABLE: &'static Table;

    /// Its optional capabilities; the functions of other capabilities are never called.
    const CAPABILITIES: Capabilities = Capabilities::NONE;

    /// Creates an instance from the files in `resources/` of the archive.
    ///
    /// # Errors
    /// A message for the log; `fmi2Instantiate` fails.
    fn open(resources: &Resources) -> Result<Self, String>;

    /// Whether the archive has a variable of the table. The rows of the others are not in its description, and their
    /// value references are unknown. Depends on the resources only.
    #[inline]
    fn has(&self, _variable: Self::Variable) -> bool {
        true
    }

    /// What the resources state of a variable; `None` leaves its row as it is. Depends on the resources only.
    fn stated(&self, _variable: Self::Variable) -> Option<StatedVariable> {
        None
    }

    /// The value of a variable, of the row's type, after everything set so far.
    fn get(&mut self, variable: Self::Variable) -> Value;

    /// Sets a variable.
    fn set(&mut self, variable: Self::Variable, value: &Value);

    /// Leaves initialization mode at `start_time` (s).
    ///
    /// # Errors
    /// A message for the log; the call returns `fmi2Error`.
    fn exit_initialization(&mut self, start_time: f64, log: &mut Log) -> Result<(), String>;

    /// Advances from `time` by `step` (both s, `step` > 0).
    ///
    /// `time` comes from the importer and is within a thousandth of a step of the expected time:
    /// advance states by `step`, never by a difference of times.
    ///
    /// # Errors
    /// A message for the log; the call returns `fmi2Error`.
    fn step(&mut self, time: f64, step: f64, log: &mut Log) -> Result<(), String>;

    /// The continuous states. The list depends on the resources only.
    fn states(&self) -> Vec<StateSpec> {
        Vec::new()
    }

    /// The value of a state, after everything set so far.
    fn state(&mut self, _index: usize) -> f64 {
        0.0
    }

    /// The time derivative of a state at the present inputs, in the state's unit per second.
    fn state_derivative(&mut self, _index: usize) -> f64 {
        0.0
    }

    /// Sets the initial value of a settable state. Called before the first step; afterwards only on
    /// clones, for the central differences of [`CoSimulationUnit::partial_derivative`].
    fn set_state(&mut self, _index: usize, _value: f64) {}

    /// Sets the time derivative of an input (its unit per second) within the next step. The layer
    /// sets it to zero after that step; the value of the input does not change.
    fn set_input_derivative(&mut self, _variable: Self::Variable, _derivative: f64) {}

    /// The time derivative of a Real output at this communication point.
    fn output_derivative(&mut self, _variable: Self::Variable) -> f64 {
        0.0
    }

    /// How an unknown depends on a known; `None` if the partial derivative is always zero. The default
    /// takes the dependencies of outputs on inputs from the table and lets states and derivatives
    /// depend on everything.
    ///
    /// For outputs this is the dependency at communication points; their dependencies on variables in
    /// initialization mode are the table's `initial_depends_on`. For states and derivatives it is the
    /// dependency in both modes, in initialization mode also on variables with `initial="exact"`.
    fn dependency(
        &self,
        unknown: Unknown<Self::Variable>,
        known: Known<Self::Variable>,
    ) -> Option<DependencyKind> {
        match (unknown, known) {
            (Unknown::Variable(unknown), Known::Variable(known)) => {
                listed(unknown.spec().depends_on, known)
            }
            _ => Some(DependencyKind::Dependent),
        }
    }

    /// `∂unknown/∂known` at the present values; for `None` the layer takes a central difference on clones.
    fn partial_derivative(
        &mut self,
        _unknown: Unknown<Self::Variable>,
        _known: Known<Self::Variable>,
    ) -> Option<f64> {
        None
    }

    /// Everything that can differ from a unit opened from the same resources, as bytes; equal states
    /// return equal bytes. The layer saves the derivatives of inputs itself.
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Restores the bytes of [`CoSimulationUnit::save`], possibly from another process. `self` is a unit that
    /// [`CoSimulationUnit::open`] returned. The checksum of the bytes is correct, but they may still be invalid.
    ///
    /// # Errors
    /// A message for the log; the instance keeps its state.
    fn load(&mut self, _bytes: &[u8]) -> Result<(), String> {
        Err("this model has no serialized states".into())
    }
}

/// The dependency on a known that a column of the table lists.
pub(crate) fn listed(depends_on: DependsOn, known: impl VariableId) -> Option<DependencyKind> {
    let depends = match depends_on {
        DependsOn::Nothing => false,
        DependsOn::All => true,
        DependsOn::On(names) => names.contains(&known.spec().name),
    };
    if depends { Some(DependencyKind::Dependent) } else { None }
}
