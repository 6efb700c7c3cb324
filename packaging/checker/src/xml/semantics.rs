//! The rules of `model-description`, with the locations of their findings.

use super::document::{Document, child, children, items};
use crate::finding::{Findings, Location};
use model_description::{FindingPlace, ModelDescription};
use roxmltree::Node;

pub(super) fn check(
    document: &Document<'_>,
    description: &ModelDescription,
    findings: &mut Findings,
) {
    let places = Places::new(document);
    for finding in description.findings() {
        let message = match finding.variable {
            Some(name) => format!("`{name}`: {}", finding.message),
            None => finding.message,
        };
        findings.add_at(finding.rule, || places.location(finding.place), message);
    }
}

/// The elements that rules refer to, in document order.
struct Places<'a, 'd> {
    document: &'a Document<'d>,
    root: Node<'a, 'd>,
    variables: Vec<Node<'a, 'd>>,
}

impl<'a, 'd> Places<'a, 'd> {
    fn new(document: &'a Document<'d>) -> Self {
        let root = document.tree.root_element();
        let variables = items(root, "ModelVariables", "ScalarVariable").collect();
        Self { document, root, variables }
    }

    fn location(&self, place: FindingPlace) -> Location {
        let node = match place {
            FindingPlace::Root => None,
            FindingPlace::CoSimulation => child(self.root, "CoSimulation"),
            FindingPlace::DefaultExperiment => child(self.root, "DefaultExperiment"),
            FindingPlace::LogCategory(n) => items(self.root, "LogCategories", "Category").nth(n),
            FindingPlace::Unit(n) => items(self.root, "UnitDefinitions", "Unit").nth(n),
            FindingPlace::DisplayUnit { unit, position } => {
                items(self.root, "UnitDefinitions", "Unit")
                    .nth(unit)
                    .and_then(|unit| children(unit, "DisplayUnit").nth(position))
            }
            FindingPlace::VendorAnnotation(n) => {
                items(self.root, "VendorAnnotations", "Tool").nth(n)
            }
            FindingPlace::Variable(n) => self.variables.get(n).copied(),
            FindingPlace::List(list) => self.list(list.as_str()),
            FindingPlace::Unknown { list, position } => {
                self.list(list.as_str()).and_then(|list| children(list, "Unknown").nth(position))
            }
        };
        self.document.place(node.unwrap_or(self.root))
    }

    fn list(&self, name: &str) -> Option<Node<'a, 'd>> {
        child(child(self.root, "ModelStructure")?, name)
    }
}
