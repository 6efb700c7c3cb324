//! Builds the FMU libraries, or takes ready ones, and writes the table that `lib.rs` includes.
//!
//! The libraries are built by a cargo of their own: in a target folder and a profile of their own
//! (unwinding on, whatever the outer profile says), one library a crate, since two crates that
//! export the same C symbols must never be linked into one binary. Each step is a line on stderr, which cargo
//! shows with `-vv` and where the build fails.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

include!("libraries.rs");

/// The crates that the libraries link, whose manifests say with what features.
const LINKED: [&str; 5] = ["formats", "modelDescription", "fmu/models", "fmu/export", "fmu/units"];

/// What the outer cargo sets for its own build and the inner one must not inherit.
const NOT_INHERITED: [&str; 9] = [
    "CARGO_BUILD_RUSTFLAGS",
    "CARGO_BUILD_TARGET",
    "CARGO_BUILD_TARGET_DIR",
    "CARGO_ENCODED_RUSTFLAGS",
    "CARGO_TARGET_DIR",
    "RUSTC",
    "RUSTC_WORKSPACE_WRAPPER",
    "RUSTC_WRAPPER",
    "RUSTFLAGS",
];

/// One library to embed.
struct Library {
    name: String,
    platform: String,
    file: PathBuf,
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=libraries.rs");
    println!("cargo::rerun-if-env-changed=STEERWRIGHT_FMU_BINARIES");
    let fmu = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?).join("..").canonicalize()?;
    let names = libraries(&fmu)?;
    let libraries = match env::var_os("STEERWRIGHT_FMU_BINARIES") {
        Some(folder) => ready(Path::new(&folder), &names)?,
        None => built(&fmu, &names)?,
    };
    let out = PathBuf::from(env::var("OUT_DIR")?);
    fs::write(out.join("libraries.rs"), table(&libraries))?;
    Ok(())
}

/// The libraries in `folder/<platform>/<Name>.<extension>`.
fn ready(folder: &Path, names: &[(String, String)]) -> Result<Vec<Library>, Box<dyn Error>> {
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut libraries = Vec::new();
    let read = |path: &Path| -> Result<Vec<PathBuf>, Box<dyn Error>> {
        let entries = fs::read_dir(path)
            .map_err(|e| format!("STEERWRIGHT_FMU_BINARIES: {}: {e}", path.display()))?;
        let mut paths =
            entries.map(|e| Ok(e?.path())).collect::<Result<Vec<_>, std::io::Error>>()?;
        paths.sort();
        Ok(paths)
    };
    for platform in read(folder)?.into_iter().filter(|p| p.is_dir()) {
        for file in read(&platform)? {
            let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            if names.iter().any(|(_, name)| *name == stem) {
                println!("cargo::rerun-if-changed={}", file.display());
                eprintln!("FMU libraries: {} is taken", file.display());
                let platform = platform.file_name().unwrap_or_default().to_string_lossy();
                libraries.push(Library { name: stem, platform: platform.into_owned(), file });
            }
        }
    }
    if libraries.is_empty() {
        return Err(format!(
            "STEERWRIGHT_FMU_BINARIES: no <platform>/<FMU name>.<so|dll|dylib> in {}",
            folder.display()
        )
        .into());
    }
    Ok(libraries)
}

