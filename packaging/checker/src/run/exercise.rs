//! The legal calls of each phase of the state machine (section 4.2.4), and comparisons of the results.

use super::journal::Journal;
use super::reference;
use super::trajectory::{Plan, Trajectory, difference, drive, is_rounding, outputs, same, show};
use model_description::{Causality, Initial, Kind, ModelDescription, Value, Variability};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;
use steerwright_host::{Archive, Error, Instance, InstanceOptions};

/// A GUID that no FMU uses.
const WRONG_GUID: &str = "ffffffff-0000-4000-8000-00000000dead";

/// Runs the whole test, from loading to unloading.
pub(super) fn all(fmu: &Path, journal: &mut Journal, deadline: Instant) {
    journal.start("opening the archive");
    let archive = match Archive::open(fmu) {
        Ok(archive) => archive,
        Err(error @ (Error::TooManyEntries { .. } | Error::TooLarge { .. })) => {
            return journal.found("not-examined", error.to_string());
        }
        Err(error) => return journal.found("run-load", error.to_string()),
    };
    journal.start("loading the binary");
    match archive.load() {
        Ok(()) => {}
        Err(error @ (Error::NoBinary { .. } | Error::OtherBinary { .. })) => {
            return journal.found("run-skipped", error.to_string());
        }
        Err(error @ Error::WrongVersion { .. }) => {
            return journal.found("run-version", error.to_string());
        }
        Err(error) => return report(&archive, journal, "run-load", &error),
    }
    let plan = Plan::from_description(archive.model().description());
    journal.runs(binary(&archive));
    let mut run = ExerciseRun {
        archive: &archive,
        plan,
        journal,
        mismatched: BTreeSet::new(),
        differences: Vec::new(),
        deadline,
        stop: None,
        first_steps: None,
    };
    let instantiated = run.simulations();
    run.journal.start("fmi2FreeInstance(NULL)");
    if let Err(error) = archive.free_null_instance() {
        run.journal.found("run-null", error.to_string());
    }
    run.wrong_guid();
    // A failed instantiation is already reported.
    if instantiated {
        reference::replay(&archive, run.journal);
        let _ = run.experiment();
    }
    journal.start("unloading the binary");
    drop(archive);
}

fn binary(archive: &Archive) -> Option<String> {
    let name = steerwright_host::binary_name(&archive.model().co_simulation().model_identifier);
    steerwright_host::platform_folders()
        .iter()
        .map(|folder| format!("binaries/{folder}/{name}"))
        .find(|entry| archive.folder().join(entry).is_file())
}

/// Reports an error, unless the FMU needs a tool that may not be installed.
fn report(archive: &Archive, journal: &mut Journal, rule: &'static str, error: &Error) {
    let message = error.to_string();
    if archive.model().co_simulation().needs_execution_tool {
        let message =
            format!("it needs a tool (needsExecutionTool) that is not available: {message}");
        journal.found("run-skipped", message);
    } else {
        journal.found(rule, message);
    }
}

pub(super) struct ExerciseRun<'a> {
    pub(super) archive: &'a Archive,
    pub(super) plan: Plan,
    pub(super) journal: &'a mut Journal,
    /// Variables whose start values were reported as wrong.
    mismatched: BTreeSet<String>,
    /// Rules and messages of runs that should be equal; reported at the end, unless the FMU is random.
    pub(super) differences: Vec<(&'static str, String)>,
    /// When the last run has to end.
    pub(super) deadline: Instant,
    /// The stop time that the FMU is given, if any.
    pub(super) stop: Option<f64>,
    /// The steps of the first run, if it was without a fault.
    pub(super) first_steps: Option<u32>,
}

/// A violation after which the instance is not tested further.
pub(super) struct Stop;

