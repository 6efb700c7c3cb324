//! Why an archive could not be made.

use miette::Diagnostic;

/// An error of this crate.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("{file}: no FMU is made from {found}")]
    #[diagnostic(help("give a file whose \"schema\" is one of {}", schemas()))]
    NotPackable { file: String, found: String },
    /// The document is refused by its schema.
    #[error(transparent)]
    #[diagnostic(help("{}", .0.hint()))]
    Document(#[from] steerwright_formats::Error),
    #[error("{file}: {source}")]
    #[diagnostic(help("make the file again with the command that writes it"))]
    CoSimulationUnit { file: String, source: steerwright_units::Error },
    #[error("{fmu}: no library for any platform")]
    #[diagnostic(help(
        "this build holds no FMU libraries; build steerwright without STEERWRIGHT_FMU_BINARIES"
    ))]
    NoBinary { fmu: &'static str },
    #[error("`{platform}` is no platform of FMI 2.0")]
    #[diagnostic(help(
        "the names are win32, win64, linux32, linux64, darwin32, darwin64, and <architecture>-<system> for others, such as aarch64-linux"
    ))]
    Platform { platform: String },
    #[error("{fmu}: two libraries for {platform}")]
    #[diagnostic(help("give one library for each platform"))]
    TwoBinaries { fmu: &'static str, platform: String },
    #[error("{file}: the reference run fails at {time} s: {problem}")]
    #[diagnostic(help(
        "the model does not stand its own operating point: correct the file it is made from"
    ))]
    Reference { file: String, time: f64, problem: String },
    #[error("the step size is {step}, expected a number above 0")]
    #[diagnostic(help("give the step in seconds, such as 10ms"))]
    Step { step: f64 },
    /// Names do not determine the source of an input.
    #[error(transparent)]
    #[diagnostic(help("wire one of them alone: leave out the files of the others"))]
    Wiring(Box<steerwright_host::Error>),
    #[error("the system has no {need} {variable}")]
    #[diagnostic(help("name a variable of a component, as component.variable"))]
    NoVariable { variable: String, need: &'static str },
    #[error("{connection}: the ends differ in type or unit")]
    #[diagnostic(help("connect variables of the same type and unit"))]
    Connection { connection: String },
    #[error("{name}.ssp: {source}")]
    #[diagnostic(help("{}", SPACE))]
    Package { name: String, source: zip::result::ZipError },
    #[error("{fmu}.fmu: {source}")]
    #[diagnostic(help("{}", SPACE))]
    Zip { fmu: &'static str, source: zip::result::ZipError },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}

const SPACE: &str = "check the free space and try again";

/// The schemas of the files that FMUs are made from.
fn schemas() -> String {
    steerwright_units::Fmu::ALL.map(steerwright_units::Fmu::schema).join(", ")
}
