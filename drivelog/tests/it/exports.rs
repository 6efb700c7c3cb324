//! Logs as the field's tools export them: each is read as the same drive as in plain CSV, or rejected with a
//! hint at the missing statement.

use super::{good, rate, read_one, refused, steer, units};
use proptest::prelude::*;
use std::fmt::Write;
use steerwright_drivelog::{
    DecimalMark, DriveLog, Error, Intersample, LogFile, LogOptions, inspect,
};

/// A drive of 10 s at 100 Hz, rows made by `row` of time (s), steering (°), yaw rate (°/s), speed (km/h).
fn rows(row: impl Fn(usize, f64, f64, f64, f64) -> String) -> String {
    let line = |k: usize| {
        let t = 0.01 * k as f64;
        row(k, t, steer(t).to_degrees(), rate(t).to_degrees(), 54.0)
    };
    (0..1000).map(|k| line(k) + "\n").collect()
}

fn german(number: f64) -> String {
    format!("{number:.9}").replace('.', ",")
}

/// The drive in plain CSV, as read.
fn same(text: impl AsRef<[u8]>, options: &LogOptions) -> DriveLog {
    let log = read_one(text.as_ref().to_vec(), options)
        .unwrap_or_else(|e| panic!("{e}\n{}", String::from_utf8_lossy(&text.as_ref()[..300])));
    let plain = read_one(good(), &LogOptions::default()).unwrap();
    assert_eq!(log.len(), plain.len());
    // Seconds since 1970 have steps of 0.2 µs.
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-5);
    assert!(close(&log.input, &plain.input), "steering");
    assert!(close(&log.output, &plain.output), "yaw rate");
    assert!(close(log.speed.as_ref().unwrap(), plain.speed.as_ref().unwrap()), "speed");
    log
}

fn o() -> LogOptions {
    LogOptions::default()
}

#[test]
fn excel_with_german_settings() {
    let head =
        "sep=;\r\nZeit [s];Radlenkwinkel, vorn [°];Gierrate [°/s];Geschwindigkeit [km/h]\r\n";
    let body =
        rows(|_, t, s, r, v| format!("{};{};{};{}\r", german(t), german(s), german(r), german(v)));
    same(format!("{head}{body}"), &o());
    // Without the line for Excel, in Latin 1, with a delimiter at the end of each row.
    let latin: Vec<u8> = format!("{}{body}", head.replace("sep=;\r\n", ""))
        .replace("\r\n", ";\r\n")
        .chars()
        .map(|c| u8::try_from(c).unwrap())
        .collect();
    assert!(std::str::from_utf8(&latin).is_err());
    same(latin, &o());
    // Tabs.
    same(format!("{head}{body}").replace("sep=;\r\n", "").replace(';', "\t"), &o());
    // A comma in quotes between commas.
    let quoted = rows(|_, t, s, r, v| {
        let cells = [t, s, r, v].map(|x| format!("\"{}\"", german(x)));
        cells.join(",")
    });
    same(format!("Zeit [s],Lenkwinkel [°],Gierrate [°/s],Geschwindigkeit [km/h]\n{quoted}"), &o());
}

