//! The runs of a study on some threads, their rows in order.
//!
//! Each thread has instances and buffers of its own and takes the next run that nobody has; rows
//! wait until those before them are written. A run that an FMU refuses is a row with its error.
//! After `fmi2Fatal` nothing of that FMU may be called any more in this process: the sweep ends
//! there, and can be gone on with in another process.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use fmi2_host::{Error as HostError, Status};

use crate::error::Error;
use crate::isolate::Worker;
use crate::prepare::Sweep;
use crate::results::{Outcome, Results, row};
use crate::rig::{Ended, Rig};
use crate::summary::Summary;
use crate::trajectory;
use crate::watch::Watch;

/// How to run a study.
pub struct Options<'a> {
    /// The results file; `-` is stdout.
    pub results: &'a Path,
    /// Threads; by default as many as there are cores.
    pub threads: Option<usize>,
    /// Go on with the results file, if it is there.
    pub resume: bool,
    /// Write over unfinished results of the same study.
    pub overwrite: bool,
    /// Where to write trajectories, and of which runs.
    pub trajectories: Option<(PathBuf, Vec<usize>)>,
    /// Has the FMUs of each thread in a process of its own, started by this; see [`Sweep::serve`].
    pub isolate: Option<&'a (dyn Fn() -> Command + Sync)>,
    /// The longest that a run may take; one that takes longer is a row with an error.
    pub timeout: Option<Duration>,
    /// Told of a run, and of the rows in the file, where an FMU in this process does not return: it
    /// cannot be made to, so the process is to be ended.
    pub hung: &'a (dyn Fn(usize, usize) + Sync),
    /// Set, from anywhere, to end as soon as may be.
    pub stop: &'a AtomicBool,
    /// Told the number of rows in the file whenever it grows.
    pub progress: &'a (dyn Fn(usize) + Sync),
}

/// What a call did.
#[derive(Debug)]
pub struct Finished {
    /// Rows that were there before.
    pub resumed: usize,
    /// Rows in the file now.
    pub rows: usize,
    /// Threads that ran.
    pub threads: usize,
    /// The FMU that ended fatally, if that is why not all runs were made.
    pub fatal: Option<String>,
    /// What the rows say together.
    pub summary: Summary,
}

/// What a thread tells.
enum Told {
    Row(usize, Outcome, Vec<u8>),
    Fatal(String),
    Io(Error),
    Ended,
}

