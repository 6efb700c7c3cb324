//! The errors between a drive and its model, with their numbers and the suggested fix.

use miette::Diagnostic;
use steerwright_drivelog::{DriveLog, Response};

/// Why no model could be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Diagnostic)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Log(#[from] steerwright_drivelog::Error),
    #[error("the data do not excite the system: {problem}")]
    #[diagnostic(help(
        "leave out channels that do not move, and record an input that moves at many frequencies, such as a slalom of changing pace, or accelerating and braking by different amounts"
    ))]
    NotExciting { problem: String },
    #[error("the data's condition {condition:.1e} is too large for sums of products")]
    #[diagnostic(help("accumulate the data again with a QR factorisation, Decomposition::Qr"))]
    IllConditioned { condition: f64 },
    #[error(
        "{got} samples of {} s are too few: {need} are needed",
        (sample_time_s * 1e9).round() / 1e9
    )]
    #[diagnostic(help(
        "record longer (a minute or more), use a longer part of the log, or a shorter sample time; where the drive was longer, check the unit of the time"
    ))]
    TooFewSamples { got: usize, need: usize, sample_time_s: f64 },
    #[error("{option}: {value} is out of range, expected {expected}")]
    #[diagnostic(help("use a value that is expected, or omit the option"))]
    Option { option: &'static str, value: String, expected: String },
    #[error("the input steering*speed needs a channel of the speed")]
    #[diagnostic(help("name the channel of the speed, or identify with the input steering"))]
    NoSpeed,
    #[error("the structure bicycle needs the speed, and the log has no channel of it")]
    #[diagnostic(help(
        "name the channel of the speed (with the steering and yaw rate, or in a file of its own), or identify the structure state-space"
    ))]
    SpeedNeeded,
    #[error(
        "no segment of the log is at {least_mps} m/s or more, which this structure uses; the speed reaches {fastest_mps:.1} m/s"
    )]
    #[diagnostic(help(
        "check the unit of the speed; of a vehicle that is as slow as that, state the lowest speed, or identify the structure state-space"
    ))]
    TooSlow { least_mps: f64, fastest_mps: f64 },
    #[error(
        "the log was read for the response {response}, and this structure needs that of the yaw rate"
    )]
    #[diagnostic(help("read the log for the response yaw-rate"))]
    YawRateLogNeeded { response: Response },
    #[error(
        "the log was read for the response {response}, and the structure longitudinal needs that of the speed"
    )]
    #[diagnostic(help("read the log for the response speed"))]
    SpeedLogNeeded { response: Response },
    #[error("the log was read for the response {response}, and not for named inputs and outputs")]
    #[diagnostic(help("read the log with its inputs and outputs named"))]
    ChannelsNeeded { response: Response },
    /// The channels of a log are not those of a plant.
    #[error("{problem}")]
    #[diagnostic(help(
        "name the channels of the plant in its order, with their units, and resample the log to the sample time of the plant"
    ))]
    OtherChannels { problem: String },
    #[error(
        "the structure torque needs command, lateral acceleration, speed and steering angle; of this log, {missing}"
    )]
    #[diagnostic(help(
        "read the log for the response lateral-acceleration, and name the channel that is missing"
    ))]
    TorqueLogNeeded { missing: &'static str },
    #[error("an order of {order} needs a horizon above it; the horizon is {horizon}")]
    #[diagnostic(help("use a horizon of {} or more, or leave it out", order + 2))]
    OrderAboveHorizon { order: usize, horizon: usize },
    #[error("{problem}")]
    #[diagnostic(help("{hint}"))]
    Implausible { problem: String, hint: String },
    #[error(
        "the steering is no angle, and no wheelbase is stated: neither follows without the other"
    )]
    #[diagnostic(help("state the wheelbase, or the steering angle at a command of 1"))]
    WheelbaseNeeded,
    #[error("inputs and outputs are no data set: {problem}")]
    #[diagnostic(help(
        "each segment needs as many samples of input as of output, all of them finite numbers"
    ))]
    Data { problem: String },
    #[error("{first} and {second} cannot be merged: {problem}")]
    #[diagnostic(help(
        "accumulate all logs with the same version and options; state sample time, steering ratio and horizon where the logs differ"
    ))]
    Differ { first: String, second: String, problem: String },
    #[error("{file}: this is no complete R factor: {problem}")]
    #[diagnostic(help("accumulate the log again, or copy the file again"))]
    NoFactor { file: String, problem: String },
    #[error("no model was identified: {problem}")]
    #[diagnostic(help(
        "check the mapping, the signs and the units; the input must drive the output"
    ))]
    NoModel { problem: String },
    #[error("the vehicle is unstable at {speed_mps} m/s")]
    #[diagnostic(help(
        "design the manoeuvre at a lower speed, or correct the vehicle data: an oversteering vehicle is unstable above its critical speed"
    ))]
    Unstable { speed_mps: f64 },
    #[error("a matrix factorisation did not converge: {what}")]
    #[diagnostic(help(
        "look for extreme values in the log; another horizon or sample time may help"
    ))]
    Numerical { what: &'static str },
}

/// Rejects a log that was read for another response.
pub(crate) fn check_yaw_rate(log: &DriveLog) -> Result<(), Error> {
    match log.response {
        Response::YawRate | Response::Motion => Ok(()),
        response @ (Response::LateralAcceleration | Response::Speed | Response::Channels) => {
            Err(Error::YawRateLogNeeded { response })
        }
    }
}

impl Error {
    pub(crate) fn no_model(problem: impl Into<String>) -> Self {
        Self::NoModel { problem: problem.into() }
    }

    pub(crate) fn data(problem: impl Into<String>) -> Self {
        Self::Data { problem: problem.into() }
    }

    pub(crate) fn too_few(got: usize, need: usize, sample_time_s: f64) -> Self {
        Self::TooFewSamples { got, need, sample_time_s }
    }

    pub(crate) fn option(
        option: &'static str,
        value: impl ToString,
        expected: impl Into<String>,
    ) -> Self {
        Self::Option { option, value: value.to_string(), expected: expected.into() }
    }

    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}
