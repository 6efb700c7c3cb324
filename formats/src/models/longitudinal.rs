//! `longitudinal.json`: the response of the speed to accelerator and brake, or to an acceleration command.

use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts, quality_facts};
use crate::matrix::Matrix;
use crate::models::evidence::ChannelSummary;
use crate::models::uncertainty::Estimate;
use crate::provenance::Provenance;
use crate::quality::Quality;
use serde::{Deserialize, Serialize};

/// `dv/dt = p + b − (c0 + c1·v + c2·v²) − ρ·g·sin(grade)`, with the speed v ≥ 0. The drive p follows `G(v)·u(t − d)` with
/// the lag τ, where u is the accelerator from 0 to 1, curved by κ, or the acceleration command; b follows `−B·w(t − e)`
/// with the lag σ, where w is the brake from 0 to 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Longitudinal {
    /// `steerwright/longitudinal/1`.
    pub schema: String,
    /// A name, such as the log's.
    pub name: String,
    /// Unit of the command u: `m/s2` of an acceleration command, or `1` of an accelerator.
    pub command_unit: String,
    /// G, table over the speed with increasing speeds, linear between them and constant beyond; one row where it does not
    /// depend on the speed.
    pub gains: Vec<SpeedGain>,
    /// G by the number of the gear, in place of `gains`, which then holds the mean of all gears as they were used; empty where the gear is
    /// not an input of the model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gear_gains: Vec<GearGain>,
    /// κ, curvature of the pedal: an accelerator a acts as `u = a + κ·a·(1 − a)`; absent where it is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pedal_curvature: Option<Estimate>,
    /// τ, lag of the drive, s.
    pub time_constant_s: Estimate,
    /// d, delay of the command, s.
    pub delay_s: Estimate,
    /// The brake; absent where the log has none, or none that is used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brake: Option<Brake>,
    /// c0, rolling resistance and drag of the engine, m/s².
    pub resistance_mps2: Estimate,
    /// c1, 1/s; absent where it is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resistance_per_speed: Option<Estimate>,
    /// c2, drag, 1/m.
    pub drag_per_m: Estimate,
    /// Origin of the grade: `grade`, `pitch` or `altitude` of the log, or `none`, where the grade is part of the
    /// disturbance.
    pub grade_source: String,
    /// ρ, share of the gravity along the road that acts on the speed; absent where the log has no grade that varies, and
    /// then 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grade_coefficient: Option<Estimate>,
    /// The errors of the model and of the log.
    pub noise: LongitudinalNoise,
    /// The names of the rows of `covariance`.
    pub parameters: Vec<String>,
    /// Covariance of the parameters, in the units of these.
    pub covariance: Matrix,
    /// The evidence.
    pub evidence: LongitudinalEvidence,
    /// Whether the model may be used.
    #[serde(default)]
    pub quality: Quality,
    /// The sources of the file.
    pub provenance: Provenance,
}

/// The gain at a speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedGain {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration per command, m/s² per unit of the command.
    pub gain: Estimate,
}

/// The gain in a gear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GearGain {
    /// Number of the gear, as the log has it.
    pub gear: i64,
    /// Acceleration per command, m/s² per unit of the command.
    pub gain: Estimate,
}

/// The response to the brake.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Brake {
    /// B, deceleration at a brake of 1, m/s².
    pub gain_mps2: Estimate,
    /// σ, lag of the brake, s.
    pub time_constant_s: Estimate,
    /// e, delay of the brake, s.
    pub delay_s: Estimate,
}

/// The errors of a longitudinal model: the speed in the log is that of the vehicle and white noise, and the acceleration
/// that of the model and a disturbance, such as an unknown grade and wind, that decays exponentially.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LongitudinalNoise {
    /// Standard deviation of the noise of the speed, m/s.
    pub speed_mps: f64,
    /// Standard deviation of the disturbance, m/s².
    pub disturbance_mps2: f64,
    /// Time constant of the disturbance, s.
    pub disturbance_time_constant_s: f64,
}

/// Variation of the gain from one stretch of the drive to another at one speed, relative to it, such as that of gears which
/// the log does not have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainVariation {
    /// Length of the stretches, s.
    pub stretch_s: f64,
    /// Standard deviation of greatest likelihood.
    pub deviation: f64,
    /// Upper end of its 95 % band.
    pub largest: f64,
    /// Logarithm of the ratio of the likelihoods with and without it.
    pub log_likelihood_ratio: f64,
}

