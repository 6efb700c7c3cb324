//! The bytes of the FMU libraries, built by this crate's build script.
//!
//! With them inside, an installed `steerwright` packs FMUs on a machine without a compiler.
//! `STEERWRIGHT_FMU_BINARIES=DIR` at build time skips the build and takes
//! `DIR/<platform>/<FMU name>.<so|dll|dylib>`, for releases with more than one platform.
//!
//! This crate links none of the libraries and does not depend on their function.

/// A built library.
#[derive(Debug, Clone, Copy)]
pub struct Library {
    /// The FMU's name, such as `LateralPid`.
    pub name: &'static str,
    /// FMI's name of the platform, such as `linux64`.
    pub platform: &'static str,
    /// The library's bytes.
    pub bytes: &'static [u8],
}

include!(concat!(env!("OUT_DIR"), "/libraries.rs"));

/// The library of an FMU for a platform, where there is one.
#[must_use]
pub fn get(name: &str, platform: &str) -> Option<&'static [u8]> {
    LIBRARIES.iter().find(|l| l.name == name && l.platform == platform).map(|l| l.bytes)
}

/// Every library of an FMU, one for each platform.
pub fn libraries_of(name: &str) -> impl Iterator<Item = &'static Library> {
    LIBRARIES.iter().filter(move |l| l.name == name)
}
