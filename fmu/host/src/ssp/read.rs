//! Reading a `SystemStructure.ssd` of SSP 1.0, of any tool.
//!
//! Elements are identified by namespace and name, independent of prefixes. Unsupported content that
//! changes the behaviour of the system is an error: transformations that are not linear, parameter
//! mappings, components other than FMUs. Systems inside the system are flattened (`wires`). Descriptive content (geometry, unused signal dictionaries,
//! annotations of other tools) is ignored.

use model_description::{BaseUnit, Unit, Value};

use super::element::{Element, File, line_ends, without_mark};
use super::structure::{Component, Connector, Parameter, SystemStructure, WrittenConnection};
use super::wires::{Wire, Wires};
use crate::Error;
use crate::names::{near, near_text};
use crate::system::Linear;

const SSD: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";
const SSC: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
const SSV: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
const OSP: &str = "http://opensimulationplatform.com/SSP/OSPAnnotations";

/// Reads `SystemStructure.ssd`; `load` returns the text of another file in the package.
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
    structure.units = read_units(root, SSD)?;
    let mut wires = Wires::default();
    // The components of the root keep their names, wherever in the file they are.
    for element in system.inside(SSD, "Elements").filter(|e| e.is(SSD, "Component")) {
        wires.reserve(element.attribute("name")?);
    }
    read_system(system, "", &mut structure, &mut wires, load)?;
    if structure.components.is_empty() {
        return Err(system.error("the system has no components"));
    }
    wires.connect(&mut structure)?;
    if let Some(experiment) = root.child(SSD, "DefaultExperiment") {
        structure.start_time = experiment.number("startTime")?;
        structure.stop_time = experiment.number("stopTime")?;
        structure.step = step(experiment)?;
    }
    Ok(structure)
}

/// Reads a system with its components, values and connections, and the systems inside it. `path` is that of the system from
/// the root, with a slash after each name.
fn read_system(
    system: Element<'_, '_>,
    path: &str,
    structure: &mut SystemStructure,
    wires: &mut Wires,
    load: &dyn Fn(&str) -> Result<String, Error>,
) -> Result<(), Error> {
    for written in system.inside(SSD, "Connectors").filter(|e| e.is(SSD, "Connector")) {
        let connector = connector(written)?;
        if path.is_empty() {
            structure.connectors.push(connector);
        } else {
            wires.add_connector(path, connector);
        }
    }
    for element in system.inside(SSD, "Elements") {
        if element.is(SSD, "System") {
            let name = element.attribute("name")?;
            wires.add_system(path, name).map_err(|problem| element.error(problem))?;
            read_system(element, &format!("{path}{name}/"), structure, wires, load)?;
            continue;
        }
        let mut component = component(element, load)?;
        let own_name = component.name.clone();
        // In a system inside the system a name may be that of another component.
        let is_in_use = structure.components.iter().any(|other| other.name == component.name);
        if !path.is_empty() && (is_in_use || wires.is_reserved(&component.name)) {
            component.name = format!("{}{own_name}", path.replace('/', "_"));
        }
        if structure.components.iter().any(|other| other.name == component.name) {
            return Err(element.error(format!("two components are named {:?}", component.name)));
        }
        wires
            .add_component(path, &own_name, &component.name)
            .map_err(|problem| element.error(problem))?;
        structure.components.push(component);
    }
    // Bindings of the system count more than those of its components, so they come last.
    for binding in system.inside(SSD, "ParameterBindings") {
        for parameter in bound(binding, load)? {
            distribute(structure, wires, path, parameter);
        }
    }
    for connection in system.inside(SSD, "Connections").filter(|e| e.is(SSD, "Connection")) {
        wires.add(read_wire(connection, path, wires)?);
    }
    Ok(())
}

