//! The faults, each a small change of the good archive with the one rule that it breaks.

use super::{Files, base, binary_name};

/// A fault.
pub(crate) struct Fault {
    /// Its name, for people and files.
    pub(crate) name: &'static str,
    /// The rule it breaks.
    pub(crate) rule: &'static str,
    edit: Edit,
}

/// How it gets into the archive.
enum Edit {
    /// A replacement in modelDescription.xml.
    Xml(&'static str, &'static str),
    /// A change of the files.
    Files(fn(&mut Files)),
    /// A change of the archive's bytes.
    Bytes(fn(&mut Vec<u8>)),
    /// Both.
    Both(fn(&mut Files), fn(&mut Vec<u8>)),
}

use Edit::{Both, Bytes, Files as InFiles, Xml};

impl Fault {
    /// The archive with the fault.
    pub(crate) fn archive(&self) -> Vec<u8> {
        let mut files = base();
        match self.edit {
            Xml(from, to) => files.replace(from, to),
            InFiles(edit) => edit(&mut files),
            Bytes(_) => {}
            Both(edit, _) => edit(&mut files),
        }
        let mut bytes = files.zip();
        if let Bytes(edit) | Both(_, edit) = self.edit {
            edit(&mut bytes);
        }
        bytes
    }
}

const fn fault(name: &'static str, rule: &'static str, edit: Edit) -> Fault {
    Fault { name, rule, edit }
}

const GAIN: &str = r#"name="gain" valueReference="1" causality="parameter" variability="tunable"><Real start="1"/>"#;

