//! Reading `modelDescription.xml` of any tool.
//!
//! The reader is tolerant: unknown elements and attributes are skipped, declared types supply
//! attributes that variables omit, and [`crate::ModelDescription::findings`] reports violations of the
//! standard's rules. It rejects documents without a meaning: another version than FMI 2.0, a missing
//! name, an invalid number, a document type declaration (which can define entities that multiply).

use crate::Error;
use crate::description::{
    CoSimulation, DefaultExperiment, LogCategory, ModelDescription, ModelExchange, Unknown,
    Variable, VendorAnnotation,
};
use crate::excess::Excess;
use crate::units::{BaseUnit, DisplayUnit, Unit};
use crate::vocabulary::{
    Causality, DependencyKind, Initial, Kind, NamingConvention, Value, Variability,
};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::BTreeMap;

/// Elements, texts and comments a description may have; the largest known ones have about 10⁶.
const NODES_LIMIT: u32 = 16_000_000;

impl ModelDescription {
    /// Reads a `modelDescription.xml`.
    ///
    /// # Errors
    /// [`Error`] with the line of the fault.
    pub fn from_xml(text: &str) -> Result<Self, Error> {
        let options = ParsingOptions { nodes_limit: NODES_LIMIT, ..ParsingOptions::default() };
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if let Some(Excess { kind, line }) = Excess::find(text) {
            return Err(Error::Malformed { line, column: 1, problem: kind.to_string() });
        }
        let document =
            Document::parse_with_options(text, options).map_err(|error| match error {
                roxmltree::Error::DtdDetected => Error::DocumentType,
                error => {
                    let place = error.pos();
                    Error::Malformed {
                        line: place.row,
                        column: place.col,
                        problem: error.to_string(),
                    }
                }
            })?;
        description(Reader { node: document.root_element() })
    }
}

/// An element and the ways to read it.
#[derive(Clone, Copy)]
struct Reader<'a, 'input> {
    node: Node<'a, 'input>,
}

impl<'a, 'input> Reader<'a, 'input> {
    fn line(self) -> u32 {
        self.node.document().text_pos_at(self.node.range().start).row
    }

    fn name(self) -> &'a str {
        self.node.tag_name().name()
    }

    fn children(self) -> impl Iterator<Item = Self> {
        self.node.children().filter(Node::is_element).map(|node| Self { node })
    }

    fn named(self, name: &'static str) -> impl Iterator<Item = Self> {
        self.children().filter(move |child| child.name() == name)
    }

    fn child(self, name: &'static str) -> Option<Self> {
        self.named(name).next()
    }

    /// The `name` children of the child `list`.
    fn items(self, list: &'static str, name: &'static str) -> impl Iterator<Item = Self> {
        self.child(list).into_iter().flat_map(move |list| list.named(name))
    }

    fn need(self, child: &'static str) -> Result<Self, Error> {
        self.child(child).ok_or_else(|| self.without(child))
    }

    fn without(self, child: &'static str) -> Error {
        Error::MissingElement { line: self.line(), element: self.name().into(), child }
    }

    fn text(self, attribute: &'static str) -> Option<String> {
        self.node.attribute(attribute).map(Into::into)
    }

    fn needed<T>(self, attribute: &'static str, value: Option<T>) -> Result<T, Error> {
        value.ok_or_else(|| Error::MissingAttribute {
            line: self.line(),
            element: self.name().into(),
            attribute,
        })
    }

    fn invalid(self, attribute: &'static str, value: &str, expected: &'static str) -> Error {
        Error::InvalidAttribute {
            line: self.line(),
            element: self.name().into(),
            attribute,
            value: value.chars().take(60).collect(),
            expected,
        }
    }

    fn parsed<T>(
        self,
        attribute: &'static str,
        expected: &'static str,
        parse: impl FnOnce(&str) -> Option<T>,
    ) -> Result<Option<T>, Error> {
        let Some(text) = self.node.attribute(attribute) else { return Ok(None) };
        parse(text).map(Some).ok_or_else(|| self.invalid(attribute, text, expected))
    }

    fn real(self, attribute: &'static str) -> Result<Option<f64>, Error> {
        self.parsed(attribute, "a number", |text| text.trim().parse().ok())
    }

    fn integer(self, attribute: &'static str) -> Result<Option<i32>, Error> {
        self.parsed(attribute, "an integer", |text| text.trim().parse().ok())
    }

    fn unsigned(self, attribute: &'static str) -> Result<Option<u32>, Error> {
        self.parsed(attribute, "an unsigned integer", |text| text.trim().parse().ok())
    }

    fn boolean(self, attribute: &'static str) -> Result<Option<bool>, Error> {
        self.parsed(attribute, "true or false", parse_boolean)
    }

    fn flag(self, attribute: &'static str) -> Result<bool, Error> {
        Ok(self.boolean(attribute)?.unwrap_or(false))
    }
}

