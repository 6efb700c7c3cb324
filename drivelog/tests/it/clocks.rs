//! Files as they are written, and clocks: merged, resampled, or refused with their place.

use super::{HEADER, coarse, csv, good, rate, read_one, refused, steer, units, with_line};
use steerwright_drivelog::{Error, Intersample, LogFile, LogOptions, Role, read_drives, read_log};

#[test]
fn a_clean_log_is_read_and_resampled() {
    let log = read_one(good(), &LogOptions::default()).unwrap();
    // Without noise decimation would show: the log's own rate is kept.
    assert_eq!(log.sample_time_s, 0.01);
    assert_eq!(log.name, "drive");
    for (k, y) in log.output.iter().enumerate() {
        let t = log.segments[0].time0_s + 0.01 * k as f64;
        assert!((y - rate(t)).abs() < 1e-4, "{t}: {y} {}", rate(t));
    }
    assert!(log.speed.as_ref().unwrap().iter().all(|v| (v - 15.0).abs() < 1e-9));
    let summary = &log.channels[1];
    assert_eq!((summary.role.as_str(), summary.rows), ("yaw_rate", 1000));
    assert!((summary.rate_hz - 100.0).abs() < 0.01);
    // A measured angle is brought to what, held, does the same: the mean over the step that follows.
    let behaviour = |log: &steerwright_drivelog::DriveLog| log.channels[0].intersample;
    assert_eq!(behaviour(&log), Some(Intersample::Bl));
    for (k, u) in log.input.iter().enumerate() {
        let middle = log.segments[0].time0_s + 0.01 * k as f64 + 0.005;
        assert!((u - steer(middle)).abs() < 2e-5, "{middle}: {u} {}", steer(middle));
    }
    let log = read_one(good(), &coarse()).unwrap();
    for (k, u) in log.input.iter().enumerate() {
        let middle = log.segments[0].time0_s + 0.04 * k as f64 + 0.02;
        assert!((u - steer(middle)).abs() < 1e-4, "{middle}: {u} {}", steer(middle));
    }
    // A command at the log's own rate is not touched.
    let held = Some(Intersample::Zoh);
    let options =
        LogOptions { sample_time_s: Some(0.01), intersample: held, ..LogOptions::default() };
    let log = read_one(good(), &options).unwrap();
    assert_eq!((log.len(), behaviour(&log)), (1000, held));
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
        assert!((y - rate(log.segments[0].time0_s + 0.02 * k as f64)).abs() < 5e-4);
    }
    // The input of the model is held: its sample represents the middle of its interval.
    for (k, u) in log.input.iter().enumerate() {
        let middle = log.segments[0].time0_s + 0.02 * k as f64 + 0.5 * 0.02;
        assert!((u - steer(middle)).abs() < 5e-4);
    }
    let same = vec![files[0].clone(), ("c.csv".to_owned(), files[0].1.clone()), files[1].clone()];
    let options = LogOptions { input: Some("steer_rad".into()), ..LogOptions::default() };
    let error = read_log(&same, &options).unwrap_err();
    assert!(matches!(&error, Error::AmbiguousColumn { files, .. } if files == "a.csv, c.csv"));
    let stated = LogOptions { input: Some("a.csv:steer_rad".into()), ..LogOptions::default() };
    assert_eq!(read_log(&same, &stated).unwrap().input, log.input);
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
    assert!(matches!(refused(b"\0\x01PK\n".to_vec(), &o), Error::NotText { line: 1, .. }));
    let e = refused(with_line(5, "abc,0.1,0.1,15"), &o);
    assert!(matches!(e, Error::NotANumber { ref at, .. } if at.line == 5 && at.column == "time_s"));
    let e = refused(with_line(6, "1e999,0.01,0.1,15"), &o);
    assert!(matches!(e, Error::NotFinite { ref at, .. } if at.line == 6 && at.column == "time_s"));
    assert!(matches!(
        refused(with_line(7, "0.05,0.01,0.1,15,7"), &o),
        Error::RaggedRow { line: 7, got: 5, expected: 4, .. }
    ));
    let back = refused(with_line(8, "0.02,0.01,0.1,15"), &o);
    assert!(matches!(back, Error::TimeNotIncreasing { ref at, .. } if at.line == 8));
    let twice = refused(csv("time_s,steer_rad,steer_rad", 5, |_| "1,2,3".into()), &o);
    assert!(matches!(twice, Error::RepeatedColumn { line: 1, .. }));
    let unclosed = [HEADER, "\n0,\"0.1,0.2,15\n0.01,0.1,0.2,15\n"].concat().into_bytes();
    refused(unclosed, &o);
    assert!(matches!(read_log(&[], &o), Err(Error::NoFiles)));
}

