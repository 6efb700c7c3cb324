//! Tables and buses as other tools write them: each is read as the plain one, or refused with its reason.

use super::{csv, good_row, rate, read_one, refused, steer};
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, Error, Inspection, LogFile, LogOptions, inspect, read_log};

fn o() -> LogOptions {
    LogOptions::default()
}

fn inspected(name: &str, bytes: impl AsRef<[u8]>, options: &LogOptions) -> Inspection {
    inspect(LogFile::of_bytes(name, bytes.as_ref()), options).unwrap()
}

/// A table with these units in its header and its numbers in them.
fn table(units: [&str; 4], scales: [f64; 4]) -> Vec<u8> {
    let [t, s, r, v] = units;
    let header = format!("time [{t}],roadwheel_angle [{s}],yaw_rate [{r}],speed [{v}]");
    csv(&header, 1000, |k| {
        let time = 0.01 * k as f64;
        let values = [time, steer(time), rate(time), 15.0];
        let cells: Vec<String> =
            values.iter().zip(scales).map(|(x, scale)| format!("{:.9}", x / scale)).collect();
        cells.join(",")
    })
}

fn is_plain(log: &DriveLog) {
    let plain = read_one(csv(super::HEADER, 1000, good_row), &o()).unwrap();
    assert_eq!(log.len(), plain.len());
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(&log.input, &plain.input) && close(&log.output, &plain.output));
    assert!(close(log.speed.as_ref().unwrap(), plain.speed.as_ref().unwrap()));
}

#[test]
fn units_of_other_tools() {
    let deg = 1_f64.to_radians();
    let (kmh, knots) = (1.0 / 3.6, 1852.0 / 3600.0);
    for (units, scales) in [
        (["s", "deg", "1/s", "km/h"], [1.0, deg, 1.0, kmh]),
        (["s", "deg", "deg s^-1", "m s-1"], [1.0, deg, deg, 1.0]),
        (["s", "deg", "deg.s-1", "km/hr"], [1.0, deg, deg, kmh]),
        (["s", "degrees", "degrees/s", "km/h"], [1.0, deg, deg, kmh]),
        (["s", "Grad", "Grad/s", "km/h"], [1.0, deg, deg, kmh]),
        (["μs", "mrad", "deg/s", "knots"], [1e-6, 1e-3, deg, knots]),
        (["s", "Â°", "Â°/s", "mph"], [1.0, deg, deg, 0.447_04]),
        (["s", "º", "˚/s", "kph"], [1.0, deg, deg, kmh]),
    ] {
        let log = read_one(table(units, scales), &o());
        is_plain(&log.unwrap_or_else(|e| panic!("{units:?}: {e}")));
    }
}

#[test]
fn an_unknown_unit_is_named_and_no_other_is_proposed() {
    for (units, unknown) in [
        (["furlongs", "rad", "rad/s", "m/s"], "furlongs"),
        (["s", "turns", "rad/s", "m/s"], "turns"),
        (["s", "rad", "turns/s", "m/s"], "turns/s"),
        // Without a speed the model would be one of a standstill.
        (["s", "rad", "rad/s", "furlongs/h"], "furlongs/h"),
    ] {
        let e = refused(table(units, [1.0; 4]), &o());
        assert!(matches!(e, Error::UnknownUnit { ref unit, .. } if unit == unknown), "{e:?}");
        assert_eq!(e.suggested_unit(), None);
        assert!(e.hint().starts_with("known units: "), "{}", e.hint());
    }
    // Another column with a known unit serves, and parentheses may be part of a name.
    let two = csv("time_s,steer [turns],steering [rad],yaw_rate_radps", 1000, |k| {
        let t = 0.01 * k as f64;
        format!("{t:.2},0,{:.9},{:.9}", steer(t), rate(t))
    });
    assert!(read_one(two, &o()).is_ok());
    let name = csv("time_s,steer (front),yaw_rate_radps", 1000, |k| good_row(k)[..14].into());
    assert!(matches!(refused(name, &o()), Error::UnitNotStated { .. }));
}

