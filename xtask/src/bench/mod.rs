//! `cargo xtask bench`: measurements, none of which runs in the tests.

mod fmu;

use clap::ValueEnum;

/// What can be measured.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Bench {
    /// What a call of an FMU costs, beside the same arithmetic in C and in pythonfmu
    Fmu,
    /// What identification costs in time and memory, beside its peers
    Sysid,
}

/// Measures it.
pub(crate) fn bench(what: Bench) -> Result<(), String> {
    match what {
        Bench::Fmu => fmu::fmu(),
        Bench::Sysid => crate::evaluate::evaluate("speed", &[]),
    }
}
