//! Keyword arguments as options of the command line: the same names with underscores; numbers are in SI.

use crate::work::raised;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyInt, PyString};
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
        let refused =
            |Refused { problem, hint }| raised(keywords.py(), "ArgumentError", &problem, &hint);
        let Some(option) = known.iter().find(|option| option.name == name) else {
            return Err(refused(unknown(subcommand, &keyword, &known)));
        };
        if value.is_none() {
            continue;
        }
        if option.value.is_none() {
            let is_set: bool = value.extract().map_err(|_| {
                let problem = format!("{keyword}: {} is neither True nor False", shown(&value));
                refused(Refused { problem, hint: format!("write {keyword}=True") })
            })?;
            if is_set {
                all.push((name, None));
            }
            continue;
        }
        for text in texts(option, &value)?.map_err(|(problem, hint)| {
            refused(Refused {
                problem: format!("{keyword}={problem}"),
                hint: format!("write {keyword}={hint}"),
            })
        })? {
            all.push((name.clone(), Some(text)));
        }
    }
    Ok(all)
}

/// Why keywords are refused, and what to write instead.
struct Refused {
    problem: String,
    hint: String,
}

/// An option that does not exist: the one of nearest name, or else all.
fn unknown(subcommand: &str, keyword: &str, known: &[OptionDescription]) -> Refused {
    let names: Vec<String> = known.iter().map(|o| o.name.replace('-', "_")).collect();
    let nearest = names.iter().map(|name| (edits(keyword, name), name)).min();
    let others = match nearest {
        // Further apart, the names have nothing to do with each other.
        Some((edits, name)) if 3 * edits <= name.len().max(keyword.len()) => {
            format!("did you mean `{name}`?")
        }
        _ => format!("the options are {}", names.join(", ")),
    };
    Refused {
        problem: format!("no option `{keyword}` of {subcommand}; {others}"),
        hint: format!("steerwright.options(\"{subcommand}\") prints all"),
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

/// What is refused of a value, and what to write instead, both after the name of the option and `=`.
type Accepted<T> = PyResult<Result<T, (String, String)>>;

/// The texts of a value: several where the option may be repeated.
fn texts(option: &OptionDescription, value: &Bound<'_, PyAny>) -> Accepted<Vec<String>> {
    if let Ok(pairs) = value.cast::<PyDict>() {
        let texts =
            pairs.iter().map(|(key, value)| Ok(format!("{}={}", plain(&key)?, plain(&value)?)));
        return Ok(Ok(texts.collect::<PyResult<_>>()?));
    }
    let is_text = value.is_instance_of::<PyString>() || value.hasattr("__fspath__")?;
    if is_text || !value.hasattr("__len__")? || !value.hasattr("__getitem__")? {
        return Ok(text(option, value)?.map(|text| vec![text]));
    }
    let items: Vec<_> = value.try_iter()?.collect::<PyResult<_>>()?;
    let is_range = matches!(option.value.as_deref(), Some("RANGE" | "FROM..TO"));
    let is_bound = |item: &Bound<'_, PyAny>| {
        item.extract::<f64>().is_ok()
            || item.extract::<&str>().is_ok_and(|text| !text.contains(".."))
    };
    if is_range && items.iter().all(is_bound) {
        let [from, to] = &items[..] else {
            let problem = format!("{}: a range is a pair", shown(value));
            return Ok(Err((
                problem,
                if option.name.contains("speed") { "(5, 30)" } else { "(10, 60)" }.into(),
            )));
        };
        return Ok(Ok(vec![format!("{}..{}", bound(option, from)?, bound(option, to)?)]));
    }
    let mut texts = Vec::new();
    for item in &items {
        match self::texts(option, item)? {
            Ok(more) => texts.extend(more),
            refused => return Ok(refused),
        }
    }
    Ok(Ok(if option.is_repeated { texts } else { vec![texts.join(",")] }))
}

/// An end of a range, with its unit.
fn bound(option: &OptionDescription, value: &Bound<'_, PyAny>) -> PyResult<String> {
    if value.is_instance_of::<PyString>() {
        return Ok(value.extract::<String>()?.replace(' ', ""));
    }
    let unit = match option.name.as_str() {
        "band" => "Hz",
        name if name.contains("speed") => "m/s",
        _ => "s",
    };
    Ok(format!("{}{unit}", value.extract::<f64>()?))
}

/// A value as it is written: text, path, number or truth; a pair as two of them.
fn plain(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(is) = value.extract::<bool>() {
        return Ok(if is { "true" } else { "false" }.into());
    }
    if value.hasattr("__fspath__")? {
        return value.call_method0("__fspath__")?.extract();
    }
    if let Ok((first, second)) = value.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>() {
        return Ok(format!("{},{}", plain(&first)?, plain(&second)?));
    }
    Ok(value.str()?.to_string())
}

/// A value of one option; numbers get the SI unit of what the option is.
fn text(option: &OptionDescription, value: &Bound<'_, PyAny>) -> Accepted<String> {
    let kind = option.value.as_deref().unwrap_or_default();
    // Of Python or NumPy.
    if let Ok(is) = value.extract::<bool>() {
        if kind.split('|').any(|word| word == "on") {
            return Ok(Ok(if is { "on" } else { "off" }.into()));
        }
        return Ok(Err((
            format!("{}: {kind} is expected", shown(value)),
            format!("{kind} or leave it out"),
        )));
    }
    let is_number = value.is_instance_of::<PyFloat>()
        || value.is_instance_of::<PyInt>()
        || (!value.is_instance_of::<PyString>() && value.hasattr("__float__")?);
    if !is_number {
        return Ok(Ok(plain(value)?));
    }
    let unit = match kind.split('|').next().unwrap_or_default() {
        "TIME" => "s",
        "ANGLE" => "rad",
        "RATE" => "rad/s",
        "LENGTH" => "m",
        "SPEED" => "m/s",
        "ACCELERATION" => "m/s2",
        "JERK" => "m/s3",
        "GRADIENT" => "rad.s2/m",
        "PER_SECOND" => "/s",
        "SHARE" => {
            let share = value.extract::<f64>()?;
            let percent = to_12_digits(100.0 * share);
            if share > 1.0 {
                let problem =
                    format!("{share}: a share is a fraction, at most 1, and this is {percent} %");
                return Ok(Err((problem, format!("{}", to_12_digits(share / 100.0)))));
            }
            return Ok(Ok(format!("{percent}%")));
        }
        _ => return Ok(Ok(plain(value)?)),
    };
    Ok(Ok(format!("{}{unit}", value.extract::<f64>()?)))
}

/// Rounded, since 100 times 0.07 is not 7.
fn to_12_digits(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