fn description(root: Reader<'_, '_>) -> Result<ModelDescription, Error> {
    let version = root.text("fmiVersion");
    let fmi2 = version.as_deref().is_some_and(|version| version.trim() == "2.0");
    if root.name() != "fmiModelDescription" || !fmi2 {
        let found = match version {
            Some(version) => format!("<{}> of version {version}", root.name()),
            None => format!("<{}>", root.name()),
        };
        return Err(Error::NotFmi2 { line: root.line(), found: found.chars().take(80).collect() });
    }
    let types: BTreeMap<String, Reader<'_, '_>> = root
        .items("TypeDefinitions", "SimpleType")
        .filter_map(|simple| Some((simple.text("name")?, simple.children().next()?)))
        .collect();
    let mut variables = Vec::new();
    for child in root.need("ModelVariables")?.named("ScalarVariable") {
        variables.push(variable(child, &types)?);
    }
    let structure = root.child("ModelStructure");
    let unknowns = |list| match structure {
        Some(structure) => structure.items(list, "Unknown").map(unknown).collect(),
        None => Ok(Vec::new()),
    };
    Ok(ModelDescription {
        model_name: root.needed("modelName", root.text("modelName"))?,
        guid: root.needed("guid", root.text("guid"))?,
        description: root.text("description"),
        author: root.text("author"),
        version: root.text("version"),
        copyright: root.text("copyright"),
        license: root.text("license"),
        generation_tool: root.text("generationTool"),
        naming_convention: root
            .parsed("variableNamingConvention", "flat or structured", NamingConvention::from_word)?
            .unwrap_or_default(),
        co_simulation: root.child("CoSimulation").map(co_simulation).transpose()?,
        model_exchange: root.child("ModelExchange").map(model_exchange).transpose()?,
        units: root.items("UnitDefinitions", "Unit").map(unit).collect::<Result<_, _>>()?,
        log_categories: root
            .items("LogCategories", "Category")
            .map(log_category)
            .collect::<Result<_, _>>()?,
        default_experiment: root.child("DefaultExperiment").map(experiment).transpose()?,
        vendor_annotations: root.items("VendorAnnotations", "Tool").map(annotation).collect(),
        variables,
        outputs: unknowns("Outputs")?,
        derivatives: unknowns("Derivatives")?,
        initial_unknowns: unknowns("InitialUnknowns")?,
    })
}

fn co_simulation(reader: Reader<'_, '_>) -> Result<CoSimulation, Error> {
    Ok(CoSimulation {
        model_identifier: reader.needed("modelIdentifier", reader.text("modelIdentifier"))?,
        needs_execution_tool: reader.flag("needsExecutionTool")?,
        can_handle_variable_communication_step_size: reader
            .flag("canHandleVariableCommunicationStepSize")?,
        can_interpolate_inputs: reader.flag("canInterpolateInputs")?,
        max_output_derivative_order: reader.unsigned("maxOutputDerivativeOrder")?.unwrap_or(0),
        can_run_asynchronously: reader.flag("canRunAsynchronuously")?,
        can_be_instantiated_only_once_per_process: reader
            .flag("canBeInstantiatedOnlyOncePerProcess")?,
        can_not_use_memory_management_functions: reader
            .flag("canNotUseMemoryManagementFunctions")?,
        can_get_and_set_fmu_state: reader.flag("canGetAndSetFMUstate")?,
        can_serialize_fmu_state: reader.flag("canSerializeFMUstate")?,
        provides_directional_derivative: reader.flag("providesDirectionalDerivative")?,
        source_files: reader
            .items("SourceFiles", "File")
            .map(|file| file.needed("name", file.text("name")))
            .collect::<Result<_, _>>()?,
    })
}

fn model_exchange(reader: Reader<'_, '_>) -> Result<ModelExchange, Error> {
    let model_identifier = reader.needed("modelIdentifier", reader.text("modelIdentifier"))?;
    Ok(ModelExchange { model_identifier })
}

