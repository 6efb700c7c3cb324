//! The places of all values in the one array of a run: see [`crate::plan`].

use std::collections::{BTreeSet, HashMap};

use fmi2_host::{Causality, Kind, Variable};
use toml::Spanned;

use crate::connect::Wired;
use crate::error::Error;
use crate::plan::Outputs;
use crate::resolve::Disturbed;
use crate::study::{Quantity, Study};
use crate::values::find;

/// The places of all values.
pub(crate) struct Places {
    pub(crate) slots: HashMap<(usize, String), usize>,
    /// What each instance gives: outputs, and what else is looked at.
    pub(crate) read: Vec<(Outputs, Outputs)>,
    /// Inputs that are composed.
    pub(crate) composed: HashMap<(usize, String), usize>,
    /// By instance and input: what feeds it.
    pub(crate) fed: HashMap<(usize, String), (usize, String)>,
    /// What metrics and trajectories see.
    pub(crate) looked_at: Vec<(usize, String)>,
    pub(crate) count: usize,
}

impl Places {
    pub(crate) fn new(
        study: &Study,
        wired: &Wired,
        disturbed: &[Disturbed<'_>],
    ) -> Result<Self, Error> {
        let all = wired.system.instances();
        let index = |name: &str| all.iter().position(|i| i.name() == name).unwrap_or(0);
        let mut fed = HashMap::new();
        let mut looked_at: Vec<(usize, String)> = Vec::new();
        for c in wired.system.connections() {
            let source = (index(&c.from), c.output.clone());
            if !looked_at.contains(&source) {
                looked_at.push(source.clone());
            }
            fed.insert((index(&c.to), c.input.clone()), source);
        }
        let mut look = |path: &Spanned<String>| {
            let (index, variable) = find(study, wired, path)?;
            if variable.kind == Kind::String {
                let problem = format!("{} is a text", path.get_ref());
                return Err(study.fault(path, problem, "look at numbers and Booleans"));
            }
            let key = (index, variable.name.clone());
            if !looked_at.contains(&key) {
                looked_at.push(key);
            }
            Ok(())
        };
        for entry in &study.raw.metric {
            look(&entry.get_ref().variable)?;
            if let Some(target) = &entry.get_ref().target
                && let Quantity::Name(name) = target.get_ref()
                && name.contains('.')
                && !study.raw.vary.iter().any(|v| {
                    let first = v.get_ref().variables.first().map(Spanned::get_ref);
                    v.get_ref().name.as_ref().or(first) == Some(name)
                })
            {
                look(&respanned(target, name))?;
            }
        }
        study.raw.record.iter().try_for_each(&mut look)?;
        let mut composed_inputs: BTreeSet<(usize, String)> =
            disturbed.iter().map(|(index, v, _)| (*index, v.name.clone())).collect();
        composed_inputs.extend(wired.scaled.keys().map(|(i, v)| (index(i), v.clone())));

        let mut places = Self {
            slots: HashMap::new(),
            read: Vec::new(),
            composed: HashMap::new(),
            fed,
            looked_at,
            count: 0,
        };
        for (index, instance) in all.iter().enumerate() {
            let mut of = |outputs: bool| {
                let mut wanted: Vec<&Variable> = Vec::new();
                for kind in [Kind::Real, Kind::Integer, Kind::Boolean, Kind::String] {
                    wanted.extend(instance.model().variables().iter().filter(|v| {
                        let key = (index, v.name.clone());
                        v.kind == kind
                            && (v.causality == Causality::Output) == outputs
                            && places.looked_at.contains(&key)
                            && !places.fed.contains_key(&key)
                            && !composed_inputs.contains(&key)
                    }));
                }
                let mut lane = Outputs { first: places.count, ..Outputs::default() };
                for variable in wanted {
                    match variable.kind {
                        Kind::Real => lane.real.push(variable.reference),
                        Kind::Integer => lane.integer.push(variable.reference),
                        Kind::Boolean => lane.boolean.push(variable.reference),
                        Kind::String => return Err(variable.name.clone()),
                    }
                    lane.names.push(variable.name.clone());
                    places.slots.insert((index, variable.name.clone()), places.count);
                    places.count += 1;
                }
                Ok(lane)
            };
            let both = of(true).and_then(|outputs| Ok((outputs, of(false)?)));
            places.read.push(both.map_err(|text| Error::Study {
                at: study.top(),
                problem: format!("{}.{text} is a text, and a connection takes it", instance.name()),
                hint: "sweeps pass numbers and Booleans between FMUs",
            })?);
        }
        for key in composed_inputs {
            places.composed.insert(key, places.count);
            // One place for its value, one for the constant that it may have.
            places.count += 2;
        }
        Ok(places)
    }

    /// Where a variable's value is.
    pub(crate) fn of(&self, index: usize, variable: &str) -> usize {
        let key = (index, variable.to_owned());
        if let Some(slot) = self.composed.get(&key) {
            return *slot;
        }
        let key = self.fed.get(&key).unwrap_or(&key);
        // Everything that is asked for was laid out.
        self.slots.get(key).copied().unwrap_or(0)
    }
}

/// A text of an entry, at the entry's place.
pub(crate) fn respanned<T>(entry: &Spanned<T>, text: &str) -> Spanned<String> {
    Spanned::new(entry.span(), text.to_owned())
}
