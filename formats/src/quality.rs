//! The quality of a model: whether a controller may be designed on it, and the reasons with their
//! numbers.
//!
//! Quality is part of `plant.json` and `bicycle.json`, and travels with everything that is made from
//! them: `pid.json`, the provenance and documentation of an FMU, and each page of a report.

use crate::document::Checker;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The grade of a model or of one reason; later ones are worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Grade {
    /// A controller may be designed on the model.
    Pass,
    /// A controller may be designed on the model; the reasons limit its expected performance.
    Warn,
    /// No controller should be designed on the model.
    Fail,
}

impl Grade {
    /// The word in files and messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Warn => "warn",
            Self::Fail => "fail",
        }
    }
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The subject of a reason; its name in files is stable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReasonCode {
    /// The model was not validated on recorded data, such as one made from a data sheet.
    NotValidated,
    /// The steering hardly moves the vehicle.
    WeakSteering,
    /// Steering and yaw rate are coherent up to a low frequency only.
    NarrowBand,
    /// Noise is a large part of the yaw rate.
    NoisyYawRate,
    /// The simulation reproduces too little of the validation data.
    LowValidationFit,
    /// A channel is sampled too slowly for the bandwidth of the vehicle.
    SlowLog,
    /// The model has no continuous counterpart (eq 9–10 have no real solution).
    NoContinuousModel,
    /// The model differs from the measured frequency response by more than chance.
    ModelError,
    /// The gain from steering to yaw rate is too uncertain, at rest or at a frequency that a controller needs.
    UncertainGain,
    /// The effect of the accelerator varies at one speed, as with gears, which the log does not have, or may do so.
    UnknownGear,
    /// The phase from steering to yaw rate is too uncertain at a frequency that a controller needs.
    UncertainPhase,
    /// The vehicle yaws against the steering at low frequency.
    WrongSign,
    /// The low-frequency gain from steering to yaw rate is that of no road vehicle.
    ImplausibleGain,
    /// The wheelbase, or the speed that belongs to it, is that of no road vehicle or of another class.
    ImplausibleVehicle,
    /// A zero in the right half plane is slower than the bandwidth.
    NonMinimumPhase,
    /// The validation data are too short for a standard error of the fit.
    ShortValidation,
    /// Little of the validation data can be reproduced by any model: noise is as large as the signal.
    UninformativeValidation,
    /// A channel has samples that no vehicle produces: single spikes or dropouts.
    Spikes,
    /// The yaw rate stays at one value while the vehicle is steered.
    FrozenYawRate,
    /// The steering has play (lash).
    SteeringPlay,
    /// Straight driving shows a yaw rate or requires a steering angle.
    Offset,
    /// The resolution of a channel is coarse against its signal and its noise.
    CoarseResolution,
    /// The yaw rate comes before the steering that causes it.
    EarlyYawRate,
    /// The yaw rate follows the steering later than that of a vehicle.
    LateYawRate,
    /// The GNSS fixes are older or younger than stated.
    AgeOfFixes,
    /// The drive turns to one side alone: a banked road and the vehicle's parameters cannot be separated.
    OneSidedTurns,
    /// A parameter of a vehicle is at a bound, or more than three standard deviations off its prior.
    UnusualParameter,
    /// A vehicle with slightly less grip at the rear axle would spin on the drive.
    NearSpin,
    /// The model of a controller has the measured steering angle as its input, and the controller misses its requirements
    /// behind a usual actuator.
    NoActuator,
    /// A controller misses a requirement on the model that it was designed on.
    MissedRequirement,
    /// Vehicles within the uncertainty of the model miss a requirement of the controller.
    NotRobust,
    /// The model of a speed controller has no brake.
    NoBrake,
}

impl ReasonCode {
    /// The name in files, such as `low-validation-fit`.
    #[must_use]
    pub fn name(self) -> String {
        serde_json::to_value(self)
            .ok()
            .and_then(|v| v.as_str().map(str::to_owned))
            .unwrap_or_default()
    }
}

/// One reason for a grade, with the number that was compared and its limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reason {
    /// The subject.
    pub code: ReasonCode,
    /// The grade that the reason causes: `warn` or `fail`.
    pub grade: Grade,
    /// The message, such as `the fit on validation data is 24 %, below 60 %`.
    pub message: String,
    /// The number that was compared, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The limit that it violates, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Unit of value and limit; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
}

