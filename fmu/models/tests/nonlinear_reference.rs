//! The nonlinear vehicle against an independent solution, that of `data/nonlinear_reference.py`.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use steerwright_formats::{Body, SteeringActuator, Tyres};
use steerwright_models::{NonlinearParameters, NonlinearVehicle};

/// A case of the reference: its name, its columns, a vehicle at its start.
struct Case {
    name: String,
    columns: BTreeMap<String, f64>,
    vehicle: NonlinearVehicle,
}

fn cases() -> Vec<Case> {
    let text = include_str!("data/nonlinear_reference.csv");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            assert_eq!(fields.len(), header.len());
            let columns: BTreeMap<String, f64> = header
                .iter()
                .zip(&fields)
                .skip(1)
                .map(|(name, field)| ((*name).to_owned(), field.parse().unwrap()))
                .collect();
            let get = |name: &str| columns[name];
            let mut vehicle = NonlinearVehicle::new(NonlinearParameters {
                body: Body {
                    mass_kg: get("mass"),
                    yaw_inertia_kgm2: get("yaw_inertia"),
                    distance_front_m: get("distance_front"),
                    distance_rear_m: get("distance_rear"),
                    centre_of_gravity_height_m: get("centre_of_gravity_height"),
                    track_width_m: get("track_width"),
                    roll_stiffness_front: get("roll_stiffness_front"),
                    roll_time_constant_s: get("roll_time_constant"),
                    drive_share_front: get("drive_share_front"),
                    brake_share_front: get("brake_share_front"),
                    side_force_area_m2: get("side_force_area"),
                    side_force_arm_m: get("side_force_arm"),
                },
                tyres: Tyres {
                    cornering_stiffness_front_npr: get("cornering_stiffness_front"),
                    cornering_stiffness_rear_npr: get("cornering_stiffness_rear"),
                    friction_coefficient: get("friction_coefficient"),
                    friction_balance_rear: get("friction_balance_rear"),
                    shape_factor: get("tyre_shape_factor"),
                    curvature_factor: get("tyre_curvature_factor"),
                    friction_load_sensitivity: get("friction_load_sensitivity"),
                    stiffness_load_sensitivity: get("stiffness_load_sensitivity"),
                    combined_slip: get("combined_slip"),
                },
                actuator: SteeringActuator {
                    steering_ratio: get("steering_ratio"),
                    time_constant_s: get("actuator_time_constant"),
                    delay_s: get("actuator_delay"),
                    road_wheel_rate_max_radps: get("road_wheel_rate_max"),
                    road_wheel_angle_max_rad: get("road_wheel_angle_max"),
                    play_rad: get("steering_play"),
                },
            })
            .unwrap();
            vehicle.speed = get("speed");
            vehicle.crosswind = get("crosswind");
            vehicle.initial_states = [
                get("start_lateral_velocity"),
                get("start_yaw_rate"),
                get("start_road_wheel_angle"),
                get("start_roll_acceleration"),
            ];
            let before = get("speed_before");
            if before == vehicle.speed {
                vehicle.start().unwrap();
            } else {
                // Straight on at another speed to the place where the case begins.
                vehicle.initial_x = -0.01 * before;
                vehicle.start().unwrap();
                let speed = std::mem::replace(&mut vehicle.speed, before);
                vehicle.step(0.01).unwrap();
                vehicle.speed = speed;
            }
            Case { name: fields[0].to_owned(), columns, vehicle }
        })
        .collect()
}

/// Drives the case in `count` steps; largest difference from the reference, states and outputs.
fn error(case: &Case, count: u32) -> f64 {
    let get = |name: &str| case.columns[name];
    let mut vehicle = case.vehicle.clone();
    let h = get("time") / f64::from(count);
    for k in 0..count {
        vehicle.steering_angle = get("steering") + get("slope") * h * f64::from(k);
        vehicle.steering_slope = get("slope");
        vehicle.step(h).unwrap();
    }
    vehicle.steering_angle = get("steering") + get("slope") * get("time");
    [
        (vehicle.lateral_velocity(), "lateral_velocity"),
        (vehicle.yaw_rate(), "yaw_rate"),
        (vehicle.road_wheel_angle(), "road_wheel_angle"),
        (vehicle.states()[3], "roll_acceleration"),
        (vehicle.yaw(), "yaw"),
        (vehicle.x(), "x"),
        (vehicle.y(), "y"),
        (vehicle.lateral_acceleration(), "lateral_acceleration"),
    ]
    .into_iter()
    .map(|(value, name)| (value - get(name)).abs())
    .fold(0.0, f64::max)
}

#[test]
fn agrees_with_the_independent_solution() {
    for case in cases() {
        // One long step, and steps of 10 ms as importers take them.
        let steps = (case.columns["time"] / 0.01).round() as u32;
        for count in [1, steps] {
            let error = error(&case, count);
            println!("{}: {count} steps: {error:.2e}", case.name);
            assert!(error < 2e-7, "{}: {error:e} in {count} steps", case.name);
        }
    }
}

/// Checks that errors fall with an order when the steps become shorter, rate limits and end stops or not;
/// returns the number of cases, those from a speed on.
fn converges(steps: [f64; 3], least_speed: f64, order: std::ops::Range<f64>) -> usize {
    let mut seen = 0;
    for case in cases() {
        if case.columns["speed"] < least_speed {
            continue;
        }
        let counts = steps.map(|h| (case.columns["time"] / h).round() as u32);
        let errors = counts.map(|count| error(&case, count));
        println!("{}: {errors:?}", case.name);
        seen += 1;
        for i in 0..2 {
            // Below this the reference's own error shows.
            if errors[i + 1] > 1e-11 {
                let finer = f64::from(counts[i + 1]) / f64::from(counts[i]);
                let measured = (errors[i] / errors[i + 1]).ln() / finer.ln();
                println!("    order {measured:.2}");
                assert!(order.contains(&measured), "{}: {measured:.2}", case.name);
            }
        }
    }
    seen
}

/// A communication step below the longest panel is one panel, except where the actuator's motion changes.
#[test]
fn short_steps_converge_with_order_four() {
    assert_eq!(converges([0.002, 0.001, 0.0005], 5.0, 3.8..4.3), 16);
}

/// At lower speeds a step is cut into several panels.
#[test]
fn longer_steps_converge_with_order_six() {
    assert_eq!(converges([0.008, 0.007, 0.006], 10.0, 5.5..6.5), 15);
}
