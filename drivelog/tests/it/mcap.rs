//! MCAP files with messages of ROS 2, written here; the peers compare all kinds of fields and messages.

use super::{rate, steer};
use proptest::prelude::*;
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use steerwright_drivelog::{
    Error, Inspection, LogFile, LogOptions, ReadAt, Request, Wanted, inspect, open, read_drives,
};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const HEADER: &str = "===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
/// Topic, encoding, type and definition of each channel.
const CHANNELS: [[&str; 4]; 6] = [
    [
        "/steering",
        "cdr",
        "autoware_vehicle_msgs/msg/SteeringReport",
        "builtin_interfaces/Time stamp\nfloat32 steering_tire_angle\n",
    ],
    [
        "/velocity",
        "cdr",
        "autoware_vehicle_msgs/msg/VelocityReport",
        "std_msgs/Header header\nfloat32 longitudinal_velocity\nfloat32 lateral_velocity\nfloat32 heading_rate\n",
    ],
    ["/camera", "cdr", "test_msgs/msg/Image", "std_msgs/Header header\nuint8[] data\n"],
    ["/other", "protobuf", "other.Message", ""],
    [
        "/imu/data",
        "cdr",
        "sensor_msgs/msg/Imu",
        "std_msgs/Header header\ngeometry_msgs/Vector3 angular_velocity\n===\nMSG: geometry_msgs/Vector3\n\
         float64 x\nfloat64 y\nfloat64 z\n",
    ],
    [
        "/json",
        "json",
        "Drive",
        r#"{"properties": {"roll": {"type": ["number", "null"]}, "name": {"type": "string"}}}"#,
    ],
];

#[derive(Clone)]
struct Message {
    channel: u16,
    /// ns
    log_time: u64,
    data: Vec<u8>,
}

#[derive(Clone, Copy)]
struct Form {
    compression: &'static str,
    per_chunk: Option<usize>,
    has_summary: bool,
}

const FORM: Form = Form { compression: "zstd", per_chunk: Some(100), has_summary: true };

fn record(code: u8, content: &[u8]) -> Vec<u8> {
    [&[code], &(content.len() as u64).to_le_bytes()[..], content].concat()
}

fn counted(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

fn compressed(compression: &str, bytes: &[u8]) -> Vec<u8> {
    match compression {
        "zstd" => {
            ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
        }
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        }
        _ => bytes.to_vec(),
    }
}

fn definitions(messages: &[Message]) -> Vec<u8> {
    let mut all = Vec::new();
    for (id, [topic, encoding, kind, text]) in (1_u16..).zip(CHANNELS) {
        if messages.iter().all(|m| m.channel != id) {
            continue;
        }
        let (encoded, text) = if *encoding == *"cdr" {
            ("ros2msg", format!("{text}{HEADER}"))
        } else {
            (if *encoding == *"json" { "jsonschema" } else { "x" }, text.into())
        };
        let schema =
            [counted(kind.as_bytes()), counted(encoded.as_bytes()), counted(text.as_bytes())];
        all.extend(record(3, &[&id.to_le_bytes()[..], &schema.concat()].concat()));
        let ids = [id.to_le_bytes(), id.to_le_bytes()].concat();
        let texts = [counted(topic.as_bytes()), counted(encoding.as_bytes()), counted(&[])];
        all.extend(record(4, &[ids, texts.concat()].concat()));
    }
    all
}

