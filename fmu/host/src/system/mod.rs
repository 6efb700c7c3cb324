//! Systems of wired instances: assembled by name, compiled to a [`Plan`], run by a [`Cosimulation`].
//!
//! The instances step in the order in which they were added unless [`System::order`] changes
//! the order; for a steering loop that is plant, pose estimator, path, PID.

mod by_name;
mod connections;
mod cosimulation;
mod inputs;
mod plan;
mod recording;
mod run;

pub use by_name::{Connection, Measurement, Unit, wires_by_name};
pub use cosimulation::{Cosimulation, Settled, Signals};
pub use inputs::InputTable;
pub use plan::{Assigned, Composition, Coupling, Grid, Key, Linear, Plan, PlanOptions};
pub use recording::Recording;
pub use run::grid;

use std::collections::BTreeMap;

use model_description::{Causality, Kind, Value, Variable};

use crate::Error;
use crate::instance::Instance;
use crate::names::near;

/// Instances, connections between them, values to set, inputs from outside, what to record.
#[derive(Debug, Default)]
pub struct System {
    instances: Vec<Instance>,
    connections: Vec<Connection>,
    /// The change of the values on connections that do not pass them as they are, by instance and input.
    scales: BTreeMap<(String, String), Linear>,
    /// Inputs that connectors of the system itself feed.
    inputs: Vec<OutsideInput>,
    settings: Vec<Setting>,
    table: Option<InputTable>,
    /// Variables to record instead of the default.
    recorded: Option<Vec<(String, String)>>,
    tolerance: Option<f64>,
}

/// An input that a connector of the system feeds: from a table, otherwise with its start value.
#[derive(Debug, Clone)]
struct OutsideInput {
    connector: String,
    instance: String,
    input: String,
    /// From the connector to the input.
    scale: Linear,
}

/// A value to set before the run: a parameter's before initialization, an input's in it.
#[derive(Debug, Clone)]
pub(crate) struct Setting {
    pub(crate) instance: usize,
    pub(crate) variable: String,
    pub(crate) value: Value,
    /// Whether it is a start value, which a column of the table replaces.
    pub(crate) is_start: bool,
}

impl System {
    /// A system of nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an instance, last in order. Its name must be unique and without dots,
    /// which separate it from its variables' names.
    pub fn add(&mut self, instance: Instance) -> Result<&mut Self, Error> {
        let name = instance.name();
        if name.contains('.') {
            let reason = "a dot separates it from the names of its variables";
            return Err(Error::InstanceName { name: name.to_owned(), reason });
        }
        if self.instances.iter().any(|other| other.name() == name) {
            return Err(Error::DuplicateInstance { name: name.to_owned() });
        }
        self.instances.push(instance);
        Ok(self)
    }

    /// The instances, in order.
    #[must_use]
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// An instance by name, to read variables after a run or its log.
    pub fn instance_mut(&mut self, name: &str) -> Result<&mut Instance, Error> {
        let index = self.index(name)?;
        Ok(&mut self.instances[index])
    }

    /// Puts the instances into another order, in which a Gauss–Seidel coupling steps them.
    pub fn order(&mut self, names: &[&str]) -> Result<&mut Self, Error> {
        let wanted: Vec<usize> =
            names.iter().map(|name| self.index(name)).collect::<Result<_, _>>()?;
        let mut sorted = wanted.clone();
        sorted.sort_unstable();
        if sorted.iter().copied().ne(0..self.instances.len()) {
            return Err(Error::BadOrder {
                order: names.iter().map(|name| (*name).to_owned()).collect(),
                instances: self.instance_names(),
            });
        }
        for setting in &mut self.settings {
            // `wanted` holds every index, as was just seen.
            if let Some(place) = wanted.iter().position(|index| *index == setting.instance) {
                setting.instance = place;
            }
        }
        let mut old: Vec<Option<Instance>> = self.instances.drain(..).map(Some).collect();
        self.instances.extend(wanted.into_iter().filter_map(|index| old[index].take()));
        Ok(self)
    }

    /// Sets a parameter, or the constant value of an input that nothing feeds, in the next runs.
    pub fn set(
        &mut self,
        instance: &str,
        variable: &str,
        value: impl Into<Value>,
    ) -> Result<&mut Self, Error> {
        self.assign(instance, variable, value.into(), false)
    }

    /// As [`System::set`], for the start value of a package: a column of the table replaces it.
    pub fn start_with(
        &mut self,
        instance: &str,
        variable: &str,
        value: impl Into<Value>,
    ) -> Result<&mut Self, Error> {
        self.assign(instance, variable, value.into(), true)
    }

