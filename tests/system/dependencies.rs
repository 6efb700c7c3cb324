//! Who may depend on whom inside the workspace; see ARCHITECTURE.md.

use cargo_metadata::{DependencyKind, MetadataCommand};
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
    ("slaves", &["fmi2-export", "formats", "model-description", "model-loading", "vehicle-models"]),
    ("fmi2-export", &["model-description"]),
    ("control", &["formats", "model-loading", "vehicle-models"]),
    ("model-loading", &["formats", "vehicle-models"]),
    ("drivelog", &["formats"]),
    ("sysid", &["drivelog", "formats"]),
    ("sysid-evaluation", &["drivelog", "sysid"]),
    ("fmi2-host", &["model-description"]),
    ("packaging", &["fmi2-host", "formats", "model-description", "slaves"]),
    ("fmu-checker", &["fmi2-host", "model-description"]),
    ("report", &["formats"]),
    ("sweep", &["fmi2-host"]),
    (
        "comparison",
        &[
            "control",
            "drivelog",
            "fmi2-host",
            "fmu-binaries",
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
            "fmi2-host",
            "fmu-binaries",
            "fmu-checker",
            "formats",
            "packaging",
            "report",
            "sweep",
            "sysid",
        ],
    ),
    ("formats", NOTHING),
    ("vehicle-models", NOTHING),
    ("model-description", NOTHING),
    ("fmu-binaries", NOTHING),
    ("fuzzing", &["fmi2-export", "fmi2-host", "model-description", "slaves"]),
    ("xtask", NOTHING),
    ("abi-tests", NOTHING),
    ("bench-fmus", &["fmi2-export"]),
];

#[test]
fn no_edge_beyond_the_architecture() {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let metadata = MetadataCommand::new().manifest_path(manifest).no_deps().exec().unwrap();
    let members: BTreeSet<&str> =
        metadata.workspace_packages().iter().map(|p| p.name.as_str()).collect();
    let allowed: BTreeMap<&str, &[&str]> = ALLOWED.iter().copied().collect();
    assert_eq!(
        members,
        allowed.keys().copied().collect::<BTreeSet<_>>(),
        "a crate without a rule, or a rule without a crate"
    );
    for package in metadata.workspace_packages() {
        for dependency in &package.dependencies {
            let name = dependency.name.as_str();
            if dependency.kind != DependencyKind::Development && members.contains(name) {
                assert!(
                    allowed[package.name.as_str()].contains(&name),
                    "{} depends on {name}, which ARCHITECTURE.md does not allow",
                    package.name
                );
            }
        }
    }
}

#[test]
fn an_fmu_binary_links_no_identification_and_no_design() {
    for library in [
        "identified-plant",
        "bicycle-plant",
        "nonlinear-vehicle",
        "lateral-pid",
        "reference-path",
        "pose-estimator",
    ] {
        let tree = Command::new(env!("CARGO"))
            .args(["tree", "--edges", "normal", "--prefix", "none", "--package", library])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
        let text = String::from_utf8(tree.stdout).unwrap();
        let reached: BTreeSet<&str> =
            text.lines().filter_map(|line| line.split_whitespace().next()).collect();
        assert!(reached.contains("vehicle-models"), "{reached:?}");
        for forbidden in ["faer", "sysid", "control", "argmin", "clap"] {
            assert!(!reached.contains(forbidden), "{library} links {forbidden}");
        }
    }
}
