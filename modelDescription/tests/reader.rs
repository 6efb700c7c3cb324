//! Descriptions of other tools, broken ones, and anything at all.

use crate::common;

use common::description;
use model_description::{Causality, Error, Kind, ModelDescription, Value, Variability};
use proptest::prelude::*;

const FOREIGN: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="a.b" guid="{x}" numberOfEventIndicators="0">
  <ModelExchange modelIdentifier="ab"/>
  <CoSimulation modelIdentifier="ab" canHandleVariableCommunicationStepSize="1">
    <SourceFiles><File name="all.c"/></SourceFiles>
  </CoSimulation>
  <UnitDefinitions><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit></UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="T"><Real unit="degC" min="-10" max="+1e2"/></SimpleType>
    <SimpleType name="Mode"><Enumeration><Item name="off" value="1"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <ModelVariables>
    <ScalarVariable name="t" valueReference="0" causality="input">
      <Real declaredType="T" start=" 20 " max="50"/><Annotations/>
    </ScalarVariable>
    <ScalarVariable name="mode" valueReference="1" variability="discrete">
      <Enumeration declaredType="Mode" start="1"/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>"#;

#[test]
fn declared_types_enumerations_and_defaults() {
    let read = ModelDescription::from_xml(FOREIGN).unwrap();
    let t = read.variable("t").unwrap();
    assert_eq!((t.unit.as_deref(), t.min, t.max), (Some("degC"), Some(-10.0), Some(50.0)));
    assert_eq!(t.start, Some(Value::Real(20.0)));
    assert_eq!((t.causality, t.variability), (Causality::Input, Variability::Continuous));
    let mode = read.variable_at(2).unwrap();
    assert_eq!((mode.kind, mode.is_enumeration), (Kind::Integer, true));
    assert_eq!(mode.causality, Causality::Local);
    let co_simulation = read.co_simulation.unwrap();
    assert!(co_simulation.can_handle_variable_communication_step_size);
    assert_eq!(co_simulation.source_files, ["all.c"]);
    assert_eq!(read.units[0].base.unwrap().offset, 273.15);
    assert!(read.model_exchange.is_some());
}

#[test]
fn faults_are_named_with_their_line() {
    let broken = |from: &str, to: &str| {
        assert!(FOREIGN.contains(from));
        ModelDescription::from_xml(&FOREIGN.replacen(from, to, 1)).unwrap_err()
    };
    let error = broken("start=\" 20 \"", "start=\"20,5\"");
    assert!(error.to_string().starts_with("modelDescription.xml:14: <Real>: `start`"), "{error}");
    let error = broken("valueReference=\"1\"", "");
    assert!(matches!(error, Error::MissingAttribute { line: 16, .. }), "{error}");
    let error = broken("fmiVersion=\"2.0\"", "fmiVersion=\"3.0\"");
    assert!(matches!(error, Error::NotFmi2 { line: 2, .. }), "{error}");
    let error = broken("<Enumeration declaredType=\"Mode\" start=\"1\"/>", "");
    assert!(matches!(error, Error::MissingElement { line: 16, .. }), "{error}");
    let error = broken("</ModelVariables>", "");
    assert!(matches!(error, Error::Malformed { .. }), "{error}");
    let many: String = (0..1001).map(|k| format!("\n a{k}='1'")).collect();
    let error = ModelDescription::from_xml(&format!("<a>\n<b {many}/></a>")).unwrap_err();
    assert!(error.to_string().contains("xml:2:1: "), "{error}");
    assert!(error.to_string().contains("more than 1000 attributes"), "{error}");
    assert!(matches!(ModelDescription::from_xml(""), Err(Error::Malformed { .. })));
    assert!(matches!(ModelDescription::from_xml("<a/>"), Err(Error::NotFmi2 { .. })));
}

#[test]
fn entities_are_refused() {
    let bomb = format!(
        "<!DOCTYPE x [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>{}",
        FOREIGN.split_once("?>").unwrap().1
    );
    assert_eq!(ModelDescription::from_xml(&bomb), Err(Error::DocumentType));
}

