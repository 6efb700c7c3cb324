//! modelDescription.xml: the text, the schema, and the rules beyond it.

mod lexical;
mod schema;
mod semantics;
mod text;
mod types;
mod validate;

use crate::archive::Contents;
use crate::finding::{Findings, Location};
use model_description::ModelDescription;
use roxmltree::{Attribute, Node, ParsingOptions};

pub(crate) use text::{DESCRIPTION, nesting};

/// Elements, texts and comments a description may have.
const NODES_LIMIT: u32 = 16_000_000;

/// A parsed description, and where things are in it.
struct Document<'d> {
    tree: &'d roxmltree::Document<'d>,
}

impl Document<'_> {
    fn location(&self, at: usize, node: Node<'_, '_>) -> Location {
        let place = self.tree.text_pos_at(at);
        let name = node.attribute("name").or_else(|| node.attribute("index"));
        let key = if node.has_attribute("name") { "name" } else { "index" };
        let tag = node.tag_name().name();
        let element = match name {
            Some(name) => {
                format!("<{tag} {key}=\"{}\">", name.chars().take(80).collect::<String>())
            }
            None => format!("<{tag}>"),
        };
        Location {
            entry: Some(DESCRIPTION.into()),
            line: Some(place.row),
            column: Some(place.col),
            element: Some(element),
        }
    }

    fn place(&self, node: Node<'_, '_>) -> Location {
        self.location(node.range().start, node)
    }

    fn attribute_place(&self, node: Node<'_, '_>, attribute: &Attribute<'_, '_>) -> Location {
        self.location(attribute.range().start, node)
    }
}

/// Checks the description; gives it back where it can be read.
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
        let message = format!("this is FMI {version}, the checker supports 2.0");
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
            // The schema's findings report the same with better places.
            if valid {
                let place = Location::entry(DESCRIPTION);
                findings.add("xml-unreadable", place, error.to_string());
            }
            None
        }
    }
}

/// The version, where the description is of FMI 1.0 or 3.0 which our schema does not cover.
fn other_version<'d>(root: Node<'d, '_>) -> Option<&'d str> {
    let version = root.attribute("fmiVersion")?;
    let is_other = ["1.", "3."].iter().any(|head| version.trim().starts_with(head));
    (root.tag_name().name() == "fmiModelDescription" && is_other).then_some(version.trim())
}
