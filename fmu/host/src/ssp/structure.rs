//! The content of a `SystemStructure.ssd`, without the systems inside the system.

use model_description::{BaseUnit, Unit, Value};

use crate::system::{Connection, Linear};

/// Components that are FMUs, the connections between them, and the values they start with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SystemStructure {
    /// The system's name.
    pub name: String,
    /// In the order of the file, which is that in which a Gauss–Seidel coupling steps them.
    pub components: Vec<Component>,
    /// The connectors of the system itself.
    pub connectors: Vec<Connector>,
    /// Values that its input connectors have without a source; of several for one the last counts.
    pub parameters: Vec<Parameter>,
    /// Which inputs of components its input connectors feed.
    pub inputs: Vec<SystemInput>,
    /// As written; start and end of SSP have no direction (see [`SystemPackage::system`]).
    ///
    /// [`SystemPackage::system`]: crate::SystemPackage::system
    pub connections: Vec<Connection>,
    /// Where each connection is written, and whether it forbids converting units.
    pub(super) written: Vec<WrittenConnection>,
    /// The units that the file defines.
    pub units: Vec<Unit>,
    /// Start of the default experiment, s.
    pub start_time: Option<f64>,
    /// Stop of the default experiment, s.
    pub stop_time: Option<f64>,
    /// Base step of the `osp:FixedStepAlgorithm`, s.
    pub step: Option<f64>,
    /// Ignored content.
    pub remarks: Vec<String>,
}

impl SystemStructure {
    /// An input connector of the system itself.
    pub(super) fn input_connector(&self, name: &str) -> Option<&Connector> {
        self.connectors.iter().find(|c| c.name == name && c.kind == "input")
    }
}

/// A connection from an input connector of the system to an input of a component.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemInput {
    /// The connector of the system.
    pub connector: String,
    /// The component.
    pub component: String,
    /// Its input.
    pub input: String,
    pub(super) written: WrittenConnection,
}

/// An FMU in a system.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Component {
    /// Its name in connections.
    pub name: String,
    /// Where it lies in the package, such as `resources/Plant.fmu`.
    pub source: String,
    /// Its variables in the file.
    pub connectors: Vec<Connector>,
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
    /// That unit in base units, where the file of the value defines it.
    pub base: Option<BaseUnit>,
    /// Where the value is written.
    pub place: SspPlace,
}

/// A variable of an FMU, or a signal of the system, as the package describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Connector {
    /// The variable or signal.
    pub name: String,
    /// `input`, `output`, `parameter` or `calculatedParameter`.
    pub kind: String,
    /// `Real`, `Integer`, `Boolean`, `String`, `Enumeration` or `Binary`, where one is stated.
    pub of_type: Option<String>,
    /// Its unit, where one is stated.
    pub unit: Option<String>,
    /// Where it is written.
    pub place: SspPlace,
}

/// A line of a file of a package.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SspPlace {
    /// The file, such as `SystemStructure.ssd`.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
}

impl std::fmt::Display for SspPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// How a connection is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WrittenConnection {
    pub(super) place: SspPlace,
    /// `suppressUnitConversion`.
    pub(super) suppressed: bool,
    /// `LinearTransformation`, of the value of the source.
    pub(super) transformation: Linear,
}
