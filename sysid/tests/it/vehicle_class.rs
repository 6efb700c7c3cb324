//! Wheelbase and speed of a drive in every structure.

use crate::linear_car::{CAR, LinearCar, Pattern};
use steerwright_drivelog::VehicleClass;
use steerwright_formats::{Grade, Quality, Reason, ReasonCode};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::single_track::{IdentifyVehicleOptions, identify_vehicle};
use steerwright_sysid::{ChoiceOptions, identify_structure};
use steerwright_sysid::{IdentifyOptions, identify};

const SHORT: LinearCar = LinearCar { seconds: 60.0, pattern: Pattern::Multisine, ..CAR };

fn plant(drive: LinearCar) -> Quality {
    identify(&drive.log(), &IdentifyOptions::default()).unwrap().plant.quality
}

fn fails(quality: &Quality) -> bool {
    quality
        .reasons
        .iter()
        .any(|r| r.code == ReasonCode::ImplausibleVehicle && r.grade == Grade::Fail)
}

/// A speed in km/h in a column of m/s fails in every structure, by the wheelbase that the drive determines.
#[test]
fn a_wrong_unit_of_the_speed_fails_in_every_structure() {
    for (mean_mps, varies_mps, class) in
        [(15.0, 4.0, None), (15.0, 4.0, Some(VehicleClass::Car)), (9.0, 4.0, None)]
    {
        let drive = LinearCar { mean_mps, varies_mps, class, speed_factor: 3.6, ..SHORT };
        let log = drive.log();
        let bicycle = identify_bicycle(&log, &BicycleOptions::default()).unwrap();
        let chosen = identify_structure(&log, &ChoiceOptions::default()).unwrap().identified.model;
        for (structure, quality) in [
            ("state space", &plant(drive)),
            ("bicycle", &bicycle.bicycle.quality),
            ("chosen", chosen.quality()),
        ] {
            println!("{drive:?} {structure}: {}", quality.summary);
            assert!(fails(quality), "{drive:?} {structure}: {}", quality.summary);
        }
    }
}

/// A wheelbase of no vehicle is far off its prior, too: that is one reason, not two.
#[test]
fn a_wheelbase_of_no_vehicle_is_a_reason_once() {
    let drive = LinearCar { varies_mps: 4.0, speed_factor: 3.6, ..SHORT };
    let found = identify_vehicle(&drive.log(), &IdentifyVehicleOptions::default()).unwrap();
    let quality = found.vehicle.quality;
    assert!(fails(&quality), "{}", quality.summary);
    let is_unusual = quality.reasons.iter().any(|r| r.code == ReasonCode::UnusualParameter);
    assert!(!is_unusual, "{}", quality.summary);
}

/// At one speed the understeer gradient may be what makes a drive's gain small: such a drive, and one of another
/// size with its right units, does not fail.
#[test]
fn the_wheelbase_of_a_drive_fails_none_with_right_units() {
    let one_speed = LinearCar { varies_mps: 0.0, ..SHORT };
    for drive in [
        SHORT,
        LinearCar { class: Some(VehicleClass::Car), ..SHORT },
        LinearCar { mean_mps: 40.0, class: Some(VehicleClass::Car), ..SHORT },
        LinearCar { mean_mps: 20.0, varies_mps: 3.0, wheelbase_m: 6.5, ..SHORT },
        LinearCar { mean_mps: 7.0, varies_mps: 5.0, wheelbase_m: 7.5, ..SHORT },
        LinearCar { mean_mps: 2.0, varies_mps: 0.5, wheelbase_m: 0.26, ratio: 1.0, ..SHORT },
        LinearCar { mean_mps: 1.2, varies_mps: 1.1, wheelbase_m: 0.5, ratio: 1.0, ..SHORT },
        LinearCar { mean_mps: 8.0, ..one_speed },
        LinearCar { mean_mps: 20.0, ..one_speed },
        LinearCar { mean_mps: 35.0, class: Some(VehicleClass::Car), ..one_speed },
        LinearCar { mean_mps: 48.0, ..one_speed },
    ] {
        let quality = plant(drive);
        println!("{drive:?}: {}", quality.summary);
        assert!(!fails(&quality), "{drive:?}: {}", quality.summary);
    }
}

/// A banked road and the vehicle's parameters cannot be separated where all turns are to one side.
#[test]
fn turns_to_one_side_are_a_reason() {
    for (pattern, is_one_sided) in [(Pattern::Multisine, false), (Pattern::LeftTurns, true)] {
        let log = LinearCar { pattern, ..SHORT }.log();
        let bicycle = identify_bicycle(&log, &BicycleOptions::default()).unwrap().bicycle.quality;
        let vehicle =
            identify_vehicle(&log, &IdentifyVehicleOptions::default()).unwrap().vehicle.quality;
        for quality in [bicycle, vehicle] {
            let is_reason =
                |r: &Reason| (r.code, r.grade) == (ReasonCode::OneSidedTurns, Grade::Warn);
            assert_eq!(quality.reasons.iter().any(is_reason), is_one_sided, "{}", quality.summary);
        }
    }
}