impl Reason {
    /// A reason without numbers.
    #[must_use]
    pub fn new(code: ReasonCode, grade: Grade, message: impl Into<String>) -> Self {
        Self { code, grade, message: message.into(), value: None, limit: None, unit: String::new() }
    }

    /// The same with the number that was compared and its limit.
    #[must_use]
    pub fn compared(self, value: f64, limit: f64, unit: &str) -> Self {
        // A file holds finite numbers only; the message still names what is not.
        let finite = |x: f64| if x.is_finite() { Some(x) } else { None };
        Self { value: finite(value), limit: finite(limit), unit: unit.into(), ..self }
    }
}

/// The quality of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// The worst grade of the reasons; `pass` without any.
    pub grade: Grade,
    /// One or two sentences.
    pub summary: String,
    /// The reasons for the grade, the worst first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<Reason>,
    /// Limits of the model and of the log that cause no reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// What to do next, such as the manoeuvre to drive.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub advice: Vec<String>,
}

impl Quality {
    /// The quality that follows from its reasons.
    #[must_use]
    pub fn new(summary: impl Into<String>, mut reasons: Vec<Reason>, advice: Vec<String>) -> Self {
        reasons.sort_by_key(|reason| std::cmp::Reverse(reason.grade));
        let grade = reasons.first().map_or(Grade::Pass, |worst| worst.grade);
        Self { grade, summary: summary.into(), reasons, remarks: Vec::new(), advice }
    }

    /// The same with remarks.
    #[must_use]
    pub fn with_remarks(self, remarks: Vec<String>) -> Self {
        Self { remarks, ..self }
    }

    /// The same with a further reason and advice.
    #[must_use]
    pub fn with_reason(self, reason: Reason, advice: String) -> Self {
        let summary = format!("{} Also, {}.", self.summary, reason.message);
        let (mut reasons, mut all_advice) = (self.reasons, self.advice);
        reasons.push(reason);
        all_advice.push(advice);
        Self::new(summary, reasons, all_advice).with_remarks(self.remarks)
    }

    /// Of a model that no recorded data have validated.
    #[must_use]
    pub fn not_validated() -> Self {
        let message = "the model was not validated on recorded data";
        let reason = Reason::new(ReasonCode::NotValidated, Grade::Warn, message);
        Self::new("The model was not validated on recorded data.", vec![reason], Vec::new())
    }

    /// Whether a controller may be designed on the model.
    #[must_use]
    pub fn allows_design(&self) -> bool {
        self.grade < Grade::Fail
    }

    /// Whether a reason of this code is among the reasons.
    #[must_use]
    pub fn has(&self, code: ReasonCode) -> bool {
        self.reasons.iter().any(|reason| reason.code == code)
    }

    /// The reasons that the summary does not state already.
    pub fn unstated_reasons(&self) -> impl Iterator<Item = &Reason> {
        self.reasons.iter().filter(|reason| !self.summary.contains(&reason.message))
    }

    /// The codes of all reasons, separated by commas.
    #[must_use]
    pub fn codes(&self) -> String {
        let codes: Vec<String> = self.reasons.iter().map(|reason| reason.code.name()).collect();
        codes.join(", ")
    }

    /// Reports a grade that does not follow from the reasons; `at` is the prefix of each key.
    pub(crate) fn check(&self, c: &mut Checker, at: &str) {
        let worst = self.reasons.iter().map(|reason| reason.grade).max();
        c.require(self.grade == worst.unwrap_or(Grade::Pass), &format!("{at}grade"), || {
            format!(
                "the grade is {}, but the worst grade of the reasons is {}",
                self.grade,
                worst.unwrap_or(Grade::Pass)
            )
        });
        for (i, reason) in self.reasons.iter().enumerate() {
            for (number, key) in [(reason.value, "value"), (reason.limit, "limit")] {
                c.finite(number.unwrap_or(0.0), &format!("{at}reasons[{i}].{key}"));
            }
        }
    }
}

/// Files that state no quality hold models that no recorded data have validated.
impl Default for Quality {
    fn default() -> Self {
        Self::not_validated()
    }
}
