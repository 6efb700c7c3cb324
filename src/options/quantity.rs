//! Numbers with a unit, as people write them on a command line: `22deg`, `1s`, `0.5%`, `54km/h`.

use serde::de::{Deserialize, Deserializer, Error};
use std::f64::consts::PI;
use std::str::FromStr;

/// Sizes that are taken, whatever the unit; times since 1970 are among them.
const SENSIBLE: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Functions that read a number with one of some units, each with its factor to SI.
macro_rules! readers {
    ($($(#[$doc:meta])* $name:ident: $($unit:literal = $factor:expr),+;)*) => {$(
        $(#[$doc])*
        pub(crate) fn $name(text: &str) -> Result<f64, String> {
            with_unit(text, &[$(($unit, $factor)),+])
        }
    )*};
}

readers! {
    /// An angle in rad.
    angle: "deg" = PI / 180.0, "rad" = 1.0;
    /// An angular rate in rad/s.
    angle_rate: "deg/s" = PI / 180.0, "rad/s" = 1.0;
    /// A time in s.
    time: "ms" = 1e-3, "s" = 1.0;
    /// A length in m.
    length: "cm" = 1e-2, "m" = 1.0;
    /// A speed in m/s.
    speed: "m/s" = 1.0, "km/h" = 1.0 / 3.6;
    /// An acceleration in m/s².
    acceleration: "m/s2" = 1.0, "g" = 9.80665;
    /// A jerk in m/s³.
    jerk: "m/s3" = 1.0;
    /// A rate in 1/s.
    rate: "/s" = 1.0;
    /// A frequency in Hz.
    frequency: "Hz" = 1.0;
    /// An understeer gradient in rad·s²/m.
    gradient: "deg/g" = PI / 180.0 / 9.80665, "rad.s2/m" = 1.0;
    /// A share in percent.
    percent: "%" = 1.0;
    /// A gain in dB.
    decibel: "dB" = 1.0;
}

/// A number without a unit.
fn plain(text: &str) -> Result<f64, String> {
    let value: f64 =
        text.trim().parse().map_err(|_| format!("`{text}` is not a number without a unit"))?;
    let sensible = value == 0.0 || SENSIBLE.contains(&value.abs());
    sensible.then_some(value).ok_or_else(|| format!("`{text}` is beyond any sensible value"))
}

fn with_unit(text: &str, units: &[(&str, f64)]) -> Result<f64, String> {
    let expected = || units.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" or ");
    let text = text.trim();
    let (number, factor) = units
        .iter()
        .find_map(|(unit, factor)| text.strip_suffix(unit).map(|number| (number.trim(), *factor)))
        .filter(|(number, _)| !number.ends_with(char::is_alphabetic))
        .ok_or_else(|| format!("a number with its unit ({}) is expected", expected()))?;
    let value: f64 =
        number.parse().map_err(|_| format!("`{number}` is not a number (unit: {})", expected()))?;
    if !value.is_finite() {
        return Err(format!("`{number}` is not a finite number"));
    }
    // Sums and quotients of what passes stay far from overflow, and texts of them short.
    if value != 0.0 && !SENSIBLE.contains(&value.abs()) {
        return Err(format!("`{number}` is beyond any sensible value"));
    }
    Ok(value * factor)
}

/// A value in a file: text with a unit, or a plain number.
#[derive(serde::Deserialize)]
#[serde(untagged, expecting = "a text with a unit is expected")]
enum WrittenQuantity {
    Text(String),
    Number(f64),
}

impl WrittenQuantity {
    fn text(self) -> String {
        match self {
            Self::Text(text) => text,
            Self::Number(number) => number.to_string(),
        }
    }
}

/// Types of quantities, which are read from a command line and from a file alike.
macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident = $parse:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub(crate) struct $name(f64);

        impl FromStr for $name {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                let parse: fn(&str) -> Result<f64, String> = $parse;
                parse(text).map(Self)
            }
        }

        impl From<$name> for f64 {
            fn from(value: $name) -> Self {
                value.0
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                WrittenQuantity::deserialize(deserializer)?.text().parse().map_err(Error::custom)
            }
        }
    )*};
}