#[test]
fn missing_values_of_other_tools() {
    for marker in [
        "-",
        "--",
        "?",
        "#N/A",
        "#NV",
        "#DIV/0!",
        "N/A",
        "None",
        "null",
        "inf",
        "-Inf",
        "1.#QNAN",
        "-1.#IND",
        "-nan(ind)",
        "-NaN",
        "",
    ] {
        let text = csv(super::HEADER, 1000, |k| {
            let row = good_row(k);
            let cells: Vec<&str> = row.split(',').collect();
            if k == 500 { [cells[0], cells[1], marker, cells[3]].join(",") } else { row }
        });
        let found = inspected("a.csv", &text, &o());
        let values: Vec<usize> = found.groups[0].channels.iter().map(|c| c.values).collect();
        assert_eq!(values, [1000, 1000, 999, 1000], "{marker}");
        let log = read_one(text, &o()).unwrap_or_else(|e| panic!("{marker}: {e}"));
        assert!(log.warnings.iter().any(|w| w.contains("1 sample (lines 502)")), "{marker}");
    }
}

#[test]
fn a_first_cell_that_looks_like_a_comment_is_a_cell() {
    for (marker, rows) in [
        ("#N/A", 1000),
        ("#NV", 1000),
        ("#DIV/0!", 1000),
        ("#n/a ", 1000),
        ("\"#N/A\"", 1000),
        ("%", 1000),
        ("# note", 500),
        ("#", 500),
        ("% note", 500),
        ("// note", 500),
    ] {
        let header = format!("note,{}", super::HEADER);
        let text = csv(&header, 1000, |k| {
            format!("{},{}", if k % 2 == 1 { marker } else { "1.0" }, good_row(k))
        });
        let options = LogOptions { units: super::units(&[("note", "1")]), ..o() };
        let found = inspected("a.csv", &text, &options);
        assert_eq!(found.groups[0].rows, rows, "{marker}: {:?}", found.losses);
    }
}

#[test]
fn short_rows_and_ends_of_files() {
    let text = String::from_utf8(csv(super::HEADER, 1000, good_row)).unwrap();
    // Rows that end at their last value.
    let sparse = text.replacen(super::HEADER, &format!("{},brake_bar,gear", super::HEADER), 1);
    let found = inspected("a.csv", &sparse, &o());
    assert_eq!((found.groups[0].rows, found.groups[0].channels[4].values), (1000, 0));
    assert!(found.losses[0].contains("1000 rows with fewer cells"), "{:?}", found.losses);
    let log = read_one(sparse.clone().into_bytes(), &o()).unwrap();
    is_plain(&log);
    assert!(log.warnings.iter().any(|w| w.contains("the first at line 2")), "{:?}", log.warnings);
    for (end, is_read) in [
        ("10.00,0.01,0.1,15.0\n", true),
        ("10.00,0.01,0.1,15.0", true),
        ("10.00,0.01\n", true),
        // The cell may be cut.
        ("10.00,0.1", false),
        ("10.0", false),
        ("10.00,0.01,0.1,15.0,7,7", false),
        ("End of file,,,\n", false),
        ("End of file\n\n", false),
        ("10.00,0.01,x,15\n# the end\n", true),
        ("10.00,0.01,0.1,x", false),
    ] {
        let found = inspected("a.csv", format!("{text}{end}"), &o());
        assert_eq!(found.groups[0].rows, 1000 + usize::from(is_read), "{end:?}");
        let is_reported = found.losses.iter().any(|loss| loss.contains("last row is not read"));
        assert_eq!(is_reported, !is_read, "{end:?}: {:?}", found.losses);
        assert!(read_one(format!("{text}{end}").into_bytes(), &o()).is_ok(), "{end:?}");
    }
    // The same fault above the last row is an error.
    let within = text.replacen("\n0.50,", "\nEnd of file,", 1).into_bytes();
    assert!(matches!(refused(within, &o()), Error::NotANumber { .. }));
}

const DBC: &str = "BO_ 37 STEER: 8 X\n SG_ ANGLE : 0|16@1- (0.001,0) [0|0] \"deg\" X\n";

