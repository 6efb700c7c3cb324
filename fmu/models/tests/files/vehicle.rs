//! The example of `vehicle.json` is the car whose parameters are compiled in.
#![allow(clippy::unwrap_used)]

use steerwright_formats::{Document, Vehicle};
use steerwright_models::NonlinearParameters;
use steerwright_models::files::nonlinear_parameters;

#[test]
fn the_example_is_the_default() {
    let text = include_str!("../../../../examples/drives/multibody/vehicle.json");
    let vehicle = Vehicle::from_json(text, "vehicle.json").unwrap();
    assert_eq!(nonlinear_parameters(&vehicle), NonlinearParameters::default());
}
