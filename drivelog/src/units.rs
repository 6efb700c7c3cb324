//! Units of columns: from the suffix of a name, from brackets in the header, or stated.
//!
//! A unit is never guessed: a column without one is an error whose hint is how to state it.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    Time,
    Angle,
    AngularRate,
    Speed,
    Length,
    Acceleration,
    Torque,
    Dimensionless,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    /// Its name in messages and files.
    pub(crate) name: &'static str,
    pub(crate) quantity: Quantity,
    pub(crate) to_si: f64,
}

const DEG: f64 = std::f64::consts::PI / 180.0;

/// Times as ISO 8601 writes them, which are read as seconds.
pub(crate) const STAMP: Unit = unit("ISO 8601", Quantity::Time, 1.0);

/// The unit of numbers.
pub(crate) const ONE: Unit = unit("1", Quantity::Dimensionless, 1.0);

/// Spellings, longest first where one ends in another (`deg_s` before `s`).
const SPELLINGS: &[(&[&str], Unit)] = &[
    (
        &["degps", "deg_s", "deg/s", "deg/sec", "dps", "°/s", "°/sec"],
        unit("deg/s", Quantity::AngularRate, DEG),
    ),
    (&["radps", "rad_s", "rad/s", "rad/sec"], unit("rad/s", Quantity::AngularRate, 1.0)),
    (&["mrad/s"], unit("mrad/s", Quantity::AngularRate, 1e-3)),
    (&["mps2", "m_s2", "m/s2", "m/s^2", "m/s²"], unit("m/s2", Quantity::Acceleration, 1.0)),
    (&["mps", "m_s", "m/s", "m/sec"], unit("m/s", Quantity::Speed, 1.0)),
    (&["kmh", "kph", "kmph", "km_h", "km/h"], unit("km/h", Quantity::Speed, 1.0 / 3.6)),
    (&["mph"], unit("mph", Quantity::Speed, 0.447_04)),
    (&["knots"], unit("knots", Quantity::Speed, 1852.0 / 3600.0)),
    (&["deg", "degree", "degrees", "°"], unit("deg", Quantity::Angle, DEG)),
    (&["rad", "radian", "radians"], unit("rad", Quantity::Angle, 1.0)),
    (&["mrad"], unit("mrad", Quantity::Angle, 1e-3)),
    (&["ms", "msec"], unit("ms", Quantity::Time, 1e-3)),
    (&["us", "µs"], unit("us", Quantity::Time, 1e-6)),
    (&["ns"], unit("ns", Quantity::Time, 1e-9)),
    (&["s", "sec", "seconds"], unit("s", Quantity::Time, 1.0)),
    (&["m"], unit("m", Quantity::Length, 1.0)),
    (&["g"], unit("g", Quantity::Acceleration, 9.806_65)),
    (&["nm", "n.m", "n*m", "n·m"], unit("Nm", Quantity::Torque, 1.0)),
    (&["ft", "feet"], unit("ft", Quantity::Length, 0.3048)),
    (&["%", "pct", "percent", "prozent"], unit("%", Quantity::Dimensionless, 0.01)),
    (&["1"], ONE),
];

/// Spellings that are read where they stand alone, not as the end of a name, and what they equal.
const EQUAL: &[(&[&str], &str)] = &[
    (&["degree/s", "degrees/s", "degree/sec", "degrees/sec", "grad/s", "grad/sec"], "deg/s"),
    (&["grad", "graden"], "deg"),
    (&["graden/s", "degs/s", "degs/sec"], "deg/s"),
    (&["radian/s", "radians/s"], "rad/s"),
    (&["kts", "knot"], "knots"),
    (&["mi/h", "mile/h", "miles/h"], "mph"),
    (&["kilometer/h", "kilometers/h", "kilometre/h", "kilometres/h"], "km/h"),
    (&["meter/s", "meters/s", "metre/s", "metres/s"], "m/s"),
    (&["meter/s2", "meters/s2", "metre/s2", "metres/s2"], "m/s2"),
    (&["unix time", "сек", "с", "秒"], "s"),
    (&["мс", "毫秒"], "ms"),
    // Russian and Chinese.
    (&["град", "度"], "deg"),
    (&["град/с", "град/сек", "度/秒"], "deg/s"),
    (&["рад", "弧度"], "rad"),
    (&["рад/с", "弧度/秒"], "rad/s"),
    (&["м/с", "米/秒"], "m/s"),
    (&["км/ч", "公里/小时", "千米/小时"], "km/h"),
];

/// As sailors and pilots write knots; kN is a force.
const KNOTS: [&str; 2] = ["kn", "kt"];