fn with(dbc: &str) -> LogOptions {
    LogOptions { dbc: vec![("a.dbc".into(), dbc.into())], ..o() }
}

/// The number of frames and the last instant, s.
fn frames(text: &str) -> (usize, f64, Vec<String>) {
    let found = inspected("a.log", text, &with(DBC));
    (found.groups[0].rows, found.groups[0].span_s.unwrap()[1], found.losses)
}

#[test]
fn requests_are_counted_once_and_differences_are_added_up() {
    let lines = |line: &dyn Fn(f64) -> String| -> String {
        (0..100).map(|k| line(0.01 * f64::from(k))).collect()
    };
    let asc = |ways: &[&str]| {
        let line = |t: f64| -> String {
            ways.iter().map(|way| format!("{t:.3} 1 25 {way} d 2 49 03\n")).collect()
        };
        frames(&format!("base hex timestamps absolute\n{}", lines(&line)))
    };
    let (rows, _, losses) = asc(&["TxRq", "Tx"]);
    assert_eq!(rows, 100);
    assert!(losses[0].contains("100 requests (TxRq)"), "{losses:?}");
    // Requests alone are what there is.
    let (rows, _, losses) = asc(&["TxRq"]);
    assert_eq!((rows, losses), (100, vec![]));
    let (rows, last, losses) = frames(&format!(
        " (000.000000)  can0  025   [2]  49 03\n{}",
        " (000.002000)  can0  026   [2]  49 03\n (000.008000)  can0  025   [2]  49 03\n".repeat(99)
    ));
    assert_eq!(rows, 100);
    assert!((last - 0.99).abs() < 1e-9, "{last}");
    assert!(losses[0].contains("candump -t d"), "{losses:?}");
    // Frames that are logged in batches share an instant.
    let batch = |t: f64| format!("({t:.6}) can0 025#4903\n").repeat(5);
    let (rows, last, losses) = frames(&lines(&batch));
    assert_eq!((rows, losses), (500, vec![]));
    assert!((last - 0.99).abs() < 1e-9, "{last}");
    // Times from the start (-t z) are instants.
    let (_, last, losses) = frames(&lines(&|t| format!(" ({t:010.6})  can0  025   [2]  49 03\n")));
    assert!((last - 0.99).abs() < 1e-9 && losses.is_empty(), "{last} {losses:?}");
    let bare = "  can0  025   [2]  49 03\n".repeat(20);
    let e = inspect(LogFile::of_bytes("a.log", bare.as_bytes()), &with(DBC)).unwrap_err();
    assert!(matches!(e, Error::FramesWithoutTime { .. }) && e.hint().contains("-ta or"), "{e:?}");
}

#[test]
fn faults_of_a_database_are_reported_where_nothing_matches() {
    let text = b"(1.0) can0 123#00\n(1.1) can0 124#00\n";
    let e = inspect(LogFile::of_bytes("a.log", text), &with("BO_ five OTHER: 8 X\n")).unwrap_err();
    assert!(e.to_string().contains("a.dbc:1: not understood: BO_ five"), "{e}");
}

