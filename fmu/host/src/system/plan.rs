//! A system compiled into value references and places: all that a run needs, without names.
//!
//! Every number that passes between instances, or that is read at communication points, has a place
//! in one array of floats: Booleans are 1 and 0, and every Integer of FMI 2.0 is a float exactly. The
//! first places are those of the external signals. The Real variables that are read of an instance
//! lie next to each other, so that `fmi2GetReal` writes straight into the array. Strings have an
//! array of their own.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

use model_description::{Causality, Kind, Value, Variable};

use super::System;
use crate::Error;

/// A variable by the index of its instance and its name.
pub type Key = (usize, String);

/// `factor · value + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear {
    /// Unit of the result over that of the value.
    pub factor: f64,
    /// In the unit of the result.
    pub offset: f64,
}

impl Linear {
    /// The value itself.
    pub const IDENTITY: Self = Self { factor: 1.0, offset: 0.0 };

    /// The result for a value.
    #[must_use]
    #[inline]
    pub fn apply(self, value: f64) -> f64 {
        self.factor * value + self.offset
    }

    /// This after another.
    #[must_use]
    pub fn after(self, first: Self) -> Self {
        Self { factor: self.factor * first.factor, offset: self.apply(first.offset) }
    }

    /// From the result back to the value.
    #[must_use]
    pub fn inverse(self) -> Self {
        Self { factor: 1.0 / self.factor, offset: -self.offset / self.factor }
    }
}

/// The value that a variable is set to at the start of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Assigned {
    /// The same in every run.
    Fixed(Value),
    /// One of the run's quantities, by its index, converted to the variable's unit.
    Quantity(usize, Linear),
}

/// How the value of an input follows from its source: scaled, with signals added.
#[derive(Debug, Clone, PartialEq)]
pub struct Composition {
    /// Applied to the source, or to the constant of an input without a connection.
    pub scale: Linear,
    /// The external signals that are added, by their indices.
    pub added: Vec<usize>,
}

/// Options of a plan, besides the instances and connections of the system.
#[derive(Debug, Default)]
pub struct PlanOptions {
    /// Variables to read at communication points, besides the connected outputs.
    pub read: Vec<Key>,
    /// Values to set at the start of a run.
    pub assigned: HashMap<Key, Assigned>,
    /// The number of external signals, computed by the caller at each communication point.
    pub signals: usize,
    /// Inputs that an external signal feeds, with its index.
    pub fed_by_signals: HashMap<Key, usize>,
    /// Real inputs that are more than a copy of their source.
    pub composed: BTreeMap<Key, Composition>,
}

/// How a step of the system consists of the steps of its instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coupling {
    /// One instance after the other, each with the most recent values.
    #[default]
    GaussSeidel,
    /// All instances with the values of the last communication point.
    Jacobi,
}

/// The communication points `start + k·step`, k = 0 … `steps`, in s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// The first point.
    pub start: f64,
    /// The stop time that the FMUs get; not before the last point.
    pub stop: f64,
    /// The distance of the points.
    pub step: f64,
    /// The number of steps.
    pub steps: usize,
}

impl Grid {
    /// A communication point; computed, never accumulated.
    #[must_use]
    #[inline]
    pub fn time(&self, k: usize) -> f64 {
        self.start + k as f64 * self.step
    }
}

/// A compiled system. It is shared by all [`super::Cosimulation`]s of it.
#[derive(Debug)]
pub struct Plan {
    /// How the instances are coupled within a step.
    pub coupling: Coupling,
    /// The communication points.
    pub grid: Grid,
    pub(super) members: Vec<Member>,
    pub(super) tolerance: Option<f64>,
    pub(super) numbers: usize,
    pub(super) texts: usize,
    /// The external signals' number; their places are the first.
    pub(super) signals: usize,
    /// Places of the variables read; a fed input has the place of its source.
    places: HashMap<Key, usize>,
}

