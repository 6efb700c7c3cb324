//! Stages on their own: identification with its figures, accumulated drives, a design in the loop of the
//! packed FMUs.

use crate::support::{self, read_json, run, text_of};
use std::fs;
use std::path::Path;

const LOG: &str =
    "{data}/multibody/drive.csv --input-channel steering_command_rad --steering-ratio 1";

fn done(folder: &Path, line: &str) -> String {
    text_of(&support::done(folder, line))
}

#[test]
fn the_evidence_is_drawn_without_a_build() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &format!("identify {LOG} -o plant.json --plots plots --report page.html"));
    for name in ["frequency-response", "poles-and-zeros", "residuals", "prediction"] {
        let svg = fs::read_to_string(folder.path().join(format!("plots/{name}.svg"))).unwrap();
        assert!(svg.trim_start().starts_with("<svg") && svg.contains("</svg>"), "{name}");
    }
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("</html>") && page.contains("fit to design on"));
    let factor = &read_json(&folder.path().join("plant.json"))["evidence"]["factor"];
    assert_eq!(factor["method"], "gram");
}

#[test]
fn an_accumulated_drive_gives_a_plant_with_its_limits() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &format!("accumulate {LOG} -o drive.rfactor"));
    let text = done(folder.path(), "identify drive.rfactor -o plant.json");
    assert!(text.contains("there is no simulation of whole drives"), "{text}");
    let plant = read_json(&folder.path().join("plant.json"));
    assert!(plant["evidence"]["fit"]["estimation"].as_f64().unwrap() > 97.0);
    // The plant is one that can be packed, and a factor is no log.
    assert_eq!(plant["quality"]["grade"], "pass");
    done(folder.path(), "package plant.json --out fmu");
    assert!(folder.path().join("fmu/IdentifiedPlant.fmu").is_file());
    for (line, expected) in [
        ("identify drive.rfactor --plots plots", "an R factor holds no signals"),
        (
            "identify drive.rfactor --input-channel steering_command_rad",
            "have no effect on an R factor",
        ),
        ("identify drive.rfactor {data}/multibody/drive.csv", "is an R factor"),
    ] {
        let output = run(folder.path(), line);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(text_of(&output).contains(expected), "{line}: {}", text_of(&output));
    }
}

/// What the design predicts for each coupling is what the packed FMUs do under it. Under Jacobi the
/// response is seen a sample late, which moves times by up to a sample and nothing else.
#[test]
fn a_design_is_proved_in_the_loop_of_the_fmus() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &format!("identify {LOG} -o plant.json"));
    done(folder.path(), "design plant.json -o pid.json --max-rate 0.4rad/s --plots plots");
    let pid = read_json(&folder.path().join("pid.json"));
    let sample_time = pid["sample_time_s"].as_f64().unwrap();
    let loops = pid["evidence"]["fmu_loops"].as_array().unwrap();
    let couplings: Vec<&str> = loops.iter().map(|l| l["coupling"].as_str().unwrap()).collect();
    assert_eq!(couplings, ["gauss-seidel", "jacobi"]);
    for (in_fmus, late) in loops.iter().zip([0.0, sample_time]) {
        let (step, predicted) = (&in_fmus["step"], &in_fmus["predicted"]);
        assert_eq!(in_fmus["loop_delay_s"].as_f64().unwrap(), late);
        for key in ["overshoot_percent", "settling_time_s", "rise_time_s", "largest_angle_rad"] {
            let apart = (step[key].as_f64().unwrap() - predicted[key].as_f64().unwrap()).abs();
            let allowed = 1e-6 + if key == "settling_time_s" { late } else { 0.0 };
            assert!(apart <= allowed, "{} {key}: {apart}", in_fmus["coupling"]);
        }
    }
    // The key's old name is read.
    let text = std::fs::read_to_string(folder.path().join("pid.json")).unwrap();
    std::fs::write(folder.path().join("old.json"), text.replace("\"coupling\"", "\"master\""))
        .unwrap();
    done(folder.path(), "package old.json --out fmu");
    for name in ["bode", "nyquist", "step", "step-with-offset"] {
        assert!(folder.path().join(format!("plots/{name}.svg")).is_file(), "{name}");
    }
}

/// The loops of the FMUs run without the stated latency: the figures in one row are of different loops,
/// and the summary reports it.
#[test]
#[ignore = "slow: cargo xtask test"]
fn a_latency_that_the_fmus_lack_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let unlike = "have no latency but their coupling's";
    done(folder.path(), &format!("identify {LOG} -o plant.json"));
    for latency in ["60 ms", "14 ms"] {
        let line = format!("design plant.json --latency {} -o late.json", latency.replace(' ', ""));
        let text = done(folder.path(), &line);
        assert!(text.contains(unlike) && text.contains(latency), "{text}");
    }
    let text = done(folder.path(), "design plant.json --coupling jacobi -o jacobi.json");
    assert!(!text.contains(unlike), "{text}");
}

/// Seconds since 1970: figures, page and windows count from the first sample, and the start is stated once.
#[test]
fn a_drive_stamped_since_1970_is_drawn_from_zero() {
    let folder = tempfile::tempdir().unwrap();
    let drive = fs::read_to_string(support::data().join("multibody/drive.csv")).unwrap();
    let stamped = drive.lines().map(|line| match line.split_once(',') {
        Some((time, rest)) if time.parse::<f64>().is_ok() => {
            format!("{:.3},{rest}\n", 1_764_000_000.06 + time.parse::<f64>().unwrap())
        }
        _ => format!("{line}\n"),
    });
    fs::write(folder.path().join("epoch.csv"), stamped.collect::<String>()).unwrap();
    let log = "epoch.csv --input-channel steering_command_rad --steering-ratio 1";
    let line =
        format!("identify {log} --window 10s..60s -o plant.json --plots plots --report p.html");
    let text = done(folder.path(), &line);
    assert_eq!(text.matches("1764000000.06 s (2025-11-24 16:00:00 UTC)").count(), 1, "{text}");
    for name in ["drive", "comparison"] {
        let svg = fs::read_to_string(folder.path().join(format!("plots/{name}.svg"))).unwrap();
        assert!(svg.contains(">20</text>") && !svg.contains(">1764"), "{name}: {svg}");
    }
    let page = fs::read_to_string(folder.path().join("p.html")).unwrap();
    assert_eq!(page.matches("1764000000.06 s (").count(), 1);
    let data = page.split("id=\"figures\">").nth(1).unwrap().split("</script>").next().unwrap();
    assert!(!data.contains("1764000"), "the data of the page count from zero");
    let text = done(folder.path(), "inspect epoch.csv --plot channels.html");
    assert!(text.contains("0.000 to ") && text.contains("1764000000.060 s on the log's clock"));
    let output = support::done(folder.path(), "inspect epoch.csv --json");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["log_start_s"], 1_764_000_000.06);
    let [first, last] = [0, 1].map(|k| found["groups"][0]["span_s"][k].as_f64().unwrap());
    assert!(first == 0.0 && (last - 102.99).abs() < 1e-3, "{first} to {last}");
    let failed = run(folder.path(), &format!("identify {log} --window 1764000010s..1764000060s"));
    assert_eq!(failed.status.code(), Some(2));
    let text = text_of(&failed);
    assert!(text.contains("the window covers 1764000010 to 1764000060 s, the log 0 to"), "{text}");
}
