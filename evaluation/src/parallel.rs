//! Independent pieces of work on all cores, with progress on stderr.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Time between two reports of progress.
const REPORT_EVERY: Duration = Duration::from_secs(2);

/// `work(0)` … `work(count − 1)`, in this order; `what` is named in the progress.
pub fn on_all_cores<T: Send>(what: &str, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let (send, receive) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..cores.min(count) {
            let (send, next, work) = (send.clone(), &next, &work);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count || send.send((index, work(index))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut progress = Progress::new(what, count);
        let mut all: Vec<Option<T>> = (0..count).map(|_| None).collect();
        for (index, done) in receive {
            all[index] = Some(done);
            progress.step();
        }
        all.into_iter().flatten().collect()
    })
}

/// A count on stderr: a line that is written over on a terminal, lines elsewhere.
struct Progress<'a> {
    what: &'a str,
    done: usize,
    count: usize,
    begun: Instant,
    reported: Instant,
    is_terminal: bool,
}

impl<'a> Progress<'a> {
    fn new(what: &'a str, count: usize) -> Self {
        let now = Instant::now();
        let is_terminal = std::io::stderr().is_terminal();
        Self { what, done: 0, count, begun: now, reported: now, is_terminal }
    }

    fn step(&mut self) {
        self.done += 1;
        let is_last = self.done == self.count;
        if !is_last && self.reported.elapsed() < REPORT_EVERY {
            return;
        }
        self.reported = Instant::now();
        let seconds = self.begun.elapsed().as_secs_f64();
        let text = format!("{}: {} of {} in {seconds:.0} s", self.what, self.done, self.count);
        let mut stderr = std::io::stderr().lock();
        // Progress that no one reads stops nothing.
        let _ = match (self.is_terminal, is_last) {
            (true, false) => write!(stderr, "\r{text}"),
            (true, true) => writeln!(stderr, "\r{text}"),
            (false, _) => writeln!(stderr, "{text}"),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_whatever_the_threads() {
        let squares = on_all_cores("squares", 100, |k| k * k);
        assert_eq!(squares, (0..100).map(|k| k * k).collect::<Vec<_>>());
        assert!(on_all_cores("nothing", 0, |k| k).is_empty());
    }
}
