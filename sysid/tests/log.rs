//! Logs as they are found: several files and clocks, units, and every kind of bad input, each of
//! which must be refused with its place and a hint, or mended with a warning.
#![allow(clippy::unwrap_used, clippy::panic, clippy::single_range_in_vec_init)]

use std::collections::BTreeMap;
use std::f64::consts::PI;
use sysid::{DriveLog, Error, LogFile, LogOptions, read_drives, read_log};

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
        LogOptions { windows: vec![(5.0, 2.0)], ..o.clone() },
        LogOptions { windows: vec![(0.0, 3.0), (f64::NAN, 2.0)], ..o.clone() },
        LogOptions { speed_window: Some((16.0, 14.0)), ..o.clone() },
        LogOptions { speed_window: Some((14.0, f64::INFINITY)), ..o.clone() },
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
        windows: vec![(from, to)],
        sample_time_s: Some(0.01),
        ..LogOptions::default()
    };
    assert!(matches!(read_one(starts.clone(), &options(0.0, 5.0)), Err(Error::Standstill { .. })));
    assert!(read_one(starts, &options(6.0, 9.0)).is_ok());
}

/// The text without some of its lines; the header is line 0.
fn holed(text: &[u8], holes: &[std::ops::Range<usize>]) -> Vec<u8> {
    let text = std::str::from_utf8(text).unwrap();
    let kept = text.lines().enumerate().filter(|(i, _)| !holes.iter().any(|h| h.contains(i)));
    kept.map(|(_, line)| line).collect::<Vec<_>>().join("\n").into_bytes()
}

fn warning<'a>(log: &'a DriveLog, part: &str) -> &'a str {
    let found = log.warnings.iter().find(|w| w.contains(part));
    found.unwrap_or_else(|| panic!("no `{part}` in {:?}", log.warnings))
}

/// Every sample is where and what it is in the drive without gaps, and the stretches are all samples.
fn is_part_of(log: &DriveLog, tolerance: f64) {
    let mut next = 0;
    for stretch in &log.segments {
        assert_eq!(stretch.range.start, next);
        next = stretch.range.end;
    }
    assert_eq!((next, log.input.len()), (log.len(), log.len()));
    for (t, y) in log.time_s().into_iter().zip(&log.output) {
        assert!((y - rate(t)).abs() < tolerance, "{t}: {y} {}", rate(t));
    }
}

#[test]
fn short_gaps_are_bridged_and_long_ones_split_the_drive() {
    let o = LogOptions::default();
    // Blank, NaN and missing cells of the yaw rate on lines 302 to 305.
    let blanks = |from: usize, to: usize| {
        csv(HEADER, 1000, |k| {
            let t = k as f64 * 0.01;
            let cell = ["", "NaN", " ", "nan"][k % 4];
            if (from..to).contains(&k) {
                format!("{t:.2},{:.9},{cell},15.0", steer(t))
            } else {
                good_row(k)
            }
        })
    };
    let log = read_one(blanks(300, 304), &o).unwrap();
    let told = warning(&log, "yaw_rate_radps");
    assert!(told.contains("4 samples") && told.contains("302-305"), "{told}");
    assert_eq!(log.segments.len(), 1);
    is_part_of(&log, 2e-3);
    // Blank for a second: two stretches, and the steering that is there is not used between them.
    let log = read_one(blanks(400, 500), &o).unwrap();
    let told = warning(&log, "split");
    assert!(told.starts_with("drive.csv:502: column `yaw_rate_radps`"), "{told}");
    assert!(told.contains("nothing from 3.99 s to 5 s"), "{told}");
    assert_eq!(log.segments.len(), 2);
    is_part_of(&log, 1e-4);
    // Rows missing altogether: 0.2 s bridged, 1 s not.
    let log = read_one(holed(&good(), &[400..420]), &o).unwrap();
    assert!(warning(&log, "bridged").contains("line 401"));
    assert_eq!(log.segments.len(), 1);
    let log = read_one(holed(&good(), &[400..500]), &o).unwrap();
    let told: Vec<&String> = log.warnings.iter().filter(|w| w.contains("split")).collect();
    // Once for the file, though three columns have the gap.
    assert!(told.len() == 1 && told[0].starts_with("drive.csv:401:"), "{told:?}");
    assert_eq!(log.segments.len(), 2);
    // The anti-alias filter takes 0.36 s at either end of each stretch.
    let ends: Vec<(f64, f64)> = log
        .segments
        .iter()
        .map(|s| (s.time0_s, s.time0_s + 0.04 * (s.range.len() - 1) as f64))
        .collect();
    assert!(ends[0].1 <= 3.98 - 0.35 && ends[1].0 >= 4.99 + 0.35, "{ends:?}");
    is_part_of(&log, 1e-4);
    let wide = LogOptions { max_gap_s: 5.0, ..o.clone() };
    assert_eq!(read_one(holed(&good(), &[200..500]), &wide).unwrap().segments.len(), 1);
    // At the log's own rate there is no filter, and no sample is lost.
    let own = LogOptions { sample_time_s: Some(0.01), ..o.clone() };
    let log = read_one(holed(&good(), &[301..601]), &own).unwrap();
    assert_eq!(
        log.segments.iter().map(|s| s.range.clone()).collect::<Vec<_>>(),
        [0..300, 300..700]
    );
    is_part_of(&log, 1e-8);
    // A piece too short is left out and told.
    let log = read_one(holed(&good(), &[100..200, 300..400]), &o).unwrap();
    assert_eq!(log.segments.len(), 1);
    assert!(warning(&log, "left out").contains("2 stretches"));
    // One wild instant at the end costs itself alone.
    let wild = with_line(1001, "1e300,0.01,0.1,15");
    let log = read_one(wild, &o).unwrap();
    assert!(warning(&log, "split").contains("1.000e300"), "{:?}", log.warnings);
    is_part_of(&log, 1e-4);
}

