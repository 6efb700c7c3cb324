//! Why an archive could not be made.

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The document is of no kind that an FMU is made from.
    #[error("{file}: no FMU is made from {found}")]
    NotPackable {
        /// The document's name as the caller gave it.
        file: String,
        /// Its schema, or the description of a file without one.
        found: String,
    },
    /// The document is refused by its schema.
    #[error(transparent)]
    Document(#[from] steerwright_formats::Error),
    /// The slave refuses the document.
    #[error("{file}: {source}")]
    Slave {
        /// The document's name as the caller gave it.
        file: String,
        /// Why.
        source: steerwright_slaves::Error,
    },
    /// There is no library to put in.
    #[error("{fmu}: no library for any platform")]
    NoBinary {
        /// The FMU.
        fmu: &'static str,
    },
    /// FMI has no platform of that name.
    #[error("`{platform}` is no platform of FMI 2.0")]
    Platform {
        /// The name.
        platform: String,
    },
    /// Two libraries are for one platform.
    #[error("{fmu}: two libraries for {platform}")]
    TwoBinaries {
        /// The FMU.
        fmu: &'static str,
        /// The platform.
        platform: String,
    },
    /// The FMU fails on the inputs of its reference run.
    #[error("{file}: the reference run fails at {time} s: {problem}")]
    Reference {
        /// The document's name as the caller gave it.
        file: String,
        /// When, in seconds.
        time: f64,
        /// The slave's reason.
        problem: String,
    },
    /// The step size is no step size.
    #[error("the step size is {step}, expected a number above 0")]
    Step {
        /// The step size.
        step: f64,
    },
    /// Names do not determine the source of an input.
    #[error(transparent)]
    Wiring(Box<steerwright_host::Error>),
    /// A system names a variable that does not exist or has the wrong causality.
    #[error("the system has no {need} {variable}")]
    NoVariable {
        /// The variable, `component.variable`.
        variable: String,
        /// The required kind of variable.
        need: &'static str,
    },
    /// The ends of a connection are not alike.
    #[error("{connection}: the ends differ in type or unit")]
    Connection {
        /// From output to input.
        connection: String,
    },
    /// Writing the package of a system failed.
    #[error("{name}.ssp: {source}")]
    Package {
        /// The system.
        name: String,
        /// Why.
        source: zip::result::ZipError,
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
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::NotPackable { .. } => {
                let kinds = steerwright_slaves::Fmu::ALL.map(steerwright_slaves::Fmu::schema).join(", ");
                format!("give a file whose \"schema\" is one of {kinds}")
            }
            Self::Document(error) => error.hint(),
            Self::Slave { .. } => "make the file again with the command that writes it".into(),
            Self::NoBinary { .. } => {
                "this build holds no FMU libraries; build steerwright without STEERWRIGHT_FMU_BINARIES"
                    .into()
            }
            Self::Platform { .. } => "the names are win32, win64, linux32, linux64, darwin32, \
                darwin64, and <architecture>-<system> for others, such as aarch64-linux"
                .into(),
            Self::TwoBinaries { .. } => "give one library for each platform".into(),
            Self::Reference { .. } => {
                "the model does not stand its own operating point: correct the file it is made from".into()
            }
            Self::Step { .. } => "give the step in seconds, such as 10ms".into(),
            Self::Wiring(_) => "wire one of them alone: leave out the files of the others".into(),
            Self::NoVariable { .. } => "name a variable of a component, as component.variable".into(),
            Self::Connection { .. } => "connect variables of the same type and unit".into(),
            Self::Zip { .. } | Self::Package { .. } => "check the free space and try again".into(),
        }
    }
}
