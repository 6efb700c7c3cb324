//! Files as further tools write them: what is read of them, at which line a fault is, and what is not read.

use super::{HEADER, csv, good, good_row, rate, read_one, refused, steer};
use steerwright_drivelog::{Error, Inspection, LogFile, LogOptions, inspect};

fn inspected(bytes: impl AsRef<[u8]>, options: &LogOptions) -> Inspection {
    inspect(LogFile::of_bytes("a.csv", bytes.as_ref()), options).unwrap()
}

fn reports(bytes: impl AsRef<[u8]>, part: &str) {
    let losses = inspected(bytes, &LogOptions::default()).losses;
    assert!(losses.iter().any(|loss| loss.contains(part)), "{part}: {losses:?}");
}

fn text_of(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

#[test]
fn a_bad_cell_is_reported_with_its_line_whatever_ends_the_lines() {
    let bad = |k: usize| if k == 7 { "0.07,0.0,abc,15.0".into() } else { good_row(k) };
    let text = text_of(csv(HEADER, 1000, bad));
    for end in ["\n", "\r\n", "\r"] {
        reports(text.replace('\n', end), "a.csv:9: column `yaw_rate_radps`: `abc`");
        // A blank line and comments above the header and above the row.
        let text = text.replace("\n0.07,", "\n\n# a remark\n0.07,");
        let text = format!("# another one\n\n{text}").replace('\n', end);
        reports(text, "a.csv:13: column `yaw_rate_radps`: `abc`");
    }
    let stated = LogOptions { header_line: Some(3), ..LogOptions::default() };
    let text = format!("a\rb\r{}", text_of(good()).replace('\n', "\r"));
    assert_eq!(inspected(text, &stated).groups[0].channels[1].name, "steer_rad");
}

#[test]
fn a_last_cell_that_the_end_of_the_file_cuts_is_not_read() {
    let whole = text_of(csv("time_s,steer_rad,yaw_rate_radps,rpm", 1000, |k| {
        format!("{},1500", good_row(k).rsplit_once(',').unwrap().0)
    }));
    let read = |text: &str| {
        let found = inspected(text, &LogOptions::default());
        let rpm = found.groups[0].channels[3].min;
        (found.groups[0].rows, rpm, found.losses.join("; "))
    };
    assert_eq!(read(&whole), (1000, Some(1500.0), String::new()));
    assert_eq!(read(whole.trim_end()), (1000, Some(1500.0), String::new()));
    for cut in 2..=4 {
        let (rows, least, losses) = read(&whole[..whole.len() - cut]);
        assert_eq!((rows, least), (999, Some(1500.0)));
        assert!(losses.contains("a.csv:1001: the file ends within this line"), "{losses}");
    }
    // The times of the last column.
    let times = text_of(csv("steer_rad,time_ms", 1000, |k| format!("0.1,{}", 10 * k)));
    assert_eq!(inspected(&times[..times.len() - 3], &LogOptions::default()).groups[0].rows, 999);
}

#[test]
fn texts_above_the_numbers_of_a_column_make_it_no_text() {
    let late = |texts: usize| {
        csv(HEADER, 4000, |k| {
            let row = good_row(k);
            let (rest, _) = row.rsplit_once(',').unwrap();
            if k < texts { format!("{rest},init") } else { row }
        })
    };
    let found = inspected(late(250), &LogOptions::default());
    assert_eq!(found.groups[0].channels[3].values, 3750, "{:?}", found.losses);
    reports(late(250), "250 of 4000 rows");
    // Where the first 64 KiB have none, they are counted.
    reports(late(3990), "column `speed_mps` is read as text by its first rows: 10 numbers");
    let log = read_one(late(3990), &LogOptions::default()).unwrap();
    assert!(log.warnings.iter().any(|w| w.contains("10 numbers")), "{:?}", log.warnings);
}

#[test]
fn numbers_with_the_sign_of_a_typesetter_are_read() {
    let text = text_of(good());
    let found = inspected(text.replace(",-", ",−"), &LogOptions::default());
    assert_eq!(found.groups, inspected(text, &LogOptions::default()).groups);
    assert_eq!(found.losses, Vec::<String>::new());
}

#[test]
fn a_name_of_several_lines_is_typed_in_one() {
    let header = "time_s,\"roadwheel\nangle [rad]\",\"yaw rate\r\n[rad/s]\",\"speed \n\n[m/s]\"";
    let text = csv(header, 1000, good_row);
    let options = LogOptions {
        input: Some("roadwheel angle".into()),
        output: Some("yaw rate [rad/s]".into()),
        ..LogOptions::default()
    };
    assert_eq!(
        read_one(text, &options).unwrap().len(),
        read_one(good(), &LogOptions::default()).unwrap().len()
    );
}

#[test]
fn clocks_of_further_tools() {
    let row = |k: usize| format!("{:.2},{},{},15", 0.01 * k as f64, steer(0.01), rate(0.01));
    for (header, clock) in [
        ("__time,steer_rad,yaw_rate_radps,speed_mps", "__time"),
        ("xAxis,steer,yaw_rate,speed\ns,rad,rad/s,m/s", "xAxis"),
    ] {
        let found = inspected(csv(header, 500, row), &LogOptions::default());
        assert_eq!(found.groups[0].clock.as_deref(), Some(clock));
        assert_eq!(found.groups[0].rate_hz, Some(100.0));
    }
    // LabVIEW without values of x, which is no clock.
    let row = |k: usize| row(k).replacen(|c: char| c != ',', "", 4);
    let found = inspected(
        csv("X_Value,steer_rad,yaw_rate_radps,speed_mps", 500, row),
        &LogOptions::default(),
    );
    let group = &found.groups[0];
    let hint = group.no_clock.as_deref().unwrap_or_default();
    assert!(group.clock.is_none() && hint.contains("time between rows"), "{hint}");
}

#[test]
fn a_clock_that_falls_is_reported() {
    let joined = csv(HEADER, 1000, |k| good_row(k % 600));
    reports(joined, "1 row with a time before that of the row above, the first 0 s after 5.99 s");
}

#[test]
fn a_table_of_frames_that_is_not_read_as_such_is_reported() {
    let bus = |k: usize| format!("{:.3};x;25;49 03 20 41", 0.01 * k as f64);
    let part = "no frames of a bus are recognised";
    reports(csv("Time [s];Name;ID;Data", 100, bus), part);
    // Known columns, whose identifiers are 25 or 0x25.
    let bus = |k: usize| format!("{:.3};1;25;4;49 03 20 41", 0.01 * k as f64);
    let error = refused(csv("Time [s];Channel;ID;DLC;Data", 100, bus), &LogOptions::default());
    assert!(error.to_string().contains("the base of the identifiers is open"), "{error}");
    // A dialect that is not known, with a database.
    let text = "<1.5> can0 25 49\n<1.6> can0 25 48\n<1.7> can0 25 47\n".repeat(20);
    let dbc = vec![("a.dbc".into(), b"BO_ 37 A: 8 X\n".to_vec())];
    let losses = inspected(&text, &LogOptions { dbc, ..LogOptions::default() }).losses;
    assert!(losses.iter().any(|loss| loss.contains(part)), "{losses:?}");
    assert!(
        !inspected(&text, &LogOptions::default()).losses.iter().any(|loss| loss.contains(part))
    );
    // A bus of another kind.
    let lin = "date Thu Feb 1\nbase hex  timestamps absolute\n0.5 Li 25 Rx 2 49 03 checksum = 70\n";
    let error = refused(lin.repeat(2).into_bytes(), &LogOptions::default());
    assert!(matches!(error, Error::NoFrames { .. }), "{error:?}");
}

#[test]
fn databases_that_no_log_uses_are_reported() {
    let dbc = || {
        vec![("car.dbc".into(), b"BO_ 37 A: 8 X\n SG_ B : 0|8@1+ (1,0) [0|0] \"\" X\n".to_vec())]
    };
    let options = || LogOptions { dbc: dbc(), ..LogOptions::default() };
    let part = "car.dbc: not used";
    let losses = inspected(good(), &options()).losses;
    assert!(losses.iter().any(|loss| loss.contains(part)), "{losses:?}");
    let warnings = read_one(good(), &options()).unwrap().warnings;
    assert!(warnings.iter().any(|warning| warning.contains(part)), "{warnings:?}");
    let losses = inspected("(1.0) can0 025#01\n(1.1) can0 025#02\n", &options()).losses;
    assert_eq!(losses, Vec::<String>::new());
    // Frames in a form that is not read.
    reports(
        "time,address,bus,data\n0.0,37,0,4a03\n0.1,37,0,4903\n",
        "no frames of a bus are recognised",
    );
}

#[test]
fn a_column_of_texts_with_the_name_of_the_steering_is_named() {
    let text = csv(HEADER, 1000, |k| good_row(k).replacen(',', ",left ", 1));
    let error = refused(text.clone(), &LogOptions::default());
    assert!(error.to_string().contains("`steer_rad` holds texts"), "{error}");
    let channels = &inspected(text, &LogOptions::default()).groups[0].channels;
    assert_eq!((channels[1].unit.as_deref(), channels[1].values), (Some("text"), 0));
}

#[test]
fn the_speed_of_a_gnss_receiver_is_taken_where_no_other_one_is_there() {
    let columns = |names: &str| {
        let header = format!("time_s,steer_rad,yaw_rate_radps,{names}");
        let row = |k: usize| format!("{},14.0", good_row(k));
        read_one(csv(&header, 1000, row), &LogOptions::default()).unwrap()
    };
    let speed = |names: &str| columns(names).speed.map(|speed| speed[0].round());
    assert_eq!(speed("rpm,GPS Speed [m/s]"), Some(14.0));
    assert_eq!(speed("speed_mps,GPS Speed [m/s]"), Some(15.0));
    assert_eq!(speed("GPS Speed [m/s],vehicle_speed_mps"), Some(14.0));
}

#[test]
fn numbers_of_fortran_are_read() {
    let digits = |number: f64| format!("{number:.9E}").replace('E', "D");
    let text = csv(HEADER, 1000, |k| {
        let t = 0.01 * k as f64;
        [t, steer(t), rate(t), 15.0].map(digits).join(",")
    });
    let found = inspected(&text, &LogOptions::default());
    assert_eq!(found.groups[0].span_s, Some([0.0, 9.99]));
    let plain = read_one(good(), &LogOptions::default()).unwrap();
    let log = read_one(text, &LogOptions::default()).unwrap();
    assert!(log.input.iter().zip(&plain.input).all(|(a, b)| (a - b).abs() < 1e-6));
    // Letters that are no power of ten.
    reports(text_of(good()).replacen(",15.0", ",1D5", 1), "`1D5` is not a number");
}

#[test]
fn fields_of_messages_in_a_table_are_named_like_the_quantity() {
    for message in ["field", "value", "car"] {
        let header = format!(
            "time_s,{message}.steering_angle_rad,{message}.yaw_rate_radps,{message}.speed_mps"
        );
        let log = read_one(csv(&header, 1000, good_row), &LogOptions::default()).unwrap();
        assert!(log.speed.is_some(), "{message}");
    }
    let other = csv("time_s,steering_angle_rad,yaw_rate_radps,motor.speed_mps", 1000, good_row);
    assert!(read_one(other, &LogOptions::default()).unwrap().speed.is_none());
}

#[test]
fn texts_that_are_no_tables_are_named() {
    let ulog = "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nIMU, 1, 0.5\n";
    let utf_32: Vec<u8> =
        "\u{feff}time_s,x\n0,1\n".chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
    for (text, name, help) in [
        (b"<?xml version=\"1.0\"?>\n<gpx><trk></trk></gpx>".to_vec(), "GPX", "gpsbabel"),
        (b"\n<!DOCTYPE html>\n<html><p>404, none</p></html>".to_vec(), "HTML", "download"),
        (b"<?xml version=\"1.0\"?><Workbook><Row>1</Row></Workbook>".to_vec(), "XML", "CSV"),
        (b"header:\n  stamp:\n    sec: 1\nx: 0.5\n---\n".to_vec(), "ros2 topic echo", "--csv"),
        (ulog.into(), "ArduPilot", "mavlogdump"),
        (b"\xa3\x95\x80\x80\x59FMT\0BBnNZ\0".to_vec(), "ArduPilot", "mavlogdump"),
        (utf_32, "UTF-32", "iconv"),
    ] {
        let error = refused(text, &LogOptions::default());
        assert!(matches!(error, Error::OtherFormat { .. }), "{name}: {error:?}");
        assert!(error.to_string().contains(name) && error.hint().contains(help), "{error}");
    }
}
