//! Work on several threads with results that do not depend on their number.

use crate::Error;
use std::sync::atomic::{AtomicUsize, Ordering};
use steerwright_formats::interruption::{self, Interruption};

pub(crate) fn each<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Result<Vec<R>, Error> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(items.len());
    if threads < 2 {
        return Ok(items.iter().map(work).collect());
    }
    let next = AtomicUsize::new(0);
    let part = || -> Vec<_> {
        let taken = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < items.len());
        std::iter::from_fn(|| {
            taken().map(|i| {
                interruption::check();
                (i, work(&items[i]))
            })
        })
        .collect()
    };
    let interruption = Interruption::current();
    let parts = std::thread::scope(|scope| {
        let part = || interruption.during(part);
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(part)).collect();
        let parts = running.into_iter().map(|thread| thread.join().map_err(|_| ended_early()));
        parts.collect::<Result<Vec<_>, Error>>()
    })?;
    let mut all: Vec<_> = parts.into_iter().flatten().collect();
    all.sort_by_key(|(i, _)| *i);
    Ok(all.into_iter().map(|(_, result)| result).collect())
}

/// The results of two functions that run at the same time.
pub(crate) fn both<A: Send, B>(
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B,
) -> Result<(A, B), Error> {
    let interruption = Interruption::current();
    std::thread::scope(|scope| {
        let one = scope.spawn(move || interruption.during(one));
        let other = other();
        one.join().map(|one| (one, other)).map_err(|_| ended_early())
    })
}

fn ended_early() -> Error {
    Error::Optimiser("a thread of the search ended early".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_the_order_of_the_items() {
        let items: Vec<u64> = (0..200).collect();
        let slow_first = |i: &u64| {
            std::thread::sleep(std::time::Duration::from_micros(200 - i));
            i * i
        };
        let expected: Vec<u64> = items.iter().map(|i| i * i).collect();
        assert_eq!(each(&items, slow_first).unwrap(), expected);
        assert_eq!(both(|| 1, || 2).unwrap(), (1, 2));
    }
}
