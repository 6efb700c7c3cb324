//! The licences in the archives are those of what the FMU libraries link.
//!
//! `cargo xtask licenses` writes them again.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

const LICENSES: &str = include_str!("../licenses/license.txt");

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The packages of fmu/ that are C libraries.
fn libraries() -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(root().join("fmu")).unwrap() {
        let Ok(manifest) = std::fs::read_to_string(entry.unwrap().path().join("Cargo.toml")) else {
            continue;
        };
        if manifest.lines().any(|l| l.starts_with("crate-type") && l.contains("\"cdylib\"")) {
            let name = manifest.lines().find_map(|l| l.strip_prefix("name = ")).unwrap();
            names.push(name.trim_matches('"').to_owned());
        }
    }
    names
}

/// `name version` → licence expression, as cargo states them of everything linked, ours left out.
fn linked() -> BTreeMap<String, String> {
    let libraries = libraries();
    assert!(libraries.len() >= 4, "{libraries:?}");
    let mut all = BTreeMap::new();
    for library in libraries {
        let tree = Command::new(env!("CARGO"))
            .args(["tree", "--locked", "--edges", "normal,no-proc-macro", "--target", "all"])
            .args(["--prefix", "none", "--format", "{p}\t{l}", "--package", &library])
            .current_dir(root())
            .output()
            .unwrap();
        assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
        for line in String::from_utf8(tree.stdout).unwrap().lines() {
            let (package, expression) = line.split_once('\t').unwrap();
            if let [name, version] = package.split_whitespace().collect::<Vec<_>>()[..] {
                let expression = expression.trim_end_matches("(*)").trim();
                all.insert(format!("{name} {}", &version[1..]), expression.to_owned());
            }
        }
    }
    all
}

/// The same, as the file says.
fn listed() -> BTreeMap<String, String> {
    let (_, list) = LICENSES.split_once("Crates\n------\n\n").unwrap();
    let (list, _) = list.split_once("\n\n").unwrap();
    list.lines()
        .map(|line| line.trim().split_once(": ").unwrap())
        .map(|(package, expression)| (package.to_owned(), expression.to_owned()))
        .collect()
}

#[test]
fn every_linked_crate_is_listed_with_its_licence() {
    assert_eq!(listed(), linked(), "out of date: run `cargo xtask licenses`");
}

#[test]
fn every_listed_crate_has_a_text_and_a_licence() {
    // Owners stand between two rules.
    let rule = format!("\n{}\n", "-".repeat(96));
    let parts: Vec<&str> = LICENSES.split(&rule).collect();
    let mut owners = BTreeSet::new();
    for (owner, text) in parts[1..].chunks(2).map(|pair| (pair[0], pair[1])) {
        assert!(text.trim().len() > 10, "{owner}: {text}");
        let list = owner.strip_prefix("Of ").unwrap().replace('\n', " ");
        owners.extend(list.split(", ").map(str::to_owned));
    }
    for (package, expression) in listed() {
        assert!(owners.contains(&package), "{package} has no text");
        assert!(!expression.is_empty(), "{package} names no licence");
    }
    for owner in ["Steerwright", "the Rust standard library's tables of Unicode"] {
        assert!(owners.contains(owner), "{owner} has no text");
    }
    for phrase in ["Apache License", "Permission is hereby granted", "UNICODE LICENSE V3"] {
        assert!(LICENSES.contains(phrase), "{phrase}");
    }
}

#[test]
fn no_path_of_the_machine_that_wrote_them() {
    for word in ["/root", "/home", "/work", "/tmp", ".cargo"] {
        assert!(!LICENSES.contains(word), "{word}");
    }
}
