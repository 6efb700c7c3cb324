//! `PoseEstimator`: the glue from [`steerwright_models::PoseEstimator`] to the export trait.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::resources::{optional, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{Moment, Scenario};
use fmi2_export::{Capabilities, CoSimulationUnit, Log, Resources, variables};
use model_description::DependsOn::{Nothing, On};
use model_description::{Table, Value};
use steerwright_formats::Estimator;
use steerwright_models::{PoseParameters, SavedPose};

variables! {
    /// Variables of the pose estimator. Its outputs are evaluated in a step, from the inputs set
    /// before it, so at a communication point they depend on no input.
    Variable of PoseEstimator, "PoseEstimator", "extended Kalman filter for the pose: GNSS fixes, yaw rate and speed in, pose and course out";
    GnssX = 0, real "gnss_x", Input, Continuous, at estimator.input.gnss_x,
        .unit("m").nominal(100.0).description("position of the antenna at the latest fix");
    GnssY = 1, real "gnss_y", Input, Continuous, at estimator.input.gnss_y,
        .unit("m").nominal(100.0).description("position of the antenna at the latest fix");
    GnssStd = 2, real "gnss_std", Input, Continuous, at estimator.input.gnss_std,
        .unit("m").nominal(0.1).description("standard deviation of the latest fix in each coordinate; not usable unless above 0");
    GnssFixCount = 3, integer "gnss_fix_count", Input, Discrete,
        .description("counts the fixes: a new fix is a changed count, or the end of a gnss_period");
    YawRate = 4, real "yaw_rate", Input, Continuous, at estimator.input.yaw_rate,
        .unit("rad/s").display_unit("deg/s").description("yaw rate that the gyro measures, positive to the left");
    Speed = 5, real "speed", Input, Continuous, at estimator.input.speed,
        .unit("m/s").display_unit("km/h").min(0.0).nominal(10.0).description("longitudinal velocity");
    X = 10, real "x", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_x"]))
        .description("position of the centre of gravity");
    Y = 11, real "y", Output, Continuous,
        .unit("m").nominal(100.0).depends_on(Nothing).initial_depends_on(On(&["initial_y"]))
        .description("position of the centre of gravity");
    Yaw = 12, real "yaw", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing).initial_depends_on(On(&["initial_yaw"]))
        .description("yaw, not wrapped");
    Course = 13, real "course", Output, Continuous,
        .unit("rad").display_unit("deg").depends_on(Nothing)
        .initial_depends_on(On(&["yaw_rate", "speed", "sideslip_per_yaw_rate", "sideslip_growth", "sideslip_reference_speed", "distance_rear", "initial_yaw"]))
        .description("direction in which the centre of gravity moves, not wrapped");
    PositionStd = 14, real "position_std", Output, Continuous,
        .unit("m").nominal(0.1).depends_on(Nothing).initial_depends_on(On(&["initial_position_std"]))
        .description("standard deviation of the position in the direction in which it is largest");
    SideslipPerYawRateOffset = 15, real "sideslip_per_yaw_rate_offset", Output, Continuous,
        .unit("s").nominal(0.01).depends_on(Nothing).initial_depends_on(Nothing)
        .description("what the sideslip angle per yaw rate is beyond that of the parameters, as learnt from the fixes");
    GnssLatency = 20, real "gnss_latency", Parameter, Fixed, at estimator.parameters.gnss.latency_s,
        .unit("s").display_unit("ms").min(0.0).max(10.0).description("age of a fix when it arrives");
    AntennaX = 21, real "antenna_x", Parameter, Fixed, at estimator.parameters.gnss.antenna_x_m,
        .unit("m").min(-100.0).max(100.0).description("the antenna ahead of the centre of gravity");
    AntennaY = 22, real "antenna_y", Parameter, Fixed, at estimator.parameters.gnss.antenna_y_m,
        .unit("m").min(-100.0).max(100.0).description("the antenna to the left of the centre of gravity");
    SideslipPerYawRate = 23, real "sideslip_per_yaw_rate", Parameter, Fixed, at estimator.parameters.sideslip.per_yaw_rate,
        .unit("s").nominal(0.1).min(-10.0).max(10.0).description("sideslip angle per yaw rate in a steady turn");
    YawRateNoiseDensity = 24, real "yaw_rate_noise_density", Parameter, Fixed, at estimator.parameters.noise.yaw_rate_density,
        .nominal(1e-3).min(0.0).max(100.0).description("density of the gyro's white noise, rad/s per root Hz");
    YawRateBiasDensity = 25, real "yaw_rate_bias_density", Parameter, Fixed, at estimator.parameters.noise.yaw_rate_bias_density,
        .nominal(1e-4).min(0.0).max(100.0).description("density of what the gyro's bias walks by, rad/s2 per root Hz");
    SpeedNoiseDensity = 26, real "speed_noise_density", Parameter, Fixed, at estimator.parameters.noise.speed_density,
        .nominal(0.1).min(0.0).max(1000.0).description("density of the speed's white noise, m/s per root Hz");
    LateralVelocityNoiseDensity = 27, real "lateral_velocity_noise_density", Parameter, Fixed, at estimator.parameters.noise.lateral_velocity_density,
        .nominal(0.1).min(0.0).max(1000.0).description("density of the lateral velocity beyond the sideslip, m/s per root Hz");
    GnssPeriod = 28, real "gnss_period", Parameter, Fixed, at estimator.parameters.gnss.period_s,
        .unit("s").display_unit("ms").min(0.0).max(3600.0).description("time between fixes taken from the inputs without a changed count; 0 for none");
    SideslipGrowth = 29, real "sideslip_growth", Parameter, Fixed, at estimator.parameters.sideslip.growth,
        .unit("s5/m2").nominal(0.001).min(-1.0).max(1.0).description("what the sideslip per yaw rate grows by, per squared lateral acceleration");
    InitialX = 30, real "initial_x", Parameter, Fixed, at estimator.parameters.initial_pose.x,
        .unit("m").description("position at the start");
    InitialY = 31, real "initial_y", Parameter, Fixed, at estimator.parameters.initial_pose.y,
        .unit("m").description("position at the start");
    InitialYaw = 32, real "initial_yaw", Parameter, Fixed, at estimator.parameters.initial_pose.yaw,
        .unit("rad").display_unit("deg").description("yaw at the start");
    InitialPositionStd = 33, real "initial_position_std", Parameter, Fixed, at estimator.parameters.initial.position_std_m,
        .unit("m").min(0.0).max(1e6).description("standard deviation of each coordinate at the start");
    InitialYawStd = 34, real "initial_yaw_std", Parameter, Fixed, at estimator.parameters.initial.yaw_std_rad,
        .unit("rad").display_unit("deg").min(0.0).max(std::f64::consts::PI).description("standard deviation of the yaw at the start; above 0.5 it is determined from the first fixes");
    InitialYawRateBiasStd = 35, real "initial_yaw_rate_bias_std", Parameter, Fixed, at estimator.parameters.initial.yaw_rate_bias_std_radps,
        .unit("rad/s").display_unit("deg/s").min(0.0).max(10.0).description("standard deviation of the gyro's bias at the start");
    SideslipPerYawAcceleration = 36, real "sideslip_per_yaw_acceleration", Parameter, Fixed, at estimator.parameters.sideslip.per_yaw_acceleration,
        .unit("s2").nominal(0.01).min(-1.0).max(1.0).description("sideslip angle per yaw acceleration");
    SideslipReferenceSpeed = 37, real "sideslip_reference_speed", Parameter, Fixed, at estimator.parameters.sideslip.reference_speed,
        .unit("m/s").display_unit("km/h").min(0.0).max(1000.0).nominal(10.0).description("speed at which the sideslip parameters hold");
    DistanceRear = 38, real "distance_rear", Parameter, Fixed, at estimator.parameters.sideslip.distance_rear,
        .unit("m").min(0.0).max(100.0).description("distance from centre of gravity to rear axle, by which the sideslip follows the speed; 0: not known, the sideslip parameters hold at all speeds");
    SideslipPerYawRateDensity = 39, real "sideslip_per_yaw_rate_density", Parameter, Fixed, at estimator.parameters.noise.sideslip_per_yaw_rate_density,
        .nominal(1e-3).min(0.0).max(10.0).description("density of what the sideslip per yaw rate walks by, s per root s");
    InitialSideslipPerYawRateStd = 40, real "initial_sideslip_per_yaw_rate_std", Parameter, Fixed, at estimator.parameters.initial.sideslip_per_yaw_rate_std_s,
        .unit("s").display_unit("ms").min(0.0).max(10.0).description("standard deviation of the sideslip per yaw rate at the start; 0: known exactly");
}