#[test]
fn gaps_that_leave_nothing_are_refused_with_the_longest_whole_part() {
    let holes: Vec<_> = (0..9).map(|i| 60 + 110 * i..130 + 110 * i).collect();
    let e = refused(holed(&good(), &holes), &LogOptions::default());
    let Error::Gap { at, gap_s, longest, .. } = e.clone() else { panic!("{e:?}") };
    assert!(at.line > 1 && (gap_s - 0.71).abs() < 1e-9, "{e}");
    assert!((longest.1 - longest.0 - 0.59).abs() < 0.03, "{longest:?}");
    assert!(e.hint().contains("--max-gap"), "{}", e.hint());
}

#[test]
fn yaw_over_a_gap_is_no_yaw_rate() {
    let all = csv("time_s,steer_rad,heading_deg", 1000, |k| {
        let t = k as f64 * 0.01;
        format!("{t:.2},{:.9},{:.9}", steer(t), (-0.2 / PI * (PI * t - 0.3).cos()).to_degrees())
    });
    let options = LogOptions { output: Some("heading_deg".into()), ..LogOptions::default() };
    // 0.8 s: its middle is within the bridged length of either end.
    let log = read_one(holed(&all, &[451..531]), &options).unwrap();
    assert_eq!(log.segments.len(), 2);
    is_part_of(&log, 1e-3);
}

#[test]
fn windows_may_be_several() {
    let windows = |w: &[(f64, f64)]| LogOptions { windows: w.to_vec(), ..LogOptions::default() };
    let log = read_one(good(), &windows(&[(6.0, 9.5), (0.5, 4.0)])).unwrap();
    assert_eq!(log.segments.len(), 2);
    assert!(log.segments[0].time0_s >= 0.5 && log.segments[1].time0_s >= 6.0);
    assert!(log.time_s().iter().all(|t| (0.5..=4.0).contains(t) || (6.0..=9.5).contains(t)));
    is_part_of(&log, 1e-4);
    // Windows that meet are one.
    let log = read_one(good(), &windows(&[(1.0, 5.0), (5.0, 9.0)])).unwrap();
    assert_eq!(log.segments.len(), 1);
    let error = read_one(good(), &windows(&[(20.0, 30.0)])).unwrap_err();
    assert!(matches!(error, Error::NoOverlap { .. }), "{error:?}");
}

