//! The choice of a structure: each of the three on a drive that needs it, and no more.

use super::{DRIVE, Drive, drive};
use crate::common::{car, recording};
use crate::known::limit_drive::LimitDrive;
use steerwright_drivelog::DriveLog;
use steerwright_sysid::single_track::SingleTrackModel;
use steerwright_sysid::structures::{
    Choice, IdentifiedModel, Structure, StructureOptions, identify_structure,
};

fn choice(log: &DriveLog) -> Choice {
    let found = identify_structure(log, &StructureOptions::default()).unwrap();
    for row in &found.rows {
        println!("{}: {:?} {:?} {}", row.structure, row.fit, row.errors, row.is_rejected);
    }
    println!();
    found
}

#[test]
fn the_simplest_structure_that_is_not_rejected_is_chosen() {
    let noisy = Drive { noise: 0.004, ..DRIVE };
    let one_speed = drive(car(), Drive { slowest: 15.0, fastest: 15.0, ..noisy });
    let found = choice(&one_speed);
    assert!(matches!(found.model, IdentifiedModel::Plant(_)));
    assert!(found.rows[1].fit.as_ref().unwrap_err().contains("hardly varies"));

    let found = choice(&drive(car(), noisy));
    assert!(matches!(found.model, IdentifiedModel::Bicycle(_)));
    assert!(found.rows[0].is_rejected && !found.rows[1].is_rejected);

    // A car at its limit of grip.
    let drive = LimitDrive { grip_used: 0.95, ..LimitDrive::new(SingleTrackModel::default(), 4) };
    let recorded = drive.record().unwrap();
    let segment = &recorded.segments[0];
    let log = DriveLog {
        speed: Some(segment.speed_mps.clone()),
        ..recording(
            recorded.sample_time_s,
            segment.steering_rad.clone(),
            segment.yaw_rate_radps.clone(),
        )
    };
    let found = choice(&log);
    assert!(matches!(found.model, IdentifiedModel::Vehicle(_)));
    let names: Vec<Structure> =
        found.rows.iter().filter(|row| row.is_rejected).map(|row| row.structure).collect();
    assert_eq!(names, [Structure::StateSpace, Structure::Bicycle]);
}

#[test]
fn without_speed_there_is_one_structure() {
    let log = DriveLog { speed: None, ..drive(car(), Drive { noise: 0.004, ..DRIVE }) };
    let found = choice(&log);
    assert!(matches!(found.model, IdentifiedModel::Plant(_)));
    for row in &found.rows[1..] {
        assert_eq!(row.fit, Err("the log has no speed".into()));
    }
}
