//! A file read in chunks brings what it brings when it is read whole.

use super::{Piece, in_chunks};
use crate::{DriveLog, LogFile, LogOptions, read_log};

/// Stretches of (steering, yaw rate, speed).
type Stretches = Vec<[Vec<f64>; 3]>;

fn streamed(csv: &str, options: &LogOptions, chunk: usize) -> (f64, Stretches) {
    let (mut step, mut stretches, mut open) = (0.0, Stretches::new(), false);
    let file = LogFile::of_bytes("drive.csv", csv.as_bytes());
    in_chunks(file, options, chunk, &mut |sample_time_s, piece| {
        step = sample_time_s;
        match piece {
            Piece::Samples { steering, yaw_rate, speed } => {
                if !open {
                    stretches.push(Default::default());
                }
                open = true;
                let last = stretches.last_mut().unwrap();
                let parts = [steering, yaw_rate, speed.unwrap_or_default()];
                last.iter_mut().zip(parts).for_each(|(all, x)| all.extend_from_slice(x));
            }
            Piece::End => open = false,
        }
        Ok(())
    })
    .unwrap();
    (step, stretches)
}

fn whole(csv: &str, options: &LogOptions) -> (DriveLog, Stretches) {
    let log = read_log(&[("drive.csv".into(), csv.as_bytes().to_vec())], options).unwrap();
    let speed = log.speed.clone().unwrap_or_default();
    let stretches = log.segments.iter().map(|s| {
        let speed = speed.get(s.range.clone()).unwrap_or_default().to_vec();
        [log.input[s.range.clone()].to_vec(), log.output[s.range.clone()].to_vec(), speed]
    });
    let stretches = stretches.collect();
    (log, stretches)
}

fn assert_same(csv: &str, options: &LogOptions, least_stretches: usize) {
    let (log, expected) = whole(csv, options);
    assert!(expected.len() >= least_stretches, "{}", expected.len());
    for chunk in [700, 1033, 5000, 100_000] {
        let (step, got) = streamed(csv, options, chunk);
        assert_eq!(step, log.sample_time_s);
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
    // At the chunks' ends and within, and a stretch too short to keep between two of them.
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
