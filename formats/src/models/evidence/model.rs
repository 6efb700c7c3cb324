//! Properties of the model: residuals and predictions on validation data, poles and zeros.

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

/// The predictions of the model on validation data.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldOut {
    /// Standard error of the simulation fit on validation data, percentage points (block
    /// jackknife); absent where they are too short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit_standard_error: Option<f64>,
    /// Number of blocks of time behind it.
    pub blocks: usize,
    /// How the validation data were chosen: `end` of the log, `excited-blocks` where the end is not
    /// excited, `speed-blocks` where the speed varies, `windows` of accumulated drives.
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

/// Blocks of time that a standard error of a fit needs at least.
pub const LEAST_BLOCKS: usize = 5;
/// The length of such a block, s: that of a few manoeuvres, nearly independent of the others.
pub const BLOCK_S: f64 = 3.0;

/// Why a fit over so many blocks has no standard error.
#[must_use]
pub fn too_few_blocks(blocks: usize) -> String {
    format!(
        "a standard error of the fit needs {LEAST_BLOCKS} blocks of {BLOCK_S} s, and the validation data have {blocks}"
    )
}

impl HeldOut {
    /// Why the fit has no standard error, where it has none.
    #[must_use]
    pub fn without_standard_error(&self) -> String {
        if self.selection == "windows" {
            return "windows of accumulated drives have no blocks of time".into();
        }
        too_few_blocks(self.blocks)
    }
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

/// Correlation of the one-step residuals on validation data, lag by lag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualCorrelation {
    /// Autocorrelation at lags 1, 2, …
    pub autocorrelation: Vec<f64>,
    /// Bound on their absolute values with a probability of 99 % for white residuals.
    pub autocorrelation_bound: f64,
    /// Correlation of the input at t and the residual at t + k, k from −n to n.
    pub with_input: Vec<f64>,
    /// Bound on their absolute values with a probability of 99 % if input and residuals are uncorrelated.
    pub with_input_bound: f64,
    /// Test for feedback: whether past residuals explain a part of the input, as with a driver who
    /// corrects deviations. Passed if they do not.
    pub feedback: ResidualTest,
}

/// Poles and transmission zeros.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoleZeroMap {
    /// Eigenvalues of A; of a conjugate pair, the one above the real axis.
    pub poles: Vec<Mode>,
    /// Finite transmission zeros of the discrete model, likewise.
    pub zeros: Vec<Mode>,
    /// Finite transmission zeros of the continuous model, rad/s, all of them as (real, imaginary);
    /// those of the discrete model that come from sampling alone are not among them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub continuous_zeros: Vec<[f64; 2]>,
    /// Their covariances, in the same order; empty if unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub continuous_zero_spreads: Vec<Spread>,
}

/// Covariance of a point in the plane, to first order.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Variance of the real part.
    pub variance_re: f64,
    /// Variance of the imaginary part.
    pub variance_im: f64,
    /// Covariance of the two.
    pub covariance: f64,
}

/// A pole or zero z, and s = ln(z)/T.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mode {
    /// z, (real, imaginary).
    pub discrete: [f64; 2],
    /// The covariance of z; absent if unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<Spread>,
    /// s, rad/s, (real, imaginary); absent for z = 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous: Option<[f64; 2]>,
    /// |s|/2π, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub natural_frequency_hz: Option<f64>,
    /// −Re s/|s|.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// −1/Re s, s; absent if it does not decay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant_s: Option<f64>,
}
