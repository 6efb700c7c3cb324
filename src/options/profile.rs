//! The limits of the speed profile of a path.

use crate::documents::feasibility::STANDARD_ACCELERATION;
use crate::documents::files;
use crate::failure::Failure;
use crate::options::quantity::{self, Acceleration, Angle, AngleRate, Jerk, Number, OrNone};
use std::path::PathBuf;
use steerwright_control::{
    DesignPlant, SpeedDesignOptions, lateral_acceleration_limit, steering_limits,
    unlimited_steering,
};
use steerwright_formats::{Model, Pid, ProfileLimits, SourceFile, SpeedController, SteeringLimits};

/// Shares of the limits of a speed controller that a profile uses: the rest is for its feedback, without which a vehicle that
/// is late comes too fast to every bend. The reference model of the controller itself has 0.8 of the jerk.
const SHARE: f64 = 0.9;
const JERK_SHARE: f64 = 0.7;

/// The limits of a speed profile; absent where not stated.
#[derive(clap::Args)]
#[command(next_help_heading = "Speed profile")]
pub(crate) struct ProfileArguments {
    /// Compute the time-optimal speed along the path within the limits below; `ReferencePath` has it as speed_reference
    /// and acceleration_reference
    #[arg(long)]
    pub(crate) profile: bool,
    /// Largest speed of the profile; by default --speed
    #[arg(long, value_name = "SPEED", requires = "profile", allow_hyphen_values = true, value_parser = quantity::speed)]
    max_speed: Option<f64>,
    /// Largest lateral acceleration of the profile; by default 0.9 of that of --pid, otherwise 0.9 of that which the evidence
    /// of --plant covers, otherwise 4m/s2
    #[arg(long, value_name = "ACCELERATION", requires = "profile", allow_hyphen_values = true)]
    max_lateral_acceleration: Option<Acceleration>,
    /// Largest acceleration of the profile; by default 0.9 of that of --speed-controller, otherwise 2m/s2, that of ISO 15622
    #[arg(long, value_name = "ACCELERATION", requires = "profile", allow_hyphen_values = true)]
    max_acceleration: Option<Acceleration>,
    /// Largest deceleration of the profile; by default 0.9 of that of --speed-controller, otherwise 3.5m/s2, that of ISO 15622
    #[arg(long, value_name = "ACCELERATION", requires = "profile", allow_hyphen_values = true)]
    max_deceleration: Option<Acceleration>,
    /// Largest jerk of the profile, or `none`; by default 0.7 of that of --speed-controller, otherwise 2.5m/s3, that of ISO 15622
    #[arg(long, value_name = "JERK", requires = "profile", allow_hyphen_values = true)]
    max_jerk: Option<OrNone<Jerk>>,
    /// Friction coefficient of the road: the vector sum of lateral and longitudinal acceleration stays below it times
    /// gravity; not limited by default
    #[arg(long, value_name = "MU", requires = "profile", allow_hyphen_values = true)]
    friction: Option<Number>,
    /// Largest steering angle of the profile in steering coordinates, or `none`; by default 0.9 of that of --pid. Requires
    /// --pid or --plant
    #[arg(long, value_name = "ANGLE", requires = "profile", allow_hyphen_values = true)]
    max_angle: Option<OrNone<Angle>>,
    /// Largest rate of the steering angle of the profile, or `none`; by default 0.9 of that of --pid. Requires --pid or
    /// --plant
    #[arg(long, value_name = "RATE", requires = "profile", allow_hyphen_values = true)]
    max_rate: Option<OrNone<AngleRate>>,
    /// Speed at the beginning of the path; standstill by default. A closed path has none: a lap ends at the speed at which
    /// it begins
    #[arg(long, value_name = "SPEED", requires = "profile", conflicts_with = "closed", allow_hyphen_values = true, value_parser = quantity::speed)]
    start_speed: Option<f64>,
    /// Speed at the end of the path; standstill by default
    #[arg(long, value_name = "SPEED", requires = "profile", conflicts_with = "closed", allow_hyphen_values = true, value_parser = quantity::speed)]
    end_speed: Option<f64>,
    /// speed_controller.json of the controller that will follow the profile: 0.9 of its limits of acceleration and
    /// deceleration, and 0.7 of that of jerk, so that it has a reserve
    #[arg(long, value_name = "FILE.json", requires = "profile")]
    pub(crate) speed_controller: Option<PathBuf>,
}

