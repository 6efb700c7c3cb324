//! `cargo xtask evaluate` and `bench sysid`: the programs of `evaluation`, in release mode, with
//! the Python environment of the peers they are compared with.

mod help;
mod programs;
mod record;

use crate::python;
use crate::run::{cargo, released, root, run, run_and_read, target};
use programs::{PROGRAMS, Program};
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// What is evaluated.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub(crate) struct Options {
    /// Run with little data, to see that it works; all programs if none is named
    #[arg(long)]
    short: bool,
    /// Write the figures that the programs print into evaluation/README.md
    #[arg(long)]
    record: bool,
    /// Print help, also of a program
    #[arg(long, short)]
    help: bool,
    /// A program; its options follow it
    program: Option<String>,
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<String>,
}

/// Runs one of the programs with its arguments, or all of them shortly.
pub(crate) fn evaluate(options: &Options) -> Result<(), String> {
    let program = options.program.as_deref().map(find).transpose()?;
    let asks = |argument: &String| matches!(argument.as_str(), "--help" | "-h");
    if options.help || options.arguments.iter().any(asks) {
        print!("{}", help::text(program)?);
        return Ok(());
    }
    let record = options.record;
    match (program, options.short) {
        (Some(program), false) => run_all(&[(program, &options.arguments)], record),
        (Some(program), true) => run_all(&[(program, &short(program, &options.arguments))], record),
        (None, true) => {
            let all: Vec<_> = PROGRAMS.iter().map(|p| (p, short(p, &[]))).collect();
            let all: Vec<_> = all.iter().map(|(p, arguments)| (*p, &arguments[..])).collect();
            run_all(&all, record)
        }
        (None, false) => Err(format!("which program?\n\n{}", help::text(None)?)),
    }
}

/// All programs, at full length.
pub(crate) fn evaluate_all() -> Result<(), String> {
    run_all(&PROGRAMS.iter().map(|program| (program, &[][..])).collect::<Vec<_>>(), false)
}

/// A program by its name, with these arguments.
pub(crate) fn evaluate_named(name: &str, is_short: bool) -> Result<(), String> {
    let program = find(name)?;
    run_all(&[(program, &if is_short { short(program, &[]) } else { Vec::new() })], false)
}

fn find(name: &str) -> Result<&'static Program, String> {
    let known = || PROGRAMS.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
    let found = PROGRAMS.iter().find(|p| p.name == name);
    found.ok_or_else(|| format!("there is no program {name}; there are {}", known()))
}

/// The arguments of the short form, and then those given.
fn short(program: &Program, given: &[String]) -> Vec<String> {
    program.short.iter().map(|word| (*word).to_owned()).chain(given.iter().cloned()).collect()
}

/// Builds once, and runs one after the other. Where the peers cannot be had, without them. `record` writes the figures
/// into evaluation/README.md.
fn run_all(programs: &[(&Program, &[String])], record: bool) -> Result<(), String> {
    // As `cargo test --release` builds it, see `program`.
    run(&mut cargo(&["test", "--release", "--quiet", "--no-run", "--test", "programs"]))?;
    // `command_line` measures the program that users run.
    if programs.iter().any(|(program, _)| program.name == "command_line") {
        crate::run::program(None)?;
    }
    let peers = peers();
    for (program, arguments) in programs {
        let mut command = Command::new(released("evaluation"));
        command.arg(program.name).args(*arguments).current_dir(root());
        command.envs(peers.iter().map(|python| ("STEERWRIGHT_PEERS_PYTHON", python)));
        let start = Instant::now();
        if record {
            record::record(program, arguments, &run_and_read(&mut command)?)?;
        } else {
            run(&mut command)?;
        }
        if programs.len() > 1 {
            eprintln!("{}: {:.1} s\n", program.name, start.elapsed().as_secs_f64());
        }
    }
    Ok(())
}

/// The interpreter with the peers' packages.
fn peers() -> Option<PathBuf> {
    let requirements = root().join("evaluation/requirements.txt");
    python::environment_in(&target().join("peers-python"), &requirements)
        .inspect_err(|problem| eprintln!("left out: peers from Python: {problem}"))
        .ok()
}
