//! `cargo xtask snapshot`: the results of every command, compared with `tests/snapshot.csv`. It shows whether a change
//! of the code changes a result.
//!
//! The table has a fingerprint of each output and is compared with a tolerance. `--record` writes the outputs
//! themselves, which `--compare` compares bit for bit: those of two builds on one machine. With `STEERWRIGHT_FMU_BINARIES`
//! the libraries are those of one platform: the texts about archives name each.

mod archive;
mod commands;
mod execute;
mod fingerprint;
mod inputs;
mod mask;
mod recording;
mod table;

use crate::files::{all_below, read, write};
use crate::run::{program, root, target};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What is recorded or compared.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Write the table of the fingerprints again
    #[arg(long, conflicts_with_all = ["record", "compare"])]
    update: bool,
    /// Write all outputs into this folder, which is new, instead
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Folder of further logs (CSV), whose outputs are recorded too
    #[arg(long, value_name = "DIR", requires = "record")]
    cases: Option<PathBuf>,
    /// Compare two recordings bit for bit instead
    #[arg(long, num_args = 2, value_names = ["DIR", "DIR"], conflicts_with = "record")]
    compare: Option<Vec<PathBuf>>,
    /// The program, by default that of this workspace, which is built
    #[arg(long, value_name = "FILE", conflicts_with = "compare")]
    program: Option<PathBuf>,
    /// Print the time of each command
    #[arg(long, conflicts_with = "compare")]
    times: bool,
}

/// Runs all commands and compares their outputs, or writes them.
pub(crate) fn snapshot(options: &Options) -> Result<(), String> {
    if let Some([before, now]) = options.compare.as_deref() {
        return match recording::compare(before, now)? {
            0 => Ok(()),
            count => Err(format!("{count} files differ")),
        };
    }
    if let Some(folder) = options.record.as_ref().filter(|folder| folder.exists()) {
        return Err(format!("{} exists\nhint: name a new folder", folder.display()));
    }
    let outputs = outputs(options)?;
    if let Some(folder) = &options.record {
        return recording::save(&outputs, folder);
    }
    let file = root().join("tests/snapshot.csv");
    let now = table::table(&outputs);
    if options.update {
        return write(&file, table::to_csv(&now).as_bytes());
    }
    let before = table::from_csv(&read(&file)?).map_err(|e| format!("{}: {e}", file.display()))?;
    report(&table::differences(&before, &now))
}

/// The outputs of all commands.
fn outputs(options: &Options) -> Result<Vec<recording::Output>, String> {
    let program = options.program.clone().map_or_else(|| program(None), Ok)?;
    let program = program.canonicalize().map_err(|e| format!("{}: {e}", program.display()))?;
    let begun = Instant::now();
    let work = target().join("snapshot");
    inputs::prepare(&work, options.cases.as_deref())?;
    let cases = options.cases.as_deref().map_or(Ok(Vec::new()), logs)?;
    let commands = commands::commands(&cases)?;
    let masks = mask::Masks::new(&work, root());
    let runner = execute::Runner { program: &program, work: &work, masks };
    let execute::Recording { outputs, mut times } = runner.run_all(&commands)?;
    if options.times {
        times.sort();
        times.iter().for_each(|(time, name)| eprintln!("{:6.2} s {name}", time.as_secs_f64()));
    }
    let (commands, files) = (commands.len(), outputs.len());
    eprintln!("{commands} commands, {files} outputs in {:.0} s", begun.elapsed().as_secs_f64());
    Ok(outputs)
}

/// The logs of a folder, relative to it.
fn logs(folder: &Path) -> Result<Vec<String>, String> {
    let is_log = |file: &&PathBuf| file.extension().is_some_and(|end| end == "csv");
    let name = |file: &PathBuf| file.strip_prefix(folder).unwrap_or(file).display().to_string();
    Ok(all_below(folder)?.iter().filter(is_log).map(name).collect())
}

fn report(differences: &[String]) -> Result<(), String> {
    if differences.is_empty() {
        return Ok(());
    }
    Err(format!(
        "{} outputs differ from tests/snapshot.csv\n  {}\nhint: to see the differences, run `cargo xtask \
         snapshot --record DIR` here and in a clone before the change, and `cargo xtask snapshot --compare \
         DIR DIR`; if the results are to change, `cargo xtask snapshot --update`",
        differences.len(),
        differences.join("\n  ")
    ))
}
