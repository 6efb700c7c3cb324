//! One instance: state machine, times, FMU state. Everything here is safe code over slices.

use crate::calls::{Call, Leniency, State};
use crate::log::Level;
use crate::logger::{Category, Logger};
use crate::types::Status;
use crate::{Log, Resources, Slave, describe};
use std::ffi::{CStr, CString};
use std::sync::Arc;

/// How a call went: a status up to discard, or the text of an error.
pub(crate) type Outcome = Result<Status, String>;

/// How far a communication point may lie from where it is expected, in steps.
const TIME_TOLERANCE: f64 = 1e-3;

/// What `fmi2SetupExperiment` said, s.
#[derive(Debug, Clone, Copy)]
struct Experiment {
    start_time: f64,
    stop_time: Option<f64>,
}

/// What an FMU state holds: all that a later call can depend on.
#[derive(Debug, Clone)]
pub(crate) struct Core<S> {
    pub(crate) slave: S,
    pub(crate) state: State,
    experiment: Option<Experiment>,
    /// Where the next step is expected to begin, s.
    time: f64,
}

/// A copy of an instance's [`Core`], and whose it is.
#[derive(Debug)]
pub(crate) struct Snapshot<S> {
    core: Core<S>,
    guid: Arc<str>,
}

/// One instance.
pub(crate) struct Instance<S> {
    pub(crate) core: Core<S>,
    /// As `open` made it; what `fmi2Reset` goes back to.
    pristine: S,
    guid: Arc<str>,
    pub(crate) logger: Logger,
    log: Log,
    /// Value references of inputs whose clipping was told.
    pub(crate) clipped: Vec<u32>,
    /// Bits of the leniencies that were told.
    noted: u8,
    /// What the pointers of the last `fmi2GetString` point to.
    pub(crate) strings: Vec<CString>,
}

impl<S: Slave> Core<S> {
    fn new(slave: S) -> Self {
        Self { slave, state: State::Instantiated, experiment: None, time: 0.0 }
    }
}

impl<S: Slave> Instance<S> {
    /// A new instance, if the GUID is that of this library and these resources.
    pub(crate) fn new(guid: &CStr, resources: &Resources, logger: Logger) -> Result<Self, String> {
        let expected = describe::guid::<S>(resources);
        if guid.to_bytes() != expected.as_bytes() {
            return Err(format!(
                "the GUID given is \"{}\", that of this library with its {} resource files is \
                 \"{expected}\": description, library and resources are not of one archive, or \
                 the resource location is wrong",
                guid.to_string_lossy(),
                resources.entries().len(),
            ));
        }
        let pristine = S::open(resources)?;
        Ok(Self {
            core: Core::new(pristine.clone()),
            pristine,
            guid: expected.into(),
            logger,
            log: Log::default(),
            clipped: Vec::new(),
            noted: 0,
            strings: Vec::new(),
        })
    }

    /// Whether the call is legal now.
    #[inline]
    pub(crate) fn admit(&self, call: Call) -> Result<(), String> {
        if call.is_legal_in(self.core.state) { Ok(()) } else { Err(self.refusal()) }
    }

    #[cold]
    fn refusal(&self) -> String {
        format!("not allowed in the state \"{}\"", self.core.state.name())
    }

    /// Ends a call that failed: one log line, and the error state.
    #[cold]
    pub(crate) fn fail(&mut self, call: Call, problem: &str) -> Status {
        if self.core.state == State::Fatal {
            return Status::Fatal;
        }
        self.core.state = State::Error;
        self.logger.tell(Category::Error, &format!("{}: {problem}", call.name()));
        Status::Error
    }

    /// Ends a call that panicked: one log line, and nothing is legal any more but to free it.
    #[cold]
    pub(crate) fn poison(&mut self, call: Call, message: &str) -> Status {
        self.core.state = State::Fatal;
        let text = format!("{}: a fault of the model: {message}", call.name());
        self.logger.tell(Category::Fatal, &text);
        Status::Fatal
    }

    /// Tells a leniency, once.
    #[inline]
    pub(crate) fn note(&mut self, leniency: Leniency) {
        let bit = 1 << leniency as u8;
        if self.noted & bit == 0 {
            self.noted |= bit;
            self.logger.tell(Category::Event, leniency.text());
        }
    }

    /// Passes on what the slave told during a call.
    #[inline]
    fn flush(&mut self) -> Status {
        if self.log.lines().is_empty() { Status::Ok } else { self.flush_lines() }
    }

    #[cold]
    fn flush_lines(&mut self) -> Status {
        let mut status = Status::Ok;
        for (level, text) in self.log.take() {
            match level {
                Level::Info => self.logger.tell(Category::Event, &text),
                Level::Warning => {
                    status = Status::Warning;
                    self.logger.tell(Category::Warning, &text);
                }
            }
        }
        status
    }

