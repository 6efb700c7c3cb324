//! `steerwright sweep`: Monte Carlo over closed loops of FMUs.

use crate::failure::{BAD_INPUT, Failure, Outcome};
use crate::options::Global;
use crate::options::quantity;
use crate::output::{Files, OutputKind, Outputs};
use crate::process::program;
use crate::process::program::GUARDED_BY;
use crate::terminal::console;
use crate::terminal::progress::Progress;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, SystemTime};
use steerwright_host::process::{lines_of_parent, on_interruption};
use steerwright_sweep::{
    Cause, FailureSummary, Finished, MetricSummary, Options, Requirement, Study, Summary, Sweep,
    SweepPiece,
};

/// How long `merge` waits for the FMUs, as a sweep does without --timeout.
const PATIENCE: Duration = Duration::from_secs(600);

/// Run a Monte Carlo study: simulate a system of FMUs many times and evaluate every run
///
/// The study is a TOML file: the FMUs or the .ssp, the varied quantities and their distributions,
/// disturbances, metrics and requirements. A row of the results depends only on the study and the
/// number of the run. Without --isolate all runs share one process: an FMU that crashes ends the sweep.
///
/// On a cluster, `--shard I/N` makes one of N pieces of the study, on any machine, in any order, again after a
/// failure; `sweep merge` makes the results of them.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    merge: Option<Merge>,
    /// The study
    #[arg(value_name = "STUDY.toml", required = true)]
    study: Option<PathBuf>,
    /// Write the results here, a row a run; by default results.csv. With --shard the folder of the pieces, by
    /// default pieces
    #[arg(long = "output", short = 'o', value_name = "CSV")]
    out: Option<PathBuf>,
    /// Make only this part of the runs, counted from 0, such as 0/100 to 99/100, in a file of the folder
    /// --output whose name states study and runs. A piece that is there is not made again
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with_all = ["resume", "trajectories"])]
    shard: Option<(usize, usize)>,
    /// Continue with the unfinished results of an earlier call
    #[arg(long)]
    resume: bool,
    /// Threads; by default one a core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Run the FMUs of each thread in a separate process: a crash ends one run only, and FMUs that allow
    /// one instance per process run on all threads
    #[arg(long)]
    isolate: bool,
    /// Longest duration of a run; a longer run is a row with an error. An FMU that does not return ends
    /// the sweep, which --resume continues; with --isolate it ends its run only
    #[arg(long, value_name = "TIME", default_value = "600s", allow_hyphen_values = true, value_parser = quantity::time)]
    timeout: f64,
    /// The process that `--isolate` starts
    #[arg(long, hide = true, conflicts_with = "isolate")]
    serve: bool,
    /// Write trajectories of the runs that --of names into this folder
    #[arg(long, value_name = "DIR", requires = "of")]
    trajectories: Option<PathBuf>,
    /// Runs to write trajectories of, such as 0,7,12
    #[arg(long, value_name = "RUNS", value_delimiter = ',', requires = "trajectories")]
    of: Vec<usize>,
}

#[derive(clap::Subcommand)]
enum Merge {
    /// Merge the pieces of a study to its results, the same bytes as without shards
    Merge(MergeArguments),
}

#[derive(clap::Args)]
struct MergeArguments {
    /// The study
    #[arg(value_name = "STUDY.toml")]
    study: PathBuf,
    /// The pieces that --shard wrote, in any order
    #[arg(required = true, value_name = "PIECE")]
    pieces: Vec<PathBuf>,
    /// Write the results here, a row a run
    #[arg(long = "output", short = 'o', value_name = "CSV", default_value = "results.csv")]
    out: PathBuf,
}

/// A shard and their number.
fn shard(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    let (index, of) = numbers.ok_or("expected I/N, such as 0/100")?;
    match of {
        0 => Err("there is at least one shard".into()),
        _ if index < of => Ok((index, of)),
        _ => Err(format!("the shards are counted from 0: the last is {}/{of}", of - 1)),
    }
}

/// The result, for scripts.
#[derive(Serialize)]
struct Done {
    file: Option<PathBuf>,
    threads: usize,
    resumed: usize,
    warnings: Vec<String>,
    #[serde(flatten)]
    summary: Summary,
}

impl Arguments {
    fn study(&self) -> &Path {
        self.study.as_deref().unwrap_or(Path::new(""))
    }

    fn out(&self) -> &Path {
        let usual = if self.shard.is_some() { "pieces" } else { "results.csv" };
        self.out.as_deref().unwrap_or(Path::new(usual))
    }
}

