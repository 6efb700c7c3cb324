//! The documentation page of an archive, from the FMU's README, its variables and its origin.

use crate::platform::Platform;
use crate::provenance::{Origin, cell, shortened};
use model_description::{Causality, ModelDescription, Table, Value, Variable};
use pulldown_cmark::{Options, Parser, html};
use std::fmt::Write;
use steerwright_units::Fmu;

const BEGIN: &str = "<!-- variables:begin -->";
const END: &str = "<!-- variables:end -->";

/// `text` with the part between its variable marks replaced; unchanged without marks.
#[must_use]
pub fn with_variables(text: &str, variables: &str) -> String {
    match (text.find(BEGIN), text.find(END)) {
        (Some(begin), Some(end)) if begin < end => {
            let (head, tail) = (&text[..begin + BEGIN.len()], &text[end..]);
            format!("{head}\n{variables}{tail}")
        }
        _ => text.to_owned(),
    }
}

/// A table's variables in Markdown, as the READMEs show them. Of rows with the same name but for a number, as channels have
/// them, the first stands for all.
#[must_use]
pub fn table_markdown(table: &Table) -> String {
    let mut text = String::from("| variable | kind | unit | description |\n|---|---|---|---|\n");
    for row in table.variables {
        let number = row.name.rsplit_once('_').and_then(|(_, end)| end.parse::<u32>().ok());
        if number.is_some_and(|number| number > 1) {
            continue;
        }
        let further = if number.is_some() { " …" } else { "" };
        let kind = kind(row.causality, row.kind.as_str(), row.variability.as_str());
        let unit = row.unit.unwrap_or("");
        let _ =
            writeln!(text, "| `{}`{further} | {kind} | {unit} | {} |", row.name, row.description);
    }
    text
}

/// The variables of one archive in Markdown, with limits, start values and display units.
fn description_markdown(description: &ModelDescription) -> String {
    let mut text = String::from(
        "| variable | kind | unit | start | limits | description |\n|---|---|---|---|---|---|\n",
    );
    for v in &description.variables {
        let kind = kind(v.causality, v.kind.as_str(), v.variability.as_str());
        let start = match &v.start {
            None => String::new(),
            Some(Value::Real(value)) => match displayed(description, v, *value) {
                Some(text) => format!("{} ({text})", brief(*value)),
                None => brief(*value),
            },
            Some(Value::Integer(value)) => value.to_string(),
            Some(Value::Boolean(value)) => value.to_string(),
            Some(Value::String(value)) => cell(value),
        };
        let limits = match (v.min, v.max) {
            (None, None) => String::new(),
            (Some(min), None) => format!("≥\u{a0}{}", brief(min)),
            (None, Some(max)) => format!("≤\u{a0}{}", brief(max)),
            (Some(min), Some(max)) => format!("{} … {}", brief(min), brief(max)),
        };
        let unit = match (&v.unit, &v.display_unit) {
            (Some(unit), Some(display)) => format!("{unit} ({display})"),
            (unit, _) => unit.clone().unwrap_or_default(),
        };
        let line = cell(v.description.as_deref().unwrap_or(""));
        let _ = writeln!(text, "| `{}` | {kind} | {unit} | {start} | {limits} | {line} |", v.name);
    }
    text
}

/// A value in full where that is short, else to four digits; the XML has them all.
fn brief(value: f64) -> String {
    Some(value.to_string()).filter(|text| text.len() <= 8).unwrap_or_else(|| shortened(value))
}

/// A value in the variable's display unit, to four digits; nothing for zero, which is zero in any.
fn displayed(description: &ModelDescription, variable: &Variable, value: f64) -> Option<String> {
    let name = variable.display_unit.as_deref()?;
    let unit = description.units.iter().find(|u| Some(&u.name) == variable.unit.as_ref())?;
    let display = unit.display_units.iter().find(|d| d.name == name)?;
    let shown = display.factor * value + display.offset;
    if shown != 0.0 { Some(format!("{}\u{a0}{name}", shortened(shown))) } else { None }
}

pub(crate) struct Sections<'a> {
    pub(crate) origin: &'a Origin,
    /// Folders below `binaries/`, each with its platform.
    pub(crate) platforms: &'a [(String, Platform)],
    /// Where the reference run's files are, seen from the archive's root.
    pub(crate) extra: &'a str,
}

impl Sections<'_> {
    fn markdown(&self, name: &str) -> String {
        let extra = self.extra;
        let mut text = format!(
            "\n## Where it came from\n\n{}\nThe same facts, for programs: \
             [provenance.json](../{extra}/provenance.json).\n\n## Libraries\n\n\
             | file | platform | standing |\n|---|---|---|\n",
            self.origin.markdown()
        );
        for (folder, platform) in self.platforms {
            let (end, title) = (platform.extension(), platform.title());
            let file = format!("binaries/{folder}/{name}.{end}");
            let _ = writeln!(text, "| `{file}` | {title} | {} |", platform.standing());
        }
        let _ = write!(
            text,
            "\nThey load libraries of the system alone: on Linux the C library and libgcc_s.\n\n## Reference run\n\n\
             The inputs of [input.csv](../{extra}/reference/input.csv) give the outputs of \
             [result.csv](../{extra}/reference/result.csv), within the tolerance that \
             [reference.json](../{extra}/reference/reference.json) names. A row of inputs is set at \
             its time and holds until the next, the first one before the initialization ends; a row \
             of results is what was read at its time before new inputs were set. Times are seconds, \
             Booleans 0 or 1.\n\n## Licences\n\n\
             MIT OR Apache-2.0; [license.txt](licenses/license.txt) has the licences of all code in \
             the libraries.\n"
        );
        text
    }
}

/// `input`, `output, Boolean`, `parameter, tunable` …
fn kind(causality: Causality, kind: &str, variability: &str) -> String {
    let mut words = vec![causality.as_str()];
    if kind != "Real" {
        words.push(kind);
    }
    if causality == Causality::Parameter {
        words.push(variability);
    }
    words.join(", ")
}

const STYLE: &str = include_str!("style.css");

/// `documentation/index.html`: one file that loads nothing, with links into the archive.
pub(crate) fn page(fmu: Fmu, description: &ModelDescription, sections: &Sections<'_>) -> String {
    let name = fmu.name();
    let mut text = with_variables(fmu.readme(), &description_markdown(description));
    text.push_str(&sections.markdown(name));
    let mut body = String::new();
    html::push_html(&mut body, Parser::new_ext(&text, Options::ENABLE_TABLES));
    let body = body
        .replacen("<h1>", "<h1><img src=\"../model.png\" alt=\"\">", 1)
        // A table may be wider than the page: it scrolls by itself.
        .replace("<table>", "<div class=\"wide\"><table>")
        .replace("</table>", "</table></div>");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    )
}
