//! Requirements of the builds and runs: Debian's packages, and the Python environment
//! that holds zig.

use super::apt::{apt, find, is_root};
use super::folder;
use super::platform::{GLIBC, Platform, Runner};
use super::toolchain::{Source, toolchain};
use crate::python;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// A program, or a file by its whole path, and Debian's package with it.
struct Needed {
    program: &'static str,
    package: &'static str,
}

/// Where an ARM machine's C library is, for qemu.
pub(crate) const ARM_ROOT: &str = "/usr/aarch64-linux-gnu";

const MINGW: Needed =
    Needed { program: "x86_64-w64-mingw32-gcc", package: "gcc-mingw-w64-x86-64-win32" };
const QEMU: Needed = Needed { program: "qemu-aarch64-static", package: "qemu-user-static" };
const ARM_LIBRARIES: Needed = Needed {
    program: "/usr/aarch64-linux-gnu/lib/ld-linux-aarch64.so.1",
    package: "libc6-arm64-cross",
};
const WINE: Needed = Needed { program: "wine64", package: "wine64" };

/// The programs that are missing for building for the platforms, and with `running` also for running
/// their libraries.
fn missing(platforms: &[Platform], running: bool) -> Vec<Needed> {
    let mut all = Vec::new();
    if platforms.contains(&Platform::Win64) {
        all.push(MINGW);
    }
    for platform in platforms.iter().filter(|_| running) {
        match platform.runner() {
            Runner::Wine => all.push(WINE),
            Runner::Qemu => all.extend([QEMU, ARM_LIBRARIES]),
            Runner::Itself | Runner::Nothing => {}
        }
    }
    all.retain(|needed| find(needed.program).is_none());
    all
}

/// An error with the packages to install, if a program is missing.
pub(crate) fn check(platforms: &[Platform], running: bool) -> Result<(), String> {
    let missing = missing(platforms, running);
    if missing.is_empty() {
        return Ok(());
    }
    let programs: Vec<_> = missing.iter().map(|n| n.program).collect();
    Err(format!(
        "not found: {}\nhint: {}, or `cargo xtask cross --setup` as root",
        programs.join(", "),
        apt_line(&missing)
    ))
}

fn apt_line(missing: &[Needed]) -> String {
    let packages: Vec<_> = missing.iter().map(|n| n.package).collect();
    format!("apt-get install --no-install-recommends {}", packages.join(" "))
}

/// Installs the missing packages, as root; other users get the command to run. Then installs zig and
/// the toolchains, without root.
pub(crate) fn install(platforms: &[Platform], source: Source) -> Result<(), String> {
    let missing = missing(platforms, true);
    if !missing.is_empty() {
        if find("apt-get").is_none() {
            return check(platforms, true);
        }
        if !is_root() {
            return Err(format!("only root can install\nhint: sudo {}", apt_line(&missing)));
        }
        let packages: Vec<_> = missing.iter().map(|n| n.package).collect();
        apt(&packages)?;
    }
    check(platforms, true)?;
    zig()?;
    for &platform in platforms {
        toolchain(platform, source)?;
    }
    Ok(())
}

/// zig and cargo-zigbuild, from their Python packages: the folder of the environment's programs.
pub(crate) fn zig() -> Result<PathBuf, String> {
    let requirements = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/cross/requirements.txt");
    let python = python::environment_in(&folder().join("tools/zig"), &requirements)?;
    python.parent().map(Path::to_path_buf).ok_or_else(|| "no folder of programs".into())
}

/// A program that links for this machine's platform with the oldest glibc that the FMU libraries run with.
pub(crate) fn linker() -> Result<PathBuf, String> {
    let programs = zig()?;
    let tools = folder().join("tools");
    let (major, minor) = GLIBC;
    let script = format!(
        "#!/bin/sh\nexport PATH='{0}':\"$PATH\" ZIG_GLOBAL_CACHE_DIR='{1}/zig-cache' \
         CARGO_ZIGBUILD_CACHE_DIR='{1}/zigbuild-cache'\nexec '{0}/cargo-zigbuild' zig cc -- -g0 \
         -fno-sanitize=all -target x86_64-linux-gnu.{major}.{minor} \"$@\"\n",
        programs.display(),
        tools.display(),
    );
    let file = tools.join("linker");
    let written = fs::write(&file, script)
        .and_then(|()| fs::set_permissions(&file, fs::Permissions::from_mode(0o755)));
    written.map_err(|e| format!("{}: {e}", file.display()))?;
    Ok(file)
}
