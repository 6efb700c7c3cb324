//! Every number of `estimator.json` arrives at its place.
#![allow(clippy::unwrap_used)]

use steerwright_formats::{Document, Estimator, Gnss, InitialUncertainty, SensorNoise};
use steerwright_models::PoseParameters;
use steerwright_models::files::pose_parameters;
use steerwright_models::quadrature::Pose;

/// Everything but the latency is the estimator that is compiled in, which knows of none.
#[test]
fn the_example_is_the_default() {
    let text = include_str!("../../../../examples/drives/multibody/estimator.json");
    let estimator = Estimator::from_json(text, "estimator.json").unwrap();
    let mut expected = PoseParameters {
        gnss: Gnss { latency_s: 0.1, ..PoseParameters::default().gnss },
        ..PoseParameters::default()
    };
    expected.sideslip.reference_speed = estimator.speed_mps;
    assert_eq!(pose_parameters(&estimator), expected);
}

#[test]
fn the_estimator() {
    let estimator = Estimator {
        schema: Estimator::SCHEMA.into(),
        name: "sensors".into(),
        gnss: Gnss {
            latency_s: 1.0,
            antenna_x_m: 2.0,
            antenna_y_m: 3.0,
            std_m: 10.0,
            period_s: 11.0,
        },
        sideslip_per_yaw_rate_s: 4.0,
        sideslip_growth_s5pm2: 0.125,
        sideslip_per_yaw_acceleration_s2: 0.0625,
        distance_rear_m: 1.5,
        noise: SensorNoise {
            yaw_rate_density: 5.0,
            yaw_rate_bias_density: 6.0,
            speed_density: 7.0,
            lateral_velocity_density: 8.0,
            sideslip_per_yaw_rate_density: 0.75,
        },
        initial: InitialUncertainty {
            position_std_m: 9.0,
            yaw_std_rad: 0.5,
            yaw_rate_bias_std_radps: 0.25,
            sideslip_per_yaw_rate_std_s: 0.375,
        },
        speed_mps: 12.0,
    };
    let expected = PoseParameters {
        gnss: Gnss {
            latency_s: 1.0,
            period_s: 11.0,
            antenna_x_m: 2.0,
            antenna_y_m: 3.0,
            std_m: 10.0,
        },
        sideslip: steerwright_models::Sideslip {
            per_yaw_rate: 4.0,
            growth: 0.125,
            per_yaw_acceleration: 0.0625,
            reference_speed: 12.0,
            distance_rear: 1.5,
        },
        noise: SensorNoise {
            yaw_rate_density: 5.0,
            yaw_rate_bias_density: 6.0,
            speed_density: 7.0,
            lateral_velocity_density: 8.0,
            sideslip_per_yaw_rate_density: 0.75,
        },
        initial_pose: Pose { x: 0.0, y: 0.0, yaw: 0.0 },
        initial: InitialUncertainty {
            position_std_m: 9.0,
            yaw_std_rad: 0.5,
            yaw_rate_bias_std_radps: 0.25,
            sideslip_per_yaw_rate_std_s: 0.375,
        },
    };
    assert_eq!(pose_parameters(&estimator), expected);
}