fn write(messages: &[Message], form: Form) -> Vec<u8> {
    let mut file = [MAGIC, &record(1, &[counted(b"ros2"), counted(b"")].concat())].concat();
    if !form.has_summary || form.per_chunk.is_none() {
        file.extend(definitions(messages));
    }
    let mut indexes = Vec::new();
    for part in messages.chunks(form.per_chunk.unwrap_or(usize::MAX)) {
        let records = part.iter().map(|m| {
            let times = [m.log_time, m.log_time].map(u64::to_le_bytes).concat();
            record(5, &[&m.channel.to_le_bytes(), &[0; 4][..], &times, &m.data].concat())
        });
        let records = records.collect::<Vec<_>>().concat();
        if form.per_chunk.is_none() {
            file.extend(records);
            continue;
        }
        let times = || part.iter().map(|m| m.log_time);
        let times = [times().min().unwrap(), times().max().unwrap()].map(u64::to_le_bytes).concat();
        let bytes = compressed(form.compression, &records);
        let length = (records.len() as u64).to_le_bytes();
        let start = [&times[..], &length, &crc32fast::hash(&records).to_le_bytes()].concat();
        let start = [start, counted(form.compression.as_bytes())].concat();
        let start = [&start[..], &(bytes.len() as u64).to_le_bytes()].concat();
        let at = file.len() as u64;
        let chunk = record(6, &[start, bytes].concat());
        let mut channels: Vec<u16> = part.iter().map(|m| m.channel).collect();
        channels.sort_unstable();
        channels.dedup();
        let map = channels.iter().flat_map(|id| [&id.to_le_bytes()[..], &[0; 8]].concat());
        let map = counted(&map.collect::<Vec<_>>());
        let place = [at, chunk.len() as u64].map(u64::to_le_bytes).concat();
        let sizes = [counted(form.compression.as_bytes()), vec![0; 16]].concat();
        indexes.extend(record(8, &[times, place, map, vec![0; 8], sizes].concat()));
        file.extend(chunk);
    }
    file.extend(record(15, &[0; 4]));
    let mut start = 0;
    if form.has_summary {
        start = file.len() as u64;
        file.extend(definitions(messages));
        let chunks = form.per_chunk.map_or(0, |per| messages.len().div_ceil(per)) as u32;
        let counts = (1..=CHANNELS.len() as u16).map(|id| {
            let count = messages.iter().filter(|m| m.channel == id).count() as u64;
            [&id.to_le_bytes()[..], &count.to_le_bytes()].concat()
        });
        let counts = counted(&counts.collect::<Vec<_>>().concat());
        let used = (1..=6).filter(|id| messages.iter().any(|m| m.channel == *id)).count();
        let channels = (used as u32).to_le_bytes();
        let count = (messages.len() as u64).to_le_bytes();
        let head = [&count[..], &[0; 2], &channels, &[0; 8], &chunks.to_le_bytes()].concat();
        file.extend(record(11, &[&head[..], &[0; 16], &counts].concat()));
        file.extend(indexes);
    }
    let footer = [&start.to_le_bytes()[..], &[0; 12]].concat();
    [file, record(2, &footer), MAGIC.to_vec()].concat()
}

const START: u64 = 1_700_000_000_000_000_000;

fn cdr(ns: u64, is_header: bool, numbers: &[f64]) -> Vec<u8> {
    let (seconds, rest) = ((ns / 1_000_000_000) as u32, (ns % 1_000_000_000) as u32);
    let mut data = vec![0, 1, 0, 0];
    data.extend([seconds.to_le_bytes(), rest.to_le_bytes()].concat());
    if is_header {
        data.extend([&4_u32.to_le_bytes()[..], b"car\0"].concat());
    }
    numbers.iter().for_each(|x| data.extend((*x as f32).to_le_bytes()));
    data
}

/// A drive of 10 s; every other message is logged 9 ms after its stamp, the others 1 ms.
fn messages() -> Vec<Message> {
    let mut all = Vec::new();
    for k in 0..1000 {
        let t = 0.01 * k as f64;
        let stamp = START + 10_000_000 * k;
        let log_time = stamp + if k % 2 == 0 { 12_000_000 } else { 1_000_000 };
        let image =
            [cdr(stamp, true, &[]), 2000_u32.to_le_bytes().to_vec(), vec![7; 2000]].concat();
        for (channel, data) in [
            (1, cdr(stamp, false, &[steer(t)])),
            (2, cdr(stamp, true, &[15.0, 0.0, rate(t)])),
            (3, image),
            (4, vec![k as u8]),
        ] {
            if channel < 3 || k % 50 == 0 {
                all.push(Message { channel, log_time, data });
            }
        }
    }
    all
}

