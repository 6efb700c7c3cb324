//! The raw CAN bus of the recorded city drive, decoded by its database.

use std::path::Path;
use steerwright_drivelog::{
    Error, LogFile, LogOptions, Recording, Request, Wanted, inspect, open, read_drives,
};

fn data(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/drives/comma2k19");
    std::fs::read(folder.join(name)).unwrap()
}

fn with_database() -> LogOptions {
    let dbc = ("toyota.dbc".to_owned(), data("can/toyota_prius_2010_pt.dbc"));
    LogOptions { dbc: vec![dbc], ..LogOptions::default() }
}

fn bus(bytes: &[u8]) -> Box<dyn Recording> {
    open(LogFile::of_bytes("raw_can.log.gz", bytes), &with_database()).unwrap()
}

/// The rows of some channels of a group.
fn values(recording: &mut dyn Recording, group: &str, channels: &[&str]) -> Vec<Vec<f64>> {
    let place = recording.groups().iter().position(|g| g.name == group).unwrap();
    let names = &recording.groups()[place].channels;
    let channel = |name: &&str| names.iter().position(|c| c.name == **name).unwrap();
    let wanted = [Wanted { group: place, channels: channels.iter().map(channel).collect() }];
    let mut all = vec![Vec::new(); channels.len()];
    for rows in recording.rows(Request { wanted: &wanted, window_s: None, most: 1000 }).unwrap() {
        let rows = rows.unwrap().columns;
        assert!(rows.lines.len() <= 1000);
        all.iter_mut().zip(rows.values).for_each(|(all, mut new)| all.append(&mut new));
    }
    all
}

#[test]
fn the_bus_has_the_shipped_steering_exactly() {
    let mut recording = bus(&data("can/raw_can.log.gz"));
    let wanted = ["time", "STEER_ANGLE", "STEER_FRACTION"];
    let read = values(recording.as_mut(), "STEER_ANGLE_SENSOR", &wanted);
    let [time, angle, fraction] = &read[..] else { panic!() };
    let csv = String::from_utf8(data("steering_wheel_angle.csv")).unwrap();
    let rows: Vec<(f64, f64)> = csv
        .lines()
        .skip(1)
        .map(|row| row.split_once(',').unwrap())
        .map(|(t, angle)| (t.parse().unwrap(), angle.parse().unwrap()))
        .collect();
    assert_eq!((time.len(), rows.len()), (4974, 4974));
    for (k, (t, shipped)) in rows.into_iter().enumerate() {
        assert!((time[k] - 46_408.0 - t).abs() < 1e-6, "row {k}: {} {t}", time[k]);
        // The file has three decimals.
        let sum = format!("{:.3}", angle[k] + fraction[k]).parse::<f64>().unwrap();
        assert_eq!(sum, shipped, "row {k}");
    }
}

#[test]
fn the_messages_are_listed_with_what_they_look_like() {
    let file = LogFile::of_bytes("raw_can.log.gz", &data("can/raw_can.log.gz"));
    let found = inspect(file, &with_database()).unwrap();
    let candidates: Vec<(String, &str)> = found
        .groups
        .iter()
        .flat_map(|g| g.channels.iter().map(move |c| (g, c)))
        .flat_map(|(g, c)| {
            c.candidate_for.iter().map(move |r| (format!("{}.{}", g.name, c.name), *r))
        })
        .collect();
    for (name, role) in [
        ("STEER_ANGLE_SENSOR.STEER_ANGLE", "steering"),
        ("KINEMATICS.YAW_RATE", "yaw rate"),
        ("SPEED.SPEED", "speed"),
    ] {
        assert!(candidates.contains(&(name.into(), role)), "{name}: {candidates:?}");
    }
    let losses = found.losses.join("\n");
    assert!(losses.contains("kinds of frames are in no database"), "{losses}");
}

#[test]
fn a_drive_is_read_from_the_bus_by_an_expression() {
    let options = LogOptions {
        input: Some("STEER_ANGLE + STEER_FRACTION".into()),
        output: Some("KINEMATICS.YAW_RATE".into()),
        speed: Some("SPEED.SPEED".into()),
        topics: ["STEER_ANGLE_SENSOR", "KINEMATICS", "SPEED"].map(str::to_owned).into(),
        units: [("STEER_ANGLE", "deg"), ("YAW_RATE", "deg/s")]
            .map(|(a, b)| (a.to_owned(), b.to_owned()))
            .into(),
        steering_ratio: Some(16.0),
        ..with_database()
    };
    let file = LogFile::of_bytes("raw_can.log.gz", &data("can/raw_can.log.gz"));
    let log = read_drives(vec![file], Vec::new(), &options).unwrap();
    let seconds = log.len() as f64 * log.sample_time_s;
    assert!((58.0..61.0).contains(&seconds), "{seconds}");
    let mean = log.speed.unwrap().iter().sum::<f64>() / log.output.len() as f64;
    assert!((15.0..18.0).contains(&mean), "{mean}");
    assert!(log.sources[0].of_samples);
}

