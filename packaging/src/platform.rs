//! The platforms a library may be for.
//!
//! FMI 2.0.5, section 2.3, names `win32`, `win64`, `linux32`, `linux64`, `darwin32` and `darwin64`,
//! all x86; every other platform is named by the tuple of FMI 3.0, section 2.5.1.4.1:
//! `<architecture>-<system>`, such as `aarch64-linux`.

use crate::Error;

/// A platform by its folder below `binaries/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Platform {
    system: System,
    architecture: &'static str,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum System {
    Linux,
    Windows,
    Darwin,
}

impl Platform {
    /// The platform of that folder.
    ///
    /// # Errors
    /// [`Error::Platform`] where FMI has no such name. The tuples of platforms that FMI 2.0 has a
    /// name for are refused too, since its importers would not look there.
    pub(crate) fn of(folder: &str) -> Result<Self, Error> {
        let unknown = || Error::Platform { platform: folder.to_owned() };
        let named =
            [("linux", System::Linux), ("win", System::Windows), ("darwin", System::Darwin)];
        for (word, system) in named {
            match folder.strip_prefix(word) {
                Some("32") => return Ok(Self { system, architecture: "32-bit x86" }),
                Some("64") => return Ok(Self { system, architecture: "64-bit x86" }),
                _ => {}
            }
        }
        let (architecture, system) = folder.split_once('-').ok_or_else(unknown)?;
        let system = match system {
            "linux" => System::Linux,
            "windows" => System::Windows,
            "darwin" => System::Darwin,
            _ => return Err(unknown()),
        };
        let architecture = match architecture {
            "aarch32" => "32-bit ARM",
            "aarch64" => "64-bit ARM",
            _ => return Err(unknown()),
        };
        Ok(Self { system, architecture })
    }

    /// How a library's file name ends.
    pub(crate) fn extension(self) -> &'static str {
        match self.system {
            System::Linux => "so",
            System::Windows => "dll",
            System::Darwin => "dylib",
        }
    }

    pub(crate) fn title(self) -> String {
        let system = match self.system {
            System::Linux => "Linux",
            System::Windows => "Windows",
            System::Darwin => "macOS",
        };
        format!("{system}, {}", self.architecture)
    }

    /// How its libraries are tested, by `cargo test` and `cargo xtask test --cross`.
    pub(crate) fn standing(self) -> &'static str {
        match (self.system, self.architecture) {
            (System::Linux, "64-bit x86") => "run by the project's tests",
            (System::Windows, "64-bit x86") => "run by the project's tests under Wine",
            (System::Linux, "64-bit ARM") => "run by the project's tests under QEMU",
            (System::Darwin, _) => "built and inspected, never run",
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
            assert_eq!(Platform::of(folder).unwrap().extension(), extension, "{folder}");
        }
    }

    #[test]
    fn other_names_are_refused() {
        // No importer of FMI 2.0 looks for x86_64-linux: that is linux64 there.
        for folder in ["", "linux", "x86_64-linux", "../linux64", "Linux64", "amd64-linux", "win65"]
        {
            assert!(Platform::of(folder).is_err(), "{folder}");
        }
    }
}
