//! The co-simulation loop: initialization, then steps of equal length, by a Gauss–Seidel or Jacobi coupling
//! (`docs/methods/co-simulation.md`). External signals hold from a communication point to the next.
//!
//! For each instance a step is one call to set its Reals, the step, and one call to read its Reals
//! (and one each for other kinds that it has): nothing is looked up or allocated.

use model_description::{Kind, Value};

use super::plan::{Assigned, Assignment, Coupling, Inputs, Member, Outputs, Plan};
use crate::Error;
use crate::instance::{Instance, Phase};

/// Computes the external signals from a communication point (s) on.
pub type Signals<'a> = &'a mut dyn FnMut(f64, &mut [f64]);

/// How the iteration in initialization mode ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settled {
    /// Passes over the system.
    pub passes: usize,
    /// Whether the last pass changed nothing. If it did, an algebraic loop did not converge.
    pub converged: bool,
}

/// The values of a run and the buffers of its calls.
///
/// [`Cosimulation::initialize`] starts a run, and may start another after it. The instances are those
/// of the plan's system, in its order, and the same in all calls of a run.
#[derive(Debug)]
pub struct Cosimulation<'p> {
    plan: &'p Plan,
    values: Vec<f64>,
    texts: Vec<String>,
    real: Vec<f64>,
    integer: Vec<i32>,
    boolean: Vec<bool>,
}

impl<'p> Cosimulation<'p> {
    /// Buffers for runs of a plan.
    #[must_use]
    pub fn new(plan: &'p Plan) -> Self {
        Self {
            plan,
            values: vec![0.0; plan.numbers],
            texts: vec![String::new(); plan.texts],
            real: Vec::new(),
            integer: Vec::new(),
            boolean: Vec::new(),
        }
    }

    /// The values at the last communication point, by their places ([`Plan::place`]). An input's
    /// value is that of its source, held by the input from here on.
    #[must_use]
    #[inline]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// From instantiation to the first communication point: parameters are set, and in
    /// initialization mode values are passed on in order until a pass changes nothing, n + 1 passes
    /// at most (n carry a value through any chain, one more shows that nothing changes). Instances
    /// that have run before are reset first.
    ///
    /// # Errors
    /// [`Error`] of an instance, or an output that is not finite.
    pub fn initialize(
        &mut self,
        instances: &mut [Instance],
        quantities: &[f64],
        signals: Signals<'_>,
    ) -> Result<Settled, Error> {
        let plan = self.plan;
        self.values.fill(0.0);
        self.texts.fill(String::new());
        for (instance, member) in instances.iter_mut().zip(&plan.members) {
            if instance.phase() != Phase::Instantiated {
                instance.reset()?;
            }
            for parameter in &member.parameters {
                assign(instance, parameter, quantities)?;
            }
            instance.setup_experiment(plan.grid.start, Some(plan.grid.stop), plan.tolerance)?;
            instance.enter_initialization_mode()?;
            for constant in &member.constants {
                assign(instance, constant, quantities)?;
            }
            for composed in &member.inputs.composed {
                if let Some(constant) = &composed.constant {
                    self.values[composed.from] = number(constant, quantities);
                }
            }
        }
        signals(plan.grid.start, &mut self.values[..plan.signals]);
        self.read_all(instances)?;
        let settled = self.settle(instances)?;
        for instance in &mut *instances {
            instance.exit_initialization_mode()?;
        }
        // Leaving initialization mode may change outputs (discrete ones tick at the start).
        self.read_all(instances)?;
        self.settle(instances)?;
        for member in &plan.members {
            check_finite(member, &self.values, plan.grid.start)?;
        }
        self.observe(instances)?;
        Ok(settled)
    }

    /// Passes values on in order until a pass changes nothing.
    fn settle(&mut self, instances: &mut [Instance]) -> Result<Settled, Error> {
        let limit = instances.len() + 1;
        for pass in 1..=limit {
            let before = (self.values.clone(), self.texts.clone());
            for (instance, member) in instances.iter_mut().zip(&self.plan.members) {
                self.write(instance, &member.inputs)?;
                self.read(instance, &member.outputs)?;
            }
            if before.0 == self.values && before.1 == self.texts {
                return Ok(Settled { passes: pass, converged: true });
            }
        }
        Ok(Settled { passes: limit, converged: false })
    }

    /// The step from communication point k to the next.
    ///
    /// # Errors
    /// [`Error`] of an instance, or an output that is not finite.
    pub fn step(
        &mut self,
        instances: &mut [Instance],
        k: usize,
        signals: Signals<'_>,
    ) -> Result<(), Error> {
        let plan = self.plan;
        let (time, step) = (plan.grid.time(k), plan.grid.step);
        match plan.coupling {
            Coupling::GaussSeidel => {
                for (instance, member) in instances.iter_mut().zip(&plan.members) {
                    self.write(instance, &member.inputs)?;
                    instance.do_step(time, step)?;
                    self.read(instance, &member.outputs)?;
                    check_finite(member, &self.values, time + step)?;
                }
            }
            Coupling::Jacobi => {
                for (instance, member) in instances.iter_mut().zip(&plan.members) {
                    self.write(instance, &member.inputs)?;
                }
                for instance in &mut *instances {
                    instance.do_step(time, step)?;
                }
                self.read_all(instances)?;
                for member in &plan.members {
                    check_finite(member, &self.values, time + step)?;
                }
            }
        }
        signals(plan.grid.time(k + 1), &mut self.values[..plan.signals]);
        self.observe(instances)
    }