impl Sweep {
    /// Runs what is left to do and appends it to the results.
    pub fn run(&self, options: &Options<'_>) -> Result<Finished, Error> {
        let wanted: &[usize] = options.trajectories.as_ref().map_or(&[], |(_, runs)| runs);
        if let Some(&run) = wanted.iter().find(|run| **run >= self.runs()) {
            return Err(Error::NoSuchRun { run, runs: self.runs() });
        }
        let (mut results, mut outcomes) = if options.resume {
            Results::resume(self, options.results)?
        } else {
            (Results::create(self, options.results, options.overwrite)?, Vec::new())
        };
        let resumed = outcomes.len();
        (options.progress)(resumed);
        let threads = self.threads(options, self.runs() - resumed);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Error::Threads { reason: e.to_string() })?;
        let next = AtomicUsize::new(resumed);
        let ending = AtomicBool::new(false);
        let watch = Watch::new(options.timeout, threads);
        let (tell, told) = mpsc::channel();
        let mut fatal = None;
        let written = pool.in_place_scope(|scope| {
            scope.spawn_broadcast(|_, context| {
                // Told also where a panic ends the thread.
                let _end = AtEnd(&tell);
                self.work(options, &next, &ending, &tell, (&watch, context.index()));
            });
            let mut waiting = BTreeMap::new();
            let mut running = threads;
            let mut result = Ok(());
            while running > 0 {
                let message = match told.recv_timeout(watch.look()) {
                    Ok(message) => message,
                    Err(mpsc::RecvTimeoutError::Disconnected) => break,
                    Err(mpsc::RecvTimeoutError::Timeout) => {
                        if let Some(run) = watch.hung() {
                            ending.store(true, Ordering::Relaxed);
                            (options.hung)(run, outcomes.len());
                        }
                        continue;
                    }
                };
                match message {
                    Told::Ended => running -= 1,
                    Told::Fatal(text) => fatal = fatal.take().or(Some(text)),
                    Told::Io(error) => result = result.and(Err(error)),
                    Told::Row(run, outcome, bytes) => {
                        waiting.insert(run, (outcome, bytes));
                    }
                }
                while let Some((outcome, bytes)) = waiting.remove(&outcomes.len()) {
                    if result.is_ok() {
                        result = results.append(&bytes);
                    }
                    if result.is_err() {
                        break;
                    }
                    outcomes.push(outcome);
                    (options.progress)(outcomes.len());
                }
                if result.is_err() {
                    ending.store(true, Ordering::Relaxed);
                }
            }
            result
        });
        written?;
        self.earlier_trajectories(options, resumed)?;
        let summary = Summary::of(self, &outcomes);
        Ok(Finished { resumed, rows: outcomes.len(), threads, fatal, summary })
    }

    /// Threads that have something to do, one where an FMU allows one instance.
    fn threads(&self, options: &Options<'_>, left: usize) -> usize {
        let one = self.only_once.is_some() && options.isolate.is_none();
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let wanted = options.threads.unwrap_or_else(cores);
        if one { 1 } else { wanted.clamp(1, left.max(1)) }
    }

    /// An FMU that keeps the sweep to one thread.
    #[must_use]
    pub fn only_once(&self) -> Option<&str> {
        self.only_once.as_deref()
    }

    fn work(
        &self,
        options: &Options<'_>,
        next: &AtomicUsize,
        ending: &AtomicBool,
        tell: &mpsc::Sender<Told>,
        (watch, thread): (&Watch, usize),
    ) {
        let mut maker = Maker::new(self, options);
        let asked = || options.stop.load(Ordering::Relaxed) || ending.load(Ordering::Relaxed);
        while !asked() {
            let run = next.fetch_add(1, Ordering::Relaxed);
            if run >= self.runs() {
                break;
            }
            let made = maker.make(self, options, run, Some((watch, thread)));
            watch.end(thread);
            let made = match made {
                Ok(made) => made,
                Err(error) => {
                    // Whoever does not listen any more does not miss it.
                    let _ = tell.send(Told::Io(error));
                    break;
                }
            };
            if let Some(text) = made.fatal {
                ending.store(true, Ordering::Relaxed);
                let _ = tell.send(Told::Fatal(text));
            }
            let Some((outcome, bytes)) = made.row else { break };
            let _ = tell.send(Told::Row(run, outcome, bytes));
        }
    }

    /// Makes a run here, with its trajectory written if it was asked for.
    pub(crate) fn make_here(
        &self,
        rig: &mut Rig<'_>,
        options: &Options<'_>,
        run: usize,
    ) -> Result<Made, Error> {
        let quantities = self.plan.quantities(run);
        rig.deadline = options.timeout.map(|timeout| Instant::now() + timeout);
        let wanted = options.trajectories.as_ref();
        let stop = options.stop;
        let result = match wanted {
            Some((folder, runs)) if runs.contains(&run) => {
                trajectory::write(&self.plan, rig, folder, run, &quantities, stop)?
            }
            _ => rig.run(run, &quantities, stop, None),
        };
        let (outcome, fatal, aftermath) = match result {
            Ok(metrics) => (Outcome::Done(metrics), None, false),
            Err(Ended::Stopped) => return Ok(Made { row: None, fatal: None }),
            Err(Ended::TooLong) => (Outcome::Failed(too_long(options)), None, false),
            Err(Ended::Failed(error)) => {
                let text = in_a_line(&format!("error: {error}"));
                let fatal = is_fatal(&error).then(|| error.to_string());
                (Outcome::Failed(text), fatal, matches!(error, HostError::Fatal { .. }))
            }
        };
        // Of an FMU that had ended before, the run itself is not to blame.
        let bytes = (!aftermath).then(|| row(self, run, &quantities, &outcome));
        Ok(Made { row: bytes.map(|bytes| (outcome, bytes)), fatal })
    }

    /// Trajectories of runs that an earlier call made; what they ended with stands in their rows.
    fn earlier_trajectories(&self, options: &Options<'_>, resumed: usize) -> Result<(), Error> {
        let Some((_, runs)) = &options.trajectories else { return Ok(()) };
        let mut maker = Maker::new(self, options);
        for &run in runs.iter().filter(|run| **run < resumed) {
            maker.make(self, options, run, None)?;
        }
        Ok(())
    }
}

/// What became of a run.
pub(crate) struct Made {
    /// Nothing, where it was stopped or could not be begun.
    pub(crate) row: Option<(Outcome, Vec<u8>)>,
    /// Why nothing more can be run in the same process.
    pub(crate) fatal: Option<String>,
}

/// Where a thread's runs are made.
enum Maker<'a> {
    Here(Box<Rig<'a>>),
    Apart(Worker<'a>),
}

impl<'a> Maker<'a> {
    fn new(sweep: &'a Sweep, options: &Options<'a>) -> Self {
        match options.isolate {
            None => Self::Here(Box::new(Rig::new(&sweep.plan, sweep.source.archives()))),
            Some(start) => Self::Apart(Worker::new(start)),
        }
    }

    fn make(
        &mut self,
        sweep: &Sweep,
        options: &Options<'_>,
        run: usize,
        watched: Option<(&Watch, usize)>,
    ) -> Result<Made, Error> {
        match self {
            Self::Here(rig) => {
                if let Some((watch, thread)) = watched {
                    watch.begin(thread, run, None);
                }
                sweep.make_here(rig, options, run)
            }
            Self::Apart(worker) => worker.make(sweep, run, options, watched),
        }
    }
}

/// What stands in the row of a run that takes longer than it may.
pub(crate) fn too_long(options: &Options<'_>) -> String {
    let limit = options.timeout.map_or(f64::INFINITY, |timeout| timeout.as_secs_f64());
    format!("error: the run takes longer than {limit} s")
}

/// Whether an FMU may not be called any more in this process.
fn is_fatal(error: &HostError) -> bool {
    matches!(
        error,
        HostError::Call { status: Status::Fatal, .. }
            | HostError::Step { status: Status::Fatal, .. }
            | HostError::Fatal { .. }
    )
}

/// Errors of FMUs have a line for each line of their log.
fn in_a_line(text: &str) -> String {
    text.lines().map(str::trim).collect::<Vec<_>>().join("; ").replace('\r', " ")
}

/// Tells that a thread has ended, however it does.
struct AtEnd<'a>(&'a mpsc::Sender<Told>);

impl Drop for AtEnd<'_> {
    fn drop(&mut self) {
        let _ = self.0.send(Told::Ended);
    }
}
