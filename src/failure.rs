//! Errors of the command line: message, hint, exit status.

use crate::process::program;
use crate::terminal::console;
use std::fmt;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Why a command ended without doing its work, with what the reader can do about it.
#[derive(Debug)]
pub struct Failure {
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
        use std::io::ErrorKind;
        let hint = match error.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
                "free some space there, or name a file on another disk"
            }
            ErrorKind::ReadOnlyFilesystem => {
                "name a file on another disk: nothing can be written there"
            }
            ErrorKind::InvalidFilename => {
                "use a shorter name, without characters that the disk rejects"
            }
            _ => "check that the path is right and that you may read and write there",
        };
        Self::new(format!("{}: {error}", path.display()), hint)
    }

    /// An error of a stage, with the file that it concerns.
    pub(crate) fn in_file(file: &Path, error: impl fmt::Display, hint: String) -> Self {
        Self::new(format!("{}: {error}", file.display()), hint)
    }

    /// What is wrong, and where.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What to do about it, with the options of the command line where they help.
    #[must_use]
    pub fn hint(&self) -> &str {
        &self.hint
    }

    /// Prints it on stderr and returns its exit status.
    pub(crate) fn report(&self) -> u8 {
        console::error(&self.message, &self.hint, self.status);
        self.status
    }

    /// As [`Failure::report`], and ends the process with another status.
    pub(crate) fn exit(&self, status: u8) -> ! {
        console::error(&self.message, &self.hint, status);
        std::process::exit(program::exit_status(status).into())
    }
}

pub(crate) const BAD_INPUT: u8 = 2;

/// Does the work and returns its exit status. A fault of this program is reported like an error of the input: with
/// its place, as JSON where that is wanted, and with that status.
pub(crate) fn status(work: impl FnOnce() -> Result<Outcome, Failure>) -> u8 {
    // Its place is known to the hook alone.
    std::panic::set_hook(Box::new(|fault| console::warning(format!("internal fault: {fault}"))));
    let result = catch_unwind(AssertUnwindSafe(work));
    drop(std::panic::take_hook());
    match result {
        Ok(Ok(outcome)) => outcome.status(),
        Ok(Err(failure)) => failure.report(),
        Err(_) => Failure::new(
            "the program failed at the place of the warning above; no file was completed after that",
            "report the warning with the command and, if possible, the input; other options or a part of the log may avoid the fault",
        )
        .report(),
    }
}

/// Prints an error of the arguments, or the requested help.
pub(crate) fn report_usage(error: &clap::Error) -> u8 {
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
    status
}

impl From<console::NoOutput> for Failure {
    fn from(error: console::NoOutput) -> Self {
        Self::new(format!("stdout: {}", error.0), "check where the output goes")
    }
}

/// Errors of the stages carry a hint, which names the options where they help.
macro_rules! from_stage {
    ($($error:ty => $hint:path),* $(,)?) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::new(&error, $hint(&error))
            }
        }
    )*};
}

from_stage!(
    steerwright_formats::Error => steerwright_formats::Error::hint,
    steerwright_packaging::Error => steerwright_packaging::Error::hint,
    steerwright_host::Error => steerwright_host::Error::hint,
    steerwright_checker::Error => steerwright_checker::Error::hint,
    steerwright_report::Error => steerwright_report::Error::hint,
    steerwright_sweep::Error => steerwright_sweep::Error::hint,
    steerwright_drivelog::Error => log_hint,
    steerwright_sysid::Error => identification_hint,
    steerwright_control::Error => design_hint,
    steerwright_comparison::Error => comparison_hint,
);

/// The option with the name of a library's option.
fn flag(option: &str) -> String {
    match option {
        "channel steering_command" => "--channel".into(),
        "several inputs or outputs" => "--input-channel, --output-channel".into(),
        _ => format!("--{}", option.replace(' ', "-")),
    }
}

/// The option that names the channel of a role.
fn channel(role: &str) -> &'static str {
    match role {
        "steering" | "steering torque" | "accelerator or acceleration command" => {
            "--input-channel NAME"
        }
        "yaw rate" | "lateral acceleration" => "--output-channel NAME",
        "speed" => "--speed-channel NAME",
        "time" => "--time-channel NAME",
        _ => "--channel ROLE=NAME",
    }
}