impl Arguments {
    /// Whether it calls FMUs in its own process.
    pub(crate) fn calls_fmus(&self) -> bool {
        // With --isolate, too, and to merge, FMUs are instantiated to prepare the study.
        !self.serve
    }

    /// What is left of a sweep that began then and whose process did not come to its end.
    pub(crate) fn kept(&self, began: SystemTime) -> Option<String> {
        if self.merge.is_some() {
            return None;
        }
        if self.shard.is_some() {
            let isolate = if self.isolate { "" } else { "; with --isolate such a run is a row" };
            return Some(format!("the piece is not kept{isolate}"));
        }
        let out = self.out();
        let written = std::fs::metadata(out).and_then(|file| file.modified()).ok()?;
        if written < began {
            return None;
        }
        let how = if self.isolate { "" } else { " --isolate, where such a run is a row" };
        Some(format!("{} has the runs that were done: continue with --resume{how}", out.display()))
    }
}

/// A study whose FMUs are instantiated and, where `is_tried`, make a first step; ends the process where that hangs.
fn prepared(study: &Study, limit: Duration, is_tried: bool) -> Result<Sweep, Failure> {
    let (done, wait) = mpsc::channel::<()>();
    std::thread::spawn(move || {
        if wait.recv_timeout(limit) == Err(mpsc::RecvTimeoutError::Timeout) {
            let limit = limit.as_secs_f64();
            let problem = format!("an FMU does not return within {limit} s, before the first run");
            Failure::new(problem, "increase --timeout, or try the FMU with check --run")
                .exit(BAD_INPUT)
        }
    });
    // Our FMUs reset exactly, which a test verifies; for others the study states it.
    let resets = |tool: &str| tool.starts_with("steerwright ");
    let sweep = Sweep::prepare(study, &steerwright_packaging::ssp::MEASUREMENTS, &resets)?;
    if is_tried {
        sweep.try_first_step(study)?;
    }
    drop(done);
    Ok(sweep)
}

fn merge(arguments: &MergeArguments, global: &Global) -> Result<Outcome, Failure> {
    let study = Study::open(&arguments.study)?;
    let inputs = study.files().into_iter().chain([arguments.study.clone()]);
    let inputs: Vec<PathBuf> = inputs.chain(arguments.pieces.iter().cloned()).collect();
    Outputs::new(global.force, &inputs).file(&arguments.out, OutputKind::SweepResults)?;
    let sweep = prepared(&study, PATIENCE, false)?;
    let finished = sweep.merge(&arguments.pieces, &arguments.out, global.force)?;
    report(finished, Some(arguments.out.clone()), Vec::new())
}

/// Prints the summary of whole results.
fn report(
    finished: Finished,
    file: Option<PathBuf>,
    warnings: Vec<String>,
) -> Result<Outcome, Failure> {
    let met = finished.summary.all_passed();
    let text = text(&finished);
    let note = file.as_ref().map(|file| format!("written to {}", file.display()));
    let (threads, resumed) = (finished.threads, finished.resumed);
    let done = Done { file, threads, resumed, warnings, summary: finished.summary };
    console::result(&text, &done)?;
    note.iter().for_each(console::note);
    Ok(Outcome::when(met))
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    if let Some(Merge::Merge(arguments)) = &arguments.merge {
        return merge(arguments, global);
    }
    let study = Study::open(arguments.study())?;
    let trajectories = decide(arguments, global, &study)?;
    let limit = Duration::try_from_secs_f64(arguments.timeout).ok().filter(|t| !t.is_zero());
    let limit = limit.ok_or_else(|| {
        Failure::new("--timeout: not above 0", "state the longest duration of a run, such as 60s")
    })?;
    let sweep = prepared(&study, limit, !(arguments.isolate || arguments.serve))?;
    if let Some(files) = &trajectories {
        files.check_columns(&sweep.recorded().map(str::to_owned).collect::<Vec<_>>())?;
    }
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    on_interruption(move || asked.store(true, Ordering::Relaxed)).map_err(|e| {
        Failure::new(format!("no signal handler: {e}"), "run the command in a separate process")
    })?;
    let start = || isolated(arguments);
    // Worker processes print no progress.
    let progress = if arguments.serve { None } else { Some(Progress::start("running the study")) };
    let options = Options {
        results: arguments.out(),
        runs: None,
        threads: arguments.threads.map(usize::from),
        resume: arguments.resume,
        overwrite: global.force,
        trajectories: arguments.trajectories.clone().map(|dir| (dir, arguments.of.clone())),
        isolate: if arguments.isolate { Some(&start) } else { None },
        timeout: Some(limit),
        // The thread that hangs cannot be waited for.
        hung: &|run, rows| {
            if stop.load(Ordering::Relaxed) {
                interrupted(arguments, rows, sweep.runs()).exit(BAD_INPUT)
            }
            hung(arguments, run, rows, sweep.runs()).exit(BAD_INPUT)
        },
        stop: &stop,
        progress: &|rows| {
            if let Some(progress) = &progress {
                progress.count(rows, sweep.runs());
            }
        },
    };
    if arguments.serve {
        let lines = lines_of_parent()
            .map_err(|e| Failure::new(format!("stdin: {e}"), "--isolate starts this process"))?;
        sweep.serve(&options, lines, std::io::stdout())?;
        return Ok(Outcome::Done);
    }
    let warnings = warnings(&sweep, arguments);
    for warning in &warnings {
        console::warning(warning);
    }
    if let Some(shard) = arguments.shard {
        let piece = sweep.piece(arguments.out(), shard, &options);
        drop(progress);
        return finish_piece(arguments, piece?, sweep.runs(), study.files());
    }
    let finished = sweep.run(&options);
    drop(progress);
    let finished = finished?;
    complete(arguments, &finished, finished.summary.runs)?;
    report(finished, Some(arguments.out().into()), warnings)
}

