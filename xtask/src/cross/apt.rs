//! Programs on this machine, and the installation of Debian's packages.

use crate::run::run;
use std::env;
use std::path::PathBuf;
use std::process::Command;

/// Programs outside of the path, as Debian installs wine without its wrapper scripts.
const ELSEWHERE: &[&str] = &["/usr/lib/wine"];

/// Where a program is.
pub(crate) fn find(program: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&path)
        .chain(ELSEWHERE.iter().map(PathBuf::from))
        .map(|folder| folder.join(program))
        .find(|file| file.is_file())
}

/// Installs Debian's packages, as root.
pub(crate) fn apt(packages: &[&str]) -> Result<(), String> {
    update()?;
    run(Command::new("apt-get")
        .env("DEBIAN_FRONTEND", "noninteractive")
        .args(["install", "--yes", "--quiet=2", "--no-install-recommends"])
        .args(packages))
}

/// Refreshes apt's lists.
pub(crate) fn update() -> Result<(), String> {
    run(Command::new("apt-get").args(["update", "--quiet=2"]))
}

pub(crate) fn is_root() -> bool {
    Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}
