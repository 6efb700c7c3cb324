//! One instance: state machine, times, FMU state. All code here is safe and works on slices.

use crate::access_rules::Leniency;
use crate::calls::{Call, State};
use crate::contain::Contained;
use crate::describe;
use crate::log::{Level, Log, Repetitions};
use crate::logger::{Category, Logger};
use crate::resources::Resources;
use crate::types::Status;
use crate::unit::{CoSimulationUnit, VariableId};
use std::ffi::{CStr, CString};
use std::sync::Arc;

/// The outcome of a call: a status up to `fmi2Discard`, or the message of an error.
pub(crate) type Outcome = Result<Status, String>;

/// The largest deviation of a communication point from the expected time, in steps.
const TIME_TOLERANCE: f64 = 1e-3;

/// The times of `fmi2SetupExperiment`, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Experiment {
    pub(crate) start_time: f64,
    pub(crate) stop_time: Option<f64>,
}

/// The content of an FMU state: everything that the result of a later call can depend on.
#[derive(Debug, Clone)]
pub(crate) struct Core<S> {
    pub(crate) unit: Contained<S>,
    pub(crate) state: State,
    pub(crate) experiment: Option<Experiment>,
    /// The expected start of the next step, s.
    pub(crate) time: f64,
    /// Whether a variable was set at this communication point.
    pub(crate) set_since_step: bool,
    /// References of inputs whose clipping was logged; the first clipping of each returns `fmi2Warning`.
    pub(crate) clipped: Vec<u32>,
    /// Value references and derivatives of inputs with a derivative in the next step.
    pub(crate) input_derivatives: Vec<(u32, f64)>,
}

/// A copy of an instance's [`Core`] with the GUID of its FMU.
#[derive(Debug)]
pub(crate) struct Snapshot<S> {
    pub(crate) core: Core<S>,
    pub(crate) guid: Arc<str>,
}

/// One instance.
pub(crate) struct Instance<S> {
    pub(crate) core: Core<S>,
    /// The unit that `open` returned, which `fmi2Reset` restores.
    pub(crate) pristine: Contained<S>,
    /// For each state, whether it is settable.
    pub(crate) settable: Box<[bool]>,
    pub(crate) guid: Arc<str>,
    pub(crate) logger: Logger,
    log: Log,
    repetitions: Repetitions,
    /// The strings that the last `fmi2GetString` returned pointers to.
    pub(crate) strings: Vec<CString>,
}

impl<S: CoSimulationUnit> Core<S> {
    pub(crate) fn new(unit: Contained<S>) -> Self {
        Self {
            unit,
            state: State::Instantiated,
            experiment: None,
            time: 0.0,
            set_since_step: false,
            clipped: Vec::new(),
            input_derivatives: Vec::new(),
        }
    }
}

impl<S: CoSimulationUnit> Instance<S> {
    /// Creates an instance.
    ///
    /// # Errors
    /// The GUID is not that of this library with these resources, or the unit rejects them.
    pub(crate) fn new(guid: &CStr, resources: &Resources, logger: Logger) -> Result<Self, String> {
        let expected = describe::guid::<S>(resources);
        if guid.to_bytes() != expected.as_bytes() {
            return Err(format!(
                "the GUID given is \"{}\"; this library with its {} resource files has the GUID \
                 \"{expected}\": description, library and resources are not of one archive, or \
                 the resource location is wrong",
                guid.to_string_lossy(),
                resources.entries().len(),
            ));
        }
        let pristine = Contained::new(S::open(resources)?);
        Ok(Self {
            settable: pristine.states().iter().map(|state| state.settable).collect(),
            core: Core::new(pristine.clone()),
            pristine,
            guid: expected.into(),
            logger,
            log: Log::default(),
            repetitions: Repetitions::default(),
            strings: Vec::new(),
        })
    }

    /// Checks that a call is legal in the present state.
    #[inline]
    pub(crate) fn admit(&self, call: Call) -> Result<(), String> {
        if call.is_legal_in(self.core.state) { Ok(()) } else { Err(self.illegal_call()) }
    }

