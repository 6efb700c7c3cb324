//! The loop as a system structure package: made, run, and run as its FMUs are.

use crate::support::{chain, column, done, read_json, run, text_of};
use serde_json::Value;
use std::io::{Read, Write};
use std::path::Path;
use steerwright_host::{Archive, Connection, SystemPackage};
use steerwright_packaging::Binary;
use steerwright_packaging::ssp::{Component, Experiment};

/// The recorded road of the multi-body drive, which starts away from the origin, and the loop
/// packed for it.
fn packed(folder: &Path) {
    done(folder, "path {data}/multibody/position.csv --pid {chain}/pid.json -o path.json");
    let files = "{chain}/pid.json path.json {chain}/plant.json";
    done(folder, &format!("package {files} --out fmu --ssp LateralLoop.ssp"));
}

#[test]
fn a_package_starts_on_its_road_and_runs_as_its_fmus_do() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    packed(folder);
    let path = read_json(&folder.join("path.json"));
    let first = &path["points"][0];
    assert!(first[1].as_f64().unwrap().hypot(first[2].as_f64().unwrap()) > 0.01, "{first}");

    // Each FMU starts there by itself, and the package states it too.
    let package = SystemPackage::open(folder.join("fmu/LateralLoop.ssp")).unwrap();
    let plant = Archive::open(folder.join("fmu/IdentifiedPlant.fmu")).unwrap();
    let components = &package.structure().components;
    let names: Vec<&str> = components.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["IdentifiedPlant", "ReferencePath", "LateralPid"]);
    for (name, value) in
        [("initial_x", &first[1]), ("initial_y", &first[2]), ("initial_yaw", &first[3])]
    {
        let value = value.as_f64().unwrap().into();
        assert_eq!(plant.model().variable(name).unwrap().start, Some(value), "{name}");
        let stated = components[0].parameters.iter().find(|p| p.name == name).unwrap();
        assert_eq!(Some(&stated.value), plant.model().variable(name).unwrap().start.as_ref());
    }
    for (component, archive) in components.iter().zip(package.archives()).take(2) {
        let stated = component.parameters.iter().find(|p| p.name == "speed").unwrap();
        assert_eq!(Some(&stated.value), archive.model().variable("speed").unwrap().start.as_ref());
        assert_eq!(stated.value, path["speed_mps"].as_f64().unwrap().into());
    }

    let fmus = "fmu/IdentifiedPlant.fmu fmu/ReferencePath.fmu fmu/LateralPid.fmu";
    let stop = package.structure().stop_time.unwrap();
    for coupling in ["gauss-seidel", "jacobi"] {
        done(folder, &format!("simulate fmu/LateralLoop.ssp -o ssp.csv --coupling {coupling}"));
        // The option's old name.
        done(folder, &format!("simulate {fmus} -o fmus.csv --master {coupling} --stop {stop}s"));
        let read = |name| std::fs::read_to_string(folder.join(name)).unwrap();
        assert!(read("ssp.csv") == read("fmus.csv"), "{coupling}");
    }
    // It drove on the road to its end.
    let errors = column(&folder.join("ssp.csv"), "ReferencePath.cross_track_error");
    assert!(errors.len() > 1000 && errors.iter().all(|e| e.abs() < 1.0));
}

#[test]
fn a_package_is_the_same_to_the_byte_and_lists_its_connections() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let files = "{chain}/plant.json {chain}/pid.json {chain}/path.json";
    let output =
        done(one.path(), &format!("package {files} --out fmu --ssp LateralLoop.ssp --json"));
    done(two.path(), &format!("package {files} --out fmu --ssp LateralLoop.ssp"));
    for name in ["LateralLoop.ssp", "IdentifiedPlant.fmu"] {
        let read = |folder: &Path| std::fs::read(folder.join("fmu").join(name)).unwrap();
        assert!(read(one.path()) == read(two.path()), "{name}");
    }
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let package = printed.as_array().unwrap().last().unwrap();
    assert_eq!(package["file"], "fmu/LateralLoop.ssp");
    assert_eq!(package["connections"].as_array().unwrap().len(), 7);
    // This road starts at the origin, as the plant does, at a speed other than the drive's: only
    // that is packed otherwise.
    for name in ["IdentifiedPlant", "LateralPid"] {
        let fmu = Archive::open(one.path().join(format!("fmu/{name}.fmu"))).unwrap();
        let start = read_json(&fmu.folder().join("resources/start.json"));
        let values: Vec<&String> = start["values"].as_object().unwrap().keys().collect();
        assert_eq!(values, ["speed"], "{name}");
    }
}