/// The inputs and outputs of one instance.
#[derive(Debug, Default)]
pub(super) struct Member {
    pub(super) name: String,
    /// Set before initialization.
    pub(super) parameters: Vec<Assignment>,
    /// Inputs without a source, set in initialization mode.
    pub(super) constants: Vec<Assignment>,
    /// Set in every pass and step.
    pub(super) inputs: Inputs,
    /// Outputs, read in every pass and step.
    pub(super) outputs: Outputs,
    /// Other variables, read only at communication points.
    pub(super) others: Outputs,
}

/// A value that is set.
#[derive(Debug)]
pub(super) struct Assignment {
    pub(super) reference: u32,
    pub(super) kind: Kind,
    pub(super) value: Assigned,
}

/// Inputs of one kind: their references, and the places of their values.
#[derive(Debug, Default)]
pub(super) struct Lane {
    pub(super) references: Vec<u32>,
    pub(super) from: Vec<usize>,
}

/// Inputs of one instance.
#[derive(Debug, Default)]
pub(super) struct Inputs {
    pub(super) real: Lane,
    pub(super) integer: Lane,
    pub(super) boolean: Lane,
    /// Taken from the array of texts.
    pub(super) string: Lane,
    /// Computed first.
    pub(super) composed: Vec<Composed>,
}

/// A composed input with its places.
#[derive(Debug)]
pub(super) struct Composed {
    /// The place of the input's value.
    pub(super) to: usize,
    /// The place of its source, or of its constant.
    pub(super) from: usize,
    pub(super) composition: Composition,
    /// The value of an input without a connection.
    pub(super) constant: Option<Assigned>,
}

/// Variables of one instance that are read: their references by kind, and the places of their values.
#[derive(Debug, Default)]
pub(super) struct Outputs {
    pub(super) real: Vec<u32>,
    pub(super) integer: Vec<u32>,
    pub(super) boolean: Vec<u32>,
    pub(super) string: Vec<u32>,
    /// The place of the first Real; Integers follow the Reals, Booleans the Integers.
    pub(super) first: usize,
    /// The place of the first text.
    pub(super) first_text: usize,
    /// The names of the Reals, for messages.
    pub(super) names: Vec<String>,
}

impl Outputs {
    pub(super) fn reals(&self) -> Range<usize> {
        self.first..self.first + self.real.len()
    }

    fn add(&mut self, variable: &Variable) {
        match variable.kind {
            Kind::Real => {
                self.real.push(variable.reference);
                self.names.push(variable.name.clone());
            }
            Kind::Integer => self.integer.push(variable.reference),
            Kind::Boolean => self.boolean.push(variable.reference),
            Kind::String => self.string.push(variable.reference),
        }
    }
}

impl Plan {
    /// The place of a variable's value among [`super::Cosimulation::values`]; `None` for a String
    /// and for variables that are not read.
    #[must_use]
    pub fn place(&self, variable: &Key) -> Option<usize> {
        self.places.get(variable).copied()
    }
}

