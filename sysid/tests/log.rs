//! Logs as they are found: several files and clocks, units, and every kind of bad input, each of
//! which must be refused with its place and a hint, or mended with a warning.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::f64::consts::PI;
use sysid::{DriveLog, Error, LogOptions, read_log};

/// A CSV text with a row for each 10 ms made by `row`.
fn csv(header: &str, rows: usize, row: impl Fn(usize) -> String) -> Vec<u8> {
    let mut text = format!("{header}\n");
    for k in 0..rows {
        text += &row(k);
        text.push('\n');
    }
    text.into_bytes()
}

fn steer(t: f64) -> f64 {
    0.05 * (2.0 * PI * 0.5 * t).sin()
}

fn rate(t: f64) -> f64 {
    0.2 * (2.0 * PI * 0.5 * t - 0.3).sin()
}

const HEADER: &str = "time_s,steer_rad,yaw_rate_radps,speed_mps";

fn good_row(k: usize) -> String {
    let t = k as f64 * 0.01;
    format!("{t:.2},{:.9},{:.9},15.0", steer(t), rate(t))
}

fn good() -> Vec<u8> {
    csv(HEADER, 1000, good_row)
}

fn read_one(bytes: Vec<u8>, options: &LogOptions) -> Result<DriveLog, Error> {
    read_log(&[("drive.csv".to_owned(), bytes)], options)
}

/// Every error has a message that names the place and a hint.
fn refused(bytes: Vec<u8>, options: &LogOptions) -> Error {
    let error = read_one(bytes, options).unwrap_err();
    assert!(!error.hint().is_empty() && !error.to_string().is_empty(), "{error:?}");
    println!("{error}\n  hint: {}", error.hint());
    error
}

fn with_line(line: usize, text: &str) -> Vec<u8> {
    csv(HEADER, 1000, |k| if k + 2 == line { text.to_owned() } else { good_row(k) })
}

fn units(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
    pairs.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect()
}

#[test]
fn a_clean_log_is_read_and_resampled() {
    let log = read_one(good(), &LogOptions::default()).unwrap();
    assert_eq!(log.sample_time_s, 0.04);
    assert_eq!(log.name, "drive");
    for (k, y) in log.output.iter().enumerate() {
        let t = log.segments[0].time0_s + 0.04 * k as f64;
        assert!((y - rate(t)).abs() < 1e-4, "{t}: {y} {}", rate(t));
    }
    assert!(log.speed.unwrap().iter().all(|v| (v - 15.0).abs() < 1e-9));
    let summary = &log.channels[1];
    assert_eq!((summary.role.as_str(), summary.rows), ("yaw_rate", 1000));
    assert!((summary.rate_hz - 100.0).abs() < 0.01);
    // At the log's own rate nothing is touched.
    let options = LogOptions { sample_time_s: Some(0.01), ..LogOptions::default() };
    let log = read_one(good(), &options).unwrap();
    assert_eq!(log.len(), 1000);
    assert!((0..1000).all(|k| (log.input[k] - steer(k as f64 * 0.01)).abs() < 2e-9));
}

#[test]
fn spellings_of_a_file_do_not_matter() {
    let plain = read_one(good(), &LogOptions::default()).unwrap();
    let text = String::from_utf8(good()).unwrap();
    let variants = [
        format!("\u{feff}{text}"),
        text.replace('\n', "\r\n"),
        format!("{text}\n\n  \n"),
        text.replace(',', ";"),
        text.replace(',', "\t"),
        text.replacen(HEADER, "\"time_s\",\"steer_rad\",\"yaw_rate_radps\", speed_mps", 1),
        text.replacen(HEADER, "time [s],steer [rad],yaw_rate (rad/s),speed [m/s]", 1),
    ];
    for (i, variant) in variants.into_iter().enumerate() {
        let log = read_one(variant.into_bytes(), &LogOptions::default()).unwrap();
        assert_eq!((&log.input, &log.output), (&plain.input, &plain.output), "variant {i}");
    }
}

