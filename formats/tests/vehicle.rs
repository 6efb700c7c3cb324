//! `vehicle.json`: the example is read, and what cannot be is refused at its place.
#![allow(clippy::unwrap_used)]

use steerwright_formats::{Bicycle, Document, Error, Vehicle};

const EXAMPLE: &str = include_str!("../../examples/drives/multibody/vehicle.json");

#[test]
fn the_example_survives_a_round_trip() {
    let vehicle = Vehicle::from_json(EXAMPLE, "vehicle.json").unwrap();
    assert_eq!(Vehicle::from_json(&vehicle.to_json(), "vehicle.json").unwrap(), vehicle);
}

#[test]
fn faults_are_named_by_their_place() {
    for (from, to, expected) in [
        ("\"mass_kg\": 1093.2952", "\"mass_kg\": 0", "body.mass_kg"),
        ("\"mass_kg\": 1093.2952", "\"mass\": 1093.2952", "body.mass"),
        ("\"shape_factor\": 1.3507", "\"shape_factor\": 2", "tyres.shape_factor"),
        ("\"curvature_factor\": -0.0074722", "\"curvature_factor\": 1.5", "tyres.curvature_factor"),
        (
            "\"friction_coefficient\": 1.0489",
            "\"friction_coefficient\": -1",
            "tyres.friction_coefficient",
        ),
        (
            "\"roll_stiffness_front\": 0.515",
            "\"roll_stiffness_front\": 51.5",
            "body.roll_stiffness_front",
        ),
        ("\"delay_s\": 0.0", "\"delay_s\": -0.1", "actuator.delay_s"),
        ("\"delay_s\": 0.0", "\"delay_s\": \"none\"", "actuator.delay_s"),
        ("\"speed_mps\": 15.0", "\"speed_mps\": 1e999", "speed_mps"),
    ] {
        assert!(EXAMPLE.contains(from), "{from}");
        match Vehicle::from_json(&EXAMPLE.replacen(from, to, 1), "v.json").unwrap_err() {
            Error::Syntax { path, .. } | Error::Value { path, .. } => {
                assert_eq!(path, expected, "{from} -> {to}");
            }
            Error::Schema { found, .. } => assert_eq!(found, expected),
            other => panic!("{other}"),
        }
    }
    let newer = EXAMPLE.replacen("vehicle/1", "vehicle/2", 1);
    assert!(matches!(Vehicle::from_json(&newer, "v.json"), Err(Error::Schema { .. })));
}

/// The numbers of a bicycle stand next to its name and speed in one struct: a struct of their own that serde flattens
/// would lose both.
#[test]
fn a_fault_in_the_data_of_a_vehicle_has_its_key_and_line() {
    let vehicle = Vehicle::from_json(EXAMPLE, "vehicle.json").unwrap();
    let text = Bicycle::new(vehicle.in_gentle_driving()).to_json();
    let from = "\"mass_kg\": 1093.2952";
    let at = text.lines().position(|line| line.contains(from)).unwrap() + 1;
    for (to, key) in
        [("\"mass_kg\": \"heavy\"", "vehicle.mass_kg"), ("\"mass\": 1093.2952", "vehicle.mass")]
    {
        match Bicycle::from_json(&text.replacen(from, to, 1), "b.json").unwrap_err() {
            Error::Syntax { path, line, .. } => assert_eq!((path.as_str(), line), (key, at)),
            other => panic!("{other}"),
        }
    }
}

#[test]
fn eq_13_of_another_vehicle_is_refused_and_rounded_numbers_are_not() {
    let vehicle = Vehicle::from_json(EXAMPLE, "vehicle.json").unwrap();
    let bicycle = Bicycle::new(vehicle.in_gentle_driving());
    let fault = |bicycle: &Bicycle| match bicycle.checked("bicycle.json") {
        Err(Error::Value { path, problem, .. }) => {
            assert!(problem.contains("by eq 13 of `vehicle`"), "{problem}");
            path
        }
        other => panic!("{other:?}"),
    };
    let mut heavier = bicycle.clone();
    heavier.vehicle.mass_kg *= 1.01;
    assert_eq!(fault(&heavier), "coefficients.A1");
    let mut faster = bicycle.clone();
    faster.vehicle.speed_mps *= 1.01;
    assert_eq!(fault(&faster), "state_matrix[1][1]");
    let mut slower = bicycle.clone();
    slower.input_matrix.0[4][0] *= 1.01;
    assert_eq!(fault(&slower), "input_matrix[4][0]");
    let mut rounded = bicycle;
    for row in &mut rounded.state_matrix.0 {
        for value in row {
            *value = format!("{value:.3e}").parse().unwrap();
        }
    }
    rounded.checked("bicycle.json").unwrap();
}
