//! `steerwright path` on everything that a road may come in.

use crate::support::{done, run, text_of};
use serde_json::Value;
use std::path::Path;
use steerwright_host::{Archive, Instance};
use steerwright_packaging::Fmu;

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

/// Straight, clothoid, arc of a radius of 22 m, at whose end the road ends.
const BEND: &str = "name = \"bend\"\n[[segments]]\nlength_m = 60.0\n[[segments]]\nlength_m = 20.0\n\
    end_curvature_per_m = 0.045\n[[segments]]\nlength_m = 40.0\ncurvature_per_m = 0.045\n";

#[test]
fn a_road_beyond_the_controller_is_reported_before_it_is_driven() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("bend.toml"), BEND).unwrap();
    let warnings = |line: &str| -> Vec<String> {
        let (_, said) = path(folder, &format!("path {line} --force --json"));
        let of_line = |text: &str| {
            let value: Value = serde_json::from_str(text).ok()?;
            value["warning"]["message"].as_str().map(str::to_owned)
        };
        said.lines().filter_map(of_line).collect()
    };
    // The standard road of 4 m/s² needs nothing unusual; a bend of 10.1 m/s² more than the 6 m/s² of the design.
    assert_eq!(warnings("--pid {chain}/pid.json"), Vec::<String>::new());
    assert_eq!(warnings("bend.toml"), Vec::<String>::new());
    assert_eq!(
        warnings("bend.toml --pid {chain}/pid.json"),
        [
            "the road needs 10.1 m/s² of lateral acceleration at 80 m, 1.69 of the 6.0 m/s² that the controller \
          has: drive it at 10.9 m/s or slower"
        ]
    );
    // At that speed it is feasible, but the controller is designed for another.
    assert_eq!(
        warnings("bend.toml --pid {chain}/pid.json --speed 10.9m/s"),
        [
            "the path is for 10.9 m/s, the controller for 15.0 m/s: design it for 10.9 m/s (design --speeds for a \
          range), or make the path with --speed 14.99m/s"
        ]
    );

    // With a slow actuator the road needs more than its rate, which a design reports of the standard road too.
    let pid = crate::support::read_json(&crate::support::chain().join("pid.json"));
    let slow = |rate: f64, bound: bool| {
        let mut pid = pid.clone();
        pid["limits"]["max_rate_radps"] = rate.into();
        if !bound {
            pid["limits"].as_object_mut().unwrap().remove("lateral_acceleration");
        }
        std::fs::write(folder.join("slow.json"), pid.to_string()).unwrap();
    };
    slow(0.08, true);
    let said = warnings("bend.toml --pid slow.json --speed 15m/s");
    assert!(said.len() == 2 && said[1].contains("rad/s of steering rate at "), "{said:?}");
    assert!(
        said[1].contains("of the 0.08 rad/s that the controller has: drive it at "),
        "{said:?}"
    );
    let output = run(folder, "design {chain}/plant.json --max-rate 0.07rad/s -o slow.json --force");
    let text = text_of(&output);
    assert!(
        text.contains(
            "warning: the standard road of 4 m/s² at 15.0 m/s needs 0.07 rad/s of steering rate"
        ),
        "{text}"
    );
    // A controller that states no largest lateral acceleration is compared with that of the model's evidence.
    slow(9.0, false);
    let output = run(folder, "path bend.toml --pid slow.json --force");
    let text = text_of(&output);
    assert!(text.contains("lateral acceleration is compared with no limit"), "{text}");
    assert!(!text.contains("warning: "), "{text}");
}

#[test]
fn a_build_reports_roads_beyond_its_controller() {
    let folder = tempfile::tempdir().unwrap();
    let line = "build {data}/multibody/drive.csv --input-channel steering_command_rad --robust off \
                --lateral-acceleration 7m/s2 --out b --json";
    let (built, said) = path(folder.path(), line);
    let expected = "identification-based controller on road: the road needs 7.0 m/s² of lateral acceleration at";
    let remarks = built["remarks"].as_array().unwrap();
    assert!(remarks.iter().any(|r| r.as_str().unwrap().starts_with(expected)), "{remarks:?}");
    assert!(said.contains(expected), "{said}");
}

/// Two bends on which several limits bind.
const BENDS: &str = "name = \"bends\"\n[[segments]]\nlength_m = 80.0\n[[segments]]\nlength_m = 20.0\n\
    end_curvature_per_m = 0.03\n[[segments]]\nlength_m = 30.0\ncurvature_per_m = 0.03\n[[segments]]\n\
    length_m = 40.0\ncurvature_per_m = 0.03\nend_curvature_per_m = -0.03\n[[segments]]\nlength_m = 20.0\n\
    curvature_per_m = -0.03\nend_curvature_per_m = 0.0\n[[segments]]\nlength_m = 90.0\n";

