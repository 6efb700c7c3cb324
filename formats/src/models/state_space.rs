//! The discrete and the continuous form of an identified model.

use crate::document::Checker;
use crate::matrix::Matrix;
use serde::{Deserialize, Serialize};

/// `x⁺ = A x + B u + K e`, `y = C x + D u + e` (eq 3–5).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Discrete {
    /// Sample time T.
    pub sample_time_s: f64,
    /// State matrix, n by n.
    #[serde(rename = "A")]
    pub a: Matrix,
    /// Input matrix, n by 1.
    #[serde(rename = "B")]
    pub b: Matrix,
    /// Output matrix, 1 by n.
    #[serde(rename = "C")]
    pub c: Matrix,
    /// Feedthrough, 1 by 1.
    #[serde(rename = "D")]
    pub d: Matrix,
    /// Kalman gain, n by 1.
    #[serde(rename = "K")]
    pub k: Matrix,
    /// State at the log's first sample.
    pub x0: Vec<f64>,
}

/// `ẋ = F x + G u`, `y = H x + D u` (eq 6–8), the exact zero-order-hold inverse of [`Discrete`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Continuous {
    /// State matrix, n by n.
    #[serde(rename = "F")]
    pub f: Matrix,
    /// Input matrix, n by 1.
    #[serde(rename = "G")]
    pub g: Matrix,
    /// Output matrix, 1 by n.
    #[serde(rename = "H")]
    pub h: Matrix,
}

impl Continuous {
    /// Reports matrices that are not of order `n`; `at` is the key.
    pub(crate) fn check(&self, c: &mut Checker, n: usize, at: &str) {
        c.shape(&self.f, n, n, &format!("{at}.F"));
        c.shape(&self.g, n, 1, &format!("{at}.G"));
        c.shape(&self.h, 1, n, &format!("{at}.H"));
    }
}
