//! Units of channels: stated in the options, by the file, or in the name.

use crate::Error;
use crate::error::Place;
use crate::options::LogOptions;
use crate::recording::Group;
use crate::role::Role;
use crate::units::{Quantity, Unit, parse_unit, split_brackets, unit_of_header, unknown_unit};

/// The unit stated in the options, else by the file or in the channel's name.
pub(crate) fn unit_of(group: &Group, channel: usize, options: &LogOptions) -> Result<Unit, Error> {
    let own = &group.channels[channel];
    let stated = options.units.iter().find(|(name, _)| is_named(group, channel, name));
    let parsed = |text: &str| {
        parse_unit(text).ok_or_else(|| Error::UnknownUnit {
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

/// Whether `name` is that of the channel, with or without its file before it.
pub(crate) fn is_named(group: &Group, channel: usize, name: &str) -> bool {
    let own = &group.channels[channel].name;
    let is = |name: &str| {
        name == own || name == split_brackets(own).0 || group.find(name) == Some(channel)
    };
    is(name) || name.rsplit_once(':').is_some_and(|(file, name)| group.is_called(file) && is(name))
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
