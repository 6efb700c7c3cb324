//! The connections of a system with systems inside it, as connections between components.
//!
//! A connector of a system inside the system passes a value on: an `input` from the system around it to its components, an
//! `output` the other way. Each component's input is followed back to the output, or the connector of the root, that feeds it.

use std::collections::{BTreeMap, BTreeSet};

use super::structure::{Connector, SystemInput, SystemStructure, WrittenConnection};
use crate::Error;
use crate::system::Connection;

/// One end of a wire.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum WireEnd {
    /// A variable of a component, by the component's name in the flat system.
    Variable { component: String, name: String },
    /// A connector of a system, by the system's path; that of the root is empty.
    Connector { system: String, name: String },
}

/// A connection as it is written.
#[derive(Debug, Clone)]
pub(super) struct Wire {
    start: WireEnd,
    end: WireEnd,
    /// The path of the system in which it is written.
    level: String,
    written: WrittenConnection,
    package: String,
}

impl Wire {
    pub(super) fn new(
        [start, end]: [WireEnd; 2],
        level: &str,
        written: WrittenConnection,
        package: &str,
    ) -> Self {
        Self { start, end, level: level.to_owned(), written, package: package.to_owned() }
    }

    fn other_end(&self, end: &WireEnd) -> Option<&WireEnd> {
        match end {
            end if *end == self.start => Some(&self.end),
            end if *end == self.end => Some(&self.start),
            _ => None,
        }
    }

    fn not_supported(&self, what: String) -> Error {
        Error::SystemNotSupported {
            package: self.package.clone(),
            file: self.written.place.file.clone(),
            line: self.written.place.line,
            what,
        }
    }
}

/// What the elements of all systems are, and the wires between them.
#[derive(Debug, Default)]
pub(super) struct Wires {
    wires: Vec<Wire>,
    /// The element of a path: the name of a component in the flat system, or nothing for a system.
    elements: BTreeMap<String, Option<String>>,
    /// Names in the flat system that are those of components of the root.
    reserved: BTreeSet<String>,
    /// The connectors of systems inside the system, by the system's path and the name.
    connectors: BTreeMap<(String, String), Connector>,
}

/// A value on its way: where it comes from, and what the wires do to it.
struct Origin {
    end: WireEnd,
    written: WrittenConnection,
    /// How many wires it passed.
    wires: usize,
}

impl Wires {
    pub(super) fn add(&mut self, wire: Wire) {
        self.wires.push(wire);
    }

    pub(super) fn reserve(&mut self, name: &str) {
        self.reserved.insert(name.to_owned());
    }

    pub(super) fn is_reserved(&self, name: &str) -> bool {
        self.reserved.contains(name)
    }

    pub(super) fn add_connector(&mut self, system: &str, connector: Connector) {
        self.connectors.insert((system.to_owned(), connector.name.clone()), connector);
    }

    pub(super) fn add_system(&mut self, path: &str, name: &str) -> Result<(), String> {
        self.add_element(path, name, None)
    }

    pub(super) fn add_component(
        &mut self,
        path: &str,
        name: &str,
        flat: &str,
    ) -> Result<(), String> {
        self.add_element(path, name, Some(flat.to_owned()))
    }

    fn add_element(&mut self, path: &str, name: &str, flat: Option<String>) -> Result<(), String> {
        match self.elements.insert(format!("{path}{name}"), flat) {
            None => Ok(()),
            Some(_) => Err(format!("two components are named {name:?}")),
        }
    }

