//! Tables with text above the header, with a header in a comment, or without one.

use super::{csv, good_row, rate, read_one, refused, steer};
use std::fmt::Write;
use steerwright_drivelog::{DriveLog, Error, Inspection, LogFile, LogOptions, inspect};

fn o() -> LogOptions {
    LogOptions::default()
}

fn inspected(text: &str, options: &LogOptions) -> Inspection {
    inspect(LogFile::of_bytes("drive.csv", text.as_bytes()), options).unwrap()
}

/// Rows of time, steering in deg, yaw rate in deg/s and speed in km/h.
fn body(delimiter: &str) -> String {
    let mut text = String::new();
    for k in 0..1000 {
        let t = 0.01 * f64::from(k);
        let cells = [t, steer(t).to_degrees(), rate(t).to_degrees(), 54.0];
        let _ = writeln!(text, "{}", cells.map(|x| format!("{x:.9}")).join(delimiter));
    }
    text
}

fn is_plain(text: String, options: &LogOptions) -> DriveLog {
    let first = text.lines().take(3).collect::<Vec<_>>().join(" / ");
    let log = read_one(text.into_bytes(), options).unwrap_or_else(|e| panic!("{first}: {e}"));
    let plain = read_one(csv(super::HEADER, 1000, good_row), &o()).unwrap();
    assert_eq!(log.len(), plain.len(), "{first}");
    let is_close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(is_close(&log.input, &plain.input), "{first}");
    assert!(is_close(&log.output, &plain.output), "{first}");
    assert!(is_close(log.speed.as_ref().unwrap(), plain.speed.as_ref().unwrap()), "{first}");
    log
}

#[test]
fn the_header_stands_above_the_numbers() {
    let wheel = LogOptions { steering_ratio: Some(1.0), ..o() };
    let names = "Time,Steered Angle,Gyro Yaw Velocity,Ground Speed";
    let motec = format!(
        "\"Format\",\"MoTeC CSV File\",,,\"Workbook\",\"\"\n\"Sample Rate\",\"100.000\",\"Hz\",\"\",\"End Time\",\"29.990\",\"s\"\n\n{names}\ns,deg,deg/s,km/h\n\n{}",
        body(",")
    );
    let log = is_plain(motec.clone(), &wheel);
    assert!(log.warnings.iter().any(|w| w.contains("the header is line 4")), "{:?}", log.warnings);
    // RaceChrono: units and sources.
    let sources =
        "timestamp,steering_angle,yaw_rate,speed\nunix time,deg,deg/s,km/h\n,,100: gyro,100: gps";
    is_plain(format!("Created by x\n\nFormat,3\nNote,\n\n{sources}\n{}", body(",")), &wheel);
    let etas = "ETASAsciiItemFile\trecord\tVersion\t1.1\ntabular\ntime\tRoadWheelAngle\tYawRate\tVehicleSpeed\nf8\tf8\tf8\tf8\ns\tdeg\tdeg/s\tkm/h\n";
    is_plain(format!("{etas}{}", body("\t")), &o());
    let labview = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nSamples\t1000\t1000\t1000\t\nY_Unit_Label\tdeg\tdeg/s\tkm/h\t\nX_Dimension\tTime\tTime\tTime\t\nDelta_X\t0.01\t0.01\t0.01\t\n***End_of_Header***\t\t\t\t\nX_Value\tRoadWheelAngle\tYawRate\tVehicleSpeed\tComment\n";
    is_plain(format!("{labview}{}", body("\t")), &o());
    // A table of a German spreadsheet, with remarks as wide as the table.
    let remarks = "Messung;Test 1;Fahrer;Hans\nZeit in s;Radlenkwinkel / Grad;Gierrate in Grad/s;Geschwindigkeit / (km/h)\n";
    is_plain(format!("{remarks}{}", body(";").replace('.', ",")), &o());
    // The line of the header as stated; a line without text is refused.
    let stated = |line| LogOptions { header_line: Some(line), ..wheel.clone() };
    is_plain(motec.clone(), &stated(4));
    let e = refused(motec.clone().into_bytes(), &stated(3));
    assert!(matches!(e, Error::Option { option: "header line", .. }), "{e:?}");
    let e = refused(motec.into_bytes(), &stated(1));
    assert!(e.to_string().contains("MoTeC CSV File"), "{e}");
}

