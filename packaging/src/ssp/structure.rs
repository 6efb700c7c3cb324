//! Writing `SystemStructure.ssd`.

use super::inputs::SystemInput;
use super::{Component, Experiment};
use crate::Error;
use model_description::{BaseUnit, Causality, Kind, Unit, Variable};
use quick_xml::Writer;
use std::io;
use steerwright_host::Connection;

type Xml = Writer<Vec<u8>>;

type Inner<'a> = &'a dyn Fn(&mut Xml) -> io::Result<()>;

/// Namespaces by prefix.
const NAMESPACES: [(&str, &str); 4] = [
    ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
    ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
    ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
    ("xmlns:osp", "http://opensimulationplatform.com/SSP/OSPAnnotations"),
];

pub(super) fn source(component: &Component<'_>) -> String {
    format!("resources/{}.fmu", component.name())
}

/// A structure file.
#[derive(Clone, Copy)]
pub(super) struct Structure<'a> {
    /// The name among the variants of the package.
    pub(super) title: &'a str,
    /// The name of the system.
    pub(super) name: &'a str,
    pub(super) components: &'a [Component<'a>],
    pub(super) connections: &'a [Connection],
    /// The connectors of the system.
    pub(super) inputs: &'a [SystemInput<'a>],
    pub(super) experiment: Experiment,
}

impl Structure<'_> {
    pub(super) fn to_xml(self) -> Result<String, Error> {
        for connection in self.connections {
            check(self.components, connection)?;
        }
        for component in self.components {
            for (variable, _) in &component.start {
                let known = component.packed.description.variable(variable);
                if known.is_none_or(|v| v.kind != Kind::Real) {
                    return Err(no_variable(component.name(), variable, "Real variable"));
                }
            }
        }
        let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
        let whole = document(&mut xml, &self);
        whole.map_err(|source| Error::Package { name: self.name.into(), source: source.into() })?;
        let text = String::from_utf8_lossy(&xml.into_inner()).into_owned();
        Ok(format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{text}\n"))
    }

    /// Whether an output or a connector of the system feeds an input.
    fn is_fed(&self, component: &str, input: &str) -> bool {
        self.connections.iter().any(|c| c.to == component && c.input == input)
            || self.inputs.iter().any(|i| i.feeds(component, input))
    }

    /// The values that a component states: those that the system states for it are left out.
    fn start_of<'a>(&self, component: &'a Component<'_>) -> Vec<&'a (String, f64)> {
        let of_system = |name: &str| {
            self.inputs.iter().any(|i| i.start.is_some() && i.feeds(component.name(), name))
        };
        component.start.iter().filter(|(name, _)| !of_system(name)).collect()
    }
}

fn check(components: &[Component<'_>], c: &Connection) -> Result<(), Error> {
    let output = find(components, &c.from, &c.output, Causality::Output)?;
    let input = find(components, &c.to, &c.input, Causality::Input)?;
    if output.kind != input.kind || output.unit != input.unit {
        return Err(Error::Connection { connection: c.to_string() });
    }
    Ok(())
}

fn find<'a>(
    components: &'a [Component<'_>],
    component: &str,
    variable: &str,
    causality: Causality,
) -> Result<&'a Variable, Error> {
    let known = components.iter().find(|c| c.name() == component);
    let found = known.and_then(|c| c.packed.description.variable(variable));
    found
        .filter(|v| v.causality == causality)
        .ok_or_else(|| no_variable(component, variable, causality.as_str()))
}

fn no_variable(component: &str, variable: &str, need: &'static str) -> Error {
    Error::NoVariable { variable: format!("{component}.{variable}"), need }
}

