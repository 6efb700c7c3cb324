//! The parsed description: locations of its nodes, and their child elements.

use super::text::DESCRIPTION;
use crate::finding::Location;
use roxmltree::{Attribute, Node};

pub(super) struct Document<'d> {
    pub(super) tree: &'d roxmltree::Document<'d>,
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

    pub(super) fn place(&self, node: Node<'_, '_>) -> Location {
        self.location(node.range().start, node)
    }

    pub(super) fn attribute_place(
        &self,
        node: Node<'_, '_>,
        attribute: &Attribute<'_, '_>,
    ) -> Location {
        self.location(attribute.range().start, node)
    }
}

pub(super) fn children<'a, 'd>(
    node: Node<'a, 'd>,
    name: &str,
) -> impl Iterator<Item = Node<'a, 'd>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

pub(super) fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    children(node, name).next()
}

pub(super) fn items<'a, 'd>(
    root: Node<'a, 'd>,
    list: &str,
    item: &str,
) -> impl Iterator<Item = Node<'a, 'd>> {
    child(root, list).into_iter().flat_map(move |list| children(list, item))
}
