//! The platforms a library may be for.
//!
//! FMI 2.0.5, section 2.3, names `win32`, `win64`, `linux32`, `linux64`, `darwin32` and `darwin64`,
//! all x86; every other platform is named by the tuple of FMI 3.0, section 2.5.1.4.1:
//! `<architecture>-<system>`, such as `aarch64-linux`.

use crate::Error;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Platform {
    system: [&'static str; 4],
    architecture: &'static str,
}

/// Systems: the beginning of FMI 2.0's names, the name in tuples, how a library's file name ends, the title.
const SYSTEMS: [[&str; 4]; 3] = [
    ["linux", "linux", "so", "Linux"],
    ["win", "windows", "dll", "Windows"],
    ["darwin", "darwin", "dylib", "macOS"],
];

impl Platform {
    pub(crate) fn from_folder(folder: &str) -> Result<Self, Error> {
        let unknown = || Error::Platform { platform: folder.to_owned() };
        for system in SYSTEMS {
            match folder.strip_prefix(system[0]) {
                Some("32") => return Ok(Self { system, architecture: "32-bit x86" }),
                Some("64") => return Ok(Self { system, architecture: "64-bit x86" }),
                _ => {}
            }
        }
        let (architecture, name) = folder.split_once('-').ok_or_else(unknown)?;
        let system = SYSTEMS.into_iter().find(|system| system[1] == name).ok_or_else(unknown)?;
        let architecture = match architecture {
            "aarch32" => "32-bit ARM",
            "aarch64" => "64-bit ARM",
            _ => return Err(unknown()),
        };
        Ok(Self { system, architecture })
    }

    pub(crate) fn extension(self) -> &'static str {
        self.system[2]
    }

    pub(crate) fn title(self) -> String {
        format!("{}, {}", self.system[3], self.architecture)
    }

    /// How its libraries are tested, by `cargo test` and `cargo xtask cross --run`.
    pub(crate) fn standing(self) -> &'static str {
        match (self.system[1], self.architecture) {
            ("linux", "64-bit x86") => "run by the project's tests",
            ("windows", "64-bit x86") => "run by the project's tests under Wine",
            ("linux", "64-bit ARM") => "run by the project's tests under QEMU",
            ("darwin", _) => "built and inspected, never run",
            _ => "never built or run by the project",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Platform;

    #[test]
    fn fmi_names_and_tuples_have_their_extension() {
        for (folder, extension) in [
            ("linux64", "so"),
            ("linux32", "so"),
            ("win32", "dll"),
            ("win64", "dll"),
            ("darwin64", "dylib"),
            ("aarch64-linux", "so"),
            ("aarch64-darwin", "dylib"),
            ("aarch64-windows", "dll"),
        ] {
            assert_eq!(Platform::from_folder(folder).unwrap().extension(), extension, "{folder}");
        }
    }

    #[test]
    fn other_names_are_refused() {
        // No importer of FMI 2.0 looks for x86_64-linux: that is linux64 there.
        for folder in ["", "linux", "x86_64-linux", "../linux64", "Linux64", "amd64-linux", "win65"]
        {
            assert!(Platform::from_folder(folder).is_err(), "{folder}");
        }
    }
}