fn document(xml: &mut Xml, structure: &Structure<'_>) -> io::Result<()> {
    xml.create_element("ssd:SystemStructureDescription")
        .with_attributes(NAMESPACES)
        .with_attributes([
            ("version", "1.0"),
            ("name", structure.title),
            ("generationTool", crate::provenance::TOOL),
        ])
        .write_inner_content(|xml| {
            let tag = xml.create_element("ssd:System").with_attribute(("name", structure.name));
            tag.write_inner_content(|xml| {
                system_connectors(xml, structure.inputs)?;
                xml.create_element("ssd:Elements").write_inner_content(|xml| {
                    structure.components.iter().try_for_each(|c| element(xml, c, structure))
                })?;
                wires(xml, structure)
            })?;
            units(xml, structure)?;
            default_experiment(xml, structure.experiment)
        })?;
    Ok(())
}

/// The connectors of the system, and the values that they have without a source.
fn system_connectors(xml: &mut Xml, inputs: &[SystemInput<'_>]) -> io::Result<()> {
    if inputs.is_empty() {
        return Ok(());
    }
    nested(xml, &["ssd:Connectors"], &|xml| {
        inputs.iter().try_for_each(|input| {
            connector(xml, input.name, Causality::Input, Kind::Real, input.unit)
        })
    })?;
    let started = inputs.iter().filter_map(|input| Some((input.name, input.start?, input.unit)));
    parameters(xml, &started.collect::<Vec<_>>())
}

/// A component: its connectors, and the values it starts with.
fn element(xml: &mut Xml, component: &Component<'_>, structure: &Structure<'_>) -> io::Result<()> {
    let description = &component.packed.description;
    let tag = xml.create_element("ssd:Component").with_attributes([
        ("name", component.name()),
        ("type", "application/x-fmu-sharedlibrary"),
        ("source", &source(component)),
        ("implementation", "CoSimulation"),
    ]);
    let text = description.description.as_deref().map(|text| ("description", text));
    tag.with_attributes(text).write_inner_content(|xml| {
        xml.create_element("ssd:Connectors").write_inner_content(|xml| {
            connectors(component, structure).try_for_each(|v| {
                let unit = v.unit.as_deref().filter(|_| v.kind == Kind::Real);
                connector(xml, &v.name, v.causality, v.kind, unit)
            })
        })?;
        let started = structure.start_of(component).into_iter().map(|(name, value)| {
            let unit = description.variable(name).and_then(|v| v.unit.as_deref());
            (name.as_str(), *value, unit)
        });
        parameters(xml, &started.collect::<Vec<_>>())
    })?;
    Ok(())
}

/// The start values of a component or of the system: name, value, unit.
fn parameters(xml: &mut Xml, values: &[(&str, f64, Option<&str>)]) -> io::Result<()> {
    if values.is_empty() {
        return Ok(());
    }
    let names = ["ssd:ParameterBindings", "ssd:ParameterBinding", "ssd:ParameterValues"];
    nested(xml, &names, &|xml| {
        xml.create_element("ssv:ParameterSet")
            .with_attributes([("version", "1.0"), ("name", "start")])
            .write_inner_content(|xml| {
                nested(xml, &["ssv:Parameters"], &|xml| {
                    values
                        .iter()
                        .try_for_each(|(name, value, unit)| parameter(xml, name, *value, *unit))
                })
            })?;
        Ok(())
    })
}

/// Nested elements without attributes around the content of `inner`.
fn nested(xml: &mut Xml, names: &[&'static str], inner: Inner<'_>) -> io::Result<()> {
    match names.split_first() {
        None => inner(xml),
        Some((first, rest)) => {
            xml.create_element(*first).write_inner_content(|xml| nested(xml, rest, inner))?;
            Ok(())
        }
    }
}

/// The component's outputs and fed inputs, in the order of its description.
fn connectors<'a>(
    component: &'a Component<'_>,
    structure: &'a Structure<'_>,
) -> impl Iterator<Item = &'a Variable> {
    let name = component.name();
    component.packed.description.variables.iter().filter(move |v| match v.causality {
        Causality::Output => true,
        Causality::Input => structure.is_fed(name, &v.name),
        _ => false,
    })
}

fn connector(
    xml: &mut Xml,
    name: &str,
    causality: Causality,
    kind: Kind,
    unit: Option<&str>,
) -> io::Result<()> {
    xml.create_element("ssd:Connector")
        .with_attributes([("name", name), ("kind", causality.as_str())])
        .write_inner_content(|xml| {
            xml.create_element(format!("ssc:{}", kind.as_str()))
                .with_attributes(unit.map(|unit| ("unit", unit)))
                .write_empty()?;
            Ok(())
        })?;
    Ok(())
}

