//! The errors of the crate with their numbers, and a hint for each.

/// A bicycle, a design or a path is impossible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The vehicle file is invalid.
    #[error("{file}:{line}:{column}: {problem}")]
    VehicleFile {
        /// Name of the file as the caller gave it.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The problem.
        problem: String,
    },
    /// The file of recorded points is invalid.
    #[error("{file}:{line}:{column}: {problem}")]
    PointFile {
        /// Name of the file as the caller gave it.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: usize,
        /// The problem.
        problem: String,
    },
    /// The file of a road is invalid.
    #[error("{file}:{line}:{column}: {problem}")]
    RoadFile {
        /// Name of the file as the caller gave it.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The problem.
        problem: String,
    },
    /// The recording of a satellite receiver has no usable fix.
    #[error(
        "{file}: none of {total} fixes can be used: {without} have no position, {poor} have fewer than {least_satellites} satellites or no correction"
    )]
    PoorFixes {
        /// Name of the file as the caller gave it.
        file: String,
        /// Fixes in the file.
        total: usize,
        /// Fixes without a position.
        without: usize,
        /// Fixes with too few satellites or without correction.
        poor: usize,
        /// Satellites needed.
        least_satellites: u32,
    },
    /// A document is inconsistent.
    #[error(transparent)]
    Document(#[from] steerwright_formats::Error),
    /// The plant model cannot be stepped.
    #[error("{model}: {problem}")]
    Model {
        /// The model's name.
        model: String,
        /// The problem.
        problem: String,
    },
    /// The identified model's file is inconsistent.
    #[error("{model}: {source}")]
    Identified {
        /// The model's name.
        model: String,
        /// The problem.
        source: steerwright_models::Error,
    },
    /// The speed at which the plant was identified is unknown.
    #[error(
        "{model}: operating_point.speed_mps is 0: the speed at which the plant holds is unknown"
    )]
    NoSpeed {
        /// The model's name.
        model: String,
    },
    /// The plant's yaw rate grows without bound.
    #[error("{model}: the plant is unstable at {speed_mps} m/s: a mode {text}")]
    UnstablePlant {
        /// The model's name.
        model: String,
        /// Its speed.
        speed_mps: f64,
        /// The mode in words.
        text: String,
    },
    /// The largest rate of the steering is not stated.
    #[error(
        "{model}: no rate of the steering is stated, and the model comes from no drive that has one"
    )]
    NoSteeringRate {
        /// The model's name.
        model: String,
    },
    /// The model holds at one speed alone.
    #[error("{model}: the model holds only at the speed of its identification")]
    NotScheduled {
        /// The model's name.
        model: String,
    },
    /// Steering to the left does not turn the plant to the left.
    #[error(
        "{model}: the steady-state gain from steering to yaw rate is {gain} 1/s, it must be positive"
    )]
    SteadyStateGain {
        /// The model's name.
        model: String,
        /// Yaw rate per steering angle, 1/s.
        gain: f64,
    },
    /// The controller's sample time is no multiple of the grid of a discrete plant.
    #[error(
        "{model} has no continuous model and steps every {plant_s} s: a controller sample of {controller_s} s is not a multiple of it"
    )]
    SampleTimeMismatch {
        /// The model's name.
        model: String,
        /// The plant's sample time.
        plant_s: f64,
        /// The controller's sample time.
        controller_s: f64,
    },
    /// The controller has too few samples in the settling time.
    #[error(
        "a sample time of {sample_time_s} s leaves fewer than {need} samples in the settling time of {settling_time_s} s"
    )]
    SampleTimeTooLong {
        /// The controller's sample time.
        sample_time_s: f64,
        /// The required settling time.
        settling_time_s: f64,
        /// Samples needed within it.
        need: usize,
    },
    /// The delay is longer than a design allows.
    #[error("a delay of {delay_s} s is longer than the {allowed_s} s that a design allows")]
    DelayTooLong {
        /// The delay of plant and loop.
        delay_s: f64,
        /// The longest allowed.
        allowed_s: f64,
    },
    /// An option is out of its range.
    #[error("{option} is {value}: it must be {must}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        must: &'static str,
    },
    /// Two options contradict each other.
    #[error("{one} contradicts {other}: {why}")]
    Contradiction {
        /// The first.
        one: String,
        /// The second.
        other: String,
        /// The reason.
        why: &'static str,
    },
    /// Controller and plant have different steering angles.
    #[error("the controller is for a steering ratio of {pid}, the plant has {plant}")]
    SteeringRatio {
        /// The controller's.
        pid: f64,
        /// The plant's.
        plant: f64,
    },
    /// A road of that shape does not exist.
    #[error("{road}: {problem}")]
    Road {
        /// Which road.
        road: &'static str,
        /// The problem.
        problem: String,
    },
    /// Too few distinct points for a path.
    #[error("{got} distinct points, a path needs at least {need}")]
    TooFewPoints {
        /// Distinct points there are.
        got: usize,
        /// Points needed.
        need: usize,
    },
    /// The recorded positions jump.
    #[error(
        "{dropped} of {total} points jump from their neighbours (the first at point {first}, by {jump_m:.2} m), more than the {allowed} that may be outliers"
    )]
    Jumps {
        /// Points left out as outliers.
        dropped: usize,
        /// Points in all.
        total: usize,
        /// First outlier, from 1.
        first: usize,
        /// Its distance from its neighbours.
        jump_m: f64,
        /// Outliers allowed.
        allowed: usize,
    },
    /// The recorded positions continue at another place.
    #[error("the positions jump by {jump_m:.2} m between points {after} and {next}")]
    Jump {
        /// Point before the jump, from 1.
        after: usize,
        /// Point after it.
        next: usize,
        /// Size of the jump.
        jump_m: f64,
    },
    /// The recorded path cannot be smoothed to the curvature allowed.
    #[error(
        "the curvature reaches {reached:.4} 1/m even when smoothed over {smoothing_m:.0} m; {allowed} 1/m is allowed"
    )]
    Curvature {
        /// Largest curvature reached.
        reached: f64,
        /// Largest allowed.
        allowed: f64,
        /// Longest smoothing tried.
        smoothing_m: f64,
    },
    /// The optimiser stopped.
    #[error("the optimiser stopped: {0}")]
    Optimiser(String),
}

