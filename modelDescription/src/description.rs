//! The content of a `modelDescription.xml`.

use crate::legality::default_initial;
use crate::units::Unit;
use crate::vocabulary::{
    Causality, DependencyKind, Initial, Kind, NamingConvention, Value, Variability,
};

/// The content of a `modelDescription.xml` of FMI 2.0.
#[derive(Debug, Clone, PartialEq, Default)]
#[allow(missing_docs)] // the names are those of the standard
pub struct ModelDescription {
    pub model_name: String,
    /// `guid`, which the binary requires at instantiation.
    pub guid: String,
    pub description: Option<String>,
    pub author: Option<String>,
    pub version: Option<String>,
    pub copyright: Option<String>,
    pub license: Option<String>,
    pub generation_tool: Option<String>,
    pub naming_convention: NamingConvention,
    pub co_simulation: Option<CoSimulation>,
    /// Its model-exchange side, if it has one. This project only reads it.
    pub model_exchange: Option<ModelExchange>,
    pub units: Vec<Unit>,
    pub log_categories: Vec<LogCategory>,
    pub default_experiment: Option<DefaultExperiment>,
    /// Annotations of other tools.
    pub vendor_annotations: Vec<VendorAnnotation>,
    /// The variables; `Unknown::index` counts them from 1.
    pub variables: Vec<Variable>,
    pub outputs: Vec<Unknown>,
    pub derivatives: Vec<Unknown>,
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
#[allow(missing_docs)] // the names are those of the standard
pub struct CoSimulation {
    /// The binary's name without its ending: a C identifier.
    pub model_identifier: String,
    pub needs_execution_tool: bool,
    pub can_handle_variable_communication_step_size: bool,
    pub can_interpolate_inputs: bool,
    pub max_output_derivative_order: u32,
    /// `canRunAsynchronuously` (the standard's spelling).
    pub can_run_asynchronously: bool,
    pub can_be_instantiated_only_once_per_process: bool,
    pub can_not_use_memory_management_functions: bool,
    pub can_get_and_set_fmu_state: bool,
    pub can_serialize_fmu_state: bool,
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
#[allow(missing_docs)] // the names are those of the standard
pub struct DefaultExperiment {
    pub start_time: Option<f64>,
    pub stop_time: Option<f64>,
    pub tolerance: Option<f64>,
    pub step_size: Option<f64>,
}

/// A category that log messages cite.
#[derive(Debug, Clone, PartialEq, Eq)]
#[allow(missing_docs)] // the names are those of the standard
pub struct LogCategory {
    pub name: String,
    pub description: Option<String>,
}

/// The annotation of a tool under `VendorAnnotations`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VendorAnnotation {
    /// Name of the tool.
    pub tool: String,
    /// The XML in `<Tool>`, trimmed. Written back only where it is well-formed by itself.
    pub xml: String,
}

/// `ScalarVariable`. The defaults are those of the standard.
#[derive(Debug, Clone, PartialEq, Default)]
#[allow(missing_docs)] // the names are those of the standard
pub struct Variable {
    pub name: String,
    pub reference: u32,
    /// Type; an Enumeration is Integer here.
    pub kind: Kind,
    pub is_enumeration: bool,
    pub description: Option<String>,
    pub causality: Causality,
    pub variability: Variability,
    /// How it is initialized, as given; see [`Variable::effective_initial`].
    pub initial: Option<Initial>,
    /// `canHandleMultipleSetPerTimeInstant`, as given.
    pub can_handle_multiple_set: Option<bool>,
    /// Unit, its own or of its declared type.
    pub unit: Option<String>,
    pub display_unit: Option<String>,
    pub quantity: Option<String>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub nominal: Option<f64>,
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
