//! Messages of FMUs: the callbacks given to an instance and the lines collected from its logger.
//!
//! `fmi2CallbackLogger` is variadic in C, `(environment, instance, status, category, message, …)`
//! with a printf format as message. Stable Rust cannot define variadic functions, so [`logger`] has the
//! five fixed parameters and one more pointer for the first variadic argument. A call through the
//! variadic type reaches it intact where the ABI passes variadic pointers as it passes named ones: x86-64
//! System V (r9), Windows x64 (sixth slot on the stack), AAPCS64 on Linux and Windows on ARM64 (x5). The
//! caller cleans the stack, so a wrong number of arguments has no effect.
//!
//! The sixth parameter is [`MaybeUninit`]: it is read only if the format makes the caller pass a string
//! first. On other targets (Apple's ARM64 passes variadic arguments on the stack, 32-bit ABIs were not
//! examined), and with other conversions than one `%s`, the bare format is kept.
//!
//! The environment is only a key into a table of the living instances and is never followed, since some
//! FMUs pass another pointer in its place, such as their own component. Such a line belongs to the
//! instance of the name that it carries; where there is none, or several, it is dropped.

#![allow(unsafe_code)]

use std::collections::{HashMap, VecDeque};
use std::ffi::{CStr, c_char, c_void};
use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError, RwLock};

use crate::c_types::{CallbackFunctions, RawStatus, Status};

/// Lines an instance keeps until they are taken; the oldest are dropped, and counted.
pub const MAX_LOG_LINES: usize = 1000;
/// Bytes kept of one line.
const MAX_LINE_BYTES: usize = 4096;

/// One call of an FMU's logger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogLine {
    /// The status it was logged with.
    pub status: Status,
    /// The log category; empty where the FMU states none.
    pub category: String,
    /// The text.
    pub message: String,
}

impl std::fmt::Display for LogLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.category.is_empty() {
            write!(f, "[{}] {}", self.status, self.message)
        } else {
            write!(f, "[{}, {}] {}", self.status, self.category, self.message)
        }
    }
}

/// The lines of one instance. The FMU may log from threads of its own, hence the lock.
#[derive(Default)]
pub(crate) struct LogBuffer {
    lines: Mutex<VecDeque<LogLine>>,
    /// Lines ever logged.
    count: AtomicUsize,
}

impl LogBuffer {
    fn lock(&self) -> MutexGuard<'_, VecDeque<LogLine>> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, line: LogLine) {
        let mut lines = self.lock();
        if lines.len() == MAX_LOG_LINES {
            lines.pop_front();
        }
        lines.push_back(line);
        self.count.fetch_add(1, Ordering::Relaxed);
    }

    /// How many lines were ever logged: a mark for [`LogBuffer::since`].
    pub(crate) fn count(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }

    /// A copy of the lines logged after a mark, at most the last `limit`.
    pub(crate) fn since(&self, mark: usize, limit: usize) -> Vec<LogLine> {
        let lines = self.lock();
        let new = self.count().saturating_sub(mark).min(limit).min(lines.len());
        lines.range(lines.len() - new..).cloned().collect()
    }

    /// Takes all lines.
    pub(crate) fn drain(&self) -> Vec<LogLine> {
        self.lock().drain(..).collect()
    }
}

/// A living instance, as the logger finds it.
struct Living {
    name: String,
    log: Arc<LogBuffer>,
}

/// The living instances of this process. The key, the address of the instance's own [`LogBuffer`], is
/// unlike every pointer to other memory that an FMU may pass.
static LIVING: LazyLock<RwLock<HashMap<usize, Living>>> = LazyLock::new(RwLock::default);

/// The log of the instance that a line belongs to.
fn log_of(environment: usize, instance: &str) -> Option<Arc<LogBuffer>> {
    let living = LIVING.read().unwrap_or_else(PoisonError::into_inner);
    if let Some(own) = living.get(&environment) {
        return Some(Arc::clone(&own.log));
    }
    let mut of_name = living.values().filter(|other| other.name == instance);
    match (of_name.next(), of_name.next()) {
        (Some(only), None) => Some(Arc::clone(&only.log)),
        _ => None,
    }
}

/// The callbacks of one instance: they stay at their address for as long as it lives, since an FMU
/// may keep the pointer it was given.
pub(crate) struct Callbacks {
    functions: CallbackFunctions,
    log: Arc<LogBuffer>,
}

