//! The tasks of developers: `cargo xtask test`, `lint`, `docs`, `readme`, `licenses`, `cross`, `fuzz`, `stress`,
//! `bench fmu`, `evaluate`, `experiment`, `snapshot`.

mod bench;
mod browser;
mod cross;
mod docs;
mod evaluate;
mod every_fmu;
mod experiment;
mod files;
mod fmus;
mod formats;
mod fuzz;
mod importers;
mod licenses;
mod lint;
mod python;
mod python_types;
mod readme;
mod run;
mod snapshot;
mod stacks;
mod stress;
mod test;
mod wheel;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// The tasks of developers.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Every test, also those that need Python or libclang: makes its own environment in
    /// target/python
    Test(test::Options),
    /// The tests of the report in headless Chromium alone
    Browser,
    /// The FMUs in importers that are not this project's alone
    Importers,
    /// rustfmt and clippy, warnings denied
    Lint,
    /// Build the FMU libraries for other platforms, and the demo's archives with them
    Cross(cross::Options),
    /// Make the Python environment and print its interpreter
    Python,
    /// Build the wheel of the Python package, install it into a fresh environment and test it
    Wheel {
        /// Write the file that is generated from the options of the command line
        #[arg(long)]
        update: bool,
    },
    /// Run the fuzzer over the targets of tests/fuzzing
    Fuzz {
        /// How long each target is run
        #[arg(long, default_value_t = 10.0)]
        minutes: f64,
        /// Targets; all of them if none is named
        targets: Vec<String>,
    },
    /// Gather the licences of all that the FMU libraries link
    Licenses,
    /// Write the demo's tables and the figures into README.md and docs/
    Readme,
    /// Build the book with mdBook and check the links of all documents
    Docs {
        /// Write the files that are generated from the crate formats
        #[arg(long)]
        update: bool,
    },
    /// The tests that take minutes: millions of instances, thousands under valgrind, everything
    /// built twice
    Stress,
    /// How well the identification does, compared with its peers
    Evaluate(evaluate::Options),
    /// Controllers designed from a drive, on multi-body cars from outside, compared with their rivals
    Experiment(experiment::Options),
    /// The results of every command, compared with tests/snapshot.csv
    Snapshot(snapshot::Options),
    /// Measure something
    Bench(bench::Options),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Test(options) => test::test(&options),
        Command::Cross(options) => cross::cross(&options),
        Command::Browser => browser::browser(),
        Command::Importers => importers::importers(),
        Command::Lint => lint::lint(),
        Command::Fuzz { minutes, targets } => fuzz::fuzz(minutes, &targets),
        Command::Licenses => licenses::licenses(),
        Command::Readme => readme::readme(),
        Command::Docs { update } => docs::docs(update),
        Command::Stress => stress::stress(),
        Command::Evaluate(options) => evaluate::evaluate(&options),
        Command::Experiment(options) => experiment::experiment(&options),
        Command::Snapshot(options) => snapshot::snapshot(&options),
        Command::Bench(options) => bench::bench(&options),
        Command::Wheel { update } => wheel::wheel(update),
        Command::Python => python::environment().map(|python| println!("{}", python.display())),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