#[test]
fn a_speed_window_keeps_the_stretches_within_it() {
    // 8 m/s for 20 s, up to 15 m/s within 5 s, 15 m/s with noise for 35 s, 30 m/s to the end.
    let speed = |k: usize| match k {
        0..2000 => 8.0,
        2000..2500 => 8.0 + 7.0 * (k - 2000) as f64 / 500.0,
        2500..6000 => 15.0 + 1.4 * ((k * 7919) % 1000) as f64 / 1000.0,
        _ => 30.0,
    };
    let row = |k: usize| {
        let t = k as f64 * 0.01;
        format!("{t:.2},{:.9},{:.9},{:.4}", steer(t), rate(t), speed(k))
    };
    let bytes = csv(HEADER, 7000, row);
    let window = |from, to| LogOptions { speed_window: Some((from, to)), ..LogOptions::default() };
    // Single samples beyond 16 m/s break nothing: the average over a second is within.
    let log = read_one(bytes.clone(), &window(14.0, 16.0)).unwrap();
    assert_eq!(log.segments.len(), 1, "{:?}", log.segments);
    let (from, to) = (log.time_s()[0], log.time_s()[log.len() - 1]);
    assert!((24.0..25.0).contains(&from) && (59.0..60.1).contains(&to), "{from} {to}");
    assert!(warning(&log, "speed window").contains("in 1 stretch"), "{:?}", log.warnings);
    is_part_of(&log, 1e-4);
    let log = read_one(bytes.clone(), &window(7.0, 16.0)).unwrap();
    assert!((log.len() as f64 * 0.04 - 59.5).abs() < 1.0);
    // Passing through 11 m/s takes less than a second.
    let error = read_one(bytes.clone(), &window(11.0, 12.0)).unwrap_err();
    let Error::SpeedWindow { least, most, quartiles, .. } = error else { panic!("{error:?}") };
    // A filtered jump overshoots.
    assert!((least - 8.0).abs() < 0.1 && (30.0..32.0).contains(&most), "{least} {most}");
    assert!(quartiles.0 < 9.0 && (15.0..17.0).contains(&quartiles.1), "{quartiles:?}");
    assert!(error.hint().contains("--speed-window"), "{}", error.hint());
    let still = csv("time_s,steer_rad,yaw_rate_radps", 1000, |k| good_row(k).replace(",15.0", ""));
    let error = read_one(still, &window(7.0, 16.0)).unwrap_err();
    assert!(matches!(error, Error::NoSpeedForWindow { .. }), "{error:?}");
}

fn file(name: &str, bytes: &[u8]) -> (String, Vec<u8>) {
    (name.to_owned(), bytes.to_vec())
}

/// A drive that starts at another time on another clock.
fn other_drive() -> Vec<u8> {
    csv(HEADER, 800, |k| {
        let t = k as f64 * 0.0125;
        format!("{:.4},{:.9},{:.9},15.0", 1000.0 + t, steer(t), rate(t))
    })
}

#[test]
fn files_that_bring_everything_are_drives_of_their_own() {
    let o = LogOptions::default();
    let log = read_log(&[file("one/a.csv", &good()), file("b.csv", &other_drive())], &o).unwrap();
    let (one, two) = (read_one(good(), &o).unwrap(), read_one(other_drive(), &o).unwrap());
    assert_eq!(log.segments.len(), 2);
    // 0.04 s suits the first, 0.0375 s the second: one sample time for all.
    assert_eq!((one.sample_time_s, two.sample_time_s, log.sample_time_s), (0.04, 0.0375, 0.04));
    assert_eq!(log.output[log.segments[0].range.clone()], one.output[..]);
    assert!(log.segments[1].time0_s > 1000.0);
    for (k, y) in log.output[log.segments[1].range.clone()].iter().enumerate() {
        let t = log.segments[1].time0_s - 1000.0 + 0.04 * k as f64;
        assert!((y - rate(t)).abs() < 1e-3, "{t}");
    }
    // Each file by name and hash, each channel by file and column, and which drives there are.
    let hashes: Vec<_> = log.sources.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(hashes, ["a.csv", "b.csv"]);
    assert_eq!(
        (&log.sources[0].sha256, &log.sources[1].sha256),
        (&{ formats::sha256_hex(&good()) }, &formats::sha256_hex(&other_drive()))
    );
    let columns: Vec<_> = log.channels.iter().map(|c| c.column.as_str()).collect();
    assert_eq!(&columns[..2], ["a.csv:steer_rad", "a.csv:yaw_rate_radps"]);
    assert_eq!((columns.len(), columns[5]), (6, "b.csv:speed_mps"));
    assert_eq!(log.options["drives"], "a.csv; b.csv");
    // A window is on each drive's own clock; a drive that none meets is left out.
    let window = LogOptions { windows: vec![(1001.0, 1008.0)], ..o.clone() };
    let part = read_log(&[file("a.csv", &good()), file("b.csv", &other_drive())], &window).unwrap();
    assert_eq!(part.segments.len(), 1);
    assert!(warning(&part, "no window meets").starts_with("a.csv"));
    let none = LogOptions { windows: vec![(50.0, 60.0)], ..o.clone() };
    let error = read_log(&[file("a.csv", &good()), file("b.csv", &other_drive())], &none);
    assert!(matches!(error, Err(Error::NoOverlap { .. })));
    // The same drive twice would judge a model by what it was estimated from.
    let error = read_log(&[file("a.csv", &good()), file("copy.csv", &good())], &o).unwrap_err();
    assert!(
        matches!(&error, Error::RepeatedDrive { first, second } if first == "a.csv" && second == "copy.csv")
    );
    // Where one drive has no speed, none is used.
    let mute = csv("time_s,steer_rad,yaw_rate_radps", 999, |k| good_row(k).replace(",15.0", ""));
    let log = read_log(&[file("a.csv", &good()), file("mute.csv", &mute)], &o).unwrap();
    assert!(log.speed.is_none() && warning(&log, "no speed in").contains("mute.csv"));
}

