//! Other checkers with the seeded faults: our schema compared with libxml2 and FMPy's schema files,
//! and a table of the findings of each checker (`--nocapture` prints it).
//!
//! Needs the Python environment that `cargo xtask test` creates; STEERWRIGHT_PYTHON is its interpreter.
#![allow(clippy::unwrap_used)]

use crate::corpus;

use corpus::{base, faults};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;
use steerwright_checker::{Severity, check, check_file};

/// Rules of the schema. `special-value` and `interface-twice` are rules of the text that the schema does
/// not express.
fn is_of_the_schema(rule: &str) -> bool {
    rule.starts_with("xsd-")
}

/// Number of descriptions with a random change, validated with both schemas.
const MUTATIONS: usize = 600;

/// The valid description with a random change; a number always has the same change.
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
    // A linear congruential generator is random enough.
    let mut state = number as u64;
    let mut below = |bound: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % bound
    };
    let mut files = base();
    let xml = files.get("modelDescription.xml");
    let text = String::from_utf8(xml.clone()).unwrap();
    // The first line is not an element.
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

/// The messages of a tool for an archive, without those for the valid one; `None` if it is not installed.
fn complaints(findings: &Value, fault: &str, tool: &str) -> Option<usize> {
    let good = findings["good"][tool].as_array()?;
    Some(findings[fault][tool].as_array()?.iter().filter(|line| !good.contains(line)).count())
}

fn shown(count: Option<usize>) -> String {
    count.map_or_else(|| "?".into(), |n| if n == 0 { "-".into() } else { n.to_string() })
}

#[test]
#[ignore = "needs FMPy and fmutool: cargo xtask test"]
fn the_schema_is_that_of_fmpy_and_the_others_find_less() {
    let python = std::env::var_os("STEERWRIGHT_PYTHON").expect("cargo xtask test names it");
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
    let findings: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();

    let mut invalid = 0;
    for (number, archive) in archives.iter().enumerate() {
        // Malformed XML is not validated.
        let Some(schema) = findings[format!("mutated/{number}")]["schema"].as_array() else {
            continue;
        };
        let report = check(archive, "Base.fmu");
        let ours: Vec<_> = report.findings.iter().filter(|f| is_of_the_schema(f.rule)).collect();
        assert_eq!(ours.is_empty(), schema.is_empty(), "{number}: {ours:#?}, {schema:#?}");
        invalid += usize::from(!schema.is_empty());
    }
    println!("{invalid} of {MUTATIONS} mutated descriptions break both schemas, none breaks one");
    assert!(invalid > MUTATIONS / 4 && invalid < MUTATIONS);

    assert_eq!(findings["good"]["schema"], serde_json::json!([]));
    assert_eq!(findings["good"]["fmpy"], serde_json::json!([]));
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

        if let Some(schema) = findings[fault.name]["schema"].as_array() {
            // The two schemas agree on every parsed document.
            let ours = rules.iter().any(|rule| is_of_the_schema(rule));
            let refused = rules.iter().any(|rule| {
                rule.starts_with("xml-") || matches!(*rule, "not-examined" | "fmi-version")
            });
            assert!(refused || ours != schema.is_empty(), "{}: {rules:?}, {schema:?}", fault.name);
        }
        found[0] += usize::from(!rules.is_empty());
        let others = ["fmpy", "fmutool"].map(|tool| complaints(&findings, fault.name, tool));
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
    // The page of the book has the same numbers.
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
