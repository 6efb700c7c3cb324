//! A file read in chunks brings what it brings when it is read whole.

use super::gate::Piece;
use super::{Streamed, in_chunks};
use crate::Error;
use crate::log::DriveLog;
use crate::options::LogOptions;
use crate::read::{read_log, read_recordings};
use crate::recording::{Group, LogFile, Pieces, Recording, Request, Rows, Wanted, in_memory, open};
use steerwright_formats::ChannelSummary;

/// Segments of (steering, yaw rate, speed).
type Segments = Vec<[Vec<f64>; 3]>;

fn streamed(csv: &str, options: &LogOptions, chunk: usize) -> (f64, Segments, Vec<ChannelSummary>) {
    let file = LogFile::of_bytes("drive.csv", csv.as_bytes());
    let (step, segments, read) = of_recording(open(file, options).unwrap(), options, chunk);
    (step, segments, read.channels)
}

fn of_recording(
    recording: Box<dyn Recording + '_>,
    options: &LogOptions,
    chunk: usize,
) -> (f64, Segments, Streamed) {
    let (mut step, mut segments, mut open) = (0.0, Segments::new(), false);
    let read = in_chunks::<crate::Error>(recording, options, chunk, &mut |start, piece| {
        step = start.sample_time_s;
        match piece {
            Piece::Samples { steering, yaw_rate, speed } => {
                if !open {
                    segments.push(Default::default());
                }
                open = true;
                let last = segments.last_mut().unwrap();
                let parts = [steering, yaw_rate, speed.unwrap_or_default()];
                last.iter_mut().zip(parts).for_each(|(all, x)| all.extend_from_slice(x));
            }
            Piece::End => open = false,
        }
        Ok(())
    })
    .unwrap();
    (step, segments, read)
}

fn whole(csv: &str, options: &LogOptions) -> (DriveLog, Segments) {
    let log = read_log(&[("drive.csv".into(), csv.as_bytes().to_vec())], options).unwrap();
    let speed = log.speed.clone().unwrap_or_default();
    let segments = log.segments.iter().map(|s| {
        let speed = speed.get(s.range.clone()).unwrap_or_default().to_vec();
        [log.input[s.range.clone()].to_vec(), log.output[s.range.clone()].to_vec(), speed]
    });
    let segments = segments.collect();
    (log, segments)
}

fn assert_same(csv: &str, options: &LogOptions, least_segments: usize) {
    let (log, expected) = whole(csv, options);
    assert!(expected.len() >= least_segments, "{}", expected.len());
    for chunk in [700, 1033, 5000, 5960, 100_000] {
        let (step, got, channels) = streamed(csv, options, chunk);
        assert_eq!(step, log.sample_time_s);
        for (a, b) in channels.iter().zip(&log.channels) {
            let faults = |c: &ChannelSummary| (c.spikes_s.clone(), c.frozen_s.clone());
            assert_eq!(faults(a), faults(b), "{}, chunks of {chunk}", a.role);
            if a.frozen_s.is_empty() {
                assert_eq!(a.rows, b.rows, "{}: {chunk}", a.role);
                assert!(
                    (a.min - b.min).abs() + (a.max - b.max).abs() < 1e-9,
                    "{}: {chunk}",
                    a.role
                );
            }
        }
        assert_eq!(got.len(), expected.len(), "chunks of {chunk}");
        for (got, expected) in got.iter().flatten().zip(expected.iter().flatten()) {
            assert_eq!(got.len(), expected.len(), "chunks of {chunk}");
            for (k, (a, b)) in got.iter().zip(expected).enumerate() {
                assert!((a - b).abs() < 1e-11, "sample {k}, chunks of {chunk}: {a} {b}");
            }
        }
    }
}

/// A drive of 60 s at 100 Hz; `cell` may change the text of a row's cells, or leave the row out.
fn drive(cell: impl Fn(usize, [f64; 4]) -> Option<[String; 4]>) -> String {
    let mut csv = String::from("time_s,roadwheel_angle_rad,yaw_rate_radps,speed_mps\n");
    for k in 0..6000 {
        let t = 0.01 * k as f64;
        let values = [
            t,
            0.02 * (1.3 * t).sin() + 0.01 * (0.11 * t * t).cos(),
            0.2 * (1.3 * t + 0.4).sin() + 0.03 * (17.0 * t).sin(),
            15.0 + 3.0 * (0.3 * t).sin() + 0.2 * (40.0 * t).sin(),
        ];
        if let Some(cells) = cell(k, values) {
            csv += &cells.join(",");
            csv.push('\n');
        }
    }
    csv
}

fn text(values: [f64; 4]) -> [String; 4] {
    values.map(|x| format!("{x:.9}"))
}