#[test]
fn which_files_are_one_drive_is_told_or_asked() {
    let o = LogOptions::default();
    let bare = csv("time_s,steer_rad,yaw_rate_radps", 1000, |k| good_row(k).replace(",15.0", ""));
    let speed = csv("time_s,speed_mps", 1000, |k| format!("{},15", k as f64 * 0.01));
    // A file that adds to the only whole one.
    let log = read_log(&[file("a.csv", &bare), file("speed.csv", &speed)], &o).unwrap();
    assert!(log.segments.len() == 1 && log.speed.is_some());
    // To which of two it adds is not known.
    let three = [file("a.csv", &bare), file("b.csv", &other_drive()), file("speed.csv", &speed)];
    let error = read_log(&three, &o).unwrap_err();
    assert!(matches!(error, Error::AmbiguousDrives { .. }), "{error:?}");
    assert!(error.hint().contains("--drive a.csv,speed.csv"), "{}", error.hint());
    let open = |i: usize| LogFile::of_bytes(&three[i].0, &three[i].1);
    let log = read_drives(vec![open(1)], vec![vec![open(0), open(2)]], &o).unwrap();
    assert_eq!(
        (log.segments.len(), log.options["drives"].as_str()),
        (2, "b.csv; a.csv + speed.csv")
    );
    assert!(log.speed.is_some());
    // Columns named with their files are channels of one drive.
    let named = LogOptions {
        input: Some("a.csv:steer_rad".into()),
        output: Some("b.csv:yaw_rate_radps".into()),
        ..o.clone()
    };
    let error = read_log(&three[..2], &named).unwrap_err();
    assert!(matches!(error, Error::NoOverlap { .. }), "{error:?}");
    assert!(matches!(read_drives(Vec::new(), vec![Vec::new()], &o), Err(Error::NoFiles)));
}

/// A reader that gives a byte at a time, and fails where told.
struct Slow<'a>(&'a [u8], usize);

impl std::io::Read for Slow<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.1 == 0 {
            return Err(std::io::Error::other("the disk is gone"));
        }
        self.1 -= 1;
        let count = self.0.len().min(buffer.len()).min(1);
        buffer[..count].copy_from_slice(&self.0[..count]);
        self.0 = &self.0[count..];
        Ok(count)
    }
}

#[test]
fn a_file_is_read_as_it_comes() {
    let text = [b"\xEF\xBB\xBF", b"\n \n".as_slice(), &good()].concat();
    let read = |budget: usize| {
        let file = LogFile { name: "slow.csv".into(), reader: Box::new(Slow(&text, budget)) };
        read_drives(vec![file], Vec::new(), &LogOptions::default())
    };
    let log = read(usize::MAX).unwrap();
    assert_eq!(log.output, read_one(good(), &LogOptions::default()).unwrap().output);
    assert_eq!(log.sources[0].sha256, formats::sha256_hex(&text));
    for budget in [10, 20_000] {
        let error = read(budget).unwrap_err().to_string();
        assert!(error.starts_with("slow.csv:") && error.contains("the disk is gone"), "{error}");
    }
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