impl Error {
    /// The suggested fix.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::VehicleFile { .. } => {
                "the keys are name, mass_kg, yaw_inertia_kgm2, distance_front_m, distance_rear_m, \
                 cornering_stiffness_front_npr, cornering_stiffness_rear_npr, \
                 actuator_time_constant_s, steering_ratio and speed_mps"
                    .into()
            }
            Self::PointFile { .. } => {
                "give a comma-separated table with the columns x_m and y_m, or latitude_deg and \
                 longitude_deg (and altitude_m), a GPX track, or NMEA sentences (GGA, RMC); repair \
                 or delete the line that is named"
                    .into()
            }
            Self::RoadFile { .. } => {
                "a road has a name and [[segments]], each with length_m, curvature_per_m and \
                 end_curvature_per_m; metres, 1/m, positive to the left"
                    .into()
            }
            Self::PoorFixes { .. } => {
                "record with a receiver that has correction data, or use the poor fixes and have them \
                 marked"
                    .into()
            }
            Self::Document(inner) => inner.hint(),
            Self::Model { .. } => "correct the model's file, or identify the model again".into(),
            Self::Identified { source, .. } => source.hint().into(),
            Self::NoSpeed { .. } => {
                "identify with the log's speed channel, or write the speed of the drive into the file"
                    .into()
            }
            Self::UnstablePlant { .. } => {
                "design at a lower speed, or correct the vehicle data: an oversteering vehicle is \
                 unstable above its critical speed"
                    .into()
            }
            Self::NoSteeringRate { .. } => {
                "state the largest rate of the steering angle that the actuator can follow, or design \
                 on a model that was identified from a drive"
                    .into()
            }
            Self::NotScheduled { .. } => {
                "identify a structure that holds at other speeds, such as the bicycle"
                    .into()
            }
            Self::SteadyStateGain { .. } => {
                "check the signs of the log: steering and yaw rate are positive to the left".into()
            }
            Self::SampleTimeMismatch { plant_s, .. } => {
                format!("design with a sample time of {plant_s} s or a multiple of it")
            }
            Self::SampleTimeTooLong { settling_time_s, need, .. } => format!(
                "sample every {} s or faster, or allow a longer settling time",
                settling_time_s / *need as f64
            ),
            Self::DelayTooLong { .. } => "check the unit of the delay: it is in seconds".into(),
            Self::Option { must, .. } => format!("give a value that is {must}"),
            Self::Contradiction { .. } => "remove one of the two options, or change it".into(),
            Self::SteeringRatio { .. } => {
                "compare models whose steering angles are measured at the same place (steering wheel \
                 or road wheel)"
                    .into()
            }
            Self::Road { .. } => {
                "change the speed, the lateral acceleration or the road's options".into()
            }
            Self::TooFewPoints { .. } => {
                "record a longer drive, or lower the least spacing between points".into()
            }
            Self::Jumps { .. } | Self::Jump { .. } => {
                "cut the recording at the jump, or repair the rows around it".into()
            }
            Self::Curvature { .. } => {
                "check the units of the positions, or allow a larger curvature".into()
            }
            Self::Optimiser(_) => "report this with the plant's file and the options".into(),
        }
    }
}
