//! The documentation page of an archive, from the FMU's README and its variables.

use model_description::{Causality, ModelDescription, Table, Value};
use pulldown_cmark::{Options, Parser, html};
use slaves::Fmu;
use std::fmt::Write;

const BEGIN: &str = "<!-- variables:begin -->";
const END: &str = "<!-- variables:end -->";

/// `text` with what stands between its variable marks replaced; unchanged where it has none.
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

/// A table's variables in Markdown, as the READMEs show them.
#[must_use]
pub fn table_markdown(table: &Table) -> String {
    let mut text = String::from("| variable | kind | unit | description |\n|---|---|---|---|\n");
    for row in table.variables {
        let kind = kind(row.causality, row.kind.as_str(), row.variability.as_str());
        let unit = row.unit.unwrap_or("");
        let _ = writeln!(text, "| `{}` | {kind} | {unit} | {} |", row.name, row.description);
    }
    text
}

/// The variables of one archive in Markdown, with their start values.
fn description_markdown(description: &ModelDescription) -> String {
    let mut text =
        String::from("| variable | kind | unit | start | description |\n|---|---|---|---|---|\n");
    for v in &description.variables {
        let kind = kind(v.causality, v.kind.as_str(), v.variability.as_str());
        let start = match &v.start {
            None => String::new(),
            Some(Value::Real(value)) => value.to_string(),
            Some(Value::Integer(value)) => value.to_string(),
            Some(Value::Boolean(value)) => value.to_string(),
            Some(Value::String(value)) => value.clone(),
        };
        let unit = v.unit.as_deref().unwrap_or("");
        let line = v.description.as_deref().unwrap_or("");
        let _ = writeln!(text, "| `{}` | {kind} | {unit} | {start} | {line} |", v.name);
    }
    text
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

/// `documentation/index.html`.
pub(crate) fn page(fmu: Fmu, description: &ModelDescription) -> String {
    let readme = with_variables(fmu.readme(), &description_markdown(description));
    let mut body = String::new();
    html::push_html(&mut body, Parser::new_ext(&readme, Options::ENABLE_TABLES));
    let name = fmu.name();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{name}</title>\n<style>\n\
         body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }}\n\
         pre {{ background: #f4f4f4; padding: 0.8em; overflow-x: auto; line-height: 1.35; }}\n\
         table {{ border-collapse: collapse; }}\n\
         th, td {{ text-align: left; padding: 0.2em 0.8em 0.2em 0; border-bottom: 1px solid #ddd; }}\n\
         </style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    )
}
