//! The values that a study sets and varies, held against the variables that get them.

use crate::Error;
use crate::connect::{Wired, host, split};
use crate::distribution::Distribution;
use crate::draws::Key;
use crate::plan::Varied;
use crate::study::{Study, Vary};
use std::collections::HashMap;
use steerwright_host::{Assigned, Causality, Error as HostError, Kind, Linear, Value, Variable};
use toml::Spanned;

/// A variable of the system: its instance and itself.
pub(crate) type Found<'a> = (usize, &'a Variable);

pub(crate) fn find<'a>(
    study: &Study,
    wired: &'a Wired,
    path: &Spanned<String>,
) -> Result<Found<'a>, Error> {
    let (instance, name) = split(study, path)?;
    let located = |e: HostError| host(study, Some(path), e);
    let all = wired.system.instances();
    let index = all.iter().position(|i| i.name() == instance).ok_or_else(|| {
        let instances = all.iter().map(|i| i.name().to_owned()).collect();
        located(HostError::UnknownInstance { name: instance.to_owned(), instances })
    })?;
    Ok((index, all[index].variable(name).map_err(located)?))
}

/// The values set in each run: by instance and variable.
pub(crate) type Assignments = HashMap<(usize, String), Assigned>;

/// The values of the package, of `[set]` and of `[[vary]]`, and the varied quantities.
pub(crate) fn values(study: &Study, wired: &Wired) -> Result<(Assignments, Vec<Varied>), Error> {
    let mut assignments = Assignments::new();
    let all = wired.system.instances();
    for (instance, variable, value) in wired.system.settings() {
        if let Some(index) = all.iter().position(|i| i.name() == instance) {
            assignments.insert((index, variable.to_owned()), Assigned::Fixed(value.clone()));
        }
    }
    let mut stated: HashMap<(usize, String), String> = HashMap::new();
    for (path, value) in &study.raw.set {
        let (index, variable) = settable(study, wired, path, &mut stated, "[set]")?;
        let value = fixed(study, wired, path, (index, variable), value)?;
        assignments.insert((index, variable.name.clone()), Assigned::Fixed(value));
    }
    let mut varied = Vec::new();
    for entry in &study.raw.vary {
        varied.push(quantity(study, wired, entry, varied.len(), &mut stated, &mut assignments)?);
    }
    // The axis that is named last moves fastest.
    let mut stride = 1;
    for quantity in varied.iter_mut().rev() {
        quantity.stride = stride;
        stride *= quantity.distribution.points();
    }
    Ok((assignments, varied))
}

/// A variable that may be set, and is not by another entry.
fn settable<'a>(
    study: &Study,
    wired: &'a Wired,
    path: &Spanned<String>,
    stated: &mut HashMap<(usize, String), String>,
    by: &str,
) -> Result<Found<'a>, Error> {
    let (index, variable) = find(study, wired, path)?;
    let instance = &wired.system.instances()[index];
    if variable.causality == Causality::Input {
        let feeds =
            |c: &&steerwright_host::Connection| c.to == instance.name() && c.input == variable.name;
        if let Some(connection) = wired.system.connections().iter().find(feeds) {
            let problem = format!(
                "{} is fed by {}.{}: a value set there would have no effect",
                path.get_ref(),
                connection.from,
                connection.output
            );
            let hint = "to disturb what a connection carries, use a [[disturb]]";
            return Err(study.fault(path, problem, hint));
        }
    } else {
        instance.settable(&variable.name).map_err(|e| host(study, Some(path), e))?;
    }
    if let Some(other) = stated.insert((index, variable.name.clone()), by.to_owned()) {
        let problem = format!("{} already gets its value from {other}", path.get_ref());
        return Err(study.fault(path, problem, "set it once"));
    }
    Ok((index, variable))
}

/// A value of `[set]`, in the variable's type and unit.
fn fixed(
    study: &Study,
    wired: &Wired,
    path: &Spanned<String>,
    (index, variable): Found<'_>,
    entry: &Spanned<toml::Value>,
) -> Result<Value, Error> {
    let bad = || {
        let error = HostError::BadValue {
            instance: wired.system.instances()[index].name().to_owned(),
            variable: variable.name.clone(),
            text: entry.get_ref().to_string(),
            kind: variable.kind,
        };
        host(study, Some(entry), error)
    };
    let value = match (variable.kind, entry.get_ref()) {
        (Kind::Real, toml::Value::Float(value)) => Value::Real(*value),
        (Kind::Real, toml::Value::Integer(value)) => Value::Real(*value as f64),
        (Kind::Real, toml::Value::String(text)) => {
            let split = text.find(|c: char| c.is_alphabetic() && c != 'e' && c != 'E' || c == '%');
            let (number, unit) = text.split_at(split.unwrap_or(text.len()));
            let number: f64 = number.trim().parse().map_err(|_| bad())?;
            let convert = conversion(wired, (index, variable), Some(unit.trim()))
                .map_err(|problem| study.fault(entry, problem, UNIT_HINT))?;
            Value::Real(convert.apply(number))
        }
        (Kind::Integer, toml::Value::Integer(value)) => {
            Value::Integer(i32::try_from(*value).map_err(|_| bad())?)
        }
        (Kind::Boolean, toml::Value::Boolean(value)) => Value::Boolean(*value),
        (Kind::String, toml::Value::String(text)) => Value::String(text.clone()),
        _ => return Err(bad()),
    };
    if let Value::Real(number) = value
        && !number.is_finite()
    {
        return Err(bad());
    }
    if let Some(number) = value.as_number() {
        within(study, path, variable, (number, number))?;
    }
    Ok(value)
}

