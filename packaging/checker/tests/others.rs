//! The seeded faults before other checkers: our schema against libxml2's with fmpy's schema files,
//! and a table of who finds what (`--nocapture` shows it).
//!
//! Needs the Python environment that `cargo xtask test` makes and names in STEERWRIGHT_PYTHON.
#![allow(clippy::unwrap_used)]

use crate::corpus;

use checker::{Severity, check, check_file};
use corpus::{base, faults};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Rules that say what the schema says. `special-value` and `interface-twice` are of the text:
/// the schema lets them pass.
fn is_of_the_schema(rule: &str) -> bool {
    rule.starts_with("xsd-")
}

/// Descriptions with a random change that are held against both schemas.
const MUTATIONS: usize = 600;

/// The good description with a random change, the same for the same number.
fn mutation(number: usize) -> Vec<u8> {
    const VALUES: &[&str] = &[
        "",
        "1",
        "-1",
        "true",
        "1.5",
        "INF",
        "x y",
        "2020-01-01T00:00:00Z",
        "flat",
        "input",
        "1 2",
        "constant",
        "99999999999",
        " 1 ",
        "+3",
        "1e3",
        ".",
        "exact",
    ];
    const NAMES: &[&str] = &["name", "start", "min", "unit", "index", "causality", "kg", "foo"];
    const ELEMENTS: &[&str] = &[
        "<Real/>",
        "<Unit name=\"q\"/>",
        "<BaseUnit/>",
        "<Tool name=\"t\"/>",
        "<Outputs/>",
        "<Foo/>",
        "<Unknown index=\"1\"/>",
        "<Item name=\"i\" value=\"7\"/>",
        "<ModelVariables/>",
        "text",
    ];
    // A linear congruential generator: the numbers need to be mixed, no more.
    let mut state = number as u64;
    let mut below = |bound: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % bound
    };
    let mut files = base();
    let xml = files.get("modelDescription.xml");
    let text = String::from_utf8(xml.clone()).unwrap();
    // The first line is no element.
    let mut lines: Vec<String> = text.lines().map(Into::into).collect();
    let line = 1 + below(lines.len() - 1);
    let kind = below(8);
    if kind < 5 {
        let attributes: Vec<_> = text.match_indices("=\"").skip(2).map(|(at, _)| at).collect();
        let at = attributes[below(attributes.len())];
        let from = text[..at].rfind(' ').unwrap() + 1;
        let to = at + 2 + text[at + 2..].find('"').unwrap();
        let (head, name, value, tail) =
            (&text[..from], &text[from..at], &text[at + 2..to], &text[to + 1..]);
        *xml = match kind {
            0 => format!("{head}{tail}"),
            1 => format!("{head}{}=\"{value}\"{tail}", NAMES[below(NAMES.len())]),
            _ => format!("{head}{name}=\"{}\"{tail}", VALUES[below(VALUES.len())]),
        }
        .into_bytes();
        return files.zip();
    }
    match kind {
        5 => drop(lines.remove(line)),
        6 => {
            let other = 1 + below(lines.len() - 1);
            lines.swap(line, other);
        }
        _ => lines.insert(line, ELEMENTS[below(ELEMENTS.len())].into()),
    }
    *xml = lines.join("\n").into_bytes();
    files.zip()
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
    let mutated = folder.path().join("mutated");
    std::fs::create_dir(&mutated).unwrap();
    let archives: Vec<Vec<u8>> = (0..MUTATIONS).map(mutation).collect();
    for (number, archive) in archives.iter().enumerate() {
        std::fs::write(mutated.join(format!("{number}.fmu")), archive).unwrap();
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/others.py");
    let output = Command::new(python).arg(script).arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // The tool prints on its own; the JSON is the last line.
    let text = String::from_utf8(output.stdout).unwrap();
    let told: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();

    let mut invalid = 0;
    for (number, archive) in archives.iter().enumerate() {
        // What is no XML any more is judged by no schema.
        let Some(schema) = told[format!("mutated/{number}")]["schema"].as_array() else { continue };
        let report = check(archive, "Base.fmu");
        let ours: Vec<_> = report.findings.iter().filter(|f| is_of_the_schema(f.rule)).collect();
        assert_eq!(ours.is_empty(), schema.is_empty(), "{number}: {ours:#?}, {schema:#?}");
        invalid += usize::from(!schema.is_empty());
    }
    println!("{invalid} of {MUTATIONS} mutated descriptions break both schemas, none breaks one");
    assert!(invalid > MUTATIONS / 4 && invalid < MUTATIONS);

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
            let refused = rules.iter().any(|rule| {
                rule.starts_with("xml-") || matches!(*rule, "not-examined" | "fmi-version")
            });
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
    // The book's page states the same.
    let page = include_str!("../../../docs/methods/check.md");
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let claim = format!(
        "of {} the checker finds {}, FMPy 0.3.32 finds {} and the toolbox 2.0 finds {}",
        faults().len(),
        found[0],
        found[1],
        found[2]
    );
    assert!(page.contains(&claim), "docs/methods/check.md does not state: {claim}");
}