#[test]
fn an_open_decimal_mark_is_rejected() {
    let header = "time_ms;steer_deg;yaw_rate_degps;speed_kmh\n";
    // 1,234 ms or 1234 ms?
    let open = rows(|k, _, _, _, _| {
        format!("{},{:03};{};{};54", k / 100 + 1, 10 * (k % 100), k % 7, k % 5)
    });
    let e = refused(format!("{header}{open}").into_bytes(), &o());
    assert!(
        matches!(e, Error::DecimalMark { ref at, other: None, .. } if at.line == 2)
            && e.hint().contains("a comma or a point"),
        "{e:?}"
    );
    let comma = LogOptions { decimal: Some(DecimalMark::Comma), ..o() };
    let steps = "time_s;steer_deg;yaw_rate_degps;speed_kmh\n";
    let read = read_one(format!("{steps}{open}").into_bytes(), &comma).unwrap();
    assert_eq!(read.channels[0].rate_hz, 100.0);
    let point = LogOptions { decimal: Some(DecimalMark::Point), ..o() };
    assert!(matches!(
        refused(format!("{header}{open}").into_bytes(), &point),
        Error::DecimalMark { other: Some("point"), .. }
    ));
    // Both marks.
    let both = rows(|_, t, s, r, _| format!("{};{};{r:.6};54,0", german(t), german(s)));
    refused(format!("{header}{both}").into_bytes(), &o());
    // One cell after the rows that the detection reads.
    let late =
        rows(
            |k, t, s, r, v| {
                if k == 900 { format!("{t};0,5;{r};{v}") } else { format!("{t:.2};{s};{r};{v:.1}") }
            },
        );
    let e = refused(format!("{steps}{late}").into_bytes(), &o());
    assert!(matches!(e, Error::DecimalMark { ref at, .. } if at.line == 902), "{e:?}");
    // Commas between cells and in them.
    let none = rows(|_, t, s, r, v| [t, s, r, v].map(german).join(","));
    let e = refused(format!("{}{none}", steps.replace(';', ",")).into_bytes(), &o());
    assert!(matches!(e, Error::RaggedRow { got: 8, .. }) && e.hint().contains("decimal commas"));
}

#[test]
fn units_below_the_header() {
    let body = rows(|_, t, s, r, v| format!("{t:.3};{s:.9};{r:.9};{v:.1}"));
    let names = "Time;StWhlAng;YawRate;VehicleSpeed";
    let wheel = LogOptions { steering_ratio: Some(1.0), ..o() };
    let log = same(format!("{names}\ns;°;°/s;km/h\n{body}"), &wheel);
    assert_eq!(log.channels[0].unit, "deg");
    same(format!("{names}\n[s];[deg];[deg/s];[km/h]\n\n{body}"), &wheel);
    // Columns that are not read may have any unit, or none.
    let more = body.replace('\n', ";12;0\n");
    same(format!("{names};Torque;Gear\ns;deg;deg/s;km/h;Nm;-\n{more}"), &wheel);
    let e = refused(format!("{names}\ns;turns;deg/s;km/h\n{body}").into_bytes(), &wheel);
    assert!(matches!(e, Error::UnknownUnit { ref unit, .. } if unit == "turns"), "{e:?}");
    let differs = names.replace("YawRate", "YawRate [rad/s]");
    let text = format!("{differs}\ns;deg;deg/s;km/h\n{body}").into_bytes();
    let e = refused(text.clone(), &wheel);
    assert!(matches!(e, Error::UnitsDiffer { row: "deg/s", header: "rad/s", .. }), "{e:?}");
    let stated = units(&[("YawRate", "deg/s")]);
    same(text, &LogOptions { units: stated, ..wheel.clone() });
    // A row of text that is not a row of units is rejected with its line.
    let e = refused(format!("{names}\na;b;c;d\n{body}").into_bytes(), &wheel);
    assert!(matches!(e, Error::UnitNotStated { .. }), "{e:?}");
}

#[test]
fn comments_are_skipped() {
    let header = "time_s,roadwheel_angle_deg,yaw_rate_degps,speed_kmh";
    for mark in ["#", "# ", "//", "%", "  # "] {
        let body = rows(|k, t, s, r, v| {
            let note = if k == 400 { format!("{mark}lap 2, \"wet\n") } else { String::new() };
            format!("{note}{t:.2},{s:.9},{r:.9},{v}")
        });
        same(format!("{mark}Recorded by logger 4.2, 100 Hz\n{mark}\n{header}\n{body}"), &o());
        // numpy.savetxt and MATLAB put the names into a comment.
        same(format!("{mark}drive 3\n{mark}{header}\n{body}"), &o());
        // Named as it stands in the file, and as it is read.
        for time in [format!("{mark}time(s)"), "time(s)".into(), "time".into()] {
            let named = LogOptions { time: Some(time), ..o() };
            let rest = &header["time_s".len()..];
            same(format!("{mark}time(s){rest}\n{body}"), &named);
        }
        let twice = LogOptions { time: Some("## time(s)".into()), ..o() };
        same(format!("## time(s){}\n{body}", &header["time_s".len()..]), &twice);
        let names = "time,roadwheel_angle,yaw_rate,speed";
        same(format!("{mark}{names}\n{mark}s,deg,deg/s,km/h\n{body}"), &o());
    }
}

