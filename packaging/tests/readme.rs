//! The variable tables in the READMEs are those of the code.
//!
//! `STEERWRIGHT_UPDATE=1 cargo test -p steerwright-packaging readme` writes them again.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use steerwright_packaging::{Fmu, table_markdown, with_variables};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn holds(file: &Path, variables: &str) {
    let text = fs::read_to_string(file).unwrap();
    assert!(text.contains("<!-- variables:begin -->"), "{} has no mark", file.display());
    let expected = with_variables(&text, variables);
    if std::env::var_os("STEERWRIGHT_UPDATE").is_some() {
        fs::write(file, expected).unwrap();
        return;
    }
    assert!(
        text == expected,
        "{} is out of date; STEERWRIGHT_UPDATE=1 cargo test -p steerwright-packaging readme",
        file.display()
    );
}

#[test]
fn each_fmu_lists_its_variables() {
    for fmu in Fmu::ALL {
        holds(
            &root().join("fmu").join(fmu.folder()).join("README.md"),
            &table_markdown(fmu.table()),
        );
    }
}