#[test]
fn foreign_formats_are_named_with_what_reads_them() {
    let workbook =
        b"PK\x03\x04\x14\0\0\0\x08\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x10\0\0\0docProps/app.xml";
    for (bytes, name, help) in [
        (&b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08"[..], "HDF5", "h5py"),
        (b"\xd4\xc3\xb2\xa1\x02\0\x04\0", "pcap", "candump -L"),
        (b"\x0a\x0d\x0d\x0a\x1c\0\0\0", "pcapng", "Wireshark"),
        (workbook, "Excel", "CSV"),
        (b"PK\x03\x04\x14\0\0\0\x08\0a.csv", "ZIP", "decompress"),
        (b"LOGG\x90\0\0\0", "BLF", "[logs]"),
        (b"MATLAB 5.0 MAT-file, Platform", "MAT", "[logs]"),
        (b"#ROSBAG V2.0\n", "ROS 1", "[logs]"),
        (b"SQLite format 3\0", "SQLite", "[logs]"),
        (b"FEA1\0\0\0\0", "Feather of the first version", "Parquet"),
    ] {
        let e = refused(bytes.to_vec(), &o());
        assert!(matches!(e, Error::OtherFormat { .. }), "{name}: {e:?}");
        assert!(e.to_string().contains(name) && e.hint().contains(help), "{e} {}", e.hint());
    }
}

/// A deflate stream that ends early is reported, though each row lacks the last cells of the header.
#[test]
fn a_cut_stream_with_short_rows_is_reported() {
    let mut text = String::from("time_s,steer_rad,yaw_rate_radps,speed_mps,gap,note\n");
    for k in 0..40_000 {
        let t = 0.01 * f64::from(k);
        let _ = writeln!(
            text,
            "{t:.2},{:.6},{:.6},{:.3}",
            0.03 * t.sin(),
            0.2 * t.cos(),
            15.0 + (0.37 * t).sin()
        );
    }
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut packed, text.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    let cut = packed[..2 * packed.len() / 3].to_vec();
    let options = LogOptions { steering_ratio: Some(1.0), ..LogOptions::default() };
    match read_log(&[("a.csv.gz".into(), cut)], &options) {
        Ok(log) => {
            assert!(log.warnings.iter().any(|w| w.contains("deflate")), "{:?}", log.warnings)
        }
        Err(error) => assert!(error.to_string().contains("deflate"), "{error}"),
    }
}

#[test]
fn race_capture_states_units_within_its_names() {
    let mut text = String::from(
        "\"Interval\"|\"ms\"|0|0|1,\"Utc\"|\"ms\"|0|0|1,\"Steering\"|\"Deg\"|-360.0|360.0|50,\"YawRate\"|\"Deg/s\"|0.0|0.0|50,\"Speed\"|\"km/h\"|0.0|150.0|10\n",
    );
    for k in 0..300 {
        let t = 0.01 * f64::from(k);
        let speed = if k % 5 == 0 { "54.0" } else { "" };
        let _ = writeln!(
            text,
            "{},{},{:.3},{:.3},{speed}",
            402 + 10 * k,
            1_700_000_000_000_i64,
            steer(t),
            rate(t)
        );
    }
    let found = inspected("a.log", &text, &o());
    assert_eq!(found.groups[0].clock.as_deref(), Some("Interval"), "{:?}", found.losses);
    assert_eq!(found.groups[0].rate_hz, Some(100.0));
    let channels: Vec<(&str, &str, usize)> = found.groups[0]
        .channels
        .iter()
        .skip(2)
        .map(|c| (c.name.as_str(), c.unit.as_deref().unwrap(), c.values))
        .collect();
    assert_eq!(
        channels,
        [("Steering", "deg", 300), ("YawRate", "deg/s", 300), ("Speed", "km/h", 60)]
    );
}

#[test]
fn exports_with_texts_in_quotes_and_blank_lines_below_the_units() {
    let row = |k: u32| {
        let t = 0.01 * f64::from(k);
        let cells = [t, steer(t).to_degrees(), rate(t).to_degrees(), 54.0];
        cells.map(|x| format!("\"{x:.6}\"")).join(",") + "\n"
    };
    let rows: String = (0..1000).map(row).collect();
    let wheel = LogOptions { steering_ratio: Some(1.0), ..o() };
    let names =
        "\"Time\",\"Steering Angle\",\"YawRate\",\"Speed\"\n\"s\",\"deg\",\"deg/s\",\"km/h\"\n\n\n";
    let aim = format!(
        "\"Format\",\"AIM CSV File\"\n\"Date\",\"Monday, May 5, 2025\"\n\"Sample Rate\",\"100\"\n\"Beacon Markers\",\"1.2 2.3\"\n\n{names}{rows}"
    );
    is_plain(&read_one(aim.clone().into_bytes(), &wheel).unwrap());
    // DEWESoft.
    let plain = format!(
        "Data info\nFile name,test.dxd\nSample rate,100 Hz\n\nData1\nTime (s),Steering Angle (deg),Yaw Rate (deg/s),Speed (km/h)\n{rows}"
    );
    is_plain(&read_one(plain.replace('"', "").replace(',', "\t").into_bytes(), &wheel).unwrap());
}