/// A filter that estimates the pose from fixes, yaw rate and speed.
#[derive(Debug, Clone)]
pub struct PoseEstimator {
    estimator: steerwright_models::PoseEstimator,
    /// Whether initialization mode was left.
    started: bool,
}

impl PoseEstimator {
    /// Until the start, everything is as after a start from the present settings; one that
    /// cannot be is refused when initialization mode is left.
    fn settled(&mut self) -> &steerwright_models::PoseEstimator {
        if !self.started {
            let _ = self.estimator.start();
        }
        &self.estimator
    }
}

impl Definition for PoseEstimator {
    type File = Estimator;
    const RESOURCE: &'static str = "estimator.json";
    const ROLE: Role = Role::Estimator;

    /// Five seconds to the left, then to the right, with poor fixes, an outlier and a drop-out.
    fn scenario(file: Estimator) -> Scenario {
        let (speed, latency) = (file.speed_mps, file.gnss.latency_s);
        Scenario::new(move |input, Moment { time, .. }| located(input, time, speed, latency))
    }
}

/// Yaw rate of the two turns of the reference run, rad/s; the gyro reads a little more.
const TURN: f64 = 0.2;
const GYRO_BIAS: f64 = 0.01;

/// An input at a time (s) of the reference run, at a speed (m/s), with fixes that are late by `latency` (s).
fn located(input: &str, time: f64, speed: f64, latency: f64) -> Option<f64> {
    // The latest fix: ten a second, none from 6 s to 8 s.
    let count = if (6.0..8.0).contains(&time) { 60.0 } else { (10.0 * time + 1e-6).floor() };
    let valid = (0.1 * count - latency).max(0.0);
    let radius = speed / TURN;
    let (left, right) = (TURN * valid.min(5.0), TURN * (valid - 5.0).max(0.0));
    Some(match input {
        "yaw_rate" => GYRO_BIAS + if time < 5.0 { TURN } else { -TURN },
        "speed" => speed,
        "gnss_fix_count" => count,
        "gnss_std" if (40.0..=60.0).contains(&count) => 0.5,
        "gnss_std" => 0.02,
        "gnss_x" => {
            let outlier = if count == 30.0 { 5.0 } else { 0.0 };
            outlier + radius * (left.sin() + left.sin() - (left - right).sin())
        }
        "gnss_y" => radius * (1.0 - left.cos() + (left - right).cos() - left.cos()),
        _ => return None,
    })
}

