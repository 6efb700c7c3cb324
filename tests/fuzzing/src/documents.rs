//! The documents that inputs are made from: a small one of each file.

/// `plant.json`, no delay.
pub(crate) const PLANT: &[u8] = include_bytes!("../documents/plant.json");
/// `plant.json`, its input delayed by no multiple of the sample time.
pub(crate) const DELAYED: &[u8] = include_bytes!("../documents/plant-delayed.json");
/// `bicycle.json`.
pub(crate) const BICYCLE: &[u8] = include_bytes!("../documents/bicycle.json");
/// `vehicle.json`, with a delay.
pub(crate) const VEHICLE: &[u8] = include_bytes!("../documents/vehicle.json");
/// `estimator.json`, with a latency.
pub(crate) const ESTIMATOR: &[u8] = include_bytes!("../documents/estimator.json");
/// `pid.json`.
pub(crate) const PID: &[u8] = include_bytes!("../documents/pid.json");
/// `path.json`.
pub(crate) const PATH: &[u8] = include_bytes!("../documents/path.json");
/// `longitudinal.json`.
pub(crate) const LONGITUDINAL: &[u8] =
    include_bytes!("../../../examples/drives/multibody/longitudinal.json");
