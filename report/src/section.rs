//! What is shown of a document: sections of text, tables and figures, which [`crate::page_text`] and
//! [`crate::report_html`] render.

use crate::figure::Figure;
use crate::table::Table;

/// A heading and what is below it.
#[derive(Debug, Clone, PartialEq, Default)]
#[allow(missing_docs)]
#[must_use]
pub struct Section {
    pub heading: String,
    pub blocks: Vec<Block>,
    /// Whether only the heading is seen until it is opened.
    pub folded: bool,
}

impl Section {
    /// A section that is open.
    pub fn new(heading: impl Into<String>, blocks: Vec<Block>) -> Self {
        Self { heading: heading.into(), blocks, folded: false }
    }

    /// The blocks that are shown, with or without details and figures, and without empty ones and headings of nothing.
    pub(crate) fn shown(&self, details: bool, figures: bool) -> Vec<&Block> {
        let mut all = Vec::new();
        for block in &self.blocks {
            match block {
                Block::Details(inner) if details => all.extend(inner),
                Block::Details(_) => {}
                other => all.push(other),
            }
        }
        all.retain(|block| {
            !block.is_empty() && (figures || !matches!(block, Block::Figure { .. }))
        });
        let mut shown: Vec<&Block> = Vec::new();
        for block in all.into_iter().rev() {
            let is_heading = |block: &Block| matches!(block, Block::Heading(_));
            if !is_heading(block) || shown.last().is_some_and(|below| !is_heading(below)) {
                shown.push(block);
            }
        }
        shown.reverse();
        shown
    }
}

/// A piece of a section.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
pub enum Block {
    /// A smaller heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A verdict and its reason: a box on a page, the first line on a terminal. Both begin with a small letter or a
    /// proper one, as on a terminal.
    Note {
        /// Good, bad, or neither.
        tone: Tone,
        title: String,
        text: String,
    },
    /// Sentences with bullets.
    List(Vec<String>),
    /// Names, and what there is to state of each.
    Facts(Vec<(String, String)>),
    /// A table; cells that end with ✓ or ✗, `met` and `not met` are coloured.
    Table(Table),
    /// A figure that is drawn when the page is made; one that cannot be drawn leaves a remark. A terminal has none.
    Figure {
        figure: Figure,
        /// Height in pixels at a width of 900.
        height: u32,
        caption: String,
    },
    /// What only a specialist reads: on a page, and on a terminal and in a notebook where it is asked for. Details have
    /// no details.
    Details(Vec<Block>),
}

impl Block {
    /// A figure with its caption.
    #[must_use]
    pub fn figure(figure: Figure, height: u32, caption: impl Into<String>) -> Self {
        Self::Figure { figure, height, caption: caption.into() }
    }

    /// A fact for [`Block::Facts`].
    pub(crate) fn fact(name: &str, text: impl Into<String>) -> (String, String) {
        (name.to_owned(), text.into())
    }

    fn is_empty(&self) -> bool {
        match self {
            Self::List(items) => items.is_empty(),
            Self::Facts(facts) => facts.is_empty(),
            Self::Table(table) => table.is_empty(),
            _ => false,
        }
    }
}

/// Tone of a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Tone {
    Good,
    Bad,
    Neutral,
}