fn finish_piece(
    arguments: &Arguments,
    piece: SweepPiece,
    study_runs: usize,
    study_files: Vec<PathBuf>,
) -> Result<Outcome, Failure> {
    let SweepPiece { file, runs, finished, was_there } = piece;
    let note = file.as_ref().map(|file| format!("written to {}", file.display()));
    let done = PieceDone { file, runs: runs.len(), was_there, study_runs, study_files };
    let Some(finished) = finished else {
        let text = match &done.file {
            Some(file) => format!("{} is complete", file.display()),
            None => "the shard has no runs: there are more shards than runs".to_owned(),
        };
        console::result(&text, &done)?;
        return Ok(Outcome::Done);
    };
    complete(arguments, &finished, runs.len())?;
    // Requirements are those of the whole study: `merge` reports them.
    console::result(&outcomes(&finished.summary), &done)?;
    note.iter().for_each(console::note);
    Ok(Outcome::Done)
}

/// The result of a shard, for scripts.
#[derive(Serialize)]
struct PieceDone {
    file: Option<PathBuf>,
    runs: usize,
    was_there: bool,
    study_runs: usize,
    study_files: Vec<PathBuf>,
}

/// Rejects outputs that would replace an input or a foreign file; returns the files of the trajectories.
fn decide(arguments: &Arguments, global: &Global, study: &Study) -> Result<Option<Files>, Failure> {
    if arguments.serve {
        return Ok(None);
    }
    if arguments.shard.is_some() {
        // A piece replaces only a file of its own name, which states its content.
        return Ok(None);
    }
    let inputs = study.files().into_iter().chain([arguments.study().into()]);
    let inputs: Vec<PathBuf> = inputs.collect();
    // The sweep checks whether results can be resumed.
    Outputs::new(global.force || arguments.resume, &inputs)
        .file(arguments.out(), OutputKind::SweepResults)?;
    let trajectories = |folder| {
        let runs: BTreeSet<usize> = arguments.of.iter().copied().collect();
        let names = runs.iter().map(|run| format!("run-{run}.csv"));
        let out = arguments.out().to_path_buf();
        let inputs = inputs.iter().chain([&out]);
        Outputs::new(global.force, inputs).files(folder, names, OutputKind::Recording)
    };
    arguments.trajectories.as_deref().map(trajectories).transpose()
}

fn warnings(sweep: &Sweep, arguments: &Arguments) -> Vec<String> {
    let mut warnings = sweep.remarks().to_vec();
    if let Some(fmu) = sweep.only_once()
        && arguments.threads != Some(1)
        && !arguments.isolate
    {
        warnings.push(format!(
            "{fmu} allows one instance in a process: one thread runs; --isolate lets all run"
        ));
    }
    warnings
}

/// The error of an FMU that does not return.
fn hung(arguments: &Arguments, run: usize, rows: usize, runs: usize) -> Failure {
    let (out, limit) = (arguments.out().display(), arguments.timeout);
    Failure::new(
        format!(
            "run {run} hangs: an FMU does not return, after twice the --timeout of {limit} s; {out} \
             holds {rows} of {runs} runs"
        ),
        "continue with --resume --isolate, which ends that run only",
    )
}