#[test]
fn times_of_iso_8601() {
    let body = |time: &dyn Fn(usize) -> String| {
        rows(|k, _, s, r, v| format!("{},{s:.9},{r:.9},{v}", time(k)))
    };
    let header = "timestamp,roadwheel_angle_deg,yaw_rate_degps,speed_kmh";
    let clock = |k: usize| format!("{:02}.{:02}", (55 + k / 100) % 60, k % 100);
    let date = |k: usize| {
        let day = if k < 500 { "2024-02-28T23:59" } else { "2024-02-29T00:00" };
        format!("{day}:{}", clock(k))
    };
    same(format!("{header}\n{}", body(&|k| format!("{}Z", date(k)))), &o());
    same(format!("{header}\n{}", body(&|k| format!("{}+01:00", date(k)))), &o());
    same(format!("{header}\n{}", body(&|k| date(k).replace('T', " "))), &o());
    let quoted = body(&|k| format!("\"{}\"", date(k).replace('.', ",")));
    same(format!("{header}\n{quoted}"), &o());
    // The time of day goes on after midnight.
    let log = same(format!("{header}\n{}", body(&|k| date(k)[11..].to_owned())), &o());
    assert!(log.segments[0].time0_s < 0.1);
    let start: f64 = log.options["log_start_s"].parse().unwrap();
    assert!((start - 86_395.0).abs() < 0.2, "{start}");
    // pandas writes its index without a name.
    same(format!("{}\n{}", &header[9..], body(&date)), &o());
    same(
        format!("{header}\n{}", body(&|k| format!("29.02.2024 00:00:0{:.2}", 0.01 * k as f64))),
        &o(),
    );
    let span = |k: usize| format!("0 days 00:00:{:09.6}", 0.01 * k as f64);
    same(format!("{header}\n{}", body(&span)), &o());
    let watch = |k: usize| format!("{}:{}", 59 + (55 + k / 100) / 60, clock(k));
    same(format!("{header}\n{}", body(&watch)), &o());
    let mixed = body(&|k| if k == 700 { format!("{}Z", date(k)) } else { date(k) });
    let e = refused(format!("{header}\n{mixed}").into_bytes(), &o());
    assert!(matches!(e, Error::NotATime { ref at, .. } if at.line == 702), "{e:?}");
    let other = body(&|k| format!("29.Feb.2024 00:00:{}", clock(k)));
    let stated = LogOptions { units: units(&[("timestamp", "s")]), ..o() };
    let e = refused(format!("{header}\n{other}").into_bytes(), &stated);
    assert!(matches!(e, Error::NotANumber { .. }) && e.hint().contains("ISO 8601"), "{e:?}");
}