#[test]
fn a_whole_drive_at_its_own_rate_and_filtered() {
    let csv = drive(|_, v| Some(text(v)));
    for sample_time_s in [None, Some(0.01), Some(0.03), Some(0.0377)] {
        assert_same(&csv, &LogOptions { sample_time_s, ..LogOptions::default() }, 1);
    }
}

#[test]
fn gaps_split_it_where_they_split_the_whole() {
    // At the chunks' ends and within, and a segment too short to keep between two of them.
    let gap = |k: usize| {
        (1400..1466).contains(&k) || (3000..3100).contains(&k) || (3150..3260).contains(&k)
    };
    let csv = drive(|k, v| (!gap(k)).then(|| text(v)));
    assert_same(&csv, &LogOptions::default(), 3);
    assert_same(&csv, &LogOptions { sample_time_s: Some(0.01), ..LogOptions::default() }, 3);
    // All in one channel.
    let csv = drive(|k, v| {
        let mut cells = text(v);
        if gap(k) {
            cells[2].clear();
        }
        Some(cells)
    });
    assert_same(&csv, &LogOptions::default(), 3);
}

#[test]
fn channels_of_other_rates_and_missing_cells() {
    let csv = drive(|k, v| {
        let mut cells = text(v);
        if k % 10 != 3 {
            cells[3].clear();
        }
        if k % 2 == 1 || k % 97 == 0 {
            cells[1].clear();
        }
        Some(cells)
    });
    // At 0.04 s the last tap of the steering's filter would lie on the edge of its window, where the
    // last digit of the period decides whether it is there.
    let options = LogOptions { sample_time_s: Some(0.05), ..LogOptions::default() };
    assert_same(&csv, &options, 1);
}

#[test]
fn reversing_splits_it_where_it_splits_the_whole() {
    let csv = drive(|k, mut v| {
        if (1395..1470).contains(&k) || (3000..3900).contains(&k) {
            v[3] = -2.0;
        }
        Some(text(v))
    });
    assert_same(&csv, &LogOptions::default(), 3);
    let (log, _) = whole(&csv, &LogOptions::default());
    assert!(log.speed.unwrap().iter().all(|v| *v > 0.0));
    let reported = |w: &String| w.contains("the vehicle reverses for 9.8 s, first at 13.94 s");
    assert!(log.warnings.iter().any(reported), "{:?}", log.warnings);
    let backwards = drive(|_, mut v| {
        v[3] = -v[3];
        Some(text(v))
    });
    let files = [("drive.csv".into(), backwards.into_bytes())];
    let error = read_log(&files, &LogOptions::default()).unwrap_err();
    assert!(error.to_string().contains("the vehicle reverses for 60.0 s"), "{error}");
    assert!(error.hint().contains("forward"), "{}", error.hint());
}

#[test]
fn a_speed_window_keeps_the_same_parts() {
    let csv = drive(|_, v| Some(text(v)));
    let options = LogOptions { speed_window: Some((14.0, 17.0)), ..LogOptions::default() };
    assert_same(&csv, &options, 4);
}

#[test]
fn a_yaw_is_differenced_across_chunks() {
    let csv = drive(|_, v| {
        let mut cells = text(v);
        cells[2] =
            format!("{:.9}", (3.0 * v[0] + 0.3 * v[0].sin()).rem_euclid(std::f64::consts::TAU));
        Some(cells)
    })
    .replace("yaw_rate_radps", "yaw_rad");
    let options = LogOptions { output: Some("yaw_rad".into()), ..LogOptions::default() };
    assert_same(&csv, &options, 1);
}

#[test]
fn freezes_and_spikes_are_found_across_chunks() {
    // From one chunk to the next, and through whole ones.
    let frozen = [1300..1500, 2000..3500, 4970..5030];
    // On both sides of the chunks' ends, and in the last rows.
    let spikes = [699, 700, 1032, 1033, 4132, 4998, 5600, 5959, 5990];
    let csv = drive(|k, mut v| {
        if let Some(run) = frozen.iter().find(|run| run.contains(&k)) {
            v[2] = 0.1 + 1e-3 * run.start as f64 / 6000.0;
        }
        if spikes.contains(&k) {
            v[1] = -0.7;
        }
        if k == 5166 || k == 5960 {
            v[2] = 3.0;
        }
        Some(text(v))
    });
    let (log, _) = whole(&csv, &LogOptions::default());
    assert_eq!(log.channels[0].spikes_s, spikes.map(|k| (k as f64 * 10.0).round() / 1e3));
    assert_eq!(log.channels[1].spikes_s, [51.66, 59.6]);
    assert_eq!(log.channels[1].frozen_s, [[13.0, 14.99], [20.0, 34.99], [49.7, 50.29]]);
    assert_same(&csv, &LogOptions::default(), 2);
}

