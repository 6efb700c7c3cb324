//! Reading a flat `SystemStructure.ssd` of SSP 1.0, of any tool.
//!
//! Elements are known by namespace and name, whatever their prefixes. What would change the
//! system's behaviour and is not supported is an error: nested systems, transformations, parameter
//! mappings, components that are no FMUs. What describes it alone (geometry, signal dictionaries
//! that nothing refers to, annotations of other tools) is passed over.

use model_description::Value;
use roxmltree::{Document, Node, ParsingOptions};

use super::structure::{Component, Connector, Parameter, Place, SystemStructure, Written};
use super::unit_definitions;
use crate::names::{near, near_text};
use crate::{Connection, Error};

const SSD: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";
const SSC: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
const SSV: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
const OSP: &str = "http://opensimulationplatform.com/SSP/OSPAnnotations";

/// Elements, texts and comments a file may have.
const NODES_LIMIT: u32 = 4_000_000;

/// A file of a package, for messages: `loop.ssp: SystemStructure.ssd`.
#[derive(Clone, Copy)]
pub(super) struct File<'a> {
    pub(super) package: &'a str,
    pub(super) name: &'a str,
}

impl File<'_> {
    fn error(self, line: u32, problem: impl Into<String>) -> Error {
        Error::SystemStructure {
            package: self.package.to_owned(),
            file: self.name.to_owned(),
            line,
            problem: problem.into(),
        }
    }

    fn parse(self, text: &str) -> Result<Document<'_>, Error> {
        let options = ParsingOptions { nodes_limit: NODES_LIMIT, ..ParsingOptions::default() };
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Document::parse_with_options(text, options)
            .map_err(|error| self.error(error.pos().row, error.to_string()))
    }
}

/// An element and the file it is of.
#[derive(Clone, Copy)]
pub(super) struct Element<'a, 'input> {
    pub(super) node: Node<'a, 'input>,
    file: File<'a>,
}

impl<'a, 'input> Element<'a, 'input> {
    pub(super) fn is(self, namespace: &str, name: &str) -> bool {
        self.node.tag_name().namespace() == Some(namespace) && self.node.tag_name().name() == name
    }

    pub(super) fn children(self) -> impl Iterator<Item = Element<'a, 'input>> {
        let file = self.file;
        self.node.children().filter(Node::is_element).map(move |node| Element { node, file })
    }

    pub(super) fn child(
        self,
        namespace: &'static str,
        name: &'static str,
    ) -> Option<Element<'a, 'input>> {
        self.children().find(|child| child.is(namespace, name))
    }

    /// What stands in the child of that name, or nothing.
    fn inside(self, name: &'static str) -> impl Iterator<Item = Element<'a, 'input>> {
        self.child(SSD, name).into_iter().flat_map(Element::children)
    }

    fn line(self) -> u32 {
        self.node.document().text_pos_at(self.node.range().start).row
    }

    fn place(self) -> Place {
        Place { file: self.file.name.to_owned(), line: self.line() }
    }

    pub(super) fn error(self, problem: impl Into<String>) -> Error {
        self.file.error(self.line(), problem)
    }

    fn not_supported(self, what: impl Into<String>) -> Error {
        Error::SystemNotSupported {
            package: self.file.package.to_owned(),
            file: self.file.name.to_owned(),
            line: self.line(),
            what: what.into(),
        }
    }

    pub(super) fn optional(self, name: &str) -> Option<&'a str> {
        self.node.attribute(name)
    }

    pub(super) fn attribute(self, name: &str) -> Result<&'a str, Error> {
        self.optional(name).ok_or_else(|| {
            self.error(format!("<{}> has no attribute {name}", self.node.tag_name().name()))
        })
    }

    /// A finite number.
    pub(super) fn number(self, name: &str) -> Result<Option<f64>, Error> {
        let Some(text) = self.optional(name) else { return Ok(None) };
        match text.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(self.error(format!("{name} is {text:?}, not a finite number"))),
        }
    }
}

