//! The understeer gradient and the tyre limit as goals of a manoeuvre: what is stated is what identifications of the simulated
//! manoeuvre reach, on the plants of the FMUs, other implementations than those of the design.

use crate::common::recording;
use crate::known::Random;
use steerwright_formats::{
    Bicycle, Document, Manoeuvre, ManoeuvreGoal, ManoeuvreKind, ManoeuvreLimits, Vehicle,
    VehicleData,
};
use steerwright_models::files::{bicycle_parameters, nonlinear_parameters};
use steerwright_models::{BicyclePlant, NonlinearVehicle};
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::single_track::{
    Drive, DriveSegment, Parameter, SingleTrackModel, SingleTrackOptions, VehicleOptions,
    identify_single_track,
};
use steerwright_sysid::{Error, ExcitationOptions, excite, excite_vehicle};

const T: f64 = 0.02;
const NOISE: f64 = 0.004;

fn bicycle() -> Bicycle {
    Bicycle::new(VehicleData { name: "car".into(), steering_ratio: 15.0, ..VehicleData::default() })
}

/// A car of 0.85 g in front and 1 g behind.
fn model() -> SingleTrackModel {
    SingleTrackModel::default()
        .with(Parameter::StiffnessFront, 12.0)
        .with(Parameter::StiffnessRear, 17.0)
        .with(Parameter::FrictionFront, 0.85)
        .with(Parameter::FrictionBalance, 1.18)
        .with(Parameter::Lag, 0.05)
}

fn vehicle() -> Vehicle {
    model().vehicle(&VehicleOptions { steering_ratio: 15.0, ..VehicleOptions::default() })
}

fn options(goal: ManoeuvreGoal, speeds_mps: Vec<f64>, acceleration: f64) -> ExcitationOptions {
    ExcitationOptions {
        goal,
        speeds_mps,
        time_s: 80.0,
        limits: ManoeuvreLimits {
            max_lateral_acceleration_mps2: acceleration,
            max_angle_rad: None,
            max_rate_radps: Some(7.0),
            max_offset_m: None,
        },
        noise_density: NOISE * NOISE * T,
        sample_time_s: T,
        assumed_uncertainty: 0.02,
        ..ExcitationOptions::default()
    }
}

/// Speed and steering angle at the samples.
fn steps(manoeuvre: &Manoeuvre) -> Vec<[f64; 2]> {
    let of = |block: &steerwright_formats::ManoeuvreBlock| {
        let speed = manoeuvre.signals[block.signal].speed_mps;
        let at = |k: usize| [speed, manoeuvre.steering_rad(block, k)];
        (0..manoeuvre.block_samples()).map(at).collect::<Vec<_>>()
    };
    manoeuvre.schedule.iter().flat_map(of).collect()
}