/// This command once more, for the FMUs of one thread.
fn isolated(arguments: &Arguments) -> Command {
    // Without the path of this program, the start fails with an error.
    let (program, first) = program::words().unwrap_or_default();
    let mut command = Command::new(program);
    command.env_remove(GUARDED_BY).args(first);
    command.arg("sweep").arg(arguments.study()).arg("--serve");
    command.arg("--timeout").arg(format!("{}s", arguments.timeout));
    if let Some(folder) = &arguments.trajectories {
        let runs: Vec<String> = arguments.of.iter().map(ToString::to_string).collect();
        command.arg("--trajectories").arg(folder).args(["--of", &runs.join(",")]);
    }
    command
}

/// An error for incomplete results; they hold the first rows and can be resumed.
fn complete(arguments: &Arguments, finished: &Finished, runs: usize) -> Result<(), Failure> {
    let rows = finished.rows;
    if rows == runs {
        return Ok(());
    }
    if arguments.shard.is_some() {
        let why = finished.fatal.as_deref().unwrap_or("interrupted");
        return Err(Failure::new(
            format!("{why}: the piece has {rows} of {runs} runs and is not kept"),
            "make the shard again; with --isolate a run that ends fatally is a row",
        ));
    }
    let held = rows_held(arguments, rows, runs);
    Err(match &finished.fatal {
        Some(fatal) => Failure::new(
            format!("{fatal}\nno function of that FMU may be called any more; {held}"),
            "continue with --resume; with --isolate such a run is a row and the sweep continues",
        ),
        None => interrupted(arguments, rows, runs),
    })
}

fn interrupted(arguments: &Arguments, rows: usize, runs: usize) -> Failure {
    if arguments.shard.is_some() {
        let message = format!("interrupted: the piece has {rows} runs and is not kept");
        return Failure::new(message, "make the shard again");
    }
    let held = rows_held(arguments, rows, runs);
    Failure::new(format!("interrupted: {held}"), "continue with --resume")
}

fn rows_held(arguments: &Arguments, rows: usize, runs: usize) -> String {
    format!("{} holds {rows} of {runs} runs", arguments.out().display())
}

fn text(finished: &Finished) -> String {
    let summary = &finished.summary;
    let mut table = steerwright_report::Table::new([
        "metric", "unit", "median", "5 %", "95 %", "99 %", "largest", "met",
    ]);
    for metric in &summary.metrics {
        let MetricSummary { name, unit, median, q05, q95, q99, maximum, requirement, .. } = metric;
        let cells = [median, q05, q95, q99, maximum].map(|value| match value {
            Some(value) => format!("{value:.4}"),
            None => "–".to_owned(),
        });
        let met = match requirement.as_ref() {
            Some(value) => share(value),
            None => String::new(),
        };
        let names = [name.clone(), unit.clone().unwrap_or_default()];
        table = table.row(names.into_iter().chain(cells).chain([met]));
    }
    let mut text = outcomes(summary);
    for failure in &summary.failures {
        text += &causes(failure);
    }
    if let Some(error) = &summary.first_error {
        text += &format!("the first error: {error}\n");
    }
    text + &format!("\n{}", console::table(&table))
}

/// The number of runs of each outcome.
fn outcomes(summary: &Summary) -> String {
    let all: Vec<String> =
        summary.outcomes.iter().map(|o| format!("{} {}", o.runs, o.outcome.name())).collect();
    let mut text = format!("{} runs: {}\n", summary.rows, all.join(", "));
    if let Some(passed) = &summary.passed {
        text += &format!("{} as required: {}\n", passed.passed, share(passed));
    }
    text
}

/// The varied quantities that go with a kind of failure.
fn causes(failure: &FailureSummary) -> String {
    let kind = failure.outcome.map_or("all failures", steerwright_sweep::Class::name);
    if failure.causes.is_empty() {
        return format!("{kind}: {} runs; no varied quantity explains them\n", failure.runs);
    }
    let mut text = format!("{kind}: {} runs\n", failure.runs);
    for cause in &failure.causes {
        let Cause { among, condition, with, without, .. } = cause;
        let all = with.failed + without.failed;
        let among = match among.as_ref() {
            Some(c) => format!("with {c}: "),
            None => String::new(),
        };
        text += &format!(
            "  {among}{} of {all} have {condition} ({} of {} runs there, {} of {} elsewhere)\n",
            with.failed, with.failed, with.of, without.failed, without.of
        );
    }
    text
}

/// A share with its interval, in percent.
fn share(requirement: &Requirement) -> String {
    let [low, high] = requirement.share_interval_95.map(|share| 100.0 * share);
    format!("{:.1} % ({low:.1} to {high:.1})", 100.0 * requirement.share)
}
