//! Writing `modelDescription.xml`: deterministic, indented, elements in the order of the schema.

use crate::description::{
    CoSimulation, DefaultExperiment, LogCategory, ModelDescription, Unknown, Variable,
    VendorAnnotation,
};
use crate::units::{BaseUnit, Unit};
use crate::vocabulary::{Kind, Value};
use quick_xml::Writer;
use quick_xml::events::{BytesEnd, BytesStart, BytesText, Event};
use std::io::Write;

impl ModelDescription {
    /// The XML text. Equal descriptions have equal bytes.
    ///
    /// Characters that XML cannot hold become U+FFFD. Enumerations are written as Integer, and
    /// model exchange, which this project does not export, is left out.
    #[must_use]
    pub fn to_xml(&self) -> String {
        let mut sink = Sink { writer: Writer::new_with_indent(Vec::new(), b' ', 2) };
        sink.document(self);
        let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        text.push_str(&String::from_utf8_lossy(&sink.writer.into_inner()));
        text.push('\n');
        text
    }
}

/// An element under construction.
struct Element(BytesStart<'static>);

impl Element {
    fn new(name: &'static str) -> Self {
        Self(BytesStart::new(name))
    }

    fn with(mut self, name: &'static str, value: &str) -> Self {
        let clean: String =
            value.chars().map(|c| if is_xml_character(c) { c } else { '\u{fffd}' }).collect();
        self.0.push_attribute((name, clean.as_str()));
        self
    }

    fn maybe(self, name: &'static str, value: Option<&String>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    fn number(self, name: &'static str, value: Option<f64>) -> Self {
        match value {
            Some(value) => self.with(name, &real(value)),
            None => self,
        }
    }

    /// A flag of which `false` is the default, and left out.
    fn flag(self, name: &'static str, value: bool) -> Self {
        if value { self.with(name, "true") } else { self }
    }
}

/// Section 2.2 of XML 1.0.
fn is_xml_character(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..)
}

struct Sink {
    writer: Writer<Vec<u8>>,
}

impl Sink {
    fn event(&mut self, event: Event<'_>) {
        // Writing to a vector cannot fail.
        let _ = self.writer.write_event(event);
    }

    fn empty(&mut self, element: Element) {
        self.event(Event::Empty(element.0));
    }

    /// An element with children; an empty one if there are none.
    fn parent(&mut self, element: Element, children: impl FnOnce(&mut Self)) {
        let end = element.0.name().as_ref().to_owned();
        self.event(Event::Start(element.0));
        children(self);
        self.event(Event::End(BytesEnd::new(end)));
    }

    /// An element around a list, left out if the list is empty, as the schema demands.
    fn list<T>(&mut self, name: &'static str, items: &[T], each: impl Fn(&mut Self, &T)) {
        if !items.is_empty() {
            self.parent(Element::new(name), |sink| items.iter().for_each(|item| each(sink, item)));
        }
    }

    fn document(&mut self, description: &ModelDescription) {
        let root = Element::new("fmiModelDescription")
            .with("fmiVersion", "2.0")
            .with("modelName", &description.model_name)
            .with("guid", &description.guid)
            .maybe("description", description.description.as_ref())
            .maybe("author", description.author.as_ref())
            .maybe("version", description.version.as_ref())
            .maybe("copyright", description.copyright.as_ref())
            .maybe("license", description.license.as_ref())
            .maybe("generationTool", description.generation_tool.as_ref())
            .with("variableNamingConvention", description.naming_convention.as_str());
        self.parent(root, |sink| {
            if let Some(co_simulation) = &description.co_simulation {
                sink.co_simulation(co_simulation);
            }
            sink.list("UnitDefinitions", &description.units, Self::unit);
            sink.list("LogCategories", &description.log_categories, Self::log_category);
            if let Some(experiment) = &description.default_experiment {
                sink.default_experiment(experiment);
            }
            sink.list("VendorAnnotations", &description.vendor_annotations, Self::annotation);
            sink.parent(Element::new("ModelVariables"), |sink| {
                for (variable, index) in description.variables.iter().zip(1_usize..) {
                    // The index of the standard, which counts from 1, as a comment for readers.
                    sink.event(Event::Comment(BytesText::new(&format!(" {index} "))));
                    sink.variable(variable);
                }
            });
            sink.parent(Element::new("ModelStructure"), |sink| {
                sink.list("Outputs", &description.outputs, Self::unknown);
                sink.list("Derivatives", &description.derivatives, Self::unknown);
                sink.list("InitialUnknowns", &description.initial_unknowns, Self::unknown);
            });
        });
    }

    fn co_simulation(&mut self, c: &CoSimulation) {
        let mut element = Element::new("CoSimulation")
            .with("modelIdentifier", &c.model_identifier)
            .flag("needsExecutionTool", c.needs_execution_tool)
            .flag(
                "canHandleVariableCommunicationStepSize",
                c.can_handle_variable_communication_step_size,
            )
            .flag("canInterpolateInputs", c.can_interpolate_inputs);
        if c.max_output_derivative_order > 0 {
            element = element
                .with("maxOutputDerivativeOrder", &c.max_output_derivative_order.to_string());
        }
        let element = element
            .flag("canRunAsynchronuously", c.can_run_asynchronously)
            .flag(
                "canBeInstantiatedOnlyOncePerProcess",
                c.can_be_instantiated_only_once_per_process,
            )
            .flag("canNotUseMemoryManagementFunctions", c.can_not_use_memory_management_functions)
            .flag("canGetAndSetFMUstate", c.can_get_and_set_fmu_state)
            .flag("canSerializeFMUstate", c.can_serialize_fmu_state)
            .flag("providesDirectionalDerivative", c.provides_directional_derivative);
        if c.source_files.is_empty() {
            self.empty(element);
        } else {
            self.parent(element, |sink| {
                sink.list("SourceFiles", &c.source_files, |sink, name| {
                    sink.empty(Element::new("File").with("name", name));
                });
            });
        }
    }