#[test]
fn units_and_signs_are_converted() {
    let bytes = csv("t_ms,steer_deg,gyro_down_deg_s,v_kmh", 1000, |k| {
        let t = k as f64 * 0.01;
        let (s, r) = (steer(t).to_degrees(), -rate(t).to_degrees());
        format!("{},{s:.9},{r:.9},54.0", 10 * k)
    });
    let options = LogOptions {
        output: Some("-gyro_down_deg_s".into()),
        speed: Some("v_kmh".into()),
        ..LogOptions::default()
    };
    let log = read_one(bytes.clone(), &options).unwrap();
    let plain = read_one(good(), &LogOptions::default()).unwrap();
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-7);
    assert!(close(&log.input, &plain.input) && close(&log.output, &plain.output));
    assert!((log.speed.unwrap()[0] - 15.0).abs() < 1e-9);
    // A stated unit goes before the name's.
    let stated = LogOptions { units: units(&[("steer_deg", "rad")]), ..options };
    let log = read_one(bytes, &stated);
    assert!(matches!(log, Err(Error::NotARoadWheel { .. })), "2.9 rad is no road wheel's angle");
}

#[test]
fn yaw_is_differenced_where_there_is_no_yaw_rate() {
    let bytes = csv("time_s,steer_rad,heading_deg", 1000, |k| {
        let t = k as f64 * 0.01;
        // Turns through the wrap at ±180°.
        let yaw = 170.0 + (-0.2 / PI * (PI * t - 0.3).cos()).to_degrees() + 5.0 * t;
        format!("{t:.2},{:.9},{:.9}", steer(t), (yaw + 180.0).rem_euclid(360.0) - 180.0)
    });
    let options = LogOptions { output: Some("heading_deg".into()), ..LogOptions::default() };
    let log = read_one(bytes, &options).unwrap();
    assert!(log.warnings.iter().any(|w| w.contains("differenced")), "{:?}", log.warnings);
    for (k, y) in log.output.iter().enumerate() {
        let t = log.segments[0].time0_s + 0.04 * k as f64;
        assert!((y - rate(t) - 5.0_f64.to_radians()).abs() < 1e-3, "{t}: {y}");
    }
}

#[test]
fn files_with_clocks_of_their_own_are_merged() {
    let a = csv("time_s,steer_rad", 830, |k| {
        let t = 0.3 + k as f64 * 0.012 + 0.002 * (k as f64 * 1.7).sin();
        format!("{t:.6},{:.9}", steer(t))
    });
    let b = csv("time_s,yaw_rate_radps", 1040, |k| {
        let t = k as f64 * 0.0096;
        format!("{t:.6},{:.9}", rate(t))
    });
    let files = vec![("a.csv".to_owned(), a), ("b.csv".to_owned(), b)];
    let log = read_log(&files, &LogOptions::default()).unwrap();
    assert!(log.segments[0].time0_s >= 0.3);
    for (k, y) in log.output.iter().enumerate() {
        assert!((y - rate(log.segments[0].time0_s + 0.04 * k as f64)).abs() < 5e-4);
    }
    // The input is held: its sample stands for the middle of its interval.
    for (k, u) in log.input.iter().enumerate() {
        let middle = log.segments[0].time0_s + 0.04 * k as f64 + 0.5 * (0.04 - 0.012);
        assert!((u - steer(middle)).abs() < 5e-4);
    }
    let same = vec![files[0].clone(), ("c.csv".to_owned(), files[0].1.clone()), files[1].clone()];
    let options = LogOptions { input: Some("steer_rad".into()), ..LogOptions::default() };
    let error = read_log(&same, &options).unwrap_err();
    assert!(matches!(&error, Error::AmbiguousColumn { files, .. } if files == "a.csv, c.csv"));
    let told = LogOptions { input: Some("a.csv:steer_rad".into()), ..LogOptions::default() };
    assert_eq!(read_log(&same, &told).unwrap().input, log.input);
    let late = csv("time_s,yaw_rate_radps", 500, |k| format!("{},{}", 100.0 + k as f64, k));
    let error = read_log(&[files[0].clone(), ("late.csv".into(), late)], &LogOptions::default());
    assert!(matches!(error, Err(Error::Impossible { .. } | Error::NoOverlap { .. })));
    let late = csv("time_s,yaw_rate_radps", 500, |k| {
        format!("{},{}", 100.0 + 0.01 * k as f64, rate(k as f64))
    });
    let error = read_log(&[files[0].clone(), ("late.csv".into(), late)], &LogOptions::default());
    assert!(matches!(error, Err(Error::NoOverlap { .. })), "{error:?}");
}