#[test]
fn breaches_of_the_rules_are_found() {
    let found = |change: fn(&mut ModelDescription)| -> Vec<&'static str> {
        let mut description = description();
        change(&mut description);
        description.findings().into_iter().map(|finding| finding.rule).collect()
    };
    assert_eq!(found(|_| ()), [""; 0]);
    assert_eq!(found(|d| d.variables[5].start = None), ["start-missing"]);
    assert_eq!(found(|d| d.variables[0].start = Some(0.0.into())), ["start-forbidden"]);
    assert_eq!(found(|d| d.variables[5].start = Some((-1.0).into())), ["start-outside-limits"]);
    assert_eq!(found(|d| d.variables[8].min = Some(f64::INFINITY)), [""; 0]);
    assert_eq!(
        found(|d| (d.variables[8].min, d.variables[8].max) = (Some(2.0), Some(1.0))),
        ["min-above-max"]
    );
    assert_eq!(found(|d| d.variables[0].unit = Some("furlong".into())), ["unit-undefined"]);
    assert_eq!(
        found(|d| d.variables[0].display_unit = Some("gon".into())),
        ["display-unit-undefined"]
    );
    assert_eq!(found(|d| d.variables[3].name = "gain".into()), ["name-twice"]);
    assert_eq!(
        found(|d| d.variables[1].variability = Variability::Continuous),
        ["illegal-combination"]
    );
    assert_eq!(
        found(|d| d.co_simulation.as_mut().unwrap().can_serialize_fmu_state = true),
        ["serialize-needs-get-and-set"]
    );
    assert_eq!(
        found(|d| d.co_simulation.as_mut().unwrap().model_identifier = "1a".into()),
        ["model-identifier"]
    );
    assert_eq!(found(|d| drop(d.outputs.pop())), ["structure-missing"]);
    assert_eq!(found(|d| d.initial_unknowns.swap(0, 1)), ["initial-unknowns-order"]);
    assert_eq!(
        found(|d| d.initial_unknowns[0].dependencies = Some(vec![6, 2])),
        ["dependencies-order"]
    );
    assert_eq!(found(|d| d.outputs[0].dependencies = Some(vec![2])), ["dependency-no-known"]);
    assert_eq!(found(|d| d.outputs[0].dependencies = Some(vec![99])), ["dependency-unknown"]);
    assert_eq!(found(|d| d.outputs[0].kinds = Some(vec![])), ["dependencies-kind-count"]);
    assert_eq!(
        found(|d| d.default_experiment.as_mut().unwrap().stop_time = Some(-1.0)),
        ["stop-before-start"]
    );
    assert_eq!(
        found(|d| d.default_experiment.as_mut().unwrap().step_size = Some(0.0)),
        ["experiment"]
    );
    assert_eq!(
        found(|d| d.log_categories.push(d.log_categories[0].clone())),
        ["log-category-twice"]
    );
}

proptest! {
    /// Whatever the text, reading ends in a description or an error.
    #[test]
    fn reading_never_panics(text in any::<String>()) {
        let _ = ModelDescription::from_xml(&text);
    }

    /// The same for texts that are nearly descriptions: a piece of a good one cut out or replaced.
    #[test]
    fn reading_a_damaged_description_never_panics(
        start in 0_usize..4000, length in 0_usize..40, piece in "[<>/=\"'&;0-9a-zA-Z. \\-]{0,20}",
        foreign: bool,
    ) {
        let mut text = if foreign { FOREIGN.to_owned() } else { description().to_xml() };
        let cut = |mut index: usize| {
            index = index.min(text.len());
            while !text.is_char_boundary(index) { index -= 1; }
            index
        };
        let (from, to) = (cut(start), cut(start + length));
        text.replace_range(from..to, &piece);
        if let Ok(description) = ModelDescription::from_xml(&text) {
            let _ = description.findings();
            // What was read can be written, and reads as the same again but for what is not written.
            prop_assert!(ModelDescription::from_xml(&description.to_xml()).is_ok());
        }
    }

    /// Any text in any field survives, but for characters XML cannot hold.
    #[test]
    fn any_text_survives(text in "[\\t\\n\\r -~\u{80}-\u{d7ff}\u{10000}-\u{10ffff}]{0,40}") {
        let mut written = description();
        written.description = Some(text.clone());
        written.variables[4].start = Some(Value::String(text));
        prop_assert_eq!(ModelDescription::from_xml(&written.to_xml()).unwrap(), written);
    }
}