impl ExerciseRun<'_> {
    pub(super) fn description(&self) -> &ModelDescription {
        self.archive.model().description()
    }

    /// A failed legal call is a finding that ends the test of the instance.
    pub(super) fn legal<T>(&mut self, result: Result<T, Error>) -> Result<T, Stop> {
        result.map_err(|error| {
            match error {
                Error::Instantiate { .. } => {
                    report(self.archive, self.journal, "run-instantiate", &error);
                }
                Error::Call { .. }
                | Error::Step { .. }
                | Error::Fatal { .. }
                | Error::NullResult { .. } => {
                    self.journal.found("run-call", format!("a legal call fails: {error}"));
                }
                // An error of our own host is not a violation by the FMU.
                error => self.journal.found("not-examined", format!("the remaining run: {error}")),
            }
            Stop
        })
    }

    /// A legal call, which the journal names before it is made.
    pub(super) fn call<T>(
        &mut self,
        name: &str,
        made: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Stop> {
        self.journal.start(name);
        self.legal(made())
    }

    pub(super) fn instance(&mut self, name: &str) -> Result<Instance, Stop> {
        self.journal.start("fmi2Instantiate");
        let options = InstanceOptions { logging_on: true, visible: false };
        self.legal(Instance::with_options(self.archive, name, options))
    }

    fn wrong_guid(&mut self) {
        self.journal.start("fmi2Instantiate with a wrong GUID");
        let made = Instance::with_guid(self.archive, "check", Default::default(), WRONG_GUID);
        if made.is_ok() {
            self.journal
                .found("run-guid", "fmi2Instantiate accepts a GUID that differs from the XML's");
        }
        self.journal.start("fmi2FreeInstance after a wrong GUID");
    }

    /// Runs all simulations. Returns whether the FMU can be instantiated.
    fn simulations(&mut self) -> bool {
        if self.fresh_starts().is_err() {
            return false;
        }
        let Ok(mut instance) = self.instance("check") else { return false };
        let simulated = self.simulate(&mut instance);
        self.log(&mut instance);
        self.journal.start("fmi2FreeInstance");
        drop(instance);
        // A run with a discarded step is not compared with others.
        if let Ok(first) = simulated {
            self.first_steps = u32::try_from(first.len()).ok();
            if self.is_whole(&first) {
                self.probes(&first);
            }
        }
        self.report_differences();
        true
    }

    fn simulate(&mut self, instance: &mut Instance) -> Result<Trajectory, Stop> {
        self.ready(instance)?;
        self.readings(instance)?;
        self.nudge(instance)?;
        let first = self.steps(instance)?;
        // After a discarded step no variable may be set.
        if self.is_whole(&first) {
            self.settings(instance, |variable| {
                variable.causality == Causality::Input
                    || variable.causality == Causality::Parameter
                        && variable.variability == Variability::Tunable
            })?;
        }
        self.call("fmi2Terminate", || instance.terminate())?;
        self.journal.start("fmi2GetXXX after fmi2Terminate");
        self.readings(instance)?;

        self.call("fmi2Reset after fmi2Terminate", || instance.reset())?;
        self.initialize_unset(instance)?;
        self.starts(instance, "run-reset")?;
        self.call("fmi2Reset", || instance.reset())?;
        self.ready(instance)?;
        self.nudge(instance)?;
        let second = self.steps(instance)?;
        if let Some(difference) = difference(&first, &second, &outputs(instance)) {
            self.differences.push(("run-reset", format!("after fmi2Reset {difference}")));
        }
        self.states(instance)?;
        Ok(first)
    }

    /// Sets the start values and initializes, equally in all runs that are compared.
    pub(super) fn ready(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.settings(instance, |variable| {
            matches!(variable.effective_initial(), Some(Initial::Exact | Initial::Approx))
                && variable.variability != Variability::Constant
        })?;
        self.initialize(instance)
    }

    /// Sets variables to their start values, which must not change anything.
    pub(super) fn settings(
        &mut self,
        instance: &mut Instance,
        wanted: impl Fn(&model_description::Variable) -> bool,
    ) -> Result<(), Stop> {
        self.journal.start("fmi2SetXXX");
        let variables: Vec<_> = self
            .description()
            .variables
            .iter()
            .filter(|variable| wanted(variable))
            .filter_map(|variable| Some((variable.name.clone(), variable.start.clone()?)))
            .collect();
        for (name, start) in variables {
            self.legal(instance.set(&name, start))?;
        }
        Ok(())
    }

    pub(super) fn initialize(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("fmi2SetupExperiment");
        self.legal(instance.setup_experiment(self.plan.start, self.stop, None))?;
        self.call("fmi2EnterInitializationMode", || instance.enter_initialization_mode())?;
        self.settings(instance, |variable| variable.causality == Causality::Input)?;
        self.journal.start("fmi2GetXXX in initialization mode");
        for name in outputs(instance) {
            let value = self.legal(instance.value(&name))?;
            self.finite(&name, &value);
        }
        self.call("fmi2ExitInitializationMode", || instance.exit_initialization_mode())
    }

    fn initialize_unset(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("an initialization without setting variables");
        let ready = instance
            .setup_experiment(self.plan.start, None, None)
            .and_then(|()| instance.enter_initialization_mode())
            .and_then(|()| instance.exit_initialization_mode());
        self.legal(ready)
    }

    /// Compares the start values with those of a separate instance whose variables are not set.
    fn fresh_starts(&mut self) -> Result<(), Stop> {
        let mut fresh = self.instance("fresh")?;
        self.initialize_unset(&mut fresh)?;
        self.starts(&mut fresh, "run-start")
    }

    fn starts(&mut self, instance: &mut Instance, rule: &'static str) -> Result<(), Stop> {
        self.journal.start("the comparison of start values");
        let variables: Vec<_> = self
            .description()
            .variables
            .iter()
            .filter(|variable| variable.effective_initial() != Some(Initial::Approx))
            .filter_map(|variable| Some((variable.name.clone(), variable.start.clone()?)))
            .collect();
        for (name, start) in variables {
            let value = self.legal(instance.value(&name))?;
            if !same(&start, &value) && self.mismatched.insert(name.clone()) {
                let (xml, binary) = (show(&start), show(&value));
                let message = format!(
                    "the start value of `{name}` is {xml} in the XML and {binary} in the binary"
                );
                let rule = if is_rounding(&start, &value) { "run-start-rounding" } else { rule };
                self.journal.found(rule, message);
            }
        }
        Ok(())
    }

    fn readings(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("fmi2GetXXX of every variable");
        let names: Vec<String> =
            self.description().variables.iter().map(|v| v.name.clone()).collect();
        for name in names {
            let value = self.legal(instance.value(&name))?;
            self.finite(&name, &value);
        }
        Ok(())
    }

    pub(super) fn finite(&mut self, name: &str, value: &Value) {
        if let Value::Real(value) = value
            && !value.is_finite()
        {
            self.journal.found("run-value", format!("`{name}` is {value}"));
        }
    }

    fn steps(&mut self, instance: &mut Instance) -> Result<Trajectory, Stop> {
        self.journal.start("fmi2DoStep");
        let trajectory = self.legal(drive(instance, self.plan, 0, self.plan.count))?;
        let names = outputs(instance);
        let not_finite = trajectory.iter().enumerate().find_map(|(step, values)| {
            let is_bad = |value: &Value| matches!(value, Value::Real(v) if !v.is_finite());
            let at = values.iter().position(is_bad)?;
            Some(format!("`{}` is {} after step {}", names[at], show(&values[at]), step + 1))
        });
        if let Some(message) = not_finite {
            self.journal.found("run-value", message);
        }
        let co_simulation = self.archive.model().co_simulation();
        // After a discarded step none of this is legal.
        if self.is_whole(&trajectory) {
            if co_simulation.max_output_derivative_order > 0 {
                self.output_derivatives(instance)?;
            }
            if co_simulation.provides_directional_derivative {
                self.directional_derivatives(instance)?;
            }
            if co_simulation.can_interpolate_inputs {
                self.input_derivatives(instance)?;
            }
        }
        Ok(trajectory)
    }

    fn is_whole(&self, trajectory: &Trajectory) -> bool {
        trajectory.len() == self.plan.count as usize
    }

    /// Sets the Real inputs to legal values other than their start values.
    pub(super) fn nudge(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        let inputs: Vec<(String, f64)> = self
            .description()
            .variables
            .iter()
            .filter(|v| v.causality == Causality::Input && v.kind == Kind::Real)
            .map(|v| {
                let start = v.start.as_ref().and_then(Value::as_number).unwrap_or(0.0);
                let above = start + 0.01;
                let value = if v.max.is_none_or(|max| above <= max) { above } else { start };
                (v.name.clone(), value)
            })
            .collect();
        for (name, value) in inputs {
            self.legal(instance.set(&name, value))?;
        }
        Ok(())
    }

    fn log(&mut self, instance: &mut Instance) {
        let mut unknown: Vec<String> = instance
            .take_log()
            .into_iter()
            .map(|line| line.category)
            .filter(|category| !category.is_empty())
            .filter(|category| {
                self.description().log_categories.iter().all(|known| known.name != *category)
            })
            .collect();
        unknown.sort();
        unknown.dedup();
        for category in unknown {
            let message = format!("logs with the category \"{category}\", which is not declared");
            self.journal.found("run-log-category", message);
        }
    }
}
