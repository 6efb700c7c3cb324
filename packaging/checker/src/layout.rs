//! Requirements on the folders of an archive (section 2.3).

use crate::archive::Contents;
use crate::binary::platform;
use crate::finding::{Findings, Location};
use model_description::ModelDescription;
use std::collections::BTreeSet;

/// Entries that the standard defines at the top of the archive.
const TOP: &[&str] = &[
    "modelDescription.xml",
    "model.png",
    "documentation",
    "sources",
    "binaries",
    "resources",
    "extra",
    "terminalsAndIcons",
];

/// Headers that the importer provides.
const HEADERS: &[&str] = &["fmi2TypesPlatform.h", "fmi2FunctionTypes.h", "fmi2Functions.h"];

pub(crate) fn check(
    contents: &Contents<'_>,
    description: Option<&ModelDescription>,
    findings: &mut Findings,
) {
    top(contents, findings);
    binaries(contents, description, findings);
    if let Some(description) = description {
        sources(contents, description, findings);
    }
    documentation(contents, findings);
    terminals(contents, findings);
    if let Some(image) = contents.file("model.png")
        && !image.starts_with(b"\x89PNG\r\n\x1a\n")
    {
        findings.add("icon", Location::entry("model.png"), "it is not a PNG image");
    }
}

/// The parts of a path below a folder, for the entries below it.
fn below<'c>(contents: &'c Contents<'_>, folder: &'static str) -> impl Iterator<Item = &'c str> {
    contents
        .names()
        .filter_map(move |name| name.strip_prefix(folder))
        .filter(|rest| !rest.is_empty())
}

fn top(contents: &Contents<'_>, findings: &mut Findings) {
    let tops: BTreeSet<&str> =
        contents.names().filter_map(|name| name.split(['/', '\\']).next()).collect();
    for name in tops.iter().filter(|name| !TOP.contains(name)) {
        let message = "the standard does not define this entry";
        findings.add("unknown-entry", Location::entry(*name), message);
    }
    let mut seen = BTreeSet::new();
    for rest in below(contents, "extra/") {
        let (folder, file) = rest.split_once('/').unwrap_or((rest, ""));
        if seen.insert(folder) && (!folder.contains('.') || file.is_empty() && !rest.ends_with('/'))
        {
            let message = "it is in no folder named after a domain";
            findings.add("extra-name", Location::entry(format!("extra/{rest}")), message);
        }
    }
}

fn binaries(
    contents: &Contents<'_>,
    description: Option<&ModelDescription>,
    findings: &mut Findings,
) {
    let has_files = |folder: &'static str| below(contents, folder).any(|name| !name.ends_with('/'));
    if !has_files("binaries/") && !has_files("sources/") {
        let message = "there is neither a binary nor a source file";
        findings.add("no-implementation", Location::archive(), message);
    }
    let folders: BTreeSet<&str> = below(contents, "binaries/")
        .filter_map(|rest| rest.split_once('/').map(|(folder, _)| folder))
        .collect();
    let identifiers: Vec<&str> = match description {
        Some(description) => {
            let co_simulation =
                description.co_simulation.as_ref().map(|c| c.model_identifier.as_str());
            let exchange = description.model_exchange.as_ref().map(|m| m.model_identifier.as_str());
            co_simulation.into_iter().chain(exchange).collect()
        }
        None => Vec::new(),
    };
    for folder in folders {
        let path = format!("binaries/{folder}/");
        let Some(platform) = platform(folder) else {
            let message = format!("\"{folder}\" is not a known platform");
            findings.add("platform-name", Location::entry(path), message);
            continue;
        };
        // A folder with only static libraries is for linking.
        let present: Vec<&str> = contents
            .names()
            .filter_map(|name| name.strip_prefix(&path))
            .filter(|rest| !rest.is_empty() && !rest.contains('/'))
            .take(10)
            .collect();
        if present.is_empty() {
            continue;
        }
        for identifier in &identifiers {
            let name = format!("{path}{identifier}.{}", platform.extension);
            if !contents.has(&name) {
                let (ending, present) = (platform.extension, present.join(", "));
                let message = format!("{identifier}.{ending} is missing; the folder has {present}");
                findings.add("binary-name", Location::entry(&path), message);
                break;
            }
        }
    }
    for rest in below(contents, "binaries/").filter(|rest| !rest.contains('/')) {
        let message = "it is not in the folder of a platform";
        findings.add("binary-name", Location::entry(format!("binaries/{rest}")), message);
    }
}

fn sources(contents: &Contents<'_>, description: &ModelDescription, findings: &mut Findings) {
    let listed = description.co_simulation.as_ref().map_or(&[][..], |c| &c.source_files);
    for name in listed {
        let place = || Location::entry(format!("sources/{name}"));
        // Modeling tools write `./gc/x.c` for `gc/x.c`.
        let parts: Vec<&str> = name.split('/').filter(|part| *part != ".").collect();
        let is_plain = !name.contains(['\\', ':'])
            && !parts.is_empty()
            && parts.iter().all(|part| !matches!(*part, "" | ".."));
        if !is_plain {
            findings.add("source-name", place(), format!("SourceFiles lists \"{name}\""));
        } else if !contents.has(&format!("sources/{}", parts.join("/"))) {
            let message = "SourceFiles lists it, but it is not in the archive";
            findings.add("source-missing", place(), message);
        }
    }
    let mut units = below(contents, "sources/").filter(|name| name.ends_with(".c"));
    if listed.is_empty()
        && description.model_exchange.is_none()
        && !contents.has("sources/buildDescription.xml")
        && let Some(name) = units.next()
    {
        let message = "no SourceFiles lists the sources to compile";
        findings.add("sources-unlisted", Location::entry(format!("sources/{name}")), message);
    }
    for name in below(contents, "sources/") {
        if HEADERS.contains(&name.rsplit('/').next().unwrap_or(name)) {
            let message = "the importer provides this header";
            findings.add("source-header", Location::entry(format!("sources/{name}")), message);
        }
    }
}

fn documentation(contents: &Contents<'_>, findings: &mut Findings) {
    if !contents.has_folder("documentation/") {
        findings.add("no-documentation", Location::archive(), "documentation/ is missing");
    } else if !contents.has("documentation/index.html") {
        let place = Location::entry("documentation/");
        findings.add("documentation-entry", place, "index.html is missing");
    }
    let licenses = "documentation/licenses/";
    let entries = ["license.txt", "license.html"];
    if contents.has_folder(licenses)
        && !entries.iter().any(|name| contents.has(&format!("{licenses}{name}")))
    {
        let message = "both license.txt and license.html are missing";
        findings.add("license-entry", Location::entry(licenses), message);
    }
}

fn terminals(contents: &Contents<'_>, findings: &mut Findings) {
    const FILE: &str = "terminalsAndIcons/terminalsAndIcons.xml";
    let Some(bytes) = contents.file(FILE) else { return };
    let place = Location::entry(FILE);
    let Ok(text) = String::from_utf8(bytes) else {
        return findings.add("terminals", place, "it is not UTF-8");
    };
    if let Some((rule, problem)) = crate::xml::nesting(&text) {
        let rule = if rule == "not-examined" { rule } else { "terminals" };
        return findings.add(rule, place, problem);
    }
    match roxmltree::Document::parse(text.trim_start_matches('\u{feff}')) {
        Err(error) => findings.add("terminals", place, error.to_string()),
        Ok(tree) if tree.root_element().tag_name().name() != "fmiTerminalsAndIcons" => {
            findings.add("terminals", place, "its root is not fmiTerminalsAndIcons");
        }
        Ok(_) => {}
    }
}
