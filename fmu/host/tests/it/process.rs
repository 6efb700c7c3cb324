//! A process that runs FMUs ends with its parent, on every platform.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use steerwright_host::process::{Subprocess, end_with_parent};

const ROLE: &str = "STEERWRIGHT_TEST_ROLE";
const FOLDER: &str = "STEERWRIGHT_TEST_FOLDER";

/// This program once more, for [`has_a_role`].
fn again(role: &str, folder: &Path) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "process::has_a_role"]).env(ROLE, role).env(FOLDER, folder);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// What the other processes of the next test do; nothing in a usual run.
#[test]
fn has_a_role() {
    let folder = PathBuf::from(std::env::var_os(FOLDER).unwrap_or_default());
    match std::env::var(ROLE).as_deref() {
        Ok(role @ ("parent" | "parent-with-input")) => {
            let mut child = again("child", &folder);
            let _child = match role {
                "parent" => Subprocess::start(&mut child),
                _ => Subprocess::start_with_input(&mut child),
            };
            loop {
                std::thread::sleep(Duration::from_secs(1));
            }
        }
        Ok("child") => {
            end_with_parent().unwrap();
            let lock = File::create(folder.join("lock")).unwrap();
            lock.lock().unwrap();
            fs::write(folder.join("locked"), "").unwrap();
            // As an FMU that does not return.
            loop {
                std::hint::spin_loop();
            }
        }
        _ => {}
    }
}

#[test]
fn a_hanging_process_ends_with_its_killed_parent() {
    hangs_and_ends("parent");
    hangs_and_ends("parent-with-input");
}

fn hangs_and_ends(role: &str) {
    let folder = tempfile::tempdir().unwrap();
    let began = Instant::now();
    let in_time = || assert!(began.elapsed() < Duration::from_secs(120));
    let mut parent = again(role, folder.path()).spawn().unwrap();
    while !folder.path().join("locked").exists() {
        in_time();
        std::thread::sleep(Duration::from_millis(5));
    }
    let lock = File::options().write(true).open(folder.path().join("lock")).unwrap();
    assert!(lock.try_lock().is_err(), "the process runs");
    parent.kill().unwrap();
    parent.wait().unwrap();
    // The system frees the lock with the process.
    while lock.try_lock().is_err() {
        in_time();
        std::thread::sleep(Duration::from_millis(5));
    }
}