/// Of a channel one cell in a hundred rows may be bad; it is a missing value.
#[test]
fn bad_cells_are_counted() {
    let with_bad = |count: usize| {
        csv(HEADER, 1000, |k| {
            let row = super::good_row(k);
            if k % 50 == 3 && k / 50 < count { row.replace(",15.0", ",abc") } else { row }
        })
    };
    let log = read_one(with_bad(10), &LogOptions::default()).unwrap();
    let text = "drive.csv:5: column `speed_mps`: `abc` is not a number: 10 cells of this kind";
    assert!(log.warnings.iter().any(|w| w.starts_with(text)), "{:?}", log.warnings);
    let e = refused(with_bad(11), &LogOptions::default());
    let text =
        "drive.csv:5: column `speed_mps`: `abc` is not a number: 11 of 1000 rows, at most 1 in 100";
    assert_eq!(e.to_string(), text);
}

/// A reader that returns a byte at a time, and fails at a stated byte.
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
        let file = LogFile::of_stream("slow.csv", Slow(&text, budget));
        read_drives(vec![file], Vec::new(), &LogOptions::default())
    };
    let log = read(usize::MAX).unwrap();
    assert_eq!(log.output, read_one(good(), &LogOptions::default()).unwrap().output);
    assert_eq!(log.sources[0].sha256, steerwright_formats::sha256_hex(&text));
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

/// A channel whose values repeat in faster rows is read as updated where they change: a yaw rate that is
/// updated at 10 or 50 Hz in rows of 100 Hz is no later than it was measured.
#[test]
fn a_sensor_that_is_slower_than_the_rows_is_read_as_it_was_updated() {
    for rows in [2, 10] {
        let text = csv(HEADER, 3000, |k| {
            let t = k as f64 * 0.01;
            let updated = (k / rows * rows) as f64 * 0.01;
            format!("{t:.2},{:.9},{:.9},15.0", steer(t), rate(updated))
        });
        let log = read_one(text, &LogOptions::default()).unwrap();
        assert!((log.channels[1].rate_hz - 100.0 / rows as f64).abs() < 0.1, "{:?}", log.channels);
        assert!(log.warnings.iter().any(|w| w.contains("repeated over")), "{:?}", log.warnings);
        for (t, y) in log.time_s().into_iter().zip(&log.output) {
            assert!((y - rate(t)).abs() < 3e-3, "{rows} {t}: {y} {}", rate(t));
        }
    }
}

/// A command is held however it is named, where its values show so.
#[test]
fn what_the_steering_does_between_its_samples_is_detected() {
    let with = |name: &str, angle: fn(usize) -> f64| {
        let header = HEADER.replace("steer_rad", name);
        let text = csv(&header, 1000, |k| {
            format!("{:.2},{:.9},{:.9},15.0", k as f64 * 0.01, angle(k), rate(k as f64 * 0.01))
        });
        let read = |intersample| {
            let options = LogOptions { intersample, ..LogOptions::default() };
            read_one(text.clone(), &options).unwrap()
        };
        // What is stated is not open.
        assert_eq!(
            read(Some(Intersample::Bl)).assumed_period_s(Role::Steering, Intersample::Bl),
            None
        );
        let log = read(None);
        for between in [Intersample::Bl, Intersample::Zoh] {
            let period = log.assumed_period_s(Role::Steering, between);
            let is_assumed = period.is_some_and(|period| (period - 0.01).abs() < 1e-6);
            assert_eq!(is_assumed, log.channels[0].intersample == Some(between), "{name}");
        }
        log.channels[0].intersample
    };
    let smooth = |k: usize| steer(k as f64 * 0.01);
    let steps = |k: usize| 0.01 * ((k / 70 * 7919) % 13) as f64;
    assert_eq!(with("steer_rad", smooth), Some(Intersample::Bl));
    assert_eq!(with("steering_command_rad", smooth), Some(Intersample::Zoh));
    assert_eq!(with("steer_rad", steps), Some(Intersample::Zoh));
}

