//! Models and numbers of which no parameters can be made.

/// Why there are no parameters.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error(
        "the steady-state gain from steering to yaw rate is {gain:.4} 1/s, it must be greater than 0"
    )]
    Gain { gain: f64 },
    #[error("the model states no speed, by which its gain would be a wheelbase")]
    Speed,
    #[error("{stack} does not steer by torque")]
    NotByTorque { stack: &'static str },
    #[error("the command of the model is in {unit}; openpilot's is normalised, from -1 to 1")]
    NotNormalised { unit: String },
    #[error("the {name} is {value}, it must be greater than 0{most}")]
    Stated { name: &'static str, value: f64, most: &'static str },
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Gain { .. } => {
                "identify the model again from a log with turns in both directions and the right signs"
            }
            Self::Speed => "identify the model again with the channel of the speed",
            Self::NotByTorque { .. } => {
                "export the parameters for openpilot, or those of a model of the steering angle"
            }
            Self::NotNormalised { .. } => {
                "identify from the normalised command, such as the product of the torque and 1 over the torque at command 1"
            }
            Self::Stated { .. } => "correct the value, or omit it",
        }
        .into()
    }
}
