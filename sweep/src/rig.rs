//! One closed loop of instances, run after run: the inner loop of a sweep.
//!
//! A step is, for each FMU, one call to set its Reals, the step, and one call to read its Reals
//! (and as many for Integers and Booleans, where it has any); buffers and value references stand
//! ready, and nothing is looked up or allocated. Initialization and the order of values within a
//! step are those of [`fmi2_host::System::run`], to the bit.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use fmi2_host::{Archive, Error as HostError, Instance, Kind, Master, Phase, Value};

use crate::disturbance::Signal;
use crate::metric::Memory;
use crate::plan::{Assigned, Assignment, Inputs, Member, Outputs, Plan};

/// Gets time and values at a communication point.
pub(crate) type See<'a> = &'a mut dyn FnMut(f64, &[f64]);

/// Steps between looks at whether to stop.
const STEPS_BETWEEN_LOOKS: usize = 256;

/// Why a run gave no results.
#[derive(Debug)]
pub(crate) enum Ended {
    /// An FMU refused.
    Failed(HostError),
    /// The user asked to stop.
    Stopped,
    /// It took longer than it may.
    TooLong,
}

/// A thread's instances and buffers.
pub(crate) struct Rig<'a> {
    plan: &'a Plan,
    archives: Vec<&'a Archive>,
    instances: Vec<Option<Instance>>,
    values: Vec<f64>,
    disturbed: Vec<f64>,
    signals: Vec<Signal>,
    memories: Vec<Memory>,
    real: Vec<f64>,
    integer: Vec<i32>,
    boolean: Vec<bool>,
    /// When a run is ended that has not come to its end, looked at between steps.
    pub(crate) deadline: Option<Instant>,
}

impl<'a> Rig<'a> {
    /// Buffers; instances are made when first needed.
    pub(crate) fn new(plan: &'a Plan, archives: Vec<&'a Archive>) -> Self {
        Self {
            plan,
            instances: plan.members.iter().map(|_| None).collect(),
            archives,
            values: vec![0.0; plan.slots],
            disturbed: vec![0.0; plan.disturbances.len()],
            signals: Vec::new(),
            memories: Vec::new(),
            real: Vec::new(),
            integer: Vec::new(),
            boolean: Vec::new(),
            deadline: None,
        }
    }

    /// Runs to the end and gives the metrics. `see` gets the values at every communication point.
    pub(crate) fn run(
        &mut self,
        run: usize,
        quantities: &[f64],
        stop: &AtomicBool,
        see: Option<See<'_>>,
    ) -> Result<Vec<f64>, Ended> {
        self.run_for(self.plan.steps, run, quantities, stop, see)
    }

    /// As [`Rig::run`], but ends after some steps.
    pub(crate) fn run_for(
        &mut self,
        steps: usize,
        run: usize,
        quantities: &[f64],
        stop: &AtomicBool,
        mut see: Option<See<'_>>,
    ) -> Result<Vec<f64>, Ended> {
        let result = self.steps(steps, run, quantities, stop, &mut see);
        if result.is_err() {
            // Whatever state they are in, it is not that of the next run.
            self.instances.fill_with(|| None);
        } else {
            for (instance, member) in self.instances.iter_mut().zip(&self.plan.members) {
                if !member.reused {
                    *instance = None;
                }
            }
        }
        match result {
            Ok(None) => {
                let of = |(memory, metric): (&Memory, &crate::metric::Metric)| {
                    memory.result(metric.kind)
                };
                Ok(self.memories.iter().zip(&self.plan.metrics).map(of).collect())
            }
            Ok(Some(ended)) => {
                self.instances.fill_with(|| None);
                Err(ended)
            }
            Err(error) => Err(Ended::Failed(error)),
        }
    }

    /// Why the end was not reached, if it was not.
    fn steps(
        &mut self,
        steps: usize,
        run: usize,
        quantities: &[f64],
        stop: &AtomicBool,
        see: &mut Option<See<'_>>,
    ) -> Result<Option<Ended>, HostError> {
        let plan = self.plan;
        let (step, draw) = (plan.step, plan.draw_of(run));
        self.values.fill(0.0);
        self.signals.clear();
        self.signals.extend(plan.disturbances.iter().map(|d| d.signal(quantities, draw, step)));
        self.memories.clear();
        self.memories.extend(plan.metrics.iter().map(|m| Memory::new(m, quantities)));
        self.initialize(quantities)?;
        self.observe(plan.start, see)?;
        for k in 0..steps.min(plan.steps) {
            let time = plan.time(k);
            match plan.master {
                Master::GaussSeidel => self.gauss_seidel(time)?,
                Master::Jacobi => self.jacobi(time)?,
            }
            let next = plan.time(k + 1);
            self.disturb(next);
            self.observe(next, see)?;
            if k % STEPS_BETWEEN_LOOKS == 0 {
                if stop.load(Ordering::Relaxed) {
                    return Ok(Some(Ended::Stopped));
                }
                if self.deadline.is_some_and(|deadline| Instant::now() > deadline) {
                    return Ok(Some(Ended::TooLong));
                }
            }
        }
        for instance in self.instances.iter_mut().flatten() {
            instance.terminate()?;
        }
        Ok(None)
    }

