//! Designs meet their specification on plants of all kinds, or report their shortfalls.

use crate::common::{
    car, designed, identified, identified_car, options as usual, requiring, source, transfer,
};
use steerwright_control::{
    DesignOptions, DesignPlant, Error, design, evaluate, metrics_of, step_response,
};
use steerwright_formats::{Document, Grade, Model, Pid, Reason, ReasonCode, Vehicle};

/// The evidence is what the response shows, read here without the crate's metrics.
fn assert_meets(plant: &DesignPlant, pid: &Pid) {
    let evidence = &pid.evidence;
    assert!(evidence.met && evidence.shortfalls.is_empty(), "{}: {evidence:?}", plant.name);
    let spec = &pid.specification;
    let step = spec.step_rad;
    assert!((step.to_degrees() - 5.0).abs() < 1e-12);
    let trace = step_response(plant, pid, false, 5.0).expect("a response");
    for (t, y) in trace.time.iter().zip(&trace.yaw) {
        let percent = 100.0 * (y / step - 1.0);
        assert!(percent <= spec.overshoot_percent.expect("required"), "{percent} % at {t}");
        if *t >= spec.settling_time_s.expect("required") {
            assert!(percent.abs() <= spec.settling_band_percent, "{percent} % at {t}");
        }
    }
    let disturbed = step_response(plant, pid, true, 5.0).expect("a response");
    let last = disturbed.yaw[disturbed.yaw.len() - 1];
    assert!(100.0 * (last / step - 1.0).abs() <= spec.settling_band_percent);
    assert!(evidence.margins.modulus_margin >= spec.modulus_margin.expect("required"));
    let angle = trace.steering.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    assert!(angle <= pid.limits.max_angle_rad);
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn a_typical_car_in_steering_and_road_wheel_coordinates() {
    let designs = [1.0, 15.0].map(|ratio| {
        let plant = DesignPlant::from_bicycle(&car(ratio)).expect("a plant");
        let pid = designed(&plant, &usual());
        assert_meets(&plant, &pid);
        assert!((pid.limits.max_angle_rad / ratio - 22.0_f64.to_radians()).abs() < 1e-12);
        assert!((pid.limits.max_increment_rad / ratio - 15.0_f64.to_radians()).abs() < 1e-12);
        assert_eq!(Pid::from_json(&pid.to_json(), "pid.json").expect("the same"), pid);
        pid
    });
    // The same car: gains scale with the ratio.
    let (a, b) = (&designs[0], &designs[1]);
    assert!((b.gains.kp / a.gains.kp / 15.0 - 1.0).abs() < 0.05);
    assert_eq!(a.designed_for.speed_mps, 15.0);
    assert_eq!(a.designed_for.model, "bicycle");
}

#[test]
fn plants_of_first_second_and_fourth_order() {
    for (i, mut plant) in [
        transfer(&[40.0], &[8.0], 0.0),
        transfer(&[40.0], &[8.0], 0.05),
        transfer(&[6.0, 300.0], &[9.0, 60.0], 0.0),
        transfer(&[300.0], &[14.0, 60.0], 0.0),
        // (s² + 8s + 40)(s + 30)(s + 40): a mode and two lags.
        transfer(&[4000.0, 200_000.0], &[78.0, 1800.0, 12_400.0, 48_000.0], 0.0),
    ]
    .into_iter()
    .enumerate()
    {
        plant.name = format!("plant {i}");
        let pid = designed(&plant, &usual());
        assert_meets(&plant, &pid);
    }
}

#[test]
fn a_discrete_plant_is_designed_for_on_its_own_grid() {
    let mut plant = identified_car();
    let continuous = DesignPlant::from_plant(&plant).expect("a plant");
    plant.continuous = None;
    let discrete = DesignPlant::from_plant(&plant).expect("a plant");
    assert!((discrete.gain() / continuous.gain() - 1.0).abs() < 1e-9);
    let pid = designed(&discrete, &usual());
    assert_meets(&discrete, &pid);
    let fine = DesignOptions { sample_time_s: 0.015, ..usual() };
    let error = design(&discrete, &source(), &fine).expect_err("no multiple of the grid");
    assert!(matches!(error, Error::SampleTimeMismatch { .. }), "{error}");
    assert!(error.hint().contains("0.01 s"));
}

#[test]
#[ignore = "slow: cargo xtask test"]
fn delays_of_loop_and_plant_are_designed_for() {
    let plant = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    let options = DesignOptions { loop_delay_s: 0.06, ..usual() };
    let pid = designed(&plant, &options);
    assert_meets(&plant, &pid);
    assert_eq!(pid.designed_for.loop_delay_s, 0.06);
    // The same delay in the plant is the same to the loop.
    let mut delayed = plant.clone();
    delayed.input_delay = 0.06;
    let other = designed(&delayed, &usual());
    assert_eq!(pid.gains, other.gains);
    // Without the delay the margins only grow.
    let mut quick = pid.clone();
    quick.designed_for.loop_delay_s = 0.0;
    let without = evaluate(&plant, &quick).expect("evidence");
    assert!(without.margins.modulus_margin > pid.evidence.margins.modulus_margin);
}

#[test]
fn a_steering_times_speed_model_is_read_at_its_speed() {
    let mut plant = identified(&[-8.0], &[40.0], &[1.0], 0.01, 0.0);
    let steering = DesignPlant::from_plant(&plant).expect("a plant");
    plant.input = steerwright_formats::InputKind::SteeringTimesSpeed;
    let product = DesignPlant::from_plant(&plant).expect("a plant");
    assert!((product.gain() / steering.gain() - 15.0).abs() < 1e-9);
}

#[test]
fn a_requirement_that_cannot_be_met_has_a_shortfall() {
    let plant = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    // 0.5 degrees of steering turn 5 degrees in 2 s at best.
    let weak = DesignOptions { max_angle_rad: Some(0.5_f64.to_radians()), ..usual() };
    let pid = designed(&plant, &weak);
    assert!(!pid.evidence.met);
    assert!(pid.evidence.step.largest_angle_rad <= 0.5_f64.to_radians() + 1e-12);
    let settling = pid
        .evidence
        .shortfalls
        .iter()
        .find(|s| s.requirement == "settling_time_s")
        .expect("it cannot settle in time");
    assert!(settling.required == 1.0 && settling.reached > 1.5, "{settling:?}");

    let slow = DesignOptions { sample_time_s: 0.4, ..usual() };
    let error = design(&plant, &source(), &slow).expect_err("too slow");
    assert!(matches!(error, Error::SampleTimeTooLong { need: 4, .. }), "{error}");
    assert!(error.hint().contains("0.25 s"), "{}", error.hint());
}

/// A shorter required settling time never returns a slower loop: the fastest loop that keeps the other
/// requirements is found whatever settling time is required.
#[test]
#[ignore = "slow: cargo xtask test"]
fn a_harder_requirement_is_never_worse_than_a_milder_one() {
    for (name, plant, max_angle_rad) in [
        ("car", DesignPlant::from_bicycle(&car(1.0)).expect("a plant"), None),
        ("weak", DesignPlant::from_bicycle(&car(1.0)).expect("a plant"), Some(0.01)),
        ("late", transfer(&[40.0], &[8.0], 0.05), None),
        ("slow mode", transfer(&[6.0, 300.0], &[9.0, 60.0], 0.0), None),
    ] {
        let mut milder: Option<Pid> = None;
        for settling_time_s in [2.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.05] {
            let required = requiring(|s| s.settling_time_s = Some(settling_time_s));
            // The search on the nominal plant alone; other plants would require a slower loop.
            let options = DesignOptions { max_angle_rad, robust: None, ..required };
            let pid = designed(&plant, &options);
            let (evidence, step) = (&pid.evidence, &pid.evidence.step);
            println!(
                "{name}, {settling_time_s} s: met {}, overshoot {:.3} %, settling {:?}",
                evidence.met, step.overshoot_percent, step.settling_time_s
            );
            let settling = step.settling_time_s.expect("it settles");
            // Only the settling time is relaxed.
            assert!(step.overshoot_percent <= 1.0, "{step:?}");
            assert!(evidence.margins.modulus_margin >= 0.5, "{:?}", evidence.margins);
            assert!(evidence.met || settling > settling_time_s || max_angle_rad.is_some());
            if let Some(milder) = &milder {
                let before = milder.evidence.step.settling_time_s.expect("it settles");
                assert!(
                    settling <= 1.02 * before,
                    "{name}, {settling_time_s} s: {settling} {before}"
                );
                // Both are clearly out of reach: the same loop.
                if milder.specification.settling_time_s.expect("required") < 0.9 * before {
                    assert_eq!(pid.gains, milder.gains, "{name}, {settling_time_s} s");
                }
            }
            milder = Some(pid);
        }
    }
}

/// The same on all plants: the reported shortest settling time is no longer than that of a milder
/// requirement.
#[test]
fn the_shortest_settling_time_is_the_shortest() {
    let limited = DesignOptions { max_rate_radps: Some(0.4), ..usual() };
    for (name, plant, options) in [
        ("car", DesignPlant::from_bicycle(&car(1.0)).expect("a plant"), usual()),
        ("slow servo", DesignPlant::from_bicycle(&car(1.0)).expect("a plant"), limited),
        ("late", transfer(&[40.0], &[8.0], 0.05), usual()),
    ] {
        let mut shortest = f64::INFINITY;
        for settling_time_s in [1.0, 0.5, 0.4, 0.3, 0.25, 0.2, 0.1] {
            let mut options = DesignOptions { ..options };
            options.requirements.settling_time_s = Some(settling_time_s);
            let evidence = designed(&plant, &options).evidence;
            let settling = evidence.step.settling_time_s.expect("it settles");
            println!("{name}, {settling_time_s} s: met {}, settling {settling:.3} s", evidence.met);
            assert!(
                settling <= 1.02 * shortest,
                "{name}, {settling_time_s} s: {settling} {shortest}"
            );
            shortest = shortest.min(settling);
        }
    }
}

/// With an actuator of 0.4 rad/s no step overshoots more than 2 %, and the loop returns to the road with
/// tyres that saturate.
#[test]
fn large_steps_do_not_overshoot_and_the_loop_engages() {
    for speed in [8.0, 15.0, 25.0] {
        let mut vehicle = car(1.0);
        vehicle.vehicle.speed_mps = speed;
        let plant = DesignPlant::from_bicycle(&vehicle).expect("a plant");
        let pid = designed(
            &plant,
            &DesignOptions { max_rate_radps: Some(0.4), ..DesignOptions::default() },
        );
        assert!(pid.evidence.met, "{:?}", pid.evidence.shortfalls);
        let heights: Vec<f64> =
            pid.evidence.steps.iter().map(|s| s.height_rad.to_degrees().round()).collect();
        assert_eq!(heights, [1.0, 2.0, 5.0, 10.0, 20.0, 45.0, 90.0]);
        for s in &pid.evidence.steps {
            assert!(s.step.overshoot_percent < 2.0, "{speed}: {s:?}");
        }
        let engagement = pid.evidence.engagement.as_ref().expect("an envelope");
        assert!(engagement.plant.contains("saturating"), "{}", engagement.plant);
        assert_eq!(engagement.rows.len(), 21);
        for row in &engagement.rows {
            assert!(row.largest_offset_m.is_some_and(|m| m >= 10.0), "{speed}: {row:?}");
        }
        // The file's formula is the controller's.
        let parameters = steerwright_models::files::pid_parameters(&pid);
        for v in [0.0, 0.5, 1.0, speed, 40.0] {
            assert_eq!(pid.limits.largest_angle_rad(v), parameters.largest_angle(v));
        }
        // 6 m/s² in a steady turn of the linear car.
        let acceleration = speed * plant.gain() * pid.largest_angle_rad();
        assert!(
            acceleration <= 6.0 + 1e-9 && (speed < 10.0 || acceleration > 5.999),
            "{speed}: {acceleration}"
        );
    }
}

/// A servo that a drive has shown is not asked for more; what is stated takes precedence.
#[test]
fn the_largest_rate_of_a_model_is_that_of_its_controller() {
    let options = DesignOptions { robust: None, max_rate_radps: None, ..usual() };
    let mut vehicle = car(15.0);
    vehicle.vehicle.actuator_rate_max_radps = Some(0.4);
    let plant = DesignPlant::from_bicycle(&vehicle).expect("a plant");
    let of_model = designed(&plant, &options);
    assert!((of_model.limits.max_rate_radps - 6.0).abs() < 1e-9, "{:?}", of_model.limits);
    let advice = of_model.evidence.advice.join(" ");
    assert!(!advice.contains("no rate of the steering was stated"), "{advice}");
    let stated = designed(&plant, &DesignOptions { max_rate_radps: Some(4.5), ..options });
    assert_eq!(stated.limits.max_rate_radps, 4.5);
}

/// A drive of a measured angle identifies an actuator of hardly any lag. The vehicle of the envelope has one that the
/// integration resolves in few panels; it rejects one below 0.1 ms.
#[test]
fn an_actuator_of_hardly_any_lag_has_an_envelope() {
    let options = DesignOptions { max_rate_radps: Some(0.4), robust: None, ..Default::default() };
    let [prompt, usual] = [2e-5, 4e-3].map(|lag| {
        let mut vehicle = car(1.0);
        vehicle.vehicle.actuator_time_constant_s = lag;
        let plant = DesignPlant::from_bicycle(&vehicle).expect("a plant");
        designed(&plant, &options).evidence.engagement.expect("an envelope").rows
    });
    assert_eq!(prompt, usual);
}

/// On ice a vehicle does not return from where its dry road lets it.
#[test]
fn the_envelope_of_a_vehicle_is_that_of_its_tyres() {
    let offsets = |friction: f64| -> f64 {
        let text = include_str!("../../../examples/drives/multibody/vehicle.json");
        let mut vehicle = Vehicle::from_json(text, "vehicle.json").expect("the example");
        vehicle.tyres.friction_coefficient = friction;
        let model = Model::SingleTrack(Box::new(vehicle));
        let plant = DesignPlant::from_model(&model).expect("a plant");
        let rate = DesignOptions { max_rate_radps: Some(0.4), ..DesignOptions::default() };
        let engagement = designed(&plant, &rate).evidence.engagement.expect("an envelope");
        assert!(engagement.plant.contains("identified vehicle"), "{}", engagement.plant);
        engagement.rows.iter().map(|row| row.largest_offset_m.unwrap_or(-1.0)).sum()
    };
    let [dry, ice] = [1.05, 0.2].map(offsets);
    println!("sum of the largest offsets: {dry} m dry, {ice} m on ice");
    assert!(ice < 0.7 * dry, "{ice} {dry}");
}

/// A design does not include play, so the play that the file of a vehicle states is a reason.
#[test]
fn the_play_of_a_vehicle_is_a_reason() {
    let text = include_str!("../../../examples/drives/multibody/vehicle.json");
    let mut vehicle = Vehicle::from_json(text, "vehicle.json").expect("the example");
    for degrees in [0.0, 0.4] {
        vehicle.actuator.play_rad = f64::to_radians(degrees);
        let model = Model::SingleTrack(Box::new(vehicle.clone()));
        let quality = DesignPlant::from_model(&model).expect("a plant").quality;
        let is_play = |reason: &&Reason| reason.code == ReasonCode::SteeringPlay;
        let play = quality.reasons.iter().find(is_play);
        assert_eq!(play.is_some(), degrees > 0.0, "{quality:?}");
        assert!(play.is_none_or(|r| r.grade == Grade::Warn && r.message.contains("0.40° of play")));
    }
}

/// The phase of 40/(s + 8) and a delay of 50 ms at half a turn a second, as a lag of first order.
#[test]
fn the_lag_of_the_yaw_rate_is_that_of_the_plant() {
    use std::f64::consts::PI;
    let pid = designed(&transfer(&[40.0], &[8.0], 0.05), &usual());
    let lag = pid.limits.large_errors.expect("a stable loop").yaw_rate_lag_s;
    let expected = ((PI / 8.0).atan() + 0.05 * PI).tan() / PI;
    assert!((lag / expected - 1.0).abs() < 0.03, "{lag} {expected}");
}

/// Up to rounding.
#[test]
#[ignore = "slow: cargo xtask test"]
fn an_overshoot_of_zero_may_be_required() {
    for plant in
        [DesignPlant::from_bicycle(&car(1.0)).expect("a plant"), transfer(&[40.0], &[8.0], 0.05)]
    {
        for settling_time_s in [1.0, 4.0] {
            let options = requiring(|s| {
                s.overshoot_percent = Some(0.0);
                s.settling_time_s = Some(settling_time_s);
            });
            let pid = designed(&plant, &options);
            assert!(pid.evidence.met, "{:?}", pid.evidence);
            assert_eq!(pid.evidence.step.overshoot_percent, 0.0);
            let trace = step_response(&plant, &pid, false, 5.0).expect("a response");
            let highest = trace.yaw.iter().fold(0.0_f64, |m, y| m.max(*y));
            assert!(highest <= pid.specification.step_rad * (1.0 + 1e-11), "{highest}");
        }
    }
}

/// Non-minimum phase and slow: no design meets a second, and none is unstable.
#[test]
fn a_non_minimum_phase_plant_has_a_stable_loop() {
    let plant = transfer(&[-6.0, 12.0], &[5.0, 6.0], 0.1);
    let pid = designed(&plant, &usual());
    assert!(!pid.evidence.met);
    assert!(pid.evidence.margins.modulus_margin > 0.3, "{:?}", pid.evidence.margins);
}

#[test]
fn the_same_input_gives_the_same_file() {
    let plant = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    let text = || designed(&plant, &usual()).to_json();
    assert_eq!(text(), text());
    let other = DesignOptions { seed: 7, ..usual() };
    assert_meets(&plant, &designed(&plant, &other));
}

/// A controller is evaluated on another plant than its own, and rejected on one of other coordinates.
#[test]
fn controllers_are_compared_across_plants() {
    let own = DesignPlant::from_bicycle(&car(1.0)).expect("a plant");
    let pid = designed(&own, &usual());
    let again = evaluate(&own, &pid).expect("evidence");
    assert_eq!((again.step, again.margins), (pid.evidence.step, pid.evidence.margins));
    assert_eq!(
        (again.step_with_offset, again.curve),
        (pid.evidence.step_with_offset, pid.evidence.curve)
    );
    let other = transfer(&[40.0], &[8.0], 0.08);
    let evidence = evaluate(&other, &pid).expect("evidence");
    assert!(evidence.margins.modulus_margin < pid.evidence.margins.modulus_margin);
    let spec = &pid.specification;
    let trace = step_response(&other, &pid, false, spec.steady_state_time_s).expect("a response");
    let metrics = metrics_of(&trace, spec.step_rad, spec.settling_band_percent);
    let metrics = metrics.expect("metrics");
    assert_eq!(metrics.step, evidence.step);
    assert!(metrics.step.integral_absolute_error_s > 0.05);
    let wheel = DesignPlant::from_bicycle(&car(15.0)).expect("a plant");
    let error = evaluate(&wheel, &pid).expect_err("another steering angle");
    assert_eq!(error, Error::SteeringRatio { pid: 1.0, plant: 15.0 });
}

/// A slow servo reduces the overshoot of a large step; the gains must not depend on it.
#[test]
fn a_servos_rate_limit_is_not_what_keeps_the_overshoot_down() {
    let plant = identified_car();
    let plant = DesignPlant::from_plant(&plant).expect("a plant");
    let options = DesignOptions { max_rate_radps: Some(0.4 * plant.steering_ratio), ..usual() };
    let pid = designed(&plant, &options);
    assert_meets(&plant, &pid);
    let servo = pid.limits.max_rate_radps * pid.sample_time_s;
    assert!(
        pid.evidence.step.largest_increment_rad > 0.99 * servo,
        "the servo is not at its limit"
    );
    let small = pid.evidence.small_step.expect("a small step");
    assert!(small.overshoot_percent <= 1.0, "{small:?}");
    assert!(small.settling_time_s.expect("it settles") <= 1.0, "{small:?}");
}