impl CoSimulationUnit for PoseEstimator {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// The outputs are those of the last step, held until the next, and jump at a fix.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = optional::<Estimator>(resources, Self::RESOURCE)?;
        let mut parameters = PoseParameters::default();
        parameters.sideslip.reference_speed = SPEED;
        if let Some(file) = &file {
            parameters = steerwright_models::files::pose_parameters(file);
        }
        let mut estimator = steerwright_models::PoseEstimator::new(parameters)
            .map_err(|e| format!("estimator.json: {e}; hint: {}", e.hint()))?;
        estimator.input.gnss_std = parameters.gnss.std_m;
        estimator.input.speed = file.map_or(SPEED, |file| file.speed_mps);
        with_start_values(Self { estimator, started: false }, resources)
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        Value::Real(match variable {
            V::GnssFixCount => return Value::Integer(self.estimator.input.gnss_fix_count),
            V::X => self.settled().x(),
            V::Y => self.settled().y(),
            V::Yaw => self.settled().yaw(),
            V::Course => self.settled().course(),
            V::PositionStd => self.settled().position_std(),
            V::SideslipPerYawRateOffset => self.settled().sideslip_per_yaw_rate_offset(),
            other => other.place(self).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        match (variable, value) {
            (V::GnssFixCount, Value::Integer(count)) => {
                self.estimator.input.gnss_fix_count = *count;
            }
            (_, Value::Real(value)) => {
                if let Some(place) = variable.place(self) {
                    *place = *value;
                }
            }
            _ => {}
        }
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.started = true;
        self.estimator.start().map_err(|e| refuse(&e))?;
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log) -> Result<(), String> {
        self.estimator.step(step).map_err(|e| refuse(&e))
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.started, self.estimator.save()))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (started, saved): (bool, SavedPose) = decode(bytes)?;
        let estimator =
            steerwright_models::PoseEstimator::restore(saved).map_err(|e| refuse(&e))?;
        let mut loaded = Self { estimator, started };
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}

/// Longitudinal velocity at the start where no file states another, m/s.
const SPEED: f64 = 10.0;
