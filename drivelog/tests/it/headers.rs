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
    // Zeros that lead are missing, and a channel has no unit.
    let spare = text.replace("Yaw_Rate", "Spare Yaw_Rate").replacen("Spare ", "Spare\r\n", 1);
    let spare = spare.replace("\ndeg\r\n", "\ndeg\r\n\r\n").replace("009 0", "009 ");
    let spare: String = spare
        .lines()
        .map(|line| match line.rsplit_once(' ') {
            Some((row, last)) if line.starts_with("009") => format!("{row} 0 {last}\r\n"),
            _ => format!("{line}\r\n"),
        })
        .collect();
    is_plain(spare.clone(), &LogOptions { steering_ratio: Some(1.0), ..o() });
    let e = refused(spare.replace("009 95959.00", "009 95999.00").into_bytes(), &o());
    assert!(matches!(e, Error::NotATime { .. }), "{e:?}");
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

const NAMES: &str = "time_s,roadwheel_angle_deg,yaw_rate_degps,speed_kmh";

/// The table with further cells in each row.
fn with_cells(names: &str, cells: &str) -> String {
    format!("{NAMES}{names}\n{}", body(",").replace('\n', &format!("{cells}\n")))
}

#[test]
fn texts_with_numbers_do_not_change_the_delimiter() {
    let payloads = ["00 11 22 33 44 55 66 77", "[0. 1. 0. 2. 3. 4. 5. 6.]", "01.03.2024 10:00:00"];
    for cell in ["Lap 3", "turn 3 left", "1;2;3;4;5;6;7;8"].into_iter().chain(payloads) {
        let text = with_cells(",note", &format!(",{cell}"));
        is_plain(text.replace(',', "\t"), &o());
        is_plain(text, &o());
    }
    let german = with_cells(",note", ",00 11 22 33 44 55 66 77").replace(',', ";");
    is_plain(german.replace('.', ","), &o());
    // Blanks with decimal commas, named or not.
    let blanks = body(" ").replace('.', ",");
    is_plain(format!("{}\n{blanks}", NAMES.replace(',', " ")), &o());
    assert_eq!(inspected(&blanks, &o()).groups[0].channels.len(), 4);
}

#[test]
fn names_and_units_may_have_a_gap_between_them() {
    for gap in ["", "\n", "# units\n", ",,,\n"] {
        let names = format!("time,roadwheel_angle,yaw_rate,speed\n{gap}s,deg,deg/s,km/h\n");
        is_plain(format!("{names}{}", body(",")), &o());
    }
}

#[test]
fn a_header_may_have_few_texts() {
    for (names, cells) in [
        (",,,,,,,", ",1.5,1.5,1.5,1.5,1.5,1.5,1.5"),
        (",100,200,300,400,500", ",1,1,1,1,1"),
        (",0,1,2,3,4,5", ",1.5,1.5,1.5,1.5,1.5,1.5"),
    ] {
        let log = is_plain(with_cells(names, cells), &o());
        assert!(log.warnings.iter().all(|w| !w.contains("header")), "{:?}", log.warnings);
        is_plain(format!("Run,Monday\n{}", with_cells(names, cells)), &o());
    }
}

#[test]
fn rows_below_the_names_are_rows_of_values() {
    let states = with_cells(",a,b,c,d,e,f", ",1,1,1,1,1,1");
    let states = states.splitn(300, '\n').collect::<Vec<_>>();
    let (last, first) = states.split_last().unwrap();
    let first = first.join("\n").replace(",1,1,1,1,1,1", ",INIT,INIT,INIT,INIT,INIT,INIT");
    let text = format!("{first}\n{last}");
    is_plain(text.clone(), &o());
    let unknown = format!("a,b,c,d,e,f,g,h,i,j\n{}", text.split_once('\n').unwrap().1);
    for (text, rows) in [
        (unknown, 1000),
        // The first row has texts.
        (format!("a,b,c,d\n0.00,x,y,z\n{}", body(",")), 1001),
        (format!("{NAMES}\n-1,n.v.,n.v.,n.v.\n{}", body(",")), 1001),
    ] {
        let found = inspected(&text, &o());
        assert_eq!(found.groups[0].rows, rows, "{:?}", found.losses);
    }
}

#[test]
fn bad_cells_of_an_optional_column_drop_no_row() {
    let mut k = 0;
    let text = with_cells(",lateral_acceleration_mps2", ",7777.5").replace('\n', "\n%,");
    let text = text.trim_end_matches("%,").lines().map(|line| {
        k += 1;
        if k % 2 == 0 { line.replace(",7777.5", ",x") } else { line.to_owned() }
    });
    is_plain(format!("note,{}", text.collect::<Vec<_>>().join("\n") + "\n"), &o());
}

#[test]
fn rows_between_blanks_are_as_wide_as_the_header() {
    let table = format!("{}\n{}", NAMES.replace(',', "  "), body("  "));
    for (from, to) in
        [("yaw_rate", "spare yaw_rate"), ("  54.000000000\n2.000000000", "\n2.000000000")]
    {
        let e = refused(table.replacen(from, to, 1).into_bytes(), &o());
        assert!(matches!(e, Error::RaggedRow { .. }) && e.hint().contains("NaN"), "{e:?}");
    }
}

#[test]
fn long_texts_above_the_header_are_read() {
    let key = |k: usize| format!("key{k},value {k}\n");
    let plain = format!("\n{NAMES}\n{}", body(","));
    for rows in [900, 3000, 9000] {
        let top: String = (0..rows).map(key).collect();
        is_plain(top + &plain, &o());
    }
    let wide = (0..20_000).map(|k| format!(",c{k}")).collect::<String>();
    let table = body(",");
    let rows = table.lines().take(20).map(|row| format!("{row}{}\n", ",1".repeat(20_000)));
    let text = format!(
        "Format,x\nVenue,x\nVehicle,y\nDriver,z\n\n{NAMES}{wide}\n{}",
        rows.collect::<String>()
    );
    assert_eq!(inspected(&text, &o()).groups[0].channels.len(), 20_004);
    // A row of numbers is no header.
    let line = |n| LogOptions { header_line: Some(n), ..o() };
    let e = refused(plain.clone().into_bytes(), &line(9));
    assert!(matches!(e, Error::Option { option: "header line", .. }), "{e:?}");
    let log = is_plain(format!("a,b,c,d\n1,2,3,4\n{plain}"), &line(4));
    assert!(log.warnings.iter().any(|w| w.contains("2 rows above")), "{:?}", log.warnings);
}

#[test]
fn units_with_blanks_and_repeated_clocks() {
    let names = "time_s,roadwheel angle deg,yaw rate deg / s,speed km / h\n";
    is_plain(format!("{names}{}", body(",")), &o());
    let twice = body(",").lines().map(|row| format!("0,{row}\n")).collect::<String>();
    let e = refused(
        format!("time_s,time_s,utc_time_s,yaw_rate_degps,roadwheel_angle_deg\n{twice}")
            .into_bytes(),
        &o(),
    );
    assert!(matches!(e, Error::RepeatedColumn { .. }), "{e:?}");
}