pub(crate) static FAULTS: &[Fault] = &[
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
        "xml-encoding",
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
        "xml-refused",
        InFiles(|f| {
            let (open, close) = ("<a>".repeat(100_000), "</a>".repeat(100_000));
            f.replace(r#"<Tool name="One"/>"#, &format!("<Tool name=\"One\">{open}{close}</Tool>"));
        }),
    ),
    // --- the model as a whole
    fault(
        "no-interface",
        "interface",
        InFiles(|f| {
            let text = String::from_utf8(f.get("modelDescription.xml").clone()).unwrap();
            let (head, tail) = text.split_once("<CoSimulation").unwrap();
            let (_, tail) = tail.split_once("</CoSimulation>").unwrap();
            *f.get("modelDescription.xml") = format!("{head}{tail}").into_bytes();
            f.remove("sources/base.c");
        }),
    ),
    fault(
        "two-co-simulations",
        "interface-twice",
        Xml("<UnitDefinitions>", r#"<CoSimulation modelIdentifier="Base"/><UnitDefinitions>"#),
    ),
    fault(
        "serialize-alone",
        "serialize-needs-get-and-set",
        Xml(r#" canGetAndSetFMUstate="true""#, ""),
    ),
    fault("guid-empty", "guid-empty", Xml(r#"guid="base""#, r#"guid="""#)),
    fault(
        "no-c-identifier",
        "model-identifier",
        InFiles(|f| {
            f.replace(r#"modelIdentifier="Base""#, r#"modelIdentifier="1 Base""#);
            let name = binary_name();
            f.rename(&name, &name.replace("Base", "1 Base"));
        }),
    ),
    // --- units, types, categories, experiment
    fault(
        "unit-twice",
        "unit-twice",
        Xml(r#"<Unit name="m/s">"#, r#"<Unit name="m"/><Unit name="m/s">"#),
    ),
    fault(
        "display-unit-twice",
        "display-unit-twice",
        Xml("<DisplayUnit", r#"<DisplayUnit name="km"/><DisplayUnit"#),
    ),
    fault("unit-undefined", "unit-undefined", Xml(r#"unit="m/s" min"#, r#"unit="mps" min"#)),
    fault(
        "display-unit-alone",
        "display-unit-without-unit",
        Xml("<Real nominal", r#"<Real displayUnit="km" nominal"#),
    ),
    fault(
        "type-twice",
        "type-twice",
        Xml(
            r#"<SimpleType name="Mode">"#,
            r#"<SimpleType name="Length"><Real/></SimpleType><SimpleType name="Mode">"#,
        ),
    ),
    fault(
        "type-named-as-variable",
        "type-named-as-variable",
        Xml(
            r#"<SimpleType name="Mode">"#,
            r#"<SimpleType name="gain"><Real/></SimpleType><SimpleType name="Mode">"#,
        ),
    ),
    fault(
        "item-value-twice",
        "enumeration-item-twice",
        Xml(r#"name="on" value="2""#, r#"name="on" value="1""#),
    ),
    fault(
        "min-above-max",
        "min-above-max",
        Xml(r#"min="-1000" max="1000""#, r#"min="1000" max="-1000""#),
    ),
    fault("nominal-zero", "nominal", Xml(r#"nominal="2""#, r#"nominal="0""#)),
    fault(
        "category-twice",
        "log-category-twice",
        Xml(r#"name="logAll""#, r#"name="logStatusError""#),
    ),
    fault("stop-before-start", "stop-before-start", Xml(r#"stopTime="1""#, r#"stopTime="-1""#)),
    fault("negative-step", "experiment", Xml(r#"stepSize="0.125""#, r#"stepSize="-0.125""#)),
    fault(
        "annotation-twice",
        "annotation-twice",
        Xml(r#"<Tool name="Two"/>"#, r#"<Tool name="One"/>"#),
    ),
    // --- variables
    fault("name-twice", "name-twice", Xml(r#"name="count""#, r#"name="gain""#)),
    fault(
        "continuous-parameter",
        "illegal-combination",
        Xml(r#"variability="tunable""#, r#"variability="continuous""#),
    ),
    fault(
        "initial-of-an-input",
        "illegal-combination",
        Xml(r#"causality="input""#, r#"causality="input" initial="exact""#),
    ),
    fault(
        "calculated-parameter-exact",
        "illegal-combination",
        Xml(
            r#"causality="parameter" variability="tunable""#,
            r#"causality="parameter" variability="tunable" initial="calculated""#,
        ),
    ),
    fault("continuous-boolean", "continuous-not-real", Xml(r#" variability="discrete"><B"#, "><B")),
    fault(
        "two-independents",
        "independent-twice",
        Xml(
            r#"</ModelVariables>"#,
            r#"<ScalarVariable name="t2" valueReference="7" causality="independent"><Real/></ScalarVariable></ModelVariables>"#,
        ),
    ),
    fault(
        "multiple-set",
        "multiple-set",
        Xml(
            r#"causality="input""#,
            r#"causality="input" canHandleMultipleSetPerTimeInstant="true""#,
        ),
    ),
    fault(
        "reinit",
        "reinit",
        Xml(r#"<Real declaredType="Length""#, r#"<Real declaredType="Length" reinit="true""#),
    ),
    fault(
        "start-missing",
        "start-missing",
        Xml(
            GAIN,
            r#"name="gain" valueReference="1" causality="parameter" variability="tunable"><Real/>"#,
        ),
    ),
    fault(
        "start-of-calculated",
        "start-forbidden",
        Xml("<Real nominal", r#"<Real start="0" nominal"#),
    ),
    fault("start-outside", "start-outside-limits", Xml(r#"min="0" max="9""#, r#"min="4" max="9""#)),
    fault(
        "start-outside-declared",
        "start-outside-limits",
        Xml(r#"declaredType="Length" start="0""#, r#"declaredType="Length" start="2000""#),
    ),
    fault(
        "alias-of-inputs",
        "alias-both-settable",
        Xml(r#"name="gain" valueReference="1""#, r#"name="gain" valueReference="0""#),
    ),
    fault(
        "alias-start",
        "alias-start-twice",
        Xml(
            "</ModelVariables>",
            r#"<ScalarVariable name="x2" valueReference="2" initial="exact"><Real unit="m" start="0"/></ScalarVariable></ModelVariables>"#,
        ),
    ),
    fault(
        "alias-unit",
        "alias-unit",
        Xml(
            "</ModelVariables>",
            r#"<ScalarVariable name="x2" valueReference="2"><Real unit="m/s"/></ScalarVariable></ModelVariables>"#,
        ),
    ),
    fault(
        "alias-constant",
        "alias-constant",
        Xml(
            "</ModelVariables>",
            r#"<ScalarVariable name="c" valueReference="5" variability="constant"><Real start="0"/></ScalarVariable></ModelVariables>"#,
        ),
    ),
    fault(
        "declared-type-undefined",
        "declared-type-undefined",
        Xml(r#"<Real nominal"#, r#"<Real declaredType="Width" nominal"#),
    ),
    fault(
        "declared-type-kind",
        "declared-type-kind",
        Xml(r#"<Integer min"#, r#"<Integer declaredType="Length" min"#),
    ),
    fault(
        "derivative-of-nothing",
        "derivative-reference",
        Xml(
            "</ModelVariables>",
            r#"<ScalarVariable name="a" valueReference="9"><Real derivative="99"/></ScalarVariable></ModelVariables>"#,
        ),
    ),
    fault(
        "derivative-of-an-integer",
        "derivative-reference",
        Xml(
            "</ModelVariables>",
            r#"<ScalarVariable name="a" valueReference="9"><Real derivative="8"/></ScalarVariable></ModelVariables>"#,
        ),
    ),
    // --- model structure
    fault(
        "output-not-listed",
        "structure-missing",
        Xml(
            r#"<Unknown index="6" dependencies="1 3"/>
      <Unknown index="9""#,
            r#"<Unknown index="9""#,
        ),
    ),
    fault(
        "input-as-output",
        "structure-extra",
        Xml("<Outputs>", r#"<Outputs><Unknown index="1"/>"#),
    ),
    fault("output-twice", "structure-twice", Xml("<Outputs>", r#"<Outputs><Unknown index="3"/>"#)),
    fault(
        "index-too-large",
        "structure-index",
        Xml("<Outputs>", r#"<Outputs><Unknown index="77"/>"#),
    ),
    fault(
        "initial-unknown-missing",
        "structure-missing",
        Xml(r#"<Unknown index="4" dependencies="1"/>"#, ""),
    ),
    fault(
        "initial-unknowns-order",
        "initial-unknowns-order",
        InFiles(|f| {
            f.replace(r#"<Unknown index="4" dependencies="1"/>"#, "");
            f.replace(
                "</InitialUnknowns>",
                r#"<Unknown index="4" dependencies="1"/></InitialUnknowns>"#,
            );
        }),
    ),
    fault(
        "derivative-without-attribute",
        "derivatives-attribute",
        InFiles(|f| {
            f.replace("<Derivatives>", r#"<Derivatives><Unknown index="6"/>"#);
        }),
    ),
    fault(
        "dependencies-order",
        "dependencies-order",
        Xml(r#"dependencies="1 3""#, r#"dependencies="3 1""#),
    ),
    fault(
        "dependency-of-nothing",
        "dependency-unknown",
        Xml(r#"dependencies="1 3""#, r#"dependencies="1 3 88""#),
    ),
    fault(
        "dependency-on-a-parameter",
        "dependency-no-known",
        Xml(r#"dependencies="1 3""#, r#"dependencies="1 2 3""#),
    ),
    fault(
        "kinds-too-few",
        "dependencies-kind-count",
        Xml(r#"dependencies="1 3""#, r#"dependencies="1 3" dependenciesKind="constant""#),
    ),
    fault(
        "kinds-alone",
        "dependencies-kind-count",
        Xml(r#"dependencies="3" dependenciesKind="tunable""#, r#"dependenciesKind="tunable""#),
    ),
    fault(
        "kind-tunable-at-the-start",
        "dependencies-kind",
        Xml(
            r#"<Unknown index="5" dependencies="2 3"/>"#,
            r#"<Unknown index="5" dependencies="2 3" dependenciesKind="dependent tunable"/>"#,
        ),
    ),
    fault(
        "kind-of-a-boolean",
        "dependencies-kind",
        Xml(
            r#"<Unknown index="9" dependencies=""/>"#,
            r#"<Unknown index="9" dependencies="1" dependenciesKind="constant"/>"#,
        ),
    ),
    // --- names
    fault("name-empty", "name-empty", Xml(r#"name="count""#, r#"name="""#)),
    fault("name-not-structured", "name-structured", Xml(r#"name="count""#, r#"name="count of""#)),
    fault(
        "name-with-a-tab",
        "name-characters",
        InFiles(|f| {
            f.replace(r#" variableNamingConvention="structured""#, "");
            f.replace(r#"name="count""#, r#"name="co&#9;unt""#);
        }),
    ),
    fault(
        "array-not-together",
        "array-order",
        InFiles(|f| {
            f.replace(r#"name="y[1]""#, r#"name="y[3]""#);
        }),
    ),
    // --- the folders
    fault(
        "no-implementation",
        "no-implementation",
        InFiles(|f| {
            f.remove(&binary_name());
            f.remove("sources/base.c");
            f.replace(r#"<SourceFiles><File name="base.c"/></SourceFiles>"#, "");
        }),
    ),
    fault(
        "binary-misnamed",
        "binary-name",
        InFiles(|f| {
            let name = binary_name();
            f.rename(&name, &name.replace("Base", "base"));
        }),
    ),
    fault(
        "source-missing",
        "source-missing",
        Xml(r#"<File name="base.c"/>"#, r#"<File name="base.c"/><File name="more.c"/>"#),
    ),
    fault(
        "source-with-backslash",
        "source-name",
        Xml(r#"<File name="base.c"/>"#, r#"<File name="base.c"/><File name="a\b.c"/>"#),
    ),
    fault(
        "sources-unlisted",
        "sources-unlisted",
        Xml(r#"<SourceFiles><File name="base.c"/></SourceFiles>"#, ""),
    ),
    fault(
        "description-in-a-folder",
        "no-description",
        InFiles(|f| f.rename("modelDescription.xml", "Base/modelDescription.xml")),
    ),
    fault(
        "terminals-malformed",
        "terminals",
        InFiles(|f| f.add("terminalsAndIcons/terminalsAndIcons.xml", b"<fmiTerminalsAndIcons>")),
    ),
    fault(
        "no-documentation-entry",
        "documentation-entry",
        InFiles(|f| f.rename("documentation/index.html", "documentation/main.html")),
    ),
    fault(
        "no-license-entry",
        "license-entry",
        InFiles(|f| {
            f.rename("documentation/licenses/license.txt", "documentation/licenses/MIT.txt")
        }),
    ),
    // --- the binary
    fault(
        "binary-is-text",
        "binary-format",
        InFiles(|f| *f.get(&binary_name()) = b"#!/bin/sh\n".to_vec()),
    ),
    fault(
        "binary-of-another-platform",
        "binary-format",
        InFiles(|f| f.add("binaries/win64/Base.dll", super::library())),
    ),
    fault("binary-truncated", "binary-format", InFiles(|f| f.get(&binary_name()).truncate(700))),
    fault(
        "function-missing",
        "binary-functions",
        InFiles(|f| {
            let binary = f.get(&binary_name());
            let name = b"fmi2GetBooleanStatus";
            let at = binary.windows(name.len()).position(|w| w == name).unwrap();
            binary[at] = b'F';
        }),
    ),
    // --- the archive
    fault(
        "compressed-otherwise",
        "zip-method",
        Bytes(|b| on_first(b, 8, 10, &12_u16.to_le_bytes())),
    ),
    fault("version-4.5", "zip-version", Bytes(|b| on_first(b, 4, 6, &45_u16.to_le_bytes()))),
    fault("encrypted", "zip-encrypted", Bytes(|b| on_last(b, 6, 8, &1_u16.to_le_bytes()))),
    fault(
        "stored-with-descriptor",
        "zip-stored-descriptor",
        Both(
            |f| f.add("resources/table.bin", b"stored"),
            |b| on_last(b, 6, 8, &8_u16.to_le_bytes()),
        ),
    ),
    fault(
        "link",
        "zip-link",
        Bytes(|b| on_last_central(b, 38, &(0o120_777_u32 << 16).to_le_bytes())),
    ),
    fault(
        "backslash",
        "zip-backslash",
        InFiles(|f| f.rename("resources/data.txt", "resources\\data.txt")),
    ),
    fault(
        "parent-folder",
        "zip-unsafe-name",
        InFiles(|f| f.rename("resources/data.txt", "resources/../../data.txt")),
    ),
    fault(
        "absolute-path",
        "zip-unsafe-name",
        InFiles(|f| f.rename("resources/data.txt", "/data.txt")),
    ),
    fault(
        "entry-twice",
        "zip-duplicate",
        Both(
            |f| f.add("resources/dat2.txt", b"other\n"),
            |b| {
                while let Some(at) = b.windows(18).position(|w| w == b"resources/dat2.txt") {
                    b[at + 13] = b'a';
                }
            },
        ),
    ),
    fault("checksum", "zip-entry-damaged", Bytes(|b| on_last(b, 14, 16, &[1, 2, 3, 4]))),
    fault(
        "headers-disagree",
        "zip-local-header",
        Bytes(|b| {
            let at = find(b, b"PK\x03\x04");
            b[at + 30] = b'M';
        }),
    ),
    fault("truncated", "zip-unreadable", Bytes(|b| b.truncate(b.len() / 2))),
    fault("bytes-behind", "zip-outside-data", Bytes(|b| b.extend(b"more"))),
    fault(
        "bytes-before",
        "zip-outside-data",
        Bytes(|b| {
            b.splice(0..0, *b"MZ before");
        }),
    ),
    fault(
        "case-collision",
        "zip-case-collision",
        InFiles(|f| f.add("resources/Data.txt", b"other\n")),
    ),
    fault("bomb", "zip-too-large", InFiles(|f| f.add("resources/zeros", &vec![0; 4 << 20]))),
];

/// Where a signature is first.
fn find(bytes: &[u8], signature: &[u8]) -> usize {
    bytes.windows(signature.len()).position(|window| window == signature).unwrap()
}

fn rfind(bytes: &[u8], signature: &[u8]) -> usize {
    bytes.windows(signature.len()).rposition(|window| window == signature).unwrap()
}

/// Writes into the first entry's own header and into its header in the directory.
fn on_first(bytes: &mut [u8], local: usize, central: usize, value: &[u8]) {
    let (l, c) = (find(bytes, b"PK\x03\x04") + local, find(bytes, b"PK\x01\x02") + central);
    bytes[l..l + value.len()].copy_from_slice(value);
    bytes[c..c + value.len()].copy_from_slice(value);
}

/// The same for the last entry.
fn on_last(bytes: &mut [u8], local: usize, central: usize, value: &[u8]) {
    let (l, c) = (rfind(bytes, b"PK\x03\x04") + local, rfind(bytes, b"PK\x01\x02") + central);
    bytes[l..l + value.len()].copy_from_slice(value);
    bytes[c..c + value.len()].copy_from_slice(value);
}

fn on_last_central(bytes: &mut [u8], central: usize, value: &[u8]) {
    let c = rfind(bytes, b"PK\x01\x02") + central;
    bytes[c..c + value.len()].copy_from_slice(value);
}
