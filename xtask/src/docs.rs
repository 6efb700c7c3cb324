//! `cargo xtask docs`: the book, built by mdBook, and the links of all documents.

use crate::files::{below, read};
use crate::run::{answer, cargo, root, run, target};
use crate::{fmus, formats, python_types, stacks};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The version of mdBook.
const MDBOOK: &str = "0.4.52";

/// Builds the book into the target folder and checks it; every fault is listed.
///
/// `update` writes the files that are generated; `tests/system/generated.rs` requires that they are current.
pub(crate) fn docs(update: bool) -> Result<(), String> {
    if update {
        let sources = root().join("formats/src");
        for (file, text) in [
            ("docs/formats.md".to_owned(), formats::page(&sources)?),
            ("python/steerwright/documents.py".to_owned(), python_types::module(&sources)?),
            stacks::page(root())?,
        ]
        .into_iter()
        .chain(fmus::files(root())?)
        {
            let path = root().join(file);
            if let Some(folder) = path.parent() {
                fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            }
            // What is current keeps its time, so that nothing is built again for it.
            if fs::read_to_string(&path).is_ok_and(|current| current == text) {
                continue;
            }
            fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
        }
    }
    let mut problems = documents()?;
    let book = build()?;
    problems.extend(pages(&book)?);
    if !problems.is_empty() {
        return Err(problems.join("\n"));
    }
    eprintln!("the book is in {}", book.join("index.html").display());
    Ok(())
}

fn build() -> Result<PathBuf, String> {
    let tools = target().join("tools");
    let program = tools.join("bin").join(format!("mdbook{}", std::env::consts::EXE_SUFFIX));
    let version = answer(Command::new(&program).arg("--version"));
    if version.is_none_or(|version| !version.ends_with(MDBOOK)) {
        // Not optimised: it builds a small book once.
        let install = ["install", "mdbook", "--version", MDBOOK, "--locked", "--debug"];
        run(cargo(&install)
            .args(["--quiet", "--force", "--no-default-features", "--root"])
            .arg(&tools)
            .env("CARGO_PROFILE_DEV_DEBUG", "false"))?;
    }
    let book = target().join("book");
    let output = Command::new(&program)
        .arg("build")
        .arg(root().join("docs"))
        .arg("--dest-dir")
        .arg(&book)
        .output()
        .map_err(|e| format!("{}: {e}", program.display()))?;
    let log = String::from_utf8_lossy(&output.stderr);
    // A page that cannot be included is an error in its log only.
    if !output.status.success() || log.contains("[ERROR]") || log.contains("[WARN]") {
        return Err(format!("mdbook build docs: {}\n{log}", output.status));
    }
    Ok(book)
}

/// The folders whose files the documents name.
const FOLDERS: [&str; 13] = [
    "comparison/",
    "control/",
    "docs/",
    "drivelog/",
    "fmu/",
    "formats/",
    "modelDescription/",
    "packaging/",
    "python/",
    "report/",
    "sweep/",
    "sysid/",
    "xtask/",
];

/// Broken links of the tracked Markdown files, and missing files and identifiers that they name.
fn documents() -> Result<Vec<String>, String> {
    let listed = answer(Command::new("git").args(["ls-files", "*.md"]).current_dir(root()));
    let listed = listed.ok_or("git ls-files finds no documents")?;
    let mut documents = BTreeMap::new();
    for name in listed.lines() {
        documents.insert(normal(Path::new(name)), parts(&read(&root().join(name))?));
    }
    // Tests and variables that the book names.
    let identifiers = "[a-z0-9]+(_[a-z0-9]+){3,}";
    let search = ["grep", "-h", "-o", "-w", "-E", identifiers, "--", "*.rs", "*.py"];
    let known = answer(Command::new("git").args(search).current_dir(root()));
    let known = known.ok_or("git grep finds no identifiers")?;
    let known: BTreeSet<&str> = known.lines().collect();
    let mut problems = Vec::new();
    for (document, (_, links, named)) in &documents {
        let folder = document.parent().unwrap_or(Path::new(""));
        for name in named {
            if name.contains('/') && !root().join(name).exists() {
                problems.push(format!("{}: no file {name}", document.display()));
            } else if !name.contains('/') && !known.contains(name.as_str()) {
                problems.push(format!("{}: no identifier {name}", document.display()));
            }
        }
        for link in links.iter().filter(|link| !is_external(link)) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let file = if file.is_empty() { document.clone() } else { normal(&folder.join(file)) };
            if !root().join(&file).exists() {
                problems.push(format!("{}: no file {}", document.display(), file.display()));
            } else if let (false, Some((headings, ..))) = (heading.is_empty(), documents.get(&file))
                && !headings.contains(heading)
            {
                problems.push(format!("{}: no heading {link}", document.display()));
            }
        }
    }
    Ok(problems)
}

