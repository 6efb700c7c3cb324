//! Controllers of models whose drive has the measured steering angle, on the vehicle behind an actuator.

use crate::common::{car, designed, options};
use steerwright_control::{DesignOptions, DesignPlant, evaluate};
use steerwright_formats::{
    Bicycle, BicycleEvidence, ChannelSummary, Grade, IdentifiedActuator, Intersample, Pid,
    ReasonCode, StatedActuator,
};

const FAST: StatedActuator = StatedActuator { time_constant_s: 0.0005, delay_s: 0.0 };
const SERVO: StatedActuator = StatedActuator { time_constant_s: 0.05, delay_s: 0.01 };

fn identified(own: StatedActuator, intersample: Intersample) -> Bicycle {
    let mut bicycle = car(1.0);
    bicycle.vehicle.actuator_time_constant_s = own.time_constant_s;
    bicycle.vehicle.actuator_delay_s = own.delay_s;
    let steering = ChannelSummary {
        role: "steering".into(),
        intersample: Some(intersample),
        ..ChannelSummary::default()
    };
    let channels = vec![steering];
    bicycle.evidence = Some(BicycleEvidence { channels, ..BicycleEvidence::default() });
    bicycle
}

fn lacks(pid: &Pid) -> bool {
    pid.designed_for.quality.reasons.iter().any(|r| r.code == ReasonCode::NoActuator)
}

#[test]
fn a_model_of_a_measured_angle_needs_an_actuator() {
    let plant = DesignPlant::from_bicycle(&identified(FAST, Intersample::Bl)).unwrap();
    assert!(plant.lacks_actuator());
    let on_the_vehicle = plant.behind(Some(SERVO));
    let alone = designed(&plant, &options());
    let quality = &alone.designed_for.quality;
    assert!(alone.evidence.met && quality.grade == Grade::Warn, "{quality:?}");
    assert!(lacks(&alone), "{quality:?}");
    let promised = alone.evidence.step.overshoot_percent;
    let reached = evaluate(&on_the_vehicle, &alone).unwrap();
    assert!(!reached.met && reached.step.overshoot_percent > promised + 1.0, "{reached:?}");

    let pid = designed(&plant, &DesignOptions { actuator: Some(SERVO), ..options() });
    assert!(pid.evidence.met && !lacks(&pid));
    assert_eq!(pid.designed_for.actuator, Some(SERVO));
    let reached = evaluate(&on_the_vehicle, &pid).unwrap();
    assert_eq!(reached.step, pid.evidence.step);
    // At other speeds, too.
    let robust = pid.evidence.robustness.as_ref().unwrap();
    let [low, _] = robust.speed_range_mps.unwrap();
    assert_eq!(
        plant.at_speed(low).unwrap().behind(Some(SERVO)),
        on_the_vehicle.at_speed(low).unwrap()
    );
}

#[test]
fn an_angle_along_lines_is_measured() {
    let mut bicycle = identified(FAST, Intersample::Foh);
    assert!(!DesignPlant::from_bicycle(&bicycle).unwrap().lacks_actuator());
    bicycle.evidence.as_mut().unwrap().channels[0].along_lines = true;
    assert!(DesignPlant::from_bicycle(&bicycle).unwrap().lacks_actuator());
}

#[test]
fn a_command_or_an_own_lag_is_an_actuator() {
    for (own, intersample) in [(FAST, Intersample::Zoh), (SERVO, Intersample::Bl)] {
        let plant = DesignPlant::from_bicycle(&identified(own, intersample)).unwrap();
        assert!(!plant.lacks_actuator());
        let pid = designed(&plant, &options());
        assert!(!lacks(&pid));
    }
    assert!(!DesignPlant::from_bicycle(&car(1.0)).unwrap().lacks_actuator());
}

#[test]
fn the_actuator_that_a_drive_shows_is_designed_for() {
    let shown = IdentifiedActuator {
        time_constant_s: SERVO.time_constant_s,
        time_constant_standard_error_s: 0.002,
        delay_s: SERVO.delay_s,
        delay_standard_error_s: 0.001,
        gain: 1.01,
        max_rate_radps: Some(0.3),
        fit: 97.0,
    };
    let shows = |actuator: IdentifiedActuator| {
        let mut bicycle = identified(FAST, Intersample::Bl);
        bicycle.evidence.as_mut().unwrap().actuator = Some(actuator);
        DesignPlant::from_bicycle(&bicycle).unwrap()
    };
    let plant = shows(shown);
    let open = DesignOptions { max_rate_radps: None, ..options() };
    let pid = designed(&plant, &open);
    assert_eq!(pid.designed_for.actuator, Some(SERVO));
    assert!((pid.limits.max_rate_radps - 0.3).abs() < 1e-12 && !lacks(&pid));
    let reached = evaluate(&plant.behind(Some(SERVO)), &pid).unwrap();
    assert_eq!(reached.step, pid.evidence.step);
    // What is stated is preferred.
    let other = StatedActuator { time_constant_s: 0.1, delay_s: 0.0 };
    let stated = DesignOptions { actuator: Some(other), max_rate_radps: Some(0.5), ..options() };
    let pid = designed(&plant, &stated);
    assert_eq!((pid.designed_for.actuator, pid.limits.max_rate_radps), (Some(other), 0.5));
    // One that does not explain the angle is not used.
    for unfit in
        [IdentifiedActuator { fit: 60.0, ..shown }, IdentifiedActuator { gain: 15.2, ..shown }]
    {
        assert_eq!(designed(&shows(unfit), &options()).designed_for.actuator, None);
    }
}
