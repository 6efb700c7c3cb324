//! modelDescription.xml: the text, the schema, and the rules that the schema cannot express.

mod document;
mod lexical;
mod schema;
mod semantics;
mod text;
mod types;
mod validate;

use crate::archive::Contents;
use crate::finding::{Findings, Location};
use document::Document;
use model_description::ModelDescription;
use roxmltree::{Node, ParsingOptions};

pub(crate) use text::{DESCRIPTION, nesting};

/// The largest number of elements, texts and comments of a description.
const NODES_LIMIT: u32 = 16_000_000;

pub(crate) fn check(contents: &Contents<'_>, findings: &mut Findings) -> Option<ModelDescription> {
    let text = text::read(contents, findings)?;
    let options = ParsingOptions { nodes_limit: NODES_LIMIT, ..ParsingOptions::default() };
    let tree = match roxmltree::Document::parse_with_options(&text, options) {
        Ok(tree) => tree,
        Err(error) => {
            let mut place = Location::entry(DESCRIPTION);
            (place.line, place.column) = (Some(error.pos().row), Some(error.pos().col));
            match error {
                roxmltree::Error::DtdDetected => {
                    findings.add("xml-refused", place, "it has a document type declaration");
                }
                error => findings.add("xml-malformed", place, error.to_string()),
            }
            return None;
        }
    };
    let document = Document { tree: &tree };
    if let Some(version) = other_version(tree.root_element()) {
        let message = format!("this is FMI {version}; the checker supports 2.0");
        findings.add("fmi-version", document.place(tree.root_element()), message);
        return None;
    }
    let errors = findings.errors();
    validate::validate(&document, findings);
    let valid = findings.errors() == errors;
    match ModelDescription::from_xml(&text) {
        Ok(description) => {
            semantics::check(&document, &description, findings);
            types::check(&document, &description, findings);
            Some(description)
        }
        Err(error) => {
            // The findings of the schema report the same with better locations.
            if valid {
                let place = Location::entry(DESCRIPTION);
                findings.add("xml-unreadable", place, error.to_string());
            }
            None
        }
    }
}

/// The version, if the description is of FMI 1.0 or 3.0, which have other schemas.
fn other_version<'d>(root: Node<'d, '_>) -> Option<&'d str> {
    let version = root.attribute("fmiVersion")?;
    let is_other = ["1.", "3."].iter().any(|head| version.trim().starts_with(head));
    if root.tag_name().name() == "fmiModelDescription" && is_other {
        Some(version.trim())
    } else {
        None
    }
}
