//! The content of a `modelDescription.xml`.

use crate::{
    Causality, DependencyKind, Initial, Kind, NamingConvention, Unit, Value, Variability,
    default_initial,
};

/// The content of a `modelDescription.xml` of FMI 2.0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelDescription {
    /// `modelName`.
    pub model_name: String,
    /// `guid`, which the binary requires at instantiation.
    pub guid: String,
    /// A description of one line.
    pub description: Option<String>,
    /// Who wrote the model.
    pub author: Option<String>,
    /// Version of the model.
    pub version: Option<String>,
    /// Copyright notice.
    pub copyright: Option<String>,
    /// Licence of the model.
    pub license: Option<String>,
    /// The tool that made the FMU.
    pub generation_tool: Option<String>,
    /// How names are built.
    pub naming_convention: NamingConvention,
    /// Its co-simulation side, if it has one.
    pub co_simulation: Option<CoSimulation>,
    /// Its model-exchange side, if it has one. This project only reads it.
    pub model_exchange: Option<ModelExchange>,
    /// Units that variables cite.
    pub units: Vec<Unit>,
    /// Categories that log messages cite.
    pub log_categories: Vec<LogCategory>,
    /// Default experiment.
    pub default_experiment: Option<DefaultExperiment>,
    /// Annotations of other tools.
    pub vendor_annotations: Vec<VendorAnnotation>,
    /// The variables; `Unknown::index` counts them from 1.
    pub variables: Vec<Variable>,
    /// `ModelStructure/Outputs`.
    pub outputs: Vec<Unknown>,
    /// `ModelStructure/Derivatives`.
    pub derivatives: Vec<Unknown>,
    /// `ModelStructure/InitialUnknowns`.
    pub initial_unknowns: Vec<Unknown>,
}

impl ModelDescription {
    /// A description with no variables, to be filled.
    #[must_use]
    pub fn new(model_name: &str, guid: &str) -> Self {
        Self { model_name: model_name.into(), guid: guid.into(), ..Self::default() }
    }

    /// The variable with that name.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// The variable an `Unknown` or dependency means: indices count from 1.
    #[must_use]
    pub fn variable_at(&self, index: u32) -> Option<&Variable> {
        self.variables.get(usize::try_from(index).ok()?.checked_sub(1)?)
    }
}

/// `CoSimulation`: the binary and its capabilities.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CoSimulation {
    /// The binary's name without its ending: a C identifier.
    pub model_identifier: String,
    /// `needsExecutionTool`.
    pub needs_execution_tool: bool,
    /// `canHandleVariableCommunicationStepSize`.
    pub can_handle_variable_communication_step_size: bool,
    /// `canInterpolateInputs`.
    pub can_interpolate_inputs: bool,
    /// `maxOutputDerivativeOrder`.
    pub max_output_derivative_order: u32,
    /// `canRunAsynchronuously` (the standard's spelling).
    pub can_run_asynchronously: bool,
    /// `canBeInstantiatedOnlyOncePerProcess`.
    pub can_be_instantiated_only_once_per_process: bool,
    /// `canNotUseMemoryManagementFunctions`.
    pub can_not_use_memory_management_functions: bool,
    /// `canGetAndSetFMUstate`.
    pub can_get_and_set_fmu_state: bool,
    /// `canSerializeFMUstate`.
    pub can_serialize_fmu_state: bool,
    /// `providesDirectionalDerivative`.
    pub provides_directional_derivative: bool,
    /// `SourceFiles`: names below `sources/`.
    pub source_files: Vec<String>,
}

/// `ModelExchange`, as far as an importer for co-simulation cares.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ModelExchange {
    /// The binary's name without its ending.
    pub model_identifier: String,
}

/// `DefaultExperiment`; times in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DefaultExperiment {
    /// `startTime`.
    pub start_time: Option<f64>,
    /// `stopTime`.
    pub stop_time: Option<f64>,
    /// `tolerance`.
    pub tolerance: Option<f64>,
    /// `stepSize`.
    pub step_size: Option<f64>,
}

/// A category that log messages cite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogCategory {
    /// Its name.
    pub name: String,
    /// Its description.
    pub description: Option<String>,
}

/// The annotation of a tool under `VendorAnnotations`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VendorAnnotation {
    /// Name of the tool.
    pub tool: String,
    /// The XML between `<Tool>` and `</Tool>`, trimmed. Written back only where it is well-formed
    /// by itself.
    pub xml: String,
}

/// `ScalarVariable`. The defaults are those of the standard.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// Value reference.
    pub reference: u32,
    /// Type; an Enumeration is Integer here.
    pub kind: Kind,
    /// Whether the XML type is Enumeration.
    pub is_enumeration: bool,
    /// A description of one line.
    pub description: Option<String>,
    /// Its causality.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// How it is initialized, as given; see [`Variable::effective_initial`].
    pub initial: Option<Initial>,
    /// `canHandleMultipleSetPerTimeInstant`, as given.
    pub can_handle_multiple_set: Option<bool>,
    /// Unit, its own or of its declared type.
    pub unit: Option<String>,
    /// Unit to show it in.
    pub display_unit: Option<String>,
    /// Physical quantity.
    pub quantity: Option<String>,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
    /// Typical magnitude.
    pub nominal: Option<f64>,
    /// Start value.
    pub start: Option<Value>,
    /// Index, from 1, of the state whose derivative this is.
    pub derivative: Option<u32>,
}

impl Variable {
    /// The `initial` that holds: the one given or the standard's default.
    #[must_use]
    pub fn effective_initial(&self) -> Option<Initial> {
        self.initial.or_else(|| default_initial(self.causality, self.variability))
    }
}

/// An unknown of the model structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// Index of the variable, from 1.
    pub index: u32,
    /// Indices of the knowns it depends on; `None` means all of them, empty means none.
    pub dependencies: Option<Vec<u32>>,
    /// How it depends on each.
    pub kinds: Option<Vec<DependencyKind>>,
}
