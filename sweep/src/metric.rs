//! Metrics of a run and what became of it: its class.
//!
//! The names of two variables have a meaning here: `cross_track_error` (m), whose largest value
//! decides whether the path was left, and `heading_error` (rad), beyond 90° of which a vehicle spins
//! or drives away. A metric of either is a lower bound of its largest value, unless it has a target
//! or counts time.

use crate::draws::Number;
use serde::{Deserialize, Serialize};
use steerwright_host::Linear;

/// A cross-track error beyond this is off the path, m, where the study states no other: half of a
/// lane of 3.5 m.
pub(crate) const OFF_PATH_BEYOND_M: f64 = 1.75;
/// A heading error beyond this is that of a vehicle that spins, rad.
const SPINS_BEYOND_RAD: f64 = std::f64::consts::FRAC_PI_2;

/// The functional of a variable over the window of a metric.
#[derive(Debug, Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum MetricKind {
    Rms,
    /// Mean over the communication points.
    Mean,
    Minimum,
    Maximum,
    /// Largest absolute value.
    MaxAbs,
    /// Value at the window's last communication point.
    Final,
    /// Time beyond a bound, s.
    Time,
    /// When, in s, a bound is first passed; `inf` if never.
    FirstTime,
    /// From the window's start until the band about the target is not left any more, in s; `inf`
    /// if it is outside at the end.
    SettlingTime,
    /// How far the target is passed, in percent of the distance at the window's start.
    Overshoot,
}

impl MetricKind {
    /// Whether a metric's absolute value is at most the largest one of its variable.
    fn is_bounded_by_largest(self) -> bool {
        !matches!(self, Self::Time | Self::FirstTime | Self::SettlingTime | Self::Overshoot)
    }

    /// As it is written.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rms => "rms",
            Self::Mean => "mean",
            Self::Minimum => "minimum",
            Self::Maximum => "maximum",
            Self::MaxAbs => "max-abs",
            Self::Final => "final",
            Self::Time => "time",
            Self::FirstTime => "first-time",
            Self::SettlingTime => "settling-time",
            Self::Overshoot => "overshoot",
        }
    }

    /// The unit of the result, where that is not the variable's own.
    pub(crate) fn unit(self) -> Option<&'static str> {
        match self {
            Self::Time | Self::FirstTime | Self::SettlingTime => Some("s"),
            Self::Overshoot => Some("%"),
            _ => None,
        }
    }
}

/// A metric with its names resolved.
#[derive(Debug, Clone)]
pub(crate) struct Metric {
    pub(crate) name: String,
    pub(crate) kind: MetricKind,
    pub(crate) unit: Option<String>,
    /// The variable's place.
    pub(crate) slot: usize,
    /// From the variable's unit to the metric's.
    pub(crate) convert: Linear,
    pub(crate) target: Target,
    pub(crate) absolute: bool,
    /// The window, s.
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) above: Option<f64>,
    pub(crate) below: Option<f64>,
    pub(crate) band: f64,
    /// Whether the band is in percent of the distance at the window's start.
    pub(crate) band_is_relative: bool,
    pub(crate) at_most: Option<f64>,
    pub(crate) at_least: Option<f64>,
    pub(crate) shows: Option<Shows>,
}

/// What a metric shows beyond its number: the class of a run in which its absolute value is beyond
/// the bound, in the metric's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shows {
    class: Class,
    beyond: f64,
}

impl Shows {
    /// Of a metric of the variable `name`, which `convert` takes to the metric's unit. What the
    /// study itself allows is not off the path.
    pub(crate) fn new(
        name: &str,
        kind: MetricKind,
        target: Target,
        convert: Linear,
        allowed: Option<f64>,
        max_cross_track_error_m: f64,
    ) -> Option<Self> {
        if !kind.is_bounded_by_largest()
            || !matches!(target, Target::Nothing)
            || convert.offset != 0.0
        {
            return None;
        }
        let scale = convert.factor.abs();
        let last = name.rsplit('.').next().unwrap_or(name);
        match last {
            "cross_track_error" => {
                let allowed = allowed.filter(|_| kind == MetricKind::MaxAbs).unwrap_or(0.0);
                Some(Self {
                    class: Class::OffThePath,
                    beyond: allowed.max(scale * max_cross_track_error_m),
                })
            }
            "heading_error" => {
                Some(Self { class: Class::Unstable, beyond: scale * SPINS_BEYOND_RAD })
            }
            _ => None,
        }
    }
}

/// The reference that is subtracted from a metric's variable.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Target {
    Nothing,
    Number(Number),
    /// A variable's place, and from its unit to the metric's.
    Variable(usize, Linear),
}

impl Metric {
    pub(crate) fn is_required(&self) -> bool {
        self.at_most.is_some() || self.at_least.is_some()
    }

    /// The class that a result shows.
    pub(crate) fn class_of(&self, value: f64) -> Option<Class> {
        if self.kind.is_bounded_by_largest() && value.is_infinite() {
            return Some(Class::Unstable);
        }
        self.shows.filter(|shows| value.abs() > shows.beyond).map(|shows| shows.class)
    }

    /// Whether a result is as required; NaN is not.
    pub(crate) fn is_met(&self, value: f64) -> bool {
        !value.is_nan()
            && self.at_most.is_none_or(|most| value <= most)
            && self.at_least.is_none_or(|least| value >= least)
    }
}

/// The result of a run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outcome {
    Done(Vec<f64>),
    /// The error, in one line.
    Failed(String),
}

/// The class of a run, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// Everything required was met; a study may require nothing.
    Met,
    /// A requirement was missed, on the path.
    SpecificationMissed,
    /// The cross-track error went beyond the bound.
    OffThePath,
    /// The vehicle spun or a signal left all bounds.
    Unstable,
    /// An FMU refused a call, or the run took too long.
    FailedToRun,
}

impl Class {
    /// All, from the best to the worst.
    pub const ALL: [Self; 5] =
        [Self::Met, Self::SpecificationMissed, Self::OffThePath, Self::Unstable, Self::FailedToRun];

    /// For people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::SpecificationMissed => "specification missed",
            Self::OffThePath => "off the path",
            Self::Unstable => "unstable",
            Self::FailedToRun => "failed to run",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shows(name: &str, kind: MetricKind, factor: f64, allowed: Option<f64>) -> Option<Shows> {
        let convert = Linear { factor, offset: 0.0 };
        Shows::new(name, kind, Target::Nothing, convert, allowed, OFF_PATH_BEYOND_M)
    }

    #[test]
    fn a_path_is_left_beyond_half_a_lane_or_the_limit_of_the_study() {
        let of = |kind, factor, allowed| {
            shows("ReferencePath.cross_track_error", kind, factor, allowed).unwrap().beyond
        };
        assert_eq!(of(MetricKind::Rms, 1.0, Some(9.0)), 1.75);
        assert_eq!(of(MetricKind::MaxAbs, 100.0, None), 175.0);
        assert_eq!(of(MetricKind::MaxAbs, 1.0, Some(3.0)), 3.0);
        assert_eq!(shows("cross_track_error", MetricKind::SettlingTime, 1.0, None), None);
        assert_eq!(shows("LateralPid.yaw", MetricKind::MaxAbs, 1.0, None), None);
        let spins =
            shows("ReferencePath.heading_error", MetricKind::MaxAbs, 180.0 / 3.0, None).unwrap();
        assert_eq!(spins.class, Class::Unstable);
    }
}