/// The data of a longitudinal model, and its errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LongitudinalEvidence {
    /// What was read from each column.
    pub channels: Vec<ChannelSummary>,
    /// How far the gain varies at one speed; absent in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_variation: Option<GainVariation>,
    /// Number of estimation samples.
    pub estimation_samples: usize,
    /// Number of validation samples.
    pub validation_samples: usize,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Lowest speed of the samples, m/s.
    pub least_speed_mps: f64,
    /// Smallest, mean and largest speed of the estimation samples, m/s.
    pub speed_mps: [f64; 3],
    /// Length of the windows that are simulated, each from an estimated initial speed, s.
    pub window_s: f64,
    /// Fit of the simulated speed to the change of the speed in the windows of the estimation data, percent.
    pub estimation_fit: f64,
    /// The same of the validation data, percent.
    pub validation_fit: f64,
    /// Standard error of the fit on validation data, percent; absent below 8 windows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation_fit_standard_error: Option<f64>,
    /// Number of windows of the validation data.
    pub validation_windows: usize,
    /// Standard deviation of the one-step prediction errors on the validation data over that which the noise model
    /// states: 1 where they agree.
    pub prediction_error_ratio: f64,
    /// Largest autocorrelation of the one-step prediction errors at lags up to 1 s, and largest correlation with the
    /// command at lags within 2 s.
    pub residual_correlation: [f64; 2],
    /// Standard deviation of a correlation of white errors.
    pub correlation_standard_error: f64,
    /// Warnings of the reader and of the identification.
    pub warnings: Vec<String>,
}

impl Longitudinal {
    /// G at a speed, m/s² per unit of the command.
    #[must_use]
    pub fn gain_at(&self, speed_mps: f64) -> f64 {
        let Some(first) = self.gains.first() else { return 0.0 };
        let mut below = first;
        for row in &self.gains {
            if row.speed_mps > speed_mps {
                let width = row.speed_mps - below.speed_mps;
                let share = if width > 0.0 { (speed_mps - below.speed_mps) / width } else { 0.0 };
                return below.gain.value + share.max(0.0) * (row.gain.value - below.gain.value);
            }
            below = row;
        }
        below.gain.value
    }

    /// G in a gear at a speed, m/s² per unit of the command; a gear without a gain of its own has that of the speed.
    #[must_use]
    pub fn gain_in(&self, gear: i32, speed_mps: f64) -> f64 {
        for row in &self.gear_gains {
            if row.gear == i64::from(gear) {
                return row.gain.value;
            }
        }
        self.gain_at(speed_mps)
    }

    /// Whether the command is an acceleration, otherwise an accelerator.
    #[must_use]
    pub fn is_acceleration_commanded(&self) -> bool {
        self.command_unit == "m/s2"
    }

    /// The estimate of a name in `parameters`; `None` where the model has none of that name.
    #[must_use]
    pub fn estimate_mut(&mut self, name: &str) -> Option<&mut Estimate> {
        if let Some((table, rest)) = name.split_once('[') {
            let index: usize = rest.strip_suffix("].gain")?.parse().ok()?;
            return match table {
                "gains" => self.gains.get_mut(index).map(|row| &mut row.gain),
                "gear_gains" => self.gear_gains.get_mut(index).map(|row| &mut row.gain),
                _ => None,
            };
        }
        match name {
            "pedal_curvature" => self.pedal_curvature.as_mut(),
            "time_constant_s" => Some(&mut self.time_constant_s),
            "delay_s" => Some(&mut self.delay_s),
            "brake.gain_mps2" => self.brake.as_mut().map(|b| &mut b.gain_mps2),
            "brake.time_constant_s" => self.brake.as_mut().map(|b| &mut b.time_constant_s),
            "brake.delay_s" => self.brake.as_mut().map(|b| &mut b.delay_s),
            "resistance_mps2" => Some(&mut self.resistance_mps2),
            "resistance_per_speed" => self.resistance_per_speed.as_mut(),
            "drag_per_m" => Some(&mut self.drag_per_m),
            "grade_coefficient" => self.grade_coefficient.as_mut(),
            _ => None,
        }
    }
}

impl Document for Longitudinal {
    const SCHEMA: &'static str = "steerwright/longitudinal/1";

