//! The kinds of metrics, and which keys each takes.

use serde::Deserialize;

use crate::study::Metric;

/// What a metric makes of its variable over its window.
#[derive(Debug, Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    /// Root of the mean square.
    Rms,
    /// Mean over the communication points.
    Mean,
    Minimum,
    Maximum,
    /// Largest absolute value.
    MaxAbs,
    /// Value at the window's last communication point.
    Final,
    /// How long, in s, a bound is passed.
    Time,
    /// When, in s, a bound is first passed; `inf` if never.
    FirstTime,
    /// From the window's start until the band about the target is not left any more, in s; `inf`
    /// if it is outside at the end.
    SettlingTime,
    /// How far the target is passed, in percent of the distance at the window's start.
    Overshoot,
}

impl Kind {
    /// As it is written.
    fn name(self) -> &'static str {
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

    /// Refuses a metric whose keys do not fit its kind or contradict each other.
    pub(crate) fn check(self, metric: &Metric) -> Result<(), String> {
        let name = self.name();
        let bounds = usize::from(metric.above.is_some()) + usize::from(metric.below.is_some());
        match self {
            Self::Time | Self::FirstTime if bounds != 1 => {
                return Err(format!("{name} needs either above or below"));
            }
            Self::Time | Self::FirstTime => {}
            _ if bounds > 0 => {
                return Err(format!("{name} has no above or below; at_most and at_least judge it"));
            }
            _ => {}
        }
        let bands = usize::from(metric.band.is_some()) + usize::from(metric.band_percent.is_some());
        if self == Self::SettlingTime {
            if bands != 1 || metric.target.is_none() {
                return Err(format!("{name} needs a target, and either band or band_percent"));
            }
        } else if bands > 0 {
            return Err(format!("{name} has no band"));
        }
        if self == Self::Overshoot && (metric.target.is_none() || metric.absolute) {
            return Err(format!("{name} needs a target, and has a sign"));
        }
        for (key, value) in [("band", metric.band), ("band_percent", metric.band_percent)] {
            if let Some(value) = value
                && !(value > 0.0 && value.is_finite())
            {
                return Err(format!("{key} {value} is not above 0"));
            }
        }
        for (key, value) in [
            ("above", metric.above),
            ("below", metric.below),
            ("at_most", metric.at_most),
            ("at_least", metric.at_least),
        ] {
            if let Some(value) = value
                && !value.is_finite()
            {
                return Err(format!("{key} is {value}"));
            }
        }
        if let (Some(least), Some(most)) = (metric.at_least, metric.at_most)
            && least > most
        {
            return Err(format!("no value is at least {least} and at most {most}"));
        }
        Ok(())
    }
}
