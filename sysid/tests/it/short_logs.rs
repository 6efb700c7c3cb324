//! Logs of a few seconds: no pass on what a few seconds determine, and a fit with its ± or the reason for none.

use crate::common::recording;
use crate::known::Drive;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{Grade, Quality, ReasonCode};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::{IdentifyOptions, identify};

const SAMPLE_TIME: f64 = 0.02;

fn log(seconds: f64, noise: f64, seed: u64) -> DriveLog {
    let drive = Drive { sample_time: SAMPLE_TIME, delay: 0.0, servo: 0.05, noise, seed };
    let recorded = drive.record((seconds / SAMPLE_TIME) as usize);
    let speed = Some(vec![15.0; recorded.steering.len()]);
    DriveLog { speed, ..recording(SAMPLE_TIME, recorded.steering, recorded.yaw_rate) }
}

fn state_space(log: &DriveLog) -> Quality {
    identify(log, &IdentifyOptions::default()).unwrap().plant.quality
}

#[test]
fn a_short_log_is_no_pass_and_states_why_its_fit_has_no_uncertainty() {
    for (seconds, seed) in [(5.0, 1), (8.0, 2), (12.0, 3), (20.0, 4)] {
        let log = log(seconds, 0.002, seed);
        let bicycle = identify_bicycle(&log, &BicycleOptions::default()).unwrap();
        for quality in [state_space(&log), bicycle.bicycle.quality] {
            assert_ne!(quality.grade, Grade::Pass, "{seconds} s: {}", quality.summary);
            assert!(quality.has(ReasonCode::ShortValidation), "{seconds} s: {}", quality.codes());
            assert!(quality.summary.contains("needs 5 blocks of 3 s"), "{}", quality.summary);
        }
    }
}

/// The reason is there exactly where the file states more than 10 % at 0.3, 1 or 2 Hz, and then there is no pass.
#[test]
fn a_pass_needs_standard_errors_that_allow_it() {
    let mut uncertain = [0; 2];
    for (noise, seed) in [(0.002, 5), (0.002, 6), (0.04, 5), (0.04, 6), (0.04, 7)] {
        let plant = identify(&log(32.0, noise, seed), &IdentifyOptions::default()).unwrap().plant;
        let stated = plant.uncertainty.unwrap();
        let errors = [0.3, 1.0, 2.0].map(|hz| stated.errors_at(hz).unwrap()[0]);
        let is_uncertain = errors.iter().any(|e| *e > 0.1);
        let quality = plant.quality;
        assert_eq!(quality.has(ReasonCode::UncertainGain), is_uncertain, "{}", quality.summary);
        assert!(!is_uncertain || quality.grade > Grade::Pass, "{}", quality.summary);
        assert!(quality.summary.contains('±'), "{}", quality.summary);
        uncertain[usize::from(noise > 0.01)] += usize::from(is_uncertain);
    }
    assert!(uncertain[0] == 0 && uncertain[1] > 0, "{uncertain:?}");
}