    fn initialize(&mut self, quantities: &[f64]) -> Result<(), HostError> {
        let plan = self.plan;
        for ((place, member), archive) in
            self.instances.iter_mut().zip(&plan.members).zip(&self.archives)
        {
            let instance = match place {
                Some(instance) => {
                    if instance.phase() != Phase::Instantiated {
                        instance.reset()?;
                    }
                    instance
                }
                None => place.insert(Instance::new(archive, &member.name)?),
            };
            for parameter in &member.parameters {
                assign(instance, parameter, quantities)?;
            }
        }
        for (instance, member) in self.instances.iter_mut().flatten().zip(&plan.members) {
            instance.setup_experiment(plan.start, Some(plan.stop()), None)?;
            instance.enter_initialization_mode()?;
            for constant in &member.constants {
                assign(instance, constant, quantities)?;
            }
            for composed in &member.inputs.composed {
                if let Some(constant) = &composed.constant {
                    self.values[composed.from] = match constant {
                        Assigned::Fixed(value) => number(value),
                        Assigned::Varied(index, convert) => convert.of(quantities[*index]),
                    };
                }
            }
        }
        self.disturb(plan.start);
        self.read_all()?;
        self.settle()?;
        for instance in self.instances.iter_mut().flatten() {
            instance.exit_initialization_mode()?;
        }
        // Leaving initialization mode may move outputs (discrete ones tick at the start).
        self.read_all()?;
        self.settle()?;
        for member in &plan.members {
            check_finite(member, &self.values, plan.start)?;
        }
        Ok(())
    }

    /// Passes values on in order until a pass changes nothing, n + 1 times at most.
    fn settle(&mut self) -> Result<(), HostError> {
        for _ in 0..=self.plan.members.len() {
            let before = self.values.clone();
            for index in 0..self.plan.members.len() {
                self.write(index)?;
                self.read(index)?;
            }
            if before == self.values {
                break;
            }
        }
        Ok(())
    }

    fn gauss_seidel(&mut self, time: f64) -> Result<(), HostError> {
        let plan = self.plan;
        for (index, member) in plan.members.iter().enumerate() {
            self.write(index)?;
            if let Some(instance) = &mut self.instances[index] {
                instance.do_step(time, plan.step)?;
            }
            self.read(index)?;
            check_finite(member, &self.values, time + plan.step)?;
        }
        Ok(())
    }

    fn jacobi(&mut self, time: f64) -> Result<(), HostError> {
        let plan = self.plan;
        for index in 0..plan.members.len() {
            self.write(index)?;
        }
        for instance in self.instances.iter_mut().flatten() {
            instance.do_step(time, plan.step)?;
        }
        self.read_all()?;
        for member in &plan.members {
            check_finite(member, &self.values, time + plan.step)?;
        }
        Ok(())
    }

    /// The disturbances from a communication point on.
    fn disturb(&mut self, time: f64) {
        for (value, signal) in self.disturbed.iter_mut().zip(&mut self.signals) {
            *value = signal.next(time, self.plan.step);
        }
    }

    /// Reads what is only looked at, and shows everything to metrics and trajectory.
    fn observe(&mut self, time: f64, see: &mut Option<See<'_>>) -> Result<(), HostError> {
        let plan = self.plan;
        for (instance, member) in self.instances.iter_mut().flatten().zip(&plan.members) {
            get(instance, &member.others, &mut self.values, &mut self.integer, &mut self.boolean)?;
            // An input's value is that of its sources now, as it holds from here on.
            compose(&member.inputs, &self.disturbed, &mut self.values);
        }
        for (memory, metric) in self.memories.iter_mut().zip(&plan.metrics) {
            memory.see(metric, &self.values, time, plan.step);
        }
        if let Some(see) = see {
            see(time, &self.values);
        }
        Ok(())
    }

