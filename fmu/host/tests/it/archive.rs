//! Archives that are broken or hostile are refused with a clear error, and nothing is left behind.

use crate::support::{Behaviour, binary_path, library, xml, zip_of};
use steerwright_host::{Archive, Error, Limits};
use zip::write::SimpleFileOptions;

fn plain_xml() -> String {
    xml(("u", ""), ("y", ""))
}

fn refused(bytes: &[u8]) -> Error {
    let error = Archive::from_bytes(bytes, "x.fmu").expect_err("the archive was accepted");
    let text = error.to_string();
    assert!(text.contains("x.fmu"), "the message does not name the archive: {text}");
    assert!(!error.hint().is_empty());
    error
}

/// A file that `bytes` must not be able to create.
fn with_entry(name: &str) -> Vec<u8> {
    zip_of(&[("modelDescription.xml", plain_xml().as_bytes()), (name, b"evil")])
}

#[test]
fn a_sound_archive_opens_and_leaves_nothing_behind() {
    let bytes = zip_of(&[
        ("modelDescription.xml", plain_xml().as_bytes()),
        ("resources/deep/er/data.txt", b"data"),
    ]);
    let archive = Archive::from_bytes(&bytes, "x.fmu").unwrap();
    let folder = archive.folder().to_path_buf();
    assert_eq!(std::fs::read(folder.join("resources/deep/er/data.txt")).unwrap(), b"data");
    assert_eq!(archive.model().co_simulation().model_identifier, "Test");
    assert_eq!(archive.model().variable("u").unwrap().reference, 0);
    drop(archive);
    assert!(!folder.exists());
}

#[test]
fn entries_that_leave_the_folder_are_refused() {
    for name in ["../evil", "resources/../../evil", "/etc/evil", "C:/evil", "a\\..\\evil", "./../b"]
    {
        let error = refused(&with_entry(name));
        assert!(matches!(error, Error::UnsafeEntry { .. }), "{name}: {error}");
    }
}

#[test]
fn the_folder_itself_and_a_dot_in_a_path_are_no_attack() {
    let xml = plain_xml();
    let folders = zip_of(&[("./", b""), ("resources/./", b""), ("resources/data", b"1")]);
    assert!(matches!(refused(&folders), Error::NoModelDescription { .. }));
    let bytes = zip_of(&[
        ("./", b""),
        ("./modelDescription.xml", xml.as_bytes()),
        ("./resources/./data.txt", b"data"),
    ]);
    let archive = Archive::from_bytes(&bytes, "x.fmu").unwrap();
    assert_eq!(std::fs::read(archive.folder().join("resources/data.txt")).unwrap(), b"data");
    let twice = zip_of(&[("resources/a", b"1"), ("./resources/a", b"2")]);
    assert!(matches!(refused(&twice), Error::DuplicateEntry { .. }));
}

#[test]
fn links_and_devices_are_refused() {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    writer.add_symlink("resources", "/etc", SimpleFileOptions::default()).unwrap();
    let error = refused(&writer.finish().unwrap().into_inner());
    assert!(error.to_string().contains("link"), "{error}");
}

#[test]
fn zip_bombs_are_refused_before_they_are_unpacked() {
    let zeros = vec![0u8; 65 << 20];
    let error = refused(&zip_of(&[("modelDescription.xml", &zeros)]));
    assert!(error.to_string().contains("times its compressed size"), "{error}");

    let small = Limits { entry_bytes: 1000, ..Limits::default() };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.fmu");
    let xml = plain_xml();
    std::fs::write(&path, zip_of(&[("modelDescription.xml", xml.as_bytes())])).unwrap();
    let open = |limits: Limits| Archive::open_with_limits(&path, &limits).unwrap_err();
    assert!(matches!(open(small), Error::TooLarge { limit: 1000, .. }));
    let total = Limits { total_bytes: xml.len() as u64 - 1, ..Limits::default() };
    assert!(matches!(open(total), Error::TooLarge { .. }));
    // Below 64 MiB the ratio is free, and the sum of all entries is bounded all the same.
    std::fs::write(
        &path,
        zip_of(&[
            ("modelDescription.xml", xml.as_bytes()),
            ("resources/map.bin", &zeros[..4 << 20]),
        ]),
    )
    .unwrap();
    assert!(Archive::open(&path).is_ok());
    let total = Limits { total_bytes: 4 << 20, ..Limits::default() };
    assert!(matches!(
        open(total),
        Error::TooLarge { what: "bytes in all entries up to this one", .. }
    ));
    std::fs::write(&path, zip_of(&[("modelDescription.xml", xml.as_bytes())])).unwrap();
    let entries = Limits { entries: 0, ..Limits::default() };
    assert!(matches!(open(entries), Error::TooManyEntries { got: 1, limit: 0, .. }));
}