#[test]
fn a_profile_has_the_limits_of_its_options_and_of_the_controller() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("bends.toml"), BENDS).unwrap();
    let line = "path bends.toml --pid {chain}/pid.json --profile --max-jerk 3m/s3 --friction 0.7 \
                --max-speed 20m/s --end-speed 5m/s";
    let (written, _) = path(folder, &format!("{line} --json"));
    let said = text_of(&run(folder, &format!("{line} --force")));
    let pid = crate::support::read_json(&crate::support::chain().join("pid.json"));
    let limits = &written["profile"]["limits"];
    for (key, expected) in [
        ("max_speed_mps", 20.0),
        ("max_acceleration_mps2", 2.0),
        ("max_deceleration_mps2", 3.5),
        ("max_jerk_mps3", 3.0),
        ("friction", 0.7),
    ] {
        assert_eq!(limits[key], expected, "{key}");
    }
    let stated = &pid["limits"];
    for (got, of_pid) in [
        (&limits["max_lateral_acceleration_mps2"], &stated["lateral_acceleration"]["max_mps2"]),
        (&limits["steering"]["max_angle_rad"], &stated["max_angle_rad"]),
        (&limits["steering"]["max_rate_radps"], &stated["max_rate_radps"]),
    ] {
        let share = got.as_f64().unwrap() / of_pid.as_f64().unwrap();
        assert!((share - 0.9).abs() < 1e-9, "{got} {of_pid}");
    }
    assert_eq!(limits["end_speeds_mps"], serde_json::json!([0.0, 5.0]));
    let points = written["profile"]["points"].as_array().unwrap();
    let last = points.last().unwrap()[1].as_f64().unwrap();
    assert!((last - 5.0).abs() < 0.01, "{last}");
    let time = written["profile"]["time_s"].as_f64().unwrap();
    assert!(said.contains(&format!("speed profile: {time:.2} s, largest speed ")), "{said}");
    assert!(said.contains("lateral acceleration") && said.contains("% of the time"), "{said}");

    // Drawn, with the limits that bind.
    done(folder, "path bends.toml --profile --force --plot profile.svg");
    let drawn = std::fs::read_to_string(folder.join("profile.svg")).unwrap();
    for part in
        ["Speed (m/s)", "Lateral acceleration (m/s²)", "Speed profile", "lateral acceleration"]
    {
        assert!(drawn.contains(part), "{part}");
    }

    // Without a controller the steering is not limited, which is reported; the jerk may be unlimited.
    let (free, said) = path(folder, "path bends.toml --profile --max-jerk none --force --json");
    assert!(free["profile"]["limits"].get("steering").is_none());
    assert!(free["profile"]["limits"].get("max_jerk_mps3").is_none());
    assert!(said.contains("does not limit the steering"), "{said}");
    // Of a speed controller: its limits, less what it needs for its feedback.
    std::fs::write(folder.join("speed.json"), Fmu::SpeedController.example()).unwrap();
    let line = "path bends.toml --profile --speed-controller speed.json --force --json";
    let (driven, _) = path(folder, line);
    let file = crate::support::read_json(&folder.join("speed.json"));
    for (key, share) in
        [("max_acceleration_mps2", 0.9), ("max_deceleration_mps2", 0.9), ("max_jerk_mps3", 0.7)]
    {
        let [of_profile, of_controller] =
            [&driven["profile"], &file].map(|document| document["limits"][key].as_f64().unwrap());
        assert!((of_profile / of_controller - share).abs() < 1e-9, "{key}: {of_profile}");
    }
    assert_eq!(driven["provenance"]["sources"].as_array().unwrap().len(), 2);
    // And the lags of its drive and its brake.
    for (key, lag) in [
        ("speed_preview_time_s", ["time_constant_s", "delay_s"].map(|name| &file["model"][name])),
        (
            "brake_preview_time_s",
            ["time_constant_s", "delay_s"].map(|name| &file["model"]["brake"][name]),
        ),
    ] {
        let expected: f64 = lag.iter().map(|part| part["value"].as_f64().unwrap()).sum();
        let got = driven["guidance"][key].as_f64().unwrap();
        assert!((got - expected).abs() < 1e-9 && got > 0.0, "{key}: {got}");
    }
    assert!(free["guidance"].get("speed_preview_time_s").is_none());
    assert!(said.contains("no preview of the speed"), "{said}");

    for (line, expected) in [
        ("--max-jerk 2m/s3", "--profile"),
        ("--profile --max-rate 0.3rad/s", "state the controller with --pid or the vehicle"),
        ("--profile --friction 0", "friction is 0: it must be greater than 0"),
        ("--profile --start-speed 40m/s --max-speed 50m/s", "the start speed is 40 m/s"),
        (
            "--profile --max-rate 0.0002rad/s --plant {chain}/plant.json",
            "the vehicle would have to stop",
        ),
    ] {
        let output = run(folder, &format!("path bends.toml {line} --force"));
        assert_eq!(output.status.code(), Some(2), "{line}: {}", text_of(&output));
        assert!(text_of(&output).contains(expected), "{line}: {}", text_of(&output));
    }
}

