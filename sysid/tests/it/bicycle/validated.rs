//! A bicycle validated on a drive: with the recorded speed, and the drive's own offsets.

use super::{DRIVE, Drive, at_end, at_speed, drive, evidence};
use crate::common::car;
use steerwright_formats::Bicycle;
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle, validate_bicycle};
use steerwright_sysid::{IdentifyOptions, validate};

/// The same vehicle on another day: other speeds, another wheel alignment, another gyro.
const ANOTHER: Drive =
    Drive { seed: 5, offset: -0.02, bias: 0.015, slowest: 5.0, fastest: 30.0, ..DRIVE };

#[test]
fn on_its_own_drive_a_bicycle_has_the_fits_of_its_identification() {
    let log = drive(car(), Drive { noise: 0.005, ..DRIVE });
    let options = BicycleOptions { validation: at_end(), ..BicycleOptions::default() };
    let found = identify_bicycle(&log, &options).unwrap();
    let validated = validate_bicycle(&log, &IdentifyOptions::default(), &found.bicycle).unwrap();
    let e = evidence(&found);
    for (now, then) in
        [(validated.estimation_fit, e.estimation_fit), (validated.validation_fit, e.validation_fit)]
    {
        assert!((now - then).abs() < 0.05, "{now} {then}");
    }
}

#[test]
fn on_another_drive_it_gets_the_recorded_speed_and_that_drive_s_offsets() {
    let found = identify_bicycle(&drive(car(), DRIVE), &BicycleOptions::default()).unwrap();
    let log = drive(car(), ANOTHER);
    let fit = |bicycle: &Bicycle| {
        validate_bicycle(&log, &IdentifyOptions::default(), bicycle).unwrap().validation_fit
    };
    assert!(fit(&found.bicycle) > 99.0, "{}", fit(&found.bicycle));
    // From vehicle data it has no offsets of its own.
    let data = Bicycle { evidence: None, ..found.bicycle.clone() };
    assert!(fit(&data) > 99.0, "{}", fit(&data));
    // At the one speed of its file it is another vehicle.
    let fixed = at_speed(&car(), found.bicycle.vehicle.speed_mps);
    let fixed = validate(&log, &IdentifyOptions::default(), &fixed).unwrap().validation_fit;
    assert!(fixed < 80.0, "{fixed}");
}

#[test]
fn without_a_recorded_speed_it_runs_at_its_own() {
    let level = Drive { slowest: 15.0, fastest: 15.0, ..DRIVE };
    let mut log = drive(car(), level);
    let found = identify_bicycle(&log, &BicycleOptions::default()).unwrap();
    log.speed = None;
    let validated = validate_bicycle(&log, &IdentifyOptions::default(), &found.bicycle).unwrap();
    assert!(validated.validation_fit > 99.0, "{}", validated.validation_fit);
}