fn unit(reader: Reader<'_, '_>) -> Result<Unit, Error> {
    let base = match reader.child("BaseUnit") {
        None => None,
        Some(child) => {
            let mut exponents = [0; 8];
            for (exponent, symbol) in exponents.iter_mut().zip(BaseUnit::SYMBOLS) {
                *exponent = child.integer(symbol)?.unwrap_or(0);
            }
            let factor = child.real("factor")?.unwrap_or(1.0);
            Some(BaseUnit { exponents, factor, offset: child.real("offset")?.unwrap_or(0.0) })
        }
    };
    let display = |child: Reader<'_, '_>| {
        Ok(DisplayUnit {
            name: child.needed("name", child.text("name"))?,
            factor: child.real("factor")?.unwrap_or(1.0),
            offset: child.real("offset")?.unwrap_or(0.0),
        })
    };
    Ok(Unit {
        name: reader.needed("name", reader.text("name"))?,
        base,
        display_units: reader.named("DisplayUnit").map(display).collect::<Result<_, _>>()?,
    })
}

fn log_category(reader: Reader<'_, '_>) -> Result<LogCategory, Error> {
    let name = reader.needed("name", reader.text("name"))?;
    Ok(LogCategory { name, description: reader.text("description") })
}

fn experiment(reader: Reader<'_, '_>) -> Result<DefaultExperiment, Error> {
    Ok(DefaultExperiment {
        start_time: reader.real("startTime")?,
        stop_time: reader.real("stopTime")?,
        tolerance: reader.real("tolerance")?,
        step_size: reader.real("stepSize")?,
    })
}

/// The XML inside `<Tool>`, as it stands in the text.
fn annotation(reader: Reader<'_, '_>) -> VendorAnnotation {
    let inner = match (reader.node.first_child(), reader.node.last_child()) {
        (Some(first), Some(last)) => reader
            .node
            .document()
            .input_text()
            .get(first.range().start..last.range().end)
            .unwrap_or(""),
        _ => "",
    };
    VendorAnnotation { tool: reader.text("name").unwrap_or_default(), xml: inner.trim().into() }
}

/// A variable; its declared type may supply what its type element omits.
fn variable(
    reader: Reader<'_, '_>,
    types: &BTreeMap<String, Reader<'_, '_>>,
) -> Result<Variable, Error> {
    let element = reader
        .children()
        .find(|child| kind(child.name()).is_some())
        .ok_or_else(|| reader.without("Real | Integer | Boolean | String | Enumeration"))?;
    let kind = kind(element.name()).unwrap_or_default();
    let declared = element.text("declaredType").and_then(|name| types.get(&name).copied());
    let real = |attribute| match (element.real(attribute)?, declared) {
        (None, Some(declared)) => declared.real(attribute),
        (own, _) => Ok(own),
    };
    let text = |attribute| {
        element.text(attribute).or_else(|| declared.and_then(|declared| declared.text(attribute)))
    };
    let start = match kind {
        Kind::Real => element.real("start")?.map(Value::Real),
        Kind::Integer => element.integer("start")?.map(Value::Integer),
        Kind::Boolean => element.boolean("start")?.map(Value::Boolean),
        Kind::String => element.text("start").map(Value::String),
    };
    Ok(Variable {
        name: reader.needed("name", reader.text("name"))?,
        reference: reader.needed("valueReference", reader.unsigned("valueReference")?)?,
        kind,
        is_enumeration: element.name() == "Enumeration",
        description: reader.text("description"),
        causality: reader
            .parsed("causality", "a causality of FMI 2.0", Causality::from_word)?
            .unwrap_or_default(),
        variability: reader
            .parsed("variability", "a variability of FMI 2.0", Variability::from_word)?
            .unwrap_or_default(),
        initial: reader.parsed("initial", "exact, approx or calculated", Initial::from_word)?,
        can_handle_multiple_set: reader.boolean("canHandleMultipleSetPerTimeInstant")?,
        unit: text("unit"),
        display_unit: text("displayUnit"),
        quantity: text("quantity"),
        min: real("min")?,
        max: real("max")?,
        nominal: real("nominal")?,
        start,
        derivative: element.unsigned("derivative")?,
    })
}

fn kind(element: &str) -> Option<Kind> {
    if element == "Enumeration" { Some(Kind::Integer) } else { Kind::from_word(element) }
}

fn unknown(reader: Reader<'_, '_>) -> Result<Unknown, Error> {
    let dependencies = reader.parsed("dependencies", "indices of variables", |text| {
        text.split_ascii_whitespace().map(|word| word.parse().ok()).collect::<Option<Vec<u32>>>()
    })?;
    let kinds = reader.parsed("dependenciesKind", "kinds of dependencies of FMI 2.0", |text| {
        text.split_ascii_whitespace()
            .map(DependencyKind::from_word)
            .collect::<Option<Vec<DependencyKind>>>()
    })?;
    Ok(Unknown { index: reader.needed("index", reader.unsigned("index")?)?, dependencies, kinds })
}

/// The value of an `xs:boolean`.
fn parse_boolean(text: &str) -> Option<bool> {
    match text.trim() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}
