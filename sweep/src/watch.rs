//! The present run of each thread, and its duration: runs beyond the time limit are reported, or ended.
//!
//! A run looks at the clock between its steps and ends itself ([`crate::rig`]). A call of an FMU that
//! never returns cannot be ended in the same process: it is reported, once, to the sweep's caller.
//! In a process of its own ([`crate::isolate`]) it ends with the process, and is a row as others.

use std::process::Child;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How many times as long as it may take a run is waited for, before what it calls is taken for hung.
const HUNG_AFTER: u32 = 2;

/// The longest between two looks.
const LONGEST_LOOK: Duration = Duration::from_secs(1);

/// The run that a thread makes.
#[derive(Debug, Default)]
struct Busy {
    run: usize,
    since: Option<Instant>,
    /// The process that does it, if it is another.
    child: Option<Arc<Mutex<Child>>>,
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

    /// Records that a thread begins a run, here or in a child.
    pub(crate) fn begin(&self, thread: usize, run: usize, child: Option<Arc<Mutex<Child>>>) {
        if let Some(busy) = self.threads.get(thread) {
            *held(busy) = Busy { run, since: Some(Instant::now()), child };
        }
    }

    pub(crate) fn end(&self, thread: usize) {
        if let Some(busy) = self.threads.get(thread) {
            *held(busy) = Busy::default();
        }
    }

    /// Ends processes that take too long, and returns a run that hangs in this one.
    pub(crate) fn hung(&self) -> Option<usize> {
        let longest = self.limit? * HUNG_AFTER;
        let late = |busy: &Busy| busy.since.is_some_and(|since| since.elapsed() > longest);
        let mut hung = None;
        for thread in &self.threads {
            let busy = held(thread);
            match &busy.child {
                _ if !late(&busy) => {}
                Some(child) => {
                    // Whoever waits for its answer sees its end; one that is gone is no error.
                    let _ = held(child).kill();
                }
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