fn read(bytes: &[u8]) -> Inspection {
    inspect(LogFile::of_bytes("drive.mcap", bytes), &LogOptions::default()).unwrap()
}

/// The stamps and angles of the steering, and what was lost.
fn steering(bytes: &[u8]) -> (Vec<[f64; 2]>, Vec<String>) {
    let mut log = open(LogFile::of_bytes("drive.mcap", bytes), &LogOptions::default()).unwrap();
    let place = |name: &str| log.groups().iter().position(|g| g.name == name).unwrap();
    let wanted = [Wanted { group: place("/steering"), channels: vec![2, 3] }];
    let request = Request { wanted: &wanted, window_s: None, most: 64 };
    let mut rows = Vec::new();
    for piece in log.rows(request).unwrap() {
        let columns = piece.unwrap().columns;
        assert!(columns.lines.len() <= 64);
        rows.extend(columns.values[0].iter().zip(&columns.values[1]).map(|(t, x)| [*t, *x]));
    }
    (rows, log.losses())
}

#[test]
fn messages_in_zstandard_have_the_same_rows() {
    let mut all = messages();
    all.iter_mut().for_each(|m| m.data = compressed("zstd", &m.data));
    for per_chunk in [Some(100), None] {
        let (rows, losses) = steering(&write(&all, Form { per_chunk, ..FORM }));
        assert!(losses.is_empty() && rows.len() == 1000, "{losses:?}");
        rows.iter().enumerate().for_each(|(k, row)| assert_eq!(*row, expected(k), "{k}"));
    }
    all.iter_mut().for_each(|m| m.data.truncate(10));
    let (rows, losses) = steering(&write(&all, FORM));
    assert!(rows.is_empty() && losses.join("\n").contains("Zstandard"), "{losses:?}");
}

