//! One instance of an FMU, from instantiation to its end.
//!
//! An [`Instance`] makes only the calls that table 4.2.4 of FMI 2.0.5 allows at the time, and
//! turns every status but ok and warning into an [`Error`] with the lines that the FMU logged
//! during the call. It may be moved between threads and is used by one at a time (`Send`, not
//! `Sync`), as FMI requires of importers.
//!
//! After `fmi2Fatal` no function of the FMU is called any more, by any of its instances, not even
//! `fmi2FreeInstance` (FMI 2.0.5, 2.1.3): what the instance held is leaked, and the library stays
//! loaded until the process ends.

#![allow(unsafe_code)]

mod derivatives;
mod named;
mod phase;
mod states;
mod values;

use std::ffi::CString;
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::Ordering;

pub(crate) use named::why_not_settable;
pub use phase::Phase;
pub use states::FmuState;

use crate::Error;
use crate::archive::{Archive, Extracted};
use crate::c_types::{self, RawStatus, Status};
use crate::library::{Functions, Library};
use crate::log::{Callbacks, LogLine};
use crate::model::Model;

/// Lines of the FMU's log that an error carries at most.
const LINES_IN_ERRORS: usize = 10;

/// An instance of an FMU for co-simulation.
pub struct Instance {
    name: String,
    component: NonNull<std::ffi::c_void>,
    phase: Phase,
    model: Arc<Model>,
    states: states::Saved,
    /// For `fmi2Boolean`s on their way in and out.
    booleans: Vec<c_types::Boolean>,
    // Dropped in this order, after `Drop::drop` has freed the component: the callbacks outlive it,
    // and on Windows a loaded file cannot be deleted.
    library: Arc<Library>,
    callbacks: Arc<Callbacks>,
    _files: Arc<Extracted>,
}

// SAFETY: the component is used through `&mut self` (or, in `Drop`, by the owner) alone, so by one
// thread at a time, and FMI 2.0 lets each call come from another thread. The callbacks are only
// read here; their log is behind a lock.
unsafe impl Send for Instance {}

/// How to instantiate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct InstanceOptions {
    /// Have the FMU log debugging information.
    pub logging_on: bool,
    /// Let the FMU show a window, if it has any.
    pub visible: bool,
}

