//! `*.rfactor`: the R factor of the windows of drives that are too long, or too many, for memory. It
//! can be merged with others and identified from.
//!
//! The R factors are bytes of `sysid` in hexadecimal; everything else is plain. A checksum over the
//! whole file detects a file that was cut or changed.

use crate::document::{Checker, Document};
use crate::models::{ChannelSummary, InputKind};
use crate::provenance::{Provenance, sha256_hex};
use serde::{Deserialize, Serialize};

/// The windows of accumulated drives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AccumulatedDrives {
    /// `steerwright/factor/2`.
    pub schema: String,
    /// A name, such as the first log's.
    pub name: String,
    /// Input of the model.
    pub input: InputKind,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// Sample time T.
    pub sample_time_s: f64,
    /// Block rows of past and of future.
    pub horizon: usize,
    /// Samples to estimate from.
    pub estimation_samples: usize,
    /// Number of validation samples.
    pub validation_samples: usize,
    /// The speed over all samples, if every drive has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<AccumulatedSpeed>,
    /// The channels of the logs; drives with equal columns are combined.
    pub channels: Vec<ChannelSummary>,
    /// Warnings of the log reader.
    pub warnings: Vec<String>,
    /// The sources of the file.
    pub provenance: Provenance,
    /// State of the estimation data's windows, in hexadecimal.
    pub estimation: String,
    /// State of the validation data's windows, in hexadecimal.
    pub validation: String,
    /// Sums of Welch's spectra of all samples: number of windows, variance of their average, then |U|²,
    /// |Y|² and the parts of U*Y at each frequency.
    pub spectra: Vec<f64>,
    /// SHA-256 of this file with an empty string in this place.
    pub sha256: String,
}

/// Mean and spread of a speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AccumulatedSpeed {
    /// Mean, m/s.
    pub mean_mps: f64,
    /// Standard deviation, m/s.
    pub standard_deviation_mps: f64,
}

impl AccumulatedDrives {
    /// The document with its checksum.
    #[must_use]
    pub fn sealed(mut self) -> Self {
        self.sha256 = self.checksum();
        self
    }

    fn checksum(&self) -> String {
        let open = Self { sha256: String::new(), ..self.clone() };
        sha256_hex(open.to_json().as_bytes())
    }
}

impl Document for AccumulatedDrives {
    const SCHEMA: &'static str = "steerwright/factor/2";

    fn check(&self, c: &mut Checker) {
        c.positive(self.steering_ratio, "steering_ratio");
        c.positive(self.sample_time_s, "sample_time_s");
        c.require((2..=200).contains(&self.horizon), "horizon", || {
            format!("{} is not within 2 to 200", self.horizon)
        });
        if let Some(speed) = &self.speed {
            c.not_negative(speed.mean_mps, "speed.mean_mps");
            c.not_negative(speed.standard_deviation_mps, "speed.standard_deviation_mps");
        }
        c.require(self.sha256 == self.checksum(), "sha256", || {
            "the checksum is not that of the file: it was cut or changed".into()
        });
    }
}