/// Replaces every occurrence of a byte string by another of its length.
fn patch(mut bytes: Vec<u8>, from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut found = 0;
    for at in 0..=bytes.len() - from.len() {
        if &bytes[at..at + from.len()] == from {
            bytes[at..at + from.len()].copy_from_slice(to);
            found += 1;
        }
    }
    assert!(found > 0);
    bytes
}

#[test]
fn duplicate_names_are_refused() {
    let bytes = zip_of(&[("resources/aaaa", b"1"), ("resources/aaab", b"2")]);
    let error = refused(&patch(bytes, b"aaab", b"aaaa"));
    assert!(matches!(error, Error::DuplicateEntry { .. }), "{error}");
    // A file and a folder of one name.
    let error = refused(&zip_of(&[("resources/a", b"1"), ("resources/a/", b"")]));
    assert!(matches!(error, Error::DuplicateEntry { .. }), "{error}");
}

#[test]
fn a_size_that_is_not_the_promised_one_is_refused() {
    // Claims 5 bytes uncompressed in both headers where there are 64: what is written stays bounded.
    let content = [7u8; 64];
    let bytes = zip_of(&[("modelDescription.xml", &content)]);
    let error = refused(&patch(bytes, &64u32.to_le_bytes(), &5u32.to_le_bytes()));
    assert!(matches!(error, Error::CorruptEntry { .. }), "{error}");
}

#[test]
fn anything_but_an_archive_is_refused() {
    assert!(matches!(refused(b""), Error::NotAnArchive { .. }));
    assert!(matches!(refused(b"this is not a zip archive"), Error::NotAnArchive { .. }));
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(Archive::open(folder.path()), Err(Error::NotAnArchive { .. })));
    let missing = folder.path().join("missing.fmu");
    let error = Archive::open(missing).unwrap_err().to_string();
    assert!(error.contains("missing.fmu"), "{error}");
}

#[test]
fn every_truncation_and_many_corruptions_give_an_error_or_an_archive_but_no_crash() {
    let xml = plain_xml();
    let bytes = zip_of(&[("modelDescription.xml", xml.as_bytes()), ("resources/a", b"0123456789")]);
    for length in (0..bytes.len()).step_by(7) {
        refused(&bytes[..length]);
    }
    for at in (0..bytes.len()).step_by(3) {
        let mut corrupt = bytes.clone();
        corrupt[at] ^= 0x55;
        // Some bytes (dates, attributes) matter to nobody.
        let _ = Archive::from_bytes(&corrupt, "x.fmu");
    }
}

#[test]
fn an_archive_without_or_with_a_wrong_description_is_refused() {
    let xml = plain_xml();
    let error = refused(&zip_of(&[("Test/modelDescription.xml", xml.as_bytes())]));
    assert!(matches!(error, Error::NoModelDescription { .. }), "{error}");
    let with = |xml: &str| refused(&zip_of(&[("modelDescription.xml", xml.as_bytes())]));
    assert!(matches!(with("<not closed"), Error::ModelDescription { .. }));
    let error = refused(&zip_of(&[("modelDescription.xml", b"\xff\xfe<")]));
    assert!(error.to_string().contains("UTF-8"), "{error}");
    let fmi3 = xml.replace("fmiVersion=\"2.0\"", "fmiVersion=\"3.0\"");
    assert!(matches!(with(&fmi3), Error::ModelDescription { .. }));
    let outside = xml.replace("modelIdentifier=\"Test\"", "modelIdentifier=\"../../Test\"");
    let error = with(&outside);
    assert!(error.to_string().contains("../../Test"), "{error}");
}

#[test]
fn a_missing_platform_names_those_that_are_there() {
    let xml = plain_xml();
    let bytes = zip_of(&[
        ("modelDescription.xml", xml.as_bytes()),
        ("binaries/amiga/Test.so", b"x"),
        ("binaries/beos/Test.dll", b"x"),
        ("binaries/other/Else.so", b"x"),
    ]);
    let archive = Archive::from_bytes(&bytes, "x.fmu").unwrap();
    assert_eq!(archive.platforms(), ["amiga", "beos"]);
    let error = archive.load().unwrap_err().to_string();
    assert!(error.contains("amiga, beos") && error.contains(&binary_path()), "{error}");
}