    pub(crate) fn set_debug_logging(&mut self, on: bool, categories: &[&CStr]) -> Outcome {
        let unknown = self.logger.set_enabled(on, categories);
        if unknown.is_empty() {
            return Ok(Status::Ok);
        }
        let text = format!("fmi2SetDebugLogging: there is no category {}", unknown.join(", "));
        self.logger.tell(Category::Warning, &text);
        Ok(Status::Warning)
    }

    pub(crate) fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start_time: f64,
        stop_time: Option<f64>,
    ) -> Outcome {
        if !start_time.is_finite() {
            return Err(format!("the start time is {start_time}"));
        }
        if let Some(stop) = stop_time.filter(|stop| !(stop.is_finite() && *stop >= start_time)) {
            return Err(format!("the stop time is {stop}, the start time {start_time}"));
        }
        if let Some(tolerance) = tolerance.filter(|t| !(t.is_finite() && *t > 0.0)) {
            return Err(format!("the tolerance is {tolerance}"));
        }
        self.core.experiment = Some(Experiment { start_time, stop_time });
        self.core.time = start_time;
        Ok(Status::Ok)
    }

    pub(crate) fn enter_initialization_mode(&mut self) -> Outcome {
        if self.core.experiment.is_none() {
            return Err("fmi2SetupExperiment was not called before".into());
        }
        self.core.state = State::Initialization;
        Ok(Status::Ok)
    }

    pub(crate) fn exit_initialization_mode(&mut self) -> Outcome {
        let core = &mut self.core;
        let result = core.slave.exit_initialization(core.time, &mut self.log);
        let status = self.flush();
        result?;
        self.core.state = State::StepComplete;
        Ok(status)
    }

    pub(crate) fn terminate(&mut self) -> Outcome {
        self.core.state = State::Terminated;
        Ok(Status::Ok)
    }

    pub(crate) fn reset(&mut self) -> Outcome {
        self.core = Core::new(self.pristine.clone());
        self.clipped.clear();
        self.noted = 0;
        Ok(Status::Ok)
    }

    /// One step from `time` by `step`, both s.
    #[inline]
    pub(crate) fn do_step(&mut self, time: f64, step: f64) -> Outcome {
        let tolerance = TIME_TOLERANCE * step;
        // Clocks of 64 bits count no finer than this at a late time.
        let slack = tolerance + 4.0 * f64::EPSILON * self.core.time.abs();
        let end = time + step;
        let stop = self.core.experiment.and_then(|experiment| experiment.stop_time);
        // Each comparison is written so that NaN fails.
        if !(step > 0.0
            && step < f64::INFINITY
            && (time - self.core.time).abs() <= slack
            && stop.is_none_or(|stop| end <= stop + slack))
        {
            return Err(self.wrong_time(time, step));
        }
        let result = self.core.slave.step(time, step, &mut self.log);
        let status = self.flush();
        result?;
        self.core.time = end;
        Ok(status)
    }

    #[cold]
    fn wrong_time(&self, time: f64, step: f64) -> String {
        if !(step > 0.0 && step.is_finite()) {
            return format!("the step size is {step}");
        }
        let expected = self.core.time;
        match self.core.experiment {
            Some(Experiment { stop_time: Some(stop), .. })
                if (time - expected).abs() <= TIME_TOLERANCE * step =>
            {
                format!("the step from {time} by {step} goes past the stop time {stop}")
            }
            Some(Experiment { start_time, .. }) if expected == start_time => {
                format!("the communication point is {time}, expected {expected}, the start time")
            }
            _ => format!(
                "the communication point is {time}, expected {expected}, where the last step ended"
            ),
        }
    }

    /// End of the last step that was made, s.
    pub(crate) fn last_successful_time(&self) -> f64 {
        self.core.time
    }

    /// Tells that a question has no answer.
    pub(crate) fn discard(&mut self, call: Call) -> Outcome {
        let text = format!("{}: there is no status of this kind", call.name());
        self.logger.tell(Category::Discard, &text);
        Ok(Status::Discard)
    }

    pub(crate) fn snapshot(&self) -> Snapshot<S> {
        Snapshot { core: self.core.clone(), guid: self.guid.clone() }
    }

    pub(crate) fn restore(&mut self, snapshot: &Snapshot<S>) -> Outcome {
        if snapshot.guid != self.guid {
            return Err("the FMU state is of an instance with other resources".into());
        }
        self.core.clone_from(&snapshot.core);
        Ok(Status::Ok)
    }
}
