//! `estimator.json`: the example is read, and what cannot be is refused at its place.
#![allow(clippy::unwrap_used)]

use steerwright_formats::{Document, Error, Estimator};

const EXAMPLE: &str = include_str!("../../examples/drives/multibody/estimator.json");

#[test]
fn the_example_survives_a_round_trip() {
    let estimator = Estimator::from_json(EXAMPLE, "estimator.json").unwrap();
    assert_eq!(Estimator::from_json(&estimator.to_json(), "estimator.json").unwrap(), estimator);
}

#[test]
fn faults_are_named_by_their_place() {
    for (from, to, expected) in [
        ("\"latency_s\": 0.1", "\"latency_s\": -0.1", "gnss.latency_s"),
        ("\"latency_s\": 0.1", "\"latency_s\": 100", "gnss.latency_s"),
        ("\"latency_s\": 0.1", "\"latency_s\": 0.1, \"period_s\": -1", "gnss.period_s"),
        ("\"latency_s\": 0.1", "\"latency_s\": 0.1, \"std_m\": 1e999", "gnss.std_m"),
        ("\"latency_s\": 0.1", "\"latency\": 0.1", "gnss.latency"),
        ("\"speed_density\": 0.05", "\"speed_density\": -1", "noise.speed_density"),
        ("\"speed_density\": 0.05", "\"speed_density\": \"low\"", "noise.speed_density"),
        ("\"yaw_std_rad\": 0.1", "\"yaw_std_rad\": 5.7", "initial.yaw_std_rad"),
        ("\"speed_mps\": 15.0", "\"speed_mps\": -1", "speed_mps"),
        ("\"speed_mps\": 15.0", "\"speed_mps\": 1e999", "speed_mps"),
    ] {
        assert!(EXAMPLE.contains(from), "{from}");
        match Estimator::from_json(&EXAMPLE.replacen(from, to, 1), "e.json").unwrap_err() {
            Error::Syntax { path, .. } | Error::Value { path, .. } => {
                assert_eq!(path, expected, "{from} -> {to}");
            }
            Error::Schema { found, .. } => assert_eq!(found, expected),
            other => panic!("{other}"),
        }
    }
    let newer = EXAMPLE.replacen("estimator/1", "estimator/2", 1);
    assert!(matches!(Estimator::from_json(&newer, "e.json"), Err(Error::Schema { .. })));
}
