//! The evidence for the quality of a vehicle that was identified from a log.

use crate::document::Checker;
use crate::matrix::Matrix;
use crate::models::bicycle_evidence::{
    BicycleEvidence, Estimated, SpeedSummary, VehicleDirection, WithDelay,
};
use crate::models::evidence::{ChannelSummary, IdentifiedActuator};
use serde::{Deserialize, Serialize};

/// The results of the identification of a vehicle from a log, by the single-track model of
/// docs/methods/single-track.md.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleEvidence {
    /// The channels of the log, after resampling.
    pub channels: Vec<ChannelSummary>,
    /// Samples used for estimation.
    pub estimation_samples: usize,
    /// Number of validation samples.
    pub validation_samples: usize,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Speed over the estimation data.
    pub speed: SpeedSummary,
    /// Largest lateral acceleration of the estimation data, m/s²: its 99th percentile, from yaw rate times speed.
    pub lateral_acceleration_mps2: f64,
    /// Roles of the channels that were fitted.
    pub fitted: Vec<String>,
    /// Period of the steering, s, where the data do not determine whether it is held between its samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open_hold_s: Option<f64>,
    /// Free simulation of the estimation data.
    pub estimation: SimulationFit,
    /// Free simulation of the validation data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation: Option<SimulationFit>,
    /// The parameters in the order of the covariance.
    pub parameters: Vec<VehicleParameter>,
    /// Covariance of the parameters' coordinates; zero for those that are stated.
    pub covariance: Matrix,
    /// The covariance factor of the vehicle's data in gentle driving: one standard deviation along each independent
    /// axis of the parameters that these depend on.
    pub directions: Vec<VehicleDirection>,
    /// Fastest steering of the log, rad/s in its coordinates, by `Excitation::largest_rate`.
    pub largest_steering_rate_radps: f64,
    /// The actuator behind the steering command beside the measured angle; absent where no such command was read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actuator: Option<IdentifiedActuator>,
    /// How much less friction the rear axle can have, relative, before the free simulation of estimation or validation
    /// data spins: at most 0.2, in steps of 0.005 near 0.
    pub spin_margin: f64,
    /// Spectral density of the errors of the yaw rate by which it was weighted, (rad/s)²/Hz, two-sided: the largest from 0 to
    /// 2 Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_rate_noise_density: Option<f64>,
    /// Warnings of the log reader and of the identification.
    pub warnings: Vec<String>,
}

/// A free simulation compared with the measured signals: from steering and speed alone,
/// each segment from the steady turn at its first yaw rate. Fits are `100·(1 − ‖y − ŷ‖/‖y − mean y‖)` in
/// percent over all segments, −100 where the simulation is worse or leaves all bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationFit {
    /// Fit of yaw rate, %.
    pub yaw_rate: f64,
    /// Its standard error, percentage points (block jackknife); absent where the data are too short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_rate_standard_error: Option<f64>,
    /// Number of blocks of time behind it.
    #[serde(default)]
    pub blocks: usize,
    /// Fit of lateral acceleration, %, where it is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_acceleration: Option<f64>,
    /// RMS error of the sideslip angle, rad, above 3 m/s, where lateral velocity is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip_rms_error_rad: Option<f64>,
    /// RMS of the measured sideslip angle likewise, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sideslip_rms_rad: Option<f64>,
    /// Largest RMS error of yaw rate in a window of 5 s, rad/s.
    pub worst_window_radps: f64,
}

/// A parameter of the single-track model with its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleParameter {
    /// The quantity.
    pub name: String,
    /// Its unit; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// The estimate.
    pub value: f64,
    /// Its standard error; 0 where it is stated.
    pub standard_error: f64,
    /// Ends of the 95 % band, within the bounds.
    pub band_95: [f64; 2],
    /// Whether its coordinate is the natural logarithm.
    pub is_logarithmic: bool,
    /// The prior distribution of the coordinate, and the bounds of the value.
    pub prior: Prior,
    /// Posterior over prior standard deviation: about 1 where the drive is uninformative; 0 where it is stated.
    pub posterior_per_prior: f64,
    /// How far the drive moved the coordinate, in standard deviations of the prior; 0 where it is stated.
    pub moved_deviations: f64,
    /// Whether the drive determines it: a posterior of at most half the prior's deviation.
    pub is_determined: bool,
    /// Whether the value is at one of its bounds.
    pub is_at_bound: bool,
}

