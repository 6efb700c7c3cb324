//! The example of `vehicle.json` is the car whose parameters are compiled in.
#![allow(clippy::unwrap_used)]

use steerwright_formats::{Document, Vehicle};
use steerwright_loading::nonlinear_parameters;
use steerwright_models::NonlinearParameters;

#[test]
fn the_example_is_the_default() {
    let text = include_str!("../../../examples/drives/multibody/vehicle.json");
    let vehicle = Vehicle::from_json(text, "vehicle.json").unwrap();
    assert_eq!(nonlinear_parameters(&vehicle), NonlinearParameters::default());
}

/// Every number of the file arrives at its place.
#[test]
fn the_vehicle() {
    let vehicle = Vehicle {
        schema: Vehicle::SCHEMA.into(),
        name: "car".into(),
        body: steerwright_formats::Body {
            mass_kg: 1.0,
            yaw_inertia_kgm2: 2.0,
            distance_front_m: 3.0,
            distance_rear_m: 4.0,
            centre_of_gravity_height_m: 5.0,
            track_width_m: 6.0,
            roll_stiffness_front: 7.0,
            roll_time_constant_s: 8.0,
        },
        tyres: steerwright_formats::Tyres {
            cornering_stiffness_front_npr: 9.0,
            cornering_stiffness_rear_npr: 10.0,
            friction_coefficient: 11.0,
            shape_factor: 12.0,
            curvature_factor: 13.0,
            friction_load_sensitivity: 14.0,
            stiffness_load_sensitivity: 15.0,
        },
        actuator: steerwright_formats::SteeringActuator {
            steering_ratio: 16.0,
            time_constant_s: 17.0,
            delay_s: 18.0,
            road_wheel_rate_max_radps: 19.0,
            road_wheel_angle_max_rad: 20.0,
        },
        speed_mps: 21.0,
        evidence: None,
        quality: steerwright_formats::Quality::default(),
        provenance: None,
    };
    let expected = NonlinearParameters {
        mass: 1.0,
        yaw_inertia: 2.0,
        distance_front: 3.0,
        distance_rear: 4.0,
        centre_of_gravity_height: 5.0,
        track_width: 6.0,
        roll_stiffness_front: 7.0,
        roll_time_constant: 8.0,
        cornering_stiffness_front: 9.0,
        cornering_stiffness_rear: 10.0,
        friction_coefficient: 11.0,
        tyre_shape_factor: 12.0,
        tyre_curvature_factor: 13.0,
        friction_load_sensitivity: 14.0,
        stiffness_load_sensitivity: 15.0,
        steering_ratio: 16.0,
        actuator_time_constant: 17.0,
        actuator_delay: 18.0,
        road_wheel_rate_max: 19.0,
        road_wheel_angle_max: 20.0,
    };
    assert_eq!(nonlinear_parameters(&vehicle), expected);
}
