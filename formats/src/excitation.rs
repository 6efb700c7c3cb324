//! `excitation.json`: a manoeuvre that identifies a vehicle well, with the standard errors to expect.

use crate::document::{Checker, Document};
use crate::facts::{Described, Fact, Facts, quality_facts};
use crate::models::Estimated;
use crate::provenance::Provenance;
use crate::quality::Quality;
use serde::{Deserialize, Serialize};

/// A steering manoeuvre for an identification: its signals, when each is driven, and what it determines.
///
/// Angles are those of the log that the model is from: at the steering wheel where `steering_ratio` is that of a steering wheel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manoeuvre {
    /// `steerwright/excitation/1`.
    pub schema: String,
    /// The name of the vehicle or of its log.
    pub name: String,
    /// The kind of its signals.
    pub kind: ManoeuvreKind,
    /// What is to be known.
    pub purpose: ManoeuvrePurpose,
    /// The limits that it keeps.
    pub limits: ManoeuvreLimits,
    /// Spectral density of the errors of the yaw rate that is assumed, (rad/s)²/Hz, two-sided.
    pub noise_density: f64,
    /// Share of the recording that estimates; the rest validates.
    pub estimation_share: f64,
    /// Steering angle over road-wheel angle.
    pub steering_ratio: f64,
    /// Time from one sample of the signals to the next, s; each is held.
    pub sample_time_s: f64,
    /// Length of a block, s: a signal, and straight driving up to the next.
    pub block_s: f64,
    /// The blocks in the order to drive.
    pub schedule: Vec<ManoeuvreBlock>,
    /// The signals of the blocks.
    pub signals: Vec<SteeringSignal>,
    /// What the recording determines.
    pub expected: ExpectedErrors,
    /// The best manoeuvre of each kind.
    pub alternatives: Vec<Alternative>,
    /// The quality of the model that it was designed on.
    #[serde(default)]
    pub quality: Quality,
    /// The sources of the file.
    pub provenance: Provenance,
}

/// The kind of a manoeuvre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ManoeuvreKind {
    /// Tones whose amplitudes and phases are optimised, for a steering robot or drive-by-wire.
    Multisine,
    /// A slalom whose rhythm rises.
    Sweep,
    /// Slaloms of a steady rhythm each.
    Slalom,
    /// Lane changes there and back, by steps of the angle.
    Steps,
    /// Slaloms of a steady rhythm each whose amplitude grows.
    GrowingSlalom,
    /// An angle that rises slowly, and returns.
    RisingAngle,
}

crate::words!(ManoeuvreKind {
    Multisine = "multisine",
    Sweep = "sweep",
    Slalom = "slalom",
    Steps = "steps",
    GrowingSlalom = "growing-slalom",
    RisingAngle = "rising-angle",
});

/// The quantity whose standard error a manoeuvre minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ManoeuvreGoal {
    /// Gain (relative) and phase (rad) of the response from the steering angle to the yaw rate in a band, the larger of both.
    #[default]
    Response,
    /// The understeer gradient at the road wheel, rad·s²/m.
    Understeer,
    /// The friction coefficients of front and rear axle, relative, the larger of both.
    TyreLimit,
}

crate::words!(ManoeuvreGoal {
    Response = "response",
    Understeer = "understeer",
    TyreLimit = "tyre-limit",
});

impl ManoeuvreGoal {
    /// Unit of its standard error; empty of a relative one.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Response | Self::TyreLimit => "",
            Self::Understeer => "rad.s2/m",
        }
    }

    // By reference, as serde calls it.
    fn is_response(&self) -> bool {
        *self == Self::Response
    }
}

/// What is to be known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManoeuvrePurpose {
    /// The quantity whose standard error is minimised; absent of the response.
    #[serde(default, skip_serializing_if = "ManoeuvreGoal::is_response")]
    pub goal: ManoeuvreGoal,
    /// Band of the response from the steering angle to the yaw rate, Hz; of other goals that of the steering.
    pub band_hz: [f64; 2],
    /// Two standard errors of the goal, in its unit, that are to be reached; absent where as little as possible is wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_error: Option<f64>,
}