/// The unit of an angular rate as CarMaker and German tools write it.
const PER_SECOND: Unit = unit("1/s", Quantity::AngularRate, 1.0);

/// Units that stand alone, since their letters end names of other things.
const ALONE: [Unit; 6] = [
    unit("ft/s", Quantity::Speed, 0.3048),
    unit("cm/s", Quantity::Speed, 0.01),
    unit("mm/s", Quantity::Speed, 1e-3),
    unit("rpm", Quantity::AngularRate, 6.0 * DEG),
    unit("gon", Quantity::Angle, 0.9 * DEG),
    unit("urad", Quantity::Angle, 1e-6),
];

/// Long units of time, which stand alone, not as the end of a name.
const LONG_TIMES: [(&[&str], Unit); 3] = [
    (&["min", "minute", "minutes"], unit("min", Quantity::Time, 60.0)),
    (&["h", "hr", "hour", "hours"], unit("h", Quantity::Time, 3600.0)),
    (&["d", "day", "days"], unit("d", Quantity::Time, 86_400.0)),
];

/// Minutes of arc as VBOX writes places, with longitudes positive in the west.
const MINUTES: [Unit; 2] = [
    unit("arcmin", Quantity::Angle, DEG / 60.0),
    unit("arcmin west", Quantity::Angle, -DEG / 60.0),
];

const fn unit(name: &'static str, quantity: Quantity, to_si: f64) -> Unit {
    Unit { name, quantity, to_si }
}

pub(crate) fn parse_unit(text: &str) -> Option<Unit> {
    let text = plain_spelling(text);
    if text == PER_SECOND.name {
        return Some(PER_SECOND);
    }
    if let Some(unit) = MINUTES.into_iter().find(|unit| unit.name == text) {
        return Some(unit);
    }
    if let Some(unit) = ALONE.into_iter().find(|unit| unit.name.eq_ignore_ascii_case(&text)) {
        return Some(unit);
    }
    let text = if KNOTS.contains(&&*text) { "knots".into() } else { text };
    let is_in = |names: &[&str]| names.iter().any(|n| n.eq_ignore_ascii_case(&text));
    let text = EQUAL.iter().find(|(names, _)| is_in(names)).map_or(&*text, |(_, unit)| *unit);
    SPELLINGS
        .iter()
        .find(|(names, _)| names.iter().any(|n| n.eq_ignore_ascii_case(text)))
        .map(|(_, unit)| *unit)
}

/// A unit that stands in brackets, in a row of units or in the options: also those of long times, whose letters are names
/// elsewhere.
pub(crate) fn parse_stated_unit(text: &str) -> Option<Unit> {
    let long = || LONG_TIMES.into_iter().find(|(names, _)| names.contains(&text.trim()));
    parse_unit(text).or_else(|| long().map(|(_, unit)| unit))
}

/// A unit with one degree sign, one micro sign and a slash: `º`, `˚`, and those of UTF-8 (`Â°`), MS-DOS (`ø`) and the
/// Macintosh (`¡`) that were read as Latin 1; the Greek letter; `s^-1`, `s⁻¹` and `s-1` after a blank, a point or `°`; `per`
/// and the units of time in words.
fn plain_spelling(text: &str) -> String {
    let mut text = text.trim().to_owned();
    for (from, to) in [
        ("Â°", "°"),
        ("Âº", "°"),
        ("º", "°"),
        ("˚", "°"),
        ("ø", "°"),
        ("¡", "°"),
        ("&deg;", "°"),
        ("Âµ", "µ"),
        ("Î¼", "µ"),
        ("μ", "µ"),
        ("⁻¹", "-1"),
        ("⁻²", "-2"),
        ("^-", "-"),
        (" / ", "/"),
        (" per ", "/"),
        ("µrad", "urad"),
    ] {
        text = text.replace(from, to);
    }
    if let Some((unit, time)) = text.split_once('/')
        && let Some((_, short)) = PER_TIME.iter().find(|(word, _)| word.eq_ignore_ascii_case(time))
    {
        text = format!("{unit}/{short}");
    }
    for (power, per) in [("s-1", "/s"), ("s-2", "/s2"), ("h-1", "/h")] {
        let Some(rest) = text.strip_suffix(power) else { continue };
        let unit = rest.strip_suffix([' ', '.', '*', '·']).map(str::trim_end);
        let unit = unit.or(if rest.ends_with('°') { Some(rest) } else { None });
        text = match unit {
            Some(unit) => format!("{unit}{per}"),
            None if rest.is_empty() => format!("1{per}"),
            None => continue,
        };
        break;
    }
    text
}

