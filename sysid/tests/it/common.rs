//! The repository's recordings and a car of its own, for the tests.

use steerwright_drivelog::{DriveLog, LogOptions, read_log};
use steerwright_models::BicycleParameters;

/// A file of the repository's test data.
pub(crate) fn data(path: &str) -> Vec<u8> {
    let path = format!("{}/../tests/data/{path}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The multi-body drive, from the steering that was commanded.
pub(crate) fn multibody() -> DriveLog {
    let files = vec![("drive.csv".to_owned(), data("multibody/drive.csv"))];
    let options = LogOptions {
        input: Some("steering_command_rad".into()),
        output: Some("yaw_rate_radps".into()),
        speed: Some("speed_mps".into()),
        steering_ratio: Some(1.0),
        ..LogOptions::default()
    };
    read_log(&files, &options).unwrap()
}

/// A car of the size of CommonRoad's, understeering a little.
pub(crate) fn car() -> BicycleParameters {
    BicycleParameters {
        mass: 1093.0,
        yaw_inertia: 1650.0,
        distance_front: 1.2,
        distance_rear: 1.4,
        cornering_stiffness_front: 98_000.0,
        cornering_stiffness_rear: 105_000.0,
        actuator_time_constant: 0.06,
        steering_ratio: 1.0,
    }
}