#[test]
fn a_binary_of_another_name_is_named() {
    let xml = plain_xml();
    let other = binary_path().replace("Test", "Other");
    let bytes = zip_of(&[("modelDescription.xml", xml.as_bytes()), (&other, b"x")]);
    let error = Archive::from_bytes(&bytes, "x.fmu").unwrap().load().unwrap_err().to_string();
    let missing = format!("{} is missing; the archive has {other}", binary_path());
    assert!(error.contains(&missing), "{error}");
}

#[test]
fn a_model_identifier_that_is_no_c_identifier_names_the_binary_all_the_same() {
    let Some(binary) = library(Behaviour::Integrator) else { return };
    let with = |identifier: &str| {
        let named = format!("modelIdentifier=\"{identifier}\"");
        plain_xml().replace("modelIdentifier=\"Test\"", &named)
    };
    let xml = with("1-Test (v2)");
    let place = binary_path().replace("Test", "1-Test (v2)");
    let bytes = zip_of(&[("modelDescription.xml", xml.as_bytes()), (&place, binary)]);
    let archive = Archive::from_bytes(&bytes, "x.fmu").unwrap();
    archive.load().unwrap();
    let [remark] = archive.remarks() else { panic!("{:?}", archive.remarks()) };
    assert!(remark.contains("x.fmu: modelIdentifier \"1-Test (v2)\" is not a C identifier"));
    for identifier in ["", " ", "..", "a/b", "a\\b", "C:x"] {
        let error = refused(&zip_of(&[("modelDescription.xml", with(identifier).as_bytes())]));
        assert!(matches!(error, Error::BadModelIdentifier { .. }), "{identifier}: {error}");
    }
}

#[test]
fn a_description_in_latin_1_is_read_with_a_remark() {
    let latin = plain_xml().replace("UTF-8", "ISO-8859-1");
    let open = |xml: &str| {
        let bytes: Vec<u8> = xml.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
        Archive::from_bytes(&zip_of(&[("modelDescription.xml", &bytes)]), "x.fmu")
    };
    let plain = open(&latin).unwrap();
    assert!(plain.remarks().is_empty(), "{:?}", plain.remarks());
    let archive = open(&latin.replace("name=\"gain\"", "name=\"Verstärkung\"")).unwrap();
    assert!(archive.model().variable("Verstärkung").is_some());
    let [remark] = archive.remarks() else { panic!("{:?}", archive.remarks()) };
    assert!(remark.contains("x.fmu: modelDescription.xml is in ISO-8859-1"), "{remark}");
    let undeclared = plain_xml().replace("name=\"gain\"", "name=\"Verstärkung\"");
    assert!(matches!(open(&undeclared), Err(Error::NotUtf8 { .. })));
}

#[test]
fn a_unit_has_the_name_of_its_model_or_its_file() {
    let named = |model: &str, file: &str| {
        let xml = plain_xml().replace("modelName=\"Test\"", &format!("modelName=\"{model}\""));
        let bytes = zip_of(&[("modelDescription.xml", xml.as_bytes())]);
        Archive::from_bytes(&bytes, file).unwrap().unit_name()
    };
    assert_eq!(named("Car", "x.fmu"), "Car");
    assert_eq!(named("Plants.Car", "Car.fmu"), "Car");
    assert_eq!(named("Plants.Car", "Plants.Car.fmu"), "Plants_Car");
    assert_eq!(named("", "x.FMU"), "x");
}

#[cfg(target_os = "linux")]
#[test]
fn an_undefined_symbol_of_python_names_its_library() {
    let Some(python) = library(Behaviour::Python) else { return };
    let xml = plain_xml();
    let files = [("modelDescription.xml", xml.as_bytes()), (&*binary_path(), python)];
    let error = Archive::from_bytes(&zip_of(&files), "x.fmu").unwrap().load().unwrap_err();
    let text = error.to_string();
    assert!(text.contains("Py_Initialize is of libpython"), "{text}");
    assert!(error.hint().contains("LD_PRELOAD=libpython"), "{}", error.hint());
}

#[test]
fn a_binary_that_is_no_fmu_is_refused() {
    let xml = plain_xml();
    let open = |binary: &[u8]| {
        let files = [("modelDescription.xml", xml.as_bytes()), (&binary_path(), binary)];
        Archive::from_bytes(&zip_of(&files), "x.fmu").unwrap().load().unwrap_err()
    };
    assert!(matches!(open(b"no library"), Error::Load { .. }));
    let Some(incomplete) = library(Behaviour::Incomplete) else { return };
    let error = open(incomplete).to_string();
    assert!(error.contains("a function is missing: fmi2GetStringStatus"), "{error}");
    let Some(version_1) = library(Behaviour::Version1) else { return };
    let error = open(version_1).to_string();
    assert!(error.contains("fmi2GetVersion returns \"1.0\""), "{error}");
}