fn is_external(link: &str) -> bool {
    link.contains("://") || link.starts_with("mailto:")
}

/// The anchors of a document's headings, its links, and the files and identifiers that it names.
fn parts(text: &str) -> (BTreeSet<String>, Vec<String>, Vec<String>) {
    let (mut headings, mut links, mut named) = (BTreeSet::new(), Vec::new(), Vec::new());
    let mut heading: Option<String> = None;
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::End(TagEnd::Heading(_)) => headings.extend(heading.take().map(|h| anchor(&h))),
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                links.push(dest_url.into_string());
            }
            Event::Text(part) | Event::Code(part) => {
                if is_path(&part) || is_identifier(&part) {
                    named.push(part.to_string());
                }
                if let Some(heading) = &mut heading {
                    heading.push_str(&part);
                }
            }
            _ => {}
        }
    }
    (headings, links, named)
}

/// Whether a text is the path of a file or folder of the repository.
fn is_path(text: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/_-.".contains(c);
    text.chars().all(is_plain) && FOLDERS.iter().any(|folder| text.starts_with(folder))
}

/// Whether a text is a name of at least four words, as those of tests are.
fn is_identifier(text: &str) -> bool {
    let is_word = |word: &str| {
        !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
    };
    text.matches('_').count() >= 3 && text.split('_').all(is_word)
}

/// A heading's anchor as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    let kept =
        heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

/// A path without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut parts = Vec::new();
    for part in path.components() {
        match part {
            std::path::Component::ParentDir => {
                parts.pop();
            }
            std::path::Component::CurDir => {}
            other => parts.push(other),
        }
    }
    parts.iter().collect()
}

/// Broken links of the built pages: every file that they name is in the book.
fn pages(book: &Path) -> Result<Vec<String>, String> {
    let mut problems = BTreeSet::new();
    for path in below(book, "html")? {
        let folder = path.parent().unwrap_or(book);
        let page = read(&path)?;
        let links = page.split(" href=\"").chain(page.split(" src=\"")).skip(1);
        for link in links.filter_map(|rest| rest.split('"').next()) {
            let file = link.split(['#', '?']).next().unwrap_or_default();
            let is_ours = !file.is_empty() && !is_external(link) && !link.starts_with("data:");
            if is_ours && !file.contains('<') && !folder.join(file).exists() {
                let page = path.strip_prefix(book).unwrap_or(&path);
                problems.insert(format!("the book's {}: no {file}", page.display()));
            }
        }
    }
    Ok(problems.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anchors_and_links_are_found() {
        let (headings, links, named) = parts(
            "# A `b` C\n[x](y.md#z) ![p](q.svg) `control/{a,b}` `control/src/lib.rs`\n\n## Other platforms\n",
        );
        assert!(headings.contains("a-b-c") && headings.contains("other-platforms"), "{headings:?}");
        assert_eq!(links, ["y.md#z", "q.svg"]);
        assert_eq!(named, ["control/src/lib.rs"]);
        assert_eq!(normal(Path::new("docs/../a/./b.md")), Path::new("a/b.md"));
    }
}