#[test]
fn without_a_database_and_with_a_foreign_one_the_bus_is_refused() {
    let read = |dbc: &str| {
        let dbc = if dbc.is_empty() { vec![] } else { vec![("x.dbc".into(), dbc.into())] };
        let options = LogOptions { dbc, ..LogOptions::default() };
        open(LogFile::of_bytes("a.log", b"(1.0) can0 123#00\n(1.1) can0 124#00\n"), &options)
            .map(drop)
    };
    assert!(matches!(read(""), Err(Error::NoDatabase { kinds: 2, .. })));
    let foreign = "BO_ 5 OTHER: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n";
    assert!(matches!(read(foreign), Err(Error::NotInDatabase { kinds: 2, .. })));
}

#[test]
fn parameter_groups_are_read_from_any_source() {
    let dbc = "BO_ 2565868030 VDC2: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n";
    let options = LogOptions { dbc: vec![("x.dbc".into(), dbc.into())], ..LogOptions::default() };
    let text = "(1.0) c 18F0090B#05\n(1.1) c 0CF0090C#06\n(1.2) c 18F00A0B#07\n";
    let log = open(LogFile::of_bytes("a.log", text.as_bytes()), &options).unwrap();
    let names: Vec<&str> = log.groups().iter().map(|g| g.name.as_str()).collect();
    assert_eq!(names, ["VDC2[SA=0x0C]", "VDC2[SA=0x0B]"]);
}

#[test]
fn a_parameter_group_is_read_from_another_source_than_that_of_its_database() {
    // EEC1 of source 0, and a group that is left to the makers.
    let dbc = "BO_ 2364539904 EEC1: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n\
               BO_ 2566852608 OWN: 8 X\n SG_ B : 0|8@1+ (1,0) [0|0] \"\" X\n";
    let options = LogOptions { dbc: vec![("x.dbc".into(), dbc.into())], ..LogOptions::default() };
    let groups = |text: &str| -> Vec<String> {
        let log = open(LogFile::of_bytes("a.log", text.as_bytes()), &options).unwrap();
        log.groups().iter().map(|g| g.name.clone()).collect()
    };
    assert_eq!(groups("(1.0) c 0CF0040B#05\n(1.1) c 18FF100B#06\n"), ["EEC1[SA=0x0B]"]);
    // Where the stated source is on the bus, another one is none of the database.
    assert_eq!(groups("(1.0) c 0CF00400#05\n(1.1) c 0CF0040B#06\n"), ["EEC1"]);
}

#[test]
fn a_log_by_names_is_read_by_those_of_the_database() {
    let dbc = "BO_ 37 STEER: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n\
               BO_ 2565868030 FACE: 8 X\n SG_ B : 0|8@1+ (1,0) [0|0] \"\" X\n\
               BO_ 38 TWICE: 8 X\n SG_ C : 0|8@1+ (1,0) [0|0] \"\" X\n";
    let other = "BO_ 39 TWICE: 8 X\n SG_ D : 0|8@1+ (1,0) [0|0] \"\" X\n";
    let dbc = [("x.dbc", dbc), ("y.dbc", other)].map(|(name, text)| (name.into(), text.into()));
    let options = LogOptions { dbc: dbc.to_vec(), ..LogOptions::default() };
    let text = "date Thu Feb 1\nbase hex  timestamps absolute\n\
                0.5 1 STEER Rx d 1 05\n0.6 1 FACE Tx d 1 06\n0.7 1 26 Rx d 1 07\n\
                0.8 CANFD 1 Rx STEER 1 0 1 1 08\n0.9 1 TWICE Rx d 1 09\n";
    let log = open(LogFile::of_bytes("a.asc", text.as_bytes()), &options).unwrap();
    let groups = log.groups().iter().map(|g| (g.name.as_str(), g.rows));
    let expected = [("STEER", Some(2)), ("TWICE", Some(1)), ("FACE", Some(1))];
    assert_eq!(groups.collect::<Vec<_>>(), expected);
    // Which of two messages a name is that of is open.
    assert!(log.losses()[0].contains("1 line is no frame"), "{:?}", log.losses());
    let text = "date Thu Feb 1\n0.5 1 STEER Rx d 1 05\n";
    let without = LogOptions { dbc: vec![("y.dbc".into(), other.into())], ..LogOptions::default() };
    let error = open(LogFile::of_bytes("a.asc", text.as_bytes()), &without).map(drop).unwrap_err();
    assert!(
        matches!(error, Error::NoFrames { .. }) && error.hint().contains("database"),
        "{error}"
    );
}

#[test]
fn a_log_that_begins_with_remote_frames_and_errors_is_a_bus() {
    let dbc = "BO_ 37 STEER: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n";
    let options = LogOptions { dbc: vec![("x.dbc".into(), dbc.into())], ..LogOptions::default() };
    let top = "(1.0) can0 025#R\n(1.0) can0 20000080#0000000000000000\n(1.0) can0 026#R8\n";
    for rest in ["(1.1) can0 025#05\n", " (1.1)  can0  025   [1]  05\n"] {
        let text = format!("{top}{rest}");
        let log = open(LogFile::of_bytes("a.log", text.as_bytes()), &options).unwrap();
        assert_eq!((log.groups()[0].rows, log.losses().len()), (Some(1), 0));
    }
}

