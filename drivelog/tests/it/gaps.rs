//! Gaps, windows and speed windows: bridged, or the drive is split there.

use super::{HEADER, coarse, csv, good, good_row, rate, read_one, refused, steer, with_line};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use steerwright_drivelog::{DriveLog, Error, Intersample, LogOptions, Response, Role, read_log};

/// The text without some of its lines; the header is line 0.
fn holed(text: &[u8], holes: &[std::ops::Range<usize>]) -> Vec<u8> {
    let text = std::str::from_utf8(text).unwrap();
    let kept = text.lines().enumerate().filter(|(i, _)| !holes.iter().any(|h| h.contains(i)));
    kept.map(|(_, line)| line).collect::<Vec<_>>().join("\n").into_bytes()
}

pub(crate) fn warning<'a>(log: &'a DriveLog, part: &str) -> &'a str {
    let found = log.warnings.iter().find(|w| w.contains(part));
    found.unwrap_or_else(|| panic!("no `{part}` in {:?}", log.warnings))
}

/// Every sample is where and what it is in the drive without gaps, and the segments are all samples.
fn is_part_of(log: &DriveLog, tolerance: f64) {
    let mut next = 0;
    for segment in &log.segments {
        assert_eq!(segment.range.start, next);
        next = segment.range.end;
    }
    assert_eq!((next, log.input.len()), (log.len(), log.len()));
    for (t, y) in log.time_s().into_iter().zip(&log.output) {
        assert!((y - rate(t)).abs() < tolerance, "{t}: {y} {}", rate(t));
    }
}

#[test]
fn short_gaps_are_bridged_and_long_ones_split_the_drive() {
    let o = coarse();
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
    let split = warning(&log, "yaw_rate_radps");
    assert!(split.contains("4 samples") && split.contains("302-305"), "{split}");
    assert_eq!(log.segments.len(), 1);
    is_part_of(&log, 2e-3);
    // Blank for a second: two segments, and the steering that is there is not used between them.
    let log = read_one(blanks(400, 500), &o).unwrap();
    let split = warning(&log, "split");
    assert!(split.starts_with("drive.csv:502: column `yaw_rate_radps`"), "{split}");
    assert!(split.contains("nothing from 3.99 s to 5 s"), "{split}");
    assert_eq!(log.segments.len(), 2);
    is_part_of(&log, 1e-4);
    // Rows missing altogether: 0.2 s bridged, 1 s not.
    let log = read_one(holed(&good(), &[400..420]), &o).unwrap();
    assert!(warning(&log, "bridged").contains("line 401"));
    assert_eq!(log.segments.len(), 1);
    let log = read_one(holed(&good(), &[400..500]), &o).unwrap();
    let split: Vec<&String> = log.warnings.iter().filter(|w| w.contains("split")).collect();
    // Once for the file, though three columns have the gap.
    assert!(split.len() == 1 && split[0].starts_with("drive.csv:401:"), "{split:?}");
    assert_eq!(log.segments.len(), 2);
    // The anti-alias filter takes 0.36 s at either end of each segment.
    let ends: Vec<(f64, f64)> = log
        .segments
        .iter()
        .map(|s| (s.time0_s, s.time0_s + 0.04 * (s.range.len() - 1) as f64))
        .collect();
    assert!(ends[0].1 <= 3.98 - 0.35 && ends[1].0 >= 4.99 + 0.35, "{ends:?}");
    is_part_of(&log, 1e-4);
    let wide = LogOptions { max_gap_s: 5.0, ..o.clone() };
    assert_eq!(read_one(holed(&good(), &[200..500]), &wide).unwrap().segments.len(), 1);
    // At the log's own rate a command has no filter, and no sample is lost.
    let held = Some(Intersample::Zoh);
    let own = LogOptions { sample_time_s: Some(0.01), intersample: held, ..o.clone() };
    let log = read_one(holed(&good(), &[301..601]), &own).unwrap();
    assert_eq!(
        log.segments.iter().map(|s| s.range.clone()).collect::<Vec<_>>(),
        [0..300, 300..700]
    );
    is_part_of(&log, 1e-8);
    // A piece that is too short is left out and reported.
    let log = read_one(holed(&good(), &[100..200, 300..400]), &o).unwrap();
    assert_eq!(log.segments.len(), 1);
    assert!(warning(&log, "left out").contains("2 segments"));
    // One wild instant at the end costs itself alone.
    let wild = with_line(1001, "1e300,0.01,0.1,15");
    let log = read_one(wild, &o).unwrap();
    assert!(warning(&log, "split").contains("1.000e300"), "{:?}", log.warnings);
    is_part_of(&log, 1e-4);
}