// SAFETY: nothing in it changes after construction; the environment is a key and never followed.
unsafe impl Send for Callbacks {}
// SAFETY: as above.
unsafe impl Sync for Callbacks {}

impl Callbacks {
    /// The callbacks of the instance of that name, living from now on.
    pub(crate) fn new(name: &str) -> Arc<Self> {
        let log = Arc::new(LogBuffer::default());
        let environment = Arc::as_ptr(&log).cast_mut().cast::<c_void>();
        let living = Living { name: name.to_owned(), log: Arc::clone(&log) };
        LIVING.write().unwrap_or_else(PoisonError::into_inner).insert(environment.addr(), living);
        Arc::new(Self {
            functions: CallbackFunctions {
                logger: Some(logger),
                allocate_memory: Some(calloc),
                free_memory: Some(free),
                // Steps are synchronous: none is ever reported as finished later.
                step_finished: None,
                component_environment: environment,
            },
            log,
        })
    }

    /// The argument of `fmi2Instantiate`.
    pub(crate) fn as_ptr(self: &Arc<Self>) -> *const CallbackFunctions {
        &raw const self.functions
    }

    pub(crate) fn log(&self) -> &LogBuffer {
        &self.log
    }
}

impl Drop for Callbacks {
    fn drop(&mut self) {
        let key = self.functions.component_environment.addr();
        LIVING.write().unwrap_or_else(PoisonError::into_inner).remove(&key);
    }
}

unsafe extern "C" {
    // The C library that Rust's own standard library is linked to: FMUs that allocate by callback
    // expect zeroed memory of malloc's alignment, to be freed without its size.
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

/// Whether the first variadic argument arrives as the sixth parameter; see the module page.
const FIRST_VARIADIC_ARRIVES: bool = cfg!(any(
    all(target_arch = "x86_64", any(unix, windows)),
    all(target_arch = "aarch64", any(target_os = "linux", windows)),
));

/// `fmi2CallbackLogger`. Never unwinds: nothing in it panics.
///
/// # Safety
/// To be called by FMUs only, with C strings or NULL, and the variadic arguments that the format
/// requires. The environment may be any pointer.
unsafe extern "C" fn logger(
    environment: *mut c_void,
    instance: *const c_char,
    status: RawStatus,
    category: *const c_char,
    message: *const c_char,
    first_variadic: MaybeUninit<*const c_char>,
) {
    // SAFETY: C strings or NULL, by the contract of the logger.
    let (instance, category, format) = unsafe { (text(instance), text(category), text(message)) };
    let Some(log) = log_of(environment.addr(), &instance) else { return };
    let message = match lone_string_conversion(&format) {
        Some((before, after)) if FIRST_VARIADIC_ARRIVES => {
            // SAFETY: the format's first and only conversion is `%s`, so by the contract of
            // printf the caller passed a string as the first variadic argument, and on this
            // target it arrives here.
            let argument = unsafe { text(first_variadic.assume_init()) };
            format!("{}{argument}{}", before.replace("%%", "%"), after.replace("%%", "%"))
        }
        Some(_) => format,
        None if !has_conversion(&format) => format.replace("%%", "%"),
        None => format,
    };
    log.push(LogLine { status: Status::from_raw(status), category, message: bounded(message) });
}

/// A C string as text; NULL is empty.
///
/// # Safety
/// `pointer` is NULL or a C string.
unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: not NULL, so a C string by this function's contract.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}

/// The text before and after the only conversion of a format, if that is a plain `%s`.
fn lone_string_conversion(format: &str) -> Option<(&str, &str)> {
    let at = first_conversion(format)?;
    let (before, rest) = format.split_at(at);
    let after = rest.strip_prefix("%s")?;
    if has_conversion(after) { None } else { Some((before, after)) }
}

fn has_conversion(format: &str) -> bool {
    first_conversion(format).is_some()
}

/// The place of the first `%` that is not part of a `%%`.
fn first_conversion(format: &str) -> Option<usize> {
    let bytes = format.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        if bytes[i] == b'%' {
            if bytes.get(i + 1) != Some(&b'%') {
                return Some(i);
            }
            i += 1;
        }
        i += 1;
    }
    None
}

