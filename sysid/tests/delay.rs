//! The input delay: found where there is one, left out where a lag explains the same.
#![allow(clippy::unwrap_used)]

use faer::Mat;
use std::f64::consts::PI;
use sysid::delay::{Delay, estimate_delay};
use sysid::{DataSet, LogOptions, Segment, read_log};
use sysid_evaluation::Random;

#[test]
fn look() {
    let files =
        [("drive.csv".to_owned(), std::fs::read("../tests/data/multibody/drive.csv").unwrap())];
    for ts in [0.01, 0.02, 0.04] {
        let options = LogOptions {
            input: Some("steering_command_rad".into()),
            steering_ratio: Some(1.0),
            sample_time_s: Some(ts),
            ..LogOptions::default()
        };
        let log = read_log(&files, &options).unwrap();
        let t0 = std::time::Instant::now();
        let data = DataSet::single(
            log.sample_time_s,
            Mat::from_fn(1, log.len(), |_, k| log.input[k]),
            Mat::from_fn(1, log.len(), |_, k| log.output[k]),
        )
        .unwrap();
        println!("{:?} {:?}", estimate_delay(&data), t0.elapsed());
        let t0 = std::time::Instant::now();
        let data = DataSet::single(
            log.sample_time_s,
            Mat::from_fn(1, log.len() - 3, |_, k| log.input[k]),
            Mat::from_fn(1, log.len() - 3, |_, k| log.output[k + 3]),
        )
        .unwrap();
        println!("ahead {:?} {:?}", estimate_delay(&data), t0.elapsed());
        let data = DataSet::single(
            log.sample_time_s,
            Mat::from_fn(1, log.len() - 3, |_, k| log.input[k]),
            Mat::from_fn(1, log.len() - 3, |_, k| if k > 2 { log.output[k - 3] } else { 0.0 }),
        )
        .unwrap();
        println!("late {:?} {:?}", estimate_delay(&data), t0.elapsed());
    }
}
