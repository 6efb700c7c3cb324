//! What became of a run, by name.
//!
//! The names of two variables mean something here, as they do where instances are wired by name:
//! `cross_track_error` (m), whose largest value tells whether the path was left, and `heading_error`
//! (rad), beyond 90° of which a vehicle spins or drives away. A metric of either is a lower bound of
//! its largest value, unless it takes a target off or counts time.

use serde::Serialize;

use crate::metric::{Metric, Target};
use crate::metric_kind::Kind;
use crate::plan::Plan;
use crate::quantity::Linear;
use crate::results::Outcome;

/// A cross-track error beyond this is off the path, m, where the study states no other: half of a
/// lane of 3.5 m.
pub(crate) const OFF_PATH_BEYOND_M: f64 = 1.75;
/// A heading error beyond this is that of a vehicle that spins, rad.
const SPINS_BEYOND_RAD: f64 = std::f64::consts::FRAC_PI_2;

/// What became of a run, from the best to the worst.
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
    pub(crate) fn of(
        name: &str,
        kind: Kind,
        target: Target,
        convert: Linear,
        allowed: Option<f64>,
        max_cross_track_error_m: f64,
    ) -> Option<Self> {
        if !bounds_the_largest(kind) || !matches!(target, Target::Nothing) || convert.offset != 0.0
        {
            return None;
        }
        let scale = convert.factor.abs();
        let last = name.rsplit('.').next().unwrap_or(name);
        match last {
            "cross_track_error" => {
                let allowed = allowed.filter(|_| kind == Kind::MaxAbs).unwrap_or(0.0);
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

/// Whether a metric's absolute value is at most its variable's largest one.
fn bounds_the_largest(kind: Kind) -> bool {
    match kind {
        Kind::Rms | Kind::Mean | Kind::Minimum | Kind::Maximum | Kind::MaxAbs | Kind::Final => true,
        Kind::Time | Kind::FirstTime | Kind::SettlingTime | Kind::Overshoot => false,
    }
}

impl Plan {
    /// The worst that a run's metrics show.
    pub(crate) fn class(&self, outcome: &Outcome) -> Class {
        let Outcome::Done(values) = outcome else { return Class::FailedToRun };
        let required = if self.passes(outcome) { Class::Met } else { Class::SpecificationMissed };
        let shown = self.metrics.iter().zip(values).filter_map(|(m, v)| class_of(m, *v));
        shown.fold(required, Class::max)
    }
}

fn class_of(metric: &Metric, value: f64) -> Option<Class> {
    if bounds_the_largest(metric.kind) && value.is_infinite() {
        return Some(Class::Unstable);
    }
    metric.shows.filter(|shows| value.abs() > shows.beyond).map(|shows| shows.class)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shows(name: &str, kind: Kind, factor: f64, allowed: Option<f64>) -> Option<Shows> {
        let convert = Linear { factor, offset: 0.0 };
        Shows::of(name, kind, Target::Nothing, convert, allowed, OFF_PATH_BEYOND_M)
    }

    #[test]
    fn a_path_is_left_beyond_half_a_lane_or_what_the_study_allows() {
        let of = |kind, factor, allowed| {
            shows("ReferencePath.cross_track_error", kind, factor, allowed).unwrap().beyond
        };
        assert_eq!(of(Kind::Rms, 1.0, Some(9.0)), 1.75);
        assert_eq!(of(Kind::MaxAbs, 100.0, None), 175.0);
        assert_eq!(of(Kind::MaxAbs, 1.0, Some(3.0)), 3.0);
        assert_eq!(shows("cross_track_error", Kind::SettlingTime, 1.0, None), None);
        assert_eq!(shows("LateralPid.yaw", Kind::MaxAbs, 1.0, None), None);
        let spins = shows("ReferencePath.heading_error", Kind::MaxAbs, 180.0 / 3.0, None).unwrap();
        assert_eq!(spins.class, Class::Unstable);
    }
}
