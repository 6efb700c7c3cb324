//! One self-contained page: text, tables and figures, without anything from elsewhere.
//!
//! Every text is escaped here and nowhere else: names of files and columns are whatever the log's
//! author wrote. A figure is on the page twice, from one description: as SVG, for print and where scripts
//! do not run, and as data, from which the scripts in `page` draw with uPlot a figure that can be
//! magnified.

use crate::figure::Figure;
use crate::markup::{escape, push};
use crate::section::{Block, Section, Tone};
use crate::table::Table;
use crate::{Error, data};

const STYLE: &str = include_str!("page/style.css");
const SCRIPTS: [&str; 3] =
    [include_str!("page/common.js"), include_str!("page/chart.js"), include_str!("page/page.js")];
const UPLOT: &str = include_str!("../uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../uplot/uPlot.min.css");
const UPLOT_LICENSE: &str = include_str!("../uplot/LICENSE");
/// A page is smaller than this, bytes.
const LARGEST: usize = 2_000_000;

/// The page, complete.
#[must_use]
pub fn report_html(title: &str, lead: &str, sections: &[Section]) -> String {
    let drawn = Drawn::from_sections(sections);
    let mut figures = drawn.figures.iter();
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"generator\" content=\"{3} {2}\"/>\n\
         <title>{0}</title>\n<style>\n{UPLOT_STYLE}{STYLE}</style>\n</head>\n<body>\n\
         <header>\n<h1>{0}</h1>\n<p>{1}</p>\n</header>\n<nav aria-label=\"Contents\">",
        escape(title),
        escape(lead),
        env!("CARGO_PKG_VERSION"),
        crate::GENERATOR
    );
    for (k, section) in sections.iter().enumerate() {
        push!(out, "<a href=\"#s{k}\">{}</a> ", escape(&section.heading));
    }
    out.push_str("</nav>\n<main>\n");
    for (k, section) in sections.iter().enumerate() {
        let heading = format!("<h2 id=\"s{k}\">{}</h2>", escape(&section.heading));
        let (before, after) = if section.folded {
            (format!("<details>\n<summary>{heading}</summary>"), "</details>\n")
        } else {
            (heading, "")
        };
        push!(out, "<section aria-labelledby=\"s{k}\">\n{before}\n");
        section.shown(true, true).into_iter().for_each(|b| push_block(&mut out, b, &mut figures));
        push!(out, "{after}</section>\n");
    }
    out.push_str("</main>\n");
    if drawn.figures.iter().any(Result::is_ok) {
        push_scripts(&mut out, &drawn.data);
    }
    out.push_str("</body>\n</html>\n");
    out
}

/// Sections for a notebook, without details: headings, text, tables, and figures as SVG.
#[must_use]
pub fn notebook_html(sections: &[Section]) -> String {
    let mut out = String::new();
    for section in sections.iter().filter(|section| !section.shown(false, true).is_empty()) {
        push!(out, "<h3>{}</h3>\n", escape(&section.heading));
        for block in section.shown(false, true) {
            match block {
                // One that a short log leaves empty is left out.
                Block::Figure { figure, height, caption } => {
                    if let Ok(svg) = figure.to_svg(crate::WIDTH, *height) {
                        let caption = escape(caption);
                        push!(out, "<div style=\"max-width:900px\">{svg}<p>{caption}</p></div>\n");
                    }
                }
                other => push_block(&mut out, other, &mut std::iter::empty()),
            }
        }
    }
    out
}

/// The figures of a page in their order, as SVG, and the data of those that can be drawn.
struct Drawn {
    figures: Vec<Result<Still, Error>>,
    data: String,
}

/// A figure that does not move.
struct Still {
    /// Its number among those drawn.
    number: usize,
    svg: String,
    /// Points in the data of all, where not all fit the page.
    thinned: Option<(usize, usize)>,
}

impl Drawn {
    fn from_sections(sections: &[Section]) -> Self {
        let figure = |block| match block {
            &Block::Figure { ref figure, height, .. } => Some((figure, height)),
            _ => None,
        };
        let all: Vec<(&Figure, u32)> =
            sections.iter().flat_map(|s| s.shown(true, true)).filter_map(figure).collect();
        let svgs: Vec<_> = all.iter().map(|(f, height)| f.to_svg(crate::WIDTH, *height)).collect();
        let drawable: Vec<(&Figure, u32)> =
            all.iter().zip(&svgs).filter(|(_, svg)| svg.is_ok()).map(|(f, _)| *f).collect();
        let size: usize = svgs.iter().flatten().map(String::len).sum();
        // A tenth is for text, tables and scripts.
        let room = (LARGEST - LARGEST / 10).saturating_sub(size);
        let (data, kept) = data::encode(&drawable, room).unwrap_or_default();
        let mut kept = kept.into_iter().enumerate();
        let mut still = |svg| {
            let (number, (kept, of)) = kept.next().unwrap_or_default();
            Still { number, svg, thinned: if kept < of { Some((kept, of)) } else { None } }
        };
        Self { figures: svgs.into_iter().map(|svg| svg.map(&mut still)).collect(), data }
    }
}

