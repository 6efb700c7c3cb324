//! Controllers for a range of speeds.

use crate::common::{car, identified_car, source};
use steerwright_control::{
    DesignOptions, DesignPlant, Error, design_over_speeds, evaluate, guidance_for,
    guidance_schedule,
};
use steerwright_formats::{Document, Pid, Requirement, SpeedRampKind};

/// An actuator of 34°/s at the road wheel.
fn options() -> DesignOptions {
    DesignOptions { max_rate_radps: Some(0.6), ..DesignOptions::default() }
}

fn designed(options: &DesignOptions, speeds: [f64; 2]) -> Pid {
    let plant = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    design_over_speeds(&plant, &source(), options, speeds, &|_| ()).expect("a design")
}

/// From 5 to 30 m/s the specification holds at and between few entries, and gains of one speed do not hold
/// there. The file is read back as it was written.
#[test]
fn the_specification_holds_over_the_range() {
    let pid = designed(&options(), [5.0, 30.0]);
    let over = pid.evidence.over_speed.as_ref().expect("evidence");
    let entries = pid.schedule.len();
    println!("{entries} entries");
    assert!((3..=9).contains(&entries), "{entries}");
    assert_eq!(over.frozen.len(), 4 * entries - 3);
    assert_eq!(over.frozen.iter().filter(|f| f.breakpoint).count(), entries);
    for row in &over.frozen {
        assert!(row.met, "{} m/s: {:?}", row.speed_mps, row.shortfalls);
        assert!(row.share_kept.expect("an ensemble") > 0.8, "{row:?}");
        assert!(row.margins.gain_margin_db.is_none_or(|gain| gain > 6.0), "{row:?}");
    }
    assert!(over.met);
    assert_eq!(Pid::from_json(&pid.to_json(), "pid.json").expect("a file"), pid);

    // The gains at 15 m/s, which files without a table have, miss the specification at the ends.
    let fixed = Pid { schedule: Vec::new(), ..pid.clone() };
    for speed in [5.0, 30.0] {
        let mut there = car(1.0);
        there.vehicle.speed_mps = speed;
        let plant = DesignPlant::from_bicycle(&there).expect("a plant");
        assert!(evaluate(&plant, &pid).expect("evidence").met, "{speed}");
        assert!(!evaluate(&plant, &fixed).expect("evidence").met, "{speed}");
    }
}

/// Where the lateral acceleration limits the steering to less than the specification's offset of 1°, the requirement
/// follows the limit.
#[test]
fn an_offset_that_the_limit_does_not_hold_is_not_required() {
    let pid = designed(&options(), [20.0, 40.0]);
    let over = pid.evidence.over_speed.as_ref().expect("evidence");
    let fastest = over.frozen.last().expect("a row");
    assert!(fastest.max_angle_rad < pid.specification.steering_offset_rad, "{fastest:?}");
    let with_offset = Requirement::SteadyStateWithOffset.name();
    for row in &over.frozen {
        let missed = row.shortfalls.iter().any(|s| s.requirement == with_offset);
        assert!(!missed, "{} m/s: {:?}", row.speed_mps, row.shortfalls);
    }
}

/// While the speed changes, the loop stays near the specification and on the path.
#[test]
fn speed_ramps_leave_the_loop_on_the_path() {
    let pid = designed(&options(), [5.0, 30.0]);
    let ramps = &pid.evidence.over_speed.as_ref().expect("evidence").ramps;
    assert_eq!(ramps.len(), 4);
    for ramp in ramps {
        println!("{ramp:?}");
        match ramp.manoeuvre {
            SpeedRampKind::YawSteps => {
                assert!(ramp.overshoot_percent.expect("steps") < 4.0);
                assert!(ramp.settling_time_s.expect("it settles") < 1.2);
            }
            SpeedRampKind::ConstantRadius => {
                assert!(ramp.largest_cross_track_error_m.expect("a path") < 0.02);
            }
        }
    }
}

/// The guidance at an entry is that of the entry, and between two it lies between them.
#[test]
fn the_guidance_follows_the_table() {
    let pid = designed(&options(), [10.0, 20.0]);
    let table = guidance_schedule(&pid);
    for entry in &table {
        let here = guidance_for(&pid, entry.speed_mps);
        assert_eq!(here.preview_time_s, entry.preview_time_s);
        assert_eq!(here.feedforward_gain_radm, entry.feedforward_gain_radm);
    }
    let [first, second] = [&table[0], &table[1]];
    let middle = guidance_for(&pid, 0.5 * (first.speed_mps + second.speed_mps));
    let mean = 0.5 * (first.feedforward_gain_radm + second.feedforward_gain_radm);
    assert!((middle.feedforward_gain_radm - mean).abs() < 1e-12);
}

/// With a slow actuator the lowest speeds miss the specification; the table names the reason.
#[test]
fn what_no_gains_reach_has_a_reason() {
    let pid = designed(&DesignOptions { max_rate_radps: Some(0.15), ..options() }, [3.0, 15.0]);
    let over = pid.evidence.over_speed.expect("evidence");
    let slowest = &over.frozen[0];
    assert!(!over.met && !slowest.met);
    let reason = slowest.reason.as_deref().expect("a reason");
    assert!(reason.contains("largest rate") || reason.contains("largest angle"), "{reason}");
    assert!(over.frozen.iter().all(|row| row.met == row.reason.is_none()));
}

#[test]
fn ranges_that_cannot_be_designed_for() {
    let fixed = DesignPlant::from_plant(&identified_car()).expect("a plant");
    let error = design_over_speeds(&fixed, &source(), &options(), [5.0, 30.0], &|_| ());
    let error = error.expect_err("one speed");
    assert!(matches!(error, Error::NotScheduled { .. }), "{error}");
    assert!(error.hint().contains("bicycle"), "{}", error.hint());
    let car = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    for speeds in [[0.5, 30.0], [30.0, 5.0], [10.0, 10.0], [5.0, f64::NAN], [f64::NAN, 5.0]] {
        let error = design_over_speeds(&car, &source(), &options(), speeds, &|_| ());
        assert!(matches!(error, Err(Error::Option { .. })), "{speeds:?}");
    }
}