    /// The component, by its name in the flat system, and the variable of a parameter of a system: `component.variable`, or
    /// `system.component.variable` for one inside it.
    pub(super) fn component_of<'a>(
        &self,
        path: &str,
        parameter: &'a str,
    ) -> Option<(&str, &'a str)> {
        for (dot, _) in parameter.match_indices('.') {
            let (name, variable) = (&parameter[..dot], &parameter[dot + 1..]);
            match self.elements.get(&format!("{path}{name}")) {
                Some(Some(flat)) => return Some((flat, variable)),
                Some(None) => return self.component_of(&format!("{path}{name}/"), variable),
                None => {}
            }
        }
        None
    }

    /// The end of a wire that is written in the system `path`: a connector of its own, or of an element in it.
    ///
    /// # Errors
    /// The names of its elements, where there is none of that name.
    pub(super) fn end(
        &self,
        path: &str,
        element: Option<&str>,
        connector: &str,
    ) -> Result<WireEnd, Vec<String>> {
        let name = connector.to_owned();
        let Some(element) = element else {
            return Ok(WireEnd::Connector { system: path.to_owned(), name });
        };
        match self.elements.get(&format!("{path}{element}")) {
            Some(Some(flat)) => Ok(WireEnd::Variable { component: flat.clone(), name }),
            Some(None) => Ok(WireEnd::Connector { system: format!("{path}{element}/"), name }),
            None => {
                let known = self.elements.keys().filter_map(|key| key.strip_prefix(path));
                Err(known.filter(|key| !key.contains('/')).map(str::to_owned).collect())
            }
        }
    }

    /// Gives the structure the connections between its components, and from connectors of the root to them.
    pub(super) fn connect(self, structure: &mut SystemStructure) -> Result<(), Error> {
        for wire in &self.wires {
            let ends = [&wire.start, &wire.end];
            let is_inner = |end: &WireEnd| matches!(end, WireEnd::Connector { system, .. } if !system.is_empty());
            match ends.map(is_inner) {
                [false, false] => connect_ends(structure, ends, &wire.written),
                [true, true] => {}
                [start, _] => {
                    // From the component or the root to the system inside; only the end that takes the value follows it.
                    let (inner, outer) =
                        if start { (ends[0], ends[1]) } else { (ends[1], ends[0]) };
                    if self.is_fed_by(inner, wire)? {
                        continue;
                    }
                    match self.origin(inner, 0)? {
                        Some(origin) => {
                            let written = joined(wire, &wire.written, &origin)?;
                            connect_ends(structure, [&origin.end, outer], &written);
                        }
                        None => structure.remarks.push(format!(
                            "{}: nothing feeds the connector {}",
                            wire.written.place,
                            path_text(inner)
                        )),
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether a connector of a system inside the system has its value from this wire.
    fn is_fed_by(&self, end: &WireEnd, wire: &Wire) -> Result<bool, Error> {
        let WireEnd::Connector { system, name } = end else { return Ok(false) };
        let connector = self.connectors.get(&(system.clone(), name.clone()));
        let Some(connector) = connector else {
            let what = format!("{}, which the system does not declare,", path_text(end));
            return Err(wire.not_supported(what));
        };
        let is_inside = wire.level == *system;
        match connector.kind.as_str() {
            "input" | "parameter" => Ok(!is_inside),
            "output" | "calculatedParameter" => Ok(is_inside),
            kind => {
                Err(wire.not_supported(format!("the connector {} of kind {kind}", path_text(end))))
            }
        }
    }

    /// What feeds a connector of a system inside the system.
    fn origin(&self, end: &WireEnd, depth: usize) -> Result<Option<Origin>, Error> {
        for wire in &self.wires {
            let Some(other) = wire.other_end(end) else { continue };
            if !self.is_fed_by(end, wire)? {
                continue;
            }
            // Systems are finite, so a longer way is a circle.
            if depth > self.connectors.len() {
                return Err(wire.not_supported(format!("a circle through {}", path_text(end))));
            }
            let written = wire.written.clone();
            return match other {
                WireEnd::Connector { system, .. } if !system.is_empty() => {
                    let Some(before) = self.origin(other, depth + 1)? else { return Ok(None) };
                    let written = joined(wire, &written, &before)?;
                    Ok(Some(Origin { end: before.end, written, wires: before.wires + 1 }))
                }
                other => Ok(Some(Origin { end: other.clone(), written, wires: 1 })),
            };
        }
        Ok(None)
    }
}

/// How a value passes that comes from `origin` and then passes a wire: with the transformations of both.
fn joined(
    wire: &Wire,
    last: &WrittenConnection,
    origin: &Origin,
) -> Result<WrittenConnection, Error> {
    if last.suppressed != origin.written.suppressed {
        let what = "suppressUnitConversion on a part of the way through systems inside the system";
        return Err(wire.not_supported(what.to_owned()));
    }
    let transformation = last.transformation.after(origin.written.transformation);
    let has_offset = transformation.offset != 0.0;
    if has_offset && !last.suppressed && origin.wires > 0 {
        // Units are converted once, at the ends: an offset would be in the unit of a connector between them.
        let what =
            "an offset of a LinearTransformation on the way through systems inside the system";
        return Err(wire.not_supported(what.to_owned()));
    }
    Ok(WrittenConnection { place: last.place.clone(), suppressed: last.suppressed, transformation })
}

/// A name for messages: `system/connector` or `component.variable`.
fn path_text(end: &WireEnd) -> String {
    match end {
        WireEnd::Variable { component, name } => format!("{component}.{name}"),
        WireEnd::Connector { system, name } => format!("{system}{name}"),
    }
}

/// Adds a connection whose ends are components, or connectors of the root.
fn connect_ends(structure: &mut SystemStructure, ends: [&WireEnd; 2], written: &WrittenConnection) {
    let (connector, component, input) = match ends {
        [
            WireEnd::Variable { component: from, name: output },
            WireEnd::Variable { component: to, name: input },
        ] => {
            structure.connections.push(Connection::new(from, output, to, input));
            structure.written.push(written.clone());
            return;
        }
        [WireEnd::Connector { name, .. }, WireEnd::Variable { component, name: input }]
        | [WireEnd::Variable { component, name: input }, WireEnd::Connector { name, .. }] => {
            (name, Some(component), input)
        }
        [WireEnd::Connector { name, .. }, WireEnd::Connector { name: other, .. }] => {
            (name, None, other)
        }
    };
    match component {
        Some(component) if structure.input_connector(connector).is_some() => {
            structure.inputs.push(SystemInput {
                connector: connector.clone(),
                component: component.clone(),
                input: input.clone(),
                written: written.clone(),
            });
        }
        // Outputs of the system have no effect on a system without surroundings.
        _ => structure.remarks.push(format!(
            "the connection of {} and {} is left out: it leads to a connector of the system itself \
             that is no declared input",
            path_name(ends[0]),
            path_name(ends[1])
        )),
    }
}

/// The name of an end as it is written in a connection.
fn path_name(end: &WireEnd) -> &str {
    match end {
        WireEnd::Variable { name, .. } | WireEnd::Connector { name, .. } => name,
    }
}
