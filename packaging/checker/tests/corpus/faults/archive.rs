//! Faults of the folders, the binary and the zip archive.

use super::Edit::{Both, Bytes, Files as InFiles, Xml};
use super::{Fault, fault};
use crate::corpus::binary_name;

pub(super) static FAULTS: &[Fault] = &[
    // --- the folders
    fault(
        "no-implementation",
        "no-implementation",
        InFiles(|f| {
            f.remove(&binary_name());
            f.remove("sources/base.c");
            f.replace(r#"<SourceFiles><File name="base.c"/></SourceFiles>"#, "");
        }),
    ),
    fault(
        "binary-misnamed",
        "binary-name",
        InFiles(|f| {
            let name = binary_name();
            f.rename(&name, &name.replace("Base", "base"));
        }),
    ),
    fault(
        "source-missing",
        "source-missing",
        Xml(r#"<File name="base.c"/>"#, r#"<File name="base.c"/><File name="more.c"/>"#),
    ),
    fault(
        "source-with-backslash",
        "source-name",
        Xml(r#"<File name="base.c"/>"#, r#"<File name="base.c"/><File name="a\b.c"/>"#),
    ),
    fault(
        "sources-unlisted",
        "sources-unlisted",
        Xml(r#"<SourceFiles><File name="base.c"/></SourceFiles>"#, ""),
    ),
    fault(
        "description-in-a-folder",
        "no-description",
        InFiles(|f| f.rename("modelDescription.xml", "Base/modelDescription.xml")),
    ),
    fault(
        "terminals-malformed",
        "terminals",
        InFiles(|f| f.add("terminalsAndIcons/terminalsAndIcons.xml", b"<fmiTerminalsAndIcons>")),
    ),
    fault(
        "no-documentation-entry",
        "documentation-entry",
        InFiles(|f| f.rename("documentation/index.html", "documentation/main.html")),
    ),
    fault(
        "no-license-entry",
        "license-entry",
        InFiles(|f| {
            f.rename("documentation/licenses/license.txt", "documentation/licenses/MIT.txt")
        }),
    ),
    // --- the binary
    fault(
        "binary-is-text",
        "binary-format",
        InFiles(|f| *f.get(&binary_name()) = b"#!/bin/sh\n".to_vec()),
    ),
    fault(
        "binary-of-another-platform",
        "binary-format",
        InFiles(|f| f.add("binaries/win64/Base.dll", crate::corpus::library())),
    ),
    fault("binary-truncated", "binary-format", InFiles(|f| f.get(&binary_name()).truncate(700))),
    fault(
        "function-missing",
        "binary-functions",
        InFiles(|f| {
            let binary = f.get(&binary_name());
            let name = b"fmi2GetBooleanStatus";
            let at = binary.windows(name.len()).position(|w| w == name).unwrap();
            binary[at] = b'F';
        }),
    ),
    // --- the archive
    fault(
        "compressed-otherwise",
        "zip-method",
        Bytes(|b| on_first(b, 8, 10, &12_u16.to_le_bytes())),
    ),
    fault("version-4.5", "zip-version", Bytes(|b| on_first(b, 4, 6, &45_u16.to_le_bytes()))),
    fault("encrypted", "zip-encrypted", Bytes(|b| on_last(b, 6, 8, &1_u16.to_le_bytes()))),
    fault(
        "stored-with-descriptor",
        "zip-stored-descriptor",
        Both(
            |f| f.add("resources/table.bin", b"stored"),
            |b| on_last(b, 6, 8, &8_u16.to_le_bytes()),
        ),
    ),
    fault(
        "link",
        "zip-link",
        Bytes(|b| on_last_central(b, 38, &(0o120_777_u32 << 16).to_le_bytes())),
    ),
    fault(
        "backslash",
        "zip-backslash",
        InFiles(|f| f.rename("resources/data.txt", "resources\\data.txt")),
    ),
    fault(
        "parent-folder",
        "zip-unsafe-name",
        InFiles(|f| f.rename("resources/data.txt", "resources/../../data.txt")),
    ),
    fault(
        "absolute-path",
        "zip-unsafe-name",
        InFiles(|f| f.rename("resources/data.txt", "/data.txt")),
    ),
    fault(
        "entry-twice",
        "zip-duplicate",
        Both(
            |f| f.add("resources/dat2.txt", b"other\n"),
            |b| {
                while let Some(at) = b.windows(18).position(|w| w == b"resources/dat2.txt") {
                    b[at + 13] = b'a';
                }
            },
        ),
    ),
    fault("checksum", "zip-entry-damaged", Bytes(|b| on_last(b, 14, 16, &[1, 2, 3, 4]))),
    fault(
        "headers-disagree",
        "zip-local-header",
        Bytes(|b| {
            let at = find(b, b"PK\x03\x04");
            b[at + 30] = b'M';
        }),
    ),
    fault("truncated", "zip-unreadable", Bytes(|b| b.truncate(b.len() / 2))),
    fault("bytes-behind", "zip-outside-data", Bytes(|b| b.extend(b"more"))),
    fault(
        "bytes-before",
        "zip-outside-data",
        Bytes(|b| {
            b.splice(0..0, *b"MZ before");
        }),
    ),
    fault(
        "case-collision",
        "zip-case-collision",
        InFiles(|f| f.add("resources/Data.txt", b"other\n")),
    ),
];

/// The position of the first signature.
fn find(bytes: &[u8], signature: &[u8]) -> usize {
    bytes.windows(signature.len()).position(|window| window == signature).unwrap()
}

fn rfind(bytes: &[u8], signature: &[u8]) -> usize {
    bytes.windows(signature.len()).rposition(|window| window == signature).unwrap()
}

/// Writes into the local header of the first entry and into its header in the directory.
fn on_first(bytes: &mut [u8], local: usize, central: usize, value: &[u8]) {
    let (l, c) = (find(bytes, b"PK\x03\x04") + local, find(bytes, b"PK\x01\x02") + central);
    bytes[l..l + value.len()].copy_from_slice(value);
    bytes[c..c + value.len()].copy_from_slice(value);
}

/// The same for the last entry.
fn on_last(bytes: &mut [u8], local: usize, central: usize, value: &[u8]) {
    let (l, c) = (rfind(bytes, b"PK\x03\x04") + local, rfind(bytes, b"PK\x01\x02") + central);
    bytes[l..l + value.len()].copy_from_slice(value);
    bytes[c..c + value.len()].copy_from_slice(value);
}

fn on_last_central(bytes: &mut [u8], central: usize, value: &[u8]) {
    let c = rfind(bytes, b"PK\x01\x02") + central;
    bytes[c..c + value.len()].copy_from_slice(value);
}
