//! `cargo xtask bench`: measurements, none of which runs in the tests.

mod fmu;
mod sweep;

use clap::ValueEnum;

/// What can be measured.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Bench {
    /// What a call of an FMU costs, beside the same arithmetic in C and in pythonfmu
    Fmu,
    /// What identification costs in time and memory, beside its peers
    Sysid,
    /// What a closed loop of FMUs costs in a sweep, on a thread and on two, beside fmpy
    Sweep,
}

/// Measures it.
pub(crate) fn bench(what: Bench) -> Result<(), String> {
    match what {
        Bench::Fmu => fmu::fmu(),
        Bench::Sweep => sweep::sweep(),
        Bench::Sysid => crate::evaluate::evaluate("speed", &[]),
    }
}
