//! Every seeded fault is found under its own rule, without further findings.
#![allow(clippy::unwrap_used)]

use crate::corpus;

use corpus::{base, faults};
use std::collections::BTreeSet;
use steerwright_checker::{Report, Severity};

/// The rules of errors and warnings.
fn rules(report: &Report) -> BTreeSet<&'static str> {
    report.findings.iter().filter(|f| f.severity > Severity::Note).map(|f| f.rule).collect()
}

#[test]
fn the_good_archive_has_no_findings() {
    let report = steerwright_checker::check(&base().zip(), "Base.fmu");
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
        let report = steerwright_checker::check(&fault.archive(), "Base.fmu");
        if rules(&report) != BTreeSet::from([fault.rule]) {
            let found: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
            wrong.push(format!("{} ({}):\n  {}", fault.name, fault.rule, found.join("\n  ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A finding of the description has its line and column.
#[test]
fn findings_have_locations() {
    let mut files = base();
    files.replace(r#"min="0" max="9""#, r#"min="4" max="9""#);
    let report = steerwright_checker::check(&files.zip(), "Base.fmu");
    let finding = report.findings.iter().find(|f| f.rule == "start-outside-limits").unwrap();
    let xml = String::from_utf8(files.get("modelDescription.xml").clone()).unwrap();
    let line = xml.lines().position(|line| line.contains(r#"name="count""#)).unwrap() + 1;
    assert_eq!(finding.location.line.map(|l| l as usize), Some(line));
    assert_eq!(finding.location.column, Some(5));
    assert_eq!(finding.location.element.as_deref(), Some("<ScalarVariable name=\"count\">"));
    assert_eq!(finding.section, "2.2.7");
}

/// A part `.` in the name of a source is ignored.
#[test]
fn a_dot_in_the_name_of_a_source_is_ignored() {
    let rules_of = |name: &str| {
        let mut files = base();
        files.add("sources/gc/more.c", b"int more;\n");
        let listed = format!("<File name=\"base.c\"/><File name=\"{name}\"/>");
        files.replace(r#"<File name="base.c"/>"#, &listed);
        rules(&steerwright_checker::check(&files.zip(), "Base.fmu"))
    };
    for name in ["./gc/more.c", "gc/./more.c", "././gc/more.c"] {
        assert_eq!(rules_of(name), BTreeSet::new(), "{name}");
    }
    assert_eq!(rules_of("./gc/other.c"), BTreeSet::from(["source-missing"]));
    for name in ["gc/../base.c", "/gc/more.c", "gc\\more.c", "gc//more.c", "./", "c:base.c"] {
        assert_eq!(rules_of(name), BTreeSet::from(["source-name"]), "{name}");
    }
}
