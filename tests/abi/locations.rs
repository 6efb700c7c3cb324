//! The resource location in every spelling, through the built libraries.

use crate::samples::{Sample, samples};
use crate::unit::Birth;
use std::ffi::CString;
use std::path::Path;

/// The log of a refused instantiation with that location; `None` if it succeeds.
fn refusal(sample: &Sample, location: Option<&[u8]>) -> Option<String> {
    let mut birth = Birth::of(sample);
    birth.location = location.map(|bytes| CString::new(bytes).unwrap());
    let unit = birth.give(sample);
    if !unit.component.is_null() {
        return None;
    }
    let lines = unit.lines.take();
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert_eq!((lines[0].status, &*lines[0].category), (3, "logStatusError"));
    assert!(lines[0].text.starts_with("fmi2Instantiate: "), "{lines:?}");
    Some(lines[0].text.clone())
}

fn copy(sample: &Sample, folder: &Path) {
    std::fs::create_dir_all(folder).unwrap();
    for entry in std::fs::read_dir(sample.folder.join("resources")).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
    }
}

/// Every byte but the plainest, escaped.
fn escaped(path: &str) -> String {
    let byte = |b: u8| match b {
        b'/' | b'.' | b'-' | b'_' | b':' => char::from(b).to_string(),
        b if b.is_ascii_alphanumeric() => char::from(b).to_string(),
        b => format!("%{b:02X}"),
    };
    path.bytes().map(byte).collect()
}

#[test]
#[cfg(unix)]
fn every_spelling_of_every_folder() {
    let base = tempfile::tempdir().unwrap();
    for sample in samples() {
        for name in
            ["plain", "with spaces in it", "Größe/資料/дорога", "100%", "a%20b", "a+b&c=d'e"]
        {
            let folder = base.path().join(sample.name()).join(name).join("resources");
            copy(sample, &folder);
            let path = folder.to_str().unwrap();
            let code = escaped(path);
            let mut spellings = vec![
                format!("file://localhost{code}"),
                format!("FILE://{code}"),
                format!("file://{code}/"),
                path.to_owned(),
                format!("{path}/"),
            ];
            // One, three and four slashes; escaped, and not, as many importers have it.
            for start in ["file:", "file://", "file:///"] {
                spellings.extend([&code, path].map(|path| format!("{start}{path}")));
            }
            for spelling in spellings {
                let refused = refusal(sample, Some(spelling.as_bytes()));
                assert_eq!(refused, None, "{} {spelling}", sample.name());
            }
        }
    }
}

#[test]
fn what_is_no_folder_is_refused() {
    for sample in samples() {
        let folder = sample.folder.join("resources");
        let file = folder.read_dir().unwrap().next().map(|entry| entry.unwrap().path());
        let mut bad: Vec<(Vec<u8>, &str)> = vec![
            (b"".into(), "is empty"),
            (b"file:".into(), "names no folder"),
            (b"file://".into(), "names no folder"),
            (b"http://example.org/resources".into(), "is not a file: URI"),
            (b"ftp://example.org/resources".into(), "is not a file: URI"),
        ];
        if cfg!(unix) {
            bad.push((b"file://elsewhere/resources".into(), "is on another host, elsewhere"));
        }
        if let Some(file) = file {
            bad.push((format!("file://{}", file.display()).into_bytes(), "cannot read"));
            // Where nothing is there is no file, so it is not the archive of this GUID.
            bad.push((b"file:///there/is/no/such/folder".into(), "the GUID given is"));
            bad.push((b"file:///not\xff\xfeUTF-8".into(), "the GUID given is"));
            let none = refusal(sample, None).unwrap();
            assert!(none.contains("the GUID given is") && none.contains("0 resource files"));
        }
        for (location, expected) in bad {
            let shown = String::from_utf8_lossy(&location).into_owned();
            let logged = refusal(sample, Some(&location)).unwrap_or_default();
            assert!(logged.contains(expected), "{} {shown}: {logged}", sample.name());
        }
    }
}

/// One byte more in a file, or a file more: another archive.
#[test]
fn changed_resources_are_refused() {
    for sample in samples() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path().join("resources");
        copy(sample, &folder);
        let uri = crate::samples::uri_of(&folder).into_bytes();
        assert_eq!(refusal(sample, Some(&uri)), None);
        std::fs::write(folder.join("more"), "").unwrap();
        let logged = refusal(sample, Some(&uri)).unwrap();
        assert!(
            logged.contains("description, library and resources are not of one archive"),
            "{logged}"
        );
        std::fs::remove_file(folder.join("more")).unwrap();
        for entry in folder.read_dir().unwrap() {
            let path = entry.unwrap().path();
            let mut bytes = std::fs::read(&path).unwrap();
            bytes.push(b' ');
            std::fs::write(&path, bytes).unwrap();
            let logged = refusal(sample, Some(&uri)).unwrap();
            assert!(logged.contains("are not of one archive"), "{logged}");
        }
    }
}
