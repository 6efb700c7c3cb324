//! Panics never cross the C boundary and print nothing to the host's stderr.
//!
//! Nothing here has a destructor that runs at the end of a thread, and nothing is leaked: either
//! would keep the library or its memory loaded after the host has unloaded the FMU.

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

/// Installs, once, a panic hook that is silent inside [`contain`] and calls the previous hook elsewhere.
///
/// In a cdylib the hook belongs to the library's own copy of the standard library; a program that
/// links this crate still reports its other panics.
pub(crate) fn silence_hook() {
    if std::thread::panicking() {
        // Called from a destructor during unwinding: hooks cannot be changed now. The next call does it.
        return;
    }
    INSTALLED.call_once(|| {
        let _ = PREVIOUS.set(take_hook());
        // The closure captures nothing, so the box allocates no memory.
        set_hook(Box::new(|info| {
            if !INSIDE.get()
                && let Some(previous) = PREVIOUS.get()
            {
                previous(info);
            }
        }));
    });
}

/// Runs `f` and catches a panic.
///
/// # Errors
/// The message of the panic.
#[inline]
pub(crate) fn contain<R>(f: impl FnOnce() -> R) -> Result<R, String> {
    // One access to thread-local storage, since each is a function call in a shared library.
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

/// A unit whose panicking destructor cannot abort the process.
///
/// A panic of a destructor while another panic unwinds aborts the process. This wrapper catches the
/// panic of the unit's destructor. It cannot help if two fields of one unit both panic when they are
/// dropped, since both belong to one destructor.
#[derive(Debug)]
pub(crate) struct Contained<T>(ManuallyDrop<T>);

impl<T> Contained<T> {
    pub(crate) fn new(value: T) -> Self {
        Self(ManuallyDrop::new(value))
    }

    /// Drops the value; a panic of its destructor propagates.
    pub(crate) fn release(mut self) {
        // SAFETY: the value is not used again: `forget` prevents `Drop` from dropping it a second time.
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
