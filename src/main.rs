//! `steerwright`: from a recorded drive to steering FMUs that can be trusted.
//!
//! Each subcommand is a file: it reads, calls a stage, writes and tells. Results a script may want
//! go to stdout as JSON with `--json`; everything else goes to stderr.

mod absorb;
mod bicycle;
mod build;
mod check;
mod compare;
mod comparison;
mod demo;
mod design;
mod design_plots;
mod design_summary;
mod evidence;
mod failure;
mod files;
mod fmu_step;
mod fmu_track;
mod gate;
mod identify;
mod identify_bicycle;
mod identify_factor;
mod lateral_loop;
mod log_options;
mod overview;
mod package;
mod path;
mod pipeline;
mod quantity;
mod requirements;
mod simulate;
mod sweep;
mod tell;

use clap::{Parser, Subcommand};
use failure::{Failure, Outcome};
use std::process::ExitCode;

/// From a recorded drive to steering FMUs that can be trusted.
///
/// Identifies a vehicle's lateral dynamics from a drive log, designs a PID steering controller on
/// the identified model, and packs plant, controller and reference path as FMI 2.0 Co-Simulation
/// units.
///
/// Exit status: 0 done, 1 the work was done but a requirement or a validation is not met, 2 bad input.
#[derive(Parser)]
#[command(version, max_term_width = 100, disable_help_subcommand = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Arguments),
    // Boxed: it has the options of all stages.
    Build(Box<build::Arguments>),
    Identify(identify::Arguments),
    Absorb(absorb::Arguments),
    Bicycle(bicycle::Arguments),
    Design(design::Arguments),
    Path(path::Arguments),
    Package(package::Arguments),
    Simulate(simulate::Arguments),
    // Boxed: it has the options of several stages.
    Compare(Box<compare::Arguments>),
    Sweep(sweep::Arguments),
    Check(check::Arguments),
}

fn run(command: Command) -> Result<Outcome, Failure> {
    match command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Build(arguments) => build::run(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Absorb(arguments) => absorb::run(&arguments),
        Command::Bicycle(arguments) => bicycle::run(&arguments),
        Command::Design(arguments) => design::run(&arguments),
        Command::Path(arguments) => path::run(&arguments),
        Command::Package(arguments) => package::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
    }
}

fn main() -> ExitCode {
    match Arguments::try_parse() {
        Ok(arguments) => match run(arguments.command) {
            Ok(outcome) => outcome.into(),
            Err(failure) => failure.tell(),
        },
        Err(error) => failure::tell_usage(&error),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn no_two_options_of_a_command_are_called_the_same() {
        super::Arguments::command().debug_assert();
    }
}
