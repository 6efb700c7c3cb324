//! How far an identified bicycle can be trusted, with the numbers behind it.

use crate::{Bicycle, ChannelSummary, Checker, HeldOut, VehicleData};
use serde::{Deserialize, Serialize};

/// What was measured on the way from a log to a bicycle.
///
/// Fit is 100·(1 − ‖y − ŷ‖/‖y − mean(y)‖) on yaw rate, in percent, of a simulation over the recorded
/// steering and speed with the estimated offsets; the initial state is estimated at the start of each
/// part.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BicycleEvidence {
    /// Samples used for estimation.
    pub estimation_samples: usize,
    /// Validation samples.
    pub validation_samples: usize,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Fit on the estimation data, percent.
    pub estimation_fit: f64,
    /// Fit on the validation data, percent.
    pub validation_fit: f64,
    /// The selection of the validation data, and the results on them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
    /// Speed over the estimation data.
    pub speed: SpeedSummary,
    /// What yaw rate identifies; angles are those of the road wheel by the log's steering ratio.
    pub identified: Vec<Estimated>,
    /// How the vehicle's data vary within the uncertainty: one standard deviation along each axis of what
    /// was identified, independent of the others. Empty: not stated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub directions: Vec<VehicleDirection>,
    /// Quantities that the yaw rate does not determine and the file states.
    pub stated: Vec<Stated>,
    /// Steering angle that drives straight, rad, in the log's coordinates. The plant has none.
    pub steering_offset_rad: f64,
    /// Fastest steering of the log, rad/s in its coordinates, by `Excitation::largest_rate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_steering_rate_radps: Option<f64>,
    /// Offset of the yaw rate's sensor, rad/s. The plant has none.
    pub yaw_rate_offset_radps: f64,
    /// The same model with a delay of the steering, which the plant does not have: in the file, the
    /// actuator's lag represents both.
    pub with_delay: WithDelay,
    /// How long the simulation errors last, s: their long-run variance over their variance, by the
    /// sample time. The standard errors count with it.
    pub error_correlation_time_s: f64,
    /// What was read from the log, after resampling.
    pub channels: Vec<ChannelSummary>,
    /// What the reader of the log and the identification warned of.
    pub warnings: Vec<String>,
}

/// A number with its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimated {
    /// What it is.
    pub name: String,
    /// The estimate.
    pub value: f64,
    /// Its standard deviation.
    pub standard_error: f64,
    /// Unit of both.
    pub unit: String,
}

/// Natural logarithms of factors on a vehicle's data.
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
}

impl VehicleDirection {
    /// A vehicle that many times this direction away.
    fn moved(&self, v: &VehicleData, times: f64) -> VehicleData {
        let by = |logarithm: f64| (times * logarithm).exp();
        VehicleData {
            distance_front_m: v.distance_front_m * by(self.wheelbase),
            distance_rear_m: v.distance_rear_m * by(self.wheelbase),
            yaw_inertia_kgm2: v.yaw_inertia_kgm2 * by(self.yaw_inertia),
            cornering_stiffness_front_npr: v.cornering_stiffness_front_npr
                * by(self.cornering_stiffness_front),
            cornering_stiffness_rear_npr: v.cornering_stiffness_rear_npr
                * by(self.cornering_stiffness_rear),
            actuator_time_constant_s: v.actuator_time_constant_s * by(self.actuator_time_constant),
            steering_ratio: v.steering_ratio * by(self.steering_ratio),
            ..v.clone()
        }
    }
}

impl Bicycle {
    /// How many standard normal numbers [`Bicycle::ensemble_member`] takes; 0 where the file states no
    /// uncertainty.
    #[must_use]
    pub fn ensemble_dimension(&self) -> usize {
        self.evidence.as_ref().map_or(0, |e| e.directions.len())
    }

    /// The vehicle whose data are `ln nominal + Σ ξ_i · direction_i` in their logarithms: for independent
    /// standard normal ξ a draw from the estimate's distribution.
    ///
    /// `None` where the file states no uncertainty, where there are not [`Bicycle::ensemble_dimension`]
    /// numbers, and where a vehicle has none of these data.
    #[must_use]
    pub fn ensemble_member(&self, xi: &[f64]) -> Option<VehicleData> {
        let directions = &self.evidence.as_ref()?.directions;
        if directions.is_empty() || xi.len() != directions.len() {
            return None;
        }
        let drawn = directions
            .iter()
            .zip(xi)
            .fold(self.vehicle.clone(), |vehicle, (direction, xi)| direction.moved(&vehicle, *xi));
        let mut checker = Checker::default();
        drawn.check(&mut checker, "");
        checker.into_first().is_none().then_some(drawn)
    }
}

/// A number that was not identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stated {
    /// Key in the vehicle's data.
    pub name: String,
    /// The number.
    pub value: f64,
    /// Whose number it is.
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

/// A bicycle whose steering acts some time later.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WithDelay {
    /// The delay, s; negative where the steering channel lags behind the gyro.
    pub input_delay_s: f64,
    /// Its standard deviation, s.
    pub standard_error_s: f64,
    /// The actuator's time constant with that delay, s.
    pub actuator_time_constant_s: f64,
    /// Fit on the estimation data, percent.
    pub estimation_fit: f64,
    /// Fit on the validation data, percent.
    pub validation_fit: f64,
}

impl BicycleEvidence {
    /// Reports numbers that cannot be; `at` is put before each key.
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        c.positive(self.sample_time_s, &format!("{at}sample_time_s"));
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
            for (value, key) in [
                (d.wheelbase, "wheelbase"),
                (d.yaw_inertia, "yaw_inertia"),
                (d.cornering_stiffness_front, "cornering_stiffness_front"),
                (d.cornering_stiffness_rear, "cornering_stiffness_rear"),
                (d.actuator_time_constant, "actuator_time_constant"),
                (d.steering_ratio, "steering_ratio"),
            ] {
                c.finite(value, &format!("{at}directions[{i}].{key}"));
            }
        }
        for (i, e) in self.identified.iter().enumerate() {
            c.finite(e.value, &format!("{at}identified[{i}].value"));
            c.not_negative(e.standard_error, &format!("{at}identified[{i}].standard_error"));
        }
    }
}
