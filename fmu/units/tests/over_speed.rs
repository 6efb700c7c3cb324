//! Controller and path with a table over speed in their files.
#![allow(clippy::unwrap_used)]

use crate::common::{get, path, path_over_speed, pid, set, start, step};
use fmi2_export::{CoSimulationUnit, Resources};
use steerwright_formats::{
    DesignEvidence, DesignedFor, Document, GuidanceAdvice, GuidanceEntry, Limits, Pid, PidGains,
    Provenance, ScheduleEntry, Specification,
};
use steerwright_units::LateralPid;

fn gains(kp: f64) -> PidGains {
    PidGains {
        kp,
        ki: 2.0 * kp,
        kd: 0.05 * kp,
        derivative_filter_time_s: 0.02,
        setpoint_weight_proportional: 0.6,
        setpoint_weight_derivative: 0.0,
        anti_windup_time_s: 0.2,
    }
}

/// A controller designed at 15 m/s, with gains of 5, 15 and 30 m/s or with none but its own.
fn file(over_speed: bool) -> Pid {
    let guidance = GuidanceAdvice {
        feedforward_gain_radm: 2.5,
        preview_time_s: 0.1,
        yaw_acceleration_gain_s2: 0.0,
        yaw_jerk_gain_s3: 0.0,
    };
    let entry = |(speed_mps, kp)| ScheduleEntry {
        speed_mps,
        gains: gains(kp),
        yaw_rate_lag_s: None,
        rate_reserve_time_s: None,
        guidance,
    };
    let entries = [(5.0, 6.0), (15.0, 2.0), (30.0, 1.0)].map(entry);
    Pid {
        schema: Pid::SCHEMA.into(),
        name: "controller".into(),
        sample_time_s: 0.01,
        gains: gains(2.0),
        limits: Limits {
            max_angle_rad: 3.0,
            max_increment_rad: 1.0,
            max_rate_radps: 100.0,
            large_errors: None,
            lateral_acceleration: None,
        },
        designed_for: DesignedFor { speed_mps: 15.0, steering_ratio: 1.0, ..Default::default() },
        specification: Specification::default(),
        evidence: DesignEvidence::default(),
        guidance,
        schedule: if over_speed { entries.to_vec() } else { vec![] },
        provenance: Provenance::default(),
    }
}

fn opened(file: &Pid) -> LateralPid {
    let bytes = file.to_json().into_bytes();
    LateralPid::open(&Resources::from(vec![("pid.json".into(), bytes)])).unwrap()
}

/// The first output for a yaw error of 0.1 rad: kp·b·e and the integral action of one tick.
fn first_output(unit: &mut LateralPid) -> f64 {
    set(unit, "yaw_reference", 0.1);
    set(unit, "yaw", 0.0);
    start(unit);
    step(unit, 0.01);
    get(unit, "steering_angle")
}

#[test]
fn the_gains_follow_the_speed() {
    let without = |speed: f64| {
        let mut unit = opened(&file(false));
        set(&mut unit, "speed", speed);
        first_output(&mut unit)
    };
    let with = |speed: Option<f64>| {
        let mut unit = opened(&file(true));
        speed.into_iter().for_each(|speed| set(&mut unit, "speed", speed));
        first_output(&mut unit)
    };
    assert_eq!(without(5.0), without(30.0));
    // At the speed of the design, and where the input is not connected, both are alike.
    assert_eq!(with(Some(15.0)), without(15.0));
    assert_eq!(with(None), without(15.0));
    assert!((with(Some(5.0)) / without(5.0) - 3.0).abs() < 1e-12);
    assert!((with(Some(10.0)) / without(10.0) - 2.0).abs() < 1e-12);
    assert!((with(Some(90.0)) / without(90.0) - 0.5).abs() < 1e-12);
}

/// The parameter reads as the gain of the design; another value holds at every speed.
#[test]
fn a_gain_that_is_set_holds_at_every_speed() {
    let mut unit = opened(&file(true));
    assert_eq!(get(&mut unit, "kp"), 2.0);
    set(&mut unit, "kp", 2.0);
    set(&mut unit, "ki", 0.0);
    set(&mut unit, "setpoint_weight_proportional", 1.0);
    set(&mut unit, "speed", 5.0);
    assert!((first_output(&mut unit) - 0.6).abs() < 1e-12);
    let mut unit = opened(&file(true));
    set(&mut unit, "kp", 3.0);
    set(&mut unit, "ki", 0.0);
    set(&mut unit, "setpoint_weight_proportional", 1.0);
    set(&mut unit, "speed", 5.0);
    assert!((first_output(&mut unit) - 0.3).abs() < 1e-12);
}

/// A state that was loaded goes on with the table of its archive.
#[test]
fn a_loaded_state_keeps_the_table() {
    let mut saved = opened(&file(true));
    first_output(&mut saved);
    let mut loaded = opened(&file(true));
    loaded.load(&saved.save()).unwrap();
    for unit in [&mut saved, &mut loaded] {
        set(unit, "speed", 7.0);
        set(unit, "yaw", 0.02);
        for _ in 0..5 {
            step(unit, 0.01);
        }
    }
    assert_eq!(get(&mut saved, "steering_angle"), get(&mut loaded, "steering_angle"));
    // The bytes are those of a controller without a table.
    let mut plain = opened(&file(false));
    plain.load(&saved.save()).unwrap();
    assert_eq!(plain.save(), saved.save());
    assert_eq!(pid().save().len(), opened(&file(true)).save().len());
}

#[test]
fn the_guidance_follows_the_speed() {
    let entry = |speed_mps: f64, feedforward_gain_radm: f64| GuidanceEntry {
        speed_mps,
        lookahead_time_s: 1.0,
        lookahead_min_m: 5.0,
        preview_time_s: 0.2,
        feedforward_gain_radm,
        yaw_acceleration_gain_s2: -0.006,
        yaw_jerk_gain_s3: 0.0004,
    };
    let at = |mut unit: steerwright_units::ReferencePath, speed: f64| {
        set(&mut unit, "speed", speed);
        start(&mut unit);
        step(&mut unit, 0.01);
        get(&mut unit, "steering_feedforward")
    };
    let table = vec![entry(5.0, 1.35), entry(20.0, 5.4)];
    let share =
        |speed: f64| at(path_over_speed(true, table.clone()), speed) / at(path(true), speed);
    for (speed, expected) in [(2.0, 0.5), (5.0, 0.5), (12.5, 1.25), (20.0, 2.0), (40.0, 2.0)] {
        assert!((share(speed) - expected).abs() < 1e-9, "{speed}: {}", share(speed));
    }
}

/// Speeds that do not increase and gains without integral action are refused.
#[test]
fn damaged_tables_are_refused() {
    let refused = |file: Pid| {
        let bytes = file.to_json().into_bytes();
        LateralPid::open(&Resources::from(vec![("pid.json".into(), bytes)])).err().unwrap()
    };
    let mut unsorted = file(true);
    unsorted.schedule.swap(0, 1);
    let error = refused(unsorted);
    assert!(error.contains("schedule[1].speed_mps") && error.contains("hint: "), "{error}");
    let mut without = file(true);
    without.schedule[2].gains.ki = 0.0;
    let error = refused(without);
    assert!(error.contains("schedule[2].gains.ki"), "{error}");
}
