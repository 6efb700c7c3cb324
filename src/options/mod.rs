//! Options that several commands have, and how their values are read.

pub(crate) mod log;
pub(crate) mod profile;
pub(crate) mod quantity;
pub(crate) mod specification;

/// Options of every subcommand.
#[derive(clap::Args, Debug, Clone, Copy)]
pub(crate) struct Global {
    /// Overwrite an existing file of any content, and replace a folder with changed files; an input is
    /// never overwritten, a foreign file in a folder never removed
    #[arg(long, global = true)]
    pub(crate) force: bool,
    /// Print the result as JSON on stdout, and errors as JSON on stderr
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print also what only a specialist reads, such as the table of orders, poles and zeros, and all parameters
    #[arg(long, global = true)]
    pub(crate) verbose: bool,
    /// Report progress at this interval, with --json
    #[arg(long, global = true, hide = true, value_name = "TIME", value_parser = quantity::time)]
    pub(crate) progress_interval: Option<f64>,
    /// End when the process that holds the other end of standard input does
    #[arg(long, global = true, hide = true)]
    pub(crate) end_with_parent: bool,
}
