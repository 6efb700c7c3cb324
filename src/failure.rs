//! What can go wrong on the command line: message, hint, exit status.

use crate::console;
use std::fmt;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

/// Why a command ended without doing its work, with what the reader can do about it.
#[derive(Debug)]
pub(crate) struct Failure {
    message: String,
    hint: String,
    status: u8,
}

impl Failure {
    pub(crate) fn new(message: impl fmt::Display, hint: impl Into<String>) -> Self {
        Self { message: message.to_string(), hint: hint.into(), status: 2 }
    }

    /// Good input that does not meet a requirement; exit status 1.
    pub(crate) fn requirement(message: impl fmt::Display, hint: impl Into<String>) -> Self {
        Self { status: 1, ..Self::new(message, hint) }
    }

    /// A file that could not be read or written.
    pub(crate) fn file(path: &Path, error: &std::io::Error) -> Self {
        Self::new(
            format!("{}: {error}", path.display()),
            "check that the path is right and that you may read and write there",
        )
    }

    /// An error of a stage that does not know the file it was about.
    pub(crate) fn in_file(file: &Path, error: impl fmt::Display, hint: String) -> Self {
        Self::new(format!("{}: {error}", file.display()), hint)
    }

    /// The same, with the file or the thing that it is about before it.
    pub(crate) fn about(self, what: impl fmt::Display) -> Self {
        Self { message: format!("{what}: {}", self.message), ..self }
    }

    /// Prints it on stderr and returns its exit status.
    pub(crate) fn tell(&self) -> ExitCode {
        console::error(&self.message, &self.hint, self.status);
        ExitCode::from(self.status)
    }

    /// As [`Failure::tell`], and ends the process with another status.
    pub(crate) fn exit(&self, status: u8) -> ! {
        console::error(&self.message, &self.hint, status);
        std::process::exit(status.into())
    }
}

/// Exit status of bad input.
pub(crate) const BAD_INPUT: u8 = 2;

/// Prints what is wrong with the arguments, or the help that was asked for.
pub(crate) fn tell_usage(error: &clap::Error) -> ExitCode {
    const CLOSING: &str = "For more information, try '--help'.";
    const HINT: &str = "--help lists the arguments with their units and defaults";
    let status = u8::try_from(error.exit_code()).unwrap_or(BAD_INPUT);
    if !error.use_stderr() {
        let _ = error.print();
    } else if console::is_json() {
        let text = error.render().to_string();
        let text = text.replace(CLOSING, "");
        let message = text.trim().trim_start_matches("error: ");
        console::error(message, HINT, status);
    } else {
        let hint = format!("{}: {HINT}", console::styled(console::HINT, "hint"));
        // Plain, since the styles of clap part the closing sentence.
        let text = error.render().to_string().replace(CLOSING, &hint);
        let text = text.replacen("error", &console::styled(console::BAD, "error"), 1);
        let _ = write!(anstream::stderr(), "{text}");
    }
    ExitCode::from(status)
}

/// Errors of the stages carry their own hint.
macro_rules! from_stage {
    ($($error:ty),*) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::new(&error, error.hint())
            }
        }
    )*};
}

from_stage!(
    formats::Error,
    drivelog::Error,
    sysid::Error,
    packaging::Error,
    fmi2_host::Error,
    fmu_checker::Error,
    report::Error,
    ::sweep::Error
);

impl From<control::Error> for Failure {
    fn from(error: control::Error) -> Self {
        let hint = design_hint(&error);
        Self::new(&error, hint)
    }
}

/// The hint of a design's error, with the option where one helps.
pub(crate) fn design_hint(error: &control::Error) -> String {
    match error {
        control::Error::NoSteeringRate { .. } => format!("{}: --max-rate 25deg/s", error.hint()),
        _ => error.hint(),
    }
}

/// How a command ended that did its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Everything asked for is met.
    Done,
    /// The work was done but a requirement or a validation is not met.
    RequirementNotMet,
}

impl Outcome {
    /// Of an identification: a model that failed validation is a requirement not met.
    pub(crate) fn of(quality: &formats::Quality) -> Self {
        if quality.allows_design() { Self::Done } else { Self::RequirementNotMet }
    }
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(match outcome {
            Outcome::Done => 0,
            Outcome::RequirementNotMet => 1,
        })
    }
}
