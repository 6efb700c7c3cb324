//! FMUs for the tests: `fmu.c` compiled with the machine's C compiler, packed with an XML made here.

#![allow(dead_code)] // each test file uses a part

use std::io::{Cursor, Write};
use std::process::Command;
use std::sync::OnceLock;

use steerwright_host::{Archive, Instance};
use zip::write::SimpleFileOptions;

/// The behaviours of `fmu.c`.
#[derive(Clone, Copy)]
pub(crate) enum Behaviour {
    Integrator,
    Gain,
    Sampled,
    /// Lacks one function.
    Incomplete,
    /// Says that it is FMI 1.0.
    Version1,
    /// Calls a function of Python's that it does not link.
    Python,
    /// An integrator of which no step ends.
    Hanging,
    /// Ends the process, with status 0, when it is loaded.
    EndsLoaded,
    /// The same when it is instantiated.
    EndsInstantiated,
    /// An instantiation does not end.
    Uninstantiable,
}

/// The compiled library's bytes, or `None`, said on stdout, where there is no C compiler.
pub(crate) fn library(behaviour: Behaviour) -> Option<&'static [u8]> {
    static BUILT: [OnceLock<Option<Vec<u8>>>; 10] = [const { OnceLock::new() }; 10];
    let flags: &[&str] = match behaviour {
        Behaviour::Integrator => &["-DKIND=0"],
        Behaviour::Gain => &["-DKIND=1"],
        Behaviour::Sampled => &["-DKIND=2"],
        Behaviour::Incomplete => &["-DKIND=0", "-DINCOMPLETE"],
        Behaviour::Version1 => &["-DKIND=0", "-DBROKEN"],
        Behaviour::Python => &["-DKIND=0", "-DPYTHON"],
        Behaviour::Hanging => &["-DKIND=0", "-DHANGING"],
        Behaviour::EndsLoaded => &["-DKIND=0", "-DENDS_PROCESS=1"],
        Behaviour::EndsInstantiated => &["-DKIND=0", "-DENDS_PROCESS=2"],
        Behaviour::Uninstantiable => &["-DKIND=0", "-DUNINSTANTIABLE"],
    };
    BUILT[behaviour as usize].get_or_init(|| compile(flags)).as_deref()
}

fn compile(flags: &[&str]) -> Option<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    // Not read where it stands, which tests of other crates do not know.
    let source = folder.path().join("fmu.c");
    std::fs::write(&source, include_str!("fmu.c")).unwrap();
    let output = folder.path().join("fmu.bin");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let status = Command::new(&compiler)
        .args(["-O1", "-shared", "-fPIC"])
        .args(flags)
        .arg(source)
        .arg("-o")
        .arg(&output)
        .status();
    match status {
        Ok(status) => {
            assert!(status.success(), "{compiler} failed on fmu.c");
            Some(std::fs::read(output).unwrap())
        }
        Err(error) => {
            println!("skipped: no C compiler ({compiler}: {error})");
            None
        }
    }
}

/// A model description of `fmu.c` in which input and output have the given names and units.
pub(crate) fn xml(input: (&str, &str), output: (&str, &str)) -> String {
    let unit =
        |unit: &str| if unit.is_empty() { String::new() } else { format!(r#" unit="{unit}""#) };
    let units: String =
        ["rad", "m", "rad/s"].iter().map(|name| format!(r#"<Unit name="{name}"/>"#)).collect();
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Test" guid="{{test-guid}}" numberOfEventIndicators="0">
<CoSimulation modelIdentifier="Test" canHandleVariableCommunicationStepSize="true"
  canGetAndSetFMUstate="true" canSerializeFMUstate="true" providesDirectionalDerivative="true"/>
<UnitDefinitions>{units}</UnitDefinitions>
<LogCategories><Category name="logStatusError"/></LogCategories>
<ModelVariables>
<ScalarVariable name="{}" valueReference="0" causality="input" variability="continuous"><Real start="0"{}/></ScalarVariable>
<ScalarVariable name="{}" valueReference="1" causality="output" variability="continuous" initial="calculated"><Real{}/></ScalarVariable>
<ScalarVariable name="gain" valueReference="2" causality="parameter" variability="tunable" initial="exact"><Real start="1"/></ScalarVariable>
<ScalarVariable name="offset" valueReference="3" causality="parameter" variability="fixed" initial="exact"><Real start="0"/></ScalarVariable>
<ScalarVariable name="misbehaviour" valueReference="4" causality="input" variability="discrete"><Integer start="0"/></ScalarVariable>
<ScalarVariable name="steps" valueReference="5" causality="output" variability="discrete" initial="calculated"><Integer/></ScalarVariable>
<ScalarVariable name="enabled" valueReference="6" causality="input" variability="discrete"><Boolean start="true"/></ScalarVariable>
<ScalarVariable name="is_positive" valueReference="7" causality="output" variability="discrete" initial="calculated"><Boolean/></ScalarVariable>
<ScalarVariable name="label" valueReference="8" causality="parameter" variability="fixed" initial="exact"><String start="none"/></ScalarVariable>
<ScalarVariable name="living_states" valueReference="10" causality="local" variability="discrete" initial="calculated"><Integer/></ScalarVariable>
<ScalarVariable name="living_instances" valueReference="11" causality="local" variability="discrete" initial="calculated"><Integer/></ScalarVariable>
<ScalarVariable name="resources" valueReference="12" causality="local" variability="discrete" initial="calculated"><String/></ScalarVariable>
</ModelVariables>
<ModelStructure>
<Outputs><Unknown index="2"/><Unknown index="6"/><Unknown index="8"/></Outputs>
<InitialUnknowns><Unknown index="2"/><Unknown index="6"/><Unknown index="8"/></InitialUnknowns>
</ModelStructure>
</fmiModelDescription>
"#,
        input.0,
        unit(input.1),
        output.0,
        unit(output.1)
    )
}

/// A zip archive of files, deflated.
pub(crate) fn zip_of(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        writer.start_file(*name, SimpleFileOptions::default()).unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// The place of a binary for the running platform.
pub(crate) fn binary_path() -> String {
    let folder = steerwright_host::platform_folders()[0];
    format!("binaries/{folder}/{}", steerwright_host::binary_name("Test"))
}

/// An opened FMU with the given description and behaviour.
pub(crate) fn open(behaviour: Behaviour, xml: &str) -> Option<Archive> {
    let bytes = zip_of(&[
        ("modelDescription.xml", xml.as_bytes()),
        (&binary_path(), library(behaviour)?),
        ("resources/data.txt", b"data"),
    ]);
    Some(Archive::from_bytes(&bytes, "Test.fmu").unwrap())
}

/// An instance of a behaviour with an input and an output, named as given, without units.
pub(crate) fn instance(
    behaviour: Behaviour,
    name: &str,
    input: &str,
    output: &str,
) -> Option<Instance> {
    let archive = open(behaviour, &xml((input, ""), (output, "")))?;
    Some(Instance::new(&archive, name).unwrap())
}