#[test]
fn vbox_counts_minutes_and_times_of_day() {
    let mut text = String::from(
        "File created on 01/02/2024 at 10:00:00\r\n\r\n[header]\r\nsatellites\r\ntime\r\nlatitude\r\nlongitude\r\nvelocity kmh\r\nSteering_Angle\r\nYaw_Rate\r\n\r\n[channel units]\r\ndeg\r\ndeg/s\r\n\r\n[column names]\r\nsats time lat long velocity Steering_Angle Yaw_Rate\r\n\r\n[data]\r\n",
    );
    for k in 0..1000 {
        let t = 0.01 * f64::from(k);
        // A minute begins within.
        let time = if k < 500 { 95_955.0 + t } else { 99_995.0 + t };
        let (angle, rate) = (steer(t).to_degrees(), rate(t).to_degrees());
        let _ = write!(
            text,
            "009 {time:09.2} +03119.09973 -00058.49277 054.000 {angle:+.9} {rate:+.9}\r\n"
        );
    }
    is_plain(text.clone(), &LogOptions { steering_ratio: Some(1.0), ..o() });
    let found = inspected(&text, &o());
    let units = found.groups[0].channels.iter().map(|c| c.unit.as_deref().unwrap_or_default());
    let units: Vec<&str> = units.collect();
    assert_eq!(units, ["", "", "arcmin", "arcmin west", "km/h", "deg", "deg/s"]);
}

#[test]
fn delimiters_of_other_tools() {
    let names = ["time_s", "roadwheel_angle_deg", "yaw_rate_degps", "speed_kmh"];
    for (delimiter, mark) in [("|", ""), (" ", ""), (" ", "# "), ("   ", "#"), ("\t", "")] {
        let header = format!("{mark}{}", names.join(delimiter));
        is_plain(format!("{header}\n{}", body(delimiter)), &o());
    }
    // Blanks at the ends of lines, as tables in columns have them.
    let lines = body("  ").replace('\n', "  \n  ");
    is_plain(format!("  {}\n  {lines}\n", names.join("  ")), &o());
}

#[test]
fn a_table_without_a_header_has_numbered_columns() {
    for text in [body(","), body(" "), body(";").replace('.', ",")] {
        let found = inspected(&text, &o());
        assert_eq!((found.groups[0].rows, &*found.groups[0].channels[1].name), (1000, "column_2"));
        assert!(found.losses[0].contains("no header"), "{:?}", found.losses);
    }
    let stated = LogOptions {
        time: Some("column_1".into()),
        input: Some("column_2".into()),
        output: Some("column_3".into()),
        speed: Some("column_4".into()),
        units: super::units(&[
            ("column_1", "s"),
            ("column_2", "deg"),
            ("column_3", "deg/s"),
            ("column_4", "km/h"),
        ]),
        steering_ratio: Some(1.0),
        ..o()
    };
    is_plain(body(","), &stated);
    // `rostopic echo -p` names the columns in a comment, and one of them holds texts.
    let ros = "%time,field.frame,field.steering_angle,field.yaw_rate\n".to_owned()
        + "1700000000000000000,base,0.1,0.2\n1700000000010000000,base,0.1,0.2\n";
    let found = inspected(&ros, &o());
    assert_eq!((found.groups[0].rows, found.groups[0].clock.as_deref()), (2, Some("time")));
    assert_eq!(found.groups[0].rate_hz, Some(100.0));
}

#[test]
fn a_column_that_nobody_uses_stops_no_read() {
    let more = |name: &str, cell: &str| {
        let body = body(";").replace('\n', &format!(";{cell}\n"));
        format!("time_s;roadwheel_angle_deg;yaw_rate_degps;speed_kmh;{name}\n{body}")
    };
    for (name, cell) in [("rpm", "4,000"), ("speed_kmh [x]", "7"), ("time_s", "1")] {
        let text = more(name, cell);
        let found = inspected(&text, &o());
        assert_eq!(found.groups[0].rows, 1000, "{name}: {:?}", found.losses);
        assert_eq!(found.groups[0].channels.len(), 5);
    }
    is_plain(more("rpm", "4,000"), &o());
    is_plain(more("spare;spare", "0;0"), &o());
    let e = refused(more("yaw_rate_degps", "0").into_bytes(), &o());
    assert!(matches!(e, Error::RepeatedColumn { ref column, .. } if column == "yaw_rate_degps"));
    let grouped = inspected(&more("rpm", "4,000"), &o());
    assert!(grouped.losses[0].contains("`4,000`"), "{:?}", grouped.losses);
}