    #[cold]
    fn illegal_call(&self) -> String {
        format!("not allowed in the state \"{}\"", self.core.state.name())
    }

    /// Ends a failed call: logs the problem and enters the error state.
    #[cold]
    pub(crate) fn fail(&mut self, call: Call, problem: &str) -> Status {
        if self.core.state == State::Fatal {
            return Status::Fatal;
        }
        self.core.state = State::Error;
        self.logger.log(Category::Error, &format!("{}: {problem}", call.name()));
        Status::Error
    }

    /// Ends a call that panicked: logs the message; the instance can only be freed.
    #[cold]
    pub(crate) fn poison(&mut self, call: Call, message: &str) -> Status {
        self.core.state = State::Fatal;
        let text = format!("{}: the model panicked: {message}", call.name());
        self.logger.log(Category::Fatal, &text);
        Status::Fatal
    }

    /// Logs a leniency, once.
    #[inline]
    pub(crate) fn log_once(&mut self, leniency: Leniency) {
        if self.repetitions.is_new(leniency) {
            self.logger.log(Category::Event, leniency.text());
        }
    }

    /// Logs a line that may be repeated, as often as [`Repetitions`] admits it.
    #[cold]
    pub(crate) fn log_repeated(&mut self, category: Category, text: String) {
        // Lines of disabled categories are not counted.
        if self.logger.is_enabled(category)
            && let Some(text) = self.repetitions.admit(text)
        {
            self.logger.log(category, &text);
        }
    }

    /// Passes the lines that the unit logged during a call to the importer.
    #[inline]
    fn flush(&mut self) -> Status {
        if self.log.lines().is_empty() { Status::Ok } else { self.flush_lines() }
    }