#[test]
fn a_table_with_several_clocks_is_a_group_for_each() {
    let slow = |k: usize, t: f64| if k < 100 { format!("{:.2};54", 10.0 * t) } else { ";".into() };
    let body = rows(|k, t, s, r, _| format!("{t:.2};{s:.9};{t:.2};{r:.9};{}", slow(k, t)));
    let mda = "time [s];Lenkwinkel vorn [deg];time [s];Gierrate [deg/s];time [s];Geschwindigkeit [km/h]\n";
    let found =
        inspect(LogFile::of_bytes("a.csv", format!("{mda}{body}").as_bytes()), &o()).unwrap();
    let groups: Vec<(&str, usize, Option<f64>)> =
        found.groups.iter().map(|g| (g.name.as_str(), g.rows, g.rate_hz)).collect();
    assert_eq!(
        groups,
        [
            ("Lenkwinkel vorn", 1000, Some(100.0)),
            ("Gierrate", 1000, Some(100.0)),
            ("Geschwindigkeit", 100, Some(10.0))
        ]
    );
    let body = rows(|_, t, s, r, v| format!("{t:.2};{s:.9};{t:.2};{r:.9};{t:.2};{v}"));
    same(format!("{mda}{body}"), &o());
    // A bad cell in a clock that is not the first one is an error with its line.
    let bad = format!("{mda}{body}").replacen("\n0.50;", "\n0.50;0;x0.50;0;;\n0.505;", 1);
    let e = refused(bad.into_bytes(), &o());
    assert!(matches!(&e, Error::NotANumber { at, .. } if at.line == 52), "{e:?}");
    // One name with one channel in front of another one is a fault of the names.
    let text = format!(
        "time_s,time_s,steer_deg,yaw_rate_degps\n{}",
        rows(|_, t, s, r, _| format!("{t},{t},{s},{r}"))
    );
    assert!(matches!(refused(text.into_bytes(), &o()), Error::RepeatedColumn { .. }));
}

#[test]
fn labview_with_a_clock_for_each_channel_and_without_any() {
    let top = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nMulti_Headings\tYes\nX_Columns\tKIND\n\
               Time_Pref\tRelative\nDate\t2024/03/01\nTime\t10:00:00,123\n***End_of_Header***\t\n\t\n";
    let block = |tabs: &str, step: &str| {
        let line = |key: &str, cells: [&str; 3]| format!("{key}\t{}\n", cells.join(tabs));
        [
            line("Channels", ["3", "", ""]),
            line("Samples", ["1000"; 3]),
            line("Y_Unit_Label", ["deg", "deg/s", "km/h"]),
            line("X_Dimension", ["Time"; 3]),
            line("X0", ["0.0000000000000000E+0"; 3]),
            line("Delta_X", [step, "0.010000", "0.010000"]),
            "***End_of_Header***\t\t\t\n".into(),
        ]
        .concat()
    };
    let multi = "X_Value\tRoadWheelAngle\tX_Value\tYawRate\tX_Value\tSpeed\tComment\n";
    let text = rows(|_, t, s, r, v| format!("{t:.6}\t{s:.9}\t{t:.6}\t{r:.9}\t{t:.6}\t{v}"));
    same(
        format!("{}{}{multi}{text}", top.replace("KIND", "Multi"), block("\t\t", "0.010000")),
        &o(),
    );
    let names = "X_Value\tRoadWheelAngle\tYawRate\tSpeed\tComment\n";
    let text = rows(|_, _, s, r, v| format!("\t{s:.9}\t{r:.9}\t{v}"));
    let none = |step: &str| format!("{}{}{names}", top.replace("KIND", "No"), block("\t", step));
    same(format!("{}{text}", none("0.010000")), &o());
    // Channels of different rates have no common clock.
    assert!(matches!(
        refused(format!("{}{text}", none("0.1")).into_bytes(), &o()),
        Error::NoTime { .. }
    ));
    // A further block begins again, at a time that this file does not relate to the first.
    let again = format!("{}{text}\n{}{names}{text}", none("0.010000"), block("\t", "0.010000"));
    assert!(matches!(refused(again.into_bytes(), &o()), Error::TimeNotIncreasing { .. }));
}

