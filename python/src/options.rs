//! Keyword arguments as options of the command line: the same names with underscores; numbers are in SI.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};
use steerwright::stages::{OptionDescription, options};

/// Name, value, values, whether repeated, default, help.
pub(crate) type Described = (String, Option<String>, Vec<String>, bool, Option<String>, String);
/// Name and text; no text for a switch.
pub(crate) type Options = Vec<(String, Option<String>)>;

pub(crate) fn described(subcommand: &str) -> PyResult<Vec<Described>> {
    Ok(known(subcommand)?
        .into_iter()
        .map(|o| (o.name, o.value, o.values, o.is_repeated, o.default, o.help))
        .collect())
}

fn known(subcommand: &str) -> PyResult<Vec<OptionDescription>> {
    options(subcommand)
        .ok_or_else(|| PyValueError::new_err(format!("`{subcommand}` is no subcommand")))
}

pub(crate) fn of_keywords(subcommand: &str, keywords: &Bound<'_, PyDict>) -> PyResult<Options> {
    let known = known(subcommand)?;
    let mut all = Vec::new();
    for (name, value) in keywords {
        let keyword: String = name.extract()?;
        let name = keyword.replace('_', "-");
        let Some(option) = known.iter().find(|option| option.name == name) else {
            return Err(PyTypeError::new_err(unknown(subcommand, &keyword, &known)));
        };
        let refused = |problem: String| PyTypeError::new_err(format!("{keyword}: {problem}"));
        if value.is_none() {
            continue;
        }
        if option.value.is_none() {
            let is_set: bool = value.extract().map_err(|_| {
                refused(format!("True or False is expected, not {}", shown(&value)))
            })?;
            if is_set {
                all.push((name, None));
            }
            continue;
        }
        for text in
            texts(option, &value).map_err(|e| refused(e.value(keywords.py()).to_string()))?
        {
            all.push((name.clone(), Some(text)));
        }
    }
    Ok(all)
}

/// The message of an option that does not exist: the one of nearest name, or else all.
fn unknown(subcommand: &str, keyword: &str, known: &[OptionDescription]) -> String {
    let names: Vec<String> = known.iter().map(|o| o.name.replace('-', "_")).collect();
    let nearest = names.iter().map(|name| (edits(keyword, name), name)).min();
    match nearest {
        // Further apart, the names have nothing to do with each other.
        Some((edits, name)) if 3 * edits <= name.len().max(keyword.len()) => format!(
            "no option `{keyword}` of {subcommand}; did you mean `{name}`? \
             steerwright.options(\"{subcommand}\") prints all"
        ),
        _ => format!("no option `{keyword}` of {subcommand}; the options are {}", names.join(", ")),
    }
}

/// How many letters are left out, added or replaced between two names (Levenshtein).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

fn shown(value: &Bound<'_, PyAny>) -> String {
    value.repr().map_or_else(|_| "this".into(), |text| text.to_string())
}

/// The texts of a value: several where the option may be repeated.
fn texts(option: &OptionDescription, value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    if let Ok(pairs) = value.cast::<PyDict>() {
        return pairs
            .iter()
            .map(|(key, value)| Ok(format!("{}={}", plain(&key)?, plain(&value)?)))
            .collect();
    }
    let is_range = option.value.as_deref().is_some_and(|kind| kind.contains(".."));
    if is_range && let Ok((from, to)) = value.extract::<(f64, f64)>() {
        return Ok(vec![range(option, from, to)]);
    }
    let is_text = value.is_instance_of::<PyString>() || value.hasattr("__fspath__")?;
    if !is_text && value.hasattr("__len__")? && value.hasattr("__getitem__")? {
        let items =
            value.try_iter()?.map(|item| texts(option, &item?)).collect::<PyResult<Vec<_>>>()?;
        let items = items.concat();
        return Ok(if option.is_repeated { items } else { vec![items.join(",")] });
    }
    Ok(vec![text(option, value)?])
}

fn range(option: &OptionDescription, from: f64, to: f64) -> String {
    let unit = if option.name.contains("speed") { "m/s" } else { "s" };
    format!("{from}{unit}..{to}{unit}")
}

/// A value as it is written: text, path, number or truth.
fn plain(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(is) = value.cast::<PyBool>() {
        return Ok(if is.is_true() { "true" } else { "false" }.into());
    }
    if value.hasattr("__fspath__")? {
        return value.call_method0("__fspath__")?.extract();
    }
    Ok(value.str()?.to_string())
}

/// A value of one option; numbers get the SI unit of what the option is.
fn text(option: &OptionDescription, value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(is) = value.cast::<PyBool>() {
        return Ok(if is.is_true() { "on" } else { "off" }.into());
    }
    let is_number = value.is_instance_of::<PyFloat>()
        || value.is_instance_of::<PyInt>()
        || (!value.is_instance_of::<PyString>() && value.hasattr("__float__")?);
    if !is_number {
        return plain(value);
    }
    let kind = option.value.as_deref().unwrap_or_default();
    let kind = kind.split('|').next().unwrap_or_default();
    let unit = match kind {
        "TIME" => "s",
        "ANGLE" => "rad",
        "RATE" => "rad/s",
        "LENGTH" => "m",
        "SPEED" => "m/s",
        "ACCELERATION" => "m/s2",
        "PER_SECOND" => "/s",
        "SHARE" => {
            // To 12 digits, since 100 times 0.07 is not 7.
            let percent = 100.0 * value.extract::<f64>()?;
            let digits = format!("{percent:.11e}").parse().unwrap_or(percent);
            return Ok(format!("{digits}%"));
        }
        _ => return plain(value),
    };
    Ok(format!("{}{unit}", value.extract::<f64>()?))
}
