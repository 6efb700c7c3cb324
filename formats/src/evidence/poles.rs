//! Poles and zeros of the model.

use serde::{Deserialize, Serialize};

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