/// The data, uPlot with its licence, and the page's own scripts. In XML the sections hold `<` and `&`, in
/// HTML their ends are comments.
fn push_scripts(out: &mut String, data: &str) {
    push!(out, "<script type=\"application/json\" id=\"figures\">{data}</script>\n");
    let library = format!("/*\n{UPLOT_LICENSE}\n*/\n{UPLOT}");
    for script in [&*library].into_iter().chain(SCRIPTS) {
        let script = script.trim_end();
        push!(out, "<script>//<![CDATA[\n{script}\n//]]></script>\n");
    }
}

fn push_block<'a>(
    out: &mut String,
    block: &Block,
    figures: &mut impl Iterator<Item = &'a Result<Still, Error>>,
) {
    match block {
        Block::Heading(text) => push!(out, "<h3>{}</h3>\n", escape(text)),
        Block::Text(text) => push!(out, "<p>{}</p>\n", prose(text)),
        Block::Note { tone, title, text } => {
            let class = match tone {
                Tone::Good => "note good",
                Tone::Bad => "note bad",
                Tone::Neutral => "note",
            };
            let (title, text) = (prose(&capitalised(title)), prose(&capitalised(text)));
            push!(out, "<p class=\"{class}\"><b>{title}.</b>{text}</p>\n");
        }
        Block::List(items) => {
            out.push_str("<ul>\n");
            for item in items {
                push!(out, "<li>{}</li>\n", prose(item));
            }
            out.push_str("</ul>\n");
        }
        Block::Facts(facts) => {
            out.push_str("<div class=\"wide\"><table>\n<tbody>\n");
            for (name, text) in facts {
                let name = escape(&capitalised(name));
                push!(out, "<tr><th scope=\"row\">{name}</th><td>{}</td></tr>\n", prose(text));
            }
            out.push_str("</tbody>\n</table></div>\n");
        }
        Block::Table(table) => push_table(out, table),
        // In `Section::shown`.
        Block::Details(_) => {}
        Block::Figure { figure, caption, .. } => match figures.next() {
            Some(Ok(still)) => push_figure(out, figure, still, caption),
            Some(Err(error)) => push!(
                out,
                "<p class=\"note\">The figure “{}” is missing: {}</p>\n",
                escape(&figure.title),
                escape(&format!("{error}; {}", error.hint()))
            ),
            None => {}
        },
    }
}

/// The text with a capital letter, as a sentence on a page begins.
fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    first + letters.as_str()
}

/// Escaped text with what stands between backticks as code.
fn prose(text: &str) -> String {
    let escaped = escape(text);
    let parts: Vec<&str> = escaped.split('`').collect();
    // A backtick without a partner is a character of a name.
    let pairs = (parts.len() - 1) / 2;
    let mut out = String::with_capacity(escaped.len() + 11 * pairs);
    for (k, part) in parts.iter().enumerate() {
        let mark = match k {
            0 => "",
            k if k > 2 * pairs => "`",
            k if k % 2 == 1 => "<code>",
            _ => "</code>",
        };
        out.push_str(mark);
        out.push_str(part);
    }
    out
}

fn push_figure(out: &mut String, figure: &Figure, still: &Still, caption: &str) {
    let (n, title, svg) = (still.number, escape(&figure.title), &still.svg);
    let (result, caption) = (escape(&figure.result), escape(caption));
    let thinned = match still.thinned {
        Some((kept, of)) => {
            format!(
                " To limit the size of the page, {kept} of {of} points are in it, with the least and the \
             largest of each interval; the files have all."
            )
        }
        None => String::new(),
    };
    push!(
        out,
        "<figure id=\"f{n}\">\n<div class=\"still\" tabindex=\"0\" role=\"region\" \
             aria-label=\"{title}\">{svg}</div>\n<figcaption id=\"c{n}\"><b>{result}</b> \
             {caption}{thinned}</figcaption>\n</figure>\n"
    );
}

fn push_table(out: &mut String, table: &Table) {
    let numeric: Vec<bool> = (0..table.headers().len()).map(|k| table.is_numeric(k)).collect();
    let class = |k: usize| if numeric[k] { " class=\"n\"" } else { "" };
    // Scrolled by the keyboard where it is wider than the page.
    let label = escape(&table.headers().join(", "));
    push!(
        out,
        "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Table: {label}\"><table>\n\
             <thead><tr>"
    );
    for (k, header) in table.headers().iter().enumerate() {
        match header.as_str() {
            "" => out.push_str("<td></td>"),
            text => push!(out, "<th scope=\"col\"{}>{}</th>", class(k), escape(text)),
        }
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in table.rows() {
        out.push_str("<tr>");
        for (k, cell) in row.iter().enumerate() {
            match cell.as_str() {
                "met" => out.push_str("<td class=\"good\">✓ met</td>"),
                "not met" => out.push_str("<td class=\"bad\">✗ not met</td>"),
                _ if cell.ends_with('✓') => {
                    push!(out, "<td class=\"n good\">{}</td>", escape(cell))
                }
                _ if cell.ends_with('✗') => {
                    push!(out, "<td class=\"n bad\">{}</td>", escape(cell))
                }
                _ if is_hash(cell) => push!(out, "<td><code>{cell}</code></td>"),
                _ => push!(out, "<td{}>{}</td>", class(k), escape(cell)),
            }
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table></div>\n");
}

fn is_hash(cell: &str) -> bool {
    cell.len() == 64 && cell.bytes().all(|b| b.is_ascii_hexdigit())
}
