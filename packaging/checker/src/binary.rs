//! Static checks of the binaries.

use crate::archive::Contents;
use crate::finding::{Findings, Location};
use model_description::ModelDescription;
use object::read::NameOrOrdinal;
use object::read::macho::{FatArch, MachOFatFile32};
use object::{Architecture, BinaryFormat, Object, ObjectKind};
use std::collections::BTreeSet;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Platform {
    folder: &'static str,
    format: BinaryFormat,
    architecture: Architecture,
    pub(crate) extension: &'static str,
}

const fn known_platform(
    folder: &'static str,
    format: BinaryFormat,
    architecture: Architecture,
    extension: &'static str,
) -> Platform {
    Platform { folder, format, architecture, extension }
}

use Architecture::{Aarch64, I386, X86_64};
use BinaryFormat::{Elf, MachO, Pe};

/// The folders of FMI 2.0, and those of FMI 3.0 that FMI 2.0 archives use too.
const PLATFORMS: &[Platform] = &[
    known_platform("win32", Pe, I386, "dll"),
    known_platform("win64", Pe, X86_64, "dll"),
    known_platform("linux32", Elf, I386, "so"),
    known_platform("linux64", Elf, X86_64, "so"),
    known_platform("darwin32", MachO, I386, "dylib"),
    known_platform("darwin64", MachO, X86_64, "dylib"),
    known_platform("x86-windows", Pe, I386, "dll"),
    known_platform("x86_64-windows", Pe, X86_64, "dll"),
    known_platform("aarch64-windows", Pe, Aarch64, "dll"),
    known_platform("x86-linux", Elf, I386, "so"),
    known_platform("x86_64-linux", Elf, X86_64, "so"),
    known_platform("aarch64-linux", Elf, Aarch64, "so"),
    known_platform("x86_64-darwin", MachO, X86_64, "dylib"),
    known_platform("aarch64-darwin", MachO, Aarch64, "dylib"),
];

/// Further requirements of model exchange (section 3.2.3).
const MODEL_EXCHANGE: &str = "fmi2EnterEventMode fmi2NewDiscreteStates fmi2EnterContinuousTimeMode \
    fmi2CompletedIntegratorStep fmi2SetTime fmi2SetContinuousStates fmi2GetDerivatives \
    fmi2GetEventIndicators fmi2GetContinuousStates fmi2GetNominalsOfContinuousStates";

/// Libraries that every machine of a platform has, by the beginning of their names.
const SYSTEM: &str = "libc.so libm.so libdl.so libpthread.so librt.so libgcc_s.so ld-linux libstdc++.so \
    /usr/lib/ /system/library/ kernel32 ntdll user32 advapi32 ws2_32 bcrypt userenv shell32 ole32 oleaut32 \
    msvcrt api-ms-win- synchronization gdi32 shlwapi winmm version.dll";

pub(crate) fn platform(folder: &str) -> Option<&'static Platform> {
    PLATFORMS.iter().find(|platform| platform.folder == folder)
}

pub(crate) fn check(
    contents: &Contents<'_>,
    description: Option<&ModelDescription>,
    findings: &mut Findings,
) {
    let Some(description) = description else { return };
    let Some(co_simulation) = &description.co_simulation else { return };
    let identifier = &co_simulation.model_identifier;
    let mut functions: Vec<&str> = steerwright_host::FUNCTION_NAMES.to_vec();
    if description.model_exchange.as_ref().is_some_and(|m| m.model_identifier == *identifier) {
        functions.extend(MODEL_EXCHANGE.split(' '));
    }
    let documented = ["txt", "html"]
        .iter()
        .any(|ending| contents.has(&format!("documentation/externalDependencies.{ending}")));
    for platform in PLATFORMS {
        let name = format!("binaries/{}/{identifier}.{}", platform.folder, platform.extension);
        let Some(bytes) = contents.file(&name) else { continue };
        let place = || Location::entry(&name);
        let library = match Library::read(&bytes, platform) {
            Ok(library) => library,
            Err(problem) => {
                findings.add("binary-format", place(), problem);
                continue;
            }
        };
        let missing: Vec<&str> =
            functions.iter().copied().filter(|f| !library.functions.contains(*f)).collect();
        if !missing.is_empty() {
            let prefixed = format!("{identifier}_{}", missing[0]);
            let why = if library.functions.contains(&prefixed) {
                "; they have the prefix that is only for sources and static libraries"
            } else {
                ""
            };
            let (count, all) = (missing.len(), functions.len());
            let message =
                format!("{count} of {all} functions missing: {}{why}", missing.join(", "));
            findings.add("binary-functions", place(), message);
        }
        let foreign: Vec<&str> = library
            .needs
            .iter()
            .map(String::as_str)
            .filter(|library| !is_available(library, platform, contents))
            .collect();
        if !foreign.is_empty() && !documented {
            let message = format!("needs {}, which is not documented", foreign.join(", "));
            findings.add("binary-dependencies", place(), message);
        }
        if !library.needs.is_empty() {
            findings.add("binary-needs", place(), format!("needs {}", library.needs.join(", ")));
        }
        if let Some([major, minor]) = glibc(&bytes).filter(|_| platform.format == Elf) {
            findings.add("binary-glibc", place(), format!("needs glibc {major}.{minor}"));
        }
        if let Some(path) = build_path(&bytes) {
            let message = format!("contains paths of the build machine, such as {path:?}");
            findings.add("binary-build-path", place(), message);
        }
    }
}

