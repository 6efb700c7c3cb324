//! Rules on types and attributes that `model-description` does not check.

use super::document::{Document, children, items};
use crate::finding::Findings;
use model_description::{Causality, ModelDescription};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// Reports violations of the rules for types and for some attributes.
pub(super) fn check(
    document: &Document<'_>,
    description: &ModelDescription,
    findings: &mut Findings,
) {
    let mut check = Check { document, description, findings, types: BTreeMap::new() };
    check.header();
    check.types();
    let root = document.tree.root_element();
    for variable in items(root, "ModelVariables", "ScalarVariable") {
        check.variable(variable);
    }
}

struct Check<'a, 'd> {
    document: &'a Document<'d>,
    description: &'a ModelDescription,
    findings: &'a mut Findings,
    types: BTreeMap<&'a str, Node<'a, 'd>>,
}

impl<'a, 'd> Check<'a, 'd> {
    fn report(&mut self, rule: &'static str, node: Node<'_, '_>, message: impl Into<String>) {
        self.findings.add_at(rule, || self.document.place(node), message);
    }

    fn header(&mut self) {
        let root = self.document.tree.root_element();
        for name in ["ModelExchange", "CoSimulation"] {
            if let Some(second) = children(root, name).nth(1) {
                self.report("interface-twice", second, format!("a second <{name}>"));
            }
        }
        if self.description.co_simulation.is_none() && self.description.model_exchange.is_some() {
            self.report("not-co-simulation", root, "<CoSimulation> is missing");
        }
        let guid = self.description.guid.as_str();
        if guid.trim().is_empty() {
            self.report("guid-empty", root, "the guid is empty");
        } else if guid.starts_with('{') {
            self.report("guid-braces", root, "the guid is in braces");
        }
        if let Some(date) = root.attribute("generationDateAndTime") {
            let shape = date.bytes().map(|b| if b.is_ascii_digit() { b'0' } else { b });
            if !shape.eq(*b"0000-00-00T00:00:00Z") {
                let message = format!("generationDateAndTime is \"{date}\"");
                self.report("date-format", root, message);
            }
        }
        let time = self.description.variable("time");
        let is_clash = time.is_some_and(|time| time.causality != Causality::Independent)
            && self.description.variables.iter().all(|v| v.causality != Causality::Independent);
        if is_clash
            && let Some(node) = items(root, "ModelVariables", "ScalarVariable")
                .find(|node| node.attribute("name") == Some("time"))
        {
            let message = "the implicit independent variable has this name too";
            self.report("name-time", node, message);
        }
        for unit in items(root, "UnitDefinitions", "Unit") {
            for scaled in unit.children().filter(|child| child.attribute("factor").is_some()) {
                if scaled.attribute("factor").is_some_and(|f| f.trim().parse() == Ok(0.0)) {
                    self.report("unit-factor", scaled, "the factor is zero");
                }
            }
        }
    }

    fn types(&mut self) {
        let root = self.document.tree.root_element();
        let variables: BTreeSet<&str> =
            self.description.variables.iter().map(|v| v.name.as_str()).collect();
        for simple in items(root, "TypeDefinitions", "SimpleType") {
            let Some(name) = simple.attribute("name") else { continue };
            if variables.contains(name) {
                self.report("type-named-as-variable", simple, "a variable has this name too");
            }
            let Some(element) = simple.children().find(Node::is_element) else { continue };
            if self.types.insert(name, element).is_some() {
                self.report("type-twice", simple, "the name is used twice");
            }
            self.limits(element);
            self.unit(element);
            if let Some(nominal) = real(element, "nominal").filter(|n| n.is_nan() || *n <= 0.0) {
                self.report("nominal", element, format!("nominal {nominal} is not positive"));
            }
            let (mut names, mut values) = (BTreeSet::new(), BTreeSet::new());
            for item in children(element, "Item") {
                if !item.attribute("name").is_none_or(|name| names.insert(name)) {
                    self.report("enumeration-item-twice", item, "the name is used twice");
                }
                if !integer(item, "value").is_none_or(|value| values.insert(value)) {
                    self.report("enumeration-item-twice", item, "the value is used twice");
                }
            }
        }
    }

    fn limits(&mut self, element: Node<'_, '_>) {
        if let (Some(min), Some(max)) = (real(element, "min"), real(element, "max"))
            && min > max
        {
            self.report("min-above-max", element, format!("min {min} exceeds max {max}"));
        }
    }

    fn unit(&mut self, element: Node<'_, '_>) {
        let unit = element.attribute("unit");
        let defined = unit.map(|unit| self.description.units.iter().find(|u| u.name == unit));
        match (defined, element.attribute("displayUnit")) {
            (None, Some(display)) => {
                let message = format!("displayUnit \"{display}\" without a unit");
                self.report("display-unit-without-unit", element, message);
            }
            (Some(None), _) => {
                let message = format!("unit \"{}\" is not defined", unit.unwrap_or_default());
                self.report("unit-undefined", element, message);
            }
            (Some(Some(unit)), Some(display))
                if unit.name != display
                    && unit.display_units.iter().all(|known| known.name != display) =>
            {
                let message = format!("unit \"{}\" has no displayUnit \"{display}\"", unit.name);
                self.report("display-unit-undefined", element, message);
            }
            _ => {}
        }
    }

    fn variable(&mut self, variable: Node<'_, '_>) {
        let mut tools = BTreeSet::new();
        for tool in items(variable, "Annotations", "Tool") {
            if !tool.attribute("name").is_none_or(|name| tools.insert(name)) {
                self.report("annotation-twice", tool, "the name is used twice");
            }
        }
        const KINDS: [&str; 5] = ["Real", "Integer", "Boolean", "String", "Enumeration"];
        let Some(element) =
            variable.children().find(|child| KINDS.contains(&child.tag_name().name()))
        else {
            return;
        };
        if element.has_attribute("reinit") && self.description.model_exchange.is_none() {
            self.report("reinit", element, "reinit is only for ModelExchange");
        }
        let Some(name) = element.attribute("declaredType") else { return };
        let kind = element.tag_name().name();
        let Some(declared) = self.types.get(name).copied() else {
            let message =
                format!("its declaredType \"{name}\" is not defined under TypeDefinitions");
            return self.report("declared-type-undefined", variable, message);
        };
        let declared_kind = declared.tag_name().name();
        if declared_kind != kind {
            let message =
                format!("its type is {kind}, but its declaredType \"{name}\" is {declared_kind}");
            self.report("declared-type-kind", variable, message);
        } else if kind == "Enumeration"
            && let Some(start) = integer(element, "start")
            && children(declared, "Item").all(|item| integer(item, "value") != Some(start))
        {
            let message = format!("its start {start} is not the value of an item of \"{name}\"");
            self.report("enumeration-start", variable, message);
        }
    }
}

fn real(element: Node<'_, '_>, attribute: &str) -> Option<f64> {
    element.attribute(attribute)?.trim().parse().ok()
}

fn integer(element: Node<'_, '_>, attribute: &str) -> Option<i32> {
    element.attribute(attribute)?.trim().parse().ok()
}
