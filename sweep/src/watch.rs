//! The present run of each thread, and its duration: runs beyond the time limit are reported, or ended.
//!
//! A run looks at the clock between its steps and ends itself ([`crate::rig`]). A call of an FMU that
//! never returns cannot be ended in the same process: it is reported, once, to the sweep's caller.
//! In a process of its own ([`crate::isolate`]) it ends with the process, and is a row as others.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use steerwright_host::process::Subprocess;

/// How many times as long as it may take a run is waited for, before what it calls is taken for hung.
const HUNG_AFTER: u32 = 2;

/// How long a run is waited for that is to stop at its next step.
const STOPPED_AFTER: Duration = Duration::from_secs(1);

/// The longest between two looks.
const LONGEST_LOOK: Duration = Duration::from_millis(100);

/// The run that a thread makes.
#[derive(Debug, Default)]
struct Busy {
    run: usize,
    since: Option<Instant>,
    /// The process that does it, if it is another.
    process: Option<Arc<Mutex<Subprocess>>>,
}

#[derive(Debug)]
pub(crate) struct Watch {
    limit: Option<Duration>,
    threads: Vec<Mutex<Busy>>,
}

impl Watch {
    pub(crate) fn new(limit: Option<Duration>, threads: usize) -> Self {
        Self { limit, threads: (0..threads).map(|_| Mutex::default()).collect() }
    }

    /// How long to wait until the next look.
    pub(crate) fn look(&self) -> Duration {
        self.limit.map_or(LONGEST_LOOK, |limit| (limit / 2).min(LONGEST_LOOK))
    }

    /// Records that a thread begins a run, here or in another process.
    pub(crate) fn begin(&self, thread: usize, run: usize, process: Option<Arc<Mutex<Subprocess>>>) {
        if let Some(busy) = self.threads.get(thread) {
            *held(busy) = Busy { run, since: Some(Instant::now()), process };
        }
    }

    pub(crate) fn end(&self, thread: usize) {
        if let Some(busy) = self.threads.get(thread) {
            *held(busy) = Busy::default();
        }
    }

    /// Ends processes that take too long, and returns a run that hangs in this one. After a stop a process ends at
    /// once, since its run has no row, and a run in this one soon.
    pub(crate) fn hung(&self, stopped: Option<Instant>) -> Option<usize> {
        let longest = self.limit.map_or(Duration::MAX, |limit| limit * HUNG_AFTER);
        let late = |busy: &Busy| {
            let too_long = busy.since.is_some_and(|since| since.elapsed() > longest);
            let wait = if busy.process.is_some() { Duration::ZERO } else { STOPPED_AFTER };
            too_long || busy.since.is_some() && stopped.is_some_and(|s| s.elapsed() >= wait)
        };
        let mut hung = None;
        for thread in &self.threads {
            let busy = held(thread);
            match &busy.process {
                _ if !late(&busy) => {}
                // Whoever waits for its answer sees its end.
                Some(process) => held(process).kill(),
                None => hung = hung.or(Some(busy.run)),
            }
        }
        hung
    }
}

/// What a thread left that panicked is still good to look at.
pub(crate) fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
