//! Archives to check: a valid one, and one for each of many seeded faults.
#![allow(dead_code, clippy::unwrap_used, clippy::panic)]

mod faults;

pub(crate) use faults::faults;

use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

const XML: &str = include_str!("base.xml");
/// The source files of the base's binary.
const SOURCES: [(&str, &str); 3] = [
    ("base.rs", include_str!("../library/base.rs")),
    ("states.rs", include_str!("../library/states.rs")),
    ("variables.rs", include_str!("../library/variables.rs")),
];

/// The files of an archive, in order.
#[derive(Clone)]
pub(crate) struct Files(pub(crate) Vec<(String, Vec<u8>)>);

impl Files {
    pub(crate) fn get(&mut self, name: &str) -> &mut Vec<u8> {
        let file = self.0.iter_mut().find(|(other, _)| other == name);
        &mut file.unwrap_or_else(|| panic!("no {name}")).1
    }

    pub(crate) fn replace(&mut self, from: &str, to: &str) {
        let xml = self.get("modelDescription.xml");
        let text = String::from_utf8(xml.clone()).unwrap();
        assert!(text.contains(from), "{from} is not in the description");
        *xml = text.replacen(from, to, 1).into_bytes();
    }

    pub(crate) fn add(&mut self, name: &str, bytes: &[u8]) {
        self.0.push((name.into(), bytes.to_vec()));
    }

    pub(crate) fn remove(&mut self, name: &str) {
        self.get(name);
        self.0.retain(|(other, _)| other != name);
    }

    pub(crate) fn rename(&mut self, from: &str, to: &str) {
        let bytes = self.get(from).clone();
        self.remove(from);
        self.add(to, &bytes);
    }

    /// The archive of these files.
    pub(crate) fn zip(&self) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .unix_permissions(0o644);
        for (name, bytes) in &self.0 {
            let stored = options.compression_method(CompressionMethod::Stored);
            let options = if name.ends_with(".bin") { stored } else { options };
            zip.start_file(name.as_str(), options).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }
}

/// The folder and name of the base's binary on the running platform.
pub(crate) fn binary_name() -> String {
    format!(
        "binaries/{}/{}",
        steerwright_host::platform_folders()[0],
        steerwright_host::binary_name("Base")
    )
}

/// The files of the base archive, which has no faults.
pub(crate) fn base() -> Files {
    let mut files = Files(Vec::new());
    files.add("modelDescription.xml", XML.as_bytes());
    files.add(&binary_name(), library());
    files.add("sources/base.c", b"int base;\n");
    files.add("resources/data.txt", b"data\n");
    files.add("documentation/index.html", b"<!DOCTYPE html><title>Base</title>\n");
    files.add("documentation/licenses/license.txt", b"None.\n");
    files
}

/// The base's binary, built once for a test binary.
pub(crate) fn library() -> &'static [u8] {
    static LIBRARY: OnceLock<Vec<u8>> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let (source, library) = (folder.path().join("base.rs"), folder.path().join("base.library"));
        for (name, text) in SOURCES {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let status = Command::new(rustc)
            .args(["--edition", "2024", "--crate-type", "cdylib", "--crate-name", "base"])
            .args(["-C", "panic=abort", "-C", "opt-level=1", "-C", "strip=symbols"])
            .args(["-A", "warnings", "-o"])
            .args([&library, &source])
            .status()
            .unwrap();
        assert!(status.success(), "the test library does not build");
        std::fs::read(library).unwrap()
    })
}

/// Writes the valid archive and every faulty one into a folder.
pub(crate) fn write(folder: &Path) -> Vec<PathBuf> {
    std::fs::create_dir_all(folder).unwrap();
    let good = folder.join("good.fmu");
    std::fs::write(&good, base().zip()).unwrap();
    let mut files = vec![good];
    for fault in faults() {
        let file = folder.join(format!("{}.fmu", fault.name));
        std::fs::write(&file, fault.archive()).unwrap();
        files.push(file);
    }
    files
}