#[test]
fn packages_that_cannot_be_wired_or_read_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.ssp"), "no zip").unwrap();
    let both = "{chain}/plant.json {chain}/bicycle.json {chain}/path.json {chain}/pid.json";
    for (line, what) in [
        (format!("package {both} --ssp L.ssp"), "could be connected to any of"),
        ("package {chain}/pid.json --ssp L.zip".into(), "not the name of an .ssp file"),
        ("simulate broken.ssp".into(), "broken.ssp: not a readable zip archive"),
        ("simulate broken.ssp {chain}/fmu/LateralPid.fmu".into(), "is combined with other files"),
    ] {
        let output = run(folder.path(), &line);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(text_of(&output).contains(what), "{}", text_of(&output));
        assert!(text_of(&output).contains("\nhint: "), "{}", text_of(&output));
    }
    // The other plants make a loop as well.
    for (name, plant) in
        [("Bicycle", "{chain}/bicycle.json"), ("Nonlinear", "{data}/multibody/vehicle.json")]
    {
        let files = format!("{plant} {{chain}}/path.json {{chain}}/pid.json");
        done(folder.path(), &format!("package {files} --ssp {name}.ssp"));
        done(folder.path(), &format!("simulate {name}.ssp --stop 1s"));
    }
}

/// The package with the first place where its structure has one text having another.
fn edited(package: &Path, from: &str, to: &str) -> Vec<u8> {
    let mut old = zip::ZipArchive::new(std::fs::File::open(package).unwrap()).unwrap();
    let mut new = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for index in 0..old.len() {
        let mut entry = old.by_index(index).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        if name == "SystemStructure.ssd" {
            let text = String::from_utf8(bytes).unwrap();
            assert!(text.contains(from), "{from:?} is not in {text}");
            bytes = text.replacen(from, to, 1).into_bytes();
        }
        new.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        new.write_all(&bytes).unwrap();
    }
    new.finish().unwrap().into_inner()
}

