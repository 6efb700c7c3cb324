//! Finds the column for each role.

use crate::Error;
use crate::channel_units::{check_quantity, is_named, is_stated_without_unit, named_unit, unit_of};
use crate::error::shortened;
use crate::expression::{Term, terms};
use crate::options::LogOptions;
use crate::recording::{Group, uncommented};
use crate::role::Role;
use crate::units::{ONE, Quantity, STAMP, Unit};
use strsim::osa_distance;

/// What a role is read from.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    pub(crate) group: usize,
    /// As it is named in messages.
    pub(crate) name: String,
    pub(crate) unit: Unit,
    /// Unit that the values keep; `None` of values that are brought to SI.
    pub(crate) own_unit: Option<String>,
    /// Products of channels, to be added.
    pub(crate) terms: Vec<Term>,
}

/// The channel for `role`, or `None` where none is named and the role is optional.
pub(crate) fn find(
    groups: &[Group],
    options: &LogOptions,
    role: Role,
    warnings: &mut Vec<String>,
) -> Result<Option<Source>, Error> {
    let Some(wanted) = options.stated_channel(role) else {
        return by_name(groups, options, role, warnings);
    };
    let (name, sign) = wanted.strip_prefix('-').map_or((wanted, 1.0), |n| (n, -1.0));
    let (group, terms) = match only_column(groups, role, name) {
        Ok((group, channel)) => (group, vec![Term { factor: sign, channels: vec![channel] }]),
        Err(error) => expression(groups, role, wanted)?.ok_or(error)?,
    };
    let first = terms.iter().flat_map(|term| &term.channels).next().copied().unwrap_or_default();
    let is_plain = matches!(&terms[..], [term] if term.channels.len() == 1);
    let own = &groups[group];
    if role.is_named_channel() {
        let unit = named_unit(own, first, options, warnings)?;
        // A product or a sum has the unit that is stated of none of its channels.
        let unit = if is_plain { unit } else { "1".into() };
        let name = if is_plain { own.channels[first].name.clone() } else { wanted.into() };
        return Ok(Some(Source { group, name, unit: ONE, own_unit: Some(unit), terms }));
    }
    let unit = match centripetal(own, &terms, role, options) {
        Some(unit) => unit,
        None => unit_for(own, first, role, options)?,
    };
    check_quantity(own, first, unit, role)?;
    let unit = at_full_scale(unit, options, role)?;
    let reversed = if sign < 0.0 { "-" } else { "" };
    let name =
        if is_plain { format!("{reversed}{}", own.channels[first].name) } else { wanted.into() };
    Ok(Some(Source { group, name, unit, own_unit: None, terms }))
}

/// The one channel of that name, as group and place in it.
fn only_column(groups: &[Group], role: Role, name: &str) -> Result<(usize, usize), Error> {
    // A channel may have a colon in its own name, so the whole name is tried first.
    let mut hits: Vec<(usize, usize)> = hits(groups, name);
    if hits.is_empty()
        && let Some((file, channel)) = name.rsplit_once(':')
    {
        hits = self::hits(groups, channel);
        hits.retain(|(g, _)| groups[*g].is_called(file));
        // The file's whole name goes before its last part.
        if hits.iter().any(|(g, _)| groups[*g].file == file) {
            hits.retain(|(g, _)| groups[*g].file == file);
        }
    }
    match hits[..] {
        [] => Err(Error::MissingColumn {
            role: role.name(),
            column: name.into(),
            available: available(groups, Some(name)),
        }),
        [(g, c)] if groups[g].is_repeated(c) => Err(groups[g].repeated(c)),
        [hit] => Ok(hit),
        _ => {
            let places: Vec<String> = hits.iter().map(|(g, _)| groups[*g].place()).collect();
            let (role, column) = (role.name(), name.into());
            Err(Error::AmbiguousColumn { role, column, files: places.join(", ") })
        }
    }
}

