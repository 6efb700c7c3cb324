//! What was found of the data before a model was made of them.

use serde::{Deserialize, Serialize};

/// How the recorded windows were reduced to one triangular factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataFactor {
    /// The way that the condition allowed.
    pub method: FactorMethod,
    /// Estimated condition of the windows, scaled to equal size; absent where it is infinite, as with
    /// data without noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// The same of the input's windows alone, at the horizon asked for: beyond 1e12 it is said not to
    /// excite them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_condition: Option<f64>,
    /// Block rows that were asked for; with an automatic horizon, the longest that was tried.
    pub asked_horizon: usize,
    /// Block rows that the input excites: fewer than asked for where it does not excite those.
    pub horizon: usize,
}

/// A way to the triangular factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FactorMethod {
    /// Cholesky factor of the Gram matrix, for conditions that bear being squared.
    Gram,
    /// QR factorisation of the windows.
    Qr,
}

/// The pure delay from steering to yaw rate as the estimation data determine it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DelayEstimate {
    /// Delay of the best model that has one, s.
    pub estimate_s: f64,
    /// Its standard error, s: noise, how models of different orders differ, and what a lag can stand
    /// for; absent where the data do not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error_s: Option<f64>,
    /// Fastest time constant of the best model without a delay, s: the lag in whose place it stands.
    pub lag_without_s: f64,
    /// By how much the Bayesian information criterion prefers the delay to lags; a delay below 6 is
    /// not taken.
    pub evidence: f64,
    /// Whether it was taken for the plant's.
    pub taken: bool,
}