quantities! {
    /// An angle, rad.
    Angle = angle;
    /// A phase, degrees.
    Phase = |text| angle(text).map(f64::to_degrees);
    /// An angular rate, rad/s.
    AngleRate = angle_rate;
    /// A time, s.
    Time = time;
    /// An acceleration, m/s².
    Acceleration = acceleration;
    /// A jerk, m/s³.
    Jerk = jerk;
    /// A share, percent.
    Percent = percent;
    /// A gain, dB.
    Decibel = decibel;
    /// A number without a unit.
    Number = plain;
}

/// A range of speeds, m/s: `5..30`, `5m/s..30m/s` or `18..108km/h`. A speed without a unit has that of the
/// other, or is in m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpeedRange(pub(crate) [f64; 2]);

impl FromStr for SpeedRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (low, high) = text
            .split_once("..")
            .ok_or_else(|| format!("`{text}` is no range of speeds such as 5..30 (m/s)"))?;
        let unit = if high.trim().ends_with("km/h") { "km/h" } else { "m/s" };
        let number = |text: &str| match plain(text) {
            Ok(_) => speed(&format!("{text}{unit}")),
            Err(_) => speed(text),
        };
        Ok(Self([number(low)?, number(high)?]))
    }
}

/// A band of frequencies, Hz: `0.2..2`, `0.2..2Hz` or `0.2Hz..2Hz`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrequencyRange(pub(crate) [f64; 2]);

impl FromStr for FrequencyRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (low, high) = text
            .split_once("..")
            .ok_or_else(|| format!("`{text}` is no band of frequencies such as 0.2..2Hz"))?;
        let number = |text: &str| match plain(text) {
            Ok(value) => Ok(value),
            Err(_) => frequency(text),
        };
        Ok(Self([number(low)?, number(high)?]))
    }
}

/// A quantity, or `none`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OrNone<T>(pub(crate) Option<T>);

impl<T: FromStr<Err = String>> FromStr for OrNone<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(Self(if text.trim() == "none" { None } else { Some(text.parse()?) }))
    }
}

impl<'de, T: FromStr<Err = String>> Deserialize<'de> for OrNone<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        WrittenQuantity::deserialize(deserializer)?.text().parse().map_err(Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::{FrequencyRange, SpeedRange, angle, angle_rate, percent, rate, speed, time};

    #[test]
    fn ranges_of_speeds() {
        for text in ["5..30", "5m/s..30m/s", "5 .. 30 m/s", "18km/h..108km/h", "18..108km/h"] {
            assert_eq!(text.parse(), Ok(SpeedRange([5.0, 30.0])), "{text}");
        }
        for bad in ["5", "5-30", "..30", "5..", "5..30s", "a..b"] {
            assert!(bad.parse::<SpeedRange>().is_err(), "{bad}");
        }
    }

    #[test]
    fn bands_of_frequencies() {
        for text in ["0.2..2", "0.2..2Hz", "0.2Hz .. 2 Hz"] {
            assert_eq!(text.parse(), Ok(FrequencyRange([0.2, 2.0])), "{text}");
        }
        for bad in ["2Hz", "0.2-2Hz", "..2Hz", "0.2..2m/s"] {
            assert!(bad.parse::<FrequencyRange>().is_err(), "{bad}");
        }
    }

    #[test]
    fn units_are_applied_and_required() {
        assert!((angle("22deg").unwrap() - 0.383_972_435_438_752_5).abs() < 1e-15);
        assert_eq!(angle("0.5 rad").unwrap(), 0.5);
        assert_eq!(rate("0.05/s").unwrap(), 0.05);
        assert_eq!(time("250ms").unwrap(), 0.25);
        assert_eq!(time("1s").unwrap(), 1.0);
        assert_eq!(percent("1%").unwrap(), 1.0);
        assert_eq!(speed("54km/h").unwrap(), 15.0);
        assert!((angle_rate("180deg/s").unwrap() - std::f64::consts::PI).abs() < 1e-15);
        for bad in ["22", "deg", "22grad", "1e999deg", "NaNrad", "22 m", "1e300deg", "1e-300deg"] {
            assert!(angle(bad).is_err(), "{bad}");
        }
        assert!(time("5min").is_err());
        assert!(time("ms").is_err());
    }
}
