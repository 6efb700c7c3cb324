//! System structure packages: what is read, what is refused, and that a package runs as its FMUs do.

use crate::support::{Behaviour, binary_path, library, xml, zip_of};
use model_description::Value;
use steerwright_host::{Connection, Coupling, Error, InputTable, Instance, System, SystemPackage};

/// A structure file. Other prefixes than the usual ones on purpose: namespaces count.
pub(crate) fn ssd(system: &str, experiment: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<SystemStructureDescription version="1.0" name="whole"
  xmlns="http://ssp-standard.org/SSP1/SystemStructureDescription"
  xmlns:c="http://ssp-standard.org/SSP1/SystemStructureCommon"
  xmlns:v="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
  xmlns:o="http://opensimulationplatform.com/SSP/OSPAnnotations">
<System name="loop">{system}</System>{experiment}
</SystemStructureDescription>"#
    )
}

fn set(name: &str, typed: &str) -> String {
    format!(
        r#"<ParameterValues><v:ParameterSet version="1.0" name="s"><v:Parameters>
<v:Parameter name="{name}">{typed}</v:Parameter></v:Parameters></v:ParameterSet></ParameterValues>"#
    )
}

const PAIR: &str = r#"<Elements>
<Component name="integrator" source="resources/I%20n.fmu"><Connectors>
  <Connector name="u" kind="input"><c:Real/></Connector>
  <Connector name="y" kind="output"><c:Real/></Connector></Connectors></Component>
<Component name="gain" source="./resources/gain.fmu"/>
</Elements>"#;

const WIRES: &str = r#"<Connections>
<Connection startElement="integrator" startConnector="y" endElement="gain" endConnector="u"/>
<Connection startElement="integrator" startConnector="u" endElement="gain" endConnector="y"/>
</Connections>"#;

/// ẏ = u in a loop with a gain; `None` where there is no C compiler.
pub(crate) fn package(ssd: &str, more: &[(&str, &[u8])]) -> Option<Result<SystemPackage, Error>> {
    let description = xml(("u", "m"), ("y", "m"));
    let fmu = |behaviour| {
        let files = [
            ("modelDescription.xml", description.as_bytes()),
            (&*binary_path(), library(behaviour)?),
        ];
        Some(zip_of(&files))
    };
    let (integrator, gain) = (fmu(Behaviour::Integrator)?, fmu(Behaviour::Gain)?);
    let mut files: Vec<(&str, &[u8])> = vec![
        ("SystemStructure.ssd", ssd.as_bytes()),
        ("resources/I n.fmu", &integrator),
        ("resources/gain.fmu", &gain),
    ];
    files.extend(more);
    Some(SystemPackage::from_bytes(&zip_of(&files), "loop.ssp"))
}

fn refused(ssd: &str) -> Option<String> {
    let error = package(ssd, &[])?.expect_err("the package was accepted");
    assert!(!error.hint().is_empty());
    let text = error.to_string();
    assert!(text.contains("loop.ssp"), "the message does not name the package: {text}");
    Some(text)
}