/// The channels of that name; of its name without the marks of a comment where there are none.
fn hits(groups: &[Group], name: &str) -> Vec<(usize, usize)> {
    let named = |name: &str| -> Vec<(usize, usize)> {
        groups.iter().enumerate().filter_map(|(g, group)| Some((g, group.find(name)?))).collect()
    };
    let hits = named(name);
    match uncommented(name) {
        Some(bare) if hits.is_empty() => named(bare),
        _ => hits,
    }
}

/// The unit of a lateral acceleration that is yaw rate times speed.
fn centripetal(group: &Group, terms: &[Term], role: Role, options: &LogOptions) -> Option<Unit> {
    let [Term { channels, .. }] = terms else { return None };
    let [a, b] = channels[..] else { return None };
    let [a, b] = [unit_of(group, a, options).ok()?, unit_of(group, b, options).ok()?];
    let is_product = [(a, b), (b, a)]
        .iter()
        .any(|(a, b)| a.quantity == Quantity::AngularRate && b.quantity == Quantity::Speed);
    let unit = Unit { name: "m/s2", quantity: Quantity::Acceleration, to_si: a.to_si * b.to_si };
    if role == Role::LateralAcceleration && is_product { Some(unit) } else { None }
}

/// Channels of one group that are added, such as an angle and its fraction; `None` where the text is no
/// expression.
fn expression(
    groups: &[Group],
    role: Role,
    text: &str,
) -> Result<Option<(usize, Vec<Term>)>, Error> {
    let Some(parsed) = terms(text) else { return Ok(None) };
    let mut group = None;
    let mut found = Vec::new();
    for (factor, names) in parsed {
        let mut channels = Vec::new();
        for name in names {
            let (own, channel) = only_column(groups, role, name)?;
            if *group.get_or_insert(own) != own {
                return Err(Error::SeveralClocks { role: role.name(), expression: text.into() });
            }
            channels.push(channel);
        }
        found.push(Term { factor, channels });
    }
    Ok(group.map(|group| (group, found)))
}

/// The columns of numbers that are no speed by a word in their names.
fn named_otherwise(group: &Group) -> impl Iterator<Item = String> {
    let channels =
        group.channels.iter().filter(|channel| channel.has_role_by_name && !channel.is_text);
    channels.filter_map(|channel| {
        let word = Role::Speed.excluded_by(&channel.name)?;
        let (file, column) = (group.place(), shortened(&channel.name));
        Some(format!(
            "{file}: column `{column}` looks like a speed, but its name contains `{word}`: name it with \
             --speed-channel if it is the speed"
        ))
    })
}

