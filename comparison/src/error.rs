//! Why loops of FMUs cannot run, or models cannot be compared.

use std::fmt::Display;

/// An error of a comparison, with its numbers and a [`hint`](Self::hint).
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An error, with the file or the model that it concerns.
    #[error("{what}: {source}")]
    In {
        /// The file, model or run.
        what: String,
        /// The error there.
        source: Box<Error>,
    },
    /// A file has the wrong content.
    #[error(transparent)]
    Document(#[from] steerwright_formats::Error),
    /// A model could not be validated on the drive.
    #[error(transparent)]
    Identification(Box<steerwright_sysid::Error>),
    /// No controller or road could be made.
    #[error(transparent)]
    Design(Box<steerwright_control::Error>),
    /// An archive could not be packed.
    #[error(transparent)]
    Packaging(Box<steerwright_packaging::Error>),
    /// The code of an FMU rejects its resources or start values, with a hint from that code.
    #[error("{message}")]
    Rejected {
        /// What it rejects.
        message: String,
        /// What to do about it.
        hint: String,
    },
    /// An FMU could not be opened, wired or stepped.
    #[error(transparent)]
    Fmu(Box<steerwright_host::Error>),
    /// A figure could not be drawn, or a run not be read.
    #[error(transparent)]
    Report(#[from] steerwright_report::Error),
    /// A file is not JSON.
    #[error("{file}:{line}:{column}: {problem}")]
    NotJson {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the parser found.
        problem: String,
    },
    /// A loop has no samples of a variable.
    #[error("{variable} was not recorded")]
    NotRecorded {
        /// Name of the variable.
        variable: String,
    },
    /// The path has no points.
    #[error("the path has no points")]
    EmptyPath,
    /// A plant cannot start where the road starts.
    #[error("{plant} has no `{parameter}`, and the road starts at {value}")]
    NoStartPose {
        /// The plant's name.
        plant: String,
        /// The parameter it lacks.
        parameter: &'static str,
        /// Where the road starts, m or rad.
        value: f64,
    },
    /// A cross-track error of 0 or less would put every run off the path.
    #[error("the largest cross-track error is {metres} m: it must be greater than 0")]
    MaxCrossTrackError {
        /// The bound, m.
        metres: f64,
    },
    /// Steering angles of different places.
    #[error("{high} has a steering ratio of {high_ratio}, {low} of {low_ratio}")]
    SteeringRatios {
        /// File with the higher ratio.
        high: String,
        /// Its ratio.
        high_ratio: f64,
        /// File with the lower ratio.
        low: String,
        /// Its ratio.
        low_ratio: f64,
    },
    /// The log's steering angle is not that of the model.
    #[error("it has a steering ratio of {model}, the log of {log}")]
    LogSteeringRatio {
        /// The model's ratio.
        model: f64,
        /// The log's ratio.
        log: f64,
    },
    /// A controller belongs to none of the models.
    #[error("{file}: designed on a model that is not compared")]
    OtherModel {
        /// The controller's file.
        file: String,
        /// A model that it may belong to.
        model: String,
    },
    /// One controller alone.
    #[error("there is one model with one controller: nothing to compare")]
    NothingToCompare,
    /// Controllers of different sample times.
    #[error("the controller of {high} has a sample time of {high_s} s, that of {low} of {low_s} s")]
    SampleTimes {
        /// Controller with the longer sample time.
        high: String,
        /// Its sample time, s.
        high_s: f64,
        /// Controller with the shorter sample time.
        low: String,
        /// Its sample time, s.
        low_s: f64,
    },
    /// Models of different speeds, with a road of no stated speed.
    #[error("the models are of speeds from {low_mps:.2} to {high_mps:.2} m/s")]
    Speeds {
        /// Lowest speed of a model, m/s.
        low_mps: f64,
        /// Highest speed of a model, m/s.
        high_mps: f64,
    },
    /// A model is used too far from its speed.
    #[error("{model} is of {model_mps:.2} m/s, the road is driven at {road_mps:.2} m/s")]
    OtherSpeed {
        /// The model's file.
        model: String,
        /// Its speed, m/s.
        model_mps: f64,
        /// Speed on the road, m/s.
        road_mps: f64,
    },
    /// The road needs more steering than a controller may command.
    #[error(
        "the road's radius of {radius_m:.1} m needs {needed_deg:.1} deg of steering of {model}, whose controller may steer {limit_deg:.1} deg"
    )]
    TightRoad {
        /// Smallest radius, m.
        radius_m: f64,
        /// Steering angle of the steady turn, deg.
        needed_deg: f64,
        /// The model.
        model: String,
        /// The controller's limit, deg.
        limit_deg: f64,
    },
    /// A plant does not turn to the left for steering to the left.
    #[error(
        "{plant} turns at {gain_per_s:.3} rad/s per rad of steering, the models at about {expected_per_s:.3}"
    )]
    SteeringSign {
        /// The plant.
        plant: String,
        /// Its yaw rate per steering angle, 1/s.
        gain_per_s: f64,
        /// That of the models, 1/s.
        expected_per_s: f64,
    },
    /// A plant's gain is far from that of the models, as a steering wheel's from a road wheel's.
    #[error(
        "{plant} turns at {gain_per_s:.3} rad/s per rad of steering, the models at about {expected_per_s:.3}"
    )]
    SteeringPlace {
        /// The plant.
        plant: String,
        /// Its yaw rate per steering angle, 1/s.
        gain_per_s: f64,
        /// That of the models, 1/s.
        expected_per_s: f64,
        /// The models' steering ratio.
        steering_ratio: f64,
    },
    /// The sample time is too long to read a turn.
    #[error("a turn has too few steps")]
    ShortTurn,
    /// A file makes an FMU that is no vehicle.
    #[error("{file}: this makes {fmu}.fmu, which is no vehicle")]
    NoVehicle {
        /// Name of the file.
        file: String,
        /// The FMU.
        fmu: &'static str,
    },
    /// An FMU lacks variables of a plant.
    #[error("{file}: as the truth it lacks {}", missing.join(", "))]
    NoPlant {
        /// Name of the file.
        file: String,
        /// Causality, name and unit of each missing variable.
        missing: Vec<String>,
        /// Names of its inputs.
        inputs: String,
        /// Names of its outputs.
        outputs: String,
    },
}