/// The limits, and where those come from that are not stated.
pub(crate) struct Limited {
    pub(crate) limits: ProfileLimits,
    /// Preview times of the profile for drive and brake, s.
    pub(crate) preview_s: [f64; 2],
    pub(crate) sources: Vec<SourceFile>,
    pub(crate) notes: Vec<String>,
}

impl ProfileArguments {
    /// The limits of a profile along a path that is made for a speed, m/s.
    pub(crate) fn limits(
        &self,
        speed: f64,
        closed: bool,
        pid: Option<&Pid>,
        model: Option<&Model>,
    ) -> Result<Limited, Failure> {
        let mut notes = Vec::new();
        let mut sources = Vec::new();
        let mut preview_s = [0.0; 2];
        let usual = SpeedDesignOptions::default();
        let mut of_speed =
            [usual.max_acceleration_mps2, usual.max_deceleration_mps2, usual.max_jerk_mps3];
        if let Some(file) = &self.speed_controller {
            let (controller, source) = files::read_document::<SpeedController>(file)?;
            let l = controller.limits;
            of_speed = [
                SHARE * l.max_acceleration_mps2,
                SHARE * l.max_deceleration_mps2,
                JERK_SHARE * l.max_jerk_mps3,
            ];
            preview_s = steerwright_control::speed_preview_times(&controller.model);
            sources.push(source);
        } else {
            notes.push(
                "no preview of the speed: --speed-controller sets it to the lag of its drive"
                    .into(),
            );
        }
        let [acceleration, deceleration, jerk] = of_speed;
        let steering = self.steering(pid, model)?;
        if steering.is_none() {
            notes.push(
                "the profile does not limit the steering: --pid, or --plant with --max-rate, states its limits".into(),
            );
        }
        let limits = ProfileLimits {
            max_speed_mps: self.max_speed.unwrap_or(speed),
            max_lateral_acceleration_mps2: match self.max_lateral_acceleration {
                Some(stated) => stated.into(),
                None => lateral_acceleration_limit(pid, model).unwrap_or(STANDARD_ACCELERATION),
            },
            max_acceleration_mps2: self.max_acceleration.map_or(acceleration, f64::from),
            max_deceleration_mps2: self.max_deceleration.map_or(deceleration, f64::from),
            max_jerk_mps3: self.max_jerk.map_or(Some(jerk), |stated| stated.0.map(f64::from)),
            friction: self.friction.map(f64::from),
            steering,
            end_speeds_mps: if closed {
                None
            } else {
                Some([self.start_speed, self.end_speed].map(Option::unwrap_or_default))
            },
        };
        Ok(Limited { limits, preview_s, sources, notes })
    }

    /// Those of the controller, with the stated ones in their place.
    fn steering(
        &self,
        pid: Option<&Pid>,
        model: Option<&Model>,
    ) -> Result<Option<SteeringLimits>, Failure> {
        let is_stated = self.max_angle.is_some() || self.max_rate.is_some();
        let mut steering = match (pid, model) {
            (Some(pid), _) => steering_limits(pid),
            (None, Some(model)) => unlimited_steering(&DesignPlant::from_model(model)?),
            (None, None) if is_stated => {
                return Err(Failure::new(
                    "--max-angle and --max-rate: the steering angle that a curvature requires is unknown",
                    "state the controller with --pid or the vehicle with --plant",
                ));
            }
            (None, None) => return Ok(None),
        };
        if let Some(stated) = self.max_angle {
            steering.max_angle_rad = stated.0.map(f64::from);
        }
        if let Some(stated) = self.max_rate {
            steering.max_rate_radps = stated.0.map(f64::from);
        }
        let is_limited = steering.max_angle_rad.is_some() || steering.max_rate_radps.is_some();
        Ok(if is_limited { Some(steering) } else { None })
    }
}
