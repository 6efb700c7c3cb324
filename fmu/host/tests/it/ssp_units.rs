//! Connectors and units of a package, compared with its FMUs.

use crate::support::{Behaviour, binary_path, library, xml, zip_of};
use steerwright_host::{Coupling, Error, System, SystemPackage};

const UNITS: &str = r#"<Unit name="m"><BaseUnit m="1"/><DisplayUnit name="cm" factor="100"/></Unit>
<Unit name="cm"><BaseUnit m="1" factor="0.01"/></Unit>
<Unit name="metre"><BaseUnit m="1"/></Unit>
<Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" factor="1" offset="-273.15"/></Unit>"#;

/// A source with the output `y` in one unit, and a sink with the input `u` in another, gain 1.
struct Pair<'a> {
    output: &'a str,
    input: &'a str,
    connectors: &'a str,
    connection: &'a str,
    /// `Units` of the structure.
    units: &'a str,
    values: &'a str,
}

const PLAIN: Pair<'static> = Pair {
    output: "m",
    input: "m",
    connectors: r#"<Connector name="u" kind="input"><c:Real unit="m"/></Connector>"#,
    connection: r#"startElement="source" startConnector="y" endElement="sink" endConnector="u""#,
    units: "",
    values: "",
};

impl Pair<'_> {
    /// `None` where there is no C compiler.
    fn system(&self) -> Option<Result<(System, Vec<String>), Error>> {
        let fmu = |input, output| {
            let xml = xml(("u", input), ("y", output)).replace(r#"<Unit name="m"/>"#, UNITS);
            let library = library(Behaviour::Gain)?;
            Some(zip_of(&[("modelDescription.xml", xml.as_bytes()), (&*binary_path(), library)]))
        };
        let (source, sink) = (fmu("m", self.output)?, fmu(self.input, "m")?);
        let Pair { connectors, connection, units, values, .. } = self;
        let connection = match *connection {
            "" => String::new(),
            // One with an element inside has its end tag.
            some if some.ends_with("</Connection") => {
                format!("<Connections><Connection {some}></Connections>")
            }
            some => format!("<Connections><Connection {some}/></Connections>"),
        };
        let text = format!(
            r#"<SystemStructureDescription version="1.0" name="pair"
  xmlns="http://ssp-standard.org/SSP1/SystemStructureDescription"
  xmlns:c="http://ssp-standard.org/SSP1/SystemStructureCommon"
  xmlns:v="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
<System name="pair"><Elements><Component name="source" source="source.fmu"/>
<Component name="sink" source="sink.fmu"><Connectors>
{connectors}</Connectors>
<ParameterBindings><ParameterBinding><ParameterValues><v:ParameterSet version="1.0" name="s">
<v:Parameters>
{values}</v:Parameters></v:ParameterSet></ParameterValues></ParameterBinding></ParameterBindings>
</Component></Elements>
{connection}</System>{units}</SystemStructureDescription>"#
        );
        let files: [(&str, &[u8]); 3] = [
            ("SystemStructure.ssd", text.as_bytes()),
            ("source.fmu", &source),
            ("sink.fmu", &sink),
        ];
        Some(SystemPackage::from_bytes(&zip_of(&files), "pair.ssp").and_then(|p| p.system()))
    }
}

#[test]
fn connectors_that_differ_from_the_fmu_are_reported() {
    for (connectors, expected_text) in [
        (PLAIN.connectors, ""),
        (
            r#"<Connector name="u" kind="output"><c:Real unit="m"/></Connector>"#,
            r#"the connector sink.u has the kind "output", its FMU has "input""#,
        ),
        (
            r#"<Connector name="u" kind="input"><c:Real unit="cm"/></Connector>"#,
            r#"the connector sink.u has the unit "cm", its FMU has "m""#,
        ),
        (
            r#"<Connector name="enabled" kind="input"><c:Real/></Connector>"#,
            r#"the connector sink.enabled has the type "Real", its FMU has "Boolean""#,
        ),
        (
            r#"<Connector name="gian" kind="parameter"><c:Real/></Connector>"#,
            "sink.gian is a connector and no variable of the FMU; near it: gain",
        ),
    ] {
        let Some(system) = (Pair { connectors, ..PLAIN }).system() else { return };
        let (system, remarks) = system.unwrap();
        assert_eq!(system.connections().len(), 1);
        assert_eq!(remarks.len(), usize::from(!expected_text.is_empty()), "{remarks:?}");
        let expected = format!("SystemStructure.ssd:7: {expected_text}");
        assert!(remarks.iter().all(|r| r.starts_with(&expected)), "{expected} is not {remarks:?}");
    }
}

