//! What a model leaves unexplained.

use serde::{Deserialize, Serialize};

/// A test of residuals against a χ² bound.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualTest {
    /// Number of lags.
    pub lags: usize,
    /// The statistic.
    pub statistic: f64,
    /// The bound at 99 %.
    pub bound: f64,
    /// Whether statistic ≤ bound.
    pub pass: bool,
}

/// How the model predicts what it was not estimated on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldOut {
    /// Standard error of the simulation fit on the validation data, percentage points (block
    /// jackknife); absent where the validation data are too short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit_standard_error: Option<f64>,
    /// Blocks of time it comes from.
    pub blocks: usize,
    /// How the validation data were chosen: `end` of the log, `excited-blocks` where the end is not
    /// excited, `windows` of accumulated drives.
    #[serde(default)]
    pub selection: String,
    /// First and last instants of each segment of validation data, s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub segments_s: Vec<[f64; 2]>,
    /// Fit that noise of the size of the one-step prediction errors allows at most, percent: no
    /// simulation reaches more on these data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit_bound: Option<f64>,
    /// Variance of the yaw rate that the simulation accounts for, percent.
    pub variance_accounted_for: f64,
    /// Fits of predictions some steps ahead, by rising number of steps.
    pub predictions: Vec<PredictionFit>,
}

/// Fit of k-step predictions: from all inputs, and the outputs up to k samples ago.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictionFit {
    /// Steps k ahead; absent for the simulation, which sees no output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
    /// The same in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ahead_s: Option<f64>,
    /// Fit, percent.
    pub fit: f64,
    /// Variance accounted for, percent.
    pub variance_accounted_for: f64,
}

/// Correlation of the one-step residuals on the validation data, lag by lag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualCorrelation {
    /// Autocorrelation at lags 1, 2, …
    pub autocorrelation: Vec<f64>,
    /// What each stays within, up to its sign, with a probability of 99 % for white residuals.
    pub autocorrelation_bound: f64,
    /// Correlation of the input at t and the residual at t + k, k from −n to n.
    pub with_input: Vec<f64>,
    /// What each stays within, up to its sign, with a probability of 99 % where they are unrelated.
    pub with_input_bound: f64,
    /// Whether past residuals say something of the input, as where a driver corrects what he sees:
    /// passed where they do not.
    pub feedback: ResidualTest,
}