    /// Reads the variables of communication points only, and composes the inputs for the record.
    pub(super) fn observe(&mut self, instances: &mut [Instance]) -> Result<(), Error> {
        for (instance, member) in instances.iter_mut().zip(&self.plan.members) {
            self.read(instance, &member.others)?;
            compose(&member.inputs, &mut self.values);
        }
        Ok(())
    }

    pub(super) fn read_all(&mut self, instances: &mut [Instance]) -> Result<(), Error> {
        for (instance, member) in instances.iter_mut().zip(&self.plan.members) {
            self.read(instance, &member.outputs)?;
        }
        Ok(())
    }

    #[inline]
    fn write(&mut self, instance: &mut Instance, inputs: &Inputs) -> Result<(), Error> {
        compose(inputs, &mut self.values);
        let values = &self.values;
        if !inputs.real.references.is_empty() {
            self.real.clear();
            self.real.extend(inputs.real.from.iter().map(|from| values[*from]));
            instance.set_real(&inputs.real.references, &self.real)?;
        }
        if !inputs.integer.references.is_empty() {
            self.integer.clear();
            self.integer.extend(inputs.integer.from.iter().map(|from| values[*from] as i32));
            instance.set_integer(&inputs.integer.references, &self.integer)?;
        }
        if !inputs.boolean.references.is_empty() {
            self.boolean.clear();
            self.boolean.extend(inputs.boolean.from.iter().map(|from| values[*from] != 0.0));
            instance.set_boolean(&inputs.boolean.references, &self.boolean)?;
        }
        if !inputs.string.references.is_empty() {
            let texts: Vec<&String> =
                inputs.string.from.iter().map(|from| &self.texts[*from]).collect();
            instance.set_string(&inputs.string.references, &texts)?;
        }
        Ok(())
    }

    #[inline]
    fn read(&mut self, instance: &mut Instance, outputs: &Outputs) -> Result<(), Error> {
        let reals = outputs.reals();
        let after = reals.end;
        if !outputs.real.is_empty() {
            instance.get_real(&outputs.real, &mut self.values[reals])?;
        }
        if !outputs.integer.is_empty() {
            self.integer.clear();
            self.integer.resize(outputs.integer.len(), 0);
            instance.get_integer(&outputs.integer, &mut self.integer)?;
            for (place, value) in self.values[after..].iter_mut().zip(&self.integer) {
                *place = f64::from(*value);
            }
        }
        if !outputs.boolean.is_empty() {
            self.boolean.clear();
            self.boolean.resize(outputs.boolean.len(), false);
            instance.get_boolean(&outputs.boolean, &mut self.boolean)?;
            let after = after + outputs.integer.len();
            for (place, value) in self.values[after..].iter_mut().zip(&self.boolean) {
                *place = f64::from(u8::from(*value));
            }
        }
        if !outputs.string.is_empty() {
            let texts = instance.get_string(&outputs.string)?;
            for (place, text) in self.texts[outputs.first_text..].iter_mut().zip(texts) {
                *place = text;
            }
        }
        Ok(())
    }
}

#[inline]
fn compose(inputs: &Inputs, values: &mut [f64]) {
    for composed in &inputs.composed {
        let of = &composed.composition;
        let added: f64 = of.added.iter().map(|signal| values[*signal]).sum();
        values[composed.to] = of.scale.apply(values[composed.from]) + added;
    }
}

/// Refuses values that are not finite, with the variable's name.
#[inline]
fn check_finite(member: &Member, values: &[f64], time: f64) -> Result<(), Error> {
    let reals = &values[member.outputs.reals()];
    match reals.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Error::NonFiniteOutput {
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
) -> Result<(), Error> {
    let reference = [assignment.reference];
    if let Assigned::Fixed(Value::String(text)) = &assignment.value {
        return instance.set_string(&reference, &[text]);
    }
    let value = number(&assignment.value, quantities);
    match assignment.kind {
        Kind::Real => instance.set_real(&reference, &[value]),
        Kind::Integer => instance.set_integer(&reference, &[value as i32]),
        Kind::Boolean => instance.set_boolean(&reference, &[value != 0.0]),
        // No quantity is a text.
        Kind::String => Ok(()),
    }
}

/// A value as a number; NaN for a text.
fn number(assigned: &Assigned, quantities: &[f64]) -> f64 {
    match assigned {
        Assigned::Quantity(index, convert) => convert.apply(quantities[*index]),
        Assigned::Fixed(Value::Boolean(value)) => f64::from(u8::from(*value)),
        Assigned::Fixed(value) => value.as_number().unwrap_or(f64::NAN),
    }
}
