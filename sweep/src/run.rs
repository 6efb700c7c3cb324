//! The runs of a study on some threads, their rows in order.
//!
//! Each thread has instances and buffers of its own and takes the next free run; rows
//! wait until those before them are written. A run that an FMU refuses is a row with its error.
//! After `fmi2Fatal` nothing of that FMU may be called any more in this process: the sweep ends
//! there, and can be resumed in another process.

use crate::Error;
use crate::isolate::Worker;
use crate::make::{Made, Options};
use crate::metric::Outcome;
use crate::prepare::Sweep;
use crate::results::Results;
use crate::rig::Rig;
use crate::summary::Summary;
use crate::watch::Watch;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

/// What a call did.
#[derive(Debug)]
#[allow(missing_docs)]
pub struct Finished {
    /// Rows that were there before.
    pub resumed: usize,
    pub rows: usize,
    pub threads: usize,
    /// The FMU that ended fatally, if that is why not all runs were made.
    pub fatal: Option<String>,
    pub summary: Summary,
}

enum Message {
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
        let runs = options.runs.clone().unwrap_or(0..self.runs());
        let (mut results, mut outcomes) = if options.resume {
            Results::resume(self, &runs, options.results)?
        } else {
            (Results::create(self, options.results, options.overwrite)?, Vec::new())
        };
        let resumed = outcomes.len();
        (options.progress)(resumed);
        let threads = self.threads(options, runs.len() - resumed);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Error::Threads { reason: e.to_string() })?;
        let next = AtomicUsize::new(runs.start + resumed);
        let ending = AtomicBool::new(false);
        let watch = Watch::new(options.timeout, threads);
        let (sender, receiver) = mpsc::channel();
        let mut fatal = None;
        let written = pool.in_place_scope(|scope| {
            scope.spawn_broadcast(|_, context| {
                // Sent also where a panic ends the thread.
                let _end = AtEnd(&sender);
                self.work(options, runs.end, &next, &ending, &sender, (&watch, context.index()));
            });
            let mut waiting = BTreeMap::new();
            let mut running = threads;
            let mut result = Ok(());
            let mut stopped = None;
            while running > 0 {
                if options.stop.load(Ordering::Relaxed) {
                    stopped = stopped.or_else(|| Some(Instant::now()));
                }
                let message = match receiver.recv_timeout(watch.look()) {
                    Ok(message) => message,
                    Err(mpsc::RecvTimeoutError::Disconnected) => break,
                    Err(mpsc::RecvTimeoutError::Timeout) => {
                        if let Some(run) = watch.hung(stopped) {
                            ending.store(true, Ordering::Relaxed);
                            (options.hung)(run, outcomes.len());
                        }
                        continue;
                    }
                };
                match message {
                    Message::Ended => running -= 1,
                    Message::Fatal(text) => fatal = fatal.take().or(Some(text)),
                    Message::Io(error) => result = result.and(Err(error)),
                    Message::Row(run, outcome, bytes) => {
                        waiting.insert(run, (outcome, bytes));
                    }
                }
                while let Some((outcome, bytes)) = waiting.remove(&(runs.start + outcomes.len())) {
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
        results.finish()?;
        self.earlier_trajectories(options, runs.start..runs.start + resumed)?;
        let summary = Summary::new(self, runs.start, &outcomes);
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
        end: usize,
        next: &AtomicUsize,
        ending: &AtomicBool,
        sender: &mpsc::Sender<Message>,
        (watch, thread): (&Watch, usize),
    ) {
        let mut maker = Maker::new(self, options);
        let ending_now = || options.stop.load(Ordering::Relaxed) || ending.load(Ordering::Relaxed);
        while !ending_now() {
            let run = next.fetch_add(1, Ordering::Relaxed);
            if run >= end {
                break;
            }
            let made = maker.make(self, options, run, Some((watch, thread)));
            watch.end(thread);
            let made = match made {
                Ok(made) => made,
                Err(error) => {
                    // Whoever does not listen any more does not miss it.
                    let _ = sender.send(Message::Io(error));
                    break;
                }
            };
            if let Some(text) = made.fatal {
                ending.store(true, Ordering::Relaxed);
                let _ = sender.send(Message::Fatal(text));
            }
            let Some((outcome, bytes)) = made.row else { break };
            let _ = sender.send(Message::Row(run, outcome, bytes));
        }
    }

    /// Trajectories of runs that an earlier call made; their rows have what they ended with.
    fn earlier_trajectories(
        &self,
        options: &Options<'_>,
        resumed: Range<usize>,
    ) -> Result<(), Error> {
        let Some((_, runs)) = &options.trajectories else { return Ok(()) };
        let mut maker = Maker::new(self, options);
        for &run in runs.iter().filter(|run| resumed.contains(run)) {
            maker.make(self, options, run, None)?;
        }
        Ok(())
    }
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

/// Sends that a thread has ended, however it does.
struct AtEnd<'a>(&'a mpsc::Sender<Message>);

impl Drop for AtEnd<'_> {
    fn drop(&mut self) {
        let _ = self.0.send(Message::Ended);
    }
}
