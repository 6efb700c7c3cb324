//! The end of a computation whose result nobody waits for any more.
//!
//! Long loops call [`check`], which unwinds out of the computation once it is interrupted. That costs a look at a
//! flag; where no interruption is possible, as in the command line, there is none.

use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    /// That of this thread's computation.
    static CURRENT: RefCell<Interruption> = const { RefCell::new(Interruption(None)) };
}

/// A flag that all threads of a computation share.
#[derive(Debug, Clone, Default)]
pub struct Interruption(Option<Arc<AtomicBool>>);

impl Interruption {
    /// That of a new computation.
    #[must_use]
    pub fn new() -> Self {
        Self(Some(Arc::default()))
    }

    /// That of this thread's computation, for another thread of it.
    #[must_use]
    pub fn current() -> Self {
        CURRENT.with_borrow(Clone::clone)
    }

    /// Ends the computation at the next [`check`] of each of its threads.
    pub fn set(&self) {
        if let Some(flag) = &self.0 {
            flag.store(true, Ordering::Relaxed);
        }
    }

    /// Whether it is set.
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Computes in this thread, until it is set.
    pub fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        CURRENT.set(self.clone());
        let done = work();
        CURRENT.set(Self(None));
        done
    }
}

/// Unwinds, without the message of a panic, where this thread's computation is interrupted.
pub fn check() {
    if CURRENT.with_borrow(Interruption::is_set) {
        resume_unwind(Box::new("interrupted"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::catch_unwind;

    #[test]
    fn a_computation_ends_in_all_of_its_threads_and_no_other_one() {
        let interruption = Interruption::new();
        let ended = interruption.during(|| {
            check();
            interruption.set();
            let current = Interruption::current();
            let other = std::thread::spawn(move || current.during(check));
            (other.join().is_err(), catch_unwind(check).is_err())
        });
        assert_eq!(ended, (true, true));
        check();
    }
}