/// Times that a rate is per, in words and with a point of abbreviation.
const PER_TIME: [(&str, &str); 9] = [
    ("hr", "h"),
    ("hour", "h"),
    ("std", "h"),
    ("second", "s"),
    ("seconds", "s"),
    ("sekunde", "s"),
    ("sec.", "s"),
    ("s.", "s"),
    ("sec²", "s2"),
];

/// The unit in square brackets at the end of a name that no unit known here is: neither blank, `-`, nor the index of
/// an array.
pub(crate) fn unknown_unit(header: &str) -> Option<&str> {
    let inner = header.trim_end().strip_suffix(']')?;
    let text = inner[inner.rfind('[')? + 1..].trim();
    let is_unit = text.contains(|c: char| !c.is_ascii_digit() && !"-–,: ".contains(c));
    if is_unit && parse_stated_unit(text).is_none() { Some(text) } else { None }
}

/// Splits `steer [deg]`, `steer (deg)`, `steer {deg}`, `steer / deg`, `steer, deg`, `rate / (deg/s)`, `rate deg / s` or
/// `Winkel in Grad` into name and unit text; without brackets only where the unit is known.
pub(crate) fn split_brackets(header: &str) -> (&str, Option<&str>) {
    // `yaw rate deg / s`
    if let Some((name, _)) = header.rsplit_once(" / ")
        && let Some((name, unit)) = name.trim_end().rsplit_once(' ')
        && let tail = header[name.len()..].trim()
        && unit != "1"
        && parse_unit(tail).is_some()
    {
        let name = name.trim_end();
        return (name.strip_suffix(" in").unwrap_or(name).trim_end(), Some(tail));
    }
    for word in [" / ", " in ", ", "] {
        if let Some((name, unit)) = header.rsplit_once(word) {
            let unit = unit.trim();
            let bare =
                unit.strip_prefix('(').and_then(|unit| unit.strip_suffix(')')).unwrap_or(unit);
            // `wheel, 1` is the first of several.
            let is_number = word == ", " && bare == "1";
            if parse_unit(bare).is_some() && !is_number {
                return (name.trim_end(), Some(bare));
            }
        }
    }
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}'), ('（', '）')] {
        if let Some(inner) = header.strip_suffix(close)
            && let Some(at) = inner.rfind(open)
        {
            return (header[..at].trim_end(), Some(&inner[at + open.len_utf8()..]));
        }
    }
    (header, None)
}

/// The name of a channel without the unit that its header states in brackets.
#[must_use]
pub fn without_unit(header: &str) -> &str {
    split_brackets(header).0
}

/// The unit a header states, in brackets or as a suffix: after an underscore, after a space where it
/// has more than one letter, or of an angle after a small letter (`roadWheelAngleDeg`).
pub(crate) fn unit_of_header(header: &str) -> Option<Unit> {
    let (name, bracketed) = split_brackets(header);
    if let Some(text) = bracketed {
        return parse_stated_unit(text);
    }
    let lower = name.to_lowercase();
    SPELLINGS
        .iter()
        // A number at the end of a name counts things.
        .filter(|(_, unit)| *unit != ONE)
        .flat_map(|(names, unit)| names.iter().map(move |n| (*n, *unit)))
        .filter(|(n, _)| {
            lower.strip_suffix(n).is_some_and(|rest| {
                rest.ends_with('_') || (n.chars().count() > 1 && rest.ends_with(' '))
            }) || is_camel_case(name, n)
        })
        .max_by_key(|(n, _)| n.len())
        .map(|(_, unit)| unit)
}

fn is_camel_case(name: &str, unit: &str) -> bool {
    let before = match unit {
        "deg" => name.strip_suffix("Deg"),
        "rad" => name.strip_suffix("Rad"),
        _ => None,
    };
    before.is_some_and(|before| before.ends_with(|c: char| c.is_lowercase()))
}

/// The name of a column as names of its kind are compared: the last part of a path, no unit, small
/// letters and digits.
pub(crate) fn plain_name(header: &str) -> String {
    let (name, bracketed) = split_brackets(header);
    let name = if name.starts_with('/') { name.rsplit('/').next().unwrap_or(name) } else { name };
    let lower = name.to_lowercase();
    let suffix = SPELLINGS
        .iter()
        .filter(|_| bracketed.is_none())
        .flat_map(|(names, _)| names.iter())
        .filter_map(|n| lower.strip_suffix(n).filter(|rest| rest.ends_with(['_', ' '])))
        .min_by_key(|rest| rest.len());
    let lower = suffix.unwrap_or(&lower);
    lower.chars().filter(|c| c.is_alphanumeric()).collect()
}