#[test]
fn bad_files_are_refused_with_their_place() {
    let o = LogOptions::default();
    for empty in ["", "\n\n", "  ", "\u{feff}"] {
        assert!(matches!(refused(empty.as_bytes().to_vec(), &o), Error::EmptyFile { .. }));
    }
    let header_only = format!("{HEADER}\n").into_bytes();
    assert!(matches!(refused(header_only, &o), Error::TooFewRows { .. }));
    assert!(matches!(refused(b"\xff\xfe\x00".to_vec(), &o), Error::NotText { line: 1, .. }));
    let e = refused(with_line(5, "0.03,abc,0.1,15"), &o);
    assert!(
        matches!(e, Error::NotANumber { ref at, .. } if at.line == 5 && at.column == "steer_rad")
    );
    let e = refused(with_line(6, "0.04,0.01,inf,15"), &o);
    assert!(
        matches!(e, Error::NotFinite { ref at, .. } if at.line == 6 && at.column == "yaw_rate_radps")
    );
    assert!(matches!(
        refused(with_line(7, "0.05,0.01,0.1"), &o),
        Error::RaggedRow { line: 7, got: 3, expected: 4, .. }
    ));
    let back = refused(with_line(8, "0.02,0.01,0.1,15"), &o);
    assert!(matches!(back, Error::TimeNotIncreasing { ref at, .. } if at.line == 8));
    let repeated = refused(with_line(9, "0.06,0.01,0.1,15"), &o);
    assert!(matches!(repeated, Error::TimeNotIncreasing { ref at, .. } if at.line == 9));
    let twice = refused(csv("time_s,a_rad,a_rad", 5, |_| "1,2,3".into()), &o);
    assert!(matches!(twice, Error::RepeatedColumn { line: 1, .. }));
    let unclosed = [HEADER, "\n0,\"0.1,0.2,15\n0.01,0.1,0.2,15\n"].concat().into_bytes();
    refused(unclosed, &o);
    assert!(matches!(read_log(&[], &o), Err(Error::NoFiles)));
}

