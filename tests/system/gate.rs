//! A model that failed validation becomes no controller, no FMU and no comparison unless that is
//! accepted, and its quality stays with everything that is made from it.

use crate::support::{read_json, run, text_of};
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::Path;

/// A drive in which the driver barely steers.
const WEAK: &str = "{data}/comma2k19/steering_wheel_angle.csv {data}/comma2k19/speed.csv \
                    {data}/comma2k19/gyro.csv --input-channel steering_wheel_angle_deg \
                    --output-channel=-gyro_down_radps --steering-ratio 16.88 --structure state-space";

/// Runs a command that must stop at the gate: exit status 1, the reason and the way on.
fn stopped(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(1), "{line}: {text}");
    for expected in ["quality of the model is fail", "slalom", "--accept-untrusted"] {
        assert!(text.contains(expected), "{line}: {expected} is missing in {text}");
    }
    text
}

fn entry(archive: &Path, name: &str) -> String {
    let mut archive = zip::ZipArchive::new(fs::File::open(archive).unwrap()).unwrap();
    let mut text = String::new();
    archive.by_name(name).unwrap().read_to_string(&mut text).unwrap();
    text
}

#[test]
fn a_model_that_failed_validation_stops_every_stage_after_identify() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let output = run(folder.path(), &format!("identify {WEAK} -o plant.json"));
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let quality = read_json(&at("plant.json"))["quality"].clone();
    assert_eq!(quality["grade"], "fail");
    let reasons = quality["reasons"].as_array().unwrap();
    let weak = reasons.iter().find(|r| r["code"] == "weak-steering").unwrap();
    assert!(weak["value"].as_f64().unwrap() < weak["limit"].as_f64().unwrap());

    stopped(folder.path(), "design plant.json -o pid.json --max-rate 5rad/s");
    stopped(folder.path(), "package plant.json --out fmu");
    // Also where no controller could be designed on it anyway.
    let mut reversed = read_json(&at("plant.json"));
    let gain = &mut reversed["discrete"]["C"][0];
    gain.as_array_mut().unwrap().iter_mut().for_each(|c| *c = (-c.as_f64().unwrap()).into());
    reversed["continuous"]["H"] = reversed["discrete"]["C"].clone();
    fs::write(at("reversed.json"), reversed.to_string()).unwrap();
    stopped(folder.path(), "design reversed.json -o pid.json --max-rate 5rad/s");
    let bicycle = "bicycle {data}/comma2k19/vehicle.toml -o bicycle.json";
    assert!(run(folder.path(), bicycle).status.success());
    stopped(folder.path(), "compare plant.json bicycle.json --max-rate 5rad/s");
    assert!(!at("pid.json").exists() && !at("fmu").exists());

    // What is accepted carries the quality of its model.
    let design = "design plant.json -o pid.json --max-rate 5rad/s --accept-untrusted";
    let text = text_of(&run(folder.path(), design));
    assert!(
        text.contains("quality of the design: fail (") && text.contains("weak-steering"),
        "{text}"
    );
    let is_called_good = ["every requirement is met\n", "every requirement is met;"];
    assert!(!is_called_good.iter().any(|verdict| text.contains(verdict)), "{text}");
    assert_eq!(read_json(&at("pid.json"))["designed_for"]["quality"], quality);
    stopped(folder.path(), "package pid.json --out fmu");
    let output = run(folder.path(), "package plant.json pid.json --out fmu --accept-untrusted");
    assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
    for fmu in ["IdentifiedPlant", "LateralPid"] {
        let archive = at("fmu").join(fmu).with_extension("fmu");
        let provenance: Value =
            serde_json::from_str(&entry(&archive, "extra/io.github.steerwright/provenance.json"))
                .unwrap();
        let facts = provenance["evidence"].as_array().unwrap();
        assert!(facts.iter().any(|f| f["key"] == "quality" && f["value"] == "fail"), "{fmu}");
        assert!(entry(&archive, "documentation/index.html").contains("weak-steering"), "{fmu}");
        assert!(entry(&archive, "modelDescription.xml").contains("weak-steering"), "{fmu}");
    }
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn a_build_on_a_failed_model_ends_with_the_evidence() {
    let folder = tempfile::tempdir().unwrap();
    let vehicle = "--vehicle {data}/comma2k19/vehicle.toml --max-rate 5rad/s";
    let output = run(folder.path(), &format!("build {WEAK} {vehicle} --out out --json"));
    assert_eq!(output.status.code(), Some(1), "{}", text_of(&output));
    let overview: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(overview["quality"]["grade"], "fail");
    assert_eq!(overview["controllers"].as_array().unwrap().len(), 0);
    let out = folder.path().join("out");
    assert!(out.join("plant.json").is_file() && !out.join("pid.json").exists());
    assert!(!out.join("fmu").exists() && !out.join("pid-from-bicycle.json").exists());
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        page.contains("failed validation")
            && page.contains("Quality fail (")
            && page.contains("slalom")
    );
    let summary = page.split("<h2 id=\"s0\">").nth(1).unwrap().split("<h2").next().unwrap();
    assert_eq!(summary.matches("(standard deviation) only").count(), 1, "{summary}");
    assert!(!page.contains("Every requirement is met"));

    let accepted = format!("build {WEAK} {vehicle} --out accepted --accept-untrusted");
    run(folder.path(), &accepted);
    let page = fs::read_to_string(folder.path().join("accepted/report.html")).unwrap();
    assert!(page.contains("failed validation") && !page.contains("Every requirement is met.<"));
}