pub(crate) const UNIT_HINT: &str =
    "use the unit of the variable, or one that its FMU defines for display";

/// From a unit to that of a variable.
pub(crate) fn conversion(
    wired: &Wired,
    (index, variable): Found<'_>,
    unit: Option<&str>,
) -> Result<Linear, String> {
    let Some(unit) = unit else { return Ok(Linear::IDENTITY) };
    let instance = &wired.system.instances()[index];
    let at = |value| instance.model().converted(variable, value, unit);
    match (at(0.0), at(1.0)) {
        (Some(offset), Some(one)) if one != offset => Ok(Linear { factor: one - offset, offset }),
        _ => Err(format!(
            "{}.{} is in {}, and nothing converts {unit:?} to it",
            instance.name(),
            variable.name,
            variable.unit.as_deref().map_or("no unit".to_owned(), |u| format!("{u:?}")),
        )),
    }
}

/// Refuses values beyond what modelDescription.xml allows.
fn within<T>(
    study: &Study,
    at: &Spanned<T>,
    variable: &Variable,
    (least, greatest): (f64, f64),
) -> Result<(), Error> {
    let below = variable.min.filter(|min| least < *min);
    let above = variable.max.filter(|max| greatest > *max);
    let (value, word, bound) = match (below, above) {
        (Some(min), _) => (least, "minimum", min),
        (_, Some(max)) => (greatest, "maximum", max),
        _ => return Ok(()),
    };
    let problem = format!("{} would get {value}, beyond its {word} {bound}", variable.name);
    let hint = "keep to the variable's bounds; truncated-normal has bounds";
    Err(study.fault(at, problem, hint))
}

/// A varied quantity, and what it sets.
fn quantity(
    study: &Study,
    wired: &Wired,
    entry: &Spanned<Vary>,
    place: usize,
    stated: &mut HashMap<(usize, String), String>,
    assignments: &mut Assignments,
) -> Result<Varied, Error> {
    let vary = entry.get_ref();
    let first = vary.variables.first().map(|v| v.get_ref().clone());
    let Some(name) = vary.name.clone().or(first) else {
        let problem = "a quantity without variables and without a name";
        return Err(study.fault(entry, problem, "name it, so that a disturbance can use it"));
    };
    if vary.variables.is_empty() && vary.unit.is_some() {
        let problem = format!("{name} sets no variable, so it has no unit of its own");
        return Err(study.fault(entry, problem, "state the unit where the quantity is used"));
    }
    let mut targets = Vec::new();
    for path in &vary.variables {
        let (index, variable) = settable(study, wired, path, stated, "a [[vary]]")?;
        if variable.kind == Kind::String {
            let hint = "vary numbers, whole numbers and Booleans";
            return Err(study.fault(path, format!("{} is a text", path.get_ref()), hint));
        }
        let convert = conversion(wired, (index, variable), vary.unit.as_deref())
            .map_err(|problem| study.fault(path, problem, UNIT_HINT))?;
        targets.push((path, index, variable, convert));
    }
    let whole = targets.iter().any(|(_, _, variable, _)| variable.kind != Kind::Real);
    let distribution = Distribution::from_study(vary, whole).map_err(|problem| {
        study.fault(entry, format!("{name}: {problem}"), "see the distributions in the example")
    })?;
    let (least, greatest) = distribution.reach();
    for (path, index, variable, convert) in targets {
        let ends = (convert.apply(least), convert.apply(greatest));
        let ordered = (ends.0.min(ends.1), ends.0.max(ends.1));
        within(study, path, variable, ordered)?;
        fits(&distribution, variable, ordered)
            .map_err(|problem| study.fault(path, problem, "use values of the variable's type"))?;
        let assigned = Assigned::Quantity(place, convert);
        assignments.insert((index, variable.name.clone()), assigned);
    }
    let key = Key::new(study.raw.seed, &name);
    Ok(Varied { name, distribution, whole, key, stride: 1 })
}

/// Refuses numbers that are not of the variable's kind.
fn fits(
    distribution: &Distribution,
    variable: &Variable,
    (least, greatest): (f64, f64),
) -> Result<(), String> {
    let values: &[f64] = match distribution {
        Distribution::Choice { values, .. } | Distribution::Points(values) => values,
        _ => &[],
    };
    let (low, high) = match variable.kind {
        Kind::Real | Kind::String => return Ok(()),
        Kind::Integer => (f64::from(i32::MIN), f64::from(i32::MAX)),
        Kind::Boolean => (0.0, 1.0),
    };
    if let Some(bad) = values.iter().find(|value| value.fract() != 0.0) {
        return Err(format!("{bad} is no {}", variable.kind));
    }
    if least < low || greatest > high {
        return Err(format!("{least} to {greatest} is more than a {} takes", variable.kind));
    }
    Ok(())
}
