//! What a text must not have, so that it is parsed in a time that grows with its length, on a stack of usual size.

use std::fmt;

/// The largest number of attributes of an element; a parser compares each pair.
const MOST_ATTRIBUTES: usize = 1000;
/// The deepest nesting of elements. The schema's own depth is 5; annotations may be deeper.
const DEEPEST: usize = 256;

/// What is too much.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExcessKind {
    /// Attributes of an element.
    Attributes,
    /// Elements in each other.
    Depth,
}

impl fmt::Display for ExcessKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Attributes => write!(f, "an element has more than {MOST_ATTRIBUTES} attributes"),
            Self::Depth => write!(f, "its elements are nested more than {DEEPEST} deep"),
        }
    }
}

/// The first place of an XML text with too much.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Excess {
    /// What it is.
    pub kind: ExcessKind,
    /// The line, from 1.
    pub line: u32,
}

impl Excess {
    /// Counts attributes and open elements, without parsing the text.
    #[must_use]
    pub fn find(text: &str) -> Option<Self> {
        let (kind, at) = place(text)?;
        let line = 1 + text.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count();
        Some(Self { kind, line: line as u32 })
    }
}

fn place(text: &str) -> Option<(ExcessKind, usize)> {
    let bytes = text.as_bytes();
    let mut depth = 0_usize;
    let mut at = 0;
    while let Some(open) = bytes[at..].iter().position(|b| *b == b'<') {
        at += open + 1;
        let rest = &text[at..];
        // Comments, CDATA and processing instructions contain no elements.
        let skip = |end: &str| rest.find(end).map_or(rest.len(), |found| found + end.len());
        if rest.starts_with("!--") {
            at += skip("-->");
        } else if rest.starts_with("![CDATA[") {
            at += skip("]]>");
        } else if rest.starts_with('?') {
            at += skip("?>");
        } else if rest.starts_with('/') {
            depth = depth.saturating_sub(1);
        } else if !rest.starts_with('!') {
            let (end, attributes) = tag_end(rest.as_bytes());
            if attributes > MOST_ATTRIBUTES {
                return Some((ExcessKind::Attributes, at));
            }
            if !rest[..end].ends_with('/') {
                depth += 1;
                if depth > DEEPEST {
                    return Some((ExcessKind::Depth, at));
                }
            }
            at += end;
        }
    }
    None
}

/// The end of a start tag, at its first `>` outside quotes, and the number of its values.
fn tag_end(bytes: &[u8]) -> (usize, usize) {
    let (mut quote, mut values) = (None, 0);
    for (at, byte) in bytes.iter().enumerate() {
        match (quote, byte) {
            (None, b'>') => return (at, values),
            (None, b'"' | b'\'') => quote = Some(*byte),
            (Some(open), _) if open == *byte => {
                quote = None;
                values += 1;
            }
            _ => {}
        }
    }
    (bytes.len(), values)
}
