//! The importer's logger: categories, filter, and the one call of a C function pointer.

use crate::types::{CallbackFunctions, LoggerFunction, Status};
use std::ffi::{CStr, CString, c_void};

/// The categories of messages, as declared in the XML: name and description. The first five are
/// those that messages carry; `logAll` selects them all.
pub const LOG_CATEGORIES: [(&str, &str); 6] = [
    ("logStatusError", "Calls that failed"),
    ("logStatusWarning", "Things that are not quite right"),
    ("logStatusDiscard", "Questions that have no answer"),
    ("logStatusFatal", "Faults of the model that end the instance"),
    ("logEvents", "Notes of the model, and calls accepted though outside the standard"),
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
/// What is told without debug logging: the standard has each of these statuses come with a message.
const QUIET: u8 = Category::Error.bit() | Category::Warning.bit() | Category::Fatal.bit();

/// The categories a name selects; 0 if there is none of that name.
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
    /// What was enabled at instantiation.
    initially: u8,
}

impl Logger {
    /// A logger over a copy of the importer's callbacks, which may live on its stack.
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
            initially: enabled,
        }
    }

    /// Back to what was enabled at instantiation.
    pub(crate) fn reset(&mut self) {
        self.enabled = self.initially;
    }

    /// `fmi2SetDebugLogging`: without categories all or, off, only what is always told; on with
    /// categories just these; off with categories all but these. Returns the names there are none
    /// of.
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

    /// Whether messages of that category are passed on.
    pub(crate) fn is_enabled(&self, category: Category) -> bool {
        self.function.is_some() && self.enabled & category.bit() != 0
    }

    /// Passes a message on if its category is enabled.
    #[cold]
    pub(crate) fn tell(&self, category: Category, text: &str) {
        if !self.is_enabled(category) {
            return;
        }
        let Some(function) = self.function else { return };
        let clean: Vec<u8> = text.bytes().filter(|byte| *byte != 0).collect();
        let Ok(text) = CString::new(clean) else { return };
        // SAFETY: the importer gave this function for this purpose, with this environment; every
        // pointer is a string that ends in zero and outlives the call. The format takes one string.
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