fn parameter(xml: &mut Xml, name: &str, value: f64, unit: Option<&str>) -> io::Result<()> {
    xml.create_element("ssv:Parameter").with_attribute(("name", name)).write_inner_content(
        |xml| {
            // The shortest text that reads back to the same number.
            let value = format!("{value:?}");
            xml.create_element("ssv:Real")
                .with_attribute(("value", value.as_str()))
                .with_attributes(unit.map(|unit| ("unit", unit)))
                .write_empty()?;
            Ok(())
        },
    )?;
    Ok(())
}

/// The connections of the system's connectors, which have no start element, and those between components.
fn wires(xml: &mut Xml, structure: &Structure<'_>) -> io::Result<()> {
    let connections = structure.connections;
    if connections.is_empty() && structure.inputs.is_empty() {
        return Ok(());
    }
    nested(xml, &["ssd:Connections"], &|xml| {
        for input in structure.inputs {
            for component in &input.components {
                wire(xml, None, input.name, component, input.name)?;
            }
        }
        connections.iter().try_for_each(|c| wire(xml, Some(&c.from), &c.output, &c.to, &c.input))
    })
}

fn wire(xml: &mut Xml, from: Option<&str>, output: &str, to: &str, input: &str) -> io::Result<()> {
    xml.create_element("ssd:Connection")
        .with_attributes(from.map(|from| ("startElement", from)))
        .with_attributes([("startConnector", output), ("endElement", to), ("endConnector", input)])
        .write_empty()?;
    Ok(())
}

/// The units that connectors and parameters cite.
fn units(xml: &mut Xml, structure: &Structure<'_>) -> io::Result<()> {
    let mut cited: Vec<&Unit> = Vec::new();
    for component in structure.components {
        let description = &component.packed.description;
        let started = component.start.iter().filter_map(|(name, _)| description.variable(name));
        let variables = connectors(component, structure).chain(started);
        for name in variables.filter_map(|v| v.unit.as_deref()) {
            let unit = description.units.iter().find(|unit| unit.name == name);
            cited.extend(unit.filter(|_| cited.iter().all(|known| known.name != name)));
        }
    }
    if cited.is_empty() {
        return Ok(());
    }
    nested(xml, &["ssd:Units"], &|xml| {
        cited.iter().try_for_each(|unit| {
            let named = xml.create_element("ssc:Unit").with_attribute(("name", &*unit.name));
            named.write_inner_content(|xml| {
                let mut tag = xml.create_element("ssc:BaseUnit");
                if let Some(base) = &unit.base {
                    for (name, exponent) in BaseUnit::SYMBOLS.into_iter().zip(base.exponents) {
                        if exponent != 0 {
                            tag = tag.with_attribute((name, exponent.to_string().as_str()));
                        }
                    }
                }
                tag.write_empty()?;
                Ok(())
            })?;
            Ok(())
        })
    })
}

fn default_experiment(xml: &mut Xml, experiment: Experiment) -> io::Result<()> {
    let (step, stop) = (format!("{:?}", experiment.step), format!("{:?}", experiment.stop));
    xml.create_element("ssd:DefaultExperiment")
        .with_attributes([("startTime", "0.0"), ("stopTime", stop.as_str())])
        .write_inner_content(|xml| {
            nested(xml, &["ssd:Annotations"], &|xml| {
                xml.create_element("ssc:Annotation")
                    .with_attribute(("type", "com.opensimulationplatform"))
                    .write_inner_content(|xml| {
                        nested(xml, &["osp:Algorithm"], &|xml| {
                            xml.create_element("osp:FixedStepAlgorithm")
                                .with_attribute(("baseStepSize", step.as_str()))
                                .write_empty()?;
                            Ok(())
                        })
                    })?;
                Ok(())
            })
        })?;
    Ok(())
}
