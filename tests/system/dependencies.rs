//! The allowed dependencies inside the workspace; see ARCHITECTURE.md.

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

const NOTHING: &[&str] = &[];
const LIBRARY: &[&str] = &["fmi2-export", "slaves"];

const ALLOWED: &[(&str, &[&str])] = &[
    ("identified-plant", LIBRARY),
    ("bicycle-plant", LIBRARY),
    ("nonlinear-vehicle", LIBRARY),
    ("lateral-pid", LIBRARY),
    ("reference-path", LIBRARY),
    ("pose-estimator", LIBRARY),
    ("slaves", &["fmi2-export", "formats", "model-description", "loading", "models"]),
    ("fmi2-export", &["model-description"]),
    ("control", &["formats", "loading", "models"]),
    ("loading", &["formats", "models"]),
    ("drivelog", &["formats"]),
    ("sysid", &["drivelog", "formats"]),
    ("evaluation", &["drivelog", "sysid"]),
    ("host", &["model-description"]),
    ("packaging", &["host", "formats", "model-description", "slaves"]),
    ("checker", &["host", "model-description"]),
    ("report", &["formats"]),
    ("stacks", &["formats"]),
    ("sweep", &["host"]),
    (
        "comparison",
        &[
            "control",
            "drivelog",
            "host",
            "binaries",
            "formats",
            "packaging",
            "report",
            "sweep",
            "sysid",
        ],
    ),
    (
        "steerwright",
        &[
            "comparison",
            "control",
            "drivelog",
            "host",
            "binaries",
            "checker",
            "formats",
            "packaging",
            "report",
            "stacks",
            "sweep",
            "sysid",
        ],
    ),
    ("python", &["drivelog", "steerwright", "sysid"]),
    ("formats", NOTHING),
    ("models", NOTHING),
    ("model-description", NOTHING),
    ("binaries", NOTHING),
    ("fuzzing", &["drivelog", "fmi2-export", "host", "model-description", "slaves"]),
    ("xtask", NOTHING),
    ("abi", NOTHING),
    ("bench-fmus", &["fmi2-export"]),
];

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

#[test]
fn no_edge_beyond_the_architecture() {
    let metadata = metadata();
    let members: BTreeSet<&str> =
        metadata.workspace_packages().iter().map(|p| short(p.name.as_str())).collect();
    let allowed: BTreeMap<&str, &[&str]> = ALLOWED.iter().copied().collect();
    assert_eq!(
        members,
        allowed.keys().copied().collect::<BTreeSet<_>>(),
        "a crate without a rule, or a rule without a crate"
    );
    for package in metadata.workspace_packages() {
        for dependency in &package.dependencies {
            let name = short(&dependency.name);
            if dependency.kind != DependencyKind::Development && members.contains(name) {
                assert!(
                    allowed[short(&package.name)].contains(&name),
                    "{} depends on {name}, which ARCHITECTURE.md does not allow",
                    package.name
                );
            }
        }
    }
}

#[test]
fn an_fmu_binary_links_no_identification_and_no_design() {
    for (library, _) in ALLOWED.iter().filter(|(_, allowed)| *allowed == LIBRARY) {
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
