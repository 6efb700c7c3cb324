//! Every seeded fault is found under its own rule, and nothing else is said of it.
#![allow(clippy::unwrap_used)]

use crate::corpus;

use checker::{Report, Severity};
use corpus::{base, faults};
use std::collections::BTreeSet;

/// The rules that errors and warnings name.
fn rules(report: &Report) -> BTreeSet<&'static str> {
    report.findings.iter().filter(|f| f.severity > Severity::Note).map(|f| f.rule).collect()
}

#[test]
fn the_good_archive_has_no_findings() {
    let report = checker::check(&base().zip(), "Base.fmu");
    assert_eq!(rules(&report), BTreeSet::new(), "{:#?}", report.findings);
    assert!(report.is_clean());
}

#[test]
fn every_fault_is_found_under_its_rule_and_nothing_else() {
    let names: BTreeSet<&str> = faults().iter().map(|fault| fault.name).collect();
    assert_eq!(names.len(), faults().len());
    assert!(faults().len() >= 60);
    let mut wrong = Vec::new();
    for fault in faults() {
        let report = checker::check(&fault.archive(), "Base.fmu");
        if rules(&report) != BTreeSet::from([fault.rule]) {
            let told: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
            wrong.push(format!("{} ({}):\n  {}", fault.name, fault.rule, told.join("\n  ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A finding of the description leads to its line.
#[test]
fn findings_say_where() {
    let mut files = base();
    files.replace(r#"min="0" max="9""#, r#"min="4" max="9""#);
    let report = checker::check(&files.zip(), "Base.fmu");
    let finding = report.findings.iter().find(|f| f.rule == "start-outside-limits").unwrap();
    let xml = String::from_utf8(files.get("modelDescription.xml").clone()).unwrap();
    let line = xml.lines().position(|line| line.contains(r#"name="count""#)).unwrap() + 1;
    assert_eq!(finding.location.line.map(|l| l as usize), Some(line));
    assert_eq!(finding.location.column, Some(5));
    assert_eq!(finding.location.element.as_deref(), Some("<ScalarVariable name=\"count\">"));
    assert_eq!(finding.section, "2.2.7");
}

/// Names of sources with `.` in them lead to the same file.
#[test]
fn a_dot_in_the_name_of_a_source_is_looked_through() {
    let told = |name: &str| {
        let mut files = base();
        files.add("sources/gc/more.c", b"int more;\n");
        let listed = format!("<File name=\"base.c\"/><File name=\"{name}\"/>");
        files.replace(r#"<File name="base.c"/>"#, &listed);
        rules(&checker::check(&files.zip(), "Base.fmu"))
    };
    for name in ["./gc/more.c", "gc/./more.c", "././gc/more.c"] {
        assert_eq!(told(name), BTreeSet::new(), "{name}");
    }
    assert_eq!(told("./gc/other.c"), BTreeSet::from(["source-missing"]));
    for name in ["gc/../base.c", "/gc/more.c", "gc\\more.c", "gc//more.c", "./", "c:base.c"] {
        assert_eq!(told(name), BTreeSet::from(["source-name"]), "{name}");
    }
}
