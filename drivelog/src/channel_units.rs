//! Units of channels: stated in the options, by the file, or in the name.

use crate::Error;
use crate::error::{Place, shortened};
use crate::options::LogOptions;
use crate::recording::Group;
use crate::role::Role;
use crate::units::{
    Quantity, Unit, parse_stated_unit, parse_unit, split_brackets, unit_of_header, unknown_unit,
};
use steerwright_formats::PhysicalUnit;

/// The unit stated in the options, else by the file or in the channel's name.
pub(crate) fn unit_of(group: &Group, channel: usize, options: &LogOptions) -> Result<Unit, Error> {
    let own = &group.channels[channel];
    let stated = options.units.iter().find(|(name, _)| is_named(group, channel, name));
    let parsed = |text: &str| {
        parse_stated_unit(text).ok_or_else(|| Error::UnknownUnit {
            file: group.place(),
            column: own.name.clone(),
            unit: text.into(),
        })
    };
    if let Some((_, text)) = stated {
        return parsed(text);
    }
    let place = || Place::new(&group.place(), group.header_line, &own.name);
    let apart = own.unit.as_deref().map(parsed).transpose()?;
    match (unit_of_header(&own.name), apart) {
        (Some(name), Some(apart)) if name != apart => {
            let (header, row) = (name.name, apart.name);
            Err(Error::UnitsDiffer { at: place(), header, row })
        }
        (None, None) => Err(match unknown_unit(&own.name) {
            Some(unit) => Error::UnknownUnit {
                file: group.place(),
                column: own.name.clone(),
                unit: unit.into(),
            },
            None => Error::UnitNotStated { at: place() },
        }),
        (Some(unit), _) | (None, Some(unit)) => Ok(unit),
    }
}

/// The unit of a channel of any system, which keeps it: stated in the options, by the file or in the channel's name, and
/// `1` without one.
pub(crate) fn named_unit(
    group: &Group,
    channel: usize,
    options: &LogOptions,
    warnings: &mut Vec<String>,
) -> Result<String, Error> {
    let own = &group.channels[channel];
    let known = |text: &str| {
        if PhysicalUnit::parse(text).is_some() {
            return Some(PhysicalUnit::plain(text));
        }
        let spelled = parse_unit(text).map(|unit| unit.name);
        spelled.filter(|name| PhysicalUnit::parse(name).is_some()).map(Into::into)
    };
    if let Some((_, text)) = options.units.iter().find(|(name, _)| is_named(group, channel, name)) {
        return known(text).ok_or_else(|| Error::UnknownUnit {
            file: group.place(),
            column: own.name.clone(),
            unit: text.clone(),
        });
    }
    let (name, bracketed) = split_brackets(&own.name);
    if let Some(text) = own.unit.as_deref().or(bracketed).map(str::trim)
        && !text.is_empty()
        && text != "-"
    {
        return Ok(known(text).unwrap_or_else(|| {
            warnings.push(format!(
                "{}: column `{}`: the unit `{text}` is not known: taken for 1 unless it is stated",
                group.place(),
                shortened(&own.name)
            ));
            "1".into()
        }));
    }
    let spelled = unit_of_header(name).and_then(|unit| known(unit.name));
    Ok(spelled.or_else(|| unit_at_end(name)).unwrap_or_else(|| "1".into()))
}

/// Units of one letter at the end of a name, which may as well count things, and the words beside which they do not.
const LETTERS: [(&str, &[&str]); 6] = [
    ("V", &["volt", "supply", "spannung"]),
    ("A", &["current", "strom"]),
    ("W", &["power", "leistung"]),
    ("J", &["energy", "energie"]),
    ("K", &["temp"]),
    ("N", &["force", "thrust", "kraft"]),
];

/// The unit after the last underscore of a name.
fn unit_at_end(name: &str) -> Option<String> {
    let (rest, end) = name.rsplit_once('_')?;
    if let Some((_, words)) = LETTERS.iter().find(|(letter, _)| *letter == end) {
        let rest = rest.to_lowercase();
        return if words.iter().any(|word| rest.contains(word)) {
            Some(end.to_owned())
        } else {
            None
        };
    }
    // `x_min` is a least value, `k_rev` a direction.
    let is_word = end.chars().count() < 2 || matches!(end, "min" | "rev");
    let is_unit = !is_word
        && end.starts_with(|c: char| c.is_alphabetic())
        && PhysicalUnit::parse(end).is_some();
    if is_unit { Some(PhysicalUnit::plain(end)) } else { None }
}

