//! The origin of an FMU, from its document: source files, options, fit and quality, without a date. The
//! archive has it as `extra/io.github.steerwright/provenance.json`, as the vendor annotation of the model
//! description and as a section of the documentation page.

use crate::Error;
use model_description::VendorAnnotation;
use quick_xml::escape::escape;
use serde::Serialize;
use serde_json::Value as Json;
use std::collections::BTreeMap;
use std::fmt::Write;
use steerwright_formats::{Fact, Facts, SourceFile, sha256_hex};
use steerwright_units::Fmu;

pub(crate) const TOOL: &str = concat!("steerwright ", env!("CARGO_PKG_VERSION"));

#[derive(Debug, Clone, Serialize)]
pub(crate) struct Origin {
    schema: &'static str,
    fmu: &'static str,
    /// The tool that wrote the archive.
    packed_by: &'static str,
    document: DocumentFacts,
    sources: Vec<SourceFile>,
    options: BTreeMap<String, String>,
    evidence: Vec<Fact>,
}

#[derive(Debug, Clone, Serialize)]
struct DocumentFacts {
    file: String,
    schema: &'static str,
    name: String,
    sha256: String,
    written_by: String,
}

impl Origin {
    pub(crate) fn new(fmu: Fmu, document: &str, file: &str) -> Result<Self, Error> {
        let Facts { name, provenance, evidence } = fmu.facts(document, file)?;
        Ok(Self {
            schema: "steerwright/provenance/1",
            fmu: fmu.name(),
            packed_by: TOOL,
            document: DocumentFacts {
                file: format!("resources/{}", fmu.resource()),
                schema: fmu.schema(),
                name,
                sha256: sha256_hex(document.as_bytes()),
                written_by: match provenance.as_ref() {
                    Some(p) => format!("steerwright {}", p.version),
                    None => "hand".into(),
                },
            },
            sources: provenance.as_ref().map(|p| p.sources.clone()).unwrap_or_default(),
            options: provenance.map(|p| p.options).unwrap_or_default(),
            evidence,
        })
    }

    pub(crate) fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// The vendor annotation of the model description: one element, as the schema allows.
    pub(crate) fn annotation(&self) -> VendorAnnotation {
        let mut xml = String::new();
        let DocumentFacts { file, schema, name, sha256, written_by } = &self.document;
        let _ = write!(xml, "<Provenance packedBy=\"{}\">", escape(self.packed_by));
        let _ = write!(
            xml,
            "\n        <Document file=\"{}\" schema=\"{}\" name=\"{}\" sha256=\"{sha256}\" \
             writtenBy=\"{}\"/>",
            attribute(file),
            attribute(schema),
            attribute(name),
            attribute(written_by)
        );
        for SourceFile { name, sha256, .. } in &self.sources {
            let _ = write!(
                xml,
                "\n        <Source name=\"{}\" sha256=\"{}\"/>",
                attribute(name),
                attribute(sha256)
            );
        }
        for Fact { key, value, unit } in &self.evidence {
            let _ = write!(
                xml,
                "\n        <Evidence key=\"{key}\" value=\"{}\"",
                attribute(&raw(value))
            );
            if !unit.is_empty() {
                let _ = write!(xml, " unit=\"{unit}\"");
            }
            xml.push_str("/>");
        }
        xml.push_str("\n      </Provenance>");
        VendorAnnotation { tool: "steerwright".into(), xml }
    }

    pub(crate) fn markdown(&self) -> String {
        let DocumentFacts { file, name, sha256, written_by, .. } = &self.document;
        let mut text = String::from("| fact | value |\n|---|---|\n");
        let mut row = |label: &str, value: &str| {
            let _ = writeln!(text, "| {} | {} |", cell(label), value);
        };
        row("model", &cell(name));
        row("file", &format!("`{file}`, SHA-256 `{sha256}`, written by {}", cell(written_by)));
        for SourceFile { name, sha256, .. } in &self.sources {
            row("made from", &format!("{}, SHA-256 `{}`", cell(name), cell(sha256)));
        }
        for Fact { key, value, unit } in &self.evidence {
            row(&key.replace('_', " "), &cell(format!("{} {unit}", shown(value)).trim_end()));
        }
        row("packed by", self.packed_by);
        if !self.options.is_empty() {
            let options = self.options.iter().map(|(k, v)| format!("{k} = {v}"));
            row("options", &cell(&options.collect::<Vec<_>>().join(", ")));
        }
        text
    }
}

/// Text inside an attribute: characters illegal in XML become U+FFFD, line ends become spaces.
fn attribute(text: &str) -> String {
    let clean: String = text
        .chars()
        .map(|c| match c {
            '\n' | '\r' | '\t' => ' ',
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
            c => c,
        })
        .collect();
    escape(clean).into_owned()
}

/// Text inside a cell of a Markdown table, taken as it stands.
pub(crate) fn cell(text: &str) -> String {
    let mut cell = String::new();
    for c in text.chars() {
        match c {
            '\n' | '\r' => cell.push(' '),
            '\\' | '|' | '<' | '>' | '&' | '*' | '_' | '`' | '[' | ']' | '#' | '~' | '!' => {
                cell.push('\\');
                cell.push(c);
            }
            c => cell.push(c),
        }
    }
    cell
}

fn raw(value: &Json) -> String {
    match value.as_str() {
        Some(value) => value.to_owned(),
        None => value.to_string(),
    }
}

/// A number to four digits, a truth as yes or no.
fn shown(value: &Json) -> String {
    match value {
        Json::Bool(value) => if *value { "yes" } else { "no" }.into(),
        Json::Number(number) if number.is_f64() => shortened(number.as_f64().unwrap_or_default()),
        value => raw(value),
    }
}

/// A number to four digits.
pub(crate) fn shortened(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        let text = format!("{value:.3e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'));
    }
    #[allow(clippy::cast_possible_truncation)] // between −3 and 5
    let whole = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let digits = usize::try_from(3 - whole).unwrap_or(0);
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
