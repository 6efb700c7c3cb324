//! `PoseEstimator`: the glue from [`steerwright_models::PoseEstimator`] to the export trait.

use crate::finite::outputs_are_finite;
use crate::resources::optional;
use crate::saved::{check_settable, decode, encode, refuse};
use crate::start::with_start_values;
use crate::tables::pose_estimator::Variable;
use fmi2_export::{Capabilities, Log, Resources, Slave};
use model_description::{Table, Value};
use steerwright_models::{PoseInput, PoseParameters, SavedPose};

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

    fn number(&mut self, variable: Variable) -> Option<&mut f64> {
        let PoseInput { gnss_x, gnss_y, gnss_std, gnss_fix_count: _, yaw_rate, speed } =
            &mut self.estimator.input;
        let PoseParameters {
            gnss_latency,
            gnss_period,
            antenna_x,
            antenna_y,
            sideslip_per_yaw_rate,
            sideslip_growth,
            sideslip_per_yaw_acceleration,
            yaw_rate_noise_density,
            yaw_rate_bias_density,
            speed_noise_density,
            lateral_velocity_noise_density,
            initial_x,
            initial_y,
            initial_yaw,
            initial_position_std,
            initial_yaw_std,
            initial_yaw_rate_bias_std,
        } = &mut self.estimator.parameters;
        Some(match variable {
            Variable::GnssX => gnss_x,
            Variable::GnssY => gnss_y,
            Variable::GnssStd => gnss_std,
            Variable::YawRate => yaw_rate,
            Variable::Speed => speed,
            Variable::GnssLatency => gnss_latency,
            Variable::GnssPeriod => gnss_period,
            Variable::AntennaX => antenna_x,
            Variable::AntennaY => antenna_y,
            Variable::SideslipPerYawRate => sideslip_per_yaw_rate,
            Variable::SideslipGrowth => sideslip_growth,
            Variable::SideslipPerYawAcceleration => sideslip_per_yaw_acceleration,
            Variable::YawRateNoiseDensity => yaw_rate_noise_density,
            Variable::YawRateBiasDensity => yaw_rate_bias_density,
            Variable::SpeedNoiseDensity => speed_noise_density,
            Variable::LateralVelocityNoiseDensity => lateral_velocity_noise_density,
            Variable::InitialX => initial_x,
            Variable::InitialY => initial_y,
            Variable::InitialYaw => initial_yaw,
            Variable::InitialPositionStd => initial_position_std,
            Variable::InitialYawStd => initial_yaw_std,
            Variable::InitialYawRateBiasStd => initial_yaw_rate_bias_std,
            Variable::GnssFixCount
            | Variable::X
            | Variable::Y
            | Variable::Yaw
            | Variable::Course
            | Variable::PositionStd => return None,
        })
    }
}

impl Slave for PoseEstimator {
    type Variable = Variable;
    const TABLE: &'static Table = Variable::TABLE;
    /// The outputs are those of the last step, held until the next, and jump at a fix.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = optional::<steerwright_formats::Estimator>(resources, "estimator.json")?;
        let parameters = file
            .as_ref()
            .map_or_else(PoseParameters::default, steerwright_loading::pose_parameters);
        let mut estimator = steerwright_models::PoseEstimator::new(parameters)
            .map_err(|e| format!("estimator.json: {e}; hint: {}", e.hint()))?;
        estimator.input.gnss_std = file.as_ref().and_then(|file| file.gnss.std_m).unwrap_or(0.0);
        estimator.input.speed = file.map_or(SPEED, |file| file.speed_mps);
        with_start_values(Self { estimator, started: false }, resources)
    }

    #[inline]
    fn get(&mut self, variable: Variable) -> Value {
        Value::Real(match variable {
            Variable::GnssFixCount => return Value::Integer(self.estimator.input.gnss_fix_count),
            Variable::X => self.settled().x(),
            Variable::Y => self.settled().y(),
            Variable::Yaw => self.settled().yaw(),
            Variable::Course => self.settled().course(),
            Variable::PositionStd => self.settled().position_std(),
            other => self.number(other).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: Variable, value: &Value) {
        match (variable, value) {
            (Variable::GnssFixCount, Value::Integer(count)) => {
                self.estimator.input.gnss_fix_count = *count;
            }
            (_, Value::Real(value)) => {
                if let Some(place) = self.number(variable) {
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
