//! The program alone, on a machine without a compiler.

use crate::support::{archives, demo, text_of};
use std::fs;
use std::path::Path;
use std::process::Command;
use steerwright_packaging::Fmu;

#[test]
fn a_copied_binary_packs_the_same_archives_with_an_empty_environment() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("installed");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let program = folder.join("steerwright");
    fs::copy(env!("CARGO_BIN_EXE_steerwright"), &program).unwrap();
    let files = Fmu::ALL.map(|fmu| format!("{}.json", fmu.folder()));
    let made = demo().folder.join("multibody");
    for (fmu, file) in Fmu::ALL.iter().zip(&files) {
        let file = folder.join(file);
        // What the demo does not make is an example.
        if made.join(format!("fmu/{}.fmu", fmu.name())).is_file() {
            fs::copy(made.join(fmu.resource()), &file).unwrap();
        } else {
            fs::write(&file, fmu.example()).unwrap();
        }
    }
    let output = Command::new(&program)
        .arg("package")
        .args(&files)
        .args(["--out", "fmu"])
        .current_dir(&folder)
        .env_clear()
        .env("PATH", "/nonexistent")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text_of(&output));
    for name in Fmu::ALL.map(Fmu::name) {
        let archive = format!("{name}.fmu");
        let packed = fs::read(folder.join("fmu").join(&archive)).unwrap();
        let elsewhere = fs::read(archives().join(&archive)).unwrap();
        assert!(packed == elsewhere, "{archive} differs");
    }
}