/// The one column whose name and unit fit the role.
fn by_name(
    groups: &[Group],
    options: &LogOptions,
    role: Role,
    warnings: &mut Vec<String>,
) -> Result<Option<Source>, Error> {
    let mut found = Vec::new();
    let mut unfit = Vec::new();
    let mut texts = Vec::new();
    for (g, group) in groups.iter().enumerate() {
        for (c, channel) in group.channels.iter().enumerate() {
            if !channel.may_be(role) {
                if channel.is_text && channel.is_named_like(role) {
                    texts.push(shortened(&channel.name));
                }
                if options.is_optional(role) && channel.is_named_like(role) {
                    let (file, name) = (group.place(), role.name());
                    let column = shortened(&channel.name);
                    warnings.push(format!(
                        "{file}: column `{column}` holds texts: not taken for the {name}"
                    ));
                }
                continue;
            }
            let unit = unit_for(group, c, role, options)
                .and_then(|unit| check_quantity(group, c, unit, role).map(|()| unit));
            match unit {
                Ok(_) if group.is_repeated(c) && !options.is_optional(role) => {
                    return Err(group.repeated(c));
                }
                Ok(unit) => {
                    let terms = vec![Term { factor: 1.0, channels: vec![c] }];
                    let name = channel.name.clone();
                    found.push(Source { group: g, name, unit, own_unit: None, terms });
                }
                // A stated unit is an error where it is not recognised; one in a name where no other column fits.
                Err(error @ Error::UnknownUnit { .. })
                    if !options.is_optional(role) && channel.unit.is_some()
                        || options.units.keys().any(|name| is_named(group, c, name)) =>
                {
                    return Err(error);
                }
                Err(error) => unfit.push(error),
            }
        }
    }
    if role == Role::Speed && found.is_empty() && unfit.is_empty() {
        warnings.extend(groups.iter().flat_map(named_otherwise));
    }
    let is_required = options.response.roles().contains(&role);
    let is_unknown = |error: &Error| matches!(error, Error::UnknownUnit { .. });
    if found.is_empty()
        && (is_required || role == Role::Speed)
        && !options.is_optional(role)
        && let Some(at) = unfit.iter().position(is_unknown)
    {
        return Err(unfit.swap_remove(at));
    }
    if role == Role::Steering && !is_required {
        // Not the command.
        found.retain(|source| source.unit.quantity == Quantity::Angle);
    }
    let is_of_gnss = |source: &Source| role.is_of_gnss(&source.name);
    if found.iter().any(|source| !is_of_gnss(source)) {
        found.retain(|source| !is_of_gnss(source));
    }
    match (&found[..], is_required) {
        ([source], _) => {
            let unit = at_full_scale(source.unit, options, role)?;
            Ok(Some(Source { unit, ..source.clone() }))
        }
        // The column is there, its unit is wrong.
        ([], true) if unfit.len() == 1 => Err(unfit.remove(0)),
        (several, false) => {
            if let ([], [error]) = (several, &unfit[..]) {
                warnings.push(format!("{error}: not taken for the {}", role.name()));
            } else if several.len() > 1 {
                warnings
                    .push(format!("several columns could be the {}: none is taken", role.name()));
            }
            Ok(None)
        }
        (several, true) => Err(Error::RoleNotFound {
            role: role.name(),
            problem: if let ([], Some(text)) = (several, texts.first()) {
                format!("`{text}` holds texts, and numbers are expected")
            } else if several.is_empty() {
                "no column is named like one".into()
            } else {
                let names: Vec<String> =
                    several.iter().map(|s| groups[s.group].label(&shortened(&s.name))).collect();
                format!("several could be ({})", names.join(", "))
            },
            available: available(groups, None),
        }),
    }
}

/// The unit of a normalised steering command whose angle at 1 is stated.
fn at_full_scale(unit: Unit, options: &LogOptions, role: Role) -> Result<Unit, Error> {
    let Some(angle) = options.steering_full_scale_rad.filter(|_| role == Role::Steering) else {
        return Ok(unit);
    };
    if unit.quantity != Quantity::Dimensionless {
        return Err(Error::NoCommand { unit: unit.name });
    }
    Ok(Unit { quantity: Quantity::Angle, to_si: angle * unit.to_si, ..unit })
}

/// The unit of a channel in a role; a switch needs none, and neither does a pedal that is stated to have none.
fn unit_for(
    group: &Group,
    channel: usize,
    role: Role,
    options: &LogOptions,
) -> Result<Unit, Error> {
    match unit_of(group, channel, options) {
        Err(Error::UnitNotStated { .. })
            if role.is_state()
                || role.is_pedal(&group.channels[channel].name)
                    && is_stated_without_unit(group, channel) =>
        {
            Ok(ONE)
        }
        unit => unit,
    }
}

