//! Which files are one drive.

use super::gaps::warning;
use super::{HEADER, csv, good, good_row, rate, read_one, steer};
use std::cell::Cell;
use std::rc::Rc;
use steerwright_drivelog::{
    Columns, Error, Group, LogFile, LogOptions, Pieces, Recording, Request, Rows, in_memory,
    read_drives, read_log, read_recordings,
};

fn file(name: &str, bytes: &[u8]) -> (String, Vec<u8>) {
    (name.to_owned(), bytes.to_vec())
}

/// A drive that starts at another time on another clock.
fn other_drive() -> Vec<u8> {
    csv(HEADER, 800, |k| {
        let t = k as f64 * 0.0125;
        format!("{:.4},{:.9},{:.9},15.0", 1000.0 + t, steer(t), rate(t))
    })
}

#[test]
fn dates_of_another_file_decide_which_number_is_the_day() {
    let two = |date: &str, other: &str| {
        let stamp = |k: usize| format!("10:00:{:02}.{:02}", k / 100, k % 100);
        let angles = csv("time,steer_rad,yaw_rate_radps", 1000, |k| {
            let t = k as f64 * 0.01;
            format!("{date} {},{:.9},{:.9}", stamp(k), steer(t), rate(t))
        });
        let speeds =
            csv("time,speed_mps", 1000, |k| format!("{other}T{},{}", stamp(k), 15 + k % 2));
        read_log(&[file("a.csv", &angles), file("b.csv", &speeds)], &LogOptions::default())
    };
    for iso in ["2024-03-04", "2024-04-03"] {
        assert!(two("03/04/2024", iso).unwrap().len() > 900, "{iso}");
    }
    assert!(matches!(two("03/04/2024", "2024-07-01"), Err(Error::NoOverlap { .. })));
    // The number that cannot be a month decides before another file does.
    assert!(matches!(two("03/14/2024", "2024-07-01"), Err(Error::NoOverlap { .. })));
}

#[test]
fn files_that_bring_everything_are_drives_of_their_own() {
    let o = LogOptions::default();
    let log = read_log(&[file("one/a.csv", &good()), file("b.csv", &other_drive())], &o).unwrap();
    let (one, two) = (read_one(good(), &o).unwrap(), read_one(other_drive(), &o).unwrap());
    assert_eq!(log.segments.len(), 2);
    // 0.01 s suits the first, 0.0125 s the second: one sample time for all.
    let times = [&one, &two, &log].map(|log| log.sample_time_s);
    assert_eq!(times, [0.01, 0.0125, 0.0125]);
    let same = LogOptions { sample_time_s: Some(0.0125), ..o.clone() };
    let alone = read_one(good(), &same).unwrap();
    assert_eq!(log.output[log.segments[0].range.clone()], alone.output[..]);
    assert_eq!(log.options["log_start_s"], format!("0; {}", two.options["log_start_s"]));
    let start: f64 = two.options["log_start_s"].parse().unwrap();
    assert!(start > 999.0 && log.segments[1].time0_s < 1.0);
    for (k, y) in log.output[log.segments[1].range.clone()].iter().enumerate() {
        let t = log.segments[1].time0_s + start - 1000.0 + 0.0125 * k as f64;
        assert!((y - rate(t)).abs() < 1e-3, "{t}");
    }
    // Each file by name and hash, each channel by file and column, and which drives there are.
    let hashes: Vec<_> = log.sources.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(hashes, ["a.csv", "b.csv"]);
    assert_eq!(
        (&log.sources[0].sha256, &log.sources[1].sha256),
        (
            &{ steerwright_formats::sha256_hex(&good()) },
            &steerwright_formats::sha256_hex(&other_drive())
        )
    );
    let columns: Vec<_> = log.channels.iter().map(|c| c.column.as_str()).collect();
    assert_eq!(&columns[..2], ["a.csv:steer_rad", "a.csv:yaw_rate_radps"]);
    assert_eq!((columns.len(), columns[5]), (6, "b.csv:speed_mps"));
    assert_eq!(log.options["drives"], "a.csv; b.csv");
    // A window counts from the first sample of each drive; a drive that none meets is left out.
    let window = LogOptions { windows: vec![(1.0, 8.0)], ..o.clone() };
    let part = read_log(&[file("a.csv", &good()), file("b.csv", &other_drive())], &window).unwrap();
    assert_eq!(part.segments.len(), 2);
    assert!(part.segments.iter().all(|s| (1.0..1.2).contains(&s.time0_s)), "{:?}", part.segments);
    let none = LogOptions { windows: vec![(1001.0, 1008.0)], ..o.clone() };
    let error = read_log(&[file("a.csv", &good()), file("b.csv", &other_drive())], &none);
    assert!(matches!(error, Err(Error::NoOverlap { .. })));
    // The same drive twice would validate a model on its own estimation data.
    let error = read_log(&[file("a.csv", &good()), file("copy.csv", &good())], &o).unwrap_err();
    assert!(
        matches!(&error, Error::RepeatedDrive { first, second } if first == "a.csv" && second == "copy.csv")
    );
    // Where one drive has no speed, none is used.
    let mute = csv("time_s,steer_rad,yaw_rate_radps", 999, |k| good_row(k).replace(",15.0", ""));
    let log = read_log(&[file("a.csv", &good()), file("mute.csv", &mute)], &o).unwrap();
    assert!(log.speed.is_none() && warning(&log, "no speed in").contains("mute.csv"));
}

