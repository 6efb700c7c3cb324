//! Models and numbers of which no parameters can be made.

use miette::Diagnostic;

/// Why there are no parameters.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Diagnostic)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error(
        "the steady-state gain from steering to yaw rate is {gain:.4} 1/s, it must be greater than 0"
    )]
    #[diagnostic(help(
        "identify the model again from a log with turns in both directions and the right signs"
    ))]
    Gain { gain: f64 },
    #[error("the model states no speed, by which its gain would be a wheelbase")]
    #[diagnostic(help("identify the model again with the channel of the speed"))]
    Speed,
    #[error("{stack} does not steer by torque")]
    #[diagnostic(help(
        "export the parameters for openpilot, or those of a model of the steering angle"
    ))]
    NotByTorque { stack: &'static str },
    #[error("the command of the model is in {unit}; openpilot's is normalised, from -1 to 1")]
    #[diagnostic(help(
        "identify from the normalised command, such as the product of the torque and 1 over the torque at command 1"
    ))]
    NotNormalised { unit: String },
    #[error("the {name} is {value}, it must be greater than 0{most}")]
    #[diagnostic(help("correct the value, or omit it"))]
    Stated { name: &'static str, value: f64, most: &'static str },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}
