//! Why a description cannot be read or built.

use crate::vocabulary::Kind;

/// Why a model description cannot be read or built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("modelDescription.xml:{line}:{column}: not well-formed XML: {problem}")]
    Malformed { line: u32, column: u32, problem: String },
    #[error("modelDescription.xml has a document type declaration, which is rejected")]
    DocumentType,
    #[error(
        "modelDescription.xml:{line}: expected fmiModelDescription of fmiVersion 2.0, found {found}"
    )]
    NotFmi2 { line: u32, found: String },
    #[error("modelDescription.xml:{line}: <{element}> has no attribute `{attribute}`")]
    MissingAttribute { line: u32, element: String, attribute: &'static str },
    #[error("modelDescription.xml:{line}: <{element}> has no <{child}>")]
    MissingElement { line: u32, element: String, child: &'static str },
    #[error(
        "modelDescription.xml:{line}: <{element}>: `{attribute}` is \"{value}\", expected {expected}"
    )]
    InvalidAttribute {
        line: u32,
        element: String,
        attribute: &'static str,
        value: String,
        expected: &'static str,
    },
    #[error("{model}: {got} start values for {need} variables")]
    StartCount { model: &'static str, got: usize, need: usize },
    #[error("{model}: the start value of `{variable}` is {got}, the variable is {need}")]
    StartKind { model: &'static str, variable: &'static str, got: Kind, need: Kind },
    #[error("{model}: the start value {value} of `{variable}` is not within [{min}, {max}]")]
    StartRange { model: &'static str, variable: &'static str, value: f64, min: f64, max: f64 },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Malformed { .. } | Self::DocumentType => {
                "export the FMU again; its modelDescription.xml must be plain XML without a DOCTYPE"
                    .into()
            }
            Self::NotFmi2 { .. } => "export the FMU as FMI 2.0 for Co-Simulation".into(),
            Self::MissingAttribute { .. }
            | Self::MissingElement { .. }
            | Self::InvalidAttribute { .. } => {
                "report this to the author of the FMU: the description violates the FMI 2.0 schema".into()
            }
            Self::StartCount { .. } | Self::StartKind { .. } => {
                "pass one start value for each row of the table, of the row's type, in the order of the rows"
                    .into()
            }
            Self::StartRange { variable, min, max, .. } => {
                format!("set `{variable}` to a value from {min} to {max} in the resource file")
            }
        }
    }
}