    #[cold]
    fn flush_lines(&mut self) -> Status {
        let mut status = Status::Ok;
        for (level, text) in self.log.take() {
            match level {
                Level::Info => self.log_repeated(Category::Event, text),
                Level::Warning => {
                    status = Status::Warning;
                    self.log_repeated(Category::Warning, text);
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
        let text = format!("fmi2SetDebugLogging: unknown category {}", unknown.join(", "));
        self.logger.log(Category::Warning, &text);
        Ok(Status::Warning)
    }

    pub(crate) fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start_time: f64,
        stop_time: Option<f64>,
    ) -> Outcome {
        if !start_time.is_finite() {
            return Err(format!("the start time is {start_time}; it must be finite"));
        }
        if let Some(stop) = stop_time.filter(|stop| !(stop.is_finite() && *stop >= start_time)) {
            return Err(format!(
                "the stop time is {stop}; it must be finite and not before the start time {start_time}"
            ));
        }
        if let Some(tolerance) = tolerance.filter(|t| !t.is_finite()) {
            return Err(format!("the tolerance is {tolerance}; it must be finite"));
        }
        self.core.experiment = Some(Experiment { start_time, stop_time });
        self.core.time = start_time;
        // The tolerance is not used. Some importers pass 0 by default, so it is not an error.
        let Some(tolerance) = tolerance.filter(|t| *t <= 0.0) else { return Ok(Status::Ok) };
        let text = format!("fmi2SetupExperiment: the tolerance of {tolerance} is not used");
        self.logger.log(Category::Warning, &text);
        Ok(Status::Warning)
    }

    pub(crate) fn enter_initialization_mode(&mut self) -> Outcome {
        if self.core.experiment.is_none() {
            return Err("fmi2SetupExperiment was not called".into());
        }
        self.core.state = State::Initialization;
        Ok(Status::Ok)
    }

    pub(crate) fn exit_initialization_mode(&mut self) -> Outcome {
        let core = &mut self.core;
        let result = core.unit.exit_initialization(core.time, &mut self.log);
        let status = self.flush();
        result?;
        self.core.state = State::StepComplete;
        self.core.set_since_step = false;
        Ok(status)
    }

    pub(crate) fn terminate(&mut self) -> Outcome {
        self.core.state = State::Terminated;
        Ok(Status::Ok)
    }

    /// Restores the state after `fmi2Instantiate`, including the log settings and repetition counts.
    pub(crate) fn reset(&mut self) -> Outcome {
        let fresh = Core::new(self.pristine.clone());
        self.replace_core(fresh);
        self.log.take();
        self.repetitions = Repetitions::default();
        self.strings = Vec::new();
        self.logger.reset();
        Ok(Status::Ok)
    }

    /// Replaces the core; then a panic of the old unit's destructor propagates.
    fn replace_core(&mut self, core: Core<S>) {
        let old = std::mem::replace(&mut self.core, core);
        old.unit.release();
    }

    /// One step from `time` by `step`, both s.
    #[inline]
    pub(crate) fn do_step(&mut self, time: f64, step: f64) -> Outcome {
        let tolerance = TIME_TOLERANCE * step;
        // The resolution of a double at the present time.
        let slack = tolerance + 4.0 * f64::EPSILON * self.core.time.abs();
        let end = time + step;
        let stop = self.core.experiment.and_then(|experiment| experiment.stop_time);
        // Each comparison is written so that NaN fails. An infinite step has no finite end.
        if !(step > 0.0
            && end < f64::INFINITY
            && (time - self.core.time).abs() <= slack
            && stop.is_none_or(|stop| end <= stop + slack))
        {
            self.check_time(time, step, slack)?;
        }
        let result = self.core.unit.step(time, step, &mut self.log);
        let status = self.flush();
        result?;
        self.core.time = end;
        self.core.set_since_step = false;
        if !self.core.input_derivatives.is_empty() {
            self.clear_input_derivatives();
        }
        Ok(status)
    }

    /// Sets the derivatives of the inputs to zero: each is valid for one step.
    #[inline(never)]
    fn clear_input_derivatives(&mut self) {
        for (reference, _) in self.core.input_derivatives.drain(..) {
            if let Some(variable) = S::Variable::from_reference(reference) {
                self.core.unit.set_input_derivative(variable, 0.0);
            }
        }
    }

    /// Checks the times of a step that is past the stop time or wrong.
    ///
    /// # Errors
    /// Why the step cannot be made. A step past the stop time is accepted if the excess can be the
    /// rounding error of a time that is a sum of steps.
    #[cold]
    fn check_time(&self, time: f64, step: f64, slack: f64) -> Result<(), String> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(format!("the step size is {step}; it must be positive and finite"));
        }
        let expected = self.core.time;
        // Written so that NaN is not near.
        let near = (time - expected).abs() <= slack;
        match self.core.experiment {
            _ if near && (time + step).is_infinite() => {
                Err(format!("the step from {time} by {step} has no finite end"))
            }
            Some(Experiment { start_time, stop_time: Some(stop) }) if near => {
                let count = (time - start_time) / step + 1.0;
                let rounding = count * f64::EPSILON * stop.abs().max(start_time.abs());
                if time + step - stop <= slack + rounding.min(0.5 * step) {
                    return Ok(());
                }
                Err(format!("the step from {time} by {step} exceeds the stop time {stop}"))
            }
            Some(Experiment { start_time, .. }) if expected == start_time => Err(format!(
                "the communication point is {time}; expected is the start time {expected}"
            )),
            _ => Err(format!(
                "the communication point is {time}; expected is the end of the last step, {expected}"
            )),
        }
    }

    /// Ends a call that requests a status that does not exist.
    pub(crate) fn discard(&mut self, call: Call) -> Outcome {
        let text = format!("{}: no status of this kind exists", call.name());
        self.logger.log(Category::Discard, &text);
        Ok(Status::Discard)
    }

    pub(crate) fn snapshot(&self) -> Snapshot<S> {
        Snapshot { core: self.core.clone(), guid: self.guid.clone() }
    }

    pub(crate) fn restore(&mut self, snapshot: &Snapshot<S>) -> Outcome {
        if snapshot.guid != self.guid {
            return Err("the FMU state is of an instance with other resources".into());
        }
        self.replace_core(snapshot.core.clone());
        Ok(Status::Ok)
    }
}
