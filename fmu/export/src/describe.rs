//! From a slave to the description that goes into its archive.

use crate::{Known, LOG_CATEGORIES, Log, Resources, Slave, Unknown, VariableId};
use model_description::{
    CoSimulation, DefaultExperiment, DependencyKind, DependsOn, LogCategory, ModelDescription,
    Value,
};

/// Why a slave cannot be described.
#[derive(Debug, thiserror::Error)]
pub enum DescribeError {
    /// The slave refuses its resources.
    #[error("{model} cannot be made from these resources: {problem}")]
    Open {
        /// The model's name.
        model: &'static str,
        /// The slave's reason.
        problem: String,
    },
    /// The slave cannot be initialized with its start values.
    #[error("{model} cannot be initialized with its start values: {problem}")]
    Initialize {
        /// The model's name.
        model: &'static str,
        /// The slave's reason.
        problem: String,
    },
    /// A row of the table has no variable.
    #[error("{model}: the slave knows no variable for `{variable}`, value reference {reference}")]
    Unmapped {
        /// The model's name.
        model: &'static str,
        /// The row's name.
        variable: &'static str,
        /// The row's value reference.
        reference: u32,
    },
    /// A start value contradicts the table.
    #[error(transparent)]
    Start(#[from] model_description::Error),
}

impl DescribeError {
    /// What the reader can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Open { .. } | Self::Initialize { .. } => {
                "mend the resource file, or make it again with the command that writes it".into()
            }
            Self::Unmapped { .. } => "let the enum of the variables have every row".into(),
            Self::Start(error) => error.hint(),
        }
    }
}

/// What this layer can do, whatever the slave.
pub const CAPABILITIES: CoSimulation = CoSimulation {
    model_identifier: String::new(),
    needs_execution_tool: false,
    can_handle_variable_communication_step_size: true,
    can_interpolate_inputs: false,
    max_output_derivative_order: 0,
    can_run_asynchronously: false,
    can_be_instantiated_only_once_per_process: false,
    // Rust has an allocator of its own.
    can_not_use_memory_management_functions: true,
    can_get_and_set_fmu_state: true,
    can_serialize_fmu_state: false,
    provides_directional_derivative: false,
    source_files: Vec::new(),
};

/// The GUID of this slave with these resources: what `fmi2Instantiate` expects.
#[must_use]
pub fn guid<S: Slave>(resources: &Resources) -> String {
    model_description::guid(S::TABLE, resources.entries())
}

/// The description of this slave with these resources.
///
/// The start values are those read at a communication point after an initialization, at the
/// experiment's start time, in which nothing was set.
///
/// # Errors
/// [`DescribeError`] if the slave refuses the resources or contradicts its table.
pub fn describe<S: Slave>(
    resources: &Resources,
    default_experiment: Option<DefaultExperiment>,
) -> Result<ModelDescription, DescribeError> {
    let table = S::TABLE;
    let model = table.model_name;
    let mut slave = S::open(resources).map_err(|problem| DescribeError::Open { model, problem })?;
    let start_time = default_experiment.and_then(|e| e.start_time).unwrap_or(0.0);
    slave
        .exit_initialization(start_time, &mut Log::default())
        .map_err(|problem| DescribeError::Initialize { model, problem })?;
    let start = table
        .variables
        .iter()
        .map(|row| match S::Variable::from_reference(row.reference) {
            Some(variable) if variable.spec().name == row.name => Ok(slave.get(variable)),
            _ => {
                Err(DescribeError::Unmapped { model, variable: row.name, reference: row.reference })
            }
        })
        .collect::<Result<Vec<Value>, _>>()?;
    let guid = guid::<S>(resources);
    let mut description = ModelDescription::from_table(table, &start, &guid, default_experiment)?;
    description.co_simulation =
        Some(CoSimulation { model_identifier: model.into(), ..CAPABILITIES.clone() });
    description.log_categories = LOG_CATEGORIES
        .iter()
        .map(|&(name, text)| LogCategory { name: name.into(), description: Some(text.into()) })
        .collect();
    Ok(description)
}

/// What the table says of a dependency at a communication point.
pub(crate) fn table_dependency<S: Slave>(
    unknown: Unknown<S::Variable>,
    known: Known<S::Variable>,
) -> Option<DependencyKind> {
    let (Unknown::Variable(unknown), Known::Variable(known)) = (unknown, known) else {
        return Some(DependencyKind::Dependent);
    };
    let depends = match unknown.spec().depends_on {
        DependsOn::Nothing => false,
        DependsOn::All => true,
        DependsOn::On(names) => names.contains(&known.spec().name),
    };
    depends.then_some(DependencyKind::Dependent)
}
