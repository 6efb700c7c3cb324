//! Vehicle data, tracks, the stages' files, and what is simulated.

use super::refused;
use crate::support::{self, chain, data};
use serde_json::{Value, json};

#[test]
fn vehicle_data() {
    let good = std::fs::read_to_string(support::data().join("multibody/vehicle.toml")).unwrap();
    for (from, to, says) in [
        ("mass_kg = 1093.2952", "mass_kg = -5", &["v.toml:5:11: mass_kg: -5"] as &[_]),
        ("mass_kg = 1093.2952", "mass_kg = nan", &["v.toml:5:11: mass_kg: NaN"]),
        ("mass_kg = 1093.2952", "mass_kg = \"heavy\"", &["v.toml:5:11:", "string"]),
        ("mass_kg = 1093.2952", "", &["v.toml:1:1: missing field `mass_kg`"]),
        (
            "mass_kg",
            "mas_kg",
            &["v.toml:5:1: unknown field `mas_kg`", "a TOML file; its keys are name, mass_kg"],
        ),
        ("= 1791.5995", "= 1e-300", &["v.toml: the model's fastest rate"]),
    ] {
        assert!(good.contains(from));
        refused((&[("v.toml", &good.replace(from, to))], "bicycle v.toml", says));
    }
    refused((&[], "bicycle v.toml", &["v.toml: No such file"]));
}

#[test]
fn tracks() {
    for (content, arguments, says) in [
        ("", "", &["t.csv:1:1: no columns x_m and y_m"] as &[_]),
        ("a,b\n1,2\n", "", &["t.csv:1:1:", "there are: a, b"]),
        ("x_m,y_m\n1,2\n", "", &["t.csv: 1 distinct points", "at least 4"]),
        ("x_m,y_m\n1,2\n1,2\n1,2\n1,2\n1,2\n", "", &["t.csv: 1 distinct points"]),
        ("x_m,y_m\n0,0\n1,NaN\n", "", &["t.csv:3:3: y_m is `NaN`, not a number"]),
        ("x_m,y_m\n0,0\n1\n", "", &["t.csv:3:3: the row has no y_m"]),
        ("x_m,y_m\n0,0\n1,1e300\n", "", &["t.csv:3:3: y_m is 1e300"]),
        ("x_m,y_m\n0,0\n1e7,0\n2e7,0\n3e7,0\n4e7,0\n", "", &["length of the path is 40000000"]),
        ("x_m,y_m\n0,0\n1,0\n2,0\n3,0\n4,0\n", "--closed", &["t.csv: the curvature reaches inf"]),
        ("x_m,y_m\n0,0\n1,0\n2,0\n3,0\n", "--speed 0m/s", &["speed is 0 m/s"]),
        ("x_m,y_m\n", "--pid {chain}/plant.json", &["t.csv: 0 distinct points"]),
    ] {
        refused((&[("t.csv", content)], &format!("path t.csv {arguments}"), says));
    }
    for (line, says) in [
        ("path --speed 1m/s", &["double lane change: a curvature of 4.0000 1/m"] as &[_]),
        ("path --speed 1e5m/s", &["speed is 100000 m/s: it must be at most 150 m/s"]),
        (
            "path --lateral-acceleration 1e-6m/s2",
            &["lateral acceleration is 0.000001 m/s²: it must be at least 0.1 m/s²"],
        ),
        ("path --lateral-acceleration 1e6m/s2", &["it must be at most 50 m/s²"]),
        ("path --speed 20", &["'--speed <SPEED>'", "(m/s or km/h)"]),
        ("path --pid {chain}/plant.json", &["found `steerwright/plant/1`", "steerwright/pid/1"]),
    ] {
        refused((&[], line, says));
    }
}

/// A file of the chain, changed.
fn edited(file: &str, edit: impl Fn(&mut Value)) -> String {
    let text = std::fs::read_to_string(chain().join(file)).unwrap();
    let mut value = serde_json::from_str(&text).unwrap();
    edit(&mut value);
    value.to_string()
}

