//! What an FMU's author writes.

use crate::{Log, Resources};
use model_description::{Table, Value, VariableSpec};

/// A variable of an FMU: usually an enum with one member for each row of the table.
pub trait VariableId: Copy + 'static {
    /// The variable with that value reference.
    fn from_reference(reference: u32) -> Option<Self>;

    /// Its row of the table.
    fn spec(self) -> &'static VariableSpec;
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
}
