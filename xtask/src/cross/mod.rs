//! `cargo xtask cross`: the FMU libraries for other platforms than this one, checked, and the
//! demo's archives with all of them inside.
//!
//! Everything is in `target/cross`: `binaries/<platform>/<FMU name>.<so|dll|dylib>`, which is what
//! `STEERWRIGHT_FMU_BINARIES` takes; `archives`, the demo's; `tools` and `build`, which may be
//! deleted.

mod apt;
mod archives;
mod build;
mod debian;
mod differences;
mod inspect;
mod platform;
mod setup;
mod toolchain;
mod trajectories;
mod universal;

use crate::files::remove;
use crate::run::{root, target};
pub(crate) use apt::{apt, find, is_root};
use clap::Args;
use platform::{Platform, Runner};
pub(crate) use setup::linker;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::thread::{self, ScopedJoinHandle};
use std::time::Instant;
pub(crate) use toolchain::Source;

/// Folder and FMU name of each library.
static LIBRARIES: LazyLock<Vec<(String, String)>> =
    LazyLock::new(|| crate::fmus::fmus(root()).unwrap_or_default());

/// What is built where no platform is named.
const USUAL: [Platform; 2] = [Platform::Linux64, Platform::Win64];

/// What to build, and how.
#[derive(Args)]
pub(crate) struct Options {
    /// The platforms; without any, linux64 and win64
    platforms: Vec<Platform>,
    /// Install what the platforms need, and build nothing; with --run beside the first build
    #[arg(long)]
    setup: bool,
    /// Also run the libraries and compare them with those of linux64, as far as they run here
    #[arg(long)]
    run: bool,
    /// Where the standard library of another platform comes from
    #[arg(long, value_enum, default_value = "auto")]
    std: Source,
}

/// `cargo xtask cross`.
pub(crate) fn cross(options: &Options) -> Result<(), String> {
    let platforms = with_own(&options.platforms);
    let install = || timed("set up", || setup::install(&platforms, options.std));
    if options.setup && !options.run {
        return install();
    }
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return Err("`cargo xtask cross` runs on x86-64 Linux\nhint: elsewhere, \
                    `cargo build --profile fmu --target TARGET --package FMU` builds one library"
            .into());
    }
    if !options.setup {
        setup::check(&platforms, options.run)?;
    }
    let zig = timed("zig", setup::zig)?;
    thread::scope(|scope| {
        // The libraries for linux64, the first, need nothing else.
        let mut installed = if options.setup { Some(scope.spawn(install)) } else { None };
        // An older library next to those that are built could be of other sources.
        remove(&binaries())?;
        for &platform in &platforms {
            if platform != Platform::Linux64 {
                ended(installed.take())?;
            }
            libraries(platform, options.std, &zig)?;
        }
        ended(installed)?;
        universal::join(&platforms)
    })?;
    let packed = timed("archives", || archives::archives(&platforms))?;
    if options.run {
        let others: Vec<_> = platforms.into_iter().filter(|p| *p != Platform::Linux64).collect();
        run(&others, &packed)?;
    }
    Ok(())
}

/// Waits for a thread that installs, if there is one.
fn ended(installed: Option<ScopedJoinHandle<'_, Result<(), String>>>) -> Result<(), String> {
    installed.map_or(Ok(()), |thread| {
        thread.join().unwrap_or_else(|_| Err("the set-up panicked".into()))
    })
}

/// Builds and checks the libraries for a platform.
fn libraries(platform: Platform, source: Source, zig: &Path) -> Result<(), String> {
    let name = platform.name();
    let toolchain = timed(&format!("{name}: Rust"), || toolchain::toolchain(platform, source))?;
    timed(&format!("{name}: build"), || build::build(platform, &toolchain, zig))?;
    for (_, library) in LIBRARIES.iter() {
        let file = library_file(platform, library);
        let needed = inspect::inspect(platform, library, &file)?;
        eprintln!("{name}/{library}: {needed}");
    }
    let run = match platform.runner() {
        Runner::Nothing => "built and inspected, never run",
        _ => "`cargo xtask cross --run` runs it",
    };
    eprintln!("{name}: {}; {run}", toolchain.name());
    Ok(())
}

/// Runs the libraries of the platforms and compares them with those for linux64 in `native`, a folder
/// of a demo's archives.
fn run(platforms: &[Platform], native: &Path) -> Result<(), String> {
    for &platform in platforms {
        if platform.runner() == Runner::Nothing {
            eprintln!("{}: built and inspected, never run", platform.name());
        } else {
            let name = format!("{}: run", platform.name());
            timed(&name, || trajectories::compare(platform, native))?;
        }
    }
    Ok(())
}

/// The platforms, each once, and this machine's own among them: the program that packs the archives
/// runs its library.
fn with_own(platforms: &[Platform]) -> Vec<Platform> {
    let mut all = if platforms.is_empty() { USUAL.to_vec() } else { platforms.to_vec() };
    all.push(Platform::Linux64);
    all.sort();
    all.dedup();
    all
}

/// Where all of this is.
fn folder() -> PathBuf {
    target().join("cross")
}

/// The libraries: what `STEERWRIGHT_FMU_BINARIES` takes.
fn binaries() -> PathBuf {
    folder().join("binaries")
}

fn library_file(platform: Platform, library: &str) -> PathBuf {
    binaries().join(platform.name()).join(format!("{library}.{}", platform.extension()))
}

/// Does something and prints its duration.
fn timed<T>(what: &str, work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let start = Instant::now();
    let done = work().map_err(|e| format!("{what}: {e}"))?;
    eprintln!("{what}: {:.1} s", start.elapsed().as_secs_f64());
    Ok(done)
}
