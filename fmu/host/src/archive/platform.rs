//! The names that `binaries/` uses for platforms (FMI 2.0.5, 2.3).
//!
//! FMI 2.0 names 32- and 64-bit Windows, Linux and macOS; for ARM the names of FMI 3.0 are in use
//! in FMI 2.0 archives too, and on Apple silicon `darwin64` is often a universal binary.

/// Where a binary for the running platform may be, the best place first.
#[must_use]
pub fn platform_folders() -> &'static [&'static str] {
    folders(std::env::consts::OS, std::env::consts::ARCH)
}

/// The file name of the binary of a model identifier on the running platform.
#[must_use]
pub fn binary_name(model_identifier: &str) -> String {
    format!("{model_identifier}{}", std::env::consts::DLL_SUFFIX)
}

fn folders(system: &str, architecture: &str) -> &'static [&'static str] {
    match (system, architecture) {
        ("linux", "x86_64") => &["linux64", "x86_64-linux"],
        ("linux", "x86") => &["linux32", "x86-linux"],
        ("linux", "aarch64") => &["aarch64-linux"],
        ("windows", "x86_64") => &["win64", "x86_64-windows"],
        ("windows", "x86") => &["win32", "x86-windows"],
        ("windows", "aarch64") => &["aarch64-windows"],
        ("macos", "x86_64") => &["darwin64", "x86_64-darwin"],
        ("macos", "aarch64") => &["aarch64-darwin", "darwin64"],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_platforms_of_fmi_2_have_the_names_of_the_standard() {
        assert_eq!(folders("linux", "x86_64")[0], "linux64");
        assert_eq!(folders("windows", "x86_64")[0], "win64");
        assert_eq!(folders("macos", "x86_64")[0], "darwin64");
        // A universal binary is found, a native one is preferred.
        assert_eq!(folders("macos", "aarch64"), ["aarch64-darwin", "darwin64"]);
        assert!(folders("plan9", "mips").is_empty());
    }
}
