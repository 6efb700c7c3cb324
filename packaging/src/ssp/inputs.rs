//! Inputs of the system itself: one connector for a quantity that several components take from outside.

use super::Component;
use model_description::{Causality, Kind, Value, Variable};
use steerwright_host::Connection;

/// The inputs that become connectors of the system where no output feeds them.
const FROM_OUTSIDE: [&str; 1] = ["speed"];

/// A Real connector of the system, with the name of the inputs that it feeds.
#[derive(Debug, Clone)]
pub(super) struct SystemInput<'a> {
    pub(super) name: &'static str,
    /// The common unit of the inputs.
    pub(super) unit: Option<&'a str>,
    /// The value without a source; `None` where the inputs start with different values, their own.
    pub(super) start: Option<f64>,
    /// The components whose input it feeds.
    pub(super) components: Vec<&'static str>,
}

impl SystemInput<'_> {
    pub(super) fn feeds(&self, component: &str, input: &str) -> bool {
        self.name == input && self.components.contains(&component)
    }
}

/// The connectors of a system: its speed, if a component takes one that no other component puts out.
pub(super) fn system_inputs<'a>(
    components: &'a [Component<'_>],
    connections: &[Connection],
) -> Vec<SystemInput<'a>> {
    FROM_OUTSIDE
        .into_iter()
        .filter_map(|name| system_input(name, components, connections))
        .collect()
}

fn system_input<'a>(
    name: &'static str,
    components: &'a [Component<'_>],
    connections: &[Connection],
) -> Option<SystemInput<'a>> {
    let mut free: Vec<(&Component<'_>, &Variable)> = Vec::new();
    for component in components {
        let is_fed = connections.iter().any(|c| c.to == component.name() && c.input == name);
        let variable = component.packed.description.variable(name).filter(|variable| {
            variable.causality == Causality::Input && variable.kind == Kind::Real && !is_fed
        });
        free.extend(variable.map(|variable| (component, variable)));
    }
    let (component, variable) = *free.first()?;
    free.retain(|(_, other)| other.unit == variable.unit);
    let start = start_of(component, variable);
    let is_common = free.iter().all(|(component, variable)| start_of(component, variable) == start);
    Some(SystemInput {
        name,
        unit: variable.unit.as_deref(),
        start: start.filter(|_| is_common),
        components: free.iter().map(|(component, _)| component.name()).collect(),
    })
}

/// The value that an input starts with: that of the system, otherwise of its archive.
fn start_of(component: &Component<'_>, variable: &Variable) -> Option<f64> {
    let stated = component.start.iter().find(|(name, _)| *name == variable.name);
    match (stated, &variable.start) {
        (Some((_, value)), _) => Some(*value),
        (None, Some(Value::Real(value))) => Some(*value),
        (None, _) => None,
    }
}
