//! The output of a command: results on stdout, everything else on stderr.
//!
//! With `--json` stdout has one JSON value, and each line on stderr is a JSON object with one key:
//! `error`, `warning`, `note` or `progress`. Without it, colour is used where the stream is a
//! terminal and `NO_COLOR` is not set.

use anstyle::{AnsiColor, Style};
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use steerwright_report::{Section, TextStyle, Tone, page_text};

/// Whether `--json` is set; errors are also printed where the arguments are not available.
static JSON: AtomicBool = AtomicBool::new(false);
/// Whether `--verbose` is set.
static DETAILS: AtomicBool = AtomicBool::new(false);
/// Whether a file of results goes to stdout, where nothing else may be printed then.
static TAKEN: AtomicBool = AtomicBool::new(false);

pub(crate) const GOOD: Style = AnsiColor::Green.on_default().bold();
pub(crate) const WARN: Style = AnsiColor::Yellow.on_default().bold();
pub(crate) const BAD: Style = AnsiColor::Red.on_default().bold();
pub(crate) const HINT: Style = AnsiColor::Cyan.on_default().bold();

/// Sets the form of all output.
pub(crate) fn use_json(json: bool) {
    JSON.store(json, Ordering::Relaxed);
}

/// Sets whether pages have what only a specialist reads.
pub(crate) fn use_details(details: bool) {
    DETAILS.store(details, Ordering::Relaxed);
}

/// Keeps stdout for a file.
pub(crate) fn take_stdout() {
    TAKEN.store(true, Ordering::Relaxed);
}

/// Whether results and errors are JSON.
pub(crate) fn is_json() -> bool {
    JSON.load(Ordering::Relaxed)
}

/// A styled word; the style is left out where the stream is no terminal.
pub(crate) fn styled(style: Style, text: impl Display) -> String {
    format!("{style}{text}{style:#}")
}

fn toned(tone: Tone, title: &str) -> String {
    let style = match tone {
        Tone::Good => GOOD,
        Tone::Neutral => WARN,
        Tone::Bad => BAD,
    };
    styled(style, title)
}

/// Sections as text; the first line is the verdict, which ends with the next command if there is one.
pub(crate) fn page(sections: &[Section], next: Option<&str>) -> String {
    let details = DETAILS.load(Ordering::Relaxed);
    let text = page_text(sections, &TextStyle { columns: columns(), details, paint: toned });
    match (next, text.split_once('\n')) {
        (Some(next), Some((verdict, rest))) => {
            format!("{}; next: {next}\n{rest}", verdict.trim_end_matches('.'))
        }
        _ => text,
    }
}

/// A table as wide as the terminal at most, and as [`steerwright_report::COLUMNS`] elsewhere.
pub(crate) fn table(table: &steerwright_report::Table) -> String {
    table.text(columns())
}

/// Columns of the terminal, and [`steerwright_report::COLUMNS`] elsewhere.
pub(crate) fn columns() -> usize {
    terminal_columns().unwrap_or(steerwright_report::COLUMNS)
}

/// Columns of the terminal that stdout is, if it is one.
fn terminal_columns() -> Option<usize> {
    let is_terminal = std::io::stdout().is_terminal();
    let (width, _) = is_terminal.then(terminal_size::terminal_size).flatten()?;
    Some(usize::from(width.0))
}

/// Lines that are longer than the terminal, wrapped between words below their second column, which
/// is where text stands that has a label.
fn wrapped(text: &str, columns: usize) -> String {
    let lines = text.lines().map(|line| {
        if anstream::adapter::strip_str(line).to_string().chars().count() <= columns {
            return line.to_owned();
        }
        let label = line.find("  ").filter(|at| *at > 0 && *at < columns / 3);
        let start = label.map_or(0, |at| at + line[at..].len() - line[at..].trim_start().len());
        let indent = if start > 0 { start } else { line.len() - line.trim_start().len() };
        let (mut wrapped, mut used) = (line[..indent].to_owned(), indent);
        for (k, word) in line[indent..].split(' ').enumerate() {
            let width = anstream::adapter::strip_str(word).to_string().chars().count();
            if k > 0 && used + 1 + width > columns {
                wrapped += &format!("\n{}", " ".repeat(indent));
                used = indent;
            } else if k > 0 {
                wrapped.push(' ');
                used += 1;
            }
            wrapped += word;
            used += width;
        }
        wrapped
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A result that could not be written to stdout.
#[derive(Debug)]
pub(crate) struct NoOutput(pub(crate) std::io::Error);

/// The result: text for people, or the value with `--json`.
pub(crate) fn result(text: &str, value: &impl Serialize) -> Result<(), NoOutput> {
    let written = if is_json() {
        let json = serde_json::to_string_pretty(value).map_err(|e| NoOutput(e.into()))?;
        writeln!(anstream::stdout(), "{json}")
    } else if TAKEN.load(Ordering::Relaxed) {
        writeln!(anstream::stderr(), "{}", text.trim_end())
    } else {
        let text = text.trim_end();
        let text = match terminal_columns() {
            Some(c) => wrapped(text, c),
            None => text.to_owned(),
        };
        writeln!(anstream::stdout(), "{text}")
    };
    match written {
        // The work is done and written: a closed pipe is no failure.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(NoOutput(e)),
        _ => Ok(()),
    }
}

/// A result that is a file, on stdout.
pub(crate) fn bytes(bytes: &[u8]) -> std::io::Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        // A closed pipe is no failure.
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        done => done,
    }
}

/// Something that may be wrong.
pub(crate) fn warning(text: impl Display) {
    let text = text.to_string();
    if is_json() {
        object("warning", json!({ "message": text }))
    } else {
        labelled(WARN, "warning", &text)
    }
}

/// The files written, and other facts about the run.
pub(crate) fn note(text: impl Display) {
    let text = text.to_string();
    if is_json() { object("note", json!({ "message": text })) } else { line(&text) }
}

/// The present work, how much of how much is done (of 0 if that is unknown), and its duration.
pub(crate) fn progress(text: &str, [done, of]: [u64; 2], elapsed: Duration) {
    let seconds = elapsed.as_secs();
    if is_json() {
        let progress = json!({ "message": text, "done": done, "of": of, "elapsed_s": seconds });
        object("progress", progress);
    } else {
        line(&format!("progress: {text}, {seconds} s"));
    }
}

/// Why the work is not done.
pub(crate) fn error(message: &str, hint: &str, exit_status: u8) {
    if is_json() {
        let error = json!({ "message": message, "hint": hint, "exit_status": exit_status });
        return object("error", error);
    }
    labelled(BAD, "error", message);
    labelled(HINT, "hint", hint);
}

fn labelled(style: Style, label: &str, text: &str) {
    line(&format!("{}: {text}", styled(style, label)));
}

fn object(key: &str, value: Value) {
    let mut object = serde_json::Map::new();
    object.insert(key.into(), value);
    line(&Value::Object(object).to_string());
}

fn line(text: &str) {
    // A closed stderr is no reason to fail.
    let _ = writeln!(anstream::stderr(), "{text}");
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    #[test]
    fn long_lines_continue_below_their_text_and_tables_stay() {
        let text = "fit      one two three four\nshort\n\u{1b}[1mab\u{1b}[0m cd ef gh ij kl mn op";
        assert_eq!(
            wrapped(text, 20),
            "fit      one two\n         three four\nshort\n\u{1b}[1mab\u{1b}[0m cd ef gh ij kl mn\nop"
        );
    }
}
