//! Why a description cannot be read or built.

use crate::Kind;

/// Why a model description cannot be read or built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The text is not XML.
    #[error("modelDescription.xml:{line}:{column}: not well-formed XML: {problem}")]
    Malformed {
        /// Line, from 1.
        line: u32,
        /// Column, from 1.
        column: u32,
        /// Message of the parser.
        problem: String,
    },
    /// The XML declares a document type, which could define entities.
    #[error("modelDescription.xml has a document type declaration, which is rejected")]
    DocumentType,
    /// The document is something else, or of another version of FMI.
    #[error(
        "modelDescription.xml:{line}: expected fmiModelDescription of fmiVersion 2.0, found {found}"
    )]
    NotFmi2 {
        /// Line, from 1.
        line: u32,
        /// The value found.
        found: String,
    },
    /// An attribute that the standard requires is absent.
    #[error("modelDescription.xml:{line}: <{element}> has no attribute `{attribute}`")]
    MissingAttribute {
        /// Line, from 1.
        line: u32,
        /// The element.
        element: String,
        /// The attribute.
        attribute: &'static str,
    },
    /// An element that the standard requires is absent.
    #[error("modelDescription.xml:{line}: <{element}> has no <{child}>")]
    MissingElement {
        /// Line, from 1.
        line: u32,
        /// The element.
        element: String,
        /// The element that should be in it.
        child: &'static str,
    },
    /// An attribute has a value that cannot be.
    #[error(
        "modelDescription.xml:{line}: <{element}>: `{attribute}` is \"{value}\", expected {expected}"
    )]
    InvalidAttribute {
        /// Line, from 1.
        line: u32,
        /// The element.
        element: String,
        /// The attribute.
        attribute: &'static str,
        /// Its value, shortened.
        value: String,
        /// The expected value.
        expected: &'static str,
    },
    /// There are more or fewer start values than variables.
    #[error("{model}: {got} start values for {need} variables")]
    StartCount {
        /// The model's name.
        model: &'static str,
        /// Values given.
        got: usize,
        /// Variables of the table.
        need: usize,
    },
    /// A start value has the wrong type.
    #[error("{model}: the start value of `{variable}` is {got}, the variable is {need}")]
    StartKind {
        /// The model's name.
        model: &'static str,
        /// The variable's name.
        variable: &'static str,
        /// Type of the value.
        got: Kind,
        /// Type of the variable.
        need: Kind,
    },
    /// A start value is not finite or outside the variable's limits.
    #[error("{model}: the start value {value} of `{variable}` is not within [{min}, {max}]")]
    StartRange {
        /// The model's name.
        model: &'static str,
        /// The variable's name.
        variable: &'static str,
        /// The value.
        value: f64,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
    },
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