#[test]
fn tables_of_r_pandas_and_others() {
    let cells = |sep: &'static str| {
        rows(move |_, t, s, r, v| [t, s, r, v].map(|x| format!("{x:.9}")).join(sep))
    };
    let names = "\"time_s\" \"steer_deg\" \"yaw_rate_degps\" \"speed_kmh\"\n";
    let numbered = rows(|k, t, s, r, v| format!("\"{}\" {t} {s:.9} {r:.9} {v}", k + 1));
    same(format!("{names}{numbered}"), &o());
    same(format!("{names}{numbered}").replace(' ', ","), &o());
    // Levels of columns and the name of the index.
    let levels = "signal,steer,yaw_rate,speed\nunit,deg,deg/s,km/h\ntime_s,,,\n";
    same(format!("{levels}{}", cells(",")), &o());
    let levels = ",imu,imu,car\n,steer_deg,yaw_rate_degps,speed_kmh\ntime_s,,,\n";
    same(format!("{levels}{}", cells(",")), &o());
    // The only unit below the names is one.
    let log = format!("time,steer_deg,yaw_rate_degps,speed_kmh\ns,,,\n{}", cells(","));
    same(log, &o());
    for head in [
        "# xtime [s]\tSTEER [deg]\tyaw_rate [deg/s]\tspeed [km/h]\n",
        "Elapsed Time (s)\tSteering (deg)\tYaw Rate (deg/s)\tSpeed (km/h)\n",
        "ETASAsciiItemFile\trecord\ntime\tSteer\tYawRate\tSpeed\n\nf8\tf8\tf8\tf8\ns\tdeg\tdeg/s\tkm/h\n",
    ] {
        same(format!("{head}{}", cells("\t")), &o());
    }
    let race = "# RaceRender Data: TrackAddict\n\"Time\",\"steer_deg\",\"yaw_rate_degps\",\"Speed (KPH)\",\"GPS_Update\"\n";
    same(format!("{race}{}", cells(",").replace('\n', ",1\n")), &o());
    let lap = format!("Lap Time (s),steer_deg,yaw_rate_degps,speed_kmh\n{}", cells(","));
    assert!(matches!(refused(lap.into_bytes(), &o()), Error::NoTime { .. }));
}

#[test]
fn days_of_a_spreadsheet_and_long_units_are_a_clock() {
    let header = "steer_deg,yaw_rate_degps,speed_kmh";
    let body = |time: &dyn Fn(f64) -> String| {
        rows(|_, t, s, r, v| format!("{},{s:.9},{r:.9},{v}", time(t)))
    };
    let days = |t: f64| format!("{:.12}", 45_352.416_7 + t / 86_400.0);
    for name in ["Date", "Time", "Datum", "timestamp"] {
        let log = same(format!("{name},{header}\n{}", body(&days)), &o());
        assert!(log.warnings.iter().any(|w| w.contains("days")), "{name}: {:?}", log.warnings);
    }
    let minutes = |t: f64| format!("{:.12}", t / 60.0);
    same(format!("Time [min],{header}\n{}", body(&minutes)), &o());
    // Parts of a day may be any time.
    let parts = |t: f64| format!("{:.12}", 0.4 + t / 86_400.0);
    let text = format!("Time,{header}\n{}", body(&parts));
    let e = refused(text.clone().into_bytes(), &o());
    assert!(
        e.hint().ends_with("known units of time are s, ms, us, ns, min, h and d"),
        "{}",
        e.hint()
    );
    let in_days = LogOptions { units: units(&[("Time", "d")]), ..o() };
    let log = read_one(text.into_bytes(), &in_days).unwrap();
    assert!((log.channels[0].rate_hz - 100.0).abs() < 1e-3, "{}", log.channels[0].rate_hz);
    // The same numbers with a stated unit are seconds.
    let stated = LogOptions { units: units(&[("Time", "s")]), ..o() };
    let text = format!("Time,{header}\n{}", body(&|t| format!("{}", 45_352.0 + t)));
    same(text, &stated);
}

#[test]
fn a_time_in_a_form_that_is_not_read_is_named() {
    let header = "Time,steer_deg,yaw_rate_degps,speed_kmh";
    for time in ["Fri Mar 01 10:00:00 GMT+01:00 2024", "2024.61 10:00:00", "10h00m00s"] {
        let body = rows(|_, _, s, r, v| format!("{time},{s:.9},{r:.9},{v}"));
        let e = refused(format!("{header}\n{body}").into_bytes(), &o());
        assert!(
            matches!(&e, Error::UnreadTime { at, text } if at.line == 2 && text == time),
            "{e:?}"
        );
    }
}