#[test]
fn values_pass_between_units_of_one_dimension() {
    let fmus = |output, input| Pair { output, input, connectors: "", ..PLAIN };
    let says = |connectors| Pair { connectors, ..PLAIN };
    let seconds = r#"<Units><c:Unit name="min"><c:BaseUnit s="1" factor="60"/></c:Unit></Units>"#;
    let in_minutes = r#"<Connector name="u" kind="input"><c:Real unit="min"/></Connector>"#;
    for (pair, what) in [
        (fmus("m", "K"), r#"source.y is in "m" and sink.u is in "K", a unit of another dimension"#),
        // Nothing says what rad is.
        (fmus("m", "rad"), r#"is in "m" and sink.u is in "rad": they cannot be connected"#),
        // Another dimension by a unit that the structure defines.
        (Pair { units: seconds, ..says(in_minutes) }, "a unit of another dimension"),
        (
            says(r#"<Connector name="u" kind="input"><c:Real unit="K"/></Connector>"#),
            "a unit of another dimension",
        ),
    ] {
        let Some(system) = pair.system() else { return };
        let error = system.unwrap_err();
        let text = error.to_string();
        let place = "pair.ssp: SystemStructure.ssd:";
        assert!(text.starts_with(place) && text.contains(what), "{what:?} is not in {text}");
        assert!(text.contains("the connection of source.y and sink.u: "), "{text}");
        assert!(error.hint().starts_with("connect variables of the same"), "{}", error.hint());
    }
    let in_cm = r#"<Connector name="u" kind="input"><c:Real unit="cm"/></Connector>"#;
    let doubled = format!(
        "{}><c:LinearTransformation factor=\"2\" offset=\"1\"/></Connection",
        PLAIN.connection
    );
    let kelvin = fmus("degC", "K");
    for (pair, expected) in [
        (fmus("m", "cm"), 300.0),
        (fmus("cm", "m"), 0.03),
        // Degrees have an offset.
        (kelvin, 276.15),
        // The FMU has no unit, so the connector's counts.
        (Pair { connectors: in_cm, ..fmus("m", "") }, 300.0),
        // A transformation is in addition to the conversion.
        (Pair { connection: &doubled, ..fmus("m", "cm") }, 601.0),
    ] {
        let Some(system) = pair.system() else { return };
        let (mut system, remarks) = system.unwrap();
        assert!(remarks.is_empty(), "{remarks:?}");
        system.set("source", "u", 3.0).unwrap();
        for coupling in [Coupling::GaussSeidel, Coupling::Jacobi] {
            let recording = system.run(coupling, 0.0, 1.0, 0.5).unwrap();
            let got = recording.column("sink.y").unwrap()[2];
            assert!((got - expected).abs() < 1e-9, "{got}, not {expected}");
        }
    }
    // Another name of the same unit.
    let Some(system) = fmus("m", "metre").system() else { return };
    assert!(system.unwrap().1.is_empty());
    // Conversion forbidden: as they are, and reported. Dimensions still count.
    let connection = format!(r#"{} suppressUnitConversion="true""#, PLAIN.connection);
    let forbidden = |input| Pair { connection: &connection, ..fmus("m", input) };
    let (mut system, remarks) = forbidden("cm").system().unwrap().unwrap();
    assert!(remarks[0].contains(r#"values in "m" to "cm" as they are"#), "{remarks:?}");
    system.set("source", "u", 3.0).unwrap();
    let recording = system.run(Coupling::GaussSeidel, 0.0, 1.0, 0.5).unwrap();
    assert_eq!(recording.column("sink.y").unwrap()[2], 3.0);
    assert!(forbidden("K").system().unwrap().is_err());
}

#[test]
fn values_are_converted_to_the_units_of_their_variables() {
    let minutes = r#"<Units><c:Unit name="km"><c:BaseUnit m="1" factor="1000"/></c:Unit></Units>"#;
    for (input, unit, expected) in [
        ("m", "m", Some(20.0)),
        ("m", "cm", Some(0.2)),
        ("m", "metre", Some(20.0)),
        ("m", "km", Some(20_000.0)),
        ("K", "degC", Some(293.15)),
        ("", "furlong", Some(20.0)),
        ("m", "degC", None),
        ("m", "furlong", None),
    ] {
        let values =
            format!(r#"<v:Parameter name="u"><v:Real value="20" unit="{unit}"/></v:Parameter>"#);
        let pair = Pair {
            input,
            connection: "",
            connectors: "",
            units: minutes,
            values: &values,
            ..PLAIN
        };
        let Some(system) = pair.system() else { return };
        let Some(expected) = expected else {
            let error = system.unwrap_err();
            let expected_text = format!(
                "pair.ssp: SystemStructure.ssd:10: sink.u is in {input:?}, its value is given in \
                 {unit:?}"
            );
            assert!(
                error.to_string().starts_with(&expected_text),
                "{expected_text} is not {error}"
            );
            assert!(error.hint().contains("unit"));
            continue;
        };
        let (mut system, _) = system.unwrap();
        let recording = system.run(Coupling::GaussSeidel, 0.0, 1.0, 0.5).unwrap();
        let got = recording.column("sink.y").unwrap()[2];
        assert!((got - expected).abs() < 1e-9, "{input} {unit}: {got}, not {expected}");
    }
}

#[test]
fn a_connection_to_nowhere_names_the_place_both_ends_and_near_names() {
    for (from, to, expected_text) in [
        (r#""u""#, r#""uu""#, r#"source.y and sink.uu: sink has no variable "uu"; near it: u"#),
        (
            r#""sink""#,
            r#""sinc""#,
            r#"source.y and sinc.u names "sinc", which is no component; near it: sink"#,
        ),
    ] {
        let connection = PLAIN.connection.replacen(from, to, 1);
        let Some(system) = (Pair { connection: &connection, ..PLAIN }).system() else { return };
        let text = system.unwrap_err().to_string();
        let expected_text =
            format!("pair.ssp: SystemStructure.ssd:12: the connection of {expected_text}");
        assert!(text.starts_with(&expected_text), "{expected_text} is not {text}");
    }
}