/// Reads `SystemStructure.ssd`; `load` gives the text of another file in the package.
pub(super) fn structure(
    text: &str,
    file: File<'_>,
    load: &dyn Fn(&str) -> Result<String, Error>,
) -> Result<SystemStructure, Error> {
    let document = file.parse(text)?;
    let root = Element { node: document.root_element(), file };
    if !root.is(SSD, "SystemStructureDescription") {
        return Err(root.error("the root is no SystemStructureDescription of SSP 1"));
    }
    let version = root.attribute("version")?;
    if !version.starts_with("1.") {
        return Err(root.not_supported(format!("version {version} (1.0 is)")));
    }
    let system = root.child(SSD, "System").ok_or_else(|| root.error("there is no System"))?;
    let mut structure =
        SystemStructure { name: system.attribute("name")?.to_owned(), ..Default::default() };
    structure.units = unit_definitions::read(root, SSD, SSC)?;
    for element in system.inside("Elements") {
        let component = component(element, load)?;
        if structure.components.iter().any(|other| other.name == component.name) {
            return Err(element.error(format!("two components are named {:?}", component.name)));
        }
        structure.components.push(component);
    }
    if structure.components.is_empty() {
        return Err(system.error("the system has no components"));
    }
    // Bindings of the system count more than those of its components, so they come last.
    for binding in system.inside("ParameterBindings") {
        for parameter in bound(binding, load)? {
            distribute(&mut structure, parameter);
        }
    }
    for connection in system.inside("Connections").filter(|e| e.is(SSD, "Connection")) {
        connect(&mut structure, connection)?;
    }
    if let Some(experiment) = root.child(SSD, "DefaultExperiment") {
        structure.start_time = experiment.number("startTime")?;
        structure.stop_time = experiment.number("stopTime")?;
        structure.step = step(experiment)?;
    }
    Ok(structure)
}

fn component(
    element: Element<'_, '_>,
    load: &dyn Fn(&str) -> Result<String, Error>,
) -> Result<Component, Error> {
    if !element.is(SSD, "Component") {
        return Err(element.not_supported(match element.node.tag_name().name() {
            "System" => "a system within the system".to_owned(),
            name => format!("the element {name}"),
        }));
    }
    let kind = element.optional("type").unwrap_or("application/x-fmu-sharedlibrary");
    if kind != "application/x-fmu-sharedlibrary" {
        return Err(element.not_supported(format!("a component of type {kind}")));
    }
    if element.optional("implementation") == Some("ModelExchange") {
        return Err(element.not_supported("a component for model exchange"));
    }
    let mut component = Component {
        name: element.attribute("name")?.to_owned(),
        source: element.attribute("source")?.to_owned(),
        connectors: Vec::new(),
        parameters: Vec::new(),
    };
    for written in element.inside("Connectors").filter(|e| e.is(SSD, "Connector")) {
        component.connectors.push(connector(written)?);
    }
    for binding in element.inside("ParameterBindings") {
        component.parameters.extend(bound(binding, load)?);
    }
    Ok(component)
}

fn connector(element: Element<'_, '_>) -> Result<Connector, Error> {
    let of_type = element.children().find(|child| child.node.tag_name().namespace() == Some(SSC));
    Ok(Connector {
        name: element.attribute("name")?.to_owned(),
        kind: element.attribute("kind")?.to_owned(),
        of_type: of_type.map(|child| child.node.tag_name().name().to_owned()),
        unit: of_type.and_then(|child| child.optional("unit")).map(str::to_owned),
        place: element.place(),
    })
}

/// The values of a `ParameterBinding`, which stand in it or in a file of the package.
fn bound(
    binding: Element<'_, '_>,
    load: &dyn Fn(&str) -> Result<String, Error>,
) -> Result<Vec<Parameter>, Error> {
    let kind = binding.optional("type").unwrap_or("application/x-ssp-parameter-set");
    if kind != "application/x-ssp-parameter-set" {
        return Err(binding.not_supported(format!("a parameter binding of type {kind}")));
    }
    if let Some(mapping) = binding.child(SSD, "ParameterMapping") {
        return Err(mapping.not_supported("a parameter mapping"));
    }
    if binding.optional("sourceBase").is_some_and(|base| base != "SSD") {
        return Err(binding.not_supported("a parameter source inside a component"));
    }
    let prefix = binding.optional("prefix").unwrap_or("");
    match binding.optional("source") {
        None => {
            let sets = binding.inside("ParameterValues").filter(|e| e.is(SSV, "ParameterSet"));
            sets.map(|set| parameters(set, prefix))
                .collect::<Result<Vec<_>, _>>()
                .map(|p| p.concat())
        }
        Some(source) => {
            let text = load(source)?;
            let file = File { package: binding.file.package, name: source };
            let document = file.parse(&text)?;
            let set = Element { node: document.root_element(), file };
            if !set.is(SSV, "ParameterSet") {
                return Err(set.error("the root is no ParameterSet of SSP 1"));
            }
            parameters(set, prefix)
        }
    }
}

