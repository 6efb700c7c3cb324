//! Long work: in a thread of its own without the interpreter's lock, while this one serves signals and progress.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;
use steerwright::stages::{Failure, Observer, observed};

/// Between two looks at signals and progress.
const TICK: Duration = Duration::from_millis(50);
/// Stack of the thread, that of a main thread on Linux.
const STACK: usize = 8 << 20;

/// Does work and returns its result. Ctrl-C returns at once; the thread then ends soon and without a result. `progress` is called with the present work, and how much of how much is done.
pub(crate) fn done<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<Bound<'_, PyAny>>,
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let observer = Observer::default();
    let of_thread = observer.clone();
    let (send, mut receive) = channel();
    thread::Builder::new().name("steerwright".into()).stack_size(STACK).spawn(move || {
        let result = catch_unwind(AssertUnwindSafe(|| observed(&of_thread, work)));
        // Nobody waits any more after Ctrl-C.
        let _ = send.send(result);
    })?;
    loop {
        // A receiver may be in one thread at a time only, so it goes in and comes back.
        let received;
        (receive, received) = py.detach(move || {
            let received = receive.recv_timeout(TICK);
            (receive, received)
        });
        match received {
            Ok(Ok(result)) => return result.map_err(|failure| error(py, &failure)),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("a fault of steerwright; please report it"));
            }
            Err(RecvTimeoutError::Timeout) => {
                let shown = || {
                    py.check_signals()?;
                    match (&progress, observer.state()) {
                        (Some(progress), Some(state)) => progress.call1(state).map(drop),
                        _ => Ok(()),
                    }
                };
                shown().inspect_err(|_| observer.interrupt())?;
            }
        }
    }
}

/// `steerwright.Error` with message and hint.
pub(crate) fn error(py: Python<'_>, failure: &Failure) -> PyErr {
    raised(py, "Error", &in_python(failure.message()), &in_python(failure.hint()))
}

/// An error of the package.
pub(crate) fn raised(py: Python<'_>, class: &str, message: &str, hint: &str) -> PyErr {
    let error = py
        .import("steerwright._errors")
        .and_then(|module| module.getattr(class))
        .and_then(|class| class.call1((message, hint)));
    error.map_or_else(|error| error, PyErr::from_value)
}

/// Options of the command line as the keywords of Python: `--steering-ratio 15` is `steering_ratio=15`.
pub(crate) fn in_python(text: &str) -> String {
    let mut parts = text.split("--");
    let mut result = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.find(|c: char| !c.is_ascii_lowercase() && c != '-').unwrap_or(part.len());
        let (name, rest) = part.split_at(end);
        if name.is_empty() || result.ends_with(|c: char| c.is_alphanumeric()) {
            result.push_str("--");
            result.push_str(part);
            continue;
        }
        result.push_str(&name.replace('-', "_"));
        // A value follows: a number, or its placeholder, a word in capitals.
        let value = rest.strip_prefix(' ').filter(|value| {
            value.starts_with(|c: char| c.is_ascii_digit() || c == '"' || c == '-')
                || value.split([' ', ',', ')']).next().is_some_and(|word| {
                    word.len() > 1 && word.chars().all(|c| c.is_ascii_uppercase() || c == '=')
                })
        });
        match value {
            Some(value) => {
                result.push('=');
                result.push_str(value);
            }
            None => result.push_str(rest),
        }
    }
    result
}
