//! Logs that are rejected, and logs with faults that are corrected.

use super::refused;
use crate::support::{chain, steerwright, text_of, words};
use std::fmt::Write;

const HEADER: &str = "time_s,steering_angle_rad,yaw_rate_radps,speed_mps";

/// A log of 20 s at 100 Hz under a header; `edit` changes the cells of a row.
fn log(header: &str, edit: impl Fn(usize, &mut Vec<String>)) -> String {
    let mut text = format!("{header}\n");
    let mut yaw_rate = 0.0;
    for i in 0..2000 {
        let t = f64::from(i) * 0.01;
        let steering = 0.02 * (2.0 * (1.0 + 0.1 * t) * t).sin();
        yaw_rate += 0.05 * (5.0 * steering - yaw_rate);
        let mut row = vec![
            format!("{t:.2}"),
            format!("{steering:.6}"),
            format!("{yaw_rate:.6}"),
            "15".to_owned(),
        ];
        edit(i as usize, &mut row);
        if !row.is_empty() {
            let _ = writeln!(text, "{}", row.join(","));
        }
    }
    text
}

/// A log with one other cell, in line 502.
fn with_cell(column: usize, cell: &str) -> String {
    log(HEADER, |i, row| {
        if i == 500 {
            row[column] = cell.into();
        }
    })
}

