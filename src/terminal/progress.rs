//! Progress on stderr, wherever something works for longer than two seconds.
//!
//! A terminal shows one line that moves; elsewhere a line is printed now and then: after 2, 4, 8 …
//! seconds and then each minute, with `--json` as JSON.

use crate::terminal::console;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::RefCell;
use std::io::{IsTerminal, Read};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use steerwright_drivelog::ReadAt;
use steerwright_formats::interruption::{self, Interruption};

/// Shorter work is not reported.
const SILENT: Duration = Duration::from_secs(2);
/// Lines follow each other at most this far apart.
const SELDOM: Duration = Duration::from_secs(60);
const TICK: Duration = Duration::from_millis(100);

/// The interval of progress, where one is requested.
static INTERVAL: OnceLock<Duration> = OnceLock::new();

/// Reports progress at this interval, s.
pub(crate) fn set_interval(seconds: Option<f64>) {
    let interval = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    if let Some(interval) = interval.filter(|interval| !interval.is_zero()) {
        // The first one holds: there is one command in a process.
        let _ = INTERVAL.set(interval);
    }
}

/// Work that is going on; it ends with this value.
#[derive(Debug)]
pub(crate) struct Progress {
    shared: Arc<Shared>,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// What is being done in a thread, for whoever shows it in place of the lines on stderr, or interrupts it.
#[derive(Debug, Clone)]
pub struct Observer {
    shared: Arc<Mutex<Option<Arc<Shared>>>>,
    interruption: Interruption,
}

impl Default for Observer {
    fn default() -> Self {
        Self { shared: Arc::default(), interruption: Interruption::new() }
    }
}

impl Observer {
    /// The present work, and how much of how much is done, 0 of 0 if that is unknown; `None` between works.
    #[must_use]
    pub fn state(&self) -> Option<(String, u64, u64)> {
        let shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner).clone()?;
        let what = shared.what.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let [done, all] = [&shared.done, &shared.all].map(|n| n.load(Ordering::Relaxed));
        Some((what, done, all))
    }

    /// Ends the work soon, where it waits for no file; it has no result then.
    pub fn interrupt(&self) {
        self.interruption.set();
    }
}

thread_local! {
    /// The observer of this thread's work.
    static OBSERVER: RefCell<Option<Observer>> = const { RefCell::new(None) };
}

/// Does work whose progress is observed instead of printed.
pub(crate) fn observed<T>(observer: &Observer, work: impl FnOnce() -> T) -> T {
    OBSERVER.set(Some(observer.clone()));
    let done = observer.interruption.during(work);
    OBSERVER.set(None);
    done
}

#[derive(Debug, Default)]
struct Shared {
    what: Mutex<String>,
    done: AtomicU64,
    /// 0 if unknown.
    all: AtomicU64,
    /// When the count began, and what was done then.
    from: Mutex<Option<(Instant, u64)>>,
}

impl Shared {
    /// The count begins here, unless it has begun.
    fn begin(&self, done: u64) {
        let mut from = self.from.lock().unwrap_or_else(PoisonError::into_inner);
        from.get_or_insert_with(|| (Instant::now(), done));
    }

    /// The present work, and the time for the rest at the present rate.
    fn in_words(&self) -> String {
        let what = self.what.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match (self.done.load(Ordering::Relaxed), self.all.load(Ordering::Relaxed)) {
            (_, 0) => what,
            (done, all) => {
                let percent = 100.0 * (done as f64 / all as f64).min(1.0);
                let from = *self.from.lock().unwrap_or_else(PoisonError::into_inner);
                let left = from.filter(|(_, first)| done > *first).map(|(since, first)| {
                    let each = since.elapsed().as_secs_f64() / (done - first) as f64;
                    format!(", {:.0} s left", each * all.saturating_sub(done) as f64)
                });
                format!("{what}, {percent:.0} %{}", left.unwrap_or_default())
            }
        }
    }
}

impl Progress {
    /// Starts work, such as "reading drive.csv".
    pub(crate) fn start(what: impl Into<String>) -> Self {
        let shared = Arc::new(Shared { what: Mutex::new(what.into()), ..Shared::default() });
        if let Some(observer) = OBSERVER.with_borrow(Clone::clone) {
            let mut current = observer.shared.lock().unwrap_or_else(PoisonError::into_inner);
            *current = Some(Arc::clone(&shared));
            return Self { shared, stop: None, thread: None };
        }
        let (stop, stopped) = mpsc::channel();
        let show = Arc::clone(&shared);
        let thread = std::thread::spawn(move || {
            let began = Instant::now();
            let requested = INTERVAL.get().copied();
            if stopped.recv_timeout(requested.unwrap_or(SILENT)) != Err(RecvTimeoutError::Timeout) {
                return;
            }
            if requested.is_none() && std::io::stderr().is_terminal() {
                let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
                let style = ProgressStyle::with_template("{spinner} {msg}, {elapsed}");
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
                let bar = bar.with_elapsed(began.elapsed());
                while stopped.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                    bar.set_message(show.in_words());
                    bar.tick();
                }
                bar.finish_and_clear();
                return;
            }
            let mut pause = requested.unwrap_or(SILENT);
            loop {
                let share = [&show.done, &show.all].map(|n| n.load(Ordering::Relaxed));
                console::progress(&show.in_words(), share, began.elapsed());
                if stopped.recv_timeout(pause) != Err(RecvTimeoutError::Timeout) {
                    return;
                }
                if requested.is_none() {
                    pause = (2 * pause).min(SELDOM);
                }
            }
        });
        Self { shared, stop: Some(stop), thread: Some(thread) }
    }

    /// States the present work.
    pub(crate) fn now(&self, what: impl Into<String>) {
        interruption::check();
        *self.shared.what.lock().unwrap_or_else(PoisonError::into_inner) = what.into();
        self.shared.all.store(0, Ordering::Relaxed);
        self.shared.done.store(0, Ordering::Relaxed);
        *self.shared.from.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// States the share that is done.
    pub(crate) fn count(&self, done: usize, all: usize) {
        self.shared.begin(done as u64);
        self.shared.all.store(all as u64, Ordering::Relaxed);
        self.shared.done.store(done as u64, Ordering::Relaxed);
    }

    /// A reader whose bytes count as progress; `bytes` is what there is to read, if that is known.
    pub(crate) fn reading<R>(&self, reader: R, bytes: u64) -> ReadingProgress<R> {
        self.shared.begin(self.shared.done.load(Ordering::Relaxed));
        self.shared.all.fetch_add(bytes, Ordering::Relaxed);
        ReadingProgress { reader, shared: Arc::clone(&self.shared) }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        // The line is gone before anything else is printed.
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[derive(Debug)]
pub(crate) struct ReadingProgress<R> {
    reader: R,
    shared: Arc<Shared>,
}

impl<R: ReadAt> ReadAt for ReadingProgress<R> {
    fn size(&self) -> std::io::Result<u64> {
        self.reader.size()
    }

    fn read_at(&self, buffer: &mut [u8], offset: u64) -> std::io::Result<usize> {
        interruption::check();
        let count = self.reader.read_at(buffer, offset)?;
        self.shared.done.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

impl<R: Read> Read for ReadingProgress<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        interruption::check();
        let count = self.reader.read(buffer)?;
        self.shared.done.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}
