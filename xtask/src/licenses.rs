//! `cargo xtask licenses`: packaging/licenses/license.txt, which every archive carries.
//!
//! The crates are those that cargo links into the FMU libraries on any platform, the texts those
//! in the crates' own sources, so nothing is fetched beyond what a build fetches. Crates that only
//! run at build time (macros) are not linked and not listed. The standard library's notices come
//! from the toolchain's documentation.

use crate::files::read;
use crate::run::{answer, cargo, root};
use cargo_metadata::{CrateType, Metadata, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A crate with its licence.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Linked {
    name: String,
    version: String,
    expression: String,
}

/// Licence texts, equal ones once: what they read without their layout → the text and its owners.
#[derive(Default)]
struct Texts(BTreeMap<String, (String, Vec<String>)>);

impl Texts {
    fn add(&mut self, owner: String, text: &str) {
        let key = text.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
        let entry = self.0.entry(key).or_insert_with(|| (text.to_owned(), Vec::new()));
        if !entry.1.contains(&owner) {
            entry.1.push(owner);
        }
    }
}

/// Writes the file again.
pub(crate) fn licenses() -> Result<(), String> {
    let metadata = MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .other_options(["--locked".to_owned()])
        .exec()
        .map_err(|e| e.to_string())?;
    let mut texts = Texts::default();
    for name in ["LICENSE-APACHE", "LICENSE-MIT"] {
        texts.add("Steerwright".into(), &read(&root().join(name))?);
    }
    let crates = linked(&metadata)?;
    for linked in &crates {
        let owner = format!("{} {}", linked.name, linked.version);
        let folder = folder(&metadata, linked).ok_or_else(|| format!("{owner} has no sources"))?;
        let files = license_files(&folder)?;
        if files.is_empty() {
            return Err(format!("{owner} comes without a licence text: {}", folder.display()));
        }
        for file in files {
            texts.add(owner.clone(), &read(&file)?);
        }
    }
    let library = standard_library(&mut texts)?;
    let file = root().join("packaging/licenses/license.txt");
    fs::write(&file, page(&crates, &library, &texts))
        .map_err(|e| format!("{}: {e}", file.display()))?;
    println!("{}: {} crates, {} texts", file.display(), crates.len(), texts.0.len());
    Ok(())
}

/// What the FMU libraries link, on all platforms, ours left out.
fn linked(metadata: &Metadata) -> Result<BTreeSet<Linked>, String> {
    let libraries = metadata.workspace_packages().into_iter().filter(|package| {
        package
            .targets
            .iter()
            .any(|target| target.is_cdylib() && target.crate_types.contains(&CrateType::CDyLib))
    });
    let mut all = BTreeSet::new();
    for library in libraries {
        let text = answer(
            cargo(&["tree", "--locked", "--edges", "normal,no-proc-macro", "--target", "all"])
                .args(["--prefix", "none", "--format", "{p}\t{l}", "--package"])
                .arg(library.name.as_str()),
        )
        .ok_or_else(|| format!("cargo tree --package {} failed", library.name))?;
        for line in text.lines() {
            let (package, expression) = line.split_once('\t').unwrap_or((line, ""));
            // A path in parentheses follows what is ours.
            let mut words = package.split_whitespace();
            if let (Some(name), Some(version), None) = (words.next(), words.next(), words.next()) {
                all.insert(Linked {
                    name: name.to_owned(),
                    version: version.trim_start_matches('v').to_owned(),
                    expression: expression.trim_end_matches("(*)").trim().to_owned(),
                });
            }
        }
    }
    Ok(all)
}

fn folder(metadata: &Metadata, linked: &Linked) -> Option<PathBuf> {
    let package = metadata.packages.iter().find(|package| {
        package.name.as_str() == linked.name && package.version.to_string() == linked.version
    })?;
    Some(package.manifest_path.parent()?.into())
}

/// The licence files at the top of a crate's sources, sorted.
fn license_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
            let words = ["license", "licence", "copying", "copyright", "unlicense", "notice"];
            path.is_file() && words.iter().any(|word| name.starts_with(word))
        })
        .collect();
    files.sort();
    Ok(files)
}

/// Crates of the standard library's notices that no FMU library links: they serve the build, the
/// tests, or systems that FMUs are not built for.
const NOT_LINKED: &[&str] = &[
    "cc",
    "shlex",
    "getopts",
    "rand",
    "rustc-literal-escaper",
    "dlmalloc",
    "fortanix-sgx-abi",
    "hermit-abi",
    "moto-rt",
    "r-efi",
    "unwinding",
    "vex-sdk",
    "wasi",
    "wit-bindgen",
];

