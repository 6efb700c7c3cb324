//! Wiring by names: the one rule by which files are simulated, packed and swept together.
//!
//! An input is fed by the output of its name in another unit; without one it stays free. Several such
//! outputs are ambiguous, and refused, but where a *pose estimator* stands between a vehicle and what
//! steers it. That is a unit with the inputs `gnss_x` and `gnss_y` and the outputs `x` and `y`:
//!
//! - what it puts out goes before outputs of the same names elsewhere: path and controller see the
//!   estimate, not the truth;
//! - where nothing puts out `gnss_x` and `gnss_y`, they are fed by `x` and `y` of the vehicle, as by a
//!   receiver without fault.

use model_description::{Causality, Variable};

use super::Connection;
use crate::Error;

/// Inputs of a pose estimator, and what a receiver without fault would give them.
const RECEIVER: [(&str, &str); 2] = [("gnss_x", "x"), ("gnss_y", "y")];

/// What is wired: its name, and its variables.
pub struct Unit<'a> {
    /// The name in connections.
    pub name: &'a str,
    /// The variables.
    pub variables: &'a [Variable],
    /// Variables, each with the name that it is wired under instead of its own.
    pub renamed: Vec<(&'a str, &'a str)>,
}

impl<'a> Unit<'a> {
    /// A unit whose variables are wired under their own names.
    #[must_use]
    pub fn new(name: &'a str, variables: &'a [Variable]) -> Self {
        Self { name, variables, renamed: Vec::new() }
    }

    fn name_of(&self, variable: &'a Variable) -> &'a str {
        let renamed = self.renamed.iter().find(|(own, _)| *own == variable.name);
        renamed.map_or(&variable.name, |(_, name)| name)
    }

    /// The variables of a causality, with the names that they are wired under.
    fn of(&self, causality: Causality) -> impl Iterator<Item = (&'a Variable, &'a str)> {
        let variables = self.variables.iter().filter(move |v| v.causality == causality);
        variables.map(|v| (v, self.name_of(v)))
    }

    fn output(&self, name: &str) -> Option<&'a Variable> {
        self.of(Causality::Output).find(|(_, own)| *own == name).map(|(variable, _)| variable)
    }

    fn is_estimator(&self) -> bool {
        RECEIVER.iter().all(|(fix, estimate)| {
            self.of(Causality::Input).any(|(_, own)| own == *fix) && self.output(estimate).is_some()
        })
    }
}

/// The connections that names make, in the order of the units and their inputs. `is_fed` says of an
/// input whether something feeds it already.
///
/// # Errors
/// [`Error::Ambiguous`] where an input could be fed by several outputs.
pub fn wires_by_name(
    units: &[Unit<'_>],
    is_fed: &dyn Fn(&Unit<'_>, &str) -> bool,
) -> Result<Vec<Connection>, Error> {
    let mut wires = Vec::new();
    for (index, to) in units.iter().enumerate() {
        for (input, name) in to.of(Causality::Input) {
            if is_fed(to, &input.name) {
                continue;
            }
            let others = || {
                let others = units.iter().enumerate().filter(|(other, _)| *other != index);
                others.map(|(_, unit)| unit)
            };
            let found = |name: &str| -> Vec<(&Unit<'_>, &Variable)> {
                others().filter_map(|unit| Some((unit, unit.output(name)?))).collect()
            };
            let mut candidates = found(name);
            if candidates.len() > 1 && candidates.iter().any(|(unit, _)| unit.is_estimator()) {
                candidates.retain(|(unit, _)| unit.is_estimator());
            }
            if candidates.is_empty()
                && to.is_estimator()
                && let Some((_, truth)) = RECEIVER.iter().find(|(fix, _)| *fix == name)
            {
                candidates = found(truth);
                candidates.retain(|(unit, _)| !unit.is_estimator());
            }
            match candidates[..] {
                [] => {}
                [(from, output)] => {
                    wires.push(Connection::new(from.name, &output.name, to.name, &input.name));
                }
                _ => {
                    let path = |(unit, output): &(&Unit<'_>, &Variable)| {
                        format!("{}.{}", unit.name, output.name)
                    };
                    return Err(Error::Ambiguous {
                        to: format!("{}.{}", to.name, input.name),
                        candidates: candidates.iter().map(path).collect(),
                    });
                }
            }
        }
    }
    Ok(wires)
}
