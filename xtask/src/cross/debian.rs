//! Debian's Rust compiler and the source of its standard library, unpacked into a folder of their
//! own: nothing is installed, and no root is needed.

use super::{apt, folder};
use crate::files::remove;
use crate::run::{run, shown};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The compiler that Debian keeps new for its web browsers.
const COMPILER: &str = "rustc-web";
/// The source of its standard library.
const SOURCE: &str = "rust-web-src";
/// The compiler's own libraries.
const LIBRARIES: &str = "libstd-rust-web-dev";

/// An unpacked compiler.
pub(crate) struct Compiler {
    /// Starts it.
    pub(crate) rustc: PathBuf,
    /// Its sysroot, with the source of the standard library.
    pub(crate) sysroot: PathBuf,
}

/// Unpacks the compiler, unless the newest version on offer is there already.
pub(crate) fn compiler() -> Result<Compiler, String> {
    let mut version = field(COMPILER, "Version");
    if version.is_err() && apt::find("apt-get").is_some() && apt::is_root() {
        apt::update()?;
        version = field(COMPILER, "Version");
    }
    let version = version.map_err(|e| {
        format!(
            "{e}\nhint: without rustup's targets this takes Debian's packages: `apt-get update` as \
             root, on Debian 12 or newer; `rustup target add` is the simpler way"
        )
    })?;
    let tools = folder().join("tools/rust");
    let compiler = Compiler { rustc: tools.join("rustc"), sysroot: tools.join("usr") };
    let stamp = tools.join("unpacked.txt");
    if fs::read_to_string(&stamp).is_ok_and(|unpacked| unpacked == version) {
        return Ok(compiler);
    }
    eprintln!("unpacking Debian's Rust compiler and standard library, {version}");
    let said = |path: &Path| {
        let path = path.display().to_string();
        move |e: std::io::Error| format!("{path}: {e}")
    };
    remove(&tools)?;
    let downloads = tools.join("downloads");
    fs::create_dir_all(&downloads).map_err(said(&downloads))?;

    let exactly = |package: &str| format!("{package}={version}");
    let standard = dependency(&exactly(LIBRARIES), "libstd-rust-web-")?;
    let llvm = dependency(&exactly(&standard), "libllvm")?;
    run(Command::new("apt-get")
        .args(["download", "--quiet=2", "--option", "APT::Sandbox::User=root"])
        .args([COMPILER, SOURCE, LIBRARIES, &standard].map(exactly))
        .arg(llvm)
        .current_dir(&downloads))?;
    let entries = fs::read_dir(&downloads).map_err(said(&downloads))?;
    for package in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        unpack(&package, &tools)?;
    }
    remove(&downloads)?;

    let libraries = compiler.sysroot.join("lib/x86_64-linux-gnu");
    let script = format!(
        "#!/bin/sh\nLD_LIBRARY_PATH='{}' exec '{}' \"$@\"\n",
        libraries.display(),
        compiler.sysroot.join("bin/rustc").display()
    );
    fs::write(&compiler.rustc, script).map_err(said(&compiler.rustc))?;
    fs::set_permissions(&compiler.rustc, fs::Permissions::from_mode(0o755))
        .map_err(said(&compiler.rustc))?;
    run(Command::new(&compiler.rustc).arg("--version"))?;
    fs::write(&stamp, version).map_err(said(&stamp))?;
    Ok(compiler)
}

/// Unpacks a package; of the source, which is mostly LLVM and the compiler, the library alone.
fn unpack(package: &Path, to: &Path) -> Result<(), String> {
    let name = package.file_name().unwrap_or_default().to_string_lossy();
    if !name.starts_with(SOURCE) {
        return run(Command::new("dpkg").arg("-x").args([package, to]));
    }
    let mut dpkg = Command::new("dpkg-deb");
    dpkg.arg("--fsys-tarfile").arg(package).stdout(Stdio::piped());
    let line = shown(&dpkg);
    let mut dpkg = dpkg.spawn().map_err(|e| format!("{line}: {e}"))?;
    let mut tar = Command::new("tar");
    tar.args(["--extract", "--wildcards", "--directory"]).arg(to);
    tar.args(["./usr/src/*/library/*", "./usr/lib/rustlib/src/*"]);
    tar.stdin(match dpkg.stdout.take() {
        Some(value) => Stdio::from(value),
        None => Stdio::null(),
    });
    let unpacked = run(&mut tar);
    let status = dpkg.wait().map_err(|e| format!("{line}: {e}"))?;
    unpacked?;
    if status.success() { Ok(()) } else { Err(format!("{line}: {status}")) }
}

/// A field of the newest version of a package in the lists of apt.
fn field(package: &str, name: &str) -> Result<String, String> {
    let mut apt = Command::new("apt-cache");
    apt.args(["show", "--no-all-versions", package]).env("LC_ALL", "C");
    let output = apt.output().map_err(|e| format!("{}: {e}", shown(&apt)))?;
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .find_map(|line| Some(line.strip_prefix(name)?.strip_prefix(": ")?.to_owned()))
        .ok_or_else(|| format!("no package {package} in the lists of apt"))
}

/// The dependency of a package whose name begins so.
fn dependency(package: &str, prefix: &str) -> Result<String, String> {
    field(package, "Depends")?
        .split(", ")
        .filter_map(|entry| entry.split_whitespace().next())
        .find(|name| name.starts_with(prefix))
        .map(str::to_owned)
        .ok_or_else(|| format!("{package} depends on no {prefix}…"))
}