#[test]
fn files_of_one_drive_are_stated_or_requested() {
    let o = LogOptions::default();
    let bare = csv("time_s,steer_rad,yaw_rate_radps", 1000, |k| good_row(k).replace(",15.0", ""));
    let speed = csv("time_s,speed_mps", 1000, |k| format!("{},15", k as f64 * 0.01));
    // A file that adds to the only whole one.
    let log = read_log(&[file("a.csv", &bare), file("speed.csv", &speed)], &o).unwrap();
    assert!(log.segments.len() == 1 && log.speed.is_some());
    // To which of two it adds is not known.
    let three = [file("a.csv", &bare), file("b.csv", &other_drive()), file("speed.csv", &speed)];
    let error = read_log(&three, &o).unwrap_err();
    assert!(matches!(error, Error::AmbiguousDrives { .. }), "{error:?}");
    assert!(error.hint().contains("a.csv and speed.csv"), "{}", error.hint());
    let open = |i: usize| LogFile::of_bytes(&three[i].0, &three[i].1);
    let log = read_drives(vec![open(1)], vec![vec![open(0), open(2)]], &o).unwrap();
    assert_eq!(
        (log.segments.len(), log.options["drives"].as_str()),
        (2, "b.csv; a.csv + speed.csv")
    );
    assert!(log.speed.is_some());
    // Columns named with their files are channels of one drive.
    let named = LogOptions {
        input: Some("a.csv:steer_rad".into()),
        output: Some("b.csv:yaw_rate_radps".into()),
        ..o.clone()
    };
    let error = read_log(&three[..2], &named).unwrap_err();
    assert!(matches!(error, Error::NoOverlap { .. }), "{error:?}");
    assert!(matches!(read_drives(Vec::new(), vec![Vec::new()], &o), Err(Error::NoFiles)));
}

/// A recording of that many equal rows, of which it makes as many as are taken.
struct Long {
    groups: Vec<Group>,
    rows: usize,
    taken: Rc<Cell<usize>>,
}

impl Recording for Long {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let channels = request.wanted[0].channels.len();
        Ok(Box::new((0..self.rows / request.most).map(move |_| {
            self.taken.set(self.taken.get() + request.most);
            let values = vec![vec![0.0; request.most]; channels];
            let lines = Rc::new(vec![1; request.most]);
            Ok(Rows { wanted: 0, columns: Columns { values, lines } })
        })))
    }
}

/// How many rows are taken before the log is refused, and the hint.
fn refused(stated: Option<u64>) -> (usize, String) {
    let names = ["time_s", "steering_angle_rad", "yaw_rate_radps"];
    let columns = names.map(|name| (name.to_owned(), vec![0.0, 1.0])).to_vec();
    let mut groups = in_memory("long.csv", columns).unwrap().groups().to_vec();
    groups[0].rows = stated;
    let taken = Rc::new(Cell::new(0));
    let long = Long { groups, rows: 44_000_000, taken: Rc::clone(&taken) };
    let options = LogOptions { steering_ratio: Some(1.0), ..LogOptions::default() };
    let error = read_recordings(vec![Box::new(long)], &options).unwrap_err();
    assert!(matches!(error, Error::TooManyRows { .. }), "{error}");
    (taken.get(), error.hint())
}

#[test]
fn a_log_that_is_too_long_is_refused_before_it_fills_the_memory() {
    let (taken, hint) = refused(Some(44_000_000));
    assert!(taken == 0 && hint.contains("accumulate"), "{taken} {hint}");
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn a_log_of_unknown_length_is_read_no_further_than_its_limit() {
    assert!(refused(None).0 < 20_100_000);
}

#[test]
fn a_stated_receiver_of_a_log_without_fixes_is_reported() {
    let quiet = read_one(good(), &LogOptions::default()).unwrap();
    assert!(!quiet.warnings.iter().any(|w| w.contains("fixes")), "{:?}", quiet.warnings);
    let latency = LogOptions { gnss_latency_s: Some(0.1), ..LogOptions::default() };
    let antenna = LogOptions { antenna_x_m: 0.5, ..LogOptions::default() };
    for options in [latency, antenna] {
        warning(&read_one(good(), &options).unwrap(), "the log has no fixes");
    }
}