pub(crate) fn time_column(
    group: &Group,
    options: &LogOptions,
) -> Result<Option<(usize, Unit)>, Error> {
    let of = |c: usize| {
        if group.is_repeated(c) {
            Err(group.repeated(c))
        } else if group.channels[c].has_stamps {
            Ok(STAMP)
        } else {
            unit_of(group, c, options)
        }
    };
    if let Some(name) = &options.time {
        let name = name.rsplit_once(':').map_or(name.as_str(), |(_, column)| column);
        let bare = || uncommented(name).and_then(|bare| group.find(bare));
        if let Some(c) = group.find(name).or_else(bare) {
            let unit = of(c)?;
            check_quantity(group, c, unit, Role::Time)?;
            return Ok(Some((c, unit)));
        }
    }
    if let Some(c) = group.clock {
        return Ok(Some((c, of(c)?)));
    }
    let mut unfit = Vec::new();
    for (c, channel) in group.channels.iter().enumerate() {
        if options.time.is_some() || !channel.may_be(Role::Time) {
            continue;
        }
        match of(c) {
            Err(Error::UnitNotStated { .. }) if channel.unread.is_some() => {
                unfit.extend(group.unread_time(c));
            }
            Ok(unit) if unit.quantity == Quantity::Time => return Ok(Some((c, unit))),
            Ok(_) => {}
            Err(error @ Error::RepeatedColumn { .. }) if options.row_period_s.is_none() => {
                return Err(error);
            }
            Err(error) => unfit.push(error),
        }
    }
    // Dates and times are a clock whatever they are called, unless there are several.
    let channels = group.channels.iter().enumerate();
    let mut stamps = channels.filter(|(_, channel)| channel.has_stamps);
    if let (None, Some((c, _)), None) = (&options.time, stamps.next(), stamps.next()) {
        return Ok(Some((c, STAMP)));
    }
    if options.row_period_s.is_some() {
        return Ok(None);
    }
    // The only other name that ends with the time and has a unit of it.
    let is_other = |c: &usize| Role::is_named_like_another_time(&group.channels[*c].name);
    let mut others = (0..group.channels.len())
        .filter(is_other)
        .filter_map(|c| Some((c, of(c).ok().filter(|unit| unit.quantity == Quantity::Time)?)));
    if let (None, true, Some(other), None) =
        (&options.time, unfit.is_empty(), others.next(), others.next())
    {
        return Ok(Some(other));
    }
    if let Some(name) = &options.time {
        let (role, column, available) = (Role::Time.name(), name.clone(), group.names());
        return Err(Error::MissingColumn { role, column, available });
    }
    if unfit.len() == 1 {
        return Err(unfit.remove(0));
    }
    let is_time = |c: &usize| group.channels[*c].is_named_like(Role::Time);
    if let Some(error) =
        (0..group.channels.len()).filter(is_time).find_map(|c| group.unread_time(c))
    {
        return Err(error);
    }
    Err(Error::NoTime { file: group.place(), available: group.names() })
}

/// Channels in words: all of a few, or those nearest to what was asked for.
fn available(groups: &[Group], wanted: Option<&str>) -> String {
    // A bus or a robot has hundreds of channels.
    const MOST: usize = 60;
    const MOST_BESIDE_A_NAME: usize = 12;
    const NEAREST: usize = 5;
    let all: usize = groups.iter().map(|g| g.channels.len()).sum();
    if let Some(wanted) = wanted
        && all > MOST_BESIDE_A_NAME
    {
        let wanted = wanted.to_lowercase();
        let mut found = Vec::new();
        for group in groups {
            for channel in &group.channels {
                let name = channel.name.to_lowercase();
                let is_part =
                    !name.is_empty() && (name.contains(&wanted) || wanted.contains(&name));
                let distance = osa_distance(&wanted, &name);
                found.push((!is_part, distance, group.label(&shortened(&channel.name))));
            }
        }
        found.sort();
        let names: Vec<String> = found.into_iter().take(NEAREST).map(|(.., name)| name).collect();
        return format!("{} (the nearest of {all})", names.join(", "));
    }
    let (mut left, mut texts) = (MOST, Vec::new());
    for group in groups {
        let names = group.channels.iter().take(left).map(|c| shortened(&c.name));
        let names: Vec<String> = names.collect();
        left -= names.len();
        if !names.is_empty() {
            texts.push(format!("{} in {}", names.join(", "), group.place()));
        }
    }
    if texts.is_empty() {
        return "none".into();
    }
    let more = if all > MOST { format!("; {} more", all - MOST) } else { String::new() };
    texts.join("; ") + &more
}
