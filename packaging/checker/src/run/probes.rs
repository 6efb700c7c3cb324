//! Further runs, each for one requirement of the XML or the standard.

use super::exercise::{ExerciseRun, Stop};
use super::trajectory::{Trajectory, difference, drive, outputs, same};
use model_description::{Causality, Kind, Value};
use std::collections::BTreeSet;
use steerwright_host::{Error, Status};

/// The largest number of inputs that are perturbed one by one.
const MOST_INPUTS: usize = 200;

impl ExerciseRun<'_> {
    /// Runs all probes; `first` is the trajectory of an instance that ran alone.
    pub(super) fn probes(&mut self, first: &Trajectory) {
        let co_simulation = self.archive.model().co_simulation();
        let varies = co_simulation.can_handle_variable_communication_step_size;
        if !co_simulation.can_be_instantiated_only_once_per_process {
            let _ = self.interleaved(first);
        }
        if varies {
            let _ = self.half_step();
        }
        let _ = self.dependencies();
    }

    /// Alternates between two instances with different inputs: the first must behave as it did alone.
    fn interleaved(&mut self, first: &Trajectory) -> Result<(), Stop> {
        let (mut one, mut other) = (self.instance("one")?, self.instance("other")?);
        self.ready(&mut one)?;
        self.ready(&mut other)?;
        self.nudge(&mut one)?;
        let mut alternating = Trajectory::new();
        for point in 0..self.plan.count {
            self.journal.start("fmi2DoStep of two instances alternately");
            let values = self.legal(drive(&mut one, self.plan, point, 1))?;
            let driven = drive(&mut other, self.plan, point, 1);
            if values.is_empty() || self.legal(driven)?.is_empty() {
                break;
            }
            alternating.extend(values);
            self.settings(&mut other, |variable| variable.causality == Causality::Input)?;
        }
        if let Some(difference) = difference(first, &alternating, &outputs(&one)) {
            let message = format!("with a second instance that has other inputs {difference}");
            self.differences.push(("run-instances", message));
        }
        Ok(())
    }

    fn half_step(&mut self) -> Result<(), Stop> {
        let mut instance = self.instance("half")?;
        self.ready(&mut instance)?;
        self.journal.start("fmi2DoStep");
        if self.legal(drive(&mut instance, self.plan, 0, 1))?.is_empty() {
            return Ok(());
        }
        self.journal.start("fmi2DoStep of half the size");
        match instance.do_step(self.plan.time(1), self.plan.step / 2.0) {
            Err(Error::Step { status: Status::Discard, .. } | Error::Terminated { .. }) => {}
            Err(error @ Error::Step { .. }) => {
                self.journal.found("run-step-size", error.to_string());
            }
            other => self.legal(other)?,
        }
        Ok(())
    }

    /// Changes each continuous input separately: outputs that do not list it must not change.
    fn dependencies(&mut self) -> Result<(), Stop> {
        let mut instance = self.instance("perturbed")?;
        self.ready(&mut instance)?;
        self.nudge(&mut instance)?;
        // Two steps, since some models evaluate variables in the first step for the first time.
        self.journal.start("fmi2DoStep");
        if self.legal(drive(&mut instance, self.plan, 0, 2))?.len() < 2 {
            return Ok(());
        }
        self.journal.start("fmi2GetReal after a change of one input");
        let description = self.description();
        let real = |index: u32| {
            description.variable_at(index).filter(|v| v.kind == Kind::Real).map(|v| v.reference)
        };
        // The name of each output, and the references of its dependencies.
        let listed: Vec<(String, BTreeSet<u32>)> = description
            .outputs
            .iter()
            .filter_map(|unknown| {
                let name = description.variable_at(unknown.index)?.name.clone();
                let knowns = unknown.dependencies.as_ref()?;
                Some((name, knowns.iter().filter_map(|index| real(*index)).collect()))
            })
            .collect();
        let inputs = self.continuous(Causality::Input);
        let mut reported = BTreeSet::new();
        for (input, reference) in inputs.into_iter().take(MOST_INPUTS) {
            let before = self.values(&mut instance, &listed)?;
            // Outputs that change without a new input prove nothing.
            let still = self.values(&mut instance, &listed)?;
            let Some(value) = self.legal(instance.value(&input))?.as_number() else { continue };
            let variable = self.description().variable(&input);
            let above = value + 0.01;
            let fits = variable.and_then(|v| v.max).is_none_or(|max| above <= max);
            let set = instance.set(&input, if fits { above } else { value - 0.01 });
            self.legal(set)?;
            let after = self.values(&mut instance, &listed)?;
            let compared = listed.iter().zip(&before).zip(&still).zip(&after);
            for ((((output, knowns), before), still), after) in compared {
                if same(before, still)
                    && !knowns.contains(&reference)
                    && !same(before, after)
                    && reported.insert(output.clone())
                {
                    let message = format!(
                        "`{output}` changes at once with `{input}`, which it does not list as a dependency"
                    );
                    self.journal.found("run-dependency", message);
                }
            }
            self.legal(instance.set(&input, value))?;
        }
        Ok(())
    }

    fn values(
        &mut self,
        instance: &mut steerwright_host::Instance,
        listed: &[(String, BTreeSet<u32>)],
    ) -> Result<Vec<Value>, Stop> {
        let values: Result<Vec<_>, _> =
            listed.iter().map(|(name, _)| instance.value(name)).collect();
        self.legal(values)
    }

    fn again(&mut self) -> Result<(Trajectory, Vec<String>), Stop> {
        let mut instance = self.instance("again")?;
        self.ready(&mut instance)?;
        self.nudge(&mut instance)?;
        self.journal.start("fmi2DoStep");
        let trajectory = self.legal(drive(&mut instance, self.plan, 0, self.plan.count))?;
        Ok((trajectory, outputs(&instance)))
    }

    /// Reports runs that differ, unless two new instances differ as well: random behaviour is legal.
    pub(super) fn report_differences(&mut self) {
        let differences = std::mem::take(&mut self.differences);
        if differences.is_empty() {
            return;
        }
        if let (Ok((one, names)), Ok((other, _))) = (self.again(), self.again())
            && let Some(difference) = difference(&one, &other, &names)
        {
            let message = format!("for two new instances with the same inputs {difference}");
            return self.journal.found("run-nondeterministic", message);
        }
        for (rule, message) in differences {
            self.journal.found(rule, message);
        }
    }
}
