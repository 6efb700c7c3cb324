//! The experiment that the FMU recommends, to its stop time or as far as the time limit allows.

use super::exercise::{ExerciseRun, Stop};
use super::trajectory::{outputs, steps_to_stop};
use model_description::{Kind, Value};
use std::time::Instant;
use steerwright_host::{Error, Instance, Status};

/// Why a run ended where it did.
enum End {
    Whole,
    NoStopTime,
    TimeLimit,
    Discarded,
}

impl ExerciseRun<'_> {
    /// Runs the whole experiment, unless the first run was as long, and states the time that was run.
    pub(super) fn experiment(&mut self) -> Result<(), Stop> {
        let Some(steps) = self.first_steps else { return Ok(()) };
        let total = steps_to_stop(self.description(), self.plan);
        let (steps, end) = match total {
            _ if steps < self.plan.count => (steps, End::Discarded),
            None => (steps, End::NoStopTime),
            Some(total) if total <= steps => (steps, End::Whole),
            Some(total) => self.whole_experiment(total)?,
        };
        let why = match (end, total) {
            (End::Whole, _) => "the whole DefaultExperiment".to_owned(),
            (End::TimeLimit, Some(total)) => {
                format!("the time limit ends the run, the stop time is after {total} steps")
            }
            (End::Discarded, _) => {
                "the FMU discards the next step or ends the simulation".to_owned()
            }
            (End::NoStopTime | End::TimeLimit, _) => {
                "DefaultExperiment has no stop time".to_owned()
            }
        };
        let (start, stop, step) = (self.plan.start, self.plan.time(steps), self.plan.step);
        let message = format!("ran from {start} s to {stop} s in {steps} steps of {step} s: {why}");
        self.journal.found("run-span", message);
        Ok(())
    }

    /// The steps that were made, and why there are no more.
    fn whole_experiment(&mut self, total: u32) -> Result<(u32, End), Stop> {
        self.stop = Some(self.plan.time(total));
        let mut instance = self.instance("whole")?;
        self.ready(&mut instance)?;
        let reals: Vec<(String, u32)> = instance
            .model()
            .variables()
            .iter()
            .filter(|v| v.kind == Kind::Real && v.causality == model_description::Causality::Output)
            .map(|v| (v.name.clone(), v.reference))
            .collect();
        let references: Vec<u32> = reals.iter().map(|(_, reference)| *reference).collect();
        let mut values = vec![0.0; reals.len()];
        let mut longest = std::time::Duration::ZERO;
        let mut end = (total, End::Whole);
        for point in 0..total {
            let begun = Instant::now();
            // A step that takes twice as long as any before still ends in time.
            if begun + 2 * longest > self.deadline {
                end = (point, End::TimeLimit);
                break;
            }
            let time = self.plan.time(point);
            self.journal.progress(&format!("fmi2DoStep from t = {time} s"));
            match instance.do_step(time, self.plan.step) {
                Err(Error::Step { status: Status::Discard, .. } | Error::Terminated { .. }) => {
                    end = (point, End::Discarded);
                    break;
                }
                other => self.legal(other)?,
            }
            if !references.is_empty() {
                let read = instance.get_real(&references, &mut values);
                self.legal(read)?;
            }
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                let (name, value) = (&reals[index].0, values[index]);
                let time = self.plan.time(point + 1);
                self.journal.found("run-value", format!("`{name}` is {value} at t = {time} s"));
                return Err(Stop);
            }
            longest = longest.max(begun.elapsed());
        }
        self.last_readings(&mut instance)?;
        self.call("fmi2Terminate", || instance.terminate())?;
        self.journal.start("fmi2FreeInstance");
        Ok(end)
    }

    fn last_readings(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        self.journal.start("fmi2GetXXX of the outputs after the last step");
        for name in outputs(instance) {
            let value: Value = self.legal(instance.value(&name))?;
            self.finite(&name, &value);
        }
        Ok(())
    }
}
