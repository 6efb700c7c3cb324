//! The elements of a package's XML files: found by namespace and name, errors with file and line.

use model_description::Excess;
use roxmltree::{Document, Node, ParsingOptions};

use super::structure::SspPlace;
use crate::Error;

/// Elements, texts and comments a file may have.
const NODES_LIMIT: u32 = 4_000_000;

/// A file of a package, for messages: `loop.ssp: SystemStructure.ssd`.
#[derive(Clone, Copy)]
pub(super) struct File<'a> {
    pub(super) package: &'a str,
    pub(super) name: &'a str,
    /// Where its lines end: a parser counts them from the start for each place that it is asked for.
    pub(super) line_ends: &'a [usize],
}

/// The places of the line feeds in a text.
pub(super) fn line_ends(text: &str) -> Vec<usize> {
    text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect()
}

/// A text without a byte order mark.
pub(super) fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

impl File<'_> {
    pub(super) fn error(self, line: u32, problem: impl Into<String>) -> Error {
        Error::SystemStructure {
            package: self.package.to_owned(),
            file: self.name.to_owned(),
            line,
            problem: problem.into(),
        }
    }

    pub(super) fn parse(self, text: &str) -> Result<Document<'_>, Error> {
        let options = ParsingOptions { nodes_limit: NODES_LIMIT, ..ParsingOptions::default() };
        if let Some(Excess { kind, line }) = Excess::find(text) {
            return Err(self.error(line, kind.to_string()));
        }
        Document::parse_with_options(text, options)
            .map_err(|error| self.error(error.pos().row, error.to_string()))
    }
}

/// An element and the file it is of.
#[derive(Clone, Copy)]
pub(super) struct Element<'a, 'input> {
    pub(super) node: Node<'a, 'input>,
    pub(super) file: File<'a>,
}

impl<'a, 'input> Element<'a, 'input> {
    pub(super) fn is(self, namespace: &str, name: &str) -> bool {
        self.node.tag_name().namespace() == Some(namespace) && self.node.tag_name().name() == name
    }

    pub(super) fn children(self) -> impl Iterator<Item = Element<'a, 'input>> {
        let file = self.file;
        self.node.children().filter(Node::is_element).map(move |node| Element { node, file })
    }

    pub(super) fn child(
        self,
        namespace: &'static str,
        name: &'static str,
    ) -> Option<Element<'a, 'input>> {
        self.children().find(|child| child.is(namespace, name))
    }

    /// The children of the child of that name, if there is one.
    pub(super) fn inside(
        self,
        namespace: &'static str,
        name: &'static str,
    ) -> impl Iterator<Item = Element<'a, 'input>> {
        self.child(namespace, name).into_iter().flat_map(Element::children)
    }

    pub(super) fn line(self) -> u32 {
        let start = self.node.range().start;
        1 + self.file.line_ends.partition_point(|end| *end < start) as u32
    }

    pub(super) fn place(self) -> SspPlace {
        SspPlace { file: self.file.name.to_owned(), line: self.line() }
    }

    pub(super) fn error(self, problem: impl Into<String>) -> Error {
        self.file.error(self.line(), problem)
    }

    pub(super) fn not_supported(self, what: impl Into<String>) -> Error {
        Error::SystemNotSupported {
            package: self.file.package.to_owned(),
            file: self.file.name.to_owned(),
            line: self.line(),
            what: what.into(),
        }
    }

    pub(super) fn optional(self, name: &str) -> Option<&'a str> {
        self.node.attribute(name)
    }

    pub(super) fn attribute(self, name: &str) -> Result<&'a str, Error> {
        self.optional(name).ok_or_else(|| {
            self.error(format!("<{}> has no attribute {name}", self.node.tag_name().name()))
        })
    }

    /// A finite number.
    pub(super) fn number(self, name: &str) -> Result<Option<f64>, Error> {
        let Some(text) = self.optional(name) else { return Ok(None) };
        match text.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(self.error(format!("{name} is {text:?}, not a finite number"))),
        }
    }
}
