//! Builds the FMU libraries for a platform, with no path of this machine in them.

use super::platform::{Format, GLIBC, MACOS, Platform};
use super::toolchain::Toolchain;
use super::{LIBRARIES, binaries, folder};
use crate::run::{cargo, root, run};
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Builds every library and copies it to `binaries/<platform>/<FMU name>.<extension>`. `zig` is the
/// folder of zig's programs.
pub(crate) fn build(platform: Platform, toolchain: &Toolchain, zig: &Path) -> Result<(), String> {
    let target = toolchain.target(platform);
    let products = folder().join("build");
    if platform.format() == Format::MachO {
        // One at a time: a library of macOS holds its own name.
        for (package, name) in LIBRARIES.iter() {
            let link = format!("-Clink-arg=-Wl,-install_name,@rpath/{name}.dylib");
            // Without `-S` the linker would list the object files, with their paths, for a debugger.
            let mut one = command(platform, toolchain, zig, "rustc", &[package]);
            run(one.args(["--", &link, "-Clink-arg=-Wl,-S"]))?;
        }
    } else {
        let packages: Vec<_> = LIBRARIES.iter().map(|(package, _)| package.as_str()).collect();
        run(&mut command(platform, toolchain, zig, "build", &packages))?;
    }
    let to = binaries().join(platform.name());
    fs::create_dir_all(&to).map_err(|e| format!("{}: {e}", to.display()))?;
    for (package, name) in LIBRARIES.iter() {
        let from = products.join(target).join("fmu").join(platform.product(package));
        fs::copy(&from, to.join(format!("{name}.{}", platform.extension())))
            .map_err(|e| format!("{}: {e}", from.display()))?;
    }
    Ok(())
}

/// The command that builds some of the libraries.
fn command(
    platform: Platform,
    toolchain: &Toolchain,
    zig: &Path,
    action: &str,
    packages: &[&str],
) -> Command {
    let mut target = toolchain.target(platform).to_owned();
    let mut command = if platform.linked_by_zig() {
        if platform.format() == Format::Elf {
            target = format!("{target}.{}.{}", GLIBC.0, GLIBC.1);
        }
        let mut command = Command::new(zig.join("cargo-zigbuild"));
        command.arg(if action == "build" { "zigbuild" } else { action }).current_dir(root());
        let tools = folder().join("tools");
        command
            .env("PATH", path_with(zig))
            .env("ZIG_GLOBAL_CACHE_DIR", tools.join("zig-cache"))
            .env("CARGO_ZIGBUILD_CACHE_DIR", tools.join("zigbuild-cache"))
            .env("MACOSX_DEPLOYMENT_TARGET", MACOS);
        command
    } else {
        cargo(&[action])
    };
    for (name, _) in env::vars_os() {
        if inherited(&name.to_string_lossy()) {
            command.env_remove(&name);
        }
    }
    let mut flags = remapped_paths(toolchain);
    match platform.format() {
        // The linker would write the time of the build.
        Format::Pe => flags.push("-Clink-arg=-Wl,--no-insert-timestamp".into()),
        // Stripping is zig's linker's to do; the profile's `strip` calls a tool that is not there.
        Format::MachO => {
            command.env("CARGO_PROFILE_FMU_STRIP", "false");
        }
        Format::Elf => {}
    }
    command
        .env("CARGO_ENCODED_RUSTFLAGS", flags.join("\u{1f}"))
        .args(["--quiet", "--locked", "--profile", "fmu", "--target", &target, "--target-dir"])
        .arg(folder().join("build"));
    for package in packages {
        command.args(["--package", &format!("steerwright-{package}")]);
    }
    if let Toolchain::FromSource(compiler) = toolchain {
        command
            .env("RUSTC", &compiler.rustc)
            .env("RUSTC_BOOTSTRAP", "1")
            .arg("-Zbuild-std=std,panic_unwind");
    }
    command
}

/// Whether a variable that is set for `cargo xtask` would change this build.
fn inherited(name: &str) -> bool {
    name.starts_with("CARGO_PROFILE_")
        || name.starts_with("CARGO_TARGET_")
        || name.starts_with("CARGO_BUILD_")
        || name.starts_with("RUSTC")
        || ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS"].contains(&name)
}

/// The path with a folder before all others.
fn path_with(first: &Path) -> OsString {
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(first.to_path_buf()).chain(env::split_paths(&path));
    env::join_paths(folders).unwrap_or(path)
}

/// Folders of this machine whose paths must not be in a library.
pub(crate) fn machine_paths() -> Vec<(PathBuf, &'static str)> {
    let home = |name: &str, below: &str| {
        env::var_os(name)
            .map(PathBuf::from)
            .or_else(|| env::home_dir().map(|home| home.join(below)))
            .map(|folder| fs::canonicalize(&folder).unwrap_or(folder))
    };
    let mut paths = Vec::new();
    paths.extend(home("CARGO_HOME", ".cargo").map(|folder| (folder, "cargo")));
    paths.extend(home("RUSTUP_HOME", ".rustup").map(|folder| (folder, "rustup")));
    paths.push((root().to_path_buf(), "steerwright"));
    paths.push((folder(), "target"));
    paths
}

/// Flags that put names for the folders of this machine; the last that matches counts.
fn remapped_paths(toolchain: &Toolchain) -> Vec<String> {
    let mut paths = machine_paths();
    if let Toolchain::FromSource(compiler) = toolchain {
        paths.push((compiler.sysroot.clone(), "rust"));
    }
    let flag = |(from, to): (PathBuf, &str)| format!("--remap-path-prefix={}={to}", from.display());
    paths.into_iter().map(flag).collect()
}
