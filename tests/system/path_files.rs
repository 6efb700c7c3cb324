//! `steerwright path` on everything that a road may come in.

use crate::support::{run, text_of};
use serde_json::Value;
use std::path::Path;

fn path(folder: &Path, line: &str) -> (Value, String) {
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", text_of(&output));
    (serde_json::from_slice(&output.stdout).unwrap(), text_of(&output))
}

/// A straight of 200 m to the north-east, a fix each metre and a half.
fn nmea(quality: char, satellites: u32) -> String {
    (0..134)
        .map(|k| {
            let data = format!(
                "GPGGA,1200{:02}.{},5200.{:07},N,00800.{:07},E,{quality},{satellites:02},0.9,80.0,M,45.0,M,1,1",
                k / 10,
                k % 10,
                k * 5_700,
                k * 9_250
            );
            let sum = data.bytes().fold(0_u8, |sum, byte| sum ^ byte);
            format!("${data}*{sum:02X}\r\n")
        })
        .collect()
}

fn length(path: &Value) -> f64 {
    path["points"].as_array().unwrap().last().unwrap()[0].as_f64().unwrap()
}

#[test]
fn recordings_and_segments_become_paths() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();

    write("drive.nmea", &nmea('4', 12));
    let (driven, _) = path(folder, "path drive.nmea --json");
    assert!((190.0..210.0).contains(&length(&driven)), "{}", length(&driven));
    assert_eq!(driven["provenance"]["sources"][0]["name"], "drive.nmea");

    // An option of the standard road is not ignored.
    let output = run(folder, "path drive.nmea --lateral-acceleration 2m/s2");
    assert_eq!(output.status.code(), Some(2));
    assert!(text_of(&output).contains("--lateral-acceleration"), "{}", text_of(&output));

    // Without correction: rejected, or used and reported.
    write("phone.nmea", &nmea('1', 12));
    let output = run(folder, "path phone.nmea");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text_of(&output).contains("phone.nmea: none of 134 fixes can be used"),
        "{}",
        text_of(&output)
    );
    assert!(text_of(&output).contains("hint: ") && text_of(&output).contains("--poor-fixes mark"));
    let (marked, said) = path(folder, "path phone.nmea --poor-fixes mark --json");
    assert_eq!(marked["points"], driven["points"]);
    assert!(said.contains("{\"warning\":{\"message\":\"used 134 of 134 fixes"), "{said}");

    let bad = nmea('4', 12).replacen("*", "*0", 1);
    write("bad.nmea", &bad);
    let output = run(folder, "path bad.nmea");
    assert_eq!(output.status.code(), Some(2));
    assert!(text_of(&output).contains("bad.nmea:1:"), "{}", text_of(&output));

    write("broken.gpx", "<gpx><trk>\n<trkseg></gpx>");
    let output = run(folder, "path broken.gpx");
    assert_eq!(output.status.code(), Some(2));
    assert!(text_of(&output).contains("broken.gpx:2:9: "), "{}", text_of(&output));

    write(
        "road.toml",
        "name = \"bend\"\n[[segments]]\nlength_m = 60.0\n[[segments]]\nlength_m = 30.0\n\
         end_curvature_per_m = 0.01\n[[segments]]\nlength_m = 40.0\ncurvature_per_m = 0.01\n",
    );
    let options = "--speed 10m/s --sideslip-per-yaw-rate -40ms --cross-track-integral 0.05/s";
    let said = text_of(&run(folder, &format!("path road.toml {options}")));
    let (bend, _) = path(folder, &format!("path road.toml {options} --json"));
    assert!((length(&bend) - 130.0).abs() < 1e-9);
    assert_eq!(bend["guidance"]["sideslip_per_yaw_rate_s"], -0.04);
    assert_eq!(bend["guidance"]["cross_track_integral_gain_per_s"], 0.05);
    assert!(said.contains("curvature up to 0.0100 1/m"), "{said}");
    // The file holds no option that was not stated.
    assert!(driven["guidance"].get("cross_track_integral_gain_per_s").is_none());
    let output = run(folder, "path road.toml --cross-track-integral -1/s");
    assert!(text_of(&output).contains("cross_track_integral_gain_per_s"), "{}", text_of(&output));
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text_of(&run(folder, "path road.toml --closed")).contains("a road of segments has ends")
    );
}
