//! The book's tutorial: its commands run, and what it shows is printed. Its Python is run by hand.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

/// Language and content of each fenced block.
fn blocks(page: &str) -> Vec<(&str, &str)> {
    let fenced = page.split("```").skip(1).step_by(2);
    fenced.filter_map(|block| block.split_once('\n')).collect()
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn the_tutorial_shows_what_is_printed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(root.join("examples"), folder.path().join("examples")).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_steerwright")).parent().unwrap().to_path_buf();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([program].into_iter().chain(std::env::split_paths(&path)));
    let path = path.unwrap();
    let mut printed = String::new();
    let (mut commands, mut lines) = (0, 0);
    for (language, block) in blocks(include_str!("../../docs/tutorial.md")) {
        if block.starts_with("steerwright ") {
            let output = Command::new("sh")
                .args(["-c", block])
                .current_dir(folder.path())
                .env("PATH", &path)
                .output()
                .unwrap();
            let text = [output.stdout, output.stderr].concat();
            printed = String::from_utf8(text).unwrap();
            // 1: a requirement or a validation is not met, which the tutorial shows.
            assert!(matches!(output.status.code(), Some(0 | 1)), "{block}{printed}");
            commands += 1;
        } else if language == "python" {
            printed.clear();
        } else if !printed.is_empty() {
            for line in block.lines() {
                // Any text may be between the parts.
                for part in line.split('…').map(str::trim).filter(|part| !part.is_empty()) {
                    assert!(printed.contains(part), "not printed: {part:?}\n{printed}");
                    lines += 1;
                }
            }
        }
    }
    assert!(commands >= 9 && lines >= 50, "{commands} commands, {lines} lines");
}