/// Limits of a manoeuvre, in steering coordinates; absent where not limited.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManoeuvreLimits {
    /// Largest lateral acceleration, m/s².
    pub max_lateral_acceleration_mps2: f64,
    /// Largest steering angle, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_angle_rad: Option<f64>,
    /// Largest rate of the steering angle, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_rate_radps: Option<f64>,
    /// Largest lateral offset of the centre of gravity to either side, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_offset_m: Option<f64>,
}

/// A block of a manoeuvre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManoeuvreBlock {
    /// Its start, s.
    pub start_s: f64,
    /// Number of its signal, from 0.
    pub signal: usize,
    /// Whether it begins to the other side: the signal times −1.
    pub mirrored: bool,
}

/// A steering signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteeringSignal {
    /// Speed at which it is driven, m/s.
    pub speed_mps: f64,
    /// Frequency of a slalom, or that from which and to which a sweep or the tones go, Hz; absent of steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<[f64; 2]>,
    /// Time for which a step is held, s; absent of other kinds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold_s: Option<f64>,
    /// The largest values of the model, and those that the vehicle keeps with a probability of 97.5 % each by the
    /// uncertainty of the model.
    pub peaks: SignalPeaks,
    /// Steering angle, rad.
    pub steering_rad: Vec<f64>,
}

/// The largest absolute values under a signal: of the model, and the bound by its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalPeaks {
    /// Lateral acceleration, m/s².
    pub lateral_acceleration_mps2: [f64; 2],
    /// Lateral offset, m.
    pub offset_m: [f64; 2],
    /// Steering angle, rad.
    pub angle_rad: f64,
    /// Rate of the steering angle, rad/s.
    pub rate_radps: f64,
    /// Lateral offset after the signal, m.
    pub end_offset_m: f64,
}

/// The standard errors to expect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpectedErrors {
    /// Standard error of the goal, in its unit: of the response the largest of gain (relative) and phase (rad) in the band at all
    /// speeds.
    pub largest_error: f64,
    /// The same of the convex problem: no powers of the tones within the limits are better. Absent of other kinds than
    /// the multisine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<f64>,
    /// Gap of the solution of the convex problem, as a share of the variance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// Whether the wanted error is reached; true where none is stated.
    pub met: bool,
    /// Time of the same manoeuvre that would reach it, s; absent where none is stated or no time does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needed_time_s: Option<f64>,
    /// By speed and frequency; empty where the goal is the tyre limit.
    pub response: Vec<ExpectedResponse>,
    /// Of the parameters at the mean speed.
    pub parameters: Vec<Estimated>,
}

/// The standard errors of a response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpectedResponse {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Gain of the model, yaw rate over steering angle, 1/s.
    pub gain: f64,
    /// Relative standard error of the gain.
    pub gain_error: f64,
    /// Standard error of the phase, rad.
    pub phase_error_rad: f64,
}

/// The best manoeuvre of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Alternative {
    /// Its kind.
    pub kind: ManoeuvreKind,
    /// Standard error of the goal, in its unit.
    pub largest_error: f64,
}

impl Manoeuvre {
    /// Length, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.block_s * self.schedule.len() as f64
    }

    /// The blocks of the first half, which has all signals and estimates.
    pub fn estimation_blocks(&self) -> impl Iterator<Item = &ManoeuvreBlock> {
        self.schedule.iter().take(self.schedule.len() / 2)
    }

    /// Samples of a block: its signal, and straight driving up to the next.
    #[must_use]
    pub fn block_samples(&self) -> usize {
        (self.block_s / self.sample_time_s).round() as usize
    }

    /// The steering angle at a sample of a block, rad.
    #[must_use]
    pub fn steering_rad(&self, block: &ManoeuvreBlock, sample: usize) -> f64 {
        let signal = self.signals.get(block.signal);
        let angle = signal.and_then(|s| s.steering_rad.get(sample)).copied().unwrap_or(0.0);
        if block.mirrored { -angle } else { angle }
    }
}