#[test]
fn a_package_runs_as_its_fmus_do() {
    let experiment = r#"<DefaultExperiment startTime="1" stopTime="2.5"><Annotations>
<c:Annotation type="org.other"><x/></c:Annotation>
<c:Annotation type="com.opensimulationplatform"><o:Algorithm>
<o:FixedStepAlgorithm baseStepSize="1e-2"/></o:Algorithm></c:Annotation>
</Annotations></DefaultExperiment>"#;
    // Of the bindings of a component the later counts, and those of the system more than both; the
    // last is in a file, with a prefix.
    let first = set("gain", r#"<v:Real value="7" unit="1"/>"#);
    let second = set("gain", r#"<v:Integer value="5"/>"#);
    let bindings = format!(
        "<ParameterBindings><ParameterBinding>{first}</ParameterBinding>\
         <ParameterBinding>{second}</ParameterBinding></ParameterBindings>"
    );
    let elements = PAIR.replace(r#"gain.fmu"/>"#, &format!(r#"gain.fmu">{bindings}</Component>"#));
    let of_system = r#"<ParameterBindings>
<ParameterBinding source="values.ssv" prefix="gain."/></ParameterBindings>"#;
    let values = r#"<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
  version="1.0" name="values"><ssv:Parameters>
<ssv:Parameter name="offset"><ssv:Real value="0.25"/></ssv:Parameter>
<ssv:Parameter name="label"><ssv:String value="a &lt; b"/></ssv:Parameter>
<ssv:Parameter name="u"><ssv:Real value="3"/></ssv:Parameter>
<ssv:Parameter name="unknown"><ssv:Boolean value="1"/></ssv:Parameter>
</ssv:Parameters></ssv:ParameterSet>"#;
    let text = ssd(&format!("{of_system}{elements}{WIRES}"), experiment);
    let Some(package) = package(&text, &[("values.ssv", values.as_bytes())]) else { return };
    let package = package.unwrap();
    let said = package.structure();
    assert_eq!(said.name, "loop");
    assert_eq!((said.start_time, said.stop_time, said.step), (Some(1.0), Some(2.5), Some(0.01)));
    let (mut system, remarks) = package.system().unwrap();
    // Start and end have no direction: the second connection is written backwards.
    let expected = [
        Connection::new("integrator", "y", "gain", "u"),
        Connection::new("gain", "y", "integrator", "u"),
    ];
    assert_eq!(system.connections(), expected);
    let expected_text = [
        "starts at the input integrator.u and ends at the output gain.y",
        "values.ssv:5: gain.u is given a value, but",
        "values.ssv:6: gain.unknown is given a value and does not exist",
    ];
    assert_eq!(remarks.len(), expected_text.len(), "{remarks:?}");
    for (remark, expected_text) in remarks.iter().zip(expected_text) {
        assert!(remark.contains(expected_text), "{expected_text:?} is not in {remark}");
    }

    let mut by_hand = System::new();
    for (archive, name) in package.archives().zip(["integrator", "gain"]) {
        by_hand.add(Instance::new(archive, name).unwrap()).unwrap();
    }
    for connection in expected {
        by_hand.connect(connection).unwrap();
    }
    by_hand.set("gain", "gain", 5.0).unwrap();
    by_hand.set("gain", "offset", 0.25).unwrap();
    by_hand.set("gain", "label", Value::String("a < b".into())).unwrap();
    for coupling in [Coupling::GaussSeidel, Coupling::Jacobi] {
        let recording = system.run(coupling, 1.0, 2.5, 0.01).unwrap();
        assert_eq!(recording, by_hand.run(coupling, 1.0, 2.5, 0.01).unwrap());
        // ẏ = 5 (y + …): it grew, so the values arrived.
        assert!(recording.column("integrator.y").unwrap()[150].abs() > 1.0);
    }
}

#[test]
fn what_is_not_supported_is_named_with_its_line() {
    let with = |from: &str, to: &str| ssd(&format!("{PAIR}{WIRES}").replacen(from, to, 1), "");
    let transformed = r#"endConnector="u"><c:BooleanMappingTransformation/></Connection>"#;
    let mapped = r#"gain.fmu"><ParameterBindings><ParameterBinding><ParameterMapping/></ParameterBinding></ParameterBindings></Component>"#;
    for (text, what) in [
        (
            with(
                "</Elements>",
                r#"<SignalDictionaryReference name="s" dictionary="d"/></Elements>"#,
            ),
            "SignalDictionaryReference",
        ),
        (with(r#"endConnector="u"/>"#, transformed), "BooleanMappingTransformation"),
        (with(r#"gain.fmu"/>"#, mapped), "a parameter mapping"),
        (
            with(r#"gain.fmu"/>"#, r#"gain.fmu" type="application/x-ssp-package"/>"#),
            "x-ssp-package",
        ),
        (with(r#"gain.fmu"/>"#, r#"gain.fmu" implementation="ModelExchange"/>"#), "model exchange"),
        (
            ssd(PAIR, "").replacen(r#""1.0" name="whole""#, r#""2.0" name="whole""#, 1),
            "version 2.0",
        ),
    ] {
        let Some(message) = refused(&text) else { return };
        assert!(message.contains(what) && message.ends_with("is not supported"), "{message}");
        assert!(message.contains("SystemStructure.ssd:"), "no line: {message}");
    }
}

#[test]
fn broken_packages_are_refused() {
    let bound = |typed: &str| {
        let set = set("gain", typed);
        let bindings = format!(
            r#"gain.fmu"><ParameterBindings><ParameterBinding>{set}</ParameterBinding></ParameterBindings></Component>"#
        );
        ssd(&PAIR.replacen(r#"gain.fmu"/>"#, &bindings, 1), "")
    };
    let nowhere = r#"<Connections><Connection startElement="integrator" startConnector="y" endElement="no" endConnector="u"/></Connections>"#;
    let source = |source: &str| ssd(&PAIR.replacen("./resources/gain.fmu", source, 1), "");
    let step = r#"<DefaultExperiment><Annotations><c:Annotation type="com.opensimulationplatform"><o:Algorithm><o:FixedStepAlgorithm baseStepSize="0"/></o:Algorithm></c:Annotation></Annotations></DefaultExperiment>"#;
    for (text, what) in [
        ("<a>".to_owned(), "SystemStructure.ssd:1"),
        ("<a/>".to_owned(), "no SystemStructureDescription"),
        (ssd("", ""), "no components"),
        (ssd(PAIR, "").replacen("name=\"gain\"", "name=\"integrator\"", 1), "two components"),
        (ssd(&format!("{PAIR}{nowhere}"), ""), "which is no component"),
        (ssd(PAIR, step), "baseStepSize"),
        (ssd(PAIR, r#"<DefaultExperiment stopTime="NaN"/>"#), "not a finite number"),
        (bound(r#"<v:Real value="1,5"/>"#), "not a finite number"),
        (bound(r#"<v:Integer value="1.5"/>"#), "which is no Integer"),
        (bound(r#"<v:Boolean value="yes"/>"#), "which is no Boolean"),
        (bound(r#"<v:Enumeration value="a"/>"#), "Enumeration is not supported"),
        (source("resources/none.fmu"), "no such file"),
        (source("../gain.fmu"), "leaves the package"),
        (source("/etc/passwd"), "leaves the package"),
        (source("resources/%2e%2e/%2e%2e/x"), "leaves the package"),
        (source("resources/%zz.fmu"), "no URI"),
        (source("file:///etc/passwd"), "leaves the package"),
    ] {
        let Some(message) = refused(&text) else { return };
        assert!(message.contains(what), "{what:?} is not in {message}");
    }
    let many: String = (0..1001).map(|k| format!("\n a{k}='1'")).collect();
    for (text, expected) in [
        (format!("<a>\n<b {many}/></a>"), "SystemStructure.ssd:2: an element has more than 1000"),
        ("<a>".repeat(300), "SystemStructure.ssd:1: its elements are nested more than 256 deep"),
    ] {
        let bytes = zip_of(&[("SystemStructure.ssd", text.as_bytes())]);
        let message = SystemPackage::from_bytes(&bytes, "loop.ssp").unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    let empty = SystemPackage::from_bytes(&zip_of(&[("x/SystemStructure.ssd", b"")]), "loop.ssp");
    assert!(matches!(empty.unwrap_err(), Error::NoSystemStructure { .. }));
    let evil = SystemPackage::from_bytes(&zip_of(&[("../evil", b"")]), "loop.ssp").unwrap_err();
    assert!(matches!(evil, Error::UnsafeEntry { .. }), "{evil}");
}

#[test]
fn values_and_connections_have_to_fit_the_fmus() {
    let bound = |name: &str, typed: &str| {
        let set = set(name, typed);
        let bindings = format!(
            r#"gain.fmu"><ParameterBindings><ParameterBinding>{set}</ParameterBinding></ParameterBindings></Component>"#
        );
        ssd(&PAIR.replacen(r#"gain.fmu"/>"#, &bindings, 1), "")
    };
    let wrong = WIRES.replacen(r#"startConnector="y""#, r#"startConnector="z""#, 1);
    for (text, what) in [
        (
            bound("u", r#"<v:Real value="1" unit="km"/>"#),
            "loop.ssp: SystemStructure.ssd:12: gain.u is in \"m\", its value is given in \"km\"",
        ),
        (bound("gain", r#"<v:Boolean value="true"/>"#), "gain.gain is Real, not Boolean"),
        (
            ssd(&format!("{PAIR}{wrong}"), ""),
            "SystemStructure.ssd:13: the connection of integrator.z and gain.u: \
             integrator has no variable \"z\"",
        ),
    ] {
        let Some(package) = package(&text, &[]) else { return };
        let message = package.unwrap().system().unwrap_err().to_string();
        assert!(message.contains(what), "{what:?} is not in {message}");
    }
}

#[test]
fn connectors_of_the_system_itself_are_left_out_and_reported() {
    let outside = r#"<Connections><Connection startElement="gain" startConnector="y" endConnector="shown"/></Connections>"#;
    let Some(package) = package(&ssd(&format!("{PAIR}{outside}"), ""), &[]) else { return };
    let (system, remarks) = package.unwrap().system().unwrap();
    assert!(system.connections().is_empty());
    assert!(remarks[0].contains("shown"), "{remarks:?}");
}

/// One connector, `push`, feeds both FMUs; the second connection is written backwards.
fn pushed(unit: &str, value: &str) -> String {
    let connectors = format!(
        r#"<Connectors><Connector name="push" kind="input"><c:Real unit="{unit}"/></Connector></Connectors>"#
    );
    let set = set("push", value);
    let bindings = format!(
        "<ParameterBindings><ParameterBinding>{set}</ParameterBinding></ParameterBindings>"
    );
    let wires = r#"<Connections>
<Connection startConnector="push" endElement="integrator" endConnector="u"/>
<Connection startElement="gain" startConnector="u" endConnector="push"/></Connections>"#;
    ssd(&format!("{connectors}{bindings}{PAIR}{wires}"), "")
}

#[test]
fn a_connector_of_the_system_feeds_its_inputs() {
    let Some(package) = package(&pushed("m", r#"<v:Real value="2" unit="m"/>"#), &[]) else {
        return;
    };
    let package = package.unwrap();
    assert_eq!(package.structure().connectors[0].name, "push");
    let run = |csv: Option<&str>| {
        let (mut system, remarks) = package.system().unwrap();
        assert!(remarks.is_empty(), "{remarks:?}");
        if let Some(csv) = csv {
            system.feed(InputTable::read(csv.as_bytes(), "in.csv").unwrap());
        }
        let recording = system.run(Coupling::GaussSeidel, 0.0, 2.0, 0.5)?;
        let last = |name: &str| *recording.column(name).unwrap().last().unwrap();
        Ok::<_, Error>(["integrator.u", "gain.u", "integrator.y"].map(last))
    };
    // Without a table its start value holds, in both.
    let [first, second, reached] = run(None).unwrap();
    assert_eq!((first, second), (2.0, 2.0));
    let [first, second, further] = run(Some("time,push\n0,3\n")).unwrap();
    assert_eq!((first, second), (3.0, 3.0));
    assert!(further > reached, "{further} {reached}");
    // A column of one input leaves the other at its start value.
    assert_eq!(run(Some("time,gain.u\n0,3\n")).unwrap()[..2], [2.0, 3.0]);
    let error = run(Some("time,pusch\n0,3\n")).unwrap_err();
    assert!(matches!(&error, Error::TableColumn { near, .. } if near == &["push"]), "{error}");
    // A value that is set, not a start value, excludes a column.
    let (mut system, _) = package.system().unwrap();
    system.set("gain", "u", 1.0).unwrap();
    system.feed(InputTable::read("time,push\n0,3\n".as_bytes(), "in.csv").unwrap());
    let error = system.run(Coupling::GaussSeidel, 0.0, 1.0, 0.5).unwrap_err().to_string();
    assert!(error.contains("gain.u") && error.contains("\"push\""), "{error}");
}

#[test]
fn connectors_of_the_system_have_to_fit_their_inputs() {
    let metre = r#"<v:Real value="2" unit="m"/>"#;
    for (text, what) in [
        (pushed("kg", metre), "the connection of loop.push and integrator.u: "),
        (
            pushed("m", r#"<v:Real value="2" unit="km"/>"#),
            "integrator.u is in \"m\", its value is given in \"km\"",
        ),
        (
            pushed("m", metre).replace(r#"endConnector="u""#, r#"endConnector="v""#),
            "integrator has no variable \"v\"",
        ),
        (
            pushed("m", metre).replace(r#"endConnector="u""#, r#"endConnector="y""#),
            "integrator.y is",
        ),
    ] {
        let Some(package) = package(&text, &[]) else { return };
        let error = package.unwrap().system().unwrap_err();
        assert!(error.to_string().contains(what), "{what:?} is not in {error}");
        assert!(!error.hint().is_empty());
    }
    let nowhere = pushed("m", metre).replace(r#"endElement="integrator""#, r#"endElement="int""#);
    let Some(message) = refused(&nowhere) else { return };
    assert!(message.contains("the connection of push and int.u names \"int\""), "{message}");
}

#[test]
fn deep_nesting_and_entities_are_refused() {
    let deep = format!("{}{}", "<a>".repeat(200_000), "</a>".repeat(200_000));
    let entities = "<!DOCTYPE a [<!ENTITY e \"eeee\">]><a>&e;</a>";
    for text in [deep.as_str(), entities] {
        let bytes = zip_of(&[("SystemStructure.ssd", text.as_bytes())]);
        assert!(SystemPackage::from_bytes(&bytes, "loop.ssp").is_err());
    }
}
