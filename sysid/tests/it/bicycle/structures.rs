//! The choice of a structure: each of the three on a drive that needs it, and no more.

use super::{DRIVE, Drive, drive};
use crate::common::{car, recording};
use crate::known::limit_drive::LimitDrive;
use steerwright_drivelog::DriveLog;
use steerwright_formats::{Model, Structure, VehicleDirection};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::single_track::{SingleTrackModel, identify_vehicle};
use steerwright_sysid::{Choice, ChoiceOptions, identify_structure};
use steerwright_sysid::{Error, identify};

fn choice(log: &DriveLog) -> Choice {
    let found = identify_structure(log, &ChoiceOptions::default()).unwrap();
    for row in &found.rows {
        println!("{}: {:?} {:?}", row.structure, row.fit, row.errors);
    }
    println!();
    found
}

#[test]
fn the_structure_with_the_smallest_error_is_chosen() {
    let noisy = Drive { noise: 0.004, ..DRIVE };
    let one_speed = drive(car(), Drive { slowest: 15.0, fastest: 15.0, ..noisy });
    let found = choice(&one_speed);
    assert_eq!(found.identified.model.structure(), Structure::StateSpace);
    assert!(found.rows[1].fit.as_ref().unwrap_err().contains("hardly varies"));

    let found = choice(&drive(car(), noisy));
    assert_eq!(found.identified.model.structure(), Structure::Bicycle);
    let is_worse = |place: usize, found: &Choice| {
        let (ratio, error) = found.rows[place].errors.unwrap();
        ratio > 1.05 && ratio - 1.0 > 2.0 * error
    };
    assert!(is_worse(0, &found));
    assert_eq!(found.rows[1].errors, Some((1.0, 0.0)));

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
    assert_eq!(found.identified.model.structure(), Structure::SingleTrack);
    assert!(is_worse(0, &found) && is_worse(1, &found));
    assert!(found.rows.iter().all(|row| row.excluded.is_none()), "{:?}", found.rows);

    // The share of the front axle, which the yaw rate hardly depends on, leaves the gain as certain as it is.
    let Model::SingleTrack(vehicle) = found.identified.model else { panic!() };
    let (body, tyres) = (&vehicle.body, &vehicle.tyres);
    let gain = |d: &VehicleDirection| {
        let [a, b] = [body.distance_front_m, body.distance_rear_m].map(|x| x * d.wheelbase.exp());
        let front = tyres.cornering_stiffness_front_npr * d.cornering_stiffness_front.exp();
        let rear = tyres.cornering_stiffness_rear_npr * d.cornering_stiffness_rear.exp();
        let understeer = body.mass_kg / (a + b) * (b / front - a / rear);
        25.0 / (a + b + understeer * 25.0 * 25.0)
    };
    let certain = gain(&VehicleDirection::default());
    let evidence = vehicle.evidence.as_ref().unwrap();
    let moved = evidence.directions.iter().map(|d| (gain(d) / certain).ln().powi(2));
    let error = moved.sum::<f64>().sqrt();
    println!("standard error of the gain: {error}");
    assert!(error > 0.0 && error < 0.02, "{error}");
}

#[test]
fn without_speed_there_is_one_structure() {
    let log = DriveLog { speed: None, ..drive(car(), Drive { noise: 0.004, ..DRIVE }) };
    let found = choice(&log);
    assert_eq!(found.identified.model.structure(), Structure::StateSpace);
    for row in &found.rows[1..] {
        assert_eq!(row.fit, Err("the log has no speed".into()));
    }
}

/// State space alone leaves out what crawls, as the choice does: one model has one grade.
#[test]
fn state_space_alone_is_that_of_the_choice() {
    let mut log =
        drive(car(), Drive { slowest: 15.0, fastest: 15.0, noise: 0.004, seconds: 240.0, ..DRIVE });
    // No tyre is near its limit, so that no other structure is tried.
    log.input.iter_mut().chain(&mut log.output).for_each(|x| *x *= 0.5);
    let crawls = 0..700;
    let mut speed = vec![15.0; log.len()];
    speed[crawls.clone()].fill(0.4);
    log.output[crawls].iter_mut().for_each(|r| *r *= 0.1);
    log.speed = Some(speed);
    let options = ChoiceOptions::default();
    let alone = identify(&log, &options.state_space).unwrap().plant;
    let Model::StateSpace(chosen) = choice(&log).identified.model else { panic!("one speed") };
    assert_eq!(alone, *chosen);
    assert!(alone.evidence.warnings.iter().any(|w| w.contains("left out")), "{:?}", alone.evidence);
}

/// A drive with other speeds.
fn at_speeds(speed: impl Fn(usize) -> f64) -> DriveLog {
    let mut log = drive(car(), Drive { noise: 0.004, ..DRIVE });
    let speeds: Vec<f64> = (0..log.len()).map(speed).collect();
    // A kinematic vehicle of 2.6 m.
    log.output = log.input.iter().zip(&speeds).map(|(angle, v)| v * angle / 2.6).collect();
    log.speed = Some(speeds);
    log
}

#[test]
fn drives_without_a_fast_part_are_models_or_errors() {
    let empty = recording(0.04, Vec::new(), Vec::new());
    let sample = recording(0.04, vec![0.01], vec![0.02]);
    let with_speed =
        |log: &DriveLog, v: f64| DriveLog { speed: Some(vec![v; log.len()]), ..log.clone() };
    let slow = |k: usize| 1.25 * (1.0 + (k as f64 * 0.02).sin());
    // Above 3 m/s for fewer samples than a segment needs.
    let nearly_slow = |k: usize| if (500..503).contains(&k) { 60.0 } else { 1.0 };
    for (name, log) in [
        ("empty", empty.clone()),
        ("empty, with speed", with_speed(&empty, 0.0)),
        ("one sample", sample.clone()),
        ("one sample, with speed", with_speed(&sample, 10.0)),
        ("slow", at_speeds(slow)),
        ("nearly slow", at_speeds(nearly_slow)),
        ("standing", at_speeds(|_| 0.0)),
        ("reversing", at_speeds(|_| -1.8)),
        ("fast at one end", at_speeds(|k| if k < 2980 { 0.5 } else { 20.0 })),
        ("without an end", at_speeds(|k| if k < 100 { 20.0 } else { f64::NAN })),
    ] {
        let options = ChoiceOptions::default();
        match identify_structure(&log, &options) {
            Ok(found) => println!("{name}: {:?}", found.rows),
            Err(error) => assert!(!error.hint().is_empty(), "{name}: {error}"),
        }
        for error in [
            identify_bicycle(&log, &options.bicycle).err(),
            identify_vehicle(&log, &options.single_track).err(),
        ] {
            println!("{name}: {}", error.map(|e| e.to_string()).unwrap_or_default());
        }
    }
    let crawling = at_speeds(slow);
    let error = identify_bicycle(&crawling, &BicycleOptions::default()).unwrap_err();
    assert!(matches!(error, Error::TooSlow { least_mps: 3.0, .. }), "{error}");
    // A vehicle of a tenth of the length is fast at a third of the speed.
    let small = DriveLog { output: crawling.output.iter().map(|r| 10.0 * r).collect(), ..crawling };
    let found = identify_bicycle(&small, &BicycleOptions::default()).unwrap();
    assert_eq!(found.bicycle.provenance.options["least_speed_mps"], "0.9");
    let found = choice(&small);
    assert!(found.rows[1].fit.is_ok(), "{:?}", found.rows);
}
