//! `PoseEstimator`: the glue from [`steerwright_models::PoseEstimator`] to the export trait.

use crate::resources::{optional, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::tables::pose_estimator::Variable as V;
use fmi2_export::{Capabilities, Log, Resources, Slave};
use model_description::{Table, Value};
use steerwright_models::{PoseParameters, SavedPose};

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

    /// A parameter or an input that is a Real; `None` for the others and for outputs.
    fn number(&mut self, variable: V) -> Option<&mut f64> {
        let i = &mut self.estimator.input;
        let p = &mut self.estimator.parameters;
        Some(match variable {
            V::GnssX => &mut i.gnss_x,
            V::GnssY => &mut i.gnss_y,
            V::GnssStd => &mut i.gnss_std,
            V::YawRate => &mut i.yaw_rate,
            V::Speed => &mut i.speed,
            V::GnssLatency => &mut p.gnss_latency,
            V::GnssPeriod => &mut p.gnss_period,
            V::AntennaX => &mut p.antenna_x,
            V::AntennaY => &mut p.antenna_y,
            V::SideslipPerYawRate => &mut p.sideslip.per_yaw_rate,
            V::SideslipGrowth => &mut p.sideslip.growth,
            V::SideslipPerYawAcceleration => &mut p.sideslip.per_yaw_acceleration,
            V::SideslipReferenceSpeed => &mut p.sideslip.reference_speed,
            V::DistanceRear => &mut p.sideslip.distance_rear,
            V::YawRateNoiseDensity => &mut p.yaw_rate_noise_density,
            V::YawRateBiasDensity => &mut p.yaw_rate_bias_density,
            V::SpeedNoiseDensity => &mut p.speed_noise_density,
            V::LateralVelocityNoiseDensity => &mut p.lateral_velocity_noise_density,
            V::InitialX => &mut p.initial_x,
            V::InitialY => &mut p.initial_y,
            V::InitialYaw => &mut p.initial_yaw,
            V::InitialPositionStd => &mut p.initial_position_std,
            V::InitialYawStd => &mut p.initial_yaw_std,
            V::InitialYawRateBiasStd => &mut p.initial_yaw_rate_bias_std,
            V::GnssFixCount | V::X | V::Y | V::Yaw | V::Course | V::PositionStd => return None,
        })
    }
}

impl Slave for PoseEstimator {
    type Variable = V;
    const TABLE: &'static Table = V::TABLE;
    /// The outputs are those of the last step, held until the next, and jump at a fix.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let file = optional::<steerwright_formats::Estimator>(resources, "estimator.json")?;
        let mut parameters = PoseParameters::default();
        parameters.sideslip.reference_speed = SPEED;
        if let Some(file) = &file {
            parameters = steerwright_loading::pose_parameters(file);
        }
        let mut estimator = steerwright_models::PoseEstimator::new(parameters)
            .map_err(|e| format!("estimator.json: {e}; hint: {}", e.hint()))?;
        estimator.input.gnss_std = file.as_ref().and_then(|file| file.gnss.std_m).unwrap_or(0.0);
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
            other => self.number(other).map_or(0.0, |value| *value),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        match (variable, value) {
            (V::GnssFixCount, Value::Integer(count)) => {
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
