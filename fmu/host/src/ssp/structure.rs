//! What a flat `SystemStructure.ssd` says.

use model_description::Value;

use crate::Connection;

/// Components that are FMUs, the connections between them, and the values they start with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SystemStructure {
    /// The system's name.
    pub name: String,
    /// In the order of the file, which is that in which a Gauss–Seidel master steps them.
    pub components: Vec<Component>,
    /// As written; SSP gives start and end no direction (see [`SystemPackage::system`]).
    ///
    /// [`SystemPackage::system`]: crate::SystemPackage::system
    pub connections: Vec<Connection>,
    /// Start of the default experiment, s.
    pub start_time: Option<f64>,
    /// Stop of the default experiment, s.
    pub stop_time: Option<f64>,
    /// Base step of the `osp:FixedStepAlgorithm`, s.
    pub step: Option<f64>,
    /// What was left out of account.
    pub remarks: Vec<String>,
}

/// An FMU in a system.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Component {
    /// What connections call it.
    pub name: String,
    /// Where it lies in the package, such as `resources/Plant.fmu`.
    pub source: String,
    /// Values to start with; of several for one variable the last counts.
    pub parameters: Vec<Parameter>,
}

/// A value that a variable starts with.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The variable.
    pub name: String,
    /// Its value.
    pub value: Value,
    /// The value's unit, where one is stated.
    pub unit: Option<String>,
}
