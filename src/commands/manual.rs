//! `steerwright completions` and `steerwright man`: for shells and `man`, from the
//! definitions of the command line.

use crate::failure::{Failure, Outcome};
use crate::options::Global;
use crate::output::{OutputKind, Outputs};
use clap::{Command, CommandFactory};
use std::path::PathBuf;

/// Print the completions of a shell
///
///   steerwright completions bash > ~/.local/share/bash-completion/completions/steerwright
///   steerwright completions zsh > ~/.zfunc/_steerwright
///   steerwright completions fish > ~/.config/fish/completions/steerwright.fish
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct CompletionArguments {
    /// The shell
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

/// Print a man page, or write all of them
///
///   steerwright man identify | man -l -
///   steerwright man --out ~/.local/share/man/man1
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct ManArguments {
    /// The subcommand; without it the page of steerwright itself
    #[arg(value_name = "COMMAND", conflicts_with = "out")]
    command: Option<String>,
    /// Folder for a page of each command
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(crate) fn completions(arguments: &CompletionArguments) -> Result<Outcome, Failure> {
    let mut command = crate::Arguments::command();
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, name, &mut script);
    print(&script)
}

pub(crate) fn man(arguments: &ManArguments, global: &Global) -> Result<Outcome, Failure> {
    let pages = pages()?;
    if let Some(folder) = &arguments.out {
        let inputs: [PathBuf; 0] = [];
        let names = pages.iter().map(|(name, _)| format!("{name}.1"));
        let files = Outputs::new(global.force, inputs).files(folder, names, OutputKind::ManPage)?;
        for (name, page) in &pages {
            files.write(&format!("{name}.1"), page)?;
        }
        crate::terminal::console::note(format!("{} pages in {}", pages.len(), folder.display()));
        return Ok(Outcome::Done);
    }
    let wanted = match &arguments.command {
        Some(command) => format!("steerwright-{command}"),
        None => "steerwright".to_owned(),
    };
    let Some((_, page)) = pages.iter().find(|(name, _)| *name == wanted) else {
        let names = pages.iter().filter_map(|(name, _)| name.strip_prefix("steerwright-"));
        let names: Vec<&str> = names.collect();
        let message = format!("`{}` is no command", arguments.command.as_deref().unwrap_or(""));
        return Err(Failure::new(message, format!("the commands are {}", names.join(", "))));
    };
    print(page)
}

fn pages() -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let mut root = crate::Arguments::command().disable_help_subcommand(true);
    // Global options, usages and full names of subcommands are known after this.
    root.build();
    let commands = root.get_subcommands().filter(|command| !command.is_hide_set());
    std::iter::once(&root).chain(commands).map(page).collect()
}

fn page(command: &Command) -> Result<(String, Vec<u8>), Failure> {
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone())
        .render(&mut page)
        .map_err(|e| Failure::new(format!("{name}: {e}"), "report this as a fault"))?;
    Ok((name, page))
}

fn print(bytes: &[u8]) -> Result<Outcome, Failure> {
    crate::terminal::console::bytes(bytes).map_err(crate::terminal::console::NoOutput)?;
    Ok(Outcome::Done)
}