impl System {
    /// Compiles the system with its connections. Settings, table and recorded variables of the
    /// system are those of [`System::run`] and have no part in it.
    ///
    /// # Errors
    /// [`Error`] where a connection or an option names an instance or a variable that is not there.
    pub fn plan(
        &self,
        coupling: Coupling,
        grid: Grid,
        options: &PlanOptions,
    ) -> Result<Plan, Error> {
        let mut composed = options.composed.clone();
        for ((instance, input), scale) in &self.scales {
            let key = (self.index(instance)?, input.clone());
            let copy = Composition { scale: Linear::IDENTITY, added: Vec::new() };
            let composition = composed.entry(key).or_insert(copy);
            composition.scale = composition.scale.after(*scale);
        }
        let mut sources: HashMap<Key, Key> = HashMap::new();
        let mut read: HashSet<Key> = HashSet::new();
        for c in &self.connections {
            let source = (self.index(&c.from)?, c.output.clone());
            sources.insert((self.index(&c.to)?, c.input.clone()), source.clone());
            read.insert(source);
        }
        for (index, name) in &options.read {
            self.instances[*index].variable(name)?;
            read.insert((*index, name.clone()));
        }
        read.retain(|key| {
            !sources.contains_key(key)
                && !options.fed_by_signals.contains_key(key)
                && !composed.contains_key(key)
        });
        let mut plan = Plan {
            coupling,
            grid,
            members: Vec::new(),
            tolerance: self.tolerance,
            numbers: options.signals,
            texts: 0,
            signals: options.signals,
            places: HashMap::new(),
        };
        let mut texts = HashMap::new();
        for (index, instance) in self.instances.iter().enumerate() {
            let variables = instance.model().variables();
            let mut outputs = |plan: &mut Plan, wanted: &dyn Fn(Causality) -> bool| {
                let mut outputs =
                    Outputs { first: plan.numbers, first_text: plan.texts, ..Outputs::default() };
                for kind in [Kind::Real, Kind::Integer, Kind::Boolean, Kind::String] {
                    for variable in variables {
                        let key = (index, variable.name.clone());
                        if variable.kind != kind
                            || !wanted(variable.causality)
                            || !read.contains(&key)
                        {
                            continue;
                        }
                        outputs.add(variable);
                        let (places, count) = match kind {
                            Kind::String => (&mut texts, &mut plan.texts),
                            _ => (&mut plan.places, &mut plan.numbers),
                        };
                        places.insert(key, *count);
                        *count += 1;
                    }
                }
                outputs
            };
            let member = Member {
                name: instance.name().to_owned(),
                outputs: outputs(&mut plan, &|causality| causality == Causality::Output),
                others: outputs(&mut plan, &|causality| causality != Causality::Output),
                ..Member::default()
            };
            plan.members.push(member);
        }
        for key in composed.keys() {
            // The second place is that of the constant.
            plan.places.insert(key.clone(), plan.numbers);
            plan.numbers += 2;
        }
        for (key, signal) in &options.fed_by_signals {
            plan.places.insert(key.clone(), *signal);
        }
        for (input, source) in &sources {
            let places = if texts.contains_key(source) { &mut texts } else { &mut plan.places };
            if let Some(place) = places.get(source).copied() {
                places.entry(input.clone()).or_insert(place);
            }
        }
        for (index, instance) in self.instances.iter().enumerate() {
            for variable in instance.model().variables() {
                plan.sets((index, variable), &sources, &texts, (options, &composed));
            }
        }
        Ok(plan)
    }
}

impl Plan {
    /// Adds the assignments to a variable.
    fn sets(
        &mut self,
        (index, variable): (usize, &Variable),
        sources: &HashMap<Key, Key>,
        texts: &HashMap<Key, usize>,
        (options, composed): (&PlanOptions, &BTreeMap<Key, Composition>),
    ) {
        let key = (index, variable.name.clone());
        let assigned = options.assigned.get(&key).cloned();
        let source = sources.get(&key);
        let is_fed = source.is_some() || options.fed_by_signals.contains_key(&key);
        let composition = composed.get(&key);
        let place = self.places.get(&key).copied();
        let source = source.and_then(|source| self.places.get(source)).copied();
        let member = &mut self.members[index];
        if let (Some(composition), Some(to)) = (composition, place) {
            let start = variable.start.clone().map(Assigned::Fixed);
            member.inputs.composed.push(Composed {
                to,
                from: source.unwrap_or(to + 1),
                composition: composition.clone(),
                constant: if is_fed { None } else { assigned.or(start) },
            });
        } else if let (Some(value), false) = (assigned, is_fed) {
            let (reference, kind) = (variable.reference, variable.kind);
            let assignment = Assignment { reference, kind, value };
            match variable.causality {
                Causality::Input => member.constants.push(assignment),
                _ => member.parameters.push(assignment),
            }
        }
        if !is_fed && composition.is_none() {
            return;
        }
        let (lane, from) = match variable.kind {
            Kind::Real => (&mut member.inputs.real, place),
            Kind::Integer => (&mut member.inputs.integer, place),
            Kind::Boolean => (&mut member.inputs.boolean, place),
            Kind::String => (&mut member.inputs.string, texts.get(&key).copied()),
        };
        if let Some(from) = from {
            lane.references.push(variable.reference);
            lane.from.push(from);
        }
    }
}
