//! The evidence for the quality of an identified model.

mod data;
mod frequency;
mod model;

use crate::models::state_space::Continuous;
use serde::{Deserialize, Serialize};

pub use data::{
    DataFactor, DelayEstimate, FactorMethod, IdentifiedActuator, LimitCycle, SteeringPlay,
};
pub use frequency::{
    BandDeparture, CoherencePoint, Excitation, ExcitationBand, FrequencyResponse, Information,
    Persistence, ResponsePoint,
};
pub use model::{
    BLOCK_S, HeldOut, LEAST_BLOCKS, Mode, PoleZeroMap, PredictionFit, ResidualCorrelation,
    ResidualTest, Spread, too_few_blocks,
};

/// The evidence for the quality of an identified model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// `n4sid`, `moesp`, `cva`, `ssarx` or `pbsid`.
    pub method: String,
    /// Block rows s of the Hankel matrices (past and future horizon).
    pub horizon: usize,
    /// How the data were reduced, and how well that is conditioned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<DataFactor>,
    /// Estimate of a pure delay; absent where the delay was stated or cannot be estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay: Option<DelayEstimate>,
    /// The vehicle, without a delay, for which the steering was held over each sample; absent where it was held as it was
    /// read, and in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_for: Option<Continuous>,
    /// Samples used for estimation.
    pub estimation_samples: usize,
    /// Number of validation samples.
    pub validation_samples: usize,
    /// Fits in percent.
    pub fit: Fits,
    /// One row for each order tried.
    pub order_table: Vec<OrderRow>,
    /// Test of the estimation data for feedback from yaw rate to steering, which decides between
    /// open-loop and closed-loop methods; it passes where none is seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feedback: Option<ResidualTest>,
    /// Autocorrelation of the one-step residuals on validation data.
    pub whiteness: ResidualTest,
    /// Cross-correlation of past input and one-step residuals on validation data.
    pub independence: ResidualTest,
    /// Information in the log.
    pub excitation: Excitation,
    /// Prediction of the validation data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
    /// Play of the steering; absent if the data do not show any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub play: Option<SteeringPlay>,
    /// The actuator behind the steering command beside the measured angle; absent where no such command was read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actuator: Option<IdentifiedActuator>,
    /// Least lead of the yaw rate before the steering that causes it, s; absent if it does not lead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_rate_lead_s: Option<f64>,
    /// Lag of the yaw rate behind the steering beyond the lag of tyres and an actuator, s; absent if it is no
    /// more than a vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_rate_lag_s: Option<f64>,
    /// The residuals lag by lag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residuals: Option<ResidualCorrelation>,
    /// Measured and modelled frequency response.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_response: Option<FrequencyResponse>,
    /// Poles and zeros.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poles_and_zeros: Option<PoleZeroMap>,
    /// Largest eigenvalue modulus of A before stability was enforced; absent if it was stable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stabilised_from: Option<f64>,
    /// Relative error ‖exp(F·T) − A‖/‖A‖ and the same for B, the larger (eq 9–10).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conversion_round_trip: Option<f64>,
    /// The channels of the log, after resampling.
    pub channels: Vec<ChannelSummary>,
    /// Warnings of the log reader and of the identification.
    pub warnings: Vec<String>,
}

/// Fit is 100·(1 − ‖y − ŷ‖/‖y − mean(y)‖) on yaw rate, in percent. Validation data have the means of
/// the estimation data removed and the initial state estimated.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fits {
    /// Simulation on the estimation data.
    pub estimation: f64,
    /// Simulation on validation data.
    pub validation: f64,
    /// One-step prediction on validation data.
    pub validation_one_step: f64,
}

/// One order that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderRow {
    /// Order n.
    pub order: usize,
    /// The n-th singular value, with the method and horizon of the chosen model for all orders; absent if
    /// there are fewer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub singular_value: Option<f64>,
    /// Simulation fit on the estimation data, percent.
    pub estimation_fit: f64,
    /// Simulation fit on validation data, percent.
    pub validation_fit: f64,
    /// Whether the model was stable as estimated.
    pub stable: bool,
    /// BIC on the estimation data; the order with the smallest BIC is chosen.
    #[serde(default)]
    pub criterion: f64,
}

/// The behaviour of a channel between its samples (the terms of MATLAB's `InterSample`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Intersample {
    /// Zero-order hold: constant until the next sample, like a command.
    Zoh,
    /// First-order hold: linear interpolation.
    Foh,
    /// Band-limited: samples of a continuous signal, like those of a sensor.
    Bl,
}

crate::words!(Intersample { Zoh = "zoh", Foh = "foh", Bl = "bl" });

/// The summary of one channel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelSummary {
    /// `steering`, `yaw_rate`, `speed` …
    pub role: String,
    /// The column's name in the log.
    pub column: String,
    /// The unit it was read in.
    pub unit: String,
    /// Rows read.
    pub rows: usize,
    /// Median sample rate of the channel's clock, Hz; of a sensor whose values repeat over several rows, the
    /// rate at which it was updated.
    pub rate_hz: f64,
    /// The assumed behaviour between its samples; absent in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intersample: Option<Intersample>,
    /// Whether it was taken for band-limited, and the data show straight lines between its samples: a measured angle behind
    /// the steps of a controller.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub along_lines: bool,
    /// Smallest value, SI.
    pub min: f64,
    /// Mean, SI.
    pub mean: f64,
    /// Largest value, SI.
    pub max: f64,
    /// Step of which all values are multiples, SI; absent if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<f64>,
    /// Instants of single spikes and dropouts, which are treated as missing, s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spikes_s: Vec<f64>,
    /// First and last instants at which the channel was frozen while the vehicle was steered, s;
    /// these samples are treated as missing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frozen_s: Vec<[f64; 2]>,
}
