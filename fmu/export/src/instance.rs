//! One instance: state machine, times, FMU state. Everything here is safe code over slices.

use crate::calls::{Call, Leniency, State};
use crate::contain::Contained;
use crate::log::Level;
use crate::logger::{Category, Logger};
use crate::told::Told;
use crate::types::Status;
use crate::{Log, Resources, Slave, VariableId, describe};
use std::ffi::{CStr, CString};
use std::sync::Arc;

/// How a call went: a status up to discard, or the text of an error.
pub(crate) type Outcome = Result<Status, String>;

/// How far a communication point may lie from where it is expected, in steps.
const TIME_TOLERANCE: f64 = 1e-3;

/// What `fmi2SetupExperiment` said, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Experiment {
    pub(crate) start_time: f64,
    pub(crate) stop_time: Option<f64>,
}

/// What an FMU state holds: all that the result of a later call can depend on.
#[derive(Debug, Clone)]
pub(crate) struct Core<S> {
    pub(crate) slave: Contained<S>,
    pub(crate) state: State,
    pub(crate) experiment: Option<Experiment>,
    /// Where the next step is expected to begin, s.
    pub(crate) time: f64,
    /// Whether something was set at this communication point.
    pub(crate) set_since_step: bool,
    /// Value references of inputs whose clipping was told: the first one is an `fmi2Warning`.
    pub(crate) clipped: Vec<u32>,
    /// Value references and derivatives of the inputs that are to grow within the next step.
    pub(crate) input_derivatives: Vec<(u32, f64)>,
}

/// A copy of an instance's [`Core`], and whose it is.
#[derive(Debug)]
pub(crate) struct Snapshot<S> {
    pub(crate) core: Core<S>,
    pub(crate) guid: Arc<str>,
}

/// One instance.
pub(crate) struct Instance<S> {
    pub(crate) core: Core<S>,
    /// As `open` made it; what `fmi2Reset` goes back to.
    pub(crate) pristine: Contained<S>,
    /// Of each state, whether it is settable.
    pub(crate) settable: Box<[bool]>,
    pub(crate) guid: Arc<str>,
    pub(crate) logger: Logger,
    log: Log,
    told: Told,
    /// What the pointers of the last `fmi2GetString` point to.
    pub(crate) strings: Vec<CString>,
}

impl<S: Slave> Core<S> {
    pub(crate) fn new(slave: Contained<S>) -> Self {
        Self {
            slave,
            state: State::Instantiated,
            experiment: None,
            time: 0.0,
            set_since_step: false,
            clipped: Vec::new(),
            input_derivatives: Vec::new(),
        }
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
        let pristine = Contained::new(S::open(resources)?);
        Ok(Self {
            settable: pristine.states().iter().map(|state| state.settable).collect(),
            core: Core::new(pristine.clone()),
            pristine,
            guid: expected.into(),
            logger,
            log: Log::default(),
            told: Told::default(),
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
        if self.told.is_new(leniency) {
            self.logger.tell(Category::Event, leniency.text());
        }
    }

    /// Tells a line that may come again and again, as often as [`Told`] lets it.
    #[cold]
    pub(crate) fn tell_often(&mut self, category: Category, text: String) {
        // What nobody hears does not count as told.
        if self.logger.is_enabled(category)
            && let Some(text) = self.told.admit(text)
        {
            self.logger.tell(category, &text);
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
                Level::Info => self.tell_often(Category::Event, text),
                Level::Warning => {
                    status = Status::Warning;
                    self.tell_often(Category::Warning, text);
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
        if let Some(tolerance) = tolerance.filter(|t| !t.is_finite()) {
            return Err(format!("the tolerance is {tolerance}"));
        }
        self.core.experiment = Some(Experiment { start_time, stop_time });
        self.core.time = start_time;
        // Nothing here is iterated to a tolerance, and importers are seen to pass their default, 0.
        let Some(tolerance) = tolerance.filter(|t| *t <= 0.0) else { return Ok(Status::Ok) };
        let text = format!("fmi2SetupExperiment: the tolerance of {tolerance} is not used");
        self.logger.tell(Category::Warning, &text);
        Ok(Status::Warning)
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
        self.core.set_since_step = false;
        Ok(status)
    }

    pub(crate) fn terminate(&mut self) -> Outcome {
        self.core.state = State::Terminated;
        Ok(Status::Ok)
    }

    /// Back to what `fmi2Instantiate` made, down to what was told and what is to be told.
    pub(crate) fn reset(&mut self) -> Outcome {
        let fresh = Core::new(self.pristine.clone());
        self.replace_core(fresh);
        self.log.take();
        self.told = Told::default();
        self.strings = Vec::new();
        self.logger.reset();
        Ok(Status::Ok)
    }

    /// Takes another core; a panic of the old slave's destructor shows, after that.
    fn replace_core(&mut self, core: Core<S>) {
        let old = std::mem::replace(&mut self.core, core);
        old.slave.release();
    }

    /// One step from `time` by `step`, both s.
    #[inline]
    pub(crate) fn do_step(&mut self, time: f64, step: f64) -> Outcome {
        let tolerance = TIME_TOLERANCE * step;
        // Clocks of 64 bits count no finer than this at a late time.
        let slack = tolerance + 4.0 * f64::EPSILON * self.core.time.abs();
        let end = time + step;
        let stop = self.core.experiment.and_then(|experiment| experiment.stop_time);
        // Each comparison is written so that NaN fails. A step that is infinite has no finite end.
        if !(step > 0.0
            && end < f64::INFINITY
            && (time - self.core.time).abs() <= slack
            && stop.is_none_or(|stop| end <= stop + slack))
        {
            self.wrong_time(time, step, slack)?;
        }
        let result = self.core.slave.step(time, step, &mut self.log);
        let status = self.flush();
        result?;
        self.core.time = end;
        self.core.set_since_step = false;
        if !self.core.input_derivatives.is_empty() {
            self.end_input_derivatives();
        }
        Ok(status)
    }

    /// Sets the derivatives of the inputs back: each holds for one step.
    #[inline(never)]
    fn end_input_derivatives(&mut self) {
        for (reference, _) in self.core.input_derivatives.drain(..) {
            if let Some(variable) = S::Variable::from_reference(reference) {
                self.core.slave.set_input_derivative(variable, 0.0);
            }
        }
    }

    /// Why that step cannot be made, or nothing if it goes past the stop time by no more than
    /// adding up so many steps to a time makes of rounding.
    #[cold]
    fn wrong_time(&self, time: f64, step: f64, slack: f64) -> Result<(), String> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(format!("the step size is {step}"));
        }
        let expected = self.core.time;
        // Written so that NaN is far away.
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
                Err(format!("the step from {time} by {step} goes past the stop time {stop}"))
            }
            Some(Experiment { start_time, .. }) if expected == start_time => Err(format!(
                "the communication point is {time}, expected {expected}, the start time"
            )),
            _ => Err(format!(
                "the communication point is {time}, expected {expected}, where the last step ended"
            )),
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
        self.replace_core(snapshot.core.clone());
        Ok(Status::Ok)
    }
}