#[test]
fn wrong_mappings_are_refused() {
    let o = LogOptions::default();
    let named = |input: &str| LogOptions { input: Some(input.into()), ..o.clone() };
    let e = refused(good(), &named("sterring"));
    assert!(
        matches!(e, Error::MissingColumn { ref available, .. } if available.contains("steer_rad"))
    );
    let e = refused(good(), &named("speed_mps"));
    assert!(matches!(e, Error::WrongQuantity { .. }));
    let text = String::from_utf8(good()).unwrap();
    let bare = text.replacen("steer_rad", "steer", 1).into_bytes();
    assert!(
        matches!(refused(bare.clone(), &named("steer")), Error::UnitNotStated { ref at } if at.line == 1)
    );
    let stated = LogOptions { units: units(&[("steer", "rad")]), ..named("steer") };
    assert!(read_one(bare.clone(), &stated).is_ok());
    let wrong = LogOptions { units: units(&[("steer", "turns")]), ..named("steer") };
    assert!(matches!(refused(bare.clone(), &wrong), Error::UnknownUnit { .. }));
    let unused = LogOptions { units: units(&[("stear", "rad")]), ..named("steer") };
    assert!(matches!(refused(bare, &unused), Error::UnusedUnit { .. }));
    let clockless = text.replacen("time_s", "stamp", 1).into_bytes();
    assert!(matches!(refused(clockless.clone(), &o), Error::NoTime { .. }));
    let period = LogOptions { row_period_s: Some(0.01), ..o.clone() };
    let (one, two) = (read_one(clockless, &period).unwrap(), read_one(good(), &o).unwrap());
    assert!(one.output.iter().zip(&two.output).all(|(a, b)| (a - b).abs() < 1e-12));
    let wheel = text.replacen("steer_rad", "steering_wheel_rad", 1).into_bytes();
    assert!(matches!(refused(wheel, &o), Error::SteeringRatioUnknown { .. }));
    let e = refused(with_line(5, "0.03,41,0.1,15"), &o);
    assert!(
        matches!(e, Error::Impossible { ref at, .. } if at.line == 5) && e.hint().contains("deg"),
        "{e:?}"
    );
    let e = refused(with_line(5, "0.03,0.01,12,15"), &o);
    assert!(
        matches!(e, Error::Impossible { ref at, .. } if at.line == 5) && e.hint().contains("deg/s")
    );
    let e = refused(with_line(5, "0.03,0.01,0.1,200"), &o);
    assert!(
        matches!(e, Error::Impossible { ref at, .. } if at.line == 5) && e.hint().contains("km/h")
    );
    assert!(matches!(refused(with_line(5, "0.03,0.01,0.1,-9"), &o), Error::Impossible { .. }));
    let still = csv(HEADER, 500, |k| format!("{},0.1,{},15", k as f64 * 0.01, k % 3));
    assert!(matches!(refused(still, &o), Error::Constant { role: "steering", .. }));
    for bad in [
        LogOptions { steering_ratio: Some(0.0), ..o.clone() },
        LogOptions { sample_time_s: Some(f64::NAN), ..o.clone() },
        LogOptions { max_gap_s: -1.0, ..o.clone() },
        LogOptions { window: Some((5.0, 2.0)), ..o.clone() },
    ] {
        assert!(matches!(refused(good(), &bad), Error::Option { .. }));
    }
    let fast = LogOptions { sample_time_s: Some(0.001), ..o.clone() };
    assert!(matches!(refused(good(), &fast), Error::SampleTimeTooShort { .. }));
    let slow = LogOptions { sample_time_s: Some(5.0), ..o };
    assert!(matches!(refused(good(), &slow), Error::TooFewSamples { .. }));
}

#[test]
fn a_road_wheel_that_is_none_is_named_with_file_and_line() {
    let o = LogOptions::default();
    let text = String::from_utf8(good()).unwrap();
    // Under a blank line, so that the header is on line 2.
    let wheel =
        text.replacen(HEADER, &format!("\n{}", HEADER.replace("steer", "steering_wheel")), 1);
    let e = refused(wheel.into_bytes(), &o).to_string();
    assert!(e.starts_with("drive.csv: column `steering_wheel_rad`"), "{e}");
    // The largest angle, not the first that is too large.
    let rows = |k: usize| match k {
        40 => "0.40,-0.9,0.1,15".into(),
        50 => "0.50,-1.5,0.1,15".into(),
        _ => good_row(k),
    };
    let e = refused(csv(HEADER, 1000, rows), &o).to_string();
    assert!(e.starts_with("drive.csv:52: column `steer_rad`: 86°"), "{e}");
}

