//! FMU states (section 2.1.8), if an FMU declares them.

use super::exercise::{ExerciseRun, Stop};
use super::trajectory::{difference, drive, outputs};
use steerwright_host::Instance;

impl ExerciseRun<'_> {
    /// Continues from a state twice, then from its bytes in another instance.
    pub(super) fn states(&mut self, instance: &mut Instance) -> Result<(), Stop> {
        let co_simulation = self.archive.model().co_simulation();
        let can_serialize = co_simulation.can_serialize_fmu_state;
        let only_once = co_simulation.can_be_instantiated_only_once_per_process;
        if !co_simulation.can_get_and_set_fmu_state {
            return Ok(());
        }
        self.call("fmi2Reset", || instance.reset())?;
        self.initialize(instance)?;
        let half = self.plan.count / 2;
        let rest = self.plan.count - half;
        if self.legal(drive(instance, self.plan, 0, half))?.len() < half as usize {
            return Ok(());
        }
        let state = self.call("fmi2GetFMUstate", || instance.get_state())?;
        let bytes = if can_serialize {
            self.journal.start("fmi2SerializeFMUstate");
            let bytes = instance.serialize_state(&state);
            Some(self.legal(bytes)?)
        } else {
            None
        };
        // Changed inputs reveal a state that is not restored.
        self.nudge(instance)?;
        let first = self.legal(drive(instance, self.plan, half, rest))?;
        self.call("fmi2SetFMUstate", || instance.set_state(&state))?;
        self.nudge(instance)?;
        let second = self.legal(drive(instance, self.plan, half, rest))?;
        let names = outputs(instance);
        if let Some(difference) = difference(&first, &second, &names) {
            self.differences.push(("run-state", format!("after fmi2SetFMUstate {difference}")));
        }
        let Some(bytes) = bytes.filter(|_| !only_once) else { return Ok(()) };
        let mut other = self.instance("restored")?;
        self.initialize(&mut other)?;
        let state = self.call("fmi2DeSerializeFMUstate", || {
            other.deserialize_state(&bytes, steerwright_host::Phase::StepComplete)
        })?;
        self.legal(other.set_state(&state))?;
        self.nudge(&mut other)?;
        let third = self.legal(drive(&mut other, self.plan, half, rest))?;
        if let Some(difference) = difference(&first, &third, &names) {
            let message = format!("in another instance, from the serialized state, {difference}");
            self.differences.push(("run-state", message));
        }
        Ok(())
    }
}
