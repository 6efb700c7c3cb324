//! Systems inside the system of a package, and transformations on their connections.

use crate::ssp::{package, ssd};
use steerwright_host::{Coupling, InputTable, Recording};

/// `push` feeds two gains, one inside two systems, whose output comes out again and feeds the integrator of the root.
const NESTED: &str = r#"<Connectors><Connector name="push" kind="input"><c:Real unit="m"/></Connector></Connectors>
<Elements>
<System name="outer"><Connectors><Connector name="in" kind="input"/><Connector name="out" kind="output"/></Connectors>
  <Elements><System name="inner">
    <Connectors><Connector name="in" kind="input"/><Connector name="out" kind="output"/></Connectors>
    <Elements><Component name="gain" source="resources/gain.fmu"/></Elements>
    <ParameterBindings><ParameterBinding><ParameterValues><v:ParameterSet version="1.0" name="s"><v:Parameters>
      <v:Parameter name="gain.gain"><v:Real value="5"/></v:Parameter>
    </v:Parameters></v:ParameterSet></ParameterValues></ParameterBinding></ParameterBindings>
    <Connections><Connection startConnector="in" endElement="gain" endConnector="u"/>
      <Connection startElement="gain" startConnector="y" endConnector="out"/></Connections>
  </System></Elements>
  <Connections>
    <Connection startConnector="in" endElement="inner" endConnector="in"><c:LinearTransformation factor="2"/></Connection>
    <Connection startElement="inner" startConnector="out" endConnector="out"><c:LinearTransformation factor="10"/></Connection>
  </Connections>
</System>
<Component name="gain" source="resources/gain.fmu"/>
<Component name="integrator" source="resources/I%20n.fmu"/>
</Elements>
<ParameterBindings><ParameterBinding><ParameterValues><v:ParameterSet version="1.0" name="s"><v:Parameters>
  <v:Parameter name="push"><v:Real value="3"/></v:Parameter>
  <v:Parameter name="outer.inner.gain.offset"><v:Real value="0.5"/></v:Parameter>
</v:Parameters></v:ParameterSet></ParameterValues></ParameterBinding></ParameterBindings>
<Connections>
<Connection startConnector="push" endElement="outer" endConnector="in"/>
<Connection startConnector="push" endElement="gain" endConnector="u"><c:LinearTransformation factor="-1" offset="1"/></Connection>
<Connection startElement="outer" startConnector="out" endElement="integrator" endConnector="u"/>
</Connections>"#;

/// The last values of `variables`, by a table of inputs, where there is one.
fn last(system: &str, table: Option<&str>, variables: [&str; 3]) -> Option<[f64; 3]> {
    let package = package(&ssd(system, ""), &[])?.unwrap();
    let (mut system, remarks) = package.system().unwrap();
    assert!(remarks.is_empty(), "{remarks:?}");
    if let Some(csv) = table {
        system.feed(InputTable::read(csv.as_bytes(), "in.csv").unwrap());
    }
    let recording: Recording = system.run(Coupling::GaussSeidel, 0.0, 1.0, 0.5).unwrap();
    Some(variables.map(|name| *recording.column(name).unwrap().last().unwrap()))
}

#[test]
fn systems_inside_the_system_are_wired_through_their_connectors() {
    // The only gain is the inner one: 5·(2·3) + 0.5, and ten times that is integrated.
    let swapped = NESTED.replace(
        "<Component name=\"gain\" source=\"resources/gain.fmu\"/>\n<Component name=\"integrator\"",
        "<Component name=\"integrator\"",
    );
    assert!(swapped.len() < NESTED.len());
    let single = swapped.replace("<Connection startConnector=\"push\" endElement=\"gain\" endConnector=\"u\"><c:LinearTransformation factor=\"-1\" offset=\"1\"/></Connection>\n", "");
    let Some(values) = last(&single, None, ["gain.y", "gain.u", "integrator.y"]) else { return };
    assert_eq!(values[0], 5.0 * 6.0 + 0.5);
    assert!((values[2] - 305.0).abs() < 1e-9, "{values:?}");
    let values =
        last(&single, Some("time,push\n0,4\n"), ["gain.y", "gain.u", "integrator.y"]).unwrap();
    assert_eq!(values[0], 5.0 * 8.0 + 0.5);
}

