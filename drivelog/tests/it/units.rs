//! Units, signs and mappings: converted, or refused with what could have been meant.

use super::{HEADER, csv, good, good_row, rate, read_one, refused, steer, units, with_line};
use std::f64::consts::PI;
use steerwright_drivelog::{DriveLog, Error, LogOptions, Response, Role};

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
        let t = log.segments[0].time0_s + 0.02 * k as f64;
        assert!((y - rate(t) - 5.0_f64.to_radians()).abs() < 1e-3, "{t}: {y}");
    }
}

#[test]
fn wrong_mappings_are_refused() {
    let o = LogOptions::default();
    let named = |input: &str| LogOptions { input: Some(input.into()), ..o.clone() };
    let e = refused(good(), &named("sterring"));
    assert!(
        matches!(e, Error::MissingColumn { ref available, .. } if available.contains("steer_rad"))
    );
    // Of many columns the nearest are named, and how many there are.
    let more: String = (0..20).map(|k| format!(",channel_{k}")).collect();
    let wide = |line: &str| {
        format!("{line}{}", if line.contains('_') { more.clone() } else { ",0".repeat(20) })
    };
    let text = String::from_utf8(good()).unwrap();
    let text: Vec<String> = text.lines().map(wide).collect();
    let e = refused((text.join("\n") + "\n").into_bytes(), &named("steer_rat"));
    let Error::MissingColumn { available, .. } = e else { panic!("{e}") };
    assert!(available.starts_with("steer_rad"), "{available}");
    assert!(
        available.contains("(the nearest of 2") && !available.contains("channel_19"),
        "{available}"
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
    let clockless = text.replacen("time_s", "moment", 1).into_bytes();
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
    // The largest angle, not the first that is too large; a single row would be a spike.
    let rows = |k: usize| match k {
        40..45 => format!("{:.2},-0.9,0.1,15", 0.01 * k as f64),
        50..55 => format!("{:.2},-1.5,0.1,15", 0.01 * k as f64),
        _ => good_row(k),
    };
    let e = refused(csv(HEADER, 1000, rows), &o).to_string();
    assert!(e.starts_with("drive.csv:52: column `steer_rad`: 86°"), "{e}");
}

#[test]
fn the_speed_of_a_standstill_is_refused() {
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
        assert!(e.hint().contains("channel of the speed"), "{}", e.hint());
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

/// A log of the response of the speed, with the columns and units of `header` beside time and speed.
fn pedals(
    header: &str,
    row: impl Fn(f64) -> String,
    options: &LogOptions,
) -> Result<DriveLog, Error> {
    let bytes = csv(&format!("time_s,speed_mps,{header}"), 1000, |k| {
        let t = k as f64 * 0.01;
        format!("{t:.2},{:.6},{}", 15.0 + steer(t), row(t))
    });
    read_one(bytes, &LogOptions { response: Response::Speed, ..options.clone() })
}

#[test]
fn pedals_grades_and_altitudes_have_the_units_of_their_names() {
    let o = LogOptions::default();
    let row = |t: f64| {
        let share = 0.5 + 5.0 * steer(t);
        format!("{share},{},{},{}", 100.0 * share, 3.0 + 10.0 * steer(t), 100.0 + t)
    };
    let header = "accelerator [-],brake_pct,road_grade_percent,altitude_ft";
    let log = pedals(header, row, &o).unwrap();
    assert_eq!(log.warnings, Vec::<String>::new());
    let units: Vec<&str> = log.channels.iter().map(|channel| channel.unit.as_str()).collect();
    assert_eq!(units, ["1", "m/s", "%", "%", "ft"]);
    let close = |x: f64, y: f64| (x - y).abs() < 1e-3;
    let [brake, grade, altitude] =
        [Role::Brake, Role::Grade, Role::Altitude].map(|role| log.others[&role][100]);
    assert!(close(brake, log.input[100]), "{brake}");
    assert!(close(grade, 0.03 + 0.1 * (brake - 0.5) / 5.0), "{grade}");
    assert!((30.48..33.6).contains(&altitude), "{altitude}");
    // An accelerator that is stated to have no unit is one from 0 to 1; without any statement its unit is open.
    for header in ["accelerator [-]", "accelerator [%]", "throttle_pct", "accelerator_percent"] {
        let row = |t: f64| format!("{}", 0.5 + 5.0 * steer(t));
        pedals(header, row, &o).unwrap();
    }
    // The same in a row of units.
    let rows = (0..1000).map(|k| {
        let t = 0.01 * f64::from(k);
        format!("{t:.2},{},{}\n", 15.0 + steer(t), 0.5 + 5.0 * steer(t))
    });
    let text = format!("time,speed,accelerator\ns,m/s,-\n{}", rows.collect::<String>());
    let options = LogOptions { response: Response::Speed, ..o.clone() };
    assert_eq!(read_one(text.into_bytes(), &options).unwrap().channels[0].unit, "1");
    let error = pedals("accelerator", |t| format!("{}", 0.5 + steer(t)), &o).unwrap_err();
    assert!(matches!(error, Error::UnitNotStated { .. }), "{error}");
    let error = pedals("accelerator [-]", |t| format!("{}", 30.0 + steer(t)), &o).unwrap_err();
    assert!(error.to_string().contains("beyond 1.1"), "{error}");
    assert!(!error.to_string().contains("1.1 1"), "{error}");
}

#[test]
fn options_of_a_steering_have_no_effect_on_the_speed_and_are_reported() {
    let row = |t: f64| format!("{}", 0.5 + 5.0 * steer(t));
    let plain = pedals("accelerator [1]", row, &LogOptions::default()).unwrap();
    let stated = LogOptions {
        steering_full_scale_rad: Some(0.4),
        steering_ratio: Some(15.0),
        antenna_x_m: 1.0,
        ..LogOptions::default()
    };
    let log = pedals("accelerator [1]", row, &stated).unwrap();
    assert_eq!(log.input, plain.input);
    assert_eq!(
        log.warnings,
        ["steering ratio", "steering full scale", "place of the antenna"]
            .map(|option| format!("the stated {option} has no effect on a model of the speed"))
    );
}

/// Named channels, of which one is a combination, are not taken for steering and yaw rate.
#[test]
fn a_combination_of_channels_is_an_input_of_any_system() {
    let bytes = csv("time_s,a,c,y", 1000, |k| {
        let t = k as f64 * 0.01;
        format!("{t:.2},{:.6},{:.6},{:.6}", steer(t), rate(2.0 * t), rate(t))
    });
    let named = |input: &str, speed: Option<&str>| LogOptions {
        input: Some(input.into()),
        output: Some("y".into()),
        inputs: vec![input.into()],
        outputs: vec!["y".into()],
        speed: speed.map(Into::into),
        ..LogOptions::default()
    };
    let log = read_one(bytes.clone(), &named("a + 0.5 * c", Some("nosuch"))).unwrap();
    assert_eq!(log.response, Response::Channels);
    let sentence = "the stated channel of the speed has no effect on a plant of named channels";
    assert_eq!(log.warnings, [sentence]);
    let twice = LogOptions { inputs: vec!["a".into(), "c".into(), "a".into()], ..named("a", None) };
    let error = read_one(bytes, &twice).unwrap_err();
    assert!(error.to_string().contains("`a` is named as an input twice"), "{error}");
    // Of a vehicle both are as they were.
    let log = read_one(
        good(),
        &LogOptions {
            inputs: vec!["steer_rad + 0.0 * speed_mps".into()],
            outputs: vec!["yaw_rate_radps".into()],
            input: Some("steer_rad + 0.0 * speed_mps".into()),
            output: Some("yaw_rate_radps".into()),
            ..LogOptions::default()
        },
    );
    assert_eq!(log.unwrap().response, Response::YawRate);
}
