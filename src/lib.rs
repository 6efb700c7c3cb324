//! `steerwright`: from a recorded drive to steering FMUs that can be trusted.
//!
//! [`run`] is the command line; each subcommand is a file or folder of `commands`. Results go to stdout, everything else
//! to stderr, both as JSON with `--json`; see `terminal`.
//!
//! [`stages`] has the stages that compute in memory, with the options of the command line, for the Python package.

mod commands;
mod documents;
mod failure;
mod options;
mod output;
mod pipeline;
mod presentation;
mod process;
pub mod stages;
mod terminal;

use clap::{Parser, Subcommand};
use commands::{
    accumulate, bicycle, build, check, compare, demo, design, excite, export, identify, inspect,
    manual, package, path, simulate, sweep,
};
use failure::{Failure, Outcome};
use options::Global;
use process::guard::{self, Interruption};
use process::program;
use std::ffi::OsString;
use std::time::SystemTime;
use terminal::{console, progress};

/// From a recorded drive to steering FMUs that can be trusted.
///
/// Identifies a vehicle's lateral dynamics from a drive log, designs a PID steering controller on
/// the identified model, and packs plant, controller and reference path as FMI 2.0 Co-Simulation
/// units.
///
/// Exit status: 0 done, 1 the work was done but a requirement or a validation is not met, 2 bad input.
#[derive(Parser)]
#[command(version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: Global,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Arguments),
    // Boxed: they have the options of several stages.
    Build(Box<build::Arguments>),
    Inspect(inspect::Arguments),
    Identify(Box<identify::Arguments>),
    Accumulate(accumulate::Arguments),
    Bicycle(bicycle::Arguments),
    Design(design::Arguments),
    Path(path::Arguments),
    Excite(excite::Arguments),
    Package(package::Arguments),
    Simulate(simulate::Arguments),
    // Boxed: it has the options of several stages.
    Compare(Box<compare::Arguments>),
    Sweep(sweep::Arguments),
    Export(export::Arguments),
    Check(check::Arguments),
    Completions(manual::CompletionArguments),
    Man(manual::ManArguments),
}

impl Command {
    /// Whether it calls FMUs, which may be anyone's, in its own process.
    fn calls_fmus(&self) -> bool {
        match self {
            Self::Simulate(_) | Self::Compare(_) => true,
            Self::Sweep(arguments) => arguments.calls_fmus(),
            _ => false,
        }
    }
}

fn execute(command: Command, global: &Global) -> Result<Outcome, Failure> {
    match command {
        Command::Demo(arguments) => demo::run(&arguments, global),
        Command::Build(arguments) => build::run(&arguments, global),
        Command::Inspect(arguments) => inspect::run(&arguments, global),
        Command::Identify(arguments) => identify::run(&arguments, global),
        Command::Accumulate(arguments) => accumulate::run(&arguments, global),
        Command::Bicycle(arguments) => bicycle::run(&arguments, global),
        Command::Design(arguments) => design::run(&arguments, global),
        Command::Path(arguments) => path::run(&arguments, global),
        Command::Excite(arguments) => excite::run(&arguments, global),
        Command::Package(arguments) => package::run(&arguments, global),
        Command::Simulate(arguments) => simulate::run(&arguments, global),
        Command::Compare(arguments) => compare::run(&arguments, global),
        Command::Sweep(arguments) => sweep::run(&arguments, global),
        Command::Export(arguments) => export::run(&arguments, global),
        Command::Check(arguments) => check::run(&arguments),
        Command::Completions(arguments) => manual::completions(&arguments),
        Command::Man(arguments) => manual::man(&arguments, global),
    }
}

/// Runs the command line on the arguments, of which the first is the name of the program; returns the exit
/// status. `program` starts the same command line in another process; by default it is this executable.
pub fn run(arguments: Vec<OsString>, program: Option<Vec<OsString>>) -> u8 {
    program::set(program);
    // Before the arguments are parsed, since their errors are printed in the same form.
    console::use_json(arguments.iter().any(|argument| argument == "--json"));
    match Arguments::try_parse_from(&arguments) {
        Ok(Arguments { command, global }) => {
            progress::set_interval(global.progress_interval);
            console::use_details(global.verbose);
            if command.calls_fmus() && program::is_guarded() {
                return guard::guarded(|| failure::status(|| execute(command, &global)));
            }
            if global.end_with_parent
                && let Err(error) = steerwright_host::process::end_with_parent()
            {
                let hint = "leave --end-with-parent out";
                return Failure::new(format!("standard input: {error}"), hint).report();
            }
            match command {
                Command::Simulate(simulation) => {
                    guard::run(&arguments, Interruption::Ends, |rows| {
                        simulation.keep(rows, &global)
                    })
                }
                Command::Sweep(sweep) if sweep.calls_fmus() => {
                    let began = SystemTime::now();
                    guard::run(&arguments, Interruption::IsPassedOn, |_| Ok(sweep.kept(began)))
                }
                command if command.calls_fmus() => {
                    guard::run(&arguments, Interruption::IsPassedOn, |_| Ok(None))
                }
                command => failure::status(|| execute(command, &global)),
            }
        }
        Err(error) => failure::report_usage(&error),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn no_two_options_of_a_command_are_called_the_same() {
        // In release, where the tests run, clap's own check is empty.
        fn check(command: &clap::Command) {
            let arguments: Vec<_> = command.get_arguments().collect();
            for (k, one) in arguments.iter().enumerate() {
                let same = |other: &&clap::Arg| {
                    one.get_id() == other.get_id()
                        || one.get_long().is_some_and(|name| other.get_long() == Some(name))
                        || one.get_short().is_some_and(|name| other.get_short() == Some(name))
                };
                assert!(!arguments[..k].iter().any(same), "{command} {one}");
            }
            command.get_subcommands().for_each(check);
        }
        let mut command = super::Arguments::command();
        command.build();
        check(&command);
        command.debug_assert();
    }
}