    fn check(&self, c: &mut Checker) {
        let is_unit = matches!(self.command_unit.as_str(), "1" | "m/s2");
        c.require(is_unit, "command_unit", || {
            format!("found `{}`, expected `1` or `m/s2`", self.command_unit)
        });
        c.require(!self.gains.is_empty(), "gains", || "there is no gain".into());
        let is_increasing = self.gains.windows(2).all(|w| w[0].speed_mps < w[1].speed_mps);
        c.require(is_increasing, "gains", || "the speeds do not increase".into());
        let mut check = |estimate: Estimate, key: &str| {
            c.finite(estimate.value, &format!("{key}.value"));
            c.not_negative(estimate.standard_error, &format!("{key}.standard_error"));
        };
        for (i, row) in self.gains.iter().enumerate() {
            check(row.gain, &format!("gains[{i}].gain"));
        }
        for (i, row) in self.gear_gains.iter().enumerate() {
            check(row.gain, &format!("gear_gains[{i}].gain"));
        }
        let optional = [
            (self.pedal_curvature, "pedal_curvature"),
            (Some(self.time_constant_s), "time_constant_s"),
            (Some(self.delay_s), "delay_s"),
            (self.brake.map(|b| b.gain_mps2), "brake.gain_mps2"),
            (self.brake.map(|b| b.time_constant_s), "brake.time_constant_s"),
            (self.brake.map(|b| b.delay_s), "brake.delay_s"),
            (Some(self.resistance_mps2), "resistance_mps2"),
            (self.resistance_per_speed, "resistance_per_speed"),
            (Some(self.drag_per_m), "drag_per_m"),
            (self.grade_coefficient, "grade_coefficient"),
        ];
        for (estimate, key) in optional {
            if let Some(estimate) = estimate {
                check(estimate, key);
            }
        }
        for (i, row) in self.gains.iter().enumerate() {
            c.not_negative(row.speed_mps, &format!("gains[{i}].speed_mps"));
        }
        if let Some(curvature) = self.pedal_curvature {
            c.require(!self.is_acceleration_commanded(), "pedal_curvature", || {
                "the command is an acceleration, which has no pedal".into()
            });
            // Beyond these an accelerator that is pressed further would drive less.
            c.within(curvature.value, -1.0, 1.0, "pedal_curvature.value");
        }
        c.positive(self.time_constant_s.value, "time_constant_s.value");
        c.not_negative(self.delay_s.value, "delay_s.value");
        if let Some(brake) = &self.brake {
            c.positive(brake.time_constant_s.value, "brake.time_constant_s.value");
            c.not_negative(brake.delay_s.value, "brake.delay_s.value");
        }
        check_fields!(c.not_negative(self.noise, "noise."): speed_mps disturbance_mps2);
        c.positive(self.noise.disturbance_time_constant_s, "noise.disturbance_time_constant_s");
        c.covariance(&self.covariance, self.parameters.len(), "covariance");
        let e = &self.evidence;
        c.positive(e.sample_time_s, "evidence.sample_time_s");
        check_fields!(c.finite(e, "evidence."): least_speed_mps window_s estimation_fit
            validation_fit prediction_error_ratio correlation_standard_error);
        if let Some(variation) = &e.gain_variation {
            c.positive(variation.stretch_s, "evidence.gain_variation.stretch_s");
            check_fields!(c.not_negative(variation, "evidence.gain_variation."):
                deviation largest log_likelihood_ratio);
        }
        self.quality.check(c, "quality.");
    }
}

impl Described for Longitudinal {
    fn facts(self) -> Facts {
        let e = self.evidence;
        let mut facts = quality_facts(self.quality);
        facts.extend(e.warnings.into_iter().map(|line| Fact::new("warning", line, "")));
        facts.extend([
            Fact::new("fit_held_out", e.validation_fit, "%"),
            Fact::new("fit_estimation", e.estimation_fit, "%"),
            Fact::new("estimation_samples", e.estimation_samples, ""),
            Fact::new("held_out_samples", e.validation_samples, ""),
            Fact::new("sample_time", e.sample_time_s, "s"),
            Fact::new("lowest_speed", e.speed_mps[0], "m/s"),
            Fact::new("highest_speed", e.speed_mps[2], "m/s"),
            Fact::new("command_unit", self.command_unit, ""),
            Fact::new("grade_source", self.grade_source, ""),
        ]);
        Facts { name: self.name, provenance: Some(self.provenance), evidence: facts }
    }
}