    fn assign(
        &mut self,
        instance: &str,
        variable: &str,
        value: Value,
        is_start: bool,
    ) -> Result<&mut Self, Error> {
        let index = self.index(instance)?;
        let found = self.instances[index].variable(variable)?;
        if found.kind != value.kind() {
            let (instance, variable) = (instance.to_owned(), variable.to_owned());
            let (need, got) = (found.kind, value.kind());
            return Err(Error::WrongKind { instance, variable, need, got });
        }
        self.settings.retain(|s| !(s.instance == index && s.variable == variable));
        let variable = variable.to_owned();
        self.settings.push(Setting { instance: index, variable, value, is_start });
        Ok(self)
    }

    /// The values that are set, `(instance, variable, value)`.
    pub fn settings(&self) -> impl Iterator<Item = (&str, &str, &Value)> {
        let all = self.settings.iter();
        all.map(|s| (self.instances[s.instance].name(), s.variable.as_str(), &s.value))
    }

    /// [`System::set`] from a text like `pid.kp=2.5` or `pid.enabled=false`.
    pub fn set_text(&mut self, text: &str) -> Result<&mut Self, Error> {
        let bad = || Error::BadPath { text: text.to_owned(), with_value: true };
        let (path, value) = text.split_once('=').ok_or_else(bad)?;
        let (instance, variable) = path.trim().split_once('.').ok_or_else(bad)?;
        let kind = self.instances[self.index(instance)?].variable(variable)?.kind;
        let value = parse(value, kind).ok_or_else(|| Error::BadValue {
            instance: instance.to_owned(),
            variable: variable.to_owned(),
            text: value.to_owned(),
            kind,
        })?;
        self.set(instance, variable, value)
    }

    /// Feeds inputs from a table, by zero-order hold.
    pub fn feed(&mut self, table: InputTable) -> &mut Self {
        self.table = Some(table);
        self
    }

    /// Passes a relative tolerance to the FMUs.
    pub fn tolerance(&mut self, tolerance: f64) -> &mut Self {
        self.tolerance = Some(tolerance);
        self
    }

    /// Records these variables, written `instance.variable`, instead of the default: all outputs and
    /// the inputs without a connection.
    pub fn record(&mut self, paths: &[&str]) -> Result<&mut Self, Error> {
        let mut recorded = Vec::new();
        for path in paths {
            let (instance, variable) = path
                .split_once('.')
                .ok_or_else(|| Error::BadPath { text: (*path).to_owned(), with_value: false })?;
            let found = self.instances[self.index(instance)?].variable(variable)?;
            if found.kind == Kind::String {
                return Err(Error::NotRecordable { variable: (*path).to_owned() });
            }
            recorded.push((instance.to_owned(), variable.to_owned()));
        }
        self.recorded = Some(recorded);
        Ok(self)
    }

    fn index(&self, name: &str) -> Result<usize, Error> {
        self.instances.iter().position(|instance| instance.name() == name).ok_or_else(|| {
            Error::UnknownInstance { name: name.to_owned(), instances: self.instance_names() }
        })
    }

    fn instance_names(&self) -> Vec<String> {
        self.instances.iter().map(|instance| instance.name().to_owned()).collect()
    }

    /// Every input of every instance, with its instance's index.
    fn inputs(&self) -> impl Iterator<Item = (usize, &Variable)> {
        self.instances.iter().enumerate().flat_map(|(index, instance)| {
            let variables = instance.model().variables().iter();
            variables.filter(|v| v.causality == Causality::Input).map(move |v| (index, v))
        })
    }

    fn path(&self, index: usize, variable: &str) -> String {
        format!("{}.{variable}", self.instances[index].name())
    }

    /// Input paths near a misspelt one.
    fn near_inputs(&self, name: &str) -> Vec<String> {
        let paths: Vec<String> =
            self.inputs().map(|(index, v)| self.path(index, &v.name)).collect();
        let plain: Vec<&str> = self.inputs().map(|(_, v)| v.name.as_str()).collect();
        let connectors = self.inputs.iter().map(|input| input.connector.as_str());
        let mut found = near(name, connectors.chain(paths.iter().map(String::as_str)).chain(plain));
        found.dedup();
        found
    }
}

fn parse(text: &str, kind: Kind) -> Option<Value> {
    let trimmed = text.trim();
    match kind {
        Kind::Real => trimmed.parse().ok().filter(|v: &f64| v.is_finite()).map(Value::Real),
        Kind::Integer => trimmed.parse().ok().map(Value::Integer),
        Kind::Boolean => match trimmed {
            "true" | "1" => Some(Value::Boolean(true)),
            "false" | "0" => Some(Value::Boolean(false)),
            _ => None,
        },
        Kind::String => Some(Value::String(text.to_owned())),
    }
}
