//! `steerwright inspect`, and mapping files, as a person uses them.

use crate::support::{done, read_json, run, text_of};
use serde_json::Value;

#[test]
fn channels_of_a_recorded_drive_are_listed_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let output =
        done(folder.path(), "inspect {data}/multibody/drive.csv --plot channels.html --json");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let group = &found["groups"][0];
    assert_eq!((&group["rows"], &group["rate_hz"]), (&10_300.into(), &100.0.into()));
    let candidates: Vec<(&str, &str)> = group["channels"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|c| c["candidate_for"].as_array().unwrap().iter().map(|r| (&c["name"], r)))
        .map(|(name, role)| (name.as_str().unwrap(), role.as_str().unwrap()))
        .collect();
    let expected = [
        ("steering_command_rad", "steering"),
        ("steering_angle_rad", "steering"),
        ("yaw_rate_radps", "yaw rate"),
        ("speed_mps", "speed"),
        ("lateral_acceleration_mps2", "lateral acceleration"),
    ];
    assert_eq!(candidates, expected);
    let page = std::fs::read_to_string(folder.path().join("channels.html")).unwrap();
    assert_eq!(page.matches("<figure").count(), expected.len());
    let text =
        text_of(&run(folder.path(), "inspect {data}/multibody/drive.csv --channel speed_mps"));
    assert!(text.contains("speed_mps") && !text.contains("yaw_rate"), "{text}");
    let refused = run(folder.path(), "inspect {data}/multibody/drive.csv --channel speed");
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn gaps_texts_and_damage_are_reported_and_the_rest_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let row = |k: usize| format!("{:.2},manual,{}\n", k as f64 * 0.01, k % 7);
    let rows: String = (0..300).chain(400..900).map(row).collect();
    let log = format!("time_s,mode,steer_deg\n{rows}9.00,manual,x7\n");
    std::fs::write(folder.path().join("log.csv"), log).unwrap();
    let output = run(folder.path(), "inspect log.csv");
    let text = text_of(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("1 gap, the longest 1.010 s at 2.990 s"), "{text}");
    assert!(text.contains("text"), "{text}");
    assert!(
        text.contains("warning: log.csv:802: column `steer_deg`: `x7` is not a number"),
        "{text}"
    );
}

#[test]
fn a_mapping_file_replaces_the_options() {
    let folder = tempfile::tempdir().unwrap();
    let mapping = "yaw_rate = \"yaw_rate_radps\"\n[vehicle.car]\nsteering = \"steering_command_rad\"\n\
                   steering_ratio = 1\n[vehicle.other]\nsteering = \"nothing\"\n";
    std::fs::write(folder.path().join("mapping.toml"), mapping).unwrap();
    let line = "identify {data}/multibody/drive.csv --order 2 --horizon 10";
    done(
        folder.path(),
        &format!("{line} --mapping mapping.toml --mapping-vehicle car -o mapped.json"),
    );
    done(
        folder.path(),
        &format!(
            "{line} --input-channel steering_command_rad --output-channel yaw_rate_radps --steering-ratio 1 -o stated.json"
        ),
    );
    let read = |name: &str| read_json(&folder.path().join(name));
    assert_eq!(read("mapped.json"), read("stated.json"));
    let several = run(folder.path(), &format!("{line} --mapping mapping.toml"));
    assert_eq!(several.status.code(), Some(2));
    assert!(text_of(&several).contains("which vehicle? There are: car, other"));
}

#[test]
fn an_expression_of_channels_is_a_channel() {
    let folder = tempfile::tempdir().unwrap();
    let line = "identify {data}/multibody/drive.csv --order 2 --horizon 10 --steering-ratio 1";
    let sum = "2 * steering_command_rad - steering_command_rad";
    let arguments = |channel: &str, out: &str| {
        let mut all = crate::support::words(line, std::path::Path::new(""));
        all.extend(["--input-channel", channel, "-o", out].map(String::from));
        crate::support::steerwright(folder.path(), &all)
    };
    assert!(arguments(sum, "sum.json").status.success());
    assert!(arguments("steering_command_rad", "one.json").status.success());
    let read = |name: &str| read_json(&folder.path().join(name));
    assert_eq!(read("sum.json")["discrete"], read("one.json")["discrete"]);
}

#[test]
fn a_log_without_a_row_or_a_number_ends_with_status_2() {
    let folder = tempfile::tempdir().unwrap();
    for (text, reason) in [
        ("time_s,steer_deg\n", "no row was read"),
        ("time_s,steer_deg\n,\n", "no row was read"),
        ("name,colour\na,red\nb,blue\n", "no numeric channel was read"),
    ] {
        std::fs::write(folder.path().join("log.csv"), text).unwrap();
        let output = run(folder.path(), "inspect log.csv");
        let printed = text_of(&output);
        assert_eq!(output.status.code(), Some(2), "{printed}");
        assert!(printed.contains(&format!("error: log.csv: {reason}")), "{printed}");
    }
}

#[test]
fn a_name_of_a_channel_stands_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let names = [
        "/localization/acceleration/lateral_acceleration",
        "/vehicle/status/steering_status/steering_tire_angle",
    ];
    let rows: String = (0..100).map(|k| format!("{:.2},0.{k},1\n", 0.01 * f64::from(k))).collect();
    let log = format!("time_s,{} [m/s2],{} [rad]\n{rows}", names[0], names[1]);
    std::fs::write(folder.path().join("log.csv"), log).unwrap();
    let text = text_of(&run(folder.path(), "inspect log.csv"));
    assert!(names.iter().all(|name| text.contains(name)), "{text}");
}

#[test]
fn the_folder_of_a_ros_2_bag_is_a_log() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("bag");
    std::fs::create_dir(&bag).unwrap();
    let recorded =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzzing/corpus/logs/lz4.mcap");
    let inspected = |log: &str| text_of(&run(folder.path(), &format!("inspect {log}")));
    let refused = |part: &str| {
        let text = inspected("bag");
        assert!(text.contains(part), "{text}");
    };
    refused("bag");
    std::fs::write(bag.join("metadata.yaml"), "rosbag2_bagfile_information:\n").unwrap();
    refused("the folder has a metadata.yaml and no MCAP file");
    std::fs::copy(&recorded, bag.join("a_0.mcap")).unwrap();
    let text = inspected("bag");
    assert!(text.contains("rows at"), "{text}");
    assert_eq!(text, inspected("bag/a_0.mcap"));
    std::fs::copy(&recorded, bag.join("a_1.mcap")).unwrap();
    refused("a bag of 2 files");
    refused("such as bag/a_0.mcap");
    std::fs::write(bag.join("a_2.db3"), "").unwrap();
    refused("a_2.db3: a ROS 2 bag in SQLite (.db3), which is not read here");
}

#[test]
fn a_table_shows_the_start_of_a_very_long_name() {
    let folder = tempfile::tempdir().unwrap();
    let name = "abcde".repeat(40_000);
    let rows: String = (0..50).map(|k| format!("{}.{:02},{k}\n", k / 100, k % 100)).collect();
    std::fs::write(folder.path().join("log.csv"), format!("time_s,{name}\n{rows}")).unwrap();
    let text = text_of(&run(folder.path(), "inspect log.csv"));
    assert!(text.contains(&format!("{}…", &name[..200])) && text.len() < 10_000, "{}", text.len());
    let output = done(folder.path(), "inspect log.csv --json");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["groups"][0]["channels"][1]["name"], name);
}
