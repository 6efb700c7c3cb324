//! Logs as they are found: several files and clocks, units, and every kind of bad input, each of which
//! must be rejected with its place and a hint, or corrected with a warning.
#![allow(clippy::unwrap_used, clippy::panic, clippy::single_range_in_vec_init)]

mod arrow;
mod can;
mod clocks;
mod compression;
mod dialects;
mod drives;
mod exports;
mod gaps;
mod headers;
mod mcap;
mod mdf;
mod parquet;
mod tools;
mod torn;
mod units;

use std::collections::BTreeMap;
use std::f64::consts::PI;
use steerwright_drivelog::{DriveLog, Error, LogOptions, read_log};

/// A CSV text with a row for each 10 ms made by `row`.
fn csv(header: &str, rows: usize, row: impl Fn(usize) -> String) -> Vec<u8> {
    let mut text = format!("{header}\n");
    for k in 0..rows {
        text += &row(k);
        text.push('\n');
    }
    text.into_bytes()
}

fn steer(t: f64) -> f64 {
    0.05 * (2.0 * PI * 0.5 * t).sin()
}

fn rate(t: f64) -> f64 {
    0.2 * (2.0 * PI * 0.5 * t - 0.3).sin()
}

const HEADER: &str = "time_s,steer_rad,yaw_rate_radps,speed_mps";

fn good_row(k: usize) -> String {
    let t = k as f64 * 0.01;
    format!("{t:.2},{:.9},{:.9},15.0", steer(t), rate(t))
}

fn good() -> Vec<u8> {
    csv(HEADER, 1000, good_row)
}

/// Brought to a sample time of four rows.
fn coarse() -> LogOptions {
    LogOptions { sample_time_s: Some(0.04), ..LogOptions::default() }
}

fn read_one(bytes: Vec<u8>, options: &LogOptions) -> Result<DriveLog, Error> {
    read_log(&[("drive.csv".to_owned(), bytes)], options)
}

/// Every error has a message that names the place and a hint.
fn refused(bytes: Vec<u8>, options: &LogOptions) -> Error {
    let error = read_one(bytes, options).unwrap_err();
    assert!(!error.hint().is_empty() && !error.to_string().is_empty(), "{error:?}");
    println!("{error}\n  hint: {}", error.hint());
    error
}

fn with_line(line: usize, text: &str) -> Vec<u8> {
    csv(HEADER, 1000, |k| if k + 2 == line { text.to_owned() } else { good_row(k) })
}

fn units(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
    pairs.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect()
}
