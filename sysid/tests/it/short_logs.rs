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
            assert!(quality.summary.contains("needs 5 × 3 s"), "{}", quality.summary);
        }
    }
}

/// With little noise a minute passes; with much, the same minute determines the response at no frequency well enough.
#[test]
fn a_minute_passes_by_what_its_standard_errors_allow() {
    let quality = state_space(&log(60.0, 0.002, 5));
    assert_eq!(quality.grade, Grade::Pass, "{}", quality.summary);
    assert!(quality.summary.contains('±'), "{}", quality.summary);
    let noisy = log(60.0, 0.045, 5);
    let quality = state_space(&noisy);
    assert_eq!(quality.grade, Grade::Warn, "{}", quality.summary);
    assert!(quality.has(ReasonCode::UncertainGain), "{}", quality.codes());
    let bicycle = identify_bicycle(&noisy, &BicycleOptions::default()).unwrap().bicycle.quality;
    assert!(bicycle.has(ReasonCode::UncertainGain), "{}", bicycle.summary);
}
