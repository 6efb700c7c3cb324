//! Hostile archives: for any bytes the checker ends with findings.
#![allow(clippy::unwrap_used)]

use crate::corpus;

use corpus::base;
use proptest::prelude::*;
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use steerwright_checker::{Report, check};

fn good() -> &'static [u8] {
    static GOOD: OnceLock<Vec<u8>> = OnceLock::new();
    GOOD.get_or_init(|| base().zip())
}

fn has(report: &Report, rule: &str) -> bool {
    report.findings.iter().any(|finding| finding.rule == rule)
}

/// Names that point outside the folder that an archive is unpacked to: the checker reports them, the
/// host rejects them.
#[test]
fn names_outside_the_folder_are_found() {
    for name in [
        "../x",
        "a/../../x",
        "/etc/x",
        "C:/x",
        "c:x",
        "a//b",
        "./../x",
        "a/./../../b",
        "..\\x",
        "\\x",
        "a\0b",
    ] {
        let mut files = base();
        files.add(name, b"x");
        let bytes = files.zip();
        let report = check(&bytes, "Base.fmu");
        assert!(has(&report, "zip-unsafe-name"), "{name:?}: {:?}", report.findings);
        assert!(steerwright_host::Archive::from_bytes(&bytes, "x").is_err(), "{name:?}");
    }
}

/// The sizes in headers are checked, and entries that are declared too large are not unpacked.
#[test]
fn bombs_are_not_unpacked() {
    let start = Instant::now();
    let mut files = base();
    files.add("resources/zeros", &vec![0; 65 << 20]);
    let report = check(&files.zip(), "Base.fmu");
    // The limit is the checker's, so exceeding it does not violate FMI.
    assert!(has(&report, "not-examined") && report.is_clean() && report.warnings == 1);
    // The same with a header that declares one byte.
    let mut bytes = files.zip();
    let central = bytes.windows(4).rposition(|w| w == b"PK\x01\x02").unwrap();
    bytes[central + 24..central + 28].copy_from_slice(&1_u32.to_le_bytes());
    let report = check(&bytes, "Base.fmu");
    assert!(has(&report, "zip-local-header"), "{:?}", report.findings);
    let local = bytes.windows(4).rposition(|w| w == b"PK\x03\x04").unwrap();
    bytes[local + 22..local + 26].copy_from_slice(&1_u32.to_le_bytes());
    assert!(has(&check(&bytes, "Base.fmu"), "zip-entry-damaged"));
    assert!(start.elapsed() < Duration::from_secs(20));
}

/// FMI allows large files of zeros, many files and deep annotations.
#[test]
fn limits_of_the_checker_are_not_violations() {
    let mut files = base();
    files.add("resources/zeros", &vec![0; 4 << 20]);
    for number in 0..10_001 {
        files.add(&format!("resources/{number}"), b"");
    }
    assert_eq!(check(&files.zip(), "Base.fmu").warnings, 0);
    let mut files = base();
    let deep = format!("<Tool name=\"One\">{}{}</Tool>", "<a>".repeat(300), "</a>".repeat(300));
    files.replace("<Tool name=\"One\"/>", &deep);
    let report = check(&files.zip(), "Base.fmu");
    assert!(report.is_clean() && has(&report, "not-examined"), "{:?}", report.findings);
}

#[test]
fn overlapping_entries_are_found() {
    let mut files = base();
    files.add("resources/a.bin", b"abcdefgh");
    files.add("resources/b.bin", b"abcdefgh");
    let mut bytes = files.zip();
    let central: Vec<usize> =
        (0..bytes.len() - 4).filter(|at| bytes[*at..].starts_with(b"PK\x01\x02")).collect();
    let [.., a, b] = central.as_slice() else { unreachable!() };
    let offset = bytes[a + 42..a + 46].to_vec();
    bytes[b + 42..b + 46].copy_from_slice(&offset);
    let report = check(&bytes, "Base.fmu");
    assert!(has(&report, "zip-overlap") || has(&report, "zip-local-header"), "{report:?}");
}

/// Zip64 fields with wrong counts and offsets.
#[test]
fn wrong_zip64_fields_are_rejected() {
    let end = good().len() - 22;
    for (at, length) in [(8, 2), (10, 2), (12, 4), (16, 4)] {
        let mut bytes = good().to_vec();
        bytes[end + at..end + at + length].fill(0xff);
        assert!(!check(&bytes, "Base.fmu").is_clean(), "field at {at}");
    }
    let mut bytes = good()[..end].to_vec();
    bytes.extend(b"PK\x06\x07\0\0\0\0\xff\xff\xff\xff\xff\xff\xff\x7f\x01\0\0\0");
    bytes.extend(&good()[end..]);
    assert!(has(&check(&bytes, "Base.fmu"), "zip-version"));
}