/// The standard library's own third-party crates, `name version: licence`; adds their texts.
fn standard_library(texts: &mut Texts) -> Result<Vec<String>, String> {
    let sysroot = answer(Command::new("rustc").args(["--print", "sysroot"])).ok_or("no rustc")?;
    let documents = Path::new(&sysroot).join("share/doc/rust");
    let html = read(&documents.join("COPYRIGHT-library.html"))
        .map_err(|e| format!("{e}; the toolchain needs its component rust-docs or rustc"))?;
    let mut list = Vec::new();
    for section in html.split("<h3>\u{1f4e6} ").skip(1) {
        let (title, rest) = section.split_once("</h3>").unwrap_or((section, ""));
        let (name, version) = title.rsplit_once('-').unwrap_or((title, ""));
        if NOT_LINKED.iter().any(|word| name == *word || title.starts_with(&format!("{word}-")))
            || title.starts_with("rand_")
        {
            continue;
        }
        let expression = between(rest, "<b>License:</b> ", "</p>").unwrap_or_default();
        list.push(format!("{name} {version}: {}", expression.trim()));
        for notice in rest.split("<pre>").skip(1) {
            let text = unescaped(notice.split("</pre>").next().unwrap_or_default());
            texts.add(format!("the Rust standard library's {name} {version}"), &text);
        }
    }
    if list.is_empty() {
        return Err("COPYRIGHT-library.html has another form than expected".into());
    }
    let unicode = read(&documents.join("licenses/Unicode-3.0.txt"))?;
    texts.add("the Rust standard library's tables of Unicode".into(), &unicode);
    Ok(list)
}

fn between<'a>(text: &'a str, begin: &str, end: &str) -> Option<&'a str> {
    text.split_once(begin)?.1.split_once(end).map(|(text, _)| text)
}

fn unescaped(text: &str) -> String {
    [("&#34;", "\""), ("&#39;", "'"), ("&#60;", "<"), ("&#62;", ">"), ("&#38;", "&")]
        .iter()
        .fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// The file: who is in, then every text with its owners.
fn page(crates: &BTreeSet<Linked>, library: &[String], texts: &Texts) -> String {
    let mut page = String::from(
        "Licences of the FMUs that Steerwright makes\n\
         ===========================================\n\n\
         An FMU's libraries hold Steerwright's own code, the Rust crates listed here and parts of\n\
         the Rust standard library. Each comes under the licence named beside it; where that is a\n\
         choice, any of them. The texts follow. What resources/ and extra/ hold is data of whoever\n\
         made the archive.\n\n\
         Steerwright: MIT OR Apache-2.0\n\n\
         Crates\n------\n\n",
    );
    for Linked { name, version, expression } in crates {
        let _ = writeln!(page, "  {name} {version}: {expression}");
    }
    page.push_str(
        "\nThe Rust standard library\n-------------------------\n\n\
         Copyright: The Rust Project Developers (see https://thanks.rust-lang.org) and, for its\n\
         tables of Unicode, 1991-2024 Unicode, Inc.\n\
         Licence: MIT OR Apache-2.0; the tables of Unicode: Unicode-3.0. Its third-party crates:\n\n",
    );
    for line in library {
        let _ = writeln!(page, "  {line}");
    }
    let mut sorted: Vec<_> = texts.0.values().collect();
    sorted.sort_by_key(|(text, owners)| (std::cmp::Reverse(owners.len()), owners.first(), text));
    for (text, owners) in sorted {
        let rule = "-".repeat(96);
        let _ = writeln!(page, "\n{rule}\n{}\n{rule}\n", wrapped(owners));
        let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
        page.push_str(lines.join("\n").trim_matches('\n'));
        page.push('\n');
    }
    page
}

/// The owners of a text, in lines of at most 96 characters.
fn wrapped(owners: &[String]) -> String {
    let mut lines = vec![String::from("Of")];
    for (owner, rest) in owners.iter().zip((0..owners.len()).rev()) {
        let word = if rest > 0 { format!("{owner},") } else { owner.clone() };
        match lines.last_mut() {
            Some(line) if line.len() + word.len() < 96 => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines.join("\n")
}
