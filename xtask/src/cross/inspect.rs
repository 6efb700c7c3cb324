//! The properties of a built library: its format, exports, requirements on the system, and that it
//! names no folder of the machine that built it.

use super::build::machine_paths;
use super::platform::{Format, GLIBC, Platform};
use object::read::macho::LoadCommandVariant;
use object::read::{ImportFlags, NameOrOrdinal};
use object::{Architecture, File, Object};
use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::Path;

/// The functions of FMI 2.0 for Co-Simulation, without `fmi2`.
const FUNCTIONS: [&str; 34] = [
    "CancelStep",
    "DeSerializeFMUstate",
    "DoStep",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "FreeFMUstate",
    "FreeInstance",
    "GetBoolean",
    "GetBooleanStatus",
    "GetDirectionalDerivative",
    "GetFMUstate",
    "GetInteger",
    "GetIntegerStatus",
    "GetReal",
    "GetRealOutputDerivatives",
    "GetRealStatus",
    "GetStatus",
    "GetString",
    "GetStringStatus",
    "GetTypesPlatform",
    "GetVersion",
    "Instantiate",
    "Reset",
    "SerializeFMUstate",
    "SerializedFMUstateSize",
    "SetBoolean",
    "SetDebugLogging",
    "SetFMUstate",
    "SetInteger",
    "SetReal",
    "SetRealInputDerivatives",
    "SetString",
    "SetupExperiment",
    "Terminate",
];

/// The libraries that come with Linux's C library, with Windows, and with macOS.
const LINUX: [&str; 7] = [
    "ld-linux-aarch64.so.1",
    "ld-linux-x86-64.so.2",
    "libc.so.6",
    "libdl.so.2",
    "libgcc_s.so.1",
    "libm.so.6",
    "libpthread.so.0",
];
const WINDOWS: [&str; 5] =
    ["advapi32.dll", "bcryptprimitives.dll", "kernel32.dll", "msvcrt.dll", "ntdll.dll"];
const MACOS: [&str; 2] = ["/System/Library/", "/usr/lib/"];

/// Checks a library and returns its requirements on the system, in a line.
pub(crate) fn inspect(platform: Platform, name: &str, file: &Path) -> Result<String, String> {
    let bytes = fs::read(file).map_err(|e| format!("{}: {e}", file.display()))?;
    check(platform, name, &bytes).map_err(|e| format!("{}: {e}", file.display()))
}

fn check(platform: Platform, name: &str, bytes: &[u8]) -> Result<String, String> {
    let read = |e: object::Error| e.to_string();
    let library = File::parse(bytes).map_err(read)?;
    let format = match &library {
        File::Elf64(_) => Format::Elf,
        File::Pe64(_) => Format::Pe,
        File::MachO64(_) => Format::MachO,
        _ => return Err("no 64-bit library of Linux, Windows or macOS".into()),
    };
    let arm = matches!(platform, Platform::Aarch64Linux | Platform::Aarch64Darwin);
    let processor = if arm { Architecture::Aarch64 } else { Architecture::X86_64 };
    if (format, library.architecture()) != (platform.format(), processor) {
        return Err(format!("{format:?} for {:?}", library.architecture()));
    }

    let mut exported = BTreeSet::new();
    for export in library.exports().map_err(read)? {
        if let NameOrOrdinal::Name(name) = export.map_err(read)?.name() {
            exported.insert(String::from_utf8_lossy(name).into_owned());
        }
    }
    let prefix = if format == Format::MachO { "_fmi2" } else { "fmi2" };
    let missing: Vec<_> = FUNCTIONS
        .iter()
        .map(|function| format!("{prefix}{function}"))
        .filter(|function| !exported.contains(function))
        .collect();
    if !missing.is_empty() {
        return Err(format!("not exported: {}", missing.join(", ")));
    }

    let mut libraries = BTreeSet::new();
    let mut glibc = (0, 0);
    for import in library.imports().map_err(read)? {
        let import = import.map_err(read)?;
        if !import.library().is_empty() {
            libraries.insert(String::from_utf8_lossy(import.library()).into_owned());
        }
        if let ImportFlags::Elf { version: Some(version), .. } = import.flags()
            && let Some(version) = glibc_version(&String::from_utf8_lossy(version))?
        {
            glibc = glibc.max(version);
        }
    }
    if let Some(stranger) = libraries.iter().find(|library| !comes_with(platform, library)) {
        return Err(format!("needs {stranger}, which is no part of the system"));
    }
    if format == Format::Elf && glibc > GLIBC {
        return Err(format!(
            "needs glibc {}.{}, newer than {}.{}",
            glibc.0, glibc.1, GLIBC.0, GLIBC.1
        ));
    }
    if format == Format::Elf && glibc == (0, 0) {
        return Err("names no version of glibc".into());
    }

    let mut needs = Vec::new();
    if format == Format::Elf {
        needs.push(format!("glibc {}.{}", glibc.0, glibc.1));
    }
    if let File::MachO64(library) = &library {
        let (own, oldest) = mach(library).map_err(read)?;
        if own != format!("@rpath/{name}.dylib") {
            return Err(format!("its install name is {own:?}"));
        }
        needs.push(format!("macOS {oldest}"));
    }
    needs.extend(libraries);
    if let Some(trace) = trace(bytes) {
        return Err(format!("names {trace:?}, of the machine that built it"));
    }
    Ok(format!("{} kB, needs {}", bytes.len() / 1000, needs.join(", ")))
}

