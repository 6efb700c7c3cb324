//! The seeded faults before other checkers: our schema against libxml2's with fmpy's schema files,
//! and a table of who finds what (`--nocapture` shows it).
//!
//! Needs the Python environment that `cargo xtask test` makes and names in STEERWRIGHT_PYTHON.
#![allow(clippy::unwrap_used)]

mod corpus;

use corpus::faults;
use fmu_checker::{Severity, check_file};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Rules that say what the schema says. `special-value` and `interface-twice` are of the text:
/// the schema lets them pass.
fn is_of_the_schema(rule: &str) -> bool {
    rule.starts_with("xsd-")
}

/// What a tool says of an archive and not of the good one; `None` where it is not installed.
fn complaints(told: &Value, fault: &str, tool: &str) -> Option<usize> {
    let good = told["good"][tool].as_array()?;
    Some(told[fault][tool].as_array()?.iter().filter(|line| !good.contains(line)).count())
}

fn shown(count: Option<usize>) -> String {
    count.map_or_else(|| "?".into(), |n| if n == 0 { "-".into() } else { n.to_string() })
}

#[test]
fn the_schema_is_that_of_fmpy_and_the_others_find_less() {
    let Some(python) = std::env::var_os("STEERWRIGHT_PYTHON") else {
        println!("left out: what fmpy and fmutool find of the seeded faults");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    corpus::write(folder.path());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/others.py");
    let output = Command::new(python).arg(script).arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // The tool prints on its own; the JSON is the last line.
    let text = String::from_utf8(output.stdout).unwrap();
    let told: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();

    assert_eq!(told["good"]["schema"], serde_json::json!([]));
    assert_eq!(told["good"]["fmpy"], serde_json::json!([]));
    let mut found = [0; 3];
    println!("{:<28} {:<28} {:>6} {:>8}", "fault", "ours", "fmpy", "fmutool");
    for fault in faults() {
        let report = check_file(&folder.path().join(format!("{}.fmu", fault.name))).unwrap();
        let rules: BTreeSet<&str> = report
            .findings
            .iter()
            .filter(|f| f.severity > Severity::Note)
            .map(|f| f.rule)
            .collect();

        if let Some(schema) = told[fault.name]["schema"].as_array() {
            // Where there is a tree to judge, the two schemas judge the same.
            let ours = rules.iter().any(|rule| is_of_the_schema(rule));
            let refused = rules.iter().any(|rule| rule.starts_with("xml-"));
            assert!(refused || ours != schema.is_empty(), "{}: {rules:?}, {schema:?}", fault.name);
        }
        found[0] += usize::from(!rules.is_empty());
        let others = ["fmpy", "fmutool"].map(|tool| complaints(&told, fault.name, tool));
        for (sum, count) in found[1..].iter_mut().zip(others) {
            *sum += usize::from(count.is_some_and(|n| n > 0));
        }
        let ours: Vec<&str> = rules.into_iter().collect();
        println!(
            "{:<28} {:<28} {:>6} {:>8}",
            fault.name,
            ours.join(" "),
            shown(others[0]),
            shown(others[1])
        );
    }
    println!(
        "{} faults: ours {}, fmpy {}, fmutool {}",
        faults().len(),
        found[0],
        found[1],
        found[2]
    );
    assert_eq!(found[0], faults().len());
    assert!(found[1] < faults().len() && found[2] < faults().len());
}
