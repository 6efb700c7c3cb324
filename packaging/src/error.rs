//! Why an archive could not be made.

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The document is of no kind that an FMU is made from.
    #[error("{file}: no FMU is made from {found}")]
    NotPackable {
        /// The document's name as the caller gave it.
        file: String,
        /// Its schema, or what stands in its place.
        found: String,
    },
    /// The document is refused by its schema.
    #[error(transparent)]
    Document(#[from] formats::Error),
    /// The slave refuses the document.
    #[error("{file}: {source}")]
    Slave {
        /// The document's name as the caller gave it.
        file: String,
        /// Why.
        source: slaves::Error,
    },
    /// There is no library to put in.
    #[error("{fmu}: no library for any platform")]
    NoBinary {
        /// The FMU.
        fmu: &'static str,
    },
    /// The step size is no step size.
    #[error("the step size is {step}, expected a number above 0")]
    Step {
        /// The step size.
        step: f64,
    },
    /// Writing the archive failed.
    #[error("{fmu}.fmu: {source}")]
    Zip {
        /// The FMU.
        fmu: &'static str,
        /// Why.
        source: zip::result::ZipError,
    },
}

impl Error {
    /// What the reader can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::NotPackable { .. } => {
                let kinds = slaves::Fmu::ALL.map(slaves::Fmu::schema).join(", ");
                format!("give a file whose \"schema\" is one of {kinds}")
            }
            Self::Document(error) => error.hint(),
            Self::Slave { .. } => "make the file again with the command that writes it".into(),
            Self::NoBinary { .. } => {
                "this build holds no FMU libraries; build steerwright without STEERWRIGHT_FMU_BINARIES"
                    .into()
            }
            Self::Step { .. } => "give the step in seconds, such as 10ms".into(),
            Self::Zip { .. } => "check the free space and try again".into(),
        }
    }
}