#[test]
fn a_package_at_odds_with_its_fmus_is_reported_before_its_result() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    packed(folder);
    let package = folder.join("fmu/LateralLoop.ssp");
    done(folder, "simulate fmu/LateralLoop.ssp --stop 1s -o as_made.csv");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let simulate = |from: &str, to: &str| {
        std::fs::write(folder.join("edited.ssp"), edited(&package, from, to)).unwrap();
        let line = "simulate edited.ssp --stop 1s -o edited.csv";
        (run(folder, line), run(folder, &format!("{line} --json")))
    };
    let steering = r#"<ssd:Connector name="steering_angle" kind="input">"#;
    let backwards = [
        r#"startElement="LateralPid" startConnector="steering_angle" endElement="IdentifiedPlant""#,
        r#"startElement="IdentifiedPlant" startConnector="steering_angle" endElement="LateralPid""#,
    ];
    for (from, to, what) in [
        (
            steering,
            &*steering.replace("input", "output"),
            "IdentifiedPlant.steering_angle has the kind",
        ),
        (r#"unit="rad""#, r#"unit="deg""#, "IdentifiedPlant.steering_angle has the unit \"deg\""),
        (backwards[0], backwards[1], "starts at the input IdentifiedPlant.steering_angle"),
        (
            r#"</ssv:Parameters>"#,
            r#"<ssv:Parameter name="intial_x"><ssv:Real value="1"/></ssv:Parameter></ssv:Parameters>"#,
            "IdentifiedPlant.intial_x is given a value and does not exist; near it: initial_x",
        ),
    ] {
        let (output, as_json) = simulate(from, to);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(0), "{text}");
        assert!(text.starts_with("warning: SystemStructure.ssd:"), "{text}");
        assert!(text.lines().next().unwrap().contains(what), "{what:?} is not in {text}");
        assert_eq!(text.matches("warning: ").count(), 1, "{text}");
        let printed: Value = serde_json::from_slice(&as_json.stdout).unwrap();
        assert!(printed["warnings"][0].as_str().unwrap().contains(what), "{printed}");
        // The FMUs count, so it runs as it did.
        assert!(read("edited.csv") == read("as_made.csv"), "{what}");
    }
    // The speed in km/h is the same speed.
    let speed = read_json(&folder.join("path.json"))["speed_mps"].as_f64().unwrap();
    let (output, _) = simulate(
        &format!(r#"value="{speed:?}" unit="m/s""#),
        &format!(r#"value="{:?}" unit="km/h""#, speed * 3.6),
    );
    assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
    let numbers = |name: &str| -> Vec<f64> {
        read(name).split([',', '\n']).filter_map(|cell| cell.parse().ok()).collect()
    };
    let (one, other) = (numbers("as_made.csv"), numbers("edited.csv"));
    assert!(one.len() == other.len() && one.len() > 500);
    assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-9));
    for (from, to, what) in [
        (r#"unit="m/s""#, r#"unit="furlong""#, "is in \"m/s\", its value is given in \"furlong\""),
        (
            r#"startConnector="steering_angle""#,
            r#"startConnector="stering_angle""#,
            "the connection of LateralPid.stering_angle and IdentifiedPlant.steering_angle: \
             LateralPid has no variable \"stering_angle\"; near it: steering_angle",
        ),
        (r#"unit="rad""#, r#"unit="m""#, "a unit of another dimension"),
    ] {
        let (output, _) = simulate(from, to);
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.starts_with("error: edited.ssp: SystemStructure.ssd:"), "{text}");
        assert!(text.contains(what) && text.contains("\nhint: "), "{what:?} is not in {text}");
    }
    // A stop of 1 s, and a start behind it.
    let text = text_of(&simulate(r#"startTime="0.0""#, r#"startTime="5""#).0);
    assert!(text.contains("start 5 s, step 0.01 s and stop 1 s"), "{text}");
}

/// One column drives all components over speed, in place of the start values of the package.
#[test]
fn a_package_is_driven_over_speed_by_one_column() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let files = "{chain}/bicycle.json {chain}/path.json {chain}/pid.json";
    done(folder, &format!("package {files} {{data}}/multibody/estimator.json --ssp Loop.ssp"));
    std::fs::write(folder.join("speed.csv"), "time,speed\n0,14\n2,15.5\n4,17\n").unwrap();
    done(folder, "simulate Loop.ssp --stop 6s --input speed.csv -o ssp.csv");
    let fmus = "BicyclePlant.fmu PoseEstimator.fmu ReferencePath.fmu LateralPid.fmu";
    done(folder, &format!("simulate {fmus} --stop 6s --input speed.csv -o fmus.csv"));
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert!(read("ssp.csv") == read("fmus.csv"));
    for unit in ["BicyclePlant", "PoseEstimator", "ReferencePath", "LateralPid"] {
        let speed = column(&folder.join("ssp.csv"), &format!("{unit}.speed"));
        assert_eq!((speed[0], speed[250], *speed.last().unwrap()), (14.0, 15.5, 17.0), "{unit}");
    }
    for (table, set, what) in [
        ("time,sped\n0,14\n", "", "column \"sped\""),
        ("time,speed\n0,14\n", "--set LateralPid.speed=14", "LateralPid.speed"),
    ] {
        std::fs::write(folder.join("wrong.csv"), table).unwrap();
        let output = run(folder, &format!("simulate Loop.ssp --input wrong.csv {set}"));
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(what) && text.contains("speed"), "{text}");
        assert!(text.contains("\nhint: "), "{text}");
    }
}

/// The variant with one connector of the system runs as the structure without one.
#[test]
fn the_variant_of_a_package_has_the_speed_as_its_one_connector() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    packed(folder);
    let package = folder.join("fmu/LateralLoop.ssp");
    let speed = read_json(&folder.join("path.json"))["speed_mps"].as_f64().unwrap();
    let plain = SystemPackage::open(&package).unwrap();
    assert!(plain.structure().connectors.is_empty());
    let variant = SystemPackage::open_variant(&package, "SpeedInput").unwrap();
    let structure = variant.structure();
    let [connector] = &structure.connectors[..] else { panic!("{:?}", structure.connectors) };
    assert_eq!((&*connector.name, &*connector.kind), ("speed", "input"));
    assert_eq!(connector.of_type.as_deref(), Some("Real"));
    assert_eq!(connector.unit.as_deref(), Some("m/s"));
    let [parameter] = &structure.parameters[..] else { panic!("{:?}", structure.parameters) };
    assert_eq!((&*parameter.name, parameter.unit.as_deref()), ("speed", Some("m/s")));
    assert_eq!(parameter.value, speed.into());
    let fed: Vec<&str> = structure.inputs.iter().map(|input| input.component.as_str()).collect();
    assert_eq!(fed, ["IdentifiedPlant", "ReferencePath", "LateralPid"]);
    assert_eq!(structure.connections, plain.structure().connections);
    assert!(variant.system().unwrap().1.is_empty(), "{:?}", variant.system().unwrap().1);

    let simulate = |what: &str| done(folder, &format!("simulate fmu/LateralLoop.ssp {what}"));
    std::fs::write(folder.join("speed.csv"), "time,speed\n0,14\n1,15\n").unwrap();
    for input in ["", "--input speed.csv"] {
        simulate(&format!("--stop 3s {input} -o plain.csv"));
        simulate(&format!("--stop 3s {input} -o variant.csv --variant SpeedInput"));
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
        assert!(read("plain.csv") == read("variant.csv"), "{input}");
    }
    for (line, what) in [
        ("fmu/LateralLoop.ssp --variant Speed", "only SpeedInput, SystemStructure"),
        ("fmu/LateralPid.fmu --variant SpeedInput", "--variant names a structure of an .ssp"),
    ] {
        let output = run(folder, &format!("simulate {line}"));
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(what) && text.contains("\nhint: "), "{text}");
    }
}

