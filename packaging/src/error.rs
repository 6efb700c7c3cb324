//! Why an archive could not be made.

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("{file}: no FMU is made from {found}")]
    NotPackable { file: String, found: String },
    /// The document is refused by its schema.
    #[error(transparent)]
    Document(#[from] steerwright_formats::Error),
    #[error("{file}: {source}")]
    Slave { file: String, source: steerwright_slaves::Error },
    #[error("{fmu}: no library for any platform")]
    NoBinary { fmu: &'static str },
    #[error("`{platform}` is no platform of FMI 2.0")]
    Platform { platform: String },
    #[error("{fmu}: two libraries for {platform}")]
    TwoBinaries { fmu: &'static str, platform: String },
    #[error("{file}: the reference run fails at {time} s: {problem}")]
    Reference { file: String, time: f64, problem: String },
    #[error("the step size is {step}, expected a number above 0")]
    Step { step: f64 },
    /// Names do not determine the source of an input.
    #[error(transparent)]
    Wiring(Box<steerwright_host::Error>),
    #[error("the system has no {need} {variable}")]
    NoVariable { variable: String, need: &'static str },
    #[error("{connection}: the ends differ in type or unit")]
    Connection { connection: String },
    #[error("{name}.ssp: {source}")]
    Package { name: String, source: zip::result::ZipError },
    #[error("{fmu}.fmu: {source}")]
    Zip { fmu: &'static str, source: zip::result::ZipError },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        let text: &str = match self {
            Self::NotPackable { .. } => {
                let kinds =
                    steerwright_slaves::Fmu::ALL.map(steerwright_slaves::Fmu::schema).join(", ");
                return format!("give a file whose \"schema\" is one of {kinds}");
            }
            Self::Document(error) => return error.hint(),
            Self::Slave { .. } => "make the file again with the command that writes it",
            Self::NoBinary { .. } => {
                "this build holds no FMU libraries; build steerwright without STEERWRIGHT_FMU_BINARIES"
            }
            Self::Platform { .. } => {
                "the names are win32, win64, linux32, linux64, darwin32, \
                darwin64, and <architecture>-<system> for others, such as aarch64-linux"
            }
            Self::TwoBinaries { .. } => "give one library for each platform",
            Self::Reference { .. } => {
                "the model does not stand its own operating point: correct the file it is made from"
            }
            Self::Step { .. } => "give the step in seconds, such as 10ms",
            Self::Wiring(_) => "wire one of them alone: leave out the files of the others",
            Self::NoVariable { .. } => "name a variable of a component, as component.variable",
            Self::Connection { .. } => "connect variables of the same type and unit",
            Self::Zip { .. } | Self::Package { .. } => "check the free space and try again",
        };
        text.to_owned()
    }
}
