//! The co-simulation master: initialization, then steps of equal length.
//!
//! Communication points are t_k = start + k·step, computed, never accumulated. A step from t_k to
//! t_{k+1} is, for the instances i = 1 … n in their order,
//!
//! - Gauss–Seidel: for each i in turn, set its inputs from the most recent outputs (those of
//!   instances before it are at t_{k+1}, the others at t_k), step it, read its outputs. In the
//!   order plant, path, PID the PID steps with inputs at t_{k+1}: the loop has no delay.
//! - Jacobi: set all inputs from the outputs at t_k, step all, read all outputs. Each connection
//!   delays by one step.
//!
//! Values of an input table hold from the communication point on. See Kübler and Schiehlen, *Two
//! methods of simulator coupling* (2000), for the two schemes.

use model_description::Causality;

use super::recording::Recording;
use super::wiring::{Wiring, recorded_variables};
use super::{InputTable, System};
use crate::{Error, Instance, Phase};

/// More communication points than this are taken for a slip.
const MAX_STEPS: f64 = 1e8;

/// How a step of the system is put together from steps of its instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Master {
    /// One instance after the other, each with the most recent values.
    #[default]
    GaussSeidel,
    /// All instances with the values of the last communication point.
    Jacobi,
}

impl System {
    /// The names of what a run records, `instance.variable`, in order.
    ///
    /// # Errors
    /// [`Error`] where an instance lacks what is to be recorded.
    pub fn recorded(&self) -> Result<Vec<String>, Error> {
        let variables = recorded_variables(self)?;
        Ok(variables.into_iter().map(|(index, name)| self.path(index, &name)).collect())
    }

    /// Runs the system from `start` to `stop` by steps of `step`, all in s, and terminates the
    /// instances. Run again, they are reset first.
    pub fn run(
        &mut self,
        master: Master,
        start: f64,
        stop: f64,
        step: f64,
    ) -> Result<Recording, Error> {
        let steps = grid(start, stop, step)?;
        let time = |k: usize| start + k as f64 * step;
        let mut wiring = Wiring::new(self, start)?;
        // The last point may lie an ulp past the stop time that was asked for.
        let (initial_passes, initially_settled) =
            wiring.initialize(self, start, stop.max(time(steps)), step)?;
        let mut recording = wiring.recording(initial_passes, initially_settled);
        wiring.record(&mut self.instances, start, &mut recording)?;
        for k in 0..steps {
            match master {
                Master::GaussSeidel => wiring.gauss_seidel(&mut self.instances, time(k), step)?,
                Master::Jacobi => wiring.jacobi(&mut self.instances, time(k), step)?,
            }
            wiring.feed(self.table.as_ref(), time(k + 1), step);
            wiring.record(&mut self.instances, time(k + 1), &mut recording)?;
        }
        for instance in &mut self.instances {
            instance.terminate()?;
        }
        Ok(recording)
    }
}

/// The number of steps of a time grid, all in s; refuses grids that are no whole steps, or more than
/// 100 million.
pub fn grid(start: f64, stop: f64, step: f64) -> Result<usize, Error> {
    let bad = |reason: &'static str| Err(Error::BadGrid { start, stop, step, reason });
    if !(start.is_finite() && stop.is_finite() && step.is_finite()) {
        return bad("a time is not finite");
    }
    if step <= 0.0 {
        return bad("the step is not above 0");
    }
    if stop <= start {
        return bad("the stop is not after the start");
    }
    let steps = (stop - start) / step;
    if steps > MAX_STEPS {
        return bad("more than 100 million steps");
    }
    if steps.round() < 1.0 || (steps - steps.round()).abs() > 1e-6 {
        return bad("the stop is not a whole number of steps after the start");
    }
    if start + step == start || stop - step == stop {
        return bad("the step vanishes beside the times");
    }
    Ok(steps.round() as usize)
}

impl Wiring {
    /// From instantiation to the first communication point: parameters are set, and in
    /// initialization mode values are passed on in order until a pass changes nothing, n + 1 passes
    /// at most (n carry a value through any chain, one more sees that all is said). Gives the passes
    /// and whether the last changed nothing.
    fn initialize(
        &mut self,
        system: &mut System,
        start: f64,
        stop: f64,
        step: f64,
    ) -> Result<(usize, bool), Error> {
        for instance in &mut system.instances {
            if instance.phase() != Phase::Instantiated {
                instance.reset()?;
            }
        }
        set(system, |causality| causality != Causality::Input)?;
        for instance in &mut system.instances {
            instance.setup_experiment(start, Some(stop), system.tolerance)?;
            instance.enter_initialization_mode()?;
        }
        set(system, |causality| causality == Causality::Input)?;
        self.feed(system.table.as_ref(), start, step);
        self.read_outputs(&mut system.instances)?;
        let settled = self.settle(&mut system.instances)?;
        for instance in &mut system.instances {
            instance.exit_initialization_mode()?;
        }
        // Leaving initialization mode may move outputs (discrete ones tick at the start).
        self.read_outputs(&mut system.instances)?;
        self.settle(&mut system.instances)?;
        self.check_finite(&system.instances, start)?;
        Ok(settled)
    }

