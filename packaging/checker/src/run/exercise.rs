//! What an FMU is put through: each phase of the state machine, with the calls that are legal there
//! (section 4.2.4), and comparisons of what it answers.

use super::journal::Journal;
use super::reference;
use super::trajectory::{Plan, Trajectory, difference, drive, is_rounding, outputs, same, show};
use host::{Archive, Error, Instance, InstanceOptions};
use model_description::{Causality, Initial, Kind, ModelDescription, Value, Variability};
use std::collections::BTreeSet;
use std::path::Path;

/// A GUID that no FMU has.
const WRONG_GUID: &str = "ffffffff-0000-4000-8000-00000000dead";

/// Everything, from loading to unloading.
pub(super) fn all(fmu: &Path, journal: &mut Journal) {
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
        Err(error @ Error::NoBinary { .. }) => {
            return journal.found("run-skipped", error.to_string());
        }
        Err(error @ Error::WrongVersion { .. }) => {
            return journal.found("run-version", error.to_string());
        }
        Err(error) => return refused(&archive, journal, "run-load", &error),
    }
    let plan = Plan::of(archive.model().description());
    journal.runs(binary(&archive));
    let mut run = Run {
        archive: &archive,
        plan,
        journal,
        mismatched: BTreeSet::new(),
        differences: Vec::new(),
    };
    let is_alive = run.life();
    run.journal.start("fmi2FreeInstance(NULL)");
    if let Err(error) = archive.free_null_instance() {
        run.journal.found("run-null", error.to_string());
    }
    run.wrong_guid();
    // A failed instantiation was reported.
    if is_alive {
        reference::replay(&archive, run.journal);
    }
    journal.start("unloading the binary");
    drop(archive);
}

/// The entry of the binary that is loaded here.
fn binary(archive: &Archive) -> Option<String> {
    let name = host::binary_name(&archive.model().co_simulation().model_identifier);
    host::platform_folders()
        .iter()
        .map(|folder| format!("binaries/{folder}/{name}"))
        .find(|entry| archive.folder().join(entry).is_file())
}

/// Reports an error, unless the FMU needs a tool that may not be installed.
fn refused(archive: &Archive, journal: &mut Journal, rule: &'static str, error: &Error) {
    let message = error.to_string();
    if archive.model().co_simulation().needs_execution_tool {
        let message = format!("it needs a tool (needsExecutionTool) that is not here: {message}");
        journal.found("run-skipped", message);
    } else {
        journal.found(rule, message);
    }
}

pub(super) struct Run<'a> {
    pub(super) archive: &'a Archive,
    pub(super) plan: Plan,
    pub(super) journal: &'a mut Journal,
    /// Variables whose start values were reported as wrong.
    mismatched: BTreeSet<String>,
    /// Rules and messages of runs that should have been the same, reported once it is clear whether any
    /// two runs are.
    pub(super) differences: Vec<(&'static str, String)>,
}

/// A rule is broken so that going on with the instance makes no sense.
pub(super) struct Stop;