#[test]
fn a_component_inside_a_system_gets_another_name_where_its_own_is_taken() {
    let (gain, rest) =
        ("<Component name=\"gain\" source=\"resources/gain.fmu\"/>\n<Component", "<Component");
    let first = NESTED.replace(gain, rest).replacen(
        "<Elements>\n",
        "<Elements>\n<Component name=\"gain\" source=\"resources/gain.fmu\"/>\n",
        1,
    );
    // Wherever in the file the component of the root is.
    for text in [NESTED, &first] {
        let names = ["gain.u", "outer_inner_gain.y", "integrator.y"];
        let Some(values) = last(text, None, names) else { return };
        assert_eq!(values[..2], [-2.0, 30.5]);
        let values = last(text, Some("time,push\n0,4\n"), names).unwrap();
        assert_eq!(values[..2], [-3.0, 40.5]);
    }
}

#[test]
fn an_integer_feeds_a_real() {
    let wires = r#"<Elements><Component name="integrator" source="resources/I%20n.fmu"/>
<Component name="gain" source="resources/gain.fmu"/></Elements><Connections>
<Connection startElement="integrator" startConnector="steps" endElement="gain" endConnector="u"/></Connections>"#;
    let Some(values) = last(wires, None, ["integrator.steps", "gain.y", "gain.y"]) else { return };
    assert_eq!(values, [2.0, 2.0, 2.0]);
    let scaled =
        wires.replace(r#""u"/>"#, r#""u"><c:LinearTransformation factor="3"/></Connection>"#);
    assert_eq!(
        last(&scaled, None, ["integrator.steps", "gain.y", "gain.y"]).unwrap(),
        [2.0, 6.0, 6.0]
    );
}

#[test]
fn wires_that_cannot_be_followed_are_refused_or_reported() {
    for (from, to, expected) in [
        (
            "<Connector name=\"in\" kind=\"input\"/>",
            "<Connector name=\"in\" kind=\"inout\"/>",
            "of kind inout",
        ),
        (
            "endElement=\"outer\" endConnector=\"in\"",
            "endElement=\"outer\" endConnector=\"on\"",
            "outer/on, which the system does not declare",
        ),
        (
            "endElement=\"inner\" endConnector=\"in\"",
            "endElement=\"iner\" endConnector=\"in\"",
            "names \"iner\", which is no component",
        ),
        ("factor=\"2\"", "factor=\"2\" offset=\"1\"", "an offset of a LinearTransformation"),
        (
            "<Component name=\"integrator\"",
            "<System name=\"outer\"/><Component name=\"integrator\"",
            "two components are named \"outer\"",
        ),
    ] {
        assert!(NESTED.contains(from), "{from}");
        let Some(package) = package(&ssd(&NESTED.replacen(from, to, 1), ""), &[]) else { return };
        let error = package.unwrap_err();
        assert!(error.to_string().contains(expected), "{expected:?} is not in {error}");
        assert!(error.to_string().contains("SystemStructure.ssd:"), "{error}");
        assert!(!error.hint().is_empty());
    }
    // Without a wire to it, a connector has no value to pass on.
    let unfed = NESTED.replacen(
        "<Connection startConnector=\"push\" endElement=\"outer\" endConnector=\"in\"/>\n",
        "",
        1,
    );
    let Some(package) = package(&ssd(&unfed, ""), &[]) else { return };
    let (_, remarks) = package.unwrap().system().unwrap();
    assert!(
        remarks.iter().any(|r| r.contains("nothing feeds the connector outer/inner/in")),
        "{remarks:?}"
    );
}