/// The hint of a log's error, with the options where they help.
fn log_hint(error: &steerwright_drivelog::Error) -> String {
    use steerwright_drivelog::Error as E;
    let options: &str = match error {
        E::MissingColumn { role, .. }
        | E::RoleNotFound { role, .. }
        | E::NotADrive { role, .. } => channel(role),
        E::Option { option, .. } => &flag(option),
        E::UnknownWord { option, .. } | E::InPieces { option } => &flag(option),
        E::UnusedRole { .. } => "--channel, --structure",
        E::Mapping { .. } => "--mapping-vehicle NAME",
        E::NoSuchTopic { .. } => "--topic NAME",
        E::NoCommand { .. } => "--steering-full-scale, --input-channel NAME",
        E::DecimalMark { .. } => "--decimal comma, --decimal point",
        E::UnitNotStated { .. } | E::UnitsDiffer { .. } => match error.suggested_unit() {
            Some((column, unit)) if column.contains(' ') => &format!("--unit \"{column}={unit}\""),
            Some((column, unit)) => &format!("--unit {column}={unit}"),
            None => "--unit",
        },
        E::WrongQuantity { column, .. } => &format!("--unit {column}=UNIT"),
        E::UnusedUnit { .. } | E::Impossible { .. } => "--unit",
        E::BeyondFullScale { .. } => "--unit, --steering-full-scale",
        E::NoTime { .. } => "--time-channel NAME, --row-period",
        E::CoarseClock { .. } => "--row-period",
        E::Gap { .. } => "--max-gap",
        E::AmbiguousDrives { first, other, .. } => &format!("--drive {first},{other}"),
        E::SpeedWindow { .. } => "--speed-window",
        E::NoSpeedForWindow { .. } => "--speed-channel NAME, --speed-window",
        E::SteeringRatioUnknown { .. } => "--steering-ratio 15",
        E::NotARoadWheel { .. } => "--steering-ratio 15, --unit",
        E::Standstill { .. } => "--speed-channel NAME, --unit, --window",
        E::TooFewSamples { .. } | E::TooManySamples { .. } => "--window, --sample-time",
        E::TooManyRows { .. } => "steerwright accumulate, --window",
        E::NoOverlap { .. } => "--window",
        E::SampleTimeTooShort { .. } | E::ClockChanged { .. } => "--sample-time",
        _ => return error.hint(),
    };
    format!("{} ({options})", error.hint())
}

/// The hint of an identification's error, with the options where they help.
fn identification_hint(error: &steerwright_sysid::Error) -> String {
    use steerwright_sysid::Error as E;
    let options: &str = match error {
        E::Log(error) => return log_hint(error),
        E::Option { option, .. } => &flag(option),
        E::TooFewSamples { .. } => "--window, --sample-time",
        E::TooSlow { .. } => "--min-speed, --structure state-space",
        E::SpeedNeeded => "--speed-channel NAME, --structure state-space",
        E::NoSpeed => "--speed-channel NAME, --model-input steering",
        E::WheelbaseNeeded => "--wheelbase, --steering-full-scale",
        E::OrderAboveHorizon { order, .. } => &format!("--horizon {}", order + 2),
        E::Differ { .. } => "--sample-time, --steering-ratio, --horizon",
        E::Numerical { .. } => "--horizon, --sample-time",
        _ => return error.hint(),
    };
    format!("{} ({options})", error.hint())
}

/// The hint of a comparison's error, with the options where they help.
fn comparison_hint(error: &steerwright_comparison::Error) -> String {
    use steerwright_comparison::Error as E;
    let options: &str = match error {
        E::In { source, .. } => return comparison_hint(source),
        E::Design(error) => return design_hint(error),
        E::Identification(error) => return identification_hint(error),
        E::OtherModel { file, model } => &format!("--pid {model}={file}"),
        E::NothingToCompare => "--pid",
        E::SampleTimes { .. } => "--pid-sample-time",
        E::LogSteeringRatio { .. } => "--steering-ratio, --input-channel",
        E::MaxCrossTrackError { .. } => "--max-cross-track-error",
        E::Speeds { .. } | E::OtherSpeed { .. } => "--road-speed",
        E::TightRoad { .. } => "--lateral-acceleration, --max-angle",
        _ => return error.hint(),
    };
    format!("{} ({options})", error.hint())
}

/// The hint of a design's error, with the option where one helps.
fn design_hint(error: &steerwright_control::Error) -> String {
    use steerwright_control::Error as E;
    let option = match error {
        E::NoSteeringRate { .. } => "--max-rate 25deg/s",
        E::NotScheduled { .. } => "--structure bicycle",
        E::PoorFixes { .. } => "--poor-fixes mark",
        _ => return error.hint(),
    };
    format!("{} ({option})", error.hint())
}

/// How a command ended that did its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done,
    /// The work was done but a requirement or a validation is not met.
    RequirementNotMet,
}

impl Outcome {
    /// Of an identification: a model that failed validation is a requirement not met.
    pub(crate) fn from_quality(quality: &steerwright_formats::Quality) -> Self {
        Self::when(quality.allows_design())
    }

    /// Done when the requirements are met.
    pub(crate) fn when(met: bool) -> Self {
        if met { Self::Done } else { Self::RequirementNotMet }
    }

    /// The exit status.
    pub(crate) fn status(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::RequirementNotMet => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_of_the_program_has_the_status_of_bad_input() {
        let nothing: [f64; 0] = [];
        assert_eq!(status(|| Ok(Outcome::when(nothing[nothing.len()] > 0.0))), BAD_INPUT);
        assert_eq!(status(|| Ok(Outcome::Done)), 0);
        assert_eq!(status(|| Err(Failure::requirement("missed", ""))), 1);
    }
}
