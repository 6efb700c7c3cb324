//! Finds the column for each role.

use crate::error::{Error, Place, last_part};
use crate::options::LogOptions;
use crate::role::Role;
use crate::table::Table;
use crate::units::{Quantity, STAMP, Unit, parse_unit, split_brackets, unit_of_header};

#[derive(Debug, Clone, Copy)]
pub(crate) struct Source {
    pub(crate) table: usize,
    pub(crate) column: usize,
    pub(crate) unit: Unit,
    /// −1 where the mapping has a leading `-`.
    pub(crate) sign: f64,
}

/// The column for `role`, or `None` where none is named and the role is optional.
pub(crate) fn find(
    tables: &[Table<'_>],
    options: &LogOptions,
    role: Role,
    warnings: &mut Vec<String>,
) -> Result<Option<Source>, Error> {
    let Some(wanted) = role.wanted(options) else {
        return by_name(tables, options, role, warnings);
    };
    let (name, sign) = wanted.strip_prefix('-').map_or((wanted, 1.0), |n| (n, -1.0));
    // A column may have a colon in its own name, so the whole name is tried first.
    let mut hits: Vec<(usize, usize)> = hits(tables, name);
    if hits.is_empty()
        && let Some((file, column)) = name.rsplit_once(':')
    {
        hits = self::hits(tables, column);
        hits.retain(|(t, _)| same_file(&tables[*t].file, file));
        // The file's whole name goes before its last part.
        if hits.iter().any(|(t, _)| tables[*t].file == file) {
            hits.retain(|(t, _)| tables[*t].file == file);
        }
    }
    match hits[..] {
        [] => Err(Error::MissingColumn {
            role: role.name(),
            column: name.into(),
            available: available(tables),
        }),
        [(table, column)] => {
            let unit = unit_of(&tables[table], column, options)?;
            check_quantity(&tables[table], column, unit, role)?;
            let unit = at_full_scale(unit, options, role)?;
            Ok(Some(Source { table, column, unit, sign }))
        }
        _ => Err(Error::AmbiguousColumn {
            role: role.name(),
            column: name.into(),
            files: hits.iter().map(|(t, _)| &*tables[*t].file).collect::<Vec<_>>().join(", "),
        }),
    }
}

fn hits(tables: &[Table<'_>], name: &str) -> Vec<(usize, usize)> {
    tables.iter().enumerate().filter_map(|(t, table)| Some((t, table.find(name)?))).collect()
}

fn same_file(path: &str, name: &str) -> bool {
    path == name || last_part(path) == name
}

/// The one column whose name and unit fit the role.
fn by_name(
    tables: &[Table<'_>],
    options: &LogOptions,
    role: Role,
    warnings: &mut Vec<String>,
) -> Result<Option<Source>, Error> {
    let mut found = Vec::new();
    let mut unfit = Vec::new();
    for (t, table) in tables.iter().enumerate() {
        for (column, header) in table.header.iter().enumerate() {
            if !role.is_named_like(header) {
                continue;
            }
            let unit = unit_of(table, column, options)
                .and_then(|unit| check_quantity(table, column, unit, role).map(|()| unit));
            match unit {
                Ok(unit) => found.push(Source { table: t, column, unit, sign: 1.0 }),
                // A stated unit is an error where it is not recognised.
                Err(error @ Error::UnknownUnit { .. }) => return Err(error),
                Err(error) => unfit.push(error),
            }
        }
    }
    match (&found[..], role.required()) {
        ([source], _) => {
            let unit = at_full_scale(source.unit, options, role)?;
            Ok(Some(Source { unit, ..*source }))
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
            problem: if several.is_empty() {
                "no column is named like one".into()
            } else {
                let names: Vec<&str> =
                    several.iter().map(|s| tables[s.table].header[s.column].as_str()).collect();
                format!("several could be ({})", names.join(", "))
            },
            available: available(tables),
        }),
    }
}

/// The unit of a normalised steering command whose angle at 1 is stated.
fn at_full_scale(unit: Unit, options: &LogOptions, role: Role) -> Result<Unit, Error> {
    let Some(angle) = options.steering_full_scale_rad.filter(|_| role == Role::Steering) else {
        return Ok(unit);
    };
    if unit.quantity != Quantity::Dimensionless {
        return Err(Error::Option {
            option: "steering full scale",
            value: format!("{angle} rad"),
            expected: format!("a steering column in 1 or %; it is in {}", unit.name),
        });
    }
    Ok(Unit { quantity: Quantity::Angle, to_si: angle * unit.to_si, ..unit })
}

/// The unit stated in the options, else in the header or in the row under it.
pub(crate) fn unit_of(
    table: &Table<'_>,
    column: usize,
    options: &LogOptions,
) -> Result<Unit, Error> {
    let header = &table.header[column];
    let bare = split_brackets(header).0;
    let stated = options.units.iter().find(|(name, _)| {
        let name = name.as_str();
        name == header
            || name == bare
            || name.rsplit_once(':').is_some_and(|(file, column)| {
                same_file(&table.file, file) && (column == header || column == bare)
            })
    });
    let parsed = |text: &str| {
        parse_unit(text).ok_or_else(|| Error::UnknownUnit {
            file: table.file.clone(),
            column: header.clone(),
            unit: text.into(),
        })
    };
    if let Some((_, text)) = stated {
        return parsed(text);
    }
    let place = || Place::new(&table.file, table.header_line, header);
    let under = table.unit_under(column).map(parsed).transpose()?;
    match (unit_of_header(header), under) {
        (Some(header), Some(row)) if header != row => {
            let (header, row) = (header.name, row.name);
            Err(Error::UnitsDiffer { at: place(), header, row })
        }
        (header, row) => header.or(row).ok_or_else(|| Error::UnitNotStated { at: place() }),
    }
}

/// Every stated unit must belong to a column that exists.
pub(crate) fn check_units_are_used<'a>(
    tables: impl Iterator<Item = &'a Table<'a>> + Clone,
    options: &LogOptions,
) -> Result<(), Error> {
    for name in options.units.keys() {
        let column = name.rsplit_once(':').map_or(name.as_str(), |(_, column)| column);
        if !tables.clone().any(|t| t.find(name).is_some() || t.find(column).is_some()) {
            return Err(Error::UnusedUnit { column: name.clone() });
        }
    }
    Ok(())
}

fn check_quantity(table: &Table<'_>, column: usize, unit: Unit, role: Role) -> Result<(), Error> {
    if role.takes(unit.quantity)
        && !(role.is_rate(&table.header[column]) && unit.quantity == Quantity::Angle)
    {
        return Ok(());
    }
    Err(Error::WrongQuantity {
        file: table.file.clone(),
        column: table.header[column].clone(),
        role: role.name(),
        unit: unit.name,
        expected: role.expected_units(),
    })
}

pub(crate) fn time_column(
    table: &Table<'_>,
    options: &LogOptions,
) -> Result<Option<(usize, Unit)>, Error> {
    if let Some(name) = &options.time {
        let name = name.rsplit_once(':').map_or(name.as_str(), |(_, column)| column);
        if let Some(column) = table.find(name) {
            if table.has_stamps(column) {
                return Ok(Some((column, STAMP)));
            }
            let unit = unit_of(table, column, options)?;
            check_quantity(table, column, unit, Role::Time)?;
            return Ok(Some((column, unit)));
        }
    }
    let mut unfit = Vec::new();
    for (column, header) in table.header.iter().enumerate() {
        if options.time.is_some() || !Role::Time.is_named_like(header) {
            continue;
        }
        if table.has_stamps(column) {
            return Ok(Some((column, STAMP)));
        }
        match unit_of(table, column, options) {
            Ok(unit) if unit.quantity == Quantity::Time => return Ok(Some((column, unit))),
            Ok(_) => {}
            Err(error) => unfit.push(error),
        }
    }
    // Dates and times are a clock whatever they are called, unless there are several.
    let mut stamps = (0..table.header.len()).filter(|column| table.has_stamps(*column));
    if let (None, Some(column), None) = (&options.time, stamps.next(), stamps.next()) {
        return Ok(Some((column, STAMP)));
    }
    if options.row_period_s.is_some() {
        return Ok(None);
    }
    if unfit.len() == 1 {
        return Err(unfit.remove(0));
    }
    Err(Error::NoTime { file: table.file.clone(), available: table.header.join(", ") })
}

fn available(tables: &[Table<'_>]) -> String {
    let text = |t: &Table<'_>| format!("{} in {}", t.header.join(", "), t.file);
    tables.iter().map(text).collect::<Vec<_>>().join("; ")
}
