//! The repository's recordings and a car of its own, for the tests.

use faer::Mat;
use steerwright_drivelog::{DriveLog, LogOptions, Segment, read_log};
use steerwright_models::BicycleParameters;

/// A file of the repository's test data.
pub(crate) fn data(path: &str) -> Vec<u8> {
    let path = format!("{}/../examples/drives/{path}", env!("CARGO_MANIFEST_DIR"));
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

/// A recording made in memory: one segment, a steering ratio of 1 and no speed.
pub(crate) fn recording(sample_time_s: f64, input: Vec<f64>, output: Vec<f64>) -> DriveLog {
    DriveLog {
        name: "made".into(),
        sample_time_s,
        segments: vec![Segment { time0_s: 0.0, range: 0..input.len() }],
        input,
        output,
        speed: None,
        steering_ratio: 1.0,
        vehicle_class: None,
        response: Default::default(),
        others: Default::default(),
        gnss: None,
        channels: Vec::new(),
        warnings: Vec::new(),
        sources: Vec::new(),
        options: std::collections::BTreeMap::new(),
    }
}

/// F and G of a bicycle at 20 m/s with a steering servo, which an angle moves by `servo`, 1/s. The
/// yaw rate is the second state.
pub(crate) fn vehicle(servo: f64) -> (Mat<f64>, Mat<f64>) {
    let f = [[-6.0, -18.0, 80.0], [0.9, -7.0, 55.0], [0.0, 0.0, -12.0]];
    (
        Mat::from_fn(3, 3, |i, j| f[i][j]),
        Mat::from_fn(3, 1, |i, _| if i == 2 { servo } else { 0.0 }),
    )
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
        ..BicycleParameters::default()
    }
}