    fn read_all(&mut self) -> Result<(), HostError> {
        (0..self.plan.members.len()).try_for_each(|index| self.read(index))
    }

    fn read(&mut self, index: usize) -> Result<(), HostError> {
        let Some(instance) = &mut self.instances[index] else { return Ok(()) };
        let outputs = &self.plan.members[index].outputs;
        get(instance, outputs, &mut self.values, &mut self.integer, &mut self.boolean)
    }

    fn write(&mut self, index: usize) -> Result<(), HostError> {
        let Some(instance) = &mut self.instances[index] else { return Ok(()) };
        let inputs = &self.plan.members[index].inputs;
        compose(inputs, &self.disturbed, &mut self.values);
        let values = &self.values;
        self.real.clear();
        self.real.extend(inputs.real_from.iter().map(|from| values[*from]));
        instance.set_real(&inputs.real, &self.real)?;
        if !inputs.integer.is_empty() {
            self.integer.clear();
            self.integer.extend(inputs.integer_from.iter().map(|from| values[*from] as i32));
            instance.set_integer(&inputs.integer, &self.integer)?;
        }
        if !inputs.boolean.is_empty() {
            self.boolean.clear();
            self.boolean.extend(inputs.boolean_from.iter().map(|from| values[*from] != 0.0));
            instance.set_boolean(&inputs.boolean, &self.boolean)?;
        }
        Ok(())
    }
}

fn compose(inputs: &Inputs, disturbed: &[f64], values: &mut [f64]) {
    for composed in &inputs.composed {
        let added: f64 = composed.disturbances.iter().map(|d| disturbed[*d]).sum();
        values[composed.slot] = composed.scale.of(values[composed.from]) + added;
    }
}

fn get(
    instance: &mut Instance,
    outputs: &Outputs,
    values: &mut [f64],
    integer: &mut Vec<i32>,
    boolean: &mut Vec<bool>,
) -> Result<(), HostError> {
    let reals = outputs.reals();
    let after = reals.end;
    instance.get_real(&outputs.real, &mut values[reals])?;
    if !outputs.integer.is_empty() {
        integer.clear();
        integer.resize(outputs.integer.len(), 0);
        instance.get_integer(&outputs.integer, integer)?;
        for (place, value) in values[after..].iter_mut().zip(&*integer) {
            *place = f64::from(*value);
        }
    }
    if !outputs.boolean.is_empty() {
        boolean.clear();
        boolean.resize(outputs.boolean.len(), false);
        instance.get_boolean(&outputs.boolean, boolean)?;
        let after = after + outputs.integer.len();
        for (place, value) in values[after..].iter_mut().zip(&*boolean) {
            *place = f64::from(u8::from(*value));
        }
    }
    Ok(())
}

/// Refuses values that have left the numbers, with the variable's name.
fn check_finite(member: &Member, values: &[f64], time: f64) -> Result<(), HostError> {
    let reals = &values[member.outputs.reals()];
    match reals.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(HostError::NonFiniteOutput {
            variable: format!("{}.{}", member.name, member.outputs.names[index]),
            value: reals[index],
            time,
        }),
    }
}

fn assign(
    instance: &mut Instance,
    assignment: &Assignment,
    quantities: &[f64],
) -> Result<(), HostError> {
    let reference = [assignment.reference];
    match &assignment.value {
        Assigned::Fixed(Value::Real(value)) => instance.set_real(&reference, &[*value]),
        Assigned::Fixed(Value::Integer(value)) => instance.set_integer(&reference, &[*value]),
        Assigned::Fixed(Value::Boolean(value)) => instance.set_boolean(&reference, &[*value]),
        Assigned::Fixed(Value::String(value)) => instance.set_string(&reference, &[value]),
        Assigned::Varied(index, convert) => {
            let value = convert.of(quantities[*index]);
            match assignment.kind {
                Kind::Real => instance.set_real(&reference, &[value]),
                Kind::Integer => instance.set_integer(&reference, &[value as i32]),
                Kind::Boolean => instance.set_boolean(&reference, &[value != 0.0]),
                // Refused when the study was resolved.
                Kind::String => Ok(()),
            }
        }
    }
}

/// A value as a number; texts are never asked for.
pub(crate) fn number(value: &Value) -> f64 {
    match value {
        Value::Real(value) => *value,
        Value::Integer(value) => f64::from(*value),
        Value::Boolean(value) => f64::from(u8::from(*value)),
        Value::String(_) => f64::NAN,
    }
}
