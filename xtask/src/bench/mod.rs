//! `cargo xtask bench`: measurements. Their short forms run in CI, to see that they work.

mod cluster;
mod fmu;
mod sweep;

use clap::ValueEnum;

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Run with few calls, to see that it works; everything if nothing is named
    #[arg(long)]
    short: bool,
    /// What to measure
    #[arg(required_unless_present = "short")]
    what: Option<Bench>,
}

/// What can be measured.
#[derive(Clone, Copy, ValueEnum)]
enum Bench {
    /// What a call of an FMU costs, compared with the same arithmetic in C and in pythonfmu
    Fmu,
    /// What identification costs in time and memory, compared with its peers
    Sysid,
    /// What a closed loop of FMUs costs in a sweep, on a thread and on two, compared with fmpy
    Sweep,
    /// A sweep and a fleet on two local workers of Dask, compared with one process
    Cluster,
}

/// Measures it.
pub(crate) fn bench(options: &Options) -> Result<(), String> {
    let short = options.short;
    let all: &[Bench] = match &options.what {
        Some(what) => std::slice::from_ref(what),
        // The short form of `sysid` is one of those of `cargo xtask evaluate --short`.
        None => &[Bench::Fmu, Bench::Sweep, Bench::Cluster],
    };
    for what in all {
        match what {
            Bench::Fmu => fmu::fmu(short)?,
            Bench::Sweep => sweep::sweep(short)?,
            Bench::Cluster => cluster::cluster(short)?,
            Bench::Sysid => crate::evaluate::evaluate_named("speed", short)?,
        }
    }
    Ok(())
}