#[test]
fn repeated_times_are_averaged_and_reported() {
    // A clock of 20 ms under rows of 10 ms, now and then.
    let repeats = |k: usize| k % 50 == 7;
    let text = csv("time_s,steer_rad,yaw_rate_radps", 1000, |k| {
        let t = 0.01 * k as f64;
        let shown = if repeats(k) { t - 0.01 } else { t };
        format!("{shown:.2},{:.9},{:.9}", steer(t), rate(t))
    });
    let log = read_one(text.clone(), &coarse()).unwrap();
    let warning = log.warnings.iter().find(|w| w.contains("averaged")).unwrap();
    assert!(warning.contains("20 samples") && warning.contains("line 9 at 0.06 s"), "{warning}");
    assert_eq!(log.channels[1].rows, 980);
    for (k, y) in log.output.iter().enumerate() {
        assert!((y - rate(log.segments[0].time0_s + 0.04 * k as f64)).abs() < 3e-3, "{k}");
    }
    // Yaw wraps between the two.
    let yaw = csv("time_s,steer_rad,yaw_deg", 1000, |k| {
        let t = 0.01 * k as f64;
        let shown = if repeats(k) { t - 0.01 } else { t };
        let yaw = 30.0 * t + (0.2 * (std::f64::consts::PI * t).sin()).to_degrees();
        format!("{shown:.2},{:.9},{:.9}", steer(t), (yaw + 180.0).rem_euclid(360.0) - 180.0)
    });
    let options = LogOptions { output: Some("yaw_deg".into()), ..coarse() };
    let log = read_one(yaw, &options).unwrap();
    assert!(log.output.iter().all(|r| (-0.3..1.3).contains(r)), "{:?}", log.output);
    // Channels on alternate rows do not repeat their own times.
    let turns = csv("time_s,steer_rad,yaw_rate_radps", 2000, |k| {
        let t = 0.01 * (k / 2) as f64;
        if k % 2 == 0 { format!("{t:.2},{},", steer(t)) } else { format!("{t:.2},,{}", rate(t)) }
    });
    assert!(
        !read_one(turns, &LogOptions::default())
            .unwrap()
            .warnings
            .iter()
            .any(|w| w.contains("averaged"))
    );
    // A clock of seconds.
    let coarse = csv("time_s,steer_rad,yaw_rate_radps", 3000, |k| {
        let t = 0.01 * k as f64;
        format!("{},{},{}", t.floor(), steer(t), rate(t))
    });
    let e = refused(coarse, &LogOptions::default());
    assert!(matches!(e, Error::CoarseClock { values: 3000, instants: 30, .. }), "{e:?}");
}

#[test]
fn dates_of_several_files_have_one_order_of_day_and_month() {
    let read = |days: [&str; 2], hours: [&str; 2]| {
        let text = |k: usize, name: &str, value: fn(f64) -> f64| {
            let rows = super::csv(&format!("date,{name}"), 600, |row| {
                let t = 0.01 * row as f64;
                format!("{} {}:{t:05.2},{:.9}", days[k], hours[k], value(t))
            });
            (format!("{name}.csv"), rows)
        };
        let files = [text(0, "delta_rad", super::steer), text(1, "yaw_rate_radps", super::rate)];
        steerwright_drivelog::read_log(&files, &LogOptions::default())
    };
    // The first is open, the second has the day first: both are 3 April.
    assert!(read(["03/04/2024", "03/04/2024"], ["10:00", "10:00"]).is_ok());
    let other = read(["03/04/2024", "13/04/2024"], ["10:00", "10:00"]).unwrap_err();
    assert!(
        matches!(other, Error::NoOverlap { first_from, second_from, .. } if (first_from - second_from).abs() < 864_001.0),
        "{other:?}"
    );
    let open = read(["03/04/2024", "04/04/2024"], ["10:00", "10:00"]).unwrap_err();
    assert_eq!(
        open.to_string(),
        "delta_rad.csv: the first date is 2024-03-04 or 2024-04-03: day and month are open"
    );
    assert!(open.hint().contains("write dates as in 2024-03-04"), "{}", open.hint());
}