#[test]
fn a_file_that_begins_frozen_or_at_rest() {
    for speed in [15.0, 0.0] {
        let csv = drive(|k, mut v| {
            if k < 2200 {
                (v[2], v[3]) = (0.0, speed);
            }
            Some(text(v))
        });
        let (log, _) = whole(&csv, &LogOptions::default());
        assert_eq!(log.channels[1].frozen_s.len(), usize::from(speed > 0.0));
        // Its own rate would be chosen by what the first chunk shows.
        assert_same(&csv, &LogOptions { sample_time_s: Some(0.02), ..LogOptions::default() }, 1);
    }
}

/// Each sample of a sensor of 10 Hz is ten rows of 100 Hz, a bad one too.
#[test]
fn a_bad_sample_of_a_slow_sensor_is_a_spike() {
    let csv = drive(|k, mut v| {
        let t = 0.1 * (k / 10) as f64;
        v[2] = 0.2 * (1.3 * t + 0.4).sin();
        if [2090, 3030, 4990, 5950].contains(&(k / 10 * 10)) {
            v[2] = 2.0;
        }
        Some(text(v))
    });
    let (log, _) = whole(&csv, &LogOptions::default());
    assert_eq!(log.channels[1].spikes_s, [20.9, 30.3, 49.9, 59.5]);
    assert_same(&csv, &LogOptions::default(), 1);
}

/// Tables on clocks of their own as groups of one file.
struct Several {
    tables: Vec<Box<dyn Recording>>,
    groups: Vec<Group>,
}

impl Recording for Several {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn rows<'r>(&'r mut self, request: Request<'r>) -> Result<Pieces<'r>, Error> {
        let mut pieces = Vec::new();
        for (index, wanted) in request.wanted.iter().enumerate() {
            let own = [Wanted { group: 0, channels: wanted.channels.clone() }];
            let rows = self.tables[wanted.group].rows(Request { wanted: &own, ..request })?;
            for (k, rows) in rows.enumerate() {
                pieces.push((k, Rows { wanted: index, ..rows? }));
            }
        }
        pieces.sort_by_key(|(k, rows)| (*k, rows.wanted));
        Ok(Box::new(pieces.into_iter().map(|(_, rows)| Ok(rows))))
    }
}

#[test]
fn groups_with_clocks_of_their_own_bring_what_they_bring_when_read_whole() {
    let several = || {
        let table = |name: &str, rate: f64, from: f64, f: fn(f64) -> f64| {
            let time: Vec<f64> =
                (0..(60.0 * rate) as usize).map(|k| from + k as f64 / rate).collect();
            let value = time.iter().map(|t| f(*t)).collect();
            in_memory("bus", vec![("time_s".into(), time), (name.into(), value)]).unwrap()
        };
        let tables = vec![
            table("roadwheel_angle_rad", 83.0, 0.0, |t| {
                0.02 * (1.3 * t).sin() + 0.01 * (0.1 * t * t).cos()
            }),
            // Ahead of the steering by more with each piece, and frozen where the steering moves.
            table("yaw_rate_radps", 50.0, 0.4, |t| {
                let t = if (31.0..35.0).contains(&t) { 31.0 } else { t };
                0.2 * (1.3 * t + 0.4).sin() + 0.03 * (7.0 * t).sin()
            }),
            table("speed_mps", 10.0, 0.1, |t| 15.0 + t.sin()),
        ];
        let groups = tables.iter().enumerate().map(|(k, table)| {
            let mut group = table.groups()[0].clone();
            group.name = format!("message {k}");
            group
        });
        Box::new(Several { groups: groups.collect(), tables }) as Box<dyn Recording>
    };
    let options = LogOptions::default();
    let log = read_recordings(vec![several()], &options).unwrap();
    assert_eq!((log.segments.len(), log.channels[1].frozen_s.len()), (2, 1));
    for chunk in [500, 1000, 100_000] {
        let (step, segments, read) = of_recording(several(), &options, chunk);
        assert_eq!((step, segments.len()), (log.sample_time_s, 2));
        assert_eq!(read.channels[1].frozen_s, log.channels[1].frozen_s);
        assert_eq!(read.source, log.sources[0]);
        let expected = [&log.input, &log.output, log.speed.as_ref().unwrap()];
        for (c, expected) in expected.into_iter().enumerate() {
            let got: Vec<f64> = segments.iter().flat_map(|s| s[c].iter().copied()).collect();
            assert_eq!(got.len(), expected.len(), "chunks of {chunk}");
            let differ = got.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(differ < 1e-11, "chunks of {chunk}: {differ}");
        }
    }
}