fn bounded(mut message: String) -> String {
    if message.len() > MAX_LINE_BYTES {
        let mut end = MAX_LINE_BYTES;
        while !message.is_char_boundary(end) {
            end -= 1;
        }
        message.truncate(end);
        message.push('…');
    }
    // Many FMUs end their lines themselves.
    message.truncate(message.trim_end().len());
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Calls the logger as C does, through its variadic type.
    fn call(callbacks: &Arc<Callbacks>, format: &CStr, argument: Option<&CStr>) {
        let environment = callbacks.functions.component_environment;
        call_with(callbacks, environment, c"plant", format, argument);
    }

    fn call_with(
        callbacks: &Arc<Callbacks>,
        environment: *mut c_void,
        name: &CStr,
        format: &CStr,
        argument: Option<&CStr>,
    ) {
        type Variadic = unsafe extern "C" fn(
            *mut c_void,
            *const c_char,
            RawStatus,
            *const c_char,
            *const c_char,
            ...
        );
        // SAFETY: both are function pointers; the call is the one the module page reasons about.
        unsafe {
            let logger: Variadic = std::mem::transmute(callbacks.functions.logger.unwrap());
            let (name, category) = (name.as_ptr(), c"logAll".as_ptr());
            match argument {
                Some(a) => logger(environment, name, 1, category, format.as_ptr(), a.as_ptr()),
                None => logger(environment, name, 1, category, format.as_ptr()),
            }
        }
    }

    #[test]
    fn a_string_argument_is_expanded_and_other_formats_stay_bare() {
        let callbacks = Callbacks::new("plant");
        call(&callbacks, c"%s", Some(c"100 % of %d\n"));
        call(&callbacks, c"at 5 %% of [%s].", Some(c"speed"));
        call(&callbacks, c"no argument, 5 %%", None);
        call(&callbacks, c"%s and %d", Some(c"text"));
        call(&callbacks, c"%d", None);
        let lines: Vec<String> = callbacks.log().drain().into_iter().map(|l| l.message).collect();
        if FIRST_VARIADIC_ARRIVES {
            assert_eq!(lines[0], "100 % of %d");
            assert_eq!(lines[1], "at 5 % of [speed].");
        }
        assert_eq!(lines[2..], ["no argument, 5 %", "%s and %d", "%d"]);
    }

    #[test]
    fn a_foreign_environment_is_not_followed() {
        let callbacks = Callbacks::new("foreign plant");
        let twins = [Callbacks::new("foreign twin"), Callbacks::new("foreign twin")];
        let other = Box::new([0u8; 64]);
        let component = (&raw const *other).cast_mut().cast::<c_void>();
        let number = std::ptr::without_provenance_mut;
        for environment in [std::ptr::null_mut(), number(1), component, number(usize::MAX)] {
            call_with(&callbacks, environment, c"foreign plant", c"found", None);
            // Whose line this is cannot be seen.
            call_with(&callbacks, environment, c"foreign twin", c"lost", None);
            call_with(&callbacks, environment, c"foreign to all", c"lost", None);
        }
        assert_eq!(callbacks.log().drain().len(), 4);
        assert!(twins.iter().all(|twin| twin.log().drain().is_empty()));
        let own = twins[0].functions.component_environment;
        call_with(&callbacks, own, c"any name", c"mine", None);
        assert_eq!(twins[0].log().drain().len(), 1);
    }

    #[test]
    fn the_log_is_bounded_and_keeps_the_latest() {
        let callbacks = Callbacks::new("plant");
        for i in 0..MAX_LOG_LINES + 5 {
            let line = std::ffi::CString::new(format!("line {i}")).unwrap();
            call(&callbacks, c"%s", Some(&line));
        }
        let long = std::ffi::CString::new("ä".repeat(MAX_LINE_BYTES)).unwrap();
        call(&callbacks, c"%s", Some(&long));
        let last = callbacks.log().since(MAX_LOG_LINES + 4, 10);
        assert_eq!(last.len(), 2);
        assert_eq!(last[0].message, format!("line {}", MAX_LOG_LINES + 4));
        assert!(last[1].message.len() < MAX_LINE_BYTES + 8);
        assert_eq!(callbacks.log().drain().len(), MAX_LOG_LINES);
        assert!(callbacks.log().drain().is_empty());
    }
}
