//! Faults of the XML syntax, and violations of the schema.

use super::Edit::{Files as InFiles, Xml};
use super::{Fault, fault};

pub(super) static FAULTS: &[Fault] = &[
    // --- the schema
    fault(
        "element-unknown",
        "xsd-element",
        Xml("<VendorAnnotations>", "<Extra/><VendorAnnotations>"),
    ),
    fault(
        "element-order",
        "xsd-element",
        InFiles(|f| {
            let experiment = r#"<DefaultExperiment startTime="0" stopTime="1" stepSize="0.125"/>"#;
            f.replace(experiment, "");
            f.replace("<UnitDefinitions>", &format!("{experiment}<UnitDefinitions>"));
        }),
    ),
    fault(
        "element-twice",
        "xsd-element",
        Xml("<DefaultExperiment", "<DefaultExperiment/><DefaultExperiment"),
    ),
    fault("two-types-of-a-variable", "xsd-element", Xml(r#"<Boolean/>"#, "<Boolean/><Boolean/>")),
    fault("child-of-a-leaf", "xsd-element", Xml(r#"<Boolean/>"#, "<Boolean><x/></Boolean>")),
    fault(
        "no-model-structure",
        "xsd-element-missing",
        InFiles(|f| {
            let text = String::from_utf8(f.get("modelDescription.xml").clone()).unwrap();
            let (head, tail) = text.split_once("<ModelStructure>").unwrap();
            let (_, tail) = tail.split_once("</ModelStructure>").unwrap();
            // No outputs and no states, so that nothing else is missing.
            let head = head.replace(r#"causality="output""#, "").replace(
                r#" variability="discrete"><B"#,
                r#" causality="local" variability="discrete"><B"#,
            );
            *f.get("modelDescription.xml") = format!("{head}{tail}").into_bytes();
        }),
    ),
    fault("empty-list", "xsd-element-missing", Xml(r#"<Tool name="One"/><Tool name="Two"/>"#, "")),
    fault("variable-without-type", "xsd-element-missing", Xml("<Boolean/>", "")),
    fault(
        "attribute-unknown",
        "xsd-attribute",
        Xml(r#"modelName="Base""#, r#"modelName="Base" tool="x""#),
    ),
    fault(
        "attribute-of-fmi-1",
        "xsd-attribute",
        Xml(r#"modelName="Base""#, r#"modelName="Base" numberOfContinuousStates="1""#),
    ),
    fault(
        "attribute-spelt-right",
        "xsd-attribute",
        Xml("<CoSimulation", "<CoSimulation canRunAsynchronously=\"false\""),
    ),
    fault("guid-missing", "xsd-attribute-missing", Xml(r#" guid="base""#, "")),
    fault(
        "value-reference-missing",
        "xsd-attribute-missing",
        Xml(r#"name="gain" valueReference="1""#, r#"name="gain""#),
    ),
    fault(
        "enumeration-without-type",
        "xsd-attribute-missing",
        Xml(r#"<Enumeration declaredType="Mode""#, "<Enumeration"),
    ),
    fault("fmi-3", "fmi-version", Xml(r#"fmiVersion="2.0""#, r#"fmiVersion="3.0" x="1""#)),
    fault("fmi-1", "fmi-version", Xml(r#"fmiVersion="2.0""#, r#"fmiVersion="1.0""#)),
    fault("fmi-version", "xsd-value", Xml(r#"fmiVersion="2.0""#, r#"fmiVersion="2.0.4""#)),
    fault("decimal-comma", "xsd-value", Xml(r#"stepSize="0.125""#, r#"stepSize="0,125""#)),
    fault(
        "negative-reference",
        "xsd-value",
        Xml(r#"name="gain" valueReference="1""#, r#"name="gain" valueReference="-1""#),
    ),
    fault("integer-with-fraction", "xsd-value", Xml(r#"start="3""#, r#"start="3.0""#)),
    fault(
        "boolean-word",
        "xsd-value",
        Xml(r#"canSerializeFMUstate="true""#, r#"canSerializeFMUstate="True""#),
    ),
    fault("causality-word", "xsd-value", Xml(r#"causality="independent""#, r#"causality="time""#)),
    fault("date-of-february-30", "xsd-value", Xml("2009-12-08T", "2009-02-30T")),
    fault("dependency-word", "xsd-value", Xml(r#"dependencies="1 3""#, r#"dependencies="1, 3""#)),
    fault("text-in-between", "xsd-text", Xml("<ModelVariables>", "<ModelVariables>variables")),
    fault(
        "infinite-limit",
        "special-value",
        Xml(r#"min="-10" max="10""#, r#"min="-10" max="INF""#),
    ),
    // --- the text
    fault("no-declaration", "xml-encoding", Xml(r#"<?xml version="1.0" encoding="UTF-8"?>"#, "")),
    fault("latin-1", "xml-encoding", Xml(r#"encoding="UTF-8""#, r#"encoding="ISO-8859-1""#)),
    fault(
        "not-utf-8",
        "xml-undecodable",
        InFiles(|f| {
            f.replace("logAll", "log\u{e4}All");
            let xml = f.get("modelDescription.xml");
            let at = xml.iter().position(|b| *b == 0xc3).unwrap();
            xml.remove(at);
        }),
    ),
    fault("unclosed", "xml-malformed", Xml("</ModelVariables>", "")),
    fault(
        "document-type",
        "xml-refused",
        Xml("<fmiModelDescription", "<!DOCTYPE x [<!ENTITY a \"b\">]><fmiModelDescription"),
    ),
    fault(
        "deep-nesting",
        "not-examined",
        InFiles(|f| {
            let (open, close) = ("<a>".repeat(100_000), "</a>".repeat(100_000));
            f.replace(r#"<Tool name="One"/>"#, &format!("<Tool name=\"One\">{open}{close}</Tool>"));
        }),
    ),
];