impl Run<'_> {
    pub(super) fn description(&self) -> &ModelDescription {
        self.archive.model().description()
    }

    /// Any refusal of a legal call is a finding that ends the exercise.
    pub(super) fn legal<T>(&mut self, result: Result<T, Error>) -> Result<T, Stop> {
        result.map_err(|error| {
            match error {
                Error::Instantiate { .. } => {
                    refused(self.archive, self.journal, "run-instantiate", &error);
                }
                Error::Call { .. }
                | Error::Step { .. }
                | Error::Fatal { .. }
                | Error::NullResult { .. } => {
                    self.journal.found("run-call", format!("a legal call fails: {error}"));
                }
                // Our own host made no call: that is no finding about the FMU.
                error => {
                    self.journal.found("not-examined", format!("the rest of the run: {error}"))
                }
            }
            Stop
        })
    }

    pub(super) fn instance(&mut self, name: &str) -> Result<Instance, Stop> {
        self.journal.start("fmi2Instantiate");
        let options = InstanceOptions { logging_on: true, visible: false };
        let made = Instance::with_options(self.archive, name, options);
        self.legal(made)
    }

    fn wrong_guid(&mut self) {
        self.journal.start("fmi2Instantiate with a wrong GUID");
        let made = Instance::with_guid(self.archive, "check", Default::default(), WRONG_GUID);
        if made.is_ok() {
            self.journal.found("run-guid", "instantiated with a GUID other than the XML's");
        }
        self.journal.start("fmi2FreeInstance after a wrong GUID");
    }

    /// Simulations with everything in them; findings state where they stop. Returns whether there was
    /// an instance at all.
    fn life(&mut self) -> bool {
        if self.fresh_starts().is_err() {
            return false;
        }
        let Ok(mut instance) = self.instance("check") else { return false };
        let lived = self.live(&mut instance);
        self.log(&mut instance);
        self.journal.start("fmi2FreeInstance");
        drop(instance);
        // A run with a discarded step is no measure for others.
        if let Ok(first) = lived
            && self.is_whole(&first)
        {
            self.probes(&first);
        }
        self.tell_differences();
        true
    }

    fn live(&mut self, instance: &mut Instance) -> Result<Trajectory, Stop> {
        self.ready(instance)?;
        self.readings(instance)?;
        self.nudge(instance)?;
        let first = self.steps(instance)?;
        // After a discarded step nothing may be set.
        if self.is_whole(&first) {
            self.settings(instance, |variable| {
                variable.causality == Causality::Input
                    || variable.causality == Causality::Parameter
                        && variable.variability == Variability::Tunable
            })?;
        }
        self.journal.start("fmi2Terminate");
        let terminated = instance.terminate();
        self.legal(terminated)?;
        self.journal.start("fmi2GetXXX after fmi2Terminate");
        self.readings(instance)?;

        self.journal.start("fmi2Reset after fmi2Terminate");
        let reset = instance.reset();
        self.legal(reset)?;
        self.untouched(instance)?;
        self.starts(instance, "run-reset")?;
        self.journal.start("fmi2Reset");
        let reset = instance.reset();
        self.legal(reset)?;
        self.ready(instance)?;
        self.nudge(instance)?;
        let second = self.steps(instance)?;
        if let Some(difference) = difference(&first, &second, &outputs(instance)) {
            self.differences.push(("run-reset", format!("after fmi2Reset {difference}")));
        }
        self.states(instance)?;
        Ok(first)
    }

    /// Start values set and initialized, the same in all runs that are compared.
    pub(super) fn ready(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.settings(instance, |variable| {
            matches!(variable.effective_initial(), Some(Initial::Exact | Initial::Approx))
                && variable.variability != Variability::Constant
        })?;
        self.initialize(instance)
    }

    /// Sets variables to their own start values, which changes nothing.
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
            let set = instance.set(&name, start);
            self.legal(set)?;
        }
        Ok(())
    }

    pub(super) fn initialize(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("fmi2SetupExperiment");
        let done = instance.setup_experiment(self.plan.start, None, None);
        self.legal(done)?;
        self.journal.start("fmi2EnterInitializationMode");
        let done = instance.enter_initialization_mode();
        self.legal(done)?;
        self.settings(instance, |variable| variable.causality == Causality::Input)?;
        self.journal.start("fmi2GetXXX in initialization mode");
        for name in outputs(instance) {
            let value = instance.value(&name);
            let value = self.legal(value)?;
            self.finite(&name, &value);
        }
        self.journal.start("fmi2ExitInitializationMode");
        let done = instance.exit_initialization_mode();
        self.legal(done)
    }

    /// An initialization in which nothing is set.
    fn untouched(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("an initialization in which nothing is set");
        let ready = instance
            .setup_experiment(self.plan.start, None, None)
            .and_then(|()| instance.enter_initialization_mode())
            .and_then(|()| instance.exit_initialization_mode());
        self.legal(ready)
    }

    /// Start values against those of a separate instance in which nothing was set.
    fn fresh_starts(&mut self) -> Result<(), Stop> {
        let mut fresh = self.instance("fresh")?;
        self.untouched(&mut fresh)?;
        self.starts(&mut fresh, "run-start")
    }

    /// Start values of the XML against what an untouched instance answers.
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
            let value = instance.value(&name);
            let value = self.legal(value)?;
            if !same(&start, &value) && self.mismatched.insert(name.clone()) {
                let (xml, binary) = (show(&start), show(&value));
                let message =
                    format!("`{name}` starts at {xml} in the XML and at {binary} in fact");
                let rule = if is_rounding(&start, &value) { "run-start-rounding" } else { rule };
                self.journal.found(rule, message);
            }
        }
        Ok(())
    }

    /// Every variable can be read at a communication point.
    fn readings(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("fmi2GetXXX of every variable");
        let names: Vec<String> =
            self.description().variables.iter().map(|v| v.name.clone()).collect();
        for name in names {
            let value = instance.value(&name);
            let value = self.legal(value)?;
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
        let driven = drive(instance, self.plan, 0, self.plan.count);
        let trajectory = self.legal(driven)?;
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
        let (interpolates, order, directional) = (
            co_simulation.can_interpolate_inputs,
            co_simulation.max_output_derivative_order,
            co_simulation.provides_directional_derivative,
        );
        // A discarded step leaves the instance where none of this is legal.
        if self.is_whole(&trajectory) {
            if order > 0 {
                self.output_derivatives(instance)?;
            }
            if directional {
                self.directional_derivatives(instance)?;
            }
            if interpolates {
                self.input_derivatives(instance)?;
            }
        }
        Ok(trajectory)
    }

    /// Whether no step was discarded.
    fn is_whole(&self, trajectory: &Trajectory) -> bool {
        trajectory.len() == self.plan.count as usize
    }

    /// Gives the continuous inputs another legal value than their start.
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
            let set = instance.set(&name, value);
            self.legal(set)?;
        }
        Ok(())
    }

    /// Categories of what was logged against those of the XML.
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
