//! The evidence for the quality of an identified bicycle.

use crate::document::Checker;
use crate::models::evidence::{ChannelSummary, HeldOut, IdentifiedActuator};
use crate::models::state_space::Continuous;
use serde::{Deserialize, Serialize};

/// The results of the identification of a bicycle from a log.
///
/// Fit is 100·(1 − ‖y − ŷ‖/‖y − mean(y)‖) on yaw rate, in percent, of a simulation over the recorded
/// steering and speed with the estimated offsets; the initial state is estimated at the start of each
/// part.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BicycleEvidence {
    /// Samples used for estimation.
    pub estimation_samples: usize,
    /// Number of validation samples.
    pub validation_samples: usize,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// The linear vehicle, without a delay, for which the steering was held over each sample; absent where it was held as
    /// it was read, and in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_for: Option<Continuous>,
    /// Period of the steering, s, where the data do not determine whether it is held between its samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open_hold_s: Option<f64>,
    /// Fit on the estimation data, percent.
    pub estimation_fit: f64,
    /// Fit on validation data, percent.
    pub validation_fit: f64,
    /// Selection of the validation data, and the fit there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
    /// Speed over the estimation data.
    pub speed: SpeedSummary,
    /// The quantities that the yaw rate identifies; angles are of the road wheel, by the log's steering
    /// ratio.
    pub identified: Vec<Estimated>,
    /// The covariance factor of the vehicle's data: one standard deviation along each independent axis of
    /// the identified quantities. Empty if not stated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub directions: Vec<VehicleDirection>,
    /// Parameters that the yaw rate does not determine, with the origin of their values.
    pub stated: Vec<Stated>,
    /// Steering angle that drives straight, rad, in the log's coordinates. The plant has none.
    pub steering_offset_rad: f64,
    /// Fastest steering of the log, rad/s in its coordinates, by `Excitation::largest_rate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_steering_rate_radps: Option<f64>,
    /// Offset of the yaw rate's sensor, rad/s. The plant has none.
    pub yaw_rate_offset_radps: f64,
    /// The model with a delay of the steering, which is that of the file if the delay is determined and positive.
    pub with_delay: WithDelay,
    /// The actuator behind the steering command beside the measured angle; absent where no such command was read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actuator: Option<IdentifiedActuator>,
    /// How long the simulation errors last, s: their long-run variance over their variance, by the
    /// sample time. The standard errors count with it.
    pub error_correlation_time_s: f64,
    /// Standard deviation of the simulation errors on the estimation data, rad/s; absent in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_std_radps: Option<f64>,
    /// The channels of the log, after resampling.
    pub channels: Vec<ChannelSummary>,
    /// Warnings of the log reader and of the identification.
    pub warnings: Vec<String>,
}

/// A number with its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimated {
    /// The quantity.
    pub name: String,
    /// The estimate.
    pub value: f64,
    /// Its standard deviation.
    pub standard_error: f64,
    /// Unit of both.
    pub unit: String,
}

impl Estimated {
    /// The name of the largest rate of the road wheels.
    pub const LARGEST_RATE: &str = "actuator_rate_max";
}

/// Natural logarithms of factors on a vehicle's data, and a change of its delay.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleDirection {
    /// On both axles' distances from the centre of gravity.
    pub wheelbase: f64,
    /// On the yaw inertia.
    pub yaw_inertia: f64,
    /// On the front axle's cornering stiffness.
    pub cornering_stiffness_front: f64,
    /// On the rear axle's cornering stiffness.
    pub cornering_stiffness_rear: f64,
    /// On the actuator's time constant.
    pub actuator_time_constant: f64,
    /// On the steering ratio.
    pub steering_ratio: f64,
    /// Change of the actuator's delay, s.
    #[serde(default)]
    pub actuator_delay_s: f64,
}

/// A number that was not identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stated {
    /// Key in the vehicle's data.
    pub name: String,
    /// The number.
    pub value: f64,
    /// The origin of the number.
    pub origin: String,
}

/// Speeds of a recording, m/s.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedSummary {
    /// The lowest, m/s.
    pub min_mps: f64,
    /// Mean, m/s.
    pub mean_mps: f64,
    /// The highest, m/s.
    pub max_mps: f64,
    /// Standard deviation, m/s.
    pub standard_deviation_mps: f64,
}

impl SpeedSummary {
    /// Whether the speed hardly varies, so that nothing is known of other speeds.
    #[must_use]
    pub fn is_one_speed(&self) -> bool {
        self.standard_deviation_mps < LEAST_SPREAD * self.mean_mps
    }
}

/// Standard deviation of a speed over its mean, below which it is one speed.
pub const LEAST_SPREAD: f64 = 0.05;

/// The bicycle with a delay of the steering.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WithDelay {
    /// The delay, s; negative if the steering channel lags behind the gyro.
    pub input_delay_s: f64,
    /// Its standard deviation, s.
    pub standard_error_s: f64,
    /// The actuator's time constant estimated together with it, s.
    pub actuator_time_constant_s: f64,
    /// Fit on the estimation data, percent.
    pub estimation_fit: f64,
    /// Fit on validation data, percent.
    pub validation_fit: f64,
}

impl VehicleDirection {
    /// Reports impossible numbers; `at` is the prefix of each key.
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        check_fields!(c.finite(self, at): wheelbase yaw_inertia cornering_stiffness_front
            cornering_stiffness_rear actuator_time_constant steering_ratio actuator_delay_s);
    }
}

impl BicycleEvidence {
    /// Spectral density of the simulation errors over the long run, (rad/s)²/Hz, two-sided; `None` where it is not stated.
    #[must_use]
    pub fn noise_density(&self) -> Option<f64> {
        let density = self.error_std_radps?.powi(2) * self.error_correlation_time_s;
        if density > 0.0 { Some(density) } else { None }
    }

    /// Reports impossible numbers; `at` is the prefix of each key.
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        c.positive(self.sample_time_s, &format!("{at}sample_time_s"));
        if let Some(vehicle) = &self.held_for {
            vehicle.check(c, vehicle.f.rows(), &format!("{at}held_for"));
        }
        if let Some(period) = self.open_hold_s {
            c.positive(period, &format!("{at}open_hold_s"));
        }
        if let Some(deviation) = self.error_std_radps {
            c.not_negative(deviation, &format!("{at}error_std_radps"));
        }
        if let Some(actuator) = &self.actuator {
            actuator.check(c, &format!("{at}actuator."));
        }
        for (value, key) in [
            (self.steering_offset_rad, "steering_offset_rad"),
            (self.yaw_rate_offset_radps, "yaw_rate_offset_radps"),
            (self.with_delay.input_delay_s, "with_delay.input_delay_s"),
            (self.estimation_fit, "estimation_fit"),
            (self.validation_fit, "validation_fit"),
        ] {
            c.finite(value, &format!("{at}{key}"));
        }
        for (i, d) in self.directions.iter().enumerate() {
            d.check(c, &format!("{at}directions[{i}]."));
        }
        for (i, e) in self.identified.iter().enumerate() {
            c.finite(e.value, &format!("{at}identified[{i}].value"));
            c.not_negative(e.standard_error, &format!("{at}identified[{i}].standard_error"));
        }
    }
}