/// A valid archive truncated to many lengths.
#[test]
fn truncated_archives_are_rejected() {
    let bytes = good();
    for length in (0..bytes.len()).step_by(97).chain(bytes.len() - 40..bytes.len()) {
        assert!(!check(&bytes[..length], "Base.fmu").is_clean(), "{length} bytes");
    }
}

#[test]
fn entities_and_other_encodings_are_rejected() {
    let bomb = "<!DOCTYPE x [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]>";
    let external = "<!DOCTYPE x SYSTEM \"file:///etc/passwd\">";
    for insert in [bomb, external] {
        let mut files = base();
        files.replace("<fmiModelDescription", &format!("{insert}<fmiModelDescription"));
        assert!(has(&check(&files.zip(), "Base.fmu"), "xml-refused"), "{insert}");
    }
    let mut files = base();
    let xml = files.get("modelDescription.xml");
    let wide: Vec<u8> =
        std::str::from_utf8(xml).unwrap().encode_utf16().flat_map(u16::to_le_bytes).collect();
    *xml = [&[0xff, 0xfe][..], &wide].concat();
    assert!(has(&check(&files.zip(), "Base.fmu"), "xml-encoding"));
}

/// The time is proportional to the size of a description, not to its square, also with faults.
#[test]
fn the_time_is_linear_in_the_description() {
    let start = Instant::now();
    let line = "<ScalarVariable name=\"a\" valueReference=\"7\" x=\"1\" causality=\"parameter\">\
                <Real unit=\"z\" min=\"2\" max=\"1\"/></ScalarVariable>\n";
    let mut files = base();
    files.replace("</ModelVariables>", &format!("{}</ModelVariables>", line.repeat(30_000)));
    let report = check(&files.zip(), "Base.fmu");
    assert!(has(&report, "name-twice") && has(&report, "xsd-attribute"));
    // A rule that is violated 30,000 times has a limited number of findings.
    assert!(report.findings.len() < 2000, "{}", report.findings.len());
    let mut files = base();
    let attributes: String = (0..100_000).map(|n| format!(" a{n}=\"\"")).collect();
    files.replace("<ModelVariables>", &format!("<ModelVariables{attributes}>"));
    assert!(has(&check(&files.zip(), "Base.fmu"), "xml-refused"));
    assert!(start.elapsed() < Duration::from_secs(30), "{:?}", start.elapsed());
}

/// As many files as a zip can have, and as many sources that are missing.
#[test]
fn the_time_is_linear_in_the_number_of_files() {
    let mut files = base();
    for number in 0..60_000 {
        files.add(&format!("sources/folder/with/a/long/name/{number:05}.h"), b"");
    }
    let list: String = (0..60_000)
        .map(|number| format!("<File name=\"folder/with/a/long/name/{number:05}.c\"/>"))
        .collect();
    files.replace("<File name=\"base.c\"/>", &list);
    let bytes = files.zip();
    let start = Instant::now();
    let report = check(&bytes, "Base.fmu");
    assert!(has(&report, "source-missing"), "{:?}", report.findings);
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Random bytes.
    #[test]
    fn any_bytes_end_in_findings(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
        prop_assert!(!check(&bytes, "Base.fmu").is_clean());
    }

    /// A valid archive with random changes of its bytes.
    #[test]
    fn mutated_archives_never_panic(
        changes in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..12),
        cut in proptest::option::of(any::<proptest::sample::Index>()),
    ) {
        let mut bytes = good().to_vec();
        for (index, value) in changes {
            let at = index.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = check(&bytes, "Base.fmu");
    }

    /// A valid archive with a damaged description, zipped again.
    #[test]
    fn mutated_descriptions_never_panic(
        at in any::<proptest::sample::Index>(), length in 0_usize..60,
        piece in "[<>/=\"'&;!\\[\\]0-9a-zA-Z. \\-]{0,30}",
    ) {
        let mut files = base();
        let xml = files.get("modelDescription.xml");
        let from = at.index(xml.len());
        let to = (from + length).min(xml.len());
        xml.splice(from..to, piece.bytes());
        let _ = check(&files.zip(), "Base.fmu");
    }

    /// A valid archive with a damaged binary.
    #[test]
    fn mutated_binaries_never_panic(
        changes in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..30),
        header: bool,
    ) {
        let mut files = base();
        let binary = files.get(&corpus::binary_name());
        for (index, value) in changes {
            let at = index.index(if header { 64 } else { binary.len() });
            binary[at] = value;
        }
        let _ = check(&files.zip(), "Base.fmu");
    }
}