/// Declares the calls that take nothing but the component and change the phase.
macro_rules! transitions {
    ($($(#[$doc:meta])* $name:ident: $call:literal if $legal:ident, to $phase:ident;)*) => {$(
        $(#[$doc])*
        pub fn $name(&mut self) -> Result<(), Error> {
            self.call($call, phase::$legal, |f, c| {
                // SAFETY: as `call` requires.
                unsafe { (f.$name)(c) }
            })?;
            self.phase = Phase::$phase;
            Ok(())
        }
    )*};
}

impl Instance {
    /// Instantiates an FMU under a name, with its debug log off.
    pub fn new(archive: &Archive, name: &str) -> Result<Self, Error> {
        Self::with_options(archive, name, InstanceOptions::default())
    }

    /// Instantiates an FMU under a name.
    pub fn with_options(
        archive: &Archive,
        name: &str,
        options: InstanceOptions,
    ) -> Result<Self, Error> {
        Self::with_guid(archive, name, options, &archive.model().description().guid)
    }

    /// Instantiates with a GUID other than that of modelDescription.xml, to see it refused.
    pub fn with_guid(
        archive: &Archive,
        name: &str,
        options: InstanceOptions,
        guid: &str,
    ) -> Result<Self, Error> {
        if name.trim().is_empty() {
            return Err(Error::InstanceName { name: name.to_owned(), reason: "it is blank" });
        }
        let library = archive.library()?;
        if library.is_fatal() {
            return Err(Error::Fatal { instance: name.to_owned(), call: "fmi2Instantiate" });
        }
        let model = archive.model_arc();
        let others = library.instances().fetch_add(1, Ordering::AcqRel);
        // From here on the count goes down again wherever this function ends early.
        let counted = Counted(&library);
        if others > 0 && model.co_simulation().can_be_instantiated_only_once_per_process {
            let model = model.co_simulation().model_identifier.clone();
            return Err(Error::OnlyOnce { instance: name.to_owned(), model });
        }
        let (c_name, c_guid) = (c_string(name, name)?, c_string(name, guid)?);
        let resources = c_string(name, &archive.resources_uri())?;
        let callbacks = Callbacks::new(name);
        // SAFETY: the texts are C strings that outlive the call. The callbacks stay at their
        // address until the instance is freed.
        let component = unsafe {
            (library.functions.instantiate)(
                c_name.as_ptr(),
                c_types::CO_SIMULATION,
                c_guid.as_ptr(),
                resources.as_ptr(),
                callbacks.as_ptr(),
                c_types::Boolean::from(options.visible),
                c_types::Boolean::from(options.logging_on),
            )
        };
        let Some(component) = NonNull::new(component) else {
            let log = callbacks.log().since(0, LINES_IN_ERRORS);
            return Err(Error::Instantiate { instance: name.to_owned(), log });
        };
        std::mem::forget(counted);
        Ok(Self {
            name: name.to_owned(),
            component,
            phase: Phase::Instantiated,
            model,
            states: states::Saved::default(),
            booleans: Vec::new(),
            library,
            callbacks,
            _files: archive.files(),
        })
    }

    /// The name it was instantiated under.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The FMU's description in modelDescription.xml.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Where it is in its life.
    #[must_use]
    pub fn phase(&self) -> Phase {
        if self.library.is_fatal() { Phase::Fatal } else { self.phase }
    }

    /// Takes the lines logged since the last time, at most [`crate::MAX_LOG_LINES`].
    pub fn take_log(&mut self) -> Vec<LogLine> {
        self.callbacks.log().drain()
    }

    /// Switches the debug log of some categories, or of all if none is given.
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Result<(), Error> {
        let texts = categories
            .iter()
            .map(|category| c_string(&self.name, category))
            .collect::<Result<Vec<_>, _>>()?;
        let pointers: Vec<_> = texts.iter().map(|text| text.as_ptr()).collect();
        let on = c_types::Boolean::from(on);
        self.call("fmi2SetDebugLogging", phase::ANY, |f, c| {
            // SAFETY: as `call` requires; the array has the given length and outlives the call.
            unsafe { (f.set_debug_logging)(c, on, pointers.len(), pointers.as_ptr()) }
        })
    }

    /// Passes the FMU the start time and, where known, stop time (both s) and relative tolerance.
    pub fn setup_experiment(
        &mut self,
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    ) -> Result<(), Error> {
        let call = "fmi2SetupExperiment";
        self.finite(call, "start time", start)?;
        self.finite(call, "stop time", stop.unwrap_or(start))?;
        self.finite(call, "tolerance", tolerance.unwrap_or(0.0))?;
        let pair = |value: Option<f64>, other: f64| {
            (c_types::Boolean::from(value.is_some()), value.unwrap_or(other))
        };
        let ((has_tolerance, tolerance), (stops, stop)) = (pair(tolerance, 0.0), pair(stop, start));
        self.call(call, phase::INSTANTIATED, |f, c| {
            // SAFETY: as `call` requires.
            unsafe { (f.setup_experiment)(c, has_tolerance, tolerance, start, stops, stop) }
        })
    }

    transitions! {
        /// Enters initialization mode.
        enter_initialization_mode: "fmi2EnterInitializationMode" if INSTANTIATED, to Initialization;
        /// Leaves initialization mode: the instance is at its first communication point.
        exit_initialization_mode: "fmi2ExitInitializationMode" if INITIALIZATION, to StepComplete;
        /// Ends the simulation; values may still be read.
        terminate: "fmi2Terminate" if TERMINATE, to Terminated;
        /// Back to where it was after instantiation.
        reset: "fmi2Reset" if ANY, to Instantiated;
    }

    /// Steps from the communication point `time` to `time + step`, both in s.
    ///
    /// Unless an [`FmuState`] exists, the call states that the FMU is never set back before `time`. An FMU
    /// that discards the step because it ends the simulation is [`Error::Terminated`].
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<(), Error> {
        const CALL: &str = "fmi2DoStep";
        self.finite(CALL, "time", time)?;
        self.finite(CALL, "step", step)?;
        let no_set_prior = c_types::Boolean::from(self.states.is_empty());
        let result = self.call(CALL, phase::STEP, |f, c| {
            // SAFETY: as `call` requires.
            unsafe { (f.do_step)(c, time, step, no_set_prior) }
        });
        match result {
            Err(Error::Call { status, log, .. }) => {
                let instance = self.name.clone();
                match status {
                    Status::Discard => {
                        self.phase = Phase::StepFailed;
                        if let Some(time) = self.terminated_at(time, step) {
                            return Err(Error::Terminated { instance, time, log });
                        }
                    }
                    Status::Pending => self.cancel_step(),
                    _ => {}
                }
                Err(Error::Step { instance, call: CALL, time, step, status, log })
            }
            other => other,
        }
    }

    /// The time that was reached, where the FMU discarded the step from `time` because it ended the
    /// simulation (FMI 2.0.5, 4.2.3). Both questions are optional for an FMU: a refusal changes nothing.
    #[cold]
    fn terminated_at(&mut self, time: f64, step: f64) -> Option<f64> {
        let (component, functions) = (self.component.as_ptr(), &self.library.functions);
        let (mut terminated, mut reached) = (c_types::FALSE, time);
        // SAFETY: component and functions are valid, and the call is legal after a discarded step.
        let status = unsafe {
            (functions.get_boolean_status)(component, c_types::TERMINATED, &raw mut terminated)
        };
        match Status::from_raw(status) {
            Status::Ok | Status::Warning if terminated != c_types::FALSE => {}
            Status::Fatal => {
                self.failed("fmi2GetBooleanStatus", Status::Fatal, 0);
                return None;
            }
            _ => return None,
        }
        // SAFETY: as above.
        let status = unsafe {
            (functions.get_real_status)(component, c_types::LAST_SUCCESSFUL_TIME, &raw mut reached)
        };
        match Status::from_raw(status) {
            Status::Ok | Status::Warning if reached.is_finite() => {
                Some(reached.clamp(time, time + step))
            }
            _ => Some(time),
        }
    }

    /// Ends an asynchronous step, which an importer without `stepFinished` never requests.
    fn cancel_step(&mut self) {
        // `call` has put the instance into `Phase::Error`, in which nothing but this is called.
        let canceled = self.call("fmi2CancelStep", phase::ERROR, |f, c| {
            // SAFETY: as `call` requires; the instance has a step in progress.
            unsafe { (f.cancel_step)(c) }
        });
        self.phase = if canceled.is_ok() { Phase::StepCanceled } else { Phase::Error };
    }

    /// Makes one call of the FMU: `make` gets the functions and the component, both valid, and the
    /// call is legal in the present phase.
    #[inline]
    fn call(
        &mut self,
        call: &'static str,
        legal: phase::Phases,
        make: impl FnOnce(&Functions, c_types::Component) -> RawStatus,
    ) -> Result<(), Error> {
        if self.phase == Phase::Fatal || self.library.is_fatal() {
            return Err(Error::Fatal { instance: self.name.clone(), call });
        }
        if !legal.contain(self.phase) {
            let phase = self.phase.when();
            return Err(Error::Phase { instance: self.name.clone(), call, phase });
        }
        let mark = self.callbacks.log().count();
        match Status::from_raw(make(&self.library.functions, self.component.as_ptr())) {
            Status::Ok | Status::Warning => Ok(()),
            status => Err(self.failed(call, status, mark)),
        }
    }

    #[cold]
    fn failed(&mut self, call: &'static str, status: Status, mark: usize) -> Error {
        match status {
            Status::Fatal => {
                self.library.set_fatal();
                self.phase = Phase::Fatal;
            }
            Status::Error | Status::Pending | Status::Undefined(_) => self.phase = Phase::Error,
            Status::Ok | Status::Warning | Status::Discard => {}
        }
        let log = self.callbacks.log().since(mark, LINES_IN_ERRORS);
        Error::Call { instance: self.name.clone(), call, status, log }
    }

    #[inline]
    fn finite(&self, call: &'static str, what: &'static str, value: f64) -> Result<(), Error> {
        if value.is_finite() {
            return Ok(());
        }
        Err(Error::NotFinite { instance: self.name.clone(), call, what, value })
    }
}

fn c_string(instance: &str, text: &str) -> Result<CString, Error> {
    CString::new(text)
        .map_err(|_| Error::NulInText { instance: instance.to_owned(), text: text.to_owned() })
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance")
            .field("name", &self.name)
            .field("model", &self.model.co_simulation().model_identifier)
            .field("phase", &self.phase())
            .finish_non_exhaustive()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.free_all_states();
        // Checked after the states are freed: that, too, may have ended fatally.
        if self.library.is_fatal() {
            // A thread of the FMU may go on logging.
            std::mem::forget(Arc::clone(&self.callbacks));
        } else {
            // SAFETY: the component is valid and of no use to anyone after this; the library is
            // still loaded and the callbacks still at their place.
            unsafe { (self.library.functions.free_instance)(self.component.as_ptr()) };
        }
        self.library.instances().fetch_sub(1, Ordering::AcqRel);
    }
}

/// Takes an instance off its library's count when dropped.
struct Counted<'a>(&'a Library);

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.instances().fetch_sub(1, Ordering::AcqRel);
    }
}
