//! What is built does not say where: the same sources in two folders, built by users whose cargo keeps
//! its packages in different places, give the same libraries and the same archive, byte for byte.
#![cfg(unix)] // for a link
#![allow(clippy::unwrap_used, clippy::panic)]

use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const VEHICLE: &str = "examples/drives/multibody/vehicle.json";
const ARCHIVE: &str = "NonlinearVehicle.fmu";

/// Copies the sources: all but what was built and what git keeps.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let (path, name) = (entry.path(), entry.file_name());
        if name == "target" || name == ".git" {
            continue;
        }
        if path.is_dir() {
            copy(&path, &to.join(name));
        } else {
            fs::copy(&path, to.join(name)).unwrap();
        }
    }
}

/// Where cargo keeps what it downloads.
fn cargo_home() -> PathBuf {
    std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .unwrap_or_else(|| Path::new(&std::env::var_os("HOME").unwrap()).join(".cargo"))
}

/// Builds everything in a folder as a user does, into the target folder there, packs an archive,
/// and gives the digests of the libraries and of the archive.
fn digests(folder: &Path, cargo_home: &Path) -> BTreeMap<String, String> {
    let mut cargo = Command::new(env!("CARGO"));
    for (name, _) in std::env::vars() {
        if name.starts_with("CARGO") || name.starts_with("STEERWRIGHT") {
            cargo.env_remove(name);
        }
    }
    cargo.env("CARGO_HOME", cargo_home);
    // The program itself need not be fast; the libraries are built with a profile of their own.
    let quick = ["profile.dev.debug=false", "profile.dev.package.\"*\".opt-level=0"];
    cargo.current_dir(folder).env_remove("RUSTFLAGS").args(["run", "--quiet", "--locked"]);
    cargo.args(quick.iter().flat_map(|setting| ["--config", setting]));
    let status = cargo.args(["--", "package", VEHICLE, "--out", "out"]).status().unwrap();
    assert!(status.success(), "{}: {status}", folder.display());

    let mut files = vec![folder.join("out").join(ARCHIVE)];
    for triple in fs::read_dir(folder.join("target/fmu")).unwrap().map(Result::unwrap) {
        let products = triple.path().join("fmu");
        let is_library =
            |path: &Path| path.extension().is_some_and(|e| e == "so" || e == "dll" || e == "dylib");
        let entries = fs::read_dir(products).into_iter().flatten();
        files.extend(entries.map(|e| e.unwrap().path()).filter(|path| is_library(path)));
    }
    let digest = |path: &Path| {
        let bytes = Sha256::digest(fs::read(path).unwrap());
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    };
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    files.iter().map(|path| (name(path), digest(path))).collect()
}

#[test]
#[ignore = "minutes: cargo xtask stress"]
fn stress_two_folders_give_the_same_bytes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
    let place = tempfile::tempdir().unwrap();
    let folders =
        ["a", "a much/longer path to the same sources"].map(|name| place.path().join(name));
    // Both before the first is built: nobody's edits come between them.
    folders.iter().for_each(|folder| copy(root, folder));
    // The sources of packages show up in libraries by the paths that cargo knows them by.
    let home = cargo_home();
    let another = place.path().join("the home of another");
    std::os::unix::fs::symlink(&home, &another).unwrap();
    let [short, long] =
        [(&folders[0], &home), (&folders[1], &another)].map(|(folder, home)| digests(folder, home));
    assert_eq!(short.len(), 7, "six libraries and an archive: {short:#?}");
    for (name, digest) in &short {
        eprintln!("{digest}  {name}");
    }
    assert_eq!(short, long);
}