#[test]
fn an_unnamed_index_is_no_channel_unless_it_is_named() {
    let body = rows(|k, t, s, r, v| format!("{k},{t:.2},{s:.9},{r:.9},{v}"));
    same(format!(",time_s,roadwheel_angle_deg,yaw_rate_degps,speed_kmh\n{body}"), &o());
    // The index is the clock.
    let text = format!(",t2,roadwheel_angle_deg,yaw_rate_degps,speed_kmh\n{body}");
    assert!(matches!(refused(text.clone().into_bytes(), &o()), Error::NoTime { .. }));
    let in_ms = units(&[("column_1", "ms")]);
    let options = LogOptions {
        time: Some("column_1".into()),
        units: in_ms,
        sample_time_s: Some(0.002),
        ..o()
    };
    let log = read_one(text.into_bytes(), &options).unwrap();
    assert_eq!(log.channels[0].rate_hz, 1000.0);
}

#[test]
fn names_of_the_tools() {
    let body = |units: [f64; 3]| {
        rows(|_, t, s, r, v| {
            let [s, r, v] = [s / units[0], r / units[1], v / units[2]];
            format!("{t:.2},{s:.9},{r:.9},{v:.6}")
        })
    };
    let degrees = body([1.0; 3]);
    let rad = 1.0_f64.to_degrees();
    let radians = body([rad, rad, 3.6]);
    for header in [
        "t[s],Radlenkwinkel [deg],Giergeschwindigkeit [deg/s],Fahrzeuggeschwindigkeit [km/h]",
        "Zeit [s],Lenkwinkel [deg],Gierrate [°/s],v_Fzg [km/h]",
        "Time [s],Road Wheel Angle [deg],Yaw Rate [deg/s],Vehicle Speed [km/h]",
        "time_s,road_wheel_angle_deg,yaw_rate_degps,vehicle_speed_kmh",
        "time_s,frontWheelAngle [deg],yawRate [deg/s],VehSpd [km/h]",
        // VBOX
        "time [s],Steering_Angle [deg],Yaw_Rate [deg/s],velocity kmh",
    ] {
        same(format!("{header}\n{degrees}"), &o());
    }
    for header in [
        // CarMaker
        "Time [s],Car.SteerAngleFL [rad],Car.YawRate [rad/s],Car.v [m/s]",
        // Autoware, as PlotJuggler writes it
        "time_s,/vehicle/status/steering_status/steering_tire_angle [rad],/sensing/yaw_rate [rad/s],/vehicle/status/velocity_status/longitudinal_velocity [m/s]",
        "t_s,delta_f_rad,psi_p_radps,vx_mps",
    ] {
        same(format!("{header}\n{radians}"), &o());
    }
    // The ratio of a steering wheel is required.
    for name in ["Lenkradwinkel", "SteeringWheelAngle", "StWhlAng", "handwheel_angle", "SWA"] {
        let text = format!("time_s,{name} [deg],yaw_rate_degps,speed_kmh\n{degrees}");
        assert!(
            matches!(refused(text.clone().into(), &o()), Error::SteeringRatioUnknown { .. }),
            "{name}"
        );
        same(text, &LogOptions { steering_ratio: Some(1.0), ..o() });
    }
    // openpilot: a rate of the steering in addition to its angle, which is not mistaken for it.
    let more = degrees.replace('\n', ",3.0,1\n");
    let header =
        "time_s,steeringAngleDeg,yawRate [deg/s],vEgo [km/h],steeringRateDeg,steeringTorque";
    same(format!("{header}\n{more}"), &o());
    // A rate in degrees is no yaw.
    let text = format!("time_s,roadwheel_angle_deg,yaw_rate_deg,speed_kmh\n{degrees}");
    assert!(matches!(refused(text.into(), &o()), Error::WrongQuantity { .. }));
}