/// `GLIBC_2.17` as a pair of numbers; nothing for the versions of other libraries.
fn glibc_version(text: &str) -> Result<Option<(u32, u32)>, String> {
    let Some(numbers) = text.strip_prefix("GLIBC_") else { return Ok(None) };
    let mut numbers = numbers.split('.').map(str::parse);
    match (numbers.next(), numbers.next()) {
        (Some(Ok(major)), Some(Ok(minor))) => Ok(Some((major, minor))),
        _ => Err(format!("needs {text}")),
    }
}

/// Whether a library is there wherever the system is.
fn comes_with(platform: Platform, library: &str) -> bool {
    match platform.format() {
        Format::Elf => LINUX.contains(&library),
        Format::Pe => {
            let library = library.to_ascii_lowercase();
            WINDOWS.contains(&library.as_str()) || library.starts_with("api-ms-win-core-")
        }
        Format::MachO => MACOS.iter().any(|folder| library.starts_with(folder)),
    }
}

/// The install name and the oldest macOS of a library.
fn mach(
    library: &object::read::macho::MachOFile64<'_, object::Endianness>,
) -> object::Result<(String, String)> {
    let endian = library.endian();
    let (mut own, mut oldest) = (String::new(), String::new());
    let mut commands = library.macho_load_commands()?;
    while let Some(command) = commands.next()? {
        match command.variant()? {
            LoadCommandVariant::IdDylib(id) => {
                let name = command.string(endian, id.dylib.name)?;
                own = String::from_utf8_lossy(name).into_owned();
            }
            LoadCommandVariant::BuildVersion(version, _) => {
                let version = version.minos.get(endian);
                oldest = version.to_string();
            }
            _ => {}
        }
    }
    Ok((own, oldest))
}

/// The first name of a folder of this machine, or of its user, in a library.
fn trace(bytes: &[u8]) -> Option<String> {
    let mut names: Vec<String> =
        machine_paths().into_iter().map(|(path, _)| path.display().to_string()).collect();
    if let Some(home) = env::home_dir() {
        names.push(format!("{}/", home.display()));
    }
    for user in ["USER", "LOGNAME"].into_iter().filter_map(|name| env::var(name).ok()) {
        names.extend([format!("/{user}/"), format!("\\{user}\\")]);
    }
    names.into_iter().find(|name| {
        name.len() > 2 && bytes.windows(name.len()).any(|window| window == name.as_bytes())
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_version_of_glibc_is_compared_by_its_numbers() {
        assert_eq!(glibc_version("GLIBC_2.2.5").unwrap(), Some((2, 2)));
        assert!(glibc_version("GLIBC_2.9").unwrap() < Some(GLIBC));
        assert!(glibc_version("GLIBC_2.34").unwrap() > Some(GLIBC));
        assert_eq!(glibc_version("GCC_3.0").unwrap(), None);
        assert!(glibc_version("GLIBC_PRIVATE").is_err());
    }

    #[test]
    fn libraries_that_a_compiler_brings_are_no_part_of_windows() {
        assert!(comes_with(Platform::Win64, "KERNEL32.dll"));
        assert!(!comes_with(Platform::Win64, "libwinpthread-1.dll"));
        assert!(!comes_with(Platform::Darwin64, "@rpath/libc++.dylib"));
        assert!(!comes_with(Platform::Linux64, "libstdc++.so.6"));
    }

    #[test]
    fn the_folder_of_the_workspace_is_found_in_a_library() {
        let library = format!("\0{}/fmu/models/src/lib.rs\0", crate::run::root().display());
        assert!(trace(library.as_bytes()).is_some());
        assert!(trace(b"\0steerwright/fmu/models/src/lib.rs\0").is_none());
    }

    #[test]
    fn files_other_than_libraries_are_refused() {
        assert!(check(Platform::Linux64, "LateralPid", b"no library").is_err());
        // This test's own program is for some platform, and has none of the functions.
        let own = fs::read(env::current_exe().unwrap()).unwrap();
        assert!(check(Platform::Linux64, "LateralPid", &own).is_err());
        assert!(check(Platform::Win64, "LateralPid", &own).is_err());
    }
}