/// The loop in which path and controller use the estimated pose.
#[test]
fn with_an_estimator_the_loop_is_closed_through_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let files = "{chain}/pid.json {chain}/path.json {data}/multibody/estimator.json";
    let output =
        done(folder, &format!("package {files} {{chain}}/plant.json --ssp PoseLoop.ssp --json"));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let wired = printed.as_array().unwrap().last().unwrap()["connections"].clone();
    let wired: Vec<String> = serde_json::from_value(wired).unwrap();
    let expected = [
        "LateralPid.steering_angle -> IdentifiedPlant.steering_angle",
        "IdentifiedPlant.x -> PoseEstimator.gnss_x",
        "IdentifiedPlant.y -> PoseEstimator.gnss_y",
        "IdentifiedPlant.yaw_rate -> PoseEstimator.yaw_rate",
        "PoseEstimator.x -> ReferencePath.x",
        "PoseEstimator.y -> ReferencePath.y",
        "PoseEstimator.yaw -> ReferencePath.yaw",
        "PoseEstimator.sideslip_per_yaw_rate_offset -> ReferencePath.sideslip_per_yaw_rate_offset",
        "ReferencePath.yaw_reference -> LateralPid.yaw_reference",
        "PoseEstimator.yaw -> LateralPid.yaw",
        "ReferencePath.steering_feedforward -> LateralPid.steering_feedforward",
    ];
    assert_eq!(wired, expected);
    // The plant's position is no old one, and of no antenna; the values of the file are replaced, in the
    // archive itself too.
    let estimator = Archive::open(folder.join("PoseEstimator.fmu")).unwrap();
    for (name, value) in
        [("gnss_latency", 0.0), ("antenna_x", 0.0), ("gnss_period", 0.1), ("gnss_std", 0.02)]
    {
        let start = estimator.model().variable(name).unwrap().start.clone();
        assert_eq!(start, Some(value.into()), "{name}");
    }
    let fmus = "IdentifiedPlant.fmu PoseEstimator.fmu ReferencePath.fmu LateralPid.fmu";
    // At each end of the run, how far the estimate is from the plant.
    let away = |file: &str| {
        let [x, y, own_x, own_y] =
            ["IdentifiedPlant.x", "IdentifiedPlant.y", "PoseEstimator.x", "PoseEstimator.y"]
                .map(|name| column(&folder.join(file), name));
        let away = |k: usize| (x[k] - own_x[k]).hypot(y[k] - own_y[k]);
        [away(0), away(x.len() - 1)]
    };
    let start = "--set PoseEstimator.initial_y=0.5";
    for coupling in ["gauss-seidel", "jacobi"] {
        let run = |what: &str| done(folder, &format!("simulate {what} --coupling {coupling}"));
        run(&format!("PoseLoop.ssp --stop 12s -o ssp.csv {start}"));
        run(&format!("{fmus} --stop 12s -o fmus.csv {start}"));
        let read = |name| std::fs::read(folder.join(name)).unwrap();
        assert!(read("ssp.csv") == read("fmus.csv"), "{coupling}");
        // The fixes alone correct a start that is half a metre off. Under Jacobi
        // the estimate is a step old, as everything is.
        let [first, last] = away("ssp.csv");
        let late = if coupling == "jacobi" { 0.2 } else { 0.0 };
        assert!((first - 0.5).abs() < 1e-9 && last < late + 0.02, "{coupling}: {first} {last}");
        let steering = column(&folder.join("ssp.csv"), "LateralPid.steering_angle");
        assert!(steering.iter().any(|angle| angle.abs() > 0.01));
        run(&format!("{fmus} --stop 12s -o dead.csv {start} --set PoseEstimator.gnss_period=0"));
        assert!(away("dead.csv")[1] > 0.3, "{:?}", away("dead.csv"));
    }
    // A packed estimator without indication of fixes causes a warning.
    done(folder, "package {data}/multibody/estimator.json --out plain");
    let plain = fmus.replace("PoseEstimator", "plain/PoseEstimator");
    let output = done(folder, &format!("simulate {plain} --stop 1s"));
    assert!(
        text_of(&output).contains("warning: PoseEstimator receives IdentifiedPlant.x"),
        "{output:?}"
    );
    // Fixes from a file go before those of the plant.
    let fixes = "time,gnss_x,gnss_y,gnss_std,gnss_fix_count\n0,0,0,0.02,0\n1,3,4,0.02,1\n";
    std::fs::write(folder.join("fixes.csv"), fixes).unwrap();
    let output = done(folder, &format!("simulate {fmus} --stop 2s --input fixes.csv --json"));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let wired = printed["connections"].as_array().unwrap();
    assert!(wired.len() == 9 && wired.iter().all(|c| !c.to_string().contains("gnss")), "{wired:?}");
    assert_eq!(printed["last"]["PoseEstimator.gnss_y"], 4.0);
}