#[test]
fn a_normalised_command_has_a_stated_full_scale_or_is_taken_as_it_is() {
    let body = rows(|_, t, s, r, v| format!("{t:.2},{:.9},{r:.9},{v}", s / 20.0));
    let text = format!("time_s,steering,yaw_rate_degps,speed_kmh\n{body}");
    let e = refused(text.clone().into(), &o());
    assert!(
        matches!(e, Error::UnitNotStated { .. }) && e.hint().contains("unit 1"),
        "{}",
        e.hint()
    );
    // Of the plain log the angle was measured; a command would be held.
    let measured = LogOptions { intersample: Some(Intersample::Bl), ..o() };
    let one = LogOptions { units: units(&[("steering", "1")]), ..measured };
    let full = LogOptions { steering_full_scale_rad: Some(20.0_f64.to_radians()), ..one.clone() };
    let log = same(&text, &full);
    assert!(log.warnings.iter().any(|w| w.contains("1 is 20.00°")), "{:?}", log.warnings);
    assert_eq!(log.options["steering_full_scale_rad"], 20.0_f64.to_radians().to_string());
    let percent = rows(|_, t, s, r, v| format!("{t:.2},{:.9},{r:.9},{v}", s * 5.0));
    same(format!("time_s,steering [%],yaw_rate_degps,speed_kmh\n{percent}"), &full_only());
    let as_it_is = read_one(text.clone().into(), &one).unwrap();
    let warned = as_it_is.warnings.iter().any(|w| w.contains("steering full scale"));
    assert!(warned && as_it_is.input[10].abs() < 0.2, "{:?}", as_it_is.warnings);
    let command = read_one(text.clone().into(), &LogOptions { intersample: None, ..full });
    assert_eq!(command.unwrap().channels[0].intersample, Some(Intersample::Zoh));
    let beyond = format!("time_s,steering [1],yaw_rate_degps,speed_kmh\n{percent}");
    assert!(matches!(refused(beyond.into(), &full_only()), Error::BeyondFullScale { .. }));
    let angle = text.replace("steering", "steering [deg]");
    assert!(matches!(refused(angle.into(), &full_only()), Error::NoCommand { unit: "deg" }));
}

fn full_only() -> LogOptions {
    LogOptions {
        steering_full_scale_rad: Some(20.0_f64.to_radians()),
        intersample: Some(Intersample::Bl),
        ..o()
    }
}

