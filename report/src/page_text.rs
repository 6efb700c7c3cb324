//! Sections as plain text, for a terminal.

use crate::markup::{printable, push};
use crate::section::{Block, Section, Tone};

/// How sections are laid out as text.
#[derive(Debug, Clone, Copy)]
pub struct TextStyle {
    /// Columns that a table may take.
    pub columns: usize,
    /// Whether what only a specialist reads is printed too.
    pub details: bool,
    /// The title of a verdict in the colour of its tone.
    pub paint: fn(Tone, &str) -> String,
}

/// Sections as text. The heading of the first one is left out, since the first line is the verdict; figures are left
/// out.
#[must_use]
pub fn page_text(sections: &[Section], style: &TextStyle) -> String {
    let mut out = String::new();
    for (number, section) in sections.iter().enumerate() {
        let blocks = section.shown(style.details, false);
        if number > 0 && !blocks.is_empty() {
            push!(out, "\n{}\n", printable(&section.heading));
        }
        let mut above: Option<&Block> = None;
        for block in blocks {
            let is_apart = matches!(block, Block::Heading(_) | Block::Table(_))
                || matches!(above, Some(Block::Table(_)));
            if is_apart && above.is_some_and(|above| !matches!(above, Block::Heading(_))) {
                out.push('\n');
            }
            push_block(&mut out, block, style);
            above = Some(block);
        }
    }
    // A number and its unit are kept together on a page; a terminal wraps nothing here.
    out.replace('\u{a0}', " ")
}

fn push_block(out: &mut String, block: &Block, style: &TextStyle) {
    match block {
        Block::Heading(text) | Block::Text(text) => push!(out, "{}\n", printable(text)),
        Block::Note { tone, title, text } => {
            out.push_str(&(style.paint)(*tone, &printable(title)));
            if !text.is_empty() {
                push!(out, ": {}", printable(text));
            }
            out.push('\n');
        }
        Block::List(items) => {
            for item in items {
                push!(out, "- {}\n", printable(item));
            }
        }
        Block::Facts(facts) => {
            let width = facts.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
            for (name, text) in facts {
                push!(out, "{:width$}  {}\n", printable(name), printable(text));
            }
        }
        Block::Table(table) => out.push_str(&table.text(style.columns)),
        // Neither is on a terminal: figures are files, and details are in `blocks` where they are shown.
        Block::Figure { .. } | Block::Details(_) => {}
    }
}
