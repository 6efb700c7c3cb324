//! The platforms: FMI's names of them, Rust's, and what builds and runs a library for each.

use clap::ValueEnum;

/// A platform that FMU libraries are built for. The names are those of the folders in an archive:
/// FMI 2.0's own for x86, and FMI 3.0's platform tuples, to which FMI 2.0.5 refers, for the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(crate) enum Platform {
    /// x86-64 Linux, glibc 2.17 or newer
    #[value(name = "linux64")]
    Linux64,
    /// x86-64 Windows
    #[value(name = "win64")]
    Win64,
    /// 64-bit ARM Linux, glibc 2.17 or newer
    #[value(name = "aarch64-linux")]
    Aarch64Linux,
    /// x86-64 macOS: built and inspected, never run
    #[value(name = "darwin64")]
    Darwin64,
    /// 64-bit ARM macOS: built and inspected, never run
    #[value(name = "aarch64-darwin")]
    Aarch64Darwin,
}

/// The format of a platform's libraries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Elf,
    Pe,
    MachO,
}

/// What can run a platform's libraries on x86-64 Linux.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Runner {
    Itself,
    Wine,
    Qemu,
    Nothing,
}

/// The newest glibc that a Linux library may need.
pub(crate) const GLIBC: (u32, u32) = (2, 17);
/// The oldest macOS that a library is built for.
pub(crate) const MACOS: &str = "11.0";

impl Platform {
    /// The folder in an archive.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Linux64 => "linux64",
            Self::Win64 => "win64",
            Self::Aarch64Linux => "aarch64-linux",
            Self::Darwin64 => "darwin64",
            Self::Aarch64Darwin => "aarch64-darwin",
        }
    }

    /// Rust's target for which a ready standard library is offered.
    pub(crate) fn target(self) -> &'static str {
        match self {
            Self::Linux64 => "x86_64-unknown-linux-gnu",
            Self::Win64 => "x86_64-pc-windows-gnu",
            Self::Aarch64Linux => "aarch64-unknown-linux-gnu",
            Self::Darwin64 => "x86_64-apple-darwin",
            Self::Aarch64Darwin => "aarch64-apple-darwin",
        }
    }

    /// The target where the standard library is built from source: on Windows the one that asks
    /// nothing of the system that wine 8 lacks.
    pub(crate) fn target_from_source(self) -> &'static str {
        match self {
            Self::Win64 => "x86_64-win7-windows-gnu",
            _ => self.target(),
        }
    }

    pub(crate) fn format(self) -> Format {
        match self {
            Self::Linux64 | Self::Aarch64Linux => Format::Elf,
            Self::Win64 => Format::Pe,
            Self::Darwin64 | Self::Aarch64Darwin => Format::MachO,
        }
    }

    pub(crate) fn runner(self) -> Runner {
        match self {
            Self::Linux64 => Runner::Itself,
            Self::Win64 => Runner::Wine,
            Self::Aarch64Linux => Runner::Qemu,
            Self::Darwin64 | Self::Aarch64Darwin => Runner::Nothing,
        }
    }

    /// Whether zig links the library; the others are mingw's.
    pub(crate) fn linked_by_zig(self) -> bool {
        self != Self::Win64
    }

    pub(crate) fn extension(self) -> &'static str {
        match self.format() {
            Format::Elf => "so",
            Format::Pe => "dll",
            Format::MachO => "dylib",
        }
    }

    /// The file that cargo makes of a package's library.
    pub(crate) fn product(self, package: &str) -> String {
        let stem = package.replace('-', "_");
        let prefix = if self.format() == Format::Pe { "" } else { "lib" };
        format!("{prefix}{stem}.{}", self.extension())
    }
}