#[test]
fn other_encodings_are_named() {
    let text = String::from_utf8(good()).unwrap();
    for (mark, bytes) in [(true, u16::to_le_bytes as fn(u16) -> [u8; 2]), (false, u16::to_be_bytes)]
    {
        let marked = mark.then_some('\u{feff}').into_iter().chain(text.chars()).collect::<String>();
        let wide: Vec<u8> = marked.encode_utf16().flat_map(bytes).collect();
        let e = refused(wide, &o());
        assert!(matches!(e, Error::Utf16 { .. }) && e.hint().contains("UTF-8"), "{e:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The same numbers are read from every spelling of a table.
    #[test]
    fn a_table_is_read_however_it_is_written(
        seed in 1_u64..1000, delimiter in 0..2_usize, comma: bool, units: bool, comments: bool,
        digits in 1..7_usize, sep: bool, crlf: bool,
    ) {
        let end = if crlf { "\r\n" } else { "\n" };
        let delimiter = [";", "\t"][delimiter];
        let number = |x: f64| {
            let text = format!("{x:.digits$}");
            if comma { text.replace('.', ",") } else { text }
        };
        let values = |k: usize| {
            let x = (seed as f64 * 0.37 + k as f64).sin();
            [0.1 * k as f64, 0.3 * x, 0.5 * (x + 0.1 * k as f64).sin()]
        };
        let mut text = String::new();
        if sep {
            let _ = write!(text, "sep={delimiter}{end}");
        }
        if comments {
            let _ = write!(text, "# made, for a test; 1,5{end}");
        }
        let (names, row) = if units {
            (["time", "roadwheel", "yaw rate"], format!("s{delimiter}rad{delimiter}rad/s{end}"))
        } else {
            (["time_s", "roadwheel [rad]", "yaw_rate_radps"], String::new())
        };
        let _ = write!(text, "{}{end}{row}", names.join(delimiter));
        for k in 0..400 {
            let _ = write!(text, "{}{end}", values(k).map(number).join(delimiter));
        }
        // Held, so that the samples are the rows.
        let held = Some(Intersample::Zoh);
        let options = LogOptions { sample_time_s: Some(0.1), intersample: held, ..o() };
        let log = read_one(text.into_bytes(), &options).unwrap();
        let tolerance = 0.5001 * 0.1_f64.powi(digits as i32) + 1e-9;
        for k in 0..400 {
            let [_, steering, yaw_rate] = values(k);
            prop_assert!((log.input[k] - steering).abs() < tolerance);
            prop_assert!((log.output[k] - yaw_rate).abs() < tolerance);
        }
    }
}

#[test]
fn names_in_a_comment_above_decimal_commas() {
    let body =
        rows(|_, t, s, r, v| [t, s, r, v].map(|x| format!("{x:.9}").replace('.', ",")).join(";"));
    same(format!("# time_s;delta_deg;yaw_rate_degps;speed_kmh\n{body}"), &o());
}

#[test]
fn a_quote_in_a_comment_hides_no_row() {
    let body = rows(|k, t, s, r, v| {
        let comment = if k % 400 == 100 { "  # note,\"wet\n// \"\n" } else { "" };
        format!("{comment}{t:.3},{s:.9},{r:.9},{v:.1}")
    });
    let head =
        "sep=,\n# by,\"hand\n\"time_s\n# not a comment\",delta_deg,yaw_rate_degps,speed_kmh\n";
    let named = LogOptions {
        time: Some("time_s\n# not a comment".into()),
        units: units(&[("time_s\n# not a comment", "s")]),
        ..o()
    };
    same(format!("{head}{body}"), &named);
    let plain = "% by,\"hand\ntime_s,delta_deg,yaw_rate_degps,speed_kmh\n";
    let log = same(format!("{plain}{body}"), &o());
    assert_eq!(log.channels[0].rows, 1000);
    // A line is counted, whether or not it is a comment.
    let broken = body.replacen("9.980,", "x9.980,", 1);
    let e = refused(format!("{plain}{broken}").into_bytes(), &o());
    assert!(matches!(e, Error::NotANumber { ref at, .. } if at.line == 1007), "{e:?}");
}

#[test]
fn the_steering_control_table_of_comma_has_its_units() {
    let mut text = String::from(
        "t,latActive,steeringPressed,vEgo,aEgo,steeringAngleDeg,steer,steerFiltered,roll,latAccelDesired,\
         latAccelSteeringAngle,latAccelLocalizer,epsFwVersion\n",
    );
    for k in 0..300 {
        let t = 0.1 * f64::from(k);
        text += &format!(
            "{t:.1},True,False,25.1,0.02,{:.3},{:.4},0.1,0.01,0.2,0.2,{:.4},b'8965'\n",
            5.0 * t.sin(),
            0.1 * t.sin(),
            0.3 * t.sin()
        );
    }
    let file = LogFile::of_bytes("00000.csv", text.as_bytes());
    let found = inspect(file, &LogOptions::default()).unwrap();
    assert_eq!(found.losses, Vec::<String>::new());
    assert_eq!(found.groups[0].clock.as_deref(), Some("t"));
    let unit = |name: &str| {
        let channel = found.groups[0].channels.iter().find(|c| c.name == name).unwrap();
        channel.unit.clone().unwrap()
    };
    assert_eq!(["vEgo", "steer", "roll"].map(unit), ["m/s", "1", "rad"]);
    assert_eq!(["latAccelLocalizer", "steeringAngleDeg"].map(unit), ["m/s2", "deg"]);
    assert_eq!(unit("epsFwVersion"), "text");
}