#[test]
fn documents() {
    let plant = |edit: fn(&mut Value)| edited("plant.json", edit);
    let pid = |edit: fn(&mut Value)| edited("pid.json", edit);
    let path = |edit: fn(&mut Value)| edited("path.json", edit);
    let example = data().join("multibody/vehicle.json").display().to_string();
    let vehicle = |edit: fn(&mut Value)| edited(&example, edit);
    let not_json = plant(|_| ()).replacen("\"A\":[[", "\"A\":[[NaN, ", 1);
    for (content, command, says) in [
        (plant(|p| p["schema"] = json!("steerwright/plant/3")), "design", &["plant/3"] as &[_]),
        (plant(|p| p["discrete"]["A"] = json!([[1, 2]])), "design", &["at `discrete.A`", "1 by 2"]),
        (plant(|p| p["discrete"]["B"] = json!([[1], []])), "design", &["at `discrete.B`"]),
        (not_json.clone(), "design", &["f.json:1:", "at `discrete.A[0][0]`"]),
        (not_json, "package", &["f.json:1:"]),
        (plant(|p| p["steering_ratio"] = json!(0)), "design", &["f.json: at `steering_ratio`"]),
        (plant(|p| p["extra"] = json!(1)), "design", &["at `extra`: unknown field"]),
        (
            plant(|p| {
                p["discrete"]["A"][0][0] = json!(1.5);
                p.as_object_mut().unwrap().remove("continuous");
            }),
            "design",
            &["f.json: ", "unstable"],
        ),
        (
            plant(|p| {
                for (model, input) in [("discrete", "B"), ("continuous", "G")] {
                    for row in p[model][input].as_array_mut().unwrap() {
                        row[0] = json!(-row[0].as_f64().unwrap());
                    }
                }
            }),
            "design",
            &["f.json: ", "steady-state gain", "check the signs"],
        ),
        (
            edited("bicycle.json", |b| b["schema"] = json!("steerwright/bicycle/9")),
            "design",
            &["expected `steerwright/bicycle/1`"],
        ),
        (pid(|_| ()), "design", &["`steerwright/pid/1` is no plant, bicycle, vehicle, ", " model"]),
        ("name = \"x\"\n".to_owned(), "design", &["f.json:1:", "not a JSON document"]),
        (plant(|_| ()), "bicycle", &["f.json:1:1", "vehicle data are a TOML file"]),
        (pid(|p| p["sample_time_s"] = json!(-0.01)), "package", &["at `sample_time_s`: -0.01"]),
        (pid(|p| p["gains"]["kp"] = json!(-1)), "package", &["at `gains.kp`: -1"]),
        (vehicle(|_| ()), "design", &["no rate of the steering is stated"]),
        (
            vehicle(|v| v["tyres"]["shape_factor"] = json!(3)),
            "package",
            &["at `tyres.shape_factor`: 3"],
        ),
        (
            vehicle(|v| v["body"]["track_width_m"] = json!(1e6)),
            "package",
            &["the track width is 1000000"],
        ),
        (path(|p| p["points"] = json!([[0, 0, 0, 0, 0]])), "package", &["at `points`: 1 points"]),
        (path(|p| p["points"][5][0] = json!(0)), "package", &["at `points[5][0]`"]),
        (path(|p| p["schema"] = json!("steerwright/x/1")), "package", &["`steerwright/x/1`"]),
        ("time,x\n".to_owned(), "package", &["f.json:1:"]),
        ("[]".to_owned(), "package", &["f.json: no FMU is made from"]),
    ] {
        refused((&[("f.json", &content)], &format!("{command} f.json"), says));
    }
    let two = "package {chain}/plant.json f.json";
    refused((&[("f.json", &plant(|_| ()))], two, &["both make IdentifiedPlant.fmu"]));
    for (content, says) in [
        (
            "settling = \"1s\"\nsetling = \"1s\"\n",
            &["s.toml:2:1: `setling` is no requirement; near it: settling"],
        ),
        ("settling = \"1\"\n", &["s.toml:1:12: settling: a number with its unit (ms or s)"]),
        ("settling = 1\n", &["s.toml:1:12: settling: a number with its unit"]),
        ("overshoot = [1]\n", &["s.toml:1:13: overshoot: a text with a unit"]),
        ("disk-margin = 3\n", &["s.toml:1:15: disk-margin: disk margin is 3"]),
        (
            "settling = \"1s\"\n  rise-time = \"2s\"\n",
            &["s.toml:2:15: rise-time: a rise time of up to 2 s contradicts"],
        ),
        ("settling = \"1s\"\nsettling = \"2s\"\n", &["s.toml:2:1:"]),
        ("", &["s.toml:1:1: the file has no requirement"]),
    ] as [(&str, &[&str]); 8]
    {
        let line = "design {chain}/plant.json --requirements s.toml";
        refused((&[("s.toml", content)], line, says));
    }
    for (line, says) in [
        ("design {chain}/plant.json --settling 0s", &["settling time is 0 s: it must be"] as &[_]),
        ("design {chain}/plant.json --overshoot -1%", &["overshoot is -1 %: it must be"]),
        ("design {chain}/plant.json --max-angle 22", &["'--max-angle <ANGLE>'", "(deg or rad)"]),
        ("design {chain}/plant.json --modulus-margin 2", &["modulus margin is 2"]),
        ("design {chain}/plant.json --settling 30ms", &["fewer than 4 samples"]),
        ("design {chain}/plant.json --gain-margin 6", &["'--gain-margin <GAIN>'", "(dB)"]),
        (
            "design {chain}/plant.json --rise-time 2s",
            &["a rise time of up to 2 s contradicts a settling time of at most 1 s"],
        ),
        ("package {chain}/plant.json --step 0s", &["the step size is 0"]),
        ("package missing.json", &["missing.json: No such file"]),
    ] {
        refused((&[], line, says));
    }
}

