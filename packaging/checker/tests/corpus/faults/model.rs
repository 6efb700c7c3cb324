//! Faults of the XML that its schema allows.

use super::Edit::{Files as InFiles, Xml};
use super::{Fault, fault};
use crate::corpus::binary_name;

const GAIN: &str = r#"name="gain" valueReference="1" causality="parameter" variability="tunable"><Real start="1"/>"#;

pub(super) static FAULTS: &[Fault] = &[
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
];