#[test]
fn gaps_that_leave_nothing_are_refused_with_the_longest_whole_part() {
    let holes: Vec<_> = (0..9).map(|i| 60 + 110 * i..130 + 110 * i).collect();
    let e = refused(holed(&good(), &holes), &coarse());
    let Error::Gap { at, gap_s, longest, .. } = e.clone() else { panic!("{e:?}") };
    assert!(at.line > 1 && (gap_s - 0.71).abs() < 1e-9, "{e}");
    assert!((longest.1 - longest.0 - 0.59).abs() < 0.03, "{longest:?}");
    assert!(e.hint().contains("bound on gaps"), "{}", e.hint());
}

#[test]
fn yaw_over_a_gap_is_no_yaw_rate() {
    let all = csv("time_s,steer_rad,heading_deg", 1000, |k| {
        let t = k as f64 * 0.01;
        format!("{t:.2},{:.9},{:.9}", steer(t), (-0.2 / PI * (PI * t - 0.3).cos()).to_degrees())
    });
    let options = LogOptions { output: Some("heading_deg".into()), ..coarse() };
    // 0.8 s: its middle is within the bridged length of either end.
    let log = read_one(holed(&all, &[451..531]), &options).unwrap();
    assert_eq!(log.segments.len(), 2);
    is_part_of(&log, 1e-3);
}

/// Seconds since 1970: time counts from the first sample, in windows and in what is reported of them.
#[test]
fn windows_and_messages_count_from_the_first_sample() {
    let late = csv(HEADER, 1000, |k| {
        let row = good_row(k);
        let (time, rest) = row.split_once(',').unwrap();
        let gap = if k < 500 { 0.0 } else { 2.0 };
        format!("{:.2},{rest}", 1_764_000_000.06 + time.parse::<f64>().unwrap() + gap)
    });
    let log = read_one(late.clone(), &coarse()).unwrap();
    assert_eq!(log.options["log_start_s"], "1764000000.06");
    assert!(warning(&log, "nothing from").contains("nothing from 4.99 s to 7 s"), "{log:?}");
    assert!(log.segments[0].time0_s < 0.5, "{:?}", log.segments);
    let windows = |w: (f64, f64)| LogOptions { windows: vec![w], ..LogOptions::default() };
    let part = read_one(late.clone(), &windows((1.0, 4.0))).unwrap();
    assert!(part.time_s().iter().all(|t| (1.0..=4.0).contains(t)));
    let error = read_one(late, &windows((1_764_000_001.0, 1_764_000_004.0))).unwrap_err();
    let text = error.to_string();
    assert!(text.ends_with("the log 0 to 11.99 s") && text.contains("the window"), "{text}");
    assert!(error.hint().contains("from the log's first sample"), "{}", error.hint());
    // A log that starts at 0 states nothing.
    assert!(!read_one(good(), &coarse()).unwrap().options.contains_key("log_start_s"));
}