/// The values of a `ParameterSet`.
fn parameters(set: Element<'_, '_>, prefix: &str) -> Result<Vec<Parameter>, Error> {
    let units = unit_definitions::read(set, SSV, SSC)?;
    let all = set.child(SSV, "Parameters").into_iter().flat_map(Element::children);
    all.map(|parameter| {
        let name = format!("{prefix}{}", parameter.attribute("name")?);
        let typed = parameter.children().find(|e| !e.is(SSV, "Annotations"));
        let typed = typed.ok_or_else(|| parameter.error(format!("{name} has no value")))?;
        let text = typed.attribute("value")?;
        let kind = typed.node.tag_name().name();
        let bad = || typed.error(format!("{name} is {text:?}, which is no {kind}"));
        let value = match kind {
            "Real" => Value::Real(typed.number("value")?.unwrap_or_default()),
            "Integer" => Value::Integer(text.trim().parse().map_err(|_| bad())?),
            "Boolean" => Value::Boolean(match text.trim() {
                "true" | "1" => true,
                "false" | "0" => false,
                _ => return Err(bad()),
            }),
            "String" => Value::String(text.to_owned()),
            _ => return Err(typed.not_supported(format!("a parameter of type {kind}"))),
        };
        let unit = typed.optional("unit").map(str::to_owned);
        let defined = units.iter().find(|known| Some(&known.name) == unit.as_ref());
        let base = defined.and_then(|known| known.base);
        Ok(Parameter { name, value, unit, base, place: parameter.place() })
    })
    .collect()
}

/// Gives a parameter of the system, `component.variable`, to its component.
fn distribute(structure: &mut SystemStructure, parameter: Parameter) {
    for component in &mut structure.components {
        let rest = parameter.name.strip_prefix(&component.name);
        if let Some(name) = rest.and_then(|rest| rest.strip_prefix('.')) {
            component.parameters.push(Parameter { name: name.to_owned(), ..parameter });
            return;
        }
    }
    let (place, name) = (parameter.place, parameter.name);
    structure.remarks.push(format!("{place}: no component has the parameter {name}"));
}

fn connect(structure: &mut SystemStructure, element: Element<'_, '_>) -> Result<(), Error> {
    if let Some(child) = element.children().find(|e| e.node.tag_name().namespace() == Some(SSC)) {
        return Err(
            child.not_supported(format!("a {} on a connection", child.node.tag_name().name()))
        );
    }
    let ends = (element.optional("startElement"), element.optional("endElement"));
    let connectors = (element.attribute("startConnector")?, element.attribute("endConnector")?);
    let (Some(start), Some(end)) = ends else {
        // What the system shows to the outside adds nothing to a system that runs alone.
        structure.remarks.push(format!(
            "the connection of {} and {} is left out: it leads to a connector of the system itself",
            connectors.0, connectors.1
        ));
        return Ok(());
    };
    for name in [start, end] {
        if !structure.components.iter().any(|component| component.name == name) {
            let known = structure.components.iter().map(|component| component.name.as_str());
            return Err(element.error(format!(
                "the connection of {start}.{} and {end}.{} names {name:?}, which is no component{}",
                connectors.0,
                connectors.1,
                near_text(&near(name, known))
            )));
        }
    }
    let suppressed = match element.optional("suppressUnitConversion").map(str::trim) {
        None | Some("false" | "0") => false,
        Some("true" | "1") => true,
        Some(text) => {
            let problem = format!("suppressUnitConversion is {text:?}, not true or false");
            return Err(element.error(problem));
        }
    };
    structure.connections.push(Connection::new(start, connectors.0, end, connectors.1));
    structure.written.push(Written { place: element.place(), suppressed });
    Ok(())
}

/// The base step in the annotation of the Open Simulation Platform.
fn step(experiment: Element<'_, '_>) -> Result<Option<f64>, Error> {
    let annotations = experiment.inside("Annotations");
    let found = annotations
        .filter(|annotation| annotation.optional("type") == Some("com.opensimulationplatform"))
        .find_map(|annotation| {
            annotation.child(OSP, "Algorithm")?.child(OSP, "FixedStepAlgorithm")
        });
    let Some(algorithm) = found else { return Ok(None) };
    match algorithm.number("baseStepSize")? {
        Some(step) if step > 0.0 => Ok(Some(step)),
        _ => Err(algorithm.error("baseStepSize is not above 0")),
    }
}
