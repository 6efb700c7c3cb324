//! The importer's logger: categories, filter, and the call of its C function.

use crate::types::{CallbackFunctions, LoggerFunction, Status};
use std::ffi::{CStr, CString, c_void};

/// The log categories declared in the XML: name and description. Messages have one of the first
/// five; `logAll` selects them all.
pub const LOG_CATEGORIES: [(&str, &str); 6] = [
    ("logStatusError", "Failed calls"),
    ("logStatusWarning", "Warnings"),
    ("logStatusDiscard", "Requested statuses that do not exist"),
    ("logStatusFatal", "Panics of the model; the instance is unusable"),
    ("logEvents", "Information from the model, and accepted deviations from the standard"),
    ("logAll", "All messages"),
];

/// The category of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Category {
    Error,
    Warning,
    Discard,
    Fatal,
    Event,
}

impl Category {
    const fn bit(self) -> u8 {
        1 << self as u8
    }

    const fn status(self) -> Status {
        match self {
            Self::Error => Status::Error,
            Self::Warning => Status::Warning,
            Self::Discard => Status::Discard,
            Self::Fatal => Status::Fatal,
            Self::Event => Status::Ok,
        }
    }

    const fn name(self) -> &'static CStr {
        match self {
            Self::Error => c"logStatusError",
            Self::Warning => c"logStatusWarning",
            Self::Discard => c"logStatusDiscard",
            Self::Fatal => c"logStatusFatal",
            Self::Event => c"logEvents",
        }
    }
}

/// Every category.
const ALL: u8 = 0b1_1111;
/// Categories enabled without debug logging, since the standard requires their messages.
const QUIET: u8 = Category::Error.bit() | Category::Warning.bit() | Category::Fatal.bit();

/// The categories that a name selects; 0 for an unknown name.
fn selected(name: &[u8]) -> u8 {
    match LOG_CATEGORIES.iter().position(|(known, _)| known.as_bytes() == name) {
        Some(5) => ALL,
        Some(index) => 1 << index,
        None => 0,
    }
}

/// Passes messages to the importer.
#[derive(Debug, Clone)]
pub(crate) struct Logger {
    function: Option<LoggerFunction>,
    environment: *mut c_void,
    instance_name: CString,
    enabled: u8,
    /// The categories enabled at instantiation.
    initially_enabled: u8,
}

impl Logger {
    /// A logger with a copy of the importer's callbacks, which may be on the importer's stack.
    pub(crate) fn new(
        callbacks: Option<&CallbackFunctions>,
        instance_name: &CStr,
        logging_on: bool,
    ) -> Self {
        let enabled = if logging_on { ALL } else { QUIET };
        Self {
            function: callbacks.and_then(|callbacks| callbacks.logger),
            environment: callbacks.map_or(std::ptr::null_mut(), |c| c.component_environment),
            instance_name: instance_name.to_owned(),
            enabled,
            initially_enabled: enabled,
        }
    }

    /// Enables the categories that were enabled at instantiation.
    pub(crate) fn reset(&mut self) {
        self.enabled = self.initially_enabled;
    }

    /// `fmi2SetDebugLogging`. Without categories, on enables all and off only [`QUIET`]; with
    /// categories, on enables exactly these and off disables these. Returns the unknown names.
    pub(crate) fn set_enabled(&mut self, logging_on: bool, categories: &[&CStr]) -> Vec<String> {
        let mut chosen = 0;
        let mut unknown = Vec::new();
        for category in categories {
            match selected(category.to_bytes()) {
                0 => unknown.push(category.to_string_lossy().into_owned()),
                bits => chosen |= bits,
            }
        }
        self.enabled = match (logging_on, categories.is_empty()) {
            (true, true) => ALL,
            (false, true) => QUIET,
            (true, false) => chosen,
            (false, false) => self.enabled & !chosen,
        };
        unknown
    }

    /// Whether messages of a category are passed to the importer.
    pub(crate) fn is_enabled(&self, category: Category) -> bool {
        self.function.is_some() && self.enabled & category.bit() != 0
    }

    /// Passes a message to the importer if its category is enabled.
    #[cold]
    pub(crate) fn log(&self, category: Category, text: &str) {
        if !self.is_enabled(category) {
            return;
        }
        let Some(function) = self.function else { return };
        let clean: Vec<u8> = text.bytes().filter(|byte| *byte != 0).collect();
        let Ok(text) = CString::new(clean) else { return };
        // SAFETY: the importer passed this function for this purpose, with this environment; every
        // pointer is a NUL-terminated string that outlives the call. The format takes one string.
        unsafe {
            function(
                self.environment,
                self.instance_name.as_ptr(),
                category.status() as i32,
                category.name().as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}