impl Error {
    /// The same with the file, model or run that it concerns.
    #[must_use]
    pub fn of(self, what: impl Display) -> Self {
        Self::In { what: what.to_string(), source: Box::new(self) }
    }

    /// The remedy, for the reader.
    #[must_use]
    pub fn hint(&self) -> String {
        let text = match self {
            Self::In { source, .. } => return source.hint(),
            Self::Document(error) => return error.hint(),
            Self::Identification(error) => return error.hint(),
            Self::Design(error) => return error.hint(),
            Self::Packaging(error) => return error.hint(),
            Self::Rejected { hint, .. } => return hint.clone(),
            Self::Fmu(error) => return error.hint(),
            Self::Report(error) => error.hint(),
            Self::NotJson { .. } => "use a JSON file that steerwright wrote",
            Self::NotRecorded { .. } => "report this as a fault",
            Self::EmptyPath => "make the path again",
            Self::NoStartPose { .. } => {
                "use a road that starts at the origin along x, or an FMU with initial_x, initial_y \
                 and initial_yaw"
            }
            Self::MaxCrossTrackError { .. } => {
                "use the lateral clearance in the lane, such as 1.75 m"
            }
            Self::SteeringRatios { .. } => {
                "models are compared on one steering angle, that of the steering wheel or that of the \
                 road wheel: make one of them again with the other's steering ratio"
            }
            Self::LogSteeringRatio { .. } => {
                "state the log's steering ratio, or use the column of the same steering angle"
            }
            Self::OtherModel { .. } => "add the model that it was designed on, or name its model",
            Self::NothingToCompare => "compare two models, or two controllers",
            Self::SampleTimes { .. } => {
                "design them with the same sample time, since it affects the comparison"
            }
            Self::Speeds { .. } => {
                "state the speed on the road, or make a bicycle.json of the other's speed"
            }
            Self::OtherSpeed { .. } => {
                "a model holds near its own speed: identify it from a drive at that speed, make the \
                 bicycle.json with it, or drive at another speed"
            }
            Self::TightRoad { .. } => {
                "drive a wider road, or a standard one with less lateral acceleration; the limit is \
                 the largest angle of the design"
            }
            Self::SteeringSign { .. } => {
                "steering, yaw rate and yaw must be positive to the left (ISO 8855), and the vehicle \
                 must move"
            }
            Self::SteeringPlace { gain_per_s, expected_per_s, steering_ratio, .. } => {
                return format!(
                    "a factor of {:.2} is that of a steering wheel to a road wheel: use a vehicle \
                     with the models' steering ratio of {steering_ratio}, or models with the \
                     vehicle's",
                    gain_per_s / expected_per_s
                );
            }
            Self::ShortTurn => "shorten the sample time",
            Self::NoVehicle { .. } => {
                "use a plant FMU, vehicle.json, plant.json, bicycle.json, or vehicle data (TOML)"
            }
            Self::NoPlant { inputs, outputs, .. } => {
                return format!(
                    "its inputs are: {inputs}; its outputs: {outputs}. Names are as in the FMUs of \
                     this program, angles in rad, positive to the left"
                );
            }
        };
        text.to_owned()
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