/// Builds the libraries for the target of this build.
fn built(fmu: &Path, names: &[(String, String)]) -> Result<Vec<Library>, Box<dyn Error>> {
    let root = fmu.join("..").canonicalize()?;
    let target = env::var("TARGET")?;
    // <target>/<profile>/build/<package>/out: debug and release builds share the libraries.
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let folder = out.ancestors().nth(4).ok_or("OUT_DIR is not in a target folder")?.join("fmu");

    let mut cargo = Command::new(env::var("CARGO")?);
    for name in NOT_INHERITED {
        cargo.env_remove(name);
    }
    // CARGO_PROFILE_* would change the profile, CARGO_TARGET_<TRIPLE>_RUSTFLAGS the code.
    for (name, _) in env::vars() {
        let target_flags = name.starts_with("CARGO_TARGET_") && name.ends_with("RUSTFLAGS");
        if name.starts_with("CARGO_PROFILE_") || target_flags {
            cargo.env_remove(name);
        }
    }
    cargo
        .current_dir(&root)
        .env("CARGO_ENCODED_RUSTFLAGS", remapped_paths(&root, &folder))
        .args(["build", "--profile", "fmu", "--target", &target, "--target-dir"])
        .arg(&folder);
    for (crate_, _) in names {
        cargo.args(["--package", &format!("steerwright-{crate_}")]);
    }
    eprintln!("FMU libraries: building {} for {target} in {}", names.len(), folder.display());
    let status = cargo.status()?;
    if !status.success() {
        return Err(
            format!("building the FMU libraries failed: {cargo:?} ended with {status}").into()
        );
    }

    let products = folder.join(&target).join("fmu");
    let platform = platform(&target)?;
    let mut sources = BTreeSet::new();
    let mut libraries = Vec::new();
    for (crate_, name) in names {
        let file = products.join(library_file(&target, &crate_.replace('-', "_")));
        sources.extend(dependencies(&file.with_extension("d"))?);
        // A name of its own in OUT_DIR, so that a later inner build cannot swap what was embedded.
        let copy = out.join(format!("{name}.library"));
        let size = fs::copy(&file, &copy).map_err(|e| format!("{}: {e}", file.display()))?;
        eprintln!("FMU libraries: {name} for {platform}, {size} bytes");
        libraries.push(Library { name: name.clone(), platform: platform.into(), file: copy });
    }
    sources.extend(LINKED.iter().map(|crate_| root.join(crate_).join("Cargo.toml")));
    sources.extend(names.iter().map(|(crate_, _)| fmu.join(crate_).join("Cargo.toml")));
    // A folder that comes or goes.
    sources.insert(fmu.to_owned());
    sources.extend(["Cargo.toml", "Cargo.lock"].map(|file| root.join(file)));
    for source in sources {
        println!("cargo::rerun-if-changed={}", source.display());
    }
    Ok(libraries)
}

/// Flags that keep the paths of the building machine out of the binaries.
fn remapped_paths(root: &Path, target_folder: &Path) -> String {
    let home = |name: &str, below: &str| {
        env::var_os(name)
            .map(PathBuf::from)
            .or_else(|| env::var_os("HOME").map(|home| PathBuf::from(home).join(below)))
    };
    let mut flags = Vec::new();
    let prefixes = [
        (home("CARGO_HOME", ".cargo"), "cargo"),
        (home("RUSTUP_HOME", ".rustup"), "rustup"),
        (Some(root.to_path_buf()), "steerwright"),
        (Some(target_folder.to_path_buf()), "target"),
    ];
    for (from, to) in prefixes {
        if let Some(from) = from {
            flags.push(format!("--remap-path-prefix={}={to}", from.display()));
        }
    }
    flags.join("\u{1f}")
}

/// The files a library was made from, by cargo's dependency file next to it.
fn dependencies(file: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let text = fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let (_, list) = text.split_once(": ").unwrap_or_default();
    let escaped = list.trim().replace("\\ ", "\u{1f}");
    Ok(escaped.split_whitespace().map(|p| p.replace('\u{1f}', " ").into()).collect())
}

/// FMI's name of the platform.
fn platform(target: &str) -> Result<&'static str, String> {
    let table = [
        ("x86_64", "linux", "linux64"),
        ("x86_64", "windows", "win64"),
        ("x86_64", "darwin", "darwin64"),
        ("aarch64", "linux", "aarch64-linux"),
        ("aarch64", "darwin", "aarch64-darwin"),
    ];
    table
        .iter()
        .find(|(cpu, system, _)| target.starts_with(cpu) && target.contains(system))
        .map(|(_, _, name)| *name)
        .ok_or_else(|| format!("no FMI platform is known for the target {target}"))
}

fn library_file(target: &str, name: &str) -> String {
    if target.contains("windows") {
        format!("{name}.dll")
    } else if target.contains("darwin") {
        format!("lib{name}.dylib")
    } else {
        format!("lib{name}.so")
    }
}

fn table(libraries: &[Library]) -> String {
    let rows: String = libraries
        .iter()
        .map(|l| {
            format!(
                "    Library {{ name: {:?}, platform: {:?}, bytes: include_bytes!({:?}) }},\n",
                l.name, l.platform, l.file
            )
        })
        .collect();
    format!("static LIBRARIES: &[Library] = &[\n{rows}];\n")
}