impl Document for Manoeuvre {
    const SCHEMA: &'static str = "steerwright/excitation/1";

    fn check(&self, c: &mut Checker) {
        let [low, high] = self.purpose.band_hz;
        c.positive(low, "purpose.band_hz[0]");
        c.require(high > low && high.is_finite(), "purpose.band_hz[1]", || {
            format!("{high} must be greater than {low}")
        });
        c.positive(
            self.limits.max_lateral_acceleration_mps2,
            "limits.max_lateral_acceleration_mps2",
        );
        for (limit, key) in [
            (self.purpose.max_error, "purpose.max_error"),
            (self.limits.max_angle_rad, "limits.max_angle_rad"),
            (self.limits.max_rate_radps, "limits.max_rate_radps"),
            (self.limits.max_offset_m, "limits.max_offset_m"),
        ] {
            if let Some(limit) = limit {
                c.positive(limit, key);
            }
        }
        c.positive(self.noise_density, "noise_density");
        c.within(self.estimation_share, 0.1, 1.0, "estimation_share");
        check_fields!(c.positive(self, ""): steering_ratio sample_time_s block_s);
        for (i, block) in self.schedule.iter().enumerate() {
            let at = format!("schedule[{i}].");
            let expected = i as f64 * self.block_s;
            c.require(
                (block.start_s - expected).abs() <= 1e-6 * (1.0 + expected),
                &format!("{at}start_s"),
                || format!("{} s, expected {expected} s: blocks follow each other", block.start_s),
            );
            c.require(block.signal < self.signals.len(), &format!("{at}signal"), || {
                format!("{}, there are {} signals", block.signal, self.signals.len())
            });
        }
        for (i, signal) in self.signals.iter().enumerate() {
            let at = format!("signals[{i}].");
            c.positive(signal.speed_mps, &format!("{at}speed_mps"));
            let longest = self.block_samples();
            c.require(signal.steering_rad.len() <= longest, &format!("{at}steering_rad"), || {
                format!("{} samples, a block has {longest}", signal.steering_rad.len())
            });
            for (k, angle) in signal.steering_rad.iter().enumerate() {
                c.finite(*angle, &format!("{at}steering_rad[{k}]"));
            }
        }
        c.not_negative(self.expected.largest_error, "expected.largest_error");
        for (i, row) in self.expected.response.iter().enumerate() {
            let at = format!("expected.response[{i}].");
            check_fields!(c.positive(row, at): speed_mps frequency_hz);
            check_fields!(c.not_negative(row, at): gain gain_error phase_error_rad);
        }
        for (i, parameter) in self.expected.parameters.iter().enumerate() {
            let at = format!("expected.parameters[{i}].");
            c.finite(parameter.value, &format!("{at}value"));
            c.not_negative(parameter.standard_error, &format!("{at}standard_error"));
        }
        self.quality.check(c, "quality.");
    }
}

impl Described for Manoeuvre {
    fn facts(self) -> Facts {
        let speeds = |pick: fn(f64, f64) -> f64| {
            self.signals.iter().map(|signal| signal.speed_mps).reduce(pick).unwrap_or_default()
        };
        let (lowest, highest) = (speeds(f64::min), speeds(f64::max));
        let mut facts = vec![
            Fact::new("kind", self.kind.name(), ""),
            Fact::new("goal", self.purpose.goal.name(), ""),
            Fact::new("blocks", self.schedule.len(), ""),
            Fact::new("time", self.time_s(), "s"),
            Fact::new("lowest_speed", lowest, "m/s"),
            Fact::new("highest_speed", highest, "m/s"),
            Fact::new(
                "largest_lateral_acceleration",
                self.limits.max_lateral_acceleration_mps2,
                "m/s2",
            ),
            Fact::new(
                "largest_standard_error",
                self.expected.largest_error,
                self.purpose.goal.unit(),
            ),
            Fact::new("requirements_met", self.expected.met, ""),
        ];
        facts.extend(quality_facts(self.quality));
        Facts { name: self.name, provenance: Some(self.provenance), evidence: facts }
    }
}