#[test]
fn the_help_names_the_process_of_the_binaries() {
    let folder = tempfile::tempdir().unwrap();
    let help = String::from_utf8(done(folder.path(), "simulate --help").stdout).unwrap();
    let words: Vec<&str> = help.split_whitespace().collect();
    let help = words.join(" ");
    assert!(help.contains("binaries of the FMUs run in a process of their own"), "{help}");
    assert!(help.contains("steerwright check --run"), "{help}");
}

#[test]
fn a_system_is_written_of_existing_variables_only() {
    let read = |name: &str| std::fs::read_to_string(chain().join(name)).unwrap();
    let library = [Binary { platform: "linux64", bytes: b"none" }];
    let [plant, pid] = ["plant.json", "pid.json"].map(|name| {
        steerwright_packaging::package(&read(name), name, &library, None, None).unwrap()
    });
    let write = |start: &[(&str, f64)], wires: &[Connection], step: f64| {
        let start = start.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let components =
            [Component { packed: &plant, start }, Component { packed: &pid, start: Vec::new() }];
        steerwright_packaging::ssp::ssp("A & B", &components, wires, Experiment { step, stop: 1.0 })
    };
    let wire = |output, input| [Connection::new("IdentifiedPlant", output, "LateralPid", input)];
    let bytes = write(&[("initial_x", -0.1)], &wire("yaw", "yaw"), 0.01).unwrap();
    let package = SystemPackage::from_bytes(&bytes, "a.ssp").unwrap();
    let said = package.structure();
    assert_eq!(said.name, "A & B");
    assert_eq!((said.start_time, said.stop_time, said.step), (Some(0.0), Some(1.0), Some(0.01)));
    assert_eq!(said.connections, wire("yaw", "yaw"));
    let parameter = &said.components[0].parameters[0];
    assert_eq!((&*parameter.name, parameter.unit.as_deref()), ("initial_x", Some("m")));
    assert_eq!(parameter.value, (-0.1).into());
    for (result, what) in [
        (write(&[], &wire("yaw", "jaw"), 0.01), "no input LateralPid.jaw"),
        (write(&[], &wire("speed", "yaw"), 0.01), "no output IdentifiedPlant.speed"),
        (write(&[], &wire("yaw_rate", "yaw"), 0.01), "differ in type or unit"),
        (write(&[], &wire("yaw", "enabled"), 0.01), "differ in type or unit"),
        (write(&[("mass", 1.0)], &[], 0.01), "no Real variable IdentifiedPlant.mass"),
        (write(&[], &[], 0.0), "the step size is 0"),
        (write(&[], &[], f64::NAN), "the step size is NaN"),
    ] {
        let error = result.unwrap_err();
        assert!(error.to_string().contains(what) && !error.hint().is_empty(), "{error}");
    }
}