/// The standard deviation about the truth of values by seed.
fn deviation(values: &[f64], truth: f64) -> f64 {
    (values.iter().map(|x| (x - truth).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn understeer(vehicle: &VehicleData) -> f64 {
    bicycle_parameters(vehicle).understeer_gradient()
}

/// Over 40 drives the standard error is within a quarter, about 2.3 of the standard errors 1/√80 of a standard deviation.
#[test]
#[ignore = "slow: cargo xtask test"]
fn the_understeer_gradient_errs_as_much_as_is_stated() {
    let car = bicycle();
    let manoeuvre =
        excite(&car, &options(ManoeuvreGoal::Understeer, vec![10.0, 25.0], 4.0)).unwrap();
    let mut plant = BicyclePlant::new(bicycle_parameters(&car.vehicle)).unwrap();
    let driven = steps(&manoeuvre);
    let mut yaw_rate = Vec::new();
    for [speed, angle] in &driven {
        yaw_rate.push(plant.yaw_rate());
        plant.steering_angle = *angle;
        plant.speed = *speed;
        plant.step(T).unwrap();
    }
    let of_seed = |seed: u64| {
        let mut random = Random(2000 + seed);
        let noisy = yaw_rate.iter().map(|r| r + NOISE * random.normal()).collect();
        let mut log = recording(T, driven.iter().map(|x| x[1]).collect(), noisy);
        log.speed = Some(driven.iter().map(|x| x[0]).collect());
        log.steering_ratio = 15.0;
        understeer(&identify_bicycle(&log, &BicycleOptions::default()).unwrap().bicycle.vehicle)
    };
    let found: Vec<f64> = (0..40).map(of_seed).collect();
    let truth = understeer(&car.vehicle);
    let ratio = deviation(&found, truth) / manoeuvre.expected.largest_error;
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    println!("{truth} ± {}: mean {mean}, {ratio} of it", manoeuvre.expected.largest_error);
    assert!((0.7..1.35).contains(&ratio), "{ratio}");
}

#[test]
fn the_goal_is_what_is_minimised() {
    let of = |goal, speeds: &[f64]| {
        let manoeuvre = excite(&bicycle(), &options(goal, speeds.to_vec(), 4.0)).unwrap();
        manoeuvre.checked("m.json").unwrap();
        assert_eq!(manoeuvre.purpose.goal, goal);
        let stated = manoeuvre.expected.parameters.iter();
        let own = stated.clone().find(|p| p.name == "understeer_gradient").unwrap();
        (own.standard_error, manoeuvre.expected.largest_error, manoeuvre.expected)
    };
    let (understeer, largest, expected) = of(ManoeuvreGoal::Understeer, &[10.0, 25.0]);
    assert!((understeer / largest - 1.0).abs() < 1e-9, "{understeer} {largest}");
    assert!(expected.bound.is_none(), "{expected:?}");
    let (by_response, _, _) = of(ManoeuvreGoal::Response, &[10.0, 25.0]);
    let (at_one_speed, _, _) = of(ManoeuvreGoal::Understeer, &[17.5]);
    println!("{understeer}, of the response {by_response}, at one speed {at_one_speed}");
    assert!(understeer < 0.95 * by_response, "{understeer} {by_response}");
    assert!(understeer < 0.7 * at_one_speed, "{understeer} {at_one_speed}");
}

#[test]
fn a_growing_manoeuvre_keeps_its_limits_on_the_vehicle_of_the_fmu() {
    let vehicle = vehicle();
    for limit in [4.0, 7.0] {
        let options = options(ManoeuvreGoal::TyreLimit, vec![20.0], limit);
        let manoeuvre = excite_vehicle(&vehicle, &options).unwrap();
        manoeuvre.checked("m.json").unwrap();
        let mut plant = NonlinearVehicle::new(nonlinear_parameters(&vehicle)).unwrap();
        plant.speed = 20.0;
        plant.start().unwrap();
        let (mut largest, mut sideslip) = (0.0_f64, 0.0_f64);
        for [speed, angle] in steps(&manoeuvre) {
            plant.steering_angle = angle;
            plant.speed = speed;
            let before = plant.lateral_velocity();
            plant.step(T).unwrap();
            let acceleration = (plant.lateral_velocity() - before) / T + speed * plant.yaw_rate();
            largest = largest.max(acceleration.abs());
            sideslip = sideslip.max((plant.lateral_velocity() / speed).abs());
        }
        let peaks = manoeuvre.signals[0].peaks.lateral_acceleration_mps2;
        println!("{limit}: {} {largest} {sideslip} {peaks:?}", manoeuvre.kind);
        assert!(peaks[0] <= peaks[1] && peaks[1] <= limit, "{peaks:?}");
        assert!(largest > 0.9 * limit && largest < 1.02 * limit, "{largest}");
        assert!(sideslip < 0.2, "{sideslip}");
        assert_eq!(manoeuvre.alternatives.len(), 5);
        let best = manoeuvre.expected.largest_error;
        assert!(manoeuvre.alternatives.iter().all(|other| other.largest_error >= best));
    }
}

/// Near the limit of grip the friction of both axles is known, far below it from the prior alone.
#[test]
fn the_friction_needs_lateral_acceleration() {
    let of = |limit| {
        let options = options(ManoeuvreGoal::TyreLimit, vec![20.0], limit);
        let options = ExcitationOptions { max_error: Some(0.1), ..options };
        excite_vehicle(&vehicle(), &options).unwrap().expected
    };
    let [gentle, brisk, hard] = [2.0, 5.0, 7.5].map(of);
    let errors = [&gentle, &brisk, &hard].map(|expected| expected.largest_error);
    println!("{errors:?}");
    assert!(errors[0] > 0.1 && errors[2] < 0.03, "{errors:?}");
    assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
    assert!(!gentle.met && gentle.needed_time_s.is_none_or(|time| time > 80.0), "{gentle:?}");
    assert!(hard.met && hard.needed_time_s.unwrap() <= 80.0, "{hard:?}");
    for name in ["friction_coefficient_front", "friction_coefficient_rear"] {
        let own = hard.parameters.iter().find(|p| p.name == name).unwrap();
        let share = own.standard_error / own.value;
        assert!(share > 0.0 && share <= hard.largest_error * (1.0 + 1e-9), "{own:?}");
    }
}

/// The root mean square error over drives of the vehicle of the FMU is the stated one.
#[test]
#[ignore = "slow: cargo xtask test"]
fn the_friction_errs_as_much_as_is_stated() {
    let vehicle = vehicle();
    let options = options(ManoeuvreGoal::TyreLimit, vec![20.0], 7.5);
    let manoeuvre = excite_vehicle(&vehicle, &options).unwrap();
    let mut plant = NonlinearVehicle::new(nonlinear_parameters(&vehicle)).unwrap();
    plant.speed = 20.0;
    plant.start().unwrap();
    let driven = steps(&manoeuvre);
    let mut yaw_rate = Vec::new();
    for [speed, angle] in &driven {
        yaw_rate.push(plant.yaw_rate());
        plant.steering_angle = *angle;
        plant.speed = *speed;
        plant.step(T).unwrap();
    }
    let half = driven.len() / 2;
    let of_seed = |seed: u64| {
        let mut random = Random(3000 + seed);
        let noisy: Vec<f64> = yaw_rate.iter().map(|r| r + NOISE * random.normal()).collect();
        let part = |range: std::ops::Range<usize>| Drive {
            sample_time_s: T,
            steering_ratio: 15.0,
            steering_delay_s: 0.5 * T,
            segments: vec![DriveSegment {
                steering_rad: driven[range.clone()].iter().map(|x| x[1]).collect(),
                speed_mps: driven[range.clone()].iter().map(|x| x[0]).collect(),
                yaw_rate_radps: noisy[range].to_vec(),
                ..DriveSegment::default()
            }],
        };
        let all = [part(0..half), part(half..driven.len())];
        let single = SingleTrackOptions::default();
        let found = identify_single_track(&all[0], Some(&all[1]), &single).unwrap();
        let of = |parameter| found.model.get(parameter);
        let front = of(Parameter::FrictionFront);
        [
            front,
            front * of(Parameter::FrictionBalance),
            of(Parameter::StiffnessFront),
            of(Parameter::StiffnessRear),
        ]
    };
    let found: Vec<[f64; 4]> = (0..12).map(of_seed).collect();
    for (i, name) in [
        "friction_coefficient_front",
        "friction_coefficient_rear",
        "cornering_stiffness_front_per_load",
        "cornering_stiffness_rear_per_load",
    ]
    .into_iter()
    .enumerate()
    {
        let stated = manoeuvre.expected.parameters.iter().find(|p| p.name == name).unwrap();
        let values: Vec<f64> = found.iter().map(|f| f[i]).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let ratio = deviation(&values, stated.value) / stated.standard_error;
        println!(
            "{name}: {} ± {}, mean {mean}, {ratio} of it",
            stated.value, stated.standard_error
        );
        assert!(ratio < 1.6, "{name}: {ratio}");
    }
}

#[test]
fn the_actuator_of_a_vehicle_limits_its_manoeuvre() {
    let mut vehicle = vehicle();
    vehicle.actuator.road_wheel_rate_max_radps = 0.15;
    let options = options(ManoeuvreGoal::TyreLimit, vec![20.0], 6.0);
    let manoeuvre = excite_vehicle(&vehicle, &options).unwrap();
    assert_eq!(manoeuvre.limits.max_rate_radps, Some(0.15 * vehicle.actuator.steering_ratio));
    for signal in &manoeuvre.signals {
        assert!(signal.peaks.rate_radps <= 0.15 * 15.0, "{:?}", signal.peaks);
    }
}

#[test]
fn a_vehicle_and_a_bicycle_have_their_goals() {
    let vehicle = vehicle();
    let of_response = options(ManoeuvreGoal::Response, vec![20.0], 5.0);
    let error = excite_vehicle(&vehicle, &of_response).unwrap_err();
    assert!(matches!(error, Error::Option { option: "goal", .. }), "{error}");
    // A bicycle has the tyres of the priors: it is steered less than a vehicle whose grip is known.
    let of_tyres = options(ManoeuvreGoal::TyreLimit, vec![20.0], 8.0);
    let usual = excite(&bicycle(), &of_tyres).unwrap();
    usual.checked("m.json").unwrap();
    assert_ne!(usual.kind, ManoeuvreKind::Multisine);
    let known = excite_vehicle(&vehicle, &of_tyres).unwrap();
    let of = |m: &Manoeuvre| m.signals[0].peaks.lateral_acceleration_mps2[0];
    println!("{} {}", of(&usual), of(&known));
    assert!(of(&usual) < of(&known), "{} {}", of(&usual), of(&known));
    let unstable = SingleTrackModel::default()
        .with(Parameter::StiffnessFront, 20.0)
        .with(Parameter::StiffnessRear, 9.0)
        .vehicle(&VehicleOptions::default());
    let error = excite_vehicle(&unstable, &options(ManoeuvreGoal::TyreLimit, vec![40.0], 5.0));
    assert!(matches!(error, Err(Error::Unstable { .. })), "{error:?}");
}