#[test]
fn logs() {
    let good = log(HEADER, |_, _| {});
    let identify = "identify log.csv";
    for (content, says) in [
        ("", &["log.csv: the file is empty"] as &[_]),
        (&format!("{HEADER}\n"), &["log.csv: column `steering_angle_rad` has 0 values"]),
        (&format!("{HEADER}\n0,0,0,15\n"), &["has 1 values"]),
        ("\0\u{1}PK\n", &["log.csv:1: the file is not text"]),
        ("{\"schema\": 1}\n", &["log.csv: this is a JSON document, not a log", "name a log: CSV"]),
        (
            &log("time_s,wheels_rad,yaw_rate_radps,speed_mps", |_, _| {}),
            &["which column is the steering?", "wheels_rad", "--input-channel NAME"],
        ),
        (&with_cell(0, "oops"), &["log.csv:502: column `time_s`: `oops`"]),
        (&with_cell(0, "1e999"), &["log.csv:502: column `time_s`", "finite"]),
        (&with_cell(1, "1e300"), &["log.csv:502:", "1.000e300 rad"]),
        (&with_cell(3, "1e300"), &["log.csv:502:", "the speed would be"]),
        (&with_cell(0, "3.0"), &["log.csv:502: column `time_s`: time 3 s", "4.99 s"]),
        (&with_cell(2, "1,2"), &["log.csv:502: the row has 5 cells", "decimal commas"]),
        (&with_cell(2, "\"1,2\""), &["log.csv:502: column `yaw_rate_radps`: `1,2`", "--decimal"]),
        (&log(HEADER, |_, row| row[1] = "NaN".into()), &["has 0 values"]),
        (
            &log(HEADER, |i, row| {
                // Nothing between the gaps is long enough.
                if i % 100 < 60 {
                    row.clear();
                }
            }),
            &["log.csv:", "a gap of 0.61 s", "is too short", "--max-gap"],
        ),
        (&log(HEADER, |_, row| row[1] = "0.1".into()), &["the steering is 0.1 rad throughout"]),
        (&log(HEADER, |_, row| row[2] = "0".into()), &["the yaw rate is 0 rad/s throughout"]),
        // A steering wheel's degrees and a gyro's, both read as radians.
        (&log(HEADER, |_, row| row[1] += "e3"), &["more than a road wheel can turn", "--unit"]),
        (&log(HEADER, |_, row| row[2] += "e3"), &["rad/s (read as rad/s)", "deg/s would make it"]),
        (
            &log("time_s,steering,yaw_rate,speed", |_, _| {}),
            &["log.csv:1: column `steering`: the unit is not stated", "steering=deg"],
        ),
        (
            &log("time,steer_rad,yaw_rate_radps,v_mps", |_, _| {}),
            &["log.csv:1: column `time`: the unit is not stated", "time=s"],
        ),
        (
            &log("time_s,steering_wheel_rad,yaw_rate_radps,v_mps", |_, _| {}),
            &["log.csv: column `steering_wheel_rad`", "--steering-ratio 15"],
        ),
        (
            &log("time_s,steer_rad,steer_rad,v_mps", |_, _| {}),
            &["log.csv:1: the header names the column `steer_rad` twice"],
        ),
        // Seconds declared as nanoseconds.
        (&good.replace("time_s", "time_ns"), &["check the time column and its unit"]),
    ] {
        refused((&[("log.csv", content)], identify, says));
    }

    let later = log(HEADER, |i, row| row[0] = format!("{}", 1000.0 + i as f64 * 0.01));
    for (line, says) in [
        ("identify missing.csv", &["missing.csv: No such file"] as &[_]),
        ("identify .", &["error: .: "]),
        (
            "identify --drive a.csv,b.csv --input-channel steering_angle_rad",
            &["in more than one file: a.csv, b.csv", "as in a.csv:steering_angle_rad"],
        ),
        (
            "identify a.csv b.csv --input-channel a.csv:steering_angle_rad --output-channel b.csv:yaw_rate_radps",
            &["the clocks do not overlap", "1000 to 1019.99 s"],
        ),
        ("identify a.csv a.csv", &["a.csv is the same recording as a.csv"]),
        (
            "identify a.csv b.csv speed.csv",
            &["a.csv, b.csv have steering and yaw rate each", "--drive a.csv,speed.csv"],
        ),
        ("identify --drive a.csv,", &["'--drive <FILE,FILE…>'", "commas between them"]),
        ("identify", &["<LOG"]),
        (
            "identify a.csv --speed-window 20..30",
            &["within 20.0 to 30.0 m/s for 0.0 s only", "widen the speed window"],
        ),
        ("identify a.csv --speed-window 60..50km/h", &["60 is not below 50km/h"]),
        ("identify a.csv --speed-window fast", &["'--speed-window <FROM..TO>'", "14..16"]),
        ("identify a.csv --speed-window 1e300..2e300", &["beyond any sensible value"]),
        ("identify a.csv --delay -1s", &["delay: -1 s is out of range", "(--delay)"]),
        ("identify a.csv --delay 0.1", &["'--delay <TIME|auto>'", "(ms or s)"]),
        ("identify a.csv --detrend cubic", &["expected mean, linear or none"]),
        ("identify a.csv --input-channel nosuch", &["no column `nosuch`", "a.csv"]),
        ("identify a.csv --input-channel speed_mps", &["a.csv: column `speed_mps` is in m/s"]),
        ("identify a.csv --unit steering_angle_rad=furlong", &["`furlong` is not a known unit"]),
        ("identify a.csv --unit speed_mps=furlong", &["`furlong` is not a known unit"]),
        ("identify a.csv --unit nosuch=deg", &["a unit is stated for `nosuch`"]),
        ("identify a.csv --order 99", &["order: 99 is out of range", "(--order)"]),
        ("identify a.csv --max-order 99", &["max order: 99", "(--max-order)"]),
        ("identify a.csv --horizon 1", &["horizon: 1 is out of range", "2 to 200"]),
        ("identify a.csv --horizon 5 --order 5", &["needs a horizon above it", "--horizon 7"]),
        (
            "identify a.csv --validation-fraction 95%",
            &["validation fraction: 95% is out of range", "10% to 90%"],
        ),
        ("identify a.csv --validation-fraction -5%", &["validation fraction: -5% is out of range"]),
        ("identify a.csv --validation-fraction 0.5", &["'--validation-fraction <SHARE>'", "(%)"]),
        ("identify a.csv --steering-ratio 0", &["steering ratio: 0.0 is out of range"]),
        (
            "identify a.csv --channel roll=speed_mps",
            &["`roll` is not read for the response motion, expected one of lateral_acceleration"],
        ),
        (
            "identify a.csv --steering-full-scale 20deg",
            &["that of a command in 1 or %, and the steering is in rad", "(--steering-full-scale"],
        ),
        ("accumulate a.csv --gnss-latency 0s", &["an R factor holds no fixes", "identify LOG"]),
        ("accumulate a.csv --antenna-x 1m", &["an R factor holds no fixes"]),
        ("accumulate a.csv --window 1s..9s", &["window: not available where logs are read in"]),
        (
            "identify a.csv --structure bicycle --delay 50ms",
            &["--delay is an option of the structure state-space"],
        ),
        ("identify a.csv --structure torque --max-samples 99", &["--max-samples is an option of"]),
        ("identify {chain}/pid.json", &["this is a JSON document, not a log", "name a log: CSV"]),
        ("inspect {chain}/pid.json", &["this is a JSON document, not a log"]),
        ("identify a.csv --window 1s..2s", &["samples of 0.01 s are too few"]),
        ("identify a.csv --window 90s..99s", &["the window covers 90 to 99 s, the log 0 to 19.99"]),
        ("identify a.csv --window 9s..5s", &["9 s is not before 5 s"]),
        ("identify a.csv --sample-time 1ms", &["the log's own 0.01 s", "use 0.01 s or more"]),
        ("identify a.csv --max-gap 1e300s", &["`1e300` is beyond any sensible value"]),
        ("identify a.csv --order 1 -o .", &["error: .: this is a folder"]),
        ("identify a.csv --order 1 -o a.csv/p.json", &["a.csv: this is a file, not a folder"]),
    ] {
        let speed = log("time_s,a_1,b_1,speed_mps", |_, _| {});
        refused((&[("a.csv", &good), ("b.csv", &later), ("speed.csv", &speed)], line, says));
    }
}