fn component(
    element: Element<'_, '_>,
    load: &dyn Fn(&str) -> Result<String, Error>,
) -> Result<Component, Error> {
    if !element.is(SSD, "Component") {
        return Err(
            element.not_supported(format!("the element {}", element.node.tag_name().name()))
        );
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
    for written in element.inside(SSD, "Connectors").filter(|e| e.is(SSD, "Connector")) {
        component.connectors.push(connector(written)?);
    }
    for binding in element.inside(SSD, "ParameterBindings") {
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

/// The values of a `ParameterBinding`, which are in it or in a file of the package.
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
            let sets = binding.inside(SSD, "ParameterValues").filter(|e| e.is(SSV, "ParameterSet"));
            sets.map(|set| parameters(set, prefix))
                .collect::<Result<Vec<_>, _>>()
                .map(|p| p.concat())
        }
        Some(source) => {
            let text = load(source)?;
            let text = without_mark(&text);
            let line_ends = line_ends(text);
            let file = File { package: binding.file.package, name: source, line_ends: &line_ends };
            let document = file.parse(text)?;
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
    let units = read_units(set, SSV)?;
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

/// Gives a parameter of a system, `component.variable`, to its component; one of the root that is named after an input
/// connector is the value of that.
fn distribute(structure: &mut SystemStructure, wires: &Wires, path: &str, parameter: Parameter) {
    if path.is_empty() && structure.input_connector(&parameter.name).is_some() {
        structure.parameters.push(parameter);
        return;
    }
    if let Some((component, variable)) = wires.component_of(path, &parameter.name)
        && let Some(component) = structure.components.iter_mut().find(|c| c.name == component)
    {
        component.parameters.push(Parameter { name: variable.to_owned(), ..parameter });
        return;
    }
    let (place, name) = (parameter.place, parameter.name);
    structure.remarks.push(format!("{place}: no component has the parameter {name}"));
}

fn read_wire(element: Element<'_, '_>, path: &str, wires: &Wires) -> Result<Wire, Error> {
    let mut transformation = Linear::IDENTITY;
    for child in element.children().filter(|e| e.node.tag_name().namespace() == Some(SSC)) {
        if !child.is(SSC, "LinearTransformation") {
            let name = child.node.tag_name().name();
            return Err(child.not_supported(format!("a {name} on a connection")));
        }
        let factor = child.number("factor")?.unwrap_or(1.0);
        transformation = Linear { factor, offset: child.number("offset")?.unwrap_or(0.0) };
    }
    let start = (element.optional("startElement"), element.attribute("startConnector")?);
    let end = (element.optional("endElement"), element.attribute("endConnector")?);
    let written_as = |(name, connector): (Option<&str>, &str)| match name {
        Some(name) => format!("{name}.{connector}"),
        None => connector.to_owned(),
    };
    let wire_end = |(name, connector): (Option<&str>, &str)| {
        wires.end(path, name, connector).map_err(|known| {
            let name = name.unwrap_or_default();
            element.error(format!(
                "the connection of {} and {} names {name:?}, which is no component{}",
                written_as(start),
                written_as(end),
                near_text(&near(name, known.iter().map(String::as_str)))
            ))
        })
    };
    let ends = [wire_end(start)?, wire_end(end)?];
    let suppressed = match element.optional("suppressUnitConversion").map(str::trim) {
        None | Some("false" | "0") => false,
        Some("true" | "1") => true,
        Some(text) => {
            let problem = format!("suppressUnitConversion is {text:?}, not true or false");
            return Err(element.error(problem));
        }
    };
    let written = WrittenConnection { place: element.place(), suppressed, transformation };
    Ok(Wire::new(ends, path, written, element.file.package))
}

/// The base step in the annotation of the Open Simulation Platform.
fn step(experiment: Element<'_, '_>) -> Result<Option<f64>, Error> {
    let annotations = experiment.inside(SSD, "Annotations");
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

/// The units that an element defines; `namespace` is that of its file.
fn read_units(parent: Element<'_, '_>, namespace: &'static str) -> Result<Vec<Unit>, Error> {
    let all = parent.child(namespace, "Units").into_iter().flat_map(Element::children);
    all.filter(|element| element.is(SSC, "Unit"))
        .map(|element| {
            let name = element.attribute("name")?.to_owned();
            let base = element.child(SSC, "BaseUnit").map(read_base).transpose()?;
            Ok(Unit { name, base, display_units: Vec::new() })
        })
        .collect()
}

fn read_base(element: Element<'_, '_>) -> Result<BaseUnit, Error> {
    let mut exponents = [0; 8];
    for (exponent, symbol) in exponents.iter_mut().zip(BaseUnit::SYMBOLS) {
        if let Some(text) = element.optional(symbol) {
            let bad = || element.error(format!("{symbol} is {text:?}, not a whole number"));
            *exponent = text.trim().parse().map_err(|_| bad())?;
        }
    }
    let factor = element.number("factor")?.unwrap_or(1.0);
    if factor == 0.0 {
        return Err(element.error("the factor of a unit is 0"));
    }
    Ok(BaseUnit { exponents, factor, offset: element.number("offset")?.unwrap_or(0.0) })
}
