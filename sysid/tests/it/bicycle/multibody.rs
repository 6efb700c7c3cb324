//! A vehicle that no one here wrote.

use super::{at_speed, evidence};
use crate::common::multibody;
use steerwright_models::BicycleParameters;
use steerwright_sysid::bicycle::{BicycleOptions, identify_bicycle};
use steerwright_sysid::{IdentifyOptions, validate};

#[test]
fn on_the_multi_body_vehicle_it_beats_the_data_sheet() {
    let log = multibody();
    let found = identify_bicycle(&log, &BicycleOptions::default()).unwrap();
    // examples/drives/multibody/vehicle.toml
    let sheet = BicycleParameters {
        mass: 1093.2952,
        yaw_inertia: 1791.5995,
        distance_front: 1.1561957,
        distance_rear: 1.4227171,
        cornering_stiffness_front: 129_696.69,
        cornering_stiffness_rear: 105_400.27,
        actuator_time_constant: 0.05,
        steering_ratio: 1.0,
        ..BicycleParameters::default()
    };
    let sheet = validate(&log, &IdentifyOptions::default(), &at_speed(&sheet, 15.0)).unwrap();
    let e = evidence(&found);
    println!("{} {} data sheet {}", e.estimation_fit, e.validation_fit, sheet.validation_fit);
    assert!(e.validation_fit > sheet.validation_fit + 0.5);
}
