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
    // A vehicle.json is not the model that was validated: the best of the others is chosen.
    let found = choice(&log);
    assert!(!matches!(found.model, IdentifiedModel::Vehicle(_)));
    let [state_space, bicycle, single_track] = &found.rows[..] else { panic!("{:?}", found.rows) };
    let (ratio, error) = single_track.errors.unwrap();
    assert!(ratio + 2.0 * error < 1.0, "{ratio} ± {error}");
    assert!(single_track.excluded.unwrap().contains("relaxation"));
    assert!(single_track.structure == Structure::SingleTrack && !single_track.is_rejected);
    assert_eq!((state_space.excluded, bicycle.excluded), (None, None));
    let best = state_space.errors.unwrap().0.min(bicycle.errors.unwrap().0);
    assert!((best - 1.0).abs() < 1e-12, "errors are compared with what may be chosen: {best}");
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