    fn unit(&mut self, unit: &Unit) {
        self.parent(Element::new("Unit").with("name", &unit.name), |sink| {
            if let Some(base) = &unit.base {
                let mut element = Element::new("BaseUnit");
                for (symbol, exponent) in BaseUnit::SYMBOLS.into_iter().zip(base.exponents) {
                    if exponent != 0 {
                        element = element.with(symbol, &exponent.to_string());
                    }
                }
                sink.empty(scale(element, base.factor, base.offset));
            }
            for display in &unit.display_units {
                let element = Element::new("DisplayUnit").with("name", &display.name);
                sink.empty(scale(element, display.factor, display.offset));
            }
        });
    }

    fn log_category(&mut self, category: &LogCategory) {
        let element = Element::new("Category").with("name", &category.name);
        self.empty(element.maybe("description", category.description.as_ref()));
    }

    fn default_experiment(&mut self, experiment: &DefaultExperiment) {
        self.empty(
            Element::new("DefaultExperiment")
                .number("startTime", experiment.start_time)
                .number("stopTime", experiment.stop_time)
                .number("tolerance", experiment.tolerance)
                .number("stepSize", experiment.step_size),
        );
    }

    fn annotation(&mut self, annotation: &VendorAnnotation) {
        let element = Element::new("Tool").with("name", &annotation.tool);
        let own = format!("<Tool>{}</Tool>", annotation.xml);
        if annotation.xml.is_empty() || roxmltree::Document::parse(&own).is_err() {
            self.empty(element);
        } else {
            self.parent(element, |sink| {
                let _ = sink.writer.get_mut().write_all(b"\n      ");
                let _ = sink.writer.get_mut().write_all(annotation.xml.as_bytes());
            });
        }
    }

    fn variable(&mut self, variable: &Variable) {
        let mut element = Element::new("ScalarVariable")
            .with("name", &variable.name)
            .with("valueReference", &variable.reference.to_string())
            .maybe("description", variable.description.as_ref())
            .with("causality", variable.causality.as_str())
            .with("variability", variable.variability.as_str());
        if let Some(initial) = variable.initial {
            element = element.with("initial", initial.as_str());
        }
        if let Some(multiple) = variable.can_handle_multiple_set {
            element = element.with(
                "canHandleMultipleSetPerTimeInstant",
                if multiple { "true" } else { "false" },
            );
        }
        let mut kind = Element::new(variable.kind.as_str())
            .maybe("quantity", variable.quantity.as_ref())
            .maybe("unit", variable.unit.as_ref())
            .maybe("displayUnit", variable.display_unit.as_ref());
        for (name, limit) in [("min", variable.min), ("max", variable.max)] {
            kind = match (variable.kind, limit) {
                // An integer limit has no decimal point; it is exact in an f64.
                (Kind::Integer, Some(limit)) => kind.with(name, &format!("{limit:.0}")),
                (_, limit) => kind.number(name, limit),
            };
        }
        kind = kind.number("nominal", variable.nominal);
        kind = match &variable.start {
            None => kind,
            Some(Value::Real(value)) => kind.number("start", Some(*value)),
            Some(Value::Integer(value)) => kind.with("start", &value.to_string()),
            Some(Value::Boolean(value)) => {
                kind.with("start", if *value { "true" } else { "false" })
            }
            Some(Value::String(value)) => kind.with("start", value),
        };
        if let Some(index) = variable.derivative {
            kind = kind.with("derivative", &index.to_string());
        }
        self.parent(element, |sink| sink.empty(kind));
    }

    fn unknown(&mut self, unknown: &Unknown) {
        let mut element = Element::new("Unknown").with("index", &unknown.index.to_string());
        if let Some(list) = &unknown.dependencies {
            let words: Vec<String> = list.iter().map(ToString::to_string).collect();
            element = element.with("dependencies", &words.join(" "));
        }
        if let Some(kinds) = &unknown.kinds {
            let words: Vec<&str> = kinds.iter().map(|kind| kind.as_str()).collect();
            element = element.with("dependenciesKind", &words.join(" "));
        }
        self.empty(element);
    }
}

/// Adds a factor and an offset that are not the defaults.
fn scale(element: Element, factor: f64, offset: f64) -> Element {
    let element = element.number("factor", Some(factor).filter(|factor| *factor != 1.0));
    element.number("offset", Some(offset).filter(|offset| *offset != 0.0))
}

/// An `xs:double` with the fewest digits that read back to the same number, in any locale.
fn real(value: f64) -> String {
    if value.is_nan() {
        "NaN".into()
    } else if value.is_infinite() {
        if value > 0.0 { "INF".into() } else { "-INF".into() }
    } else {
        format!("{value:?}")
    }
}
