//! The errors of the crate with their numbers, and a hint for each.

use miette::Diagnostic;
use steerwright_formats::VehicleData;

/// A bicycle, a design or a path is impossible.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Diagnostic)]
#[allow(missing_docs)] // the fields are named in the messages
pub enum Error {
    #[error("{file}:{line}:{column}: {problem}")]
    #[diagnostic(help("vehicle data are a TOML file; its keys are {}", VehicleData::KEYS))]
    VehicleFile { file: String, line: usize, column: usize, problem: String },
    #[error("{file}:{line}:{column}: {problem}")]
    #[diagnostic(help(
        "give a comma-separated table with the columns x_m and y_m, or latitude_deg and longitude_deg (and altitude_m), a GPX track, or NMEA sentences (GGA, RMC); repair or delete the line that is named"
    ))]
    PointFile { file: String, line: u64, column: usize, problem: String },
    #[error("{file}:{line}:{column}: {problem}")]
    #[diagnostic(help(
        "a road has a name and [[segments]], each with length_m, curvature_per_m and end_curvature_per_m; metres, 1/m, positive to the left"
    ))]
    RoadFile { file: String, line: usize, column: usize, problem: String },
    #[error(
        "{file}: none of {total} fixes can be used: {without} have no position, {poor} have fewer than {least_satellites} satellites or no correction"
    )]
    #[diagnostic(help(
        "record with a receiver that has correction data, or use the poor fixes and have them marked"
    ))]
    PoorFixes { file: String, total: usize, without: usize, poor: usize, least_satellites: u32 },
    /// A document is inconsistent.
    #[error(transparent)]
    #[diagnostic(help("{}", .0.hint()))]
    Document(#[from] steerwright_formats::Error),
    #[error("{model}: {problem}")]
    #[diagnostic(help("correct the model's file, or identify the model again"))]
    Model { model: String, problem: String },
    #[error("{model}: {source}")]
    #[diagnostic(help("{}", source.hint()))]
    Identified { model: String, source: steerwright_models::Error },
    #[error(
        "{model}: operating_point.speed_mps is 0: the speed at which the plant holds is unknown"
    )]
    #[diagnostic(help(
        "identify with the log's speed channel, or write the speed of the drive into the file"
    ))]
    NoSpeed { model: String },
    #[error("a model of the steering torque has no steering angle to control")]
    #[diagnostic(help(
        "identify a model from the steering angle, or export this one: steerwright export"
    ))]
    SteeredByTorque,
    #[error("a model of the structure {structure} has no steering to control")]
    #[diagnostic(help(
        "identify a model from the steering angle: steerwright identify --structure auto{elsewhere}"
    ))]
    NoSteering { structure: &'static str, elsewhere: &'static str },
    #[error(
        "a plant of named channels is of any system: no steering controller is designed for it"
    )]
    #[diagnostic(help(
        "identify a plant from the steering angle to the yaw rate; this one is designed on with other tools, in Python: plant.to_control()"
    ))]
    NamedChannels,
    #[error("{model}: the plant is unstable at {speed_mps} m/s: a mode {text}")]
    #[diagnostic(help(
        "design at a lower speed, or correct the vehicle data: an oversteering vehicle is unstable above its critical speed"
    ))]
    UnstablePlant { model: String, speed_mps: f64, text: String },
    #[error(
        "{model}: no rate of the steering is stated, and the model comes from no drive that has one"
    )]
    #[diagnostic(help(
        "state the largest rate of the steering angle that the actuator can follow, or design on a model that was identified from a drive"
    ))]
    NoSteeringRate { model: String },
    #[error("{model}: the model holds only at the speed of its identification")]
    #[diagnostic(help("identify a structure that holds at other speeds, such as the bicycle"))]
    NotScheduled { model: String },
    #[error(
        "{model}: the steady-state gain from steering to yaw rate is {gain} 1/s, it must be positive"
    )]
    #[diagnostic(help(
        "check the signs of the log: steering and yaw rate are positive to the left"
    ))]
    SteadyStateGain { model: String, gain: f64 },
    #[error(
        "{model} has no continuous model and steps every {plant_s} s: a controller sample of {controller_s} s is not a multiple of it"
    )]
    #[diagnostic(help("design with a sample time of {plant_s} s or a multiple of it"))]
    SampleTimeMismatch { model: String, plant_s: f64, controller_s: f64 },
    #[error(
        "a sample time of {sample_time_s} s leaves fewer than {need} samples in the settling time of {settling_time_s} s"
    )]
    #[diagnostic(help(
        "sample every {} s or faster, or allow a longer settling time",
        settling_time_s / *need as f64
    ))]
    SampleTimeTooLong { sample_time_s: f64, settling_time_s: f64, need: usize },
    #[error("a delay of {delay_s} s is longer than the {allowed_s} s that a design allows")]
    #[diagnostic(help("check the unit of the delay: it is in seconds"))]
    DelayTooLong { delay_s: f64, allowed_s: f64 },
    #[error("{option} is {value}{unit}: it must be {must}")]
    #[diagnostic(help("give a value that is {must}"))]
    Option { option: &'static str, value: f64, unit: &'static str, must: &'static str },
    #[error("{one} contradicts {other}: {why}")]
    #[diagnostic(help("remove one of the two options, or change it"))]
    Contradiction { one: String, other: String, why: &'static str },
    #[error("the controller is for a steering ratio of {pid}, the plant has {plant}")]
    #[diagnostic(help(
        "compare models whose steering angles are measured at the same place (steering wheel or road wheel)"
    ))]
    SteeringRatio { pid: f64, plant: f64 },
    #[error("{road}: {problem}")]
    #[diagnostic(help("change the speed, the lateral acceleration or the road's options"))]
    Road { road: &'static str, problem: String },
    #[error("{got} distinct points, a path needs at least {need}")]
    #[diagnostic(help("record a longer drive, or lower the least spacing between points"))]
    TooFewPoints { got: usize, need: usize },
    #[error(
        "{dropped} of {total} points jump from their neighbours (the first at point {first}, by {jump_m:.2} m), more than the {allowed} that may be outliers"
    )]
    #[diagnostic(help("{}", JUMP))]
    Jumps { dropped: usize, total: usize, first: usize, jump_m: f64, allowed: usize },
    #[error("the positions jump by {jump_m:.2} m between points {after} and {next}")]
    #[diagnostic(help("{}", JUMP))]
    Jump { after: usize, next: usize, jump_m: f64 },
    #[error(
        "the curvature reaches {reached:.4} 1/m even when smoothed over {smoothing_m:.0} m; {allowed} 1/m is allowed"
    )]
    #[diagnostic(help("check the units of the positions, or allow a larger curvature"))]
    Curvature { reached: f64, allowed: f64, smoothing_m: f64 },
    #[error(
        "the limit `{limit}` allows a speed of {speed_mps:.3} m/s at {distance_m:.2} m: the vehicle would have to stop there"
    )]
    #[diagnostic(help(
        "smooth the path at this place (a clothoid instead of a jump of the curvature, a wider curve), or allow more of {limit}"
    ))]
    ProfileStandstill { limit: &'static str, speed_mps: f64, distance_m: f64 },
    #[error(
        "the {end} speed is {stated_mps} m/s: the limits along the path allow {reached_mps:.2} m/s there"
    )]
    #[diagnostic(help(
        "state a lower {end} speed of at most {reached_mps:.1} m/s, or raise the limits of acceleration, deceleration and jerk"
    ))]
    ProfileEnd { end: &'static str, stated_mps: f64, reached_mps: f64 },
    #[error(
        "between the points of the profile, at {distance_m:.1} m, it needs {share:.3} of the limit `{limit}`"
    )]
    #[diagnostic(help("make the path with points that are closer together"))]
    ProfileExcess { limit: &'static str, share: f64, distance_m: f64 },
    #[error("no speed profile was found in {steps} steps")]
    #[diagnostic(help("report this with the path's file and the options"))]
    ProfileNotConverged { steps: usize },
    #[error("the optimiser stopped: {0}")]
    #[diagnostic(help("report this with the plant's file and the options"))]
    Optimiser(String),
}

/// The faults of a file of points, by line, column and problem.
pub(crate) fn point_fault(file: &str) -> impl Fn(u64, usize, String) -> Error + '_ {
    move |line, column, problem| Error::PointFile { file: file.into(), line, column, problem }
}

/// Rejects an option whose value is not valid; `unit` is the text that follows the value.
pub(crate) fn require(
    is_valid: bool,
    option: &'static str,
    (value, unit): (f64, &'static str),
    must: &'static str,
) -> Result<(), Error> {
    if is_valid { Ok(()) } else { Err(Error::Option { option, value, unit, must }) }
}

/// Rejects options that are not positive numbers.
pub(crate) fn positive<const N: usize>(
    options: [(&'static str, f64, &'static str); N],
) -> Result<(), Error> {
    options.into_iter().try_for_each(|(option, value, unit)| {
        require(value.is_finite() && value > 0.0, option, (value, unit), "greater than 0")
    })
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        self.help().map(|help| help.to_string()).unwrap_or_default()
    }
}

const JUMP: &str = "cut the recording at the jump, or repair the rows around it";
