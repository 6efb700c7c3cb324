//! The book's guide to a first FMU, followed step by step.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use std::fs;
use std::path::Path;
use std::process::Command;

/// The contents of the fenced blocks of a language, in order.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    page.split(&fence).skip(1).filter_map(|rest| Some(rest.split_once("```")?.0)).collect()
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_guide_to_the_first_fmu_works() {
    let page = include_str!("../../docs/first-fmu.md");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    };
    let ([manifest], [model, describe], [steps]) =
        (&*blocks(page, "toml"), &*blocks(page, "rust"), &*blocks(page, "sh"))
    else {
        panic!("the guide has other blocks than the files and steps of this test")
    };
    // A package outside of the workspace, with the crate of this clone and its versions.
    let here = format!("fmi2-export = {{ path = {:?} }}", root.join("fmu/export"));
    assert!(manifest.contains("fmi2-export = \"0.1\""), "{manifest}");
    let manifest = manifest.replace("fmi2-export = \"0.1\"", &here);
    write("Cargo.toml", &format!("{manifest}\n[workspace]\n"));
    write("Cargo.lock", &fs::read_to_string(root.join("Cargo.lock")).unwrap());
    write("src/lib.rs", model);
    write("src/bin/describe.rs", describe);
    // What was built by an earlier run is used again.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("first-fmu");
    fs::create_dir_all(&target).unwrap();
    std::os::unix::fs::symlink(target, folder.path().join("target")).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_steerwright")).parent().unwrap().to_path_buf();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([program].into_iter().chain(std::env::split_paths(&path)));
    let output = Command::new("sh")
        .args(["-e", "-c", steps])
        .current_dir(folder.path())
        .env("PATH", path.unwrap())
        .env_remove("CARGO_TARGET_DIR")
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    let problems = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{printed}{problems}");
    assert!(printed.contains("no breach of FMI 2.0 found"), "{printed}");
}