#[test]
fn windows_may_be_several() {
    let windows = |w: &[(f64, f64)]| LogOptions { windows: w.to_vec(), ..coarse() };
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
fn a_speed_window_keeps_the_segments_within_it() {
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
    let window = |from, to| LogOptions { speed_window: Some((from, to)), ..coarse() };
    // Single samples beyond 16 m/s break nothing: the average over a second is within.
    let log = read_one(bytes.clone(), &window(14.0, 16.0)).unwrap();
    assert_eq!(log.segments.len(), 1, "{:?}", log.segments);
    let (from, to) = (log.time_s()[0], log.time_s()[log.len() - 1]);
    assert!((24.0..25.0).contains(&from) && (59.0..60.1).contains(&to), "{from} {to}");
    assert!(warning(&log, "speed window").contains("in 1 segment"), "{:?}", log.warnings);
    is_part_of(&log, 1e-4);
    let log = read_one(bytes.clone(), &window(7.0, 16.0)).unwrap();
    assert!((log.len() as f64 * 0.04 - 59.5).abs() < 1.0);
    // Passing through 11 m/s takes less than a second.
    let error = read_one(bytes.clone(), &window(11.0, 12.0)).unwrap_err();
    let Error::SpeedWindow { least, most, quartiles, .. } = error else { panic!("{error:?}") };
    // A filtered jump overshoots.
    assert!((least - 8.0).abs() < 0.1 && (30.0..32.0).contains(&most), "{least} {most}");
    assert!(quartiles.0 < 9.0 && (15.0..17.0).contains(&quartiles.1), "{quartiles:?}");
    assert!(error.hint().contains("speed window"), "{}", error.hint());
    let still = csv("time_s,steer_rad,yaw_rate_radps", 1000, |k| good_row(k).replace(",15.0", ""));
    let error = read_one(still, &window(7.0, 16.0)).unwrap_err();
    assert!(matches!(error, Error::NoSpeedForWindow { .. }), "{error:?}");
}

#[test]
fn an_optional_channel_takes_no_sample_from_the_others() {
    let motion = LogOptions { response: Response::Motion, ..coarse() };
    let with = |name: &str, cell: &dyn Fn(usize) -> String| {
        csv(&format!("{HEADER},{name}"), 1000, |k| format!("{},{}", good_row(k), cell(k)))
    };
    let acceleration = "lateral_acceleration_mps2";
    let value = |k: usize| format!("{:.5}", 15.0 * rate(k as f64 * 0.01));
    let when =
        |is_there: fn(usize) -> bool| move |k| if is_there(k) { value(k) } else { String::new() };
    let without = read_one(good(), &motion).unwrap();
    let same = |log: &DriveLog| {
        assert_eq!((&log.segments, &log.output), (&without.segments, &without.output));
        assert_eq!((&log.input, &log.speed), (&without.input, &without.speed));
        log.others.contains_key(&Role::LateralAcceleration)
    };
    let whole = read_one(with(acceleration, &value), &motion).unwrap();
    assert!(same(&whole));
    // A short gap and one at the end are bridged, and so is a cell with a text.
    let bridged = |k: usize| match k {
        300..320 | 980.. => String::new(),
        500 => "abc".into(),
        k => value(k),
    };
    assert!(same(&read_one(with(acceleration, &bridged), &motion).unwrap()));
    type Case<'c> = (&'c str, &'c dyn Fn(usize) -> String, &'c str);
    let unused: [Case<'_>; 10] = [
        (acceleration, &|_| String::new(), "has 0 values"),
        (acceleration, &|_| "NaN".into(), "has 0 values"),
        (acceleration, &|_| "abc".into(), "holds texts"),
        (
            acceleration,
            &|k| if k < 400 { value(k) } else { "abc".into() },
            "no value in 6.0 s of 10.0 s",
        ),
        (acceleration, &|_| "0.0".into(), "throughout"),
        (
            acceleration,
            &when(|k| !(300..400).contains(&k)),
            "no value in 1.0 s of 10.0 s, first from 2.99 s to 4",
        ),
        (
            acceleration,
            &when(|k| k < 500),
            "no value in 5.0 s of 10.0 s, first from 4.99 s to 9.99",
        ),
        (acceleration, &when(|k| k >= 500), "no value in 5.0 s of 10.0 s, first from 0 s to 5"),
        ("lateral_acceleration [furlong]", &value, "`furlong` is not a known unit"),
        ("sideslip_deg", &|k| format!("{}", 100 + k % 7), "sideslip"),
    ];
    for (name, cell, reason) in unused {
        let log = read_one(with(name, cell), &motion).unwrap();
        assert!(!same(&log) && !log.others.contains_key(&Role::Sideslip), "{reason}");
        let warning = warning(
            &log,
            &format!("the {}", name[..8].replace("lateral_", "lateral acceleration")),
        );
        assert!(warning.contains(name) && warning.contains(reason), "{warning}");
        if name == acceleration {
            let channels = BTreeMap::from([("lateral_acceleration".to_owned(), name.to_owned())]);
            let stated = LogOptions { channels, ..motion.clone() };
            match read_one(with(name, cell), &stated) {
                Ok(log) => assert!(log.len() < without.len(), "{reason}"),
                Err(error) => assert!(error.to_string().contains(name), "{error}"),
            }
        }
    }
    // A drive without it: the other's is not used.
    let files = [("a.csv".to_owned(), with(acceleration, &value)), ("b.csv".to_owned(), good())];
    let log = read_log(&files, &motion).unwrap();
    assert!(!log.others.contains_key(&Role::LateralAcceleration));
    assert!(warning(&log, "no lateral acceleration in b.csv").contains("is not used"));
}