/// Speed and acceleration that a ReferencePath puts out for a vehicle on the path at distances.
fn references(archive: &Archive, path: &Value, distances: &[f64]) -> Vec<[f64; 2]> {
    let points: Vec<Vec<f64>> = serde_json::from_value(path["points"].clone()).unwrap();
    let mut all = Vec::new();
    for distance in distances {
        let after = points.partition_point(|p| p[0] <= *distance).clamp(1, points.len() - 1);
        let (a, b) = (&points[after - 1], &points[after]);
        let share = (distance - a[0]) / (b[0] - a[0]);
        let mut fmu = Instance::new(archive, "path").unwrap();
        fmu.setup_experiment(0.0, None, None).unwrap();
        fmu.enter_initialization_mode().unwrap();
        for (name, k) in [("x", 1), ("y", 2), ("yaw", 3)] {
            fmu.set(name, a[k] + share * (b[k] - a[k])).unwrap();
        }
        fmu.exit_initialization_mode().unwrap();
        fmu.do_step(0.0, 0.01).unwrap();
        let mut value = |name: &str| fmu.real(name).unwrap();
        assert!((value("distance") - distance).abs() < 0.01);
        all.push([value("speed_reference"), value("acceleration_reference")]);
    }
    all
}

#[test]
fn the_packed_path_has_the_speed_of_its_profile_and_drives_a_speed_controller() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("bends.toml"), BENDS).unwrap();
    let (constant, _) = path(folder, "path bends.toml --pid {chain}/pid.json --speed 9m/s --json");
    done(folder, "package path.json --out constant");
    let archive = Archive::open(folder.join("constant/ReferencePath.fmu")).unwrap();
    for reference in references(&archive, &constant, &[0.0, 100.0]) {
        assert_eq!(reference, [9.0, 0.0]);
    }

    let line = "path bends.toml --pid {chain}/pid.json --profile --force --json";
    let (profiled, _) = path(folder, line);
    done(folder, "package path.json --out fmu");
    done(folder, "check fmu/ReferencePath.fmu --run --strict");
    let archive = Archive::open(folder.join("fmu/ReferencePath.fmu")).unwrap();
    let points: Vec<[f64; 3]> =
        serde_json::from_value(profiled["profile"]["points"].clone()).unwrap();
    let chosen: Vec<[f64; 3]> = points.iter().skip(80).step_by(97).copied().collect();
    let distances: Vec<f64> = chosen.iter().map(|point| point[0]).collect();
    assert!(chosen.len() > 4, "{}", points.len());
    for (reference, point) in references(&archive, &profiled, &distances).iter().zip(&chosen) {
        let off = (reference[0] - point[1]).abs().max((reference[1] - point[2]).abs());
        assert!(off < 0.02, "{reference:?} {point:?}");
    }
    // At the start there is a speed to start with, at the end there is none.
    let ends = references(&archive, &profiled, &[0.0, points.last().unwrap()[0]]);
    assert!(ends[0][0] > 0.3 && ends[0][1] > 1.0, "{ends:?}");
    assert!(ends[1][0] < 0.1, "{ends:?}");

    std::fs::write(folder.join("speed.json"), Fmu::SpeedController.example()).unwrap();
    std::fs::write(folder.join("car.json"), Fmu::LongitudinalPlant.example()).unwrap();
    let files = "{chain}/plant.json {chain}/pid.json path.json car.json speed.json";
    let output = done(folder, &format!("package {files} --out all --ssp Drive.ssp --json"));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let package = printed.as_array().unwrap().last().unwrap();
    let connections = package["connections"].to_string();
    for name in ["speed_reference", "acceleration_reference"] {
        let expected = format!("ReferencePath.{name}");
        assert!(connections.contains(&expected), "{connections}");
        assert!(connections.contains(&format!("SpeedController.{name}")), "{connections}");
    }
}
