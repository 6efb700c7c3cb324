//! The program as `cargo xtask evaluate` starts it. This test also has `cargo test` build it, with the
//! features that shared dependencies have there.
#![allow(clippy::unwrap_used)]

use std::process::Command;

#[test]
fn a_program_is_chosen_by_its_name() {
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_evaluation")).args(arguments).output().unwrap()
    };
    let help = run(&["orders", "--help"]);
    assert!(help.status.success());
    assert!(String::from_utf8_lossy(&help.stdout).contains("--systems"));
    let unknown = run(&["nothing"]);
    assert!(!unknown.status.success());
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("no program nothing"));
}