/// Faults that are corrected and reported.
#[test]
fn logs_with_faults_that_are_corrected() {
    let gap = |i: usize, row: &mut Vec<String>| {
        if (900..1000).contains(&i) {
            row.clear();
        }
    };
    let wild = |i: usize, row: &mut Vec<String>| {
        if i == 1999 {
            row[0] = "1e300".into();
        }
    };
    let later = |i: usize, row: &mut Vec<String>| row[0] = format!("{}", 1000 + 10 * i);
    let other = log(HEADER, later).replace("time_s", "t_ms");
    for (first, arguments, says) in [
        (log(HEADER, gap), "", &["a.csv:902:", "nothing from 8.99 s to 10 s: the drive is split"]),
        (with_cell(1, "oops"), "", &["a.csv:502: column `steering_angle_rad`: `oops`", "1 cell"]),
        (log(HEADER, wild), "", &["a.csv:2001:", "to 1.000e300 s"]),
        (log(HEADER, |_, _| {}), "other.csv", &["a.csv:steering_angle", "other.csv:"]),
        (log(HEADER, |_, _| {}), "--speed-window 50..60km/h", &["13.9 to 16.7 m/s", "1 s"]),
        (
            log(HEADER, |_, _| {}),
            "--window 1s..8s --window 9s..19s --detrend linear",
            &["model", ""],
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.csv"), first).unwrap();
        std::fs::write(folder.path().join("other.csv"), &other).unwrap();
        let line = format!("identify a.csv {arguments} --order 1 --horizon 10");
        let output = steerwright(folder.path(), &words(&line, chain()));
        let text = text_of(&output);
        assert_eq!(output.status.code(), Some(0), "{line}: {text}");
        for part in says {
            assert!(text.contains(part), "{line}: no `{part}` in: {text}");
        }
        let plant = std::fs::read_to_string(folder.path().join("plant.json")).unwrap();
        assert!(plant.contains("\"input_delay_s\": 0"), "{line}");
    }
}

/// The speed of a drive over time, m/s, and whether its model may fail validation.
fn drive_of_speed(speed: impl Fn(f64) -> f64) -> String {
    let mut text = format!("{HEADER}\n");
    for i in 0..6000 {
        let t = f64::from(i) * 0.01;
        let steering = 0.15 * (1.3 * t).sin() + 0.1 * (4.1 * t).sin();
        let v = speed(t);
        let _ = writeln!(text, "{t:.2},{steering:.6},{:.6},{v:.4}", v * steering / 0.5);
    }
    text
}

#[test]
fn drives_without_a_fast_part_end_with_a_model_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("rows", format!("{HEADER}\n")),
        ("row", format!("{HEADER}\n0,0.01,0.02,15\n")),
        ("slow", drive_of_speed(|t| 1.25 + 1.25 * (0.4 * t).sin())),
        ("slowest", drive_of_speed(|t| 0.2 + 0.1 * (0.4 * t).sin())),
        ("standing", drive_of_speed(|_| 0.0)),
        ("reversing", drive_of_speed(|_| -1.8)),
        ("short", drive_of_speed(|t| if t > 59.0 { 15.0 } else { 0.1 })),
    ] {
        let log = format!("{name}.csv");
        std::fs::write(folder.path().join(&log), text).unwrap();
        for command in [
            format!("identify {log} --steering-ratio 1 -o {name}.json"),
            format!("identify {log} --steering-ratio 1 --structure bicycle -o {name}-bicycle.json"),
            format!(
                "identify {log} --steering-ratio 1 --structure single-track -o {name}-vehicle.json"
            ),
            format!("build {log} --steering-ratio 1 --max-rate 0.4rad/s --out {name}"),
        ] {
            let output = steerwright(folder.path(), &words(&command, folder.path()));
            let text = text_of(&output);
            let status = output.status.code();
            assert!(matches!(status, Some(0..=2)), "{command}: {status:?} {text}");
            assert!(
                !text.contains("panicked") && !text.contains("internal fault"),
                "{command}: {text}"
            );
            assert!(status != Some(2) || text.contains("hint:"), "{command}: {text}");
        }
    }
    assert!(folder.path().join("slow.json").exists());
}
