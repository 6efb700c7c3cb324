//! A panic never crosses the C boundary, and tells nothing on the host's stderr.
//!
//! Nothing here has a destructor that runs when a thread ends, and nothing is allocated for good:
//! either would keep the library, or its memory, after the host has unloaded it.

use std::cell::Cell;
use std::mem::ManuallyDrop;
use std::ops::{Deref, DerefMut};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::{Once, OnceLock};

thread_local! {
    /// Whether this thread is inside a call of the layer.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

static PREVIOUS: OnceLock<Hook> = OnceLock::new();
static INSTALLED: Once = Once::new();

/// Installs, once, a panic hook that is silent inside [`contain`] and the previous one elsewhere.
///
/// In a cdylib the hook belongs to the library's own copy of the standard library; in a program
/// that links this crate, other people's panics go on to be reported.
pub(crate) fn silence_hook() {
    if std::thread::panicking() {
        // A host of ours in a destructor; hooks cannot be changed now, and the next call will.
        return;
    }
    INSTALLED.call_once(|| {
        let _ = PREVIOUS.set(take_hook());
        // It captures nothing, so that the box holds no memory.
        set_hook(Box::new(|info| {
            if !INSIDE.get()
                && let Some(previous) = PREVIOUS.get()
            {
                previous(info);
            }
        }));
    });
}

/// Runs `f`; a panic in it becomes its message.
#[inline]
pub(crate) fn contain<R>(f: impl FnOnce() -> R) -> Result<R, String> {
    // One access to the thread's storage, which costs a call in a shared library.
    let result = INSIDE.with(|inside| {
        let outer = inside.replace(true);
        let result = catch_unwind(AssertUnwindSafe(f));
        inside.set(outer);
        result
    });
    match result {
        Ok(value) => Ok(value),
        Err(payload) => Err(message(payload)),
    }
}

#[cold]
fn message(payload: Box<dyn std::any::Any + Send>) -> String {
    if let Some(text) = payload.downcast_ref::<&str>() {
        return (*text).to_owned();
    }
    match payload.downcast::<String>() {
        Ok(text) => *text,
        Err(other) => {
            // Its destructor could panic again.
            std::mem::forget(other);
            "no message".into()
        }
    }
}

/// A value of the slave's whose destructor cannot do harm.
///
/// Two values that panic when they are dropped, one during the unwinding of the other, would end
/// the process. In here a panic goes no further than the one destructor. (Two members of one slave
/// that both panic are beyond any help: that is one destructor to Rust.)
#[derive(Debug)]
pub(crate) struct Contained<T>(ManuallyDrop<T>);

impl<T> Contained<T> {
    pub(crate) fn new(value: T) -> Self {
        Self(ManuallyDrop::new(value))
    }

    /// Drops the value so that a panic shows.
    pub(crate) fn release(mut self) {
        // SAFETY: the value is not used again: it is dropped here and not by `Drop`, which the
        // next line keeps from running, panic or not.
        let value = unsafe { ManuallyDrop::take(&mut self.0) };
        std::mem::forget(self);
        drop(value);
    }
}

impl<T> Drop for Contained<T> {
    fn drop(&mut self) {
        // SAFETY: dropped once, here; nothing uses it afterwards.
        let _ = contain(|| unsafe { ManuallyDrop::drop(&mut self.0) });
    }
}

impl<T: Clone> Clone for Contained<T> {
    fn clone(&self) -> Self {
        Self::new(T::clone(self))
    }
}

impl<T> Deref for Contained<T> {
    type Target = T;

    #[inline]
    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> DerefMut for Contained<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}