/// A normal distribution of a parameter's coordinate, and the bounds of the value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prior {
    /// Mean; of a logarithm the median. In the parameter's unit.
    pub mean: f64,
    /// Standard deviation of the coordinate: of a logarithm relative. Zero states the parameter.
    pub standard_deviation: f64,
    /// Least value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl VehicleEvidence {
    /// The largest rate of the road wheels, rad/s, if the drive shows one or it was stated.
    fn largest_rate(&self) -> Option<Estimated> {
        let mut all = self.parameters.iter();
        let rate = all.find(|p| p.name == Estimated::LARGEST_RATE)?;
        let is_known = rate.is_determined || rate.prior.standard_deviation == 0.0;
        // The largest of all stands for none.
        if !is_known || rate.value >= rate.prior.max {
            return None;
        }
        Some(Estimated {
            name: rate.name.clone(),
            value: rate.value,
            standard_error: rate.standard_error,
            unit: rate.unit.clone(),
        })
    }

    /// That of the bicycle of gentle driving.
    #[must_use]
    pub fn of_bicycle(&self) -> BicycleEvidence {
        BicycleEvidence {
            estimation_samples: self.estimation_samples,
            validation_samples: self.validation_samples,
            sample_time_s: self.sample_time_s,
            estimation_fit: self.estimation.yaw_rate,
            validation_fit: self.validation.unwrap_or(self.estimation).yaw_rate,
            speed: self.speed,
            directions: self.directions.clone(),
            identified: self.largest_rate().into_iter().collect(),
            largest_steering_rate_radps: Some(self.largest_steering_rate_radps),
            with_delay: WithDelay::default(),
            channels: self.channels.clone(),
            actuator: self.actuator,
            open_hold_s: self.open_hold_s,
            warnings: self.warnings.clone(),
            ..BicycleEvidence::default()
        }
    }

    /// Reports impossible numbers; `at` is the prefix of each key.
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        c.positive(self.sample_time_s, &format!("{at}sample_time_s"));
        check_fields!(c.finite(self, at): lateral_acceleration_mps2 spin_margin);
        if let Some(period) = self.open_hold_s {
            c.positive(period, &format!("{at}open_hold_s"));
        }
        if let Some(density) = self.yaw_rate_noise_density {
            c.positive(density, &format!("{at}yaw_rate_noise_density"));
        }
        if let Some(actuator) = &self.actuator {
            actuator.check(c, &format!("{at}actuator."));
        }
        let fits = [(Some(self.estimation), "estimation"), (self.validation, "validation")];
        for (fit, key) in fits {
            let Some(fit) = fit else { continue };
            c.finite(fit.yaw_rate, &format!("{at}{key}.yaw_rate"));
            c.finite(fit.worst_window_radps, &format!("{at}{key}.worst_window_radps"));
        }
        for (i, p) in self.parameters.iter().enumerate() {
            c.finite(p.value, &format!("{at}parameters[{i}].value"));
            c.not_negative(p.standard_error, &format!("{at}parameters[{i}].standard_error"));
        }
        for (i, d) in self.directions.iter().enumerate() {
            d.check(c, &format!("{at}directions[{i}]."));
        }
        c.covariance(&self.covariance, self.parameters.len(), &format!("{at}covariance"));
    }
}

/// Correlation of two parameters from which they are reported.
const STRONG: f64 = 0.9;

/// Pairs of parameters whose errors are strongly correlated, with the correlation.
#[must_use]
pub fn correlated(e: &VehicleEvidence) -> Vec<(&str, &str, f64)> {
    let variance = |i: usize| e.covariance.0[i][i];
    let mut all = Vec::new();
    for i in 0..e.parameters.len() {
        for j in 0..i {
            let product = variance(i) * variance(j);
            let correlation =
                if product > 0.0 { e.covariance.0[i][j] / product.sqrt() } else { 0.0 };
            if correlation.abs() > STRONG {
                all.push((&*e.parameters[j].name, &*e.parameters[i].name, correlation));
            }
        }
    }
    all
}
