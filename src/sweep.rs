//! `steerwright sweep`: Monte Carlo over closed loops of FMUs.

use crate::failure::{BAD_INPUT, Failure, Outcome};
use crate::output::{Files, Kind, Outputs};
use crate::progress::Progress;
use crate::{Global, console, program, quantity};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;
use steerwright_sweep::{
    Cause, FailureSummary, Finished, MetricSummary, Options, Requirement, Study, Summary, Sweep,
};

/// Run a Monte Carlo study: simulate a system of FMUs many times and evaluate every run
///
/// The study is a TOML file: the FMUs or the .ssp, the varied quantities and their distributions,
/// disturbances, metrics and requirements. A row of the results depends only on the study and the
/// number of the run. Without --isolate the binaries of the FMUs run in this process.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The study
    #[arg(value_name = "STUDY.toml")]
    study: PathBuf,
    /// Write the results here, a row a run
    #[arg(long = "output", short = 'o', value_name = "CSV", default_value = "results.csv")]
    out: PathBuf,
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

/// The result, for scripts.
#[derive(Serialize)]
struct Done {
    file: PathBuf,
    threads: usize,
    resumed: usize,
    warnings: Vec<String>,
    #[serde(flatten)]
    summary: Summary,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Outcome, Failure> {
    let study = Study::open(&arguments.study)?;
    let trajectories = decide(arguments, global, &study)?;
    // Our FMUs reset exactly, which a test verifies; for others the study states it.
    let sweep = Sweep::prepare(&study, &steerwright_packaging::ssp::MEASUREMENTS, &|tool| {
        tool.starts_with("steerwright ")
    })?;
    if let Some(files) = &trajectories {
        files.check_columns(&sweep.recorded().map(str::to_owned).collect::<Vec<_>>())?;
    }
    let timeout = Duration::try_from_secs_f64(arguments.timeout).ok().filter(|t| !t.is_zero());
    let timeout = timeout.ok_or_else(|| {
        Failure::new("--timeout: not above 0", "state the longest duration of a run, such as 60s")
    })?;
    if !(arguments.isolate || arguments.serve) {
        try_first_step(&study, &sweep, timeout)?;
    }
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed)).map_err(|e| {
        Failure::new(format!("no signal handler: {e}"), "run the command in a separate process")
    })?;
    let start = || isolated(arguments);
    // Worker processes print no progress.
    let progress = (!arguments.serve).then(|| Progress::start("running the study"));
    let options = Options {
        results: &arguments.out,
        threads: arguments.threads.map(usize::from),
        resume: arguments.resume,
        overwrite: global.force,
        trajectories: arguments.trajectories.clone().map(|dir| (dir, arguments.of.clone())),
        isolate: if arguments.isolate { Some(&start) } else { None },
        timeout: Some(timeout),
        // The thread that hangs cannot be waited for.
        hung: &|run, rows| hung(arguments, run, rows, sweep.runs()).exit(BAD_INPUT),
        stop: &stop,
        progress: &|rows| {
            if let Some(progress) = &progress {
                progress.count(rows, sweep.runs());
            }
        },
    };
    if arguments.serve {
        sweep.serve(&options, std::io::stdin().lock(), std::io::stdout())?;
        return Ok(Outcome::Done);
    }
    let warnings = warnings(&sweep, arguments);
    for warning in &warnings {
        console::warning(warning);
    }
    let finished = sweep.run(&options);
    drop(progress);
    let finished = finished?;
    complete(arguments, &finished)?;
    let met = finished.summary.all_passed();
    let text = text(&finished);
    let done = Done {
        file: arguments.out.clone(),
        threads: finished.threads,
        resumed: finished.resumed,
        warnings,
        summary: finished.summary,
    };
    console::result(&text, &done)?;
    console::note(format!("written to {}", arguments.out.display()));
    Ok(Outcome::when(met))
}

/// Rejects outputs that would replace an input or a foreign file; returns the files of the trajectories.
fn decide(arguments: &Arguments, global: &Global, study: &Study) -> Result<Option<Files>, Failure> {
    if arguments.serve {
        return Ok(None);
    }
    let inputs = study.files().into_iter().chain([arguments.study.clone()]);
    let inputs: Vec<PathBuf> = inputs.collect();
    // The sweep checks whether results can be resumed.
    Outputs::new(global.force || arguments.resume, &inputs)
        .file(&arguments.out, Kind::SweepResults)?;
    let trajectories = |folder| {
        let runs: BTreeSet<usize> = arguments.of.iter().copied().collect();
        let names = runs.iter().map(|run| format!("run-{run}.csv"));
        let inputs = inputs.iter().chain([&arguments.out]);
        Outputs::new(global.force, inputs).files(folder, names, Kind::Recording)
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

/// Whether a first step can be made at all; ends the process where it hangs.
fn try_first_step(study: &Study, sweep: &Sweep, timeout: Duration) -> Result<(), Failure> {
    let (done, wait) = mpsc::channel::<()>();
    std::thread::spawn(move || {
        if wait.recv_timeout(timeout) == Err(mpsc::RecvTimeoutError::Timeout) {
            let problem = format!("the first step takes longer than {} s", timeout.as_secs_f64());
            Failure::new(problem, "increase --timeout, or try the FMU with check --run")
                .exit(BAD_INPUT)
        }
    });
    let tried = sweep.try_first_step(study);
    drop(done);
    Ok(tried?)
}

/// The error of an FMU that does not return.
fn hung(arguments: &Arguments, run: usize, rows: usize, runs: usize) -> Failure {
    let (out, limit) = (arguments.out.display(), arguments.timeout);
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
    command.args(first);
    command.arg("sweep").arg(&arguments.study).arg("--serve");
    command.arg("--timeout").arg(format!("{}s", arguments.timeout));
    if let Some(folder) = &arguments.trajectories {
        let runs: Vec<String> = arguments.of.iter().map(ToString::to_string).collect();
        command.arg("--trajectories").arg(folder).args(["--of", &runs.join(",")]);
    }
    command
}

/// An error for incomplete results; they hold the first rows and can be resumed.
fn complete(arguments: &Arguments, finished: &Finished) -> Result<(), Failure> {
    let (rows, runs) = (finished.rows, finished.summary.runs);
    if rows == runs {
        return Ok(());
    }
    let held = format!("{} holds {rows} of {runs} runs", arguments.out.display());
    Err(match &finished.fatal {
        Some(fatal) => Failure::new(
            format!("{fatal}\nno function of that FMU may be called any more; {held}"),
            "continue with --resume; with --isolate such a run is a row and the sweep continues",
        ),
        None => Failure::new(format!("interrupted: {held}"), "continue with --resume"),
    })
}

fn text(finished: &Finished) -> String {
    let summary = &finished.summary;
    let mut table = steerwright_report::Table::new([
        "metric", "unit", "median", "5 %", "95 %", "99 %", "largest", "met",
    ]);
    for metric in &summary.metrics {
        let MetricSummary { name, unit, median, q05, q95, q99, maximum, requirement, .. } = metric;
        let cells = [median, q05, q95, q99, maximum]
            .map(|value| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.4}")));
        let met = requirement.as_ref().map_or_else(String::new, share);
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
        let among = among.as_ref().map_or_else(String::new, |c| format!("with {c}: "));
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
