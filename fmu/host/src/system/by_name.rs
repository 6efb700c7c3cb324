//! Wiring by names: the one rule by which files are simulated, packed and swept together.
//!
//! An input is fed by the output of its name in another unit; without one it stays free. Several such
//! outputs are ambiguous, and refused. The exception is an *estimator*, a unit whose outputs estimate
//! outputs of another unit from measurements of them; the caller states which inputs are such
//! measurements ([`Measurement`]):
//!
//! - the outputs of an estimator take precedence over outputs of the same names elsewhere;
//! - a measurement without an output of its name is fed by the measured output itself.

use model_description::{Causality, Variable};

use crate::Error;

/// An output of one instance that feeds an input of another, or of the same.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // an output is of `from`, an input of `to`
pub struct Connection {
    pub from: String,
    pub output: String,
    pub to: String,
    pub input: String,
}

impl Connection {
    /// A connection from `from.output` to `to.input`.
    #[must_use]
    pub fn new(from: &str, output: &str, to: &str, input: &str) -> Self {
        Self {
            from: from.to_owned(),
            output: output.to_owned(),
            to: to.to_owned(),
            input: input.to_owned(),
        }
    }

    pub(crate) fn source(&self) -> String {
        format!("{}.{}", self.from, self.output)
    }

    pub(crate) fn target(&self) -> String {
        format!("{}.{}", self.to, self.input)
    }
}

impl std::fmt::Display for Connection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} -> {}", self.source(), self.target())
    }
}

/// An input of estimators, and the output that it measures. A unit that has the inputs of all stated
/// measurements, and estimates the measured outputs under their own names, is an estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measurement<'a> {
    /// The name of the input.
    pub input: &'a str,
    /// The name of the measured output, and of its estimate.
    pub output: &'a str,
}

/// A unit to wire: its name and its variables.
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
    fn variables(&self, causality: Causality) -> impl Iterator<Item = (&'a Variable, &'a str)> {
        let variables = self.variables.iter().filter(move |v| v.causality == causality);
        variables.map(|v| (v, self.name_of(v)))
    }

    fn output(&self, name: &str) -> Option<&'a Variable> {
        self.variables(Causality::Output)
            .find(|(_, own)| *own == name)
            .map(|(variable, _)| variable)
    }

    fn is_estimator(&self, measurements: &[Measurement<'_>]) -> bool {
        !measurements.is_empty()
            && measurements.iter().all(|m| {
                self.variables(Causality::Input).any(|(_, own)| own == m.input)
                    && self.output(m.output).is_some()
            })
    }
}

/// The connections that names make, in the order of the units and their inputs. `is_fed` reports
/// whether an input has a source already.
///
/// # Errors
/// [`Error::Ambiguous`] where an input could be fed by several outputs.
pub fn wires_by_name(
    units: &[Unit<'_>],
    measurements: &[Measurement<'_>],
    is_fed: &dyn Fn(&Unit<'_>, &str) -> bool,
) -> Result<Vec<Connection>, Error> {
    let mut wires = Vec::new();
    for (index, to) in units.iter().enumerate() {
        for (input, name) in to.variables(Causality::Input) {
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
            let is_estimator = |unit: &Unit<'_>| unit.is_estimator(measurements);
            let mut candidates = found(name);
            if candidates.len() > 1 && candidates.iter().any(|(unit, _)| is_estimator(unit)) {
                candidates.retain(|(unit, _)| is_estimator(unit));
            }
            if candidates.is_empty()
                && is_estimator(to)
                && let Some(measurement) = measurements.iter().find(|m| m.input == name)
            {
                candidates = found(measurement.output);
                candidates.retain(|(unit, _)| !is_estimator(unit));
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
