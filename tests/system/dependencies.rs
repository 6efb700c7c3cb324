//! The dependencies inside the workspace are those of the table in ARCHITECTURE.md.

use crate::circles::sources;
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// The crates that carry no prefix: those for others to use, the program, and cargo's convention.
const UNPREFIXED: [&str; 4] = ["fmi2-export", "model-description", "steerwright", "xtask"];

/// A package's name without the prefix of internal crates.
fn short(package: &str) -> &str {
    package.strip_prefix("steerwright-").unwrap_or(package)
}

fn metadata() -> Metadata {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    MetadataCommand::new().manifest_path(manifest).no_deps().exec().unwrap()
}

/// An internal crate is called after its folder.
#[test]
fn names_are_those_of_folders() {
    for package in metadata().workspace_packages() {
        if !UNPREFIXED.contains(&package.name.as_str()) {
            let folder = package.manifest_path.parent().and_then(|folder| folder.file_name());
            assert_eq!(
                Some(package.name.as_str()),
                folder.map(|f| format!("steerwright-{f}")).as_deref()
            );
        }
    }
}

/// The cdylibs of FMUs: the folders of `fmu/` that make one.
fn fmu_binaries(metadata: &Metadata) -> BTreeSet<String> {
    let is_cdylib = |package: &Package| package.targets.iter().any(|t| t.is_cdylib());
    let is_fmu = |package: &Package| {
        let folder = package.manifest_path.parent().and_then(|folder| folder.parent());
        folder.and_then(|folder| folder.file_name()) == Some("fmu")
    };
    let packages = metadata.workspace_packages().into_iter();
    packages
        .filter(|p| is_cdylib(p) && is_fmu(p))
        .map(|p| short(p.name.as_str()).to_string())
        .collect()
}

/// Crates between backquotes.
fn crates(cell: &str) -> BTreeSet<String> {
    cell.split('`').skip(1).step_by(2).map(String::from).collect()
}

/// The table of ARCHITECTURE.md: each crate with those that it depends on.
fn table(metadata: &Metadata) -> BTreeMap<String, BTreeSet<String>> {
    let page = include_str!("../../ARCHITECTURE.md");
    let rows = page.lines().skip_while(|line| line.trim() != "| crate | depends on |").skip(2);
    let mut table = BTreeMap::new();
    for row in rows.map(str::trim).take_while(|row| row.starts_with('|')) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [names, dependencies] = cells[..] else { panic!("{row}") };
        assert_eq!(dependencies == "nothing of ours", crates(dependencies).is_empty(), "{row}");
        let names = if names == "the cdylibs" { fmu_binaries(metadata) } else { crates(names) };
        for name in names {
            let earlier = table.insert(name, crates(dependencies));
            assert!(earlier.is_none(), "a crate has two rows: {row}");
        }
    }
    table
}

/// The dependencies that cargo builds with, those for development apart.
fn edges(metadata: &Metadata) -> BTreeMap<String, BTreeSet<String>> {
    let packages = metadata.workspace_packages();
    let members: BTreeSet<&str> = packages.iter().map(|p| short(p.name.as_str())).collect();
    let of = |package: &Package| {
        let built = package.dependencies.iter().filter(|d| d.kind != DependencyKind::Development);
        let names = built.map(|dependency| short(&dependency.name));
        names.filter(|name| members.contains(name)).map(String::from).collect()
    };
    packages.iter().map(|p| (short(p.name.as_str()).to_string(), of(p))).collect()
}

#[test]
fn dependencies_are_those_of_the_architecture() {
    let metadata = metadata();
    let (table, edges) = (table(&metadata), edges(&metadata));
    let names = |map: &BTreeMap<String, _>| map.keys().cloned().collect::<BTreeSet<_>>();
    assert_eq!(names(&edges), names(&table), "the crates of cargo, and those of ARCHITECTURE.md");
    for (name, dependencies) in &edges {
        assert_eq!(dependencies, &table[name], "{name}: in Cargo.toml, and in ARCHITECTURE.md");
    }
}

#[test]
fn an_fmu_binary_links_no_identification_and_no_design() {
    let libraries = fmu_binaries(&metadata());
    assert!(libraries.contains("identified-plant"), "{libraries:?}");
    for library in libraries {
        let tree = Command::new(env!("CARGO"))
            .args(["tree", "--edges", "normal", "--prefix", "none", "--package"])
            .arg(format!("steerwright-{library}"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
        let text = String::from_utf8(tree.stdout).unwrap();
        let reached: BTreeSet<&str> =
            text.lines().filter_map(|line| line.split_whitespace().next()).map(short).collect();
        assert!(reached.contains("models"), "{reached:?}");
        for forbidden in ["faer", "sysid", "control", "argmin", "clap"] {
            assert!(!reached.contains(forbidden), "{library} links {forbidden}");
        }
    }
}

/// What is delivered does not depend on what tests it.
#[test]
fn code_includes_no_file_of_the_tests() {
    for (package, texts) in sources() {
        // It shares the known vehicles of the tests.
        if package == "steerwright-evaluation" {
            continue;
        }
        for (module, text) in texts {
            for line in text.lines().filter(|line| line.contains("tests/")) {
                let is_inclusion = line.contains("include") || line.contains("#[path");
                assert!(!is_inclusion, "{package}: {}: {line}", module.join("::"));
            }
        }
    }
}
