//! Why loops of FMUs cannot run, or models cannot be compared.

use miette::Diagnostic;
use std::fmt::Display;

/// An error of a comparison, with its numbers and a [`hint`](Self::hint).
#[derive(Debug, thiserror::Error, Diagnostic)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    /// An error, with the file or the model that it concerns.
    #[error("{what}: {source}")]
    #[diagnostic(help("{}", source.hint()))]
    In { what: String, source: Box<Error> },
    #[error(transparent)]
    #[diagnostic(help("{}", .0.hint()))]
    Document(#[from] steerwright_formats::Error),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Identification(Box<steerwright_sysid::Error>),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Design(Box<steerwright_control::Error>),
    /// An archive could not be packed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Packaging(Box<steerwright_packaging::Error>),
    /// The code of an FMU rejects its resources or start values, with a hint from that code.
    #[error("{message}")]
    #[diagnostic(help("{hint}"))]
    Rejected { message: String, hint: String },
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fmu(Box<steerwright_host::Error>),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Report(#[from] steerwright_report::Error),
    #[error("{file}:{line}:{column}: not a JSON document: {problem}")]
    #[diagnostic(help("use a JSON file that steerwright wrote"))]
    NotJson { file: String, line: usize, column: usize, problem: String },
    #[error("{variable} was not recorded")]
    #[diagnostic(help("report this as a fault"))]
    NotRecorded { variable: String },
    #[error("the path has no points")]
    #[diagnostic(help("make the path again"))]
    EmptyPath,
    /// A plant cannot start where the road starts.
    #[error("{plant} has no `{parameter}`, and the road starts at {value}")]
    #[diagnostic(help(
        "use a road that starts at the origin along x, or an FMU with initial_x, initial_y and initial_yaw"
    ))]
    NoStartPose { plant: String, parameter: &'static str, value: f64 },
    /// A cross-track error of 0 or less would put every run off the path.
    #[error("the largest cross-track error is {metres} m: it must be greater than 0")]
    #[diagnostic(help("use the lateral clearance in the lane, such as 1.75 m"))]
    MaxCrossTrackError { metres: f64 },
    #[error("{high} has a steering ratio of {high_ratio}, {low} of {low_ratio}")]
    #[diagnostic(help(
        "models are compared on one steering angle, that of the steering wheel or that of the road wheel: make one of them again with the other's steering ratio"
    ))]
    SteeringRatios { high: String, high_ratio: f64, low: String, low_ratio: f64 },
    /// The log's steering angle is not that of the model.
    #[error("it has a steering ratio of {model}, the log of {log}")]
    #[diagnostic(help(
        "state the log's steering ratio, or use the column of the same steering angle"
    ))]
    LogSteeringRatio { model: f64, log: f64 },
    #[error("{file}: designed on a model that is not compared")]
    #[diagnostic(help("add the model that it was designed on, or name its model"))]
    OtherModel { file: String, model: String },
    #[error("there is one model with one controller: nothing to compare")]
    #[diagnostic(help("compare two models, or two controllers"))]
    NothingToCompare,
    #[error("the controller of {high} has a sample time of {high_s} s, that of {low} of {low_s} s")]
    #[diagnostic(help("design them with the same sample time, since it affects the comparison"))]
    SampleTimes { high: String, high_s: f64, low: String, low_s: f64 },
    #[error("the models are of speeds from {low_mps:.2} to {high_mps:.2} m/s")]
    #[diagnostic(help("state the speed on the road, or make a bicycle.json of the other's speed"))]
    Speeds { low_mps: f64, high_mps: f64 },
    #[error("{model} is of {model_mps:.2} m/s, the road is driven at {road_mps:.2} m/s")]
    #[diagnostic(help(
        "a model holds near its own speed: identify it from a drive at that speed, make the bicycle.json with it, or drive at another speed"
    ))]
    OtherSpeed { model: String, model_mps: f64, road_mps: f64 },
    /// The road needs more steering than a controller may command.
    #[error(
        "the road's radius of {radius_m:.1} m needs {needed_deg:.1} deg of steering of {model}, whose controller may steer {limit_deg:.1} deg"
    )]
    #[diagnostic(help(
        "drive a wider road, or a standard one with less lateral acceleration; the limit is the largest angle of the design"
    ))]
    TightRoad { radius_m: f64, needed_deg: f64, model: String, limit_deg: f64 },
    /// A plant does not turn to the left for steering to the left.
    #[error(
        "{plant} turns at {gain_per_s:.3} rad/s per rad of steering, the models at about {expected_per_s:.3}"
    )]
    #[diagnostic(help(
        "steering, yaw rate and yaw must be positive to the left (ISO 8855), and the vehicle must move"
    ))]
    SteeringSign { plant: String, gain_per_s: f64, expected_per_s: f64 },
    /// A plant's gain is far from that of the models, as a steering wheel's from a road wheel's.
    #[error(
        "{plant} turns at {gain_per_s:.3} rad/s per rad of steering, the models at about {expected_per_s:.3}"
    )]
    #[diagnostic(help(
        "a factor of {:.2} is that of a steering wheel to a road wheel: use a vehicle with the models' steering ratio of {steering_ratio}, or models with the vehicle's",
        gain_per_s / expected_per_s
    ))]
    SteeringPlace { plant: String, gain_per_s: f64, expected_per_s: f64, steering_ratio: f64 },
    /// The sample time is too long to read a turn.
    #[error("a turn has too few steps")]
    #[diagnostic(help("shorten the sample time"))]
    ShortTurn,
    #[error("{file}: this makes {fmu}.fmu, which is no vehicle")]
    #[diagnostic(help(
        "use a plant FMU, vehicle.json, plant.json, bicycle.json, or vehicle data (TOML)"
    ))]
    NoVehicle { file: String, fmu: &'static str },
    #[error("{file}: as the truth it lacks {}", missing.join(", "))]
    #[diagnostic(help(
        "its inputs are: {inputs}; its outputs: {outputs}. Names are as in the FMUs of this program, angles in rad, positive to the left"
    ))]
    NoPlant { file: String, missing: Vec<String>, inputs: String, outputs: String },
}

impl Error {
    /// The same with the file, model or run that it concerns.
    #[must_use]
    pub fn within(self, what: impl Display) -> Self {
        Self::In { what: what.to_string(), source: Box::new(self) }
    }

    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}

/// The errors of the stages are boxed, since they are large.
macro_rules! from_stage {
    ($($variant:ident: $error:ty),*) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::$variant(Box::new(error))
            }
        }
    )*};
}

from_stage!(Identification: steerwright_sysid::Error, Design: steerwright_control::Error, Fmu: steerwright_host::Error);

impl From<steerwright_packaging::Error> for Error {
    fn from(error: steerwright_packaging::Error) -> Self {
        // The hint of an FMU's own code is part of its message, since an importer shows nothing else.
        match error.to_string().split_once("; hint: ") {
            Some((message, hint)) => Self::Rejected { message: message.into(), hint: hint.into() },
            None => Self::Packaging(Box::new(error)),
        }
    }
}