#[test]
fn a_speed_that_says_standstill_is_refused() {
    let at = |speed: &str, options: &LogOptions| {
        let speed = speed.to_owned();
        let row = |k: usize| good_row(k).replace(",15.0", &format!(",{speed}"));
        read_one(csv(HEADER, 1000, row), options)
    };
    let o = LogOptions::default();
    for speed in ["0", "0.0", "0.3", "-0.2"] {
        let e = at(speed, &o).unwrap_err();
        assert!(matches!(e, Error::Standstill { .. }), "{speed}: {e:?}");
        assert!(e.to_string().starts_with("drive.csv: column `speed_mps`"), "{e}");
        assert!(e.hint().contains("--speed"), "{}", e.hint());
    }
    // A constant speed is what a test drive aims at.
    assert!(at("5.0", &o).is_ok());
    // The part that is used decides.
    let starts = |k: usize| good_row(k).replace(",15.0", if k < 600 { ",0.1" } else { ",1.2" });
    let starts = csv(HEADER, 1000, starts);
    assert!(read_one(starts.clone(), &o).is_ok());
    let options = |from, to| LogOptions {
        window: Some((from, to)),
        sample_time_s: Some(0.01),
        ..LogOptions::default()
    };
    assert!(matches!(read_one(starts.clone(), &options(0.0, 5.0)), Err(Error::Standstill { .. })));
    assert!(read_one(starts, &options(6.0, 9.0)).is_ok());
}

#[test]
fn short_gaps_are_bridged_with_a_warning_and_long_ones_refused() {
    let o = LogOptions::default();
    let clean = read_one(good(), &o).unwrap();
    // Blank, NaN and missing cells of the yaw rate on lines 302 to 305.
    let blanks = csv(HEADER, 1000, |k| {
        let cell = ["", "NaN", " ", "nan"];
        match k.checked_sub(300) {
            Some(i) if i < 4 => {
                format!("{:.2},{:.9},{},15.0", k as f64 * 0.01, steer(k as f64 * 0.01), cell[i])
            }
            _ => good_row(k),
        }
    });
    let log = read_one(blanks, &o).unwrap();
    let warning = log.warnings.iter().find(|w| w.contains("yaw_rate_radps")).unwrap();
    assert!(warning.contains("4 samples") && warning.contains("302-305"), "{warning}");
    assert!(log.output.iter().zip(&clean.output).all(|(a, b)| (a - b).abs() < 2e-3));
    // Rows missing altogether: 0.2 s bridged, 3 s refused with the longest whole part.
    let holed = |from: usize, to: usize| {
        let text = String::from_utf8(good()).unwrap();
        let kept: Vec<&str> = text
            .lines()
            .enumerate()
            .filter(|(i, _)| !(from..to).contains(i))
            .map(|(_, l)| l)
            .collect();
        kept.join("\n").into_bytes()
    };
    let log = read_one(holed(400, 420), &o).unwrap();
    assert!(
        log.warnings.iter().any(|w| w.contains("bridged") && w.contains("line 401")),
        "{:?}",
        log.warnings
    );
    let e = refused(holed(200, 500), &o);
    let Error::Gap { at, gap_s, longest, .. } = e.clone() else { panic!("{e:?}") };
    assert_eq!((at.line, gap_s), (201, 3.01));
    assert!((longest.0 - 4.99).abs() < 1e-9 && (9.9..=9.99).contains(&longest.1), "{longest:?}");
    // As the command line takes it.
    assert!(e.hint().contains(&format!("--window 4.99s..{}s;", longest.1)), "{}", e.hint());
    let window = LogOptions { window: Some(longest), ..o.clone() };
    let part = read_one(holed(200, 500), &window).unwrap();
    assert!(part.segments[0].time0_s >= 4.99);
    let wide = LogOptions { max_gap_s: 5.0, ..o };
    assert!(read_one(holed(200, 500), &wide).is_ok());
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(mut bytes: Vec<u8>, at in 0_usize..3000, header: bool) {
        let o = LogOptions { units: units(&[]), ..LogOptions::default() };
        if header {
            let mut text = good();
            let at = at.min(text.len());
            text.splice(at..at, bytes);
            bytes = text;
        }
        if let Err(error) = read_one(bytes, &o) {
            proptest::prop_assert!(!error.hint().is_empty());
        }
    }
}
