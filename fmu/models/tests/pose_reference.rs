//! The pose estimator against an independent filter, that of `data/pose_reference.py`.
#![allow(clippy::unwrap_used)]

use steerwright_formats::{Gnss, InitialUncertainty, SensorNoise};
use steerwright_models::quadrature::Pose;
use steerwright_models::{PoseEstimator, PoseInput, PoseParameters, Sideslip};

/// The drive of the script, whose latency is no multiple of its step.
fn estimator() -> PoseEstimator {
    let mut estimator = PoseEstimator::new(PoseParameters {
        gnss: Gnss {
            period_s: 0.0,
            latency_s: 0.07,
            antenna_x_m: 1.2,
            antenna_y_m: -0.4,
            std_m: 0.0,
        },
        sideslip: Sideslip { per_yaw_rate: 0.08, ..Sideslip::default() },
        noise: SensorNoise {
            yaw_rate_density: 2e-3,
            yaw_rate_bias_density: 1e-3,
            speed_density: 0.1,
            lateral_velocity_density: 0.08,
            sideslip_per_yaw_rate_density: 4e-3,
        },
        initial_pose: Pose { x: 3.0, y: -2.0, yaw: 0.5 },
        initial: InitialUncertainty {
            position_std_m: 0.8,
            yaw_std_rad: 0.15,
            yaw_rate_bias_std_radps: 0.03,
            sideslip_per_yaw_rate_std_s: 0.04,
        },
    })
    .unwrap();
    estimator.start().unwrap();
    estimator
}

#[test]
fn the_same_estimates_as_an_independent_filter() {
    let mut estimator = estimator();
    let mut before = 0.0;
    let (mut rows, mut largest) = (0, [0.0_f64; 2]);
    for line in include_str!("data/pose_reference.csv").lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        #[allow(clippy::cast_possible_truncation)] // a count below 100
        let gnss_fix_count = row[6] as i32;
        estimator.input = PoseInput {
            yaw_rate: row[1],
            speed: row[2],
            gnss_x: row[3],
            gnss_y: row[4],
            gnss_std: row[5],
            gnss_fix_count,
        };
        estimator.step(row[0] - before).unwrap();
        before = row[0];
        for (mean, expected) in estimator.mean().iter().zip(&row[7..12]) {
            largest[0] = largest[0].max((mean - expected).abs());
        }
        let covariance = estimator.covariance();
        let lower = (0..5).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for ((i, j), expected) in lower.zip(&row[12..]) {
            // Relative to the two deviations.
            let scale = (covariance[i][i] * covariance[j][j]).sqrt();
            largest[1] = largest[1].max((covariance[i][j] - expected).abs() / scale);
        }
        rows += 1;
    }
    println!("largest differences: mean {:.1e}, covariance {:.1e}", largest[0], largest[1]);
    assert_eq!(rows, 300);
    // What the covariance of an interval that is cut lacks, and the reference's nine digits.
    assert!(largest[0] < 1e-6, "{largest:?}");
    assert!(largest[1] < 1e-5, "{largest:?}");
}
