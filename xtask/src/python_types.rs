//! The documents as typed classes of the Python package, from the types of the crate `formats`.

use super::formats::{self, Described};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = "\
\"\"\"The JSON documents, typed. Generated from the crate `formats` by `cargo xtask docs --update`.

Angles are in rad, signs follow ISO 8855; other units are in the names of the keys or in their descriptions.
\"\"\"

from __future__ import annotations

from typing import Any, Literal, Union

from ._record import Array, Record
";

const KEYWORDS: [&str; 4] = ["pass", "from", "in", "is"];

/// The Python module; `sources` is the folder of the crate `formats`.
pub(crate) fn module(sources: &Path) -> Result<String, String> {
    let types = formats::types(sources)?;
    let known: BTreeSet<&str> = types.iter().map(|(name, _)| name.as_str()).collect();
    let mut text = HEAD.to_owned();
    for (name, described) in types.iter().filter(|(_, of)| !of.is_struct) {
        let values: Vec<_> =
            described.rows.iter().map(|(value, ..)| format!("\"{value}\"")).collect();
        let _ = write!(text, "\n{name} = Literal[\n");
        values.iter().for_each(|value| text += &format!("    {value},\n"));
        let _ = writeln!(text, "]\n{}", documented("", described));
    }
    for (name, described) in types.iter().filter(|(_, of)| of.is_struct) {
        let _ = writeln!(text, "\n\nclass {name}(Record):\n{}\n", documented("    ", described));
        for (key, kind, description) in &described.rows {
            // The keywords of Python have an underscore more.
            let reserved = if KEYWORDS.contains(&key.as_str()) { "_" } else { "" };
            let _ = writeln!(text, "    {key}{reserved}: {}", python(kind, &known)?);
            let description = description.replace('\\', "\\\\");
            let _ = writeln!(text, "    \"\"\"{}\"\"\"", wrapped(&description, "    "));
        }
    }
    Ok(text)
}

fn documented(indent: &str, described: &Described) -> String {
    let text = described.text.replace('\\', "\\\\");
    format!("{indent}\"\"\"{}\"\"\"", wrapped(&text, indent))
}

/// Lines of at most 110 characters.
fn wrapped(text: &str, indent: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last().map_or(0, |line| line.chars().count());
        if last > 0 && last + word.chars().count() > 100 {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.join(&format!("\n{indent}"))
}

/// A type in words as a type of Python.
fn python(words: &str, known: &BTreeSet<&str>) -> Result<String, String> {
    if let Some(rest) = words.strip_suffix(", optional") {
        return Ok(format!("Union[{}, None]", python(rest, known)?));
    }
    if let Some(item) = words.strip_prefix("list of ") {
        let is_numbers = item.trim_start_matches("list of ") == "number";
        return Ok(if is_numbers {
            "Array".into()
        } else {
            format!("tuple[{}, ...]", python(item, known)?)
        });
    }
    Ok(match words {
        "number" => "float".into(),
        "integer" => "int".into(),
        "true or false" => "bool".into(),
        "text" => "str".into(),
        "BTreeMap" => "dict[str, Any]".into(),
        _ if words.starts_with("matrix") => "Array".into(),
        _ if known.contains(words) => words.into(),
        _ => return Err(format!("a type `{words}` in formats that Python has no type for")),
    })
}