/// Whether `name` is that of the channel, with or without its file before it.
pub(crate) fn is_named(group: &Group, channel: usize, name: &str) -> bool {
    let own = &group.channels[channel].name;
    let is = |name: &str| {
        name == own || name == split_brackets(own).0 || group.find(name) == Some(channel)
    };
    is(name) || name.rsplit_once(':').is_some_and(|(file, name)| group.is_called(file) && is(name))
}

/// Whether brackets or a row of units state that the channel has no unit, as in `throttle [-]`.
pub(crate) fn is_stated_without_unit(group: &Group, channel: usize) -> bool {
    let own = &group.channels[channel];
    let bracketed = split_brackets(&own.name).1.map(str::trim);
    own.is_without_unit || matches!(bracketed, Some("-" | "–"))
}

/// Every stated unit must belong to a channel that exists.
pub(crate) fn check_units_are_used<'a>(
    groups: impl Iterator<Item = &'a Group> + Clone,
    options: &LogOptions,
) -> Result<(), Error> {
    for name in options.units.keys() {
        let column = name.rsplit_once(':').map_or(name.as_str(), |(_, column)| column);
        if !groups.clone().any(|g| g.find(name).is_some() || g.find(column).is_some()) {
            return Err(Error::UnusedUnit { column: name.clone() });
        }
    }
    Ok(())
}

/// That databases are stated and no log has frames of a bus, for people.
pub(crate) fn unused_databases<'a>(
    mut groups: impl Iterator<Item = &'a Group>,
    options: &LogOptions,
) -> Option<String> {
    let (first, _) = options.dbc.first()?;
    if groups.any(|group| group.kind.starts_with("CAN ")) {
        return None;
    }
    Some(format!("{first}: not used: no frame of a CAN bus was read"))
}

pub(crate) fn check_quantity(
    group: &Group,
    channel: usize,
    unit: Unit,
    role: Role,
) -> Result<(), Error> {
    let name = &group.channels[channel].name;
    if role.takes(unit.quantity) && !(role.is_rate(name) && unit.quantity == Quantity::Angle) {
        return Ok(());
    }
    Err(Error::WrongQuantity {
        file: group.place(),
        column: name.clone(),
        role: role.name(),
        unit: unit.name,
        expected: role.expected_units(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Channel, Group};

    #[test]
    fn named_channels_keep_their_unit_and_have_1_without_one() {
        let unit = |name: &str, stated: Option<&str>| {
            let group = Group::new("log.csv", "", vec![Channel::new(name, None)]);
            let units = stated.iter().map(|unit| (name.to_owned(), (*unit).to_owned())).collect();
            let options = LogOptions { units, ..LogOptions::default() };
            let mut warnings = Vec::new();
            (named_unit(&group, 0, &options, &mut warnings), warnings.len())
        };
        for (name, expected) in [
            ("voltage [V]", "V"),
            ("supply_voltage_V", "V"),
            ("tank_A", "1"),
            ("force_1", "1"),
            ("outlet_temperature_degC", "degC"),
            ("T (°C)", "degC"),
            ("pressure [mbar]", "mbar"),
            ("n [min⁻¹]", "1/min"),
            ("speed_rpm", "rpm"),
            ("level_min", "1"),
            ("yaw_rate_radps", "rad/s"),
            ("steer [deg]", "deg"),
            ("torque_Nm", "Nm"),
            ("flow_rate", "1"),
            ("u", "1"),
        ] {
            assert_eq!(unit(name, None), (Ok(expected.into()), 0), "{name}");
        }
        assert_eq!(unit("u [counts]", None), (Ok("1".into()), 1));
        assert_eq!(unit("u", Some("N.m")), (Ok("N.m".into()), 0));
        assert!(matches!(unit("u", Some("turns")).0, Err(Error::UnknownUnit { .. })));
    }
}