#[test]
fn simulations() {
    let all = ["IdentifiedPlant", "ReferencePath", "LateralPid"];
    let all = all.map(|name| format!("{{chain}}/fmu/{name}.fmu")).join(" ");
    let with = |arguments: &str| format!("simulate {all} {arguments}");
    for (content, arguments, says) in [
        ("time,speed\n", "--input f", &["f: it has no rows"] as &[_]),
        ("time,sped\n0,1\n", "--input f", &["column \"sped\" names no input", "speed"]),
        ("t,speed\n0,1\n", "--input f", &["the first column is \"t\""]),
        ("time,speed\n0,x\n", "--input f", &["f: line 2, column \"speed\": \"x\""]),
        ("time,speed\n0,NaN\n", "--input f", &["f: line 2, column \"speed\""]),
        ("time,speed\n0\n", "--input f", &["f: line 2: the row has 1 cells"]),
        ("time,speed\n0,1\n0,2\n", "--input f", &["f: line 3: time 0 s does not come after"]),
        ("time,speed\n1,1\n", "--input f", &["f: starts at 1 s"]),
        ("time,yaw\n0,1\n", "--input f", &["it is fed by"]),
        ("", "f", &["f: not a readable zip archive"]),
        ("", "{chain}/fmu/BicyclePlant.fmu", &["could be connected to any of", "omit"]),
        ("", "{chain}/fmu/LateralPid.fmu", &["two instances are named \"LateralPid\""]),
        ("", "--set LateralPid.kpp=1", &["no variable \"kpp\"; near it: kp"]),
        ("", "--set Pid.kp=1", &["no instance \"Pid\"; it has IdentifiedPlant"]),
        ("", "--set LateralPid.kp", &["not of the form"]),
        ("", "--set LateralPid.kp=x", &["LateralPid.kp: \"x\""]),
        ("", "--set LateralPid.kp=-1", &["`kp` cannot be -1"]),
        ("", "--set LateralPid.yaw=1", &["fed by IdentifiedPlant.yaw"]),
        ("", "--step 0s", &["step 0 s"]),
        ("", "--step 30ms --stop 1s", &["not a whole number of steps"]),
        ("", "--stop 1e12s", &["more than 100 million steps"]),
        ("", "--coupling foo", &["[possible values: gauss-seidel, jacobi]"]),
        ("", "-o f/result.csv", &["f: this is a file, not a folder"]),
        ("", "-o .", &[".: this is a folder"]),
    ] {
        refused((&[("f", content)], &with(arguments), says));
    }
    refused((&[], "simulate missing.fmu", &["missing.fmu: No such file"]));
}