fn is_available(library: &str, platform: &Platform, contents: &Contents<'_>) -> bool {
    let lower = library.to_lowercase();
    let file = library.rsplit('/').next().unwrap_or(library);
    SYSTEM.split(' ').any(|known| lower.starts_with(known))
        || contents.has(&format!("binaries/{}/{file}", platform.folder))
}

struct Library {
    functions: BTreeSet<String>,
    needs: Vec<String>,
}

impl Library {
    /// Reads a library; of a universal binary the part for the platform.
    fn read(bytes: &[u8], platform: &Platform) -> Result<Self, String> {
        let bytes = match MachOFatFile32::parse(bytes) {
            Ok(fat) if platform.format == MachO => fat
                .arches()
                .iter()
                .find(|part| part.architecture() == platform.architecture)
                .ok_or_else(|| format!("a universal binary without {:?}", platform.architecture))?
                .data(bytes)
                .map_err(|e| e.to_string())?,
            _ => bytes,
        };
        let file =
            object::File::parse(bytes).map_err(|error| format!("it is not a binary: {error}"))?;
        if file.format() != platform.format {
            return Err(format!("it is {:?}, not {:?}", file.format(), platform.format));
        }
        if file.architecture() != platform.architecture {
            let (got, need) = (file.architecture(), platform.architecture);
            return Err(format!("it is for {got:?}, not {need:?}"));
        }
        if file.kind() != ObjectKind::Dynamic {
            return Err(format!("it is not a shared library but {:?}", file.kind()));
        }
        let problem = |error: object::Error| format!("its tables cannot be read: {error}");
        let mut functions = BTreeSet::new();
        for export in file.exports().map_err(problem)? {
            if let NameOrOrdinal::Name(name) = export.map_err(problem)?.into_name() {
                let name = String::from_utf8_lossy(&name).into_owned();
                // On macOS C names begin with an underscore.
                let plain = match platform.format {
                    MachO => name.strip_prefix('_').unwrap_or(&name).to_owned(),
                    _ => name,
                };
                functions.insert(plain);
            }
        }
        let mut needs = Vec::new();
        for library in file.import_libraries().map_err(problem)? {
            let library = library.map_err(problem)?;
            needs.push(String::from_utf8_lossy(library.name()).into_owned());
        }
        needs.sort();
        needs.dedup();
        Ok(Self { functions, needs })
    }
}

/// The newest `GLIBC_x.y` among the names of symbol versions.
fn glibc(bytes: &[u8]) -> Option<[u32; 2]> {
    const NAME: &[u8] = b"GLIBC_";
    let digits = |text: &[u8]| -> Option<u32> {
        let end = text.iter().position(|b| !b.is_ascii_digit()).unwrap_or(text.len());
        std::str::from_utf8(&text[..end]).ok()?.parse().ok()
    };
    positions(bytes, NAME)
        .filter_map(|at| {
            let rest = &bytes[at + NAME.len()..];
            let dot = rest.iter().take(4).position(|b| *b == b'.')?;
            Some([digits(&rest[..dot])?, digits(&rest[dot + 1..])?])
        })
        .max()
}

/// A path of a home folder in the binary.
fn build_path(bytes: &[u8]) -> Option<String> {
    [&b"/home/"[..], b"/root/", b"/Users/", b":\\Users\\", b"/tmp/"].iter().find_map(|head| {
        let at = positions(bytes, head).next()?;
        let rest = &bytes[at..bytes.len().min(at + 60)];
        let end = rest.iter().position(|b| !b.is_ascii_graphic()).unwrap_or(rest.len());
        if end > head.len() {
            Some(String::from_utf8_lossy(&rest[..end]).into_owned())
        } else {
            None
        }
    })
}

fn positions<'b>(bytes: &'b [u8], text: &'b [u8]) -> impl Iterator<Item = usize> + 'b {
    let first = text.first().copied();
    (0..bytes.len()).filter(move |at| Some(bytes[*at]) == first && bytes[*at..].starts_with(text))
}
