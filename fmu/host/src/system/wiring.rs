//! A system resolved into value references and places: who reads what, who is set from where.

use std::collections::HashMap;

use model_description::{Causality, Kind, Variable};

use super::signals::{Ports, Signals, Slot};
use super::{InputTable, System};
use crate::Error;

/// A system resolved into value references and places.
pub(super) struct Wiring {
    pub(super) signals: Signals,
    pub(super) members: Vec<Member>,
    /// Columns of the table and the places they go to.
    pub(super) feeds: Vec<(usize, Slot)>,
    /// The table's present row.
    pub(super) row: usize,
    /// Names, units and places of what is recorded.
    pub(super) recorded: Vec<(String, Option<String>, Slot)>,
}

/// What passes through one instance.
#[derive(Default)]
pub(super) struct Member {
    /// Inputs that are fed, from where they are.
    pub(super) inputs: Ports,
    /// Outputs, read in every pass and step.
    pub(super) outputs: Ports,
    /// What else is recorded, read only at communication points.
    pub(super) others: Ports,
}

impl Wiring {
    pub(super) fn new(system: &System, start: f64) -> Result<Self, Error> {
        let mut signals = Signals::default();
        let mut members: Vec<Member> = Vec::new();
        members.resize_with(system.instances.len(), Member::default);
        // Places of outputs (and of whatever else is recorded), and of what feeds inputs.
        let mut places: HashMap<(usize, String), Slot> = HashMap::new();
        let mut sources: HashMap<(usize, String), (Slot, String)> = HashMap::new();

        let mut place =
            |signals: &mut Signals, members: &mut [Member], index: usize, name: &str| {
                let variable = system.instances[index].variable(name)?;
                let slot = *places.entry((index, name.to_owned())).or_insert_with(|| {
                    let slot = signals.slot(variable.kind);
                    let ports = match variable.causality {
                        Causality::Output => &mut members[index].outputs,
                        _ => &mut members[index].others,
                    };
                    ports.add(name, variable.reference, slot);
                    slot
                });
                Ok::<Slot, Error>(slot)
            };
        for c in &system.connections {
            let slot = place(&mut signals, &mut members, system.index(&c.from)?, &c.output)?;
            let source = format!("{}.{}", c.from, c.output);
            sources.insert((system.index(&c.to)?, c.input.clone()), (slot, source));
        }
        let feeds = match &system.table {
            Some(table) => resolve_table(system, table, start, &mut signals, &mut sources)?,
            None => Vec::new(),
        };
        for setting in &system.settings {
            if let Some((_, source)) = sources.get(&(setting.instance, setting.variable.clone())) {
                return Err(Error::SetAndFed {
                    input: system.path(setting.instance, &setting.variable),
                    source_name: source.clone(),
                });
            }
        }
        let mut recorded = Vec::new();
        for (index, name) in recorded_variables(system)? {
            let variable = system.instances[index].variable(&name)?;
            let slot = match sources.get(&(index, name.clone())) {
                Some((slot, _)) => *slot,
                None => place(&mut signals, &mut members, index, &name)?,
            };
            recorded.push((system.path(index, &name), variable.unit.clone(), slot));
        }
        // In the order of modelDescription.xml, so that a run does not depend on a hash.
        for (index, instance) in system.instances.iter().enumerate() {
            for variable in instance.model().variables() {
                if let Some((slot, _)) = sources.get(&(index, variable.name.clone())) {
                    members[index].inputs.add(&variable.name, variable.reference, *slot);
                }
            }
        }
        Ok(Self { signals, members, feeds, row: 0, recorded })
    }
}

/// What to record: what was asked for, or all outputs and the inputs that no output feeds, no texts.
pub(super) fn recorded_variables(system: &System) -> Result<Vec<(usize, String)>, Error> {
    if let Some(recorded) = &system.recorded {
        return recorded.iter().map(|(i, v)| Ok((system.index(i)?, v.clone()))).collect();
    }
    let mut variables = Vec::new();
    for (index, instance) in system.instances.iter().enumerate() {
        for variable in instance.model().variables() {
            let wanted = match variable.causality {
                Causality::Output => true,
                // A connected input is its source once more.
                Causality::Input => !system
                    .connections
                    .iter()
                    .any(|c| c.to == instance.name() && c.input == variable.name),
                _ => false,
            };
            if wanted && variable.kind != Kind::String {
                variables.push((index, variable.name.clone()));
            }
        }
    }
    Ok(variables)
}

/// Gives the table's columns to the inputs they name. A column named `instance.input` feeds that
/// input, one named `input` feeds every input of that name that no connection feeds.
fn resolve_table(
    system: &System,
    table: &InputTable,
    start: f64,
    signals: &mut Signals,
    sources: &mut HashMap<(usize, String), (Slot, String)>,
) -> Result<Vec<(usize, Slot)>, Error> {
    let first = table.times().first().copied().unwrap_or(f64::INFINITY);
    if first > start {
        return Err(Error::TableStart { table: table.name().to_owned(), first, start });
    }
    let connected: Vec<(usize, String)> = sources.keys().cloned().collect();
    let mut feeds = Vec::new();
    for (column, name) in table.columns().iter().enumerate() {
        // Names of variables may have dots in them, so a dot alone does not make a path.
        let named = |(index, v): &(usize, &Variable)| {
            v.name == *name || system.path(*index, &v.name) == *name
        };
        let all: Vec<(usize, &Variable)> = system.inputs().filter(named).collect();
        if all.is_empty() {
            return Err(Error::TableColumn {
                table: table.name().to_owned(),
                column: name.clone(),
                near: system.near_inputs(name),
            });
        }
        let mut free = all.clone();
        free.retain(|(index, v)| !connected.contains(&(*index, v.name.clone())));
        let set_and_fed = |(index, variable): (usize, &Variable), source: String| {
            Error::SetAndFed { input: system.path(index, &variable.name), source_name: source }
        };
        if free.is_empty() {
            return Err(set_and_fed(all[0], format!("a connection and column {name:?}")));
        }
        for (index, variable) in free {
            table.fits(column, variable.kind)?;
            let slot = signals.slot(variable.kind);
            let source = format!("column {name:?} of {}", table.name());
            let key = (index, variable.name.clone());
            if let Some((_, other)) = sources.insert(key, (slot, source.clone())) {
                return Err(set_and_fed((index, variable), format!("{other} and {source}")));
            }
            feeds.push((column, slot));
        }
    }
    Ok(feeds)
}