#[test]
fn fields_of_json_are_those_of_the_schema_and_of_all_first_messages() {
    let json = (0..300_u64).map(|k| {
        let data = match k {
            0 => r#"{"yaw_rate": null, "name": "x"}"#.into(),
            1..100 => "{}".into(),
            _ => format!(r#"{{"yaw_rate": 0.5, "late": {{"x": {k}}}}}"#),
        };
        Message { channel: 6, log_time: START + 10_000_000 * k, data: data.into_bytes() }
    });
    let found = read(&write(&json.collect::<Vec<_>>(), Form { per_chunk: None, ..FORM }));
    let fields: Vec<(&str, usize)> =
        found.groups[0].channels[2..].iter().map(|c| (c.name.as_str(), c.values)).collect();
    assert_eq!(fields, [("late.x", 200), ("roll", 0), ("yaw_rate", 200)]);
}

/// The messages of steering and velocity, whose stamps are moved by so many ns.
fn stamped(shift: impl Fn(u64) -> i64) -> Vec<Message> {
    let mut all = messages();
    all.retain(|m| m.channel < 3);
    for message in &mut all {
        let number = |at: usize| u32::from_le_bytes(message.data[at..at + 4].try_into().unwrap());
        let stamp = 1_000_000_000 * u64::from(number(4)) + u64::from(number(8));
        let moved = stamp.saturating_add_signed(shift((stamp - START) / 10_000_000));
        message.data.splice(..12, cdr(moved, false, &[]));
    }
    all
}

#[test]
fn late_stamps_are_sorted_with_a_note_and_those_that_begin_again_are_an_error() {
    let all = stamped(|_| 0);
    let same = |rows: &[[f64; 2]]| rows.iter().enumerate().all(|(k, row)| *row == expected(k));
    let loose = Form { per_chunk: None, ..FORM };
    // One in 100 is sent 0.2 s later than the others.
    let late =
        |m: &Message| m.log_time + if m.log_time / 10_000_000 % 100 == 1 { 200_000_000 } else { 0 };
    let mut delayed = all.clone();
    delayed.iter_mut().for_each(|m| m.log_time = late(m));
    delayed.sort_by_key(|m| m.log_time);
    for form in [FORM, loose] {
        let (rows, losses) = steering(&write(&delayed, form));
        assert!(same(&rows), "sorted");
        let losses = losses.join("\n");
        assert!(losses.contains("/steering: 20 messages with a stamp before"), "{losses}");
    }
    // After 6 s the clock of the sender begins again.
    let again = stamped(|k| if k < 600 { 0 } else { -5_000_000_000 });
    for form in [FORM, loose] {
        let bytes = write(&again, form);
        let file = LogFile::of_bytes("drive.mcap", &bytes);
        let error = read_drives(vec![file], Vec::new(), &LogOptions::default()).unwrap_err();
        assert!(error.to_string().contains("does not come after"), "{error}");
        let losses = read(&bytes).losses.join("\n");
        assert!(losses.contains("a time before that of the row above"), "{losses}");
    }
}

#[test]
fn log_times_that_fall_along_a_file_are_reported() {
    let mut all = stamped(|_| 0);
    let back = |m: &mut Message| m.log_time -= 5_000_000_000;
    all.iter_mut().filter(|m| m.log_time > START + 6_000_000_000).for_each(back);
    let losses = read(&write(&all, Form { per_chunk: None, ..FORM })).losses.join("\n");
    for topic in ["/steering", "/velocity"] {
        assert!(losses.contains(&format!("{topic}: the log times fall by 5.0 s")), "{losses}");
    }
}

#[test]
fn types_without_a_definition_are_those_that_are_stated_or_usual() {
    let form = Form { per_chunk: None, has_summary: false, ..FORM };
    let file = write(&messages(), form);
    // Bags of ROS 2 Humble have none; the texts keep their length.
    let blank = |kind: &str| {
        let place = CHANNELS.iter().find(|own| own[2] == kind).unwrap();
        let text = format!("{}{HEADER}", place[3]);
        let at = file.windows(text.len()).position(|part| part == text.as_bytes()).unwrap();
        let mut file = file.clone();
        file[at..at + text.len()].fill(b' ');
        file
    };
    let fields = |file: &[u8], options: &LogOptions, topic: &str| {
        let found = inspect(LogFile::of_bytes("drive.mcap", file), options).unwrap();
        let group = found.groups.iter().find(|g| g.name == topic).unwrap();
        let names: Vec<String> = group.channels[2..].iter().map(|c| c.name.clone()).collect();
        (names, found.losses.join("\n"))
    };
    let none = LogOptions::default();
    let (names, _) = fields(&blank("autoware_vehicle_msgs/msg/SteeringReport"), &none, "/steering");
    assert_eq!(names, ["stamp", "steering_tire_angle"]);
    let own = blank("test_msgs/msg/Image");
    let (names, losses) = fields(&own, &none, "/camera");
    assert!(names.is_empty());
    assert!(losses.contains("/camera: no definition of test_msgs/msg/Image"), "{losses}");
    assert!(losses.contains("--ros-definitions"), "{losses}");
    let text = String::from("std_msgs/Header header\nuint8[] data\n");
    let stated = [("test_msgs/Image".to_owned(), text)].into();
    let (names, _) = fields(&own, &LogOptions { ros_definitions: stated, ..none }, "/camera");
    assert_eq!(names, ["header.stamp"]);
}

fn expected(k: usize) -> [f64; 2] {
    let stamp = START as i64 + 10_000_000 * k as i64;
    [stamp as f64 / 1e9, f64::from(steer(0.01 * k as f64) as f32)]
}

#[test]
fn every_form_of_a_file_has_the_same_rows_in_the_order_of_their_stamps() {
    for compression in ["", "lz4", "zstd"] {
        for per_chunk in [Some(100), Some(7), None] {
            for has_summary in [true, false] {
                let form = Form { compression, per_chunk, has_summary };
                let (rows, losses) = steering(&write(&messages(), form));
                assert!(losses.is_empty(), "{losses:?}");
                assert_eq!(rows.len(), 1000);
                rows.iter().enumerate().for_each(|(k, row)| assert_eq!(*row, expected(k), "{k}"));
            }
        }
    }
}

#[test]
fn chunks_that_overlap_are_merged() {
    // Topic after topic, and of each every other message first.
    let mut all = messages();
    all.sort_by_key(|m| (m.channel, m.log_time / 1_000_000 % 10));
    let file = write(&all, FORM);
    let (rows, _) = steering(&file);
    assert!(rows.iter().enumerate().all(|(k, row)| *row == expected(k)));
    // By log time, for which nothing is sorted later; the topics advance together.
    let mut log = open(LogFile::of_bytes("drive.mcap", &file), &LogOptions::default()).unwrap();
    let wanted = [0, 1].map(|group| Wanted { group, channels: vec![0] });
    let mut last = [0.0; 2];
    for rows in log.rows(Request { wanted: &wanted, window_s: None, most: 20 }).unwrap() {
        let rows = rows.unwrap();
        for t in &rows.columns.values[0] {
            assert!(*t > last[rows.wanted]);
            last[rows.wanted] = *t;
        }
        assert!(last[0] == 0.0 || last[1] == 0.0 || (last[0] - last[1]).abs() < 0.3);
    }
}

#[test]
fn a_drive_is_that_of_the_same_samples_in_csv() {
    let mut csv = String::from("time_s,steering_tire_angle_rad,heading_yaw_rate_radps,speed_mps\n");
    for k in 0..1000 {
        let ([t, angle], rate) = (expected(k), f64::from(rate(0.01 * k as f64) as f32));
        csv += &format!("{t},{angle},{rate},15\n");
    }
    let read = |name: &str, bytes: &[u8]| {
        let file = LogFile::of_bytes(name, bytes);
        read_drives(vec![file], Vec::new(), &LogOptions::default()).unwrap()
    };
    let [csv, mcap] =
        [read("drive.csv", csv.as_bytes()), read("drive.mcap", &write(&messages(), FORM))];
    assert_eq!((csv.input, csv.output, csv.speed), (mcap.input, mcap.output, mcap.speed));
    assert_eq!(csv.segments, mcap.segments);
}

#[test]
fn types_of_messages_state_roles_and_units() {
    let file = write(&messages(), FORM);
    let found = read(&file);
    let summary = |topic: &str| {
        let group = found.groups.iter().find(|g| g.name == topic).unwrap();
        let channels = group.channels.iter();
        let channels: Vec<String> = channels
            .map(|c| {
                let unit = c.unit.as_deref().unwrap_or("?");
                format!("{} {unit} {}", c.name, c.candidate_for.join(" "))
            })
            .collect();
        (group.rows, group.clock.clone().unwrap(), channels[2..].to_vec())
    };
    let fields = ["stamp s ", "steering_tire_angle rad steering"].map(String::from).to_vec();
    assert_eq!(summary("/steering"), (1000, "stamp".into(), fields));
    let fields = [
        "header.stamp s ",
        "longitudinal_velocity m/s speed",
        "lateral_velocity m/s ",
        "heading_rate rad/s yaw rate",
    ];
    let clock = String::from("header.stamp");
    assert_eq!(summary("/velocity"), (1000, clock.clone(), fields.map(String::from).to_vec()));
    assert_eq!(summary("/camera"), (20, clock, vec!["header.stamp s ".into()]));
    assert_eq!(summary("/other").0, 20);
    assert_eq!(found.losses, ["drive.mcap:/other: messages in protobuf are not read"]);
    let log = read_drives(
        vec![LogFile::of_bytes("drive.mcap", &file)],
        Vec::new(),
        &LogOptions::default(),
    );
    let log = log.unwrap();
    assert!(log.speed.is_some() && log.warnings.iter().all(|w| !w.contains("protobuf")));
    // The log time is a clock for those who ask for it.
    let options = LogOptions { time: Some("log_time".into()), ..LogOptions::default() };
    let log = inspect(LogFile::of_bytes("drive.mcap", &file), &options).unwrap();
    assert_eq!(log.groups[0].clock.as_deref(), Some("log_time"));
    // A stamp that was never set is no clock.
    let mut unset = messages();
    unset.iter_mut().filter(|m| m.channel == 1).for_each(|m| m.data[4..12].fill(0));
    assert_eq!(read(&write(&unset, FORM)).groups[0].clock.as_deref(), Some("log_time"));
}

#[test]
fn a_role_of_several_topics_is_named_with_its_topic() {
    let mut all = messages();
    let imu = (0..1000).map(|k| {
        let log_time = START + 10_000_000 * k;
        let mut data = cdr(log_time, true, &[]);
        let rates = [0.0, 0.0, rate(0.01 * k as f64)].map(f64::to_le_bytes);
        data.extend(rates.concat());
        Message { channel: 5, log_time, data }
    });
    all.extend(imu);
    let file = write(&all, FORM);
    let read = |output: Option<&str>| {
        let options = LogOptions { output: output.map(Into::into), ..LogOptions::default() };
        read_drives(vec![LogFile::of_bytes("drive.mcap", &file)], Vec::new(), &options)
    };
    let error = read(None).unwrap_err();
    let text = error.to_string();
    let both = "several could be (/velocity.heading_rate, /imu/data.angular_velocity.z)";
    assert!(text.contains(both) && error.hint().contains("name the channel"), "{text}");
    for name in
        ["/imu/data.angular_velocity.z", "/imu/data/angular_velocity/z", "/velocity/heading_rate"]
    {
        let log = read(Some(name)).unwrap();
        let column = log.channels[1].column.replace('.', "/");
        assert!(name.replace('.', "/").ends_with(&column), "{name}: {column}");
    }
}

/// Bytes that count how many are read.
struct Counted(Vec<u8>, Arc<AtomicU64>);

impl ReadAt for Counted {
    fn size(&self) -> std::io::Result<u64> {
        self.0.size()
    }

    fn read_at(&self, buffer: &mut [u8], offset: u64) -> std::io::Result<usize> {
        let count = self.0.read_at(buffer, offset)?;
        self.1.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

#[test]
fn only_the_chunks_of_a_topic_and_a_window_are_read() {
    let mut all = messages();
    // Ten minutes, so that a window with its surroundings is a small part.
    for m in &mut all {
        let since = m.log_time - START;
        let late = if since % 10_000_000 == 1_000_000 { 1_000_000 } else { 12_000_000 };
        let k = (since - late) / 10_000_000;
        m.log_time = START + 600_000_000 * k + late;
        let stamp = START + 600_000_000 * k;
        if m.channel < 4 {
            let (s, ns) = ((stamp / 1_000_000_000) as u32, (stamp % 1_000_000_000) as u32);
            m.data[4..12].copy_from_slice(&[s.to_le_bytes(), ns.to_le_bytes()].concat());
        }
    }
    let file = write(&all, Form { compression: "", per_chunk: Some(20), has_summary: true });
    let size = file.len() as u64;
    let count = Arc::new(AtomicU64::new(0));
    let log = LogFile::of_file("drive.mcap", Counted(file, Arc::clone(&count)));
    let mut log = open(log, &LogOptions::default()).unwrap();
    assert!(count.load(Ordering::Relaxed) < size, "{count:?} of {size}");
    let start = START as f64 / 1e9;
    assert_eq!(log.groups()[0].rows, Some(1000));
    let (from, to) = log.groups()[0].span_s.unwrap();
    assert!((from - start).abs() < 0.7 && (to - start - 599.4).abs() < 0.7, "{from} {to}");
    count.store(0, Ordering::Relaxed);
    let wanted = [Wanted { group: 0, channels: vec![2, 3] }];
    let window_s = Some((start + 300.0, start + 330.0));
    let rows = log.rows(Request { wanted: &wanted, window_s, most: 1000 }).unwrap();
    let times: Vec<f64> = rows.flat_map(|rows| rows.unwrap().columns.values[0].clone()).collect();
    let within = times.iter().filter(|t| (start + 300.0..=start + 330.0).contains(*t)).count();
    assert_eq!(within, 51);
    assert!(count.load(Ordering::Relaxed) * 4 < size, "{count:?} of {size}");
}

#[test]
fn what_can_be_read_of_a_damaged_file_is_read() {
    for compression in ["", "lz4", "zstd"] {
        let file = write(&messages(), Form { compression, ..FORM });
        let whole = write(&messages(), Form { compression, has_summary: false, ..FORM });
        // A bit: of one chunk at most nothing is read, and no value is wrong.
        for file in [&file, &whole] {
            let mut with_loss = 0;
            for at in (file.len() / 4..file.len() * 3 / 4).step_by(file.len() / 40) {
                let mut file = file.clone();
                file[at] ^= 4;
                let (rows, losses) = steering(&file);
                assert!((900..=1000).contains(&rows.len()), "{compression}: {}", rows.len());
                // Times in a chunk's head are not in its checksum, and not needed.
                assert!(rows.len() == 1000 || losses.iter().any(|loss| loss.contains("byte")));
                assert!(rows.iter().all(|row| (0..1000).any(|k| expected(k) == *row)));
                with_loss += usize::from(!losses.is_empty());
            }
            assert!(with_loss > 15, "{compression}: {with_loss}");
        }
        // The end is missing.
        {
            let cut = &whole[..whole.len() * 2 / 3];
            let (rows, losses) = steering(cut);
            assert!((550..750).contains(&rows.len()), "{compression}: {}", rows.len());
            assert!(losses.len() == 1 && losses[0].contains("cut off"), "{losses:?}");
        }
        // Bytes that belong to nothing.
        let at = whole.len() / 2;
        let file = [&whole[..at], &[0xEE; 300], &whole[at..]].concat();
        let (rows, losses) = steering(&file);
        assert!(
            rows.len() > 900 && !losses.is_empty(),
            "{compression}: {}, {losses:?}",
            rows.len()
        );
    }
    let file = write(&messages(), Form { per_chunk: None, has_summary: false, ..FORM });
    let at = file.len() / 2;
    let file = [&file[..at], &[0xEE; 300], &file[at..]].concat();
    let (rows, losses) = steering(&file);
    assert!(rows.len() >= 998 && losses.len() == 1, "{}, {losses:?}", rows.len());
    let none = open(LogFile::of_bytes("drive.mcap", MAGIC), &LogOptions::default());
    assert!(matches!(none.err(), Some(Error::Read { .. })));
    // A message that is shorter than its type.
    let mut short = messages();
    short[0].data.truncate(13);
    let (rows, losses) = steering(&write(&short, FORM));
    assert!(rows.len() == 999 && losses[0].contains("shorter than their type"), "{losses:?}");
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(
        changes in proptest::collection::vec((0_usize..1_000_000, any::<u8>()), 0..20),
        cut in 0_usize..1_000_000, splice: Option<(usize, usize)>, form in 0_usize..6,
    ) {
        let compression = ["", "lz4", "zstd"][form % 3];
        let mut messages = messages();
        messages.truncate(200);
        let form = Form { compression, per_chunk: (form != 0).then_some(50), has_summary: form < 4 };
        let mut bytes = write(&messages, form);
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        if let Some((from, to)) = splice {
            let (from, to) = (from % bytes.len(), to % bytes.len());
            let part = bytes[from.min(to)..from.max(to)].to_vec();
            bytes.splice(to..to, part);
        }
        if cut % 3 == 0 {
            bytes.truncate(cut % bytes.len());
        }
        let _ = inspect(LogFile::of_bytes("drive.mcap", &bytes), &LogOptions::default());
    }
}