#[test]
fn times_between_frames_are_added_up_also_in_bursts() {
    let dbc = "BO_ 37 STEER: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n";
    let options = LogOptions { dbc: vec![("x.dbc".into(), dbc.into())], ..LogOptions::default() };
    let span = |times: &dyn Fn(u32) -> f64| {
        let line = |k| format!("({:010.6}) can0 025#05\n", times(k));
        let text: String = (0..1000).map(line).collect();
        let log = open(LogFile::of_bytes("a.log", text.as_bytes()), &options).unwrap();
        let (from, to) = log.groups()[0].span_s.unwrap();
        to - from
    };
    // Of 20 frames at each 0.1 s the others share the instant.
    let burst = |k: u32| if k.is_multiple_of(20) { 0.1 } else { 0.0 };
    assert!((span(&burst) - 4.9).abs() < 1e-6);
    // Instants since the start, of frames in bursts, of two interfaces whose clocks differ by 9 s.
    assert!((span(&|k| f64::from(k / 20) * 0.1) - 4.9).abs() < 1e-6);
    let of_two = |k: u32| f64::from(k) * 0.01 + 9.0 * f64::from(k % 2);
    assert!((span(&of_two) - 18.99).abs() < 1e-6);
}

#[test]
fn short_recordings_that_follow_each_other_have_instants() {
    let dbc = "BO_ 37 STEER: 8 X\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n";
    let options = LogOptions { dbc: vec![("x.dbc".into(), dbc.into())], ..LogOptions::default() };
    let losses = |times: &dyn Fn(u32) -> f64| {
        let line = |k| format!("({:010.6}) can0 025#05\n", times(k));
        let text: String = (0..600).map(line).collect();
        open(LogFile::of_bytes("a.log", text.as_bytes()), &options).unwrap().losses()
    };
    for frames in [20, 50, 150] {
        for first in [0.0, 3.5] {
            let instants = losses(&|k| first + 0.01 * f64::from(k % frames));
            assert_eq!(instants, Vec::<String>::new(), "{frames} frames");
        }
        // The pause before each of them is long.
        let steps = losses(&|k| if k.is_multiple_of(frames) { 5.0 } else { 0.01 });
        assert!(steps[0].contains("candump -t d"), "{steps:?}");
    }
    // With and without the variation of a real bus; the first frame has no frame before it.
    let varied = |k: u32| if k == 0 { 0.0 } else { 0.01 + 1e-4 * f64::from(k * 7919 % 31) };
    let equal = |k: u32| if k == 0 { 0.0 } else { 0.01 };
    for times in [&varied as &dyn Fn(u32) -> f64, &equal] {
        let steps = losses(times);
        assert!(steps[0].contains("candump -t d"), "{steps:?}");
    }
}

#[test]
fn a_truncated_archive_and_bad_lines_lose_only_themselves() {
    let whole = data("can/raw_can.log.gz");
    let mut cut = bus(&whole[..whole.len() / 2]);
    let rows = values(cut.as_mut(), "STEER_ANGLE_SENSOR", &["time"])[0].len();
    assert!((1500..3500).contains(&rows), "{rows}");
    let losses = cut.losses().join("\n");
    assert!(losses.contains("nothing is read after line"), "{losses}");
    let text = "(1.0) c STEER\n(1.1) c 025#00001000C00000FD\n(bad\n(1.2) c 025#0000\n";
    let mut bad = open(LogFile::of_bytes("a.log", text.as_bytes()), &with_database()).unwrap();
    let read =
        values(bad.as_mut(), "STEER_ANGLE_SENSOR", &["time", "STEER_ANGLE", "STEER_FRACTION"]);
    assert_eq!(read[0], [1.1, 1.2]);
    // A frame that is too short has no fraction.
    assert!(read[2][1].is_nan() && !read[2][0].is_nan() && !read[1][1].is_nan());
    assert!(bad.losses()[0].contains("2 lines are no frame"), "{:?}", bad.losses());
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(
        flips in proptest::collection::vec((0_usize..4000, 0_u8..=255), 0..40),
        form in 0..2,
    ) {
        let asc = "date x\nbase hex timestamps absolute\n1.5 1 25 Rx d 8 00 00 10 00 C0 00 00 FD\n";
        let log = "(1.1) can0 025#00001000C00000FD\n(1.2) can1 025##100001000C00000FD\n";
        let mut text = if form == 0 { asc.repeat(20) } else { log.repeat(20) }.into_bytes();
        let mut dbc = data("can/toyota_prius_2010_pt.dbc");
        for (at, byte) in flips {
            let at_dbc = at % dbc.len();
            dbc[at_dbc] = byte;
            let at = at % text.len();
            text[at] = byte;
        }
        let options = LogOptions { dbc: vec![("a.dbc".into(), dbc)], ..LogOptions::default() };
        let _ = inspect(LogFile::of_bytes("a.log", &text), &options);
    }
}