#[must_use]
pub(crate) fn known_units() -> String {
    let names = SPELLINGS.iter().map(|(_, unit)| unit.name);
    let long = LONG_TIMES.iter().map(|(_, unit)| unit.name);
    let alone = ALONE.iter().map(|unit| unit.name);
    let names: Vec<&str> = names.chain([PER_SECOND.name]).chain(alone).chain(long).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_other_tools() {
        for (text, name, to_si) in [
            ("1/s", "1/s", 1.0),
            ("s^-1", "1/s", 1.0),
            ("deg s^-1", "deg/s", DEG),
            ("deg.s-1", "deg/s", DEG),
            ("deg·s⁻¹", "deg/s", DEG),
            ("m s-1", "m/s", 1.0),
            ("m s^-2", "m/s2", 1.0),
            ("degrees/s", "deg/s", DEG),
            ("Grad/s", "deg/s", DEG),
            ("Grad", "deg", DEG),
            ("mrad", "mrad", 1e-3),
            ("km/hr", "km/h", 1.0 / 3.6),
            ("kn", "knots", 0.514_444_444_444_444_4),
            ("μs", "us", 1e-6),
            ("Âµs", "us", 1e-6),
            ("Â°", "deg", DEG),
            ("º/s", "deg/s", DEG),
            ("˚", "deg", DEG),
            ("°s⁻¹", "deg/s", DEG),
            ("degrees per second", "deg/s", DEG),
            ("deg/second", "deg/s", DEG),
            ("°/sec.", "deg/s", DEG),
            ("&deg;/s", "deg/s", DEG),
            ("graden/s", "deg/s", DEG),
            ("ø/s", "deg/s", DEG),
            ("¡", "deg", DEG),
            ("rpm", "rpm", 6.0 * DEG),
            ("gon", "gon", 0.9 * DEG),
            ("µrad", "urad", 1e-6),
            ("kilometers per hour", "km/h", 1.0 / 3.6),
            ("km/hour", "km/h", 1.0 / 3.6),
            ("m per s", "m/s", 1.0),
            ("Meters/second", "m/s", 1.0),
            ("mi/h", "mph", 0.447_04),
            ("ft/s", "ft/s", 0.3048),
            ("cm/s", "cm/s", 0.01),
            ("mm/s", "mm/s", 1e-3),
        ] {
            let unit = parse_unit(text).unwrap();
            assert_eq!(unit.name, name, "{text}");
            assert!((unit.to_si / to_si - 1.0).abs() < 1e-12, "{text}");
        }
        assert_eq!(unknown_unit("yaw_rate [turns/s]"), Some("turns/s"));
        for known in ["wheel[0]", "steer [-]", "steer []", "yaw rate [1/s]", "x (raw)", "steer"] {
            assert_eq!(unknown_unit(known), None, "{known}");
        }
    }

    #[test]
    fn suffixes_and_brackets() {
        for (header, name) in [
            ("time_s", "s"),
            ("t_ms", "ms"),
            ("yaw_rate_deg_s", "deg/s"),
            ("yaw_rate_rad_s", "rad/s"),
            ("gyro_degps", "deg/s"),
            ("Steer [deg]", "deg"),
            ("rate (deg/s)", "deg/s"),
            ("vx_mps", "m/s"),
            ("v_m_s", "m/s"),
            ("v_kmh", "km/h"),
            ("x_m", "m"),
            ("ay_g", "g"),
            ("steering_wheel_angle_DEG", "deg"),
            ("velocity kmh", "km/h"),
            ("steeringAngleDeg", "deg"),
            ("Lenkwinkel [°]", "deg"),
            ("throttle [%]", "%"),
            ("throttle_pct", "%"),
            ("Accelerator percent", "%"),
            ("altitude_ft", "ft"),
            ("yaw rate deg / s", "deg/s"),
            ("speed m / s", "m/s"),
            ("time / s", "s"),
            ("time, s", "s"),
            ("rate, deg/s", "deg/s"),
            ("rate {deg/s}", "deg/s"),
            ("yaw_rate（deg/s）", "deg/s"),
            ("Yaw rate, град/с", "deg/s"),
            ("speed(公里/小时)", "km/h"),
        ] {
            assert_eq!(unit_of_header(header).map(|u| u.name), Some(name), "{header}");
        }
        for header in ["steer", "wheels", "grad", "x", "1", "steer [turns]", "gear s", "winkel"] {
            assert_eq!(unit_of_header(header), None, "{header}");
        }
    }
}
