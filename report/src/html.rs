//! One self-contained page: text, tables and figures, without scripts or anything from elsewhere.
//!
//! Every text is escaped here and nowhere else: names of files and columns are whatever the log's
//! author wrote. Only [`Block::Figure`] holds markup, made by this crate from escaped parts.

use crate::{Error, Figure, Table};
use std::fmt::Write as _;

const STYLE: &str = include_str!("style.css");

/// A heading and what is below it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// The heading.
    pub heading: String,
    /// What is below it.
    pub blocks: Vec<Block>,
}

/// A piece of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A smaller heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A conclusion in a box.
    Note {
        /// Good, bad, or neither.
        tone: Tone,
        /// In bold.
        title: String,
        /// Below it.
        text: String,
    },
    /// Sentences with bullets.
    List(Vec<String>),
    /// A table; the cells `met` and `not met` are coloured.
    Table(Table),
    /// A figure that is drawn when the page is made; one that cannot be drawn leaves a remark.
    Figure {
        /// What is drawn.
        figure: Figure,
        /// Height in pixels at a width of 900.
        height: u32,
        /// Below it.
        caption: String,
    },
}

/// Tone of a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// All is well.
    Good,
    /// Something is not.
    Bad,
    /// Neither.
    Neutral,
}

/// The page, complete.
#[must_use]
pub fn report_html(title: &str, lead: &str, sections: &[Section]) -> String {
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"generator\" content=\"{3} {2}\"/>\n\
         <title>{0}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{0}</h1>\n\
         <p>{1}</p>\n<nav>",
        escape(title),
        escape(lead),
        env!("CARGO_PKG_VERSION"),
        crate::GENERATOR
    );
    for (k, section) in sections.iter().enumerate() {
        push(&mut out, format_args!("<a href=\"#s{k}\">{}</a> ", escape(&section.heading)));
    }
    out.push_str("</nav>\n");
    for (k, section) in sections.iter().enumerate() {
        let heading = escape(&section.heading);
        push(&mut out, format_args!("<section>\n<h2 id=\"s{k}\">{heading}</h2>\n"));
        section.blocks.iter().for_each(|block| push_block(&mut out, block));
        out.push_str("</section>\n");
    }
    out.push_str("</main>\n</body>\n</html>\n");
    out
}

fn push(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = out.write_fmt(text);
}

fn push_block(out: &mut String, block: &Block) {
    match block {
        Block::Heading(text) => push(out, format_args!("<h3>{}</h3>\n", escape(text))),
        Block::Text(text) => push(out, format_args!("<p>{}</p>\n", escape(text))),
        Block::Note { tone, title, text } => {
            let class = match tone {
                Tone::Good => "note good",
                Tone::Bad => "note bad",
                Tone::Neutral => "note",
            };
            let (title, text) = (escape(title), escape(text));
            push(out, format_args!("<p class=\"{class}\"><b>{title}</b>{text}</p>\n"));
        }
        Block::List(items) if items.is_empty() => {}
        Block::List(items) => {
            out.push_str("<ul>\n");
            for item in items {
                push(out, format_args!("<li>{}</li>\n", escape(item)));
            }
            out.push_str("</ul>\n");
        }
        Block::Table(table) => push_table(out, table),
        Block::Figure { figure, height, caption } => match figure.to_svg(crate::WIDTH, *height) {
            Ok(svg) => {
                let caption = escape(caption);
                push(
                    out,
                    format_args!("<figure>\n{svg}<figcaption>{caption}</figcaption>\n</figure>\n"),
                );
            }
            Err(error) => push(
                out,
                format_args!(
                    "<p class=\"note bad\"><b>{} is missing</b>{}</p>\n",
                    escape(&figure.title),
                    escape(&missing(&error))
                ),
            ),
        },
    }
}

fn missing(error: &Error) -> String {
    format!("{error}; {}", error.hint())
}

fn push_table(out: &mut String, table: &Table) {
    let numeric: Vec<bool> = (0..table.headers().len()).map(|k| table.is_numeric(k)).collect();
    let class = |k: usize| if numeric[k] { " class=\"n\"" } else { "" };
    out.push_str("<div class=\"wide\"><table>\n<thead><tr>");
    for (k, header) in table.headers().iter().enumerate() {
        push(out, format_args!("<th scope=\"col\"{}>{}</th>", class(k), escape(header)));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in table.rows() {
        out.push_str("<tr>");
        for (k, cell) in row.iter().enumerate() {
            match cell.as_str() {
                "met" => out.push_str("<td class=\"good\">✓ met</td>"),
                "not met" => out.push_str("<td class=\"bad\">✗ not met</td>"),
                _ if is_hash(cell) => push(out, format_args!("<td><code>{cell}</code></td>")),
                _ => push(out, format_args!("<td{}>{}</td>", class(k), escape(cell))),
            }
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table></div>\n");
}

fn is_hash(cell: &str) -> bool {
    cell.len() == 64 && cell.bytes().all(|b| b.is_ascii_hexdigit())
}

/// The text with everything that XML or HTML could take for markup replaced, and without the
/// characters that XML cannot hold.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
    }
    out
}

/// Control characters and what turns the direction of writing become U+FFFD: XML forbids the first,
/// and the second make a name read as another.
pub(crate) fn printable(text: &str) -> String {
    let bad = |c: char| {
        (c.is_control() && !matches!(c, '\n' | '\t'))
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{fffe}' | '\u{ffff}')
    };
    text.chars().map(|c| if bad(c) { '\u{fffd}' } else { c }).collect()
}