    fn settle(&mut self, instances: &mut [Instance]) -> Result<(usize, bool), Error> {
        let limit = instances.len() + 1;
        for pass in 1..=limit {
            let mut changed = false;
            for (member, instance) in self.members.iter_mut().zip(instances.iter_mut()) {
                member.inputs.write(instance, &self.signals)?;
                changed |= member.outputs.read(instance, &mut self.signals)?;
            }
            if !changed {
                return Ok((pass, true));
            }
        }
        Ok((limit, false))
    }

    fn gauss_seidel(
        &mut self,
        instances: &mut [Instance],
        time: f64,
        step: f64,
    ) -> Result<(), Error> {
        for (member, instance) in self.members.iter_mut().zip(instances) {
            member.inputs.write(instance, &self.signals)?;
            instance.do_step(time, step)?;
            member.outputs.read(instance, &mut self.signals)?;
            member.outputs.check_finite(instance, &self.signals, time + step)?;
        }
        Ok(())
    }

    fn jacobi(&mut self, instances: &mut [Instance], time: f64, step: f64) -> Result<(), Error> {
        for (member, instance) in self.members.iter_mut().zip(&mut *instances) {
            member.inputs.write(instance, &self.signals)?;
        }
        for instance in &mut *instances {
            instance.do_step(time, step)?;
        }
        self.read_outputs(instances)?;
        self.check_finite(instances, time + step)
    }

    fn read_outputs(&mut self, instances: &mut [Instance]) -> Result<(), Error> {
        for (member, instance) in self.members.iter_mut().zip(instances) {
            member.outputs.read(instance, &mut self.signals)?;
        }
        Ok(())
    }

    fn check_finite(&self, instances: &[Instance], time: f64) -> Result<(), Error> {
        for (member, instance) in self.members.iter().zip(instances) {
            member.outputs.check_finite(instance, &self.signals, time)?;
        }
        Ok(())
    }

    /// Puts the table's values at a time into their places.
    fn feed(&mut self, table: Option<&InputTable>, time: f64, step: f64) {
        let Some(table) = table else { return };
        // k·step may fall an ulp short of the time that the table states.
        let due = time + 1e-6 * step;
        while table.times().get(self.row + 1).is_some_and(|next| *next <= due) {
            self.row += 1;
        }
        let row = table.row(self.row);
        for (column, slot) in &self.feeds {
            self.signals.put(*slot, row[*column]);
        }
    }

    fn recording(&self, initial_passes: usize, initially_settled: bool) -> Recording {
        Recording {
            names: self.recorded.iter().map(|(name, _, _)| name.clone()).collect(),
            units: self.recorded.iter().map(|(_, unit, _)| unit.clone()).collect(),
            times: Vec::new(),
            rows: Vec::new(),
            initial_passes,
            initially_settled,
        }
    }

    fn record(
        &mut self,
        instances: &mut [Instance],
        time: f64,
        recording: &mut Recording,
    ) -> Result<(), Error> {
        for (member, instance) in self.members.iter_mut().zip(instances) {
            member.others.read(instance, &mut self.signals)?;
        }
        recording.times.push(time);
        let values = self.recorded.iter().map(|(_, _, slot)| self.signals.number(*slot));
        recording.rows.push(values.collect());
        Ok(())
    }
}

/// Sets the values that were asked for, of variables of some causalities.
fn set(system: &mut System, of: impl Fn(Causality) -> bool) -> Result<(), Error> {
    for setting in &system.settings {
        let instance = &mut system.instances[setting.instance];
        if of(instance.variable(&setting.variable)?.causality) {
            instance.set(&setting.variable, setting.value.clone())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_whole_steps() {
        assert_eq!(grid(0.0, 1.0, 0.1).unwrap(), 10);
        assert_eq!(grid(5.0, 5.3, 0.1).unwrap(), 3);
        assert_eq!(grid(0.0, 20.0, 1.0 / 60.0).unwrap(), 1200);
        for (start, stop, step) in [
            (0.0, 1.0, 0.3),
            (0.0, 1.0, 0.0),
            (0.0, 1.0, -0.1),
            (1.0, 1.0, 0.1),
            (0.0, f64::NAN, 0.1),
            (0.0, f64::INFINITY, 0.1),
            (0.0, 1.0, 2.0),
            (0.0, 1e9, 0.1),
            (1e20, 1e20 + 1e6, 1.0),
        ] {
            assert!(grid(start, stop, step).is_err(), "{start} {stop} {step}");
        }
    }
}
