//! Validation of a document with the table of the schema.

use super::document::Document;
use super::lexical::is_special;
use super::schema::{Attribute, AttributeKind, Content, Element, ROOT, Slot};
use crate::finding::Findings;
use roxmltree::Node;

/// The namespace of the attributes that any element may have.
const INSTANCE: &str = "http://www.w3.org/2001/XMLSchema-instance";

pub(super) fn validate(document: &Document<'_>, findings: &mut Findings) {
    let mut validator = Validator { document, findings };
    let root = document.tree.root_element();
    if is_named(root, ROOT.name) {
        validator.element(root, &ROOT);
    } else {
        validator.report("xsd-element", root, format!("<{}> is expected here", ROOT.name));
    }
}

fn is_named(node: Node<'_, '_>, name: &str) -> bool {
    node.tag_name().namespace().is_none() && node.tag_name().name() == name
}

struct Validator<'a, 'd> {
    document: &'a Document<'d>,
    findings: &'a mut Findings,
}

impl Validator<'_, '_> {
    fn report(&mut self, rule: &'static str, node: Node<'_, '_>, message: String) {
        self.findings.add_at(rule, || self.document.place(node), message);
    }

    /// The recursion is bounded, since elements outside the schema are not entered.
    fn element(&mut self, node: Node<'_, '_>, element: &'static Element) {
        if !matches!(element.content, Content::Anything) {
            self.attributes(node, element.attributes);
        }
        match element.content {
            Content::Anything => self.foreign(node),
            Content::Empty => {
                if let Some(child) = node.children().find(Node::is_element) {
                    let message = format!("<{}> must have no elements", element.name);
                    self.report("xsd-element", child, message);
                }
                if node.children().any(|child| child.is_text()) {
                    self.report("xsd-text", node, format!("<{}> must have no text", element.name));
                }
            }
            Content::One => {
                self.no_text(node);
                if let Some(second) = node.children().filter(Node::is_element).nth(1) {
                    let message = format!("<{}> must have one element only", element.name);
                    self.report("xsd-element", second, message);
                }
                self.foreign(node);
            }
            Content::Slots(slots) => {
                self.no_text(node);
                self.children(node, slots);
            }
        }
    }

    fn no_text(&mut self, node: Node<'_, '_>) {
        let texts = node.children().filter(|child| child.is_text());
        let blank = |text: &str| text.chars().all(|c| " \t\r\n".contains(c));
        if texts.into_iter().any(|text| !text.text().is_none_or(blank)) {
            let message = format!("<{}> must have no text", node.tag_name().name());
            self.report("xsd-text", node, message);
        }
    }

    fn attributes(&mut self, node: Node<'_, '_>, known: &'static [Attribute]) {
        let name = node.tag_name().name();
        for attribute in node.attributes() {
            let (document, findings) = (self.document, &mut *self.findings);
            let place = || document.attribute_place(node, &attribute);
            let mut report = |rule, message: String| findings.add_at(rule, place, message);
            let value = attribute.value();
            match attribute.namespace() {
                Some(INSTANCE)
                    if matches!(
                        attribute.name(),
                        "noNamespaceSchemaLocation" | "schemaLocation"
                    ) => {}
                None => match known.iter().find(|known| known.name == attribute.name()) {
                    None => report(
                        "xsd-attribute",
                        format!("<{name}> has no attribute `{}`", attribute.name()),
                    ),
                    Some(known) if !known.kind.accepts(value) => report(
                        "xsd-value",
                        format!(
                            "`{}` is \"{}\"; expected is {}",
                            known.name,
                            value.chars().take(60).collect::<String>(),
                            known.kind.expected()
                        ),
                    ),
                    Some(known) if known.kind == AttributeKind::Double && is_special(value) => {
                        report("special-value", format!("`{}` is {}", known.name, value.trim()));
                    }
                    Some(_) => {}
                },
                Some(namespace) => report(
                    "xsd-attribute",
                    format!("<{name}> has no attribute `{}` of {namespace}", attribute.name()),
                ),
            }
        }
        for attribute in known.iter().filter(|attribute| attribute.required) {
            if node.attribute(attribute.name).is_none() {
                let message = format!("<{name}> needs the attribute `{}`", attribute.name);
                self.report("xsd-attribute-missing", node, message);
            }
        }
    }

    fn children(&mut self, node: Node<'_, '_>, slots: &'static [Slot]) {
        let mut counts = vec![0_usize; slots.len()];
        let mut present = 0;
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            let found = slots.iter().enumerate().find_map(|(index, slot)| {
                let element = slot.elements.iter().find(|element| is_named(child, element.name))?;
                Some((index, slot, *element))
            });
            let Some((index, slot, element)) = found else {
                let message = format!("<{name}> is not allowed in <{}>", node.tag_name().name());
                self.report("xsd-element", child, message);
                continue;
            };
            counts[index] += 1;
            if counts[index] > slot.max {
                self.report("xsd-element", child, format!("<{name}> is repeated too often"));
            } else if index < present {
                let before = slots[present].elements[0].name;
                let message = format!("<{name}> follows <{before}>, but must precede it");
                self.report("xsd-element", child, message);
            }
            present = present.max(index);
            self.element(child, element);
        }
        for (slot, count) in slots.iter().zip(counts) {
            if count < slot.min {
                let names: Vec<&str> = slot.elements.iter().map(|element| element.name).collect();
                let message = format!(
                    "<{}> needs an element {}",
                    node.tag_name().name(),
                    names.join(", ").replace(", ", " or ")
                );
                self.report("xsd-element-missing", node, message);
            }
        }
    }

    /// Content outside the schema is allowed, except the one element that it declares globally.
    fn foreign(&mut self, node: Node<'_, '_>) {
        for inner in node.descendants().skip(1).filter(|inner| is_named(*inner, ROOT.name)) {
            // Report only the outermost one.
            if inner
                .ancestors()
                .skip(1)
                .take_while(|outer| *outer != node)
                .all(|outer| !is_named(outer, ROOT.name))
            {
                self.report("xsd-element", inner, "a model description inside another one".into());
            }
        }
    }
}
